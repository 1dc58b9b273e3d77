"""The flexible plant against the rigid one, a beam, arbitrary precision, and its invariances."""

from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest

import tvclin as tv
from tests.flexible import BOOSTER, ENGINE, MODES, STRUCTURE, TANKS, transfer

MODELS = ("fixed-path", "drift-exact", "drift-and-speed")
EPS = np.finfo(float).eps
SHAPE = (
    *("gimbal_displacement", "gimbal_slope", "attitude_slope", "rate_slope"),
    "pressure_displacement",
)
PULSE = tv.TriangularWind(peak=0.05, duration=7.5)
POINTS = (0.3 + 0.2j, 0.5j, 2.9j, 14j, 31j, -0.4 + 64j)


def flexible(structure=STRUCTURE, model="drift-exact", vehicle=BOOSTER, plane="pitch"):
    return tv.FlexiblePlant.from_vehicle(vehicle, structure, model, plane)


def precise(vehicle, structure, model, plane, s):
    """Return the outputs from deflection, wind and deflection acceleration, from M, C, K itself.

    All in 40 digits: (M s^2 + C s + K) q = forces, with the path as further unknowns.
    """
    number = lambda x: mp.mpf(float(x))  # noqa: E731
    v = {name: number(getattr(vehicle, name)) for name in vehicle.__dataclass_fields__ if name
         not in {"name", "numbers_from", "time", "control_force_slope", "structure"}}  # fmt: skip
    g, s = mp.mpf("9.80665"), mp.mpc(s)
    m, T, F, N = v["weight"] / g, v["thrust"], v["axial_force"], v["normal_force_slope"]
    a, modes, tanks = (T - F) / m, structure.bending, structure.slosh
    b, n = 2 + len(modes), 2 + len(modes) + len(tanks)
    up = [mp.mpf(1), -v["control_arm"], *(number(one.gimbal_displacement) for one in modes)]
    turn = [mp.mpf(0), mp.mpf(1), *(number(one.gimbal_slope) for one in modes)]
    air = [mp.mpf(1), v["aerodynamic_arm"], *(number(one.pressure_displacement) for one in modes)]
    left, right = mp.zeros(n + 2), mp.zeros(n + 2, 3)  # the last two unknowns: gamma and u
    left[0, 0] = m * s**2
    left[1, 1] = v["moment_of_inertia"] * s**2 + v["pitch_damping"] * s
    for i, mode in enumerate(modes, start=2):
        M, w, zeta = (number(x) for x in (mode.modal_mass, mode.frequency, mode.damping))
        left[i, i] = M * (s**2 + 2 * zeta * w * s + w**2)
    for k, tank in enumerate(tanks):
        j, mass = b + k, number(tank.mass)
        w2 = a / number(tank.pendulum_length)
        phi = [mp.mpf(1), number(tank.station), *(number(x.tank_displacements[k]) for x in modes)]
        sigma = [mp.mpf(0), mp.mpf(1), *(number(x.tank_slopes[k]) for x in modes)]
        left[j, j] = mass * (s**2 + 2 * number(tank.damping) * mp.sqrt(w2) * s + w2)
        for i in range(b):
            left[i, j] += mass * (phi[i] * s**2 - a * sigma[i])
            left[j, i] += mass * (phi[i] * s**2 - a * sigma[i])
    left[0, 1] -= T - F
    path = model != "fixed-path"
    for i in range(b):
        left[i, 1] -= N * air[i]
        left[i, n] += N * air[i] * path
        right[i, 1] = -N * air[i]
        right[i, 0] = T * up[i]
        if i >= 2 and structure.thrust_follows:
            left[0, i] -= T * turn[i]
            left[1, i] += T * (v["control_arm"] * turn[i] + up[i])
        if structure.engine is not None:
            mass, arm = number(structure.engine.mass), number(structure.engine.arm)
            s_E, J_E = mass * arm, number(structure.engine.moment_of_inertia) + mass * arm**2
            right[i, 0] -= s_E * a * turn[i]
            right[i, 2] = s_E * up[i] - J_E * turn[i]
    # V gamma' + V' gamma - V sqrt(q) u = z'', and u' = - sqrt(q) gamma.
    V, theta = v["velocity"], v["attitude"]
    slowing = a - g * mp.sin(theta)
    turning = g * mp.cos(theta) / V if plane == "pitch" and model == "drift-and-speed" else 0
    left[n, 0], left[n, n], left[n, n + 1] = s**2, -(V * s + slowing), V * turning
    left[n + 1, n], left[n + 1, n + 1] = turning, s
    computed = left**-1 * right
    rows = [[computed[1, k], s * computed[1, k], computed[n, k]] for k in range(3)]
    columns = []
    for k, row in enumerate(rows):
        alpha = row[0] - path * row[2] - (k == 1)
        sensed = row[0] + sum(
            number(x.attitude_slope) * computed[i, k] for i, x in enumerate(modes, 2)
        )
        rate = s * (
            row[0] + sum(number(x.rate_slope) * computed[i, k] for i, x in enumerate(modes, 2))
        )
        if structure.rate_gyro is not None:
            w, zeta = mp.mpf(120), mp.mpf(0.7)
            rate *= w**2 / (s**2 + 2 * zeta * w * s + w**2)
        columns.append([*(row if path else row[:2]), alpha, sensed, rate])
    return np.array([[complex(x) for x in column] for column in columns]).T


