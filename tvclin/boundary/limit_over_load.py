"""Trade-off of angle and load: the minimum deflection limit over a bound of the structure's load.

The load is the angle of attack alpha, or alpha + M delta: the bending moment M_alpha alpha +
M_delta delta at a station over M_alpha, M = M_delta/M_alpha. The minimum deflection under
``|load| <= a`` is a convex problem, so that it is convex over a, and falls. Two floors make nearly
all of it: the minimum deflection d0 at any load, and, since nothing turns a vehicle faster than the
whole constant deflection,

    a >= sup_t (|alpha_0(t)| - d |G(t)|),

alpha_0 being the angle of attack without control and G the change by a constant unit deflection.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.fields import array_table, derived, spec
from tvclin.base.lines import NONE_SUFFICIENT, Table
from tvclin.base.quantities import FORECAST_FREE, NO_FORECAST, WIND_KNOWN, sufficiency
from tvclin.boundary.limit_over_rate import (
    TradeOff,
    lower_bound_text,
    no_forecast_deflection,
    point_table,
    ramped_deflection,
    rate_trade_off,
)
from tvclin.boundary.optimum.load_case import LoadCase
from tvclin.boundary.optimum.load_program import LOAD, PEAK, LoadProgram
from tvclin.boundary.optimum.minimum_peak import optimum_deflection
from tvclin.boundary.optimum.moments import separate_nodes
from tvclin.boundary.optimum.rate_limit import RATE_RANGE
from tvclin.linear.deflections import ConstantDeflection
from tvclin.linear.modes import unstable_poles
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_responses
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import linear_notes

RELATIVE_GAP = 1e-4
"""Relative gap between a limit and its lower bound at which a program is not refined."""
_MAX_NODES = 1000
"""Largest number of nodes of a program that is refined."""
_EXCESS_FRACTIONS = (0.125, 0.25, 0.5, 1.0)
"""Fractions of the excess of the load, by which the next program's load bound is reduced."""
_PEAKS_OVER_PROOF = (1.1, 1.5, 3.0, 10.0)
"""Peaks, relative to the proved one, of programs of minimum load where no program has the load."""
_MIN_CELLS, _MAX_CELLS = 48, 160
"""Smallest and largest number of cells in the wind."""
_CELLS_PER_TIME_CONSTANT = 10.0
"""Cells in the time constant of the fastest mode, between these numbers."""
_WIDTH_RATIO = 1.15
"""Ratio of the widths of neighbouring cells after the wind, later over earlier."""
_SPAN_OVER_TIME_CONSTANT = 20.0
"""Time of the last node after the wind, over the time constant of the slowest unstable mode."""
_MAX_DEFLECTION: float = float(np.pi / 2)
"""Largest deflection [rad] of the programs of minimum load."""
_NEGLIGIBLE_LOAD = 1e-9
"""Load, relative to the optimal deflection, below which it is zero."""
_MIN_LOAD_DECREASE = 0.01
"""Smallest relative decrease of the load by a program after which another is solved."""
_NODES_PER_RADIAN = 3.5
"""Nodes in 1/omega of the oscillating zeros of the load."""
_MAX_ZERO_NODES = 300
"""Largest number of these nodes."""
_MIN_START_LOAD = 0.02
"""Smallest load at which they begin, relative to the optimal deflection."""
_RELATIVE_TOLERANCE = 1e-3
"""Relative distance to a floor within which the floor sets a limit."""
ANGLE, TURN, BOTH = "the minimum angle", "turning in time", "both together"
LEAST_LOAD = "the minimum load"
_MIN_MOMENT_RATIO = 1e-12
"""Smallest size of a moment ratio other than zero, for numerical range."""


