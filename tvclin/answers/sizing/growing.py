"""The growing direction of a vehicle whose parameters vary: the adjoint solution of eq (4b).

    x' = A(t) x + b(t) delta + w(t) alpha_w,     p' = -A(t)^T p

p.x is the part of the state that grows. It goes to zero in the end exactly when

    integral of p.b delta + p.w alpha_w dt = 0,

which for constant parameters, p = e^(-s t) times the left eigenvector, is eq (4b). Integrated
backwards, every solution turns into the one of the growing direction. It is kept as
p = m(t) (s, s/(s + d), ...) with m' = -s m, so that nothing overflows: s is the pole of the moment,
and d its damping.
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
from tvclin.linear.modes import unstable_modes
from tvclin.linear.plant import Plant

FloatArray = NDArray[np.float64]

RTOL, ATOL = 1e-9, 1e-12
_LONGEST = 500.0
"""Of the span, over the time of the fastest mode; the solver takes at least twice as many steps."""
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

    def at(self, t: Any) -> tuple[FloatArray, Any]:
        """Return l = p/m, ``(n,) + t.shape``, and the reach of a unit deflection held from t on.

        That is the integral from t on of m(r)/m(t) l(r).b(r) dr.
        """
        found = self._solution(np.clip(t, *self.span))
        return found[:-1], found[-1]

    @cached_property
    def _table(self) -> Any:
        from scipy.interpolate import PchipInterpolator

        rows = self.schedule.times
        between = [
            np.linspace(a, b, math.ceil((b - a) / _STEP), endpoint=False) for a, b in pairwise(rows)
        ]
        times = np.concatenate([*between, rows[-1:]])
        plant = Plant.from_vehicle(self.schedule.held(times), self.model, self.plane)
        A, inputs, _, _ = plant.matrices()
        both = np.concatenate([A, inputs], axis=-1)
        rows = np.broadcast_to(both, (times.size, *both.shape[-2:]))
        table = PchipInterpolator(times, rows, axis=0)
        return lambda t: table(np.clip(t, times[0], times[-1]))

    @cached_property
    def _solution(self) -> Any:
        """(l, reach) over the span, integrated backwards from a constant end."""
        from scipy.integrate import solve_ivp

        start, stop = self.span
        vehicle = self.schedule.held(stop)
        plant = Plant.from_vehicle(vehicle, self.model, self.plane)
        poles = unstable_modes(plant).poles
        real = np.real(poles[np.imag(poles) == 0.0])
        if not real.size:
            raise InputError(
                "varying parameters need a real unstable pole at the end of the flight, at"
                f" {stop:.6g} s"
            )
        A, inputs, _, _ = plant.matrices()
        damping = float(plant.coefficients.damping)
        fastest = float(real.max())
        if fastest * (stop - start) > _LONGEST:
            raise InputError(
                f"varying parameters can be followed for at most {_LONGEST / fastest:.4g} s,"
                f" {_LONGEST:g} times that of the fastest mode; schedule and winds together last"
                f" {stop - start:.4g} s: shorten the winds"
            )
        row = left_vector(A, fastest)
        row = row / row[1] * (fastest / (fastest + damping))  # its first part is the pole
        end = np.append(row, row @ inputs[:, 0] / row[0])

        def rates(t: float, y: FloatArray) -> FloatArray:
            A, inputs = self.matrices(t)
            row, reach = y[:-1], y[-1]
            turned = row[0] * row - row @ A
            return np.append(turned, row[0] * reach - row @ inputs[:, 0])

        return solve_ivp(
            rates,
            (stop, start),
            end,
            method="DOP853",
            rtol=RTOL,
            atol=ATOL,
            max_step=0.5 / row[0],
            dense_output=True,
        ).sol
