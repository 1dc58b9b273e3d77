"""The unstable modes, the residues at them, and the verdict of eq (4b)."""

import mpmath
import numpy as np
import pytest

import tvclin
from tvclin import Coefficients, Plant, residues, unstable_modes
from tvclin.linear import judge
from tvclin.linear.modes import (
    all_modes,
    left_eigenvector,
    left_eigenvectors,
    mode_table,
    poles_text,
    separated_poles,
    wind_over_deflection,
)
from tvclin.linear.plant import INPUTS, MODELS

ORDER = {"fixed-path": 2, "drift": 3, "drift-exact": 3, "drift-and-speed": 4}
STABLE = {"mu_alpha": -0.3, "mu_delta": 2.6, "b1": 0.02, "b2": 0.015}


def triangle(plant, tau_beta=4.0):
    return tvclin.TriangularWind(peak=-0.08, duration=tau_beta / plant.coefficients.beta)


def on_the_boundary(plant, wind, dead_band=1.0, factor=1.0):
    """Return the report's control with `factor` times the boundary limit."""
    boundary = tvclin.boundary_limit(plant, wind, dead_band)
    limit = factor * boundary.deflection
    return tvclin.trim_then_hold(plant, wind, limit=limit, dead_band=dead_band)


@pytest.mark.parametrize(
    ("name", "model", "printed", "last_digit"),
    [
        ("configuration_i", "fixed-path", [0.52928], 1e-5),
        ("configuration_ii", "fixed-path", [0.39570], 1e-5),
        ("configuration_i", "drift", [0.52928], 1e-5),
        ("configuration_ii", "drift", [0.39570], 1e-5),
        ("configuration_i", "drift-exact", [0.5102040259, 0.0128538675], 1e-10),
        ("configuration_ii", "drift-exact", [0.3739717894, 0.0097502194], 1e-10),
        (
            "configuration_i",
            "drift-and-speed",
            [0.5102163, 0.0064156 + 0.0112135j, 0.0064156 - 0.0112135j],
            1e-7,
        ),
        (
            "configuration_ii",
            "drift-and-speed",
            [0.3739966, 0.0048526 + 0.0117149j, 0.0048526 - 0.0117149j],
            1e-7,
        ),
    ],
)
def test_unstable_poles_are_those_computed_in_50_digits(name, model, printed, last_digit, request):
    poles = unstable_modes(Plant.from_vehicle(request.getfixturevalue(name), model)).poles
    assert poles.shape == (len(printed),)
    for part in (np.real, np.imag):
        np.testing.assert_allclose(part(poles), part(printed), rtol=0, atol=0.51 * last_digit)


@pytest.mark.parametrize("model", ["fixed-path", "drift", "drift-exact"])
def test_real_poles_come_as_real_numbers(configuration_i, model):
    modes = unstable_modes(Plant.from_vehicle(configuration_i, model))
    assert modes.poles.dtype == modes.wind_residues.dtype == np.float64


def contour_integral(plant, input, pole):
    """Integrate H(s) ds/(2 pi j) around one pole, in 50 digits.

    The trapezoidal sum on a circle halfway to the next pole errs by 2^-n.
    """
    with mpmath.workdps(50):
        denominator = [mpmath.mpf(float(a)) for a in plant.denominator]
        numerator = [mpmath.mpf(float(a)) for a in plant.numerator("attitude", input)]
        roots = mpmath.polyroots(denominator, maxsteps=200, extraprec=200)
        centre = min(roots, key=lambda root: abs(root - pole))
        radius = min(abs(root - centre) for root in roots if root is not centre) / 2
        n, total = 120, mpmath.mpc(0)
        for k in range(n):
            arm = radius * mpmath.expjpi(mpmath.mpf(2 * k) / n)
            total += (
                arm
                * mpmath.polyval(numerator, centre + arm)
                / mpmath.polyval(denominator, centre + arm)
            )
        return complex(total / n)


@pytest.mark.parametrize("model", MODELS)
def test_residues_are_contour_integrals_around_the_poles(configuration, model):
    plant = Plant.from_vehicle(configuration, model)
    modes = unstable_modes(plant)
    both = (modes.deflection_residues, modes.wind_residues)
    for input, computed in zip(INPUTS, both, strict=True):
        expected = [contour_integral(plant, input, pole) for pole in modes.poles]
        np.testing.assert_allclose(computed, expected, rtol=1e-12)


