"""Flights with six degrees of freedom against the linear theory, closed forms and other flights."""

import multiprocessing
import re
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

import tvclin as tv
from tests.planar import random_vehicle
from tests.report_responses import triangular_attitude
from tests.turns import by_turns, usual
from tvclin.ascent.nominal_flight import load_flight_condition, nominal_flight
from tvclin.base.units import FOOT
from tvclin.boundary.closed_forms import rectangular_limit, triangular_limit
from tvclin.flights.sixdof.airframe import Airframe, Engine, motion_readers, wind_setter
from tvclin.flights.sixdof.fly_sixdof import SixDof
from tvclin.flights.sixdof.model import DEFLECTIONS, model_xml, nominal_trajectory, planet_xml

pytest.importorskip("jsbsim")

DEGREE = np.radians(1.0)
BANDS = (1.0, 0.5, 0.0)


def triangle(vehicle, peak=DEGREE, tau_beta=4.0):
    beta = tv.Coefficients.from_vehicle(vehicle).beta
    return tv.TriangularWind(peak=peak, duration=tau_beta / beta)


def drifting(vehicle, plane="pitch"):
    """Return the linear model whose parameters are frozen and whose speed is held: a cubic."""
    return tv.Plant.from_vehicle(vehicle, model="drift-exact", plane=plane)


def in_jsbsim(*case, **options):
    return tv.flown_boundary(*case, **{"engine": "sixdof"} | options)


def steering(vehicle, deflection=0.001, plane="pitch"):
    """Return an engine with the nozzle turned for a second, and its readers."""
    initial = {"h-sl-ft": 0.0, "theta-rad": vehicle.attitude, "u-fps": vehicle.velocity / FOOT}
    engine = Engine(model_xml(vehicle), initial, 0.01, planet=planet_xml())
    engine.writer(DEFLECTIONS[plane])(deflection)
    for _ in range(100):
        engine.run()
    return engine.reader


@pytest.mark.parametrize("dead_band", usual(BANDS, 1))
def test_the_boundary_without_drift_is_that_of_the_closed_form(configuration_i, dead_band):
    flown = in_jsbsim(
        configuration_i, triangle(configuration_i), dead_band, drift=False, tolerance=5e-6
    )

    assert flown.error <= 5e-6
    assert flown.limit == pytest.approx(triangular_limit(4.0, dead_band), abs=1e-5)


OTHERS = {
    "I": (0.6559, 0.5410, 0.3709),  # independent fourth-order integration of (B1), JSBSim by hand
    "II": (0.6480, 0.5380, 0.3721),
}


@pytest.mark.thorough
@by_turns("plane,name", ["pitch", "yaw"], ["I", "II"], each=3)
def test_the_boundary_with_drift_is_that_of_the_cubic_model(
    configuration_i, configuration_ii, name, plane
):
    """Within what is not linear at one degree; the dead band is left by the trim itself."""
    vehicle = configuration_i if name == "I" else configuration_ii
    plant, wind = drifting(vehicle, plane), triangle(vehicle)
    for dead_band, other in zip(BANDS, OTHERS[name], strict=True):
        exact = tv.boundary_limit(plant, wind, dead_band, switch="literal").limit
        flown = in_jsbsim(vehicle, wind, dead_band, plane=plane)

        assert flown.limit == pytest.approx(exact, abs=1.1e-4 if plane == "yaw" else 5e-4)
        assert flown.limit == pytest.approx(other, abs=1e-3)


@pytest.mark.thorough
def test_what_is_not_linear_grows_with_the_wind_and_turns_with_its_sign(configuration_i):
    """A tail wind is felt less once the path has turned, a head wind more."""
    exact = tv.boundary_limit(
        drifting(configuration_i), triangle(configuration_i), switch="literal"
    ).limit
    off = [
        in_jsbsim(configuration_i, triangle(configuration_i, peak), tolerance=2e-5).limit - exact
        for peak in (2 * DEGREE, -2 * DEGREE, 4 * DEGREE)
    ]

    assert off[1] == pytest.approx(-off[0], rel=0.1)
    assert off[2] == pytest.approx(2.0 * off[0], rel=0.1)


