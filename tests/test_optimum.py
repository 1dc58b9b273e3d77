"""The minimum-peak control against the tables, a linear program and mpmath of our own."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

import tvclin
from tvclin import Coefficients, InputError, Plant, TriangularWind, optimum_deflection
from tvclin.optimum import (
    early_switch,
    late_switch,
    longest_single_pole_duration,
    neglecting_the_fast_pole,
    single_pole_validity,
    switch_variable,
    switching_ratio,
)
from tvclin.optimum.constraints import Constraints
from tvclin.optimum.dual import best_multipliers
from tvclin.optimum.exponential_sums import Window
from tvclin.optimum.minimum_peak import NOT_CONVERGED, STABLE, UNTOUCHED, certify
from tvclin.optimum.two_poles import switch_time

NAMES = ("configuration-i", "configuration-ii")
MODELS = ("fixed-path", "drift", "drift-exact", "drift-and-speed")


def plant_of(name="configuration-i", model="drift-exact"):
    return Plant.from_vehicle(tvclin.load_vehicle(name), model)


def triangle(plant, tau_beta, peak=-0.1):
    return TriangularWind(peak=peak, duration=tau_beta / plant.coefficients.beta)


def scaled_peak(plant, tau_beta):
    wind = triangle(plant, tau_beta)
    return optimum_deflection(plant, wind).peak / abs(plant.coefficients.B * wind.peak)


def solved(poles, demands, horizon=np.inf):
    """Return limit, switches and certificate of bare conditions, without a plant."""
    window = Window(Constraints(np.asarray(poles), np.asarray(demands, float), horizon))
    best = best_multipliers(window)
    return best, certify(window, best.multipliers, best.zeros, best.norm * best.signs[0])


@pytest.mark.parametrize("tau_beta", [0.1, 1.0, 4.0, 20.0])
def test_on_a_fixed_path_it_is_the_boundary_without_a_dead_band(tau_beta):
    plant = plant_of(model="fixed-path")
    limit = tvclin.boundary_limit(plant, triangle(plant, tau_beta), dead_band=0.0).limit
    assert limit == pytest.approx(scaled_peak(plant, tau_beta), rel=1e-13)
    if tau_beta == 4.0:
        assert scaled_peak(plant, tau_beta) == pytest.approx(0.3738, abs=5e-5)


TABLE = [
    ("configuration-i", 2, 0.3885267, 1, 57.43),
    ("configuration-i", 4, 0.3706964, 1, 61.26),
    ("configuration-i", 8, 0.2431881, 1, 77.52),
    ("configuration-i", 14, 0.1446964, 1, 152.0),
    ("configuration-i", 20, 0.1390519, -1, 0.284),
    ("configuration-i", 40, 0.2252857, -1, 0.960),
    ("configuration-ii", 2, 0.3857364, 1, 76.24),
    ("configuration-ii", 4, 0.3719132, 1, 81.80),
    ("configuration-ii", 8, 0.2463739, 1, 105.5),
    ("configuration-ii", 14, 0.1470409, 1, 225.3),
    ("configuration-ii", 20, 0.1535162, -1, 0.479),
    ("configuration-ii", 40, 0.2478409, -1, 1.348),
]


@pytest.mark.parametrize(("name", "tau_beta", "peak", "sign", "switch"), TABLE)
def test_exact_third_order_in_triangular_winds(name, tau_beta, peak, sign, switch):
    plant = plant_of(name)
    wind = triangle(plant, tau_beta)
    best = optimum_deflection(plant, wind)
    first = best.deflection(0.0) / -(plant.coefficients.B * wind.peak)
    assert first == pytest.approx(sign * peak, abs=1e-7)
    assert best.switch_times == pytest.approx([switch], rel=2e-3)
    assert tvclin.judge(plant, best.deflection, wind).stable


@pytest.mark.parametrize(
    ("name", "tau_beta", "peak"),
    [
        ("configuration-i", 4, 0.3706964),
        ("configuration-i", 14, 0.1446964),
        ("configuration-i", 20, 0.114),
        ("configuration-i", 40, 0.192),
        ("configuration-ii", 4, 0.3719132),
        ("configuration-ii", 14, 0.1470409),
        ("configuration-ii", 20, 0.125),
        ("configuration-ii", 40, 0.210),
    ],
)
def test_fourth_order_with_its_complex_pair(name, tau_beta, peak):
    assert scaled_peak(plant_of(name, "drift-and-speed"), tau_beta) == pytest.approx(peak, abs=1e-3)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("horizon", [None, 90.0, 400.0])
def test_every_result_proves_itself(name, model, horizon):
    plant = plant_of(name, model)
    for wind in (
        triangle(plant, 3.0),
        triangle(plant, 17.0),
        triangle(plant, 35.0, peak=0.05),
        tvclin.RectangularWind(peak=0.02, duration=6.0),
        triangle(plant, 4.0) + triangle(plant, 6.0, peak=0.08).shift(20.0),
    ):
        for start in (-2.0, 0.0, 1.5):
            best = optimum_deflection(plant, wind, start, horizon)
            proof = best.certificate
            assert best.status == "ok"
            assert abs(proof.gap) < 1e-12
            assert proof.residual < 1e-14
            assert proof.tail <= (1e-12 if model == "drift-and-speed" and not horizon else 0.0)
            assert proof.primal == best.peak == abs(float(best.deflection.peak))
            assert tvclin.judge(plant, best.deflection, wind).stable
            assert best.deflection.onset == start
            if horizon is not None:
                assert best.deflection.end == horizon


def test_multipliers_are_the_price_of_the_demands():
    plant = plant_of()
    wind, step = triangle(plant, 20.0), 1e-6
    best = optimum_deflection(plant, wind)
    poles = tvclin.unstable_modes(plant).poles
    demands = -np.array([-best.deflection.laplace(pole) for pole in poles])
    assert best.multipliers @ demands == pytest.approx(best.peak, rel=1e-12)
    for i in range(2):
        changed = demands + step * abs(demands[i]) * np.eye(2)[i]
        price = (solved(poles, changed)[1].primal - best.peak) / (step * abs(demands[i]))
        assert price == pytest.approx(best.multipliers[i], rel=1e-4)


@pytest.mark.parametrize("name", NAMES)
def test_it_is_never_below_what_any_single_pole_asks_for(name):
    plant = plant_of(name)
    modes = tvclin.unstable_modes(plant)
    for tau_beta in (1.0, 10.0, 16.5, 17.0, 30.0):
        wind = triangle(plant, tau_beta)
        demands = -modes.wind_residues / modes.deflection_residues * wind.laplace(modes.poles)
        best = optimum_deflection(plant, wind)
        assert best.peak >= (np.abs(modes.poles * demands)).max() * (1.0 - 1e-14)


def test_a_late_start_costs_and_an_early_one_gains_a_factor():
    plant = plant_of(model="drift")
    wind, beta = triangle(plant, 4.0), plant.coefficients.beta
    peaks = [optimum_deflection(plant, wind, start).peak for start in (-3.0, 0.0, 3.0, 20.0)]
    np.testing.assert_allclose(np.array(peaks) / peaks[1], np.exp(beta * np.array([-3, 0, 3, 20])))


def test_a_finite_horizon_costs_little_and_less_the_later_it_is():
    plant = plant_of(model="fixed-path")
    wind, beta = triangle(plant, 4.0), plant.coefficients.beta
    for horizon in (8.0, 12.0, 100.0):
        ratio = optimum_deflection(plant, wind, 0.0, horizon).peak
        ratio /= optimum_deflection(plant, wind).peak
        assert ratio == pytest.approx(1.0 / -np.expm1(-beta * horizon), rel=1e-13)
    exact = plant_of()
    wind = triangle(exact, 20.0)
    peaks = [optimum_deflection(exact, wind, 0.0, h).peak for h in (40.0, 60.0, 200.0, None)]
    assert np.all(np.diff(peaks) < 0.0)


# ---- two real poles ------------------------------------------------------------------------


def precise_pair(poles, demands):
    """Solve eqs (C5) in 60 digits by bisection: the peak and the switch."""
    with mpmath.workdps(60):
        p, d = [mpmath.mpf(float(x)) for x in poles], [mpmath.mpf(float(x)) for x in demands]
        c = [a * b for a, b in zip(p, d, strict=True)]

        def excess(t):
            return c[0] * (1 - 2 * mpmath.exp(-p[1] * t)) - c[1] * (1 - 2 * mpmath.exp(-p[0] * t))

        low, high = mpmath.mpf(0), 200 / min(p)
        side = mpmath.sign(excess(low))
        for _ in range(240):
            middle = (low + high) / 2
            if mpmath.sign(excess(middle)) == side:
                low = middle
            else:
                high = middle
        wide = max(range(2), key=lambda i: abs(1 - 2 * mpmath.exp(-p[i] * low)))
        return abs(c[wide] / (1 - 2 * mpmath.exp(-p[wide] * low))), low


def pairs(count):
    """Pairs of poles and demands: near and far poles, both signs, either one dominant."""
    rng = np.random.default_rng(20)
    slow = 10.0 ** rng.uniform(-3, 0, count)
    fast = slow * 10.0 ** rng.uniform(0.05, 3, count)
    poles = np.stack([slow, fast], axis=-1)
    demands = rng.choice([-1.0, 1.0], (count, 2)) * 10.0 ** rng.uniform(-2, 2, (count, 2)) / poles
    demands[::5, 0] = demands[::5, 1] * poles[::5, 1] / poles[::5, 0]  # y near 1
    demands[::5, 0] *= 1.0 + rng.choice([-1, 1], len(demands[::5])) * 10.0 ** -rng.uniform(
        1, 12, len(demands[::5])
    )
    flipped = rng.random(count) < 0.5
    poles[flipped], demands[flipped] = poles[flipped, ::-1], demands[flipped, ::-1]
    return list(zip(poles, demands, strict=True))


def test_two_poles_agree_with_sixty_digits():
    for poles, demands in pairs(200):
        peak, switch = precise_pair(poles, demands)
        found = switch_time(tuple(poles), tuple(demands))
        shares = 1.0 - 2.0 * np.exp(-poles * found)
        i = int(np.argmax(np.abs(shares)))
        assert abs(poles[i] * demands[i] / shares[i]) == pytest.approx(float(peak), rel=1e-11)
        if poles.min() * found < 10.0 and found > 1e-3 / poles.max():
            assert found == pytest.approx(float(switch), rel=1e-10)


def test_the_dual_finds_the_same_for_two_poles():
    for poles, demands in pairs(60):
        best, proof = solved(poles, demands)
        peak, _ = precise_pair(poles, demands)
        assert proof.primal == pytest.approx(float(peak), rel=1e-9)
        assert proof.dual <= float(peak) * (1.0 + 1e-9)
        assert best.zeros.size <= 1


def test_at_y_of_one_the_switch_is_never_or_at_once():
    assert switch_time((1.0, 2.0), (2.0, 1.0)) == np.inf
    before = switch_time((0.01, 0.5), (50.0 * (1.0 - 1e-9), 1.0))
    after = switch_time((0.01, 0.5), (50.0 * (1.0 + 1e-9), 1.0))
    assert before > 1000.0
    assert 0.0 < after < 1e-7
    assert switch_time((0.01, 0.5), (0.0, 1.0)) == pytest.approx(np.log(2.0) / 0.01)
    assert switch_time((0.01, 0.5), (1.0, 0.0)) == pytest.approx(np.log(2.0) / 0.5)


@given(y=st.floats(-50.0, 50.0), ratio=st.floats(1e-3, 0.95))
def test_the_switch_variable_solves_eq_c6(y, ratio):
    x = switch_variable(y, ratio)
    assert 0.0 <= x <= 1.0
    if x < 1e-290:  # too late a switch for x to be written down
        assert -1.0 < y <= 1.0
        return
    assert 2.0 * x**ratio - 2.0 * x * y == pytest.approx(1.0 - y, abs=1e-12 * (1.0 + abs(y)))


def test_approximations_of_the_switch():
    for y, error in ((0.01, 1.8e-4), (0.1, 7.6e-4)):
        shares = [1.0 - 2.0 * x for x in (switch_variable(y, 0.1), late_switch(y, 0.1))]
        assert abs(shares[1] / shares[0] - 1.0) < 2.0 * error
    assert late_switch(0.0, 0.1) == pytest.approx(0.5**10)
    assert switch_variable(10.0, 0.1) == pytest.approx(0.54410, abs=5e-6)
    assert early_switch(10.0, 0.1) == pytest.approx(0.5433, abs=5e-5)
    large = switch_variable(1e6, 0.1)
    assert 1.0 - 2.0 * large**0.1 == pytest.approx(1.0 - 2.0 * early_switch(1e6, 0.1) ** 0.1)
    assert abs(1.0 / (1.0 - 2.0 * large**0.1)) == pytest.approx(1.0 / (2.0**0.9 - 1.0), rel=1e-4)


def test_the_duration_up_to_which_one_pole_decides():
    for name, tau, tau_beta in (("configuration-i", 31.8, 16.8), ("configuration-ii", 40.7, 16.1)):
        coefficients = Coefficients.from_vehicle(tvclin.load_vehicle(name))
        found = single_pole_validity(coefficients)
        assert found == pytest.approx(tau, abs=0.05)
        assert found * coefficients.beta == pytest.approx(tau_beta, abs=0.05)
    printed = longest_single_pole_duration(0.01, 0.5)
    assert printed == pytest.approx(30.479, abs=5e-4)
    assert neglecting_the_fast_pole(0.01, 0.5) == pytest.approx(30.495, abs=5e-4)
    assert printed * 0.5 == pytest.approx(15.2, abs=0.05)
    assert switching_ratio(printed, 0.01, 0.5) == pytest.approx(1.0, rel=1e-13)
    assert np.isnan(longest_single_pole_duration(0.5, 0.5))
    many = longest_single_pole_duration(np.array([[0.01], [0.02]]), 0.5, [1.0, 0.7, 0.001])
    assert many.shape == (2, 3)
    assert np.all(np.isnan(many[:, 2]))


def test_the_switching_ratio_is_that_of_the_demands():
    for name in NAMES:
        plant = plant_of(name)
        modes = tvclin.unstable_modes(plant)
        fast, slow = modes.poles
        K = -modes.wind_residues / modes.deflection_residues
        for tau in (1.0, 30.0, 100.0):
            terms = modes.poles * K * TriangularWind(peak=1.0, duration=tau).laplace(modes.poles)
            y = switching_ratio(tau, slow, fast, K[1] / K[0])
            assert y == pytest.approx(terms[1] / terms[0], rel=1e-12)
        wind = TriangularWind(peak=-0.1, duration=single_pole_validity(plant.coefficients))
        best = optimum_deflection(plant, wind)
        alone = fast * -K[0] * wind.laplace(fast)
        assert best.peak == pytest.approx(abs(alone), rel=1e-11)


def test_validity_of_batches_and_of_stable_vehicles():
    both = Coefficients.from_beta(
        beta=[0.53, 0.4], B=0.1, C1=[0.025, 0.034], C2=[0.0036, 0.0015], b1=0.03, b2=0.02
    )
    assert single_pole_validity(both).shape == (2,)
    stable = Coefficients(mu_alpha=-0.2, mu_delta=1.0, C1=0.02, C2=0.003, b1=0.03, b2=0.02)
    assert np.isnan(single_pole_validity(stable))
    assert np.isnan(single_pole_validity(Coefficients.from_beta(beta=0.5, B=0.1)))


# ---- any number of poles -------------------------------------------------------------------


def scaled_grid_peak(constraints, cells=4000):
    """An independent linear program: largest share of the demands that |v_j| <= 1 can meet."""
    last = min(constraints.horizon, 18.0 / constraints.decays.min())
    edges = np.linspace(0.0, last ** (1.0 / 3.0), cells + 1) ** 3
    middle, width = (edges[1:] + edges[:-1]) / 2.0, np.diff(edges)
    rows = []
    for pole in constraints.poles:
        values = np.exp(-pole * middle) * width
        rows += [values.real] if pole.imag == 0.0 else [values.real, -values.imag]
    sizes = np.abs(rows).sum(axis=1)
    matrix = np.column_stack([rows, -constraints.demands]) / sizes[:, None]
    bounds = [*[(-1.0, 1.0)] * cells, (0.0, None)]
    found = linprog(
        np.append(np.zeros(cells), -1.0), A_eq=matrix, b_eq=np.zeros(len(rows)), bounds=bounds
    )
    assert found.status == 0
    return 1.0 / found.x[-1]


def cases(count):
    """Conditions with one to three unknown signs: real poles, pairs, finite and no horizon."""
    rng = np.random.default_rng(5)
    for i in range(count):
        p = np.sort(10.0 ** rng.uniform(-1.3, 0.5, 3))[::-1]
        pair = p[2] + 1j * p[2] * rng.uniform(0.3, 4.0)
        poles = [p[:1], p[:2], p, np.array([p[0], pair]), np.array([pair])][i % 5]
        count = sum(1 if np.imag(pole) == 0.0 else 2 for pole in poles)
        decays = np.concatenate([[q.real] * (1 if q.imag == 0.0 else 2) for q in poles])
        horizon = np.inf if i % 2 else rng.uniform(1.0, 4.0) / p[-1]
        yield Constraints(poles, rng.normal(size=count) / decays, horizon)


def test_a_hundred_random_cases_against_a_linear_program():
    for constraints in cases(120):
        window = Window(constraints)
        best = best_multipliers(window)
        proof = certify(window, best.multipliers, best.zeros, best.norm * best.signs[0])
        assert abs(proof.gap) < 1e-10
        assert proof.residual < 1e-12
        assert proof.primal == pytest.approx(scaled_grid_peak(constraints), rel=2e-3)


def test_three_real_poles_far_apart_need_no_special_care():
    """A steep flight: the pair of the fourth-order model splits into two slow real poles."""
    best, proof = solved([0.5, 0.011, 0.002], [0.8, 30.0, 90.0])
    assert best.zeros.size == 2
    assert abs(proof.gap) < 1e-13
    assert proof.residual < 1e-14
    best, proof = solved([5.0, 0.01 + 0.2j], [0.005, 0.006, 0.0001])
    assert abs(proof.gap) < 1e-12
    assert proof.residual < 1e-14
    assert proof.tail < 1e-12


@pytest.mark.parametrize("angle", [64.0, 75.0, 85.0])
def test_steep_flight_with_three_real_unstable_poles(angle):
    vehicle = tvclin.load_vehicle(NAMES[0]).replace(attitude=np.radians(angle))
    plant = Plant.from_vehicle(vehicle, "drift-and-speed")
    poles = tvclin.unstable_modes(plant).poles
    assert poles.shape == (3,)
    assert np.isrealobj(poles)
    for tau_beta in (2.0, 8.0, 20.0, 40.0):
        wind = triangle(plant, tau_beta)
        best = optimum_deflection(plant, wind)
        assert best.status == "ok"
        assert abs(best.certificate.gap) < 1e-11
        assert best.switch_times.size <= 2
        assert tvclin.judge(plant, best.deflection, wind).stable


def test_a_result_that_did_not_converge_says_so(monkeypatch):
    plant = plant_of(model="drift-and-speed")
    monkeypatch.setattr("tvclin.optimum.dual._NEWTON_STEPS", 0)
    monkeypatch.setattr("tvclin.optimum.dual._ROUNDS", 1)
    best = optimum_deflection(plant, triangle(plant, 20.0))
    assert best.status == NOT_CONVERGED
    assert best.certificate.gap > 1e-9


# ---- properties ----------------------------------------------------------------------------


@settings(max_examples=30, deadline=None)
@given(factor=st.floats(0.1, 10.0), tau_beta=st.floats(0.5, 40.0), model=st.sampled_from(MODELS))
def test_it_is_linear_in_the_wind_and_odd(factor, tau_beta, model):
    plant = plant_of(model=model)
    wind = triangle(plant, tau_beta, peak=-0.01)
    best = optimum_deflection(plant, wind)
    other = optimum_deflection(plant, -factor * wind)
    assert other.peak == pytest.approx(factor * best.peak, rel=1e-10)
    assert np.sign(other.deflection(0.0)) == -np.sign(best.deflection(0.0))
    np.testing.assert_allclose(other.switch_times[:2], best.switch_times[:2], rtol=1e-7)


@settings(max_examples=30, deadline=None)
@given(dt=st.floats(-20.0, 20.0), tau_beta=st.floats(0.5, 40.0), model=st.sampled_from(MODELS))
def test_it_moves_with_the_wind(dt, tau_beta, model):
    plant = plant_of(model=model)
    wind = triangle(plant, tau_beta)
    best, other = (optimum_deflection(plant, wind.shift(s), s) for s in (0.0, dt))
    assert other.peak == pytest.approx(best.peak, rel=1e-11)
    np.testing.assert_allclose(other.switch_times[:2], best.switch_times[:2] + dt, atol=1e-6)


@settings(max_examples=30, deadline=None)
@given(factor=st.floats(0.1, 10.0), ratio=st.floats(0.01, 0.9), y=st.floats(-3.0, 3.0))
def test_it_scales_with_time(factor, ratio, y):
    poles, demands = np.array([1.0, ratio]), np.array([1.0, y / ratio])
    times = [
        switch_time(tuple(f * poles), tuple(demands / f)) * f for f in (1.0, factor)
    ]  # c_i stay the same
    if np.isinf(times[0]) or ratio * times[0] > 15.0:
        return
    assert times[1] == pytest.approx(times[0], rel=1e-8, abs=1e-12)


@settings(max_examples=30, deadline=None)
@given(
    slow=st.floats(0.01, 1.0),
    apart=st.floats(1.2, 50.0),
    d=st.tuples(st.floats(-10.0, 10.0), st.floats(-10.0, 10.0)),
)
def test_two_poles_ask_for_no_less_than_either(slow, apart, d):
    poles = np.array([slow * apart, slow])
    demands = np.array(d)
    if np.abs(demands).min() < 1e-3:
        return
    _, proof = solved(poles, demands)
    assert proof.residual < 1e-11
    assert proof.primal >= np.abs(poles * demands).max() * (1.0 - 1e-11)


def test_nothing_is_needed_by_a_stable_vehicle_or_by_a_wind_that_excites_nothing():
    wind = TriangularWind(peak=0.1, duration=5.0)
    stable = Plant(Coefficients(mu_alpha=-0.2, mu_delta=1.0))
    best = optimum_deflection(stable, wind)
    assert (best.peak, best.status) == (0.0, STABLE)
    assert best.multipliers.shape == (0,)
    assert np.all(best.deflection(np.linspace(-1.0, 9.0, 5)) == 0.0)
    tuned = Plant(Coefficients.from_beta(beta=0.5, B=0.1, b1=0.03, b2=-0.5), "drift")
    best = optimum_deflection(tuned, wind)
    assert (best.peak, best.status) == (0.0, UNTOUCHED)
    assert best.multipliers.tolist() == [0.0]


WIND = TriangularWind(peak=0.1, duration=5.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"horizon": 4.0}, "horizon must not be before the wind ends at 5 s; got 4 s"),
        ({"start": 8.0, "horizon": 8.0}, r"horizon must be after start \(8 s\); got 8 s"),
        ({"start": [0.0, 1.0]}, "start must be one number"),
        ({"start": np.inf}, "start must be finite"),
        ({"start": 1e5}, "start is so late"),
        ({"horizon": "late"}, "horizon must be a number"),
        ({"wind": tvclin.HeldDeflection(limit=0.1)}, "wind must end"),
        ({"wind": 0.0 * WIND}, "wind must differ from zero"),
        ({"wind": TriangularWind(peak=[0.1, 0.2], duration=5.0)}, "wind must be one wind"),
        (
            {"plant": Plant(Coefficients.from_beta(beta=[0.4, 0.5], B=0.1))},
            r"plant must be one plant; got a batch of shape \(2,\)",
        ),
        (
            {"plant": Plant(Coefficients.from_beta(beta=0.5, B=0.1, b1=-0.5), "drift")},
            "no effect at 0.5 1/s",
        ),
    ],
)
def test_bad_input_is_refused_in_one_sentence(change, message):
    arguments = {"plant": Plant(Coefficients.from_beta(beta=0.5, B=0.1)), "wind": WIND} | change
    with pytest.raises(InputError, match=message):
        optimum_deflection(**arguments)


@pytest.mark.parametrize("call", [late_switch, early_switch])
def test_ratios_of_the_approximations_are_checked(call):
    with pytest.raises(InputError, match="ratio must be below 1"):
        call(0.5, 1.0)
