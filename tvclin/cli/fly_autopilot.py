"""`tvclin fly --engine linear`: a sampled law with the nozzle's limits, in the linear model.

With --law autopilot also its required deflection, and the comparison with trim.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees, inf, isfinite
from typing import Any

import numpy as np

from tvclin.ascent.wind_along import SoundingWind
from tvclin.base.errors import InputError
from tvclin.base.fields import document
from tvclin.base.lines import Row, quantities, significant
from tvclin.base.lines import degrees as angle
from tvclin.base.quantities import (
    NO_LIMIT,
    NOMINAL,
    REQUIREMENT,
    satisfaction,
    sufficiency,
    survival,
)
from tvclin.case.flexible_autopilot import gain_notes, with_filters
from tvclin.cli.flight_cases import (
    FROZEN_VEHICLE,
    LIMIT_OVER_BOUNDARY,
    MAX_LIMIT_OVER_TRIM,
    REPORT,
    Compared,
    Flying,
    flight_title,
)
from tvclin.cli.inputs import note_nominal_pressure
from tvclin.cli.margins import (
    parts_line,
    poles_document,
    print_autopilot,
    print_bounds,
    print_parts,
)
from tvclin.cli.options import ShownCurves
from tvclin.cli.output import print_answer, print_json, print_tables, say
from tvclin.cli.wind import wind_direction
from tvclin.control.autopilot.judged_margins import JudgedMargins
from tvclin.control.comparison import (
    TrimComparison,
    WorstDuration,
    compare_with_trim,
    worst_duration,
)
from tvclin.control.laws.law import Law
from tvclin.design.gain_designs import specified_autopilot
from tvclin.flights.closed_loop.fly_many import NOT_KNOWN, OUTCOME_WORDS
from tvclin.flights.closed_loop.survival_limit import ClosedLoopBoundary, closed_loop_boundary
from tvclin.flights.theory_comparison import SampledFlight, fly_sampled
from tvclin.linear.flexible import AnyPlant
from tvclin.requirement.autopilot_requirement import AutopilotRequirement, autopilot_requirement
from tvclin.requirement.case_requirement import CaseRequirement, study_requirement
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.wind_angles import ATTACK, beyond_linear, linear_notes

LINEAR = "linear"
"""Name of the engine."""


@dataclass(frozen=True, eq=False)
class LinearCase(Flying):
    """A flight by the linear engine, in steps.

    `plan`, `wind`, `law`: plan, its wind and the name of the law.
    """

    engine = LINEAR

    @property
    def plant(self) -> AnyPlant:
        """The plant of the case, flexible if the vehicle has a structure; it is flown."""
        return self.plan.plant

    @property
    def is_flexible(self) -> bool:
        """Whether the vehicle of the case has a structure: bending or slosh modes."""
        return self.plan.vehicle.structure is not None

    @cached_property
    def control(self) -> Law:
        """Control law of --law for the rigid plant, with the filters of the case.

        `InputError` for the report's law, which --engine planar and sixdof alone fly.
        """
        if self.law == REPORT:
            raise InputError(
                f"--law {REPORT} has no actuator and no samples: fly it by --engine planar or"
                " sixdof, or give --law trim"
            )
        chosen = self.designed(self.plant.rigid)
        assert isinstance(chosen, Law)
        return with_filters(chosen, self.plan.autopilot_design)

    @property
    def title(self) -> str:
        """Lines on the vehicle, the wind, the equations and the law."""
        structure = self.plan.vehicle.structure
        servo, delay = self.plan.nozzle.actuator, 1000.0 * self.plan.autopilot_design.delay
        rate = self.plan.hardware["sample_rate"]
        with_servo = f"{servo.natural_frequency:g} rad/s" if servo else "none"
        title_lines = [
            flight_title(self),
            *([parts_line(structure)] if structure else []),
            f"linear equations, {self.plant.model}, {NOMINAL}; law at {rate:g} Hz,"
            f" delay {delay:g} ms, actuator {with_servo}",
        ]
        return "\n".join(title_lines)


def limited_law(case: StudyPlan, name: str) -> Law:
    """Return the law of a case with the name of --law; `InputError` without a deflection limit."""
    if case.nozzle.limit is None:
        raise InputError("--law needs --limit-deg, the deflection limit of the nozzle")
    # the control does not depend on the name of the wind; without a dead band the law has its own
    return LinearCase(case, shape="", law=name, dead_band=None).control


def fly_linear(case: LinearCase, boundary: bool, times: Any) -> Compared:
    """Return the flight of a case; the default limit is `LIMIT_OVER_BOUNDARY` times the boundary.

    `boundary`: whether the boundary is sought for a given limit too. `times`: times of the flight
    [s], ``(n,)``. A flexible vehicle has two boundaries, its own and that of the rigid vehicle:
    the smallest limits that survive the wind, sought up to `MAX_LIMIT_OVER_TRIM` times trim.
    `InputError` without a finite boundary and without a limit.
    """
    boundaries = None
    limit = case.plan.nozzle.limit
    if limit is None or boundary:
        plants = (case.plant, case.plant.rigid) if case.is_flexible else (case.plant,)
        search = {"highest": MAX_LIMIT_OVER_TRIM, **case.plan.hardware}
        boundaries = tuple(
            closed_loop_boundary(plant, case.control, case.wind, **search) for plant in plants
        )
    if limit is None:
        assert boundaries is not None
        limit = LIMIT_OVER_BOUNDARY * abs(boundaries[0].deflection)
        if not np.isfinite(limit):
            raise InputError(f"{boundaries[0].status}: give --limit-deg, or another law")
    flight = fly_sampled(
        case.plant, case.control, case.wind, times, deflection_limit=limit, **case.plan.hardware
    )
    if case.plan.unknown_wind:
        flight = flight.in_unknown_wind()
    return _compared(case, limit, flight, boundaries)


def _compared(
    case: LinearCase,
    limit: float,
    flight: SampledFlight,
    boundaries: tuple[ClosedLoopBoundary, ...] | None,
) -> Compared:
    """Return flight and boundaries, if any, of a flexible vehicle compared with the rigid one's.

    `limit`: deflection limit [rad] of the flight. `boundaries`: of the flown vehicle and, where it
    is flexible, of the rigid one, in this order, as the two statuses and peak rates of the flight.
    """
    labels, rates = ("flown", "rigid"), np.degrees(flight.peak_rates).tolist()
    flown_status, rigid_status = flight.status
    rate = case.plan.nozzle.rate_limit
    ending = f"; rigid: {_word(rigid_status)}" if case.is_flexible else ""
    size = f"{np.degrees(limit):.3f} deg"
    sizes = [abs(boundary.deflection) for boundary in boundaries or ()]
    rate_text = "" if rate is None else f", rate limit {np.degrees(rate):.3f} deg/s"
    of_limit = f"; {case.plant.model}, limit {size}{rate_text}"
    return Compared(
        flying=case,
        flight=flight,
        limit=limit,
        reference="rigid",
        columns=("flexible", "rigid") if case.is_flexible else ("flown",),
        boundary=(sizes[0], sizes[-1]) if sizes else None,
        setting_lines=[case.title],
        verdict=f"{_word(flown_status)} with {size} {NOMINAL}, {FROZEN_VEHICLE}{ending}"
        f"{case.unknown_suffix}",
        flight_notes=tuple(_flight_notes(case, flight, boundaries or ())),
        title=f"{flight_title(case)}{of_limit}".replace("\n", ": "),
        facts={
            "flexible": case.is_flexible,
            "linear_model": case.plant.model,
            "sample_rate_Hz": case.plan.hardware["sample_rate"],
            "rate_limit_deg_per_s": None if rate is None else float(np.degrees(rate)),
            "delay_s": case.plan.autopilot_design.delay,
            "status": dict(zip(labels, flight.status, strict=True)),
            "peak_deflection_rate_deg_s": dict(zip(labels, rates, strict=True)),
        },
    )


def _flight_notes(
    case: LinearCase, flight: SampledFlight, boundaries: Iterable[ClosedLoopBoundary]
) -> Iterator[str]:
    """Yield notes on an oscillation of the nozzle, and on boundaries that are not exact.

    `boundaries`: of the flexible and of the rigid vehicle, or of the rigid one alone; empty where
    they were not sought.
    """
    if "rings" in flight.status:  # the status of a limit cycle
        yield RINGS_MEANS
    names = ("flexible", "rigid") if case.is_flexible else ("rigid",)
    for name, boundary in zip(names, boundaries, strict=False):
        if boundary.status != "ok":
            yield f"boundary, {name}: {boundary.status}"


RINGS_MEANS = (
    "limit cycle: the vehicle is brought back, and the nozzle keeps oscillating: an oscillation of"
    " the loop, mostly of bending or slosh, grows near rest or persists between the limits"
)


def _word(status: str) -> str:
    """Return the outcome of a flight in words, from its `FlownCases.status`.

    A status other than survived, lost and limit cycle is explained.
    """
    if status == NOT_KNOWN:
        return survival(None)
    detail = {"survived": "", "lost": "", "rings": ", limit cycle"}.get(
        status, f", the vehicle {OUTCOME_WORDS[status]}"
    )
    return f"{survival(status == 'survived')}{detail}"


_COMPARED = (
    *("peak_deflection", "peak_deflection_rate", "peak_angle_of_attack", "peak_attitude"),
    *("peak_flight_path_angle", "minimum", "wind_gain", "part_of_trim", "steady_drift_rate"),
)
"""Fields of a comparison with trim that JSON has."""
_MIN_DURATION_RATIO, _MAX_DURATION_RATIO = 0.2, 8.0
"""Range of the search for the worst duration, over the duration of the given wind."""


def fly_autopilot(linear: LinearCase, more: bool, times: Any) -> "AutopilotFlight":
    """Return the flight of an autopilot, where its loop or a limit allows one, and its requirement.

    Without a limit the flight needs a requirement that is known; `reason` says why it is not.
    `linear`: case, wind and law. `more`: whether boundaries are sought for a given limit too.
    `times`: times of the flight [s], ``(n,)``.
    """
    case = linear.plan
    autopilot = specified_autopilot(case, case.history, criteria=case.margin_criteria)
    compared = compare_with_trim(case.plant, autopilot, case.history)
    # without a limit shape the requirement is that of this plane alone
    single_plane_case = replace(case, nozzle=replace(case.nozzle, limit_shape=None))
    requirement, reason = None, "the loop is not stable"
    if compared.margins.stable:
        try:
            need = study_requirement(single_plane_case, case.dead_band)
            requirement = autopilot_requirement(single_plane_case, case.plant, autopilot, need)
        except InputError as error:
            reason = str(error)
    flight = None
    if case.nozzle.limit is not None or (
        requirement is not None and isfinite(requirement.nominal_deflection)
    ):
        flight = fly_linear(linear, more, times)
    note_nominal_pressure(case)
    return AutopilotFlight(
        linear=linear,
        compared=compared,
        worst=_worst_duration(compared, case.wind_in_plane),
        required=study_requirement(case, case.dead_band),
        requirement=requirement,
        reason=reason,
        flight=flight,
    )


@dataclass(frozen=True, eq=False)
class AutopilotFlight:
    """Required deflection of an autopilot in the wind of a case, and its flight with a limit.

    `linear`: case and law of the flight. `compared`: autopilot compared with the control that
    trims, without limits. `worst`: duration of the wind that requires most, None if not sought.
    `required`: requirement of the study, of any control. `requirement`: requirement of the
    autopilot, None where it is not known, for a `reason`. `flight`: None without a limit to fly.
    """

    linear: LinearCase
    compared: TrimComparison
    worst: WorstDuration | None
    required: CaseRequirement | None
    requirement: AutopilotRequirement | None
    reason: str
    flight: Compared | None

    @property
    def case(self) -> StudyPlan:
        """The case: vehicle, wind, nozzle and autopilot."""
        return self.linear.plan

    @property
    def limit(self) -> float | None:
        """The deflection limit [deg] that is judged; None without one."""
        return None if self.case.nozzle.limit is None else degrees(self.case.nozzle.limit)

    @property
    def unknown_reason(self) -> str:
        """Reason why the linear theory gives no answer in this wind; empty if it does.

        It is the wind angle, or else the largest angle of attack of the autopilot without limits,
        which counts only where its loop is stable.
        """
        attack = self.compared.peak_angle_of_attack if self.compared.margins.stable else 0.0
        return beyond_linear(float(self.compared.wind.peak)) or beyond_linear(attack, ATTACK)

    @property
    def direction(self) -> str:
        """The direction of the wind that sets the requirement: head, tail or cross."""
        return wind_direction(self.case) if self.required is None else self.required.direction

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the wind angle and angle of attack, the loop, the flight and the gains."""
        attack = self.compared.peak_angle_of_attack if self.compared.margins.stable else 0.0
        angle = linear_notes(float(self.compared.wind.peak)) or linear_notes(attack, ATTACK)
        delay, satisfied = self.compared.margins.delay_margin, self.criteria_satisfied
        gains = gain_notes(self.case, self.case.margin_criteria, satisfied, delay)
        flight_notes = () if self.flight is None else self.flight.flight_notes
        loop = self.compared.notes if self.compared.margins.stable else ()
        return (*angle, *loop, *flight_notes, *gains)

    @property
    def sufficient(self) -> bool | None:
        """Whether the limit is sufficient in this wind; None without one, and if not known.

        The flight and the requirement of the autopilot decide, in a wind that is known. Without
        them the linear loop of `compared` does, which survives where it never reaches its limits.
        """
        limit, max_rate = self.case.nozzle.limit, self.case.nozzle.rate_limit or inf
        if limit is None or self.unknown_reason:
            return None
        if self.flight is not None and self.flight.flight.survived is False:
            return False
        if self.requirement is not None:
            sufficient = self.requirement.sufficient(limit)
            return None if sufficient and self.case.unknown_wind else sufficient
        if self.case.unknown_wind:
            return None
        within = self.compared.peak_deflection <= limit
        return True if within and self.compared.peak_deflection_rate <= max_rate else None

    @cached_property
    def criteria_satisfied(self) -> bool:
        """Whether the margins of the autopilot satisfy the criteria `case.margin_criteria`."""
        compared, criteria = self.compared, self.case.margin_criteria
        return JudgedMargins.of(compared.autopilot, compared.plant, criteria).satisfied

    @property
    def peak_force_and_lateral_speed(self) -> tuple[float, float]:
        """Peak normal force [N] and peak speed across the nominal path [m/s], without limits.

        NaN for a vehicle known by its coefficients.
        """
        vehicle, compared = self.case.vehicle, self.compared
        if not isinstance(vehicle, Vehicle):
            return float("nan"), float("nan")
        force = abs(float(vehicle.normal_force_slope)) * compared.peak_angle_of_attack
        return force, compared.peak_flight_path_angle * float(vehicle.velocity)

    def document(self) -> dict[str, Any]:
        """Return the flight, the requirement and the comparison with trim, for JSON.

        Without a flight, its first keys stand with `null` in place of limit and survival.
        """
        case, requirement = self.case, self.requirement
        flight = {
            "vehicle": case.vehicle.name,
            "engine": self.linear.engine,
            "plane": case.plane,
            "law": self.linear.law,
            "limit_deg": None,
            "survived": None,
            "required_deflection_deg": self.required and degrees(self.required.known_deflection),
        }
        return {
            **(flight if self.flight is None else self.flight.document()),
            "autopilot_requirement_deg": requirement and degrees(requirement.deflection),
            "autopilot_requirement_nominal_deg": requirement
            and degrees(requirement.nominal_deflection),
            "sufficient": self.sufficient,
            "comparison": self._comparison(),
            "notes": self.notes,
        }

    def _comparison(self) -> dict[str, Any]:
        """Return the autopilot without a limit, compared with trim and the boundaries, for JSON.

        Beside its fields: peak normal force [N] and speed across the path [m/s] without limits, the
        boundaries by dead band K, and the worst duration of the wind.
        """
        compared, (force, across) = self.compared, self.peak_force_and_lateral_speed
        criteria = self.case.margin_criteria
        return {
            "model": self.case.plant.model,
            "autopilot": compared.autopilot,
            **poles_document(compared.autopilot, compared.plant),
            "wind_peak_deg": degrees(compared.wind.peak),
            "stable": compared.margins.stable,
            **document(compared, *_COMPARED),
            "peak_normal_force_N": force,
            "peak_lateral_speed_m_s": across,
            "trim_deg": degrees(compared.trim_deflection),
            "boundaries_deg": {f"{K:g}": degrees(y) for K, y in compared.boundaries.items()},
            "worst_duration": self.worst,
            "criteria": {
                "name": criteria.name,
                "limits": criteria.limits,
                "satisfied": self.criteria_satisfied,
            },
        }

    def show(self, shown: ShownCurves, more: bool) -> bool:
        """Write and print the answer; return whether the limit survives, and is sufficient."""
        if self.flight is not None:
            self.flight.write(shown)
        elif shown.csv or shown.plot:
            say("No file is written: an unstable loop has no flight to draw.", err=True)
        if shown.as_json:
            print_json(self.document())
        else:
            self._print(more)
        survived = self.flight is not None and self.flight.flight.survived
        return bool(survived and (self.limit is None or self.sufficient))

    def _print(self, more: bool) -> None:
        """Print the verdict, the flight with a limit or else the deflections, and notes.

        `more`: whether the details are printed, and all notes. With a limit the verdict is on that,
        and the flight comes first; without one it is the autopilot requirement, and the comparison
        of the loop with trim comes first. An unstable loop is not compared.
        """
        tables = []
        if self.compared.margins.stable:
            nominal = None if self.requirement is None else self.requirement.nominal_deflection
            model = self.case.plant.model
            title = f"{flight_title(self.linear)}; {model}, {NOMINAL}".replace("\n", ": ")
            tables.append(self.compared.deflections(title, nominal))
        if self.flight is not None:
            tables.insert(0 if self.limit is not None else 1, self.flight.table())
        requirement, notes = f"{REQUIREMENT}: {self._requirement}", [*self._judged(), *self.notes]
        verdict = requirement
        if self.limit is not None:
            verdict, notes = self._verdict, [requirement, *notes]
            if not more:  # the deflections, of which these notes are, are below the flight
                notes = [note for note in notes if note not in self.compared.notes]

        def details() -> None:
            """Print the remaining `tables`, and what stands below them."""
            print_tables(*tables[1:])
            self._print_details()

        print_answer(verdict, *tables[:1], notes=notes, more=more, details=details)

    def _print_details(self) -> None:
        """Print vehicle, wind and control of the flight, the autopilot, and a stable loop's motion.

        The motion is without a limit; an unstable loop has neither motion nor bounds.
        """
        stable = self.compared.margins.stable
        if stable:
            uses = f"{degrees(self.compared.peak_deflection):.3f} deg without a limit"
            say(f"In this wind the autopilot uses {uses}.")
            rows = [*self.compared.motions(), *self._further_rows()]
            print_tables(quantities("In this wind", rows))
        if self.flight is None:
            print_parts(self.compared.plant)
        else:
            for line in self.flight.setting_lines:  # with the parts of a flexible vehicle
                say(line)
        print_autopilot("Autopilot", self.compared.autopilot, self.compared.plant)
        if stable:
            print_bounds(self.compared.autopilot, self.compared.plant)

    def _judged(self) -> Iterator[str]:
        """Yield notes on criteria that are not satisfied, and on the required deflection.

        The criteria of an unstable loop are not mentioned: the requirement says that it is one.
        """
        if self.compared.margins.stable and not self.criteria_satisfied:
            word, name = satisfaction(self.criteria_satisfied), self.case.margin_criteria.name
            yield f"criteria {name}: {word} (tvclin margins says by how much)"
        if self.required is not None:
            yield f"{self.required.see_study}: for the ideal trim law"

    @property
    def _verdict(self) -> str:
        """The verdict on the limit, and the outcome of its flight.

        NOT KNOWN has its reason: the requirement is known at nominal dynamic pressure (`NOMINAL`),
        and in a head wind (`head`) or not; else the wind is beyond the linear range, or unknown. A
        sufficient limit is compared with the deflection in the wind `worst`, of the same shape and
        peak and of the duration that requires most; None if it is not sought.
        """
        word, worst, limit = sufficiency(self.sufficient), self.worst, self.limit or 0.0
        if self.sufficient is None:
            reason = self.reason
            if self.requirement is not None:
                wind = "this wind" if self._is_measured else f"a {self.direction} wind"
                bound = f"and below the bound for {wind}"
                known = self.requirement.head is not None
                reason = f"sufficient {NOMINAL}, {bound if known else 'not known at another'}"
            reason = self.unknown_reason or self.case.unknown_wind or reason
            if self.flight is None or reason not in self.flight.verdict:
                word += f", {reason}"
        elif worst is not None and self.sufficient and limit < degrees(worst.peak_deflection):
            uses = f"{degrees(worst.peak_deflection):.3f} deg in a wind of {worst.duration:.3g} s"
            word += f" in this wind; without a limit the autopilot uses {uses}"
        if self.flight is None:
            return f"limit {limit:g} deg: {word}"
        if self.sufficient is False and self.flight.flight.survived:
            word += ", a larger limit is lost; this flight"
        else:
            word += ";"
        return f"limit {limit:g} deg: {word} {self.flight.verdict}"

    @property
    def _requirement(self) -> str:
        """The autopilot requirement, at the pressure of a head wind and at nominal pressure.

        `head` is its boundary at the peak pressure, None without one. NOT KNOWN for an unstable
        loop, and where flights cannot decide.
        """
        if not self.compared.margins.stable:
            return f"{sufficiency(None)}, {self.compared.margins.reason}"
        if self.requirement is None or self.unknown_reason:
            return f"{sufficiency(None)}: {self.unknown_reason or self.reason}"
        if not isfinite(self.requirement.nominal_deflection):
            return f"{NO_LIMIT}, {NOMINAL}"
        nominal = f"{degrees(self.requirement.nominal_deflection):.3f} deg"
        if self.requirement.head is None:
            counted = self._is_measured and self.case.sign is None
            below = counted and not self.requirement.head_counts
            return f"{nominal} {NOMINAL}{', the largest in this wind' if below else ''}"
        deflection = self.requirement.deflection
        bound = f"{degrees(deflection):.3f} deg" if isfinite(deflection) else NO_LIMIT
        peak = f"the peak pressure of a {self.direction} wind"
        where = "the largest pressure in this wind" if self._is_measured else peak
        return f"{bound} at {where}, {nominal} at nominal"

    @property
    def _is_measured(self) -> bool:
        """Whether the wind is a sounding, whose largest pressure need not be at its peak."""
        return isinstance(self.case.wind, SoundingWind)

    def _further_rows(self) -> Iterator[Row]:
        """Yield rows (label, number) of the loads in the wind, and of its worst duration.

        A vehicle known by its coefficients has no loads: they are NaN, and have no row.
        """
        (force, across), worst = self.peak_force_and_lateral_speed, self.worst
        if isfinite(force):
            number = significant("wind.normal_force", force, 4, "N")
            yield "N times the angle of attack", number
        if isfinite(across):
            yield "drift across", significant("wind.lateral_speed", across, 4, "m/s")
        if worst is not None:
            end = ", an end of the range tried" if worst.at_range_end else ""
            deflection = angle("wind.worst", worst.peak_deflection, unit="deg")
            yield "worst duration", (f"{worst.duration:.3g} s, ", *deflection, end)


def _worst_duration(compared: TrimComparison, wind: Any) -> WorstDuration | None:
    """Return the duration of a pulse with the largest deflection of an autopilot.

    `compared`: the autopilot in the wind, compared with ideal trim. None for a sounding, and for an
    unstable loop.
    """
    if not isinstance(wind, ShapedWind) or not compared.margins.stable or not wind.peak:
        return None
    return worst_duration(
        compared.plant,
        compared.autopilot.continuous,
        peak=wind.peak,
        shortest=_MIN_DURATION_RATIO * wind.duration,
        longest=_MAX_DURATION_RATIO * wind.duration,
        shape=lambda peak, duration: wind.history({"wind_peak": peak, "wind_duration": duration}),
    )