@pytest.mark.parametrize("damping", [0.0, 0.5])
@pytest.mark.parametrize("plane", ["pitch", "yaw"])
@pytest.mark.parametrize("model", MODELS)
def test_state_space_is_the_second_order_equations_solved_in_forty_digits(model, plane, damping):
    vehicle = BOOSTER.replace(pitch_damping=damping * BOOSTER.moment_of_inertia)
    plant = flexible(model=model, plane=plane, vehicle=vehicle)
    A, B, C, D = plant.matrices()
    with mp.workdps(40):
        for s in POINTS:
            exact = precise(vehicle, STRUCTURE, model, plane, s)
            transfer_function = transfer((A, B, C, D), s)
            # Backward error of the solution: eps times the sizes of what is added up.
            inside = np.linalg.inv(s * np.eye(len(A)) - A)
            sizes = np.abs(C) @ np.abs(inside) @ (np.abs(A) + abs(s) * np.eye(len(A)))
            bound = 30 * EPS * (sizes @ np.abs(inside) @ np.abs(B) + np.abs(D))
            assert np.all(np.abs(transfer_function - exact) <= bound)
            assert np.all(bound[0] < 1e-9 * np.abs(exact[0]))  # the bound says something


@pytest.mark.parametrize("plane", ["pitch", "yaw"])
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("name", ["configuration-i", "configuration-ii"])
def test_without_structure_it_is_the_rigid_plant(name, model, plane):
    vehicle = tv.load_vehicle(name)
    plant = flexible(tv.Structure(), model, vehicle, plane)
    rigid = tv.Plant.from_vehicle(vehicle, model, plane)
    assert plant.states == rigid.states
    assert plant.outputs[:-2] == rigid.outputs
    assert plant.rigid == rigid
    v = vehicle
    momentum = v.mass * v.velocity
    size = (v.thrust + v.axial_force + v.normal_force_slope + v.weight) / momentum
    for mine, other in zip(plant.matrices(), rigid.matrices(), strict=True):
        # Sums of the forces over m V_n, in another order, and products of three numbers.
        few = mine[: len(other)]
        np.testing.assert_allclose(few, other, rtol=4 * EPS, atol=8 * EPS * size)
    np.testing.assert_array_equal(plant.matrices()[2][-2:], np.eye(2, len(plant.states)))


def test_modal_normalisation_is_free():
    """All displacements and slopes times c, all modal masses times c^2."""
    for c in (4.0, 1e-3, 37.0):
        changed = []
        for mode in MODES:
            scaled = {name: c * getattr(mode, name) for name in SHAPE}
            for name in ("tank_displacements", "tank_slopes"):
                scaled[name] = tuple(c * one for one in getattr(mode, name))
            changed.append(replace(mode, modal_mass=c**2 * mode.modal_mass, **scaled))
        plant, other = flexible(), flexible(replace(STRUCTURE, bending=tuple(changed)))
        for s in POINTS:
            one, two = transfer(plant.matrices(), s), transfer(other.matrices(), s)
            np.testing.assert_allclose(two, one, rtol=1e-9, atol=1e-13 * np.abs(one).max())


