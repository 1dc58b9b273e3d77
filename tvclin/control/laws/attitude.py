"""Attitude and rate feedback under a deflection limit."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, instance, single
from tvclin.base.fields import spec
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.system_autopilot import SystemAutopilot
from tvclin.control.laws.law import Chains, Law, LinearLaw
from tvclin.control.laws.system_law import SystemLaw
from tvclin.kernels.control_laws import LawNumbers
from tvclin.linear.lateral import LateralSensors


def gain_numbers(autopilot: Autopilot) -> dict[str, Any]:
    """Return the gains of an autopilot by their names in `LawNumbers`."""
    return {
        "attitude": autopilot.attitude_gain,
        "attitude_rate": autopilot.rate_gain,
        "angle_of_attack": autopilot.alpha_gain,
        "first_state": autopilot.integral_gain,
        "drift_rate": autopilot.drift_rate_gain,
        "drift": autopilot.drift_gain,
        "acceleration": autopilot.acceleration_gain,
    }


@dataclass(frozen=True)
class SaturatedLaw(LinearLaw):
    """Autopilot feedback under a deflection limit, the sum of its gains times the measurements.

    Parameters
    ----------
    autopilot : Autopilot
        One autopilot with gains and filters; actuator, delay and sample rate belong to the flight.

    Raises
    ------
    InputError
        For a batch, and for an autopilot with an actuator, a delay or a sample rate.
    """

    autopilot: Autopilot = field(metadata=spec())

    def __post_init__(self) -> None:
        instance("autopilot", self.autopilot, Autopilot, "see design_gains")
        single("autopilot", self.autopilot.batch)
        a = self.autopilot
        if a.controller is not None:
            raise InputError("a SaturatedLaw is of gains; SystemLaw is that of a state space")
        if a.actuator is not None or a.delay or a.sample_rate is not None:
            raise InputError(
                "a SaturatedLaw takes gains and filters only: give actuator, delay and sample_rate"
                " to fly()"
            )

    @classmethod
    def of(cls, autopilot: Autopilot) -> Law:
        """Return the law of an autopilot, without actuator, delay and sample rate.

        That of a `SystemAutopilot` is a `SystemLaw`.
        """
        instance("autopilot", autopilot, Autopilot, "see design_gains")
        if isinstance(autopilot, SystemAutopilot):
            return SystemLaw(autopilot)
        return cls(replace(autopilot, actuator=None, delay=0.0, sample_rate=None))

    @property
    def states(self) -> tuple[FloatArray, FloatArray]:
        """F and G of the integral of the attitude; no states without integral gain."""
        if not self.autopilot.integral_gain:
            return super().states
        return np.zeros((1, 1)), np.eye(1, 5)

    @property
    def chains(self) -> Chains:
        """Filter chains of the autopilot."""
        a = self.autopilot
        return Chains(a.attitude_filters, a.rate_filters, a.filters)

    @property
    def lateral_sensors(self) -> LateralSensors:
        """Sensors of lateral motion of the autopilot."""
        return self.autopilot.lateral_sensors

    @cached_property
    def numbers(self) -> LawNumbers:
        """Gains a0, a1, b0, aI, d1, d0 and g of the autopilot."""
        gains: Any = {k: float(v) for k, v in gain_numbers(self.autopilot).items()}
        return LawNumbers(**gains)
