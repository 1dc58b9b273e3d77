"""The conditions (4b) as moments of the deflection, eq (C1), and sums of their exponentials.

Time u counts from the start of the control, so that no late or early start overflows:

    integral from 0 to H of e_i(u) delta(start + u) du = d_i,     i = 1 ... n

A real pole p gives e = e^(-p u); a complex pair sigma +- j omega gives e^(-sigma u) cos(omega u)
and e^(-sigma u) sin(omega u). The dual of the minimum-peak problem requires of a sum lambda . e(u)
its changes of sign t_j, its L1 norm, and the gradient of that, the moments of the sign:

    L1 = integral |lambda . e| du,    m = integral e sgn(lambda . e) du.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IndexArray
from tvclin.base.errors import InputError, instance, number, single
from tvclin.linear.modes import separated_poles, unstable_poles, wind_over_deflection
from tvclin.linear.plant import PLANT_HINT, Plant
from tvclin.numerics.searches import roots_between
from tvclin.winds.histories import History
from tvclin.winds.pulses import check_end

_MAX_DECAY_TIMES = 60.0
"""Times of the slowest real pole, in e-folding times, up to which a change of sign is sought."""
TRUNCATED = 34.0
"""Length of the window, in e-folding times, for a complex pair, whose sign changes without end."""
_GEOMETRIC_POINTS = 600
"""Points of the grid, evenly spaced in their logarithm: fifty or so a decade. Two zeros between
neighbours are detected by the dip between them; two dips would be missed."""
_POINTS_PER_HALF_PERIOD = 16
"""Points of the grid for each half wave of a complex pole."""
_MAX_POINTS = 200_000
"""Largest number of points for a complex pole, to bound the memory; beyond it they are coarser."""
_NEGLIGIBLE_MULTIPLIER = 1e-200
"""Multiplier, relative to the largest, that cannot be distinguished from zero."""


@dataclass(frozen=True, eq=False)
class Constraints:
    """Moments of a deflection that cancels every unstable mode.

    `poles`: unstable poles [1/s], ``(m,)``, of a conjugate pair the pole with positive imaginary
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
        """Decay rate [1/s] of each exponential e_i, ``(n,)``."""
        return np.repeat(np.real(self.poles), self._rows_of_poles)

    @cached_property
    def pulsations(self) -> FloatArray:
        """Angular frequency [rad/s] of each exponential e_i, ``(n,)``; zero at real poles."""
        return np.repeat(np.imag(self.poles), self._rows_of_poles)

    def basis(self, u: FloatArray) -> FloatArray:
        """Return the poles' exponentials e_i at times `u` [s], ``(k,)``, as rows ``(n, k)``.

        A real pole p has e^(-p u); a pair e^(-sigma u) cos(omega u) and e^(-sigma u) sin(omega u).
        """
        return self.real_rows(np.exp(-self.poles[:, np.newaxis] * u))

    def slopes(self, u: FloatArray) -> FloatArray:
        """Return the derivatives [1/s] of the poles' exponentials at times `u` [s], ``(n, k)``."""
        column = self.poles[:, np.newaxis]
        return self.real_rows(-column * np.exp(-column * u))

    def moments(self, knots: FloatArray) -> FloatArray:
        """Return the integrals [s] of the exponentials e_i between `knots` [s], ``(n, k)``.

        n are the real rows of `real_rows`, two for a complex pair; `knots`: ``(k + 1,)``, rising,
        the last of which may be infinite.
        """
        column = self.poles[:, np.newaxis]
        width = np.diff(knots)
        endless = np.isinf(width)
        # integral of e^(-p u) from t to t + h: e^(-p t) (1 - e^(-p h))/p
        fraction = np.where(endless, 1.0, -np.expm1(-column * np.where(endless, 0.0, width)))
        return self.real_rows(np.exp(-column * knots[:-1]) * fraction / column)

    def real_rows(self, values: AnyArray) -> FloatArray:
        """Return complex `values` at m poles ``(m, ...)`` as rows ``(n, ...)``, two for a pair.

        The two are the real part, with the cosine, and minus the imaginary part, with the sine.
        """
        if self.real:
            return values
        components = np.stack([np.real(values), -np.imag(values)], axis=1)
        # each pole has the real part, and one of two rows the imaginary part too
        wanted = np.stack([np.ones(self.poles.size, dtype=bool), self._rows_of_poles == 2], axis=1)
        return components[wanted]

    def complex_values(self, rows: FloatArray) -> AnyArray:
        """Return the values ``(m,)`` at m poles, complex for a pair, of real rows ``(n,)``.

        It is the inverse of `real_rows`: of a pair the rows are real and minus imaginary part.
        """
        if self.real:
            return rows
        # first row of each pole, which has one or two
        first = np.cumsum(self._rows_of_poles) - self._rows_of_poles
        paired = self._rows_of_poles == 2
        second = np.where(paired, rows[np.minimum(first + 1, rows.size - 1)], 0.0)
        return rows[first] - 1j * second

    @cached_property
    def _rows_of_poles(self) -> IndexArray:
        """Number of real conditions of each pole, ``(m,)``: one, or two for a pair."""
        return np.where(np.imag(self.poles) == 0.0, 1, 2)


