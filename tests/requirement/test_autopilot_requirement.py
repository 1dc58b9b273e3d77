"""The autopilot requirement of a measured wind counts the dynamic pressure of that wind."""

from dataclasses import replace

import numpy as np
import pytest

import tvclin as tv
from tvclin.ascent.wind_along import SoundingWind
from tvclin.case.case import Case
from tvclin.requirement.autopilot_requirement import autopilot_requirement
from tvclin.vehicle.vehicle import at_pressure

FLIGHT = tv.load_schedule("configuration-i")
VEHICLE = FLIGHT.at(66.0)
SPEED, WINDOW = 15.0, 20.0
"""Speed of a west wind at all heights [m/s], and the length of its window [s]."""


def requirement_of(wind, plane="pitch"):
    case = Case(vehicle=VEHICLE, wind=wind, plane=plane)
    return case, autopilot_requirement(case, case.plant, case.autopilot, None)


def west_wind(azimuth_deg):
    profile = tv.WindProfile(height=[0.0, 40e3], east=[SPEED] * 2, north=[0.0] * 2)
    return SoundingWind(
        name="west",
        profile=profile,
        schedule=FLIGHT,
        azimuth=np.radians(azimuth_deg),
        window=WINDOW,
    )


@pytest.mark.thorough
@pytest.mark.parametrize(("azimuth", "plane"), [(270, "pitch"), (0, "yaw")])
def test_a_sounding_is_flown_at_its_largest_pressure_in_the_window(azimuth, plane):
    """The ratio is that of the wind triangle, over the window by hand."""
    case, required = requirement_of(west_wind(azimuth), plane)
    time = 66.0 + np.linspace(-0.5, 0.5, 2001) * WINDOW
    path, speed = (
        np.interp(time, FLIGHT.times, x) for x in (FLIGHT.flight_path_angle, FLIGHT.speed)
    )
    along, across = (SPEED, 0.0) if plane == "pitch" else (0.0, SPEED)  # against and across
    ratio = (np.cos(path) + along / speed) ** 2 + np.sin(path) ** 2 + (across / speed) ** 2
    denser = replace(case, vehicle=at_pressure(VEHICLE, ratio.max()))
    law = tv.SaturatedLaw.of(case.autopilot)
    by_hand = tv.closed_loop_boundary(denser.plant, law, case.history, **case.hardware)
    assert required.deflection == pytest.approx(abs(float(by_hand.deflection)), rel=1e-4)
    low, high = required.nominal_deflection, required.deflection
    assert low < high
    verdicts = [required.sufficient(x) for x in (0.999 * low, 0.5 * (low + high), 1.001 * high)]
    assert verdicts == [False, None, True]


def test_a_sounding_from_behind_and_the_nominal_pressure_count_as_they_are():
    _, behind = requirement_of(west_wind(90))
    assert behind.head is None
    assert behind.sufficient(1.001 * behind.nominal_deflection) is True
    ahead = Case(vehicle=VEHICLE, wind=west_wind(270), sign="frozen")
    nominal = autopilot_requirement(ahead, ahead.plant, ahead.autopilot, None)
    assert nominal.head is None


@pytest.mark.thorough
def test_a_history_has_the_pressure_of_its_own_sign():
    """A negative angle is a head wind, whose speed along the path gives its angle."""
    tail = tv.TriangularWind(peak=np.radians(5), duration=7.5)
    case, head = requirement_of(-1.0 * tail)
    path = float(VEHICLE.attitude)
    along = np.sin(np.radians(5)) / np.sin(path - np.radians(5))  # over the speed, from ahead
    ratio = (np.cos(path) + along) ** 2 + np.sin(path) ** 2
    denser = replace(case, vehicle=at_pressure(VEHICLE, ratio))
    by_hand = autopilot_requirement(denser, denser.plant, case.autopilot, None)
    assert head.deflection == pytest.approx(by_hand.nominal_deflection, rel=1e-6)
    assert requirement_of(tail)[1].head is None
