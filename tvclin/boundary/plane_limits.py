"""The boundary limit of two planes that share a deflection limit, for one case or a batch.

By eq (4b) in each plane the report's control (trim until the exit of the dead band, then a constant
deflection) is on the boundary when that deflection is the vector of discounted means of the
remaining trim, W(a). At the exit of the dead band the gauge of the driver is K times the limit:

    g_S(driver(a)) = K g_S(W(a)),        limit = g_S(W(a))

For a wind of one direction that is the scalar equation, times the gauge of the direction. The limit
is the largest of that, the bounds of `plane_bounds`, and the minimum after trim.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, broadcast, one_of, within
from tvclin.base.fields import spec
from tvclin.boundary.limit import JUMP, NO_EXIT, OK, boundary_limit
from tvclin.boundary.limit_shapes import CircularShape, LimitShape
from tvclin.boundary.open_loop import ROUNDING, Reason, open_loop_requirements
from tvclin.boundary.optimum.minimum_peak import peaks_for_demands
from tvclin.boundary.plane_bounds import (
    PlanePair,
    checked_batch,
    minimum_in_planes,
    no_forecast_bound,
)
from tvclin.linear.deflections import SWITCHES
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind, unit_vector

_GRID_POINTS = 65
"""Points of a grid for the exit time, which is refined within one of its cells."""
_GRID_REFINEMENTS = 10
"""Refinements of that grid, after which its step is rounding."""
_RELATIVE_ROUNDING = 1e-12
"""Rounding of the driver's gauge, relative to its largest value."""
_RELATIVE_JUMP = 1e-9
"""Fall of the driver below its last value, relative to it, that counts as a jump at the exit."""
_RELATIVE_TOLERANCE = 1e-3
"""Relative tolerance of the limit that diverges after trim."""
_RELATIVE_RANGE = 1e-2
"""Relative distance to another requirement within which its own survival is tested."""
TURNS = (
    "the wind turns, and the constant deflection presumes how: a law that limits its command"
    " without changing its direction may require more in flight"
)
POLYGON = (
    "the dead band of the cluster is that of a polygon inside its shape: the limit is a"
    " little too large"
)


@dataclass(frozen=True)
class PlaneRequirement:
    """Requirement of one wind at one dead band.

    `limit`: required limit [rad]. `deflection`: constant deflection after the exit of the dead band
    [rad], pitch + j yaw. `time`: of the exit [s]. `bound`: lower bound without a forecast [rad].
    `minimum`: over all unstable poles [rad]. `y`: the limit normalised by B alpha_w,max, where it
    is exact to the last digit; else None.
    """

    limit: float
    deflection: complex
    time: float
    bound: float
    minimum: float
    notes: tuple[str, ...]
    y: float | None = None


def vector_requirement(
    pair: PlanePair, limit_shape: LimitShape, K: float, separate: float
) -> float:
    """Return the required limit [rad] of trim in both planes together, at least `separate`.

    The control trims both planes until the gauge of the trim vector (the minimum limit that reaches
    it) is K times the limit, and then deflects by a constant vector. The limit is the boundary
    limit, or with more than one unstable pole and 0 < K < 1 the largest limit that diverges after
    trim. `pair`: plants and wind. `K`: dead band. `separate`: limit [rad] of the rectangle of both
    planes' separate requirements. The minimum of both planes and their bound without a forecast do
    not exceed it, and are not computed. `InputError` where `plane_limit` raises it.
    """
    if _scalar_case(pair) is not None:  # along the wind the two planes are like a single plane
        return separate
    _check_turning(pair, K)  # a wind that turns, where trim would grow after it
    requirement = _turning_requirement(
        pair, limit_shape, K, literal=True, minimum=separate, bound=separate, warning=""
    )
    return max(separate, requirement.limit)


