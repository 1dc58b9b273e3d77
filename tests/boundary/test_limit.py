"""The boundary limit of any wind, against closed forms and against integrals of our own."""

import mpmath
import numpy as np
import pytest

import tvclin
from tests.turns import usual
from tvclin import Coefficients, InputError, Plant, boundary_limit, is_sufficient, survivable_peak
from tvclin.boundary.closed_forms import (
    rectangular_limit,
    triangular_limit,
    triangular_limit_with_drift,
)
from tvclin.boundary.limit import STABLE, leading_pole
from tvclin.boundary.open_loop import Reason, open_loop_requirements
from tvclin.linear.plant import MODELS

TAU_BETA = np.array([0.01, 0.03, 0.1, 0.3, 1.0, 2.0, 4.0, 8.0, 14.0, 20.0, 40.0])
DEAD_BANDS = np.array([0.0, 0.01, 0.25, 0.5, 0.9, 1.0])[:, np.newaxis]
BETA, B, DRIFT = 0.53, 0.107, {"b1": 0.0284, "b2": 0.0169}
TIME = np.array([0.0, 1.3, 2.1, 3.0, 4.4, 6.0, 7.7, 9.0])
GUST = np.array([0.0, 0.2, 0.15, 0.5, 1.0, 0.6, 0.75, 0.0])


def plant_of(model="fixed-path", **changes):
    numbers = {"beta": BETA, "B": B, "C1": 0.025, "C2": 0.0036, "q": 1.7e-4} | DRIFT | changes
    return Plant.from_coefficients(Coefficients.from_beta(**numbers), model)


def sampled(peak=0.08, time=TIME, angle=GUST):
    return tvclin.SampledWind(time=time, angle=peak * np.asarray(angle))


@pytest.mark.parametrize("switch", ["report", "literal"])
def test_rectangular_winds_have_the_limit_of_eq_7_and_with_drift_of_eq_16(switch):
    wind = tvclin.RectangularWind(peak=0.1, duration=TAU_BETA / BETA)
    K1 = (BETA + DRIFT["b2"]) / (BETA + DRIFT["b1"])
    fixed = boundary_limit(plant_of(), wind, 1.0, switch)
    drifting = boundary_limit(plant_of("drift"), wind, 0.0, switch)
    np.testing.assert_allclose(fixed.limit, rectangular_limit(TAU_BETA), rtol=1e-12)
    np.testing.assert_allclose(drifting.limit, rectangular_limit(TAU_BETA, K1), rtol=1e-12)
    assert np.all(fixed.switch_time == 0.0)


def test_triangular_winds_have_the_limit_of_eq_12():
    wind = tvclin.TriangularWind(peak=-0.1, duration=TAU_BETA / BETA)
    boundary = boundary_limit(plant_of(), wind, DEAD_BANDS)
    expected = triangular_limit(TAU_BETA, DEAD_BANDS)
    np.testing.assert_allclose(boundary.limit, expected, rtol=1e-12)
    np.testing.assert_allclose(
        boundary.switch_time, expected * DEAD_BANDS / 2 * TAU_BETA / BETA, rtol=1e-11
    )
    assert np.all(boundary.status == "ok")
    assert type(boundary_limit(plant_of(), sampled()).status) is str


def test_triangular_winds_with_drift_have_the_limit_of_eq_18():
    wind = tvclin.TriangularWind(peak=-0.1, duration=TAU_BETA / BETA)
    boundary = boundary_limit(plant_of("drift"), wind, DEAD_BANDS)
    expected = triangular_limit_with_drift(TAU_BETA, DEAD_BANDS, BETA, **DRIFT)
    np.testing.assert_allclose(boundary.limit, expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "limits"),
    [
        ("configuration_i", [0.65596, 0.53991, 0.37070]),
        ("configuration_ii", [0.64819, 0.53683, 0.37191]),
    ],
)
def test_the_exact_cubic_has_the_limits_computed_in_50_digits(name, limits, request):
    plant = Plant.from_vehicle(request.getfixturevalue(name), "drift-exact")
    wind = tvclin.TriangularWind(peak=0.1, duration=4.0 / plant.coefficients.beta)
    computed = boundary_limit(plant, wind, [1.0, 0.5, 0.0]).limit
    np.testing.assert_allclose(computed, limits, rtol=0, atol=5.1e-6)


