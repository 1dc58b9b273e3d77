"""Sampled autopilots: check cases, sums over aliases, small steps, a simulation at the edge."""

import tracemalloc
import warnings
from dataclasses import replace

import control
import numpy as np
import pytest
from scipy.linalg import expm
from scipy.signal import bilinear, tf2ss

import tvclin as tv
from tests.control.test_flexible_loops import AUTOPILOT, FILTERS, booster, to_margin
from tests.flexible import BOOSTER, transfer
from tests.turns import usual
from tvclin.control.autopilot.actuator import plant_with_actuator
from tvclin.control.autopilot.wiring import COMMAND

SAMPLED = replace(AUTOPILOT, sample_rate=25.0)
SLOW = "is below twice the frequency of bending 3"


@pytest.mark.thorough
def test_the_booster_sampled_at_25_hertz():
    plant = booster()
    loop = SAMPLED.exact_loop(plant)
    assert loop.response(14.0) == pytest.approx(-2.24657083 - 4.72188699j, abs=1e-8)
    assert np.abs(loop.closed_loop_poles).max() == pytest.approx(0.99815586, abs=1e-8)
    result = SAMPLED.band_margins(plant)
    m = result.margins
    assert m.aero_margin_dB == to_margin(9.952950)
    assert (m.gain_increase_dB, m.gain_increase_frequency) == (
        to_margin(7.774023),
        to_margin(4.888663),
    )
    assert (m.phase_margin_deg, m.crossover_frequency) == (
        to_margin(38.082280),
        to_margin(14.859371),
    )
    assert result.rigid.phase_margin_deg == to_margin(41.333057)
    assert result.rigid.crossover_frequency == to_margin(1.412942)
    assert m.disk_margin == pytest.approx(0.62741270, abs=1e-8)
    # A delay of 1.1 samples more is a little less than phase over frequency says.
    late = np.radians(m.phase_margin_deg) / m.crossover_frequency
    assert m.delay_margin == pytest.approx(late, rel=1e-3)
    edge = replace(SAMPLED, delay=SAMPLED.delay + m.delay_margin).exact_loop(plant)
    assert np.abs(edge.closed_loop_poles).max() == pytest.approx(1.0, abs=1e-11)


def test_the_booster_sampled_at_12_hertz_and_a_half():
    slow = replace(AUTOPILOT, sample_rate=12.5, delay=0.08)
    plant = booster()
    with pytest.warns(UserWarning, match=SLOW):
        assert slow.margins(plant).unstable_poles == 2
    loop = slow.exact_loop(plant)
    assert np.sum(np.abs(loop.closed_loop_poles) > 1.0) == 2
    with pytest.warns(UserWarning, match=SLOW):
        result = slow.band_margins(plant)
    # 64.96 rad/s is seen at 2 pi 12.5 - 64.96 rad/s.
    assert result.mode("bending 3").alias == pytest.approx(25 * np.pi - 64.96177493, abs=1e-7)
    assert np.isnan(result.mode("bending 1").alias)


def by_aliases(autopilot, plant, omega, terms=640):
    """Return L(e^(j omega h)) as the sum over all frequencies that have the same samples."""
    rate, delay = autopilot.sample_rate, autopilot.delay
    h = 1.0 / rate
    seen = plant_with_actuator(plant, autopilot.actuator)
    rows = [seen.outputs.index(n) for n in ("sensed_attitude", "sensed_attitude_rate")]
    held = np.zeros(2, dtype=complex)
    for k in range(-terms, terms + 1):
        s = 1j * (omega + 2.0 * np.pi * rate * k)
        hold = (1.0 - np.exp(-s * h)) / (s * h)
        held += transfer(seen.matrices(), s)[rows, 0] * hold * np.exp(-s * delay)
    z = np.exp(1j * omega * h)
    value = autopilot.attitude_gain * held[0] + autopilot.rate_gain * held[1]
    for one, own in zip(autopilot.filters, (13.0, 32.0), strict=True):
        value *= one(own / np.tan(0.5 * own * h) * (z - 1.0) / (z + 1.0))[()]
    return -value


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("rate", "delay"), usual([(25.0, 0.02), (25.0, 0.11), (12.5, 0.08), (40.0, 0.0)], 1)
)
def test_the_loop_is_the_sum_over_all_aliases(rate, delay):
    autopilot = replace(AUTOPILOT, sample_rate=rate, delay=delay)
    loop = autopilot.exact_loop(booster())
    for omega in (0.3, 5.0, 13.6, 0.9 * np.pi * rate):
        # The terms fall as 1/omega^3, with the inertia of the engine; those left out are 1e-9.
        expected = by_aliases(autopilot, booster(), omega)
        assert loop.response(omega) == pytest.approx(expected, rel=1e-7, abs=1e-9)


