"""Flights of laws with limits, against closed loops written here: scipy's solver and expm."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

import tvclin as tv
from tests.flying import BETA, COEFFICIENTS, GAINS, LAG, LAWS, MORE, PEAK, SERVO, WIND, B, plant_of
from tests.turns import by_turns, usual
from tvclin import Actuator, Autopilot, InputError, Plant, SampledWind, TriangularWind
from tvclin.flights.closed_loop import continuous
from tvclin.flights.closed_loop.continuous import Loop
from tvclin.flights.closed_loop.fly import LinearEquations
from tvclin.linear.plant import MODELS

CASES = [
    ("gains", "fixed-path", 1.1, {}),
    ("gains", "fixed-path", 1.1, {"actuator": SERVO, "rate_limit": 0.004}),
    ("all gains", "drift-exact", 0.9, {"actuator": LAG}),
    ("trim", "fixed-path", 0.85, {}),
    ("trim", "drift-exact", 0.85, {"actuator": SERVO}),
    ("trim", "fixed-path", 0.9, {"actuator": LAG, "rate_limit": 0.004}),
    ("lean", "fixed-path", 0.5, {}),
    ("lean", "drift-exact", 0.5, {"actuator": SERVO}),
    ("lean", "fixed-path", 0.5, {"actuator": SERVO, "rate_limit": 0.006}),
    ("lean", "drift-exact", 0.5, {"actuator": LAG, "rate_limit": 0.004}),
    ("estimated", "fixed-path", 0.6, {}),
    ("estimated", "drift-exact", 0.7, {"actuator": LAG, "rate_limit": 0.004}),
]
PROMISED = 12.0 * np.sqrt(7) * 1e-9
"""Error of a flight without pause in a stable loop, over the size of each output: the solver grants
each step 1e-9, as the root mean square over up to 7 states, and 12 times that between its ends."""
CORNERS = 10.0 * np.sqrt(24) * PROMISED
"""The same where a limit or the end of a lean leaves a corner inside a step, which only the error
control sees. A corner costs the polynomial of a step about one more decimal, and flights here have
up to two dozen of them, whose errors add as squares."""
EACH_CASE = pytest.mark.parametrize(("name", "model", "part", "hardware"), usual(CASES, 2, 11))


def commanded(name, law, x, memory, wind, limit):
    """Return the deflection commanded; the lean itself has tests of its own."""
    path = x[2] if len(x) > 2 else 0.0
    alpha = x[0] - path - wind
    demand = GAINS["attitude_gain"] * x[0] + GAINS["rate_gain"] * x[1]
    if name == "all gains":
        demand += 0.03 * alpha + 0.02 * memory[0]
    if name == "trim":
        demand = B * (alpha + 4.0 * (x[0] + x[1] / BETA))
    if name in ("lean", "estimated"):
        demand = law.demand(tv.control.Measurement(x[0], x[1], path, alpha, 0.0), memory, limit)
    return np.clip(demand, -limit, limit)


def learnt(name, x, memory, deflection):
    """Return the rates of the law's own states: the integral, or the observer written out."""
    if name == "all gains":
        return np.array([x[0]])
    if name != "estimated":
        return np.zeros(0)
    c, w, miss = COEFFICIENTS, 6.0, x[1] - memory[0]
    rate = c.mu_alpha * (x[0] - memory[1]) - c.mu_delta * deflection + 1.4 * w * miss
    return np.array([rate, -(w**2) / c.mu_alpha * miss])


