"""Feedback of lateral drift and acceleration: margins, loops, flights, against own equations."""

from dataclasses import replace
from typing import NamedTuple

import control
import numpy as np
import pytest
from scipy.integrate import cumulative_simpson, solve_ivp
from scipy.linalg import expm

import tvclin as tv
from tvclin.control import Actuator
from tvclin.control.autopilot.feedback import GAINS
from tvclin.flights.closed_loop.batch import Hardware, one_flight
from tvclin.flights.closed_loop.sampled_stability import linear_delay_margin, linear_gain_margins
from tvclin.vehicle import BendingMode, Structure

LIFT, THRUST, STEERING, SPEED = 11.2, 24.0, 18.5, 640.0
"""Normal force, thrust less drag, and control force, over the mass [m/s^2]; speed [m/s]."""
PLANT = tv.Plant.from_coefficients(
    tv.Coefficients(
        mu_alpha=2.1,
        mu_delta=3.9,
        C1=(THRUST + LIFT) / SPEED,
        b1=(THRUST + LIFT + 2.1 / 3.9 * STEERING) / SPEED,
        b2=THRUST / SPEED,
        velocity=SPEED,
    )
)
LOOP = tv.Autopilot(
    attitude_gain=1.25,
    rate_gain=0.62,
    drift_rate_gain=8e-4,
    drift_gain=5e-4,
    actuator=Actuator(natural_frequency=60.0, damping=0.7),
    delay=0.015,
)
ALL = replace(LOOP, acceleration_gain=2e-3, acceleration_station=4.0, accelerometer_bandwidth=80.0)
MARGINS = ("aero_margin_dB", "gain_increase_dB", "phase_margin_deg", "delay_margin")


def test_margins_and_poles_of_a_loop_with_drift_are_those_of_a_launcher_course():
    with_drift = [getattr(LOOP.margins(PLANT), name) for name in MARGINS]
    assert with_drift == pytest.approx([6.0146, 24.3638, 42.2547, 0.3247], rel=1e-5)
    without = replace(LOOP, drift_rate_gain=0.0, drift_gain=0.0)
    assert [getattr(without.margins(PLANT), name) for name in MARGINS] == pytest.approx(
        [7.0279, 24.312, 42.9645, 0.325617], rel=1e-5
    )
    poles = replace(LOOP, actuator=None, delay=0.0).closed_loop_poles(PLANT)
    expected = [-1.149188 + 1.101661j, -0.079912 + 0.168414j]
    assert sorted(poles[poles.imag > 0], key=abs, reverse=True) == pytest.approx(expected, abs=1e-6)


class Case(NamedTuple):
    """A plant, its autopilot, and A, B ``(n,)`` and feedback k ``(n,)`` of own equations."""

    plant: tv.Plant | tv.FlexiblePlant
    autopilot: tv.Autopilot
    A: np.ndarray
    B: np.ndarray
    row: np.ndarray
    vehicle: tv.Vehicle


def drawn(seed: int, modes: int) -> Case:
    """Return a random vehicle and autopilot, and x' = A x + B u, u = k x, from eq (B5) by hand.

    The states are attitude, its rate, path, drift, accelerometer, nozzle and its rate, and
    amplitude and rate of each mode.
    """
    rng = np.random.default_rng(seed)
    v = tv.load_vehicle("made-up-booster").rigid
    names = ("thrust", "normal_force_slope", "moment_of_inertia", "velocity", "axial_force")
    v = v.replace(**{name: getattr(v, name) * rng.uniform(0.6, 1.5) for name in names})
    v = v.replace(attitude=rng.uniform(0.4, 1.5), pitch_damping=rng.uniform(0, 0.1) * 2e7)
    shapes = rng.uniform(-1.0, 1.0, (modes, 8))
    bending = tuple(
        BendingMode(
            frequency=rng.uniform(8.0, 60.0),
            damping=rng.uniform(0.002, 0.02),
            modal_mass=v.mass * rng.uniform(0.2, 3.0),
            gimbal_displacement=s[0],
            gimbal_slope=0.1 * s[1],
            attitude_slope=0.1 * s[2],
            rate_slope=0.1 * s[3],
            pressure_displacement=s[4],
            drift_displacement=s[5],
            accelerometer_displacement=s[6],
            accelerometer_slope=0.1 * s[7],
        )
        for s in shapes
    )
    follows = bool(rng.integers(2))
    B_ratio = v.normal_force_slope * v.aerodynamic_arm / (v.control_force * v.control_arm)
    gains = {
        "attitude_gain": abs(B_ratio) * rng.uniform(1.5, 5.0),
        "rate_gain": abs(B_ratio) * rng.uniform(0.5, 5.0),
        "alpha_gain": rng.uniform(0.0, 0.3),
        "drift_rate_gain": rng.uniform(0, 1) * 1e-3,
        "drift_gain": rng.uniform(0, 1) * 1e-4,
        "acceleration_gain": rng.uniform(-1, 1) * 1e-2,
        "acceleration_station": rng.uniform(-10, 20),
        "accelerometer_bandwidth": rng.uniform(20, 200),
    }
    servo = Actuator(natural_frequency=rng.uniform(20, 80), damping=rng.uniform(0.4, 1.2))
    autopilot = tv.Autopilot(**gains, actuator=servo, delay=rng.uniform(0.0, 0.06))
    return own_case(v, bending, follows, autopilot)