def test_with_small_steps_the_loop_is_the_continuous_one():
    plant = booster()
    omega = np.array([0.3, 1.4, 5.0, 14.0])
    exact = AUTOPILOT.frequency_response(plant, omega)
    # A hold is half a step late; with that taken off what is left falls with the square.
    errors = []
    for rate in (400.0, 800.0):
        one = replace(AUTOPILOT, sample_rate=rate, delay=AUTOPILOT.delay - 0.5 / rate)
        errors.append(np.abs(one.frequency_response(plant, omega) - exact))
    np.testing.assert_allclose(errors[0] / errors[1], 4.0, rtol=0.02)


def test_a_delay_of_any_length_moves_on_in_step_with_the_samples():
    plant = booster()
    omega = np.array([0.5, 3.0, 14.0])
    first = SAMPLED.frequency_response(plant, omega)
    for whole in (1, 3):
        later = replace(SAMPLED, delay=0.02 + 0.04 * whole).frequency_response(plant, omega)
        np.testing.assert_allclose(later, first * np.exp(-0.04j * whole * omega), rtol=1e-10)
    near = [
        replace(SAMPLED, delay=0.04 + e).frequency_response(plant, omega) for e in (-1e-9, 1e-9)
    ]
    np.testing.assert_allclose(near[0], near[1], rtol=1e-6)


def test_a_rigid_plant_is_sampled_as_well_with_all_its_feedbacks():
    """With a hold, half a step late, and the integral of what is held, half a step later still."""
    plant = tv.Plant.from_vehicle(BOOSTER, "drift-exact")
    gains = {"attitude_gain": 0.36, "rate_gain": 0.56, "alpha_gain": 0.1}
    omega = np.array([0.3, 1.4])
    straight, whole = (
        tv.Autopilot(**gains, **more, delay=0.02).frequency_response(plant, omega)
        for more in ({}, {"integral_gain": 0.02})
    )
    errors = []
    for rate in (100.0, 200.0):
        one = tv.Autopilot(**gains, integral_gain=0.02, delay=0.02 - 0.5 / rate, sample_rate=rate)
        expected = straight + (whole - straight) * np.exp(-0.5j * omega / rate)
        errors.append(np.abs(one.frequency_response(plant, omega) - expected))
    np.testing.assert_allclose(errors[0] / errors[1], 4.0, rtol=0.02)


@pytest.mark.thorough
@pytest.mark.parametrize("late", [0, 1, 2])
@pytest.mark.parametrize("model", ["fixed-path", "drift-exact", "drift-and-speed"])
def test_a_rigid_loop_and_its_margins_are_those_of_python_control(model, late):
    """Which holds plant and nozzle, warps the filter, and closes the loop, all by itself."""
    plant, h, own = tv.Plant.from_vehicle(BOOSTER, model), 0.05, 13.0
    servo, shelf = tv.Actuator(natural_frequency=30.0), tv.vehicle.Filter.low_pass(own, 0.7)
    autopilot = tv.Autopilot(
        attitude_gain=0.5, rate_gain=0.7, actuator=servo, filters=(shelf,),
        delay=late * h, sample_rate=1.0 / h,
    )  # fmt: skip
    airframe = plant.ss()[["attitude", "attitude_rate"], ["deflection"]]
    held = control.sample_system(control.series(control.ss(servo.tf()), airframe), h, "zoh")
    warped = control.sample_system(
        control.tf(shelf.numerator, shelf.denominator), h, "bilinear", prewarp_frequency=own
    )
    sums = control.ss([], [], [], [[-0.5, -0.7]], h)  # L is minus what returns
    waits = control.ss(np.eye(late, k=-1), np.eye(late, 1), np.eye(late)[-1:], 0.0, h)
    chain = [held, sums, control.ss(warped), *([waits] if late else [])]
    loop = control.series(*chain)
    omega = np.array([0.3, 1.4, 5.0, 30.0, 60.0])
    result = autopilot.frequency_response(plant, omega)
    np.testing.assert_allclose(result, loop(np.exp(1j * omega * h)), rtol=1e-9)
    poles = autopilot.exact_loop(plant).closed_loop_poles
    theirs = control.feedback(loop, 1).poles()
    assert np.abs(poles).max() == pytest.approx(np.abs(theirs).max(), rel=1e-9)
    at = 1.3 * np.exp(1j * np.linspace(0.1, 3.0, 7))[:, np.newaxis]
    np.testing.assert_allclose(np.prod(at - poles, -1), np.prod(at - theirs, -1), rtol=1e-9)
    m = autopilot.margins(plant)
    for factor, omega in (
        (1.0 / m.aero_margin, m.aero_frequency),
        (m.gain_increase, m.gain_increase_frequency),
    ):
        assert factor * loop(np.exp(1j * omega * h)) == pytest.approx(-1.0, rel=1e-9)
        edge = control.feedback(factor * loop, 1).poles()
        assert np.abs(edge).max() == pytest.approx(1.0, abs=1e-9)
    turned = np.exp(-1j * m.phase_margin) * loop(np.exp(1j * m.crossover_frequency * h))
    assert turned == pytest.approx(-1.0, rel=1e-9)


