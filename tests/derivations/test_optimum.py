"""Appendix C: the smallest peak deflection for one and for two unstable poles."""

import mpmath
import numpy as np
import pytest
import sympy as sp
from mpmath import mpf, workdps
from scipy.optimize import brentq

import tvclin
from tests.symbolic import equal, s, solved, t, transform

beta1, beta2, D1, D2, b1, b2, B, tau, peak, ts = sp.symbols(
    "beta1 beta2 D1 D2 b1 b2 B tau peak t_s", positive=True
)
top, x, y, r = sp.symbols("delta_max x y r", positive=True)  # r = beta1/beta2
C6 = 2 * x**r - 2 * x * y - (1 - y)
TRIANGLE = {0: 2 * peak / tau * t, tau / 2: -4 * peak / tau * t, tau: 2 * peak / tau * t}
BANG_BANG = {0: top, ts: -2 * top}
RATIO = (1 - sp.exp(-tau * beta1 / 2)) ** 2 / (1 - sp.exp(-tau * beta2 / 2)) ** 2


def K1_at(pole):
    return (pole + b2) / (pole + b1)


@pytest.fixture(params=["configuration-i", "configuration-ii"])
def named(request):
    """Return a name of Table I, its exact third-order plant and its unstable poles, slow first."""
    plant = tvclin.Plant.from_vehicle(tvclin.load_vehicle(request.param), "drift-exact")
    slow, fast = tvclin.unstable_modes(plant).poles[::-1]
    return request.param, plant, slow, fast


def test_each_pole_has_its_own_k1(named):
    """Eq (C1): the residue at beta_i gives K1_i = (beta_i + b2)/(beta_i + b1), not one K1."""
    pole, deflection, wind = sp.symbols("pole deflection wind")
    bracket = (s + b1) * deflection + B * (s + b2) * wind  # numerator over P(s)
    assert equal(solved(bracket.subs(s, pole), deflection), -B * K1_at(pole) * wind)
    name, plant, *poles = named
    c = plant.coefficients
    computed = [(p + c.b2) / (p + c.b1) for p in poles]
    expected = {"configuration-i": [0.7211, 0.9787], "configuration-ii": [0.7857, 0.9754]}
    assert computed == pytest.approx(expected[name], abs=5e-5)
    modes = tvclin.unstable_modes(plant)
    gains = modes.wind_residues / modes.deflection_residues / c.B
    np.testing.assert_allclose(gains[::-1], computed, rtol=1e-9)


def test_a_bounded_deflection_is_one_with_a_real_slack():
    """Eq (C2): delta^2 - delta_max^2 + sigma^2 = 0 has a real sigma exactly within the limit."""
    share = sp.Symbol("share", real=True)
    sigma_squared = sp.expand(top**2 - (share * top) ** 2)
    for inside in (-1, 0, sp.Rational(1, 2), 1):
        assert sigma_squared.subs(share, inside).is_nonnegative
    assert sigma_squared.subs(share, 2).is_negative


deflection, sigma, lambda1, lambda2, lambda3 = sp.symbols("delta sigma lambda1 lambda2 lambda3")
WEIGHT = lambda1 * sp.exp(-beta1 * t) + lambda2 * sp.exp(-beta2 * t)
INTEGRAND = WEIGHT * deflection + lambda3 * (deflection**2 - top**2 + sigma**2)


def test_stationarity_makes_the_deflection_bang_bang():
    """Eq (C3a), (C3b), (C4): as printed, with lambda_(N+1) a function of time."""
    assert equal(sp.diff(INTEGRAND, deflection), WEIGHT + 2 * lambda3 * deflection)
    assert equal(sp.diff(INTEGRAND, sigma), 2 * lambda3 * sigma)
    multiplier = solved(WEIGHT + 2 * lambda3 * top, lambda3)
    assert equal(multiplier, -WEIGHT / (2 * top))
    assert sp.diff(multiplier, t) != 0  # a constant one would not give delta = +-delta_max


def test_the_excess_function_rewards_the_sign_against_the_sum():
    """Eq (E-test): on (C2) the excess is sum lambda_i e^(-beta_i t) (delta* - delta)."""
    other, slack = sp.symbols("delta_star sigma_star")
    changed = INTEGRAND.subs({deflection: other, sigma: slack})
    on_c2 = {sigma: 0, deflection: top, slack: sp.sqrt(top**2 - other**2)}
    assert equal((changed - INTEGRAND).subs(on_c2), WEIGHT * (other - top))