def written_out(name, model, limit, actuator=None, rate_limit=np.inf):
    """Return a function of times: states and deflection from scipy's solver."""
    plant = plant_of(model)
    law, n = LAWS[name](plant), len(plant.states)
    A, inputs, _, _ = plant.matrices()
    order = 0 if actuator is None else 1 if actuator.damping is None else 2

    def parts(t, y):
        wind, x, memory = float(WIND(t)), y[:n], y[n + order :]
        command = commanded(name, law, x, memory, wind, limit)
        return x, memory, wind, command, np.clip(y[n], -limit, limit) if order else command

    def rates(t, y):
        x, memory, wind, command, deflection = parts(t, y)
        moved, servo = A @ x + inputs @ [deflection, wind], []
        if order:
            w = actuator.natural_frequency
            pull = w * (command - y[n])
            servo = [np.clip(pull, -rate_limit, rate_limit)]
        if order == 2:
            pull = w * pull - 2 * actuator.damping * w * y[n + 1]
            over = abs(y[n + 1]) >= rate_limit and pull * y[n + 1] > 0.0
            servo = [np.clip(y[n + 1], -rate_limit, rate_limit), 0.0 if over else pull]
        return np.concatenate([moved, servo, learnt(name, x, memory, deflection)])

    edges = [*np.unique(WIND.knots), 20.0]
    y, runs = np.zeros(n + order + len(law.states[0])), []
    for a, b in pairwise(edges):
        span = (a, np.nextafter(b, a))  # the wind jumps at a knot
        run = solve_ivp(
            rates, span, y, "DOP853", max_step=0.05, rtol=1e-10, atol=1e-13, dense_output=True
        )
        y = run.y[:, -1]
        runs.append(run.sol)

    def at(times):
        computed = []
        for t in times:
            y = runs[np.searchsorted(edges, t, side="right") - 1](t)
            computed.append([*y[:n], parts(t, y)[-1]])
        return np.array(computed).T

    return at


def compared(flown, model):
    """Return states and deflection of a flight as rows."""
    return flown.outputs[[*range(len(plant_of(model).states)), -1]]


@EACH_CASE
def test_a_flight_without_pause_is_that_of_the_written_out_loop(name, model, part, hardware):
    limit, plant = part * B * PEAK, plant_of(model)
    times = np.linspace(0.1, 19.9, 50)
    flown = tv.fly(plant, LAWS[name](plant), WIND, times, deflection_limit=limit, **hardware)
    expected = written_out(name, model, limit, **hardware)(times)
    for row, other in zip(compared(flown, model), expected, strict=True):
        np.testing.assert_allclose(row, other, rtol=0, atol=CORNERS * np.abs(other).max())


def memory_step(name, size, h):
    """Return what takes the law's own states and theta, theta', delta held over a step."""
    driven = np.zeros((size + 3, size + 3))
    for k, unit in enumerate(np.eye(size + 3)):
        driven[:size, k] = learnt(name, unit[size : size + 2], unit[:size], unit[-1])
    return expm(driven * h)[:size]


def stepped(name, model, limit, rate, times, actuator=None, rate_limit=np.inf):
    """Return states and deflection: sample by sample, each part of a step with scipy's expm."""
    plant, h, knots = plant_of(model), 1.0 / rate, WIND.knots
    law, n = LAWS[name](plant), len(plant.states)
    A, inputs, _, _ = plant.matrices()
    even = np.zeros((n + 4, n + 4))  # states, a deflection that goes evenly, the wind
    even[:n, :n], even[:n, n], even[:n, n + 2] = A, inputs[:, 0], inputs[:, 1]
    even[n, n + 1] = even[n + 2, n + 3] = 1.0
    order = 1 if actuator is None or actuator.damping is None else 2
    free = np.zeros((n + order + 3, n + order + 3))  # states, nozzle, command, the wind
    free[:n, :n], free[:n, n + order + 1] = A, inputs[:, 1]
    free[:n, n if actuator else n + 1] = inputs[:, 0]
    free[n + order + 1, n + order + 2] = 1.0
    if actuator is not None:
        w, zeta = actuator.natural_frequency, actuator.damping
        second = [[0, 1, 0], [-w * w, -2 * w * (zeta or 0), w * w]]
        free[n : n + order, n : n + order + 1] = [[-w, w]] if zeta is None else second

    @cache
    def grown(bounded, seconds):
        return expm((even if bounded else free) * seconds)

    def carried(x, a, b, bounded, *given):
        for one, two in pairwise([a, *np.unique(knots[(knots > a) & (knots < b)]), b]):
            first, last = WIND([one, np.nextafter(two, one)])
            begun = [*x, *given, first, (last - first) / (two - one)]
            moved = grown(bounded, round(two - one, 13)) @ begun
            x, given = moved[:n], moved[n:-2]
        return x, given

    x, servo, memory = np.zeros(n), np.zeros(order), np.zeros(len(law.states[0]))
    remembered = memory_step(name, len(memory), h)
    onset = float(WIND.onset)
    computed = {t: np.zeros(n + 1) for t in times[times < onset]}
    for k in range(int((times.max() - onset) * rate) + 1):
        t, later = onset + k * h, onset + (k + 1) * h
        before = np.clip(servo[0], -limit, limit)
        command = commanded(name, law, x, memory, float(WIND(t)), limit)
        given = (*(servo if actuator else [command]), command)
        moved = np.array(carried(x, t, later, False, *given)[1][:order])
        free_to = np.clip(moved[0], servo[0] - rate_limit * h, servo[0] + rate_limit * h)
        slowed = np.clip(moved[1:], -rate_limit, rate_limit)
        bounded = free_to != moved[0] or np.any(slowed != moved[1:])
        if order == 1:  # the rate at the beginning, which is the largest
            pace = np.inf if actuator is None else abs(command - servo[0]) * w
            bounded = bounded or pace > rate_limit
        else:
            bounded = bounded or abs(servo[1]) >= rate_limit
        bounded = bounded or max(abs(servo[0]), abs(moved[0])) > limit * (1.0 + 1e-9)
        moved = np.array([free_to, *slowed])
        if bounded:
            given = (before, (np.clip(moved[0], -limit, limit) - before) / h)
        for time in times[(times >= t) & (times < later)]:
            state, nozzle = carried(x, t, time, bounded, *given) if time > t else (x, given)
            computed[time] = [*state, np.clip(nozzle[0], -limit, limit)]
        memory = remembered @ [*memory, x[0], x[1], before]
        x, servo = carried(x, t, later, bounded, *given)[0], moved
    return np.array([computed[t] for t in times]).T


