"""Trials of laws: the same standard winds for all, and the limit that each law requires.

Every wind has the same peak and is measured by the duration of the triangle it belongs to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown, table
from tvclin.base.errors import InputError, callable_for, each, flag, instance, number, positive
from tvclin.base.fields import checked, count, file_table, quantity, record_table, spec, word
from tvclin.base.lines import Line, Table
from tvclin.base.lines import number as number_cell
from tvclin.base.quantities import NO_FORECAST, QUANTITIES, WIND_KNOWN
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.optimum.minimum_peak import optimum_deflection
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.laws.law import Law
from tvclin.control.laws.registry import AUTOPILOT, LAWS, design_law
from tvclin.flights.closed_loop.fly import flight_responses
from tvclin.flights.closed_loop.survival_limit import (
    ABOVE,
    ALWAYS,
    NEVER,
    OK,
    PARTS,
    STEPS,
    closed_loop_boundary,
)
from tvclin.kernels.choice import repeated
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.plant import Plant
from tvclin.winds import pulses
from tvclin.winds.histories import History

WINDS = (
    *("triangle", "sawtooth, stops dead", "sawtooth, jumps first", "1 - cosine", "trapezoid"),
    *("two gusts", "opposite gusts", "flip to 0.3", "full reversal"),
)
"""The winds of trials, see `standard_winds`."""
_LOAD_LIMIT_RATIO = 1.2
"""Limit of the flights for loads, as a ratio to the boundary."""
_LOAD_POINTS = 801
"""Number of times of the flights for loads."""
_MAX_LIMIT = 4.0
"""Largest limit that is tried, normalised by trim."""
_SAMPLE_RATE = 100.0
"""Sample rate of laws by default [Hz]."""


@dataclass(frozen=True, kw_only=True)
class LawsRequest:
    """Specification of the laws that are flown, and of their winds.

    Attributes
    ----------
    names : tuple of str
        Names of `standard_laws`.
    winds : tuple of str
        Names of `standard_winds`.
    sample_rate : float
        Sample rate of the laws [Hz].
    cuts : int
        Number of sudden ends of each wind that are flown as well.
    """

    names: tuple[str, ...] = word(LAWS, tuple(LAWS), many=True)
    winds: tuple[str, ...] = word(WINDS, ("triangle",), many=True)
    sample_rate: float = quantity("sample rate", 50.0, positive)
    cuts: int = count(0)

    def __post_init__(self) -> None:
        """Check names, sample rate and cuts."""
        checked(self)


LAWS_TABLE = file_table("[laws]", LawsRequest)


@dataclass(frozen=True)
class LawTrial(Shown):
    """Trial of a law in a wind.

    Attributes
    ----------
    law, wind : str
        Names of law and wind.
    limit : float
        Boundary: minimum deflection limit, normalised by ``|B alpha_w,max|``; infinite if none is
        sufficient, and the lowest that was tried if that survives.
    status : str
        "ok", or a reservation on the boundary in words; see `ClosedLoopBoundary`.
    lowest, highest : float
        Range of limits that were tried, normalised by trim.
    growth : float
        Growth rate [1/s] of the worst mode in the linear range; see `ClosedLoopBoundary`.
    creeps : bool
        Whether the law lets that mode creep away, though it survives the wind.
    monotone : bool
        Whether every limit that was tried above one that survives survives as well.
    looked : tuple of pairs of float
        Steps in which limits were tried above the boundary, and the largest limit of each step;
        see `ClosedLoopBoundary`.
    peak_angle_of_attack, peak_attitude : float
        Largest of 801 samples of a flight at 1.2 times the boundary, normalised by the peak of the
        wind; NaN without a boundary, and without `loads`.
    """

    law: str = field(metadata=spec())
    wind: str = field(metadata=spec())
    limit: float = field(metadata=spec(digits=3))
    status: str = field(metadata=spec())
    lowest: float
    highest: float
    growth: float
    creeps: bool
    monotone: bool
    looked: tuple[tuple[float, float], ...]
    peak_angle_of_attack: float = field(metadata=spec(label="angle of attack", digits=2))
    peak_attitude: float = field(metadata=spec(label="attitude", digits=2))


class LawTrials(tuple[LawTrial, ...]):
    """Trials, one after the other, and in a notebook as a table."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        """Return the trials as a table for a notebook."""
        caption = "Required limit of each law over full trim, and angles over the peak of the wind"
        names = ("law", "wind", "limit", "peak_angle_of_attack", "peak_attitude", "status")
        return table(record_table(caption, "trial", self, *names))


def standard_winds(peak: float, duration: float) -> dict[str, History]:
    """Return the winds of the trials by name.

    Parameters
    ----------
    peak : float
        Largest wind angle of attack [rad] of each.
    duration : float
        Duration [s] of the triangle, and of each half of the double gusts.
    """
    tau, peak = number("duration", duration, positive, "s"), number("peak", peak, unit="rad")
    triangle = pulses.TriangularWind(peak=peak, duration=tau)
    rise = triangle.before(tau / 2)
    fall = pulses.SampledWind(time=np.array([0.0, tau / 2]), angle=np.array([peak, 0.0]))
    winds: tuple[History, ...] = (
        triangle,
        pulses.AsymmetricTriangularWind(peak=peak, duration=tau, peak_time=tau),
        pulses.AsymmetricTriangularWind(peak=peak, duration=tau, peak_time=0.0),
        pulses.OneMinusCosineGust(peak=peak, duration=tau),
        pulses.TrapezoidalWind(peak=peak, rise=tau / 4, hold=tau / 2, fall=tau / 4),
        triangle + triangle.shift(tau),
        triangle - triangle.shift(tau),
        rise - 0.3 * fall.shift(tau / 2),
        rise - fall.shift(tau / 2),
    )
    return dict(zip(WINDS, winds, strict=True))


def standard_laws(
    plant: Plant, peak: float, autopilot: Autopilot | None = None, rate_limit: float = np.inf
) -> dict[str, Law]:
    """Return all laws by name, designed on a plant for a peak wind [rad] and rate limit [rad/s].

    The law "autopilot" has the gains of `autopilot`, if given. `InputError` for a plant without an
    unstable pole.
    """
    design = partial(design_law, plant=plant, peak=peak, rate_limit=rate_limit)
    others = {name: design(name) for name in LAWS if name != AUTOPILOT}
    return {AUTOPILOT: design(AUTOPILOT, autopilot=autopilot)} | others


def law_trials(
    plant: AnyPlant,
    laws: Mapping[str, Law],
    winds: Mapping[str, History],
    *,
    sample_rate: float = _SAMPLE_RATE,
    cuts: int = 0,
    loads: bool = True,
    progress: Callable[[int, int], None] | None = None,
    **hardware: Any,
) -> LawTrials:
    """Return the trial of each law in each wind, winds within laws.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        The plant that flies.
    laws, winds : mapping of str to Law and to History
        Laws and winds by name, such as from `standard_laws` and `standard_winds`.
    sample_rate : float
        Samples of the law in a second [Hz].
    cuts : int
        Number of sudden ends of each wind that are tried as well, at even instants.
    loads : bool
        Whether to fly for the largest angle of attack and attitude; they are NaN otherwise.
    progress : callable, optional
        Called with the finished work and the largest total of it.
    **hardware
        rate_limit [rad/s], actuator and delay [s] of the flights.
    """
    if progress is not None:
        callable_for("progress", progress, "of how many are done and how many there are")
    for name, mapping, kind in (("laws", laws, Law), ("winds", winds, History)):
        instance(name, mapping, Mapping, "by name")
        each(name, tuple(mapping.values()), kind, "by name")
    flag("loads", loads)
    flown = {"sample_rate": sample_rate, **hardware}
    pairs = [(law, wind) for law in laws.items() for wind in winds.items()]

    def report(pair: int, done: int, total: int) -> None:
        """Report the work on all pairs, from the work `done` of `total` on one, by its index."""
        if progress is not None:
            progress(pair * total + done, len(pairs) * total)

    with repeated(len(pairs)):  # similar runs, which decide between compiled and plain code
        return LawTrials(
            _trial(plant, law, wind, cuts, loads, flown, progress=partial(report, k))
            for k, (law, wind) in enumerate(pairs)
        )


def law_curve(
    plant: AnyPlant,
    law: Law,
    tau_beta: FloatArray,
    peak: float,
    *,
    sample_rate: float = _SAMPLE_RATE,
    **hardware: Any,
) -> FloatArray:
    """Return the boundaries of a law in triangular winds, normalised by trim, ``(n,)``.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        The plant that flies.
    law : Law
        The law, designed on that plant.
    tau_beta : ndarray
        Durations of the winds, times beta; with damping, times the pole of the plant, ``(n,)``.
    peak : float
        Largest wind angle of attack [rad].
    sample_rate : float
        Sample rate of the law [Hz].
    **hardware
        rate_limit [rad/s], actuator and delay [s] of the flights.
    """
    pole = float(plant.coefficients.pole)
    winds = [pulses.TriangularWind(peak=peak, duration=float(x) / pole) for x in tau_beta]
    options: dict[str, Any] = {"sample_rate": sample_rate, "highest": _MAX_LIMIT, **hardware}
    return np.array([closed_loop_boundary(plant, law, wind, **options).limit for wind in winds])


def _trial(
    plant: AnyPlant,
    law: tuple[str, Law],
    wind: tuple[str, History],
    cuts: int,
    loads: bool,
    flown: dict[str, Any],
    progress: Callable[[int, int], None],
) -> LawTrial:
    """Return the trial of a law in a wind, each a pair of name and value.

    `plant`: the plant that flies. `cuts`: number of sudden ends of the wind. `loads`: whether to
    fly for the peaks [rad] of angle of attack and attitude, with a limit above the boundary; NaN
    if not. `flown`: sample rate and hardware of `closed_loop_boundary`. `progress`: called with
    finished and total work.
    """
    (law_name, flown_law), (wind_name, history) = law, wind
    options = {"cuts": cuts, "highest": _MAX_LIMIT, "progress": progress, **flown}
    boundary = closed_loop_boundary(plant, flown_law, history, **options)
    alpha, attitude = np.nan, np.nan
    if loads and np.isfinite(boundary.limit):
        start, end = float(history.onset), float(history.end)
        times = np.linspace(start, end + 0.5 * (end - start), _LOAD_POINTS)
        flown = {"deflection_limit": _LOAD_LIMIT_RATIO * abs(boundary.deflection), **flown}
        outputs = flight_responses(plant, flown_law, history, times, **flown)
        peak = abs(float(history.peak))
        alpha, attitude = (
            float(np.abs(outputs[name]).max()) / peak for name in ("angle_of_attack", "attitude")
        )
    return LawTrial(
        law=law_name,
        wind=wind_name,
        limit=boundary.limit,
        status=boundary.status,
        lowest=float(boundary.scan[0]),
        highest=float(boundary.scan[-1]),
        growth=boundary.growth,
        creeps=boundary.has_unstable_mode,
        monotone=boundary.monotone,
        looked=boundary.refinements,
        peak_angle_of_attack=alpha,
        peak_attitude=attitude,
    )


LEGEND = f"Any law, {NO_FORECAST}: {QUANTITIES[NO_FORECAST]}; - where the wind changes its sign."


class Bounds(NamedTuple):
    """Bounds of all laws in a wind: trim [deg], and two lower bounds normalised by that trim.

    A bound that is not defined is NaN.
    """

    trim_deg: float
    no_forecast: float
    minimum: float


def bounds(plant: Plant, winds: Mapping[str, History]) -> dict[str, Bounds]:
    """Return the bounds on every law around a plant by wind: without a forecast, and wind known.

    The first holds for laws without a forecast that survive the wind even if it stops at any
    instant, the second is the minimum peak of any control. `winds`: by name.
    """
    bounds_of = {}
    for name, wind in winds.items():
        trim = abs(float(plant.coefficients.B * wind.peak))
        no_forecast = minimum = np.nan  # where a theorem refuses the wind
        with suppress(InputError):
            # The control of the known wind may begin at time 0, ahead of a later onset.
            optimum = optimum_deflection(plant, wind, min(0.0, float(wind.onset)))
            minimum = optimum.peak / trim if trim else np.nan
        with suppress(InputError):
            no_forecast = float(forecast_free_limit(plant, wind).limit)
        bounds_of[name] = Bounds(float(np.degrees(trim)), no_forecast, minimum)
    return bounds_of


def limit_tables(
    trials: Sequence[LawTrial], wind_bounds: Mapping[str, Bounds]
) -> tuple[Table, ...]:
    """Return the tables of the required limit of each law in each wind, and of the bounds.

    The limits of the `trials` are in degrees and normalised by the trim of the wind; the bounds
    hold for every law.
    """
    laws = tuple(dict.fromkeys(trial.law for trial in trials))
    by_name = {(trial.wind, trial.law): trial for trial in trials}
    head = ("wind", *(law.replace("-", " ") for law in laws), "any law")

    def rows(unit: str, scales: Mapping[str, float]) -> Iterator[tuple[Line, ...]]:
        """Yield a row of each wind: limits of all `laws`, and the bound without a forecast.

        `scales`: factor of a wind on limits over trim: its trim [deg], or 1. `unit`: end of the
        keys for JSON, as in "laws.0.any_deg" of the first wind.
        """
        for j, (wind, wind_bound) in enumerate(wind_bounds.items()):
            scale, key = scales[wind], f"laws.{j}"
            cells = [_limit(f"{key}.{law}{unit}", by_name[wind, law], scale) for law in laws]
            any_law = number_cell(f"{key}.any{unit}", scale * wind_bound.no_forecast)
            yield ((wind,), *cells, any_law)

    minimum_rows = tuple(
        (
            (wind,),
            number_cell(f"laws.{j}.ideal_deg", trim),
            number_cell(f"laws.{j}.minimum_deg", trim * minimum),
            number_cell(f"laws.{j}.minimum", minimum),
        )
        for j, (wind, (trim, _, minimum)) in enumerate(wind_bounds.items())
    )
    trims = {wind: entry.trim_deg for wind, entry in wind_bounds.items()}
    beyond = ("wind", "trim in that wind [deg]", f"{WIND_KNOWN} [deg]", "over trim")
    over_trim = tuple(rows("", dict.fromkeys(trims, 1.0)))
    return (
        Table("Required deflection limit of each law [deg]", head, tuple(rows("_deg", trims))),
        Table("Required limit of each law, over trim in that wind", head, over_trim),
        Table("Trim in each wind, and the minimum of any control", beyond, minimum_rows),
    )


def load_table(trials: Sequence[LawTrial]) -> Table:
    """Return the table of the largest angle of attack and attitude of each law in each wind.

    Both are normalised by the peak wind angle of attack, of flights with 1.2 times the limit that
    the law requires. `trials`: one of each law in each wind.
    """
    laws = tuple(dict.fromkeys(trial.law for trial in trials))
    rows: dict[str, list[Line]] = {trial.wind: [(trial.wind,)] for trial in trials}
    for trial in trials:
        cell: Line = ("-",)
        if trial.limit <= trial.highest:  # else without a boundary
            key = f"loads.{trial.wind}.{trial.law}"
            angle = number_cell(f"{key}.angle_of_attack", trial.peak_angle_of_attack, 2)
            cell = (*angle, "/", *number_cell(f"{key}.attitude", trial.peak_attitude, 2))
        rows[trial.wind].append(cell)
    caption = "Largest angle of attack / attitude over the wind, with 1.2 times that limit"
    head = ("wind", *(law.replace("-", " ") for law in laws))
    return Table(caption, head, tuple(map(tuple, rows.values())))


def scan_text(trials: Sequence[LawTrial]) -> str:
    """Return the text on the deflection limits of `trials`, over trim: their range and steps.

    The limits are the same in all trials. A scan has `STEPS` steps; above its largest lost limit
    `ABOVE` steps are scanned again, each in `PARTS` parts.
    """
    trial = trials[0]
    step = (trial.highest - trial.lowest) / STEPS
    return (
        f"Tried: limits from {trial.lowest:g} to {trial.highest:g} of ideal trim in steps of"
        f" {step:.2g}, and for {ABOVE * step:.2g} above each edge in steps of {step / PARTS:.2g},"
        " finer still near the edge. A narrower range of lost limits would not be seen."
    )


def limit_warnings(trials: Sequence[LawTrial]) -> list[str]:
    """Return the notes on limits of `trials` marked by ``!`` or ``*``, with laws and winds.

    ``!`` marks a boundary whose status is a warning; ``*`` a boundary below which some limits
    survive too: survival is not monotone in the limit.
    """
    marked = [
        f'!: "{trial.law}" in "{trial.wind}": {trial.status}'
        for trial in trials
        if _doubtful(trial)
    ]
    not_monotone = ", ".join(
        f'"{trial.law}" in "{trial.wind}"' for trial in trials if not trial.monotone
    )
    meaning = "some lower limits survive as well; above this one all that were tried survive"
    return [*marked, f"*: {meaning}: {not_monotone}"] if not_monotone else marked


def _limit(key: str, trial: LawTrial, scale: float) -> Line:
    """Return the cell of a trial's boundary times `scale`: a number, or "<" or ">" a tried limit.

    `trial`: its boundary, and the lowest and highest limit that were tried, over trim. `key`: key
    of the number. ``*`` marks a boundary below which some limits survive as well, ``!`` one with a
    reservation.
    """
    shown = number_cell(key, scale * trial.limit)
    if trial.limit > trial.highest:
        shown = (f">{scale * trial.highest:.4g}",)
    elif trial.limit <= trial.lowest:
        shown = (f"<{scale * trial.lowest:.4g}",)
    mark = ("" if trial.monotone else "*") + ("!" if _doubtful(trial) else "")
    return (*shown, mark) if mark else shown


def _doubtful(trial: LawTrial) -> bool:
    """Return whether the status of a trial's boundary needs a note below the table.

    No note is needed for "ok", nor where all or none of the limits survive, which the cell shows.
    """
    return trial.status not in (OK, NEVER, ALWAYS)
