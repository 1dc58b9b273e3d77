"""Loops in turbulence: covariances against frequency integrals, sampled flights and integration."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.linalg import expm
from scipy.signal import welch

import tvclin as tv
from tvclin.ascent.schedule_file import load_schedule
from tvclin.base.errors import InputError
from tvclin.control import (
    LoadSlopes,
    SensorNoise,
    turbulence_along,
    turbulence_covariance,
    turbulence_history,
)

BOOSTER = tv.load_vehicle("configuration-i")
SPEED = float(BOOSTER.velocity)
ACTUATOR = tv.Actuator(natural_frequency=25.0, damping=0.7)
AUTOPILOT = tv.Autopilot(attitude_gain=0.2144578, rate_gain=0.4862230, actuator=ACTUATOR)
AIR = tv.winds.Turbulence(6.0, 533.4)
WIND = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
EXACT = tv.Plant.from_vehicle(BOOSTER, "drift-exact")
BEND = {"damping": 0.005, "modal_mass": 5.1e4, "gimbal_displacement": 1.0, "gimbal_slope": -0.068}
BEND |= {"attitude_slope": 0.027, "rate_slope": 0.025, "pressure_displacement": -0.43}
STRUCTURE = tv.Structure(
    bending=tuple(tv.vehicle.BendingMode(frequency=w, **BEND) for w in (13.6, 30.0)),
    rate_gyro=tv.vehicle.Filter.low_pass(120.0, 0.7),
)
NOTCHES = tuple(tv.vehicle.Filter.notch(w, 0.06, 0.6) for w in (13.6, 30.0))


@pytest.mark.parametrize(
    ("model", "rms", "travel"),
    [
        ("fixed-path", [0.216724, 0.095428, 0.698240, 0.0656728, 0.0726218], 0.0579438),
        ("drift-exact", [0.209806, 0.097643, 0.692901, 0.0654089, 0.0730072], 0.0582513),
    ],
)
def test_configuration_i_in_6_m_per_s(model, rms, travel):
    """By a program of its own: Lyapunov's equation of filter and loop."""
    plant = tv.Plant.from_vehicle(BOOSTER, model)
    result = turbulence_covariance(AUTOPILOT, plant, AIR, SPEED)
    names = ["attitude", "attitude_rate", "angle_of_attack", "deflection", "deflection_rate"]
    degrees = np.degrees([result.rms(name) for name in names])
    assert np.allclose(degrees, rms, rtol=0.0, atol=0.6 * 10.0 ** -np.array([6, 6, 6, 7, 7]))
    assert np.degrees(result.mean_absolute_rate()) == pytest.approx(travel, abs=6e-8)


def deflection_response(autopilot, plant, omega, noise=None):
    """Return the deflection per wind, or per noise of a sensor, with an exact delay."""
    s = 1j * omega
    A, B, C, D = plant.matrices()
    names = plant.outputs
    gains = {"attitude": autopilot.attitude_gain, "attitude_rate": autopilot.rate_gain}
    gains["angle_of_attack"] = autopilot.alpha_gain
    above, below = np.array([625.0]), np.array([1.0, 35.0, 625.0])
    ahead = np.polyval(above, s) / np.polyval(below, s) * np.exp(-s * autopilot.delay)
    transfer = C @ np.linalg.solve(s * np.eye(len(A)) - A, B) + D
    fed = sum(gain * transfer[names.index(name)] for name, gain in gains.items())
    source = fed[1] if noise is None else gains[noise]
    return ahead * source / (1.0 - ahead * fed[0])


def frequency_integral(function, corners):
    """Return the integral over all frequencies, in parts between the corners."""
    ends = [0.0, *corners, 1e5]
    parts = [quad(function, a, b, epsrel=1e-9, limit=400)[0] for a, b in zip(ends, ends[1:])]  # noqa: B905, RUF007
    return sum(parts)


@pytest.mark.thorough
@pytest.mark.parametrize("alpha_gain", [0.0, 0.3])
def test_a_variance_is_the_integral_of_the_spectrum_with_the_exact_delay(alpha_gain):
    autopilot = replace(AUTOPILOT, delay=0.06, alpha_gain=alpha_gain)
    result = turbulence_covariance(autopilot, EXACT, AIR, SPEED)

    def power(omega):
        size = abs(deflection_response(autopilot, EXACT, omega)) / SPEED
        return size**2 * float(AIR.power_spectrum(omega, SPEED))

    corners = [1e-3, 0.01, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0]
    variance = frequency_integral(power, corners)
    assert np.isclose(result.rms(), np.sqrt(variance), rtol=1e-6)  # Pade of order four
    rate = frequency_integral(lambda w: w**2 * power(w), corners)
    assert np.isclose(result.rms("deflection_rate"), np.sqrt(rate), rtol=1e-5)
    omega = np.array([0.05, 0.7, 5.0])
    assert np.allclose(result.spectrum(omega), [power(w) for w in omega], rtol=1e-5)