@dataclass(frozen=True, eq=False)
class LoadTradeOff(TradeOff):
    """The minimum deflection over a load bound, for one plant in one wind.

    Attributes
    ----------
    loads : ndarray
        Bounds of the load [rad], ``(n,)``.
    limits : ndarray
        Deflection limit [rad] with which a control that knows the wind stays within each load,
        ``(n,)``; infinite where no angle is sufficient.
    lower_bounds : ndarray
        Lower bound [rad] of that limit, ``(n,)``: the minimum is between the two.
    slopes : ndarray
        Decrease of the deflection with the load bound, ``(n,)``: its reciprocal is the decrease of
        the load for a degree of the nozzle.
    set_by : tuple of str
        Condition that sets each limit: the minimum angle, turning in time into the wind, or both
        together; the minimum load where no angle is sufficient.
    no_forecast_bounds : ndarray or None
        Lower bound [rad] of laws that survive if the wind stops for good at any instant,
        ``(n,)``; None for a wind that changes its sign.
    minimum_deflection, load_of_minimum : float
        Minimum deflection [rad] without a load limit, and the load [rad] of its control.
    minimum_load, no_forecast_load : float
        Minimum load [rad] of a computed control at any deflection, and a lower bound [rad] of the
        load without a forecast.
    moment_ratio, rate_limit : float
        M, and the rate limit [rad/s]; infinite if none.
    limit, load : float or None
        Limit of the nozzle and load limit of the structure [rad].
    lower_bound : float
        Required limit [rad] at that load limit, or without one.
    required_load : float
        Minimum load [rad] of a control with that limit, or with any; infinite without one.
    angle : float
        Largest wind angle [rad]. Above 30 deg the trade-off holds for the linear equations only,
        and the lower bound is NaN.
    """

    loads: FloatArray = field(metadata=spec("angle", "load", card=False))
    limits: FloatArray = field(
        metadata=spec("angle", WIND_KNOWN, infinite=NONE_SUFFICIENT, card=False)
    )
    lower_bounds: FloatArray = field(metadata=spec("angle", card=False))
    slopes: FloatArray = field(metadata=spec(card=False))
    set_by: tuple[str, ...] = field(metadata=spec(card=False))
    no_forecast_bounds: FloatArray | None = field(
        metadata=spec("angle", NO_FORECAST, infinite=NONE_SUFFICIENT, card=False)
    )
    minimum_deflection: float = field(metadata=spec("angle"))
    load_of_minimum: float = field(metadata=spec("angle", card=False))
    minimum_load: float = field(metadata=spec("angle"))
    no_forecast_load: float = field(metadata=spec("angle", card=False))
    moment_ratio: float = field(metadata=spec(card=False))
    rate_limit: float = field(metadata=spec("angular rate", card=False))
    limit: float | None = field(metadata=spec("angle"))
    load: float | None = field(metadata=spec("angle"))
    lower_bound: float = field(metadata=spec("angle", infinite=NONE_SUFFICIENT))
    required_load: float = field(metadata=spec("angle", infinite=NONE_SUFFICIENT))
    angle: float = 0.0

    @property
    @derived("degrees", label="a degree buys", digits=2, card=False, document=False)
    def load_per_degree(self) -> FloatArray:
        """Decrease of the load per increase of the limit at n loads; NaN where it has none."""
        return 1.0 / np.where(self.slopes > 0.0, self.slopes, np.nan)

    @property
    @derived("angle", infinite="-", card=False)
    def remaining_load(self) -> float | None:
        """Remaining load [rad]: the structure's limit minus the required load."""
        return None if self.load is None else self.load - self.required_load

    @property
    @derived()
    def above_lower_bound(self) -> bool | None:
        """Whether the limit is on the trade-off with the wind known, or above.

        It is between `_proved`, a bound of every control, and `lower_bound`, the peak of one. None
        for a limit between these, and without a limit unless no limit is sufficient.
        """
        if self.beyond_linear:
            return None
        if self.limit is None:
            return False if np.isinf(self._proved) else None
        if self.limit >= self.lower_bound:
            return True
        return None if self._proved <= self.limit else False

    @property
    def _proved(self) -> float:
        """Proved lower bound [rad] of the limit of controls within the load limit `load`.

        For a load that is not limited, or not in `loads`, it is the limit `lower_bound`.
        """
        at = np.flatnonzero(self.loads == self.load)
        return float(self.lower_bounds[at[0]]) if at.size else self.lower_bound

    @property
    def requires_forecast(self) -> bool:
        """Whether a law that must survive a stop of the wind at any time exceeds the load limit."""
        return self.load is not None and self.load < self.no_forecast_load

    @property
    def bound_text(self) -> str:
        """The lower bound of the limit within the load, in words."""
        load = "" if self.load is None else " within this load"
        return lower_bound_text(WIND_KNOWN, self._proved, load)

    @property
    def verdict(self) -> str:
        """Why the limit is not sufficient or not known to be, in words; empty otherwise."""
        if self.beyond_linear:
            return f"{sufficiency(None)}: {self.beyond_linear}"
        if self.above_lower_bound is False:
            return f"{sufficiency(False)}, below the {WIND_KNOWN}"
        if self.above_lower_bound is None and self.limit is not None:
            low, high = np.degrees([self._proved, self.lower_bound])  # proved, of a control
            between = f"between {low:.4g} and {high:.4g}" if high < 90.0 else f"above {low:.4g}"
            return f"{sufficiency(None)}: the lower bound is {between} deg"
        return ""

    def tables(self) -> tuple[Table, ...]:
        """Return the tables of the trade-off, and of the nozzle's point with the requirement."""
        return (
            array_table(
                "Lower bounds of the limit over the largest load",
                "trade_off",
                self,
                *("loads", "limits", "load_per_degree", "no_forecast_bounds", "set_by"),
            ),
            point_table(
                "Both at once: the limit at that load, the load at that limit",
                self,
                ("lower_bound", "limit", "remaining"),
                ("required_load", "load", "remaining_load"),
            ),
        )

    @property
    def notes(self) -> Iterator[str]:
        """Return the notes on the trade-off, a sentence each: load, forecast and proved gap."""
        yield from linear_notes(self.angle)
        what = "the angle of attack" if self.moment_ratio == 0.0 else "alpha + M delta, as an angle"
        yield f"the load is {what}, during the wind and after it"
        if self.no_forecast_bounds is None:
            yield f"the wind changes its sign: there is no {NO_FORECAST}"
        elif np.isfinite(self.no_forecast_load) and self.no_forecast_load > 0.0:
            load_deg = np.degrees(self.no_forecast_load)
            more = ", more than this load" * self.requires_forecast
            yield f"a {FORECAST_FREE} bears {load_deg:.4g} deg at least{more}"
        if np.any(self.limits > self.lower_bounds * (1.0 + 2.0 * RELATIVE_GAP)):
            gaps = 1.0 - self.lower_bounds / np.maximum(self.limits, 1e-300)  # not zero
            worst, at = np.max(gaps), np.degrees(self.loads[np.argmax(gaps)])
            percent = f"{100.0 * worst:.2g} percent"
            yield f"the limits are proved to {percent}, that at {at:.4g} deg least"


