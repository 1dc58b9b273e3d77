"""Study files: one file for studies and campaigns, and one sentence for what it should not say."""

import json
import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import tvclin as tv
from tests.studies import FLIGHT
from tvclin.base.units import UNITS
from tvclin.cli.app import app
from tvclin.requirement.flight.request import SoundingRequest
from tvclin.studyfile.campaign_file import TABLES, differing_vehicle, parse_campaign
from tvclin.studyfile.parse import parse_study
from tvclin.studyfile.read import example
from tvclin.vehicle.vehicle_file import read_vehicle_text

HEAD = {"vehicle": "configuration-i"}
WIND = {"peak_deg": 5.0, "duration_s": 7.5}

SOUNDINGS = Path(__file__).parents[1] / "soundings"
SOUNDING = {"sounding": str(SOUNDINGS / "wyoming.txt"), "azimuth_deg": 90}


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def plan(**tables: object) -> tv.studyfile.StudyPlan:
    return parse_study({"study": HEAD, "wind": WIND} | tables)


def test_a_study_names_the_sign_that_counts() -> None:
    for sign in ("head", "tail", "frozen"):
        assert parse_study({"study": HEAD | {"sign": sign}, "wind": WIND}).sign == sign


def test_the_example_says_what_its_keys_say() -> None:
    result = parse_study(tomllib.loads(example()))

    assert result.vehicle == tv.load_vehicle("configuration-i")
    assert result.wind == tv.ShapedWind("triangular", peak=np.radians(5), duration=7.5)
    assert result.nozzle.limit == pytest.approx(np.radians(0.4), rel=1e-15)
    assert result.criteria is tv.CRITERIA["classic"]
    assert (result.laws.sample_rate, result.design.design) == (50.0, "canonical")
    assert len(result.dispersions.distributions) == 5
    sizing = result.sizing
    assert sizing.schedule.at(66.0) == tv.load_schedule("configuration-i").at(66.0)
    assert (sizing.pulses(result), sizing.every) == ((result.wind,), 10.0)
    assert sizing.dead_bands == (1.0, 0.5)
    assert (sizing.dispersion, sizing.gravity_offset, sizing.reserve) == (0.2, 0.02, 0.1)


FLIGHT_TABLES = """
[[wind]]
peak_deg = 5.0
duration_s = 7.5
[[wind]]
sounding = "balloon.txt"
azimuth_deg = 90
name = "15 February"
[sounding]
window_s = 30.0
[gust]
peak_deg = 1.0
duration_s = 2.0
peak_time_s = 3.75
[schedule]
source = "configuration-i"
[size]
from_s = 50.0
to_s = 90.0
every_s = 5.0
dead_bands = [1.0, 0.5]
law = "bound"
varying = true
peak_speed_m_per_s = 60.0
count = "K = 1"
dispersion_percent = 20.0
thrust_offset_deg = 0.1
gravity_offset_m = 0.02
reserve_percent = 10.0
"""
"""Tables of a study of a flight, in two winds and a gust."""


def test_the_page_shows_a_study() -> None:
    page = (Path(__file__).parents[2] / "docs" / "report.md").read_text()
    (text,) = re.findall(r"```toml\n(.*?)```", page, flags=re.DOTALL)
    result = parse_study(tomllib.loads(text))

    assert (result.model, result.dead_band, result.design.delay) == ("drift", 0.5, 0.02)
    assert result.laws.winds == ("triangle", "1 - cosine")


def test_a_study_of_a_flight_has_its_winds_and_times(tmp_path: Path) -> None:
    (tmp_path / "balloon.txt").write_text((SOUNDINGS / "wyoming.txt").read_text())
    tables = tomllib.loads(FLIGHT_TABLES)
    result = parse_study({"study": HEAD} | tables, tmp_path)
    request = result.sizing

    assert list(request.winds(result)) == [
        "triangular wind of 60 m/s, 7.5 s, gust of 1 deg, 2 s",
        "15 February, gust of 1 deg, 2 s",
    ]
    assert (result.wind.gust.end, result.wind.gust_at, request.window) == (2.0, 3.75, 30.0)
    assert request.times(result).tolist() == [50.0, 55.0, 60.0, 65.0, 70.0, 75.0, 80.0, 85.0, 90.0]


