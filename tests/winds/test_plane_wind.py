"""Winds with a direction, against their values, quadrature, and the pole that a veer is."""

import numpy as np
import pytest
from scipy.integrate import quad

import tvclin as tv
from tvclin import InputError
from tvclin.winds import PlaneWind

EPS = np.finfo(float).eps
GUST = tv.TriangularWind(peak=0.08, duration=7.5)
SMOOTH = tv.OneMinusCosineGust(peak=-0.05, duration=4.0).shift(2.0)
FILTERED = GUST.filter([1.0], [1.0, 0.6, 4.0]).before(20.0)
WINDS = (GUST, SMOOTH, FILTERED, tv.RectangularWind(peak=0.03, duration=5.0))


@pytest.mark.parametrize("wind", WINDS)
@pytest.mark.parametrize("rate", [-0.4, 0.1, 3.0])
def test_a_veering_wind_is_its_size_times_a_turning_unit_vector(wind, rate):
    t = np.linspace(-1.0, 22.0, 200)
    result = PlaneWind.veering(wind, 0.7, rate)(t)
    expected = wind(t) * np.exp(1j * (0.7 + rate * (t - float(wind.onset))))
    # the terms of a filtered wind are larger than their sum, by less than a hundred
    assert np.abs(result - expected).max() <= 100 * EPS


@pytest.mark.parametrize("wind", WINDS)
def test_veer_is_a_complex_pole(wind):
    """The discounted future is that of the straight wind at p - j rate, turned."""
    p, rate, angle = 0.5, 0.8, -0.3
    t = np.array([-1.0, 0.5, 3.0])
    begun = angle + rate * (t - float(wind.onset))
    expected = np.exp(1j * begun) * wind.remaining_integral(p - 1j * rate, t)
    result = PlaneWind.veering(wind, angle, rate).remaining_integral(p, t)
    # each integral is within rounding of the sum of its terms, of which there are some hundred
    assert (
        np.abs(result - expected).max() <= 1e3 * EPS * np.abs(wind.remaining_integral(p, t)).max()
    )


def test_the_triangle_in_closed_form_and_by_quadrature():
    p, rate = 0.53, np.radians(90) / 7.5
    s, tau = p - 1j * rate, 7.5
    wind = PlaneWind.veering(GUST, 0.0, rate)
    computed = p * wind.remaining_integral(p, 0.0) / 0.08
    closed = p * (2.0 / tau) * (1.0 - np.exp(-s * tau / 2.0)) ** 2 / s**2
    assert computed == pytest.approx(closed, rel=1e-13)
    parts = [
        quad(lambda t, f=f: np.exp(-p * t) * f(wind(t)), 0, tau, points=[tau / 2])[0]
        for f in (np.real, np.imag)
    ]
    assert computed == pytest.approx(p * complex(*parts) / 0.08, abs=2e-8)  # of quad: 1.5e-8


@pytest.mark.thorough
def test_the_peak_is_that_of_the_vector():
    across = PlaneWind(pitch=GUST, yaw=0.75 * GUST.shift(3.0))
    t = np.linspace(0.0, 11.0, 20001)
    # straight lines: largest at a knot, which may lie between two times
    assert across.peak == pytest.approx(np.abs(across(t)).max(), rel=1e-3)
    assert across.peak >= np.abs(across(t)).max()
    assert across.peak < np.hypot(across.pitch.peak, across.yaw.peak) * 0.99
    for wind in WINDS:
        for rate in (0.0, 0.9):
            veering = PlaneWind.veering(wind, 1.0, rate)
            assert veering.peak == pytest.approx(abs(wind.peak), rel=1e-9)


def test_a_wind_of_one_direction_is_known_as_one():
    assert PlaneWind.towards(GUST, 1.1).unidirectional
    assert PlaneWind(pitch=GUST, yaw=-2.0 * GUST).unidirectional
    assert PlaneWind(pitch=GUST, yaw=0.0 * SMOOTH).unidirectional
    assert not PlaneWind(pitch=GUST, yaw=GUST.shift(1e-3)).unidirectional
    for between in (1.0, 9.0, 65.0):  # half turns, at whatever times one looks
        steady = tv.RectangularWind(peak=0.03, duration=5.0)
        assert not PlaneWind.veering(steady, 0.0, np.pi * between / 5.0).unidirectional


