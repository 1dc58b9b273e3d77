"""What the page rests on: assumptions, equations, inputs and versions."""

import platform
from importlib.metadata import version

import numpy as np

from tvclin.answers.findings import Findings
from tvclin.answers.study import outlasts_one_pole
from tvclin.answers.study_notes import OUTLASTS
from tvclin.base.lines import Line, significant
from tvclin.boundary.optimum.two_poles import single_pole_validity
from tvclin.show.report.blocks import Check, Checks, Paragraph, Section, Table
from tvclin.show.reproduce.claims import equations as every_equation

_PACKAGES = ("tvclin", "numpy", "scipy", "control", "matplotlib")
_ALWAYS = {
    "(B2c)": "moments about the centre of gravity",
    "(B4)": "beta and B from the vehicle",
    "(4b)": "the condition of survival, at each unstable pole",
    "(8)": "the boundary limit, over trim",
    "(11)": "when the dead band is left",
    "(6b)": "the minimum, held from the start, on one pole",
    "(C4)": "the minimum, full deflection to one side or the other, on two poles",
}
_BY_SHAPE = {
    ("rectangular", False): "(7)",
    ("rectangular", True): "(16)",
    ("triangular", False): "(12)",
    ("triangular", True): "(18)",
}


def assumptions(found: Findings) -> Section:
    """Return what the numbers assume, and whether it holds here."""
    s = found.study
    checks = [_one_pole(found)]
    for name, one in s.boundaries.items():
        odd = dict.fromkeys(str(status) for status in one.status if status != "ok")
        checks += [Check("doubt", (f"{name}: {status}.",)) for status in odd]
    checks += [Check("doubt", (f"{note}.",)) for note in s.notes if OUTLASTS not in note]
    checks += [Check("doubt", (f"{one}.",)) for one in found.warnings]
    if found.comparison is not None:
        notes = dict.fromkeys((*found.comparison.margins.notes, *found.comparison.notes))
        checks += [Check("doubt", (f"autopilot: {note}.",)) for note in notes]
    checks += [
        Check(
            "reader",
            (
                "The vehicle is rigid, and its numbers stay as they are while the wind blows; the"
                " motion is planar and linear about the nominal flight.",
            ),
        ),
        Check("reader", ("The deflection limit is sharp, and no rate limit counts.",)),
        Check("reader", (_left_out(found),)),
    ]
    if found.dispersed is not None:
        checks.append(
            Check("reader", ("The dispersions are those of the input, and as good as it is.",))
        )
    return Section("assumptions", "Assumptions", (Checks(tuple(checks)),))


def _left_out(found: Findings) -> str:
    damped = "" if found.study.coefficients.damping else ", damping of the attitude rate"
    if found.plan.structure is None:
        return f"Bending, slosh{damped} and sensor noise are left out."
    return (
        "Bending and slosh count for the autopilot alone, and are left out of all else; sensor"
        f" noise{damped} is left out."
    )


def equations(found: Findings) -> Section:
    """Return the equations that were used, by their numbers in the report of 1968."""
    s = found.study
    used = dict(_ALWAYS)
    for name in s.boundaries:
        drifts = name != "fixed-path"
        used["(B8)" if drifts else "(5)"] = f"the {name} model"
        if (s.shape, drifts) in _BY_SHAPE:
            used[_BY_SHAPE[s.shape, drifts]] = f"the boundary, {name}"
        if drifts:
            used["(15b)"] = "K1"
    texts = {one["id"]: _as_it_should_read(one) for one in every_equation()}
    rows = tuple(((key,), (texts[key],), (used[key],)) for key in texts if key in used)
    words = (
        "Numbers are those of Borsody and Teren (NASA Lewis Research Center, 1968), with the errors"
        " of the print corrected; variables are deviations from the nominal flight. Models with"
        " more poles than the equation has are solved by the same condition (4b)."
    )
    table = Table("Equations", ("number", "as it should read", "used for"), rows)
    return Section("equations", "Equations", (table, Paragraph((words,))))


def origin(found: Findings) -> Section:
    """Return the seal of the inputs and the versions that computed the page."""
    rows: list[tuple[Line, ...]] = [(("inputs, SHA-256",), (found.seal,))]
    rows += [((name,), (version(name),)) for name in _PACKAGES]
    rows.append((("Python",), (platform.python_version(),)))
    words = "The same inputs and versions give the same page, to the last byte."
    table = Table("Inputs and versions", ("what", "which"), tuple(rows))
    return Section("origin", "Origin", (table, Paragraph((words,))))


def _one_pole(found: Findings) -> Check:
    """Whether the slow mode of the flight path may be neglected."""
    s = found.study
    edge = float(single_pole_validity(s.coefficients))
    if np.isnan(edge):
        words = "How long one pole is enough is not defined: there are no two real unstable poles."
        return Check("reader", (words,))
    tau = significant("validity.duration", float(s.wind.duration), unit="s")
    upto = significant("validity.edge", edge, unit="s")
    if outlasts_one_pole(s):
        needs = "; the slow mode of the flight path may then need more than the boundary says."
        line = ("One pole is not enough: the wind lasts ", *tau, ", longer than ", *upto, needs)
        return Check("doubt", line)
    return Check(
        "ok",
        ("One unstable pole is enough: the wind lasts ", *tau, ", not longer than ", *upto, "."),
    )


def _as_it_should_read(equation: dict[str, str]) -> str:
    corrected = equation["corrected"]
    return equation["printed"] if corrected.startswith("agrees") else corrected
