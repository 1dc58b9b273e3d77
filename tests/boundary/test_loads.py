"""Angle and load together, against linear programs of another form, closed forms and flights."""

import numpy as np
import pytest
from scipy import sparse
from scipy.integrate import solve_ivp
from scipy.optimize import linprog

import tvclin as tv
from tests.turns import usual
from tvclin.boundary import load_trade_off

PEAK, B, BETA = 0.1, 0.1, 0.5
FIXED = tv.Plant(tv.Coefficients.from_beta(beta=BETA, B=B), "fixed-path")


def exact():
    return tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")


def triangle(plant, tau_beta):
    return tv.TriangularWind(peak=-PEAK, duration=tau_beta / plant.coefficients.beta)


def relative(plant, wind, loads, **options):
    """Limits and what is proved, over the trim deflection, at loads over the wind's peak."""
    front = load_trade_off(plant, wind, PEAK * np.array(loads), **options)
    unit = plant.coefficients.B * PEAK
    return front.limits / unit, front.lower_bounds / unit


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("plant", "tau_beta", "loads", "expected"),
    usual(
        [
            (FIXED, 2.0, [0.8, 0.6], [0.6909, 1.0591]),
            (FIXED, 4.0, [0.6, 0.4, 0.2], [0.4393, 0.5125, 0.7249]),
            (FIXED, 8.0, [0.4, 0.2], [0.2441, 0.2562]),
            (exact(), 4.0, [0.7, 0.5, 0.3], [0.4013, 0.4768, 0.5686]),
            (exact(), 8.0, [0.3], [0.2511]),
        ],
        1,
        3,
    ),
)
def test_triangles_need_what_a_program_of_their_own_found(plant, tau_beta, loads, expected):
    limits, lower_bounds = relative(plant, triangle(plant, tau_beta), loads)
    assert limits == pytest.approx(expected, abs=3e-4)
    assert np.all(lower_bounds <= limits * (1.0 + 1e-9))
    assert lower_bounds == pytest.approx(limits, rel=2e-4)


@pytest.mark.thorough
def test_a_curved_gust_and_rate_limits_need_it_too():
    plant = exact()
    gust = tv.OneMinusCosineGust(peak=-PEAK, duration=4.0 / plant.coefficients.beta)
    limits, _ = relative(plant, gust, [0.7, 0.5, 0.3])
    assert limits == pytest.approx([0.3598, 0.4528, 0.5906], abs=3e-4)
    for rho, expected in ((1.0, 0.581), (2.0, 0.466)):
        rate = rho * plant.coefficients.beta * plant.coefficients.B * PEAK
        limits, lower_bounds = relative(plant, triangle(plant, 4.0), [0.7], rate_limit=rate)
        assert limits == pytest.approx([expected], abs=5e-4)
        assert lower_bounds == pytest.approx(limits, rel=2e-4)


def program(tau_beta, load, h, mu=0.0, rho=np.inf):
    """The least peak by states at even nodes, in units of 1/p, B A and A.

    The attitude obeys x'' = x - w + v, v being straight between the nodes; at the end both are
    zero. The load is x - w - mu v.
    """
    n = round((tau_beta + 16.0) / h)
    t = h * np.arange(n + 1)
    w = np.interp(t, [0.0, tau_beta / 2.0, tau_beta], [0.0, 1.0, 0.0])
    ch, sh = np.cosh(h), np.sinh(h)
    step, late = np.array([[ch, sh], [sh, ch]]), np.array([(sh - h) / h, (ch - 1.0) / h])
    soon = np.array([ch - 1.0, sh]) - late
    one = sparse.identity(n + 1, format="csr")
    now, then, none = one[:-1], one[1:], sparse.csr_matrix((n, 1))
    rows, right = [], []
    for i in range(2):
        parts = [(i == j) * then - step[i, j] * now for j in range(2)]
        rows.append(sparse.hstack([*parts, -(soon[i] * now + late[i] * then), none]))
        right.append(-(soon[i] * w[:-1] + late[i] * w[1:]))
    ends = [0, n + 1, n, 2 * n + 1] + [2 * n + 2] * bool(np.isfinite(rho))
    rows.append(sparse.csr_matrix(np.eye(3 * n + 4)[ends]))
    right.append(np.zeros(len(ends)))
    still, bound = sparse.csr_matrix((n + 1, n + 1)), np.ones((n + 1, 1))
    felt = sparse.hstack([one, still, -mu * one, 0.0 * bound])
    below = [felt, -felt]
    below += [sparse.hstack([still, still, side * one, -bound]) for side in (1.0, -1.0)]
    most = [load + w, load - w, np.zeros(2 * n + 2)]
    if np.isfinite(rho):
        turning = sparse.hstack([0.0 * now, 0.0 * now, then - now, none])
        below, most = [*below, turning, -turning], [*most, np.full(2 * n, rho * h)]
    cost = np.append(np.zeros(3 * n + 3), 1.0)
    result = linprog(
        cost,
        sparse.vstack(below).tocsr(),
        np.concatenate(most),
        sparse.vstack(rows).tocsr(),
        np.concatenate(right),
        (None, None),
        method="highs-ipm",
    )
    assert result.status == 0
    return result.fun


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("options", "load", "tolerance"),
    usual(
        [
            ({}, 0.4, 1e-4),
            ({}, 0.25, 3e-4),
            ({"rho": 1.0}, 0.7, 1.5e-4),
            ({"mu": 0.3}, 0.6, 6e-4),
            ({"mu": 0.6}, 0.6, 6e-4),
        ],
        0,
    ),
)
def test_states_at_even_nodes_need_the_same(options, load, tolerance):
    """Theirs falls to the least with the step squared; what is proved is below it."""
    own = program(4.0, load, 0.02, **options)
    keys = {"rho": ("rate_limit", BETA * B * PEAK), "mu": ("moment_ratio", 1.0 / B)}
    ours = {keys[key][0]: keys[key][1] * value for key, value in options.items()}
    limits, lower_bounds = relative(FIXED, triangle(FIXED, 4.0), [load], **ours)
    assert lower_bounds[0] <= own * (1.0 + 1e-6)
    assert limits[0] == pytest.approx(own, rel=tolerance)
    assert lower_bounds[0] == pytest.approx(
        own, rel=tolerance + 1e-4
    )  # the gap that ends the search