def test_two_half_tanks_are_one():
    first, second = TANKS
    half = replace(first, mass=first.mass / 2)
    modes = tuple(
        replace(
            mode,
            tank_displacements=(mode.tank_displacements[0], *mode.tank_displacements),
            tank_slopes=(mode.tank_slopes[0], *mode.tank_slopes),
        )
        for mode in MODES
    )
    halves = replace(STRUCTURE, bending=modes, slosh=(half, half, second))
    for s in POINTS:
        one, two = transfer(flexible().matrices(), s), transfer(flexible(halves).matrices(), s)
        np.testing.assert_allclose(two, one, rtol=1e-9, atol=1e-13 * np.abs(one).max())


def test_a_stiff_structure_is_the_rigid_vehicle():
    """All frequencies times k: what is left of the shift falls with k^2."""
    left = []
    for k in (10.0, 100.0):
        stiff = replace(
            STRUCTURE,
            engine=None,
            bending=tuple(replace(mode, frequency=k * mode.frequency) for mode in MODES),
            slosh=tuple(
                replace(tank, pendulum_length=tank.pendulum_length / k**2) for tank in TANKS
            ),
        )
        left.append(flexible(stiff).shift().fast_pole / 100.0)
    assert abs(left[1]) < 1e-6
    assert left[0] / left[1] == pytest.approx(100.0, rel=0.01)


def beam(count, station):
    """Return the first modes of a uniform free-free beam of unit length, mass and stiffness.

    cosh k cos k = 1; normalised to 2 at both ends. The gimbal is at -1/2, the sensors at `station`.
    """
    modes = []
    for i in range(1, count + 1):
        k = (i + 0.5) * np.pi
        for _ in range(5):
            k -= (np.cos(k) - 1.0 / np.cosh(k)) / (-np.sin(k) + np.tanh(k) / np.cosh(k))
        ratio = (np.cosh(k) - np.cos(k)) / (np.sinh(k) - np.sin(k))
        # From the aft end; cosh - ratio sinh in exponentials, which cancel where k is large.
        grow = (1.0 - ratio) / 2.0 if i < 8 else (np.cos(k) - np.sin(k)) * np.exp(-k)

        def slope(y, k=k, ratio=ratio, grow=grow):
            rise = grow * np.exp(k * y) - (1.0 + ratio) / 2.0 * np.exp(-k * y)
            return k * (rise - np.sin(k * y) - ratio * np.cos(k * y))

        y = station + 0.5
        seen = {"attitude_slope": slope(y), "rate_slope": slope(y)}
        end = {"gimbal_displacement": 2.0, "gimbal_slope": slope(0.0)}
        modes.append(
            tv.vehicle.BendingMode(frequency=k**2, damping=0.0, modal_mass=1.0, **end, **seen)
        )
    return tuple(modes)


def test_many_modes_of_a_uniform_beam_are_the_beam():
    """The slope along a free beam that is pushed at its end, from w'''' = omega^2 w itself."""
    g = 9.80665
    weightless = tv.Vehicle(
        weight=g,
        moment_of_inertia=1.0 / 12.0,
        normal_force_slope=0.0,
        thrust=1.0,
        axial_force=1.0,
        aerodynamic_arm=0.0,
        control_arm=0.5,
        velocity=1.0,
        attitude=0.0,
    )
    count, station, omega = 40, 0.2, 35.0  # between the first mode, 22.4, and the second, 61.7
    structure = tv.Structure(bending=beam(count, station), thrust_follows=False)
    plant = tv.FlexiblePlant(
        weightless, structure, "fixed-path"
    )  # without the warnings of from_vehicle
    np.testing.assert_allclose(
        np.sort(np.abs(plant.poles))[2::2], [m.frequency for m in structure.bending], rtol=1e-11
    )
    computed = transfer(plant.matrices(), 1j * omega)[plant.outputs.index("sensed_attitude"), 0]
    # w = A cosh + B sinh + C cos + D sin of k y; w'' = 0 at both ends, w''' = -1 and 0: y = 0, 1.
    k = np.sqrt(omega)
    ends = np.array(
        [
            [1.0, 0.0, -1.0, 0.0],
            [np.cosh(k), np.sinh(k), -np.cos(k), -np.sin(k)],
            [0.0, 1.0, 0.0, -1.0],
            [np.sinh(k), np.cosh(k), np.sin(k), -np.cos(k)],
        ]
    )
    # A unit force up at y = 0 is the shear there: w'''(0) = +1 for EI = 1 (dQ/dy = -mass w'').
    A, B, C, D = np.linalg.solve(ends, [0.0, 0.0, 1.0 / k**3, 0.0])
    y = station + 0.5
    exact = k * (A * np.sinh(k * y) + B * np.cosh(k * y) - C * np.sin(k * y) + D * np.cos(k * y))
    # Modes left out: |phi| = 2, |slope| < 3 k_i, and k_i^4 - omega^2 > 0.99 k_i^4.
    tail = sum(6.0 * ((i + 0.5) * np.pi) ** -3 / 0.99 for i in range(count + 1, 2000))
    assert tail < 0.01 * abs(exact)
    assert abs(computed - exact) < tail


