"""The damping of the attitude rate: denominators, coordinate and limits, derived with it."""

from itertools import pairwise

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq, minimize_scalar

import tvclin as tv
from tests.damped import fast_pole
from tests.planar import (
    C1,
    C2,
    B,
    Theta,
    V,
    assert_polynomial,
    b1,
    b2,
    beta_squared,
    delta,
    gains,
    gamma,
    inertia,
    moment,
    path_rate,
    q,
    random_vehicle,
    speed_rate,
    wind,
)
from tests.symbolic import equal, from_then_on, s, solved, t, transform
from tests.turns import usual
from tvclin.boundary.closed_forms import (
    rectangular_limit,
    triangular_limit,
    triangular_limit_with_drift,
)
from tvclin.linear.plant import MODELS

Mq, p, d, tau, peak, K, y, a = sp.symbols("M_q p d tau peak K y a", positive=True)
D = Mq / inertia
PEAK = np.radians(5.0)
DENOMINATORS = {
    "fixed-path": s**2 + D * s - beta_squared,
    "drift": s * (s**2 + D * s - beta_squared),
    "drift-exact": s**3 + (C1 + D) * s**2 + (C1 * D - beta_squared) * s + C2,
    "drift-and-speed": s**4
    + (C1 + D) * s**3
    + (q + C1 * D - beta_squared) * s**2
    + (C2 + q * D) * s
    - q * beta_squared,
}
FACTORS = {
    "fixed-path": (1, 1),
    "drift": (s + b1, s + b2),
    "drift-exact": (s + b1, s + b2),
    "drift-and-speed": (s**2 + b1 * s + q, s**2 + b2 * s + q),
}
NUMBERS = [
    (0.28, 0.25, 4.0, 1.0, 0.68845937),
    (6.866, 0.2156, 4.0, 0.5, 0.55875767),
    (0.28, 0.25, 6.0, 0.8, 0.73109797),
    (0.28, 0.6, 3.0, 0.3, 0.48309544),
]


def paths(model):
    """Return the path and the speed that a model lets change."""
    return {
        "fixed-path": (None, None),
        "drift": (b1 / B * delta + b2 * wind, None),
        "drift-exact": (path_rate.subs(V, 0), None),
        "drift-and-speed": (path_rate, speed_rate),
    }[model]


def damped_attitude(model):
    """Return the transform of the attitude of I Theta'' = moment - M_q Theta', and of the path."""
    path, speed = paths(model)
    change = 0 if speed is None else solved(s * V - speed, V)
    turn = 0 if path is None else solved(s * gamma - path.subs(V, change), gamma)
    result = solved(inertia * s**2 * Theta + Mq * s * Theta - moment.subs(gamma, turn), Theta)
    return result, sp.sympify(turn).subs(Theta, result)


@pytest.mark.thorough
@pytest.mark.parametrize("model", usual(MODELS, 0, 2))
def test_damping_changes_denominators_and_no_numerator_of_the_attitude(model):
    derived = gains(damped_attitude(model)[0])
    for gain, factor, scale in zip(derived, FACTORS[model], (1, B), strict=True):
        assert equal(gain, -beta_squared / B * scale * factor / DENOMINATORS[model])


@pytest.mark.parametrize("model", MODELS)
def test_the_plant_has_these_polynomials_and_those_of_the_path(model):
    vehicle, exact = random_vehicle(1)
    vehicle = vehicle.replace(pitch_damping=0.3 * vehicle.moment_of_inertia)
    exact[Mq] = sp.Rational(vehicle.pitch_damping)
    plant = tv.Plant.from_vehicle(vehicle, model)
    assert_polynomial(plant.denominator, DENOMINATORS[model], exact)
    if model == "fixed-path":
        return
    for name, gain in zip(("deflection", "wind"), gains(damped_attitude(model)[1]), strict=True):
        value = gain.subs(exact).subs(s, sp.Rational(3, 7))
        above = np.polyval(plant.numerator("flight_path_angle", name), 3 / 7)
        assert above / np.polyval(plant.denominator, 3 / 7) == pytest.approx(
            float(sp.N(value, 30)), rel=1e-12
        )


