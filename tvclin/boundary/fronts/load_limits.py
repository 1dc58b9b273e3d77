"""Angle and load together: the least deflection over a bound of the structure's load.

The load is the angle of attack alpha, or alpha + M delta: the bending moment M_alpha alpha +
M_delta delta at a station over M_alpha, M = M_delta/M_alpha. The least deflection under
``|load| <= a`` is a convex problem, so that it is convex over a, and falls. Two floors make nearly
all of it: the least deflection d0 at any load, and, since nothing turns a vehicle faster than the
whole constant deflection,

    a >= sup_t (|alpha_0(t)| - d |G(t)|),

alpha_0 being the angle of attack without control and G the change by a constant unit deflection.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from tvclin.base.arrays import ComplexArray, FloatArray
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.fronts.load_record import PROVED
from tvclin.boundary.fronts.ramps import ramped_deflection
from tvclin.boundary.fronts.rates import rate_front
from tvclin.boundary.optimum.grid import apart
from tvclin.boundary.optimum.load_case import LoadCase
from tvclin.boundary.optimum.load_program import LOAD, PEAK, LoadProgram
from tvclin.boundary.optimum.minimum_peak import optimum_deflection
from tvclin.linear.deflections import ConstantDeflection
from tvclin.linear.modes import unstable_poles
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_responses
from tvclin.winds.histories import History, Piecewise, linear_pieces

_MAX_NODES = 1000
"""Largest number of nodes of a program that is refined."""
_EXCESS_FRACTIONS = (0.125, 0.25, 0.5, 1.0)
"""Fractions of the excess of the load, by which the next program's load bound is reduced."""
_PEAKS_OVER_PROOF = (1.1, 1.5, 3.0, 10.0)
"""Peaks, relative to the proved one, of programs of least load where no program has the load."""
_MIN_CELLS = 48
"""Smallest number of cells in the wind."""
_MAX_CELLS = 160
"""Largest number of cells in the wind."""
_CELLS_PER_TIME_CONSTANT = 10.0
"""Cells in the time constant of the fastest mode, between these numbers."""
_WIDTH_RATIO = 1.15
"""Width of each cell after the wind over that of the one before."""
_SPAN_OVER_TIME_CONSTANT = 20.0
"""Time of the last node after the wind, over the time constant of the slowest unstable mode."""
_MAX_DEFLECTION: float = float(np.pi / 2)
"""Largest deflection [rad] of the programs of least load."""
_NEGLIGIBLE_LOAD = 1e-9
"""Load, relative to that of the optimal deflection, below which it is zero."""
_LOAD_PROGRAMS = 5
"""Largest number of programs of the least load."""
_MIN_LOAD_DECREASE = 0.01
"""Smallest relative decrease of the load by a program after which another is solved."""
_NODES_PER_RADIAN = 3.5
"""Nodes in 1/omega of the oscillating zeros of the load."""
_MAX_ZERO_NODES = 300
"""Largest number of these nodes."""
_NEWTON_STEPS = 6
"""Largest number of Newton steps to the load at a limit."""
_MIN_START_LOAD = 0.02
"""Smallest load at which they begin, relative to that of the optimal deflection."""
_RELATIVE_TOLERANCE = 1e-3
"""Relative distance to a floor within which the floor sets a limit."""
ANGLE, TURN, BOTH = "the least angle", "turning in time", "both together"


