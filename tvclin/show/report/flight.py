"""The section of the whole flight: required deflections by time, and all the nozzle has to do."""

from tvclin.answers.findings import Findings
from tvclin.answers.sizing import tables
from tvclin.answers.sizing.record import STEADY, Sizing
from tvclin.answers.sizing.total_record import total_table
from tvclin.plots import sizing_chart
from tvclin.show.report.blocks import (
    Block,
    Figure,
    Paragraph,
    Section,
    checks,
    section_of,
)
from tvclin.show.report.figures import inline_svg


def over_flight(found: Findings) -> Section | None:
    """Return required deflections by flight time and wind, and the worst total."""
    return section_of(found, "flight", "flight", "The whole flight", _blocks)


def _blocks(found: Findings) -> list[Block]:
    asked = found.plan.sizing
    assert asked is not None
    assert found.flight is not None
    sizing, total = found.flight
    counted = asked.counted(sizing, found.plan.sign)
    of = f" of {asked.source}" if asked.source else ""
    blocks: list[Block] = [Paragraph((_words(sizing, of),))]
    if sizing.times.size > 1:
        label = "Required deflection over flight time, in the worst wind of each"
        caption = (
            "Required deflection over the flight, in the worst wind of each time. Lines: the"
            " vehicle is frozen at each time."
        )
        caption += " Circles: it varies while the wind blows." if sizing.freezing_error else ""
        drawn = inline_svg(sizing_chart(sizing, total.limit), "flight", label)
        blocks.append(Figure(label, caption, drawn))
    for j in range(len(sizing.winds)):
        blocks += tables.over_time(sizing, counted, j)
    ratio = asked.ratio(found.plan, sizing)
    notes = checks(
        (*asked.warnings, *sizing.notes), (*asked.notes, *(ratio.notes if ratio else ()))
    )
    verdict = [Paragraph(line) for line in total.verdict]
    beside: list[Block] = [ratio.table, Paragraph(ratio.verdict)] if ratio else []
    blocks += [total_table(total, counted), *verdict, *beside]
    if (card := found.card) is not None:
        said = Paragraph((f"The card of the nozzle, {card.law} flown: {card.verdict.words}.",))
        blocks += [said, *card.tables(), *checks((), card.notes)]
    elif "card" in found.reasons:
        blocks.append(Paragraph((f"No card of the nozzle: {found.reasons['card']}.",)))
    return [*blocks, *notes]


def _words(s: Sizing, of: str) -> str:
    planes = "both planes with one stop" if s.alone else f"the {s.plane} plane"
    return (
        f"The table takes the vehicle at each time of the flight{of}, on the {s.model} model in"
        f" {planes}; the peak of a pulse comes at that time. {tables.legend(s)} Change: by how much"
        f" beta or B changes while the wind blows; above {100 * STEADY:g} % a frozen vehicle is"
        " doubtful. One pole: whether the slow motion of the flight path may be neglected. Data:"
        " whether those of the flight cover the whole wind."
    )
