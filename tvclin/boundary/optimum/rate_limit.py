"""The deflection of minimum peak when it may change only at a limited rate.

    min peak |delta|   with   eq (C1)   and   |delta'| <= r

A linear program over deflections that are linear between nodes, with the exact moments of each
linear piece. The nodes are refined where the rate or the peak begins or ceases to bind.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, between, number, positive, shown, whole_number
from tvclin.base.fields import spec
from tvclin.boundary.limit import OK, STABLE
from tvclin.boundary.optimum.minimum_peak import NOT_EXCITED, Optimum, optimum_under
from tvclin.boundary.optimum.moments import (
    Constraints,
    constraints_of,
    decay_spaced_times,
    separate_nodes,
)
from tvclin.linear.plant import Plant
from tvclin.numerics.pieces import moments
from tvclin.winds.histories import History, Piecewise, linear_pieces

_PEAK, _MOTION, _RATE = "peak", "motion", "rate"
_RESIDUAL_SCALE = 1e8
"""Factor of the residual in a program that corrects a solution: the tolerance is 1e-7."""
_MAX_CORRECTIONS = (1e5, 1e2, 1e2)
"""Largest change of a variable in each correction, times `_RESIDUAL_SCALE`."""
RATE_RANGE = (1e-15, 1e9)
"""Smallest and largest rate [rad/s] and acceleration that differ from zero and infinity."""
_MIN_STEPS, _STEPS, _MAX_STEPS = 10, 200, 10_000
"""Smallest, default and largest number of intervals to begin with."""
_REFINEMENTS = 8
"""Largest number of programs, each on finer nodes; `change`: the peak's by the last program."""
_RELATIVE_CHANGE = 1e-8
"""Relative change of the peak below which the nodes are fine enough."""
_ACTIVE_DISTANCE = 1e-7
"""Relative distance at which the peak or the rate limit counts as active: a program's tolerance."""
_SPAN_OVER_TIME_CONSTANT = 20.0
"""Time of the last node over the slowest time constant: later changes of the peak are e^-20."""
_MAX_SPLIT_INTERVALS = 40
"""Largest number of intervals split at a time, by descending price."""


