"""Boundaries in triangular winds: eq (12) and (18) for many cases."""

import numpy as np
from peers import ratio
from scipy.optimize import brentq
from scipy.special import wrightomega

from tvclin.closed_forms import triangular_limit, triangular_limit_with_drift

CASES = 1_000_000
FEW = 300
RNG = np.random.default_rng(1)
TAU_BETA = np.exp(RNG.uniform(np.log(1e-3), np.log(40.0), CASES))
K = RNG.uniform(0.0, 1.0, CASES)
FLOOR = "three exponentials, nine divisions and two roots, four or eight cases at once"


def test_boundary_12_against_brentq(benchmark):
    def printed(y, p, band, R):
        return (1 - p * y * (1 - band)) * np.exp(-p * y * band) - R

    def loop():
        for tau_beta, band in zip(TAU_BETA[:FEW], K[:FEW], strict=True):
            p = tau_beta / 2.0
            R = 2.0 * np.exp(-p) - np.exp(-2.0 * p)
            brentq(printed, 0.0, 1.0, args=(p, band, R))

    ratio(
        benchmark,
        lambda: triangular_limit(TAU_BETA, K),
        loop,
        peer_name="scipy.optimize.brentq loop",
        per=CASES,
        peer_per=FEW,
        floor=FLOOR,
    )


def test_boundary_12_against_wrightomega(benchmark):
    p, band = TAU_BETA / 2.0, np.clip(K, 1e-6, 1.0 - 1e-6)

    def by_lambert():
        c = band / (1.0 - band)
        L = p - np.log(2.0 - np.exp(-p))
        return (1.0 - wrightomega(np.log(c) + c - L) / c) / (p * (1.0 - band))

    ratio(
        benchmark,
        lambda: triangular_limit(TAU_BETA, K),
        by_lambert,
        peer_name="scipy.special.wrightomega",
        per=CASES,
        peer_per=CASES,
        floor=FLOOR,
    )


def test_boundary_18_against_brentq(benchmark):
    beta, b1, b2 = 0.53, 0.022, -0.016

    K1, kappa, rho = (beta + b2) / (beta + b1), (b1 - b2) / (beta + b1), b1 / beta

    def left(z, band, L):
        x = band * z
        curve = (np.exp(-rho * x) - 1.0 + rho * x) / rho**2
        return -K1 * np.expm1(x - L) - (1.0 - band) * z - kappa * (x + curve)

    def loop():
        for tau_beta, band in zip(TAU_BETA[:FEW], K[:FEW], strict=True):
            p = tau_beta / 2.0
            L = p - np.log(2.0 - np.exp(-p))
            brentq(left, 1e-12, min(p / band, 1.0 / (1.0 - band)), args=(band, L))

    ratio(
        benchmark,
        lambda: triangular_limit_with_drift(TAU_BETA, K, beta, b1, b2),
        loop,
        peer_name="scipy.optimize.brentq loop",
        per=CASES,
        peer_per=FEW,
        floor="about five steps of Newton, each with three exponentials",
    )
