"""Values of a smooth function at many times from those at few."""

import numpy as np

from tvclin.numerics.chebyshev import Surface, smooth_values

TIMES = np.linspace(0.0, 20.0, 1001)


class Counted:
    """A function of time that counts at how many times it was evaluated."""

    def __init__(self, function) -> None:
        self.function, self.evaluated = function, 0

    def __call__(self, times, index):
        self.evaluated += times.size
        return self.function(times)


def test_smooth_values_are_those_of_the_function_from_few_evaluations() -> None:
    """To 1e-13 of the largest of each array, where half of the degree agrees to 1e-7."""

    def function(t):
        slow, rising = np.sin(0.3 * t), 1e-6 / (30.0 + t)
        return {"slow": np.stack([slow, slow**2], axis=1), "small": rising}

    counted = Counted(function)
    made = smooth_values(counted, TIMES, (TIMES >= 10.0).astype(int))
    assert counted.evaluated < 0.15 * TIMES.size
    for name, exact in function(TIMES).items():
        np.testing.assert_allclose(made[name], exact, rtol=0.0, atol=1e-13 * exact.max())


def test_a_constant_is_exact_and_what_is_missing_stays_missing() -> None:
    def function(t):
        return {"constant": np.full((t.size, 2), 0.1), "missing": np.full(t.size, np.nan)}

    made = smooth_values(Counted(function), TIMES, np.zeros(TIMES.size, int))
    assert np.all(made["constant"] == 0.1)
    assert np.isnan(made["missing"]).all()


def test_a_function_that_is_not_smooth_is_evaluated_itself() -> None:
    def function(t):
        return {"kink": np.abs(t - 7.003), "late": np.where(t < 12.0, np.nan, t)}

    made = smooth_values(Counted(function), TIMES, np.zeros(TIMES.size, int))
    for name, exact in function(TIMES).items():
        np.testing.assert_array_equal(made[name], exact)
    counted = Counted(function)
    few = smooth_values(counted, TIMES[:9], np.array([-1, -1, 0, 0, 0, 0, 1, 1, 1]))
    assert counted.evaluated == 9
    np.testing.assert_array_equal(few["kink"], function(TIMES[:9])["kink"])


def test_a_surface_is_its_function_linear_in_z() -> None:
    """To 1e-13 of the largest; half of the degrees agrees to 1e-7."""

    def function(x, y, z):
        bent = np.sin(0.2 * x) * np.exp(0.01 * y) + z * x
        return {"pair": np.stack([bent, np.cos(0.1 * x + 0.01 * y)], axis=1)}

    surface = Surface.of(function, (0.0, 2.0), (-0.5, 1.0), 1e-3)
    x, y, z = (np.linspace(*ends, 7) for ends in ((0.0, 2.0), (1.0, -0.5), (-1e-3, 1e-3)))
    out, exact = np.empty((7, 1)), function(x, y, z)["pair"]
    for part in range(2):
        surface.write("pair", slice(part, part + 1), surface.factors(x, y, z), out)
        np.testing.assert_allclose(out[:, 0], exact[:, part], rtol=0.0, atol=1e-13)
    assert Surface.of(lambda x, y, z: {"kink": np.abs(y)}, (0.0, 2.0), (-0.5, 1.0), 1e-3) is None