@pytest.mark.thorough
def test_a_rectangular_wind_that_jumps_between_two_steps(configuration_i):
    beta = tv.Coefficients.from_vehicle(configuration_i).beta
    wind = tv.RectangularWind(peak=DEGREE, duration=4.0 / beta).shift(0.0037)
    flown = in_jsbsim(configuration_i, wind, drift=False)

    assert flown.limit == pytest.approx(rectangular_limit(4.0), abs=1.5e-4)


@pytest.mark.parametrize("dead_band", BANDS)
def test_the_attitude_without_drift_is_that_of_equation_13(configuration_i, dead_band):
    wind, B = triangle(configuration_i), tv.Coefficients.from_vehicle(configuration_i).B
    y = 1.1 * triangular_limit(4.0, dead_band)
    times = np.linspace(0.0, 1.5 * wind.duration, 301)
    flown = tv.fly_sixdof(
        configuration_i,
        tv.flights.ReportControl(dead_band),
        wind,
        times,
        deflection_limit=y * B * DEGREE,
        drift=False,
    )
    exact = triangular_attitude(times / wind.duration, 4.0, y, dead_band)
    scaled = flown.outputs["attitude"] / -DEGREE

    assert np.abs(exact).max() > 0.16
    np.testing.assert_allclose(scaled, exact, atol=1e-3)
    np.testing.assert_allclose(
        flown.outputs["angle_of_attack"], flown.outputs["attitude"] - wind(times), atol=2e-5
    )


@pytest.mark.parametrize("plane", ["pitch", "yaw"])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_every_output_tends_to_that_of_the_linear_model(configuration, plane, sign):
    """Errors over the wind fall with the wind: sign, plane and size of all that acts are right."""
    plant, times = drifting(configuration, plane), np.linspace(0.0, 6.0, 61)
    off = []
    for peak in (sign * 0.01, sign * 0.001):
        wind = triangle(configuration, peak)
        bent = tv.linear.ConstantDeflection(limit=-0.3 * peak * plant.coefficients.B, start=1.0)
        exact = tv.attitude_response(plant, bent, wind, times)
        flown = tv.fly_sixdof(configuration, bent, wind, times, plane=plane)
        labels = list(exact.output_labels)
        rows = np.array([flown.outputs[label] for label in labels])
        size = np.abs(np.array(exact.outputs)).max(axis=1, keepdims=True)
        off.append(np.abs((rows - exact.outputs) / size).max())
        assert list(flown.output_labels) == [*labels, "deflection"]
        np.testing.assert_array_equal(flown.inputs["wind"], wind(times))

    assert off[0] < 0.02
    assert off[1] < 0.003


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(6))
def test_any_vehicle_flies_as_its_linear_model(seed):
    """Stable ones too, effectors ahead of the centre of gravity, and others than the thrust."""
    vehicle, _ = random_vehicle(seed)
    vehicle = vehicle.replace(
        aerodynamic_arm=vehicle.aerodynamic_arm * (-1.0) ** (seed % 2),
        control_arm=vehicle.control_arm * (-1.0) ** (seed % 3),
        control_force_slope=None if seed % 2 else 0.3 * vehicle.thrust,
    )
    end = 3.0 / np.sqrt(abs(tv.Coefficients.from_vehicle(vehicle).mu_alpha))
    wind, times = tv.TriangularWind(peak=1e-3, duration=end / 1.5), np.linspace(0.0, end, 31)
    bent = tv.linear.ConstantDeflection(limit=1e-4, start=end / 5.0)
    for plane in ("pitch", "yaw"):
        exact = tv.attitude_response(drifting(vehicle, plane), bent, wind, times).outputs
        flown = tv.fly_sixdof(vehicle, bent, wind, times, plane=plane).outputs[:4]

        size = np.abs(exact).max(axis=1, keepdims=True)
        np.testing.assert_allclose(flown / size, exact / size, atol=3e-3)


