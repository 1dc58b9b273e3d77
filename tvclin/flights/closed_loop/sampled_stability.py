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
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.arrays import ComplexArray, FloatArray, IndexArray
from tvclin.control.laws.law import Law, Measurement
from tvclin.flights.closed_loop.batch import Batch, flights
from tvclin.flights.closed_loop.outcomes import SETTLING
from tvclin.kernels.control_laws import LawNumbers, asked
from tvclin.kernels.flight_arrays import MEASURED, Flights
from tvclin.linear.system import split_delay

if TYPE_CHECKING:
    from tvclin.flights.closed_loop.batch import Batch


_SMALL = 1e-7
"""A state so small, over the reach, is far below every limit and dead band."""
SLOW = 0.1
"""What turns more slowly, over the fastest growing pole, does not swing but creeps."""
_TOGETHER = 20_000
"""Rows of steps that are worked on together."""
_BEYOND = 1e100
"""An eigenvalue in place of one that is no number."""


def worst_near_rest(batch: Batch) -> complex:
    """Return the pole [1/s] of the worst mode of one loop, log(z)/h, upper where there are two.

    The spectral radius of its step near rest says how fast it grows (positive) or decays. Its
    frequency is what the samples show, at most half their rate.
    """
    values = np.linalg.eigvals(step_near_rest(batch)).astype(complex)
    worst = values[np.abs(values).argmax()]
    growth = np.log(max(abs(worst), np.finfo(float).tiny))
    return complex(growth, abs(np.angle(worst))) / float(batch.hardware.length)


