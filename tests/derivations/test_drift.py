"""Equations (14) to (18): the boundary limits of a vehicle that drifts with the wind."""

import numpy as np
import pytest
import sympy as sp
from mpmath import mpf, workdps

import tvclin
from tests import planar
from tests.symbolic import equal, from_then_on, s, solved, t, transform
from tests.turns import usual
from tvclin.boundary.closed_forms import rectangular_limit, triangular_limit_with_drift

beta, B, y, K, tau, peak, a, b1, b2 = sp.symbols("beta B y K tau peak a b1 b2", positive=True)
MODEL = -(beta**2 / B) / (s * (s**2 - beta**2))  # eq (B8), corrected
LIMIT = -y * B * peak
SWITCH = y * tau / 2 * K  # eq (11)
K1 = (beta + b2) / (beta + b1)
kappa, rho, p = 1 - K1, b1 / beta, tau * beta / 2
R = sp.exp(-tau * beta) * (2 * sp.exp(p) - 1)

SLOPE = peak / (tau / 2)
RECTANGLE = {0: peak, tau: -peak}
TRIANGLE = {0: SLOPE * t, tau / 2: -2 * SLOPE * t, tau: SLOPE * t}
TRIM_SHAPE = b2 / b1 * t + (b1 - b2) / b1**2 * (1 - sp.exp(-b1 * t))  # for the wind u(t) t
TRIM_THEN_HOLD = {
    0: -B * SLOPE * TRIM_SHAPE,
    a: from_then_on(B * SLOPE * TRIM_SHAPE + LIMIT, a),
}
LEFT_OF_18 = (
    1
    - p * y * (1 - K)
    + (b2 - b1)
    * (beta / b1) ** 2
    * (sp.exp(-b1 * a) / (beta + b1) + b1 / beta**2 + b1 * a / beta - 1 / beta)
) * sp.exp(-a * beta)


def psi(x):
    return (sp.exp(-x) - 1 + x) / x**2


def drive(deflection, wind):
    """Return (s + b1) L(delta - delta_n) + B (s + b2) L(alpha_w), the bracket of eq (14)."""
    return (s + b1) * transform(deflection) + B * (s + b2) * transform(wind)


def balance(deflection, wind):
    """Return what (15a) says is zero."""
    return (transform(deflection) + B * K1 * transform(wind)).subs(s, beta)


def test_the_second_form_of_the_drift_model_has_two_slips():
    """Eq (14): printed s^2 for s and without 1/B, hence B/s times (B8)."""
    printed = -(beta**2) / (s**2 * (s**2 - beta**2))
    assert equal(printed, MODEL * B / s)
    assert not equal(printed, MODEL)


def test_the_condition_with_drift_is_that_on_a_fixed_path_times_k1():
    """Eq (15a): the residue of (B8) at beta; neither slip of (14) changes it."""
    deflection, wind = sp.symbols("deflection wind")
    bracket = (s + b1) * deflection + B * (s + b2) * wind
    for front in (MODEL, -(beta**2) / (s**2 * (s**2 - beta**2))):
        residue = (sp.cancel(front * (s - beta)) * bracket).subs(s, beta)
        assert equal(solved(residue, deflection), -B * K1 * wind)


def test_k1_is_below_one():
    """Eq (15b): b1 - b2 = N (1 + l_a/l_c)/(m V_n), which is positive."""
    arms = 1 + planar.la / planar.lc
    assert equal(planar.b1 - planar.b2, planar.N * arms / (planar.m * planar.Vn))
    assert equal(1 - K1, (b1 - b2) / (beta + b1))
    c = tvclin.Coefficients.from_beta(beta=0.53, B=0.1, b1=0.03, b2=0.02)
    assert c.K1 == pytest.approx(0.55 / 0.56, rel=1e-15)


