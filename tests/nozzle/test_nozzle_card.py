"""What a motion asks of a nozzle, against formulas, integrals and the equations of motion."""

from itertools import pairwise

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad, simpson, solve_ivp

import tvclin as tv
from tests.turns import usual
from tvclin.case.flexible_autopilot import specified_law
from tvclin.flights.closed_loop.fly import fly_nozzle
from tvclin.nozzle.duty import Motion, duty_of_motion
from tvclin.nozzle.duty_over_flight import FlownDuty
from tvclin.studyfile.study_plan import StudyPlan

PER_DEGREE = 180.0 / np.pi
BENCH = tv.case.NozzleData(
    engine=tv.vehicle.Engine(mass=1.0, arm=0.0, moment_of_inertia=1400.0),
    stiffness=15200.0 * PER_DEGREE,
    damping=174.0 * PER_DEGREE,
)


def test_a_sine_asks_for_what_its_phasor_says():
    times = np.linspace(0.0, 1.0, 60_001)
    card = tv.nozzle.nozzle_duty(times, np.radians(np.sin(6.0 * np.pi * times)), nozzle=BENCH)
    work = card.work
    X, w = np.radians(1.0), 6.0 * np.pi
    torque = X * np.hypot(BENCH.stiffness - 1400.0 * w**2, BENCH.damping * w)
    assert torque == pytest.approx(7296.9, abs=0.05)
    assert abs(work.torque.value) == pytest.approx(torque, rel=1e-5)
    assert work.rms_torque == pytest.approx(torque / np.sqrt(2.0), rel=1e-5)
    assert work.power.value == pytest.approx(1739.8, abs=0.05)
    assert work.energy - work.returned == pytest.approx(539.5, abs=0.05)  # of one second
    assert card.rate.value == pytest.approx(X * w, rel=1e-6)
    assert abs(card.acceleration.value) == pytest.approx(X * w**2, rel=1e-5)
    assert card.travel == pytest.approx(12.0 * X, rel=1e-6)
    assert card.reversals == 6
    assert card.rms_rate == pytest.approx(X * w / np.sqrt(2.0), rel=1e-6)


def ramp(t):
    """One degree at 2 deg/s with 20 deg/s2, from rest to rest: deflection and its rate [deg]."""
    rate = 20.0 * np.minimum(np.minimum(t, 0.1), 0.6 - t)
    early, late = 10.0 * t**2, 1.0 - 10.0 * (0.6 - t) ** 2
    return np.where(t < 0.1, early, np.where(t < 0.5, 0.1 + 2.0 * (t - 0.1), late)), rate


@pytest.mark.parametrize(
    ("friction", "expected"),
    [(0.0, [14731.2, 489.67, 138.31]), (2000.0, [16731.2, 559.48, 173.22])],
)
def test_a_ramp_asks_for_what_is_integrated_of_its_parts(friction, expected):
    nozzle = tv.case.NozzleData(**vars(BENCH) | {"friction": friction})
    times = np.linspace(0.0, 0.6, 30_001)
    work = tv.nozzle.nozzle_duty(times, np.radians(ramp(times)[0]), nozzle=nozzle).work
    computed = [work.torque.value, work.power.value, work.energy]
    assert computed == pytest.approx(expected, rel=1e-4)  # a corner lies between two times

    def power(t):
        angle, rate = np.radians(ramp(t))
        bend = np.radians(20.0 * ((t < 0.1) - 1.0 * (t > 0.5)))
        torque = 1400.0 * bend + BENCH.stiffness * angle + BENCH.damping * rate + friction
        return max(float(torque * rate), 0.0)

    assert work.energy == pytest.approx(quad(power, 0.0, 0.6, points=[0.1, 0.5])[0], rel=1e-5)


