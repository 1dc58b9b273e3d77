"""Wind angles of attack: the triangle of wind and flight, and the range of linear aerodynamics.

Seen from the ground the vehicle has the speed V at the angle Theta_n above the horizontal. In
horizontal winds w along the path, positive from behind, and c across it, both over V, its velocity
through the air over V is

    (cos Theta_n - w, sin Theta_n, -c),

so that the wind angles of attack in pitch and yaw and the dynamic pressure over the nominal one are

    alpha = atan2(sin Theta_n, cos Theta_n - w) - Theta_n = atan2(w sin Theta_n, 1 - w cos Theta_n),
    tan(beta) = c/v,    q/q_n = v^2 + c^2,    v^2 = (cos Theta_n - w)^2 + sin(Theta_n)^2.

A wind that is given by its angles is that whose triangle has them,

    w = sin(alpha)/sin(Theta_n + alpha),  v = sin(Theta_n)/sin(Theta_n + alpha),  c = v tan(beta).

Where only the speed V_R through the air is known, eq (B1e) of the report gives the wind angle,

    sin(alpha_w) = (V_w/V_R) sin(gamma).

Speed and path are those given; `EncounteredWind.flight` lets them vary along a flight. Above
`MAX_LINEAR_ANGLE` linear aerodynamics has no validity, and no verdict is given.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.numerics import pieces
from tvclin.winds.histories import History

SIGNS = {"head": -1.0, "tail": 1.0}
"""Sign of the wind angle in the pitch plane, by direction."""
CROSS = "cross"
"""Direction of a wind across the path."""
DIRECTIONS = (*SIGNS, CROSS)
"""Directions of a wind, on which the dynamic pressure encountered depends."""
FROZEN = "frozen"
"""The nominal dynamic pressure, for either sign of the wind."""
_NEWTON_ITERATIONS = 8
"""Newton iterations for the speed ratio of a wind vector."""
_AXIS_ROUNDING = 1e-12
"""Component of a unit vector that counts as zero."""
MAX_LINEAR_ANGLE = float(np.radians(30.0))
"""Largest wind angle [rad] of a verdict: above it no constant slope of the normal force holds."""
MAX_CERTAIN_ANGLE = float(np.radians(10.0))
"""Angle of attack [rad] above which the normal force of a slender body is doubtfully linear."""
BEYOND_LINEAR = f"above {np.degrees(MAX_LINEAR_ANGLE):.3g} deg linear aerodynamics says nothing"
DOUBTFUL = (
    f"above about {np.degrees(MAX_CERTAIN_ANGLE):.3g} deg the normal force of a slender body is no"
    " longer proportional to the angle: the numbers are doubtful"
)
WIND, ATTACK = "the wind meets the flight at", "the angle of attack reaches"
"""Subjects of the sentences: the wind angle, and the angle of attack of a flight."""
_RELATIVE_ROUNDING = 1e-12
"""Relative rounding of an angle at the limit."""


def wind_triangle(
    path: ArrayLike, along: ArrayLike, across: ArrayLike = 0.0
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return wind angles of attack in pitch and yaw [rad], and q/q_n, of horizontal winds.

    q/q_n is the dynamic pressure over the nominal one. `path`: angle Theta_n of the path above the
    horizontal [rad]. `along`, `across`: wind speeds w and c over the speed of the vehicle; w is
    positive from behind.
    """
    in_pitch = pressure_in_winds(path, along)  # squared airspeed in the pitch plane, over V^2
    pitch = np.arctan2(np.multiply(along, np.sin(path)), 1.0 - np.multiply(along, np.cos(path)))
    yaw = np.arctan2(across, np.sqrt(in_pitch))
    return np.asarray(pitch), np.asarray(yaw), np.asarray(in_pitch + np.square(across))


def pressure_in_winds(path: ArrayLike, along: ArrayLike, across: ArrayLike = 0.0) -> FloatArray:
    """Return q/q_n, the dynamic pressure in horizontal winds over the nominal one.

    `path`: angle Theta_n of the path above the horizontal [rad]. `along`, `across`: wind speeds
    over the speed of the vehicle.
    """
    return np.asarray((np.cos(path) - along) ** 2 + np.sin(path) ** 2 + np.square(across))


def along_from_angle(path: ArrayLike, angle: ArrayLike) -> FloatArray:
    """Return the wind speed w along a path, over the vehicle's, for a wind angle of attack.

    By the sine rule in the wind triangle w = sin(alpha)/sin(Theta_n + alpha), positive from behind.
    `path`, `angle`: Theta_n and alpha [rad]. NaN where no horizontal wind has the angle.
    """
    return np.asarray(np.sin(angle) / _sine_of_airspeed(path, angle))


