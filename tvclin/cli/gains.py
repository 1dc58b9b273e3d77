"""Options that describe an autopilot, and the autopilot that they specify."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Any

from tvclin.base.errors import InputError, nonnegative, number, positive
from tvclin.case.nozzle import USUAL_ACTUATOR
from tvclin.cli.inputs import only_with
from tvclin.cli.options import DESIGN, GROUP, SAMPLE_RATE, Given, asked
from tvclin.control.autopilot.design_rules import (
    GIVEN_GAINS,
    POLE_PLACEMENT_RULES,
    RULE_KEYS,
    AutopilotDesign,
)
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.filters import Filter


@dataclass(frozen=True)
class LoopOptions:
    """Options of any law's loop: filters, actuator, delay; `grouped` gives them to a command."""

    actuator_frequency: float | None = asked(
        "Natural frequency of the actuator, in rad/s; 0: no actuator.", shown="25.1"
    )
    actuator_hz: float | None = asked("Natural frequency of the actuator, in Hz.")
    actuator_damping: float | None = asked("Damping ratio of the actuator.", shown="0.7")
    delay_ms: float | None = asked("Delay between sensors and actuator, in ms.", shown="0.0")
    notch_hz: list[str] | None = asked(
        "Notch filter of the deflection command: frequency in Hz, damping of its zeros and of its"
        " poles, as in 12,0.05,0.5. May be given several times. Study files also take lead-lag and"
        " rational filters, under autopilot.filter.",
        metavar="F,ZEROS,POLES",
    )
    low_pass_hz: list[str] | None = asked(
        "Low-pass filter of the deflection command: frequency in Hz; with a damping ratio it is of"
        " second order. May be given several times.",
        metavar="F[,DAMPING]",
    )
    panel = "Autopilot"

    def over(self, plan: StudyPlan) -> StudyPlan:
        """Return a plan with the actuator, the delay and the filters of these options."""
        if self.actuator_frequency is not None and self.actuator_hz is not None:
            raise InputError("give --actuator-frequency or --actuator-hz, not both")
        servo, frequency = plan.nozzle.actuator, self.actuator_frequency
        if frequency is not None:
            number("--actuator-frequency", frequency, nonnegative, "rad/s")
        if self.actuator_hz is not None:
            frequency = 2.0 * pi * number("--actuator-hz", self.actuator_hz, nonnegative, "Hz")
        if frequency is not None:
            servo = (
                replace(servo or USUAL_ACTUATOR, natural_frequency=frequency) if frequency else None
            )
        if servo is None:
            only_with("an actuator, --actuator-hz", actuator_damping=self.actuator_damping)
        elif self.actuator_damping is not None:
            damping = number("--actuator-damping", self.actuator_damping, positive)
            servo = replace(servo, damping=damping)
        delay = plan.autopilot_design.delay
        if self.delay_ms is not None:
            delay = number("--delay-ms", self.delay_ms, nonnegative, "ms") / 1000.0
        filters = (
            _filters(self.notch_hz or (), self.low_pass_hz or ()) or plan.autopilot_design.filters
        )
        design = replace(plan.autopilot_design, delay=delay, filters=filters)
        return replace(plan, nozzle=replace(plan.nozzle, actuator=servo), design=design)


@dataclass(frozen=True)
class GainOptions(Given):
    """Options of the gains, or of a rule for them."""

    def over(self, plan: StudyPlan) -> StudyPlan:
        """Return a plan with these gains, or with this rule for them."""
        values = self.values
        return replace(plan, design=with_gains(plan.autopilot_design, **values)) if values else plan


GAINS = GainOptions(
    DESIGN,
    ("design", "natural_frequency", "damping", *GIVEN_GAINS, "integral_gain"),
)


@dataclass(frozen=True)
class FlownLaw:
    """Options of a flown law: its samples, the gains of the law autopilot, and its loop."""

    samples: Given = SAMPLE_RATE
    gains: Given = GAINS
    loop: LoopOptions = GROUP

    def over(self, plan: StudyPlan) -> StudyPlan:
        """Return a plan with the values of all these options."""
        return self.loop.over(self.gains.over(self.samples.over(plan)))

    def only_with(self, needed: str) -> None:
        """Raise `InputError` if any of these options is given without what it requires."""
        self.gains.only_with(needed)
        self.samples.only_with(needed)
        only_with(needed, **vars(self.loop))


def with_gains(base: AutopilotDesign, **given: float | str | None) -> AutopilotDesign:
    """Return a design with the gains or the rule of options.

    Gains remove a rule and a rule removes gains; a named rule also removes parameters of another.
    """
    out: tuple[str, ...] = ()
    if given.keys() & set(GIVEN_GAINS):
        out = RULE_KEYS
    elif given.keys() & set(RULE_KEYS):
        rule_changes = "design" in given or base.design not in (None, *POLE_PLACEMENT_RULES)
        out = (*GIVEN_GAINS, *(RULE_KEYS if rule_changes else ()))
    changed: Any = dict.fromkeys(out) | given
    return replace(base, **changed)


def _filters(notches: Sequence[str], passes: Sequence[str]) -> tuple[Filter, ...]:
    """Return the filters of the options for notches and low passes."""
    made = [Filter.notch(*_numbers("--notch-hz", text, 3, 3)) for text in notches]
    made += [Filter.low_pass(*_numbers("--low-pass-hz", text, 1, 2)) for text in passes]
    return tuple(made)


def _numbers(option: str, text: str, min_count: int, max_count: int) -> list[float]:
    """Return numbers separated by commas, the first a frequency, converted from Hz to rad/s."""
    parts = text.replace(",", " ").split()
    try:
        values = [float(number_text) for number_text in parts]
    except ValueError:
        values = []
    if not min_count <= len(values) <= max_count:
        count = f"{min_count}" if min_count == max_count else f"{min_count} or {max_count}"
        raise InputError(f"{option} must be {count} numbers with commas between; got {text!r}")
    return [2.0 * pi * number(option, values[0], positive, "Hz"), *values[1:]]
