"""Covariances and Gaussian statistics, compared with scipy's exponential and with quadrature."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import expm
from scipy.stats import foldnorm, multivariate_normal, norm

from tvclin.numerics.covariance import (
    absolute_covariance,
    constant_over_steps,
    crossing_rate,
    mean_absolute,
    periodic_covariance,
    stationary_covariance,
    steps,
)
from tvclin.numerics.propagation import GAUSS_NODES


def system(n=5, seed=2):
    """Return a stable A and a noise N of low rank."""
    random = np.random.default_rng(seed)
    A = random.standard_normal((n, n))
    A -= (np.linalg.eigvals(A).real.max() + 0.3) * np.eye(n)
    b = random.standard_normal((n, 2))
    return A, b @ b.T


@pytest.mark.parametrize("held", [(), (1,), (0, 4, 5)], ids=["none", "one", "three"])
def test_steps_are_those_of_van_loan(held):
    """Also with states that are held, of which the first acts on the others."""
    A, noise = (np.insert(np.insert(m, held, 0.0, 0), held, 0.0, 1) for m in system())
    n = len(A)
    if held:
        A[:, held[0]] = np.linspace(0.1, 0.9, n)
        A[held[0]] = 0.0
    for h in (0.01, 0.7):
        whole = expm(np.block([[-A, noise], [np.zeros_like(A), A.T]]) * h)
        F = whole[n:, n:].T
        result = steps(A, noise, np.array([h]))
        assert np.allclose(result[0][0], F, rtol=1e-11, atol=1e-13)
        assert np.allclose(result[1][0], F @ whole[:n, n:], rtol=1e-10, atol=1e-12)


def test_a_long_step_of_a_fast_system_ends_in_the_stationary_covariance():
    A, noise = system()
    fast = 400.0 * A  # where e^(-A h) of Van Loan has lost all digits
    P = stationary_covariance(fast, noise)
    assert np.allclose(fast @ P + P @ fast.T, -noise, atol=1e-12)
    F, Q = steps(fast, noise, np.array([2.0]))
    assert np.allclose(Q[0], P, rtol=1e-10, atol=1e-14)
    assert np.allclose(periodic_covariance(F[0], Q[0]), P, rtol=1e-10, atol=1e-14)


@pytest.mark.thorough
def test_a_varying_step_is_right_to_fourth_order():
    """Against a thousand small steps, each with the system of its middle."""
    A0, N0 = system()
    A1, N1 = system(seed=3)

    def at(t):
        return A0 + np.sin(t) * A1, N0 + t**2 * N1

    errors = []
    for h in (0.2, 0.1):
        nodes = [at(0.3 + h * node) for node in GAUSS_NODES]
        A, noise = (tuple(np.array([node[k]]) for node in nodes) for k in range(2))
        result = steps(*constant_over_steps(A, noise, np.array([h])), np.array([h]))
        F, Q, fine = np.eye(5), np.zeros((5, 5)), h / 1000
        for k in range(1000):
            one = steps(*at(0.3 + fine * (k + 0.5)), np.array([fine]))
            F, Q = one[0][0] @ F, one[0][0] @ Q @ one[0][0].T + one[1][0]
        errors.append(max(np.abs(result[0][0] - F).max(), np.abs(result[1][0] - Q).max()))
    assert errors[0] < 1e-3
    assert errors[1] < errors[0] / 20.0  # of one step 2^5


def mean_of_folded(mean, spread):
    """Return E|x| by scipy's own folded normal distribution."""
    return foldnorm.mean(abs(mean) / spread, scale=spread)


@pytest.mark.parametrize("means", [(0.0, 0.0), (0.7, -0.4), (2.5, 3.0)])
@pytest.mark.parametrize("r", [-0.95, 0.3, 0.99])
def test_the_covariance_of_absolute_values_is_that_of_their_density(means, r):
    d = np.array([1.3, 0.6])
    result = absolute_covariance(
        *(tuple(map(np.float64, pair)) for pair in (means, d)), np.float64(r)
    )
    if not any(means):
        expected = 2.0 / np.pi * d.prod() * (np.sqrt(1.0 - r**2) + r * np.arcsin(r) - 1.0)
        assert np.isclose(result, expected, rtol=1e-12)
        return
    # E|x| |y| by conditioning on x
    inner = d[1] * np.sqrt(1.0 - r**2)

    def product(x):
        mean = means[1] + r * d[1] * (x - means[0]) / d[0]
        folded = mean_of_folded(mean, inner)
        return abs(x) * folded * norm.pdf(x, means[0], d[0])

    ends = means[0] - 9 * d[0], means[0] + 9 * d[0]
    whole = quad(product, *ends, points=[0.0, means[0]], epsabs=1e-9, limit=100)[0]
    single = [mean_of_folded(m, s) for m, s in zip(means, d, strict=True)]
    assert np.isclose(mean_absolute(np.float64(means[0]), np.float64(d[0])), single[0], rtol=1e-9)
    assert np.isclose(result, whole - single[0] * single[1], rtol=1e-6, atol=1e-7)


def test_the_rate_of_crossings_is_rice_s_integral():
    mean, s, rate, d, rho, limit = 0.3, 0.8, -0.5, 1.7, 0.4, 1.1
    covariance = [[s**2, rho * s * d], [rho * s * d, d**2]]
    joint = multivariate_normal([mean, rate], covariance)
    upward = quad(lambda v: v * joint.pdf([limit, v]), 0.0, 30.0)[0]
    downward = quad(lambda v: -v * joint.pdf([-limit, v]), -30.0, 0.0)[0]
    result = crossing_rate(limit, *(np.float64(x) for x in (mean, s, rate, d, rho)))
    assert np.isclose(result, upward + downward, rtol=1e-9)
    still = crossing_rate(limit, *(np.float64(x) for x in (0.0, s, 0.0, d, 0.0)))
    assert np.isclose(still, d / s / np.pi * np.exp(-(limit**2) / (2 * s**2)), rtol=1e-12)
