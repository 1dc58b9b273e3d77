"""The answer in one sentence, and the few numbers that stand beside it."""

import numpy as np

from tvclin.answers.asked_table import asked_table, measured
from tvclin.answers.findings import Findings
from tvclin.answers.questions import (
    Question,
    questions,
    sufficient,
    without_stop,
)
from tvclin.answers.study import Study
from tvclin.answers.study_notes import TRUSTS
from tvclin.answers.study_tables import survivable
from tvclin.base.lines import Line, degrees, minimum_limit, number, significant
from tvclin.base.quantities import STATIC_TRIM, WIND_KNOWN, sufficiency
from tvclin.boundary.open_loop import Reason
from tvclin.show.report.blocks import Section
from tvclin.winds.shaped import ShapedWind

_NOTHING = "No deflection is needed: this model has no unstable pole that a wind could excite."
_NONE = f"{sufficiency(False)}: with this dead band no limit is, see Assumptions."
SURVIVES = "survives this wind up to"
"""How the largest peak is called that limit and autopilot survive, whatever else is asked."""
_SENSIBLE = 1000.0
"""Above this many percent a percentage says nothing."""
_LEAST_SHOWN = 0.001
"""The last digit of an angle [deg] on the page."""


def sentence(found: Findings) -> Line:
    """Return the verdict, and by how much of the largest requirement."""
    study, each = found.study, questions(found)
    failed = [one for one in each if one.yes is False]
    unknown = [one for one in each if one.yes is None and study.limit is not None]
    asked = failed or unknown or each
    sized = [one for one in asked if not np.isnan(one.needs)]
    worst = max(sized, key=lambda one: one.needs, default=None)
    if study.limit is None and not failed:
        return _needed(study)
    if study.limit is not None and worst is not None and (failed or not unknown):
        return _beside(worst, study.limit, not failed)
    first = asked[0]
    word = first.answer
    said = f"{word}: {first.text.partition('; ')[0]}"
    if first.measure is not None and first.whose and np.isnan(first.needs):  # it needs a rate
        needed, there = measured("verdict", first.measure)[:2]
        return (f"{word}: {first.whose} ", *needed, " and has ", *there, ".")
    if study.limit is None:
        return (f"{said}.",)
    have = degrees("verdict.limit", study.limit, unit="deg")
    return (f"{said}; the limit is ", *have, ".")


def _needed(study: Study) -> Line:
    """What the wind needs, where no limit is in question."""
    need = study.required_deflection
    if study.beyond:
        return (f"{sufficiency(None)}: {study.beyond}.",)
    if not need:
        return (_NOTHING,)
    if np.isinf(need):
        return (_NONE,)
    return (
        "This wind requires ",
        *degrees("verdict.required", need, unit="deg"),
        " of deflection.",
    )


def _beside(worst: Question, limit: float, sufficient: bool) -> Line:
    """By how much a limit is sufficient for a question, or not."""
    if not worst.needs:
        return (_NOTHING,)
    if np.isinf(worst.needs):
        return (_NONE if worst.name == "wind" else f"{sufficiency(False)}: {worst.text}.",)
    needed = degrees("verdict.required", worst.needs, unit="deg")
    have = degrees("verdict.limit", limit, unit="deg")
    apart = abs(limit - worst.needs)
    percent = 100.0 * apart / worst.needs
    by: Line = degrees("verdict.surplus", apart, unit="deg")
    if float(np.degrees(apart)) < _LEAST_SHOWN:
        by = (f"less than {_LEAST_SHOWN:g} deg",)
    elif percent <= _SENSIBLE:
        by += (" (", *number("verdict.surplus_percent", percent, 1, "%"), ")")
    word, side = sufficiency(sufficient), "more than" if sufficient else "short of"
    tail = (*by, f" {side} the ", *needed, f" that {worst.whose}.")
    return (f"{word}: the limit of ", *have, " is ", *tail)


def asked(found: Findings) -> Section | None:
    """Return every question with its answer; None where only one is asked."""
    table = asked_table(found)
    return Section("asked", "What was asked", (table,)) if len(table.rows) > 1 else None


