"""One table of all questions: answer, required, available and remaining, worst first."""

from collections.abc import Iterator

import numpy as np

from tvclin.answers.findings import Findings
from tvclin.answers.questions import Measure, Question, questions
from tvclin.base.lines import Line, Table, minimum_limit, number, significant
from tvclin.control.margins.bands import GAIN, PHASE, BandMargins
from tvclin.control.margins.margins import margin

HEAD = ("question", "answer", "required", "available", "remaining", "why")
_NUMBERS = ("needed", "there", "left")
"""Names of the numbers of a measure, below the headings required, available and remaining."""
_SUFFIXES = {"%": "percent"}
"""Units in the names of numbers."""
_ROUNDED = ("deg", "deg/s", "%", "dB", "ms", "")
"""Units of which the digits behind the point are given; of others four digits count."""
_NOT_JUDGED = "not judged"
"""Answer of values that no criterion bounds."""
_MAX_NAMED_CHANGES = 3
"""Number of changes that are named of those that miss the criteria."""


def asked_table(found: Findings) -> Table:
    """Return every question with its answer, and below them the values that are not judged."""
    judged = sorted(questions(found), key=_worst_first)
    rows = [_row(question, question.answer) for question in judged]
    rows += [_row(question, _NOT_JUDGED) for question in beside(found)]
    return Table("Every question, and its answer, worst first", HEAD, tuple(rows))


def _worst_first(question: Question) -> tuple[int, float]:
    """Return the sort key: no, not known, yes, and in each the largest ratio required/available."""
    ratio = np.nan if question.measure is None else question.measure.part
    return (False, None, True).index(question.yes), np.inf if np.isnan(ratio) else -ratio


def _row(question: Question, answer: str) -> tuple[Line, ...]:
    """Return the row of a question with its answer."""
    cells: tuple[Line, ...] = (("",),) * 3
    if question.measure is not None:
        cells = measured(f"asked.{question.name.replace(' ', '_')}", question.measure)
    return ((question.name,), (answer,), *cells, question.line)


def measured(key: str, measure: Measure) -> tuple[Line, ...]:
    """Return required, available and remaining, with units; none remains of what none satisfies."""
    shown = [_shown(f"{key}.{name}", name, measure) for name in _NUMBERS[:2]]
    if np.isinf(measure.needed):
        return (("none is sufficient",), shown[1], ("",))
    return (*shown, _shown(f"{key}.left", "left", measure))


def _shown(key: str, name: str, measure: Measure) -> Line:
    value, unit = getattr(measure, name), measure.unit
    suffix = _SUFFIXES.get(unit, unit.replace("/", "_per_").replace(" ", "_"))
    key += f"_{suffix}" if suffix else ""
    if unit not in _ROUNDED:
        return significant(key, value, unit=unit)
    line = number(key, value, measure.digits, unit)
    return minimum_limit(line) if name == "needed" and unit == "deg" else line


def beside(found: Findings) -> Iterator[Question]:
    """Yield the values that no criterion bounds, as questions without an answer."""
    margins = found.margins
    if isinstance(margins, BandMargins) and not found.criteria.has_mode_limits:
        yield from _modes(margins)
    if found.flexible is not None and found.flexible.detuned is not None:
        d = found.flexible.detuned
        missed = [name for name, fine in zip(d.changes, d.satisfied, strict=True) if not fine]
        more = ", ..." * (len(missed) > _MAX_NAMED_CHANGES)
        named = f": {', '.join(missed[:_MAX_NAMED_CHANGES])}{more}" if missed else ""
        words = f"{len(missed)} of {len(d.changes)} changes of one mode miss the criteria{named}"
        yield Question("modes detuned", None, (words,))
    if found.availability is not None and found.availability.limit is not None:
        request = found.plan.availability
        if request is not None and request.least_part is None:
            words = f"{found.availability.part()}; no least_part is asked in [availability]"
            yield Question("availability", None, (words,))


def _modes(margins: BandMargins) -> Iterator[Question]:
    """Yield the modes with the smallest gain and phase margins, as a question without an answer."""
    gains = [mode for mode in margins.modes if mode.stabilised == GAIN]
    phases = [mode for mode in margins.modes if mode.stabilised == PHASE]
    line: Line = ()
    if gains:
        worst = min(gains, key=lambda mode: float(mode.gain_margin_dB))
        line += (f"{worst.name} stays ", *margin("asked.mode.gain", worst.gain_margin_dB, "dB"))
        line += (" below one",)
    if phases:
        worst = min(phases, key=lambda mode: float(mode.phase_margin_deg))
        has = margin("asked.mode.phase", worst.phase_margin_deg, "deg")
        line += (", " * bool(line) + f"{worst.name} has ", *has, " of phase")
    if line:
        words = "; nothing is asked of modes without mode_gain_margin_dB in [criteria]"
        yield Question("modes", None, (*line, words))
