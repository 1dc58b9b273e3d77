"""Histories against quadrature, closed forms, an ODE solver, and the algebra of transforms."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import tvclin as tv
from tvclin.numerics.pieces import Pieces
from tvclin.winds.histories import Piecewise

EPS = np.finfo(float).eps
TIMES = np.sort(np.append(np.linspace(-5.0, 40.0, 91), [0.1, 1 / 3, 2.0, 7.0]))


def tri(peak=0.1, duration=8.0):
    return tv.TriangularWind(peak=peak, duration=duration)


def test_values_take_the_shape_of_the_times():
    h = tri()
    np.testing.assert_allclose(h([[1.0, 4.0, 7.0]]), [[0.025, 0.1, 0.025]], rtol=4e-16)
    assert h([[1.0, 4.0, 7.0]]).shape == (1, 3)


def test_the_value_at_one_time_is_one_number():
    assert np.shape(tri()(4.0)) == ()
    assert tri()(4.0) == 0.1


@pytest.mark.parametrize("s", [1e-300, 1e-12, 1e-6, 1e-3, 0.1, 1.0, 30.0, 80.0])
def test_the_transform_of_a_triangle_is_exact_from_tiny_to_large_s(s):
    with mp.workdps(700):
        z = mp.mpf(s)
        expected = float(mp.mpf(0.1) / 4 * ((1 - mp.exp(-4 * z)) / z) ** 2)
    np.testing.assert_allclose(tri().laplace(s), expected, rtol=4e-15)


def test_the_transform_at_zero_is_the_area():
    assert tri().laplace(0.0) == pytest.approx(0.4, rel=4e-16)
    assert tri().laplace(0.0 + 0.0j) == pytest.approx(0.4, rel=4e-16)


def test_transform_of_a_late_history_is_the_shifted_transform():
    # e^(-s t) itself is rounded by s t epsilon.
    s, dt = 0.53, 1200.0
    expected = float(mp.exp(-mp.mpf(s) * dt)) * tri().laplace(s)
    np.testing.assert_allclose(tri().shift(dt).laplace(s), expected, rtol=s * dt * 2 * EPS)


def test_the_magnitude_of_a_triangle_adds_its_terms_without_their_signs():
    # Rising: a triangle; falling: 0.1 plus a slope of 0.025, over 4 s.
    assert tri().laplace_magnitude(0.0) == pytest.approx(0.2 + (0.4 + 0.2), rel=4e-16)


def test_the_magnitude_of_terms_of_one_sign_is_the_transform():
    c = np.array([[[0.3, 0.1], [0.0, 2.0]], [[0.4, 0.0], [1.0, 0.5]]])
    one = Piecewise(Pieces(np.array([-1.0, 3.0]), c, np.array([-0.8, 0.3])))
    assert one.laplace_magnitude(0.5) == one.laplace(0.5)


def test_the_future_seen_from_the_first_knot_is_the_transform():
    h = tri().shift(3.0)
    expected = h.laplace(0.5) * np.exp(1.5)
    np.testing.assert_allclose(h.remaining_integral(0.5, [3.0])[0], expected, rtol=1e-15)


def test_the_future_stays_exact_late_and_is_zero_after_the_end():
    constant = tv.linear.ConstantDeflection(limit=0.1)
    np.testing.assert_allclose(constant.remaining_integral(0.5, [0.0, 1e4]), [0.2, 0.2], rtol=4e-16)
    np.testing.assert_array_equal(tri().remaining_integral(0.5, [8.0, 1e4]), [0.0, 0.0])


def test_the_future_of_one_variable_is_a_function_of_times():
    s, times = np.array([0.5, 0.2 + 0.3j]), np.array([[-1.0, 2.0], [5.0, 9.0]])
    expected, ahead = tri().remaining_integral(s, times), tri().remaining_integral_of(s)
    assert expected.shape == (2, 2, 2)
    np.testing.assert_array_equal(ahead(times[0]), expected[:, 0])
    np.testing.assert_array_equal(ahead(5.0), expected[:, 1, 0])
    with pytest.raises(tv.InputError, match="t must be finite"):
        ahead(np.nan)


def test_the_future_at_one_time_is_one_number():
    assert tri().remaining_integral(0.0, 0.0) == pytest.approx(0.4, rel=4e-16)


number = st.floats(-2.0, 2.0).map(lambda x: round(x, 6))
variable = st.sampled_from([0.0, 0.4, 2.0, 0.3 + 1j])
dyadic = st.integers(-192, 1280).map(lambda n: n / 64)  # so that sums of times are exact


@st.composite
def histories(draw):
    n = draw(st.integers(2, 6))
    widths = draw(st.lists(st.sampled_from([0.0, 1 / 64, 0.5, 1.0, 7.0]), min_size=n, max_size=n))
    c = np.array(draw(st.lists(number, min_size=4 * n, max_size=4 * n))).reshape(n, 2, 2)
    c[-1] *= 0.0
    rates = [draw(st.sampled_from([0.0, 0.1])), draw(st.sampled_from([-3.0, -0.5]))]
    return Piecewise(Pieces(draw(dyadic) + np.cumsum(widths), c, np.array(rates)))


@settings(max_examples=60, deadline=None, derandomize=True)
@given(histories(), histories(), number, number, variable)
def test_values_and_transforms_are_linear(f, g, a, b, s):
    both = a * f + g * b
    scale = 20 * EPS * (f.laplace_magnitude(s) + g.laplace_magnitude(s)) * 2
    assert abs(both.laplace(s) - (a * f.laplace(s) + b * g.laplace(s))) <= 4 * scale
    np.testing.assert_allclose(both(TIMES), a * f(TIMES) + b * g(TIMES), rtol=0, atol=4e-13)
    np.testing.assert_allclose((f - g)(TIMES), f(TIMES) - g(TIMES), rtol=0, atol=2e-13)
    np.testing.assert_array_equal((-f)(TIMES), -f(TIMES))


@settings(max_examples=60, deadline=None, derandomize=True)
@given(histories(), dyadic, variable)
def test_a_shift_multiplies_the_transform_by_an_exponential(f, dt, s):
    expected = np.exp(-s * dt) * f.laplace(s)
    moved = f.shift(dt)
    rounding = 20 * EPS * (1.0 + 60.0 * abs(s)) * moved.laplace_magnitude(s)
    assert abs(moved.laplace(s) - expected) <= rounding


@pytest.mark.thorough
@settings(max_examples=60, deadline=None, derandomize=True)
@given(histories(), dyadic, variable)
def test_the_cut_and_the_rest_make_the_whole(f, time, s):
    cut = f.before(time)
    rest = f - cut
    early = TIMES < time
    np.testing.assert_array_equal(cut(TIMES), np.where(early, f(TIMES), 0.0))
    np.testing.assert_allclose(rest(TIMES), np.where(early, 0.0, f(TIMES)), rtol=0, atol=2e-13)
    later = np.exp(-s * time) * f.remaining_integral(s, [time])[0]
    total = 40 * EPS * (1.0 + 60.0 * abs(s)) * f.laplace_magnitude(s)
    assert abs(cut.laplace(s) + later - f.laplace(s)) <= total


def test_cutting_at_infinity_changes_nothing_and_cutting_early_leaves_nothing():
    h = tri().filter([1.0], [1.0, 0.5]) - tv.linear.ConstantDeflection(limit=0.1)
    np.testing.assert_array_equal(h.before(np.inf)(TIMES), h(TIMES))
    assert h.before(np.inf).laplace(0.5) == h.laplace(0.5)
    assert not np.any(h.before(-1.0)(TIMES))
    assert h.before(-9.0).onset == np.inf


def test_onset_and_end_skip_what_is_zero():
    constant = tv.linear.ConstantDeflection(limit=0.1, start=-2.0)
    assert (constant.onset, constant.end) == (-2.0, np.inf)
    wind = tv.SampledWind(time=[0.0, 1.0, 2.0, 3.0, 4.0], angle=[0.0, 0.0, 0.1, 0.0, 0.0])
    assert (wind.onset, wind.end) == (1.0, 3.0)
    assert ((0.0 * wind).onset, (0.0 * wind).end) == (np.inf, -np.inf)


def test_the_final_value_is_what_stays():
    assert tri().final_value == 0.0
    assert tri().filter([1.0], [1.0, 0.5]).final_value == 0.0
    assert tv.linear.ConstantDeflection(limit=-0.2).final_value == -0.2
    assert tri().filter([1.0], [1.0, 0.0]).final_value == pytest.approx(0.4, rel=4e-16)
    constant = tv.linear.ConstantDeflection(limit=0.1)
    assert constant.filter([1.0], [1.0, 0.5]).final_value == pytest.approx(0.2, rel=4e-16)
    assert np.isnan(constant.filter([1.0], [1.0, 0.0]).final_value)
    assert np.isnan(constant.filter([1.0], [1.0, -0.5]).final_value)
    assert np.isnan(constant.filter([1.0], [1.0, 0.0, 4.0]).final_value)


def test_the_peak_is_signed_and_sees_the_left_side_of_a_jump():
    assert (tri().peak, (-tri()).peak) == (0.1, -0.1)
    saw = tv.SampledWind(time=[0.0, 1.0, 1.0, 2.0], angle=[0.0, -0.3, 0.2, 0.0])
    assert saw.peak == pytest.approx(-0.3, rel=4e-16)


def test_the_peak_between_knots_is_found_to_rounding():
    c = np.array([[[0.0, 1.0]], [[0.0, 0.0]]])
    h = Piecewise(Pieces(np.array([0.0, 30.0]), c, np.array([-0.37])))  # t e^(-0.37 t)
    assert h.peak == pytest.approx(np.exp(-1) / 0.37, rel=1e-14)
    assert (-h).peak == pytest.approx(-np.exp(-1) / 0.37, rel=1e-14)


def test_probe_times_show_both_sides_of_every_knot_in_order():
    times = tri().probe_times(between=3)
    assert times.shape == (2 * 5 + 1,)
    assert np.all(np.diff(times) >= 0.0)
    assert set(tri().knots) <= set(times)
    assert {np.nextafter(k, -np.inf) for k in (4.0, 8.0)} <= set(times)


def test_histories_refuse_what_is_no_number():
    with pytest.raises(tv.InputError, match=r"^t must be finite"):
        tri()([np.nan])
    with pytest.raises(
        tv.InputError, match=r"^s must be numbers up to 1e\+100 in size, real or complex; got inf$"
    ):
        tri().laplace(np.inf)
    with pytest.raises(tv.InputError, match=r"^s must be"):
        tri().laplace("fast")
    with pytest.raises(tv.InputError, match=r"^factor must be a number"):
        tri() * "twice"
    with pytest.raises(TypeError):
        tri() * tri()
    with pytest.raises(TypeError):
        tri() + 1.0


FILTERS = {
    "gain": ([2.0], [4.0]),
    "lag": ([1.0], [1.0, 0.5]),
    "lead": ([2.0, 0.3], [1.0, 0.5]),
    "integrator": ([1.0], [1.0, 0.0]),
    "almost an integrator": ([1.0], [1.0, -1e-10]),
    "unstable": ([1.0], [2.0, -0.6]),
    "double pole": ([1.0, 0.1], [1.0, 1.0, 0.25]),
    "double integrator": ([1.0], [1.0, 0.0, 0.0]),
    "complex pair": ([3.0, 4.0], [1.0, 0.6, 4.0]),
    "drift": ([-1.0, -0.02], [1.0, 0.0, -0.28, 0.0]),
    "double pair": ([1.0], [1.0, 0.4, 8.04, 1.6, 16.0]),
}
LATE = np.array([0.0, 0.7, 2.0, 4.0, 4.5, 8.0, 9.0, 14.0, 25.0])


def integrated(history, numerator, denominator, times):
    """Return the answer of the filter by stepping its controllable form from knot to knot."""
    order = len(denominator) - 1
    num = np.append(np.zeros(order + 1 - len(numerator)), numerator) / denominator[0]
    den = np.array(denominator) / denominator[0]
    A, out = np.eye(order, k=-1), num[1:] - num[0] * den[1:]
    A[:1] = -den[1:]

    def slope(t, x, end):
        return A @ x + np.eye(1, order)[0] * history([min(t, np.nextafter(end, 0.0))])

    state, values, now = np.zeros(order), [], float(history.knots[0])
    for t in np.unique(np.concatenate([times, history.knots[1:]])):
        if order and t > now:
            solution = solve_ivp(slope, (now, t), state, "DOP853", rtol=3e-14, atol=1e-16, args=[t])
            state = solution.y[:, -1]
        now = t
        if t in times:
            values.append(out @ state + num[0] * history([t])[0])
    return np.array(values)


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("history", [tri(), tv.RectangularWind(peak=0.2, duration=4.5)])
def test_a_filter_answers_as_an_ode_solver_says(name, history):
    expected = integrated(history, *FILTERS[name], LATE)
    size = np.max(np.abs(expected))
    np.testing.assert_allclose(history.filter(*FILTERS[name])(LATE), expected, 0, 1e-12 * size)


@pytest.mark.parametrize("s", [0.9, 3.0, 0.8 + 2j, 1.0 - 9j])
@pytest.mark.parametrize("name", FILTERS)
def test_a_filter_multiplies_the_transform(name, s):
    num, den = FILTERS[name]
    for h in (tri(), tv.linear.ConstantDeflection(limit=0.1, start=1.0)):
        expected = np.polyval(num, s) / np.polyval(den, s) * h.laplace(s)
        np.testing.assert_allclose(h.filter(num, den).laplace(s), expected, rtol=1e-12)


@pytest.mark.thorough
@pytest.mark.parametrize("off", [0.0, 1e-12, -1e-12, 1e-6, -1e-6, 1e-3, -1e-3, 0.3])
@pytest.mark.parametrize("pole", [[1.0, 0.5], [1.0, -0.2], [1.0, 0.6, 4.0]])
def test_a_pole_on_or_near_a_rate_of_the_history_loses_nothing(pole, off):
    shrink = (1.0 + off) ** np.arange(len(pole))
    h = tri().filter([1.0], pole)
    answer = h.filter([1.0], pole * shrink)
    expected = h.laplace(0.9) / np.polyval(pole * shrink, 0.9)
    np.testing.assert_allclose(answer.laplace(0.9), expected, rtol=1e-12)
    values = integrated(tri(), [1.0], np.polymul(pole, pole * shrink), LATE)
    np.testing.assert_allclose(answer(LATE), values, 0, 1e-11 * np.max(np.abs(values)))


@pytest.mark.parametrize("pole", [1e-10, -1e-10, 1e-6, -1e-3])
def test_a_slow_pole_answers_a_held_deflection_to_rounding(pole):
    expected = 0.1 * np.expm1(pole * LATE) / pole
    answer = tv.linear.ConstantDeflection(limit=0.1).filter([1.0], [1.0, -pole])
    np.testing.assert_allclose(answer(LATE), expected, rtol=1e-14)


def test_a_fast_lag_and_a_slow_one_commute_over_long_pieces():
    wind = tv.TriangularWind(peak=0.1, duration=80.0)
    slow_first = wind.filter([1.0], [1.0, 0.1]).filter([25.0], [1.0, 25.0])
    fast_first = wind.filter([25.0], [1.0, 25.0]).filter([1.0], [1.0, 0.1])
    expected = slow_first(LATE)
    np.testing.assert_allclose(fast_first(LATE), expected, 1e-12, 1e-15 * np.max(expected))


def test_a_history_ends_before_no_time_that_is_no_number():
    with pytest.raises(tv.InputError, match=r"^time must be a number; got nan s$"):
        tri().before(np.nan)
    assert tri().before(np.inf).end == tri().end


def test_a_history_shows_how_much_of_it_there_is_and_when():
    samples = tv.SampledWind(time=[1.0, 2.5, 4.0], angle=[0.0, 0.1, 0.0])
    assert repr(samples) == "SampledWind(3 samples from 1 s to 4 s)"
    assert repr(samples.shift(2.0)) == f"Piecewise({samples.knots.size} pieces from 3 s to 6 s)"


def test_a_filter_must_not_differentiate_nor_begin_with_zero():
    for num, den in (([1.0, 0.0], [1.0]), ([1.0], [0.0, 1.0]), ([0.0, 1.0], [2.0])):
        with pytest.raises(tv.InputError, match=r"^numerator must not be of higher degree"):
            tri().filter(num, den)


def test_a_filter_that_numbers_cannot_carry_is_refused():
    denominator = [-3.8e198, 1.0e-208, 3.5e123, -1.2e-289]
    with pytest.raises(tv.InputError, match="denominator"):
        tv.TriangularWind(peak=0.1, duration=5.0).filter([1.0], denominator)


@pytest.mark.parametrize("s", [-700.0, -6.2e60, [0.5, -6.2e60]])
def test_a_future_that_outgrows_every_number_is_refused_in_a_sentence(s):
    wind = tri()
    with pytest.raises(tv.InputError, match="s must be such that"):
        wind.remaining_integral(s, 1.0)


def test_a_filter_whose_poles_outgrow_every_number_is_refused_in_a_sentence():
    with pytest.raises(tv.InputError, match="poles too large for floating-point numbers"):
        tri().filter([1.0], [2.8e-184, -6.1e236, -1.5e279, -4.3e99])
