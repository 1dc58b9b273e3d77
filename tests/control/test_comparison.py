"""A closed loop in a wind: exact answers, their peaks, and what stands beside trim."""

import contextlib
import warnings
from dataclasses import replace
from itertools import product
from math import factorial

import control
import matplotlib as mpl
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import tvclin as tv
from tests.turns import usual
from tvclin import Actuator, Autopilot, Coefficients, InputError, Plant
from tvclin.control.comparison import wind_gain
from tvclin.linear.plant import MODELS
from tvclin.plots import comparison_chart, curves_of

mpl.use("Agg")

COEFFICIENTS = Coefficients(
    mu_alpha=0.28, mu_delta=2.6, C1=0.025, C2=0.0036, b1=0.0284, b2=0.0169, q=1.7e-4
)
COURSE = Plant.from_coefficients(Coefficients(mu_alpha=0.228, mu_delta=1.317))
COURSE_GAINS = {"attitude_gain": 1.88, "rate_gain": 1.59}
MISLED = Autopilot(
    **COURSE_GAINS, actuator=Actuator(natural_frequency=20.0, damping=0.02), delay=0.4
)
GAINS = {"attitude_gain": 0.3, "rate_gain": 0.4}
OPTIONS = {
    "gains": {},
    "alpha": {"alpha_gain": 0.07},
    "integral": {"integral_gain": 0.05},
    "actuator": {"actuator": Actuator()},
    "delay": {"delay": 0.1},
}
EVERYTHING = {k: v for options in OPTIONS.values() for k, v in options.items()}
OPTIONS["everything"] = EVERYTHING
FAST = Actuator(natural_frequency=300.0)
TAU, PEAK = 8.0, -0.1
RNG = np.random.default_rng(5)
TIME = 0.05 * np.sort(RNG.choice(260, 20, replace=False)) - 1.0
ANGLE = RNG.uniform(-0.1, 0.1, 20)
WINDS = {
    "triangular": (tv.TriangularWind(peak=PEAK, duration=TAU), [0, 4, 8], [0, PEAK, 0]),
    "rectangular": (tv.RectangularWind(peak=PEAK, duration=TAU), [0, 8], [PEAK, PEAK]),
    "sampled": (tv.SampledWind(time=TIME, angle=ANGLE), TIME, ANGLE),
}
TRIANGLE = WINDS["triangular"][0]
EACH_OPTION = pytest.mark.parametrize("options", OPTIONS.values(), ids=OPTIONS)


def plant_of(model="fixed-path", **changes):
    return Plant.from_coefficients(COEFFICIENTS.replace(**changes), model)


def flown(closed, corners, step):
    """Fly a wind of straight lines with python-control, on a grid with its corners on it.

    Gives times, wind, states, outputs and their rates without the wind's own: with it and after.
    """
    state, end = np.zeros(closed.nstates), corners[0][-1]
    for times, angles in (corners, ([end, end + 20.0], [0.0, 0.0])):
        t = np.linspace(times[0], times[-1], round((times[-1] - times[0]) / step) + 1)
        w = np.interp(t, times, angles)
        inputs = [w, 0 * w, 0 * w]
        x = np.asarray(control.forced_response(closed, t - t[0], inputs, state).states)
        outputs = closed.C @ x + np.outer(closed.D[:, 0], w)
        yield t, w, x, outputs, closed.C @ (closed.A @ x + np.outer(closed.B[:, 0], w))
        state = x[:, -1]