@pytest.mark.parametrize(
    ("name", "model", "part", "hardware"),
    usual([*CASES, ("lean", "drift-exact", 0.5, {"rate_limit": 0.003})], 2, 7, 10, 12),
)
def test_a_sampled_flight_is_the_same_step_by_step(name, model, part, hardware):
    limit, plant = part * B * PEAK, plant_of(model)
    times = np.array([0.0, 0.0131, 1.0, 2.0, 7.577, 7.6, 7.77, 9.30233, 11.0, 14.14])
    options = {"deflection_limit": limit, "sample_rate": 43.0} | hardware
    flown = tv.fly(plant, LAWS[name](plant), WIND, times, **options)
    expected = stepped(name, model, limit, 43.0, times, **hardware)
    np.testing.assert_allclose(compared(flown, model), expected, rtol=0, atol=1e-10 * PEAK)


@pytest.mark.parametrize(("name", "part"), [("trim", 0.85), ("lean", 0.5)])
def test_a_sampled_flight_comes_to_that_without_pause_as_the_rate_grows(name, part):
    plant, times = plant_of(), np.linspace(0.5, 20.0, 40)
    law, limit = LAWS[name](plant), part * B * PEAK
    exact = tv.fly(plant, law, WIND, times, deflection_limit=limit)
    errors = []
    for rate in (25, 50, 100, 200):
        flown = tv.fly(plant, law, WIND, times, deflection_limit=limit, sample_rate=rate)
        errors.append(np.abs(flown.outputs[:2] - exact.outputs[:2]).max())
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 2.0, atol=0.4)


@by_turns("model,actuator", MODELS, [None, SERVO, LAG], each=4)
def test_without_saturation_it_is_the_linear_loop(model, actuator):
    plant, times = plant_of(model), np.linspace(-1.0, 20.0, 421)
    law = LAWS["all gains"](plant)
    flown = tv.fly(plant, law, WIND, times, deflection_limit=1.0, actuator=actuator)
    linear = Autopilot(**GAINS, **MORE, actuator=actuator).respond(plant, WIND, times)
    for row, expected in zip(flown.outputs, linear.outputs, strict=True):
        size = np.abs(expected).max()
        np.testing.assert_allclose(row, expected, rtol=0, atol=PROMISED * size)
    np.testing.assert_array_equal(flown.inputs, linear.inputs)
    assert list(flown.output_labels) == list(linear.output_labels) == [*plant.outputs, "deflection"]
    assert list(flown.input_labels) == ["wind"]


