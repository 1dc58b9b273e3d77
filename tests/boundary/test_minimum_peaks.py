"""The least peak of appendix C for a batch, and where two poles merge."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad_vec

import tvclin
from tvclin import Coefficients, Plant, optimum_deflection
from tvclin.boundary.optimum.minimum_peak import (
    _is_sufficient,
    _pair_peak_bounds,
    _pair_peaks,
    minimum_peaks,
    peaks_for_demands,
)
from tvclin.vehicle.coefficients import NUMBERS

WIND = tvclin.TriangularWind(peak=-0.1, duration=12.0)


def plant_of_poles(first, second, third=0.9):
    """Return a drift-exact plant with two given unstable poles, and a stable one."""
    C1, minus = third - (first + second).real, (first * second).real - third * (first + second).real
    c = Coefficients(
        mu_alpha=-minus, mu_delta=2.0, C1=C1, C2=(first * second).real * third, b1=0.03, b2=0.02
    )
    return Plant(c, "drift-exact")


def test_where_two_poles_merge_nothing_jumps():
    peaks = []
    for apart in (1e-3, 1e-5, 1e-7, 0.0, 1e-7j, 1e-5j, 1e-3j):
        plant = plant_of_poles(0.2 + apart, 0.2 - apart)
        peaks.append(optimum_deflection(plant, WIND, float(WIND.onset)).peak)
        assert minimum_peaks(plant, WIND) == pytest.approx(peaks[-1], rel=1e-9)
    np.testing.assert_allclose(peaks[1:-1], peaks[3], rtol=1e-8)
    np.testing.assert_allclose(peaks, peaks[3], rtol=1e-4)
    assert peaks[0] < peaks[3] < peaks[-1] or peaks[0] > peaks[3] > peaks[-1]


def test_a_double_pole_asks_what_both_its_moments_do():
    plant, p = plant_of_poles(0.2, 0.2), 0.2
    best = optimum_deflection(plant, WIND, float(WIND.onset))
    # delta and the wind leave neither e^(pt) nor t e^(pt): F(p) = 0 and F'(p) = 0.
    turned, blown = (np.poly1d(plant.numerator("attitude", i)) for i in ("deflection", "wind"))

    def left(s):
        return turned(s) * best.deflection.laplace(s) + blown(s) * WIND.laplace(s)

    size = abs(turned(p) * best.peak / p)
    assert abs(left(p)) < 1e-9 * size
    assert abs(left(p + 1e-4) - left(p - 1e-4)) / 2e-4 < 1e-6 * size / p


@pytest.mark.thorough
@settings(max_examples=60, deadline=None)
@given(
    st.floats(0.02, 0.6),
    st.floats(1e-4, 0.95) | st.floats(1e-3, 3.0).map(lambda x: x * 1j),
    st.floats(1.0, 60.0),
)
def test_peaks_of_a_batch_are_those_of_the_certified_optimum(middle, apart, duration):
    plant = plant_of_poles(middle * (1.0 + apart), middle * (1.0 - apart))
    wind = tvclin.TriangularWind(peak=-0.07, duration=duration).shift(2.0)
    best = optimum_deflection(plant, wind, 2.0)
    assert best.status == "ok"
    assert minimum_peaks(plant, wind) == pytest.approx(best.peak, rel=1e-8)


def test_a_batch_of_peaks_takes_plants_of_every_kind_together():
    kinds = [(0.5, 0.013), (0.2, 0.2), (0.1 + 0.1j, 0.1 - 0.1j), (0.3, -0.1), (-0.2, -0.1)]
    plants = [plant_of_poles(*two) for two in kinds]
    every = Coefficients(**{n: [getattr(p.coefficients, n) for p in plants] for n in NUMBERS})
    result = minimum_peaks(Plant(every, "drift-exact"), WIND)
    single = [float(minimum_peaks(p, WIND)) for p in plants]
    # Conditions of poles set apart by 2e-6 are known to rounding over that.
    np.testing.assert_allclose(result, single, rtol=np.finfo(float).eps / 2e-6 * 4.0)
    certified = [optimum_deflection(p, WIND, float(WIND.onset)).peak for p in plants]
    np.testing.assert_allclose(result, certified, rtol=1e-8)


def test_without_an_unstable_pole_nothing_is_needed():
    stable = Plant(Coefficients(mu_alpha=[-0.3, -0.2], mu_delta=2.0), "fixed-path")
    assert minimum_peaks(stable, WIND).tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    ("wind", "message"),
    [
        (0.0 * WIND, "wind must differ from zero"),
        (tvclin.linear.ConstantDeflection(limit=0.1), "wind must end"),
        (0.1, "wind must be a History"),
    ],
)
def test_winds_without_a_least_peak(wind, message):
    with pytest.raises(tvclin.InputError, match=message):
        minimum_peaks(plant_of_poles(0.5, 0.1), wind)


def demands_of_peak_one(poles, weights):
    """Return the demands [rad s] whose minimum peak is 1 rad, by the dual, ``(3,)``.

    They are the moments of the control sign(Re sum lambda_i e^(-p_i t)), the weights lambda its
    certificate.
    """

    def costate(t):
        return np.real(weights @ np.exp(-np.outer(poles, t)))

    time = np.linspace(0.0, 40.0 / poles.real.min(), 8001)
    signs = np.sign(costate(time))
    changes = np.flatnonzero(signs[:-1] != signs[1:])
    before, after = time[changes], time[changes + 1]
    for _ in range(50):
        middle = (before + after) / 2.0
        earlier = np.sign(costate(middle)) == signs[changes]
        before, after = np.where(earlier, middle, before), np.where(earlier, after, middle)
    switches = np.concatenate([[0.0], before])
    decays = np.column_stack([np.exp(-np.outer(poles, switches)), np.zeros(3)])
    control = signs[0] * (-1.0) ** np.arange(switches.size)
    return (decays[:, :-1] - decays[:, 1:]) @ control / poles


def three_poles_with_peak_one(count, early=False):
    """Return poles [1/s] and demands [rad s] of minimum peak 1 rad; every second has a pair.

    `early`: the control switches within a time constant of a pole at least five times as fast as
    the two others, which decide the peak.
    """
    rng = np.random.default_rng(11)
    poles, demands = np.empty((count, 3), dtype=complex), np.empty((count, 3), dtype=complex)
    for k in range(count):
        fast, weights = rng.uniform(0.1, 1.0), rng.normal(size=3).astype(complex)
        others = fast * np.sort(rng.uniform(0.02, 0.9, 2))[::-1]
        if k % 2:
            others = others[0] + 1j * fast * rng.uniform(0.01, 2.0) * np.array([1.0, -1.0])
            weights[1:] = weights[1] + weights[2] * np.array([1j, -1j])
        if early:
            others *= 0.2
            switch = rng.uniform(0.2, 1.0) / fast
            weights[0] = -np.real(weights[1:] @ np.exp(-others * switch)) * np.exp(fast * switch)
        poles[k] = fast, *others
        demands[k] = demands_of_peak_one(poles[k], weights)
    return poles, demands


def test_three_poles_require_the_peak_of_their_switching_control():
    poles, demands = three_poles_with_peak_one(2)
    peaks = peaks_for_demands(poles, demands, np.array([0.999, 10.0]))
    np.testing.assert_allclose(peaks, [1.0, 10.0], rtol=1e-9)  # 0.999 is not sufficient, 10 is


@pytest.mark.thorough
def test_a_peak_is_proved_sufficient_at_or_above_the_minimum_alone_and_soon_above_it():
    poles, demands = three_poles_with_peak_one(80)
    np.testing.assert_allclose(peaks_for_demands(poles[:4], demands[:4]), 1.0, rtol=1e-9)
    for peak in (0.5, 0.9, 0.999, 1.0 - 1e-7):
        assert not np.any(_is_sufficient(poles, demands, np.full(80, peak)))
    proved = _is_sufficient(poles, demands, np.full(80, 1.5))
    assert np.mean(proved[::2]) > 0.8
    assert np.mean(proved[1::2]) > 0.25
    for time, angle in ((1024.0, 1.0), (1.0, 1024.0)):  # powers of two round nothing
        scaled = _is_sufficient(poles / time, demands * time * angle, np.full(80, 1.5 * angle))
        np.testing.assert_array_equal(scaled, proved)
    assert np.mean(_is_sufficient(poles, demands, np.full(80, 10.0))) > 0.85
    given = peaks_for_demands(poles[proved], demands[proved], np.full(proved.sum(), 1.5))
    np.testing.assert_array_equal(given, 1.5)


@pytest.mark.thorough
def test_where_two_slow_poles_decide_a_peak_is_proved_a_fifth_above_the_minimum_and_never_below():
    poles, demands = three_poles_with_peak_one(60, early=True)
    for peak in (0.5, 0.8, 0.95, 0.999):
        assert not np.any(_is_sufficient(poles, demands, np.full(60, peak)))
    assert np.mean(_is_sufficient(poles, demands, np.full(60, 1.2))) > 0.8


@pytest.mark.parametrize("pole", [0.1 + 0.5j, 0.3 + 0.02j, 2.0 + 1.0j])
def test_the_quick_bound_of_a_pair_has_the_smallest_integral_of_a_square(pole):
    def squares(u):
        """Return e^(-sigma u) cos(omega u + phi)^2 as a form in (cos phi, -sin phi)."""
        pair = np.array([np.cos(pole.imag * u), np.sin(pole.imag * u)])
        return np.exp(-pole.real * u) * np.outer(pair, pair)

    smallest = np.linalg.eigvalsh(quad_vec(squares, 0.0, 60.0 / pole.real, epsrel=1e-10)[0])[0]
    bound = _pair_peak_bounds(np.array([pole]), np.array([3.0 - 4.0j]))
    assert bound == pytest.approx(5.0 / smallest, rel=1e-7)


def test_the_quick_bound_of_a_pair_is_above_its_peak_and_often_near():
    poles, demands = three_poles_with_peak_one(80)
    ratios = _pair_peak_bounds(poles[1::2, 1], demands[1::2, 1]) / _pair_peaks(
        poles[1::2, 1], demands[1::2, 1]
    )
    assert ratios.min() >= 1.0
    assert np.median(ratios) < 2.5
