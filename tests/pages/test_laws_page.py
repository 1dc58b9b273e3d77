"""What the page of laws says was measured: each number is what its setting gives, as rounded."""

import re
from pathlib import Path

import numpy as np
import pytest

import tvclin as tv
from tests.turns import usual

PAGE = " ".join((Path(__file__).parents[2] / "docs" / "laws.md").read_text().split())
PLANT = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "fixed-path")
PEAK, COEFFICIENTS = np.radians(5.0), PLANT.coefficients


def triangle(tau_beta: float) -> tv.TriangularWind:
    return tv.TriangularWind(peak=PEAK, duration=tau_beta / COEFFICIENTS.beta)


def needs(law: tv.control.Law, wind: tv.TriangularWind, rate: float, **options) -> float:
    return tv.closed_loop_boundary(PLANT, law, wind, sample_rate=rate, **options).limit


def lean(believed_B: float = 1.0, believed_peak: float = 1.0, **options) -> tv.control.Law:
    own = tv.Coefficients.from_beta(beta=COEFFICIENTS.beta, B=believed_B * COEFFICIENTS.B)
    options = {"design_peak": believed_peak * PEAK, **options}
    return tv.RecoverableAttitudeLaw(tv.Plant.from_coefficients(own), **options)


def shown(number: str, value: float) -> None:
    """A number as the page writes it, .79, is the value as it is rounded."""
    digits = len(number.partition(".")[2])
    assert float(number) == pytest.approx(value, abs=0.5 * 10.0**-digits + 2e-5)


REVERSAL = tv.design.standard_winds(PEAK, triangle(4.0).duration)["full reversal"]
OBSERVER = tv.control.WindEstimator(bandwidth=1.0, seed=1)
MEASURED = {
    r"without one the limit is (\S+) \(": lambda: needs(lean(design_peak=None), REVERSAL, 50.0),
    r"too low needs (\S+) there, and": lambda: needs(
        lean(0.8, trust=1.0), triangle(8.0), 25.0, cuts=6
    ),
    r"it is used up \((\S+)\)": lambda: needs(lean(0.7), triangle(20.0), 25.0, cuts=6),
    r"At 1 rad/s it is (\S+), ": lambda: needs(
        lean(reach=0.7, estimator=OBSERVER), triangle(4.0), 25.0
    ),
    r"canonical gains need (\S+) at": lambda: needs(
        tv.SaturatedLaw(tv.control.canonical_gains(COEFFICIENTS)), triangle(4.0), 100.0
    ),
    r"it needs (\S+) for the promised": lambda: needs(
        tv.control.DeadBandLaw(PLANT), triangle(20.0), 50.0
    ),
    r"40 percent need (\S+) at 8": lambda: needs(lean(1.0, 0.6), triangle(8.0), 25.0),
}


@pytest.mark.thorough
@pytest.mark.parametrize("words", usual(MEASURED, 0, 3, 4, 5, 6))
def test_a_measured_number_is_what_its_setting_gives(words: str) -> None:
    (number,) = re.findall(words, PAGE)
    shown(number, MEASURED[words]())


def test_a_design_peak_30_percent_too_low_changes_nothing() -> None:
    for tau_beta in (8.0, 20.0):
        low, right = (needs(lean(1.0, part), triangle(tau_beta), 25.0) for part in (0.7, 1.0))
        assert low == pytest.approx(right, abs=1e-4)