def test_noise_of_the_sensors_adds_its_integral():
    noise = SensorNoise(attitude=2e-4, rate=3e-4)
    calm = replace(AIR, intensity=0.0)
    result = turbulence_covariance(AUTOPILOT, EXACT, calm, SPEED, noise=noise)

    def power(omega):
        parts = {"attitude": noise.attitude, "attitude_rate": noise.rate}
        sizes = [abs(deflection_response(AUTOPILOT, EXACT, omega, k)) * n for k, n in parts.items()]
        return float(np.sum(np.square(sizes))) / (2.0 * np.pi)  # one-sided, per Hz

    variance = frequency_integral(power, [1e-3, 0.01, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 1e3])
    assert np.isclose(result.rms(), np.sqrt(variance), rtol=1e-7)
    assert "deflection_acceleration" not in result.outputs
    both = turbulence_covariance(AUTOPILOT, EXACT, AIR, SPEED, noise=noise)
    single = turbulence_covariance(AUTOPILOT, EXACT, AIR, SPEED)
    assert np.isclose(both.rms() ** 2, result.rms() ** 2 + single.rms() ** 2, rtol=1e-9)
    sampled = replace(AUTOPILOT, sample_rate=5000.0)
    fast = turbulence_covariance(sampled, EXACT, calm, SPEED, noise=noise)
    assert np.isclose(fast.rms(), result.rms(), rtol=1e-3)


def test_loads_are_sums_of_angle_and_deflection():
    slopes = LoadSlopes(dynamic_pressure=3e4, alpha_moment=2e7, deflection_moment=-1e7)
    result = turbulence_covariance(AUTOPILOT, EXACT, AIR, SPEED, loads=slopes)
    assert np.isclose(result.rms("q_alpha"), 3e4 * result.rms("angle_of_attack"))
    assert np.isclose(result.rms("drift_rate"), SPEED * result.rms("flight_path_angle"))
    tilted = [
        turbulence_covariance(
            AUTOPILOT, EXACT, AIR, SPEED, loads=LoadSlopes(alpha_moment=a, deflection_moment=d)
        ).rms("bending_moment")
        for a, d in ((1.0, 1.0), (1.0, -1.0))
    ]
    squares = result.rms("angle_of_attack") ** 2 + result.rms() ** 2
    assert np.isclose(sum(np.square(tilted)), 2.0 * squares)


def sampled_motion(autopilot, winds, step):
    """Return the deflection and its rate in winds ``(runs, n)``, straight between their times."""
    system = autopilot.close(EXACT)
    names = list(system.state_labels)
    A, B = system.A, system.B[:, [list(system.input_labels).index("wind")]]
    n = len(A)
    whole = np.zeros((n + 2, n + 2))
    whole[:n, :n], whole[:n, [n]], whole[n, n + 1] = A, B, 1.0
    transition = expm(whole * step)
    F, G, H = transition[:n, :n], transition[:n, n], transition[:n, n + 1]
    x, motion = np.zeros((len(winds), n)), []
    rows = [names.index("actuator_deflection"), names.index("actuator_rate")]
    for k in range(winds.shape[1]):
        motion.append(x[:, rows])
        if k + 1 < winds.shape[1]:
            slope = (winds[:, k + 1] - winds[:, k]) / step
            x = x @ F.T + np.outer(winds[:, k], G) + np.outer(slope, H)
    return np.moveaxis(np.array(motion), 0, -1)


@cache
def flown_in_a_triangle(runs):
    """Return times, deflections and rates of flights from rest, in turbulence and a wind."""
    step = 0.02
    times = step * np.arange(1001)
    winds = AIR.winds(times, SPEED, seed=60, runs=runs).angle + WIND(times)
    return times, *np.moveaxis(sampled_motion(AUTOPILOT, winds, step), 1, 0)


