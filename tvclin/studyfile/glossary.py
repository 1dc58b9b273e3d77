"""Symbols, quantities, terms and equations of a study, the latter of the report of 1968."""

import re
import tomllib
from importlib.resources import files

from tvclin.base.lines import Formula, Line, Table, as_sentence, labelled, quantities
from tvclin.base.quantities import QUANTITIES, WIND_KNOWN
from tvclin.requirement.study import Study

SYMBOLS = {
    "beta": "unstable pole on a fixed path: without control the error grows as exp(beta t), eq"
    " (B4)",
    "B": "static trim per wind angle, eq (2)",
    "K": "dead band: trim up to K times the limit, then the whole limit; K = 1 needs no forecast",
    "y_BR": f"boundary limit: {QUANTITIES['boundary limit']}",
    "K1": "fraction of the wind that counts with drift, eq (15b); below 1, for the vehicle moves"
    " with the wind",
    "C1": "rate at which the flight path follows the attitude, eq (B7)",
    "C2": "gravity term of the poles with drift, eq (B7)",
    "b1, b2": "zeros from deflection and from wind to attitude, with drift, eq (B7)",
}
"""The symbols that a study prints."""

TERMS = QUANTITIES | {
    "deflection": "angle of the engine from its nominal position",
    "limit": "the largest deflection of the engine, its stop",
    "wind angle": "angle of attack that the wind alone makes: its speed across the path over the"
    " speed of the vehicle",
    "trim": "the deflection that cancels the moment of the wind at every instant",
    "survive": "the deflection cancels what the wind excites of the unstable modes; the attitude"
    " may still drift",
    "boundary": "the limit with which a control with dead band survives, condition (4b)",
    "minimum": f"the {WIND_KNOWN}: {QUANTITIES[WIND_KNOWN]}",
    "nominal": "of the dynamic pressure of the flight without wind",
    "encountered": "of the dynamic pressure of the velocity through the air, wind included",
    "SUFFICIENT": "the limit is at least what is required; NOT KNOWN where validity ends",
    "MET": "a criterion is satisfied",
    "SURVIVED": "a flight with the limit comes back",
    "drift": "the flight path turns with the side force, so the vehicle moves with the wind",
    "fixed-path": "model without drift: the flight path stays nominal",
    "drift-exact": "model with drift, eq (B7): a fast unstable pole and a slow one",
    "drift-and-speed": "model with drift and with the change of speed",
    "pole": "a motion goes as exp(pole t); it grows where the real part is positive",
    "frozen": "computed with the vehicle of one flight time, as if it stayed so while the wind"
    " blows",
    "varying": "computed with the vehicle as it changes while the wind blows",
    "stop": "the angle beyond which the nozzle cannot turn, in one plane or in both together",
    "gain may fall": "aero margin, the lower gain margin: by how much before the loop becomes"
    " unstable",
    "gain may rise": "the upper gain margin: by how much before the loop becomes unstable",
    "phase": "as a margin: the added lag, at unit loop gain, that makes the loop unstable",
    "delay": "as a margin: the added delay that makes the loop unstable",
    "disk": "as a margin: the size of the disk in which gain and phase may change together",
    "peak of S": "largest factor by which the loop amplifies a disturbance",
    "peak of T": "largest factor from a command, or from sensor noise, to the output",
    "effectiveness": "control moment per deflection, over its nominal value",
    "near rest": "motion so small that the nozzle does not reach its stop",
    "slosh": "motion of the liquid in a tank",
    "sounding": "wind over height, measured by one balloon",
    "systematic": "always of one sign: these parts of a total add",
    "random": "of either sign: these parts of a total add by the root of the sum of squares",
    "rank correlation": "from -1 to 1, how strongly the answer follows a parameter",
}
"""The terms of a study and its page."""
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


def quantity_table() -> Table:
    """Return the quantities of a verdict, each with its sentence."""
    return quantities("Quantities", ((name, (words,)) for name, words in QUANTITIES.items()))


def symbol_table() -> Table:
    """Return the table of the symbols with their meanings."""
    return quantities("What the symbols mean", ((k, (words,)) for k, words in SYMBOLS.items()))


def equation_table(s: Study) -> Table:
    """Return the equations that a study `s` uses: number, equation as corrected, and use.

    They are used in every study, by its models, or by its closed forms.
    """
    printed = tomllib.loads((files("tvclin.studyfile") / "equations.toml").read_text("utf-8"))
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
    """Return the symbols and terms that occur in a text `words`, each with its meaning.

    A symbol, or the first of two ("b1, b2"), occurs as a word of its own; a term as the beginning
    of a word, small or large.
    """
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
    """Return the line of symbols, each a formula; `names`: the symbols, separated by commas."""
    first, *others = (labelled(name)[-1] for name in names.split(", "))  # the formula comes last
    return (first, *(word for name in others for word in (", ", name)))
