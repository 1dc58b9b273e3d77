"""At the limit for which a flight is sized in a sounding, the trim law flown survives it."""

import numpy as np
import pytest

import tvclin as tv
from tests.turns import usual
from tvclin.ascent.nominal_flight import load_flight_condition

REPORTED = ("configuration-i", "configuration-ii")


def launcher() -> tv.FlightSchedule:
    """Return the flight of a small launcher, a tenth of configuration I."""
    vehicle = tv.Vehicle(
        weight=130e3,
        thrust=230e3,
        moment_of_inertia=2.2e5,
        normal_force_slope=1.2e5,
        aerodynamic_arm=3.0,
        control_arm=6.0,
        axial_force=9e3,
        velocity=480.0,
        attitude=np.radians(60.0),
        time=60.0,
    )
    condition = load_flight_condition("configuration-i")
    return tv.FlightSchedule.from_flight(vehicle, condition, start=40.0, stop=90.0, step=10.0)


def sounding(rng: np.random.Generator) -> tv.WindProfile:
    """Return a jet that turns with height, and what is not known of it."""
    height = np.concatenate([[0.0], np.sort(rng.uniform(0.0, 45e3, rng.integers(12, 40))), [60e3]])
    jet = np.exp(-(((height - rng.uniform(8e3, 14e3)) / rng.uniform(2e3, 6e3)) ** 2))
    speed = rng.uniform(10.0, 70.0) * jet + np.abs(rng.normal(0.0, 5.0, height.size))
    turning = np.cumsum(rng.normal(0.0, 12.0, height.size))
    direction = np.radians(rng.uniform(0.0, 360.0) + turning)
    return tv.WindProfile(
        height=height, east=-speed * np.sin(direction), north=-speed * np.cos(direction)
    )


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "soundings"),
    usual([("launcher", 10), *((name, 40) for name in ("launcher", *REPORTED))], 0),
)
def test_flown_trim_laws_survive_at_the_sized_limit(name: str, soundings: int) -> None:
    schedule = launcher() if name == "launcher" else tv.load_schedule(name, step=20.0)
    rng, flown = np.random.default_rng(7), 0
    times = np.linspace(*schedule.span, 4)[1:3]
    for _ in range(soundings):
        azimuth = float(rng.uniform(0.0, 2.0 * np.pi))
        encountered = tv.fly_through(sounding(rng), schedule, azimuth=azimuth)
        sized = tv.size(schedule, encountered, times=times, dead_bands=1.0)
        limit = float(np.nanmax(sized.required["K = 1"]))
        for time in sized.times[~np.isnan(sized.required["K = 1"][:, 0])].tolist():
            vehicle = schedule.at(time)
            plant = tv.Plant.from_vehicle(vehicle, "drift-exact")
            law = tv.TrimLaw(tv.Plant(plant.coefficients, "fixed-path"))
            wind = encountered.of_both_signs(vehicle)
            # At what is required a flight is on the edge: half a percent above it decides.
            options = {"deflection_limit": 1.005 * limit, "sample_rate": 200.0}
            outcome = tv.fly_many(plant, law, wind, **options).status
            assert outcome == "survived", (azimuth, time, np.degrees(limit))
            flown += 1
    assert flown > soundings
