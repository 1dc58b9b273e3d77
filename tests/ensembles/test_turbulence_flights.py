"""Flights with limits in sampled turbulence: where the linear loop is right, and where not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

import tvclin as tv
from tvclin.base.errors import InputError
from tvclin.ensembles import fly_turbulence, fly_turbulence_along

BOOSTER = tv.load_vehicle("configuration-i")
SPEED = float(BOOSTER.velocity)
ACTUATOR = tv.Actuator(natural_frequency=25.0, damping=0.7)
AUTOPILOT = tv.Autopilot(
    attitude_gain=0.2144578, rate_gain=0.4862230, actuator=ACTUATOR, sample_rate=25.0
)
AIR = tv.winds.Turbulence(6.0, 533.4)
PLANT = tv.Plant.from_vehicle(BOOSTER, "drift-exact")


def test_a_saturation_takes_as_much_gain_as_it_takes_time():
    """The random-input describing function E[y sat(y)]/E[y^2], by quadrature."""
    y = np.linspace(-12.0, 12.0, 200_001)
    for limit in (0.5, 1.0, 2.5):
        gain = np.trapezoid(y * np.clip(y, -limit, limit) * norm.pdf(y), y)
        assert np.isclose(1.0 - gain, 2.0 * norm.sf(limit), atol=1e-8)


@pytest.mark.thorough
@pytest.mark.parametrize("sample_rate", [None, 25.0])
def test_the_time_beyond_a_limit_is_that_of_the_normal_distribution(sample_rate):
    autopilot = replace(AUTOPILOT, sample_rate=sample_rate)
    result = tv.control.turbulence_covariance(autopilot, PLANT, AIR, SPEED)
    expected = 2.0 * norm.sf(np.radians(0.1) / result.rms())
    assert np.isclose(result.exceedance(np.radians(0.1)), expected, rtol=1e-3)
    wind = tv.TriangularWind(peak=np.radians(5), duration=7.5)
    history = tv.control.turbulence_history(autopilot, PLANT, AIR, SPEED, 10.0, wind=wind)
    limit, m, s = np.radians(0.7), history.mean(), np.maximum(history.deviation(), 1e-12)
    beyond = norm.sf((limit - m) / s) + norm.cdf((-limit - m) / s)
    assert np.allclose(history.exceedance(limit), beyond, atol=1e-12)
    assert np.isclose(history.time_fraction(limit), np.trapezoid(beyond, history.times) / 10.0)


@pytest.mark.thorough
@pytest.mark.parametrize("runs", [100, pytest.param(2000, marks=pytest.mark.thorough)])
def test_a_limit_that_is_met_rarely_leaves_the_linear_answer(runs):
    flights = fly_turbulence(
        AUTOPILOT, PLANT, AIR, SPEED, 20.0, deflection_limit=np.radians(0.2), runs=runs, seed=2
    )
    assert flights.is_linear
    assert flights.survived.estimate > 0.99
    # 30 s of flight, of which 20 in turbulence
    share = flights.flown.end_time.mean() / 20.0
    difference = flights.limited_time * share - flights.linear_time
    # the demand is ahead of the nozzle, and a limit that is reached takes some of the gain
    assert abs(difference) < 5.0 * flights.limited_time_error * share + 0.3 * flights.linear_time
    # flights see the limit at samples alone, and crossings come in clusters
    chance = flights.linear_probability_of_none
    error = 5.0 * np.sqrt(chance * (1.0 - chance) / runs)
    assert chance - error < flights.unlimited.estimate < chance + error + 0.02


@pytest.mark.thorough
def test_a_limit_that_is_met_often_has_no_linear_answer():
    flights = fly_turbulence(
        AUTOPILOT, PLANT, AIR, SPEED, 20.0, deflection_limit=np.radians(0.1), runs=100
    )
    assert not flights.is_linear
    assert flights.largest_exceedance > flights.linear_time > 0.1
    assert flights.limited_time > 1.5 * flights.linear_time
    assert flights.survived.upper < 0.9
    assert "its answer is none" in str(flights.tables()[0])


@pytest.mark.thorough
def test_a_known_wind_and_fewer_runs_change_no_other_flight():
    wind = tv.TriangularWind(peak=np.radians(2.0), duration=5.0)
    case = (AUTOPILOT, PLANT, AIR, SPEED, 8.0)
    limit = {"deflection_limit": np.radians(0.6), "wind": wind, "seed": 4}
    few, more = (fly_turbulence(*case, **limit, runs=runs) for runs in (3, 5))
    assert np.array_equal(few.flown.peak_deflection, more.flown.peak_deflection[:3])
    calm = fly_turbulence(*case, **{**limit, "wind": None}, runs=3)
    assert np.all(few.flown.peak_deflection > calm.flown.peak_deflection)


@pytest.mark.thorough
def test_along_a_flight_the_worst_time_says_whether_the_loop_is_linear():
    schedule = tv.load_schedule("configuration-i")
    coefficients = tv.Plant.from_vehicle(schedule.vehicle, "drift-exact").coefficients
    rule = {"natural_frequency": 1.0, "damping": 0.7, "actuator": ACTUATOR}
    gains = tv.control.GainSchedule.design(schedule.times, coefficients, tv.design_gains, **rule)
    gains = replace(gains, autopilot=replace(gains.autopilot, sample_rate=25.0))
    severe = tv.winds.Turbulence.mil_f_8785c("severe")
    of = {"start": 50.0, "stop": 80.0, "runs": 40}
    wide, narrow = (
        fly_turbulence_along(schedule, gains, severe, deflection_limit=np.radians(limit), **of)
        for limit in (1.0, 0.15)
    )
    assert wide.is_linear
    assert wide.survived.estimate == wide.unlimited.estimate == 1.0
    assert not narrow.is_linear
    assert narrow.survived.upper < 0.9
    peaks = wide.flown.peak_deflection
    sizes = wide.linear.deviation()
    assert sizes.max() < np.median(peaks) < 4.0 * sizes.max()


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"runs": 1}, "runs must be 2 to 100000"),
        ({"autopilot": replace(AUTOPILOT, sample_rate=None)}, "give the autopilot a sample_rate"),
        ({"deflection_limit": -1.0}, "deflection_limit must be positive"),
    ],
)
def test_what_is_not_flown_is_refused_in_a_sentence(changes, sentence):
    given = {"autopilot": AUTOPILOT, "plant": PLANT, "turbulence": AIR, "speed": SPEED}
    given |= {"duration": 5.0, "deflection_limit": 0.01}
    with pytest.raises(InputError, match=sentence):
        fly_turbulence(**(given | changes))
