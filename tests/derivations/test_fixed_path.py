"""Equations (4a) to (13): the stability condition and the boundary limits on a fixed path."""

import numpy as np
import pytest
import sympy as sp
from mpmath import exp, lambertw, mpf, workdps

import tvclin
from tests.report_responses import rectangular_attitude, triangular_attitude
from tests.symbolic import equal, exponentials, from_then_on, s, solved, t, transform
from tvclin.boundary.closed_forms import rectangular_limit, triangular_limit

beta, B, y, K, tau, peak, a = sp.symbols("beta B y K tau peak a", positive=True)
MODEL = -(beta**2 / B) / (s**2 - beta**2)  # eq (5)
LIMIT = -y * B * peak  # eq (8)
SWITCH = y * tau / 2 * K  # eq (11)
p = tau * beta / 2
R = sp.exp(-tau * beta) * (2 * sp.exp(p) - 1)  # the right side of eq (12)
LEFT_OF_12 = (1 - p * y * (1 - K)) * sp.exp(-p * y * K)

SLOPE = peak / (tau / 2)
RECTANGLE = {0: peak, tau: -peak}
TRIANGLE = {0: SLOPE * t, tau / 2: -2 * SLOPE * t, tau: SLOPE * t}
TRIM_THEN_HOLD = {0: -B * SLOPE * t, a: from_then_on(B * SLOPE * t + LIMIT, a)}

RAMP, STEP = sp.sinh(beta * t) - beta * t, sp.cosh(beta * t) - 1
RESPONSE_9 = {0: (1 - y) * STEP, tau: -STEP}
RESPONSE_13 = {
    SWITCH: (RAMP - y * p * (1 - K) * STEP) / p,
    tau / 2: -2 * RAMP / p,
    tau: RAMP / p,
}


def drive(deflection, wind):
    """Return L(delta - delta_n) + B L(alpha_w), the bracket of eq (5)."""
    return transform(deflection) + B * transform(wind)


def long_after(pieces):
    """Return a response after its last piece began, as {(rate, power): coefficient}."""
    return exponentials(sum(f.subs(t, t - start) for start, f in pieces.items()))


def evaluate(pieces, times, numbers):
    """Return the printed response at the times."""
    total = np.zeros_like(times)
    for start, f in pieces.items():
        begin = float(sp.sympify(start).subs(numbers))
        later = np.maximum(times - begin, 0.0)
        total += sp.lambdify(t, sp.sympify(f).subs(numbers))(later)
    return total


@pytest.mark.thorough
def test_the_growing_exponential_is_absent_exactly_where_the_residue_is_zero():
    """Eq (4b), (6a): the coefficient of e^(beta t) in (13) is the residue of (5) at beta."""
    growing = -peak * long_after(RESPONSE_13)[beta, 0]
    residue = sp.cancel(MODEL * (s - beta)) * drive(TRIM_THEN_HOLD, TRIANGLE)
    assert equal(growing, residue.subs(s, beta).subs(a, SWITCH))


def test_on_the_boundary_the_attitude_does_not_return_to_zero():
    """Eq (4a): does not follow from (4b): held for ever, y is left over, with drift a ramp."""
    after = long_after(RESPONSE_13)
    assert equal(after[0, 0], y)
    assert (0, 1) not in after  # no ramp
    b1, b2 = sp.symbols("b1 b2")
    inputs = (s + b1) * LIMIT / s + B * (s + b2) * transform(RECTANGLE)
    with_drift = MODEL / s * inputs / -peak
    assert equal(sp.limit(s**2 * with_drift, s, 0), b1 * y)
    for model, field in (("fixed-path", "offset"), ("drift", "rate")):
        c = tvclin.Coefficients.from_beta(beta=0.53, B=0.107, b1=0.028, b2=0.017)
        computed, wind = tvclin.Plant(c, model), tvclin.TriangularWind(peak=-0.1, duration=7.5)
        limit = tvclin.boundary_limit(computed, wind)
        held = tvclin.trim_then_hold(computed, wind, limit.deflection)
        expected = 0.1 * limit.limit * (1.0 if field == "offset" else 0.028)
        verdict = tvclin.linear.judge(computed, held, wind)
        assert verdict.stable
        assert getattr(verdict.final_motion, field) == pytest.approx(expected, rel=1e-12)


