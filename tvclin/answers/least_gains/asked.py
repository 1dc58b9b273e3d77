"""The autopilot that a file or options specify, which may be that for the least nozzle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tvclin.answers.least_gains.least import least_deflection_gains
from tvclin.answers.least_gains.record import LeastGains
from tvclin.base.errors import InputError
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.design_rules import LEAST_NOZZLE
from tvclin.control.margins.criteria import Criteria
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from tvclin.answers.case import Case


def autopilot_asked(case: Case, wind: History, criteria: Criteria) -> Autopilot:
    """Return the autopilot of a case, in a wind and by criteria for the least nozzle."""
    if case.asked.design != LEAST_NOZZLE:
        return case.autopilot
    return least_asked(case, wind, criteria).autopilot


def least_asked(
    case: Case, winds: History | Sequence[History], criteria: Criteria, **options: Any
) -> LeastGains:
    """Return the gains for the least nozzle with the nozzle, delay, samples and filters of a case.

    `InputError` for gains and numbers of other rules in the same design, and as
    `least_deflection_gains`.
    """
    design = case.asked
    chains: dict[str, Any] = design.chains
    conflicting = [
        name
        for name in (
            *("natural_frequency", "damping", "attitude_gain", "rate_gain", "alpha_gain"),
            "integral_gain",
        )
        if getattr(design, name) not in (None, 0.0)
    ]
    if conflicting:
        raise InputError(
            "gains for the least nozzle are sought: give no"
            f" {', '.join(name.replace('_', ' ') for name in conflicting)} with them"
        )
    return least_deflection_gains(
        case.plant,
        winds,
        criteria=criteria,
        actuator=case.nozzle.actuator,
        delay=design.delay,
        crossover=design.crossover,
        sample_rate=design.sample_rate,
        **chains,
        **options,
    )
