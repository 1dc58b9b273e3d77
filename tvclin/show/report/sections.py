"""The sections of the study itself: inputs, boundaries and the response."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.answers.findings import Findings
from tvclin.answers.study import pulse_of
from tvclin.base.lines import Line, Table, degrees, least, number, significant
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.extremes import FALLEN, LET_GO, TURNED_OVER, WHOLE, Point, extremes, shown_until
from tvclin.linear.loads import wind_loads
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_responses
from tvclin.plots import response_chart, response_curves, study_chart
from tvclin.show.report.blocks import Figure, Paragraph, Section, pairs
from tvclin.show.report.figures import inline_svg
from tvclin.show.report.flexible import given
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from control import ControlPlot

_TO_SHOW, _POINTS = 2.0, 401
"""A response is shown for so many durations of the wind, at so many points."""
_SWITCHES = {"literal": "reached by trim", "report": "reached by B times the wind angle"}
_ABOVE = 1.1
"""Without a limit in question, the response is that to so many times what is needed."""


LEAST = {"forecast_free": "no forecast, any law", "minimum": "minimum, wind known"}
"""What stands below the boundaries of every control."""


def inputs(found: Findings) -> Section:
    """Return what went in, each number with its unit."""
    s, plan, wind = found.study, found.plan, pulse_of(found.plan)
    vehicle = [
        (label, significant(f"vehicle.{key}", value, 6, unit))
        for key, label, value, unit in s.vehicle.quantities()
    ]
    case: list[tuple[str, Line]] = [
        ("plane", ("pitch and yaw, one stop" if s.in_both else plan.plane,)),
        ("model of the verdict", (plan.model,)),
        ("wind shape", (wind.shape,)),
        ("peak wind angle", _typed("wind.peak_deg", wind.peak)),
        ("wind duration", significant("wind.duration", wind.duration, 6, "s")),
        ("dead band of the verdict, K", significant("question.dead_band", plan.dead_band)),
        ("left when K times the limit is", (_SWITCHES[plan.switch],)),
    ]
    if wind.heading is not None:
        heading = _typed("wind.heading_deg", float(wind.heading) % (2.0 * np.pi))
        case.insert(4, ("it blows from, off the flight", heading))
    if s.gust is not None:
        case += [
            ("gust on top: peak", _typed("gust.peak_deg", s.gust.peak)),
            ("it begins", significant("gust.begins", s.gust.onset, 6, "s")),
            ("it ends", significant("gust.ends", s.gust.end, 6, "s")),
        ]
    if plan.nozzle.limit is not None:
        case.append(("deflection limit", degrees("question.limit", plan.nozzle.limit, unit="deg")))
    name = s.vehicle.name or "unnamed"
    blocks = (
        Table(f"Vehicle: {name}", ("quantity", "value"), pairs(vehicle)),
        *([] if plan.vehicle.structure is None else given(plan.vehicle.structure)),
        Table("Wind and question", ("quantity", "value"), pairs(case)),
        Table("Linear coefficients", ("quantity", "value"), pairs(_coefficients(found))),
    )
    return Section("inputs", "Inputs", blocks)


def _typed(name: str, angle: Any) -> Line:
    """An angle [rad] in degrees as it was typed."""
    return significant(name, np.degrees(angle), unit="deg")


def boundaries(found: Findings) -> Section:
    """Return the boundary at every dead band, and what stands above and below it."""
    s = found.study
    names = tuple(s.boundaries)
    rows: list[tuple[Line, ...]] = []
    for i, K in enumerate(s.dead_bands):
        row: list[Line] = [("K = ", *significant(f"boundary.{i}.K", K), *_marked(K == s.dead_band))]
        for name in names:
            one, key = s.boundaries[name], f"boundary.{name}.{i}"
            row.append(least(number(f"{key}.limit", one.limit[i])))
            row.append(least(degrees(key, abs(one.deflection[i]))))
        rows.append(tuple(row))
    rows += [((LEAST[key],), *_parts(found, key, needs)) for key, needs in s.needs.items()]
    trim = dict.fromkeys(names, s.trim_deflection)
    rows.insert(0, (("ideal trim",), *_parts(found, "trim", trim)))
    head = ("control", *(h for name in names for h in (f"{name}: over trim", f"{name} [deg]")))
    peak, tau = float(np.degrees(s.wind.peak)), float(s.wind.duration)
    part = f", its part in the {s.plane} plane" if s.slanting is not None else ""
    caption = (
        f"Least deflection limit that survives a {s.shape} wind of {peak:.4g} deg{part}, for"
        f" {tau:g} s{s.blows.gust_words}"
    )
    label = f"Required deflection over the duration of the wind, for {' and '.join(names)}"
    figure = Figure(
        label,
        "Required deflection over the duration of the wind, for each dead band K and model. The dot"
        " is this study.",
        inline_svg(study_chart(s), "boundaries", label),
    )
    words = (
        "Ideal trim cancels the moment of the wind at every instant. With a dead band K the engine"
        " follows trim up to K times the limit and then uses the whole limit: K = 1 needs no"
        " forecast of the wind, K = 0 a certain one. A law that does not know when the wind stops"
        ' needs at least the limit of "no forecast" (with drift a lower bound), and any control at'
        ' least the "minimum". The marked row has the dead band of the verdict.'
    )
    return Section(
        "boundaries", "Boundaries", (Table(caption, head, tuple(rows)), figure, Paragraph((words,)))
    )


def response(found: Findings) -> Section | None:
    """Return the exact response to the limit in question; None where nothing is, or can be."""
    s = found.study
    needed = abs(float(s.requirement.deflection))
    limit = s.limit if s.limit is not None else _ABOVE * needed
    if not limit or np.isinf(limit):
        return None
    plant, wind = Plant(s.coefficients, s.model), s.history
    against = -float(np.sign(s.coefficients.B * wind.peak)) or 1.0
    deflection = trim_then_hold(plant, wind, against * limit, s.dead_band, s.switch)
    end, ends = _end(found, plant, deflection)
    whose = "the limit in question" if s.limit is not None else f"{_ABOVE:g} times what is needed"
    label = f"Attitude, deflection and wind over time with {whose}"
    alone = f" in the {s.plane} plane alone" if s.in_both else ""
    caption = (
        f"Exact response of the linear model{alone} with {whose}, {np.degrees(limit):.3f} deg: the"
        f" engine follows trim until the dead band is left, then it holds the limit. {ends}"
    )
    svg = inline_svg(_over_time(found, plant, deflection, end), "response", label)
    head = ("quantity", "[deg]", "time [s]")
    table = Table("Largest and last values", head, _outstanding(found, plant, deflection, end))
    return Section("response", "Response", (Figure(label, caption, svg), table))


def _end(found: Findings, plant: Plant, deflection: History) -> tuple[float, str]:
    """When a response has said all, and why."""
    wind = found.study.history
    longest = _TO_SHOW * float(wind.end)
    shown = shown_until(plant, deflection, wind, longest)
    words = {
        LET_GO: "It ends where the attitude is back at zero: there an autopilot lets go of the"
        " limit.",
        FALLEN: "It ends where the attitude error exceeds 90 degrees.",
        WHOLE: "The attitude does not come back to zero in this time.",
    }
    said = words[shown.why]
    if shown.why == FALLEN and (found.study.limit is None or found.study.sufficient):
        said += f" {TURNED_OVER}"
    stands = extremes(plant, deflection, wind, shown.time)
    if stands.with_wind is None and stands.against_wind is None:
        said = "Trim stays within the limit, and the attitude at zero."
    return shown.time, said


def _over_time(found: Findings, plant: Plant, deflection: History, end: float) -> "ControlPlot":
    """The figure of a response: angles, deflection and wind."""
    wind = found.study.history
    times = np.linspace(0.0, end, _POINTS)
    answer = attitude_responses(plant, deflection, wind, times)
    curves = response_curves(answer, deflection, wind, "response", "")
    kept = tuple(column for column in curves.columns if column.panel != "rate")
    return response_chart(replace(curves, columns=kept), "", float(wind.end), across=1)


def _outstanding(
    found: Findings, plant: Plant, deflection: History, end: float
) -> tuple[tuple[Line, ...], ...]:
    wind = found.study.history
    stands, loads = extremes(plant, deflection, wind, end), wind_loads(plant, deflection, wind)
    points = (
        (
            "largest attitude error, to the side the wind turns it",
            "with_wind",
            stands.with_wind,
        ),
        ("largest attitude error, to the other side", "against_wind", stands.against_wind),
        ("attitude error when the wind ends", "at_wind_end", stands.at_wind_end),
        ("attitude error at the end of the figure", "at_end", stands.at_end),
        (
            "largest angle of attack while the wind blows",
            "angle_of_attack",
            Point(loads.peak_angle_of_attack, loads.peak_time) if end >= wind.end else None,
        ),
    )
    return tuple(
        (
            (label,),
            degrees(f"response.{key}", point.value),
            number(f"response.{key}_s", point.time, 2),
        )
        for label, key, point in points
        if point is not None
    )


def _coefficients(found: Findings) -> list[tuple[str, Line]]:
    c = found.study.coefficients
    rows: list[tuple[str, Line]] = []
    if c.mu_alpha > 0.0:
        rows.append(("beta", significant("coefficients.beta", c.beta, 4, "1/s")))
        if c.damping:
            rows.append(("damping", significant("coefficients.damping", c.damping, 4, "1/s")))
            rows.append(("pole p", significant("coefficients.pole", c.pole, 4, "1/s")))
        rows.append(("K1", significant("coefficients.K1", c.K1, 4)))
    rows += [
        ("B", significant("coefficients.B", c.B, 4, "deg/deg")),
        ("C1", significant("coefficients.C1", c.C1, 4, "1/s")),
        ("C2", significant("coefficients.C2", c.C2, 4, "1/s³")),
        ("b1", significant("coefficients.b1", c.b1, 4, "1/s")),
        ("b2", significant("coefficients.b2", c.b2, 4, "1/s")),
    ]
    return rows


def _parts(found: Findings, key: str, needs: dict[str, float]) -> list[Line]:
    """Cells of a deflection for each model: over trim, and in degrees."""
    cells: list[Line] = []
    for name in found.study.boundaries:
        if name in needs and found.study.trim_deflection:
            part = needs[name] / found.study.trim_deflection
            cells += [number(f"{key}.{name}.part", part), degrees(f"{key}.{name}", needs[name])]
        else:
            cells += [("-",), ("-",)]
    return cells


def _marked(here: bool) -> Line:
    return (" (verdict)",) if here else ()
