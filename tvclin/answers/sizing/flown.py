"""What the trim law needs along a flight with parameters that vary: it is flown there.

    delta = -(A_2.x + w_2 alpha_w + gain mu_alpha z)/b_2,    z = theta + theta' l_2/l_1,

within the limit, for x' = A x + b delta + w alpha_w and the row l of `FlightMode`: the moment is
trimmed, and the growing part of the attitude brought back. Where parameters change so fast that
l_2/l_1 is not of the size of 1/sqrt(mu_alpha), it counts as three times that at the most. Many
winds and limits at once, by Heun's rule.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from tvclin.answers.sizing.flight_mode import FlightMode
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.flights.closed_loop.edges import edges_above_losses

_GAIN = 10.0
"""Of the attitude feedback over that of trim; as of `TrimLaw`."""
_MOST_RATE = 3.0
_STEP = 0.03
"""Between steps, over the time in which the fastest mode grows by e; the rule is off by a part of
(_GAIN _STEP)^2/6 in the feedback, a sixtieth of what it settles in."""
_AFTER = 15.0
"""A wind is followed so long beyond its end, over the time of the fastest mode."""
_MORE = 1e-6
"""Above the largest trim deflection, with which the law is not limited."""
_TINY = 1e-12
"""A limit [rad] in place of none."""


def flight_steps(mode: FlightMode, wind: tuple[float, float] | None = None) -> FloatArray:
    """Return the times [s] of a flight at which `trim_law_needs` asks for winds, ``(t,)``.

    Those of all of it, or from the onset of a wind to a while after its end.
    """
    start, stop = mode.span
    fastest = float(np.max(mode.growth_rate(np.linspace(start, stop, 200))))
    if wind is not None:
        start, stop = max(start, wind[0]), min(stop, wind[1] + _AFTER / fastest)
    return np.linspace(start, stop, max(math.ceil((stop - start) * fastest / _STEP), 2) + 1)


def trim_law_needs(
    mode: FlightMode, times: FloatArray, winds: FloatArray, expected: ArrayLike
) -> FloatArray:
    """Return the least limits [rad] above which all that are tried survive, ``(r,)``.

    Of winds [rad] at the `flight_steps`, ``(r, t)``; `expected` is what each needs at the least
    [rad].
    """
    low = np.maximum(np.broadcast_to(np.asarray(expected, dtype=float), winds.shape[:1]), _TINY)
    high = np.maximum(_largest_trim(mode, times, winds) * (1.0 + _MORE), low)

    def lost(tried: FloatArray) -> BoolArray:
        return trim_law_lost(mode, times, winds, tried.T).T

    return edges_above_losses(lost, low, high)[0]


def trim_law_lost(
    mode: FlightMode, times: FloatArray, winds: FloatArray, limits: FloatArray
) -> BoolArray:
    """Which flights with limits ``(r, tries)`` end where the limit, held, does not bring back."""
    A, inputs = mode.matrices(times)
    row, reach = mode.at(times)
    stiffness = np.abs(A[:, 1, 0])
    back = _GAIN * stiffness / inputs[:, 1, 0]
    with np.errstate(divide="ignore"):
        longest = _MOST_RATE / np.sqrt(stiffness)
        ahead = np.minimum(np.where(row[0] > 0.0, row[1] / row[0], np.inf), longest)
    law = A[:, 1] / inputs[:, 1, :1]
    law[:, 0] += back
    law[:, 1] += back * ahead
    both = np.concatenate([A, law[:, np.newaxis]], axis=1)  # rows of x', and of the command
    felt = inputs[:, 1, 1] / inputs[:, 1, 0]
    order, step, cases = A.shape[-1], float(times[1] - times[0]), winds[..., np.newaxis]

    def rates(k: int, x: FloatArray) -> FloatArray:
        moved = (both[k] @ x.reshape(order, -1)).reshape(-1, *limits.shape)
        command = moved[order] + felt[k] * cases[:, k]
        delta = np.minimum(np.maximum(-command, -limits), limits)
        moved = moved[:order] + inputs[k, :, 0, np.newaxis, np.newaxis] * delta
        return np.asarray(moved + np.multiply.outer(inputs[k, :, 1], cases[:, k]))

    x = np.zeros((order, *limits.shape))
    for k in range(times.size - 1):
        first = rates(k, x)
        x = x + 0.5 * step * (first + rates(k + 1, x + step * first))
    return np.asarray(np.abs(np.tensordot(row[:, -1], x, 1)) > limits * abs(reach[-1]))


def _largest_trim(mode: FlightMode, times: FloatArray, winds: FloatArray) -> FloatArray:
    """The largest deflection of ideal trim [rad], with what drift adds or relieves, ``(r,)``."""
    A, inputs = mode.matrices(times)
    x, most = np.zeros((winds.shape[0], A.shape[-1] - 2)), np.zeros(winds.shape[0])
    step = float(times[1] - times[0])

    def trim(k: int, x: FloatArray) -> FloatArray:
        return np.asarray(-(x @ A[k, 1, 2:] + inputs[k, 1, 1] * winds[:, k]) / inputs[k, 1, 0])

    def rates(k: int, x: FloatArray) -> FloatArray:
        both = np.stack([trim(k, x), winds[:, k]], axis=-1)
        return np.asarray(x @ A[k, 2:, 2:].T + both @ inputs[k, 2:].T)

    for k in range(times.size - 1):
        most = np.maximum(most, np.abs(trim(k, x)))
        first = rates(k, x)
        x = x + 0.5 * step * (first + rates(k + 1, x + step * first))
    return np.maximum(most, np.abs(trim(times.size - 1, x)))
