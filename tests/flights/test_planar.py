"""Planar flights: the report's equations, linear in the small, and what flying finds."""

import warnings
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tvclin as tv
from tests.report_responses import triangular_attitude
from tests.turns import usual
from tvclin import InputError, TriangularWind, flown_boundary, fly_planar
from tvclin.ascent.atmosphere import standard_atmosphere
from tvclin.ascent.nominal_flight import load_flight_condition, nominal_flight
from tvclin.flights import ReportControl
from tvclin.flights.planar import PlanarMotion

DEGREE = np.radians(1.0)
NAMES = ("configuration-i", "configuration-ii")
EACH_NAME = pytest.mark.parametrize("name", NAMES)
EACH_PLANE = pytest.mark.parametrize("plane", ["pitch", "yaw"])


def case(name, tau_beta=4.0, peak=DEGREE):
    vehicle = tv.load_vehicle(name)
    beta = tv.Coefficients.from_vehicle(vehicle).beta
    return vehicle, TriangularWind(peak=peak, duration=tau_beta / beta)


@EACH_NAME
@EACH_PLANE
def test_in_the_small_the_equations_are_the_linear_plant(name, plane):
    vehicle = tv.load_vehicle(name)
    motion = PlanarMotion(vehicle, plane)
    A, B, _, _ = tv.Plant.from_vehicle(vehicle, "drift-and-speed", plane).matrices()
    both, h = np.zeros((4, 6)), 1e-6
    for column, step in enumerate(h * np.eye(6)):
        ahead, back = (motion.rates(0.0, s * step[:4], s * step[4], s * step[5]) for s in (1, -1))
        both[:, column] = (ahead - back) / (2.0 * h)
    np.testing.assert_allclose(both, np.hstack([A, B]), atol=2e-11)


@EACH_NAME
def test_the_equations_are_those_of_the_report(name):
    """(B1a) to (B1c), written out, about a nominal flight whose own rates are left out."""
    v = tv.load_vehicle(name)
    x, delta, gust = np.array([0.2, 0.1, -0.15, 0.05]), -0.07, 0.04
    m, W = v.mass, v.weight
    theta, gamma, V = v.attitude + x[0], v.attitude + x[2], v.velocity * (1 + x[3])
    alpha = theta - gamma - gust

    def forces(theta, gamma, alpha, delta):
        lean = theta - gamma
        N = v.normal_force_slope * alpha
        along = (
            v.thrust * np.cos(lean + delta)
            - v.axial_force * np.cos(lean)
            - N * np.sin(lean)
            - W * np.sin(gamma)
        )
        across = (
            v.thrust * np.sin(lean + delta)
            - v.axial_force * np.sin(lean)
            + N * np.cos(lean)
            - W * np.cos(gamma)
        )
        return along, across

    along, across = forces(theta, gamma, alpha, delta)
    rest = forces(v.attitude, v.attitude, 0.0, 0.0)
    moment = v.normal_force_slope * v.aerodynamic_arm * alpha
    moment -= v.thrust * v.control_arm * np.sin(delta)
    expected = [
        x[1],
        moment / v.moment_of_inertia,
        across / (m * V) - rest[1] / (m * v.velocity),
        (along - rest[0]) / m / v.velocity,
    ]
    np.testing.assert_allclose(PlanarMotion(v).rates(0.0, x, delta, gust), expected, rtol=1e-12)


@EACH_NAME
@EACH_PLANE
def test_a_small_deflection_history_gives_the_exact_linear_response(name, plane):
    vehicle, wind = case(name, peak=1e-5)
    plant = tv.Plant.from_vehicle(vehicle, "drift-and-speed", plane)
    limit = 1.05 * tv.boundary_limit(plant, wind, 0.5).deflection
    constant = tv.trim_then_hold(plant, wind, limit, 0.5)
    times = np.linspace(0.0, 1.5 * wind.duration, 40)
    flown = fly_planar(vehicle, constant, wind, times, plane=plane)
    linear = tv.attitude_response(plant, constant, wind, times)
    for output in ("attitude", "flight_path_angle", "angle_of_attack"):
        error = np.abs(flown.outputs[output] - linear.outputs[output]).max()
        assert error < 1e-4 * 1e-5  # of the wind: what is left is of the second order


@pytest.mark.thorough
@EACH_NAME
@pytest.mark.parametrize(("K", "limit"), usual([(1.0, 0.68846), (0.5, 0.55876), (0.0, 0.37382)], 1))
def test_without_drift_the_boundary_is_equation_12(name, K, limit):
    flown = flown_boundary(*case(name), K, drift=False, tolerance=2e-4)
    assert flown.limit == pytest.approx(limit, abs=4e-4)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "K", "limit"),
    usual(
        [  # a Runge-Kutta integration of (B1) of its own, bisected
            (NAMES[0], 1.0, 0.6561),
            (NAMES[0], 0.0, 0.3707),
            (NAMES[1], 0.5, 0.5381),
        ],
        2,
    ),
)
def test_with_drift_the_boundary_is_that_of_another_integration(name, K, limit):
    flown = flown_boundary(*case(name), K, tolerance=2e-4)
    assert flown.limit == pytest.approx(limit, abs=5e-4)


