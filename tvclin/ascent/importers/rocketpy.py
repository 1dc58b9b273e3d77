"""Flight schedules from the objects of RocketPy, which this package never imports."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from tvclin.ascent.importers.powered_flight import MOST_ROWS, Flight, powered, schedule_of_flight
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, each, finite, number, shown
from tvclin.base.sheet import Column

_SAMPLES = 401
"""Times between rail and burnout at which the flight is sampled."""
_OF_FLIGHT = {
    "velocity": "speed",
    "altitude": "z",
    "dynamic_pressure": "dynamic_pressure",
    "mach": "mach_number",
    "axial_force": "aerodynamic_drag",
}
_ANGLES = {"attitude": "attitude_angle", "angle_of_attack": "angle_of_attack"}
_OF_ROCKET = {
    "mass": "total_mass",
    "gravity": "center_of_mass",
    "dry_inertia": "I_11",
    "offset": "com_to_cdm_function",
}


def schedule_from_rocketpy(
    flight: Any,
    *,
    gimbal_position: float,
    without: tuple[str, ...] = (),
    start: float | None = None,
    stop: float | None = None,
    max_rows: int = MOST_ROWS,
) -> FlightSchedule:
    """Return the flight schedule of a flight of RocketPy.

    Parameters
    ----------
    flight : rocketpy.Flight
        Of a simulation without wind; anything with its attributes.
    gimbal_position : float
        Where the thrust is turned [m], in the rocket's own coordinates, as `nozzle_position`.
    without : tuple of str
        Names of aerodynamic surfaces to leave out of slope and centre of pressure, such as fins
        that the steered vehicle does not have. Drag and mass stay.
    start, stop, max_rows
        Earliest and latest time [s], within the time from the rail to burnout, and largest number
        of rows.

    Returns
    -------
    FlightSchedule
        The powered flight; its notes say where each column came from.

    Raises
    ------
    InputError
        For an object that lacks an attribute, a surface that is not there, and as
        `read_openrocket`.

    Notes
    -----
    `I_11` is about the centre of dry mass. About the centre of mass it is I_11 - m d^2, with d the
    distance between them, `com_to_cdm_function`. Positions grow forward where `_csys` is 1 and aft
    where it is -1; arms are differences of positions times that.
    """
    gimbal = number("gimbal_position", gimbal_position, finite, "m")
    rocket = _attribute(flight, "rocket")
    motor = _attribute(rocket, "motor")
    names = each("without", without, str, "names of aerodynamic surfaces")
    first = number("out_of_rail_time", _attribute(flight, "out_of_rail_time"), finite, "s")
    last = number("burn_out_time", _attribute(motor, "burn_out_time"), finite, "s")
    if not first < last:
        raise InputError(f"flight must leave the rail before burnout; got {first:g} and {last:g} s")
    time = np.linspace(first, last, _SAMPLES)
    columns = {"time": Column(time, f"{_SAMPLES} times from rail to burnout")}
    thrust = _sampled(motor, "thrust", time, "motor")
    columns["thrust"] = Column(thrust.values, f"{thrust.origin}, not corrected for the air")
    columns |= {k: _sampled(flight, name, time, "flight") for k, name in _OF_FLIGHT.items()}
    columns |= {k: _sampled(rocket, name, time, "rocket") for k, name in _OF_ROCKET.items()}
    for key, name in _ANGLES.items():
        angle = _sampled(flight, name, time, "flight")
        columns[key] = Column(np.radians(angle.values), f"{angle.origin}, in degrees")
    simulated = Flight(
        source="the RocketPy flight",
        places=tuple(f"the RocketPy flight at {t:.4g} s" for t in time),
        columns=columns,
    )
    simulated = powered(simulated, start, stop)
    slope, centre, notes = _aerodynamics(rocket, simulated["mach"], names)
    simulated = simulated.with_columns(**_of_vehicle(simulated, rocket, gimbal, slope, centre))
    simulated = simulated.noted(*notes, *_generic(rocket))
    return schedule_of_flight(simulated, "RocketPy flight", max_rows)


def _of_vehicle(
    flight: Flight, rocket: Any, gimbal: float, slope: FloatArray, centre: FloatArray
) -> dict[str, Column]:
    """Return columns of inertia, area, slope and arms of a rocket at each row of a flight, by name.

    `gimbal`: position of the gimbal [m]. `slope`, `centre`: slope of the normal force [1/rad] and
    centre of pressure [m], ``(n,)``. Positions are in the rocket's coordinates.
    """
    area = number("rocket.area", _attribute(rocket, "area"), finite, "m^2")
    forward = number("rocket._csys", _attribute(rocket, "_csys"), finite)
    if abs(forward) != 1.0:
        raise InputError(f"rocket._csys must be 1 or -1; got {forward:g}")
    gravity, mass = flight["gravity"], flight["mass"]
    control = forward * (gravity - gimbal)
    if np.any(control <= 0.0):
        i = int(np.argmin(control))
        raise InputError(
            f"gimbal_position must lie behind the centre of mass, at {gravity[i]:.4g} m in the"
            f" rocket's coordinates at {flight['time'][i]:.4g} s; got {gimbal:.6g} m"
        )
    return {
        # parallel axes: from the centre of dry mass to that of all mass, I = I_11 - m d^2
        "moment_of_inertia": Column(
            flight["dry_inertia"] - mass * flight["offset"] ** 2,
            "rocket.I_11 less m com_to_cdm_function^2: about the centre of mass",
        ),
        "reference_area": Column(np.full(mass.size, area), "rocket.area"),
        "normal_force_coefficient_slope": Column(slope, "rocket.total_lift_coeff_der"),
        "aerodynamic_arm": Column(
            forward * (centre - gravity), "rocket.cp_position less rocket.center_of_mass"
        ),
        "control_arm": Column(control, f"rocket.center_of_mass less gimbal at {gimbal:g} m, given"),
    }


def _aerodynamics(
    rocket: Any, mach: FloatArray, without: tuple[str, ...]
) -> tuple[FloatArray, FloatArray, list[str]]:
    """Return slope of the normal force [1/rad], centre of pressure [m], ``(n,)`` each, and notes.

    `rocket`: of RocketPy. `mach`: Mach numbers, ``(n,)``. `without`: names of omitted surfaces.
    """
    slope = _sampled(rocket, "total_lift_coeff_der", mach, "rocket").values
    moment = slope * _sampled(rocket, "cp_position", mach, "rocket").values
    # pairs of a surface and its position
    surfaces = list(_attribute(rocket, "aerodynamic_surfaces")) if without else []
    for name in without:
        omitted = [(x, at) for x, at in surfaces if getattr(x, "name", None) == name]
        if not omitted:
            names = ", ".join(str(getattr(surface, "name", "")) for surface, _ in surfaces)
            raise InputError(
                f"without must name aerodynamic surfaces of the rocket, {names}; got {shown(name)}"
            )
        for surface, position in omitted:
            # the slope of a surface is on its own radius r, and the rocket's on R
            radius_ratio = _attribute(surface, "rocket_radius") / _attribute(rocket, "radius")
            part = radius_ratio**2 * _sampled(surface, "clalpha", mach, "surface").values
            # cpz counts from the surface towards the tail; _csys is 1 where positions of the
            # rocket count towards the nose, else -1
            centre = position.z - _attribute(rocket, "_csys") * _attribute(surface, "cpz")
            slope, moment = slope - part, moment - part * centre
    if np.any(slope <= 0.0):
        raise InputError(
            "without must leave a slope of the normal force; nothing is left of the rocket's"
        )
    note = f"left out of slope and centre of pressure: {', '.join(without)}; drag and mass stay"
    return slope, moment / slope, [note] if without else []


def _generic(rocket: Any) -> list[str]:
    """Return a note on surfaces of a rocket that RocketPy omits from slope and pressure centre."""
    pairs = getattr(rocket, "aerodynamic_surfaces", ())
    names = [
        str(getattr(surface, "name", ""))
        for surface, _ in pairs
        if any(kind.__name__ == "GenericSurface" for kind in type(surface).__mro__)
    ]
    if not names:
        return []
    return [f"RocketPy leaves generic surfaces out of slope and pressure: {', '.join(names)}"]


def _attribute(record: Any, name: str) -> Any:
    """Return an attribute, by its name, of an object of RocketPy; `InputError` without it.

    `record`: the object: a flight, a rocket, or a part of one.
    """
    value = getattr(record, name, None)
    if value is None:
        raise InputError(
            f"flight must be a Flight of RocketPy, with {name} in its {type(record).__name__}; got"
            f" {shown(record)}"
        )
    return value


def _sampled(record: Any, name: str, at: FloatArray, called: str) -> Column:
    """Return the values of a function `name` of an object of RocketPy, ``(n,)``, and their origin.

    `record`: the object: a flight, a rocket, or a part of one. `at`: times [s] or Mach numbers,
    ``(n,)``. `called`: name of the object in messages.
    """
    function: Callable[[float], Any] = _attribute(record, name)
    try:
        values = np.array([float(function(float(x))) for x in at])
    except Exception:  # whatever a stranger's function may raise
        raise InputError(
            f"flight must be a Flight of RocketPy, and its {called}.{name} a function that gives a"
            " number"
        ) from None
    return Column(values, f"{called}.{name}")
