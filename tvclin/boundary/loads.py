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

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.documents import keyed
from tvclin.base.errors import (
    InputError,
    between,
    finite,
    number,
    one_row,
    positive,
    small_angle,
)
from tvclin.base.lines import Table, degrees, least
from tvclin.base.lines import number as figure
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.optimum.load_case import LoadCase
from tvclin.boundary.optimum.load_program import LOAD, PEAK, LoadProgram, apart
from tvclin.boundary.optimum.minimum_peak import optimum_deflection
from tvclin.boundary.rates import ramped_deflection, rate_front
from tvclin.linear.deflections import HeldDeflection
from tvclin.linear.modes import unstable_poles
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_responses
from tvclin.winds.histories import History, Piecewise, linear_pieces

_POINTS = 10
"""Of a front, unless loads are given."""
_MOST_NODES, _LESS = 1000, 0.95
_GAP = 1e-4
"""A limit so near to its bound, relative, is found."""
_AIMED = (0.125, 0.25, 0.5, 1.0)
"""Programs on finer nodes until it is; what the load exceeded by is aimed below the next time."""
_FEWEST, _MOST, _EACH = 48, 160, 10.0
"""Cells in the wind: about so many in the time of the fastest mode."""
_GROWTH, _DECAYED = 1.15, 20.0
"""Growth of the cells after the wind, and their reach in times of the slowest growing mode."""
_WHOLE: float = float(np.pi / 2)
_SIGN = 1e-12
"""What a wind of one sign may be beyond zero, over its peak."""
_NOTHING = 1e-9
"""A load so small, over that of the least deflection, is none."""
_STEPS, _LOWEST = 6, 0.02
"""Newton steps to the load at a limit, and where they begin at least, over the same."""
_FLOOR = 1e-3
"""A limit so near to a floor, relative, is set by it."""
ANGLE, TURN, BOTH = "the least angle", "turning in time", "both together"


