"""The section of the whole flight: required deflections by time, and all the nozzle has to do."""

from tvclin.answers.findings import Findings
from tvclin.answers.sizing.record import STEADY, VARYING, Sizing
from tvclin.answers.sizing.total import DeflectionTotal
from tvclin.base.lines import Line, degrees, number, significant
from tvclin.plots import sizing_chart
from tvclin.show.report.blocks import (
    Block,
    Figure,
    Paragraph,
    Section,
    Table,
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
    frozen = [name for name in sizing.required if not name.endswith(VARYING)]
    varying = [name for name in sizing.required if name.endswith(VARYING)]
    of = f" of {asked.source}" if asked.source else ""
    blocks: list[Block] = [Paragraph((_words(sizing, of),))]
    if sizing.times.size > 1:
        label = "Required deflection over flight time, in the worst wind of each"
        caption = (
            "Required deflection over the flight, in the worst wind of each time. Lines: the"
            " vehicle is frozen at each time."
        )
        caption += " Circles: it varies while the wind blows." if varying else ""
        drawn = inline_svg(sizing_chart(sizing, total.limit), "flight", label)
        blocks.append(Figure(label, caption, drawn))
    for j, wind in enumerate(sizing.winds):
        blocks.append(_required(sizing, j, wind, frozen))
        if varying:
            blocks.append(_varying(sizing, j, wind, varying))
        if sizing.alone:
            blocks.append(_by_planes(sizing, j, wind, asked.counted))
    notes = checks((*asked.warnings, *sizing.notes), asked.notes)
    return [*blocks, _total(total, asked.counted), *_verdict(total), *notes]


def _words(s: Sizing, of: str) -> str:
    planes = "both planes with one stop" if s.alone else f"the {s.plane} plane"
    return (
        f"The table takes the vehicle at each time of the flight{of}, on the {s.model} model in"
        f" {planes}; the peak of a pulse comes at that time. No forecast: {s.law_words}. Minimum:"
        " the wind is known. K below 1: a forecast is trusted. Change: by how much beta or B"
        f" changes while the wind blows; above {100 * STEADY:g} % a frozen vehicle is doubtful. One"
        " pole: whether the slow motion of the flight path may be neglected. Data: whether those of"
        " the flight cover the whole wind."
    )


def _required(s: Sizing, j: int, wind: str, names: list[str]) -> Table:
    """What a wind asks for by flight time, parameters frozen, and where that is doubtful."""
    rows = []
    for i in range(s.times.size):
        cells = [
            *_at(s, i, j, names),
            number(f"flight.{j}.{i}.change_percent", 100.0 * s.change[i, j], 1),
            ("no",) if s.beyond_one_pole[i, j] else ("yes",),
            ("yes",) if s.covered[i, j] else ("no",),
        ]
        rows.append(tuple(cells))
    head = ("time [s]", *names, "change [%]", "one pole", "data")
    return Table(f"Required deflection [deg]: {wind}", head, tuple(rows))


def _by_planes(s: Sizing, j: int, wind: str, name: str) -> Table:
    """What each plane by itself asks for, and by how much the pitch plane is too little."""
    rows = []
    for i in range(s.times.size):
        key = f"flight.{j}.{i}.planes"
        cells = [degrees(f"{key}.both", s.required[name][i, j])]
        cells += [degrees(f"{key}.{k}", one.required[name][i, j]) for k, one in s.alone.items()]
        missing = number(f"{key}.missing_percent", 100.0 * s.pitch_misses[name][i, j], 1)
        rows.append(((f"{s.times[i]:.6g}",), *cells, missing))
    alone = (f"{plane} alone" for plane in s.alone)
    head = ("time [s]", "both planes", *alone, "pitch alone is too little by [%]")
    return Table(f"{name} by planes [deg]: {wind}", head, tuple(rows))


def _varying(s: Sizing, j: int, wind: str, names: list[str]) -> Table:
    rows = []
    for i in range(s.times.size):
        rows.append(((f"{s.times[i]:.6g}",), *_at(s, i, j, names)[1:]))
    head = ("time [s]", *(name.removesuffix(VARYING) for name in names))
    return Table(f"The same, parameters varying [deg]: {wind}", head, tuple(rows))


def _at(s: Sizing, i: int, j: int, names: list[str]) -> list[Line]:
    """The cells of a flight time and wind."""
    key = f"flight.{j}.{i}"
    time = significant(f"{key}.time", s.times[i], 6)
    return [time, *(degrees(f"{key}.{name}", s.required[name][i, j]) for name in names)]


def _total(total: DeflectionTotal, counted: str) -> Table:
    rows: list[tuple[Line, ...]] = [
        (
            (f"{one.name}, {counted}" if one.name == "wind" else one.name,),
            (one.kind,),
            degrees(f"total.{one.name.replace(' ', '_')}", one.deflection),
        )
        for one in total.lines
        if one.deflection
    ]
    rows.append((("total",), ("",), degrees("total.total", total.total)))
    if total.reserve:
        kept = ("limit that keeps ", *number("total.reserve_percent", 100 * total.reserve, 1, "%"))
        rows.append(((*kept, " in reserve"), ("",), degrees("total.required", total.required)))
    at = f"All that takes deflection at the {total.words[0]}"
    return Table(at, ("what", "kind", "[deg]"), tuple(rows))


def _verdict(total: DeflectionTotal) -> list[Paragraph]:
    unknown = f" The flight is not sized {', '.join(total.not_sized)}." if total.not_sized else ""
    if total.left is None or total.limit is None:
        return [Paragraph((unknown.strip(),))] if unknown else []
    line: Line
    left, beside = degrees("total.left", abs(total.left), unit="deg"), total.words[1]
    if total.sufficient:
        line = (f" is enough: it leaves{beside} ", *left)
    elif total.sufficient is None:
        line = (f" is not known to be enough: where the winds are known it leaves{beside} ", *left)
    else:
        of = " of the limit that keeps the reserve" if total.reserve else ""
        short = degrees("total.short", total.required - total.limit, unit="deg")
        line = (" is not enough: it is ", *short, f" short{of}")
    limit = degrees("total.limit", total.limit, unit="deg")
    rest = f". Systematic parts add, random ones by the root of the sum of squares.{unknown}"
    return [Paragraph(("Over the whole flight the limit of ", *limit, *line, rest))]