def test_the_growing_coordinate_has_p_plus_d_below_the_rate():
    """The coordinate z = theta + theta'/(p + d), p (p + d) = mu_alpha, has z' = p (z - u - w)."""
    theta, rate, u, w = sp.symbols("theta rate u w")
    acceleration = p * (p + d) * (theta - w - u) - d * rate
    z = theta + rate / (p + d)
    assert equal(rate + acceleration / (p + d), p * (z - u - w))
    single = theta + rate / p
    assert not equal(rate + acceleration / p, p * (single - u - w))
    assert sp.expand((s - p) * (s + p + d) - (s**2 + d * s - p * (p + d))) == 0


@pytest.mark.thorough
def test_the_residue_at_p_is_that_of_an_undamped_vehicle_with_beta_equal_to_p():
    """Eq (4b), and with it (6) to (12): the wind and the deflection enter at s = p alone."""
    slope, B_ = peak / (tau / 2), sp.Symbol("B", positive=True)
    triangle = {0: slope * t, tau / 2: -2 * slope * t, tau: slope * t}
    hold = {0: -B_ * slope * t, a: from_then_on(B_ * slope * t - y * B_ * peak, a)}
    drive = transform(hold) + B_ * transform(triangle)
    damped, undamped = (
        sp.limit(sp.cancel(-m / B_ / poly * (s - p)), s, p) * drive.subs(s, p)
        for m, poly in (
            (p * (p + d), s**2 + d * s - p * (p + d)),
            (p**2, s**2 - p**2),
        )
    )
    assert equal(damped, undamped * 2 * (p + d) / (2 * p + d))


def flown_limit(mu, damping, tau_pole, K):
    """Return the limit that leaves no fall, by integration of theta and theta' alone."""
    pole = fast_pole(mu, damping)
    duration = tau_pole / pole

    def falls(limit):
        leaves = limit * K * duration / 2

        def rates(time, x):
            gust = max(0.0, 1.0 - abs(2.0 * time / duration - 1.0))
            trimmed = -gust if time < leaves else -limit  # delta over B
            return [x[1], mu * (x[0] - gust) - mu * trimmed - damping * x[1]]

        x = [0.0, 0.0]
        for begin, end in zip(knots := sorted({0.0, leaves, duration / 2, duration}), knots[1:],
                              strict=False):  # fmt: skip
            inside = (begin + 1e-12, end - 1e-12)
            x = solve_ivp(rates, inside, x, method="DOP853", rtol=1e-12, atol=1e-15).y[:, -1]
        # Alone with the limit, theta'' + d theta' - mu (theta + limit) = 0 grows or does not.
        late = solve_ivp(
            lambda time, x: [x[1], mu * (x[0] + limit) - damping * x[1]],
            (0.0, 14.0 / pole), x, method="DOP853", rtol=1e-12, atol=1e-15,
        )  # fmt: skip
        return late.y[0, -1]

    return brentq(falls, 0.01, 0.999 / max(K, 1e-9) if K else 1.0, xtol=1e-10)


@pytest.mark.thorough
@pytest.mark.parametrize(("mu", "damping", "tau_pole", "K", "expected"), NUMBERS)
def test_limits_are_those_of_an_integration_that_knows_no_pole(mu, damping, tau_pole, K, expected):
    c = tv.Coefficients(mu_alpha=mu, mu_delta=2.6, damping=damping)
    wind_ = tv.TriangularWind(peak=PEAK, duration=tau_pole / c.pole)
    assert tv.boundary_limit(tv.Plant(c, "fixed-path"), wind_, K).limit == pytest.approx(
        expected, abs=5e-9
    )
    assert triangular_limit(tau_pole, K) == pytest.approx(expected, abs=5e-9)
    assert flown_limit(mu, damping, tau_pole, K) == pytest.approx(expected, abs=2e-6)


