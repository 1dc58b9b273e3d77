"""Exact response of a sum of modes to piecewise inputs, and its residues at the poles.

A mode that is not unstable is propagated from knot to knot. An unstable mode is written as

    z(t) = R e^(p t) - (remaining integral of its inputs, discounted with e^(-p (r - t))),

R being its residue. Where R is zero the remainder decays, so that nothing is lost; integrated
forward, the same mode would be the difference of two numbers that grow with e^(p t). A residue that
is zero within the rounding of its own sum counts as zero.

The kernel is `response_cases`, exact within 1e-13 of the largest value of each output in the times
that are requested.
"""

from dataclasses import dataclass
from functools import reduce
from math import prod
from typing import Any

import numpy as np

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray
from tvclin.kernels import choice
from tvclin.kernels.choice import in_slices
from tvclin.kernels.response_cases import (
    COMPILED_OVER_PLAIN,
    MARGINAL,
    PLAIN_SECONDS,
    PLAIN_SECONDS_PER_TIME,
    respond,
    workspace,
)
from tvclin.numerics.pieces import Pieces, flat_arrays, flat_batch, laplace, magnitude, spread

_EPSILON = float(np.finfo(float).eps)
_UNDERFLOW_EXPONENT = 750.0
"""Exponent at which e^-x underflows: later knots contribute nothing."""
_ROUNDINGS_PER_TERM = 32.0
"""Roundings in one term of a transform; its knots and its exponent add to them."""


def residues(
    poles: AnyArray, gains: tuple[AnyArray, ...], inputs: tuple[Pieces, ...], start: FloatArray
) -> tuple[AnyArray, FloatArray]:
    """Return the residue of the response at each pole, and its rounding error, both ``(..., N)``.

    The residue R of a pole p is the coefficient of e^(p (t - start)) in the response long after the
    inputs: the sum over the inputs of gain times the Laplace integral at p, from `start` on. The
    error is of rounding, by the sum of the sizes of all terms. `poles`: p [1/s], ``(..., N)``;
    NaN stays NaN. `gains`: for each input the residues of its transfer function at the poles,
    ``(..., N)``. `inputs`: the two input histories, whose batches broadcast with the poles.
    `start`: time from which e^(p t) counts [s], ``(...)``.
    """
    terms, sizes = [], []
    roundings = np.asarray(_ROUNDINGS_PER_TERM)
    for gain, pieces in zip(gains, inputs, strict=True):
        shifted = Pieces(pieces.knots - start[..., np.newaxis], pieces.coefficients, pieces.rates)
        terms.append(gain * _at_poles(laplace, shifted, poles))
        sizes.append(np.abs(gain) * _at_poles(magnitude, shifted, poles))
        # e^x of a rounded x has a relative error of x roundings, and a sum adds about sqrt(n)
        last = np.abs(shifted.knots[..., -1])[..., np.newaxis]
        exponent = np.minimum(np.abs(poles) * last, _UNDERFLOW_EXPONENT)
        roundings = roundings + exponent + np.sqrt(shifted.knots.shape[-1])
    return np.asarray(terms[0] + terms[1]), _EPSILON * roundings * np.real(sizes[0] + sizes[1])


def _at_poles(transform: Any, pieces: Pieces, poles: AnyArray) -> AnyArray:
    """Return a transform of input histories at each pole ``(..., N)`` [1/s]; NaN poles stay NaN.

    `transform`: function from `pieces`, the histories, and s ``(...)`` to the transform at s.
    """
    columns = []
    for pole in np.moveaxis(poles, -1, 0):
        missing = np.isnan(pole)
        transform_value = transform(pieces, np.where(missing, 1.0, pole))
        transform_value = transform_value if np.iscomplexobj(poles) else np.real(transform_value)
        columns.append(np.where(missing, np.nan, transform_value))
    return np.stack(columns, axis=-1) if columns else np.zeros((*poles.shape[:-1], 0))