@pytest.mark.parametrize("model", MODELS)
def test_the_residue_of_a_response_is_the_sum_over_both_inputs(configuration_i, model):
    plant = Plant.from_vehicle(configuration_i, model)
    modes, p = unstable_modes(plant), unstable_modes(plant).poles
    wind = tvclin.RectangularWind(peak=0.05, duration=7.0)
    held = tvclin.linear.ConstantDeflection(limit=-0.004, start=2.0)
    expected = (
        modes.deflection_residues * -0.004 * np.exp(-2.0 * p) / p
        + modes.wind_residues * 0.05 * -np.expm1(-7.0 * p) / p
    )
    np.testing.assert_allclose(residues(plant, held, wind), expected, rtol=1e-12)


@pytest.mark.parametrize("model", ["fixed-path", "drift"])
def test_a_stable_vehicle_has_no_unstable_mode_and_every_history_is_stable(model):
    plant = Plant.from_coefficients(Coefficients(**STABLE), model)
    wind = tvclin.RectangularWind(peak=0.05, duration=7.0)
    assert unstable_modes(plant).poles.shape == (0,)
    verdict = judge(plant, tvclin.linear.ConstantDeflection(limit=0.1), wind)
    assert verdict.stable is True
    assert verdict.residues.shape == (0,)


