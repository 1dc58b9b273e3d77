"""The sections of closed loops and dispersed cases."""

import numpy as np

from tvclin.answers.findings import Findings
from tvclin.answers.gain_notes import gain_notes
from tvclin.answers.trial_tables import LEGEND, bounds, doubts, needed
from tvclin.answers.trials import standard_winds
from tvclin.base.lines import Line, degrees, number, quantities
from tvclin.base.quantities import NOMINAL, satisfaction
from tvclin.control.comparison import TrimComparison
from tvclin.control.margins.criteria import margin_table
from tvclin.control.margins.margins import Margins
from tvclin.flights.closed_loop.flown_margins import flown_table
from tvclin.flights.closed_loop.survival_limit import OK
from tvclin.linear.plant import Plant
from tvclin.plots import comparison_chart, nichols_chart
from tvclin.show.report.blocks import Block, Paragraph, Section, checks, section_of
from tvclin.show.report.figures import figure_of

_NOMINAL = f", {NOMINAL}"
"""Of a section, where the verdict is also on the dynamic pressure in a head wind."""


def laws(found: Findings) -> Section | None:
    """Return what each law needs in each wind, beside trim and the minimum."""
    return section_of(found, "trials", "laws", "Control laws", _laws)


def _laws(found: Findings) -> list[Block]:
    asked, s = found.plan.laws, found.study
    assert asked is not None
    flown, rate = f"the {found.plan.law_model} model", asked.sample_rate
    if found.plan.vehicle.structure is not None:
        flown += " of the flexible vehicle, with filters, actuator and delay of the autopilot"
    words = (
        f"Each law is flown with a stop on {flown}, sampled at {rate:g} Hz, in winds with the peak"
        " and duration of this study. The number is the least stop above which every one that was"
        " tried survives. The laws trim and dead band hold the attitude, and are designed on a"
        f" fixed path. {LEGEND}{_apart(found)}"
    )
    plant = Plant(s.coefficients, found.plan.law_model)
    every = standard_winds(s.wind.peak, s.wind.duration)
    beside = bounds(plant, {name: every[name] for name in asked.winds})
    return [*needed(found.trials, beside), Paragraph((words,)), *checks(doubts(found.trials))]


def _apart(found: Findings) -> str:
    """By what the flight of the autopilot as a law is another than that which is judged."""
    plan, rate = found.plan, found.plan.laws.sample_rate if found.plan.laws else 0.0
    if found.stop is None or plan.laws is None or "autopilot" not in plan.laws.names:
        return " The gust is left out here." if found.study.gust is not None else ""
    stop = np.degrees(abs(float(found.stop.deflection)) * found.study.of_both)
    least = f"{stop:.3f} deg" if np.isfinite(stop) else "any limit"
    apart = ["the gust"] if found.study.gust is not None else []
    if plan.vehicle.structure is None:
        apart += ["actuator", "delay"]
    own = plan.hardware["sample_rate"]
    apart += [f"{own:g} samples a second in place of {rate:g}"] if own != rate else []
    apart += ["both planes counted"] if found.study.in_both else []
    added = f", flown with {', '.join(apart)}" if apart else ""
    return (
        f" The autopilot flies here with the gains of Autopilot and margins. There it requires"
        f" {least}{added}{_NOMINAL * bool(found.head)}."
    )


def autopilot(found: Findings) -> Section | None:
    """Return gains, margins beside their criteria, and what the autopilot asks of the nozzle."""
    return section_of(found, "comparison", "margins", "Autopilot and margins", _autopilot)