def flown(autopilot, plant, seconds, parts=8):
    """Return the attitude of a flight in which every command is applied at its time."""
    seen = plant_with_actuator(plant, autopilot.actuator)
    h, n = 1.0 / autopilot.sample_rate, len(seen.A)
    rows = [seen.outputs.index(name) for name in ("sensed_attitude", "sensed_attitude_rate")]
    held = np.zeros((n + 1, n + 1))
    held[:n, :n], held[:n, n:] = seen.A * h / parts, seen.B[:, :1] * h / parts
    step = expm(held)
    late = round(autopilot.delay * parts / h)
    assert late == pytest.approx(autopilot.delay * parts / h)
    chain = []
    for one, own in zip(autopilot.filters, (13.0, 32.0), strict=True):
        c = own / np.tan(0.5 * own * h)
        chain.append([*tf2ss(*bilinear(one.numerator, one.denominator, 0.5 * c)), np.zeros((2, 1))])
    state = np.zeros(n)
    state[1] = 1e-3
    commands = np.zeros(round(seconds / h) * parts + late + parts)
    attitude = []
    for k in range(round(seconds / h)):
        y = seen.C[rows] @ state
        attitude.append(y[0])
        u = autopilot.attitude_gain * y[0] + autopilot.rate_gain * y[1]
        for one in chain:
            A, B, C, D, x = one
            u, one[4] = (C @ x + D * u).item(), A @ x + B * u
        commands[k * parts + late :] = u
        for part in range(parts):
            state = step[:n, :n] @ state + step[:n, n] * commands[k * parts + part]
    return np.array(attitude)


@pytest.mark.thorough
def test_a_long_simulation_grows_just_beyond_the_margin_and_dies_just_before():
    plant = booster()
    rise = SAMPLED.margins(plant).gain_increase
    for part, grows in ((0.995, False), (1.005, True)):
        gains = {"attitude_gain": 0.36 * rise * part, "rate_gain": 0.56 * rise * part}
        seen = flown(replace(SAMPLED, **gains), plant, 240.0)
        early, end = (np.abs(seen[a : a + 1000]).max() for a in (2000, 5000))
        assert (end > early) == grows


def test_filters_are_exact_at_their_own_frequency():
    plant = booster()
    for one, own in (
        (FILTERS[0], 13.0),
        (FILTERS[1], 32.0),
        (tv.vehicle.Filter.lead_lag(4.0, 9.0), 9.0),
    ):
        bare = replace(SAMPLED, filters=()).frequency_response(plant, own)
        result = replace(SAMPLED, filters=(one,)).frequency_response(plant, own)
        assert result / bare == pytest.approx(one(1j * own)[()], rel=1e-10)


def test_the_vehicle_moves_in_steps_as_it_does_between_them():
    plant = booster()
    seen = plant_with_actuator(plant, SAMPLED.actuator)
    steps = seen.select((COMMAND,), plant.sensed).to_steps(0.04, 0.05)
    late = ("deflection_command_1", "deflection_command_2")
    assert steps.states == (*plant.states, "actuator_deflection", "actuator_rate", *late)
    # From rest under one command: steady for ever is what the exponential says at that time.
    held = np.zeros((18, 18))
    held[:17, :17], held[:17, 17:] = seen.A, seen.B[:, :1]
    state = np.zeros((19, 1))
    for _ in range(4):
        state = steps.A @ state + steps.B
    moved = 4 * 0.04 - 0.05  # the first command leaves with the first step
    expected = expm(held * moved)[:17, 17:]
    np.testing.assert_allclose(state[:17], expected, rtol=1e-9, atol=1e-12)


@pytest.mark.thorough
def test_a_batch_of_rates_and_delays_is_each_of_them():
    plant = booster()
    rates, delays = np.array([25.0, 25.0, 50.0]), np.array([0.02, 0.05, 0.02])
    many = replace(SAMPLED, sample_rate=rates, delay=delays).margins(plant)
    for k in range(3):
        one = replace(SAMPLED, sample_rate=rates[k], delay=delays[k]).margins(plant)
        assert many.phase_margin[k] == pytest.approx(one.phase_margin, rel=1e-8)
        assert many.gain_increase[k] == pytest.approx(one.gain_increase, rel=1e-8)


