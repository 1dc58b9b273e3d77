"""Flights of both planes at once, whose nozzle has one stop.

Each plane is stepped by the kernel that flies one. Between what the law asks for and the nozzle the
vector of both demands is brought back into the stop; see `laws.planes`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, ending, instance, number, positive, small_angle
from tvclin.boundary.stops import Stop, Vectors
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.both_planes import LawInPlanes
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.batch import Hardware
from tvclin.flights.closed_loop.checks import (
    check_actuator,
    check_delays,
    check_pace,
    check_rate_limit,
    check_sample_rate,
    check_samples,
)
from tvclin.flights.closed_loop.edges import STEPS, edge_above_losses
from tvclin.flights.closed_loop.in_step import Course, flown_in_step, ready
from tvclin.flights.closed_loop.many import STATUS, SURVIVED
from tvclin.flights.closed_loop.outcomes import decidable
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind


@dataclass(frozen=True, eq=False, repr=False)
class FlownPlanes(Shown):
    """The outcomes of flights of both planes, each field in the shape of the limits.

    Attributes
    ----------
    peak_attitude : ndarray
        Size [rad] of the largest attitude vector at samples.
    peak_deflection : ndarray
        Largest deflection [rad] at samples, in the measure of the stop.
    saturated_time_fraction : ndarray
        Part of the flight in which the stop was asked for.
    end_time : ndarray
        When the flight ended [s].
    status : ndarray of str
        "survived", "lost" or "undecided", as of `FlownCases`.
    time, attitude, deflection : ndarray
        Of one flight alone, samples [s], and the vectors [rad] there, ``(n,)``; else of no length.
    """

    peak_attitude: FloatArray
    peak_deflection: FloatArray
    saturated_time_fraction: FloatArray
    end_time: FloatArray
    status: NDArray[np.str_]
    time: FloatArray
    attitude: Vectors
    deflection: Vectors

    _keys = "status peak_attitude_deg peak_deflection_deg"


@dataclass(frozen=True, eq=False)
class FlownPlaneLimit(Shown):
    """The least limit with which a law survives a wind in both planes.

    Attributes
    ----------
    limit : float
        Over ``|B|`` times the largest wind vector; infinite if the largest that was tried is lost.
    deflection : float
        The same [rad], positive, in the measure of the stop.
    scan : ndarray
        The limits that were tried, rising, over the same.
    survives : ndarray of bool
        Which of them survive.
    status : str
        "ok", or in words why the limit is an end of the range.
    """

    limit: float
    deflection: float
    scan: FloatArray
    survives: BoolArray
    status: str

    _keys = "limit_over_trim=limit deflection_deg status"


def fly_planes(
    plant: Plant,
    law: Law,
    wind: PlaneWind,
    *,
    deflection_limit: ArrayLike,
    stop: Stop | str = "round",
    saturate: str = "radial",
    rate_limit: float = np.inf,
    actuator: Actuator | None = None,
    sample_rate: float,
    delay: float = 0.0,
    yaw_plant: Plant | None = None,
) -> FlownPlanes:
    """Return the outcomes of flights of a law in pitch and yaw, whose nozzle has one stop.

    Parameters
    ----------
    plant : Plant
        One plant with one or two real unstable poles.
    law : Law
        For both planes: along the felt wind and across it.
    wind : PlaneWind
        One wind that ends.
    deflection_limit : array_like
        Limits [rad], positive, each a flight.
    stop : Stop or str
        What the nozzle can do, times the limit; or a word, as of `size`.
    saturate : {"radial", "each plane"}
        Whether the vector that is asked for keeps its direction when it is limited, or each plane
        is limited by itself to the square inside the stop.
    rate_limit : float
        Largest deflection rate [rad/s], of each plane.
    actuator : Actuator, optional
        Of first order, in both planes. Without one the deflection follows its command at once.
    sample_rate : float
        Samples of the law in a second [Hz], the first at the onset of the wind.
    delay : float
        Computing delay [s], as of `fly_many`.
    yaw_plant : Plant, optional
        Of the yaw plane; by default the same as in pitch.

    Returns
    -------
    FlownPlanes
        A flight is lost when one plane is, and survives when both do.

    Raises
    ------
    InputError
        For a wind without a direction, batches, a law that switches, has filters or noise, an
        actuator of second order, whose nozzle overshoots its stop, and numbers out of range.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> gust = tv.TriangularWind(peak=0.1, duration=8.0)
    >>> wind = tv.winds.PlaneWind.veering(gust, angle=0.0, rate=np.radians(180) / 8.0)
    >>> flown = tv.flights.fly_planes(plant, tv.TrimLaw(plant), wind, sample_rate=100.0,
    ...                       deflection_limit=np.array([0.66, 0.69]) * 0.01)
    >>> flown.status.tolist()
    ['lost', 'survived']
    """
    planes = _plants(plant, yaw_plant)
    whole = LawInPlanes(law, stop, saturate)
    _check(wind, actuator)
    rate = check_sample_rate(sample_rate, actuator)
    limit = small_angle("a deflection", positive)("deflection_limit", deflection_limit)
    length = np.asarray(1.0 / rate)
    late = check_delays(number("delay", delay), length)
    hardware = Hardware(length, late, actuator, check_rate_limit(rate_limit))
    for one in planes:
        check_pace(one, 1.0 / rate)
    check_samples(float(wind.end - wind.onset), 1.0 / rate)
    flat = np.atleast_1d(limit).ravel()
    pair = [
        ready(one, law, wind, part, flat * side, hardware)
        for one, part, side in zip(planes, (wind.pitch, wind.yaw), whole.plane_limits, strict=True)
    ]
    return _answer(flown_in_step(pair, whole, flat), float(wind.onset), 1.0 / rate, limit.shape)


def flown_plane_limit(
    plant: Plant,
    law: Law,
    wind: PlaneWind,
    *,
    stop: Stop | str = "round",
    saturate: str = "radial",
    sample_rate: float = 200.0,
    lowest: float = 0.02,
    highest: float = 2.0,
    **flight: Any,
) -> FlownPlaneLimit:
    """Return the least limit with which a law survives a wind in both planes.

    Parameters
    ----------
    plant, law, wind, stop, saturate, sample_rate
        As of `fly_planes`.
    lowest, highest : float
        Range of the limits that are tried, over ``|B|`` times the largest wind vector.
    **flight
        As of `fly_planes`: rate_limit, actuator, delay, yaw_plant.

    Returns
    -------
    FlownPlaneLimit
        Scanned and refined as by `closed_loop_boundary`.

    Raises
    ------
    InputError
        As `fly_planes`, and for a range that is none.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> gust = tv.TriangularWind(peak=0.1, duration=8.0)
    >>> wind = tv.winds.PlaneWind.veering(gust, angle=0.0, rate=np.radians(180) / 8.0)
    >>> found = tv.flights.flown_plane_limit(plant, tv.TrimLaw(plant), wind, sample_rate=50.0)
    >>> round(found.limit, 2), round(tv.plane_limit(plant, wind).limit, 2)
    (0.68, 0.63)
    """
    _plants(plant, None)
    LawInPlanes(law, stop, saturate)
    _check(wind, None)
    low, high = (number(n, v, positive) for n, v in (("lowest", lowest), ("highest", highest)))
    if low >= high:
        raise InputError(f"highest must be above lowest; got {high:.6g} and {low:.6g}")
    scale = abs(float(np.asarray(plant.coefficients.B))) * float(wind.peak)

    def status(limits: FloatArray) -> NDArray[np.str_]:
        options = {"stop": stop, "saturate": saturate, "sample_rate": sample_rate, **flight}
        return fly_planes(plant, law, wind, deflection_limit=limits * scale, **options).status

    edge = edge_above_losses(status, np.linspace(low, high, STEPS + 1))
    survives = edge.found == SURVIVED
    return FlownPlaneLimit(edge.limit, edge.limit * scale, edge.scan, survives, edge.status)


def _plants(plant: Plant, yaw_plant: Plant | None) -> tuple[Plant, Plant]:
    planes = plant, plant if yaw_plant is None else yaw_plant
    for name, one in zip(("plant", "yaw_plant"), planes, strict=True):
        instance(name, one, Plant, "see Plant.from_vehicle")
        if one.batch or not np.all(decidable(one)):
            raise InputError(f"{name} must be one plant with one or two real unstable poles")
    return planes


def _check(wind: PlaneWind, actuator: Actuator | None) -> None:
    if isinstance(wind, History):
        raise InputError("wind must have a direction: give PlaneWind.towards(wind, angle)")
    instance("wind", wind, PlaneWind, "see PlaneWind.towards")
    if wind.batch:
        raise InputError(f"wind must be one; got a batch of shape {wind.batch}")
    ending("wind", wind.end)
    check_actuator(actuator)
    if actuator is not None and actuator.damping is not None:
        raise InputError(
            "actuator must be of first order in two planes: one of second order overshoots the stop"
        )


def _answer(course: Course, start: float, length: float, shape: tuple[int, ...]) -> FlownPlanes:
    shown = np.array(course.shown).reshape(-1, 2)
    end: FloatArray = np.asarray(start + course.ended * length)
    return FlownPlanes(
        peak_attitude=course.attitude.reshape(shape),
        peak_deflection=course.deflection.reshape(shape),
        saturated_time_fraction=(course.saturated / np.maximum(course.ended, 1)).reshape(shape),
        end_time=end.reshape(shape),
        status=np.array(STATUS)[course.outcome].reshape(shape),
        time=np.asarray(start + length * np.arange(len(shown))),
        attitude=shown[:, 0],
        deflection=shown[:, 1],
    )
