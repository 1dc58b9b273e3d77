"""Gains against closed forms and scipy, schedules, loops of python-control, answers to a wind."""

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import solve_continuous_are, solve_continuous_lyapunov

import tvclin as tv
from tests.turns import usual
from tvclin import Actuator, Autopilot, Coefficients, InputError, Plant
from tvclin.linear.plant import MODELS

COEFFICIENTS = Coefficients(
    mu_alpha=0.28, mu_delta=2.6, C1=0.025, C2=0.0036, b1=0.0284, b2=0.0169, q=1.7e-4
)
FAST = {"natural_frequency": 1.3, "damping": 0.7}
GAINS = {"attitude_gain": 0.3, "rate_gain": 0.4}
OPTIONS = {
    "gains alone": {},
    "alpha": {"alpha_gain": 0.07},
    "integral": {"integral_gain": 0.05},
    "first-order actuator": {"actuator": Actuator(natural_frequency=15.0, damping=None)},
    "delay": {"delay": 0.05, "pade_order": 3},
    "short delay": {"delay": 0.005},
    "everything": {
        "alpha_gain": 0.07,
        "integral_gain": 0.05,
        "actuator": Actuator(),
        "delay": 0.04,
    },
}
EACH_MODEL = pytest.mark.parametrize("model", MODELS)
EACH_OPTION = pytest.mark.parametrize("options", OPTIONS.values(), ids=OPTIONS)
BOTH = pytest.mark.parametrize("name", ["configuration-i", "configuration-ii"])


def test_a_vehicle_and_its_plants_have_the_gains_of_their_coefficients() -> None:
    vehicle = tv.load_vehicle("made-up-launcher")
    plant = tv.linear.plant_of(vehicle)
    gains = tv.design_gains(plant.coefficients, **FAST)
    assert plant.structure is not None
    assert gains == tv.design_gains(vehicle, **FAST) == tv.design_gains(plant, **FAST)
    assert gains == tv.design_gains(plant.rigid, **FAST)


def steady(autopilot, plant, output):
    """Return the steady output per wind of the closed loop."""
    closed = autopilot.close(plant)
    return control.dcgain(closed)[closed.find_output(output), closed.find_input("wind")]


def slow_pole(autopilot, plant):
    poles = autopilot.close(plant).poles()
    return poles[np.argmin(np.abs(poles))]


def test_gains_of_a_batch_place_the_poles_of_each():
    mu_alpha, frequency = np.array([0.1, 0.28, -0.4]), np.array([[1.0], [2.0]])
    c = Coefficients(mu_alpha=mu_alpha, mu_delta=[2.0, 2.6, -3.0])
    made = tv.design_gains(c, natural_frequency=frequency, damping=0.6)
    assert made.batch == (2, 3)
    for i, j in np.ndindex(2, 3):
        rate, stiffness = (
            c.mu_delta[j] * made.rate_gain[i, j],
            c.mu_delta[j] * made.attitude_gain[i, j],
        )
        poles = np.roots([1, rate, stiffness - mu_alpha[j]])
        expected = frequency[i, 0] * (-0.6 + 0.8j)
        np.testing.assert_allclose(np.sort_complex(poles), [expected.conjugate(), expected])
    unstable = Coefficients(mu_alpha=[0.1, 0.28], mu_delta=2.6)
    canonical = tv.control.canonical_gains(unstable)
    for a0, a1, mu in zip(canonical.attitude_gain, canonical.rate_gain, [0.1, 0.28], strict=True):
        poles = np.roots([1, 2.6 * a1, 2.6 * a0 - mu])
        np.testing.assert_allclose(np.abs(poles), np.sqrt(mu))
        np.testing.assert_allclose(poles.real, -np.sqrt(mu) / 2)