def test_the_torque_in_flight_is_that_of_lagrange():
    """A body under thrust with an engine that turns on it, linear in all angles, by sympy."""
    t = sp.Symbol("t")
    m, whole, lc, mE, lE, IE, ax = sp.symbols("m I l_c m_E l_E I_E a_x", positive=True)
    y, theta, delta = (sp.Function(name)(t) for name in ("y", "theta", "delta"))
    hinge = y - lc * theta  # of the whole, engine straight
    tail = hinge - lE * (theta + delta)
    # the rest of the vehicle, so that mass, centre and inertia of the whole are m, 0 and I
    rest, at = m - mE, -mE * (-(lc + lE)) / (m - mE)
    own = whole - IE - mE * (lc + lE) ** 2 - rest * at**2
    kinetic = (
        rest * (y + at * theta).diff(t) ** 2
        + own * theta.diff(t) ** 2
        + mE * tail.diff(t) ** 2
        + IE * (theta + delta).diff(t) ** 2
    ) / 2
    # in a frame that is accelerated by a_x along the path, masses weigh a_x aft: the engine's
    # centre is l_E (1 - cos(theta + delta)) and the hinge l_c (1 - cos theta) less far aft
    height = mE * lE * (theta + delta) ** 2 / 2 + (mE * lc - rest * at) * theta**2 / 2
    L = kinetic - ax * height
    moment = L.diff(delta.diff(t)).diff(t) - L.diff(delta)
    JE, sE = IE + mE * lE**2, mE * lE
    normal = (y.diff(t, 2) - ax * theta) - lc * theta.diff(t, 2)  # felt, across the body
    ours = JE * (delta.diff(t, 2) + theta.diff(t, 2)) + sE * (ax * delta - normal)
    assert sp.simplify(sp.expand(moment - ours)) == 0


def test_a_flight_s_torque_has_every_term():
    vehicle = tv.load_vehicle("configuration-i")
    engine = tv.vehicle.Engine(mass=2000.0, arm=0.8, moment_of_inertia=300.0)
    data = {"stiffness": 1e5, "damping": 1e4, "friction": 500.0}
    nozzle = tv.case.NozzleData(engine=engine, offset=0.01, thrust_offset=0.002, **data)
    times = np.linspace(0.0, 2.0, 2001)
    delta, theta, alpha = 0.01 * times**2, 0.003 * times**2, 0.02 * times
    computed = tv.nozzle.nozzle_duty(
        times, delta, nozzle=nozzle, vehicle=vehicle, angle_of_attack=alpha, attitude=theta
    ).work.torque
    T, m, F = vehicle.thrust, vehicle.mass, vehicle.axial_force
    JE, sE, at = 300.0 + 2000.0 * 0.64, 1600.0, computed.time
    a_x = (T - F) / m
    a_n = (vehicle.normal_force_slope * 0.02 * at + T * 0.01 * at**2) / m
    a_n -= vehicle.control_arm * 0.006
    expected = JE * 0.026 + sE * (a_x * 0.01 * at**2 - a_n) + 1e4 * 0.02 * at
    expected += 1e5 * 0.01 * at**2 + 500.0 + 2000.0 * a_x * 0.01 + T * 0.002
    assert computed.value == pytest.approx(expected, rel=1e-6)


def test_time_at_the_stop_and_the_steady_rate():
    times = np.linspace(0.0, 4.0, 4001)
    delta = np.clip(0.01 * times, 0.0, 0.02) - np.clip(0.01 * (times - 3.0), 0.0, 1.0)
    card = tv.nozzle.nozzle_duty(times, delta, limit=0.02, window=1.5)
    assert card.time_at_stop == pytest.approx(1.0, abs=0.005)
    assert card.steady_rate == pytest.approx(0.01, rel=1e-9)
    assert card.reversals == 1
    assert card.work is None
    assert "torque, power and energy need" in card.notes[0]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"times": [0.0, 0.0, 1.0]}, "each after"),
        ({"deflection": [0.0, 1.0]}, "row of 3"),
        ({"nozzle": BENCH, "attitude": [0.0, 0.0, 0.0]}, "need a vehicle"),
        ({"limit": 4.0}, "90 degrees"),
    ],
)
def test_what_is_no_motion_is_refused(given, words):
    with pytest.raises(tv.InputError, match=words):
        tv.nozzle.nozzle_duty(**{"times": [0.0, 0.5, 1.0], "deflection": [0.0, 0.01, 0.0]} | given)


STEPS = 10
"""Of the integration below in a sample: steps h of 1 ms are off by a part of (25.1 h)^2/6, 1e-4."""


