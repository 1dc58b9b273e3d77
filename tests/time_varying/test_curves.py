"""What is read from trim and demand over time, beside the roots of polynomials of both.

A quadratic trim and a cubic demand are the curves within their steps exactly.
"""

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from scipy.optimize import brentq

from tvclin.time_varying.curves import Curves, at_substeps

ONSET = 62.0
EDGES = np.array([0.0, 0.7, 1.9, 3.1, 4.6, 5.5, 5.5, 7.2, 8.0])  # two breakpoints coincide
SAMPLES = np.stack([EDGES[:-1], 0.5 * (EDGES[:-1] + EDGES[1:]), EDGES[1:]], axis=-1)
TRIM = Polynomial([0.0, 8.0, -1.0]) * 0.01 / 16.0  # 0.01 rad after 4 s, between two samples
FALLING = 0.014 * Polynomial([1.0, -0.1]) ** 3
HIGH = Polynomial([0.05, 0.001])
STEADY = Polynomial([0.0, 0.001])


def of_both_signs(trim, demand):
    """Return the curves of a wind in one direction and in the other."""
    signs = np.array([1.0, -1.0])
    times, trims, demands = SAMPLES + ONSET, trim(SAMPLES), demand(SAMPLES)
    rows = [np.multiply.outer(signs, x) for x in (-trims, trims, demands)]
    slope = np.multiply.outer(signs, demand.deriv()(SAMPLES[:, ::2]))
    extremes = [min(trims.min(), 0.0), max(trims.max(), trim(4.0))]
    ends = np.sort(np.multiply.outer(signs, extremes), axis=-1)
    path = np.zeros((2, EDGES.size, 0))
    return Curves(np.stack([times, times]), *rows, ends, slope, path)


def crossing(demand, first=0.0, last=4.0):
    """Return the time [s], between two, at which trim crosses a demand, a function of time."""
    return brentq(lambda t: TRIM(t) - demand(t), first, last, xtol=1e-14)


@pytest.mark.parametrize(
    ("demand", "first", "last"),
    [
        # in the first half of a step, in the second, and in each half of a step with either higher
        (FALLING, 0.0, 4.0),
        (1.5 * FALLING, 0.0, 4.0),
        (Polynomial([0.0097, 5e-5]), 4.0, 4.6),
        (Polynomial([0.0101, -5e-5]), 3.1, 4.0),
        # as trim falls, after a lower crossing as it rises
        (Polynomial([0.001, 0.0012]), 4.0, 8.0),
    ],
)
def test_the_trim_law_requires_trim_where_it_crosses_the_demand_of_its_sign(demand, first, last):
    curves, time = of_both_signs(TRIM, demand), crossing(demand, first, last)
    unpaired = np.zeros(curves.trim.shape, dtype=bool)
    limit, at = curves.limit_of_trim_law(unpaired)
    np.testing.assert_allclose(limit, TRIM(time), rtol=1e-12)
    np.testing.assert_allclose(at, ONSET + time, rtol=1e-13)
    for sign, expected in ((1.0, [TRIM(time), 0.0]), (-1.0, [0.0, TRIM(time)])):
        limit, _ = curves.limit_of_trim_law(unpaired, sign)
        np.testing.assert_allclose(limit, expected, rtol=1e-12)


def test_where_a_pair_is_unstable_all_of_trim_counts():
    curves = of_both_signs(TRIM, FALLING)
    limit, at = curves.limit_of_trim_law(np.ones(curves.trim.shape, dtype=bool))
    np.testing.assert_array_equal(limit, TRIM(SAMPLES).max())
    np.testing.assert_allclose(at, ONSET + 3.85, rtol=1e-15)


def test_trim_that_rises_to_the_end_has_its_limits_there():
    curves = of_both_signs(STEADY, HIGH)
    for limit, at in (
        curves.limit_of_trim_law(np.zeros(curves.trim.shape, dtype=bool)),
        curves.limit_of_dead_band(1.0),
    ):
        np.testing.assert_allclose(limit, 0.008, rtol=1e-14)
        np.testing.assert_allclose(at, ONSET + 8.0, rtol=1e-15)


def test_no_demand_within_a_step_is_above_its_bound_which_a_slope_alone_reaches():
    zero = Polynomial([0.0])
    curves = of_both_signs(TRIM, zero)
    curves.demand_slope[:, :, 0] = 0.01  # at the begin of each step
    lengths, fractions = np.diff(EDGES), np.linspace(0.0, 1.0, 301)
    bounds = curves._largest_demand(None)
    for step in np.flatnonzero(lengths):
        inside = curves.demand_at(np.zeros(300, dtype=int), step + fractions[:-1])
        np.testing.assert_allclose(inside.max(), bounds[0, step], rtol=1e-5)


def test_below_a_high_demand_the_trim_law_requires_the_largest_trim_between_two_samples():
    curves = of_both_signs(TRIM, HIGH)
    limit, at = curves.limit_of_trim_law(np.zeros(curves.trim.shape, dtype=bool))
    np.testing.assert_allclose(limit, 0.01, rtol=1e-14)
    np.testing.assert_allclose(at, ONSET + 4.0, rtol=1e-14)


@pytest.mark.parametrize("dead_band", [0.1, 0.5, 0.8])
def test_a_dead_band_is_left_where_trim_is_k_times_the_demand(dead_band):
    limit, at = of_both_signs(TRIM, FALLING).limit_of_dead_band(dead_band)
    time = crossing(dead_band * FALLING)
    np.testing.assert_allclose(limit, FALLING(time), rtol=1e-11)
    np.testing.assert_allclose(at, ONSET + time, rtol=1e-12)


