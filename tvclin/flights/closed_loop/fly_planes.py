"""Flights in both planes at once, with one deflection limit for the vector of both.

Each plane is stepped by the kernel of one plane. Between law and nozzle the vector of both demands
is limited by the limit shape; see `laws.both_planes`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.base.arrays import BoolArray, FloatArray, IntArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, ending, instance, number, positive, small_angle
from tvclin.base.fields import spec
from tvclin.boundary.limit_shapes import LimitShape, Vectors
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law, LawInPlanes
from tvclin.flights.closed_loop.batch import Batch, Hardware, flights
from tvclin.flights.closed_loop.checks import (
    check_actuator,
    check_delays,
    check_fastest_pole,
    check_rate_limit,
    check_sample_rate,
    check_samples,
)
from tvclin.flights.closed_loop.fly_many import LOST, STATUS, SURVIVED, UNDECIDED
from tvclin.flights.closed_loop.law_batch import law_batch
from tvclin.flights.closed_loop.outcomes import decidable
from tvclin.flights.closed_loop.sampled import Stepper
from tvclin.flights.closed_loop.survival_limit import STEPS, limit_above_losses
from tvclin.kernels.flight_arrays import Flights
from tvclin.kernels.flights import JUDGED_SAMPLES
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind

_MAX_SAMPLES_AFTER_WIND = 20_000
"""Largest number of samples after the wind until a flight is undecided."""
_MAX_OVER_RECOVERABLE = 0.999
"""Largest vector of unstable coordinates of a surviving flight, over the recoverable set."""


@dataclass(frozen=True, eq=False, repr=False)
class FlownPlanes(Shown):
    """Outcomes of flights in both planes, each field in the shape of the limits.

    Attributes
    ----------
    peak_attitude : ndarray
        Magnitude [rad] of the largest attitude vector at samples.
    peak_deflection : ndarray
        Largest deflection [rad] at samples, in the measure of the limit shape.
    saturated_time_fraction : ndarray
        Fraction of the flight in which the demand was at or beyond the limit.
    end_time : ndarray
        Time of the end of the flight [s].
    status : ndarray of str
        "survived", "lost" or "undecided", see `FlownCases`.
    time, attitude, deflection : ndarray
        Samples [s] of a single flight, and its vectors [rad], ``(n,)``; empty for several flights.
    """

    peak_attitude: FloatArray = field(metadata=spec("angle"))
    peak_deflection: FloatArray = field(metadata=spec("angle"))
    saturated_time_fraction: FloatArray
    end_time: FloatArray
    status: NDArray[np.str_] = field(metadata=spec())
    time: FloatArray
    attitude: Vectors
    deflection: Vectors


def flown_in_step(
    pair: list[Flights], law: LawInPlanes, limit: FloatArray, start: float, period: float
) -> FlownPlanes:
    """Return the outcomes of flights whose planes are stepped together until all are decided.

    `pair`: arrays of the m flights in pitch and in yaw. `law`: law of both planes, with the limit
    shape. `limit`: limits of the vector [rad], m in number. `start`, `period`: start of the flights
    and sample period [s]. Vectors are complex, pitch + j yaw. The gauge of a vector [rad] is the
    limit whose shape it just reaches.
    """
    shape, limit, limit_shape = limit.shape, limit.ravel(), law.shape
    m, steppers = limit.size, [Stepper(f) for f in pair]
    attitude, deflection, saturated = np.zeros((3, m))  # peaks [rad]; samples at the limit
    # last sample, -1 before; index of the outcome in `STATUS`
    ended, outcome = np.full(m, -1), np.full(m, STATUS.index(UNDECIDED))
    shown: list[tuple[complex, complex]] = []  # vectors at the samples of a single flight
    last = int(max(f.cases.finish.max(initial=-1) for f in pair))
    for f in pair:
        f.cases.finish[:] = last
    for k in range(last + 1):
        active = np.flatnonzero(ended < 0)
        with np.errstate(all="ignore"):  # a lost flight may leave all numbers
            for stepper in steppers:
                stepper.look(k)
        # state 0 is the attitude; the deflection is the state after those of the plant
        attitudes = _vectors(pair, lambda f: f.now.y[:, 0])[active]
        deflections = _vectors(pair, lambda f: f.now.y[:, f.vehicles.A.shape[1]])[active]
        attitude[active] = np.maximum(attitude[active], np.abs(attitudes))
        deflection[active] = np.maximum(deflection[active], limit_shape.gauge(deflections))
        if m == 1:
            shown.append((complex(attitudes[0]), complex(deflections[0])))
        if k % JUDGED_SAMPLES == 0 or k == last:
            lost, survived = _lost_and_survived(pair, limit_shape, limit)
            decided = (lost | survived | (k == last)) & (ended < 0)
            outcome[decided & survived] = STATUS.index(SURVIVED)
            outcome[decided & lost] = STATUS.index(LOST)
            for samples in (ended, *(f.now.ended for f in pair)):
                samples[decided] = k
            active = np.flatnonzero(ended < 0)
            if not active.size:
                break
        saturated[active] += _advanced(pair, steppers, law, limit, active, k)
    vectors = np.array(shown).reshape(-1, 2).T  # complex, attitude and deflection by sample
    return FlownPlanes(
        peak_attitude=attitude.reshape(shape),
        peak_deflection=deflection.reshape(shape),
        saturated_time_fraction=(saturated / np.maximum(ended, 1)).reshape(shape),
        end_time=np.asarray(start + ended * period).reshape(shape),
        status=np.array(STATUS)[outcome].reshape(shape),
        time=np.asarray(start + period * np.arange(len(shown))),
        attitude=vectors[0],
        deflection=vectors[1],
    )


def _advanced(
    pair: list[Flights],
    steppers: list[Stepper],
    law: LawInPlanes,
    limit: FloatArray,
    active: IntArray,
    k: int,
) -> BoolArray:
    """Step the flights by the sample with number `k`; return whether their demands are limited.

    Each plane gets its component of the limited command, which no limiter of a plane changes. The
    result is of the flights that have not ended, whose indices are `active`. `steppers`: kernels of
    both planes. Other parameters as of `flown_in_step`.
    """
    measured = _vectors(pair, lambda f: f.now.measured)[active]
    states = _vectors(pair, lambda f: f.now.states)[active, : len(law.law.states[0])]
    demand, command = law.demand(measured, states, limit[active]), np.zeros(limit.size, complex)
    command[active], saturated = law.limited(demand, limit[active])
    # a plane engages and releases its whole limit at demands of one time the limit
    ratio = np.ones(limit.size)
    for stepper, component in zip(steppers, (command.real, command.imag), strict=True):
        stepper.advance(k, np.ascontiguousarray(component), ratio, ratio)
    return saturated


def _vectors(pair: list[Flights], array: Callable[[Flights], FloatArray]) -> Vectors:
    """Return the vectors pitch + j yaw of an array of the flights in both planes.

    `pair`: arrays of the flights in pitch and in yaw. `array`: function that selects the array.
    """
    pitch, yaw = (array(f) for f in pair)
    return np.asarray(pitch + 1j * yaw)


def _lost_and_survived(
    pair: list[Flights], limit_shape: LimitShape, limit: FloatArray
) -> tuple[BoolArray, BoolArray]:
    """Return whether a plane of each of m flights has diverged, and whether both have settled.

    Both results are ``(m,)``. Both planes must also be settled as a vector: its unstable
    coordinates, over their reach, are inside the limit shape. `pair`: arrays of the flights in
    pitch and in yaw. `limit_shape`: limit shape of unit limit. `limit`: limits of the vector [rad],
    ``(m,)``.
    """
    pitch, yaw = (f.now.outcome for f in pair)
    lost = (pitch == STATUS.index(LOST)) | (yaw == STATUS.index(LOST))
    survived = (pitch == STATUS.index(SURVIVED)) & (yaw == STATUS.index(SURVIVED))
    if np.any(survived):
        # fast unstable coordinate of each plane [rad], the first row of `judges` of the one
        # vehicle, over its reach: the largest recoverable one per deflection limit
        z = [f.now.y @ f.vehicles.judges[0, 0] / f.vehicles.reach[0] for f in pair]
        with np.errstate(all="ignore"):
            ratio = limit_shape.gauge(np.where(survived, z[0] + 1j * z[1], 0.0))
        survived &= ratio < _MAX_OVER_RECOVERABLE * limit
    return lost, survived


@dataclass(frozen=True, eq=False)
class FlownPlaneLimit(Shown):
    """Smallest limit above which a law survives a wind in both planes.

    Attributes
    ----------
    limit : float
        Limit over ``|B|`` times the largest wind vector; infinite if the largest of the scan is
        lost.
    deflection : float
        Limit [rad], positive, in the measure of the limit shape.
    scan : ndarray
        Limits of the flights, rising, over ``|B|`` times the largest wind vector.
    survives : ndarray of bool
        Whether each of them survives.
    status : str
        "ok", or the reason why the limit is an end of the range.
    """

    limit: float = field(metadata=spec(label="limit over trim"))
    deflection: float = field(metadata=spec("angle"))
    scan: FloatArray
    survives: BoolArray
    status: str = field(metadata=spec())


def fly_planes(
    plant: Plant,
    law: Law,
    wind: PlaneWind,
    *,
    deflection_limit: ArrayLike,
    limit_shape: LimitShape | str = "round",
    saturate: str = "radial",
    rate_limit: float = np.inf,
    actuator: Actuator | None = None,
    sample_rate: float,
    delay: float = 0.0,
    yaw_plant: Plant | None = None,
) -> FlownPlanes:
    """Return the outcomes of flights of a law in pitch and yaw with one limit shape.

    Parameters
    ----------
    plant : Plant
        One plant with one or two real unstable poles.
    law : Law
        Law of both planes: it acts along the measured wind and across it.
    wind : PlaneWind
        One wind that ends.
    deflection_limit : array_like
        Limits [rad], positive, each a flight.
    limit_shape : LimitShape or str
        Limit shape of the nozzle, of unit limit; or its name, as in `size`.
    saturate : {"radial", "each plane"}
        Whether the limited demand keeps its direction, or each component is limited by the largest
        rectangle within the limit shape.
    rate_limit : float
        Largest deflection rate [rad/s] of each plane.
    actuator : Actuator, optional
        First-order actuator of both planes. Without it the deflection equals its command.
    sample_rate, delay
        Same as in `fly_many`, one for all flights.
    yaw_plant : Plant, optional
        Plant of the yaw plane; by default the plant of the pitch plane.

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
    law_in_planes = LawInPlanes(law, limit_shape, saturate)
    _check(wind, actuator)
    rate = check_sample_rate(sample_rate, actuator)
    limit = small_angle("a deflection", positive)("deflection_limit", deflection_limit)
    period = np.asarray(1.0 / rate)
    delays = check_delays(number("delay", delay), period)
    max_rate = check_rate_limit(rate_limit)
    hardware = Hardware(period, delays, actuator=actuator, rate_limit=max_rate)
    for plane_plant in planes:
        check_fastest_pole(plane_plant, 1.0 / rate)
    check_samples(float(wind.end - wind.onset), 1.0 / rate)
    onset, laws, pair = float(wind.onset), law_batch(law, (limit.size,)), []
    # samples of the wind; 1e-9 is rounding
    ends = int(np.ceil((float(wind.end) - onset) / float(period) - 1e-9))
    for plane_plant, component, plane_limit in zip(
        planes, (wind.pitch, wind.yaw), law_in_planes.plane_limits, strict=True
    ):
        limits = limit.ravel() * plane_limit
        batch = Batch(plane_plant, hardware, component, laws, limit=limits, shape=limits.shape)
        with np.errstate(invalid="ignore"):  # a plane without wind
            f = flights(batch)
        # both planes have the samples of the vector wind, until at most 20000 after it
        f.cases.start[:], f.cases.ends[:] = onset, ends
        f.cases.finish[:] = ends + np.minimum(f.cases.waiting, _MAX_SAMPLES_AFTER_WIND)
        # index of the last breakpoint of the component that is not after the onset
        f.now.piece[:] = (f.winds.knots[f.cases.wind] <= onset).sum(axis=1) - 1
        pair.append(f)
    return flown_in_step(pair, law_in_planes, limit, onset, 1.0 / rate)


