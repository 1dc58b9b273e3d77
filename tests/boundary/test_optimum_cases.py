"""The minimum-peak control of random plants and winds, against a linear program and its laws."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

import tvclin
from tests.optima import NAMES, plant_of, solved, triangle
from tests.turns import usual
from tvclin import Plant, optimum_deflection
from tvclin.boundary.optimum.dual import best_multipliers
from tvclin.boundary.optimum.minimum_peak import NOT_CONVERGED, certify
from tvclin.boundary.optimum.moments import Constraints, Window
from tvclin.boundary.optimum.two_poles import switch_time

MODELS = ("fixed-path", "drift", "drift-exact", "drift-and-speed")


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
    program = linprog(
        np.append(np.zeros(cells), -1.0), A_eq=matrix, b_eq=np.zeros(len(rows)), bounds=bounds
    )
    assert program.status == 0
    return 1.0 / program.x[-1]


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


@pytest.mark.thorough
@pytest.mark.parametrize("count", usual([20, 60], 0))
def test_random_cases_against_a_linear_program(count):
    for constraints in cases(count):
        window = Window(constraints)
        best = best_multipliers(window)
        proof = certify(window, best.multipliers, best.zeros, best.norm * best.signs[0])
        assert abs(proof.gap) < 1e-10
        assert proof.residual < 1e-12
        assert proof.primal == pytest.approx(scaled_grid_peak(constraints), rel=2e-3)


@pytest.mark.thorough
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


@pytest.mark.parametrize(
    "poles",
    usual(
        [
            [0.344447710, 0.0296960686, 4.33586171e-05],
            [0.410531129, 0.00983137471, 1.47505636e-05],
            [0.484142834, 0.0173333111, 2.28430164e-05],
            [3.0, 0.02, 1e-6],
            [3.0, 0.9 + 0.3j, 6e-5],
        ],
        0,
    ),
)
def test_a_pole_that_counts_only_after_the_others_is_proved_by_the_others(poles):
    """A switch cancels it so late that the others require the same peak without it."""
    rows = [1 if np.imag(pole) == 0.0 else 2 for pole in poles]
    decays = np.repeat(np.real(poles), rows)
    for seed in range(2):
        demands = np.random.default_rng(seed).uniform(-0.8, 0.8, decays.size)
        _, others = solved(poles[:-1], demands[:-1])
        demands[-1] *= others.primal / decays[-1]
        best, proof = solved(poles, demands)

        assert abs(proof.gap) < 1e-12
        assert proof.residual < 1e-12
        assert proof.primal == pytest.approx(others.primal, rel=1e-12)
        assert np.exp(-decays[-2] * best.zeros[-1]) < 1e-20


@pytest.mark.parametrize("angle", usual([64.0, 75.0, 85.0], 1))
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
        assert tvclin.linear.judge(plant, best.deflection, wind).stable


def test_a_result_that_did_not_converge_says_so(monkeypatch):
    plant = plant_of(model="drift-and-speed")
    monkeypatch.setattr("tvclin.boundary.optimum.dual._NEWTON_STEPS", 0)
    monkeypatch.setattr("tvclin.boundary.optimum.dual._GRID_REFINEMENTS", 1)
    best = optimum_deflection(plant, triangle(plant, 20.0))
    assert best.status == NOT_CONVERGED
    assert best.certificate.gap > 1e-9


# ---- properties ----------------------------------------------------------------------------


@pytest.mark.thorough
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


@pytest.mark.thorough
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


@pytest.mark.thorough
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
