"""The plant and the nozzle of a flight, stepped exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tvclin.autopilot import Actuator
from tvclin.errors import InputError
from tvclin.histories import History
from tvclin.kernels.propagation import answering, driven, exponentials, inputs_at
from tvclin.plant import Plant

FloatArray = NDArray[np.float64]

MOST = 5_000_000
"""Samples of a flight, or of all that are flown together: some hundred megabytes."""
_LARGEST = 300.0
"""A plant may grow by e^300 in a step: numbers end at e^709, and products of two are needed."""


@dataclass(frozen=True, eq=False)
class Steps:
    """x(t + h) = free @ x + first * delta(t) + last * delta(t + h) + gusts[k].

    The deflection goes evenly from its first to its last value in a step.

    Attributes
    ----------
    times : ndarray
        Starts of the steps and the end of the last [s], ``(m + 1,)``.
    free : ndarray
        ``(n, n)``.
    first, last : ndarray
        ``(n,)``.
    gusts : ndarray
        What the wind adds in each step, exactly, whatever its knots, ``(m, n)``.
    wind : ndarray
        The wind at `times` [rad], after a jump, ``(m + 1,)``.
    """

    times: FloatArray
    free: FloatArray
    first: FloatArray
    last: FloatArray
    gusts: FloatArray
    wind: FloatArray


def steps(plant: Plant, wind: History, start: float, stop: float, length: float) -> Steps:
    """Return the steps of a plant in a wind, of equal length [s], to `stop` or just beyond.

    Raises
    ------
    InputError
        For so many steps that no memory holds them, and for a step in which the plant outgrows
        every number.
    """
    A, inputs, _, _ = plant.matrices()
    fastest = float(np.real(np.linalg.eigvals(A)).max())
    if fastest * length > _LARGEST:
        raise InputError(
            f"sample_rate must be at least {fastest / _LARGEST:.4g} Hz: between two samples the"
            f" plant grows by e^({fastest:.4g} t), and may not by more than e^{_LARGEST:g}; got"
            f" {1.0 / length:.6g} Hz"
        )
    if (stop - start) / length > MOST:
        raise InputError(
            f"a flight may have at most {MOST:g} samples; got {stop - start:.6g} s at"
            f" {1.0 / length:.6g} Hz: give a shorter wind or a lower sample_rate"
        )
    count = max(int(np.ceil((stop - start) / length - 1e-9)), 1)
    times: FloatArray = start + length * np.arange(count + 1.0)
    n = len(A)
    ramp_of = np.array([[0.0, 1.0 / length], [0.0, 0.0]])
    held_and_ramp = np.column_stack([inputs[:, 0], np.zeros(n)])
    matrix = driven(A, held_and_ramp, ramp_of)
    whole = exponentials(matrix, np.array([length]))[0]
    held, ramp = whole[:n, n], whole[:n, n + 1]
    gusts = gust_steps(A, inputs[:, 1], wind, times)
    return Steps(times, whole[:n, :n], held - ramp, ramp, gusts, wind(times))


def gust_steps(A: FloatArray, B: FloatArray, wind: History, times: FloatArray) -> FloatArray:
    """Return what a wind adds to the states in each step between the times, ``(m, n)``.

    A step with knots inside is put together from its parts, so that no gust is missed.
    """
    n, pieces = len(A), wind.pieces
    matrix = answering(A, B, pieces)
    whole = exponentials(matrix, times[1:2] - times[:1])[0]
    gusts = np.real(inputs_at(pieces, times[:-1]) @ whole[:n, n:].T)
    knots = pieces.knots[(pieces.knots > times[0]) & (pieces.knots < times[-1])]
    for k in np.unique(np.searchsorted(times, knots, side="right") - 1):
        inside = knots[(knots > times[k]) & (knots < times[k + 1])]
        edges = np.concatenate([times[k : k + 1], inside, times[k + 1 : k + 2]])
        states = inputs_at(pieces, edges[:-1])
        parts = exponentials(matrix, np.diff(edges))
        state = np.zeros(n)
        for part, begun in zip(parts, states, strict=True):
            state = np.real(part[:n, :n] @ state + part[:n, n:] @ begun)
        gusts[k] = state
    return gusts


@dataclass(frozen=True, eq=False)
class Nozzle:
    """How the deflection follows its command in steps of one length.

    A rate limit bounds the rate of the servo; the stop at the deflection limit stands outside it.
    """

    actuator: Actuator | None
    rate_limit: float
    length: float

    @property
    def order(self) -> int:
        """Number of states: the position [rad], and the rate [rad/s] of a second-order servo."""
        return 1 if self.actuator is None else self.actuator.denominator.size - 1

    @property
    def jumps(self) -> bool:
        """Whether the deflection is at its command at once."""
        return self.actuator is None and self.rate_limit == np.inf

    def matrices(self) -> tuple[FloatArray, FloatArray]:
        """Return what takes states and command to the states one step later."""
        if self.actuator is None:
            return np.zeros((1, 1)), np.ones(1)
        A, B, _, _ = self.actuator.matrices()
        whole = exponentials(driven(A, B), np.array([self.length]))[0]
        return whole[:-1, :-1], whole[:-1, -1]