@pytest.mark.thorough
@pytest.mark.parametrize("runs", [400, pytest.param(10_000, marks=pytest.mark.thorough)])
def test_flights_in_sampled_turbulence_have_mean_spread_travel_and_crossings(runs):
    times, deflections, rates = flown_in_a_triangle(runs)
    result = turbulence_history(AUTOPILOT, EXACT, AIR, SPEED, 20.0, wind=WIND)
    assert np.degrees(result.travel()) == pytest.approx(2.0484, abs=5e-5)
    limit = np.radians(0.82)
    assert result.crossings(limit) == pytest.approx(0.02914, abs=5e-6)
    assert result.probability_of_none(limit) == pytest.approx(np.exp(-0.02914), abs=5e-6)
    at = np.searchsorted(result.times, times - 1e-9)[50::50]
    here = slice(50, None, 50)
    spread = result.deviation()[at]
    assert np.all(np.abs(deflections[:, here].mean(0) - result.mean()[at]) < 5 * spread / runs**0.5)
    deviation = deflections[:, here].std(0)
    assert np.all(np.abs(deviation / spread - 1.0) < 5.0 / np.sqrt(2.0 * runs))
    travels = np.trapezoid(np.abs(rates), times, axis=1)
    assert abs(travels.mean() - result.travel()) < 5.0 * travels.std() / np.sqrt(runs)
    assert abs(travels.std() / result.travel_deviation() - 1.0) < 5.0 / np.sqrt(2.0 * runs)
    low = np.radians(0.6)  # crossed often, so that few flights suffice
    outside = np.abs(deflections) > low
    counts = np.sum(outside[:, 1:] & ~outside[:, :-1], axis=1)
    missed = 0.02 * result.crossings(low)  # two crossings within a step
    assert abs(counts.mean() - result.crossings(low)) < 5.0 * counts.std() / np.sqrt(runs) + missed


def test_a_history_becomes_stationary_about_the_exact_mean_response():
    result = turbulence_history(AUTOPILOT, EXACT, AIR, SPEED, 60.0, wind=WIND)
    stationary = turbulence_covariance(AUTOPILOT, EXACT, AIR, SPEED)
    for output in ("attitude", "angle_of_attack", "deflection_acceleration"):
        assert np.isclose(result.deviation(output)[-1], stationary.rms(output), rtol=2e-2)
    mean = AUTOPILOT.wind_response(EXACT, WIND)(result.times)
    # of fourth order in 25 rad/s times 0.02 s: 0.5^4/720 of the wind's share in a step
    assert np.allclose(result.mean(), mean[-1], rtol=0.0, atol=1e-9)
    alpha = result.outputs.index("angle_of_attack")
    assert np.allclose(result.mean("angle_of_attack"), mean[alpha], rtol=0.0, atol=1e-9)
    size, time = result.largest(3.0)
    k = np.searchsorted(result.times, time)
    assert np.isclose(size, abs(result.mean()[k]) + 3.0 * result.deviation()[k])
    assert np.all(np.diff(result.deviation("drift")) > 0.0)  # an integral has no limit
    assert np.allclose(result.quantile(0.5), result.mean())


@pytest.mark.parametrize("delay", [0.0, 0.03, 0.04])
def test_a_sampled_loop_is_near_the_continuous_one_with_half_a_sample_more_delay(delay):
    sampled = replace(AUTOPILOT, sample_rate=50.0, delay=delay)
    result = turbulence_covariance(sampled, EXACT, AIR, SPEED)
    near = turbulence_covariance(replace(AUTOPILOT, delay=delay + 0.01), EXACT, AIR, SPEED)
    for output in ("attitude", "angle_of_attack", "deflection"):
        assert np.isclose(result.rms(output), near.rms(output), rtol=2e-4)
    assert np.isclose(result.mean_absolute_rate(), near.mean_absolute_rate(), rtol=2e-3)
    assert np.isclose(result.spectrum(1.0), near.spectrum(1.0), rtol=1e-2)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("autopilot", "plant"),
    [
        pytest.param(
            replace(AUTOPILOT, sample_rate=8.0, delay=0.05, alpha_gain=0.1),
            EXACT,
            marks=pytest.mark.thorough,
        ),
        (
            replace(AUTOPILOT, filters=NOTCHES, sample_rate=40.0, integral_gain=0.02),
            tv.FlexiblePlant.from_vehicle(BOOSTER, STRUCTURE),
        ),
    ],
)
def test_a_sampled_covariance_is_that_of_its_flights(autopilot, plant):
    """The engine of flights, whose limit is far away, in turbulence that is long and sampled."""
    step, duration, runs, begin = 0.025, 100.0, 16, 40.0
    times = step * np.arange(int(duration / step) + 1)
    winds = AIR.winds(times, SPEED, seed=8, runs=runs)
    law = tv.control.SaturatedLaw.of(autopilot)
    when = np.arange(begin, duration, 1.0 / autopilot.sample_rate / 4.0)
    hardware = {"actuator": ACTUATOR, "sample_rate": autopilot.sample_rate}
    squares = []
    for run in range(runs):
        wind = tv.SampledWind(time=times, angle=winds.angle[run])
        flight = tv.fly(
            plant, law, wind, when, deflection_limit=0.5, delay=autopilot.delay, **hardware
        )
        squares.append(np.mean(flight.outputs**2, axis=-1).ravel())
    labels = list(flight.output_labels)
    result = turbulence_covariance(autopilot, plant, AIR, SPEED)
    for name in ("attitude", "attitude_rate", "deflection"):
        power = np.array(squares)[:, labels.index(name)]
        error = 5.0 * power.std() / np.sqrt(runs)
        assert abs(power.mean() - result.rms(name) ** 2) < error + 0.01 * power.mean(), name
        assert error < 0.5 * power.mean()


