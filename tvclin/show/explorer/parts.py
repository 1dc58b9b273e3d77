"""The parts of an answer, each kept by the numbers that it depends on and by no others.

Margins do not depend on the wind, nor the curve of the boundary on the duration: what did not
change is not computed again.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache, wraps
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.answers.requirement import required_deflection
from tvclin.base.errors import InputError, one_of
from tvclin.base.warned import warned
from tvclin.boundary.closed_forms import rectangular_limit, triangular_limit
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.gains import half_relief_gains
from tvclin.control.laws.law import Law, seen_coordinates
from tvclin.control.laws.registry import AUTOPILOT, DEAD_BAND, design_law
from tvclin.control.margins.record import Margins
from tvclin.flights.closed_loop.fly import fly
from tvclin.kernels.choice import compiling_nothing
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_responses
from tvclin.show.explorer.choices import CONTROLS, HALF_RELIEF, REPORT
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.shaped import PULSES

FloatArray = NDArray[np.float64]

LONGEST = 30.0
"""Longest wind [s] of the curve."""
DURATIONS = LONGEST * np.linspace(0.05, 1.0, 30) ** 1.5
SAMPLE_RATE = 20.0
"""Samples of a flown law [Hz], where the vehicle is no faster than 1/s."""
_AFTER, _LONGEST_AFTER = 6.0, 20.0
"""A response is followed so long after the wind, times beta, and at most so many seconds."""
_KEPT = 512


@dataclass(frozen=True, eq=False)
class Part:
    """What was found, None where there is no answer, and what is to be said of it."""

    value: Any
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Motion:
    """A response or a flight over time.

    Attributes
    ----------
    time, wind, attitude, deflection : ndarray
        Times [s] and angles [rad], ``(n,)``.
    survived : bool or None
        Whether what is left at the end can still be brought back; None where nothing can be said,
        and for the report's control, which is judged by its boundary.
    """

    time: FloatArray
    wind: FloatArray
    attitude: FloatArray
    deflection: FloatArray
    survived: bool | None


def _part(compute: Callable[..., Any]) -> Callable[..., Part]:
    """Keep what is found, with warnings and refusals as sentences beside it.

    A slider must not wait until kernels are compiled; those that are compiled already are taken.
    """

    @lru_cache(maxsize=_KEPT)
    @wraps(compute)
    def found(*plain: Any) -> Part:
        said: list[str] = []
        with compiling_nothing(), warned(said.append):
            try:
                value = compute(*plain)
            except InputError as error:
                return Part(None, (str(error),))
        return Part(value, tuple(said))

    return found


@lru_cache(maxsize=_KEPT)
def plant_of(vehicle: Vehicle, plane: str, model: str) -> Plant:
    """Return the plant, with what it has computed of itself.

    Raises
    ------
    InputError
        As `Plant.from_vehicle`.
    """
    return Plant(Coefficients.from_vehicle(vehicle, plane), model)


def pieces(model: str, dead_band: float) -> list[tuple[float, ...]]:
    """Return `DURATIONS` in pieces: one by one where the trim law may have to be flown for each."""
    each = tuple(DURATIONS.tolist())
    slow = model != "fixed-path" and (dead_band == 1.0 or model == "drift-and-speed")
    return [(one,) for one in each] if slow else [each]


@_part
def boundary(
    vehicle: Vehicle,
    plane: str,
    model: str,
    shape: str,
    dead_band: float,
    durations: tuple[float, ...],
) -> FloatArray:
    """Return the deflection that is needed per wind angle [rad/rad] at durations [s], ``(n,)``."""
    plant = plant_of(vehicle, plane, model)
    return np.asarray(_needed(plant, shape, dead_band, np.array(durations)))


def _needed(plant: Plant, shape: str, dead_band: float, duration: FloatArray) -> Any:
    """Linear in the peak, which is why the peak is not asked for."""
    limit = _closed_form(plant, one_of("shape", shape, PULSES), dead_band, duration)
    if np.all(np.isfinite(limit)):
        return np.abs(plant.coefficients.B * limit)
    peak = 0.1
    wind = PULSES[shape](peak=peak, duration=duration)
    return np.abs(required_deflection(plant, wind, dead_band).deflection) / peak


def _closed_form(plant: Plant, shape: str, dead_band: float, duration: Any) -> Any:
    """y_BR by eq (7), (12) or (16) with its pole, at once; NaN where there is none."""
    c = plant.coefficients
    if float(c.mu_alpha) <= 0.0 or plant.model != "fixed-path":
        return np.nan
    x = c.pole * np.asarray(duration)
    if shape == "rectangular":
        return rectangular_limit(x)
    return triangular_limit(x, dead_band) if shape == "triangular" else np.nan


@_part
def loop_margins(
    vehicle: Vehicle, plane: str, model: str, law: tuple[str, tuple[float, ...]], delay: float
) -> Margins | None:
    """Return the margins of a law's gains, with an actuator and a delay [s]; None without gains."""
    plant = plant_of(vehicle, plane, model)
    gains = gains_of(plant, *law)
    if gains is None:
        return None
    return replace(gains, actuator=Actuator(), delay=delay).margins(plant)


