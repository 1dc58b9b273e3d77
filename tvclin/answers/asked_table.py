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
_TOLD = "not judged"
_FEW = 3
"""So many changes are named that do not meet what is asked."""


def asked_table(found: Findings) -> Table:
    """Return every question with its answer, and below them what is known and not judged."""
    each = sorted(questions(found), key=_worst_first)
    rows = [_row(one, one.answer) for one in each]
    rows += [_row(one, _TOLD) for one in beside(found)]
    return Table("Every question, and its answer, worst first", HEAD, tuple(rows))


def _worst_first(one: Question) -> tuple[int, float]:
    """No before not known before yes; of each the one that takes the largest part."""
    part = np.nan if one.measure is None else one.measure.part
    return (False, None, True).index(one.yes), np.inf if np.isnan(part) else -part


def _row(one: Question, answer: str) -> tuple[Line, ...]:
    cells: tuple[Line, ...] = (("",),) * 3
    if one.measure is not None:
        cells = measured(f"asked.{one.name.replace(' ', '_')}", one.measure)
    return ((one.name,), (answer,), *cells, one.line)


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
    """Yield what is known beside the questions, of which no answer was asked."""
    margins = found.margins
    if isinstance(margins, BandMargins) and not found.criteria.has_mode_limits:
        yield from _modes(margins)
    if found.flexible is not None and found.flexible.detuned is not None:
        d = found.flexible.detuned
        missed = [one for one, met in zip(d.changes, d.satisfied, strict=True) if not met]
        named = f": {', '.join(missed[:_FEW])}{', ...' * (len(missed) > _FEW)}" if missed else ""
        words = f"{len(missed)} of {len(d.changes)} changes of one mode miss the criteria{named}"
        yield Question("modes detuned", None, (words,))
    if found.availability is not None and found.availability.limit is not None:
        asked = found.plan.availability
        if asked is not None and asked.least_part is None:
            words = f"{found.availability.part()}; no least_part is asked in [availability]"
            yield Question("availability", None, (words,))


def _modes(margins: BandMargins) -> Iterator[Question]:
    """The modes with the least margins, where no criterion is asked of modes."""
    gains = [one for one in margins.modes if one.stabilised == GAIN]
    phases = [one for one in margins.modes if one.stabilised == PHASE]
    line: Line = ()
    if gains:
        one = min(gains, key=lambda one: float(one.gain_margin_dB))
        line += (f"{one.name} stays ", *margin("asked.mode.gain", one.gain_margin_dB, "dB"))
        line += (" below one",)
    if phases:
        one = min(phases, key=lambda one: float(one.phase_margin_deg))
        has = margin("asked.mode.phase", one.phase_margin_deg, "deg")
        line += (", " * bool(line) + f"{one.name} has ", *has, " of phase")
    if line:
        words = "; nothing is asked of modes without mode_gain_margin_dB in [criteria]"
        yield Question("modes", None, (*line, words))
