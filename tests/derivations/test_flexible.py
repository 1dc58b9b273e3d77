"""The flexible plant from the energies of its parts: body, mode, pendulum, sliding mass, engine."""

import functools
import random
from itertools import chain

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad, solve_ivp

import tvclin as tv
from tests.turns import usual
from tvclin.linear.motions import motions

SMALL = UP, TURNED, BENT, HUNG, SLID, STEERED = sp.symbols("z theta eta psi zeta delta")
FREE, ALPHA = SMALL[:-1], sp.symbols("alpha")


def numbers(seed):
    """Return rational numbers of a vehicle, of which the parts are two pieces of hull and the rest.

    The last four are what makes the frame that of the whole: its centre of gravity at zero, and a
    mode that neither moves nor turns it.
    """
    chance = random.Random(seed)
    names = (
        *("m_1", "m_2", "I_1", "I_2", "x_2", "m_p", "x_p", "L", "m_s", "x_s", "k_s"),
        *("m_E", "l_E", "I_E", "l_c", "l_a", "T", "F_A", "N", "omega", "phi_g", "sigma_g"),
        *("phi_p", "sigma_p", "phi_s", "sigma_s", "sigma_1", "sigma_2", "phi_a", "alpha"),
    )
    n = {name: sp.Rational(chance.randint(20, 99), 30) for name in names}
    n |= {"m_1": n["m_1"] + 9, "m_2": n["m_2"] + 9, "T": n["T"] + 40, "l_c": n["l_c"] + 5}
    x_1, phi_1, phi_2 = sp.symbols("x_1 phi_1 phi_2")
    x_E = -n["l_c"] - n["l_E"]
    # The engine's own centre of gravity moves with the gimbal and its slope.
    phi_E = n["phi_g"] - n["l_E"] * n["sigma_g"]
    masses = [n[k] for k in ("m_1", "m_2", "m_p", "m_s", "m_E")]
    stations = [x_1, n["x_2"], n["x_p"], n["x_s"], x_E]
    balance = sum(m * x for m, x in zip(masses, stations, strict=True))
    n["x_1"] = sp.solve(balance, x_1)[0]
    stations[0] = n["x_1"]
    moved = [phi_1, phi_2, n["phi_p"], n["phi_s"], phi_E]
    turned = n["I_1"] * n["sigma_1"] + n["I_2"] * n["sigma_2"] + n["I_E"] * n["sigma_g"]
    both = [
        sum(m * phi for m, phi in zip(masses, moved, strict=True)),
        sum(m * x * phi for m, x, phi in zip(masses, stations, moved, strict=True)) + turned,
    ]
    n |= {str(k): value for k, value in sp.solve(both, [phi_1, phi_2]).items()}
    moved[:2] = n["phi_1"], n["phi_2"]
    inertias = n["I_1"] + n["I_2"] + n["I_E"]
    n["m"] = sum(masses)
    n["I"] = inertias + sum(m * x**2 for m, x in zip(masses, stations, strict=True))
    n["M"] = sum(m * phi**2 for m, phi in zip(masses, moved, strict=True)) + (
        n["I_1"] * n["sigma_1"] ** 2 + n["I_2"] * n["sigma_2"] ** 2 + n["I_E"] * n["sigma_g"] ** 2
    )
    return n


def placed(x, y):
    """Return where a point of the body frame is, from the steady motion along the nominal axis."""
    c, s = sp.cos(TURNED), sp.sin(TURNED)
    return sp.Matrix([c * x - s * y, UP + s * x + c * y])


def branch(x, phi, sigma, along, across):
    """Return a point that hangs on the hull at x, which bends there; along and across the hull."""
    c, s = sp.cos(sigma * BENT), sp.sin(sigma * BENT)
    return placed(x + c * along - s * across, phi * BENT + s * along + c * across)


