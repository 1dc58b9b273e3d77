"""The least deflection limit with which a law survives a wind, decided without a horizon.

Survival need not grow with the limit (a law that leans further may be further out when the wind
turns), so limits are scanned before the edge is refined, and the edge is that above the highest
limit that does not survive. To survive is to be brought back from the wind (see `survival`); a
slow mode which the law then lets creep away is told apart from it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count

import numpy as np
from numpy.typing import NDArray

from tvclin.autopilot import Actuator
from tvclin.cards import card
from tvclin.closed_loop.airframe import MOST, Nozzle, steps
from tvclin.closed_loop.checks import check_flight, check_rate_limit, check_sample_rate
from tvclin.closed_loop.survival import SAVED, UNDECIDED, Trial
from tvclin.errors import InputError, number, positive, whole_number
from tvclin.histories import History
from tvclin.laws import Law
from tvclin.plant import Plant
from tvclin.recoverable import unstable_coordinates

FloatArray = NDArray[np.float64]

OK = "ok"
NEVER = "no limit in the range survives"
ALWAYS = "every limit in the range survives"
OPEN = "undecided: the highest limit that does not survive is not lost either"
_SCAN = 61
_ROUNDS = 2
_CREEPS = 1e-5
"""A mode that grows more slowly, over the fastest pole of the plant, is held within rounding."""


@dataclass(frozen=True, eq=False)
class ClosedLoopBoundary:
    """The boundary of a law in a wind.

    Attributes
    ----------
    limit : float
        Least limit above which every limit of the scan survives, over ``|B alpha_w,max|``; infinite
        if the largest does not.
    deflection : float
        The same [rad].
    scan : ndarray
        The limits that were tried, rising, over ``|B alpha_w,max|``.
    survives : ndarray of bool
        Which of them survive.
    growth : float
        How fast the worst mode of the loop grows [1/s] in still air, far below the limit: law,
        actuator and samples together. Negative where everything comes to rest again.
    creeps : bool
        Whether that mode grows, so that the law by itself does not hold it for ever.
    status : str
        "ok", or in words why the limit is an end of the range, that flights just below it stay
        undecided, and that the law by itself lets a mode grow.
    """

    limit: float
    deflection: float
    scan: FloatArray
    survives: NDArray[np.bool_]
    growth: float
    creeps: bool
    status: str

    def _repr_html_(self) -> str:
        rows = [
            ("limit, of full trim", self.limit, "-"),
            ("deflection", np.degrees(self.deflection), "deg"),
            ("worst growth near rest", self.growth, "1/s"),
            ("status", self.status, ""),
        ]
        return card("Boundary of a law", rows)

    @property
    def monotone(self) -> bool:
        """Whether no limit that is lost lies above one that survives."""
        return bool(np.all(np.diff(self.survives.astype(int)) >= 0))


def closed_loop_boundary(
    plant: Plant,
    law: Law,
    wind: History,
    *,
    rate_limit: float = np.inf,
    actuator: Actuator | None = None,
    sample_rate: float = 200.0,
    cuts: int = 0,
    lowest: float = 0.02,
    highest: float = 2.0,
    progress: Callable[[int, int], None] | None = None,
) -> ClosedLoopBoundary:
    """Return the least deflection limit with which a law survives a wind.

    Parameters
    ----------
    plant : Plant
        The plant that flies, with one or two real unstable poles.
    law : Law
        The law, designed on this plant or on another.
    wind : History
        One wind that ends.
    rate_limit : float
        Largest deflection rate [rad/s].
    actuator : Actuator, optional
        Without one the deflection follows its command within a sample.
    sample_rate : float
        Samples of the law in a second [Hz].
    cuts : int
        So many sudden stops are tried as well, at even instants of the wind: a limit survives if
        it survives them all.
    lowest, highest : float
        Range of the limits that are tried, over ``|B alpha_w,max|``.
    progress : callable, optional
        Is told how many winds have been flown with many limits, and how many there are at most.

    Returns
    -------
    ClosedLoopBoundary
        With the limits that were tried. The edge is known to 1/3600 of a step of the scan.

    Raises
    ------
    InputError
        For batches, a plant without a real unstable pole, a wind that never ends, and a sample
        rate too slow for the actuator.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> wind = tv.TriangularWind(peak=0.1, duration=8.0)
    >>> found = tv.closed_loop_boundary(plant, tv.TrimLaw(plant), wind, sample_rate=100)
    >>> round(found.limit, 3), round(tv.boundary_limit(plant, wind).limit, 3)
    (0.689, 0.688)
    """
    check_flight(plant, law, wind)
    modes = unstable_coordinates(plant)
    length = 1.0 / check_sample_rate(sample_rate, actuator)
    nozzle = Nozzle(actuator, check_rate_limit(rate_limit), length)
    stops = whole_number("cuts", cuts)
    low, high = number("lowest", lowest, positive), number("highest", highest, positive)
    if low >= high:
        raise InputError(f"highest must be above lowest; got {high:.6g} and {low:.6g}")
    B, gust = abs(float(plant.coefficients.B)), abs(float(wind.peak))
    start, end = float(wind.onset), float(wind.end)
    if (stops + 1) * (end - start) / length > MOST:
        raise InputError(
            f"cuts and sample_rate may make at most {MOST:g} samples of all winds; got"
            f" {stops + 1} times {end - start:.6g} s at {1.0 / length:.6g} Hz"
        )
    winds = [wind, *(wind.before(t) for t in np.linspace(start, end, stops + 2)[1:-1])]
    paces = [steps(plant, one, start, float(one.end), length) for one in winds]
    trials = [
        Trial(plant, law, one, nozzle, pace, modes, B, gust)
        for one, pace in zip(winds, paces, strict=True)
    ]
    flown, most = count(1), (1 + _ROUNDS) * len(trials)

    def tell() -> None:
        if progress is not None:
            progress(next(flown), most)

    edge = _edge(trials, np.linspace(low, high, _SCAN), B * gust, tell)
    at = edge.limit if np.isfinite(edge.limit) else high
    growth = trials[0].growth(at * B * gust)
    words = [] if edge.status == OK else [edge.status]
    creeps = bool(growth > _CREEPS * modes.poles[0])
    if creeps:
        words.append(f"near rest the law lets a mode of {growth:+.3g} 1/s creep away")
    return ClosedLoopBoundary(
        limit=edge.limit,
        deflection=edge.limit * B * gust,
        scan=edge.scan,
        survives=edge.verdicts == SAVED,
        growth=growth,
        creeps=creeps,
        status="; ".join(words) or OK,
    )


@dataclass(frozen=True, eq=False)
class _Edge:
    """What a scan found: the limit, the limits tried, their verdicts, and what is to be said."""

    limit: float
    scan: FloatArray
    verdicts: NDArray[np.int_]
    status: str


def _edge(trials: list[Trial], scan: FloatArray, scale: float, tell: Callable[[], None]) -> _Edge:
    """The edge above the highest limit that does not survive, over the scale [rad]."""
    verdicts = _verdicts(trials, scan * scale, tell)
    below = np.flatnonzero(verdicts != SAVED)
    if not below.size:
        return _Edge(float(scan[0]), scan, verdicts, ALWAYS)
    last = int(below[-1])
    status = OPEN if verdicts[last] == UNDECIDED else OK
    if last == scan.size - 1:
        return _Edge(np.inf, scan, verdicts, NEVER if status == OK else f"{NEVER}; {OPEN}")
    low, high = float(scan[last]), float(scan[last + 1])
    for _ in range(_ROUNDS):
        finer = np.linspace(low, high, _SCAN)
        found = _verdicts(trials, finer[1:-1] * scale, tell)
        below = np.flatnonzero(found != SAVED)
        last = int(below[-1]) if below.size else -1
        if last >= 0:
            status = OPEN if found[last] == UNDECIDED else OK
        low, high = float(finer[last + 1]), float(finer[last + 2])
    return _Edge(high, scan, verdicts, status)


def _verdicts(
    trials: list[Trial], limits: FloatArray, tell: Callable[[], None]
) -> NDArray[np.int_]:
    """The verdict over all winds for each limit [rad]: the first that is not survived counts."""
    found = np.full(limits.size, SAVED)
    for trial in trials:
        alive = found == SAVED
        found[alive] = trial.verdicts(limits[alive])
        tell()
    return found
