"""The minimum-peak control under a rate limit, against closed forms and other programs."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

import tvclin
from tests.turns import by_turns, usual
from tvclin import Coefficients, InputError, Plant, TriangularWind
from tvclin import optimum_deflection as without_limit
from tvclin.boundary import optimum_with_rate_limit as with_limit

BETA, B = 0.5, 0.1
WIND = TriangularWind(peak=-0.1, duration=8.0)


def fixed_path():
    return Plant(Coefficients.from_beta(beta=BETA, B=B), "fixed-path")


def configuration(model):
    return Plant.from_vehicle(tvclin.load_vehicle("configuration-i"), model)


def triangle(plant, tau_beta):
    return TriangularWind(peak=-0.1, duration=tau_beta / plant.coefficients.beta)


def slopes(deflection):
    return deflection.pieces.coefficients[..., 0, 1]


def demand():
    return B * 0.1 * float(TriangularWind(peak=1.0, duration=8.0).laplace(BETA))


@pytest.mark.thorough
@pytest.mark.parametrize("rate", usual([2e-3, 3e-3, 1e-2, 0.1, 1.0, 1e3], 0, 3, 5))
def test_one_pole_is_a_ramp_and_a_hold(rate):
    """A ramp to P and a hold have the moment r (1 - e^(-beta P/r))/beta^2."""
    best = with_limit(fixed_path(), WIND, rate)
    exact = -rate / BETA * np.log1p(-(BETA**2) * demand() / rate)
    assert best.peak == pytest.approx(exact, rel=1e-6)
    assert best.peak >= exact * (1.0 - 1e-12)
    assert best.deflection.final_value == pytest.approx(best.peak, rel=1e-12)


@by_turns(
    "model,tau_beta,horizon",
    ["fixed-path", "drift", "drift-exact", "drift-and-speed"],
    [4.0, 20.0],
    [None, 120.0],
    each=5,
)
def test_what_it_returns_keeps_every_promise(model, tau_beta, horizon):
    plant = configuration(model)
    wind = triangle(plant, tau_beta)
    for rate in (3e-3, 2e-2, 0.5):
        best = with_limit(plant, wind, rate, horizon=horizon)
        assert best.status == "ok"
        assert best.deflection(0.0) == pytest.approx(0.0, abs=1e-12 * best.peak)
        assert best.rate <= rate * (1.0 + 1e-9)
        assert np.abs(slopes(best.deflection)).max() == pytest.approx(best.rate, rel=1e-12)
        assert abs(float(best.deflection.peak)) == pytest.approx(best.peak, rel=1e-12)
        assert best.residual < 1e-13
        assert best.change < 1e-4
        assert tvclin.linear.judge(plant, best.deflection, wind).stable
        unlimited = without_limit(plant, wind, horizon=horizon)
        assert best.unlimited_peak == unlimited.peak
        assert best.peak >= unlimited.peak * (1.0 - 1e-9)


def grid_peak(plant, wind, rate, count=1200):
    """An independent program: values at fixed nodes, moments by Simpson's rule in each piece."""
    modes = tvclin.unstable_modes(plant)
    demands = -modes.wind_residues / modes.deflection_residues * wind.laplace(modes.poles)
    last = 14.0 / modes.poles.min()
    nodes = np.linspace(0.0, last ** (1.0 / 3.0), count + 1) ** 3
    width = np.diff(nodes)
    rows = []
    for pole in modes.poles:
        low, mid, high = (
            np.exp(-pole * t) for t in (nodes[:-1], nodes[:-1] + width / 2, nodes[1:])
        )
        row = np.zeros(count + 1)
        row[:-1] += width / 6.0 * (low + 2.0 * mid)
        row[1:] += width / 6.0 * (high + 2.0 * mid)
        row[-1] += np.exp(-pole * last) / pole
        rows.append(row[1:])
    rows, sizes = np.array(rows), np.abs(rows).sum(axis=1)
    difference = np.eye(count) - np.eye(count, k=-1)
    unit, column = np.abs(demands * modes.poles).max(), np.ones((count, 1))
    zero = np.zeros((count, 1))
    program = linprog(
        np.append(np.zeros(count), 1.0),
        A_ub=np.vstack(
            [
                np.hstack([np.eye(count), -column]),
                np.hstack([-np.eye(count), -column]),
                np.hstack([difference, zero]),
                np.hstack([-difference, zero]),
            ]
        ),
        b_ub=np.concatenate([np.zeros(2 * count), np.tile(rate * width / unit, 2)]),
        A_eq=np.column_stack([rows / sizes[:, None], np.zeros(len(rows))]),
        b_eq=demands / sizes / unit,
        bounds=[*[(None, None)] * count, (0.0, None)],
    )
    assert program.status == 0
    return program.x[-1] * unit


@pytest.mark.thorough
@pytest.mark.parametrize(("tau_beta", "rate"), usual([(4.0, 4e-3), (17.0, 2e-3), (20.0, 8e-4)], 1))
def test_two_poles_against_another_program(tau_beta, rate):
    plant = configuration("drift-exact")
    wind = triangle(plant, tau_beta)
    other = grid_peak(plant, wind, rate)
    computed = with_limit(plant, wind, rate).peak
    assert computed == pytest.approx(other, rel=2e-3)
    assert computed <= other * (1.0 + 1e-4)