def two_plane_requirement(
    pair: PlanePair, limit_shape: LimitShape, bands: Sequence[float], literal: bool
) -> list[PlaneRequirement]:
    """Return the requirement of one wind in two planes, for each dead band K of `bands`.

    `pair`: plants and wind. `limit_shape`: of the nozzle. `literal`: whether the exit of the dead
    band is on trim, not on the wind. `InputError` as `_check_turning`.
    """
    scalar_case = _scalar_case(pair)  # plant and wind along one direction, None in other cases
    if scalar_case is not None:
        return [
            _unidirectional_requirement(pair, *scalar_case, limit_shape, K, literal) for K in bands
        ]
    _check_turning(pair, max(bands))
    onset, warning = np.asarray([float(pair.wind.onset)]), ""
    # minimum of any control; with one unstable mode in each plane it is constant from the onset on
    minimum = float(limit_shape.inside.gauge(pair.wind_demand(onset))[0])
    if max(poles.size for poles in pair.poles) > 1:
        optimum = minimum_in_planes(pair, limit_shape.inside)
        minimum = optimum.peak
        if optimum.status != OK:
            warning = (
                f"the minimum is not solved: at most {100.0 * optimum.certificate.gap:.2g}% less"
            )
    bound = no_forecast_bound(pair, limit_shape.inside)
    return [
        _turning_requirement(pair, limit_shape, K, literal, minimum, bound, warning) for K in bands
    ]


def _check_turning(pair: PlanePair, K: float) -> None:
    """Raise `InputError` for a wind of `pair` that turns where b1 < 0 and the dead band `K` > 0.

    -b1 [1/s] is the zero from deflection to attitude of a plant with drift.
    """
    negative_b1 = [p.model != "fixed-path" and p.coefficients.b1 < 0.0 for p in pair.plants]
    if any(negative_b1) and K > 0.0 and not pair.wind.unidirectional:
        raise InputError(
            "a wind that turns requires plants with b1 of zero or more, for with b1 < 0 trim grows"
            " when the wind is over; take dead_band=0, or what each plane requires by itself"
        )


def _turning_requirement(
    pair: PlanePair,
    limit_shape: LimitShape,
    K: float,
    literal: bool,
    minimum: float,
    bound: float,
    warning: str,
) -> PlaneRequirement:
    """Return the requirement of a wind that turns, or of planes that differ.

    `pair`: plants and wind. `limit_shape`: of the nozzle. `K`: dead band. `literal`: whether its
    exit is on trim, not on the wind. `minimum`: over all unstable poles [rad]. `bound`: lower bound
    without a forecast [rad]. `warning`: note where the minimum is the requirement.
    """
    shape = limit_shape if K == 0.0 else limit_shape.inside
    # `inside` is the shape, or of a cluster a polygon in it, whose gauge takes no search
    deflection, time, status = _dead_band_exit(pair, shape, K, literal)
    notes = [] if status == OK else [status]
    if K > 0.0:
        notes += [] if pair.wind.unidirectional else [TURNS]
        notes += [] if shape is limit_shape else [POLYGON]
    modes = max(poles.size for poles in pair.poles)
    # [rad]; zero where a requirement does not apply: of one mode the boundary is the minimum
    requirements = {
        Reason.BOUNDARY: float(shape.gauge(deflection)),
        Reason.MINIMUM: minimum if modes > 1 else 0.0,
        Reason.NO_FORECAST: bound if K == 1.0 else 0.0,
    }
    if modes > 1 and 0.0 < K < 1.0:
        requirements[Reason.AFTER_TRIM] = _requirement_after_trim(
            pair, limit_shape.inside, K, literal, minimum=max(requirements.values())
        )
    limit, why_larger = _governing_requirement(requirements)
    notes += [warning] if warning and limit == requirements[Reason.MINIMUM] else []
    return PlaneRequirement(
        limit, deflection, time, bound=bound, minimum=minimum, notes=(*notes, *why_larger)
    )


