"""Flights that settle slowly survive by their modes, and flying them on shows that it is so."""

from dataclasses import replace

import numpy as np
import pytest

import tvclin as tv
from tvclin.flights.closed_loop.batch import Batch, Hardware, flights, one_flight
from tvclin.flights.closed_loop.fly_many import _continuation, _overshoots, remain_linear
from tvclin.flights.closed_loop.law_batch import law_batch
from tvclin.flights.closed_loop.sampled import finish
from tvclin.flights.closed_loop.sampled_stability import linear_gain_margins

PLANT = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "fixed-path")
WIND = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
TRIM = float(PLANT.coefficients.B) * float(WIND.peak)
LAW = tv.SaturatedLaw(tv.design_gains(PLANT.coefficients, natural_frequency=1.0, damping=0.7))
SERVO = tv.Actuator(natural_frequency=20.0, damping=0.7)


@pytest.mark.parametrize("actuator", [SERVO, replace(SERVO, damping=None)], ids=["second", "first"])
def test_a_nozzle_that_is_said_to_remain_within_its_limits_does_so(actuator):
    """Gains near both stability limits; limits of deflection and rate that some reach again."""
    h, law = 0.02, law_batch(LAW, (32,))
    hardware = Hardware(h, 0.05, actuator, rate_limit=np.tile([0.004, 0.02, 0.1, np.inf], 8))
    one = one_flight(PLANT, LAW, WIND, TRIM, Hardware(h, 0.05, actuator))
    fall, rise = linear_gain_margins(one, "gain", float(PLANT.poles[0]))
    gains = np.repeat([1.001 / fall, 1.02 / fall, 1.0, 0.999 * rise], 8)
    limits = TRIM * np.tile(np.repeat([1.5, 6.0], 4), 4)
    batch = Batch(
        PLANT, hardware, WIND, law, limit=limits, shape=(32,), gain=gains, until=WIND.end + 4.0
    )
    f = flights(batch)
    finish(f, law)
    linear = remain_linear(batch, f, np.arange(32))
    reached, g = np.zeros(32, bool), f
    for _ in range(40):
        g = _continuation(g, np.arange(32), law)
        rate = g.now.peaks[:, 3] >= 0.999 * hardware.rate_limit
        reached |= (g.now.peaks[:, 5] > 0.0) | rate
    assert linear.sum() > 8
    assert reached.sum() > 4
    assert not np.any(linear & reached)


def test_a_flight_survives_up_to_the_stability_limit_that_it_approaches_in_its_linear_range():
    """60 time constants after the wind its amplitude has hardly fallen: flown ten times as long."""
    options = {"deflection_limit": 5.0 * TRIM, "actuator": SERVO, "sample_rate": 50.0}
    one = one_flight(PLANT, LAW, WIND, 5.0 * TRIM, Hardware(0.02, 0.0, SERVO))
    edge = 1.0 / linear_gain_margins(one, "gain", float(PLANT.poles[0]))[0]
    gain = edge * np.array([1.0001, 1.001, 0.95])
    status = tv.fly_many(PLANT, LAW, WIND, gain=gain, **options).status
    assert status.tolist() == ["survived", "survived", "lost"]
    ends = WIND.end + 60.0 / float(PLANT.poles[0]) * np.array([0.5, 1.0, 10.0])
    flown = [tv.fly_many(PLANT, LAW, WIND, gain=gain, until=end, **options) for end in ends]
    attitudes = np.abs([late.final_attitude for late in flown])
    assert np.all(np.diff(attitudes, axis=0)[:, :2] < 0.0)
    assert attitudes[1, 2] > attitudes[0, 2]
    limited = [late.saturated_time_fraction * (late.end_time - WIND.onset) for late in flown]
    np.testing.assert_allclose(limited[2][:2], limited[0][:2], rtol=1e-9)  # no further sample


@pytest.mark.parametrize("damping", [None, 0.1, 0.7, 1.5])
@pytest.mark.parametrize("length", [0.0025, 0.025, 0.25])
def test_no_commands_turn_a_nozzle_faster_than_the_bound(damping, length):
    """Commands that change by one in each sample, each towards the sign of the response then."""
    actuator = tv.Actuator(natural_frequency=20.0, damping=damping)
    one = one_flight(PLANT, LAW, WIND, TRIM, Hardware(length, 0.0, actuator))
    times = np.arange(0.0, 40.0 / (20.0 * (damping or 1.0)) + 2.0 * length, length / 100.0)
    roots, residues = np.roots(actuator.denominator), actuator.denominator[-1]
    partial = [residues / np.prod(np.delete(z - roots, k)) for k, z in enumerate(roots)]
    response = sum(c * np.exp(z * times) for c, z in zip(partial, roots, strict=True)).real
    whole = np.abs(response[: times.size // 100 * 100]).reshape(-1, 100)
    largest = length * whole.sum(axis=0).max()
    (bound,) = _overshoots(one, flights(one))
    assert 1.0 <= largest <= bound * (1.0 + 1e-9)
    if damping is not None and length < 0.01:
        assert bound < 1.2 * largest
