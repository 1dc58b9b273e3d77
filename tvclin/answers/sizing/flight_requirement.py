"""What a wind requires of a vehicle along its flight, at the dynamic pressure encountered.

Parts of a flight in which the moment of a wind has the other sign are separate.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from tvclin.answers.sizing.flight_mode import FlightMode
from tvclin.answers.time_varying import varying_requirement
from tvclin.answers.varying_equations import (
    PRESSURES,
    Equations,
    at_pressure,
    has_quick_path,
    of_pressure,
)
from tvclin.answers.varying_minimum import unstable_modes_of
from tvclin.ascent.measured_wind import SoundingSpeeds
from tvclin.base.arrays import FloatArray
from tvclin.boundary.limit import leading_pole
from tvclin.winds.wind_angles import EncounteredWind, NominalWind

_SAMPLES_BETWEEN = 16
"""Times between breakpoints of a wind at which static trim is computed."""


@dataclass(frozen=True, eq=False)
class FlightEquations:
    """Linear equations of a vehicle along its flight.

    Beyond the last time with a real unstable mode they stay as they are there. The costate at the
    end of a wind is that of the rest of the flight.
    """

    mode: FlightMode

    @property
    def fastest(self) -> FloatArray:
        """Largest rate [1/s] of the attitude over the flight, ``(1,)``."""
        return np.array([self.mode.fastest])

    @property
    def breakpoints(self) -> FloatArray:
        """Times [s] of the schedule, between which the equations are smooth."""
        return self.mode.schedule.times

    def over(self, times: FloatArray) -> Equations:
        """Return the equations at times [s] of the steps of one wind, ``(1, S, 3)``."""
        flight, mode = self.mode.schedule, self.mode
        inside = np.minimum(times.ravel(), mode.last_unstable)
        plants = [
            replace(flight, vehicle=at_pressure(flight.vehicle, r)).plants(
                inside, mode.model, mode.plane
            )
            for r in PRESSURES
        ]
        nominal, slopes = of_pressure(plants)
        nominal, slopes = (
            np.broadcast_to(x, (inside.size, *x.shape[-k:])).reshape(*times.shape, *x.shape[-k:])
            for x, k in ((nominal, 2), (slopes, 3))
        )
        plant, order = plants[0], nominal.shape[-2]
        costate, reach = mode.at(times[0, -1, 2])
        paired = np.broadcast_to(leading_pole(plant)[1], inside.shape)
        return Equations(
            nominal,
            slopes,
            np.append(costate, reach)[np.newaxis],
            paired.reshape(times.shape),
            np.atleast_1d(np.any(has_quick_path(plant))),
            unstable_modes_of(nominal[:, -1, 2, :, :order]),
        )


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
    parts = mode.schedule.parts
    ends = [mode.span[0], *(part.span[0] for part in parts[1:]), mode.span[1]]
    begins, stops = float(wind.history.onset), float(wind.history.end)
    whole = not any(begins < end < stops for end in ends[1:-1])
    if whole:
        parts, ends = (mode.schedule,), list(mode.span)
    required, minimum, time = 0.0, 0.0, np.nan
    for part, (start, stop) in zip(parts, pairwise(ends), strict=True):
        inside = mode if whole else FlightMode(part, mode.model, mode.plane, (start, stop))
        blows = wind if whole else wind.between(start, stop)
        if inside.unstable and not blows.calm:
            found = varying_requirement(FlightEquations(inside), blows, dead_band)
            if not (np.isnan(required) or found.required[0] <= required):
                required, time = float(found.required[0]), float(found.time[0])
            minimum = max(minimum, float(found.minimum[0]))
    return required, minimum, time
