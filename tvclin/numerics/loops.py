"""Loop transfer functions in batches, with an exact delay T, closed by 1 + L = 0.

In polynomial form L(s) = N(s)/D(s) e^(-s T) (`Rational`), and in state space
L(s) = (C (s - A)^-1 B + D) e^(-s T) (`StateLoop`), whose poles, zeros and crossings are eigenvalues
of the matrices themselves, so that orders of thirty and closely spaced modes keep their digits.

Closed, it has infinitely many poles: the delayed signal is a wave v(t, theta), -T <= theta <= 0,

    x' = A x + B v(-T),    dv/dt = dv/dtheta,    v(0) = -C x,

whose values at Chebyshev points are states like others (Breda, Maset and Vermiglio, SIAM J. Sci.
Comput. 27, 2005); `rightmost_poles` refines their eigenvalues to zeros of 1 + L(s).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tvclin.numerics import polynomials

_SUM_ROUNDING = 1e-13
"""Value, relative to the sum of the sizes of its terms, below which it is rounding: a zero."""
_MAX_FREQUENCY = 1e30
"""Frequency [rad/s] above which a root of Im L is at infinity."""
_MAX_EIGENVECTOR_CONDITION = 1e6
"""Condition number of the eigenvectors above which poles count as repeated."""
_INTEGRATOR_POLE = 1e-14
"""Pole, relative to the largest, below which it is an integrator."""
_INTEGRATOR_CLUSTER = 1e-7
"""Several poles below this, over the largest, are a repeated integrator split by rounding."""
_POLE_ROUNDING = 1e-13
"""Relative distance of a frequency from a pole, and of a last Newton step, that counts as zero."""
_ZERO_VALUE = 1e-11
"""Value of L, relative to the sum of the sizes of its terms, that counts as zero."""
_MAX_ZERO_OVER_LARGEST_POLE = 1e3
"""Ratio of a zero to the largest pole above which it is a zero at infinity."""
_GAIN_AXIS_TOLERANCE, _REAL_AXIS_TOLERANCE = 1e-4, 1e-3
"""Distance of eigenvalues from the axis, over their size, up to which they are candidates for
crossings of |L| and of Im L."""
_NEWTON_ITERATIONS, _MAX_RELATIVE_STEP = 20, 0.1
"""Newton iterations to a gain crossover, and the largest step over the frequency."""
_GAIN_TOLERANCE, _EQUAL_FREQUENCIES = 1e-9, 1e-9
"""Largest |ln(|L|/g)| of a crossover, and relative distance at which two crossovers are equal."""
_POLE_OFFSET = 1e-15
"""Offset from a pole, relative to the largest, at which a singular system is solved."""
_MIN_HAMILTONIAN_DIVISOR = 1e-8
"""Smallest |1 - D^2/g^2| in the Hamiltonian matrix."""
_POINTS_PER_BLOCK = 2**13
"""Points at which a sum over poles is evaluated together, so that they stay in the cache."""
_MAX_POINTS_OF_CUMULATIVE_SUMS = 256
"""Number of points above which terms are added one by one, which is then quicker."""
_ENTRIES_PER_BLOCK = 2**22
"""Entries of matrices that are solved together, to bound the memory."""
_CHEBYSHEV_POINTS = 48
"""Chebyshev points in the delay; poles with |s| T below half of their number are resolved."""
_DELAYED_POLE_ITERATIONS = 12
"""Newton iterations on 1 + L(s) from each eigenvalue."""
_DIFFERENCE_STEP = 1e-6
"""Half step of the central difference for dL/ds, relative to |s| + 1/T."""
_MAX_POLE_CORRECTION = 1e-5
"""Largest correction of an eigenvalue by Newton's method, relative to |s| + 1/T."""


