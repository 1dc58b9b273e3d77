"""One model where none is named: every command takes it, and says so at once."""

import pytest
from typer.testing import CliRunner

from tests.turns import usual
from tvclin.cli.app import app

COMMANDS = {
    "study": [],
    "respond": [],
    "boundary": [],
    "margins": [],
    "design": [],
    "fly": ["--law", "autopilot"],
    "ascent": ["--from", "66", "--to", "66"],
}


@pytest.mark.parametrize("command", usual(COMMANDS, 0, 1, 2, 3))
def test_the_first_lines_name_the_model(command: str) -> None:
    said = CliRunner().invoke(app, [command, "configuration-i", *COMMANDS[command]])
    lines = said.stdout.strip().splitlines()
    assert "drift-exact" in " ".join(lines[:6]), said.output  # verdict and title of two lines


@pytest.mark.parametrize("command", usual([one for one in COMMANDS if one != "ascent"], 0, 1, 2))
def test_where_no_path_is_known_it_is_fixed(tmp_path, command: str) -> None:
    file = tmp_path / "course.toml"
    file.write_text("[coefficients]\nmu_alpha_per_s2 = 0.228\nmu_delta_per_s2 = 1.317\n")
    said = CliRunner().invoke(app, [command, str(file), *COMMANDS[command]])
    assert "fixed-path" in " ".join(said.stdout.strip().splitlines()[:6]), said.output
