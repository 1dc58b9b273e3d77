"""Linear systems with named signals, in batches, in continuous or in discrete time.

    x' = A x + B u,            y = C x + D u,            or
    x[k+1] = A x[k] + B u[k],  y[k] = C x[k] + D u[k]

A block diagram is a list of systems: `connect` joins signals of the same name. Vehicle, nozzle,
filters and laws are such blocks, from which margins, poles, responses and the steps of flights are
computed.
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
from tvclin.numerics.propagation import augmented_matrix, constant_generator, matrix_exponentials
from tvclin.numerics.state_space import Matrices

if TYPE_CHECKING:
    import control

Names = tuple[str, ...]
WHOLE_SAMPLE_TOLERANCE = 1e-9
"""Distance of a delay from a whole number of samples, in samples, that counts as zero."""
_ALGEBRAIC_LOOP = "this is an algebraic loop: a signal follows itself at once"


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """Linear system with named inputs, outputs and states; matrices have leading batch axes.

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
        """Return the matrices A, B, C and D."""
        return self.A, self.B, self.C, self.D

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch; ``()`` for one system."""
        return np.broadcast_shapes(*(matrix.shape[:-2] for matrix in self.matrices()))

    @property
    def poles(self) -> ComplexArray:
        """Eigenvalues of A, ``(..., n)``: s [1/s], or z in discrete time."""
        return np.linalg.eigvals(self.A).astype(complex)

    def series(self, behind: LinearSystem) -> LinearSystem:
        """Return the series connection of this system and the system `behind` it.

        The inputs of `behind` are the outputs of this system, in its order.
        """
        matrices = state_space.series(self.matrices(), behind.matrices())
        states = (*self.states, *behind.states)
        return LinearSystem(*matrices, self.inputs, behind.outputs, states, self.period)

    def feedback(self, output: str, input: str) -> LinearSystem:
        """Return the system with an output added to an input, which stays an input as well.

        `output`, `input`: names of both signals. `InputError` for an output that follows the input
        at once, which makes an algebraic loop.
        """
        A, B, C, D = self.matrices()
        into, out = self.inputs.index(input), self.outputs.index(output)
        if np.any(D[..., out, into]):
            raise InputError(_ALGEBRAIC_LOOP)
        # columns of B and D of the input, and rows of C and D of the output, which is added to it
        B_column, D_column = B[..., into, np.newaxis], D[..., into, np.newaxis]
        C_row, D_row = C[..., out, np.newaxis, :], D[..., out, np.newaxis, :]
        return replace(
            self,
            A=A + B_column * C_row,
            B=B + B_column * D_row,
            C=C + D_column * C_row,
            D=D + D_column * D_row,
        )

    def select(self, inputs: Sequence[str], outputs: Sequence[str]) -> LinearSystem:
        """Return the system with the selected inputs and outputs alone, in the order of names."""
        into = [self.inputs.index(name) for name in inputs]
        out = [self.outputs.index(name) for name in outputs]
        B, C, D = self.B[..., into], self.C[..., out, :], self.D[..., out, :][..., into]
        return replace(self, B=B, C=C, D=D, inputs=tuple(inputs), outputs=tuple(outputs))

    def with_outputs(self, rows: Mapping[str, tuple[FloatArray, FloatArray]]) -> LinearSystem:
        """Return the system with further outputs.

        `rows`: row of C ``(..., n)`` and row of D ``(..., inputs)`` of each, by its name.
        """
        C_rows = np.stack([row for row, _ in rows.values()], axis=-2)
        D_rows = np.stack([row for _, row in rows.values()], axis=-2)
        C, D = np.concatenate([self.C, C_rows], axis=-2), np.concatenate([self.D, D_rows], axis=-2)
        return replace(self, C=C, D=D, outputs=(*self.outputs, *rows))

    def renamed(self, inputs: Mapping[str, str]) -> LinearSystem:
        """Return the system with some inputs renamed; `inputs`: new names by the old names."""
        return replace(self, inputs=tuple(inputs.get(name, name) for name in self.inputs))

    def cases(self, index: IndexArray, shape: tuple[int, ...]) -> LinearSystem:
        """Return the systems at flat positions `index` ``(k,)`` of a batch of the shape `shape`."""

        def selected(array: FloatArray, size: tuple[int, ...]) -> FloatArray:
            """Return the selected cases of an array of the shape batch + size."""
            return np.broadcast_to(array, (*shape, *size)).reshape(prod(shape), *size)[index]

        period = None if self.period is None else selected(self.period, ())
        A, B, C, D = (selected(matrix, matrix.shape[-2:]) for matrix in self.matrices())
        return replace(self, A=A, B=B, C=C, D=D, period=period)

    def to_steps(self, period: ArrayLike, delay: ArrayLike = 0.0) -> LinearSystem:
        """Return the exact discretisation with a zero-order hold of the inputs.

        With d whole samples of the delay and a remainder f,

            x[k+1] = F x[k] + G0 u[k-d] + G1 u[k-d-1],    e^([A, B; 0, 0] t) = [E(t), P(t); 0, 1],
            F = E(h - f) E(f),    G0 = P(h - f),    G1 = E(h - f) P(f),

        and delayed commands are states. `period`: h [s], ``(...)``. `delay`: from a sample until
        its command acts [s], ``(...)``; `InputError` for a delay with several inputs or a direct
        feedthrough.
        """
        h, delays = np.asarray(period, float), np.asarray(delay, float)
        complete, remainder = split_delay(delays, h)
        shape = broadcast(system=self.batch, period=h.shape, delay=delays.shape)
        intervals = [h - remainder, remainder] if np.any(remainder) else [h]
        n = len(self.states)
        (F, G0), *rest = (self._transition(np.broadcast_to(time, shape)) for time in intervals)
        input_matrices = [G0]
        for E, P in rest:  # over the remainder f; so far F = E(h - f)
            F, input_matrices = F @ E, [G0, F @ P]
        period = np.broadcast_to(h, shape)
        if not np.any(delays):
            return replace(self, A=F, B=G0, period=period)
        if len(self.inputs) > 1 or np.any(self.D):
            raise InputError("a delayed system needs one input, which no output follows at once")
        # Delayed commands u[k-1], u[k-2], .., as many as the longest delay has.
        count = int((complete + (remainder > 0.0)).max(initial=0))
        # columns by u[k], u[k-1], ..: G0 at d whole samples of the case, G1 at d + 1
        input_matrix = np.zeros((*shape, n, 1 + count))
        for k, matrix in enumerate(input_matrices):
            input_matrix += matrix * (
                np.arange(1 + count) == (complete + k)[..., np.newaxis, np.newaxis]
            )
        A = np.zeros((*shape, n + count, n + count))
        B = np.zeros((*shape, n + count, 1))
        A[..., :n, :n], A[..., :n, n:] = F, input_matrix[..., 1:]
        B[..., :n, :] = input_matrix[..., :1]
        # each delayed command takes the value of the one before it, the first that of the input
        A[..., n:, n:], B[..., n : n + 1, 0] = np.eye(count, k=-1), 1.0
        C = state_space.join_columns(self.C, np.zeros((len(self.outputs), count)))
        delayed = tuple(f"{self.inputs[0]}_{k}" for k in range(1, count + 1))
        states = (*self.states, *delayed)
        return replace(self, A=A, B=B, C=C, states=states, period=period)

    def _transition(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return E ``(..., n, n)`` and P ``(..., n, inputs)`` of x(t) = E x(0) + P u, u constant.

        `times`: times t [s], ``(...)``, one for each case of the batch.
        """
        generator, n = augmented_matrix(self.A, self.B), len(self.states)
        shape = (*times.shape, *generator.shape[-2:])
        generators = np.broadcast_to(generator, shape).reshape(-1, *shape[-2:])
        transition = matrix_exponentials(generators, times.ravel()).reshape(shape)
        return transition[..., :n, :n], transition[..., :n, n:]

    def to_control(self, name: str) -> control.StateSpace:
        """Return one system as `control.StateSpace` of this name; `InputError` for a batch."""
        import control

        if self.batch:
            raise InputError(
                f"ss() is for one system; this is a batch of shape {self.batch} (use matrices())"
            )
        signals = {"inputs": self.inputs, "outputs": self.outputs, "states": self.states}
        named = {kind: list(names) for kind, names in signals.items()}
        dt = 0 if self.period is None else float(self.period)
        return control.StateSpace(*self.matrices(), dt, name=name, **named)