def test_the_condition_compares_the_deflection_with_trim_not_with_nominal():
    """Eq (after 4b): it reads L(delta - delta_T) = 0 at beta_i; delta_n in it is a slip."""
    N1, N2, history, trim, wind = sp.symbols("N1 N2 history trim wind")
    trimmed = solved(N1 * trim + N2 * wind, trim)
    stable = solved(N1 * history + N2 * wind, history)
    assert equal(stable, trimmed)  # L(delta - delta_T) = 0
    assert not equal(stable, 0)  # L(delta - delta_n) = 0, as printed, holds without wind only


def test_the_condition_is_the_discounted_balance_of_deflection_and_wind():
    """Eq (6b): (6a) written out; residues of the package vanish with it for a sampled wind."""
    rate, trim = 0.5, 0.11
    wind = tvclin.SampledWind(time=[0.0, 2.0, 5.0, 9.0], angle=[0.0, -0.05, -0.08, 0.0])
    grid = np.linspace(0.0, 9.0, 900_001)
    balance = -trim * np.trapezoid(np.exp(-rate * grid) * wind(grid), grid)
    plant = tvclin.Plant.from_coefficients(tvclin.Coefficients.from_beta(beta=rate, B=trim))
    held = tvclin.linear.ConstantDeflection(
        limit=balance * rate
    )  # integral of e^(-beta t) is 1/beta
    size = rate / (2 * trim) * balance
    assert tvclin.residues(plant, held, wind) == pytest.approx([0.0], abs=1e-9 * size)


def test_the_rectangular_limit_follows():
    """Eq (7), (8): y_BR = 1 - e^(-tau beta) from (6a) for a rectangle and a held deflection."""
    balance = drive({0: LIMIT}, RECTANGLE).subs(s, beta)
    assert equal(solved(balance, y), 1 - sp.exp(-tau * beta))
    assert rectangular_limit(4.0) == pytest.approx(1.0 - np.exp(-4.0), rel=1e-15)


def test_the_limit_is_the_ratio_to_the_trim_deflection():
    """Eq (after 8): with (2), and (3) at a fixed path, delta_T - delta_n = -B alpha_w."""
    trim = B * (-peak)
    assert equal(LIMIT / trim, y)


def test_the_transform_for_the_rectangle_lacks_one_over_b():
    """Eq (before 9): printed with -beta^2; B times what (5) gives."""
    printed = -(beta**2) / (s**2 - beta**2) / s * (LIMIT + B * peak * (1 - sp.exp(-tau * s)))
    assert equal(printed, B * MODEL * drive({0: LIMIT}, RECTANGLE))


def test_the_response_to_the_rectangle_transforms_back():
    """Eq (9): its transform is (5) with a held deflection; the package gives the same."""
    assert equal(-peak * transform(RESPONSE_9), MODEL * drive({0: LIMIT}, RECTANGLE))
    parts = np.linspace(0.0, 1.6, 33)
    printed = evaluate(RESPONSE_9, parts, {beta: 4.0, tau: 1.0, y: 0.9})
    np.testing.assert_allclose(rectangular_attitude(parts, 4.0, 0.9), printed, atol=1e-13)


def test_the_switching_time_is_where_the_wind_reaches_the_dead_band():
    """Eq (10), (11): trim without drift is K times the limit at a = y_BR tau K/2."""
    leaving = solved(-B * SLOPE * a - K * LIMIT, a)
    assert equal(leaving, -LIMIT / (B * peak) * tau / 2 * K)
    assert equal(leaving, SWITCH)


def test_the_triangular_limit_follows():
    """Eq (12): from (6a) with trim up to a and the limit from there on."""
    balance = drive(TRIM_THEN_HOLD, TRIANGLE).subs(s, beta).subs(a, SWITCH)
    assert equal(balance * beta**2 / (B * SLOPE), LEFT_OF_12 - R)


@pytest.mark.thorough
def test_the_response_to_the_triangle_transforms_back():
    """Eq (13): its transform is (5) with trim up to a, for any y: not for the boundary only."""
    driven = MODEL * drive(TRIM_THEN_HOLD, TRIANGLE)
    assert equal(-peak * transform(RESPONSE_13), driven.subs(a, SWITCH))
    assert not equal(-peak * transform(RESPONSE_13), driven)  # needs a of (11)
    parts = np.linspace(0.0, 1.6, 33)
    printed = evaluate(RESPONSE_13, parts, {beta: 4.0, tau: 1.0, y: 0.7, K: 0.6})
    np.testing.assert_allclose(triangular_attitude(parts, 4.0, 0.7, 0.6), printed, atol=1e-12)


