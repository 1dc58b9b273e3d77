"""Stability of sampled loops in their linear range, in still air and far below their limits.

One matrix M maps the states of vehicle, nozzle, law and filters and the pending commands from
sample to sample; log(z)/h of its eigenvalues z are the poles. M = A_e + g D_e is affine in the gain
g and in the effectiveness e of the nozzle; n whole samples of delay are the gain g z^-n. A mode
becomes unstable where it reaches the unit circle, at some z = e^(j theta) with

    1 = factor x l(z),    l = trace (z - M_0)^-1 (M_1 - M_0),

M_0 and M_1 being the steps for the factors zero and one: their difference acts through the one
command, so that l is its only eigenvalue other than zero.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from tvclin.base.arrays import ComplexArray, FloatArray, IndexArray
from tvclin.control.laws.law import Law, Measurement
from tvclin.flights.closed_loop.batch import Batch, flights
from tvclin.flights.closed_loop.outcomes import SETTLING
from tvclin.kernels.control_laws import LawNumbers, law_demand
from tvclin.kernels.flight_arrays import MEASURED, Flights
from tvclin.linear.system import split_delay

_DIFFERENCE_OVER_REACH = 1e-7
"""State of a finite difference, over the recoverable set: far below every limit and dead band."""
MIN_FREQUENCY_OVER_POLE = 0.1
"""Smallest frequency of an oscillation, over the fastest unstable pole; slower modes count as
real."""
_MAX_ROWS = 20_000
"""Largest number of matrix rows whose eigenvalues are computed at once."""
_OVERFLOW_EIGENVALUE = 1e100
"""Eigenvalue of a step whose entries are not finite."""


def dominant_pole(batch: Batch) -> complex:
    """Return the dominant pole log(z)/h [1/s] of one loop, with imaginary part >= 0.

    z is the eigenvalue of largest modulus of its step at equilibrium. The imaginary part is the
    frequency [rad/s] in the samples, at most pi times their rate. The length of a sample is h [s].
    `batch`: batch of one flight.
    """
    values = np.linalg.eigvals(equilibrium_step(batch)).astype(complex)
    worst = values[np.abs(values).argmax()]
    growth = np.log(max(abs(worst), np.finfo(float).tiny))
    return complex(growth, abs(np.angle(worst))) / float(batch.hardware.period)


def oscillation_growth(batch: Batch, f: Flights) -> FloatArray:
    """Return the largest growth rate [1/s] of an oscillation of each of m loops, ``(m,)``.

    It is log(r)/h, r being the largest modulus of an oscillating eigenvalue of the step, and h [s]
    the length of a sample; where none oscillates, r is the smallest positive number. Slow modes do
    not count: real positive eigenvalues of the step, and frequencies below a tenth of the fastest
    unstable pole, as the path's. `batch`: the loops. `f`: arrays of their flights, at any sample.
    """
    # Flights that differ in their limit alone have the same loop, unless their law depends on it.
    laws, of_flight = np.unique(f.cases.law, return_inverse=True)
    numbers = [batch.laws.numbers[k] for k in laws]
    # `leans`: recoverable-attitude law; the numbers of laws in Python are None
    depends = np.array([law is None or law.leans for law in numbers])[of_flight]
    limit = np.where(depends, f.cases.limit, 0.0)
    keys = np.column_stack([f.cases.vehicle, f.cases.law, f.cases.gain, limit])
    _, first, which = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    # states of the system and of the law, and delayed commands; blocks of loops bound the memory
    size = f.now.y.shape[1] + f.now.states.shape[1] + f.now.commands.shape[1]
    blocks = np.array_split(first, -(-first.size * size // _MAX_ROWS))
    step_matrices = (steps for steps, _ in (loop_steps(batch, f, block) for block in blocks))
    eigenvalues = np.concatenate([np.linalg.eigvals(steps) for steps in step_matrices])
    values = eigenvalues.astype(complex)[which.ravel()]
    h = f.steps.lengths[f.cases.vehicle, 0]
    frequencies = np.abs(np.angle(values)) / h[:, np.newaxis]
    # A flight settles in SETTLING/pole [s], `cases.settling` samples, which gives the pole
    slowest = MIN_FREQUENCY_OVER_POLE * SETTLING / np.maximum(f.cases.settling * h, h)
    oscillates = (frequencies > slowest[:, np.newaxis]) & (np.angle(values) != 0.0)
    radius = np.where(oscillates, np.abs(values), 0.0).max(axis=1, initial=np.finfo(float).tiny)
    return np.asarray(np.log(radius) / h)


def equilibrium_step(batch: Batch) -> FloatArray:
    """Return the step matrix M of one loop at equilibrium over a sample, ``(n, n)``.

    It acts on the states of vehicle, nozzle and law, and the pending commands, latest first.
    `batch`: batch of one flight.
    """
    steps, _ = loop_steps(batch, flights(batch), np.zeros(1, np.intp))
    return steps[0]  # of flight number 0


@np.errstate(over="ignore", invalid="ignore")
def loop_steps(batch: Batch, f: Flights, cases: IndexArray) -> tuple[FloatArray, FloatArray]:
    """Return step matrices of k loops at equilibrium, ``(k, n, n)``, and command rows ``(k, n)``.

    They act on the n states of `equilibrium_step`, and each signal of the loop is a matrix of its
    coefficients on them. The last `command_count` commands [rad], of which all but one are pending,
    are states. A matrix over a sample whose entries are not finite is replaced by one with a huge
    eigenvalue. `batch`, `f`: all flights, and their arrays. `cases`: indices of the k flights. The
    part of a sample with `index` 0 is the last: there a command that is `late` samples old acts,
    and before it, in the part with index 1, the one before.
    """
    k, arrays = cases.size, (f.now.y, f.now.states, f.now.commands)
    order, law_order, command_count = (array.shape[1] for array in arrays)
    vehicles, n = f.cases.vehicle[cases], f.vehicles.A.shape[1]
    size = order + law_order + command_count - 1
    x, law_states, pending = np.split(np.eye(size), [order, order + law_order])

    memory = f.cases.memory[cases]  # index of each flight's rows of the law with its filters

    def spread(rows: FloatArray) -> FloatArray:
        """Return rows of coefficients that are the same in all k flights, ``(k, rows, n)``."""
        return np.broadcast_to(rows, (k, *rows.shape[-2:]))

    # Sensors: attitude, rate, path and angle of attack, the deflection, then lateral sensors.
    shown = f.vehicles.shown[vehicles, :, :n] @ x[:n]
    not_measured = np.zeros((k, MEASURED - 1 - shown.shape[1], size))
    sensed = np.concatenate(
        [shown[:, :4], spread(x[n : n + 1]), shown[:, 4:], not_measured], axis=1
    )
    # Law: its states, the sensors and its demand give its inputs, the command and its next states.
    signals = np.concatenate([spread(law_states), sensed, spread(0.0 * x[:1])], axis=1)
    measured = f.laws.input_rows[memory] @ signals if len(f.laws.input_rows) else sensed
    # derivatives of the demand by measurements and states of the law
    slopes = f.cases.gain[cases, np.newaxis] * _slopes(batch, f, cases)
    demand = slopes[:, np.newaxis] @ np.concatenate([measured, spread(law_states)], axis=1)
    signals[:, -1:] = demand
    command = demand
    if len(f.laws.command_rows):
        command = f.laws.command_rows[memory][:, np.newaxis] @ signals
    commands = np.concatenate([command, spread(pending)], axis=1)
    # Vehicle and nozzle: the part of a sample before the arrival of a command, then the other.
    stepped = spread(x)
    for index in range(f.steps.joint.shape[1] - 1, -1, -1):
        age = (f.steps.late[vehicles] + index)[:, np.newaxis, np.newaxis]
        now = np.take_along_axis(commands, age, axis=1)
        J = f.steps.joint[vehicles, index]  # columns: states of vehicle and nozzle, the command
        stepped = J[..., :order] @ stepped + J[..., order : order + 1] @ now
    rows = [stepped, f.laws.memory[memory] @ signals, commands[:, : command_count - 1]]
    steps = np.concatenate(rows, axis=1)
    # A gain whose step matrix (last two axes) overflows is unstable.
    steps[~np.all(np.isfinite(steps), axis=(1, 2))] = -_OVERFLOW_EIGENVALUE * np.eye(size)
    return steps, command[:, 0]


def _slopes(batch: Batch, f: Flights, cases: IndexArray) -> FloatArray:
    """Return the derivatives of k demands by measurements and law states, ``(k, 8 + s)``.

    They are finite differences of 1e-7 of the recoverable set, the limit over B, far below every
    limit and dead band. s is the number of states of a law. `batch`, `f`: all flights, and their
    arrays. `cases`: indices of the k flights. A law has `numbers` if it runs in a kernel, and if
    these have `leans` (the recoverable-attitude law), its slopes depend on the limit of a flight.
    """
    # B, trim deflection per angle of attack, is the scale of the unstable coordinates
    largest_scale = max(float(np.abs(batch.plant.coordinate_scale).max()), 1.0)
    limits = f.cases.limit[cases]
    slopes = np.zeros((cases.size, MEASURED + f.now.states.shape[1]))
    for index in np.unique(f.cases.law[cases]).tolist():
        numbers, flights = batch.laws.numbers[index], np.flatnonzero(f.cases.law[cases] == index)
        law = batch.laws.laws[index] if numbers is None else numbers
        different = flights if numbers is None or numbers.leans else flights[:1]
        steps = _DIFFERENCE_OVER_REACH / largest_scale * limits[different]
        rows = [
            _slopes_of(law, small, limit, slopes.shape[1])
            for small, limit in zip(steps.tolist(), limits[different].tolist(), strict=True)
        ]
        slopes[flights] = np.array(rows)
    return slopes


def _slopes_of(law: LawNumbers | Law, small: float, limit: float, width: int) -> list[float]:
    """Return the derivatives of a demand by measurements and law states, ``(8 + s,)``.

    By forward differences: the last of the points in `rows` is the origin, each other one has a
    single number `small`. `law`: numbers of the law, or a law in Python. `limit`: deflection limit
    [rad]. `width`: 8 measurements and s states.
    """
    rows = (small * np.eye(width + 1, width)).tolist()
    if isinstance(law, Law):
        end = MEASURED + len(law.states[0])
        values = [
            float(law.demand(Measurement(*row[:MEASURED]), np.array(row[MEASURED:end]), limit))
            for row in rows
        ]
    else:
        values = [law_demand(law, row[:MEASURED], row[MEASURED:], limit) for row in rows]
    return [(value - values[-1]) / small for value in values[:-1]]


Response = Callable[[Any], ComplexArray]

_LOGARITHMIC_ANGLES = 1500
"""Number of logarithmically spaced angles on the unit circle."""
_ANGLES_PER_TURN = 8
"""Number of angles in each turn of the delay's phase."""
_MIN_FREQUENCY_OVER_POLE = 1e-4
"""Lowest frequency of the angles, over the fastest pole of the plant."""
_ZERO_ANGLE = 1e-12
"""Angle that replaces zero, where an integrator is infinite."""
_MIN_GAIN_FACTOR = 1e-12
"""Factor on the gain up to which it is that of an integrator at zero, which limits nothing."""
_MAX_IMAGINARY_OVER_REAL = 1e-3
"""Largest imaginary part of a real crossing, over its real part; near an integrator it is 1e12."""
_ROOT_TOLERANCE = 4.0 * np.finfo(float).eps
"""Relative tolerance of roots."""


