"""The least deflection limit with which a law survives a wind, decided without a horizon.

Survival need not grow with the limit (a law that leans further may be further out when the wind
turns), so limits are scanned, and the edge is that above the highest limit that does not survive
(see `edges`). To survive is to be brought back from the wind, with a nozzle that comes to rest (see
`fly_many`); a slow mode which the law then lets creep away is told apart from it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, between, callable_for, nonnegative, number, positive
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
from tvclin.flights.closed_loop.edges import (
    LEVELS,
    OK,
    STEPS,
    edge_above_losses,
    in_all,
    stopped_winds,
)
from tvclin.flights.closed_loop.growth import SLOW, worst_near_rest
from tvclin.flights.closed_loop.many import LARGEST_LIMIT, SURVIVED, fly_many
from tvclin.kernels.choice import repeated
from tvclin.linear.flexible import AnyPlant
from tvclin.winds.histories import History

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
