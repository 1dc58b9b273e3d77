"""The sections of the whole flight: what it needs by time, and on how many days it flies."""

from collections.abc import Iterator

import numpy as np

from tvclin.answers.availability import answer_tables
from tvclin.answers.availability.record import Availability
from tvclin.answers.findings import Findings
from tvclin.answers.sizing import tables
from tvclin.answers.sizing.record import STEADY, Sizing
from tvclin.answers.sizing.request import SizingRequest
from tvclin.answers.sizing.total import total_table
from tvclin.base.lines import Line, degrees, number
from tvclin.plots import availability_chart, sizing_chart
from tvclin.show.report.blocks import Block, Paragraph, Section, checks, section_of
from tvclin.show.report.figures import figure_of


def over_flight(found: Findings) -> Section | None:
    """Return required deflections by flight time and wind, and the worst total."""
    return section_of(found, "flight", "flight", "The whole flight", _over_flight)


def _over_flight(found: Findings) -> list[Block]:
    asked = found.plan.sizing
    assert asked is not None
    assert found.flight is not None
    sizing, total = found.flight
    counted = asked.counted(sizing, found.plan.sign)
    of = f" of {asked.source}" if asked.source else ""
    blocks: list[Block] = [Paragraph((_words(sizing, of),)), *_measured(asked)]
    if sizing.times.size > 1:
        label = "Required deflection over flight time, in the worst wind of each"
        caption = (
            "Required deflection over the flight, in the worst wind of each time. Lines: the"
            " vehicle is frozen at each time."
        )
        caption += " Circles: it varies while the wind blows." if sizing.freezing_error else ""
        blocks.append(figure_of(sizing_chart(sizing, total.limit), "flight", label, caption))
    for j in range(len(sizing.winds)):
        blocks += tables.over_time(sizing, counted, j)
    ratio = asked.ratio(found.plan, sizing)
    notes = checks(
        (*asked.warnings, *sizing.notes), (*asked.notes, *(ratio.notes if ratio else ()))
    )
    verdict = [Paragraph(line) for line in total.verdict]
    beside: list[Block] = [ratio.table, Paragraph(ratio.verdict)] if ratio else []
    blocks += [total_table(total, counted.label), *verdict, *beside]
    if (card := found.card) is not None:
        said = Paragraph((f"The card of the nozzle, {card.law} flown: {card.verdict.words}.",))
        blocks += [said, *card.tables(), *checks((), card.notes)]
    elif "card" in found.reasons:
        blocks.append(Paragraph((f"No card of the nozzle: {found.reasons['card']}.",)))
    return [*blocks, *notes]


def _measured(asked: SizingRequest) -> Iterator[Block]:
    """The soundings that the flight goes through, with station, date and direction of flight."""
    for name, sounding in asked.soundings.items():
        source = sounding.profile.source or "given without a source"
        azimuth = number(f"flight.azimuth.{name}", np.degrees(sounding.azimuth), 1, "deg")
        said = source if source.startswith(name) else f"{name}: {source}"
        yield Paragraph((f"Measured wind {said}; the flight goes towards ", *azimuth, "."))


def _words(s: Sizing, of: str) -> str:
    planes = "both planes with one stop" if s.alone else f"the {s.plane} plane"
    return (
        f"The table takes the vehicle at each time of the flight{of}, on the {s.model} model in"
        f" {planes}; the peak of a pulse comes at that time. {tables.legend(s)} Change: by how much"
        f" beta or B changes while the wind blows; above {100 * STEADY:g} % a frozen vehicle is"
        " doubtful. One pole: whether the slow motion of the flight path may be neglected. Data:"
        " whether those of the flight cover the whole wind."
    )


def availability(found: Findings) -> Section | None:
    """Return which part of an archive's soundings flies, by month and over the limit."""
    return section_of(
        found, "availability", "availability", "On how many days it flies", _availability
    )


def _availability(found: Findings) -> list[Block]:
    a = found.availability
    assert a is not None
    whole = a.part()
    answer: Line = (
        "Limit ",
        *degrees("availability.limit", a.limit, unit="deg"),
        ": ",
        *whole.line,
    )
    blocks: list[Block] = [
        Paragraph((*answer, ".")),
        Paragraph((_how(a), " ", answer_tables.interval(a))),
    ]
    if np.nanmax(a.most, initial=0.0) > 0.0:
        label = "The part of soundings that fly, over the deflection limit"
        caption = (
            "Part of the judged soundings in which a limit is sufficient, over that limit, with its"
            " confidence interval. The vertical line is the limit in question."
        )
        blocks.append(figure_of(availability_chart(a), "availability", label, caption))
    blocks.append(answer_tables.by_month(a))
    if whole.judged:
        blocks.append(answer_tables.placard(a))
    if whole.unknown:
        blocks.append(answer_tables.unknown(a))
    return [*blocks, *checks(a.notes)]


def _how(a: Availability) -> str:
    azimuth = f"{np.degrees(float(a.azimuth)):.4g}"
    first, last = a.soundings.times[[0, -1]].astype("datetime64[D]")
    station = a.soundings.station or "an archive"
    planes = "both planes" if a.plane == "both" else f"the {a.plane} plane"
    return (
        f"The vehicle flies towards {azimuth} deg through each of the {len(a.soundings)} winds of"
        f" {station} from {first} to {last}. It varies while the wind blows, on the {a.model} model"
        f" in {planes}, and is trimmed up to the limit (K = 1), which needs no forecast. Where"
        " a balloon has no data the wind is unknown; such a sounding counts neither as flown nor as"
        " lost."
    )
