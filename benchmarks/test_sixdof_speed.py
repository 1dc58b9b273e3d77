"""Flights with six degrees of freedom: 15 s at a step of 0.01 s, beside the bare engine."""

import numpy as np
import pytest
from peers import ratio

import tvclin as tv
from tvclin.ascent.nominal_flight import load_flight_condition
from tvclin.base.units import FOOT
from tvclin.flights.sixdof.airframe import Engine
from tvclin.flights.sixdof.fly_sixdof import SixDof
from tvclin.flights.sixdof.model import model_xml, planet_xml
from tvclin.flights.sixdof.steering import TrimThenHold

pytest.importorskip("jsbsim")

VEHICLE = tv.load_vehicle("configuration-i")
WIND = tv.TriangularWind(peak=np.radians(1.0), duration=7.5)
TIMES = np.linspace(0.0, 15.0, 151)
STEPS = 1500


@pytest.fixture
def bare():
    initial = {"h-sl-ft": 0.0, "theta-rad": VEHICLE.attitude, "u-fps": VEHICLE.velocity / FOOT}
    engine = Engine(model_xml(VEHICLE), initial, 0.01, planet=planet_xml())

    def run():
        engine.reset()
        for _ in range(STEPS):
            engine.run()

    return run


def test_sixdof_flight_with_a_law_in_python(benchmark, bare):
    law = tv.TrimLaw(tv.Plant.from_vehicle(VEHICLE, model="drift-exact"))

    ratio(
        benchmark,
        lambda: tv.fly_sixdof(VEHICLE, law, WIND, TIMES, deflection_limit=0.0021),
        bare,
        peer_name="steps of JSBSim alone",
        floor="JSBSim's step, then the law in Python",
    )


def test_sixdof_flight_along_the_trajectory(benchmark, bare):
    law = tv.TrimLaw(tv.Plant.from_vehicle(VEHICLE, model="drift-exact"))
    condition, start = load_flight_condition("configuration-i"), VEHICLE.time - 3.75
    wind, times = WIND.shift(start), TIMES + start

    ratio(
        benchmark,
        lambda: tv.fly_sixdof(
            VEHICLE, law, wind, times, deflection_limit=0.0021, condition=condition
        ),
        bare,
        peer_name="steps of JSBSim alone",
        floor="JSBSim's step, a hold in the other plane, then the law in Python",
    )


def test_sixdof_flight_of_the_reports_control(benchmark, bare):
    case = SixDof(VEHICLE)
    air, trim = case.air(WIND, 0.0, 15.0), tv.TrimLaw(tv.Plant.from_vehicle(VEHICLE, "fixed-path"))

    ratio(
        benchmark,
        lambda: case.flown(TrimThenHold(trim, 0.00123, 1.0, WIND, air.times, 0.01), air),
        bare,
        peer_name="steps of JSBSim alone",
        floor="JSBSim's step, and six properties read and set",
    )
