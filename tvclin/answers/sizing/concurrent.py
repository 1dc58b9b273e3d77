"""Trim of winds that have their place in the flight, each wind angle with its own flight time.

A sounding meets the vehicle of each height with the wind of that height: what trim takes is
``|B(t) alpha_w(t)|``, and not the largest angle of the flight with the B of another time.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.answers.sizing.placing import PEAK, WindOf, given
from tvclin.ascent.measured_wind import MeasuredPlanes, MeasuredWind, gust_at
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.errors import NotKnownError
from tvclin.boundary.limit_shapes import LimitShape
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind

_TIMES_IN_INTERVAL = 33
"""Even times between two flight times, besides the samples, at which B alpha_w is evaluated."""


@dataclass(frozen=True, eq=False)
class ConcurrentTrim:
    """Largest trim ``|B(t) alpha_w(t)|`` of the times nearest to each flight time.

    `deflection` is that trim [rad], its gust included, and `time` its flight time [s], both
    ``(n, m)``; NaN for a wind whose peak is moved to the flight time, and where the wind is not
    known. For both planes the deflection is in the measure of the stop.
    """

    deflection: FloatArray
    time: FloatArray


def concurrent_trim(
    schedule: FlightSchedule,
    times: FloatArray,
    winds: Mapping[str, WindOf],
    placing: Mapping[str, str],
    planes: tuple[str, ...],
    stop: LimitShape,
    known: BoolArray,
) -> ConcurrentTrim:
    """Return the concurrent trim [rad] of winds at flight times [s], ``(n, m)``.

    `known` says where a wind can be sized, ``(n, m)``: where it cannot although it blows, as beyond
    linear aerodynamics, its trim is NaN.
    """
    ordered = np.sort(times)
    edges = np.concatenate([ordered[:1], 0.5 * (ordered[1:] + ordered[:-1]), ordered[-1:]])
    found = np.full((times.size, len(winds), 2), np.nan)
    for j, (name, wind) in enumerate(winds.items()):
        first, last = -np.inf, np.inf
        if isinstance(wind, MeasuredWind | MeasuredPlanes):
            first, last = wind.known
        elif placing[name] == PEAK:
            continue
        for i, k in enumerate(np.argsort(np.argsort(times)).tolist()):
            low, high = max(edges[k], first), min(edges[k + 1], last)
            steep = not known[i, j] and first <= times[i] <= last
            if low <= high and not steep:
                vehicle = schedule.at(float(times[i]))
                found[i, j] = _largest(schedule, wind, vehicle, planes, stop, (low, high))
    return ConcurrentTrim(found[..., 0], found[..., 1])


def _largest(
    schedule: FlightSchedule,
    wind: WindOf,
    vehicle: Vehicle,
    planes: tuple[str, ...],
    stop: LimitShape,
    interval: tuple[float, float],
) -> tuple[float, float]:
    """Return the largest trim [rad] of an interval of the flight, and its time [s]."""
    low, high = interval
    parts = {plane: _in_plane(wind, plane, vehicle) for plane in planes}
    samples = [schedule.times, *(one.probe_times() for one in parts.values() if one is not None)]
    bends = np.concatenate(samples)
    even = np.linspace(low, high, _TIMES_IN_INTERVAL)
    t = np.unique(np.concatenate([even, bends[(bends > low) & (bends < high)]]))
    held = schedule.clamped_at(t)
    slopes = {plane: np.asarray(Coefficients.from_vehicle(held, plane).B) for plane in planes}
    moments = [
        slopes[plane] * (0.0 if one is None else one(t)) + np.zeros(t.shape)
        for plane, one in parts.items()
    ]
    trim = np.abs(moments[0]) if len(moments) == 1 else stop.gauge(moments[0] + 1j * moments[1])
    trim = trim + np.max([np.abs(one) for one in slopes.values()], axis=0) * _gust(wind, vehicle)
    most = int(np.argmax(trim))
    return float(trim[most]), float(t[most])


def _in_plane(wind: Any, plane: str, vehicle: Vehicle) -> History | None:
    """Return the wind in one plane in flight time, without its gust; None where it is calm."""
    if isinstance(wind, MeasuredPlanes):
        part = wind.parts.get(plane)
        return None if part is None else part.wind
    if isinstance(wind, MeasuredWind):
        return wind.wind
    history = given(wind, vehicle)
    found: History = getattr(history, plane) if isinstance(history, PlaneWind) else history
    return found


def _gust(wind: Any, vehicle: Vehicle) -> float:
    """Return the peak angle [rad] of the gust of a measured wind; NaN where it is not known."""
    gust = getattr(wind, "gust", None)
    if gust is None:
        return 0.0
    try:
        return abs(float(gust_at(gust, vehicle).peak))
    except NotKnownError:
        return float("nan")
