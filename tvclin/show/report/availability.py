"""The section of the archive: on how many days the limit is enough."""

from collections import Counter

import numpy as np

from tvclin.answers.availability.parts import Part
from tvclin.answers.availability.record import Availability
from tvclin.answers.findings import Findings
from tvclin.base.lines import Line, degrees, number
from tvclin.plots import availability_chart
from tvclin.show.report.blocks import (
    Block,
    Check,
    Checks,
    Figure,
    Paragraph,
    Section,
    Table,
    no_answer,
)
from tvclin.show.report.figures import inline_svg

_TITLE = "On how many days it flies"
_MONTHS = "January February March April May June July August September October November December"
_PLACARD = (0.5, 0.8, 0.9, 0.95, 0.99)


def availability(found: Findings) -> Section | None:
    """Return which part of an archive's soundings flies, by month and over the limit."""
    if "availability" in found.reasons:
        return no_answer("availability", _TITLE, found.reasons["availability"])
    a = found.availability
    if a is None:
        return None
    whole = a.part()
    blocks: list[Block] = [Paragraph(_answer(a, whole)), Paragraph((_how(a),))]
    if np.nanmax(a.most, initial=0.0) > 0.0:
        label = "The part of soundings that fly, over the deflection limit"
        blocks.append(
            Figure(
                label,
                "Soundings that fly over those that are judged, by the deflection limit, with the"
                " ends of the interval. The line upright is the limit in question.",
                inline_svg(availability_chart(a), "availability", label),
            )
        )
    blocks.append(_by_month(a))
    if whole.judged:
        blocks.append(_placard(a))
    if whole.unknown:
        blocks.append(_unknown(a))
    notes = tuple(Check("doubt", (f"{note}.",)) for note in a.notes)
    return Section("availability", _TITLE, (*blocks, *([Checks(notes)] if notes else [])))


def _answer(a: Availability, whole: Part) -> Line:
    limit = degrees("availability.limit", a.limit, unit="deg")
    unknown = number("availability.unknown", whole.unknown, 0)
    if not whole.judged:
        return ("Of the limit of ", *limit, " nothing can be said: all ", *unknown, " are unknown.")
    low, high = whole.bounds
    apart: Line = (
        " Of ",
        *unknown,
        " more it is not known; whatever they were, it is ",
        *number("availability.least_percent", 100.0 * low, 1),
        " to ",
        *number("availability.most_percent", 100.0 * high, 1, "%."),
    )
    return (
        "The limit of ",
        *limit,
        " is enough for ",
        *number("availability.flown", whole.flown, 0),
        " of ",
        *number("availability.judged", whole.judged, 0),
        " soundings, ",
        *number("availability.part_percent", 100.0 * whole.part, 1, "%"),
        f"; {100.0 * whole.confidence:g} % interval ",
        *number("availability.lower_percent", 100.0 * whole.lower, 1),
        " to ",
        *number("availability.upper_percent", 100.0 * whole.upper, 1, "%"),
        ", as of ",
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
        f"Each of the {len(a.soundings)} winds of {station} from {first} to {last} is flown through"
        f" towards {azimuth} deg, with parameters that vary, on the {a.model} model in {planes},"
        " with trim up to the limit (K = 1), which needs no forecast. What a balloon did not see is"
        " unknown, and in no part."
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
    head = ("month", "flown", "of", "unknown", "flown [%]", "from", "to")
    return Table("By month", head, tuple(rows))


def _placard(a: Availability) -> Table:
    limits = zip(_PLACARD, a.placard(_PLACARD).tolist(), strict=True)
    rows = tuple(
        ((f"{100.0 * part:g} %",), degrees(f"availability.placard.{100.0 * part:g}", limit))
        for part, limit in limits
    )
    return Table("The limit that is enough for so many", ("part", "limit [deg]"), rows)


def _unknown(a: Availability) -> Table:
    """Why soundings are not judged; what is wrong with a file is not told line by line."""
    reasons = Counter(why.split(":")[0] for why in a.why if why)
    rows = tuple(
        ((why,), number(f"availability.unknown.{i}", count, 0))
        for i, (why, count) in enumerate(reasons.most_common())
    )
    return Table("Unknown soundings", ("why", "how many"), rows)
