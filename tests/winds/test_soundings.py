"""Winds over height: signs, the flight through them, gusts and shear."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq

import tvclin as tv
from tvclin.ascent.nominal_flight import load_flight_condition, nominal_flight
from tvclin.winds.soundings.levels import wind_components

GOLDEN = Path(__file__).parents[1] / "soundings"
EAST = np.pi / 2
NAMES = ["configuration-i", "configuration-ii"]


def jet(peak=69.4, azimuth=EAST):
    """Return a triangle about 11.95 km, 10 km thick, that blows towards an azimuth."""
    speed = peak * np.array([0.0, 0.0, 1.0, 0.0, 0.0])
    return tv.WindProfile(
        height=[0.0, 6950.0, 11950.0, 16950.0, 25000.0],
        east=speed * np.sin(azimuth),
        north=speed * np.cos(azimuth),
    )


def climb(name, start=-20.0, stop=20.0):
    vehicle = tv.load_vehicle(name)
    time = vehicle.time
    return tv.winds.steady_climb(vehicle, height=11950.0, start=time + start, stop=time + stop)


# --- signs ---------------------------------------------------------------------------------------


@given(direction=st.floats(0.0, 2 * np.pi), speed=st.floats(0.1, 100.0), flown=st.floats(-6.0, 6.0))
def test_a_flight_into_the_direction_a_wind_comes_from_has_a_head_wind(direction, speed, flown):
    east, north = wind_components(np.full(2, speed), np.full(2, direction))
    profile = tv.WindProfile(height=[0.0, 1.0], east=east, north=north)
    np.testing.assert_allclose(profile.in_plane(direction), -speed, rtol=1e-14)
    np.testing.assert_allclose(profile.cross_plane(direction), 0.0, atol=1e-13)
    np.testing.assert_allclose(profile.cross_plane(direction - np.pi / 2), speed, rtol=1e-14)
    np.testing.assert_allclose(
        np.hypot(profile.in_plane(flown), profile.cross_plane(flown)), profile.speed, rtol=1e-13
    )


def test_degrees_in_the_place_of_radians_are_no_direction():
    profile = tv.WindProfile(height=[0.0, 1.0], east=[1.0, 1.0], north=[0.0, 0.0])
    with pytest.raises(tv.InputError, match="azimuth must be between -6.28"):
        profile.in_plane(60)


def test_the_four_winds_on_a_flight_to_the_east():
    speed, direction = np.full(4, 10.0), np.radians([0.0, 90.0, 180.0, 270.0])
    east, north = wind_components(speed, direction)
    profile = tv.WindProfile(height=[0.0, 1.0, 2.0, 3.0], east=east, north=north)
    np.testing.assert_allclose(profile.in_plane(EAST), [0.0, -10.0, 0.0, 10.0], atol=1e-14)
    np.testing.assert_allclose(profile.cross_plane(EAST), [-10.0, 0.0, 10.0, 0.0], atol=1e-14)


# --- from height to time -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "angle_deg", "trim_deg", "tau_beta"),
    [(NAMES[0], 5.2, 0.559, 14.0), (NAMES[1], 3.95, 0.381, 10.6)],
)
def test_the_95_percent_wind_of_the_worst_month_at_the_cape(name, angle_deg, trim_deg, tau_beta):
    """Eq (B1e) and Table I, by hand: V sin(gamma) = 379.9 and 374.1 m/s."""
    cape = tv.winds.read_range_reference(GOLDEN / "T1cap19.txt")
    height, speed = tv.winds.worst_month(cape, 95.0)
    peak = float(speed[height == 12000.0][0])
    assert peak == pytest.approx(69.4, abs=0.05)
    wind = jet(peak).to_wind(climb(name), azimuth=EAST)
    vehicle = tv.load_vehicle(name)
    rate = vehicle.velocity * np.sin(vehicle.attitude)
    assert wind.peak == pytest.approx(np.arcsin(peak * rate / vehicle.velocity**2), rel=1e-12)
    assert np.degrees(wind.peak) == pytest.approx(angle_deg, abs=0.02)
    c = tv.Coefficients.from_vehicle(vehicle)
    assert np.degrees(c.B * wind.peak) == pytest.approx(trim_deg, abs=6e-4)
    assert wind.end - wind.onset == pytest.approx(10e3 / rate, rel=1e-12)
    assert (wind.end - wind.onset) * c.beta == pytest.approx(tau_beta, abs=0.1)


def test_knots_stand_where_the_flight_meets_the_levels():
    flight = climb(NAMES[0])
    profile = jet()
    wind = profile.to_wind(flight, azimuth=EAST)
    rate = np.diff(flight.height)[0] / np.diff(flight.time)[0]
    crossing_times = flight.time[0] + (profile.height[1:4] - flight.height[0]) / rate
    np.testing.assert_allclose(wind.time[1:-1], crossing_times, rtol=1e-14)
    assert (wind.time[0], wind.time[-1]) == (flight.time[0], flight.time[-1])


def test_levels_that_a_flight_meets_at_one_time_are_one_knot():
    close = np.array([11950.0, 11950.0, 11950.0, 11950.0])
    for i in (1, 2, 3):
        close[i] = np.nextafter(close[i - 1], np.inf)
    height = [0.0, *close, 20e3]
    profile = tv.WindProfile(height=height, east=[1.0, 9.0, 9.0, 9.0, 9.0, 1.0], north=np.zeros(6))
    wind = profile.to_wind(climb(NAMES[0]), azimuth=EAST)
    assert np.all(np.diff(wind.time) > 0.0)


def test_along_a_nominal_flight_the_wind_is_that_of_its_height_speed_and_path():
    vehicle, condition = tv.load_vehicle(NAMES[0]), load_flight_condition(NAMES[0])
    flight = nominal_flight(vehicle, condition, start=52.0, stop=80.0)
    profile = jet(40.0)
    wind = profile.to_wind(flight, azimuth=EAST)
    for level in profile.height[1:4]:
        passed = brentq(lambda t, level=level: flight.states(t)[2] - level, 52.0, 80.0)
        assert np.abs(wind.time - passed).min() < 1e-4
    speed, path, height = flight.states(wind.time[1:-1])
    expected = np.arcsin(np.interp(height, profile.height, profile.east) * np.sin(path) / speed)
    np.testing.assert_allclose(wind.angle[1:-1], expected, atol=1e-6)


def test_a_cross_wind_meets_the_vehicle_at_right_angles():
    flight = climb(NAMES[1])
    wind = jet(30.0, azimuth=0.0).to_wind(flight, azimuth=EAST, plane="yaw")
    assert wind.peak == pytest.approx(np.arcsin(30.0 / flight.speed[0]), rel=1e-14)
    with pytest.raises(tv.InputError, match="zero throughout"):
        jet(30.0).between(0.0, 6000.0).to_wind(climb(NAMES[1], -32.0), azimuth=EAST)


def test_gaps_in_which_the_wind_is_not_known_are_noted():
    flight = tv.winds.Climb(
        time=[0.0, 60.0], height=[0.0, 9e3], speed=[300.0] * 2, flight_path_angle=[1.0] * 2
    )
    height = np.array([0.0, 2000.0, 4500.0, 8000.0, 9500.0, 12000.0])
    profile = tv.WindProfile(height=height, east=0.0 * height, north=0.0 * height, notes=["one"])
    assert profile.notes_along(flight) == [
        "one",
        "no level from 4.5 to 8 km and in 1 other gap: in gaps of more than 2 km the wind is not"
        " known, and straight lines are shown",
    ]
    assert tv.WindProfile(height=height[:2], east=[0, 0], north=[0, 0]).notes_along(flight) == []


def test_the_wind_is_met_only_where_flight_and_profile_have_a_height_in_common():
    flight = climb(NAMES[0])
    low = jet().between(9000.0, 14000.0).to_wind(flight, azimuth=EAST)
    whole = jet().to_wind(flight, azimuth=EAST)
    rate = np.diff(flight.height)[0] / np.diff(flight.time)[0]
    ends = 66.0 + (np.array([9000.0, 14000.0]) - 11950.0) / rate
    np.testing.assert_allclose([low.onset, low.end], ends, rtol=1e-13)
    np.testing.assert_allclose(low.time[1:-1], [66.0], rtol=1e-15)
    assert low(66.0) == whole(66.0)
    cut = 69.4 * np.array([2050.0, 2950.0]) / 5000.0
    expected = tv.angle_from_speed(cut, flight.speed, flight.flight_path_angle)
    np.testing.assert_allclose(low.angle[[0, -1]], expected, rtol=1e-12)
    with pytest.raises(tv.InputError, match="does not reach the wind: it goes from 4352.72 to"):
        jet().between(21000.0, 24000.0).to_wind(flight, azimuth=EAST)


def test_from_a_file_to_a_boundary_and_what_the_triangle_costs():
    wind = tv.read_sounding(GOLDEN / "wyoming.txt").to_wind(climb(NAMES[0]), azimuth=EAST)
    plant = tv.Plant.from_vehicle(tv.load_vehicle(NAMES[0]), "fixed-path")
    boundary, triangle = tv.boundary_limit(plant, wind), tv.winds.equivalent_triangle(wind)
    assert triangle.laplace(0.0) == pytest.approx(wind.laplace(0.0), rel=1e-12)
    cost = tv.boundary_limit(plant, triangle).deflection / boundary.deflection - 1.0
    assert tv.boundary.triangle_error(plant, wind) == pytest.approx(cost, rel=1e-9)


def test_a_triangle_of_five_thousand_samples_has_the_boundary_of_the_triangle():
    plant = tv.Plant.from_vehicle(tv.load_vehicle(NAMES[0]), "fixed-path")
    triangle = tv.TriangularWind(peak=0.09, duration=20.0)
    time = np.linspace(0.0, 20.0, 5001)
    fine = tv.SampledWind(time=time, angle=triangle(time))
    limits = [tv.boundary_limit(plant, wind, dead_band=0.5).limit for wind in (triangle, fine)]
    assert limits[1] == pytest.approx(limits[0], rel=1e-12)


GOOD = {
    "time": [0.0, 10.0],
    "height": [0.0, 12e3],
    "speed": [1700.0, 1700.0],
    "flight_path_angle": [0.8, 0.8],
}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"height": [5e3, 0.0]}, "height of a flight must ascend; it does not at index 0"),
        ({"time": [0.0, 0.0]}, "time of a flight must ascend"),
        ({"speed": [500.0]}, "arrays of one length, two or more; got"),
        ({"speed": [0.0, 500.0]}, "speed must be positive"),
        ({"speed": [9.0, 40.0]}, r"first at 11950 m; .* profile.between\(12000, "),
        ({"time": [0.0, 1e300]}, "time must be between"),
        ({"height": ["a", "b"]}, "height must be a number"),
    ],
)
def test_what_is_no_flight_is_refused(changes, said):
    with pytest.raises(tv.InputError, match=said):
        jet().to_wind(SimpleNamespace(**{**GOOD, **changes}), azimuth=EAST)


def test_other_bad_input_to_profiles_and_climbs_is_refused():
    vehicle, flight = tv.load_vehicle(NAMES[0]), climb(NAMES[0])
    for call, said in (
        (lambda: jet().to_wind(3, azimuth=0.0), "flight must have arrays time, .* got int"),
        (
            lambda: jet().to_wind(flight, azimuth=0.0, plane="roll"),
            "plane must be one of pitch, yaw",
        ),
        (
            lambda: tv.fly_through(jet(), flight, azimuth=0.0, gust=3.0),
            "gust must be a History",
        ),
        (lambda: jet().at(26e3), "height must be between 0 and 25000 m"),
        (lambda: jet().between(5e3, 5e3), "low must be below high"),
        (lambda: jet().smoothed(0.0), "thickness must be between 0.001"),
        (lambda: tv.WindProfile(height=[0, 0], east=[1, 1], north=[0, 0]), "must ascend; got 0 m"),
        (lambda: tv.WindProfile(height=[0], east=[1], north=[0]), "two or more levels"),
        (lambda: tv.WindProfile(height=[0, 1], east=[1, np.nan], north=[0, 0]), "east must be fin"),
        (lambda: tv.WindProfile(height=[0, 1], east=[1, 2e3], north=[0, 0]), "east must be betw"),
        (
            lambda: tv.winds.steady_climb(vehicle, height=0, start=2, stop=1),
            "stop must be after start",
        ),
        (
            lambda: tv.winds.steady_climb(vehicle.replace(attitude=0.0), height=0, start=0, stop=1),
            "vehicle must climb",
        ),
        (
            lambda: tv.winds.steady_climb(
                vehicle.replace(velocity=[5e2, 6e2]), height=0, start=0, stop=1
            ),
            "vehicle must be one vehicle; got a batch",
        ),
    ):
        with pytest.raises(tv.InputError, match=said):
            call()


def test_smoothing_is_the_running_mean_of_the_straight_lines():
    profile = jet()
    smooth = profile.smoothed(6000.0)
    for level, computed in zip(profile.height, smooth.east, strict=True):
        low, high = max(level - 3000.0, 0.0), min(level + 3000.0, 25000.0)
        kinks = [z for z in profile.height if low < z < high]
        mean = quad(np.interp, low, high, (profile.height, profile.east), points=kinks)[0]
        assert computed == pytest.approx(mean / (high - low), rel=1e-9, abs=1e-9)
    assert smooth.notes == ("running mean over 6000 m",)


# --- gusts and shear -----------------------------------------------------------------------------


def test_a_gust_on_a_calm_profile_is_a_layered_gust_in_time():
    calm = tv.WindProfile(height=[5e3, 20e3], east=[0.0, 0.0], north=[0.0, 0.0])
    gusty = tv.winds.add_gust(
        calm, base=12e3, amplitude=9.0, blend=300.0, thickness=2000.0, azimuth=EAST
    )
    flight = climb(NAMES[0])
    rate = np.diff(flight.height)[0] / np.diff(flight.time)[0]
    peak = tv.angle_from_speed(9.0, flight.speed[0], flight.flight_path_angle[0])
    whole = tv.winds.LayeredGust(peak=peak, blend=300.0 / rate, plateau=2000.0 / rate)
    shifted = whole.shift(66.0 + 50.0 / rate)
    times = np.linspace(65.0, 75.0, 1001)
    wind = gusty.to_wind(flight, azimuth=EAST)
    np.testing.assert_allclose(wind(times), shifted(times), atol=7e-4 * peak)
    assert gusty.notes == ("gust of 9 m/s added from 12000 m on",)


def test_a_gust_leaves_the_wind_outside_it_as_it_was_and_must_fit():
    sizes = {"amplitude": 5.0, "blend": 100.0, "thickness": 200.0, "azimuth": 0.3}
    gusty = tv.winds.add_gust(jet(), base=10e3, **sizes)
    east, north = gusty.at([9999.0, 10250.0, 10401.0])
    before_east, before_north = jet().at([9999.0, 10250.0, 10401.0])
    gust = np.array([0.0, 5.0, 0.0])
    np.testing.assert_allclose(east - before_east, gust * np.sin(0.3), atol=1e-12)
    np.testing.assert_allclose(north - before_north, gust * np.cos(0.3), atol=1e-12)
    for wrong, said in (
        ({"base": 24.7e3}, "the gust from 24700 to 25100 m must lie within the profile"),
        ({"base": 10e3, "blend": 0.0}, "blend must be between 0.001"),
    ):
        with pytest.raises(tv.InputError, match=said):
            tv.winds.add_gust(jet(), **{**sizes, **wrong})


def test_shear_goes_with_the_seven_tenths_power_of_the_layer():
    assert tv.winds.power_law_shear(20.0, 1000.0) == 20.0
    halves = tv.winds.power_law_shear([[10.0], [20.0]], [200.0, 400.0])
    np.testing.assert_allclose(halves[:, 1] / halves[:, 0], 2**0.7, rtol=1e-15)
    with pytest.raises(tv.InputError, match="thickness must be at most 1000 m"):
        tv.winds.power_law_shear(20.0, 1001.0)


def test_a_synthetic_profile_touches_its_envelope_and_falls_by_the_shear():
    envelope = {"height": [0.0, 12e3, 20e3], "speed": [10.0, 70.0, 30.0]}
    shear = {"thickness": [500.0, 1000.0, 4000.0], "change": [20.0, 40.0, 80.0]}
    profile = tv.winds.synthetic_profile(**envelope, peak_height=12e3, **shear, azimuth=EAST)
    # 70 m/s are lost after 1000 m and three quarters of the next 3000 m.
    away = np.array([-3250.0, -1000.0, -500.0, 0.0, 500.0, 1000.0, 3250.0])
    np.testing.assert_allclose(profile.height, 12e3 + away, rtol=1e-15)
    np.testing.assert_allclose(profile.east, [0, 30, 50, 70, 50, 30, 0], atol=1e-12)
    lower = tv.winds.synthetic_profile(**envelope, peak_height=6e3, **shear, azimuth=EAST)
    assert lower.speed.max() == 40.0
    np.testing.assert_allclose(lower.height, [5e3, 5.5e3, 6e3, 6.5e3, 7e3])
    short = tv.winds.synthetic_profile(
        **envelope, peak_height=12e3, thickness=[500.0], change=[20.0], azimuth=0.0
    )
    np.testing.assert_allclose(short.north, [50.0, 70.0, 50.0], rtol=1e-15)
    for wrong, said in (
        ({"peak_height": 21e3}, "peak_height must be within the envelope"),
        ({"change": [20.0, 10.0, 80.0]}, "thickness and change must ascend"),
        ({"change": [20.0]}, "must be two lists of one length"),
    ):
        with pytest.raises(tv.InputError, match=said):
            tv.winds.synthetic_profile(
                **{**envelope, "peak_height": 12e3, **shear, "azimuth": EAST, **wrong}
            )
