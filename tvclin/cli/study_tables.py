"""What `tvclin study` prints: tables of a study, and of a dispersed one."""

from typing import TYPE_CHECKING, Any

import typer

from tvclin.cli.output import say

if TYPE_CHECKING:
    from tvclin.answers.campaign.quick import DispersedStudy
    from tvclin.answers.findings import Findings
    from tvclin.answers.study import Study
    from tvclin.base.cards import Quantity
    from tvclin.vehicle.coefficients import Coefficients


def print_study(result: "Study", source: str, explain: bool = False) -> None:
    """Print the vehicle, its coefficients and poles, the boundaries and the verdict.

    Where it is asked for, what the symbols mean stands at the foot.
    """
    from tvclin.cli.output import print_pairs
    from tvclin.vehicle.file import as_written

    v, c = result.vehicle, result.coefficients
    own = as_written(source)
    rows = [(one.label, _in_units(one, own)) for one in v.quantities()]
    twice = any("(" in value for _, value in rows)
    planes = "pitch and yaw" if result.in_both else result.plane
    print_pairs(f"{v.name or source}, {result.model}, {planes}", rows, columns=1 if twice else 2)
    path = [
        ("K1", f"{c.K1:.4f}" if c.mu_alpha > 0.0 else "none (stable)"),
        ("C1", f"{c.C1:.5f} 1/s"),
        ("C2", f"{c.C2:.6f} 1/s3"),
        ("b1", f"{c.b1:.5f} 1/s"),
        ("b2", f"{c.b2:.5f} 1/s"),
    ]
    known = [
        ("beta", f"{c.beta:.4f} 1/s" if c.mu_alpha > 0.0 else "none (stable)"),
        *_damping(c),
        ("B", f"{c.B:.4f} deg/deg"),
        *(path if "drift-exact" in result.modes else ()),
    ]
    print_pairs(f"\nCoefficients, {result.plane} plane", known, columns=4)
    print_pairs(
        "\nUnstable poles [1/s]",
        [(name, _poles(modes.poles)) for name, modes in result.modes.items()],
        columns=1,
    )
    typer.echo()
    _print_boundaries(result)
    if explain:
        from tvclin.answers.glossary import SYMBOLS

        print_pairs("\nWhat the symbols mean", SYMBOLS.items(), columns=1)


_FIELDS = {
    "inertia": "moment_of_inertia",
    "slope": "normal_force_slope",
    "l_a": "aerodynamic_arm",
    "l_c": "control_arm",
    "attitude_deg": "attitude",
    "control_slope": "control_force_slope",
    "damping": "pitch_damping",
}
"""What files call the quantities of a vehicle, where it is not the same."""


def _in_units(one: "Quantity", own: dict[str, tuple[float, str]]) -> str:
    """A number in the unit of its file, and beside it in that of tables, where it is another."""
    shown = f"{one.value:.5g} {one.unit}"
    name = _FIELDS.get(one.key, one.key)
    number, unit = own.get("mass" if name == "weight" and "mass" in own else name, (0.0, ""))
    if not unit or unit == one.unit.replace("²", "2"):
        return shown
    return f"{number:.5g} {unit} ({shown})"


def print_dispersed(found: "DispersedStudy") -> None:
    """Print the deflection that covers the dispersed cases, and what drives it."""
    import numpy as np

    from tvclin.answers.campaign.statistics import shares
    from tvclin.cli.output import print_pairs

    required, drivers = found.required, list(found.drivers.items())[:3]
    of_cases, of_flights = shares(required.probability, required.confidence)
    covers = f"{np.degrees(required.upper):.4f} deg"
    if np.isinf(required.upper):
        covers = "too few cases to say: give more --cases"
    pairs = [
        ("dispersions", "assumed: " + ", ".join(found.dispersions.parameters)),
        ("median", f"{np.degrees(found.median):.4f} deg"),
        (of_cases, f"{np.degrees(required.estimate):.4f} deg"),
        (of_flights, covers),
        ("driven by", ", ".join(f"{name} ({rank:+.2f})" for name, rank in drivers)),
    ]
    if found.success is not None:
        s = found.success
        enough = f"in {100 * s.estimate:.2f} % ({100 * s.lower:.2f} to {100 * s.upper:.2f} %)"
        pairs.append(("the limit is enough", enough))
    print_pairs(f"\nDispersed, {required.cases} cases, seed {found.seed}", pairs, columns=1)


def print_questions(found: "Findings") -> None:
    """Print every question with its answer, where more than one is asked."""
    from tvclin.answers.questions import questions, sufficient
    from tvclin.cli.output import print_pairs

    each = questions(found)
    if len(each) < 2:
        return
    pairs = [(one.name, f"{one.answer}: {one.text}") for one in each]
    print_pairs("\nIs it enough? Every question, and its answer", pairs, columns=1)
    others = ", ".join(one.name for one in each if one.yes is not True)
    said = {
        True: "SUFFICIENT in all",
        False: f"NOT SUFFICIENT: {others}",
        None: "no limit was given" if found.study.limit is None else f"NOT KNOWN: {others}",
    }
    say(f"Verdict: {said[sufficient(found)]}")
    for note in () if found.availability is None else found.availability.notes:
        say(f"Note: {note}.")


