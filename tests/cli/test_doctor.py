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
    told = json.loads(CliRunner().invoke(app, ["doctor", "--json"]).stdout)

    for name in ("tvclin", "numpy", "scipy", "control", "matplotlib"):
        assert told["versions"][name] == metadata.version(name)


def test_what_is_missing_is_named_with_its_mend(monkeypatch) -> None:
    def version(name: str) -> str:
        if name == "slycot":
            raise metadata.PackageNotFoundError(name)
        return "1.0"

    monkeypatch.setattr(metadata, "version", version)
    told = CliRunner().invoke(app, ["doctor"])

    assert told.exit_code == 0
    assert "slycot missing" in told.stdout
    assert 'pip install "tvclin[slycot]"' in told.stdout


def test_every_extra_of_the_project_says_what_it_adds() -> None:
    assert set(ADDS) >= set(PROJECT["optional-dependencies"]) - {"all"}
