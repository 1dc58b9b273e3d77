"""What the report's control needs of a stop that two planes share.

By eq (4b) in each plane the report's control (trim until the dead band is left, then hold) is on
the boundary when the deflection held is the vector of discounted means of the trim still to come,
W(a). The dead band is left when the gauge of the driver is K times the limit:

    g_S(driver(a)) = K g_S(W(a)),        limit = g_S(W(a))

For a wind of one direction that is the scalar equation, times the gauge of the direction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.boundary.limit import JUMP, NEVER_LEFT, OK, boundary_limit
from tvclin.boundary.open_loop import (
    ROUNDING,
    Reason,
    open_loop_requirements,
)
from tvclin.boundary.optimum.least_peaks import peaks_of
from tvclin.boundary.planes.optimum import least_in_planes
from tvclin.boundary.planes.pair import Pair
from tvclin.boundary.planes.unforeseen import unforeseen
from tvclin.boundary.stops import Stop
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import unit_vector

_GRID, _ROUNDS = 65, 10
"""Points of a grid that is laid into one cell of the one before: after 10 rounds, to rounding."""
_SLACK = 1e-12
_FALLEN = 1e-9
_CLOSE, _NEAR = 1e-3, 1e-2
"""Parts of a limit: the last step of a search, and from where on another need is looked at."""
TURNS = (
    "the wind turns, and the deflection held presumes how: a law that limits its command"
    " without changing its direction may need more in flight"
)
POLYGON = (
    "the dead band of the cluster is that of a polygon inside its shape: the limit is a"
    " little too large"
)


@dataclass(frozen=True)
class Needed:
    """What one wind asks for: the limit and the bound [rad], the vector held, and since when.

    `least` is the minimum over all unstable poles, and `y` the limit over B alpha_w,max where that
    is known to the last digit.
    """

    limit: float
    held: complex
    time: float
    bound: float
    least: float
    notes: tuple[str, ...]
    y: float | None = None


def in_vectors(pair: Pair, stop: Stop, K: float, least: float) -> float:
    """Return the limit [rad] of the control in both planes, which trim itself leaves; or `least`.

    `least`: the rectangle of what each plane asks for by itself, if that is more. The minimum of
    both and their bound without a forecast are no more than this, and are not looked for.
    `InputError` as `plane_limit`.
    """
    if _line(pair) is not None:  # along which the planes are one
        return least
    _turns_level(pair, K)
    shape = stop if K == 0.0 else stop.inside
    limit = max(least, float(shape.gauge(_left(pair, shape, K, literal=True)[0])))
    if K in (0.0, 1.0) or max(one.size for one in pair.poles) == 1:
        return limit
    return _lost_after_trim(pair, stop.inside, K, True, limit)


def needed(pair: Pair, stop: Stop, bands: Sequence[float], literal: bool) -> list[Needed]:
    """Return what one wind asks of two planes at each dead band."""
    line = _line(pair)
    if line is not None:
        return [_straight(pair, *line, stop, K, literal) for K in bands]
    _turns_level(pair, max(bands))
    least = float(stop.inside.gauge(pair.demanded(np.asarray([float(pair.wind.onset)])))[0])
    doubt = ""
    if max(one.size for one in pair.poles) > 1:
        best = least_in_planes(pair, stop.inside)
        least = best.peak
        if best.status != OK:
            doubt = f"the minimum is not solved: at most {100.0 * best.certificate.gap:.2g}% less"
    bound = unforeseen(pair, stop.inside)
    return [_turning(pair, stop, K, literal, least, bound, doubt) for K in bands]


def _turns_level(pair: Pair, K: float) -> None:
    """Raise `InputError` for a wind that turns where b1 is below zero."""
    falling = [p.model != "fixed-path" and p.coefficients.b1 < 0.0 for p in pair.plants]
    if any(falling) and K > 0.0 and not pair.wind.unidirectional:
        raise InputError(
            "a wind that turns needs plants with b1 of zero or more, for with b1 < 0 trim grows"
            " when the wind is over; take dead_band=0, or what each plane requires by itself"
        )


def _turning(
    pair: Pair, stop: Stop, K: float, literal: bool, least: float, bound: float, doubt: str
) -> Needed:
    """The boundary of the control in a wind that turns, or of planes that differ."""
    shape = stop if K == 0.0 else stop.inside
    held, time, status = _left(pair, shape, K, literal)
    notes = [] if status == OK else [status]
    if K > 0.0:
        notes += [] if pair.wind.unidirectional else [TURNS]
        notes += [] if shape is stop else [POLYGON]
    modes = max(one.size for one in pair.poles)
    needs = {
        Reason.BOUNDARY: float(shape.gauge(held)),
        Reason.MINIMUM: least if modes > 1 else 0.0,
        Reason.NO_FORECAST: bound if K == 1.0 else 0.0,
    }
    if modes > 1 and 0.0 < K < 1.0:
        needs[Reason.AFTER_TRIM] = _lost_after_trim(
            pair, stop.inside, K, literal, max(needs.values())
        )
    limit, more = _largest(needs)
    notes += [doubt] if doubt and limit == needs[Reason.MINIMUM] else []
    return Needed(limit, held, time, bound, least, (*notes, *more))


def _lost_after_trim(pair: Pair, stop: Stop, K: float, literal: bool, least: float) -> float:
    """The largest limit [rad] that is lost when the dead band is left at K times it, or `least`.

    L <- max(K L, m(L)) from the largest trim on, as in `after_trim`. The rectangle of what each
    plane asks for by itself is no less than m, and tried first.
    """
    from scipy.optimize import brentq  # late: it takes 0.3 s to import

    driver = pair.trim if literal else pair.of_moment
    times = pair.times()
    heights = np.asarray(stop.gauge(driver(times)))
    limit = float(max(heights.max(), stop.gauge(pair.trim(times)).max()))

    def asked(limit: float, enough: float, solved: bool) -> float:
        """m(L) solved, or what is no less."""

        def over(t: float) -> float:
            return float(stop.gauge(driver(np.asarray([t])))[0]) - K * limit

        # at the end of the wind where the dead band is not left before
        k = int(np.argmax(heights >= K * limit)) if heights.max() >= K * limit else -1
        t = float(times[k])
        if k > 0 and over(times[k - 1]) < 0.0 < over(t):
            t = float(brentq(over, times[k - 1], t, xtol=1e-12))
        alone = []  # the least peak of each plane by itself
        for plane in (0, 1):
            poles, z = pair.poles[plane][np.newaxis], pair.left_at(plane, t)[np.newaxis]
            alone.append(float(peaks_of(poles, z / poles)[0]))
        corners = [complex(alone[0], side * alone[1]) for side in (1.0, -1.0)]
        apart = float(np.max(stop.gauge([*corners, *(-one for one in corners)])))
        return apart if apart <= enough or not solved else least_in_planes(pair, stop, t).peak

    limit = max(limit, asked(heights.max() / K * (1.0 + _CLOSE), limit, False))
    for solved in (False, True):
        while limit > least:
            lowest = max(K * limit, least)
            below = max(asked(limit, lowest, solved), lowest)
            if below > limit * (1.0 - _CLOSE):
                break
            limit = below
            near = limit <= least * (1.0 + _NEAR)
            if near and asked(least, least, solved) <= least * (1.0 + _CLOSE):
                return least
    return max(limit, least)


def _largest(needs: dict[Reason, float]) -> tuple[float, list[str]]:
    """The largest need, and what to say if it is not that of the control."""
    governs = max(needs, key=lambda name: needs[name])
    more = needs[governs] > needs[Reason.BOUNDARY] * (1.0 + ROUNDING)
    return (needs[governs], [governs.larger]) if more else (needs[Reason.BOUNDARY], [])


def _line(pair: Pair) -> tuple[Plant, History] | None:
    """The plant and the scalar wind of one direction and one sign; None for all others."""
    if not pair.wind.unidirectional:
        return None
    wind, angle = pair.wind, pair.wind.direction
    alone = [not np.isfinite(one.onset) for one in (wind.yaw, wind.pitch)]
    if not (pair.equal or any(alone)):
        return None
    scalar = wind.component(angle)
    if not scalar.constant_sign:
        return None
    return pair.plants[1 if alone[1] and not pair.equal else 0], scalar


def _straight(
    pair: Pair, plant: Plant, wind: History, stop: Stop, K: float, literal: bool
) -> Needed:
    """The scalar answers, each along the direction of the wind."""
    boundary = boundary_limit(plant, wind, K, "literal" if literal else "report")
    required = open_loop_requirements(plant, wind, 1.0, boundary)
    needs = {name: float(size) for name, size in required.items()}
    direction = complex(unit_vector(pair.wind.direction))
    held = boundary.deflection * direction
    gauges = stop.gauge([direction, -direction])
    one_way, both_ways = float(gauges[int(boundary.deflection < 0.0)]), float(gauges.max())
    bound = needs[Reason.NO_FORECAST] * both_ways
    after = needs[Reason.AFTER_TRIM]
    if 0.0 < K < 1.0:
        flown = boundary if literal else boundary_limit(plant, wind, K, "literal")
        after = float(open_loop_requirements(plant, wind, K, flown)[Reason.AFTER_TRIM])
    limit, more = _largest(
        {
            Reason.BOUNDARY: needs[Reason.BOUNDARY] * one_way,
            Reason.MINIMUM: needs[Reason.MINIMUM] * both_ways,
            Reason.AFTER_TRIM: after * both_ways,
            Reason.NO_FORECAST: bound if K == 1.0 else 0.0,
        }
    )
    notes = [] if boundary.status == OK else [str(boundary.status)]
    y = None if more or not pair.equal else boundary.limit * one_way
    least = needs[Reason.MINIMUM] * both_ways
    return Needed(limit, held, float(boundary.switch_time), bound, least, (*notes, *more), y)


def _left(pair: Pair, stop: Stop, K: float, literal: bool) -> tuple[complex, float, str]:
    """The vector held, the time [s] from which on, and what is different.

    Only new heights of the driver's gauge count; of several solutions it is the last.
    """
    onset = np.asarray([float(pair.wind.onset)])
    if K == 0.0:
        return complex(pair.held(onset)[0]), float(onset[0]), OK
    times = pair.times()

    def spare(t: FloatArray, floor: float = 0.0) -> FloatArray:
        driver = stop.gauge(pair.trim(t) if literal else pair.of_moment(t))
        return np.maximum(driver, floor) - K * stop.gauge(pair.held(t))

    heights = stop.gauge(pair.trim(times) if literal else pair.of_moment(times))
    records = np.flatnonzero(heights >= np.maximum.accumulate(heights))
    left = spare(times[records])
    short = np.flatnonzero(left < -_SLACK * heights.max())
    if short.size == 0:
        return complex(pair.held(times[:1])[0]), float(times[0]), OK
    if short[-1] == records.size - 1:
        trims = pair.trim(times)
        return complex(trims[np.argmax(stop.gauge(trims))]), np.nan, NEVER_LEFT
    first, last = records[short[-1]], records[short[-1] + 1]
    floor, span = float(heights[first]), times[first : last + 1]
    for _ in range(_ROUNDS):  # the last rise through zero, in steps between each two
        low = np.flatnonzero(spare(span, floor)[:-1] < 0.0).max(initial=0)
        span = np.linspace(span[low], span[low + 1], _GRID)
    b = span[-1]
    held, driver = pair.held(np.asarray([b])), spare(np.asarray([b]))[0]
    fallen = driver < -_FALLEN * floor
    return complex(held[0]), float(b), JUMP if fallen else OK
