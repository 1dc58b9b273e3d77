"""Options that describe an autopilot, and the autopilot that they specify."""

from dataclasses import dataclass, replace
from typing import Any

from tvclin.base.errors import InputError
from tvclin.cli.inputs import keys_set
from tvclin.cli.options import DESIGN, TIMING, Options
from tvclin.control.autopilot.design_rules import (
    GIVEN_GAINS,
    POLE_PLACEMENT_RULES,
    RULE_KEYS,
    AutopilotDesign,
)
from tvclin.studyfile.study_plan import StudyPlan


@dataclass(frozen=True)
class GainOptions(Options):
    """Options of the gains, or of a rule for them."""

    def over(self, plan: StudyPlan) -> StudyPlan:
        """Return a plan with these gains, or with this rule for them."""
        values = self.values
        return replace(plan, design=with_gains(plan.autopilot_design, **values)) if values else plan


GAINS = GainOptions(
    DESIGN,
    ("design", "natural_frequency", "damping", "attitude_gain", "rate_gain"),
)


@dataclass(frozen=True)
class FlownLaw:
    """Options of a flown law: its samples and delay, and the gains of the law autopilot."""

    timing: Options = TIMING
    gains: Options = GAINS

    def over(self, plan: StudyPlan) -> StudyPlan:
        """Return a plan with the values of all these options."""
        return self.gains.over(self.timing.over(plan))

    def only_with(self, needed: str) -> None:
        """Raise `InputError` if any of these options is given without what it requires."""
        self.gains.only_with(needed)
        self.timing.only_with(needed)

    def only_with_autopilot(self, source: str) -> None:
        """Raise `InputError` for gains, by options or keys of --set, of a law that has none."""
        from tvclin.control.laws.registry import AUTOPILOT  # late: of all laws

        needed = f"--law {AUTOPILOT}"
        self.gains.only_with(needed)
        for key in self._gain_keys(source):
            raise InputError(f"--set {key} needs {needed}")

    def has_gains(self, source: str) -> bool:
        """Return whether gains are given by options or by keys of --set."""
        return bool(self.gains.values or self._gain_keys(source))

    def _gain_keys(self, source: str) -> list[str]:
        """Return the keys of --set that give gains, or a rule for them."""
        if not (keys := keys_set(source)):
            return []
        from tvclin.studyfile.settings import quantity_name  # late: it knows the keys of all files

        gains = {f"autopilot.{name}" for name in (*GIVEN_GAINS, *RULE_KEYS, "integral_gain")}
        return [key for key in keys if quantity_name(key) in gains]


def with_gains(base: AutopilotDesign, **values: float | str | None) -> AutopilotDesign:
    """Return a design with the gains or the rule of options.

    Gains remove a rule and a rule removes gains; a named rule also removes parameters of another.
    """
    out: tuple[str, ...] = ()
    if values.keys() & {*GIVEN_GAINS, *RULE_KEYS} and base.schedule is not None:
        base = replace(base, schedule=replace(base.schedule, gains={}))
    if values.keys() & set(GIVEN_GAINS):
        out = RULE_KEYS
    elif values.keys() & set(RULE_KEYS):
        rule_changes = "design" in values or base.design not in (None, *POLE_PLACEMENT_RULES)
        out = (*GIVEN_GAINS, *(RULE_KEYS if rule_changes else ()))
    changed: Any = dict.fromkeys(out) | values
    return replace(base, **changed)
