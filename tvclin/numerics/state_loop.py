"""A batch of loops in state space, each with a delay: what the margins ask, without polynomials.

Poles, zeros and crossings are eigenvalues of the matrices themselves, so that orders of thirty and
modes that lie close together keep their digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tvclin.numerics.rational import Rational, product

_INDEPENDENT = 1e6
"""Eigenvectors with a higher condition number are not used: poles are repeated, or nearly so."""
_AT_ORIGIN = 1e-14
"""A pole below this part of the largest is an integrator."""
_CLUSTER = 1e-7
"""Several poles below this part of the largest are one repeated integrator, moved by rounding."""
_ROUNDING = 1e-13
_VANISHING = 1e-11
"""A sum that is below this part of its terms is zero: their rounding is its value."""
_FAR = 1e3
"""What lies beyond so many times the largest pole is at infinity, moved by rounding."""
_NEAR_AXIS, _LOOSE = 1e-4, 1e-3
"""Eigenvalues so near to the axis, over their size, may be crossings of |L| and of Im L."""
_STEPS, _LONGEST, _ARRIVED, _SAME = 20, 0.1, 1e-9, 1e-9
"""Newton's steps to a crossing: how many, how long over the frequency, how little |ln |L|/g| may be
left; and how close two are one."""
_ASIDE = 1e-15
"""So far beside a pole, over the largest, one solves where it is met to rounding."""
_THIN = 1e-8
"""No |1 - D^2/g^2| is taken to be smaller where |L| = g is looked for."""
_NUMBERS = 2**16
"""Terms that are worked on at a time, to bound the memory."""
_ENTRIES = 2**22
"""Entries of matrices that are solved at a time, likewise."""


@dataclass(frozen=True, eq=False)
class StateLoop:
    """The loops L(s) = (C (s - A)^-1 B + D) e^(-s delay), closed by 1 + L = 0.

    Made by `balanced`. The arrays are those of all loops that were made together, and `case` says
    which of them are meant.

    `A`, `B`, `C`, `D`: ``(k, n, n)``, ``(k, n)``, ``(k, n)`` and ``(k,)``. `late`: delay [s],
    ``(k,)``. `poles`, `residues`: L without delay is D + sum of residue/(s - pole), both ``(k,
    n)``. `modal`: whether that holds, ``(k,)``: not where poles are repeated. `case`: positions
    among the ``(k,)``.
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray
    late: FloatArray
    poles: AnyArray
    residues: AnyArray
    modal: BoolArray
    case: IndexArray

    @classmethod
    def balanced(
        cls, A: FloatArray, B: FloatArray, C: FloatArray, D: FloatArray, delay: FloatArray
    ) -> Self:
        """Return the loops of ``(k, n, n)``, ``(k, n)``, ``(k, n)``, ``(k,)`` and ``(k,)``.

        The states are scaled by powers of two until rows and columns of A are of like size.
        """
        from scipy.linalg import eig, matrix_balance  # late: it takes 0.1 s to import

        scales = np.ones(B.shape)
        for k in range(len(A)):
            scales[k] = matrix_balance(A[k], permute=False, separate=True)[1][0]
        A = A * scales[:, np.newaxis] / scales[:, :, np.newaxis]
        B, C = B / scales, C * scales
        poles, vectors = np.linalg.eig(A)
        poles, vectors = poles.astype(complex), vectors.astype(complex)
        size = np.abs(poles).max(axis=-1, initial=0.0, keepdims=True)
        modal = np.linalg.cond(vectors) < _INDEPENDENT
        left = np.linalg.inv(
            np.where(modal[:, np.newaxis, np.newaxis], vectors, np.eye(B.shape[1]))
        )
        residues = (C[:, np.newaxis] @ vectors)[:, 0] * (left @ B[..., np.newaxis])[..., 0]
        for k in map(int, np.flatnonzero(~modal)):  # those of poles that stand alone
            poles[k], left, right = eig(A[k], left=True, right=True)
            with np.errstate(all="ignore"):
                residues[k] = (C[k] @ right) * (B[k] @ left.conj()) / np.sum(left.conj() * right, 0)
        poles[np.abs(poles) <= _AT_ORIGIN * size] = 0.0
        cluster = (np.abs(poles) <= _CLUSTER * size) & ~modal[:, np.newaxis]
        poles[cluster & (cluster.sum(axis=-1, keepdims=True) > 1)] = 0.0
        return cls(A, B, C, D, delay, poles, residues, modal, np.arange(len(A)))

    @property
    def delay(self) -> FloatArray:
        """Delay [s]."""
        return self.late[self.case]

    @property
    def direct(self) -> FloatArray:
        """The value at infinity."""
        return self.D[self.case]

    def take(self, index: Any) -> Self:
        """Return the loops at the positions `index`."""
        stored = (self.A, self.B, self.C, self.D, self.late, self.poles, self.residues, self.modal)
        return type(self)(*stored, self.case[index])

    def parts(self, omega: ArrayLike) -> tuple[AnyArray, AnyArray]:
        """Return L with its delay, over one, at j omega ``(k, m)``; at a pole one over zero."""
        omega = np.broadcast_to(np.asarray(omega, float), (len(self.case), np.shape(omega)[-1]))
        values = self._values(1j * omega)
        values = np.where(np.isnan(omega), np.nan, values)
        if np.any(self.delay):
            late = np.exp(-1j * omega * self.delay[:, np.newaxis])
            with np.errstate(invalid="ignore"):  # at a pole
                values = product(values, late)
        return self._over(values, omega)

    def value(self, s: AnyArray) -> AnyArray:
        """Return L with its delay at complex frequencies ``(k, m)`` [1/s], off the poles."""
        return product(self._values(s), np.exp(-s * self.delay[:, np.newaxis]))

    def slope(self, s: AnyArray) -> AnyArray:
        """Return dL/ds with the delay at complex frequencies ``(k, m)`` [1/s], off the poles."""
        late = self.delay[:, np.newaxis]
        value, slope = self._solved(s)
        return (slope - late * value) * np.exp(-s * late)

    def undelayed(self, omega: FloatArray) -> tuple[AnyArray, AnyArray]:
        """Return L without its delay, over one, at j omega ``(k, m)``, by solving for it."""
        return self._over(self._solved(1j * omega)[0], omega)

    def log_slope(self, omega: FloatArray) -> AnyArray:
        """Return d ln G/d omega = j G'/G at j omega, ``(k, m)``, with G' = -C (s - A)^-2 B."""
        value, slope = self._solved(1j * omega)
        with np.errstate(all="ignore"):
            return 1j * (slope / value)

    def vanishes(self, omega: FloatArray) -> BoolArray:
        """Return whether L is zero or infinite, to rounding, at one frequency each ``(k,)``."""
        s = 1j * omega[:, np.newaxis]
        poles, residues = self.poles[self.case], self.residues[self.case]
        apart = np.abs(s - poles)
        at_pole = np.any(apart <= _ROUNDING * np.abs(omega)[:, np.newaxis], axis=-1)
        with np.errstate(divide="ignore", invalid="ignore"):
            size = np.sum(np.abs(residues) / apart, axis=-1) + np.abs(self.direct)
            small = np.abs(self._values(s)[:, 0]) <= _VANISHING * size
        return np.asarray(at_pole | (small & self.modal[self.case]))

    def open_poles(self) -> AnyArray:
        """Return the poles without the delay [1/s], ``(k, n)``."""
        return self.poles[self.case]

    def closed_poles(self) -> AnyArray:
        """Return the closed-loop poles without the delay [1/s]: eig(A - B C/(1 + D))."""
        A, B, C, D = self._matrices
        returned = B[..., :, np.newaxis] * C[..., np.newaxis, :]
        return np.linalg.eigvals(A - returned / (1.0 + D)[:, np.newaxis, np.newaxis]).astype(
            complex
        )

    def zeros(self) -> AnyArray:
        """Return the zeros [1/s], ``(k, n)``; NaN fills the rows."""
        roots = _zeros(*self._matrices)
        near = np.abs(roots) < _FAR * self.bound()[:, np.newaxis]
        return np.where(near, roots, np.nan)

    def crossovers(self, size: float) -> tuple[FloatArray, BoolArray]:
        """Return where |L| is `size` [rad/s], rising, and whether |L| falls there, ``(k, m)``.

        The frequencies are imaginary eigenvalues of the Hamiltonian matrix of L/size (Boyd,
        Balakrishnan and Kabamba 1989), each then led by Newton's steps to |L| itself.
        """
        A, B, C, D = self._matrices
        C, D = C / size, D / size
        R = 1.0 - D**2
        R = np.where(np.abs(R) < _THIN, _THIN, R)[:, np.newaxis, np.newaxis]
        BB, CC = B[:, :, np.newaxis] * B[:, np.newaxis], C[:, :, np.newaxis] * C[:, np.newaxis]
        DD = D[:, np.newaxis, np.newaxis]
        A1 = A + B[:, :, np.newaxis] * C[:, np.newaxis] * DD / R
        upper = np.concatenate([A1, BB / R], axis=-1)
        lower = np.concatenate([-CC * (1.0 + DD**2 / R), -A1.swapaxes(-1, -2)], axis=-1)
        roots = np.linalg.eigvals(np.concatenate([upper, lower], axis=-2))
        near = (np.abs(roots.real) < _NEAR_AXIS * np.abs(roots)) & (roots.imag > 0.0)
        omega = _packed(np.where(near, roots.imag, np.nan))
        omega = self._led(omega, size)
        falls = self.log_slope(omega).real < 0.0
        with np.errstate(invalid="ignore"):
            again = np.diff(omega, axis=-1) <= _SAME * omega[:, 1:]
        again &= falls[:, 1:] == falls[:, :-1]
        omega[:, 1:][again] = np.nan
        order = np.argsort(omega, axis=-1)
        return np.take_along_axis(omega, order, axis=-1), np.take_along_axis(falls, order, axis=-1)

    def real_frequencies(self) -> FloatArray:
        """Return where L, but for its delay, is real [rad/s], ``(k, m)``; NaN fills the rows.

        They are zeros of L(s) - L(-s), the system of A and -A side by side.
        """
        A, B, C, D = self._matrices
        none = np.zeros_like(A)
        both = np.concatenate(
            [np.concatenate([A, none], axis=-1), np.concatenate([none, -A], axis=-1)], axis=-2
        )
        B, C = (np.concatenate([row, row], axis=-1) for row in (B, C))
        roots = _zeros(both, B, C, np.zeros_like(D))
        near = (np.abs(roots.real) < _LOOSE * np.abs(roots)) & (roots.imag > 0.0)
        near &= np.abs(roots) < _FAR * self.bound()[:, np.newaxis]
        return _packed(np.where(near, roots.imag, np.nan))

    def bound(self) -> FloatArray:
        """Return the size of the largest pole [rad/s]."""
        return np.abs(self.open_poles()).max(axis=-1, initial=0.0)

    @cached_property
    def _matrices(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """A, B, C and D of the cases, B and C of one size."""
        A, B, C, D = (array[self.case] for array in (self.A, self.B, self.C, self.D))
        sizes = [np.sqrt(np.sum(row**2, axis=-1, keepdims=True)) for row in (B, C)]
        whole = np.all(np.concatenate(sizes, axis=-1) > 0.0, axis=-1, keepdims=True)
        ratio = np.sqrt(np.where(whole, sizes[0], 1.0) / np.where(whole, sizes[1], 1.0))
        return A, B / ratio, C * ratio, D

    def _values(self, s: AnyArray) -> AnyArray:
        """L without its delay at s ``(k, m)``: the sum over the poles, in real numbers.

        r/(s - p) = r conj(s - p)/|s - p|^2, added one after the other, so that the same sum has
        the same bits in a batch of any shape.
        """
        poles = self.poles[self.case].T[..., np.newaxis]
        residues = self.residues[self.case].T[..., np.newaxis]
        found = np.zeros(s.shape, dtype=complex)
        found.real = self.direct[:, np.newaxis]
        together = max(1, _NUMBERS // max(s.size, 1))
        with np.errstate(all="ignore"):
            for k in range(0, len(poles), together):
                p, r = poles[k : k + together], residues[k : k + together]
                x, y = s.real - p.real, s.imag - p.imag
                size = x**2 + y**2
                real, imag = (r.real * x + r.imag * y) / size, (r.imag * x - r.real * y) / size
                found.real = np.cumsum(np.concatenate([found.real[np.newaxis], real]), axis=0)[-1]
                found.imag = np.cumsum(np.concatenate([found.imag[np.newaxis], imag]), axis=0)[-1]
        repeated = np.flatnonzero(~self.modal[self.case])
        if repeated.size:
            found[repeated] = self.take(repeated)._solved(s[repeated])[0]
        return found

    def _solved(self, s: AnyArray) -> tuple[AnyArray, AnyArray]:
        """L without its delay, and dL/ds, at s ``(k, m)``; infinite at a pole, NaN at NaN."""
        together = max(1, _ENTRIES // max(1, s.shape[1] * self.A.shape[-1] ** 2))
        if len(s) > together:
            half = len(s) // 2
            parts = [self.take(part)._solved(s[part]) for part in (slice(half), slice(half, None))]
            return np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])
        A, B, C, D = (array[self.case] for array in (self.A, self.B, self.C, self.D))
        poles = self.poles[self.case]
        at_pole = np.any(s[..., np.newaxis] == poles[:, np.newaxis], axis=-1)
        lost = np.isnan(s) | at_pole
        away = 1.0 + 2.0 * np.abs(poles).max(axis=-1, initial=0.0)[:, np.newaxis]
        matrix = np.where(lost, away, s)[..., np.newaxis, np.newaxis] * np.eye(A.shape[-1])
        matrix = matrix - A[:, np.newaxis]
        right = np.broadcast_to(B[:, np.newaxis, :, np.newaxis], (*s.shape, A.shape[-1], 1))
        try:
            first = np.linalg.solve(matrix, right)
        except np.linalg.LinAlgError:  # at a pole, to rounding: beside it
            matrix = matrix + _ASIDE * away[..., np.newaxis, np.newaxis] * np.eye(A.shape[-1])
            first = np.linalg.solve(matrix, right)
        second = np.linalg.solve(matrix, first)
        row = C[:, np.newaxis, np.newaxis, :]
        value: AnyArray = (row @ first)[..., 0, 0] + D[:, np.newaxis]
        slope: AnyArray = -(row @ second)[..., 0, 0]
        for array in (value, slope):
            array[at_pole], array[np.isnan(s)] = np.inf, np.nan
        return value, slope

    def _led(self, omega: FloatArray, size: float) -> FloatArray:
        """Newton's steps on ln |L| to the frequencies at which it is `size`; NaN if they fail."""
        left = np.full(omega.shape, np.nan)
        with np.errstate(all="ignore"):
            for _ in range(_STEPS):
                value, slope = self._solved(1j * omega)
                left = np.log(np.abs(value) / size)
                step = left / -np.imag(slope / value)
                far = _LONGEST * omega
                moved = omega - np.clip(step, -far, far)
                done = ~(np.abs(step) > _ROUNDING * omega)
                omega = np.where(np.isfinite(moved), moved, omega)
                if np.all(done | np.isnan(omega)):
                    break
            omega = np.where(np.abs(left) < _ARRIVED, omega, np.nan)
        return np.sort(omega, axis=-1)

    @staticmethod
    def _over(values: AnyArray, omega: FloatArray) -> tuple[AnyArray, AnyArray]:
        """The values over one, and at a pole one over zero."""
        at_pole = ~np.isfinite(values) & ~np.isnan(omega)
        one = np.ones_like(values)
        return np.where(at_pole, one, values), np.where(at_pole, 0.0, one)


AnyLoop = Rational | StateLoop
"""A batch ``(k,)`` of loops L(s) = G(s) e^(-s delay), closed by 1 + L = 0, however it is written
down. The engine of the margins (`stability`, `loop_grid`, `loop_margins`) asks what both answer;
frequencies are in rad/s, and NaN fills rows of roots and frequencies."""


def _zeros(A: FloatArray, B: FloatArray, C: FloatArray, D: FloatArray) -> AnyArray:
    """The finite s at which [[A - s, B], [C, D]] is singular, ``(k, n)``, filled with NaN."""
    from scipy.linalg import eigvals  # late: it takes 0.1 s to import

    count, n = B.shape
    unit = np.diag([1.0] * n + [0.0])
    found = np.full((count, n + 1), np.nan, dtype=complex)
    for k in range(count):
        rows = np.vstack([np.column_stack([A[k], B[k]]), [*C[k], D[k]]])
        above, below = eigvals(rows, unit, homogeneous_eigvals=True)
        with np.errstate(all="ignore"):
            roots = above / below
        found[k] = np.where(np.isfinite(roots), roots, np.nan)
    return found


def _packed(frequencies: FloatArray) -> FloatArray:
    """Rows that rise, as wide as the longest of them."""
    frequencies = np.sort(frequencies, axis=-1)
    width = int(np.sum(~np.isnan(frequencies), axis=-1).max(initial=0))
    return frequencies[:, :width]