@dataclass(frozen=True, eq=False)
class LoadFront(Shown):
    """The least deflection over a load bound, for one plant in one wind.

    Attributes
    ----------
    loads : ndarray
        Bounds of the load [rad], ``(n,)``.
    limits : ndarray
        Deflection [rad] with which a control that knows the wind stays within each, ``(n,)``;
        infinite where no angle is enough.
    proofs : ndarray
        Deflection [rad] with which none does, ``(n,)``: the least is between the two.
    slopes : ndarray
        By how much the deflection falls with the load bound, ``(n,)``: one over it is what a
        degree of the nozzle buys.
    holds : tuple of str
        What sets each limit: the least angle, turning in time into the wind, or both together.
    bounds : ndarray or None
        Lower bound [rad] of every law that does not know when the wind will stop, ``(n,)``; None
        for a wind that changes its sign.
    least_deflection, its_load : float
        The least deflection [rad] whatever the load, and the load [rad] of a control that is least.
    least_load, least_load_blind : float
        The least load [rad] at any deflection, and without a forecast, by the bound.
    moment_ratio, rate_limit : float
        M, and the rate limit [rad/s]; infinite if none.
    limit, load : float or None
        What the nozzle has, and what the structure bears [rad].
    needed : float
        The limit [rad] at that load, or whatever the load.
    needed_load : float
        The load [rad] that some control keeps to with that limit, or at any; infinite if none.
    """

    loads: FloatArray
    limits: FloatArray
    proofs: FloatArray
    slopes: FloatArray
    holds: tuple[str, ...]
    bounds: FloatArray | None
    least_deflection: float
    its_load: float
    least_load: float
    least_load_blind: float
    moment_ratio: float
    rate_limit: float
    limit: float | None
    load: float | None
    needed: float
    needed_load: float

    as_dict = keyed(
        "loads_deg limits_deg proofs_deg slopes holds bounds_deg least_deflection_deg its_load_deg"
        " least_load_deg least_load_blind_deg moment_ratio rate_limit_deg_per_s limit_deg load_deg"
        " needed_deg needed_load_deg left_deg left_load_deg enough"
    )
    _keys = (
        "least_deflection_deg least_load_deg limit_deg needed_deg load_deg needed_load_deg enough"
    )

    @property
    def left(self) -> float | None:
        """Angle [rad] that is left over what is needed."""
        return None if self.limit is None else self.limit - self.needed

    @property
    def left_load(self) -> float | None:
        """Load [rad] that is left over what is needed."""
        return None if self.load is None else self.load - self.needed_load

    @property
    def enough(self) -> bool | None:
        """Whether the limit is on the front or above, of a control that knows the wind."""
        return None if self.limit is None else self.limit >= self.needed

    @property
    def verdict(self) -> str:
        """Whether that is enough, in words."""
        if self.enough is None:
            return "nothing is asked; give a limit and a load"
        if not self.enough:
            return "NOT enough, whatever the control"
        if self.load is not None and self.load < self.least_load_blind:
            return "enough only for a control that knows when the wind stops"
        return "enough by theory, the wind being known"

    def tables(self) -> tuple[Table, ...]:
        """Return the front, and the nozzle's point beside what is needed."""
        blank = np.full(self.loads.size, np.nan)
        bounds = blank if self.bounds is None else self.bounds
        buys = 1.0 / np.where(self.slopes > 0.0, self.slopes, np.nan)
        rows = tuple(
            (
                degrees(f"front.{k}.load", self.loads[k]),
                least(degrees(f"front.{k}.limit", self.limits[k])),
                figure(f"front.{k}.buys_deg", buys[k], 2),
                least(degrees(f"front.{k}.bound", bounds[k])),
                (self.holds[k],),
            )
            for k in range(self.loads.size)
        )
        head = (
            *("load [deg]", "wind known [deg]", "a degree buys [deg]"),
            *("no forecast, at least [deg]", "set by"),
        )
        both = (
            ("limit [deg]", "limit", self.needed, self.limit, self.left),
            ("load [deg]", "load", self.needed_load, self.load, self.left_load),
        )
        point = tuple(
            (
                (label,),
                degrees(f"nozzle.{key}.needed", needed),
                degrees(f"nozzle.{key}.there", np.nan if there is None else there),
                degrees(f"nozzle.{key}.left", np.nan if left in (None, -np.inf) else left),
            )
            for label, key, needed, there, left in both
        )
        return (
            Table("Least deflection over the largest load", head, rows),
            Table(
                "Both at once: the limit at that load, the load at that limit",
                ("", "needed", "there", "left"),
                point,
            ),
        )

    @property
    def notes(self) -> Iterator[str]:
        """What the reader of the front should know."""
        what = "the angle of attack" if self.moment_ratio == 0.0 else "alpha + M delta, as an angle"
        yield f"the load is {what}, during the wind and after it"
        if self.bounds is None:
            yield "the wind changes its sign: there is no bound for laws without a forecast"
        elif np.isfinite(self.least_load_blind) and self.least_load_blind > 0.0:
            half = np.degrees(self.least_load_blind)
            yield f"a law that does not know when the wind stops bears {half:.4g} deg at least"
        if np.any(self.limits > self.proofs * (1.0 + 2.0 * _GAP)):
            most = np.max(1.0 - self.proofs / np.maximum(self.limits, 1e-300))
            yield f"the limits are proved to {100.0 * most:.2g} percent"


