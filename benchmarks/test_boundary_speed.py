"""Boundaries of 10,000 vehicles in as many winds, beside brentq on (4b) and (12), one by one."""

from math import exp

import numpy as np
import pytest
from peers import PROCESSOR, ratio
from scipy.optimize import brentq

import tvclin as tv
from tvclin.linear.plant import MODELS

CASES, KNOTS, FEW, ROOTS = 10_000, 100, 3, 500


def vehicles(rng, model):
    c = tv.Coefficients.from_beta(
        beta=rng.uniform(0.3, 0.7, CASES),
        B=rng.uniform(0.08, 0.14, CASES),
        C1=rng.uniform(0.02, 0.03, CASES),
        C2=rng.uniform(0.002, 0.005, CASES),
        b1=rng.uniform(0.02, 0.04, CASES),
        b2=rng.uniform(-0.02, 0.018, CASES),
        q=rng.uniform(1e-4, 3e-4, CASES),
    )
    return c, model


def triangles(rng):
    duration = rng.uniform(3.0, 20.0, CASES)
    return lambda: tv.TriangularWind(peak=np.full(CASES, 0.08), duration=duration)


def samples(rng):
    rough = np.abs(np.cumsum(rng.normal(size=(CASES, KNOTS)), axis=-1))
    rough *= np.sin(np.linspace(0.0, np.pi, KNOTS))
    angle = 0.08 * rough / rough.max(axis=-1, keepdims=True)
    return lambda: tv.SampledWind(time=np.linspace(0.0, 30.0, KNOTS), angle=angle)


def by_brentq(plant, wind, dead_band):
    """Return the limit at which the residue of the whole control is zero, near its largest root."""
    full = -plant.coefficients.B * float(wind.peak)

    def residue(y):
        control = tv.trim_then_hold(plant, wind, y * full, dead_band)
        return float(np.real(tv.residues(plant, control, wind)[0]))

    tried = np.linspace(0.02, 0.98, 25)
    sides = np.sign([residue(y) for y in tried])
    last = np.flatnonzero(sides[:-1] != sides[1:])[-1]
    return brentq(residue, tried[last], tried[last + 1], xtol=1e-15, rtol=1e-14)


@pytest.mark.parametrize(
    ("model", "winds"),
    [
        ("fixed-path", triangles),
        ("drift", triangles),
        ("drift-exact", triangles),
        ("drift-and-speed", triangles),
        ("fixed-path", samples),
        ("drift-exact", samples),
    ],
)
def test_boundary_limit_of_a_batch(benchmark, model, winds):
    """With everything it does: poles, the exit of the dead band, status."""
    rng = np.random.default_rng(1)
    coefficients, model = vehicles(rng, model)
    wind, K = winds(rng), rng.uniform(0.05, 0.9, CASES)

    def ours():
        return tv.boundary_limit(tv.Plant(coefficients, model), wind(), K)

    found = ours()
    every = tv.Plant(coefficients, model), wind()
    cases = [(*(one.case(k, (CASES,)) for one in every), float(K[k])) for k in range(FEW)]
    beside = np.array([by_brentq(*case) for case in cases])
    apart = np.abs(found.limit[:FEW] / beside - 1.0).max()
    ratio(
        benchmark,
        ours,
        lambda: [by_brentq(*case) for case in cases],
        peer_name=f"scipy.optimize.brentq on `residues`, the same to {apart:.0e}",
        per=CASES,
        peer_per=FEW,
        floor="exponentials of some seven steps",
    )


def roots_of_12(tau_beta, dead_bands):
    """Return the roots of eq (12) as printed, for each of several tau beta and dead bands."""
    found = []
    for x, K in zip(tau_beta, dead_bands, strict=True):
        p = x / 2.0
        R = 2.0 * exp(-p) - exp(-2.0 * p)

        def left(y, p=p, K=K, R=R):
            return (1.0 - p * y * (1.0 - K)) * exp(-p * y * K) - R

        found.append(brentq(left, 0.0, 1.0, xtol=1e-15, rtol=1e-14))
    return found


@pytest.mark.parametrize("dead_band", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("model", MODELS)
def test_a_boundary_limit_takes_less_than_half_of_a_root_of_eq_12(benchmark, model, dead_band):
    """Any model and dead band beside roots of eq (12), which has neither path nor other winds."""
    rng = np.random.default_rng(1)
    coefficients, model = vehicles(rng, model)
    duration = rng.uniform(3.0, 20.0, CASES)
    tau_beta = (duration * coefficients.beta)[:ROOTS].tolist()
    dead_bands = rng.uniform(0.05, 0.9, ROOTS).tolist()
    found = ratio(
        benchmark,
        lambda: tv.boundary_limit(
            tv.Plant(coefficients, model),
            tv.TriangularWind(peak=np.full(CASES, 0.08), duration=duration),
            dead_band,
        ),
        lambda: roots_of_12(tau_beta, dead_bands),
        peer_name="scipy.optimize.brentq on eq (12)",
        per=CASES,
        peer_per=ROOTS,
        floor="poles, and exponentials of some seven steps",
        clock=PROCESSOR,
    )
    assert found > 2.0
