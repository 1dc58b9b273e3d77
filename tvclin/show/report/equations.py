"""Equations of the report of 1968 that a study uses, by their numbers, and its glossary."""

import re
import tomllib
from importlib.resources import files

from tvclin.base.lines import Formula, Line, Table, as_sentence, labelled
from tvclin.requirement.study import Study
from tvclin.studyfile.glossary import SYMBOLS, TERMS

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


def equation_table(s: Study) -> Table:
    """Return the equations that a study uses: number, equation as corrected, and use."""
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
    return Table("Equations", ("number", "as it should read", "used for"), tuple(rows))


def glossary_table(words: str) -> Table:
    """Return the symbols and terms that a text uses, each with its meaning."""
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
    return Table("Symbols and terms of this page", ("what", "meaning"), tuple(used))


def _symbols(names: str) -> Line:
    """Return the line of one symbol, or of several separated by commas."""
    first, *others = (labelled(name)[-1] for name in names.split(", "))
    return (first, *(word for name in others for word in (", ", name)))