def test_a_sampled_history_settles_at_its_stationary_covariance():
    autopilot = replace(AUTOPILOT, sample_rate=10.0, delay=0.13)
    noise = SensorNoise(rate=1e-3)
    plant = tv.Plant.from_vehicle(BOOSTER, "fixed-path")
    result = turbulence_history(autopilot, plant, AIR, SPEED, 40.0, noise=noise)
    stationary = turbulence_covariance(autopilot, plant, AIR, SPEED, noise=noise)
    last = result.times > 39.0
    for output in ("deflection", "attitude_rate", "angle_of_attack"):
        assert np.isclose(result.deviation(output)[last].max(), stationary.rms(output), rtol=2e-3)
    settled = (
        result.travel()
        - turbulence_history(autopilot, plant, AIR, SPEED, 30.0, noise=noise).travel()
    )
    assert np.isclose(settled, 10.0 * stationary.mean_absolute_rate(), rtol=5e-3)  # (25 h)^2/12


@pytest.mark.parametrize("sample_rate", [None, 20.0])
def test_settled_turbulence_has_its_stationary_covariance_throughout(sample_rate):
    autopilot = replace(AUTOPILOT, sample_rate=sample_rate, delay=0.03)
    result = turbulence_history(autopilot, EXACT, AIR, SPEED, 4.0, wind=WIND, settled=True)
    stationary = turbulence_covariance(autopilot, EXACT, AIR, SPEED)
    for output in ("deflection", "deflection_rate", "angle_of_attack"):
        assert np.isclose(result.deviation(output).max(), stationary.rms(output), rtol=2e-3)
    calm = turbulence_history(autopilot, EXACT, AIR, SPEED, 4.0, settled=True)
    assert np.isclose(
        calm.travel(), 4.0 * stationary.mean_absolute_rate(), rtol=5e-3
    )  # (25 h)^2/12
    assert np.isclose(calm.crossings(0.002), 4.0 * stationary.crossing_rate(0.002), rtol=5e-3)


@pytest.mark.thorough
def test_welch_finds_the_spectrum_of_the_deflection_in_flights():
    step, runs = 0.05, 8
    times = step * np.arange(2**13 + 400)
    winds = AIR.winds(times, SPEED, seed=4, runs=runs).angle
    deflection = sampled_motion(AUTOPILOT, winds, step)[:, 0, 400:]
    hertz, density = welch(deflection, 1.0 / step, nperseg=1024)
    result = turbulence_covariance(AUTOPILOT, EXACT, AIR, SPEED)
    band = slice(5, 60)  # windows blur below, straight winds between times damp above
    expected = 2.0 * np.pi * result.spectrum(2.0 * np.pi * hertz[band])
    spread = np.sqrt(1.0 / (0.55 * runs * 15))
    ratio = density.mean(axis=0)[band] / expected
    assert np.abs(ratio - 1.0).max() < 5.0 * spread
    assert abs(ratio.mean() - 1.0) < 5.0 * spread / np.sqrt(len(ratio) / 2)


@pytest.mark.parametrize("sample_rate", [None, 40.0])
def test_the_curves_of_the_chart_integrate_to_the_variances(sample_rate):
    result = turbulence_covariance(replace(AUTOPILOT, sample_rate=sample_rate), EXACT, AIR, SPEED)
    curves = tv.plots.spectrum_curves(result)
    assert curves.abscissa[-1] <= (sample_rate or 200.0) / 2.0
    for label, panel in (("deflection", "angles"), ("attitude rate", "rates")):
        variance = np.trapezoid(curves.column(label, panel) ** 2, curves.abscissa)
        rms = np.degrees(result.rms(label.replace(" ", "_")))
        assert np.isclose(np.sqrt(variance), rms, rtol=5e-3), label


@cache
def flight():
    """Return the flight of configuration I and gains along it."""
    schedule = load_schedule("configuration-i")
    coefficients = tv.Plant.from_vehicle(schedule.vehicle, "drift-exact").coefficients
    rule = {"natural_frequency": 1.0, "damping": 0.7, "actuator": ACTUATOR}
    design = tv.control.GainSchedule.design
    return schedule, design(schedule.times, coefficients, tv.design_gains, **rule)


