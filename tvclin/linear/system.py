"""Linear systems with named signals, one or a batch, in continuous time or in steps.

    x' = A x + B u,            y = C x + D u,            or
    x[k+1] = A x[k] + B u[k],  y[k] = C x[k] + D u[k]

A block diagram is a list of them: `connect` joins what has the same name. Vehicle, nozzle, filters
and laws are such blocks, and margins, poles, responses and the steps of flights are made of what
comes out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import ComplexArray, FloatArray, IndexArray
from tvclin.base.errors import InputError, broadcast
from tvclin.numerics import state_space
from tvclin.numerics.propagation import augmented_matrix, matrix_exponentials

if TYPE_CHECKING:
    import control

Names = tuple[str, ...]
Matrices = tuple[FloatArray, FloatArray, FloatArray, FloatArray]

WHOLE = 1e-9
"""So near to a whole number of samples a delay is one."""


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """A linear system with named inputs, outputs and states; the batch leads the matrices.

    The batches of the matrices broadcast. `period`: length of a step [s], ``(...)``; None in
    continuous time.
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray
    inputs: Names
    outputs: Names
    states: Names
    period: FloatArray | None = None

    def matrices(self) -> Matrices:
        """Return A, B, C and D."""
        return self.A, self.B, self.C, self.D

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch; ``()`` for one system."""
        return np.broadcast_shapes(*(one.shape[:-2] for one in self.matrices()))

    @property
    def poles(self) -> ComplexArray:
        """The eigenvalues of A, ``(..., n)``: s [1/s], or z in steps."""
        return np.linalg.eigvals(self.A).astype(complex)

    def series(self, behind: LinearSystem) -> LinearSystem:
        """Return this system with another behind it, whose inputs are the outputs of this one."""
        found = state_space.series(self.matrices(), behind.matrices())
        names = (self.inputs, behind.outputs, (*self.states, *behind.states))
        return LinearSystem(*found, *names, self.period)

    def feedback(self, output: str, input: str) -> LinearSystem:
        """Return the system with an output added to an input, which is then no input any more.

        `InputError` where the output follows that input at once.
        """
        back = gain(input, {output: 1.0})
        inputs = tuple(name for name in self.inputs if name != input)
        return connect([self, back], inputs, self.outputs)

    def select(self, inputs: Sequence[str], outputs: Sequence[str]) -> LinearSystem:
        """Return the system with some of its inputs and outputs, in this order."""
        into = [self.inputs.index(name) for name in inputs]
        out = [self.outputs.index(name) for name in outputs]
        B, C, D = self.B[..., into], self.C[..., out, :], self.D[..., out, :][..., into]
        return replace(self, B=B, C=C, D=D, inputs=tuple(inputs), outputs=tuple(outputs))

    def renamed(self, inputs: Mapping[str, str]) -> LinearSystem:
        """Return the system with other names of some inputs."""
        return replace(self, inputs=tuple(inputs.get(name, name) for name in self.inputs))

    def cases(self, index: IndexArray, shape: tuple[int, ...]) -> LinearSystem:
        """Return the systems at flat positions ``(k,)`` of the batch broadcast to `shape`."""

        def selected(array: FloatArray, axes: int) -> FloatArray:
            trailing = array.shape[array.ndim - axes :]
            return np.broadcast_to(array, (*shape, *trailing)).reshape(prod(shape), *trailing)[
                index
            ]

        period = None if self.period is None else selected(self.period, 0)
        A, B, C, D = (selected(matrix, 2) for matrix in self.matrices())
        return replace(self, A=A, B=B, C=C, D=D, period=period)

    def to_steps(self, period: ArrayLike, delay: ArrayLike = 0.0) -> LinearSystem:
        """Return the system as a computer sees it whose commands are held from sample to sample.

        Exactly: with d whole samples of the delay and a rest f,

            x[k+1] = F x[k] + G0 u[k-d] + G1 u[k-d-1],    e^([A, B; 0, 0] t) = [E(t), P(t); 0, 1],
            F = E(h - f) E(f),    G0 = P(h - f),    G1 = E(h - f) P(f),

        and commands that have not arrived are states. `period`: h [s], ``(...)``. `delay`: from a
        sample until its command acts [s], ``(...)``; `InputError` with one, for more inputs than
        one, and outputs that follow at once.
        """
        h, late = np.asarray(period, float), np.asarray(delay, float)
        whole, rest = delay_parts(late, h)
        shape = broadcast(system=self.batch, period=h.shape, delay=late.shape)
        parts = [h - rest, rest] if np.any(rest) else [h]
        n, moved = len(self.states), [self._moved(np.broadcast_to(one, shape)) for one in parts]
        F, pushes = moved[0][..., :n], [moved[0][..., n:]]
        if np.any(rest):
            F, pushes = F @ moved[1][..., :n], [*pushes, F @ moved[1][..., n:]]
        period = np.broadcast_to(h, shape)
        if not np.any(late):
            return replace(self, A=F, B=pushes[0], period=period)
        if len(self.inputs) > 1 or np.any(self.D):
            raise InputError("a delayed system needs one input, which no output follows at once")
        # The commands on their way: u[k-1], u[k-2], .., as many as the longest delay asks for.
        count = int((whole + (rest > 0.0)).max(initial=0))
        pushed = np.zeros((*shape, n, 1 + count))  # by u[k], u[k-1], ..
        for k, push in enumerate(pushes):
            pushed += push * (np.arange(1 + count) == (whole + k)[..., np.newaxis, np.newaxis])
        A = np.zeros((*shape, n + count, n + count))
        B = np.zeros((*shape, n + count, 1))
        A[..., :n, :n], A[..., :n, n:], B[..., :n, :] = F, pushed[..., 1:], pushed[..., :1]
        A[..., n:, n:], B[..., n:, 0] = np.eye(count, k=-1), np.eye(1, count)[0]
        C = state_space.beside(self.C, np.zeros((len(self.outputs), count)))
        waiting = tuple(f"{self.inputs[0]}_{k}" for k in range(1, count + 1))
        states = (*self.states, *waiting)
        return replace(self, A=A, B=B, C=C, states=states, period=period)

    def _moved(self, times: FloatArray) -> FloatArray:
        """States a time [s] later, ``(..., n, n + inputs)``: of states and inputs, which are held.

        The batch of times is that of the whole.
        """
        whole = augmented_matrix(self.A, self.B)
        shape = (*times.shape, *whole.shape[-2:])
        every = np.broadcast_to(whole, shape).reshape(-1, *shape[-2:])
        return matrix_exponentials(every, times.ravel()).reshape(shape)[..., : len(self.states), :]

    def to_control(self, name: str) -> control.StateSpace:
        """Return one system as `control.StateSpace`; `InputError` for a batch."""
        import control

        if self.batch:
            raise InputError(f"to_control() is for one system; got a batch of shape {self.batch}")
        signals = {"inputs": self.inputs, "outputs": self.outputs, "states": self.states}
        named = {kind: list(names) for kind, names in signals.items()}
        return control.StateSpace(*self.matrices(), 0, name=name, **named)


def delay_parts(
    delay: float | FloatArray, period: float | FloatArray
) -> tuple[IndexArray, FloatArray]:
    """Return the whole samples of a delay, and the rest [s] of it."""
    samples = delay / np.where(period > 0.0, period, 1.0)
    whole = np.floor(samples + WHOLE)
    rest = np.where(samples - whole > WHOLE, samples - whole, 0.0) * period
    return whole.astype(np.intp), rest


def gain(output: str, factors: Mapping[str, ArrayLike]) -> LinearSystem:
    """Return the block without states of one output, the sum of inputs times their factors."""
    rows = np.stack(np.broadcast_arrays(*(np.asarray(f, float) for f in factors.values())), -1)
    none = (np.zeros((0, 0)), np.zeros((0, len(factors))), np.zeros((1, 0)))
    return LinearSystem(*none, rows[..., np.newaxis, :], tuple(factors), (output,), ())


def rising(name: str, terms: int) -> LinearSystem:
    """Return the block without inputs whose output is a polynomial of the time, c0 + c1 t + ...

    Its states are the coefficients about now.
    """
    A, C = np.diag(np.arange(1.0, terms), k=1), np.eye(1, terms)
    states = tuple(f"{name}_{k}" for k in range(terms))
    return LinearSystem(A, np.zeros((terms, 0)), C, np.zeros((1, 0)), (), (name,), states)


def connect(
    blocks: Sequence[LinearSystem], inputs: Sequence[str], outputs: Sequence[str]
) -> LinearSystem:
    """Return the system of blocks whose signals are joined by their names.

    A signal is the sum of all outputs, and of the input from outside, that have its name; it goes
    to every input of that name. `blocks`: all in continuous time, or all in steps of one length.
    `inputs`, `outputs`: what comes from outside, and the signals to look at. `InputError` for an
    algebraic loop, in which a signal follows itself at once.
    """
    given = [name for one in blocks for name in one.inputs]
    made = [name for one in blocks for name in one.outputs]
    A, B, C, D = (_diagonal([one.matrices()[k] for one in blocks]) for k in range(4))
    # u = K y + L w and y = C x + D u, so that y = (1 + D K + (D K)^2 + ..) (C x + D L w).
    K, L = _same(given, made), _same(given, inputs)
    once = D @ K
    through, power = np.eye(len(made)) + once, once
    for _ in made:
        power = power @ once
        if not np.any(power):
            break
        through = through + power
    else:
        raise InputError("this is an algebraic loop: a signal follows itself at once")
    seen, passed = through @ C, through @ (D @ L)
    augmented_matrix = B @ K
    P, Q = _same(outputs, made), _same(outputs, inputs)
    found = (
        A + augmented_matrix @ seen,
        augmented_matrix @ passed + B @ L,
        P @ seen,
        P @ passed + Q,
    )
    batch = np.broadcast_shapes(*(one.shape[:-2] for one in found))
    A, B, C, D = (np.broadcast_to(one, (*batch, *one.shape[-2:])) for one in found)
    states = tuple(name for one in blocks for name in one.states)
    period = next((one.period for one in blocks if one.period is not None), None)
    return LinearSystem(A, B, C, D, tuple(inputs), tuple(outputs), states, period)


def _same(rows: Sequence[str], columns: Sequence[str]) -> FloatArray:
    """One where the names are the same."""
    found = [[row == column for column in columns] for row in rows]
    return np.array(found, float).reshape(len(rows), len(columns))


def _diagonal(parts: Sequence[FloatArray]) -> FloatArray:
    """The parts along the diagonal."""
    batch = np.broadcast_shapes(*(one.shape[:-2] for one in parts))
    sizes = np.array([one.shape[-2:] for one in parts])
    whole = np.zeros((*batch, *sizes.sum(axis=0)))
    ends = np.cumsum(sizes, axis=0)
    for one, (rows, columns), (bottom, right) in zip(parts, sizes, ends, strict=True):
        whole[..., bottom - rows : bottom, right - columns : right] = one
    return whole