def basis(found: Findings) -> Line:
    """Return on what the verdict rests."""
    s = found.study
    alone: Line = ()
    if s.sufficient and not sufficient(found):
        needed = degrees("basis.required", s.required_deflection, unit="deg")
        alone = ("The wind of this study alone needs ", *needed, ", which the limit covers. ")
    line: Line = (
        *alone,
        f"The verdict rests on the {s.model} model in {_planes(s)} and on a dead band of K = ",
        *significant("basis.dead_band", s.dead_band),
        f", in a {s.shape} wind of ",
        *significant("basis.peak_deg", np.degrees(_blows(s).peak), unit="deg"),
        " for ",
        *significant("basis.duration_s", s.wind.duration, unit="s"),
        f"{_blows(s).gust_text}.",
        *_meets_the_stop(found),
    )
    if s.required_deflection and s.governs != Reason.BOUNDARY and asked(found) is None:
        line += (f" What this wind needs is set by {s.governs}.",)
    if any(TRUSTS in note for note in s.notes):
        line += (f" Beware: this dead band {TRUSTS} of the wind, see Assumptions.",)
    if found.flight is not None and found.flight[1].sufficient is False:
        kept = ", and a reserve" if found.flight[1].reserve else ""
        line += (f" The whole flight counts all that the nozzle has to do{kept}.",)
    if found.flight is not None and found.plan.sizing is not None:
        line += tuple(f" Beware: {doubt}." for doubt in found.plan.sizing.warnings)
    if s.beyond or found.dispersed is None or found.dispersed.success is None:
        return line
    percent = number("basis.success", 100.0 * found.dispersed.success.estimate, 2, "%")
    return (
        *line,
        " With vehicle and wind dispersed the limit is sufficient in ",
        *percent,
        " of cases.",
    )


def _meets_the_stop(found: Findings) -> Line:
    """Where the autopilot turns the nozzle to its stop and survives nevertheless."""
    survives = any(one.name == "autopilot" and one.yes for one in questions(found))
    turns, limit = without_stop(found), found.study.limit
    if limit is None or not survives or not turns > limit:
        return ()
    peak = degrees("basis.autopilot", turns, unit="deg")
    met = (
        ", more than the limit. Flown with the limit as its stop it reaches the stop and survives"
        " this wind, with smaller margins, see Autopilot and margins."
    )
    return (" Beware: without a limit the autopilot would turn the nozzle by ", *peak, met)


def _planes(s: Study) -> str:
    return "both planes with one stop" if s.in_both else f"the {s.plane} plane"


def _blows(s: Study) -> ShapedWind:
    """The wind on which the verdict rests: of both planes the vector."""
    return s.slanting if s.in_both and s.slanting is not None else s.wind_in_plane


def facts(found: Findings) -> tuple[tuple[str, Line], ...]:
    """Return the numbers beside the verdict, each with what it is."""
    s = found.study
    rows: list[tuple[str, Line]] = []
    if asked(found) is None:  # else it is one of its rows
        need = minimum_limit(degrees("facts.required", s.required_deflection, unit="deg"))
        rows.append(("required deflection", need))
    if s.limit is not None:
        rows.append(("available", degrees("facts.limit", s.limit, unit="deg")))
    if s.limit is not None and s.survivable_peak is not None:
        survived = abs(s.survivable_peak)
        survived = np.fmin(survived, abs(s.judged_peak) * found.autopilot_survives)
        peak = survivable("facts.survivable_peak", float(survived), abs(s.peak_bound))
        by = ", with this autopilot" if survived < abs(s.survivable_peak) else ""
        rows.append((SURVIVES + by, (*peak, " deg")))
    if not s.in_both:
        trim = degrees("facts.trim", s.trim_deflection, unit="deg")
        rows.append((STATIC_TRIM, trim))
    if s.model in s.minima and not s.in_both:
        rows.append((WIND_KNOWN, degrees("facts.minimum", s.minima[s.model], unit="deg")))
    return tuple(rows)
