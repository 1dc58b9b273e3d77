"""The vehicle: what it accepts, what it refuses, and in which words."""

import dataclasses

import numpy as np
import pytest

import tvclin
from tests.vehicles import CONFIGURATION_I
from tvclin.vehicle.vehicle import vehicle_warnings

NUMBERS = CONFIGURATION_I | {"control_force_slope": 1e6}
AERODYNAMICS = {
    "dynamic_pressure": 45_000.0,
    "reference_area": 34.0,
    "normal_force_coefficient_slope": 4.3,
    "axial_force_coefficient": 0.5,
}
OTHERS = {
    name: value
    for name, value in NUMBERS.items()
    if name not in ("normal_force_slope", "axial_force")
}
NOT_NUMBERS = [np.nan, np.inf, -np.inf, "2.5", "heavy", True, 1j, [1.0, None], [[1.0, 2.0], [3.0]]]


def refusal(call, *args, **kwargs):
    """Return the message of an InputError, which must be one sentence on one line."""
    with pytest.raises(tvclin.InputError) as caught:
        call(*args, **kwargs)
    message = str(caught.value)
    assert "\n" not in message
    assert ". " not in message
    assert 20 < len(message) < 250
    return message


def test_input_error_is_a_value_error():
    assert issubclass(tvclin.InputError, ValueError)


@pytest.mark.parametrize("bad", NOT_NUMBERS, ids=repr)
@pytest.mark.parametrize("name", NUMBERS)
def test_each_number_must_be_real_and_finite(name, bad):
    assert refusal(tvclin.Vehicle, **NUMBERS | {name: bad}).startswith(f"{name} must be ")


@pytest.mark.parametrize("bad", [0.0, -1.0, [1.0, -2.0]], ids=repr)
@pytest.mark.parametrize(
    "name", ["weight", "moment_of_inertia", "thrust", "velocity", "control_force_slope"]
)
def test_weight_inertia_thrust_velocity_and_slope_are_positive(name, bad):
    assert refusal(tvclin.Vehicle, **NUMBERS | {name: bad}).startswith(f"{name} must be positive")


@pytest.mark.parametrize("name", ["normal_force_slope", "axial_force"])
def test_aerodynamic_forces_may_be_zero_but_not_negative(name):
    assert getattr(tvclin.Vehicle(**NUMBERS | {name: 0.0}), name) == 0.0
    assert refusal(tvclin.Vehicle, **NUMBERS | {name: -1.0}).startswith(
        f"{name} must be zero or positive"
    )


def test_a_control_force_at_the_centre_of_gravity_is_refused():
    assert refusal(tvclin.Vehicle, **NUMBERS | {"control_arm": 0.0}).startswith("control_arm must")


def test_effectors_ahead_of_the_centre_of_gravity_have_a_negative_arm():
    assert tvclin.Vehicle(**NUMBERS | {"control_arm": -12.0}).control_arm == -12.0


@pytest.mark.parametrize("attitude", [1.58, -1.58, 44.83])
def test_an_attitude_beyond_90_degrees_is_refused(attitude):
    message = refusal(tvclin.Vehicle, **NUMBERS | {"attitude": attitude})
    got = f"{np.degrees(attitude):.6g} deg ({attitude:.6g} rad)"
    assert message == f"attitude must be within 90 degrees; got {got}"


@pytest.mark.parametrize(
    ("name", "value"),
    [("moment_of_inertia", 1e19), ("axial_force", 1e-10), ("weight", [1e6, 1e19])],
)
def test_sizes_that_no_booster_has_are_refused(name, value):
    rule = f"{name} must be a size between 1e-09 and 1e+18 in SI units; got {np.ravel(value)[-1]:g}"
    assert refusal(tvclin.Vehicle, **NUMBERS | {name: value}) == rule
    assert tvclin.Vehicle(**NUMBERS | {"aerodynamic_arm": 1e-10}).aerodynamic_arm == 1e-10


def test_vertical_and_descending_flight_are_legal():
    assert tvclin.Vehicle(**NUMBERS | {"attitude": np.pi / 2}).attitude == np.pi / 2
    assert tvclin.Vehicle(**NUMBERS | {"attitude": -np.pi / 2}).attitude == -np.pi / 2


def test_a_stable_vehicle_is_legal():
    assert tvclin.Vehicle(**NUMBERS | {"aerodynamic_arm": -3.0}).aerodynamic_arm == -3.0


def test_the_message_says_what_came_and_at_which_index():
    message = refusal(tvclin.Vehicle, **NUMBERS | {"thrust": [1e6, 2e6, -3.5e6]})
    assert message == "thrust must be positive; got -3.5e+06 N at index 2"


def test_batches_that_do_not_broadcast_are_refused_by_name_and_shape():
    message = refusal(tvclin.Vehicle, **NUMBERS | {"thrust": [1.0, 2.0], "weight": [1.0] * 3})
    assert "thrust (2,)" in message
    assert "weight (3,)" in message


def test_the_name_is_a_text():
    assert refusal(tvclin.Vehicle, **NUMBERS, name=7).startswith("name must be a text")


