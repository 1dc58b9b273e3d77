"""Both planes of one vehicle in one wind: demands of their modes, as vectors pitch + j yaw."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray
from tvclin.base.errors import InputError, broadcast, ending, instance
from tvclin.boundary.stops import Stop, Vectors
from tvclin.linear.deflections import trim_deflection
from tvclin.linear.modes import poles_text, unstable_poles, wind_over_deflection
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind

RemainingIntegral = Callable[[FloatArray], AnyArray]
"""A discounted integral from times [s] to the end of the wind."""

_MIN_POLE_SEPARATION = 1e-4
"""Smallest distance between the two fastest poles, relative to the fastest."""
_MAX_TIMES = 8192
"""Largest number of times at which a wind is computed, in each plane."""


@dataclass(frozen=True)
class Pair:
    """A plant for each plane, and a wind that ends.

    `plants`: of pitch and of yaw; the same one where the planes are equal.
    """

    plants: tuple[Plant, Plant]
    wind: PlaneWind

    @cached_property
    def poles(self) -> tuple[FloatArray, FloatArray]:
        """Unstable poles [1/s] of each plane, the fastest first."""
        pitch, yaw = (np.real(unstable_poles(plant)) for plant in self.plants)
        return pitch, yaw

    @cached_property
    def equal(self) -> bool:
        """Whether the two planes are one plant."""
        first, second = self.plants
        if first.model != second.model:
            return False
        coefficients = [plant.coefficients for plant in self.plants]
        if first.model == "fixed-path":  # which has no gravity term
            coefficients = [replace(plane, q=0.0) for plane in coefficients]
        return first is second or coefficients[0] == coefficients[1]

    @cached_property
    def trim(self) -> PlaneWind:
        """Trim deflection [rad], which keeps the attitude."""
        winds = self.wind.pitch, self.wind.yaw
        pitch, yaw = (trim_deflection(*plane) for plane in zip(self.plants, winds, strict=True))
        return PlaneWind(pitch=pitch, yaw=yaw)

    @cached_property
    def _strengths(self) -> tuple[FloatArray, FloatArray]:
        """Factors -B K1 p [1/s] of every mode of each plane, ``(N,)``."""
        pitch, yaw = (
            np.asarray(-wind_over_deflection(plant, poles) * poles)
            for plant, poles in zip(self.plants, self.poles, strict=True)
        )
        return pitch, yaw

    @cached_property
    def _trim_integrals(self) -> tuple[RemainingIntegral, RemainingIntegral]:
        """Remaining integral of trim [rad s] in each plane."""
        return self._remaining_integrals(self.trim)

    @cached_property
    def _wind_integrals(self) -> tuple[RemainingIntegral, RemainingIntegral]:
        """Remaining integral of the wind angle [rad s] in each plane."""
        return self._remaining_integrals(self.wind)

    def _remaining_integrals(
        self, history: PlaneWind
    ) -> tuple[RemainingIntegral, RemainingIntegral]:
        """Return the discounted remaining integral in each plane, at its fast pole."""
        (p, *_), (r, *_) = self.poles
        return history.pitch.remaining_integral_of(p), history.yaw.remaining_integral_of(r)

    def required_constant(self, t: FloatArray) -> Vectors:
        """Return the constant deflection [rad] required after `t` [s], the mean of trim, (4b)."""
        (p, *_), (r, *_) = self.poles
        pitch, yaw = self._trim_integrals
        return np.asarray(p * pitch(t) + 1j * r * yaw(t))

    def wind_demand(self, t: FloatArray) -> Vectors:
        """Return the demand [rad] of the wind after the times `t` [s] at the fast modes."""
        (p, *_), (r, *_) = self._strengths
        pitch, yaw = self._wind_integrals
        return np.asarray(p * pitch(t) + 1j * (r * yaw(t)))

    def mode_demands(self, plane: int, t: FloatArray) -> FloatArray:
        """Return the wind demand -B K1 W [rad] of every mode of one plane, ``(N, n)``."""
        wind = (self.wind.pitch, self.wind.yaw)[plane]
        return self._strengths[plane][:, np.newaxis] * wind.remaining_integral(self.poles[plane], t)

    def demands_after_trim(self, plane: int, t: float) -> FloatArray:
        """Return the demand [rad] of every mode of one plane after trim up to `t` [s], ``(N,)``."""
        trim, poles = (self.trim.pitch, self.trim.yaw)[plane], self.poles[plane]
        return poles * np.asarray(trim.remaining_integral(poles, np.asarray([t])))[:, 0]

    def decayed(self, vector: Vectors, time: FloatArray) -> Vectors:
        """Return vectors times e^(-p time), each component with the fast pole of its plane."""
        pitch, yaw = (np.exp(-p[0] * time) for p in self.poles)
        return np.asarray(np.real(vector) * pitch + 1j * np.imag(vector) * yaw)

    def moment_driver(self, t: FloatArray) -> Vectors:
        """Return the driver -B alpha_w [rad] of the report's exit on wind."""
        pitch, yaw = (plant.coefficients.B for plant in self.plants)
        w = self.wind(t)
        return np.asarray(-pitch * np.real(w) - 1j * yaw * np.imag(w))

    def times(self) -> FloatArray:
        """Return times [s] that resolve the wind: its breakpoints, both sides, and more."""
        times = []
        for history in (self.wind.pitch, self.wind.yaw):
            oscillation = np.abs(history.pieces.rates).max(initial=0.0) * np.diff(
                history.knots
            ).max(initial=0.0)
            most_points = max(_MAX_TIMES // history.knots.size, 8)
            times.append(
                history.probe_times(
                    int(np.clip(8.0 * oscillation, min(64, most_points), most_points))
                )
            )
        merged = np.unique(np.concatenate(times))
        return merged[(merged >= self.wind.onset) & (merged <= self.wind.end)]


def checked(plant: Plant, wind: PlaneWind, stop: Stop, yaw_plant: Plant | None) -> tuple[int, ...]:
    """Return the shape of the batch; `InputError` for what has no limit in two planes."""
    instance("plant", plant, Plant, "see Plant.from_vehicle")
    if isinstance(wind, History):
        raise InputError(
            "wind must have a direction: give PlaneWind.towards(wind, angle), or a pitch and a yaw"
            " history"
        )
    instance("wind", wind, PlaneWind, "see PlaneWind.towards")
    instance("stop", stop, Stop, "such as CircularStop")
    plants = {"plant": plant}
    if yaw_plant is not None:
        instance("yaw_plant", yaw_plant, Plant, "see Plant.from_vehicle")
        plants["yaw_plant"] = yaw_plant
    ending("wind", wind.end)
    for name, plane_plant in plants.items():
        poles = unstable_poles(plane_plant)
        real = poles.size > 0 and not np.any(np.imag(poles))
        if not real or np.any(np.isnan(poles[..., 0])):
            reason = "it has none" if not poles.size else "a pair in two planes is not treated"
            message = reason if plane_plant.batch else f"it has {poles_text(poles)}"
            raise InputError(f"{name} must have unstable poles, all real; {message}")
        if np.any(poles[..., 1:] > (1.0 - _MIN_POLE_SEPARATION) * poles[..., :1]):
            raise InputError(f"{name} must have a fastest pole that is single; two are together")
        if np.any(np.asarray(plane_plant.coefficients.B) == 0.0):
            raise InputError(f"{name} must have an aerodynamic moment, mu_alpha other than zero")
    return broadcast(
        wind=wind.batch, **{name: plane_plant.batch for name, plane_plant in plants.items()}
    )
