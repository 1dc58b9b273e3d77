"""Bounds of margins against interpolation (Nevanlinna and Pick), and the rule against a scan."""

from math import factorial

import numpy as np
import pytest

import tvclin as tv
from tests.flexible import BOOSTER, STRUCTURE
from tests.turns import usual
from tvclin.control.margins.margins import loop_margins


def least_norm(points, values):
    """The least of |F| over the right half plane of a function with these values at points."""

    def possible(bound):
        matrix = bound**2 - np.outer(values, np.conj(values))
        matrix = matrix / (points[:, np.newaxis] + np.conj(points))
        return np.linalg.eigvalsh(matrix).min() > -1e-13

    low, high = np.abs(values).max(), 1e3
    for _ in range(60):
        middle = np.sqrt(low * high)
        low, high = (low, middle) if possible(middle) else (middle, high)
    return high


@pytest.mark.parametrize("growth", [0.1, 0.3, 0.8])
def test_the_least_peaks_are_those_of_interpolation(growth):
    """A delay as the all-pass of Pade of order 3: T is zero at its zeros and one at the pole."""
    bounds = tv.control.margin_bounds(
        tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=growth**2, mu_delta=1.0)), delay=1.0
    )
    order = 3
    below = [
        factorial(2 * order - k) / factorial(k) / factorial(order - k) for k in range(order, -1, -1)
    ]
    zeros = -np.roots(below)
    points = np.append(zeros, growth)
    most = bounds.peak_sensitivity
    assert most == pytest.approx(np.exp(growth))
    at_zeros = np.ones(order)
    for name, values, expected in (
        ("T", np.append(0.0 * at_zeros, 1.0), most),
        ("S", np.append(at_zeros, 0.0), most),
        ("S - T", np.append(at_zeros, -1.0), most + np.sqrt(most**2 - 1.0)),
    ):
        assert least_norm(points, values.astype(complex)) == pytest.approx(expected, rel=1e-4), name
    assert bounds.disk_margin == pytest.approx(2.0 / (most + np.sqrt(most**2 - 1.0)))


def test_no_gains_have_more_than_the_bounds():
    """Of a scan of gains with a delay alone, the best margins stay below."""
    plant = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=1.0, mu_delta=1.0))
    delay = 0.2
    a0, a1 = np.meshgrid(np.geomspace(1.05, 20.0, 40), np.geomspace(0.2, 20.0, 40))
    gains = tv.Autopilot(attitude_gain=a0, rate_gain=a1, delay=delay)
    margins = loop_margins(gains.exact_loop(plant))
    some = margins.stable
    bounds = tv.control.margin_bounds(plant, delay=delay)
    assert np.sum(some) > 100
    assert margins.disk_margin[some].max() < bounds.disk_margin
    assert margins.phase_margin[some].max() < bounds.phase_margin
    assert (margins.aero_margin * margins.gain_increase)[some].max() < bounds.gain_range
    assert margins.peak_sensitivity[some].min() > bounds.peak_sensitivity
    assert margins.peak_complementary_sensitivity[some].min() > bounds.peak_sensitivity


@pytest.mark.parametrize(
    ("mu_alpha", "frequency", "damping", "delay"),
    usual([(0.28, 25.13, 0.7, 0.02), (3.3818, 70.0, 0.7, 0.02), (3.3818, 20.0, 0.7, 0.05)], 1),
)
def test_the_rule_for_attitude_and_rate_gains_is_good_to_3_percent(
    mu_alpha, frequency, damping, delay
):
    plant = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=mu_alpha, mu_delta=2.6))
    nozzle = tv.Actuator(natural_frequency=frequency, damping=damping)
    rule = tv.control.margin_bounds(plant, actuator=nozzle, delay=delay)
    a0, a1 = np.meshgrid(
        rule.rule_attitude_gain * np.geomspace(0.6, 1.6, 25),
        rule.rule_rate_gain * np.geomspace(0.6, 1.6, 25),
    )
    gains = tv.Autopilot(attitude_gain=a0, rate_gain=a1, actuator=nozzle, delay=delay)
    best = np.nanmax(loop_margins(gains.exact_loop(plant)).disk_margin)
    assert rule.lag <= 0.23
    assert rule.rule_disk_margin == pytest.approx(best, rel=0.03)


def test_without_delay_nothing_is_bounded_and_without_growth_nothing_is_said():
    plant = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=1.0, mu_delta=1.0))
    bounds = tv.control.margin_bounds(plant)
    assert (bounds.disk_margin, bounds.rule_disk_margin, bounds.gain_range) == (2.0, 2.0, np.inf)
    assert bounds.sentence == ""
    stable = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=-1.0, mu_delta=1.0))
    with pytest.raises(tv.InputError, match="by unstable poles only"):
        tv.control.margin_bounds(stable)


def test_a_flexible_vehicle_is_bounded_by_its_own_pole() -> None:
    """Which is slower than that of the rigid one here, and leaves more."""
    plant = tv.FlexiblePlant.from_vehicle(BOOSTER, STRUCTURE, "drift-exact")
    own = np.linalg.eigvals(plant.matrices()[0]).real.max()
    bounds = tv.control.margin_bounds(plant, delay=0.1)
    assert bounds.pole == pytest.approx(own, rel=1e-9)
    M = np.exp(own * 0.1)
    assert bounds.disk_margin == pytest.approx(2.0 / (M + np.sqrt(M**2 - 1.0)), rel=1e-9)
    assert (
        bounds.disk_margin > tv.control.margin_bounds(plant.rigid, delay=0.1).disk_margin * 1.0005
    )
