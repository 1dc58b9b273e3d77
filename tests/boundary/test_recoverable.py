"""The recoverable set, against support functions, matrix exponentials and eq (B1)."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import expm
from scipy.optimize import minimize_scalar

import tvclin as tv
from tests.recoverable import are_recoverable, slow_range
from tvclin import Coefficients, InputError, Plant
from tvclin.boundary.forecast_free import UnstableCoordinates, unstable_coordinates

MODELS = ("fixed-path", "drift", "drift-exact")
EACH_MODEL = pytest.mark.parametrize("model", MODELS)
BOTH = pytest.mark.parametrize("name", ["configuration-i", "configuration-ii"])
PAIRS = [(0.5, 0.013), (1.0, 0.2), (0.8, 0.5), (2.0, 1.9)]
EACH_PAIR = pytest.mark.parametrize("poles", PAIRS)


def two(poles):
    """Return coordinates of two modes of which only the poles count."""
    return UnstableCoordinates(np.array(poles), np.eye(2), np.ones(2))


def plant_of(name, model):
    return Plant.from_vehicle(tv.load_vehicle(name), model)


def motion(vehicle, model, state, deflection, wind):
    """Return the rates of attitude, its rate and flight path angle, written out by hand."""
    v, mass = vehicle, vehicle.weight / 9.80665
    stiffness = v.normal_force_slope * v.aerodynamic_arm / v.moment_of_inertia
    power = v.thrust * v.control_arm / v.moment_of_inertia
    path = 0.0 if model == "fixed-path" else state[2]
    angle = state[0] - path - wind
    rates = [state[1], stiffness * angle - power * deflection]
    if model == "drift":
        b2 = v.thrust - v.axial_force - v.weight * np.sin(v.attitude)
        b1 = b2 + v.normal_force_slope * (1 + v.aerodynamic_arm / v.control_arm)
        b1, b2 = b1 / (mass * v.velocity), b2 / (mass * v.velocity)
        rates.append(b1 * deflection * power / stiffness + b2 * wind)
    if model == "drift-exact":
        lean = state[0] - path
        across = (v.thrust - v.axial_force) * np.sin(lean) + v.thrust * deflection * np.cos(lean)
        across += v.normal_force_slope * angle * np.cos(lean)
        across -= v.weight * np.cos(v.attitude + path)
        rates.append((across + v.weight * np.cos(v.attitude)) / (mass * v.velocity))
    return np.array(rates)


@BOTH
@EACH_MODEL
def test_each_coordinate_moves_on_its_own_as_promised(name, model):
    """The promise is z' = s (z - u - k w); here are complex steps of the equations of motion."""
    vehicle = tv.load_vehicle(name)
    plant = plant_of(name, model)
    result = unstable_coordinates(plant)
    B = vehicle.normal_force_slope * vehicle.aerodynamic_arm / vehicle.thrust / vehicle.control_arm
    assert result.left_eigenvectors.shape == (result.poles.size, len(plant.states))
    assert result.poles.size == (2 if model == "drift-exact" else 1)
    rng = np.random.default_rng(7)
    for _ in range(5):
        state, (deflection, wind) = rng.normal(size=len(plant.states)), rng.normal(size=2)
        small = 1e-30j
        rates = motion(vehicle, model, small * state, small * deflection, small * wind)
        z = result.left_eigenvectors @ state
        expected = result.poles * (z - deflection / B - result.wind * wind)
        np.testing.assert_allclose(
            result.left_eigenvectors @ rates.imag / 1e-30, expected, atol=2e-12
        )


@BOTH
@EACH_MODEL
def test_the_strength_of_the_wind_is_the_reports_K1_at_each_pole(name, model):
    plant = plant_of(name, model)
    c, computed = plant.coefficients, unstable_coordinates(plant_of(name, model))
    b1, b2 = (0.0, 0.0) if model == "fixed-path" else (c.b1, c.b2)
    np.testing.assert_allclose(
        computed.wind, (computed.poles + b2) / (computed.poles + b1), rtol=1e-9
    )
    if model == "drift":
        assert computed.wind[0] == pytest.approx((c.beta + c.b2) / (c.beta + c.b1), rel=1e-12)
    cubic = [1.0, c.C1, -(c.beta**2), c.C2] if model == "drift-exact" else [1, 0, -(c.beta**2)]
    roots = np.sort(np.roots(cubic))[::-1]
    np.testing.assert_allclose(computed.poles, roots[: computed.poles.size], rtol=1e-10)
    assert np.all(np.diff(computed.poles) < 0.0)