@pytest.mark.thorough
def test_along_a_flight_it_is_the_solution_of_the_differential_equation():
    schedule, gains = flight()
    air = tv.winds.Turbulence.mil_f_8785c("severe")
    start, stop = 60.2, 62.7
    wind = tv.TriangularWind(peak=0.05, duration=1.5).shift(60.5)
    result = turbulence_along(schedule, gains, air, start=start, stop=stop, wind=wind)
    a, b, c = air.normalised_filter
    n = 5  # attitude, its rate, flight path, deflection and its rate

    def slope(t, flat):
        vehicle, law = schedule.at(t), gains.at(t)
        plant_A, plant_B, *_ = tv.Plant.from_vehicle(vehicle, "drift-exact").matrices()
        sigma, length = air.over(np.interp(t, schedule.times, schedule.height))
        V = float(vehicle.velocity)
        A, onto = np.zeros((n + 2, n + 2)), np.zeros(n + 2)
        A[:3, :3], A[:3, 3], onto[:3] = plant_A, plant_B[:, 0], plant_B[:, 1]
        A[3, 4] = 1.0
        command = np.array([law.attitude_gain, law.rate_gain])
        A[4, :2], A[4, 3:5] = 625.0 * command, [-625.0, -35.0]
        A[:, n:] += np.outer(onto, c[0] * (sigma / V))
        A[n:, n:] = a * (V / length)
        m, P = flat[: n + 2], flat[n + 2 :].reshape(n + 2, n + 2)
        growth = A @ P + P @ A.T
        growth[n:, n:] += b @ b.T * (V / length)
        return np.concatenate([A @ m + onto * float(wind(t)), growth.ravel()])

    first = np.zeros((n + 2, n + 2))
    first[n:, n:] = 0.25 * np.array([[1.0, 0.0], [0.0, 1.0]])  # of 1/(1 + s)^2
    solution = np.concatenate([np.zeros(n + 2), first.ravel()])
    for ends in ((start, 60.5), (60.5, 61.25), (61.25, 62.0), (62.0, stop)):
        whole = solve_ivp(slope, ends, solution, method="RK45", rtol=1e-6, atol=1e-12, max_step=0.2)
        solution = whole.y[:, -1]
    m, P = solution[: n + 2], solution[n + 2 :].reshape(n + 2, n + 2)
    states = ("attitude", "attitude_rate", "flight_path_angle", "deflection", "deflection_rate")
    for k, output in enumerate(states):
        assert np.isclose(result.deviation(output)[-1], np.sqrt(P[k, k]), rtol=2e-5), output
        assert np.isclose(result.mean(output)[-1], m[k], rtol=1e-4, atol=1e-8), output


def test_along_a_flight_a_constant_vehicle_is_a_history():
    vehicle = BOOSTER.replace(time=[60.0, 70.0])
    schedule = tv.FlightSchedule(vehicle)
    along = turbulence_along(schedule, AUTOPILOT, AIR, wind=WIND.shift(61.0))
    single = turbulence_history(AUTOPILOT, EXACT, AIR, SPEED, 10.0, wind=WIND.shift(1.0))
    for output in ("deflection", "angle_of_attack", "drift"):
        assert np.isclose(along.deviation(output)[-1], single.deviation(output)[-1], rtol=1e-9)
        assert np.isclose(along.mean(output)[-1], single.mean(output)[-1], rtol=1e-5)
    assert np.isclose(along.travel(), single.travel(), rtol=1e-3)


def test_turbulence_below_a_cutoff_is_the_part_of_the_spectrum_below_it():
    air = replace(AIR, cutoff_wavelength=500.0)
    whole = turbulence_covariance(AUTOPILOT, EXACT, AIR, SPEED)
    result = turbulence_covariance(AUTOPILOT, EXACT, air, SPEED)

    def power(omega):
        ratio = (omega * 500.0 / (2.0 * np.pi * SPEED)) ** 4
        return float(whole.spectrum(omega)) * ratio / (1.0 + ratio)

    variance = frequency_integral(power, [0.1, 1.0, 3.0, 6.0, 10.0, 30.0, 100.0])
    assert np.isclose(result.rms(), np.sqrt(variance), rtol=1e-6)
    schedule = tv.FlightSchedule(BOOSTER.replace(time=[60.0, 70.0]))
    along = turbulence_along(schedule, AUTOPILOT, air)
    single = turbulence_history(AUTOPILOT, EXACT, air, SPEED, 10.0)
    for output in ("deflection", "angle_of_attack"):
        assert np.isclose(along.deviation(output)[-1], single.deviation(output)[-1], rtol=1e-9)
    assert np.isclose(single.deviation()[-1], result.rms(), rtol=1e-2)


