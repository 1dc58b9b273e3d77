"""The triangle that stands for a wind, and what it costs."""

import numpy as np
import pytest

import tvclin as tv

EPS = np.finfo(float).eps
PEAK, DEAD_BANDS = 0.08, [1.0, 0.5, 0.0]
PLANT = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.53, B=0.107))
ONE = tv.TriangularWind(peak=PEAK, duration=4.0)


@pytest.mark.parametrize(
    ("wind", "duration"),
    [
        (tv.TriangularWind(peak=PEAK, duration=7.5), 7.5),
        (tv.winds.AsymmetricTriangularWind(peak=PEAK, duration=7.5, peak_time=6.0), 7.5),
        (tv.OneMinusCosineGust(peak=-PEAK, duration=6.0), 6.0),
        (tv.RectangularWind(peak=PEAK, duration=6.0), 12.0),
        # 1/2 + 2 + 3/2 times the peak is the area.
        (tv.winds.TrapezoidalWind(peak=PEAK, rise=1.0, hold=2.0, fall=3.0), 8.0),
        (tv.winds.LayeredGust(peak=PEAK, blend=1.5, plateau=4.0), 11.0),
        (tv.SampledWind(time=[0.0, 1.0, 3.0], angle=[0.0, 0.1, -0.02]), 1.0 + 1.6),
    ],
)
def test_the_equivalent_triangle_has_the_area_and_the_peak(wind, duration):
    triangle = tv.winds.equivalent_triangle(wind)
    assert isinstance(triangle, tv.TriangularWind)
    assert triangle.peak == wind.peak
    assert triangle.duration == pytest.approx(duration, rel=1e-14)
    assert triangle.laplace(0.0) == pytest.approx(wind.laplace(0.0), rel=1e-14)


def test_the_equivalent_triangle_starts_where_the_wind_starts():
    time, angle = [-5.0, -2.0, 0.0, 2.0], [0.0, 0.0, 0.1, 0.0]
    triangle = tv.winds.equivalent_triangle(tv.SampledWind(time=time, angle=angle))
    assert (triangle.onset, triangle.end) == (-2.0, pytest.approx(2.0, rel=1e-14))
    assert triangle.peak == pytest.approx(0.1, rel=4 * EPS)


def test_equivalent_triangles_come_in_batches():
    wind = tv.winds.LayeredGust(peak=[0.1, -0.2], blend=[[1.0], [2.0], [0.0]], plateau=1.0)
    triangles = tv.winds.equivalent_triangle(wind.shift([1.0, 3.0]))
    np.testing.assert_array_equal(triangles.onset, [[1.0, 3.0]] * 3)
    np.testing.assert_allclose(triangles.end, [[5.0, 7.0], [7.0, 9.0], [3.0, 5.0]], rtol=1e-14)


def test_a_triangle_is_its_own_equivalent():
    wind = tv.TriangularWind(peak=[0.1, -0.08], duration=[[0.5], [8.0], [30.0]])
    assert np.abs(tv.boundary.triangle_error(PLANT, wind, 0.5)).max() < 1e-14


@pytest.mark.parametrize("K", DEAD_BANDS)
def test_the_triangle_error_compares_two_boundaries(K):
    gust = tv.OneMinusCosineGust(peak=PEAK, duration=6.0)
    triangle = tv.TriangularWind(peak=PEAK, duration=6.0)
    true, close = (tv.boundary_limit(PLANT, wind, K).deflection for wind in (gust, triangle))
    error = tv.boundary.triangle_error(PLANT, gust, K)
    assert isinstance(error, float)
    assert error == pytest.approx(close / true - 1.0, abs=1e-13)


def test_a_triangle_promises_too_much_for_a_wind_that_comes_all_at_once():
    wind = tv.RectangularWind(peak=PEAK, duration=[3.0, 8.0])
    errors = tv.boundary.triangle_error(PLANT, wind, np.array(DEAD_BANDS)[:, np.newaxis])
    assert errors.shape == (3, 2)
    assert np.all(errors < -0.1)


def test_a_vehicle_that_needs_no_deflection_has_no_triangle_error():
    stable = tv.Coefficients(mu_alpha=-0.3, mu_delta=2.6)
    gust = tv.OneMinusCosineGust(peak=PEAK, duration=6.0)
    assert np.isnan(tv.boundary.triangle_error(tv.Plant.from_coefficients(stable), gust))


@pytest.mark.parametrize(
    ("wind", "message"),
    [
        (ONE - ONE.shift(10.0), r"^wind must have a time integral with the sign of its peak"),
        (ONE - 0.9 * tv.TriangularWind(peak=PEAK, duration=9.0).shift(4.0), r"got -0\.164 rad s"),
        (0.0 * ONE, r"^wind must have a time integral.* got 0 rad s with a peak of 0 rad$"),
        ([1.0, 0.0] * ONE, r"^wind must have a time integral.* got 0 rad s with a peak of 0 rad$"),
        (tv.linear.ConstantDeflection(limit=PEAK), r"^wind must end"),
        (ONE.filter([1.0], [1.0, 0.1]), r"^wind must end"),
        (30.0 * ONE, r"^peak must be a wind angle within 90 degrees.*got .*2\.4 rad"),
    ],
)
def test_a_wind_that_no_triangle_can_stand_for_is_refused(wind, message):
    with pytest.raises(tv.InputError, match=message):
        tv.winds.equivalent_triangle(wind)
