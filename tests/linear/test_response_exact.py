"""Random plants, winds and deflections against the same motion carried with sixty digits."""

import mpmath as mp
import numpy as np
import pytest

import tvclin as tv
from tests.sixty_digits import carried
from tests.turns import usual

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


def random_inputs(rng: np.random.Generator) -> tuple[tv.winds.History, tv.winds.History]:
    """A wind of straight pieces with a jump, and a deflection that switches; knots anywhere."""
    time = np.sort(rng.uniform(0.0, 9.0, 5))
    time[2] = time[1]
    wind = tv.SampledWind(time=time, angle=rng.uniform(-0.1, 0.1, 5))
    switches = np.sort(rng.uniform(0.5, 9.0, 2))
    return wind, tv.linear.BangBang(
        limit=rng.uniform(0.001, 0.02), switch_times=switches, start=0.2
    )


@pytest.mark.thorough
@pytest.mark.parametrize("model", usual(MODELS, 2))
def test_random_responses_keep_eleven_digits(model: str) -> None:
    rng = np.random.default_rng(MODELS.index(model))
    for _ in range(CASES):
        plant, (wind, deflection) = random_plant(rng, model), random_inputs(rng)
        times = np.sort(rng.uniform(0.0, 16.0, TIMES))
        with mp.workdps(60):
            expected = carried([deflection, wind], times, plant.matrices())
        computed = tv.attitude_responses(plant, deflection, wind, times).outputs

        scale = np.max(np.abs(expected), axis=1, keepdims=True)
        assert np.max(np.abs(computed - expected) / scale) < 1e-11
