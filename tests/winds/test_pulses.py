"""Winds: values, transforms in closed form, jumps, batches, and what is refused."""

from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import quad

import tvclin as tv

EPS = np.finfo(float).eps
VARIABLES = [1e-12, 0.01, 0.53, 4.0, 0.3 + 2j, -0.2 + 1j, -0.5]


def ramp(s, t):
    """Integrate r e^(-s r) over r from 0 to t, in 50 digits."""
    with mp.workdps(50):
        z = mp.mpmathify(s)
        return complex((1 - (1 + z * t) * mp.exp(-z * t)) / z**2)


def step(s, t):
    """Integrate e^(-s r) over r from 0 to t, in 50 digits."""
    with mp.workdps(50):
        z = mp.mpmathify(s)
        return complex((1 - mp.exp(-z * t)) / z)


def test_a_rectangular_wind_keeps_its_angle_until_it_stops():
    wind = tv.RectangularWind(peak=-0.08, duration=7.5)
    before_end = np.nextafter(7.5, 0.0)
    times = [-1.0, -1e-300, 0.0, 3.0, before_end, 7.5, 100.0]
    np.testing.assert_array_equal(wind(times), [0.0, 0.0, -0.08, -0.08, -0.08, 0.0, 0.0])


def test_a_pulse_without_a_peak_is_refused_as_python_does():
    with pytest.raises(TypeError, match="missing 1 required keyword-only argument: 'peak'"):
        tv.TriangularWind(duration=7.5)


def test_a_triangular_wind_rises_to_half_its_duration_and_falls():
    wind = tv.TriangularWind(peak=0.1, duration=8.0)
    expected = [0.0, 0.0, 0.025, 0.1, 0.05, 0.0, 0.0]
    np.testing.assert_allclose(wind([-1.0, 0.0, 1.0, 4.0, 6.0, 8.0, 9.0]), expected, rtol=4e-16)


def test_pulses_know_their_peak_onset_and_end():
    for kind in (tv.RectangularWind, tv.TriangularWind):
        wind = kind(peak=-0.08, duration=7.5)
        assert (wind.peak, wind.onset, wind.end, wind.final_value) == (-0.08, 0.0, 7.5, 0.0)


@pytest.mark.parametrize("s", VARIABLES)
def test_the_transform_of_a_rectangle_is_the_closed_form(s):
    wind = tv.RectangularWind(peak=-0.08, duration=7.5)
    np.testing.assert_allclose(wind.laplace(s), -0.08 * step(s, 7.5), rtol=2e-15)


@pytest.mark.parametrize("s", VARIABLES)
def test_the_transform_of_a_triangle_is_a_squared_rectangle(s):
    # A triangle is the convolution of two rectangles of half its duration.
    expected = 0.1 / 3.75 * step(s, 3.75) ** 2
    wind = tv.TriangularWind(peak=0.1, duration=7.5)
    np.testing.assert_allclose(wind.laplace(s), expected, rtol=1e-14)


@pytest.mark.parametrize("s", VARIABLES)
def test_the_transform_of_samples_is_the_sum_of_its_ramps(s):
    time, angle = [-2.0, 0.0, 1.5, 1.5, 6.0], [0.02, 0.1, -0.05, 0.07, 0.03]
    expected = 0.0
    for (t0, a0), (t1, a1) in pairwise(zip(time, angle, strict=True)):
        if t1 > t0:
            w = t1 - t0
            terms = a0 * step(s, w) + (a1 - a0) / w * ramp(s, w)
            expected = expected + np.exp(-s * t0) * terms
    wind = tv.SampledWind(time=time, angle=angle)
    rounding = 10 * EPS * wind.laplace_magnitude(s)
    assert abs(wind.laplace(s) - expected) <= rounding


def test_samples_are_joined_by_straight_lines_and_are_zero_outside():
    time, angle = np.array([1.0, 2.0, 4.0, 5.0]), np.array([0.1, 0.3, -0.2, -0.1])
    wind = tv.SampledWind(time=time, angle=angle)
    inside = np.array([1.0, 1.25, 2.0, 3.0, 4.5])
    np.testing.assert_allclose(wind(inside), np.interp(inside, time, angle), rtol=4e-16)
    np.testing.assert_array_equal(wind([0.0, 0.999999, 5.0, 5.1]), np.zeros(4))
    np.testing.assert_allclose(wind([np.nextafter(5.0, 0.0)]), [-0.1], rtol=1e-15)


def test_a_time_given_twice_is_a_jump():
    wind = tv.SampledWind(time=[0.0, 2.0, 2.0, 3.0], angle=[0.0, 0.1, -0.2, 0.0])
    at_jump = wind([np.nextafter(2.0, 0.0), 2.0])
    np.testing.assert_allclose(at_jump, [0.1, -0.2], rtol=1e-15)
    assert wind.laplace(0.0) == pytest.approx(0.5 * 2.0 * 0.1 - 0.5 * 0.2, abs=1e-17)


