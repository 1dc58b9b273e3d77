"""Schedules from RocketPy: by a made-up stand-in always, by the package where it is installed."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import tvclin as tv
from tests.schedules.rocketpy_standin import BURN, RADIUS, Flight, GenericSurface, Rocket

G = 9.80665


@pytest.mark.parametrize("forward", [1.0, -1.0])
def test_numbers_are_those_of_point_masses_and_forces(forward: float) -> None:
    """At any time by moments about the nose, in both of RocketPy's orientations."""
    flight = Flight(Rocket(forward))
    schedule = tv.ascent.schedule_from_rocketpy(
        flight, gimbal_position=forward * -1.2, max_rows=401
    )
    t = float(schedule.times[200])
    mass = 23.0 + 6.0 * (1.0 - t / BURN)
    p = mass - 23.0
    x = 0.8 * p / mass  # aft of the centre of dry mass
    # 23 kg about 0, and p about 0.8 m aft: both about x
    inertia = 18.0 + 23.0 * x**2 + p * (0.5**2 / 12.0 + (0.8 - x) ** 2)
    nose, fins = 2.0, 4.0 * 6.0
    centre = (nose * (1.7 - 0.28) + fins * (-1.0 - 0.05)) / (nose + fins)
    mach = 65.0 * t / 340.0
    N = 0.5 * (65.0 * t) ** 2 * np.pi * RADIUS**2 * (nose + fins) * (1.0 + 0.1 * mach)
    vehicle = schedule.at(t)
    expected = {
        "weight": mass * G,
        "moment_of_inertia": inertia,
        "control_arm": 1.2 - x,
        "aerodynamic_arm": centre + x,
        "normal_force_slope": N,
        "thrust": 2400.0,
        "velocity": 65.0 * t,
        "attitude": np.radians(84.0),
    }
    for name, value in expected.items():
        assert getattr(vehicle, name) == pytest.approx(value, rel=1e-13), name  # a dozen roundings
    assert schedule.height[0] == pytest.approx(flight.z(0.4), rel=1e-15)
    assert schedule.times[-1] < BURN
    assert any("stable throughout" in note for note in schedule.notes)


def test_surfaces_are_left_out_by_name() -> None:
    """Without fins the nose alone pulls, 0.28 m behind its tip."""
    schedule = tv.ascent.schedule_from_rocketpy(Flight(), gimbal_position=-1.2, without=("Fins",))
    t = float(schedule.times[0])
    x = -Rocket().center_of_mass(t)
    assert schedule.at(t).aerodynamic_arm == pytest.approx(1.7 - 0.28 + x, rel=1e-13)
    assert any("left out of slope and centre of pressure: Fins" in note for note in schedule.notes)
    with pytest.raises(tv.InputError, match="surfaces of the rocket, Nose Cone, Fins; got 'Wings'"):
        tv.ascent.schedule_from_rocketpy(Flight(), gimbal_position=-1.2, without=("Wings",))
    with pytest.raises(tv.InputError, match="nothing is left"):
        tv.ascent.schedule_from_rocketpy(
            Flight(), gimbal_position=-1.2, without=("Fins", "Nose Cone")
        )


def test_generic_surfaces_are_told() -> None:
    surfaces = (*Rocket().surfaces, (GenericSurface("Canards", 1.0, 0.0), 0.5))
    schedule = tv.ascent.schedule_from_rocketpy(
        Flight(Rocket(surfaces=surfaces)), gimbal_position=-1.2
    )
    assert any("leaves generic surfaces out" in n and "Canards" in n for n in schedule.notes)


@pytest.mark.parametrize(
    ("flight", "gimbal", "said"),
    [
        (Flight(degrees_of_attack=3.0), -1.2, r"at 0.4 s: the angle of attack is 3 deg"),
        (Flight(), 1.2, "must lie behind the centre of mass, at -0.15"),
        (Flight(Rocket(forward=-1.0)), -1.2, "must lie behind the centre of mass"),
        (Flight(out_of_rail_time=6.0), -1.2, "leave the rail before burnout; got 6 and 5 s"),
        (SimpleNamespace(), -1.2, "with rocket in its SimpleNamespace"),
        ("flight.csv", -1.2, "with rocket in its str; got 'flight.csv'"),
    ],
)
def test_what_is_no_flight_or_not_linear_is_refused(flight: Any, gimbal: float, said: str) -> None:
    with pytest.raises(tv.InputError, match=said):
        tv.ascent.schedule_from_rocketpy(flight, gimbal_position=gimbal)


