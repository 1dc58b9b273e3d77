"""Linear equations whose coefficients vary, against closed forms and the matrix exponential."""

import numpy as np
import pytest
from scipy.linalg import expm

from tvclin.answers.sizing.collocation import mesh, solved


@pytest.mark.parametrize("backwards", [False, True])
def test_constant_coefficients_give_the_matrix_exponential(backwards) -> None:
    A = np.array([[0.3, 1.0, 0.2], [0.5, -0.1, 0.4], [0.0, 0.3, -2.0]])
    times = mesh(np.array([1.0, 2.5, 6.0]), 2.0)
    found = solved(
        lambda t: (np.broadcast_to(A, (t.size, 3, 3)), np.zeros((t.size, 3, 3))),
        times,
        np.eye(3),
        backwards=backwards,
    )
    begin = times[-1] if backwards else times[0]
    for t in np.linspace(1.0, 6.0, 23):
        assert found(t) == pytest.approx(expm(A * (t - begin)), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("backwards", [False, True])
def test_a_growth_rate_and_a_source_that_vary_give_their_closed_form(backwards) -> None:
    # y = sin(3 t) e^(t^2/2) + 1/(1 + t) solves y' = t y + g
    def exact(t):
        return np.sin(3.0 * t) * np.exp(0.5 * t**2) + 1.0 / (1.0 + t)

    def terms(t):
        rest = 3.0 * np.cos(3.0 * t) * np.exp(0.5 * t**2) - (1.0 + t) ** -2 - t / (1.0 + t)
        return t.reshape(-1, 1, 1), rest.reshape(-1, 1, 1)

    times = mesh(np.array([0.0, 2.0]), 3.0)
    first = np.full((1, 1), exact(2.0 if backwards else 0.0))
    found = solved(terms, times, first, backwards=backwards)
    t = np.linspace(0.0, 2.0, 401)
    assert found(t)[:, 0, 0] == pytest.approx(exact(t), abs=1e-8)


def test_a_direction_that_grows_beyond_all_numbers_keeps_its_length() -> None:
    A = np.array([[2.0, 1.0], [0.0, 1.0]])
    times = mesh(np.array([0.0, 1e3]), 2.0)
    found = solved(
        lambda t: (np.broadcast_to(A, (t.size, 2, 2)), np.zeros((t.size, 2, 1))),
        times,
        np.array([[0.0], [1.0]]),
        direction=True,
    )
    # y = (e^(2 t) - e^t, e^t)
    begin = times[:-1]
    exact = np.stack([-np.expm1(-begin), np.exp(-begin)], axis=-1)
    exact /= np.linalg.norm(exact, axis=-1, keepdims=True)
    assert found(begin)[:, :, 0] == pytest.approx(exact, abs=1e-9)


def test_a_jump_of_the_source_at_a_time_of_the_mesh_costs_no_accuracy() -> None:
    times = mesh(np.array([0.0, 1.0, 2.0]), 0.1)
    found = solved(
        lambda t: (np.zeros((t.size, 1, 1)), np.where(t < 1.0, 1.0, -5.0).reshape(-1, 1, 1)),
        times,
        np.zeros((1, 1)),
    )
    t = np.linspace(0.0, 2.0, 9)
    assert found(t)[:, 0, 0] == pytest.approx(np.where(t < 1.0, t, 6.0 - 5.0 * t), abs=1e-12)
