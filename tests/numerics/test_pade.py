"""The Pade approximation of a delay, and the bound that proves a loop's stability with both."""

import control
import mpmath
import numpy as np
import pytest

from tvclin.numerics.loop_margins import stability
from tvclin.numerics.loops import StateLoop
from tvclin.numerics.state_space import pade_delay, pade_keeps_stability

ORDERS = range(1, 11)


@pytest.mark.parametrize("order", ORDERS)
def test_the_delay_is_the_pade_approximation_of_python_control(order):
    A, B, C, D = pade_delay(0.3, order)
    expected = control.tf(*control.pade(0.3, order))
    omega = np.geomspace(0.1, 100.0, 50)
    result = control.ss(A, B, C, D)(1j * omega)
    np.testing.assert_allclose(result, expected(1j * omega), rtol=1e-9)


@pytest.mark.parametrize("order", ORDERS)
def test_the_error_of_the_approximation_is_below_its_bound(order):
    """The bound of the docstring, with the coefficients of the approximation in 120 digits."""
    with mpmath.workdps(120):
        f = mpmath.factorial
        factor = f(order) ** 2 / (f(2 * order) * f(2 * order + 1))
        terms = [
            f(2 * order - k) * f(order) / (f(2 * order) * f(k) * f(order - k))
            for k in range(order + 1)
        ]
        for x in (0.01, 0.3, 1.0, 3.0, 10.0, 40.0):
            above, below = (
                sum(c * (sign * 1j * mpmath.mpf(x)) ** k for k, c in enumerate(terms))
                for sign in (-1, 1)
            )
            error = abs(mpmath.exp(-1j * mpmath.mpf(x)) - above / below)
            bound = factor * mpmath.mpf(x) ** (2 * order + 1)
            assert error <= bound
            assert x > 0.3 or error > 0.9 * bound


def random_loop(rng, modes=3):
    """A stable or unstable loop of lightly damped modes behind a second-order actuator."""
    blocks = []
    for frequency in rng.uniform(0.5, 20.0, modes):
        damping = rng.uniform(-0.05, 0.7)
        blocks.append([[0.0, 1.0], [-(frequency**2), -2.0 * damping * frequency]])
    n = 2 * modes
    A, B, C = np.zeros((n + 2, n + 2)), np.zeros(n + 2), np.zeros(n + 2)
    for k, block in enumerate(blocks):
        A[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = block
        A[2 * k + 1, n] = rng.normal()
    A[n:, n:], B[-1] = [[0.0, 1.0], [-625.0, -35.0]], 625.0
    C[:n] = rng.normal(size=n) * np.tile([3.0, 1.0], modes)
    return A, B, C


@pytest.mark.thorough
def test_a_proved_approximation_has_as_many_unstable_poles_as_the_exact_delay():
    rng, proved, misled = np.random.default_rng(1), 0, 0
    for _ in range(150):
        (A, B, C), delay, order = random_loop(rng), rng.choice([0.02, 1.0]), rng.integers(1, 3)
        a, b, c, d = pade_delay(delay, order)
        closed = np.block([[A - np.outer(B * d[0, 0], C), np.outer(B, c[0])], [-np.outer(b, C), a]])
        into, out = np.append(B * d[0, 0], b[:, 0]), np.append(-C, np.zeros(order))
        exact = stability(
            StateLoop.balanced(A[None], B[None], C[None], np.zeros(1), np.array([delay]))
        )
        same = np.sum(np.linalg.eigvals(closed).real > 0.0) == exact.unstable_poles[0]
        keeps = pade_keeps_stability(closed, into, out, delay, order)
        assert same or not keeps
        proved, misled = proved + keeps, misled + (not same)
    assert proved > 40
    assert misled > 5