def test_one_file_drives_the_study_and_the_campaign(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    assert run("init", "--study", file).exit_code == 0
    study, campaign = tv.load_study(file), tv.studyfile.load_campaign(file)
    assert study.sizing is None  # no flight of another vehicle is in force
    named = file.read_text().replace("# [schedule]", "[schedule]").replace("# source =", "source =")
    file.write_text(named.replace("# [size]", "[size]"))
    assert tv.load_study(file).sizing.source == "configuration-i"

    for name in ("vehicle", "model", "plane", "wind", "nozzle", "dispersions", "cases", "seed"):
        assert getattr(study, name) == getattr(campaign, name), name


@pytest.mark.thorough
def test_one_file_drives_the_sizing_of_a_flight(tmp_path: Path) -> None:
    file, sounding = tmp_path / "my.toml", tmp_path / "wyoming.txt"
    file.write_text(FLIGHT)
    sounding.write_text((SOUNDINGS / "wyoming.txt").read_text())
    options = ["--peak-deg", 4, "--winds", sounding, "--azimuth-deg", 90, "--model", "drift"]
    options += [
        "--set",
        "gust.peak_deg=1",
        "--set",
        "gust.duration_s=2",
        "--from",
        70,
        "--to",
        90,
        "--every",
        20,
    ]
    budget = ("dispersion_percent=20", "thrust_offset_deg=0.1", "gravity_offset_m=0.02")
    keys = [f"size.{key}" for key in (*budget, "reserve_percent=10")]
    options += [w for key in (*keys, "sounding.window_s=16") for w in ("--set", key)]
    options += ["--dead-band", 1, "--varying", "--limit-deg", 0.6]
    by_file = run("ascent", file, "--json")
    by_options = run("ascent", "configuration-ii", *options, "--json")
    one, other = json.loads(by_file.stdout), json.loads(by_options.stdout)

    said, other_said = one.pop("notes"), other.pop("notes")
    doubt = next(note for note in said if note.startswith("the flight is of configuration-ii"))
    said.remove(doubt)
    assert said[:-5] == other_said[:-6]
    assert one == other
    assert by_file.exit_code == by_options.exit_code
    assert one["times_s"] == [70.0, 90.0]
    assert one["winds"] == [
        "triangular wind of 4 deg, 7.5 s, gust of 1 deg, 2 s",
        "wyoming.txt, gust of 1 deg, 2 s",
    ]
    wider = json.loads(run("ascent", file, "--every", 50, "--plane", "yaw", "--json").stdout)
    assert (wider["times_s"], wider["plane"]) == ([70.0, 90.0], "yaw")


@pytest.mark.thorough
def test_the_same_file_drives_the_study_and_its_gust_has_a_time_only_where_that_is_given(
    tmp_path: Path,
) -> None:
    file = tmp_path / "my.toml"
    file.write_text(FLIGHT)
    (tmp_path / "wyoming.txt").write_text((SOUNDINGS / "wyoming.txt").read_text())
    options = ["--peak-deg", 4, "--gust", 1, 2, "--limit-deg", 0.6, "--model", "drift"]
    by_options = run("study", "configuration-i", *options, "--json")

    by_file, by_options = (
        json.loads(one.stdout) for one in (run("study", file, "--json"), by_options)
    )
    assert [one["name"] for one in by_file.pop("questions")] == ["wind", "whole flight"]
    assert by_options.pop("questions")[0]["yes"] is by_options.pop("all_answers_yes")
    by_file.pop("all_answers_yes")
    doubt = "the flight is of configuration-ii, not of the study's vehicle"
    of_flight = [note for note in by_file["notes"] if note not in by_options["notes"]]
    assert [note.startswith(doubt) for note in of_flight] == [True]
    by_file["notes"].remove(of_flight[0])
    assert by_file == by_options
    late = plan(gust={"peak_deg": 1, "duration_s": 2, "peak_time_s": 6.0}).wind
    assert (late.placed_gust.onset, late.placed_gust.end) == (5.0, 7.0)
    drawn = parse_campaign(tomllib.loads(FLIGHT) | {"campaign": {"cases": 3}}, tmp_path)
    gust = drawn.wind.placed_gust
    placed = by_file["gust"]["begins_s"], by_file["gust"]["ends_s"]
    assert (gust.onset, gust.end) == pytest.approx(placed)


def test_a_flight_of_the_file_itself_and_of_its_vehicle(tmp_path: Path) -> None:
    rows = tv.load_schedule("configuration-i", start=60.0, stop=70.0, step=5.0)
    v = rows.vehicle
    table = {
        "time_s": rows.times.tolist(),
        "weight_N": v.weight.tolist(),
        "normal_force_slope_N_per_rad": v.normal_force_slope.tolist(),
        "axial_force_N": v.axial_force.tolist(),
        "velocity_m_per_s": v.velocity.tolist(),
        "attitude_rad": v.attitude.tolist(),
        "moment_of_inertia_kg_m2": v.moment_of_inertia,
        "thrust_N": v.thrust,
        "aerodynamic_arm_m": v.aerodynamic_arm,
        "control_arm_m": v.control_arm,
    }
    given, own = plan(schedule=table).sizing.schedule, plan(size={}).sizing.schedule

    assert given.at(62.0) == rows.at(62.0).replace(name=given.vehicle.name)
    assert own.at(66.0) == tv.load_schedule("configuration-i").at(66.0)
    assert plan().sizing is None
    file = tmp_path / "none.toml"
    file.write_text(re.sub(r"(?s)# The whole flight.*?(?=# Many)", "", example()))
    found = tv.studyfile.load_sizing(file).sizing  # the flight of its vehicle, as with [size]
    assert found.schedule.at(66.0) == own.at(66.0)
    for command in (("ascent", file), ("nozzle", file, "--over", "flight", "--to", "50")):
        assert run(*command).exit_code < 2, command
    numbers = tmp_path / "numbers.toml"
    text = read_vehicle_text("configuration-i")[0].replace("[vehicle]", "[study.vehicle]")
    numbers.write_text(text.partition("[flight]")[0] + "[wind]\npeak_deg = 5\nduration_s = 5\n")
    assert "has no flight; add [schedule]" in run("ascent", numbers).output


def test_a_campaign_file_is_a_study_file() -> None:
    tables = {"campaign": HEAD | {"cases": 10, "model": "drift"}, "wind": WIND}

    assert parse_study(tables).model == parse_campaign(tables).model == "drift"


def test_the_three_ways_to_name_a_vehicle_are_the_same(tmp_path: Path) -> None:
    text = (Path(tv.__file__).parent / "vehicle/shipped" / "configuration-ii.toml").read_text()
    (tmp_path / "mine.toml").write_text(text)
    table = tomllib.loads(text)["vehicle"]
    wind = "[wind]\npeak_deg = 5\nduration_s = 7.5\n"
    (tmp_path / "study.toml").write_text('[study]\nvehicle = "mine.toml"\n' + wind)

    named = plan(study={"vehicle": "configuration-ii"})
    assert named == plan(study={"vehicle": table}) == tv.load_study(tmp_path / "study.toml")


def test_a_vehicle_alone_is_a_plan_with_nothing_else(tmp_path: Path) -> None:
    bare = tv.load_study("configuration-i")

    assert bare == tv.studyfile.StudyPlan(vehicle=tv.load_vehicle("configuration-i"))


def test_the_study_of_a_file_is_that_of_its_options(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(
        '[study]\nvehicle = "configuration-ii"\nmodel = "drift"\nplane = "yaw"\ndead_band = 0.6\n'
        '[wind]\nshape = "rectangular"\npeak_deg = 3\nduration_s = 6\n[nozzle]\nlimit_deg = 0.3\n'
    )
    options = ["--model", "drift", "--plane", "yaw", "--dead-band", "0.6", "--peak-deg", "3"]
    options += ["--wind", "rectangular", "--duration", "6", "--limit-deg", "0.3"]
    by_file = run("study", file, "--json")
    by_options = run("study", "configuration-ii", *options, "--json")

    assert json.loads(by_file.stdout) == json.loads(by_options.stdout)
    assert by_file.exit_code == by_options.exit_code


@pytest.mark.thorough
def test_an_option_counts_more_than_the_file(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(example())
    answer = json.loads(run("study", file, "--duration", "9", "--plane", "yaw", "--json").stdout)
    kept = tv.load_study(file)
    expected = replace(kept, plane="yaw", wind=replace(kept.wind, duration=9.0)).study()

    assert answer["plane"] == "yaw"
    assert answer["verdict"]["required_deflection_deg"] == pytest.approx(
        np.degrees(expected.required_deflection), rel=1e-15
    )


def test_gains_and_criteria_of_ones_own() -> None:
    own = {"attitude_gain": 0.3, "rate_gain_s": 0.4, "delay_ms": 20}
    wanted = {"name": "aircraft", "delay_margin_ms": 50.0}
    result = plan(autopilot=own, criteria=wanted)
    plant = tv.Plant.from_vehicle(result.vehicle, "fixed-path")
    autopilot = result.design.autopilot(plant)

    assert (autopilot.attitude_gain, autopilot.rate_gain, autopilot.delay) == (0.3, 0.4, 0.02)
    limits = {limit.margin: limit.limit for limit in result.criteria.limits}
    assert (limits["phase_margin_deg"], limits["delay_margin"]) == (45.0, 0.05)
    by_rule = plan(autopilot={"design": "poles", "natural_frequency_rad_per_s": 2.0})
    expected = tv.design_gains(plant.coefficients, natural_frequency=2.0, damping=0.7)
    assert by_rule.design.autopilot(plant).attitude_gain == expected.attitude_gain


LIMITS = {
    "phase_margin_deg": 35.0,
    "gain_increase_dB": 3.0,
    "delay_margin": 0.05,
    "disk_margin": 0.4,
    "peak_sensitivity": 2.0,
}


@pytest.mark.parametrize("name", [None, "classic", "aircraft"])
@pytest.mark.parametrize("margin", LIMITS)
def test_a_single_criterion_leaves_the_others_of_its_standard_set(margin, name) -> None:
    """Gains that miss the others are not judged by the one alone; without a name it is classic."""
    standard = tv.CRITERIA[name or "classic"]
    key, number = margin, LIMITS[margin]
    if margin == "delay_margin":
        key, number = "delay_margin_ms", 50.0
    named = {} if name is None else {"name": name}
    criteria = plan(criteria=named | {key: number}).margin_criteria

    limits = {limit.margin: limit.limit for limit in criteria.limits}
    assert limits == {limit.margin: limit.limit for limit in standard.limits} | {
        margin: LIMITS[margin]
    }
    assert criteria.name.startswith(f"{standard.name}, with {margin.split('_')[0]} ")
    assert plan(criteria=named).margin_criteria == standard


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"studdy": {}}, "unknown table: 'studdy'; did you mean study?"),
        ({"study": HEAD | {"dead_bnd": 1.0}}, "'dead_bnd'; did you mean dead_band?"),
        ({"study": HEAD | {"model": "drifty"}}, "model must be one of .*'drift'"),
        ({"study": HEAD | {"dead_band": 2.0}}, "dead_band must be between 0 and 1"),
        ({"study": {}}, r"a key is missing in \[study\]: vehicle, as vehicle = "),
        ({"study": {"vehicle": "configuration-3"}}, "did you mean 'configuration-i"),
        ({"study": {"vehicle": "none.toml"}}, "none.toml does not exist"),
        ({"study": {"vehicle": "a\x1b[31m.toml"}}, "vehicle must be a name or a path"),
        ({"study": {"vehicle": "a\0b"}}, "vehicle must be a name or a path"),
        ({"study": {"vehicle": {"name": "a\x1b[31m"}}}, "key is missing .*: weight_N"),
        ({"study": {"vehicle": {"weigth_N": 1.0}}}, "in .study.vehicle.: 'weigth_N'; did you mean"),
        ({"campaign": {"cases": 5, "model": "drift"}, "study": HEAD | {"model": "drift"}}, "keep"),
        ({"campaign": {"cases": 0}}, "cases must be from 1"),
        ({"question": {"limit_deg": 0.4}}, r"limit_deg stands in \[nozzle\], not in \[question\]"),
        (
            {"size": {"model": "drift"}},
            r"model stands in \[study\] or \[campaign\], not in \[size\]",
        ),
        ({"nozzle": {"limt_deg": 0.4}}, r"'limt_deg'; did you mean limit_deg or limit_rad\?"),
        ({"nozzle": {"limit": 0.4}}, "limit has no known unit .* write limit_rad or limit_deg"),
        ({"study": {"vehicle": {"weight": 1.0}}}, "weight has no known unit .*; write weight_N or"),
        ({"nozzle": {"limit_deg": -0.4}}, r"limit_deg in \[nozzle\] must be positive"),
        ({"laws": {"names": ["trimm"]}}, r"\[laws\]: names must be one of .*'trim'"),
        ({"laws": {"names": "trim"}}, r"names in \[laws\] must be a list"),
        (
            {"laws": {"winds": []}},
            r"\[laws\]: winds must be a tuple of one or more different values",
        ),
        ({"laws": {"sample_rate": 50}}, "sample_rate has no known unit .* write sample_rate_Hz"),
        ({"laws": {"sample_rate_Hz": 0}}, r"sample_rate_Hz in \[laws\] must be positive"),
        ({"autopilot": {"desing": "lqr"}}, "'desing'; did you mean design"),
        ({"autopilot": {"design": "guess"}}, "design must be one of canonical"),
        ({"autopilot": {"delay_ms": -1}}, r"delay_ms in \[autopilot\] must be zero or positive"),
        ({"autopilot": {"delay_ms": 1, "delay_s": 1}}, "delay is given twice .* keep one"),
        ({"criteria": {"name": "clasic"}}, "name in .criteria. must be one of .*'classic'"),
        ({"dispersion": [{"parameter": "thurst"}]}, "did you mean 'thrust'"),
        (
            {"dispersion": [{"parameter": "wind_peak", "spread": 1.0}]},
            "spread has no known unit .* of wind_peak; write spread_rad or spread_deg",
        ),
        ({"laws": 3}, r"\[laws\] must be a table"),
        ({"wind": 3}, r"wind must be a table \[wind\], or \[\[wind\]\]"),
        ({"wind": [WIND, 3]}, r"wind must be a table \[wind\], or \[\[wind\]\]"),
        (
            {"wind": [SOUNDING], "schedule": {}},
            "a study needs a wind of one shape.*; tvclin fly or tvclin boundary",
        ),
        ({"wind": [WIND, SOUNDING]}, r"a sounding needs a flight: add \[schedule\]"),
        ({"wind": [WIND, {"soundng": "a"}]}, "'soundng'; did you mean sounding"),
        (
            {"wind": [WIND, SOUNDING | {"azimut_deg": 3}], "schedule": {}},
            "'azimut_deg'; did you mean azimuth",
        ),
        (
            {"wind": [WIND, {"sounding": "a"}], "schedule": {}},
            "a key is missing .*: azimuth_rad or",
        ),
        ({"wind": [WIND, SOUNDING | {"sounding": 3}], "schedule": {}}, "must be a path; got 3"),
        ({"wind": [WIND, SOUNDING | {"time": 3}], "schedule": {}}, "time in .* must be a text"),
        ({"wind": [WIND, SOUNDING | {"format": "x"}], "schedule": {}}, "format must be one of"),
        ({"wind": [WIND, SOUNDING, SOUNDING], "schedule": {}}, "two soundings have one name"),
        ({"gust": 3}, r"\[gust\] must be a table"),
        ({"gust": {"peak_deg": 1, "duratoin_s": 2}}, "'duratoin_s'; did you mean duration_s"),
        ({"gust": {"peak_deg": 1}}, "a key is missing .*: duration_s"),
        ({"gust": {"peak_deg": 0, "duration_s": 2}}, "peak must be other than zero"),
        ({"nozzle": {"actuator_damping": -1}}, "actuator_damping must be positive"),
        ({"shedule": {}}, "unknown table: 'shedule'; did you mean schedule"),
        ({"schedule": {"sorce": "a"}}, "'sorce'; did you mean source"),
        ({"schedule": {"source": 3}}, "needs a source"),
        ({"schedule": {"source": "none.csv"}}, "none.csv does not exist"),
        ({"schedule": {"time_s": 3}}, "needs time_s, a list"),
        ({"schedule": {"source": "a", "time_s": [1, 2]}}, "a source, and the flight itself"),
        ({"schedule": {"time_s": [1, 2]}}, "a key is missing .*: weight_N"),
        ({"schedule": {"thrust_N": [1, 2]}}, "needs time_s, a list"),
        ({"size": {"evry_s": 1}}, "'evry_s'; did you mean every_s"),
        ({"size": {"every_s": 0}}, r"every_s in \[size\] must be positive"),
        ({"size": {"dead_bands": 1}}, r"dead_bands in \[size\] must be a list"),
        ({"size": {"dead_bands": [2]}}, "dead_bands must be between 0 and 1"),
        ({"size": {"varying": 1}}, "must be true or false"),
        (
            {"size": {"reserve_percent": -1}},
            r"reserve_percent in \[size\] must be zero or positive",
        ),
    ],
)
def test_what_a_study_file_should_not_say_is_one_sentence(
    tables: dict[str, object], message: str
) -> None:
    with pytest.raises(tv.InputError, match=message) as caught:
        plan(**tables).study()
    lines = str(caught.value).split("\n")
    assert len(lines) == 1 or all("a key is missing" in line for line in lines)
    assert all(line.isprintable() for line in lines)