@pytest.mark.parametrize("model", ["fixed-path", "drift", "drift-exact"])
@pytest.mark.parametrize(("dead_band", "release"), [(1.0, 1.0), (0.5, 0.45)])
def test_the_reports_control_is_met_to_the_instant_until_the_law_lets_go(model, dead_band, release):
    """A law that holds the attitude asks for the literal trim, and switches where that does."""
    plant, wind = plant_of(model), TriangularWind(peak=-PEAK, duration=5.0 / BETA)
    law = tv.control.DeadBandLaw(plant_of(), dead_band=dead_band)
    law = tv.TrimLaw(plant_of(), gain=1.0) if dead_band == 1.0 else law
    limit = 1.05 * tv.boundary_limit(plant, wind, dead_band, "literal").deflection
    constant = tv.trim_then_hold(plant, wind, limit, dead_band, "literal")
    trim, top = tv.trim_deflection(plant, wind), wind.duration / 2.0
    switch = brentq(lambda t: float(trim(t)) - dead_band * limit, 0.1, top, xtol=1e-13)

    def excess(t):
        shown = tv.attitude_responses(plant, constant, wind, [t])
        attitude, rate = shown["attitude"], shown["attitude_rate"]
        demand = B * (shown["angle_of_attack"] + attitude + rate / BETA)
        return demand.item() - release * limit

    later = np.arange(switch + 0.05, wind.duration + 3.0, 0.2)
    done = next(t for t in later if excess(t) < 0.0)
    done = brentq(excess, done - 0.2, done, xtol=1e-12)
    times = [*np.linspace(0.1, done - 1e-6, 40), switch - 1e-7, switch + 1e-7]
    flown = tv.fly(plant, law, wind, times, deflection_limit=limit)
    expected = tv.attitude_responses(plant, constant, wind, times)
    for row, output in zip(flown.outputs, plant.outputs, strict=False):
        np.testing.assert_allclose(row, expected[output], rtol=0, atol=1e-8 * PEAK)
    np.testing.assert_allclose(flown.outputs[-1], constant(times), rtol=0, atol=1e-7 * limit)
    after = tv.fly(plant, law, wind, [done - 1e-6, done + 1e-6], deflection_limit=limit)
    assert after.outputs[-1, 0] == limit
    assert after.outputs[-1, 1] == pytest.approx(release * limit, rel=1e-4)
    assert after.outputs[-1, 1] < limit


@pytest.mark.parametrize("sample_rate", [None, 20.0])
def test_a_late_gust_is_not_missed(sample_rate):
    plant, times = plant_of("drift-exact"), np.linspace(0.0, 15.0, 16)
    options = {"deflection_limit": 0.85 * B * PEAK, "sample_rate": sample_rate}
    early = tv.fly(plant, LAWS["trim"](plant), WIND, times, **options)
    assert np.abs(early.outputs[-1]).max() > 0.8 * B * PEAK
    late = tv.fly(
        plant, LAWS["trim"](plant), WIND.shift(500.0), [0.0, 400.0, *(times + 500.0)], **options
    )
    np.testing.assert_array_equal(late.outputs[:, :2], 0.0)
    np.testing.assert_allclose(late.outputs[:, 2:], early.outputs, rtol=0, atol=1e-8 * PEAK)


@pytest.mark.parametrize(("sample_rate", "sees"), [(20.0, 0.0), (None, 1.0)])
def test_a_gust_between_two_samples_acts_by_its_impulse_response(sample_rate, sees):
    """Of 1 ms; the sampled law sees nothing of it before the next sample."""
    a, b = 0.1233, 0.1243
    wind = SampledWind(time=[0.0, a, a, b, b, 0.3], angle=[0, 0, PEAK, PEAK, 0, 0])
    times = np.array([0.1, 0.1234, 0.13, 0.149])
    options = {"deflection_limit": 1.0, "sample_rate": sample_rate}
    flown = tv.fly(plant_of(), LAWS["gains"](None), wind, times, **options)
    since = [np.maximum(times - edge, 0.0) for edge in (a, b)]
    attitude, rate = (f(BETA * since[1]) - f(BETA * since[0]) for f in (np.cosh, np.sinh))
    if sample_rate:
        np.testing.assert_allclose(flown.outputs[0], PEAK * attitude, rtol=1e-9, atol=1e-18)
        np.testing.assert_allclose(flown.outputs[1], PEAK * BETA * rate, rtol=1e-9, atol=1e-18)
    linear = Autopilot(**GAINS).respond(plant_of(), wind, times).outputs
    acted = np.abs(flown.outputs[-1, 2:]) > 0.0
    assert np.all(acted == sees)
    np.testing.assert_allclose(sees * flown.outputs, sees * linear, rtol=0, atol=1e-12)