def test_a_positive_deflection_turns_the_nose_down_or_left(configuration_i):
    pitch, yaw = (steering(configuration_i, 0.001, plane) for plane in ("pitch", "yaw"))

    assert pitch("attitude/theta-rad")() < configuration_i.attitude - 1e-3
    assert abs(pitch("attitude/psi-rad")()) < 1e-12
    assert yaw("attitude/psi-rad")() > 6.28 - 1e-2  # just left of north
    assert yaw("velocities/r-rad_sec")() < -1e-3
    assert abs(yaw("attitude/theta-rad")() - configuration_i.attitude) < 1e-5
    # The thrust that turns the nose down first pushes the path up.
    assert pitch("flight-path/gamma-rad")() > configuration_i.attitude + 1e-6
    assert yaw("velocities/v-east-fps")() > 1e-3


@pytest.mark.parametrize("plane", ["pitch", "yaw"])
def test_the_path_angle_is_that_of_the_velocity_over_the_ground(configuration_i, plane):
    """A wind of 5 deg changes the speed through the air."""
    initial = {"h-sl-ft": 0.0, "u-fps": configuration_i.velocity / FOOT}
    initial["theta-rad"] = configuration_i.attitude
    engine = Engine(model_xml(configuration_i), initial, 0.01, planet=planet_xml())
    sense = motion_readers(engine, plane, 0.0)
    wind_setter(engine, plane, 0.0)(np.tan(5 * DEGREE) * configuration_i.velocity)
    engine.writer(DEFLECTIONS[plane])(0.005)
    for _ in range(200):
        engine.run()
    read = engine.reader
    north, east, down = (read(f"velocities/v-{name}-fps")() for name in ("north", "east", "down"))
    angles = {"pitch": np.arctan2(-down, north), "yaw": np.arctan2(east, np.hypot(north, down))}
    assert sense.angles()[1] == pytest.approx(angles[plane], rel=1e-9)
    over_ground = np.hypot(np.hypot(north, east), down)
    assert read("velocities/vt-fps")() != pytest.approx(over_ground, rel=3e-3)


@pytest.mark.parametrize(("plane", "towards"), [("pitch", "north"), ("yaw", "west")])
def test_a_positive_wind_is_a_tail_wind_or_from_the_right(configuration_i, plane, towards):
    """The wind speed is the one that `angle_from_speed` takes for the angle, seen from the air."""
    case, wind = SixDof(configuration_i, plane), triangle(configuration_i)
    air = case.air(wind, 0.0, 10.0)
    path = configuration_i.attitude if plane == "pitch" else np.pi / 2
    along = air.speeds if towards == "north" else -air.speeds
    relative = configuration_i.velocity * np.sin(path) / np.sin(path + air.angles)

    assert along.max() > 0.0
    np.testing.assert_allclose(tv.angle_from_speed(along, relative, path), air.angles, atol=1e-15)


def test_speed_and_nominal_flight_are_held(configuration_i):
    bent, still = steering(configuration_i, 0.01), steering(configuration_i, 0.0)

    assert bent("velocities/vt-fps")() * FOOT == pytest.approx(configuration_i.velocity, rel=1e-8)
    assert abs(still("attitude/theta-rad")() - configuration_i.attitude) < 1e-9
    assert abs(still("flight-path/gamma-rad")() - configuration_i.attitude) < 1e-9


def test_the_engine_is_given_the_vehicle_to_the_last_digit(configuration_i):
    read = steering(configuration_i, 0.0)
    slug = 0.45359237 * 9.80665 / 0.3048

    assert read("inertia/mass-slugs")() * slug == pytest.approx(configuration_i.mass, rel=1e-12)
    for axis in ("iyy", "izz"):
        inertia = read(f"inertia/{axis}-slugs_ft2")() * slug * FOOT**2
        assert inertia == pytest.approx(configuration_i.moment_of_inertia, rel=1e-12)
    assert read("accelerations/gravity-ft_sec2")() * FOOT == pytest.approx(9.80665, rel=1e-7)


def test_a_common_factor_of_forces_and_inertia_changes_nothing(configuration_i):
    names = ("weight", "moment_of_inertia", "normal_force_slope", "thrust", "axial_force")
    tenfold = configuration_i.replace(**{n: 10.0 * getattr(configuration_i, n) for n in names})
    wind, times = triangle(configuration_i), np.linspace(0.0, 8.0, 41)
    one, ten = (
        tv.fly_sixdof(v, tv.flights.ReportControl(0.5), wind, times, deflection_limit=0.001).outputs
        for v in (configuration_i, tenfold)
    )

    np.testing.assert_allclose(ten, one, rtol=1e-7, atol=1e-10)  # rounding that has grown by e^4


