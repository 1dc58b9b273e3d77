"""Drift and lateral acceleration that a law measures in a flight of JSBSim, with states of sensors.

The drift is integrated by the trapezoidal rule. The lag of the accelerometer is exact for a force
that is a straight line over each step, as it is extrapolated over the next one.
"""

from __future__ import annotations

from math import exp, sin

from tvclin.control.laws.law import Measurement
from tvclin.linear.lateral import LateralSensors


class LateralMotion:
    """Lateral motion in one plane, from the steps of a flight.

    `sensors`: those of the law. `step`: step [s].
    """

    __slots__ = (
        "_acceleration", "_decay", "_drift", "_drift_rate", "_felt", "_felt_before", "_ramp",
        "_sensors", "_speed", "_step",
    )  # fmt: skip

    def __init__(self, sensors: LateralSensors, step: float) -> None:
        lag = sensors.bandwidth * step
        self._sensors, self._step, self._decay = sensors, step, exp(-lag)
        self._ramp = 1.0 - (1.0 - self._decay) / lag
        self._drift = self._drift_rate = self._speed = 0.0
        self._acceleration = self._felt = self._felt_before = 0.0

    def measured(self, plain: Measurement) -> Measurement:
        """Return the measurements at the end of the next step with those of lateral motion."""
        sensors, rate = self._sensors, self._speed * sin(plain.flight_path_angle)
        extrapolated = 2.0 * self._felt - self._felt_before
        return plain._replace(
            drift_rate=rate if sensors.drift_rate else 0.0,
            drift=self._drifted(rate) if sensors.drift else 0.0,
            acceleration=self._lagged(extrapolated) if sensors.acceleration else 0.0,
        )

    def move(self, path: float, speed: float, force: float, push: float) -> None:
        """Update the state to the end of a step, which begins a flight too.

        `path`: flight path angle relative to the nominal flight [rad]. `speed`: over the ground
        [m/s]. `force`: force per mass normal to the body, without weight, relative to the nominal
        flight [m/s^2]. `push`: acceleration of the attitude, relative to the nominal flight
        [rad/s^2].
        """
        rate, felt = speed * sin(path), force + self._sensors.station * push
        self._drift, self._drift_rate = self._drifted(rate), rate
        self._acceleration = self._lagged(felt)
        self._felt_before, self._felt, self._speed = self._felt, felt, speed

    def _drifted(self, rate: float) -> float:
        """Return the drift [m] at the end of a step with a drift rate [m/s] there."""
        return self._drift + 0.5 * self._step * (self._drift_rate + rate)

    def _lagged(self, felt: float) -> float:
        """Return the lagged acceleration [m/s^2] at the end of a step; `felt`: without the lag."""
        decayed = self._felt + self._decay * (self._acceleration - self._felt)
        return decayed + self._ramp * (felt - self._felt)
