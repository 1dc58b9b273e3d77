"""The report's linear equations up to (B5), derived from the planar equations of motion."""

import numpy as np
import pytest
import sympy as sp

import tvclin
from tests.planar import (
    ACROSS,
    ALONG,
    ANGLE,
    C1,
    FA,
    MOMENT,
    NOMINAL,
    B,
    N,
    T,
    Theta,
    Tn,
    V,
    Vn,
    W,
    about_nominal,
    alpha,
    attitude,
    b2,
    beta_squared,
    delta,
    g,
    gamma,
    inertia,
    la,
    lc,
    m,
    moment,
    path_rate,
    q,
    random_vehicle,
    speed_rate,
    value,
    wind,
)
from tests.symbolic import equal, linear, s, solved


def unit(angle):
    return sp.Matrix([sp.cos(angle), sp.sin(angle)])


@pytest.mark.thorough
def test_the_forces_and_the_moment_resolve_to_the_planar_equations():
    """Eq (B1a), (B1b), (B1c): forces along and across the velocity, and their moment."""
    steered, normal = T * unit(Theta + delta), unit(Theta + sp.pi / 2)
    total = steered - FA * unit(Theta) + N * alpha * normal - sp.Matrix([0, W])
    assert equal(total.dot(unit(gamma)), ALONG)
    assert equal(total.dot(unit(gamma + sp.pi / 2)), ACROSS)
    assert equal(la * N * alpha - lc * steered.dot(normal), MOMENT)


@pytest.mark.thorough
def test_the_normal_force_slope_is_pressure_times_area_times_coefficient():
    """Eq (B1d): N = (rho V_R^2/2) S dc_n/dalpha; its change with speed is of second order."""
    rho, area, slope, speed = 0.4, 34.0, 1.7, 540.0
    vehicle = tvclin.Vehicle.from_aerodynamics(
        dynamic_pressure=rho * speed**2 / 2,
        reference_area=area,
        normal_force_coefficient_slope=slope,
        axial_force_coefficient=0.5,
        **{"weight": 1e6, "moment_of_inertia": 1e7, "thrust": 2e6, "aerodynamic_arm": 9.0},
        **{"control_arm": 20.0, "velocity": speed, "attitude": 0.7},
    )
    assert vehicle.normal_force_slope == pytest.approx(rho * speed**2 / 2 * area * slope)
    varying = N * (V / Vn) ** 2
    assert equal(about_nominal(MOMENT.subs(N, varying)), moment)
    assert equal(about_nominal(ACROSS.subs(N, varying) / (m * V)), path_rate)
    assert equal(about_nominal(ALONG.subs(N, varying) / m), speed_rate)


def test_the_wind_angle_turns_the_velocity_relative_to_the_air():
    """Eq (B1e), (B1f), (B2d), (B2e): V_R is the speed relative to the air."""
    speed, path, gust = 540.0, 0.8, 30.0
    air = np.array([speed * np.cos(path) - gust, speed * np.sin(path)])
    result = tvclin.angle_from_speed(gust, np.hypot(*air), path)
    assert np.arctan2(air[1], air[0]) == pytest.approx(path + result, rel=1e-14)
    wrong = tvclin.angle_from_speed(gust, speed, path)  # with the speed over the ground
    assert abs(wrong / result - 1.0) > 0.03
    small = 1e-4 / 500.0 * np.sin(path)
    assert tvclin.angle_from_speed(1e-4, 500.0, path) == pytest.approx(small, rel=1e-13)


@pytest.mark.thorough
def test_the_small_angle_equations_are_the_first_order_in_the_deflection():
    """Eq (B2a), (B2b), (B2c): (B1) to first order in delta, with the same linear part."""
    lean = Theta - gamma
    printed = {
        ALONG: T * (sp.cos(lean) - delta * sp.sin(lean))
        - (FA * sp.cos(lean) + N * alpha * sp.sin(lean) + W * sp.sin(gamma)),
        ACROSS: T * (sp.sin(lean) + delta * sp.cos(lean))
        - (FA * sp.sin(lean) - N * alpha * sp.cos(lean) + W * sp.cos(gamma)),
        MOMENT: N * la * alpha - T * lc * delta,
    }
    for exact, small in printed.items():
        assert equal(small, exact.subs(delta, 0) + delta * sp.diff(exact, delta).subs(delta, 0))
        assert equal(about_nominal(small), about_nominal(exact))


def test_nominal_and_trim_deflection_follow_from_the_moment_equation():
    """Eq (1), (2): from (B2c) with alpha_n = 0 and one attitude history; B = N l_a/(T l_c)."""
    acceleration, alpha_T = sp.symbols("acceleration alpha_T")

    def needed(angle):
        return solved(N * la * angle - T * lc * delta - inertia * acceleration, delta)

    assert equal(needed(0), -inertia * acceleration / (T * lc))
    assert equal((needed(alpha_T) - needed(0)) / alpha_T, B)