@pytest.mark.thorough
def test_the_turning_floor_is_its_closed_form_where_nothing_else_binds():
    """A triangle of slope s = 2/tb: d = (a + s^2/a)/2, or (s sinh(tb/2) - a)/(cosh(tb/2) - 1)."""
    for tau_beta, load in ((2.0, 0.8), (4.0, 0.6), (8.0, 0.4), (8.0, 0.11)):
        slope, half = 2.0 / tau_beta, tau_beta / 2.0
        floor = (slope * np.sinh(half) - load) / (np.cosh(half) - 1.0)
        early = (load + slope**2 / load) / 2.0
        if early > max(slope, load) and np.arctanh(slope / early) < half:
            floor = max(floor, early)
        limits, _ = relative(FIXED, triangle(FIXED, tau_beta), [load])
        assert floor * (1.0 - 1e-4) <= limits[0] <= floor + 0.003


@pytest.mark.thorough
def test_the_front_ends_at_the_minimum_of_appendix_c_and_its_load():
    for plant in (FIXED, exact()):
        for tau_beta, load in ((4.0, 0.781), (8.0, 0.487)):
            wind = triangle(plant, tau_beta)
            front = load_trade_off(plant, wind, limit=0.1)
            minimum = tv.optimum_deflection(plant, wind).peak
            assert front.limits[-1] == pytest.approx(minimum, rel=1e-12)
            if plant is not FIXED:
                assert front.load_of_minimum / PEAK == pytest.approx(load, abs=5e-4)
            assert np.all(np.diff(front.limits) <= 1e-9)
            assert front.set_by[-1] == "the minimum angle"


@pytest.mark.thorough
def test_the_least_load_is_the_jump_of_the_wind():
    wind = triangle(FIXED, 4.0)
    assert load_trade_off(FIXED, wind, [0.05]).minimum_load == 0.0
    box = tv.RectangularWind(peak=-PEAK, duration=8.0)
    assert load_trade_off(FIXED, box, [0.1]).minimum_load == pytest.approx(PEAK)
    half = wind.before(4.0)  # it ends where it is largest
    front = load_trade_off(FIXED, half, [0.45 * PEAK, 0.55 * PEAK])
    assert front.minimum_load == pytest.approx(PEAK / 2.0)
    assert np.isinf(front.limits[0])
    assert np.isfinite(front.limits[1])
    impossible = load_trade_off(FIXED, half, limit=0.1, load=0.45 * PEAK)
    assert impossible.lower_bound == np.inf
    assert impossible.above_lower_bound is False


def flown_with_little_load(plant, M, most, wind, last):
    """Deflection and state at the end of a law that keeps to a load and damps what swings then."""
    A, inputs, _, _ = plant.matrices()
    gain = 3.0 * np.sign(inputs[1, 0] / M)

    def deflection(y, blows):
        return (np.clip(-gain * y[1], -most, most) - (y[0] - blows)) / M

    state, widest = np.zeros(2), 0.0
    for begin, end, blows in ((0.0, wind.duration, wind.peak), (wind.duration, last, 0.0)):

        def moves(_, y, blows=blows):
            return A @ y + inputs @ [deflection(y, blows), blows]

        solved = solve_ivp(moves, (begin, end), state, rtol=1e-8, atol=1e-12, max_step=0.1)
        widest = max(widest, np.abs(deflection(solved.y, blows)).max())
        state = solved.y[:, -1]
    return widest, state


