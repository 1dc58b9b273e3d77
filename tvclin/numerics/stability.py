"""Whether a closed loop is stable, with its delay exact, and where its gain is one.

Without the delay T the closed-loop poles are known. As a delay grows from zero,
poles can pass the imaginary axis only at the frequencies at which |L| = 1, whatever the delay;
there they pass each time the phase comes round to -180 degrees, to the right where |L| falls
with the frequency and to the left where it rises. So they can be counted (after Walton and
Marshall, IEE Proceedings D 134, 1987): no approximation of the delay enters the verdict.
"""

from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tvclin.numerics.state_loop import AnyLoop

_AXIS = 1e-12
"""Nearer to the imaginary axis than this part of the largest pole is on it."""
_TURN = 2.0 * np.pi
_SAME = 1e-6
"""A pole that is due within this phase [rad] begins on the axis, to rounding."""
_MANY = 1e15
"""More poles than these are not counted."""
_STEPS, _CLOSE = 4, 1e-6
"""How often a root of the squares is moved, and how far, over its frequency."""


@dataclass(frozen=True, eq=False)
class Stability:
    """What the closed loop does.

    `poles`: the closed-loop poles without the delay, ``(..., n)``. `unstable_poles`: closed-loop
    poles in the right half plane, ``(...)``. `marginal`: whether one lies on the imaginary axis,
    ``(...)``. `crossovers`: frequencies [rad/s] at which |L| = 1, rising, ``(..., k)``, filled with
    NaN.
    """

    poles: AnyArray
    unstable_poles: IndexArray
    marginal: BoolArray
    crossovers: FloatArray


def stability(loop: AnyLoop) -> Stability:
    """Return how many closed-loop poles are unstable, and the gain crossovers."""
    poles = loop.closed_poles()
    slack = _AXIS * np.abs(poles).max(axis=-1, keepdims=True)
    grown = np.sum(np.real(poles) > slack, axis=-1)
    on_axis = np.abs(np.real(poles)) <= slack
    at_zero = np.any(on_axis & (np.abs(poles) <= slack), axis=-1)
    frequencies, rising = loop.crossovers(1.0)
    frequencies = _polished(loop, frequencies)
    above, below = loop.undelayed(frequencies)
    with np.errstate(invalid="ignore"):
        due = np.angle(-above / below) % _TURN
        beginning = (due < _SAME) | (due > _TURN - _SAME)
        due = np.where(beginning, _first_due(poles, slack, frequencies, rising), due)
        turns = (frequencies * loop.delay[..., np.newaxis] - due) / _TURN
        passed = np.maximum(np.ceil(turns), 0.0)
        whole = (np.abs(turns - np.round(turns)) < _AXIS) & (turns > -_AXIS)
    moved = np.nansum(np.where(rising, 2.0, -2.0) * passed, axis=-1)
    moved = np.clip(moved, -_MANY, _MANY)
    delayed = loop.delay > 0.0
    touching = np.where(delayed, np.any(whole, axis=-1), np.any(on_axis, axis=-1))
    count = grown + np.where(delayed, moved, 0.0).astype(np.intp)
    return Stability(poles, np.asarray(count), np.asarray(at_zero | touching), frequencies)


def _first_due(
    poles: AnyArray, slack: FloatArray, omega: FloatArray, rising: BoolArray
) -> FloatArray:
    """The phase [rad] still to be lost by poles that begin on the axis or next to it.

    Those that move to the side on which they already are have a whole turn to go.
    """
    apart = np.abs(poles[..., np.newaxis, :] - 1j * omega[..., np.newaxis])
    nearest = np.argmin(np.nan_to_num(apart, nan=np.inf), axis=-1)
    right = np.take_along_axis(np.real(poles) > slack, nearest, axis=-1)
    return np.where(right != rising, 0.0, _TURN)


def last_frequency(loop: AnyLoop, size: float) -> FloatArray:
    """Return the highest frequency [rad/s] at which |L| is `size`, ``(...)``; zero if at none."""
    return np.nan_to_num(loop.crossovers(size)[0]).max(axis=-1, initial=0.0)


def _polished(loop: AnyLoop, omega: FloatArray) -> FloatArray:
    """Newton's steps on ln |L| itself: its squares have half the digits beside undamped poles."""
    with np.errstate(all="ignore"):
        for _ in range(_STEPS):
            above, below = loop.undelayed(omega)
            step = np.log(np.abs(above / below)) / loop.log_slope(omega).real
            omega = np.where(np.abs(step) <= _CLOSE * omega, omega - step, omega)
    return omega