def linear_gain_margins(batch: Batch, name: str, pole: float) -> tuple[float, float]:
    """Return the gain reduction and increase, factors above one, until the loop is unstable.

    Infinite if it never is. A factor 1/l brings a mode to the unit circle at each angle at which
    the response l of the loop (`_response`) is real and positive: the nearest factors below and
    above one are the margins. `batch`: one flight with a stable loop. `name`: "gain" of the law or
    "effectiveness" of the nozzle. `pole`: fastest unstable pole of the plant [1/s].
    """
    hardware = batch.hardware
    samples, remainder = split_delay(hardware.delay, hardware.period)  # whole samples, and [s]
    loop = _response(batch.delayed(remainder), name, float(samples))
    angles = _angles(batch, pole, float(samples))
    real = [_ZERO_ANGLE, *_roots(lambda a: loop(a).imag, angles), np.pi]
    values = loop(np.array(real))  # real at a zero of its imaginary part, not where that jumps
    is_real = np.abs(values.imag) < _MAX_IMAGINARY_OVER_REAL * np.abs(values.real)
    factors = 1.0 / values[is_real].real
    fall = factors[(factors > 0.0) & (factors < 1.0)].max(initial=0.0)
    rise = factors[factors > 1.0].min(initial=np.inf)
    reduction = 1.0 / fall if fall > _MIN_GAIN_FACTOR else np.inf
    return float(reduction), float(rise)