def test_a_part_of_the_thrust_may_be_what_is_turned(configuration_i):
    part = configuration_i.replace(control_force_slope=0.4 * configuration_i.thrust)
    plant, wind = drifting(part), 0.0 * triangle(part)
    bent, times = tv.linear.ConstantDeflection(limit=1e-4), np.linspace(0.0, 4.0, 21)
    flown = tv.fly_sixdof(part, bent, wind, times).outputs
    exact = tv.attitude_response(plant, bent, wind, times).outputs

    np.testing.assert_allclose(flown[0], exact[0], atol=1e-3 * np.abs(exact[0]).max())


EARTH = tv.flights.Earth(latitude=-0.5, heading=2.0)
CONDITION = load_flight_condition("configuration-i")


def at_its_time(vehicle, peak=DEGREE):
    """Return the triangle with its peak at the vehicle's own time, and times up to its end."""
    wind = triangle(vehicle, peak)
    wind = wind.shift(vehicle.time - wind.duration / 2)
    return wind, np.linspace(float(wind.onset), float(wind.end), 41)


@pytest.mark.thorough
@pytest.mark.parametrize(("plane", "peak"), [("pitch", -3 * DEGREE), ("yaw", DEGREE)])
def test_along_the_trajectory_it_flies_as_the_equations_of_the_report(configuration_i, plane, peak):
    """Another solver, atmosphere and nominal flight; deviations agree, in the wind's measure."""
    wind, times = at_its_time(configuration_i, peak)
    limit = 0.8 * tv.Coefficients.from_vehicle(configuration_i).B * abs(peak)
    options = {"deflection_limit": limit, "plane": plane, "condition": CONDITION}
    bent = tv.linear.ConstantDeflection(
        limit=-np.sign(peak) * 0.4 * limit, start=float(wind.onset) + 1.0
    )
    for control in (tv.flights.ReportControl(0.7), bent):
        flown, planar = (
            fly(configuration_i, control, wind, times, **options)
            for fly in (tv.fly_sixdof, tv.fly_planar)
        )
        size = np.abs(planar.outputs[0]).max()
        assert size > 0.2 * abs(peak)
        off = np.abs(flown.outputs - planar.outputs).max(axis=1) / max(size, abs(peak))
        assert max(off[:3]) < 1e-3
        assert off[3] < 2e-3  # the end of a jump or a bend is felt up to half a step early


FEEDBACK = {
    "drift": {"drift_rate_gain": 8e-4, "drift_gain": 3e-4},
    "acceleration": {"acceleration_gain": 4e-3, "acceleration_station": 6.0},
}


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("plane", "feedback"), usual([(p, name) for name in FEEDBACK for p in ("pitch", "yaw")], 3)
)
@pytest.mark.parametrize("condition", [None, CONDITION], ids=["frozen", "varying"])
def test_feedback_of_lateral_motion_flies_as_the_equations_of_the_report(
    configuration_i, plane, feedback, condition
):
    """Drift and force by another solver; the same gains without it fly elsewhere."""
    wind, times = at_its_time(configuration_i, 3 * DEGREE)
    flown = {
        name: [
            fly(
                configuration_i,
                tv.Autopilot(attitude_gain=0.6, rate_gain=0.8, **gains),
                wind,
                times,
                deflection_limit=0.1,
                plane=plane,
                condition=condition,
            ).outputs[:3]
            for fly in (tv.fly_sixdof, tv.fly_planar)
        ]
        for name, gains in (("with", FEEDBACK[feedback]), ("without", {}))
    }
    with_it, without = (np.abs(np.subtract(*flown[name])).max() for name in flown)
    assert np.abs(flown["with"][1] - flown["without"][1]).max() > 0.02 * 3 * DEGREE
    assert with_it < 1.3e-3 * 3 * DEGREE
    assert with_it < 1.1 * without + 3e-4 * 3 * DEGREE


