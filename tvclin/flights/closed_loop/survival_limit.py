"""The smallest deflection limit with which a law survives, and above which it always survives.

Survival need not be monotonic in the limit. Limits are scanned upwards and the transition from the
last loss to survival is refined; `boundary_map` repeats this over gains and delays of the loop.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import (
    InputError,
    between,
    callable_for,
    nonnegative,
    number,
    one_row,
    positive,
    shown,
    whole_number,
)
from tvclin.boundary.recoverable import unstable_coordinates
from tvclin.control.autopilot.actuator import Actuator, check_engine
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.batch import Hardware, one_flight
from tvclin.flights.closed_loop.checks import (
    check_delays,
    check_flight,
    check_pace,
    check_rate_limit,
    check_sample_rate,
    check_samples,
)
from tvclin.flights.closed_loop.fly_many import LARGEST_LIMIT, SURVIVED, UNDECIDED, fly_many
from tvclin.flights.closed_loop.sampled_stability import SLOW, worst_near_rest
from tvclin.kernels.choice import repeated
from tvclin.linear.flexible import AnyPlant
from tvclin.winds.histories import History

Words = NDArray[np.str_]

OK = "ok"
NEVER = "no limit in the range survives"
ALWAYS = "every limit in the range survives"
OPEN = "undecided: the highest limit that does not survive is not lost either"
STEPS = 60
"""Of a scan."""
ABOVE, PARTS, LEVELS = 4, 16, 3
"""So many steps above an edge are looked at again, each in so many parts, and that so often."""
STRIDE, FINE, AHEAD, LAST_PARTS = 0.02, 0.002, 0.06, 10
"""Steps of many edges at once, over the value; how far above an edge the finer ones reach; and in
how many parts the last is looked at."""
_MOST_CUTS = 1000
_SAMPLES = 5_000_000
"""Of all winds that are flown together: some hundred megabytes."""


@dataclass(frozen=True, eq=False)
class Edge:
    """The edge, the values tried, their status, what was looked at, and what is to be said.

    `looked` holds steps, and up to which value they were tried, the finest last; `lost` is the
    highest value that does not survive, or minus infinity.
    """

    limit: float
    lost: float
    scan: FloatArray
    found: Words
    looked: tuple[tuple[float, float], ...]
    status: str


def edge_above_losses(survives: Callable[[FloatArray], Words], scan: FloatArray) -> Edge:
    """Return the edge above the highest value that does not survive.

    `survives`: the status of values, ``(n,)``. `scan`: values in even steps, rising.
    """
    bottom, top = float(scan[0]), float(scan[-1])
    step = float(scan[1] - scan[0])
    tried: list[FloatArray] = []
    status: list[Words] = []

    def lost(values: FloatArray) -> BoolArray:
        column, found = values[:, 0], np.zeros(values.shape, np.bool_)
        new = column < top if tried else column <= top  # the top has been tried at once
        tried.append(column[new])
        status.append(survives(column[new]))
        found[new, 0] = status[-1] != SURVIVED
        return found

    steps = step / float(PARTS) ** np.arange(1, LEVELS + 1)
    levels = [(one, ABOVE * PARTS, PARTS) for one in steps.tolist()]
    base, ends = _climbed(lost, scan[:, np.newaxis], levels)
    values, found = np.concatenate(tried), np.concatenate(status)
    looked = tuple((one, min(end, top)) for one, end in zip(steps.tolist(), ends, strict=True))
    low, order = float(base[0]), np.argsort(values)
    words = OPEN if np.any(found[values == low] == UNDECIDED) else OK
    edge = min(low + looked[-1][0], top)
    if low == -np.inf:
        edge, words = bottom, ALWAYS
    elif low == top:
        edge, words = np.inf, NEVER if words == OK else f"{NEVER}; {OPEN}"
    return Edge(edge, low, values[order], found[order], looked, words)


def edges_above_losses(
    lost: Callable[[FloatArray], BoolArray], low: FloatArray, high: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Return the edges of many cases at once, and which of them are lost at `high` too.

    Values are tried every `STRIDE` from `low` to `high`; above the highest that is lost every
    `FINE`, until a range of `AHEAD` is clean; and the step that is left in `LAST_PARTS`. `lost`:
    which of the values ``(k, n)``, a column for each case, are lost. `low`, `high`: positive values
    between which the edges are sought, ``(n,)``.
    """
    span, fine = np.log(np.maximum(high / low, 1.0)), np.log1p(FINE)
    count = max(int(np.ceil(span.max(initial=0.0) / STRIDE)), 1)
    scan = span * np.linspace(0.0, 1.0, count + 1)[:, np.newaxis]

    def gone(parts: FloatArray) -> BoolArray:
        return lost(low * np.exp(np.minimum(parts, span))) & (parts <= span)

    levels = [(fine, int(AHEAD / FINE), 1), (fine / LAST_PARTS, LAST_PARTS - 1, 1)]
    base, _ = _climbed(gone, scan, levels)
    never, edge = base >= span, low * np.exp(np.minimum(base + fine / LAST_PARTS, span))
    return np.where(never, high, np.where(base > -np.inf, edge, low)), never