def test_the_trim_angle_of_attack_is_that_of_the_path_and_the_wind():
    """Eq (3): alpha_T from (B1f) with Theta_T = Theta_n = gamma_n."""
    gamma_T, gamma_n = sp.symbols("gamma_T gamma_n")
    trimmed = ANGLE.subs({Theta: gamma_n, gamma: gamma_T})
    assert equal(trimmed, -(gamma_T - gamma_n) - wind)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(3))
def test_the_moment_equation_gives_the_attitude_with_the_factor_one_over_b(seed):
    """Eq (B3), (B4): the attitude from path, deflection and wind; the 1/B belongs there."""
    derived = solved(inertia * s**2 * Theta - moment, Theta)
    front = -beta_squared / (s**2 - beta_squared)
    assert equal(derived, front * (gamma + (delta + B * wind) / B))
    assert not equal(derived, front * (gamma + (delta + B * wind)))
    vehicle, exact = random_vehicle(seed)
    result = tvclin.Coefficients.from_vehicle(vehicle)
    assert result.mu_alpha == pytest.approx(value(beta_squared, exact), rel=1e-13)
    assert result.mu_delta == pytest.approx(value(T * lc / inertia, exact), rel=1e-13)
    assert result.B == pytest.approx(value(B, exact), rel=1e-13)


def test_a_path_that_stays_nominal_leaves_the_fixed_path_model():
    """Eq (5): (B3) with gamma = gamma_n, with the sign and the 1/B that are printed."""
    printed = -(beta_squared / B) / (s**2 - beta_squared) * (delta + B * wind)
    assert equal(attitude(), printed)


@pytest.mark.thorough
def test_the_linearised_pair_is_the_linear_part_of_the_force_equations():
    """Eq (before B5): first about any nominal flight, then with alpha_n = delta_n = 0."""
    pitch, path, steered, a_n = sp.symbols("T_n g_n d_n a_n")
    four = (Theta, gamma, delta, alpha)
    nominal = dict(zip(four, (pitch, path, steered, a_n), strict=True))
    lean, turned = pitch - path, pitch - path + steered
    swing, tilt = Theta - gamma, Theta - gamma + delta
    along = -T * sp.sin(turned) * tilt + FA * sp.sin(lean) * swing - N * alpha * sp.sin(lean)
    along += -N * a_n * sp.cos(lean) * swing - W * sp.cos(path) * gamma
    across = T * sp.cos(turned) * tilt - FA * sp.cos(lean) * swing + N * alpha * sp.cos(lean)
    across += -N * a_n * sp.sin(lean) * swing + W * sp.sin(path) * gamma
    assert equal(linear(ALONG, nominal, four), along)
    assert equal(linear(ACROSS, nominal, four), across)
    turning = -g * sp.cos(Tn) / Vn
    assert equal(ACROSS.subs(NOMINAL) / (m * Vn), turning)  # gamma_n'
    assert equal(m * speed_rate, -W * sp.cos(Tn) * gamma)
    force = T * tilt - FA * swing + N * ANGLE + W * sp.sin(Tn) * gamma
    assert equal(m * (V * turning + Vn * path_rate), force)


@pytest.mark.thorough
def test_the_path_angle_follows_from_the_pair_without_the_perturbed_speed():
    """Eq (B5): V (not V_n) and gamma_n' are put in; both printed forms follow."""
    derived = solved(s * gamma - path_rate.subs(V, solved(s * V - speed_rate, V)), gamma)
    drive = (T - FA + N) * Theta + T * delta - N * wind
    assert equal(derived, s * drive / (m * Vn) / (s**2 + C1 * s + q))
    with_alpha = s / (m * Vn) * ((T - FA) * Theta + T * delta + N * ANGLE)
    assert equal(solved(gamma * (s**2 + b2 * s + q) - with_alpha, gamma), derived)


def test_the_path_angle_of_configuration_i_has_no_two_real_roots(configuration_i, configuration_ii):
    """Eq (after B5): two real roots, one near zero: I has a pair, those of II differ 5 times."""
    pairs = []
    for vehicle in (configuration_i, configuration_ii):
        c = tvclin.Coefficients.from_vehicle(vehicle)
        pairs.append(np.sort_complex(np.roots([1.0, c.C1, c.q])))
    np.testing.assert_allclose(pairs[0], [-0.012531 - 0.003098j, -0.012531 + 0.003098j], atol=1e-6)
    np.testing.assert_allclose(pairs[1], [-0.028126, -0.005701], atol=1e-6)
