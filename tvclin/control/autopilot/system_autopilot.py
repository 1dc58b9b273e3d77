"""Autopilot whose law is a state space or transfer function with named signals.

It is continuous, or the difference equations of a flight computer with their sample time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import InitVar, dataclass, field, replace
from typing import Any, Self

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.base.fields import spec
from tvclin.base.lines import Row, significant
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import GAINS
from tvclin.linear.lateral import LateralSensors
from tvclin.linear.named_systems import check_hidden_modes, eigenvectors, named_system
from tvclin.linear.system import LinearSystem
from tvclin.numerics import state_space

_RELATIVE_RATE = 1e-9
"""Relative distance of two sample rates that count as equal."""
_MIN_DISTANCE_FROM_MINUS_ONE = 1e-12
"""Smallest distance of a pole z from -1, which no continuous pole has."""


@dataclass(frozen=True, kw_only=True)
class SystemAutopilot(Autopilot):
    """Autopilot from a state space or a transfer function, with delay and actuator around it.

    Margins, closed-loop poles, bands, responses, flown margins, flights and the comparison with
    trim take it like an `Autopilot`.

    Parameters
    ----------
    system : control.StateSpace or control.TransferFunction
        From outputs of the plant, by their names, to the deflection command [rad]. Its inputs
        attitude and attitude_rate are what the sensors show, the attitude minus its command;
        drift_rate [m/s], drift [m] and lateral_acceleration [m/s^2] are those of lateral sensors,
        the acceleration behind the lag of its accelerometer; deflection is the actuator's. A
        positive output pitches the nose down, as with positive gains of an `Autopilot`. With a
        sample time it is the difference equations of a flight computer.
    inputs : sequence of str, optional
        Names of the inputs, in place of the system's.
    actuator, delay, pade_order, acceleration_station, accelerometer_bandwidth
        Same parameters as `Autopilot`.
    filters, attitude_filters, rate_filters : tuple of Filter
        Filters behind the controller, and of its inputs attitude and attitude_rate.
    sample_rate : float, optional
        Samples per second [Hz] of a continuous system, with a zero-order hold of its inputs. That
        of a system with a sample time is one over it.

    Raises
    ------
    InputError
        For several outputs, gains, another sample rate than that of the system, an improper
        transfer function, sizes that do not fit, and the errors of `Autopilot`.

    Examples
    --------
    >>> import control, tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=0.228, mu_delta=1.317))
    >>> gains = control.StateSpace([], [], [], [[1.88, 1.59]], inputs=["attitude", "attitude_rate"],
    ...                            outputs=["deflection_command"])
    >>> m = tv.control.SystemAutopilot(gains).margins(plant)
    >>> round(m.crossover_frequency, 3), round(m.phase_margin_deg, 1)
    (2.262, 62.4)
    """

    system: Any = field(kw_only=False)
    inputs: InitVar[Sequence[str] | None] = None
    attitude_gain: float | FloatArray = field(default=0.0, metadata=spec(card=False))
    rate_gain: float | FloatArray = field(default=0.0, metadata=spec("time", card=False))

    def __post_init__(self, inputs: Sequence[str] | None) -> None:
        """Check the system and set `system` to its state space with the named `inputs`.

        `InputError` also for a mode that no input reaches or the output does not show.
        """
        super().__post_init__()
        system = named_system("controller", self.system, inputs)
        if len(system.outputs) != 1:
            raise InputError(
                "controller must have one output, the deflection command; its outputs are"
                f" {', '.join(system.outputs)}"
            )
        if system.batch:
            raise InputError(f"controller must be one system; got a batch of shape {system.batch}")
        gain_names = [name for name in GAINS if np.any(np.asarray(getattr(self, name)))]
        if gain_names:
            raise InputError(f"{gain_names[0]} is of an Autopilot; the controller has its own")
        object.__setattr__(self, "system", system)
        faults = ("no input reaches", "its output does not show")
        modes = eigenvectors(system.A)
        check_hidden_modes("controller", modes, system.B, system.C, faults, system.period)
        if system.period is not None:
            rate = 1.0 / float(system.period)
            if self.sample_rate is None:
                object.__setattr__(self, "sample_rate", rate)
            elif np.any(np.abs(np.asarray(self.sample_rate) / rate - 1.0) > _RELATIVE_RATE):
                raise InputError(
                    f"sample_rate must be that of the controller, {rate:.6g} Hz; got"
                    f" {np.ravel(self.sample_rate)[0]:.6g} Hz"
                )

    @property
    def controller(self) -> LinearSystem:
        """State space from outputs of plant and sensors to the deflection command."""
        return self.system

    @property
    def lateral_sensors(self) -> LateralSensors:
        """Sensors of the lateral motion that the controller reads."""
        inputs = self.system.inputs
        return LateralSensors(
            drift_rate="drift_rate" in inputs,
            drift="drift" in inputs,
            acceleration="lateral_acceleration" in inputs,
            station=self.acceleration_station,
            bandwidth=self.accelerometer_bandwidth,
        )

    @property
    def continuous(self) -> Self:
        """Continuous autopilot; of difference equations by the bilinear rule.

        `InputError` for a pole at z = -1, which that rule takes to infinity.
        """
        system = self.system
        if system.period is None:
            return replace(self, sample_rate=None)
        poles = np.linalg.eigvals(system.A)
        if np.any(np.abs(poles + 1.0) < _MIN_DISTANCE_FROM_MINUS_ONE):
            raise InputError("the controller has a pole at z = -1, which no continuous system has")
        matrices = state_space.from_steps(system.matrices(), 0.5 * system.period)
        continuous = LinearSystem(*matrices, system.inputs, system.outputs, system.states)
        return replace(self, system=continuous, sample_rate=None)

    @property
    def description(self) -> str:
        """Order of the controller, actuator, delay and samples, in one line."""
        terms = [f"controller of order {len(self.system.states)}"]
        if self.actuator is not None:
            terms.append(f"actuator {self.actuator.natural_frequency:.4g} rad/s")
        if self.delay:
            terms.append(f"delay {self.delay:.4g} s")
        if self.sample_rate is not None:
            terms.append(f"sampled at {self.sample_rate:.4g} Hz")
        return ", ".join(terms)

    def rows(self) -> list[Row]:
        """Return order and inputs of the controller, actuator, delay and samples, as rows."""
        order = significant("controller.order", len(self.system.states), 4)
        rows = super().rows()
        # The rows ahead of that of the actuator are of gains, which a controller does not have.
        first = next(k for k, (label, _) in enumerate(rows) if label == "actuator")
        inputs = ("controller inputs", (", ".join(self.system.inputs),))
        return [("controller order", order), inputs, *rows[first:]]
