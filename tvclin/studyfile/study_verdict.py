"""The verdict in one sentence, and the few numbers shown with it."""

import numpy as np

from tvclin.base.lines import Line, degrees, minimum_limit, number, significant
from tvclin.base.quantities import STATIC_TRIM, WIND_KNOWN, sufficiency
from tvclin.boundary.open_loop import Reason
from tvclin.requirement.study import TRUSTS, Study
from tvclin.requirement.study_tables import survivable
from tvclin.studyfile.findings import Findings
from tvclin.studyfile.questions import (
    Question,
    measured,
    questions,
    questions_table,
    sufficient,
    without_stop,
)
from tvclin.winds.shaped import ShapedWind

_NOTHING = "No deflection is needed: this model has no unstable pole that a wind could excite."
"""Verdict where no wind can excite the model."""
_NONE = f"{sufficiency(False)}: with this dead band no limit is, see Assumptions."
"""Verdict where no limit is sufficient."""
SURVIVES = "survives this wind up to"
"""Label of the largest peak that limit and autopilot survive."""
_MAX_PERCENT = 1000.0
"""A surplus above this percentage is shown as an angle alone."""
_ANGLE_RESOLUTION_DEG = 0.001
"""Smallest angle [deg] that the page shows."""


def sentence(findings: Findings) -> Line:
    """Return the verdict, and by how much of the largest requirement."""
    study, answers = findings.study, questions(findings)
    failed = [question for question in answers if question.yes is False]
    unknown = [question for question in answers if question.yes is None and study.limit is not None]
    open_questions = failed or unknown or answers
    sized = [question for question in open_questions if not np.isnan(question.required_deflection)]
    worst = max(sized, key=lambda question: question.required_deflection, default=None)
    if study.limit is None and not failed:
        return _needed(study)
    if study.limit is not None and worst is not None and (failed or not unknown):
        return _limit_against(worst, study.limit, not failed)
    first = open_questions[0]
    word = first.answer
    said = f"{word}: {first.text.partition('; ')[0]}"
    if (
        first.measure is not None and first.whose and np.isnan(first.required_deflection)
    ):  # it needs a rate
        needed, available = measured("verdict", first.measure)[:2]
        return (f"{word}: {first.whose} ", *needed, " and has ", *available, ".")
    if study.limit is None:
        return (f"{said}.",)
    have = degrees("verdict.limit", study.limit, unit="deg")
    return (f"{said}; the limit is ", *have, ".")


def _needed(study: Study) -> Line:
    """Return the verdict without a limit: the required deflection of the wind."""
    need = study.required_deflection
    if reason := study.beyond or study.unknown:
        return (f"{sufficiency(None)}: {reason}.",)
    if not need:
        return (_NOTHING,)
    if np.isinf(need):
        return (_NONE,)
    return (
        "This wind requires ",
        *degrees("verdict.required", need, unit="deg"),
        " of deflection.",
    )


def _limit_against(worst: Question, limit: float, sufficient: bool) -> Line:
    """Return the verdict with a limit: its surplus over the requirement, or its deficit."""
    if not worst.required_deflection:
        return (_NOTHING,)
    if np.isinf(worst.required_deflection):
        return (_NONE if worst.name == "wind" else f"{sufficiency(False)}: {worst.text}.",)
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
    tail = (*by, f" {relation} the ", *needed, f" that {worst.whose}.")
    return (f"{word}: the limit of ", *have, " is ", *tail)


def basis(findings: Findings) -> Line:
    """Return the line on the basis of the verdict: model, plane, dead band and wind."""
    s = findings.study
    wind_text: Line = ()
    if s.sufficient and not sufficient(findings):
        needed = degrees("basis.required", s.required_deflection, unit="deg")
        wind_text = (
            "The wind of this study alone requires ",
            *needed,
            ", which the limit covers. ",
        )
    line: Line = (
        *wind_text,
        f"The verdict is that of the {s.model} model in {_planes(s)}, with a dead band of K = ",
        *significant("basis.dead_band", s.dead_band),
        f", in a {s.shape} wind of ",
        *significant("basis.peak_deg", np.degrees(_judged_wind(s).peak), unit="deg"),
        " for ",
        *significant("basis.duration_s", s.wind.duration, unit="s"),
        f"{_judged_wind(s).gust_text}.",
        *_meets_the_stop(findings),
    )
    if (
        s.required_deflection
        and s.governs != Reason.BOUNDARY
        and len(questions_table(findings).rows) < 2
    ):
        line += (f" The required deflection is set by {s.governs}.",)
    if any(TRUSTS in note for note in s.notes):
        line += (f" Warning: this dead band {TRUSTS} of the wind, see Assumptions.",)
    if findings.flight is not None and findings.flight[1].sufficient is False:
        reserve_text = ", and a reserve" if findings.flight[1].reserve else ""
        line += (f" The whole flight counts all deflections of the nozzle{reserve_text}.",)
    if findings.flight is not None and findings.plan.sizing is not None:
        line += tuple(f" Warning: {doubt}." for doubt in findings.plan.sizing.warnings)
    if s.beyond or findings.dispersed is None or findings.dispersed.success is None:
        return line
    percent = number("basis.success", 100.0 * findings.dispersed.success.estimate, 2, "%")
    return (
        *line,
        " With vehicle and wind dispersed the limit is sufficient in ",
        *percent,
        " of cases.",
    )


def _meets_the_stop(findings: Findings) -> Line:
    """Return the warning of an autopilot that reaches the limit and survives; else empty."""
    survives = any(
        question.name == "autopilot" and question.yes for question in questions(findings)
    )
    turns, limit = without_stop(findings), findings.study.limit
    if limit is None or not survives or not turns > limit:
        return ()
    peak = degrees("basis.autopilot", turns, unit="deg")
    tail = (
        ", more than the limit. Flown with the limit it reaches the limit and survives this"
        " wind, with smaller margins, see Autopilot and margins."
    )
    return (" Warning: without a limit the autopilot would turn the nozzle by ", *peak, tail)


def _planes(s: Study) -> str:
    return "both planes with one stop" if s.judges_both_planes else f"the {s.plane} plane"


def _judged_wind(s: Study) -> ShapedWind:
    """Return the wind of the verdict; for both planes its vector."""
    return s.slanting if s.judges_both_planes and s.slanting is not None else s.wind_in_plane


def facts(findings: Findings) -> tuple[tuple[str, Line], ...]:
    """Return the numbers shown with the verdict, each with its label."""
    s = findings.study
    rows: list[tuple[str, Line]] = []
    if len(questions_table(findings).rows) < 2:  # else it is one of its rows
        need = minimum_limit(degrees("facts.required", s.required_deflection, unit="deg"))
        rows.append(("required deflection", need))
    if s.limit is not None:
        rows.append(("available", degrees("facts.limit", s.limit, unit="deg")))
    if s.limit is not None and s.survivable_peak is not None:
        survived = abs(s.survivable_peak)
        survived = np.fmin(survived, abs(s.judged_peak) * findings.autopilot_survives)
        peak = survivable("facts.survivable_peak", float(survived), abs(s.peak_bound))
        by = ", with this autopilot" if survived < abs(s.survivable_peak) else ""
        rows.append((SURVIVES + by, (*peak, " deg")))
    if not s.judges_both_planes:
        trim = degrees("facts.trim", s.trim_deflection, unit="deg")
        rows.append((STATIC_TRIM, trim))
    if s.model in s.minima and not s.judges_both_planes:
        rows.append((WIND_KNOWN, degrees("facts.minimum", s.minima[s.model], unit="deg")))
    return tuple(rows)