@dataclass(frozen=True, eq=False)
class LoadLimits:
    """A case, with points (load, peak) [rad] that are attained, and lines (bound, slope) below.

    The peak is the largest deflection, and the load the largest ``|alpha + M delta|`` under it; the
    minimum peak is convex over the load. `case`: plant and wind with M (`ratio`), rate limit, and
    the deflection of minimum peak without a load limit, the `reference`. `minimum_deflection`: the
    peak's lower bound [rad] then. `program`: linear program on the first nodes. `no_forecast`:
    lower bound [rad] without a forecast, or None. A line says that no deflection has a peak below
    bound - slope load.
    """

    case: LoadCase
    minimum_deflection: float
    program: LoadProgram
    no_forecast: float | None
    points: list[tuple[float, float]] = field(default_factory=list)
    lines: list[tuple[float, float]] = field(default_factory=list)

    @cached_property
    def dense_program(self) -> LoadProgram:
        """Linear program on nodes that resolve the oscillating deflection which keeps load zero."""
        nodes, zeros = self.program.nodes, self.case.oscillating_zeros
        if not zeros.size:
            return self.program
        span = nodes[-1] - nodes[0]
        wanted = span * float(np.abs(zeros).max()) * _NODES_PER_RADIAN
        more = np.linspace(nodes[0], nodes[-1], int(min(wanted, _MAX_ZERO_NODES)) + 2)
        gap = 1e-6 / self.case.fastest  # [s]: nodes nearer than that are one
        return LoadProgram(self.case, separate_nodes(np.concatenate([nodes, more]), gap))

    @cached_property
    def load_of_minimum(self) -> float:
        """Load [rad] of the reference deflection, of minimum peak without a load limit."""
        return float(np.abs(self.program.reference_load).max())

    @property
    def minimum_load(self) -> float:
        """Minimum load |alpha + M delta| [rad], M as in `LoadCase`, of computed controls.

        The deflection is not bounded.
        """
        return self._minimum_loads[0]

    @property
    def load_floor(self) -> float:
        """Proved lower bound [rad] of the load |alpha + M delta| of every control; zero if none."""
        return self._minimum_loads[1]

    @cached_property
    def _minimum_loads(self) -> tuple[float, float]:
        """Minimum load |alpha + M delta| [rad], as computed, and its proved lower bound.

        With M (`case.ratio`) zero the load is the angle of attack, which jumps with the wind: a
        load before the jump may halve it, except at the onset. Without a rate limit and with a
        single unstable mode that is the minimum. Else it takes up to five linear programs, each of
        finer nodes in time. By duality each proves that every control has peak >= bound - slope
        load (`lines`): a load bound for peaks up to `_MAX_DEFLECTION`.
        """
        case, jumped = self.case, 0.0
        if case.ratio == 0.0:
            wind, knots = case.wind, case.wind.knots
            jumps = np.abs(wind(knots) - wind(np.nextafter(knots, -np.inf)))
            jumped = float(np.max(jumps / np.where(knots <= wind.onset, 1.0, 2.0)))
            if np.isinf(case.rate) and np.count_nonzero(case.unstable) <= 1:
                jumped = jumped if jumped > _NEGLIGIBLE_LOAD * self.load_of_minimum else 0.0
                return jumped, jumped
        loads, proved = [self.load_of_minimum], [jumped]
        program, lowest = self.dense_program, np.inf
        for _ in range(5):
            if (solved := program.solve(LOAD, _MAX_DEFLECTION)) is None:
                break
            self.points.append((solved.load, solved.peak))
            self.lines.append((solved.bound, solved.slope))
            if solved.slope > 0.0:
                proved.append((solved.bound - _MAX_DEFLECTION) / solved.slope)
            loads.append(solved.load)
            if solved.load > (1.0 - _MIN_LOAD_DECREASE) * lowest or solved.finer.size > _MAX_NODES:
                break
            lowest = min(lowest, solved.load)
            program = LoadProgram(case, solved.finer)
        floor = max(proved)
        return max(min(loads), floor), floor  # rounding is not below the floor

    @property
    def no_forecast_load(self) -> float:
        """Smallest load [rad] if the wind stops at its peak: half a jump of that size."""
        # with M a deflection can jump with the wind and take part of the load
        half_jump = 0.0 if self.case.ratio else abs(float(self.case.wind.peak)) / 2.0
        return max(half_jump, self.load_floor)

    def points_at(self, loads: FloatArray) -> list[tuple[float, float, float]]:
        """Return limit [rad], lower bound [rad] and slope at each of `loads` [rad], in their order.

        For the slope see `at`. The outer loads are computed first, then those in the middle of
        computed ones: mixtures of their controls often suffice for the loads between.
        """
        order, pending = np.argsort(loads, kind="stable"), [(0, loads.size - 1)]
        positions = [0, loads.size - 1]
        for low, high in pending:  # pairs of computed loads; halves are appended
            if high - low > 1:
                middle = (low + high) // 2
                positions.append(middle)
                pending += [(low, middle), (middle, high)]
        results = {int(order[k]): self.at(float(loads[order[k]])) for k in positions}
        return [results[k] for k in range(loads.size)]

    def at(self, load: float) -> tuple[float, float, float]:
        """Return limit [rad], its lower bound [rad] and slope at a load bound `load` [rad].

        The slope is the decrease of the lower bound per load. Programs on finer nodes add controls,
        (load, peak) in `points`, until the gap is small. The limit is the peak of a weighted mean
        of two of these, with more and with less load; infinite without one with less.
        """
        if load < self.load_floor:
            return np.inf, np.inf, np.nan
        for program in (self.program, self.dense_program):
            if self._refine(load, program) and np.isfinite(self._attained(load)):
                break
        # without a control of less load: of minimum load, with peaks up to multiples of the bound
        for multiple in _PEAKS_OVER_PROOF:
            program = self.dense_program
            for _ in range(2):
                if np.isfinite(self._attained(load)):
                    break
                proof, _ = self._proved(load)
                peak = min(multiple * proof, _MAX_DEFLECTION)
                if (solved := program.solve(LOAD, peak)) is None:
                    break
                self.points.append((solved.load, solved.peak))
                program = LoadProgram(self.case, solved.finer)
        return self._attained(load), *self._proved(load)

    def _refine(self, load: float, program: LoadProgram) -> bool:
        """Add controls of about a `load` [rad], from a `program` on; return whether they exist.

        Each solved program adds a point (load, peak) that its control attains, and a line below all
        peaks, and the next one is solved on its finer nodes, until the gap at `load` is small.
        Between its nodes a control exceeds the bound; the next is lower by a fraction of that.
        """
        bound = load
        for fraction in _EXCESS_FRACTIONS:
            limit, (proof, _) = self._attained(load), self._proved(load)
            if limit - proof <= RELATIVE_GAP * proof:
                break
            if (solved := program.solve(PEAK, bound)) is None:
                return False
            self.points.append((solved.load, solved.peak))
            self.lines.append((solved.bound, solved.slope))
            if solved.finer.size > _MAX_NODES:
                break
            bound = load - fraction * max(solved.load - bound, 0.0)
            program = LoadProgram(self.case, solved.finer)
        return True

    def _attained(self, load: float) -> float:
        """Return the minimum peak [rad] of a mixture of computed controls, within a load [rad].

        `points`: loads and peaks of the controls. One with more load and one with less are mixed
        linearly, as load and peak are convex in the deflection; infinite without one with less.
        """
        below = [point for point in self.points if point[0] <= load]
        above = [point for point in self.points if point[0] > load]
        mixed = [
            low_peak + (load - low_load) / (high_load - low_load) * (high_peak - low_peak)
            for low_load, low_peak in below
            for high_load, high_peak in above
        ]
        return min([peak for _, peak in below] + mixed, default=np.inf)

    def _proved(self, load: float) -> tuple[float, float]:
        """Return the largest lower bound [rad] of the peak at a load [rad], and its slope.

        The slope is the decrease of the bound per load. `lines` has bounds at load zero with their
        slopes; the minimum without a bound of the load has slope zero.
        """
        bounds = [(bound - slope * load, slope) for bound, slope in self.lines]
        return max([*bounds, (self.minimum_deflection, 0.0)])

    def required_load(self, limit: float | None) -> float:
        """Return the minimum load [rad] of a control within a limit [rad]; inf if there is none.

        None is no limit. The load is the angle of attack alpha, or alpha + M delta (M, `ratio` of
        the case). It is the smallest of controls, computed or mixed of two, within the limit.
        """
        if limit is not None and limit < self.minimum_deflection:
            return np.inf
        if limit is None or limit >= self._attained(self.minimum_load):
            return self.minimum_load
        free, constant = self._responses  # alpha without control; its change by unit deflection
        low = max(float(np.max(np.abs(free) - limit * constant)), self.minimum_load)
        load = max(low, _MIN_START_LOAD * self.load_of_minimum)
        for _ in range(6):  # Newton steps from below, along tangents of the lower bound `proof`
            _, proof, slope = self.at(load)  # adds the controls that it computes to `points`
            if proof - limit <= RELATIVE_GAP * limit or not slope:
                break
            load += (proof - limit) / slope
        # mixtures of controls with loads a, b and peaks d, e, above and within the limit
        above = [(a, d) for a, d in self.points if d > limit]
        below = [(a, d) for a, d in self.points if d <= limit]
        mixed = [b + (limit - e) / (d - e) * (a - b) for a, d in above for b, e in below]
        return min([a for a, _ in below] + mixed, default=np.inf)

    def set_by(self, load: float, limit: float) -> str:
        """Return the label of the condition that sets a `limit` [rad] at a bound `load` [rad].

        One of the minimum angle at any load, turning into the wind in time, and both together; or
        the minimum load, where no limit is sufficient. Turning alone is judged where the load is
        the angle of attack (M, `case.ratio`, the load per deflection, is zero) without rate limit.
        """
        if load < self.load_floor:
            return LEAST_LOAD
        floors = {ANGLE: self.minimum_deflection}
        if not self.case.ratio and np.isinf(self.case.rate):
            # without M the load is the angle of attack: a constant deflection must reduce it
            free, change_per_deflection = self._responses
            floors[TURN] = float(((np.abs(free) - load) / change_per_deflection).max(initial=0.0))
        labels = (k for k, floor in floors.items() if limit <= floor * (1.0 + _RELATIVE_TOLERANCE))
        return next(labels, BOTH)

    @cached_property
    def _responses(self) -> tuple[FloatArray, FloatArray]:
        """Angle of attack [rad] without control, and its largest change by a unit deflection.

        Both at 1000 times in the wind, ``(1000,)``. The change [rad/rad] is the largest up to each
        time by a constant deflection from the onset on; infinite where it is zero, since loads are
        divided by it.
        """
        case, start = self.case, float(self.case.wind.onset)
        times = np.linspace(start, float(case.wind.end), 1001)[1:]
        unit, calm = ConstantDeflection(limit=1.0, start=start), 0.0 * case.wind
        name = "angle_of_attack"
        free = attitude_responses(case.plant, calm, case.wind, times, [name])[name]
        change = attitude_responses(case.plant, unit, calm, times, [name])[name]
        size = np.maximum.accumulate(np.abs(change))
        return free, np.where(size > 0.0, size, np.inf)


