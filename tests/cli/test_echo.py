"""What `tvclin study` repeats of a vehicle file, and doubts in it."""

from pathlib import Path

from typer.testing import CliRunner

from tvclin.cli.app import app
from tvclin.vehicle.file import template


def study(folder: Path, *changes: tuple[str, str]) -> str:
    text = template()
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    file = folder / "mine.toml"
    file.write_text(text)
    return CliRunner().invoke(app, ["study", str(file)]).output


def test_the_vehicle_is_repeated_in_the_units_of_its_file_beside_si(tmp_path: Path) -> None:
    said = study(
        tmp_path,
        ("weight_N = 1.5e7", "mass_kg = 1.53e6"),
        ("thrust_N = 2.5e7", "thrust_lbf = 5.62e6"),
        ("moment_of_inertia_kg_m2", "moment_of_inertia_slug_ft2"),
    )

    assert "1.53e+06 kg (1.5004e+07 N)" in said
    assert "5.62e+06 lbf (2.4999e+07 N)" in said
    assert "2.2e+08 slug ft2 (2.9828e+08 kg m²)" in said
    assert "7.9e+05 N " in said
    assert "(7.9e+05 N)" not in said  # nothing twice


def test_a_mass_typed_as_a_weight_is_doubted(tmp_path: Path) -> None:
    assert "is the weight a mass?" not in study(tmp_path)
    assert "is the weight a mass?" in study(tmp_path, ("weight_N = 1.5e7", "weight_N = 1.53e6"))
