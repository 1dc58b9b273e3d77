"""How far a sampled loop may change before it grows near rest: from its step, without a flight.

There the loop is linear and its step a matrix, affine in a gain and in the effectiveness of the
nozzle. With a gain g and n samples of delay it grows from where, for some z on the unit circle,

    1 = g z^-n G(z),        G(z) = trace (z - M_0)^-1 (M_1 - M_0),

M_g being the step without these samples: M_1 - M_0 is of rank one, for it goes through the command.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tvclin.flights.closed_loop.growth import step_near_rest, worst_mode

if TYPE_CHECKING:
    from tvclin.flights.closed_loop.sampled import Batch
    from tvclin.linear.plant import Plant

FloatArray = NDArray[np.float64]

MOST_FACTOR = 1e6
"""Factors are looked at up to this."""
_FACTORS = 1.03
"""From one factor to the next; what lies between two that do not grow is not seen."""
_FREQUENCIES = 1500
_LOWEST = 1e-3
"""Of the frequencies of the delay, over the fastest pole of the plant."""
_EXACT = 4.0 * np.finfo(float).eps


def factor_at_growth(step: Callable[[float], FloatArray], length: float, *, rise: bool) -> float:
    """Return the least factor above one by which to multiply, or divide, before the loop grows.

    Parameters
    ----------
    step : callable
        The step of the loop with a gain, or with an effectiveness.
    length : float
        Of a sample [s].
    rise : bool
        Whether to multiply.
    """
    from scipy.optimize import brentq

    one, two = step(1.0), step(2.0)

    def growth(exponent: float) -> float:
        factor = np.exp(exponent if rise else -exponent)
        return worst_mode(one + (factor - 1.0) * (two - one), length).real

    exponents = np.arange(0.0, np.log(MOST_FACTOR), np.log(_FACTORS))
    for before, after in pairwise(exponents.tolist()):
        if growth(after) > 0.0:
            begins = before if before > 0.0 else _EXACT
            return float(np.exp(brentq(growth, begins, after, xtol=_EXACT, rtol=_EXACT)))
    return float(np.inf)


def delay_at_growth(batch: Batch, pace: float) -> float:
    """Return the least delay [s], beyond that of the loop, with which it grows; all frequencies.

    Parameters
    ----------
    batch : Batch
        One flight, whose loop does not grow.
    pace : float
        The fastest unstable pole of the plant [1/s].

    Notes
    -----
    With the fraction f of a sample in G, the whole samples n that bring it to the circle are
    arg G/theta where |G| = 1. f is the one with which n is whole.
    """
    from scipy.optimize import brentq

    h, late = float(batch.length), float(batch.delay) / float(batch.length)
    angles = np.geomspace(_LOWEST * pace * h, np.pi, _FREQUENCIES)

    def samples(part: float) -> float:
        """Whole samples on top of a fraction; they need not be whole yet."""
        loop = _open(replace(batch, delay=np.asarray(part * h)))
        sizes = np.log(np.abs(loop(angles)))
        found = [
            brentq(lambda a: float(np.log(np.abs(loop(np.array([a]))[0]))), *ends, rtol=_EXACT)
            for ends in pairwise(angles)
            if np.prod(np.sign(sizes[np.searchsorted(angles, ends)])) < 0.0
        ]
        at, least = np.array(found), late - part
        turns = np.mod(np.angle(loop(at)) - least * at, 2.0 * np.pi) if found else at
        return float(np.min(least + turns / at, initial=np.inf))

    first = samples(0.0)
    if first == np.inf:
        return first
    whole = np.floor(first)
    part = brentq(lambda f: samples(f) - whole, 0.0, 1.0, xtol=_EXACT) if first > whole else 0.0
    return float((whole + part - late) * h)


def _open(batch: Batch) -> Callable[[FloatArray], NDArray[np.complex128]]:
    """G at angles of z on the unit circle."""
    rest, moved = (step_near_rest(replace(batch, gain=np.asarray(g))) for g in (0.0, 1.0))
    by_command, unit = moved - rest, np.eye(len(rest))

    def loop(angles: FloatArray) -> NDArray[np.complex128]:
        z = np.exp(1j * angles)[:, np.newaxis, np.newaxis]
        return np.asarray(np.trace(np.linalg.solve(z * unit - rest, by_command), axis1=1, axis2=2))

    return loop


def with_effectiveness(plant: Plant, factor: FloatArray | float) -> Plant:
    """Return a plant whose deflection does so many times as much, moment and side force alike."""
    c = plant.coefficients
    return replace(plant, coefficients=c.replace(mu_delta=factor * np.asarray(c.mu_delta)))
