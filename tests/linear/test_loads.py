"""Angle of attack and bending under trim and under the controls of the report."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import tvclin as tv


def plant() -> tv.Plant:
    return tv.Plant(tv.Coefficients.from_beta(beta=0.5, B=0.1), "fixed-path")


def test_ideal_trim_keeps_the_attitude_and_meets_the_whole_wind() -> None:
    wind = tv.TriangularWind(peak=-0.08, duration=6.0)
    loads = tv.linear.wind_loads(plant(), tv.trim_deflection(plant(), wind), wind)

    assert loads.relative == pytest.approx(1.0, rel=1e-12)
    assert loads.peak_angle_of_attack == pytest.approx(0.08, rel=1e-12)
    assert loads.peak_time == pytest.approx(3.0, rel=1e-12)
    assert abs(loads.peak_attitude) < 1e-16


@pytest.mark.parametrize("K", [1.0, 0.5, 0.0])
def test_the_peak_is_that_of_the_exact_response(K: float) -> None:
    wind = tv.TriangularWind(peak=0.1, duration=8.0)
    constant = tv.trim_then_hold(plant(), wind, tv.boundary_limit(plant(), wind, K).deflection, K)

    def angle(t: float) -> float:
        return -abs(tv.attitude_responses(plant(), constant, wind, [t])["angle_of_attack"][0])

    times = np.linspace(0.0, 7.99, 800)
    grid = tv.attitude_responses(plant(), constant, wind, times)["angle_of_attack"]
    near = times[np.argmax(np.abs(grid))]
    best = minimize_scalar(angle, bounds=(near - 0.02, near + 0.02), options={"xatol": 1e-9})
    loads = tv.linear.wind_loads(plant(), constant, wind)

    assert abs(loads.peak_angle_of_attack) == pytest.approx(-best.fun, rel=1e-7)


def test_the_angle_of_attack_falls_with_the_dead_band() -> None:
    wind = tv.TriangularWind(peak=0.1, duration=8.0)
    falls = []
    for K in (1.0, 0.5, 0.0):
        limit = tv.boundary_limit(plant(), wind, K).deflection
        falls.append(
            tv.linear.wind_loads(plant(), tv.trim_then_hold(plant(), wind, limit, K), wind)
        )

    expected = [1.021, 0.933, 0.781]
    assert [loads.relative for loads in falls] == pytest.approx(expected, abs=5e-4)


def test_batches_and_endless_winds_are_refused() -> None:
    wind = tv.TriangularWind(peak=[0.1, 0.2], duration=8.0)
    with pytest.raises(tv.InputError, match="one case"):
        tv.linear.wind_loads(plant(), tv.linear.ConstantDeflection(limit=-0.01), wind)
    with pytest.raises(tv.InputError, match="wind must end"):
        tv.linear.wind_loads(
            plant(),
            tv.linear.ConstantDeflection(limit=-0.01),
            tv.linear.ConstantDeflection(limit=0.1),
        )
