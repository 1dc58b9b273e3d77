"""Flights through parts of a sounding that are not known: no command says that they survive."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from tests.turns import usual
from tvclin.cli.app import app

HEIGHTS = {
    "known": np.arange(0.0, 41.0),
    "with gaps": np.array([0.0, 3.0, 6.0, 9.0, 20.0, 40.0]),
    "too short": np.arange(0.0, 13.0),
}
"""Heights of the levels [km] of a jet of straight lines between three heights."""


@pytest.fixture(scope="module")
def winds(tmp_path_factory):
    """Return the files of the soundings by name."""
    folder = tmp_path_factory.mktemp("winds")
    for name, heights in HEIGHTS.items():
        speeds = np.interp(heights, [0.0, 10.0, 20.0, 40.0], [3.0, 30.0, 10.0, 10.0])
        rows = [f"{h:g},{v},270" for h, v in zip(heights, speeds, strict=True)]
        text = "\n".join(["altitude_km,speed_m_per_s,direction_deg", *rows, ""])
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")
    return folder


def answer(winds, name, command, limit, *options):
    """Return exit code and JSON of a command with a limit [deg], or none, in a sounding."""
    verb, *words = command.split()
    given = ("--winds", winds / f"{name}.csv", "--azimuth-deg", 90)
    given += ("--limit-deg", limit) if limit else ()
    words = [verb, "configuration-i", *words, *given, *options, "--json"]
    done = CliRunner().invoke(app, [str(word) for word in words])
    return done.exit_code, json.loads(done.stdout)


SURVIVED = {
    "fly": lambda found: found["survived"],
    "fly --law autopilot": lambda found: found["survived"],
    "fly --engine planar-varying": lambda found: found["survived"],
    "respond": lambda found: found["survived"],
    "nozzle --law autopilot": lambda found: found["flown"][0]["verdict"]["satisfied"],
    "nozzle --over load --law trim": lambda found: found["flown"][0]["survives_within"],
    "nozzle --over flight --from 60 --to 64": lambda found: found["verdict"]["satisfied"],
    "ascent --from 60 --to 64": lambda found: found["verdict"]["sufficient"],
}
"""Whether a flight is survived, or a limit is sufficient, in the answer of each command."""


@pytest.mark.parametrize("command", usual(list(SURVIVED), 1, 4))
@pytest.mark.parametrize("name", ["with gaps", "too short"])
def test_a_limit_that_is_sufficient_in_a_known_wind_is_not_known_with_gaps(winds, command, name):
    """A sounding that ends within the time that counts is not known; a limit too small stays so."""
    survived = SURVIVED[command]
    if name == "too short" and ("flight" in command or "ascent" in command):
        pytest.skip("flight times after the end of a sounding are not sized")
    exit_code, found = answer(winds, "known", command, 0.7)
    assert (exit_code, survived(found)) == (0, True)
    exit_code, found = answer(winds, name, command, 0.7)
    assert survived(found) is None
    assert exit_code == (0 if command == "respond" else 1)
    exit_code, found = answer(winds, name, command, 0.15)
    assert survived(found) is False


@pytest.mark.thorough
@pytest.mark.parametrize(("name", "unknown"), [("known", False), ("with gaps", True)])
def test_the_limits_of_all_laws_are_not_known_in_a_sounding_with_gaps(winds, name, unknown):
    _, found = answer(winds, name, "fly --law all", None)
    assert any("survival is not known" in note for note in found["notes"]) is unknown


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["with gaps", "too short"])
def test_dispersed_vehicles_are_not_known_to_survive_a_sounding_with_gaps(winds, name):
    options = ("--probability", 0.5)
    _, known = answer(winds, "known", "disperse", 0.7, "--cases", 20, *options)
    assert known["success"]["estimate"] == 1.0
    exit_code, found = answer(winds, name, "disperse", 0.7, "--cases", 20, *options)
    assert exit_code == 1
    assert found["success"]["estimate"] == 0.0
    assert found["statuses"] == {"wind not known throughout, counted as not survived": 20}


@pytest.mark.thorough
def test_flown_margins_in_a_sounding_with_gaps_say_that_survival_is_not_known(winds):
    for name, unknown in (("known", False), ("with gaps", True)):
        _, found = answer(winds, name, "margins --natural-frequency 1", 0.7)
        assert any("survival is not known" in note for note in found["notes"]) is unknown