@dataclass(frozen=True, eq=False)
class RateProgram:
    """Programs of minimum peak, motion and rate of a deflection that is linear between nodes.

    `nodes`: times [s] after the start, ``(k,)``, from zero on; the last value stays constant.
    `rate`: rate limit [rad/s]. `unit`: unit [rad] of the values.
    """

    constraints: Constraints
    nodes: FloatArray
    rate: float
    unit: float

    @cached_property
    def moments(self) -> FloatArray:
        """Integrals [s] of the poles' exponentials times the hat function of each node, ``(n, k)``.

        A hat function is one at its node, zero at the others and linear between nodes; the last of
        k stays one up to the horizon. A complex pair has two of the n rows (`real_rows`).
        """
        # On an interval of width h from t, with x = (u - t)/h, a node's share is x or 1 - x, and
        # integral e^(-p u) x du = e^(-p t) h M_1(p h), with the moments M_k of `numerics.pieces`.
        c, widths = self.constraints, np.diff(self.nodes)
        column = c.poles[:, np.newaxis]
        integrals = moments(column * widths, 1)
        lead = np.exp(-column * self.nodes[:-1]) * widths
        rising = c.real_rows(lead * integrals[..., 1])
        falling = c.real_rows(lead * (integrals[..., 0] - integrals[..., 1]))
        last = c.moments(np.array([self.nodes[-1], c.horizon]))
        zero = np.zeros((last.shape[0], 1))
        return np.hstack([falling, last]) + np.hstack([zero, rising])

    @cached_property
    def sizes(self) -> FloatArray:
        """Sums of absolute moments [s] of each condition, ``(n,)``, by which its row is divided."""
        return np.abs(self.moments).sum(axis=1)

    @property
    def steps(self) -> FloatArray:
        """Largest change of the deflection between two of k nodes, over `unit`, ``(k - 1,)``."""
        return self.rate * np.diff(self.nodes) / self.unit

    def residual(self, values: FloatArray) -> float:
        """Return the largest violation of the n conditions of survival, relative to their terms.

        Condition: the integral of the deflection times the exponential e^(-p t) of a pole p is the
        wind's demand [rad s], of `constraints`. `values`: deflection at the nodes [rad], ``(k,)``.
        """
        demands = self.constraints.demands
        violation = np.abs(self.moments @ values - demands)
        return float((violation / (np.abs(self.moments) @ np.abs(values) + np.abs(demands))).max())

    def minimum_peak(self) -> tuple[FloatArray, FloatArray] | None:
        """Return the deflection of minimum peak at the nodes, ``(k,)``, and prices.

        It is normalised by `unit` [rad], zero at the first node, and its values at the others are
        the first variables of the program. Prices are the multipliers of the conditions, ``(n,)``,
        the program's last rows, which are divided by `sizes`. None if infeasible.
        """
        result = self._solve(_PEAK)
        if result is None:
            return None
        prices = result.eqlin.marginals[-self.sizes.size :] / self.sizes
        return np.append(0.0, result.x[: self.nodes.size - 1]), prices

    def minimum_motion(self, peak: float) -> FloatArray | None:
        """Return the deflection of least total change within `peak`, at the k nodes, over `unit`.

        `unit` is the unit [rad] of the program's values, and of `peak`. None if infeasible. The
        program satisfies its conditions to 1e-7. So further programs give corrections, each within
        a smaller change, for the residual; residual and correction are times `_RESIDUAL_SCALE`.
        """
        # the deflection of minimum peak where `peak` is below the minimum by rounding
        result = self._solve(_MOTION, peak) or self._solve(_PEAK)
        if result is None:
            return None
        solution = result.x
        for max_change in _MAX_CORRECTIONS:
            correction = self._solve(_PEAK, around=solution, max_change=max_change)
            if correction is not None:
                solution = solution + correction.x / _RESIDUAL_SCALE
        return np.append(0.0, solution[: self.nodes.size - 1])  # zero at the first node

    def minimum_rate(self) -> float:
        """Return the smallest rate limit [rad/s] at which some deflection survives, or inf.

        The deflection has any peak, and is linear between `nodes`. It survives if its integrals
        times the exponential of each unstable pole are those that cancel the wind, the demands
        of `constraints`. The last variable of the program `_RATE`, which is minimised, is the rate
        times the last node [s], over `unit` [rad].
        """
        result = self._solve(_RATE)
        return np.inf if result is None else float(result.x[-1]) * self.unit / self.nodes[-1]

    @cached_property
    def _rows(self) -> tuple[Any, Any, Any]:
        """Rows that bound the values by the peak, the changes by the rate, and equations, sparse.

        Variables are the values at the nodes after the first, their changes up and down, and the
        bound, which is the peak, or the rate times the last time. The bounded rows must not be
        positive. The equations say that the changes are those of the values, and that the moments
        of the deflection, its integrals times the poles' exponentials, are the demands, each
        divided by the sum of its absolute moments.
        """
        from scipy import sparse  # late: it takes 0.1 s to import

        count = self.nodes.size - 1
        identity, none = sparse.identity(count), sparse.csr_matrix((count, count))
        peak, rate = np.ones((count, 1)), np.diff(self.nodes)[:, np.newaxis] / self.nodes[-1]
        sides = [sparse.hstack([sign * identity, none, none, -peak]) for sign in (1.0, -1.0)]
        by_rate = sparse.hstack([none, identity, identity, -rate])
        conditions = np.zeros((self.sizes.size, 3 * count + 1))
        conditions[:, :count] = self.moments[:, 1:] / self.sizes[:, np.newaxis]
        change = identity - sparse.eye(count, k=-1)
        motion = sparse.hstack([change, -identity, identity, sparse.csr_matrix((count, 1))])
        equal = sparse.vstack([motion, conditions])
        return sparse.vstack(sides).tocsr(), by_rate.tocsr(), equal.tocsr()

    def _solve(
        self,
        aim: str,
        peak: float = np.inf,
        around: FloatArray | None = None,
        max_change: float = np.inf,
    ) -> Any:
        """Return the result of minimum peak, rate or total motion (`aim`); None if infeasible.

        The variables, over `unit` [rad]: deflections at all nodes but the first; their changes up,
        and down, in each interval; and the peak, or for the minimum rate this rate times the last
        node [s]. `peak`: bound of that last variable. `around`: a solution to be corrected; the
        result is then the change from it times `_RESIDUAL_SCALE`, within `max_change`.
        """
        from scipy.optimize import linprog  # late: it takes 0.3 s to import

        count = self.nodes.size - 1
        by_peak, by_rate, equal = self._rows
        below = by_rate if aim == _RATE else by_peak
        # each condition is divided by the size of its row, the sum of its absolute moments
        demands = self.constraints.demands / self.sizes / self.unit
        right, upper = np.append(np.zeros(count), demands), np.zeros(below.shape[0])
        # bounds of the changes: `steps` of the rate limit, at most 1e6 units for numerical range
        steps = np.full(count, np.inf) if aim == _RATE else np.minimum(self.steps, 1e6)
        highest = np.concatenate([np.full(count, np.inf), steps, steps, [peak]])
        lowest = np.concatenate([np.full(count, -np.inf), np.zeros(2 * count + 1)])
        if around is not None:
            right = _RESIDUAL_SCALE * (right - equal @ around)
            upper = -_RESIDUAL_SCALE * (below @ around)
            lowest, highest = (
                np.clip(_RESIDUAL_SCALE * (b - around), -max_change, max_change)
                for b in (lowest, highest)
            )
        cost = np.zeros(3 * count + 1)  # of the changes, or of the last variable
        cost[slice(count, -1) if aim == _MOTION else -1] = 1.0
        for method in ("highs", "highs-ipm"):  # interior points where the simplex method fails
            result = linprog(
                cost, below, upper, equal, right, np.column_stack([lowest, highest]), method=method
            )
            if result.status == 0:
                return result
        return None


