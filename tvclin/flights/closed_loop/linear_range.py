"""Flights that settle slowly in the linear range of their loop, decided by its modes.

Near a stability limit a loop takes thousands of time constants to settle. Its state is then a sum
of modes, x_k = sum_j v_j c_j z_j^k, and if all of them decay, every later command is bounded by sum
``|r v_j c_j|``, r being the row of the command. Within the limits of the nozzle the loop stays
linear and the flight survives; it need not be flown to its end.
"""

from __future__ import annotations

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.control.autopilot.actuator import Actuator
from tvclin.flights.closed_loop.batch import Batch, flights, frequency, spread_to
from tvclin.flights.closed_loop.sampled import finish
from tvclin.flights.closed_loop.sampled_stability import loop_steps
from tvclin.kernels.flight_arrays import NEVER, SURVIVED, UNDECIDED, Cases, Flights, FlightStates
from tvclin.kernels.flights import JUDGED_SAMPLES

_SETTLING_TIMES = 10
"""Time after the wind, over the settling time, after which the modes of a flight decide it."""
_MIN_DECAY = 1e-10
"""Smallest decay 1 - ``|z|`` of a mode in a sample; smaller ones may be rounding."""
_DECAYED = 1e-12
"""Fraction of its amplitude at the end of the wind below which a mode is neglected."""
_RELATIVE_TOLERANCE = 1e-6
"""Largest part of a state that is not of the remaining modes, over their amplitudes."""


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
    slow = _has_linear_law(f, batch) & (f.cases.finish == NEVER) & (pause < waiting)
    start = FlightStates._make(array.copy() for array in f.now) if np.any(slow) else f.now
    np.copyto(f.cases.waiting, pause, where=slow)
    finish(f, batch.laws)
    np.copyto(f.cases.waiting, waiting)
    undecided = np.flatnonzero(slow & (f.now.outcome == UNDECIDED))
    if not undecided.size:
        return
    decided = remain_linear(batch, f, undecided)
    f.now.outcome[undecided[decided]] = SURVIVED
    rest = undecided[~decided]
    if rest.size:  # flown once more, to the end of their waiting time
        cases, now = ((array[rest] for array in arrays) for arrays in (f.cases, start))
        again = f._replace(cases=Cases._make(cases), now=FlightStates._make(now))
        finish(again, batch.laws)
        for array, flown in zip(f.now, again.now, strict=True):
            array[rest] = flown


def _has_linear_law(f: Flights, batch: Batch) -> BoolArray:
    """Return whether the law of each of m flights is linear below its limit, ``(m,)``.

    It is without noise, without a switch (`engage`) below the limit, and no recoverable-attitude
    law (`leans`); laws in Python, without numbers, are not known to be linear. `f`: arrays of the
    flights. `batch`: the flights.
    """
    linear = [
        numbers is not None and not numbers.leans and numbers.engage >= 1.0 and not noise
        for numbers, (noise, _) in zip(batch.laws.numbers, batch.laws.noise, strict=True)
    ]
    return np.array(linear, bool)[f.cases.law]


def remain_linear(batch: Batch, f: Flights, cases: IndexArray) -> BoolArray:
    """Return whether k flights in still air settle without reaching a limit, ``(k,)``.

    Sufficient, not necessary: all modes of the loop decay, those that have not decayed yet make up
    the state, and the sums of their amplitudes in command, deflection and rate are within the
    limits. The rate of the nozzle is at most the `overshoot` times that of its commands. `batch`:
    flights of linear laws. `f`: their arrays, at their ends. `cases`: indices of the k flights.
    """
    steps, rows = loop_steps(batch, f, cases)
    return np.array(
        [
            _remains_linear(f, i, steps[k], rows[k], overshoot)
            for k, (i, overshoot) in enumerate(
                zip(cases.tolist(), _overshoots(batch, f)[cases].tolist(), strict=True)
            )
        ],
        bool,
    )


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


def flown_by_modes(batch: Batch) -> Flights:
    """Return the flights of a batch at their ends, as arrays, each stopped when its end is known.

    A flight within its limits survives if its modes decay; see `finish_by_modes`.
    """
    f = flights(batch)
    finish_by_modes(f, batch)
    return f
