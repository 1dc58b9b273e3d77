"""One case, whoever asks: a study file in any command, options over it, and the same in Python."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.turns import usual
from tvclin.case.features import omission_notes
from tvclin.cli.app import app
from tvclin.flights.theory_comparison import fly_sampled
from tvclin.studyfile.findings import find

STUDY = """
[study]
vehicle = "configuration-i"
model = "drift"
plane = "yaw"
dead_band = 0.5
[wind]
shape = "rectangular"
peak_deg = 4.0
duration_s = 5.0
direction_deg = 250
azimuth_deg = 45
[gust]
peak_deg = 0.5
duration_s = 1.0
peak_time_s = 2.5
[nozzle]
limit_deg = 2.0
rate_limit_deg_per_s = 20
actuator_frequency_rad_per_s = 30
[autopilot]
natural_frequency_rad_per_s = 1.2
delay_ms = 10
sample_rate_Hz = 80
[[autopilot.filter]]
kind = "low-pass"
frequency_Hz = 9.0
[criteria]
name = "aircraft"
[laws]
names = ["trim", "autopilot"]
winds = ["triangle"]
"""
CASE = tv.Case(
    vehicle=tv.load_vehicle("configuration-i"),
    model="drift",
    plane="yaw",
    wind=tv.ShapedWind(
        "rectangular",
        np.radians(4.0),
        5.0,
        np.radians(205.0),
        tv.OneMinusCosineGust(peak=np.radians(0.5), duration=1.0),
        2.5,
    ),
    nozzle=tv.Nozzle(
        limit=np.radians(2.0),
        rate_limit=np.radians(20.0),
        actuator=tv.Actuator(natural_frequency=30.0),
    ),
    design=tv.AutopilotDesign(
        natural_frequency=1.2,
        delay=0.01,
        sample_rate=80.0,
        filters=(tv.vehicle.Filter.low_pass(2.0 * np.pi * 9.0),),
    ),
)
VARYING = ("--engine", "planar-varying")
AS_OPTIONS = (
    *("configuration-i", "--plane", "yaw", "--wind", "rectangular", "--peak-deg", "4"),
    *("--duration", "5", "--set", "wind.direction_deg=250", "--azimuth-deg", "45"),
    *("--set", "gust.peak_deg=0.5", "--set", "gust.duration_s=1", "--set", "gust.peak_time_s=2.5"),
)
AIRCRAFT = ("--set", "criteria.name=aircraft")
LOOP = (
    *(
        "--natural-frequency",
        "1.2",
        "--set",
        "nozzle.actuator_frequency_rad_per_s=30",
        "--delay-ms",
        "10",
    ),
    *(
        "--sample-rate",
        "80",
        "--set",
        'autopilot.filter=[{kind="low-pass", frequency_Hz=9}]',
    ),
)


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(STUDY)
    return str(path)


def run(*arguments):
    return CliRunner().invoke(app, [*arguments, "--json"])


def document(*arguments):
    result = run(*arguments)
    assert result.exit_code in (0, 1), result.output
    return json.loads(result.stdout)


def test_a_study_file_and_python_make_the_same_case(file):
    plan = tv.load_study(file)
    assert plan.history.peak == pytest.approx(CASE.history.peak, rel=1e-15)
    for one in (plan, CASE):
        assert (one.model, one.plane, one.loop_model) == ("drift", "yaw", "drift")
    assert plan.autopilot == CASE.autopilot
    assert plan.hardware == CASE.hardware


@pytest.mark.thorough
def test_every_command_answers_for_the_case_of_the_study(file):
    computed, study = find(tv.load_study(file)), tv.Study.of(CASE, 0.5)
    required = np.degrees(study.required_deflection)
    assert np.degrees(computed.study.required_deflection) == pytest.approx(required, rel=1e-13)
    assert document("study", file)["verdict"]["required_deflection_deg"] == pytest.approx(required)
    responded, nominal = document("respond", file), np.degrees(study.nominal_deflection)
    assert (responded["nominal_deflection_deg"], responded["limit_deg"]) == pytest.approx(
        (nominal, 2.0), rel=1e-13
    )
    minimum = np.degrees(study.minima["drift"])
    assert document("boundary", file)["peak_deg"] == pytest.approx(minimum, rel=1e-9)
    controlled = document("fly", file, "--law", "autopilot")["comparison"]
    comparison = computed.comparison
    assert controlled["peak_deflection_deg"] == np.degrees(comparison.peak_deflection)
    margins = document("margins", file, "--limit-deg", "2")
    whole = comparison.margins
    assert margins["margins"]["phase_margin_deg"] == whole.phase_margin_deg
    assert margins["criteria"]["name"] == controlled["criteria"]["name"] == "aircraft"
    assert margins["flown"]["spare"] == computed.flown.spare
    flown = fly_sampled(
        CASE.plant,
        tv.SaturatedLaw.of(CASE.autopilot),
        CASE.history,
        np.linspace(0.0, 10.0, 401),
        deflection_limit=CASE.nozzle.limit,
        **CASE.hardware,
    )
    flight = document("fly", file, "--engine", "linear")
    peak = np.degrees(flown.peaks("attitude")[0])
    assert flight["peaks_over_the_wind_deg"]["attitude"]["flown"] == pytest.approx(peak, rel=1e-12)


@pytest.mark.thorough
def test_laws_of_a_study_file_are_those_of_the_study(file, tmp_path):
    calm = tmp_path / "calm.toml"
    calm.write_text(
        STUDY.replace("[gust]\npeak_deg = 0.5\nduration_s = 1.0\npeak_time_s = 2.5\n", "")
    )
    trials = find(tv.load_study(calm)).trials
    result = document("fly", str(calm), "--law", "all")
    assert result["sample_rate_Hz"] == 50
    assert {trial["law"]: trial["limit"] for trial in result["trials"]} == {
        trial.law: trial.limit for trial in trials
    }


@pytest.mark.thorough
@pytest.mark.parametrize("command", usual(["respond", "boundary", "design", "margins", "fly"], 0))
def test_a_study_file_and_options_give_the_same_answer(command, file):
    own = {
        "respond": ("--model", "drift", "--limit-deg", "2", "--dead-band", "0.5"),
        "boundary": ("--model", "drift", "--set", "nozzle.rate_limit_deg_per_s=20"),
        "design": ("--model", "drift", *AIRCRAFT, *LOOP),
        "margins": (
            *("--model", "drift", *AIRCRAFT, *LOOP),
            *("--limit-deg", "2", "--set", "nozzle.rate_limit_deg_per_s=20"),
        ),
        "fly": (
            *("--model", "drift", *AIRCRAFT, *LOOP),
            *("--limit-deg", "2", "--set", "nozzle.rate_limit_deg_per_s=20"),
        ),
    }[command]
    same = ("--limit-deg", "2") if command == "margins" else ()
    assert document(command, file, *same) == document(command, *AS_OPTIONS, *own)


def test_a_model_that_is_not_flown_is_told():
    drift = tv.Case(vehicle=tv.load_vehicle("made-up-launcher"), model="drift")
    assert drift.plant.model == "drift-exact"
    assert "the model is drift-exact: drift leaves out the structure" in omission_notes(
        drift, "margins"
    )
    assert "the model is drift-exact" not in " ".join(omission_notes(drift, "respond"))
    fast = tv.Case(vehicle=tv.load_vehicle("configuration-i"), model="drift-and-speed")
    (sentence,) = omission_notes(fast, "fly --law all")
    assert sentence.startswith("the model is drift-exact: drift-and-speed has a speed")
    assert not list(omission_notes(fast, "margins"))


@pytest.mark.thorough
def test_an_option_counts_more_than_the_file(file):
    over = ("--natural-frequency", "1.5", "--delay-ms", "0", "--limit-deg", "3", "--plane", "pitch")
    result = document("fly", file, *over)
    gains = result["comparison"]["autopilot"]
    assert (gains["delay_s"], result["limit_deg"], result["plane"]) == (
        0.0,
        pytest.approx(3),
        "pitch",
    )
    given = document("design", file, "--attitude-gain", "1", "--rate-gain", "2")["autopilot"]
    assert (given["attitude_gain"], given["rate_gain_s"]) == (1.0, 2.0)
    lqr = document("margins", file, "--design", "lqr")["autopilot"]
    assert lqr["attitude_gain"] != gains["attitude_gain"]
    capable = document("respond", file, "--capability", "1.5")
    assert capable["limit_deg"] == pytest.approx(1.5 * capable["nominal_deflection_deg"], rel=1e-12)


@pytest.mark.thorough
def test_gains_for_the_least_nozzle_in_a_file_are_those_of_the_study(tmp_path):
    path = tmp_path / "least.toml"
    path.write_text(
        """
