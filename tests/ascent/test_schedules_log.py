"""Logs of simulations, as text and as .mat, against the numbers that they were written of."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat
from typer.testing import CliRunner

import tvclin as tv
from tests.schedules.samples import FOLDER
from tvclin.cli.app import app

LOG = FOLDER / "log.csv"
LINES = LOG.read_text().splitlines()
NAMES = LINES[1].split(",")
ROWS = np.array([line.split(",") for line in LINES[2:]], dtype=float)
COLUMNS = dict(zip(NAMES, ROWS.T, strict=True))
FIELDS = ("weight", "moment_of_inertia", "thrust", "control_arm", "aerodynamic_arm", "velocity")


def written(folder: Path, **changes: object) -> Path:
    """The log with other columns; None leaves one out."""
    columns = {name: value for name, value in (COLUMNS | changes).items() if value is not None}
    rows = np.column_stack([np.broadcast_to(c, len(ROWS)) for c in columns.values()])
    file = folder / "own.csv"
    lines = [",".join(columns), *(",".join(map(repr, row)) for row in rows.tolist())]
    file.write_text("\n".join(lines))
    return file


def test_a_log_is_a_schedule_and_a_wind() -> None:
    result = tv.ascent.read_log(LOG)
    v = result.schedule.vehicle
    np.testing.assert_allclose(v.weight, COLUMNS["mass_kg"] * 9.80665)
    np.testing.assert_allclose(v.thrust, 2400.0)
    np.testing.assert_allclose(v.control_arm, 2.95 - COLUMNS["gravity_station_m"])
    np.testing.assert_allclose(result.schedule.height, COLUMNS["altitude (m)"])
    np.testing.assert_allclose(result.wind.time, COLUMNS["time_s"])
    np.testing.assert_allclose(np.degrees(result.wind.angle), COLUMNS["wind_angle_deg"])
    assert "left out: roll_deg" in result.schedule.notes


@pytest.mark.parametrize("whole", [False, True])
def test_a_mat_file_is_the_same(tmp_path, whole) -> None:
    """By themselves or in one structure; numbers that do not change may stand once."""
    held = {name.replace(" (m)", "_m"): values for name, values in COLUMNS.items()}
    held |= {"thrust_kN": 2.4, "attitude_deg": 84.0}
    file = tmp_path / "log.mat"
    savemat(file, {"log": held} if whole else held | {"name": "a text"})
    one, other = tv.ascent.read_log(file), tv.ascent.read_log(LOG)
    for name in FIELDS:
        np.testing.assert_array_equal(
            getattr(one.schedule.vehicle, name), getattr(other.schedule.vehicle, name)
        )
    np.testing.assert_array_equal(one.wind.angle, other.wind.angle)


def test_the_wind_is_that_of_its_speed_or_of_the_angle_of_attack(tmp_path) -> None:
    speed, V, path = np.array([0.0, 2, 5, 9, 5, 2, 0]), COLUMNS["velocity_m_per_s"], 84.0
    none = {"wind_angle_deg": None}
    result = tv.ascent.read_log(written(tmp_path, wind_speed_m_per_s=speed, **none))
    turned = np.arcsin(speed * np.sin(np.radians(path)) / V)  # eq (B1e)
    np.testing.assert_allclose(result.wind.angle, turned, rtol=1e-9, atol=1e-12)

    alpha = np.array([0.0, -1.0, -2.0, -3.0, -2.0, -1.0, 0.0])
    result = tv.ascent.read_log(written(tmp_path, angle_of_attack_deg=alpha, **none))
    np.testing.assert_allclose(np.degrees(result.wind.angle), -alpha)
    assert any("motion of the vehicle in it" in note for note in result.schedule.notes)
    drifts = {"angle_of_attack_deg": alpha, "flight_path_angle_deg": 84.5}
    result = tv.ascent.read_log(written(tmp_path, **drifts, **none))
    np.testing.assert_allclose(np.degrees(result.wind.angle), -0.5 - alpha)


def test_the_wind_over_height_meets_the_flight_at_the_same_angle(tmp_path) -> None:
    result = tv.ascent.read_log(LOG)
    result.write_wind(tmp_path / "wind.csv")
    profile = tv.read_sounding(tmp_path / "wind.csv")
    encountered = tv.fly_through(profile, result.schedule, azimuth=0.0)
    inside = np.interp(COLUMNS["time_s"], encountered.wind.time, encountered.wind.angle)
    np.testing.assert_allclose(inside, result.wind.angle, atol=1e-6)
    sized = tv.size(result.schedule, {"log": result.wind}, times=[5.0], placing="flight")
    assert np.isfinite(sized.required["K = 1"]).all()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"wind_angle_deg": None}, "has no wind"),
        ({"thrust_kN": None}, "columns must have thrust"),
        ({"time_s": None}, "with the time among them"),
    ],
)
def test_what_a_log_lacks_is_named(tmp_path, changes, words) -> None:
    with pytest.raises(tv.InputError, match=words):
        tv.ascent.read_log(written(tmp_path, **changes))


def test_what_is_no_mat_file_is_refused(tmp_path) -> None:
    file = tmp_path / "log.mat"
    for content in (b"", b"not one", b"MATLAB 5.0 MAT-file" + bytes(200)):
        file.write_bytes(content)
        with pytest.raises(tv.InputError, match="log.mat"):
            tv.ascent.read_log(file)
    savemat(file, {"name": "a text"})
    with pytest.raises(tv.InputError, match="vectors of one length"):
        tv.ascent.read_log(file)


def test_the_command_writes_both(tmp_path) -> None:
    out, wind = tmp_path / "flight.csv", tmp_path / "wind.csv"
    words = ["import", "log", str(LOG), "-o", str(out), "--wind-output", str(wind)]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    assert tv.load_schedule(out).span == (2.0, 8.0)
    sized = ["ascent", str(out), "--winds", str(wind), "--azimuth-deg", "0", "--limit-deg", "5"]
    result = CliRunner().invoke(app, [*sized, "--from", "4", "--to", "6"])
    assert result.exit_code == 0, result.output