@pytest.mark.thorough
def test_along_a_flight_a_structure_and_drift_count():
    schedule, gains = flight()
    air = tv.winds.Turbulence.mil_f_8785c("moderate")
    rigid = turbulence_along(schedule, gains, air)
    soft = replace(gains, autopilot=replace(gains.autopilot, filters=NOTCHES))
    bent = turbulence_along(schedule, soft, air, structure=STRUCTURE)
    assert bent.travel() > rigid.travel()
    assert "sensed_attitude" in bent.outputs
    assert rigid.deviation("drift")[-1] > 10.0
    # severe air is 2.0 to 3.3 times moderate air at these altitudes
    severe = turbulence_along(schedule, gains, tv.winds.Turbulence.mil_f_8785c("severe"))
    assert 2.0 * rigid.travel() < severe.travel() < 3.3 * rigid.travel()


def flown_along(schedule, gains, air, times, runs, samples, delayed):
    """Return deflections and attitudes of sampled flights along a flight at even times.

    `samples`: number of steps between samples. `delayed`: from a sample until its command acts.
    """
    step = times[1] - times[0]
    V = np.interp(times, schedule.times, schedule.speed)
    height = np.interp(times, schedule.times, schedule.height)
    winds = air.winds(times, V, altitude=height, seed=61, runs=runs).angle
    x, held, pipe, motion = np.zeros((runs, 5)), np.zeros(runs), {}, []
    for k, t in enumerate(times):
        motion.append(x[:, [3, 0]])
        if k % samples == 0:
            law = gains.at(t)
            pipe[k + delayed] = law.attitude_gain * x[:, 0] + law.rate_gain * x[:, 1]
        held = pipe.pop(k, held)
        if k + 1 < len(times):
            plant = tv.Plant.from_vehicle(schedule.at(t + 0.5 * step), "drift-exact")
            A, B, *_ = plant.matrices()
            whole = np.zeros((8, 8))
            whole[:3, :3], whole[:3, 3], whole[:3, 6] = A, B[:, 0], B[:, 1]
            whole[3, 4], whole[4, 3:6], whole[6, 7] = 1.0, [-625.0, -35.0, 625.0], 1.0
            F = expm(whole * step)[:5]
            slope = (winds[:, k + 1] - winds[:, k]) / step
            x = np.column_stack([x, held, winds[:, k], slope]) @ F.T
    return np.moveaxis(np.array(motion), 0, -1)


@pytest.mark.thorough
@pytest.mark.parametrize("runs", [400, pytest.param(10_000, marks=pytest.mark.thorough)])
def test_along_a_flight_a_sampled_autopilot_has_the_covariance_of_its_flights(runs):
    schedule, gains = flight()
    air = tv.winds.Turbulence.mil_f_8785c("severe")
    sampled = replace(gains, autopilot=replace(gains.autopilot, sample_rate=12.5, delay=0.02))
    result = turbulence_along(schedule, sampled, air, start=60.0, stop=66.0)
    times = 60.0 + 0.01 * np.arange(601)
    deflection, attitude = np.moveaxis(flown_along(schedule, gains, air, times, runs, 8, 2), 1, 0)
    at = np.searchsorted(result.times, times - 1e-6)
    assert np.allclose(result.times[at], times, atol=1e-9)
    later = slice(100, None, 37)  # at and between samples
    for name, values in (("deflection", deflection), ("attitude", attitude)):
        ratio = values.std(axis=0)[later] / result.deviation(name)[at][later]
        assert np.abs(ratio - 1.0).max() < 5.0 / np.sqrt(2.0 * runs), name
    rates = np.diff(deflection) / 0.01
    travels = np.abs(rates).sum(axis=1) * 0.01
    assert (
        abs(travels.mean() / result.travel() - 1.0)
        < 5.0 * travels.std() / (travels.mean() * np.sqrt(runs)) + 2e-3
    )  # (25 x 0.01)^2/12 of differences within steps
    assert abs(travels.std() / result.travel_deviation() - 1.0) < 5.0 / np.sqrt(2.0 * runs) + 0.02