def test_an_effector_ahead_of_the_centre_of_gravity_changes_nothing():
    c = Coefficients(mu_alpha=0.28, mu_delta=2.6, C1=0.025, C2=0.0036, b1=0.0284, b2=0.0169)
    one, other = (
        unstable_coordinates(Plant.from_coefficients(c.replace(mu_delta=m), "drift-exact"))
        for m in (2.6, -2.6)
    )
    # delta/B is the same angle in both, and so are all the coordinates.
    np.testing.assert_allclose(other.left_eigenvectors, one.left_eigenvectors, rtol=1e-9)
    np.testing.assert_allclose(other.wind, one.wind, rtol=1e-9)


def support(poles, direction):
    """The largest direction . z of all states that |u| <= 1 brings back, in any time.

    z = integral of s e^(-s t) u(t) dt is brought to rest by -u, so it is the integral of
    |sum of c s e^(-s t)|, whose sign changes once at most.
    """
    s, r = poles
    a, b = direction[0] * s, direction[1] * r

    def until(t):
        return direction[0] * -np.expm1(-s * t) + direction[1] * -np.expm1(-r * t)

    whole = direction[0] + direction[1]
    if a * b >= 0.0 or abs(b) >= abs(a):  # the slow term is the larger for ever
        return abs(whole)
    change = np.log(-a / b) / (s - r)
    return abs(until(change)) + abs(whole - until(change))


@pytest.mark.thorough
@EACH_PAIR
def test_the_support_function_above_is_an_integral(poles):
    rng = np.random.default_rng(2)
    for c in rng.normal(size=(6, 2)):

        def size(t, c=c):
            return abs(sum(c_i * s * np.exp(-s * t) for c_i, s in zip(c, poles, strict=True)))

        edges = np.concatenate([[0.0], np.geomspace(0.01, 60.0 / poles[1], 60)])
        total = sum(quad(size, a, b)[0] for a, b in pairwise(edges))
        assert support(poles, c) == pytest.approx(total, rel=1e-6)


def excess(poles, points, reach):
    """The largest c . z - h(c) over many directions: negative where every direction allows z."""
    angles = np.concatenate(
        [np.linspace(0.0, 2.0 * np.pi, 2001)]
        + [
            q * np.pi / 2 + sign * np.geomspace(1e-9, 0.4, 200)
            for q in range(4)
            for sign in (1, -1)
        ]
    )
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    allowed = reach * np.array([support(poles, c) for c in directions])
    return np.max(directions @ points.T - allowed[:, np.newaxis], axis=0)


@pytest.mark.thorough
@EACH_PAIR
def test_a_state_is_recoverable_when_no_direction_forbids_it(poles):
    rng, reach = np.random.default_rng(11), 0.4
    points = rng.uniform(-1.1 * reach, 1.1 * reach, size=(3000, 2))
    points[::2, 1] = points[::2, 0] + rng.normal(0.0, 0.02, size=1500)  # where thin sets lie
    out = excess(poles, points, reach)
    clear = np.abs(out) > 1e-5
    inside = are_recoverable(two(poles), points, reach)
    assert clear.mean() > 0.99
    assert 100 < inside.sum() < 2900
    np.testing.assert_array_equal(inside[clear], out[clear] < 0.0)


@pytest.mark.thorough
@EACH_PAIR
def test_the_edge_touches_the_tightest_direction(poles):
    angles = np.linspace(0.0, 2.0 * np.pi, 721)

    def short(angle, z):
        c = np.array([np.cos(angle), np.sin(angle)])
        return 2.0 * support(poles, c) - c @ z

    for fast in np.linspace(-1.99, 1.99, 21):
        for slow in slow_range(two(poles), fast, 2.0):
            z = np.array([fast, slow])
            best = angles[np.argmin([short(a, z) for a in angles])]
            bounds = (best - 0.01, best + 0.01)
            minimum = minimize_scalar(
                short, bounds=bounds, args=(z,), method="bounded", options={"xatol": 1e-11}
            )
            assert minimum.fun == pytest.approx(0.0, abs=1e-9)


def back(poles, first, last, sign):
    """The state that is at rest after `first` s of u = sign and `last` s of u = -sign."""
    z = np.zeros(2)
    for seconds, u in ((last, -sign), (first, sign)):
        drive = np.zeros((3, 3))
        drive[:2, :2], drive[:2, 2] = -np.diag(poles), np.array(poles) * u
        z = (expm(drive * seconds) @ np.append(z, 1.0))[:2]
    return z