@pytest.mark.parametrize("sample_rate", [None, 100.0])
@pytest.mark.parametrize("hardware", usual([{}, {"actuator": SERVO}, {"actuator": LAG}], 1))
@pytest.mark.parametrize(("name", "most"), [("gains", 0.0015), ("lean", 0.006)])
def test_limit_and_rate_are_reached_and_never_exceeded(name, most, hardware, sample_rate):
    plant, limit = plant_of("drift-exact"), 0.5 * B * PEAK
    options = {"deflection_limit": limit, "sample_rate": sample_rate} | hardware
    if hardware or sample_rate:
        options["rate_limit"] = most
    times = np.linspace(0.0, 12.0, 601)
    flown = tv.fly(plant, LAWS[name](plant), WIND, times, **options).outputs[-1]
    assert np.abs(flown).max() == pytest.approx(limit, rel=1e-6)
    assert np.abs(flown).max() <= limit
    if "rate_limit" in options:
        rates = np.abs(np.diff(flown)) / np.diff(times)
        # Both deflections of a difference have their error, and 0.02 s lie between them.
        slack = 2.0 * CORNERS * limit / 0.02 if sample_rate is None else 1e-9 * most
        assert rates.max() == pytest.approx(most, rel=1e-5, abs=slack)
        assert rates.max() <= most + slack


@pytest.mark.parametrize("excess", usual([1e-10, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2], 3))
def test_a_limit_that_is_only_touched_is_not_exceeded(excess):
    wind, times = tv.OneMinusCosineGust(peak=PEAK, duration=10.0), np.linspace(0.0, 20.0, 4001)
    free = tv.fly(plant_of(), LAWS["gains"](None), wind, times, deflection_limit=1.0)
    limit = np.abs(free.outputs[-1]).max() / (1.0 + excess)
    flown = tv.fly(plant_of(), LAWS["gains"](None), wind, times, deflection_limit=limit)
    assert np.abs(flown.outputs[-1]).max() <= limit
    loop = Loop(LinearEquations(plant_of()), LAWS["gains"](None), limit, np.inf, actuator=None)
    arcs = continuous.ContinuousFlight(loop, wind).arcs(0.0, 20.0)
    (constant,) = [(a.start, b.start) for a, b in pairwise(arcs) if a.mode]
    times = [constant[0], np.mean(constant), constant[1]]
    linear = np.abs(Autopilot(**GAINS).respond(plant_of(), wind, times).outputs[-1])
    assert linear[0] == pytest.approx(limit, rel=1e-9)
    assert linear[1] >= limit
    assert linear[2] == pytest.approx(limit, rel=max(1e-8, 0.1 * excess if excess < 1e-3 else 1e-2))


class Dip(tv.control.Law):
    """It asks for a little more than the limit, less what it feels of the wind."""

    def __init__(self, most, gain):
        self.most, self.gain = most, gain

    def demand(self, seen, states, limit):
        return self.most - self.gain * (seen.attitude - seen.angle_of_attack)


def test_a_limit_that_is_left_for_a_moment_is_left():
    """At the peak of the wind the demand is just below the limit."""
    wind, limit, depth = tv.OneMinusCosineGust(peak=PEAK, duration=4.0), 0.01, 1e-6
    law = Dip(limit * (1.1 - depth), 0.1 * limit / PEAK)
    times = [0.0, 1.0, 1.9, 2.0, 2.1, 3.0]
    flown = tv.fly(plant_of(), law, wind, times, deflection_limit=limit)
    expected = limit * np.array([1.0, 1.0, 1.0, 1.0 - depth, 1.0, 1.0])
    np.testing.assert_allclose(flown.outputs[-1], expected, rtol=1e-11)


