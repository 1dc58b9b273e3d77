"""The answer in one sentence, and the few numbers that stand beside it."""

import numpy as np

from tvclin.answers.findings import Findings
from tvclin.answers.questions import Question, questions, sufficient
from tvclin.answers.sizing.total import DeflectionTotal
from tvclin.answers.study import Study, outlasts_one_pole
from tvclin.answers.study_notes import TRUSTS
from tvclin.base.lines import Line, degrees, least, number, significant
from tvclin.boundary.limit import BOUNDARY
from tvclin.show.report.blocks import Section, Table
from tvclin.show.report.flight import whose

_NOTHING = "No deflection is needed: this model has no unstable pole that a wind could excite."
_NONE = "Not enough: with this dead band no limit is, see Assumptions."
_SENSIBLE = 1000.0
"""Above this many percent a percentage says nothing."""


def sentence(found: Findings) -> Line:
    """Return the verdict, that of the worst question: enough or not, and by how much."""
    study = found.study
    failed = next((one for one in questions(found) if one.yes is not True), None)
    if failed is not None and failed.name != "wind":
        return _not_only_wind(found, failed)
    if not study.required_deflection:
        return (_NOTHING,)
    if study.limit is None and np.isinf(study.required_deflection):
        return (_NONE,)
    if study.limit is None:
        needed = degrees("verdict.required", study.required_deflection, unit="deg")
        return ("This wind needs ", *needed, " of deflection.")
    return _in_this_wind(study.required_deflection, study.limit, failed is None)


def _not_only_wind(found: Findings, failed: Question) -> Line:
    """The answer to a question beyond the wind that is not yes."""
    limit = found.study.limit
    if limit is not None and failed.name == "whole flight" and found.flight is not None:
        return _short_over_flight(found.flight[1], limit, whose(found))
    word = "Not enough" if failed.yes is False else "Not shown to be enough"
    if limit is None:
        return (f"{word}: {failed.text}.",)
    have = degrees("verdict.limit", limit, unit="deg")
    return (f"{word}: {failed.text}; the limit is ", *have, ".")


def _in_this_wind(need: float, limit: float, enough: bool) -> Line:
    """By how much a limit is enough, or not."""
    if need == float("inf"):
        return (_NONE,)
    needed = degrees("verdict.required", need, unit="deg")
    have = degrees("verdict.limit", limit, unit="deg")
    by = degrees("verdict.surplus", abs(limit - need), unit="deg")
    percent = 100.0 * abs(limit - need) / need
    part: Line = (" (", *number("verdict.surplus_percent", percent, 1, "%"), ")")
    if percent > _SENSIBLE:
        part = ()
    word, side = ("Enough", "more than") if enough else ("Not enough", "short of")
    tail = (*by, *part, f" {side} the ", *needed, " that this wind needs.")
    return (f"{word}: the limit of ", *have, " is ", *tail)


def asked(found: Findings) -> Section | None:
    """Return every question with its answer; None where only one is asked."""
    each = questions(found)
    if len(each) < 2:
        return None
    rows: tuple[tuple[Line, ...], ...] = tuple(
        ((one.name,), (one.answer,), one.line) for one in each
    )
    table = Table("Every question, and its answer", ("question", "enough?", "why"), rows)
    return Section("asked", "What was asked", (table,))


def _short_over_flight(total: DeflectionTotal, limit: float, of: str) -> Line:
    if total.sufficient is None:
        where = f"the whole flight{of} is not sized {', '.join(total.not_sized)}"
        have = degrees("verdict.limit", limit, unit="deg")
        return ("Not shown to be enough: the limit is ", *have, f", but {where}.")
    needed = degrees("verdict.flight", total.required, unit="deg")
    by = degrees("verdict.flight_short", total.required - limit, unit="deg")
    have = degrees("verdict.limit", limit, unit="deg")
    words = (f"Not enough: the whole flight{of} needs ", *needed, ", ", *by)
    return (*words, " more than the limit of ", *have, ".")


def basis(found: Findings) -> Line:
    """Return on what the verdict rests."""
    s = found.study
    alone: Line = ()
    if s.sufficient and not sufficient(found):
        needed = degrees("basis.required", s.required_deflection, unit="deg")
        alone = ("The wind of this study alone needs ", *needed, ", which the limit covers. ")
    line: Line = (
        *alone,
        f"On the {s.model} model in {_planes(s)}, with a dead band of ",
        *significant("basis.dead_band", s.dead_band),
        f", in a {s.shape} wind of ",
        *significant("basis.peak_deg", np.degrees(_peak(s)), unit="deg"),
        " for ",
        *significant("basis.duration_s", s.wind.duration, unit="s"),
        f"{s.gust_words}.",
    )
    if s.required_deflection and s.governs != BOUNDARY:
        line += (f" What is required is governed by {s.governs}.",)
    if outlasts_one_pole(s):
        line += (" Beware: this wind lasts longer than one pole can speak for, see Assumptions.",)
    if any(TRUSTS in note for note in s.notes):
        line += (f" Beware: this dead band {TRUSTS} of the wind, see Assumptions.",)
    if found.flight is not None and found.flight[1].sufficient is False:
        kept = ", and a reserve" if found.flight[1].reserve else ""
        line += (f" The flight counts all else that the nozzle has to do{kept}.",)
    if found.flight is not None and found.plan.sizing is not None:
        line += tuple(f" Beware: {doubt}." for doubt in found.plan.sizing.warnings)
    if found.dispersed is None or found.dispersed.success is None:
        return line
    percent = number("basis.success", 100.0 * found.dispersed.success.estimate, 1, "%")
    return (
        *line,
        " With vehicle and wind dispersed the limit is enough in ",
        *percent,
        " of cases.",
    )


def _planes(s: Study) -> str:
    return "both planes with one stop" if s.in_both else f"the {s.plane} plane"


def _peak(s: Study) -> float:
    """The peak of the wind on which the verdict rests [rad]: of both planes that of the vector."""
    return float(s.slanting.peak if s.in_both and s.slanting is not None else s.wind.peak)


def facts(found: Findings) -> tuple[tuple[str, Line], ...]:
    """Return the numbers beside the verdict, each with what it is."""
    s = found.study
    rows: list[tuple[str, Line]] = [
        ("this wind needs", least(degrees("facts.required", s.required_deflection, unit="deg")))
    ]
    if found.flight is not None:
        needed = degrees("facts.flight", found.flight[1].required, unit="deg")
        rows.append(("the whole flight needs", needed))
    if s.limit is not None:
        rows.append(("available", degrees("facts.limit", s.limit, unit="deg")))
    if s.survivable_peak is not None:
        survived = degrees("facts.survivable_peak", abs(s.survivable_peak), 3, "deg")
        rows.append(("wind it survives", survived))
    if not s.in_both:
        trim = degrees("facts.trim", s.trim_deflection, unit="deg")
        rows.append(("ideal trim takes", trim))
    if s.model in s.minima and not s.in_both:
        rows.append(("least, wind known", degrees("facts.minimum", s.minima[s.model], unit="deg")))
    if found.dispersed is not None:
        required = found.dispersed.required
        covers = f"covers {100 * required.probability:g} % of cases"
        rows.append((covers, degrees("facts.covers", required.upper, unit="deg")))
    return tuple(rows)
