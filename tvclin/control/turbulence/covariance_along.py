"""Covariance of a loop in turbulence along a flight, about its mean response to a known wind.

Vehicle, structure, gains and the intensity of each time vary, the filter stands in the distance
flown; a sampled autopilot jumps at its samples, with the gains of each. The vehicle starts at rest
in turbulence that is stationary.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tvclin.ascent.atmosphere import LAYER_ALTITUDES
from tvclin.ascent.schedule import FlightSchedule, flight_variable
from tvclin.ascent.structure_schedule import StructureSchedule
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, instance
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.gain_schedule import GainSchedule, autopilot_along
from tvclin.control.autopilot.sweep import plants_along
from tvclin.control.turbulence.covariance_history import CovarianceHistory
from tvclin.control.turbulence.covariance_march import march, march_times
from tvclin.control.turbulence.driven_loop import (
    DrivenLoop,
    LoadSlopes,
    SensorNoise,
    checked_parts,
    driven_loop,
    loads_at,
)
from tvclin.control.turbulence.varying_loop import VaryingLoop
from tvclin.linear.flexible import AnyPlant, FlexiblePlant
from tvclin.vehicle.structure import Structure
from tvclin.winds.histories import History
from tvclin.winds.turbulence import Turbulence


def turbulence_along(
    schedule: FlightSchedule,
    autopilot: Autopilot | GainSchedule,
    turbulence: Turbulence,
    *,
    model: str = "drift-exact",
    plane: str = "pitch",
    start: float | None = None,
    stop: float | None = None,
    wind: History | None = None,
    structure: Structure | StructureSchedule | None = None,
    noise: SensorNoise | None = None,
    loads: LoadSlopes | None = None,
) -> CovarianceHistory:
    """Return mean and covariance of a vehicle along its flight, in a known wind and turbulence.

    Parameters
    ----------
    schedule : FlightSchedule
        The vehicle at its flight times; it needs altitudes for turbulence that is a table.
    autopilot : Autopilot or GainSchedule
        One autopilot, or its gains over the flight; continuous, or with one sample rate. The
        actuator of a flight that has one over time takes the place of the autopilot's.
    turbulence : Turbulence
        The wind.
    model : {"fixed-path", "drift", "drift-exact", "drift-and-speed"}
        Model of the motion.
    plane : {"pitch", "yaw"}
        Plane of the motion.
    start, stop : float, optional
        First and last time [s], by default those of the schedule: a start where the wind angle is
        small, so not on the pad.
    wind : History, optional
        The known wind [rad] over flight time; by default none.
    structure : Structure or StructureSchedule, optional
        Bending, slosh and sensors, constant or over the flight; by default those of the schedule.
    noise : SensorNoise, optional
        White noise of the sensors.
    loads : LoadSlopes, optional
        Slopes of loads, one number or one for each time of the schedule, and a low-pass. A schedule
        with altitudes has the output "q_alpha" by itself.

    Raises
    ------
    InputError
        For a delay or a sample rate that varies, a schedule without the altitudes that a table
        needs, more than 30,000 steps, and numbers out of range.

    Notes
    -----
    Between the times of the schedule the vehicle and the gains are straight lines. The outputs are
    those of `turbulence_history`, and the drift [m] where the model has a flight path. The delay of
    a continuous autopilot is its Pade approximation; with samples it is exact, the law has the
    gains of each sample, and the history shows the motion between samples too.
    """
    instance("schedule", schedule, FlightSchedule, "see load_schedule")
    parts = autopilot.autopilot if isinstance(autopilot, GainSchedule) else autopilot
    checked_parts(parts, turbulence, noise, loads)
    if not isinstance(autopilot, GainSchedule) and parts.batch:
        raise InputError(
            f"autopilot must be one autopilot, or a GainSchedule; got a batch of {parts.batch}"
        )
    delay = _constant("delay", parts.delay)
    rate = None if parts.sample_rate is None else _constant("sample_rate", parts.sample_rate)
    flight = schedule if start is None and stop is None else schedule.between(start, stop)
    frozen: Structure | None = None
    if isinstance(structure, StructureSchedule):
        flight = replace(flight, structure=structure)
    elif structure is not None:
        instance("structure", structure, Structure, "or a StructureSchedule")
        frozen = structure
    if turbulence.altitude is not None:
        _ = flight.height  # refuses a schedule without altitude
    given = LoadSlopes() if loads is None else loads
    own_pressure = given.dynamic_pressure is None and flight.altitude is not None

    def loop_at(times: FloatArray) -> DrivenLoop:
        inside = np.clip(times, *flight.span)
        vehicle = flight.at(inside)
        plant: AnyPlant
        if frozen is None:
            plant = plants_along(flight, inside, model, plane)
        else:
            plant = FlexiblePlant.from_vehicle(vehicle.rigid, frozen, model, plane)
        law = replace(autopilot_along(autopilot, flight, inside), delay=delay, sample_rate=rate)
        height = None if flight.altitude is None else np.interp(inside, flight.times, flight.height)
        V = np.broadcast_to(np.asarray(vehicle.velocity), times.shape)
        a, b, c = turbulence.shaping_filter(V, height)
        shape = a, b, c / V[:, np.newaxis, np.newaxis]
        slopes = loads_at(given, schedule.times, inside)
        if own_pressure:
            pressure = flight_variable(flight, "dynamic_pressure", inside)
            slopes = replace(slopes, dynamic_pressure=pressure)
        return driven_loop(law, plant, shape, V, noise, slopes, drift=True)

    loop = VaryingLoop(loop_at, _breakpoints(flight, autopilot, turbulence))
    times = march_times(*flight.span, wind, loop)
    moments = march(loop, times, wind)
    return CovarianceHistory(times, loop.labels, loop.signals(times), moments)


def _constant(name: str, value: float | FloatArray) -> float:
    """Return a number of an autopilot that must be the same along a flight."""
    values = np.unique(value)
    if values.size > 1:
        raise InputError(f"the {name} of the autopilot must be the same along the flight")
    return float(values[0])


def _breakpoints(
    flight: FlightSchedule, autopilot: Autopilot | GainSchedule, turbulence: Turbulence
) -> FloatArray:
    """Return the times of a flight at which its data, gains or turbulence have a corner [s]."""
    first, last = flight.span
    breaks = [flight.times]
    if flight.structure is not None:
        breaks.append(flight.structure.times)
    if isinstance(autopilot, GainSchedule) and autopilot.variable == "time":
        breaks.append(autopilot.breakpoints)
    if flight.altitude is not None and np.all(np.diff(flight.height) > 0.0):
        corners = [LAYER_ALTITUDES, *([] if turbulence.altitude is None else [turbulence.altitude])]
        breaks += [np.interp(corner, flight.height, flight.times) for corner in corners]
    inner = np.unique(np.concatenate(breaks))
    inner = inner[(inner > first + _CLOSE_S) & (inner < last - _CLOSE_S)]
    times = np.concatenate([[first], inner, [last]])
    return np.asarray(times[np.append(True, np.diff(times) > _CLOSE_S)])


_CLOSE_S = 1e-6
"""Breakpoints this close are one [s]."""