def test_without_drift_the_attitude_is_equation_13():
    vehicle, wind = case(NAMES[0])
    y = 1.1 * tv.boundary_limit(tv.Plant.from_vehicle(vehicle, "fixed-path"), wind).limit
    B = tv.Coefficients.from_vehicle(vehicle).B
    times = np.linspace(0.0, 1.2 * wind.duration, 200)
    limit = y * B * wind.peak
    control = ReportControl(1.0)
    flown = fly_planar(vehicle, control, wind, times, deflection_limit=limit, drift=False)
    expected = triangular_attitude(times / wind.duration, 4.0, y, 1.0)
    error = flown.outputs["attitude"] / -wind.peak - expected
    assert np.abs(error).max() < 1e-3
    assert expected.max() > 0.16


@pytest.mark.thorough
def test_a_law_flies_as_in_the_linear_theory():
    vehicle, wind = case(NAMES[0], peak=1e-4)
    plant = tv.Plant.from_vehicle(vehicle, "drift-and-speed")
    design = tv.Plant.from_vehicle(vehicle, "fixed-path")
    law = tv.RecoverableAttitudeLaw(design, design_peak=1e-4)
    limit = 0.5 * plant.coefficients.B * 1e-4
    times = np.linspace(0.0, 12.0, 50)
    servo = tv.Actuator(natural_frequency=20.0, damping=0.7)
    options = {"deflection_limit": limit, "actuator": servo, "rate_limit": 0.1}
    flown = fly_planar(vehicle, law, wind, times, **options)
    linear = tv.fly(plant, law, wind, times, **options)
    for output in ("attitude", "angle_of_attack", "deflection"):
        error = np.abs(flown.outputs[output] - linear.outputs[output]).max()
        assert error < 2e-4 * 1e-4, output


def test_a_flight_ends_where_the_model_does():
    vehicle, wind = case(NAMES[0])
    with pytest.warns(UserWarning, match="more than 25 deg"):
        flown = fly_planar(
            vehicle, ReportControl(), wind, np.linspace(0.0, 60.0, 601), deflection_limit=5e-4
        )
    attitude = np.degrees(flown.outputs["attitude"])
    assert np.isnan(attitude[-1])
    assert 23.0 < np.nanmax(np.abs(attitude)) <= 25.0


def test_times_may_be_few_and_in_any_order():
    vehicle, wind = case(NAMES[0])
    few = fly_planar(vehicle, ReportControl(), wind, [8.0, 0.0, 5.0], deflection_limit=2e-3)
    many = fly_planar(vehicle, ReportControl(), wind, np.linspace(0, 8, 9), deflection_limit=2e-3)
    np.testing.assert_allclose(few.outputs, many.outputs[:, [8, 0, 5]], rtol=1e-9, atol=1e-12)


@pytest.mark.thorough
def test_varying_parameters_are_those_of_another_integration():
    """The whole flight in inertial quantities, air speed from wind speed, by another solver."""
    vehicle, wind = case(NAMES[0], peak=np.radians(3.0))
    condition = load_flight_condition(NAMES[0])
    later = wind.shift(vehicle.time - wind.duration / 2)
    constant = tv.linear.ConstantDeflection(limit=-2e-3, start=float(later.onset) + 1.0)
    times = np.linspace(float(later.onset), float(later.end), 9)
    flown = fly_planar(vehicle, constant, later, times, condition=condition)
    nominal = nominal_flight(vehicle, condition, start=float(times[0]), stop=float(times[-1]))
    density = standard_atmosphere(condition.altitude).density
    v, g = vehicle, 9.80665

    def rates(t, x):
        theta, rate, gamma, V, h = x
        speed_n, path_n, _ = nominal.states(t)
        alpha_w = float(later(t))
        gust = speed_n * np.sin(alpha_w) / np.sin(path_n + alpha_w)
        u, w = V * np.cos(gamma) - gust, V * np.sin(gamma)
        alpha = theta - np.arctan2(w, u)
        air = standard_atmosphere(h).density
        q = air / density * (u**2 + w**2) / v.velocity**2
        m, delta = nominal.mass(t), float(constant(t))
        normal, lean = v.normal_force_slope * q * alpha, theta - gamma
        T, axial = v.thrust, v.axial_force * q
        moment = normal * v.aerodynamic_arm - T * v.control_arm * np.sin(delta)
        turn = T * np.sin(lean + delta) - axial * np.sin(lean) + normal * np.cos(lean)
        push = T * np.cos(lean + delta) - axial * np.cos(lean) - normal * np.sin(lean)
        return [
            rate,
            moment / v.moment_of_inertia + (bend(t)),
            turn / (m * V) - g * np.cos(gamma) / V,
            push / m - g * np.sin(gamma),
            V * np.sin(gamma),
        ]

    def bend(t):
        """The nominal attitude is turned by a deflection that is not counted."""
        h = 1e-3
        t = min(max(t, times[0] + h), times[-1] - h)
        path = nominal.states(np.array([t - h, t, t + h]))[1]
        return (path[0] - 2.0 * path[1] + path[2]) / h**2

    speed, path, height = nominal.states(times[0])
    spin = (nominal.states(times[0] + 1e-3)[1] - path) / 1e-3
    knots = [times[0], float(constant.knots[0]), vehicle.time, times[-1]]
    state, attitude = np.array([path, spin, path, speed, height]), np.zeros(times.size)
    for first, last in pairwise(knots):
        part = solve_ivp(rates, (first, last), state, dense_output=True, rtol=1e-9, atol=1e-10)
        here = (times >= first) & (times <= last)
        attitude[here] = part.sol(times[here])[0]
        state = part.y[:, -1]
    error = attitude - nominal.states(times)[1] - flown.outputs["attitude"]
    assert np.abs(error).max() < 2e-5
    assert np.ptp(flown.outputs["attitude"]) > np.radians(0.5)