def own_case(v: tv.Vehicle, bending: tuple, follows: bool, autopilot: tv.Autopilot) -> Case:
    """Return a vehicle with modes and its autopilot, and own equations as `drawn`."""
    modes, servo = len(bending), autopilot.actuator
    mass, inertia, speed = v.mass, v.moment_of_inertia, v.velocity
    plant = (
        tv.FlexiblePlant.from_vehicle(v, Structure(bending=bending, thrust_follows=follows))
        if modes
        else tv.Plant.from_vehicle(v)
    )
    n = 7 + 2 * modes
    x = np.eye(n)
    theta, rate, path, drift, felt, nozzle, nozzle_rate = x[:7]
    eta, eta_rate = x[7::2], x[8::2]
    alpha = theta - path
    lift, steering = v.normal_force_slope * alpha, v.control_force * nozzle

    def bending_at(name: str, amplitudes: np.ndarray = eta) -> np.ndarray:
        """Return the sum of amplitudes times a displacement or slope of the modes."""
        shape = np.array([getattr(mode, name) for mode in bending])
        return shape @ amplitudes

    bent, moved = (follows * bending_at(f"gimbal_{what}") for what in ("slope", "displacement"))
    across = ((v.thrust - v.axial_force) * theta + lift + steering + v.thrust * bent) / mass
    slowing = (v.thrust - v.axial_force) / mass - 9.80665 * np.sin(v.attitude)
    turning = lift * v.aerodynamic_arm - steering * v.control_arm - v.pitch_damping * rate
    turning = (turning - v.thrust * (v.control_arm * bent + moved)) / inertia
    shaking = np.array(
        [
            (lift * mode.pressure_displacement + steering * mode.gimbal_displacement)
            / mode.modal_mass
            - mode.frequency**2 * a
            - 2 * mode.damping * mode.frequency * b
            for mode, a, b in zip(bending, eta, eta_rate, strict=True)
        ]
    ).reshape(modes, n)
    axial = (v.thrust - v.axial_force) / mass
    local = across + autopilot.acceleration_station * turning - axial * theta
    local = local + bending_at("accelerometer_displacement", shaking)
    local = local - axial * bending_at("accelerometer_slope")
    drifting = speed * path + bending_at("drift_displacement", eta_rate)
    w = servo.natural_frequency
    A = np.zeros((n, n))
    A[:7] = [
        rate,
        turning,
        (across - slowing * path) / speed,
        drifting,
        autopilot.accelerometer_bandwidth * (local - felt),
        nozzle_rate,
        -(w**2) * nozzle - 2 * servo.damping * w * nozzle_rate,
    ]
    for k in range(modes):
        A[7 + 2 * k], A[8 + 2 * k] = eta_rate[k], shaking[k]
    B = w**2 * nozzle_rate
    row = autopilot.attitude_gain * (theta + bending_at("attitude_slope"))
    row = row + autopilot.rate_gain * (rate + bending_at("rate_slope", eta_rate))
    row = row + autopilot.alpha_gain * alpha + autopilot.drift_rate_gain * drifting
    row = row + autopilot.drift_gain * drift + autopilot.acceleration_gain * felt
    return Case(plant, autopilot, A, B, row, v)


OMEGA = np.geomspace(0.01, 300.0, 40)


