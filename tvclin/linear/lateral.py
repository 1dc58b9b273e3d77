"""Sensors of lateral drift and acceleration: the plant with their outputs.

An inertial unit measures the velocity normal to the nominal path, the drift rate V gamma, and its
integral, the drift z, a state with a pole at zero. A body-mounted accelerometer measures the force
normal to the body, without gravity, through a first-order lag.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import compress
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, flag
from tvclin.linear.flexible import AnyPlant, check_plant
from tvclin.linear.system import LinearSystem, connect
from tvclin.linear.system_plant import SystemPlant

DRIFT_RATE, DRIFT, ACCELERATION = "sensed_drift_rate", "sensed_drift", "sensed_acceleration"
"""Names of the outputs [m/s], [m] and [m/s^2]."""
SENSOR_OF = {"drift_rate": DRIFT_RATE, "drift": DRIFT, "lateral_acceleration": ACCELERATION}
"""Output of the sensor by the name of the lateral signal."""
_FORCE = "acceleration ahead of the lag"
"""Name of the acceleration before the lag."""


@dataclass(frozen=True)
class LateralSensors:
    """Sensors of an autopilot that measure lateral motion.

    `drift_rate`, `drift`, `acceleration`: whether these are measured. `station`: position of the
    accelerometer ahead of the centre of gravity [m]. `bandwidth`: of its first-order lag [rad/s].
    """

    drift_rate: bool = False
    drift: bool = False
    acceleration: bool = False
    station: float = 0.0
    bandwidth: float = 100.0

    @cached_property
    def signals(self) -> tuple[str, ...]:
        """Names of the outputs of the sensors."""
        measured = (self.drift_rate, self.drift, self.acceleration)
        return tuple(compress((DRIFT_RATE, DRIFT, ACCELERATION), measured))

    @cached_property
    def states(self) -> tuple[str, ...]:
        """Names of the states of the sensors: the drift, and the lag of the accelerometer.

        The drift rate needs no state, and around a plant with an output drift only the lag is one.
        """
        return tuple(name.removeprefix("sensed_") for name in self.signals if name != DRIFT_RATE)

    def measurements(self, values: FloatArray) -> dict[str, Any]:
        """Return the measured values by their names drift_rate, drift and acceleration.

        `values`: outputs of the sensors [m/s, m, m/s^2], ``(signals, ...)``, in the order of the
        property `signals`, which has only what is measured.
        """
        names = (name.removeprefix("sensed_") for name in self.signals)
        return dict(zip(names, values, strict=True))

    def joined(self, other: LateralSensors) -> LateralSensors:
        """Return sensors that measure what these or the `other` ones do.

        `InputError` for accelerometers at two stations, or with two bandwidths.
        """
        accelerometers = {
            (sensors.station, sensors.bandwidth)
            for sensors in (self, other)
            if sensors.acceleration
        }
        if len(accelerometers) > 1:
            raise InputError(
                "laws that are flown together must have their accelerometer at one station, with"
                " one bandwidth; fly them one after the other"
            )
        default = self.station, self.bandwidth  # without effect, without an accelerometer
        station, bandwidth = next(iter(accelerometers), default)
        return LateralSensors(
            drift_rate=self.drift_rate or other.drift_rate,
            drift=self.drift or other.drift,
            acceleration=bool(accelerometers),
            station=station,
            bandwidth=bandwidth,
        )

    def system(self, plant: AnyPlant) -> LinearSystem:
        """Return the plant with the sensors; its outputs are the plant's, then `signals`.

        Its states are the plant's, then the drift, unless that is an output of the plant, and the
        lag of the accelerometer. `InputError` for a plant without a speed, or without a flight path
        angle for the drift.
        """
        system = plant.system
        if not self.signals:
            return system
        others = [name for name in system.outputs if name not in (DRIFT_RATE, DRIFT, ACCELERATION)]
        system = system.select(system.inputs, others)
        blocks, rows = [], {}  # integral and lag; rows of C and D of signals that the plant has
        if self.drift_rate or self.drift:
            rows[DRIFT_RATE] = plant.lateral_rows("drift_rate", self.station)
        if self.drift and "drift" in system.outputs:
            k = system.outputs.index("drift")
            rows[DRIFT] = system.C[..., k, :], system.D[..., k, :]
            if np.any(system.D[..., k, :]):  # D: direct effect of deflection and wind
                raise InputError("drift of the plant must not follow deflection or wind at once")
        elif self.drift:
            blocks.append(_first_order(pole=0.0, gain=1.0, input=DRIFT_RATE, output=DRIFT))
        if self.acceleration:
            # the accelerometer lags behind the acceleration that acts on it, `_FORCE`
            rows[_FORCE] = plant.lateral_rows("acceleration", self.station)
            pole, gain = -self.bandwidth, self.bandwidth
            blocks.append(_first_order(pole, gain, input=_FORCE, output=ACCELERATION))
        measured = system.with_outputs(rows)
        return connect([measured, *blocks], system.inputs, (*system.outputs, *self.signals))


NO_LATERAL_SENSORS = LateralSensors()
"""Sensors of an autopilot without feedback of drift and acceleration."""


def lateral_plant(plant: AnyPlant, *, station: float = 0.0, position: bool = False) -> SystemPlant:
    """Return the plant with lateral drift rate and acceleration among its outputs.

    Responses, flights by samples and closed loops of it have the further outputs drift_rate [m/s],
    the velocity normal to the nominal path, lateral_acceleration [m/s^2], the force normal to the
    body over the mass, and on request drift [m]. With bending they are those at the sensors.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        One plant with a flight path and a known speed.
    station : float
        Position of the acceleration ahead of the centre of gravity [m].
    position : bool
        Whether the drift is an output too: a state more, with a pole at zero.

    Raises
    ------
    InputError
        For a batch, and as `Plant.lateral_rows`.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> vehicle = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> plant = tv.linear.lateral_plant(vehicle, station=10.0, position=True)
    >>> wind = tv.TriangularWind(peak=np.radians(5), duration=7.5)
    >>> trim = tv.trim_deflection(vehicle, wind)
    >>> flown = tv.attitude_responses(plant, trim, wind, [7.5])
    >>> [round(float(flown[name][0]), 2) for name in ("drift_rate", "drift")]
    [-1.82, -7.15]
    """
    check_plant(plant)
    flag("position", position)
    rows = {
        name: plant.lateral_rows(signal, station)
        for name, signal in (("drift_rate", "drift_rate"), ("lateral_acceleration", "acceleration"))
    }
    system = plant.system.with_outputs(rows)
    if position:
        integral = _first_order(pole=0.0, gain=1.0, input="drift_rate", output="drift")
        system = connect([system, integral], system.inputs, (*system.outputs, "drift"))
    return SystemPlant(system.to_control(plant.model), plant.coefficients)


def _first_order(pole: float, gain: float, input: str, output: str) -> LinearSystem:
    """Return the system x' = pole x + gain u with the output x.

    `pole`, `gain`: in 1/s. `input`, `output`: names of u and x; the name of x as a state is that of
    the output without "sensed_".
    """
    A, B, C, D = (np.array([[value]]) for value in (pole, gain, 1.0, 0.0))
    state = output.removeprefix("sensed_")
    return LinearSystem(A, B, C, D, inputs=(input,), outputs=(output,), states=(state,))
