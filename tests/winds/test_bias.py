"""A mean wind taken out of another: what a biased flight path leaves to the nozzle."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.archives import Balloon, jet, write
from tvclin.cli.app import app

SOUNDINGS = Path(__file__).parents[1] / "soundings"
LOW = tv.winds.WindProfile(height=[0.0, 1000.0, 9000.0], east=[2.0, 4.0, 20.0], north=[0, 1, 5])
HIGH = tv.winds.WindProfile(height=[500.0, 3000.0, 12000.0], east=[1.0, 6.0, 9.0], north=[2, 3, 4])


def test_what_is_left_is_the_difference_at_every_height_that_both_know():
    left = LOW - HIGH
    assert (left.height[0], left.height[-1]) == (500.0, 9000.0)
    heights = np.linspace(500.0, 9000.0, 301)
    for got, a, b in zip(left.at(heights), LOW.at(heights), HIGH.at(heights), strict=True):
        assert got == pytest.approx(a - b, abs=1e-12)


def test_the_wind_that_is_met_is_the_difference_of_those_that_are_met():
    """Eq (B1e) is linear in the wind speed; between fewer levels an angle is straight."""
    flight = SimpleNamespace(
        time=np.linspace(0.0, 40.0, 9),
        height=np.linspace(100.0, 8900.0, 9),
        speed=np.linspace(50.0, 600.0, 9),
        flight_path_angle=np.linspace(1.5, 1.0, 9),
    )
    times = np.linspace(0.0, 40.0, 81)
    both = [one.to_wind(flight, azimuth=1.0)(times) for one in (LOW, HIGH)]
    left = (LOW - HIGH).to_wind(flight, azimuth=1.0)
    inside = left(times) != 0.0
    assert np.count_nonzero(inside) > 5
    knots = np.intersect1d(np.intersect1d(left.time, times), times[inside])
    there = np.isin(times, knots)
    assert knots.size > 5
    assert left(times)[there] == pytest.approx((both[0] - both[1])[there], rel=2e-3)


def test_profiles_without_a_common_height_are_refused():
    with pytest.raises(tv.InputError, match="no height is in both"):
        LOW.between(0.0, 400.0) - HIGH
    with pytest.raises(TypeError):
        LOW - 1.0


def test_the_mean_of_an_archive_is_that_of_its_profiles(tmp_path):
    balloons = [Balloon(f"2023-02-{day:02d}T00", jet(6.0 * day)) for day in range(1, 5)]
    archive = tv.read_soundings(write(tmp_path / "s-data.txt", balloons))
    mean = archive.mean()
    expected = np.mean([one.at(mean.height) for one in archive], axis=0)
    assert np.array([mean.east, mean.north]) == pytest.approx(expected, abs=1e-9)
    assert mean.source == "the mean of 4 soundings"
    with pytest.raises(tv.InputError, match="got 0 that can be used"):
        archive[:0].mean()


def boundary_command(*options):
    words = ("boundary", "configuration-i", "--winds", SOUNDINGS / "wyoming.txt", *options)
    return CliRunner().invoke(app, [*map(str, words), "--azimuth-deg", "90", "--json"])


def bias(file, month=None):
    """Return the options of a mean wind, and of its month."""
    given = [f"sounding.bias={file}", *([] if month is None else [f"sounding.bias_month={month}"])]
    return [word for key in given for word in ("--set", key)]


@pytest.mark.thorough
def test_a_biased_path_leaves_less_to_the_nozzle(tmp_path):
    plain = json.loads(boundary_command().stdout)
    biased = json.loads(boundary_command(*bias(SOUNDINGS / "table.csv")).stdout)
    assert plain["wind"]["peak_deg"] != biased["wind"]["peak_deg"]
    station = write(tmp_path / "s-data.txt", [Balloon("2023-02-01T00", jet(6.0))])
    month = boundary_command(*bias(station, 2))
    assert month.exit_code == 0
    for options, words in (
        (bias(SOUNDINGS / "wyoming.txt"), "zero"),
        (bias(station, 3), "got 0"),
        (bias(SOUNDINGS / "table.csv", 2), "station"),
        (("--set", "sounding.bias_month=2"), "needs bias"),
    ):
        refused = boundary_command(*options)
        assert refused.exit_code == 2, options
        assert words in " ".join(refused.output.split())


def test_the_dynamic_pressure_is_that_of_all_that_blows():
    """Against the air speed itself: the flight less the whole wind, as vectors."""
    flight = tv.load_schedule("configuration-i")
    height = np.linspace(0.0, 40e3, 9)
    mean = tv.WindProfile(height=height, east=-40.0 + 0.0 * height, north=0.0 * height)
    whole = tv.WindProfile(
        height=height, east=np.linspace(-50.0, -45.0, 9), north=5.0 + 0.0 * height
    )
    encountered = tv.fly_through(whole, flight, azimuth=np.radians(90.0), bias=mean)
    left = tv.fly_through(whole - mean, flight, azimuth=np.radians(90.0))
    assert encountered.wind.angle == pytest.approx(left.wind.angle, abs=1e-15)
    time = encountered.wind.time
    speed, climb = (
        np.interp(time, flight.time, one) for one in (flight.speed, flight.flight_path_angle)
    )
    east = np.interp(np.interp(time, flight.time, flight.height), height, whole.east)
    air = np.array([speed * np.cos(climb) - east, 0.0 * time - 5.0, speed * np.sin(climb)])
    assert encountered.speeds.pressure == pytest.approx((air**2).sum(axis=0) / speed**2, rel=1e-12)
    computed = [tv.size(flight, one, times=[66.0]).required for one in (encountered, left)]
    frozen, varying = (
        [float(one[name].max()) for one in computed] for name in ("K = 1", "K = 1, varying")
    )
    assert frozen[0] == pytest.approx(frozen[1], rel=1e-9)  # of calm air
    # the same wind turns the faster air less: the normal force stays, only the stiffness is larger
    assert varying[1] < varying[0] < 1.01 * varying[1]