def flown_plane_limit(
    plant: Plant,
    law: Law,
    wind: PlaneWind,
    *,
    limit_shape: LimitShape | str = "round",
    saturate: str = "radial",
    sample_rate: float = 200.0,
    lowest: float = 0.02,
    highest: float = 2.0,
    **flight: Any,
) -> FlownPlaneLimit:
    """Return the smallest deflection limit above which a law survives a wind in both planes.

    Parameters
    ----------
    plant, law, wind, limit_shape, saturate, sample_rate
        Same as in `fly_planes`.
    lowest, highest : float
        Range of the limits, over the trim deflection ``|B|`` times the largest wind vector.
    **flight
        Options of `fly_planes`: rate_limit, actuator, delay, yaw_plant.

    Returns
    -------
    FlownPlaneLimit
        Result of the scan and refinements of `closed_loop_boundary`.

    Raises
    ------
    InputError
        In the same cases as `fly_planes`, and for an empty range.

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
    # checks alone, before the wind is used
    _plants(plant, yaw_plant=None)
    LawInPlanes(law, limit_shape, saturate)
    _check(wind, actuator=None)
    low, high = (number(n, v, positive) for n, v in (("lowest", lowest), ("highest", highest)))
    if low >= high:
        raise InputError(f"highest must be above lowest; got {high:.6g} and {low:.6g}")
    scale = abs(float(np.asarray(plant.coefficients.B))) * float(wind.peak)  # static trim [rad]

    shape: dict[str, Any] = {"limit_shape": limit_shape, "saturate": saturate}
    flown = partial(fly_planes, plant, law, wind, sample_rate=sample_rate, **shape, **flight)

    def status(limits: FloatArray) -> NDArray[np.str_]:
        """Return the status of flights with m limits over trim, ``(m,)``; `scale`: trim [rad]."""
        return flown(deflection_limit=limits * scale).status

    limit = limit_above_losses(status, np.linspace(low, high, STEPS + 1))
    return FlownPlaneLimit(
        limit=limit.limit,
        deflection=limit.limit * scale,
        scan=limit.scan,
        survives=limit.outcomes == SURVIVED,
        status=limit.status,
    )


def _plants(plant: Plant, yaw_plant: Plant | None) -> tuple[Plant, Plant]:
    """Return the plants of pitch and yaw; `InputError` unless each has one or two real poles.

    `yaw_plant`: plant of the yaw plane; None for the plant of the pitch plane.
    """
    planes = plant, plant if yaw_plant is None else yaw_plant
    for name, plane_plant in zip(("plant", "yaw_plant"), planes, strict=True):
        instance(name, plane_plant, Plant, "see Plant.from_vehicle")
        if plane_plant.batch or not np.all(decidable(plane_plant)):
            raise InputError(f"{name} must be one plant with one or two real unstable poles")
    return planes


def _check(wind: PlaneWind, actuator: Actuator | None) -> None:
    """Raise `InputError` unless wind and actuator are possible in two planes."""
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
