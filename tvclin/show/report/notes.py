"""Lines and tables of the sections that have no record with them yet."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from tvclin.base.lines import Line, Row, Table, degrees, number, quantities, significant
from tvclin.case.flexible_autopilot import shift_of
from tvclin.design.standard_trials import bounds, limit_tables, standard_winds
from tvclin.ensembles.availability.availability_record import Availability
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.plant import Plant
from tvclin.requirement import study_tables
from tvclin.requirement.case_requirement import pulse_of
from tvclin.requirement.flight.request import SizingRequest
from tvclin.requirement.flight.sizing import STEADY
from tvclin.requirement.study import Study
from tvclin.studyfile.findings import Findings

# sizing/tables
COLUMNS = (
    "Change: by how much beta or B changes while the wind blows; above"
    f" {100 * STEADY:g} % a frozen vehicle is doubtful. One pole: whether the slow motion of the"
    " flight path may be neglected. Data: whether those of the flight cover the whole wind."
)
"""Definitions of the columns of doubts, in sentences."""


def sounding_lines(request: SizingRequest) -> Iterator[Line]:
    """Yield station, date and direction of flight of each sounding, as a sentence."""
    for name, sounding in request.soundings.items():
        source = sounding.profile.source or "given without a source"
        azimuth = number(f"flight.azimuth.{name}", np.degrees(sounding.azimuth), 1, "deg")
        said = source if source.startswith(name) else f"{name}: {source}"
        yield (f"Measured wind {said}; the flight goes towards ", *azimuth, ".")


# availability/answer_tables
def limit_line(a: Availability) -> Line:
    """Return the limit and the fraction of the soundings that fly with it."""
    return ("Limit ", *degrees("availability.limit", a.limit, unit="deg"), ": ", *a.part().line)


def archive_words(a: Availability) -> str:
    """Return azimuth, number, station and dates of the soundings, as a sentence."""
    azimuth = f"{np.degrees(float(a.azimuth)):.4g}"
    first, last = a.soundings.times[[0, -1]].astype("datetime64[D]")
    station = a.soundings.station or "an archive"
    return (
        f"The vehicle flies towards {azimuth} deg through each of the {len(a.soundings)} winds of"
        f" {station} from {first} to {last}."
    )


# trial_tables
def law_tables(findings: Findings) -> tuple[Table, ...]:
    """Return the tables of `limit_tables` for the laws of a study file."""
    request, s = findings.plan.laws, findings.study
    assert request is not None
    plant = Plant(s.coefficients, findings.plan.law_model)
    winds = standard_winds(s.wind.peak, s.wind.duration)
    return limit_tables(
        findings.trials, bounds(plant, {name: winds[name] for name in request.winds})
    )


# flexible
def shift_lines(plant: AnyPlant) -> tuple[Line, Line] | None:
    """Return the shifts [%] of fast pole and deflection by the structure; None as of `shift_of`."""
    moved = shift_of(plant)
    if moved is None:
        return None
    return (
        number("flexible.shift.fast_pole", moved.fast_pole, 1, "%"),
        number("flexible.shift.trim_price", moved.trim_price, 1, "%"),
    )


# study_tables
def heading_line(s: Study) -> Line:
    """Return the direction from which the wind blows, clockwise from that of flight."""
    assert s.slanting is not None
    assert s.slanting.heading is not None
    heading = float(np.degrees(s.slanting.heading)) % 360.0
    return number("planes.heading_deg", heading, 1, "deg")


def pitch_omitted_fraction(s: Study) -> Line:
    """Return the fraction [%] of the requirement of both planes that the pitch plane omits."""
    assert s.planes is not None
    return number("planes.missing_percent", 100.0 * s.planes.omitted_fraction("pitch"), 1, "%")


def both_planes(s: Study) -> Table:
    """Return the required deflection of both planes with one limit, and of each plane."""
    assert s.planes is not None
    rows: list[tuple[Line, ...]] = [
        (("both planes, one stop",), degrees("planes.required", s.planes.deflection))
    ]
    for plane, required in s.planes.separate.items():
        rows.append(((f"{plane} alone",), degrees(f"planes.{plane}", required)))
    caption = f"Required deflection of both planes, K = {s.dead_band:g}, {s.model}"
    return Table(caption, ("what turns the nozzle", "[deg]"), tuple(rows))


def question(findings: Findings) -> Table:
    """Return the wind, the dead band, the limits and further inputs of a study."""
    s, plan, wind = findings.study, findings.plan, pulse_of(findings.plan)
    rows: list[Row] = [
        ("plane", ("pitch and yaw, one stop" if s.in_both else plan.plane,)),
        ("model of the verdict", (plan.model,)),
        ("wind shape", (wind.shape,)),
        ("peak wind angle", _typed("wind.peak_deg", wind.peak)),
        ("wind duration", significant("wind.duration", wind.duration, 6, "s")),
        ("dead band of the verdict, K", significant("question.dead_band", plan.dead_band)),
        ("left when K times the limit is", (study_tables.LEFT_WHEN[plan.switch],)),
    ]
    if wind.heading is not None:
        heading = _typed("wind.heading_deg", float(wind.heading) % (2.0 * np.pi))
        rows.insert(4, ("it blows from, off the flight", heading))
    if s.encountered or s.sign is not None:
        rows.append(("dynamic pressure", (study_tables.AIR[s.sign],)))
    gust = (s.slanting or s.wind_in_plane).placed_gust
    if gust is not None:
        rows += [
            ("gust on top: peak", _typed("gust.peak_deg", gust.peak)),
            ("it begins", significant("gust.begins", gust.onset, 6, "s")),
            ("it ends", significant("gust.ends", gust.end, 6, "s")),
        ]
    if plan.nozzle.limit is not None:
        rows.append(("deflection limit", degrees("question.limit", plan.nozzle.limit, unit="deg")))
    if plan.nozzle.rate_limit is not None:
        rate = _typed("question.rate_limit", plan.nozzle.rate_limit, "deg/s")
        rows.append(("deflection rate limit", rate))
    return quantities("Wind and question", rows)


def _typed(name: str, angle: Any, unit: str = "deg") -> Line:
    """Return an angle [rad] or a rate [rad/s] in degrees, as it was typed."""
    return significant(name, np.degrees(angle), unit=unit)


# availability/record: property of Availability
def requires_deflection(a: Availability) -> bool:
    """Return whether any judged sounding requires deflection."""
    return bool(np.nanmax(a.most, initial=0.0) > 0.0)
