"""Sections on the basis of the page: assumptions, equations, inputs, versions and glossary."""

import platform
import re
import tomllib
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from importlib.resources import files

from tvclin.base.lines import Formula, Line, Table, labelled, text
from tvclin.requirement.study import OUTLASTS
from tvclin.show.report.blocks import (
    Checks,
    Figure,
    Paragraph,
    Section,
    as_sentence,
    checks,
)
from tvclin.studyfile.findings import Findings
from tvclin.studyfile.glossary import SYMBOLS, TERMS
from tvclin.studyfile.questions import nominal_notes
from tvclin.winds.wind_angles import DOUBTFUL

_PACKAGES = ("tvclin", "numpy", "scipy", "control", "matplotlib")
_PLANTS = {
    "fixed-path": "(5)",
    "drift": "(B8)",
    "drift-exact": "(B7)",
    "drift-and-speed": "(B5)",
}
"""Number of the report's attitude equation, by model."""
_CLOSED_FORMS = {
    ("rectangular", "fixed-path"): "(7)",
    ("rectangular", "drift"): "(16)",
    ("triangular", "fixed-path"): "(12)",
    ("triangular", "drift"): "(18)",
}
"""Number of the report's closed-form boundary, by wind shape and model of one unstable pole."""


def assumptions(findings: Findings) -> Section:
    """Return the section of the assumptions of the numbers, doubtful ones first."""
    s = findings.study
    odd = [
        f"boundaries on the {name} model: {status}"
        for name, boundary in s.boundaries.items()
        for status in dict.fromkeys(str(status) for status in boundary.status if status != "ok")
    ]
    odd += [note for note in s.notes if OUTLASTS not in note and DOUBTFUL not in note]
    odd += [*nominal_notes(findings), *findings.warnings]
    if findings.comparison is not None:
        notes = dict.fromkeys((*findings.comparison.margins.notes, *findings.comparison.notes))
        odd += [f"autopilot: {note}" for note in notes]
    assumed = [
        "the motion is planar, linear, and a deviation from the nominal flight",
        "the engine stops sharply at its limit",
        _neglected(findings),
    ]
    if findings.dispersed is not None:
        assumed.append("the dispersions are those given, and not checked")
    return Section("assumptions", "Assumptions", tuple(checks(odd, assumed)))


def _neglected(findings: Findings) -> str:
    damped = "" if findings.study.coefficients.damping else ", damping of the attitude rate"
    if findings.plan.vehicle.structure is None:
        return f"bending, slosh{damped} and sensor noise are left out"
    return (
        "bending and slosh count for the autopilot alone, and are left out of all else; sensor"
        f" noise{damped} is left out"
    )


def equations(findings: Findings) -> Section:
    """Return the section of the equations used, by their numbers in the report of 1968."""
    s = findings.study
    printed = tomllib.loads((files("tvclin.show.report") / "equations.toml").read_text("utf-8"))
    used = {key: equation["use"] for key, equation in printed.items() if "use" in equation}
    for name in s.boundaries:
        used[_PLANTS[name]] = f"the {name} model"
        if (s.shape, name) in _CLOSED_FORMS:
            used[_CLOSED_FORMS[s.shape, name]] = f"the boundary, {name}"
        if name != "fixed-path":
            used["(15b)"] = "K1"
    rows: list[tuple[Line, ...]] = [
        ((key,), (Formula(equation["tex"], equation["text"]),), (used[key],))
        for key, equation in printed.items()
        if key in used
    ]
    words = (
        "Numbers are those of Borsody and Teren (NASA Lewis Research Center, 1968), with the errors"
        " of the print corrected. Variables are deviations from the nominal flight, and L is the"
        " Laplace transform. The boundary of a model with more than one unstable pole has no closed"
        " form: it follows from condition (4b) at each of them."
    )
    table = Table("Equations", ("number", "as it should read", "used for"), tuple(rows))
    return Section("equations", "Equations", (table, Paragraph((words,))))


def origin(findings: Findings) -> Section:
    """Return the section with the seal of the inputs and the versions that computed the page."""
    rows: list[tuple[Line, ...]] = [(("inputs, SHA-256",), (findings.seal,))]
    rows += [((name,), (version(name),)) for name in _PACKAGES]
    rows.append((("Python",), (platform.python_version(),)))
    words = "The same study file and versions give the same page, to the last byte."
    table = Table("Inputs and versions", ("what", "which"), tuple(rows))
    return Section("origin", "Origin", (table, Paragraph((words,))))


def glossary(sections: Sequence[Section]) -> Section:
    """Return the section that explains the symbols and terms used in these sections."""
    words = " ".join(_texts(sections))
    used: list[tuple[Line, ...]] = [
        (_symbols(name), (as_sentence(meaning),))
        for name, meaning in SYMBOLS.items()
        if re.search(rf"(?<!\w){name.partition(',')[0]}(?!\w)", words)
    ]
    used += [
        ((name,), (as_sentence(meaning),))
        for name, meaning in TERMS.items()
        if re.search(rf"\b{name}", words, re.IGNORECASE)
    ]
    table = Table("Symbols and terms of this page", ("what", "meaning"), tuple(used))
    return Section("glossary", "Glossary", (table,))


def _symbols(names: str) -> Line:
    """Return the line of one symbol, or of several separated by commas."""
    first, *others = (labelled(name)[-1] for name in names.split(", "))
    return (first, *(word for name in others for word in (", ", name)))


def _texts(sections: Sequence[Section]) -> Iterator[str]:
    """Yield the text of all blocks of sections; of a figure its caption."""
    for block in (block for section in sections for block in section.blocks):
        if isinstance(block, Table):
            yield from (block.caption, *block.head)
            yield from (text(line) for row in block.rows for line in row)
        elif isinstance(block, Checks):
            yield from (text(check.line) for check in block.each)
        else:
            yield block.caption if isinstance(block, Figure) else text(block.line)