def conditions(poles: AnyArray, demands: AnyArray, horizon: float = np.inf) -> Constraints:
    """Return the conditions of m `poles` p [1/s], ``(m,)``, one per conjugate pair.

    `demands`: what the integral of e^(-p t) times the deflection must be [rad s], ``(m,)``, complex
    for a pair. `horizon`: time [s] after which the deflection is zero; infinite if never.
    """
    without_demands = Constraints(poles, np.zeros(0), horizon)  # knows which poles are pairs
    return Constraints(poles, without_demands.real_rows(demands), horizon)


def constraints_of(
    plant: Plant, wind: History, start: float, horizon: float | None = None
) -> Constraints:
    """Return the conditions, eq (C1) of the report, on a deflection from `start` to `horizon`.

    `plant`: one plant. `wind`: one wind, which must end. `start`: first time [s] at which the
    deflection may differ from zero. `horizon`: time [s] from which the deflection is zero again;
    never by default. `InputError` for batches, a wind that is zero or never ends, a horizon not
    after the start or before the end of the wind, a start so late that the deflection would
    overflow, and unstable poles that the deflection cannot reach.

    d_i = -(N_wind(p)/N_deflection(p)) e^(p start) L(alpha_w)(p): D_i of eq (C1), moved to the
    start, with a ratio K1_i = (beta_i + b2)/(beta_i + b1) for each pole of its own.
    """
    instance("plant", plant, Plant, PLANT_HINT)
    instance("wind", wind, History, "such as TriangularWind")
    single("plant", plant.batch)
    single("wind", wind.batch)
    check_end(wind)
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


def _check_times(wind: History, start: float, horizon: float | None) -> tuple[float, float]:
    """Return `start` and `horizon` [s], infinite for None; `InputError` if that is too early.

    It must be after the start, and not before the end of the `wind`.
    """
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