def peaks(autopilot, plant, corners):
    """Return sampled peak, refined peak and its time, of each output and (key 1) of its rate.

    It is refined by Taylor series of the states in the intervals about the highest sample.
    """
    closed, computed = autopilot.close(plant), {}
    runs = list(flown(closed, corners, 0.01))
    for (i, label), rate in product(enumerate(closed.output_labels), (0, 1)):
        C, through, tops = closed.C[i], closed.D[i, 0], []
        for t, w, x, *rows in runs:
            slope = np.diff(w) / np.diff(t)
            own = rate * through * slope
            sides = np.abs([rows[rate][i, :-1] + own, rows[rate][i, 1:] + own]).max(axis=0)
            tops.append((sides.max(), int(np.argmax(sides)), t, w, x, slope))
        sampled, top, t, w, x, slope = max(tops, key=lambda one: one[0])
        best = 0.0, 0.0
        for j in range(max(top - 1, 0), min(top + 2, slope.size)):
            u, derivative = np.linspace(0.0, t[j + 1] - t[j], 1001), x[:, j]
            terms = [C @ derivative + through * w[j]]
            for wind in (w[j], slope[j], *[0.0] * 14):
                derivative = closed.A @ derivative + closed.B[:, 0] * wind
                terms.append(C @ derivative)
            terms[1] += through * slope[j]
            values = np.abs(sum(c * u**k / factorial(k) for k, c in enumerate(terms[rate:])))
            best = max(best, (values.max(), t[j] + u[np.argmax(values)]))
        computed[label, rate] = sampled, *best
    return computed


@pytest.mark.parametrize(
    ("model", "options", "wind"),
    [(m, o, "sampled") for m in MODELS for o in OPTIONS.values()]
    + [(m, EVERYTHING, wind) for m in MODELS for wind in ("triangular", "rectangular")],
)
def test_the_answer_is_that_of_python_control(model, options, wind):
    autopilot, plant = Autopilot(**GAINS, **options), plant_of(model)
    history, *corners = WINDS[wind]
    closed = autopilot.close(plant)
    runs = list(flown(closed, corners, 0.05))
    times = np.concatenate([run[0][:-1:4] for run in runs])
    expected = np.concatenate([run[3][:, :-1:4] for run in runs], axis=1)
    result = autopilot.respond(plant, history, times)
    scale = np.abs(expected).max(axis=1, keepdims=True)
    np.testing.assert_allclose(result.outputs / scale, expected / scale, atol=1e-9)
    assert result.output_labels == closed.output_labels
    early = np.nextafter(history.knots[0], -np.inf)
    assert not autopilot.wind_response(plant, history)([early - 1.0, early]).any()


def test_a_critically_damped_loop_in_closed_form():
    """A double pole -w: theta = -mu_alpha alpha_w (1 - (1 + w t) e^-wt)/w^2 in a steady wind."""
    w, c, times = 1.3, COEFFICIENTS, np.array([0.0, 0.5, 2.0, 5.0, 7.9, 8.0, 9.0, 14.0])
    autopilot = tv.design_gains(c, natural_frequency=w, damping=1.0)
    answer = autopilot.wind_response(plant_of(), WINDS["rectangular"][0])

    def held(t):
        t = np.maximum(t, 0.0)
        angle = -c.mu_alpha * PEAK / w**2 * (1 - (1 + w * t) * np.exp(-w * t))
        return np.array([angle, -c.mu_alpha * PEAK * t * np.exp(-w * t)])

    attitude, rate = held(times) - held(times - TAU)
    a0, a1 = autopilot.attitude_gain, autopilot.rate_gain
    wind = PEAK * (times < TAU)
    expected = [attitude, rate, attitude - wind, a0 * attitude + a1 * rate]
    np.testing.assert_allclose(answer(times), expected, rtol=1e-12, atol=1e-14)
    top = 2 * w / (w**2 - c.mu_alpha)
    computed, time = answer.peak("deflection")
    assert computed == pytest.approx(np.array([a0, a1]) @ held(top), rel=1e-12)
    assert time == pytest.approx(top, rel=1e-6)
    assert answer.peak("attitude_rate")[0] == pytest.approx(held(1 / w)[1], rel=1e-12)


