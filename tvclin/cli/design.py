"""`tvclin design`: gains by rules, gains for the minimum deflection, and their worst case."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import degrees, nan
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tvclin.base.cards import Record
from tvclin.base.errors import InputError
from tvclin.base.fields import Field, record_table, spec, specs
from tvclin.base.lines import listed
from tvclin.base.quantities import satisfaction
from tvclin.base.tables import check_known
from tvclin.case.flexible_autopilot import gain_notes, satisfying_rule
from tvclin.cli.inputs import case_of, chosen, only_with
from tvclin.cli.margins import (
    margin_tables,
    margins_document,
    mode_notes,
    print_autopilot,
    print_bounds,
    print_parts,
)
from tvclin.cli.options import (
    GAINS,
    GROUP,
    MODEL_AND_PLANE,
    TIMING,
    At,
    More,
    Options,
    Shown,
    Source,
    option,
    switch,
    with_gains,
)
from tvclin.cli.output import answer, draw, print_answer, print_tables, say, waiting
from tvclin.cli.wind import WindOptions, wind_words
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.design_rules import DESIGNS, LEAST_NOZZLE, POLE_PLACEMENT_RULES
from tvclin.control.autopilot.judged_margins import JudgedMargins
from tvclin.control.margins.criteria import Criteria
from tvclin.design.gain_designs import gain_trade_off, minimum_gains, specified_autopilot
from tvclin.design.minimum_gains import PEAK, MinimumGains, UnsatisfiedCriteriaError
from tvclin.design.worst_case import BOX_TABLE, WorstCase, unit_of, worst_case
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.linear_vehicle import complete_vehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.shaped import ShapedWind

if TYPE_CHECKING:
    from control import ControlPlot

Box = Annotated[
    list[str] | None,
    typer.Option(
        "--box",
        metavar="KEY=LO..HI",
        help="A number that may lie anywhere between two values, as delay_ms=0..40 or"
        " thrust_kN=2400..2600: a key with its unit, as in a vehicle file. Or in percent of the"
        " nominal value, without a unit: thrust=-3%..3%. May be given several times. Keys: those"
        " of a vehicle, wind_peak, wind_duration, the gains, gain (a factor on all gains), delay,"
        " actuator_frequency and actuator_damping.",
    ),
]
_DURATION_RATIOS = (1.0, 0.5, 2.0)
"""Durations of the winds, relative to the case; a single wind would be overfitted."""
_FREQUENCY_RATIO = 2.0
"""Natural frequency of rules that place poles, over the unstable pole, if none is given."""


@dataclass(frozen=True, eq=False)
class BoxResult:
    """The worst case in a box, and the criteria of its margins.

    `omitted`: part of the vehicle that is not in the box, as "structure"; empty without one.
    """

    worst: WorstCase
    criteria: Criteria
    omitted: str

    @property
    def satisfied(self) -> bool | None:
        """Whether the loop is stable and its margins satisfy the criteria throughout the box.

        The box: numbers that may lie anywhere between two values. None where that is `unknown`.
        """
        if not self.worst.stable or any(
            self.worst.margins[criterion.margin].value < criterion.limit
            for criterion in self.criteria.limits
            if criterion.margin in self.worst.margins
        ):
            return False
        return None if self.unknown else True

    @property
    def unknown(self) -> str:
        """Reason why criteria that the computed margins satisfy may not be; empty without one."""
        if self.omitted:
            return f"the vehicle in the box is without its {self.omitted}"
        names = [
            limit.name for limit in self.criteria.limits if limit.margin not in self.worst.margins
        ]
        return f"no {listed(names)} is computed in a box" if names else ""

    def as_dict(self) -> dict[str, Any]:
        """Return the worst case in the box, and whether it satisfies the criteria, for JSON."""
        return self.worst.as_dict() | {"satisfied": self.satisfied}

    @property
    def verdict(self) -> str:
        """Verdict on the criteria in the box, with the worst disk margin and its position.

        The position is the value of each number of the box, with its unit.
        """
        disk = self.worst.margins["disk_margin"]
        at = ", ".join(f"{k} = {v:.5g} {unit_of(k)}".rstrip() for k, v in disk.at.items())
        word = satisfaction(self.satisfied)
        why = f", {self.unknown}" if self.satisfied is None else ""
        unstable = "" if self.worst.stable else "; the loop becomes UNSTABLE there"
        return (
            f"criteria {self.criteria.name} in the box: {word}{why}; worst disk margin"
            f" {disk.value:.3f} at {at}{unstable}"
        )


def worst_in_box(intervals: list[str], case: StudyPlan, autopilot: Autopilot) -> BoxResult | None:
    """Return the worst case in the box of --box, of the rigid vehicle; None without a box.

    `intervals`: values of --box, as "delay_ms=0..40". `autopilot`: autopilot of the loop.
    """
    if not intervals:
        return None
    vehicle, wind = complete_vehicle(case.vehicle, "--box"), case.wind_in_plane
    if not isinstance(wind, ShapedWind):
        raise InputError(
            "--box moves peak and duration of a pulse: give no --winds with it; tvclin margins"
            " --limit-deg goes through a sounding"
        )
    box: dict[str, tuple[float, float]] = {}
    for text in intervals:
        name, ends = _interval(text, vehicle, autopilot, wind)
        if name in box:
            raise InputError(f"--box gives {name} twice")
        box[name] = ends
    worst = worst_case(vehicle, autopilot, box, model=case.plant.model, plane=case.plane, wind=wind)
    structure, system = vehicle.structure is not None, case.plant_system is not None
    omitted = "structure" if structure else "plant in its file" * system
    # the vehicle in the box has no modes: their limits are omitted, unless there are no others
    criteria = case.margin_criteria.without_mode_limits or case.margin_criteria
    return BoxResult(worst, criteria, omitted)


def _interval(
    text: str, vehicle: Vehicle, autopilot: Autopilot, wind: ShapedWind
) -> tuple[str, tuple[float, float]]:
    """Return the name of a number, and its two ends [SI], of a value `text` of --box.

    `vehicle`, `autopilot`, `wind`: nominal values, for ends in percent, which are a key without a
    unit. `InputError` for ends in the wrong order, and percent of zero.
    """
    key, (low, high), percent = _split(text)
    if not low < high:
        raise InputError(f"--box must have a smaller and a larger value, LO..HI; got {text!r}")
    if not percent:
        ((name, factor),) = BOX_TABLE.read({key: 1.0}).items()  # factor: one of its unit [SI]
        return name, (factor * low, factor * high)
    check_known("number of --box", [key], BOX_TABLE.quantities)
    centre = _nominal(key, vehicle, autopilot, wind)
    if not centre:
        raise InputError(
            f"--box {text}: {key} has no nominal value for a percentage; give both ends in its unit"
        )
    factor = 0.01 * abs(centre)
    return key, (centre + factor * low, centre + factor * high)


def _split(text: str) -> tuple[str, tuple[float, float], bool]:
    """Return key and two ends of a value `text` of --box, and whether they are in percent.

    `InputError` for another form than KEY=LO..HI, and for percent at one end alone.
    """
    key, equals, ends = text.partition("=")
    low, dots, high = (end.strip() for end in ends.partition(".."))
    if not equals or not dots:
        raise InputError(
            f"--box must be KEY=LO..HI, as in delay_ms=0..40 or thrust=-3%..3%; got {text!r}"
        )
    percent = low.endswith("%") and high.endswith("%")
    if percent:
        low, high = low.removesuffix("%"), high.removesuffix("%")
    try:
        return key.strip(), (float(low), float(high)), percent
    except ValueError:
        raise InputError(
            f"--box must have two numbers beside the dots, both in percent or neither; got {text!r}"
        ) from None


def _nominal(name: str, vehicle: Vehicle, autopilot: Autopilot, wind: ShapedWind) -> float:
    """Return the nominal value [SI] of a number of vehicle, autopilot or wind, by its name.

    Zero where none is defined; one of "gain", a factor on all gains.
    """
    actuator = autopilot.actuator
    values: dict[str, Any] = {**vars(vehicle), **vars(autopilot), **wind.nominal, "gain": 1.0}
    if actuator is not None:
        values["actuator_frequency"] = actuator.natural_frequency
        values["actuator_damping"] = actuator.damping
    value = values.get(name)
    return float(value) if isinstance(value, int | float) else 0.0


@dataclass(frozen=True)
class MinimumGainOptions:
    """Options of the search for gains; `grouped` gives them to a command."""

    least: bool = switch(
        "--least",
        "Find the gains with the minimum deflection of all that satisfy the criteria: in the wind,"
        " and in winds half and twice as long.",
    )
    three_gains: bool = switch("--three-gains", "With --least: also feed back the angle of attack.")
    crossover: float | None = option("With --least: highest gain crossover, in rad/s.")

    panel = "Gains for the minimum deflection"

    def applied_to(self, plan: StudyPlan) -> StudyPlan:
        """Return a plan with the rule `LEAST_NOZZLE` for gains, with --least; else the plan."""
        if not self.least:
            only_with("--least", **vars(self))
            return plan
        crossover = chosen(self.crossover, plan.autopilot_design.crossover)
        design = with_gains(plan.autopilot_design, design=LEAST_NOZZLE, crossover=crossover)
        return replace(plan, design=design)

    def minimum(self, case: StudyPlan) -> MinimumGains | None:
        """Return the gains for the minimum deflection; None without --least.

        The minimum is of the largest deflection over pulses of the duration of the wind, half and
        twice that; margins satisfy `case.margin_criteria`, of the plan or the classic ones.
        `applied_to` gives the plan the rule `LEAST_NOZZLE`; `InputError` where gains or another
        rule took its place, and for a sounding; `UnsatisfiedCriteriaError` where there are none.
        """
        design, wind = case.autopilot_design, case.wind_in_plane
        if not self.least:
            return None
        if design.design != LEAST_NOZZLE:
            raise InputError("give --least, or gains and a rule for them, not both")
        if not isinstance(wind, ShapedWind):
            raise InputError(
                "gains for the minimum deflection are sought in pulses of three durations: give no"
                " --winds; tvclin margins and fly take its gains through a sounding"
            )
        winds = [
            wind.history({"wind_duration": ratio * wind.duration}) for ratio in _DURATION_RATIOS
        ]
        gains = ("attitude", "rate", "alpha") if self.three_gains else ("attitude", "rate")
        return minimum_gains(case, winds, case.margin_criteria, gains=gains)


@dataclass(frozen=True, eq=False)
class RuleResult(Record):
    """Gains of a rule, the margins of their loop, and the peak deflection [rad] in the wind.

    The peak is of the linear, continuous loop without a limit; NaN for an unstable loop.
    """

    rule: str = field(metadata=spec(label="gains"))
    margins: JudgedMargins = field(
        metadata=specs(
            Field("attitude_gain", of="margins.autopilot.attitude_gain", label="a0", significant=4),
            Field("rate_gain", "time", "margins.autopilot.rate_gain", "a1", significant=4),
            Field("alpha_gain", of="margins.autopilot.alpha_gain", label="b0", significant=4),
            Field("stable", of="margins.whole.stable"),
            Field("aero_margin", "gain", "margins.whole.aero_margin", "aero", digits=1),
            Field("gain_increase", "gain", "margins.whole.gain_increase", "rise", digits=1),
            Field("phase_margin", "angle", "margins.whole.phase_margin", "phase", digits=1),
            Field("satisfied", of="margins.satisfied", label="met"),
        )
    )
    peak: float = field(metadata=spec("angle", "peak", name="peak_deflection"))

    @classmethod
    def of(cls, rule: str, case: StudyPlan, autopilot: Autopilot) -> "RuleResult":
        """Return margins, judged by the criteria of a case, and peak deflection of an autopilot.

        They are with the plant and the wind of the case. `rule`: name of the rule of its gains. The
        peak [rad] is NaN for an unstable loop, and for a delay too long for its approximation.
        """
        margins, peak = JudgedMargins.of(autopilot, case.plant, case.margin_criteria), nan
        if margins.whole.stable:
            with suppress(InputError):  # the approximation of a long delay misleads
                response = autopilot.continuous.wind_response(case.plant, case.history)
                value, _ = response.peak("deflection")  # with its time
                peak = abs(value)
        return cls(rule, margins, float(peak))


_RULE_COLUMNS = (
    *("rule", "attitude_gain", "rate_gain", "alpha_gain", "aero_margin", "gain_increase"),
    *("phase_margin", "satisfied", "peak_deflection"),
)
"""Fields of a rule in its table."""


def design(
    vehicle: Source = "configuration-i",
    time: At = None,
    winds: WindOptions = GROUP,
    gains: Options = GAINS,
    timing: Options = TIMING,
    least: MinimumGainOptions = GROUP,
    box: Box = None,
    model: Options = MODEL_AND_PLANE,
    more: More = False,
    shown: Shown = GROUP,
) -> None:
    """Print gains for an autopilot by each design rule, with their margins and peak deflection.

    tvclin margins judges gains in detail, also over a flight. The first row has the gains of the
    case, which are judged: by a rule, by given gains, or those for the minimum deflection
    (--least). The peak is of the linear loop, without a limit, at nominal dynamic pressure; tvclin
    fly says what limit the autopilot requires.

    --box lets numbers lie anywhere between two values, and prints the worst margins of the rigid
    vehicle there, and the worst required deflection, at nominal dynamic pressure. The criteria
    judge the worst margins too; whether a vehicle with a structure satisfies them is NOT KNOWN.

    --plot draws the Nichols chart of the gains; with --least, what a disk margin costs.

    Rules that place poles have --natural-frequency; without it the first of 1.5, 2, 3, 4 and 6
    times the unstable pole whose gains satisfy the criteria, or twice that pole.

    Exit code 0: the criteria are MET; 1: NOT MET, as of an unstable loop, or by any gains of
    --least, or NOT KNOWN in the box; 2: bad input.
    """
    # functions that put the options over the plan of the file, the last a check
    changes = [*(options.applied_to for options in (timing, model, least, gains)), _with_gains]
    questions = ("design", "design --box") if box else ("design",)  # notes say what they neglect
    case = case_of(vehicle, *changes, wind=winds.applied_to, questions=questions, time=time)
    with waiting("seeking gains"):
        loop, sought, unsatisfied = _designed(case, least)
        frequency = _frequency(case)  # natural frequency for rules that place poles [rad/s]
        results = tuple(_results(case, loop, frequency))
        in_box = None if unsatisfied else worst_in_box(box or [], case, loop)
    wind = wind_words(winds.name(case), case)
    result = _Answer(case, wind, results, frequency, sought, unsatisfied, in_box)
    with waiting("drawing"):
        draw(shown.plot, result.chart)
    answer(shown.as_json, result.document, lambda: result.print(vehicle, more), result.satisfied)


def _with_gains(plan: StudyPlan) -> StudyPlan:
    """Return a plan; `InputError` where a controller in state space stands for gains."""
    if plan.controller is not None:
        raise InputError(
            "design is of gains, and the study has a [controller]: tvclin margins judges that;"
            " --set controller none designs gains in its place"
        )
    return plan


def _designed(
    case: StudyPlan, least: MinimumGainOptions
) -> tuple[Autopilot, MinimumGains | None, UnsatisfiedCriteriaError | None]:
    """Return the autopilot of a case, the result of --least, and the error of its search.

    Where no gains satisfy the criteria, the autopilot has the nearest gains, and the error says so;
    also without --least, of a case whose rule is `LEAST_NOZZLE`.
    """
    try:
        sought = least.minimum(case)
        if sought is not None:
            return sought.autopilot, sought, None
        return specified_autopilot(case, case.history, case.margin_criteria), None, None
    except UnsatisfiedCriteriaError as error:
        return error.nearest, None, error


def _results(case: StudyPlan, loop: Autopilot, frequency: float | None) -> Iterator[RuleResult]:
    """Yield the results of the gains of a case, and of each rule's gains for its vehicle.

    `loop`: autopilot of the case. `frequency`: natural frequency [rad/s] of rules that place poles;
    None without such rules. The rule of the case is not repeated, and the search for the minimum
    deflection, which takes long, is left out; so is a rule without gains for this vehicle.
    """
    specified = case.autopilot_design
    rule_of_case = specified.design or ("poles" if specified.natural_frequency else "canonical")
    if specified.attitude_gain is not None:
        rule_of_case = "given"
    yield RuleResult.of(rule_of_case, case, loop)  # also of the nearest gains to the criteria
    for rule in DESIGNS:
        placed = rule in POLE_PLACEMENT_RULES
        if rule in (rule_of_case, LEAST_NOZZLE) or (placed and frequency is None):
            continue
        poles = {"natural_frequency": frequency} if placed else {}
        # a crossover limit is of the minimum deflection alone, and refused for other rules
        rule_design = with_gains(replace(specified, crossover=None), design=rule, **poles)
        with suppress(InputError):  # the rule has no gains for this vehicle
            ruled = replace(case, design=rule_design)
            yield RuleResult.of(rule, ruled, ruled.autopilot)


def _frequency(case: StudyPlan) -> float | None:
    """Return the natural frequency [rad/s] of a case, or one that satisfies the criteria.

    If none does, it is twice the unstable pole; None for a stable vehicle.
    """
    if (frequency := case.autopilot_design.natural_frequency) is not None:
        return frequency
    rule = satisfying_rule(case, case.margin_criteria)
    if rule is not None and rule.natural_frequency is not None:
        return rule.natural_frequency
    with suppress(InputError):  # a stable vehicle has no such pole
        return _FREQUENCY_RATIO * float(case.plant.rigid.coefficients.pole)
    return None


@dataclass(frozen=True, eq=False)
class _Answer:
    """Gains of a case, first, and of rules; the search for them, and their worst case in a box.

    `sought`: gains for the minimum deflection; None where others are designed. `unsatisfied`: error
    of a search without a result, whose nearest gains are then those of the case.
    """

    case: StudyPlan
    wind: str
    results: tuple[RuleResult, ...]
    frequency: float | None
    sought: MinimumGains | None
    unsatisfied: UnsatisfiedCriteriaError | None
    in_box: BoxResult | None

    @property
    def margins(self) -> JudgedMargins:
        """Margins of the loop with the gains of the case, the first of `results`."""
        return self.results[0].margins

    @property
    def satisfied(self) -> bool:
        """Whether the gains satisfy the criteria, with a box of uncertain parameters too.

        False after a search without a result: the nearest gains may miss the crossover alone.
        """
        if self.unsatisfied is not None:
            return False
        return self.margins.satisfied and (self.in_box is None or self.in_box.satisfied is True)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Notes on the gains, on the search for them and on their margins, also of modes."""
        delay = self.margins.whole.delay_margin
        # without the box: other gains are proposed where these do not satisfy the criteria
        satisfied = self.unsatisfied is None and self.margins.satisfied
        notes = gain_notes(self.case, self.case.margin_criteria, satisfied, delay)
        sampled = self.margins.autopilot.sample_rate is not None
        timing = ("margins are of the sampled autopilot, peaks of the continuous one",) * sampled
        sought = self._search_notes()
        return (*sought, *timing, *notes, *self.margins.whole.notes, *mode_notes(self.margins))

    def _search_notes(self) -> Iterator[str]:
        """Yield notes on the search for gains: range, winds, and rules with a lower peak."""
        if self.unsatisfied is not None:
            yield from filter(None, (self.unsatisfied.searched, self.unsatisfied.bounds))
        if self.sought is None:
            return
        yield from self.sought.notes
        first, *others = self.results
        lower = [row for row in others if row.margins.satisfied and row.peak < first.peak]
        if not lower:
            return
        quantity = "peak" if self.sought.meaning == PEAK else "required limit"
        free = listed(self.sought.problem.gains)
        three = "" if self.sought.problem.has_alpha else " (--three-gains adds the angle of attack)"
        yield (
            f"{first.rule} has the lowest {quantity} of gains on {free}{three}, in the worst of"
            " this wind and winds half and twice as long; in this wind alone the peak is lower"
            f" with {listed(row.rule for row in lower)}"
        )

    def chart(self) -> "ControlPlot":
        """Return the chart of deflection against disk margin for gains of minimum deflection.

        For other gains it is the Nichols chart of the margins, with their criteria.
        """
        from tvclin import plots

        if self.sought is not None:
            return plots.gain_trade_off_chart([gain_trade_off(self.sought)])
        return plots.nichols_chart(
            self.margins.autopilot, self.case.plant, self.case.margin_criteria
        )

    def document(self) -> dict[str, Any]:
        """Return the document of the answer for JSON.

        "least" has the gains for the minimum deflection (`sought`), "unsatisfied" the sentence that
        there are none, and "box" the worst margins in the intervals of --box (`in_box`), where
        these are computed. "rules" has the designs by rules, with their margins and peaks.
        """
        case, margins = self.case, margins_document(self.margins)
        head = {"vehicle": case.vehicle.name, "model": case.plant.model, "plane": case.plane}
        unsatisfied = None if self.unsatisfied is None else self.unsatisfied.sentence
        further = {"least": self.sought, "unsatisfied": unsatisfied, "box": self.in_box}
        return {
            **head,
            **margins,
            "wind_peak_deg": degrees(case.history.peak),
            "natural_frequency_rad_per_s": self.frequency,
            "rules": self.results,
            **{name: value for name, value in further.items() if value is not None},
            "notes": self.notes,
        }

    def print(self, source: str, more: bool) -> None:
        """Print the verdict on the gains, the table of rules or of the box, and notes.

        `source`: file, for a vehicle without a name. `more`: whether details and all notes follow.
        """
        name = self.case.vehicle.name or source
        poles = f"; rules that place poles: at {self.frequency:.3g} rad/s" if self.frequency else ""
        unstable = [row.rule for row in self.results if not row.margins.whole.stable]
        without = f"; no margins, the loop is not stable: {listed(unstable)}" if unstable else ""
        caption = f"{name}, {self.case.plant.model}, {self.case.plane}: {self.wind}{poles}{without}"
        rules = record_table(caption, "rule", self.results, *_RULE_COLUMNS)
        tables = (rules,) if self.in_box is None else (self.in_box.worst.table(),)

        def details() -> None:
            """Print autopilot, margins, bounds, the search for gains, and the rules of a box."""
            print_parts(self.case.plant)
            print_autopilot("Autopilot", self.margins.autopilot, self.case.plant)
            print_tables(*margin_tables(self.margins))
            if self.margins.whole.stable:
                print_bounds(self.margins.autopilot, self.case.plant)
            if self.sought is not None:
                print_tables(self.sought.table())
                active = ", ".join(self.sought.active) or "no constraint, a flat minimum"
                say(f"Active constraints: {active}")
            if self.in_box is not None:
                print_tables(rules)

        print_answer(self._verdict, *tables, notes=self.notes, more=more, details=details)

    @property
    def _verdict(self) -> str:
        """The gains of the case with the verdict on their margins; with a box the verdict in it."""
        if self.in_box is not None:
            return self.in_box.verdict
        if self.unsatisfied is not None:
            return self.unsatisfied.sentence
        autopilot, rule = self.margins.autopilot, self.results[0].rule
        return f"gains {rule}: {autopilot.gains_text}; {self.margins.verdict}"
