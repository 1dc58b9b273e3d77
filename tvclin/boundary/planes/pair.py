"""Both planes of one vehicle in one wind: what their modes ask for, as vectors pitch + j yaw."""

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

Ahead = Callable[[FloatArray], AnyArray]
"""A discounted future, of times [s]."""

_TOGETHER = 1e-4
_MOST_TIMES = 8192


@dataclass(frozen=True)
class Pair:
    """One plant for each plane, and one wind that ends.

    `plants`: of pitch and of yaw; the same one where the planes are equal.
    """

    plants: tuple[Plant, Plant]
    wind: PlaneWind

    @cached_property
    def poles(self) -> tuple[FloatArray, FloatArray]:
        """The unstable poles [1/s] of each plane, the fastest first."""
        pitch, yaw = (np.real(unstable_poles(plant)) for plant in self.plants)
        return pitch, yaw

    @cached_property
    def equal(self) -> bool:
        """Whether the two planes are one plant."""
        first, second = self.plants
        if first.model != second.model:
            return False
        known = [one.coefficients for one in self.plants]
        if first.model == "fixed-path":  # which has no gravity term
            known = [replace(one, q=0.0) for one in known]
        return first is second or known[0] == known[1]

    @cached_property
    def trim(self) -> PlaneWind:
        """The deflection that keeps the attitude [rad]."""
        winds = self.wind.pitch, self.wind.yaw
        pitch, yaw = (trim_deflection(*one) for one in zip(self.plants, winds, strict=True))
        return PlaneWind(pitch=pitch, yaw=yaw)

    @cached_property
    def _strengths(self) -> tuple[FloatArray, FloatArray]:
        """-B K1 p for every mode of each plane."""
        pitch, yaw = (
            np.asarray(-wind_over_deflection(plant, poles) * poles)
            for plant, poles in zip(self.plants, self.poles, strict=True)
        )
        return pitch, yaw

    @cached_property
    def _trim_ahead(self) -> tuple[Ahead, Ahead]:
        return self._ahead(self.trim)

    @cached_property
    def _wind_ahead(self) -> tuple[Ahead, Ahead]:
        return self._ahead(self.wind)

    def _ahead(self, both: PlaneWind) -> tuple[Ahead, Ahead]:
        """The discounted future in each plane, at its fast pole."""
        (p, *_), (r, *_) = self.poles
        return both.pitch.remaining_integral_of(p), both.yaw.remaining_integral_of(r)

    def held(self, t: FloatArray) -> Vectors:
        """Return what must be held from the times `t` [s] on: discounted means of trim, eq (4b)."""
        (p, *_), (r, *_) = self.poles
        pitch, yaw = self._trim_ahead
        return np.asarray(p * pitch(t) + 1j * r * yaw(t))

    def demanded(self, t: FloatArray) -> Vectors:
        """Return what the wind after the times `t` [s] alone asks for at the fast modes [rad]."""
        (p, *_), (r, *_) = self._strengths
        pitch, yaw = self._wind_ahead
        return np.asarray(p * pitch(t) + 1j * (r * yaw(t)))

    def of_modes(self, plane: int, t: FloatArray) -> FloatArray:
        """Return the same, -B K1 W, for every mode of one plane, ``(N, n)``."""
        wind = (self.wind.pitch, self.wind.yaw)[plane]
        return self._strengths[plane][:, np.newaxis] * wind.remaining_integral(self.poles[plane], t)

    def left_at(self, plane: int, t: float) -> FloatArray:
        """Return what every mode of one plane asks for when trim is left at `t` [s], ``(N,)``."""
        trim, poles = (self.trim.pitch, self.trim.yaw)[plane], self.poles[plane]
        return poles * np.asarray(trim.remaining_integral(poles, np.asarray([t])))[:, 0]

    def decayed(self, vector: Vectors, time: FloatArray) -> Vectors:
        """Return vectors times e^(-p time), each part with the fast pole of its plane."""
        pitch, yaw = (np.exp(-p[0] * time) for p in self.poles)
        return np.asarray(np.real(vector) * pitch + 1j * np.imag(vector) * yaw)

    def of_moment(self, t: FloatArray) -> Vectors:
        """Return -B alpha_w [rad], with which the report's switch compares."""
        pitch, yaw = (plant.coefficients.B for plant in self.plants)
        w = self.wind(t)
        return np.asarray(-pitch * np.real(w) - 1j * yaw * np.imag(w))

    def times(self) -> FloatArray:
        """Return times [s] that show the wind: its knots on both sides, and many between."""
        found = []
        for one in (self.wind.pitch, self.wind.yaw):
            swing = np.abs(one.pieces.rates).max(initial=0.0) * np.diff(one.knots).max(initial=0.0)
            most = max(_MOST_TIMES // one.knots.size, 8)
            found.append(one.probe_times(int(np.clip(8.0 * swing, min(64, most), most))))
        every = np.unique(np.concatenate(found))
        return every[(every >= self.wind.onset) & (every <= self.wind.end)]


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
    for name, one in plants.items():
        poles = unstable_poles(one)
        real = poles.size > 0 and not np.any(np.imag(poles))
        if not real or np.any(np.isnan(poles[..., 0])):
            kept = "it has none" if not poles.size else "a pair in two planes is not treated"
            has = kept if one.batch else f"it has {poles_text(poles)}"
            raise InputError(f"{name} must have unstable poles, all real; {has}")
        if np.any(poles[..., 1:] > (1.0 - _TOGETHER) * poles[..., :1]):
            raise InputError(f"{name} must have a fastest pole that is single; two are together")
        if np.any(np.asarray(one.coefficients.B) == 0.0):
            raise InputError(f"{name} must have an aerodynamic moment, mu_alpha other than zero")
    return broadcast(wind=wind.batch, **{name: one.batch for name, one in plants.items()})
