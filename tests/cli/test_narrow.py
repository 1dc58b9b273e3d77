"""Narrow terminals: words are broken between words, files and pipes get whole lines."""

import json
import os
import re
import subprocess
import sys
import warnings
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tests.turns import usual
from tvclin.base.lines import QUANTITIES, Table
from tvclin.base.package_warnings import ImplausibleInput
from tvclin.cli.app import app
from tvclin.cli.output import print_answer, say
from tvclin.vehicle.vehicle_file import read_vehicle_text, template

COMMANDS = {
    "study": ["study", "configuration-i", "--model", "fixed-path", "--sign", "frozen"],
    "boundary": ["boundary", "configuration-i", "--tau-beta", "4", "--model", "drift"],
    "autopilot": ["margins", "configuration-i", "--more"],
    "error": ["study", "a vehicle of which nobody has ever heard and that is nowhere to be found"],
}


def words(*arguments: str, columns: str = "") -> str:
    env = {"COLUMNS": columns or None}
    return CliRunner().invoke(app, list(arguments), env=env).output


@pytest.mark.parametrize("name", COMMANDS)
def test_no_line_is_wider_than_the_terminal(name) -> None:
    wide = words(*COMMANDS[name]).splitlines()
    narrow = words(*COMMANDS[name], columns="40")

    assert max(map(len, narrow.splitlines())) <= 40
    sentences = [line for line in wide if line.startswith(("Note: ", "Error: ", "Bounds: "))]
    assert any(len(sentence) > 80 for sentence in sentences)
    for sentence in sentences:
        assert sentence in " ".join(narrow.split())


def test_no_width_breaks_json() -> None:
    arguments = (*COMMANDS["study"], "--json")

    assert json.loads(words(*arguments, columns="40")) == json.loads(words(*arguments))


def begun(*arguments: str, **environment: str) -> subprocess.CompletedProcess[bytes]:
    """Run the commands in an environment of their own."""
    return subprocess.run(
        [sys.executable, "-m", "tvclin", *arguments],
        capture_output=True,
        check=False,
        env={**os.environ, **environment},
    )


@pytest.mark.thorough
@pytest.mark.parametrize("width", ["0", "-3"])
def test_a_width_that_no_terminal_has_counts_as_none(width: str) -> None:
    error = begun("study", "nobody", COLUMNS=width)
    vehicles = begun("vehicles", COLUMNS=width)
    assert (error.returncode, vehicles.returncode) == (2, 0)
    assert error.stderr.decode() == words("study", "nobody")
    assert vehicles.stdout.decode().splitlines() == words("vehicles").splitlines()