def by_small_steps(case, law):
    """Vehicle, law and nozzle in steps, by the midpoint rule: rows of time and what moves."""
    A, inputs, C, D = case.plant.matrices()
    servo, limit, most = case.nozzle.actuator, case.nozzle.limit, case.nozzle.rate_limit or np.inf
    w, z, h = servo.natural_frequency, servo.damping, 0.01 / STEPS
    wind, n = case.history, len(A)
    end = float(wind.end) + 15.0 / float(case.plant.coefficients.pole)

    blows = wind(np.arange(2 * int(end / h) + 2) * h / 2.0)

    def moves(k, y, command):
        x, delta, rate = y[:n], y[n], y[n + 1]
        bend = w**2 * (command - delta) - 2.0 * z * w * rate
        if abs(rate) >= most and bend * rate > 0.0:
            bend = 0.0
        return np.concatenate([A @ x + inputs @ [delta, blows[k]], [rate, bend]])

    y, rows = np.zeros(n + 2), []
    for k in range(int(end / h)):
        seen = C @ y[:n] + D @ [y[n], blows[2 * k]]
        of = dict(zip(case.plant.outputs, seen, strict=True))
        if k % STEPS == 0:
            names = tv.control.Measurement._fields[:-1]
            measured = tv.control.Measurement(*(of.get(name, 0.0) for name in names), y[n])
            command = float(np.clip(law.demand(measured, np.zeros(0), limit), -limit, limit))
        first = moves(2 * k, y, command)
        rows.append([k * h, y[n], y[n + 1], first[n + 1], of["angle_of_attack"], first[1]])
        y = y + h * moves(2 * k + 1, y + h / 2.0 * first, command)
        y[n + 1] = np.clip(y[n + 1], -most, most)
    return np.array(rows).T


@pytest.mark.thorough
@pytest.mark.parametrize("rate", usual([None, 0.9], 1))
def test_the_card_of_a_flight_is_that_of_an_integration_by_small_steps(rate):
    """Torque and power by the nozzle's own equation, with friction, offsets and the vehicle."""
    engine = tv.vehicle.Engine(mass=1200.0, arm=1.35, moment_of_inertia=400.0)
    hinge = {"stiffness": 15200.0 * PER_DEGREE, "damping": 174.0 * PER_DEGREE, "friction": 900.0}
    data = tv.case.NozzleData(engine=engine, offset=0.01, thrust_offset=0.002, **hinge)
    most = None if rate is None else np.radians(rate)
    nozzle = tv.Nozzle(limit=np.radians(0.6), rate_limit=most, data=data)
    v = tv.load_vehicle("configuration-i")
    case = tv.Case(vehicle=v, nozzle=nozzle)
    law = tv.control.design_law("trim", case.plant, float(case.history.peak))
    card = FlownDuty.of(case, "trim", law).duty
    t, delta, turns, bend, alpha, swing = by_small_steps(case, law)
    h = t[1]

    # a rate limit is reached a substep late, after which all is a little different: see `fly_many`
    near = {"rel": 1e-3 if rate is None else 1e-2}
    assert card.angle.value == pytest.approx(delta[np.abs(delta).argmax()], **near)
    assert abs(card.rate.value) == pytest.approx(np.abs(turns).max(), **near)
    assert abs(card.acceleration.value) == pytest.approx(np.abs(bend).max(), **near)
    assert card.travel == pytest.approx(np.abs(turns).sum() * h, **near)
    assert card.rms_rate == pytest.approx(np.sqrt(np.mean(turns**2)), **near)

    a_x = (v.thrust - v.axial_force) / v.mass
    a_n = (v.normal_force_slope * alpha + v.thrust * delta) / v.mass - v.control_arm * swing
    JE, sE = 400.0 + 1200.0 * 1.35**2, 1200.0 * 1.35
    torque = JE * (bend + swing) + sE * (a_x * delta - a_n) + hinge["damping"] * turns
    torque += hinge["stiffness"] * delta + 1200.0 * a_x * 0.01 + v.thrust * 0.002
    moving = torque + 900.0 * np.sign(turns)
    still = np.abs(turns) < 1e-6 * np.abs(turns).max()
    assert abs(card.work.torque.value) == pytest.approx(np.abs(moving[~still]).max(), **near)
    assert card.work.power.value == pytest.approx((moving * turns).max(), **near)
    energy = np.maximum(moving * turns, 0.0).sum() * h
    assert card.work.energy == pytest.approx(energy, **near)


QUIET = {"trim": 2.01, "recoverable-attitude": 3.68, "half-relief": 2.16, "autopilot": 4.91}
LOUD = {"trim": 41.0, "recoverable-attitude": 60.0, "half-relief": 74.0, "autopilot": 5.9}


