"""Standard trials of laws: the same winds for all, and what each law needs in them.

Every wind has the same peak and is measured by the duration of the triangle it belongs to.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from tvclin.base import lines
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown, table
from tvclin.base.declared import checked, file_table, quantity, word
from tvclin.base.errors import callable_for, each, flag, instance, number, positive
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.laws.law import Law
from tvclin.control.laws.registry import AUTOPILOT, LAWS, design_law
from tvclin.flights.closed_loop.fly import fly
from tvclin.flights.closed_loop.survival_limit import closed_loop_boundary
from tvclin.kernels.choice import repeated
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History
from tvclin.winds.pulses import (
    AsymmetricTriangularWind,
    OneMinusCosineGust,
    SampledWind,
    TrapezoidalWind,
    TriangularWind,
)

WINDS = (
    *("triangle", "sawtooth, stops dead", "sawtooth, jumps first", "1 - cosine", "trapezoid"),
    *("two gusts", "opposite gusts", "flip to 0.3", "full reversal"),
)
"""The winds of trials, see `standard_winds`."""
_SPARE = 1.2
"""Loads are those at so many times the boundary, where every law is at its ease."""
_POINTS = 801
_HIGHEST = 4.0
_RATE = 100.0


@dataclass(frozen=True, kw_only=True)
class LawsRequest:
    """The laws that are to be flown, and in which winds.

    Attributes
    ----------
    names : tuple of str
        Laws, of `standard_laws`.
    winds : tuple of str
        Winds, of `standard_winds`.
    sample_rate : float
        Sample rate of the laws [Hz].
    """

    names: tuple[str, ...] = word(LAWS, tuple(LAWS), many=True)
    winds: tuple[str, ...] = word(WINDS, ("triangle",), many=True)
    sample_rate: float = quantity("sample rate", 50.0, positive)

    def __post_init__(self) -> None:
        checked(self)


LAWS_TABLE = file_table("[laws]", LawsRequest)


@dataclass(frozen=True)
class LawTrial(Shown):
    """One law in one wind.

    Attributes
    ----------
    law, wind : str
        Their names.
    limit : float
        Boundary: least deflection limit, over ``|B alpha_w,max|``; infinite if none was found, and
        the lowest that was tried if that survives.
    status : str
        "ok", or in words what is to be said of the boundary, as of `ClosedLoopBoundary`.
    lowest, highest : float
        The range of limits that were tried.
    growth : float
        Growth rate [1/s] of the worst mode near rest, as of `ClosedLoopBoundary`.
    creeps : bool
        Whether the law lets that mode creep away, though it survives the wind.
    monotone : bool
        Whether every limit that was tried above one that survives survives as well.
    looked : tuple of pairs of float
        Steps in which limits were tried above the boundary, and up to where, as of
        `ClosedLoopBoundary`.
    peak_angle_of_attack, peak_attitude : float
        Largest of 801 samples of a flight at 1.2 times the boundary, over the peak of the wind;
        NaN where there is no boundary, or where they were not asked for.
    """

    law: str
    wind: str
    limit: float
    status: str
    lowest: float
    highest: float
    growth: float
    creeps: bool
    monotone: bool
    looked: tuple[tuple[float, float], ...]
    peak_angle_of_attack: float
    peak_attitude: float

    _keys = "law wind limit status peak_angle_of_attack peak_attitude"


class LawTrials(tuple[LawTrial, ...]):
    """Trials, one after the other, and in a notebook as a table."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        head = ("law", "wind", "limit, of full trim", "angle of attack", "attitude", "status")
        rows = tuple(
            (
                (t.law,),
                (t.wind,),
                lines.number("limit", t.limit),
                lines.number("angle of attack", t.peak_angle_of_attack, 2),
                lines.number("attitude", t.peak_attitude, 2),
                (t.status,),
            )
            for t in self
        )
        caption = "What each law needs; angles over the peak of the wind"
        return table(lines.Table(caption, head, rows))


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
    triangle = TriangularWind(peak=peak, duration=tau)
    back = SampledWind(time=np.array([0.0, tau / 2]), angle=np.array([peak, 0.0]))
    rise = triangle.before(tau / 2)
    winds: tuple[History, ...] = (
        triangle,
        AsymmetricTriangularWind(peak=peak, duration=tau, peak_time=tau),
        AsymmetricTriangularWind(peak=peak, duration=tau, peak_time=0.0),
        OneMinusCosineGust(peak=peak, duration=tau),
        TrapezoidalWind(peak=peak, rise=tau / 4, hold=tau / 2, fall=tau / 4),
        triangle + triangle.shift(tau),
        triangle - triangle.shift(tau),
        rise - 0.3 * back.shift(tau / 2),
        rise - back.shift(tau / 2),
    )
    return dict(zip(WINDS, winds, strict=True))