def swing_near_rest(batch: Batch, f: Flights) -> FloatArray:
    """Return the growth rate [1/s] of the worst oscillation of each of many loops, ``(m,)``.

    What creeps does not count: a real positive eigenvalue of the step, and one that turns by less
    than a tenth of the fastest growing pole, as the path does. `f` are the flights of the batch, at
    any sample.
    """
    # Flights that differ in their limit alone are of one loop, unless their law looks at it.
    looks = np.array([one is None or one.leans for one in batch.laws.numbers])[f.cases.law]
    alike = np.where(looks, f.cases.limit, 0.0)
    keys = np.column_stack([f.cases.vehicle, f.cases.law, f.cases.gain, alike])
    _, first, which = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    size = f.now.y.shape[1] + f.now.states.shape[1] + f.now.commands.shape[1]
    parts = np.array_split(first, -(-first.size * size // _TOGETHER))
    found = np.concatenate([np.linalg.eigvals(_steps(batch, f, part)) for part in parts])
    values = found.astype(complex)[which.ravel()]
    h = f.steps.lengths[f.cases.vehicle, 0]
    turns = np.abs(np.angle(values)) / h[:, np.newaxis]
    slowest = SLOW * SETTLING / np.maximum(f.cases.settling * h, h)
    swings = (turns > slowest[:, np.newaxis]) & (np.angle(values) != 0.0)
    radius = np.where(swings, np.abs(values), 0.0).max(axis=1, initial=np.finfo(float).tiny)
    return np.asarray(np.log(radius) / h)


def step_near_rest(batch: Batch) -> FloatArray:
    """Return the step of one loop near rest, where it is a matrix.

    Its columns are what a step makes of the states of the vehicle, of the nozzle and of the law,
    and of the commands that are still to come, the latest first.
    """
    return _steps(batch, flights(batch), np.zeros(1, np.intp))[0]


def _steps(batch: Batch, f: Flights, cases: IndexArray) -> FloatArray:
    """Return the steps of some flights near rest, ``(k, n, n)``."""
    with np.errstate(over="ignore", invalid="ignore"):
        steps = _composed(batch, f, cases)
    # A gain whose step is beyond all numbers throws the nozzle from side to side.
    steps[~np.all(np.isfinite(steps), axis=(1, 2))] = -_BEYOND * np.eye(steps.shape[-1])
    return steps


def _composed(batch: Batch, f: Flights, cases: IndexArray) -> FloatArray:
    """The steps of some flights, ``(k, size, size)``; each signal is rows of factors on states."""
    k, every = cases.size, (f.now.y, f.now.states, f.now.commands)
    order, own, ring = (one.shape[1] for one in every)
    places, n = f.cases.vehicle[cases], f.vehicles.A.shape[1]
    x, held, sent = np.split(np.eye(order + own + ring - 1), [order, order + own])

    def of_each(rows: FloatArray) -> FloatArray:
        return rows[cases] if len(rows) > 1 else rows

    def spread(rows: FloatArray) -> FloatArray:
        return np.broadcast_to(rows, (k, *rows.shape[-2:]))

    sensed = np.concatenate([f.vehicles.shown[places, :, :n] @ x[:n], spread(x[n : n + 1])], axis=1)
    known = np.concatenate([spread(held), sensed, spread(0.0 * x[:1])], axis=1)
    seen = of_each(f.laws.seen) @ known if len(f.laws.seen) else sensed
    slopes = f.cases.gain[cases, np.newaxis] * _slopes(batch, f, cases)
    asks = slopes[:, np.newaxis] @ np.concatenate([seen, spread(held)], axis=1)
    known[:, -1:] = asks
    told = of_each(f.laws.told)[:, np.newaxis] @ known if len(f.laws.told) else asks
    commands = np.concatenate([told, spread(sent)], axis=1)
    moved = spread(x)
    for part in range(f.steps.joint.shape[1] - 1, -1, -1):
        age = (f.steps.late[places] + part)[:, np.newaxis, np.newaxis]
        now = np.take_along_axis(commands, age, axis=1)
        J = f.steps.joint[places, part]
        moved = J[..., :order] @ moved + J[..., order : order + 1] @ now
    states = of_each(f.laws.memory) @ known
    return np.concatenate([moved, states, commands[:, : ring - 1]], axis=1)


def _slopes(batch: Batch, f: Flights, cases: IndexArray) -> FloatArray:
    """What laws ask for, per number that they see and per state of their own, ``(k, 5 + s)``."""
    reach = max(float(np.abs(batch.plant.coefficients.B).max()), 1.0)
    small, limit = _SMALL / reach * f.cases.limit[cases], f.cases.limit[cases]
    found = np.zeros((cases.size, MEASURED + f.now.states.shape[1]))
    for place, numbers in enumerate(batch.laws.numbers):
        mine = np.flatnonzero(f.cases.law[cases] == place)
        if not mine.size:
            continue
        if numbers is None:
            found[mine] = _of_law(batch.laws.laws[place], small[mine], limit[mine], found.shape[1])
            continue
        alone = mine if numbers.leans else mine[:1]
        rows = [_of_numbers(numbers, small[i], limit[i], found.shape[1]) for i in alone]
        found[mine] = np.array(rows)
    return found


def _of_numbers(numbers: LawNumbers, small: float, limit: float, width: int) -> list[float]:
    """The slopes of a law of the package."""
    rows = (small * np.eye(width + 1, width)).tolist()
    values = [asked(numbers, one[:MEASURED], one[MEASURED:], limit) for one in rows]
    return [(value - values[-1]) / small for value in values[:-1]]


def _of_law(law: Law, small: FloatArray, limit: FloatArray, width: int) -> FloatArray:
    """The slopes of a law in Python, of some flights at once."""
    own = len(law.states[0])
    rows = small * np.eye(width + 1, width)[..., np.newaxis]
    values = [
        np.broadcast_to(
            law.demand(Measurement(*one[:MEASURED]), one[MEASURED : MEASURED + own], limit),
            small.shape,
        )
        for one in rows
    ]
    return np.stack([(value - values[-1]) / small for value in values[:-1]], axis=-1)


Response = Callable[[Any], ComplexArray]

_FREQUENCIES, _PER_TURN = 1500, 8
"""Angles that are laid by ratio, and in each turn of the delay."""
_LOWEST = 1e-4
"""Of the frequencies, over the fastest pole of the plant."""
_ZERO = 1e-12
"""An angle for zero, where an integrator is not yet infinite."""
_REAL = 1e-3
"""What is imaginary in a number that is real, over that; beside an integrator it is 1e12."""
_EXACT = 4.0 * np.finfo(float).eps


def factors_at_growth(batch: Batch, name: str, pace: float) -> tuple[float, float]:
    """Return by how much to divide, and to multiply, until the loop grows; infinite for never.

    `batch`: one flight, whose loop does not grow. `name`: what is multiplied. `pace`: the fastest
    unstable pole of the plant [1/s].
    """
    hardware = batch.hardware
    samples, rest = split_delay(hardware.delay, hardware.length)
    loop = _response(batch.delayed(rest), name, float(samples))
    angles = _angles(batch, pace, float(samples))
    real = [_ZERO, *_roots(lambda a: loop(a).imag, angles), np.pi]
    found = loop(np.array(real))
    found = found[np.abs(found.imag) < _REAL * np.abs(found.real)]  # beside an integrator it is not
    factors = 1.0 / found.real
    fall = factors[(factors > 0.0) & (factors < 1.0)].max(initial=0.0)
    rise = factors[factors > 1.0].min(initial=np.inf)
    return float(1.0 / fall) if fall > _ZERO else np.inf, float(rise)


def delay_at_growth(batch: Batch, pace: float) -> float:
    """Return the least delay [s], beyond that of the loop, with which it grows.

    `batch`: one flight, whose loop does not grow. `pace`: the fastest unstable pole of the plant
    [1/s].

    With a fraction f of a sample in l, as many whole samples n bring a mode to the circle as arg l
    = n theta where ``|l| = 1``; f is the one with which n is whole.
    """
    from scipy.optimize import brentq

    h = float(batch.hardware.length)
    late = float(batch.hardware.delay) / h
    angles = _angles(batch, pace, 0.0)

    def samples(part: float) -> float:
        """Samples on top of a fraction; they need not be whole yet."""
        loop = _response(batch.delayed(part * h), "gain", 0.0)
        at = np.array(_roots(lambda a: np.log(np.abs(loop(a))), angles))
        least = late - part
        turns = np.mod(np.angle(loop(at)) - least * at, 2.0 * np.pi)
        return float(np.min(least + turns / at, initial=np.inf))

    first = samples(0.0)
    if first == np.inf:
        return first
    whole = np.floor(first)
    part = brentq(lambda f: samples(f) - whole, 0.0, 1.0, xtol=_EXACT) if first > whole else 0.0
    return float((whole + part - late) * h)


def _response(batch: Batch, name: str, samples: float) -> Response:
    """L at angles of z on the unit circle, with so many whole samples of delay more."""

    def step(gain: float, effectiveness: float) -> FloatArray:
        plant = batch.plant.with_effectiveness(effectiveness)
        return step_near_rest(replace(batch, gain=np.asarray(gain), plant=plant))

    free, moved = step(0.0, 1.0), step(1.0, 1.0)
    by_command, unit = moved - free, np.eye(len(free))  # D_1; A_1 is free
    if name == "effectiveness":  # A_2 - A_1 and D_2 - D_1
        more = step(0.0, 2.0) - free
        more_by_command = step(1.0, 2.0) - moved - more

    def response(angles: Any) -> ComplexArray:
        theta = np.asarray(angles)[..., np.newaxis, np.newaxis]
        z, late = np.exp(1j * theta), np.exp(-1j * samples * theta)
        loop = free + late * by_command
        part = late * by_command if name == "gain" else more + late * more_by_command
        found = np.linalg.solve(z * unit - loop + part, part)
        return np.asarray(np.trace(found, axis1=-2, axis2=-1))

    return response


def _angles(batch: Batch, pace: float, samples: float) -> FloatArray:
    """Angles between which l is smooth, rising."""
    by_ratio = np.geomspace(_LOWEST * pace * float(batch.hardware.length), np.pi, _FREQUENCIES)
    turns = np.linspace(0.0, np.pi, int(_PER_TURN * samples) // 2 + 2)
    return np.union1d(by_ratio, turns[1:-1])


def _roots(function: Callable[[Any], Any], angles: FloatArray) -> list[float]:
    """Where a function changes its sign between angles."""
    from scipy.optimize import brentq

    above = function(angles) > 0.0
    ends = [pair for k, pair in enumerate(pairwise(angles.tolist())) if above[k] != above[k + 1]]
    return [brentq(function, *pair, xtol=_EXACT * pair[0], rtol=_EXACT) for pair in ends]
