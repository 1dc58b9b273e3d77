"""The tables of pages that no example computes: every cell is what the package gives."""

import re
from pathlib import Path

import numpy as np
import pytest

import tvclin as tv
from tests.turns import usual
from tvclin.ascent.nominal_flight import load_flight_condition

pytest.importorskip("jsbsim", reason="the extra sixdof is not installed")
DOCS = Path(__file__).parents[2] / "docs"
DEGREE, TOLERANCE = np.radians(1.0), 5e-5
LAWS = ("recoverable-attitude", "half-relief", "dead-band", "trim", "autopilot")
FLIGHT = tv.load_vehicle("configuration-i"), tv.load_vehicle("configuration-ii")


def row(page: str, label: str, count: int) -> list[float]:
    """Return the numbers of the only row of a page that has this label and so many cells."""
    cells = [line.strip("| ").split(" | ") for line in (DOCS / page).read_text().splitlines()]
    (computed,) = [one[1:] for one in cells if one[0] == label and len(one) == count + 1]
    return [float(number) for cell in computed for number in re.split(", ", cell)]


def shown(numbers: list[float], computed: list[float], digits: int, error: float) -> None:
    """Every number is the computed one as it is rounded, but for the error of a bisection."""
    assert numbers == pytest.approx(computed, abs=0.5 * 10.0**-digits + error)


def triangle(vehicle: tv.Vehicle, degrees: float = 1.0) -> tv.TriangularWind:
    beta = tv.Coefficients.from_vehicle(vehicle).beta
    return tv.TriangularWind(peak=degrees * DEGREE, duration=4.0 / beta)


@pytest.mark.thorough
@pytest.mark.parametrize("law", LAWS)
def test_the_laws_flown(law: str) -> None:
    vehicle = FLIGHT[0]
    plant, computed = tv.Plant.from_vehicle(vehicle, "drift-exact"), []
    control = tv.design.standard_laws(plant, DEGREE)[law]
    rectangle = tv.RectangularWind(peak=DEGREE, duration=triangle(vehicle).duration)
    for wind in (triangle(vehicle), rectangle):
        computed.append(tv.closed_loop_boundary(plant, control, wind, sample_rate=100).limit)
        for engine in ("planar", "sixdof"):
            options = {"law": control, "engine": engine, "tolerance": TOLERANCE, "highest": 2.5}
            computed.append(tv.flown_boundary(vehicle, wind, **options).limit)

    shown(row("six-degrees.md", law, 6), computed, 3, TOLERANCE)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("label", "number", "options"),
    usual(
        [
            ("flown without drift", 0, {"drift": False}),
            ("flown without drift", 1, {"drift": False}),
            ("flown with drift, I, pitch", 0, {}),
            ("flown with drift, I, yaw", 0, {"plane": "yaw"}),
            ("flown with drift, II, pitch", 1, {}),
            ("flown with drift, II, yaw", 1, {"plane": "yaw"}),
        ],
        *(0, 3),
    ),
)
def test_the_boundary_flown(label: str, number: int, options: dict[str, object]) -> None:
    vehicle, error = FLIGHT[number], 1e-5
    computed = [
        tv.flown_boundary(
            vehicle, triangle(vehicle), K, engine="sixdof", tolerance=error, **options
        ).limit
        for K in (1.0, 0.5, 0.0)
    ]
    shown(row("six-degrees.md", label, 3), computed, 4, error)


@pytest.mark.parametrize(("label", "number"), [("`drift-exact`, I", 0), ("`drift-exact`, II", 1)])
def test_the_boundary_beside_it(label: str, number: int) -> None:
    vehicle = FLIGHT[number]
    limits = [
        tv.boundary_limit(plant, triangle(vehicle), (1.0, 0.5, 0.0), "literal").limit
        for plant in (
            tv.Plant.from_vehicle(vehicle, "drift-exact"),
            tv.Plant.from_vehicle(vehicle, "fixed-path"),
        )
    ]
    shown(row("six-degrees.md", label, 3), limits[0].tolist(), 4, 0.0)
    shown(row("six-degrees.md", "eq (12), both configurations", 3), limits[1].tolist(), 4, 0.0)


@pytest.mark.parametrize(
    ("label", "degrees", "plane"),
    usual(
        [
            ("tail wind of 1 degree", 1.0, "pitch"),
            ("tail wind of 5 degrees", 5.0, "pitch"),
            ("head wind of 5 degrees", -5.0, "pitch"),
            ("across, 1 degree", 1.0, "yaw"),
        ]
    ),
)
def test_along_the_trajectory(label: str, degrees: float, plane: str) -> None:
    """What the report's control needs, in JSBSim and planar, and laws in JSBSim."""
    vehicle, bands = FLIGHT[0], (1.0, 0.5, 0.0)
    peak = triangle(vehicle, degrees)
    wind = peak.shift(vehicle.time - peak.duration / 2.0)
    options = {"plane": plane, "frozen": False}
    options["condition"] = load_flight_condition("configuration-i")
    laws = tv.design.standard_laws(tv.Plant.from_vehicle(vehicle, "drift-exact", plane), peak.peak)

    computed = [
        tv.flown_boundary(vehicle, wind, K, engine=engine, tolerance=1e-5, **options).limit
        for engine in ("planar", "sixdof")
        for K in bands
    ]
    shown(row("six-degrees.md", label, 2), computed, 4, 1e-5)
    options |= {"engine": "sixdof", "tolerance": 1e-4}
    computed = [
        tv.flown_boundary(vehicle, wind, law=laws[law], **options).limit for law in LAWS[:4]
    ]
    shown(row("six-degrees.md", label, 4), computed, 3, 1e-4)
