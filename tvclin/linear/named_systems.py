"""Systems of python-control as `LinearSystem`, with the names and sizes of their signals checked.

A state space keeps its matrices. A transfer function becomes the observer form of its common
denominator; of several outputs only where the states of the first one give all of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from math import prod
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from tvclin.base.arrays import ComplexArray, FloatArray
from tvclin.base.errors import InputError, finite, shown
from tvclin.linear.system import LinearSystem
from tvclin.numerics.modal import is_unstable

if TYPE_CHECKING:
    import control

    AnySystem: TypeAlias = "LinearSystem | control.StateSpace | control.TransferFunction"

_HIDDEN = 1e-12
"""Size of an eigenvector in an input or output, relative, that counts as zero."""
_ON_CIRCLE = 1e-9
"""Distance of a pole z beyond the unit circle that counts as on it."""
_RELATIVE_RESIDUAL = 1e-8
"""Largest error of a transfer function that is written with the states of another, relative."""


def named_system(
    name: str,
    system: AnySystem,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
) -> LinearSystem:
    """Return a system of python-control as `LinearSystem`, with its sample time as `period`.

    `name`: of the system in messages. `system`: of python-control, or already a `LinearSystem`.
    `inputs`, `outputs`: names of the signals, in place of the system's. `InputError` for another
    type, numbers that are not finite, sizes that do not fit, names that are repeated, an improper
    transfer function, and an unspecified sample time.
    """
    if isinstance(system, LinearSystem):
        matrices: tuple[FloatArray, ...] = system.matrices()
        period = system.period
        names, states = {"inputs": system.inputs, "outputs": system.outputs}, system.states
    else:
        import control

        if not isinstance(system, control.StateSpace | control.TransferFunction):
            raise InputError(
                f"{name} must be a control.StateSpace or control.TransferFunction; got"
                f" {shown(system)}"
            )
        period = _period(name, system.dt)
        is_ss = isinstance(system, control.StateSpace)
        matrices = (
            (system.A, system.B, system.C, system.D) if is_ss else _observer_form(name, system)
        )
        names = {"inputs": tuple(system.input_labels), "outputs": tuple(system.output_labels)}
        count = len(matrices[0])
        states = tuple(system.state_labels) if is_ss else tuple(f"x_{k}" for k in range(count))
    for kind, replacement in (("inputs", inputs), ("outputs", outputs)):
        if replacement is not None:
            names[kind] = _names(f"{kind} of {name}", replacement, len(names[kind]))
    return checked_system(name, matrices, **names, states=states, period=period)


def checked_system(
    name: str,
    matrices: Sequence[Any],
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    states: tuple[str, ...],
    period: Any = None,
) -> LinearSystem:
    """Return the system of matrices A, B, C and D; `InputError` for sizes or names that do not fit.

    `name`: name of the system in messages. `matrices`: A, B, C and D. `inputs`, `outputs`,
    `states`: names of the signals. `period`: sample time [s]; None in continuous time.
    """
    A, B, C, D = (finite(f"{m} of {name}", a) for m, a in zip("ABCD", matrices, strict=True))
    n, m, p = A.shape[-1] if A.ndim > 1 else 0, len(inputs), len(outputs)
    sizes = {"A": (A, (n, n)), "B": (B, (n, m)), "C": (C, (p, n)), "D": (D, (p, m))}
    for letter, (matrix, size) in sizes.items():
        if matrix.shape[-2:] != size:
            raise InputError(
                f"{letter} of {name} must be {size[0]} by {size[1]}, for {n} states, {m} inputs and"
                f" {p} outputs; got {' by '.join(map(str, matrix.shape)) or 'a number'}"
            )
    if len(states) != n:
        raise InputError(f"{name} must have a name for each of its {n} states; got {len(states)}")
    for kind, names in (("inputs", inputs), ("outputs", outputs), ("states", states)):
        repeated = sorted({signal for signal in names if names.count(signal) > 1})
        if repeated:
            raise InputError(f"{kind} of {name} must have different names; {repeated[0]} is twice")
    return LinearSystem(A, B, C, D, inputs, outputs, states, period)


def require_signals(
    name: str, kind: str, needed: Iterable[str], available: Sequence[str], remedy: str = ""
) -> None:
    """Raise `InputError` for a required signal that a system does not have; it names a similar one.

    `name`: the system. `kind`: "input" or "output". `needed`: names of the required signals.
    `available`: names of the signals that the system has. `remedy`: end of the message.
    """
    for signal in needed:
        if signal not in available:
            similar = get_close_matches(signal, available, n=1, cutoff=0.5)
            hint = f" (is {similar[0]} meant?)" if similar else ""
            raise InputError(
                f"{name} has no {kind} {signal}; its {kind}s are {', '.join(available) or 'none'}"
                f"{hint}{remedy}"
            )


def eigenvectors(A: FloatArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Return eigenvalues p ``(..., n)`` by falling real part, left rows and right columns.

    `A`: ``(..., n, n)``. Rows l of l A = p l and columns r of A r = p r, ``(..., n, n)`` each, have
    length one.
    """
    from scipy.linalg import eig  # late: it takes 0.1 s to import

    n = A.shape[-1]
    flat = A.reshape(prod(A.shape[:-2]), n, n)
    values, (left, right) = np.zeros((len(flat), n), complex), np.zeros((2, *flat.shape), complex)
    for k, matrix in enumerate(flat):
        if not n:
            continue
        roots, rows, columns = eig(matrix, left=True, right=True)
        order = np.lexsort((-roots.imag, -roots.real))
        values[k], left[k], right[k] = roots[order], rows.conj().T[order], columns[:, order]
    return values.reshape(A.shape[:-1]), left.reshape(A.shape), right.reshape(A.shape)


