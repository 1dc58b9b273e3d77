"""What takes plant, nozzle and law of each of many flights over one step, exactly."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tvclin.autopilot import Actuator
from tvclin.closed_loop.law_rows import LawRows
from tvclin.kernels import flight_table as table
from tvclin.kernels.flight_table import FlightTable, SampledSteps
from tvclin.plant import Plant

FloatArray = NDArray[np.float64]

_SMALL, _TERMS = 0.5, 14


def sampled_steps(
    plant: Plant,
    laws: LawRows,
    actuator: Actuator | None,
    flights: FlightTable,
    shape: tuple[int, ...],
    good: NDArray[np.bool_],
    length: float,
) -> SampledSteps:
    """Return the steps of one length [s] of the flights that are good among a batch."""
    A, inputs, _, _ = plant.matrices()
    moved = _plant_steps(A, inputs, flights.wind.shape[2], length)
    A, gusts, begun, first, last, gust = (
        _spread(a, len(plant.batch), shape)[good] for a in (A, inputs[..., 1], *moved)
    )
    free, drive = _servo_steps(actuator, length)
    axes = 0 if actuator is None else len(actuator.batch)
    servo = _spread(free, axes, shape)[good], _spread(drive, axes, shape)[good]
    kept = exponentials(_beside(laws.free[good], laws.driven[good]), length)
    memory = kept[:, :2, :2].copy(), kept[:, :2, 2:].copy()
    noise = _noise(laws, flights, length)
    return SampledSteps(
        length, (A, gusts), begun, first, last, gust, servo, memory, noise, laws.hears[good]
    )


def exponentials(matrices: FloatArray, step: float) -> FloatArray:
    """Return e^(matrix step) of each of the matrices ``(..., n, n)``.

    By Taylor series, scaling and squaring; `kernels.propagation.exponentials` takes one matrix
    and many steps.
    """
    size = float(np.abs(matrices).sum(axis=-2).max(initial=0.0)) * step
    squarings = max(int(np.ceil(np.log2(max(size / _SMALL, 1e-300)))), 0)
    scaled = matrices * (step / 2.0**squarings)
    unit = np.eye(matrices.shape[-1])
    result = np.broadcast_to(unit, scaled.shape)
    for k in range(_TERMS, 0, -1):
        result = unit + scaled @ result / k
    for _ in range(squarings):
        result = result @ result
    return np.asarray(result)


def _beside(A: FloatArray, B: FloatArray) -> FloatArray:
    """The system whose inputs are states that stay."""
    n, m = B.shape[-2:]
    whole = np.zeros((*A.shape[:-2], n + m, n + m))
    whole[..., :n, :n], whole[..., :n, n:] = A, B
    return whole


def _plant_steps(
    A: FloatArray, inputs: FloatArray, terms: int, length: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Free motion, deflection at the start and at the end, and coefficients of the wind."""
    n = A.shape[-1]
    whole = np.zeros((*A.shape[:-2], n + 2 + terms, n + 2 + terms))
    whole[..., :n, :n], whole[..., :n, n] = A, inputs[..., 0]
    whole[..., n, n + 1] = 1.0 / length
    whole[..., :n, n + 2] = inputs[..., 1]
    for k in range(1, terms):
        whole[..., n + 1 + k, n + 2 + k] = k / length
    moved = exponentials(whole, length)
    ramp = moved[..., :n, n + 1]
    gust = moved[..., :n, n + 2 :] * length ** np.arange(terms)
    return moved[..., :n, :n], moved[..., :n, n] - ramp, ramp, gust


def _servo_steps(actuator: Actuator | None, length: float) -> tuple[FloatArray, FloatArray]:
    """Of the nozzle's states ``(..., 2, 2)`` and its command ``(..., 2)``."""
    if actuator is None:
        return np.zeros((2, 2)), np.array([1.0, 0.0])
    terms = actuator.denominator
    order = terms.shape[-1] - 1
    whole = np.zeros((*terms.shape[:-1], order + 1, order + 1))
    whole[..., :order, :order] = np.eye(order, k=1)
    whole[..., order - 1, :order] = -terms[..., :0:-1]
    whole[..., order - 1, order] = terms[..., -1]
    moved = exponentials(whole, length)
    free, drive = np.zeros((*terms.shape[:-1], 2, 2)), np.zeros((*terms.shape[:-1], 2))
    free[..., :order, :order], drive[..., :order] = moved[..., :-1, :-1], moved[..., :-1, -1]
    return free, drive


def _spread(array: FloatArray, axes: int, shape: tuple[int, ...]) -> FloatArray:
    """An array whose first axes are a batch, for every case ``(m, ...)``."""
    rest = array.shape[axes:]
    return np.broadcast_to(array, (*shape, *rest)).reshape(-1, *rest)


def _noise(laws: LawRows, flights: FlightTable, length: float) -> FloatArray:
    """A row of noise for each level and seed, as of `fly`; none where nobody has noise."""
    if not any(level for level, _ in laws.noise):
        return np.zeros((1, 0))
    rows = flights.rows
    patience = np.where(np.isnan(rows[table.REACH]), 0.0, rows[table.PATIENCE])
    last = np.where(np.isinf(rows[table.UNTIL]), rows[table.END] + patience, rows[table.UNTIL])
    count = int(np.ceil(float((last - rows[table.START]).max()) / length)) + 2 * table.LOOK
    return np.stack(
        [
            np.random.default_rng([seed, 0]).normal(0.0, level, count) if level else np.zeros(count)
            for level, seed in laws.noise
        ]
    )