@pytest.mark.parametrize(
    ("heading", "wrong", "right"),
    [
        ("study", "swich", "switch"),
        ("laws", "sample_rat_Hz", "sample_rate_Hz"),
        ("autopilot", "dmaping", "damping"),
        ("criteria", "phase_margn_deg", "phase_margin_deg"),
        ("size", "resrve_percent", "reserve_percent"),
    ],
)
def test_a_campaign_finds_misspelled_keys_of_a_study(heading: str, wrong: str, right: str) -> None:
    tables = {"study": HEAD, "wind": WIND, "campaign": {"cases": 3}}
    tables[heading] = tables.get(heading, {}) | {wrong: 1.0}
    for parse in (parse_campaign, parse_study):
        with pytest.raises(tv.InputError, match=rf"\[{heading}\]: '{wrong}'; did you mean {right}"):
            parse(tables)


def test_no_number_that_has_a_unit_goes_without_it() -> None:
    """Its bare name is refused, and what is offered in its place has the unit."""
    for table in (table for table in TABLES if table.heading != "[[dispersion]]"):
        for name in (name for name, kind in table.quantities.items() if "" not in UNITS[kind]):
            tables = {"study": HEAD, "wind": WIND, "campaign": {"cases": 1}}
            tables[table.name] = tables.get(table.name, {}) | {name: 1.0}
            with pytest.raises(tv.InputError, match=f"{name} has no known unit .*write {name}_"):
                parse_study(tables)