def test_closed_forms_of_drift_hold_with_the_pole_in_the_place_of_beta():
    """Eqs (16) and (18) of random vehicles, some of them damped by more than beta."""
    rng = np.random.default_rng(3)
    mu = rng.uniform(0.05, 7.0, 60)
    damping = rng.uniform(0.0, 1.5, 60) * np.sqrt(mu)
    b2_ = rng.uniform(0.005, 0.03, 60)
    drift = {"b1": b2_ + rng.uniform(0.0, 0.02, 60), "b2": b2_}
    c = tv.Coefficients(mu_alpha=mu, mu_delta=3.0, damping=damping, **drift)
    plant, x, K_ = tv.Plant(c, "drift"), rng.uniform(0.3, 14.0, 60), rng.uniform(0.0, 1.0, 60)
    triangle = tv.TriangularWind(peak=PEAK, duration=x / c.pole)
    expected = triangular_limit_with_drift(x, K_, c.pole, c.b1, c.b2)
    np.testing.assert_allclose(tv.boundary_limit(plant, triangle, K_).limit, expected, rtol=1e-12)
    rectangle = tv.RectangularWind(peak=PEAK, duration=x / c.pole)
    computed = tv.boundary_limit(plant, rectangle, 1.0).limit
    np.testing.assert_allclose(computed, rectangular_limit(x, c.K1), rtol=1e-12)
    poles = np.sort(np.real(plant.poles), axis=-1)
    np.testing.assert_allclose(poles[:, -1], c.pole, rtol=1e-12)
    np.testing.assert_allclose(poles[:, 0], -(c.pole + c.damping), rtol=1e-12)


@pytest.mark.thorough
@pytest.mark.parametrize("tau_pole", usual([3.0, 8.0], 0))
def test_the_bound_without_forecast_and_the_minimum_are_those_of_the_pole(tau_pole):
    """W(t) = p integral of e^(-p (r - t)) wind(r) dr: max{W(0), sup W/2}, and W(0)."""
    c = tv.Coefficients(mu_alpha=0.28, mu_delta=2.6, damping=0.4)
    pole, plant = fast_pole(0.28, 0.4), tv.Plant(c, "fixed-path")
    wind_ = tv.TriangularWind(peak=PEAK, duration=tau_pole / pole)
    end = float(wind_.end)

    def ahead(time):
        ends = [x for x in (time, end / 2, end) if x >= time]
        integrand = lambda r: pole * np.exp(-pole * (r - time)) * float(wind_(r))  # noqa: E731
        return sum(quad(integrand, *part)[0] for part in pairwise(ends)) / PEAK

    top = max(ahead(time) for time in np.linspace(0.0, end, 801))
    bound = max(ahead(0.0), top / 2.0)
    assert tv.forecast_free_limit(plant, wind_).limit == pytest.approx(bound, rel=1e-5)
    least = tv.optimum_deflection(plant, wind_, 0.0).peak / (abs(c.B) * PEAK)
    assert least == pytest.approx(ahead(0.0), rel=1e-9)


@pytest.mark.parametrize(("K", "where"), [(0.5, 4.09), (0.0, 2.51)])
def test_a_slower_pole_asks_for_more_beyond_the_largest_limit(K, where):
    minimum = minimize_scalar(
        lambda x: -triangular_limit(x, K), bounds=(0.5, 12.0), method="bounded"
    )
    assert minimum.x == pytest.approx(where, abs=5e-3)
    assert triangular_limit(0.96 * 14.0, K) > triangular_limit(14.0, K)
    assert triangular_limit(0.96 * 2.0, K) < triangular_limit(2.0, K)


def test_with_the_whole_dead_band_damping_always_relieves():
    x = np.linspace(0.05, 40.0, 800)
    assert np.all(np.diff(triangular_limit(x, 1.0)) > 0.0)