@pytest.mark.thorough
@pytest.mark.skipif(os.name != "posix", reason="a locale of POSIX")
def test_a_letter_that_the_locale_lacks_is_a_question_mark(tmp_path: Path) -> None:
    """ASCII has no letter for 10⁶, nor for the name of this file."""
    file = tmp_path / "näme.toml"
    file.write_text(template())
    ascii_alone = {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    done = begun("poles", os.fspath(file), **ascii_alone)
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.isascii()
    assert b"?" in done.stdout


@pytest.mark.thorough
@pytest.mark.skipif(os.name != "posix", reason="names that only POSIX allows")
@pytest.mark.parametrize("letter", usual(["\x1b[31m", "\udcff", "\u202e"], 0))
def test_no_escape_sequence_of_a_file_reaches_terminal_csv_or_figure(
    tmp_path: Path, letter: str
) -> None:
    file, table, chart = tmp_path / f"a{letter}.csv", tmp_path / "a.csv", tmp_path / "a.svg"
    file.write_text("height_m,east_m_per_s,north_m_per_s\n0,0,0\n12000,40,0\n40000,0,0\n")
    calls = ["--azimuth-deg", "90", "--every", "60", "--csv", str(table), "--plot", str(chart)]
    done = CliRunner().invoke(app, ["ascent", "configuration-i", "--winds", str(file), *calls])
    assert done.exit_code == 0, done.output
    name = f"a{letter}.csv".replace(letter[0], "?")
    assert name in done.output
    assert name in table.read_text()
    for written in (done.output, table.read_text(), chart.read_text()):
        assert letter[0] not in written


def test_a_warning_is_shown_without_its_escape_sequences(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Matplotlib quotes the letter that its font lacks; the package passes such a warning on."""

    def warning(*_: object) -> tuple[str, ...]:
        warnings.warn("Glyph 27 (\x1b) missing from font", UserWarning, stacklevel=1)
        return ("configuration-i",)

    monkeypatch.setattr("tvclin.cli.vehicles.list_vehicles", warning, raising=False)
    monkeypatch.setattr("tvclin.vehicle.vehicle_file.list_vehicles", warning)
    said = CliRunner().invoke(app, ["vehicles"]).output
    assert "Warning: Glyph 27 (?) missing from font" in said
    assert "\x1b" not in said


def test_sentences_without_room_in_a_table_are_set_below_it_in_whole_words(capsys, monkeypatch):
    from tvclin.base.lines import Table
    from tvclin.cli.output import print_tables

    monkeypatch.setenv("COLUMNS", "80")
    sentence = "the whole flight of configuration-i; remaining beyond the reserve"
    numbers = tuple((f"{k}.123456789 deg",) for k in range(4))
    head = ("question", "answer", "required", "available", "remaining", "what is asked")
    print_tables(Table("Answers", head, ((("whole flight",), *numbers, (sentence,)),)))
    said = capsys.readouterr().out
    assert f"  whole flight: {sentence}"[:40] in said
    assert sentence in " ".join(said.split())


def test_the_peak_survived_of_a_wind_along_the_path_says_of_which_direction_it_is():
    result = CliRunner().invoke(app, ["study", "configuration-i", "--limit-deg", "0.5"])
    assert "survivable peak of the head wind" in " ".join(result.stdout.split())


@pytest.mark.parametrize("more", [False, True])
def test_an_answer_has_its_verdict_first_and_three_notes(more, capsys) -> None:
    table = Table("A", QUANTITIES, ((("weight",), ("3",)),))
    print_answer("enough", table, notes="wxyz", more=more, details=lambda: say("details"))

    said = [line.strip() for line in capsys.readouterr().out.splitlines() if line.strip()]
    notes = [f"Note: {note}." for note in ("wxyz" if more else "wxy")]
    end = "details" if more else "--more prints all tables and notes."
    assert said == ["Enough.", "A", "weight  3", *notes, end]


def test_notes_on_implausible_input_are_first_and_all_printed(capsys) -> None:
    table = Table("A", QUANTITIES, ((("weight",), ("3",)),))
    implausible = [ImplausibleInput(note) for note in "pqrs"]
    for count, further in ((1, "wx"), (4, "")):
        print_answer("enough", table, notes=["w", "x", "y", *implausible[:count]])
        said = [line for line in capsys.readouterr().out.splitlines() if "Note" in line]
        assert said == [f"Note: {note}." for note in (*implausible[:count], *further)]


def test_numbers_beyond_all_nozzles_are_no_wider_than_others(tmp_path: Path) -> None:
    """A thrust in kN where N was meant requires 1e47 deg, which was printed with all its digits."""
    text = read_vehicle_text("configuration-i")[0]
    thrust = re.search(r"(?m)^thrust_N = (\S+)", text)
    assert thrust is not None
    file = tmp_path / "kn.toml"
    file.write_text(text.replace(thrust[0], f"thrust_N = {float(thrust[1]) / 1e3!r}"))
    said = CliRunner(env={"COLUMNS": "80"}).invoke(app, ["study", str(file)]).output
    assert said.startswith("In this wind the ideal trim law requires more than 90 deg of")
    notes = " ".join(said.split()).split("Note: ")[1:]
    assert "the linear force of a nozzle says nothing" in notes[0]
    assert "a power of ten may be missing" in notes[1]
    assert max(len(line.rstrip()) for line in said.splitlines()) <= 80


def test_a_velocity_above_that_of_escape_is_noted(tmp_path: Path) -> None:
    file = tmp_path / "fast.toml"
    text = read_vehicle_text("configuration-i")[0]
    file.write_text(re.sub(r"(?m)^velocity_\w+ = \S+", "velocity_km_per_s = 470", text))
    said = " ".join(CliRunner().invoke(app, ["margins", str(file)]).output.split())
    assert (
        "the velocity V_n is 4.7e+05 m/s, above the escape velocity: its unit may be wrong" in said
    )


@pytest.mark.thorough
def test_a_closed_pipe_is_no_verdict() -> None:
    """With a reader that closes at once the exit code is 128 + SIGPIPE, as in other programs."""
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        [sys.executable, "-m", "tvclin", "study", "configuration-i", "--limit-deg", "3"],
        stdout=write,
        stderr=subprocess.PIPE,
        check=False,
    )
    os.close(write)
    assert (done.returncode, done.stderr) == (141, b"")


def test_a_heading_is_broken_before_a_cell() -> None:
    said = CliRunner(env={"COLUMNS": "80"}).invoke(app, ["margins", "configuration-i"]).output
    (aero,) = (line for line in said.splitlines() if line.startswith("  aero: gain may fall"))
    assert aero.rstrip().endswith("NOT MET")
    assert "dB (1.79x)" in aero
