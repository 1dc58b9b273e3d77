"""Whether a law survives in JSBSim with both planes at once and one stop."""

from collections.abc import Callable
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.boundary.stops import Stop
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.laws.attitude import SaturatedLaw
from tvclin.control.laws.both_planes import LawInPlanes
from tvclin.control.laws.law import Law, Measurement
from tvclin.flights.answer import FARTHEST
from tvclin.flights.closed_loop.checks import check_span
from tvclin.flights.falls import has_fallen, watched_until
from tvclin.flights.sixdof.airframe import borrowed
from tvclin.flights.sixdof.case import SixDof
from tvclin.vehicle.coefficients import PLANES
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.plane_wind import PlaneWind


def planes_verdict(
    vehicle: Vehicle,
    wind: PlaneWind,
    control: object,
    *,
    frozen: bool = True,
    drift: bool = True,
    step: float = 0.01,
    stop: Stop | str = "round",
    saturate: str = "radial",
) -> Callable[[float], bool]:
    """Return what says of a deflection limit [rad] whether its flight survives.

    `vehicle`, `frozen`, `drift`, `step`: as of `fly_sixdof`; parameters are frozen over a flat
    planet. `wind`: one wind that ends, from t = 0 on. `control`: for both planes, as of
    `fly_planes`. `stop`, `saturate`: as of `fly_planes`. `InputError` for what is no law, a flight
    that is not frozen, and as `fly_sixdof` and `fly_planes`.
    """
    if isinstance(control, Autopilot):
        control = SaturatedLaw(control)
    if not isinstance(control, Law):
        raise InputError("both planes are flown by a law; give law=, such as TrimLaw")
    if not frozen:
        raise InputError("both planes are flown with frozen parameters; leave frozen=True")
    law = LawInPlanes(control, stop, saturate)
    cases = {plane: SixDof(vehicle, plane, drift, step) for plane in PLANES}
    pole = float(cases["yaw"].coefficients.pole)
    begin, until = min(0.0, float(wind.onset)), watched_until(wind, pole)
    check_span(begin, until)
    blown = [_blown(cases[plane], getattr(wind, plane), begin, until) for plane in PLANES]
    speeds, angles = (np.stack(one) for one in zip(*blown, strict=True))
    numbers = vehicle.replace(name="", time=None)

    def survives(limit: float) -> bool:
        with borrowed(numbers, "pitch", drift, step, None) as airframe:
            rows = airframe.fly_both(_steering(law, limit, step), speeds, angles)
        if not np.all(np.isfinite(rows)) or np.abs(rows[-1, :, 0]).max() > FARTHEST:
            return False
        return not has_fallen(float(np.hypot(*rows[-1, :, 1])), float(wind.peak), pole)

    return survives


def _blown(case: SixDof, wind: Any, begin: float, until: float) -> tuple[FloatArray, FloatArray]:
    """Wind speeds [m/s] and angles [rad] at the steps; zeros in a plane without wind."""
    if np.isfinite(wind.onset):
        air = case.air(wind, begin, until)
        return air.speeds, air.angles
    count = int(np.ceil((until - begin) / case.step - 1e-9)) + 3
    return np.zeros(count), np.zeros(count)


def _steering(
    law: LawInPlanes, limit: float, step: float
) -> Callable[[list[Measurement]], tuple[float, float]]:
    """Return what asks the law at every step, and remembers what it remembers."""
    learning = law.law.state_space.to_steps(step)
    memory, most = np.zeros(len(learning.states), complex), np.array([limit])

    def asked(planes: list[Measurement]) -> tuple[float, float]:
        nonlocal memory
        pitch, yaw = planes
        measured = np.array(pitch) + 1j * np.array(yaw)
        demand = law.demand(measured[np.newaxis], memory[np.newaxis], most)
        (command,), _ = law.limited(demand, most)
        memory = learning.A @ memory + learning.B @ measured
        return float(command.real), float(command.imag)

    return asked
