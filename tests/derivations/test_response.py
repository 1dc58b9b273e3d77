"""Equation (B9): the response to a triangular wind with drift, corrected in three places.

The corrected form is held against its transform, against a numerical inverse of that transform,
and against the differential equations, which are solved to 50 digits piece by piece.
"""

import mpmath
import numpy as np
import pytest
import sympy as sp
from mpmath import mp, mpf, workdps

import tvclin
from tests.report_responses import triangular_attitude_with_drift
from tests.symbolic import equal, from_then_on, s, t, transform
from tests.turns import usual

beta, B, y, K, tau, peak, a, b1, b2 = sp.symbols("beta B y K tau peak a b1 b2", positive=True)
MODEL = -(beta**2 / B) / (s * (s**2 - beta**2))  # eq (B8), corrected
LIMIT, SWITCH, SLOPE = -y * B * peak, y * tau / 2 * K, peak / (tau / 2)
TRIANGLE = {0: SLOPE * t, tau / 2: -2 * SLOPE * t, tau: SLOPE * t}
TRIM = -B * SLOPE * (b2 / b1 * t + (b1 - b2) / b1**2 * (1 - sp.exp(-b1 * t)))
CONTROL = {0: TRIM, SWITCH: from_then_on(LIMIT - TRIM, SWITCH)}

p = tau * beta / 2
RAMP, STEP = sp.sinh(beta * t) - beta * t, sp.cosh(beta * t) - 1
CONSTANT_RIGHT = beta * (b2 - b1) / b1**2 * (sp.exp(-b1 * a) + b1 * a - 1)
CONSTANT_PRINTED = B * (b2 - b1) / b1**2 * sp.exp(-b1 * a) + a * b1 - 1
CASES = [(4, 1.0, 0.66), (4, 0.5, 0.59), (8, 0.0, 0.3), (1.5, 0.7, 0.3)]  # on and off the boundary


def equation_b9(sign=-1, constant=CONSTANT_RIGHT, factor_on_all=True):
    """Return (B9), by default as corrected: {start: function of the time since}."""
    parabola = sp.cosh(beta * t) + sign * (beta * t) ** 2 / 2 - 1
    straight = STEP - (beta * t) ** 2 / 2
    lead = 1 + a * (b2 - b1) - b1 * tau / 2 * y * (1 - K)
    first = lead * RAMP + b2 / beta * parabola + (constant - p * y * (1 - K)) * STEP
    later = RAMP + b2 / beta * straight
    others = later / p if factor_on_all else later
    return {SWITCH: (first / p).subs(a, SWITCH), tau / 2: -2 * others, tau: others}


def numbers(tau_beta, band, limit):
    """Return configuration I, rounded, with exact values."""
    rates = {beta: "0.53", B: "0.107", b1: "0.0284", b2: "0.0169", peak: "-0.1"}
    values = {symbol: sp.Rational(value) for symbol, value in rates.items()}
    duration = sp.Rational(tau_beta) / values[beta]
    return values | {tau: duration, K: sp.Rational(band), y: sp.Rational(limit)}


def evaluate(pieces, time, point):
    """Return (B9) at one time, in the working precision."""
    total = mpf(0)
    for start, f in pieces.items():
        later = mpf(sp.N(sp.sympify(start).subs(point), mp.dps))
        if time > later:
            total += sp.lambdify(t, f.subs(point), "mpmath")(time - later)
    return total


def integrated(point, times):
    """Solve the equations of (B8) from rest, and return the attitude over -peak at the times.

    The state is attitude, its rate, path angle, deflection, wind and its rate; trim obeys
    delta' = -b1 delta - B (alpha_w' + b2 alpha_w).
    """
    P = {symbol: mpf(value.p) / value.q for symbol, value in point.items()}
    Q = P[beta] ** 2

    def motion(trimmed):
        rows = mpmath.zeros(6)
        rows[0, 1] = rows[4, 5] = 1
        rows[1, 0], rows[1, 2], rows[1, 3], rows[1, 4] = Q, -Q, -Q / P[B], -Q
        rows[2, 3], rows[2, 4] = P[b1] / P[B], P[b2]
        if trimmed:
            rows[3, 3], rows[3, 4], rows[3, 5] = -P[b1], -P[B] * P[b2], -P[B]
        return rows

    slope = 2 * P[peak] / P[tau]
    switch = P[y] * P[tau] / 2 * P[K]
    wind_rates = {P[tau] / 2: -slope, P[tau]: mpf(0)}
    state, now, trimmed, computed = mpmath.matrix([0, 0, 0, 0, 0, slope]), mpf(0), True, []
    for stop in sorted({switch, *wind_rates, *times}):
        state, now = mpmath.expm(motion(trimmed) * (stop - now)) * state, stop
        if stop == switch:
            trimmed, state[3] = False, -P[y] * P[B] * P[peak]
        state[5] = wind_rates.get(stop, state[5])
        if stop in times:
            computed.append(state[0] / -P[peak])
    return computed


@pytest.mark.thorough
def test_the_corrected_response_transforms_back():
    """Eq (B9): as corrected its transform is (B8) with (17) and the triangle, for any y."""
    bracket = (s + b1) * transform(CONTROL) + B * (s + b2) * transform(TRIANGLE)
    assert equal(-peak * transform(equation_b9()), MODEL * bracket)