@pytest.mark.parametrize("turns", [0, 1, 2, 3])
def test_along_an_axis_a_wind_is_the_same_to_the_last_digit(turns):
    wind = PlaneWind.towards(GUST, turns * np.pi / 2.0)
    line = wind.component(wind.direction)
    assert np.array_equal(np.abs(line.pieces.coefficients), np.abs(GUST.pieces.coefficients))
    assert wind.peak == 0.08
    other = wind.yaw if turns % 2 == 0 else wind.pitch
    assert np.isinf(other.onset)


def test_a_batch_is_what_each_is_alone():
    gusts = tv.TriangularWind(peak=[[0.05], [-0.08]], duration=[5.0, 7.5, 9.0])
    angles, rates = np.array([0.1, 2.0, -1.0]), np.array([0.0, 0.2, -0.3])
    both = PlaneWind.veering(gusts, angles, rates)
    assert both.batch == both.peak.shape == both.onset.shape == (2, 3)
    t = np.array([0.5, 4.0])
    for i in range(2):
        for k in range(3):
            gust = tv.TriangularWind(peak=gusts.peak[i, k], duration=gusts.duration[i, k])
            single = PlaneWind.veering(gust, angles[k], rates[k])
            # angles of some radians, and so their vectors, are known to some EPS
            assert np.abs(both(t)[i, k] - single(t)).max() <= 20 * EPS * 0.08
            assert both.peak[i, k] == pytest.approx(float(single.peak), rel=1e-9)
            assert both.unidirectional[i, k] == single.unidirectional == (rates[k] == 0.0)
            assert np.array_equal(both.case(3 * i + k, (2, 3))(t), both(t)[i, k])


def test_a_west_jet_meets_a_slanting_flight_in_both_planes():
    """With 50 m/s at 45 degrees: in pitch with the sine of the path angle, in yaw without."""
    booster = tv.load_vehicle("configuration-i")
    jet = tv.WindProfile(
        height=[9e3, 10e3, 12e3, 14e3], east=[0.0, 50.0, 50.0, 0.0], north=[0.0] * 4
    )
    climb = tv.winds.steady_climb(booster, height=11e3, start=60.0, stop=70.0)
    wind = jet.to_winds(climb, azimuth=np.radians(45))
    for plane, sine in (("pitch", np.sin(booster.attitude)), ("yaw", 1.0)):
        single = jet.to_wind(climb, azimuth=np.radians(45), plane=plane)
        assert np.array_equal(getattr(wind, plane).pieces.knots, single.pieces.knots)
        expected = np.arcsin(50.0 * np.sqrt(0.5) * sine / booster.velocity)
        assert abs(single(65.0)) == pytest.approx(expected, rel=1e-12)
    assert np.real(wind(65.0)) > 0.0 > np.imag(wind(65.0))  # from behind, and from the left
    assert np.degrees(wind.peak) == pytest.approx(4.6028, abs=5e-5)
    along = jet.to_winds(climb, azimuth=np.radians(90))
    assert along.unidirectional
    calm = tv.WindProfile(height=[9e3, 14e3], east=[0.0, 0.0], north=[0.0, 0.0])
    with pytest.raises(InputError, match="the wind must blow along the flight"):
        calm.to_winds(climb, azimuth=0.0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: PlaneWind(pitch=GUST, yaw=0.1), "yaw must be a History"),
        (lambda: PlaneWind.towards(GUST, np.nan), "angle must be finite"),
        (lambda: PlaneWind.veering(GUST, 0.0, 100.0), "less than 100 times"),
        (
            lambda: PlaneWind.veering(tv.linear.ConstantDeflection(limit=0.1), 0.0, 0.1),
            "wind must end",
        ),
        (lambda: PlaneWind.veering(GUST, [0.0, 1.0], [0.1, 0.2, 0.3]), "broadcast together"),
    ],
)
def test_what_is_no_wind_with_a_direction_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