@functools.cache
def lagrange(seed):
    """Return the numbers, and M, K and the forces of M q'' + K q = forces (delta, delta'', alpha).

    Lagrange's equations are sum m p''.dp/dq = work. About a steady acceleration a along the axis
    their linear part is M = sum m dp/dq.dp/dq, and K = sum m a d2p_x/dq2 less dwork/dq.
    """
    n = numbers(seed)
    L, l_c, l_E = n["L"], n["l_c"], n["l_E"]
    engine = TURNED + n["sigma_g"] * BENT + STEERED
    # At the hinge, L ahead of the mass at rest, the hull has moved by phi_p + L sigma_p.
    hung = -L * sp.cos(HUNG), L * sp.sin(HUNG)
    nozzle = -l_E * sp.cos(STEERED), -l_E * sp.sin(STEERED)
    points = [
        *((n[f"m_{k}"], placed(n[f"x_{k}"], n[f"phi_{k}"] * BENT)) for k in (1, 2)),
        (n["m_p"], branch(n["x_p"] + L, n["phi_p"] + L * n["sigma_p"], n["sigma_p"], *hung)),
        (n["m_s"], branch(n["x_s"], n["phi_s"], n["sigma_s"], 0, SLID)),
        (n["m_E"], branch(-l_c, n["phi_g"], n["sigma_g"], *nozzle)),
    ]
    turning = [
        *((n[f"I_{k}"], TURNED + n[f"sigma_{k}"] * BENT) for k in (1, 2)),
        (n["I_E"], engine),
    ]
    a = (n["T"] - n["F_A"]) / n["m"]
    mass, stiff = sp.zeros(5, 6), sp.zeros(5, 6)
    for m, point in points:
        moves = at_rest(point.jacobian(SMALL))
        mass += m * (moves.T * moves)[:5, :]
        stiff += m * a * at_rest(sp.hessian(point[0], SMALL))[:5, :]
    for inertia, angle in turning:
        turns = sp.Matrix([angle]).jacobian(SMALL)
        mass += inertia * (turns.T * turns)[:5, :]
    stiff[4, 4] += n["k_s"]
    # The work of thrust, drag and normal force on each motion.
    axis, side = (sp.Matrix([sp.cos(TURNED + k), sp.sin(TURNED + k)]) for k in (0, sp.pi / 2))
    pushed, pressed = placed(-l_c, n["phi_g"] * BENT), placed(n["l_a"], n["phi_a"] * BENT)
    work = sp.Matrix(
        [
            n["T"] * (sp.cos(engine) * pushed[0].diff(q) + sp.sin(engine) * pushed[1].diff(q))
            - n["F_A"] * axis.dot(placed(0, 0).diff(q))
            + n["N"] * ALPHA * side.dot(pressed.diff(q))
            for q in FREE
        ]
    )
    stiff -= at_rest(work.jacobian(SMALL))
    forces = sp.Matrix.hstack(-stiff[:, 5], -mass[:, 5], at_rest(work.diff(ALPHA)))
    return n, mass[:, :5], stiff[:, :5], forces


def at_rest(expression):
    """Return the value where nothing is moved and no wind blows."""
    return expression.subs(dict.fromkeys((*SMALL, ALPHA), 0))


