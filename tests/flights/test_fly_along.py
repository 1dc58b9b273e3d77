"""Flights along a varying vehicle: against an integration, and frozen against those of one time."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tvclin as tv
from tests.turns import usual
from tests.whole_flight import TIMES, Filter, StructureSchedule, autopilot, flight
from tvclin import InputError
from tvclin.ascent.wind_along import wind_along
from tvclin.control.autopilot.actuator import plant_with_actuator
from tvclin.control.autopilot.wiring import closed_loop
from tvclin.flights import fly_along, fly_many_along
from tvclin.flights.closed_loop.flown_flights import checked_flight, sampled_stages

GUST = tv.TriangularWind(peak=np.radians(4.0), duration=6.0).shift(52.0)


def plant_at(made, time):
    vehicle = made.at(time)
    return tv.FlexiblePlant.from_vehicle(vehicle.rigid, vehicle.structure)


def test_the_flight_of_a_made_up_schedule_is_that_of_another_integration() -> None:
    """Numbers of `solve_ivp` with its own plants, relative to the largest: 1e-5."""
    gains = tv.Autopilot(
        attitude_gain=[0.28856656, 0.24001325, 0.14874845, 0.0876385, 0.06166739],
        rate_gain=[0.56401101, 0.51437777, 0.40494013, 0.31082221, 0.26073082],
        actuator=tv.Actuator(natural_frequency=25.0, damping=0.7),
    )
    schedule = tv.control.GainSchedule([41.0, 60.0, 80.0, 100.0, 116.0], gains)
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=20.0).shift(56.0)
    flown = fly_along(
        tv.load_schedule("configuration-i"), schedule, wind, sign="frozen", start=56.0
    )
    largest = {
        "attitude": (-3.26972, 68.47),
        "flight_path_angle": (-1.57646, 75.30),
        "deflection": (-0.776972, 66.53),
        "deflection_rate": (0.106538, 70.54),
        "angle_of_attack": (-7.04744, 66.0),
    }
    for name, (value, time) in largest.items():
        got = flown.largest(name)
        # the numbers have six digits, and the largest is at a step of 0.02 s
        assert np.degrees(got.value) == pytest.approx(value, rel=1e-5)
        assert got.time == pytest.approx(time, abs=0.02)
    at_90 = {
        "attitude": 1.00158,
        "attitude_rate": -0.0342570,
        "flight_path_angle": -0.846363,
        "deflection": 0.1065793,
    }
    k = int(np.argmin(np.abs(flown.times - 90.0)))
    for name, value in at_90.items():
        assert np.degrees(flown.outputs[name][k]) == pytest.approx(value, rel=1e-5)
    assert flown.status == "not judged"


@pytest.mark.thorough
def test_bending_and_slosh_over_the_flight_are_those_of_an_integration() -> None:
    made, laws = flight(), autopilot(filters=(Filter.low_pass(40.0, 0.7),), delay=0.0)
    flown = fly_along(made, laws, GUST, sign="frozen", start=50.0, stop=60.0)

    def slope(t, x):
        loop = closed_loop(laws.along(made, float(t)), plant_at(made, float(t)))
        return loop.A @ x + loop.B[:, 0] * float(GUST(t))

    x, order = None, len(closed_loop(laws.along(made, 50.0), plant_at(made, 50.0)).states)
    x = np.zeros(order)
    for begin, end in ((52.0, 55.0), (55.0, 58.0)):
        x = solve_ivp(slope, (begin, end), x, method="DOP853", rtol=1e-9, atol=1e-13).y[:, -1]
        k = int(np.argmin(np.abs(flown.times - end)))
        for name, state in (("attitude", 0), ("first", 3), ("second", 5), ("lox", 7)):
            size = abs(flown.largest(name).value)
            assert flown.outputs[name][k] == pytest.approx(x[state], abs=1e-5 * size)


@pytest.mark.thorough
def test_samples_of_a_varying_vehicle_are_those_of_an_integration() -> None:
    """Bending, a delay of half a sample and a filter, with the law of each sample held."""
    made, laws = flight(), autopilot(sample_rate=50.0)
    flown = fly_along(
        made,
        laws,
        GUST,
        deflection_limit=0.2,
        sign="frozen",
        start=52.0,
        stop=54.0,
        alpha_moment=1e6,
    )
    h, delay, x, command = 0.02, 0.01, np.zeros(len(plant_at(made, 52.0).states) + 2), 0.0

    def slope(t, x, c):
        moving = plant_with_actuator(plant_at(made, float(t)), tv.Actuator())
        return moving.A @ x + moving.B[:, 0] * c + moving.B[:, 2] * float(GUST(t))

    def moved(begin, end, x, c):
        options = {"method": "DOP853", "rtol": 1e-9, "atol": 1e-14, "args": (c,)}
        return solve_ivp(slope, (begin, end), x, **options).y[:, -1]

    for k in range(100):
        t = 52.0 + k * h
        gains = laws.along(made, t)
        system = plant_with_actuator(plant_at(made, t), tv.Actuator())
        sensed = dict(zip(system.outputs, system.C @ x, strict=True))
        following = gains.attitude_gain * sensed["sensed_attitude"]
        following += gains.rate_gain * sensed["sensed_attitude_rate"]
        x = moved(t, t + delay, x, command)
        command = float(following)
        x = moved(t + delay, t + h, x, command)
        if k % 20 == 19:
            for name, state in (("attitude", 0), ("first", 3), ("second", 5), ("deflection", -2)):
                size = abs(flown.largest(name).value)
                assert flown.outputs[name][k + 1] == pytest.approx(x[state], abs=1e-5 * size)
    moment = 1e6 * flown.outputs["angle_of_attack"]
    np.testing.assert_allclose(flown.outputs["bending_moment"], moment, rtol=1e-14)


def with_air(made, ratio) -> tv.FlightSchedule:
    """Return a flight whose vehicle has so many times its forces of the air."""
    v = made.vehicle
    forces = {
        "normal_force_slope": v.normal_force_slope * ratio,
        "axial_force": v.axial_force * ratio,
    }
    return replace(made, vehicle=v.replace(**forces))


def integrated(made, laws, alpha, ratio, end) -> float:
    """Return the attitude [rad] of a continuous loop from 52 s, in an angle and a q/q_n."""

    def slope(t, x):
        time = float(t)
        plant = with_air(made, ratio(time)).plants(time, "drift-exact", "pitch")
        loop = closed_loop(laws.along(made, time), plant)
        return loop.A @ x + loop.B[:, 0] * alpha(time)

    order = len(closed_loop(laws.along(made, 52.0), made.plants(52.0, "drift-exact", "pitch")).A)
    x = np.zeros(order)
    for piece in pairwise(sorted({52.0, min(55.0, end), end})):
        x = solve_ivp(slope, piece, x, "DOP853", rtol=1e-6, atol=1e-10).y[:, -1]
    return float(x[0])


@pytest.mark.thorough
@pytest.mark.parametrize("end", usual([54.0, 56.0], 0))
@pytest.mark.parametrize("sign", usual(["head", "tail"], 0))
def test_a_pulse_has_the_pressure_of_its_wind_triangle(sign, end) -> None:
    """q/q_n of the horizontal wind that has the angle, by the sine rule of the triangle."""
    made, laws = flight(flexible=False), autopilot(delay=0.0)
    turned = {"head": -1.0, "tail": 1.0}[sign]

    def ratio(t):
        path = np.interp(t, made.times, made.vehicle.attitude)
        return (np.sin(path) / np.sin(path + turned * float(GUST(t)))) ** 2

    expected = integrated(made, laws, lambda t: float(GUST(t)), ratio, end)
    options = {"start": 52.0, "stop": end, "alpha_moment": 1e6}
    flown = fly_along(made, laws, GUST, sign=sign, **options)
    largest = abs(flown.largest("attitude").value)
    assert flown.outputs["attitude"][-1] == pytest.approx(expected, abs=1e-5 * largest)
    q = np.array([ratio(t) for t in flown.times])
    np.testing.assert_allclose(flown.outputs["pressure_ratio"], q, rtol=1e-12)
    moment = 1e6 * q * flown.outputs["angle_of_attack"]
    np.testing.assert_allclose(flown.outputs["bending_moment"], moment, rtol=1e-12)
    reversed_gust = fly_along(made, laws, -GUST, sign=sign, **options)
    np.testing.assert_array_equal(reversed_gust.outputs["attitude"], -flown.outputs["attitude"])
    if sign == "head":  # by default
        default = fly_along(made, laws, GUST, **options)
        np.testing.assert_array_equal(default.outputs["attitude"], flown.outputs["attitude"])


@pytest.mark.thorough
@pytest.mark.parametrize("end", usual([54.0, 56.0], 0))
def test_a_sounding_has_its_speed_in_angle_and_pressure(end) -> None:
    made, laws = flight(flexible=False), autopilot(delay=0.0)
    height = np.linspace(0.0, 3e4, 1201)
    speeds = {
        "east": np.interp(height, [0, 8e3, 9e3, 3e4], [0, -40, -10, 0]),
        "north": 1e-3 * height,
    }
    profile = tv.WindProfile(height=height, **speeds)
    wind = tv.fly_through(profile, made, azimuth=np.pi / 2)

    def triangle(t):
        at, speed, path = (
            np.interp(t, made.times, x) for x in (made.altitude, made.speed, made.vehicle.attitude)
        )
        along, across = (np.interp(at, height, x) for x in speeds.values())
        x, z, y = speed * np.cos(path) - along, speed * np.sin(path), across
        return np.arctan2(z, x) - path, (x**2 + y**2 + z**2) / speed**2

    flown = fly_along(made, laws, wind, start=52.0, stop=end)
    for name, k in (("wind", 0), ("pressure_ratio", 1)):
        shown = np.array([triangle(t)[k] for t in flown.times[:-1]])
        # chords of T = 0.06 s, between which the angle bends by T^2/8 times 2e-3 rad/s^2
        largest = np.abs(shown).max()
        np.testing.assert_allclose(flown.outputs[name][:-1], shown, atol=2e-5 * largest, rtol=0.0)
    expected = integrated(
        made, laws, lambda t: float(triangle(t)[0]), lambda t: float(triangle(t)[1]), end
    )
    size = abs(flown.largest("attitude").value)
    assert flown.outputs["attitude"][-1] == pytest.approx(expected, abs=2e-5 * size)
    with pytest.raises(InputError, match="measured winds have their own sign"):
        fly_along(made, laws, wind, sign="head")
    with pytest.raises(InputError, match="gust_time must be given"):
        fly_along(made, laws, replace(wind, gust=GUST))
    gusty = fly_along(made, laws, replace(wind, gust=GUST), gust_time=54.0, start=52.0, stop=56.0)
    # eq (B1e) at the nominal speed with the gust, and the triangle of that wind
    path = np.interp(54.0, made.times, made.vehicle.attitude)
    along = np.interp(np.interp(54.0, made.times, made.altitude), height, speeds["east"])
    nominal = np.arcsin(along / (8.0 * 54.0) * np.sin(path)) - np.radians(4.0)
    w = np.sin(nominal) / np.sin(path)
    expected = np.arctan2(w * np.sin(path), 1.0 - w * np.cos(path))
    shown = np.interp(54.0, gusty.times, gusty.outputs["wind"])
    assert shown == pytest.approx(expected, rel=1e-4)


def frozen(made, time) -> tuple[tv.FlightSchedule, tv.FlexiblePlant]:
    """Return a flight that keeps the vehicle of a time, and the plant of that time."""
    vehicle, span = made.at(time), np.array([50.0, 120.0])
    bent = StructureSchedule(span, vehicle.structure, ("first", "second"), ("lox",))
    still = tv.FlightSchedule(vehicle.rigid.replace(time=span), altitude=1e4, structure=bent)
    return still, tv.FlexiblePlant.from_vehicle(vehicle.rigid, vehicle.structure)


DRIFT = {
    "drift_rate_gain": 2e-4,
    "drift_gain": 1e-5,
    "acceleration_gain": 1e-3,
    "acceleration_station": 4.0,
    "accelerometer_bandwidth": 80.0,
}


@pytest.mark.parametrize("gains", [{}, DRIFT], ids=["attitude", "drift"])
def test_a_frozen_flight_is_that_of_fly_many_to_the_last_digit(gains) -> None:
    still, plant = frozen(flight(), 60.0)
    filters = (Filter.low_pass(40.0, 0.7), Filter.notch(15.0, 0.1, 0.6))
    law = autopilot(filters=filters, sample_rate=50.0).along(flight(), 60.0)
    law = replace(law, **gains)
    wind = tv.TriangularWind(peak=np.radians([3.0, 5.0, 8.0]), duration=7.5).shift(60.003)
    limits = {"deflection_limit": np.radians([1.0, 0.5, 0.5]), "rate_limit": np.radians(3.0)}
    span = {"start": 60.003, "stop": 95.003}
    along = fly_many_along(still, law, wind, **limits, sign="frozen", **span)
    many = tv.fly_many(
        plant,
        replace(law, actuator=None, delay=0.0, sample_rate=None),
        wind,
        **limits,
        actuator=law.actuator,
        sample_rate=50.0,
        delay=law.delay,
        until=95.003,
    )
    for name in many.__dataclass_fields__:
        np.testing.assert_array_equal(getattr(along, name), getattr(many, name))
    assert len(set(many.status.tolist())) > 1


@pytest.mark.thorough
def test_a_single_flight_is_one_of_many() -> None:
    made, laws = flight(), autopilot(sample_rate=50.0)
    wind = tv.TriangularWind(peak=np.radians([2.0, 4.0]), duration=6.0).shift(52.0)
    options = {"deflection_limit": 0.05, "rate_limit": 0.3, "start": 45.0, "stop": 64.0}
    many = fly_many_along(made, laws, wind, **options)
    one = fly_along(made, laws, GUST, **options)
    assert many.peak_attitude[1] == abs(one.largest("attitude").value)
    largest = abs(one.largest("angle_of_attack").value)
    assert many.peak_angle_of_attack[1] == pytest.approx(largest, rel=1e-14)
    assert one.status == many.status[1]
    sounding = tv.fly_through(
        tv.WindProfile(height=[0.0, 8e3, 4e4], east=[0, 40, 0], north=[0, 9, 0]),
        made,
        azimuth=np.pi / 2,
    )
    both = fly_many_along(made, laws, [sounding, sounding], **options)
    single = fly_along(made, laws, sounding, **options)
    assert both.peak_attitude.tolist() == [abs(single.largest("attitude").value)] * 2
    assert one.outputs["drift"][-1] != 0.0
    lines = one.to_csv().splitlines()
    assert lines[0].startswith("time_s,wind_deg,attitude_deg,attitude_rate_rad_per_s")
    assert len(lines) == one.times.size + 1
    assert len(one.table().rows) == len(one.outputs)


def test_a_small_limit_is_lost_and_a_wind_to_the_end_is_judged_before_it() -> None:
    made, laws = flight(), autopilot(sample_rate=50.0)
    options = {"rate_limit": 0.3, "start": 45.0, "stop": 105.0}
    long = tv.SampledWind(time=[50.0, 60.0, 110.0], angle=[0.0, 0.02, 0.02])
    assert fly_along(made, laws, GUST, deflection_limit=1e-3, **options).status == "lost"
    assert fly_along(made, laws, long, deflection_limit=1e-4, **options).status != "survived"
    good = fly_along(made, laws, long, deflection_limit=0.1, **options)
    assert good.status == "survived"
    assert "unstable modes" in good.reason


@pytest.mark.thorough
def test_a_pulse_at_the_end_is_flown_on_with_the_vehicle_and_gains_of_the_end() -> None:
    """The flight is that along a schedule whose last row stays the same, to rounding."""
    made, laws = flight(flexible=False), autopilot(sample_rate=25.0)
    rows = made.at(np.append(TIMES, 110.0)).replace(time=np.append(TIMES, 400.0))
    long = tv.FlightSchedule(rows, altitude=np.append(made.altitude, made.altitude[-1]))
    gust = tv.TriangularWind(peak=np.radians(4.0), duration=8.0).shift(105.0)
    options = {"deflection_limit": 0.02, "rate_limit": 0.3, "start": 105.0}
    short = fly_along(made, laws, gust, **options)
    whole = fly_along(long, laws, gust, **options, stop=400.0)
    assert 113.0 < short.times[-1] < 400.0
    assert short.status == whole.status == "survived"
    for name, values in short.outputs.items():
        expected = whole.outputs[name][: values.size]
        np.testing.assert_allclose(values, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    assert fly_along(made, laws, gust, **options, stop=110.0).status == "undecided"
    winds = tv.TriangularWind(peak=np.radians([1.0, 4.0, 4.0]), duration=8.0).shift(105.0)
    many = fly_many_along(made, laws, winds, **(options | {"deflection_limit": [0.02, 1e-5, 0.02]}))
    assert many.status.tolist() == ["survived", "lost", "survived"]
    assert many.peak_attitude[2] == abs(short.largest("attitude").value)
    limits = (
        tv.flights.survival_limit_along(x, laws, gust, start=105.0).limit for x in (made, long)
    )
    assert next(limits) == pytest.approx(next(limits), rel=1e-6)


@pytest.mark.parametrize(
    ("laws", "options", "message"),
    [
        (autopilot(), {"deflection_limit": 0.1}, "limits need samples"),
        (autopilot(sample_rate=50.0), {}, "deflection_limit must be given"),
        (autopilot(delay=np.linspace(0.01, 0.02, 5)), {}, "delay and sample_rate must be the same"),
        (autopilot(), {"start": 20.0}, "start must be between 30 and 110"),
        (autopilot(), {"model": "drift"}, 'use "drift-exact"'),
        (autopilot(), {"sign": "up"}, "sign must be one of"),
        (autopilot(), {"gust_time": 50.0}, "add a pulse to a history"),
    ],
)
def test_flights_that_cannot_be(laws, options, message) -> None:
    with pytest.raises(InputError, match=message):
        fly_along(flight(), laws, GUST, **options)


def test_the_limit_along_a_frozen_flight_is_that_of_the_frozen_vehicle() -> None:
    """Equal within the last step of both scans, 1.98/60/16^3 of the largest trim."""
    made = flight(flexible=False)
    still = tv.FlightSchedule(made.at(60.0).replace(time=np.array([50.0, 120.0])), altitude=1e4)
    plant = made.plants(60.0, "drift-exact", "pitch")
    law = autopilot(sample_rate=25.0).along(made, 60.0)
    gust = tv.TriangularWind(peak=np.radians(5.0), duration=7.5).shift(60.0)
    options = {"rate_limit": np.radians(8.0), "start": 60.0}
    along = tv.flights.survival_limit_along(still, law, gust, sign="frozen", **options)
    boundary = tv.closed_loop_boundary(
        plant,
        tv.SaturatedLaw(replace(law, actuator=None, delay=0.0, sample_rate=None)),
        gust,
        rate_limit=np.radians(8.0),
        actuator=law.actuator,
        sample_rate=25.0,
        delay=law.delay,
    )
    step = abs(boundary.deflection / boundary.limit) * 1.98 / 60 / 16**3
    assert along.limit == pytest.approx(abs(boundary.deflection), abs=1.01 * step)
    head = tv.flights.survival_limit_along(still, law, gust, **options)
    assert head.limit > 1.05 * along.limit
    flown = fly_many_along(
        still, law, gust, deflection_limit=head.limit * np.array([0.999, 1.0]), **options
    )
    assert flown.status.tolist() == ["lost", "survived"]
    with pytest.raises(InputError, match="it is calm"):
        tv.flights.survival_limit_along(still, law, gust * 0.0)


def test_stages_between_breakpoints_are_those_of_their_own_times() -> None:
    """To 1e-12 of the largest entry of each array."""
    made, laws = flight(), autopilot(sample_rate=50.0)
    along = checked_flight(
        made, laws, wind_along(made, GUST, "pitch"), 49.0, 66.0, "drift-exact", "pitch"
    )
    stages = sampled_stages([along])
    some = np.arange(3, stages.times.size, 17)
    exact = stages._arrays_at(stages.times[some], some)
    for name, values in stages._arrays.items():
        largest = np.nanmax(np.abs(exact[name]))
        np.testing.assert_allclose(values[some], exact[name], rtol=0.0, atol=1e-12 * largest)


def test_a_pade_approximation_of_another_stability_is_refused_along_a_flight(configuration_i):
    inertia = configuration_i.moment_of_inertia
    vehicle = configuration_i.replace(
        aerodynamic_arm=0.228 * inertia / configuration_i.normal_force_slope,
        control_arm=1.317 * inertia / configuration_i.thrust,
    )
    plant = tv.Plant.from_vehicle(vehicle, "fixed-path")
    schedule = tv.FlightSchedule(vehicle.replace(time=[60.0, 70.0]))
    actuator = tv.Actuator(natural_frequency=20.0, damping=0.02)
    misled = tv.Autopilot(attitude_gain=1.88, rate_gain=1.59, actuator=actuator, delay=0.4)
    better = replace(misled, pade_order=8)
    unstable = np.sum(better.close(plant).poles().real > 0.0)
    assert unstable == misled.margins(plant).unstable_poles
    options = {"model": "fixed-path", "start": 60.0, "stop": 60.5}
    air, wind = tv.winds.Turbulence(6.0, 533.4), tv.TriangularWind(peak=0.05, duration=5.0)
    for fly, around in (
        (fly_along, (wind.shift(60.0),)),
        (tv.control.turbulence_along, (air,)),
    ):
        with pytest.raises(InputError, match="pade_order = 4 is too low for this delay"):
            fly(schedule, misled, *around, **options)
        fly(schedule, better, *around, **options)


def stages_in_a_sounding(*, flexible: bool):
    """Return the stages of a flight at 50 Hz in a sounding with a level each 50 m."""
    made, laws = flight(flexible=flexible), autopilot(sample_rate=50.0)
    height = np.linspace(0.0, 4e4, 801)
    profile = tv.WindProfile(height=height, east=-40 * np.sin(height / 3e3), north=1e-3 * height)
    wind = wind_along(made, tv.fly_through(profile, made, azimuth=np.pi / 2), "pitch")
    return sampled_stages([checked_flight(made, laws, wind, 49.0, 72.0, "drift-exact", "pitch")])


@pytest.mark.parametrize("flexible", [False, True], ids=["rigid", "bending"])
def test_stages_in_a_sounding_are_those_of_their_own_times_and_pressures(flexible) -> None:
    """To 1e-12 of the largest entry of each array."""
    stages = stages_in_a_sounding(flexible=flexible)
    some = np.arange(3, stages.times.size, 17)
    exact = stages._arrays_at(stages.times[some], some, middle=True)
    assert stages._arrays.keys() == exact.keys()
    assert stages.surfaces
    assert None not in stages.surfaces.values()
    for name, values in stages._arrays.items():
        largest = np.nanmax(np.abs(exact[name]))
        np.testing.assert_allclose(values[some], exact[name], rtol=0.0, atol=1e-12 * largest)


def test_stages_near_a_pressure_of_no_possible_vehicle_are_evaluated_themselves() -> None:
    stages = stages_in_a_sounding(flexible=False)
    highest = stages.pressure_at(stages.times, stages.flight).max() + 1e-3

    def plants(times, which, pressure):
        if np.any(pressure > highest):
            raise InputError("no vehicle at this pressure")
        return stages.flown_plants(times, which, pressure)

    careful = replace(stages, flown_plants=plants, surfaces={})
    some = np.arange(3, stages.times.size, 17)
    exact = careful._arrays_at(careful.times[some], some, middle=True)
    for name, values in careful._arrays.items():
        largest = np.abs(exact[name]).max()
        np.testing.assert_allclose(values[some], exact[name], rtol=0.0, atol=1e-12 * largest)
    assert None in careful.surfaces.values()