def test_an_unknown_field_in_replace_is_named():
    vehicle = tvclin.Vehicle(**NUMBERS)
    assert "trust" in refusal(vehicle.replace, trust=1.0)


def test_replace_changes_one_field_and_checks_it():
    vehicle = tvclin.Vehicle(**NUMBERS)
    changed = vehicle.replace(thrust=3e6)
    assert changed == tvclin.Vehicle(**NUMBERS | {"thrust": 3e6})
    assert vehicle.thrust == 2.495e6
    assert refusal(vehicle.replace, thrust=0.0).startswith("thrust must be positive")


def test_aerodynamics_give_the_forces_of_eq_b1d():
    vehicle = tvclin.Vehicle.from_aerodynamics(**AERODYNAMICS, **OTHERS)
    assert vehicle.normal_force_slope == pytest.approx(45_000 * 34 * 4.3, rel=1e-15)
    assert vehicle.axial_force == pytest.approx(45_000 * 34 * 0.5, rel=1e-15)
    assert {name: getattr(vehicle, name) for name in OTHERS} == OTHERS


@pytest.mark.parametrize("bad", [np.nan, -1.0, "x"], ids=repr)
@pytest.mark.parametrize("name", AERODYNAMICS)
def test_bad_aerodynamics_are_refused_by_their_own_name(name, bad):
    call = tvclin.Vehicle.from_aerodynamics
    assert refusal(call, **AERODYNAMICS | {name: bad}, **OTHERS).startswith(f"{name} must be")


@pytest.mark.parametrize("name", ["normal_force_slope", "axial_force"])
def test_a_force_and_its_coefficient_together_are_refused(name):
    call = tvclin.Vehicle.from_aerodynamics
    assert refusal(call, **AERODYNAMICS, **OTHERS, **{name: 1.0}).startswith(name)


def test_aerodynamics_that_do_not_broadcast_are_refused():
    message = refusal(
        tvclin.Vehicle.from_aerodynamics,
        **AERODYNAMICS | {"dynamic_pressure": [1e4, 2e4], "reference_area": [1.0, 2.0, 3.0]},
        **OTHERS,
    )
    assert "dynamic_pressure (2,)" in message


def test_the_control_force_is_the_thrust_unless_a_slope_is_given():
    gimballed = tvclin.Vehicle(**NUMBERS | {"control_force_slope": None})
    assert gimballed.control_force == 2.495e6
    assert tvclin.Vehicle(**NUMBERS).control_force == 1e6


def test_the_mass_is_the_weight_over_standard_gravity():
    assert tvclin.Vehicle(**NUMBERS | {"weight": 9.80665e5}).mass == pytest.approx(1e5, rel=1e-15)


def test_a_vehicle_cannot_be_changed(configuration_i):
    with pytest.raises(dataclasses.FrozenInstanceError):
        configuration_i.thrust = 1.0


def test_arrays_in_a_vehicle_are_copies_that_cannot_be_changed():
    thrust = np.array([1e6, 2e6])
    vehicle = tvclin.Vehicle(**NUMBERS | {"thrust": thrust})
    thrust[0] = -1.0
    assert vehicle.thrust.tolist() == [1e6, 2e6]
    with pytest.raises(ValueError, match="read-only"):
        vehicle.thrust[0] = 1.0


def test_single_numbers_stay_python_floats(configuration_i):
    assert all(
        type(getattr(configuration_i, name)) is float
        for name in OTHERS
        if name != "control_force_slope"
    )
    assert type(tvclin.Vehicle(**NUMBERS | {"weight": np.int64(5)}).weight) is float


def test_vehicles_come_in_batches_that_broadcast():
    vehicle = tvclin.Vehicle(
        **NUMBERS | {"thrust": [1e6, 2e6, 3e6], "weight": [[1e6], [2e6]], "time": None}
    )
    assert np.broadcast_shapes(vehicle.thrust.shape, vehicle.weight.shape) == (2, 3)
    assert vehicle.velocity == 538.81


@pytest.mark.parametrize(("factor", "doubted"), [(1.0, False), (1e-3, True), (1e3, True)])
def test_an_inertia_with_another_prefix_is_doubted(factor, doubted):
    """A slender body has a radius of gyration of 0.5 to 1 times its control arm."""
    inertia = factor * NUMBERS["moment_of_inertia"]
    warnings = list(vehicle_warnings(tvclin.Vehicle(**NUMBERS | {"moment_of_inertia": inertia})))
    assert any("the unit of the moment of inertia" in warning for warning in warnings) == doubted


@pytest.mark.parametrize(("factor", "doubted"), [(1.0, False), (180.0 / np.pi, True)])
def test_slopes_of_a_mode_in_degrees_are_doubted(factor, doubted):
    vehicle = tvclin.load_vehicle("made-up-booster")
    modes = tuple(
        dataclasses.replace(mode, attitude_slope=factor * mode.attitude_slope, rate_slope=0.0)
        for mode in vehicle.structure.bending
    )
    structure = dataclasses.replace(vehicle.structure, bending=modes)
    warnings = list(vehicle_warnings(vehicle.replace(structure=structure)))
    assert any("a slope of bending mode" in warning for warning in warnings) == doubted
