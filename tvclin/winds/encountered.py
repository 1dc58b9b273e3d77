"""Winds as vehicles encounter them: wind angles of attack and dynamic pressure over time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray, IndexArray
from tvclin.base.errors import InputError
from tvclin.numerics import pieces
from tvclin.winds.histories import History
from tvclin.winds.triangle import along_from_angle, wind_triangle


@dataclass(frozen=True, eq=False)
class EncounteredWind:
    """Winds that end, of vehicles on paths of constant angle: one, or a batch ``(n,)``.

    A wind is known by its angle, by its speed, or is a sum of both. Its direction says which
    fraction of either lies in pitch or along the path, and which in yaw or across.

    Attributes
    ----------
    plane : str
        Plane of the wind angles of attack.
    path : ndarray
        Angle of each path above the horizontal [rad], ``(n,)`` or one for all.
    angle, speed : History or None
        Wind angles [rad], and wind speeds over that of the vehicle.
    of_angle : tuple of ndarray
        Fractions of the angle in pitch and in yaw, ``(n,)`` or one for all.
    of_speed : tuple of float
        Fractions of the speed along the path, positive from behind, and across.
    flight : tuple of ndarray, optional
        Of one wind in a flight: times [s], and there the angle of the path [rad] and the speed of
        the vehicle over that by which `speed` is divided.
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
        """A history with the breakpoints and rates of the wind; values may mix angle and speed."""
        if self.angle is None or self.speed is None:
            whole = self.angle if self.speed is None else self.speed
            assert whole is not None
            return whole
        return self.angle + self.speed

    def at(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return wind angles of attack [rad] and q/q_n at times [s], ``(n, ...)``.

        Both are NaN where no horizontal wind along the path has the angle.
        """
        path, in_pitch, in_yaw = (_column(x, times) for x in (self.path, *self.of_angle))
        angle, speed = (_values(x, times) for x in (self.angle, self.speed))
        if self.flight is not None:
            time, paths, faster = self.flight
            path = np.interp(times, time, paths)
            speed = speed / np.interp(times, time, faster)
        along, across = self.of_speed[0] * speed, self.of_speed[1] * speed
        if self.angle is not None and np.any(in_pitch):
            along = along + along_from_angle(path, in_pitch * angle)
        if self.angle is not None and np.any(in_yaw):
            in_plane = np.sqrt((np.cos(path) - along) ** 2 + np.sin(path) ** 2)
            across = across + in_plane * np.tan(in_yaw * angle)
        pitch, yaw, ratio = wind_triangle(path, along, across)
        return (pitch if self.plane == "pitch" else yaw), ratio

    def check_possible(self) -> None:
        """Raise `InputError` where one wind along the path has an angle that no wind makes."""
        times = self.history.probe_times()[np.newaxis]
        if np.any(np.isnan(self.at(times)[1])):
            most = np.degrees(np.abs(self.of_angle[0] * _values(self.angle, times)).max())
            paths = self.path if self.flight is None else self.flight[1]
            raise InputError(
                f"a wind of {most:.4g} deg along the path has no dynamic pressure for a flight at"
                f" {np.degrees(np.min(paths)):.4g} deg: no horizontal wind turns it so far"
            )

    def shift(self, dt: float) -> EncounteredWind:
        """Return the same winds, later by `dt` [s]."""
        return self._with(lambda x: x.shift(dt))

    def between(self, start: float, stop: float) -> EncounteredWind:
        """Return the winds from a time to another [s], and none before and after."""
        return self._with(lambda x: x.before(stop) - x.before(start))

    @property
    def calm(self) -> bool:
        """Whether there is no wind."""
        return not np.any(np.isfinite(self.history.onset))

    def _with(self, change: Callable[[History], History]) -> EncounteredWind:
        angle, speed = (None if x is None else change(x) for x in (self.angle, self.speed))
        return replace(self, angle=angle, speed=speed)

    def of(self, cases: IndexArray, count: int) -> EncounteredWind:
        """Return the winds of some cases of a batch of so many."""

        def some(x: FloatArray) -> FloatArray:
            return x[cases] if np.size(x) > 1 else x

        def winds(x: History | None) -> History | None:
            return None if x is None or not x.batch else x.some(cases, (count,))

        return replace(
            self,
            path=some(self.path),
            angle=winds(self.angle) or self.angle,
            speed=winds(self.speed) or self.speed,
            of_angle=(some(self.of_angle[0]), some(self.of_angle[1])),
        )


def _column(x: Any, times: FloatArray) -> FloatArray:
    """Return numbers ``(n,)`` with an axis for each further one of the times."""
    return np.reshape(x, (-1,) + (1,) * (times.ndim - 1))


def _values(history: History | None, times: FloatArray) -> FloatArray:
    """Return values of histories at times ``(n, ...)``; zeros without one."""
    if history is None:
        return np.zeros(times.shape)
    flat = times.reshape(len(times), -1)
    found = np.real(pieces.value(history.pieces, flat if history.batch else flat[0]))
    return np.asarray(found).reshape(-1, *times.shape[1:])