def assert_peaks(autopilot, plant, history, corners):
    answer, through = autopilot.wind_response(plant, history), autopilot.close(plant).D[:, 0]
    jumps = bool(corners[1][0] or corners[1][-1])
    for (label, rate), (sampled, refined, time) in peaks(autopilot, plant, corners).items():
        k = answer.labels.index(label)
        if rate:
            expected = np.inf if through[k] and jumps else refined
            assert answer.peak_rate(label) == pytest.approx(expected, rel=1e-9), label
            continue
        computed, when = answer.peak(label)
        assert abs(computed) >= sampled * (1 - 1e-12), label
        assert abs(computed) == pytest.approx(refined, rel=1e-9), label
        assert when == pytest.approx(time, abs=1e-3), label
        assert computed * answer(when - 1e-12)[k] > 0, label


@EACH_OPTION
@pytest.mark.parametrize("wind", WINDS)
def test_peaks_and_their_rates_are_those_of_dense_sampling(options, wind):
    """A deflection that is fed the angle of attack without actuator jumps with the wind."""
    autopilot, (history, *corners) = Autopilot(**GAINS, **options), WINDS[wind]
    assert_peaks(autopilot, plant_of(), history, corners)
    jumps = autopilot.wind_response(plant_of(), history).peak_rate("deflection") == np.inf
    assert jumps is (options == OPTIONS["alpha"] and wind != "triangular")


@pytest.mark.parametrize("duration", [0.5, 1.5])
def test_a_peak_after_the_wind_is_found(duration):
    soft = Autopilot(attitude_gain=1.88, rate_gain=0.02)
    history = tv.TriangularWind(peak=0.1, duration=duration)
    assert soft.wind_response(COURSE, history).peak("deflection")[1] > duration
    assert_peaks(soft, COURSE, history, ([0, duration / 2, duration], [0, 0.1, 0]))


@pytest.mark.parametrize(
    ("model", "time", "angle"),
    [
        ("drift", [0.0, 0.05, 0.8, 1.15, 2.4, 4.15], [-0.06, 0.1, 0.06, -0.08, -0.05, 0.05]),
        ("fixed-path", [0.0, 1.45, 1.9, 3.0, 3.8], [0.03, 0.1, -0.02, -0.08, 0.09]),
    ],
)
def test_the_higher_of_two_peaks_is_found(model, time, angle):
    history = tv.SampledWind(time=time, angle=angle)
    assert_peaks(Autopilot(**GAINS), plant_of(model), history, (time, angle))


@pytest.mark.parametrize("model", ["fixed-path", "drift-exact"])
def test_every_number_of_a_comparison(model):
    autopilot, plant = Autopilot(**GAINS, **EVERYTHING), plant_of(model)
    result = tv.compare_with_trim(plant, autopilot, TRIANGLE)
    sizes = {k: top for k, (_, top, _) in peaks(autopilot, plant, WINDS["triangular"][1:]).items()}
    expected = {
        "trim_deflection": 0.28 / 2.6 * 0.1,
        "peak_deflection": sizes["deflection", 0],
        "peak_deflection_rate": sizes["deflection", 1],
        "peak_angle_of_attack": sizes["angle_of_attack", 0],
        "peak_attitude": sizes["attitude", 0],
        "peak_flight_path_angle": sizes.get(("flight_path_angle", 0), np.nan),
        "ratio_to_trim": sizes["deflection", 0] / (0.28 / 2.6 * 0.1),
        "minimum": tv.optimum_deflection(plant, TRIANGLE).peak,
    }
    for name, value in expected.items():
        assert getattr(result, name) == pytest.approx(value, rel=1e-9, nan_ok=True), name
    limits = {
        K: abs(tv.boundary_limit(plant, TRIANGLE, K, "literal").deflection) for K in (1.0, 0.5, 0.0)
    }
    assert result.boundaries == pytest.approx(limits, rel=1e-13)
    assert result.margins.phase_margin == autopilot.margins(plant).phase_margin
    assert result.notes == ()


