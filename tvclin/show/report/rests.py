"""Assumptions of the verdict, each with whether it holds here."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from tvclin.base.lines import Line, degrees, number, significant
from tvclin.boundary.optimum.two_poles import single_pole_validity
from tvclin.case.case import FROZEN
from tvclin.requirement.flight.sizing import STEADY
from tvclin.requirement.required_quantity import Requirement
from tvclin.requirement.study import outlasts_one_pole
from tvclin.show.report.blocks import Check, Checks, Section
from tvclin.show.report.verdict import SURVIVES
from tvclin.studyfile.findings import Findings
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.wind_angles import (
    BEYOND_LINEAR,
    MAX_CERTAIN_ANGLE,
    beyond_linear,
    doubtfully_linear,
)


def rests(findings: Findings) -> tuple[Check, ...]:
    """Return the assumptions of the verdict, each with whether it holds here."""
    makers = (_wind, _sign, _linear, _slow, _frozen, _rigid, _nozzle)
    return tuple(check for make in makers for check in make(findings))


def doubts_counted(checks: Sequence[Check], sections: Sequence[Section]) -> str:
    """Return the number of doubtful assumptions in the head, and of notes, as a sentence."""
    blocks = [
        block for section in sections for block in section.blocks if isinstance(block, Checks)
    ]
    notes = _doubtful(check for block in blocks for check in block.each)
    doubtful = _doubtful(checks)
    are = "is" if doubtful == 1 else "are"
    head = f"{doubtful or 'None'} of these {len(checks)} assumptions {are} doubtful here"
    others = "1 more doubt is" if notes == 1 else f"{notes} more doubts are"
    return f"{head}; {others} in the sections below." if notes else f"{head}."


def _doubtful(checks: Iterable[Check]) -> int:
    """Return the number of doubtful assumptions."""
    return sum(check.state == "doubt" for check in checks)


def _wind(findings: Findings) -> Iterator[Check]:
    days = "; on how many days of an archive it flies is a question of its own, see below"
    if findings.availability is None:
        days = "; tvclin availability counts the days of an archive of soundings"
    words = (
        "This wind is given, and not derived from the winds of a site: whether it is the one to"
        f" survive is for the reader to say{days}."
    )
    yield Check("reader", (words,))


def _sign(findings: Findings) -> Iterator[Check]:
    s = findings.study
    if s.direction != FROZEN:
        words = f"A {s.direction} wind changes the dynamic pressure. That is counted: it requires "
        ratio = number("rests.pressure_ratio", s.ratio_to_nominal, 3)
        yield Check("ok", (words, *ratio, " times as much as the nominal dynamic pressure."))
    else:
        words = "The dynamic pressure is the nominal one: a head or cross wind raises it."
        yield Check("doubt", (words,))


def _linear(findings: Findings) -> Iterator[Check]:
    s, c = findings.study, findings.comparison
    angle = abs(float(s.slanting.peak if s.in_both and s.slanting is not None else s.history.peak))
    if c is not None and np.isfinite(c.peak_angle_of_attack):
        angle = max(angle, c.peak_angle_of_attack * s.of_both)
    reached = degrees("rests.angle_of_attack", angle, 1, "deg")
    line: Line = ("Forces are linear in the angle of attack, which reaches ", *reached, " here")
    state, survived = "ok", abs(s.survivable_peak or 0.0)
    edge = f"{np.degrees(MAX_CERTAIN_ANGLE):g} deg"
    if beyond_linear(angle):
        state, line = "doubt", (*line, f"; {BEYOND_LINEAR}")
    elif doubtfully_linear(angle):
        state, line = "doubt", (*line, f"; beyond about {edge} they are not")
    elif doubtfully_linear(survived):
        state = "doubt"
        line += (f'. Beyond about {edge} they are not: of "{SURVIVES}" no more is certain',)
    yield Check(state, (*line, "."))


def _slow(findings: Findings) -> Iterator[Check]:
    """Yield the check of whether the slow mode of the flight path may be neglected."""
    s = findings.study
    if not isinstance(s.vehicle, Vehicle):
        words = (
            "The flight path is held fixed: the vehicle's coefficients do not tell how it drifts"
            " with the wind."
        )
        yield Check("reader", (words,))
        return
    edge = float(single_pole_validity(s.coefficients))
    if np.isnan(edge):
        words = (
            "Up to which duration the slow motion of the flight path may be neglected is not"
            " defined: the vehicle has no two real unstable poles."
        )
        yield Check("reader", (words,))
        return
    tau = significant("validity.duration", float(s.wind.duration), unit="s")
    upto = significant("validity.edge", edge, 3, unit="s")
    if outlasts_one_pole(s):
        begin = "The slow motion of the flight path counts: the wind lasts "
        end = " up to which it may be neglected; more may be needed than the boundary says."
        yield Check("doubt", (begin, *tau, ", longer than the ", *upto, end))
        return
    begin = "The slow motion of the flight path may be neglected: the wind lasts "
    yield Check("ok", (begin, *tau, ", not longer than ", *upto, "."))


def _frozen(findings: Findings) -> Iterator[Check]:
    still = "Mass, thrust, air and speed stay as they are while the wind blows"
    if findings.flight is None:
        complete = isinstance(findings.study.vehicle, Vehicle)
        more = "; a flight ([schedule]) would say how much they change" * complete
        yield Check("reader", (f"{still}{more}.",))
        return
    s, total = findings.flight
    if total.time is None:
        return
    i = int(np.argmin(np.abs(s.times - total.time)))
    requirement = Requirement(dead_band=s.dead_bands[0])
    counted = requirement in s.freezing_error
    deflections = s.required[replace(requirement, varying=counted)][i]
    j = int(np.nanargmax(deflections))
    changes = float(s.change[i, j])
    percent = number("rests.change_percent", 100.0 * changes, 1, "%")
    change_text: Line = (" at the worst flight time beta or B changes by up to ", *percent)
    state = "doubt" if changes > STEADY else "ok"
    if not counted:
        yield Check(state, (f"{still};", *change_text, ", which is not counted."))
        return
    varying, frozen = float(deflections[j]), float(s.required[requirement][i, j])
    needs = degrees("rests.varying", varying, unit="deg")
    would = degrees("rests.frozen", frozen, unit="deg")
    line: Line = (
        still,
        ". The whole flight counts their change:",
        *change_text,
        "; the wind needs ",
    )
    yield Check(state, (*line, *needs, " with it, and ", *would, " without."))


def _rigid(findings: Findings) -> Iterator[Check]:
    if findings.plan.vehicle.structure is None:
        words = "Nothing bends or sloshes: the vehicle file has no bending and no slosh."
        yield Check("reader", (words,))


def _nozzle(findings: Findings) -> Iterator[Check]:
    """Yield the check of the nozzle's rate limit against the rate that the autopilot requires."""
    rate_limit = findings.plan.nozzle.rate_limit
    rate_text: Line = ()
    c = findings.comparison
    if c is not None and np.isfinite(c.peak_deflection_rate):
        rate = degrees("rests.rate", c.peak_deflection_rate * findings.study.of_both, unit="deg/s")
        rate_text = (
            " This autopilot turns the nozzle by up to ",
            *rate,
            " in this wind, without a stop.",
        )
    if rate_limit is None:
        words = "The rate of the nozzle has no limit (rate_limit_deg_per_s in [nozzle])."
        yield Check("reader", (words, *rate_text))
    else:
        limit_text = significant("rests.rate_limit", np.degrees(rate_limit), unit="deg/s")
        words = "The boundary does not count the rate limit of the nozzle, "
        counts = ". The questions of the rate and of flights do."
        state = "doubt" if _too_fast(findings, rate_limit) else "ok"
        yield Check(state, (words, *limit_text, counts, *rate_text))


def _too_fast(findings: Findings, rate_limit: float) -> bool:
    """Return whether theory or the autopilot requires more than the rate limit [rad/s]."""
    c, front = findings.comparison, findings.rates
    turns = 0.0 if c is None else c.peak_deflection_rate * findings.study.of_both
    return turns > rate_limit or (front is not None and front.required_rate > rate_limit)
