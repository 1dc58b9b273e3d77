"""The climb of a vehicle whose state is frozen."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import LATEST, InputError, between, instance, number, single
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.soundings.passage import checked_flight


@dataclass(frozen=True, eq=False)
class Climb:
    """A flight as `WindProfile.to_wind` asks for it; every array has the shape ``(n,)``.

    Attributes
    ----------
    time : ndarray
        [s], ascending.
    height : ndarray
        Geometric height above the sea [m], ascending.
    speed : ndarray
        [m/s].
    flight_path_angle : ndarray
        [rad].

    Raises
    ------
    InputError
        For arrays of different lengths or of one time, and for numbers that are not finite, times
        and heights that do not ascend, and speeds that are not positive.
    """

    time: FloatArray
    height: FloatArray
    speed: FloatArray
    flight_path_angle: FloatArray

    def __post_init__(self) -> None:
        for field, array in zip(fields(self), checked_flight(self), strict=True):
            object.__setattr__(self, field.name, array)


def steady_climb(vehicle: Vehicle, *, height: float, start: float, stop: float) -> Climb:
    """Return the climb of a vehicle that keeps its speed and its flight path angle.

    Parameters
    ----------
    vehicle : Vehicle
        One vehicle; its attitude is the flight path angle, as in the nominal flight.
    height : float
        Where it is [m above the sea] at its own time (zero where it has none).
    start, stop : float
        First and last time [s].

    Raises
    ------
    InputError
        For a batch, a stop not after the start, and a vehicle that does not climb.

    Examples
    --------
    >>> import tvclin as tv
    >>> vehicle = tv.load_vehicle("configuration-i")
    >>> tv.winds.steady_climb(vehicle, height=11950.0, start=53.0, stop=79.0).height.round(1)
    array([ 7011.8, 16888.2])
    """
    instance("vehicle", vehicle, Vehicle, "see load_vehicle")
    single("vehicle", vehicle.batch)
    begin, end = (
        number(name, value, between(-LATEST, LATEST), "s")
        for name, value in (("start", start), ("stop", stop))
    )
    if not begin < end:
        raise InputError(f"stop must be after start; got {begin:.6g} and {end:.6g} s")
    rate = float(vehicle.velocity * np.sin(vehicle.attitude))
    if not rate > 0.0:
        raise InputError(f"vehicle must climb; its height changes by {rate:.6g} m/s")
    time = np.array([begin, end])
    own = 0.0 if vehicle.time is None else float(vehicle.time)
    return Climb(
        time=time,
        height=number("height", height, unit="m") + rate * (time - own),
        speed=np.full(2, float(vehicle.velocity)),
        flight_path_angle=np.full(2, float(vehicle.attitude)),
    )