def check_loop(seed: int, modes: int) -> None:
    """Assert that the continuous loop is that of own equations."""
    case = drawn(seed, modes)
    result = case.autopilot.frequency_response(case.plant, OMEGA)
    s = 1j * OMEGA[:, np.newaxis, np.newaxis]
    own = -np.linalg.solve(s * np.eye(len(case.A)) - case.A, case.B[:, np.newaxis])[..., 0]
    expected = own @ case.row * np.exp(-1j * OMEGA * case.autopilot.delay)
    assert np.abs(result / expected - 1.0).max() < 1e-6
    ideal = replace(case.autopilot, delay=0.0)
    closed = np.linalg.eigvals(case.A + np.outer(case.B, case.row))
    poles = ideal.closed_loop_poles(case.plant)
    order = np.lexsort((closed.imag, closed.real.round(6)))
    assert len(poles) == len(closed)
    distance = np.abs(poles[:, np.newaxis] - closed[order]).min(axis=0)
    assert np.all(distance < 1e-6 * np.maximum(np.abs(closed[order]), 0.1))


def check_sampled_loop(seed: int, modes: int) -> None:
    """Assert that the sampled loop is that of own equations, stepped by their exponentials."""
    case = drawn(seed, modes)
    rng = np.random.default_rng(seed)
    h = rng.uniform(0.005, 0.04)
    late, part = int(rng.integers(0, 4)), rng.uniform(0.0, 1.0)
    sampled = replace(case.autopilot, sample_rate=1.0 / h, delay=(late + part) * h)
    omega = np.geomspace(0.01, 0.99 * np.pi / h, 40)
    n = len(case.A)
    generator = np.zeros((n + 1, n + 1))
    generator[:n, :n], generator[:n, n] = case.A, case.B
    first, second = expm(generator * part * h), expm(generator * (1.0 - part) * h)
    F = second[:n, :n] @ first[:n, :n]
    old, new = second[:n, :n] @ first[:n, n], second[:n, n]
    expected = []
    for z in np.exp(1j * omega * h):
        driven = (new + old / z) * z**-late
        expected.append(-case.row @ np.linalg.solve(z * np.eye(n) - F, driven))
    result = sampled.frequency_response(case.plant, omega)
    assert np.abs(result / np.array(expected) - 1.0).max() < 1e-6


def over_a_flight(case: Case) -> tuple[tv.FlightSchedule, tv.control.GainSchedule]:
    """Return a flight of 20 s whose mass, speed and modes change, and gains that fall."""
    vehicle, structure = case.vehicle, case.plant.structure
    changes = {"weight": 0.8, "velocity": 1.2, "moment_of_inertia": 0.9}
    ends = {name: getattr(vehicle, name) * np.array([1.0, x]) for name, x in changes.items()}
    flown = vehicle.replace(time=np.array([0.0, 20.0]), **ends)
    bending = tuple(
        replace(mode, frequency=mode.frequency * np.array([1.0, 1.1])) for mode in structure.bending
    )
    bent = tv.ascent.StructureSchedule(
        [0.0, 20.0], replace(structure, bending=bending), ("first", "second")
    )
    names = [name for name in GAINS if getattr(case.autopilot, name)]
    gains = {name: getattr(case.autopilot, name) * np.array([1.0, 0.8]) for name in names}
    schedule = tv.control.GainSchedule([0.0, 20.0], replace(case.autopilot, **gains))
    return tv.FlightSchedule(flown, structure=bent), schedule


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [1, pytest.param(4, marks=pytest.mark.thorough)])
def test_scheduled_gains_of_drift_and_their_bands_are_those_of_own_equations(seed):
    base = drawn(seed, 2)
    flight, schedule = over_a_flight(base)
    vehicle = flight.at(8.0)
    now = {name: getattr(base.autopilot, name) * (1.0 - 0.2 * 8.0 / 20.0) for name in GAINS}
    case = own_case(
        vehicle.rigid,
        vehicle.structure.bending,
        vehicle.structure.thrust_follows,
        replace(base.autopilot, **now),
    )

    def own(omega):
        s = 1j * np.atleast_1d(omega)[:, np.newaxis, np.newaxis]
        x = np.linalg.solve(s * np.eye(len(case.A)) - case.A, case.B[:, np.newaxis])[..., 0]
        return -x @ case.row * np.exp(-1j * np.atleast_1d(omega) * case.autopilot.delay)

    result = schedule.along(flight, 8.0).frequency_response(case.plant, OMEGA)
    assert np.abs(result / own(OMEGA) - 1.0).max() < 1e-6
    swept = tv.control.sweep(flight, schedule, [8.0])
    compared = 0
    for band in swept.modes:
        peak, at = float(band.peak[0]), float(band.peak_frequency[0])
        if np.isfinite(peak):
            compared += 1
            assert np.abs(own(at))[0] == pytest.approx(peak, rel=1e-6)
            # largest near the mode, to the rounding of a summit
            assert np.all(np.abs(own(at * np.array([0.999, 1.001]))) <= peak * (1 + 1e-9))
    assert compared  # a mode may own no frequency
    ideal = replace(schedule, autopilot=replace(schedule.autopilot, delay=0.0))
    closed = np.linalg.eigvals(case.A + np.outer(case.B, case.row))
    poles = tv.control.sweep(flight, ideal, [8.0]).poles[0]
    distance = np.abs(poles[:, np.newaxis] - closed).min(axis=0)
    assert np.all(distance < 1e-6 * np.maximum(np.abs(closed), 0.1))