@pytest.mark.parametrize("name", QUIET)
def test_travel_is_that_of_a_simulation_of_its_own(name):
    """Over |B alpha_w,max|, in three digits: tau beta = 4, a nozzle of 4 Hz, a law at 100 Hz.

    Simulated apart from this package; with noise to a tenth. Trim there holds the nose to the path.
    """
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    A, c = np.radians(5.0), plant.coefficients
    BA, duration = abs(float(c.B)) * A, 4.0 / float(c.pole)
    wind = tv.TriangularWind(peak=A, duration=duration)
    limit = BA * (2.0 if name == "autopilot" else 1.2)
    options = {"deflection_limit": limit, "rate_limit": np.inf, "sample_rate": 100.0, "delay": 0.0}
    options["actuator"] = tv.Actuator(natural_frequency=8.0 * np.pi, damping=0.7)
    law = tv.TrimLaw(plant) if name == "trim" else tv.control.design_law(name, plant, A)
    flown = fly_nozzle(plant, law, wind, **options)
    travel = duty_of_motion(Motion.of_flight(flown), limit, 0.5, None, None).travel
    assert travel / BA == pytest.approx(QUIET[name], rel=5e-3)

    if name == "recoverable-attitude":
        law = tv.RecoverableAttitudeLaw(plant, design_peak=A, gain=5.0, reach=0.7)
    noisy = tv.control.WindEstimator(bandwidth=5.0, rate_noise=np.radians(0.1), seed=1)
    law = tv.control.EstimatedLaw(law, noisy, tv.Plant(c, "fixed-path"))
    flown = fly_nozzle(plant, law, wind, **options)
    travel = duty_of_motion(Motion.of_flight(flown), limit, 0.5, None, None).travel
    assert travel / BA == pytest.approx(LOUD[name], rel=0.1)


def between_samples(case, gains, sample_rate, points=200):
    """Deflection, its derivatives, alpha and theta'' by solve_ivp from sample to sample."""
    A, inputs, C, D = case.plant.matrices()
    w, z = case.nozzle.actuator.natural_frequency, case.nozzle.actuator.damping
    wind, n, h = case.history, len(A), 1.0 / sample_rate
    place = case.plant.outputs.index("angle_of_attack")
    end = float(wind.end) + 15.0 / float(case.plant.coefficients.pole)
    y, rows = np.zeros(n + 2), []
    for k in range(int(np.ceil(end / h - 1e-9))):
        command = float(gains @ y[:2])
        jump = (float(wind.end) / h - k) * h  # of the wind, inside this sample or none
        edges = [0.0, *([jump] if 1e-9 < jump < h - 1e-9 else []), h]
        for begin, stop in pairwise(edges):
            blows = float(wind(k * h + (begin + stop) / 2.0))  # a rectangle is even between

            def moves(_, y, command=command, blows=blows):
                bend = w**2 * (command - y[n]) - 2.0 * z * w * y[n + 1]
                turned = A @ y[:n] + inputs[:, 0] * y[n] + inputs[:, 1] * blows
                return np.array([*turned, y[n + 1], bend])

            t = np.linspace(begin, stop, points + 1)
            solved = solve_ivp(moves, (begin, stop), y, "DOP853", t, rtol=1e-5, atol=1e-9)
            x = solved.y
            bend = w**2 * (command - x[n]) - 2.0 * z * w * x[n + 1]
            swing = A[1] @ x[:n] + inputs[1, 0] * x[n] + inputs[1, 1] * blows
            alpha = C[place] @ x[:n] + D[place, 0] * x[n] + D[place, 1] * blows
            rows.append([k * h + t, x[n], x[n + 1], bend, alpha, swing])
            y = x[:, -1]
    return [np.array([row[k] for row in rows]) for k in range(6)]


