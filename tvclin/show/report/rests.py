"""On what the verdict rests: each assumption, and where it stops holding."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from tvclin.answers.case import FROZEN
from tvclin.answers.findings import Findings
from tvclin.answers.quantity import Requirement
from tvclin.answers.sizing.record import STEADY
from tvclin.answers.study import outlasts_one_pole
from tvclin.base.lines import Line, degrees, number, significant
from tvclin.boundary.optimum.two_poles import single_pole_validity
from tvclin.show.report.blocks import Check, Checks, Section
from tvclin.show.report.verdict import SURVIVES
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.wind_angles import (
    BEYOND_LINEAR,
    MAX_CERTAIN_ANGLE,
    beyond_linear,
    doubtfully_linear,
)


def rests(found: Findings) -> tuple[Check, ...]:
    """Return what the verdict assumes, and whether that holds here."""
    makers = (_wind, _sign, _linear, _slow, _frozen, _rigid, _nozzle)
    return tuple(check for make in makers for check in make(found))


def doubts_counted(checks: Sequence[Check], sections: Sequence[Section]) -> str:
    """Sentence with the number of doubtful assumptions in the head, and of notes in sections."""
    blocks = [one for section in sections for one in section.blocks if isinstance(one, Checks)]
    notes = _doubtful(check for block in blocks for check in block.each)
    doubtful = _doubtful(checks)
    are = "is" if doubtful == 1 else "are"
    head = f"{doubtful or 'None'} of these {len(checks)} assumptions {are} doubtful here"
    others = "1 more doubt is" if notes == 1 else f"{notes} more doubts are"
    return f"{head}; {others} in the sections below." if notes else f"{head}."


def _doubtful(checks: Iterable[Check]) -> int:
    """Number of doubtful assumptions."""
    return sum(one.state == "doubt" for one in checks)


def _wind(found: Findings) -> Iterator[Check]:
    days = "; on how many days of an archive it flies is a question of its own, see below"
    if found.availability is None:
        days = "; tvclin availability counts the days of an archive of soundings"
    words = (
        "This wind is given, and not derived from the winds of a site: whether it is the one to"
        f" survive is for the reader to say{days}."
    )
    yield Check("reader", (words,))


def _sign(found: Findings) -> Iterator[Check]:
    s = found.study
    if s.direction != FROZEN:
        words = f"A {s.direction} wind changes the dynamic pressure. That is counted: it requires "
        ratio = number("rests.pressure_ratio", s.ratio_to_nominal, 3)
        yield Check("ok", (words, *ratio, " times as much as the nominal dynamic pressure."))
    else:
        words = "The dynamic pressure is the nominal one: a head or cross wind raises it."
        yield Check("doubt", (words,))


def _linear(found: Findings) -> Iterator[Check]:
    s, c = found.study, found.comparison
    met = abs(float(s.slanting.peak if s.in_both and s.slanting is not None else s.history.peak))
    if c is not None and np.isfinite(c.peak_angle_of_attack):
        met = max(met, c.peak_angle_of_attack * s.of_both)
    at = degrees("rests.angle_of_attack", met, 1, "deg")
    line: Line = ("Forces are linear in the angle of attack, which reaches ", *at, " here")
    state, survived = "ok", abs(s.survivable_peak or 0.0)
    edge = f"{np.degrees(MAX_CERTAIN_ANGLE):g} deg"
    if beyond_linear(met):
        state, line = "doubt", (*line, f"; {BEYOND_LINEAR}")
    elif doubtfully_linear(met):
        state, line = "doubt", (*line, f"; beyond about {edge} they are not")
    elif doubtfully_linear(survived):
        state = "doubt"
        line += (f'. Beyond about {edge} they are not: of "{SURVIVES}" no more is certain',)
    yield Check(state, (*line, "."))


def _slow(found: Findings) -> Iterator[Check]:
    """Whether the slow mode of the flight path may be neglected."""
    s = found.study
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


def _frozen(found: Findings) -> Iterator[Check]:
    still = "Mass, thrust, air and speed stay as they are while the wind blows"
    if found.flight is None:
        whole = isinstance(found.study.vehicle, Vehicle)
        more = "; a flight ([schedule]) would say how much they change" * whole
        yield Check("reader", (f"{still}{more}.",))
        return
    s, total = found.flight
    if total.time is None:
        return
    i = int(np.argmin(np.abs(s.times - total.time)))
    kept = Requirement(dead_band=s.dead_bands[0])
    counted = kept in s.freezing_error
    each = s.required[replace(kept, varying=counted)][i]
    j = int(np.nanargmax(each))
    changes = float(s.change[i, j])
    percent = number("rests.change_percent", 100.0 * changes, 1, "%")
    by: Line = (" at the worst flight time beta or B changes by up to ", *percent)
    state = "doubt" if changes > STEADY else "ok"
    if not counted:
        yield Check(state, (f"{still};", *by, ", which is not counted."))
        return
    varying, frozen = float(each[j]), float(s.required[kept][i, j])
    needs = degrees("rests.varying", varying, unit="deg")
    would = degrees("rests.frozen", frozen, unit="deg")
    line: Line = (still, ". The whole flight counts their change:", *by, "; the wind needs ")
    yield Check(state, (*line, *needs, " with it, and ", *would, " without."))


def _rigid(found: Findings) -> Iterator[Check]:
    if found.plan.vehicle.structure is None:
        words = "Nothing bends or sloshes: the vehicle file has no bending and no slosh."
        yield Check("reader", (words,))


def _nozzle(found: Findings) -> Iterator[Check]:
    """What the nozzle's rate counts for."""
    has = found.plan.nozzle.rate_limit
    asks: Line = ()
    c = found.comparison
    if c is not None and np.isfinite(c.peak_deflection_rate):
        rate = degrees("rests.rate", c.peak_deflection_rate * found.study.of_both, unit="deg/s")
        asks = (
            " This autopilot turns the nozzle by up to ",
            *rate,
            " in this wind, without a stop.",
        )
    if has is None:
        words = "The rate of the nozzle has no limit (rate_limit_deg_per_s in [nozzle])."
        yield Check("reader", (words, *asks))
    else:
        there = significant("rests.rate_limit", np.degrees(has), unit="deg/s")
        words = "The boundary does not count the rate limit of the nozzle, "
        counts = ". The questions of the rate and of flights do."
        state = "doubt" if _too_fast(found, has) else "ok"
        yield Check(state, (words, *there, counts, *asks))


def _too_fast(found: Findings, rate_limit: float) -> bool:
    """Whether theory or the autopilot takes more than the rate limit [rad/s] of the nozzle."""
    c, front = found.comparison, found.rates
    turns = 0.0 if c is None else c.peak_deflection_rate * found.study.of_both
    return turns > rate_limit or (front is not None and front.needed_rate > rate_limit)
