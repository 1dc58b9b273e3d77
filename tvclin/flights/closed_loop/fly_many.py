"""Many flights at once, each with a plant, a law, a wind and limits of its own.

A flight survives when it has settled well inside the recoverable set. If the loop is then damped in
its linear range, it may still have a limit cycle: a nozzle at its rate limit lags, and one at its
deflection limit has less gain. That is decided by a further flight in still air.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.base.cards import Shown
from tvclin.base.errors import (
    LATEST,
    InputError,
    between,
    broadcast,
    instance,
    number,
    numbers,
    positive,
    small_angle,
)
from tvclin.control.autopilot.actuator import Actuator, check_engine
from tvclin.flights.closed_loop.batch import Batch, Hardware, LawBatch, law_batch, shape_of
from tvclin.flights.closed_loop.checks import (
    FASTEST,
    MOST,
    check_delays,
    check_sample_rates,
    check_samples,
    check_span,
    paces,
)
from tvclin.flights.closed_loop.outcomes import SETTLING, WAITING, decidable
from tvclin.flights.closed_loop.sampled import finish, flown
from tvclin.flights.closed_loop.sampled_stability import swing_near_rest
from tvclin.kernels.flight_arrays import NEVER, Cases, Flights, Now
from tvclin.kernels.flight_arrays import SURVIVED as SURVIVED_CODE
from tvclin.kernels.flight_arrays import UNDECIDED as UNDECIDED_CODE
from tvclin.linear.flexible import AnyPlant, check_plant
from tvclin.winds.histories import History

_STRETCH = 0.5
"""A stretch is this part of the time in which a flight settles."""
_QUIET = 2
"""After so many stretches without a limit a nozzle is at rest."""
_FULL_RATE = 0.999
"""A rate above this part of its limit is bounded by it."""


def swings_on(f: Flights, laws: LawBatch) -> BoolArray:
    """Return which of the flights that were brought back still meet limits long afterwards.

    `f`: at their ends. `laws`: of the flights; those of a law with noise are not flown on.
    """
    silent = np.array([not level for level, _ in laws.noise])[f.cases.law]
    left = np.flatnonzero((f.now.outcome == SURVIVED_CODE) & silent & (f.cases.settling > 0))
    quiet, g = np.zeros(left.size, dtype=int), f
    where = left
    for _ in range(int(WAITING / (SETTLING * _STRETCH))):
        if not left.size:
            break
        g = _flown_on(g, where, laws)
        limited = (g.now.peaks[:, 5] > 0.0) | (g.now.peaks[:, 3] >= _FULL_RATE * g.cases.rate_limit)
        quiet = np.where(limited, 0, quiet + 1)
        where = np.flatnonzero(quiet < _QUIET)
        left, quiet = left[where], quiet[where]
    found = np.zeros(f.cases.limit.size, dtype=bool)
    found[left] = True
    return found


def _flown_on(f: Flights, where: IndexArray, laws: LawBatch) -> Flights:
    """Some flights from where they ended through a stretch of still air."""
    rows = {name: getattr(f.laws, name) for name in ("memory", "seen", "told")}
    rows = {name: one[where] if len(one) > 1 else one for name, one in rows.items()}
    g = f._replace(
        winds=f.winds._replace(pieces=np.zeros_like(f.winds.pieces)),
        laws=f.laws._replace(**rows),
        cases=Cases._make(one[where] for one in f.cases),
        now=Now._make(one[where] for one in f.now),
    )
    ring = g.now.commands.shape[1]
    turned = (g.now.ended[:, np.newaxis] + np.arange(ring)) % ring  # samples count from zero again
    g.now.commands[:] = np.take_along_axis(g.now.commands, turned, axis=1)
    g.cases.start[:] += g.now.ended * g.steps.lengths[g.cases.vehicle, 0]
    g.cases.finish[:] = np.maximum(np.ceil(_STRETCH * g.cases.settling), 1)
    g.cases.ends[:] = NEVER
    g.now.outcome[:], g.now.ended[:], g.now.peaks[:] = UNDECIDED_CODE, -1, 0.0
    finish(g, laws)
    return g


STATUS = ("undecided", "survived", "lost", "rings", "no flight")
UNDECIDED, SURVIVED, LOST, RINGS, NO_FLIGHT = STATUS
LARGEST_LIMIT = float(np.nextafter(np.pi / 2, 0.0))
"""Largest deflection limit [rad] of a flight: no nozzle turns by 90 degrees."""
_RINGING = 1e-5
"""1/s; an oscillation that grows more slowly is held within rounding."""


@dataclass(frozen=True, eq=False, repr=False)
class FlownCases(Shown):
    """The outcomes of many flights, each field in the shape of the batch.

    The largest values are those at samples, and rates of the nozzle are means over a step. All
    are sizes, and NaN where there was no flight.

    Attributes
    ----------
    peak_attitude, peak_attitude_rate : ndarray
        Largest attitude [rad] and attitude rate [rad/s].
    peak_deflection, peak_deflection_rate : ndarray
        Largest deflection [rad], and rate of the nozzle [rad/s].
    peak_angle_of_attack : ndarray
        Largest angle of attack [rad].
    final_attitude : ndarray
        Attitude at the end [rad], with its sign.
    end_time : ndarray
        When the flight ended [s].
    saturated_time_fraction : ndarray
        Part of the flight in which the whole limit was asked for.
    status : ndarray of str
        "survived", "lost", "undecided", or "no flight" where a case cannot be flown; "rings" where
        a vehicle is brought back and its nozzle keeps oscillating, see `fly_many`.
    """

    peak_attitude: FloatArray
    peak_attitude_rate: FloatArray
    peak_deflection: FloatArray
    peak_deflection_rate: FloatArray
    peak_angle_of_attack: FloatArray
    final_attitude: FloatArray
    end_time: FloatArray
    saturated_time_fraction: FloatArray
    status: NDArray[np.str_]

    @property
    def counts(self) -> dict[str, int]:
        """How many flights have each status that occurs, the most frequent first."""
        return dict(Counter(self.status.ravel().tolist()).most_common())

    _keys = "counts peak_attitude_deg peak_deflection_deg peak_angle_of_attack_deg"


def fly_many(
    plant: AnyPlant,
    law: Any,
    wind: History,
    *,
    deflection_limit: ArrayLike,
    rate_limit: ArrayLike = np.inf,
    actuator: Actuator | None = None,
    sample_rate: ArrayLike,
    delay: ArrayLike = 0.0,
    gain: ArrayLike = 1.0,
    until: float | None = None,
) -> FlownCases:
    """Return the outcomes of many flights of laws with limits, each from rest.

    Plants, laws, winds, limits and actuators broadcast: one law, designed on the nominal plant,
    for a thousand dispersed plants and winds, or a thousand limits for one plant.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        One plant or a batch. Of a flexible one a law sees what its sensors say.
    law : Law, array of Law, or Autopilot
        An `Autopilot` with a batch of gains stands for a `SaturatedLaw` of each.
    wind : History
        One wind or a batch; each must end.
    deflection_limit, rate_limit : array_like
        Largest deflection [rad], within 90 degrees, and deflection rate [rad/s], positive.
    actuator : Actuator, optional
        One or a batch. Without one the deflection follows its command at once.
    sample_rate : array_like
        Samples of the laws in a second [Hz], the first at the onset of the wind, as of `fly`.
    delay : array_like
        Computing delay [s], from a sample to when its command takes effect; any, not only whole
        samples.
    gain : array_like
        Factor on what a law asks for, positive, ahead of its switch and of the limit.
    until : float, optional
        When the flights end [s], not before the wind does. Without it each ends when it is lost or
        saved, which needs one or two real unstable poles.

    Returns
    -------
    FlownCases
        Largest values and outcomes. A flight is lost when after its wind it leaves the recoverable
        set of its unstable modes, and survives when it has settled well inside. One that does
        so rings where an oscillation of its loop grows near rest, of bending or slosh most often,
        for then the nozzle will swing from stop to stop; and a flexible vehicle also where its
        nozzle, flown on in still air, does not come to rest between its limits. A case whose limit
        is not positive or not within 90 degrees, or whose wind is nothing, never ends or lasts for
        more than a million samples, is "no flight", and so is one that could never be decided; the
        others go on.

    Raises
    ------
    InputError
        For shapes that do not broadcast, a single limit that is not positive or not within 90
        degrees, a gain that is not positive, flights that end before their wind, a delay below
        zero, and samples in which the actuator turns more than a hundred times.

    Notes
    -----
    A sample is exact, the wind with all its breakpoints included, in which the nozzle meets no
    limit. One in which it does is walked in substeps of 1/8 of the time 1/omega of the actuator, if
    it is longer than half of that. In a substep in which its rate or its stop bounds it the
    deflection goes evenly from where it begins to where it ends, which is exact while it stays
    bounded; where it does not, the attitude is good for 3e-4 of its largest value, and for less
    where a flight is nearly lost or the nozzle chatters between its rate limits (1.4e-3 in the
    worst of 40 flights). A rate limit without an actuator spreads each step of the command over
    the whole sample, so that it acts up to half a sample late: the attitude is then good for no
    more than 6e-2 of its largest value at 10 Hz and 2e-2 at 25 Hz. Laws of the package are compiled
    (extra `fast`); without numba a second of flight at 100 Hz takes some milliseconds. A law
    written in Python is asked at every sample for all its flights at once.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> wind = tv.TriangularWind(peak=0.1, duration=8.0)
    >>> limits = np.array([0.6, 0.68, 0.7, 0.9]) * 0.01
    >>> flown = tv.fly_many(plant, tv.TrimLaw(plant), wind, deflection_limit=limits,
    ...                     sample_rate=100.0)
    >>> flown.status.tolist()
    ['lost', 'lost', 'survived', 'survived']
    """
    check_plant(plant)
    instance("wind", wind, History, "such as TriangularWind")
    limits = {"deflection_limit": deflection_limit, "rate_limit": rate_limit}
    limit, most = (_limit(name, value) for name, value in limits.items())
    rate = check_sample_rates(sample_rate, actuator)
    check_engine(plant, actuator)
    late = check_delays(delay, 1.0 / rate)
    factor = positive("gain", gain)
    shape = broadcast(
        plant=plant.batch,
        law=shape_of(law),
        wind=wind.batch,
        deflection_limit=limit.shape,
        rate_limit=most.shape,
        actuator=() if actuator is None else actuator.batch,
        sample_rate=rate.shape,
        delay=late.shape,
        gain=factor.shape,
    )
    laws = law_batch(law, shape)
    stop = np.inf if until is None else number("until", until, between(-LATEST, LATEST), "s")
    if until is not None:
        last = float(np.max(wind.end, initial=-np.inf, where=np.isfinite(wind.end)))
        if stop < last:
            raise InputError(
                f"until must not lie before the end of the wind, {last:.6g} s: what blows later is"
                f" not flown; got {stop:.6g} s"
            )
        span = stop - float(np.min(wind.onset, initial=stop))
        check_span(0.0, span)
        check_samples(span, 1.0 / float(rate.max(initial=0.01)))
    factor, limit, most = (np.broadcast_to(a, shape) for a in (factor, limit, most))
    good = (limit > 0.0) & (limit <= LARGEST_LIMIT) & (most > 0.0) & np.isfinite(wind.end)
    good &= paces(plant) <= FASTEST * rate
    good &= (stop < np.inf) | ((wind.end - wind.onset) * rate <= MOST)
    good &= (stop < np.inf) | np.broadcast_to(decidable(plant), shape)
    hardware = Hardware(1.0 / rate, late, actuator, most)
    batch = Batch(plant, hardware, wind, laws, limit, shape, factor, stop)
    if not np.any(good):
        return _flown_cases(None, good, good)
    some = batch if np.all(good) else batch.only(good)
    f = flown(some)
    return _flown_cases(f, good, _rings(some, f))


def _rings(batch: Batch, f: Flights) -> BoolArray:
    """In which flights an oscillation grows near rest, or lives on between limits, ``(m,)``."""
    grows = swing_near_rest(batch, f) > _RINGING
    if batch.plant.structure is None:
        return grows
    return grows | swings_on(f, batch.laws)


def _flown_cases(f: Flights | None, good: BoolArray, rings: BoolArray) -> FlownCases:
    """What came of the flights; None where there were none."""
    outcome = np.full(good.shape, len(STATUS) - 1)
    if f is None:
        nothing = np.full(good.shape, np.nan)
        sizes = dict.fromkeys(FlownCases.__dataclass_fields__, nothing)
        return FlownCases(**{**sizes, "status": np.array(STATUS)[outcome]})

    def whole(values: FloatArray) -> FloatArray:
        found = np.full(good.shape, np.nan)
        found[good] = values
        return found

    h = f.steps.lengths[f.cases.vehicle, 0]
    brought_back = f.now.outcome == STATUS.index(SURVIVED)
    outcome[good] = np.where(brought_back & rings, STATUS.index(RINGS), f.now.outcome)
    return FlownCases(
        peak_attitude=whole(f.now.peaks[:, 0]),
        peak_attitude_rate=whole(f.now.peaks[:, 1]),
        peak_deflection=whole(f.now.peaks[:, 2]),
        peak_deflection_rate=whole(f.now.peaks[:, 3]),
        peak_angle_of_attack=whole(f.now.peaks[:, 4]),
        final_attitude=whole(f.now.y[:, 0]),
        end_time=whole(f.cases.start + f.now.ended * h),
        saturated_time_fraction=whole(f.now.peaks[:, 5] / np.maximum(f.now.ended, 1)),
        status=np.array(STATUS)[outcome],
    )


def _limit(name: str, value: ArrayLike) -> FloatArray:
    """A single limit must be in its range; among many a bad one is the matter of its case."""
    array = numbers(name, value)
    if array.ndim or (name == "rate_limit" and array == np.inf):
        return array
    if name == "rate_limit":
        return positive(name, value)
    return small_angle("a deflection", positive)(name, value)