@pytest.mark.parametrize("ratio", [0.0, 0.4, 1.0, 1.2])
@pytest.mark.parametrize(("mu_alpha", "mu_delta"), [(0.28, 2.6), (0.28, -2.6), (-0.4, 2.6)])
def test_relief_leaves_the_ratio_asked_for_as_angle_of_attack(ratio, mu_alpha, mu_delta):
    c = Coefficients(mu_alpha=mu_alpha, mu_delta=mu_delta)
    plant = Plant.from_coefficients(c)
    relief = tv.control.relief_gains(c, **FAST, alpha_ratio=ratio)
    angle = steady(relief, plant, "angle_of_attack")
    np.testing.assert_allclose(angle, -ratio, atol=1e-12)
    poles = relief.close(plant).poles()
    np.testing.assert_allclose(np.abs(poles), 1.3, rtol=1e-9)
    np.testing.assert_allclose(poles.real, -0.7 * 1.3, rtol=1e-9)


def test_pure_attitude_hold_has_more_than_the_wind_as_angle_of_attack():
    hold = tv.design_gains(COEFFICIENTS, **FAST)
    ratio = hold.attitude_gain / (hold.attitude_gain - COEFFICIENTS.B)
    assert ratio > 1
    assert ratio == pytest.approx(1 + 0.28 / 1.3**2, rel=1e-12)
    assert steady(hold, Plant(COEFFICIENTS, "fixed-path"), "angle_of_attack") == pytest.approx(
        -ratio, rel=1e-12
    )
    same = tv.control.relief_gains(COEFFICIENTS, **FAST, alpha_ratio=ratio)
    assert same.attitude_gain == pytest.approx(hold.attitude_gain, rel=1e-12)
    assert same.alpha_gain == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.9])
def test_the_slow_pole_is_right_to_first_order_in_the_drift(ratio):
    relief = tv.control.relief_gains(COEFFICIENTS, **FAST, alpha_ratio=ratio)
    errors = []
    for small in (1e-1, 1e-2):
        drift = {name: small * getattr(COEFFICIENTS, name) for name in ("C1", "C2", "b1", "b2")}
        plant = Plant.from_coefficients(COEFFICIENTS.replace(**drift), "drift-exact")
        w = drift["C2"] / 0.28
        errors.append(slow_pole(relief, plant) - (w - ratio * (drift["b1"] + w)))
    assert abs(errors[0]) < 1e-3 * 0.1
    assert abs(errors[1]) < 0.012 * abs(errors[0])  # the error is of second order


@BOTH
def test_drift_minimum_keeps_the_flight_path_in_a_steady_wind(name):
    c = Coefficients.from_vehicle(tv.load_vehicle(name))
    plant = Plant.from_coefficients(c, "drift-exact")
    for options in ({}, {"actuator": Actuator(), "delay": 0.02}):
        minimum = tv.control.drift_minimum_gains(c, **FAST, **options)
        assert minimum.close(plant).poles().real.max() < 0
        assert abs(steady(minimum, plant, "flight_path_angle")) < 1e-12
        w = 9.80665 * np.sin(tv.load_vehicle(name).attitude) / tv.load_vehicle(name).velocity
        ratio = (c.b2 + w) / (c.b1 + w)
        assert steady(minimum, plant, "angle_of_attack") == pytest.approx(-ratio, rel=1e-10)
        assert 0 < ratio < 1


@BOTH
def test_drift_minimum_without_drag_and_weight_has_the_textbook_ratio(name):
    v = tv.load_vehicle(name).replace(axial_force=0.0, attitude=0.0)
    c = Coefficients.from_vehicle(v)
    minimum = tv.control.drift_minimum_gains(c, **FAST)
    angle = steady(minimum, Plant.from_coefficients(c, "drift-exact"), "angle_of_attack")
    lift = v.normal_force_slope / v.thrust
    expected = 1 / (1 + lift * (1 + v.aerodynamic_arm / v.control_arm))
    assert -angle == pytest.approx(expected, rel=1e-10)