def test_a_function_that_gives_no_number_is_refused() -> None:
    motor = SimpleNamespace(burn_out_time=BURN, thrust=lambda t: "much")
    with pytest.raises(tv.InputError, match=r"motor\.thrust a function that gives a number"):
        tv.ascent.schedule_from_rocketpy(
            Flight(replace(Rocket(), motor=motor)), gimbal_position=-1.2
        )


@pytest.fixture(scope="module", params=["tail_to_nose", "nose_to_tail"])
def real(request: pytest.FixtureRequest) -> tuple[float, Any]:
    """A flight of the package itself, of a made-up rocket; how its positions grow."""
    rocketpy = pytest.importorskip("rocketpy")
    forward = 1.0 if request.param == "tail_to_nose" else -1.0
    motor = rocketpy.GenericMotor(
        thrust_source=[[0.0, 2400.0], [4.9, 2400.0], [5.0, 0.0]],
        burn_time=5.0,
        chamber_radius=0.06,
        chamber_height=1.0,
        chamber_position=0.5,
        propellant_initial_mass=6.0,
        dry_mass=2.0,
        center_of_dry_mass_position=0.5,
        dry_inertia=(0.2, 0.2, 0.01),
        nozzle_radius=0.04,
        nozzle_position=0,
        coordinate_system_orientation="nozzle_to_combustion_chamber",
    )
    rocket = rocketpy.Rocket(
        radius=RADIUS,
        mass=23.0,
        inertia=(18.0, 18.0, 0.1),
        power_off_drag=0.4,
        power_on_drag=0.4,
        center_of_mass_without_motor=0.0,
        coordinate_system_orientation=request.param,
    )
    rocket.add_motor(motor, position=-1.3 * forward)
    rocket.add_nose(length=0.6, kind="von karman", position=1.7 * forward, name="Nose")
    rocket.add_trapezoidal_fins(
        n=4, root_chord=0.2, tip_chord=0.1, span=0.15, position=-1.0 * forward, name="Fins"
    )
    site = rocketpy.Environment(elevation=1400)
    site.set_atmospheric_model("standard_atmosphere")
    flight = rocketpy.Flight(
        rocket=rocket, environment=site, rail_length=6, inclination=86, terminate_on_apogee=True
    )
    return forward, flight


def test_inertia_and_arms_of_the_package_itself(real: tuple[float, Any]) -> None:
    """From its parts, each about the common centre of mass, by parallel axes."""
    forward, flight = real
    rocket, motor = flight.rocket, flight.rocket.motor
    schedule = tv.ascent.schedule_from_rocketpy(
        flight, gimbal_position=-1.2 * forward, max_rows=401
    )
    for t in schedule.times[[0, 200, -2]]:
        parts = [
            (23.0, 0.0, 18.0),
            (2.0, -0.8, 0.2),
            (motor.propellant_mass(t), -0.8, motor.propellant_I_11(t)),
        ]
        mass = sum(m for m, _, _ in parts)
        x = sum(m * at for m, at, _ in parts) / mass
        inertia = sum(own + m * (at - x) ** 2 for m, at, own in parts)
        vehicle = schedule.at(t)
        # RocketPy keeps products of its functions as samples, a hundred over the burn
        assert vehicle.weight == pytest.approx(mass * G, rel=1e-6)
        assert vehicle.control_arm == pytest.approx(x + 1.2, rel=1e-4)
        assert vehicle.moment_of_inertia == pytest.approx(inertia, rel=1e-4)
    ignition = rocket.I_11(0.0) / (
        rocket.I_11(0.0) - rocket.total_mass(0.0) * rocket.com_to_cdm_function(0.0) ** 2
    )
    assert ignition > 1.02  # so much too large it would be about the centre of dry mass


def test_without_fins_the_nose_of_the_package_pulls_alone(real: tuple[float, Any]) -> None:
    forward, flight = real
    schedule = tv.ascent.schedule_from_rocketpy(
        flight, gimbal_position=-1.2 * forward, without=("Fins",)
    )
    t = float(schedule.times[0])
    nose = flight.rocket.nosecones[0]
    N = flight.dynamic_pressure(t) * np.pi * RADIUS**2 * nose.clalpha(flight.mach_number(t))
    assert schedule.at(t).normal_force_slope == pytest.approx(N, rel=1e-9)
    x = forward * flight.rocket.center_of_mass(t)
    assert schedule.at(t).aerodynamic_arm == pytest.approx(1.7 - nose.cpz - x, rel=1e-9)