@pytest.mark.thorough
def test_along_a_flight_a_constant_sampled_loop_is_a_history():
    schedule = tv.FlightSchedule(BOOSTER.replace(time=[60.0, 64.0]))
    autopilot = replace(
        AUTOPILOT, sample_rate=25.0, delay=0.05, integral_gain=0.02, filters=NOTCHES
    )
    noise, wind = SensorNoise(rate=1e-4), WIND.shift(61.0)
    along = turbulence_along(schedule, autopilot, AIR, wind=wind, noise=noise)
    single = turbulence_history(
        autopilot, EXACT, AIR, SPEED, 4.0, wind=WIND.shift(1.0), noise=noise
    )
    assert np.allclose(along.times - 60.0, single.times, atol=1e-9)
    for output in ("deflection", "angle_of_attack", "drift"):
        assert np.allclose(along.deviation(output), single.deviation(output), rtol=1e-9)
        assert np.allclose(along.mean(output), single.mean(output), rtol=1e-9, atol=1e-13)
    assert np.isclose(along.travel(), single.travel(), rtol=1e-9)
    assert np.isclose(along.travel_deviation(), single.travel_deviation(), rtol=1e-9)


@cache
def bending_flight():
    """Return configuration I with a mode over the flight, and gains with a notch that follows."""
    schedule, gains = flight()
    mode = tv.vehicle.BendingMode(**{**BEND, "frequency": [11.0, 13.6, 19.0]})
    structure = tv.ascent.StructureSchedule(
        [41.0, 66.0, 116.0], replace(STRUCTURE, bending=(mode,)), modes=("first",)
    )
    notch = tv.control.ModeNotch(mode="first", zero_damping=0.06, pole_damping=0.6)
    return schedule, structure, replace(gains, notches=(notch,))


def test_along_a_flight_a_structure_that_stays_is_one_structure():
    schedule, gains = flight()
    span = {"start": 60.0, "stop": 62.0}
    soft = replace(gains, autopilot=replace(gains.autopilot, filters=NOTCHES))
    still = tv.ascent.StructureSchedule([41.0, 116.0], STRUCTURE, modes=("first", "second"))
    ways = [
        (schedule, {"structure": STRUCTURE}),
        (schedule, {"structure": still}),
        (replace(schedule, structure=still), {}),
    ]
    spreads = [turbulence_along(s, soft, AIR, **span, **more).deviation() for s, more in ways]
    assert np.allclose(spreads[1:], spreads[0], rtol=1e-12)
    assert spreads[0][-1] > turbulence_along(schedule, gains, AIR, **span).deviation()[-1]


@pytest.mark.thorough
def test_along_a_flight_a_structure_and_its_notch_vary():
    """By integration of the covariance of loops that are closed anew at each time."""
    schedule, structure, gains = bending_flight()
    start, stop = 65.9, 66.1
    result = turbulence_along(schedule, gains, AIR, structure=structure, start=start, stop=stop)
    soft = replace(schedule, structure=structure)
    a, b, c = AIR.normalised_filter

    def slope(t, flat):
        vehicle = soft.at(t)
        plant = tv.FlexiblePlant.from_vehicle(vehicle.rigid, vehicle.structure, "drift-exact")
        loop = gains.along(soft, t).close(plant)
        onto = loop.B[:, [list(loop.input_labels).index("wind")]]
        n, V = len(loop.A), float(vehicle.velocity)
        A, N = np.zeros((2, n + 2, n + 2))
        A[:n, :n], A[:n, n:], A[n:, n:] = loop.A, onto @ c * (6.0 / V), a * (V / 533.4)
        N[n:, n:] = b @ b.T * (V / 533.4)
        P = flat.reshape(n + 2, n + 2)
        return (A @ P + P @ A.T + N).ravel()

    plant = tv.FlexiblePlant.from_vehicle(soft.at(start).rigid, soft.at(start).structure)
    names = list(gains.along(soft, start).close(plant).state_labels)
    P = np.zeros((len(names) + 2,) * 2)
    P[-2:, -2:] = 0.25 * np.eye(2)
    for ends in ((start, 66.0), (66.0, stop)):
        whole = solve_ivp(slope, ends, P.ravel(), method="RK45", rtol=1e-6, atol=1e-13)
        P = whole.y[:, -1].reshape(P.shape)
    spread = np.sqrt(P[names.index("actuator_deflection"), names.index("actuator_deflection")])
    assert np.isclose(result.deviation()[-1], spread, rtol=1e-4)
    itself = turbulence_along(soft, gains, AIR, start=start, stop=stop)
    assert np.allclose(itself.deviation(), result.deviation(), rtol=1e-12)


def test_loads_along_a_flight_are_those_of_its_times():
    schedule, gains = flight()
    air = tv.winds.Turbulence.mil_f_8785c("severe")
    slopes = np.linspace(1e7, 3e7, schedule.times.size)
    loads = LoadSlopes(alpha_moment=slopes, deflection_moment=-1e7)
    result = turbulence_along(schedule, gains, air, loads=loads, start=50.0, stop=70.0)
    pressure = tv.ascent.flight_variable(schedule, "dynamic_pressure", result.times)
    alpha = result.deviation("angle_of_attack")
    assert np.allclose(result.deviation("q_alpha"), pressure * alpha, rtol=1e-9)
    slope = np.interp(result.times, schedule.times, slopes)
    low = np.abs(slope * alpha - 1e7 * result.deviation())
    high = slope * alpha + 1e7 * result.deviation()
    moment = result.deviation("bending_moment")
    assert np.all((low * (1.0 - 1e-9) <= moment) & (moment <= high * (1.0 + 1e-9)))


