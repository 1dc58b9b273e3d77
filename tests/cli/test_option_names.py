"""Messages of a command name its options, not the arguments of Python behind them."""

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tvclin.base.lines import plural, significant, text
from tvclin.cli.app import app
from tvclin.cli.settings import in_options
from tvclin.vehicle.vehicle_file import read_vehicle_text

V = "configuration-i"
OPENROCKET = "tests/schedules/openrocket.csv"
EXPORT = ("import", "openrocket", OPENROCKET, "-o", "out.csv")
SITE = ("--gimbal-station-m", "2.95", "--cn-alpha-per-rad", "2", "--ground-m", "160")
REFUSED = {
    "--duration": ("study", V, "--duration", "1e12"),
    "--peak-deg": ("study", V, "--peak-deg", "1e9"),
    "--peak-speed": ("study", V, "--peak-speed", "1e9"),
    "--gust": ("study", V, "--gust", "1e12", "1"),
    "--limit-shape": ("study", V, "--limit-shape", "nonsense"),
    "--model": ("poles", V, "--model", "nonsense"),
    "--start": ("boundary", V, "--start", "nan"),
    "--horizon": ("boundary", V, "--horizon", "-1"),
    "--rate-limit-deg": ("nozzle", V, "--rate-limit-deg", "1e12"),
    "--dead-band": ("fly", V, "--dead-band", "7"),
    "--sample-rate": ("margins", V, "--sample-rate", "1e12"),
    "--natural-frequency": ("margins", V, "--natural-frequency", "-1"),
    "--rate-gain": ("margins", V, "--attitude-gain", "1"),
    "--at": ("study", V, "--at", "1000"),
    "--gimbal-station-m": (*EXPORT, *SITE[2:], "--gimbal-station-m", "0.01"),
    "--cn-alpha-per-rad": (*EXPORT, *SITE[:2], *SITE[4:], "--cn-alpha-per-rad", "200"),
    "--ground-m": (*EXPORT, *SITE[:4], "--ground-m", "1e5"),
}


@pytest.mark.parametrize("option", REFUSED)
def test_what_is_wrong_with_an_option_is_said_of_that_option(option, tmp_path, monkeypatch):
    given = [str(tmp_path / "out.csv") if one == "out.csv" else one for one in REFUSED[option]]
    result = CliRunner().invoke(app, given)
    assert result.exit_code == 2
    assert re.search(rf"{option}(?![\w-])", result.output), result.output


def test_rows_that_are_refused_are_left_out_with_the_options_of_the_command(tmp_path):
    """The wind angle of the third row becomes more than the linear vehicle has."""
    lines = Path(OPENROCKET).read_text(encoding="utf-8").splitlines()
    names = next(line for line in lines if "Angle of attack" in line).lstrip("# ").split(",")
    column = next(k for k, name in enumerate(names) if "Angle of attack" in name)
    rows = [k for k, line in enumerate(lines) if line[:1].isdigit()]
    for k in rows:
        cells = lines[k].split(",")
        cells[column] = "11"
        lines[k] = ",".join(cells)
    file = tmp_path / "flight.csv"
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    given = ["import", "openrocket", file, *SITE, "-o", tmp_path / "out.csv"]
    result = CliRunner().invoke(app, [str(one) for one in given])
    assert result.exit_code == 2
    assert "leave these rows out with --from and --to" in result.output


def test_only_arguments_become_options():
    likely = {"start": ("--from",), "stop": ("--to", "--stop"), "dead_band": ("--dead-band",)}
    same = (
        "study.toml: [study]: dead_band must be between 0 and 1",
        "[nozzle] has dead_band and more; keep one",
        "the flight must start before the stop of the nozzle",
        "stop must be one of round",  # both may be meant
    )
    for sentence in same:
        assert in_options(sentence, likely, ["--from", "--to", "--stop"]) == sentence
    assert in_options("stop must rise", likely, ["--to"]) == "--to must rise"
    assert in_options("start must rise", likely, []) == "start must rise"


@pytest.mark.parametrize("option", [("--sample-rate", "25"), ("--delay-ms", "3")])
def test_nothing_is_said_of_a_file_where_an_option_is_meant(option):
    result = CliRunner().invoke(app, ["fly", V, *option])
    assert (result.exit_code, "file" in result.output) == (2, False)
    assert f"{option[0]} needs --engine linear" in result.output


