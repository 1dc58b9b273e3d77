"""What a wind asks of a vehicle whose parameters vary while it blows.

Held from the time a on, after trim, the limit that brings the growing part to zero is

    delta_max(a) = -(l.x(a) + future(a))/reach(a),

with the state x that trim has left, the wind still to come in units of the growing part, and the
reach of a unit deflection. With constant parameters it is the demand behind `boundary_limit`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.answers.sizing.growing import ATOL, RTOL, GrowingMode
from tvclin.flights.closed_loop.continuous import smooth_piece
from tvclin.winds.histories import History

FloatArray = NDArray[np.float64]

_BETWEEN = 16
_SLACK = 1e-9
_EDGE = 1e-12


@dataclass(frozen=True, eq=False)
class VaryingNeed:
    """Deflections [rad] that one wind asks of a vehicle along its flight.

    Attributes
    ----------
    trim : float
        Largest |B(t) alpha_w(t)|, ideal trim without drift.
    required : ndarray
        What (4b) asks of the control at each dead band, ``(k,)``; NaN for a wind that changes its
        sign.
    minimum : float
        The whole wind being known: least peak that leaves nothing of the fastest growing part.
    """

    trim: float
    required: FloatArray
    minimum: float


def varying_need(mode: GrowingMode, wind: History, dead_bands: FloatArray) -> VaryingNeed:
    """Return what a wind asks of a vehicle whose parameters vary.

    Parameters
    ----------
    mode : GrowingMode
        The flight.
    wind : History
        One wind in flight time, within the span of `mode`.
    dead_bands : ndarray
        K, ``(k,)``.

    Notes
    -----
    The dead band is left when the trim deflection reaches K times the limit, as in a flight.
    """
    times = np.unique(wind.probe_times(_BETWEEN))
    times = times[(times >= wind.onset) & (times < wind.end)]
    course = _Course.of(mode, wind)
    trim = np.abs(mode.trim_per_wind(times) * wind(times))
    minimum = abs(course.demand(float(wind.onset)))
    side = -float(np.sign(wind.peak * mode.trim_per_wind(times[0])))
    blows = side * -mode.trim_per_wind(times) * wind(times)
    if np.any(blows < -_EDGE * trim.max()):
        required = np.full(dead_bands.shape, np.nan)
    else:
        driver = np.array([side * course.trim(t) for t in times.tolist()])
        required = np.array([_boundary(course, times, driver, side, K) for K in dead_bands])
    return VaryingNeed(float(trim.max()), required, minimum)


def _boundary(
    course: _Course, times: FloatArray, driver: FloatArray, side: float, K: float
) -> float:
    """The limit at which the dead band is left just when the limit, held from then on, is enough.

    As in `switching`: only new heights of the driver leave it, and of several solutions the last
    has the largest limit.
    """
    from scipy.optimize import brentq

    if K == 0.0:
        return side * course.demand(float(times[0]))
    highest = np.maximum.accumulate(driver)
    new = np.flatnonzero((driver >= highest * (1.0 - _SLACK)) & (driver > 0.0))
    demands = np.array([side * course.demand(t) for t in times[new].tolist()])
    short = np.flatnonzero(driver[new] < K * demands)
    last = int(short[-1]) if short.size else -1
    if last + 1 == new.size:
        trims = [side * course.trim(t) for t in times.tolist()]
        return max(float(highest[-1]) / K, *trims)
    if last < 0:
        return float(demands[0])
    floor = float(driver[new[last]])

    def over(t: float) -> float:
        return max(side * course.trim(t), floor) - K * side * course.demand(t)

    low, high = (float(times[new[i]]) for i in (last, last + 1))
    return side * course.demand(brentq(over, low, high, xtol=1e-12))


@dataclass(frozen=True, eq=False)
class _Course:
    """One wind over one flight: the state under ideal trim, and the wind still to come."""

    mode: GrowingMode
    wind: History
    drifted: Callable[[float], FloatArray]
    future: Callable[[float], FloatArray]

    @classmethod
    def of(cls, mode: GrowingMode, wind: History) -> _Course:
        knots = np.unique(wind.knots)
        knots = knots[(knots >= wind.onset) & (knots <= wind.end)]
        size = mode.matrices(float(knots[0]))[0].shape[-1] - 2

        def drift(t: float, x: FloatArray, blows: Callable[[float], float]) -> FloatArray:
            A, inputs = mode.matrices(t)
            return np.asarray(A[2:, 2:] @ x + inputs[2:] @ [_trim(A, inputs, x, a := blows(t)), a])

        def ahead(t: float, x: FloatArray, blows: Callable[[float], float]) -> FloatArray:
            row, _ = mode.at(t)
            return np.asarray(row[0] * x - row @ mode.matrices(t)[1][:, 1] * blows(t))

        pieces = list(pairwise(knots))
        return cls(
            mode,
            wind,
            _swept(drift, wind, pieces, np.zeros(size)),
            _swept(ahead, wind, [(b, a) for a, b in reversed(pieces)], np.zeros(1)),
        )

    def demand(self, t: float) -> float:
        """The limit [rad], with its sign, that is enough when it is held from t on."""
        row, reach = self.mode.at(t)
        return float(-(row[2:] @ self.drifted(t) + self.future(t)[0]) / reach)

    def trim(self, t: float) -> float:
        """The deflection of ideal trim [rad]."""
        return _trim(*self.mode.matrices(t), self.drifted(t), float(self.wind(t)))


def _trim(A: FloatArray, inputs: FloatArray, x: FloatArray, wind: float) -> float:
    """The deflection [rad] that leaves the attitude nominal while the path drifts."""
    return float(-(A[1, 2:] @ x + inputs[1, 1] * wind) / inputs[1, 0])


def _swept(
    rates: Any, wind: History, pieces: list[tuple[float, float]], state: FloatArray
) -> Callable[[float], FloatArray]:
    """The solution of a linear equation driven by a wind, piece by piece, forwards or backwards."""
    from scipy.integrate import solve_ivp

    starts, solutions = [], []
    for begin, stop in pieces:
        low = min(begin, stop)
        found = solve_ivp(
            rates,
            (begin, stop),
            state,
            method="DOP853",
            rtol=RTOL,
            atol=ATOL,
            dense_output=True,
            args=(smooth_piece(wind, low),),
        )
        starts.append(low)
        solutions.append(found.sol)
        state = found.y[:, -1]
    order = np.argsort(starts)
    edges = np.array(starts)[order]

    def at(t: float) -> FloatArray:
        k = max(int(np.searchsorted(edges, t, side="right")) - 1, 0)
        return np.asarray(solutions[order[k]](t))

    return at