@dataclass(frozen=True, eq=False)
class RateLimitedOptimum(Shown):
    """The deflection of minimum peak under a rate limit.

    Attributes
    ----------
    peak : float
        Largest size of the deflection [rad].
    deflection : History
        The deflection [rad], linear between nodes, zero at the start; the last value stays
        constant, without end or to the horizon.
    rate : float
        Largest slope of the deflection [rad/s]; below the limit where that does not bind.
    unlimited_peak : float
        Peak [rad] without a rate limit, a lower bound.
    residual : float
        Largest violation of a condition (4b), relative to the sizes of its terms.
    change : float
        Decrease of the peak by the last refinement of the nodes, relative to it. The peak is an
        upper bound that falls towards the minimum.
    status : str
        "ok", or the reason why no deflection is required.
    """

    peak: float = field(metadata=spec("angle"))
    deflection: History
    rate: float = field(metadata=spec("angular rate"))
    unlimited_peak: float = field(metadata=spec("angle", document=False))
    residual: float = field(metadata=spec())
    change: float = field(metadata=spec(name="last_refinement", label="change"))
    status: str = field(metadata=spec())


def optimum_with_rate_limit(
    plant: Plant,
    wind: History,
    rate_limit: float,
    start: float = 0.0,
    horizon: float | None = None,
    steps: int = _STEPS,
) -> RateLimitedOptimum:
    """Return the deflection of minimum peak whose rate stays within a limit.

    Parameters
    ----------
    plant, wind, start, horizon
        Parameters of `optimum_deflection`. The deflection is zero at the start; with a horizon the
        last value is dropped there, whatever the rate.
    rate_limit : float
        Largest ``|delta'|`` [rad/s], positive.
    steps : int
        Number of pieces to begin with, at least 10.

    Raises
    ------
    InputError
        Where `optimum_deflection` raises it, and for a rate with which no deflection survives the
        wind; the message says which rate would do.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> wind = tv.TriangularWind(peak=-0.1, duration=7.5)
    >>> slow = tv.boundary.optimum_with_rate_limit(plant, wind, rate_limit=0.005)
    >>> round(slow.peak / tv.optimum_deflection(plant, wind).peak, 4)
    1.2836
    """
    rate = number("rate_limit", rate_limit, positive, "rad/s")
    number("rate_limit", rate, between(*RATE_RANGE), "rad/s")
    if not _MIN_STEPS <= whole_number("steps", steps) <= _MAX_STEPS:
        raise InputError(f"steps must be {_MIN_STEPS} to {_MAX_STEPS}; got {shown(steps)}")
    constraints = constraints_of(plant, wind, start, horizon)
    unlimited = optimum_under(constraints, float(start))
    if unlimited.peak == 0.0:
        status = NOT_EXCITED if constraints.demands.size else STABLE
        return RateLimitedOptimum(
            peak=0.0,
            deflection=unlimited.deflection,
            rate=0.0,
            unlimited_peak=0.0,
            residual=0.0,
            change=0.0,
            status=status,
        )
    # `peak` over the unlimited one; `change`: its decrease by the last refinement of the nodes
    program, peak, change = _refined(constraints, unlimited, start, rate, steps)
    # values at the nodes: of all deflections with this peak the one that moves least
    values = program.minimum_motion(peak * (1.0 + _RELATIVE_CHANGE)) if np.isfinite(peak) else None
    if values is None:
        sufficient = 1.001 * program.minimum_rate()  # as the smallest one takes an endless ramp
        raise InputError(
            "rate_limit is too small for any deflection to survive this wind; got"
            f" {np.degrees(rate):.4g} deg/s, and about {np.degrees(sufficient):.4g} deg/s"
            f" ({sufficient:.4g} rad/s) would do"
        )
    values *= unlimited.peak  # [rad]: the program has this peak for its unit
    slopes = np.diff(values) / np.diff(program.nodes)
    deflection: History = Piecewise(
        linear_pieces(program.nodes + start, values, np.append(slopes, 0.0))
    )
    if np.isfinite(constraints.horizon):
        deflection = deflection.before(constraints.horizon + start)
    return RateLimitedOptimum(
        peak=float(np.abs(values).max()),
        deflection=deflection,
        rate=float(np.abs(slopes).max()),
        unlimited_peak=unlimited.peak,
        residual=program.residual(values),
        change=change,
        status=OK,
    )


