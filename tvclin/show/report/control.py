"""The sections of closed loops and dispersed cases."""

import numpy as np

from tvclin.base.lines import Line, degrees, number, quantities
from tvclin.base.quantities import NOMINAL, satisfaction
from tvclin.case.autopilot_assumptions import gain_notes
from tvclin.control.comparison import TrimComparison
from tvclin.control.margins.criteria import margin_table
from tvclin.control.margins.margins import Margins
from tvclin.design.standard_trials import LEGEND, bounds, doubts, needed, standard_winds
from tvclin.flights.closed_loop.flown_margins import flown_table
from tvclin.flights.closed_loop.survival_limit import OK
from tvclin.linear.plant import Plant
from tvclin.plots import comparison_chart, nichols_chart
from tvclin.show.report.blocks import Block, Paragraph, Section, checks, section_of
from tvclin.show.report.figures import figure_of
from tvclin.studyfile.findings import Findings

_NOMINAL = f", {NOMINAL}"
"""Suffix of a title where the verdict also covers the dynamic pressure in a head wind."""


def laws(findings: Findings) -> Section | None:
    """Return the section of the required deflection of each law in each wind, with its bounds."""
    return section_of(findings, "trials", "laws", "Control laws", _laws)


def _laws(findings: Findings) -> list[Block]:
    request, s = findings.plan.laws, findings.study
    assert request is not None
    flown, rate = f"the {findings.plan.law_model} model", request.sample_rate
    if findings.plan.vehicle.structure is not None:
        flown += " of the flexible vehicle, with filters, actuator and delay of the autopilot"
    words = (
        f"Each law is flown with a stop on {flown}, sampled at {rate:g} Hz, in winds with the peak"
        " and duration of this study. The number is the least stop above which every one that was"
        " tried survives. The laws trim and dead band hold the attitude, and are designed on a"
        f" fixed path. {LEGEND}{_comparison_text(findings)}"
    )
    plant = Plant(s.coefficients, findings.plan.law_model)
    winds = standard_winds(s.wind.peak, s.wind.duration)
    reference_bounds = bounds(plant, {name: winds[name] for name in request.winds})
    return [
        *needed(findings.trials, reference_bounds),
        Paragraph((words,)),
        *checks(doubts(findings.trials)),
    ]


def _comparison_text(findings: Findings) -> str:
    """Return the sentence on how the autopilot's flight as a law differs from the judged one."""
    plan, rate = findings.plan, findings.plan.laws.sample_rate if findings.plan.laws else 0.0
    if findings.stop is None or plan.laws is None or "autopilot" not in plan.laws.names:
        return " The gust is left out here." if findings.study.gust is not None else ""
    boundary_deg = np.degrees(abs(float(findings.stop.deflection)) * findings.study.of_both)
    requirement = f"{boundary_deg:.3f} deg" if np.isfinite(boundary_deg) else "any limit"
    differences = ["the gust"] if findings.study.gust is not None else []
    if plan.vehicle.structure is None:
        differences += ["actuator", "delay"]
    design_rate = plan.hardware["sample_rate"]
    differences += (
        [f"{design_rate:g} samples a second in place of {rate:g}"] if design_rate != rate else []
    )
    differences += ["both planes counted"] if findings.study.in_both else []
    added = f", flown with {', '.join(differences)}" if differences else ""
    return (
        f" The autopilot flies here with the gains of Autopilot and margins. There it requires"
        f" {requirement}{added}{_NOMINAL * bool(findings.head)}."
    )


def autopilot(findings: Findings) -> Section | None:
    """Return the section of gains, margins with their criteria, and the nozzle's duty."""
    return section_of(findings, "comparison", "margins", "Autopilot and margins", _autopilot)


