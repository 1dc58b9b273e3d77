"""Narrow terminals: words are broken between words, files and pipes get whole lines."""

import json

import pytest
from typer.testing import CliRunner

from tvclin.cli.app import app

COMMANDS = {
    "study": ["study", "configuration-i", "--model", "fixed-path", "--sign", "frozen"],
    "boundary": ["boundary", "configuration-i", "--model", "drift"],
    "autopilot": ["margins", "configuration-i"],
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
    assert any(len(one) > 80 for one in sentences)
    for one in sentences:
        assert one in " ".join(narrow.split())


def test_no_width_breaks_json() -> None:
    asked = (*COMMANDS["study"], "--json")

    assert json.loads(words(*asked, columns="40")) == json.loads(words(*asked))
