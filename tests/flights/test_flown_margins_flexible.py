"""Flown margins of a flexible vehicle: near rest they are those of the sampled loop."""

from dataclasses import replace

import numpy as np
import pytest

import tvclin as tv
from tests.flexible import MODE, TANK
from tests.turns import usual

VEHICLE = tv.load_vehicle("configuration-i")
ENGINE = tv.vehicle.Engine(mass=2000.0, arm=1.4, moment_of_inertia=2e3)
WIND = tv.TriangularWind(peak=np.radians(5), duration=7.5)
NOTCH = tv.vehicle.Filter.notch(24.0 * np.pi, 0.05, 0.5)
SERVO = tv.Actuator()
RATE, DELAY, LIMIT = 100.0, 0.01, np.radians(0.5)


def plant_of(engine=None):
    structure = tv.Structure(bending=(MODE,), slosh=(TANK,), engine=engine)
    return tv.FlexiblePlant.from_vehicle(VEHICLE, structure, "drift-exact")


def gains(plant):
    return tv.design_gains(plant.coefficients, natural_frequency=1.5, damping=0.7, filters=(NOTCH,))


@pytest.fixture(scope="module", params=usual([None, ENGINE], 1), ids=["light", "engine"])
def plant_and_margins(request):
    plant = plant_of(request.param)
    law = tv.SaturatedLaw(gains(plant))
    nozzle = {"actuator": SERVO, "sample_rate": RATE, "delay": DELAY}
    return plant, tv.flights.flown_margins(plant, law, WIND, limit=LIMIT, **nozzle)


@pytest.mark.thorough
def test_near_rest_they_are_the_margins_of_the_sampled_loop(plant_and_margins):
    """Another engine: the loop in the w plane, its crossings by Newton's method."""
    plant, m = plant_and_margins
    sampled = replace(gains(plant), actuator=SERVO, delay=DELAY, sample_rate=RATE).margins(plant)
    # Differences of steps of small states leave 1e-9 or so of their numbers.
    assert m.gain_rise.linear == pytest.approx(sampled.gain_increase, rel=1e-6)
    assert m.gain_fall.linear == pytest.approx(sampled.aero_margin, rel=1e-6)
    if m.delay.linear > 25.0 / RATE:  # more than such a loop is computed for
        assert m.delay.linear == pytest.approx(sampled.delay_margin, rel=1e-6)
        return
    # Phase over frequency is no exact delay of a sampled loop, whose aliases turn otherwise.
    late = replace(gains(plant), actuator=SERVO, sample_rate=RATE)
    for factor, stable in ((1.0 - 1e-5, True), (1.0 + 1e-5, False)):
        moved = replace(late, delay=DELAY + factor * m.delay.linear)
        assert moved.margins(plant).stable == stable


@pytest.mark.thorough
def test_a_change_that_is_lost_is_where_the_flights_are_lost(plant_and_margins):
    plant, m = plant_and_margins
    law = tv.SaturatedLaw(gains(plant))
    one = m.gain_fall
    assert one.cause == "lost"
    many = tv.fly_many(
        plant,
        law,
        WIND,
        deflection_limit=LIMIT,
        actuator=SERVO,
        sample_rate=RATE,
        delay=DELAY,
        gain=1.0 / (one.value * np.array([1.0 - 1e-3, 1.0 + 1e-3])),
    )
    assert many.status.tolist() == ["survived", "lost"]


@pytest.mark.thorough
def test_less_effect_of_the_nozzle_is_less_thrust_vector_of_the_vehicle(plant_and_margins):
    """The engine's inertia stays: a vehicle with another control force is flown as it is."""
    plant, m = plant_and_margins
    law, one = tv.SaturatedLaw(gains(plant)), m.effectiveness_fall
    for factor, status in ((one.value * (1 - 1e-3), "survived"), (one.value * (1 + 1e-3), "lost")):
        weak = VEHICLE.replace(control_force_slope=VEHICLE.control_force / factor)
        changed = replace(plant, vehicle=weak)
        nozzle = {"actuator": SERVO, "sample_rate": RATE, "delay": DELAY}
        flown = tv.fly_many(changed, law, WIND, deflection_limit=LIMIT, **nozzle)
        assert flown.status == status
