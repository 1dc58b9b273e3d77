"""A window of a sounding begins and ends with steps that the sounding does not have."""

import numpy as np
import pytest

import tvclin as tv
from tvclin.ascent.wind_along import SoundingWind

FLIGHT = tv.load_schedule("configuration-i")
VEHICLE = FLIGHT.at(66.0)


def sounding(window, height=(0.0, 40e3), east=(30.0, 30.0)):
    profile = tv.WindProfile(height=list(height), east=list(east), north=[0.0] * len(east))
    return SoundingWind(
        name="west", profile=profile, schedule=FLIGHT, azimuth=np.radians(90.0), window=window
    )


def test_the_steps_at_the_ends_of_a_window_are_the_wind_angles_there():
    """Of a wind from behind at 30 m/s, by eq (B1e) at the speeds of the flight."""
    time = np.array([56.0, 76.0])
    path, speed = (
        np.interp(time, FLIGHT.times, x) for x in (FLIGHT.flight_path_angle, FLIGHT.speed)
    )
    expected = np.arcsin(30.0 / speed * np.sin(path))
    assert sounding(20.0).steps(VEHICLE, "pitch") == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(("share", "steps"), [(0.05, False), (0.2, True)])
def test_a_window_that_takes_the_whole_wind_but_a_tenth_has_no_steps(share, steps):
    """A jet of 30 m/s at the vehicle, in a wind of a share of it at both ends of the window."""
    jet = np.interp([0.0, 57.0, 66.0, 75.0, 120.0], FLIGHT.times, FLIGHT.height)
    height = np.append(jet[:-1], 60e3)
    east = 30.0 * np.array([share, share, 1.0, share, share])
    assert np.any(sounding(20.0, height, east).steps(VEHICLE, "pitch")) == steps


def test_a_window_beyond_the_ends_of_a_sounding_makes_no_steps():
    assert not np.any(sounding(1e3).steps(VEHICLE, "pitch"))


def crossing():
    """A jet at the time of the vehicle, and a wind from ahead above, 10 s later on the flight."""
    height = np.interp([0.0, 50.0, 66.0, 76.0, 90.0], FLIGHT.times, FLIGHT.height)
    return sounding(40.0, height, [0.0, 0.0, 30.0, 0.0, -20.0])


def test_a_sounding_has_both_signs_and_a_part_of_one_sign_for_boundaries():
    wind = crossing()
    whole, part = (f(VEHICLE, "pitch") for f in (wind.history, wind.of_one_sign))
    times = np.linspace(0.0, 40.0, 401)
    assert whole(times).min() < -0.2 * whole.peak
    assert part(times) == pytest.approx(np.maximum(whole(times), 0.0), abs=1e-3 * whole.peak)
    assert wind.zero(VEHICLE, "pitch") == pytest.approx(50.0)  # where the sounding begins


def test_a_step_where_the_flight_begins_within_the_window_is_noted():
    """Of a wind from behind at 30 m/s, by eq (B1e) at the begin of the flight."""
    begin, _ = FLIGHT.span
    step = np.degrees(np.arcsin(30.0 / FLIGHT.speed[0] * np.sin(FLIGHT.flight_path_angle[0])))
    noted = f"west: the flight begins at {begin:.6g} s, with a step of {step:.3g} deg"
    assert noted in " ".join(sounding(1e3).notes(VEHICLE, "pitch"))
