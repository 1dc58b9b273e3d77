"""Many flights at once, each with a plant, a law, a wind and limits of its own.

A flight survives when it has settled well inside the recoverable set. If the loop is then damped in
its linear range, it may still have a limit cycle: a nozzle at its rate limit lags, and one at its
deflection limit has less gain. That is decided by a further flight in still air.

Near a stability limit a loop takes thousands of time constants to settle. Its state is then a sum
of modes, x_k = sum_j v_j c_j z_j^k, and if all of them decay, every later command is bounded by sum
``|r v_j c_j|``, r being the row of the command. Within the limits of the nozzle the loop stays
linear and the flight survives; it need not be flown to its end.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.base import errors
from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.base.cards import Shown
from tvclin.base.fields import derived, spec
from tvclin.control.autopilot.actuator import Actuator, check_engine
from tvclin.flights.closed_loop.batch import Batch, Hardware, flights, frequency, spread_to
from tvclin.flights.closed_loop.checks import (
    MAX_POLE_TIMES_SAMPLE,
    MAX_SAMPLES,
    check_delays,
    check_sample_rates,
    check_samples,
    check_span,
    fastest_poles,
)
from tvclin.flights.closed_loop.law_batch import LawBatch, law_batch, shape_of
from tvclin.flights.closed_loop.outcomes import SETTLING, WAITING, decidable
from tvclin.flights.closed_loop.sampled import finish
from tvclin.flights.closed_loop.sampled_stability import loop_steps, oscillation_growth
from tvclin.kernels.flight_arrays import NEVER, Cases, Flights, FlightStates
from tvclin.kernels.flight_arrays import SURVIVED as SURVIVED_CODE
from tvclin.kernels.flight_arrays import UNDECIDED as UNDECIDED_CODE
from tvclin.kernels.flights import JUDGED_SAMPLES
from tvclin.linear.flexible import AnyPlant, check_plant
from tvclin.winds.histories import History

_SETTLING_TIMES = 10
"""Time after the wind, over the settling time, after which the modes of a flight decide it."""
_MIN_DECAY = 1e-10
"""Smallest decay 1 - ``|z|`` of a mode in a sample; smaller ones may be rounding."""
_DECAYED = 1e-12
"""Fraction of its amplitude at the end of the wind below which a mode is neglected."""
_RELATIVE_TOLERANCE = 1e-6
"""Largest part of a state that is not of the remaining modes, over their amplitudes."""
_INTERVAL_OVER_SETTLING = 0.5
"""Length of an interval of still air, over the settling time of a flight."""
_QUIET_INTERVALS = 2
"""Number of successive intervals without a limit after which a nozzle is in equilibrium."""
_RATE_AT_LIMIT = 0.999
"""Smallest rate that counts as limited, over the rate limit."""


def finish_by_modes(f: Flights, batch: Batch) -> None:
    """Step flights to their ends, in place; those that remain linear end when this is known.

    A flight that is undecided ten settling times after its wind ends there and survives, if its
    modes decay within the limits; all others end as by `finish`, at a fixed time, by their outcome,
    or `waiting` samples after the wind. `f`: arrays of the flights at their starts, changed in
    place. `batch`: the flights.
    """
    # numbers of samples after the wind: `waiting`, and `pause`, after which the modes decide, at
    # the next sample at which flights are judged; `finish` NEVER: a flight without a fixed end
    waiting, pause = f.cases.waiting.copy(), _SETTLING_TIMES * f.cases.settling
    pause = -(-pause // JUDGED_SAMPLES) * JUDGED_SAMPLES
    # laws that are linear below the limit, without noise, a switch (`engage`) below the limit, or
    # the lean of a recoverable attitude; those in Python, without numbers, are not known to be
    linear = [
        numbers is not None and not numbers.leans and numbers.engage >= 1.0 and not noise
        for numbers, (noise, _) in zip(batch.laws.numbers, batch.laws.noise, strict=True)
    ]
    is_linear = np.array(linear, bool)[f.cases.law]
    slow = is_linear & (f.cases.finish == NEVER) & (pause < waiting)
    start = FlightStates._make(array.copy() for array in f.now) if np.any(slow) else f.now
    np.copyto(f.cases.waiting, pause, where=slow)
    finish(f, batch.laws)
    np.copyto(f.cases.waiting, waiting)
    undecided = np.flatnonzero(slow & (f.now.outcome == UNDECIDED_CODE))
    if not undecided.size:
        return
    decided = remain_linear(batch, f, undecided)
    f.now.outcome[undecided[decided]] = SURVIVED_CODE
    rest = undecided[~decided]
    if rest.size:  # flown once more, to the end of their waiting time
        cases, now = ((array[rest] for array in arrays) for arrays in (f.cases, start))
        again = f._replace(cases=Cases._make(cases), now=FlightStates._make(now))
        finish(again, batch.laws)
        for array, flown in zip(f.now, again.now, strict=True):
            array[rest] = flown


def remain_linear(batch: Batch, f: Flights, cases: IndexArray) -> BoolArray:
    """Return whether k flights in still air settle without reaching a limit, ``(k,)``.

    Sufficient, not necessary: all modes of the loop decay, those that have not decayed yet make up
    the state, and the sums of their amplitudes in command, deflection and rate are within the
    limits. The rate of the nozzle is at most the `overshoot` times that of its commands. `batch`:
    flights of linear laws. `f`: their arrays, at their ends. `cases`: indices of the k flights.
    """
    steps, rows = loop_steps(batch, f, cases)
    overshoots = _overshoots(batch, f)[cases].tolist()
    remain = map(partial(_remains_linear, f), cases.tolist(), steps, rows, overshoots)
    return np.array(list(remain), bool)


def _remains_linear(
    f: Flights, i: int, step: FloatArray, row: FloatArray, overshoot: float
) -> bool:
    """Return whether flight i remains in its linear range and settles, by the modes of its loop.

    `f`: arrays of the flights, at their ends. `step`, `row`: step matrix of the loop, ``(n, n)``,
    and row of its command, ``(n,)``. `overshoot`: largest rate of the nozzle over that of its
    commands.
    """
    z, modes = np.linalg.eig(step)  # z: factor of each mode in a sample
    if np.abs(z).max() > 1.0 - _MIN_DECAY:
        return False
    ended, pending = f.now.ended[i], f.now.commands.shape[1]
    # the commands that have not arrived yet, latest first: that of sample k is at k mod `pending`
    late = f.now.commands[i][(ended - 1 - np.arange(pending - 1)) % pending]
    state = np.concatenate([f.now.y[i], f.now.states[i], late])
    # modes that have not decayed in the samples since the end of the wind
    remaining = np.abs(z) ** (ended - f.cases.ends[i]) > _DECAYED
    modes, z = modes[:, remaining], z[remaining]
    parts = modes * np.linalg.lstsq(modes, state.astype(complex))[0]  # of the state, by mode
    amplitudes = np.abs(parts).sum(axis=1)
    error = np.abs(state - parts.sum(axis=1))  # of the state by these modes alone
    if np.any(error > _RELATIVE_TOLERANCE * amplitudes + _DECAYED * np.abs(state).max()):
        return False
    n, h = f.vehicles.A.shape[1], f.steps.lengths[f.cases.vehicle[i], 0]  # h: length of a sample
    commands = row @ parts
    command, travel = np.abs(commands).sum(), overshoot * np.abs((z - 1.0) * commands).sum()
    # the deflection between two samples differs from that at a sample by the travel at most
    deflection = max(command, amplitudes[n] + travel)
    return bool(deflection < f.cases.limit[i] and travel < h * f.cases.rate_limit[i])


def _overshoots(batch: Batch, f: Flights) -> FloatArray:
    """Return bounds of the largest nozzle rate over the rate of commands, of m flights, ``(m,)``.

    Commands that change by less than d in each sample h move a nozzle with the impulse response g
    by less than d times the largest sum of ``|g(t + k h)|`` over k, and that is below the integral
    of ``|g|`` over h, plus the sum of its peaks. omega and zeta: frequency and damping ratio of the
    actuator. With the ratio r = exp(-pi zeta/sqrt(1 - zeta^2)) of a peak to the one before, the
    integral is (1 + r)/(1 - r), and the sum of the peaks below omega/(1 - r). r is zero of first
    order and for zeta >= 1; without an actuator the bound is one.
    `batch`, `f`: the flights, and their arrays.
    """
    actuator: Actuator | None = batch.hardware.actuator
    vehicle = f.cases.vehicle
    omega_h = spread_to(frequency(actuator), batch.vehicles)[vehicle] * f.steps.lengths[vehicle, 0]
    if actuator is None or actuator.damping is None:
        return 1.0 + omega_h
    damping = spread_to(np.asarray(actuator.damping, float), batch.vehicles)[vehicle]
    with np.errstate(divide="ignore"):
        exponent = np.pi * damping / np.sqrt(np.maximum(1.0 - damping**2, 0.0))
    ratio = np.exp(-exponent)
    return np.asarray((1.0 + ratio + omega_h) / (1.0 - ratio))


def has_limit_cycle(f: Flights, laws: LawBatch) -> BoolArray:
    """Return whether the nozzle of each of m flights reaches limits long after its wind, ``(m,)``.

    Flights that survive, of laws without noise, are continued in still air, until their nozzle has
    reached no limit in two successive intervals. `f`: arrays of the flights at their ends. `laws`:
    their laws.
    """
    silent = np.array([not level for level, _ in laws.noise])[f.cases.law]
    # without noise, surviving, and with a settling time, in whose fractions intervals are counted
    active = np.flatnonzero((f.now.outcome == SURVIVED_CODE) & silent & (f.cases.settling > 0))
    quiet, g = np.zeros(active.size, dtype=int), f  # intervals without a limit; continued flights
    indices = active  # of the active flights in g
    for _ in range(int(WAITING / (SETTLING * _INTERVAL_OVER_SETTLING))):
        if not active.size:
            break
        g = _continuation(g, indices, laws)
        # Peaks 3 and 5: deflection rate, and number of samples with a demand at the limit.
        at_rate_limit = g.now.peaks[:, 3] >= _RATE_AT_LIMIT * g.cases.rate_limit
        limited = (g.now.peaks[:, 5] > 0.0) | at_rate_limit
        quiet = np.where(limited, 0, quiet + 1)
        indices = np.flatnonzero(quiet < _QUIET_INTERVALS)
        active, quiet = active[indices], quiet[indices]
    cycles = np.zeros(f.cases.limit.size, dtype=bool)
    cycles[active] = True
    return cycles


def _continuation(f: Flights, indices: IndexArray, laws: LawBatch) -> Flights:
    """Return the flights at `indices` after a further interval, in still air.

    Time goes on from the end of a flight, with its states, the matrices of its last sample, and its
    pending commands, which are kept in a ring; samples count from zero again. `f`: arrays of all
    flights at their ends; `now.ended` is the last sample. `laws`: laws of the flights.
    """
    # g: arrays of the flights in the further interval
    g = f._replace(
        winds=f.winds._replace(pieces=np.zeros_like(f.winds.pieces)),
        cases=Cases._make(array[indices] for array in f.cases),
        now=FlightStates._make(array[indices] for array in f.now),
        track=f.track[:0],
    )
    size = g.now.commands.shape[1]  # of the ring, in which sample k has the place k modulo size
    places = (g.now.ended[:, np.newaxis] + np.arange(size)) % size  # the last sample becomes 0
    g.now.commands[:] = np.take_along_axis(g.now.commands, places, axis=1)
    sample_length = g.steps.lengths[g.cases.vehicle, 0]  # [s]
    g.cases.start[:] += g.now.ended * sample_length
    g.cases.finish[:] = np.maximum(np.ceil(_INTERVAL_OVER_SETTLING * g.cases.settling), 1)
    g.cases.ends[:] = NEVER  # not judged
    g.cases.stages[:] = 1  # the same matrices at all samples
    g.now.outcome[:], g.now.ended[:], g.now.peaks[:] = UNDECIDED_CODE, -1, 0.0
    finish(g, laws)
    return g


STATUS = ("undecided", "survived", "lost", "rings", "no flight")
UNDECIDED, SURVIVED, LOST, RINGS, NO_FLIGHT = STATUS
NOT_KNOWN = "not known"
"""Status of a flight in a wind beyond linear aerodynamics, or of which parts are not known."""
OUTCOME_WORDS = {
    "survived": "survives",
    "lost": "is lost",
    "rings": "is brought back, and its nozzle keeps oscillating",
    "undecided": "is neither lost nor settled",
    "no flight": "cannot be flown",
    NOT_KNOWN: "is not known to survive",
}
"""Outcomes of a flight in words, by the status of `FlownCases`."""
MAX_DEFLECTION_LIMIT = float(np.nextafter(np.pi / 2, 0.0))
"""Largest deflection limit [rad] of a flight: no nozzle turns by 90 degrees."""
_MIN_GROWTH = 1e-5
"""Smallest growth rate [1/s] of an unstable oscillation; below it may be rounding."""


@dataclass(frozen=True, eq=False, repr=False)
class FlownCases(Shown):
    """Outcomes of many flights, each field in the shape of the batch.

    Peaks are magnitudes at samples, and nozzle rates means over a step; NaN without a flight.

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
        Time of the end of the flight [s].
    saturated_time_fraction : ndarray
        Fraction of the flight in which the demand was at or above the limit.
    status : ndarray of str
        "survived", "lost", "undecided", or "no flight" for a case that is not possible; "rings" for
        a vehicle that returns while its nozzle keeps oscillating, see `fly_many`.
    """

    peak_attitude: FloatArray = field(metadata=spec("angle"))
    peak_attitude_rate: FloatArray
    peak_deflection: FloatArray = field(metadata=spec("angle"))
    peak_deflection_rate: FloatArray
    peak_angle_of_attack: FloatArray = field(metadata=spec("angle"))
    final_attitude: FloatArray
    end_time: FloatArray
    saturated_time_fraction: FloatArray
    status: NDArray[np.str_]

    @property
    @derived()
    def counts(self) -> dict[str, int]:
        """Number of flights of each status, the most frequent first."""
        return dict(Counter(self.status.ravel().tolist()).most_common())


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
    """Return the outcomes of many flights of laws with limits, each from equilibrium.

    Plants, laws, winds, limits and actuators broadcast: one law, designed on the nominal plant,
    for a thousand dispersed plants and winds, or a thousand limits for one plant.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        One plant or a batch. For a flexible plant the law measures the outputs of its sensors.
    law : Law, array of Law, or Autopilot
        An `Autopilot` with a batch of gains means a `SaturatedLaw` for each.
    wind : History
        One wind or a batch; each must end.
    deflection_limit, rate_limit : array_like
        Largest deflection [rad], within 90 degrees, and deflection rate [rad/s], positive.
    actuator : Actuator, optional
        One actuator or a batch. Without it the deflection equals its command.
    sample_rate : array_like
        Samples of the laws per second [Hz], the first at the onset of the wind.
    delay : array_like
        Computing delay [s] from a sample to the effect of its command, a whole number of samples or
        not.
    gain : array_like
        Factor on the demand of a law, positive, before its switch and the limit.
    until : float, optional
        End of the flights [s], not before the end of the wind. Without it each flight ends when it
        is lost or settled, which requires one or two real unstable poles.

    Returns
    -------
    FlownCases
        Peaks and outcomes. A flight is lost when after its wind it leaves the recoverable set of
        its unstable modes, and survives when it has settled well inside; also, of a linear law,
        when it settles slowly, but its modes show that it does and reaches no limit: it ends then,
        fifty time constants of the fastest unstable pole after its wind. A surviving flight "rings"
        if an oscillation of its loop is unstable in the linear range, of bending or slosh most
        often, because the nozzle then has a limit cycle; a flexible vehicle also if its nozzle,
        continued in still air, does not settle between its limits. A case whose limit is not
        positive or not within 90 degrees, whose wind is zero, never ends or lasts more than a
        million samples, or whose outcome could never be decided, is "no flight"; the other cases
        are flown.

    Raises
    ------
    InputError
        For shapes that do not broadcast, a single limit that is not positive or not within 90
        degrees, a gain that is not positive, flights that end before their wind, a delay below
        zero, and samples in which the actuator turns more than a hundred times.

    Notes
    -----
    Samples in which the nozzle reaches no limit are exact, with all breakpoints of the wind. Other
    samples, if longer than half of the time 1/omega of the actuator, are divided into substeps of
    1/8 of that time. In a substep in which the rate or the deflection is limited, the deflection is
    a straight line from its start to its end, which is exact while it stays limited; otherwise the
    attitude is accurate to 3e-4 of its largest value, and less if a flight is nearly lost or the
    nozzle chatters between its rate limits (1.4e-3 in the worst of 40 flights). A rate limit
    without an actuator spreads each step of the command over the whole sample, so that it acts up
    to half a sample late: the attitude is then accurate to 6e-2 of its largest value at 10 Hz and
    2e-2 at 25 Hz. Laws of the package are compiled (extra `fast`); without numba a second of flight
    at 100 Hz takes some milliseconds. A law written in Python is called at every sample for all its
    flights at once.

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
    errors.instance("wind", wind, History, "such as TriangularWind")
    limits = {"deflection_limit": deflection_limit, "rate_limit": rate_limit}
    limit, max_rate = (_limit(name, value) for name, value in limits.items())
    rate = check_sample_rates(sample_rate, actuator)
    check_engine(plant, actuator)
    delays = check_delays(delay, 1.0 / rate)
    factor = errors.positive("gain", gain)
    shape = errors.broadcast(
        plant=plant.batch,
        law=shape_of(law),
        wind=wind.batch,
        deflection_limit=limit.shape,
        rate_limit=max_rate.shape,
        actuator=() if actuator is None else actuator.batch,
        sample_rate=rate.shape,
        delay=delays.shape,
        gain=factor.shape,
    )
    laws = law_batch(law, shape)
    stop = np.inf
    if until is not None:
        allowed = errors.between(-errors.MAX_TIME, errors.MAX_TIME)
        stop = errors.number("until", until, allowed, "s")
        end = float(np.max(wind.end, initial=-np.inf, where=np.isfinite(wind.end)))
        if stop < end:
            raise errors.InputError(
                f"until must not lie before the end of the wind, {end:.6g} s: what blows later is"
                f" not flown; got {stop:.6g} s"
            )
        span = stop - float(np.min(wind.onset, initial=stop))
        check_span(0.0, span)
        check_samples(span, 1.0 / float(rate.max(initial=0.01)))
    factor, limit, max_rate = (np.broadcast_to(a, shape) for a in (factor, limit, max_rate))
    # cases that can be flown; the others are "no flight"
    possible = (
        (limit > 0.0) & (limit <= MAX_DEFLECTION_LIMIT) & (max_rate > 0.0) & np.isfinite(wind.end)
    )
    possible &= fastest_poles(plant) <= MAX_POLE_TIMES_SAMPLE * rate
    # without a given end a flight lasts until its outcome is decided
    possible &= (stop < np.inf) | ((wind.end - wind.onset) * rate <= MAX_SAMPLES)
    possible &= (stop < np.inf) | np.broadcast_to(decidable(plant), shape)
    hardware = Hardware(1.0 / rate, delays, actuator=actuator, rate_limit=max_rate)
    batch = Batch(plant, hardware, wind, laws, limit=limit, shape=shape, gain=factor, until=stop)
    if not np.any(possible):
        return flown_cases(None, possible, rings=possible)  # no case: nothing rings
    flyable = batch if np.all(possible) else batch.only(possible)
    f = flights(flyable)
    finish_by_modes(f, flyable)
    return flown_cases(f, possible, unstable_loops(flyable, f))