def _sine_of_airspeed(path: ArrayLike, angle: ArrayLike) -> FloatArray:
    """Return sin(Theta_n + alpha_w), of the angle of the airspeed above the horizontal.

    `path`, `angle`: nominal flight path Theta_n and wind angle alpha_w [rad]. NaN where no
    horizontal wind along the path has the angle.
    """
    sine = np.sin(np.add(path, angle))
    return np.where((np.sin(path) > 0.0) & (sine > 0.0), sine, np.nan)


def pressure_ratio(path: ArrayLike, angle: ArrayLike) -> FloatArray:
    """Return q/q_n, dynamic pressure over the nominal one, for winds along a path by their angles.

    `path`: angle of the path above the horizontal [rad]. `angle`: wind angles of attack [rad]; NaN
    where no horizontal wind has the angle.
    """
    _, _, ratio = wind_triangle(path, along_from_angle(path, angle))
    return ratio


def angle_from_speed(
    speed: ArrayLike, velocity: ArrayLike, flight_path_angle: ArrayLike
) -> FloatArray:
    """Return the wind angle of attack [rad] of a horizontal wind, eq (B1e).

        sin(alpha_w) = (V_w/V_R) sin(gamma)

    Parameters
    ----------
    speed : array_like
        Wind speed V_w [m/s]; positive is a tail wind.
    velocity : array_like
        Speed of the vehicle relative to the air V_R [m/s], positive.
    flight_path_angle : array_like
        Flight path angle gamma [rad].

    Raises
    ------
    InputError
        When no wind angle exists: ``|V_w sin(gamma)| > V_R``.
    """
    speed = errors.finite("speed", speed, "m/s")
    velocity = errors.positive("velocity", velocity, "m/s")
    path = errors.directions("flight_path_angle", flight_path_angle)
    errors.together(speed=speed, velocity=velocity, flight_path_angle=path)
    with np.errstate(over="ignore"):  # an infinite ratio is refused with the others
        sine = speed * np.sin(path) / velocity
    if np.any(np.abs(sine) > 1.0):
        speeds, velocities, paths = np.broadcast_arrays(np.abs(speed), velocity, path)
        k = np.argmax(np.abs(sine))
        raise errors.NotKnownError(
            "speed must be slower, or the flight time later: no wind angle exists for a wind of"
            f" {speeds.flat[k]:.4g} m/s across a path at {np.degrees(paths.flat[k]):.4g} deg with"
            f" {velocities.flat[k]:.4g} m/s relative to the air, since speed"
            " sin(flight_path_angle) must stay below velocity"
        )
    return np.arcsin(sine)


def angle_in_plane(
    speed: ArrayLike, velocity: ArrayLike, attitude: ArrayLike, plane: str
) -> FloatArray:
    """Return the wind angle of attack [rad] in a plane, of a wind [m/s] along it.

    `velocity`: speed of the vehicle relative to the air [m/s]. In pitch the wind is along the
    flight, which climbs at its attitude [rad]; in yaw it is across, at right angles. `InputError`
    for a wind faster than the flight, which makes no wind angle.
    """
    return angle_from_speed(speed, velocity, np.pi / 2 if plane == "yaw" else attitude)


