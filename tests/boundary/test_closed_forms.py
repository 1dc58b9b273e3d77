"""The closed forms, against the report's printed equations in 80 digits.

A value y is within a relative error e of the root of a printed equation when its residual changes
sign between y (1 - e) and y (1 + e), so no solver of our own can lend its bias.
"""

import numpy as np
import pytest
from mpmath import exp, expm1, mpf, workdps

from tvclin import InputError
from tvclin.boundary.closed_forms import (
    rectangular_limit,
    solve_triangular_with_drift,
    triangular_limit,
    triangular_limit_with_drift,
)

EDGES_TAU_BETA = [1e-3, 0.01, 0.5, 1.9999999, 2.0, 2.0000001, 4.0, 20.0, 200.0]
EDGES_K = [0.0, 1e-12, 1e-3, 0.5, 0.999, 1.0 - 1e-12, 1.0]
TINY = mpf(10) ** -30


def cases(count, seed):
    """Return tau beta from 1e-3 to 200 and dead bands: all edges, then `count` random pairs."""
    rng = np.random.default_rng(seed)
    edges = np.array([(x, k) for x in EDGES_TAU_BETA for k in EDGES_K]).T
    tau_beta = 10.0 ** rng.uniform(-3, np.log10(200), count)
    dead_band = rng.uniform(0, 1, count)
    dead_band[: count // 4] = 1.0 - 10.0 ** rng.uniform(-14, -1, count // 4)
    dead_band[count // 4 : count // 2] = 10.0 ** rng.uniform(-14, -1, count // 4)
    return np.concatenate([edges[0], tau_beta]), np.concatenate([edges[1], dead_band])


def wind_term(x):
    return exp(-x) * (2 * exp(x / 2) - 1)


def eq_12(y, x, K):
    return (1 - x / 2 * y * (1 - K)) * exp(-x / 2 * y * K) - wind_term(x)


def eq_18(y, x, K, beta, b1, b2):
    a = y * x / beta / 2 * K  # eq (11)
    drift = exp(-b1 * a) / (beta + b1) + b1 / beta**2 + b1 * a / beta - 1 / beta
    left = 1 - x / 2 * y * (1 - K) + (b2 - b1) * (beta / b1) ** 2 * drift
    return left * exp(-a * beta) - (beta + b2) / (beta + b1) * wind_term(x)


def brackets(residual, y, error, *numbers):
    """Whether the falling residual changes its sign within a relative `error` of y."""
    with workdps(80):
        numbers = [mpf(float(n)) for n in numbers]
        low, high = (mpf(float(y)) * (1 + sign * mpf(error)) for sign in (-1, 1))
        return residual(low, *numbers) > 0 > residual(high, *numbers)


def test_eq_7_and_eq_16_to_thirteen_digits():
    tau_beta, K1 = cases(1000, 1)
    result = rectangular_limit(tau_beta, K1)
    with workdps(50):
        expected = [float(-mpf(k) * expm1(-mpf(x))) for x, k in zip(tau_beta, K1, strict=True)]
    np.testing.assert_allclose(result, expected, rtol=1e-13)
    np.testing.assert_array_equal(rectangular_limit(tau_beta), rectangular_limit(tau_beta, 1.0))


def test_eq_12_as_printed_to_fifteen_digits():
    tau_beta, dead_band = cases(2000, 2)
    result = triangular_limit(tau_beta, dead_band)
    missed = [
        (x, K)
        for y, x, K in zip(result, tau_beta, dead_band, strict=True)
        if not brackets(eq_12, y, 1e-15, x, K)
    ]
    assert missed == []


def drift_cases(count, seed):
    rng = np.random.default_rng(seed)
    tau_beta, dead_band = cases(count, seed)
    size = tau_beta.size
    beta = 10.0 ** rng.uniform(-1, 0.5, size)
    b1 = beta * 10.0 ** rng.uniform(-12, -0.3, size)
    b2 = b1 * rng.uniform(-0.5, 1.0, size)
    b2[::5] = b1[::5] * (1.0 - 10.0 ** rng.uniform(-12, -1, b2[::5].size))
    b2[1::10] = b1[1::10]
    return tau_beta, dead_band, beta, b1, b2


@pytest.mark.thorough
def test_eq_18_as_printed_to_thirteen_digits():
    arguments = drift_cases(2000, 3)
    solution = solve_triangular_with_drift(*arguments)
    missed = [
        numbers
        for y, *numbers in zip(solution.limit, *arguments, strict=True)
        if not brackets(eq_18, y, 1e-13, *numbers)
    ]
    assert missed == []
    assert set(solution.status) == {"ok"}
    np.testing.assert_array_equal(solution.limit, triangular_limit_with_drift(*arguments))


@pytest.mark.parametrize("dead_band", EDGES_K)
def test_eq_18_has_a_limit_for_b1_equal_to_zero(dead_band):
    for tau_beta in EDGES_TAU_BETA:
        y = triangular_limit_with_drift(tau_beta, dead_band, 0.5, 0.0, -0.02)
        with workdps(120):  # printed with b1 = 1e-30, which moves the root by as little
            low, high = (
                eq_18(
                    mpf(y) * (1 + e * mpf("1e-11")),
                    mpf(tau_beta),
                    mpf(dead_band),
                    0.5,
                    TINY,
                    mpf(-0.02),
                )
                for e in (-1, 1)
            )
        assert low > 0 > high


def test_without_drift_eq_18_is_eq_12():
    tau_beta, dead_band = cases(200, 4)
    solution = solve_triangular_with_drift(tau_beta, dead_band, 0.5, 0.03, 0.03)
    np.testing.assert_allclose(solution.limit, triangular_limit(tau_beta, dead_band), rtol=1e-13)
    assert np.all(solution.status == "ok")  # b2 is b1, not above it


def test_the_bits_of_a_limit_do_not_depend_on_the_others_of_a_batch():
    numbers = np.array(drift_cases(300, 10))
    fixed, drifting = triangular_limit(*numbers[:2]), triangular_limit_with_drift(*numbers)
    for k in range(82, fixed.size, 8):  # at the same place among equals, which converge together
        alike = np.repeat(numbers[:, k : k + 1], fixed.size, axis=1)
        assert triangular_limit(*alike[:2])[k] == fixed[k]
        assert triangular_limit_with_drift(*alike)[k] == drifting[k]


def test_very_short_winds_have_the_limit_of_their_area():
    x = 1e-6  # to first order in tau beta: all of it for a rectangle, half of it for a triangle
    assert rectangular_limit(x) == pytest.approx(x, rel=1e-6)
    for dead_band in EDGES_K:
        assert triangular_limit(x, dead_band) == pytest.approx(x / 2, rel=1e-6)
        drifting = triangular_limit_with_drift(x, dead_band, 0.5, 0.03, 0.02)
        assert drifting == pytest.approx(0.52 / 0.53 * x / 2, rel=1e-6)


def test_very_long_winds_stay_finite():
    assert rectangular_limit(700.0) == 1.0
    p = 350.0  # R = 2 e^-p to rounding
    assert triangular_limit(700.0, 1.0) == pytest.approx(1.0 - np.log(2.0) / p, rel=1e-14)
    assert triangular_limit(700.0, 0.0) == pytest.approx(1.0 / p, rel=1e-14)
    assert triangular_limit(700.0, 0.5) == pytest.approx(2.0 / p, rel=1e-14)
    solution = solve_triangular_with_drift(700.0, EDGES_K, 0.53, 0.028, 0.017)
    assert np.all((solution.limit > 0.0) & (solution.limit < 1.0))
    assert np.all(solution.status == "ok")


def test_more_dead_band_needs_more_deflection():
    tau_beta = np.geomspace(1e-2, 200, 60)[:, np.newaxis]
    dead_band = np.linspace(0.0, 1.0, 41)
    assert np.all(np.diff(triangular_limit(tau_beta, dead_band), axis=-1) > 0.0)


def test_longer_winds_need_more_where_the_vehicle_is_trimmed_throughout():
    tau_beta = np.geomspace(1e-3, 30, 200)
    assert np.all(np.diff(triangular_limit(tau_beta, 1.0)) > 0.0)
    assert np.all(np.diff(rectangular_limit(tau_beta)) > 0.0)


def test_with_half_a_dead_band_56_percent_at_tau_beta_4_is_the_worst_case():
    tau_beta = np.linspace(0.1, 40.0, 40_000)
    y = triangular_limit(tau_beta, 0.5)
    assert y.max() == pytest.approx(0.55886, abs=5e-6)
    assert tau_beta[np.argmax(y)] == pytest.approx(4.087, abs=2e-3)


def test_drift_and_the_triangle_only_ever_help():
    tau_beta, dead_band, beta, b1, _ = drift_cases(300, 5)
    fixed = triangular_limit(tau_beta, dead_band)
    drifting = triangular_limit_with_drift(tau_beta, dead_band, beta, b1, 0.3 * b1)
    assert np.all(drifting < fixed * (1.0 + 1e-13))
    assert np.all(fixed < rectangular_limit(tau_beta))


def test_the_switch_comes_in_the_first_half_of_the_wind():
    arguments = drift_cases(300, 6)
    solution = solve_triangular_with_drift(*arguments)
    assert np.all(solution.switch <= 0.5)
    np.testing.assert_allclose(solution.switch, solution.limit * arguments[1] / 2, rtol=1e-15)


def test_a_root_beyond_its_usual_ends_is_found_beside_a_plain_one():
    # With K1 > 1 the root z = y tau beta/2 of eq (18) may lie beyond 1/(1 - K).
    numbers = [20.0, 4.0], [0.1, 0.5], 0.5, 0.01, [0.2, 0.005]
    result = solve_triangular_with_drift(*numbers)
    assert result.limit[0] * 10.0 > 1.0 / (1.0 - 0.1)
    for y, *at in zip(result.limit, *np.broadcast_arrays(*numbers), strict=True):
        assert brackets(eq_18, y, 1e-11, *at)


def test_where_b2_is_above_b1_the_status_says_so_and_the_value_is_a_solution():
    solution = solve_triangular_with_drift(4.0, 0.5, 0.5, 0.02, 0.03)
    assert "b2 is above b1" in solution.status
    assert brackets(eq_18, solution.limit, 1e-11, 4.0, 0.5, 0.5, 0.02, 0.03)


def test_where_b2_is_above_b1_newton_is_led_back_to_a_solution_from_wherever_it_leaps():
    # The left side is no longer concave: steps without ends miss a root of one case in forty.
    tau_beta, dead_band, beta, b1, _ = drift_cases(400, 7)
    b2 = b1 + np.random.default_rng(8).uniform(0.0, 2.0, b1.size) * (beta + b1)
    x = np.minimum(tau_beta, 60.0)
    solution = solve_triangular_with_drift(x, dead_band, beta, b1, b2)
    assert np.all(solution.limit > 0.0)
    for y, *at in zip(solution.limit, x, dead_band, beta, b1, b2, strict=True):
        with workdps(80):
            numbers = [mpf(float(number)) for number in at]
            ends = [eq_18(mpf(y) * (1 + mpf(e)), *numbers) for e in ("-1e-11", "1e-11")]
        assert ends[0] * ends[1] < 0, at


def test_a_trim_that_cannot_saturate_is_said_and_gives_no_false_solution():
    # The left side of eq (18) is still above the right one at K y = 1, the end of eq (11).
    with workdps(80):
        assert eq_18(mpf(1), *(mpf(float(n)) for n in (40, 1, 0.5, 0.01, 0.3))) > 0
    assert "never saturates" in solve_triangular_with_drift(40.0, 1.0, 0.5, 0.01, 0.3).status


def test_one_number_gives_one_number_and_arrays_broadcast():
    assert type(triangular_limit(4.0, 0.5)) is float
    assert type(solve_triangular_with_drift(4.0, 0.5, 0.5, 0.03, 0.02).status) is str
    grid = triangular_limit([[1.0], [4.0]], [0.0, 0.5, 1.0])
    assert grid.shape == (2, 3)
    assert grid[1, 2] == triangular_limit(4.0, 1.0)


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf, "x"], ids=repr)
def test_a_tau_beta_that_is_not_positive_is_refused(bad):
    for call in (
        lambda: rectangular_limit(bad),
        lambda: triangular_limit(bad, 0.5),
        lambda: triangular_limit_with_drift(bad, 0.5, 0.5, 0.03, 0.02),
    ):
        with pytest.raises(InputError, match="^tau_beta must be"):
            call()