@BOTH
def test_load_minimum_has_no_angle_of_attack_and_a_path_that_runs_away(name):
    c = Coefficients.from_vehicle(tv.load_vehicle(name))
    minimum = tv.control.load_minimum_gains(c, **FAST)
    assert minimum.attitude_gain == 0.0
    plant = Plant.from_coefficients(c, "drift-exact")
    assert abs(steady(minimum, plant, "angle_of_attack")) < 1e-12
    assert slow_pole(minimum, plant) == pytest.approx(c.C2 / c.mu_alpha, rel=0.05)
    m = minimum.margins(plant)
    assert (m.status, m.unstable_poles) == ("unstable", 1)
    assert minimum.margins(Plant(c, "fixed-path")).stable


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: tv.control.relief_gains(COEFFICIENTS, **FAST, alpha_ratio=-0.1),
            "alpha_ratio must be ze",
        ),
        (
            lambda: tv.control.drift_minimum_gains(COEFFICIENTS.replace(b1=0.0), **FAST),
            "with drift",
        ),
        (
            lambda: tv.control.drift_minimum_gains(COEFFICIENTS.replace(mu_alpha=0.0), **FAST),
            "mu_alpha ot",
        ),
        (
            lambda: tv.control.drift_minimum_gains(COEFFICIENTS.replace(b1=-0.02), **FAST),
            r"no drift-minimum gains: .* b1 \+ w = -0\.00714.* use design_gains instead",
        ),
        (
            lambda: tv.control.drift_minimum_gains(COEFFICIENTS.replace(b2=[0.01, -0.03]), **FAST),
            r"b2 \+ w = -0\.0171.* would have to be positive",
        ),
        (lambda: tv.control.load_minimum_gains(1.0, **FAST), "plant must be a Coefficients"),
        (
            lambda: tv.control.canonical_gains(COEFFICIENTS.replace(mu_alpha=[0.2, -0.4])),
            "aerodynamically unstable vehicle, .* got -0.4 .*give natural_frequency",
        ),
        (
            lambda: tv.design_gains(COEFFICIENTS, natural_frequency=1e200, damping=0.7),
            r"natural_frequency must be between 1e-09 and 1e\+09; got 1e\+200 rad/s",
        ),
        (
            lambda: tv.design_gains(COEFFICIENTS.replace(mu_delta=1e-15), **FAST),
            "attitude_gain must be zero or 1e-30 to",
        ),
        (
            lambda: tv.design_gains(
                COEFFICIENTS.replace(mu_alpha=[0.1, 0.2]), natural_frequency=[1, 2, 3], damping=1
            ),
            "broadcast together",
        ),
    ],
)
def test_gains_that_cannot_be(make, message):
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize("rule", [tv.control.drift_minimum_gains, tv.control.load_minimum_gains])
def test_relief_is_not_softer_than_a_stable_vehicle_itself(rule):
    c = COEFFICIENTS.replace(mu_alpha=[0.28, -1.21], C2=[0.0036, -0.0156])
    for frequency in (1.1 * (1 + 1e-9), 2.0):
        made = rule(c, natural_frequency=frequency, damping=0.7)
        assert np.all(made.attitude_gain + made.alpha_gain > 0)
    with pytest.raises(InputError, match=r"vehicle alone, .* = 1\.1 rad/s: .*; got 1\.05"):
        rule(c, natural_frequency=1.05, damping=0.7)


WEIGHTS = {
    "attitude_weight": 1.5,
    "rate_weight": 0.3,
    "alpha_weight": 2.0,
    "deflection_weight": 5.0,
}


def quadratic(plant):
    """Return A, B, Q, R of the cost in `WEIGHTS` from python-control's own system."""
    system = plant.ss()
    rows = [system.find_output(n) for n in ("attitude", "attitude_rate", "angle_of_attack")]
    seen = system.C[rows]
    return system.A, system.B[:, :1], seen.T @ np.diag([1.5, 0.3, 2.0]) @ seen, np.array([[5.0]])