def constant_over_steps(
    first: LinearSystem, second: LinearSystem, lengths: FloatArray
) -> LinearSystem:
    """Return constant systems, one for each step, in place of a system that varies over the steps.

    Their states at the ends of the steps are exact to fourth order in the length. `first`,
    `second`: the system at the first and second Gauss point of each step. `lengths`: of the steps
    [s]; batches of all three broadcast. C and D are those of `first`.
    """
    at_first, at_second = (augmented_matrix(system.A, system.B) for system in (first, second))
    matrix, n = constant_generator(at_first, at_second, lengths), len(first.states)
    return replace(first, A=matrix[..., :n, :n], B=matrix[..., :n, n:])


def split_delay(
    delay: float | FloatArray, period: float | FloatArray
) -> tuple[IndexArray, FloatArray]:
    """Return the number of whole samples of a delay ``(...)``, and its remainder [s].

    `delay`, `period`: delay and sampling period [s], ``(...)``, which broadcast. With a period of
    zero, for continuous time, the number has no meaning and the remainder is zero. A delay within
    rounding of a whole number of samples has no remainder.
    """
    samples = delay / np.where(period > 0.0, period, 1.0)
    complete = np.floor(samples + WHOLE_SAMPLE_TOLERANCE)
    rest = samples - complete  # in samples
    remainder = np.where(rest > WHOLE_SAMPLE_TOLERANCE, rest, 0.0) * period
    return complete.astype(np.intp), remainder