class Watcher(tv.control.Law):
    """A law that writes down what it is shown, and feeds back the attitude."""

    def __init__(self, level=0.0, seed=0):
        self.level, self.seed, self.rates, self.deflections = level, seed, [], []

    @property
    def rate_noise(self):
        return self.level, self.seed

    def demand(self, seen, states, limit):
        self.rates.extend(np.ravel(seen.attitude_rate))
        self.deflections.extend(np.ravel(seen.deflection))
        return 3 * B * (seen.attitude + seen.attitude_rate / BETA)


@pytest.mark.parametrize("sample_rate", [50.0, None])
def test_a_law_is_shown_the_deflection(sample_rate):
    law = Watcher()
    options = {"deflection_limit": 1.0, "actuator": SERVO, "sample_rate": sample_rate}
    times = float(WIND.onset) + np.linspace(0.0, 10.0, 501)
    flown = tv.fly(plant_of(), law, WIND, times, **options)
    shown, deflection = np.array(law.deflections), flown.outputs[-1]
    assert shown.min() == pytest.approx(deflection.min(), rel=1e-3)
    if sample_rate:
        np.testing.assert_allclose(shown[:500], deflection[:500], rtol=1e-9, atol=1e-15)


@pytest.mark.thorough
def test_noise_is_on_the_measured_rate_and_comes_again_with_its_seed():
    def flown(law):
        options = {"deflection_limit": 1.0, "sample_rate": 200.0}
        times = float(WIND.onset) + np.linspace(0.0, 10.0, 101)
        return tv.fly(plant_of(), law, WIND, times, **options).outputs

    quiet, noisy = Watcher(), Watcher(1e-3, 5)
    exact, shaken = flown(quiet), flown(noisy)
    np.testing.assert_array_equal(flown(Watcher(1e-3, 5)), shaken)
    assert np.abs(flown(Watcher(1e-3, 6)) - shaken).max() > 1e-5
    # The loop is linear: twice the noise moves it twice as far.
    np.testing.assert_allclose(flown(Watcher(2e-3, 5)) - exact, 2 * (shaken - exact), atol=1e-12)
    added = np.array(noisy.rates[:2000:20]) - shaken[1, :100]
    assert np.std(added) == pytest.approx(1e-3, rel=0.25)
    assert abs(np.mean(added)) < 4e-4
    slow = tv.RecoverableAttitudeLaw(
        plant_of(), estimator=tv.control.WindEstimator(bandwidth=5.0, rate_noise=1e-3, seed=5)
    )
    np.testing.assert_array_equal(flown(slow), flown(slow))


@pytest.mark.parametrize("sample_rate", [None, 50.0])
def test_times_may_stand_in_any_order_before_the_wind_and_on_its_knots(sample_rate):
    plant, law = plant_of("drift-exact"), LAWS["trim"](None)
    options = {"deflection_limit": 0.85 * B * PEAK, "sample_rate": sample_rate}
    times = np.array([-1.0, 0.0, 0.013, 2.0, 3.0, 7.577, 9.0, 11.0, 15.0])
    order = np.array([8, 5, 0, 3, 3, 1, 7, 2, 6, 4])
    rising = tv.fly(plant, law, WIND, times, **options)
    mixed = tv.fly(plant, law, WIND, times[order], **options)
    np.testing.assert_allclose(mixed.outputs, rising.outputs[:, order], rtol=0, atol=1e-15)
    np.testing.assert_array_equal(mixed.time, times[order])
    np.testing.assert_array_equal(rising.outputs[:, :2], 0.0)
    angle = rising.outputs[0] - rising.outputs[2] - WIND(times)  # after the jump at a knot
    np.testing.assert_allclose(rising.outputs[3], angle, atol=1e-15)
    for t in (-3.0, 7.577, 10.99):
        single = tv.fly(plant, law, WIND, [0.0, t] if t > 0 else [t], **options)
        expected = tv.fly(plant, law, WIND, [0.0, t, 16.0], **options)
        np.testing.assert_allclose(single.outputs[:, -1], expected.outputs[:, 1], atol=1e-10 * PEAK)


