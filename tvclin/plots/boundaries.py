"""The boundary limit against the duration of the wind: figures 2, 5, 10 and 11, and of a study."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.nominal_flight import load_flight_condition
from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.boundary.closed_forms import (
    rectangular_limit,
    triangular_limit,
    triangular_limit_with_drift,
)
from tvclin.linear.plant import Plant
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import (
    COLOURS,
    INK,
    LINES,
    MARKS,
    WARM,
    Look,
    Style,
    broken_lines,
    called,
    control_plot,
    cycle,
    draw,
    fine_grid,
    literal,
    new_axes,
)
from tvclin.requirement.nominal_requirement import required_deflection
from tvclin.requirement.study import Study
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.vehicle.vehicle_file import load_vehicle
from tvclin.winds.histories import History
from tvclin.winds.pulses import TriangularWind
from tvclin.winds.wind_angles import BEYOND_LINEAR, FROZEN

if TYPE_CHECKING:
    from control import ControlPlot
    from matplotlib.axes import Axes


DEAD_BANDS = (1.0, 0.75, 0.5, 0.25, 0.0)
CONFIGURATIONS = ("configuration-i", "configuration-ii")

ABSCISSA = "wind duration tau*{} [-]"
ORDINATE = r"boundary limit  $y_{BR} = -\delta_{max}/(B\,\alpha_{w,max})$ [-]"
_DURATIONS = errors.between(1e-6, 1e6)
"""Check of the durations tau beta of an abscissa."""
_FIXED, _DRIFT = "without drift: eqs (7), (12)", "with drift: eqs (16), (18)"
_POINTS, _FLOWN_POINTS = 60, 40
"""Durations of the wind; with a gust, where the trim law is flown for each."""
CURVES_SECONDS = 1.0
"""Time of the curves of `study_chart` in plain Python [s], at least."""


def boundary_chart(
    tau_beta: ArrayLike | None = None,
    dead_bands: Sequence[float] = DEAD_BANDS,
    coefficients: Coefficients | None = None,
) -> ControlPlot:
    """Draw the boundary limit against tau beta for rectangular and triangular winds.

    Parameters
    ----------
    tau_beta : array_like, optional
        Abscissas, ``(n,)``, positive; 0.05 to 20 where not given: duration tau [s] of the wind
        times beta [1/s], the unstable pole on a fixed path. With damping tau times the pole.
    dead_bands : sequence of float
        K of the curves for triangular winds.
    coefficients : Coefficients, optional
        Of one vehicle; the boundaries with drift, eqs (16) and (18) of the report, are then drawn
        instead of eqs (7) and (12).
    """
    if coefficients is not None:
        errors.instance("coefficients", coefficients, Coefficients, "see Coefficients.from_vehicle")
        errors.single("coefficients", coefficients.batch)
    what = _FIXED if coefficients is None else _DRIFT
    name = "" if coefficients is None else coefficients.name
    title = called(name, f"Stability boundary {what}")
    return _draw_boundaries("boundary", title, tau_beta, dead_bands, coefficients)


def figure_2(
    tau_beta: ArrayLike | None = None, dead_bands: Sequence[float] = DEAD_BANDS
) -> ControlPlot:
    """Draw the report's figure 2: the boundary without drift, eqs (7) and (12).

    Parameters
    ----------
    tau_beta, dead_bands
        Abscissas, durations tau of the wind times the unstable pole beta, ``(n,)``, 0.05 to 20
        where not given; K of the triangular winds.
    """
    title = f"Figure 2. Stability boundary {_FIXED}"
    return _draw_boundaries("figure-2", title, tau_beta, dead_bands, coefficients=None)


def figure_5(
    tau_beta: ArrayLike | None = None,
    dead_bands: Sequence[float] = (1.0, 0.5),
    vehicles: Sequence[Vehicle | str] = CONFIGURATIONS,
) -> ControlPlot:
    """Draw the report's figure 5: triangular winds without drift, eq (12), and with it, eq (18).

    Parameters
    ----------
    tau_beta : array_like, optional
        Abscissas, durations tau of the wind times the unstable pole, beta without damping,
        ``(n,)``, 0.05 to 20 where not given.
    dead_bands : sequence of float
        K, one for each panel, of which at most ten are drawn.
    vehicles : sequence of Vehicle or str
        Vehicles, or what `load_vehicle` finds them by; one curve each, from the pole and from the
        zeros b1 and b2 [1/s] from deflection and from wind to attitude.
    """
    x = _abscissas(tau_beta)
    dead_bands = _fractions(dead_bands)
    if not isinstance(vehicles, tuple | list):
        raise errors.InputError(
            f"vehicles must be a tuple of vehicles or names; got {errors.shown(vehicles)}"
        )
    loaded = [v if isinstance(v, Vehicle) else load_vehicle(v) for v in vehicles]
    for vehicle in loaded:
        errors.single("vehicle", vehicle.batch)
    symbols = [Coefficients.from_vehicle(vehicle).pole_symbol for vehicle in loaded]
    columns = []
    for letter, K in zip("abcdefghij", dead_bands, strict=False):
        panel = f"({letter}) K = {K:g}"
        columns.append(Column("without drift, eq (12)", triangular_limit(x, K), panel=panel))
        for number, vehicle in enumerate(loaded, 1):
            c = Coefficients.from_vehicle(vehicle)
            y = triangular_limit_with_drift(x, K, c.pole, c.b1, c.b2)
            label = f"{_short(vehicle, number)}, eq (18)"
            columns.append(Column(label, y, panel=panel))
    names = ", ".join(_short(vehicle, number) for number, vehicle in enumerate(loaded, 1))
    # the pole is p instead of beta with damping
    abscissa = ABSCISSA.format(next((s for s in symbols if s != "beta"), "beta"))
    curves = Curves("figure-5", f"triangular wind, y_BR; {names}", abscissa, x, tuple(columns))
    labels = list(dict.fromkeys(column.label for column in columns))
    styles: dict[str, Any] = {labels[0]: {"color": INK, "ls": "-", "lw": 2.0}}
    broken = zip(labels[1:], cycle(COLOURS[::3]), cycle(LINES[1::3]), strict=False)
    styles |= {label: {"color": c, "ls": line, "lw": 2.0} for label, c, line in broken}
    look = Look(
        title="Figure 5. Stability boundary in triangular winds: eqs (12) and (18)",
        ordinate=ORDINATE,
        styles=styles,
        limits=dict.fromkeys(curves.panels, (0.0, 1.02)),
    )
    plot = draw(curves, look)
    for axes in plot.axes.flat:
        _mark_durations(axes, x)
    return plot


def study_chart(study: Study, durations: ArrayLike | None = None) -> ControlPlot:
    """Draw the required deflection against the duration of the wind, for one study.

    Solid lines are the first model of the study's boundaries, broken ones the second; marks tell
    the dead bands apart. The wind and the limit of the study are shown.

    Parameters
    ----------
    study : Study
        The study; its peak, shape and vehicle are kept.
    durations : array_like, optional
        Abscissas [s], positive; up to three times the study's duration where not given.
    """
    errors.instance("study", study, Study, "see Study.from_vehicle")
    chosen = float(study.wind.duration)
    points = _POINTS if study.gust is None else _FLOWN_POINTS  # with a gust each one is flown
    x = (
        np.linspace(0.02, 3.0, points) * chosen
        if durations is None
        else errors.one_row("durations", errors.positive("durations", durations))
    )
    curves = _study_curves(study, x)
    axes = new_axes()
    lines: list[Any] = []
    curves_per_model = len(curves.columns) // len(study.boundaries)  # one for each dead band
    for index, column in enumerate(curves.columns):
        model, row = divmod(index, curves_per_model)
        look: Style = {"color": cycle(COLOURS)[row], "marker": cycle(MARKS)[row], "ms": 4.5}
        look |= {"ls": ("-", "--")[model], "markevery": max(x.size // 10, 1)}
        lines += axes.plot(x, column.values, lw=1.6, label=column.label, **look)
    axes.axvline(chosen, color=INK, lw=1.0)
    sign = study.direction
    needs = "required, both planes" if study.judges_both_planes else "required"
    needs += "" if sign == FROZEN else f", {sign} wind"  # frozen: at nominal dynamic pressure
    axes.plot(chosen, np.degrees(study.required_deflection), "o", color=INK, label=needs)
    trim = float(np.degrees(study.trim_deflection))
    axes.axhline(trim, color="0.4", lw=1.0, ls=":", label="trim, no drift")
    if study.limit is not None:
        limit = float(np.degrees(study.limit))
        axes.axhline(limit, color=WARM, lw=1.6, label="available limit")
    axes.set(
        title=literal(curves.parameters),
        xlabel="wind duration [s]",
        ylabel="deflection [deg]",
        xlim=(0.0, float(x.max())),
        ylim=(0.0, None),
    )
    fine_grid(axes)
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0))
    return control_plot(lines, axes, curves)


def _study_curves(study: Study, durations: FloatArray) -> Curves:
    """Return the boundary [deg] over durations [s] for the models and dead bands of a study.

    The columns are in the order of the models, for each its dead bands K, falling: 1, 0.5,
    0 and the study's.
    """
    wind = study.wind_in_plane.history({"wind_duration": durations[:, np.newaxis]})
    shown = np.array(sorted({1.0, 0.5, 0.0, study.dead_band}, reverse=True))
    columns = []
    for model in study.boundaries:
        requirement = required_deflection(Plant(study.coefficients, model), wind, shown)
        sizes = np.abs(np.degrees(requirement.deflection)).T  # dead bands, durations
        columns += [
            Column(f"K = {K:g}, {model}", y, "deg") for K, y in zip(shown, sizes, strict=True)
        ]
    shape = type(study.wind).__name__.removesuffix("Wind").lower()
    peak = float(np.degrees(study.wind.peak))
    gust = "" if study.gust is None else f", gust of {np.degrees(study.gust.peak):.3g} deg"
    words = f"{shape} winds of {peak:.3g} deg{gust}"
    words = f"{study.vehicle.name}: {words}" if study.vehicle.name else words
    words = f"{words}; {BEYOND_LINEAR}" if study.beyond_linear else words
    return Curves("study", words, "wind duration [s]", durations, tuple(columns))


def _draw_boundaries(
    name: str,
    title: str,
    tau_beta: ArrayLike | None,
    dead_bands: Sequence[float],
    coefficients: Coefficients | None,
) -> ControlPlot:
    """Return the figure of the boundary over tau*beta in rectangular and triangular winds.

    `name`: name of its numbers. `title`: title. `tau_beta`: abscissas, durations of the wind times
    the unstable pole; None for the usual ones. `dead_bands`: K, a curve each. `coefficients`: of a
    vehicle with drift; None on a fixed path. K1 is the report's fraction of the wind that counts
    with drift, eq (15b); -b1 and -b2 [1/s] are the zeros from deflection and from wind to attitude.
    """
    x, c = _abscissas(tau_beta), coefficients
    dead_bands = _fractions(dead_bands)
    columns = [Column("rectangular", rectangular_limit(x, 1.0 if c is None else c.K1))]
    for K in dead_bands:
        if c is None:
            y = triangular_limit(x, K)
        else:
            y = triangular_limit_with_drift(x, K, c.pole, c.b1, c.b2)
        columns.append(Column(f"triangular, K = {K:g}", y))
    styles: dict[str, Any] = broken_lines([column.label for column in columns[1:]])
    styles["rectangular"] = {"color": INK, "ls": "-", "lw": 2.0}
    what = f"y_BR {_FIXED if c is None else _DRIFT}"
    if c is not None:
        what += f"; {drift_words(c)}"
    symbol = "beta" if c is None else c.pole_symbol
    curves = Curves(name, what, ABSCISSA.format(symbol), x, tuple(columns))
    plot = draw(
        curves, Look(title, ORDINATE, styles, "wind and dead band", limits={"": (0.0, 1.02)})
    )
    axes = plot.axes[0, 0]
    axes.set_yticks(np.arange(0, 1.01, 0.1))
    _mark_durations(axes, x)
    return plot


def drift_words(c: Coefficients) -> str:
    """Return the numbers of a vehicle in eq (18) of the report, as text; `c`: its coefficients.

    They are the unstable pole, and b1 and b2, zeros from deflection and from wind to attitude.
    """
    return f"{c.pole_symbol} = {c.pole:.6g} 1/s, b1 = {c.b1:.6g} 1/s, b2 = {c.b2:.6g} 1/s"


def _mark_durations(axes: Axes, tau_beta: FloatArray) -> None:
    """Set limits and ticks of the abscissa of axes; `tau_beta`: the abscissas, ``(n,)``."""
    axes.set_xlim(0.0, float(tau_beta.max()))
    axes.locator_params(axis="x", nbins=11, steps=[1, 2, 4, 5, 10])


def _abscissas(tau_beta: ArrayLike | None) -> FloatArray:
    """Return the abscissas tau*beta; `InputError` unless they are a positive row."""
    abscissas = np.linspace(0.05, 20.0, 400) if tau_beta is None else tau_beta
    return errors.one_row("tau_beta", np.atleast_1d(_DURATIONS("tau_beta", abscissas)))


def _fractions(dead_bands: Sequence[float]) -> list[float]:
    """Return dead bands K as a list; `InputError` for what is no row of numbers from 0 to 1."""
    fractions = errors.within("dead_bands", dead_bands, 0.0, 1.0)
    return errors.one_row("dead_bands", np.atleast_1d(fractions)).tolist()


def _short(vehicle: Vehicle, number: int) -> str:
    """Return the name of a vehicle without its parentheses, or else "vehicle" and a `number`."""
    return vehicle.name.partition(" (")[0] or f"vehicle {number}"


Flights = Callable[[History, float, float, FloatArray], FloatArray]
"""Function from a wind, a deflection limit [rad], a dead band and times [s], ``(n,)``, to the
attitude [rad] of the flight, ``(n,)``; NaN after its end."""

PEAK = float(np.radians(1.0))
"""Peak of the winds of the flights [rad], tail winds. The report does not give it."""


def chosen_engine(engine: str | None) -> str:
    """Return the name of an engine; the default is JSBSim if it is installed, else "planar".

    `InputError` for an unknown name.
    """
    if engine is None:
        return "sixdof" if find_spec("jsbsim") else "planar"
    from tvclin.flights.flown_boundary import ENGINES  # late: for the flown figures alone

    return errors.one_of("engine", engine, ENGINES)


def flown_attitudes(vehicle: Vehicle, engine: str) -> Flights:
    """Return the function of the attitudes [rad] of a vehicle under the report's control.

    `engine`: name of the engine that flies it, one of `ENGINES`. The function takes a wind, a limit
    [rad], a dead band and times [s] ``(n,)``, and returns attitudes ``(n,)``.
    """
    from tvclin.flights.engine_interface import OUTPUTS, ReportControl  # late, with the engines
    from tvclin.flights.flown_boundary import ENGINES

    fly = ENGINES[engine].outputs

    def attitude(wind: History, limit: float, dead_band: float, times: FloatArray) -> FloatArray:
        """Return attitudes [rad] at times [s] ``(n,)`` in a wind; `limit` in rad."""
        control = ReportControl(dead_band)
        with warnings.catch_warnings():  # that a flight below the boundary ends is what is shown
            warnings.filterwarnings("ignore", "the flight ends", UserWarning)
            _, outputs = fly(vehicle, control, wind, times, deflection_limit=limit)
        return np.asarray(outputs[OUTPUTS.index("attitude")])

    return attitude


@cache
def flown_limit(
    name: str,
    tau_beta: float,
    dead_band: float,
    *,
    plane: str = "pitch",
    peak: float = PEAK,
    engine: str = "planar",
    along: bool = False,
    tolerance: float = 2.5e-3,
) -> float:
    """Return the boundary limit over trim of the report's control in a triangular wind, by flying.

    Trim is the deflection that holds the peak of the wind. `name`: name of the vehicle.
    `tau_beta`, `dead_band`: duration of the wind times the unstable pole, and K. `plane`: of the
    wind, "pitch" or "yaw". `peak`: its peak [rad], at the vehicle's own time. `engine`: simulation
    that flies, "planar" (equations of one plane) or "sixdof" (JSBSim). `along`: whether mass,
    forces and speed vary along the trajectory, or are frozen. `tolerance`: of the result.
    """
    from tvclin.flights.flown_boundary import flown_boundary  # late, with the engines

    vehicle = load_vehicle(name)
    options: dict[str, Any] = {}
    if along:
        options = {"frozen": False, "condition": load_flight_condition(name)}
    wind = centred_wind(vehicle, peak, tau_beta)
    return flown_boundary(
        vehicle, wind, dead_band, engine=engine, plane=plane, tolerance=tolerance, **options
    ).limit


def centred_wind(vehicle: Vehicle, peak: float, tau_beta: float) -> History:
    """Return the triangular wind of a given tau p that has its peak at the vehicle's time.

    `peak`: its peak [rad]. `tau_beta`: tau p, its duration times the unstable pole p [1/s]. The
    peak of a vehicle without a flight time is at zero.
    """
    wind = TriangularWind(peak=peak, duration=tau_beta / Coefficients.from_vehicle(vehicle).pole)
    peak_time = 0.0 if vehicle.time is None else float(np.asarray(vehicle.time))
    return wind.shift(peak_time - wind.duration / 2.0)


TAU_BETA = (1.0, 2.0, 4.0, 8.0, 14.0, 20.0)
ALONG = {
    "along the trajectory, tail wind": ("pitch", PEAK),
    "along the trajectory, head wind": ("pitch", -PEAK),
    "along the trajectory, yaw": ("yaw", PEAK),
}
"""Plane and peak [rad] of the winds that are flown with varying parameters."""
_EQUATION_12, _EQUATION_18 = "without drift, eq (12)", "with drift, eq (18)"
_CURVES = np.linspace(0.05, 20.0, 400)
"""Durations tau beta at which the equations are drawn."""


def figure_10(
    vehicle: str = "configuration-i",
    dead_bands: Sequence[float] = (1.0, 0.5),
    *,
    tau_beta: ArrayLike = TAU_BETA,
    along: ArrayLike = 4.0,
    engine: str | None = None,
) -> ControlPlot:
    """Draw the report's figure 10: the boundary of configuration I, theoretical and flown.

    Parameters
    ----------
    vehicle : str
        What `load_vehicle` and `load_flight_condition` find a vehicle by.
    dead_bands : sequence of float
        K, one for each panel.
    tau_beta : array_like
        Durations, times the unstable pole, of the winds that are flown with frozen parameters,
        ``(n,)``, positive.
    along : array_like
        Durations, times the pole, of those that are flown along the trajectory, ``(m,)``, and in
        any case also by planar flights with frozen parameters. Their peak is at the vehicle's time.
    engine : {"sixdof", "planar"}, optional
        What flies with frozen parameters; JSBSim where it is installed, else "planar".

    Raises
    ------
    InputError
        For durations that are not positive, an unknown engine, and as `load_flight_condition`.

    Notes
    -----
    The points of the report are not printed as numbers. All winds here are of 1 degree, which is
    assumed. Along the trajectory planar equations are flown, and what the report does not give is
    assumed too.
    """
    return _figure(10, vehicle, dead_bands, tau_beta=tau_beta, along=along, engine=engine)


def figure_11(
    vehicle: str = "configuration-ii", dead_bands: Sequence[float] = (1.0, 0.5), **options: Any
) -> ControlPlot:
    """Draw the report's figure 11: the boundary of configuration II, theoretical and flown.

    Same parameters and exceptions as `figure_10`.
    """
    return _figure(11, vehicle, dead_bands, **options)


def _figure(
    number: int,
    name: str,
    dead_bands: Sequence[float],
    *,
    tau_beta: ArrayLike = TAU_BETA,
    along: ArrayLike = 4.0,
    engine: str | None = None,
) -> ControlPlot:
    """Return figure 10 or 11 of the report: boundary limits over the duration, by dead band.

    Limits are y_BR, over static trim; durations tau beta, times the unstable pole. `number`: 10 or
    11. `name`: name of the vehicle. `dead_bands`: K, a panel each. `tau_beta`, `along`: durations
    that are flown with a frozen vehicle, and with one whose parameters vary along its trajectory.
    `engine`: name of the engine of these flights, None for the usual one.
    """
    from tvclin.flights.flown_boundary import ENGINES  # late: for the flown figures alone

    engine = chosen_engine(engine)
    errors.instance("vehicle", name, str, "what load_vehicle finds it by")
    fractions = _fractions(dead_bands)
    trajectory = np.atleast_1d(errors.positive("along", along))
    # of flights with a frozen vehicle, and of those along the flight, of which there may be none
    durations = [_abscissas(tau_beta)]
    durations.append(errors.one_row("along", trajectory) if trajectory.size else trajectory.ravel())
    x = np.unique(np.concatenate([_CURVES, *durations]))
    vehicle = load_vehicle(name)
    # labels by engine: the chosen one, and planar flights for comparison
    flown = {key: f"flown, {ENGINES[key].words}" for key in dict.fromkeys([engine, "planar"])}
    columns = [
        column
        for letter, K in zip("abcdefghij", fractions, strict=False)  # ten panels at most
        for column in _panel(f"({letter}) K = {K:g}", name, K, x, durations, flown)
    ]
    c = Coefficients.from_vehicle(vehicle)
    what = f"triangular wind of 1 deg, y_BR; {drift_words(c)}; flown within 0.0015"
    curves = Curves(f"figure-{number}", what, ABSCISSA.format(c.pole_symbol), x, tuple(columns))
    look = Look(
        title=f"Figure {number}. Stability boundary, theoretical and flown\n{vehicle.name or name};"
        " winds of 1 deg, parameters frozen unless flown along the trajectory",
        ordinate=ORDINATE,
        styles=_styles(flown.values()),
        limits=dict.fromkeys(curves.panels, (0.0, 1.02)),
    )
    plot = draw(curves, look)
    for axes in plot.axes.flat:
        axes.set_xlim(0.0, 1.03 * float(x.max()))
    return plot


def _panel(
    panel: str,
    name: str,
    K: float,
    x: FloatArray,
    durations: Sequence[FloatArray],
    flown: Mapping[str, str],
) -> list[Column]:
    """Return the curves of boundary limits y_BR for one dead band, by equations and by flights.

    `panel`: heading. `name`: name of the vehicle. `K`: the dead band. `x`: durations tau beta of
    the curves, ``(n,)``. `durations`: two arrays, flown with a frozen vehicle and with one whose
    parameters vary along its trajectory, all among `x`; flights are NaN at others. `flown`: label
    of the flights of each engine with a frozen vehicle: the first at the first durations, planar
    flights for comparison at the second ones.
    """
    c = Coefficients.from_vehicle(load_vehicle(name))
    limits_of = {
        _EQUATION_12: np.asarray(triangular_limit(x, K)),
        _EQUATION_18: np.asarray(triangular_limit_with_drift(x, K, c.pole, c.b1, c.b2)),
    }
    frozen, along = durations
    flights: list[tuple[str, FloatArray, dict[str, Any]]] = [
        (label, along if k else frozen, {"engine": engine})
        for k, (engine, label) in enumerate(flown.items())
    ]
    flights += [
        (label, along, {"plane": plane, "peak": peak, "along": True})
        for label, (plane, peak) in ALONG.items()
    ]
    for label, flown_at, options in flights:
        limits_of[label] = np.full(x.shape, np.nan)
        limits_of[label][np.searchsorted(x, flown_at)] = [
            flown_limit(name, tau_beta, K, **options) for tau_beta in flown_at.tolist()
        ]
    return [Column(label, values, panel=panel) for label, values in limits_of.items()]


def _styles(flown: Iterable[str]) -> dict[str, Style]:
    """Return the line styles of theory and of flights by label.

    `flown`: labels of the flights with a frozen vehicle. Equations are lines; flights are marks
    alone, last those along the trajectory (`ALONG`), with varying parameters.
    """
    styles: dict[str, Style] = {
        _EQUATION_12: {"color": "0.45", "ls": LINES[1], "lw": 1.6},
        _EQUATION_18: {"color": INK, "ls": "-", "lw": 2.0},
    }
    points: list[tuple[str, Any, str, float]] = [
        *zip(flown, COLOURS[::4], "ox", (8.0, 6.0), strict=False),
        *zip(ALONG, (WARM, WARM, COLOURS[1]), "^vD", (7.0, 7.0, 6.0), strict=True),
    ]
    for label, colour, mark, size in points:
        style = {"color": colour, "ls": "", "marker": mark, "ms": size, "mfc": "none", "mew": 1.5}
        styles[label] = style
    return styles