def test_what_cannot_be_sampled_is_refused():
    with pytest.raises(tv.InputError, match="must lie below half the sample rate"):
        replace(SAMPLED, sample_rate=8.0).margins(booster())
    with pytest.raises(tv.InputError, match="delay must be at most 25 sample periods"):
        replace(SAMPLED, delay=5.0).margins(booster())
    with pytest.raises(tv.InputError, match="is too low for a vehicle whose motion grows"):
        replace(SAMPLED, sample_rate=1e-3, filters=()).margins(booster())
    for call in (
        SAMPLED.close,
        SAMPLED.closed_loop_poles,
        SAMPLED.wind_response_function,
    ):
        with pytest.raises(tv.InputError, match="is for continuous autopilots"):
            call(booster())
    with pytest.raises(tv.InputError, match="sample_rate"):
        replace(SAMPLED, sample_rate=0.0)
    with pytest.raises(tv.InputError, match="omega"):
        SAMPLED.frequency_response(booster(), 100.0)


@pytest.mark.thorough
@pytest.mark.parametrize("late", [0.0, 0.3, 0.9999, 1.0, 1.7])
@pytest.mark.parametrize("rate", [8.0, 25.0])
def test_a_delay_margin_ends_where_an_eigenvalue_is_on_the_circle(rate, late):
    """Whatever part of a sample the delay then is: with less all are inside, with more not."""
    plant = tv.Plant.from_vehicle(BOOSTER, "drift-exact")
    one = tv.Autopilot(
        attitude_gain=0.5,
        rate_gain=0.8,
        actuator=tv.Actuator(natural_frequency=12.0),
        delay=late / rate,
        sample_rate=rate,
    )
    margin = one.margins(plant).delay_margin
    for part in (0.2, 0.5, 0.8, 0.99, 1.0, 1.001):
        loop = replace(one, delay=one.delay + part * margin).exact_loop(plant)
        radius = np.abs(loop.closed_loop_poles).max()
        if part == 1.0:
            assert radius == pytest.approx(1.0, abs=1e-10)
        else:
            assert (radius < 1.0) == (part < 1.0)


@pytest.mark.thorough
def test_a_mode_beside_half_the_sample_rate_grows_with_less_delay_than_phase_says():
    """Its |L| is below one at this part of a sample, and above it a third of a sample later."""
    autopilot = tv.Autopilot(
        attitude_gain=1.4807,
        rate_gain=1.3851,
        integral_gain=0.0727,
        actuator=tv.Actuator(natural_frequency=69.66),
        delay=0.0349767,
        sample_rate=23.65,
        filters=(tv.vehicle.Filter.low_pass(13.0, 0.95),),
    )
    vehicle = tv.load_vehicle("made-up-booster")
    plant = tv.FlexiblePlant.from_vehicle(vehicle, vehicle.structure, "drift-and-speed")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        margins = autopilot.margins(plant)
    assert margins.stable
    for part in (0.5, 0.9, 0.999, 1.001):
        late = autopilot.delay + part * margins.delay_margin
        loop = replace(autopilot, delay=late).exact_loop(plant)
        assert (np.abs(loop.closed_loop_poles).max() < 1.0) == (part < 1.0)


@pytest.mark.thorough
@pytest.mark.parametrize("rate", [50.0, 5000.0])
def test_a_delay_margin_of_thousands_of_samples_takes_little_memory(rate):
    """Half-relief gains also have a slow crossover, which only 1400 s of delay take to -1."""
    plant = tv.Plant.from_vehicle(tv.load_schedule("configuration-i").at(41.0), "drift-exact")
    continuous = replace(
        tv.control.half_relief_gains(plant), actuator=tv.Actuator(natural_frequency=25.1)
    )
    sampled = replace(continuous, sample_rate=rate)
    tracemalloc.start()
    margin = sampled.margins(plant).delay_margin
    assert tracemalloc.get_traced_memory()[1] < 3e8
    tracemalloc.stop()
    # A held command is half a sample late.
    expected = continuous.margins(plant).delay_margin - 0.5 / rate
    assert margin == pytest.approx(expected, rel=1.0 / rate**2)
    if rate == 50.0:
        poles = sampled.exact_loop(plant).delayed_closed_poles
        radii = np.abs(poles(margin * np.array([0.999, 1.0, 1.001]), np.zeros(3, int))).max(-1)
        assert radii[0] < 1.0 < radii[2]
        assert radii[1] == pytest.approx(1.0, abs=1e-10)


def test_the_loop_in_steps_of_python_control_is_the_exact_one():
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    autopilot = tv.Autopilot(
        attitude_gain=0.3, rate_gain=0.5, actuator=tv.Actuator(), delay=0.013, sample_rate=50.0
    )
    steps, omega = autopilot.loop(plant), np.array([0.3, 2.0, 40.0])
    assert steps.dt == 0.02
    expected = autopilot.frequency_response(plant, omega)
    np.testing.assert_allclose(steps(np.exp(1j * omega * 0.02)), expected, rtol=1e-9)
