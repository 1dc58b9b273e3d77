"""The boundary limit: the least deflection with which a wind can be survived, eq (4b).

    y_BR = -delta_max / (B alpha_w,max)

By eq (4b) the report's control (trim until the dead band is left, then the limit) is on the
boundary exactly when the limit equals the discounted mean of the trim deflection still to come,

    delta_max = p * integral from a to infinity of e^(-p (t - a)) delta_T(t) dt,

where a is the time at which the dead band is left and p the largest real unstable pole.
`boundary_limit` solves that for any wind of one sign and for every plant; the closed forms of
the report stand in `closed_forms`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.cards import card
from tvclin.closed_forms import (
    TriangularLimit,
    rectangular_limit,
    solve_triangular_with_drift,
    triangular_limit,
    triangular_limit_with_drift,
)
from tvclin.deflections import dead_band_driver, trim_deflection
from tvclin.errors import InputError, broadcast, instance, nonzero, plain, within
from tvclin.histories import History, Piecewise
from tvclin.kernels import pieces as kernel
from tvclin.modes import unstable_modes
from tvclin.plant import Plant
from tvclin.switching import Problem
from tvclin.winds import equivalent_triangle

__all__ = [
    "BoundaryLimit",
    "TriangularLimit",
    "boundary_limit",
    "is_sufficient",
    "rectangular_limit",
    "solve_triangular_with_drift",
    "survivable_peak",
    "triangle_error",
    "triangular_limit",
    "triangular_limit_with_drift",
]

FloatArray = NDArray[np.float64]

_WIDEST = 1e9
"""Limits beyond this [rad] mean nothing."""
OK = "ok"
STABLE = "no real unstable pole: no deflection is needed"
NEVER_LEFT = "trim never saturates: a lower limit does not meet (4b), a higher one is not needed"
JUMP = "no limit meets (4b) exactly: every limit above this one is sufficient"


@dataclass(frozen=True, eq=False)
class BoundaryLimit:
    """The boundary of one plant in one wind, or of a batch; every field has the shape ``(...)``.

    Attributes
    ----------
    limit : float or ndarray
        y_BR, the least limit over the trim deflection B alpha_w,max without drift.
    deflection : float or ndarray
        The same as a deflection [rad], -y_BR B alpha_w,max; its sign opposes the wind.
    switch_time : float or ndarray
        a [s], when the dead band is left on the boundary; NaN where it never is.
    status : str or ndarray of str
        "ok", or in words why the limit is not a solution of (4b).
    """

    limit: Any
    deflection: Any
    switch_time: Any
    status: Any

    def _repr_html_(self) -> str:
        rows = [
            ("limit, of full trim", self.limit, "-"),
            ("deflection", np.degrees(self.deflection), "deg"),
            ("dead band is left at", self.switch_time, "s"),
            ("status", self.status, ""),
        ]
        return card("Boundary limit", rows)


def boundary_limit(
    plant: Plant, wind: History, dead_band: ArrayLike = 1.0, switch: str = "report"
) -> BoundaryLimit:
    """Return the boundary limit of a plant in any wind of one sign.

    Parameters
    ----------
    plant : Plant
        One plant or a batch, of any model.
    wind : History
        Wind angle of attack that does not change its sign; batches broadcast.
    dead_band : array_like
        K, the part of the limit up to which the vehicle is trimmed, in [0, 1].
    switch : {"report", "literal"}
        What leaves the dead band, as in `trim_then_hold`. They differ on models with drift.

    Returns
    -------
    BoundaryLimit
        The condition (4b) is met at the largest real unstable pole. Slower poles of the exact
        models are not met; `judge` reports them. (A stable vehicle on an exact model may have
        only a slow one, of the flight path; then it is that.) Where several limits meet the
        condition (winds of several peaks) it is the largest, above which every limit is
        sufficient.

    Raises
    ------
    InputError
        For a wind that changes sign, never ends or is zero, and a dead band outside [0, 1].

    Notes
    -----
    Eqs (6) to (8), (12), (15a), (16) and (18) are its special cases.
    """
    K = within("dead_band", dead_band, 0.0, 1.0)
    instance("plant", plant, Plant, "see Plant.from_vehicle")
    instance("wind", wind, History, "such as TriangularWind")
    _check_wind(wind)
    pole = _fastest_real_pole(plant)
    unstable = ~np.isnan(pole)
    scale = np.where(unstable, -np.asarray(plant.coefficients.B), 1.0) * wind.peak
    trim = trim_deflection(plant, wind)
    driver = dead_band_driver(plant, wind, trim, switch)
    shape = broadcast(dead_band=K.shape, plant=pole.shape, wind=driver.batch)
    problem = Problem(
        kernel.spread((driver * (1.0 / scale)).pieces, shape),
        kernel.spread((trim * (1.0 / scale)).pieces, shape),
        np.broadcast_to(np.where(unstable, pole, 1.0), shape),
        np.broadcast_to(K, shape),
    )
    switching = problem.solve()
    at_onset = (K == 0.0) | ~unstable
    onset = np.where(unstable, driver.onset, 0.0)
    time = np.where(at_onset, np.broadcast_to(onset, shape), switching.time)
    limit = np.where(unstable, problem.demand(time[..., np.newaxis])[..., 0], 0.0)
    never = switching.never & ~at_onset
    if np.any(never):
        limit = np.where(never, _trim_for_ever(problem), limit)
    known = [~np.broadcast_to(unstable, shape), never, switching.jumps & ~at_onset]
    status = np.select(known, [STABLE, NEVER_LEFT, JUMP], OK)
    return BoundaryLimit(
        plain(limit),
        plain(np.asarray(limit * scale)),
        plain(np.where(unstable & ~never, time, np.nan)),
        status if status.ndim else str(status),
    )


def is_sufficient(
    plant: Plant,
    wind: History,
    limit: ArrayLike,
    dead_band: ArrayLike = 1.0,
    switch: str = "report",
) -> Any:
    """Return whether a deflection capability is at or above the boundary.

    Parameters
    ----------
    plant, wind, dead_band, switch
        As of `boundary_limit`.
    limit : array_like
        Capability delta_max [rad]; its sign is ignored.

    Returns
    -------
    bool or ndarray of bool
        A real autopilot lets go of deflection it no longer needs, so every capability above the
        boundary is sufficient. (A history that *holds* more than the boundary for ever is not
        stable by (4b); that is the question of `judge`.)

    Raises
    ------
    InputError
        As `boundary_limit`, and for a limit of zero.
    """
    capability = _capability(limit)
    needed = np.abs(boundary_limit(plant, wind, dead_band, switch).deflection)
    enough = capability >= needed * (1.0 - 4.0 * np.finfo(float).eps)
    return enough if enough.ndim else bool(enough)


def survivable_peak(
    plant: Plant,
    wind: History,
    limit: ArrayLike,
    dead_band: ArrayLike = 1.0,
    switch: str = "report",
) -> Any:
    """Return the largest peak [rad] of a wind of this shape that a given limit survives.

    The inverse of `boundary_limit`: ``|limit|/(y_BR |B|)``, with the sign of the wind. Infinite
    where no deflection is needed. The theory is linear; read a value of many degrees as
    "more than the small-angle model can say".

    Parameters
    ----------
    plant, wind, dead_band, switch
        As of `boundary_limit`; only the shape of the wind counts.
    limit : array_like
        Capability delta_max [rad]; its sign is ignored.

    Raises
    ------
    InputError
        As `boundary_limit`, and for a limit of zero.
    """
    capability = _capability(limit)
    needed = np.abs(boundary_limit(plant, wind, dead_band, switch).deflection)
    with np.errstate(divide="ignore"):
        return plain(np.asarray(wind.peak * (capability / needed)))


def triangle_error(plant: Plant, wind: History, dead_band: ArrayLike = 1.0) -> Any:
    """Return the relative error of the boundary when a wind is replaced by its equivalent triangle.

    It holds for the given plant: the triangle's boundary deflection over that of the wind itself,
    minus one. Negative where the triangle promises too much; NaN where no deflection is needed.

    Parameters
    ----------
    plant, wind, dead_band
        As of `boundary_limit`.

    Raises
    ------
    InputError
        As `boundary_limit` and `equivalent_triangle`.
    """
    both = (wind, equivalent_triangle(wind))
    true, triangle = (np.asarray(boundary_limit(plant, w, dead_band).deflection) for w in both)
    with np.errstate(invalid="ignore"):
        return plain(np.asarray(triangle / true - 1.0))


def _capability(limit: ArrayLike) -> FloatArray:
    """Return the size of a limit [rad]."""
    return np.abs(within("limit", nonzero("limit", limit, "rad"), -_WIDEST, _WIDEST, "rad"))


def _trim_for_ever(problem: Problem) -> FloatArray:
    """The least limit with which trim is never limited.

    Nor is the dead band ever left: K times the demand, a mean of trim, is above all the driver.
    """
    return np.abs(Piecewise(problem.trim).peak)


def _fastest_real_pole(plant: Plant) -> FloatArray:
    """The largest real unstable pole, ``(...)``; NaN where there is none."""
    poles = unstable_modes(plant).poles
    if not poles.shape[-1]:
        return np.full(poles.shape[:-1], np.nan)
    real = np.where(np.imag(poles) == 0.0, np.real(poles), -np.inf)
    fastest = np.where(np.isnan(real), -np.inf, real).max(axis=-1)
    return np.where(np.isinf(fastest), np.nan, fastest)


def _check_wind(wind: History) -> None:
    values = np.real(kernel.value(wind.pieces, wind.probe_times()))
    size = np.abs(values).max(axis=-1)
    slack = 1e-12 * size
    if np.any((values.min(axis=-1) < -slack) & (values.max(axis=-1) > slack)):
        raise InputError(
            "wind must not change its sign for a boundary limit; got values from"
            f" {values.min():.6g} to {values.max():.6g} rad"
        )
    if np.any(np.isneginf(wind.end)):
        raise InputError("wind must differ from zero; got a history that is zero throughout")
    if np.any(np.isposinf(wind.end)):
        raise InputError("wind must end: the last piece of its history must be zero")