def _requirement_after_trim(
    pair: PlanePair, limit_shape: LimitShape, K: float, literal: bool, minimum: float
) -> float:
    """Return the limit L [rad] down to which all survive if the flight trims up to K L at first.

    By L <- max(K L, m(L)) from the largest trim on. m(L): minimum limit that survives from then on,
    for all unstable modes of both planes; or first an upper bound, of a rectangle. A vector's
    gauge: the limit of the shape whose edge it is on. `pair`: plants and wind. `K`: dead band.
    `literal`: whether its exit is on trim, not on the wind. `minimum`: smallest result [rad].
    """
    from scipy.optimize import brentq  # late: it takes 0.3 s to import

    driver = pair.trim if literal else pair.moment_driver  # [rad], whose gauge decides the exit
    times = pair.times()
    gauges = np.asarray(limit_shape.gauge(driver(times)))
    limit = float(max(gauges.max(), limit_shape.gauge(pair.trim(times)).max()))

    def trimmed_minimum(limit: float, sufficient: float, solved: bool) -> float:
        """Return m(L) [rad] at the `limit` L, or an upper bound of it.

        Trim ends where the gauge of the `driver` first is K L. The bound is the gauge of the
        rectangle of each plane's own minimum; it is taken if it is at most `sufficient` [rad], or m
        is not `solved`.
        """

        def excess(t: float) -> float:
            """Return the driver's gauge [rad] at `t` [s] less K `limit`, zero as trim ends."""
            return float(limit_shape.gauge(driver(np.asarray([t])))[0]) - K * limit

        # at the end of the wind without an earlier exit of the dead band
        k = int(np.argmax(gauges >= K * limit)) if gauges.max() >= K * limit else -1
        t = float(times[k])
        if k > 0 and excess(times[k - 1]) < 0.0 < excess(t):
            t = float(brentq(excess, times[k - 1], t, xtol=1e-12))
        separate = []  # the minimum peak of each plane separately
        for plane in (0, 1):
            # z: constant deflection from t on that each mode requires, after trim up to t
            poles, z = pair.poles[plane], pair.mode_demands(plane, t, after_trim=True)
            peaks = peaks_for_demands(poles[np.newaxis], (z / poles)[np.newaxis])  # of one case
            separate.append(float(peaks[0]))
        corners = [complex(separate[0], sign * separate[1]) for sign in (1.0, -1.0)]
        rectangle = float(np.max(limit_shape.gauge([*corners, *(-corner for corner in corners)])))
        if rectangle <= sufficient or not solved:
            return rectangle
        return minimum_in_planes(pair, limit_shape, t).peak

    # limits above this one have no exit of the dead band: m(L) is then that of the wind's end
    without_exit = gauges.max() / K * (1.0 + _RELATIVE_TOLERANCE)
    limit = max(limit, trimmed_minimum(without_exit, limit, solved=False))
    for solved in (False, True):
        while limit > minimum:
            lowest = max(K * limit, minimum)
            below = max(trimmed_minimum(limit, lowest, solved), lowest)
            if below > limit * (1.0 - _RELATIVE_TOLERANCE):
                break
            limit = below
            close = limit <= minimum * (1.0 + _RELATIVE_RANGE)
            if close and (
                trimmed_minimum(minimum, minimum, solved) <= minimum * (1.0 + _RELATIVE_TOLERANCE)
            ):
                return minimum
    return max(limit, minimum)


def _governing_requirement(requirements: dict[Reason, float]) -> tuple[float, list[str]]:
    """Return the largest requirement [rad], and a note on its reason unless it is the boundary.

    `requirements`: [rad], by reason. The boundary governs those that exceed it by rounding.
    """
    governs = max(requirements, key=requirements.__getitem__)
    boundary = requirements[Reason.BOUNDARY]
    if requirements[governs] > boundary * (1.0 + ROUNDING):
        return requirements[governs], [governs.larger]  # the note of this reason
    return boundary, []


def _scalar_case(pair: PlanePair) -> tuple[Plant, History] | None:
    """Return the plant and the scalar wind along its direction; None if `pair` is no scalar case.

    That takes a wind of one direction and one sign, and equal planes or a wind in only one of them.
    """
    if not pair.wind.unidirectional:
        return None
    wind, angle = pair.wind, pair.wind.direction
    zero_wind = [not np.isfinite(history.onset) for history in (wind.yaw, wind.pitch)]
    if not (pair.equal or any(zero_wind)):
        return None
    scalar = wind.component(angle)
    if not scalar.constant_sign:
        return None
    # of the plants of pitch and yaw: yaw's if the wind of pitch is zero, else pitch's
    return pair.plants[1 if zero_wind[1] and not pair.equal else 0], scalar