@pytest.mark.thorough
@pytest.mark.parametrize("hardware", usual([{}, {"actuator": SERVO}, {"actuator": LAG}], 1))
@pytest.mark.parametrize("sample_rate", [None, 41.0])
def test_the_flight_does_not_depend_on_the_times_asked_for(sample_rate, hardware):
    plant, law = plant_of("drift-exact"), LAWS["lean"](plant_of("drift-exact"))
    options = {"deflection_limit": 0.5 * B * PEAK, "sample_rate": sample_rate} | hardware
    few, many = (
        tv.fly(plant, law, WIND, times, **options).outputs
        for times in ([3.0, 9.0], [-1.0337, 0.0, 0.01, 3.0, 8.0, 9.0, 13.7])
    )
    np.testing.assert_allclose(few, many[:, [3, 5]], rtol=0, atol=1e-9 * PEAK)
    assert np.abs(few[-1]).max() > 0.1 * B * PEAK


class Follower(tv.control.Law):
    """A law that looks at the deflection itself."""

    def demand(self, seen, states, limit):
        return 3 * B * (seen.attitude + seen.attitude_rate / BETA) - 0.1 * seen.deflection


@pytest.mark.thorough
def test_without_an_actuator_there_is_no_deflection_before_the_demand():
    flight = (plant_of(), Follower(), WIND, [0.0, 5.0])
    with pytest.raises(InputError, match="looks at the deflection needs an actuator or a sample"):
        tv.fly(*flight, deflection_limit=1.0)
    free = tv.fly(*flight, deflection_limit=1.0, actuator=SERVO)
    sampled = tv.fly(*flight, deflection_limit=1.0, actuator=SERVO, sample_rate=2000.0)
    np.testing.assert_allclose(sampled.outputs, free.outputs, rtol=0, atol=2e-3 * PEAK)
    assert np.abs(free.outputs[0, -1]) > 0.1 * PEAK


def test_the_last_time_shows_what_it_shows_in_a_longer_flight():
    options = {"deflection_limit": B * PEAK, "sample_rate": 50.0}
    last, within = (
        tv.fly(plant_of(), LAWS["trim"](None), WIND, times, **options).outputs[:, 1]
        for times in ([0.0, 4.0], [0.0, 4.0, 5.0])
    )
    np.testing.assert_allclose(last, within, rtol=0, atol=1e-12)


@pytest.mark.thorough
@pytest.mark.parametrize("sample_rate", [None, 20.0])
def test_a_flight_that_is_lost_is_not_flown_on_for_ever(sample_rate):
    options = {"deflection_limit": 0.1 * B * PEAK, "sample_rate": sample_rate}
    with pytest.raises(InputError, match="lost and grows without.* before t = 4[0-9][0-9]") as said:
        tv.fly(plant_of(), LAWS["trim"](None), WIND, [0.0, 3000.0], **options)
    last = float(str(said.value).split("=")[1].split()[0])
    flown = tv.fly(plant_of(), LAWS["trim"](None), WIND, [0.0, last - 1.0], **options)
    assert np.abs(flown.outputs[0, -1]) > 1e98


class Relay(tv.control.Law):
    """A law that is at its limit nearly always."""

    engage, release = 1e-3, 0.9e-3

    def demand(self, seen, states, limit):
        return B * (seen.attitude + seen.attitude_rate / BETA)


def test_a_law_that_chatters_is_told_to_be_sampled(monkeypatch):
    monkeypatch.setattr(continuous, "_MAX_SWITCHES", 30)
    with pytest.raises(InputError, match="switches more than 30 times; give a sample_rate"):
        tv.fly(plant_of(), Relay(), WIND, [0.0, 20.0], deflection_limit=B * PEAK)


