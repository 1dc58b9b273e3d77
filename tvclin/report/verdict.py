"""The answer in one sentence, and the few numbers that stand beside it."""

import numpy as np

from tvclin.report.blocks import Line, degrees, number, significant
from tvclin.report.findings import Findings
from tvclin.report.flight import whose
from tvclin.report.sections import gust_words
from tvclin.sizing import DeflectionTotal
from tvclin.study import outlasts_one_pole

_NOTHING = "No deflection is needed: this vehicle has no unstable pole that a wind could excite."


_SENSIBLE = 1000.0
"""Above this many percent a percentage says nothing."""


def sentence(found: Findings) -> Line:
    """Return the verdict: enough or not, and by how much."""
    study = found.study
    need, limit = study.required_deflection, study.limit
    needed = degrees("verdict.required", need, unit="deg")
    if not need:
        return (_NOTHING,)
    if limit is None:
        return ("This wind needs ", *needed, " of deflection.")
    surplus = abs(limit - need)
    if study.sufficient and found.flight is not None and not found.sufficient:
        return _short_over_flight(found.flight[1], limit, whose(found))
    by = degrees("verdict.surplus", surplus, unit="deg")
    percent = 100.0 * surplus / need
    part: Line = (" (", *number("verdict.surplus_percent", percent, 1, "%"), ")")
    if percent > _SENSIBLE:
        part = ()
    have = degrees("verdict.limit", limit, unit="deg")
    if study.sufficient:
        tail = (*by, *part, " more than the ", *needed, " that this wind needs.")
        return ("Enough: the limit of ", *have, " is ", *tail)
    tail = (*by, *part, " short of the ", *needed, " that this wind needs.")
    return ("Not enough: the limit of ", *have, " is ", *tail)


def _short_over_flight(total: DeflectionTotal, limit: float, of: str) -> Line:
    if total.sufficient is None:
        where = f"the whole flight{of} is not sized {', '.join(total.not_sized)}"
        have = degrees("verdict.limit", limit, unit="deg")
        return ("The limit of ", *have, f" is not known to be enough: {where}.")
    needed = degrees("verdict.flight", total.required, unit="deg")
    by = degrees("verdict.flight_short", total.required - limit, unit="deg")
    have = degrees("verdict.limit", limit, unit="deg")
    words = (f"Not enough: the whole flight{of} needs ", *needed, ", ", *by)
    return (*words, " more than the limit of ", *have, ".")


def basis(found: Findings) -> Line:
    """Return on what the verdict rests."""
    s = found.study
    alone: Line = ()
    if s.sufficient and not found.sufficient:
        needed = degrees("basis.required", s.required_deflection, unit="deg")
        alone = ("The wind of this study alone needs ", *needed, ", which the limit covers. ")
    line: Line = (
        *alone,
        f"On the {s.model} model in the {s.plane} plane, with a dead band of ",
        *significant("basis.dead_band", s.dead_band),
        f", in a {s.shape} wind of ",
        *significant("basis.peak_deg", np.degrees(s.wind.peak), unit="deg"),
        " for ",
        *significant("basis.duration_s", s.wind.duration, unit="s"),
        f"{gust_words(s)}.",
    )
    if outlasts_one_pole(s):
        line += (" Beware: this wind lasts longer than one pole can speak for, see Assumptions.",)
    if found.flight is not None and found.flight[1].sufficient is False:
        kept = ", and a reserve" if found.flight[1].reserve else ""
        line += (f" The flight counts all else that the nozzle has to do{kept}.",)
    if found.flight is not None and found.plan.sizing is not None:
        line += tuple(f" Beware: {doubt}." for doubt in found.plan.sizing.doubts)
    if found.dispersed is None or found.dispersed.success is None:
        return line
    percent = number("basis.success", 100.0 * found.dispersed.success.estimate, 1, "%")
    return (
        *line,
        " With vehicle and wind dispersed the limit is enough in ",
        *percent,
        " of cases.",
    )


def facts(found: Findings) -> tuple[tuple[str, Line], ...]:
    """Return the numbers beside the verdict, each with what it is."""
    s = found.study
    rows: list[tuple[str, Line]] = [
        ("this wind needs", degrees("facts.required", s.required_deflection, unit="deg"))
    ]
    if found.flight is not None:
        needed = degrees("facts.flight", found.flight[1].required, unit="deg")
        rows.append(("the whole flight needs", needed))
    if s.limit is not None:
        rows.append(("available", degrees("facts.limit", s.limit, unit="deg")))
    if s.survivable_peak is not None:
        survived = degrees("facts.survivable_peak", abs(s.survivable_peak), 3, "deg")
        rows.append(("wind it survives", survived))
    rows.append(("ideal trim takes", degrees("facts.trim", s.trim_deflection, unit="deg")))
    if s.model in s.minima:
        rows.append(("least, wind known", degrees("facts.minimum", s.minima[s.model], unit="deg")))
    if found.dispersed is not None:
        required = found.dispersed.required
        covers = f"covers {100 * required.probability:g} % of cases"
        rows.append((covers, degrees("facts.covers", required.upper, unit="deg")))
    return tuple(rows)
