"""Where a flight along its trajectory begins, and the way that its nominal flight is held to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tvclin.ascent.flight_condition import FlightCondition
from tvclin.ascent.nominal_flight import nominal_flight
from tvclin.base.arrays import FloatArray
from tvclin.vehicle.vehicle import Vehicle


@dataclass(frozen=True)
class Departure:
    """The beginning of a flight in the standard atmosphere over a flat planet at rest.

    `altitude`: in m. `turn`: rate of the flight path [rad/s]. `dynamic_pressure`: what the
    vehicle's aerodynamic forces belong to [Pa]. `mass_flow`: by which the mass falls [kg/s].
    """

    altitude: float
    turn: float
    dynamic_pressure: float
    mass_flow: float


@dataclass(frozen=True, eq=False)
class Course:
    """The nominal flight that is to be flown.

    `vehicle`: the vehicle as it is at the beginning. `departure`: the beginning. `speeds`: speed
    [m/s] at each step, ``(n,)``. `rows`: attitude, attitude rate, flight path angle, angle of
    attack and deflection at each step [rad, rad/s], ``(n, 5)``, in pitch. The nose is on the path.
    """

    vehicle: Vehicle
    departure: Departure
    speeds: FloatArray
    rows: FloatArray


def course_of(vehicle: Vehicle, condition: FlightCondition, times: FloatArray) -> Course:
    """Return the course through a vehicle's state at its own time, seen at other times [s].

    `InputError` as `nominal_flight`.
    """
    own = 0.0 if vehicle.time is None else float(np.asarray(vehicle.time))
    first, last = min(float(times[0]), own), max(float(times[-1]), own)
    nominal = nominal_flight(vehicle, condition, start=first, stop=last)
    states = nominal.states(times)
    turns = nominal.rates(times, states)[1]
    still = np.zeros(times.size)
    begin = float(times[0])
    departure = Departure(
        altitude=float(states[2, 0]),
        turn=float(turns[0]),
        dynamic_pressure=float(nominal.dynamic_pressure(begin)),
        mass_flow=float(nominal.mass(begin) - nominal.mass(begin + 1.0)),
    )
    rows = np.stack([states[1], turns, states[1], still, nominal.deflection(times)], axis=-1)
    return Course(nominal.vehicle_at(begin), departure, states[0], rows)