@dataclass(frozen=True, eq=False)
class Window:
    """The poles' exponentials e_i, of `constraints`, on a grid for the zeros of their sums."""

    constraints: Constraints

    @cached_property
    def end(self) -> float:
        """Time [s] up to which sums of the exponentials are evaluated.

        It is the horizon of the constraints. Without one it is infinite for real poles, and 34 of
        the slowest time constants with a complex pair, whose sums change sign without end.
        """
        c = self.constraints
        if c.real or np.isfinite(c.horizon):
            return float(c.horizon)
        return float(TRUNCATED / c.decays.min())

    @cached_property
    def grid(self) -> FloatArray:
        """Times [s] at which sums of the exponentials are sampled for their zeros, ``(k,)``.

        They are evenly spaced in their logarithm, and within each period of a complex pair.
        """
        c = self.constraints
        last = min(self.end, _MAX_DECAY_TIMES / c.decays.min())
        # far below the fastest time constant, and within the window
        first = min(1e-6 / np.abs(c.poles).max(), 1e-3 * last)
        parts = [np.zeros(1), np.geomspace(first, last, _GEOMETRIC_POINTS)]
        for pole in c.poles[np.imag(c.poles) > 0.0]:
            step = np.pi / np.imag(pole) / _POINTS_PER_HALF_PERIOD
            pair_end = min(last, 700.0 / np.real(pole))  # e^-700 is the end of floating point
            parts.append(np.linspace(0.0, pair_end, int(min(pair_end / step + 2, _MAX_POINTS))))
        return np.unique(np.concatenate(parts))

    @cached_property
    def values(self) -> FloatArray:
        """Exponentials e_i = e^(-p_i u) of the poles at the times u of `grid`, ``(n, k)``.

        A complex pair has two rows, with the cosine and the sine; see `Constraints.basis`.
        """
        return self.constraints.basis(self.grid)

    @cached_property
    def slopes(self) -> FloatArray:
        """Derivatives [1/s] of the poles' exponentials e_i at the times of `grid`, ``(n, k)``."""
        return self.constraints.slopes(self.grid)

    @cached_property
    def sizes(self) -> FloatArray:
        """Upper bounds of the L1 norm of each e_i, ``(n,)``: the norms of the envelopes."""
        decays = self.constraints.decays
        return -np.expm1(-decays * self.end) / decays

    def zeros(self, multipliers: FloatArray) -> FloatArray:
        """Return the times [s] at which the sum lambda . e changes its sign, ascending, ``(k,)``.

        Of a grid the neighbours of different sign, and dips between neighbours of the same sign,
        are refined. `multipliers`: lambda, ``(n,)``, of the poles' exponentials e.
        """
        c = self.constraints
        values, slopes = multipliers @ self.values, multipliers @ self.slopes
        # a dip between neighbours: values of one sign whose slopes point towards zero, then away
        sides, rises = np.sign(values), np.sign(slopes)  # of the sum and of its slope
        dips = (sides[:-1] == sides[1:]) & (sides[:-1] == -rises[:-1]) & (sides[1:] == rises[1:])
        times = self.grid
        if np.any(dips):  # perhaps two zeros between neighbours: look at the bottom of the dip
            bottoms = _refined(multipliers, c.slopes, times, np.flatnonzero(dips))
            times = np.concatenate([times, bottoms])
            order = np.argsort(times, kind="stable")
            values = np.concatenate([values, multipliers @ c.basis(bottoms)])[order]
            times = times[order]
        values, times = values[values != 0.0], times[values != 0.0]
        crossed = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
        return _refined(multipliers, c.basis, times, crossed) if crossed.size else np.zeros(0)

    def signed(self, multipliers: FloatArray) -> SignedSum:
        """Return the sum with `multipliers` ``(n,)``: its zeros, signs, norm and gradient."""
        zeros = self.zeros(multipliers)
        knots = np.concatenate([[0.0], zeros, [self.end]])
        moments = self.constraints.moments(knots)
        # `moments`: integrals of e between the zeros, ``(n, k + 1)``; `areas`: those of the sum
        areas = multipliers @ moments
        signs = np.where(areas < 0.0, -1.0, 1.0)
        norm = float(np.abs(areas).sum())
        return SignedSum(
            self, multipliers, zeros=zeros, signs=signs, norm=norm, moments=moments @ signs
        )

    def piece_moments(self, switches: FloatArray) -> FloatArray:
        """Return moments ``(n, k + 1)`` of +1, -1, +1 ... between `switches` [s], ``(k,)``.

        The moment of a piece is its integral times each of the n exponentials e_i [s].
        """
        signs = (-1.0) ** np.arange(switches.size + 1)
        return self.constraints.moments(np.concatenate([[0.0], switches, [self.end]])) * signs

    def violation(self, switches: FloatArray, limit: float) -> float:
        """Return the largest violation of a condition (C1), relative to the sizes of its terms.

        The i-th condition is that the moments of the deflection's pieces sum up to d_i.
        `switches`: times [s] at which the deflection changes its sign, ``(k,)``. `limit`: its first
        value [rad].
        """
        # d_i ``(n,)``, and the moments [rad s] of the k + 1 pieces of the deflection ``(n, k + 1)``
        demands, pieces = self.constraints.demands, limit * self.piece_moments(switches)
        sizes = np.abs(pieces).sum(axis=1) + np.abs(demands)
        return float((np.abs(pieces.sum(axis=1) - demands) / sizes).max())

    def is_underflowing(self, multipliers: FloatArray) -> bool:
        """Return whether a term of the sum with `multipliers` is below 1e-200 of the largest.

        Such a multiplier cannot be distinguished from zero. The size of a term is its multiplier's
        times the bound of the L1 norm of its exponential, `sizes`. `multipliers`: ``(n,)``.
        """
        sizes = np.abs(multipliers) * self.sizes
        return bool(sizes.min() < _NEGLIGIBLE_MULTIPLIER * sizes.max())

    def vanishing_at(self, times: FloatArray) -> FloatArray:
        """Return multipliers lambda ``(n,)`` whose sum lambda . e is zero, or smallest, at `times`.

        They are the right singular vector of the smallest singular value of the exponentials e_i of
        the unstable poles (`Constraints.basis`) at these times [s], ``(k,)``, each exponential
        scaled to the size one, against rounding, and each time weighted by the largest of them.
        Without times they are the demands d_i over the squared `sizes` of the e_i (bounds of their
        L1 norms): d_i is the integral of e_i times the deflection that cancels a mode.
        """
        c = self.constraints
        if not times.size:
            return c.demands / self.sizes**2
        values = c.basis(times)
        with np.errstate(divide="ignore", over="ignore"):
            scale = 1.0 / np.abs(values).max(axis=1)
        scale = np.where(np.isfinite(scale), scale, 1.0)
        # weight of each time: the largest of the e_i then, each over its own size
        weight = np.abs(values / self.sizes[:, np.newaxis]).max(axis=0)
        rows = np.nan_to_num((values * scale[:, np.newaxis] * weight).T, posinf=0.0, neginf=0.0)
        *_, right_vectors = np.linalg.svd(rows)
        return right_vectors[-1] * scale

    def tail(self, multipliers: FloatArray) -> float:
        """Return a bound of the L1 norm, after the window's end, of the sum with `multipliers`.

        Each exponential counts with its whole area beyond the end. Zero without such an end, and
        where the deflection ends there (the horizon). `multipliers`: ``(n,)``.
        """
        c = self.constraints
        if np.isinf(self.end) or np.isfinite(c.horizon):
            return 0.0
        beyond = np.exp(-c.decays * self.end) / c.decays
        return float(np.abs(multipliers) @ beyond)


