"""The transfer functions (B6) to (B8), their roots, and the yaw plane, derived from (B1)."""

import numpy as np
import pytest
import sympy as sp

import tvclin
from tests.planar import (
    ANGLE,
    C1,
    C2,
    FA,
    B,
    N,
    P,
    T,
    Theta,
    Tn,
    V,
    Vn,
    W,
    assert_polynomial,
    attitude,
    b1,
    b2,
    beta_squared,
    delta,
    g,
    gains,
    gamma,
    m,
    path_rate,
    q,
    random_vehicle,
    speed_rate,
    value,
    wind,
)
from tests.symbolic import equal, linear, s, solved
from tests.turns import usual

NUMERATORS = {
    "deflection": -beta_squared / B * (s + b1),
    "wind": -beta_squared * (s + b2),
}
SEEDS = pytest.mark.parametrize("seed", usual(range(3), 0))


@pytest.mark.thorough
def test_the_path_angle_at_constant_speed_is_a_single_lag():
    """Eq (B6): the path equation at constant speed, which is (B5) without its gravity term."""
    derived = solved(s * gamma - path_rate.subs(V, 0), gamma)
    printed = ((T - FA + N) * Theta + T * delta - N * wind) / (m * Vn) / (s + C1)
    assert equal(derived, printed)


@pytest.mark.thorough
@SEEDS
def test_the_cubic_and_its_numerators_follow(seed):
    """Eq (B7): P, C1, C2, b1 and b2 as printed; the plant has them."""
    derived = gains(attitude(path_rate.subs(V, 0)))
    vehicle, exact = random_vehicle(seed)
    plant = tvclin.Plant.from_vehicle(vehicle, "drift-exact")
    assert_polynomial(plant.denominator, P, exact)
    for gain, (name, numerator) in zip(derived, NUMERATORS.items(), strict=True):
        assert equal(gain, numerator / P)
        assert_polynomial(plant.numerator("attitude", name), numerator, exact)
    c = plant.coefficients
    for computed, symbol in ((c.C1, C1), (c.C2, C2), (c.b1, b1), (c.b2, b2), (c.q, q)):
        assert computed == pytest.approx(value(symbol, exact), rel=1e-12)


@pytest.mark.thorough
def test_the_printed_equation_of_the_cubic_lacks_one_over_b():
    """Eq (after B6): printed with -beta^2/P(s), exactly B times what follows from (B3), (B6)."""
    printed = -beta_squared / P * ((s + b1) * delta + B * (s + b2) * wind)
    for wrong, right in zip(gains(printed), gains(attitude(path_rate.subs(V, 0))), strict=True):
        assert equal(wrong, B * right)
        assert not equal(wrong, right)


@pytest.mark.thorough
@SEEDS
def test_with_the_speed_the_plant_is_a_quartic_with_the_gravity_term(seed):
    """Eq (quartic): (B5) in (B3) without approximation, with the gravity term throughout."""
    derived = gains(attitude(path_rate, speed_rate))
    quartic = s**4 + C1 * s**3 + (q - beta_squared) * s**2 + C2 * s - beta_squared * q
    vehicle, exact = random_vehicle(seed)
    plant = tvclin.Plant.from_vehicle(vehicle, "drift-and-speed")
    assert_polynomial(plant.denominator, quartic, exact)
    gravity = (-beta_squared / B * q, -beta_squared * q)
    for gain, (name, cubic), last in zip(derived, NUMERATORS.items(), gravity, strict=True):
        numerator = s * cubic + last
        assert equal(gain, numerator / quartic)
        assert_polynomial(plant.numerator("attitude", name), numerator, exact)


def test_the_factors_of_the_cubic_leave_a_small_residual(configuration_i, configuration_ii):
    """Eq (after B7): the factors miss P by eps (C1 + eps) s, eps = C2/beta^2: 0.2 to 0.3 %."""
    eps = C2 / beta_squared
    factored = (s - eps) * (s**2 + (C1 + eps) * s - beta_squared)
    assert equal(P, factored + eps * (C1 + eps) * s)
    for vehicle, percent, size in ((configuration_i, 0.174, 0.072), (configuration_ii, 0.27, 0.11)):
        c = tvclin.Coefficients.from_vehicle(vehicle)
        slow = c.C2 / c.mu_alpha
        assert 100 * slow * (c.C1 + slow) / c.mu_alpha == pytest.approx(percent, abs=5e-4)
        assert (c.C1 + slow) / c.beta == pytest.approx(size, abs=5e-4)  # called much less than 1


def test_the_roots_of_the_cubic_are_not_quite_at_beta(configuration_i, configuration_ii):
    """Eq (roots of B7): two unstable, the fast one 3.6 % (I) and 5.5 % (II) below beta."""
    for vehicle, ratio in ((configuration_i, 0.9640), (configuration_ii, 0.9451)):
        plant = tvclin.Plant.from_vehicle(vehicle, "drift-exact")
        poles = tvclin.unstable_modes(plant).poles
        assert poles.size == 2
        assert poles[0] / plant.coefficients.beta == pytest.approx(ratio, abs=5e-5)