def sines_by_heading(heading: float, attitude: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return the sines of the wind angles in pitch and in yaw, divided by V_w/V_R.

    That is the wind speed over the speed of the vehicle relative to the air. `heading`: direction
    [rad] from which a horizontal wind blows, clockwise from the heading of the flight: pi is a tail
    wind, pi/2 a wind from the right. `attitude`: attitudes of flights above the horizontal [rad].
    Both results have the shape of `attitude`.
    """
    components = -np.cos(heading) * np.sin(attitude), np.sin(heading) + 0.0 * np.asarray(attitude)
    along, across = (np.where(np.abs(sine) < _AXIS_ROUNDING, 0.0, sine) for sine in components)
    return along, across


def angles_from_vector_size(
    peak: ArrayLike, heading: float, attitude: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return the wind angles [rad] in pitch and in yaw of winds by the size of their vector.

        sin(alpha_pitch) = -r cos(psi) sin(gamma),  sin(alpha_yaw) = r sin(psi),  r = V_w/V_R

    The ratio r of the wind's speed V_w to the airspeed V_R is solved for by Newton's method.
    `peak`: sizes [rad] of the vector of both angles; a negative size reverses the wind. `heading`:
    direction psi [rad] from which the wind blows, clockwise from the heading of the flight: pi is a
    tail wind. `attitude`: attitudes gamma above the horizontal [rad], which broadcast with the
    peaks. `InputError` for numbers that are not finite, for a wind along a level flight, which has
    no wind angle, and for a vector that no wind slower than the flight makes.
    """
    size, gamma = np.broadcast_arrays(
        errors.finite("peak", peak, "rad"), errors.directions("attitude", attitude)
    )
    along, across = sines_by_heading(
        errors.number("heading", heading, errors.directions, "rad"), gamma
    )
    if np.any((along == 0.0) & (across == 0.0)):
        raise errors.InputError(
            "a wind along a level flight has no wind angle; give another heading"
        )
    sines = np.stack([along, across])
    max_ratio = (1.0 - _AXIS_ROUNDING) / np.abs(sines).max(axis=0)
    ratio = np.minimum(np.abs(size) / np.hypot(along, across), max_ratio)
    for _ in range(_NEWTON_ITERATIONS):  # Newton on |alpha(r)|^2 = peak^2, which is convex in r
        angles = np.arcsin(ratio * sines)
        # half the derivative of |alpha|^2 with respect to r
        slope = np.sum(angles * sines / np.sqrt(1.0 - (ratio * sines) ** 2), axis=0)
        excess = np.sum(angles**2, axis=0) - size**2
        step = np.divide(excess, slope, out=np.zeros(size.shape), where=size != 0.0)
        ratio = np.minimum(ratio - 0.5 * step, max_ratio)
    single_plane = (along == 0.0) | (across == 0.0)  # exact in a single plane
    pitch, yaw = np.where(single_plane, np.sign(sines) * np.abs(size), np.arcsin(ratio * sines))
    if not np.allclose(np.hypot(pitch, yaw), np.abs(size), rtol=1e-9, atol=0.0):
        raise errors.NotKnownError(
            "peak must be an angle that a wind slower than the flight makes; got"
            f" {float(np.abs(size).max()):.6g} rad"
        )
    return np.copysign(1.0, size) * pitch, np.copysign(1.0, size) * yaw


def angles_from_speed(
    speed: float, velocity: float, attitude: float, heading: float
) -> tuple[float, float]:
    """Return the wind angles [rad] in pitch and in yaw of a horizontal wind, eq (B1e).

    `speed`, `velocity`: of the wind and of the vehicle relative to the air [m/s]. `attitude`:
    attitude above the horizontal [rad]. `heading`: direction [rad] from which the wind blows,
    clockwise from the heading of the flight. `InputError` for a wind faster than the flight.
    """
    sines = sines_by_heading(
        errors.number("heading", heading, errors.directions, "rad"), float(attitude)
    )
    wind = errors.number("speed", speed, unit="m/s")
    # eq (B1e) has sin(gamma) as a factor, which `sines` contain: so its gamma is 90 deg here
    pitch, yaw = (float(angle_from_speed(wind * sine, velocity, np.pi / 2)) for sine in sines)
    if (size := np.degrees(np.hypot(pitch, yaw))) >= 90.0:
        raise errors.NotKnownError(
            f"speed must make a vector of angles below 90 deg; got {size:.4g} deg"
        )
    return pitch, yaw


def within_linear(angles: ArrayLike) -> BoolArray:
    """Return whether angles of attack [rad] are at most `MAX_LINEAR_ANGLE`, in their shape."""
    return np.abs(np.asarray(angles)) <= MAX_LINEAR_ANGLE * (1.0 + _RELATIVE_ROUNDING)


def beyond_linear(angle: float, subject: str = WIND) -> str:
    """Return why nothing is known at an angle of attack [rad]; "" up to `MAX_LINEAR_ANGLE`.

    `subject`: beginning of the sentence, `WIND` or `ATTACK`.
    """
    if within_linear(angle):
        return ""
    return f"{subject} {np.degrees(abs(float(angle))):.4g} deg, and {BEYOND_LINEAR}"


def linear_notes(angle: float, subject: str = WIND) -> tuple[str, ...]:
    """Return a note on an angle of attack [rad] where linear theory is invalid, or doubtful.

    `subject`: beginning of the sentence, `WIND` or `ATTACK`. Empty for a small angle.
    """
    if beyond := beyond_linear(angle, subject):
        return (beyond,)
    if doubtfully_linear(angle):
        return (f"{subject} {np.degrees(abs(float(angle))):.4g} deg, and {DOUBTFUL}",)
    return ()


def doubtfully_linear(angle: float) -> bool:
    """Return whether an angle of attack [rad] is above `MAX_CERTAIN_ANGLE`."""
    return abs(float(angle)) > MAX_CERTAIN_ANGLE * (1.0 + _RELATIVE_ROUNDING)


def checked_linear(angle: float) -> float:
    """Return a wind angle [rad]; raise `NotKnownError` above `MAX_LINEAR_ANGLE`."""
    if beyond := beyond_linear(angle):
        raise errors.NotKnownError(beyond)
    return angle


@dataclass(frozen=True, eq=False)
class NominalWind:
    """Winds that end, as vehicles encounter them at nominal dynamic pressure: one, or ``(n,)``.

    `history`: wind angles of attack [rad].
    """

    history: History

    @property
    def count(self) -> int:
        """Number of winds."""
        return int(np.prod(self.history.batch))

    @property
    def calm(self) -> bool:
        """Whether there is no wind."""
        return not np.any(np.isfinite(self.history.onset))

    def at(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return wind angles of attack [rad], and ones, at times [s], ``(n, ...)`` each.

        The ones are the dynamic pressure over the nominal one, q/q_n. `times`: ``(n, ...)``, or
        ``(1, ...)`` for the same times of all n winds.
        """
        return _history_values(self.history, times), np.ones(times.shape)

    def between(self, start: float, stop: float) -> NominalWind:
        """Return the winds from a start to a stop time [s], zero before and after."""
        return NominalWind(self.history.before(stop) - self.history.before(start))

    def of(self, cases: IndexArray, count: int) -> NominalWind:
        """Return the winds of some cases, by their indices, of a batch of `count`."""
        history = self.history
        return NominalWind(history.cases(cases, (count,))) if history.batch else self


@dataclass(frozen=True, eq=False)
class EncounteredWind:
    """Winds that vehicles encounter on paths of constant angle: one wind, or a batch ``(n,)``.

    A wind has an angle, a speed, or is the sum of both. Its direction gives the fractions of either
    in pitch or along the path, and in yaw or across. It must end.

    `plane`: plane of the wind angles of attack. `path`: angle of each path above the horizontal
    [rad], ``(n,)`` or a common scalar. `angle`, `speed`: wind angles [rad], and wind speeds over
    the speed of the vehicle; None without. `of_angle`: fractions of the angle in pitch and in yaw,
    ``(n,)`` or common scalars. `of_speed`: fractions of the speed along the path, positive from
    behind, and across. `flight`: for a single wind times [s] of a flight, angles of its path [rad],
    and speeds of the vehicle over the speed by which `speed` is divided.
    """

    plane: str
    path: FloatArray
    angle: History | None
    speed: History | None
    of_angle: tuple[FloatArray, FloatArray]
    of_speed: tuple[float, float]
    flight: tuple[FloatArray, FloatArray, FloatArray] | None = None

    @property
    def history(self) -> History:
        """Sum of the histories of angle and speed: it has all breakpoints and terms of the wind.

        Its values have a meaning where the wind has an angle alone, or a speed alone.
        """
        if self.angle is None or self.speed is None:
            wind = self.angle if self.speed is None else self.speed
            assert wind is not None
            return wind
        return self.angle + self.speed

    def at(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return wind angles of attack [rad] and q/q_n of n winds at times [s], ``(n, ...)`` each.

        q/q_n is the dynamic pressure over the nominal one. Both are NaN where no horizontal wind
        along the path has the angle.
        """
        pitch, yaw, ratio = self._triangle(times)
        return (pitch if self.plane == "pitch" else yaw), ratio

    @property
    def largest_angle(self) -> FloatArray:
        """Largest size of the vector of both wind angles [rad], ``(n,)``.

        NaN where no horizontal wind along the path has the angle.
        """
        times = np.atleast_2d(self.history.probe_times())
        pitch, yaw, _ = self._triangle(times)
        return np.asarray(np.hypot(pitch, yaw).max(axis=-1))

    def _triangle(self, times: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return wind angles in pitch and in yaw [rad] and q/q_n at times [s], ``(n, ...)``.

        q/q_n is the dynamic pressure over the nominal one. The speed of a wind by its angle, of
        which `of_angle` gives the fractions in pitch and in yaw, adds to the angle of a wind by its
        speed, of which `of_speed` gives those along and across the path; angles and q/q_n are those
        of the sum. NaN where no horizontal wind along the path has the angle.
        """
        column = (-1, *[1] * (times.ndim - 1))  # one number for each wind and all of its times
        path, in_pitch, in_yaw = (np.reshape(x, column) for x in (self.path, *self.of_angle))
        angle, speed = (_history_values(x, times) for x in (self.angle, self.speed))
        # of a wind along a flight the path angle varies, and so does the speed of the vehicle
        if self.flight is not None:
            time, paths, speed_ratio = self.flight
            path = np.interp(times, time, paths)
            speed = speed / np.interp(times, time, speed_ratio)
        pitch, yaw = in_pitch * angle, in_yaw * angle
        if self.speed is None:  # both angles are given, and with them the speed of the air
            v = np.sin(path) / _sine_of_airspeed(path, pitch) if np.any(in_pitch) else 1.0
            known = np.where(np.isnan(v), np.nan, 1.0)
            airspeed = v / np.cos(yaw) if np.any(in_yaw) else v + 0.0 * yaw
            return known * pitch, known * yaw, airspeed**2
        along, across = (fraction * speed for fraction in self.of_speed)
        if np.any(pitch):
            along = along + along_from_angle(path, pitch)
        if np.any(yaw):
            # airspeed in the pitch plane, over the speed of the vehicle
            in_plane = np.sqrt((np.cos(path) - along) ** 2 + np.sin(path) ** 2)
            across = across + in_plane * np.tan(yaw)
        return wind_triangle(path, along, across)

    def check_linear(self) -> None:
        """Raise `NotKnownError` for wind angles above `MAX_LINEAR_ANGLE`, 30 degrees.

        `InputError` where no horizontal wind on the path has the angle.
        """
        self.check_possible()
        checked_linear(float(self.largest_angle.max()))

    def check_possible(self) -> None:
        """Raise `InputError` if no horizontal wind along the path, of any speed, has the angle.

        It is for a single wind, not a batch. The dynamic pressure ratio q/q_n is then NaN.
        """
        times = self.history.probe_times()[np.newaxis]
        _, ratio = self.at(times)
        if np.any(np.isnan(ratio)):
            in_pitch, _ = self.of_angle  # fractions of the wind angle in pitch and in yaw
            largest = np.degrees(np.abs(in_pitch * _history_values(self.angle, times)).max())
            paths = self.path if self.flight is None else self.flight[1]  # angles of the path
            raise errors.InputError(
                f"a wind of {largest:.4g} deg along the path has no dynamic pressure for a flight"
                f" at {np.degrees(np.min(paths)):.4g} deg: no horizontal wind turns it so far"
            )

    def shift(self, dt: float) -> EncounteredWind:
        """Return the winds delayed by `dt` [s]."""
        return self._with(lambda x: x.shift(dt))

    def between(self, start: float, stop: float) -> EncounteredWind:
        """Return the winds from a start to a stop time [s], zero before and after."""
        return self._with(lambda x: x.before(stop) - x.before(start))

    @property
    def count(self) -> int:
        """Number of winds, of which each may have its own path."""
        return max(np.size(self.history.onset), np.size(self.path))

    @property
    def calm(self) -> bool:
        """Whether the wind is zero throughout."""
        return not np.any(np.isfinite(self.history.onset))

    def _with(self, change: Callable[[History], History]) -> EncounteredWind:
        """Return the winds with angle and speed changed by a function of histories."""
        angle, speed = (None if x is None else change(x) for x in (self.angle, self.speed))
        return replace(self, angle=angle, speed=speed)

    def of(self, cases: IndexArray, count: int) -> EncounteredWind:
        """Return the winds of cases, by their indices, of a batch of `count`.

        Angles of the path, fractions of the wind angle, and histories of wind angle and wind speed
        are those of the cases; what all cases share stays.
        """

        def selected(x: FloatArray) -> FloatArray:
            """Return the numbers `x` of the cases; a scalar is the same in all."""
            return x[cases] if np.size(x) > 1 else x

        pitch, yaw = map(selected, self.of_angle)
        winds = replace(self, path=selected(self.path), of_angle=(pitch, yaw))
        return winds._with(lambda x: x.cases(cases, (count,)) if x.batch else x)


def _history_values(history: History | None, times: FloatArray) -> FloatArray:
    """Return values at times [s], ``(n, ...)``, of a batch ``(n,)`` of histories, or of one.

    `history`: None for zeros.
    """
    if history is None:
        return np.zeros(times.shape)
    # of one history the times of all winds in one row: they differ with the times of gusts
    flat = times.reshape(len(times), -1) if history.batch else times.ravel()
    values = np.real(pieces.value(history.pieces, flat))
    return np.asarray(values).reshape(-1, *times.shape[1:])
