"""What `tvclin study` repeats of a vehicle file, and doubts in it."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.turns import usual
from tvclin.cli.app import app
from tvclin.vehicle.vehicle_file import template


def study(folder: Path, *changes: tuple[str, str]) -> str:
    text = template()
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    file = folder / "mine.toml"
    file.write_text(text)
    return CliRunner().invoke(app, ["study", str(file), "--more"]).output


def test_the_vehicle_is_repeated_in_the_units_of_its_file_beside_si(tmp_path: Path) -> None:
    said = study(
        tmp_path,
        ("weight_N = 1.5e7", "mass_kg = 1.53e6"),
        ("thrust_N = 2.5e7", "thrust_lbf = 5.62e6"),
        ("moment_of_inertia_kg_m2", "moment_of_inertia_slug_ft2"),
    )

    assert "1.53·10⁶ kg (1.50042·10⁷ N)" in said
    assert "5.62·10⁶ lbf (2.4999·10⁷ N)" in said
    assert "2.2·10⁸ slug ft2 (2.9828·10⁸ kg m²)" in said
    assert "790000 N " in said
    assert "(790000 N)" not in said  # nothing twice


def test_a_mass_typed_as_a_weight_is_doubted(tmp_path: Path) -> None:
    assert "if the weight is a mass" not in study(tmp_path)
    assert "if the weight is a mass" in study(tmp_path, ("weight_N = 1.5e7", "weight_N = 1.53e6"))


def test_a_dynamic_pressure_in_another_unit_is_doubted_before_all_else(tmp_path: Path) -> None:
    """0.5 rho V^2 is 45.9 kPa at 540 m/s and 11.9 km, where rho is 0.315 kg/m^3."""
    coefficients = (
        "reference_area_m2 = 34.2\nnormal_force_coefficient_slope_per_rad = 4.3\n"
        "axial_force_coefficient = 0.51\n"
    )
    for pressure, doubted in (("dynamic_pressure_kPa", False), ("dynamic_pressure_Pa", True)):
        said = study(
            tmp_path,
            ("normal_force_slope_N_per_rad = 6.7e6 ", f"{pressure} = 45.5\n{coefficients}# "),
            ("axial_force_N = 7.9e5 ", "# "),
            ("# [flight]\n# altitude_m", "[flight]\naltitude_m"),
            ("# specific_impulse_s", "specific_impulse_s"),
        )
        assert ("in the standard atmosphere: a unit may be wrong" in said) == doubted
        assert "Required deflection" in said


DOUBTED = {
    "thrust is far above weight (T/W 15)": ("weight_N = 1.5e7", "weight_N = 1.6667e6"),
    "thrust is far below weight (T/W 0.4)": ("thrust_N = 2.5e7", "thrust_N = 6.0e6"),
    "the axial force F_A is 7.9e+07 N, larger than the thrust": (
        "axial_force_N = 7.9e5",
        "axial_force_N = 7.9e7",
    ),
    "the radius of gyration is 37.93 m, longer than control and aerodynamic arm": (
        "moment_of_inertia_kg_m2 = 2.2e8",
        "moment_of_inertia_kg_m2 = 2.2e9",
    ),
    "the aerodynamic arm l_a is negative (-2 m)": (
        "aerodynamic_arm_m = 9.5",
        "aerodynamic_arm_m = -2.0",
    ),
}


@pytest.mark.thorough
@pytest.mark.parametrize("doubt", usual(DOUBTED, 0))
def test_every_command_doubts_the_numbers_of_a_vehicle(tmp_path: Path, doubt: str) -> None:
    """A booster flies with T/W of 1.05 to 5; a mass in kg, as a weight in N, makes that 10.3."""
    for changed in (True, False):
        text = template()
        if changed:
            assert DOUBTED[doubt][0] in text
            text = text.replace(*DOUBTED[doubt])
        file = tmp_path / "my.toml"
        file.write_text(text, encoding="utf-8")
        for command in (
            ["study"],
            ["poles"],
            ["boundary"],
            ["margins", "--natural-frequency", "1"],
        ):
            said = " ".join(CliRunner().invoke(app, [*command, str(file)]).output.split())
            assert said.count(doubt) == changed, command
            assert ("Note: thrust is" in said) is (changed and doubt.startswith("thrust"))


@pytest.mark.thorough
def test_each_row_says_which_peak_the_limit_survives() -> None:
    calls = ["study", "--limit-deg", "0.3", "--model", "drift", "--sign", "frozen"]
    rows = {
        line.split()[2]: line.split()
        for line in CliRunner().invoke(app, calls).output.splitlines()
        if line.startswith("  K = ")
    }
    for K in ("0.75", "0.5", "0.25", "0"):
        result = tv.Study.from_vehicle(
            tv.load_vehicle("configuration-i"),
            duration=7.5,
            peak=np.radians(float(rows[K][-1])),
            limit=np.radians(0.3),
            model="drift",
            dead_band=float(K),
        )
        deflection = np.degrees(abs(result.boundaries["drift"].deflection))
        assert deflection[result.dead_bands == float(K)] == pytest.approx(0.3, rel=3e-4)
    verdict = CliRunner().invoke(app, calls).output.split("survivable peak ")[1].split()[0]
    assert rows["1"][-1] == verdict


def test_the_symbols_are_explained() -> None:
    said = CliRunner().invoke(app, ["study", "--explain"]).output

    for symbol in ("y_BR", "K1", "C1", "C2"):
        assert symbol in said.split("What the symbols mean")[1]
