"""An autopilot that is asked for in a file or by options, also one for the least nozzle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tvclin.answers.least_gains.least import least_deflection_gains
from tvclin.answers.least_gains.record import LeastGains
from tvclin.base.errors import InputError
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.rules import LEAST_NOZZLE, GainsAsked
from tvclin.control.margins.criteria import Criteria
from tvclin.linear.flexible import AnyPlant
from tvclin.winds.histories import History


def autopilot_asked(
    asked: GainsAsked, plant: AnyPlant, wind: History, criteria: Criteria
) -> Autopilot:
    """Return the autopilot that is asked for; of a wind and criteria where its rule needs them.

    Raises
    ------
    InputError
        As `GainsAsked.autopilot` and `least_asked`.
    """
    if asked.design != LEAST_NOZZLE:
        return asked.autopilot(plant.rigid)
    return least_asked(asked, plant, wind, criteria).autopilot


def least_asked(
    asked: GainsAsked,
    plant: AnyPlant,
    winds: History | Sequence[History],
    criteria: Criteria,
    **options: Any,
) -> LeastGains:
    """Return the gains for the least nozzle with the nozzle, delay and filters that are asked for.

    Raises
    ------
    InputError
        For gains and numbers of other rules beside it, and as `least_deflection_gains`.
    """
    numbers = ("natural_frequency", "damping", "attitude_gain", "rate_gain", "alpha_gain")
    given = [name for name in numbers if getattr(asked, name) is not None]
    given += [
        name
        for name in ("integral_gain", "attitude_filters", "rate_filters")
        if getattr(asked, name)
    ]
    if given:
        raise InputError(
            "gains for the least nozzle are sought: give no"
            f" {', '.join(name.replace('_', ' ') for name in given)} with them"
        )
    return least_deflection_gains(
        plant,
        winds,
        criteria=criteria,
        actuator=asked.actuator,
        delay=asked.delay,
        crossover=asked.crossover,
        filters=asked.filters,
        **options,
    )