@pytest.mark.thorough
@pytest.mark.parametrize(("plane", "planar"), usual([("pitch", 0.62851), ("yaw", 0.64810)], 0))
def test_the_boundary_along_the_trajectory_is_that_of_planar_flights(
    configuration_i, plane, planar
):
    """To which test_planar.py holds the planar engine, and a flight to another integration."""
    wind, _ = at_its_time(configuration_i)
    flown = in_jsbsim(
        configuration_i, wind, plane=plane, frozen=False, condition=CONDITION, tolerance=2e-4
    )

    assert flown.limit == pytest.approx(planar, abs=5e-4)


def test_the_nominal_flight_of_the_engine_is_the_gravity_turn(configuration_i):
    """Mass, air, speed and path at its end, and no angle of attack; the air to a part in 10^5."""
    times = np.arange(62.0, 72.0, 0.01)
    course = nominal_trajectory(configuration_i, CONDITION, times)
    airframe = Airframe(course.vehicle, "pitch", True, 0.01, course.departure)
    still = np.zeros(times.size)
    rows = airframe.fly(lambda k, seen: 0.0, still, still, course.rows)
    nominal = nominal_flight(configuration_i, CONDITION, start=62.0, stop=72.0)
    speed, path, altitude = nominal.states(times[-1])
    read = airframe.engine.reader
    slug = 0.45359237 * 9.80665 / 0.3048

    assert not np.any(rows)
    assert read("velocities/vt-fps")() * FOOT == pytest.approx(speed, rel=1e-5)
    assert read("flight-path/gamma-rad")() == pytest.approx(path, rel=1e-5)
    assert read("position/h-sl-ft")() * FOOT == pytest.approx(altitude, rel=1e-5)
    assert read("inertia/mass-slugs")() * slug == pytest.approx(nominal.mass(times[-1]), rel=1e-9)
    assert read("inertia/iyy-slugs_ft2")() * slug * FOOT**2 == pytest.approx(2.25e7, rel=1e-12)
    assert read("aero/qbar-psf")() * 47.880259 == pytest.approx(
        nominal.dynamic_pressure(times[-1]), rel=2e-5
    )
    assert abs(read("aero/alpha-rad")()) < 1e-6


@pytest.mark.thorough
@pytest.mark.parametrize("plane", ["pitch", "yaw"])
def test_over_the_earth_a_flight_is_measured_against_the_one_without_wind(configuration_i, plane):
    """Left alone it is that flight bit for bit; in a wind it is nearly that over a flat planet."""
    wind, times = triangle(configuration_i), np.linspace(0.0, 8.0, 41)
    single = tv.fly_sixdof(configuration_i, 0.0 * wind, 0.0 * wind, times, plane=plane, earth=EARTH)
    control = tv.flights.ReportControl(0.5)
    blown, flat = (
        tv.fly_sixdof(
            configuration_i, control, wind, times, deflection_limit=0.0011, plane=plane, earth=earth
        )
        for earth in (EARTH, None)
    )

    assert not np.any(single.outputs)
    for label in flat.output_labels:
        size = np.abs(flat.outputs[label]).max()
        np.testing.assert_allclose(
            blown.outputs[label], flat.outputs[label], atol=0.05 * size
        )  # what differs has grown by e^4
    assert np.abs(blown.outputs - flat.outputs).max() > 1e-6


@pytest.mark.thorough
@pytest.mark.parametrize("plane", usual(["pitch", "yaw"], 1))
def test_the_turning_earth_moves_the_frozen_boundary_by_less_than_a_part_in_500(
    configuration_i, plane
):
    wind = triangle(configuration_i)
    over, flat = (
        in_jsbsim(configuration_i, wind, 0.5, plane=plane, earth=earth).limit
        for earth in (EARTH, None)
    )

    assert over == pytest.approx(flat, rel=2e-3)


def flight(vehicle):
    """Return one flight, for other processes too."""
    wind, times = triangle(vehicle), np.linspace(0.0, 5.0, 51)
    limit = 0.001
    flown = tv.fly_sixdof(
        vehicle, tv.TrimLaw(drifting(vehicle)), wind, times, deflection_limit=limit
    )
    return np.asarray(flown.outputs)