CASES = [(check, modes) for check in (check_loop, check_sampled_loop) for modes in (0, 2)]


@pytest.mark.parametrize(("check", "modes"), CASES)
def test_loops_of_random_vehicles_are_those_of_own_equations(check, modes):
    for seed in range(8):
        check(seed, modes)


@pytest.mark.thorough
@pytest.mark.parametrize(("check", "modes"), CASES)
def test_loops_of_more_random_vehicles_are_those_of_own_equations(check, modes):
    for seed in range(100, 350):
        check(seed, modes)


def test_a_plant_from_a_state_space_has_the_same_loop_by_its_outputs():
    rows = [PLANT.lateral_rows(name, 4.0) for name in ("drift_rate", "acceleration")]
    A, B, C, D = PLANT.matrices()
    system = control.StateSpace(
        A,
        B,
        np.vstack([C, *(row for row, _ in rows)]),
        np.vstack([D, *(direct for _, direct in rows)]),
        inputs=list(PLANT.inputs),
        outputs=[*PLANT.outputs, "drift_rate", "lateral_acceleration"],
    )
    own = tv.linear.SystemPlant(system, PLANT.coefficients)
    for autopilot in (ALL, replace(ALL, sample_rate=40.0)):
        expected = autopilot.frequency_response(PLANT, OMEGA[:30])
        result = autopilot.frequency_response(own, OMEGA[:30])
        np.testing.assert_allclose(result, expected, rtol=1e-9)
    flights = [
        tv.fly(plant, LAW, WIND, np.linspace(0, 20, 41), **HARDWARE, sample_rate=40.0).outputs
        for plant in (PLANT, own)
    ]
    for name in ("attitude", "sensed_drift", "deflection"):
        np.testing.assert_allclose(flights[1][name], flights[0][name], atol=1e-11, rtol=1e-9)
    bare = tv.linear.SystemPlant(PLANT.ss())
    with pytest.raises(tv.InputError, match="plant has no output drift_rate"):
        LOOP.margins(bare)


def test_the_closed_loop_in_turbulence_has_drift_sampled_or_not():
    air = tv.winds.Turbulence(2.0, 500.0)
    computed = []
    for autopilot in (ALL, replace(ALL, sample_rate=400.0, delay=0.015 - 0.5 / 400.0)):
        covariance = tv.control.turbulence_covariance(autopilot, PLANT, air, SPEED)
        names = ("attitude", "sensed_drift_rate", "sensed_drift", "sensed_acceleration")
        computed.append([covariance.rms(name) for name in names])
        assert covariance.rms("sensed_drift_rate") == pytest.approx(
            covariance.rms("drift_rate"), rel=1e-9
        )
    assert computed[1] == pytest.approx(computed[0], rel=1e-3)