def status_by_limit(flight: Batch) -> Callable[[FloatArray], NDArray[np.str_]]:
    """Return the function from deflection limits [rad], ``(n,)``, to the status of their flights.

    `flight`: batch of one flight, whose own limit is not used. Its matrices are computed once; the
    outcomes are as of `fly_many` for limits that are positive and within 90 degrees.
    """
    if not np.all(decidable(flight.plant)):
        return lambda limits: np.full(limits.shape, NO_FLIGHT)
    start = flights(flight)  # arrays of the kernel at the start of the flight

    def status(limits: FloatArray) -> NDArray[np.str_]:
        """Return the status of the `flight` with each of the limits [rad], ``(n,)``."""
        # the single row of each array, once for each limit
        cases, now = (
            (np.repeat(array, limits.size, axis=0) for array in arrays)
            for arrays in (start.cases, start.now)
        )
        f = start._replace(cases=Cases._make(cases), now=FlightStates._make(now))
        f.cases.limit[:] = limits
        finish_by_modes(f, flight)  # changes f in place
        possible = np.ones(limits.shape, bool)  # the flight itself is decidable, whatever its limit
        return flown_cases(f, possible, rings=unstable_loops(flight, f)).status

    return status


def unstable_loops(batch: Batch, f: Flights) -> BoolArray:
    """Return whether the loop of each flight is unstable or has a limit cycle, ``(m,)``.

    Unstable is an oscillation in the linear range, below all limits; the limit cycle is looked for
    only with modes of bending or slosh. `batch`: the flights. `f`: their arrays at their ends.
    """
    unstable = oscillation_growth(batch, f) > _MIN_GROWTH
    if not batch.plant.has_modes:
        return unstable
    return unstable | has_limit_cycle(f, batch.laws)


