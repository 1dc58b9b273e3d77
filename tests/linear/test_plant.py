"""The plant: its transfer functions, its state space, and python-control at work on them."""

import control
import matplotlib as mpl
import numpy as np
import pytest

from tvclin import Coefficients, InputError, Plant
from tvclin.linear.plant import INPUTS, MODELS

COEFFICIENTS = Coefficients(
    mu_alpha=0.28, mu_delta=2.6, C1=0.025, C2=0.0036, b1=0.0284, b2=0.0169, q=1.7e-4
)
ORDER = {"fixed-path": 2, "drift": 3, "drift-exact": 3, "drift-and-speed": 4}
ATTITUDE_DEGREE = {"fixed-path": 0, "drift": 1, "drift-exact": 1, "drift-and-speed": 2}
PAIRS = [
    (model, output, input)
    for model in MODELS
    for output in Plant.from_coefficients(COEFFICIENTS, model).outputs
    for input in INPUTS
]


def plant_of(model):
    return Plant.from_coefficients(COEFFICIENTS, model)


def printed(model, input, s):
    """Eqs (5), (B8), (B7) and the fourth-order parent, with the 1/B the print leaves out."""
    c = COEFFICIENTS
    beta2, B = c.mu_alpha, c.mu_alpha / c.mu_delta
    zero, gain = (c.b1, 1.0) if input == "deflection" else (c.b2, B)
    factor, bottom = {
        "fixed-path": (1.0, s**2 - beta2),
        "drift": (s + zero, s * (s**2 - beta2)),
        "drift-exact": (s + zero, s**3 + c.C1 * s**2 - beta2 * s + c.C2),
        "drift-and-speed": (
            s**2 + zero * s + c.q,
            s**4 + c.C1 * s**3 + (c.q - beta2) * s**2 + c.C2 * s - beta2 * c.q,
        ),
    }[model]
    return -(beta2 / B) * gain * factor / bottom


@pytest.fixture(scope="module")
def points():
    rng = np.random.default_rng(1)
    return rng.normal(size=20) + 1j * rng.normal(size=20)


@pytest.mark.parametrize("input", INPUTS)
@pytest.mark.parametrize("model", MODELS)
def test_the_attitude_is_that_of_the_reports_equations(model, input, points):
    result = plant_of(model).tf("attitude", input)(points)
    np.testing.assert_allclose(result, printed(model, input, points), rtol=1e-13)


@pytest.mark.parametrize(("model", "output", "input"), PAIRS)
def test_transfer_function_and_state_space_are_the_same(model, output, input, points):
    plant = plant_of(model)
    matrix = plant.ss()(points)
    computed = matrix[plant.outputs.index(output), INPUTS.index(input)]
    expected = plant.tf(output, input)(points)
    np.testing.assert_allclose(computed, expected, rtol=1e-11, atol=1e-13)


@pytest.mark.parametrize("input", INPUTS)
@pytest.mark.parametrize("model", MODELS)
def test_degrees_are_exact_integers_and_no_coefficient_is_a_rounded_zero(model, input):
    plant = plant_of(model)
    attitude, angle = plant.tf("attitude", input), plant.tf("angle_of_attack", input)
    assert attitude.num[0][0].size == ATTITUDE_DEGREE[model] + 1
    assert plant.tf("attitude_rate", input).num[0][0].size == ATTITUDE_DEGREE[model] + 2
    assert attitude.den[0][0].tolist() == plant.denominator.tolist()
    assert attitude.den[0][0].size == ORDER[model] + 1
    if input == "wind":  # the wind itself is a part of the angle of attack
        assert angle.num[0][0].size == ORDER[model] + 1
        assert angle.num[0][0][0] == -1.0


def test_on_a_fixed_path_a_wind_reaches_the_angle_of_attack_as_a_pure_double_zero():
    assert plant_of("fixed-path").tf("angle_of_attack", "wind").num[0][0].tolist() == [-1, 0, 0]


