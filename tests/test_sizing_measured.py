"""Measured winds in a sizing: levels across the flight, and heights where the wind is not known."""

import numpy as np
import pytest

import tvclin as tv
from tvclin.soundings.levels import towards

EAST = np.radians(90)


@pytest.fixture(scope="module")
def flight() -> tv.FlightSchedule:
    return tv.load_schedule("configuration-i")


def test_a_level_exactly_across_the_flight_is_one_without_wind(flight) -> None:
    """To rounding: neither sine nor cosine of a whole degree is exactly zero."""
    height = np.linspace(0.0, 45e3, 31)
    for seed in range(20):
        rng = np.random.default_rng(seed)
        speed, come = rng.uniform(5.0, 50.0, 31), rng.integers(0, 361, 31)
        come[::3] = rng.choice([0, 180, 360], 11)
        east, north = towards(speed, np.radians(come))
        exact = np.where(come % 180 == 0, 0.0, east)
        met, clean = (
            tv.fly_through(tv.WindProfile(height=height, east=e, north=north), flight, azimuth=EAST)
            for e in (east, exact)
        )
        for time in (50.0, 66.0, 90.0):
            vehicle, at = flight.at(time), np.linspace(41.0, 116.0, 301)
            assert met(vehicle)(at) == pytest.approx(clean(vehicle)(at), abs=1e-13), seed