def linear_delay_margin(batch: Batch, pole: float) -> float:
    """Return the smallest further delay [s] with which the loop is unstable.

    The delay is f + n samples. With the fraction f included in the response l of the loop
    (`_response`) at z = e^(j theta), n = arg(l)/theta samples bring a mode to the unit circle where
    ``|l| = 1``; f is the root for which n is a whole number. `batch`: one flight with a stable
    loop. `pole`: fastest unstable pole of the plant [1/s]. Infinite if no delay makes it unstable.
    """
    from scipy.optimize import brentq

    h = float(batch.hardware.period)
    present = float(batch.hardware.delay) / h
    angles = _angles(batch, pole, 0.0)  # grid of theta, between which |l| = 1 is sought

    def samples(fraction: float) -> float:
        """Return the smallest n, a real number, with a mode at the stability limit; inf if none.

        The delay is n + `fraction` samples h, and at least the `present` one. With the fraction
        alone the loop has the response l at z = e^(j theta). A mode is at the limit where
        l e^(-j n theta) = 1: at each angle theta of ``|l| = 1`` for n = arg(l)/theta.
        """
        loop = _response(batch.delayed(fraction * h), "gain", samples=0.0)
        theta = np.array(_roots(lambda a: np.log(np.abs(loop(a))), angles))
        minimum = present - fraction  # n of the present delay
        remaining_phase = np.mod(np.angle(loop(theta)) - minimum * theta, 2.0 * np.pi)
        return float(np.min(minimum + remaining_phase / theta, initial=np.inf))

    first = samples(0.0)
    if first == np.inf:
        return first
    n, f = np.floor(first), 0.0
    if first > n:
        f = brentq(lambda fraction: samples(fraction) - n, 0.0, 1.0, xtol=_ROOT_TOLERANCE)
    return float((n + f - present) * h)


