"""No command writes over a file that it reads: exit code 2, one sentence, the file as it was."""

from pathlib import Path
from shutil import copy

import pytest
from typer.testing import CliRunner

from tests.archives import Balloon, days, jet, write
from tests.whole_flight import write_flight
from tvclin.cli.app import app

_STUDY = """
[study]
vehicle = "configuration-i"
[wind]
sounding = "sounding.csv"
azimuth_deg = 90
"""
_LOOK = "--azimuth-deg 90"
_COMMANDS = (
    "report vehicle.toml -o vehicle.toml",
    "report link.toml -o vehicle.toml",
    "report sounding.toml -o sounding.csv",
    "fly vehicle.toml --csv vehicle.toml",
    "respond vehicle.toml --csv vehicle.toml",
    "margins study.toml --csv gains.csv",
    "margins study.toml --csv modes.csv",
    "margins study.toml --csv flight.csv",
    "ascent flight.csv --csv flight.csv",
    f"boundary configuration-i --winds sounding.csv {_LOOK} --csv sounding.csv",
    f"availability configuration-i archive {_LOOK} --limit-deg 1 --csv archive/2.txt",
    f"availability configuration-i archive {_LOOK} --limit-deg 1 --csv archive/bad.csv",
    f"availability configuration-i archive {_LOOK} --limit-deg 1 --csv t.csv --today t.csv",
    "disperse campaign.toml --csv campaign.toml",
    "import table flight.csv --columns vehicle.toml -o vehicle.toml",
    "import log flight.csv -o flight.csv",
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A folder with a vehicle, a flight and its study, a campaign, a sounding and an archive."""
    made = tmp_path_factory.mktemp("inputs")
    write_flight(made)
    for options, name in (
        (["--vehicle", "configuration-i"], "vehicle"),
        (["--campaign"], "campaign"),
    ):
        assert CliRunner().invoke(app, ["init", f"{made}/{name}.toml", *options]).exit_code == 0
    (made / "link.toml").hardlink_to(made / "vehicle.toml")
    copy("tests/soundings/components.csv", made / "sounding.csv")
    copy("tests/soundings/components.csv", made / "t.csv")
    (made / "sounding.toml").write_text(_STUDY)
    (made / "archive").mkdir()
    for i, time in enumerate(days("2023-02-24T00", 3)):
        write(made / "archive" / f"{i}.txt", [Balloon(time, jet(5.0 * (i + 1)))])
    (made / "archive" / "bad.csv").write_text("no sounding\n")
    return made


@pytest.mark.parametrize("line", _COMMANDS)
def test_a_file_that_is_read_is_no_output(folder, monkeypatch, line) -> None:
    monkeypatch.chdir(folder)
    before = {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    result = CliRunner().invoke(app, line.split())
    assert (result.exit_code, result.stdout) == (2, ""), result.output
    assert " must not be a file that is read; got " in " ".join(result.stderr.split())
    assert {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()} == before
