"""Solutions of initial value problems: closed forms, a jump of a derivative, and an early end."""

import numpy as np
import pytest

from tvclin.numerics.chebyshev import initial_value_solution


def everywhere(x):
    return True


@pytest.mark.parametrize("stop", [30.0, -30.0])
def test_an_oscillation_is_that_of_the_closed_form(stop):
    def rates(t, x):
        return np.stack([x[1], -x[0]])

    solution = initial_value_solution(rates, np.array([1.0, 0.0]), (0.0, stop), everywhere)
    times = np.linspace(0.0, stop, 301)
    np.testing.assert_allclose(solution(times), [np.cos(times), -np.sin(times)], atol=1e-11)
    assert solution(0.0).tolist() == [1.0, 0.0]
    np.testing.assert_array_equal(solution(times[17]), solution(times)[:, 17])


def test_a_jump_of_a_derivative_is_followed():
    solution = initial_value_solution(
        lambda t, x: np.abs(t - 0.3)[np.newaxis], np.zeros(1), (0.0, 1.0), everywhere
    )
    times = np.linspace(0.0, 1.0, 101)
    expected = 0.5 * (0.09 + np.sign(times - 0.3) * (times - 0.3) ** 2)
    np.testing.assert_allclose(solution(times)[0], expected, atol=1e-12)


def test_a_solution_ends_where_it_is_no_longer_valid():
    def rates(t, x):
        return x**2

    solution = initial_value_solution(
        rates, np.ones(1), (0.0, 2.0), lambda x: bool(np.all(x < 1e3))
    )
    assert solution.ends[-1] == pytest.approx(1.0 - 1e-3, abs=1e-8)  # x = 1/(1 - t)
    assert solution(0.5)[0] == pytest.approx(2.0, rel=1e-11)
