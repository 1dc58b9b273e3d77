"""The verdict on a limit that every command gives or leaves to `tvclin study`, in its words.

Configuration I in a triangle of 5 deg and 7.5 s with 0.4 deg: 0.412 deg is required, at the dynamic
pressure of a head wind, by `solve_ivp` of the linear equations in
`tests/requirement/test_encountered_requirement`.
"""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import tvclin as tv
from tests.turns import usual
from tvclin.base.quantities import QUANTITIES, satisfaction, sufficiency, survival
from tvclin.cli.app import app
from tvclin.studyfile.glossary import TERMS
from tvclin.winds.wind_angles import BEYOND_LINEAR

WIND = ("--wind", "triangular", "--duration", "7.5", "--peak-deg", "5")
LIMIT = ("--limit-deg", "0.4")
AT = ("--from", "66", "--to", "66")
REQUIRED, NOMINAL = "0.412 deg", "at nominal dynamic pressure"
SEE = f"equired deflection {REQUIRED} in a head wind, see study"
OTHERS = re.compile(
    r"(?<!NOT )\b(SUFFICIENT|ENOUGH|Enough|enough)\b|NOT [Ee]nough|NOT ENOUGH|\bLOST\b|calm air"
)
"""Verdicts that a limit of 0.4 deg must not have, and words that are no verdicts."""


NUMBERED = ("study", "respond", "fly", "nozzle", "boundary")


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, list(arguments))


def test_a_limit_below_the_bound_of_an_autopilot_is_not_known_and_by_how_much_is_said():
    """Between what the nominal and the peak pressure require of this autopilot nothing is known."""
    limit = ("--limit-deg", "0.6", "--natural-frequency", "1.0")
    first = " ".join(run("study", *WIND, *limit).stdout.partition("\n\n")[0].split())
    numbers = re.match(
        r"NOT KNOWN: the limit of 0\.600 deg is (\S+) deg .* short of the (\S+) deg that this"
        r" autopilot requires, by the bound for a head wind;",
        first,
    )
    assert numbers, first
    short, required = map(float, numbers.groups())
    assert required - short == pytest.approx(0.6, abs=1.5e-3)


@pytest.mark.thorough
def test_a_rate_limit_above_the_bounds_is_said_to_be_no_more():
    shown = run("study", *WIND, "--limit-deg", "0.6", "--rate-limit-deg", "0.2").output
    assert "at the nominal one 0.108 deg/s; a law may require more" in " ".join(shown.split())


def test_a_rate_limit_in_the_budget_is_said_to_be_a_bound():
    shown = run("ascent", *WIND, "--limit-deg", "0.6", *AT, "--rate-limit-deg", "0.2").output
    assert "a bound: a law may survive with less" in " ".join(shown.split())


def test_the_duty_over_a_flight_says_that_its_vehicle_is_frozen_where_ascent_varies_it():
    shown = run("nozzle", "--over", "flight", *WIND, "--limit-deg", "0.5", *AT).output
    said = " ".join(shown.split())
    assert "trim is flown with the vehicle frozen at each flight time, in a head wind at" in said
    assert "through the dynamics of the nozzle; tvclin ascent judges the ideal trim law" in said


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    usual(
        [
            (
                ("study", "configuration-i", *WIND, *LIMIT),
                1,
                (REQUIRED, "NOT SUFFICIENT: the limit of 0.400 deg"),
            ),
            (("boundary", "--tau-beta", "4"), 0, (f"limit {NOMINAL}",)),
            (
                ("respond", "configuration-i", *WIND, *LIMIT),
                0,
                (SEE, "SURVIVED: 0.351 deg", NOMINAL),
            ),
            (
                ("fly", "configuration-i", *WIND, *LIMIT),
                0,
                (SEE, f"SURVIVED with 0.400 deg {NOMINAL}"),
            ),
            (
                ("nozzle", "configuration-i", *WIND, *LIMIT),
                0,
                (SEE, "wind known: 0.199 deg", NOMINAL),
            ),
            (
                ("nozzle", "configuration-i", "--over", "load", *WIND, *LIMIT),
                0,
                (SEE, "wind known: 0.199 deg", NOMINAL),
            ),
            (("boundary", "configuration-i", *WIND), 0, (SEE, "Lower bound, wind known", NOMINAL)),
            (
                ("fly", "configuration-i", *WIND, *LIMIT, "--law", "autopilot", "--more"),
                1,
                (
                    "0.974 deg at the peak pressure of a head wind, 0.690 deg at nominal",
                    "the autopilot uses 0.895 deg without a limit",
                    SEE,
                    "Limit 0.4 deg: NOT SUFF",
                ),
            ),
            (
                ("margins", "configuration-i", *WIND, "--limit-deg", "1.2"),
                1,
                (f"{NOMINAL}, with a limit of 1.2 deg", "Criteria classic: NOT MET"),
            ),
            (("fly", "configuration-i", *WIND, "--law", "all", "--more"), 0, (NOMINAL,)),
            (("ascent", "configuration-i", *WIND, *LIMIT, *AT), 1, ("Limit 0.400 deg: NOT SUFF",)),
            (
                ("nozzle", "configuration-i", "--over", "flight", *WIND, *LIMIT, *AT, "--more"),
                1,
                ("NOT SURVIVED: trim is lost", "required deflection is that of tvclin ascent"),
            ),
            (
                ("fly", "configuration-i", *WIND, *LIMIT, "--law", "autopilot"),
                1,
                (f"{SEE}: for the ideal trim law", "NOT SURVIVED"),
            ),
        ],
        *(0, 1, 2, 3, 4, 6, 7, 10, 11, 12),
    ),
    ids=lambda value: value[0] if isinstance(value, tuple) and value[0].isalpha() else "",
)
def test_no_command_calls_a_limit_sufficient_that_is_not(arguments, code, words) -> None:
    result = run(*arguments)
    said = " ".join(result.output.split())
    assert result.exit_code == code, said
    assert [word for word in words if word not in said] == [], said
    assert OTHERS.search(said) is None, said