def test_without_a_dead_band_the_limit_is_the_demand_at_the_onset():
    limit, at = of_both_signs(TRIM, FALLING).limit_of_dead_band(0.0)
    np.testing.assert_array_equal(limit, 0.014)
    np.testing.assert_array_equal(at, ONSET)


def test_trim_that_jumps_above_k_times_the_demand_at_the_onset_leaves_its_dead_band_there():
    limit, at = of_both_signs(Polynomial([0.01]), FALLING).limit_of_dead_band(0.5)
    np.testing.assert_array_equal(limit, 0.014)
    np.testing.assert_array_equal(at, ONSET)


def test_a_dead_band_that_trim_does_not_leave_has_the_largest_trim_over_k():
    limit, at = of_both_signs(TRIM, HIGH).limit_of_dead_band(0.5)
    np.testing.assert_allclose(limit, 0.02, rtol=1e-14)
    np.testing.assert_allclose(at, ONSET + 3.85, rtol=1e-15)  # of the largest sample


def test_with_a_minimum_peak_the_dead_band_is_left_on_straight_lines_between_its_values():
    peaks = FALLING(EDGES)
    minimum = np.broadcast_to(np.stack([peaks[:-1], peaks[1:]], axis=-1), (2, EDGES.size - 1, 2))
    limit, at = of_both_signs(TRIM, HIGH).limit_with_minimum(minimum, 0.5)
    time = crossing(lambda t: 0.5 * np.interp(t, EDGES, peaks))
    np.testing.assert_allclose(limit, np.interp(time, EDGES, peaks), rtol=1e-11)
    np.testing.assert_allclose(at, ONSET + time, rtol=1e-12)


@pytest.mark.parametrize(("opposite", "defined"), [(1.1e-6, False), (0.9e-6, True)])
def test_a_dead_band_has_no_limit_in_a_wind_of_two_signs(opposite, defined):
    curves = of_both_signs(TRIM, FALLING)
    wind = curves.wind.copy()
    wind[:, -1, 2] = -opposite * wind[:, 3, 1]
    curves = replace(curves, wind=wind)
    for dead_band in (0.0, 0.5):
        assert np.all(np.isfinite(curves.limit_of_dead_band(dead_band)[0]) == defined)


def test_trim_leaves_its_dead_band_at_the_begin_of_a_step_with_a_limit_of_trim_over_k():
    ratios = of_both_signs(TRIM, FALLING).trim_ratios(0.5)
    # up to the step of the largest sample, 3.85 s; at its end trim has been larger before
    expected = [np.inf, *TRIM(EDGES[1:4]) / 0.5, np.inf, *[np.nan] * 4]
    np.testing.assert_allclose(ratios, [expected, expected], rtol=1e-14)
    rising = of_both_signs(STEADY, HIGH)
    np.testing.assert_allclose(rising.trim_ratios(0.5)[0, 1:], 0.002 * EDGES[1:], rtol=1e-14)
    at_a_begin = Polynomial([0.0, 9.2, -1.0])  # largest after 4.6 s, the begin of the fifth step
    expected = [np.inf, *at_a_begin(EDGES[1:5]) / 0.5, np.inf, *[np.nan] * 3]
    ratios = of_both_signs(at_a_begin, HIGH).trim_ratios(0.5)
    np.testing.assert_allclose(ratios, [expected, expected], rtol=1e-14)


def test_trim_exceeds_a_limit_in_as_many_intervals_as_its_size_does():
    through_zero = of_both_signs(Polynomial([-0.01, 0.0025]), HIGH)
    assert through_zero.is_crossed_twice(np.array([0.005, 0.011])).tolist() == [True, False]
    assert through_zero.is_crossed_twice(np.array([0.0095, 0.0095])).all()  # at both ends alone
    single = of_both_signs(TRIM, HIGH)
    assert single.is_crossed_twice(np.array([0.005, 0.005])).tolist() == [False, False]


def test_both_signs_count_from_95_percent_of_a_limit_above_zero():
    curves = of_both_signs(TRIM, HIGH)
    ranges = np.array([[-0.0096, 0.02], [-0.03, 0.0094]])
    curves = replace(curves, trim_range=ranges)
    assert curves.reaches_both_signs(np.full(2, 0.01)).tolist() == [True, False]
    assert curves.reaches_both_signs(np.zeros(2)).tolist() == [False, False]
    np.testing.assert_array_equal(curves.largest_trim, [0.02, 0.03])
    np.testing.assert_array_equal(curves.sign, [1.0, -1.0])


@pytest.mark.parametrize(("demand", "largest"), [(HIGH, 0.058), (FALLING, 0.01)])
def test_the_highest_limit_is_above_trim_and_the_last_demand(demand, largest):
    np.testing.assert_allclose(of_both_signs(TRIM, demand).highest_limit, 1.001 * largest)


def test_curves_of_selected_winds_are_their_rows():
    curves = of_both_signs(TRIM, FALLING)
    (selected,) = curves.of(np.array([1])).trim
    np.testing.assert_array_equal(selected, curves.trim[1])
    assert curves.of(np.array([0, 1])) is curves


def test_values_at_substeps_are_those_of_the_parabola_of_each_step():
    computed = at_substeps(TRIM(SAMPLES)[np.newaxis], 3)[0]
    fractions = np.arange(3)[:, np.newaxis] / 3.0 + [0.0, 1.0 / 6.0, 1.0 / 3.0]
    times = (
        EDGES[:-1, np.newaxis, np.newaxis] + np.diff(EDGES)[:, np.newaxis, np.newaxis] * fractions
    )
    np.testing.assert_allclose(computed, TRIM(times).reshape(-1, 3), atol=1e-17)