def _autopilot(findings: Findings) -> list[Block]:
    c, f = findings.comparison, findings.flexible
    assert c is not None
    plant = c.plant
    margins = c.margins if f is None else f.bands.margins
    satisfied = bool(findings.criteria.are_satisfied(findings.margins or c.margins))
    verdict = satisfaction(satisfied)
    notes = [
        f" {note[0].upper()}{note[1:]}."
        for note in gain_notes(findings.plan, findings.criteria, satisfied)
    ]
    whose = "" if f is None else " of the flexible vehicle"
    words = (
        f'The criteria "{findings.criteria.name}" are {verdict}. The loop is that of the'
        f" {plant.model} model{whose}, without a limit.{''.join(notes)}"
    )
    blocks: list[Block] = [
        Paragraph((words,)),
        quantities("Autopilot", c.autopilot.rows()),
        *c.autopilot.filter_tables(),
        _margins(findings, margins),
    ]
    if margins.stable:
        drawn = nichols_chart(c.autopilot, plant, findings.criteria)
        label = f"Nichols chart of the loop; criteria {findings.criteria.name} {verdict}"
        caption = "Nichols chart of the loop with its margins and the box of the criteria."
        blocks.append(figure_of(drawn, "nichols", label, caption))
    blocks += _in_the_wind(findings, c)
    if c.margins.stable:
        label = "Deflection of the autopilot over time beside trim, boundaries and minimum"
        caption = "Deflection that the autopilot without a limit uses in this wind."
        blocks.append(figure_of(comparison_chart(c), "comparison", label, caption))
    if f is None and findings.stop is not None and findings.stop.status != OK:
        blocks += checks([f"flown with a stop: {findings.stop.status}"])
    return blocks + _flown(findings)


def _flown(findings: Findings) -> list[Block]:
    """Return the blocks of the margins flown with the limit; an empty list without a limit."""
    if "flown" in findings.reasons:
        return [
            Paragraph(
                (f"With this limit no margin is left in this wind: {_failure_reason(findings)}.",)
            )
        ]
    f = findings.flown
    if f is None:
        return []
    words = (
        "How much each quantity alone may change before a flight through this wind, with the limit"
        " as its stop, is lost, or the loop becomes unstable near rest. The limit is ",
        *number("flown.spare", f.spare, 2),
        " times the least with which this autopilot survives.",
    )
    return [
        flown_table(
            f, "Margins that the limit leaves in this wind" + _NOMINAL * bool(findings.head)
        ),
        Paragraph(words),
        *checks(f.notes),
    ]


def _failure_reason(findings: Findings) -> str:
    """Return the reason why the flight with the limit has no margins."""
    stop, limit = findings.stop, findings.study.limit
    if stop is None or limit is None or not abs(stop.deflection) * findings.study.of_both > limit:
        return findings.reasons["flown"]
    required_deg, limit_deg = (
        np.degrees(abs(stop.deflection) * findings.study.of_both),
        np.degrees(limit),
    )
    if np.isinf(required_deg):
        return f"flown with a stop of {limit_deg:.3f} deg or more, the autopilot does not survive"
    nominal = _NOMINAL * bool(findings.head)
    return (
        f"the autopilot requires a limit of {required_deg:.3f} deg, flown{nominal}, and has"
        f" {limit_deg:.3f} deg"
    )


def dispersed(findings: Findings) -> Section | None:
    """Return the section of the deflection required by a dispersed vehicle in a dispersed wind."""
    title = "Dispersed vehicle and wind"
    return section_of(findings, "dispersed", "dispersed", title, _dispersed)


def _dispersed(findings: Findings) -> list[Block]:
    d = findings.dispersed
    assert d is not None
    return [*d.tables(), Paragraph((d.spreads,))]


def _margins(findings: Findings, margins: Margins) -> Block:
    if not margins.stable:
        return Paragraph((f"There are no margins: {margins.reason}.",))
    return margin_table(margins, findings.criteria.judge(findings.margins or margins))


def _in_the_wind(findings: Findings, c: TrimComparison) -> list[Block]:
    title = "The autopilot in this wind, without a limit"
    title += "" if findings.flexible is None else ", flexible vehicle"
    title += f", {findings.study.plane} plane alone" if findings.study.in_both else ""
    title += _NOMINAL if findings.head is not None else ""
    stop = None if findings.stop is None else abs(float(findings.stop.deflection))
    tables = [c.deflections(title, stop), quantities("Largest motions", c.motions())]
    return [*tables, *_both_planes(findings, stop)]


def _both_planes(findings: Findings, stop: float | None) -> list[Block]:
    """Return the factor of both planes over this one, and the limit of the autopilot with it.

    An empty list unless the verdict is on both planes.
    """
    s = findings.study
    if not s.in_both:
        return []
    line: Line = (
        "Both planes together need ",
        *number("both.factor", s.of_both, 3),
        f" times the stop that the {s.plane} plane needs alone",
    )
    if stop is not None and np.isfinite(stop):
        needs = degrees("both.stop", stop * s.of_both, unit="deg")
        line += (". With that factor this autopilot needs a stop of ", *needs, ", flown")
    return [Paragraph((*line, "."))]
