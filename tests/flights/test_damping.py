"""Flights of a vehicle with damping: on both engines, and without damping as they were."""

from importlib.util import find_spec

import numpy as np
import pytest

import tvclin as tv
from tests.damped import damped
from tests.turns import usual
from tvclin.ascent.nominal_flight import load_flight_condition, nominal_flight
from tvclin.boundary.closed_forms import triangular_limit
from tvclin.flights.planar import PlanarMotion
from tvclin.flights.sixdof.model import model_xml

DEGREE = np.radians(1.0)
NAME = "configuration-i"
EACH_ENGINE = pytest.mark.parametrize(
    "engine",
    [
        "planar",
        pytest.param(
            "sixdof", marks=pytest.mark.skipif(find_spec("jsbsim") is None, reason="no JSBSim")
        ),
    ],
)
EACH_PLANE = pytest.mark.parametrize("plane", ["pitch", "yaw"])


def triangle(vehicle, tau_pole):
    pole = tv.Coefficients.from_vehicle(vehicle).pole
    return tv.TriangularWind(peak=DEGREE, duration=tau_pole / pole)


@pytest.mark.thorough
@EACH_ENGINE
@pytest.mark.parametrize("plane", usual(["pitch", "yaw"], 1))
@pytest.mark.parametrize(
    ("damping", "tau_pole", "K"), usual([(0.03, 4.0, 1.0), (0.25, 6.0, 0.5), (0.6, 3.0, 0.3)], 1)
)
def test_the_flown_boundary_is_eq_12_with_the_pole(engine, plane, damping, tau_pole, K):
    vehicle = damped(NAME, damping)
    wind = triangle(vehicle, tau_pole)
    flown = tv.flown_boundary(
        vehicle, wind, K, engine=engine, plane=plane, drift=False, tolerance=1e-4
    )
    assert flown.limit == pytest.approx(triangular_limit(tau_pole, K), abs=1e-3)
    undamped = tv.boundary_limit(
        tv.Plant.from_vehicle(damped(NAME, 0.0), "fixed-path"), wind, K
    ).limit
    assert abs(flown.limit - undamped) > 5e-3


@EACH_ENGINE
@pytest.mark.parametrize("drift", [False, True])
def test_a_small_deflection_gives_the_exact_linear_response(engine, drift):
    vehicle = damped(NAME, 0.4)
    wind = triangle(vehicle, 2.0)
    times = np.linspace(0.0, float(wind.end), 11)
    push = tv.linear.ConstantDeflection(limit=-0.0005, start=1.0)
    fly = tv.fly_planar if engine == "planar" else tv.fly_sixdof
    flown = fly(vehicle, push, wind, times, drift=drift, deflection_limit=0.1)
    plant = tv.Plant.from_vehicle(vehicle, "drift-exact" if drift else "fixed-path")
    exact = tv.attitude_responses(plant, push, wind, times)
    for name in ("attitude", "attitude_rate"):
        row = flown.outputs[list(flown.output_labels).index(name)]
        size = np.abs(exact[name]).max()
        np.testing.assert_allclose(row, exact[name], atol=2e-3 * size)


@EACH_PLANE
def test_in_the_small_the_equations_are_the_damped_plant(plane):
    vehicle = damped(NAME, 0.4)
    motion = PlanarMotion(vehicle, plane)
    A, _, _, _ = tv.Plant.from_vehicle(vehicle, "drift-and-speed", plane).matrices()
    step = 1e-6 * np.eye(4)[1]
    column = (motion.rates(0.0, step, 0.0, 0.0) - motion.rates(0.0, -step, 0.0, 0.0)) / 2e-6
    assert A[1, 1] == pytest.approx(-0.4, rel=1e-15)
    np.testing.assert_allclose(column, A[:, 1], atol=2e-11)


