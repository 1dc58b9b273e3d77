"""The coefficients: the report's numbers, its invariances, and another derivation."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tvclin
from tests.vehicles import CONFIGURATION_I
from tvclin import Coefficients, InputError

G = 9.80665
NAMES = ("mu_alpha", "mu_delta", "C1", "C2", "b1", "b2", "q")
EXTENSIVE = ("weight", "moment_of_inertia", "normal_force_slope", "thrust", "axial_force")


def as_row(coefficients):
    return np.array([getattr(coefficients, name) for name in NAMES])


@pytest.mark.parametrize(
    ("name", "first", "second", "last_digits"),
    [
        ("beta", 0.52928, 0.39570, (1e-5, 1e-5)),
        ("B", 0.107229, 0.0965056, (1e-6, 1e-7)),
        ("C1", 0.0250613, 0.0338274, (1e-7, 1e-7)),
        ("b1", 0.0283514, 0.0375151, (1e-7, 1e-7)),
        ("b2", 0.0168588, 0.0273860, (1e-7, 1e-7)),
        ("K1", 0.979390, 0.976619, (1e-6, 1e-6)),
    ],
)
def test_both_configurations_have_the_coefficients_computed_by_hand(
    configuration_i, configuration_ii, name, first, second, last_digits
):
    both = zip((configuration_i, configuration_ii), (first, second), last_digits, strict=True)
    for vehicle, value, last_digit in both:
        result = getattr(Coefficients.from_vehicle(vehicle), name)
        assert result == pytest.approx(value, abs=0.51 * last_digit)


def test_c2_over_beta_squared_is_the_slow_root_of_the_report(configuration_i, configuration_ii):
    first = Coefficients.from_vehicle(configuration_i)
    second = Coefficients.from_vehicle(configuration_ii)
    assert first.C2 / first.beta_squared == pytest.approx(0.012832, abs=5.1e-7)
    assert second.C2 / second.beta_squared == pytest.approx(0.0097238, abs=5.1e-8)


def test_the_coefficients_are_the_formulas_of_appendix_b(configuration):
    v, c = configuration, Coefficients.from_vehicle(configuration)
    momentum = v.weight / G * v.velocity
    ahead = v.thrust - v.axial_force - v.weight * np.sin(v.attitude)
    N, arms = v.normal_force_slope, v.aerodynamic_arm / v.control_arm
    expected = [
        N * v.aerodynamic_arm / v.moment_of_inertia,
        v.thrust * v.control_arm / v.moment_of_inertia,
        (ahead + N) / momentum,
        N * v.aerodynamic_arm / v.moment_of_inertia * G * np.sin(v.attitude) / v.velocity,
        (ahead + N * (1 + arms)) / momentum,
        ahead / momentum,
        (G * np.cos(v.attitude) / v.velocity) ** 2,
    ]
    np.testing.assert_allclose(as_row(c), expected, rtol=1e-14)  # a few roundings


@given(factor=st.floats(1e-6, 1e6))
def test_a_common_factor_on_all_forces_and_the_inertia_changes_nothing(factor):
    scaled = CONFIGURATION_I | {name: factor * CONFIGURATION_I[name] for name in EXTENSIVE}
    np.testing.assert_allclose(
        as_row(Coefficients.from_vehicle(tvclin.Vehicle(**scaled))),
        as_row(Coefficients.from_vehicle(tvclin.Vehicle(**CONFIGURATION_I))),
        rtol=1e-14,  # rounding of the factor itself
    )


def test_the_velocity_is_not_scale_free(configuration_i):
    faster = Coefficients.from_vehicle(configuration_i.replace(velocity=2 * 538.81))
    assert faster.b1 == pytest.approx(Coefficients.from_vehicle(configuration_i).b1 / 2, rel=1e-14)


def test_in_yaw_only_the_gravity_term_q_vanishes(configuration):
    pitch, yaw = (Coefficients.from_vehicle(configuration, plane) for plane in ("pitch", "yaw"))
    assert pitch.q > 0.0
    assert yaw.q == 0.0
    assert yaw.replace(q=pitch.q) == pitch


def test_an_unknown_plane_is_refused_with_the_near_name(configuration_i):
    with pytest.raises(InputError, match=r"plane must be one of pitch, yaw; .* 'pitch'"):
        Coefficients.from_vehicle(configuration_i, "pich")


@pytest.mark.parametrize("arm", [0.0, -3.0])
def test_a_stable_vehicle_has_coefficients_but_no_beta(configuration_i, arm):
    stable = Coefficients.from_vehicle(configuration_i.replace(aerodynamic_arm=arm))
    assert stable.beta_squared == stable.mu_alpha == pytest.approx(arm * 6.67e5 / 2.25e7, rel=1e-15)
    assert np.all(np.isfinite(as_row(stable)))
    for name in ("beta", "K1"):
        with pytest.raises(InputError, match="unstable vehicle, mu_alpha > 0; got mu_alpha ="):
            getattr(stable, name)


def test_one_stable_vehicle_in_a_batch_has_no_beta():
    with pytest.raises(InputError, match=r"-0\.25"):
        _ = Coefficients(mu_alpha=[0.25, -0.25], mu_delta=2.0).beta


@pytest.mark.parametrize(("mu_alpha", "has"), [(0.25, True), (0.0, False), ([0.25, -0.25], False)])
def test_only_where_every_vehicle_is_unstable_are_a_beta_and_a_pole_shown(mu_alpha, has):
    c = Coefficients(mu_alpha=mu_alpha, mu_delta=2.0, name="booster")
    document = c.as_dict()
    assert (document["beta_per_s"], document["pole_per_s"]) == ((0.5, 0.5) if has else (None, None))
    np.testing.assert_array_equal(document["B"], np.divide(mu_alpha, 2.0))
    shown = c._repr_html_()
    assert [f">{name}<" in shown for name in ("beta", "pole p", "K1", "B")] == [has] * 3 + [True]
    assert "Coefficients: booster" in shown


def test_from_beta_is_the_pair_of_the_report():
    c = Coefficients.from_beta(beta=0.5, B=0.125, b1=0.03, b2=0.02, q=1e-4, C1=0.025, C2=0.004)
    assert (c.mu_alpha, c.mu_delta) == (0.25, 2.0)
    assert (c.beta, c.B) == (0.5, 0.125)
    assert c.K1 == pytest.approx(0.52 / 0.53, rel=1e-15)
    assert (c.b1, c.b2, c.q, c.C1, c.C2) == (0.03, 0.02, 1e-4, 0.025, 0.004)
    assert Coefficients.from_beta(beta=1e-3, B=0.125).mu_alpha == pytest.approx(1e-6, rel=1e-15)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("beta", beta) for beta in (0.0, -0.5, np.nan, 1.001e9, 1e200)),  # its square: 1e18
        *(("B", B) for B in (0.0, "x", np.inf)),
    ],
)
def test_from_beta_refuses_what_is_no_pair(name, value):
    with pytest.raises(InputError, match=f"^{name} must be"):
        Coefficients.from_beta(**{"beta": 0.5, "B": 0.1, name: value})


def test_from_beta_refuses_pairs_that_do_not_broadcast():
    with pytest.raises(InputError, match=r"B \(3,\)"):
        Coefficients.from_beta(beta=[0.5, 0.6], B=[0.1, 0.1, 0.1])


@pytest.mark.parametrize("bad", [np.nan, np.inf, "x", 1j], ids=repr)
@pytest.mark.parametrize("name", NAMES)
def test_each_coefficient_must_be_real_and_finite(name, bad):
    with pytest.raises(InputError, match=f"^{name} must be"):
        Coefficients(**{"mu_alpha": 0.25, "mu_delta": 2.0, name: bad})


@pytest.mark.parametrize("name", ["q", "damping", "velocity"])
def test_a_negative_square_damping_or_speed_is_refused(name):
    with pytest.raises(InputError, match=f"^{name} must be zero or positive"):
        Coefficients(**{"mu_alpha": 0.25, "mu_delta": 2.0, name: -1e-9})


def test_a_control_without_moment_is_refused():
    with pytest.raises(InputError, match=r"^mu_delta must be other than zero"):
        Coefficients(mu_alpha=0.25, mu_delta=0.0)


@pytest.mark.parametrize("size", [1e18, -1e18])
def test_no_product_of_coefficients_may_overflow(size):
    """Each is at most 1e18 in size, and so is one over mu_delta; the rims themselves are legal."""
    assert Coefficients(mu_alpha=size, mu_delta=1.0 / size).b1 == 0.0
    for name in ("mu_alpha", "mu_delta"):
        with pytest.raises(InputError, match=rf"^{name} must be between -1e\+18 and 1e\+18"):
            Coefficients(**{"mu_alpha": 0.25, "mu_delta": 2.0, name: 1.001 * size})
    with pytest.raises(InputError, match=r"^mu_delta must be at least 1e-18 1/s\^2 in size; got 9"):
        Coefficients(mu_alpha=0.25, mu_delta=[2.0, 0.999 / size])


def test_the_name_of_coefficients_is_a_text():
    with pytest.raises(InputError, match=r"^name must be a str .*; got 7"):
        Coefficients(mu_alpha=0.25, mu_delta=2.0, name=7)


def test_two_coefficients_alone_leave_the_path_fixed_and_make_no_drift():
    c = Coefficients(mu_alpha=0.25, mu_delta=2.0)
    plant = tvclin.Plant.from_coefficients(c, "drift-and-speed")
    np.testing.assert_array_equal(plant.denominator, [1.0, 0.0, -0.25, 0.0, 0.0])  # s^2 (s^2 - mu)
    assert c.K1 == 1.0


def test_two_coefficients_alone_have_no_damping_and_no_speed():
    c = Coefficients(mu_alpha=0.25, mu_delta=2.0)
    assert (c.damping, c.velocity) == (0.0, 0.0)
    assert ">Coefficients<" in c._repr_html_()  # and no name


def test_lists_become_arrays_and_numbers_floats():
    c = Coefficients(mu_alpha=[0.25, 0.5], mu_delta=2)
    np.testing.assert_array_equal(c.B, [0.125, 0.25])
    assert isinstance(c.mu_delta, float)


def test_coefficients_that_do_not_broadcast_are_refused():
    with pytest.raises(InputError, match=r"mu_alpha \(2,\), q \(3,\)"):
        Coefficients(mu_alpha=[0.25, 0.5], mu_delta=2.0, q=[0.0, 0.0, 0.0])


def test_a_name_is_no_vehicle():
    with pytest.raises(InputError, match=r"vehicle must be a Vehicle \(see load_vehicle\)"):
        Coefficients.from_vehicle("configuration-i")


def test_coefficients_cannot_be_changed_and_replace_knows_its_fields():
    c = Coefficients(mu_alpha=0.25, mu_delta=2.0)
    with pytest.raises(dataclasses.FrozenInstanceError):
        c.q = 1.0
    with pytest.raises(InputError, match="no field beta"):
        c.replace(beta=1.0)


def test_a_batch_equals_a_loop(configuration_i):
    thrust, arm, attitude = [2e6, 2.5e6, 3e6], [[9.45], [-2.0]], [[0.1], [-0.7]]
    batch = Coefficients.from_vehicle(
        configuration_i.replace(thrust=thrust, aerodynamic_arm=arm, attitude=attitude)
    )
    assert batch.batch == (2, 3)
    for (i, j), one in np.ndenumerate(np.broadcast_to(thrust, (2, 3))):
        single = configuration_i.replace(
            thrust=one, aerodynamic_arm=arm[i][0], attitude=attitude[i][0]
        )
        for name in (*NAMES, "B"):
            rows = np.broadcast_to(getattr(batch, name), (2, 3))
            expected = getattr(Coefficients.from_vehicle(single), name)
            assert rows[i, j] == pytest.approx(expected, rel=1e-15), name


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"control_force_slope": 4e5, "control_arm": -11.0},
        {"control_force_slope": 9e6, "attitude": -0.3},
        {"aerodynamic_arm": -4.0, "control_force_slope": 7e5},
    ],
    ids=["gimballed", "ahead", "descending", "stable"],
)
def test_the_coefficients_are_those_of_the_linearised_equations_of_motion(
    configuration, linearised, changes
):
    vehicle = configuration.replace(**changes)
    c = Coefficients.from_vehicle(vehicle)
    A, B = linearised(vehicle)
    denominator = [1.0, c.C1, c.q - c.mu_alpha, c.C2, -c.q * c.mu_alpha]
    # Characteristic polynomials from eigenvalues lose a few digits of their small coefficients.
    np.testing.assert_allclose(np.poly(A), denominator, rtol=1e-9, atol=1e-15)
    numerators = [(-c.mu_delta, c.b1), (-c.mu_alpha, c.b2)]
    for s in (0.3 + 0.2j, -0.01 + 0.05j, 2.0j):
        computed = np.linalg.solve(s * np.eye(4) - A, B)[0]
        expected = [k * (s**2 + b * s + c.q) / np.polyval(denominator, s) for k, b in numerators]
        np.testing.assert_allclose(computed, expected, rtol=1e-11)
