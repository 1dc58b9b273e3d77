"""Required deflection of a wind along a flight, at the dynamic pressure encountered.

Parts of a flight in which the moment of a wind has the other sign are separate.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from tvclin.answers.sizing.flight_mode import FlightMode
from tvclin.answers.time_varying import varying_requirement
from tvclin.ascent.measured_wind import SoundingSpeeds
from tvclin.base.arrays import FloatArray
from tvclin.winds.wind_angles import EncounteredWind, NominalWind

_SAMPLES_BETWEEN = 16
"""Times between breakpoints of a wind at which static trim is computed."""


@dataclass(frozen=True, eq=False)
class FlightWind(NominalWind):
    """A wind in flight time, as a vehicle encounters it with the wind of a sounding.

    Attributes
    ----------
    history : History
        Wind angles [rad] at the nominal speed of the flight, eq (B1e).
    plane : str
        Plane of these angles.
    speeds : SoundingSpeeds
        The wind of both planes.
    """

    plane: str
    speeds: SoundingSpeeds

    def at(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return wind angles of attack [rad] and q/q_n at times [s], by the wind triangle."""
        return self.speeds.encountered(self.plane, super().at(times)[0], times)

    def between(self, start: float, stop: float) -> FlightWind:
        """Return the wind from a time to another [s], and none before and after."""
        return replace(self, history=super().between(start, stop).history)


@dataclass(frozen=True, eq=False)
class FlightRequirement:
    """Deflections [rad] that one wind requires of a vehicle along its flight, as sizes.

    Attributes
    ----------
    trim : float
        Static trim: the largest ``|B(t) alpha_w(t)|`` at nominal dynamic pressure, without drift.
    required : ndarray
        Required deflection at each dead band, ``(k,)``; NaN with K < 1 for a wind that changes its
        sign.
    minimum : float
        Lower bound with the wind known, to both sides, over all unstable modes.
    trim_time : float
        Time [s] of the largest static trim.
    times : ndarray
        Times [s] at which the dead bands are left with the required limits, ``(k,)``.
    """

    trim: float
    required: FloatArray
    minimum: float
    trim_time: float
    times: FloatArray


def flight_requirement(
    mode: FlightMode, wind: NominalWind, dead_bands: FloatArray, whole: NominalWind | None = None
) -> FlightRequirement:
    """Return the deflections that a wind requires of a vehicle along its flight.

    Parameters
    ----------
    mode : FlightMode
        The flight, with a span that covers the wind.
    wind : NominalWind or FlightWind
        One wind that ends.
    dead_bands : ndarray
        K, each in [0, 1], ``(k,)``.
    whole : NominalWind or FlightWind, optional
        The same with what blows to the other side, where `wind` is its part to one: what a law with
        K = 1 encounters.
    """
    times = wind.history.probe_times(_SAMPLES_BETWEEN)
    trim = np.abs(mode.trim_per_wind(times) * wind.history(times))
    trimmed = requirement_of_parts(mode, whole or wind, 1.0)
    required, _, exits = np.transpose(
        [trimmed if K == 1.0 else requirement_of_parts(mode, wind, K) for K in dead_bands.tolist()]
    )
    largest = int(np.argmax(trim))
    return FlightRequirement(
        float(trim[largest]), required, trimmed[1], float(times[largest]), exits
    )


def requirement_of_parts(
    mode: FlightMode, wind: NominalWind | EncounteredWind, dead_band: float
) -> tuple[float, float, float]:
    """Return required deflection and minimum [rad], and the exit time [s], of parts of a flight.

    The larger of all parts; the time is that of the part that requires most.
    """
    parts = mode.schedule.one_sign_intervals
    ends = [mode.span[0], *(part.span[0] for part in parts[1:]), mode.span[1]]
    begins, stops = float(wind.history.onset), float(wind.history.end)
    whole = not any(begins < end < stops for end in ends[1:-1])
    if whole:
        parts, ends = (mode.schedule,), list(mode.span)
    required, minimum, time = 0.0, 0.0, np.nan
    for part, (start, stop) in zip(parts, pairwise(ends), strict=True):
        inside = mode if whole else FlightMode(part, mode.model, mode.plane, (start, stop))
        inner = wind if whole else wind.between(start, stop)
        if inside.unstable and not inner.calm:
            result = varying_requirement(inside, inner, dead_band)
            if not (np.isnan(required) or result.required[0] <= required):
                required, time = float(result.required[0]), float(result.time[0])
            minimum = max(minimum, float(result.minimum[0]))
    return required, minimum, time
