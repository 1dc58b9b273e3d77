"""Laws of an autopilot under a deflection limit: of its gains, or of a system in state space."""

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
from tvclin.control.autopilot.wiring import controller_system
from tvclin.control.laws.law import Chains, Law, LinearLaw, Measurement
from tvclin.kernels.control_laws import LawNumbers
from tvclin.linear.lateral import SENSOR_OF, LateralSensors
from tvclin.linear.system import LinearSystem

_MEASURED = (*Measurement._fields[:5], *SENSOR_OF)
"""Inputs of a controller in state space, in the order of `Measurement`."""


class _AutopilotLaw(Law):
    """Law with the filters and the sensors of its autopilot."""

    autopilot: Any

    @property
    def chains(self) -> Chains:
        """Filter chains of the autopilot."""
        a = self.autopilot
        return Chains(a.attitude_filters, attitude_rate=a.rate_filters, demand=a.filters)

    @property
    def lateral_sensors(self) -> LateralSensors:
        """Sensors of lateral motion of the autopilot."""
        return self.autopilot.lateral_sensors


@dataclass(frozen=True)
class SystemLaw(_AutopilotLaw):
    """Law of a `SystemAutopilot`, to be flown with limits.

    Parameters
    ----------
    autopilot : SystemAutopilot
        Its actuator, delay and sample rate belong to the flight, and are not looked at; the flight
        of difference equations has their sample rate.

    Raises
    ------
    InputError
        For an autopilot of another type, and a controller with an input that a flight does not
        measure.

    Examples
    --------
    >>> import control, tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=0.228, mu_delta=1.317))
    >>> gains = control.StateSpace([], [], [], [[1.88, 1.59]], inputs=["attitude", "attitude_rate"],
    ...                            outputs=["deflection_command"])
    >>> law = tv.control.SystemLaw(tv.control.SystemAutopilot(gains))
    >>> wind = tv.TriangularWind(peak=0.05, duration=8.0)
    >>> tv.fly_many(plant, law, wind, deflection_limit=0.01, sample_rate=50.0).status.item()
    'survived'
    """

    autopilot: SystemAutopilot = field(metadata=spec())

    def __post_init__(self) -> None:
        """Check that a flight measures every input of the controller."""
        instance("autopilot", self.autopilot, SystemAutopilot, "of a control.StateSpace")
        for name in self.autopilot.system.inputs:
            if name not in _MEASURED:
                raise InputError(
                    f"a flight does not measure {name}, which the controller reads; it measures"
                    f" {', '.join(_MEASURED)}"
                )

    @property
    def state_space(self) -> LinearSystem:
        """State space of the controller, from the measurements to its output."""
        return controller_system(self.autopilot.system)

    @property
    def states(self) -> tuple[FloatArray, FloatArray]:
        """F ``(k, k)`` and G ``(k, 8)`` of s' = F s + G m of a continuous controller.

        s are its k states and m the eight measurements of a flight. `InputError` for a controller
        with a sample time.
        """
        system = self.autopilot.system
        if system.period is not None:
            raise InputError(
                f"the controller has a sample time of {float(system.period):.6g} s; give"
                f" sample_rate = {1.0 / float(system.period):.6g} Hz"
            )
        # ones that select the inputs of the controller among the measurements, (inputs, 8)
        rows = [[float(name == measured) for measured in _MEASURED] for name in system.inputs]
        return system.A, system.B @ np.reshape(rows, (len(rows), len(_MEASURED)))

    @property
    def numbers(self) -> LawNumbers:
        """Gains of the law on the measurements: one on the attitude, zero on the others.

        A flight by samples puts the controller's output, a deflection [rad], in the place of the
        attitude, so that the gain of one passes it on.
        """
        return LawNumbers(attitude=1.0)

    def demand(self, measured: Measurement, states: FloatArray, limit: Any) -> Any:
        """Return the deflection C s + D m [rad] of a continuous controller, before the limit.

        `measured`: measurements, of which m are the inputs of the controller. `states`: its states
        s, ``(k, ...)``. `limit`: is not used.
        """
        system = self.autopilot.system
        inputs = [measured[_MEASURED.index(name)] for name in system.inputs]
        (C,), (D,) = system.C, system.D  # rows of the only output
        terms = [*zip(C, states, strict=True), *zip(D, inputs, strict=True)]
        # Starts from a zero of the shape of the flights.
        return sum((gain * value for gain, value in terms if gain), 0.0 * measured.attitude)


def gain_numbers(autopilot: Autopilot) -> dict[str, Any]:
    """Return the gains of an autopilot by name: the measurement or state that each multiplies.

    `LawNumbers` has the same names.
    """
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
class SaturatedLaw(_AutopilotLaw, LinearLaw):
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
        """Check that the autopilot is one of gains, without actuator, delay and samples."""
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

        A `SystemAutopilot` becomes a `SystemLaw`.
        """
        instance("autopilot", autopilot, Autopilot, "see design_gains")
        if isinstance(autopilot, SystemAutopilot):
            return SystemLaw(autopilot)
        return cls(replace(autopilot, actuator=None, delay=0.0, sample_rate=None))

    @property
    def states(self) -> tuple[FloatArray, FloatArray]:
        """F ``(1, 1)`` and G ``(1, 5)`` of s' = F s + G m, s the integral of the attitude [rad s].

        m are five measurements, first the attitude. Without integral gain there are no states.
        """
        if not self.autopilot.integral_gain:
            return super().states
        return np.zeros((1, 1)), np.eye(1, 5)

    @cached_property
    def numbers(self) -> LawNumbers:
        """Gains of the autopilot on measurements and on the integral, its first state."""
        gains: Any = {k: float(v) for k, v in gain_numbers(self.autopilot).items()}
        return LawNumbers(**gains)