def standard_laws(
    plant: Plant, peak: float, autopilot: Autopilot | None = None, rate_limit: float = np.inf
) -> dict[str, Law]:
    """Return every law by name, designed on a plant, for a peak [rad] and a rate limit [rad/s].

    As `design_law`; the law "autopilot" has the gains of an autopilot where one is given.
    """
    own: dict[str, Any] = {} if autopilot is None else {AUTOPILOT: {AUTOPILOT: autopilot}}
    design = partial(design_law, plant=plant, peak=peak, rate_limit=rate_limit)
    return {name: design(name, **own.get(name, {})) for name in LAWS}


def law_trials(
    plant: AnyPlant,
    laws: Mapping[str, Law],
    winds: Mapping[str, History],
    *,
    sample_rate: float = _RATE,
    cuts: int = 0,
    loads: bool = True,
    progress: Callable[[int, int], None] | None = None,
    **hardware: Any,
) -> LawTrials:
    """Return what each law needs in each wind, winds within laws.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        The plant that flies.
    laws, winds : mapping of str to Law and to History
        By name, as of `standard_laws` and `standard_winds`.
    sample_rate : float
        Samples of the law in a second [Hz].
    cuts : int
        Sudden stops that are tried as well, as of `closed_loop_boundary`.
    loads : bool
        Whether to fly for the largest angle of attack and attitude; they are NaN otherwise.
    progress : callable, optional
        Is told how much is done, and how much there is at most, as of `closed_loop_boundary`.
    **hardware
        rate_limit, actuator and delay, as of `closed_loop_boundary`.
    """
    if progress is not None:
        callable_for("progress", progress, "of how many are done and how many there are")
    for name, given, kind in (("laws", laws, Law), ("winds", winds, History)):
        instance(name, given, Mapping, "by name")
        each(name, tuple(given.values()), kind, "by name")
    flag("loads", loads)
    flown = {"sample_rate": sample_rate, **hardware}
    pairs = [(law, wind) for law in laws.items() for wind in winds.items()]

    def told(pair: int) -> Callable[[int, int], None]:
        def tell(done: int, total: int) -> None:
            if progress is not None:
                progress(pair * total + done, len(pairs) * total)

        return tell

    with repeated(len(pairs)):
        return LawTrials(
            _trial(plant, *pair, cuts, loads, flown, told(k)) for k, pair in enumerate(pairs)
        )


def law_curve(
    plant: AnyPlant,
    law: Law,
    tau_beta: FloatArray,
    peak: float,
    *,
    sample_rate: float = _RATE,
    **hardware: Any,
) -> FloatArray:
    """Return the boundary of a law in triangular winds, over tau times beta.

    With damping over tau times the pole. The wind has a peak [rad], the law so many samples in a
    second [Hz]; hardware is as of `law_trials`.
    """
    pole = float(plant.coefficients.pole)
    winds = [TriangularWind(peak=peak, duration=float(x) / pole) for x in tau_beta]
    options: dict[str, Any] = {"sample_rate": sample_rate, "highest": _HIGHEST, **hardware}
    return np.array([closed_loop_boundary(plant, law, wind, **options).limit for wind in winds])


def _trial(
    plant: AnyPlant,
    law: tuple[str, Law],
    wind: tuple[str, History],
    cuts: int,
    loads: bool,
    flown: dict[str, Any],
    tell: Callable[[int, int], None],
) -> LawTrial:
    options = {"cuts": cuts, "highest": _HIGHEST, "progress": tell, **flown}
    found = closed_loop_boundary(plant, law[1], wind[1], **options)
    largest = (np.nan, np.nan)
    if loads and np.isfinite(found.limit):
        largest = _loads(plant, law[1], wind[1], _SPARE * abs(found.deflection), flown)
    return LawTrial(
        law=law[0],
        wind=wind[0],
        limit=found.limit,
        status=found.status,
        lowest=float(found.scan[0]),
        highest=float(found.scan[-1]),
        growth=found.growth,
        creeps=found.has_unstable_mode,
        monotone=found.monotone,
        looked=found.refinements,
        peak_angle_of_attack=largest[0],
        peak_attitude=largest[1],
    )


def _loads(
    plant: AnyPlant, law: Law, wind: History, limit: float, flown: dict[str, Any]
) -> tuple[float, float]:
    """The largest angle of attack and attitude of one flight, over the peak of the wind."""
    start, end = float(wind.onset), float(wind.end)
    times = np.linspace(start, end + 0.5 * (end - start), _POINTS)
    outputs = fly(plant, law, wind, times, deflection_limit=limit, **flown).outputs
    peak = abs(float(wind.peak))
    angle, attitude = (
        float(np.abs(outputs[name]).max()) / peak for name in ("angle_of_attack", "attitude")
    )
    return angle, attitude