def test_whose_the_flight_is(tmp_path: Path) -> None:
    """Only another vehicle is doubtful, not the study's own by any path, nor tables of times."""
    text = (Path(tv.__file__).parent / "vehicle/shipped" / "configuration-i.toml").read_text()
    (tmp_path / "my.toml").write_text(text)
    table = tomllib.loads(text)["vehicle"]
    rows = {key: [value] * 2 for key, value in table.items() if not isinstance(value, str)}
    rows["time_s"] = [41, 116]
    lines = (",".join(map(str, line)) for line in (rows, *zip(*rows.values(), strict=True)))
    (tmp_path / "flight.csv").write_text("\n".join(lines))
    for vehicle, schedule, source, another in (
        ("my.toml", {}, "my.toml", ""),
        ("my.toml", {"source": "./my.toml"}, "./my.toml", ""),
        ("my.toml", {"source": "flight.csv"}, "flight.csv", ""),
        (table, rows, "the lists in [schedule]", ""),
        ("my.toml", {"source": "configuration-i"}, "configuration-i", "my.toml"),
        (table, {"source": "my.toml"}, "my.toml", table["name"]),
        ({**table, "name": ""}, {"source": "my.toml"}, "my.toml", "given by its numbers"),
    ):
        tables = {"study": {"vehicle": vehicle}, "wind": WIND, "schedule": schedule}
        computed = parse_study(tables, tmp_path).sizing
        assert (computed.source, computed.another) == (source, another)
        assert len(computed.warnings) == bool(another)


