"""Trade-off curves: deflection over rate, load or disk margin, laws over duration, both planes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.lines import plural
from tvclin.base.quantities import NO_FORECAST, WIND_KNOWN
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.limit_over_load import LoadTradeOff
from tvclin.boundary.limit_over_rate import RateTradeOff
from tvclin.boundary.limit_shapes import LimitShape, limit_shape_of
from tvclin.boundary.optimum.minimum_peak import optimum_deflection
from tvclin.boundary.plane_bounds import PlanePair, checked_batch
from tvclin.boundary.plane_limits import plane_limit
from tvclin.case.load import FlownLoad
from tvclin.control.laws.law import Law
from tvclin.control.laws.registry import LAWS
from tvclin.design.gain_designs import GainTradeOff
from tvclin.design.standard_trials import law_curve
from tvclin.linear.flexible import AnyPlant, check_plant
from tvclin.linear.plant import Plant
from tvclin.nozzle.flown_trade_off import FlownTradeOff
from tvclin.plots.curves import Column, Curves, finite_or_nan
from tvclin.plots.style import COLOURS, INK, WARM, Look, Style, called, draw, law_styles
from tvclin.requirement.nominal_requirement import required_deflection
from tvclin.requirement.study import Study
from tvclin.vehicle.coefficients import PLANES
from tvclin.winds.plane_wind import PlaneWind, unit_vector
from tvclin.winds.pulses import TriangularWind

if TYPE_CHECKING:
    from control import ControlPlot
    from matplotlib.lines import Line2D


_NOZZLE = "the nozzle"
_RATES: dict[str, Style] = {
    WIND_KNOWN: {"color": "0.7", "ls": "-", "lw": 4.0},
    NO_FORECAST: {"color": INK, "ls": "-", "lw": 1.6},
    _NOZZLE: {"color": INK, "ls": "", "marker": "D", "ms": 7.0},
    **law_styles(LAWS),
}
_POINT: Style = {"ls": "", "marker": "o", "ms": 7.0}
_LOADS: dict[str, Style] = {
    WIND_KNOWN: {"color": COLOURS[0], "lw": 2.0},
    NO_FORECAST: {"color": INK, "ls": "--", "lw": 1.4},
    _NOZZLE: {"color": WARM, **_POINT},
}
_FLOWN: tuple[Style, ...] = tuple(
    {"color": colour, **_POINT, "marker": marker}
    for colour, marker in zip((c for c in COLOURS[1:] if c != WARM), "s^vDP", strict=False)
)
_MARGINS: dict[str, Style] = {
    "boundary, K = 1": {"color": "0.45", "ls": "--", "lw": 1.4},
    "boundary, K = 0.5": {"color": "0.45", "ls": "-.", "lw": 1.4},
    WIND_KNOWN: {"color": INK, "ls": ":", "lw": 2.0},
}
_MEANS = {"peak": "linear peak", "boundary": "flown limit"}


def rate_curves(trade_off: RateTradeOff | FlownTradeOff) -> Curves:
    """Return minimum deflections over the rate limit, in degrees; NaN where none is sufficient.

    `trade_off`: limits [rad] over rate limits [rad/s], with flown laws or without. The
    nozzle is a point, at its own rate limit, if that is among the rates.
    """
    flown = trade_off.limits if isinstance(trade_off, FlownTradeOff) else {}
    trade_off = trade_off.minimum if isinstance(trade_off, FlownTradeOff) else trade_off
    errors.instance("trade_off", trade_off, RateTradeOff, "see rate_trade_off")
    values = {**flown, WIND_KNOWN: trade_off.limits}
    if trade_off.no_forecast_bounds is not None:
        values[NO_FORECAST] = trade_off.no_forecast_bounds
    if trade_off.limit is not None and trade_off.rate_limit in trade_off.rates:
        values[_NOZZLE] = np.where(trade_off.rates == trade_off.rate_limit, trade_off.limit, np.nan)
    # NaN in place of infinity, so that the curve has a gap
    columns = [
        Column(name, np.degrees(finite_or_nan(angles)), "deg") for name, angles in values.items()
    ]
    words, rates = "minimum deflection over the rate limit", np.degrees(trade_off.rates)
    return Curves("rates", words, "rate limit [deg/s]", rates, tuple(columns))


def rate_chart(
    trade_off: RateTradeOff | FlownTradeOff, title: str = "Minimum deflection over rate"
) -> ControlPlot:
    """Draw the minimum deflection over the rate limit, and the nozzle if its rate is in the range.

    Parameters
    ----------
    trade_off : RateTradeOff or FlownTradeOff
        Result of `rate_trade_off`, or of `flown_trade_offs` with a curve of each law.
    title : str
        Title of the figure.
    """
    curves = rate_curves(trade_off)
    plot = draw(curves, Look(title, "deflection [deg]", _RATES))
    plot.axes.flat[0].set_xlim(0.0, 1.03 * float(curves.abscissa.max()))
    return plot


def load_curves(trade_off: LoadTradeOff, flown: Sequence[FlownLoad] = ()) -> Curves:
    """Return minimum deflections over the load, in degrees; NaN where none is sufficient.

    `trade_off`: limits [rad] over loads, as angles of attack [rad] that load the structure as much.
    `flown`: limit and load of flown laws, a point each; their loads are added to the abscissa.
    """
    errors.instance("trade_off", trade_off, LoadTradeOff, "see load_trade_off")
    flown = errors.each("flown", flown, FlownLoad, "one for each law")
    points = {}
    if trade_off.limit is not None:
        if trade_off.load is not None:
            points[_NOZZLE] = trade_off.load
        points |= {flight.law: flight.load for flight in flown if np.isfinite(flight.load)}
    loads = np.unique(np.concatenate([trade_off.loads, list(points.values())]))

    def interpolated(values: FloatArray) -> FloatArray:
        """Return limits at the loads of the figure, from `values` at the loads of the trade-off.

        NaN below the smallest of the latter, and where a limit is infinite.
        """
        return np.interp(loads, trade_off.loads, finite_or_nan(values), left=np.nan)

    values = {WIND_KNOWN: interpolated(trade_off.limits)}
    if trade_off.no_forecast_bounds is not None:
        values[NO_FORECAST] = interpolated(trade_off.no_forecast_bounds)
    for name, load in points.items():
        values[name] = np.where(loads == load, trade_off.limit or np.nan, np.nan)
    columns = [Column(name, np.degrees(angles), "deg") for name, angles in values.items()]
    words = "minimum deflection over the largest load"
    return Curves("loads", words, "load [deg]", np.degrees(loads), tuple(columns))


def load_chart(
    trade_off: LoadTradeOff,
    flown: Sequence[FlownLoad] = (),
    title: str = "Minimum deflection over the largest load",
) -> ControlPlot:
    """Draw the minimum deflection over the load, the nozzle if it has a load, and flights.

    Parameters
    ----------
    trade_off : LoadTradeOff
        Result of `load_trade_off`.
    flown : sequence of FlownLoad
        Flights of laws with the limit of the trade-off.
    title : str
        Title of the figure.
    """
    curves = load_curves(trade_off, flown)
    styles = _LOADS | dict(zip([flight.law for flight in flown], _FLOWN, strict=False))
    plot = draw(curves, Look(title, "deflection [deg]", styles))
    axes = plot.axes.flat[0]
    axes.set_xlim(0.0, 1.03 * float(curves.abscissa.max()))
    axes.set_ylim(bottom=0.0)
    return plot


def gain_trade_off_chart(trade_offs: Sequence[GainTradeOff]) -> ControlPlot:
    """Draw the minimum deflection over the required disk margin.

    Parameters
    ----------
    trade_offs : sequence of GainTradeOff
        Trade-off curves of one vehicle in one set of winds, over the same disk margins: for two
        gains or three, for linear peaks or flown limits.

    Raises
    ------
    InputError
        For no curve, and for curves over different disk margins.
    """
    trade_offs = errors.each("trade_offs", trade_offs, GainTradeOff, "see gain_trade_off")
    if not trade_offs:
        raise errors.InputError("trade_offs must be one or more; got none")
    disk = trade_offs[0].disk_margin
    if any(not np.array_equal(trade_off.disk_margin, disk) for trade_off in trade_offs):
        raise errors.InputError("trade_offs must be over the same disk margins")
    columns, styles = [], dict(_MARGINS)
    for k, trade_off in enumerate(trade_offs):
        label = f"{plural(len(trade_off.gains), 'gain')}, {_MEANS[trade_off.meaning]}"
        # over trim; NaN in place of infinity, so that the curve has a gap
        columns.append(Column(label, finite_or_nan(trade_off.relative)))
        styles[label] = {"color": COLOURS[k % len(COLOURS)], "lw": 2.0, "marker": "o", "ms": 4.0}
    columns += [
        Column(name, np.full(disk.shape, value)) for name, value in trade_offs[0].limits.items()
    ]
    words, label = "minimum deflection over the required disk margin", "required disk margin [-]"
    curves = Curves("least-gains", words, label, disk, tuple(columns))
    look = Look("Minimum deflection over disk margin", "deflection over |B alpha_w,max|", styles)
    plot = draw(curves, look)
    plot.axes.flat[0].set_ylim(bottom=0.0)
    return plot


TAU_BETA = np.array([1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 14.0, 20.0, 28.0, 40.0])
_FINE = 400
_OPEN: dict[str, Style] = {
    "required, K = 1": {"color": "0.45", "ls": "--", "lw": 1.4},
    "required, K = 0.5": {"color": "0.45", "ls": "-.", "lw": 1.4},
    NO_FORECAST: {"color": INK, "ls": "-", "lw": 2.4},
    WIND_KNOWN: {"color": INK, "ls": ":", "lw": 2.0},
}


def laws_chart(
    plant: AnyPlant,
    laws: Mapping[str, Law],
    peak: float,
    tau_beta: FloatArray = TAU_BETA,
    **hardware: Any,
) -> ControlPlot:
    """Draw the boundary of each law over tau*beta, with required limits and lower bounds.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        One plant; required limits and lower bounds are for the rigid vehicle.
    laws : mapping of str to Law
        Laws by name, such as `standard_laws`.
    peak : float
        Peak of the triangular winds [rad].
    tau_beta : ndarray
        Durations of the winds times the unstable pole, beta without damping, rising, ``(n,)``.
    **hardware
        sample_rate [Hz], rate_limit [rad/s], actuator and delay [s] of the flights.

    Notes
    -----
    The numbers are those at `tau_beta`, where laws have a mark; between them the lines are monotone
    cubics (PCHIP).
    """
    check_plant(plant)
    errors.single("plant", plant.batch)
    if not isinstance(laws, Mapping) or not all(isinstance(name, str) for name in laws):
        raise errors.InputError(
            f"laws must be a dict of laws by their names; got {errors.shown(laws)}"
        )
    peak = errors.number("peak", peak, errors.small_angle("a wind", errors.nonzero), "rad")
    tau_beta = errors.one_row("tau_beta", errors.positive("tau_beta", tau_beta))
    pole, symbol = float(plant.coefficients.pole), plant.coefficients.pole_symbol
    winds = [TriangularWind(peak=peak, duration=float(x) / pole) for x in tau_beta]
    trim = abs(float(plant.coefficients.B) * peak)
    rows = {
        "required, K = 1": [required_deflection(plant.rigid, w).limit for w in winds],
        "required, K = 0.5": [
            required_deflection(plant.rigid, w, dead_band=0.5).limit for w in winds
        ],
        NO_FORECAST: [forecast_free_limit(plant.rigid, w).limit for w in winds],
        WIND_KNOWN: [optimum_deflection(plant.rigid, w).peak / trim for w in winds],
    }
    columns = [Column(name, np.array(row)) for name, row in rows.items()]
    columns += [
        Column(name, law_curve(plant, law, tau_beta, peak, **hardware))
        for name, law in laws.items()
    ]
    words = f"{plant.model}, triangular winds of {np.degrees(peak):.4g} deg"
    curves = Curves("laws", words, f"tau*{symbol}", tau_beta, tuple(columns))
    look = Look(  # the only panel has no heading: its limits have the key ""
        called(plant.coefficients.name, f"From trim to the minimum\n{words}"),
        "deflection limit over |B alpha_w,max|",
        _OPEN | law_styles(laws),
        limits={"": (0.0, 2.0)},
    )
    plot = draw(curves, look)
    for line in plot.lines[0, 0]:
        _smooth(line)
    return plot


def _smooth(line: Line2D) -> None:
    """Replace a line by a monotone cubic through its points, with marks at the points.

    A line of fewer than three points, or with a gap where there is no boundary, is unchanged.
    """
    from scipy.interpolate import PchipInterpolator

    x, y = (np.asarray(values, dtype=float) for values in line.get_data())
    finite = np.isfinite(y)
    if finite.sum() < x.size or x.size < 3:
        return
    fine = np.unique([*x, *np.linspace(x[0], x[-1], _FINE)])
    line.set_data(fine, PchipInterpolator(x, y)(fine))
    line.set_markevery(np.searchsorted(fine, x).tolist())


TRIMS, MEANS = "trim, over time", "mean of the trim to come"
HELD, STOP = "held from the dead band on", "the stop at the least limit"
_PLANES: dict[str, Style] = {
    STOP: {"color": WARM, "ls": "-", "lw": 1.4},
    TRIMS: {"color": INK, "ls": "--", "lw": 1.4},
    MEANS: {"color": COLOURS[0], "ls": "-", "lw": 1.8},
    HELD: {"color": COLOURS[1], "ls": "-", "lw": 1.8, "marker": "o", "ms": 5.0},
}
_TIMES, _SIDES = 240, 360
"""Number of times of the wind, and of sides of the polygon that is drawn for the limit shape."""
_FRAME_MARGIN = 0.06
"""Margin of the frame around the curves, over their size."""


def plane_chart(
    plant: Plant,
    wind: PlaneWind,
    limit_shape: LimitShape | str = "round",
    dead_band: float = 1.0,
    yaw_plant: Plant | None = None,
) -> ControlPlot:
    """Draw the required deflections in pitch and yaw over a wind, and the limit shape.

    The trim deflection follows the wind. The discounted mean of the future trim is the constant
    deflection that suffices from then on, eq (4b) of the report. At the smallest limit the limit
    shape touches this mean at the exit of the dead band.

    Parameters
    ----------
    plant, wind, limit_shape, dead_band, yaw_plant
        Plant in pitch, and in yaw where that is not given; wind in both planes; limit shape or its
        name; K. No batches.

    Raises
    ------
    InputError
        In the same cases as `plane_limit`, and for batches.
    """
    shape = limit_shape_of(limit_shape)
    checked_batch(plant, wind, shape, yaw_plant)
    for name, plane_plant in (("plant", plant), ("yaw_plant", yaw_plant or plant)):
        errors.single(name, plane_plant.batch)
    dead_band = errors.number("dead_band", dead_band, errors.between(0.0, 1.0))
    # "literal": the dead band ends where trim itself, not the wind, exceeds K times the limit
    limit = plane_limit(plant, wind, shape, dead_band, switch="literal", yaw_plant=yaw_plant)
    pair = PlanePair((plant, yaw_plant or plant), wind)
    knots = np.union1d(wind.pitch.knots, wind.yaw.knots)
    ends = float(wind.onset), float(wind.end)
    times = np.union1d(knots[(knots > ends[0]) & (knots < ends[1])], np.linspace(*ends, _TIMES))
    angles = 2.0 * np.pi * np.arange(_SIDES + 1) / _SIDES
    constant = limit.pitch + 1j * limit.yaw
    # vectors of both planes [rad], pitch + i yaw; `reach`: in each direction, over the limit
    vectors = {
        STOP: limit.deflection * shape.reach(angles) * unit_vector(angles),
        TRIMS: pair.trim(times),
        MEANS: pair.required_constant(times),
        HELD: np.array([0.0, constant]),
    }
    points = np.concatenate(list(vectors.values())) * (180.0 / np.pi)
    # one abscissa, pitch, for all curves: each has its ordinates, yaw, at its own points alone
    first, columns = 0, []
    for label, values in vectors.items():
        rows, yaw = slice(first, first + values.size), np.full(points.size, np.nan)
        yaw[rows] = points[rows].imag
        columns.append(Column(label, yaw, "deg"))
        first += values.size
    words = (
        f"{plant.model}, K = {dead_band:g}, limit {np.degrees(limit.deflection):.4f} deg, pitch"
        f" alone {np.degrees(limit.pitch_only):.4f} deg"
    )
    curves = Curves("planes", words, "deflection in pitch [deg]", points.real, tuple(columns))
    title = called(plant.coefficients.name, f"Deflection that a wind needs in both planes\n{words}")
    plot = draw(curves, Look(title, "deflection in yaw [deg]", _PLANES))
    axes = plot.axes[0, 0]
    half_width = (1.0 + _FRAME_MARGIN) * np.abs([points.real, points.imag]).max()
    axes.set(xlim=(-half_width, half_width), ylim=(-half_width, half_width))
    axes.set_aspect("equal")
    return plot


def study_planes_chart(study: Study) -> ControlPlot:
    """Draw trim in pitch and yaw, the discounted mean of future trim, and the limit of a study.

    Raises
    ------
    InputError
        For a study of a wind without direction, and in the same cases as `plane_chart`.
    """
    errors.instance("study", study, Study, "see Study.from_vehicle")
    if study.slanting is None or study.planes is None:  # its wind if it has a heading, else None
        raise errors.InputError("study must be of a wind with a direction: give it a heading")
    pitch, yaw = (Plant.from_vehicle(study.vehicle, study.model, plane) for plane in PLANES)
    wind, limit_shape = study.planes.wind, study.planes.limit_shape
    return plane_chart(pitch, wind, limit_shape, study.dead_band, yaw_plant=yaw)