def _unidirectional_requirement(
    pair: PlanePair, plant: Plant, wind: History, limit_shape: LimitShape, K: float, literal: bool
) -> PlaneRequirement:
    """Return the requirement of a wind of one direction: of one plane, times the gauge of that.

    The gauge is the limit whose shape just contains a unit deflection in that direction. `pair`:
    plants and wind. `plant`, `wind`: of the plane along the wind. `limit_shape`: of the nozzle.
    `K`: dead band. `literal`: whether its exit is on trim, not on the wind.
    """
    boundary = boundary_limit(plant, wind, K, "literal" if literal else "report")
    # of K = 1, to have the bound without a forecast; the minimum does not depend on K
    required = open_loop_requirements(plant, wind, 1.0, boundary)
    requirements = {name: float(size) for name, size in required.items()}
    direction = complex(unit_vector(pair.wind.direction))
    deflection = boundary.deflection * direction
    # of an asymmetric shape the wind's opposite may require more
    gauges = limit_shape.gauge([direction, -direction])
    gauge, largest_gauge = float(gauges[int(boundary.deflection < 0.0)]), float(gauges.max())
    bound = requirements[Reason.NO_FORECAST] * largest_gauge
    after = requirements[Reason.AFTER_TRIM]
    if 0.0 < K < 1.0:  # the minimum after trim up to K times the limit, with exit on trim
        on_trim = boundary if literal else boundary_limit(plant, wind, K, "literal")
        after = float(open_loop_requirements(plant, wind, K, on_trim)[Reason.AFTER_TRIM])
    limit, why_larger = _governing_requirement(
        {
            Reason.BOUNDARY: requirements[Reason.BOUNDARY] * gauge,
            Reason.MINIMUM: requirements[Reason.MINIMUM] * largest_gauge,
            Reason.AFTER_TRIM: after * largest_gauge,
            Reason.NO_FORECAST: bound if K == 1.0 else 0.0,
        }
    )
    notes = [] if boundary.status == OK else [str(boundary.status)]
    return PlaneRequirement(
        limit=limit,
        deflection=deflection,
        time=float(boundary.switch_time),
        bound=bound,
        minimum=requirements[Reason.MINIMUM] * largest_gauge,
        notes=(*notes, *why_larger),
        # exact for equal planes, where the boundary governs and no note says why not
        y=None if why_larger or not pair.equal else boundary.limit * gauge,
    )


def _dead_band_exit(
    pair: PlanePair, limit_shape: LimitShape, K: float, literal: bool
) -> tuple[complex, float, str]:
    """Return constant deflection [rad] after the exit of the dead band, exit time [s] and status.

    Driver: trim, or on the wind -B alpha_w [rad], trim on a fixed path. At the exit its gauge, the
    limit whose shape just contains it, is K times the gauge of the constant deflection required
    from then on, and a new maximum; the last one counts. Without an exit: largest trim, time NaN.

    `pair`: plants and wind. `limit_shape`: of the nozzle. `K`: dead band. `literal`: whether its
    exit is on trim, not on the wind.
    """
    onset = np.asarray([float(pair.wind.onset)])
    if K == 0.0:
        return complex(pair.required_constant(onset)[0]), float(onset[0]), OK
    times, driver = pair.times(), pair.trim if literal else pair.moment_driver

    def margin(t: FloatArray, floor: float = 0.0) -> FloatArray:
        """Return the margin [rad] of the driver over the dead band at times `t` [s], zero at exit.

        It is the driver's gauge, at least `floor` [rad], minus K times the gauge of the constant
        deflection required from `t` on.
        """
        required = K * limit_shape.gauge(pair.required_constant(t))
        return np.maximum(limit_shape.gauge(driver(t)), floor) - required

    heights = limit_shape.gauge(driver(times))
    maxima = np.flatnonzero(heights >= np.maximum.accumulate(heights))  # times of new maxima
    margins = margin(times[maxima])
    inside = np.flatnonzero(margins < -_RELATIVE_ROUNDING * heights.max())  # within the dead band
    if inside.size == 0:
        return complex(pair.required_constant(times[:1])[0]), float(times[0]), OK
    if inside[-1] == maxima.size - 1:
        trims = pair.trim(times)
        return complex(trims[np.argmax(limit_shape.gauge(trims))]), np.nan, NO_EXIT
    first, last = maxima[inside[-1]], maxima[inside[-1] + 1]
    # between both maxima the driver may fall: the largest height so far stays the exit's level
    floor, span = float(heights[first]), times[first : last + 1]
    for _ in range(_GRID_REFINEMENTS):  # the last rise through zero, in steps between each two
        low = np.flatnonzero(margin(span, floor)[:-1] < 0.0).max(initial=0)
        span = np.linspace(span[low], span[low + 1], _GRID_POINTS)
    exit_time = span[-1:]
    (deflection,), (height,) = pair.required_constant(exit_time), margin(exit_time)
    jumped = height < -_RELATIVE_JUMP * floor  # the driver falls back just after the exit
    return complex(deflection), float(exit_time[0]), JUMP if jumped else OK