def test_jumps_at_both_ends_make_samples_a_rectangle():
    samples = tv.SampledWind(time=[0.0, 0.0, 7.5, 7.5], angle=[0.0, 0.1, 0.1, 0.0])
    wind = tv.RectangularWind(peak=0.1, duration=7.5)
    times = np.linspace(-1.0, 9.0, 41)
    np.testing.assert_array_equal(samples(times), wind(times))
    assert samples.laplace(0.53) == wind.laplace(0.53)


def test_three_samples_make_a_triangle():
    samples = tv.SampledWind(time=[0.0, 4.0, 8.0], angle=[0.0, 0.1, 0.0])
    wind = tv.TriangularWind(peak=0.1, duration=8.0)
    assert samples.laplace(0.5 + 1j) == wind.laplace(0.5 + 1j)


def test_a_measured_wind_has_the_transform_of_its_quadrature():
    rng = np.random.default_rng(7)
    time = np.cumsum(rng.uniform(0.1, 1.0, 200))
    angle = 0.1 * rng.standard_normal(200).clip(-3, 3)
    wind = tv.SampledWind(time=time, angle=angle)
    expected = 0.0
    for low, high in pairwise(time):
        expected += quad(lambda t: np.exp(-0.2 * t) * np.interp(t, time, angle), low, high)[0]
    assert abs(wind.laplace(0.2) - expected) < 20 * EPS * wind.laplace_magnitude(0.2)


BATCH = tv.TriangularWind(peak=[0.1, -0.3], duration=[[4.0], [9.0], [2.5]])
SHIFT, DEN = np.array([[0.0], [3.0], [-2.0]]), np.array([[1.0, 0.5], [1.0, -0.1]])
ONE = tv.TriangularWind(peak=0.1, duration=8.0)
OPERATIONS = {
    "nothing": lambda h, dt, den: h,
    "shift": lambda h, dt, den: h.shift(dt),
    "scale": lambda h, dt, den: dt * h,
    "before": lambda h, dt, den: h.before(dt + 1.0),
    "add": lambda h, dt, den: h + h.shift(dt),
    "subtract": lambda h, dt, den: ONE - h.shift(dt),
    "filter": lambda h, dt, den: h.filter([1.0], den),
    "shift and filter": lambda h, dt, den: h.shift(dt).filter([2.0, 1.0], den),
    "shift one": lambda h, dt, den: ONE.shift(dt + h.knots[..., -1]),
    "shift one and filter": lambda h, dt, den: ONE.shift(dt + h.knots[..., -1]).filter([1.0], den),
    "resonance": lambda h, dt, den: h.filter([1.0], den).filter([1.0], den),
}
QUANTITIES = {
    "value": lambda h: h([-1.0, 0.0, 1.7, 4.5, 9.0, 30.0]),
    "laplace": lambda h: h.laplace(0.7),
    "magnitude": lambda h: h.laplace_magnitude(0.7 + 1j),
    "future": lambda h: h.remaining_integral(0.7 - 0.1j, [-1.0, 2.0, 50.0]),
    "onset": lambda h: h.onset,
    "end": lambda h: h.end,
    "peak": lambda h: h.peak,
    "final": lambda h: h.final_value,
}


@pytest.mark.parametrize("quantity", QUANTITIES)
@pytest.mark.parametrize("operation", OPERATIONS)
def test_a_batch_of_winds_is_the_loop_over_its_elements(operation, quantity):
    change, look = OPERATIONS[operation], QUANTITIES[quantity]
    batch = look(change(BATCH, SHIFT, DEN))
    assert batch.shape[:2] == (3, 2)
    for i, duration in enumerate((4.0, 9.0, 2.5)):
        for j, peak in enumerate((0.1, -0.3)):
            single = tv.TriangularWind(peak=peak, duration=duration)
            expected = look(change(single, SHIFT[i, 0], DEN[j]))
            # A batch with one resonant element is expanded as one: equal to rounding of the terms.
            terms = change(single, SHIFT[i, 0], DEN[j]).laplace_magnitude(0.7)
            rounding = 8 * EPS * terms if quantity in {"laplace", "future"} else 1e-16
            np.testing.assert_allclose(batch[i, j], expected, rtol=1e-14, atol=rounding)


def test_a_transform_broadcasts_its_variable_with_the_batch():
    s = np.array([0.3, 0.9])
    expected = [ONE.laplace(0.3), ONE.laplace(0.9)]
    np.testing.assert_array_equal(ONE.laplace(s), expected)
    assert BATCH.laplace(s).shape == (3, 2)
    assert BATCH.laplace(0.3)[2, 1] == BATCH.laplace(s[::-1])[2, 1]


def test_samples_come_in_batches_over_one_time():
    wind = tv.SampledWind(time=[0.0, 1.0, 2.0], angle=[[0.0, 0.1, 0.0], [0.2, 0.0, -0.2]])
    np.testing.assert_allclose(wind([0.5, 1.5]), [[0.05, 0.05], [0.1, -0.1]], rtol=4e-16)
    assert wind.batch == (2,)