def load_limits(plant: Plant, wind: History, ratio: float, rate: float) -> LoadLimits:
    """Return the points and bounds of `load_trade_off` before any linear program is solved.

    They are the minimum deflection without a load limit and, if no rate limit is given, the point
    (load, peak) [rad] of its control. `plant`, `wind`: one each. `ratio`: M of alpha + M delta.
    `rate`: rate limit [rad/s] or infinite; `InputError` where no deflection survives with it.
    """
    # what is no single wind with an onset is refused by `optimum_deflection`
    start = float(wind.onset) if isinstance(wind, History) and not wind.batch else 0.0
    optimum = optimum_deflection(plant, wind, start if np.isfinite(start) else 0.0)
    case = LoadCase(plant, wind, reference=optimum.deflection, ratio=ratio, rate=rate)
    no_forecast = no_forecast_deflection(plant, wind)
    minimum_deflection = optimum.certificate.dual  # proved bound [rad], just below the peak
    if np.isfinite(rate):
        slow = rate_trade_off(plant, wind, [rate], rate_limit=rate)
        minimum_deflection = float(slow.limits[0])  # at this one rate
        if np.isinf(minimum_deflection):
            least = slow.minimum_rate
            raise errors.InputError(
                "rate_limit is too small for any deflection to survive this wind; got"
                f" {np.degrees(rate):.4g} deg/s, and more than {np.degrees(least):.6g} deg/s"
                f" ({least:.6g} rad/s) is required"
            )
        if no_forecast:  # a ramp of that rate must go to a larger deflection
            pole = float(np.real(unstable_poles(plant)[0]))
            no_forecast = float(ramped_deflection(no_forecast, pole, rate))
    limits = LoadLimits(case, minimum_deflection, LoadProgram(case, _nodes(case)), no_forecast)
    if np.isinf(rate):
        limits.points.append((limits.load_of_minimum, optimum.peak))
    return limits