def test_an_engine_swings_against_its_own_force_at_the_tail_wags_dog_frequency():
    plant = flexible(tv.Structure(engine=ENGINE), "fixed-path")
    a = (BOOSTER.thrust - BOOSTER.axial_force) / BOOSTER.mass
    s_E, J_E = ENGINE.static_moment, ENGINE.inertia_about_gimbal
    pushed = BOOSTER.thrust * BOOSTER.control_arm + s_E * a
    frequency = np.sqrt(pushed / (J_E + s_E * BOOSTER.control_arm))
    assert frequency == pytest.approx(47.13889, abs=1e-5)
    row = transfer(plant.matrices(), 1j * frequency)[0]
    assert abs(row[0] - frequency**2 * row[2]) < 8 * EPS * abs(row[0])


def test_the_made_up_booster_has_its_poles():
    """As an independent program computed them, from the same equations."""
    expected = [0.50775401, 0.01285418]
    for pole in (
        *(-0.02886933 + 2.82951565j, -0.03113566 + 3.04071225j, -0.07073674 + 13.78981688j),
        *(-0.16111166 + 31.03421522j, -0.34971683 + 64.96177493j),
    ):
        expected += [pole, np.conj(pole)]
    np.testing.assert_allclose(flexible().poles, [*expected, -0.54585651], atol=6e-9)


def test_shift_is_what_pole_and_residues_do():
    batch = tv.Structure(slosh=TANKS, rate_gyro=tv.vehicle.Filter.low_pass([100.0, 200.0]))
    for structure in (STRUCTURE, replace(STRUCTURE, engine=None), batch):
        plant = flexible(structure)
        result = plant.shift()
        rigid = tv.unstable_modes(plant.rigid)
        p, stiff = np.max(plant.poles.real, axis=-1), rigid.poles[0]
        np.testing.assert_allclose(result.fast_pole, 100.0 * (p / stiff - 1.0), rtol=1e-9)
    plant = flexible()
    near = plant.poles[0].real + 1e-6  # the residue outweighs all else there by a million
    row = transfer(plant.matrices(), near)[0]
    price = (row[1] / (row[0] + near**2 * row[2])).real
    was = rigid.wind_residues[0] / rigid.deflection_residues[0]
    assert plant.shift().trim_price == pytest.approx(100.0 * (price / was - 1.0), abs=1e-3)
    assert plant.shift().trim_price == pytest.approx(0.9, abs=0.05)
    assert plant.shift().fast_pole == pytest.approx(-0.5, abs=0.05)


def test_no_structure_shifts_nothing():
    shift = flexible(tv.Structure()).shift()
    np.testing.assert_allclose(shift, 0.0, atol=1e-10)


