"""Driven loop along a flight: polynomials of time on short intervals between breakpoints.

Between the breakpoints of vehicle, structure and gains each entry of the matrices is a smooth
function of time, which differs little from a polynomial over a part of a second: one through five
Lobatto points of an interval. It is compared with the loop itself at a further time, and an
interval with another value there is halved.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.control.turbulence.driven_loop import DrivenLoop, Jump, Signal
from tvclin.numerics.chebyshev import interpolation_factors

_POINTS = 0.5 - 0.5 * np.cos(np.pi * np.arange(5) / 4.0)
"""Lobatto points of an interval of unit length."""
_BARYCENTRIC = np.array([0.5, -1.0, 1.0, -1.0, 0.5])
"""Barycentric weights of these points, see `interpolation_factors`."""
_CHECKED_POINT = 0.32
"""Position in an interval at which the polynomial is compared."""
_MAX_INTERVAL_S, _MAX_HALVINGS = 1.0, 6
"""Longest interval [s], and how often one is halved."""
_TOLERANCE, _ROUNDING = 1e-9, 1e-13
"""Largest error of an entry, relative to its own largest value, and to that of its matrix."""


class VaryingLoop:
    """Driven loop as a function of time.

    `loop_at`: loops at times [s] ``(n,)``. `breaks`: rising times, from the first to the last, with
    the breakpoints of the data between.
    """

    def __init__(self, loop_at: Callable[[FloatArray], DrivenLoop], breaks: FloatArray) -> None:
        self._starts, self._lengths, self._nodes = _interpolated(loop_at, breaks)

    @property
    def jumps(self) -> tuple[Jump, ...]:
        """Jumps of a sampled autopilot at all nodes."""
        return self._nodes.jumps

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the outputs."""
        return self._nodes.labels

    def at(self, times: FloatArray) -> DrivenLoop:
        """Return the loops at times [s], a batch ``(n,)``, without their jumps."""
        position, weights = self._weights(times)
        smooth = replace(self._nodes, jumps=())
        return smooth.mapped(lambda values: _combined(values, position, weights))

    def jump_at(self, index: int, times: FloatArray) -> Jump:
        """Return a jump at times [s], a batch ``(n,)``."""
        position, weights = self._weights(times)
        jump = self.jumps[index]
        return Jump(jump.length, *(_combined(part, position, weights) for part in jump[1:]))

    def signals(self, times: FloatArray) -> dict[str, Signal]:
        """Return the outputs at times [s], rows ``(n, states)`` or constant ones ``(states,)``."""
        position, weights = self._weights(times)

        def varying(values: FloatArray) -> FloatArray:
            first = values[0]
            return first if np.all(values == first) else _combined(values, position, weights)

        def signal(output: str) -> Signal:
            row, direct, rate = self._nodes.signal(output)
            if rate is not None:
                rate = varying(rate[0] + self._slopes(row)), varying(rate[1])
            return Signal(varying(row), varying(direct), rate)

        return {output: signal(output) for output in self.labels}

    def _weights(self, times: FloatArray) -> tuple[IndexArray, FloatArray]:
        """Return the first node of each time's interval, and the weights of its nodes."""
        index = np.searchsorted(self._starts, times, side="right") - 1
        index = np.clip(index, 0, len(self._starts) - 1)
        places = np.clip((times - self._starts[index]) / self._lengths[index], 0.0, 1.0)
        return index * len(_POINTS), interpolation_factors(_POINTS, places)

    def _slopes(self, values: FloatArray) -> FloatArray:
        """Return the derivatives [1/s] at the nodes of values there."""
        shape = (len(self._starts), len(_POINTS), *values.shape[1:])
        slopes = np.tensordot(values.reshape(shape), _DERIVATIVE, axes=(1, 1))
        lengths = self._lengths.reshape(-1, *[1] * values.ndim)
        return np.asarray(np.moveaxis(slopes, -1, 1) / lengths).reshape(values.shape)


