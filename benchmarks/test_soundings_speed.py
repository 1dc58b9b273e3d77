"""A sounding of ten thousand levels, from its file to the wind angle over time."""

import numpy as np
from peers import ratio

import tvclin as tv

LEVELS = 10_000
HEADER = (
    "time,longitude,latitude,pressure_hPa,geopotential height_m,temperature_C,"
    "wind direction_degree,wind speed_m/s"
)


def sounding(path):
    """Write a table as the University of Wyoming does, a level each second or so."""
    height = np.linspace(5.0, 30e3, LEVELS)
    direction, speed = 250.0 + 30.0 * np.sin(height / 3e3), 10.0 + height / 600.0
    rows = [
        f"2024-02-15 11:02:03,-80.57,28.47,500.0,{z:.1f},-10.0,{d:.0f},{w:.1f}"
        for z, d, w in zip(height, direction, speed, strict=True)
    ]
    path.write_text("\n".join([HEADER, *rows]))
    return path


def test_file_to_profile_10000_levels(benchmark, tmp_path):
    path = sounding(tmp_path / "sounding.csv")
    ratio(
        benchmark,
        lambda: tv.read_sounding(path),
        lambda: np.genfromtxt(path, delimiter=",", skip_header=1, usecols=(4, 6, 7)),
        peer_name="numpy.genfromtxt, without checks",
        floor="a Python number for each cell",
    )


def test_profile_to_wind_10000_levels(benchmark, tmp_path):
    profile = tv.read_sounding(sounding(tmp_path / "sounding.csv"))
    vehicle = tv.load_vehicle("configuration-i")
    climb = tv.winds.steady_climb(vehicle, height=11950.0, start=35.0, stop=113.0)
    rate = np.diff(climb.height) / np.diff(climb.time)

    def by_interpolation():
        met = climb.time[0] + (profile.height - climb.height[0]) / rate
        wind = np.interp(
            climb.height[0] + rate * (met - climb.time[0]), profile.height, profile.east
        )
        return np.arcsin(wind * np.sin(vehicle.attitude) / vehicle.velocity)

    ratio(
        benchmark,
        lambda: profile.to_wind(climb, azimuth=np.pi / 2),
        by_interpolation,
        peer_name="numpy.interp, unsorted and unchecked",
        floor="levels and times of the flight are sorted into one row",
    )