def test_a_sizing_without_a_wind_or_a_dead_band_is_refused() -> None:
    schedule = tv.load_schedule("configuration-i")
    low = tv.WindProfile(height=[0.0, 100.0], east=[5.0, 5.0], north=[0.0, 0.0])
    for given, said in (
        ({"pulse": False}, "a sizing needs a wind: a pulse or a sounding"),
        ({"dead_bands": ()}, "dead_bands must hold one number or more"),
        (
            {"soundings": {"low": SoundingRequest(low, 0.0)}},
            "low: the flight does not reach the wind",
        ),
    ):
        with pytest.raises(tv.InputError, match=said):
            tv.requirement.SizingRequest(schedule=schedule, **given).sizing(plan())


def test_a_wind_speed_is_met_across_the_path_in_yaw() -> None:
    request = tv.requirement.SizingRequest(
        schedule=tv.load_schedule("configuration-i"), peak_speed=60.0
    )
    for plane in ("pitch", "yaw"):
        case = replace(plan(), plane=plane)
        encountered = request.at(case, 66.0, case.wind)
        meets = 60.0 * (np.sin(encountered.vehicle.attitude) if plane == "pitch" else 1.0)
        across = np.sin(encountered.history.peak) * encountered.vehicle.velocity
        assert across == pytest.approx(meets, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("# vehicle\n", r"neither a vehicle file \(it has no \[vehicle\]\) nor a study"),
        ("[wind]\npeak_deg = 5\nduration_s = 7.5\n", r"\[study\] or \[campaign\] is missing"),
        ('[campaign]\nvehicle = "configuration-i"\ncases = 3\n', r"\[wind\] is missing"),
    ],
)
@pytest.mark.parametrize(
    "load", [tv.load_study, tv.studyfile.load_sizing, tv.studyfile.load_campaign]
)
def test_a_table_that_is_missing_is_named(
    tmp_path: Path, load: Callable[[Path], object], text: str, message: str
) -> None:
    file = tmp_path / "part.toml"
    file.write_text(text)
    with pytest.raises(tv.InputError, match=rf"part\.toml: .*{message}"):
        load(file)


