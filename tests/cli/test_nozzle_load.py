"""`tvclin nozzle --over load`: numbers of the library, verdicts, exit codes and study files."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import tvclin as tv
from tests.turns import usual
from tvclin.cli.app import app
from tvclin.studyfile.findings import find
from tvclin.studyfile.questions import questions
from tvclin.studyfile.read import load_study

STUDY = """
[study]
vehicle = "configuration-i"
[wind]
peak_deg = 5.0
duration_s = 7.5
[nozzle]
limit_deg = 0.35
[load]
"""


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["nozzle", "--over", "load", *arguments])


def test_json_and_csv_equal_the_library(tmp_path: Path) -> None:
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
    expected = tv.boundary.load_trade_off(plant, wind, limit=np.radians(0.3), load=np.radians(3.0))
    file = tmp_path / "front.csv"
    options = ("--limit-deg", "0.3", "--load-deg", "3", "--json", "--csv", str(file))
    computed = json.loads(run(*options, "--plot", str(tmp_path / "a.png")).stdout)["trade_off"]
    assert computed["limits_deg"] == pytest.approx(np.degrees(expected.limits), rel=1e-12)
    assert computed["lower_bound_deg"] == pytest.approx(np.degrees(expected.lower_bound), rel=1e-12)
    rows = list(
        csv.DictReader(line for line in file.read_text().splitlines() if not line.startswith("#"))
    )
    column = [float(row["lower bound, wind known [deg]"]) for row in rows]
    assert column == pytest.approx(np.degrees(expected.limits), rel=1e-12)


@pytest.mark.parametrize(
    ("options", "code", "words"),
    usual(
        [
            (
                ("--limit-deg", "0.3", "--load-deg", "3"),
                0,
                "lower bound, wind known within this load",
            ),
            (("--limit-deg", "0.3", "--load-deg", "2"), 0, "more than this load"),
            (
                ("--limit-deg", "0.21", "--load-deg", "3"),
                1,
                "NOT SUFFICIENT, below the lower bound",
            ),
            ((), 0, "a limit below it is never sufficient"),
            (("--limit-deg", "0.5", "--load-deg", "3", "--law", "trim"), 1, "NOT within"),
            (("--limit-deg", "0.5", "--load-deg", "4", "--law", "half-relief"), 0, "within 4.000"),
            (("--limit-deg", "0.1", "--law", "trim"), 1, "trim is lost"),
            (("--wind", "rectangular", "--load-deg", "4"), 1, "no limit is sufficient"),
            (("--law", "trim"), 2, "--limit-deg"),
            (("--law", "trm", "--limit-deg", "1"), 2, "trim"),
            (("--set", "autopilot.attitude_gain=1"), 2, "--law"),
        ],
        *(0, 7, 8, 9, 10),
    ),
)
def test_the_verdict_and_its_exit_code(options: tuple[str, ...], code: int, words: str) -> None:
    result = run(*options)
    assert result.exit_code == code, result.output
    assert words in " ".join(result.output.split())


@pytest.mark.thorough
def test_a_gain_on_the_angle_of_attack_relieves_the_load() -> None:
    gains = ("--set", "autopilot.attitude_gain=0.4", "--set", "autopilot.rate_gain_s=1")
    plain = ("--limit-deg", "2", "--law", "autopilot", *gains)
    loads = [
        json.loads(run(*plain, "--set", "autopilot.alpha_gain", gain, "--json").stdout)["flown"][0][
            "load_deg"
        ]
        for gain in ("0", "-0.1", "0.1")
    ]
    assert len(set(loads)) == 3
    assert min(loads) < loads[0] < max(loads)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "table",
    [
        "load_deg = 3.0",
        "q_alpha_kPa_deg = 75\ndynamic_pressure_kPa = 25",
        "moment_kN_m = 600\nalpha_moment_N_m_per_deg = 2e5",
    ],
)
def test_a_study_file_asks_the_same_in_each_unit(table: str, tmp_path: Path) -> None:
    file = tmp_path / "a.toml"
    file.write_text(STUDY.replace("[wind]", 'sign = "frozen"\n[wind]') + table)
    computed = json.loads(run(str(file), "--json").stdout)["trade_off"]
    assert computed["load_deg"] == pytest.approx(3.0)
    own = find(load_study(str(file)))
    (request,) = [question for question in questions(own) if question.name == "load"]
    assert request.yes
    assert request.required_deflection == pytest.approx(np.radians(computed["lower_bound_deg"]))


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("", "needs one bound"),
        ("load_deg = 3\nmoment_N_m = 3\nalpha_moment_N_m_per_rad = 1", "needs one bound"),
        ("q_alpha_kPa_deg = 75", "q_alpha and dynamic_pressure together"),
        ("moment_N_m = 5", "moment and alpha_moment together"),
        ("load_deg = 3\ndeflection_moment_N_m_per_rad = 1", "beside deflection_moment"),
        ("load = 3", "load_deg"),
    ],
)
def test_a_wrong_table_is_refused_in_a_sentence(table: str, words: str, tmp_path: Path) -> None:
    file = tmp_path / "a.toml"
    file.write_text(STUDY + table)
    result = run(str(file))
    assert result.exit_code == 2
    assert words in " ".join(result.output.split())


@pytest.mark.thorough
def test_the_question_counts_the_pressure_at_the_peak_of_a_head_wind(tmp_path: Path) -> None:
    vehicle, bound = tv.load_vehicle("configuration-i"), np.radians(3.0)
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
    path, angle = vehicle.attitude, np.radians(-5.0)
    along = np.sin(angle) / np.sin(path + angle)
    ratio = (np.cos(path) - along) ** 2 + np.sin(path) ** 2
    head = vehicle.replace(
        normal_force_slope=vehicle.normal_force_slope * ratio,
        axial_force=vehicle.axial_force * ratio,
    )
    nominal, at_peak = (
        tv.boundary.load_trade_off(tv.Plant.from_vehicle(v), wind, [bound]).limits[0]
        for v in (vehicle, head)
    )
    assert at_peak > 1.05 * nominal
    file = tmp_path / "a.toml"
    file.write_text(f"{STUDY}load_deg = 3.0")
    middle = 0.5 * (nominal + at_peak)
    for limit, yes in ((0.98 * nominal, False), (middle, None), (1.02 * at_peak, True)):
        findings = find(replace(load_study(str(file)), nozzle=tv.Nozzle(limit=limit)))
        (question,) = [one for one in questions(findings) if one.name == "load"]
        assert question.yes is yes
        assert question.required_deflection == pytest.approx(at_peak, rel=1e-3)
        assert question.clause == (
            "within this load the lower bound, wind known, by the peak pressure of a head wind"
            " throughout, requires"
        )
        assert question.text.startswith("the limit covers the bound") is (yes is None)


def test_a_load_below_what_any_deflection_leaves_is_not_met(tmp_path: Path) -> None:
    file = tmp_path / "a.toml"
    file.write_text(STUDY.replace("[wind]", '[wind]\nshape = "rectangular"') + "load_deg = 4.0")
    (question,) = [one for one in questions(find(load_study(str(file)))) if one.name == "load"]
    assert question.answer == "NOT MET"