GAIN_OPTIONS = {
    "gains": {},
    "alpha": {"alpha_gain": 0.07},
    "much alpha": {"alpha_gain": 3.0},
    "everything": EVERYTHING,
    "everything late": EVERYTHING | {"delay": 0.3},
    "a microsecond": {"delay": 1e-6},
    "a millisecond": {"delay": 0.001},
    "late alpha": {"alpha_gain": 0.07, "delay": 0.05},
    "hardly damped by its delay": {"delay": 0.36, "actuator": FAST},
    "a fast actuator": {"actuator": FAST},
    "an actuator that rings": {"actuator": Actuator(natural_frequency=20.0, damping=0.03)},
}


def gain_by_hand(plant, options, omega):
    """Return |deflection/wind| of the closed loop with its exact delay, from python-control."""
    s = 1j * np.atleast_1d(omega)
    a0, a1 = GAINS["attitude_gain"], GAINS["rate_gain"]
    b0, aI = options.get("alpha_gain", 0.0), options.get("integral_gain", 0.0)
    engine, late = 1.0, np.exp(-s * options.get("delay", 0.0))
    if "actuator" in options:
        engine = options["actuator"].tf()(s)

    def response(source):
        attitude = (a0 + a1 * s + aI / s) * plant.tf("attitude", source)(s)
        return engine * late * (attitude + b0 * plant.tf("angle_of_attack", source)(s))

    return np.abs(response("wind") / (1 - response("deflection")))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("options", GAIN_OPTIONS.values(), ids=GAIN_OPTIONS)
def test_the_wind_gain_is_that_of_a_scan_with_the_exact_delay(options, model):
    plant = plant_of(model)
    result = wind_gain(plant, Autopilot(**GAINS, **options))
    if not Autopilot(**GAINS, **options).margins(plant).stable:
        assert result == np.inf
        return
    scan = np.concatenate([np.geomspace(1e-6, 1e4, 30_001), np.linspace(0.01, 60.0, 30_001)])
    scan = np.sort(scan)
    sizes = gain_by_hand(plant, options, scan)
    top = np.clip(np.argmax(sizes), 1, scan.size - 2)
    ends = scan[top - 1], scan[top + 1]
    near = minimize_scalar(
        lambda w: -gain_by_hand(plant, options, w)[0], bounds=ends, options={"xatol": 1e-9}
    )
    assert result == pytest.approx(max(sizes.max(), -near.fun), rel=1e-10)


@pytest.mark.parametrize(
    "options", [{}, {"alpha_gain": 0.07}, {"actuator": FAST}, {"integral_gain": 0.05}]
)
def test_the_wind_gain_without_delay_is_the_norm_of_python_control(options):
    plant, autopilot = plant_of("drift-exact"), Autopilot(**GAINS, **options)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # without slycot it says what it does instead
        expected = control.system_norm(autopilot.close(plant)["deflection", "wind"], p="inf")
    assert wind_gain(plant, autopilot) == pytest.approx(expected, rel=2e-6)


def test_an_unstable_loop_has_no_finite_numbers_but_the_theory_has():
    fallen, plant = Autopilot(attitude_gain=0.05, rate_gain=0.4), plant_of("drift")
    result = tv.compare_with_trim(plant, fallen, TRIANGLE)
    names = ("deflection", "deflection_rate", "angle_of_attack", "attitude", "flight_path_angle")
    assert {getattr(result, f"peak_{name}") for name in names} == {np.inf}
    assert result.wind_gain == result.ratio_to_trim == np.inf
    assert result.notes == (result.margins.reason,)
    assert "unstable: 2 closed-loop poles lie in the right half plane" in result.notes[0]
    assert result.minimum == tv.optimum_deflection(plant, TRIANGLE).peak
    assert 0 < result.boundaries[0.0] < result.boundaries[1.0] < result.trim_deflection
    answer = fallen.wind_response(plant, TRIANGLE)
    assert answer.peak("attitude")[0] == answer.peak_rate("attitude") == np.inf
    with pytest.raises(InputError, match="nothing to compare: .* 2 closed-loop poles"):
        comparison_chart(result)
    with pytest.raises(InputError, match="no duration is the worst: .* unstable"):
        tv.control.worst_duration(
            plant, fallen, peak=0.1, shortest=1, longest=9, shape=tv.TriangularWind
        )