@dataclass(frozen=True, slots=True)
class ModalSystem:
    """Plant as a sum of modes.

    `poles`: poles [1/s], ``(..., N)``. `gains`: gain of each input in each mode, ``(..., N, 2)``.
    `outputs`: coefficient of each mode in each output, ``(..., N, R)``. `less_wind`: whether the
    second input, the wind, is subtracted from the last output. `direct`: direct terms of the
    outputs from both inputs, ``(..., R, 2)``, which `responses` omits; None if there are no others.
    """

    poles: AnyArray
    gains: AnyArray
    outputs: AnyArray
    less_wind: bool = True
    direct: FloatArray | None = None


def is_unstable(poles: AnyArray) -> BoolArray:
    """Return which poles ``(..., N)`` [1/s] are unstable; those on the imaginary axis are not.

    On the axis is a real part within `MARGINAL`, relative to the largest pole of the plant.
    """
    size = reduce(np.maximum, np.moveaxis(np.abs(poles), -1, 0))  # quicker than along rows
    return np.asarray(np.real(poles) > MARGINAL * size[..., np.newaxis])


def responses(
    system: ModalSystem, inputs: tuple[Pieces, Pieces], times: FloatArray, shape: tuple[int, ...]
) -> tuple[FloatArray, BoolArray | None]:
    """Return the outputs ``(*shape, R, n)``, and the cases whose modes are not distinct.

    `system`: plants as sums of N modes with R outputs, from the last of which the wind is
    subtracted if `less_wind`. `inputs`: histories of deflection and wind.
    `times`: times [s], ``(n,)``, in any order. `shape`: of the batch, to which plants and inputs
    broadcast. The outputs have the units of the inputs. The second result has the shape `shape`,
    True where two poles are too close for separate modes within these times; it is None where this
    is nowhere the case.
    """
    histories = [spread(p, p.batch) if p.batch else p for p in inputs]
    arrays = [system.poles, *(a for h in histories for a in (h.coefficients, h.rates))]
    dtype = np.dtype(complex if any(a.dtype.kind == "c" for a in arrays) else float)
    mode_outputs = flat_batch(system.outputs, 2, dtype)
    plants = (
        flat_batch(system.poles, 1, dtype),
        flat_batch(system.gains, 2, dtype),
        mode_outputs,
        system.less_wind,
    )
    first, second = (flat_arrays(history, dtype) for history in histories)
    # flat position of each case in the batches of plants, deflections and winds, (3, cases)
    batches = (system.poles.shape[:-1], *(h.batch for h in histories))
    positions = [np.arange(prod(batch)).reshape(batch) for batch in batches]
    case_rows = np.stack([np.broadcast_to(rows, shape).ravel() for rows in positions])
    order = np.argsort(times) if np.any(times[1:] < times[:-1]) else None
    rising = times.copy() if order is None else times[order]
    out = np.empty((case_rows.shape[1], mode_outputs.shape[-1], times.size))
    indistinct = np.zeros(len(out), dtype=bool)
    # estimated run time, which decides between compiled and plain code
    seconds = len(out) * (PLAIN_SECONDS + PLAIN_SECONDS_PER_TIME * out[0].size)
    kernel = choice.fastest(respond, seconds)

    def work(begin: int, end: int) -> None:
        """Compute the outputs of the cases from `begin` up to, not including, `end`, into `out`.

        `rising`: the times. `first`, `second`: both inputs. `case_rows`: their positions by case.
        """
        memory = workspace(dtype, mode_outputs.shape[1:], first, second)
        with np.errstate(all="ignore"):  # overflows are infinite
            kernel(rising, plants, first, second, case_rows, out, indistinct, memory, begin, end)

    # in threads by the run time of compiled code; plain code, of time 0.0, in one thread
    in_slices(work, len(out), 0.0 if kernel is respond else COMPILED_OVER_PLAIN * seconds)
    if order is not None:
        out[..., order] = out.copy()
    outputs = out.reshape(*shape, *out.shape[1:])
    return outputs, indistinct.reshape(shape) if indistinct.any() else None