@pytest.mark.parametrize("bad", [-1e-9, 1.0 + 1e-9, np.nan, "x"], ids=repr)
def test_a_dead_band_outside_zero_to_one_is_refused(bad):
    for call in (triangular_limit, lambda x, K: triangular_limit_with_drift(x, K, 0.5, 0.03, 0.02)):
        with pytest.raises(InputError, match="^dead_band must be"):
            call(4.0, bad)


@pytest.mark.parametrize(
    ("name", "rim", "beyond"),
    [
        ("beta", 1e-9, 0.999e-9),
        *((name, 1e9, 1.001e9) for name in ("beta", "b1", "b2")),
        *((name, 0.0, -1.001e9) for name in ("b1", "b2")),
    ],
)
def test_rates_that_no_vehicle_has_are_refused(name, rim, beyond):
    rates = {"beta": 1e9, "b1": 0.0, "b2": 0.0}
    assert triangular_limit_with_drift(4.0, 0.5, **rates | {name: rim}) > 0.0
    with pytest.raises(InputError, match=f"^{name} must be between"):
        triangular_limit_with_drift(4.0, 0.5, **rates | {name: beyond})


@pytest.mark.parametrize("bad", [np.nan, np.inf, "x"], ids=repr)
def test_a_ratio_of_the_drift_that_is_no_number_is_refused(bad):
    with pytest.raises(InputError, match=r"^K1 must be"):
        rectangular_limit(4.0, bad)