@pytest.mark.thorough
def test_between_slow_samples_the_card_follows_a_quick_actuator():
    """Samples at 12.5 Hz and an actuator of 20 Hz: it turns and comes to rest between two."""
    engine = tv.vehicle.Engine(mass=1200.0, arm=1.35, moment_of_inertia=400.0)
    hinge = {"stiffness": 15200.0 * PER_DEGREE, "damping": 174.0 * PER_DEGREE, "friction": 2000.0}
    quick = tv.Actuator(natural_frequency=125.6, damping=0.7)
    data = tv.case.NozzleData(engine=engine, **hinge)
    v = tv.load_vehicle("configuration-i")
    case = StudyPlan(
        vehicle=v,
        wind=tv.RectangularWind(peak=np.radians(5.0), duration=7.5),
        nozzle=tv.Nozzle(limit=np.radians(1.0), actuator=quick, data=data),
        design=tv.AutopilotDesign(attitude_gain=0.3, rate_gain=0.3, sample_rate=12.5),
    )
    law = specified_law(case, "autopilot", np.inf)
    card = FlownDuty.of(case, "autopilot", law).duty
    gains = np.array([0.3, 0.3])
    t, delta, turns, bend, alpha, swing = between_samples(case, gains, 12.5)
    a_x = (v.thrust - v.axial_force) / v.mass
    a_n = (v.normal_force_slope * alpha + v.thrust * delta) / v.mass - v.control_arm * swing
    JE, sE = 400.0 + 1200.0 * 1.35**2, 1200.0 * 1.35
    torque = JE * (bend + swing) + sE * (a_x * delta - a_n) + hinge["damping"] * turns
    power = (torque + hinge["stiffness"] * delta + 2000.0 * np.sign(turns)) * turns
    energy = float(simpson(np.maximum(power, 0.0), x=t).sum())
    # a peak between two times: 1 - cos(1/30); what is integrated: (2 * 2/15)^2/24
    assert abs(card.rate.value) == pytest.approx(np.abs(turns).max(), rel=6e-4)
    assert card.work.power.value == pytest.approx(power.max(), rel=2 * 6e-4)
    assert card.work.energy == pytest.approx(energy, rel=3e-3)
    assert card.rms_rate == pytest.approx(
        np.sqrt(simpson(turns**2, x=t).sum() / t[-1, -1]), rel=3e-3
    )
    assert card.travel == pytest.approx(np.abs(np.diff(delta)).sum(), rel=6e-4)
    assert np.degrees(abs(card.rate.value)) == pytest.approx(2.298, abs=2e-3)
    assert card.work.power.value == pytest.approx(457.9, rel=2 * 6e-4)
    assert card.work.energy == pytest.approx(223.0, abs=0.5 + 3e-3 * 223.0)


def test_a_load_between_slow_samples_is_that_of_the_finely_shown_flight():
    """Samples 0.5 s apart, no actuator: the angle of attack peaks between two of them."""
    v, rad = tv.load_vehicle("configuration-i"), np.radians
    wind = tv.TriangularWind(peak=rad(5.0), duration=7.5)
    nozzle = tv.Nozzle(limit=rad(2.0), actuator=None)
    design = tv.AutopilotDesign(attitude_gain=0.4, rate_gain=0.5, sample_rate=2.0)
    case = StudyPlan(vehicle=v, wind=wind, nozzle=nozzle, design=design)
    law = specified_law(case, "autopilot", np.inf)
    result = tv.case.FlownLoad.of(case, "autopilot", law)
    times = np.linspace(0.0, 30.0, 6001)
    options = {"deflection_limit": rad(2.0), "sample_rate": 2.0}
    shown = tv.fly(case.plant, law, wind, times, **options).outputs
    names = (*case.plant.outputs, "deflection")
    alpha = np.abs(np.asarray(shown)[names.index("angle_of_attack")])
    assert result.load == pytest.approx(alpha.max(), rel=2e-3)
    assert result.load > 1.003 * np.abs(alpha[::100]).max()


def test_a_wind_with_more_times_than_a_flight_holds_is_refused_at_once():
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    law = tv.TrimLaw(plant)
    options = {"deflection_limit": 0.1, "rate_limit": np.inf, "delay": 0.0}
    options["actuator"] = tv.Actuator()
    for duration, rate, words in (
        (50_000.0, 100.0, "at most 1000000 samples"),
        (5_000.0, 100.0, "a lower sample rate"),
        (50_000.0, 1.0, "ends earlier$"),
        (7.5e6, 1.0, "at most 100000 s"),
    ):
        wind = tv.TriangularWind(peak=0.09, duration=duration)
        with pytest.raises(tv.InputError, match=words):
            fly_nozzle(plant, law, wind, sample_rate=rate, **options)
