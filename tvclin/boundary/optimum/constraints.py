"""The conditions (4b) as moments of the deflection, eq (C1), for one plant and one wind.

Time u counts from the start of the control, so that no late or early start overflows:

    integral from 0 to H of e_i(u) delta(start + u) du = d_i,     i = 1 ... n

A real pole p gives e = e^(-p u); a complex pair sigma +- j omega gives e^(-sigma u) cos(omega u)
and e^(-sigma u) sin(omega u).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IndexArray
from tvclin.base.errors import InputError, instance, number, single
from tvclin.linear.modes import separated_poles, unstable_poles, wind_over_deflection
from tvclin.linear.plant import PLANT_HINT, Plant
from tvclin.winds.histories import History
from tvclin.winds.pulses import check_end


@dataclass(frozen=True, eq=False)
class Constraints:
    """Moments of a deflection that cancels every unstable mode.

    `poles`: unstable poles [1/s], ``(m,)``, one per conjugate pair, the one with positive imaginary
    part. `demands`: d_i [rad s], ``(n,)``, two for each complex pair: the components with cosine
    and with sine. `horizon`: H [s], the time after the start at which the deflection must be zero
    again; inf if never.
    """

    poles: AnyArray
    demands: FloatArray
    horizon: float = np.inf

    @property
    def real(self) -> bool:
        """Whether every pole is real."""
        return not np.iscomplexobj(self.poles)

    @cached_property
    def decays(self) -> FloatArray:
        """Decay rate [1/s] of each function e_i, ``(n,)``."""
        return np.repeat(np.real(self.poles), self._rows)

    @cached_property
    def pulsations(self) -> FloatArray:
        """Angular frequency [rad/s] of each function e_i, ``(n,)``; zero at real poles."""
        return np.repeat(np.imag(self.poles), self._rows)

    def basis(self, u: FloatArray) -> FloatArray:
        """Return e_i at the times ``u (k,)``, shape ``(n, k)``."""
        return self.in_rows(np.exp(-self.poles[:, np.newaxis] * u))

    def slopes(self, u: FloatArray) -> FloatArray:
        """Return the derivatives of e_i [1/s] at the times ``u (k,)``, shape ``(n, k)``."""
        column = self.poles[:, np.newaxis]
        return self.in_rows(-column * np.exp(-column * u))

    def moments(self, knots: FloatArray) -> FloatArray:
        """Return the integrals of e_i between the times ``(k + 1,)``, shape ``(n, k)``.

        The last may be infinite.
        """
        column = self.poles[:, np.newaxis]
        width = np.diff(knots)
        endless = np.isinf(width)
        fraction = np.where(endless, 1.0, -np.expm1(-column * np.where(endless, 0.0, width)))
        return self.in_rows(np.exp(-column * knots[:-1]) * fraction / column)

    def in_rows(self, values: AnyArray) -> FloatArray:
        """Return the rows ``(n, ...)`` of real conditions for values at the poles ``(m, ...)``."""
        if self.real:
            return values
        components = np.stack([np.real(values), -np.imag(values)], axis=1)
        wanted = np.stack([np.ones(self.poles.size, dtype=bool), self._rows == 2], axis=1)
        return components[wanted]

    def joined(self, rows: FloatArray) -> AnyArray:
        """Return the values ``(m,)`` that `in_rows` splits into the rows ``(n,)``."""
        if self.real:
            return rows
        first = np.cumsum(self._rows) - self._rows
        paired = self._rows == 2
        second = np.where(paired, rows[np.minimum(first + 1, rows.size - 1)], 0.0)
        return rows[first] - 1j * second

    @cached_property
    def _rows(self) -> IndexArray:
        """Number of real conditions of each pole, ``(m,)``: one, or two for a pair."""
        return np.where(np.imag(self.poles) == 0.0, 1, 2)


def conditions(poles: AnyArray, demands: AnyArray, horizon: float = np.inf) -> Constraints:
    """Return the conditions of poles ``(m,)``, one per conjugate pair, with their demands."""
    bare = Constraints(poles, np.zeros(0), horizon)
    return Constraints(poles, bare.in_rows(demands), horizon)


def constraints_of(
    plant: Plant, wind: History, start: float, horizon: float | None = None
) -> Constraints:
    """Return the conditions (C1) on a deflection between `start` and `horizon`.

    `wind`: one wind, which must end. `start`: first time [s] at which the deflection may differ
    from zero. `horizon`: time [s] from which the deflection is zero again; never by default.
    `InputError` for batches, a wind that is zero or never ends, a horizon not after the start or
    before the end of the wind, a start so late that the deflection would overflow, and unstable
    poles that the deflection cannot reach.

    d_i = -(N_wind(p)/N_deflection(p)) e^(p start) L(alpha_w)(p): D_i of eq (C1), moved to the
    start, with a ratio K1_i = (beta_i + b2)/(beta_i + b1) for each pole of its own.
    """
    _check_single(plant, wind)
    start, end = _check_times(wind, start, horizon)
    poles = separated_poles(unstable_poles(plant))
    poles = poles[np.imag(poles) >= 0.0]
    strength = wind_over_deflection(plant, poles)
    if not np.all(np.isfinite(strength)):
        pole = poles[~np.isfinite(strength)][0]
        raise InputError(
            f"the deflection must reach every unstable pole; it has no effect at {pole:.6g} 1/s"
        )
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            demands = -strength * wind.shift(-start).laplace(poles)
    except InputError:
        demands = np.full(poles.shape, np.inf)
    if not np.all(np.isfinite(demands)):
        raise InputError(f"start is so late that no deflection can make up for it; got {start} s")
    return conditions(poles, demands, end - start)


def _check_single(plant: Plant, wind: History) -> None:
    instance("plant", plant, Plant, PLANT_HINT)
    instance("wind", wind, History, "such as TriangularWind")
    single("plant", plant.batch)
    single("wind", wind.batch)
    check_end(wind)


def _check_times(wind: History, start: float, horizon: float | None) -> tuple[float, float]:
    begin = number("start", start, unit="s")
    if horizon is None or (isinstance(horizon, float) and np.isposinf(horizon)):
        return begin, np.inf
    end = number("horizon", horizon, unit="s")
    if end <= begin:
        raise InputError(f"horizon must be after start ({begin:.6g} s); got {end:.6g} s")
    if end < wind.end:
        raise InputError(
            f"horizon must not be before the wind ends at {wind.end:.6g} s; got {end:.6g} s"
        )
    return begin, end
