"""Laws that are sampled slowly for their nozzle: the hardware moves on between two samples."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tvclin as tv
from tests.flexible import BOOSTER, MODES, TANKS
from tests.turns import usual
from tvclin.flights.closed_loop.batch import Hardware, flights, one_flight
from tvclin.flights.closed_loop.sampled_stability import dominant_pole

PEAK = np.radians(5.0)
PLANT = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "fixed-path")
GAINS = tv.design_gains(PLANT.coefficients, natural_frequency=1.0, damping=0.7)
LAW = tv.SaturatedLaw(GAINS)
WIND = tv.TriangularWind(peak=PEAK, duration=7.3)
TRIM = abs(float(PLANT.coefficients.B)) * PEAK


def by_small_steps(actuator, rate, delay, limit, most, last, parts=800):
    """Attitude and deflection at samples, by midpoints of small steps; limits hold in each."""
    c, w, zeta = PLANT.coefficients, actuator.natural_frequency, actuator.damping
    mu_a, mu_d, h = float(c.mu_alpha), float(c.mu_delta), 1.0 / rate / parts
    x, q, s, v, shown, commands = 0.0, 0.0, 0.0, 0.0, [], []
    late = round(delay * rate * parts)
    for k in range(round(last * rate) + 1):
        shown.append((x, min(max(s, -limit), limit)))
        request = GAINS.attitude_gain * x + GAINS.rate_gain * q
        commands.append(min(max(request, -limit), limit))
        winds = WIND((k * parts + np.arange(parts) + 0.5) * h).tolist()
        for j, wind in enumerate(winds):
            sent = (k * parts + j - late) // parts
            command = commands[sent] if sent >= 0 else 0.0
            if zeta is None:
                speed = min(max(w * (command - s), -most), most)
                middle = s + 0.5 * h * speed
                speed = min(max(w * (command - middle), -most), most)
                s += h * speed
            else:
                pull = w * w * (command - s) - 2.0 * zeta * w * v
                half = min(max(v + 0.5 * h * pull, -most), most)
                middle = s + 0.5 * h * v
                pull = w * w * (command - middle) - 2.0 * zeta * w * half
                v = min(max(v + h * pull, -most), most)
                s += h * half
            middle = min(max(middle, -limit), limit)
            turning = mu_a * (x - wind) - mu_d * middle
            between, rising = x + 0.5 * h * q, q + 0.5 * h * turning
            turning = mu_a * (between - wind) - mu_d * middle
            x, q = x + h * rising, q + h * turning
    return np.array(shown).T


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("rate", "hertz", "damping", "delay", "part", "most"),
    usual(
        [
            (50.0, 8.0, 0.7, 0.0, 1.1, 1.2),
            (50.0, 20.0, 0.7, 0.013, 1.05, np.inf),
            (25.0, 8.0, None, 0.03, 1.2, 0.6),
            (25.0, 20.0, 0.7, 0.0, 1.2, 0.8),
            (10.0, 4.0, 0.7, 0.1, 1.3, 0.9),
            (10.0, 8.0, 0.6, 0.045, 1.2, 0.8),
            (10.0, 20.0, None, 0.0, 1.05, 1.5),
        ],
        2,
        5,
    ),
)
def test_a_nozzle_meets_its_limits_between_samples(rate, hertz, damping, delay, part, most):
    """Within what substeps state, 3e-4 of the largest attitude, beside 5e-5 of the small steps."""
    actuator = tv.Actuator(natural_frequency=2.0 * np.pi * hertz, damping=damping)
    limit, most = part * TRIM, most * TRIM
    expected = by_small_steps(actuator, rate, delay, limit, most, 12.0)
    times = np.arange(expected.shape[1]) / rate
    flown = tv.fly(
        PLANT, LAW, WIND, times, deflection_limit=limit, rate_limit=most,
        actuator=actuator, sample_rate=rate, delay=delay,
    )  # fmt: skip
    for row, name, error in ((0, "attitude", 4e-4), (1, "deflection", 4e-3)):
        scale = np.abs(expected[row]).max()
        assert np.abs(flown.outputs[name] - expected[row]).max() < error * scale
    many = tv.fly_many(
        PLANT, LAW, WIND, deflection_limit=limit, rate_limit=most,
        actuator=actuator, sample_rate=rate, delay=delay, until=12.0,
    )  # fmt: skip
    assert float(many.peak_attitude) == pytest.approx(np.abs(expected[0]).max(), rel=4e-4)
    assert float(many.peak_deflection) <= limit
    assert float(many.peak_deflection_rate) <= most * (1.0 + 1e-9)


@pytest.mark.parametrize(("rate", "stated"), [(10.0, 6e-2), (25.0, 2e-2)])
def test_a_rate_limit_without_an_actuator_is_good_for_what_is_stated(rate, stated):
    """Beside a nozzle with a lag of a millisecond, which is next to none."""
    limit, most, last = 1.1 * TRIM, 0.02, 9.0
    quick = tv.Actuator(natural_frequency=1000.0, damping=None)
    exact = by_small_steps(quick, rate, 0.0, limit, most, last, parts=200)[0]
    times, options = np.arange(exact.size) / rate, {"rate_limit": most, "sample_rate": rate}
    flown = tv.fly(PLANT, LAW, WIND, times, deflection_limit=limit, **options)
    attitude = np.asarray(flown.outputs["attitude"])
    off = np.abs(attitude - exact).max() / np.abs(exact).max()
    assert 0.1 * stated < off < stated


def test_substeps_are_the_root_of_the_step_they_make_together():
    """So a part without a limit may go by as one exact product."""
    actuator = tv.Actuator(natural_frequency=50.0)
    f = flights(one_flight(PLANT, LAW, WIND, 1.0, Hardware(0.1, 0.023, actuator)))
    assert f.steps.substeps.tolist() == [[31, 10]]
    for part, count in enumerate(f.steps.substeps[0]):
        every = (f.steps.joint, f.steps.fine)
        whole, fine = (np.vstack([J[0, part, :, :5], np.eye(5)[4:]]) for J in every)
        power = np.linalg.matrix_power(fine, count)
        np.testing.assert_allclose(power, whole, rtol=0, atol=1e-12 * np.abs(whole).max())


def test_a_wind_that_turns_within_a_long_sample_moves_a_quick_structure_exactly():
    """Ten samples a second, and a gyro of 120 rad/s: a series about each stretch, not about all."""
    structure = tv.Structure(
        bending=MODES, slosh=TANKS, rate_gyro=tv.vehicle.Filter.low_pass(120.0, 0.7)
    )
    plant = tv.FlexiblePlant.from_vehicle(BOOSTER, structure, "drift-exact")
    wind = tv.SampledWind(time=[0.0, 0.53, 0.57, 1.94, 2.21], angle=[0.0, 0.05, -0.02, 0.06, 0.0])
    law = tv.SaturatedLaw(tv.Autopilot(attitude_gain=1e-20, rate_gain=0.0))
    times = np.linspace(0.0, 3.0, 31)
    flown = tv.fly(plant, law, wind, times, deflection_limit=1.0, sample_rate=10.0)
    A, B, _, _ = plant.matrices()

    def moving(t, x, before, slope, begin):
        return A @ x + B[:, 1] * (before + slope * (t - begin))

    edges, angles, x = wind.time, wind.angle, np.zeros(len(A))
    expected = []
    for k, begin in enumerate(edges):
        end = edges[k + 1] if k + 1 < len(edges) else 3.0
        slope = (angles[k + 1] - angles[k]) / (end - begin) if k + 1 < len(edges) else 0.0
        inside = times[(times >= begin) & (times < end)]
        run = solve_ivp(
            moving, (begin, end), x, "DOP853", rtol=1e-12, atol=1e-15,
            dense_output=True, args=(angles[k], slope, begin),
        )  # fmt: skip
        expected += [run.sol(t)[0] for t in inside]
        x = run.y[:, -1]
    seen = flown.outputs["attitude"][: len(expected)]
    assert np.abs(seen - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("rate", [10.0, 25.0, 50.0])
@pytest.mark.parametrize("hertz", usual([4.0, 8.0, 20.0], 1))
def test_beside_the_edge_of_stability_a_flight_is_on_the_side_that_margins_say(rate, hertz):
    """Ten percent beyond the gain that may rise it rings, ten percent before it comes to rest."""
    actuator = tv.Actuator(natural_frequency=2.0 * np.pi * hertz)
    autopilot = replace(GAINS, actuator=actuator, sample_rate=rate)
    rise = autopilot.margins(PLANT).gain_increase
    flown = tv.fly_many(
        PLANT, LAW, WIND, deflection_limit=50.0 * TRIM, gain=np.array([0.9, 1.1]) * rise,
        actuator=actuator, sample_rate=rate,
    )  # fmt: skip
    assert flown.status.tolist() == ["survived", "rings"]
    boundary = tv.closed_loop_boundary(
        PLANT, LAW, WIND, gain=1.001 * rise, actuator=actuator, sample_rate=rate
    )
    assert boundary.has_unstable_mode


BENDS = tv.FlexiblePlant.from_vehicle(BOOSTER, tv.Structure(bending=MODES, slosh=TANKS))


@pytest.mark.parametrize("rate", [10.0, 25.0, 50.0])
@pytest.mark.parametrize("hertz", usual([4.0, 8.0, 20.0], 1))
@pytest.mark.parametrize("plant", [PLANT, BENDS], ids=["rigid", "flexible"])
def test_a_millionth_beyond_each_margin_the_step_of_a_flight_grows(plant, hertz, rate):
    """And a millionth before it, it does not: with more gain, with less, and with more delay."""
    shelf = tv.vehicle.Filter.low_pass(5.0, 0.7)
    gains = tv.design_gains(
        plant.coefficients, natural_frequency=1.0, damping=0.9, filters=(shelf,) * (plant is BENDS)
    )
    nozzle, late = tv.Actuator(natural_frequency=2.0 * np.pi * hertz), 0.3 / rate
    sampled = replace(gains, actuator=nozzle, sample_rate=rate, delay=late)
    m = tv.control.loop_margins(sampled.exact_loop(plant))
    assert m.stable
    law = tv.SaturatedLaw(gains)

    def growth(gain, delay):
        hardware = Hardware(1.0 / rate, delay, nozzle)
        return dominant_pole(one_flight(plant, law, WIND, 1.0, hardware, gain)).real

    for beyond in (1.0 - 1e-6, 1.0 + 1e-6):
        changes = [(beyond * m.gain_increase, late), (1.0, late + beyond * m.delay_margin)]
        changes.append((1.0 / (beyond * m.aero_margin), late))
        assert [growth(*change) > 0.0 for change in changes] == [beyond > 1.0] * 3
