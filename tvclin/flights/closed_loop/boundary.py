"""The least deflection limit with which a law survives a wind, decided without a horizon.

Survival need not grow with the limit (a law that leans further may be further out when the wind
turns), so limits are scanned, and the edge is that above the highest limit that does not survive.
The steps above an edge are looked at again, in finer steps, and the edge moves up until they are
clean; then the finer steps likewise. Only a window of losses that is narrower than the steps where
it lies is missed. To survive is to be brought back from the wind (see `fly_many`); a
slow mode which the law then lets creep away is told apart from it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.base.cards import card
from tvclin.base.errors import (
    InputError,
    between,
    callable_for,
    nonnegative,
    number,
    positive,
    shown,
    whole_number,
)
from tvclin.boundary.recoverable import unstable_coordinates
from tvclin.control.autopilot.actuated import check_engine
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.checks import (
    check_delays,
    check_flight,
    check_pace,
    check_rate_limit,
    check_sample_rate,
    check_samples,
)
from tvclin.flights.closed_loop.growth import growth_near_rest
from tvclin.flights.closed_loop.law_batch import law_batch
from tvclin.flights.closed_loop.many import SURVIVED, UNDECIDED, fly_many
from tvclin.flights.closed_loop.sampled import Batch
from tvclin.linear.flexible import AnyPlant
from tvclin.winds.histories import History

FloatArray = NDArray[np.float64]

OK = "ok"
NEVER = "no limit in the range survives"
ALWAYS = "every limit in the range survives"
OPEN = "undecided: the highest limit that does not survive is not lost either"
STEPS = 60
"""Of the scan."""
ABOVE, PARTS, LEVELS = 4, 16, 3
"""So many steps above an edge are looked at again, each in so many parts, and that so often."""
_LIMITS = (1e-6, 1e6)
"""Limits that may be tried, over the largest trim deflection."""
_MOST_CUTS = 1000
"""Times at which a wind may be cut off; each is a wind of its own to be flown."""
_SAMPLES = 5_000_000
"""Of all winds that are flown together: some hundred megabytes."""
_CREEPS = 1e-5
"""A mode that grows more slowly, over the fastest pole of the plant, is held within rounding."""


@dataclass(frozen=True, eq=False)
class ClosedLoopBoundary:
    """The boundary of a law in a wind.

    Attributes
    ----------
    limit : float
        Least limit above which every limit that was tried survives, over ``|B alpha_w,max|``;
        infinite if the largest does not.
    deflection : float
        The same as a deflection [rad], -limit B alpha_w,max; its sign opposes the wind.
    scan : ndarray
        The limits that were tried, rising, over ``|B alpha_w,max|``.
    survives : ndarray of bool
        Which of them survive.
    looked : tuple of pairs of float
        Steps in which limits were tried again above the edge, and up to which limit, the finest
        last; both over ``|B alpha_w,max|``.
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
    looked: tuple[tuple[float, float], ...]
    growth: float
    creeps: bool
    status: str

    def _repr_html_(self) -> str:
        rows = [
            ("limit, of full trim", self.limit, "-"),
            ("deflection", np.degrees(self.deflection), "deg"),
            *(
                (f"up to {end:.4g} none is lost in steps of", step, "-")
                for step, end in self.looked
            ),
            ("worst growth near rest", self.growth, "1/s"),
            ("status", self.status, ""),
        ]
        return card("Boundary of a law", rows)

    @property
    def monotone(self) -> bool:
        """Whether no limit that was tried and is lost lies above one that survives."""
        return bool(np.all(np.diff(self.survives.astype(int)) >= 0))