def _climbed(
    lost: Callable[[FloatArray], BoolArray],
    scan: FloatArray,
    levels: Sequence[tuple[float, int, int]],
) -> tuple[FloatArray, list[float]]:
    """The highest value that is lost of each column ``(k, n)``, minus infinity where none is.

    Of each level: the step, how many of them must be clean above it, and each how many-th has been
    tried a level above. Returned too: how far each level looked, in the first column.
    """
    base, ends = np.where(lost(scan), scan, -np.inf).max(axis=0), []
    for step, most, known in levels:
        start, first, last = np.maximum(base, scan[0]), 1, most
        while first <= last:
            parts = np.arange(first, last + 1)
            parts = parts[(parts % known != 0) | (known == 1)]
            values = start + step * parts[:, np.newaxis]
            gone = lost(values)
            base = np.maximum(base, np.where(gone, values, -np.inf).max(axis=0))
            above = parts[gone.any(axis=1)]
            first, last = last + 1, int(above.max(initial=last - most)) + most
        ends.append(float(start[0] + step * (first - 1)))
    return base, ends


def in_all(
    winds: Sequence[History],
    status: Callable[[History, BoolArray], Words],
    size: int,
    flown: Callable[[], None] = lambda: None,
) -> Words:
    """Return the status over all winds of many flights: the first not survived counts.

    `winds`: flown one after the other. `status`: of the flights chosen by a mask, in a wind.
    `size`: number of flights. `flown`: is called after each wind.
    """
    found = np.full(size, SURVIVED, dtype=object)
    for one in winds:
        alive = found == SURVIVED
        if np.any(alive):
            found[alive] = status(one, alive)
        flown()
    return found.astype(str)


def stopped_winds(wind: History, cuts: int, length: float) -> list[History]:
    """Return the wind, and the same with so many sudden stops, at even instants.

    `InputError` for cuts that are not a whole number up to 1000, or make too many samples of a
    length [s].
    """
    stops = whole_number("cuts", cuts)
    if stops > _MOST_CUTS:
        raise InputError(f"cuts must be at most {_MOST_CUTS}; got {shown(cuts)}")
    start, end = float(wind.onset), float(wind.end)
    if (stops + 1) * (end - start) / length > _SAMPLES:
        raise InputError(
            f"cuts and sample_rate may make at most {_SAMPLES:g} samples of all winds; got"
            f" {stops + 1} times {end - start:.6g} s at {1.0 / length:.6g} Hz"
        )
    check_samples(end - start, length)
    return [wind, *(wind.before(t) for t in np.linspace(start, end, stops + 2)[1:-1])]


_LIMITS = (1e-6, 1e6)
"""Limits that may be tried, over the largest trim deflection."""
_CREEPS = 1e-5
"""A mode that grows more slowly, over the fastest pole of the plant, is held within rounding."""


@dataclass(frozen=True, eq=False)
class ClosedLoopBoundary(Shown):
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
    survives: BoolArray
    looked: tuple[tuple[float, float], ...]
    growth: float
    creeps: bool
    status: str

    _keys = "limit_over_trim=limit deflection_deg looked growth_per_s status"

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
    gain: float = 1.0,
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
    gain : float
        Factor on what the law asks for, as of `fly_many`.
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
        For batches, a plant without a real unstable pole, a wind that never ends, and samples
        that are far too long for the actuator.

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
    factor = number("gain", gain, positive)
    low, high = (
        number(name, number(name, value, positive), between(*_LIMITS))
        for name, value in (("lowest", lowest), ("highest", highest))
    )
    if low >= high:
        raise InputError(f"highest must be above lowest; got {high:.6g} and {low:.6g}")
    late = float(check_delays(number("delay", delay, nonnegative, "s"), np.asarray(length)))
    scale = abs(float(plant.coefficients.B) * float(wind.peak))
    check_pace(plant, length)
    winds = stopped_winds(wind, cuts, length)
    nozzle: dict[str, Any] = {"rate_limit": most_rate, "actuator": actuator, "gain": factor}
    outcomes = partial(fly_many, plant, law, sample_rate=1.0 / length, delay=late, **nozzle)
    flown, most = count(1), (1 + LEVELS) * len(winds)

    def tell() -> None:
        if progress is not None:
            progress(min(next(flown), most), most)

    def survives(limits: FloatArray) -> NDArray[np.str_]:
        def status(one: History, some: BoolArray) -> NDArray[np.str_]:
            tried = np.minimum(limits[some] * scale, LARGEST_LIMIT)
            return outcomes(wind=one, deflection_limit=tried).status

        return in_all(winds, status, limits.size, tell)

    with repeated(most):
        edge = edge_above_losses(survives, np.linspace(low, high, STEPS + 1))
    at = edge.limit if np.isfinite(edge.limit) else high
    hardware = Hardware(length, late, actuator, most_rate)
    batch = one_flight(plant, law, wind, at * scale, hardware, factor)
    worst, fastest = worst_near_rest(batch), float(modes.poles[0])
    creeps = worst.real > _CREEPS * fastest
    words = [edge.status] if edge.status != OK else []
    words += [_grows(worst, fastest)] if creeps else []
    return ClosedLoopBoundary(
        limit=edge.limit,
        deflection=-edge.limit * float(plant.coefficients.B) * float(wind.peak),
        scan=edge.scan,
        survives=edge.found == SURVIVED,
        looked=edge.looked,
        growth=worst.real,
        creeps=creeps,
        status="; ".join(words) or OK,
    )