FILE = """
[study]
vehicle = "configuration-i"
[wind]
shape = "triangular"
peak_deg = 5.0
duration_s = 7.5
[nozzle]
limit_deg = 0.4
[campaign]
cases = 1
seed = 1
"""


@pytest.mark.thorough
def test_page_and_campaign_of_one_case_say_what_the_study_says(tmp_path) -> None:
    file, page = tmp_path / "one.toml", tmp_path / "page.html"
    file.write_text(FILE, encoding="utf-8")
    assert run("report", str(file), "--output", str(page)).exit_code == 1
    text = page.read_text(encoding="utf-8")
    assert "<h1>NOT SUFFICIENT: the limit of" in text
    where = (
        "at nominal dynamic pressure, without that of the head wind, on which the verdict stands"
    )
    assert f"Exact response of the linear model {where}" in " ".join(text.split())
    shown = re.sub(r"<[^>]*>", " ", text)
    assert OTHERS.search(shown[: shown.index("Inputs")].replace(" SUFFICIENT in ", "")) is None
    required = np.degrees(tv.load_study(file).study().required_deflection)
    folder = str(tmp_path / "campaign")
    assert run("disperse", str(file), "--folder", folder).exit_code == 1
    shown = json.loads(run("disperse", folder, "--limit-deg", "0.4", "--json").stdout)
    assert shown["nominal_deg"] == pytest.approx(required, rel=1e-9)
    assert shown["success"]["estimate"] == 0.0


@pytest.mark.parametrize("command", usual(NUMBERED, 0, 1, 2))
def test_json_has_the_required_deflection_under_one_name(command) -> None:
    limit = () if command == "boundary" else LIMIT
    document = json.loads(run(command, "configuration-i", *WIND, *limit, "--json").stdout)
    result = document.get("verdict", document) if command == "study" else document
    assert result["required_deflection_deg"] == pytest.approx(0.412, abs=5e-4)


def test_the_front_door_of_python_has_the_digits_of_the_shell_and_plants_say_what_they_are() -> (
    None
):
    vehicle, peak = tv.load_vehicle("configuration-i"), np.radians(5.0)
    study = tv.Study.from_vehicle(vehicle, duration=7.5, peak=peak, limit=np.radians(0.4))
    answer = json.loads(run("study", "configuration-i", *WIND, *LIMIT, "--json").stdout)
    assert ("sufficient" in answer, answer["all_answers_yes"]) == (False, False)
    computed = answer["verdict"]
    assert computed["required_deflection_deg"] == np.degrees(study.required_deflection)
    assert (study.sufficient, computed["sufficient"]) == (False, False)
    for function in (tv.required_deflection, tv.is_sufficient, tv.boundary_limit, tv.size):
        assert NOMINAL in " ".join(str(function.__doc__).split("\n\n")[1].split())


def test_each_quantity_has_one_sentence_in_code_and_on_the_page_of_conventions() -> None:
    page = Path("docs/conventions.md").read_text(encoding="utf-8")
    table = page[page.index("| quantity | definition |") :].split("\n\n")[0].splitlines()[2:]
    rows = dict(row.strip("| ").split(" | ") for row in table)
    assert rows == QUANTITIES
    assert QUANTITIES.items() <= TERMS.items()


def test_answers_have_three_words_each() -> None:
    each = [[word(one) for one in (True, False, None)] for word in (sufficiency, satisfaction)]
    assert each[0] == ["SUFFICIENT", "NOT SUFFICIENT", "NOT KNOWN"]
    assert each[1] == ["MET", "NOT MET", "NOT KNOWN"]
    assert [survival(one) for one in (True, False, None)][1] == "NOT SURVIVED"


def test_a_wind_across_the_path_is_no_tail_wind() -> None:
    """In the yaw plane it is a cross wind, whichever sign a file has."""
    across, signed = (run("study", "--plane", "yaw", *sign) for sign in ((), ("--sign", "tail")))
    assert across.output.partition("\n\n")[0] == signed.output.partition("\n\n")[0]
    assert "sign tail is not counted: a wind in the yaw plane" in signed.output
    said = " ".join(run("study", "--plane", "yaw", "--sign", "tail", "--more").output.split())
    assert "tail wind" not in said


@pytest.mark.parametrize("command", ["poles", "respond", "nozzle"])
def test_the_verdict_stands_above_all_notes(command: str) -> None:
    said = run(command, "made-up-launcher")
    assert "Note: " in said.stderr
    assert not said.output.startswith("Note: "), said.output[:200]


def test_beyond_30_degrees_no_rise_of_the_pressure_is_said() -> None:
    """Of 40 deg eq (B1e) made 1.6e+03 percent, at an angle at which no linear answer is known."""
    for peak, rise in (("40", None), ("25", "raises the pressure by up to")):
        said = " ".join(run("respond", "--peak-deg", peak).output.split())
        assert (rise or "NOT KNOWN") in said
        assert "e+0" not in said


def test_a_verdict_that_is_not_known_says_why_in_its_first_line() -> None:
    """Of a limit alone, and of a wind with an autopilot, whose reason is the same."""
    wide = ("configuration-i", "--peak-deg", "35", "--limit-deg", "3")
    for more in ((), ("--set", "autopilot.design", "canonical")):
        first = run("study", *wide, *more).output.partition("\n\n")[0]
        assert "NOT KNOWN" in first
        assert BEYOND_LINEAR in " ".join(first.split())