def gain(output: str, factors: Mapping[str, ArrayLike]) -> LinearSystem:
    """Return the static block with the output `output`, the sum of inputs times their factors.

    `factors`: factor ``(...)`` of each input, by its name.
    """
    rows = np.stack(np.broadcast_arrays(*(np.asarray(f, float) for f in factors.values())), -1)
    return LinearSystem(
        A=np.zeros((0, 0)),
        B=np.zeros((0, len(factors))),
        C=np.zeros((1, 0)),
        D=rows[..., np.newaxis, :],
        inputs=tuple(factors),
        outputs=(output,),
        states=(),
    )


def polynomial_input(name: str, terms: int) -> LinearSystem:
    """Return the block without inputs whose output is a polynomial of the time, c0 + c1 t + ...

    `name`: name of the output. `terms`: number of coefficients; they, about the current time, are
    the states, so that c0' = c1, c1' = 2 c2, ...
    """
    return LinearSystem(
        A=np.diag(np.arange(1.0, terms), k=1),
        B=np.zeros((terms, 0)),
        C=np.eye(1, terms),
        D=np.zeros((1, 0)),
        inputs=(),
        outputs=(name,),
        states=tuple(f"{name}_{k}" for k in range(terms)),
    )


def connect(
    blocks: Sequence[LinearSystem], inputs: Sequence[str], outputs: Sequence[str]
) -> LinearSystem:
    """Return the system of blocks whose signals are joined by their names.

    A signal is the sum of all outputs, and of the external input, of its name; it drives every
    input of that name. `blocks`: all in continuous time, or in discrete time of one period.
    `inputs`, `outputs`: external inputs, observed signals. `InputError` for an algebraic loop.
    """
    block_inputs = [name for block in blocks for name in block.inputs]
    used = {*block_inputs, *outputs}
    blocks = [  # without outputs that nothing uses
        block.select(block.inputs, [k for k in block.outputs if k in used]) for block in blocks
    ]
    block_outputs = [name for block in blocks for name in block.outputs]
    A, B, C, D = (_block_diagonal([block.matrices()[k] for block in blocks]) for k in range(4))
    # Of inputs u and outputs y of the blocks, external inputs w and observed signals P y + Q w:
    # u = K y + L w and y = C x + D u, so that y = (1 + D K + (D K)^2 + ..) (C x + D L w); without
    # an algebraic loop a power of D K is zero. K, L, P and Q have a one where names are equal.
    K, L = _incidence(block_inputs, block_outputs), _incidence(block_inputs, inputs)
    loop_gain = _times(D, K)
    closed, power = np.eye(len(block_outputs)) + loop_gain, loop_gain
    for _ in block_outputs:
        power = power @ loop_gain
        if not np.any(power):
            break
        closed = closed + power
    else:
        raise InputError(_ALGEBRAIC_LOOP)
    state_outputs, feedthrough = closed @ C, closed @ _times(D, L)
    driven = _times(B, K)
    P, Q = _incidence(outputs, block_outputs), _incidence(outputs, inputs)
    matrices = (
        A + driven @ state_outputs,
        driven @ feedthrough + _times(B, L),
        P @ state_outputs,
        P @ feedthrough + Q,
    )
    batch = np.broadcast_shapes(*(matrix.shape[:-2] for matrix in matrices))
    A, B, C, D = (np.broadcast_to(matrix, (*batch, *matrix.shape[-2:])) for matrix in matrices)
    states = tuple(name for block in blocks for name in block.states)
    period = next((block.period for block in blocks if block.period is not None), None)
    return LinearSystem(A, B, C, D, tuple(inputs), tuple(outputs), states, period)


def _times(matrices: FloatArray, matrix: FloatArray) -> FloatArray:
    """Return the products ``(..., m, k)`` of matrices ``(..., m, n)`` and a matrix ``(n, k)``."""
    *batch, rows, columns = matrices.shape
    flat = matrices.reshape(prod(batch) * rows, columns) @ matrix
    return flat.reshape(*batch, rows, matrix.shape[1])


def _incidence(rows: Sequence[str], columns: Sequence[str]) -> FloatArray:
    """Return the matrix that is one where the names of row and column are equal, else zero."""
    equal = [[row == column for column in columns] for row in rows]
    return np.array(equal, float).reshape(len(rows), len(columns))


def _block_diagonal(blocks: Sequence[FloatArray]) -> FloatArray:
    """Return the block-diagonal matrix of blocks ``(..., m, n)``, whose batches broadcast."""
    batch = np.broadcast_shapes(*{block.shape[:-2] for block in blocks})
    size = (sum(block.shape[axis] for block in blocks) for axis in (-2, -1))
    matrix, row, column = np.zeros((*batch, *size)), 0, 0
    for block in blocks:
        rows, columns = block.shape[-2:]
        matrix[..., row : row + rows, column : column + columns] = block
        row, column = row + rows, column + columns
    return matrix
