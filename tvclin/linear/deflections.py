"""Deflection histories, delta - delta_n [rad], as controls of the open-loop theory.

A constant deflection, a bang-bang deflection between two limits (appendix C), trim of a wind, and
the report's control: trim up to the exit of the dead band, then the limit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import FloatArray, IndexArray
from tvclin.linear.plant import PLANT_HINT, Plant
from tvclin.numerics import pieces as algebra
from tvclin.numerics.pieces import Pieces
from tvclin.numerics.searches import first_crossing
from tvclin.winds.histories import History, Piecewise, linear_pieces

SWITCHES = ("report", "literal")


@dataclass(frozen=True, kw_only=True, eq=False)
class ConstantDeflection(History):
    """Deflection that is constant from its start on, without end.

    Parameters
    ----------
    limit : array_like
        Deflection [rad]. A positive deflection pitches the nose down; it opposes a negative wind.
    start : array_like
        Start time [s]; negative for a start before t = 0.

    Raises
    ------
    InputError
        For a limit of zero, or numbers that are not finite.
    """

    limit: float | FloatArray
    start: float | FloatArray = 0.0

    def __post_init__(self) -> None:
        """Check the fields, and make them floats or arrays."""
        limit = errors.nonzero("limit", self.limit, "rad")
        start = errors.finite("start", self.start, "s")
        errors.together(limit=limit, start=start)
        object.__setattr__(self, "limit", errors.plain(limit))
        object.__setattr__(self, "start", errors.plain(start))

    def _pieces(self) -> Pieces:
        """Pieces of a deflection that is zero up to `start` and `limit` from there on."""
        limit, start = np.broadcast_arrays(self.limit, self.start)
        return linear_pieces(start[..., np.newaxis], limit[..., np.newaxis], 0.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class BangBang(History):
    """Deflection that switches between +limit and -limit, starting with +limit (appendix C).

    Parameters
    ----------
    limit : array_like
        First deflection [rad], ``(...)``, of either sign.
    switch_times : array_like
        Times [s] at which the sign changes, ``(..., n)``, not decreasing and not before `start`.
        The deflection stays constant after the last.
    start : array_like
        Start time [s].

    Raises
    ------
    InputError
        For a limit of zero, or switch times that decrease or precede the start.
    """

    limit: float | FloatArray
    switch_times: FloatArray
    start: float | FloatArray = 0.0

    def __post_init__(self) -> None:
        """Check the fields, and make them floats or arrays."""
        limit = errors.nonzero("limit", self.limit, "rad")
        start = errors.finite("start", self.start, "s")
        times = np.atleast_1d(errors.finite("switch_times", self.switch_times, "s"))
        # the last axis of the times, which may be empty, does not broadcast
        first = times[..., 0] if times.size else limit
        errors.together(limit=limit, start=start, switch_times=first)
        if times.size and (np.any(np.diff(times) < 0.0) or np.any(times[..., 0] < start)):
            raise errors.InputError(
                f"switch_times must not decrease, nor come before start"
                f" ({errors.shown(start.tolist())} s); got {errors.shown(times.tolist())}"
            )
        object.__setattr__(self, "limit", errors.plain(limit))
        object.__setattr__(self, "start", errors.plain(start))
        object.__setattr__(self, "switch_times", times)

    def _pieces(self) -> Pieces:
        """Pieces of a deflection at the limit, whose sign changes at each switching time."""
        limit, start = np.asarray(self.limit), np.asarray(self.start)
        count = self.switch_times.shape[-1]
        shape = np.broadcast_shapes(limit.shape, start.shape, self.switch_times.shape[:-1])
        first = np.broadcast_to(start[..., np.newaxis], (*shape, 1))
        switches = np.broadcast_to(self.switch_times, (*shape, count))
        breakpoints = np.concatenate([first, switches], axis=-1)
        return linear_pieces(
            breakpoints, limit[..., np.newaxis] * (-1.0) ** np.arange(count + 1), 0.0
        )


def trim_deflection(plant: Plant, wind: History) -> History:
    """Return the deflection that keeps the attitude nominal in a wind, exactly [rad].

    On a fixed path it is -B alpha_w, with the trim deflection B per angle of attack; on the models
    with drift the wind passes the filter -B (s + b2)/(s + b1), because the vehicle drifts with the
    wind: the report's eq before (17), with b1 and b2 [1/s] of `Coefficients`.

    Parameters
    ----------
    plant : Plant
        One plant or a batch.
    wind : History
        Wind angle of attack; batches broadcast.
    """
    errors.instance("plant", plant, Plant, PLANT_HINT)
    errors.instance("wind", wind, History, "such as TriangularWind")
    from_wind = plant.numerator("attitude", "wind")
    return wind.filter(-from_wind, plant.numerator("attitude", "deflection"))


def trim_then_hold(
    plant: Plant,
    wind: History,
    limit: ArrayLike,
    dead_band: ArrayLike = 1.0,
    switch: str = "report",
) -> History:
    """Return the report's control: trim up to the exit of the dead band, then the limit.

    Parameters
    ----------
    plant : Plant
        The plant that is trimmed, one or a batch.
    wind : History
        Wind angle of attack. Where it changes sign, only the interval that the limit opposes
        can leave the dead band.
    limit : array_like
        Deflection limit delta_max [rad] with its sign: it opposes the wind,
        delta_max = -y B alpha_w,max.
    dead_band : array_like
        K, the fraction of the limit up to which the vehicle is trimmed, in [0, 1].
    switch : {"report", "literal"}
        Quantity that exits the dead band at K times the limit: ``|B alpha_w|`` (eqs (10), (11)),
        or the trim deflection itself. They differ on the models with drift, where the report
        switches a little early.

    Returns
    -------
    History
        Deflection [rad]; trim throughout where the dead band is never exited.

    Raises
    ------
    InputError
        When the limit has the sign of the wind moment instead of opposing it, and for a dead band
        outside [0, 1].
    """
    limit = errors.small_angle("a deflection", errors.nonzero)("limit", limit)
    dead_band = errors.within("dead_band", dead_band, 0.0, 1.0)
    trim = trim_deflection(plant, wind)
    # sign of trim, -B alpha_w: B is trim deflection per angle of attack
    opposing = -np.sign(np.asarray(plant.coefficients.B) * wind.peak)
    if np.any(opposing * limit < 0.0):
        raise errors.InputError(
            "limit must oppose the wind, with the sign of -B alpha_w,max; got"
            f" {limit.ravel()[0]:.6g} rad against a wind of {np.ravel(wind.peak)[0]:.6g} rad"
        )
    literal = errors.one_of("switch", switch, SWITCHES) == "literal"
    # the deflection that is compared with K times the limit [rad]: trim with drift, or without
    compared = trim if literal else wind * -np.asarray(plant.coefficients.B)
    time = exit_time(compared, limit, dead_band)
    exits = np.isfinite(time)
    # the limit from the exit on; without an exit zero, from any time on
    limit_after_exit = linear_pieces(
        np.where(exits, time, wind.knots[..., -1])[..., np.newaxis],
        np.where(exits, limit, 0.0)[..., np.newaxis],
        0.0,
    )
    return trim.before(time) + Piecewise(limit_after_exit)


def exit_time(deflection: History, limit: ArrayLike, dead_band: ArrayLike) -> FloatArray:
    """Return the first time [s] at which a deflection reaches `dead_band` times `limit`.

    Shape ``broadcast(deflection.batch, limit.shape, dead_band.shape)``; inf where it never does.
    `deflection`: histories of trim [rad]. `limit`: deflection limit with the sign of the trim
    [rad]. `dead_band`: K in [0, 1]; with zero the time is the onset of the deflection.
    """
    limit, dead_band = np.asarray(limit, dtype=float), np.asarray(dead_band, dtype=float)
    relative = deflection * (1.0 / limit)
    shape = np.broadcast_shapes(relative.batch, dead_band.shape)
    level = np.broadcast_to(dead_band, shape)
    pieces = algebra.spread(relative.pieces, shape)

    def excess(t: FloatArray, index: IndexArray) -> FloatArray:
        """Return deflection/limit - K at times t [s] of k cases at positions `index`, ``(k,)``."""
        values = algebra.value(algebra.take(pieces, index), t[:, np.newaxis])[:, 0]
        return np.real(values) - level.ravel()[index]

    times = relative.probe_times()  # samples around all breakpoints
    values = np.real(algebra.value(pieces, times)) - level[..., np.newaxis]
    onset = np.broadcast_to(relative.onset, shape)
    return np.where(level > 0.0, first_crossing(times, values, excess), onset)