@pytest.mark.parametrize("load", [tv.load_study, tv.studyfile.load_sizing])
def test_a_file_that_is_no_toml_is_refused(tmp_path: Path, load: Callable[[Path], object]) -> None:
    file = tmp_path / "half.toml"
    file.write_text("[study\n")
    with pytest.raises(tv.InputError, match=r"half\.toml is not valid TOML"):
        load(file)


def test_a_name_with_control_characters_is_refused() -> None:
    text = (Path(tv.__file__).parent / "vehicle/shipped" / "configuration-i.toml").read_text()
    table = tomllib.loads(text)["vehicle"] | {"name": "a\x1b[31m"}
    with pytest.raises(tv.InputError, match="printable"):
        plan(study={"vehicle": table})


def test_the_command_line_refuses_a_bad_study_file(tmp_path: Path) -> None:
    file = tmp_path / "bad.toml"
    file.write_text(re.sub("dead_band", "dead_bant", example()))
    for command in ("study", "poles"):
        result = run(command, file)
        assert result.exit_code == 2
        assert isinstance(result.exception, SystemExit)
    assert "did you mean dead_band" in run("study", file).stderr
    said = run("disperse", file, "-o", tmp_path / "results")
    assert said.exit_code == 2
    assert "did you mean dead_band" in said.stderr
    assert run("init", "--study", file).exit_code == 2