def load_front(
    plant: Plant,
    wind: History,
    loads: ArrayLike | None = None,
    *,
    limit: float | None = None,
    load: float | None = None,
    rate_limit: float = np.inf,
    moment_ratio: float = 0.0,
) -> LoadFront:
    """Return the least deflection over the largest load, from the onset of the wind on.

    Parameters
    ----------
    plant : Plant
        One plant.
    wind : History
        One wind that ends, known beforehand.
    loads : array_like, optional
        Bounds of the load [rad], ``(n,)``; unless given ten from near the least one up to what a
        control of least deflection has, and the given one.
    limit, load : float, optional
        What the nozzle has, and what the structure bears [rad].
    rate_limit : float
        Largest deflection rate [rad/s]; none by default.
    moment_ratio : float
        M: the load is alpha + M delta. Of a bending moment M_alpha alpha + M_delta delta it is
        M_delta/M_alpha, and the bounds are those of the moment over M_alpha.

    Returns
    -------
    LoadFront
        Each limit is reached by a deflection whose load was looked at between the nodes too, and
        proved from below by the prices of its program: they are within 1e-4, or a note says more.

    Raises
    ------
    InputError
        As `optimum_deflection` and, with a rate limit, `rate_front`; for loads that are not
        positive, and a load of the structure below the least possible, which is named.

    Notes
    -----
    At any deflection a wind without jumps leaves no load: the least is that of a jump at the onset,
    or half of a later one. A wind that may stop at its peak is such a jump: half of it is what a
    law without a forecast must bear. With a rate limit or M the least load comes from the program.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> wind = tv.TriangularWind(peak=np.radians(5), duration=7.5)
    >>> front = tv.boundary.load_front(plant, wind, np.radians([4.0, 2.5, 1.5]))
    >>> np.degrees(front.limits).round(3).tolist()
    [0.199, 0.258, 0.308]
    """
    angle = small_angle("a load", positive)
    most = (
        None if limit is None else number("limit", limit, small_angle("a limit", positive), "rad")
    )
    borne = None if load is None else number("load", load, angle, "rad")
    M = number("moment_ratio", moment_ratio, finite)
    rate = rate_limit
    if not (isinstance(rate, float) and np.isposinf(rate)):
        rate = number("rate_limit", rate, between(1e-15, 1e9), "rad/s")
    given = None if loads is None else angle("loads", one_row("loads", loads, "rad"), "rad")
    found = _front_of(plant, wind, M, rate)
    if borne is not None and borne < found.least_load:
        raise InputError(
            f"load is below what any deflection leaves; got {np.degrees(borne):.4g} deg, and"
            f" {np.degrees(found.least_load):.6g} deg ({found.least_load:.6g} rad) is the least"
        )
    if given is None:
        low, high = max(1.05 * found.least_load, 0.2 * found.its_load), found.its_load
        given = np.linspace(min(low, high), high, _POINTS)
        if borne is not None:
            given = np.unique(np.append(given, borne))
    each = dict(zip(given.tolist(), found.all_at(given), strict=True))
    limits, proofs, slopes = np.array([each[a] for a in given.tolist()]).T
    blind = found.blind
    needed = found.least_deflection if borne is None else found.all_at(np.array([borne]))[0][0]
    return LoadFront(
        loads=given,
        limits=limits,
        proofs=proofs,
        slopes=slopes,
        holds=tuple(found.set_by(a, d) for a, d in zip(given, limits, strict=True)),
        bounds=None if blind is None else found.unforeseen(given, proofs),
        least_deflection=found.least_deflection,
        its_load=found.its_load,
        least_load=found.least_load,
        least_load_blind=np.nan if blind is None else found.stopped,
        moment_ratio=M,
        rate_limit=rate,
        limit=most,
        load=borne,
        needed=needed,
        needed_load=found.least_load if most is None else found.needed_load(most),
    )