@pytest.mark.parametrize(
    ("name", "damping", "tau_beta", "K", "limit", "before"),
    [
        ("configuration-i", 0.0241, 4.0, 1.0, 0.6500, 0.6560),
        ("configuration-i", 0.0241, 4.0, 0.5, 0.5390, 0.5399),
        ("configuration-i", 0.0241, 4.0, 0.0, 0.3736, 0.3707),
        ("configuration-i", 0.0241, 14.0, 1.0, 0.8146, 0.8167),
        ("configuration-i", 0.0241, 14.0, 0.5, 0.2859, 0.2796),
        ("configuration-i", 0.0241, 14.0, 0.0, 0.1482, 0.1447),
        ("configuration-ii", 0.0320, 4.0, 1.0, 0.6370, 0.6482),
        ("configuration-ii", 0.0320, 14.0, 0.0, 0.1536, 0.1470),
    ],
)
def test_what_a_jet_changes_at_full_scale(name, damping, tau_beta, K, limit, before):
    """The jet alone, an upper bound: with K below 1 a long wind asks for more than without."""
    c = tv.Coefficients.from_vehicle(tv.load_vehicle(name))
    triangle = tv.TriangularWind(peak=PEAK, duration=tau_beta / c.beta)
    for value, expected in ((damping, limit), (0.0, before)):
        plant = tv.Plant(c.replace(damping=value), "drift-exact")
        computed = tv.boundary_limit(plant, triangle, K).limit
        assert computed == pytest.approx(expected, abs=6e-5)


@pytest.mark.thorough
def test_the_response_is_two_unlike_exponentials():
    """Theta under a unit step of -(delta/B + wind): c(t) - 1, c'' + d c' = p (p + d) c."""
    c = ((p + d) * sp.exp(p * t) + p * sp.exp(-(p + d) * t)) / (2 * p + d)
    assert sp.simplify(sp.diff(c, t, 2) + d * sp.diff(c, t) - p * (p + d) * c) == 0
    plant = tv.Plant(tv.Coefficients(mu_alpha=0.28, mu_delta=2.6, damping=0.4), "fixed-path")
    times = np.linspace(0.0, 4.0, 9)
    step = tv.linear.ConstantDeflection(limit=-plant.coefficients.B * PEAK)
    calm = 0.0 * tv.RectangularWind(peak=PEAK, duration=1.0)
    computed = tv.attitude_responses(plant, step, calm, times)["attitude"] / PEAK
    numbers = {p: fast_pole(0.28, 0.4), d: 0.4}
    np.testing.assert_allclose(
        computed, sp.lambdify(t, c.subs(numbers) - 1)(times), rtol=1e-11, atol=1e-15
    )


@pytest.mark.parametrize(
    ("tau_pole", "more"), [(2.0, False), (3.5, True), (4.4, True), (6.0, False)]
)
def test_the_bound_without_forecast_turns_twice(tau_pole, more):
    """From 2.51 to 4.46 it is that of a wind that goes on, W(0); beyond, half the largest W."""
    plant = tv.Plant(tv.Coefficients.from_beta(beta=1.0, B=0.1), "fixed-path")
    now, slower = (
        tv.forecast_free_limit(plant, tv.TriangularWind(peak=PEAK, duration=part * tau_pole)).limit
        for part in (1.0, 0.96)
    )
    assert (slower > now) == more


def test_what_a_pole_four_percent_slower_changes_is_what_the_page_says():
    """The table of docs/limits.md, from eq (12)."""
    page = {1.0: (0.6885, 0.6786, 0.9010, 0.8969), 0.5: (0.5588, 0.5580, 0.2843, 0.2957)}
    page[0.0] = (0.3738, 0.3793, 0.1426, 0.1485)
    for K_, numbers in page.items():
        result = triangular_limit(np.array([4.0, 0.96 * 4.0, 14.0, 0.96 * 14.0]), K_)
        np.testing.assert_allclose(result, numbers, atol=5e-5)


@pytest.mark.parametrize("ratio", [1e2, 1e4])
def test_a_damping_so_large_that_hardly_anything_grows_is_no_rounding(ratio):
    """The pole goes to mu_alpha/d, and the limit to the wind's mean: p tau/2 for each K."""
    c = tv.Coefficients(mu_alpha=0.28, mu_delta=2.6, damping=ratio * np.sqrt(0.28))
    triangle = tv.TriangularWind(peak=PEAK, duration=7.5)
    computed = tv.boundary_limit(tv.Plant(c, "fixed-path"), triangle, [1.0, 0.5, 0.0]).limit
    np.testing.assert_allclose(
        computed, 7.5 / 2 * 0.28 / c.damping, rtol=2 * 7.5 * 0.28 / c.damping
    )
    np.testing.assert_allclose(computed, triangular_limit(7.5 * c.pole, [1.0, 0.5, 0.0]), rtol=1e-9)
