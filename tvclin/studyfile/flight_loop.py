"""The autopilot of a plan along its whole flight: the sweep of its margins, and its flights."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import groupby
from typing import Any, NamedTuple, Self, TypeAlias

import numpy as np

from tvclin.ascent.measured_wind import MeasuredPlanes, MeasuredWind, unknown_between
from tvclin.ascent.schedule import FlightSchedule
from tvclin.ascent.wind_along import wind_along
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Record
from tvclin.base.errors import InputError, between, number
from tvclin.base.fields import derived, record_table, spec
from tvclin.base.lines import Table, plural, text
from tvclin.base.quantities import survival
from tvclin.case.flexible_autopilot import actuator_notes, textbook_notes
from tvclin.control.autopilot.gain_schedule import (
    GainSchedule,
    constant_gains_notes,
    even_times,
    flight_autopilot,
)
from tvclin.control.autopilot.sweep import Sweep, sweep
from tvclin.ensembles.statistics import Success, success_probability
from tvclin.flights.closed_loop.flown_flights import checked_flight
from tvclin.flights.closed_loop.fly_along import FlightAlong, sampled_outputs
from tvclin.flights.closed_loop.fly_planes_along import fly_planes_along
from tvclin.kernels.choice import repeated
from tvclin.linear.plant import DEFAULT_MODEL, flexible_model
from tvclin.requirement.flight.deflection_use import (
    AutopilotRequirements,
    DeflectionUse,
    autopilot_requirements,
    deflection_use,
    used_around,
)
from tvclin.requirement.flight.flight_winds import place, place_vector
from tvclin.requirement.flight.request import SizingRequest
from tvclin.requirement.flight.sizing import Sizing, flight_times
from tvclin.requirement.required_quantity import MINIMUM, NO_FORECAST
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.vehicle.vehicle import vehicle_warnings
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.wind_angles import ATTACK, MAX_LINEAR_ANGLE, SIGNS, beyond_linear

Progress = Callable[[float, float], None]
"""Function called with the number of flights done and in total."""
_IN_PLANES = "in both planes it is not computed: that of one plane is without the limit shape"
"""Reason why the autopilot requirement of both planes is not known."""
FlownWind: TypeAlias = History | PlaneWind | MeasuredWind | MeasuredPlanes
"""Wind of a flight, in one plane or in both."""
_MIN_WINDS = 2
"""Smallest number of winds of which a fraction is shown."""


@dataclass(frozen=True, eq=False)
class FlightLoop:
    """A plan with a flight, whose autopilot, structure and vehicle vary over the flight."""

    plan: StudyPlan

    @classmethod
    def of(cls, plan: StudyPlan) -> FlightLoop:
        """Return the loop of a plan, with the autopilot of its flight in place of a single time's.

        `InputError` for a plan without a flight, and with a controller in state space.
        """
        if plan.sizing is None:
            raise InputError("the autopilot over a flight needs a flight schedule")
        if plan.controller is not None or plan.plant_system is not None:
            raise InputError("a plant or a controller in state space is of a single flight time")
        return cls(replace(plan, design=plan.sizing.scheduled_design or plan.design))

    @property
    def request(self) -> SizingRequest:
        """The sizing of the flight, with its schedule and its flight times."""
        assert self.plan.sizing is not None  # by `of`
        return self.plan.sizing

    @property
    def flight(self) -> FlightSchedule:
        """The flight."""
        return self.request.schedule

    @property
    def model(self) -> str:
        """Model of the motion; with a structure "drift-exact" in place of "drift"."""
        return flexible_model(self.flight.structure, self.plan.model or DEFAULT_MODEL)

    @cached_property
    def times(self) -> FloatArray:
        """Flight times of the sweep [s], even ones and the last, ``(n,)``."""
        request, (first, last) = self.request, self.flight.span
        low = number("size.from_s", _or_default(request.start, first), between(first, last), "s")
        high = number("size.to_s", _or_default(request.stop, last), between(low, last), "s")
        return even_times(low, high, self.request.every)

    @cached_property
    def autopilot(self) -> GainSchedule:
        """The autopilot over the flight."""
        return self._autopilot_in(self.plan.plane)

    def _autopilot_in(self, plane: str) -> GainSchedule:
        """Return the autopilot over the flight in a plane, "pitch" or "yaw".

        A rule gives each plane its gains.
        """
        return flight_autopilot(
            self.plan.autopilot_design,
            self.flight,
            np.union1d(even_times(*self.flight.span, self.request.every), self.times),
            actuator=self.plan.nozzle.actuator,
            model=self.model,
            plane=plane,
        )

    @cached_property
    def sampled(self) -> dict[str, GainSchedule]:
        """The autopilot over the flight by plane, with the sample rate [Hz] of the flights.

        `sweep` judges the same autopilot without samples. One plane, or both if the plan has both.
        """
        rate, by_plane = self.plan.hardware["sample_rate"], {}
        for plane in PLANES if self.plan.planes == BOTH else (self.plan.plane,):
            law = self.autopilot if plane == self.plan.plane else self._autopilot_in(plane)
            by_plane[plane] = replace(law, autopilot=replace(law.autopilot, sample_rate=rate))
        return by_plane

    def sweep(self) -> Sweep:
        """Return the margins at the flight times, judged by the criteria of the plan."""
        return sweep(
            self.flight,
            self.autopilot,
            self.times,
            criteria=self.plan.margin_criteria,
            model=self.model,
            plane=self.plan.plane,
        )

    @property
    def notes(self) -> Iterator[str]:
        """Notes on the flight, implausible numbers, unspecified gains, an assumed actuator."""
        yield from (*self.flight.notes, *vehicle_warnings(self.flight.vehicle))
        yield from textbook_notes(self.plan, over_flight=True)
        yield from constant_gains_notes(self.autopilot, self.flight, self.times)
        if self.flight.actuator_frequency is None:
            yield from actuator_notes(self.plan)

    def _unstable_times(self) -> FloatArray:
        """Return the flight times [s] at which the frozen loop has an unstable oscillation."""
        plan = self.plan
        swept = sweep(
            self.flight,
            self.sampled[plan.plane],  # autopilot over the flight, with the rate of its samples
            self.times,
            factors=(),  # no detuned modes
            model=self.model,
            plane=plan.plane,
        )
        oscillates = (swept.poles.imag > 0.0) & (swept.poles.real > 0.0)
        return self.times[np.any(oscillates, axis=-1)]

    def fly(self, progress: Progress | None = None) -> FlightsOfLoop:
        """Return the flights of the loop through each wind of the plan, with the nozzle's limits.

        A pulse has its peak at each flight time, in the worse of head and tail wind unless the plan
        says one; a sounding is flown through, with its gust at each flight time. The dynamic
        pressure is that encountered in the wind. With a limit shape both planes fly together.
        `progress` is called with winds done and in total. `InputError` without a deflection limit,
        and as `fly_along` or `fly_planes_along`.

        A flight whose status is "lost" diverges. The used deflection [rad] by flight time of the
        sizing is NaN at the times of a wind that is not survived, at all times if that is a
        sounding without a gust, which has no time.
        """
        plan = self.plan
        if plan.nozzle.limit is None:
            raise InputError("a flight of the loop needs the deflection limit: --limit-deg")
        cases = list(self._cases())
        times = self.request.times(plan)
        used = np.full(times.shape, np.nan)
        worst_flight: FlightAlong | None = None
        outcomes: list[FlightOutcome] = []
        directed = [(case, sign) for case in cases for sign in self._directions(case.wind)]
        flights = self._flown(directed, plan.nozzle.limit)
        for k, case in enumerate(cases):
            of_case: list[FlightOutcome] = []
            for direction in self._directions(case.wind):
                # similar runs, which decide between compiled and plain code
                with repeated(len(cases)):
                    flown = next(flights)
                if flown.status != "lost" and case.time is None:  # a sounding without a gust
                    used = np.fmax(used, used_around(flown, times))
                elif flown.status != "lost":  # at the time of its pulse or gust
                    largest = abs(flown.largest("deflection").value)
                    used = np.fmax(used, np.where(times == case.time, largest, np.nan))
                flown = within_linear_range(flown)
                of_case.append(FlightOutcome.of(case, direction, flown, self._omitted(case)))
                if of_case[-1] is max([*outcomes, *of_case], key=_severity):
                    worst_flight = flown
            outcomes.append(max(of_case, key=_severity))
            if progress is not None:
                progress(k + 1, len(cases))
        assert worst_flight is not None  # a sizing has a wind
        for outcome in outcomes:
            if outcome.survived is False:
                used[slice(None) if outcome.time is None else times == outcome.time] = np.nan
        return FlightsOfLoop(
            outcomes=tuple(outcomes),
            worst=worst_flight,
            limit=plan.nozzle.limit,
            used=used,
            unstable_times=self._unstable_times(),
        )

    def _flown(
        self, cases: Sequence[tuple[_Wind, str | None]], limit: float
    ) -> Iterator[FlightAlong]:
        """Yield the flights through winds, in the order of `cases`, with a deflection limit [rad].

        `cases`: winds, each with a direction: head, tail, frozen, or None where the wind has its
        own. The flights of all pulses are computed together, and of all soundings.
        """
        plane, rate_limit = self.plan.plane, self.plan.hardware["rate_limit"]
        in_planes = self.plan.planes == BOTH
        for _is_pulse, group in groupby(cases, lambda case: case[0].start is not None):
            flights = []
            for case, direction in group:
                wind: Any = case.wind  # in one plane, or in both
                if in_planes:
                    yield fly_planes_along(
                        self.flight,
                        self.sampled,  # the autopilot over the flight by plane, with its samples
                        wind,
                        deflection_limit=limit,
                        rate_limit=rate_limit,
                        limit_shape=self.plan.nozzle.limit_shape or "round",
                        sign=direction,
                        gust_time=case.gust_time,
                        start=case.start,
                        stop=case.stop,
                        model=self.model,
                    )
                    continue
                along = wind_along(self.flight, wind, plane, direction, case.gust_time)
                law, ends = self.sampled[plane], (case.start, case.stop)
                flights.append(
                    checked_flight(self.flight, law, along, *ends, model=self.model, plane=plane)
                )
            if flights:
                yield from sampled_outputs(flights, limit, rate_limit)

    def use(
        self,
        sizing: Sizing,
        *,
        requirements: bool = False,
        progress: Progress | None = None,
    ) -> FlightsOfLoop:
        """Return the flights, with required, used and remaining deflection by flight time.

        The required one is the requirement of the sizing that the budget counts, of frozen or
        varying parameters, with the lower bounds of the same kind: the minimum, with the wind
        known, and the bound without a forecast. `sizing`: of the flight and its winds.
        `requirements`: whether the autopilot requirement stands beside them too; in both planes it
        is not computed, and NaN. `progress`: called with flights done and in total.
        """
        flown, autopilot_required = self.fly(progress), None
        counted = self.request.counted(sizing, self.plan.sign)  # the requirement that counts
        if requirements and self.plan.planes == BOTH:
            unknown = np.full((sizing.times.size, len(sizing.winds)), np.nan)
            autopilot_required = AutopilotRequirements(
                sizing.times, sizing.winds, unknown, reasons=(_IN_PLANES,)
            )
        elif requirements:
            autopilot_required = autopilot_requirements(
                sizing,
                self.sampled[self.plan.plane],
                self.request.winds(self.plan),
                rate_limit=self.plan.hardware["rate_limit"],
                sign=self.plan.sign,
                progress=progress,
            )
        bounds = [replace(MINIMUM, varying=counted.varying)]
        if not counted.varying:  # without a forecast only a frozen vehicle has a bound
            bounds.append(NO_FORECAST)
        labels = [counted.label]
        for bound in bounds:
            if bound in sizing.required and np.any(np.isfinite(sizing.at_times(bound))):
                labels.append(bound.label)
        use = deflection_use(sizing, flown.used, flown.limit, autopilot_required, labels)
        return replace(flown, use=use)

    @property
    def wind_notes(self) -> Iterator[str]:
        """Notes on the direction of pulses, on both planes, and on soundings by name."""
        pulses = self.request.pulse or self.request.others
        if pulses and self.plan.sign is None and self.plan.planes == "pitch":
            yield (
                "each pulse is flown as a head and as a tail wind, and the worse is shown (--set"
                " study.sign head, tail, or frozen: at nominal dynamic pressure)"
            )
        if self.plan.planes == BOTH:
            yield (
                "angles are magnitudes of the vectors of both planes, the deflection in the measure"
                " of the limit shape, the rate the larger of both"
            )
        for name, sounding in self.request.soundings.items():
            notes = sounding.profile.notes_along(self.flight)
            yield from (f"{name}: {note}" for note in notes)

    def _cases(self) -> Iterator[_Wind]:
        """Yield the winds in flight time: a pulse once for each flight time, where its peak is.

        A sounding is yielded once, or for each time of its gust if it has one. The flight through
        a pulse starts at its onset [s], or with the schedule.
        """
        times = self.request.times(self.plan).tolist()
        for name, wind in self.request.winds(self.plan).items():
            if isinstance(wind, MeasuredWind | MeasuredPlanes):
                for time in [None] if wind.gust is None else times:
                    yield _Wind(name, time, wind, gust_time=time, stop=self.request.stop)
                continue
            for time in times:
                vehicle = self.flight.at(time).rigid
                placed: History | PlaneWind
                if self.plan.planes == BOTH:
                    planes = place_vector(wind, vehicle, time)
                    placed = PlaneWind(**{plane: w.in_flight for plane, w in planes.items()})
                else:
                    placed = place(wind, vehicle, time).in_flight
                start = max(float(placed.onset), self.flight.span[0])
                yield _Wind(name, time, placed, start=start)

    def _directions(self, wind: FlownWind) -> tuple[str | None, ...]:
        """Return the directions in which a wind is flown: head and tail, or the one of the plan.

        None stands for the wind's own direction: that of a measured wind, and of a pulse in yaw or
        in both planes unless the plan has a sign.
        """
        if isinstance(wind, MeasuredWind | MeasuredPlanes):
            return (None,)
        head_and_tail = self.plan.sign is None and self.plan.planes == "pitch"
        return tuple(SIGNS) if head_and_tail else (self.plan.sign,)

    def _omitted(self, case: _Wind) -> str:
        """Return why survival in a wind `case` is not known throughout, in words; empty if it is.

        The flight may omit the structure of the vehicle; or go beyond a sounding, or cross its
        gaps, between the first and the last time of the sizing, by default of the flight.
        """
        if self.plan.omitted_structure or not isinstance(case.wind, MeasuredWind | MeasuredPlanes):
            return self.plan.omitted_structure  # empty in a pulse, which is known
        first, last = self.flight.span
        unknown = unknown_between(
            case.wind, _or_default(self.request.start, first), _or_default(self.request.stop, last)
        )
        return f"{unknown} (--set size.from_s, size.to_s)" if unknown else ""


def within_linear_range(flown: FlightAlong) -> FlightAlong:
    """Return the flight `flown` up to where attitude or angle of attack leaves the linear range.

    That is `MAX_LINEAR_ANGLE` [rad]; the first time beyond it is the last that is kept. A flight
    that stays within it, or begins beyond it, is returned unchanged.
    """
    angles = [np.abs(flown.outputs[name]) for name in ("attitude", "angle_of_attack")]
    beyond = np.flatnonzero(np.max(angles, axis=0) > MAX_LINEAR_ANGLE)
    if not beyond.size or beyond[0] < 1:
        return flown
    end = int(beyond[0]) + 1
    outputs = {name: values[:end] for name, values in flown.outputs.items()}
    return replace(flown, times=flown.times[:end], outputs=outputs)


def _or_default(value: float | None, default: float) -> float:
    """Return `value`, or `default` where it is None."""
    return default if value is None else value


class _Wind(NamedTuple):
    """Wind in flight time, its name, and the time of its peak or gust [s].

    `time` is None for a sounding without a gust. `start`: onset of a pulse [s], which is placed
    already, and whose flight goes on until it settles. `gust_time`, `stop`: time of the gust [s] of
    a sounding, and end of the flight [s], that of the sizing.
    """

    name: str
    time: float | None
    wind: FlownWind
    start: float | None = None
    gust_time: float | None = None
    stop: float | None = None


@dataclass(frozen=True)
class FlightOutcome(Record):
    """Outcome of a flight of the loop in a wind.

    Attributes
    ----------
    wind : str
        Name of the wind.
    time : float, optional
        Flight time of its peak, or of its gust [s].
    sign : str, optional
        Direction of a pulse, "head" or "tail"; or "frozen" at nominal dynamic pressure.
    status : str
        Status, as in `FlownCases`.
    survived : bool, optional
        Whether the flight is survived; None if that is not known.
    reason : str
        Meaning of the status, or why it is not known.
    peak_deflection, peak_deflection_rate, peak_angle_of_attack, peak_attitude : float
        Largest values [rad, rad/s].
    peak_time : float
        Time of the largest deflection [s].
    """

    wind: str = field(metadata=spec())
    time: float | None = field(metadata=spec("time", "peak at"))
    sign: str | None = field(metadata=spec())
    status: str = field(metadata=spec())
    survived: bool | None = field(metadata=spec())
    reason: str = field(metadata=spec())
    peak_deflection: float = field(metadata=spec("angle", "deflection"))
    peak_deflection_rate: float = field(metadata=spec("angular rate", "rate"))
    peak_angle_of_attack: float = field(metadata=spec("angle", "angle of attack"))
    peak_attitude: float = field(metadata=spec("angle"))
    peak_time: float = field(metadata=spec("time"))

    @classmethod
    def of(cls, case: _Wind, direction: str | None, flown: FlightAlong, omitted: str) -> Self:
        """Return the outcome of a flight `flown` through a wind in a direction.

        `case`: wind with its name. `direction`: "head", "tail", "frozen" for the nominal dynamic
        pressure, or None for the wind's own. `omitted`: part of the flight in which the wind is not
        known, in words; empty where it is known throughout. A flight with the status "lost"
        diverges, one that "rings" oscillates at its end; any other but "survived" is not known, as
        is survival beyond linear angles.
        """
        survived = {"survived": True, "lost": False, "rings": False}.get(flown.status)
        names = ("deflection", "deflection_rate", "angle_of_attack", "attitude")
        peaks = {f"peak_{name}": abs(flown.largest(name).value) for name in names}
        beyond = beyond_linear(float(np.abs(flown.outputs["wind"]).max()))
        beyond = beyond or beyond_linear(peaks["peak_angle_of_attack"], ATTACK)
        reason = flown.reason.removeprefix("NOT KNOWN: ")
        if survived and (omitted or beyond):
            survived, reason = None, omitted or beyond
        return cls(
            wind=case.name,
            time=case.time,
            sign=direction,
            status=flown.status,
            survived=survived,
            reason=reason,
            peak_time=flown.largest("deflection").time,
            **peaks,
        )

    @property
    @derived(label="wind", card=False, document=False)
    def label(self) -> str:
        """Name of the wind, its direction, and the time of its peak."""
        name = f"{self.wind}, {self.sign} wind," if self.sign in SIGNS else self.wind
        return name if self.time is None else f"{name} at {self.time:.4g} s"

    @property
    @derived(card=False, document=False)
    def outcome(self) -> str:
        """The outcome as a word: SURVIVED, NOT SURVIVED or NOT KNOWN."""
        return survival(self.survived)


def _severity(outcome: FlightOutcome) -> tuple[int, float]:
    """Return the key by which outcomes are ordered, the worst last.

    Survived precedes not known and not survived; then the largest deflection [rad] decides.
    """
    return {True: 0, None: 1, False: 2}[outcome.survived], outcome.peak_deflection


@dataclass(frozen=True, eq=False)
class FlightsOfLoop:
    """Flights of a loop along a flight, each through a wind.

    `outcomes`: of each wind. `worst`: the flight of the worst outcome, with its outputs over time.
    `limit`: deflection limit [rad]. `used`: largest deflection [rad] in the winds of each flight
    time of the sizing, ``(n,)``; NaN where one is not survived. `unstable_times`: flight times [s]
    of the sweep at which the loop, frozen there, has an unstable oscillation. `use`: required, used
    and remaining deflection, if a sizing gives the former.
    """

    outcomes: tuple[FlightOutcome, ...]
    worst: FlightAlong
    limit: float
    used: FloatArray
    unstable_times: FloatArray
    use: DeflectionUse | None = None

    @property
    def worst_outcome(self) -> FlightOutcome:
        """The outcome not survived, or else not known, with the largest deflection."""
        return max(self.outcomes, key=_severity)

    @property
    def survived(self) -> bool | None:
        """Whether every flight is survived; None if that is not known."""
        return self.worst_outcome.survived

    @property
    def notes(self) -> Iterator[str]:
        """Notes on unstable oscillations, diverged flights, and pulses too late to settle."""
        if self.unstable_times.size:
            at = flight_times(self.unstable_times.tolist())
            yield (
                f"frozen at {at} the loop has an unstable oscillation (tvclin margins): survived is"
                " a flight that has settled in the end"
            )
        if self.survived is False and self.worst.status == "lost":
            yield (
                "the largest values are until attitude or angle of attack exceed"
                f" {np.degrees(MAX_LINEAR_ANGLE):.0f} deg"
            )
        pulses = [(flown.time, flown.status) for flown in self.outcomes if flown.time is not None]
        late = [time for time, status in pulses if status == "undecided"]
        settled = [time for time, status in pulses if status != "undecided"]
        if settled and late and min(late) > max(settled):
            yield (
                "after the last pulses the flight is too short to settle: --set size.to_s"
                f" {max(settled):.6g} leaves them out"
            )

    @property
    def wind_count(self) -> int:
        """Number of winds, of which a pulse has its peak at several flight times."""
        return len({outcome.wind for outcome in self.outcomes})

    @property
    def _by_wind(self) -> list[bool | None]:
        """Whether each wind is survived at every flight time; None if that is not known."""
        return [*{x.wind: x.survived for x in sorted(self.outcomes, key=_severity)}.values()]

    @property
    def fraction(self) -> Success | None:
        """Fraction of the winds that are survived, with its interval; None for one wind.

        A wind of one shape must be survived at every flight time. None also if that is not known of
        a wind, which is then neither survived nor lost.
        """
        if self.wind_count < _MIN_WINDS or None in self._by_wind:
            return None
        return success_probability(self._by_wind.count(True), self.wind_count)

    def document(self) -> dict[str, Any]:
        """Return the flights and the largest outputs of the worst, in SI units, for JSON."""
        largest = {
            name: {"value": value, "unit": unit, "time_s": time}
            for name, unit in self.worst.units.items()
            for value, time in [self.worst.largest(name)]
        }
        return {
            "survived": self.survived,
            "verdict": self.verdict,
            "limit_deg": float(np.degrees(self.limit)),
            "fraction": self.fraction,
            "flights": self.outcomes,
            "worst": largest,
        }

    def _in_flights(self, survived: bool | None) -> str:
        """Return in how many flights, one for each wind and time, that is the outcome, in words."""
        flights = len(self.outcomes)
        of_all = plural(flights, "wind" if flights == self.wind_count else "flight")
        count = sum(outcome.survived is survived for outcome in self.outcomes)
        return f"in {of_all}" if self.survived else f"in {count} of {of_all}"

    @property
    def outcome(self) -> str:
        """The worst outcome, and in how many winds, in words."""
        return f"{survival(self.survived)} {self._in_flights(self.survived)}"

    @property
    def verdict(self) -> str:
        """Verdict on all flights, with `reason`."""
        return f"{survival(self.survived)} {self.reason}"

    @property
    def reason(self) -> str:
        """The limit, the worst flight, one that is not known, and the survived winds, in words."""
        worst = {outcome.survived: outcome for outcome in sorted(self.outcomes, key=_severity)}
        bad = [
            f"{self._in_flights(survived)}: {worst[survived].label}, {worst[survived].reason}"
            for survived in (False, None)
            if survived in worst
        ]
        largest, at = np.degrees(self.worst_outcome.peak_deflection), self.worst_outcome.peak_time
        good = f"{self._in_flights(True)}, largest deflection {largest:.3f} deg at {at:.4g} s"
        winds, fraction, not_known = self._by_wind, self.fraction, survival(None)
        words = f"with {np.degrees(self.limit):.3f} deg {f'; {not_known} '.join(bad) or good}"
        if len(winds) < _MIN_WINDS:
            return words
        share = text(fraction.line("survived")) if fraction else f"{winds.count(None)} {not_known}"
        return f"{words}; {winds.count(True)} of {len(winds)} winds survived, {share}"

    def table(self, rows: int | None = None) -> Table:
        """Return the table by wind: outcome and largest values; by default all winds.

        `rows`: largest number of rows, of the worst winds in their order.
        """
        shown = list(self.outcomes)
        if rows is not None and len(shown) > rows:
            most_severe = sorted(shown, key=_severity)[-rows:]
            shown = [outcome for outcome in shown if outcome in most_severe]
        names = ("peak_deflection", "peak_deflection_rate", "peak_angle_of_attack", "outcome")
        first = "label" if self.wind_count > 1 else "time"
        caption = "Largest values by wind"
        if len(shown) < len(self.outcomes):
            caption += f", the worst {len(shown)} of {len(self.outcomes)}"
        return record_table(caption, "flown", shown, first, *names)