def test_a_plant_with_lateral_outputs_has_the_drift_rate_of_turbulence_once():
    air = tv.winds.Turbulence(2.0, 500.0)
    autopilot = tv.design_gains(PLANT, natural_frequency=1.0, damping=0.7)
    plain = tv.control.turbulence_covariance(autopilot, PLANT, air, SPEED)
    plant = tv.linear.lateral_plant(PLANT, station=10.0)
    covariance = tv.control.turbulence_covariance(autopilot, plant, air, SPEED)
    assert covariance.outputs.count("drift_rate") == 1
    assert covariance.rms("drift_rate") == pytest.approx(plain.rms("drift_rate"), rel=1e-9)
    assert any("lateral acceleration" in row[0] for row in covariance.tables()[0].rows)
    moved = tv.linear.lateral_plant(PLANT, position=True)
    history = tv.control.turbulence_history(autopilot, moved, air, SPEED, 5.0)
    plain = tv.control.turbulence_history(autopilot, PLANT, air, SPEED, 5.0)
    assert history.deviation("drift") == pytest.approx(plain.deviation("drift"), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("model", ["drift", "drift-exact"])
@pytest.mark.parametrize("gains", ["rate", "drift", "integral", "acceleration"])
def test_the_steady_drift_is_the_static_gain_of_the_closed_loop(model, gains):
    rng = np.random.default_rng(7)
    for name in ("configuration-i", "made-up-launcher"):
        plant = tv.Plant.from_vehicle(tv.load_vehicle(name).rigid, model)
        more = {
            "rate": {"drift_rate_gain": 3e-4, "alpha_gain": 0.05},
            "drift": {"drift_rate_gain": 3e-4, "drift_gain": 2e-5},
            "integral": {"drift_rate_gain": 3e-4, "integral_gain": 0.02},
            "acceleration": {"acceleration_gain": 2e-3, "acceleration_station": 5.0},
        }[gains]
        pair = {"natural_frequency": rng.uniform(1.0, 1.5), "damping": 0.7}
        autopilot = replace(tv.design_gains(plant, **pair), **more)
        closed = autopilot.close(plant)
        row = closed.find_output("flight_path_angle")
        static = closed.D[row, 0] - closed.C[row] @ np.linalg.solve(closed.A, closed.B[:, 0])
        expected = static * float(plant.coefficients.velocity)
        result = tv.control.steady_drift(autopilot, plant)
        assert result == pytest.approx(expected, rel=1e-8, abs=1e-9)
        assert (result == 0.0) == (gains == "drift")


def test_quadratic_gains_with_weights_on_drift_are_those_of_the_hamiltonian():
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    speed = float(plant.coefficients.velocity)
    weights = {"alpha_weight": 2.0, "drift_rate_weight": 1e-5, "drift_weight": 1e-7}
    made = tv.control.lqr_gains(plant, **weights, deflection_weight=4.0)
    A, B, _, _ = plant.matrices()
    A = np.block([[A, np.zeros((3, 1))], [0.0, 0.0, speed, 0.0]])
    column = np.append(B[:, 0], 0.0)
    alpha, turn = np.array([1.0, 0.0, -1.0, 0.0]), np.array([0.0, 0.0, speed, 0.0])
    Q = np.diag([1.0, 0.0, 0.0, 1e-7]) + 2.0 * np.outer(alpha, alpha) + 1e-5 * np.outer(turn, turn)
    hamiltonian = np.block([[A, -np.outer(column, column) / 4.0], [-Q, -A.T]])
    poles = np.linalg.eigvals(hamiltonian)
    expected = np.sort_complex(poles[poles.real < 0])
    np.testing.assert_allclose(np.sort_complex(made.closed_loop_poles(plant)), expected, rtol=1e-6)
    assert tv.control.steady_drift(made, plant) == 0.0
    rate_only = tv.control.lqr_gains(plant, drift_rate_weight=1e-5)
    assert rate_only.drift_gain == 0.0
    assert rate_only.drift_rate_gain > 0.0


def test_rules_of_a_file_place_the_poles_of_the_drift_or_weigh_it():
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    rule = {"design": "drift-poles", "natural_frequency": 1.2, "drift_frequency": 0.1}
    made = tv.AutopilotDesign(**rule).autopilot(plant)
    pairs = [np.roots([1.0, 1.4 * w, w * w]) for w in (1.2, 0.1)]
    np.testing.assert_allclose(
        np.sort_complex(made.closed_loop_poles(plant)), np.sort_complex(np.concatenate(pairs)),
        rtol=1e-7,
    )  # fmt: skip
    weighed = tv.AutopilotDesign(design="lqr", drift_weight=1e-7).autopilot(plant)
    assert weighed.drift_gain == tv.control.lqr_gains(plant, drift_weight=1e-7).drift_gain > 0.0
    for wrong, sentence in (
        (rule | {"design": "poles"}, "drift_frequency is of gains by design drift-poles"),
        (rule | {"drift_gain": 1e-5}, "drift_gain follows from design drift-poles"),
        ({"design": "drift-poles", "natural_frequency": 1.0}, "needs drift_frequency"),
        (rule | {"drift_frequency": 1.2}, "cannot be placed"),
        ({"design": "canonical", "drift_weight": 1.0}, "drift_weight is of gains by design lqr"),
    ):
        with pytest.raises(tv.InputError, match=sentence):
            tv.AutopilotDesign(**wrong).autopilot(plant)


def test_the_comparison_with_trim_says_how_fast_a_vehicle_drifts_in_a_constant_wind():
    autopilot = replace(LOOP, drift_gain=0.0)
    compared = tv.compare_with_trim(PLANT, autopilot, tv.TriangularWind(peak=0.05, duration=8.0))
    rate = tv.control.steady_drift(autopilot, PLANT)
    assert compared.steady_drift_rate == pytest.approx(0.05 * rate)
    assert any("steady drift" in label for label, _ in compared.motions())


WIND = tv.TriangularWind(peak=0.05, duration=10.0)
HARDWARE = {"deflection_limit": 0.5, "actuator": ALL.actuator}
LAW = tv.SaturatedLaw.of(ALL)


def own_rates(t, x, wind, command=None):
    """Return the rates of attitude, its rate, path, drift, acceleration, nozzle, nozzle rate."""
    theta, rate, path, _, felt, nozzle, nozzle_rate = x
    alpha = theta - path - float(wind(np.array(t)))
    turning = 2.1 * alpha - 3.9 * nozzle
    across = LIFT * alpha + STEERING * nozzle
    if command is None:
        command = own_command(x)
    return [
        rate,
        turning,
        (THRUST * (theta - path) + across) / SPEED,
        SPEED * path,
        80.0 * (across + 4.0 * turning - felt),
        nozzle_rate,
        3600.0 * (command - nozzle) - 84.0 * nozzle_rate,
    ]


def own_command(x):
    """Return the deflection command of ALL."""
    drift = 8e-4 * SPEED * x[2] + 5e-4 * x[3]
    return 1.25 * x[0] + 0.62 * x[1] + drift + 2e-3 * x[4]


LABELS = ("attitude", "attitude_rate", "flight_path_angle", "sensed_drift", "sensed_acceleration")


def assert_same_flight(flown, own):
    """Assert outputs within 1e-7 of their largest values."""
    for label, values in zip((*LABELS, "deflection"), own, strict=False):
        error = np.abs(flown.outputs[label] - values).max()
        assert error < 1e-7 * np.abs(values).max(), label


@pytest.mark.thorough
def test_a_continuous_flight_with_drift_is_the_integral_of_own_equations():
    times = np.linspace(0.0, 25.0, 51)
    own = solve_ivp(
        own_rates, (0.0, 25.0), np.zeros(7), "DOP853", times,
        rtol=1e-10, atol=1e-13, max_step=0.05, args=(WIND,),
    ).y  # fmt: skip
    assert_same_flight(tv.fly(PLANT, LAW, WIND, times, **HARDWARE), own)


def test_drift_and_acceleration_are_outputs_of_any_flight_and_response():
    bare = replace(LAW.autopilot, drift_rate_gain=0.0, drift_gain=0.0, acceleration_gain=0.0)
    plant = tv.linear.lateral_plant(PLANT, station=4.0, position=True)
    rate, times = 400.0, np.linspace(0.0, 12.0, 25)
    flown = tv.fly(plant, tv.SaturatedLaw(bare), WIND, times, **HARDWARE, sample_rate=rate).outputs
    angles = [flown[name] for name in ("attitude", "flight_path_angle", "deflection")]
    theta, path, nozzle = angles
    alpha = theta - path - WIND(times)
    np.testing.assert_allclose(flown["drift_rate"], SPEED * path, rtol=1e-9, atol=1e-12)
    felt = LIFT * alpha + STEERING * nozzle + 4.0 * (2.1 * alpha - 3.9 * nozzle)
    np.testing.assert_allclose(flown["lateral_acceleration"], felt, rtol=1e-9, atol=1e-12)
    fine = np.linspace(0.0, 12.0, 4801)
    whole = tv.fly(plant, tv.SaturatedLaw(bare), WIND, fine, **HARDWARE, sample_rate=rate).outputs
    expected = cumulative_simpson(whole["drift_rate"], x=fine, initial=0.0)
    np.testing.assert_allclose(whole["drift"], expected, rtol=1e-6, atol=1e-7)
    closed = replace(bare, actuator=ALL.actuator).wind_response(plant, WIND)
    assert {"drift_rate", "drift", "lateral_acceleration"} <= set(closed.labels)
    values = dict(zip(closed.labels, closed(times), strict=True))
    np.testing.assert_allclose(values["drift_rate"], flown["drift_rate"], atol=0.02)


def test_a_sampled_flight_with_drift_is_the_integral_of_own_equations():
    h, states = 0.05, [np.zeros(7)]
    for k in range(240):
        span = (k * h, (k + 1) * h)
        command = own_command(states[-1])
        step = solve_ivp(
            own_rates, span, states[-1], "DOP853", rtol=1e-10, atol=1e-14, args=(WIND, command)
        )
        states.append(step.y[:, -1])
    times = h * np.arange(241)
    flown = tv.fly(PLANT, LAW, WIND, times, **HARDWARE, sample_rate=1.0 / h)
    assert_same_flight(flown, np.array(states).T)
    many = tv.flights.fly_many(PLANT, LAW, WIND, **HARDWARE, sample_rate=1.0 / h)
    assert many.peak_attitude == pytest.approx(np.abs(np.array(states)[:, 0]).max(), rel=1e-7)


@pytest.mark.thorough
def test_a_planar_flight_with_drift_is_linear_in_a_small_wind():
    vehicle = tv.load_vehicle("configuration-i")
    gains = replace(
        tv.design_gains(vehicle, natural_frequency=1.2, damping=0.7),
        **{"drift_rate_gain": 2e-4, "drift_gain": 1e-5, "acceleration_gain": 1e-3},
        **{"acceleration_station": 5.0, "accelerometer_bandwidth": 50.0},
    )
    law, times = tv.SaturatedLaw(gains), np.linspace(0.0, 30.0, 31)
    wind = tv.TriangularWind(peak=1e-5, duration=8.0)
    options = {"deflection_limit": 0.1, "actuator": Actuator()}
    planar = tv.fly_planar(vehicle, law, wind, times, **options).outputs
    plant = tv.Plant.from_vehicle(vehicle, "drift-and-speed")
    linear = tv.fly(plant, law, wind, times, **options).outputs
    for name in ("attitude", "flight_path_angle", "deflection"):
        size = np.abs(linear[name]).max()
        assert np.abs(planar[name] - linear[name]).max() < 1e-4 * size


@pytest.mark.thorough
def test_linear_margins_of_a_sampled_flight_with_drift_are_those_of_the_loop():
    vehicle = tv.load_vehicle("configuration-i")
    plant = tv.Plant.from_vehicle(vehicle)
    gains = replace(
        tv.design_gains(vehicle, natural_frequency=1.2, damping=0.7),
        **{"drift_rate_gain": 2e-4, "drift_gain": 1e-5, "acceleration_gain": 1e-3},
    )
    hardware = Hardware(0.04, 0.01, Actuator())
    flight = one_flight(plant, tv.SaturatedLaw(gains), WIND, 0.1, hardware)
    pole = float(plant.coefficients.pole)
    fall, rise = linear_gain_margins(flight, "gain", pole)
    loop = replace(gains, actuator=Actuator(), sample_rate=25.0, delay=0.01).margins(plant)
    assert 20 * np.log10(fall) == pytest.approx(loop.aero_margin_dB, rel=1e-6)
    assert 20 * np.log10(rise) == pytest.approx(loop.gain_increase_dB, rel=1e-6)
    assert linear_delay_margin(flight, pole) == pytest.approx(loop.delay_margin, rel=1e-6)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: replace(LOOP, integral_gain=0.1), "integral_gain and drift_gain cannot both"),
        (lambda: replace(LOOP, drift_gain=[1e-4, 0.0]), "drift_gain must be zero for all"),
        (lambda: replace(LOOP, accelerometer_bandwidth=0.0), "accelerometer_bandwidth must be"),
        (
            lambda: LOOP.margins(tv.Plant(PLANT.coefficients, "fixed-path")),
            'model "fixed-path" has no lateral drift',
        ),
        (
            lambda: LOOP.margins(tv.Plant(PLANT.coefficients.replace(velocity=0.0), PLANT.model)),
            "need the speed of the vehicle",
        ),
        (
            lambda: tv.fly_sixdof(
                tv.load_vehicle("configuration-i"),
                LAW,
                WIND,
                [0, 15],
                deflection_limit=0.1,
                drift=False,
            ),
            "the path of this flight is fixed",
        ),
        (
            lambda: tv.flights.fly_many(
                PLANT,
                np.array([LAW, tv.SaturatedLaw(replace(LAW.autopilot, acceleration_station=1.0))]),
                WIND,
                deflection_limit=0.5,
                sample_rate=50.0,
            ),
            "their accelerometer at one station",
        ),
    ],
)
def test_what_cannot_be_fed_back_is_refused_in_one_sentence(call, sentence):
    with pytest.raises(tv.InputError, match=sentence):
        call()