@EACH_PAIR
def test_paths_with_one_switch_come_from_inside_and_fill_the_set(poles):
    coordinates = two(poles)
    rng = np.random.default_rng(5)
    for sign in (1.0, -1.0):
        for first, last in rng.exponential(2.0 / poles[0], size=(40, 2)):
            assert are_recoverable(coordinates, back(poles, first, last, sign), 1.0)
        for first in np.linspace(0.1, 4.0, 9) / poles[0]:
            z = back(poles, first, 45.0 / poles[1], sign)  # as good as for ever
            ends = slow_range(coordinates, z[0], 1.0)
            assert z[1] == pytest.approx(ends[0 if sign > 0 else 1], abs=1e-9)
            assert not are_recoverable(coordinates, 1.001 * z, 1.0)
            assert are_recoverable(coordinates, 0.999 * z, 1.0)


@BOTH
def test_a_plant_is_brought_to_rest_from_inside_by_its_own_matrices(name):
    """The whole plant backward from rest with one switch, not only its coordinates."""
    plant = plant_of(name, "drift-exact")
    A, inputs, _, _ = plant.matrices()
    modes, limit = unstable_coordinates(plant), 0.05
    drive = np.zeros((4, 4))
    for first, last in ((2.0, 1.0), (5.0, 12.0), (1.0, 25.0)):
        x = np.zeros(3)
        for seconds, sign in ((last, -1.0), (first, 1.0)):
            drive[:3, :3], drive[:3, 3] = -A, -inputs[:, 0] * sign * limit
            x = (expm(drive * seconds) @ np.append(x, 1.0))[:3]
        z, reach = modes.left_eigenvectors @ x, limit / plant.coefficients.B
        expected = reach * back(modes.poles, first, last, 1.0)
        np.testing.assert_allclose(z, expected, rtol=1e-6, atol=1e-9)
        assert are_recoverable(modes, z, reach)


@EACH_PAIR
def test_the_edge_itself_is_not_recoverable(poles):
    coordinates, reach = two(poles), 1.7
    for fast in np.linspace(-0.9, 0.9, 7) * reach:
        low, high = slow_range(coordinates, fast, reach)
        for edge, inward in ((low, np.inf), (high, -np.inf)):
            assert not are_recoverable(coordinates, np.array([fast, edge]), reach)
            assert are_recoverable(coordinates, np.array([fast, np.nextafter(edge, inward)]), reach)
    for corner in ((reach, reach), (-reach, -reach), (reach, 0.0)):
        assert not are_recoverable(coordinates, np.array(corner), reach)


def test_one_mode_is_recoverable_inside_the_reach_and_not_on_it():
    modes = unstable_coordinates(plant_of("configuration-i", "fixed-path"))
    z = np.array([[-0.2], [-0.19], [0.0], [0.19], [0.2], [0.3]])
    np.testing.assert_array_equal(
        are_recoverable(modes, z, 0.2), [False, True, True, True, False, False]
    )
    assert modes.ratio == 0.0


@EACH_PAIR
def test_the_set_has_its_symmetries_and_takes_many_states_at_once(poles):
    coordinates = two(poles)
    rng = np.random.default_rng(1)
    z, reach = rng.uniform(-1, 1, size=(4, 50, 2)), rng.uniform(0.3, 1.0, size=50)
    inside = are_recoverable(coordinates, z, reach)
    assert inside.shape == (4, 50)
    np.testing.assert_array_equal(inside, are_recoverable(coordinates, -z, reach))
    np.testing.assert_array_equal(inside, are_recoverable(coordinates, 4.0 * z, 4.0 * reach))
    single = [
        [are_recoverable(coordinates, z[i, j], reach[j]) for j in range(50)] for i in range(4)
    ]
    np.testing.assert_array_equal(inside, single)
    assert np.all(are_recoverable(coordinates, z, 2.0 * reach)[inside])
    assert coordinates.ratio == poles[1] / poles[0]


def test_plants_without_real_unstable_modes_are_refused():
    stable = Coefficients(mu_alpha=-0.28, mu_delta=2.6)
    with pytest.raises(InputError, match="real unstable poles.* fixed-path has here: none"):
        unstable_coordinates(Plant.from_coefficients(stable))
    for name in ("configuration-i", "configuration-ii"):
        plant = plant_of(name, "drift-and-speed")
        assert np.iscomplexobj(tv.unstable_modes(plant).poles)
        with pytest.raises(InputError, match="real unstable poles"):
            unstable_coordinates(plant)
    many = Plant.from_coefficients(Coefficients(mu_alpha=[0.2, 0.3], mu_delta=2.6))
    with pytest.raises(InputError, match=r"plant must be one plant; got a batch of shape \(2,\)"):
        unstable_coordinates(many)
    with pytest.raises(InputError, match="plant must be a Plant"):
        unstable_coordinates(tv.load_vehicle("configuration-i"))