@pytest.mark.thorough
def test_the_limit_of_an_option_counts_for_the_whole_flight_too(tmp_path: Path) -> None:
    path = tmp_path / "s.toml"
    path.write_text(
        '[study]\nvehicle = "configuration-i"\nmodel = "fixed-path"\n'
        "[wind]\npeak_deg = 5\nduration_s = 7.5\n"
        '[schedule]\nsource = "configuration-i"\n[size]\nevery_s = 60\n[nozzle]\nlimit_deg = 0.01\n'
    )
    for options, answer in (((), False), (("--limit-deg", 3), True)):
        request = json.loads(run("study", path, *options, "--json").stdout)["questions"]
        assert {one["name"]: one["yes"] for one in request} == {
            "wind": answer,
            "whole flight": answer,
        }


def test_all_faults_of_a_file_are_told_at_once_a_line_for_each(tmp_path: Path) -> None:
    path = tmp_path / "s.toml"
    path.write_text(
        '[study]\nvehicle = "configuration-ii"\ndead_bnd = [1.0]\n'
        '[wind]\nshape = "triangular"\npeak_dg = 5\nduration_s = 7\n'
        '[gust]\npeak_deg = "x"\ndurat_s = 2\n[sutdy]\na = 1\n'
        '[[dispersion]]\nparameter = "thrust"\npercnt = 3\n'
        '[[dispersion]]\nparameter = "weight"\nprcent = 3\n'
    )
    said = (
        "unknown table: 'sutdy'; did you mean study?",
        "unknown key in [study]: 'dead_bnd'; did you mean dead_band?",
        "peak_deg must be a number; got 'x'",
        "unknown key in [gust]: 'durat_s'; did you mean duration_s or plateau_s?",
        "peak_dg has no known unit in [wind]; write peak_rad or peak_deg",
        "unknown key in [[dispersion]] of thrust: 'percnt'; did you mean percent or part?",
        "unknown key in [[dispersion]] of weight: 'prcent'; did you mean percent or part?",
    )
    result = CliRunner().invoke(app, ["study", str(path)])
    assert result.exit_code == 2
    lines = result.stderr.removeprefix("Error: ").splitlines()
    assert lines == [f"{path}: {line}" for line in said]
    assert result.stdout == ""
    with pytest.raises(tv.InputError) as error:
        tv.studyfile.load_campaign(path)
    assert str(error.value).split("\n") == lines


def test_a_wind_is_given_by_its_speed_as_the_vehicle_meets_it_by_b1e() -> None:
    booster = tv.load_vehicle("configuration-i")
    result = plan(wind={"peak_speed_m_per_s": 40.0, "duration_s": 7.5}, size={"every_s": 25})
    sine = 40.0 * np.sin(booster.attitude) / booster.velocity
    assert np.sin(result.wind.peak) == pytest.approx(sine, rel=1e-14)
    assert result.sizing.peak_speed == 40.0  # of each flight time its own angle
    yaw = plan(study=HEAD | {"plane": "yaw"}, wind={"peak_speed_m_per_s": 40, "duration_s": 7.5})
    assert np.sin(yaw.wind.peak) == pytest.approx(40.0 / booster.velocity, rel=1e-14)