def check_hidden_modes(
    name: str,
    modes: tuple[ComplexArray, ComplexArray, ComplexArray],
    B: FloatArray,
    C: FloatArray,
    faults: tuple[str, str],
    period: FloatArray | None = None,
) -> None:
    """Raise `InputError` for an unstable mode that no input reaches, or that is in no output.

    `name`: of the system in the message. `modes`: eigenvalues [1/s, or z], left rows and right
    columns of A, from `eigenvectors`. `B`, `C`: matrices of the inputs ``(..., n, m)`` and outputs
    ``(..., p, n)``. `faults`: ends of the message, as "the deflection does not reach", for a mode
    that no input reaches, and for one in no output. `period`: sample time [s]; None in continuous
    time.
    """
    poles, left, right = modes
    if not poles.size:
        return
    unstable = is_unstable(poles) if period is None else np.abs(poles) > 1.0 + _ON_CIRCLE
    not_reached, not_shown = faults
    for rows, columns, fault in (
        (left, B, not_reached),
        (np.swapaxes(right, -1, -2), np.swapaxes(C, -1, -2), not_shown),
    ):
        # of each mode with all inputs, or all outputs; the eigenvectors have length one
        products = np.linalg.norm(rows @ columns, axis=-1)
        sizes = np.linalg.norm(columns, axis=(-1, -2))[..., np.newaxis]
        hidden = unstable & (products <= _HIDDEN * sizes)
        if np.any(hidden):
            pole, unit = poles[hidden][0], "1/s" if period is None else "in z"
            pair = f" +- {abs(pole.imag):.6g}j" if pole.imag else ""
            raise InputError(
                f"{name} has an unstable mode at {pole.real:.6g}{pair} {unit} that {fault}"
            )


def _names(what: str, names: Sequence[str], count: int) -> tuple[str, ...]:
    """Return `count` names of signals as a tuple; `InputError` for another number of them.

    `what`: description of the names for the message, such as "inputs of plant".
    """
    if not isinstance(names, tuple | list) or not all(isinstance(name, str) for name in names):
        raise InputError(f"{what} must be a tuple of names; got {shown(names)}")
    if len(names) != count:
        raise InputError(f"{what} must be {count} names; got {len(names)}")
    return tuple(names)


def _period(name: str, dt: Any) -> FloatArray | None:
    """Return the sample time [s] of a system; None in continuous time.

    `name`: of the system in the message. `dt`: sample time as python-control states it: zero or
    None in continuous time, True where it is not specified, which is an `InputError`.
    """
    if dt is None or (dt == 0 and dt is not False):
        return None
    if isinstance(dt, bool):
        raise InputError(f"{name} must have a sample time in seconds; its dt is {dt}")
    return np.asarray(float(dt))


