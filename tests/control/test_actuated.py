"""A plant with its actuator: against the product of both, and the open loops of two check cases."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar, newton

import tvclin as tv
from tests.flexible import BOOSTER, STRUCTURE, transfer
from tvclin.control.autopilot.actuator import INPUTS, plant_with_actuator

ACTUATOR = tv.Actuator(natural_frequency=22.0, damping=0.8)


def booster(structure=STRUCTURE):
    return tv.FlexiblePlant.from_vehicle(BOOSTER, structure, "drift-exact")


@pytest.mark.parametrize(
    ("plant", "actuator"),
    [
        (booster(), ACTUATOR),
        (booster(tv.Structure(bending=(), slosh=STRUCTURE.slosh)), tv.Actuator(damping=None)),
        (tv.Plant.from_vehicle(BOOSTER, "drift"), ACTUATOR),
        (tv.Plant.from_vehicle(BOOSTER, "fixed-path"), None),
    ],
)
@pytest.mark.parametrize("s", [0.4 + 0.3j, 5j, 33j])
def test_it_is_actuator_times_plant(plant, actuator, s):
    result = plant_with_actuator(plant, actuator)
    assert result.outputs == (*plant.outputs, "deflection")
    system = transfer(result.matrices(), s)
    single = transfer(plant.matrices(), s)
    lag = 1.0 if actuator is None else actuator.tf()(s)
    # What the command does, with the inertia of the engine; the disturbance turns the thrust alone.
    inertia = s**2 * single[:, 2] if single.shape[1] > 2 else 0.0
    outputs = [lag * (single[:, 0] + inertia), single[:, 0], single[:, 1]]
    for k, (expected, deflection) in enumerate(zip(outputs, (lag, 1.0, 0.0), strict=True)):
        scale = np.abs(expected).max()
        np.testing.assert_allclose(system[:-1, k], expected, rtol=1e-9, atol=1e-12 * scale)
        assert system[-1, k] == pytest.approx(deflection, abs=1e-12)


def test_a_batch_of_plants_and_one_of_actuators_are_each_pair():
    vehicles = BOOSTER.replace(thrust=np.array([[2.4e7], [2.5e7]]))
    plants = tv.FlexiblePlant.from_vehicle(vehicles, STRUCTURE, "drift-exact")
    every = plant_with_actuator(
        plants, tv.Actuator(natural_frequency=[20.0, 22.0, 24.0], damping=0.8)
    )
    assert [matrix.shape for matrix in every.matrices()] == [
        *((2, 3, 17, 17), (2, 3, 17, len(INPUTS)), (2, 3, 7, 17), (2, 3, 7, len(INPUTS)))
    ]
    vehicle = BOOSTER.replace(thrust=2.5e7)
    one = plant_with_actuator(
        tv.FlexiblePlant.from_vehicle(vehicle, STRUCTURE, "drift-exact"), ACTUATOR
    )
    for mine, batch in zip(one.matrices(), every.matrices(), strict=True):
        atol = 1e-15 * np.abs(mine).max(initial=0.0)
        np.testing.assert_allclose(batch[1, 1], mine, rtol=1e-12, atol=atol)


@pytest.mark.parametrize("actuator", [None, tv.Actuator(damping=None)])
def test_an_engine_with_inertia_needs_an_actuator_of_second_order(actuator):
    with pytest.raises(tv.InputError, match="needs an actuator of second order"):
        plant_with_actuator(booster(), actuator)


def loop_of(plant, actuator, gains, filters=(), delay=0.0):
    """Return L(s), which is minus what returns for a command, so that 1 + L = 0."""
    system = plant_with_actuator(plant, actuator)
    places = [system.outputs.index(f"sensed_attitude{end}") for end in ("", "_rate")]

    def loop(s):
        seen = transfer(system.matrices(), s)[places, 0]
        shaped = np.prod([one(s) for one in filters]) if filters else 1.0
        return -np.dot(gains, seen) * shaped * np.exp(-delay * s)

    return loop


def test_the_made_up_booster_has_its_open_loop():
    """As an independent program computed it, from the same equations."""
    filters = tv.vehicle.Filter.low_pass(13.0, 0.95), tv.vehicle.Filter.notch(32.0, 0.06, 0.6)
    loop = loop_of(booster(), ACTUATOR, (0.36, 0.56), filters, delay=0.02)
    for omega, expected in {
        0.5: -1.98274061 - 1.02175840j,
        5.0: -0.40067520 - 0.01350961j,
        14.0: -1.14316925 - 4.95323008j,
    }.items():
        assert loop(1j * omega) == pytest.approx(expected, abs=2e-8)


HERTZ = 2.0 * np.pi
NOTCH = tv.vehicle.Filter.notch(12.0 * HERTZ, 0.05, 0.5)


def lesson(frequency, share=5e-4):
    """Return the loop of a lesson on bending: a mode beside mu_delta/(s^2 - mu_alpha).

    It adds share w^2/(s^2 + 2 zeta w s + w^2) to 10/(s^2 - 1), seen by both sensors: phi = 1, and
    sigma = -share w^2 M/T. Gains 5 and 1.26, actuator 10 Hz with damping 0.7.
    """
    vehicle = tv.Vehicle(
        weight=9.80665,
        moment_of_inertia=1.0,
        normal_force_slope=1.0,
        thrust=10.0,
        aerodynamic_arm=1.0,
        control_arm=1.0,
        axial_force=10.0,
        velocity=1.0,
        attitude=0.0,
    )
    w = frequency * HERTZ
    slope = -share * w**2 / vehicle.thrust
    mode = tv.vehicle.BendingMode(
        frequency=w,
        damping=0.005,
        modal_mass=1.0,
        gimbal_displacement=1.0,
        gimbal_slope=0.0,
        attitude_slope=slope,
        rate_slope=slope,
    )
    structure = tv.Structure(bending=(mode,), thrust_follows=False)
    return tv.FlexiblePlant.from_vehicle(vehicle, structure, "fixed-path")


@pytest.mark.parametrize(
    ("frequency", "share", "filters", "peak", "at", "pole"),
    [
        (12.0, 5e-4, (), 8.7606, 12.0017, 0.013569 + 76.445033j),
        (12.0, 5e-4, (NOTCH,), -11.2394, 12.0017, -0.349562 + 75.489167j),
        (13.2, 5e-4, (NOTCH,), -5.0782, 13.2040, -0.533833 + 83.141470j),
        (3.0, 5e-4, (), 3.6043, None, -0.236727 + 18.832807j),
        (3.0, -5e-4, (), 3.6194, None, 0.046225 + 18.863751j),
    ],
)
def test_the_lesson_on_bending_has_its_peak_and_its_closed_pole(
    frequency, share, filters, peak, at, pole
):
    actuator = tv.Actuator(natural_frequency=10.0 * HERTZ, damping=0.7)
    loop = loop_of(lesson(frequency, share), actuator, (5.0, 1.26), filters)
    size = lambda f: -20.0 * np.log10(abs(loop(1j * f * HERTZ)))  # noqa: E731
    near = frequency * 0.98, frequency * 1.02
    top = minimize_scalar(size, bounds=near, method="bounded", options={"xatol": 1e-9})
    assert -top.fun == pytest.approx(peak, abs=6e-5)
    assert at is None or top.x == pytest.approx(at, abs=6e-5)
    root = newton(lambda s: 1.0 + loop(s), pole, tol=1e-12)
    assert root == pytest.approx(pole, abs=1e-6)


def test_the_lesson_crosses_over_where_it_says():
    actuator = tv.Actuator(natural_frequency=10.0 * HERTZ, damping=0.7)
    bare = loop_of(lesson(12.0), actuator, (5.0, 1.26))
    for f in (2.06624, 11.85995, 12.16750):
        # To five decimals of a hertz: the slope of ln |L| over f tells how far |L| may be off.
        around = [abs(bare(1j * (f + d) * HERTZ)) for d in (-1e-5, 1e-5)]
        assert (around[0] - 1.0) * (around[1] - 1.0) < 0.0
    notched = loop_of(lesson(12.0), actuator, (5.0, 1.26), (NOTCH,))
    value = notched(2.03827j * HERTZ)
    assert abs(value) == pytest.approx(1.0, abs=1e-5)
    assert np.degrees(np.angle(-value)) == pytest.approx(47.28655, abs=1e-3)
