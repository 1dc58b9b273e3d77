"""How far a sampled loop may change before it grows near rest: from its step, without a flight.

There the loop is linear and its step a matrix, M = A_e + g D_e with a gain g, affine also in the
effectiveness e of the nozzle. n whole samples of delay are the gain g z^-n. A mode begins to grow
where it comes to the unit circle, at some z = e^(j theta) on which

    1 = factor x l(z),    l = trace (z - M_0)^-1 (M_1 - M_0),

M_0 and M_1 being the steps without what the factor multiplies, and with it once: their difference
acts through the one command, so that l is the only eigenvalue that is not zero.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.arrays import ComplexArray, FloatArray
from tvclin.flights.closed_loop.growth import step_near_rest
from tvclin.linear.system import split_delay

if TYPE_CHECKING:
    from tvclin.flights.closed_loop.batch import Batch

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