@dataclass(frozen=True, eq=False)
class Rational:
    """Loops L(s) = numerator(s)/denominator(s) e^(-s delay) in polynomial form.

    `numerator`, `denominator`: coefficients, highest power first, both ``(..., n + 1)``. `delay`:
    delay [s], ``(...)``.
    """

    numerator: FloatArray
    denominator: FloatArray
    delay: FloatArray

    @property
    def direct(self) -> FloatArray:
        """Value of L at infinity without its delay, ``(...)``."""
        return np.asarray(self.numerator[..., 0] / self.denominator[..., 0])

    def parts(self, omega: ArrayLike) -> tuple[AnyArray, AnyArray]:
        """Return the numerator, with the delay, and the denominator at j omega, both ``(..., k)``.

        `omega`: frequencies [rad/s], ``(..., k)``.
        """
        omega = np.asarray(omega, dtype=float)
        N, D = self.undelayed(omega)
        if np.any(self.delay):
            N = product(N, np.exp(-1j * omega * self.delay[..., np.newaxis]))
        return N, D

    def value(self, s: AnyArray) -> AnyArray:
        """Return L with its delay at complex frequencies ``(..., k)`` [1/s], off the poles."""
        N, D = (polynomials.value(p, s) for p in (self.numerator, self.denominator))
        return np.asarray(N / D * np.exp(-s * self.delay[..., np.newaxis]))

    def undelayed(self, omega: FloatArray) -> tuple[AnyArray, AnyArray]:
        """Return numerator and denominator at j omega, ``(..., k)``, without the delay.

        `omega`: frequencies [rad/s], ``(..., k)``.
        """
        return (
            polynomials.on_axis(self.numerator, omega),
            polynomials.on_axis(self.denominator, omega),
        )

    def log_slope(self, omega: FloatArray) -> AnyArray:
        """Return d ln G/d omega = j (N'/N - D'/D) of G = N/D, the loop without delay, at j omega.

        `omega`: frequencies [rad/s], ``(..., k)``.
        """
        N, D = self.undelayed(omega)
        dN, dD = (
            polynomials.on_axis(polynomials.derivative(p), omega)
            for p in (self.numerator, self.denominator)
        )
        return 1j * (product(dN, inverse(N)) - product(dD, inverse(D)))

    def open_poles(self) -> AnyArray:
        """Return the poles of L without delay, roots of its denominator [1/s], ``(..., n)``."""
        return polynomials.roots(self.denominator)

    def closed_poles(self) -> AnyArray:
        """Return the roots of denominator + numerator [1/s], closed-loop poles without delay."""
        return polynomials.roots(self.denominator + self.numerator)

    def zeros(self) -> AnyArray:
        """Return the roots [1/s] of k numerators of degree n, ``(k, n)``; NaN fills the rows."""
        return polynomials.roots_of_each(self.numerator)

    def crossovers(self, size: float) -> tuple[FloatArray, BoolArray]:
        """Return the frequencies [rad/s] with |L| = `size`, and whether |L| falls there.

        They are roots of |D|^2 size^2 - |N|^2 in omega^2, ascending; NaN fills the rows.
        """
        # polynomials in omega^2; the difference rises where |L| falls
        squares = polynomials.squared_size(self.denominator)
        squares = size**2 * squares - polynomials.squared_size(self.numerator)
        roots = polynomials.roots(squares)
        real = (np.imag(roots) == 0.0) & (np.real(roots) > 0.0)
        frequencies = np.sort(np.sqrt(np.where(real, np.real(roots), np.nan)), axis=-1)
        with np.errstate(invalid="ignore"):
            slope = polynomials.value(polynomials.derivative(squares), frequencies**2)
        return frequencies, np.asarray(slope > 0.0)

    def real_frequencies(self) -> FloatArray:
        """Return the frequencies [rad/s] at which k loops without delay are real, ``(k, m)``."""
        # Im(N conj(D))/omega as a polynomial in omega^2
        polynomial = polynomials.imaginary_part(self.numerator, self.denominator)
        with np.errstate(all="ignore"):
            roots = polynomials.roots_of_each(polynomial)
            real = (
                (np.imag(roots) == 0.0) & (np.real(roots) > 0.0) & (np.real(roots) < _MAX_FREQUENCY)
            )
        return np.sqrt(np.where(real, np.real(roots), np.nan))

    def bound(self) -> FloatArray:
        """Return an upper bound of the sizes of all poles of L [rad/s], ``(...)``."""
        return polynomials.bound(self.denominator)

    def is_pole_or_zero(self, omega: FloatArray) -> BoolArray:
        """Return whether L has a zero or a pole at j omega, to rounding, of the batch's shape.

        `omega`: a frequency for each loop [rad/s], of the shape of the batch.
        """
        omega, parts = omega[..., np.newaxis], []
        for polynomial in (self.numerator, self.denominator):
            size = polynomials.value(np.abs(polynomial), np.abs(omega))
            parts.append(np.abs(polynomials.on_axis(polynomial, omega)) <= _SUM_ROUNDING * size)
        return np.asarray(parts[0] | parts[1])[..., 0]

    def take(self, index: Any) -> Self:
        """Return the loops L at the positions `index` of the flattened batch."""
        size = self.numerator.shape[-1]
        N, D = (p.reshape(-1, size)[index] for p in (self.numerator, self.denominator))
        return type(self)(N, D, self.delay.reshape(-1)[index])