def test_the_rectangular_limit_with_drift_follows():
    """Eq (16): y_BR = K1 (1 - e^(-tau beta)) from (15a)."""
    assert equal(solved(balance({0: LIMIT}, RECTANGLE), y), K1 * (1 - sp.exp(-tau * beta)))
    assert rectangular_limit(4.0, 0.98) == pytest.approx(0.98 * (1 - np.exp(-4)), rel=1e-15)


def test_trim_with_drift_is_the_wind_through_a_lag():
    """Eq (before 17): the zero of the bracket of (14), for all s and in time."""
    deflection, wind = sp.symbols("deflection wind")
    bracket = (s + b1) * deflection + B * (s + b2) * wind
    assert equal(solved(bracket, deflection), -B * (s + b2) / (s + b1) * wind)
    assert equal(transform({0: TRIM_SHAPE}), (s + b2) / (s + b1) / s**2)
    c = tvclin.Coefficients.from_beta(beta=0.53, B=0.107, b1=0.028, b2=0.017)
    gust = tvclin.TriangularWind(peak=-0.1, duration=7.5)
    times = np.linspace(0.0, 3.7, 9)
    trim = -B * SLOPE * TRIM_SHAPE
    numbers = {B: 0.107, peak: -0.1, tau: 7.5, b1: 0.028, b2: 0.017}
    result = tvclin.trim_deflection(tvclin.Plant(c, "drift"), gust)(times)
    np.testing.assert_allclose(result, sp.lambdify(t, trim.subs(numbers))(times), atol=1e-15)


def printed_17():
    drift = (b2 - b1) / b1**2
    drift *= sp.exp(-b1 * a) / (s + b1) + b1 / s**2 + b1 * a / s - 1 / s
    held = 1 / s**2 - tau / 2 * y * (1 - K) / s + drift
    return -B * SLOPE * ((s + b2) / (s**2 * (s + b1)) - held * sp.exp(-a * s))


@pytest.mark.thorough
def test_the_transform_of_the_control_needs_the_switch_of_equation_11():
    """Eq (17): right for a = y K tau/2 only; off by (K tau y - 2 a)/(2 s) otherwise."""
    derived = transform(TRIM_THEN_HOLD)
    excess = B * SLOPE * (K * tau * y - 2 * a) / (2 * s) * sp.exp(-a * s)
    assert equal(printed_17() - derived, excess)
    assert equal(printed_17().subs(a, SWITCH), derived.subs(a, SWITCH))
    assert not equal(printed_17(), derived)


@pytest.mark.thorough
def test_the_triangular_limit_with_drift_follows():
    """Eq (18): (17) and the triangle in (15a)."""
    total = balance(TRIM_THEN_HOLD, TRIANGLE).subs(a, SWITCH)
    printed = LEFT_OF_18 - K1 * R
    assert equal(total * beta**2 / (B * SLOPE), printed.subs(a, SWITCH))


@pytest.mark.thorough
def test_the_safe_form_of_the_limit_with_drift_is_the_printed_equation():
    """Eq (18): with z = p y and A = K z nothing is divided by b1; its limits are (12)."""
    z = p * y
    A = K * z
    safe = 1 - (1 - K) * z - kappa * (1 + A + A**2 * psi(rho * A)) - K1 * R * sp.exp(A)
    printed = (LEFT_OF_18 - K1 * R).subs(a, SWITCH) * sp.exp(A)
    assert equal(safe, printed)
    grown = R * sp.exp(A)  # e^(K z - L)
    in_code = K1 * (1 - grown) - (1 - K) * z - kappa * (A + A**2 * psi(rho * A))
    assert equal(in_code, printed)
    x = sp.Symbol("x")
    assert sp.limit(psi(x), x, 0) == sp.Rational(1, 2)  # b1 -> 0
    left_of_12 = (1 - p * y * (1 - K)) * sp.exp(-p * y * K)
    assert equal((safe * sp.exp(-A)).subs(b2, b1), left_of_12 - R)