@pytest.mark.thorough
def test_repeats_are_equal_bit_for_bit_also_in_other_processes(configuration_i):
    once = flight(configuration_i)
    case, wind = SixDof(configuration_i), triangle(configuration_i)
    air = case.air(wind, 0.0, 5.0)
    repeats = [case.flown(lambda k, seen, bent=bent: bent, air) for bent in (0.001, -0.02, 0.001)]
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as others:
        (elsewhere,) = others.map(flight, [configuration_i])

    np.testing.assert_array_equal(flight(configuration_i), once)
    np.testing.assert_array_equal(elsewhere, once)
    with pytest.raises(tv.InputError, match="the flight fails"):
        case.flown(lambda k, seen: np.nan, air)
    np.testing.assert_array_equal(flight(configuration_i), once)
    np.testing.assert_array_equal(repeats[0], repeats[2])
    assert not np.array_equal(repeats[0], repeats[1])


@pytest.mark.parametrize("earth", [None, EARTH])
def test_a_law_is_shown_what_the_engine_will_do(configuration_i, earth):
    """The rate to rounding, the angles to second order in the step."""
    case, seen = SixDof(configuration_i, earth=earth), []
    gentle, B = triangle(configuration_i), tv.Coefficients.from_vehicle(configuration_i).B
    air = case.air(gentle, 0.0, 5.0)

    def steering(k, shown):
        seen.append(shown[:4])
        return B * (shown.angle_of_attack + 5.0 * shown.attitude + 5.0 * shown.attitude_rate)

    rows = case.flown(steering, air)[1:, :4]
    off = np.abs(np.array(seen) - rows).max(axis=0) / DEGREE

    assert off[1] < 1e-9
    assert max(off[[0, 2, 3]]) < 2e-4


def laws(plant):
    gains = tv.control.canonical_gains(plant.coefficients)
    return {
        "trim": (tv.TrimLaw(plant), {}),
        "dead band": (tv.control.DeadBandLaw(plant, dead_band=0.5), {}),
        "gains": (tv.SaturatedLaw(gains), {"actuator": tv.Actuator(natural_frequency=25.1)}),
        "integral": (tv.SaturatedLaw(_with_integral(gains)), {}),
        "rate limit": (
            tv.SaturatedLaw(gains),
            {"actuator": tv.Actuator(natural_frequency=25.1), "rate_limit": 0.0007},
        ),
        "lean": (tv.RecoverableAttitudeLaw(plant, design_peak=DEGREE), {}),
        "estimator": (
            tv.RecoverableAttitudeLaw(plant, estimator=tv.control.WindEstimator(bandwidth=5.0)),
            {},
        ),
    }


def _with_integral(gains):
    return tv.Autopilot(
        attitude_gain=gains.attitude_gain, rate_gain=gains.rate_gain, integral_gain=0.02
    )


@pytest.mark.thorough
@pytest.mark.parametrize(
    "name", ["trim", "dead band", "gains", "integral", "rate limit", "lean", "estimator"]
)
def test_a_law_flies_as_in_the_linear_flight(configuration_i, name):
    """What is left is the law's sampling and what is not linear at one degree."""
    plant, wind = drifting(configuration_i), triangle(configuration_i)
    law, options = laws(plant)[name]
    limit, times = 0.9 * plant.coefficients.B * DEGREE, np.linspace(0.0, 10.0, 101)
    flown = tv.fly_sixdof(
        configuration_i, law, wind, times, deflection_limit=limit, step=0.005, **options
    )
    linear = tv.fly(plant, law, wind, times, deflection_limit=limit, sample_rate=200.0, **options)

    for label in linear.output_labels:
        size = np.abs(linear.outputs[label]).max()
        # An estimator takes the deflection of half a step ago.
        tolerance = (0.04 if name == "estimator" else 0.02) * size
        if label in ("deflection", "attitude_rate") and name == "dead band":
            continue  # the limit is let go within a step, which the attitude shows
        np.testing.assert_allclose(flown.outputs[label], linear.outputs[label], atol=tolerance)


