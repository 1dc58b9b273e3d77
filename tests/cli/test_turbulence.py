"""Turbulence in study files: its keys, its criterion, and where it is not known."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import tvclin as tv
from tests.turns import usual
from tvclin.cli.app import app
from tvclin.control.autopilot.gain_schedule import flight_autopilot
from tvclin.show.explorer.choices import Choices, study_text
from tvclin.vehicle.vehicle_file import read_vehicle_text

STUDY = """
[study]
vehicle = "configuration-i"
sign = "frozen"
[wind]
peak_deg = 5.0
duration_s = 7.5
[nozzle]
limit_deg = 1.4
rate_limit_deg_per_s = 3
"""


def run(path: Path, turbulence: str, *arguments: str, study: str = STUDY) -> Result:
    file = path / "study.toml"
    file.write_text(f"{study}\n[turbulence]\n{turbulence}\n")
    return CliRunner().invoke(app, ["study", str(file), *arguments])


def test_the_criterion_is_the_peak_in_the_wind_and_k_sigma(tmp_path: Path) -> None:
    keys = "intensity_m_per_s = 6\nsigmas = 2"
    result = run(tmp_path, keys, "--json")
    assert result.exit_code == 0, result.output
    answer = json.loads(result.stdout)
    vehicle = tv.load_vehicle("configuration-i")
    plant = tv.Plant.from_vehicle(vehicle, "drift-exact")
    autopilot = tv.load_study(str(tmp_path / "study.toml")).autopilot
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
    air = tv.winds.Turbulence(6.0)
    spread = tv.control.turbulence_covariance(autopilot, plant, air, vehicle.velocity)
    response = autopilot.wind_response(plant, wind)
    of = answer["turbulence"]
    expected = abs(response.peak("deflection")[0]) + 2.0 * spread.rms()
    assert of["deflection_deg"] == pytest.approx(np.degrees(expected), rel=1e-5)
    rate = response.peak_rate("deflection") + 2.0 * spread.rms("deflection_rate")
    assert of["deflection_rate_deg_per_s"] == pytest.approx(np.degrees(rate), rel=1e-3)
    questions = {question["name"]: question for question in answer["questions"]}
    assert questions["turbulence"]["answer"] == "MET"
    assert questions["turbulence"]["measure"]["required"] == of["deflection_deg"]
    assert questions["rate in turbulence"]["measure"]["available"] == pytest.approx(3.0)


@pytest.mark.thorough
def test_more_standard_deviations_than_the_limit_covers_are_not_met(tmp_path: Path) -> None:
    result = run(tmp_path, "intensity_m_per_s = 20\nsigmas = 6", "--more")
    assert result.exit_code == 1
    first = " ".join(result.stdout.partition("\n\n")[0].split())
    assert first.startswith(
        "NOT MET: the linear autopilot in the wind and 6 sigma of turbulence requires"
    )
    assert "deg and has 1.400 deg" in first
    assert "wind + 6 sigma" in result.stdout


@pytest.mark.thorough
def test_gains_that_are_assumed_in_turbulence_are_named(tmp_path: Path) -> None:
    result = run(tmp_path, "intensity_m_per_s = 6\nsigmas = 2", "--json")
    notes = json.loads(result.stdout)["notes"]
    assert any(note.startswith("these are textbook gains, a0 = 2 B") for note in notes)
    assert any(note.startswith("gains that satisfy the criteria classic: ") for note in notes)
    of = tv.winds.Turbulence(6.0)
    plan = tv.load_study("configuration-i")
    sigma = tv.control.turbulence_covariance(
        plan.autopilot, plan.plant, of, float(plan.vehicle.velocity)
    ).rms("deflection")
    part = f"2 sigma of turbulence are {np.degrees(2.0 * sigma):.3f} deg of the "
    assert any(note.startswith(part) for note in notes)


@pytest.mark.parametrize(
    ("keys", "severity"),
    [
        ('severity = "severe"\naltitude_ft = 15000', 22.1),
        ("exceedance = 1e-3\naltitude_ft = 25000", 6.6),
    ],
)
def test_a_severity_is_that_of_the_specification(
    tmp_path: Path, keys: str, severity: float
) -> None:
    (tmp_path / "study.toml").write_text(f"{STUDY}\n[turbulence]\n{keys}\n")
    plan = tv.load_study(str(tmp_path / "study.toml"))
    assert plan.turbulence is not None
    assert plan.turbulence.at().intensity == pytest.approx(severity * 0.3048)
    assert plan.turbulence.at().length == pytest.approx(533.4)


@pytest.mark.thorough
def test_turbulence_over_altitude_is_that_of_a_file_or_of_levels(tmp_path: Path) -> None:
    (tmp_path / "air.csv").write_text("altitude_ft,intensity_kt\n0,4\n40000,12\n")
    level = "[[turbulence.level]]\naltitude_ft = {}\nintensity_kt = {}\n"
    tables = ['file = "air.csv"\naltitude_ft = 20000\n', "altitude_ft = 20000\n"]
    tables[1] += level.format(0, 4) + level.format(40000, 12)
    for keys in tables:
        (tmp_path / "study.toml").write_text(f"{STUDY}\n[turbulence]\n{keys}\n")
        plan = tv.load_study(str(tmp_path / "study.toml"))
        assert plan.turbulence is not None
        assert plan.turbulence.at().intensity == pytest.approx(8 * 1852 / 3600)
        assert plan.turbulence.at(0.0).intensity == pytest.approx(4 * 1852 / 3600)
        assert plan.turbulence.at().length == pytest.approx(533.4)
    assert run(tmp_path, tables[0]).exit_code == 0


def test_a_cutoff_leaves_less_turbulence(tmp_path: Path) -> None:
    rms, file = [], tmp_path / "study.toml"
    for keys in ("intensity_m_per_s = 6", "intensity_m_per_s = 6\ncutoff_wavelength_m = 3000"):
        file.write_text(f"{STUDY}\n[turbulence]\n{keys}\n")
        plan = tv.load_study(file)
        assert plan.turbulence is not None
        given = plan.autopilot, plan.plant, plan.turbulence.at(), float(plan.vehicle.velocity)
        rms.append(tv.control.turbulence_covariance(*given).rms())
    assert 0.1 * rms[0] < rms[1] < 0.8 * rms[0]


@pytest.mark.thorough
def test_with_a_flight_the_altitude_is_that_of_the_time(tmp_path: Path) -> None:
    study = f'{STUDY}[schedule]\nsource = "configuration-i"\n[size]\nfrom_s = 66\nto_s = 66\n'
    answer = json.loads(run(tmp_path, 'severity = "severe"', "--json", study=study).stdout)
    schedule = tv.load_schedule("configuration-i")
    height = np.interp(66.0, schedule.times, schedule.height)
    severe = tv.winds.Turbulence.mil_f_8785c("severe").at(float(height))
    air = answer["turbulence"]["turbulence"]
    assert air["intensity_m_per_s"] == pytest.approx(severe.intensity, rel=1e-9)


@pytest.mark.thorough
def test_an_altitude_is_that_of_the_flight_of_the_vehicle(tmp_path: Path) -> None:
    """In its own [flight] configuration I is at 11.95 km; without a flight the key is named."""
    severe = 'severity = "severe"\n'
    flown, given = (
        json.loads(run(tmp_path, f"{severe}{altitude}", "--json").stdout)["turbulence"]
        for altitude in ("", "altitude_m = 11950")
    )
    assert flown["deflection_deg"] == pytest.approx(given["deflection_deg"], rel=1e-9)
    text = read_vehicle_text("configuration-i")[0]
    (tmp_path / "v.toml").write_text(text.partition("[flight]")[0])
    without = run(tmp_path, severe, study=STUDY.replace("configuration-i", "v.toml"))
    assert without.exit_code == 2
    assert "give altitude_m in [turbulence], or a table [flight]" in " ".join(
        without.output.split()
    )


@pytest.mark.thorough
def test_the_share_of_turbulence_in_the_budget_is_said() -> None:
    options = ("--limit-deg", "1", "--from", "66", "--to", "66")
    keys = ("--set", "turbulence.intensity_m_per_s", "6", "--set", "autopilot.design", "canonical")
    words = ["ascent", "configuration-i", *options, *keys]
    said, document = (CliRunner().invoke(app, [*words, *more]) for more in ((), ("--json",)))
    lines = {line["name"]: line for line in json.loads(document.stdout)["total"]["lines"]}
    share = lines["turbulence, 3 sigma"]["deflection_deg"]
    assert f"3 sigma, adds {share:.3f} deg to the budget" in " ".join(said.output.split())


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ("", "needs one of intensity, severity, exceedance, file and level"),
        ('severity = "rough"\naltitude_m = 9e3', "must be one of light, moderate, severe"),
        ("intensity_m_per_s = 6\nlenght_m = 500", "did you mean length_m"),
    ],
)
def test_bad_keys_are_refused_in_a_sentence(tmp_path: Path, keys: str, sentence: str) -> None:
    result = run(tmp_path, keys)
    assert result.exit_code == 2
    assert sentence in " ".join(result.output.replace("│", " ").split())


@pytest.mark.thorough
def test_in_a_head_wind_the_dynamic_pressure_at_its_peak_is_an_upper_bound(tmp_path: Path) -> None:
    study = STUDY.replace('sign = "frozen"\n', "")
    nominal = json.loads(run(tmp_path, "intensity_m_per_s = 6", "--json").stdout)
    result = json.loads(run(tmp_path, "intensity_m_per_s = 6", "--json", study=study).stdout)
    answers = [
        next(q for q in answer["questions"] if q["name"] == "turbulence")
        for answer in (nominal, result)
    ]
    low, high = (answer["measure"]["required"] for answer in answers)
    assert low == nominal["turbulence"]["deflection_deg"] == result["turbulence"]["deflection_deg"]
    assert 1.1 * low < high
    between = str(0.5 * (low + high))
    unknown = json.loads(
        run(tmp_path, "intensity_m_per_s = 6", "--json", "--limit-deg", between, study=study).stdout
    )
    words = {q["name"]: q["answer"] for q in unknown["questions"]}
    assert words["turbulence"] == "NOT KNOWN"
    assert words["rate in turbulence"] == "MET"


@pytest.mark.thorough
def test_without_a_stationary_covariance_it_is_not_known(tmp_path: Path) -> None:
    study = f"{STUDY}[autopilot]\nattitude_gain = 0.05\nrate_gain_s = 0.3\n"
    result = run(tmp_path, "intensity_m_per_s = 6", study=study)
    assert result.exit_code == 1, result.output
    assert re.search(r"turbulence +NOT KNOWN", result.stdout)
    assert "turbulence: the loop is not stable: it has a pole at" in result.stdout


def test_without_the_speed_of_the_vehicle_it_is_not_known(tmp_path: Path) -> None:
    (tmp_path / "linear.toml").write_text(
        "[coefficients]\nmu_alpha_per_s2 = 0.228\nmu_delta_per_s2 = 1.317\n"
    )
    study = STUDY.replace("configuration-i", "linear.toml").replace('sign = "frozen"\n', "")
    result = run(tmp_path, "intensity_m_per_s = 6", study=study)
    assert result.exit_code == 1, result.output
    assert "turbulence: turbulence needs the speed of the vehicle" in result.stdout


@pytest.mark.thorough
@pytest.mark.parametrize("command", ["disperse", "respond", "poles"])
def test_a_command_without_turbulence_says_so(tmp_path: Path, command: str) -> None:
    file = tmp_path / "study.toml"
    file.write_text(f"{STUDY}\n[campaign]\ncases = 20\n[turbulence]\nintensity_m_per_s = 6\n")
    result = CliRunner().invoke(app, [command, str(file)])
    assert result.exit_code in (0, 1), result.output
    left_out = re.search(r"not counted here: (.*?) \(tvclin", result.stderr)
    assert left_out, result.stderr
    assert "turbulence" in left_out[1]


def flight(path: Path, keys: str, *options: str, study: str = STUDY) -> Any:
    """Return the document of the whole flight of a study file."""
    file = path / "flight.toml"
    file.write_text(f'{study}\n[schedule]\nsource = "configuration-i"\n[turbulence]\n{keys}\n')
    result = CliRunner().invoke(app, ["ascent", str(file), *options, "--json"])
    assert result.exit_code in (0, 1), result.output
    return json.loads(result.stdout)


AT_66_S = ("--from", "66", "--to", "66")


@pytest.mark.thorough
def test_the_budget_has_turbulence_at_its_own_quantile(tmp_path: Path) -> None:
    result = flight(tmp_path, 'severity = "severe"\nprobability = 0.95', *AT_66_S)
    schedule = tv.load_schedule("configuration-i")
    times = np.linspace(*schedule.span, 31)
    plants = tv.Plant.from_vehicle(schedule.at(times), "drift-exact")
    designs = [tv.control.canonical_gains(plants.case(k, (31,))) for k in range(31)]
    gains = {
        name: np.array([getattr(design, name) for design in designs])
        for name in ("attitude_gain", "rate_gain")
    }
    actuator = tv.load_study(str(tmp_path / "flight.toml")).nozzle.actuator
    law = tv.control.GainSchedule(times, tv.Autopilot(**gains, actuator=actuator))
    severe = tv.winds.Turbulence.mil_f_8785c("severe")
    along = tv.control.turbulence_along(schedule, law, severe)
    spread = np.interp(66.0, along.times, along.deviation())
    lines = {line["name"].partition(",")[0]: line for line in result["total"]["lines"]}
    assert lines["turbulence"]["kind"] == "random"
    expected = np.degrees(1.959963984540054 * spread)  # the normal quantile of 0.975
    assert lines["turbulence"]["deflection_deg"] == pytest.approx(expected, rel=2e-3)  # designs
    total = sum(line["deflection_deg"] for line in lines.values())  # no other is random
    assert result["total"]["total_deg"] == pytest.approx(total, rel=1e-12)


@pytest.mark.thorough
def test_a_pulse_of_one_flight_time_is_that_of_the_study(tmp_path: Path) -> None:
    """Without the spread, which a study has of a loop that is frozen throughout."""
    keys = "intensity_m_per_s = 6\nsigmas = 0"
    (pulse,) = flight(tmp_path, keys, *AT_66_S)["turbulence"]["winds"]
    single = json.loads(run(tmp_path, keys, "--json").stdout)["turbulence"]
    for name in ("deflection_deg", "deflection_rate_deg_per_s", "angle_of_attack_deg"):
        assert pulse[name] == pytest.approx(single[name], rel=1e-3), name  # of 66 s by its schedule


@pytest.mark.thorough
def test_a_head_wind_counts_with_its_dynamic_pressure(tmp_path: Path) -> None:
    study = STUDY.replace('sign = "frozen"\n', "")
    keys = "intensity_m_per_s = 6"
    head, tail = flight(tmp_path, keys, *AT_66_S, study=study)["turbulence"]["winds"]
    (nominal,) = flight(tmp_path, keys, *AT_66_S)["turbulence"]["winds"]
    assert tail["deflection_deg"] == pytest.approx(nominal["deflection_deg"], rel=1e-9)
    assert head["deflection_deg"] > 1.1 * nominal["deflection_deg"]


@pytest.mark.thorough
def test_a_sounding_is_flown_along_the_flight() -> None:
    schedule = tv.load_schedule("configuration-i")
    profile = tv.WindProfile(
        height=[0.0, 6e3, 12e3, 40e3], east=[0.0, 10.0, 40.0, 5.0], north=[0.0] * 4
    )
    request = tv.requirement.SizingRequest(
        schedule=schedule,
        pulse=False,
        soundings={"west": tv.requirement.SoundingRequest(profile, np.radians(90.0))},
        start=60.0,
        stop=70.0,
    )
    design = tv.control.AutopilotDesign(attitude_gain=0.8, rate_gain=0.8)
    options = tv.case.TurbulenceRequest(intensity=6.0, sigmas=0.0)
    wind = tv.ascent.fly_through(profile, schedule, azimuth=np.radians(90.0))
    for sign in ("frozen", None):
        case = tv.Case(vehicle=schedule.vehicle, design=design, sign=sign)
        result = request.turbulence(case, options)
        assert isinstance(result, tv.requirement.FlightTurbulence)
        flown = tv.flights.fly_along(schedule, design_of(case), wind, sign=sign)
        largest = np.abs(flown.outputs["deflection"]).max()
        assert result.winds[0].deflection == pytest.approx(largest, rel=1e-3)  # of other times


@pytest.mark.thorough
def test_waves_that_a_sounding_holds_are_named_until_a_cutoff_omits_them() -> None:
    """2 km between its levels, over the sine of the flight path angle."""
    schedule = tv.load_schedule("configuration-i")
    profile = tv.WindProfile(
        height=[0.0, 8e3, 9e3, 11e3, 12e3, 60e3],
        east=[0.0, 10.0, 12.0, 40.0, 35.0, 5.0],
        north=[0.0] * 6,
    )
    request = tv.requirement.SizingRequest(
        schedule=schedule.between(*np.interp([8e3, 12e3], schedule.height, schedule.times)),
        pulse=False,
        soundings={"west": tv.requirement.SoundingRequest(profile, np.radians(90.0))},
    )
    climb = np.interp(10e3, schedule.height, schedule.vehicle.attitude)
    case = tv.Case(vehicle=schedule.vehicle)
    whole, short = (
        request.turbulence(case, tv.case.TurbulenceRequest(intensity=6.0, cutoff_wavelength=cutoff))
        for cutoff in (None, 4e3)
    )
    assert isinstance(whole, tv.requirement.FlightTurbulence)
    assert isinstance(short, tv.requirement.FlightTurbulence)
    assert whole.sounding_wavelength == pytest.approx(4e3 / np.sin(climb), rel=0.01)
    assert any("turbulence counts once more" in note for note in whole.notes)
    assert not any("once more" in note for note in short.notes)


def design_of(case: tv.Case) -> tv.Autopilot:
    """Return the autopilot of a case with given gains, at any time of its flight."""
    return tv.Autopilot(attitude_gain=0.8, rate_gain=0.8, actuator=case.nozzle.actuator)


@pytest.mark.thorough
def test_a_flight_whose_turbulence_is_not_known_is_not_sized(tmp_path: Path) -> None:
    study = f'{STUDY}limit_shape = "round"\n'.replace(
        "peak_deg = 5.0", "peak_deg = 5.0\ndirection_deg = 250\nazimuth_deg = 45"
    )
    result = flight(tmp_path, "intensity_m_per_s = 6", *AT_66_S, study=study)
    assert result["verdict"]["sufficient"] is None
    assert "in turbulence: turbulence is answered in one plane" in result["verdict"]["not_sized"][0]


SHEET = ("--over", "flight", "--limit-deg", "3", "--from", "60", "--to", "70")


def sheet(*options: str) -> Any:
    """Return the document of the data sheet of configuration I, without a head wind."""
    words = ["nozzle", "configuration-i", *SHEET, "--set", "study.sign=frozen", *options, "--json"]
    result = CliRunner().invoke(app, words)
    assert result.exit_code in (0, 1), result.output
    return json.loads(result.stdout)


RANDOM = ("--set", "turbulence.intensity_m_per_s=6", "--set", "turbulence.sigmas=2")


@pytest.mark.thorough
def test_the_data_sheet_counts_turbulence_and_its_travel() -> None:
    calm, computed = sheet("--law", "autopilot"), sheet("--law", "autopilot", *RANDOM)
    lines, before = (
        {line["name"]: line for line in answer["verdict"]["lines"]} for answer in (computed, calm)
    )
    random = computed["turbulence"]
    largest = max(
        point["angle_deg"] + 2.0 * random["deflection_rms_deg"][random["times_s"].index(time)]
        for point in calm["points"]
        for time in [point["time_s"]]
    )
    assert lines["deflection"]["required"] == pytest.approx(largest, rel=1e-12)
    assert lines["deflection rate"]["required"] > 1.1 * before["deflection rate"]["required"]
    schedule = tv.load_schedule("configuration-i")
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5).shift(60.0 - 3.75)
    even = np.union1d(np.linspace(*schedule.span, 17), [60.0, 65.0, 70.0])
    law = flight_autopilot(
        tv.control.AutopilotDesign(),
        schedule,
        even,
        actuator=tv.Nozzle().actuator,
        model="drift-exact",
        plane="pitch",
    )
    flown = tv.control.turbulence_along(schedule, law, tv.winds.Turbulence(6.0), wind=wind)
    alone = np.trapezoid(np.abs(flown.mean("deflection_rate")), flown.times)
    more = np.degrees(flown.travel() - alone + 2.0 * flown.travel_deviation())
    added = lines["travel of a flight"]["required"] - before["travel of a flight"]["required"]
    assert added == pytest.approx(more, rel=1e-6)


@pytest.mark.thorough
@pytest.mark.parametrize("law", usual(["trim", "half-relief"], 0))
def test_the_data_sheet_counts_turbulence_of_the_gains_of_another_linear_law(law: str) -> None:
    """Gains by the formulas of the report: trim, a ten times larger feedback, and half relief."""
    calm, computed = sheet("--law", law), sheet("--law", law, *RANDOM)
    lines, before = (
        {line["name"]: line["required"] for line in answer["verdict"]["lines"]}
        for answer in (computed, calm)
    )
    schedule = tv.load_schedule("configuration-i")
    times = np.union1d(np.linspace(*schedule.span, 17), [60.0, 65.0, 70.0])
    c = schedule.plants(times, "drift-exact", "pitch").coefficients
    B, pole = c.mu_alpha / c.mu_delta, np.sqrt(c.mu_alpha)
    gains = {"attitude_gain": 10.0 * B, "rate_gain": 10.0 * B / pole, "alpha_gain": B}
    if law == "half-relief":
        half = tv.control.half_relief_gains(c)
        gains = {name: getattr(half, name) for name in gains}
    autopilot = tv.Autopilot(**gains, actuator=tv.Nozzle().actuator)
    flown = tv.control.turbulence_along(
        schedule, tv.control.GainSchedule(times, autopilot), tv.winds.Turbulence(6.0)
    )
    rms = np.interp(computed["turbulence"]["times_s"], flown.times, flown.deviation("deflection"))
    assert computed["turbulence"]["deflection_rms_deg"] == pytest.approx(np.degrees(rms), rel=1e-6)
    added = lines["travel of a flight"] - before["travel of a flight"]
    assert added > 0.8 * np.degrees(flown.travel())
    assert lines["deflection rate"] > before["deflection rate"]


@pytest.mark.thorough
def test_a_data_sheet_of_a_law_that_switches_is_not_known_in_turbulence() -> None:
    assert sheet("--law", "dead-band")["verdict"]["satisfied"] is True
    data_sheet = sheet("--law", "dead-band", *RANDOM)
    assert data_sheet["verdict"]["satisfied"] is None
    assert any("dead-band is not linear" in reason for reason in data_sheet["verdict"]["unknown"])


@pytest.mark.thorough
def test_torque_in_turbulence_is_not_known() -> None:
    hinge = ("--set", "nozzle.mass_kg=900", "--set", "nozzle.arm_m=1")
    limit = ("--set", "nozzle.torque_limit_N_m=1e6")
    assert sheet("--law", "autopilot", *hinge, *limit)["verdict"]["satisfied"] is True
    assert sheet("--law", "autopilot", *hinge, *limit, *RANDOM)["verdict"]["satisfied"] is None


@pytest.mark.thorough
@pytest.mark.parametrize(
    "words",
    usual(
        [
            "margins",
            "ascent --from 66 --to 66",
            "nozzle --limit-deg 2 --from 66 --to 66",
            "study --at 66",
        ],
        *(0, 3),
    ),
)
def test_no_command_of_a_flight_schedule_is_silent_on_it(tmp_path: Path, words: str) -> None:
    file = tmp_path / "flight.csv"
    tv.load_schedule("configuration-i").to_csv(file)
    command, *options = words.split()
    result = CliRunner().invoke(app, [command, str(file), *options, *RANDOM])
    assert result.exit_code in (0, 1), result.output
    assert "turbulence" in result.output


def test_a_campaign_refuses_values_out_of_range() -> None:
    words = ["disperse", "configuration-i", "--set", "turbulence.intensity_m_per_s=-1"]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 2
    assert "intensity_m_per_s in [turbulence] must be zero or positive" in result.output


@pytest.mark.parametrize(
    "request_",
    [
        tv.case.TurbulenceRequest(intensity=6.0, spectrum="von-karman", probability=0.99),
        tv.case.TurbulenceRequest(severity="light", altitude=9e3, sigmas=2.0),
        tv.case.TurbulenceRequest(
            table=tv.winds.Turbulence([3.0, 5.0], length=[400.0, 500.0], altitude=[0.0, 9e3]),
            altitude=3e3,
        ),
    ],
)
def test_a_study_that_the_panel_writes_keeps_turbulence(
    tmp_path: Path, request_: tv.case.TurbulenceRequest
) -> None:
    plan = replace(tv.load_study("configuration-i"), turbulence=request_)
    file = tmp_path / "written.toml"
    file.write_text(study_text(Choices(plan=plan, law="trim")))
    read = tv.load_study(str(file)).turbulence
    assert read is not None
    assert read.factor == pytest.approx(request_.factor, rel=1e-12)
    for mine, other in zip(read.at().over(None), request_.at().over(None), strict=True):
        assert mine == pytest.approx(other, rel=1e-12)