def test_the_nominal_deflection_holds_the_turning_nose_against_the_damping():
    """From the path alone, by differences: I Theta_n'' = -T l_c delta_n - M_q Theta_n'."""
    condition = load_flight_condition(NAME)
    flight = nominal_flight(damped(NAME, 0.3), condition, start=60.0, stop=72.0)
    t, h, v = 68.0, 0.05, flight.vehicle
    path = flight.states(np.array([t - h, t, t + h]))[1]
    bend, turn = (path[0] - 2.0 * path[1] + path[2]) / h**2, (path[2] - path[0]) / (2.0 * h)
    expected = -(v.moment_of_inertia * bend + v.pitch_damping * turn) / (v.thrust * v.control_arm)
    assert flight.deflection(t) == pytest.approx(expected, rel=1e-3)
    calm = nominal_flight(damped(NAME, 0.0), condition, start=60.0, stop=72.0)
    assert flight.deflection(t) > calm.deflection(t)  # nose down, after the path


@pytest.mark.thorough
@EACH_PLANE
def test_along_the_trajectory_both_engines_fly_the_same(plane):
    pytest.importorskip("jsbsim")
    vehicle, condition = damped(NAME, 0.3), load_flight_condition(NAME)
    wind = triangle(vehicle, 3.0).shift(63.0)
    times = np.linspace(63.0, float(wind.end), 21)
    gains = tv.design_gains(
        tv.Coefficients.from_vehicle(vehicle), natural_frequency=1.0, damping=0.7
    )
    options = {"condition": condition, "plane": plane, "deflection_limit": 0.05}
    planar, flown = (
        np.asarray(fly(vehicle, gains, wind, times, **options).outputs[:3])
        for fly in (tv.fly_planar, tv.fly_sixdof)
    )
    calm = np.asarray(tv.fly_planar(damped(NAME, 0.0), gains, wind, times, **options).outputs[:3])
    assert np.abs(flown - planar).max() < 3e-4 * DEGREE  # in the wind's measure, as in test_sixdof
    assert np.abs(calm - planar).max() > 3e-3 * DEGREE


@pytest.mark.parametrize("model", usual(["fixed-path", "drift-exact"], 1))
def test_the_law_that_leans_survives_above_the_bound_and_no_law_below(model):
    """In z = theta + theta'/(p + d) alone is a state on the edge of what can be brought back."""
    vehicle = damped("configuration-ii", 0.2)
    plant = tv.Plant.from_vehicle(vehicle, model)
    wind = triangle(vehicle, 8.0)
    bound = tv.forecast_free_limit(plant, wind).limit
    law = tv.RecoverableAttitudeLaw(plant, reach=0.98, design_peak=DEGREE, trust=1.0)
    computed = tv.closed_loop_boundary(plant, law, wind, sample_rate=50.0).limit
    assert bound * (1 - 1e-3) < computed < 1.12 * bound
    fixed = tv.Plant.from_vehicle(vehicle, "fixed-path")
    trim = tv.closed_loop_boundary(fixed, tv.TrimLaw(fixed), wind, sample_rate=50.0).limit
    assert trim == pytest.approx(triangular_limit(8.0, 1.0), abs=2e-3)


def test_without_damping_the_equations_flown_are_the_reports_to_the_last_bit():
    v = tv.load_vehicle(NAME)
    motion, chance = PlanarMotion(v), np.random.default_rng(7)
    for _ in range(20):
        x, (delta, gust) = 0.1 * chance.normal(size=4), 0.05 * chance.normal(size=2)
        moment = v.normal_force_slope * 1.0 * v.aerodynamic_arm * (x[0] - x[2] - gust)
        moment -= v.control_force * v.control_arm * np.sin(delta)
        assert motion.rates(0.0, x, delta, gust)[1] == moment / v.moment_of_inertia
    flight = nominal_flight(v, load_flight_condition(NAME), start=62.0, stop=72.0)
    speed, path, _ = states = flight.states(np.array([65.0, 69.0]))
    rates = flight.rates(np.array([65.0, 69.0]), states)
    bend = 9.80665 * (np.sin(path) * rates[1] / speed + np.cos(path) * rates[0] / speed**2)
    expected = -v.moment_of_inertia * bend / (v.control_force * v.control_arm)
    np.testing.assert_array_equal(flight.deflection(np.array([65.0, 69.0])), expected)
    assert "damping" not in model_xml(v)
    assert model_xml(damped(NAME, 0.1)).count("tvclin/damping-") == 2
