"""Tables and notes of the autopilot of a study, in its wind and with its limit, and of its laws."""

from collections.abc import Iterator

import numpy as np

from tvclin.base.lines import Line, Table, degrees, minimum_limit, number, quantities, significant
from tvclin.base.quantities import NOMINAL, satisfaction
from tvclin.case.flexible_autopilot import FlexibleAnswer
from tvclin.design.standard_trials import bounds, limit_tables, standard_winds
from tvclin.flights.closed_loop.survival_limit import OK
from tvclin.linear.plant import Plant
from tvclin.studyfile.findings import Findings


def criteria_word(findings: Findings) -> str:
    """Return whether the margins in findings satisfy their criteria, as a word."""
    margins = findings.margins
    assert margins is not None
    return satisfaction(bool(findings.criteria.are_satisfied(margins)))


def tables_in_wind(findings: Findings) -> tuple[Table, Table]:
    """Return two tables of the autopilot in findings, flown in the wind without a limit.

    The first compares its peak deflection with trim and bounds, the second has the largest motions.
    """
    c, s = findings.comparison, findings.study
    assert c is not None
    caption = "The autopilot in this wind, without a limit"
    caption += "" if findings.flexible is None else ", flexible vehicle"
    caption += f", {s.plane} plane alone" if s.judges_both_planes else ""
    # smallest limit with which the autopilot survives [rad]
    limit = None if findings.stop is None else abs(float(findings.stop.deflection))
    deflections = c.deflections(caption + nominal_suffix(findings), limit)
    return deflections, quantities("Largest motions", c.motions())


def nominal_suffix(findings: Findings) -> str:
    """Return words on nominal dynamic pressure, after a comma; empty without a head wind.

    `findings`: results of a study plan. In a head wind the verdict covers its higher pressure too.
    """
    return "" if findings.head is None else f", {NOMINAL}"


def planes_line(findings: Findings) -> Line:
    """Return the sentence on the limit of both planes, relative to the limit of one plane.

    The sentence continues with the deflection limit [deg] that the autopilot then requires in
    flight, where it is finite. `findings`: results of a study plan; `findings.stop` is the boundary
    of the autopilot in this plane, None without a flight.
    """
    s = findings.study
    factor = number("both.factor", s.plane_ratio, 3)
    limit_text = f" times the limit of the {s.plane} plane"
    line: Line = ("Both planes together require ", *factor, limit_text)
    required = np.inf if findings.stop is None else _nominal_requirement(findings)
    if np.isfinite(required):
        needs = degrees("both.stop", required, unit="deg")
        line += (". With that factor this autopilot requires a limit of ", *needs, ", flown")
    return (*line, ".")


def failure(findings: Findings) -> Line:
    """Return the reason why the flight of findings with the limit has no margins, as a line.

    It is a requirement above the limit, or else the message of the computation.
    """
    required, limit = _nominal_requirement(findings), findings.study.limit
    if limit is None or not required > limit:
        return (findings.reasons["flown"],)
    available = degrees("failure.limit", limit, unit="deg")
    if np.isinf(required):
        return ("flown with a limit of ", *available, " or more, the autopilot does not survive")
    requirement = degrees("failure.required", required, unit="deg")
    flown = f", flown{nominal_suffix(findings)}, and has "
    return ("the autopilot requires a limit of ", *requirement, flown, *available)


def requirement_warnings(findings: Findings) -> Iterator[str]:
    """Yield the statuses in findings that make the autopilot requirement doubtful, as text.

    They are of its minimum limits in flight, for a flexible structure of the flexible and of the
    rigid vehicle (`boundaries`), else of the rigid one alone (`stop`).
    """
    f = findings.flexible
    if f is not None:
        names = ("the flexible vehicle", "the rigid vehicle")
        for name, boundary in zip(names, f.boundaries, strict=True):
            if boundary.status != OK:
                yield f"{name}: {boundary.status}"
    elif findings.stop is not None and findings.stop.status != OK:
        yield f"flown with a limit: {findings.stop.status}"


def flexible_flight(findings: Findings) -> Table:
    """Return the table of flexible and rigid vehicle, flown with the limits of the nozzle.

    `findings`: results of a plan whose vehicle has a structure, with its autopilot. Without a limit
    there is no flight, and the table has the smallest limits [deg] that survive alone.
    """
    f, s = findings.flexible, findings.study
    assert isinstance(f, FlexibleAnswer)
    caption = f"Flown in this wind with the nozzle's limits, {f.sample_rate:g} samples a second"
    caption += f", {s.plane} plane alone" if s.judges_both_planes else ""
    flexible, rigid = (abs(boundary.deflection) for boundary in f.boundaries)
    if f.flight is not None:
        return f.flight.table(caption, ("flexible", "rigid"), (flexible, rigid))
    cells = (
        minimum_limit(degrees(f"flown.0.{k}", boundary))
        for k, boundary in enumerate((flexible, rigid))
    )
    head = ("quantity", "flexible", "rigid")
    return Table(caption, head, ((("smallest limit that survives [deg]",), *cells),))


def law_tables(findings: Findings) -> tuple[Table, ...]:
    """Return the tables of the limit that each law of the findings requires in each of its winds.

    They have the bounds of any law, too.
    """
    request, s = findings.plan.laws, findings.study
    assert request is not None
    plant = Plant(s.coefficients, findings.plan.law_model)
    winds = standard_winds(s.wind.peak, s.wind.duration)
    return limit_tables(
        findings.trials, bounds(plant, {name: winds[name] for name in request.winds})
    )


def law_sample_rate(findings: Findings) -> Line:
    """Return the sample rate [Hz] of the laws in the plan of findings, as a line."""
    assert findings.plan.laws is not None
    return significant("laws.sample_rate", findings.plan.laws.sample_rate, 6, "Hz")


def autopilot_as_law(findings: Findings) -> Line:
    """Return the sentence on how the autopilot is flown among the laws, and how for the verdict.

    `findings`: results of a study plan with laws. Laws fly without the gust of the wind and, with a
    rigid vehicle, without actuator and delay; the verdict counts all of these. Empty where neither
    has to be said.
    """
    plan, s, request = findings.plan, findings.study, findings.plan.laws
    gust = ["the gust"] if s.gust is not None else []
    if findings.stop is None or request is None or "autopilot" not in request.names:
        return ("The gust is left out here.",) if gust else ()
    required = _nominal_requirement(findings)
    requirement: Line = ("any limit",)
    if np.isfinite(required):
        requirement = degrees("laws.autopilot_requirement", required, unit="deg")
    differences = gust + (["actuator", "delay"] if plan.vehicle.structure is None else [])
    rate = plan.hardware["sample_rate"]
    if rate != request.sample_rate:
        differences.append(f"{rate:g} samples a second in place of {request.sample_rate:g}")
    differences += ["both planes counted"] if s.judges_both_planes else []
    added = f", flown with {', '.join(differences)}" if differences else ""
    return (
        "The autopilot flies here with the gains of Autopilot and margins. There it requires ",
        *requirement,
        f"{added}{nominal_suffix(findings)}.",
    )


def _nominal_requirement(findings: Findings) -> float:
    """Return the autopilot requirement [rad] at nominal dynamic pressure; NaN where not flown.

    `findings`: results of a study plan. Where both planes are judged it is the limit of both.
    """
    requirement = findings.autopilot_requirement
    return np.nan if requirement is None else requirement.nominal_deflection