@_part
def motion(
    vehicle: Vehicle,
    plane: str,
    model: str,
    wind: tuple[str, float, float],
    limit: float,
    law: tuple[str, tuple[float, ...]],
) -> Motion:
    """Return what the vehicle does in a wind, of a shape, a duration [s] and a peak [rad].

    The law is its name and its own numbers, as of `law_of`. The report's control is a history and
    its response exact; a law is flown without an actuator, sampled.
    """
    plant = plant_of(vehicle, plane, model)
    shape, duration, peak = wind
    gust = PULSES[one_of("shape", shape, PULSES)](peak=peak, duration=duration)
    name, numbers = law
    times, rate = _samples(plant, duration)
    if one_of("law", name, CONTROLS) == REPORT:
        against = -float(np.sign(plant.coefficients.B)) * float(np.sign(peak))
        if not against:
            raise InputError(
                "the report's control turns the nozzle against the moment of the wind, and this"
                " vehicle feels none: mu_alpha is 0"
            )
        deflection = trim_then_hold(plant, gust, against * limit, numbers[0])
        found = attitude_responses(plant, deflection, gust, times)
        return Motion(times, gust(times), found["attitude"], deflection(times), None)
    chosen = law_of(plant, name, numbers, peak)
    flown = fly(plant, chosen, gust, times, deflection_limit=limit, sample_rate=rate)
    survived = _recoverable(plant, flown.outputs[:3, -1], limit)
    return Motion(times, gust(times), flown.outputs[0], flown.outputs[-1], survived)


def _samples(plant: Plant, duration: float) -> tuple[FloatArray, float]:
    """Times [s] until some time after the wind, and the samples of a law in a second [Hz].

    A flight that is asked for at its very samples is quick.
    """
    beta = float(np.sqrt(np.abs(np.asarray(plant.coefficients.mu_alpha))))
    rate = SAMPLE_RATE * max(1.0, beta + float(plant.coefficients.damping))
    after = min(_AFTER / beta, _LONGEST_AFTER) if beta else _LONGEST_AFTER
    return np.arange(np.ceil((duration + after) * rate) + 1.0) * (1.0 / rate), rate


def law_of(plant: Plant, name: str, numbers: tuple[float, ...], peak: float) -> Law:
    """Return a law by its name, with its dead band or its gains, as `design_law` designs it.

    Raises
    ------
    InputError
        For a name that is no law, and as the law itself.
    """
    gains = gains_of(plant, name, numbers)
    if name == AUTOPILOT:
        return design_law(name, plant, peak, autopilot=gains)
    return design_law(name, plant, peak, **({"dead_band": numbers[0]} if name == DEAD_BAND else {}))


def gains_of(plant: Plant, name: str, numbers: tuple[float, ...]) -> Autopilot | None:
    """Return the gains of a law by its name; None where it is none of constant gains."""
    if name == AUTOPILOT:
        return Autopilot(attitude_gain=numbers[0], rate_gain=numbers[1])
    return half_relief_gains(plant.coefficients) if name == HALF_RELIEF else None


def _recoverable(plant: Plant, seen: FloatArray, limit: float) -> bool | None:
    """Whether a limited deflection can still bring the last state back; None if nobody can say."""
    try:
        modes = seen_coordinates(plant)
    except InputError:
        return None
    z = modes.rows @ seen[: modes.rows.shape[1]]
    return bool(modes.inside(z, limit / abs(float(plant.coefficients.B))))
