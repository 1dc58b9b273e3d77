"""Covariances of loops in turbulence, frozen and along a flight, with python-control and scipy."""

from dataclasses import replace

import control
import numpy as np
import pytest
from peers import PROCESSOR, ratio
from scipy.linalg import expm

import tvclin as tv

ACTUATOR = tv.Actuator(natural_frequency=25.0, damping=0.7)
AIR = tv.winds.Turbulence(6.0)
VEHICLE = tv.load_vehicle("configuration-i")
BEND = {"damping": 0.005, "modal_mass": 5.1e4, "gimbal_displacement": 1.0, "gimbal_slope": -0.068}
BEND |= {"attitude_slope": 0.027, "rate_slope": 0.025, "pressure_displacement": -0.43}
STRUCTURE = tv.Structure(
    bending=tuple(tv.vehicle.BendingMode(frequency=w, **BEND) for w in (13.6, 30.0)),
    rate_gyro=tv.vehicle.Filter.low_pass(120.0, 0.7),
)
NOTCHES = tuple(tv.vehicle.Filter.notch(w, 0.06, 0.6) for w in (13.6, 30.0))
STEP, OF_PEER = 0.05, 20


def test_a_frozen_loop_with_two_modes_and_filters(benchmark):
    plant = tv.FlexiblePlant.from_vehicle(VEHICLE, STRUCTURE)
    autopilot = tv.Autopilot(
        attitude_gain=0.2144578,
        rate_gain=0.486223,
        actuator=ACTUATOR,
        filters=NOTCHES,
        delay=0.02,
    )
    closed = autopilot.close(plant)
    A, b, c = AIR.shaping_filter(VEHICLE.velocity)
    shape = control.ss(A, b, c / VEHICLE.velocity, 0, inputs="n", outputs="wind", name="filter")

    def peer():
        whole = control.interconnect(
            [closed, shape], inputs=["n"], outputs=["deflection"], check_unused=False
        )
        return control.lyap(whole.A, whole.B @ whole.B.T)

    ratio(
        benchmark,
        lambda: tv.control.turbulence_covariance(autopilot, plant, AIR, VEHICLE.velocity),
        peer,
        peer_name="control.interconnect and control.lyap, of a loop that is closed already",
        floor="assembly of the loop; its poles and a proof that they hold with the exact delay",
        clock=PROCESSOR,
    )


@pytest.mark.parametrize("modes", [0, 2], ids=["rigid", "two modes"])
@pytest.mark.parametrize("sample_rate", [None, 25.0], ids=["continuous", "25 Hz"])
def test_along_a_flight_of_75_seconds(benchmark, modes, sample_rate):
    schedule = tv.load_schedule("configuration-i")
    coefficients = tv.Plant.from_vehicle(schedule.vehicle, "drift-exact").coefficients
    rule = {"natural_frequency": 1.0, "damping": 0.7, "actuator": ACTUATOR}
    gains = tv.control.GainSchedule.design(schedule.times, coefficients, tv.design_gains, **rule)
    more = {"filters": NOTCHES} if modes else {}
    gains = replace(gains, autopilot=replace(gains.autopilot, sample_rate=sample_rate, **more))
    structure = STRUCTURE if modes else None
    found = tv.control.turbulence_along(schedule, gains, AIR, structure=structure)
    of_one = replace(gains.at(66.0), sample_rate=None)
    plant = tv.Plant.from_vehicle(VEHICLE, "drift-exact")
    if structure:
        plant = tv.FlexiblePlant.from_vehicle(VEHICLE, structure, "drift-exact")
    A = of_one.close(plant).A
    n = len(A)
    whole = np.block([[-A, np.eye(n)], [np.zeros((n, n)), A.T]])

    def peer():
        return [expm(whole * STEP * (1.0 + 0.01 * k)) for k in range(OF_PEER)]

    ratio(
        benchmark,
        lambda: tv.control.turbulence_along(schedule, gains, AIR, structure=structure),
        peer,
        peer_name="scipy.linalg.expm of the matrix of Van Loan for each step, of the closed loop",
        per=len(found.times) - 1,
        peer_per=OF_PEER,
        floor="a series and six doublings for each step",
        clock=PROCESSOR,
    )