def _autopilot(found: Findings) -> list[Block]:
    c, f = found.comparison, found.flexible
    assert c is not None
    plant = c.plant
    margins = c.margins if f is None else f.bands.margins
    met = bool(found.criteria.are_satisfied(found.margins or c.margins))
    verdict = satisfaction(met)
    notes = [
        f" {note[0].upper()}{note[1:]}." for note in gain_notes(found.plan, found.criteria, met)
    ]
    whose = "" if f is None else " of the flexible vehicle"
    words = (
        f'The criteria "{found.criteria.name}" are {verdict}. The loop is that of the'
        f" {plant.model} model{whose}, without a limit.{''.join(notes)}"
    )
    blocks: list[Block] = [
        Paragraph((words,)),
        quantities("Autopilot", c.autopilot.rows()),
        *c.autopilot.filter_tables(),
        _margins(found, margins),
    ]
    if margins.stable:
        drawn = nichols_chart(c.autopilot, plant, found.criteria)
        label = f"Nichols chart of the loop; criteria {found.criteria.name} {verdict}"
        caption = "Nichols chart of the loop with its margins and the box of the criteria."
        blocks.append(figure_of(drawn, "nichols", label, caption))
    blocks += _in_the_wind(found, c)
    if c.margins.stable:
        label = "Deflection of the autopilot over time beside trim, boundaries and minimum"
        caption = "Deflection that the autopilot without a limit uses in this wind."
        blocks.append(figure_of(comparison_chart(c), "comparison", label, caption))
    if f is None and found.stop is not None and found.stop.status != OK:
        blocks += checks([f"flown with a stop: {found.stop.status}"])
    return blocks + _flown(found)


def _flown(found: Findings) -> list[Block]:
    """What the limit leaves of the margins in this wind; nothing without a limit."""
    if "flown" in found.reasons:
        return [Paragraph((f"With this limit no margin is left in this wind: {_lost(found)}.",))]
    f = found.flown
    if f is None:
        return []
    words = (
        "How much each quantity alone may change before a flight through this wind, with the limit"
        " as its stop, is lost, or the loop becomes unstable near rest. The limit is ",
        *number("flown.spare", f.spare, 2),
        " times the least with which this autopilot survives.",
    )
    return [
        flown_table(f, "Margins that the limit leaves in this wind" + _NOMINAL * bool(found.head)),
        Paragraph(words),
        *checks(f.notes),
    ]


def _lost(found: Findings) -> str:
    """Why the flight with the limit has no margins."""
    stop, limit = found.stop, found.study.limit
    if stop is None or limit is None or not abs(stop.deflection) * found.study.of_both > limit:
        return found.reasons["flown"]
    least, have = np.degrees(abs(stop.deflection) * found.study.of_both), np.degrees(limit)
    if np.isinf(least):
        return f"flown with a stop of {have:.3f} deg or more, the autopilot does not survive"
    nominal = _NOMINAL * bool(found.head)
    return (
        f"the autopilot requires a limit of {least:.3f} deg, flown{nominal}, and has {have:.3f} deg"
    )


def dispersed(found: Findings) -> Section | None:
    """Return what covers a dispersed vehicle in a dispersed wind."""
    title = "Dispersed vehicle and wind"
    return section_of(found, "dispersed", "dispersed", title, _dispersed)


def _dispersed(found: Findings) -> list[Block]:
    d = found.dispersed
    assert d is not None
    return [*d.tables(), Paragraph((d.spreads,))]


def _margins(found: Findings, whole: Margins) -> Block:
    if not whole.stable:
        return Paragraph((f"There are no margins: {whole.reason}.",))
    return margin_table(whole, found.criteria.judge(found.margins or whole))


def _in_the_wind(found: Findings, c: TrimComparison) -> list[Block]:
    title = "The autopilot in this wind, without a limit"
    title += "" if found.flexible is None else ", flexible vehicle"
    title += f", {found.study.plane} plane alone" if found.study.in_both else ""
    title += _NOMINAL if found.head is not None else ""
    stop = None if found.stop is None else abs(float(found.stop.deflection))
    tables = [c.deflections(title, stop), quantities("Largest motions", c.motions())]
    return [*tables, *_of_both(found, stop)]


def _of_both(found: Findings, stop: float | None) -> list[Block]:
    """What both planes take of the stop over this one, where the verdict is on both."""
    s = found.study
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
