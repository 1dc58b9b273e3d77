"""Required deflection of a wind along a flight, where the parameters vary.

Along the flight, at the dynamic pressure encountered, the unstable mode has a costate p and a
control reach R,

    x' = A(t) x + b(t) delta + w(t) alpha_w,    p' = -A(t)^T p,    R' = -b(t).p

The unstable component p.x goes to zero in the end exactly when

    integral of p.b delta + p.w alpha_w dt = 0,

which for constant parameters, p = e^(-s t) times the left eigenvector, is eq (4b). Integrated
backwards, every costate p turns into the costate of the unstable mode. The control reach R is the
effect on the unstable component of a unit deflection that is constant from t on. No control has a
larger effect per deflection than the integral of ``|p.b|``, the absolute control reach, which is
``|R|`` as long as p.b keeps its sign. While two poles are a pair, as near lift-off, p turns, and
R passes through zero: a constant deflection then requires more than other controls do.

All three are marched backwards from the end of the flight, where they are the values of the vehicle
frozen as it is there, by the rule of Runge and Kutta, and scaled to ``|p| = 1`` after each step.
The error is of fourth order in the steps, below 1e-6 at the length taken here. Where the moment
changes its sign during a wind or after it, flights of the limited trim law decide, up to the last
time with an unstable pole; what a wind has left then turns back before it grows again.

In a sizing, pulses have their requirement at the dynamic pressure encountered, by direction.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.errors import InputError
from tvclin.boundary.limit import leading_pole
from tvclin.case.case import Case
from tvclin.linear.modes import left_eigenvectors
from tvclin.requirement.case_requirement import case_requirement
from tvclin.requirement.flight.sizing import Sizing
from tvclin.requirement.required_quantity import Requirement
from tvclin.time_varying.equations import (
    PRESSURES,
    Equations,
    UnstableModes,
    has_quick_path,
    of_pressure,
    sign_changes,
    unstable_end,
    unstable_modes_of,
)
from tvclin.time_varying.requirements import MAX_BATCH_STEPS, varying_requirement
from tvclin.time_varying.steps import step_times
from tvclin.vehicle.linear_vehicle import complete_vehicle
from tvclin.vehicle.vehicle import at_pressure
from tvclin.winds.shaped import encountered_wind
from tvclin.winds.wind_angles import EncounteredWind, NominalWind

_STEP_OVER_TIME_CONSTANT = 0.1
"""Length of a step times the fastest rate of the attitude."""
_MAX_STEPS = 100_000
"""Largest number of steps along a flight."""
WHOLE_TRIM = "counts all of trim there, which may be more than a control requires"
"""What K = 1 requires while two unstable poles are a pair, in words."""
_REACH_ROUNDING = 1e-9
"""Relative rounding of control reaches."""
_MAX_ROW_STEP_S = 0.5
"""Longest time [s] between two rows at which the poles of the vehicle are computed."""


@dataclass(frozen=True, eq=False)
class FlightMode:
    """The linear equations of a vehicle along its flight, and its fastest unstable mode.

    Beyond the last time with a real unstable pole the vehicle is frozen as it is then: it is
    stable, or oscillates, and that it is unstable for ever requires no less.

    Attributes
    ----------
    schedule : FlightSchedule
        The vehicle along its flight.
    model, plane : str
        Linear model and its plane; see `Plant.from_vehicle`.
    span : tuple of float
        First and last time [s] at which the mode is known; parameters are constant outside the
        schedule.
    """

    schedule: FlightSchedule
    model: str
    plane: str
    span: tuple[float, float]

    def trim_per_wind(self, t: Any) -> FloatArray:
        """Return B of eq (5) of the report, the ratio of static trim deflection to angle of attack.

        `t`: times [s], of the shape of the result. In a wind, alpha = -alpha_w, trim is -B alpha_w.
        """
        # -mu_delta and -mu_alpha, in the row of the attitude rate
        of_deflection, of_wind = np.moveaxis(self._equations(t)[..., 1, -2:], -1, 0)
        return np.asarray(of_wind / of_deflection)

    def costates_and_reaches(self, t: Any) -> FloatArray:
        """Return costate p, control reach R and absolute reach in rows, ``(m + 2,) + t.shape``.

        p, of m states and of length one, belongs to the fastest unstable mode, whose unstable
        component is p.x. R is the effect on it of a unit deflection constant from t on, the
        integral of p.b, b being the deflection's column; the absolute reach is that of ``|p.b|``.
        All are integrated backwards to `t` [s] from the next of the times of `_march`; times
        outside the span count as its ends.
        """
        times = np.clip(np.asarray(t, dtype=float), *self.span)
        ends, costates = self._march  # times of storage [s], and p with both reaches there
        step = np.minimum(np.searchsorted(ends, times, side="left"), ends.size - 1)
        solution = _costates_before(costates[step], self._step_matrices(times, ends[step]))
        return np.moveaxis(solution, -1, 0)

    @property
    def unstable(self) -> bool:
        """Whether a real pole is unstable at some time after the beginning of the flight."""
        return self._last_unstable > self.schedule.times[0]

    @property
    def last_unstable(self) -> float:
        """Last time [s] with a real unstable pole; `InputError` where there is none."""
        if not self.unstable:
            raise InputError(
                "varying parameters need a real unstable pole, which this flight has at none of its"
                " times"
            )
        return self._last_unstable

    @cached_property
    def fastest(self) -> FloatArray:
        """Largest rate sqrt(abs(mu_alpha)) [1/s] up to the last unstable time, ``(1,)``.

        mu_alpha [1/s^2] is the angular acceleration per angle of attack.
        """
        times = self._rows[self._rows <= self.last_unstable]  # of the rows of the schedule
        mu_alpha = self._equations(times)[:, 1, 0]  # row of the attitude rate, column of attitude
        return np.sqrt(np.abs(mu_alpha).max(keepdims=True))

    @property
    def breakpoints(self) -> FloatArray:
        """Times [s] of the schedule, between which the equations are smooth."""
        return self.schedule.times

    def at_steps(self, times: FloatArray) -> Equations:
        """Return the linear equations of the vehicle at the times of the steps of winds.

        `times`: begin, middle and end of each of S steps of n winds [s], ``(n, S, 3)``. After the
        last unstable time the vehicle is frozen. The costate at the end of each wind includes the
        remaining flight. Reaches are integrals of p.b, costate times column of the deflection, and
        absolute reaches of ``|p.b|``: where they differ, p.b changes its sign (`reverses`).
        """
        inside = np.minimum(times.ravel(), self.last_unstable)
        vehicles = [at_pressure(self.schedule.vehicle, ratio) for ratio in PRESSURES]
        plants = [
            replace(self.schedule, vehicle=vehicle).plants(inside, self.model, self.plane)
            for vehicle in vehicles
        ]
        E, E_slopes = of_pressure(plants)  # [A b w], and how it depends on the pressure
        order, columns = E.shape[-2:]
        E = np.broadcast_to(E, (inside.size, order, columns))
        E_slopes = np.broadcast_to(E_slopes, (inside.size, 2, order, columns))
        nominal = E.reshape(*times.shape, order, columns)
        # at the end of the last step, and at the begin of the first
        *costate, reach, absolute_reach = self.costates_and_reaches(times[:, -1, 2])
        *_costate, onset_reach, onset_absolute_reach = self.costates_and_reaches(times[:, 0, 0])
        _pole, pair = leading_pole(plants[0])  # whether the fastest unstable poles are a pair
        paired, quick = (
            np.broadcast_to(x, inside.shape).reshape(times.shape)
            for x in (pair, has_quick_path(plants[0]))
        )
        changes = sign_changes(nominal)
        reverses = changes | _reverses(onset_reach, onset_absolute_reach)
        costates = np.stack(costate, axis=-1)[reverses, np.newaxis]
        # of winds in which p.b changes its sign: the fastest mode alone, whose pole is not used
        single = UnstableModes(np.flatnonzero(reverses), np.ones(costates.shape[:2]), costates)
        several = unstable_modes_of(*left_eigenvectors(nominal[:, -1, 2, :, :order]))
        constant = ~_reverses(reach, absolute_reach)  # winds after which p.b keeps its sign
        modes = [single]
        for group in several:  # positions stay those in the batch of winds
            which = constant[group.cases]
            rows = (array[which] for array in (group.cases, group.poles, group.costates))
            modes.append(UnstableModes(*rows))
        return Equations(
            nominal=nominal,
            slopes=E_slopes.reshape(*times.shape, 2, order, columns),
            end=np.stack([*costate, reach], axis=-1),
            # by a change of sign the modes are a pair for a while, which flights go through
            paired=np.where(changes[:, np.newaxis, np.newaxis], paired[:, -1:, -1:], paired),
            quick_path=np.any(quick, axis=(1, 2)),  # at any step
            modes=tuple(group for group in modes if group.cases.size),
            reverses=reverses,
            absolute_reach=absolute_reach,
        )

    @cached_property
    def until_stable(self) -> FlightMode:
        """The flight up to the last interval, of one sign of the moment, with an unstable pole.

        A flight that is stable throughout is returned whole.
        """
        start, stop = self.span
        # intervals of the flight in which the aerodynamic moment keeps its sign, in order of time
        intervals = self.schedule.one_sign_intervals
        while len(intervals) > 1:
            *before, last = intervals
            if FlightMode(last, self.model, self.plane, last.span).unstable:
                break
            intervals, stop = tuple(before), last.span[0]
        if not self.unstable or stop == self.span[1]:
            return self
        schedule = self.schedule.between(None, stop)
        return FlightMode(schedule, self.model, self.plane, (start, stop))

    def judged_at(self, ends: FloatArray) -> FloatArray:
        """Return the times [s] at which flights are judged, of winds that end at `ends` [s].

        That is the last unstable time where the moment changes its sign after the end of the wind:
        a vehicle that is stable then turns back by itself, and is unstable again later.
        """
        last_change = np.max(self.sign_changes, initial=-np.inf)
        return np.where(ends < last_change, self.last_unstable, ends)

    @cached_property
    def sign_changes(self) -> FloatArray:
        """Times [s] at which the aerodynamic moment changes its sign, ``(k,)``.

        Only those within `until_stable`, the flight without the stable intervals at its end: before
        these, intervals of both signs may alternate.
        """
        intervals = self.until_stable.schedule.one_sign_intervals
        return np.array([interval.span[0] for interval in intervals[1:]])

    def has_exit(self, begin: float, end: float) -> bool:
        """Return whether K < 1 has an exit of the dead band in a wind from `begin` to `end` [s].

        It has none where poles are a pair during the wind, or the moment changes its sign up to the
        time at which flights are judged.
        """
        return not (self._changes_sign(begin, end) or self.has_pair(begin, end))

    def has_pair(self, begin: float, end: float) -> bool:
        """Return whether the fastest unstable poles are a pair or equal at a time in a wind.

        K = 1 then counts the whole trim. `begin`, `end`: times of the wind [s]. False where the
        moment changes its sign, as flights decide there.
        """
        within = (begin <= self.paired_times) & (self.paired_times <= end)
        return bool(np.any(within)) and not self._changes_sign(begin, end)

    def _changes_sign(self, begin: float, end: float) -> bool:
        """Return whether the moment changes its sign from the begin of a wind [s] on.

        Changes count up to the time at which flights through the wind are judged: at its `end` [s]
        or, where the moment changes its sign later, at the last unstable time.
        """
        judged = self.judged_at(np.array(end))
        return bool(np.any((begin < self.sign_changes) & (self.sign_changes < judged)))

    @cached_property
    def quick_path(self) -> bool:
        """Whether the path is quick at some time, so that flights of the limited law decide.

        See `has_quick_path`: the flight path is unstable, or about as fast as the attitude.
        """
        # times [s] of the schedule up to the last one with a real unstable pole
        times = self._rows[self._rows <= self.last_unstable]
        plants = self.schedule.plants(times, self.model, self.plane)
        return bool(np.any(has_quick_path(plants)))

    @cached_property
    def paired_times(self) -> FloatArray:
        """Times [s] at which the fastest unstable poles are a pair or equal, ``(r,)``.

        They are among `_rows`, the times of the schedule, with even ones in long intervals between.
        """
        times = self._rows[self._rows <= self.last_unstable]
        _pole, paired = leading_pole(self.schedule.plants(times, self.model, self.plane))
        return times[np.broadcast_to(paired, times.shape)]

    @cached_property
    def _rows(self) -> FloatArray:
        """Times [s] of the schedule, with even ones in intervals above `_MAX_ROW_STEP_S`."""
        times = self.schedule.times
        return _refined(times, np.diff(times) / _MAX_ROW_STEP_S)

    @cached_property
    def _last_unstable(self) -> float:
        """Last of the times `_rows` with a real unstable pole [s]; minus infinity without one."""
        # control reach of the unstable mode at each time, the last entry; NaN without such a pole
        reach = unstable_end(self._plants_at(self._rows))[..., -1]
        return float(np.max(self._rows[~np.isnan(reach)], initial=-np.inf))

    def _equations(self, t: Any) -> FloatArray:
        """Return ``[A b w]`` at times [s], frozen after the last unstable time.

        A is the matrix of the states, b and w the columns of deflection and wind. The shape is
        ``t.shape + (m, m + 2)``.
        """
        return self._plants_at(np.minimum(np.asarray(t, dtype=float), self.last_unstable))

    def _plants_at(self, t: FloatArray) -> FloatArray:
        """Return ``[A b w]`` at times [s] up to the last unstable one, ``t.shape + (m, m + 2)``."""
        A, inputs, _C, _D = self.schedule.plants(t, self.model, self.plane).matrices()
        equations = np.concatenate([A, inputs], axis=-1)
        return np.broadcast_to(equations, (*t.shape, *equations.shape[-2:]))

    @cached_property
    def _march(self) -> tuple[FloatArray, FloatArray]:
        """Ends of steps [s] ``(k,)``, and costate p ``(m,)`` and two reaches there ``(k, m + 2)``.

        p of the m states x belongs to the fastest unstable mode. The control reach is the effect on
        p.x of a unit deflection constant from then on, the absolute reach that of one with the sign
        of p.b in each step. They are integrated backwards from the end of the span, where the
        vehicle is frozen, and scaled to a costate of length one after each step.
        """
        start, stop = self.span
        breakpoints = np.append(self.schedule.times, self.last_unstable)
        inside = breakpoints[(breakpoints > start) & (breakpoints < stop)]
        knots = np.unique([start, *inside, stop])
        ends = _refined(knots, np.diff(knots) * self.fastest[0] / _STEP_OVER_TIME_CONSTANT)
        matrices = self._step_matrices(ends[:-1], ends[1:])
        costates = np.empty((ends.size, matrices.shape[-1] + 1))
        costates[-1, :-1] = unstable_end(self._equations(stop))  # of the frozen vehicle at the end
        costates[-1, -1] = abs(costates[-1, -2])
        for k in range(ends.size - 2, -1, -1):
            costates[k] = _costates_before(costates[k + 1], matrices[k])
        return ends, costates

    def _step_matrices(self, begin: FloatArray, end: FloatArray) -> FloatArray:
        """Return matrices M with (p, R) at the begin of a step = (p, R) at its end times M.

        p is the costate of the unstable component p.x, R the control reach, the effect on it of a
        unit deflection from then on. M of k steps, ``(k, m + 1, m + 1)``, is exact to fourth order,
        by the classical rule of Runge and Kutta, backwards. `begin`, `end`: times [s], ``(k,)``.
        """
        h = (end - begin)[..., np.newaxis, np.newaxis]
        times = np.stack([begin, 0.5 * (begin + end), end])
        # p' = -p A and R' = -p b are (p, R)' = -(p, R) [[A, b], [0, 0]]
        A_b = self._equations(times)[..., :-1]  # without the column of the wind
        first, middle, last = np.concatenate([A_b, np.zeros_like(A_b[..., :1, :])], axis=-2)
        slopes = [last]  # derivatives of M with time to the end of the step
        for matrix, fraction in ((middle, 0.5), (middle, 0.5), (first, 1.0)):
            slopes.append(matrix + fraction * h * slopes[-1] @ matrix)
        total = slopes[0] + 2.0 * (slopes[1] + slopes[2]) + slopes[3]
        return np.asarray(np.eye(total.shape[-1]) + h / 6.0 * total)


def _costates_before(costates: FloatArray, matrices: FloatArray) -> FloatArray:
    """Return costates of length one and control reaches at the begin of steps, ``(..., m + 2)``.

    The last axis holds the costate p ``(m,)``, the control reach R and the absolute reach, the
    integrals of p.b and ``|p.b|`` from then on; all are divided by the length of p. `costates`: the
    same at the ends of the steps. `matrices`: see `FlightMode._step_matrices`.
    """
    before = np.einsum("...i,...ij->...j", costates[..., :-1], matrices)  # p and R
    later_reach, later_absolute = costates[..., -2:-1], costates[..., -1:]
    absolute_reach = later_absolute + np.abs(before[..., -1:] - later_reach)
    length = np.linalg.norm(before[..., :-1], axis=-1, keepdims=True)
    return np.asarray(np.concatenate([before, absolute_reach], axis=-1) / length)


def _reverses(reach: FloatArray, absolute_reach: FloatArray) -> BoolArray:
    """Return whether the effect of a deflection changes its sign after each of n times, ``(n,)``.

    It is p.b, the effect on the unstable component p.x of the states x, p being its costate and b
    the deflection's column. Its integral from then on is `reach`, and the integral of its size
    `absolute_reach`, ``(n,)`` each.
    """
    return np.abs(reach) < (1.0 - _REACH_ROUNDING) * absolute_reach


def _refined(times: FloatArray, steps: FloatArray) -> FloatArray:
    """Return times [s] with `steps` even steps between each two, rounded up, and at least one.

    `InputError` for more than `_MAX_STEPS` in all.
    """
    counts = np.maximum(np.ceil(steps), 1.0)
    if not counts.sum() <= _MAX_STEPS:
        raise InputError(
            f"varying parameters can be followed for at most {_MAX_STEPS} steps; a flight of"
            f" {times[-1] - times[0]:.4g} s takes {counts.sum():.4g}: shorten it or the winds, or"
            " let the vehicle be frozen"
        )
    between = [
        np.linspace(*ends, int(count), endpoint=False)
        for ends, count in zip(pairwise(times), counts, strict=True)
    ]
    return np.concatenate([*between, times[-1:]])


_NOTED_INCREASE = 1.05
"""Ratio of the minimum over all modes to the minimum by the fastest, above which a note says so."""
_SAMPLES_BETWEEN = 16
"""Times between breakpoints of a wind at which static trim is computed."""


@dataclass(frozen=True, eq=False)
class FlightRequirement:
    """Deflections [rad] that one wind requires of a vehicle along its flight, as sizes.

    Attributes
    ----------
    trim : float
        Static trim: the largest ``|B(t) alpha_w(t)|`` at nominal dynamic pressure, without drift.
    required : ndarray
        Required deflection at each dead band, ``(k,)``; NaN with K < 1 for a wind that changes its
        sign.
    minimum : float
        Lower bound with the wind known, to both sides, over all unstable modes.
    slower_modes : bool
        Whether slower unstable modes, as they are when the wind ends, raise the minimum above that
        of the fastest alone by more than 5 percent; the flight goes on then.
    trim_time : float
        Time [s] of the largest static trim.
    times : ndarray
        Times [s] at which the dead bands are left with the required limits, ``(k,)``.
    """

    trim: float
    required: FloatArray
    minimum: float
    slower_modes: bool
    trim_time: float
    times: FloatArray


def flight_requirements(
    mode: FlightMode,
    winds: Sequence[NominalWind],
    dead_bands: FloatArray,
    two_sided: Sequence[NominalWind | None] | None = None,
) -> list[FlightRequirement]:
    """Return the deflections that winds require of a vehicle along its flight, by wind.

    Parameters
    ----------
    mode : FlightMode
        The flight, with a span that covers the winds.
    winds : sequence of NominalWind or FlightWind
        Winds that end, each by itself.
    dead_bands : ndarray
        K, each in [0, 1], ``(k,)``.
    two_sided : sequence, optional
        For each wind that is the interval of one sign of a longer wind, this longer wind, which a
        law with K = 1 encounters; else None.
    """
    times = [wind.history.probe_times(_SAMPLES_BETWEEN) for wind in winds]
    ends = np.cumsum([t.size for t in times])[:-1]
    # B, the ratio of trim deflection to wind angle, at the times of each wind
    trim_ratios = np.split(mode.trim_per_wind(np.concatenate(times)), ends) if winds else []
    both_signs = [
        two_sided_wind or wind
        for two_sided_wind, wind in zip(two_sided or winds, winds, strict=True)
    ]
    # required deflection, minimum, that of the fastest mode, and exit time of each wind, (n, 4)
    full_band = requirements_along(mode, both_signs, 1.0)  # K = 1
    by_band = [full_band if K == 1.0 else requirements_along(mode, winds, K) for K in dead_bands]
    required, *_, exits = np.moveaxis(np.array(by_band), -1, 0)  # (k, n) each
    requirements = []
    for i, wind in enumerate(winds):
        trim = np.abs(trim_ratios[i] * wind.history(times[i]))
        largest = int(np.argmax(trim))
        _required, minimum, fastest_minimum, _exit = full_band[i].tolist()
        # slower modes raise the minimum, and are still unstable when the wind ends
        requirements.append(
            FlightRequirement(
                trim=float(trim[largest]),
                required=required[:, i],
                minimum=minimum,
                slower_modes=0.0 < _NOTED_INCREASE * fastest_minimum < minimum
                and float(both_signs[i].history.end) < mode.last_unstable,
                trim_time=float(times[i][largest]),
                times=exits[:, i],
            )
        )
    return requirements


def requirements_along(
    mode: FlightMode, winds: Sequence[NominalWind | EncounteredWind], dead_band: float
) -> FloatArray:
    """Return deflections [rad] and exit time [s] of winds, ``(n, 4)``.

    They are the required deflection, the minimum of any control, and that for the fastest unstable
    mode alone; and the time at which the dead band is left with the required limit. Deflections are
    zero, and the time is NaN, for a calm and a stable flight. `mode`: unstable mode of the flight.
    `dead_band`: K, from 0 to 1. A wind counts as long as the vehicle has an unstable pole
    (`until_stable`). Winds with the same number of steps are computed together, except on a quick
    path: there one by one, since the length of such a flight depends on the others of its batch.
    """
    result = np.tile([0.0, 0.0, 0.0, np.nan], (len(winds), 1))
    # index and wind, by: whether the whole wind counts, index on a quick path, number of steps
    groups: dict[tuple[bool, int, int], list[tuple[int, NominalWind | EncounteredWind]]] = {}
    for i, wind in enumerate(winds if mode.unstable else ()):
        whole = wind.calm or float(wind.history.end) <= mode.until_stable.span[1]
        flight = mode if whole else mode.until_stable
        inner = wind if whole else wind.between(*flight.span)
        if not inner.calm:
            steps = step_times(inner.history, flight).shape[1]
            groups.setdefault((whole, i if flight.quick_path else 0, steps), []).append((i, inner))
    for (whole, _quick, steps), members in sorted(groups.items()):
        batch_size = int(MAX_BATCH_STEPS // steps) + 1
        for first in range(0, len(members), batch_size):
            index, batch = zip(*members[first : first + batch_size], strict=True)
            flight = mode if whole else mode.until_stable
            of_batch = varying_requirement(flight, batch, dead_band)
            names = "required", "minimum", "fastest_minimum", "time"
            columns = [getattr(of_batch, name) for name in names]
            result[list(index)] = np.stack(columns, axis=-1)
    return result


def base_requirement(sizing: Sizing) -> Requirement:
    """Return the key of a sizing's requirement that counts, of its largest dead band.

    It has varying parameters if its values are known wherever those with parameters frozen at each
    flight time are; else frozen parameters.
    """
    frozen = Requirement(dead_band=sizing.dead_bands[0])  # the largest is the first
    varying = replace(frozen, varying=True)
    has_frozen, values = ~np.isnan(sizing.required[frozen]), sizing.required.get(varying)
    if values is None or np.isnan(values).all() or np.any(np.isnan(values) & has_frozen):
        return frozen
    return varying


def with_directions(
    sizing: Sizing, pulses: int, case_at: Callable[[float, int], Case], mode: FlightMode | None
) -> Sizing:
    """Return a sizing with the requirements of pulses at the dynamic pressure encountered.

    Columns are added by the possible directions of the pulses, for the largest dead band; a
    sounding has its own direction, and the same requirement in all.

    Parameters
    ----------
    sizing : Sizing
        The sizing at nominal dynamic pressure of its first winds.
    pulses : int
        Number of the first winds, which are pulses.
    case_at : callable
        From a flight time [s] and the number of a pulse to its case.
    mode : FlightMode or None
        The flight, where parameters vary.
    """
    # whether the requirement at the pressure encountered is not known, and the first reason
    unknown, why = np.zeros(sizing.known.shape, dtype=bool), ""
    K, base = float(sizing.dead_bands[0]), base_requirement(sizing)  # at nominal pressure
    columns: dict[Requirement, FloatArray] = {}
    # columns, flight times i and winds j whose requirement is computed below, along the flight
    along: list[tuple[FloatArray, int, int, EncounteredWind]] = []
    for i, j in np.argwhere(sizing.known[:, :pulses]).tolist():
        try:
            case = case_at(float(sizing.times[i]), j)
            # by direction: winds to be computed along the flight (the factor is not used), or
            # factors on the nominal requirement of a vehicle that is frozen at the flight time
            if base.varying and mode is not None:
                winds = _winds_along(mode, case, K, float(sizing.begins[i, j]))
                factors = dict.fromkeys(winds, 1.0)
            else:
                winds, factors = {}, _encountered_over_nominal(case, K)
            for direction, factor in factors.items():
                requirement = replace(base, direction=direction)
                column = columns.setdefault(requirement, sizing.required[base].copy())
                column[i, j] *= factor
                if direction in winds:
                    along.append((column, i, j, winds[direction]))
        except InputError as error:  # no such wind on this path, or too long: nominal value stays
            unknown[i, j], why = True, why or f"{sizing.times[i]:g} s: {error}"
    if along and mode is not None:
        required = requirements_along(mode, [wind for *_, wind in along], K)[:, 0]  # K: one alone
        for (column, i, j, _), value in zip(along, required.tolist(), strict=True):
            column[i, j] = value
    arises = dict(sizing.arises)  # times of flight at which each requirement arises
    if base in arises:
        arises |= dict.fromkeys(columns, arises[base])
    sizing = replace(sizing, required=sizing.required | columns, arises=arises)
    unknown &= sizing.required[base] != 0.0  # zero stays zero at any dynamic pressure
    if not unknown.any():
        return sizing
    note = f"the dynamic pressure encountered in a pulse is not known at {why}"
    return replace(sizing, unsigned=unknown, notes=(*sizing.notes, note))


def _encountered_over_nominal(case: Case, K: float) -> dict[str, float]:
    """Return the ratios of encountered to nominal requirement of a case, by direction.

    `K`: dead band, the fraction of the limit up to which the vehicle is trimmed. One where nominal
    is zero; `InputError` where the dynamic pressure encountered is not known.
    """
    need = case_requirement(case, K)
    if need.encountered_unknown:
        raise InputError(need.encountered_unknown)
    nominal = need.nominal_deflection
    return {
        direction: required / nominal if nominal > 0.0 else 1.0
        for direction, required in need.encountered.items()
    }


def _winds_along(
    mode: FlightMode, case: Case, K: float, begins: float
) -> dict[str, EncounteredWind]:
    """Return the pulse of a case along the flight from time `begins` [s], by direction.

    The pulse keeps its peak and duration; path and speed of the vehicle, on which its angles and
    dynamic pressure depend, vary along the schedule of `mode`, the unstable mode along the flight.
    `K`: dead band, for which the time of a gust is the worst. `InputError` beyond linear
    aerodynamics.
    """
    vehicle = complete_vehicle(case.vehicle, "the dynamic pressure encountered").rigid
    along = mode.schedule.vehicle  # the vehicle at all times of the schedule
    paths, speeds = (
        np.broadcast_to(x, mode.schedule.times.shape) for x in (along.attitude, along.velocity)
    )
    # wind speeds are over the speed of the case's vehicle, that at the flight time of the pulse
    flight = mode.schedule.times, paths, speeds / float(np.asarray(vehicle.velocity))
    placed, winds = case.wind_at(K), {}
    for direction in case.directions():
        wind = encountered_wind(placed, vehicle, case.plane, direction)
        wind = replace(wind.shift(begins - float(wind.history.onset)), flight=flight)
        wind.check_linear()
        winds[direction] = wind
    return winds
