"""The planar equations of motion (B1), where every derivation starts, and their linear part."""

import numpy as np
import sympy as sp

import tvclin
from tests.symbolic import linear, s, solved

m, g, Vn, Tn, T, FA, N, inertia, la, lc = sp.symbols("m g V_n Theta_n T F_A N I l_a l_c")
Theta, gamma, V, delta, alpha, wind = sp.symbols("Theta gamma V delta alpha alpha_w")
W = m * g

# What the report prints for them: (B4), (B7), and the square of its gravity term.
beta_squared, B = N * la / inertia, N * la / (T * lc)
C1 = (T - FA + N - W * sp.sin(Tn)) / (m * Vn)
C2 = beta_squared * g * sp.sin(Tn) / Vn
b1 = (T - FA + N * (1 + la / lc) - W * sp.sin(Tn)) / (m * Vn)
b2 = (T - FA - W * sp.sin(Tn)) / (m * Vn)
q = (g * sp.cos(Tn) / Vn) ** 2
P = s**3 + C1 * s**2 - beta_squared * s + C2

ALONG = (  # (B1a)
    T * sp.cos(Theta - gamma + delta)
    - FA * sp.cos(Theta - gamma)
    - N * alpha * sp.sin(Theta - gamma)
    - W * sp.sin(gamma)
)
ACROSS = (  # (B1b)
    T * sp.sin(Theta - gamma + delta)
    - FA * sp.sin(Theta - gamma)
    + N * alpha * sp.cos(Theta - gamma)
    - W * sp.cos(gamma)
)
MOMENT = N * la * alpha - T * lc * sp.sin(delta)  # (B1c)
ANGLE = Theta - gamma - wind  # (B1f)
NOMINAL = {Theta: Tn, gamma: Tn, V: Vn, delta: 0, alpha: 0, wind: 0}
SIGNALS = (Theta, gamma, V, delta, wind)


def about_nominal(force):
    """Return the linear part of an expression about the nominal flight."""
    return linear(force.subs(alpha, ANGLE), NOMINAL, SIGNALS)


speed_rate = about_nominal(ALONG / m)
path_rate = about_nominal(ACROSS / (m * V))
moment = about_nominal(MOMENT)


def attitude(path=None, speed=None):
    """Return the transform of the attitude with gamma' and V' as given; None holds either."""
    change = 0 if speed is None else solved(s * V - speed, V)
    turn = 0 if path is None else solved(s * gamma - path.subs(V, change), gamma)
    return solved(inertia * s**2 * Theta - moment.subs(gamma, turn), Theta)


def gains(response):
    """Return the transfer functions from the deflection and from the wind."""
    return [sp.diff(response, x) for x in (delta, wind)]


def random_vehicle(seed):
    """Return a random vehicle, and the same numbers exactly for the symbols."""
    ranges = {
        "weight": (W, 1e6, 1e7),
        "moment_of_inertia": (inertia, 2e7, 1e9),
        "normal_force_slope": (N, 5e5, 5e6),
        "thrust": (T, 2e6, 3e7),
        "aerodynamic_arm": (la, 5.0, 30.0),
        "control_arm": (lc, 15.0, 50.0),
        "axial_force": (FA, 5e4, 9e5),
        "velocity": (Vn, 300.0, 700.0),
        "attitude": (Tn, 0.3, 1.2),
    }
    rng = np.random.default_rng(seed)
    drawn = {name: float(rng.uniform(low, high)) for name, (_, low, high) in ranges.items()}
    exact = {symbol: sp.Rational(drawn[name]) for name, (symbol, *_) in ranges.items()}
    gravity = sp.Rational("9.80665")
    return tvclin.Vehicle(**drawn), exact | {g: gravity, m: exact.pop(W) / gravity}


def value(expression, exact):
    """Return a floating-point value, rounded once."""
    return float(sp.N(expression.subs(exact), 30))


def assert_polynomial(computed, derived, exact):
    """Check the coefficients of a polynomial in s."""
    expected = [value(c, exact) for c in sp.Poly(derived, s).all_coeffs()]
    np.testing.assert_allclose(computed, expected, rtol=1e-12)  # rounding of a dozen operations