@pytest.mark.parametrize(
    ("tau_beta", "limit", "half_digit"),
    [(4.0, 0.6649, 5e-5), (20.0, 0.8366, 5e-5), (40.0, 0.807, 5e-4)],
)
def test_a_literal_dead_band_needs_more_than_the_reports(
    configuration_i, tau_beta, limit, half_digit
):
    plant = Plant.from_vehicle(configuration_i, "drift")
    wind = tvclin.TriangularWind(peak=0.1, duration=tau_beta / plant.coefficients.beta)
    literal = boundary_limit(plant, wind, switch="literal").limit
    assert literal == pytest.approx(limit, abs=half_digit)
    assert literal > boundary_limit(plant, wind).limit


def trim_at(t, b1, b2):
    """The trim deflection over -B alpha_w,max of the gust: it passed (s + b2)/(s + b1)."""
    knots = [*TIME[t > TIME], t]
    drift = mpmath.quad(
        lambda r: mpmath.exp(-b1 * (t - r)) * np.interp(float(r), TIME, GUST), knots
    )
    return np.interp(float(t), TIME, GUST) - (b1 - b2) * drift


@pytest.mark.parametrize("dead_band", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("switch", ["report", "literal"])
@pytest.mark.parametrize("model", ["fixed-path", "drift"])
def test_the_limit_of_a_sampled_wind_satisfies_eq_4b(model, switch, dead_band):
    boundary = boundary_limit(plant_of(model), sampled(), dead_band, switch)
    b1, b2 = DRIFT.values() if model == "drift" else (0.0, 0.0)
    a = boundary.switch_time

    def integrand(t):
        """The wind at the pole; up to the switch also its trim, integrated by parts."""
        weight = BETA + b2
        if t < a:
            weight -= BETA + b1
            weight += (b1 - b2) * (1 - mpmath.exp(-(BETA + b1) * (a - t)))
        return weight * mpmath.exp(-BETA * t) * np.interp(float(t), TIME, GUST)

    to_come = mpmath.quad(integrand, sorted({*TIME, a}))
    expected = to_come * BETA * mpmath.exp(BETA * a) / (BETA + b1)
    assert boundary.limit == pytest.approx(float(expected), rel=1e-12)  # quad works in 15 digits
    if dead_band:
        level = trim_at(a, b1, b2) if switch == "literal" else np.interp(a, TIME, GUST)
        assert dead_band * boundary.limit == pytest.approx(float(level), rel=1e-12)
    else:
        assert a == 0.0


def test_without_dead_band_the_control_starts_with_the_wind_not_with_its_samples():
    wind = sampled(0.08, [0.0, 3.0, 4.0, 5.0, 9.0], [0.0, 0.0, 1.0, 0.0, 0.0])
    boundary = boundary_limit(plant_of(), wind, 0.0)
    assert boundary.switch_time == 3.0
    assert boundary.limit == pytest.approx(triangular_limit(2.0 * BETA, 0.0), rel=1e-12)


def excess(time, gust, dead_band, y):
    """What a limit y has above the demand of eq (4b) on a fixed path, exactly."""
    reached = gust >= dead_band * y
    if not np.any(reached):
        return y  # trimmed throughout
    i = max(int(np.argmax(reached)), 1)
    part = (dead_band * y - gust[i - 1]) / (gust[i] - gust[i - 1])
    a = time[i - 1] + part * (time[i] - time[i - 1])
    t, w = np.concatenate([[a], time[i:]]), np.concatenate([[dead_band * y], gust[i:]])
    x = BETA * np.diff(t)
    mean, slope = -np.expm1(-x), 1.0 - np.exp(-x) * (1.0 + x)
    pieces = w[:-1] * mean + np.diff(w) * slope / x
    return y - np.sum(np.exp(-BETA * (t[:-1] - a)) * pieces)


def assert_least_sufficient(time, gust, dead_band):
    """Every limit above the boundary limit covers the demand, and one just below does not."""
    boundary = boundary_limit(plant_of(), sampled(0.08, time, gust), dead_band)
    assert boundary.status == "ok"
    assert excess(time, gust, dead_band, boundary.limit) == pytest.approx(0.0, abs=1e-12)
    assert excess(time, gust, dead_band, boundary.limit * (1 - 1e-9)) < 0.0
    higher = np.linspace(boundary.limit * (1 + 1e-9), 0.999, 200)
    short = [y for y in higher if excess(time, gust, dead_band, y) < 0.0]
    assert short == [], (time.tolist(), gust.tolist(), dead_band, boundary.limit)


def test_of_two_peaks_the_one_that_needs_more_counts():
    time = np.array([0.0, 1.2, 2.0, 2.2, 3.8, 6.3])
    assert_least_sufficient(time, np.array([0.0, 0.003, 0.48, 0.011, 1.0, 0.0]), 1.0)
    assert_least_sufficient(time, np.array([0.0, 0.003, 1.0, 0.011, 0.8, 0.0]), 1.0)


def test_a_wind_of_two_steps_is_met_at_the_step_that_leaves_the_dead_band():
    second = tvclin.RectangularWind(peak=0.1, duration=4.0).shift(5.0)
    wind = tvclin.RectangularWind(peak=0.03, duration=5.0) + second
    late = boundary_limit(plant_of(), wind, 1.0)
    assert late.limit == pytest.approx(-np.expm1(-4.0 * BETA), rel=1e-12)
    assert late.switch_time == pytest.approx(5.0, abs=1e-12)
    early = boundary_limit(plant_of(), wind, 0.1)
    expected = -0.3 * np.expm1(-5.0 * BETA) - np.exp(-5.0 * BETA) * np.expm1(-4.0 * BETA)
    assert early.limit == pytest.approx(expected, rel=1e-12)
    assert early.switch_time == 0.0


def test_a_small_bump_long_before_the_gust_does_not_lower_the_limit():
    time, gust = np.array([0.0, 5.0, 10.0, 12.0, 14.0]), np.array([0.0, 0.004, 0.0, 1.0, 0.0])
    with_bump = boundary_limit(plant_of(), sampled(0.08, time, gust), 0.1)
    alone = boundary_limit(plant_of(), sampled(0.08, time[2:], gust[2:]), 0.1)
    assert with_bump.limit == pytest.approx(alone.limit, rel=1e-12)
    assert with_bump.switch_time == pytest.approx(alone.switch_time, rel=1e-12)


@pytest.mark.parametrize("dead_band", usual([0.05, 0.1, 0.3, 0.6, 1.0], 1))
def test_every_limit_above_that_of_a_random_wind_is_sufficient(dead_band):
    rng = np.random.default_rng(int(100 * dead_band))
    for _ in range(50):
        time = np.cumsum(rng.uniform(0.2, 4.0, rng.integers(4, 12)))
        gust = rng.uniform(0, 1, time.size) ** rng.choice([1, 3, 6])
        gust[[0, -1]] = 0.0
        assert_least_sufficient(time, gust / gust.max(), dead_band)


@pytest.mark.parametrize("dead_band", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("model", MODELS)
def test_a_late_start_only_moves_the_switch(model, dead_band):
    now = boundary_limit(plant_of(model), sampled(), dead_band)
    late = boundary_limit(plant_of(model), sampled().shift(300.0), dead_band)
    assert late.limit == pytest.approx(now.limit, rel=1e-12)
    assert late.switch_time == pytest.approx(now.switch_time + 300.0, abs=1e-10)


@pytest.mark.parametrize("model", MODELS)
def test_the_deflection_opposes_the_wind_and_the_limit_does_not_know_its_sign(model):
    tail, head = (boundary_limit(plant_of(model), sampled(peak)) for peak in (0.08, -0.08))
    assert tail.limit == pytest.approx(head.limit, rel=1e-14)
    assert head.deflection == pytest.approx(head.limit * B * 0.08, rel=1e-14)
    assert tail.deflection == pytest.approx(-head.deflection, rel=1e-14)


@pytest.mark.parametrize("dead_band", [0.0, 0.5, 1.0])
def test_effectors_ahead_of_the_centre_of_gravity_deflect_the_other_way(dead_band):
    wind = tvclin.TriangularWind(peak=0.1, duration=4.0 / BETA)
    fixed = boundary_limit(plant_of(B=-B), wind, dead_band)
    assert fixed.limit == pytest.approx(triangular_limit(4.0, dead_band), rel=1e-12)
    assert fixed.deflection == pytest.approx(fixed.limit * B * 0.1, rel=1e-14)
    drifting = boundary_limit(plant_of("drift", B=-B, b1=0.02), wind, dead_band)
    expected = triangular_limit_with_drift(4.0, dead_band, BETA, 0.02, DRIFT["b2"])
    assert drifting.limit == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("model", MODELS)
def test_a_batch_equals_a_loop(model):
    B_rows, peaks, bands = np.array([[0.1], [-0.2]]), np.array([0.1, -0.05, 0.02]), [1.0, 0.5, 0.0]
    batch = boundary_limit(plant_of(model, B=B_rows), sampled(peaks[:, np.newaxis]), bands)
    assert batch.limit.shape == batch.status.shape == (2, 3)
    for (i, j), limit in np.ndenumerate(batch.limit):
        single = boundary_limit(plant_of(model, B=B_rows[i, 0]), sampled(peaks[j]), bands[j])
        assert limit == pytest.approx(single.limit, rel=1e-13)
        assert batch.deflection[i, j] == pytest.approx(single.deflection, rel=1e-13)
        assert batch.switch_time[i, j] == pytest.approx(single.switch_time, rel=1e-12)
        assert batch.status[i, j] == single.status


@pytest.mark.parametrize("model", ["fixed-path", "drift"])
def test_a_stable_vehicle_needs_no_deflection_alone_or_in_a_batch(model):
    stable = Plant.from_coefficients(Coefficients(mu_alpha=-0.3, mu_delta=2.6, **DRIFT), model)
    boundary = boundary_limit(stable, sampled())
    assert (boundary.limit, boundary.deflection) == (0.0, 0.0)
    assert np.isnan(boundary.switch_time)
    assert boundary.status == STABLE
    assert is_sufficient(stable, sampled(), 1e-9) is True
    assert np.degrees(survivable_peak(stable, sampled(), 1e-9)) == pytest.approx(30.0)
    both = Coefficients(mu_alpha=[-0.3, BETA**2], mu_delta=[2.6, BETA**2 / B], **DRIFT)
    pair = boundary_limit(Plant.from_coefficients(both, model), sampled())
    assert pair.limit[0] == 0.0
    assert pair.limit[1] == pytest.approx(
        boundary_limit(plant_of(model), sampled()).limit, rel=1e-14
    )


@pytest.mark.parametrize("model", MODELS)
def test_sufficient_is_at_or_above_the_boundary_of_a_flight_in_either_sign(model):
    plant, wind = plant_of(model), sampled()
    needed = boundary_limit(plant, wind, 0.5, "literal").deflection
    assert is_sufficient(plant, wind, needed, 0.5) is True
    assert is_sufficient(plant, wind, -1.000001 * needed, 0.5) is True
    assert is_sufficient(plant, wind, 1.000001 * needed) is False  # without a dead band of 0.5
    assert is_sufficient(plant, wind, 0.999999 * needed, 0.5) is False
    assert is_sufficient(plant, wind, [0.9 * needed, needed], 0.5).tolist() == [False, True]


@pytest.mark.parametrize("peak", [0.08, -0.08])
def test_the_survivable_peak_is_the_one_whose_boundary_is_the_given_limit(peak):
    plant = plant_of("drift")
    largest = survivable_peak(plant, sampled(peak), 0.005, 0.5)
    assert np.sign(largest) == np.sign(peak)
    needed = boundary_limit(plant, sampled(largest), 0.5, "literal").deflection
    assert abs(needed) == pytest.approx(0.005, rel=1e-13)
    assert survivable_peak(plant, sampled(peak), -0.005, 0.5) == largest


@pytest.mark.parametrize(
    ("wind", "message"),
    [
        (sampled(angle=GUST - 0.5), "wind must not change its sign .* -0.04 to 0.04 rad$"),
        (sampled(angle=[GUST, GUST - 0.5]), "wind must not change its sign .* -0.04 to 0.08 rad$"),
        (tvclin.linear.ConstantDeflection(limit=0.05), "wind must end"),
        (sampled() + tvclin.linear.ConstantDeflection(limit=0.05) * [0.0, 1.0], "wind must end"),
        (0.0 * sampled(), "wind must differ from zero"),
        (sampled() * [0.0, 1.0], "wind must differ from zero"),
    ],
)
def test_winds_that_have_no_boundary_limit_are_refused_alone_or_in_a_batch(wind, message):
    with pytest.raises(InputError, match=f"^{message}"):
        boundary_limit(plant_of(), wind)


@pytest.mark.parametrize("peak", [0.08, -0.08])
def test_a_wind_may_cross_zero_by_rounding_and_no_more(peak):
    crossing = [np.where(TIME == TIME[-2], -part, GUST) for part in (1e-14, 1e-10)]
    assert boundary_limit(plant_of(), sampled(peak, angle=crossing[0])).status == "ok"
    with pytest.raises(InputError, match="^wind must not change its sign"):
        boundary_limit(plant_of(), sampled(peak, angle=crossing[1]))


def test_vehicles_with_more_and_fewer_unstable_poles_stand_in_one_batch():
    numbers = {"mu_alpha": [0.3, 0.3, -0.4], "C1": [0.025, 0.2, 1.0], "C2": [0.004, -0.1, 0.076]}
    wind, limits = sampled(), []
    for row in range(3):
        one = Coefficients(mu_delta=2.6, **DRIFT, **{k: v[row] for k, v in numbers.items()})
        plant = Plant.from_coefficients(one, "drift-exact")
        assert tvclin.unstable_modes(plant).poles.size == (2, 1, 0)[row]
        limits.append(boundary_limit(plant, wind).limit)
    batch = Plant.from_coefficients(Coefficients(mu_delta=2.6, **DRIFT, **numbers), "drift-exact")
    np.testing.assert_allclose(boundary_limit(batch, wind).limit, limits, rtol=1e-12)
    assert limits[2] == 0.0 < limits[1] != limits[0]


def test_a_batch_of_stable_vehicles_needs_no_deflection():
    stable = Plant(Coefficients(mu_alpha=[-0.3, -0.2], mu_delta=2.6), "fixed-path")
    boundary = boundary_limit(stable, sampled())
    assert boundary.limit.tolist() == boundary.deflection.tolist() == [0.0, 0.0]
    rate, paired = leading_pole(stable)
    assert np.isnan(rate).tolist() == [True, True]
    assert paired.tolist() == [False, False]


@pytest.mark.parametrize("bad", [-1e-9, 1.000001, np.nan, "all"], ids=repr)
def test_a_dead_band_outside_zero_to_one_is_refused(bad):
    for call in (
        boundary_limit,
        lambda *given: is_sufficient(*given[:2], 0.01, given[2]),
        lambda *given: survivable_peak(*given[:2], 0.01, given[2]),
    ):
        with pytest.raises(InputError, match="^dead_band must be"):
            call(plant_of(), sampled(), bad)


def test_unknown_switches_and_limits_of_zero_are_refused():
    with pytest.raises(InputError, match=r"switch must be one of .* 'literal'"):
        boundary_limit(plant_of(), sampled(), switch="litteral")
    for call in (is_sufficient, survivable_peak):
        with pytest.raises(InputError, match="^limit must be other than zero"):
            call(plant_of(), sampled(), 0.0)


def test_shapes_that_do_not_broadcast_are_refused():
    with pytest.raises(InputError, match="broadcast"):
        boundary_limit(plant_of(B=[0.1, 0.2]), sampled(), [0.0, 0.5, 1.0])


def test_a_jump_to_a_new_height_after_a_calm_is_not_overlooked():
    plant = tvclin.Plant(tvclin.Coefficients.from_beta(beta=3.0, B=0.1), "fixed-path")
    first = tvclin.RectangularWind(peak=0.15, duration=2.0)
    wind = first + tvclin.RectangularWind(peak=0.29, duration=3.4).shift(2.7)

    assert boundary_limit(plant, wind, 0.8).limit == pytest.approx(1.0 - np.exp(-10.2), rel=1e-12)
    assert not is_sufficient(plant, wind, 0.9 * 0.1 * 0.29, 0.8)


@pytest.mark.parametrize(
    ("b2", "most"),
    # With b1 = 0 trim is B (w + b2 int w): largest as the wind peaks, or where b2 w = -w' later.
    [(0.02, 1.0 + 0.02 * 15.0), (0.1, 1.0 / 3.0 + 0.1 * (15.0 + 40.0 / 3.0))],
)
def test_where_trim_never_saturates_the_limit_is_the_largest_trim(b2, most):
    drifting = Coefficients.from_beta(beta=0.5, B=0.1, b1=0.0, b2=b2)
    plant = Plant.from_coefficients(drifting, "drift")
    boundary = boundary_limit(plant, tvclin.TriangularWind(peak=0.1, duration=60.0))
    assert boundary.status.startswith("trim never saturates")
    assert np.isnan(boundary.switch_time)
    assert boundary.limit == pytest.approx(most, rel=1e-12)
    assert boundary.deflection == pytest.approx(-most * 0.1 * 0.1, rel=1e-12)
    ordinary = tvclin.TriangularWind(peak=0.1, duration=[60.0, 4.0])
    both = boundary_limit(plant, ordinary, [1.0, 0.5])
    assert both.status.tolist() == [boundary.status, "ok"]
    assert both.limit[0] == pytest.approx(most, rel=1e-12)


def test_where_the_demand_jumps_every_limit_above_the_first_pulse_is_sufficient():
    plant = Plant.from_coefficients(
        Coefficients.from_beta(beta=0.5, B=0.1, b1=0.1, b2=0.4), "drift"
    )
    second = tvclin.RectangularWind(peak=0.06, duration=0.5).shift(40.0)
    wind = tvclin.RectangularWind(peak=0.05, duration=20.0) + second
    boundary = boundary_limit(plant, wind, [1.0, 0.0])
    # Held from the first pulse on, more than its height is needed, for trim rises in it; a limit
    # above that height trims it all, and the short second pulse needs less.
    assert boundary.limit[0] == pytest.approx(5.0 / 6.0, rel=1e-12)
    assert [status.split(":")[0] for status in boundary.status] == [
        "no limit satisfies (4b) exactly",
        "ok",
    ]
    for part, sign in ((1.0 - 1e-9, -1.0), (1.0 + 1e-9, 1.0)):
        constant = tvclin.trim_then_hold(
            plant, wind, limit=part * boundary.deflection[0], dead_band=1.0
        )
        over = (
            tvclin.residues(plant, constant, wind)[0]
            / tvclin.residues(plant, constant, 0.0 * wind)[0]
        )
        assert np.sign(over) == sign


@pytest.mark.parametrize(
    ("poles", "rate", "paired"),
    [
        ([1.0, 0.051 + 0.3j, 0.051 - 0.3j], 1.0, True),
        ([1.0, 0.049 + 0.3j, 0.049 - 0.3j], 1.0, False),
        ([0.02, 0.5 + 0.3j, 0.5 - 0.3j], 0.5, True),
        ([-1.0, 0.5 + 0.3j, 0.5 - 0.3j], 0.5, True),
        ([1.0, 1.0 - 0.9e-4, -2.0], 1.0, True),
        ([1.0, 1.0 - 1.1e-4, -2.0], 1.0, False),
        ([0.5, 0.5 * (1.0 - 0.9e-4), -2.0], 0.5, True),
        ([0.5, 0.5 * (1.0 - 1.1e-4), -2.0], 0.5, False),
        ([1.0, 0.2, 0.1], 1.0, False),
        ([0.2, -0.1 + 0.3j, -0.1 - 0.3j], 0.2, False),
        ([-1.0, -0.1 + 0.3j, -0.1 - 0.3j], np.nan, False),
    ],
)
def test_a_pair_counts_from_a_twentieth_of_the_rate_and_real_poles_that_are_together(
    poles, rate, paired
):
    _, C1, stiffness, C2 = np.real(np.poly(poles))
    c = Coefficients(mu_alpha=-stiffness, mu_delta=2.0, C1=C1, C2=C2)
    result = leading_pole(Plant.from_coefficients(c, "drift-exact"))
    np.testing.assert_allclose(result[0], rate, rtol=1e-10)
    assert result[1] == paired


def test_where_a_pair_counts_the_limit_is_the_largest_trim_over_the_dead_band():
    # (s - 0.3)(s^2 - 0.4 s + 0.2), with q = 0: trim is the wind after (s + b2)/(s + b1)
    c = Coefficients(mu_alpha=-0.32, mu_delta=-2.0, C1=-0.7, C2=-0.06, **DRIFT)
    plant = Plant.from_coefficients(c, "drift-exact")
    boundary = boundary_limit(plant, sampled(-0.08), [1.0, 0.4, 0.0], "literal")
    trims = [float(trim_at(t, *DRIFT.values())) for t in TIME]  # between them trim has no extreme
    assert max(trims) < 1.0 == GUST.max()
    expected = [max(trims), max(trims) / 0.4, np.inf]
    np.testing.assert_allclose(boundary.limit, expected, rtol=1e-12)
    np.testing.assert_allclose(boundary.deflection, boundary.limit * c.B * 0.08, rtol=1e-12)
    assert np.all(np.isnan(boundary.switch_time))
    assert all(status.startswith("two unstable poles are a pair") for status in boundary.status)


@pytest.mark.parametrize("peak", [0.08, -0.08])
def test_each_need_is_the_size_of_what_its_own_question_answers(configuration_i, peak):
    plant = Plant.from_vehicle(configuration_i, "drift-exact")
    wind, K = tvclin.TriangularWind(peak=peak, duration=60.0), np.array([0.5, 1.0])
    boundary = boundary_limit(plant, wind, K, "literal")
    needs = open_loop_requirements(plant, wind, K, boundary)
    bound = abs(tvclin.forecast_free_limit(plant, wind).deflection)
    minimum = tvclin.optimum_deflection(plant, wind).peak
    np.testing.assert_array_equal(needs[Reason.BOUNDARY], np.abs(boundary.deflection))
    np.testing.assert_array_equal(needs[Reason.NO_FORECAST], [0.0, bound])
    np.testing.assert_allclose(needs[Reason.MINIMUM], [minimum, minimum], rtol=1e-9)
    assert needs[Reason.AFTER_TRIM][0] > max(
        needs[name][0] for name in (Reason.BOUNDARY, Reason.MINIMUM)
    )
    assert needs[Reason.AFTER_TRIM][1] == 0.0


def test_a_path_that_grows_without_an_aerodynamic_moment_has_no_limit_over_trim():
    wind = tvclin.TriangularWind(peak=0.05, duration=6.0)
    calm = Coefficients(mu_alpha=0.0, mu_delta=2.0, C1=0.1, q=0.01)  # s (s^2 + C1 s + q)
    assert boundary_limit(Plant.from_coefficients(calm, "drift-exact"), wind).limit == 0.0
    for mu_alpha in (0.0, [0.25, 0.0]):
        growing = Plant.from_coefficients(calm.replace(mu_alpha=mu_alpha, C1=-0.1), "drift-exact")
        with pytest.raises(InputError, match=r"^plant must have an aerodynamic moment, mu_alpha"):
            boundary_limit(growing, wind)


def test_a_table_has_a_row_for_each_place_and_a_column_for_each_dead_band():
    durations, dead_bands = np.array([5.0, 10.0]), np.array([0.0, 0.5, 1.0])
    wind = tvclin.TriangularWind(peak=0.05, duration=durations[:, np.newaxis])
    boundary = boundary_limit(plant_of(), wind, dead_bands)
    table = boundary.table("y", "tau [s]", durations, dead_bands)
    assert table.head == ("tau [s]", "K = 0", "K = 0.5", "K = 1")
    shown = [[number.value for (number,) in row] for row in table.rows]
    np.testing.assert_array_equal(shown, np.column_stack([durations, boundary.limit]))


@pytest.mark.parametrize("model", MODELS)
def test_trim_throughout_needs_the_bound_without_a_forecast_on_every_model(configuration_i, model):
    plant, wind = Plant.from_vehicle(configuration_i, model), sampled()
    boundary = boundary_limit(plant, wind, 1.0, "literal")
    needs = open_loop_requirements(plant, wind, 1.0, boundary)
    assert needs[Reason.NO_FORECAST] == abs(tvclin.forecast_free_limit(plant, wind).deflection)
