"""One vehicle in the engine: stepped, measured in its plane, and told of wind and deflection."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import asin, cos, sin

import numpy as np
from numpy.typing import NDArray

from tvclin.flight.answer import FARTHEST, OUTPUTS
from tvclin.flight.sixdof.engine import Engine
from tvclin.flight.sixdof.model import DEFLECTION, model_xml, planet_xml
from tvclin.flight.sixdof.steering import Steering
from tvclin.laws import Seen
from tvclin.units import FOOT
from tvclin.vehicle import Vehicle

FloatArray = NDArray[np.float64]


_WIND = {"pitch": "atmosphere/wind-north-fps", "yaw": "atmosphere/wind-east-fps"}
_Two = Callable[[], tuple[float, float]]


class Airframe:
    """A vehicle with frozen parameters in JSBSim, which stays in its nominal flight by itself.

    Parameters
    ----------
    vehicle : Vehicle
        One vehicle.
    plane : {"pitch", "yaw"}
        Plane of the wind, the deflection and all that is measured; in yaw to the right.
    drift : bool
        Whether the flight path may turn.
    step : float
        Step [s].
    """

    def __init__(self, vehicle: Vehicle, plane: str, drift: bool, step: float) -> None:
        initial = {
            "h-sl-ft": 0.0,
            "theta-rad": float(vehicle.attitude),
            "u-fps": float(vehicle.velocity) / FOOT,
        }
        model = model_xml(vehicle, plane)
        self._engine = Engine(model, initial, step, planet=planet_xml(), drift=drift)
        self._step = step
        self._bend = self._engine.writer(DEFLECTION)
        self._blow = self._engine.writer(_WIND[plane])
        self._angles, self._rates, self._alpha = _senses(self._engine, plane)

    def fly(self, steering: Steering, speeds: FloatArray, angles: FloatArray) -> FloatArray:
        """Return a flight from the nominal state, up to where its attitude is beyond 25 deg.

        Parameters
        ----------
        steering : callable
            Gives the deflection.
        speeds : ndarray
            Wind speed [m/s] at each step, towards north or east, ``(n,)``; the first is zero.
        angles : ndarray
            The same as wind angle [rad].

        Returns
        -------
        ndarray
            The `OUTPUTS` [rad, rad/s] as deviations from the nominal flight, ``(m, 5)``, m <= n.
            If m is below n, the last row is the one that is beyond, or not finite.
        """
        self._bend(0.0)  # the reset evaluates what acts, and does not put the nozzle back
        self._engine.reset()
        h, run, attitude_and_path, rates = self._step, self._engine.run, self._angles, self._rates
        measured_alpha = self._alpha
        attitude0, path0 = attitude_and_path()
        attitude = path = path_before = rate = push = push_before = 0.0
        alpha = blown = deflection = 0.0
        rows = [(0.0,) * len(OUTPUTS)]
        gusts = zip((speeds[1:] / FOOT).tolist(), angles[1:].tolist(), strict=True)
        for k, (speed, angle) in enumerate(gusts, start=1):
            # What acts at the end of a step is set before the step, so the state at its end is
            # foreseen: the rate by the engine's own rule, the angles to second order.
            rate_ahead = rate + h * (1.5 * push - 0.5 * push_before)
            turn = 0.5 * h * (rate + rate_ahead)
            path_turn = path - path_before
            deflection = steering(
                k,
                Seen(
                    attitude + turn,
                    rate_ahead,
                    path + path_turn,
                    alpha + turn - path_turn - (angle - blown),
                    deflection,
                ),
            )
            self._bend(deflection)
            self._blow(speed)
            run()
            push_before, path_before, blown = push, path, angle
            attitude, path = attitude_and_path()
            attitude, path = attitude - attitude0, path - path0
            (rate, push), alpha = rates(), measured_alpha()
            rows.append((attitude, rate, path, alpha, deflection))
            if not abs(attitude) <= FARTHEST:
                break
        return np.array(rows)


_IDLE: dict[tuple[Vehicle, str, bool, float], list[Airframe]] = {}
_KEPT = 8


@contextmanager
def borrowed(vehicle: Vehicle, plane: str, drift: bool, step: float) -> Iterator[Airframe]:
    """Lend an airframe, for it takes a third of a flight to make one; a flight begins it anew.

    While one is out another is made, so that threads, and laws that fly ahead, have their own.
    """
    case = (vehicle, plane, drift, step)
    try:
        airframe = _IDLE[case].pop()
    except (KeyError, IndexError):
        airframe = Airframe(*case)
    yield airframe
    if case not in _IDLE and len(_IDLE) >= _KEPT:
        _IDLE.pop(next(iter(_IDLE)), None)
    _IDLE.setdefault(case, []).append(airframe)


def _senses(engine: Engine, plane: str) -> tuple[_Two, _Two, Callable[[], float]]:
    """Return what reads attitude and flight path, rate and acceleration, and angle of attack."""
    if plane == "pitch":
        theta, gamma = engine.reader("attitude/theta-rad"), engine.reader("flight-path/gamma-rad")
        q, q_dot = (
            engine.reader("velocities/q-rad_sec"),
            engine.reader("accelerations/qdot-rad_sec2"),
        )
        alpha = engine.reader("aero/alpha-rad")
        return lambda: (theta(), gamma()), lambda: (q(), q_dot()), alpha
    theta, psi = engine.reader("attitude/theta-rad"), engine.reader("attitude/psi-rad")
    east, speed = engine.reader("velocities/v-east-fps"), engine.reader("velocities/vt-fps")
    r, r_dot = engine.reader("velocities/r-rad_sec"), engine.reader("accelerations/rdot-rad_sec2")
    sideslip = engine.reader("aero/beta-rad")
    return (
        lambda: (asin(cos(theta()) * sin(psi())), asin(east() / speed())),
        lambda: (r(), r_dot()),
        lambda: -sideslip(),
    )