@pytest.mark.thorough
@pytest.mark.parametrize("case", usual([(case,) for case in CASES], 1))
def test_the_corrected_response_is_the_numerical_inverse_transform(case):
    """Eq (B9): corrected, equal to the inverse transform by Talbot's contour to 25 digits."""
    point = numbers(*case)
    with workdps(40):
        for time in (mpf(point[tau].p) / point[tau].q * part for part in (0.45, 0.8, 1.3)):
            total = mpf(0)
            for gain, history in (((s + b1), CONTROL), (B * (s + b2), TRIANGLE)):
                for start, f in history.items():
                    later = mpf(sp.N(sp.sympify(start).subs(point), 40))
                    image = (MODEL / -peak * gain * transform({0: f})).subs(point)
                    if time > later:
                        inverse = sp.lambdify(s, image, "mpmath")
                        total += mpmath.invertlaplace(inverse, time - later, method="talbot")
            assert abs(evaluate(equation_b9(), time, point) - total) < mpf("1e-25")


@pytest.mark.thorough
@pytest.mark.parametrize("case", usual([(case,) for case in CASES], 0, 3))
def test_the_corrected_response_solves_the_differential_equations(case):
    """Eq (B9): corrected, equal to the motion solved to 50 digits, during and after the wind."""
    point = numbers(*case)
    with workdps(60):
        times = [mpf(point[tau].p) / point[tau].q * part for part in (0.1, 0.45, 0.8, 1.0, 1.5)]
        for time, attitude in zip(times, integrated(point, times), strict=True):
            assert abs(evaluate(equation_b9(), time, point) - attitude) < mpf("1e-48")


@pytest.mark.parametrize("case", usual([(case,) for case in CASES], 1, 2))
def test_the_package_gives_the_corrected_response(case):
    """Eq (B9): the closed form and the exact response of the package are the corrected form."""
    point = {symbol: float(value) for symbol, value in numbers(*case).items()}
    rates = {"beta": beta, "B": B, "b1": b1, "b2": b2}
    c = tvclin.Coefficients.from_beta(**{name: point[symbol] for name, symbol in rates.items()})
    wind = tvclin.TriangularWind(peak=-0.1, duration=point[tau])
    plant = tvclin.Plant(c, "drift")
    held = tvclin.trim_then_hold(plant, wind, 0.1 * c.B * point[y], point[K], switch="report")
    times = np.linspace(0.0, 1.5 * point[tau], 13)
    computed = tvclin.attitude_responses(plant, held, wind, times)["attitude"]
    expected = [float(evaluate(equation_b9(), mpf(time), numbers(*case))) for time in times]
    np.testing.assert_allclose(computed, 0.1 * np.array(expected), rtol=1e-9, atol=1e-13)
    numbers_of_b9 = (point[tau] * c.beta, point[y], point[K], c.beta, c.b1, c.b2)
    closed = triangular_attitude_with_drift(times / point[tau], *numbers_of_b9)
    np.testing.assert_allclose(closed, expected, rtol=1e-9, atol=1e-12)


MISPRINTS = {
    "sign of the square": {"sign": 1},
    "B for beta, bracket closed early": {"constant": CONSTANT_PRINTED},
    "factor on the first brace only": {"factor_on_all": False},
}


@pytest.mark.thorough
@pytest.mark.parametrize("misprint", MISPRINTS.values(), ids=MISPRINTS)
def test_each_misprint_alone_spoils_the_response(misprint):
    """Eq (B9): plus for minus, B for beta with a bracket, an unclosed brace: each is an error."""
    bracket = (s + b1) * transform(CONTROL) + B * (s + b2) * transform(TRIANGLE)
    assert not equal(-peak * transform(equation_b9(**misprint)), MODEL * bracket)
    point = numbers(*CASES[0])
    time = mpf(point[tau].p) / point[tau].q
    right, wrong = (evaluate(equation_b9(**how), time, point) for how in ({}, misprint))
    assert abs(wrong - right) > 0.1 * abs(right)


def test_the_inverse_of_the_drift_term_has_minus_the_square():
    """Eq (B9): the bracket of b2 has a minus: it is the inverse of beta^4/(s^3 (s^2 - beta^2))."""
    minus = STEP - (beta * t) ** 2 / 2
    assert equal(transform({0: minus / beta**2}), beta**2 / (s**3 * (s**2 - beta**2)))
    plus = STEP + (beta * t) ** 2 / 2
    assert not equal(transform({0: plus / beta**2}), beta**2 / (s**3 * (s**2 - beta**2)))


def test_the_constant_of_the_first_brace_is_without_dimension():
    """Eq (B9): other units of time leave the corrected third bracket, but not the printed one."""
    slower = {beta: beta / 60, b1: b1 / 60, b2: b2 / 60, a: 60 * a}
    assert equal(CONSTANT_RIGHT.subs(slower, simultaneous=True), CONSTANT_RIGHT)
    assert not equal(CONSTANT_PRINTED.subs(slower, simultaneous=True), CONSTANT_PRINTED)


def test_as_printed_the_attitude_at_the_end_of_the_wind_is_far_off(configuration_i):
    """Eq (B9): configuration I, tau beta = 4, K = 1, y = 0.66 at t = tau: -6.7 for 0.557."""
    c = tvclin.Coefficients.from_vehicle(configuration_i)
    point = {beta: c.beta, B: c.B, b1: c.b1, b2: c.b2, tau: 4 / c.beta, K: 1, y: 0.66}
    point = {symbol: sp.Rational(value) for symbol, value in point.items()}
    printed = equation_b9(sign=1, constant=CONSTANT_PRINTED)
    time = mpf(point[tau].p) / point[tau].q
    assert evaluate(equation_b9(), time, point) == pytest.approx(0.557, abs=5e-4)
    assert evaluate(printed, time, point) == pytest.approx(-6.73, abs=5e-3)