def _grows(worst: complex, fastest: float) -> str:
    """What grows near rest, in words; a mode that turns slowly beside the fastest pole is real."""
    if worst.imag > SLOW * fastest:
        return (
            f"near rest an oscillation of {worst.imag:.3g} rad/s grows with {worst.real:+.3g} 1/s"
        )
    return f"near rest a real mode grows with {worst.real:+.3g} 1/s"


_MOST = 2_000
"""Boundaries in a map."""


@dataclass(frozen=True, eq=False)
class BoundaryMap(Shown):
    """The boundary of a law in a wind, over gain and delay.

    Attributes
    ----------
    gains : ndarray
        Factors on what the law asks for, ``(n,)``.
    delays : ndarray
        Computing delays [s], ``(m,)``.
    limit : ndarray
        Least limit with which the law survives, over ``|B alpha_w,max|``, ``(n, m)``; infinite
        where none that was tried does.
    growth : ndarray
        How fast the loop grows near rest [1/s], ``(n, m)``; where it is positive the loop rings,
        whatever the boundary.
    full_trim : float
        ``|B alpha_w,max|`` [rad].
    """

    gains: FloatArray
    delays: FloatArray
    limit: FloatArray
    growth: FloatArray
    full_trim: float

    _keys = "gains delays_s limit_over_trim=limit"


def boundary_map(
    plant: AnyPlant,
    law: Law,
    wind: History,
    gains: ArrayLike,
    delays: ArrayLike,
    *,
    rate_limit: float = np.inf,
    actuator: Actuator | None = None,
    sample_rate: float = 100.0,
    cuts: int = 0,
    lowest: float = 0.02,
    highest: float = 2.0,
) -> BoundaryMap:
    """Return the boundary of a law over the gain and the delay of its loop.

    Parameters
    ----------
    plant, law, wind
        As of `closed_loop_boundary`.
    gains : array_like
        Factors on what the law asks for, positive and rising, ``(n,)``.
    delays : array_like
        Computing delays [s], rising, ``(m,)``.
    rate_limit, actuator, sample_rate, cuts, lowest, highest
        As of `closed_loop_boundary`.

    Raises
    ------
    InputError
        As `closed_loop_boundary`, for gains or delays that do not rise, and for more than 2000
        boundaries.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> law = tv.SaturatedLaw(tv.control.canonical_gains(plant.coefficients))
    >>> wind = tv.TriangularWind(peak=0.1, duration=8.0)
    >>> gains, delays = [1.0, 2.0, 4.0], [0.0, 0.3]
    >>> found = tv.flights.boundary_map(plant, law, wind, gains, delays, sample_rate=25)
    >>> found.limit.round(2).tolist()
    [[1.39, 1.58], [0.99, 1.05], [0.82, 0.83]]
    """
    factors = positive("gains", one_row("gains", gains))
    late = nonnegative("delays", one_row("delays", delays, "s"), "s")
    for name, row in (("gains", factors), ("delays", late)):
        if not np.all(np.diff(row) > 0.0):
            raise InputError(f"{name} must rise; got {shown(row)}")
    if factors.size * late.size > _MOST:
        raise InputError(
            f"gains and delays may make at most {_MOST} boundaries; got {factors.size} times"
            f" {late.size}"
        )
    found = [
        [
            closed_loop_boundary(
                plant,
                law,
                wind,
                rate_limit=rate_limit,
                actuator=actuator,
                sample_rate=sample_rate,
                delay=delay,
                gain=gain,
                cuts=cuts,
                lowest=lowest,
                highest=highest,
            )
            for delay in late.tolist()
        ]
        for gain in factors.tolist()
    ]
    return BoundaryMap(
        gains=factors,
        delays=late,
        limit=np.array([[one.limit for one in row] for row in found]),
        growth=np.array([[one.growth for one in row] for row in found]),
        full_trim=abs(float(plant.coefficients.B) * float(wind.peak)),
    )
