"""The U.S. Standard Atmosphere 1976 up to 86 km.

Source: U.S. Standard Atmosphere, 1976 (NOAA-S/T 76-1562), table 4 (the layers, by geopotential
height) and section 1.2 (constants); temperature is linear in each layer and the air at rest.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from math import exp, log1p

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import within
from tvclin.base.package_warnings import ImplausibleInput
from tvclin.vehicle.vehicle import STANDARD_GRAVITY

HIGHEST = 86_000.0
"""Highest altitude [m]."""
LOWEST = -5_000.0
"""Lowest altitude [m], to which the first layer is continued."""
_MAX_PRESSURE_ERROR, _SURELY_ANOTHER_UNIT = 0.1, 0.5
"""Largest relative difference of a dynamic pressure from standard air without a note, and the
smallest that another atmosphere does not explain."""
_CONTINUATION = 14_000.0
"""Height [m] over which both ends of the range are continued; beyond it the air is constant."""
_EARTH_RADIUS = 6_356_766.0
_GAS_CONSTANT = 8.31432 / 28.9644e-3
_RATIO_OF_SPECIFIC_HEATS = 1.4
_BASES = np.array([0.0, 11e3, 20e3, 32e3, 47e3, 51e3, 71e3])
LAYER_ALTITUDES = _EARTH_RADIUS * _BASES / (_EARTH_RADIUS - _BASES)
"""Geometric altitudes [m] at which layers of the atmosphere begin, its corners."""
_LAPSES = np.array([-6.5e-3, 0.0, 1.0e-3, 2.8e-3, 0.0, -2.8e-3, -2.0e-3])
_SEA_TEMPERATURE, _SEA_PRESSURE = 288.15, 101_325.0


@dataclass(frozen=True, eq=False)
class Air:
    """Air at some altitudes; every field has their shape.

    `temperature`: [K]. `pressure`: [Pa]. `density`: [kg/m^3].
    """

    temperature: FloatArray
    pressure: FloatArray
    density: FloatArray


def standard_atmosphere(altitude: ArrayLike) -> Air:
    """Return the air at geometric altitudes [m] above the sea; `InputError` beyond -5 to 86 km.

    Examples
    --------
    >>> from tvclin.ascent.atmosphere import standard_atmosphere
    >>> round(float(standard_atmosphere(10_000.0).density), 5)
    0.41351
    """
    return air_at(within("altitude", altitude, LOWEST, HIGHEST, "m"))


def air_at(altitude: FloatArray) -> Air:
    """Return the air at geometric altitudes [m], in their shape.

    The outermost layers are continued beyond -5 and 86 km by `_CONTINUATION`; beyond that the air
    is constant.
    """
    altitude = np.clip(altitude, LOWEST - _CONTINUATION, HIGHEST + _CONTINUATION)
    height = _EARTH_RADIUS * altitude / (_EARTH_RADIUS + altitude)  # geopotential
    temperatures, pressures = _bases()
    layer = np.clip(np.searchsorted(_BASES, height, side="right") - 1, 0, _BASES.size - 1)
    # temperature [K] and its slope [K/m] at the bottom of the layer, and height above it [m]
    base, lapse, above = temperatures[layer], _LAPSES[layer], height - _BASES[layer]
    temperature = base + lapse * above
    pressure = pressures[layer] * np.exp(-_log_pressure_drop(base, lapse, above))
    density = pressure / (_GAS_CONSTANT * temperature)
    return Air(temperature=temperature, pressure=pressure, density=density)


def pressure_notes(
    times: FloatArray, pressure: FloatArray, speed: FloatArray, altitude: FloatArray
) -> Iterator[ImplausibleInput]:
    """Yield a note where a dynamic pressure contradicts speed and altitude, in standard air.

    `times`: flight times [s], NaN for one that is not known. `pressure`: dynamic pressure [Pa].
    `speed`: airspeed [m/s]. `altitude`: geometric altitude [m]. All are ``(n,)``.
    """
    standard = 0.5 * air_at(altitude).density * speed**2
    excess = np.abs(pressure / np.maximum(standard, np.finfo(float).tiny) - 1.0)
    worst = int(np.argmax(excess))
    if excess[worst] > _MAX_PRESSURE_ERROR:
        another_unit = excess[worst] > _SURELY_ANOTHER_UNIT
        doubt = (
            "a unit may be wrong"
            if another_unit
            else "the altitude, from the sea, or the speed may be wrong, or the air not standard"
        )
        at = "" if np.isnan(times[worst]) else f" at {times[worst]:.6g} s"
        yield ImplausibleInput(
            f"the dynamic pressure{at} is {pressure[worst]:.4g} Pa, and speed and altitude give"
            f" {standard[worst]:.4g} Pa in the standard atmosphere: {doubt}"
        )


def speed_of_sound(air: Air) -> FloatArray:
    """Return the speed of sound [m/s] in air."""
    return np.sqrt(_RATIO_OF_SPECIFIC_HEATS * _GAS_CONSTANT * air.temperature)


def density_at(altitude: float) -> float:
    """Return the density [kg/m^3] of the standard atmosphere at one geometric altitude [m].

    Plain arithmetic, for every step of a flight. The outermost layers are continued (`air_at`).
    """
    altitude = min(max(altitude, LOWEST - _CONTINUATION), HIGHEST + _CONTINUATION)
    height = _EARTH_RADIUS * altitude / (_EARTH_RADIUS + altitude)  # geopotential
    # height, temperature and pressure at the bottom of the layer, and slope of the temperature
    bottom, base, pressure, lapse = _layers()[max(bisect_right(_BASES, height) - 1, 0)]
    above = height - bottom
    ratio = lapse * above / base
    mean = log1p(ratio) / ratio if ratio else 1.0  # of base/T over the height above the bottom
    pressure *= exp(-STANDARD_GRAVITY * above / (_GAS_CONSTANT * base) * mean)
    return pressure / (_GAS_CONSTANT * (base + lapse * above))


def _log_pressure_drop(base: FloatArray, lapse: FloatArray, above: FloatArray) -> FloatArray:
    """Return ln(p_bottom/p) of pressures within a layer: the integral of g/(R T) over height.

    `base`: temperature [K] at the bottom. `lapse`: its slope [K/m]. `above`: height above it [m].
    """
    ratio = lapse * above / base
    with np.errstate(divide="ignore", invalid="ignore"):  # mean of base/T over the height above
        mean = np.where(ratio == 0.0, 1.0, np.log1p(ratio) / ratio)
    return STANDARD_GRAVITY * above / (_GAS_CONSTANT * base) * mean


@cache
def _layers() -> list[list[float]]:
    """Return geopotential height [m], temperature [K], pressure [Pa] and lapse rate of layers.

    One row for each layer, with the values at its bottom. The lapse rate is the slope of the
    temperature over height [K/m].
    """
    return np.column_stack([_BASES, *_bases(), _LAPSES]).tolist()


@cache
def _bases() -> tuple[FloatArray, FloatArray]:
    """Return temperature [K] and pressure [Pa] at the base of each layer, ``(layers,)``."""
    thickness = np.diff(_BASES)
    temperatures = _SEA_TEMPERATURE + np.concatenate([[0.0], np.cumsum(_LAPSES[:-1] * thickness)])
    drops = _log_pressure_drop(temperatures[:-1], _LAPSES[:-1], thickness)
    return temperatures, _SEA_PRESSURE * np.exp(-np.concatenate([[0.0], np.cumsum(drops)]))