@pytest.mark.thorough
def test_a_load_that_a_law_keeps_to_is_not_refused():
    """With M < 0 the law delta = (L - alpha)/M has the load L, of any size, and swings."""
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "fixed-path")
    wind, most = tv.RectangularWind(peak=np.radians(5.0), duration=7.5), np.radians(0.6)
    widest, state = flown_with_little_load(plant, -1.18, most, wind, 60.0)
    assert np.degrees(widest) == pytest.approx(4.346, abs=1e-3)
    assert np.abs(state).max() < 1e-5
    front = load_trade_off(plant, wind, [most], load=most, moment_ratio=-1.18)
    assert front.lower_bound <= widest
    assert front.lower_bound >= (float(wind.peak) - most) / 1.18  # what the jump at the onset takes
    assert front.minimum_load < most


@pytest.mark.thorough
def test_a_load_below_what_was_computed_and_above_what_is_proved_is_not_known():
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "fixed-path")
    wind, little = tv.RectangularWind(peak=np.radians(5.0), duration=7.5), np.radians(0.006)
    options = {"moment_ratio": -1.18, "load": little, "limit": np.radians(4.0)}
    front = load_trade_off(plant, wind, [little], **options)
    assert np.isinf(front.lower_bound)
    assert front.verdict.startswith("NOT KNOWN")


@pytest.mark.thorough
@pytest.mark.parametrize("plant", [FIXED, exact()])
def test_loads_far_below_the_peak_have_a_limit_too(plant):
    """It falls over the load, and what is not settled is said to be not known.

    On a fixed path not less than turning in time takes, (a + s^2/a)/2 for s = 2/(tau beta).
    """
    loads = np.array([0.04, 0.06, 0.1])
    wind, unit = triangle(plant, 4.0), plant.coefficients.B * PEAK
    limits, lower_bounds = relative(plant, wind, loads)
    assert np.all(np.isfinite(limits))
    assert np.all(np.diff(limits) < 0.0)
    assert np.all(lower_bounds <= limits)
    assert limits == pytest.approx(lower_bounds, rel=0.2)
    if plant is FIXED:
        assert np.all(limits >= (loads + 0.25 / loads) / 2.0)
    between = 0.5 * (limits[0] + lower_bounds[0]) * unit
    for limit, verdict in (
        (between, "NOT KNOWN: the lower bound is between"),
        (lower_bounds[0] * 0.9 * unit, "NOT SUFFICIENT"),
    ):
        front = load_trade_off(plant, wind, limit=limit, load=loads[0] * PEAK)
        assert front.verdict.startswith(verdict)


def test_without_a_forecast_half_of_the_peak_is_left():
    front = load_trade_off(FIXED, triangle(FIXED, 8.0), PEAK * np.array([0.4, 0.6]), limit=0.01)
    free = tv.forecast_free_limit(FIXED, triangle(FIXED, 8.0))
    assert front.no_forecast_load == pytest.approx(PEAK / 2.0)
    assert np.isinf(front.no_forecast_bounds[0])
    assert front.no_forecast_bounds[1] == pytest.approx(abs(free.deflection))
    assert "without a forecast" in " ".join(front.notes)


@pytest.mark.thorough
def test_the_nozzle_s_point_is_judged_in_both_directions():
    plant, wind = exact(), triangle(exact(), 4.0)
    unit = plant.coefficients.B * PEAK
    front = load_trade_off(plant, wind, limit=0.45 * unit, load=0.5 * PEAK)
    again = load_trade_off(plant, wind, [front.required_load])
    assert front.above_lower_bound is False
    assert front.remaining < 0.0
    assert front.remaining_load < 0.0
    assert again.limits[0] == pytest.approx(0.45 * unit, rel=3e-4)
    assert load_trade_off(plant, wind, limit=0.36 * unit).required_load == np.inf
    assert load_trade_off(plant, wind, limit=0.5 * unit, load=0.6 * PEAK).above_lower_bound is True


@pytest.mark.thorough
def test_a_wind_that_turns_has_no_bound_and_a_stable_vehicle_bears_its_load():
    wind = triangle(FIXED, 4.0)
    front = load_trade_off(FIXED, wind - 0.5 * wind.shift(8.0), [0.05])
    assert front.no_forecast_bounds is None
    assert np.isfinite(front.limits[0])
    still = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=-0.2, mu_delta=2.0), "fixed-path")
    front = load_trade_off(still, wind, [0.02, 0.5])
    assert front.limits[0] > front.limits[1] == 0.0
