"""Where the closed-loop poles go with the loop gain: each followed from gain to gain."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IndexArray
from tvclin.control.autopilot.actuator import pade_delay
from tvclin.control.margins.loop import Loop, SampledLoop
from tvclin.numerics import polynomials
from tvclin.numerics.loops import Rational

_STEP, _APART, _ROUNDS, _PARTS = 0.015, 0.5, 5, 4
"""The largest step of a pole, over its size and over its distance from the next one; how often,
and into how many parts, a step is divided."""
_FAR = 0.2
"""The sample rate over the farthest pole of a sampled loop, which z = 0 would put at infinity."""
_HALVINGS = 60
_BESIDE = np.linspace(0.0, 1.0, 9)[1:-1] ** 2
"""Where poles meet they move with the root of the gain: parts of the step to the next gain."""


@dataclass(frozen=True, eq=False)
class LocusPoles:
    """The poles of one loop, whose gain is multiplied by a factor.

    `poles`, `zeros`: of the loop, with the approximation of its delay [1/s], ``(n,)`` and ``(m,)``.
    `closed`: from factors ``(k,)`` to closed-loop poles [1/s], ``(k, n)``, in any order.
    """

    poles: AnyArray
    zeros: AnyArray
    closed: Callable[[FloatArray], AnyArray]

    @classmethod
    def of(cls, what: str, loop: Loop, order: int) -> LocusPoles:
        """Return those of one loop, its delay approximated in this order.

        Of a sampled loop, where the delay is exact, they are s = ln(z)/h of the discrete poles z.
        """
        if isinstance(loop, SampledLoop):
            return cls._of_samples(loop)
        if isinstance(loop.form, Rational):
            return cls._of_polynomials(loop, order)
        return cls._of_matrices(loop, order)

    @classmethod
    def _of_polynomials(cls, loop: Loop, order: int) -> LocusPoles:
        above, below = np.trim_zeros(loop.numerator, "f"), loop.denominator
        delay = float(loop.delay)
        if delay > 0.0:
            import control

            powers = delay ** np.arange(order, -1.0, -1.0)
            top, bottom = (powers * p / p[-1] for p in control.pade(1.0, order))
            above, below = polynomials.multiply(above, top), polynomials.multiply(below, bottom)
        padded = np.pad(above, (below.size - above.size, 0))

        def closed(factors: FloatArray) -> AnyArray:
            return polynomials.roots(below + factors[:, np.newaxis] * padded).astype(complex)

        return cls(closed(np.zeros(1))[0], polynomials.roots(above).astype(complex), closed)

    @classmethod
    def _of_samples(cls, loop: SampledLoop) -> LocusPoles:
        # In the w plane, where a command passes at once: A - k B C/(1 + k D).
        form: Any = loop.form
        A, B, C = form.A[form.case[0]], form.B[form.case[0], :, None], form.C[form.case[0], None]
        D = np.ravel(form.D[form.case[0]])[0]
        half = 0.5 * float(np.ravel(loop.period)[0])
        least = np.exp(-2.0 * np.pi / _FAR)

        def in_s(w: AnyArray) -> AnyArray:
            z = (1.0 + w * half) / (1.0 - w * half)
            size = np.maximum(np.abs(z), least)  # z = 0 is that of a command still to come
            return (np.log(size) + 1j * np.angle(z)) / (2.0 * half)

        def closed(factors: FloatArray) -> AnyArray:
            k = factors[:, np.newaxis, np.newaxis]
            return in_s(np.linalg.eigvals(A - k / (1.0 + k * D) * (B @ C)).astype(complex))

        zeros = form.zeros()[0].astype(complex)
        return cls(closed(np.zeros(1))[0], in_s(zeros[~np.isnan(zeros)]), closed)

    @classmethod
    def _of_matrices(cls, loop: Loop, order: int) -> LocusPoles:
        # x' = A x + B u, y = C x, the delay behind it: z' = A1 z + B1 y, w = C1 z + D1 y.
        form: Any = loop.form
        A, B, C = form.A[form.case[0]], form.B[form.case[0], :, None], form.C[form.case[0], None]
        A1, B1, C1, D1 = pade_delay(float(loop.delay), order)
        none = np.zeros((len(A), len(A1)))
        whole = np.block([[A, none], [B1 @ C, A1]])
        enters = np.concatenate([B, np.zeros((len(A1), 1))])
        leaves = np.concatenate([D1 @ C, C1], axis=-1)

        def closed(factors: FloatArray) -> AnyArray:
            matrices = whole - factors[:, np.newaxis, np.newaxis] * (enters @ leaves)
            return np.linalg.eigvals(matrices).astype(complex)

        zeros = form.zeros()[0].astype(complex)
        mirrored = -np.linalg.eigvals(A1).astype(complex)  # zeros of the approximation
        zeros = np.concatenate([zeros[~np.isnan(zeros)], mirrored])
        return cls(closed(np.zeros(1))[0], zeros, closed)

    def refined(self, factors: FloatArray, near: float, far: float) -> FloatArray:
        """Return factors, rising, between which no pole nearer to zero than `far` goes far.

        Those at which two poles meet on the real axis are among them.

        `factors`: to begin with, rising. `near`, `far`: sizes [1/s]: of a pole below the first its
        step is measured by that.
        """
        for _ in range(_ROUNDS):
            poles = self.closed(factors)
            steps = np.abs(poles[1:, :, np.newaxis] - poles[:-1, np.newaxis, :]).min(axis=-1)
            sizes = np.abs(poles[1:])
            least = np.minimum(_STEP * np.maximum(sizes, near), _APART * _apart(poles[1:]))
            coarse = (steps > np.maximum(least, 0.02 * _STEP * near)) & (sizes < 2.0 * far)
            places = np.flatnonzero(np.any(coarse, axis=-1))
            between = np.linspace(factors[places], factors[places + 1], _PARTS + 1)
            factors = np.unique(np.concatenate([factors, between.ravel()]))
        for _ in range(2):
            factors = self._with_meetings(factors)
        return factors

    def _with_meetings(self, factors: FloatArray) -> FloatArray:
        """The factors, and those at which the number of real poles changes, by bisection."""
        count = self._real(factors)
        places = np.flatnonzero(count[1:] != count[:-1])
        low, high, before = factors[places], factors[places + 1], count[places]
        ends = low, high
        if not places.size:
            return factors
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            same = self._real(middle) == before
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        beside = [low[:, np.newaxis] + (end - low)[:, np.newaxis] * _BESIDE for end in ends]
        return np.unique(np.concatenate([factors, low, *(part.ravel() for part in beside)]))

    def _real(self, factors: FloatArray) -> IndexArray:
        return np.sum(np.imag(self.closed(factors)) == 0.0, axis=-1)

    def branches(self, factors: FloatArray) -> AnyArray:
        """Return the poles ``(k, n)`` at rising factors, each column one pole on its way.

        The poles at one factor are given to those at the one before so that they go least far,
        squared and in sum.
        """
        from scipy.optimize import linear_sum_assignment  # late: it takes 0.2 s to import

        poles = self.closed(factors)
        for k in range(1, len(poles)):
            apart = np.abs(poles[k - 1][:, np.newaxis] - poles[k])
            poles[k] = poles[k][linear_sum_assignment(apart**2)[1]]
        return poles


def _apart(poles: AnyArray) -> FloatArray:
    """The distance of each pole from the next one."""
    apart = np.abs(poles[..., :, np.newaxis] - poles[..., np.newaxis, :])
    return np.min(apart + np.where(np.eye(poles.shape[-1]) > 0.0, np.inf, 0.0), axis=-1)
