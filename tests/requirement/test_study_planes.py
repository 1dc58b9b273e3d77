"""Studies of a wind with a direction: of one plane with a note, or judged in both."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import tvclin as tv
from tvclin.boundary.limit_shapes import CircularShape, PolygonShape
from tvclin.cli.app import app
from tvclin.requirement.plane_requirement import omitted_fraction, rectangle
from tvclin.studyfile.findings import Findings, find
from tvclin.studyfile.parse import parse_study
from tvclin.studyfile.questions import questions
from tvclin.studyfile.study_plan import StudyPlan

HEADING = ("--set", "wind.direction_deg=270", "--azimuth-deg", "45")
JET = (*HEADING, "--peak-speed", "50", "--model", "fixed-path")


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, list(arguments))


@pytest.fixture(scope="module")
def booster() -> tv.Vehicle:
    return tv.load_vehicle("configuration-i")


def test_a_wind_from_behind_requires_what_a_tail_wind_does_to_the_last_bit(booster) -> None:
    options = {"duration": 7.5, "peak": 0.08, "limit": 0.006}
    plain = tv.Study.from_vehicle(booster, **options, sign="tail")
    for stop in (None, "round", "square"):
        tail = tv.Study.from_vehicle(booster, **options, heading=np.pi, limit_shape=stop)
        assert tail.required_deflection == plain.required_deflection
        assert tail.survivable_peak == plain.survivable_peak
        assert tail.sufficient is plain.sufficient


def test_the_jet_of_the_page_needs_what_plane_limit_says(booster) -> None:
    """And what a wind speed makes of it in a shell is one horizontal wind."""
    plant, psi = tv.Plant.from_vehicle(booster, "fixed-path"), np.radians(45)
    parts = [
        tv.angle_from_speed(50 * np.cos(psi), booster.velocity, booster.attitude),
        -tv.angle_from_speed(50 * np.sin(psi), booster.velocity, np.pi / 2),
    ]
    pitch, yaw = (tv.TriangularWind(peak=part, duration=7.5) for part in parts)
    for stop, shape in (
        ("round", tv.boundary.CircularShape()),
        ("square", tv.boundary.SquareShape()),
    ):
        exact = tv.plane_limit(plant, tv.winds.PlaneWind(pitch=pitch, yaw=yaw), shape)
        answer = json.loads(
            run("study", *JET, "--sign", "frozen", "--limit-shape", stop, "--json").stdout
        )
        needed = np.radians(answer["verdict"]["required_deflection_deg"])
        assert needed == pytest.approx(exact.deflection, rel=1e-8)
        single = np.radians(answer["planes"]["separate_deg"]["pitch"])
        assert single == pytest.approx(exact.pitch_only, rel=1e-8)


def test_one_plane_says_what_both_would_need_and_both_judge(booster) -> None:
    sufficient = ("--limit-deg", "0.3")
    one, both = (
        run("study", *JET, *sufficient),
        run("study", *JET, *sufficient, "--limit-shape", "round"),
    )
    assert "with a round stop they need 0.339 deg" in " ".join(one.output.split())
    assert "42 % of which the pitch plane alone does not see" in " ".join(one.output.split())
    assert (one.exit_code, both.exit_code) == (0, 1)
    assert "NOT SUFFICIENT" in both.output


@pytest.mark.thorough
@pytest.mark.parametrize("stop", [(), ("--limit-shape", "square")])
def test_a_peak_says_of_what_it_is(stop) -> None:
    """A wind whose vector, or part in the plane, has the peak that is survived needs the limit.

    Its parts are arc sines (B1e): off the straight line by a sixth of the square of the angle.
    """
    arguments = ("study", *HEADING, "--limit-deg", "0.4", *stop)
    shown = " ".join(run(*arguments).output.split())
    whose = (
        "of the wind's vector in both planes" if stop else "of the wind's part in the pitch plane"
    )
    assert whose in shown
    assert "of 2.88 deg and 7.5 s, the part in the pitch plane of a vector of 5 deg" in shown
    answer = json.loads(run(*arguments, "--json").stdout)
    verdict, planes = answer["verdict"], answer["planes"]
    assert verdict["survivable_peak_of"] == whose
    part = 1.0 if stop else planes["peak_deg"] / answer["wind"]["peak_deg"]
    peak = part * verdict["survivable_peak_deg"]
    again = json.loads(run(*arguments, "--peak-deg", str(peak), "--json").stdout)
    needed = again["verdict"]["required_deflection_deg"]
    assert needed == pytest.approx(0.4, rel=np.radians(peak) ** 2 / 6)
    plain = run("study", "--limit-deg", "0.4")
    assert "vector" not in plain.output
    assert "part in" not in plain.output


def test_a_study_keeps_its_direction(booster) -> None:
    gust = tv.OneMinusCosineGust(peak=0.01, duration=2.0).shift(2.0)
    study = tv.Study.from_vehicle(
        booster,
        duration=7.5,
        peak=0.08,
        heading=4.0,
        limit_shape="square",
        gust=gust,
        model="fixed-path",
    )
    again = StudyPlan.of_study(study).study()
    assert again.required_deflection == pytest.approx(study.required_deflection, rel=1e-12)


def test_a_file_gives_the_direction_in_its_wind() -> None:
    wind = {"peak_deg": 5.0, "duration_s": 7.5, "direction_deg": 270.0, "azimuth_deg": 45.0}
    study = {"vehicle": "configuration-i"}
    document = {"study": study, "nozzle": {"limit_shape": "round"}, "wind": wind}
    plan = parse_study(document)
    assert plan.wind.heading == pytest.approx(np.radians(225))
    assert plan.study().planes is not None
    flight = parse_study(document | {"schedule": {"source": "configuration-i"}})
    assert flight.sizing is not None
    assert (flight.planes, flight.nozzle.limit_shape) == ("both", "round")


def test_what_has_no_direction_is_told_so(booster) -> None:
    said = {
        ("--limit-shape", "round"): "a limit of both planes needs a wind with a direction: give"
        " where it blows from, direction_deg in [wind], and",
        ("--azimuth-deg", "9"): "tvclin ascent and tvclin fly also take a sounding, --winds FILE",
        ("--set", "wind.direction_deg=0", "--azimuth-deg", "90"): "has no part in pitch",
        (*JET, "--limit-shape", "oval"): "--limit-shape must be one of round",
    }
    for options, words in said.items():
        result = run("study", *options)
        assert result.exit_code == 2
        assert words in " ".join(result.output.split())
    with pytest.raises(tv.InputError, match="a limit of both planes needs a wind with a direction"):
        tv.Study.from_vehicle(
            booster, duration=7.5, peak=0.08, limit_shape="round", model="fixed-path"
        )
    wind = tv.ShapedWind("triangular", 0.08, 7.5, heading=0.0)
    with pytest.raises(tv.InputError, match="no part in yaw"):
        tv.Campaign(vehicle=booster, wind=wind, plane="yaw", cases=2)


SLANTING = {
    "study": {"vehicle": "configuration-i", "model": "fixed-path", "sign": "frozen"},
    "nozzle": {"limit_shape": "round", "limit_deg": 0.45},
    "wind": {"peak_deg": 5.0, "duration_s": 7.5, "direction_deg": 270.0, "azimuth_deg": 340.0},
}


def findings_of(**more) -> Findings:
    return find(parse_study(SLANTING | more))


def test_dispersed_cases_of_both_planes_need_what_each_vehicle_needs_in_both(booster) -> None:
    part = {"parameter": "thrust", "percent": 1.0}
    computed = findings_of(dispersion=[part], campaign={"cases": 30}).dispersed
    for case in (0, 17, 29):
        plant = tv.Plant.from_vehicle(
            booster.replace(thrust=computed.values["thrust"][case]), "fixed-path"
        )
        gust = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
        exact = tv.plane_limit(plant, tv.winds.PlaneWind.towards(gust, 0.3)).deflection
        assert computed.deflection[case] == pytest.approx(exact, rel=1e-6)


def test_the_autopilot_of_both_planes_is_judged_by_the_vector_of_its_deflections(booster) -> None:
    result = findings_of(autopilot={"design": "canonical"})
    peaks = result.plan.wind.peaks(booster.attitude)
    loop = tv.control.canonical_gains(tv.Coefficients.from_vehicle(booster))
    loop, row = replace(loop, actuator=result.comparison.autopilot.actuator), -1
    plant, times = result.comparison.plant, np.linspace(0.0, 20.0, 4001)
    rows = [
        loop.wind_response(plant, tv.TriangularWind(peak=peak, duration=7.5))(times)[row]
        for peak in peaks.values()
    ]
    most = np.degrees(np.hypot(*rows).max())
    (one,) = (q for q in questions(result) if q.name == "autopilot")
    assert one.yes is False
    assert f"turn the nozzle by {most:.3f}" in one.text
    assert one.text.endswith("in both planes")


@pytest.mark.parametrize("turns", range(4))
def test_a_rectangle_is_inside_every_edge_of_its_stop(turns):
    corners = np.array([1.0, 0.6j, -0.5, -0.8j]) * 1j**turns
    sides = np.stack([corners, np.roll(corners, -1)], axis=-1)
    normals = np.linalg.solve(
        np.stack([sides.real, sides.imag], axis=-1), np.ones((4, 2, 1))
    )  # of edges n . v = 1
    x, y = np.array([0.2, 0.0, 0.3, -0.2]), np.array([0.1, 0.4, 0.0, 0.1])
    expected = (np.abs(normals) * np.abs([x, y])).sum(axis=1).max(axis=0)
    np.testing.assert_allclose(rectangle(PolygonShape(corners), x, y), expected, rtol=1e-14)


def test_where_a_plane_has_no_limit_neither_has_the_rectangle():
    result = rectangle(CircularShape(), [3.0, np.inf, 1.0, np.nan], [4.0, 1.0, np.inf, 1.0])
    np.testing.assert_array_equal(result, [5.0, np.inf, np.inf, np.nan])


def test_one_plane_misses_no_part_of_nothing():
    np.testing.assert_array_equal(
        omitted_fraction([0.0, 3.0, 4.0], [0.0, 4.0, 4.0]), [0.0, 0.25, 0.0]
    )
