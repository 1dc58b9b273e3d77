"""Exit of the dead band from curves of trim and demand, beside roots of scipy, both ways to run."""

import numpy as np
import pytest
from scipy.optimize import brentq

from tvclin.kernels import choice
from tvclin.kernels.dead_band import dead_band_exits

STEPS = 8


def exits(trim, demand, slope, dead_band):
    """Return limits and positions of trim and demand, functions of the position in steps."""
    times = np.arange(STEPS)[:, np.newaxis] + np.array([0.0, 0.5, 1.0])
    arrays = [f(times)[np.newaxis] for f in (trim, demand)]
    slopes = slope(times[np.newaxis, :, [0, 2]])
    sign = np.sign(arrays[0].flat[np.argmax(np.abs(arrays[0]))])
    limits, positions = np.empty(1), np.empty(1)
    columns = np.ones((1, STEPS)), *arrays, slopes, np.array([sign])
    choice.run(dead_band_exits, (*columns, dead_band, limits, positions), 1, 1e-6, 1e-6)
    return limits[0], positions[0]


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_dead_band_is_left_where_trim_is_a_fraction_of_the_demand(sign, compiled):
    def trim(t):
        return sign * t * (8.0 - t) / 16.0  # a parabola and a cubic, as the curves of a step

    def demand(t):
        return sign * (1.0 - (t / 8.0) ** 3)

    for K in (0.01, 0.5, 0.99):
        at = brentq(lambda t, K=K: sign * (trim(t) - K * demand(t)), 0.0, 4.0, xtol=1e-15)
        with choice.pinned(compiled):
            limit, position = exits(trim, demand, lambda t: -sign * 3.0 * t**2 / 512.0, K)
        assert position == pytest.approx(at, rel=1e-13)
        assert limit == pytest.approx(abs(demand(at)), rel=1e-13)


def test_of_several_exits_the_last_counts_which_is_at_a_new_maximum():
    def trim(t):
        return np.interp(t, [0, 1, 2, 4, 8], [0.0, 2.0, 1.0, 3.0, 0.0])

    def demand(t):
        return np.interp(t, [0, 1, 2, 8], [1.0, 5.0, 5.0, 5.0])

    def slope(t):
        rising = (np.arange(STEPS) < 1)[:, np.newaxis] & np.ones(2, dtype=bool)
        return np.where(rising, 4.0, 0.0)[np.newaxis]

    limit, position = exits(trim, demand, slope, 0.5)
    assert (limit, position) == pytest.approx((5.0, 3.5), rel=1e-13)


def test_within_the_dead_band_there_is_no_exit():
    limit, position = exits(lambda t: 0.1 * t, lambda t: 1.0 + t, np.ones_like, 0.5)
    assert (limit, position) == (0.0, -1.0)
