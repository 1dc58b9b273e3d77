"""Exact responses: against 120-digit arithmetic, an ODE solver, and the equations themselves."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import tvclin as tv
from tests.report_responses import (
    rectangular_attitude,
    triangular_attitude,
    triangular_attitude_with_drift,
)

MODELS = ("fixed-path", "drift", "drift-exact", "drift-and-speed")


def coefficients() -> tv.Coefficients:
    return tv.Coefficients.from_vehicle(tv.load_vehicle("configuration-i"))


def on_boundary(
    model: str, tau_beta: float, K: float
) -> tuple[tv.Plant, tv.winds.History, tv.winds.History]:
    c = coefficients()
    plant = tv.Plant(c, model)
    wind = tv.TriangularWind(peak=0.1, duration=tau_beta / c.beta)
    limit = tv.boundary_limit(plant, wind, K).deflection
    return plant, tv.trim_then_hold(plant, wind, limit, K), wind


def exact_triangle(tau_beta: float, K: float, times: np.ndarray) -> np.ndarray:
    """Eq (13) on the boundary of eq (12), with so many digits that none of its growth matters."""
    with mp.workdps(120):
        x, p = mp.mpf(tau_beta), mp.mpf(tau_beta) / 2
        right = 2 * mp.exp(-p) - mp.exp(-2 * p)
        y = mp.findroot(
            lambda y: (1 - p * y * (1 - K)) * mp.exp(-p * y * K) - right,
            tv.boundary.triangular_limit(tau_beta, K),
        )

        def ramp(u: mp.mpf) -> mp.mpf:
            return mp.sinh(x * u) - x * u if u > 0 else mp.mpf(0)

        def attitude(t: mp.mpf) -> mp.mpf:
            since = t - y * K / 2
            held = y * p * (1 - K) * (mp.cosh(x * since) - 1) if since > 0 else 0
            total = ramp(since) - held - 2 * ramp(t - mp.mpf(1) / 2) + ramp(t - 1)
            return 2 / x * total

        return np.array([float(attitude(mp.mpf(float(t)))) for t in times])


@pytest.mark.parametrize("K", [1.0, 0.5, 0.0])
@pytest.mark.parametrize("tau_beta", [4.0, 10.0, 20.0, 40.0])
def test_thirteen_digits_are_right_on_the_boundary_at_three_durations(
    tau_beta: float, K: float
) -> None:
    plant, deflection, wind = on_boundary("fixed-path", tau_beta, K)
    x = np.array([0.1, 0.45, 0.7, 1.0, 1.5, 2.0, 3.0])
    computed = tv.attitude_responses(plant, deflection, wind, x * wind.duration)["attitude"]

    expected = exact_triangle(tau_beta, K, x)
    np.testing.assert_allclose(computed / -0.1, expected, rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize("K", [1.0, 0.5, 0.0])
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("tau_beta", [0.5, 4.0])
def test_the_response_solves_the_state_equations(model: str, tau_beta: float, K: float) -> None:
    plant, deflection, wind = on_boundary(model, tau_beta, K)
    A, B, C, D = plant.matrices()
    edges = sorted({*deflection.knots.tolist(), *wind.knots.tolist()})
    times = np.linspace(0.0, 1.3 * wind.duration, 40)
    state, rows = np.zeros(len(A)), []
    for start, stop in zip(edges, [*edges[1:], times[-1] + 1.0], strict=True):
        inside = times[(times >= start) & (times < stop)]
        answer = solve_ivp(
            lambda t, x: A @ x + B @ [float(deflection(t)), float(wind(t))],
            (start, np.nextafter(stop, start)),
            state,
            "DOP853",
            dense_output=True,
            rtol=1e-12,
            atol=1e-16,
        )
        rows.append(answer.sol(inside))
        state = answer.y[:, -1]
    inputs = np.stack([deflection(times), wind(times)])
    expected = C @ np.concatenate(rows, axis=1) + D @ inputs

    result = tv.attitude_responses(plant, deflection, wind, times)
    np.testing.assert_allclose(result.outputs, expected, rtol=0, atol=2e-9)


@pytest.mark.parametrize("capability", [0.8, 0.9, 1.0, 1.1, 1.2])
@pytest.mark.parametrize("K", [1.0, 0.5, 0.0])
def test_the_closed_forms_of_the_report_agree(capability: float, K: float) -> None:
    c, x = coefficients(), np.linspace(-0.2, 1.6, 91)
    wind = tv.TriangularWind(peak=-0.1, duration=4.0 / c.beta)
    for model, limit in (
        ("fixed-path", tv.boundary.triangular_limit(4.0, K)),
        ("drift", tv.boundary.triangular_limit_with_drift(4.0, K, c.beta, c.b1, c.b2)),
    ):
        y, plant = capability * limit, tv.Plant(c, model)
        held = tv.trim_then_hold(plant, wind, y * c.B * 0.1, K)
        computed = tv.attitude_responses(plant, held, wind, x * wind.duration)["attitude"] / 0.1
        drift = () if model == "fixed-path" else (c.beta, c.b1, c.b2)
        formula = triangular_attitude if model == "fixed-path" else triangular_attitude_with_drift
        np.testing.assert_allclose(computed, formula(x, 4.0, y, K, *drift), rtol=0, atol=2e-12)


def test_eq_9_agrees_in_a_rectangular_wind() -> None:
    c, x = coefficients(), np.linspace(-0.2, 2.0, 56)
    wind, plant = tv.RectangularWind(peak=-0.1, duration=2.0 / c.beta), tv.Plant(c, "fixed-path")
    for y in (0.5, 0.86, 1.0):
        held = tv.linear.ConstantDeflection(limit=y * c.B * 0.1)
        computed = tv.attitude_responses(plant, held, wind, x * wind.duration)["attitude"]
        np.testing.assert_allclose(computed / 0.1, rectangular_attitude(x, 2.0, y), atol=1e-13)


def test_the_peak_error_of_the_report_is_reached_at_the_time_of_figure_3() -> None:
    x = np.linspace(0.0, 1.2, 24001)
    error = triangular_attitude(x, 4.0, 1.1 * tv.boundary.triangular_limit(4.0, 1.0), 1.0)

    assert np.max(error) == pytest.approx(0.1642, abs=5e-5)
    assert x[np.argmax(error)] == pytest.approx(0.877, abs=5e-4)
    assert x[np.argmax(error < 0.0)] == pytest.approx(1.080, abs=5e-4)


def test_a_closed_form_beyond_saturation_is_refused() -> None:
    with pytest.raises(tv.InputError, match="trim never saturates"):
        triangular_attitude(1.0, 20.0, 1.1, 1.0)


def test_time_response_data_carries_the_names_and_plots() -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    plant, deflection, wind = on_boundary("drift-exact", 4.0, 1.0)
    response = tv.attitude_response(plant, deflection, wind, np.linspace(0, 10, 50))

    names = ["attitude", "attitude_rate", "flight_path_angle", "angle_of_attack"]
    assert names == response.output_labels
    assert ["deflection", "wind"] == response.input_labels
    np.testing.assert_array_equal(deflection(response.time), response.inputs["deflection"])
    angle = response.outputs["attitude"] - response.outputs["flight_path_angle"]
    np.testing.assert_allclose(
        response.outputs["angle_of_attack"], angle - response.inputs["wind"], atol=1e-15
    )
    response.plot()
    plt.close("all")


def test_a_knot_on_the_grid_makes_forced_response_right_and_one_off_it_does_not() -> None:
    import control

    c = coefficients()
    plant = tv.Plant(c, "fixed-path")
    wind = tv.TriangularWind(peak=0.1, duration=4.0 / c.beta)
    held = tv.linear.ConstantDeflection(limit=-0.37 * c.B * 0.1)
    errors = []
    for count in (400, 401):  # 401 points have the peak of the wind among them
        times = np.linspace(0.0, wind.duration, count)
        exact = tv.attitude_response(plant, held, wind, times)
        inputs = np.stack([held(times), wind(times)])
        computed = control.forced_response(plant.ss(), times, inputs).outputs[0]
        errors.append(np.max(np.abs(computed - exact.outputs["attitude"])))

    assert errors[1] < 1e-13
    assert errors[0] > 1e-8


@pytest.mark.parametrize("model", MODELS)
def test_a_batch_is_the_loop_over_its_elements(model: str) -> None:
    c = coefficients()
    many = c.replace(mu_alpha=c.mu_alpha * np.array([[1.0], [1.3]]))
    winds = tv.TriangularWind(peak=np.array([0.1, -0.05, 0.02]), duration=np.array([3.0, 7.0, 9.0]))
    held = tv.linear.ConstantDeflection(limit=np.array([-0.003, 0.002, -0.001]))
    times = np.linspace(-1.0, 12.0, 27)
    result = tv.attitude_responses(tv.Plant(many, model), held, winds, times)

    assert result.outputs.shape[:2] == (2, 3)
    for i, j in np.ndindex(2, 3):
        one = tv.attitude_responses(
            tv.Plant(c.replace(mu_alpha=float(np.asarray(many.mu_alpha)[i, 0])), model),
            tv.linear.ConstantDeflection(limit=[-0.003, 0.002, -0.001][j]),
            tv.TriangularWind(peak=[0.1, -0.05, 0.02][j], duration=[3.0, 7.0, 9.0][j]),
            times,
        )
        np.testing.assert_allclose(result.outputs[i, j], one.outputs, rtol=1e-11, atol=1e-15)


@given(st.floats(0.3, 12.0), st.floats(0.0, 1.0), st.floats(0.1, 5.0), st.sampled_from(MODELS))
@settings(max_examples=40, deadline=None)
def test_superposition_scaling_shift_and_sign(
    duration: float, share: float, late: float, model: str
) -> None:
    plant = tv.Plant(coefficients(), model)
    wind, held = (
        tv.TriangularWind(peak=0.1, duration=duration),
        tv.linear.ConstantDeflection(limit=-0.004),
    )
    times = np.linspace(0.0, 10.0, 21)
    zero = held * 0.0
    both = tv.attitude_responses(plant, held * share, wind * -2.0, times).outputs
    first = tv.attitude_responses(plant, held, zero, times).outputs
    second = tv.attitude_responses(plant, zero, wind, times).outputs
    shifted = tv.attitude_responses(plant, held.shift(late), wind.shift(late), times + late).outputs

    scale = np.max(np.abs(first)) + np.max(np.abs(second))
    np.testing.assert_allclose(both, share * first - 2.0 * second, rtol=0, atol=1e-11 * scale)
    np.testing.assert_allclose(shifted, first + second, rtol=0, atol=1e-11 * scale)


def test_time_scales_with_beta() -> None:
    times = np.linspace(0.0, 9.0, 31)
    answers = []
    for beta in (1.0, 0.4):
        plant = tv.Plant(tv.Coefficients.from_beta(beta=beta, B=0.1), "fixed-path")
        wind = tv.TriangularWind(peak=0.1, duration=4.0 / beta)
        held = tv.linear.ConstantDeflection(limit=-0.0037)
        answers.append(tv.attitude_responses(plant, held, wind, times / beta)["attitude"])

    np.testing.assert_allclose(answers[1], answers[0], rtol=1e-12, atol=1e-16)


def test_a_vehicle_without_aerodynamic_moment_is_a_double_integrator() -> None:
    plant = tv.Plant(tv.Coefficients(mu_alpha=0.0, mu_delta=2.0), "fixed-path")
    held = tv.linear.ConstantDeflection(limit=-0.01, start=1.0)
    wind = tv.RectangularWind(peak=0.1, duration=2.0)
    times = np.array([0.0, 1.0, 2.5, 40.0])
    computed = tv.attitude_responses(plant, held, wind, times)["attitude"]

    np.testing.assert_allclose(computed, 0.01 * np.maximum(times - 1.0, 0.0) ** 2, rtol=1e-14)


@pytest.mark.parametrize(
    ("times", "names"),
    [
        ([], "one row of numbers"),
        ([[0.0, 1.0]], "one row"),
        ([0.0, np.nan], "timepts must be finite"),
    ],
)
def test_bad_times_are_refused(times: list[float], names: str) -> None:
    plant, deflection, wind = on_boundary("fixed-path", 4.0, 1.0)
    with pytest.raises(tv.InputError, match=names):
        tv.attitude_response(plant, deflection, wind, times)


def test_batches_are_refused_where_one_case_is_asked_for() -> None:
    plant = tv.Plant(coefficients(), "fixed-path")
    winds = tv.TriangularWind(peak=[0.1, 0.2], duration=5.0)
    with pytest.raises(tv.InputError, match="attitude_responses"):
        tv.attitude_response(plant, tv.linear.ConstantDeflection(limit=-0.01), winds, [0.0, 1.0])
    with pytest.raises(tv.InputError, match="broadcast together"):
        tv.attitude_responses(
            plant, tv.linear.ConstantDeflection(limit=[-0.01] * 3), winds, [0.0, 1.0]
        )
    with pytest.raises(tv.InputError, match="output must be one of"):
        tv.attitude_responses(plant, tv.linear.ConstantDeflection(limit=-0.01), winds, [0.0])[
            "altitude"
        ]


@pytest.mark.thorough
@pytest.mark.parametrize("model", ["fixed-path", "drift", "drift-exact"])
@pytest.mark.parametrize("mu_alpha", [1e-8, 1e-10, 1e-12, 1e-16])
def test_a_vehicle_next_to_neutral_answers_like_its_series(mu_alpha: float, model: str) -> None:
    """Without aerodynamic moment eqs (5), (B7) give the double integral, (B8) adds b1 t^3/6."""
    c = tv.Coefficients(
        mu_alpha=mu_alpha, mu_delta=1.0, b1=0.03, b2=0.02, C1=0.03, C2=0.01 * mu_alpha
    )
    held, wind = (
        tv.linear.ConstantDeflection(limit=-0.005),
        tv.TriangularWind(peak=0.1, duration=5.0),
    )
    computed = tv.attitude_responses(tv.Plant(c, model), held, wind, [10.0])["attitude"][0]

    expected = 0.005 * (50.0 + (5.0 if model == "drift" else 0.0))
    assert computed == pytest.approx(expected, rel=1e-11 + 1e3 * mu_alpha)


@pytest.mark.parametrize("late", [-150.0, 150.0, 1500.0])
def test_an_early_or_late_flight_is_the_same_flight(late: float) -> None:
    plant = tv.Plant(tv.Coefficients.from_beta(beta=5.0, B=0.1), "fixed-path")
    wind, held = (
        tv.TriangularWind(peak=0.1, duration=5.0),
        tv.linear.ConstantDeflection(limit=-0.05),
    )
    times = np.array([-1.0, -1e-3, 0.0, 0.5, 2.0])
    expected = tv.attitude_responses(plant, held, wind, times).outputs
    moved = held.shift(late), wind.shift(late)

    computed = tv.attitude_responses(plant, *moved, times + late).outputs
    np.testing.assert_allclose(computed, expected, rtol=1e-10, atol=1e-15)
    assert not tv.linear.judge(plant, *moved).stable
    assert not np.any(computed[:, :2])