def test_a_wind_of_two_signs_has_no_boundary():
    autopilot, history = Autopilot(**GAINS), WINDS["sampled"][0]
    result = tv.compare_with_trim(plant_of(), autopilot, history)
    assert np.isnan([*result.boundaries.values()]).tolist() == [True] * 3
    assert [note.partition(":")[0] for note in result.notes] == ["no boundary"]
    assert result.peak_deflection == abs(
        autopilot.wind_response(plant_of(), history).peak("deflection")[0]
    )
    assert result.minimum == tv.optimum_deflection(plant_of(), history).peak > 0
    labels = [column.label for column in curves_of(comparison_chart(result)).columns]
    mpl.pyplot.close("all")
    assert "lower bound, wind known" in labels
    assert not any("boundary" in label for label in labels)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"plant": plant_of(mu_alpha=[0.2, 0.3])}, "for one case; take those of a batch"),
        ({"autopilot": Autopilot(attitude_gain=[0.3, 0.4], rate_gain=0.4)}, "for one case"),
        ({"wind": tv.TriangularWind(peak=[0.1, 0.2], duration=8.0)}, "for one case"),
        ({"wind": tv.linear.ConstantDeflection(limit=0.1)}, "wind must end"),
        ({"wind": 0.0 * TRIANGLE}, "wind must end, and be other than zero"),
        ({"wind": 0.1}, "wind must be a History"),
        ({"plant": COEFFICIENTS}, "plant must be a Plant .*; got <Coefficients"),
        ({"autopilot": GAINS}, "autopilot must be an? Autopilot"),
        ({"plant": COURSE, "autopilot": MISLED}, "pade_order = 4 is too low"),
    ],
)
def test_comparisons_that_cannot_be(arguments, message):
    with pytest.raises(InputError, match=message):
        tv.compare_with_trim(
            **{"plant": plant_of(), "autopilot": Autopilot(**GAINS), "wind": TRIANGLE} | arguments
        )


SHAPES = {
    tv.TriangularWind: lambda u: np.interp(u, [0, 0.5, 1], [0, 0.1, 0]),
    tv.OneMinusCosineGust: lambda u: 0.05 * (1 - np.cos(2 * np.pi * u)) * (u < 1),
    tv.RectangularWind: lambda u: 0.1 + 0 * u,
}