def _observer_form(name: str, system: control.TransferFunction) -> tuple[FloatArray, ...]:
    """Return A, B, C and D of transfer functions with a common denominator for each output.

    `name`: of the system in the message. `InputError` for an improper transfer function, and for
    outputs that do not share the states of one system.
    """
    # numerator and denominator of output i from input j, without leading zeros
    rows = [
        [
            [np.trim_zeros(np.atleast_1d(p[i][j]), "f") for p in (system.num, system.den)]
            for j in range(system.ninputs)
        ]
        for i in range(system.noutputs)
    ]
    for row in rows:
        for numerator, denominator in row:
            if numerator.size > denominator.size:
                raise InputError(
                    f"{name} must be proper: a numerator of degree {numerator.size - 1} is over a"
                    f" denominator of degree {denominator.size - 1}"
                )
    A, B, C, D = _row_form(rows[0])
    for row in rows[1:]:
        *output_form, D_k = _row_form(row)
        C = np.vstack([C, _same_states(name, (A, B), output_form)])
        D = np.vstack([D, D_k])
    return A, B, C, D


def _row_form(row: list[list[FloatArray]]) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return A, B, C and D of one output: an observer form for each different denominator.

    The observer form of (b_0 s^n + .. + b_n)/(s^n + a_1 s^(n-1) + .. + a_n) has -a_k in the first
    column of A, ones above its diagonal, b_k - b_0 a_k in B, C = (1, 0, ..) and D = b_0.

    `row`: numerator and denominator from each input, coefficients with the highest power first.
    """
    normalised = [(num / den[0], den / den[0]) for num, den in row]
    different: list[FloatArray] = []
    for _, denominator in normalised:
        if not any(np.array_equal(denominator, polynomial) for polynomial in different):
            different.append(denominator)
    n, count = sum(denominator.size - 1 for denominator in different), len(row)
    A, B, C, D = np.zeros((n, n)), np.zeros((n, count)), np.zeros((1, n)), np.zeros((1, count))
    start = 0
    for denominator in different:
        order = denominator.size - 1
        block = slice(start, start + order)
        A[block, block] = np.eye(order, k=1)
        A[block, start : start + 1] = -denominator[1:, np.newaxis]
        C[0, start : start + 1] = 1.0
        for j, (numerator, its_denominator) in enumerate(normalised):
            if np.array_equal(its_denominator, denominator):
                padded = np.pad(numerator, (denominator.size - numerator.size, 0))
                D[0, j] = padded[0]
                B[block, j] = padded[1:] - padded[0] * denominator[1:]
        start += order
    return A, B, C, D


def _same_states(
    name: str, states: tuple[FloatArray, FloatArray], output_form: list[FloatArray]
) -> FloatArray:
    """Return the row of C ``(1, n)`` of an output on the states of the first output.

    `name`: of the system in the message. `states`: A and B of the first output. `output_form`: A, B
    and C of this output alone. The row c follows from equal Markov parameters, c A^k B of the first
    system and C A^k B of the second, by least squares; `InputError` where no row gives them.
    """
    (A, B), (A_k, B_k, C_k) = states, output_form
    count = len(A) + len(A_k)  # that many equal parameters make two systems of these orders equal
    controllability, markov = [B], [C_k @ B_k]
    for _ in range(count - 1):
        controllability.append(A @ controllability[-1])
        B_k = A_k @ B_k
        markov.append(C_k @ B_k)
    left, right = np.hstack(controllability), np.hstack(markov)  # row @ left = right
    scale = np.abs(left).max(axis=0, initial=0.0)
    scale = np.where(scale > 0.0, scale, 1.0)
    row, *_ = np.linalg.lstsq((left / scale).T, (right / scale).T, rcond=None)
    row = row.T
    error = np.abs((row @ left - right) / scale).max(initial=0.0)
    if not error <= _RELATIVE_RESIDUAL * np.abs(right / scale).max(initial=0.0):
        raise InputError(
            f"{name} must be a control.StateSpace: its transfer functions do not share the states"
            " of one system"
        )
    return np.asarray(row)
