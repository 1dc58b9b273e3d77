"""Angle and load together: the least deflection over a bound on what the structure feels.

The load is the angle of attack alpha, or alpha + M delta: the bending moment M_alpha alpha +
M_delta delta at a station over M_alpha, M = M_delta/M_alpha. The least deflection under
``|load| <= a`` is a convex problem, so that it is convex over a, and falls. Two floors make nearly
all of it: the least deflection d0 at any load, and, since nothing turns a vehicle faster than the
whole deflection, held,

    a >= sup_t (|alpha_0(t)| - d |G(t)|),

alpha_0 being the angle of attack without control and G what a held deflection of one adds.
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

_MOST_NODES = 1000
_AIMED, _BEYOND = (0.125, 0.25, 0.5, 1.0), (1.1, 1.5, 3.0, 10.0)
"""Programs on finer nodes until it is; what the load exceeded by is aimed below the next time. Else
the least loads of so many times what is proved."""
_FEWEST, _MOST, _EACH = 48, 160, 10.0
"""Cells in the wind: about so many in the time of the fastest mode."""
_GROWTH, _DECAYED = 1.15, 20.0
"""Growth of the cells after the wind, and their reach in times of the slowest growing mode."""
_WHOLE: float = float(np.pi / 2)
_NOTHING = 1e-9
"""A load so small, over that of the least deflection, is none."""
_LOAD_ROUNDS, _LOAD_GAIN = 5, 0.01
"""Programs of the least load at the most; the part by which each must have less than the last."""
_PER_RADIAN, _MAX_ZERO_NODES = 3.5, 300
"""Nodes in 1/omega of the oscillating zeros of the load, and as many of them at the most."""
_STEPS, _LOWEST = 6, 0.02
"""Newton steps to the load at a limit, and where they begin at least, over the same."""
_FLOOR = 1e-3
"""A limit so near to a floor, relative, is set by it."""
ANGLE, TURN, BOTH = "the least angle", "turning in time", "both together"


@dataclass(frozen=True, eq=False)
class LoadLimits:
    """A case, with what is known of its front: points that are reached, and lines below it."""

    case: LoadCase
    least_deflection: float
    program: LoadProgram
    blind: float | None
    points: list[tuple[float, float]] = field(default_factory=list)
    lines: list[tuple[float, float]] = field(default_factory=list)

    @cached_property
    def dense(self) -> LoadProgram:
        """A program on nodes that resolve the oscillating zeros of the load as well."""
        nodes, zeros = self.program.nodes, _oscillating_zeros(self.case)
        if not zeros.size:
            return self.program
        span = nodes[-1] - nodes[0]
        wanted = span * float(np.abs(zeros).max()) * _PER_RADIAN
        more = np.linspace(nodes[0], nodes[-1], int(min(wanted, _MAX_ZERO_NODES)) + 2)
        return LoadProgram(
            self.case, apart(np.concatenate([nodes, more]), 1e-6 / self.case.fastest)
        )

    @cached_property
    def its_load(self) -> float:
        """The load [rad] of the known deflection."""
        return float(np.abs(self.program.reference_load).max())

    @cached_property
    def least_load(self) -> float:
        """The least load [rad] that a computed control keeps to, at any deflection."""
        return self._least_found[0] if self._programmed else self.floor

    @cached_property
    def floor(self) -> float:
        """A load [rad] that every deflection exceeds or has, proved: zero where nothing is."""
        jumped = 0.0
        if self.case.ratio == 0.0:
            wind = self.case.wind
            knots = wind.knots
            jumps = np.abs(wind(knots) - wind(np.nextafter(knots, -np.inf)))
            jumped = float(np.max(jumps / np.where(knots <= wind.onset, 1.0, 2.0)))
        if not self._programmed:
            return jumped if jumped > _NOTHING * self.its_load else 0.0
        return max(jumped, self._least_found[1])

    @property
    def _programmed(self) -> bool:
        """Whether the least load is more than that of a jump of the wind."""
        case = self.case
        return bool(case.ratio or np.isfinite(case.rate) or np.count_nonzero(case.unstable) > 1)

    @cached_property
    def _least_found(self) -> tuple[float, float]:
        """The least load [rad] of controls on finer and finer nodes, and what is proved of it."""
        loads, proved = [self.its_load], [0.0]
        program, least = self.dense, np.inf
        for _ in range(_LOAD_ROUNDS):
            solved = program.solve(LOAD, _WHOLE)
            if solved is None:
                break
            self.points.append((solved.load, solved.peak))
            self.lines.append((solved.bound, solved.slope))
            if solved.slope > 0.0:
                proved.append((solved.bound - _WHOLE) / solved.slope)
            loads.append(solved.load)
            if solved.load > (1.0 - _LOAD_GAIN) * least or solved.finer.size > _MOST_NODES:
                break
            least = min(least, solved.load)
            program = LoadProgram(self.case, solved.finer)
        return min(loads), max(proved)

    @property
    def stopped(self) -> float:
        """What a stop of the wind at its peak leaves at least [rad]: half a jump of that size."""
        own = 0.0 if self.case.ratio else abs(float(self.case.wind.peak)) / 2.0
        return max(own, self.floor)

    def all_at(self, loads: FloatArray) -> list[tuple[float, float, float]]:
        """Limit, proof [rad] and slope at each load, the ends first and then in between."""
        found: dict[int, tuple[float, float, float]] = {}
        order = np.argsort(loads, kind="stable")
        pending = [(0, loads.size - 1)]
        for k in (0, loads.size - 1):
            found[int(order[k])] = self.at(float(loads[order[k]]))
        while pending:
            low, high = pending.pop(0)
            if high - low < 2:
                continue
            k = (low + high) // 2
            found[int(order[k])] = self.at(float(loads[order[k]]))
            pending += [(low, k), (k, high)]
        return [found[k] for k in range(loads.size)]

    def at(self, load: float) -> tuple[float, float, float]:
        """Limit, proof [rad] and slope at a load [rad]; no program where others know it."""
        if load < self.floor:
            return np.inf, np.inf, np.nan
        for program in (self.program, self.dense):
            if self._approach(load, program) and np.isfinite(self._reached(load)):
                break
        for more in _BEYOND:  # mixed with ones that have less load
            program = self.dense
            for _ in range(2):
                limit, (proof, _) = self._reached(load), self._proved(load)
                found = program.solve(LOAD, min(more * proof, _WHOLE)) if np.isinf(limit) else None
                if found is None:
                    break
                self.points.append((found.load, found.peak))
                program = LoadProgram(self.case, found.finer)
        return self._reached(load), *self._proved(load)

    def _approach(self, load: float, program: LoadProgram) -> bool:
        """Add controls of about a load [rad] on finer and finer nodes; False where none has it."""
        aimed = load
        for part in _AIMED:
            limit, (proof, _) = self._reached(load), self._proved(load)
            if limit - proof <= PROVED * proof:
                break
            solved = program.solve(PEAK, aimed)
            if solved is None:
                return False
            self.points.append((solved.load, solved.peak))
            self.lines.append((solved.bound, solved.slope))
            if solved.finer.size > _MOST_NODES:
                break
            aimed = load - part * max(solved.load - aimed, 0.0)
            program = LoadProgram(self.case, solved.finer)
        return True

    def _reached(self, load: float) -> float:
        """The least peak of a mixture of controls that are known, within a load [rad]."""
        under = [(a, d) for a, d in self.points if a <= load]
        over = [(a, d) for a, d in self.points if a > load]
        mixed = [d + (load - a) / (b - a) * (e - d) for a, d in under for b, e in over]
        return min([d for _, d in under] + mixed, default=np.inf)

    def _proved(self, load: float) -> tuple[float, float]:
        bounds = [(bound - slope * load, slope) for bound, slope in self.lines]
        return max([*bounds, (self.least_deflection, 0.0)])

    def needed_load(self, limit: float) -> float:
        """The load [rad] that a control within a limit [rad] keeps to; infinite if none."""
        if limit < self.least_deflection:
            return np.inf
        if limit >= self._reached(self.least_load):
            return self.least_load
        free, held = self._held
        low = max(float(np.max(np.abs(free) - limit * held)), self.least_load)
        load = max(low, _LOWEST * self.its_load)
        for _ in range(_STEPS):  # from below, along tangents
            _, proof, slope = self.at(load)
            if proof - limit <= PROVED * limit or not slope:
                break
            load += (proof - limit) / slope
        over = [(a, d) for a, d in self.points if d > limit]
        under = [(a, d) for a, d in self.points if d <= limit]
        mixed = [b + (limit - e) / (d - e) * (a - b) for a, d in over for b, e in under]
        return min([a for a, _ in under] + mixed, default=np.inf)

    def set_by(self, load: float, limit: float) -> str:
        """What sets a limit [rad]."""
        for floor, words in ((self.least_deflection, ANGLE), (self._turned(load), TURN)):
            if limit <= floor * (1.0 + _FLOOR):
                return words
        return BOTH

    def _turned(self, load: float) -> float:
        """The deflection [rad] that turns into the wind in time, held from the onset on."""
        if self.case.ratio or np.isfinite(self.case.rate):
            return 0.0
        free, held = self._held
        return float(np.max((np.abs(free) - load) / held, initial=0.0))

    @cached_property
    def _held(self) -> tuple[FloatArray, FloatArray]:
        """The angle of attack [rad] without control, and what a held deflection of one adds."""
        case, start = self.case, float(self.case.wind.onset)
        times = np.linspace(start, float(case.wind.end), 1001)[1:]
        none = Piecewise(linear_pieces([start], [0.0], 0.0))
        name = "angle_of_attack"
        free = attitude_responses(case.plant, none, case.wind, times, [name])[name]
        one = ConstantDeflection(limit=1.0, start=start)
        whole = attitude_responses(case.plant, one, 0.0 * case.wind, times, [name])[name]
        size = np.maximum.accumulate(np.abs(whole))
        return free, np.where(size > 0.0, size, np.inf)

    def unforeseen(self, loads: FloatArray, proofs: FloatArray) -> FloatArray:
        """Lower bounds [rad] of every law that does not know when the wind will stop."""
        assert self.blind is not None
        return np.where(loads < self.stopped, np.inf, np.maximum(proofs, self.blind))


def limits_of(plant: Plant, wind: History, ratio: float, rate: float) -> LoadLimits:
    """Return a case of `load_front` with what is known of it: M, and the rate limit [rad/s]."""
    start = float(wind.onset) if isinstance(wind, History) and not wind.batch else 0.0
    known = optimum_deflection(plant, wind, start if np.isfinite(start) else 0.0)
    case = LoadCase(plant, wind, known.deflection, ratio, rate)
    poles = unstable_poles(plant)
    blind = 0.0 if wind.constant_sign else None
    if wind.constant_sign and poles.size and not np.imag(poles[0]):
        blind = abs(float(forecast_free_limit(plant, wind).deflection))
    least_deflection = known.certificate.dual
    if np.isfinite(rate):
        slow = rate_front(plant, wind, [rate], rate_limit=rate)
        least_deflection = float(slow.limits[0])
        if blind:
            blind = float(ramped_deflection(blind, float(np.real(poles[0])), rate))
    found = LoadLimits(case, least_deflection, LoadProgram(case, _nodes(case)), blind)
    if np.isinf(rate):
        found.points.append((found.its_load, known.peak))
    return found


def _nodes(case: LoadCase) -> FloatArray:
    """Nodes even in the wind, and ever farther apart after it, with those of both histories."""
    wind, growing = case.wind, case.poles[case.unstable]
    start, end = float(wind.onset), float(wind.end)
    length = end - start
    count = int(np.clip(_EACH * case.fastest * length, _FEWEST, _MOST))
    width = length / count
    slowest = float(growing.real.min()) if growing.size else case.fastest
    last = end + _DECAYED / slowest
    steps = np.arange(
        1, int(np.log1p((last - end) * (_GROWTH - 1.0) / width) / np.log(_GROWTH)) + 2
    )
    after = end + width * (_GROWTH**steps - 1.0) / (_GROWTH - 1.0)
    parts = [np.linspace(start, end, count + 1), after, wind.knots, case.reference.knots]
    if np.any(growing.imag):
        parts.append(np.linspace(end, last, int((last - end) * growing.imag.max()) + 2))
    nodes = np.concatenate(parts)
    return apart(nodes[(nodes >= start) & (nodes <= after[-1])], 1e-6 / case.fastest)


def _oscillating_zeros(case: LoadCase) -> ComplexArray:
    """Return the complex zeros [1/s] from deflection to load: how a control moves without load."""
    A, B, C, D = case.plant.matrices()
    through = D[-1, 0] + case.ratio
    if through == 0.0:
        return np.zeros(0, complex)
    zeros = np.linalg.eigvals(A - np.outer(B[:, 0], C[-1]) / through)
    return np.asarray(zeros[zeros.imag > 0.0], dtype=complex)