@pytest.mark.thorough
def test_the_safe_form_of_the_triangular_limit_is_the_printed_equation():
    """Eq (12): y = (1 - e^-x)/(p (1 - K)) with x + c (1 - e^-x) = L, c = K/(1 - K), solves it."""
    x = sp.Symbol("x", positive=True)
    c = K / (1 - K)
    safe = (1 - sp.exp(-x)) / (p * (1 - K))
    L = x + c * (1 - sp.exp(-x))
    assert equal(LEFT_OF_12.subs(y, safe), sp.exp(-L))
    assert equal(LEFT_OF_12.subs({K: 1, y: L / p}), sp.exp(-L))
    assert equal(LEFT_OF_12.subs({K: 0, y: (1 - sp.exp(-p)) ** 2 / p}), R)
    short = -sp.log(1 - (1 - sp.exp(-p)) ** 2)  # both forms of L = -ln R
    assert equal(sp.exp(-short), R)
    assert equal(sp.exp(-(p - sp.log(2 - sp.exp(-p)))), R)


@pytest.mark.parametrize("band", [0.0, 0.013, 0.5, 0.87, 1.0])
@pytest.mark.parametrize("tau_beta", [0.07, 1.0, 4.0, 23.0])
def test_the_package_solves_the_printed_triangular_equation(tau_beta, band):
    """Eq (12): the printed residual of the package's limit is rounding, in 40 digits."""
    with workdps(40):
        numbers = {beta: 1, tau: sp.Rational(tau_beta), K: sp.Rational(band)}
        printed = sp.lambdify(y, (LEFT_OF_12 - R).subs(numbers), "mpmath")
        result = mpf(triangular_limit(tau_beta, band))
        assert (
            printed(result * mpf("0.9999999999999")) > 0 > printed(result * mpf("1.0000000000001"))
        )


def test_the_triangular_limit_in_terms_of_lambert_s_function():
    """Eq (12): y = [1 - W(c R e^c)/c]/(p (1 - K)) for 0 < K < 1."""
    for tau_beta, band in ((1, 0.5), (4, 0.25), (20, 0.75)):
        with workdps(40):
            half, c = mpf(tau_beta) / 2, mpf(band) / (1 - mpf(band))
            right = 2 * exp(-half) - exp(-2 * half)
            lambert = (1 - lambertw(c * right * exp(c)).real / c) / (half * (1 - mpf(band)))
        assert triangular_limit(tau_beta, band) == pytest.approx(float(lambert), rel=1e-14)


def test_the_switch_on_the_boundary_never_comes_after_the_peak_of_the_wind():
    """Eq (11), (12): a <= tau/2 always, but not at 1.1 times the boundary in long winds."""
    tau_beta, band = np.geomspace(1e-3, 300, 200)[:, np.newaxis], np.linspace(0, 1, 21)
    assert np.all(band * triangular_limit(tau_beta, band) < 1.0)
    assert equal((LEFT_OF_12 - R).subs({K: 1, y: 1}), -sp.exp(-p) + sp.exp(-2 * p))  # below zero
    assert 1.1 * triangular_limit(15.23, 1.0) < 1.0 < 1.1 * triangular_limit(15.25, 1.0)


def test_a_constant_deflection_that_starts_late_costs_exponentially_more():
    """Eq (after 13): the peak is -B beta e^(beta t1) L(alpha_w)(beta); t1 = 0 is (12), K = 0."""
    start = sp.Symbol("t1", positive=True)
    held = sp.Symbol("held")
    wind = sp.Symbol("wind")
    balance = transform({start: held}).subs(s, beta) + B * wind
    assert equal(solved(balance, held), -B * beta * sp.exp(beta * start) * wind)
    minimum = (solved(balance, held) / (-B * peak)).subs({start: 0, wind: transform(TRIANGLE)})
    minimum = minimum.subs(s, beta)
    assert equal(minimum, (1 - sp.exp(-p)) ** 2 / p)  # eq (12) for K = 0
    plant = tvclin.Plant.from_coefficients(tvclin.Coefficients.from_beta(beta=0.53, B=0.107))
    gust = tvclin.TriangularWind(peak=-0.1, duration=7.5)
    for begin in (-2.0, 0.0, 1.5):
        limit = -0.107 * 0.53 * np.exp(0.53 * begin) * float(gust.laplace(0.53))
        assert tvclin.is_stable(
            plant, tvclin.linear.ConstantDeflection(limit=limit, start=begin), gust
        )