def closed_loop_boundary(
    plant: AnyPlant,
    law: Law,
    wind: History,
    *,
    rate_limit: float = np.inf,
    actuator: Actuator | None = None,
    sample_rate: float = 200.0,
    delay: float = 0.0,
    cuts: int = 0,
    lowest: float = 0.02,
    highest: float = 2.0,
    progress: Callable[[int, int], None] | None = None,
) -> ClosedLoopBoundary:
    """Return the least deflection limit with which a law survives a wind.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
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
    delay : float
        Computing delay [s], as of `fly`.
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
        With the limits that were tried: 61 over the range, then each of the four steps above the
        highest that is lost in 16 parts, until these are clean, then these parts in the same way,
        and theirs. The edge is known to 1/4096 of a step of the scan.

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
    >>> [(round(step, 5), round(end, 3)) for step, end in found.looked]  # and none is lost there
    [(0.00206, 0.82), (0.00013, 0.697), (1e-05, 0.689)]
    """
    if progress is not None:
        callable_for("progress", progress, "of how many are done and how many there are")
    check_flight(plant, law, wind)
    check_engine(plant, actuator)
    modes = unstable_coordinates(plant.rigid)
    length = 1.0 / check_sample_rate(sample_rate, actuator)
    most_rate = check_rate_limit(rate_limit)
    check_samples(1.0 / float(modes.poles[0]), length)
    stops = whole_number("cuts", cuts)
    if stops > _MOST_CUTS:
        raise InputError(f"cuts must be at most {_MOST_CUTS}; got {shown(cuts)}")
    low, high = (
        number(name, number(name, value, positive), between(*_LIMITS))
        for name, value in (("lowest", lowest), ("highest", highest))
    )
    if low >= high:
        raise InputError(f"highest must be above lowest; got {high:.6g} and {low:.6g}")
    late = float(check_delays(number("delay", delay, nonnegative, "s"), np.asarray(length)))
    scale = abs(float(plant.coefficients.B) * float(wind.peak))
    check_pace(plant, length)
    winds = _winds(wind, stops, length)
    nozzle: dict[str, Any] = {"rate_limit": most_rate, "actuator": actuator}
    outcomes = partial(fly_many, plant, law, sample_rate=1.0 / length, delay=late, **nozzle)
    flown, most = count(1), (1 + LEVELS) * len(winds)

    def survives(limits: FloatArray) -> NDArray[np.str_]:
        """The status over all winds of each limit: the first that is not survived counts."""
        found = np.full(limits.size, SURVIVED, dtype=object)
        for one in winds:
            alive = found == SURVIVED
            if np.any(alive):
                found[alive] = outcomes(wind=one, deflection_limit=limits[alive] * scale).status
            if progress is not None:
                progress(min(next(flown), most), most)
        return found.astype(str)

    edge = _edge(survives, np.linspace(low, high, STEPS + 1))
    at = edge.limit if np.isfinite(edge.limit) else high
    level, quickest, step, behind = map(np.asarray, (at * scale, most_rate, length, late))
    laws = law_batch(law, ())
    batch = Batch(plant, wind, laws, level, quickest, actuator, step, behind, np.inf, ())
    growth = growth_near_rest(batch)
    words = [] if edge.status == OK else [edge.status]
    creeps = bool(growth > _CREEPS * modes.poles[0])
    if creeps:
        words.append(f"near rest the law lets a mode of {growth:+.3g} 1/s creep away")
    return ClosedLoopBoundary(
        limit=edge.limit,
        deflection=-edge.limit * float(plant.coefficients.B) * float(wind.peak),
        scan=edge.scan,
        survives=edge.found == SURVIVED,
        looked=edge.looked,
        growth=growth,
        creeps=creeps,
        status="; ".join(words) or OK,
    )


def _winds(wind: History, stops: int, length: float) -> list[History]:
    """The wind, and the same with so many sudden stops, at even instants."""
    start, end = float(wind.onset), float(wind.end)
    if (stops + 1) * (end - start) / length > _SAMPLES:
        raise InputError(
            f"cuts and sample_rate may make at most {_SAMPLES:g} samples of all winds; got"
            f" {stops + 1} times {end - start:.6g} s at {1.0 / length:.6g} Hz"
        )
    check_samples(end - start, length)
    return [wind, *(wind.before(t) for t in np.linspace(start, end, stops + 2)[1:-1])]


@dataclass(frozen=True, eq=False)
class _Edge:
    """The limit, the limits tried, their status, what was looked at, and what is to be said."""

    limit: float
    scan: FloatArray
    found: NDArray[np.str_]
    looked: tuple[tuple[float, float], ...]
    status: str


def _edge(survives: Callable[[FloatArray], NDArray[np.str_]], scan: FloatArray) -> _Edge:
    """The edge above the highest limit that does not survive."""
    limits, found = scan, survives(scan)
    bottom, top = float(scan[0]), float(scan[-1])
    step, looked = float(scan[1] - scan[0]), []
    for _ in range(LEVELS):
        step /= PARTS
        base, first, last = max(_highest_lost(limits, found), bottom), 1, ABOVE * PARTS
        while True:
            parts = np.arange(first, last + 1)
            parts = parts[parts % PARTS != 0]  # the others have been tried a level above
            ahead = base + step * parts
            ahead = ahead[ahead < top]
            new = survives(ahead)
            limits, found = np.append(limits, ahead), np.append(found, new)
            lost = np.flatnonzero(new != SURVIVED)
            if not lost.size:
                break
            first, last = last + 1, int(parts[lost[-1]]) + ABOVE * PARTS
        looked.append((step, min(base + step * last, top)))
    low = _highest_lost(limits, found)
    order = np.argsort(limits)
    status = OPEN if np.any(found[limits == low] == UNDECIDED) else OK
    edge = min(low + step, top)
    if low == -np.inf:
        edge, status = bottom, ALWAYS
    elif low == top:
        edge, status = np.inf, NEVER if status == OK else f"{NEVER}; {OPEN}"
    return _Edge(edge, limits[order], found[order], tuple(looked), status)


def _highest_lost(limits: FloatArray, found: NDArray[np.str_]) -> float:
    """The highest limit that does not survive, or minus infinity."""
    return float(limits[found != SURVIVED].max(initial=-np.inf))