@pytest.mark.thorough
@pytest.mark.parametrize("seed", usual(range(3), 0))
def test_the_package_has_the_equations_of_lagrange(seed):
    """Every coefficient but the stiffness of the mode itself, which its frequency contains.

    The hull keeps its length to first order in the bending only: what it shortens by is of second
    order, and moves that one coefficient alone.
    """
    n, mass, stiff, forces = lagrange(seed)
    f = {name: float(value) for name, value in n.items()}
    amplitudes = sp.diag(1, 1, 1, n["L"], 1)  # zeta = L psi
    mass, stiff = mass * amplitudes.inv(), stiff * amplitudes.inv()
    assert mass[2, 2] == n["M"]
    stiff[2, 2] = n["M"] * n["omega"] ** 2
    stiffness, follows = (mass.inv() * one for one in (-stiff, forces))

    vehicle = tv.Vehicle(
        weight=f["m"] * 9.80665,
        moment_of_inertia=f["I"],
        normal_force_slope=f["N"],
        thrust=f["T"],
        aerodynamic_arm=f["l_a"],
        control_arm=f["l_c"],
        axial_force=f["F_A"],
        velocity=1.0,
        attitude=0.0,
    )
    mode = tv.vehicle.BendingMode(
        frequency=f["omega"],
        damping=0.0,
        modal_mass=f["M"],
        gimbal_displacement=f["phi_g"],
        gimbal_slope=f["sigma_g"],
        attitude_slope=0.0,
        rate_slope=0.0,
        pressure_displacement=f["phi_a"],
        tank_displacements=(f["phi_p"], f["phi_s"]),
        tank_slopes=(f["sigma_p"], f["sigma_s"]),
    )
    tanks = (
        tv.vehicle.SloshTank(mass=f["m_p"], station=f["x_p"], damping=0.0, pendulum_length=f["L"]),
        tv.vehicle.SloshTank(
            mass=f["m_s"], station=f["x_s"], damping=0.0, frequency=(f["k_s"] / f["m_s"]) ** 0.5
        ),
    )
    engine = tv.vehicle.Engine(mass=f["m_E"], arm=f["l_E"], moment_of_inertia=f["I_E"])
    result = motions(vehicle, tv.Structure(bending=(mode,), slosh=tanks, engine=engine))
    columns = [result.deflection, result.deflection_acceleration, result.angle_of_attack]
    expected = np.array(stiffness.tolist(), float), np.array(follows.tolist(), float)
    rounding = 1e-15 * float(np.linalg.cond(np.array(mass.tolist(), float))) * 10
    for mine, exact in zip((result.displacement, np.stack(columns, -1)), expected, strict=True):
        np.testing.assert_allclose(mine, exact, rtol=0.0, atol=rounding * np.abs(exact).max())
    assert not np.any(result.rate)


def swinging(t, state, push, numbers):
    """Return the rates of a rigid body with a pendulum, all angles as they are, no air.

    Newton and Euler for both with the tension of the pendulum as unknown; X and z are those of the
    body's centre of gravity, without liquid.
    """
    m, inertia, mass, length, hinge, arm, force = numbers
    theta, psi, rate, swing = state[4:]
    deflection = push(t)
    axis = np.array([np.cos(theta), np.sin(theta)])
    side = np.array([-axis[1], axis[0]])
    thrust = force * (np.cos(deflection) * axis + np.sin(deflection) * side)
    angle = theta - psi  # the pendulum hangs aft along -(cos, sin) of this
    along = np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-along[1], along[0]])
    # Unknowns: acceleration of the body, theta'', angle'', and the tension S along the pendulum.
    left, right = np.zeros((6, 6)), np.zeros(6)
    left[:2, :2], left[:2, 5] = m * np.eye(2), along
    right[:2] = thrust
    left[2, 2] = inertia
    left[2, 5] = hinge * (axis[0] * along[1] - axis[1] * along[0])
    right[2] = -arm * force * np.sin(deflection)
    turning = rate - swing
    # The liquid: S along = mass times its acceleration, that of the hinge and that about the hinge.
    left[3:5, :2], left[3:5, 2], left[3:5, 3] = np.eye(2), hinge * side, -length * across
    left[3:5, 5] = -along / mass
    right[3:5] = hinge * rate**2 * axis - length * turning**2 * along
    left[5, 3], left[5, 2], left[5, 4], right[5] = -1.0, 1.0, -1.0, 0.0  # psi'' = theta'' - angle''
    result = np.linalg.solve(left, right)
    return [*state[2:4], *result[:2], rate, swing, result[2], result[4]]


