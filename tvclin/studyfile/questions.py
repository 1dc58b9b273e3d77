"""Questions of a study file about a limit and an autopilot, and their answers."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from tvclin.base.cards import Record
from tvclin.base.fields import derived, spec
from tvclin.base.lines import Line, degrees, minimum_limit, number, significant, text
from tvclin.base.quantities import (
    BUDGET,
    FORECAST_FREE,
    FROZEN_ALONG,
    NO_LIMIT,
    NOMINAL,
    OF_RAMP,
    REQUIRED,
    REQUIRED_RATE,
    REQUIREMENT,
    WIND_KNOWN,
    satisfaction,
    sufficiency,
    survival,
)
from tvclin.control.margins.criteria import Judgement
from tvclin.control.margins.margins import DIGITS, unit_factor
from tvclin.requirement.nominal_requirement import covers
from tvclin.studyfile.findings import Findings
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.winds.wind_angles import ATTACK, beyond_linear

_OVER_FLIGHT, _ALONG_FLIGHT = "margins over the flight", "autopilot along the flight"
_FLIGHTS = ("flexible flight", _ALONG_FLIGHT)
"""Questions whose answer is the outcome of a flight: survived or not."""
_TURBULENCE, _TURBULENCE_RATE = "turbulence", "rate in turbulence"
_TURBULENCE_LOAD = "load in turbulence"
_CRITERIA = (
    *("nozzle rate", "load", "nozzle card", "availability", "margins"),
    _OVER_FLIGHT,
    *(_TURBULENCE, _TURBULENCE_RATE, _TURBULENCE_LOAD),
)
"""Questions that are answered by a criterion: satisfied or not. Others have a verdict."""
_QUANTITIES = {
    "wind": REQUIRED,
    "load": WIND_KNOWN,
    "whole flight": BUDGET,
    "probability": REQUIRED,
    "autopilot": REQUIREMENT,
    "flexible flight": f"{REQUIREMENT} {NOMINAL}",
}
"""Quantities with which a limit is compared, by the name of the question."""
_FLIGHT_RATE = "rate along the flight"
_RATE_QUESTIONS = ("nozzle rate", "whole flight", _FLIGHT_RATE)
"""Questions that compare a rate limit with the required rate."""


@dataclass(frozen=True)
class Measure(Record):
    """Required and available value of a question, both in `unit`, the unit that is shown.

    `digits` is the number of digits behind the point. `is_upper_limit`: the available value must
    not be above the required value, in place of not below.
    """

    required: float = field(metadata=spec())
    available: float = field(metadata=spec())
    unit: str = field(default="deg", metadata=spec())
    digits: int = 3
    is_upper_limit: bool = False

    @property
    def remaining(self) -> float:
        """Available minus required value; negative where it is insufficient."""
        return (self.available - self.required) * (-1.0 if self.is_upper_limit else 1.0)

    @property
    def ratio(self) -> float:
        """Required over available value; above one where it is insufficient."""
        numerator, denominator = self.required, self.available
        if self.is_upper_limit:
            numerator, denominator = denominator, numerator
        if denominator:
            return numerator / denominator
        return float("inf") if numerator > 0.0 else 0.0


@dataclass(frozen=True)
class Question(Record):
    """One question of a study file.

    `name` is "wind", "nozzle rate", "load", "whole flight", "rate along the flight", "nozzle card",
    "availability", "probability", "turbulence", "rate in turbulence", "load in turbulence",
    "autopilot", "margins" or "flexible flight"; the answer is None where it is not known, and
    `line` is why.
    `required_deflection` is the required deflection [rad], NaN for a question without one, and
    `clause` the beginning of a sentence on it ("this autopilot requires"). `measure` holds the
    required and the available value: by default `required_deflection` and the limit.
    """

    name: str = field(metadata=spec())
    yes: bool | None = field(metadata=spec())
    line: Line = field(metadata=spec(name="why", of="text"))
    required_deflection: float = float("nan")
    clause: str = ""
    measure: Measure | None = field(default=None, metadata=spec())

    @property
    @derived()
    def answer(self) -> str:
        """The answer as a word: a verdict, whether a criterion is met, or a flight survived."""
        if self.name in _FLIGHTS:
            return survival(self.yes)
        return satisfaction(self.yes) if self.name in _CRITERIA else sufficiency(self.yes)

    @property
    @derived()
    def quantity(self) -> str:
        """Name of the required quantity of `measure`; empty for a criterion, and without one."""
        if self.measure is None:
            return ""
        if self.measure.unit == "deg/s" and self.name in _RATE_QUESTIONS:
            return REQUIRED_RATE
        return _QUANTITIES.get(self.name, "")

    @property
    def text(self) -> str:
        """Reason of the answer to the question, as plain text."""
        return text(self.line)


def questioned(plan: StudyPlan) -> StudyPlan:
    """Return a plan without the parts that its page shows and that no question judges.

    They are the laws, and an archive of soundings without a required fraction of days.
    """
    archive = plan.availability
    if archive is not None and archive.least_part is None:
        archive = None
    return replace(plan, laws=None, availability=archive)


def questions(findings: Findings) -> tuple[Question, ...]:
    """Return the questions of a plan with their answers, in the order of the plan.

    `findings`: results of the plan. A question on angles has its measure: required, available. In a
    wind beyond linear aerodynamics the answer is None, and in place of yes also where the dynamic
    pressure encountered is not known.
    """
    study, answers = findings.study, []
    for question in _answered(findings):
        required, answer = question.required_deflection, question
        reason = study.beyond_linear or (study.unknown if question.yes is not False else "")
        if question.name in _IN_THE_WIND and reason:
            answer = Question(question.name, None, (reason,))
        elif question.measure is None and study.limit is not None and not np.isnan(required):
            answer = replace(question, measure=_of_angles(required, study.limit))
        answers.append(answer)
    return tuple(answers)


def sufficient(findings: Findings) -> bool | None:
    """Return whether every answer in findings is yes; None where one is not known.

    None without a limit, too, unless an answer is no.
    """
    answers = [question.yes for question in questions(findings)]
    if False in answers:
        return False
    return None if findings.study.limit is None or None in answers else True


def all_yes(findings: Findings) -> bool:
    """Return whether no question of findings has another answer than yes."""
    return all(question.yes is True for question in questions(findings))


_NOT_KNOWN_AT_PEAK = "not known with the dynamic pressure at the peak of a head wind"
"""Reason where a plant is not known at the pressure of a head wind that sets the requirement."""
_FLOWN = "flown with its stop"
"""Reason of an answer that rests on flights of the autopilot with the limit as its stop."""
_IN_THE_WIND = (
    *("wind", "nozzle rate", "load", "probability", "autopilot", "flexible flight"),
    *(_TURBULENCE, _TURBULENCE_RATE, _TURBULENCE_LOAD),
)
"""Questions whose answers rest on the wind of the study."""


def _answered(findings: Findings) -> Iterator[Question]:
    """Yield the questions of findings, each with the answer of its own function.

    Most compare a limit, and are left out without one; those on margins need none.
    """
    limit = findings.study.limit
    if limit is not None:
        yield _wind(findings)
        if findings.plan.nozzle.rate_limit is not None:
            yield _rate(findings)
        if findings.plan.load is not None:
            yield _load(findings)
        if findings.plan.sizing is not None:
            yield _flight(findings)
            yield from _flight_rate(findings)
            yield from _duty_question(findings)
        request = findings.plan.availability
        if request is not None and request.least_part is not None:
            yield _availability(findings, request.least_part)
        if findings.plan.dispersions is not None:
            yield _probability(findings, limit)
        yield from _turbulence(findings, limit)
    if findings.plan.design is not None or findings.plan.criteria is not None:
        if limit is not None:
            yield _autopilot(findings, limit)
        yield _margins(findings)
        if limit is not None and findings.plan.vehicle.structure is not None:
            yield _flexible(findings)
    yield from _along_flight(findings)


def _wind(findings: Findings) -> Question:
    """Return the question whether the limit covers the required deflection of the wind.

    `findings`: results of a plan with a limit.
    """
    required, governs = findings.study.required_deflection, findings.study.governs
    # `unknown`: the reason why the pressure encountered is not known, or empty
    pressure = f" {NOMINAL}" if findings.study.unknown else ""
    clause = f"the ideal trim law requires in this wind{pressure}"
    line: Line = (f"set by {governs}",)
    if not required:
        line = ("no deflection is needed",)
    elif np.isinf(required):
        line = ("with this dead band no limit is sufficient",)
    yes = findings.study.sufficient
    return Question("wind", yes, line, required_deflection=required, clause=clause)


def _rate(findings: Findings) -> Question:
    """Return the question whether the rate limit is above the lower bound of every control.

    `findings`: results of a plan with a rate limit. Its trade-off of limit over rate has the lower
    bounds of every control, with the wind known and without a forecast: of the deflection [rad] at
    this rate, and of the rate [rad/s] with this limit. `findings.rates` is at nominal dynamic
    pressure. In a head wind that governs, yes also needs `findings.head.rates`, with the pressure
    at its peak throughout, whose numbers are then shown; without these it is not known.
    """
    name, trade_off = "nozzle rate", findings.rates
    if trade_off is None:
        return Question(name, None, (_reason(findings, "rates"),))
    yes, head = trade_off.above_lower_bound, findings.head
    at_peak: Line = ()
    if head is not None and head.rates is not None:
        nominal = degrees("answer.calm_rate", trade_off.required_rate, unit="deg/s")
        at_peak, trade_off = (_at_peak(findings), *minimum_limit(nominal)), head.rates
        yes = _also_in_head_wind(yes, trade_off.above_lower_bound)
    elif head is not None and yes:
        return Question(name, None, (_NOT_KNOWN_AT_PEAK,))
    words = "by the larger of both lower bounds with this limit"
    if np.isinf(trade_off.required_rate):
        words = "with this limit no rate is sufficient"
    elif yes is None and trade_off.rate_limit is not None:
        words = (
            f"the rate limit covers the bounds {NOMINAL}, and not the larger one with this limit"
        )
    line: Line = (words, *at_peak, "; a law may require more") if yes else (words, *at_peak)
    required = trade_off.lower_bound * findings.study.plane_ratio  # of all judged planes
    bounds = "the larger of both lower bounds"
    if at_peak:
        bounds = f"{bounds}, by the peak pressure of a {findings.study.direction} wind throughout,"
    clause = f"at this rate {bounds} requires"
    if yes is False and np.isinf(required):  # no angle is sufficient at this rate
        required, clause = np.nan, f"with this limit {bounds} requires"
    measure = _of_angles(trade_off.required_rate, trade_off.rate_limit or np.nan, "deg/s")
    return Question(name, yes, line, required_deflection=required, clause=clause, measure=measure)


def _load(findings: Findings) -> Question:
    """Return the question whether limit and load limit admit a control that knows the wind.

    `findings`: results of a plan with a load limit. Its trade-off of limit over load has the lower
    bound of the deflection [rad] within that load, in this plane (`plane_ratio`: the limit of both
    over it), at nominal dynamic pressure. Where a head wind sets the requirement, the bound shown
    is by the pressure at its peak throughout, which is no bound of the flight: a limit below it is
    not known to be sufficient or not. A limit below the nominal one is not sufficient.
    """
    name, trade_off, rates = "load", findings.loads, findings.rates
    if trade_off is None:
        too_slow = rates is not None and np.isinf(rates.lower_bound)
        reason = _reason(findings, "loads")
        words = "at this rate no deflection is sufficient" if too_slow else reason
        return Question(name, False if too_slow else None, (words,))
    line: Line = ("for this load, of a control that knows the wind",)
    yes, head, ratio = trade_off.above_lower_bound, findings.head, findings.study.plane_ratio
    pressure = NOMINAL
    # `head`: findings by the pressure at the peak of a head wind, `loads` its trade-off
    if head is not None and head.loads is not None:
        nominal = minimum_limit(
            degrees("answer.calm_load", trade_off.lower_bound * ratio, unit="deg")
        )
        at_nominal, trade_off = yes, head.loads
        yes = _also_in_head_wind(at_nominal, trade_off.above_lower_bound)
        if at_nominal and yes is None and trade_off.limit is not None:
            line = (f"the limit covers the bound of this load {NOMINAL}, and not the larger one",)
        line = (*line, _at_peak(findings), *nominal)
        pressure = f"by the peak pressure of a {findings.study.direction} wind throughout"
    elif head is not None and yes:
        return Question(name, None, (_NOT_KNOWN_AT_PEAK,))
    if yes and trade_off.requires_forecast:
        line = (*line, f"; a {FORECAST_FREE} bears more")
    clause = f"within this load the {WIND_KNOWN}, {pressure}, requires"
    required = trade_off.lower_bound * ratio
    return Question(name, yes, line, required_deflection=required, clause=clause)


def _flight(findings: Findings) -> Question:
    """Return the question whether the limit covers the total deflection along the flight.

    `findings`: results of a plan. The total is the largest sum of deflections [rad] over the flight
    times, that of the wind among them; the reserve is the fraction of the limit to stay unused. If
    only the rate limit is insufficient, the question is of the required rate [rad/s] instead.
    """
    # `line`: reason of the answer, with the words that a reserve is part of the required value;
    # `clause`: beginning of a sentence that ends with that value
    name, request = "whole flight", findings.plan.sizing
    if findings.flight is None or request is None:
        return Question(name, None, (_reason(findings, "flight"),))
    _, total = findings.flight  # sizing, and its worst total
    flight = f"the whole flight of {request.source}" if request.source else "the whole flight"
    clause = f"{flight} requires"
    reserve = "; remaining beyond the reserve, which is required too" if total.reserve else ""
    line: Line = (flight, reserve)
    if total.sufficient is None:
        line = (
            f"required deflection of {flight} not known {', '.join(total.not_sized)}; the required"
            " value is where the winds are known",
        )
    limit = findings.study.limit
    angle_is_sufficient = limit is None or covers(limit, total.required)
    if total.too_slow and angle_is_sufficient:
        # a ramp turns the nozzle to the deflection of the wind at a constant rate
        least = f"the least rate {OF_RAMP} with which the limit is sufficient"
        line = (f"{least} for {flight}", reserve)
        measure = _of_angles(total.needed_rate, total.rate_limit or np.nan, "deg/s")
        return Question(name, False, line, clause=clause, measure=measure)
    return Question(name, total.sufficient, line, required_deflection=total.required, clause=clause)


def _flight_rate(findings: Findings) -> Iterator[Question]:
    """Yield the question whether the rate limit covers the required rate along the flight.

    `findings`: results of a plan with a flight. Nothing is yielded where the rate alone is
    insufficient, or no rate is sufficient with the limit: the question of the whole flight says so.
    The rate is that of a ramp to the required deflection; NaN where it is not known.
    """
    _, total = findings.flight or (None, None)  # sizing, and its worst total
    limit = findings.study.limit
    if not total or total.rate_limit is None:
        return
    only_rate = limit is not None and covers(limit, total.required)
    if total.too_slow and (only_rate or np.isinf(total.needed_rate)):
        return
    if np.isnan(total.needed_rate):
        yield Question(_FLIGHT_RATE, None, ("not known along the flight",))
        return
    line = (f"{OF_RAMP}, at the worst flight time",)
    measure = _of_angles(total.needed_rate, total.rate_limit, "deg/s")
    yield Question(_FLIGHT_RATE, not total.too_slow, line, measure=measure)


def _duty_question(findings: Findings) -> Iterator[Question]:
    """Yield the question whether the nozzle can follow a law along the flight of findings.

    Nothing is yielded where its duty was not requested.
    """
    name = "nozzle card"
    if findings.duty is None:
        if "duty" in findings.reasons:
            yield Question(name, None, (_reason(findings, "duty"),))
        return
    verdict = findings.duty.verdict
    worst = verdict.lines[0]  # that with the largest required fraction
    measure = (
        None if worst.available is None else Measure(worst.required, worst.available, worst.unit)
    )
    line: Line = (f"the {worst.name} that {findings.duty.law} takes, {FROZEN_ALONG}",)
    if verdict.diverged or verdict.unknown:
        line = (f"{verdict.reason}{f', {FROZEN_ALONG}' if verdict.diverged else ''}",)
    yield Question(name, verdict.satisfied, line, measure=measure)


def _availability(findings: Findings, minimum: float) -> Question:
    """Return the question whether at least a fraction of the soundings of findings fly.

    `minimum`: that fraction, from 0 to 1.
    """
    if findings.availability is None:
        return Question("availability", None, (_reason(findings, "availability"),))
    fraction = findings.availability.fraction()
    measure = Measure(100.0 * minimum, 100.0 * fraction.fraction, unit="%", digits=1)
    yes, line = findings.availability.reaches(minimum), str(fraction)
    if yes is None:
        line = f"too few soundings to tell whether {100.0 * minimum:g} % of days fly; {line}"
    return Question("availability", yes, (line,), measure=measure)


def _probability(findings: Findings, limit: float) -> Question:
    """Return the question whether a limit [rad] covers the required quantile of dispersed cases.

    `findings`: results of a plan with dispersions. The quantile has an estimate and, for the
    confidence of the plan, an upper bound, which is the required deflection [rad]; with too few
    cases the bound is infinite, and the interval of the success probability may still say no.
    """
    dispersed = findings.dispersed
    if dispersed is None:
        return Question("probability", None, (_reason(findings, "dispersed"),))
    required = dispersed.required
    flights = significant("answer.probability", 100.0 * required.probability, 5, "% of flights")
    yes, success = dispersed.sufficient, dispersed.success
    if yes is None:
        few: Line = "too few cases to judge ", *flights, required.few_cases
        unknown = dispersed.unknown_cases.rstrip(".")
        return Question("probability", None, (unknown,) if unknown else few)
    if np.isinf(required.estimate):
        return Question("probability", False, (*flights, " require more than any limit"))
    if np.isinf(required.upper) and success is not None:
        upper = number("answer.success", 100.0 * success.upper, 2)
        words: Line = ("sufficient in at most ", *upper, " %, not in ", *flights)
        return Question("probability", False, words)
    line = ("covers ", *flights, f", with {100.0 * required.confidence:g} % confidence")
    clause, upper_bound = f"{text(flights)} require", float(required.upper)
    return Question("probability", yes, line, required_deflection=upper_bound, clause=clause)


def _autopilot(findings: Findings, limit: float) -> Question:
    """Return the question whether the autopilot survives, flown with the limit as its stop.

    `findings`: results of a plan with an autopilot. `limit`: deflection limit [rad]. The comparison
    has the autopilot in the wind without a stop, with its peak deflection, rate and angle of
    attack; the requirement is the smallest stop [rad] with which its flight survives, and where
    none can be flown, sufficient is a limit that the autopilot never reaches.
    """
    name, c = "autopilot", findings.comparison
    if c is None:
        return Question(name, None, (_reason(findings, "comparison"),))
    if not c.margins.stable:
        vehicle = "" if findings.flexible is None else " of the flexible vehicle"
        return Question(name, False, (f"the loop{vehicle} is not stable: {c.margins.reason}",))
    if beyond := beyond_linear(c.peak_angle_of_attack * findings.study.plane_ratio, ATTACK):
        return Question(name, None, (beyond,))
    peak = without_stop(findings)
    turns = degrees("answer.autopilot", peak, unit="deg")
    free: Line = ("without a limit the autopilot would turn the nozzle by ", *turns)
    if findings.study.judges_both_planes:
        free += (" in both planes",)
    clause = "this autopilot requires"
    rate, max_rate = c.peak_deflection_rate, findings.plan.nozzle.rate_limit or np.inf
    if rate > max_rate:
        free += (", at ", *degrees("answer.rate", rate, unit="deg/s"))
    requirement = findings.autopilot_requirement
    if requirement is None:
        within = True if covers(limit, peak) and rate <= max_rate else None
        why: Line = (f"{_reason(findings, 'stop')}; ", *free)
        return Question(name, within, why, required_deflection=peak, clause=clause)
    yes, nominal = requirement.sufficient(limit), requirement.nominal_deflection
    line: Line = (f"{_FLOWN}; ", *free)
    if np.isinf(nominal):
        line = (f"{NO_LIMIT}; ", *free)
    elif requirement.head is not None:  # flown at the pressure of the wind's peak, an upper bound
        clause += f", by the bound for a {findings.study.direction} wind"
        at_nominal = degrees("answer.calm", nominal, unit="deg")
        flown = NO_LIMIT if np.isinf(requirement.deflection) else _FLOWN
        line = (flown, _at_peak(findings), *at_nominal, "; ", *free)
    elif yes is None:
        line = (f"{_NOT_KNOWN_AT_PEAK}; {_FLOWN} at the nominal one; ", *free)
    required = nominal if np.isinf(nominal) else requirement.deflection
    return Question(name, yes, line, required_deflection=required, clause=clause)


def _turbulence(findings: Findings, limit: float) -> Iterator[Question]:
    """Yield whether limit, rate limit and load limit cover the wind and k sigma of turbulence.

    It is a criterion on the linear loop: where it is not satisfied, limits are reached more often.
    Where a head wind sets the requirement (`findings.head`), the dynamic pressure at its peak
    throughout is an upper bound, which must be covered too. `findings`: results of a plan with
    turbulence. `limit`: deflection limit [rad].
    """
    nominal, rate_limit = findings.turbulence, findings.plan.nozzle.rate_limit
    if nominal is None:
        if findings.plan.turbulence is not None:
            yield Question(_TURBULENCE, None, (_reason(findings, "turbulence"),))
        return
    counted, loop = nominal, f"the linear autopilot in the wind and {nominal.label} of turbulence"
    clause = f"{loop} requires"
    if findings.head is not None:
        if findings.head.turbulence is None:
            yield Question(_TURBULENCE, None, (_NOT_KNOWN_AT_PEAK,))
            return
        clause += f", by the bound for a {findings.study.direction} wind,"
        counted, loop = findings.head.turbulence, f"{loop}{_at_peak(findings)}"
    beyond = beyond_linear(counted.angle_of_attack, ATTACK)
    clause = "" if beyond else clause
    # name, required and available value at nominal pressure and at the one that counts, and unit
    judged = [(_TURBULENCE, (nominal.deflection, limit), (counted.deflection, limit), "deg")]
    if rate_limit is not None and counted.deflection_rate is not None:
        rate = nominal.deflection_rate or np.nan
        pairs = (rate, rate_limit), (counted.deflection_rate, rate_limit)
        judged.append((_TURBULENCE_RATE, *pairs, "deg/s"))
    if counted.load is not None and counted.load_bound is not None:
        at_nominal = nominal.load or 0.0, nominal.load_bound or np.nan
        load = counted.load, counted.load_bound
        judged.append((_TURBULENCE_LOAD, at_nominal, load, "deg"))
    for name, (nominal_required, nominal_available), (required, available), unit in judged:
        covered = bool(covers(nominal_available, nominal_required))
        # True, False, or None for not known
        yes, words = _also_in_head_wind(covered, bool(covers(available, required))), loop
        if findings.head is not None and yes is None:
            bound = f"not by the bound for a {findings.study.direction} wind"
            words = f"covered {NOMINAL}, {bound}; {words}"
        key = f"answer.nominal_{name.replace(' ', '_')}"
        number_text = () if findings.head is None else degrees(key, nominal_required, unit=unit)
        line: Line = (words, *number_text)
        measure = _of_angles(required, available, unit)
        answered = (None, (beyond,)) if beyond else (yes, line)
        yield Question(name, *answered, clause=clause, measure=measure)
    if rate_limit is not None and counted.deflection_rate is None:
        yield Question(_TURBULENCE_RATE, None, ("the deflection rate has no variance here",))


def _at_peak(findings: Findings) -> str:
    """Return words on the dynamic pressure of an upper bound, before the number at the nominal one.

    `findings`: results of a study plan in a head wind.
    """
    wind = f"{findings.study.direction} wind"
    return f", with the dynamic pressure at the peak of a {wind} throughout, at the nominal one "


def _also_in_head_wind(nominal: bool | None, head: bool | None) -> bool | None:
    """Return the answer for both dynamic pressures; None where it is not known.

    `nominal`: answer at nominal dynamic pressure; no or not known there stands. `head`: answer at
    the peak of a head wind throughout, an upper bound of the requirement: a yes needs it too, and
    without it is not known.
    """
    return True if nominal and head else None if nominal else nominal


def without_stop(findings: Findings) -> float:
    """Return the peak deflection [rad] of the autopilot of findings without a deflection limit.

    NaN without an autopilot. Where both planes are judged, the peak in the plane is multiplied by
    `plane_ratio`, the limit of both planes over the limit of this one.
    """
    if findings.comparison is None:
        return float("nan")
    return float(findings.comparison.peak_deflection * findings.study.plane_ratio)


def _margins(findings: Findings) -> Question:
    """Return the question whether the margins of findings satisfy the criteria.

    Its numbers belong to the criterion with the smallest surplus.
    """
    flexible = findings.plan.vehicle.structure is not None
    field = "flexible" if flexible else "comparison"
    margins = findings.margins
    if getattr(findings, field) is None or margins is None:
        return Question("margins", None, (_reason(findings, field),))
    satisfied = bool(findings.criteria.are_satisfied(margins))
    words = "meets" if satisfied else "does not meet"
    vehicle = " of the flexible vehicle" if flexible else ""
    line: Line = (f"the loop{vehicle} {words} the criteria {findings.criteria.name}",)
    judged = [j for j in findings.criteria.judge(margins) if np.isfinite(j.surplus)]
    # by the surplus over the criterion, which is infinite for a criterion of zero
    worst = min(
        judged,
        key=lambda j: float(j.surplus) / j.criterion.limit if j.criterion.limit else np.inf,
        default=None,
    )
    if worst is None:
        return Question("margins", satisfied, line)
    band = f" of {worst.band}" if worst.band else ""
    line += (f"; the {worst.criterion.name}{band} has least to spare",)
    return Question("margins", satisfied, line, measure=_measured(worst))


def _along_flight(findings: Findings) -> Iterator[Question]:
    """Yield whether the autopilot has its margins at the flight times, and survives along them."""
    sweep, flights, reasons = findings.sweep, findings.flights, findings.reasons
    if sweep is not None and sweep.all_satisfied and findings.plan.omitted_structure:
        yield Question(_OVER_FLIGHT, None, (findings.plan.omitted_structure,))
    elif sweep is not None:
        yield Question(_OVER_FLIGHT, sweep.all_satisfied, (sweep.verdict,))
    elif "sweep" in reasons:
        yield Question(_OVER_FLIGHT, None, (reasons["sweep"],))
    if flights is not None:
        yield Question(_ALONG_FLIGHT, flights.survived, (flights.reason,))
    elif "flights" in reasons:
        yield Question(_ALONG_FLIGHT, None, (reasons["flights"],))


def _measured(judgement: Judgement) -> Measure:
    """Return the measure of a judged margin: the criterion is required, the margin available.

    `judgement`: margin with its criterion. Numbers are in the unit of tables.
    """
    limit, unit = judgement.criterion.shown
    return Measure(
        required=limit,
        available=unit_factor(unit) * float(judgement.value),
        unit=unit,
        digits=DIGITS[unit],
        is_upper_limit=judgement.criterion.is_upper_limit,
    )


def _flexible(findings: Findings) -> Question:
    """Return the question whether the flexible vehicle survives, flown with the limit.

    `findings`: results of a plan whose vehicle has a structure, with its autopilot. Outcomes and
    boundaries, which are smallest limits [rad], are of the flexible and of the rigid vehicle.
    """
    f = findings.flexible
    if f is None or f.flight is None:
        return Question("flexible flight", None, (_reason(findings, "flexible"),))
    part = f" with the {findings.study.plane} plane's part of the stop"
    stop = part if findings.study.judges_both_planes else ""
    flexible, rigid = f.flight.outcomes
    flown = f"flown {NOMINAL} and {f.sample_rate:g} Hz{stop}"
    line: Line = (f"{flown} the flexible vehicle {flexible}",)
    if f.flight.survived and rigid != flexible:
        line += (f", the rigid one {rigid}",)
    boundary, _ = f.boundaries
    required = abs(float(boundary.deflection)) * findings.study.plane_ratio
    limit = findings.study.limit
    measure = None if limit is None else _of_angles(required, limit)
    return Question("flexible flight", f.flight.survived, line, measure=measure)


def _of_angles(required: float, available: float, unit: str = "deg") -> Measure:
    """Return the measure of `required` and `available` angles [rad] or rates [rad/s], in degrees.

    `unit`: unit of the measure, "deg" or "deg/s".
    """
    return Measure(float(np.degrees(required)), float(np.degrees(available)), unit)


def _reason(findings: Findings, field: str) -> str:
    """Return the reason why a field of the findings has no answer."""
    return findings.reasons.get(field, "there is no answer")