def _nodes(case: LoadCase) -> FloatArray:
    """Return nodes [s] of a `case`, even in the wind and in growing steps after it.

    They hold the breakpoints of wind and reference deflection, and resolve unstable oscillation.
    """
    wind, unstable = case.wind, case.poles[case.unstable]
    start, end = float(wind.onset), float(wind.end)
    cells = _CELLS_PER_TIME_CONSTANT * case.fastest * (end - start)
    count = int(np.clip(cells, _MIN_CELLS, _MAX_CELLS))
    width = (end - start) / count
    slowest = float(unstable.real.min()) if unstable.size else case.fastest
    last = end + _SPAN_OVER_TIME_CONSTANT / slowest
    # sums of a geometric series of widths, up to the last node
    steps = np.arange(
        1, int(np.log1p((last - end) * (_WIDTH_RATIO - 1.0) / width) / np.log(_WIDTH_RATIO)) + 2
    )
    after = end + width * (_WIDTH_RATIO**steps - 1.0) / (_WIDTH_RATIO - 1.0)
    parts = [np.linspace(start, end, count + 1), after, wind.knots, case.reference.knots]
    if np.any(unstable.imag):  # a node for each radian
        parts.append(np.linspace(end, last, int((last - end) * unstable.imag.max()) + 2))
    nodes = np.concatenate(parts)
    return separate_nodes(nodes[(nodes >= start) & (nodes <= after[-1])], 1e-6 / case.fastest)


