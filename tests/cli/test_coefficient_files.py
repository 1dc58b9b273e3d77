"""A vehicle known by its coefficients alone: the same numbers, and what it lacks, in a sentence."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import tvclin as tv
from tests.turns import usual
from tvclin.cli.app import app

BOOSTER = tv.Coefficients.from_vehicle(tv.load_vehicle("configuration-i"))
SLOPES = f"mu_alpha_per_s2 = {BOOSTER.mu_alpha!r}\nmu_delta_per_s2 = {BOOSTER.mu_delta!r}\n"
PATH = "".join(
    f"{name}_per_{unit} = {getattr(BOOSTER, name)!r}\n"
    for name, unit in {"C1": "s", "C2": "s3", "b1": "s", "b2": "s", "q": "s2"}.items()
)


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, list(arguments))


@pytest.fixture
def slopes(tmp_path: Path) -> str:
    return _file(tmp_path, SLOPES)


@pytest.fixture
def all_of_it(tmp_path: Path) -> str:
    return _file(tmp_path, SLOPES + PATH)


def _file(folder: Path, text: str) -> str:
    file = folder / "known.toml"
    file.write_text(f"[coefficients]\n{text}")
    return str(file)


@pytest.mark.parametrize(
    "command",
    usual(
        [
            ["poles"],
            ["boundary"],
            ["respond", "--model", "drift", "--limit-deg", "0.4"],
            ["study", "--model", "drift-exact", "--limit-deg", "0.4", "--sign", "frozen"],
            ["margins"],
            ["design", "--natural-frequency", "1.5"],
            ["fly", "--natural-frequency", "1.5"],
        ],
        *(0, 1, 4, 5),
    ),
)
def test_the_coefficients_of_a_vehicle_give_its_numbers(command: list[str], all_of_it: str) -> None:
    whole, known = (
        json.loads(run(command[0], one, *command[1:], "--json").stdout)
        for one in ("configuration-i", all_of_it)
    )
    unknown = {"vehicle", "peak_normal_force_N", "peak_lateral_speed_m_s"}
    if command[0] != "study":  # of the wind's own dynamic pressure, where speed and attitude are
        unknown |= {"required_deflection_deg", "autopilot_requirement_deg"}

    assert without(unknown, known) == without(unknown, whole)


def without(keys: set[str], document: Any) -> Any:
    """Return a document without some keys, in objects inside it too."""
    if not isinstance(document, dict):
        return document
    return {key: without(keys, value) for key, value in document.items() if key not in keys}


@pytest.mark.parametrize("arguments", [("--plane", "yaw"), ("--peak-deg", "1")])
def test_the_study_of_coefficients_is_at_nominal_dynamic_pressure(arguments, slopes: str) -> None:
    """In yaw and in a weak wind too, where no note on a head wind says so."""
    assert "at nominal dynamic pressure), set by" in " ".join(
        run("study", slopes, *arguments).output.split()
    )


@pytest.mark.thorough
def test_moment_slopes_alone_hold_the_path_fixed(slopes: str) -> None:
    study = json.loads(run("study", slopes, "--json").stdout)
    boundary = tv.boundary_limit(
        tv.Plant(BOOSTER, "fixed-path"), tv.TriangularWind(peak=np.radians(5), duration=7.5)
    )

    assert list(study["boundaries"]) == ["fixed-path"]
    assert study["verdict"]["required_deflection_deg"] == pytest.approx(
        np.degrees(abs(boundary.deflection)), rel=1e-12
    )
    assert "the flight path is fixed" in study["notes"][0]
    for command in ("boundary", "margins", "design", "fly"):
        assert "fixed-path" in run(command, slopes).output
    refused = run("boundary", slopes, "--model", "drift")
    assert refused.exit_code == 2
    assert "needs C1, C2, b1, b2 and q" in refused.output


def test_beta_and_B_are_the_same_vehicle(tmp_path: Path, slopes: str) -> None:
    by_slopes = tv.vehicle.load_any_vehicle(slopes)
    by_beta = tv.vehicle.load_any_vehicle(
        _file(tmp_path, f"beta_per_s = {BOOSTER.beta!r}\nB = {BOOSTER.B!r}\n")
    )

    for name in ("mu_alpha", "mu_delta"):
        one, other = (getattr(of.coefficients, name) for of in (by_slopes, by_beta))
        assert one == pytest.approx(other, rel=1e-14)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["fly", "--law", "trim", "--engine", "planar"], "needs a whole vehicle"),
        (["ascent"], "needs a whole vehicle"),
        (["disperse"], "needs a whole vehicle"),
        (["study", "--peak-speed", "30"], "--peak-speed needs a whole vehicle"),
    ],
)
def test_what_needs_a_whole_vehicle_says_so(arguments: list[str], said: str, slopes: str) -> None:
    result = run(arguments[0], slopes, *arguments[1:])

    assert result.exit_code == 2
    assert said in result.output


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("mu_alpha_per_s2 = 0.3\nB = 0.1\n", "mu_alpha and mu_delta, or beta and B"),
        ("mu_alpha_per_s2 = 0.3\n", "mu_delta_per_s2"),
        (SLOPES + "C1_per_s = 0.04\n", "C2_per_s3"),
        (SLOPES + "C2_per_s = 0.04\n", "C2_per_s3"),
        (SLOPES + "[flight]\naltitude_m = 1\n", "flight"),
        ("", "mu_alpha_per_s2"),
    ],
)
def test_a_wrong_file_is_one_sentence(tmp_path: Path, text: str, said: str) -> None:
    result = run("poles", _file(tmp_path, text))

    assert result.exit_code == 2
    assert said in result.output
    first, *others = result.output.splitlines()
    assert first.startswith("Error: ")
    assert all(other.startswith(str(tmp_path)) for other in others)  # a line for each fault


def test_an_actuator_in_hertz_is_the_one_in_radians() -> None:
    both = (
        "nozzle.actuator_frequency_Hz=4",
        f"nozzle.actuator_frequency_rad_per_s={8.0 * np.pi!r}",
    )
    one, other = (
        json.loads(run("margins", "--json", "--set", key).stdout)["autopilot"]["actuator"]
        for key in both
    )

    assert one == other
    refused = run("margins", "--set", both[0], "--set", both[1])
    assert "exclude each other" in refused.output