@pytest.mark.thorough
def test_with_varying_parameters_sign_size_and_plane_of_the_wind_matter():
    name = NAMES[0]
    condition = load_flight_condition(name)
    computed = {}
    for peak, plane in ((1.0, "pitch"), (5.0, "pitch"), (-5.0, "pitch"), (1.0, "yaw")):
        vehicle, wind = case(name, peak=np.radians(peak))
        later = wind.shift(vehicle.time - wind.duration / 2)
        options = {"plane": plane, "frozen": False, "condition": condition, "tolerance": 1e-2}
        computed[peak, plane] = flown_boundary(vehicle, later, 1.0, **options).limit
    assert computed[5.0, "pitch"] < computed[1.0, "pitch"] - 0.02
    assert computed[-5.0, "pitch"] > computed[1.0, "pitch"] + 0.06
    assert computed[1.0, "yaw"] == pytest.approx(0.65, abs=0.015)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"timepts": [1.0, 9.0]}, "wind must not begin before the flight"),
        ({"timepts": [[0.0]]}, "timepts must be one row"),
        ({"deflection_limit": 0.0}, "deflection_limit must be positive"),
        ({"deflection_limit": np.inf}, "deflection_limit must be finite"),
        ({"plane": "roll"}, "plane must be one of"),
        ({"control": 3.0}, "control must be a Law"),
        ({"rate_limit": 0.1}, "belong to a law"),
        ({"wind": tv.SampledWind(time=[0, 1], angle=[[0.0, 0.1]] * 2)}, "wind must be one wind"),
        ({"vehicle": tv.load_vehicle(NAMES[0]).replace(thrust=[2e6, 3e6])}, "must be one vehicle"),
        ({"vehicle": "configuration-i"}, "vehicle must be a Vehicle"),
    ],
)
def test_what_cannot_fly_is_refused(change, words):
    vehicle, wind = case(NAMES[0])
    options = {
        "vehicle": vehicle,
        "control": ReportControl(),
        "wind": wind,
        "timepts": [0.0, 9.0],
        "deflection_limit": 2e-3,
    }
    with pytest.raises(InputError, match=words):
        fly_planar(**options | change)


class Late(tv.control.Law):
    """A law that has no answer to more than a third of a degree."""

    def demand(self, seen, states, limit):
        return np.where(np.abs(seen.angle_of_attack) < 0.006, 0.0 * seen.attitude, np.nan)


@pytest.mark.parametrize("engine", ["planar", "sixdof"])
def test_a_flight_whose_numbers_are_lost_says_when_and_which(engine):
    """The wind is at 0.006 rad after a third of its first half."""
    vehicle, wind = case(NAMES[0])
    fly = {"planar": fly_planar, "sixdof": tv.fly_sixdof}[engine]
    if engine == "sixdof":
        pytest.importorskip("jsbsim")
    with pytest.raises(
        InputError, match="the flight fails (at|near) t = 1.[23].* deflection"
    ) as caught:
        fly(vehicle, Late(), wind, [0.0, 8.0], deflection_limit=2e-3)
    assert "not finite" in str(caught.value)


def test_a_condition_belongs_to_parameters_that_vary():
    with pytest.raises(InputError, match="condition must be given exactly when"):
        flown_boundary(*case(NAMES[0]), frozen=False)


def test_nothing_is_warned_of_in_a_flight_that_holds():
    vehicle, wind = case(NAMES[0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fly_planar(vehicle, ReportControl(), wind, [0.0, 8.0], deflection_limit=2e-3)
