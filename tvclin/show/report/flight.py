"""Sections of the whole flight: required deflection over flight time, and availability."""

from collections.abc import Iterator

import numpy as np

from tvclin.base.lines import Line, degrees, number
from tvclin.ensembles.availability import availability_record as answer_tables
from tvclin.ensembles.availability.availability_record import Availability
from tvclin.plots import availability_chart, sizing_chart
from tvclin.requirement.flight import sizing_tables as tables
from tvclin.requirement.flight.request import SizingRequest
from tvclin.requirement.flight.sizing import STEADY, Sizing
from tvclin.requirement.flight.total import total_table
from tvclin.show.report.blocks import Block, Paragraph, Section, checks, section_of
from tvclin.show.report.figures import figure_of
from tvclin.studyfile.findings import Findings


def over_flight(findings: Findings) -> Section | None:
    """Return the section of required deflections by flight time and wind, and the worst total."""
    return section_of(findings, "flight", "flight", "The whole flight", _over_flight)


def _over_flight(findings: Findings) -> list[Block]:
    request = findings.plan.sizing
    assert request is not None
    assert findings.flight is not None
    sizing, total = findings.flight
    counted = request.counted(sizing, findings.plan.sign)
    of = f" of {request.source}" if request.source else ""
    blocks: list[Block] = [Paragraph((_words(sizing, of),)), *_measured(request)]
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
    ratio = request.ratio(findings.plan, sizing)
    notes = checks(
        (*request.warnings, *sizing.notes), (*request.notes, *(ratio.notes if ratio else ()))
    )
    verdict = [Paragraph(line) for line in total.verdict]
    ratio_blocks: list[Block] = [ratio.table, Paragraph(ratio.verdict)] if ratio else []
    blocks += [total_table(total, counted.label), *verdict, *ratio_blocks]
    if (card := findings.card) is not None:
        said = Paragraph((f"The card of the nozzle, {card.law} flown: {card.verdict.words}.",))
        blocks += [said, *card.tables(), *checks((), card.notes)]
    elif "card" in findings.reasons:
        blocks.append(Paragraph((f"No card of the nozzle: {findings.reasons['card']}.",)))
    return [*blocks, *notes]


def _measured(request: SizingRequest) -> Iterator[Block]:
    """Yield a paragraph for each sounding, with station, date and direction of flight."""
    for name, sounding in request.soundings.items():
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


def availability(findings: Findings) -> Section | None:
    """Return the section of the fraction of soundings that fly, by month and over the limit."""
    return section_of(
        findings, "availability", "availability", "On how many days it flies", _availability
    )


def _availability(findings: Findings) -> list[Block]:
    a = findings.availability
    assert a is not None
    share = a.part()
    answer: Line = (
        "Limit ",
        *degrees("availability.limit", a.limit, unit="deg"),
        ": ",
        *share.line,
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
    if share.judged:
        blocks.append(answer_tables.placard(a))
    if share.unknown:
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
