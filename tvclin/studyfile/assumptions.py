"""The assumptions of a study's verdict: whether each holds, its warnings, and what is general."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tvclin.base.lines import Line, degrees, listed, number, significant
from tvclin.base.quantities import NOMINAL
from tvclin.boundary.optimum.two_poles import single_pole_validity
from tvclin.control.margins.bands import BandMargins
from tvclin.requirement.flight.sizing import STEADY
from tvclin.requirement.required_quantity import Requirement
from tvclin.requirement.study import OUTLASTS, nominal_pressure
from tvclin.studyfile.findings import Findings
from tvclin.studyfile.questions import questions
from tvclin.studyfile.verdict import SURVIVES
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.wind_angles import (
    BEYOND_LINEAR,
    DOUBTFUL,
    FROZEN,
    MAX_CERTAIN_ANGLE,
    beyond_linear,
    doubtfully_linear,
)

_ASSUMED = "reader"
"""State of an assumption that nothing here checks: the reader of the page has to judge it."""


@dataclass(frozen=True)
class Assumption:
    """Assumption of a verdict: it holds ("ok"), is doubtful ("doubt"), or is not checked.

    `line`: the assumption in a sentence.
    """

    state: str
    line: Line


def assumptions(findings: Findings) -> tuple[Assumption, ...]:
    """Return the assumptions of the verdict in findings of a study, each with whether it holds."""
    makers = (_wind, _sign, _linear, _slow, _frozen, _rigid, _modes, _nozzle)
    return tuple(assumption for make in makers for assumption in make(findings))


def doubts_counted(assumed: Sequence[Assumption], notes: int) -> str:
    """Return the number of doubtful assumptions, and of further warnings, as a sentence.

    `assumed`: all assumptions of the verdict. `notes`: number of warnings elsewhere on the page.
    """
    doubtful = sum(assumption.state == "doubt" for assumption in assumed)
    are = "is" if doubtful == 1 else "are"
    head = f"{doubtful or 'None'} of these {len(assumed)} assumptions {are} doubtful here"
    others = "1 more warning is" if notes == 1 else f"{notes} more warnings are"
    return f"{head}; {others} in the sections below." if notes else f"{head}."


def study_warnings(findings: Findings) -> Iterator[str]:
    """Yield the notes and warnings in findings that no assumption states, as text.

    `findings`: results of a study plan. They are on boundaries, the study, nominal pressure, the
    computation, and the autopilot.
    """
    s = findings.study
    for name, boundary in s.boundaries.items():
        for status in dict.fromkeys(str(status) for status in boundary.status if status != "ok"):
            yield f"boundaries on the {name} model: {status}"
    # the slow mode and linear aerodynamics are assumptions
    yield from (note for note in s.notes if OUTLASTS not in note and DOUBTFUL not in note)
    yield from nominal_notes(findings)
    yield from findings.warnings
    if findings.comparison is not None:
        comparison = findings.comparison
        for note in dict.fromkeys((*comparison.margins.notes, *comparison.notes)):
            yield f"autopilot: {note}"


def general_assumptions(findings: Findings) -> Iterator[str]:
    """Yield the assumptions that every study makes, as text, for the vehicle of these findings."""
    yield "the motion is planar, linear, and a deviation from the nominal flight"
    yield "the engine stops sharply at its limit"
    damped = "" if findings.study.coefficients.damping else ", damping of the attitude rate"
    if findings.plan.vehicle.structure is None:
        yield f"bending, slosh{damped} and sensor noise are left out"
    else:
        yield (
            "bending and slosh count for the autopilot alone, and are left out of all else; sensor"
            f" noise{damped} is left out"
        )
    if findings.dispersed is not None:
        yield "the dispersions are those given, and not checked"


def _wind(findings: Findings) -> Iterator[Assumption]:
    """Yield the assumption that the wind of findings is given, which the reader has to judge."""
    days = "; on how many days of an archive it flies is a question of its own, see below"
    if findings.availability is None:
        days = "; tvclin availability counts the days of an archive of soundings"
    words = (
        "This wind is given, and not derived from the winds of a site: whether it is the one to"
        f" survive is for the reader to say{days}."
    )
    yield Assumption(_ASSUMED, (words,))


def _sign(findings: Findings) -> Iterator[Assumption]:
    """Yield the assumption on the wind direction and dynamic pressure in findings.

    A `FROZEN` direction stands for the nominal dynamic pressure, for which the ratio of the
    required deflection to that at nominal pressure is one.
    """
    s = findings.study
    if s.direction != FROZEN:
        words = f"A {s.direction} wind changes the dynamic pressure. That is counted: it requires "
        ratio = number("assumptions.pressure_ratio", s.ratio_to_nominal, 3)
        yield Assumption("ok", (words, *ratio, " times as much as the nominal dynamic pressure."))
    else:
        words = "The dynamic pressure is the nominal one: a head or cross wind raises it."
        yield Assumption("doubt", (words,))


def _linear(findings: Findings) -> Iterator[Assumption]:
    """Yield the assumption of linear aerodynamics, with the largest angle of attack in findings.

    That [rad] is the peak of the wind, of its vector where both planes are judged, or the peak of
    the autopilot times `plane_ratio`, the ratio of both planes to this one. It is doubtful
    beyond `MAX_CERTAIN_ANGLE`; so is a larger wind that the limit survives.
    """
    s, c = findings.study, findings.comparison
    vector = s.slanting if s.judges_both_planes else None  # wind with a heading to the path
    angle = abs(float(s.history.peak if vector is None else vector.peak))
    if c is not None and np.isfinite(c.peak_angle_of_attack):
        angle = max(angle, c.peak_angle_of_attack * s.plane_ratio)
    reached = degrees("assumptions.angle_of_attack", angle, 1, "deg")
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
    yield Assumption(state, (*line, "."))


def _slow(findings: Findings) -> Iterator[Assumption]:
    """Yield the assumption on whether the findings may neglect the slow mode of the flight path.

    They may up to the duration of `single_pole_validity` [s], NaN where the vehicle has no two real
    unstable poles.
    """
    s = findings.study
    if not isinstance(s.vehicle, Vehicle):
        words = (
            "The flight path is held fixed: the vehicle's coefficients do not tell how it drifts"
            " with the wind."
        )
        yield Assumption(_ASSUMED, (words,))
        return
    edge = float(single_pole_validity(s.coefficients))
    if np.isnan(edge):
        words = (
            "Up to which duration the slow motion of the flight path may be neglected is not"
            " defined: the vehicle has no two real unstable poles."
        )
        yield Assumption(_ASSUMED, (words,))
        return
    tau = significant("validity.duration", float(s.wind.duration), unit="s")
    upto = significant("validity.edge", edge, 3, unit="s")
    if s.wind.duration > edge:
        begin = "The slow motion of the flight path counts: the wind lasts "
        end = " up to which it may be neglected; more may be required than the boundary says."
        yield Assumption("doubt", (begin, *tau, ", longer than the ", *upto, end))
        return
    begin = "The slow motion of the flight path may be neglected: the wind lasts "
    yield Assumption("ok", (begin, *tau, ", not longer than ", *upto, "."))


def _frozen(findings: Findings) -> Iterator[Assumption]:
    """Yield the assumption of constant parameters during the wind, with their effect.

    `findings`: results of a study plan; the effect is that along its flight, if it has one: the
    relative change during the wind of beta (rate of the attitude) or B (trim deflection per angle
    of attack), and the requirements with it and without, at the flight time and in the wind of the
    largest total. Nothing is yielded where that is not known.
    """
    still = "Mass, thrust, air and speed stay as they are while the wind blows"
    if findings.flight is None:
        complete = isinstance(findings.study.vehicle, Vehicle)
        more = "; a flight ([schedule]) would say how much they change" * complete
        yield Assumption(_ASSUMED, (f"{still}{more}.",))
        return
    s, total = findings.flight  # sizing, and its worst total
    if total.time is None:
        return
    i = int(np.argmin(np.abs(s.times - total.time)))  # index of its flight time
    requirement = Requirement(dead_band=s.dead_bands[0])  # with frozen parameters
    counted = requirement in s.freezing_error  # whether it is computed with varying ones too
    deflections = s.required[replace(requirement, varying=counted)][i]
    if np.all(np.isnan(deflections)):
        return
    j = int(np.nanargmax(deflections))  # index of the wind
    changes = float(s.change[i, j])
    percent = number("assumptions.change_percent", 100.0 * changes, 1, "%")
    change_text: Line = (" at the worst flight time beta or B changes by up to ", *percent)
    state = "doubt" if changes > STEADY else "ok"
    if not counted:
        yield Assumption(state, (f"{still};", *change_text, ", which is not counted."))
        return
    varying, frozen = float(deflections[j]), float(s.required[requirement][i, j])
    needs = degrees("assumptions.varying", varying, unit="deg")
    would = degrees("assumptions.frozen", frozen, unit="deg")
    still += ". The whole flight counts their change:"
    line: Line = (still, *change_text, "; the wind requires ", *needs)
    yield Assumption(state, (*line, " with it, and ", *would, " without."))


def _rigid(findings: Findings) -> Iterator[Assumption]:
    """Yield the assumption of a rigid vehicle, in findings of a study without a structure."""
    if findings.plan.vehicle.structure is None:
        words = "Nothing bends or sloshes: the vehicle file has no bending and no slosh."
        yield Assumption(_ASSUMED, (words,))


def _modes(findings: Findings) -> Iterator[Assumption]:
    """Yield the assumption on the frequencies of modes, where the findings have a stable loop.

    It is doubtful where the loop becomes unstable with a mode up to the fraction `NEAR` off.
    """
    f = findings.flexible
    if f is None or f.detuned is None or not f.bands.margins.stable:
        return
    from tvclin.control.autopilot.detuning import NEAR  # late: a rigid study has no modes

    unstable: Line = ()
    for j, mode in enumerate(f.detuned.stable_ranges):
        line = mode.line(f"assumptions.edge.{j}", NEAR)  # empty for a loop that stays stable
        unstable += (", and " if unstable else "", *line) if line else ()
    words = "The frequencies of modes are those of the vehicle file"
    if unstable:
        yield Assumption("doubt", (f"{words}, but ", *unstable, "."))
    else:
        stays = f"the loop stays stable with each up to {100 * NEAR:g} percent off."
        yield Assumption("ok", (f"{words}; {stays}",))


def detuning_notes(findings: Findings) -> Iterator[str]:
    """Yield the note on modes in findings that make a stable loop unstable near their frequency."""
    detuned = findings.flexible and findings.flexible.detuned
    if not detuned:
        return
    from tvclin.control.autopilot.detuning import detuning_note  # late: a rigid study has no modes

    if note := detuning_note(detuned.stable_ranges):
        yield f"{note}; tvclin margins --detuned shows the margins"


def _nozzle(findings: Findings) -> Iterator[Assumption]:
    """Yield the assumption on the rate limit, with the rate that the autopilot requires.

    It is the reader's to judge without a rate limit, and doubtful if the limit is below the rate of
    the autopilot, or below the required rate of the theory. `findings`: results of a study plan;
    its comparison has the autopilot in the wind, without limits.
    """
    rate_limit = findings.plan.nozzle.rate_limit
    rate_text: Line = ()
    c = findings.comparison
    # rate [rad/s] of the autopilot, in both planes where both are judged
    flown = 0.0 if c is None else c.peak_deflection_rate * findings.study.plane_ratio
    if c is not None and np.isfinite(flown):
        rate = degrees("assumptions.rate", flown, unit="deg/s")
        turns = " This autopilot turns the nozzle by up to "
        rate_text = (turns, *rate, " in this wind, without a stop.")
    if rate_limit is None:
        words = "The rate of the nozzle has no limit (rate_limit_deg_per_s in [nozzle])."
        yield Assumption(_ASSUMED, (words, *rate_text))
    else:
        limit_text = significant("assumptions.rate_limit", np.degrees(rate_limit), unit="deg/s")
        words = "The boundary does not count the rate limit of the nozzle, "
        counts = ". The questions of the rate and of flights do."
        theory = 0.0 if findings.rates is None else findings.rates.required_rate
        state = "doubt" if flown > rate_limit or theory > rate_limit else "ok"
        yield Assumption(state, (words, *limit_text, counts, *rate_text))


def nominal_notes(findings: Findings) -> Iterator[str]:
    """Yield a note on answers "yes" at nominal pressure, which a head wind's pressure may refute.

    These are of autopilot and flexible flight, where a head wind sets the required deflection.
    Nothing if the autopilot was flown in that head wind too (`findings.head.stop`).
    """
    if findings.head is not None and findings.head.stop is not None:
        return
    names = "autopilot", "flexible flight"
    nominal = [q.name for q in questions(findings) if q.yes and q.name in names]
    if nominal and findings.study.ratio_to_nominal > 1.0:
        for words in nominal_pressure(findings.plan):
            yield f"{listed(nominal)}: {words}"


def loop_notes(findings: Findings) -> Iterator[str]:
    """Yield notes on properties of autopilot and nozzle that the plan leaves open.

    `findings`: results of the plan. There are none without margins, nozzle duty and turbulence,
    which alone depend on these properties.
    """
    margins, plan, air = findings.margins, findings.plan, findings.turbulence
    if margins is None and findings.duty is None and air is None:
        return
    from tvclin.case.flexible_autopilot import actuator_notes, gain_notes  # late: designs

    # with turbulence alone and the default gains: the part of turbulence in the deflection, and
    # then notes on the margins of these gains
    if air is not None and margins is None and plan.autopilot_design.unspecified:
        yield (
            f"{air.label} of turbulence are {np.degrees(air.sigmas * air.deflection_rms):.3f} deg"
            f" of the {np.degrees(air.deflection):.3f} deg that the autopilot requires {NOMINAL}"
        )
        if plan.controller is None and plan.vehicle.structure is None:
            margins = plan.autopilot.margins(plan.plant)
    if margins is not None:
        satisfied = bool(findings.criteria.are_satisfied(margins))
        # of the whole loop, without those of each mode
        loop_margins = margins.margins if isinstance(margins, BandMargins) else margins
        yield from gain_notes(plan, findings.criteria, satisfied, loop_margins.delay_margin)
    else:
        yield from actuator_notes(plan)
