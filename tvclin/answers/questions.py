"""What is asked of a limit and an autopilot, each question with its answer."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from tvclin.answers.findings import Findings
from tvclin.answers.requirement import covers
from tvclin.answers.study_file.plan import StudyPlan
from tvclin.answers.study_notes import nominal_pressure
from tvclin.base.documents import keyed
from tvclin.base.lines import Line, degrees, listed, significant, text
from tvclin.base.quantities import NOMINAL, satisfaction, sufficiency, survival
from tvclin.control.margins.criteria import Judgement
from tvclin.control.margins.margins import DIGITS, unit_factor
from tvclin.winds.wind_angles import ATTACK, beyond_linear

_FLIGHTS = ("flexible flight",)
_CRITERIA = ("nozzle rate", "load", "nozzle card", "availability", "margins")
"""Questions that a flight answers, and a criterion; the answer to others is a verdict."""


@dataclass(frozen=True)
class Measure:
    """What is needed for a yes beside what there is, both in the unit that is shown.

    With so many digits behind the point. `at_most`: what there is must not be above what is needed,
    in place of not below.
    """

    needed: float
    there: float
    unit: str = "deg"
    digits: int = 3
    at_most: bool = False

    as_dict = keyed("needed there unit")

    @property
    def left(self) -> float:
        """Return how much of what is there is not needed; negative where it is too little."""
        return (self.there - self.needed) * (-1.0 if self.at_most else 1.0)

    @property
    def part(self) -> float:
        """Return which part of what is there is needed; above one where it is too little."""
        over, under = (self.there, self.needed) if self.at_most else (self.needed, self.there)
        return over / under if under else float("inf") if over > 0.0 else 0.0


@dataclass(frozen=True)
class Question:
    """One question of a study file.

    `name` is "wind", "nozzle rate", "load", "whole flight", "nozzle card", "availability",
    "probability", "autopilot", "margins" or "flexible flight"; the answer is None where it is not
    known, and `line` is why. `needs` is the deflection [rad] that a yes takes, not a number of a
    question that asks for none, and `whose` says who needs it, with the verb. `measure` is what a
    yes takes beside what there is: a deflection is beside the limit unless something else is given.
    """

    name: str
    yes: bool | None
    line: Line
    needs: float = float("nan")
    whose: str = ""
    measure: Measure | None = None

    as_dict = keyed("name answer yes why=text measure")

    @property
    def answer(self) -> str:
        """The answer as a word: a verdict, whether a criterion is met, or a flight survived."""
        if self.name in _FLIGHTS:
            return survival(self.yes)
        return satisfaction(self.yes) if self.name in _CRITERIA else sufficiency(self.yes)

    @property
    def text(self) -> str:
        """Return why, as plain text."""
        return text(self.line)


def questioned(plan: StudyPlan) -> StudyPlan:
    """Return a plan without what is shown on its page and not asked with yes or no."""
    archive = plan.availability
    if archive is not None and archive.least_part is None:
        archive = None
    return replace(plan, laws=None, availability=archive)


def questions(found: Findings) -> tuple[Question, ...]:
    """Return all that the plan of these findings asks, in its order, with the answers."""
    limit = found.study.limit
    return tuple(
        replace(one, measure=_of_angles(one.needs, limit))
        if one.measure is None and limit is not None and not np.isnan(one.needs)
        else one
        for one in _asked(found)
    )


def sufficient(found: Findings) -> bool | None:
    """Return whether every answer is yes; None where one is not known, or no limit was given."""
    answers = [one.yes for one in questions(found)]
    if False in answers:
        return False
    return None if found.study.limit is None or None in answers else True


def overall(found: Findings) -> str:
    """Return the answers that are not yes by their words, or the verdict where all are."""
    others: dict[str, list[str]] = {}
    for one in questions(found):
        if one.yes is not True:
            others.setdefault(one.answer, []).append(one.name)
    if not others:
        return "no limit was given" if found.study.limit is None else sufficiency(True)
    return "; ".join(f"{word}: {', '.join(names)}" for word, names in sorted(others.items()))


def all_yes(found: Findings) -> bool:
    """Return whether no question has another answer than yes."""
    return all(one.yes is True for one in questions(found))


def nominal_notes(found: Findings) -> Iterator[str]:
    """Say which answers are at nominal pressure, where a head wind sets the requirement."""
    flown = found.head is not None and found.head.stop is not None
    left = {"load", *(() if flown else ("autopilot", "flexible flight"))}
    calm = [one.name for one in questions(found) if one.yes and one.name in left]
    if calm and found.study.ratio_to_nominal > 1.0:
        for words in nominal_pressure(found.plan):
            yield f"{listed(calm)}: {words}"


_IN_THE_WIND = ("wind", "nozzle rate", "load", "probability", "autopilot", "flexible flight")
"""Questions whose answers rest on the wind of the study."""


def loop_notes(found: Findings) -> Iterator[str]:
    """Yield what was not specified of the autopilot and the nozzle that answer its questions."""
    if found.margins is None and found.card is None:
        return
    from tvclin.answers.gain_notes import actuator_notes, gain_notes  # late: it designs autopilots

    margins = found.margins
    if margins is not None:
        met = bool(found.criteria.are_satisfied(margins))
        yield from gain_notes(found.plan, found.criteria, met)
    else:
        yield from actuator_notes(found.plan)


def _asked(found: Findings) -> Iterator[Question]:
    """Questions with their answers: none that rests on a wind beyond linear aerodynamics."""
    for one in _answered(found):
        beyond = found.study.beyond if one.name in _IN_THE_WIND else ""
        yield Question(one.name, None, (beyond,)) if beyond else one


def _answered(found: Findings) -> Iterator[Question]:
    limit = found.study.limit
    if limit is not None:
        yield _wind(found)
        if found.plan.nozzle.rate_limit is not None:
            yield _rate(found)
        if found.plan.load is not None:
            yield _load(found)
        if found.plan.sizing is not None:
            yield _flight(found)
            yield from _card(found)
        asked = found.plan.availability
        if asked is not None and asked.least_part is not None:
            yield _availability(found, asked.least_part)
        if found.plan.dispersions is not None:
            yield _probability(found, limit)
    if found.plan.design is not None or found.plan.criteria is not None:
        if limit is not None:
            yield _autopilot(found, limit)
        yield _margins(found)
        if limit is not None and found.plan.vehicle.structure is not None:
            yield _flexible(found)


def _wind(found: Findings) -> Question:
    need, by = found.study.required_deflection, found.study.governs
    whose = "this wind requires"
    line: Line = (f"set by {by}",)
    if not need:
        line = ("no deflection is needed",)
    elif np.isinf(need):
        line = ("with this dead band no limit is sufficient",)
    return Question("wind", found.study.sufficient, line, need, whose)


def _rate(found: Findings) -> Question:
    """Whether any control gets by with the limit at the rate that the nozzle has."""
    name, front = "nozzle rate", found.rates
    if front is None:
        return Question(name, None, (_reason(found, "rates"),))
    line: Line = ("the least rate with which any control survives with this limit",)
    if np.isinf(front.needed_rate):
        line = ("with this limit no rate is sufficient",)
    yes = front.above_lower_bound
    if found.head is not None and found.head.rates is not None:
        calm = degrees("asked.calm_rate", front.needed_rate, unit="deg/s")
        line, front = (*line, _at_peak(found), *calm), found.head.rates
        yes = _also(yes, front.above_lower_bound)
    need = front.needed * found.study.of_both
    measure = _of_angles(front.needed_rate, front.rate_limit or np.nan, "deg/s")
    return Question(name, yes, line, need, "at this rate any control requires", measure)


def _load(found: Findings) -> Question:
    """Whether a control that knows the wind keeps to what the structure bears with the limit."""
    name, front = "load", found.loads
    if front is None:
        return Question(name, None, (_reason(found, "loads"),))
    line: Line = ("for this load, of a control that knows the wind",)
    if front.above_lower_bound and front.takes_a_forecast:
        line = (*line, "; a law that does not know when it stops bears more")
    need = front.needed * found.study.of_both
    return Question(
        name, front.above_lower_bound, line, need, "within this load any control requires"
    )


def _flight(found: Findings) -> Question:
    name, asked = "whole flight", found.plan.sizing
    if found.flight is None or asked is None:
        return Question(name, None, (_reason(found, "flight"),))
    total = found.flight[1]
    whole = f"the whole flight of {asked.source}" if asked.source else "the whole flight"
    whose = f"{whole} requires"
    reserve = "; remaining beyond the reserve, which is required too" if total.reserve else ""
    line: Line = (whole, reserve)
    if total.sufficient is None:
        line = (f"{whole} is not sized {', '.join(total.not_sized)}",)
    limit = found.study.limit
    if total.too_slow and (
        limit is None or covers(limit, total.required)
    ):  # the angle is sufficient
        line = (f"the least rate with which the limit is sufficient for {whole}", reserve)
        measure = _of_angles(total.needed_rate, total.rate_limit or np.nan, "deg/s")
        return Question(name, False, line, whose=whose, measure=measure)
    return Question(name, total.sufficient, line, total.required, whose)


def _card(found: Findings) -> Iterator[Question]:
    """Whether the nozzle can do what a law asks of it along the flight, by its worst line."""
    name = "nozzle card"
    if found.card is None:
        if "card" in found.reasons:
            yield Question(name, None, (_reason(found, "card"),))
        return
    verdict = found.card.verdict
    worst = verdict.needs[0]
    measure = None if worst.there is None else Measure(worst.needed, worst.there, worst.unit)
    line: Line = (f"the {worst.name} that {found.card.law} takes along the flight",)
    if verdict.lost or verdict.unknown:
        line = (verdict.reason,)
    yield Question(name, verdict.met, line, measure=measure)


def _availability(found: Findings, least: float) -> Question:
    if found.availability is None:
        return Question("availability", None, (_reason(found, "availability"),))
    a = found.availability
    whole = a.part()
    measure = Measure(100.0 * least, 100.0 * whole.part, "%", 1)
    yes, line = a.reaches(least), str(whole)
    if yes is None:
        line = f"too few soundings to tell whether {100.0 * least:g} % of days fly; {line}"
    return Question("availability", yes, (line,), measure=measure)


def _probability(found: Findings, limit: float) -> Question:
    d = found.dispersed
    if d is None:
        return Question("probability", None, (_reason(found, "dispersed"),))
    r = d.required
    flights = significant("asked.probability", 100.0 * r.probability, 5, "% of flights")
    if np.isinf(r.estimate):
        return Question("probability", False, (*flights, " require more than any limit"))
    if np.isinf(r.upper):
        return Question("probability", None, ("too few cases to judge ", *flights))
    line = ("covers ", *flights, f", with {100.0 * r.confidence:g} % confidence")
    whose = f"{text(flights)} require"
    return Question("probability", bool(covers(limit, r.upper)), line, float(r.upper), whose)


def _autopilot(found: Findings, limit: float) -> Question:
    """Whether the autopilot survives with the limit as a stop, flown; and without any stop."""
    name, c = "autopilot", found.comparison
    if c is None:
        return Question(name, None, (_reason(found, "comparison"),))
    if not c.margins.stable:
        whose = "" if found.flexible is None else " of the flexible vehicle"
        return Question(name, False, (f"the loop{whose} is not stable: {c.margins.reason}",))
    if beyond := beyond_linear(c.peak_angle_of_attack * found.study.of_both, ATTACK):
        return Question(name, None, (beyond,))
    peak = without_stop(found)
    turns = degrees("asked.autopilot", peak, unit="deg")
    free: Line = ("without a limit it would turn the nozzle by ", *turns)
    if found.study.in_both:
        free += (" in both planes",)
    whose = "this autopilot requires"
    rate, most = c.peak_deflection_rate, found.plan.nozzle.rate_limit or np.inf
    if rate > most:
        free += (", at ", *degrees("asked.rate", rate, unit="deg/s"))
    requirement = found.autopilot_requirement
    if requirement is None:  # it cannot be flown: sufficient is what the loop never exceeds
        known = True if covers(limit, peak) and rate <= most else None
        return Question(name, known, (f"{_reason(found, 'stop')}; ", *free), peak, whose)
    yes, nominal = requirement.sufficient(limit), requirement.nominal_deflection
    line: Line = ("flown with its stop; ", *free)
    if np.isinf(nominal):
        line = ("flown with a stop it survives at no limit that was tried; ", *free)
    elif requirement.head is not None:
        whose += f", by the bound for a {found.study.direction} wind"
        needs = degrees("asked.calm", nominal, unit="deg")
        line = ("flown with its stop", _at_peak(found), *needs, "; ", *free)
    needed = nominal if np.isinf(nominal) else requirement.deflection
    return Question(name, yes, line, needed, whose)


def _at_peak(found: Findings) -> str:
    """The dynamic pressure of an upper bound, before the number at the nominal one."""
    wind = f"{found.study.direction} wind"
    return f", with the dynamic pressure at the peak of a {wind} throughout, at the nominal one "


def _also(nominal: bool | None, head: bool | None) -> bool | None:
    """Return an answer that holds at nominal pressure and at more than that of a head wind."""
    return True if nominal and head else None if nominal else nominal


def without_stop(found: Findings) -> float:
    """Return how far [rad] the autopilot turns a nozzle without a stop; nan without one."""
    if found.comparison is None:
        return float("nan")
    return float(found.comparison.peak_deflection * found.study.of_both)


def _margins(found: Findings) -> Question:
    flexible = found.plan.vehicle.structure is not None
    part = "flexible" if flexible else "comparison"
    margins = found.margins
    if getattr(found, part) is None or margins is None:
        return Question("margins", None, (_reason(found, part),))
    met = bool(found.criteria.are_satisfied(margins))
    words, whose = "meets" if met else "does not meet", " of the flexible vehicle" * flexible
    line: Line = (f"the loop{whose} {words} the criteria {found.criteria.name}",)
    judged = [one for one in found.criteria.judge(margins) if np.isfinite(one.surplus)]
    worst = min(judged, key=_spare, default=None)
    if worst is None:
        return Question("margins", met, line)
    of = f" of {worst.band}" if worst.band else ""
    line += (f"; the {worst.requirement.name}{of} has least to spare",)
    return Question("margins", met, line, measure=_measured(worst))


def _spare(one: Judgement) -> float:
    """How much of what is asked is left over."""
    return float(one.surplus) / one.requirement.limit if one.requirement.limit else np.inf


def _measured(one: Judgement) -> Measure:
    """A margin beside what is asked of it, in the unit of tables."""
    limit, unit = one.requirement.shown
    value, digits = unit_factor(unit) * float(one.value), DIGITS[unit]
    return Measure(limit, value, unit, digits, one.requirement.is_upper_limit)


def _flexible(found: Findings) -> Question:
    """Whether the flexible vehicle survives the wind with this limit, flown."""
    f = found.flexible
    if f is None or f.flight is None:
        return Question("flexible flight", None, (_reason(found, "flexible"),))
    part = f" with the {found.study.plane} plane's part of the stop" * found.study.in_both
    flexible, rigid = f.flight.outcomes
    flown = f"flown {NOMINAL} and {f.sample_rate:g} Hz{part}"
    line: Line = (f"{flown} the flexible vehicle {flexible}",)
    if f.flight.survived and rigid != flexible:
        line += (f", the rigid one {rigid}",)
    least = abs(float(f.boundaries[0].deflection)) * found.study.of_both
    limit = found.study.limit
    measure = None if limit is None else _of_angles(least, limit)
    return Question("flexible flight", f.flight.survived, line, measure=measure)


def _of_angles(needed: float, there: float, unit: str = "deg") -> Measure:
    """The measure of angles [rad] or rates [rad/s]."""
    return Measure(float(np.degrees(needed)), float(np.degrees(there)), unit)


def _reason(found: Findings, part: str) -> str:
    return found.reasons.get(part, "there is no answer")
