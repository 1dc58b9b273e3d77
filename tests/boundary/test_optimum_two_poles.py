"""Two unstable poles: eqs (C5) to (C9) against sixty digits and each other."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tvclin
from tests.optima import NAMES, plant_of, solved
from tvclin import Coefficients, Plant, TriangularWind, optimum_deflection
from tvclin.boundary.optimum.two_poles import (
    duration_without_fast_pole,
    early_switch,
    longest_single_pole_duration,
    single_pole_validity,
    switch_time,
    switch_variable,
)


def precise_pair(poles, demands):
    """Solve eqs (C5) in 60 digits by bisection: the peak and the switch."""
    with mpmath.workdps(60):
        p, d = [mpmath.mpf(float(x)) for x in poles], [mpmath.mpf(float(x)) for x in demands]
        c = [a * b for a, b in zip(p, d, strict=True)]

        def excess(t):
            return c[0] * (1 - 2 * mpmath.exp(-p[1] * t)) - c[1] * (1 - 2 * mpmath.exp(-p[0] * t))

        low, high = mpmath.mpf(0), 200 / min(p)
        side = mpmath.sign(excess(low))
        for _ in range(240):
            middle = (low + high) / 2
            if mpmath.sign(excess(middle)) == side:
                low = middle
            else:
                high = middle
        wide = max(range(2), key=lambda i: abs(1 - 2 * mpmath.exp(-p[i] * low)))
        return abs(c[wide] / (1 - 2 * mpmath.exp(-p[wide] * low))), low


def pairs(count):
    """Pairs of poles and demands: near and far poles, both signs, either one dominant."""
    rng = np.random.default_rng(20)
    slow = 10.0 ** rng.uniform(-3, 0, count)
    fast = slow * 10.0 ** rng.uniform(0.05, 3, count)
    poles = np.stack([slow, fast], axis=-1)
    demands = rng.choice([-1.0, 1.0], (count, 2)) * 10.0 ** rng.uniform(-2, 2, (count, 2)) / poles
    demands[::5, 0] = demands[::5, 1] * poles[::5, 1] / poles[::5, 0]  # y near 1
    demands[::5, 0] *= 1.0 + rng.choice([-1, 1], len(demands[::5])) * 10.0 ** -rng.uniform(
        1, 12, len(demands[::5])
    )
    flipped = rng.random(count) < 0.5
    poles[flipped], demands[flipped] = poles[flipped, ::-1], demands[flipped, ::-1]
    return list(zip(poles, demands, strict=True))


@pytest.mark.thorough
def test_two_poles_agree_with_sixty_digits():
    for poles, demands in pairs(200):
        peak, switch = precise_pair(poles, demands)
        result = switch_time(tuple(poles), tuple(demands))
        shares = 1.0 - 2.0 * np.exp(-poles * result)
        i = int(np.argmax(np.abs(shares)))
        assert abs(poles[i] * demands[i] / shares[i]) == pytest.approx(float(peak), rel=1e-11)
        if poles.min() * result < 10.0 and result > 1e-3 / poles.max():
            assert result == pytest.approx(float(switch), rel=1e-10)


@pytest.mark.thorough
def test_the_dual_finds_the_same_for_two_poles():
    for poles, demands in pairs(30):
        best, proof = solved(poles, demands)
        peak, _ = precise_pair(poles, demands)
        assert proof.primal == pytest.approx(float(peak), rel=1e-9)
        assert proof.dual <= float(peak) * (1.0 + 1e-9)
        assert best.zeros.size <= 1


@pytest.mark.parametrize("horizon", [2.0, 9.0, 40.0])
def test_with_a_horizon_the_switch_meets_eq_c5(horizon):
    for poles, demands in (
        ((0.5, 0.1), (1.0, 3.0)),
        ((0.1, 0.4), (-1.0, 2.0)),
        ((2.0, 0.2), (5, 1)),
    ):
        time = switch_time(poles, demands, horizon)
        assert 0.0 < time < horizon
        p, c = np.array(poles), np.array(poles) * demands
        shares = 1.0 - 2.0 * np.exp(-p * time) + np.exp(-p * horizon)
        assert c[0] * shares[1] == pytest.approx(c[1] * shares[0], rel=1e-10)


def test_at_y_of_one_the_switch_is_never_or_at_once():
    assert switch_time((1.0, 2.0), (2.0, 1.0)) == np.inf
    before = switch_time((0.01, 0.5), (50.0 * (1.0 - 1e-9), 1.0))
    after = switch_time((0.01, 0.5), (50.0 * (1.0 + 1e-9), 1.0))
    assert before > 1000.0
    assert 0.0 < after < 1e-7
    assert switch_time((0.01, 0.5), (0.0, 1.0)) == pytest.approx(np.log(2.0) / 0.01)
    assert switch_time((0.01, 0.5), (1.0, 0.0)) == pytest.approx(np.log(2.0) / 0.5)


@pytest.mark.parametrize("apart", [2.0**-30, -(2.0**-30)])
def test_near_y_of_one_a_switch_at_once_and_one_that_is_late_lose_no_digits(apart):
    poles, demands = (0.5, 2.0), (2.0 * (1.0 + apart), 0.5)  # both p_i d_i are exact
    time, (_, precise) = switch_time(poles, demands), precise_pair(poles, demands)
    assert time == pytest.approx(float(precise), rel=1e-13, abs=0.0)
    assert time < 1e-8 if apart > 0.0 else time > 40.0


@given(y=st.floats(-50.0, 50.0), ratio=st.floats(1e-3, 0.95))
def test_the_switch_variable_solves_eq_c6(y, ratio):
    x = switch_variable(y, ratio)
    assert 0.0 <= x <= 1.0
    if x < 1e-290:  # too late a switch for x to be written down
        assert -1.0 < y <= 1.0
        return
    assert 2.0 * x**ratio - 2.0 * x * y == pytest.approx(1.0 - y, abs=1e-12 * (1.0 + abs(y)))


def test_approximations_of_the_switch():
    for y, error in ((0.01, 1.8e-4), (0.1, 7.6e-4)):  # of eq (C7), for poles far apart
        late = ((1.0 - y) / 2.0) ** (1.0 / 0.1)
        shares = [1.0 - 2.0 * x for x in (switch_variable(y, 0.1), late)]
        assert abs(shares[1] / shares[0] - 1.0) < 2.0 * error
    assert switch_variable(10.0, 0.1) == pytest.approx(0.54410, abs=5e-6)
    assert early_switch(10.0, 0.1) == pytest.approx(0.5433, abs=5e-5)
    large = switch_variable(1e6, 0.1)
    assert 1.0 - 2.0 * large**0.1 == pytest.approx(1.0 - 2.0 * early_switch(1e6, 0.1) ** 0.1)
    assert abs(1.0 / (1.0 - 2.0 * large**0.1)) == pytest.approx(1.0 / (2.0**0.9 - 1.0), rel=1e-4)


def test_the_duration_up_to_which_one_pole_decides():
    for name, tau, tau_beta in (("configuration-i", 31.8, 16.8), ("configuration-ii", 40.7, 16.1)):
        coefficients = Coefficients.from_vehicle(tvclin.load_vehicle(name))
        result = single_pole_validity(coefficients)
        assert result == pytest.approx(tau, abs=0.05)
        assert result * coefficients.beta == pytest.approx(tau_beta, abs=0.05)
    printed = longest_single_pole_duration(0.01, 0.5)
    assert printed == pytest.approx(30.479, abs=5e-4)
    assert duration_without_fast_pole(0.01, 0.5) == pytest.approx(30.495, abs=5e-4)
    assert printed * 0.5 == pytest.approx(15.2, abs=0.05)
    assert np.isnan(longest_single_pole_duration(0.5, 0.5))
    many = longest_single_pole_duration(np.array([[0.01], [0.02]]), 0.5, [1.0, 0.7, 0.001])
    assert many.shape == (2, 3)
    assert np.all(np.isnan(many[:, 2]))


def test_a_duration_is_inverse_to_the_rates_and_none_where_the_slow_pole_never_requires_as_much():
    tau = longest_single_pole_duration(0.01, 0.5, 0.7)
    assert longest_single_pole_duration(1.0, 50.0, 0.7) == pytest.approx(tau / 100.0, rel=1e-12)
    shares = np.expm1(-tau * 0.01 / 2.0) / np.expm1(-tau * 0.5 / 2.0)
    assert 0.7 * 0.5 / 0.01 * shares**2 == pytest.approx(1.0, rel=1e-12)  # eq (C8)
    # y rises from K1_ratio beta1/beta2 to K1_ratio beta2/beta1: it is 1 for no wind alone, above 1
    # for every wind, 1 for a wind without end alone, and below 1 for every wind.
    assert np.isnan(longest_single_pole_duration(0.25, 0.5, [2.0, 2.5, 0.5, 0.4])).all()


def test_drift_factors_of_opposite_signs_have_no_validity():
    numbers = {"mu_alpha": 0.3, "mu_delta": 2.6, "C1": 0.025, "C2": 0.004, "b1": 0.03}
    poles = tvclin.unstable_modes(
        Plant.from_coefficients(Coefficients(**numbers, b2=0.02), "drift-exact")
    ).poles
    assert poles[0] > 0.03 > poles[1] > 0.0  # the factors p + b2 of b2 = -0.03
    assert np.isnan(single_pole_validity(Coefficients(**numbers, b2=-0.03)))
    both = single_pole_validity(Coefficients(**numbers, b2=[-0.03, 0.02]))
    assert np.isnan(both).tolist() == [True, False]


def test_where_the_fast_pole_leaves_no_trace_its_neglect_is_exact():
    result = longest_single_pole_duration(1e-6, 1.0)  # e^(-tau beta2/2) is e^(-1000)
    assert result == pytest.approx(-2e6 * np.log1p(-1e-3), rel=1e-12)
    assert duration_without_fast_pole(1e-6, 1.0) == pytest.approx(result, rel=1e-12)


def test_where_the_demands_of_both_poles_agree_the_fast_one_decides_the_peak():
    for name in NAMES:
        plant = plant_of(name)
        modes = tvclin.unstable_modes(plant)
        fast = modes.poles[0]
        K = -modes.wind_residues / modes.deflection_residues
        wind = TriangularWind(peak=-0.1, duration=single_pole_validity(plant.coefficients))
        demands = modes.poles * K * wind.laplace(modes.poles)
        assert demands[1] == pytest.approx(demands[0], rel=1e-12)
        best = optimum_deflection(plant, wind)
        single = fast * -K[0] * wind.laplace(fast)
        assert best.peak == pytest.approx(abs(single), rel=1e-11)


@pytest.mark.parametrize("model", ["drift-exact", "drift-and-speed"])
def test_a_force_at_the_centre_of_pressure_holds_the_balance_of_forces(model):
    """It acts as the wind does, so that N alpha_w / T, held while the wind lasts, undoes it."""
    booster = tvclin.load_vehicle("configuration-i")
    plant = Plant.from_vehicle(booster.replace(control_arm=-booster.aerodynamic_arm), model)
    wind = tvclin.RectangularWind(peak=0.05, duration=30.0)
    best = optimum_deflection(plant, wind, 0.0, wind.end)

    balance = 0.05 * booster.normal_force_slope / booster.thrust
    assert best.peak == pytest.approx(balance, rel=1e-14)
    assert best.certificate.dual == pytest.approx(balance, rel=1e-14)
    assert best.switch_times.size == 0
    assert best.deflection([0.0, 29.9]) == pytest.approx([balance] * 2, rel=1e-14)


def test_validity_of_batches_and_of_stable_vehicles():
    both = Coefficients.from_beta(
        beta=[0.53, 0.4], B=0.1, C1=[0.025, 0.034], C2=[0.0036, 0.0015], b1=0.03, b2=0.02
    )
    assert single_pole_validity(both).shape == (2,)
    stable = Coefficients(mu_alpha=-0.2, mu_delta=1.0, C1=0.02, C2=0.003, b1=0.03, b2=0.02)
    assert np.isnan(single_pole_validity(stable))
    assert np.isnan(single_pole_validity(Coefficients.from_beta(beta=0.5, B=0.1)))


def test_only_two_real_unstable_poles_have_a_validity():
    # A slow pole beside the fast one, none, and the pair of s^3 - 0.05 s + 0.1.
    numbers = {"mu_alpha": [0.3, 0.3, 0.05], "C1": [0.025, 0.2, 0.0], "C2": [0.004, -0.1, 0.1]}
    common = {"mu_delta": 2.6, "b1": 0.03, "b2": 0.02}
    result = single_pole_validity(Coefficients(**common, **numbers))
    single = Coefficients(**common, **{name: values[0] for name, values in numbers.items()})
    assert result[0] == pytest.approx(single_pole_validity(single), rel=1e-12)
    assert np.isnan(result[1:]).all()


# ---- any number of poles -------------------------------------------------------------------