def test_a_wind_angle_follows_from_speed_as_in_equation_b1e():
    angle = tv.angle_from_speed(40.0, 500.0, np.radians(45.0))
    assert np.sin(angle) == pytest.approx(40.0 / 500.0 * np.sqrt(0.5), rel=4e-16)
    assert tv.angle_from_speed(-40.0, 500.0, np.radians(45.0)) == -angle
    assert tv.angle_from_speed(500.0, 500.0, np.pi / 2) == pytest.approx(np.pi / 2)
    assert tv.angle_from_speed([1.0, 2.0, 3.0], 500.0, 0.8).shape == (3,)


@pytest.mark.parametrize("kind", [tv.RectangularWind, tv.TriangularWind])
@pytest.mark.parametrize(
    ("bad", "message"),
    [
        ({"peak": 0.0}, r"^peak must be other than zero; got 0 rad$"),
        ({"peak": 5.0}, r"^peak must be a wind angle within 90 degrees; got 286.479 deg \(5 rad\)"),
        ({"peak": 9e-13}, r"^peak must be at least 1e-12 rad in size; got 9e-13$"),
        ({"peak": np.nan}, r"^peak must be finite; got nan rad$"),
        ({"peak": "5 deg"}, r"^peak must be a number in rad; got '5 deg'$"),
        ({"peak": 0.1 + 0j}, r"^peak must be a number in rad"),
        ({"duration": 0.0}, r"^duration must be positive; got 0 s$"),
        ({"duration": -7.5}, r"^duration must be positive; got -7\.5 s$"),
        ({"duration": np.inf}, r"^duration must be finite; got inf s$"),
        ({"duration": [4.0, 0.0]}, r"^duration must be positive; got 0 s at index 1$"),
        ({"peak": [0.1, 0.2], "duration": [1.0] * 3}, r"shapes that broadcast.*peak.*duration"),
    ],
)
def test_bad_pulses_are_refused_in_one_sentence(kind, bad, message):
    with pytest.raises(tv.InputError, match=message) as caught:
        kind(**{"peak": 0.1, "duration": 7.5} | bad)
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize(
    ("time", "angle", "message"),
    [
        ([0.0], [0.1], r"^time must hold two or more samples"),
        ([0.0, 1.0], [0.1, 0.2, 0.3], r"^time must hold two or more .* \(2,\) .* \(3,\)$"),
        ([[0.0, 1.0]], [[0.1, 0.2]], r"^time must hold two or more samples"),
        ([0.0, 1.0], 0.1, r"^time must hold two or more samples"),
        ([0.0, 2.0, 1.0], [0.1] * 3, r"^time must not decrease.*got 1 s at index 2$"),
        ([0.0, 1.0, 1.0, 1.0], [0.1] * 4, r"^time must not decrease.*got 1 s at index 3$"),
        ([0.0, 0.0, 0.0, 1.0], [0.1] * 4, r"^time must not decrease.*got 0 s at index 2$"),
        ([0.0, np.nan], [0.1, 0.1], r"^time must be finite; got nan s at index 1$"),
        ([0.0, 1.0], [0.1, np.inf], r"^angle must be finite; got inf rad at index 1$"),
        ([0.0, 1.0], [0.1, 2.0], r"^angle must be a wind within 90 degrees.*got .* \(2 rad\)$"),
        ([0.0, 1.0], [0.0, 0.0], r"^angle must be a wind .* not zero throughout"),
        ([0.0, 1.0], [[0.1, 0.0], [0.0, 0.0]], r"^angle must be a wind .* not zero throughout"),
        (["a", "b"], [0.1, 0.1], r"^time must be a number in s"),
    ],
)
def test_bad_samples_are_refused_in_one_sentence(time, angle, message):
    with pytest.raises(tv.InputError, match=message) as caught:
        tv.SampledWind(time=time, angle=angle)
    assert isinstance(caught.value, ValueError)


def test_a_wind_faster_than_the_vehicle_can_meet_is_refused():
    message = r"^speed must be slower, .* wind of 600 m/s across a path at 90 deg with 500 m/s "
    with pytest.raises(tv.InputError, match=message):
        tv.angle_from_speed(600.0, 500.0, np.pi / 2)
    with pytest.raises(tv.InputError, match=r"^velocity must be positive; got -500 m/s$"):
        tv.angle_from_speed(40.0, -500.0, 0.8)


def test_a_wind_keeps_its_own_copy_of_the_samples():
    time, angle = np.array([0.0, 1.0]), np.array([0.1, 0.1])
    wind = tv.SampledWind(time=time, angle=angle)
    angle[:] = 9.0
    assert wind([0.5])[0] == 0.1
    with pytest.raises(ValueError, match="read-only"):
        wind.angle[0] = 1.0
