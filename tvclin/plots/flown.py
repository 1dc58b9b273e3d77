"""Flights beside the curves of the theory: which engine flies, and what is flown."""

import warnings
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from typing import Any

import numpy as np

from tvclin.ascent.flight_condition import load_flight_condition
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import one_of
from tvclin.flights.flown_boundary import ENGINES, flown_boundary
from tvclin.flights.nozzle_command import ReportControl
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.file import load_vehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.pulses import TriangularWind

Flights = Callable[[History, float, float, FloatArray], FloatArray]
"""Takes a wind, a deflection limit [rad], a dead band and times [s], ``(n,)``, and gives the
attitude [rad] that was flown, ``(n,)``, NaN from where the flight ended."""

PEAK = float(np.radians(1.0))
"""Of the winds that are flown [rad]: a tail wind. The report does not give its own."""


def chosen_engine(engine: str | None) -> str:
    """Return an engine by name, or where none is named JSBSim if it is installed, else "planar".

    `InputError` for any other name.
    """
    if engine is None:
        return "sixdof" if find_spec("jsbsim") else "planar"
    return one_of("engine", engine, ENGINES)


def flown_attitudes(vehicle: Vehicle, engine: str) -> Flights:
    """Return what flies the report's control on a vehicle with frozen parameters, in pitch.

    `engine`: one of `ENGINES`.
    """
    fly = ENGINES[engine].fly

    def attitude(wind: History, limit: float, dead_band: float, times: FloatArray) -> FloatArray:
        control = ReportControl(dead_band)
        with warnings.catch_warnings():  # that a flight below the boundary ends is what is shown
            warnings.filterwarnings("ignore", "the flight ends", UserWarning)
            flown = fly(vehicle, control, wind, times, deflection_limit=limit)
        return np.asarray(flown.outputs["attitude"])

    return attitude


@cache
def flown_limit(
    name: str,
    tau_beta: float,
    dead_band: float,
    *,
    plane: str = "pitch",
    peak: float = PEAK,
    engine: str = "planar",
    along: bool = False,
    tolerance: float = 2.5e-3,
) -> float:
    """Return the boundary limit of the report's control in a triangular wind, by flying.

    `name`: what `load_vehicle` and `load_flight_condition` find the vehicle by. `tau_beta`,
    `dead_band`: duration of the wind, and K. `plane` ({"pitch", "yaw"}): plane of the wind. `peak`:
    its peak [rad], at the vehicle's own time. `engine`: one of `ENGINES`. `along`: whether the
    parameters vary along the trajectory, which planar flights know; frozen where not. `tolerance`:
    as of `flown_boundary`.
    """
    vehicle = load_vehicle(name)
    options: dict[str, Any] = {}
    if along:
        options = {"frozen": False, "condition": load_flight_condition(name)}
    wind = centred_wind(vehicle, peak, tau_beta)
    return flown_boundary(
        vehicle, wind, dead_band, engine=engine, plane=plane, tolerance=tolerance, **options
    ).limit


def centred_wind(vehicle: Vehicle, peak: float, tau_beta: float) -> History:
    """Return the triangular wind of a given tau p that has its peak at the vehicle's time."""
    wind = TriangularWind(peak=peak, duration=tau_beta / Coefficients.from_vehicle(vehicle).pole)
    own = 0.0 if vehicle.time is None else float(np.asarray(vehicle.time))
    return wind.shift(own - wind.duration / 2.0)