@dataclass(frozen=True, eq=False)
class PlaneLimit(Shown):
    """The limit of two planes in one wind, or of a batch; every number has the shape ``(...)``.

    Attributes
    ----------
    limit : float or ndarray
        Minimum limit, normalised by the trim B alpha_w,max of the largest wind vector in pitch.
    deflection : float or ndarray
        Minimum limit [rad], positive, in the measure of the limit shape: the radius of a round one,
        the half width of a square.
    direction : float or ndarray
        Angle [rad] from the pitch plane of the constant deflection after trim.
    pitch, yaw : float or ndarray
        Components of that deflection in pitch and in yaw [rad], with their signs.
    pitch_only : float or ndarray
        Limit [rad] for the pitch component of the wind alone.
    pitch_only_ratio : float or ndarray
        Ratio of `pitch_only` to `deflection`.
    no_forecast_bound : float or ndarray
        Lower bound of every law without a forecast, normalised as `limit`; at K = 1 the limit is
        never below it.
    switch_time : float or ndarray
        Exit time of the dead band [s]; NaN without an exit.
    notes : tuple of str
        Warnings and reasons; for a batch, of any case.
    """

    limit: Any = field(metadata=spec(label="limit over trim"))
    deflection: Any = field(metadata=spec("angle"))
    direction: Any = field(metadata=spec("angle"))
    pitch: Any
    yaw: Any
    pitch_only: Any = field(metadata=spec("angle"))
    pitch_only_ratio: Any
    no_forecast_bound: Any = field(metadata=spec())
    switch_time: Any = field(metadata=spec("time"))
    notes: tuple[str, ...] = field(metadata=spec())