@pytest.mark.parametrize("model", MODELS)
def test_every_numerator_stands_over_the_one_denominator(model, points):
    plant = plant_of(model)
    for output in plant.outputs:
        top = np.polyval(plant.numerator(output, "wind"), points)
        expected = plant.tf(output, "wind")(points)
        np.testing.assert_allclose(
            top / np.polyval(plant.denominator, points), expected, rtol=1e-13
        )


@pytest.mark.parametrize("model", MODELS)
def test_the_angle_of_attack_is_attitude_less_path_less_wind(model, points):
    plant = plant_of(model)
    for input in INPUTS:
        path = 0.0
        if model != "fixed-path":
            path = plant.tf("flight_path_angle", input)(points)
        expected = plant.tf("attitude", input)(points) - path - (input == "wind")
        result = plant.tf("angle_of_attack", input)(points)
        np.testing.assert_allclose(result, expected, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize(
    "changes",
    [{}, {"control_force_slope": 4e5, "control_arm": -11.0}, {"aerodynamic_arm": -3.0}],
    ids=["as-it-is", "effectors-ahead", "stable"],
)
def test_the_fourth_order_matrices_are_the_linearised_equations_of_motion(
    configuration, linearised, changes
):
    vehicle = configuration.replace(**changes)
    plant = Plant.from_vehicle(vehicle, "drift-and-speed")
    A, B, C, D = plant.matrices()
    expected_A, expected_B = linearised(vehicle)
    assert plant.states == (
        "attitude",
        "attitude_rate",
        "flight_path_angle",
        "relative_speed",
    )
    np.testing.assert_allclose(A, expected_A, rtol=1e-12, atol=1e-17)
    np.testing.assert_allclose(B, expected_B, rtol=1e-12, atol=1e-17)
    assert C.tolist() == [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [1, 0, -1, 0]]
    assert D.tolist() == [[0, 0], [0, 0], [0, 0], [0, -1]]


def test_the_third_order_matrices_are_the_fourth_order_ones_without_speed(configuration):
    third = Plant.from_vehicle(configuration, "drift-exact").matrices()
    fourth = Plant.from_vehicle(configuration, "drift-and-speed").matrices()
    np.testing.assert_array_equal(third[0], fourth[0][:3, :3])
    np.testing.assert_array_equal(third[1], fourth[1][:3])


def test_signals_have_names_and_time_is_continuous():
    system = plant_of("drift").ss()
    assert system.input_labels == ["deflection", "wind"]
    assert system.output_labels == [
        "attitude",
        "attitude_rate",
        "flight_path_angle",
        "angle_of_attack",
    ]
    single = plant_of("drift").tf("attitude", "wind")
    assert (single.input_labels, single.output_labels) == (["wind"], ["attitude"])
    assert system.dt == single.dt == 0


def test_step_response_is_the_hyperbolic_cosine():
    t = np.linspace(0.0, 5.0, 51)
    response = control.step_response(plant_of("fixed-path").tf(), t)
    B, beta = 0.28 / 2.6, np.sqrt(0.28)
    np.testing.assert_allclose(
        response.outputs, -(np.cosh(beta * t) - 1) / B, rtol=1e-9, atol=1e-12
    )


def test_forced_response_to_a_ramp_of_wind_is_the_hyperbolic_sine():
    t = np.linspace(0.0, 5.0, 51)  # a ramp is exact under python-control's first-order hold
    inputs = np.stack([np.zeros_like(t), 0.01 * t])
    response = control.forced_response(plant_of("fixed-path").ss(), t, inputs)
    beta = np.sqrt(0.28)
    expected = -0.01 * (np.sinh(beta * t) / beta - t)
    np.testing.assert_allclose(response.outputs[0], expected, rtol=1e-9, atol=1e-13)


@pytest.mark.thorough
def test_bode_plot_draws_the_magnitude_of_the_transfer_function():
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    omega = np.array([0.1, 1.0, 10.0])
    drawn = control.bode_plot(plant_of("drift-exact").tf(), omega)
    magnitude = drawn.lines[0, 0][0].get_ydata()
    plt.close("all")
    np.testing.assert_allclose(
        magnitude, np.abs(printed("drift-exact", "deflection", 1j * omega)), rtol=1e-12
    )


def test_root_loci_are_the_roots_of_the_closed_loop():
    gains = np.array([0.0, 0.05, 0.5])
    loci = control.root_locus_map(-plant_of("drift").tf(), gains).loci
    for gain, poles in zip(gains, loci, strict=True):
        closed = np.polyadd([1, 0, -0.28, 0], gain * 2.6 * np.array([1, 0.0284]))
        np.testing.assert_allclose(
            np.sort_complex(poles), np.sort_complex(np.roots(closed)), atol=1e-9
        )


def test_interconnect_closes_the_loop_by_signal_names():
    law = control.ss(
        [], [], [], [[0.4, 0.3]], inputs=["attitude", "attitude_rate"], outputs=["deflection"]
    )
    closed = control.interconnect(
        [plant_of("fixed-path").ss(), law],
        inputs=["wind"],
        outputs=["attitude", "angle_of_attack"],
    )
    expected = np.roots([1.0, 0.3 * 2.6, 0.4 * 2.6 - 0.28])
    np.testing.assert_allclose(
        np.sort_complex(closed.poles()), np.sort_complex(expected), rtol=1e-12
    )


@pytest.mark.parametrize("door", ["tf", "ss"])
def test_a_batch_is_refused_at_the_doors_to_python_control(door):
    batch = Plant.from_coefficients(Coefficients(mu_alpha=[0.2, 0.3], mu_delta=2.0), "drift")
    said = rf"{door}\(\) is for one (vehicle|system); .* shape \(2,\)"
    with pytest.raises(InputError, match=said):
        getattr(batch, door)()


@pytest.mark.parametrize("model", MODELS)
def test_a_batch_of_polynomials_and_matrices_equals_a_loop(model):
    rows = {"mu_alpha": [0.2, -0.3], "mu_delta": [2.0, -1.0], "b1": [0.03, 0.01]}
    others = {"C1": 0.02, "C2": 0.003, "b2": 0.015, "q": 1e-4}
    batch = Plant.from_coefficients(Coefficients(**rows, **others), model)
    for i in range(2):
        one = {name: values[i] for name, values in rows.items()}
        single = Plant.from_coefficients(Coefficients(**one, **others), model)
        np.testing.assert_array_equal(batch.denominator[i], single.denominator)
        for output in single.outputs:
            for input in INPUTS:
                computed = batch.numerator(output, input)[i]
                np.testing.assert_array_equal(computed, single.numerator(output, input))
        for computed, expected in zip(batch.matrices(), single.matrices(), strict=True):
            np.testing.assert_array_equal(computed[i], expected)


def test_unknown_names_are_refused_with_the_near_ones():
    with pytest.raises(InputError, match=r"model must be one of .* 'drift-exact'"):
        Plant.from_coefficients(COEFFICIENTS, "drift-exakt")
    with pytest.raises(InputError, match=r"output must be one of .* 'attitude'"):
        plant_of("drift").tf("atitude")
    with pytest.raises(InputError, match=r"input must be one of .* 'deflection'"):
        plant_of("drift").tf("attitude", "deflexion")


def test_a_fixed_path_has_no_flight_path_angle():
    with pytest.raises(InputError, match=r"no flight_path_angle; drift, drift-exact"):
        plant_of("fixed-path").tf("flight_path_angle")


def test_without_aerodynamic_moment_only_the_fixed_path_model_stands():
    neutral = Coefficients(mu_alpha=0.0, mu_delta=2.0)
    assert Plant.from_coefficients(neutral).tf()(2.0) == pytest.approx(-0.5, rel=1e-15)
    with pytest.raises(InputError, match="needs an aerodynamic moment"):
        Plant.from_coefficients(neutral, "drift")
    with pytest.raises(InputError, match="flight path does not follow"):
        Plant.from_coefficients(neutral, "drift-exact").ss()
