"""Variables of a flight on which an autopilot may be scheduled."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.atmosphere import speed_of_sound, standard_atmosphere
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import finite, instance, one_of, within

VARIABLES = ("time", "speed", "altitude", "mach", "dynamic_pressure")
"""Names of the variables."""


def flight_variable(flight: FlightSchedule, variable: str, time: ArrayLike) -> FloatArray:
    """Return a variable of the flight at times [s], of their shape, in SI units.

    Parameters
    ----------
    flight : FlightSchedule
        The flight; with its altitude for all variables but time and speed.
    variable : {"time", "speed", "altitude", "mach", "dynamic_pressure"}
        Time of flight [s], speed [m/s], altitude [m], Mach number, and dynamic pressure [Pa], the
        last two in the standard atmosphere without wind.
    time : array_like
        Times of flight [s].

    Raises
    ------
    InputError
        For another variable, times outside the flight, and a flight without altitude.

    Examples
    --------
    >>> import tvclin as tv
    >>> flight = tv.load_schedule("configuration-i")
    >>> tv.ascent.flight_variable(flight, "mach", [50.0, 66.0, 80.0]).round(2)
    array([1.32, 1.83, 2.33])
    """
    instance("flight", flight, FlightSchedule, "see load_schedule")
    one_of("variable", variable, VARIABLES)
    times = within("time", finite("time", time, "s"), *flight.span, "s")
    if variable == "time":
        return times
    speed = np.asarray(np.interp(times, flight.times, flight.speed))
    if variable == "speed":
        return speed
    altitude = np.asarray(np.interp(times, flight.times, flight.height))
    if variable == "altitude":
        return altitude
    air = standard_atmosphere(altitude)
    if variable == "mach":
        return np.asarray(speed / speed_of_sound(air))
    return np.asarray(0.5 * air.density * speed**2)
