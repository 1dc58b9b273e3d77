"""The least deflection limit with which a law survives a wind, decided without a horizon.

After the wind a flight is lost for good when its state leaves the recoverable set of the unstable
modes, and saved when it has settled well inside. That is the wind survived; it says nothing of a
slow mode which the law itself does not hold (its margins do). Survival need not grow with the
limit (a law that leans further may be further out when the wind turns), so limits are scanned
before the edge is refined, and the edge is that above the highest limit that is lost.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tvclin.autopilot import Actuator
from tvclin.closed_loop.airframe import Nozzle, Steps, steps
from tvclin.closed_loop.checks import check_flight, check_rate_limit, check_sample_rate
from tvclin.closed_loop.sampled import Sampler, at_rest
from tvclin.errors import InputError, number, positive
from tvclin.histories import History
from tvclin.laws import Law
from tvclin.plant import Plant
from tvclin.recoverable import UnstableCoordinates, unstable_coordinates

FloatArray = NDArray[np.float64]

OK = "ok"
NEVER = "no limit in the range survives"
ALWAYS = "every limit in the range survives"
_SCAN = 61
_ROUNDS = 2
_SETTLED = 0.3
"""Saved: every coordinate is below this part of the reach for a while."""
_CALM = 5.0
"""So long, over the fastest pole."""
_PATIENCE = 60.0
"""A flight that is neither lost nor saved by so long after the wind, over the slowest pole."""
_EVERY = 8
"""Steps between two looks."""


@dataclass(frozen=True, eq=False)
class ClosedLoopBoundary:
    """The boundary of a law in a wind.

    Attributes
    ----------
    limit : float
        Least limit above which every limit of the scan survives, over |B alpha_w,max|; infinite
        if the largest does not.
    deflection : float
        The same [rad].
    scan : ndarray
        The limits that were tried, rising, over |B alpha_w,max|.
    survives : ndarray of bool
        Which of them survive.
    status : str
        "ok", or in words why the limit is an end of the range.
    """

    limit: float
    deflection: float
    scan: FloatArray
    survives: NDArray[np.bool_]
    status: str

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
        Range of the limits that are tried, over |B alpha_w,max|.

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
    if isinstance(cuts, bool) or not isinstance(cuts, int) or cuts < 0:
        raise InputError(f"cuts must be an integer, zero or positive; got {cuts!r}")
    low, high = number("lowest", lowest, positive), number("highest", highest, positive)
    if low >= high:
        raise InputError(f"highest must be above lowest; got {high:.6g} and {low:.6g}")
    scale = abs(float(plant.coefficients.B * wind.peak))
    start, end = float(wind.onset), float(wind.end)
    winds = [wind, *(wind.before(t) for t in np.linspace(start, end, cuts + 2)[1:-1])]
    every = [steps(plant, one, start, float(one.end), length) for one in winds]

    def survive(limits: FloatArray) -> NDArray[np.bool_]:
        alive = np.ones(limits.size, dtype=bool)
        for one in every:
            sampler = Sampler(law, one, nozzle)
            alive[alive] = _survivors(sampler, modes, plant, limits[alive] * scale)
        return alive

    scan = np.linspace(low, high, _SCAN)
    alive = survive(scan)
    if not alive[-1]:
        return ClosedLoopBoundary(np.inf, np.inf, scan, alive, NEVER)
    if np.all(alive):
        return ClosedLoopBoundary(low, low * scale, scan, alive, ALWAYS)
    edge = int(np.flatnonzero(~alive)[-1])
    lost, saved = float(scan[edge]), float(scan[edge + 1])
    for _ in range(_ROUNDS):
        finer = np.linspace(lost, saved, _SCAN)[1:-1]
        found = survive(finer)
        last = int(np.flatnonzero(~found)[-1]) if not np.all(found) else -1
        lost, saved = (
            float(finer[last]) if last >= 0 else lost,
            float(finer[last + 1]) if last + 1 < finer.size else saved,
        )
    return ClosedLoopBoundary(saved, saved * scale, scan, alive, OK)


def _survivors(
    sampler: Sampler, modes: UnstableCoordinates, plant: Plant, limit: FloatArray
) -> NDArray[np.bool_]:
    """Which limits survive: flown through the wind, then until each is lost or saved."""
    alive = np.zeros(limit.size, dtype=bool)
    if not limit.size:
        return alive
    reach = abs(float(plant.coefficients.B))
    count = sampler.steps.gusts.shape[0]
    flights = at_rest(sampler.law, sampler.steps, sampler.nozzle, limit)
    flights = sampler.flown(flights, 0, count)
    length = sampler.nozzle.length
    calm = int(np.ceil(_CALM / modes.poles[0] / length))
    patience = int(np.ceil(_PATIENCE / modes.poles[-1] / length))
    after = Sampler(sampler.law, _without_wind(sampler.steps, patience), sampler.nozzle, still=True)
    where, quiet, done = np.arange(limit.size), np.zeros(limit.size, dtype=int), 0
    while where.size and done < patience:
        flights = after.flown(flights, done, done + _EVERY)
        done += _EVERY
        z = (modes.rows @ flights.airframe).T
        D = flights.limit / reach
        inside = modes.inside(z, D)
        settled = np.all(np.abs(z) < _SETTLED * D[:, np.newaxis], axis=-1)
        quiet = np.where(settled, quiet + _EVERY, 0)
        saved = inside & (quiet >= calm)
        alive[where[saved]] = True
        open_still = inside & ~saved
        where, quiet, flights = where[open_still], quiet[open_still], flights.take(open_still)
    return alive


def _without_wind(given: Steps, count: int) -> Steps:
    """The same plant in still air."""
    n = given.first.size
    times = given.times[-1] + np.arange(count + _EVERY + 1) * (given.times[1] - given.times[0])
    still = np.zeros(times.size)
    gusts = np.zeros((times.size - 1, n))
    return Steps(times, given.free, given.first, given.last, gusts, still)
