"""The section of the archive: on how many days the limit is enough."""

from collections import Counter

import numpy as np

from tvclin.answers.availability.confidence import Part
from tvclin.answers.availability.record import Availability
from tvclin.answers.findings import Findings
from tvclin.base.lines import Line, Table, degrees, number
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

_MONTHS = "January February March April May June July August September October November December"
_PLACARD = (0.5, 0.8, 0.9, 0.95, 0.99)


def availability(found: Findings) -> Section | None:
    """Return which part of an archive's soundings flies, by month and over the limit."""
    return section_of(found, "availability", "availability", "On how many days it flies", _blocks)


def _blocks(found: Findings) -> list[Block]:
    a = found.availability
    assert a is not None
    whole = a.part()
    blocks: list[Block] = [Paragraph(_answer(a, whole)), Paragraph((_how(a),))]
    if np.nanmax(a.most, initial=0.0) > 0.0:
        label = "The part of soundings that fly, over the deflection limit"
        caption = (
            "Part of the judged soundings in which a limit is enough, over that limit, with its"
            " confidence interval. The vertical line is the limit in question."
        )
        svg = inline_svg(availability_chart(a), "availability", label)
        blocks.append(Figure(label, caption, svg))
    blocks.append(_by_month(a))
    if whole.judged:
        blocks.append(_placard(a))
    if whole.unknown:
        blocks.append(_unknown(a))
    return [*blocks, *checks(a.notes)]


def _answer(a: Availability, whole: Part) -> Line:
    limit = degrees("availability.limit", a.limit, unit="deg")
    unknown = number("availability.unknown", whole.unknown, 0)
    if not whole.judged:
        return ("Of the limit of ", *limit, " nothing can be said: all ", *unknown, " are unknown.")
    low, high = whole.bounds
    apart: Line = (
        " It is not known of ",
        *unknown,
        " more: with all of them lost the part is ",
        *number("availability.least_percent", 100.0 * low, 1, "%"),
        ", with all of them flown ",
        *number("availability.most_percent", 100.0 * high, 1, "%."),
    )
    return (
        "The limit of ",
        *limit,
        " is enough in ",
        *number("availability.flown", whole.flown, 0),
        " of ",
        *number("availability.judged", whole.judged, 0),
        " soundings, ",
        *number("availability.part_percent", 100.0 * whole.part, 1, "%"),
        f", with a {100.0 * whole.confidence:g} % confidence interval from ",
        *number("availability.lower_percent", 100.0 * whole.lower, 1),
        " to ",
        *number("availability.upper_percent", 100.0 * whole.upper, 1, "%"),
        ": they count as ",
        *number("availability.effective", whole.effective, 0),
        " independent ones.",
        *(apart if whole.unknown else ()),
    )


def _how(a: Availability) -> str:
    azimuth = f"{np.degrees(float(a.azimuth)):.4g}"
    first, last = a.soundings.times[[0, -1]].astype("datetime64[D]")
    station = a.soundings.station or "an archive"
    planes = "both planes" if a.plane == "both" else f"the {a.plane} plane"
    return (
        f"The vehicle flies towards {azimuth} deg through each of the {len(a.soundings)} winds of"
        f" {station} from {first} to {last}. It varies while the wind blows, on the {a.model} model"
        f" in {planes}, and is trimmed up to the limit (K = 1), which needs no forecast. A wind"
        " that the balloon did not see is unknown, and counts in no part."
    )


def _by_month(a: Availability) -> Table:
    names, rows = _MONTHS.split(), []
    for month, part in a.by_month().items():
        key = f"availability.month.{month}"
        counts = {"flown": part.flown, "judged": part.judged, "unknown": part.unknown}
        shares = {"part": part.part, "lower": part.lower, "upper": part.upper}
        cells = [number(f"{key}.{name}", value, 0) for name, value in counts.items()]
        cells += [number(f"{key}.{k}_percent", 100.0 * x, 1) for k, x in shares.items()]
        rows.append(((names[month - 1],), *cells))
    head = ("month", "enough in", "of", "unknown", "part [%]", "from [%]", "to [%]")
    return Table("By month", head, tuple(rows))


def _placard(a: Availability) -> Table:
    limits = zip(_PLACARD, a.placard(_PLACARD).tolist(), strict=True)
    rows = tuple(
        ((f"{100.0 * part:g} %",), degrees(f"availability.placard.{100.0 * part:g}", limit))
        for part, limit in limits
    )
    return Table("Limit that is enough in a part of soundings", ("part", "limit [deg]"), rows)


def _unknown(a: Availability) -> Table:
    """Why soundings are not judged; what is wrong with a file is not told line by line."""
    reasons = Counter(why.split(":")[0] for why in a.why if why)
    rows = tuple(
        ((why,), number(f"availability.unknown.{i}", count, 0))
        for i, (why, count) in enumerate(reasons.most_common())
    )
    return Table("Unknown soundings", ("why", "number"), rows)
