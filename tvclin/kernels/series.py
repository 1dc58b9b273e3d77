"""Taylor series of flights within their regions of limits, and what is read from them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels import flight_table as table

FloatArray = NDArray[np.float64]

_TERMS = table.ORDER + 1


@dataclass(frozen=True, eq=False)
class Series:
    """Coefficients in the time from now, lowest power first.

    Attributes
    ----------
    y : ndarray
        States of plant (4), nozzle (2) and law (1), ``(7, 12, m)``. Without an actuator the first
        state of the nozzle is the deflection.
    demand, alpha, watch : ndarray
        Deflection asked for, angle of attack, and what watches the rate limit, ``(12, m)``: the
        rate of the nozzle, or what pulls at one that is held.
    """

    y: FloatArray
    demand: FloatArray
    alpha: FloatArray
    watch: FloatArray


def taylor(
    rows: FloatArray, order: int, servo: int, y: FloatArray, wind: FloatArray, regions: FloatArray
) -> Series:
    """Return the series of flights at the states ``y (7, m)``, each in its regions ``(3, m)``."""
    mode, stop, hold = regions
    s = np.zeros((7, _TERMS + 1, y.shape[1]))
    s[:, 0] = y
    demand, alpha, watch = (np.zeros((_TERMS, y.shape[1])) for _ in range(3))
    for k in range(_TERMS):
        theta, rate, path, speed, position, spin, memory = s[:, k]
        gust = wind[k] if k < len(wind) else 0.0
        first = float(k == 0)
        alpha[k] = theta - path - gust
        demand[k] = rows[table.K_ATTITUDE] * theta + rows[table.K_RATE] * rate
        demand[k] += rows[table.K_PATH] * path + rows[table.K_ALPHA] * alpha[k]
        demand[k] += rows[table.K_MEMORY] * memory
        command = np.where(mode == 0.0, demand[k], first * mode * rows[table.LIMIT])
        deflection = command
        if servo == 0:
            s[4, k] = command
            watch[max(k - 1, 0)] = k * command
        else:
            deflection = np.where(stop == 0.0, position, first * stop * rows[table.LIMIT])
            pull = rows[table.STIFFNESS] * (command - position) - rows[table.DRAG] * spin
            watch[k] = pull
            if servo == 2:
                watch[k] = np.where(hold == 0.0, spin, pull)
                s[4, k + 1], s[5, k + 1] = spin, np.where(hold == 0.0, pull, 0.0)
            else:
                held = hold * np.where(hold == 0.0, 0.0, rows[table.RATE_LIMIT])
                s[4, k + 1] = np.where(hold == 0.0, pull, first * held)
        s[0, k + 1], s[6, k + 1] = rate, theta
        s[1, k + 1] = rows[table.MU] * theta + rows[table.MU_PATH] * path
        s[1, k + 1] += rows[table.MOMENT] * deflection + rows[table.GUST] * gust
        if order > 2:
            s[2, k + 1] = rows[table.PATH_ATTITUDE] * theta + rows[table.PATH_PATH] * path
            s[2, k + 1] += rows[table.PATH_SPEED] * speed + rows[table.PATH_GUST] * gust
            s[2, k + 1] += rows[table.PATH_DEFLECTION] * deflection
            s[3, k + 1] = rows[table.SPEED_PATH] * path
        s[:, k + 1] /= k + 1
    return Series(s[:, :_TERMS], demand, alpha, watch)


def lengths(rows: FloatArray, series: Series, trial: FloatArray) -> FloatArray:
    """Return steps [s] whose last two terms stay within the accuracy.

    That is over the wind's peak, or over an attitude that is larger. A step changes about as the
    11th root of what there is to spare, taken from the bits of a number, which are its logarithm,
    or so: within 6 percent.
    """
    last, before = np.abs(series.y[:, table.ORDER]), np.abs(series.y[:, table.ORDER - 1])
    error = (last[0] * trial + before[0]) * rows[table.SCALE]
    error += table.SERVO_SHARE * (last[4] * trial + before[4]) * rows[table.SERVO_SCALE]
    size = np.maximum(np.abs(series.y[0, 0]) * rows[table.SCALE], 1.0)
    spare = rows[table.ACCURACY] * size / np.maximum(error * trial ** (table.ORDER - 1), 1e-30)
    bits = spare.view(np.int64) - table.ONE
    factor = (table.ONE + (bits >> 4) + (bits >> 5)).view(np.float64)
    return np.minimum(trial * np.minimum(table.SAFE * factor, table.GROWTH), 1e6)


def jet(c: FloatArray, t: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return value, slope and half the curvature of series ``(..., 12, m)`` at times ``(m,)``."""
    value = slope = bend = np.zeros_like(c[..., 0, :])
    for k in range(table.ORDER, -1, -1):
        bend = bend * t + slope
        slope = slope * t + value
        value = value * t + c[..., k, :]
    return value, slope, bend