def _derivative() -> FloatArray:
    """Return the matrix from values at the points to derivatives there, ``(5, 5)``."""
    distances = _POINTS[:, np.newaxis] - _POINTS + np.eye(len(_POINTS))
    matrix = _BARYCENTRIC / _BARYCENTRIC[:, np.newaxis] / distances
    np.fill_diagonal(matrix, 0.0)
    return np.asarray(matrix - np.diag(matrix.sum(axis=1)))


_DERIVATIVE = _derivative()
"""Matrix from values at the points of an interval of unit length to derivatives there."""


def _combined(values: FloatArray, first: IndexArray, weights: FloatArray) -> FloatArray:
    """Return values at times from those at nodes ``(nodes, ...)``; what is constant stays so."""
    flat = values.reshape(len(values), -1)
    result = np.broadcast_to(flat[0], (len(first), flat.shape[1])).copy()
    varies = np.flatnonzero(np.any(flat != flat[0], axis=0))
    columns = np.ascontiguousarray(flat[:, varies])
    result[:, varies] = sum(
        weights[:, k, np.newaxis] * columns[first + k] for k in range(len(_POINTS))
    )
    return np.asarray(result.reshape(len(first), *values.shape[1:]))


def _interpolated(
    loop_at: Callable[[FloatArray], DrivenLoop], breaks: FloatArray
) -> tuple[FloatArray, FloatArray, DrivenLoop]:
    """Return starts and lengths of the intervals [s], and the loops at the nodes of all."""
    counts = np.maximum(np.ceil(np.diff(breaks) / _MAX_INTERVAL_S - 1e-9), 1.0).astype(int)
    lengths = np.repeat(np.diff(breaks) / counts, counts)
    starts = breaks[0] + np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    places = np.append(_POINTS, _CHECKED_POINT)
    parts: list[tuple[FloatArray, FloatArray, DrivenLoop]] = []
    for halving in range(_MAX_HALVINGS + 1):
        times = starts[:, np.newaxis] + lengths[:, np.newaxis] * places
        loops = loop_at(times.ravel())
        fits = _fits(loops, times.shape)
        fits |= halving == _MAX_HALVINGS
        nodes = np.broadcast_to(fits[:, np.newaxis], times.shape).copy()
        nodes[:, -1] = False
        kept = np.flatnonzero(nodes)
        parts.append((starts[fits], lengths[fits], loops.mapped(lambda a, kept=kept: a[kept])))  # type: ignore[misc]
        if np.all(fits):
            break
        half = 0.5 * lengths[~fits]
        starts = np.concatenate([starts[~fits], starts[~fits] + half])
        lengths = np.concatenate([half, half])
    first, size = (np.concatenate(column) for column in list(zip(*parts, strict=True))[:2])
    order = np.argsort(first)
    rows = (order[:, np.newaxis] * len(_POINTS) + np.arange(len(_POINTS))).ravel()
    return first[order], size[order], _joined([part[2] for part in parts], rows)


def _joined(loops: list[DrivenLoop], rows: IndexArray) -> DrivenLoop:
    """Return the loops of several batches as one, in the order of `rows`."""
    queues = [list(loop.arrays) for loop in loops]
    joined = iter([np.concatenate(arrays)[rows] for arrays in zip(*queues, strict=True)])
    return loops[0].mapped(lambda _: next(joined))


def _fits(loops: DrivenLoop, shape: tuple[int, ...]) -> BoolArray:
    """Return for each interval whether the polynomials have the values at the checked point."""
    fits = np.ones(shape[0], bool)
    weights = interpolation_factors(_POINTS, np.array([_CHECKED_POINT]))[0]
    for array in loops.arrays:
        values = array.reshape(*shape, -1)
        errors = np.abs(np.tensordot(values[:, :-1], weights, axes=(1, 0)) - values[:, -1])
        sizes = np.abs(values).max(axis=(0, 1), initial=0.0)
        fits &= np.all(errors <= _TOLERANCE * sizes + _ROUNDING * sizes.max(initial=0.0), axis=1)
    return fits
