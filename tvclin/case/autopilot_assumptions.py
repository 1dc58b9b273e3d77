"""Notes on unspecified gains and actuators, and on a rule whose gains satisfy the criteria."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from tvclin.base.errors import InputError
from tvclin.case.case import Case
from tvclin.case.nozzle import USUAL_ACTUATOR
from tvclin.control.autopilot.design_rules import GIVEN_GAINS, RULE_KEYS, AutopilotDesign
from tvclin.control.margins.criteria import Criteria
from tvclin.linear.flexible import FlexiblePlant

_FREQUENCY_RATIOS = (1.5, 2.0, 3.0, 4.0, 6.0)
"""Natural frequencies that are tried, normalised by the unstable pole."""


def gain_notes(case: Case, criteria: Criteria, satisfied: bool) -> Iterator[str]:
    """Yield notes on unspecified gains or actuator, and on gains that satisfy the criteria.

    `satisfied`: whether the gains of the case satisfy the criteria.
    """
    if case.autopilot_design.unspecified and case.controller is None:
        yield (
            "these are textbook gains, a0 = 2 B and a1 = B/beta, since no option and no file"
            " specifies others"
        )
    if not satisfied:
        yield _better(case, criteria)
    yield from actuator_notes(case)


def actuator_notes(case: Case) -> Iterator[str]:
    """Yield the note on an actuator that is assumed, as neither file nor option specifies one."""
    if case.nozzle.actuator is USUAL_ACTUATOR:
        yield (
            f"an actuator of {USUAL_ACTUATOR.natural_frequency:g} rad/s and damping"
            f" {USUAL_ACTUATOR.damping:g} is assumed"
            " (actuator_frequency_rad_per_s in [nozzle] gives another; 0: none)"
        )


def _better(case: Case, criteria: Criteria) -> str:
    """Return the note on a rule with gains that satisfy the criteria, or on the search for them."""
    rule = satisfying_rule(case, criteria)
    if rule is None:
        return (
            f"gains that satisfy the criteria {criteria.name}: neither poles at 1.5 to 6 times the"
            " unstable one nor lqr; tvclin design --least seeks them, and a bending mode may"
            " need a notch ([[autopilot.filter]])"
        )
    if rule.design is not None:
        words = f'--design {rule.design}, or design = "{rule.design}" in [autopilot]'
    else:
        frequency = f"{rule.natural_frequency:g}"
        words = (
            f"--design poles --natural-frequency {frequency}, or in [autopilot] design ="
            f' "poles" and natural_frequency_rad_per_s = {frequency}'
        )
    return f"gains that satisfy the criteria {criteria.name}: {words}, in place of other gains"


def satisfying_rule(case: Case, criteria: Criteria) -> AutopilotDesign | None:
    """Return the first design whose gains satisfy the criteria; None if none does.

    The designs are poles at multiples of the unstable pole, and the linear quadratic regulator,
    with the actuator, delay, filters and sample rate of the case.
    """
    others: Any = dict.fromkeys((*RULE_KEYS, *GIVEN_GAINS))
    base = replace(case.autopilot_design, **others)
    rules = []
    with suppress(InputError):  # a stable vehicle has no such pole
        pole = float(case.plant.rigid.coefficients.pole)
        rules = [
            replace(base, natural_frequency=float(f"{ratio * pole:.2g}"))
            for ratio in _FREQUENCY_RATIOS
        ]
    rules.append(replace(base, design="lqr"))  # last, for it loads python-control
    return next(
        (
            rule
            for rule in rules
            if _satisfies(replace(case, design=rule, controller=None), criteria)
        ),
        None,
    )


def _satisfies(case: Case, criteria: Criteria) -> bool:
    """Return whether the loop of a case is stable and satisfies the criteria."""
    plant = case.plant
    with suppress(InputError, np.linalg.LinAlgError, ArithmeticError):
        margins = case.autopilot.margins(plant)
        if not isinstance(plant, FlexiblePlant):
            return bool(criteria.are_satisfied(margins))
        return bool(margins.stable) and bool(
            criteria.are_satisfied(case.autopilot.band_margins(plant))
        )
    return False