def test_a_drift_gain_of_the_wrong_sign_is_warned_of():
    with pytest.warns(UserWarning, match=r"drift_rate_gain = -0\.0008 is positive feedback"):
        replace(LOOP, drift_rate_gain=-8e-4).margins(PLANT)


def test_a_file_gives_the_gains_of_drift_and_acceleration_in_its_units():
    table = {
        "natural_frequency_rad_per_s": 1.2,
        "drift_rate_gain_deg_s_per_m": 0.02,
        "drift_gain_rad_per_m": 1e-5,
        "acceleration_gain_rad_s2_per_m": 1e-3,
        "acceleration_station_ft": 10.0,
        "accelerometer_bandwidth_Hz": 10.0,
    }
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    made = tv.AutopilotDesign.from_table(table).autopilot(plant)
    assert made.drift_rate_gain == pytest.approx(np.radians(0.02))
    assert (made.drift_gain, made.acceleration_gain) == (1e-5, 1e-3)
    assert made.acceleration_station == pytest.approx(3.048)
    assert made.accelerometer_bandwidth == pytest.approx(2 * np.pi * 10.0)


GAINS_IN_STATE_SPACE = tv.control.SystemAutopilot(
    control.StateSpace(
        [],
        [],
        [],
        [[1.25, 0.62, 8e-4, 5e-4, 2e-3]],
        inputs=["attitude", "attitude_rate", "drift_rate", "drift", "lateral_acceleration"],
        outputs=["deflection_command"],
    ),
    actuator=ALL.actuator,
    delay=ALL.delay,
    acceleration_station=ALL.acceleration_station,
    accelerometer_bandwidth=ALL.accelerometer_bandwidth,
)


