"""Random plants, winds and deflections against the same motion carried with sixty digits."""

import mpmath as mp
import numpy as np
import pytest

import tvclin as tv

MODELS = ("fixed-path", "drift", "drift-exact", "drift-and-speed")
CASES = 6
TIMES = 9


def random_plant(rng: np.random.Generator, model: str) -> tv.Plant:
    beta, B = rng.uniform(0.2, 1.0), rng.uniform(0.05, 0.5) * rng.choice([-1.0, 1.0])
    b1 = rng.uniform(0.01, 0.1)
    c = tv.Coefficients.from_beta(
        beta=beta,
        B=B,
        C1=b1 * rng.uniform(0.8, 0.95),
        C2=beta**2 * rng.uniform(0.005, 0.02),
        b1=b1,
        b2=b1 * rng.uniform(0.3, 0.8),
        q=rng.uniform(1e-4, 4e-4),
    )
    return tv.Plant(c, model)


def random_inputs(rng: np.random.Generator) -> tuple[tv.History, tv.History]:
    """A wind of straight pieces with a jump, and a deflection that switches; knots anywhere."""
    time = np.sort(rng.uniform(0.0, 9.0, 5))
    time[2] = time[1]
    wind = tv.SampledWind(time=time, angle=rng.uniform(-0.1, 0.1, 5))
    switches = np.sort(rng.uniform(0.5, 9.0, 2))
    return wind, tv.BangBang(limit=rng.uniform(0.001, 0.02), switch_times=switches, start=0.2)


def carried(plant: tv.Plant, inputs: list[tv.History], times: np.ndarray) -> np.ndarray:
    """The outputs at increasing times: one matrix exponential of (state, inputs, slopes) a step."""
    A, B, C, D = (mp.matrix(m.tolist()) for m in plant.matrices())
    n = A.rows
    big = mp.zeros(n + 4)
    big[:n, :n], big[:n, n : n + 2] = A, B
    big[n, n + 2] = big[n + 1, n + 3] = 1
    edges = sorted({0.0, *times.tolist(), *(float(k) for h in inputs for k in h.knots)})
    state, rows = mp.zeros(n, 1), []
    for start, stop in zip(edges, [*edges[1:], edges[-1] + 1.0], strict=True):
        values = [mp.mpf(0)] * 2
        slopes = [mp.mpf(0)] * 2
        for i, history in enumerate(inputs):
            piece = np.searchsorted(history.knots, start, side="right") - 1
            if piece >= 0:
                c = history.pieces.coefficients[piece, 0]
                slopes[i] = mp.mpf(float(c[1]))
                since = mp.mpf(start) - mp.mpf(float(history.knots[piece]))
                values[i] = mp.mpf(float(c[0])) + slopes[i] * since
        if start in times:
            rows.append([float(v) for v in C * state + D * mp.matrix(values)])
        whole = mp.matrix([*state, *values, *slopes])
        state = (mp.expm(big * (mp.mpf(stop) - mp.mpf(start))) * whole)[:n, 0]
    return np.array(rows).T


@pytest.mark.parametrize("model", MODELS)
def test_random_responses_keep_eleven_digits(model: str) -> None:
    rng = np.random.default_rng(MODELS.index(model))
    for _ in range(CASES):
        plant, (wind, deflection) = random_plant(rng, model), random_inputs(rng)
        times = np.sort(rng.uniform(0.0, 16.0, TIMES))
        with mp.workdps(60):
            expected = carried(plant, [deflection, wind], times)
        found = tv.attitude_responses(plant, deflection, wind, times).outputs

        scale = np.max(np.abs(expected), axis=1, keepdims=True)
        assert np.max(np.abs(found - expected) / scale) < 1e-11
