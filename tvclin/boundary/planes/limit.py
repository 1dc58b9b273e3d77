"""The boundary limit of two planes that share a deflection limit, for one case or a batch."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.cards import Shown
from tvclin.base.errors import broadcast, one_of, within
from tvclin.boundary.planes.needed import needed
from tvclin.boundary.planes.pair import Pair, checked
from tvclin.boundary.stops import CircularStop, Stop
from tvclin.linear.deflections import SWITCHES
from tvclin.linear.plant import Plant
from tvclin.winds.plane_wind import PlaneWind


@dataclass(frozen=True, eq=False)
class PlaneLimit(Shown):
    """The limit of two planes in one wind, or of a batch; every number has the shape ``(...)``.

    Attributes
    ----------
    limit : float or ndarray
        Least limit, normalised by the trim B alpha_w,max of the largest wind vector in pitch.
    deflection : float or ndarray
        Least limit [rad], positive, in the measure of the limit shape: the radius of a round one,
        the half width of a square.
    direction : float or ndarray
        Angle [rad] from the pitch plane of the constant deflection after trim.
    in_plane, across : float or ndarray
        Components of that deflection in pitch and in yaw [rad], with their signs.
    pitch_alone : float or ndarray
        Limit [rad] for the pitch component of the wind alone.
    underestimate : float or ndarray
        Ratio of `pitch_alone` to `deflection`.
    without_forecast : float or ndarray
        Lower bound of every law without a forecast, normalised as `limit`; at K = 1 the limit is
        never below it.
    leaving_time : float or ndarray
        Exit time of the dead band [s]; NaN without an exit.
    notes : tuple of str
        Warnings and reasons; for a batch, of any case.
    """

    limit: Any
    deflection: Any
    direction: Any
    in_plane: Any
    across: Any
    pitch_alone: Any
    underestimate: Any
    without_forecast: Any
    leaving_time: Any
    notes: tuple[str, ...]

    _keys = (
        "limit_over_trim=limit deflection_deg pitch_alone_deg direction_deg without_forecast"
        " leaving_time_s notes"
    )


def plane_limit(
    plant: Plant,
    wind: PlaneWind,
    stop: Stop | None = None,
    dead_band: ArrayLike = 1.0,
    switch: str = "report",
    yaw_plant: Plant | None = None,
) -> PlaneLimit:
    """Return the least limit with which pitch and yaw survive a wind with a direction.

    Parameters
    ----------
    plant : Plant
        One plant or a batch, whose unstable poles are real.
    wind : PlaneWind
        One wind that ends, or a batch; batches broadcast, and are solved case by case.
    stop : Stop, optional
        Limit shape of the nozzle; round by default. `Stop.each_plane` is the square inside it, for
        planes that are limited separately.
    dead_band : array_like
        K, the fraction of the limit up to which the vehicle is trimmed, in [0, 1].
    switch : {"report", "literal"}
        Condition for the exit of the dead band, as in `trim_then_hold`.
    yaw_plant : Plant, optional
        Plant of the yaw plane; by default the same as in pitch. With other poles the constant
        deflection is safe, and at most two percent more than `plane_optimum` up to a ratio of 1.5.

    Returns
    -------
    PlaneLimit
        The largest of the boundary of the control, the minimum over all unstable poles, for
        0 < K < 1 that minimum after trim (in a wind that turns to one part in a thousand), and for
        K = 1 the bound without a forecast; the notes say where it is not the first, and how far
        off a minimum may be that is not solved.

    Raises
    ------
    InputError
        For a wind without a direction, one that is zero or never ends, a dead band outside [0, 1],
        a wind that turns where b1 is below zero,
        and plants without unstable poles, with a complex pair, two fastest poles that are
        together, or no aerodynamic moment.

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
    >>> np.degrees([limit.deflection, limit.pitch_alone]).round(3)
    array([0.351, 0.201])
    """
    stop = CircularStop() if stop is None else stop
    one_of("switch", switch, SWITCHES)
    K = within("dead_band", dead_band, 0.0, 1.0)
    shape = broadcast(dead_band=K.shape, plants=checked(plant, wind, stop, yaw_plant))
    if not shape:
        return _case_limit(Pair((plant, yaw_plant or plant), wind), stop, float(K), switch)
    dead_bands = np.broadcast_to(K, shape).ravel()
    limits = []
    for case in range(dead_bands.size):
        first = plant.case(case, shape)
        plants = first, yaw_plant.case(case, shape) if yaw_plant else first
        pair = Pair(plants, wind.case(case, shape))
        limits.append(_case_limit(pair, stop, float(dead_bands[case]), switch))
    names = [field.name for field in fields(PlaneLimit)][:-1]
    numbers = {n: np.reshape([getattr(limit, n) for limit in limits], shape) for n in names}
    notes = tuple(dict.fromkeys(note for limit in limits for note in limit.notes))
    return PlaneLimit(**numbers, notes=notes)


def _case_limit(pair: Pair, stop: Stop, K: float, switch: str) -> PlaneLimit:
    """Return the limit of one case at dead band K."""
    literal = switch == "literal" or pair.plants[0].model == "fixed-path"
    requirement = needed(pair, stop, (K,), literal)[0]
    pitch_alone = requirement.limit
    if np.isfinite(pair.wind.yaw.onset):
        pitch_alone = 0.0
        if np.isfinite(pair.wind.pitch.onset):
            flat = PlaneWind(pitch=pair.wind.pitch, yaw=0.0 * pair.wind.pitch)
            pitch_alone = needed(Pair(pair.plants, flat), stop, (K,), literal)[0].limit
    scale = abs(float(np.asarray(pair.plants[0].coefficients.B))) * float(pair.wind.peak)
    return PlaneLimit(
        limit=requirement.limit / scale if requirement.y is None else requirement.y,
        deflection=requirement.limit,
        direction=float(np.angle(requirement.deflection)),
        in_plane=requirement.deflection.real,
        across=requirement.deflection.imag,
        pitch_alone=pitch_alone,
        underestimate=pitch_alone / requirement.limit if requirement.limit > 0.0 else 1.0,
        without_forecast=requirement.bound / scale,
        leaving_time=requirement.time,
        notes=requirement.notes,
    )
