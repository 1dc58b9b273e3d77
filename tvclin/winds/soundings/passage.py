"""When a flight meets each level of a wind, and at which wind angle."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.errors import InputError, directions, positive, within
from tvclin.winds.speed import angle_from_speed

_FIELDS = {"time": "s", "height": "m", "speed": "m/s", "flight_path_angle": "rad"}
_FAR = 1e9


class Flown(Protocol):
    """A flight as arrays over its time, each of the shape ``(n,)``."""

    @property
    def time(self) -> Any:
        """[s]."""

    @property
    def height(self) -> Any:
        """[m]."""

    @property
    def speed(self) -> Any:
        """[m/s]."""

    @property
    def flight_path_angle(self) -> Any:
        """[rad]."""


def angles_along(
    flight: Flown, height: FloatArray, wind: FloatArray, plane: str, largest: float | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return times [s] and wind angles [rad] of a flight through a wind [m/s] over heights [m].

    The flight is straight between its times. In yaw the wind meets it at right angles. With a
    `largest` angle [rad], the longest time that stays below it alone.
    """
    time, path, speed, climb = checked_flight(flight)
    low, high = max(height[0], path[0]), min(height[-1], path[-1])
    if not low < high:
        raise InputError(
            f"the flight does not reach the wind: it goes from {path[0]:.6g} to {path[-1]:.6g} m,"
            f" and the wind is known from {height[0]:.6g} to {height[-1]:.6g} m"
        )
    met = np.concatenate([height, path])
    met = np.unique(np.concatenate([met[(met > low) & (met < high)], [low, high]]))
    when, known = np.interp(met, path, time), np.interp(met, height, wind)
    apart = np.append(True, np.diff(when) > 0.0)
    when, known = when[apart], known[apart]
    angle = np.pi / 2 if plane == "yaw" else np.interp(when, time, climb)
    flown = np.interp(when, time, speed)
    sine = np.abs(known * np.sin(angle)) / flown
    if largest is not None:
        flat = longest_run(when, sine <= np.sin(largest))
        if flat.stop - flat.start < 2:
            raise InputError(
                f"the wind meets the flight at more than {np.degrees(largest):.3g} deg all the way,"
                " of which linear aerodynamics says nothing"
            )
        angle = np.broadcast_to(angle, when.shape)
        return when[flat], angle_from_speed(known[flat], flown[flat], angle[flat])
    if np.any(sine >= 1.0):
        slow = met[apart][sine >= 1.0]
        raise InputError(
            f"the wind is faster than the flight can meet, first at {slow[0]:.6g} m; leave out the"
            f" slow part of the flight with profile.between({slow[-1]:.6g}, ...)"
        )
    return when, angle_from_speed(known, flown, angle)


def longest_run(times: FloatArray, good: BoolArray) -> slice:
    """Return the places of the longest time in which all is good."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(int)))
    runs = [slice(a, b) for a, b in ends.reshape(-1, 2).tolist()]
    return max(runs, key=lambda one: times[one.stop - 1] - times[one.start], default=slice(0, 0))


def checked_flight(flight: Flown) -> list[FloatArray]:
    """Return the four arrays of a flight; `InputError` where they are none, or do not ascend."""
    try:
        given = {name: getattr(flight, name) for name in _FIELDS}
    except AttributeError:
        raise InputError(
            f"flight must have arrays {', '.join(_FIELDS)} (see steady_climb); got"
            f" {type(flight).__name__}"
        ) from None
    arrays = [within(name, given[name], -_FAR, _FAR, unit) for name, unit in _FIELDS.items()]
    directions("flight_path_angle", arrays[3])
    shape = arrays[0].shape
    if len(shape) != 1 or shape[0] < 2 or any(array.shape != shape for array in arrays):
        raise InputError(
            f"{', '.join(_FIELDS)} of a flight must be arrays of one length, two or more; got"
            f" {', '.join(str(array.shape) for array in arrays)}"
        )
    for name, array in zip(("time", "height"), arrays, strict=False):
        wrong = np.diff(array) <= 0.0
        if np.any(wrong):
            raise InputError(
                f"{name} of a flight must ascend; it does not at index {wrong.argmax()}"
            )
    positive("speed", arrays[2], "m/s")
    return arrays