def flown_cases(f: Flights | None, possible: BoolArray, rings: BoolArray) -> FlownCases:
    """Return the outcomes of all cases of a batch; NaN and "no flight" where none is possible.

    `f`: arrays of the kernel, at their ends, of the k flights of the possible cases; None without
    any. `possible`: whether each case is possible, of the shape of the batch. `rings`: whether the
    loop of each flight keeps oscillating, ``(k,)``, which makes "rings" of "survived".
    """
    outcome = np.full(possible.shape, len(STATUS) - 1)  # "no flight", the last of them
    if f is None:
        nothing = np.full(possible.shape, np.nan)
        sizes = dict.fromkeys(FlownCases.__dataclass_fields__, nothing)
        return FlownCases(**{**sizes, "status": np.array(STATUS)[outcome]})

    def in_batch_shape(values: FloatArray) -> FloatArray:
        """Return the k values of the possible cases in the shape of the batch, else NaN."""
        array = np.full(possible.shape, np.nan)
        array[possible] = values
        return array

    h = f.steps.lengths[f.cases.vehicle, 0]
    attitude, attitude_rate, deflection, deflection_rate, alpha, samples_at_limit = f.now.peaks.T
    survived = f.now.outcome == STATUS.index(SURVIVED)
    outcome[possible] = np.where(survived & rings, STATUS.index(RINGS), f.now.outcome)
    return FlownCases(
        peak_attitude=in_batch_shape(attitude),
        peak_attitude_rate=in_batch_shape(attitude_rate),
        peak_deflection=in_batch_shape(deflection),
        peak_deflection_rate=in_batch_shape(deflection_rate),
        peak_angle_of_attack=in_batch_shape(alpha),
        final_attitude=in_batch_shape(f.now.y[:, 0]),
        end_time=in_batch_shape(f.cases.start + f.now.ended * h),
        saturated_time_fraction=in_batch_shape(samples_at_limit / np.maximum(f.now.ended, 1)),
        status=np.array(STATUS)[outcome],
    )


def _limit(name: str, value: ArrayLike) -> FloatArray:
    """Return limits [rad] or [rad/s] as an array; `InputError` for a single one out of range.

    Of an array such limits are "no flight", and the others are flown. `name`: name of the argument,
    "deflection_limit" or "rate_limit". `value`: its value.
    """
    array = errors.numbers(name, value)
    if array.ndim or (name == "rate_limit" and array == np.inf):
        return array
    if name == "rate_limit":
        return errors.positive(name, value)
    return errors.small_angle("a deflection", errors.positive)(name, value)