def test_a_numerator_zero_beyond_the_pole_is_refused():
    for b1, b2 in ((-0.5, -0.6), (-0.5, 0.02), (0.03, -0.5), ([0.03, -0.6], 0.02), (0.03, [0, -1])):
        with pytest.raises(InputError, match="^beta \\+ b1 and beta \\+ b2 must be positive"):
            triangular_limit_with_drift(4.0, 0.5, 0.5, b1, b2)


def test_shapes_that_do_not_broadcast_are_refused():
    for call in (rectangular_limit, triangular_limit):
        with pytest.raises(InputError, match="broadcast"):
            call([1.0, 2.0], [0.1, 0.2, 0.3])
    with pytest.raises(InputError, match=r"got tau_beta \(2,\), b1 \(3,\)"):
        triangular_limit_with_drift([1.0, 2.0], 0.5, 0.5, [0.03, 0.02, 0.01], 0.01)


def test_a_zero_beyond_the_pole_in_the_left_half_plane_is_no_error():
    z = triangular_limit_with_drift(4.0, 1.0, 0.5, 0.7, 0.6) * 2.0
    K1, L, rho = 1.1 / 1.2, -np.log(2.0 * np.exp(-2.0) - np.exp(-4.0)), 0.7 / 0.5
    path = (np.exp(-rho * z) - 1.0 + rho * z) / rho**2
    assert K1 * (1.0 - np.exp(z - L)) == pytest.approx((0.1 / 1.2) * (z + path), rel=1e-12)
