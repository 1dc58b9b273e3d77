"""The minimum-peak control against the tables, a linear program and mpmath of our own."""

from dataclasses import astuple
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

import tvclin
from tests.optima import NAMES, plant_of, solved, triangle
from tests.turns import by_turns, usual
from tvclin import Coefficients, InputError, Plant, TriangularWind, optimum_deflection
from tvclin.boundary.optimum import minimum_peak
from tvclin.boundary.optimum.minimum_peak import (
    NOT_CONVERGED,
    NOT_EXCITED,
    STABLE,
    _polished,
    _solve,
    certify,
)
from tvclin.boundary.optimum.moments import Constraints, Window

MODELS = ("fixed-path", "drift", "drift-exact", "drift-and-speed")


def scaled_peak(plant, tau_beta):
    wind = triangle(plant, tau_beta)
    return optimum_deflection(plant, wind).peak / abs(plant.coefficients.B * wind.peak)


def test_the_conditions_are_those_of_their_poles():
    """Two real poles and a pair: e_i, its slope, its integral, and the way back."""
    c = Constraints(np.array([0.5, 0.1 + 0.3j, 0.02]), np.zeros(4))
    functions = [
        lambda u: np.exp(-0.5 * u),
        lambda u: np.exp(-0.1 * u) * np.cos(0.3 * u),
        lambda u: np.exp(-0.1 * u) * np.sin(0.3 * u),
        lambda u: np.exp(-0.02 * u),
    ]
    u, step = np.array([0.0, 0.7, 3.0, 11.0]), 1e-5
    np.testing.assert_allclose(c.basis(u), [f(u) for f in functions], rtol=1e-13)
    slopes = [(f(u + step) - f(u - step)) / (2.0 * step) for f in functions]
    np.testing.assert_allclose(c.slopes(u), slopes, atol=1e-9)
    knots = [0.0, 0.7, 3.0, np.inf]
    areas = [[quad(f, *knots[k : k + 2])[0] for k in range(3)] for f in functions]
    np.testing.assert_allclose(c.moments(np.array(knots)), areas, atol=1e-7)
    values = np.array([1.0, 2.0 - 3.0j, 4.0])
    np.testing.assert_array_equal(c.complex_values(c.real_rows(values)), values)


def test_a_residual_is_the_violation_over_the_sizes_of_the_pieces_and_the_demand():
    window = Window(Constraints(np.array([1.0]), np.array([1.0])))
    # Up to ln 2 the deflection 3 has the moment 1.5, from then on -1.5: the demand of 1 is missed.
    proof = certify(window, np.array([1.0]), np.array([np.log(2.0)]), 3.0)
    assert proof.residual == pytest.approx(1.0 / (1.5 + 1.5 + 1.0), rel=1e-14)
    assert (proof.primal, proof.dual, proof.tail) == (3.0, pytest.approx(1.0), 0.0)
    assert proof.gap == pytest.approx(2.0 / 3.0)
    assert certify(window, np.array([1.0]), np.zeros(0), -3.0).gap == pytest.approx(2.0 / 3.0)


@pytest.mark.parametrize("missed", [0, 1])
def test_a_residual_is_that_of_the_condition_that_is_missed_most(missed):
    poles, demands = (
        np.array([1.0, 2.0]),
        np.array([3.0, 1.5]),
    )  # 3, constant for ever, is sufficient for both
    demands[missed] *= 2.0
    proof = certify(Window(Constraints(poles, demands)), np.ones(2), np.zeros(0), 3.0)
    assert proof.residual == pytest.approx(1.0 / (1.0 + 2.0), rel=1e-14)


def test_the_lower_bound_holds_however_early_the_window_is_cut(monkeypatch):
    poles, demands = [0.1 + 0.2j], [1.0, 0.5]
    best, proof = solved(poles, demands)
    functions = (
        lambda u: np.exp(-0.1 * u) * np.cos(0.2 * u),
        lambda u: np.exp(-0.1 * u) * np.sin(0.2 * u),
    )
    for cut in (1.0, 6.0):
        monkeypatch.setattr("tvclin.boundary.optimum.moments.TRUNCATED", cut)
        window = Window(Constraints(np.asarray(poles), np.asarray(demands)))
        zeros = best.zeros[best.zeros < window.end]
        bound, scaled = (
            certify(window, scale * best.multipliers, zeros, 1.0) for scale in (1.0, 3.0)
        )
        assert bound.dual < proof.primal
        sizes = [
            abs(best.multipliers @ [quad(f, *piece)[0] for f in functions])
            for piece in pairwise([0.0, *zeros, window.end])
        ]
        omitted = np.abs(best.multipliers).sum() * np.exp(-0.1 * window.end) / 0.1
        assert [bound.tail, scaled.tail] == pytest.approx(2 * [omitted / sum(sizes)], rel=1e-9)
        assert bound.tail > 1e-5


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("poles", [[1.0, 2.0], [2.0, 1.0]])
def test_where_one_constant_meets_both_conditions_their_sum_proves_it(poles, sign):
    window = Window(Constraints(np.array(poles), sign * 2.0 / np.array(poles)))
    switches, multipliers = _solve(window)
    proof = certify(window, multipliers, switches, sign * 2.0)
    assert switches.size == 0
    assert (proof.residual, proof.dual) == (pytest.approx(0.0, abs=1e-15), pytest.approx(2.0))