@pytest.mark.thorough
@pytest.mark.parametrize("rate", [None, 40.0])
@pytest.mark.parametrize("own", [False, True], ids=["plant", "plant with lateral outputs"])
def test_a_controller_that_reads_drift_and_acceleration_is_that_of_gains(rate, own):
    plant = tv.linear.lateral_plant(PLANT, station=4.0, position=True) if own else PLANT
    gains, controller = (replace(a, sample_rate=rate) for a in (ALL, GAINS_IN_STATE_SPACE))
    expected = [getattr(gains.margins(PLANT), name) for name in MARGINS]
    assert [getattr(controller.margins(plant), name) for name in MARGINS] == pytest.approx(
        expected, rel=1e-9
    )
    if rate is None and own:
        return  # a plant from matrices is flown by samples
    times = np.linspace(0.0, 20.0, 21)
    by_gains, flown = (
        tv.fly(one, law, WIND, times, **HARDWARE, sample_rate=rate).outputs
        for one, law in ((PLANT, LAW), (plant, tv.control.SystemLaw(controller)))
    )
    for name in (*LABELS[:1], "sensed_drift", "deflection"):
        error = np.abs(flown[name] - by_gains[name]).max()
        assert error < 1e-9 * np.abs(by_gains[name]).max(), name


@pytest.mark.thorough
def test_flown_margins_and_many_flights_of_a_controller_with_drift_are_those_of_gains():
    law = tv.control.SystemLaw(GAINS_IN_STATE_SPACE)
    many, expected = (
        tv.fly_many(
            PLANT, one, WIND, **HARDWARE | {"deflection_limit": [0.02, 0.5]}, sample_rate=40
        )
        for one in (law, LAW)
    )
    assert many.status.tolist() == expected.status.tolist() == ["lost", "survived"]
    np.testing.assert_allclose(many.peak_attitude, expected.peak_attitude, rtol=1e-9)
    hardware = Hardware(0.04, 0.01, ALL.actuator)
    flight, by_gains = (one_flight(PLANT, one, WIND, 0.1, hardware) for one in (law, LAW))
    pole = float(PLANT.coefficients.pole)
    assert linear_gain_margins(flight, "gain", pole) == pytest.approx(
        linear_gain_margins(by_gains, "gain", pole), rel=1e-9
    )
    assert linear_delay_margin(flight, pole) == pytest.approx(
        linear_delay_margin(by_gains, pole), rel=1e-9
    )


def test_a_controller_that_reads_drift_is_refused_where_there_is_none():
    still = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=2.1, mu_delta=3.9), "fixed-path")
    with pytest.raises(tv.InputError, match="drift|path|velocity"):
        GAINS_IN_STATE_SPACE.margins(still)
    with pytest.raises(tv.InputError, match="steady_drift is of gains"):
        tv.control.steady_drift(GAINS_IN_STATE_SPACE, PLANT)
    assert tv.compare_with_trim(PLANT, GAINS_IN_STATE_SPACE, WIND).steady_drift_rate is None
