"""`tvclin import`: what it writes and prints, and everything that would be silently wrong."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import tvclin as tv
from tests.schedules.samples import (
    FOLDER,
    HEADER,
    LINES,
    NAMES,
    OPENROCKET,
    changed,
    kept,
    number_of,
    read,
    written,
)
from tvclin.cli.app import app

GIMBAL, SLOPE, GROUND = ("--gimbal-station-m", "2.95"), ("--cn-alpha-per-rad", "2"), (
    "--ground-m", "0")  # fmt: skip
GIVEN = (*GIMBAL, *SLOPE, *GROUND)
INERTIA = ("--inertia", "0:24", "--inertia", "5:20")


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["import", *map(str, arguments)])


def refused(folder: Path, *arguments: object) -> str:
    """Assert exit code 2, one sentence, and nothing written; return the sentence."""
    output = folder / "out" / "my.csv"
    output.parent.mkdir(exist_ok=True)
    result = run(*arguments, "-o", output)
    assert result.exit_code == 2
    assert isinstance(result.exception, SystemExit), repr(result.exception)
    (said,) = result.stderr.splitlines()
    assert said.startswith("Error: ")
    assert len(said) < 500
    assert list(output.parent.iterdir()) == []
    return said


def damaged(lines: Sequence[str], at: str, change: dict[str, str]) -> list[str]:
    """Return the lines with a replacement in the one that begins so."""
    ((old, new),) = change.items()
    return [line.replace(old, new, 1) if line.startswith(at) else line for line in lines]


def test_a_schedule_is_written_with_a_comment_on_every_column(tmp_path: Path) -> None:
    output = tmp_path / "my.csv"
    result = run("openrocket", OPENROCKET, *GIVEN, "-o", output, "--more")
    assert result.exit_code == 0, result.output
    computed, expected = tv.load_schedule(output), read(OPENROCKET)
    np.testing.assert_allclose(computed.vehicle.weight, expected.vehicle.weight, rtol=1e-11)
    text = output.read_text(encoding="utf-8")
    for note in expected.notes:
        assert f"# {note}\n" in text
        assert note in result.output


def test_mu_alpha_and_b_are_printed_at_three_times(tmp_path: Path) -> None:
    """Those at 5 s are worked out by hand: N l_a/I and N l_a/(T l_c)."""
    result = run("openrocket", OPENROCKET, *GIVEN, "-o", tmp_path / "my.csv", "--from", "1")
    rows = [line.split() for line in result.output.splitlines() if re.match(r" *[135] +\d", line)]
    assert rows == [
        ["1", "2.7816", "119.7931", "0.02322"],
        ["3", "27.1816", "134.8889", "0.20151"],
        ["5", "74.8983", "152.4000", "0.49146"],
    ]


def test_a_stable_rocket_is_said(tmp_path: Path) -> None:
    file = written(tmp_path, changed("CP location", lambda x, _: x + 150.0))
    result = run("openrocket", file, *GIVEN, "-o", tmp_path / "my.csv")
    assert result.exit_code == 0
    assert "stable throughout" in result.output


def test_rasaero_and_a_map_are_read(tmp_path: Path) -> None:
    rasaero = ("--cn-alpha", FOLDER / "rasaero-aerodynamics.csv", *GIMBAL, *GROUND, *INERTIA)
    result = run("rasaero", FOLDER / "rasaero-flight.csv", *rasaero, "-o", tmp_path / "a.csv")
    assert result.exit_code == 0, result.output
    columns = tmp_path / "map.toml"
    columns.write_text(MAP)
    result = run("table", FOLDER / "table.csv", "--columns", columns, "-o", tmp_path / "b.csv")
    assert result.exit_code == 0, result.output
    for name in ("a.csv", "b.csv"):
        vehicle = tv.load_schedule(tmp_path / name).at(3.0)
        assert tv.Coefficients.from_vehicle(vehicle).B == pytest.approx(0.20151, rel=3e-5)


MAP = """[columns]
time = "t (s)"
mass = "m (kg)"
moment_of_inertia = "Iyy (kg m2)"
gravity_station = "xcg (m)"
pressure_station_m = 0.96
gimbal_station_m = 2.95
thrust = "T (kN)"
normal_force_slope_N_per_rad = "N"
axial_force_N = 190
velocity = "V (m/s)"
attitude_deg = 84
"""

ROW = number_of("3,")
"""The line of the row that is damaged."""


def without(*names: str) -> list[str]:
    """Return the lines with columns under names that nobody looks for."""
    lines = list(LINES)
    for name in names:
        lines[HEADER] = lines[HEADER].replace(f"{name} (", "Nothing (")
    return lines


def twice(name: str, column: int) -> list[str]:
    """Return the lines with a column more."""
    return [
        f"{line},{name}" if i == HEADER else line if line.startswith("#")
        else f"{line},{line.split(',')[column]}"
        for i, line in enumerate(LINES)
    ]  # fmt: skip


DAMAGED: dict[str, tuple[list[str], str]] = {
    "header off": (
        [line for i, line in enumerate(LINES) if i != HEADER],
        "no line of column names with their units, .* with field descriptions included",
    ),
    "a column missing": (without("CG location"), "has no column CG location; tick it"),
    "no air": (without("Air pressure"), "neither a column Air density nor Air pressure"),
    "a column twice": (twice("Mass (g)", 5), "the column Mass is there 2 times; keep one"),
    "unit unknown": (
        [line.replace("CG location (cm)", "CG location (furlong)") for line in LINES],
        r"unit of the column 'CG location \(furlong\)' is not known; export it in m, ft, in, mm",
    ),
    "unit lost": (
        [line.replace("Mass (g)", "Mass (?)") for line in LINES],
        r"unit of the column 'Mass \(\?\)' is not known",
    ),
    "no parentheses": (
        [line.replace("Thrust (N)", "Thrust") for line in LINES],
        "unit of the column 'Thrust' is not known; export it in N, kN, MN, lbf, kgf",
    ),
    "decimal commas beside points": (
        damaged([line.replace(",", ";") for line in LINES], "3;", {"196.503": "196,503"}),
        f"line {ROW}: numbers have decimal commas, others points; export the file with points",
    ),
    "decimal commas and commas between": (
        [line if line.startswith("#") else line.replace(".", ",") for line in LINES],
        f"line {number_of('0,0,')}: there are 17 names and 20 cells .* decimal commas",
    ),
    "a number lost": (
        damaged(LINES, "3,", {",2400,": ",NaN,"}),
        rf"line {ROW}: there is no number in column Thrust \(N\), while the motor burns",
    ),
    "a word for a number": (
        damaged(LINES, "3,", {"27400": "heavy"}),
        f"line {ROW}: Mass must be a number, or empty; got 'heavy'",
    ),
    "a row cut off": (
        [line[:40] if line.startswith("3,") else line for line in LINES],
        f"line {ROW}: there are 17 names and 7 cells",
    ),
    "time falls": (
        damaged(LINES, "3,", {"3,": "2.6,"}),
        f"line {ROW}: the time must rise; got 2.6 s after 2.75 s",
    ),
    "g for kg": (
        [line.replace("Mass (g)", "Mass (kg)") for line in LINES],
        r"thrust over weight must be between 0\.2 and 500 .* got 0\.00979",
    ),
    "kg for g": (changed("Mass", lambda x, _: x / 1000), "thrust over weight .* got 9.79e"),
    "kg cm^2 for kg m^2": (
        [line.replace("kg·m²", "kg·cm²") for line in LINES],
        "the radius of gyration, .* unit of the moment of inertia",
    ),
    "angle of attack": (
        changed("Angle of attack", lambda x, t: 7.0 if t == 3.0 else x),
        f"line {ROW}: the angle of attack is 7 deg at 3 s, beyond the 2 deg .* without wind",
    ),
    "attitude from the vertical": (
        changed("Vertical orientation", lambda x, _: 90.0 - x),
        "the attitude is 6 deg and the path 84 deg above the horizon",
    ),
    "two stages": (
        changed("Mass", lambda x, t: x + 3000.0 * (t < 2.9)),
        rf"line {ROW}: the mass falls from 30\.7 to 27\.4 kg, .* a stage leaves",
    ),
    "no thrust": (changed("Thrust", lambda *_: 0.0), "has no thrust"),
    "no centre of pressure": (changed("CP", lambda *_: np.nan), "centre of pressure .* missing"),
    "one row": (
        [line for line in LINES if line.startswith(("#", "3,"))],
        "must hold two or more rows of powered flight; got 1",
    ),
    "no row": ([line for line in LINES if line.startswith("#")], "has no row below its line"),
}  # fmt: skip


@pytest.mark.parametrize("what", DAMAGED)
def test_damage_is_refused_in_one_sentence(tmp_path: Path, what: str) -> None:
    lines, expected = DAMAGED[what]
    said = refused(tmp_path, "openrocket", written(tmp_path, lines), *GIVEN)
    assert re.search(expected, said), said


AERODYNAMICS = FOLDER / "rasaero-aerodynamics.csv"
ASKED: dict[str, tuple[tuple[object, ...], str]] = {
    "no ground": ((*GIMBAL, *SLOPE), "give --ground-m, the elevation of the launch site"),
    "no slope": (
        (*GIMBAL, *GROUND),
        r"no column Normal force coefficient derivative; Normal force coefficient \(\) is the"
        " coefficient of the flight, not its slope",
    ),
    "slope twice": ((*GIVEN, "--cn-alpha", AERODYNAMICS), "or --cn-alpha, not both"),
    "per degree": (
        (*GIMBAL, *GROUND, "--cn-alpha-per-rad", "0.035"),
        r"must be per radian, .* got at most 0\.035 \(a coefficient, or per degree",
    ),
    "from degrees twice": (
        (*GIMBAL, *GROUND, "--cn-alpha-per-rad", "114.6"),
        r"at most 100 with large fins; got 114\.6",
    ),
    "gimbal ahead": (
        (*SLOPE, *GROUND, "--gimbal-station-m", "1.7"),
        r"must lie behind the centre of gravity, 1\.806 m from the nose tip at 0\.5 s; got 1\.7 m",
    ),
    "gimbal in cm": (
        (*SLOPE, *GROUND, "--gimbal-station-m", "295"),
        r"--gimbal-station-m must be in m .* got 295 m \(is it in cm",
    ),
    "the flight as its own table": (
        (*GIMBAL, *GROUND, "--cn-alpha", OPENROCKET),
        "has no line of names with Mach",
    ),
    **{
        f"ground at {site} m": (
            (*GIMBAL, *SLOPE, f"--ground-m={site}"),
            rf"--ground-m must be between -450 and 9000; got {site} m",
        )
        for site in ("-500", "20000")
    },
    "ground that is no number": ((*GIMBAL, *SLOPE, "--ground-m=nan"), "--ground-m must be finite"),
    "start beyond": ((*GIVEN, "--from", "9"), "no thrust between --from and --to"),
    "one row for all": ((*GIVEN, "--most-rows", "1"), "--most-rows must be 2 or more"),
}


@pytest.mark.parametrize("what", ASKED)
def test_what_is_asked_wrongly_is_refused_in_one_sentence(tmp_path: Path, what: str) -> None:
    arguments, expected = ASKED[what]
    said = refused(tmp_path, "openrocket", OPENROCKET, *arguments)
    assert re.search(expected, said), said


def test_a_coefficient_over_mach_is_not_taken_for_its_slope(tmp_path: Path) -> None:
    table = tmp_path / "table.csv"
    table.write_text("Mach,Alpha,CN\n0.0,2,0.07\n1.5,2,0.08\n")
    said = refused(tmp_path, "openrocket", OPENROCKET, *GIMBAL, *GROUND, "--cn-alpha", table)
    assert "CN is a coefficient, not its slope" in said


def test_slopes_of_components_that_do_not_add_up_are_refused(tmp_path: Path) -> None:
    table = tmp_path / "table.csv"
    table.write_text(
        "Mach number (),CN\u03b1 (Nose) (),CN\u03b1 (Tail) ()\n0,2.2,-0.2\n1.5,2.2,-0.2\n"
    )
    said = refused(tmp_path, "openrocket", OPENROCKET, *GIMBAL, *GROUND, "--cn-alpha", table)
    assert "holds 2 columns CN alpha" in said


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        (
            *("normal_force_slope_N_per_rad", "normal_force_slope"),
            "unit of the column 'N' is not known; write our name .*, normal_force_slope_N_per_r",
        ),
        ('"T (kN)"', '"F (kN)"', r"no column 'F \(kN\)', which columns has for thrust; it has"),
        ('thrust = "T', 'thrust_lbf = "T', r"T \(kN\) is not in the unit of thrust_lbf; write"),
        ("attitude_deg", "attitude", "attitude is a number without a unit; write attitude_rad"),
        ("axial_force_N = 190\n", "", "columns must have axial_force, or dynamic_pressure"),
        ("thrust", "trust", r"unknown key in \[columns\]: 'trust'; did you mean thrust"),
        ("attitude_deg", "path_angle_deg", "'path_angle_deg'; give attitude, as attitude_deg"),
        ("attitude_deg", "attitude_grad", "attitude_grad has no known unit .* write attitude_rad"),
        ('"t (s)"', '"Zeit (s)"', r"no line of column names with 'Zeit \(s\)' among them"),
        ("[columns]", "[column]", r"must hold one table \[columns\]"),
        ("mass", "weight_N = 300\nmass", "has both weight and mass; keep one"),
        ('"t (s)"', "3", "columns: time is a number without a unit"),
    ],
)
def test_a_map_that_does_not_fit_is_refused_in_one_sentence(
    tmp_path: Path, old: str, new: str, expected: str
) -> None:
    columns = tmp_path / "map.toml"
    columns.write_text(MAP.replace(old, new))
    said = refused(tmp_path, "table", FOLDER / "table.csv", "--columns", columns)
    assert re.search(expected, said), said


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ((*GIVEN, "--inertia", "0:24"), "must hold two or more rising times"),
        ((*GIVEN, "--inertia", "0:24", "--inertia", "5"), "such as 0:24; got '0:24 5'"),
        ((*GIMBAL, *GROUND, *INERTIA), "give --cn-alpha-per-rad, or --cn-alpha"),
        ((*GIMBAL, *SLOPE, *INERTIA), "give --ground-m"),
    ],
)
def test_what_rasaero_needs_is_asked_for(tmp_path: Path, arguments, expected) -> None:
    said = refused(tmp_path, "rasaero", FOLDER / "rasaero-flight.csv", *arguments)
    assert expected in said


def test_another_tools_file_is_refused(tmp_path: Path) -> None:
    """RASAero's flight is no export of OpenRocket, nor the other way round."""
    said = refused(tmp_path, "rasaero", OPENROCKET, *GIVEN, *INERTIA)
    assert "no line of column names such as Time (sec), Thrust (lb), CG (in)" in said
    said = refused(tmp_path, "openrocket", FOLDER / "rasaero-flight.csv", *GIVEN)
    assert "has no columns Total velocity, Mass, " in said


def test_the_source_is_never_written_over(tmp_path: Path) -> None:
    file = written(tmp_path, LINES)
    before = file.read_bytes()
    result = run("openrocket", file, *GIVEN, "-o", file)
    assert result.exit_code == 2
    assert "--output must not be a file that is read" in result.stderr
    assert file.read_bytes() == before
    result = run("openrocket", file, *GIVEN, "-o", tmp_path / "my.txt")
    assert "path must end in .csv" in result.stderr
    assert result.exit_code == 2


def test_the_unit_less_columns_of_the_sample_hold_a_space_without_width() -> None:
    assert "Mach number (\u200b)" in NAMES
    assert changed("Mach number", kept)[HEADER] == LINES[HEADER]
