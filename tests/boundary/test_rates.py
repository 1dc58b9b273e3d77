"""Angle and rate together, against linear programs, integrals and the minimum of appendix C."""

import numpy as np
import pytest
from scipy import sparse
from scipy.integrate import quad
from scipy.optimize import linprog

import tvclin as tv
from tests.turns import usual
from tvclin.boundary import optimum_with_rate_limit, rate_trade_off
from tvclin.boundary.limit_over_rate import ramped_deflection

PEAK, B, BETA = 0.1, 0.1, 0.5
FIXED = tv.Plant(tv.Coefficients.from_beta(beta=BETA, B=B), "fixed-path")
MULTIPLES = np.array([1.1, 1.5, 2.0, 4.0])


def exact():
    return tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")


def triangle(plant, tau_beta):
    return tv.TriangularWind(peak=-PEAK, duration=tau_beta / plant.coefficients.beta)


def relative(plant, wind, rates, **options):
    front = rate_trade_off(plant, wind, rates, **options)
    return front.limits / (plant.coefficients.B * PEAK)


@pytest.mark.parametrize(
    ("plant", "tau_beta", "expected"),
    [
        (FIXED, 2.0, [1.05396, 0.65847, 0.55393, 0.45980]),
        (FIXED, 4.0, [0.98603, 0.61603, 0.51823, 0.43017]),
        (FIXED, 8.0, [0.63549, 0.39703, 0.33399, 0.27724]),
        (exact(), 2.0, [1.02481, 0.64026, 0.53861, 0.44709]),
        (exact(), 4.0, [0.97778, 0.61088, 0.51389, 0.42657]),
        (exact(), 8.0, [0.64145, 0.40075, 0.33713, 0.27984]),
    ],
)
def test_triangles_need_what_a_program_of_their_own_found(plant, tau_beta, expected):
    wind = triangle(plant, tau_beta)
    rates = MULTIPLES * rate_trade_off(plant, wind).minimum_rate
    assert relative(plant, wind, rates) == pytest.approx(expected, abs=6e-6)


def test_other_winds_and_an_acceleration_limit():
    pole, unit = BETA, B * PEAK
    length = 4.0 / pole
    jump = tv.RectangularWind(peak=-PEAK, duration=length)
    minimum = tv.optimum_deflection(FIXED, jump).peak
    assert relative(FIXED, jump, pole * minimum * np.array([1.25, 5.0])) == pytest.approx(
        [1.97495, 1.09528], abs=6e-6
    )
    gust = tv.OneMinusCosineGust(peak=-PEAK, duration=length)
    minimum = tv.optimum_deflection(FIXED, gust).peak
    result = relative(FIXED, gust, pole * minimum * np.array([1.25, 5.0]))
    assert result == pytest.approx([0.70269, 0.38970], abs=6e-6)
    wind = triangle(FIXED, 4.0)
    result = relative(FIXED, wind, [2.0 * pole * unit], acceleration_limit=4.0 * pole**2 * unit)
    assert result == pytest.approx([0.53249], abs=6e-6)


@pytest.mark.parametrize("acceleration", [None, 0.5])
def test_a_linear_program_on_a_fine_grid_needs_the_same(acceleration):
    """Values at even nodes, straight between them, with exact moments; the last is held."""
    wind, rate, h, count = triangle(FIXED, 4.0), 0.004, 0.03, 900
    times, x = h * np.arange(count), BETA * h
    share = np.exp(-BETA * times) * (2.0 * np.cosh(x) - 2.0) / (BETA**2 * h)
    share[-1] = np.exp(-BETA * times[-1]) * ((np.expm1(x) - x) / (BETA**2 * h) + 1.0 / BETA)
    demand = -B * quad(lambda t: np.exp(-BETA * t) * wind(t), 0.0, 8.0, points=[4.0])[0]
    unit, still = sparse.eye_array(count, format="csr"), np.zeros((count, 1))
    turning = unit[1:] - unit[:-1]
    rows = [sparse.hstack([s * unit, still - 1.0]) for s in (1.0, -1.0)]
    rows += [sparse.hstack([s * turning, still[1:]]) for s in (1.0, -1.0)]
    below, most = [np.zeros(2 * count), np.full(2 * count - 2, rate * h)], {}
    if acceleration is not None:
        most = {"acceleration_limit": acceleration * rate}
        bends = sparse.vstack([turning[:1], turning[1:] - turning[:-1], turning[-1:]])
        rows += [sparse.hstack([s * bends, still]) for s in (1.0, -1.0)]
        apart = np.r_[0.5, np.ones(count - 2), 0.5]  # half a step to and from rest
        below += [acceleration * rate * h**2 * apart] * 2
    first = np.eye(1, count + 1)
    program = linprog(
        np.append(np.zeros(count), 1.0),
        A_ub=sparse.vstack(rows),
        b_ub=np.concatenate(below),
        A_eq=np.vstack([np.append(share, 0.0), first]),
        b_eq=[demand, 0.0],
        bounds=(None, None),
    )
    assert program.status == 0
    minimum = rate_trade_off(FIXED, wind, [rate], **most).limits[0]
    assert minimum == pytest.approx(program.fun, rel=1e-4)


