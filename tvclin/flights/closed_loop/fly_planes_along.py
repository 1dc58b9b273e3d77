"""Flights of an autopilot along a flight in both planes, with one limit shape.

Each plane has the stages of a flight in one plane. Between the filters and the nozzle the vector of
both demands is limited by the limit shape: along its direction, or by planes for a rectangle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tvclin.ascent.measured_wind import MeasuredPlanes
from tvclin.ascent.schedule import FlightSchedule
from tvclin.ascent.wind_along import planes_along
from tvclin.base import errors
from tvclin.boundary.limit_shapes import CircularShape, LimitShape, PolygonShape, limit_shape_of
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.gain_schedule import GainSchedule
from tvclin.flights.closed_loop.checks import check_rate_limit
from tvclin.flights.closed_loop.flown_flights import SIMILAR_RUNS, FlownFlight, checked_flight
from tvclin.flights.closed_loop.fly_along import OUTSIDE, FlightAlong, tracked_states, with_outputs
from tvclin.flights.closed_loop.fly_many import (
    LOST,
    RINGS,
    SURVIVED,
    UNDECIDED,
    flown_cases,
    unstable_loops,
)
from tvclin.flights.closed_loop.sampled import finish_in_planes
from tvclin.kernels.choice import repeated
from tvclin.linear.plant import DEFAULT_MODEL
from tvclin.vehicle.coefficients import PLANES
from tvclin.winds.plane_wind import PlaneWind

_ROUNDING = 1e-9
"""Relative rounding of a deflection at the limit."""


def fly_planes_along(
    flight: FlightSchedule,
    autopilot: Autopilot | GainSchedule | Mapping[str, Autopilot | GainSchedule],
    wind: PlaneWind | MeasuredPlanes,
    *,
    deflection_limit: float,
    limit_shape: LimitShape | str = "round",
    rate_limit: float = np.inf,
    sign: str | None = None,
    gust_time: float | None = None,
    start: float | None = None,
    stop: float | None = None,
    model: str = DEFAULT_MODEL,
) -> FlightAlong:
    """Return the outputs of an autopilot along a flight in both planes, from equilibrium.

    Parameters
    ----------
    flight, gust_time, start, stop, model
        Same as in `fly_along`.
    autopilot : Autopilot, GainSchedule or mapping
        Autopilot of both planes, or one for "pitch" and one for "yaw", with a sample rate.
    wind : PlaneWind or MeasuredPlanes
        Wind angles of attack [rad] of both planes over the time of flight, or the wind of
        `fly_through` with ``plane="both"``.
    deflection_limit : float
        Deflection limit [rad], the scale of the limit shape.
    limit_shape : LimitShape or str
        Limit shape of the nozzle, of unit limit; or its name, as in `size`.
    rate_limit : float
        Largest deflection rate [rad/s] of each plane.
    sign : {"frozen"}, optional
        "frozen" for the nominal dynamic pressure, the same for either sign of the wind; by default
        that encountered in the wind of both planes.

    Returns
    -------
    FlightAlong
        Magnitudes of the vectors of both planes, and each plane in `planes`. A flight is lost when
        one plane is, and survives when both do.

    Raises
    ------
    InputError
        For a wind without a direction, another sign, and in the same cases as `fly_along`.

    Notes
    -----
    A demand outside the limit shape keeps its direction; in a rectangle along the planes, such as
    "square" and "round-each-plane", each plane is limited separately. Delay, actuator and rate
    limit act on each plane, so that the deflection vector may leave the shape at a sample though
    all demands are inside. A stop of the nozzle at the shape is not modelled, and such a flight is
    not known to survive.

    Each plane is judged after its wind with the largest deflection in it, so that what is lost is
    lost with every control. Limit cycles are looked for with the square within the shape.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> flight = tv.load_schedule("configuration-i")
    >>> pulse = tv.TriangularWind(peak=np.radians(4.0), duration=8.0).shift(60.0)
    >>> gains = tv.Autopilot(attitude_gain=0.9, rate_gain=0.9, sample_rate=50.0)
    >>> wind = tv.winds.PlaneWind.towards(pulse, np.radians(45.0))
    >>> flown = tv.flights.fly_planes_along(
    ...     flight, gains, wind, deflection_limit=np.radians(2.0))
    >>> flown.status, sorted(flown.planes)
    ('survived', ['pitch', 'yaw'])
    """
    autopilots = autopilot if isinstance(autopilot, Mapping) else dict.fromkeys(PLANES, autopilot)
    if set(autopilots) != set(PLANES):
        raise errors.InputError(
            f"autopilot must be one for both planes, or one for each of {', '.join(PLANES)}"
        )
    limit = errors.limit_angle(deflection_limit)
    max_rate = check_rate_limit(rate_limit)
    shape = limit_shape_of(limit_shape).inside
    if not isinstance(shape, CircularShape | PolygonShape):
        shape = shape.inscribed()
    winds = planes_along(flight, wind, sign, gust_time)
    pair = [
        checked_flight(flight, autopilots[plane], winds[plane], start, stop, model, plane)
        for plane in PLANES
    ]
    if pair[0].law.sample_rate != pair[1].law.sample_rate:
        raise errors.InputError("autopilot must have the same sample_rate in both planes")
    flown = _flight_in_planes(pair, shape, limit, max_rate)
    if flown.status != UNDECIDED:
        return flown
    # flown anew to the later of both planes' ends at which it can be settled, if there is one
    stops = [along.further.stop for along in pair if along.further is not None]
    if not stops:
        return flown
    pair = [replace(along, stop=max(stops), goes_on=False) for along in pair]
    return _flight_in_planes(pair, shape, limit, max_rate)


def _flight_in_planes(
    pair: Sequence[FlownFlight],
    shape: CircularShape | PolygonShape,
    limit: float,
    rate_limit: float,
) -> FlightAlong:
    """Return the outputs and the status of a sampled flight in both planes.

    The flight has the worse status of both planes. `pair`: flights in pitch and in yaw. `shape`:
    limit shape of unit limit. `limit`, `rate_limit`: limits of the deflection vector [rad] and of
    the rate in each plane [rad/s].
    """
    which, rates = np.zeros(1, np.int64), np.array([rate_limit])
    batches = [
        along.stages.batch(which, np.array([limit * plane_limit]), rates)
        for along, plane_limit in zip(pair, shape.plane_limits, strict=True)
    ]
    flights = [
        along.stages.flights(batch, track=True) for along, batch in zip(pair, batches, strict=True)
    ]
    statuses = set()
    # limit cycles are looked for with the largest limits that planes may use separately
    by_planes = isinstance(shape, PolygonShape) and shape.by_planes
    separate_limits = (shape if by_planes else shape.each_plane()).plane_limits
    # normals of the shape, for the kernel's gauge: none of a circle, and zero of a rectangle along
    # the planes, since each plane has its own limit
    normals = np.zeros((1 if by_planes else 0, 2))
    if isinstance(shape, PolygonShape) and not by_planes:
        normals = np.column_stack([shape.normals.real, shape.normals.imag])
    with repeated(SIMILAR_RUNS):  # similar runs, which decide between compiled and plain code
        finish_in_planes(flights[0], flights[1], normals, np.array([limit]))
        for batch, f, inner in zip(batches, flights, separate_limits, strict=True):
            within = f._replace(cases=f.cases._replace(limit=np.array([limit * inner])))
            cases = flown_cases(f, np.ones(1, bool), unstable_loops(batch, within))
            statuses.add(str(cases.status[0]))
    # the worst of both planes, worst first
    status = next(word for word in (LOST, RINGS, UNDECIDED, SURVIVED) if word in statuses)
    by_plane = {
        plane: with_outputs(along, *tracked_states(f, limit * plane_limit), status, slopes={})
        for plane, along, f, plane_limit in zip(
            PLANES, pair, flights, shape.plane_limits, strict=True
        )
    }
    return _vector_flight(by_plane, shape, limit)


def _vector_flight(
    by_plane: dict[str, FlightAlong], shape: CircularShape | PolygonShape, limit: float
) -> FlightAlong:
    """Return the outputs of a flight in both planes from those in each, with the common status.

    The deflection is the limit whose shape the vector just reaches (`gauge`), the rate the larger
    of both planes, and the others are magnitudes of vectors. A flight that survives with a
    deflection beyond the limit becomes "outside", which is not known. `by_plane`: flights in pitch
    and yaw. `shape`: limit shape of unit limit. `limit`: deflection limit [rad].
    """
    pitch, yaw = (by_plane[plane] for plane in PLANES)
    outputs = {
        name: np.hypot(values, yaw.outputs[name])
        for name, values in pitch.outputs.items()
        if name in yaw.outputs
    }
    deflection = pitch.outputs["deflection"] + 1j * yaw.outputs["deflection"]
    outputs["deflection"] = shape.gauge(deflection)
    rates = [np.abs(along.outputs["deflection_rate"]) for along in by_plane.values()]
    outputs["deflection_rate"] = np.maximum(*rates)
    outputs["pressure_ratio"] = pitch.outputs["pressure_ratio"]
    status = pitch.status
    if status == SURVIVED and outputs["deflection"].max() > limit * (1.0 + _ROUNDING):
        status = OUTSIDE
    planes = {plane: replace(along, status=status) for plane, along in by_plane.items()}
    return FlightAlong(times=pitch.times, outputs=outputs, status=status, planes=planes)