def _response(batch: Batch, name: str, samples: float) -> Response:
    """Return the response l(z) of an opened loop as a function of the angle of z = e^(j theta).

    l is the trace of (z - M_0)^-1 (M_1 - M_0), M_0 and M_1 being the steps for the factors zero and
    one on the gain or the effectiveness (`name`). M_1 - M_0 has rank one, so that the loop is at
    its stability limit where factor times l is 1. The step is A + g D with the gain g: A is the
    step without the law, D its effect (`A_1`, `D_1`; `dA`, `dD` are their changes when the
    effectiveness rises by one). `batch`: one flight. `samples`: whole samples of further delay.
    """

    def step(gain: float, effectiveness: float) -> FloatArray:
        """Return the step matrix of `batch` with factors on demand and control moment."""
        plant = batch.plant.with_effectiveness(effectiveness)
        return equilibrium_step(replace(batch, gain=np.asarray(gain), plant=plant))

    A_1, M_1 = step(0.0, 1.0), step(1.0, 1.0)  # without and with the law, nominal effectiveness
    D_1, identity = M_1 - A_1, np.eye(len(A_1))
    if name == "effectiveness":
        dA = step(0.0, 2.0) - A_1
        dD = step(1.0, 2.0) - M_1 - dA

    def response(angles: Any) -> ComplexArray:
        """Return l, the trace of (z - M_0)^-1 (M_1 - M_0), at angles [rad] of z, in their shape.

        M_1 = A_1 + z^-n D_1: step without the law, and its effect, n `samples` later.
        """
        theta = np.asarray(angles)[..., np.newaxis, np.newaxis]
        z, delay = np.exp(1j * theta), np.exp(-1j * samples * theta)  # z^-n for n samples
        M_1 = A_1 + delay * D_1
        change = delay * D_1 if name == "gain" else dA + delay * dD  # M_1 - M_0
        product = np.linalg.solve(z * identity - M_1 + change, change)
        return np.asarray(np.trace(product, axis1=-2, axis2=-1))

    return response


def _angles(batch: Batch, pole: float, samples: float) -> FloatArray:
    """Return ascending angles theta [rad] up to pi that resolve the response at z = e^(j theta).

    `batch`: one flight, of whose loop it is, with its sample period. `pole`: fastest unstable pole
    of the plant [1/s]. `samples`: delay in samples, with which the phase turns.
    """
    lowest = _MIN_FREQUENCY_OVER_POLE * pole * float(batch.hardware.period)  # theta [rad]
    logarithmic = np.geomspace(lowest, np.pi, _LOGARITHMIC_ANGLES)
    turns = np.linspace(0.0, np.pi, int(_ANGLES_PER_TURN * samples) // 2 + 2)
    return np.union1d(logarithmic, turns[1:-1])


def _roots(function: Callable[[Any], Any], angles: FloatArray) -> list[float]:
    """Return the zeros [rad] of a function between neighbouring `angles` of different sign."""
    from scipy.optimize import brentq

    above = function(angles) > 0.0
    ends = [pair for k, pair in enumerate(pairwise(angles.tolist())) if above[k] != above[k + 1]]
    return [
        brentq(function, *pair, xtol=_ROOT_TOLERANCE * pair[0], rtol=_ROOT_TOLERANCE)
        for pair in ends
    ]