def load_trade_off(
    plant: Plant,
    wind: History,
    loads: ArrayLike | None = None,
    *,
    limit: float | None = None,
    load: float | None = None,
    rate_limit: float = np.inf,
    moment_ratio: float = 0.0,
) -> LoadTradeOff:
    """Return the minimum deflection over the largest load, from the onset of the wind on.

    Parameters
    ----------
    plant : Plant
        One plant.
    wind : History
        One wind that ends, known beforehand.
    loads : array_like, optional
        Bounds of the load [rad], ``(n,)``; by default ten from near the minimum load up to the load
        of the control of minimum deflection, and `load`.
    limit, load : float, optional
        Limit of the nozzle and load limit of the structure [rad].
    rate_limit : float
        Largest deflection rate [rad/s]; none by default.
    moment_ratio : float
        M: the load is alpha + M delta. Of a bending moment M_alpha alpha + M_delta delta it is
        M_delta/M_alpha, and the bounds are of the moment over M_alpha.

    Returns
    -------
    LoadTradeOff
        Each limit is the peak of a computed deflection, whose load is within the bound throughout.
        Its lower bound, by multipliers of the program, is within 1e-4, or a note says more.

    Raises
    ------
    InputError
        Where `optimum_deflection` or, with a rate limit, `rate_trade_off` raises it; for loads that
        are not positive, and a rate limit with which no deflection is sufficient.

    Notes
    -----
    Without a limit of the deflection the minimum load of a wind without jumps is zero; a jump at
    the onset leaves its size, a later one half of it. A wind that may stop at its peak is such a
    jump: half of it is the minimum load of a law that must survive that. With a rate limit or M a
    computed control has the minimum load; its lower bound may be less.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> wind = tv.TriangularWind(peak=np.radians(5), duration=7.5)
    >>> front = tv.boundary.load_trade_off(plant, wind, np.radians([4.0, 2.5, 1.5]))
    >>> np.degrees(front.limits).round(3).tolist()
    [0.199, 0.258, 0.308]
    """
    load_check = errors.small_angle("a load", errors.positive)
    limit_check = errors.small_angle("a limit", errors.positive)
    nozzle_limit = None if limit is None else errors.number("limit", limit, limit_check, "rad")
    load_limit = None if load is None else errors.number("load", load, load_check, "rad")
    M = errors.number("moment_ratio", moment_ratio, errors.finite)
    if 0.0 < abs(M) < _MIN_MOMENT_RATIO:
        raise errors.InputError(
            f"moment_ratio must be zero or at least {_MIN_MOMENT_RATIO:g}; got {M:.6g}"
        )
    rate = errors.unlimited("rate_limit", rate_limit, errors.between(*RATE_RANGE), "rad/s")
    if loads is not None:
        load_bounds = load_check("loads", errors.one_row("loads", loads, "rad"), "rad")
    case = load_limits(plant, wind, M, rate)
    if loads is None:
        low, high = max(1.05 * case.minimum_load, 0.2 * case.load_of_minimum), case.load_of_minimum
        load_bounds = np.linspace(min(low, high), high, 10)
        if load_limit is not None:
            load_bounds = np.unique(np.append(load_bounds, load_limit))
    limits, lower_bounds, slopes = np.array(case.points_at(load_bounds)).T
    no_forecast, bounds = case.no_forecast, None
    if no_forecast is not None:  # below the least load without a forecast no limit is sufficient
        bounds = np.maximum(lower_bounds, no_forecast)
        bounds[load_bounds < case.no_forecast_load] = np.inf
    front = LoadTradeOff(
        loads=load_bounds,
        limits=limits,
        lower_bounds=lower_bounds,
        slopes=slopes,
        set_by=tuple(map(case.set_by, load_bounds, limits)),
        no_forecast_bounds=bounds,
        minimum_deflection=case.minimum_deflection,
        load_of_minimum=case.load_of_minimum,
        minimum_load=case.minimum_load,
        no_forecast_load=np.nan if no_forecast is None else case.no_forecast_load,
        moment_ratio=M,
        rate_limit=rate,
        limit=nozzle_limit,
        load=load_limit,
        lower_bound=case.minimum_deflection if load_limit is None else case.at(load_limit)[0],
        required_load=case.required_load(nozzle_limit),
        angle=abs(float(wind.peak)),
    )
    if front.beyond_linear:
        return replace(front, lower_bound=np.nan, required_load=np.nan)
    return front