def test_a_thousand_dispersed_frequencies_are_one_call():
    chance = np.random.default_rng(4)
    factors = chance.uniform(0.8, 1.2, (1000, 3))
    modes = tuple(
        replace(mode, frequency=mode.frequency * factors[:, k]) for k, mode in enumerate(MODES)
    )
    structure = replace(
        STRUCTURE, bending=modes, rate_gyro=tv.vehicle.Filter.low_pass([[90.0], [120.0]])
    )
    every = flexible(structure)
    assert every.batch == (2, 1000)
    assert [matrix.shape for matrix in every.matrices()] == [
        *((2, 1000, 14, 14), (2, 1000, 14, 3), (2, 1000, 6, 14), (2, 1000, 6, 3))
    ]
    for i in (0, 999):
        modes = tuple(
            replace(mode, frequency=mode.frequency * factors[i, k]) for k, mode in enumerate(MODES)
        )
        gyro = tv.vehicle.Filter.low_pass(120.0)
        one = flexible(replace(STRUCTURE, bending=modes, rate_gyro=gyro))
        for mine, batch in zip(one.matrices(), every.matrices(), strict=True):
            size = np.abs(mine).max()
            np.testing.assert_allclose(batch[1, i], mine, rtol=1e-12, atol=4 * EPS * size)
    assert every.shift().fast_pole.shape == (2, 1000)


def test_python_control_sees_the_same_plant():
    plant = flexible(replace(STRUCTURE, attitude_sensor=tv.vehicle.Filter.lead_lag(-40.0, 40.0)))
    system = plant.ss()
    assert tuple(system.state_labels) == plant.states
    assert tuple(system.input_labels) == ("deflection", "wind", "deflection_acceleration")
    assert tuple(system.output_labels) == plant.outputs
    assert plant.states[-3:] == ("attitude_sensor_1", "rate_gyro_1", "rate_gyro_2")
    for s in POINTS:
        np.testing.assert_allclose(system(s), transfer(plant.matrices(), s), rtol=1e-9, atol=1e-12)
    bare = flexible(replace(STRUCTURE, rate_gyro=None))
    for s in POINTS:
        one, two = transfer(bare.matrices(), s), transfer(plant.matrices(), s)
        lag = np.array([1, 1, 1, 1, (40 - s) / (40 + s), tv.vehicle.Filter.low_pass(120.0, 0.7)(s)])
        np.testing.assert_allclose(two, one * lag[:, None], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: flexible(model="drift"), 'use "drift-exact"'),
        (lambda: flexible(model="drifting"), "model must be one of fixed-path"),
        (
            lambda: flexible(vehicle=BOOSTER.replace(axial_force=3e7)),
            "pendulum_length needs a thrust",
        ),
        (
            lambda: flexible(tv.Structure(slosh=(replace(TANKS[0], mass=2e6),))),
            "slosh and engine weigh more than the vehicle",
        ),
        (
            lambda: flexible(tv.Structure(engine=replace(ENGINE, mass=2e6))),
            "slosh and engine weigh more than the vehicle",
        ),
        (lambda: flexible(vehicle=BOOSTER.replace(thrust=[2e7, 3e7])).ss(), "for one system"),
        (
            lambda: flexible(
                tv.Structure(), "fixed-path", BOOSTER.replace(aerodynamic_arm=-1.0)
            ).shift(),
            "growing mode",
        ),
        (
            lambda: flexible(
                replace(STRUCTURE, rate_gyro=tv.vehicle.Filter.low_pass([1.0, 2.0])),
                vehicle=BOOSTER.replace(thrust=[2e7, 2e7, 2e7]),
            ),
            "must have shapes that broadcast",
        ),
        (lambda: tv.vehicle.Engine(mass=1.0, arm=0.0), "needs an arm or a moment_of_inertia"),
        (lambda: replace(MODES[0], damping=-0.01), "damping must be between 0"),
        (lambda: replace(TANKS[0], frequency=2.0), "needs a pendulum_length or a frequency"),
        (lambda: tv.boundary_limit(flexible(), PULSE), "FlexiblePlant has .rigid, and .shift"),
        (lambda: tv.linear.all_modes(flexible()), "FlexiblePlant has .rigid, and .shift"),
    ],
)
def test_what_no_plant_can_be_made_of_is_refused_in_one_sentence(make, said):
    with pytest.raises(tv.InputError, match=said):
        make()


def test_a_mode_without_damping_is_told():
    undamped = tv.Structure(bending=(replace(MODES[0], damping=0.0, tank_displacements=(),
                                             tank_slopes=()),))  # fmt: skip
    with pytest.warns(UserWarning, match="bending mode 1 has no damping"):
        flexible(undamped)