@pytest.mark.thorough
@pytest.mark.parametrize(("tau_beta", "band"), [(0.1, 0.4), (4, 1.0), (4, 0.5), (20, 1.0), (60, 0)])
def test_the_package_solves_the_printed_equation_with_drift(tau_beta, band):
    """Eq (18): the printed residual changes sign within 1e-12 of the package's limit."""
    rates = [sp.Rational(x) for x in (0.53, 0.028, 0.017)]
    numbers = dict(zip((beta, b1, b2), rates, strict=True))
    numbers |= {tau: sp.Rational(tau_beta) / rates[0], K: sp.Rational(band)}
    with workdps(40):
        residual = (LEFT_OF_18 - K1 * R).subs(a, SWITCH).subs(numbers)
        printed = sp.lambdify(y, residual, "mpmath")
        result = mpf(triangular_limit_with_drift(tau_beta, band, 0.53, 0.028, 0.017))
        assert printed(result * (1 - mpf("1e-12"))) > 0 > printed(result * (1 + mpf("1e-12")))


def test_the_reports_switch_leaves_the_dead_band_early():
    """Eq (10): with drift trim is below -B alpha_w, so "K = 1" is a dead band of 2 h(a)/(tau y)."""
    gap = sp.diff(t - TRIM_SHAPE, t)  # the drift takes (b1 - b2)/b1 (1 - e^(-b1 t)) off the rate
    assert equal(gap, (b1 - b2) / b1 * (1 - sp.exp(-b1 * t)))
    shape = sp.lambdify((t, b1, b2), TRIM_SHAPE)
    expected = {"configuration-i": [0.986, 0.925, 0.913], "configuration-ii": [0.984, 0.921, 0.910]}
    for name, bands in expected.items():
        c = tvclin.Coefficients.from_vehicle(tvclin.load_vehicle(name))
        for tau_beta, band in zip((4, 20, 40), bands, strict=True):
            duration = tau_beta / c.beta
            limit = triangular_limit_with_drift(tau_beta, 1.0, c.beta, c.b1, c.b2)
            trim = shape(limit * duration / 2, c.b1, c.b2)
            assert 2 * trim / (duration * limit) == pytest.approx(band, abs=6e-4)


@pytest.mark.thorough
@pytest.mark.parametrize(("tau_beta", "limit"), usual([(4, 0.6649), (20, 0.8366), (40, 0.8072)], 1))
def test_a_dead_band_meant_literally_has_other_limits(configuration_i, tau_beta, limit):
    """Eq (18): with a where trim itself is K y: 0.8366, not 0.7939, at tau beta = 20 (I, K = 1)."""
    A, z = a * beta, p * y
    literal = y * p * K - (A - kappa * (1 + rho) * A**2 * psi(rho * A))
    assert equal(literal, beta * (K * y * tau / 2 - TRIM_SHAPE.subs(t, a)))
    condition = 1 + A - z - kappa * (1 + A + A**2 * psi(rho * A)) - K1 * R * sp.exp(A)
    total = balance(TRIM_THEN_HOLD, TRIANGLE) * beta**2 / (B * SLOPE)
    assert equal(total * sp.exp(A), condition)
    plant = tvclin.Plant.from_vehicle(configuration_i, "drift")
    wind = tvclin.TriangularWind(peak=-0.1, duration=tau_beta / plant.coefficients.beta)
    boundary = tvclin.boundary_limit(plant, wind, 1.0, switch="literal")
    assert boundary.limit == pytest.approx(limit, abs=6e-5)
    c = plant.coefficients
    numbers = {beta: c.beta, b1: c.b1, b2: c.b2, tau: wind.duration, K: 1}
    numbers |= {y: boundary.limit, a: boundary.switch_time}
    for equation in (literal, condition):
        assert float(equation.subs(numbers)) == pytest.approx(0.0, abs=1e-9)