def test_with_the_speed_there_are_three_unstable_roots(configuration):
    """Eq (quartic): (4b) asks about a fast real root and a slow complex pair."""
    poles = tvclin.unstable_modes(tvclin.Plant.from_vehicle(configuration, "drift-and-speed")).poles
    assert poles.size == 3
    assert np.count_nonzero(np.imag(poles)) == 2


@SEEDS
def test_the_short_denominator_keeps_one_over_b(seed):
    """Eq (B8), (14): (B7) with the roots 0 and +-beta; the printed -beta^2 lacks 1/B."""
    short = s * (s**2 - beta_squared)
    printed = -beta_squared / short * ((s + b1) * delta + B * (s + b2) * wind)
    vehicle, exact = random_vehicle(seed)
    plant = tvclin.Plant.from_vehicle(vehicle, "drift")
    assert_polynomial(plant.denominator, short, exact)
    derived = [gain * P / short for gain in gains(attitude(path_rate.subs(V, 0)))]
    for wrong, right, name in zip(gains(printed), derived, NUMERATORS, strict=True):
        assert equal(wrong, B * right)
        numerator = plant.numerator("attitude", name)
        assert_polynomial(numerator, NUMERATORS[name], exact)
        point = sp.Rational(1, 3)
        assert np.polyval(numerator, 1 / 3) / np.polyval(plant.denominator, 1 / 3) == pytest.approx(
            value(right.subs(s, point), exact), rel=1e-12
        )


def test_a_vehicle_too_heavy_to_drift_shows_which_gain_is_right():
    """Eq (B8), (5): with b1, b2 -> 0 the corrected form becomes (5), the printed one B times it."""
    short = s * (s**2 - beta_squared)
    printed = -beta_squared / short * ((s + b1) * delta + B * (s + b2) * wind)
    for wrong, right in zip(gains(printed), gains(attitude()), strict=True):
        assert equal(sp.limit(wrong.subs(g, 0), m, sp.oo), B * right)


def lateral_path_rate():
    """Return the linear rate of the lateral path angle sigma, from the motion in space.

    The axes are along the nominal velocity, level to the side, and upward in the vertical plane;
    the first and the third turn about the second, which stays level. Theta stands for the yaw
    attitude Psi and gamma for sigma.
    """
    time, turning = sp.symbols("t turning")
    speed, side = sp.Function("V")(time), sp.Function("sigma")(time)
    ahead, across = speed * sp.cos(side), speed * sp.sin(side)
    acceleration = sp.Matrix([sp.diff(ahead, time), sp.diff(across, time), turning * ahead])
    body = sp.Matrix([sp.cos(Theta), sp.sin(Theta), 0])
    normal = sp.Matrix([-sp.sin(Theta), sp.cos(Theta), 0])
    thrust = T * sp.Matrix([sp.cos(Theta + delta), sp.sin(Theta + delta), 0])
    weight = -W * sp.Matrix([sp.sin(Tn), 0, sp.cos(Tn)])
    force = thrust - FA * body + N * ANGLE * normal + weight
    balance = list((m * acceleration - force)[:2])
    rates = sp.solve(balance, (speed.diff(time), side.diff(time)))
    rate = rates[side.diff(time)].subs({speed: Vn, side: gamma})
    return linear(rate, {Theta: 0, gamma: 0, delta: 0, wind: 0}, (Theta, gamma, delta, wind))


@pytest.mark.thorough
@SEEDS
def test_in_yaw_the_weight_keeps_the_sine_of_the_real_attitude(seed):
    """Eq (yaw rule): cos Theta_n goes, sin Theta_n stays; 90 deg makes C2 too large by 1/sin."""
    rate = lateral_path_rate()
    swing = (T - FA) * (Theta - gamma) + T * delta + N * ANGLE
    assert equal(rate, (swing + W * sp.sin(Tn) * gamma) / (m * Vn))
    vehicle, exact = random_vehicle(seed)
    yaw = tvclin.Plant.from_vehicle(vehicle, "drift-and-speed", plane="yaw")
    assert_polynomial(yaw.denominator[:-1], P, exact)
    assert yaw.denominator[-1] == 0.0
    for gain, (name, numerator) in zip(gains(attitude(rate)), NUMERATORS.items(), strict=True):
        assert equal(gain, numerator / P)
        assert not equal(gain, (numerator / P).subs(Tn, sp.pi / 2))
        assert_polynomial(yaw.numerator("attitude", name)[:-1], numerator, exact)
    assert equal(C2.subs(Tn, sp.pi / 2), C2 / sp.sin(Tn))