@pytest.mark.parametrize("shape", usual(SHAPES, 0))
def test_the_worst_duration_is_worse_than_those_of_a_scan(shape):
    """By python-control on a grid; a pulse is one step less another that comes later."""
    autopilot, plant = Autopilot(attitude_gain=0.3, rate_gain=0.15), plant_of()
    closed, u = autopilot.close(plant), np.linspace(0.0, 4.0, 1201)

    def sampled(duration):
        inputs = [SHAPES[shape](u), 0 * u, 0 * u]
        result = control.forced_response(closed, duration * u, inputs).outputs["deflection"]
        if shape is tv.RectangularWind:
            result = result - np.append(np.zeros(300), result[:-300])
        return np.abs(result).max()

    def worst(low, high):
        request = {"peak": 0.1, "shortest": low, "longest": high, "shape": shape}
        return tv.control.worst_duration(plant, autopilot, **request)

    result = worst(1.0, 20.0)
    assert result.peak_deflection == pytest.approx(sampled(result.duration), rel=1e-4)
    assert result.peak_deflection > max(map(sampled, np.geomspace(1.0, 20.0, 16))) * (1 - 1e-9)
    assert not result.at_range_end
    if shape is tv.TriangularWind:
        low, high = 0.8 * result.duration, 1.2 * result.duration
        for ends, end in (((1.0, low), low), ((high, 20.0), high)):
            edge = worst(*ends)
            assert (edge.duration, edge.at_range_end) == (pytest.approx(end, rel=1e-12), True)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("damping", "low"),
    usual([(0.003, 54.0), (0.003, 35.0), (0.01, 20.0), (0.01, 1.0)], 0),
)
def test_the_worst_of_many_durations_at_which_a_loop_rings_is_found(damping, low):
    """A pulse on an oscillator: one answer to a step less another, in closed form."""
    frequency, c, high, step = 2.0, COEFFICIENTS, 60.0, 0.004
    autopilot = tv.design_gains(c, natural_frequency=frequency, damping=damping)
    sigma = damping * frequency
    omega = frequency * np.sqrt(1 - damping**2)

    def stepped(t):
        """Deflection after a unit step of the wind."""
        fallen = np.exp(-sigma * t)
        swing = fallen * (np.cos(omega * t) + sigma / omega * np.sin(omega * t))
        attitude = -c.mu_alpha / frequency**2 * (1 - swing)
        rate = -c.mu_alpha / omega * fallen * np.sin(omega * t)
        return autopilot.attitude_gain * attitude + autopilot.rate_gain * rate

    count = round(high / step)
    held = stepped(step * np.arange(count + round(8.0 / step)))
    during = np.maximum.accumulate(np.abs(held))
    later = np.arange(round(8.0 / step))
    pulses = np.arange(round(low / step), count)
    after = [np.abs(held[k + later] - held[later]).max() for k in pulses]
    expected = np.maximum(during[pulses], after)
    worst = tv.control.worst_duration(
        plant_of(),
        autopilot,
        peak=1.0,
        shortest=low,
        longest=high,
        shape=tv.RectangularWind,
    )
    assert worst.peak_deflection == pytest.approx(expected.max(), rel=1e-4)
    assert worst.peak_deflection >= expected.max() * (1 - 1e-9)
    there = np.interp(worst.duration, step * pulses, expected)
    assert there == pytest.approx(worst.peak_deflection, rel=1e-4)


def test_a_warning_points_to_who_asked():
    soft, plant = Autopilot(attitude_gain=0.3, rate_gain=-0.4), plant_of()
    request = {"peak": 0.1, "shortest": 1.0, "longest": 9.0, "shape": tv.TriangularWind}
    schedule = tv.control.GainSchedule(np.array([0.0, 1.0]), soft)
    calls = [
        lambda: tv.compare_with_trim(plant, soft, TRIANGLE),
        lambda: tv.control.worst_duration(plant, soft, **request),
        lambda: schedule.margins(plant),
    ]
    for call in calls:
        words = "rate_gain = -0.4 is positive feedback"
        with pytest.warns(UserWarning, match=words) as seen, contextlib.suppress(InputError):
            call()
        assert {one.filename for one in seen} == {__file__}


def test_a_boundary_that_is_no_solution_is_noted():
    stable = tv.compare_with_trim(plant_of(mu_alpha=-0.28), Autopilot(**GAINS), TRIANGLE)
    status = tv.boundary_limit(plant_of(mu_alpha=-0.28), TRIANGLE, 0.5).status
    assert status.startswith("no unstable pole")
    assert f"boundary K = 1, 0.5, 0: {status}" in stable.notes


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"shortest": 9.0}, "longest must be above shortest; got 9 and 9 s"),
        ({"shortest": 0.0}, "shortest must be positive"),
        ({"longest": np.inf}, "longest must be finite"),
        ({"peak": 0.0}, "peak must be other than zero"),
        ({"shape": lambda **_: 0.1}, r"shape\(peak, duration\) must be a History"),
    ],
)
def test_durations_that_cannot_be(changes, message):
    request = {"peak": 0.1, "shortest": 1.0, "longest": 9.0, "shape": tv.TriangularWind} | changes
    with pytest.raises(InputError, match=message):
        tv.control.worst_duration(plant_of(), Autopilot(**GAINS), **request)


def test_a_pade_approximation_of_another_stability_is_refused():
    with pytest.warns(UserWarning, match="pade_order = 4 is too low for this delay"):
        poles = MISLED.close(COURSE).poles()
    exact = MISLED.margins(COURSE).unstable_poles
    assert np.sum(poles.real > 0) != exact
    for call in (MISLED.wind_response, lambda *args: MISLED.respond(*args, [0.0, 1.0])):
        with pytest.raises(InputError, match="pade_order = 4 is too low .* unstable poles"):
            call(COURSE, TRIANGLE)
    better = replace(MISLED, pade_order=8)
    assert np.sum(better.close(COURSE).poles().real > 0) == exact