def test_a_pendulum_in_a_turning_accelerating_body_swings_as_the_plant_says():
    """All angles as they are: what differs falls with the square of the amplitude."""
    m, inertia, mass, length, rest, arm, force = 1.0e5, 4.0e6, 2.0e4, 2.5, 6.0, 11.0, 2.4e6
    whole = m + mass
    offset = mass * rest / m  # the body alone has its centre of gravity so far aft
    vehicle = tv.Vehicle(
        weight=whole * 9.80665,
        moment_of_inertia=inertia + m * offset**2 + mass * rest**2,
        normal_force_slope=0.0,
        thrust=force,
        aerodynamic_arm=1.0,
        control_arm=arm,
        axial_force=0.0,
        velocity=500.0,
        attitude=0.5,
    )
    tank = tv.vehicle.SloshTank(mass=mass, station=rest, damping=0.0, pendulum_length=length)
    plant = tv.FlexiblePlant(vehicle, tv.Structure(slosh=(tank,)), "fixed-path")
    A, B, *_ = plant.matrices()
    times, tight = np.linspace(0.5, 6.0, 12), {"rtol": 1e-11, "atol": 1e-14}
    shape = lambda t: np.sin(1.3 * t) * np.sin(0.4 * t)  # noqa: E731

    linear = solve_ivp(
        lambda t, x: A @ x + B[:, 0] * shape(t), (0.0, 6.0), np.zeros(4), "DOP853", times, **tight
    ).y
    # The hinge is a length ahead of the liquid at rest; arms from the body's centre of gravity.
    parts = (m, inertia, mass, length, rest + length + offset, arm - offset, force)
    left = []
    for size in (0.02, 0.04):
        flown = solve_ivp(
            lambda t, x, size=size: swinging(t, x, lambda t: size * shape(t), parts),
            *((0.0, 6.0), np.zeros(8), "DOP853", times),
            **tight,
        ).y
        attitude, slid = flown[4] / size, length * np.sin(flown[5]) / size
        off = [np.abs(attitude - linear[0]).max(), np.abs(slid - linear[2]).max()]
        left.append(off / np.abs(linear[[0, 2]]).max(axis=1))
    assert np.all(left[0] < 0.01)
    np.testing.assert_allclose(left[1] / left[0], 4.0, rtol=0.1)


def test_what_is_left_out_is_a_percent_or_two_of_the_square_of_a_frequency():
    """Axial load and following thrust on the diagonal of a uniform tube's first mode, per K."""
    vehicle = tv.load_vehicle("made-up-launcher")
    structure = vehicle.structure
    mode, k, length = structure.bending[0], 4.730040744862704, 20.0
    ratio = (np.cosh(k) - np.cos(k)) / (np.sinh(k) - np.sin(k))

    def slope(y):
        turned = np.sinh(k * y) - np.sin(k * y) - ratio * (np.cosh(k * y) + np.cos(k * y))
        return k / length * turned / 2

    # The hull carries T at the tail and F_A at the nose, and what it shortens by is slope^2/2.
    load = lambda y: vehicle.thrust - (vehicle.thrust - vehicle.axial_force) * y  # noqa: E731
    axial = quad(lambda y: load(y) * slope(y) ** 2 * length, 0.0, 1.0)[0]
    follows = -vehicle.thrust * mode.gimbal_displacement * mode.gimbal_slope
    stiffness = mode.modal_mass * mode.frequency**2
    assert -axial / stiffness == pytest.approx(-0.016, abs=0.0005)
    assert follows / stiffness == pytest.approx(0.0113, abs=0.0005)


@pytest.mark.thorough
def test_all_parts_are_in_the_equations():
    """Of the energies: a coefficient that no part moves would judge nothing."""
    _, mass, stiff, forces = lagrange(0)
    shared = [mass[b, k] for b in range(3) for k in (3, 4)]
    shared += [stiff[b, k] for b in (1, 2) for k in (3, 4)]
    assert all(value != 0 for value in chain(shared, forces[:3, 0], forces[:3, 1], forces[:3, 2]))