@pytest.mark.thorough
@pytest.mark.parametrize("sample_rate", [None, 40.0])
def test_behind_a_low_pass_the_angle_of_attack_has_crossings(sample_rate):
    """The variances are integrals of spectra, times that of the low-pass."""
    loads = LoadSlopes(dynamic_pressure=3e4, alpha_moment=2e7, bandwidth=4.0)
    autopilot = replace(AUTOPILOT, sample_rate=sample_rate)
    result = turbulence_covariance(autopilot, EXACT, AIR, SPEED, loads=loads)
    filtered = "filtered_angle_of_attack"
    assert np.isclose(result.rms("filtered_q_alpha"), 3e4 * result.rms(filtered), rtol=1e-9)
    assert np.isclose(result.rms("filtered_bending_moment"), 2e7 * result.rms(filtered), rtol=1e-9)
    assert result.rms(filtered) < result.rms("angle_of_attack")
    if sample_rate is None:

        def power(omega):
            return float(result.spectrum(omega, "angle_of_attack")) / (1.0 + (omega / 4.0) ** 2)

        corners = [1e-3, 0.01, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0]
        variance = frequency_integral(power, corners)
        motion = frequency_integral(lambda w: w**2 * power(w), corners)
        assert np.isclose(result.rms(filtered), np.sqrt(variance), rtol=1e-5)
        limit = 2.5 * result.rms(filtered)
        rate = np.sqrt(motion / variance) / np.pi * np.exp(-0.5 * 2.5**2)  # Rice, both sides
        assert np.isclose(result.crossing_rate(limit, filtered), rate, rtol=1e-3)  # 1/s above 1e5
    history = turbulence_history(autopilot, EXACT, AIR, SPEED, 30.0, loads=loads, wind=WIND)
    limit = 3.0 * result.rms(filtered)
    calm = turbulence_history(autopilot, EXACT, AIR, SPEED, 30.0, loads=loads)
    assert history.crossings(limit, filtered) > calm.crossings(limit, filtered)
    rates = calm.crossing_rate(limit, filtered)[-20:]
    assert np.isclose(rates.mean(), result.crossing_rate(limit, filtered), rtol=2e-2)


UNSTABLE = tv.Autopilot(attitude_gain=0.05, rate_gain=0.3, actuator=ACTUATOR)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: turbulence_covariance(UNSTABLE, EXACT, AIR, SPEED), r"a pole at 0.0719399 .* 1/s"),
        (
            lambda: turbulence_covariance(replace(UNSTABLE, sample_rate=9.0), EXACT, AIR, SPEED),
            r"a pole at 1.008.* in z",
        ),
        (
            lambda: turbulence_covariance(AUTOPILOT, EXACT, AIR, SPEED).crossing_rate(
                0.1, "angle_of_attack"
            ),
            "angle_of_attack has no rate of finite variance",
        ),
        (
            lambda: turbulence_covariance(
                replace(AUTOPILOT, actuator=None), EXACT, AIR, SPEED, noise=SensorNoise(1e-4)
            ),
            "follows the noise of the sensors at once",
        ),
        (
            lambda: turbulence_covariance(
                replace(AUTOPILOT, actuator=None, sample_rate=50.0), EXACT, AIR, SPEED
            ).mean_absolute_rate(),
            "deflection has no rate of finite variance",
        ),
        (
            lambda: turbulence_covariance(
                replace(AUTOPILOT, sample_rate=50.0), EXACT, AIR, SPEED
            ).spectrum(200.0),
            "half the sample rate, 157.08 rad/s",
        ),
        (
            lambda: turbulence_covariance(
                AUTOPILOT, EXACT, tv.winds.Turbulence.mil_f_8785c("light"), SPEED
            ),
            "table over altitude",
        ),
        (lambda: turbulence_history(AUTOPILOT, EXACT, AIR, SPEED, 1e4), "up to 30000 steps"),
        (
            lambda: turbulence_along(flight()[0], replace(AUTOPILOT, sample_rate=900.0), AIR),
            "up to 30000 steps",
        ),
    ],
)
def test_what_has_no_answer_is_refused_in_a_sentence(call, sentence):
    with pytest.raises(InputError, match=sentence):
        call()