def product(first: AnyArray, second: AnyArray) -> AnyArray:
    """Return the product of complex arrays, which broadcast, in real arithmetic.

    The complex product of numpy rounds differently by position in memory.
    """
    result = np.empty(np.broadcast_shapes(first.shape, second.shape), dtype=complex)
    result.real = first.real * second.real - first.imag * second.imag
    result.imag = first.real * second.imag + first.imag * second.real
    return result


def inverse(values: AnyArray) -> AnyArray:
    """Return the inverses of complex numbers of any size in real arithmetic.

    The complex quotient of numpy rounds differently by position in memory.
    """
    scale = np.maximum(np.abs(values.real), np.abs(values.imag))
    real, imag = values.real / scale, values.imag / scale
    scale *= real**2 + imag**2
    result = np.empty(values.shape, dtype=complex)
    result.real, result.imag = real / scale, -imag / scale
    return result


@dataclass(frozen=True, eq=False)
class StateLoop:
    """Loops L(s) = (C (s - A)^-1 B + D) e^(-s delay) in state space, closed by 1 + L = 0.

    Made by `balanced`. The arrays hold all k loops that were made together; `case` selects loops of
    them.

    `A`, `B`, `C`, `D`: ``(k, n, n)``, ``(k, n)``, ``(k, n)`` and ``(k,)``. `all_delays`: delay [s],
    ``(k,)``. `poles`, `residues`: L without delay is D + sum of residue/(s - pole), both ``(k,
    n)``. `modal`: whether that holds, ``(k,)``: not for repeated poles. `case`: indices of the
    selected loops among the k of the arrays.
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray
    all_delays: FloatArray
    poles: AnyArray
    residues: AnyArray
    modal: BoolArray
    case: IndexArray

    @classmethod
    def balanced(
        cls, A: FloatArray, B: FloatArray, C: FloatArray, D: FloatArray, delay: FloatArray
    ) -> Self:
        """Return the loops of A ``(k, n, n)``, B and C ``(k, n)``, D and delay [s] ``(k,)``.

        The states are scaled by powers of two until rows and columns of A have similar norms. A
        pole that is zero to rounding, or of a split repeated integrator, becomes exactly zero.
        """
        from scipy.linalg import eig, lapack  # late: it takes 0.1 s to import

        scales = np.ones(B.shape)  # of the states
        for k in range(len(A)):
            _, _, _, scales[k], _ = lapack.dgebal(A[k], scale=1)
        A = A * scales[:, np.newaxis] / scales[:, :, np.newaxis]
        B, C = B / scales, C * scales
        poles, vectors = np.linalg.eig(A)
        poles, vectors = poles.astype(complex), vectors.astype(complex)
        size = np.abs(poles).max(axis=-1, initial=0.0, keepdims=True)
        modal = np.linalg.cond(vectors) < _MAX_EIGENVECTOR_CONDITION  # whether they are a basis
        left = np.linalg.inv(
            np.where(modal[:, np.newaxis, np.newaxis], vectors, np.eye(B.shape[1]))
        )
        residues = (C[:, np.newaxis] @ vectors)[:, 0] * (left @ B[..., np.newaxis])[..., 0]
        # without a basis by both eigenvectors of each pole, valid for poles that are not repeated
        for k in map(int, np.flatnonzero(~modal)):
            poles[k], left, right = eig(A[k], left=True, right=True)
            with np.errstate(all="ignore"):
                residues[k] = (C[k] @ right) * (B[k] @ left.conj()) / np.sum(left.conj() * right, 0)
        poles[np.abs(poles) <= _INTEGRATOR_POLE * size] = 0.0
        cluster = (np.abs(poles) <= _INTEGRATOR_CLUSTER * size) & ~modal[:, np.newaxis]
        poles[cluster & (cluster.sum(axis=-1, keepdims=True) > 1)] = 0.0  # repeated integrator
        spectrum = {"poles": poles, "residues": residues, "modal": modal}
        return cls(A, B, C, D, all_delays=delay, **spectrum, case=np.arange(len(A)))

    @property
    def delay(self) -> FloatArray:
        """Delay [s] of each selected loop, ``(k,)``."""
        return self.all_delays[self.case]

    @property
    def direct(self) -> FloatArray:
        """Value of L at infinity without its delay, ``(k,)``."""
        return self.D[self.case]

    def take(self, index: Any) -> Self:
        """Return the loops at the positions `index` of the selected ones."""
        return replace(self, case=self.case[index])

    def parts(self, omega: ArrayLike) -> tuple[AnyArray, AnyArray]:
        """Return numerator and denominator of k loops L with delay at m frequencies, ``(k, m)``.

        They are L and one, and at a pole one and zero, as in `Rational` a denominator of zero. By
        the sum over the poles of each loop. `omega`: frequencies [rad/s], ``(k, m)`` or ``(m,)``.
        """
        omega = np.broadcast_to(np.asarray(omega, float), (len(self.case), np.shape(omega)[-1]))
        values = self._modal_sum(1j * omega)
        values = np.where(np.isnan(omega), np.nan, values)
        if np.any(self.delay):
            lag = np.exp(-1j * omega * self.delay[:, np.newaxis])
            with np.errstate(invalid="ignore"):  # at a pole
                values = product(values, lag)
        return self._fraction(values, omega)

    def value(self, s: AnyArray) -> AnyArray:
        """Return k loops L with their delays at m values `s` [1/s] off the poles, ``(k, m)``."""
        return product(self._modal_sum(s), np.exp(-s * self.delay[:, np.newaxis]))

    def slope(self, s: AnyArray) -> AnyArray:
        """Return dL/ds of k loops with delays at m values `s` [1/s] off the poles, ``(k, m)``."""
        delay = self.delay[:, np.newaxis]
        slope = self._modal_sum(s, slope=True) - delay * self._modal_sum(s)
        return slope * np.exp(-s * delay)

    def undelayed(self, omega: FloatArray) -> tuple[AnyArray, AnyArray]:
        """Return numerator and denominator of k loops without delay at j omega, ``(k, m)``.

        They are L and one, and at a pole one and zero. `omega`: m frequencies [rad/s], ``(k, m)``.
        """
        return self._fraction(self._solved(1j * omega), omega)

    def log_slope(self, omega: FloatArray) -> AnyArray:
        """Return d ln G/d omega = j G'/G of k loops at j omega, ``(k, m)``.

        `omega`: m frequencies [rad/s] of each, ``(k, m)``. G is L without its delay, and G' =
        -C (s - A)^-2 B.
        """
        with np.errstate(all="ignore"):
            return 1j * (self._modal_sum(1j * omega, slope=True) / self._modal_sum(1j * omega))

    def is_pole_or_zero(self, omega: FloatArray) -> BoolArray:
        """Return whether each of k loops L has a zero or pole at j omega, to rounding, ``(k,)``.

        `omega`: a frequency for each loop [rad/s], ``(k,)``. A zero is a sum of partial fractions
        that cancel; it is not recognised in a loop without them (repeated poles, `modal` false).
        """
        s = 1j * omega[:, np.newaxis]
        poles, residues = self.poles[self.case], self.residues[self.case]
        distance = np.abs(s - poles)
        at_pole = np.any(distance <= _POLE_ROUNDING * np.abs(omega)[:, np.newaxis], axis=-1)
        with np.errstate(divide="ignore", invalid="ignore"):
            size = np.sum(np.abs(residues) / distance, axis=-1) + np.abs(self.direct)
            small = np.abs(self._modal_sum(s)[:, 0]) <= _ZERO_VALUE * size
        return np.asarray(at_pole | (small & self.modal[self.case]))

    def open_poles(self) -> AnyArray:
        """Return n poles [1/s] of each of the k selected loops without its delay, ``(k, n)``."""
        return self.poles[self.case]

    def closed_poles(self) -> AnyArray:
        """Return the n closed-loop poles of k loops without delay [1/s], ``(k, n)``.

        They are the eigenvalues of A - B C/(1 + D).
        """
        A, B, C, D = self._matrices
        returned = B[..., :, np.newaxis] * C[..., np.newaxis, :]
        return np.linalg.eigvals(A - returned / (1.0 + D)[:, np.newaxis, np.newaxis]).astype(
            complex
        )

    def zeros(self) -> AnyArray:
        """Return the zeros [1/s] of the k selected loops, ``(k, n)``; NaN fills the rows."""
        roots = _zeros(*self._matrices)
        finite = np.abs(roots) < _MAX_ZERO_OVER_LARGEST_POLE * self.bound()[:, np.newaxis]
        return np.where(finite, roots, np.nan)

    def crossovers(self, size: float) -> tuple[FloatArray, BoolArray]:
        """Return the frequencies [rad/s] with |L| = `size`, and whether |L| falls there.

        Both ``(k, m)`` of k loops, ascending, NaN-filled: imaginary eigenvalues of the Hamiltonian
        matrix of G = L/size (Boyd, Balakrishnan and Kabamba 1989), each refined by Newton's method
        on |L| itself. With R = 1 - D^2 and A1 = A + B C D/R the matrix is

            [A1, B B'/R; -C' C (1 + D^2/R), -A1'],

        and it has the eigenvalue j omega where |G| = 1. Two equal frequencies with the same slope
        are one crossover.
        """
        A, B, C, D = self._matrices
        C, D = C / size, D / size  # of G
        R = 1.0 - D**2
        R = np.where(np.abs(R) < _MIN_HAMILTONIAN_DIVISOR, _MIN_HAMILTONIAN_DIVISOR, R)[
            :, np.newaxis, np.newaxis
        ]
        BB, CC = B[:, :, np.newaxis] * B[:, np.newaxis], C[:, :, np.newaxis] * C[:, np.newaxis]
        DD = D[:, np.newaxis, np.newaxis]
        A1 = A + B[:, :, np.newaxis] * C[:, np.newaxis] * DD / R
        hamiltonian = [[A1, BB / R], [-CC * (1.0 + DD**2 / R), -A1.swapaxes(-1, -2)]]
        roots = np.linalg.eigvals(np.block(hamiltonian))
        candidates = (np.abs(roots.real) < _GAIN_AXIS_TOLERANCE * np.abs(roots)) & (
            roots.imag > 0.0
        )
        omega = _packed(np.where(candidates, roots.imag, np.nan))
        omega = self._newton_crossovers(omega, size)
        falls = self.log_slope(omega).real < 0.0
        with np.errstate(invalid="ignore"):
            duplicates = np.diff(omega, axis=-1) <= _EQUAL_FREQUENCIES * omega[:, 1:]
        duplicates &= falls[:, 1:] == falls[:, :-1]
        omega[:, 1:][duplicates] = np.nan
        order = np.argsort(omega, axis=-1)
        return np.take_along_axis(omega, order, axis=-1), np.take_along_axis(falls, order, axis=-1)

    def real_frequencies(self) -> FloatArray:
        """Return the frequencies [rad/s] at which k loops without delay are real, ``(k, m)``.

        They are imaginary zeros of L(s) - L(-s), whose state matrix is block diagonal in A and -A,
        and its direct term zero. NaN fills the rows; zeros far above all poles are left out.
        """
        A, B, C, D = self._matrices
        zero = np.zeros_like(A)
        B, C = (np.concatenate([row, row], axis=-1) for row in (B, C))
        roots = _zeros(np.block([[A, zero], [zero, -A]]), B, C, np.zeros_like(D))
        candidates = (np.abs(roots.real) < _REAL_AXIS_TOLERANCE * np.abs(roots)) & (
            roots.imag > 0.0
        )
        candidates &= np.abs(roots) < _MAX_ZERO_OVER_LARGEST_POLE * self.bound()[:, np.newaxis]
        return _packed(np.where(candidates, roots.imag, np.nan))

    def bound(self) -> FloatArray:
        """Return the size of the largest pole [rad/s] of each of the k selected loops, ``(k,)``."""
        return np.abs(self.open_poles()).max(axis=-1, initial=0.0)

    @cached_property
    def _matrices(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """A, B, C and D of the selected loops, with B and C scaled to equal norms."""
        A, B, C, D = (array[self.case] for array in (self.A, self.B, self.C, self.D))
        sizes = [np.sqrt(np.sum(row**2, axis=-1, keepdims=True)) for row in (B, C)]
        # L has only the product of B and C; where one is zero neither is scaled
        scalable = np.all(np.concatenate(sizes, axis=-1) > 0.0, axis=-1, keepdims=True)
        ratio = np.sqrt(np.where(scalable, sizes[0], 1.0) / np.where(scalable, sizes[1], 1.0))
        return A, B / ratio, C * ratio, D

    def _modal_sum(self, s: AnyArray, *, slope: bool = False) -> AnyArray:
        """Return L without its delay, or with `slope` dL/ds, at s ``(k, m)`` [1/s], by residues.

        The sum over the poles is in real arithmetic, r/(s - p) = r conj(s - p)/|s - p|^2, and added
        in sequence, so that it has the same bits in a batch of any shape. Loops with repeated poles
        are solved by matrices. The k loops are those that `case` selects.
        """
        poles, residues = self.poles[self.case], self.residues[self.case]
        total = np.zeros((2, *s.shape))  # real and imaginary part
        if not slope:
            total[0] = self.direct[:, np.newaxis]
        rows = max(1, _POINTS_PER_BLOCK // max(s.shape[1], 1))
        with np.errstate(all="ignore"):
            for k in range(0, len(s), rows):
                block = slice(k, k + rows)
                _add_terms(total[:, block], s[block], poles[block].T, residues[block].T, slope)
        values = np.empty(s.shape, dtype=complex)
        values.real, values.imag = total
        repeated = np.flatnonzero(~self.modal[self.case])
        if repeated.size:
            values[repeated] = self.take(repeated)._solved(s[repeated], slope=slope)
        return values

    def _solved(self, s: AnyArray, *, slope: bool = False) -> AnyArray:
        """Return k loops L without delay, or with `slope` dL/ds, at m `s` [1/s] each, ``(k, m)``.

        By linear solves, C (s - A)^-1 B + D or -C (s - A)^-2 B, not by residues. Infinite at a
        pole, and NaN at NaN: there the matrix is of another s, away from all poles. Many loops
        are halved, to bound the memory.
        """
        block = max(1, _ENTRIES_PER_BLOCK // max(1, s.shape[1] * self.A.shape[-1] ** 2))
        if len(s) > block:
            half = len(s) // 2
            halves = (slice(half), slice(half, None))
            return np.concatenate([self.take(k)._solved(s[k], slope=slope) for k in halves])
        # `case`: index of the matrices of each loop, of which several loops may have the same
        A, B, C, D = (array[self.case] for array in (self.A, self.B, self.C, self.D))
        poles = self.poles[self.case]
        at_pole = np.any(s[..., np.newaxis] == poles[:, np.newaxis], axis=-1)
        singular = np.isnan(s) | at_pole
        away = 1.0 + 2.0 * np.abs(poles).max(axis=-1, initial=0.0)[:, np.newaxis]
        matrix = np.where(singular, away, s)[..., np.newaxis, np.newaxis] * np.eye(A.shape[-1])
        matrix = matrix - A[:, np.newaxis]
        right = np.broadcast_to(B[:, np.newaxis, :, np.newaxis], (*s.shape, A.shape[-1], 1))
        try:
            first = np.linalg.solve(matrix, right)
        except np.linalg.LinAlgError:  # at a pole, to rounding: beside it
            matrix = matrix + _POLE_OFFSET * away[..., np.newaxis, np.newaxis] * np.eye(A.shape[-1])
            first = np.linalg.solve(matrix, right)
        row = C[:, np.newaxis, np.newaxis, :]
        if slope:
            values = -(row @ np.linalg.solve(matrix, first))[..., 0, 0]
        else:
            values = (row @ first)[..., 0, 0] + D[:, np.newaxis]
        values[at_pole], values[np.isnan(s)] = np.inf, np.nan
        return np.asarray(values)

    def _newton_crossovers(self, omega: FloatArray, size: float) -> FloatArray:
        """Return frequencies [rad/s] with |L| = `size`, ascending, by Newton's method, ``(k, m)``.

        On ln(|L|/`size`), whose slope over omega is -Im(L'/L) with L' = dL/ds; a step is at most a
        tenth of the frequency. `omega`: m estimates for each of k loops. NaN without convergence.
        """
        error = np.full(omega.shape, np.nan)
        with np.errstate(all="ignore"):
            for _ in range(_NEWTON_ITERATIONS):
                value = self._solved(1j * omega)
                slope = self._modal_sum(1j * omega, slope=True)
                error = np.log(np.abs(value) / size)
                step = error / -np.imag(slope / value)
                max_step = _MAX_RELATIVE_STEP * omega
                iterate = omega - np.clip(step, -max_step, max_step)
                converged = ~(np.abs(step) > _POLE_ROUNDING * omega)  # or no step: NaN
                omega = np.where(np.isfinite(iterate), iterate, omega)
                if np.all(converged | np.isnan(omega)):
                    break
            omega = np.where(np.abs(error) < _GAIN_TOLERANCE, omega, np.nan)
        return np.sort(omega, axis=-1)

    @staticmethod
    def _fraction(values: AnyArray, omega: FloatArray) -> tuple[AnyArray, AnyArray]:
        """Return L as numerator and denominator ``(k, m)``: L and 1, or at a pole of L 1 and 0.

        `values`: k loops L at m frequencies `omega` [rad/s] each; infinite or NaN at a pole.
        """
        at_pole = ~np.isfinite(values) & ~np.isnan(omega)
        ones = np.ones_like(values)
        return np.where(at_pole, ones, values), np.where(at_pole, 0.0, ones)


AnyLoop = Rational | StateLoop
"""A batch ``(k,)`` of loops L(s) = G(s) e^(-s delay), closed by 1 + L = 0, in either form. The
margins (`loop_margins`) use the methods that both have; frequencies are in rad/s, and NaN fills
rows of roots and frequencies."""


def _add_terms(
    total: FloatArray, s: AnyArray, poles: AnyArray, residues: AnyArray, slope: bool
) -> None:
    """Add r/(s - p), or its slope -r/(s - p)^2, for each pole p to a total, in sequence.

    `total`: real and imaginary part, ``(2, k, m)``, changed in place, of k loops at m `s` each,
    ``(k, m)``. `poles`, `residues`: n of each loop, ``(n, k)``.
    """
    columns = [
        np.ascontiguousarray(part)[..., np.newaxis]
        for part in (poles.real, poles.imag, residues.real, residues.imag)
    ]
    at = np.ascontiguousarray(s.real), np.ascontiguousarray(s.imag)
    if s.size <= _MAX_POINTS_OF_CUMULATIVE_SUMS:
        for part, terms in zip(total, _terms(*at, *columns, slope=slope), strict=True):
            part[:] = np.cumsum(np.concatenate([part[np.newaxis], terms]), axis=0)[-1]
        return
    for column in zip(*columns, strict=True):  # the same sequence of additions
        real, imag = _terms(*at, *column, slope=slope)
        total[0] += real
        total[1] += imag


def _terms(
    s_real: FloatArray,
    s_imag: FloatArray,
    pole_real: FloatArray,
    pole_imag: FloatArray,
    residue_real: FloatArray,
    residue_imag: FloatArray,
    *,
    slope: bool,
) -> tuple[FloatArray, FloatArray]:
    """Return real and imaginary parts of residue/(s - pole), or of -residue/(s - pole)^2 (`slope`).

    All arrays broadcast; they hold real and imaginary parts of s [1/s], poles and residues.
    """
    # residue (x - j y)/size, with s - pole = x + j y and size = |s - pole|^2
    x, y = s_real - pole_real, s_imag - pole_imag
    size = x**2
    size += y**2
    if slope:  # -1/(s - p)^2 = (y^2 - x^2 + 2j x y)/|s - p|^4
        size *= size
        x, y = (y - x) * (y + x), -2.0 * x * y
    real, imag = residue_real * x, residue_imag * x
    real += residue_imag * y
    imag -= residue_real * y
    real /= size
    imag /= size
    return real, imag


def _zeros(A: FloatArray, B: FloatArray, C: FloatArray, D: FloatArray) -> AnyArray:
    """Return the finite s at which [[A - s, B], [C, D]] is singular, ``(k, n + 1)``, NaN-filled.

    They are the zeros of k loops C (s - A)^-1 B + D, by generalised eigenvalues (QZ). `A`, `B`,
    `C`, `D`: ``(k, n, n)``, ``(k, n)``, ``(k, n)`` and ``(k,)``, with n states.
    """
    from scipy.linalg.lapack import dggev  # late: it takes 0.1 s to import

    count, n = B.shape
    unit = np.diag([1.0] * n + [0.0])
    zeros = np.full((count, n + 1), np.nan, dtype=complex)
    for k in range(count):
        rows = np.vstack([np.column_stack([A[k], B[k]]), [*C[k], D[k]]])
        real, imag, beta = dggev(rows, unit, compute_vl=0, compute_vr=0)[:3]
        with np.errstate(all="ignore"):
            roots = (real + 1j * imag) / beta
        zeros[k] = np.where(np.isfinite(roots), roots, np.nan)
    return zeros


def _packed(frequencies: FloatArray) -> FloatArray:
    """Return k rows of frequencies, ascending, NaN last, as wide as the longest row, ``(k, m)``."""
    frequencies = np.sort(frequencies, axis=-1)
    width = int(np.sum(~np.isnan(frequencies), axis=-1).max(initial=0))
    return frequencies[:, :width]


def rightmost_poles(
    A: FloatArray, B: FloatArray, C: FloatArray, delay: float, loop: Callable[[AnyArray], AnyArray]
) -> AnyArray:
    """Return the rightmost closed-loop poles [1/s], by falling real part, as far as they converge.

    `A`, `B`, `C`: loop without its delay, ``(n, n)``, ``(n,)`` and ``(n,)``; closed by 1 + L = 0.
    `delay`: T [s], positive. `loop`: L with its delay, of complex frequencies ``(m,)`` [1/s].

    Eigenvalues of the states with the wave of the delayed signal, at Chebyshev points, start
    Newton's method on 1 + L(s); the list ends at the first that moves far.
    """
    n, wave = len(A), _chebyshev_derivative(_CHEBYSHEV_POINTS) * (2.0 / delay)
    generator = np.zeros((n + _CHEBYSHEV_POINTS, n + _CHEBYSHEV_POINTS))
    generator[:n, :n], generator[:n, -1] = A, B  # the last point is theta = -T, the first 0
    generator[n:, n:], generator[n:, :n] = wave[1:, 1:], -np.outer(wave[1:, 0], C)
    eigenvalues = np.linalg.eigvals(generator).astype(complex)
    eigenvalues = eigenvalues[np.abs(eigenvalues) * delay < 0.5 * _CHEBYSHEV_POINTS]
    eigenvalues = eigenvalues[np.argsort(-eigenvalues.real)]
    s, size = eigenvalues.copy(), np.abs(eigenvalues) + 1.0 / delay
    with np.errstate(all="ignore"):
        for _ in range(_DELAYED_POLE_ITERATIONS):
            step = _DIFFERENCE_STEP * size
            slope = (loop(s + step) - loop(s - step)) / (2.0 * step)
            s = s - (1.0 + loop(s)) / slope
        converged = np.abs(s - eigenvalues) <= _MAX_POLE_CORRECTION * size
    s = s[: int(np.argmin(converged)) if not np.all(converged) else s.size]
    return np.where(np.abs(s.imag) < _MAX_POLE_CORRECTION**2 * np.abs(s), s.real, s)


def _chebyshev_derivative(count: int) -> FloatArray:
    """Return the differentiation matrix at n + 1 Chebyshev points from 1 to -1, n = `count`.

    Shape ``(n + 1, n + 1)``: from values of a polynomial at the points to its derivative's values.
    """
    x = np.cos(np.pi * np.arange(count + 1) / count)
    c = np.ones(count + 1)  # barycentric weights, inverted
    c[[0, -1]] = 2.0
    c *= (-1.0) ** np.arange(count + 1)
    differences = x[:, np.newaxis] - x + np.eye(count + 1)  # 1 on the diagonal, to be divided by
    derivative = np.outer(c, 1.0 / c) / differences
    return derivative - np.diag(derivative.sum(axis=1))  # zero row sums: constants have no slope