[study]
vehicle = "configuration-i"
[wind]
peak_deg = 5
duration_s = 7.5
[autopilot]
design = "least-nozzle"
crossover_rad_per_s = 2
delay_ms = 20
"""
    )
    sought = find(tv.load_study(path)).comparison.autopilot
    for command in ("design", "margins"):
        gains = document(command, str(path))["autopilot"]
        assert (gains["attitude_gain"], gains["rate_gain_s"]) == (
            sought.attitude_gain,
            sought.rate_gain,
        )
    other = document("design", str(path), "--design", "canonical")["autopilot"]
    assert other["attitude_gain"] != sought.attitude_gain


@pytest.mark.thorough
def test_a_sounding_meets_the_flight_of_the_study_file(tmp_path):
    sounding = ("--winds", "tests/soundings/wyoming.txt", "--azimuth-deg", "90")
    path = tmp_path / "my.toml"
    path.write_text(STUDY.partition("[wind]")[0] + "[wind]\npeak_deg = 4\nduration_s = 5\n")
    beside = ("--model", "drift", "--plane", "yaw", "--dead-band", "0.5")
    result = document("respond", str(path), *sounding)
    assert result == document("respond", "configuration-i", *sounding, *beside)
    flight = document("fly", str(path), *sounding, *VARYING, "--dead-band", "1")
    assert flight == document("fly", "configuration-i", *sounding, *VARYING, "--plane", "yaw")


def test_a_vehicle_with_its_numbers_in_the_study_file_has_no_flight(tmp_path):
    path = tmp_path / "my.toml"
    lines = "\n".join(
        f"{key} = {value}"
        for key, value in {
            **{"weight_N": 1.48e6, "moment_of_inertia_kg_m2": 3e7, "thrust_N": 2.1e6},
            **{"aerodynamic_arm_m": 9.0, "control_arm_m": 20.0, "velocity_m_per_s": 500.0},
            **{"attitude_deg": 60.0, "time_s": 66.0, "axial_force_N": 2e5},
            "normal_force_slope_N_per_rad": 2e6,
        }.items()
    )
    wind = "[wind]\npeak_deg = 5\nduration_s = 7.5\n"
    path.write_text(f"[study.vehicle]\n{lines}\n{wind}")
    result = run("fly", str(path), *VARYING)
    assert (result.exit_code, "name a vehicle file with a table [flight]" in result.output) == (
        2,
        True,
    )
    assert document("poles", str(path))["plane"] == "pitch"


def test_a_shift_below_the_digits_shown_has_no_sign() -> None:
    """The shift of a stiff, dry vehicle is a rounding of zero, and was "-0.00 percent"."""
    vehicle = tv.load_vehicle("made-up-launcher")
    stiff = tuple(
        replace(mode, frequency=30.0 * mode.frequency, tank_displacements=(), tank_slopes=())
        for mode in vehicle.structure.bending
    )
    dry = replace(vehicle.structure, slosh=(), engine=None, bending=stiff)
    (said,) = omission_notes(tv.Case(vehicle=vehicle.replace(structure=dry)), "respond")
    assert "would move the fast pole by less than 0.01 percent" in said


@pytest.mark.thorough
def test_an_archive_without_a_criterion_is_said_to_be_no_question(tmp_path) -> None:
    (tmp_path / "days").mkdir()
    rows = ["height_m,east_m_per_s,north_m_per_s", *(f"{z},5,0" for z in range(0, 40001, 1000)), ""]
    (tmp_path / "days" / "2024-02-01.csv").write_text("\n".join(rows), encoding="utf-8")
    file = tmp_path / "my.toml"
    lines = ['[study]\nvehicle = "configuration-i"', '[wind]\nshape = "triangular"\npeak_deg = 5']
    lines += [
        "duration_s = 7.5",
        "[nozzle]\nlimit_deg = 1",
        '[schedule]\nsource = "configuration-i"',
    ]
    lines += ['[availability]\narchive = "days"\nazimuth_deg = 90']
    for least_part, noted in (("", True), ("least_part = 0.9", False)):
        file.write_text("\n".join([*lines, least_part, ""]), encoding="utf-8")
        result = CliRunner().invoke(app, ["study", str(file)])
        assert ("[availability] has no least_part" in " ".join(result.output.split())) is noted
