"""A JSBSim instance of one vehicle: its sensors, the wind that it is given, and its steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import repeat
from math import asin, cos, sin
from typing import NamedTuple

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.base.units import FOOT
from tvclin.control.laws.law import Measurement
from tvclin.flights.sixdof.engine import Engine
from tvclin.flights.sixdof.model import DEFLECTIONS, Earth, InitialState, model_xml, planet_xml
from tvclin.flights.sixdof.steering import Steering
from tvclin.flights.verdict import MAX_ATTITUDE, OUTPUTS
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle import Vehicle

_Two = Callable[[], tuple[float, float]]
_NONE = 1e-12
"""Part of the wind that is too small to be told."""


class Senses(NamedTuple):
    """Readers of one plane, each without arguments.

    `angles`: attitude and flight path angle [rad]. `rates`: attitude rate [rad/s] and acceleration
    [rad/s^2]. `alpha`: angle of attack [rad].
    """

    angles: _Two
    rates: _Two
    alpha: Callable[[], float]


def senses(engine: Engine, plane: str, heading: float) -> Senses:
    """Return the readers of a plane; in yaw angles lie between the vertical plane and the right."""
    read = engine.reader
    axis = "q" if plane == "pitch" else "r"
    rate, push = read(f"velocities/{axis}-rad_sec"), read(f"accelerations/{axis}dot-rad_sec2")
    theta = read("attitude/theta-rad")
    if plane == "pitch":
        gamma = read("flight-path/gamma-rad")
        return Senses(lambda: (theta(), gamma()), lambda: (rate(), push()), read("aero/alpha-rad"))
    psi, speed, sideslip = (
        read(name) for name in ("attitude/psi-rad", "velocities/vt-fps", "aero/beta-rad")
    )
    north, east = read("velocities/v-north-fps"), read("velocities/v-east-fps")
    ahead, right = cos(heading), sin(heading)

    def angles() -> tuple[float, float]:
        side = east() * ahead - north() * right
        return asin(cos(theta()) * sin(psi() - heading)), asin(side / speed())

    return Senses(angles, lambda: (rate(), push()), lambda: -sideslip())


def wind_setter(engine: Engine, plane: str, heading: float) -> Callable[[float], None]:
    """Return what sets a wind [m/s] along the flight (pitch) or to its right (yaw)."""
    north, east = cos(heading), sin(heading)
    if plane == "yaw":
        north, east = -east, north
    parts = [
        (engine.writer(f"atmosphere/wind-{name}-fps"), part / FOOT)
        for name, part in (("north", north), ("east", east))
        if abs(part) > _NONE
    ]
    if len(parts) == 1:
        ((write, part),) = parts
        return lambda speed: write(speed * part)

    def blow(speed: float) -> None:
        for write, part in parts:
            write(speed * part)

    return blow


Row = tuple[float, ...]


class Prediction:
    """One plane at the end of the next step.

    What acts at the end of a step is set before the step, so the state at its end is foreseen: the
    rate by the engine's own rule, the angles to second order.

    `senses`: readers of the plane, at the beginning of a flight. `step`: step [s]. `turn`: by which
    the flight path has turned in the step before the flight [rad].
    """

    __slots__ = (
        "_alpha", "_attitude", "_blown", "_deflection", "_path", "_path_before", "_push",
        "_push_before", "_rate", "_senses", "_step",
    )  # fmt: skip

    def __init__(self, senses: Senses, step: float, turn: float = 0.0) -> None:
        self._senses, self._step = senses, step
        self._attitude, self._path = senses.angles()
        self._rate, self._push = senses.rates()
        self._path_before, self._push_before = self._path - turn, self._push
        self._alpha = self._blown = self._deflection = 0.0

    def shown(self, angle: float, nominal: Row) -> Measurement:
        """Return what a law is shown: deviations from the outputs of the nominal flight there.

        `angle` is the wind angle [rad] at the end of the step.
        """
        h, rate = self._step, self._rate
        rate_ahead = rate + h * (1.5 * self._push - 0.5 * self._push_before)
        turn = 0.5 * h * (rate + rate_ahead)
        path_turn = self._path - self._path_before
        return Measurement(
            self._attitude + turn - nominal[0],
            rate_ahead - nominal[1],
            self._path + path_turn - nominal[2],
            self._alpha + turn - path_turn - (angle - self._blown) - nominal[3],
            self._deflection,
        )

    def moved(self, deflection: float, angle: float, nominal: Row) -> Row:
        """Read the plane after a step, and return its outputs as deviations from the nominal."""
        self._push_before, self._path_before = self._push, self._path
        self._deflection, self._blown = deflection, angle
        self._attitude, self._path = attitude, path = self._senses.angles()
        (self._rate, self._push), self._alpha = self._senses.rates(), self._senses.alpha()
        off = attitude - nominal[0], self._rate - nominal[1], path - nominal[2]
        return (*off, self._alpha - nominal[3], deflection)


Place = Earth | InitialState | None

_STIFF = 4.0
"""Natural frequency of the hold of the nominal flight, over that of the airframe."""
_LEAST = 1.0
"""The same [rad/s] for an airframe with hardly any moment."""


class Airframe:
    """A vehicle in JSBSim.

    With frozen parameters over a flat planet its nominal flight is straight and needs no control.
    Over the Earth, and from a departure on, it is flown first: the nose is held to the flight
    path, in the other plane in every flight.

    `vehicle`: one vehicle. `plane`: plane of the wind, the deflection and all that is measured; in
    yaw to the right. `drift`: whether the flight path may turn. `step`: step [s]. `place`: without
    either the planet is flat and at rest, and all parameters are frozen. `engine`: what flies it.
    """

    def __init__(
        self, vehicle: Vehicle, plane: str, drift: bool, step: float, place: Place
    ) -> None:
        earth = place if isinstance(place, Earth) else None
        departure = place if isinstance(place, InitialState) else None
        heading = earth.heading if earth else 0.0
        initial = {
            "lat-geod-rad": earth.latitude if earth else 0.0,
            "h-sl-ft": (place.altitude if place else 0.0) / FOOT,
            "psi-true-rad": heading,
            "theta-rad": float(vehicle.attitude),
            "u-fps": float(vehicle.velocity) / FOOT,
            "q-rad_sec": departure.turn if departure else 0.0,
        }
        planet = None if earth else planet_xml()
        model = model_xml(vehicle, heading, departure)
        engine = Engine(model, initial, step, planet=planet, drift=drift)
        self.engine, self._step = engine, step
        self._bend = {name: engine.writer(path) for name, path in DEFLECTIONS.items()}
        self._senses = {name: senses(engine, name, heading) for name in DEFLECTIONS}
        self._blows = {name: wind_setter(engine, name, heading) for name in DEFLECTIONS}
        self._blow, self._plane = self._blows[plane], plane
        self._gains = _hold(Coefficients.from_vehicle(vehicle, plane)) if place else None
        self._nominal: list[Row] = []

    def fly(
        self,
        steering: Steering,
        speeds: FloatArray,
        angles: FloatArray,
        course: FloatArray | None = None,
    ) -> FloatArray:
        """Return a flight from the nominal state, up to where its attitude is beyond 25 deg.

        `steering`: gives the deflection. `speeds`: wind speed [m/s] at each step, along the flight
        or to its right, ``(n,)``; the first is zero. `angles`: the same as wind angle [rad].
        `course`: the `OUTPUTS` in pitch that the nominal flight is held to, ``(n, 5)``; without it
        the nominal flight goes straight on. Returned: the `OUTPUTS` [rad, rad/s] as deviations from
        the nominal flight, ``(m, 5)``, m <= n. If m is below n, the last row is the one that is
        beyond, or not finite.
        """
        nominal = self._nominal_rows(len(speeds), course)
        return self._flown(steering, speeds, angles, nominal, course)

    def fly_both(
        self,
        steering: Callable[[list[Measurement]], tuple[float, float]],
        speeds: FloatArray,
        angles: FloatArray,
    ) -> FloatArray:
        """Return a flight of both planes, frozen over a flat planet, as `fly`.

        `steering`: takes what is foreseen in pitch and in yaw, and gives both deflections [rad].
        `speeds`, `angles`: wind along the flight and to its right, and as angles, ``(2, n)``; the
        first are zero. Returned: the `OUTPUTS` of both planes, ``(m, 2, 5)``.
        """
        self._begin()
        planes = [Prediction(self._senses[name], self._step) for name in DEFLECTIONS]
        bends, blows = ([one[name] for name in DEFLECTIONS] for one in (self._bend, self._blows))
        straight = [(*self._senses[name].angles(), 0.0, 0.0) for name in DEFLECTIONS]
        nominal = [(attitude, 0.0, path, *rest) for attitude, path, *rest in straight]
        rows: list[list[Row]] = [[(0.0,) * len(OUTPUTS)] * len(planes)]
        for speed, angle in zip(speeds.T[1:].tolist(), angles.T[1:].tolist(), strict=True):
            each = list(zip(planes, angle, nominal, strict=True))
            deflections = steering([one.shown(a, row) for one, a, row in each])
            for write, value in zip((*bends, *blows), (*deflections, *speed), strict=True):
                write(value)
            self.engine.run()
            rows.append(
                [one.moved(d, a, row) for d, (one, a, row) in zip(deflections, each, strict=True)]
            )
            if not max(abs(row[0]) for row in rows[-1]) <= MAX_ATTITUDE:
                break
        return np.array(rows)

    def _nominal_rows(self, count: int, course: FloatArray | None) -> Iterator[Row]:
        """Return the outputs of the nominal flight, step by step."""
        attitude, path = self._begin()
        start = (attitude, 0.0, path, 0.0, 0.0)
        if self._gains is None:
            return repeat(start)
        if len(self._nominal) < count:
            hold, still = _held(*self._gains), np.zeros(count)
            ahead = np.tile(start, (count, 1))
            if course is not None and self._plane == "pitch":
                ahead = course
            flown = self._flown(hold, still, still, _each(ahead), course)
            self._nominal = list(_each(flown + ahead[: len(flown)]))
        if len(self._nominal) < count:
            raise InputError(
                "timepts must end before the nominal flight has turned by 25 deg, after"
                f" {len(self._nominal) * self._step:.3g} s"
            )
        return iter(self._nominal)

    def _begin(self) -> tuple[float, float]:
        """Go back to the start, and return attitude and flight path angle there [rad]."""
        self.engine.reset()
        return self._senses[self._plane].angles()

    def _flown(
        self,
        steering: Steering,
        speeds: FloatArray,
        angles: FloatArray,
        nominal: Iterator[Row],
        course: FloatArray | None,
    ) -> FloatArray:
        self._begin()
        h, run, bend, blow = self._step, self.engine.run, self._bend[self._plane], self._blow
        hold_other = self._other_hold(course)
        ahead = Prediction(self._senses[self._plane], h, turn=h * next(nominal)[1])
        rows: list[Row] = [(0.0,) * len(OUTPUTS)]
        gusts = zip(speeds[1:].tolist(), angles[1:].tolist(), nominal, strict=False)
        for k, (speed, angle, row) in enumerate(gusts, start=1):
            deflection = steering(k, ahead.shown(angle, row))
            hold_other()
            bend(row[4] + deflection)
            blow(speed)
            run()
            rows.append(ahead.moved(deflection, angle, row))
            if not abs(rows[-1][0]) <= MAX_ATTITUDE:
                break
        return np.array(rows)

    def _other_hold(self, course: FloatArray | None) -> Callable[[], None]:
        """Return what holds the nose to the path in the other plane, before each step."""
        if self._gains is None:
            return _nothing
        (other,) = set(DEFLECTIONS) - {self._plane}
        (angles, rates, _), bend = self._senses[other], self._bend[other]
        on_lean, on_rate = self._gains
        ahead: Iterator[Row] = repeat((0.0, 0.0))
        if course is not None and other == "pitch":
            ahead = _each(course[1:, [1, 4]])

        def hold() -> None:
            turn, deflection = next(ahead)
            attitude, path = angles()
            bend(deflection + on_lean * (attitude - path) + on_rate * (rates()[0] - turn))

        return hold


def _each(rows: FloatArray) -> Iterator[Row]:
    """Return plain rows, for the innermost loop."""
    return map(tuple, rows.tolist())


def _nothing() -> None:
    """Do nothing."""


def _hold(c: Coefficients) -> tuple[float, float]:
    """Return gains on the lean of the nose off the path, and on its rate, with damping one."""
    frequency = max(_STIFF * abs(float(c.mu_alpha)) ** 0.5, _LEAST)
    return (frequency**2 + float(c.mu_alpha)) / float(c.mu_delta), 2.0 * frequency / float(
        c.mu_delta
    )


def _held(on_lean: float, on_rate: float) -> Steering:
    return lambda k, measured: (
        on_lean * (measured.attitude - measured.flight_path_angle)
        + on_rate * measured.attitude_rate
    )


_Case = tuple[Vehicle, str, bool, float, Place]
_IDLE: dict[_Case, list[Airframe]] = {}
_KEPT = 8
"""Cases of which airframes are kept; the oldest goes, as an engine holds some megabytes."""


@contextmanager
def reused_airframe(*case: *_Case) -> Iterator[Airframe]:
    """Lend an airframe, for it takes a third of a flight to make one; a flight begins it anew.

    While one is out another is made, so that threads, and laws that fly ahead, have their own.
    """
    try:
        airframe = _IDLE[case].pop()
    except (KeyError, IndexError):
        airframe = Airframe(*case)
    yield airframe
    if case not in _IDLE and len(_IDLE) >= _KEPT:
        _IDLE.pop(next(iter(_IDLE)), None)
    _IDLE.setdefault(case, []).append(airframe)