@pytest.mark.thorough
def test_the_sum_changes_sign_at_the_switching_time():
    """Eq (after C4): t_s = -ln(-lambda1/lambda2)/(beta2 - beta1); N terms switch N - 1 times."""
    m1, m2 = sp.symbols("lambda1 lambda2", positive=True)
    switch = -sp.log(m1 / m2) / (beta2 - beta1)  # lambda_1 and lambda_2 of opposite sign
    assert equal(m1 * sp.exp(-beta1 * switch), m2 * sp.exp(-beta2 * switch))
    rng = np.random.default_rng(3)
    grid = np.linspace(0.0, 200.0, 4001)
    for count in (2, 3):
        rates = np.sort(rng.uniform(0.01, 0.5, (200, count)))
        weights = rng.normal(size=(200, count, 1))
        sums = (weights * np.exp(-rates[..., np.newaxis] * grid)).sum(axis=1)
        changes = np.count_nonzero(np.diff(np.sign(sums)), axis=-1)
        assert changes.max() == count - 1


def test_the_two_conditions_on_a_bang_bang_deflection_follow():
    """Eq (C5a), (C5b): the transform of the switched deflection at both poles."""
    sums = [transform(BANG_BANG).subs(s, pole) for pole in (beta1, beta2)]
    slow, fast = (1 - 2 * sp.exp(-pole * ts) for pole in (beta1, beta2))
    assert equal(beta1 * sums[0], top * slow)
    peak_c5a = solved(sums[1] - D2, top)
    assert equal(peak_c5a, beta2 * D2 / fast)
    share = beta1 * D1 / (beta2 * D2)
    printed = 2 * sp.exp(-beta1 * ts) - 2 * share * sp.exp(-beta2 * ts) - (1 - share)
    assert equal((D1 - sums[0]).subs(top, peak_c5a) * beta1 * fast / (beta2 * D2), printed)


def test_with_x_and_y_one_equation_is_left():
    """Eq (C6): (C5b) with x = e^(-beta2 t_s) and y = beta1 D1/(beta2 D2)."""
    share = beta1 * D1 / (beta2 * D2)
    printed = 2 * sp.exp(-beta1 * ts) - 2 * share * sp.exp(-beta2 * ts) - (1 - share)
    names = {x: sp.exp(-beta2 * ts), y: share, r: beta1 / beta2}
    assert equal(C6.subs(names, simultaneous=True), printed)
    assert C6.subs({x: 1, y: 1}) == 0  # no switch after t = 0
    assert sp.limit(C6.subs({y: 1, r: sp.Rational(1, 10)}), x, 0) == 0  # a switch at infinity
    assert sp.diff(C6, x, 2).subs(r, sp.Rational(1, 10)).is_negative  # concave: one root inside


@pytest.mark.parametrize(("share", "error"), [("0.01", 1.8e-4), ("0.1", 7.6e-4)])
def test_the_power_law_holds_below_one_to_a_part_in_a_thousand(share, error):
    """Eq (C7): relative error 1.8e-4 and 7.6e-4 at beta2/beta1 = 10; x is at most 2^-10."""
    with workdps(40):
        ratio, share = sp.Rational(1, 10), sp.Rational(share)
        printed = sp.lambdify((), ((1 - share) / 2) ** (1 / ratio), "mpmath")()
        exact = mpmath.findroot(
            sp.lambdify(x, C6.subs({r: ratio, y: share}), "mpmath"), mpf(printed), tol=1e-60
        )
        assert float(abs(exact / printed - 1)) == pytest.approx(error, rel=0.02)
    assert 0.5**10 < 0.001


@pytest.mark.thorough
def test_for_large_y_the_root_is_above_one_half():
    """Eq (after C7): x -> (y - 1 + 2^(1 - r))/(2 y), above 1/2, unlike the printed form."""
    right, printed = (y - 1 + 2 ** (1 - r)) / (2 * y), (y - 1) / (2 * y)
    tenth = sp.Rational(1, 10)
    assert sp.limit(C6.subs(x, right).subs(r, tenth), y, sp.oo) == 0
    final_motion = sp.limit(C6.subs(x, printed).subs(r, tenth), y, sp.oo)
    assert equal(final_motion, 2 ** (1 - tenth))  # never zero
    with workdps(40):
        residual = sp.lambdify(x, C6.subs({r: tenth, y: 10}), "mpmath")
        exact = float(mpmath.findroot(residual, mpf("0.54")))
    assert exact == pytest.approx(0.54410, abs=5e-6)
    assert float(right.subs({r: tenth, y: 10})) == pytest.approx(exact, abs=1e-3)
    assert float(printed.subs(y, 10)) == 0.45
    largest = sp.limit((beta2 * D2 / (1 - 2 * right)).subs(D2, beta1 * D1 / (beta2 * y)), y, sp.oo)
    assert equal(largest, -beta1 * D1 / (2 ** (1 - r) - 1))  # finite, and negative first


