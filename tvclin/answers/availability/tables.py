"""The needs of a flight in any wind, integrated once: a wind is a sum over its straight lines.

With p = m l of `FlightMode`, m' = -mu m, the wind still to come at the time a is

    m(a) future(a) = U(a) = integral from a on of m (l.w) alpha_w dt,

and the path under ideal trim, x' = F x + c alpha_w, is x = Psi X with Psi' = F Psi and

    X(a) = integral up to a of Psi^-1 c alpha_w dt.

Of a wind of straight lines both follow from the first and the second integral of what stands
beside alpha_w, by parts: over a line from a to b with the slope r

    integral of g alpha_w dt = alpha_w(b) G0(b) - alpha_w(a) G0(a) - r (G1(b) - G1(a)).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tvclin.answers.sizing.flight_mode import FlightMode
from tvclin.answers.trim_flown import path_counts
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.boundary.limit import leading_pole

_STEP = 5e-4
"""Between the times of a table, over the time in which the fastest mode grows by e: straight lines
between them are then off by a part of _STEP^2/8, 3e-8."""
_LOOKS = 200
"""Times of a flight at which pairs of poles and the pace of the path are looked at."""


@dataclass(frozen=True, eq=False)
class FlightTables:
    """What a flight in one plane makes of any wind, at even times.

    `rows` has for each time one, ``(n, c)``: of the wind to come G0 and G1, from the end on; 1/(m
    reach); -B; each as long as the path has states, its `order`: G0 and G1 of the path,
    l.Psi/reach, and the trim deflection of Psi; 1 where two modes grow as a pair; and 1 where the
    path has a say beside the fastest mode. Signs are such that a limit is positive.
    """

    start: float
    step: float
    rows: FloatArray
    order: int
    mode: FlightMode

    def at(self, times: FloatArray) -> TableRows:
        """Return the rows at times [s] within the flight, straight lines between them."""
        place = (times - self.start) / self.step
        index = np.clip(place.astype(np.int64), 0, self.rows.shape[0] - 2)
        part = (place - index)[..., np.newaxis]
        low, high = (self.rows.take(one, axis=0) for one in (index, index + 1))
        return TableRows(low + part * (high - low), self.order)


@dataclass(frozen=True, eq=False)
class TableRows:
    """Rows of `FlightTables` at times of the shape ``(...)``; see its `rows`."""

    rows: FloatArray
    order: int

    @property
    def ahead(self) -> tuple[FloatArray, FloatArray]:
        """G0 and G1 of the wind to come, each ``(..., 1)``."""
        return self.rows[..., 0:1], self.rows[..., 1:2]

    @property
    def path(self) -> tuple[FloatArray, FloatArray]:
        """G0 and G1 of the path, each ``(..., order)``."""
        n = self.order
        return self.rows[..., 4 : 4 + n], self.rows[..., 4 + n : 4 + 2 * n]

    @property
    def per_wind(self) -> FloatArray:
        """Trim of a wind [rad/rad]."""
        return self.rows[..., 3]

    def demand(self, to_come: FloatArray, path: FloatArray) -> FloatArray:
        """Return the limit [rad] that is enough from now on, of U ``(...)``, X ``(..., order)``."""
        reach = self.rows[..., 4 + 2 * self.order : 4 + 3 * self.order]
        return np.asarray(self.rows[..., 2] * to_come + np.sum(reach * path, axis=-1))

    def trim(self, wind: FloatArray, path: FloatArray) -> FloatArray:
        """Return the trim deflection [rad] in a wind [rad]."""
        drifted = self.rows[..., 4 + 3 * self.order : 4 + 4 * self.order]
        return np.asarray(self.per_wind * wind + np.sum(drifted * path, axis=-1))

    @property
    def paired(self) -> BoolArray:
        """Whether two modes grow together: trim must then never be limited."""
        return np.asarray(self.rows[..., -2] > 0.0)

    @property
    def drifts_fast(self) -> BoolArray:
        """Whether the path has a say beside the fastest mode."""
        return np.asarray(self.rows[..., -1] > 0.0)


def flight_tables(mode: FlightMode) -> FlightTables:
    """Return the tables of a flight, in which the air turns the vehicle to one side alone.

    `InputError` for a vehicle without a real unstable pole.
    """
    start, stop = mode.span
    fastest = float(np.max(mode.growth_rate(np.linspace(start, stop, 1000))))
    count = max(math.ceil((stop - start) * fastest / _STEP), 2)
    times = np.linspace(start, stop, count + 1)
    step = (stop - start) / count
    row, reach = mode.at(times)
    A, inputs = mode.matrices(times)
    trim = -inputs[:, 1, 1] / inputs[:, 1, 0]
    side = float(np.sign(trim[np.argmax(np.abs(trim))]))
    looks = np.linspace(start, stop, _LOOKS)
    held = mode.schedule.plants(looks, mode.model, mode.plane)
    growth = np.exp(_from_the_end(mode.growth_rate(times), step))
    driven = np.asarray(np.einsum("jt,tj->t", row, inputs[:, :, 1]), dtype=float)
    ahead = _from_the_end(growth * driven, step)
    Psi = _path_under_trim(mode, times)
    to_path = (-A[:, 1, 2:] / inputs[:, 1, :1])[:, np.newaxis, :] @ Psi
    kernel = np.asarray(np.linalg.solve(Psi, mode.under_trim(times)[1])[..., 0], dtype=float)
    first = _from_the_start(kernel, step)
    columns = [
        np.stack([-ahead, _from_the_end(ahead, step), -side / (growth * reach), side * trim], -1),
        first,
        _from_the_start(first, step),
        -side * np.einsum("jt,tjk->tk", row[2:], Psi) / reach[:, np.newaxis],
        side * to_path[:, 0],
        *(
            np.interp(times, looks, counts)[:, np.newaxis]
            for counts in (leading_pole(held)[1], path_counts(held))
        ),
    ]
    return FlightTables(start, step, np.concatenate(columns, axis=-1), Psi.shape[-1], mode)


def _path_under_trim(mode: FlightMode, times: FloatArray) -> FloatArray:
    """Psi at times [s], ``(n, order, order)``, by Runge and Kutta's rule of fifth order."""
    from scipy.integrate import solve_ivp

    order = mode.matrices(times[0])[0].shape[-1] - 2
    if not order:
        return np.zeros((times.size, 0, 0))

    def rates(t: float, Psi: FloatArray) -> FloatArray:
        return np.ravel(mode.under_trim(t)[0] @ Psi.reshape(order, order))

    found = solve_ivp(rates, mode.span, np.eye(order).ravel(), t_eval=times, rtol=1e-8, atol=1e-10)
    return np.asarray(found.y.T).reshape(-1, order, order)


def _from_the_start(values: FloatArray, step: float) -> FloatArray:
    """Integrate over the first axis, by the trapezoidal rule."""
    sums = np.cumsum(0.5 * step * (values[1:] + values[:-1]), axis=0)
    return np.concatenate([np.zeros_like(values[:1]), sums])


def _from_the_end(values: FloatArray, step: float) -> FloatArray:
    """Integrate from each place to the end of the first axis."""
    return _from_the_start(values[::-1], step)[::-1]
