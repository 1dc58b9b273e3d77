"""The growing direction of a vehicle whose parameters vary: the adjoint solution of eq (4b).

    x' = A(t) x + b(t) delta + w(t) alpha_w,     p' = -A(t)^T p

p.x is the part of the state that grows. It goes to zero in the end exactly when

    integral of p.b delta + p.w alpha_w dt = 0,

which for constant parameters, p = e^(-s t) times the left eigenvector, is eq (4b). Integrated
backwards, every solution turns into the one of the growing direction. It is kept as p = m(t) l(t)
of the length |l| = 1, so that nothing overflows:

    l' = -A^T l + mu l,    m' = -mu m,    mu = l.A l,

where mu is the growth rate: the pole itself while parameters do not change.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.answers.sizing.collocation import mesh, refined, solved
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.linear.modes import left_eigenvector

_LONGEST = 500.0
"""Of the span, over the time of the fastest mode; the mesh has four times as many steps."""
_MOST_ROWS = 100_000
_STEP = 0.5
"""Between rows of the schedule coefficients are tabulated at least every half second."""


@dataclass(frozen=True, eq=False)
class GrowingMode:
    """The growing direction over a flight, whose parameters are constant beyond its span [s]."""

    schedule: FlightSchedule
    model: str
    plane: str
    span: tuple[float, float]

    def matrices(self, t: Any) -> tuple[FloatArray, FloatArray]:
        """Return A ``(n, n)`` and the columns of deflection and wind ``(n, 2)`` at a time."""
        both = np.asarray(self._table(t))
        order = both.shape[-2]
        return both[..., :order], both[..., order:]

    def trim_per_wind(self, t: Any) -> FloatArray:
        """Return B at times [s]."""
        _, inputs = self.matrices(t)
        return np.asarray(inputs[..., 1, 1] / inputs[..., 1, 0])

    def under_trim(self, t: Any) -> tuple[FloatArray, FloatArray]:
        """Return F and c of x' = F x + c alpha_w at times [s], of what is not attitude or rate.

        With delta = -(A_12 x + w_1 alpha_w)/b_1, of the row of theta'',

            F = A_22 - b_2 A_12/b_1,    c = w_2 - b_2 w_1/b_1.
        """
        A, inputs = self.matrices(t)
        turned = inputs[..., 2:, :1] / inputs[..., 1:2, :1]
        F = A[..., 2:, 2:] - turned @ A[..., 1:2, 2:]
        return F, inputs[..., 2:, 1:] - turned @ inputs[..., 1:2, 1:]

    def rate(self, t: Any) -> FloatArray:
        """Return the growth rate mu [1/s] at times [s]."""
        row = self._direction(t)
        return np.asarray(np.einsum("...i,...ij,...j->...", row, self.matrices(t)[0], row))

    def at(self, t: Any) -> tuple[FloatArray, Any]:
        """Return l = p/m, ``(n,) + t.shape``, and the reach of a unit deflection held from t on.

        That is the integral from t on of m(r)/m(t) l(r).b(r) dr.
        """
        row = self._direction(t)
        return np.moveaxis(row, -1, 0), self._reach(np.clip(t, *self.span))[..., 0, 0]

    @property
    def grows(self) -> bool:
        """Whether anything grows in this flight; else there is no direction in which it does."""
        return self._rows[0].size > 1

    @property
    def bends(self) -> FloatArray:
        """Times [s] between which coefficients are smooth; after the last they are as there.

        That is the last one with a real unstable pole. Beyond it the vehicle is stable, or
        oscillates; that it grows for ever asks for no less.
        """
        return self._rows[0]

    @cached_property
    def quickest(self) -> float:
        """The fastest rate [1/s] of the attitude alone, the largest sqrt(|mu_alpha|)."""
        return math.sqrt(float(np.abs(self._rows[1][:, 1, 0]).max(initial=0.0)))

    @cached_property
    def _rows(self) -> tuple[FloatArray, FloatArray]:
        """Times [s], and A beside the columns of the inputs; up to the last real unstable pole."""
        rows = self.schedule.times
        if rows[-1] - rows[0] > _MOST_ROWS * _STEP:
            raise InputError(
                f"varying parameters can be followed for at most {_MOST_ROWS * _STEP:.4g} s; the"
                f" flight lasts {rows[-1] - rows[0]:.4g} s: shorten the winds"
            )
        times = refined(rows, np.ceil(np.diff(rows) / _STEP))
        plant = self.schedule.plants(times, self.model, self.plane)
        A, inputs, _, _ = plant.matrices()
        both = np.concatenate([A, inputs], axis=-1)
        both = np.broadcast_to(both, (times.size, *both.shape[-2:]))
        some = np.flatnonzero(_fastest(both[..., : both.shape[-2]]) > 0.0)
        kept = slice(int(some.max(initial=-1)) + 1)
        return times[kept], both[kept]

    @cached_property
    def _table(self) -> Any:
        from scipy.interpolate import PchipInterpolator

        times, rows = self._rows
        if not self.grows:
            raise InputError(
                "varying parameters need a real unstable pole, which this flight has at none of its"
                " times"
            )
        table = PchipInterpolator(times, rows, axis=0)
        return lambda t: table(np.clip(t, times[0], times[-1]))

    def _direction(self, t: Any) -> FloatArray:
        """The row l at times [s], ``t.shape + (n,)``."""
        row = self._adjoint(np.clip(t, *self.span))[..., 0]
        return np.asarray(row / np.linalg.norm(row, axis=-1, keepdims=True))

    @cached_property
    def steps(self) -> FloatArray:
        """A mesh of the span [s], as `collocation.solved` takes it."""
        start, stop = self.span
        bends = self.bends[(self.bends > start) & (self.bends < stop)]
        return mesh(np.concatenate([[start], bends, [stop]]), self.quickest)

    @cached_property
    def _adjoint(self) -> Any:
        """A multiple of p over the span, integrated backwards from a constant end."""
        start, stop = self.span
        A, _ = self.matrices(stop)
        pole = float(_fastest(A))
        if pole * (stop - start) > _LONGEST:
            raise InputError(
                f"varying parameters can be followed for at most {_LONGEST / pole:.4g} s,"
                f" {_LONGEST:g} times that of the fastest mode; schedule and winds together last"
                f" {stop - start:.4g} s: shorten the winds"
            )
        row = np.real(left_eigenvector(A, np.asarray(pole))[1])
        row = row * np.sign(row[1])

        def rates(t: FloatArray) -> tuple[FloatArray, FloatArray]:
            A, _ = self.matrices(t)
            return -np.swapaxes(A, -1, -2), np.zeros((*A.shape[:-1], 1))

        end = (row / np.linalg.norm(row))[:, np.newaxis]
        return solved(rates, self.steps, end, backwards=True, direction=True)

    @cached_property
    def _reach(self) -> Any:
        """The control reach of a deflection held from a time on."""

        def pushed(t: Any) -> FloatArray:
            return np.vecdot(self._direction(t), self.matrices(t)[1][..., 0])

        def rates(t: FloatArray) -> tuple[FloatArray, FloatArray]:
            return self.rate(t)[:, np.newaxis, np.newaxis], -pushed(t)[:, np.newaxis, np.newaxis]

        stop = self.span[1]
        end = np.array([[pushed(stop) / self.rate(stop)]])
        return solved(rates, self.steps, end, backwards=True)


def _fastest(A: FloatArray) -> FloatArray:
    """The largest real eigenvalue of ``(..., n, n)``; minus infinity where there is none."""
    values = np.linalg.eigvals(A).astype(complex)
    return np.max(np.where(values.imag == 0.0, values.real, -np.inf), axis=-1)
