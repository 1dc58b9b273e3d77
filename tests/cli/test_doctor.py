"""`tvclin doctor` against what is really installed."""

import json
import tomllib
from importlib import metadata
from pathlib import Path

from typer.testing import CliRunner

from tvclin.cli.app import app
from tvclin.cli.doctor import ADDS

PROJECT = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]


def test_it_prints_the_versions_that_are_installed() -> None:
    answer = json.loads(CliRunner().invoke(app, ["doctor", "--json"]).stdout)

    for name in ("tvclin", "numpy", "scipy", "control", "matplotlib"):
        assert answer["versions"][name] == metadata.version(name)


def test_what_is_missing_is_named_with_its_mend(monkeypatch) -> None:
    def version(name: str) -> str:
        if name == "slycot":
            raise metadata.PackageNotFoundError(name)
        return "1.0"

    monkeypatch.setattr(metadata, "version", version)
    answer = CliRunner().invoke(app, ["doctor"])

    assert answer.exit_code == 0
    assert "slycot missing" in answer.stdout
    assert 'pip install "tvclin[slycot]"' in answer.stdout


def test_every_extra_of_the_project_says_what_it_adds() -> None:
    assert set(ADDS) >= set(PROJECT["optional-dependencies"]) - {"all"}
