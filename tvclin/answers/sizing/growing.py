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
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.answers.sizing.schedule import FlightSchedule
from tvclin.base.errors import InputError
from tvclin.boundary.recoverable import left_vector

FloatArray = NDArray[np.float64]

RTOL, ATOL = 1e-9, 1e-12
_LONGEST = 500.0
"""Of the span, over the time of the fastest mode; the solver takes at least twice as many steps."""
_MOST_ROWS = 100_000
_STEP = 0.5
"""Between rows of the schedule coefficients are tabulated at least every half second."""


@dataclass(frozen=True, eq=False)
class GrowingMode:
    """The growing direction over a flight.

    Attributes
    ----------
    schedule : FlightSchedule
        The vehicle; outside its span that of its nearer end.
    model, plane : str
        As of `Plant`.
    span : tuple of float
        The flight [s]; parameters are constant after it.
    """

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

    def rate(self, t: Any) -> FloatArray:
        """Return the growth rate mu [1/s] at times [s]."""
        row, _ = self.at(t)
        A, _ = self.matrices(t)
        return np.asarray(np.einsum("i...,...ij,j...->...", row, A, row))

    def at(self, t: Any) -> tuple[FloatArray, Any]:
        """Return l = p/m, ``(n,) + t.shape``, and the reach of a unit deflection held from t on.

        That is the integral from t on of m(r)/m(t) l(r).b(r) dr.
        """
        found = self._solution(np.clip(t, *self.span))
        return found[:-2], found[-2]

    def farthest(self, t: Any) -> FloatArray:
        """Return the most that a deflection of size one can reach from times [s] on.

        That is the integral of m(r)/m(t) |l(r).b(r)| dr: where l.b turns, the deflection turns.
        """
        return np.asarray(self._solution(np.clip(t, *self.span))[-1])

    @property
    def grows(self) -> bool:
        """Whether anything grows in this flight; else there is no direction in which it does."""
        return self._rows[0].size > 1

    @property
    def held_from(self) -> float:
        """The last time [s] with a real unstable pole, after which parameters are taken as there.

        Beyond it the vehicle is stable, or oscillates; that it grows for ever asks for no less.
        """
        return float(self._rows[0][-1])

    @cached_property
    def _rows(self) -> tuple[FloatArray, FloatArray]:
        """Times [s], and A beside the columns of the inputs; up to the last real unstable pole."""
        rows = self.schedule.times
        if rows[-1] - rows[0] > _MOST_ROWS * _STEP:
            raise InputError(
                f"varying parameters can be followed for at most {_MOST_ROWS * _STEP:.4g} s; the"
                f" flight lasts {rows[-1] - rows[0]:.4g} s: shorten the winds"
            )
        between = [
            np.linspace(a, b, math.ceil((b - a) / _STEP), endpoint=False) for a, b in pairwise(rows)
        ]
        times = np.concatenate([*between, rows[-1:]])
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

    @cached_property
    def _solution(self) -> Any:
        """(l, reach, farthest) over the span, integrated backwards from a constant end."""
        from scipy.integrate import solve_ivp

        start, stop = self.span
        A, inputs = self.matrices(stop)
        pole = float(_fastest(A))
        if pole * (stop - start) > _LONGEST:
            raise InputError(
                f"varying parameters can be followed for at most {_LONGEST / pole:.4g} s,"
                f" {_LONGEST:g} times that of the fastest mode; schedule and winds together last"
                f" {stop - start:.4g} s: shorten the winds"
            )
        row = left_vector(A, pole)
        row = row * np.sign(row[1])
        held = row @ inputs[:, 0] / pole
        quickest = math.sqrt(float(np.abs(self._rows[1][:, 1, 0]).max()))

        def rates(t: float, y: FloatArray) -> FloatArray:
            A, inputs = self.matrices(t)
            row, reaches = y[:-2], y[-2:]
            back = row @ A
            mu = back @ row / (row @ row)
            pushed = row @ inputs[:, 0]
            return np.append(mu * row - back, mu * reaches - [pushed, abs(pushed)])

        return solve_ivp(
            rates,
            (stop, start),
            [*row, held, abs(held)],
            method="DOP853",
            rtol=RTOL,
            atol=ATOL,
            max_step=0.5 / quickest,
            dense_output=True,
        ).sol


def _fastest(A: FloatArray) -> FloatArray:
    """The largest real eigenvalue of ``(..., n, n)``; minus infinity where there is none."""
    values = np.linalg.eigvals(A).astype(complex)
    return np.max(np.where(values.imag == 0.0, values.real, -np.inf), axis=-1)