def test_an_autopilot_within_its_limit_is_its_own_closed_loop(configuration_i):
    plant, wind = drifting(configuration_i), triangle(configuration_i)
    gains = tv.control.canonical_gains(plant.coefficients)
    pilot = tv.Autopilot(
        attitude_gain=gains.attitude_gain, rate_gain=gains.rate_gain, actuator=tv.Actuator()
    )
    times = np.linspace(0.0, 10.0, 101)
    flown = tv.fly_sixdof(configuration_i, pilot, wind, times, deflection_limit=0.1)
    linear = pilot.respond(plant, wind, times)

    for label in linear.output_labels:
        size = np.abs(linear.outputs[label]).max()
        np.testing.assert_allclose(flown.outputs[label], linear.outputs[label], atol=0.01 * size)


def test_name_and_time_of_a_vehicle_are_nothing_to_its_flight(configuration_i):
    other = configuration_i.replace(name="another", time=np.array([66.0, 67.0]))

    np.testing.assert_array_equal(flight(other), flight(configuration_i))


def test_a_history_is_limited(configuration_i):
    bent = tv.linear.ConstantDeflection(limit=0.01)
    flown = tv.fly_sixdof(
        configuration_i, bent, triangle(configuration_i), [0.0, 1.0], deflection_limit=0.002
    )

    assert flown.outputs["deflection"][-1] == 0.002


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("law", "linear"),
    usual([("trim", 0.6545), ("half-relief", 0.4429), ("recoverable-attitude", 0.3895)], 1),
)
def test_a_law_needs_in_six_degrees_what_it_needs_in_the_linear_theory(
    configuration_i, law, linear
):
    """The linear values are those of `closed_loop_boundary` at 100 Hz, in 7.5 s."""
    plant = drifting(configuration_i)
    wind = tv.TriangularWind(peak=DEGREE, duration=7.5)
    chosen = tv.design.standard_laws(plant, DEGREE)[law]
    flown = in_jsbsim(configuration_i, wind, law=chosen, tolerance=2e-3)

    assert flown.limit == pytest.approx(linear, abs=5e-3)


def test_a_flight_ends_where_the_model_does(configuration_i):
    wind, times = triangle(configuration_i, 5 * DEGREE), np.linspace(0.0, 12.0, 121)
    with pytest.warns(UserWarning, match=r"ends at t = \d\.\d+ s.*more than 25 deg") as caught:
        flown = tv.fly_sixdof(configuration_i, 0.0 * wind, wind, times)
    ended = float(re.search(r"t = ([\d.]+) s", str(caught[0].message))[1])
    attitude = flown.outputs["attitude"]

    np.testing.assert_array_equal(np.isnan(attitude), times > ended)
    assert np.nanmax(np.abs(attitude)) > np.radians(20.0)


