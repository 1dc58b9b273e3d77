"""One limit of linear aerodynamics, 30 deg, and one sentence, wherever a wind is judged.

The numbers that were said before come from the linear equations beyond their range: 171.024 deg of
a wind were survived by configuration I with 12 deg, and 4.210 deg enough in one of 60 deg.
"""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.turns import by_turns, usual
from tvclin.cli.app import app
from tvclin.winds.wind_angles import BEYOND_LINEAR, DOUBTFUL

WIDE = ("configuration-i", "--peak-deg", "60", "--limit-deg", "12")
SENTENCE = "the wind meets the flight at 60 deg, and above 30 deg linear aerodynamics says nothing"


def run(*arguments: str):
    result = CliRunner().invoke(app, list(arguments))
    return result.exit_code, " ".join(result.stdout.split())


def study(deg: float, **options) -> tv.Study:
    vehicle = tv.load_vehicle("configuration-i")
    return tv.Study.from_vehicle(vehicle, duration=7.5, peak=np.radians(deg), **options)


@pytest.mark.parametrize(
    ("command", "options", "words"),
    usual(
        [
            ("study", (), "NOT KNOWN: the wind meets"),
            ("nozzle", (), "NOT KNOWN"),
            ("nozzle", ("--law", "trim"), "NOT KNOWN"),
            ("fly", (), "NOT KNOWN with 12.000 deg at nominal dynamic pressure"),
            (
                "fly",
                ("--engine", "linear", "--law", "trim"),
                "NOT KNOWN with 12.000 deg at nominal dynamic pressure",
            ),
            ("nozzle", ("--over", "load", "--law", "trim"), "NOT KNOWN"),
            ("fly", ("--law", "autopilot"), "Limit 12 deg: NOT KNOWN"),
            ("ascent", ("--from", "66", "--to", "66"), "Limit 12.000 deg: NOT KNOWN"),
            ("nozzle", ("--over", "flight", "--from", "66", "--to", "66"), "NOT KNOWN"),
        ],
        0,
    ),
)
def test_no_command_judges_a_wind_of_60_degrees(command, options, words) -> None:
    code, said = run(command, *WIDE, *options)
    assert (code, words in said, SENTENCE in said) == (1, True, True), said


@pytest.mark.parametrize("command", usual(["respond", "boundary"], 1))
def test_an_answer_without_an_exit_code_says_the_sentence(command) -> None:
    options = WIDE if command == "respond" else WIDE[:3]
    code, said = run(command, *options)
    assert (code, SENTENCE in said, " SUFFICIENT" in said) == (0, True, False)


@pytest.mark.parametrize("deg", [31, 35, 40, 45, 60])
def test_a_pulse_beyond_the_linear_range_is_not_sized(deg) -> None:
    """Short by 0.788, 13.4 and 84 deg it was at 31, 35 and 40 deg, and sufficient from 45 on."""
    options = ("--from", "66", "--to", "66", "--limit-deg", "12", "--peak-deg", str(deg))
    code, said = run("ascent", "configuration-i", *options)
    assert (code, "NOT KNOWN at 66 s" in said, BEYOND_LINEAR in said) == (
        1,
        True,
        True,
    )
    assert "SUFFICIENT" not in said


@pytest.mark.thorough
def test_a_gust_counts_in_the_angle() -> None:
    """25 deg of wind and 10 of gust at its peak are 35."""
    gust = tv.winds.OneMinusCosineGust(peak=np.radians(10.0), duration=2.0)
    single, both = (study(25.0, limit=0.2, gust=one, gust_at=3.75) for one in (None, gust))
    assert (single.beyond_linear, both.sufficient) == ("", None)
    assert "at 35 deg" in both.beyond_linear


def test_the_vector_of_a_wind_with_a_direction_counts() -> None:
    """From the right front its part in pitch is below 30 deg, and the wind is not."""
    slanting = study(40.0, limit=0.2, heading=np.radians(45.0), model="fixed-path")
    assert np.degrees(abs(slanting.history.peak)) < 30.0
    assert slanting.sufficient is None
    assert "at 40 deg" in slanting.notes[0]


