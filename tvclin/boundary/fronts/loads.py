"""Angle and load together: the least deflection of a plant over the load of its structure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.errors import InputError, between, finite, number, one_row, positive, small_angle
from tvclin.boundary.fronts.load_limits import limits_of
from tvclin.boundary.fronts.load_record import LoadFront
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History

_POINTS = 10
"""Default number of load bounds of a front."""

_MIN_MOMENT_RATIO = 1e-12
"""Smallest size of a moment ratio other than zero, for numerical range."""


def load_front(
    plant: Plant,
    wind: History,
    loads: ArrayLike | None = None,
    *,
    limit: float | None = None,
    load: float | None = None,
    rate_limit: float = np.inf,
    moment_ratio: float = 0.0,
) -> LoadFront:
    """Return the least deflection over the largest load, from the onset of the wind on.

    Parameters
    ----------
    plant : Plant
        One plant.
    wind : History
        One wind that ends, known beforehand.
    loads : array_like, optional
        Bounds of the load [rad], ``(n,)``; by default ten from near the least load up to that of
        the control of least deflection, and `load`.
    limit, load : float, optional
        Limit of the nozzle and load limit of the structure [rad].
    rate_limit : float
        Largest deflection rate [rad/s]; none by default.
    moment_ratio : float
        M: the load is alpha + M delta. Of a bending moment M_alpha alpha + M_delta delta it is
        M_delta/M_alpha, and the bounds are those of the moment over M_alpha.

    Returns
    -------
    LoadFront
        Each limit is attained by a deflection whose load is computed between the nodes too, and
        bounded from below by the prices of its program: within 1e-4, or a note says more.

    Raises
    ------
    InputError
        Where `optimum_deflection` or, with a rate limit, `rate_front` raises it; for loads that
        are not positive, and a load of the structure below the lower bound of every deflection.

    Notes
    -----
    Without a limit of the deflection the least load of a wind without jumps is zero; a jump at the
    onset leaves its size, a later one half of it. A wind that may stop at its peak is such a jump:
    half of it is the least load of a law without a forecast. With a rate limit or M the least load
    is that of a computed control, on nodes that resolve the oscillating zeros of the load too; its
    lower bound may be less.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> wind = tv.TriangularWind(peak=np.radians(5), duration=7.5)
    >>> front = tv.boundary.load_front(plant, wind, np.radians([4.0, 2.5, 1.5]))
    >>> np.degrees(front.limits).round(3).tolist()
    [0.199, 0.258, 0.308]
    """
    angle = small_angle("a load", positive)
    nozzle_limit = (
        None if limit is None else number("limit", limit, small_angle("a limit", positive), "rad")
    )
    load_limit = None if load is None else number("load", load, angle, "rad")
    M = number("moment_ratio", moment_ratio, finite)
    if 0.0 < abs(M) < _MIN_MOMENT_RATIO:
        raise InputError(
            f"moment_ratio must be zero or at least {_MIN_MOMENT_RATIO:g}; got {M:.6g}"
        )
    rate = rate_limit
    if not (isinstance(rate, float) and np.isposinf(rate)):
        rate = number("rate_limit", rate, between(1e-15, 1e9), "rad/s")
    load_bounds = None if loads is None else angle("loads", one_row("loads", loads, "rad"), "rad")
    case = limits_of(plant, wind, M, rate)
    if load_limit is not None and load_limit < case.floor:
        raise InputError(
            f"load is below what any deflection leaves; got {np.degrees(load_limit):.4g} deg, and"
            f" {np.degrees(case.floor):.6g} deg ({case.floor:.6g} rad) is the least"
        )
    if load_bounds is None:
        low, high = max(1.05 * case.least_load, 0.2 * case.its_load), case.its_load
        load_bounds = np.linspace(min(low, high), high, _POINTS)
        if load_limit is not None:
            load_bounds = np.unique(np.append(load_bounds, load_limit))
    points = dict(zip(load_bounds.tolist(), case.all_at(load_bounds), strict=True))
    limits, proofs, slopes = np.array([points[a] for a in load_bounds.tolist()]).T
    blind = case.blind
    needed = (
        case.least_deflection if load_limit is None else case.all_at(np.array([load_limit]))[0][0]
    )
    front = LoadFront(
        loads=load_bounds,
        limits=limits,
        proofs=proofs,
        slopes=slopes,
        holds=tuple(case.set_by(a, d) for a, d in zip(load_bounds, limits, strict=True)),
        bounds=None if blind is None else case.unforeseen(load_bounds, proofs),
        least_deflection=case.least_deflection,
        its_load=case.its_load,
        least_load=case.least_load,
        least_load_blind=np.nan if blind is None else case.stopped,
        moment_ratio=M,
        rate_limit=rate,
        limit=nozzle_limit,
        load=load_limit,
        needed=needed,
        needed_load=case.least_load if nozzle_limit is None else case.needed_load(nozzle_limit),
        angle=abs(float(wind.peak)),
    )
    return replace(front, needed=np.nan, needed_load=np.nan) if front.beyond else front
