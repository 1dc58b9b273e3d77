"""The section of the archive: on how many days the limit is enough."""

import numpy as np

from tvclin.answers.availability import answer_tables
from tvclin.answers.availability.record import Availability
from tvclin.answers.findings import Findings
from tvclin.base.lines import Line, degrees
from tvclin.plots import availability_chart
from tvclin.show.report.blocks import (
    Block,
    Figure,
    Paragraph,
    Section,
    checks,
    section_of,
)
from tvclin.show.report.figures import inline_svg


def availability(found: Findings) -> Section | None:
    """Return which part of an archive's soundings flies, by month and over the limit."""
    return section_of(found, "availability", "availability", "On how many days it flies", _blocks)


def _blocks(found: Findings) -> list[Block]:
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
            "Part of the judged soundings in which a limit is enough, over that limit, with its"
            " confidence interval. The vertical line is the limit in question."
        )
        svg = inline_svg(availability_chart(a), "availability", label)
        blocks.append(Figure(label, caption, svg))
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