@pytest.mark.parametrize("deg", usual([5.0, 30.0, 52.0], 1))
def test_no_survivable_peak_is_beyond_the_linear_range(deg) -> None:
    """With 12 deg: it was 30.463 deg for a peak of 30, and 171.024 for one of 52."""
    result = study(deg, limit=np.radians(12.0))
    assert np.degrees(result.survivable_peak) == pytest.approx(30.0, rel=1e-12)
    assert result.survives_bound is True
    said = result.as_dict()["verdict"]
    assert said["survivable_peak_is_bound"] is True


@pytest.mark.thorough
def test_what_is_survived_below_the_bound_does_not_depend_on_the_wind_in_question() -> None:
    small, wide = (study(deg, limit=np.radians(1.0)) for deg in (5.0, 52.0))
    assert wide.survives_bound is False
    assert wide.survivable_peak == pytest.approx(small.survivable_peak, rel=1e-6)


def test_no_angle_of_a_study_is_extrapolated() -> None:
    code, said = run("study", *WIDE, "--json")
    answer = json.loads(said)
    assert code == 1
    assert answer["verdict"]["required_deflection_deg"] is None
    assert answer["verdict"]["sufficient"] is None
    assert set(answer["verdict"]["requirements_deg"].values()) == {None}
    assert set(answer["minimum_deg"].values()) == {None}
    for value in answer["boundaries"].values():
        assert set(value["deflection_deg"]) == {None}


@pytest.mark.thorough
def test_at_30_degrees_itself_linear_theory_still_answers() -> None:
    assert study(30.0, limit=np.radians(12.0)).sufficient is True
    assert study(30.0001, limit=np.radians(12.0)).sufficient is None


def test_the_pure_functions_say_where_they_leave_the_linear_range() -> None:
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")
    wide = tv.TriangularWind(peak=-np.radians(60.0), duration=7.5)
    with pytest.warns(UserWarning, match=SENTENCE):
        assert tv.is_sufficient(plant, wide, np.radians(12.0)) is True
    assert np.degrees(tv.survivable_peak(plant, wide, np.radians(12.0))) == pytest.approx(-30.0)


def test_no_deflection_is_enough_in_a_box_that_reaches_beyond_the_range() -> None:
    options = ("--box", "wind_peak_deg=5..31", "--json")
    _, said = run("design", "configuration-i", *options)
    worst = json.loads(said)["box"]["required_deflection_rad"]
    assert worst["value"] is None
    assert np.degrees(worst["at"]["wind_peak"]) == pytest.approx(31.0)


@by_turns(
    "deg,command",
    [10.0, 10.1],
    ["study", "respond", "nozzle", "fly", "boundary", "ascent"],
    each=7,
)
def test_above_ten_degrees_each_answer_has_the_doubt(command, deg) -> None:
    times = ("--from", "66", "--to", "66") if command == "ascent" else ()
    _, said = run(command, "configuration-i", "--peak-deg", str(deg), *times)
    assert (DOUBTFUL in said) is (deg > 10.0)


def test_dispersed_winds_beyond_the_range_count_as_not_covered() -> None:
    """Peaks of 28 deg, spread by a tenth: those above 30 are as many as the normal law says."""
    nominal = study(28.0, limit=np.radians(80.0), sign="frozen")
    spread = tv.ensembles.Dispersion("wind_peak", "normal", 0.1, relative=True)
    result = tv.ensembles.disperse_study(nominal, tv.ensembles.Dispersions((spread,)), cases=400)
    beyond = result.values["wind_peak"] > np.radians(30.0)
    assert 0.15 < beyond.mean() < 0.35  # 0.238 +- 0.021
    assert np.array_equal(np.isinf(result.deflection), beyond)
    assert result.success.estimate == pytest.approx(1.0 - beyond.mean(), rel=1e-12)
    assert BEYOND_LINEAR in result.spreads