@pytest.mark.parametrize("model", MODELS[:3])
def test_lqr_gains_are_those_of_the_riccati_equation_and_no_others_cost_less(model):
    plant = Plant.from_coefficients(COEFFICIENTS, model)
    A, B, Q, R = quadratic(plant)
    P = solve_continuous_are(A, B, Q, R)
    made = tv.control.lqr_gains(plant, **WEIGHTS)
    poles = np.sort_complex(np.linalg.eigvals(A - B @ np.linalg.solve(R, B.T @ P)))
    np.testing.assert_allclose(np.sort_complex(made.close(plant).poles()), poles, rtol=1e-9)

    def cost(a0, a1, b0):
        """Sum of the costs from a unit of each state, with delta = a0 theta + a1 theta' + ..."""
        K = np.array([[a0 + b0, a1, -b0][: len(A)]])
        closed = A + B @ K
        assert np.linalg.eigvals(closed).real.max() < 0
        return np.trace(solve_continuous_lyapunov(closed.T, -(Q + K.T @ R @ K)))

    gains = np.array([made.attitude_gain, made.rate_gain, made.alpha_gain])
    minimum = cost(*gains)
    assert minimum == pytest.approx(np.trace(P), rel=1e-9)
    for step in np.vstack([np.eye(3), [1, 1, 0], [1, 0, -0.5]])[: 2 if len(A) == 2 else 5]:
        for size in (0.02, -0.02):
            assert cost(*(gains + size * step)) > minimum * (1 + 1e-6)


def test_lqr_passes_the_other_arguments_on_and_only_ratios_of_weights_count():
    plant = Plant.from_coefficients(COEFFICIENTS, "drift")
    first = tv.control.lqr_gains(plant, alpha_weight=2.0, delay=0.03, actuator=Actuator())
    assert (first.delay, first.actuator) == (0.03, Actuator())
    again = tv.control.lqr_gains(
        plant, attitude_weight=7.0, alpha_weight=14.0, deflection_weight=7.0
    )
    assert again.attitude_gain == pytest.approx(first.attitude_gain, rel=1e-9)
    assert again.alpha_gain == pytest.approx(first.alpha_gain, rel=1e-9)


@pytest.mark.parametrize(
    ("plant", "weights", "message"),
    [
        (Plant(COEFFICIENTS, "drift-and-speed"), {}, "got drift-and-speed"),
        (Plant(COEFFICIENTS.replace(mu_alpha=[0.1, 0.2]), "fixed-path"), {}, r"of shape \(2,\)"),
        (COEFFICIENTS, {}, "plant must be a Plant"),
        (Plant(COEFFICIENTS, "drift"), {"attitude_weight": 0.0}, "a mode of the plant without a c"),
        (Plant(COEFFICIENTS, "drift"), {"attitude_weight": 0, "alpha_weight": 1}, "without a cost"),
        (
            Plant(COEFFICIENTS.replace(mu_alpha=-1.0), "fixed-path"),
            {"attitude_weight": 0},
            "without a cost",
        ),
        (
            Plant(COEFFICIENTS, "fixed-path"),
            {"rate_weight": -1.0},
            "rate_weight must be zero or positive",
        ),
        (
            Plant(COEFFICIENTS, "fixed-path"),
            {"deflection_weight": 0.0},
            "deflection_weight must be positive",
        ),
        (Plant(COEFFICIENTS, "fixed-path"), {"alpha_weight": [1.0, 2.0]}, "alpha_weight must be"),
    ],
)
def test_costs_that_cannot_be(plant, weights, message):
    with pytest.raises(InputError, match=message):
        tv.control.lqr_gains(plant, **weights)


def schedule():
    c = Coefficients(mu_alpha=[0.1, 0.28, 0.2], mu_delta=[2.0, 2.6, 3.0])
    options = {**FAST, "delay": 0.02, "actuator": Actuator()}
    return c, tv.control.GainSchedule.design([40.0, 66.0, 90.0], c, tv.design_gains, **options)


def test_a_schedule_interpolates_in_straight_lines():
    c, made = schedule()
    a0 = (1.3**2 + c.mu_alpha) / c.mu_delta
    np.testing.assert_allclose(made.at([40, 66, 90]).attitude_gain, a0, rtol=1e-15)
    middle = made.at(53.0)
    assert middle.attitude_gain == pytest.approx((a0[0] + a0[1]) / 2, rel=1e-14)
    assert (middle.batch, middle.delay, middle.actuator) == ((), 0.02, Actuator())
    assert made.at(78.0).rate_gain == pytest.approx(
        np.mean(made.autopilot.rate_gain[1:]), rel=1e-14
    )
    held = tv.control.GainSchedule(np.array([0.0, 10.0]), Autopilot(**GAINS))
    assert held.at(3.0) == Autopilot(**GAINS)