@pytest.mark.parametrize(
    "model", usual(["fixed-path", "drift", "drift-exact", "drift-and-speed"], 0, 2)
)
def test_at_any_rate_it_is_the_minimum_of_appendix_c(model):
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), model)
    for tau_beta in (2.0, 8.0, 20.0):
        wind = triangle(plant, tau_beta)
        minimum = tv.optimum_deflection(plant, wind).peak
        computed = rate_trade_off(plant, wind, [1e9 * plant.coefficients.pole * minimum]).limits[0]
        programmed = model == "drift-and-speed" or (model == "drift-exact" and tau_beta == 20.0)
        assert computed == pytest.approx(minimum, rel=1e-6 if programmed else 2e-9)
    assert ramped_deflection(0.3, 0.5, np.inf) == 0.3
    assert ramped_deflection(0.3, 0.5, np.inf, np.inf) == 0.3


@pytest.mark.thorough
def test_two_poles_are_never_told_too_little():
    """Where the flight path decides the limit is that of the program, above the fast pole's."""
    plant = exact()
    for tau_beta in (8.0, 13.0, 15.0, 16.0, 20.0):
        wind = triangle(plant, tau_beta)
        front = rate_trade_off(plant, wind, MULTIPLES * rate_trade_off(plant, wind).minimum_rate)
        by_program = [optimum_with_rate_limit(plant, wind, float(r)).peak for r in front.rates]
        assert front.limits == pytest.approx(by_program, rel=1e-5)


def test_the_bound_without_a_forecast_is_reached_within_what_is_known_of_it():
    for tau_beta, rho, program in (
        (2.0, [1.2, 2.0], [0.486, 0.446]),
        (4.0, [0.6, 1.0, 2.0, 5.0], [0.734, 0.514, 0.416, 0.389]),
        (8.0, [0.6, 1.0, 2.0, 5.0], [0.934, 0.636, 0.512, 0.450]),
    ):
        front = rate_trade_off(FIXED, triangle(FIXED, tau_beta), np.array(rho) * BETA * B * PEAK)
        bounds = front.no_forecast_bounds / (B * PEAK)
        assert np.all(bounds <= np.array(program) + 0.002)
        assert np.all(front.no_forecast_bounds >= front.limits * (1.0 - 1e-12))
    assert bounds[2] == pytest.approx(0.465, abs=6e-4)


def test_a_stop_and_the_wind_to_come_leave_no_state_below_the_bound():
    """States (z, v) from which both a stop and the wind still to come are survived."""
    rho, ahead = 2.0, 0.7  # W, in B A
    bound = -rho * np.log1p(-ahead / 2.0 / rho)
    for y, some in ((bound * 0.999, False), (bound * 1.001, True)):
        v = np.linspace(-y, y, 2001)
        upper = rho * -np.expm1(-(y + v) / rho)
        lower = ahead - rho * -np.expm1(-(y - v) / rho)
        assert bool(np.any(lower < upper)) is some