@dataclass(frozen=True, eq=False)
class LoadLimits:
    """A case, with attained points (load, peak) of its front, and lines (bound, slope) below."""

    case: LoadCase
    least_deflection: float
    program: LoadProgram
    blind: float | None
    points: list[tuple[float, float]] = field(default_factory=list)
    lines: list[tuple[float, float]] = field(default_factory=list)

    @cached_property
    def dense(self) -> LoadProgram:
        """Program on nodes that resolve the oscillating zeros of the load as well."""
        nodes, zeros = self.program.nodes, _oscillating_zeros(self.case)
        if not zeros.size:
            return self.program
        span = nodes[-1] - nodes[0]
        wanted = span * float(np.abs(zeros).max()) * _NODES_PER_RADIAN
        more = np.linspace(nodes[0], nodes[-1], int(min(wanted, _MAX_ZERO_NODES)) + 2)
        return LoadProgram(
            self.case, apart(np.concatenate([nodes, more]), 1e-6 / self.case.fastest)
        )

    @cached_property
    def its_load(self) -> float:
        """Load [rad] of the reference deflection."""
        return float(np.abs(self.program.reference_load).max())

    @cached_property
    def least_load(self) -> float:
        """Least load [rad] of a computed control, at any deflection."""
        return self._minimum_load[0] if self._programmed else self.floor

    @cached_property
    def floor(self) -> float:
        """Proved lower bound [rad] of the load of every deflection; zero without one."""
        jumped = 0.0
        if self.case.ratio == 0.0:
            wind = self.case.wind
            knots = wind.knots
            jumps = np.abs(wind(knots) - wind(np.nextafter(knots, -np.inf)))
            jumped = float(np.max(jumps / np.where(knots <= wind.onset, 1.0, 2.0)))
        if not self._programmed:
            return jumped if jumped > _NEGLIGIBLE_LOAD * self.its_load else 0.0
        return max(jumped, self._minimum_load[1])

    @property
    def _programmed(self) -> bool:
        """Whether the least load exceeds that of a jump of the wind."""
        case = self.case
        return bool(case.ratio or np.isfinite(case.rate) or np.count_nonzero(case.unstable) > 1)

    @cached_property
    def _minimum_load(self) -> tuple[float, float]:
        """Least load [rad] of controls on successively finer nodes, and its lower bound [rad]."""
        loads, proved = [self.its_load], [0.0]
        program, lowest = self.dense, np.inf
        for _ in range(_LOAD_PROGRAMS):
            solved = program.solve(LOAD, _MAX_DEFLECTION)
            if solved is None:
                break
            self.points.append((solved.load, solved.peak))
            self.lines.append((solved.bound, solved.slope))
            if solved.slope > 0.0:
                proved.append((solved.bound - _MAX_DEFLECTION) / solved.slope)
            loads.append(solved.load)
            if solved.load > (1.0 - _MIN_LOAD_DECREASE) * lowest or solved.finer.size > _MAX_NODES:
                break
            lowest = min(lowest, solved.load)
            program = LoadProgram(self.case, solved.finer)
        return min(loads), max(proved)

    @property
    def stopped(self) -> float:
        """Smallest load [rad] if the wind stops at its peak: half a jump of that size."""
        half_jump = 0.0 if self.case.ratio else abs(float(self.case.wind.peak)) / 2.0
        return max(half_jump, self.floor)

    def all_at(self, loads: FloatArray) -> list[tuple[float, float, float]]:
        """Return limit, proof [rad] and slope at each load, the ends first and then in between."""
        results: dict[int, tuple[float, float, float]] = {}
        order = np.argsort(loads, kind="stable")
        pending = [(0, loads.size - 1)]
        for k in (0, loads.size - 1):
            results[int(order[k])] = self.at(float(loads[order[k]]))
        while pending:
            low, high = pending.pop(0)
            if high - low < 2:
                continue
            k = (low + high) // 2
            results[int(order[k])] = self.at(float(loads[order[k]]))
            pending += [(low, k), (k, high)]
        return [results[k] for k in range(loads.size)]

    def at(self, load: float) -> tuple[float, float, float]:
        """Return limit, proof [rad] and slope at a load [rad], with programs as required."""
        if load < self.floor:
            return np.inf, np.inf, np.nan
        for program in (self.program, self.dense):
            if self._refine(load, program) and np.isfinite(self._attained(load)):
                break
        for multiple in _PEAKS_OVER_PROOF:  # mixed with ones that have less load
            program = self.dense
            for _ in range(2):
                limit, (proof, _) = self._attained(load), self._proved(load)
                solved = (
                    program.solve(LOAD, min(multiple * proof, _MAX_DEFLECTION))
                    if np.isinf(limit)
                    else None
                )
                if solved is None:
                    break
                self.points.append((solved.load, solved.peak))
                program = LoadProgram(self.case, solved.finer)
        return self._attained(load), *self._proved(load)

    def _refine(self, load: float, program: LoadProgram) -> bool:
        """Add controls of about a load [rad] on finer nodes, and return whether they exist."""
        bound = load
        for fraction in _EXCESS_FRACTIONS:
            limit, (proof, _) = self._attained(load), self._proved(load)
            if limit - proof <= PROVED * proof:
                break
            solved = program.solve(PEAK, bound)
            if solved is None:
                return False
            self.points.append((solved.load, solved.peak))
            self.lines.append((solved.bound, solved.slope))
            if solved.finer.size > _MAX_NODES:
                break
            bound = load - fraction * max(solved.load - bound, 0.0)
            program = LoadProgram(self.case, solved.finer)
        return True

    def _attained(self, load: float) -> float:
        """Return the least peak [rad] of a mixture of computed controls, within a load [rad]."""
        below = [(a, d) for a, d in self.points if a <= load]
        above = [(a, d) for a, d in self.points if a > load]
        mixed = [d + (load - a) / (b - a) * (e - d) for a, d in below for b, e in above]
        return min([d for _, d in below] + mixed, default=np.inf)

    def _proved(self, load: float) -> tuple[float, float]:
        """Return the largest lower bound [rad] of the peak at a load [rad], and its slope."""
        bounds = [(bound - slope * load, slope) for bound, slope in self.lines]
        return max([*bounds, (self.least_deflection, 0.0)])

    def needed_load(self, limit: float) -> float:
        """Return the least load [rad] of a control within a limit [rad]; infinite without one."""
        if limit < self.least_deflection:
            return np.inf
        if limit >= self._attained(self.least_load):
            return self.least_load
        free, constant = self._responses
        low = max(float(np.max(np.abs(free) - limit * constant)), self.least_load)
        load = max(low, _MIN_START_LOAD * self.its_load)
        for _ in range(_NEWTON_STEPS):  # from below, along tangents
            _, proof, slope = self.at(load)
            if proof - limit <= PROVED * limit or not slope:
                break
            load += (proof - limit) / slope
        above = [(a, d) for a, d in self.points if d > limit]
        below = [(a, d) for a, d in self.points if d <= limit]
        mixed = [b + (limit - e) / (d - e) * (a - b) for a, d in above for b, e in below]
        return min([a for a, _ in below] + mixed, default=np.inf)

    def set_by(self, load: float, limit: float) -> str:
        """Return the label of the condition that sets a limit [rad] at a load [rad]."""
        for floor, words in ((self.least_deflection, ANGLE), (self._limit_of_turning(load), TURN)):
            if limit <= floor * (1.0 + _RELATIVE_TOLERANCE):
                return words
        return BOTH

    def _limit_of_turning(self, load: float) -> float:
        """Return the constant deflection [rad] that turns the vehicle into the wind in time."""
        if self.case.ratio or np.isfinite(self.case.rate):
            return 0.0
        free, constant = self._responses
        return float(np.max((np.abs(free) - load) / constant, initial=0.0))

    @cached_property
    def _responses(self) -> tuple[FloatArray, FloatArray]:
        """Angle of attack [rad] without control, and its largest change by a unit deflection."""
        case, start = self.case, float(self.case.wind.onset)
        times = np.linspace(start, float(case.wind.end), 1001)[1:]
        none = Piecewise(linear_pieces([start], [0.0], 0.0))
        name = "angle_of_attack"
        free = attitude_responses(case.plant, none, case.wind, times, [name])[name]
        unit = ConstantDeflection(limit=1.0, start=start)
        change = attitude_responses(case.plant, unit, 0.0 * case.wind, times, [name])[name]
        size = np.maximum.accumulate(np.abs(change))
        return free, np.where(size > 0.0, size, np.inf)

    def unforeseen(self, loads: FloatArray, proofs: FloatArray) -> FloatArray:
        """Return lower bounds [rad] of every law that does not know when the wind will stop."""
        assert self.blind is not None
        return np.where(loads < self.stopped, np.inf, np.maximum(proofs, self.blind))