def test_the_margins_of_a_schedule_are_those_at_each_time():
    c, made = schedule()
    m = made.margins(Plant.from_coefficients(c))
    assert m.status.tolist() == ["ok"] * 3
    for k, time in enumerate(made.breakpoints):
        one = Plant.from_coefficients(Coefficients(mu_alpha=c.mu_alpha[k], mu_delta=c.mu_delta[k]))
        single = made.at(time).margins(one)
        assert m.phase_margin[k] == pytest.approx(single.phase_margin, rel=1e-11)
        assert m.gain_increase[k] == pytest.approx(single.gain_increase, rel=1e-11)
    falling = tv.control.GainSchedule(
        made.breakpoints, Autopilot(attitude_gain=[0.3, 0.3, 0.3], rate_gain=0.0)
    )
    with pytest.warns(UserWarning, match="rate_gain is zero: nothing damps the attitude"):
        assert falling.margins(Plant.from_coefficients(c)).unstable_poles.tolist() == [0, 0, 0]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: schedule()[1].at(39.9), r"schedule, 40 to 90; got 39\.9"),
        (lambda: schedule()[1].at([50.0, 91.5]), r"schedule, 40 to 90; got 91\.5"),
        (lambda: schedule()[1].at(np.nan), "value must be finite"),
        (
            lambda: tv.control.GainSchedule(np.array([1.0, 1.0]), Autopilot(**GAINS)),
            "rising values of time",
        ),
        (
            lambda: tv.control.GainSchedule(np.array([2.0, 1.0]), Autopilot(**GAINS)),
            "rising values of time",
        ),
        (
            lambda: tv.control.GainSchedule(np.array([1.0]), Autopilot(**GAINS)),
            "two or more rising",
        ),
        (lambda: tv.control.GainSchedule(np.eye(2), Autopilot(**GAINS)), "rising values of time"),
        (
            lambda: tv.control.GainSchedule.design(
                ["a", "b"], COEFFICIENTS, tv.control.canonical_gains
            ),
            "breakpoints must be a number",
        ),
        (lambda: tv.control.GainSchedule(np.arange(3.0), 0.3), "autopilot must be an? Autopilot"),
        (
            lambda: tv.control.GainSchedule(
                np.arange(3.0), Autopilot(attitude_gain=[1, 2], rate_gain=1)
            ),
            r"one gain for each of the 3 breakpoints; got a batch of shape \(2,\)",
        ),
    ],
)
def test_schedules_that_cannot_be(make, message):
    with pytest.raises(InputError, match=message):
        make()


@EACH_OPTION
@EACH_MODEL
def test_the_answer_to_a_triangular_wind_is_that_of_python_control(model, options):
    plant, autopilot = Plant.from_coefficients(COEFFICIENTS, model), Autopilot(**GAINS, **options)
    wind, closed = tv.TriangularWind(peak=-0.1, duration=8.0), autopilot.close(plant)
    times = np.linspace(0, 30, 601)  # 4 s and 8 s are among them
    expected = control.forced_response(closed, times, [wind(times), 0 * times, 0 * times])
    result = autopilot.respond(plant, wind, times)
    assert result.output_labels == closed.output_labels
    np.testing.assert_allclose(result.outputs, expected.outputs, rtol=1e-9, atol=1e-9 * 0.1)
    np.testing.assert_array_equal(autopilot.wind_response(plant, wind)(times), result.outputs)