@pytest.mark.parametrize("peak", [{"peak_deg": 5.0}, {"peak_speed_m_per_s": 40.0}])
def test_a_gust_alone_is_a_wind_of_its_shape(peak: dict[str, float]) -> None:
    gust = peak | {"duration_s": 7.5}
    result = parse_study({"study": HEAD, "gust": gust, "size": {"every_s": 25}})
    wind = {"shape": "one-minus-cosine", **gust}
    assert (result.wind, result.wind.gust) == (plan(wind=wind).wind, None)
    assert result.sizing.peak_speed == peak.get("peak_speed_m_per_s")
    assert result.sizing.gust_speed is None
    campaign = {"vehicle": "configuration-i", "cases": 10}
    assert parse_campaign({"campaign": campaign, "gust": gust}).wind == replace(result.wind)


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ({"wind": {"duration_s": 7}}, r"\[wind\] needs its peak: peak_deg, or peak_speed_m_per_s"),
        ({"wind": WIND | {"peak_speed_kt": 60}}, "needs its peak.*keep one"),
        ({"wind": [WIND, WIND | {"peak_speed_kt": 60}]}, "in the first .* alone"),
        (
            {"wind": [{"peak_speed_kt": 60, "duration_s": 7}, WIND], "size": {"every_s": 25}},
            "all pulses have one speed",
        ),
        ({"gust": WIND | {"plateau_s": 1}}, r"plateau_s of a \[gust\] needs a \[wind\]"),
        ({"gust": WIND | {"peak_time_s": 1}}, r"peak_time_s of a \[gust\] needs a \[wind\]"),
    ],
)
def test_a_peak_that_is_not_clear_is_refused(tables: dict[str, object], said: str) -> None:
    with pytest.raises(tv.InputError, match=said):
        parse_study({"study": HEAD} | tables)


def test_a_boundary_in_one_minus_cosine_is_that_of_its_samples() -> None:
    """Straight lines between n samples are off by (pi/n)^2/2 of the peak at most."""
    case = plan(wind=WIND | {"shape": "one-minus-cosine"})
    time = np.linspace(0.0, 7.5, 401)
    angle = 0.5 * np.radians(5.0) * (1.0 - np.cos(2.0 * np.pi * time / 7.5))
    plant = case.plant
    sampled = tv.boundary_limit(plant, tv.SampledWind(time=time, angle=angle), 1.0)
    shape = tv.boundary_limit(plant, case.history, 1.0)
    assert float(shape.limit) == pytest.approx(float(sampled.limit), rel=1e-4)
    result = run("study", "configuration-i", "--wind", "one-minus-cosine")
    assert "one-minus-cosine wind of 5 deg and 7.5 s" in result.output


@pytest.mark.thorough
@pytest.mark.parametrize(("name", "factor"), [("normal_force_slope", 1.1), ("velocity", 0.9)])
def test_a_vehicle_that_its_flight_contradicts_is_noted(tmp_path, name, factor) -> None:
    """The number is named; differences of a few percent, as of tables, have no note."""
    flight = tv.load_schedule("configuration-i")
    study = tmp_path / "s.toml"
    study.write_text(
        '[study]\nvehicle = "configuration-i"\n[wind]\npeak_deg = 5\nduration_s = 7.5\n'
        '[schedule]\nsource = "flight.csv"\n',
        encoding="utf-8",
    )
    warnings = {}
    for ratio in (1.0, 1.0 + 0.3 * (factor - 1.0), factor):
        changed = flight.vehicle.replace(**{name: ratio * getattr(flight.vehicle, name)})
        replace(flight, vehicle=changed).to_csv(tmp_path / "flight.csv")
        warnings[ratio] = tv.studyfile.load_study(study).sizing.warnings
    assert list(map(len, warnings.values())) == [0, 0, 1]
    at_zero = flight.vehicle.replace(time=flight.times - flight.times[0])
    first = replace(flight, vehicle=at_zero).at(0.0).replace(velocity=0.5 * flight.speed[0])
    assert "(velocity " in differing_vehicle(first, replace(flight, vehicle=at_zero))
    number = {"normal_force_slope": "mu_alpha", "velocity": "velocity"}[name]
    assert f" ({number} " in warnings[factor][0]
    assert "in the flight" in warnings[factor][0]