@pytest.mark.thorough
@pytest.mark.parametrize("late", usual([1e6, 1e8], 0))
def test_a_flight_long_after_the_beginning_of_time_is_that_at_zero(late):
    plant, law = plant_of("fixed-path"), LAWS["lean"](plant_of("fixed-path"))
    times = np.linspace(0.0, 30.0, 7)
    hardware = {"deflection_limit": 0.7 * B * PEAK, "actuator": SERVO}
    early = tv.fly(plant, law, WIND, times, **hardware).outputs["attitude"]
    computed = tv.fly(plant, law, WIND.shift(late), late + times, **hardware).outputs["attitude"]
    # knots there are known to a rounding of the time, and at the end BETA e^(BETA t) feels it
    lost = np.finfo(float).eps * late * np.abs(early).max() * BETA * np.exp(BETA * WIND.end)
    np.testing.assert_allclose(computed, early, rtol=0.0, atol=lost + CORNERS * np.abs(early).max())


@pytest.mark.thorough
def test_a_boundary_flown_long_after_the_beginning_of_time_is_that_at_zero():
    booster = tv.load_vehicle("configuration-i")
    law = tv.TrimLaw(Plant.from_vehicle(booster, "fixed-path"), gain=10.0)
    how = {"law": law, "actuator": Actuator(), "tolerance": 0.05}
    wind = TriangularWind(peak=0.01, duration=3.0)
    early, late = (tv.flown_boundary(booster, w, **how) for w in (wind, wind.shift(1e9)))
    assert (late.limit, late.flights) == (early.limit, early.flights)


def test_the_evaluations_of_a_flight_are_bounded(monkeypatch):
    monkeypatch.setattr(continuous, "_MAX_EVALUATIONS", 100)
    with pytest.raises(InputError, match="more than 100 evaluations of its equations, at t = "):
        tv.fly(plant_of(), LAWS["lean"](plant_of()), WIND, [0.0, 20.0], deflection_limit=0.01)


NOISY = tv.RecoverableAttitudeLaw(
    plant_of(), estimator=tv.control.WindEstimator(bandwidth=5.0, rate_noise=1e-3)
)
BATCH = Plant.from_coefficients(COEFFICIENTS.replace(mu_alpha=[0.2, 0.3]))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"deflection_limit": 0.0}, "deflection_limit must be positive"),
        ({"deflection_limit": -0.01}, "deflection_limit must be positive"),
        ({"deflection_limit": np.inf}, "deflection_limit must be finite"),
        ({"deflection_limit": [0.01, 0.02]}, "deflection_limit must be one number"),
        ({"rate_limit": 0.0, "sample_rate": 50.0}, "rate_limit must be positive"),
        ({"rate_limit": np.nan, "sample_rate": 50.0}, "rate_limit must be finite"),
        ({"rate_limit": 0.1}, "a rate_limit needs an actuator or a sample_rate"),
        ({"law": NOISY}, "noise belongs to samples; give a sample_rate"),
        ({"sample_rate": 0.0}, "sample_rate must be positive"),
        ({"sample_rate": 0.1, "actuator": SERVO}, "must be at least 0.16 Hz for an actuator of 20"),
        ({"actuator": 20.0}, "actuator must be an Actuator"),
        (
            {"actuator": Actuator(natural_frequency=[20.0, 30.0])},
            r"one actuator; got a batch of shape \(2",
        ),
        ({"law": Autopilot(**GAINS)}, "law must be a Law"),
        ({"plant": BATCH}, r"one plant in one wind; got batches of shape \(2,\) and \(\)"),
        ({"wind": TriangularWind(peak=[0.1, 0.2], duration=5.0)}, "one plant in one wind"),
        ({"wind": tv.linear.ConstantDeflection(limit=0.1)}, "wind must end"),
        ({"wind": 0.0 * WIND}, "wind must end, and be other than zero"),
        ({"wind": 0.1}, "wind must be a History"),
        ({"plant": WIND}, "plant must be a Plant"),
        ({"timepts": 3.0}, "timepts must be one row of numbers"),
        ({"timepts": []}, "timepts must be one row of numbers"),
        ({"timepts": [0.0, np.nan]}, "timepts must be finite"),
    ],
)
def test_flights_that_cannot_be(arguments, message):
    usual = {"plant": plant_of(), "law": LAWS["trim"](None), "wind": WIND, "timepts": [0.0, 1.0]}
    with pytest.raises(InputError, match=message):
        tv.fly(**usual | {"deflection_limit": 0.01} | arguments)