def test_jsbsim_writes_nothing_and_leaves_nothing(configuration_i, capfd, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    flight(configuration_i)

    assert capfd.readouterr() == ("", "")
    assert list(tmp_path.iterdir()) == []


class Lost(tv.control.Law):
    """A law that has no answer."""

    def demand(self, seen, states, limit):
        return np.nan


@pytest.mark.thorough
def test_bad_input_is_said_in_one_sentence(configuration_i, configuration_ii):
    wind, law = triangle(configuration_i), tv.TrimLaw(drifting(configuration_i))
    early = tv.linear.ConstantDeflection(limit=0.001, start=-1.0)
    pilot = tv.Autopilot(
        attitude_gain=1.0, rate_gain=1.0, actuator=tv.Actuator(natural_frequency=90.0)
    )

    def fly(control=law, wind=wind, times=(0.0, 1.0), vehicle=configuration_i, **options):
        given = {"deflection_limit": 0.001, **options}
        return tv.fly_sixdof(vehicle, control, wind, times, **given)

    cases = {
        "wind must not begin before the flight, at 1 s": lambda: fly(times=[1.0, 2.0]),
        "control must not begin before the flight, at 0 s": lambda: fly(early),
        "step must be at most 0.00555556 s for an actuator of 90 rad/s": lambda: fly(pilot),
        "step must be at most 0.00303 s for a vehicle that moves with 16.5 rad/s": lambda: fly(
            vehicle=configuration_i.replace(moment_of_inertia=23100.0)
        ),
        "step must be between 0.0001 and 0.02": lambda: fly(step=0.1),
        "the flight fails at t = 0 s: deflection is not finite": lambda: fly(Lost()),
        "deflection_limit must be finite": lambda: fly(deflection_limit=np.inf),
        "deflection_limit must be positive": lambda: fly(deflection_limit=-0.1),
        "earth must be an Earth": lambda: fly(earth="round"),
        "latitude must be between": lambda: tv.flights.Earth(latitude=28.5),
        "timepts must end before the nominal flight has turned by 25 deg": lambda: fly(
            vehicle=configuration_i.replace(velocity=20.0), times=[0.0, 200.0], earth=EARTH
        ),
        "plane must be one of pitch, yaw": lambda: fly(plane="roll"),
        "control must be a Law": lambda: fly(0.3),
        "belong to a law or an autopilot": lambda: fly(0.0 * wind, rate_limit=0.1),
        "autopilot with a delay is not flown": lambda: fly(
            tv.Autopilot(attitude_gain=1.0, rate_gain=1.0, delay=0.1)
        ),
        "timepts must be one row": lambda: fly(times=[]),
        "must be one vehicle": lambda: fly(vehicle=configuration_i.replace(thrust=[2e6, 3e6])),
        "wind must be one wind": lambda: fly(wind=tv.TriangularWind(peak=[0.1, 0.2], duration=1.0)),
        "an angle that a horizontal wind can make": lambda: fly(
            wind=tv.TriangularWind(peak=-0.9, duration=1.0)
        ),
        "dead_band must be between 0 and 1": lambda: tv.flights.ReportControl(1.1),
        "engine must be one of planar, sixdof": lambda: in_jsbsim(
            configuration_i, wind, engine="seven"
        ),
        "condition must be given exactly when": lambda: in_jsbsim(
            configuration_i, wind, frozen=False
        ),
        "condition must be left out over the Earth": lambda: fly(condition=CONDITION, earth=EARTH),
        "without drift": lambda: fly(condition=CONDITION, drift=False),
        "condition must be a FlightCondition": lambda: fly(condition=12e3),
        "dead_band belongs to the report's control": lambda: in_jsbsim(
            configuration_i, wind, 0.5, law=law
        ),
        "1.5 times the largest trim deflection": lambda: in_jsbsim(
            configuration_i, wind, engine=lambda *given, **named: lambda limit: False
        ),
        "wind must end": lambda: in_jsbsim(
            configuration_i, tv.linear.ConstantDeflection(limit=0.1)
        ),
    }
    for said, bad in cases.items():
        with pytest.raises(tv.InputError, match=re.escape(said)):
            bad()


def test_without_jsbsim_the_extra_is_named(configuration_i, monkeypatch):
    monkeypatch.setitem(sys.modules, "jsbsim", None)
    with pytest.raises(tv.InputError, match=r'pip install "tvclin\[sixdof\]"'):
        flight(configuration_i.replace(weight=1.4e6))  # no engine of it is kept from before


def test_the_bisection_knows_nothing_of_the_engine(configuration_i):
    """A known edge is computed to the tolerance, in the number of halvings that it takes."""
    wind, request = triangle(configuration_i), []
    scale = tv.Coefficients.from_vehicle(configuration_i).B * DEGREE

    def engine(vehicle, gust, control, *, plane, frozen):
        request.append((vehicle, gust, control, plane, frozen))
        return lambda limit: limit >= 0.4321 * scale

    result = tv.flown_boundary(configuration_i, wind, 0.3, engine=engine, tolerance=1e-3)

    assert request == [(configuration_i, wind, tv.flights.ReportControl(0.3), "pitch", True)]
    assert abs(result.limit - 0.4321) <= result.error <= 1e-3
    assert result.flights == 11
    assert result.deflection == -result.limit * scale
    back = tv.flown_boundary(configuration_i, wind * -1.0, 0.3, engine=engine, tolerance=1e-3)
    assert back.deflection == -result.deflection
