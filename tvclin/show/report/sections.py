"""Sections of the study itself: vehicle, inputs, boundaries, planes, response and load."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.errors import InputError
from tvclin.base.lines import Line, Table, degrees, number, quantities, significant
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.extremes import (
    COMPLETE,
    OVERTURNED,
    OVERTURNED_NOTE,
    RELEASED,
    extremes,
    response_end,
    response_table,
    wind_loads,
)
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_responses
from tvclin.plots import (
    load_chart,
    response_chart,
    response_curves,
    study_chart,
    study_planes_chart,
    vehicle_chart,
)
from tvclin.requirement import study_tables as tables
from tvclin.requirement.case_requirement import pulse_of
from tvclin.show.report.blocks import Block, Paragraph, Section, as_sentence, section_of
from tvclin.show.report.figures import figure_of
from tvclin.show.report.flexible import given
from tvclin.studyfile.findings import Findings
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from control import ControlPlot

_END_OVER_DURATION, _POINTS = 2.0, 401
"""Longest time of a response shown, in durations of the wind, and its number of points."""
_LIMIT_OVER_REQUIREMENT = 1.1
"""Limit of the response over the required deflection, where the study has no limit."""
_CAPTION = (
    "The vehicle along its axis, with lengths to scale. Its radius, nose and nozzle are sketched:"
    " they are not among its numbers."
)


def vehicle(findings: Findings) -> Section:
    """Return the section of the vehicle; one defined by its coefficients alone has no drawing."""
    study_vehicle, blocks = findings.study.vehicle, list[Block]()
    if isinstance(study_vehicle, Vehicle):
        label = "The vehicle along its axis: control force, centres of gravity and of pressure"
        caption = f"{_CAPTION} {_source(study_vehicle)}"
        blocks.append(
            figure_of(vehicle_chart(study_vehicle, findings.study.limit), "vehicle", label, caption)
        )
    input_tables = (tables.vehicle(findings.study), tables.coefficients(findings.study))
    return Section("vehicle", "The vehicle", (*blocks, *input_tables))


def _source(study_vehicle: Vehicle) -> str:
    if study_vehicle.numbers_from:
        return f"The numbers come from: {study_vehicle.numbers_from}."
    return "The vehicle file does not say where its numbers come from (numbers_from in [vehicle])."


def inputs(findings: Findings) -> Section:
    """Return the section of the inputs, each number with its unit."""
    s, plan, wind = findings.study, findings.plan, pulse_of(findings.plan)
    case: list[tuple[str, Line]] = [
        ("plane", ("pitch and yaw, one stop" if s.in_both else plan.plane,)),
        ("model of the verdict", (plan.model,)),
        ("wind shape", (wind.shape,)),
        ("peak wind angle", _typed("wind.peak_deg", wind.peak)),
        ("wind duration", significant("wind.duration", wind.duration, 6, "s")),
        ("dead band of the verdict, K", significant("question.dead_band", plan.dead_band)),
        ("left when K times the limit is", (tables.LEFT_WHEN[plan.switch],)),
    ]
    if wind.heading is not None:
        heading = _typed("wind.heading_deg", float(wind.heading) % (2.0 * np.pi))
        case.insert(4, ("it blows from, off the flight", heading))
    if s.encountered or s.sign is not None:
        case.append(("dynamic pressure", (tables.AIR[s.sign],)))
    gust = (s.slanting or s.wind_in_plane).placed_gust
    if gust is not None:
        case += [
            ("gust on top: peak", _typed("gust.peak_deg", gust.peak)),
            ("it begins", significant("gust.begins", gust.onset, 6, "s")),
            ("it ends", significant("gust.ends", gust.end, 6, "s")),
        ]
    if plan.nozzle.limit is not None:
        case.append(("deflection limit", degrees("question.limit", plan.nozzle.limit, unit="deg")))
    if plan.nozzle.rate_limit is not None:
        rate = _typed("question.rate_limit", plan.nozzle.rate_limit, "deg/s")
        case.append(("deflection rate limit", rate))
    blocks = (
        *([] if plan.vehicle.structure is None else given(plan.vehicle.structure)),
        quantities("Wind and question", case),
        tables.poles(s),
    )
    return Section("inputs", "Inputs", blocks)


def _typed(name: str, angle: Any, unit: str = "deg") -> Line:
    """Return an angle [rad] or a rate [rad/s] in degrees, as it was typed."""
    return significant(name, np.degrees(angle), unit=unit)


def boundaries(findings: Findings) -> Section:
    """Return the section of the boundaries by dead band and model, with trim and the minimum."""
    s = findings.study
    plane_text = f" and in the {s.plane} plane alone" if s.in_both else ""
    label = f"Required deflection over the duration of the wind, for {' and '.join(s.boundaries)}"
    caption = (
        "Required deflection over the duration of the wind, for each dead band K and model, in the"
        f" nominal dynamic pressure{plane_text}. The dot is what this study requires."
    )
    words = (
        "Ideal trim cancels the moment of the wind at every instant. With a dead band K the engine"
        " follows trim up to K times the limit and then uses the whole limit: K = 1 needs no"
        f" forecast of the wind, and K = 0 knows it for certain. {tables.LEGEND} The row marked"
        " (verdict) is what is required."
    )
    if s.encountered:
        words += (
            " The rows of a head and a tail wind have the dynamic pressure that the vehicle meets"
            " in them, all others the nominal one."
        )
    shown: Block = Paragraph(
        (f"{as_sentence(s.beyond)} Over trim stand the limits of the linear equations.",)
    )
    if not s.beyond:
        shown = figure_of(study_chart(s), "boundaries", label, caption)
    blocks = (tables.boundaries(s), shown, Paragraph((words,)))
    return Section("boundaries", "Boundaries", blocks)


def both_planes(findings: Findings) -> Section | None:
    """Return the section of the deflection required of pitch and yaw with one limit.

    None where the wind has no direction.
    """
    study, planes = findings.study, findings.study.planes
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
    return Section("planes", "Both planes", (Paragraph(words), table, *_against_the_stop(findings)))


def _against_the_stop(findings: Findings) -> list[Block]:
    """Return the figure of the demand against the limit; an empty list where it has no vector.

    A complex pair of poles gives no vector.
    """
    label = (
        "Trim deflection and the discounted mean of its future, in pitch and yaw, against the stop"
    )
    try:
        drawn = study_planes_chart(findings.study)
    except InputError:
        return []
    caption = (
        "Trim deflection in pitch and yaw while the wind blows, and the stop at the boundary (4b)"
        " of both planes together. Where the dead band is left, the engine holds the discounted"
        " mean of the future trim."
    )
    return [figure_of(drawn, "planes", label, caption)]


def response(findings: Findings) -> Section | None:
    """Return the section of the exact response with the limit; None if that is 0 or infinite."""
    s = findings.study
    needed = abs(float(s.requirement.deflection))
    limit = s.limit if s.limit is not None else _LIMIT_OVER_REQUIREMENT * needed
    if not limit or np.isinf(limit):
        return None
    plant, wind = Plant(s.coefficients, s.model), s.history
    against = -float(np.sign(s.coefficients.B * wind.peak)) or 1.0
    deflection = trim_then_hold(plant, wind, against * limit, s.dead_band, s.switch)
    end, ends = _end(findings, plant, deflection)
    whose = (
        "the limit in question"
        if s.limit is not None
        else f"{_LIMIT_OVER_REQUIREMENT:g} times what is needed"
    )
    label = f"Attitude, deflection and wind over time with {whose}"
    plane_text = f" in the {s.plane} plane alone" if s.in_both else ""
    caption = (
        f"Exact response of the linear model{plane_text} with {whose}, {np.degrees(limit):.3f} deg:"
        f" the engine follows trim until the dead band is left, then it holds the limit. {ends}"
    )
    drawn = _response_plot(findings, plant, deflection, end, limit)
    figure = figure_of(drawn, "response", label, caption)
    stands, loads = extremes(plant, deflection, s.history, end), None
    if end >= s.history.end:
        loads = wind_loads(plant, deflection, s.history)
    table = response_table("Largest and last values", stands, loads)
    return Section("response", "Response", (figure, table))


def _end(findings: Findings, plant: Plant, deflection: History) -> tuple[float, str]:
    """Return the end of the response shown [s], and the sentence that says why."""
    wind = findings.study.history
    longest = _END_OVER_DURATION * float(wind.end)
    shown = response_end(plant, deflection, wind, longest)
    words = {
        RELEASED: "It ends where the attitude is back at zero: there an autopilot lets go of the"
        " limit.",
        OVERTURNED: "It ends where the attitude error exceeds 90 degrees.",
        COMPLETE: "The attitude does not come back to zero in this time.",
    }
    said = words[shown.why]
    if shown.why == OVERTURNED and (findings.study.limit is None or findings.study.sufficient):
        said += f" {OVERTURNED_NOTE}"
    stands = extremes(plant, deflection, wind, shown.time)
    if stands.with_wind is None and stands.against_wind is None:
        said = "Trim stays within the limit, and the attitude at zero."
    return shown.time, said


def _response_plot(
    findings: Findings, plant: Plant, deflection: History, end: float, limit: float
) -> "ControlPlot":
    """Return the plot of a response: angles, deflection with its limit [rad], and wind."""
    wind = findings.study.history
    answer = attitude_responses(plant, deflection, wind, np.linspace(0.0, end, _POINTS))
    curves = response_curves(answer, limit=limit, deflection=deflection, wind=wind)
    columns = tuple(column for column in curves.columns if column.panel != "rate")
    return response_chart(replace(curves, columns=columns), across=1)


def load(findings: Findings) -> Section | None:
    """Return the section of the minimum deflection over the largest load."""
    return section_of(findings, "loads", "load", "What the structure bears", _load)


def _load(findings: Findings) -> list[Block]:
    front = findings.loads
    assert front is not None
    label = "Least deflection over the largest load"
    caption = (
        "Least deflection of a control that knows the wind, over the largest load. Dashed: at least"
        " so much takes a law that does not know when the wind stops."
    )
    figure = figure_of(load_chart(front), "load", label, caption)
    notes = " ".join(map(as_sentence, front.notes))
    said = Paragraph((f"The verdict here: {front.verdict}. {notes}",))
    return [said, figure, *front.tables()]
