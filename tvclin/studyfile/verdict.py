"""The verdict of a study in one sentence, with its numbers, and the table of all answers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tvclin.base.lines import Line, Table, degrees, minimum_limit, number, significant
from tvclin.base.quantities import STATIC_TRIM, WIND_KNOWN, sufficiency
from tvclin.boundary.open_loop import Reason
from tvclin.control.margins.bands import GAIN, PHASE, BandMargins
from tvclin.control.margins.margins import UNSTABLE, margin
from tvclin.requirement.study import TRUSTS, Study
from tvclin.requirement.study_tables import survivable
from tvclin.studyfile.findings import Findings
from tvclin.studyfile.questions import Measure, Question, questions, without_stop
from tvclin.winds.shaped import ShapedWind

if TYPE_CHECKING:
    from tvclin.control.autopilot.detuning import Detuned

_NOTHING = "No deflection is needed: this model has no unstable pole that a wind could excite"
"""Verdict where no wind can excite the model."""
_IDEAL = "In this wind the ideal trim law requires"
"""Begin of the verdict without a limit."""
_NONE = f"{sufficiency(False)}: with this dead band no limit is"
"""Verdict where no limit is sufficient."""
SURVIVES = "survives this wind up to"
"""Label of the largest peak that limit and autopilot survive."""
_MAX_PERCENT = 1000.0
"""A surplus above this percentage is shown as an angle alone."""
_ANGLE_RESOLUTION_DEG = 0.001
"""Smallest angle [deg] that the page shows."""


def sentence(findings: Findings) -> Line:
    """Return the verdict on findings as a sentence: the first line of commands and of the page.

    It compares the limit with the largest requirement, or has the first answer that is not yes, and
    names the other questions whose answer is not yes. No precedes not known, and not known precedes
    yes: only questions of the first of these answers are compared. Where answers are not known, the
    limit is compared only with a requirement of theirs that is larger. Without a limit and without
    a no it states the required deflection.
    """
    limit, answers = findings.study.limit, questions(findings)
    failed = [question for question in answers if question.yes is False]
    unknown = [question for question in answers if question.yes is None and limit is not None]
    judged = failed or unknown or list(answers)
    sized = [question for question in judged if not np.isnan(question.required_deflection)]
    subject = max(sized, key=lambda question: question.required_deflection, default=None)
    if limit is None and not failed:  # the required deflection, without a verdict
        subject, line = None, _required(findings.study)
    elif limit is not None and subject is not None and (failed or not unknown):
        line = _limit_against(subject, limit, not failed)  # sufficient, or not
    elif limit is not None and subject is not None and limit < subject.required_deflection < np.inf:
        line = _limit_against(subject, limit, None)  # not known, and below a requirement
    else:
        subject = judged[0]  # an answer without a comparison
        line = _answered(subject, limit)
    others = [question for question in answers if question is not subject and not question.yes]
    return (*line, *_covered_wind(answers), *_named(others), ".")


def _answered(question: Question, limit: float | None) -> Line:
    """Return the answer to a question, with its reason, or with what it requires and has.

    `limit`: deflection limit [rad], named after the reason; None without one.
    """
    measure = question.measure
    # `clause`: beginning of a sentence on a requirement, "this autopilot requires"; with NaN the
    # measure alone has the required value, such as a rate
    if measure is not None and question.clause and np.isnan(question.required_deflection):
        required, available, _ = measured("verdict", measure)
        return (f"{question.answer}: {question.clause} ", *required, " and has ", *available)
    first_reason = question.text.partition("; ")[0].rstrip(".")
    words = first_reason.replace(f": {question.answer}", "")  # the sentence begins with the answer
    line: Line = (f"{question.answer}: {words}",)
    if limit is None:
        return line
    return (*line, "; the limit is ", *degrees("verdict.limit", limit, unit="deg"))


def _covered_wind(answers: Sequence[Question]) -> Line:
    """Return words on the requirement in the wind, which the limit covers, as a line.

    `answers`: all questions. Empty if all answers are yes, or the limit does not cover the wind.
    """
    wind = next((question for question in answers if question.name == "wind"), None)
    if not (wind and wind.yes and wind.required_deflection) or all(q.yes for q in answers):
        return ()
    required = degrees("verdict.wind", wind.required_deflection, unit="deg")
    law = " that the ideal trim law requires in this wind"
    return (f"; {sufficiency(True)} for the ", *required, law)


def _named(others: Sequence[Question]) -> Line:
    """Return the names of questions by their answers, as a line.

    `others`: the questions. A reason why answers are not known is named if all have the same.
    """
    names: dict[str, list[str]] = {}
    reasons = {q.text.partition("; ")[0]: None for q in others if q.yes is None}
    for question in others:
        names.setdefault(question.answer, []).append(question.name)
    words = {word: f"{word}: {', '.join(of_word)}" for word, of_word in sorted(names.items())}
    if len(reasons) == 1:
        words[sufficiency(None)] += f" ({next(iter(reasons))})"
    return (f"; also {'; '.join(words.values())}",) if words else ()


def _required(study: Study) -> Line:
    """Return the verdict on a study without a limit: the required deflection of its wind.

    It is zero where no unstable pole is excited, and infinite where no limit is sufficient.
    """
    need = study.required_deflection
    if reason := study.beyond_linear or study.unknown:
        return (f"{sufficiency(None)}: {reason}",)
    if not need:
        return (_NOTHING,)
    if np.isinf(need):
        return (_NONE,)
    if need >= np.pi / 2:
        return (f"{_IDEAL} more than 90 deg of deflection, which no nozzle has",)
    required = degrees("verdict.required", need, unit="deg")
    return (f"{_IDEAL} ", *required, " of deflection")


def _limit_against(worst: Question, limit: float, sufficient: bool | None) -> Line:
    """Return the verdict on a limit [rad]: its surplus over a requirement, or its deficit.

    `worst`: question with the requirement. `sufficient`: whether the limit covers it; None where
    the requirement is an upper bound, so that a smaller limit may be sufficient too. A requirement
    of zero, or infinite, has its own sentence. The difference is in deg, and in percent of the
    requirement up to `_MAX_PERCENT`.
    """
    if not worst.required_deflection:
        return (_NOTHING,)
    if np.isinf(worst.required_deflection):
        return (_NONE if worst.name == "wind" else f"{sufficiency(False)}: {worst.text}",)
    needed = degrees("verdict.required", worst.required_deflection, unit="deg")
    have = degrees("verdict.limit", limit, unit="deg")
    difference = abs(limit - worst.required_deflection)
    percent = 100.0 * difference / worst.required_deflection
    by: Line = degrees("verdict.surplus", difference, unit="deg")
    if float(np.degrees(difference)) < _ANGLE_RESOLUTION_DEG:
        by = (f"less than {_ANGLE_RESOLUTION_DEG:g} deg",)
    elif percent <= _MAX_PERCENT:
        by += (" (", *number("verdict.surplus_percent", percent, 1, "%"), ")")
    word, relation = sufficiency(sufficient), "more than" if sufficient else "short of"
    tail = (*by, f" {relation} the ", *needed, f" that {worst.clause}")
    return (f"{word}: the limit of ", *have, " is ", *tail)


def basis(findings: Findings) -> Line:
    """Return the line on the basis of the verdict in findings: model, plane, dead band and wind.

    What sets the required deflection stands here only where no table of questions has it. Warnings,
    the whole flight and the dispersions follow if they bear on the verdict.
    """
    s = findings.study
    planes = "both planes with one stop" if s.judges_both_planes else f"the {s.plane} plane"
    line: Line = (
        f"The verdict is that of the {s.model} model in {planes}, with a dead band of K = ",
        *significant("basis.dead_band", s.dead_band),
        f", in a {s.shape} wind of ",
        *significant("basis.peak_deg", np.degrees(_judged_wind(s).peak), unit="deg"),
        " for ",
        *significant("basis.duration_s", s.wind.duration, unit="s"),
        f"{_judged_wind(s).gust_text}.",
        *_reaches_the_limit(findings),
    )
    if (
        s.required_deflection
        and s.governs != Reason.BOUNDARY
        and len(questions_table(findings).rows) < 2  # a table of one row is not shown
    ):
        line += (f" The required deflection is set by {s.governs}.",)
    if any(TRUSTS in note for note in s.notes):
        line += (f" Warning: this dead band {TRUSTS} of the wind, see Assumptions.",)
    _, total = findings.flight or (None, None)  # sizing, and its worst total
    if total is not None and total.sufficient is False:
        reserve_text = ", and a reserve" if total.reserve else ""
        line += (f" The whole flight counts all deflections of the nozzle{reserve_text}.",)
    if findings.flight is not None and findings.plan.sizing is not None:
        line += tuple(f" Warning: {doubt}." for doubt in findings.plan.sizing.warnings)
    if s.beyond_linear or findings.dispersed is None or findings.dispersed.success is None:
        return line
    percent = number("basis.success", 100.0 * findings.dispersed.success.estimate, 2, "%")
    words = " With vehicle and wind dispersed the limit is sufficient in "
    return (*line, words, *percent, " of cases.")


def _reaches_the_limit(findings: Findings) -> Line:
    """Return the warning, in findings of a study, of an autopilot that survives at the limit."""
    survives = any(
        question.name == "autopilot" and question.yes for question in questions(findings)
    )
    # peak deflection of the autopilot without a limit [rad], NaN without an autopilot
    unlimited, limit = without_stop(findings), findings.study.limit
    if limit is None or not survives or not unlimited > limit:
        return ()
    peak = degrees("basis.autopilot", unlimited, unit="deg")
    tail = (
        ", more than the limit. Flown with the limit it reaches the limit and survives this"
        " wind, with smaller margins, see Autopilot and margins."
    )
    return (" Warning: without a limit the autopilot would turn the nozzle by ", *peak, tail)


def _judged_wind(s: Study) -> ShapedWind:
    """Return the wind of the verdict of a study `s`; for both planes its vector."""
    return s.slanting if s.judges_both_planes and s.slanting is not None else s.wind_in_plane


def facts(findings: Findings) -> tuple[tuple[str, Line], ...]:
    """Return the numbers of findings shown with the verdict, each with its label.

    The survived peak [rad] is the smaller of two: that of the limit alone, and that which the
    autopilot survives, flown with the limit. In both planes it is of the vector of the wind.
    """
    s = findings.study
    rows: list[tuple[str, Line]] = []
    if len(questions_table(findings).rows) < 2:  # else it is one of its rows
        need = minimum_limit(degrees("facts.required", s.known_deflection, unit="deg"))
        rows.append(("required deflection", need))
    if s.limit is not None:
        rows.append(("available", degrees("facts.limit", s.limit, unit="deg")))
    if s.limit is not None and s.survivable_peak is not None:
        peak_survived, by = s.survivable_peak, ""  # [rad]
        if findings.autopilot_survives < (s.survivable_factor or 0.0):  # not NaN, without one
            peak_survived, by = s.peak_at(findings.autopilot_survives), ", with this autopilot"
        peak = survivable("facts.survivable_peak", abs(peak_survived), abs(s.peak_bound))
        gust = ", its gust included" if _judged_wind(s).gust_text else ""
        rows.append((f"{SURVIVES}{gust}{by}", (*peak, " deg")))
    if not s.judges_both_planes:
        trim = degrees("facts.trim", s.trim_deflection, unit="deg")
        rows.append((STATIC_TRIM, trim))
    if s.model in s.minima and not s.judges_both_planes:
        rows.append((WIND_KNOWN, degrees("facts.minimum", s.minima[s.model], unit="deg")))
    return tuple(rows)


HEAD = ("question", "answer", "required", "available", "remaining", "why")
_NUMBERS = ("required", "available", "remaining")
"""Names of the numbers of a measure, below the headings required, available and remaining."""
_UNITS_BY_DECIMALS = ("deg", "deg/s", "%", "dB", "ms", "")
"""Units of which the digits behind the point are given; of others four digits count."""
_NOT_JUDGED = "not judged"
"""Answer of values that no criterion bounds."""
_MAX_NAMED_CHANGES = 3
"""Number of changes that are named of those that miss the criteria."""


def questions_table(findings: Findings) -> Table:
    """Return the table of the questions of findings with their answers, the worst first.

    Below them are the values that are not judged.
    """
    judged = sorted(questions(findings), key=_worst_first)
    rows = [_row(question, question.answer) for question in judged]
    rows += [_row(question, _NOT_JUDGED) for question in unjudged_values(findings)]
    return Table("Every question, and its answer, worst first", HEAD, tuple(rows))


def _worst_first(question: Question) -> tuple[int, float]:
    """Return the sort key of a question: no, not known, yes, each by required over available.

    A question without these numbers comes last among its equals.
    """
    ratio = np.nan if question.measure is None else question.measure.ratio
    return (False, None, True).index(question.yes), np.inf if np.isnan(ratio) else -ratio


def _row(question: Question, answer: str) -> tuple[Line, ...]:
    """Return the row of a question in the table of answers, six cells.

    They are its name, the answer, three cells of its measure (empty without one; required,
    available, remaining), and the reason after the name of the required quantity. Where the answer
    is not known the required value is a bound or an estimate: what remains of it, and that none is
    sufficient by it, are no answers and stay empty.
    """
    cells: tuple[Line, ...] = (("",),) * 3
    if question.measure is not None:
        cells = measured(f"answer.{question.name.replace(' ', '_')}", question.measure)
        if question.yes is None:
            required, available, _remaining = cells
            known = np.isfinite(question.measure.required)
            cells = (required if known else ("",), available, ("",))
    quantity = f"{question.quantity}: " if question.quantity else ""
    return ((question.name,), (answer,), *cells, (quantity, *question.line))


def measured(key: str, measure: Measure) -> tuple[Line, ...]:
    """Return the required, available and remaining amount of a measure as lines, with units.

    The measure is of a deflection limit or another capability. Where no amount is sufficient, the
    remaining one is blank. `key`: begin of the unique names of the numbers on the page.
    """
    required, available, remaining = (_shown(f"{key}.{k}", k, measure) for k in _NUMBERS)
    if np.isinf(measure.required):
        return (("none is sufficient",), available, ("",))
    return (required, available, remaining)


def _shown(key: str, name: str, measure: Measure) -> Line:
    """Return the required, available or remaining value of a question as a line, in its unit.

    `key`: unique name of the number on the page, without its unit. `name`: which field of
    `measure`. An infinite required angle is shown as a text.
    """
    value, unit = getattr(measure, name), measure.unit
    suffix = "percent" if unit == "%" else unit.replace("/", "_per_").replace(" ", "_")
    key += f"_{suffix}" if suffix else ""
    if unit not in _UNITS_BY_DECIMALS:
        return significant(key, value, unit=unit)
    line = number(key, value, measure.digits, unit)  # `digits` behind the point
    return minimum_limit(line) if name == "required" and unit == "deg" else line


def unjudged_values(findings: Findings) -> Iterator[Question]:
    """Yield the values of findings that no criterion bounds, as questions without an answer."""
    margins = findings.margins
    if isinstance(margins, BandMargins) and not findings.criteria.has_mode_limits:
        yield from _modes(margins)
    if findings.flexible is not None and findings.flexible.detuned is not None:
        yield Question("modes detuned", None, (_missed(findings.flexible.detuned),))
    if findings.availability is not None and findings.availability.limit is not None:
        request = findings.plan.availability
        if request is not None and request.least_part is None:
            fraction = findings.availability.fraction()
            words = f"{fraction}; no least_part is specified in [availability]"
            yield Question("availability", None, (words,))


def _missed(detuned: Detuned) -> str:
    """Return the changes of one mode that miss the criteria, in words, the unstable ones first.

    `detuned`: margins of the changes; its first row, the nominal loop, is no change.
    """
    changes = detuned.changes[1:]
    unstable = [k for k, margin in enumerate(detuned.critical_margin[1:]) if margin == UNSTABLE]
    missed = [k for k, satisfied in enumerate(detuned.satisfied[1:]) if not satisfied]
    named = [changes[k] for k in missed if k not in unstable]
    lists = {"UNSTABLE": [changes[k] for k in unstable], "margins too small": named}
    words = f"{len(missed)} of {len(changes)} changes of one mode miss the criteria"
    for what, names in lists.items():
        more = ", ..." * (len(names) > _MAX_NAMED_CHANGES)
        words += f"; {what}: {', '.join(names[:_MAX_NAMED_CHANGES])}{more}" if names else ""
    return words


def _modes(margins: BandMargins) -> Iterator[Question]:
    """Yield the modes with the smallest gain and phase margins, as a question without an answer.

    A gain-stabilised mode stays below unit loop gain at every phase; a phase-stabilised one exceeds
    it, with a phase margin.
    """
    gains = [mode for mode in margins.modes if mode.stabilised == GAIN]
    phases = [mode for mode in margins.modes if mode.stabilised == PHASE]
    line: Line = ()
    if gains:
        worst = min(gains, key=lambda mode: float(mode.gain_margin_dB))
        line += (f"{worst.name} stays ", *margin("answer.mode.gain", worst.gain_margin_dB, "dB"))
        line += (" below one",)
    if phases:
        worst = min(phases, key=lambda mode: float(mode.phase_margin_deg))
        has = margin("answer.mode.phase", worst.phase_margin_deg, "deg")
        line += (", " * bool(line) + f"{worst.name} has ", *has, " of phase")
    if line:
        words = "; no criterion of modes without mode_gain_margin_dB in [criteria]"
        yield Question("modes", None, (*line, words))
