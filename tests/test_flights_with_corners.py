"""Flights on which a step, a look or a limit was once missed, each beside something independent."""

import numpy as np
import pytest

import tvclin as tv
from tvclin import Actuator, Autopilot, Coefficients, Plant, SampledWind
from tvclin.kernels.choice import available, pinned
from tvclin.kernels.series import exits, summits

EACH_TWIN = pytest.mark.parametrize(
    "compiled",
    [False, pytest.param(True, marks=pytest.mark.skipif(not available(), reason="needs numba"))],
)
PLANT = Plant(Coefficients.from_beta(beta=0.5, B=0.1))


def flown(compiled, plant, law, wind, **options):
    with pinned(compiled):
        return tv.fly_many(plant, tv.SaturatedLaw(law), wind, **options)


@EACH_TWIN
def test_a_swing_that_every_look_meets_near_zero_is_not_calm(compiled):
    coefficients = Coefficients(
        mu_alpha=0.31041873324610775, mu_delta=2.462824221914981, C1=0.02330299964413709,
        C2=0.0039831397506951555, b1=0.026948678984110262, b2=0.0151004447270701,
        q=0.00016661326866430746,
    )  # fmt: skip
    law = Autopilot(
        attitude_gain=0.8829984063019573,
        rate_gain=1.5224736722124805,
        integral_gain=0.017804666830078565,
    )
    found = flown(
        compiled,
        Plant.from_coefficients(coefficients, "drift-exact"),
        law,
        tv.TriangularWind(peak=0.06776156207485205, duration=2.1335266048749197),
        deflection_limit=0.04019866232893979,
        actuator=Actuator(natural_frequency=2.578591634944981, damping=0.1),
        until=60.0,
    )
    assert abs(found.final_attitude) > 1e3
    assert str(found.status) == "lost"


@EACH_TWIN
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("frequency", [0.5, 20.0])
def test_a_nozzle_that_does_not_swing_is_flown_without_a_warning(frequency, compiled):
    """Its characteristic equation is singular where the search for its ringing begins."""
    law = Autopilot(attitude_gain=0.3, rate_gain=0.6)
    servo = Actuator(natural_frequency=frequency, damping=1.0)
    wind = tv.TriangularWind(peak=0.08, duration=8.0)
    options = {"deflection_limit": 0.02, "actuator": servo}
    found = flown(compiled, PLANT, law, wind, until=5.0, **options)
    times = np.linspace(0.0, 5.0, 501)
    expected = tv.fly(PLANT, tv.SaturatedLaw(law), wind, times, **options)
    assert found.final_attitude == pytest.approx(expected.outputs[0, -1], rel=1e-7)


@EACH_TWIN
@pytest.mark.parametrize("zeros", [2, 6, 12])
def test_the_first_gust_after_a_long_calm_is_flown_in_small_steps(zeros, compiled):
    """At rest nothing bounds a step, so that the next one is far too long at first."""
    time = np.r_[np.linspace(-20.0, 0.0, zeros), 4.0, 8.0]
    wind = SampledWind(time=time, angle=np.r_[np.zeros(zeros), 0.08, 0.0])
    law, servo = Autopilot(attitude_gain=0.3, rate_gain=0.6), Actuator(natural_frequency=60.0)
    options = {"deflection_limit": 0.02, "actuator": servo, "until": 20.0}
    found = flown(compiled, PLANT, law, wind, **options)
    plain = tv.TriangularWind(peak=0.08, duration=8.0)
    expected = flown(compiled, PLANT, law, plain, **options)
    assert found.peak_deflection == pytest.approx(expected.peak_deflection, rel=1e-8)
    assert found.peak_deflection_rate == pytest.approx(expected.peak_deflection_rate, rel=1e-6)


TIMES = [
    -4.628425555747201, -3.4040596688400004, -2.6718862132400774, -0.35776553323863714,
    -0.16381753688010914, -0.08926796483855703, 0.89053529570855, 1.6656429262989771,
    2.9713989375421344, 3.5323811236582507, 5.430235064330866, 5.624760772594852,
    6.4476378308793425, 7.469394252587545, 8.522862450004917, 8.97058301814133,
    11.138449272825866, 11.233892878789955, 11.83263751182465, 11.885498047999551,
]  # fmt: skip
ANGLES = [
    0.006914863119121565, 0.008444382771314306, -0.01204902953095056, -0.01308688519945716,
    -0.016426584146750373, -0.019062286660977132, 0.009460986865422518, -0.02043673745381001,
    0.01864345752791213, 0.016960582942778708, 0.00048251757775861375, 0.0025959542255975187,
    0.010591137435495513, -0.005378472915526732, 0.007034396881161345, -0.006582298642158679,
    -0.004978174874022302, -0.010290751959890683, -0.0028059304070869057, 0.016836104168113302,
]  # fmt: skip


@EACH_TWIN
def test_a_limit_met_before_another_one_in_the_same_step_is_met(compiled):
    coefficients = Coefficients(mu_alpha=0.2757165990635356, mu_delta=2.25986019089566)
    plant = Plant.from_coefficients(coefficients)
    law = Autopilot(attitude_gain=0.7767246194428844, rate_gain=1.6203210878838092)
    wind = SampledWind(time=TIMES, angle=ANGLES)
    options = {
        "deflection_limit": 0.0027658424522817894,
        "rate_limit": 0.0036625004836458243,
        "actuator": Actuator(natural_frequency=9.955052834941672, damping=2.0),
    }
    found = flown(compiled, plant, law, wind, until=20.0, **options)
    times = np.linspace(TIMES[0], 20.0, 5001)
    expected = tv.fly(plant, tv.SaturatedLaw(law), wind, times, **options).outputs[0]
    assert found.peak_attitude == pytest.approx(np.abs(expected).max(), rel=1e-6)
    assert found.final_attitude == pytest.approx(expected[-1], rel=1e-6)


def test_a_hump_that_flattens_out_is_seen():
    """The cubic t (1.05 - t)^2 rises to 0.1715 at 0.35; its tangent at 1 stays far below."""
    c, one = np.zeros((12, 1)), np.ones(1)
    c[1:4, 0] = 1.1025, -2.1, 1.0
    assert summits(c, one, 0.15 * one) == pytest.approx(0.35 * 0.7**2, rel=1e-6)
    (when,), (side,) = exits(c, one, -0.15 * one, 0.15 * one)
    assert side == 1.0
    assert when * (1.05 - when) ** 2 == pytest.approx(0.15, rel=1e-9)


@EACH_TWIN
@pytest.mark.parametrize("limit", [1.0, 1e6])
def test_a_limit_that_is_never_near_changes_nothing(limit, compiled):
    """Swings of the nozzle count beside what the wind asks of it, not beside its limit."""
    wind = SampledWind(time=np.arange(30.0), angle=0.05 * np.sin(1.3 * np.arange(30)) ** 2)
    law = Autopilot(attitude_gain=0.3, rate_gain=0.6, alpha_gain=0.05)
    options = {"actuator": Actuator(natural_frequency=200.0), "until": 20.0}
    found = flown(compiled, PLANT, law, wind, deflection_limit=limit, **options)
    expected = flown(compiled, PLANT, law, wind, deflection_limit=0.02, **options)
    assert found.peak_deflection == pytest.approx(expected.peak_deflection, rel=1e-6)
    assert found.peak_deflection_rate == pytest.approx(expected.peak_deflection_rate, rel=1e-4)
