"""What the page of laws says was measured: each number is what its setting gives, as rounded."""

import re
from pathlib import Path

import numpy as np
import pytest

import tvclin as tv
from tests.turns import usual

PAGE = " ".join((Path(__file__).parents[2] / "docs" / "laws.md").read_text().split())
PLANT, EXACT = (
    tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), model)
    for model in ("fixed-path", "drift-exact")
)
PEAK, COEFFICIENTS = np.radians(5.0), PLANT.coefficients
SERVO = tv.Actuator(natural_frequency=20.0, damping=0.7)
SECONDS = tv.TriangularWind(peak=PEAK, duration=7.5)


def triangle(tau_beta: float) -> tv.TriangularWind:
    return tv.TriangularWind(peak=PEAK, duration=tau_beta / COEFFICIENTS.beta)


def needs(
    law: tv.control.Law, wind: tv.TriangularWind, rate: float, plant=PLANT, **options
) -> float:
    return tv.closed_loop_boundary(plant, law, wind, sample_rate=rate, **options).limit


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
    r"without one the limit is (\S+), and": lambda: needs(lean(design_peak=None), REVERSAL, 50.0),
    r"`trust` one, (\S+) \(": lambda: needs(lean(trust=1.0), REVERSAL, 50.0),
    r"it is used up \((\S+)\)": lambda: needs(lean(0.7), triangle(20.0), 25.0, cuts=6),
    r"At 1 rad/s it is (\S+), ": lambda: needs(
        lean(reach=0.7, estimator=OBSERVER), triangle(4.0), 25.0
    ),
    r"short winds: (\S+) for": lambda: needs(lean(dead_band=0.05 * PEAK), triangle(4.0), 50.0),
    r"short winds: \S+ for (\S+) with": lambda: needs(lean(), triangle(4.0), 50.0),
    r"reach of .9 needs (\S+) with": lambda: needs(
        lean(reach=0.9), triangle(4.0), 40.0, actuator=SERVO, cuts=1
    ),
    r"canonical gains need (\S+) at": lambda: needs(
        tv.SaturatedLaw(tv.control.canonical_gains(COEFFICIENTS)), triangle(4.0), 100.0
    ),
    r"literal \$K = 1\$, (\S+) flown": lambda: needs(tv.TrimLaw(PLANT), SECONDS, 100.0, EXACT),
    r"flown for (\S+) in 7.5 s": lambda: tv.boundary_limit(EXACT, SECONDS, 1.0, "literal").limit,
    r"and needs (\S+) \(measured on": lambda: needs(tv.TrimLaw(EXACT), SECONDS, 100.0, EXACT),
    r"it needs (\S+) with gain 1": lambda: needs(
        tv.control.DeadBandLaw(PLANT), triangle(8.0), 50.0
    ),
    r"gain 1, (\S+) with 10": lambda: needs(
        tv.control.DeadBandLaw(PLANT, gain=10.0), triangle(8.0), 50.0
    ),
    r"the open loop, (\S+)\. At": lambda: tv.boundary_limit(PLANT, triangle(8.0), 0.5).limit,
    r"it needs (\S+) for the promised": lambda: needs(
        tv.control.DeadBandLaw(PLANT), triangle(20.0), 50.0
    ),
    r"20, 10, 5 need (\S+), \S+, \S+ ": lambda: needs(lean(gain=20.0), triangle(4.0), 50.0),
    r"20, 10, 5 need \S+, (\S+), \S+ ": lambda: needs(lean(gain=10.0), triangle(4.0), 50.0),
    r"20, 10, 5 need \S+, \S+, (\S+) ": lambda: needs(lean(gain=5.0), triangle(4.0), 50.0),
    r"40 percent need (\S+) at 8": lambda: needs(lean(1.0, 0.6), triangle(8.0), 25.0),
    r"trim needs (\S+) and \S+\)": lambda: needs(tv.TrimLaw(PLANT), triangle(8.0), 25.0, cuts=6),
    r"trim needs \S+ and (\S+)\)": lambda: needs(tv.TrimLaw(PLANT), triangle(20.0), 25.0, cuts=6),
}


@pytest.mark.parametrize("words", MEASURED)
def test_a_measured_number_is_what_its_setting_gives(words: str) -> None:
    (number,) = re.findall(words, PAGE)
    shown(number, MEASURED[words]())


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("label", "believed"),
    usual(
        [
            ("all right", (1.0, 1.0)),
            ("$B$ 20 percent too low", (0.8, 1.0)),
            ("$B$ 10 percent too low", (0.9, 1.0)),
            ("design peak 20 percent too low", (1.0, 0.8)),
            ("$B$ and design peak 10 percent too low", (0.9, 0.9)),
        ],
        4,
    ),
)
def test_what_the_trust_gains_and_costs(label: str, believed: tuple[float, float]) -> None:
    (cells,) = re.findall(rf"\| {re.escape(label)} \| (.*?) \|(?: \||$| In)", PAGE)
    for i, number in enumerate(cells.split(" | ")):
        law = lean(*believed, trust=(1.0, 0.8)[i % 2])
        shown(number, needs(law, triangle((8.0, 20.0)[i // 2]), 25.0, cuts=6))


def test_a_design_peak_30_percent_too_low_changes_nothing() -> None:
    for tau_beta in (8.0, 20.0):
        low, right = (needs(lean(1.0, part), triangle(tau_beta), 25.0) for part in (0.7, 1.0))
        assert low == pytest.approx(right, abs=1e-4)