def test_a_count_of_one_is_singular_and_zero_has_no_minus():
    assert [plural(k, "row") for k in (0, 1, 2)] == ["0 rows", "1 row", "2 rows"]
    assert text(significant("damping", -0.0)) == "0"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("study --limit-deg abc", "--limit-deg must be a number, such as 0.4"),
        ("study --limit-deg 0,4", "--limit-deg must be a number, such as 0.4"),
        ("disperse --cases 1.5", "--cases must be a whole number, such as 100"),
        (
            "study --limit-deg",
            "tvclin study: option '--limit-deg' requires an argument; see tvclin study --help",
        ),
        ("study --verbose", "tvclin study: no option --verbose; see tvclin study --help"),
        ("study --jsn", "tvclin study takes no --jsn: did you mean --json or --sign?"),
        ("stdy", "no such command 'stdy'"),
        (
            "fly --gust 1 2",
            "takes no --gust: --set gust.peak_deg VALUE --set gust.duration_s VALUE give it",
        ),
        ("boundary --gust-duration 2", "takes no --gust-duration: --set gust.duration_s VALUE"),
        (
            "study --azimuth-deg 90",
            "--azimuth-deg needs a wind with a direction, --set wind.direction_deg 270; tvclin",
        ),
        ("study a b", "tvclin study: got unexpected extra argument"),
        ("import table", "tvclin import table: missing argument 'file'"),
        ("nozzle --from 3", "--from needs --over flight"),
        ("study --peak-deg 95", "--peak-deg must be a wind angle within 90 degrees; got 95 deg"),
        ("study --natural-frequency -1", "--natural-frequency must be positive; got -1 rad/s"),
        ("disperse --wind square", "--wind must be one of triangular"),
        ("disperse --azimuth-deg 90", "--azimuth-deg needs a sounding, --winds FILE"),
        ("ascent --winds {folder} --azimuth-deg 90", "no file of soundings in {folder}"),
        ("study {file}", "limit_deg in [nozzle] must be positive; got -0.45 deg"),
        (
            "study --set nozzle.limit_deg -0.45",
            "limit_deg in [nozzle] must be positive; got -0.45 deg",
        ),
        ("study {loose}", "key 'name' stands in no table; write the table above it"),
        ("study --damping 0 --natural-frequency 1", "--damping must be positive; got 0"),
    ],
)
def test_a_command_line_that_cannot_be_read_is_one_sentence(
    words: str, said: str, tmp_path: Path
) -> None:
    file, folder = tmp_path / "s.toml", tmp_path / "empty"
    folder.mkdir()
    file.write_text(
        '[study]\nvehicle = "configuration-i"\n[wind]\npeak_deg = 5\nduration_s = 7.5\n'
        "[nozzle]\nlimit_deg = -0.45\n"
    )
    loose = tmp_path / "v.toml"
    loose.write_text(read_vehicle_text(V)[0].replace("[vehicle]", ""))
    given = {"file": file, "folder": folder, "loose": loose}
    result = CliRunner().invoke(app, words.format(**given).split())
    assert result.exit_code == 2
    message = " ".join(result.stderr.split())
    assert message.startswith("Error: ")
    assert said.format(folder=folder) in message
    assert "──" not in message


@pytest.mark.parametrize(
    ("keys", "options", "said"),
    [
        ("damping = 0.7", "", "design poles needs autopilot.natural_frequency_rad_per_s, in"),
        ("attitude_gain = 1", "", "need autopilot.attitude_gain and autopilot.rate_gain_s, both"),
        ("damping = 0.7", "--damping 0.6", "design poles needs --natural-frequency, in rad/s"),
        (
            "damping = 0.7",
            "--set autopilot.damping 0.6",
            "design poles needs --set autopilot.natural_frequency_rad_per_s, in rad/s",
        ),
        ("delay_ms = 5", "--damping 0.6", "design poles needs --natural-frequency, in rad/s"),
    ],
)
@pytest.mark.parametrize("command", ["study", "margins", "fly"])
def test_an_error_about_gains_names_keys_where_the_file_gives_them(
    command: str, keys: str, options: str, said: str, tmp_path: Path
) -> None:
    file = tmp_path / "s.toml"
    wind = "[wind]\npeak_deg = 5\nduration_s = 7.5\n"
    file.write_text(f'[study]\nvehicle = "{V}"\n{wind}[autopilot]\n{keys}\n')
    result = CliRunner().invoke(app, [command, str(file), *options.split()])
    assert result.exit_code == 2
    assert said in " ".join(result.stderr.split())


def test_help_of_study_offers_no_sounding() -> None:
    """A study takes a wind with a direction alone; other commands take a sounding too."""
    shown = CliRunner().invoke(app, ["study", "--help"]).output
    assert "wind.direction_deg" in shown
    assert "sounding" not in shown.partition("--azimuth-deg")[2].partition("--gust")[0]
