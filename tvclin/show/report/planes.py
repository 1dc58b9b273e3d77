"""The section of both planes: what a wind with a direction asks of one stop."""

import numpy as np

from tvclin.answers.findings import Findings
from tvclin.base.errors import InputError
from tvclin.base.lines import Line, Table, degrees, number
from tvclin.plots import study_planes_chart
from tvclin.show.report.blocks import Block, Figure, Paragraph, Section
from tvclin.show.report.figures import inline_svg


def both_planes(found: Findings) -> Section | None:
    """Return what pitch and yaw ask of one stop; None where the wind has no direction."""
    study, planes = found.study, found.study.planes
    if planes is None or study.slanting is None or study.slanting.heading is None:
        return None
    rows: list[tuple[Line, ...]] = [
        (("both planes, one stop",), degrees("planes.required", planes.deflection))
    ]
    for plane, need in planes.alone.items():
        rows.append(((f"{plane} alone",), degrees(f"planes.{plane}", need)))
    missing = number("planes.missing_percent", 100.0 * planes.misses("pitch"), 1, "%")
    heading = float(np.degrees(study.slanting.heading)) % 360.0
    stop = "the stop that the study names" if study.in_both else "taken as round"
    judged = "both planes" if study.in_both else f"the {study.plane} plane alone"
    words: Line = (
        "The wind blows from ",
        *number("planes.heading_deg", heading, 1, "deg"),
        ", clockwise from the direction of flight. It asks for deflection in pitch and in yaw, and"
        f" the nozzle has one stop for both; here it is {stop}. What both need is set by"
        f" {planes.governs}; a study of the pitch plane alone would miss ",
        *missing,
        f" of it. The verdict is on {judged}.",
    )
    table = Table(
        f"Required deflection of both planes, K = {study.dead_band:g}, {study.model}",
        ("what turns the nozzle", "[deg]"),
        tuple(rows),
    )
    return Section("planes", "Both planes", (Paragraph(words), table, *_figure(found)))


def _figure(found: Findings) -> list[Block]:
    """The demand against the stop; nothing where it has no vector, as with a pair of poles."""
    label = (
        "Trim deflection and the discounted mean of its future, in pitch and yaw, against the stop"
    )
    try:
        drawn = study_planes_chart(found.study)
    except InputError:
        return []
    caption = (
        "Trim deflection in pitch and yaw while the wind blows, and the stop at the boundary (4b)"
        " of both planes together. Where the dead band is left, the engine holds the discounted"
        " mean of the future trim."
    )
    return [Figure(label, caption, inline_svg(drawn, "planes", label))]