def plane_limit(
    plant: Plant,
    wind: PlaneWind,
    limit_shape: LimitShape | None = None,
    dead_band: ArrayLike = 1.0,
    switch: str = "report",
    yaw_plant: Plant | None = None,
) -> PlaneLimit:
    """Return the minimum limit with which pitch and yaw survive a wind with a direction.

    Parameters
    ----------
    plant : Plant
        One plant or a batch, whose unstable poles are real.
    wind : PlaneWind
        One wind that ends, or a batch; batches broadcast, and are solved case by case.
    limit_shape : LimitShape, optional
        Limit shape of the nozzle; round by default. `LimitShape.each_plane` is the square
        inside it, for planes that are limited separately.
    dead_band : array_like
        K, the fraction of the limit up to which the vehicle is trimmed, in [0, 1].
    switch : {"report", "literal"}
        Condition for the exit of the dead band, as in `trim_then_hold`.
    yaw_plant : Plant, optional
        Plant of the yaw plane; by default the same as in pitch. If poles differ, a constant
        deflection requires too much: up to two percent more than `plane_optimum` for a ratio of
        the poles up to 1.5.

    Returns
    -------
    PlaneLimit
        The boundary of the control: trim in the dead band, then a constant deflection. Or a lower
        bound where that is larger, with a note: with several unstable poles the minimum of any
        control, and for 0 < K < 1 of any control after trim (to 1e-3 in a wind that turns); at K =
        1 the bound of laws without a forecast. A minimum that is not solved has a note as well.

    Raises
    ------
    InputError
        For a wind without a direction, one that is zero or never ends, a dead band outside [0, 1],
        a wind that turns where b1 of `Coefficients` is below zero, and plants without unstable
        poles, with a complex pair, two fastest poles that are together, or no aerodynamic moment.

    Notes
    -----
    A limit of the pitch plane alone requires 1/sqrt(1 + (tan psi/sin gamma)^2) of this, for
    a horizontal wind at the angle psi to the flight and a path angle gamma.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> gust = tv.TriangularWind(peak=np.radians(5), duration=7.5)
    >>> limit = tv.plane_limit(plant, tv.winds.PlaneWind.towards(gust, np.radians(55)))
    >>> np.degrees([limit.deflection, limit.pitch_only]).round(3)
    array([0.351, 0.201])
    """
    limit_shape = CircularShape() if limit_shape is None else limit_shape
    one_of("switch", switch, SWITCHES)
    K = within("dead_band", dead_band, 0.0, 1.0)
    shape = broadcast(dead_band=K.shape, plants=checked_batch(plant, wind, limit_shape, yaw_plant))
    if not shape:
        pair = PlanePair((plant, yaw_plant or plant), wind)
        return _case_limit(pair, limit_shape, float(K), switch)
    dead_bands = np.broadcast_to(K, shape).ravel()
    limits = []
    for case in range(dead_bands.size):
        first = plant.case(case, shape)
        plants = first, yaw_plant.case(case, shape) if yaw_plant else first
        pair = PlanePair(plants, wind.case(case, shape))
        limits.append(_case_limit(pair, limit_shape, float(dead_bands[case]), switch))
    names = [field.name for field in fields(PlaneLimit)][:-1]  # without the last, `notes`
    numbers = {n: np.reshape([getattr(limit, n) for limit in limits], shape) for n in names}
    notes = tuple(dict.fromkeys(note for limit in limits for note in limit.notes))
    return PlaneLimit(**numbers, notes=notes)


def _case_limit(pair: PlanePair, limit_shape: LimitShape, K: float, switch: str) -> PlaneLimit:
    """Return the limit of one `pair` of plants and wind, at the dead band `K` and exit `switch`.

    The exit is where the nozzle leaves the dead band. `switch`: "literal" where trim reaches K
    times the limit, else where B alpha_w does, which on a fixed path is the same: B is the ratio of
    trim deflection to angle of attack. Ratios are to B alpha_w,max; `y` of the requirement is this
    ratio where it is exact. A plane without wind has an infinite `onset`.
    """
    literal = switch == "literal" or pair.plants[0].model == "fixed-path"
    (requirement,) = two_plane_requirement(pair, limit_shape, (K,), literal)
    pitch_only = requirement.limit  # of the wind's pitch component alone
    if np.isfinite(pair.wind.yaw.onset):
        pitch_only = 0.0
        if np.isfinite(pair.wind.pitch.onset):
            pitch_wind = PlaneWind(pitch=pair.wind.pitch, yaw=0.0 * pair.wind.pitch)
            flat = PlanePair(pair.plants, pitch_wind)
            (in_pitch,) = two_plane_requirement(flat, limit_shape, (K,), literal)
            pitch_only = in_pitch.limit
    # B alpha_w,max [rad], the trim of the largest wind in pitch
    scale = abs(float(np.asarray(pair.plants[0].coefficients.B))) * float(pair.wind.peak)
    return PlaneLimit(
        limit=requirement.limit / scale if requirement.y is None else requirement.y,
        deflection=requirement.limit,
        direction=float(np.angle(requirement.deflection)),
        pitch=requirement.deflection.real,
        yaw=requirement.deflection.imag,
        pitch_only=pitch_only,
        pitch_only_ratio=pitch_only / requirement.limit if requirement.limit > 0.0 else 1.0,
        no_forecast_bound=requirement.bound / scale,
        switch_time=requirement.time,
        notes=requirement.notes,
    )
