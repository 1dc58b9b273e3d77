"""Load relief by an accelerometer, against an integration of forces and against a vane."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tvclin as tv
from tests.turns import usual
from tvclin.case.load import FlownLoad

BOOSTER = tv.load_vehicle("configuration-i")
GAINS = tv.control.half_relief_gains(BOOSTER)
WIND = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
LIMIT = np.radians(0.6)
SLOPE = 5.0 / 3.75
"""Of the wind [deg/s]: what a lag of one second is off by."""


def flown(law, rate=100.0):
    design = tv.control.AutopilotDesign(sample_rate=rate)
    nozzle = tv.Nozzle(limit=LIMIT)
    case = tv.Case(vehicle=BOOSTER, model="fixed-path", nozzle=nozzle, design=design)
    result = FlownLoad.of(case, "relief", law)
    assert result.status == "survived"
    return float(np.degrees(result.load))


@pytest.mark.thorough
@pytest.mark.parametrize("station", usual([-3.0, 0.0, 8.0], 2))
def test_the_load_is_that_of_an_integration_of_the_forces(station):
    law = tv.control.AccelerometerLaw(GAINS, BOOSTER, station=station, bandwidth=30.0)
    v, servo = BOOSTER, tv.Case(vehicle=BOOSTER).nozzle.actuator
    mass, own = v.weight / 9.80665, law.numbers
    frequency, damping = servo.natural_frequency, servo.damping

    def moving(t, x):
        theta, rate, nozzle, turning, read = x
        delta = np.clip(nozzle, -LIMIT, LIMIT)
        lift = v.normal_force_slope * (theta - float(WIND(t)))
        spin = (lift * v.aerodynamic_arm - v.thrust * v.control_arm * delta) / v.moment_of_inertia
        felt = (lift + v.thrust * delta) / mass + station * spin
        request = own.attitude * theta + own.attitude_rate * rate + law.gain * read
        swing = frequency**2 * (np.clip(request, -LIMIT, LIMIT) - nozzle)
        return [
            rate,
            spin,
            turning,
            swing - 2.0 * damping * frequency * turning,
            30.0 * (felt - read),
        ]

    times = np.linspace(0.0, 12.0, 4001)
    x = solve_ivp(moving, (0.0, 12.0), np.zeros(5), t_eval=times, max_step=0.02, rtol=1e-8)
    load = np.degrees(np.abs(x.y[0] - WIND(times)).max())
    # a sample of 2 ms late, and what is between the times
    assert flown(law, 500.0) == pytest.approx(load, abs=2.0 * SLOPE * 0.002)


def test_at_the_centre_of_percussion_it_is_a_vane_but_for_its_lag():
    percussion = BOOSTER.moment_of_inertia * 9.80665 / (BOOSTER.weight * BOOSTER.control_arm)
    law = tv.control.AccelerometerLaw(GAINS, BOOSTER, station=percussion, bandwidth=500.0)
    alpha, deflection, _ = law.sensitivities
    assert deflection == pytest.approx(0.0, abs=1e-12 * alpha)
    assert law.gain * alpha == pytest.approx(GAINS.alpha_gain, rel=1e-12)
    assert law.numbers.attitude == pytest.approx(GAINS.attitude_gain, rel=1e-12)
    vane = flown(tv.SaturatedLaw(GAINS))
    assert flown(law) == pytest.approx(vane, abs=SLOPE * (0.01 + 1.0 / 500.0))


@pytest.mark.parametrize(
    ("gains", "station", "words"),
    [
        (tv.control.canonical_gains(BOOSTER), 0.0, "gain on the angle of attack"),
        (GAINS, 20.0, "no place for the accelerometer"),
        (GAINS, np.nan, "station"),
    ],
)
def test_what_feels_no_wind_is_refused(gains, station, words):
    with pytest.raises(tv.InputError, match=words):
        tv.control.AccelerometerLaw(gains, BOOSTER, station=station)