@pytest.mark.thorough
def test_more_steps_change_little_and_the_answer_settles():
    plant = configuration("drift-exact")
    wind = triangle(plant, 20.0)
    peaks = [with_limit(plant, wind, 1e-3, steps=steps).peak for steps in (50, 200, 800)]
    np.testing.assert_allclose(peaks, peaks[-1], rtol=1e-5)


@pytest.mark.thorough
@pytest.mark.parametrize("model", usual(["fixed-path", "drift-exact", "drift-and-speed"], 1))
def test_large_rates_lead_to_the_unlimited_optimum(model):
    plant = configuration(model)
    wind = triangle(plant, 20.0)
    excess = [with_limit(plant, wind, r).peak for r in (0.1, 1.0, 10.0)]
    excess = np.array(excess) / without_limit(plant, wind).peak - 1.0
    assert np.all(np.diff(excess) < 0.0)
    assert excess[-1] < 1e-4


@pytest.mark.thorough
@settings(max_examples=12, deadline=None)
@given(
    rate=st.floats(1.2e-3, 0.1), more=st.floats(1.05, 10.0), model=st.sampled_from(["drift-exact"])
)
def test_a_faster_actuator_needs_no_more(rate, more, model):
    plant = configuration(model)
    wind = triangle(plant, 20.0)
    slow, fast = (with_limit(plant, wind, r).peak for r in (rate, rate * more))
    assert fast <= slow * (1.0 + 1e-6)
    assert fast >= without_limit(plant, wind).peak * (1.0 - 1e-9)


@pytest.mark.thorough
@settings(max_examples=12, deadline=None)
@given(factor=st.floats(0.1, 10.0), dt=st.floats(-5.0, 5.0))
def test_scaling_sign_and_shift(factor, dt):
    plant = configuration("drift-exact")
    wind = triangle(plant, 12.0)
    best = with_limit(plant, wind, 3e-3)
    scaled = with_limit(plant, -factor * wind, 3e-3 * factor)
    shifted = with_limit(plant, wind.shift(dt), 3e-3, start=dt)
    assert scaled.peak == pytest.approx(factor * best.peak, rel=1e-6)
    assert shifted.peak == pytest.approx(best.peak, rel=1e-6)
    assert shifted.deflection.onset >= dt
    assert np.sign(float(scaled.deflection.peak)) == -np.sign(float(best.deflection.peak))


@pytest.mark.thorough
def test_an_early_start_makes_up_for_a_slow_actuator():
    plant = fixed_path()
    with pytest.raises(InputError, match="rate_limit is too small"):
        with_limit(plant, WIND, 8e-4)
    peaks = [with_limit(plant, WIND, 8e-4, start=start).peak for start in (-2.0, -4.0, -8.0)]
    assert np.all(np.diff(peaks) < 0.0)


@pytest.mark.thorough
@pytest.mark.parametrize("horizon", usual([None, 30.0], 0))
@pytest.mark.parametrize("model", usual(["fixed-path", "drift-exact", "drift-and-speed"], 1))
def test_a_rate_too_small_names_the_one_that_would_do(model, horizon):
    plant = configuration(model)
    wind = triangle(plant, 4.0)
    with pytest.raises(InputError, match="rate_limit is too small") as refused:
        with_limit(plant, wind, 1e-5, horizon=horizon)
    named = float(re.search(r"\(([\d.e-]+) rad/s\) would do", str(refused.value)).group(1))
    assert with_limit(plant, wind, named, horizon=horizon).residual < 1e-12
    with pytest.raises(InputError, match="rate_limit is too small"):
        with_limit(plant, wind, 0.99 * named, horizon=horizon)
    if model == "fixed-path" and horizon is None:  # a ramp for ever: r/beta^2 = D
        beta = plant.coefficients.beta
        demand = -plant.coefficients.B * wind.laplace(beta)
        assert named == pytest.approx(float(beta**2 * demand), rel=2e-3)


def test_nothing_is_needed_by_a_stable_vehicle():
    best = with_limit(Plant(Coefficients(mu_alpha=-0.2, mu_delta=1.0), "fixed-path"), WIND, 0.1)
    assert (best.peak, best.rate, best.residual) == (0.0, 0.0, 0.0)
    assert best.status.startswith("no unstable pole")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rate_limit": 0.0}, "rate_limit must be positive; got 0 rad/s"),
        ({"rate_limit": [0.1, 0.2]}, "rate_limit must be one number"),
        ({"rate_limit": np.inf}, "rate_limit must be finite"),
        ({"steps": 3}, "steps must be 10 to 10000; got 3"),
        ({"steps": 20.0}, "steps must be an integer"),
        ({"horizon": 4.0}, "horizon must not be before the wind ends"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(change, message):
    arguments = {"plant": fixed_path(), "wind": WIND, "rate_limit": 0.1} | change
    with pytest.raises(InputError, match=message):
        with_limit(**arguments)