@pytest.mark.parametrize(("sign", "faster"), [(1.0, 1.0), (-1.0, 100.0)])
def test_switch_times_that_are_nearly_right_are_made_exact(sign, faster):
    poles = faster * np.array([0.5, 0.1, 0.02])
    demands = sign * np.array([1.0, -3.0, 30.0]) / faster
    best, _ = solved(poles, demands)
    assert best.zeros.size == 2
    window = Window(Constraints(poles, demands))
    switches, limit = _polished(window, best.zeros + np.array([1e-3, -2e-3]) / faster)
    np.testing.assert_allclose(switches, best.zeros, rtol=1e-10)
    assert limit == pytest.approx(best.norm * best.signs[0], rel=1e-12)


@pytest.mark.parametrize("factor", [1e-3, 1.0 + 1e-8])
def test_what_misses_its_conditions_is_not_ok_nor_below_the_bound(monkeypatch, factor):
    plant = plant_of()
    wind = triangle(plant, 20.0)
    true = optimum_deflection(plant, wind)
    limit = factor * float(true.deflection(0.0))
    monkeypatch.setattr(minimum_peak, "_polished", lambda _, times: (times, limit))
    best = optimum_deflection(plant, wind)
    assert best.status == NOT_CONVERGED
    assert best.peak == pytest.approx(max(factor, 1.0) * true.peak, rel=1e-10)


def test_at_its_switch_times_the_deflection_changes_its_sign():
    plant = plant_of()
    best = optimum_deflection(plant, triangle(plant, 20.0), -2.0)
    before, after = best.deflection(best.switch_times[0] + np.array([-1e-6, 1e-6]))
    assert before == -after != 0.0


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
    assert tvclin.linear.judge(plant, best.deflection, wind).stable


@pytest.mark.parametrize(
    ("name", "tau_beta", "peak"),
    usual(
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
        0,
        5,
    ),
)
def test_fourth_order_with_its_complex_pair(name, tau_beta, peak):
    assert scaled_peak(plant_of(name, "drift-and-speed"), tau_beta) == pytest.approx(peak, abs=1e-3)


@by_turns("name,model,horizon", NAMES, MODELS, [None, 90.0, 400.0], each=3)
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
            assert tvclin.linear.judge(plant, best.deflection, wind).stable
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
    endless, never = (optimum_deflection(plant, wind, 0.0, h) for h in (np.inf, None))
    assert endless.peak == never.peak
    exact = plant_of()
    wind = triangle(exact, 20.0)
    peaks = [optimum_deflection(exact, wind, 0.0, h).peak for h in (40.0, 60.0, 200.0, None)]
    assert np.all(np.diff(peaks) < 0.0)


# ---- two real poles ------------------------------------------------------------------------


def test_nothing_is_needed_by_a_stable_vehicle_or_by_a_wind_that_excites_nothing():
    wind = TriangularWind(peak=0.1, duration=5.0)
    stable = Plant(Coefficients(mu_alpha=-0.2, mu_delta=1.0), "fixed-path")
    best = optimum_deflection(stable, wind)
    assert (best.peak, best.status) == (0.0, STABLE)
    assert best.multipliers.shape == best.switch_times.shape == (0,)
    assert astuple(best.certificate) == (0.0, 0.0, 0.0, 0.0, 0.0)
    assert np.all(best.deflection(np.linspace(-1.0, 9.0, 5)) == 0.0)
    tuned = Plant(Coefficients.from_beta(beta=0.5, B=0.1, b1=0.03, b2=-0.5), "drift")
    best = optimum_deflection(tuned, wind)
    assert (best.peak, best.status) == (0.0, NOT_EXCITED)
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
        ({"wind": tvclin.linear.ConstantDeflection(limit=0.1)}, "wind must end"),
        ({"wind": 0.0 * WIND}, "wind must differ from zero"),
        ({"wind": TriangularWind(peak=[0.1, 0.2], duration=5.0)}, "wind must be one wind"),
        (
            {"plant": Plant(Coefficients.from_beta(beta=[0.4, 0.5], B=0.1), "fixed-path")},
            r"plant must be one plant; got a batch of shape \(2,\)",
        ),
        (
            {"plant": Plant(Coefficients.from_beta(beta=0.5, B=0.1, b1=-0.5), "drift")},
            "no effect at 0.5 1/s",
        ),
    ],
)
def test_bad_input_is_refused_in_one_sentence(change, message):
    arguments = {
        "plant": Plant(Coefficients.from_beta(beta=0.5, B=0.1), "fixed-path"),
        "wind": WIND,
    } | change
    with pytest.raises(InputError, match=message):
        optimum_deflection(**arguments)


@pytest.mark.thorough
@pytest.mark.parametrize("start", usual([0.0, -5.0, -10.0], 2))
def test_what_is_not_reached_is_said_and_never_below_the_proved_bound(start):
    """A fast pair beside a pole with an e-folding time of an hour: the hardest of thousands."""
    c = tvclin.Coefficients.from_beta(
        beta=0.2429998651618611, B=0.1, C1=0.03, C2=0.01932476546304679, b1=0.05, b2=0.03, q=1e-4
    )
    wind = tvclin.SampledWind(
        time=[3.49384, 7.55222, 9.46907], angle=[0.0391042, 0.0067311, 0.0131451]
    )
    best = tvclin.optimum_deflection(tvclin.Plant(c, "drift-and-speed"), wind, start)

    assert best.peak >= best.certificate.dual * (1.0 - 1e-9)
    assert (best.status == "ok") == (abs(best.certificate.gap) < 1e-9)