def _print_boundaries(result: "Study") -> None:
    import numpy as np

    from tvclin.cli.output import limit_cell, print_table

    deg = np.degrees
    names = list(result.boundaries)
    rows = []
    for i, K in enumerate(result.dead_bands):
        mark = " <" if result.dead_band == K else ""
        row = [f"{K:g}{mark}"]
        for name in names:
            found = result.boundaries[name]
            row += [limit_cell(found.limit[i]), limit_cell(abs(deg(found.deflection[i])))]
        rows.append(row)
    rows += _without_and_with_forecast(result, names)
    survived = _survived(result)
    if survived:
        rows = [[*row, peak] for row, peak in zip(rows, survived, strict=True)]
    peak, duration = float(deg(result.wind.peak)), float(result.wind.duration)
    whole = ""
    if result.slanting is not None:
        vector = abs(float(deg(result.slanting.peak)))
        whole = f", the part in the {result.plane} plane of a vector of {vector:.4g} deg"
    print_table(
        f"Boundary in a {result.shape} wind of {peak:.4g} deg and {duration:g} s"
        f"{result.blows.gust_words}{whole}"
        f" (trim takes {deg(result.trim_deflection):.4f} deg)",
        [
            "dead band K",
            *(h for name in names for h in (f"{name} y_BR", "deflection [deg]")),
            *(["limit survives [deg]"] if survived else []),
        ],
        rows,
    )
    needed = limit_cell(deg(result.required_deflection), unit="deg")
    basis = f"(model {result.model}, dead band {result.dead_band:g})"
    say(f"Required deflection: {needed} {basis}, {_governed(result)}")
    if result.limit is not None and result.survivable_peak is not None:
        word = "SUFFICIENT" if result.sufficient else "NOT SUFFICIENT"
        largest = abs(deg(result.survivable_peak))
        said = "any wind of this shape" if np.isinf(largest) else f"peaks up to {largest:.3f} deg"
        of_it = f", {result.peak_of}" if result.peak_of and np.isfinite(largest) else ""
        say(f"Limit {deg(result.limit):.4f} deg: {word}; it survives {said}{of_it}")
    say(
        "no forecast, bound: lower bound for laws that do not know when the wind will stop; wind"
        " known: the minimum, appendix C; y_BR: limit over ideal trim"
    )
    for note in result.notes:
        say(f"Note: {note}.")


def _survived(result: "Study") -> list[str]:
    """Which peak the limit survives, for each row, with the model of the verdict."""
    import numpy as np

    if result.limit is None or result.in_both or result.model not in result.boundaries:
        return []
    found, needs = result.boundaries[result.model], result.needs
    least = needs["minimum"].get(result.model, 0.0)
    rows = [
        result.required_deflection if result.dead_band == K else max(abs(float(each)), least)
        for K, each in zip(result.dead_bands, found.deflection, strict=True)
    ]
    rows += [needs[key].get(result.model, np.nan) for key in ("forecast_free", "minimum")]
    peak = abs(float(np.degrees(result.history.peak)))
    with np.errstate(divide="ignore"):
        peaks = [float(peak * result.limit / np.float64(row)) for row in rows]
    return ["-" if np.isnan(one) else "any" if np.isinf(one) else f"{one:.3f}" for one in peaks]


def _damping(c: "Coefficients") -> list[tuple[str, str]]:
    """The damping and the pole that it slows, where there is one."""
    if not c.damping:
        return []
    pole = [("pole p", f"{c.pole:.4f} 1/s")] if c.mu_alpha > 0.0 else []
    return [("damping", f"{c.damping:.5f} 1/s"), *pole]


def _governed(result: "Study") -> str:
    """By what the required deflection is governed, and where it stands in the table."""
    from tvclin.answers.requirement import NOTHING
    from tvclin.boundary.limit import BOUNDARY

    by = result.governs
    if result.in_both:
        return f"of both planes, {by}"
    if by == NOTHING:
        return "none is needed"
    if by == BOUNDARY and result.switch == "literal":
        return "the row marked <"
    return f"governed by {by}" + (", literal switch" if by == BOUNDARY else "")


def _without_and_with_forecast(result: "Study", names: list[str]) -> list[list[str]]:
    """The least of any law without a forecast, and of any control that knows the wind."""
    import numpy as np

    labels = {"forecast_free": "no forecast, bound", "minimum": "wind known"}
    rows = []
    for key, deflections in result.needs.items():
        row = [labels[key]]
        for name in names:
            if name in deflections and result.trim_deflection:
                part = deflections[name] / result.trim_deflection
                row += [f"{part:.4f}", f"{np.degrees(deflections[name]):.4f}"]
            else:
                row += ["-", "-"]
        rows.append(row)
    return rows


def _poles(poles: Any) -> str:
    shown = [
        f"{p.real:.6f}" if p.imag == 0.0 else f"{p.real:.6f} +- {p.imag:.6f}j"
        for p in poles
        if p.imag >= 0.0
    ]
    return ", ".join(shown) or "none"