def summits(c: FloatArray, h: FloatArray, known: FloatArray) -> FloatArray:
    """Return the largest size of a series within steps, or what was known if that is larger."""
    end, fall, _ = jet(c, h)
    known = np.maximum(known, np.maximum(np.abs(c[0]), np.abs(end)))
    one, other = c[0] + c[1] * h, end - fall * h
    bound = np.where(c[1] > 0.0, np.maximum(one, other), -np.minimum(one, other))
    here = np.flatnonzero((c[1] * fall < 0.0) & (bound > known))
    if here.size:
        part = c[:, here]
        found = jet(part, _root(part, np.zeros(here.size), h[here], 0.0, turn=True))[0]
        known[here] = np.maximum(known[here], np.abs(found))
    return known


def exits(
    c: FloatArray, h: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return when series first leave their bounds within steps, and to which side; or h, 0."""
    end, fall, _ = jet(c, h)
    one, other = c[0] + c[1] * h, end - fall * h
    out = ~((low <= end) & (end <= high))
    out |= (c[1] > 0.0) & (fall < 0.0) & (np.maximum(one, other) > high)
    out |= (c[1] < 0.0) & (fall > 0.0) & (np.minimum(one, other) < low)
    time, side = h.copy(), np.zeros_like(h)
    here = np.flatnonzero(out)
    if here.size:
        time[here], side[here] = _exits(c[:, here], h[here], low[here], high[here])
    return time, side


def _exits(
    c: FloatArray, h: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    end, fall, _ = jet(c, h)
    zero = np.zeros_like(h)
    turn = np.where(c[1] * fall < 0.0, _root(c, zero, h, 0.0, turn=True), h)
    top = jet(c, turn)[0]
    late = (low <= end) & (end <= high)
    side = np.where(end > high, 1.0, np.where(end < low, -1.0, 0.0))
    over = top > high + np.where(np.isinf(high), 0.0, table.GRAZE * np.abs(high))
    under = top < low - np.where(np.isinf(low), 0.0, table.GRAZE * np.abs(low))
    side = np.where(late, np.where(over, 1.0, np.where(under, -1.0, 0.0)), side)
    last = np.where(late, turn, h)
    edge = np.where(side > 0.0, high, np.where(side < 0.0, low, 0.0))
    dips = (side * c[1] < 0.0) & (side * fall > 0.0)
    graze = np.where(dips, table.GRAZE * np.maximum(np.abs(edge), np.abs(end)), 0.0)
    begun_out = side * (c[0] - edge) >= -graze
    returns = dips & (side * (top - edge) < 0.0)
    start = np.where(begun_out & returns, turn, zero)
    time = _root(c, start, np.where(begun_out, h, last), edge, turn=False)
    time = np.where(begun_out & ~returns, 0.0, time)
    return np.where(side == 0.0, h, time), side


def _root(c: FloatArray, low: FloatArray, high: FloatArray, target: Any, turn: bool) -> FloatArray:
    """Where series, or their slopes, pass the target between two times: `compiled.arc_roots`."""

    def miss(t: FloatArray) -> tuple[FloatArray, FloatArray]:
        value, slope, bend = jet(c, t)
        return (slope, 2.0 * bend) if turn else (value - target, slope)

    below, above = miss(low)[0], miss(high)[0]
    apart = np.where(below * above < 0.0, below - above, 1.0)
    chord = low + (high - low) * (below / apart)
    t = np.where(below * above < 0.0, chord, 0.5 * (low + high))
    fine, found = table.FINE * (high - low), np.zeros(t.size, dtype=bool)
    for _ in range(table.ROUNDS):
        off, rise = miss(t)
        under = (off < 0.0) == (below < 0.0)
        low, high = np.where(under, t, low), np.where(under, high, t)
        new = t - off / np.where(rise == 0.0, 1.0, rise)
        near = np.abs(off) <= fine * np.abs(rise)  # there `t` is an end, and `new` may be beyond
        good = near | ((rise != 0.0) & (low < new) & (new < high))
        new = np.where(good, new, 0.5 * (low + high))
        new = np.where(found, t, new)
        found |= np.abs(new - t) <= fine
        t = new
        if np.all(found):
            break
    return t
