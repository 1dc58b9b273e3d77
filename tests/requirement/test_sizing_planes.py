"""The sizing of both planes with one stop, and winds with a direction."""

import numpy as np
import pytest
from scipy.optimize import brentq

import tvclin as tv
from tests.turns import usual
from tvclin.requirement.plane_requirement import rectangle
from tvclin.winds.wind_angles import angles_from_speed, angles_from_vector_size

GUST = tv.TriangularWind(peak=0.08, duration=7.5)
TIMES = [56.0, 66.0]
NORTH = 0.0


@pytest.fixture(scope="module")
def flight() -> tv.FlightSchedule:
    return tv.load_schedule("configuration-i")


def jet(height, *, towards: float, shear: float = 0.0) -> tv.WindProfile:
    """Return a jet of 50 m/s at 12 km towards a bearing, which it leaves with height."""
    speed = 50.0 * np.exp(-(((height - 12e3) / 4e3) ** 2)) * (height > 5e3) * (height < 20e3)
    bearing = towards + shear * (height - 12e3)
    east, north = speed * np.sin(bearing), speed * np.cos(bearing)
    return tv.WindProfile(height=height, east=east, north=north)


@pytest.mark.thorough
@pytest.mark.parametrize("degrees", usual([0, 30, 45, 90, 200], 1))
def test_of_equal_planes_a_round_stop_takes_the_norm_of_the_scalar_answer(flight, degrees) -> None:
    straight = tv.size(flight, GUST, times=TIMES, model="fixed-path")
    slanting = tv.winds.PlaneWind.towards(GUST, np.radians(degrees))
    sizing = tv.size(flight, slanting, times=TIMES, model="fixed-path", plane="both")
    for name, values in straight.required.items():
        assert sizing.required[name] == pytest.approx(values, rel=1e-14), name
    misses = sizing.pitch_omitted_fraction["K = 1"]
    assert misses == pytest.approx(1.0 - abs(np.cos(np.radians(degrees))), abs=1e-14)


@pytest.mark.thorough
@pytest.mark.parametrize("model", ["fixed-path", "drift-exact"])
@pytest.mark.parametrize("varying", usual([False, True], 0))
def test_a_wind_along_one_plane_asks_for_the_same_to_the_last_bit(flight, model, varying) -> None:
    options = {"times": [66.0], "model": model, "varying": varying}
    for stop in ("round", "square"):
        for plane, angle in (("pitch", 0.0), ("yaw", np.pi / 2)):
            single = tv.size(flight, GUST, plane=plane, **options)
            wind = tv.winds.PlaneWind.towards(GUST, angle)
            sizing = tv.size(flight, wind, plane="both", limit_shape=stop, **options)
            for name, values in single.required.items():
                assert sizing.required[name].tolist() == values.tolist(), (stop, plane, name)


@pytest.mark.thorough
def test_a_sounding_along_the_flight_asks_for_the_same_to_the_last_bit(flight) -> None:
    """Though neither sine nor cosine of its azimuth is exactly zero."""
    height = np.linspace(0.0, 30e3, 31)
    profile = jet(height, towards=np.radians(90))
    options = {"times": [66.0], "dead_bands": (1.0, 0.5)}
    gust = tv.OneMinusCosineGust(peak=0.01, duration=2.0)
    for given in ({}, {"window": 15.0, "gust": gust}):
        encountered = [
            tv.fly_through(profile, flight, azimuth=np.radians(90), plane=plane, **given)
            for plane in ("pitch", "both")
        ]
        pitch = tv.size(flight, encountered[0], **options)
        both = tv.size(flight, encountered[1], plane="both", **options)
        for name, values in pitch.required.items():
            np.testing.assert_array_equal(both.required[name], values, name)