@pytest.mark.thorough
@pytest.mark.parametrize("model", usual(MODELS, 2))
def test_the_answer_to_a_smooth_gust_is_that_of_an_integrator(model):
    plant = Plant.from_coefficients(COEFFICIENTS, model)
    autopilot = Autopilot(**GAINS, **OPTIONS["everything"])
    gust, closed = tv.OneMinusCosineGust(peak=0.1, duration=6.0), autopilot.close(plant)
    times = np.array([0.3, 2.0, 3.0, 5.9, 6.0, 9.0, 25.0])

    def motion(t, x):
        return closed.A @ x + closed.B[:, 0] * 0.05 * (1 - np.cos(2 * np.pi * t / 6)) * (t < 6)

    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
    rest = np.zeros(closed.nstates)
    first = solve_ivp(motion, (0, 6), rest, t_eval=times[:5], **options)
    second = solve_ivp(motion, (6, 25), first.y[:, -1], t_eval=times[5:], **options)
    wind = 0.05 * (1 - np.cos(2 * np.pi * times / 6)) * (times < 6)
    expected = closed.C @ np.hstack([first.y, second.y]) + closed.D[:, :1] * wind
    result = autopilot.wind_response(plant, gust)(times)
    np.testing.assert_allclose(result, expected, rtol=1e-9, atol=1e-10)


def assert_peaks_of_dense_sampling(autopilot, plant, duration):
    answer = autopilot.wind_response(plant, tv.TriangularWind(peak=-0.1, duration=duration))
    times, step = np.linspace(0, 3 * duration, 12_001, retstep=True)
    wind = np.interp(times, [0, duration / 2, duration], [0, -0.1, 0])
    inputs = [wind, 0 * times, 0 * times]
    sampled = control.forced_response(autopilot.close(plant), times, inputs).outputs
    for label, row in zip(answer.labels, np.asarray(sampled), strict=True):
        value, time = answer.peak(label)
        largest = np.argmax(np.abs(row))
        assert 1 - 1e-9 < value / row[largest] < 1 + 1e-4
        assert abs(time - times[largest]) < 2 * step
        rate = np.abs(np.diff(row)).max() / step
        assert rate * (1 - 1e-9) < answer.peak_rate(label) < rate * 1.02


@EACH_OPTION
def test_the_peaks_of_an_answer_are_those_of_a_dense_sampling(options):
    autopilot = Autopilot(**GAINS, **options)
    assert_peaks_of_dense_sampling(autopilot, Plant(COEFFICIENTS, "drift-exact"), 8.0)


def test_a_fast_mode_that_has_long_died_out_does_not_return_in_a_peak():
    c = Coefficients.from_vehicle(tv.load_vehicle("configuration-i"))
    late = tv.design_gains(c, natural_frequency=1.3, damping=0.3, delay=0.005, actuator=Actuator())
    assert_peaks_of_dense_sampling(late, Plant(c, "fixed-path"), 60.0)


def test_a_jump_of_the_wind_is_a_rate_without_limit():
    wind = tv.RectangularWind(peak=0.1, duration=8.0)
    answer = Autopilot(**GAINS).wind_response(Plant(COEFFICIENTS, "fixed-path"), wind)
    assert answer.peak_rate("angle_of_attack") == np.inf
    assert answer.peak_rate("deflection") < np.inf


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda a, p, w: a.wind_response(p, w).peak("deflektion"), "deflection'?"),
        (
            lambda a, p, w: a.wind_response(p, w).peak_rate("attitude_rat"),
            "did you mean 'attitude_rate'",
        ),
        (lambda a, p, w: a.wind_response(p, w).peak("flight_path_angle"), "output must be one of"),
        (lambda a, p, w: a.wind_response(p, 0.1), "wind must be a History"),
        (lambda a, p, w: a.wind_response(w, w), "plant must be a Plant"),
        (lambda a, p, w: a.wind_response(p, w * [1.0, 2.0]), r"wind must be one .* shape \(2,\)"),
        (
            lambda a, p, w: Autopilot(attitude_gain=[1, 2], rate_gain=1).wind_response(p, w),
            "one autopilot",
        ),
        (lambda a, p, w: a.respond(p, w, [[0.0, 1.0]]), "one row of numbers"),
        (lambda a, p, w: a.respond(p, w, [0.0, np.inf]), "timepts must be finite"),
    ],
)
def test_answers_that_cannot_be(call, message):
    wind = tv.TriangularWind(peak=0.1, duration=8.0)
    with pytest.raises(InputError, match=message):
        call(Autopilot(**GAINS), Plant(COEFFICIENTS, "fixed-path"), wind)