@dataclass(frozen=True, eq=False)
class _Front:
    """A case, with what is known of its front: points that are reached, and lines below it."""

    case: LoadCase
    least_deflection: float
    program: LoadProgram
    blind: float | None
    points: list[tuple[float, float]] = field(default_factory=list)
    lines: list[tuple[float, float]] = field(default_factory=list)

    @cached_property
    def its_load(self) -> float:
        """The load [rad] of the known deflection."""
        return float(np.abs(self.program.shown).max())

    @cached_property
    def least_load(self) -> float:
        """The least load [rad] at any deflection."""
        case, jumped = self.case, 0.0
        if case.ratio == 0.0:
            knots = case.wind.knots
            jumps = np.abs(case.wind(knots) - case.wind(np.nextafter(knots, -np.inf)))
            jumped = float(np.max(jumps / np.where(knots <= case.wind.onset, 1.0, 2.0)))
        if case.ratio or np.isfinite(case.rate) or np.count_nonzero(case.grows) > 1:
            found = self.program.solve(LOAD, _WHOLE)
            least = self.its_load if found is None else found.value
            return max(least, jumped)
        return jumped if jumped > _NOTHING * self.its_load else 0.0

    @property
    def stopped(self) -> float:
        """What a stop of the wind at its peak leaves at least [rad]: half a jump of that size."""
        own = 0.0 if self.case.ratio else abs(float(self.case.wind.peak)) / 2.0
        return max(own, self.least_load)

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
        program, aimed = self.program, load
        if load < self.least_load:
            return np.inf, np.inf, np.nan
        for part in _AIMED:
            limit, (proof, _) = self._reached(load), self._proved(load)
            if limit - proof <= _GAP * proof:
                break
            solved = program.solve(PEAK, aimed)
            if solved is None:
                break
            self.points.append((solved.load, solved.peak))
            self.lines.append((solved.bound, solved.slope))
            if solved.finer.size > _MOST_NODES:
                break
            aimed = load - part * max(solved.load - aimed, 0.0)
            program = LoadProgram(self.case, solved.finer)
        if np.isinf(self._reached(load)):  # mixed with one that has less load
            solved = self.program.solve(PEAK, max(_LESS * load, self.least_load))
            if solved is not None:
                self.points.append((solved.load, solved.peak))
        return self._reached(load), *self._proved(load)

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
            if proof - limit <= _GAP * limit or not slope:
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
        one = HeldDeflection(limit=1.0, start=start)
        whole = attitude_responses(case.plant, one, 0.0 * case.wind, times, [name])[name]
        size = np.maximum.accumulate(np.abs(whole))
        return free, np.where(size > 0.0, size, np.inf)

    def unforeseen(self, loads: FloatArray, proofs: FloatArray) -> FloatArray:
        """Lower bounds [rad] of every law that does not know when the wind will stop."""
        assert self.blind is not None
        return np.where(loads < self.stopped, np.inf, np.maximum(proofs, self.blind))


def _front_of(plant: Plant, wind: History, ratio: float, rate: float) -> _Front:
    start = float(wind.onset) if isinstance(wind, History) and not wind.batch else 0.0
    known = optimum_deflection(plant, wind, start if np.isfinite(start) else 0.0)
    case = LoadCase(plant, wind, known.deflection, ratio, rate)
    low, high = wind.extent
    one_sign = min(-float(low), float(high)) <= _SIGN * abs(float(wind.peak))
    poles = unstable_poles(plant)
    blind = 0.0 if one_sign else None
    if one_sign and poles.size and not np.imag(poles[0]):
        blind = abs(float(forecast_free_limit(plant, wind).deflection))
    least_deflection = known.certificate.dual
    if np.isfinite(rate):
        slow = rate_front(plant, wind, [rate], rate_limit=rate)
        least_deflection = float(slow.limits[0])
        if blind:
            blind = float(ramped_deflection(blind, float(np.real(poles[0])), rate))
    found = _Front(case, least_deflection, LoadProgram(case, _nodes(case)), blind)
    if np.isinf(rate):
        found.points.append((found.its_load, known.peak))
    return found


def _nodes(case: LoadCase) -> FloatArray:
    """Nodes even in the wind, and ever farther apart after it, with those of both histories."""
    wind, growing = case.wind, case.poles[case.grows]
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
    parts = [np.linspace(start, end, count + 1), after, wind.knots, case.known.knots]
    if np.any(growing.imag):
        parts.append(np.linspace(end, last, int((last - end) * growing.imag.max()) + 2))
    nodes = np.concatenate(parts)
    return apart(nodes[(nodes >= start) & (nodes <= after[-1])], 1e-6 / case.fastest)