def minimum_peak_at_rate(
    constraints: Constraints, unlimited: Optimum, start: float, rate: float
) -> float:
    """Return the peak [rad] of `optimum_with_rate_limit`; infinite where no deflection survives.

    `constraints`, `unlimited`: conditions of the case, and its `optimum_deflection`, from `start`
    [s] on. `rate`: rate limit [rad/s]. The tolerance of a linear program, 1e-7 of the peak, is
    added to it.
    """
    # `peak`: over the peak without a rate limit, on nodes that are refined until it is constant
    _, peak, _ = _refined(constraints, unlimited, start, rate, _STEPS)
    return peak * unlimited.peak * (1.0 + _ACTIVE_DISTANCE)


def _refined(
    constraints: Constraints, unlimited: Optimum, start: float, rate: float, steps: int
) -> tuple[RateProgram, float, float]:
    """Return the program on nodes that are fine enough, its peak and the peak's last change.

    The peak is relative to the peak of `unlimited`, and infinite where the rate is too small; the
    change is its relative decrease by the last refinement of the nodes. `constraints`: conditions
    of the case. `unlimited`: deflection of minimum peak without a rate limit, from
    `start` [s] on. `rate`: limit [rad/s]. `steps`: intervals to begin with.
    """
    nodes = _first_nodes(constraints, unlimited.switch_times - start, steps)
    change, lowest = np.inf, np.inf
    best = program = RateProgram(constraints, nodes, rate=rate, unit=unlimited.peak)
    for _ in range(_REFINEMENTS):
        solution = program.minimum_peak()  # values at the nodes, and prices of the conditions
        if solution is None:
            break
        values, prices = solution
        peak = float(np.abs(values).max())
        change = lowest / peak - 1.0
        if peak < lowest:
            best, lowest = program, peak
        if change < _RELATIVE_CHANGE:
            break
        program = replace(program, nodes=_finer_nodes(program, values, prices))
    return best, lowest, max(change, 0.0)