def test_attitude_hold_makes_the_angle_of_attack_larger_than_a_steady_wind():
    for options in ({}, {"actuator": Actuator(), "delay": 0.1}):
        steady = tv.RectangularWind(peak=0.1, duration=400.0)
        answer = Autopilot(**GAINS, **options).wind_response(plant_of(), steady)
        computed = answer(399.0)[answer.labels.index("angle_of_attack")]
        assert computed == pytest.approx(-0.1 * 0.3 / (0.3 - 0.28 / 2.6), rel=1e-11)


@pytest.mark.parametrize(("model", "peak"), [("fixed-path", 0.1), ("drift", -0.1)])
def test_the_chart_draws_what_the_comparison_says(model, peak):
    autopilot, plant, corners = Autopilot(**GAINS), plant_of(model), ([0, 4, 8], [0, peak, 0])
    c = tv.compare_with_trim(plant, autopilot, tv.TriangularWind(peak=peak, duration=8.0))
    plot = comparison_chart(c)
    curves = curves_of(plot)
    t = curves.abscissa
    wind = np.degrees(np.interp(t, *corners))
    drawn = {(col.panel, col.label): col.values for col in curves.columns}
    closed, even = autopilot.close(plant), np.linspace(0.0, 12.8, 1201)  # all of t among them
    inputs = [np.interp(even, *corners), 0 * even, 0 * even]
    seen = control.forced_response(closed, even, inputs).outputs
    expected = {("angles", "wind"): wind, ("deflection", "ideal trim"): -0.28 / 2.6 * wind}
    for name in ("attitude", "angle_of_attack", "flight_path_angle")[: 2 + (model == "drift")]:
        expected["angles", name] = np.interp(t, even, np.degrees(seen[name]))
    expected["deflection", "autopilot"] = np.interp(t, even, np.degrees(seen["deflection"]))
    levels = {f"boundary K = {K:g}": limit for K, limit in c.boundaries.items()}
    for label, limit in (levels | {"lower bound, wind known": c.minimum}).items():
        expected["deflection", label] = np.full(t.size, -np.sign(peak) * np.degrees(limit))
    assert drawn.keys() == expected.keys()
    for key, row in expected.items():
        np.testing.assert_allclose(drawn[key], row, rtol=1e-9, atol=1e-9, err_msg=str(key))
    assert (t.min(), t.max()) == (0.0, 12.8)
    assert f"{c.ratio_to_trim:.3g} times trim" in curves.parameters
    for line, (key, row) in zip(plot.axes[0, 0].lines, drawn.items(), strict=False):
        assert line.get_label().replace("$", "") == key[1]
        np.testing.assert_array_equal(line.get_ydata(), row)
    mpl.pyplot.close(plot.figure)


def test_the_peaks_of_many_winds_are_those_of_each_and_the_largest_is_exact():
    """Winds of two families of rates; those below the largest are never above their peak."""
    plant, autopilot = plant_of(), Autopilot(**GAINS)
    winds = [
        *(tv.TriangularWind(peak=0.1, duration=duration) for duration in (2.0, 12.8, 40.0)),
        *(tv.RectangularWind(peak=-0.05, duration=duration) for duration in (1.0, 9.0)),
        tv.OneMinusCosineGust(peak=0.1, duration=5.0),
    ]
    peaks = autopilot.deflection_peaks_function(plant)(winds)
    each = [abs(autopilot.wind_response(plant, wind).peak("deflection")[0]) for wind in winds]
    assert peaks.max() == pytest.approx(max(each), rel=1e-13)
    assert np.argmax(peaks) == np.argmax(each)
    assert np.all(peaks <= np.array(each) * (1.0 + 1e-13))