def test_the_nozzle_s_point_is_judged_by_the_larger_of_both():
    plant, wind = exact(), triangle(exact(), 8.0)
    front = rate_trade_off(plant, wind, limit=0.006, rate_limit=0.01)
    at = rate_trade_off(plant, wind, [0.01, front.required_rate])
    assert front.lower_bound == max(at.limits[0], at.no_forecast_bounds[0])
    assert max(at.limits[1], at.no_forecast_bounds[1]) == pytest.approx(0.006, rel=1e-8)
    assert (front.remaining > 0.0) == (front.remaining_rate > 0.0) == front.above_lower_bound
    assert rate_trade_off(plant, wind, limit=1e-4).required_rate == np.inf


def test_the_verdict_says_whether_a_forecast_would_help():
    wind = triangle(FIXED, 10.0)
    front = rate_trade_off(FIXED, wind)
    blind = front.lower_bound  # at any rate, which is more than the known wind's
    assert blind > 1.2 * front.minimum_deflection
    for limit, rate, words in (
        (0.9 * blind, None, "no forecast"),
        (0.9 * blind, 20.0 * front.minimum_rate, "no forecast"),
        (0.9 * front.minimum_deflection, None, "wind known"),
        (None, 1.1 * front.minimum_rate, "no forecast"),
        (1.1 * front.minimum_deflection, 1.1 * front.minimum_rate, "wind known"),
    ):
        result = rate_trade_off(FIXED, wind, limit=limit, rate_limit=rate)
        assert result.above_lower_bound is False
        assert result.verdict == f"NOT SUFFICIENT, below the lower bound, {words}"


def test_the_bound_without_a_forecast_is_not_that_of_a_law_with_one():
    """Its required rate is that of the curve with the wind known: at that rate the limit is its."""
    wind = triangle(FIXED, 8.0)
    front = rate_trade_off(FIXED, wind)
    blind = tv.boundary.forecast_free_limit(FIXED, wind).deflection
    limit = 0.5 * (front.minimum_deflection + abs(blind))
    assert front.minimum_deflection < limit < abs(blind)
    known = rate_trade_off(FIXED, wind, limit=limit, forecast=True)
    assert (known.above_lower_bound, known.verdict) == (True, "")
    assert known.lower_bound == front.minimum_deflection
    at = rate_trade_off(FIXED, wind, [known.required_rate])
    assert at.limits[0] == pytest.approx(limit, rel=1e-9)


def test_no_limit_is_sufficient_at_too_low_a_rate_and_too_low_an_acceleration_is_refused():
    wind = triangle(FIXED, 4.0)
    front = rate_trade_off(FIXED, wind)
    assert front.minimum_rate == pytest.approx(BETA * tv.optimum_deflection(FIXED, wind).peak)
    slow = rate_trade_off(FIXED, wind, limit=0.3, rate_limit=front.minimum_rate)
    assert np.isinf(slow.limits[0])
    assert np.isinf(slow.lower_bound)
    assert slow.above_lower_bound is False
    assert slow.verdict == "NOT SUFFICIENT, below the lower bound, wind known"
    with pytest.raises(tv.InputError, match=f"{front.minimum_rate:.6g} rad/s"):
        tv.boundary.load_trade_off(FIXED, wind, rate_limit=front.minimum_rate)
    with pytest.raises(tv.InputError, match="acceleration_limit must be above"):
        rate_trade_off(FIXED, wind, acceleration_limit=BETA * front.minimum_rate)
    with pytest.raises(tv.InputError, match="one unstable pole decides"):
        rate_trade_off(exact(), triangle(exact(), 20.0), acceleration_limit=10.0)


def test_a_wind_that_turns_has_no_bound_and_a_stable_vehicle_needs_nothing():
    wind = triangle(FIXED, 4.0)
    front = rate_trade_off(FIXED, wind - 0.5 * wind.shift(8.0))
    assert front.no_forecast_bounds is None
    assert np.all(np.isfinite(front.limits))
    assert "changes its sign" in next(front.notes)
    still = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=-0.2, mu_delta=2.0), "fixed-path")
    front = rate_trade_off(still, wind, limit=0.01, rate_limit=0.01)
    assert front.above_lower_bound
    assert not np.any(front.limits)
    assert "neither" in next(front.notes)
