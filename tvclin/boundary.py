"""The boundary limit: the least deflection with which a wind can be survived, eq (4b).

    y_BR = -delta_max / (B alpha_w,max)

By eq (4b) the report's control (trim until the dead band is left, then the limit) is on the
boundary exactly when the limit equals the discounted mean of the trim deflection still to come,

    delta_max = p * integral from a to infinity of e^(-p (t - a)) delta_T(t) dt,

where a is the time at which the dead band is left and p the largest real unstable pole.
`boundary_limit` solves that for any wind of one sign and for every plant; the closed forms of
the report stand in `closed_forms`.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.closed_forms import (
    TriangularLimit,
    rectangular_limit,
    solve_triangular_with_drift,
    triangular_limit,
    triangular_limit_with_drift,
)
from tvclin.deflections import dead_band_driver, trim_deflection
from tvclin.errors import InputError, nonzero, plain, within
from tvclin.histories import History, Piecewise
from tvclin.kernels import pieces as kernel
from tvclin.kernels.crossings import refine
from tvclin.kernels.pieces import Pieces
from tvclin.modes import unstable_modes
from tvclin.plant import Plant

__all__ = [
    "BoundaryLimit",
    "TriangularLimit",
    "boundary_limit",
    "is_sufficient",
    "rectangular_limit",
    "solve_triangular_with_drift",
    "survivable_peak",
    "triangular_limit",
    "triangular_limit_with_drift",
]

FloatArray = NDArray[np.float64]

OK = "ok"
STABLE = "no real unstable pole: no deflection is needed"
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
        a [s], when the dead band is left on the boundary; NaN where no deflection is needed.
    status : str or ndarray of str
        "ok", or in words why the limit is not a solution of (4b).
    """

    limit: Any
    deflection: Any
    switch_time: Any
    status: Any


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
        models are not met; `judge` reports them. Where several limits meet the condition (winds
        of several peaks) it is the largest, above which every limit is sufficient.

    Raises
    ------
    InputError
        For a wind that changes sign or never ends, and a dead band outside [0, 1].

    Notes
    -----
    Eqs (6) to (8), (12), (15a), (16) and (18) are its special cases.
    """
    K = within("dead_band", dead_band, 0.0, 1.0)
    _check_one_signed(wind)
    pole = _fastest_real_pole(plant)
    unstable = ~np.isnan(pole)
    scale = np.where(unstable, -np.asarray(plant.coefficients.B), 1.0) * wind.peak
    trim = trim_deflection(plant, wind)
    driver = dead_band_driver(plant, wind, trim, switch)
    shape = np.broadcast_shapes(K.shape, pole.shape, trim.batch, driver.batch)
    problem = _Problem(
        kernel.spread((driver * (1.0 / scale)).pieces, shape),
        kernel.spread((trim * (1.0 / scale)).pieces, shape),
        np.broadcast_to(np.where(unstable, pole, 1.0), shape),
        np.broadcast_to(K, shape),
    )
    time, jumps = problem.leaving_time()
    onset = np.broadcast_to(np.where(unstable, driver.onset, 0.0), shape)
    time = np.where(problem.dead_band == 0.0, onset, time)
    limit = np.where(unstable, problem.demand(time[..., np.newaxis])[..., 0], 0.0)
    jumps = jumps & (problem.dead_band > 0.0)
    status = np.where(unstable, np.where(jumps, JUMP, OK), STABLE)
    return BoundaryLimit(
        plain(limit),
        plain(np.asarray(limit * scale)),
        plain(np.where(unstable, time, np.nan)),
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
    capability = np.abs(nonzero("limit", limit, "rad"))
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

    The inverse of `boundary_limit`: |limit|/(y_BR |B|), with the sign of the wind. Infinite
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
    capability = np.abs(nonzero("limit", limit, "rad"))
    needed = np.abs(boundary_limit(plant, wind, dead_band, switch).deflection)
    with np.errstate(divide="ignore"):
        return plain(np.asarray(wind.peak * (capability / needed)))


@dataclass(frozen=True)
class _Problem:
    """Driver and trim deflection over B alpha_w,max with its sign; all fields of one batch."""

    driver: Pieces
    trim: Pieces
    pole: FloatArray
    dead_band: FloatArray

    def demand(self, t: FloatArray) -> FloatArray:
        """The limit that (4b) asks for when it is held from the times ``t (..., m)`` on."""
        future = kernel.future(self.trim, self.pole, t)
        return np.real(future) * self.pole[..., np.newaxis]

    def leaving_time(self) -> tuple[FloatArray, Any]:
        """Where the driver last rises through K times the demand, among its new maxima."""
        times = Piecewise(self.driver).probe_times()
        level = np.real(kernel.value(self.driver, times))
        excess = level - self.dead_band[..., np.newaxis] * self.demand(times)
        highest = np.maximum.accumulate(level, axis=-1)
        earlier = np.concatenate([np.zeros_like(highest[..., :1]), highest[..., :-1]], axis=-1)
        new = level > earlier
        last = level.shape[-1] - 1
        short = new & (excess < 0.0)
        low = last - np.argmax(short[..., ::-1], axis=-1)
        low = np.where(np.any(short, axis=-1), low, -1)
        after = new & (np.arange(last + 1) > low[..., np.newaxis])
        high = np.where(np.any(after, axis=-1), np.argmax(after, axis=-1), np.maximum(low, 0))
        return self._between(times, low, high, highest)

    def _between(
        self, times: FloatArray, low: Any, high: Any, highest: FloatArray
    ) -> tuple[FloatArray, Any]:
        first = np.where(low < 0, np.maximum(high - 1, 0), low)[..., np.newaxis]
        floor = np.where(low < 0, 0.0, np.take_along_axis(highest, first, axis=-1)[..., 0])
        ends = [np.take_along_axis(times, i, axis=-1) for i in (first, high[..., np.newaxis])]
        flat_pole, flat_band, flat_floor = (a.ravel() for a in (self.pole, self.dead_band, floor))

        def excess(t: FloatArray, i: NDArray[np.intp]) -> FloatArray:
            column = t[:, np.newaxis]
            level = np.real(kernel.value(kernel.take(self.driver, i), column))[:, 0]
            future = kernel.future(kernel.take(self.trim, i), flat_pole[i], column)[:, 0]
            demand = np.real(future) * flat_pole[i]
            return np.maximum(level, flat_floor[i]) - flat_band[i] * demand

        both = np.concatenate(ends, axis=-1)
        time = refine(both, np.ones_like(high), excess)
        level = np.real(kernel.value(self.driver, np.nextafter(time, np.inf)[..., np.newaxis]))
        return time, level[..., 0] < floor * (1.0 - 1e-9)


def _fastest_real_pole(plant: Plant) -> FloatArray:
    """The largest real unstable pole, ``(...)``; NaN where there is none."""
    poles = unstable_modes(plant).poles
    if not poles.shape[-1]:
        return np.full(poles.shape[:-1], np.nan)
    real = np.where(np.imag(poles) == 0.0, np.real(poles), -np.inf)
    fastest = np.where(np.isnan(real), -np.inf, real).max(axis=-1)
    return np.where(np.isinf(fastest), np.nan, fastest)


def _check_one_signed(wind: History) -> None:
    values = np.real(kernel.value(wind.pieces, wind.probe_times()))
    size = np.abs(values).max(axis=-1)
    slack = 1e-12 * size
    if np.any((values.min(axis=-1) < -slack) & (values.max(axis=-1) > slack)):
        raise InputError(
            "wind must not change its sign for a boundary limit; got values from"
            f" {values.min():.6g} to {values.max():.6g} rad"
        )
    if np.any(np.isinf(wind.end)):
        raise InputError("wind must end: the last piece of its history must be zero")
