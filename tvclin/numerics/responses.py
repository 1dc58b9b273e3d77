"""The exact answer of a sum of modes to two inputs made of pieces, at any times.

A mode that does not grow is carried from knot to knot. A mode that grows is written as

    z(t) = R e^(p t) - (discounted future of its inputs),

R being its residue. Where R is zero what remains decays, so nothing is lost; integrated forward,
the same mode would be the difference of two numbers that grow with e^(p t). A residue that is
zero within the rounding of its own sum counts as zero.

The kernel is `response_cases`, exact within 1e-13 of the largest value of each output in the time
asked for.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from math import prod

import numpy as np

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IntArray
from tvclin.kernels import choice
from tvclin.kernels.response_cases import COMPILED, MARGINAL, PLAIN, PLAIN_TIME, respond, room
from tvclin.kernels.threads import in_slices
from tvclin.numerics.pieces import Pieces, flat, spread

_REAL, _COMPLEX = np.dtype(float), np.dtype(complex)


@dataclass(frozen=True, slots=True)
class System:
    """A plant as a sum of modes.

    `poles`: poles [1/s], ``(..., N)``. `gains`: what each input does to each mode, ``(..., N, 2)``.
    `outputs`: how much of each mode is in each output, ``(..., N, R)``. `less_wind`: whether the
    second input, the wind, is taken off the last output.
    """

    poles: AnyArray
    gains: AnyArray
    outputs: AnyArray
    less_wind: bool = True

    def only(self, rows: Sequence[int]) -> "System":
        """Return the same with some of its outputs, by their positions, which rise."""
        last = rows[-1] == self.outputs.shape[-1] - 1
        return System(self.poles, self.gains, self.outputs[..., rows], self.less_wind and last)


def growing(poles: AnyArray) -> BoolArray:
    """Return which of all the poles ``(..., N)`` of a plant grow; those on the axis do not."""
    size = reduce(np.maximum, np.moveaxis(np.abs(poles), -1, 0))  # quicker than along rows
    return np.asarray(np.real(poles) > MARGINAL * size[..., np.newaxis])


def responses(
    system: System, inputs: tuple[Pieces, Pieces], times: FloatArray, shape: tuple[int, ...]
) -> tuple[FloatArray, BoolArray | None]:
    """Return the outputs ``(*shape, R, n)``, and for which cases they are not to be used.

    `inputs`: deflection and wind. `times`: times [s], ``(n,)``, in any order. `shape`: of the
    batch, to which plants and inputs broadcast. Returned `outputs`: in the units of the inputs.
    Returned `near`: ``shape``; True where two poles are too near for modes to be told apart in that
    time. None where this is nowhere so.
    """
    histories = [spread(p, p.batch) if p.batch else p for p in inputs]
    arrays = [system.poles, *(a for h in histories for a in (h.coefficients, h.rates))]
    kind = _COMPLEX if any(a.dtype.kind == "c" for a in arrays) else _REAL
    plants = (
        flat(system.poles, 1, kind),
        flat(system.gains, 2, kind),
        flat(system.outputs, 2, kind),
        system.less_wind,
    )
    first, second = (
        (flat(h.knots, 1, _REAL), flat(h.coefficients, 3, kind), flat(h.rates, 1, kind))
        for h in histories
    )
    which = _which((system.poles.shape[:-1], *(h.batch for h in histories)), shape)
    order = np.argsort(times) if np.any(times[1:] < times[:-1]) else None
    rising = times.copy() if order is None else times[order]
    out = np.empty((which.shape[1], plants[2].shape[-1], times.size))
    near = np.zeros(len(out), dtype=bool)
    seconds = len(out) * (PLAIN + PLAIN_TIME * out[0].size)
    kernel = choice.swiftest(respond, seconds)

    def work(begin: int, end: int) -> None:
        memory = room(kind, plants[2].shape[1:], first, second)
        with np.errstate(all="ignore"):  # what is beyond all numbers is infinite
            kernel(rising, plants, first, second, which, out, near, memory, begin, end)

    in_slices(work, len(out), 0.0 if kernel is respond else COMPILED * seconds)
    if order is not None:
        out[..., order] = out.copy()
    return out.reshape(*shape, *out.shape[1:]), near.reshape(shape) if near.any() else None


def _which(batches: tuple[tuple[int, ...], ...], shape: tuple[int, ...]) -> IntArray:
    """For each case its positions in the batches, ``(len(batches), cases)``."""
    if not shape:
        return np.zeros((len(batches), 1), np.int64)
    rows = [np.arange(prod(batch)).reshape(batch) for batch in batches]
    return np.stack([np.broadcast_to(row, shape).ravel() for row in rows])