def _first_nodes(constraints: Constraints, switches: FloatArray, steps: int) -> FloatArray:
    """Return nodes [s] after the start, close where e^(-p u) falls, of every pole p, and switches.

    Of an oscillating pole even nodes are added. `constraints`: conditions, one for each unstable
    pole, with its decay Re p. `switches`: times u [s] at which the deflection without a rate limit
    switches. `steps`: about the number of nodes.
    """
    last = min(constraints.horizon, _SPAN_OVER_TIME_CONSTANT / constraints.decays.min())
    nodes_per_pole = max(steps // constraints.poles.size, 8)
    parts = [np.array([0.0, last]), switches[switches < last]]
    for pole in constraints.poles:
        parts.append(decay_spaced_times(np.real(pole), last, nodes_per_pole))
        if np.imag(pole):
            parts.append(np.linspace(0.0, last, nodes_per_pole))
    gap = 1e-9 / np.abs(constraints.poles).max()  # [s]: nodes nearer than that are one
    return separate_nodes(np.minimum(np.concatenate(parts), last), gap)


def _finer_nodes(program: RateProgram, values: FloatArray, prices: FloatArray) -> FloatArray:
    """Return the nodes [s], with more in intervals that are neither at the peak nor at full rate.

    `program`: on the present nodes. `values`: its deflection over `unit` at them, ``(k,)``.
    `prices`: multipliers of the conditions, ``(n,)``: intervals in which these show that no
    improvement is possible are not split.
    """
    nodes, peak, slope = program.nodes, np.abs(values).max(), program.rate / program.unit
    at_peak = np.abs(values) > peak * (1.0 - _ACTIVE_DISTANCE)
    distance = _ACTIVE_DISTANCE * np.minimum(peak, program.steps)
    # intervals with the largest change (`steps`), and with the same peak at both ends; elsewhere a
    # finer deflection may be better
    at_full_rate = np.abs(np.diff(values)) > program.steps - distance
    constant = at_peak[:-1] & at_peak[1:] & (values[:-1] * values[1:] > 0.0)
    decays = program.constraints.decays[:, np.newaxis]
    # bound of what a change of the deflection in each interval gains, by the prices
    gains = np.abs(prices) @ np.exp(-decays * nodes[:-1]) * np.diff(nodes)
    split = np.flatnonzero(~(constant | at_full_rate) & (gains > _RELATIVE_CHANGE * gains.max()))
    split = split[np.argsort(-gains[split])[:_MAX_SPLIT_INTERVALS]]
    first, last = nodes[split], nodes[split + 1]
    new = [first + (last - first) * fraction for fraction in (0.25, 0.5, 0.75)]
    for level in (peak, -peak):  # where a line of full rate through an end comes to the peak
        new.append(first + np.abs(level - values[split]) / slope)
        new.append(last - np.abs(level - values[split + 1]) / slope)
    inside = [np.where((time > first) & (time < last), time, first) for time in new]
    fastest = np.abs(program.constraints.poles).max()
    gap = min(1e-6 / fastest, 1e-3 * peak / slope)  # [s]: nodes nearer than that are one
    return separate_nodes(np.concatenate([nodes, *inside]), gap)
