"""`tvclin autopilot`: required deflection of an autopilot in a wind, compared with trim."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees, inf, isfinite
from pathlib import Path
from typing import Any

from tvclin.base.errors import InputError
from tvclin.base.fields import document
from tvclin.base.lines import Row, quantities, significant
from tvclin.base.lines import degrees as angle
from tvclin.base.quantities import NOMINAL, REQUIREMENT, satisfaction, sufficiency
from tvclin.case.autopilot_assumptions import gain_notes
from tvclin.case.case import Case
from tvclin.cli.criteria import CriteriaOptions
from tvclin.cli.gains import GAINS, with_gains
from tvclin.cli.inputs import case_of, chosen, note_nominal_pressure, only_with
from tvclin.cli.margin_tables import MarginsFound, poles_document, print_autopilot, print_bounds
from tvclin.cli.options import (
    BOTH_LIMITS,
    GROUP,
    MOTION,
    STUDY,
    TIMING,
    At,
    Given,
    Rigid,
    Shown,
    Source,
    asked,
    switch,
)
from tvclin.cli.output import answer, print_tables, say, say_notes, say_required
from tvclin.cli.progress import waiting
from tvclin.cli.wind import WindOptions
from tvclin.control.autopilot.design_rules import LEAST_NOZZLE
from tvclin.control.comparison import (
    TrimComparison,
    WorstDuration,
    compare_with_trim,
    worst_duration,
)
from tvclin.control.margins.criteria import Criteria
from tvclin.design.gain_designs import minimum_gains, specified_autopilot
from tvclin.design.minimum_gains import MinimumGains
from tvclin.requirement.autopilot_requirement import AutopilotRequirement, autopilot_requirement
from tvclin.requirement.case_requirement import CaseRequirement, study_requirement
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.wind_angles import ATTACK, beyond_linear, linear_notes

_COMPARED = (
    *("peak_deflection", "peak_deflection_rate", "peak_angle_of_attack", "peak_attitude"),
    *("peak_flight_path_angle", "minimum", "wind_gain"),
)
"""Fields of a comparison with trim that JSON has."""
_DURATION_RATIOS = (1.0, 0.5, 2.0)
"""Durations of the winds, relative to the case; a single wind would be overfitted."""


@dataclass(frozen=True)
class LeastOptions:
    """Options of the search for gains; `grouped` gives them to a command."""

    least: bool = switch(
        "--least",
        "Find the gains that need the least deflection of all that meet the criteria: in"
        " the wind, and in winds half and twice as long.",
    )
    three_gains: bool = switch("--three-gains", "With --least: also feed back the angle of attack.")
    crossover: float | None = asked("With --least: highest gain crossover, in rad/s.")
    limits: bool = switch(
        "--limits", "With --least: find the least limit that flights survive, not the least peak."
    )
    stops: int | None = asked(
        "With --least --limits: number of sudden ends of each wind to survive as well.", shown="0"
    )

    panel = "Gains for the minimum deflection"

    def over(self, plan: StudyPlan) -> StudyPlan:
        """Return a plan whose design is this search, where --least is given."""
        if not self.least:
            only_with("--least", **vars(self))
            return plan
        crossover = chosen(self.crossover, plan.autopilot_design.crossover)
        design = with_gains(plan.autopilot_design, design=LEAST_NOZZLE, crossover=crossover)
        return replace(plan, design=design)

    def found(self, case: Case, criteria: Criteria) -> MinimumGains | None:
        """Return the gains for the minimum deflection; None without --least."""
        design, wind = case.autopilot_design, case.wind_in_plane
        if not self.least:
            return None
        if design.design != LEAST_NOZZLE:
            raise InputError("give --least, or gains and a rule for them, not both")
        if not isinstance(wind, ShapedWind):
            raise InputError(
                "gains for the minimum deflection are sought in pulses of three durations: give no"
                " --winds; with its gains tvclin autopilot and fly go through a sounding"
            )
        winds = [
            wind.history({"wind_duration": ratio * wind.duration}) for ratio in _DURATION_RATIOS
        ]
        return minimum_gains(
            case,
            winds,
            criteria,
            gains=("attitude", "rate", "alpha") if self.three_gains else ("attitude", "rate"),
            limits=self.limits,
            stops=self.stops or 0,
        )


def print_least(gains: MinimumGains) -> None:
    """Print the gains, the active constraints of the optimum, and notes."""
    print_tables(gains.table())
    say(f"Held by: {', '.join(gains.active) or 'no constraint, a flat minimum'}")
    say_notes(gains.notes)


_MIN_DURATION_RATIO, _MAX_DURATION_RATIO = 0.2, 8.0
"""Range of the search for the worst duration, over the duration of the given wind."""


def autopilot(
    vehicle: Source = "configuration-i",
    time: At = None,
    winds: WindOptions = GROUP,
    limits: Given = BOTH_LIMITS,
    gains: Given = GAINS,
    timing: Given = TIMING,
    criteria: CriteriaOptions = GROUP,
    least: LeastOptions = GROUP,
    rigid: Rigid = False,
    motion: Given = MOTION,
    sign: Given = Given(STUDY, ("sign",)),
    shown: Shown = GROUP,
) -> None:
    """Print what an autopilot requires in a wind, compared with trim and the boundaries.

    The autopilot requirement is the smallest limit from which on every limit survives, flown with
    samples, delay, actuator, filters, bending and rate limit. All else is at nominal dynamic
    pressure, without a limit.

    A vehicle file with bending, slosh, engine inertia or sensor lags makes a flexible vehicle:
    gains, margins and peaks are of that, boundaries and minimum of the rigid one. --rigid leaves
    all that out.

    --plot draws deflection and attitude of a stable loop; with --least, what a disk margin costs.

    Exit code 0: the criteria are MET, and the limit is SUFFICIENT or not given; 1: they are NOT
    MET, as of an unstable loop, the limit is NOT SUFFICIENT, or that is NOT KNOWN; 2: bad input.
    """
    changes = [options.over for options in (limits, timing, motion, sign, criteria, least, gains)]
    case = case_of(vehicle, *changes, wind=winds.over, told=("autopilot",), rigid=rigid, time=time)
    with waiting("seeking gains and the worst duration"):
        sought = least.found(case, case.held_to)
        wind = case.history
        loop_of = (
            specified_autopilot(case, wind, case.held_to) if sought is None else sought.autopilot
        )
        compared = compare_with_trim(case.plant, loop_of, wind)
        worst, need = _worst(compared, case.wind_in_plane), study_requirement(case)
        single_plane_case = replace(
            case, nozzle=replace(case.nozzle, limit_shape=None)
        )  # in this plane
        flown, reason = None, "the loop is not stable"
        if compared.margins.stable:
            try:
                flown = autopilot_requirement(
                    single_plane_case, case.plant, loop_of, study_requirement(single_plane_case)
                )
            except InputError as error:
                reason = str(error)
        result = _Answer(case, compared, worst, sought, need, flown, reason)
    if shown.plot is not None:
        with waiting("drawing"):
            result.draw(shown.plot)
    note_nominal_pressure(case)
    answer(shown.as_json, result.document, lambda: result.print(winds.title(case, "")), result.met)


@dataclass(frozen=True, eq=False)
class _Answer:
    """Required deflection of an autopilot in the wind of a case, and in the worst duration."""

    case: StudyPlan
    compared: TrimComparison
    worst: WorstDuration | None
    sought: MinimumGains | None
    need: CaseRequirement | None
    flown: AutopilotRequirement | None
    reason: str

    @property
    def limit(self) -> float | None:
        """The limit [deg] that is judged."""
        return None if self.case.nozzle.limit is None else degrees(self.case.nozzle.limit)

    @property
    def beyond(self) -> str:
        """Reason of `beyond_linear` why the answer is not known in this wind; empty if it is."""
        attack = self.compared.peak_angle_of_attack if self.compared.margins.stable else 0.0
        return beyond_linear(float(self.compared.wind.peak)) or beyond_linear(attack, ATTACK)

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the comparison, and on its wind angle and angle of attack."""
        attack = self.compared.peak_angle_of_attack if self.compared.margins.stable else 0.0
        angle = linear_notes(float(self.compared.wind.peak)) or linear_notes(attack, ATTACK)
        return (*angle, *self.compared.notes)

    @property
    def sufficient(self) -> bool | None:
        """Whether the limit is sufficient in this wind; None without one, and if not known.

        A loop that was not flown with its limits survives where it never reaches them.
        """
        limit, max_rate = self.case.nozzle.limit, self.case.nozzle.rate_limit or inf
        if limit is None or self.beyond:
            return None
        if self.flown is not None:
            return self.flown.sufficient(limit)
        within = self.compared.peak_deflection <= limit
        return True if within and self.compared.peak_deflection_rate <= max_rate else None

    @cached_property
    def criteria_satisfied(self) -> bool:
        """Whether the margins satisfy the criteria."""
        compared = self.compared
        return MarginsFound.of(compared.autopilot, compared.plant, self.case.held_to).met

    @cached_property
    def loop_notes(self) -> tuple[str, ...]:
        """Notes on gains that were not specified, and on gains that satisfy the criteria."""
        return tuple(gain_notes(self.case, self.case.held_to, self.criteria_satisfied))

    @property
    def met(self) -> bool:
        """Whether the loop is stable and satisfies criteria and limit."""
        sufficient = self.limit is None or self.sufficient
        return bool(self.compared.margins.stable and self.criteria_satisfied and sufficient)

    @property
    def loads(self) -> tuple[float, float]:
        """Normal force [N] and speed across [m/s]; NaN for a vehicle known by its coefficients."""
        vehicle, compared = self.case.vehicle, self.compared
        if not isinstance(vehicle, Vehicle):
            return float("nan"), float("nan")
        force = abs(float(vehicle.normal_force_slope)) * compared.peak_angle_of_attack
        return force, compared.peak_flight_path_angle * float(vehicle.velocity)

    def document(self) -> dict[str, Any]:
        """Return it for JSON."""
        compared, (force, across) = self.compared, self.loads
        return {
            "vehicle": self.case.vehicle.name,
            "model": self.case.plant.model,
            "plane": self.case.plane,
            "autopilot": compared.autopilot,
            **poles_document(compared.autopilot, compared.plant),
            "wind_peak_deg": degrees(compared.wind.peak),
            "stable": compared.margins.stable,
            **document(compared, *_COMPARED),
            "part_of_trim": compared.ratio_to_trim,
            "peak_normal_force_N": force,
            "peak_lateral_speed_m_s": across,
            "trim_deg": degrees(compared.trim_deflection),
            "boundaries_deg": {f"{K:g}": degrees(y) for K, y in compared.boundaries.items()},
            "worst_duration": self.worst,
            "criteria": self._criteria_document(),
            "limit_deg": self.limit,
            "autopilot_requirement_deg": self.flown and degrees(self.flown.deflection),
            "autopilot_requirement_nominal_deg": self.flown
            and degrees(self.flown.nominal_deflection),
            "required_deflection_deg": self.need and degrees(self.need.required_deflection),
            "sufficient": self.sufficient,
            "met": self.met,
            "notes": (*self.notes, *self.loop_notes),
            **({} if self.sought is None else {"least": self.sought}),
        }

    def _criteria_document(self) -> dict[str, Any]:
        """Return name, limits and verdict of the criteria, for JSON."""
        criteria = self.case.held_to
        return {"name": criteria.name, "limits": criteria.limits, "met": self.criteria_satisfied}

    def print(self, title: str) -> None:
        """Print the autopilot, its requirement and the verdict, and the search for its gains."""
        compared = self.compared
        print_autopilot(title, compared.autopilot, compared.plant)
        if compared.margins.stable:
            stop = None if self.flown is None else self.flown.nominal_deflection
            print_tables(compared.deflections(f"Deflection in this wind, {NOMINAL}", stop))
            print_tables(quantities("In this wind", [*compared.motions(), *self._more()]))
            print_bounds(compared.autopilot, compared.plant)
            say_notes(self.notes)
            self._judge()
        else:
            say(f"NO NUMBERS: {compared.margins.reason}")
        say_notes(self.loop_notes)
        if self.sought is not None:
            print_least(self.sought)

    def _judge(self) -> None:
        """Print the verdicts on criteria and limit, with the autopilot requirement."""
        word = satisfaction(self.criteria_satisfied)
        more = "" if self.criteria_satisfied else " (tvclin margins says by how much)"
        say(f"Criteria {self.case.held_to.name}: {word}{more} ({self.case.held_to.description})")
        say(f"{REQUIREMENT[0].upper()}{REQUIREMENT[1:]}: {self._requirement}.")
        say_required(self.need)
        if self.limit is None:
            return
        word, worst = sufficiency(self.sufficient), self.worst
        if self.sufficient is None:
            word += f": {self.beyond}" if self.beyond else ", above the nominal requirement alone"
        elif worst is not None and self.sufficient and self.limit < degrees(worst.peak_deflection):
            uses = f"{degrees(worst.peak_deflection):.3f} deg in one of {worst.duration:.3g} s"
            word += f" in this wind; without a limit it uses {uses}"
        say(f"Limit {self.limit:g} deg: {word}")

    @property
    def _requirement(self) -> str:
        """Sentence on the autopilot requirement, and on the peak deflection without a limit."""
        uses = f"without a limit it uses {degrees(self.compared.peak_deflection):.3f} deg"
        if self.flown is None or self.beyond:
            return f"{sufficiency(None)}: {self.beyond or self.reason}; {uses} {NOMINAL}"
        if not isfinite(self.flown.nominal_deflection):
            return f"it survives at no limit that was tried; {uses} {NOMINAL}"
        nominal = f"{degrees(self.flown.nominal_deflection):.3f} deg {NOMINAL}, where {uses}"
        if self.flown.head is None:
            return nominal
        bound = degrees(self.flown.deflection)
        wind = "" if self.need is None else self.need.direction
        head = f"{bound:.3f} deg at the dynamic pressure of the peak of a {wind} wind throughout"
        return f"{head}; {nominal}"

    def _more(self) -> Iterator[Row]:
        """Yield the loads, which take a complete vehicle, and the worst duration of the wind."""
        (force, across), worst = self.loads, self.worst
        if isfinite(force):
            yield (
                "N times the angle of attack",
                significant("wind.normal_force", force, 4, "N"),
            )
        if isfinite(across):
            yield "drift across", significant("wind.lateral_speed", across, 4, "m/s")
        if worst is not None:
            end = ", an end of the range tried" * worst.at_range_end
            asks = angle("wind.worst", worst.peak_deflection, unit="deg")
            yield "worst duration", (f"{worst.duration:.3g} s, ", *asks, end)

    def draw(self, plot: Path) -> None:
        """Draw the front of the disk margin, where gains were sought, or else a stable response."""
        from tvclin import plots

        if self.sought is not None:
            from tvclin.design.gain_designs import gain_trade_off

            plots.save_figure(plots.gain_trade_off_chart([gain_trade_off(self.sought)]), plot)
        elif self.compared.margins.stable:
            plots.save_figure(plots.comparison_chart(self.compared), plot)
        else:
            said = "an unstable loop has no response to draw"
            say(f"No figure is written to {plot}: {said}.", err=True)


def _worst(compared: TrimComparison, wind: Any) -> WorstDuration | None:
    """Return the worst duration of a pulse; None for a sounding, or an unstable loop."""
    if not isinstance(wind, ShapedWind) or not compared.margins.stable or not wind.peak:
        return None
    return worst_duration(
        compared.plant,
        replace(compared.autopilot, sample_rate=None),
        peak=wind.peak,
        shortest=_MIN_DURATION_RATIO * wind.duration,
        longest=_MAX_DURATION_RATIO * wind.duration,
        shape=lambda peak, duration: wind.history({"wind_peak": peak, "wind_duration": duration}),
    )