@pytest.mark.thorough
def test_a_sounding_is_never_sized_for_less_than_any_one_direction_of_it(flight) -> None:
    """Whatever the azimuth, both planes ask for more than each, and for no more than the sum."""
    height = np.linspace(0.0, 30e3, 31)
    profile = jet(height, towards=np.radians(70), shear=np.radians(90) / 8e3)
    for azimuth in (0, 160):
        encountered = tv.fly_through(profile, flight, azimuth=np.radians(azimuth), plane="both")
        for stop, norm in (("round", np.hypot), ("square", np.maximum)):
            sizing = tv.size(
                flight,
                encountered,
                times=[66.0],
                plane="both",
                limit_shape=stop,
                dead_bands=(1.0, 0.5),
            )
            pitch, yaw = (sizing.separate[plane].required for plane in ("pitch", "yaw"))
            for name, values in sizing.required.items():
                if np.isnan(values).all():
                    assert name == "minimum, varying"  # beyond one pole in a plane
                    continue
                assert np.all(values >= np.maximum(pitch[name], yaw[name]) * (1 - 1e-12)), name
                assert np.all(values <= pitch[name] + yaw[name]), name
            for name in ("K = 1", "K = 0.5"):
                assert np.all(sizing.required[name] >= norm(pitch[name], yaw[name]) * (1 - 1e-12))


@pytest.mark.thorough
def test_the_rectangle_is_the_least_that_holds_its_corners() -> None:
    """By bisection on whether each corner is inside the grown shape."""
    cross = tv.boundary.Cluster([tv.boundary.ClusterEngine(at=1, state="centred")] + [
        tv.boundary.ClusterEngine(at=at) for at in (1j, -1, -1j)
    ])  # fmt: skip
    for stop in (tv.boundary.EllipticShape(1.0, 0.6), tv.boundary.SquareShape(0.3), cross):
        corners = np.array([0.3 + 0.2j, 0.3 - 0.2j, -0.3 + 0.2j, -0.3 - 0.2j])
        around = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 7201))

        def outside(limit: float, stop=stop, around=around, corners=corners) -> float:
            reached = np.real(np.conj(around)[:, np.newaxis] * corners)
            return float((reached - limit * stop.support(around)[:, np.newaxis]).max())

        minimum = brentq(outside, 1e-3, 10.0, xtol=1e-10)
        missed = 0.5 * abs(corners[0]) * (around[1] - around[0]).imag  # beside the best direction
        assert -1e-9 < rectangle(stop, 0.3, 0.2) - minimum < missed


@pytest.mark.parametrize("heading", np.radians([1.0, 40.0, 130.0, 200.0, 310.0]))
def test_the_angles_of_a_vector_are_those_of_one_horizontal_wind(heading) -> None:
    attitude, velocity = np.radians(45.0), 600.0
    for speed in (5.0, 50.0, 300.0):
        angles = angles_from_speed(speed, velocity, attitude, heading)
        along = tv.angle_from_speed(-speed * np.cos(heading), velocity, attitude)
        across = tv.angle_from_speed(speed * np.sin(heading), velocity, np.pi / 2)
        assert angles == pytest.approx((along, across), rel=1e-12)
        assert angles_from_vector_size(np.hypot(*angles), heading, attitude) == pytest.approx(
            angles, rel=1e-9
        )


def test_headings_have_the_signs_of_soundings(flight) -> None:
    """A wind from the west on a flight to the north-east: tail wind, and from the left."""
    height = np.linspace(0.0, 30e3, 31)
    profile, azimuth = jet(height, towards=np.radians(90)), np.radians(45)
    encountered = profile.to_winds(flight, azimuth=azimuth)
    pitch, yaw = angles_from_speed(50.0, 600.0, 0.8, np.radians(270) - azimuth)
    assert (
        np.sign([pitch, yaw]).tolist()
        == np.sign([encountered.pitch.peak, encountered.yaw.peak]).tolist()
    )
    assert pitch > 0.0 > yaw


def test_a_wind_without_a_direction_has_no_answer_in_two_planes(flight) -> None:
    with pytest.raises(tv.InputError, match="both planes each wind must have a direction"):
        tv.size(flight, GUST, times=TIMES, plane="both")
    with pytest.raises(tv.InputError, match="a PlaneWind needs plane='both'"):
        tv.size(flight, tv.winds.PlaneWind.towards(GUST, 0.3), times=TIMES)
    with pytest.raises(tv.InputError, match="limit_shape must be one of round"):
        tv.size(flight, GUST, times=TIMES, plane="both", limit_shape="oval")
    shaped = tv.ShapedWind("triangular", 0.08, 7.5)
    with pytest.raises(tv.InputError, match="both planes need a wind with a direction"):
        shaped.peaks(0.8)
    with pytest.raises(tv.InputError, match="has no part in pitch"):
        tv.ShapedWind("triangular", 0.08, 7.5, heading=np.pi / 2).in_plane("pitch", 0.8)