@pytest.mark.parametrize("dead_band", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("model", ["fixed-path", "drift"])
def test_the_boundary_is_stable_and_a_billionth_beside_it_is_not(configuration, model, dead_band):
    plant = Plant.from_vehicle(configuration, model)
    wind = triangle(plant)
    assert judge(plant, on_the_boundary(plant, wind, dead_band), wind).stable is True
    # Short of deflection the vehicle goes with the moment of the wind, beyond it against it.
    for factor, sign in ((1.0 - 1e-9, -np.sign(wind.peak)), (1.0 + 1e-9, np.sign(wind.peak))):
        beside = on_the_boundary(plant, wind, dead_band, factor)
        verdict = judge(plant, beside, wind)
        assert verdict.stable is tvclin.is_stable(plant, beside, wind) is False
        assert np.sign(verdict.residues[0]) == sign


@pytest.mark.parametrize("dead_band", [0.5, 1.0])
@pytest.mark.parametrize("model", ["drift-exact", "drift-and-speed"])
def test_on_the_boundary_of_the_exact_models_only_the_slow_modes_are_left(
    configuration, model, dead_band
):
    plant = Plant.from_vehicle(configuration, model)
    wind = triangle(plant)
    verdict = judge(plant, on_the_boundary(plant, wind, dead_band), wind)
    excited = np.abs(verdict.residues) > verdict.tolerance
    assert excited.tolist() == [False] + [True] * (len(excited) - 1)
    assert verdict.stable is False
    assert np.isnan(verdict.final_motion.e_folding_times[0])


def test_the_left_over_names_the_slow_root_and_its_e_folding_time(configuration_i):
    plant = Plant.from_vehicle(configuration_i, "drift-exact")
    wind = triangle(plant)
    left = judge(plant, on_the_boundary(plant, wind), wind).final_motion
    assert left.e_folding_times[1] == pytest.approx(1.0 / 0.0128538675, rel=1e-8)
    assert "e-folding time of 77.8 s" in str(left)


def test_two_growing_modes_are_said_with_both_times(configuration_i):
    plant = Plant.from_vehicle(configuration_i, "drift-exact")
    wind = triangle(plant)
    left = judge(plant, on_the_boundary(plant, wind, factor=0.5), wind).final_motion
    assert str(left).startswith("growing modes with e-folding times of 1.96 s and 77.8 s")


def test_a_growing_pair_is_said_once(configuration_i):
    plant = Plant.from_vehicle(configuration_i, "drift-and-speed")
    wind = triangle(plant)
    text = str(judge(plant, on_the_boundary(plant, wind), wind).final_motion)
    assert text.count("155.9 s") == 1


def test_on_a_fixed_path_the_held_deflection_leaves_y_times_the_wind(configuration):
    plant = Plant.from_vehicle(configuration, "fixed-path")
    wind = triangle(plant)
    y = tvclin.boundary_limit(plant, wind).limit
    left = judge(plant, on_the_boundary(plant, wind), wind).final_motion
    assert left.offset == pytest.approx(-y * wind.peak, rel=1e-13)  # the final value theorem
    assert left.rate == 0.0
    assert f"a constant attitude error of {np.degrees(-y * wind.peak):.4g} deg" == str(left)


def test_with_drift_the_held_deflection_leaves_a_ramp(configuration):
    plant = Plant.from_vehicle(configuration, "drift")
    c, wind = plant.coefficients, triangle(plant)
    control = on_the_boundary(plant, wind)
    left = judge(plant, control, wind).final_motion
    assert left.rate == pytest.approx(c.b1 / c.B * control.final_value, rel=1e-13)
    assert np.isnan(left.offset)
    assert str(left).startswith("a ramp of ")


def test_with_drift_a_pulse_that_ends_leaves_an_offset(configuration_i):
    plant = Plant.from_vehicle(configuration_i, "drift")
    c, wind = plant.coefficients, tvclin.RectangularWind(peak=0.05, duration=6.0)
    left = judge(plant, tvclin.trim_deflection(plant, 0.0 * wind), wind).final_motion
    # s times (beta^2/B) B (s + b2)/(s (beta^2 - s^2)) times the area of the wind, at s = 0
    assert left.offset == pytest.approx(c.b2 * 0.05 * 6.0, rel=1e-13)
    assert left.rate == 0.0


def test_trim_throughout_leaves_nothing(configuration_i):
    plant = Plant.from_vehicle(configuration_i, "fixed-path")
    wind = triangle(plant)
    verdict = judge(plant, tvclin.trim_deflection(plant, wind), wind)
    assert verdict.stable is True
    assert str(verdict.final_motion) == "nothing"


def test_of_a_batch_the_first_that_keeps_an_error_or_a_ramp_is_named():
    wind = tvclin.TriangularWind(peak=0.05, duration=6.0)
    held = tvclin.linear.ConstantDeflection(limit=0.01) * [0.0, 1.0, 2.0]
    stable = Plant.from_coefficients(Coefficients(mu_alpha=-1.0, mu_delta=2.0))
    # In the end 0 = mu_alpha theta - mu_delta delta: -0.02 rad.
    assert "a constant attitude error of -1.146 deg" in str(judge(stable, held, wind).final_motion)
    drifting = Plant.from_coefficients(Coefficients(mu_alpha=0.25, mu_delta=2.0, b1=0.1), "drift")
    # The slope at rest: mu_delta b1/mu_alpha delta = 0.008 rad/s.
    assert "a ramp of 0.4584 deg/s" in str(judge(drifting, held, wind).final_motion)


def test_nothing_in_still_air_leaves_nothing(configuration_i):
    plant = Plant.from_vehicle(configuration_i, "drift-exact")
    still = 0.0 * triangle(plant)
    verdict = judge(plant, tvclin.trim_deflection(plant, still), still)
    assert verdict.stable is True
    assert str(verdict.final_motion) == "nothing"


@pytest.mark.parametrize("model", ["fixed-path", "drift-exact"])
def test_without_an_aerodynamic_moment_nothing_is_said_of_the_end(configuration_i, model):
    plant = Plant.from_vehicle(configuration_i.replace(aerodynamic_arm=0.0), model)
    wind = tvclin.TriangularWind(peak=0.05, duration=6.0)
    verdict = judge(plant, tvclin.linear.ConstantDeflection(limit=0.01), wind)
    assert verdict.stable is True
    assert np.isnan([verdict.final_motion.rate, verdict.final_motion.offset]).all()
    assert str(verdict.final_motion) == "what several poles at zero make of the deflection"
    some = Plant.from_vehicle(configuration_i.replace(aerodynamic_arm=[0.0, 9.45]), model)
    left = judge(some, tvclin.linear.ConstantDeflection(limit=0.01), wind).final_motion
    np.testing.assert_array_equal(np.isnan(left.rate), [True, False])
    assert "several poles at zero" in str(left)


@pytest.mark.parametrize("model", MODELS[1:])
def test_where_the_speed_plays_no_part_every_model_with_drift_leaves_one_ramp(model):
    c = Coefficients(mu_alpha=0.25, mu_delta=2.0, b1=0.1, b2=0.05)
    wind, held = (
        tvclin.TriangularWind(peak=0.05, duration=6.0),
        tvclin.linear.ConstantDeflection(limit=0.01),
    )
    left = judge(Plant.from_coefficients(c, model), held, wind).final_motion
    # At rest mu_alpha rate = mu_delta b1 delta.
    assert left.rate == pytest.approx(2.0 * 0.1 * 0.01 / 0.25, rel=1e-13)


def test_in_yaw_the_models_with_drift_leave_the_same(configuration_i):
    wind, held = (
        tvclin.TriangularWind(peak=0.05, duration=6.0),
        tvclin.linear.ConstantDeflection(limit=0.01),
    )
    exact, speed = (
        judge(Plant.from_vehicle(configuration_i, model, "yaw"), held, wind).final_motion
        for model in ("drift-exact", "drift-and-speed")  # one is the other times s/s, as q = 0
    )
    assert exact.offset != 0.0
    assert speed.offset == pytest.approx(exact.offset, rel=1e-13)
    assert (speed.rate, exact.rate) == (0.0, 0.0)


def test_residues_of_a_verdict_count_the_time_from_the_first_of_both(configuration_i):
    plant = Plant.from_vehicle(configuration_i, "fixed-path")
    wind = tvclin.TriangularWind(peak=0.05, duration=6.0)
    pole = unstable_modes(plant).poles
    for early in (tvclin.linear.ConstantDeflection(limit=0.01), wind * 0.2):
        for first, second in ((early.shift(-2.0), wind), (early, wind.shift(-2.0))):
            computed = judge(plant, first, second).residues
            expected = residues(plant, first, second) * np.exp(-2.0 * pole)
            np.testing.assert_allclose(computed, expected, rtol=1e-12)


def test_a_wind_that_stays_is_leaned_into():
    stable = Plant.from_coefficients(Coefficients(mu_alpha=-1.0, mu_delta=2.0))
    left = judge(
        stable,
        tvclin.linear.ConstantDeflection(limit=0.01),
        tvclin.linear.ConstantDeflection(limit=0.05),
    )
    # In the end 0 = mu_alpha (theta - alpha_w) - mu_delta delta.
    assert left.final_motion.offset == pytest.approx(0.05 - 0.02, rel=1e-13)


def test_with_drift_pulses_of_wind_and_deflection_leave_the_sum_of_both(configuration_i):
    plant = Plant.from_vehicle(configuration_i, "drift")
    c, wind = plant.coefficients, tvclin.RectangularWind(peak=0.05, duration=6.0)
    pulse = tvclin.RectangularWind(peak=0.02, duration=2.0)
    left = judge(plant, pulse, wind).final_motion
    assert left.offset == pytest.approx(c.b1 / c.B * 0.04 + c.b2 * 0.3, rel=1e-13)


def test_a_held_deflection_that_does_not_ramp_leaves_an_offset_of_its_own():
    c = Coefficients(mu_alpha=0.25, mu_delta=2.0, b1=0.0, b2=0.05)
    wind, held = (
        tvclin.TriangularWind(peak=0.05, duration=6.0),
        tvclin.linear.ConstantDeflection(limit=0.01),
    )
    left = judge(Plant.from_coefficients(c, "drift"), held, wind).final_motion
    # For b1 = 0 the deflection turns the vehicle by delta/B as on a fixed path, the wind by
    # b2 times its area.
    assert left.rate == 0.0
    assert left.offset == pytest.approx(0.01 / c.B + 0.05 * 0.15, rel=1e-13)
    both = judge(Plant.from_coefficients(c, "drift"), held * [1.0, 2.0], wind).final_motion
    np.testing.assert_allclose(both.offset, [0.08 + 0.0075, 0.16 + 0.0075], rtol=1e-13)


def test_wind_and_trim_that_both_stay_leave_what_came_before_the_trim():
    c = Coefficients(mu_alpha=0.25, mu_delta=2.0, b1=0.05, b2=0.05)
    wind = tvclin.linear.ConstantDeflection(limit=0.05)
    trim = tvclin.linear.ConstantDeflection(limit=-0.05 * c.B, start=3.0)
    for late in (0.0, 7.0):
        moved = trim.shift(late), wind.shift(late)
        left = judge(Plant.from_coefficients(c, "drift"), *moved).final_motion
        # Trim cancels the wind: a pulse of 3 s is left, and of that b2 times its area.
        assert (left.rate, left.offset) == (0.0, pytest.approx(0.05 * 0.15, rel=1e-12))


def test_one_undamped_vehicle_in_a_batch_is_enough_to_say_so():
    both = Plant.from_coefficients(Coefficients(mu_alpha=[-1.0, 0.25], mu_delta=2.0))
    wind = tvclin.TriangularWind(peak=0.05, duration=6.0)
    left = judge(both, tvclin.trim_deflection(both, 0.0 * wind), wind).final_motion
    np.testing.assert_array_equal(left.oscillates, [True, False])
    assert "an undamped oscillation" in str(left)


def test_only_an_undamped_pair_oscillates_for_ever():
    wind = tvclin.TriangularWind(peak=0.05, duration=6.0)
    stable = Coefficients(mu_alpha=np.linspace(-2.0, -0.1, 9), mu_delta=2.0)
    undamped = Plant.from_coefficients(stable, "drift")  # a pole at zero beside each pair
    assert np.all(judge(undamped, wind, wind).final_motion.oscillates)
    square = np.linspace(0.1, 2.0, 9)  # (s + 1)(s^2 + square): pairs that rounding may damp
    beside = Coefficients(mu_alpha=-square, mu_delta=2.0, C1=1.0, C2=square)
    undamped = Plant.from_coefficients(beside, "drift-exact")
    assert np.all(judge(undamped, wind, wind).final_motion.oscillates)
    # (s - 1/2)(s^2 + s/2 + 0.1525)
    mixed = Coefficients(mu_alpha=0.0975, mu_delta=2.0, C2=-0.07625)
    damped = Plant.from_coefficients(mixed, "drift-exact")
    assert not judge(damped, wind, wind).final_motion.oscillates
    straight = Plant.from_coefficients(Coefficients(mu_alpha=0.25, mu_delta=2.0), "drift")
    assert not judge(straight, wind, wind).final_motion.oscillates


def test_unstable_poles_are_real_though_stable_ones_are_not():
    # (s - 1/2)(s^2 + s/2 + 0.1525) and (s + 1/2)(s^2 + s/2 + 0.1525)
    mixed = Coefficients(
        mu_alpha=[0.0975, -0.4025], mu_delta=2.0, C1=[0.0, 1.0], C2=[-0.07625, 0.07625]
    )
    poles = unstable_modes(Plant.from_coefficients(mixed, "drift-exact")).poles
    assert not np.iscomplexobj(poles)
    np.testing.assert_allclose(poles, [[0.5], [np.nan]], rtol=1e-13)


def test_a_flight_that_begins_later_leaves_as_much_less(configuration_i):
    plant = Plant.from_vehicle(configuration_i, "drift-exact")
    wind, held = (
        tvclin.TriangularWind(peak=0.05, duration=6.0),
        tvclin.linear.ConstantDeflection(limit=0.01),
    )
    now, later = residues(plant, held, wind), residues(plant, held.shift(3.0), wind.shift(3.0))
    np.testing.assert_allclose(later, now * np.exp(-3.0 * unstable_modes(plant).poles), rtol=1e-12)


def test_a_stable_vehicle_is_left_with_an_undamped_oscillation():
    plant = Plant(Coefficients(**STABLE), "fixed-path")
    wind = tvclin.RectangularWind(peak=0.05, duration=6.0)
    left = judge(plant, tvclin.trim_deflection(plant, 0.0 * wind), wind).final_motion
    assert left.oscillates
    assert str(left) == "an undamped oscillation"


def test_an_unstable_vehicle_does_not_oscillate(configuration_i):
    plant = Plant.from_vehicle(configuration_i, "fixed-path")
    wind = triangle(plant)
    assert not judge(plant, on_the_boundary(plant, wind), wind).final_motion.oscillates


@pytest.mark.parametrize("model", ["fixed-path", "drift"])
def test_the_boundary_of_a_wind_of_2000_samples_is_stable(configuration, model):
    plant = Plant.from_vehicle(configuration, model)
    time = np.linspace(0.0, 12.0, 2000)
    noise = np.random.default_rng(7).normal(scale=0.02, size=time.size)
    angle = 0.09 * np.sin(np.pi * time / 12.0) ** 2 * np.exp(noise)
    angle[[0, -1]] = 0.0
    wind = tvclin.SampledWind(time=time, angle=angle)
    verdict = judge(plant, on_the_boundary(plant, wind), wind)
    assert verdict.stable is True
    assert verdict.tolerance[0] < 1e-11  # the tolerance is rounding, no more
    assert judge(plant, on_the_boundary(plant, wind, factor=1.0 + 1e-9), wind).stable is False


@pytest.mark.parametrize("model", MODELS)
def test_a_batch_equals_a_loop_and_fills_with_nan(model):
    rows = {"mu_alpha": np.array([0.28, -0.3, 0.16]), "b1": np.array([0.03, 0.02, 0.04])}
    others = {"mu_delta": 2.0, "b2": 0.015, "C1": 0.025, "q": 1.5e-4}
    slow = {"C2": 0.013 * rows["mu_alpha"]}
    batch = Plant.from_coefficients(Coefficients(**rows, **slow, **others), model)
    wind = tvclin.RectangularWind(peak=0.05, duration=7.0)
    held = tvclin.linear.ConstantDeflection(limit=-0.004)
    modes, verdict = unstable_modes(batch), judge(batch, held, wind)
    for i in range(3):
        one = {name: values[i] for name, values in (rows | slow).items()}
        single = Plant.from_coefficients(Coefficients(**one, **others), model)
        expected, alone = unstable_modes(single), judge(single, held, wind)
        n = expected.poles.size
        np.testing.assert_allclose(modes.poles[i, :n], expected.poles, rtol=1e-13)
        np.testing.assert_allclose(verdict.residues[i, :n], alone.residues, rtol=1e-11)
        assert np.all(np.isnan(modes.poles[i, n:]))
        assert verdict.stable[i] == alone.stable
        for name in ("offset", "rate", "oscillates"):
            computed, value = getattr(verdict.final_motion, name), getattr(alone.final_motion, name)
            assert computed[i] == pytest.approx(value, rel=1e-12, nan_ok=True), name


@pytest.mark.parametrize("model", MODELS)
def test_an_impulse_does_not_move_the_attitude_at_once(configuration, model):
    modes = all_modes(Plant.from_vehicle(configuration, model))
    assert modes.poles.shape == (ORDER[model],)
    for computed in (modes.deflection_residues, modes.wind_residues):
        # The residues of a transfer function that falls as 1/s^2 add up to zero.
        assert abs(computed.sum()) < 1e-13 * np.abs(computed).max()


def test_a_repeated_pole_has_no_residue():
    modes = all_modes(Plant.from_coefficients(Coefficients(mu_alpha=0.0, mu_delta=2.0)))
    assert modes.poles.tolist() == [0.0, 0.0]
    assert np.all(np.isnan(modes.deflection_residues))


@pytest.mark.parametrize(
    ("call", "names"),
    [
        (
            lambda plant, wind: tvclin.Plant.from_vehicle("configuration-i", "fixed-path"),
            "vehicle must be a V",
        ),
        (lambda plant, wind: tvclin.Plant(3, "drift"), "coefficients must be a Coefficients"),
        (lambda plant, wind: tvclin.unstable_modes("x"), "plant must be a Plant"),
        (lambda plant, wind: all_modes("x"), "plant must be a Plant"),
        (
            lambda plant, wind: tvclin.linear.judge(plant, None, wind),
            "deflection must be a History",
        ),
        (lambda plant, wind: tvclin.linear.judge(plant, wind, 0.1), "wind must be a History"),
        (lambda plant, wind: tvclin.boundary_limit(3, wind), "plant must be a Plant"),
        (lambda plant, wind: tvclin.boundary_limit(plant, 0.1), "wind must be a History"),
        (lambda plant, wind: tvclin.trim_deflection(plant, 0.1), "wind must be a History"),
        (lambda plant, wind: tvclin.attitude_responses(plant, wind, 1, [0.0]), "wind must be a"),
        (lambda plant, wind: tvclin.load_vehicle(None), "vehicle must be a name or a path"),
    ],
)
def test_an_argument_of_another_kind_is_named(call, names):
    plant = tvclin.Plant(tvclin.Coefficients.from_beta(beta=0.5, B=0.1), "fixed-path")
    with pytest.raises(tvclin.InputError, match=names):
        call(plant, tvclin.TriangularWind(peak=0.1, duration=5.0))


@pytest.mark.parametrize("apart", [0.0, 0.95e-6, 0.95e-6j])
def test_poles_that_are_together_are_set_apart_about_their_mean(apart):
    both, other = 0.5 + np.array([apart, -apart]) / 2.0, [0.9, np.nan]
    result = separated_poles(np.array([[other[0], *both], [*both, other[1]]]))
    assert result.dtype == np.float64
    for pair in (result[0, 1:], result[1, :2]):
        np.testing.assert_allclose(pair, [0.5 + 5e-7, 0.5 - 5e-7], rtol=1e-15)
    np.testing.assert_array_equal([result[0, 0], result[1, 2]], other)


@pytest.mark.parametrize("apart", [1.05e-6, 1.05e-6j])
def test_poles_that_are_not_together_stay_as_they_are(apart):
    poles = np.array([0.5 + apart / 2.0, 0.5 - apart / 2.0, np.nan])
    np.testing.assert_array_equal(separated_poles(poles), poles)


def test_a_table_of_modes_has_each_model_once_and_of_each_pair_the_upper_pole(configuration_i):
    every = {model: all_modes(Plant.from_vehicle(configuration_i, model)) for model in MODELS}
    rows = mode_table("poles", every).rows
    assert [str(row[0][0]) for row in rows] == [
        *("fixed-path", ""),
        *("drift", "", ""),
        *("drift-exact", "", ""),
        *("drift-and-speed", "", ""),  # three of four poles: two of them are a pair
    ]
    poles, residues = every["drift-and-speed"].poles, every["drift-and-speed"].deflection_residues
    (upper,) = np.flatnonzero(poles.imag > 0.0)
    for cell, number, sign in ((1, poles[upper], "±"), (2, residues[upper], "-")):
        real, between, imaginary, _ = rows[9][cell]
        assert (real.value, between, imaginary.value) == (number.real, sign, abs(number.imag))


@pytest.mark.parametrize(
    ("poles", "words"),
    [
        ([0.5, 0.0], "2 real"),
        ([0.5, 0.02 + 0.3j, 0.02 - 0.3j], "1 real and the complex pair 0.02 +- 0.3j 1/s"),
        ([0.02 + 0.3j, 0.02 - 0.3j], "the complex pair 0.02 +- 0.3j 1/s"),
        ([], "none"),
    ],
)
def test_poles_are_counted_in_words_and_pairs_named(poles, words):
    assert poles_text(np.array(poles)) == words


@pytest.mark.parametrize("batch", [(), (3,), (2, 3)])
def test_a_left_eigenvector_is_that_of_the_eigenvalue_next_to_a_pole(batch):
    """Each row obeys l A = p l; a pole that is off by a little finds its own."""
    A = np.random.default_rng(3).normal(size=(*batch, 4, 4))
    for k in range(4):
        exact = np.sort_complex(np.linalg.eigvals(A))[..., k]
        computed, row = left_eigenvector(A, exact * (1.0 + 1e-9))
        np.testing.assert_allclose(computed, exact, rtol=1e-12)
        np.testing.assert_allclose(
            np.einsum("...i,...ij->...j", row, A), exact[..., np.newaxis] * row, atol=1e-13
        )
        np.testing.assert_allclose(np.linalg.norm(row, axis=-1), 1.0, rtol=1e-14)


def test_left_eigenvectors_come_by_falling_growth_rate():
    A = np.random.default_rng(4).normal(size=(3, 5, 5))
    values, rows = left_eigenvectors(A)
    assert np.all(np.diff(values.real, axis=-1) <= 0.0)
    np.testing.assert_allclose(rows @ A, values[..., np.newaxis] * rows, atol=1e-13)


@pytest.mark.parametrize(("model", "b1", "b2"), [("fixed-path", 0.0, 0.0), ("drift", 0.03, 0.02)])
def test_a_wind_is_as_strong_as_b_k1_of_the_deflection(model, b1, b2):
    c = Coefficients(mu_alpha=0.25, mu_delta=2.0, b1=b1, b2=b2)
    strength = wind_over_deflection(Plant.from_coefficients(c, model), np.array([0.5]))
    assert strength == pytest.approx(0.125 * (0.5 + b2) / (0.5 + b1), rel=1e-14)


@pytest.mark.parametrize("b2", [0.1, -0.9, -0.5])
def test_a_wind_is_infinitely_strong_where_the_deflection_does_not_reach(b2):
    c = Coefficients(mu_alpha=0.25, mu_delta=2.0, b1=-0.5, b2=b2)
    plant = Plant.from_coefficients(c, "drift")  # (s - 0.5)/(s - 0.5): no deflection moves it
    np.testing.assert_array_equal(wind_over_deflection(plant, np.array([0.5])), [np.inf])
