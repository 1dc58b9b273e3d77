"""Angle and load together: the least deflection of a plant over what its structure feels."""

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
"""Of a front, unless loads are given."""

_MIN_MOMENT_RATIO = 1e-12
"""A moment ratio other than zero below this size is out of the range of numbers."""


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
        Bounds of the load [rad], ``(n,)``; unless given ten from near the least one up to what a
        control of least deflection has, and the given one.
    limit, load : float, optional
        What the nozzle has, and what the structure bears [rad].
    rate_limit : float
        Largest deflection rate [rad/s]; none by default.
    moment_ratio : float
        M: the load is alpha + M delta. Of a bending moment M_alpha alpha + M_delta delta it is
        M_delta/M_alpha, and the bounds are those of the moment over M_alpha.

    Returns
    -------
    LoadFront
        Each limit is reached by a deflection whose load was looked at between the nodes too, and
        proved from below by the prices of its program: they are within 1e-4, or a note says more.

    Raises
    ------
    InputError
        As `optimum_deflection` and, with a rate limit, `rate_front`; for loads that are not
        positive, and a load of the structure below what is proved of every deflection.

    Notes
    -----
    At any deflection a wind without jumps leaves no load: the least is that of a jump at the onset,
    or half of a later one. A wind that may stop at its peak is such a jump: half of it is what a
    law without a forecast must bear. With a rate limit or M the least load is that of a computed
    control, on nodes that resolve the oscillating zeros of the load too; what is proved may be
    less.

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
    most = (
        None if limit is None else number("limit", limit, small_angle("a limit", positive), "rad")
    )
    borne = None if load is None else number("load", load, angle, "rad")
    M = number("moment_ratio", moment_ratio, finite)
    if 0.0 < abs(M) < _MIN_MOMENT_RATIO:
        raise InputError(
            f"moment_ratio must be zero or at least {_MIN_MOMENT_RATIO:g}; got {M:.6g}"
        )
    rate = rate_limit
    if not (isinstance(rate, float) and np.isposinf(rate)):
        rate = number("rate_limit", rate, between(1e-15, 1e9), "rad/s")
    given = None if loads is None else angle("loads", one_row("loads", loads, "rad"), "rad")
    found = limits_of(plant, wind, M, rate)
    if borne is not None and borne < found.floor:
        raise InputError(
            f"load is below what any deflection leaves; got {np.degrees(borne):.4g} deg, and"
            f" {np.degrees(found.floor):.6g} deg ({found.floor:.6g} rad) is the least"
        )
    if given is None:
        low, high = max(1.05 * found.least_load, 0.2 * found.its_load), found.its_load
        given = np.linspace(min(low, high), high, _POINTS)
        if borne is not None:
            given = np.unique(np.append(given, borne))
    each = dict(zip(given.tolist(), found.all_at(given), strict=True))
    limits, proofs, slopes = np.array([each[a] for a in given.tolist()]).T
    blind = found.blind
    needed = found.least_deflection if borne is None else found.all_at(np.array([borne]))[0][0]
    front = LoadFront(
        loads=given,
        limits=limits,
        proofs=proofs,
        slopes=slopes,
        holds=tuple(found.set_by(a, d) for a, d in zip(given, limits, strict=True)),
        bounds=None if blind is None else found.unforeseen(given, proofs),
        least_deflection=found.least_deflection,
        its_load=found.its_load,
        least_load=found.least_load,
        least_load_blind=np.nan if blind is None else found.stopped,
        moment_ratio=M,
        rate_limit=rate,
        limit=most,
        load=borne,
        needed=needed,
        needed_load=found.least_load if most is None else found.needed_load(most),
        angle=abs(float(wind.peak)),
    )
    return replace(front, needed=np.nan, needed_load=np.nan) if front.beyond else front