def limits_of(plant: Plant, wind: History, ratio: float, rate: float) -> LoadLimits:
    """Return a case of `load_front` with its bounds; `ratio` is M, `rate` the limit [rad/s]."""
    start = float(wind.onset) if isinstance(wind, History) and not wind.batch else 0.0
    optimum = optimum_deflection(plant, wind, start if np.isfinite(start) else 0.0)
    case = LoadCase(plant, wind, optimum.deflection, ratio, rate)
    poles = unstable_poles(plant)
    blind = 0.0 if wind.constant_sign else None
    if wind.constant_sign and poles.size and not np.imag(poles[0]):
        blind = abs(float(forecast_free_limit(plant, wind).deflection))
    least_deflection = optimum.certificate.dual
    if np.isfinite(rate):
        slow = rate_front(plant, wind, [rate], rate_limit=rate)
        least_deflection = float(slow.limits[0])
        if blind:
            blind = float(ramped_deflection(blind, float(np.real(poles[0])), rate))
    limits = LoadLimits(case, least_deflection, LoadProgram(case, _nodes(case)), blind)
    if np.isinf(rate):
        limits.points.append((limits.its_load, optimum.peak))
    return limits


def _nodes(case: LoadCase) -> FloatArray:
    """Return nodes [s], even in the wind and in growing steps after it, with all breakpoints."""
    wind, unstable = case.wind, case.poles[case.unstable]
    start, end = float(wind.onset), float(wind.end)
    length = end - start
    count = int(np.clip(_CELLS_PER_TIME_CONSTANT * case.fastest * length, _MIN_CELLS, _MAX_CELLS))
    width = length / count
    slowest = float(unstable.real.min()) if unstable.size else case.fastest
    last = end + _SPAN_OVER_TIME_CONSTANT / slowest
    steps = np.arange(
        1, int(np.log1p((last - end) * (_WIDTH_RATIO - 1.0) / width) / np.log(_WIDTH_RATIO)) + 2
    )
    after = end + width * (_WIDTH_RATIO**steps - 1.0) / (_WIDTH_RATIO - 1.0)
    parts = [np.linspace(start, end, count + 1), after, wind.knots, case.reference.knots]
    if np.any(unstable.imag):
        parts.append(np.linspace(end, last, int((last - end) * unstable.imag.max()) + 2))
    nodes = np.concatenate(parts)
    return apart(nodes[(nodes >= start) & (nodes <= after[-1])], 1e-6 / case.fastest)


def _oscillating_zeros(case: LoadCase) -> ComplexArray:
    """Return the complex zeros [1/s] from deflection to load, where a control has no load."""
    A, B, C, D = case.plant.matrices()
    through = D[-1, 0] + case.ratio
    if through == 0.0:
        return np.zeros(0, complex)
    zeros = np.linalg.eigvals(A - np.outer(B[:, 0], C[-1]) / through)
    return np.asarray(zeros[zeros.imag > 0.0], dtype=complex)