def test_the_demand_of_a_triangular_wind_at_each_pole():
    """Eq (before C8): D_i; printed without -2 B K1_i alpha_w,max/tau, so K1_i is lost in (C8)."""
    pole = sp.Symbol("pole", positive=True)
    demand = -B * K1_at(pole) * transform(TRIANGLE).subs(s, pole)
    printed = (1 - sp.exp(-tau * pole / 2)) ** 2 / pole**2
    assert equal(demand, -2 * B * peak / tau * K1_at(pole) * printed)


@pytest.mark.thorough
def test_y_of_a_triangular_wind_carries_the_ratio_of_both_k1(named):
    """Eq (C8): times K1_1/K1_2, which is 0.737 (I) and 0.806 (II); so are its limits."""
    demand = [-B * K1_at(pole) * transform(TRIANGLE).subs(s, pole) for pole in (beta1, beta2)]
    derived = beta1 * demand[0] / (beta2 * demand[1])
    printed = beta2 / beta1 * RATIO
    between = K1_at(beta1) / K1_at(beta2)
    assert equal(derived, between * printed)
    assert sp.limit(printed, tau, 0) == beta1 / beta2
    assert sp.limit(printed.subs({beta1: 1, beta2: 40}), tau, sp.oo) == 40
    name, plant, slow, fast = named
    c = plant.coefficients
    factor = float(between.subs({beta1: slow, beta2: fast, b1: c.b1, b2: c.b2}))
    expected = {
        "configuration-i": [0.737, 0.0186, 29.2],
        "configuration-ii": [0.806, 0.0210, 30.9],
    }
    computed = [factor, factor * slow / fast, factor * fast / slow]
    assert computed == pytest.approx(expected[name], rel=2e-3)


def test_the_single_pole_solution_ends_at_30_seconds():
    """Eq (C9): from (C8) at y = 1; it gives 30.5 s (tau beta = 15.2), not the printed 28 s."""
    slow, fast = 0.01, 0.5
    printed = -2 / slow * np.log(1 - np.sqrt(slow / fast))
    assert printed == pytest.approx(30.495, abs=5e-4)
    assert printed * fast == pytest.approx(15.25, abs=5e-3)
    one = sp.lambdify(tau, (beta2 / beta1 * RATIO - 1).subs({beta1: slow, beta2: fast}))
    assert brentq(one, 20.0, 40.0) == pytest.approx(30.479, abs=5e-4)
    linearised = 2 / slow * np.sqrt(slow / fast)  # where 28 s comes from
    assert linearised == pytest.approx(28.28, abs=5e-3)


def test_with_the_real_roots_the_single_pole_solution_ends_later(named):
    """Eq (C9): with the exact roots and K1_i at 31.8 s for I and 40.7 s for II."""
    name, plant, slow, fast = named
    c = plant.coefficients
    share = K1_at(beta1) / K1_at(beta2) * beta2 / beta1 * RATIO - 1
    one = sp.lambdify(tau, share.subs({beta1: slow, beta2: fast, b1: c.b1, b2: c.b2}))
    expected = {"configuration-i": 31.80, "configuration-ii": 40.66}
    assert brentq(one, 20.0, 60.0) == pytest.approx(expected[name], abs=5e-3)


@pytest.mark.parametrize(
    ("tau_beta", "peaks"), [(4, (0.370696, 0.371913)), (20, (0.139052, 0.153516))]
)
def test_one_switch_meets_both_poles_of_the_package_s_plant(named, tau_beta, peaks):
    """Eq (C5a), (C6): the switched deflection leaves no residue at either unstable pole."""
    name, plant, slow, fast = named
    c = plant.coefficients
    wind = tvclin.TriangularWind(peak=-0.1, duration=tau_beta / c.beta)
    demand = [-c.B * (p + c.b2) / (p + c.b1) * float(wind.laplace(p)) for p in (slow, fast)]
    share = slow * demand[0] / (fast * demand[1])
    c5b = sp.lambdify(x, 2 * sp.exp(-slow * x) - 2 * share * sp.exp(-fast * x) - (1 - share))
    switch = brentq(c5b, 0.0, 1000.0, xtol=1e-13)
    limit = fast * demand[1] / (1.0 - 2.0 * np.exp(-fast * switch))
    expected = peaks[name == "configuration-ii"]
    assert abs(limit) == pytest.approx(0.1 * c.B * expected, rel=5e-6)
    deflection = tvclin.linear.BangBang(limit=limit, switch_times=[switch])
    assert tvclin.residues(plant, deflection, wind) == pytest.approx([0.0, 0.0], abs=1e-12)
