"""The exact answer of a sum of modes to two inputs made of pieces, at any times.

A mode that does not grow is the discounted past of its inputs, carried from knot to knot. A mode
that grows is written as

    z(t) = R e^(p t) - (discounted future of its inputs),

R being its residue. Where R is zero what remains decays, so nothing is lost; integrated forward,
the same mode would be the difference of two numbers that grow with e^(p t). A residue that is
zero within the rounding of its own sum counts as zero.

The compiled twin does the same case by case, or several side by side where they are plain; both
agree within 1e-13 of the largest value of each output in the time asked for.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels import integrals, lags
from tvclin.kernels.choice import compiled_twin
from tvclin.kernels.pieces import Pieces, flat, spread, value
from tvclin.kernels.residues import residues
from tvclin.kernels.threads import in_slices

FloatArray = NDArray[np.float64]

MARGINAL = 1e-12
"""A pole whose real part is below this part of the largest pole counts as not growing."""
_SEPARATE = 1e-3
"""Poles nearer to each other than this, over the largest or over the time, count as near."""
_FORWARD = 20.0
"""A mode that grows by no more than e^20 may be carried forward."""
_PLAIN = (7e-3, 2e-6)
"""Seconds that the numpy twin takes for any call, and for one time of one case."""
_FAST = (2e-6, 4e-9)
"""Seconds that the compiled twin takes for one case, and for one time of it."""
_REAL, _COMPLEX = np.dtype(float), np.dtype(complex)
_DEGREE = 4
"""The compiled twin knows powers of the time up to this one."""


@dataclass(frozen=True, slots=True)
class System:
    """A plant as a sum of modes.

    Attributes
    ----------
    poles : ndarray
        Poles [1/s], ``(..., N)``.
    gains : ndarray
        What each input does to each mode, ``(..., N, 2)``.
    outputs : ndarray
        How much of each mode is in each output, ``(..., N, R)``.
    less_wind : bool
        Whether the second input, the wind, is taken off the last output.
    """

    poles: NDArray[Any]
    gains: NDArray[Any]
    outputs: NDArray[Any]
    less_wind: bool = True

    def only(self, rows: Sequence[int]) -> "System":
        """Return the same with some of its outputs, by their positions, which rise."""
        last = rows[-1] == self.outputs.shape[-1] - 1
        return System(self.poles, self.gains, self.outputs[..., rows], self.less_wind and last)


def growing(poles: NDArray[Any]) -> NDArray[np.bool_]:
    """Return which of all the poles ``(..., N)`` of a plant grow; those on the axis do not."""
    size = reduce(np.maximum, np.moveaxis(np.abs(poles), -1, 0))  # quicker than along rows
    return np.asarray(np.real(poles) > MARGINAL * size[..., np.newaxis])


def responses(
    system: System, inputs: tuple[Pieces, Pieces], times: FloatArray, shape: tuple[int, ...]
) -> tuple[FloatArray, NDArray[np.bool_] | None]:
    """Return the outputs ``(*shape, R, n)``, and for which cases they are not to be used.

    Parameters
    ----------
    system : System
        One plant or a batch.
    inputs : tuple of Pieces
        Deflection and wind.
    times : ndarray
        Times [s], ``(n,)``, in any order.
    shape : tuple of int
        Of the batch, to which plants and inputs broadcast.

    Returns
    -------
    outputs : ndarray
        In the units of the inputs.
    near : ndarray or None
        ``shape``; True where two poles are too near for modes to be told apart in that time.
        None where this is nowhere so.
    """
    seconds = _PLAIN[0] + _PLAIN[1] * prod(shape) * times.size
    twin = compiled_twin("responses", seconds)
    if twin is None or max(pieces.degree for pieces in inputs) > _DEGREE:
        return _plain(system, inputs, times, shape)
    return _compiled(twin, system, inputs, times, shape)


def values(inputs: tuple[Pieces, Pieces], times: FloatArray) -> FloatArray:
    """Return the values of two histories at the times ``(n,)``, ``(2, n)``.

    They are those of `pieces.value` to the last bit.
    """
    twin = compiled_twin("responses", 0.0)
    if twin is not None and inputs[0].batch == inputs[1].batch == () and _kind(inputs) is _REAL:
        out = np.empty((2, times.size))
        arrays = [_flat_pieces(pieces, _REAL) for pieces in inputs]
        if twin.values(_read_only(times), *arrays, out):
            return out
    return np.stack([np.real(value(pieces, times)) for pieces in inputs])


def _compiled(
    twin: Any,
    system: System,
    inputs: tuple[Pieces, Pieces],
    times: FloatArray,
    shape: tuple[int, ...],
) -> tuple[FloatArray, NDArray[np.bool_] | None]:
    kind = _COMPLEX if system.poles.dtype.kind == "c" else _kind(inputs)
    plants = [flat(a, k, kind) for a, k in ((system.poles, 1), (system.gains, 2))]
    plants.append(flat(system.outputs, 2, kind))
    batch = (*plants, system.less_wind)
    histories = [_flat_pieces(pieces, kind) for pieces in inputs]
    batches = (system.poles.shape[:-1], inputs[0].batch, inputs[1].batch)
    which = _which(batches, shape)
    cases = which.shape[1]
    out = np.empty((cases, system.outputs.shape[-1], times.size))
    status = np.zeros(cases, np.uint8)

    rising = _read_only(times)
    order = None if twin.rises(rising) else np.argsort(times)
    if order is not None:
        rising = _read_only(times[order])

    given = (rising, batch, *histories)
    if kind is _REAL:
        _in_slices(twin.respond_straight, given, which, out, status)
    if not status.all():
        _answer_left(twin.respond, given, which, out, status)
    if order is not None:
        result = np.empty_like(out)
        result[..., order] = out
        out = result
    if status.max() == twin.DONE:
        return out.reshape(*shape, *out.shape[1:]), None
    other = np.flatnonzero(status == twin.OTHER)
    if other.size:
        poles, gains, outputs = (a[which[0, other]] for a in plants)
        part = System(poles, gains, outputs, system.less_wind)
        some = [Pieces(*(a[which[i + 1, other]] for a in h)) for i, h in enumerate(histories)]
        out[other], _ = _plain(part, (some[0], some[1]), times, other.shape)
    return out.reshape(*shape, *out.shape[1:]), (status == twin.NEAR).reshape(shape)


def _in_slices(
    respond: Any, given: tuple[Any, ...], which: NDArray[Any], out: FloatArray, status: NDArray[Any]
) -> None:
    """Let one of the compiled functions answer all cases."""
    near = (_SEPARATE, _FORWARD)

    def work(first: int, last: int) -> None:
        respond(*given, which, near, out, status, first, last)

    in_slices(work, status.size, status.size * (_FAST[0] + _FAST[1] * out.shape[-1]))


def _answer_left(
    respond: Any, given: tuple[Any, ...], which: NDArray[Any], out: FloatArray, status: NDArray[Any]
) -> None:
    """Let one of the compiled functions answer the cases whose status is zero."""
    left = np.flatnonzero(status == 0)
    if left.size == status.size:
        _in_slices(respond, given, which, out, status)
        return
    part, fates = np.empty((left.size, *out.shape[1:])), np.zeros(left.size, np.uint8)
    _in_slices(respond, given, np.take(which, left, axis=1), part, fates)
    out[left], status[left] = part, fates


def _read_only(times: FloatArray) -> FloatArray:
    if not times.flags.writeable:
        return times
    times = times.view()
    times.flags.writeable = False
    return times


def _kind(inputs: tuple[Pieces, Pieces]) -> Any:
    for pieces in inputs:
        if pieces.coefficients.dtype.kind == "c" or pieces.rates.dtype.kind == "c":
            return _COMPLEX
    return _REAL


def _flat_pieces(pieces: Pieces, kind: Any) -> tuple[NDArray[Any], ...]:
    batch = pieces.batch
    if not batch and kind is _REAL:
        return pieces.single
    pieces = spread(pieces, batch) if batch else pieces
    return (
        flat(pieces.knots, 1, _REAL),
        flat(pieces.coefficients, 3, kind),
        flat(pieces.rates, 1, kind),
    )


def _which(batches: tuple[tuple[int, ...], ...], shape: tuple[int, ...]) -> NDArray[np.int64]:
    """For each case its positions in the batches, ``(len(batches), cases)``."""
    if not shape:
        return np.zeros((len(batches), 1), np.int64)
    rows = [np.arange(prod(batch)).reshape(batch) for batch in batches]
    return np.stack([np.broadcast_to(row, shape).ravel() for row in rows])


def _plain(
    system: System, inputs: tuple[Pieces, Pieces], times: FloatArray, shape: tuple[int, ...]
) -> tuple[FloatArray, NDArray[np.bool_] | None]:
    start = np.minimum(inputs[0].knots[..., 0], inputs[1].knots[..., 0])
    near = _near_poles(system.poles, times.max() - start)
    with np.errstate(invalid="ignore"):  # near poles have no residues
        modes = _amplitudes(system, inputs, times, start)
        rows = [
            np.real((system.outputs[..., r, np.newaxis] * modes).sum(axis=-2))
            for r in range(system.outputs.shape[-1])
        ]
    if system.less_wind:
        rows[-1] = rows[-1] - np.real(value(inputs[1], times))
    outputs = np.stack([np.broadcast_to(row, (*shape, times.size)) for row in rows], axis=-2)
    return outputs, np.broadcast_to(near, shape) if near.any() else None


def _amplitudes(
    system: System, inputs: tuple[Pieces, Pieces], times: FloatArray, start: FloatArray
) -> NDArray[Any]:
    """Each mode, ``(..., N, n)``; one that grows by no more than e may as well go forward."""
    ahead = np.asarray(np.maximum(times.max() - start, 0.0))[..., np.newaxis]
    unstable = growing(system.poles) & (np.abs(system.poles) * ahead > 1.0)
    gains = (system.gains[..., 0], system.gains[..., 1])
    found, tolerance = residues(np.where(unstable, system.poles, np.nan), gains, inputs, start)
    found = np.where(unstable & (np.abs(found) > tolerance), found, 0.0)
    columns = []
    for k in range(system.poles.shape[-1]):
        pole, up, weights = system.poles[..., k], unstable[..., k], system.gains[..., k, :]
        forward = _sum(lags.past, np.where(up, 0.0, pole), weights, inputs, times)
        if not np.any(up):
            columns.append(forward)
            continue
        back = _sum(integrals.future, np.where(up, pole, 1.0), weights, inputs, times)
        with np.errstate(over="ignore", invalid="ignore"):
            since = times - start[..., np.newaxis]
            growth = np.where(up, pole, 0.0)[..., np.newaxis] * since
            excess = found[..., k, np.newaxis]
            grown = np.where(excess == 0.0, 0.0, excess * np.exp(growth))
            grown = np.where(since < 0.0, 0.0, grown - back)
        columns.append(np.where(up[..., np.newaxis], grown, forward))
    return np.stack(np.broadcast_arrays(*columns), axis=-2)


def _sum(
    integral: Any,
    pole: NDArray[Any],
    weights: NDArray[Any],
    inputs: tuple[Pieces, Pieces],
    times: FloatArray,
) -> NDArray[Any]:
    terms = [weights[..., i, np.newaxis] * integral(inputs[i], pole, times) for i in range(2)]
    return np.asarray(terms[0] + terms[1])


def _near_poles(poles: NDArray[Any], span: FloatArray) -> NDArray[np.bool_]:
    """Where two poles are too near for the modes to be told apart within the time span, ``(...)``.

    A plant that grows fast all the same keeps its modes: a chain of lags runs forward.
    """
    gaps = np.abs(poles[..., :, np.newaxis] - poles[..., np.newaxis, :])
    gaps[..., np.arange(poles.shape[-1]), np.arange(poles.shape[-1])] = np.inf
    gap, size = gaps.min(axis=(-2, -1)), np.abs(poles).max(axis=-1)
    span = np.maximum(span, 0.0)
    near = (gap <= _SEPARATE * size) | (gap * span <= _SEPARATE)
    return near & ((np.real(poles).max(axis=-1) * span <= _FORWARD) | (gap == 0.0))