@dataclass(frozen=True, eq=False)
class SignedSum:
    """A sum lambda . e of the exponentials of a `window`, its changes of sign, norm and gradient.

    `multipliers`: lambda, ``(n,)``. `zeros`: times [s] of its changes of sign, ``(k,)``. `signs`:
    its sign between them, ``(k + 1,)``. `norm`: its L1 norm on the window. `moments`: the moments
    of its sign, ``(n,)``: the gradient of the norm.
    """

    window: Window
    multipliers: FloatArray
    zeros: FloatArray
    signs: FloatArray
    norm: float
    moments: FloatArray

    @cached_property
    def residual(self) -> float:
        """Largest violation of the conditions of survival by the deflection norm sgn(lambda . e).

        Condition i: the integral of deflection times e_i, the exponential of pole i, is the demand
        i of the wind [rad s]. lambda: multipliers; norm: L1 norm of lambda . e, here the peak
        [rad]. The violation is relative to the sum of the terms' sizes.
        """
        demands = self.window.constraints.demands
        with np.errstate(over="ignore", invalid="ignore"):  # multipliers may be beyond all measure
            sizes = self.norm * self.window.sizes + np.abs(demands)
            violations = np.abs(self.norm * self.moments - demands) / sizes
        return float(np.where(np.isnan(violations), np.inf, violations).max())


def decay_spaced_times(decay: float, last: float, count: int) -> FloatArray:
    """Return `count` times [s] from 0 to `last`, even in e^(-decay u/4); `decay` in 1/s.

    They end at 100/decay, if that is earlier, beyond which the exponential is rounding.
    """
    reach = -np.expm1(-decay * min(last, 100.0 / decay) / 4.0)
    return -4.0 / decay * np.log1p(-np.linspace(0.0, reach, count))


def separate_nodes(nodes: FloatArray, gap: float) -> FloatArray:
    """Return nodes [s] in order, without those within `gap` [s] of the next; the last stays."""
    nodes = np.unique(nodes)
    return np.append(nodes[:-1][np.diff(nodes) > gap], nodes[-1])


def _refined(
    multipliers: FloatArray,
    function: Callable[[FloatArray], FloatArray],
    times: FloatArray,
    intervals: IndexArray,
) -> FloatArray:
    """Return the zeros [s] of lambda . function, one in each of some intervals between times.

    `multipliers`: lambda, ``(n,)``. `function`: of times [s] to n rows, with one change of sign in
    each interval. `times`: in order [s]. `intervals`: indices of the intervals' first times.
    """
    sign = np.sign(multipliers @ function(times[intervals + 1]))

    def rising(u: FloatArray, k: IndexArray) -> FloatArray:
        """Return the sum at a time `u` [s] in each interval `k`, with a sign so that it rises."""
        return np.asarray(sign[k] * (multipliers @ function(u)))

    return roots_between(times[intervals], times[intervals + 1], rising)
