"""A flight schedule with a time of flight is a vehicle, in every command that takes one."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tvclin.base.errors import InputError
from tvclin.cli.app import app

HEAD = (
    "name,time_s,weight_N,moment_of_inertia_kg_m2,thrust_N,control_arm_m,aerodynamic_arm_m,"
    "velocity_m_per_s,attitude_deg,normal_force_slope_N_per_rad,axial_force_N\n"
)
ROWS = (
    "Booster,40,1.7e7,2.6e8,2.5e7,23.5,7.0,330,60,5e6,5e5\n"
    "Booster,60,1.5e7,2.2e8,2.5e7,23.5,9.5,540,45,6.7e6,7.9e5\n"
)
AT_52 = """
[vehicle]
name = "Booster"
time_s = 52
weight_N = 1.58e7
moment_of_inertia_kg_m2 = 2.36e8
thrust_N = 2.5e7
control_arm_m = 23.5
aerodynamic_arm_m = 8.5
velocity_m_per_s = 456
attitude_deg = 51
normal_force_slope_N_per_rad = 6.02e6
axial_force_N = 6.74e5
"""
"""Three fifths of the way between the rows, by hand."""
COMMANDS = {
    "study": (),
    "poles": (),
    "boundary": (),
    "respond": (),
    "design": (),
    "margins": (),
    "fly": ("--limit-deg", "1"),
    "nozzle": (),
    "nozzle --over load": (),
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a schedule in CSV and TOML, and the vehicle between its rows."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "flight.csv").write_text(HEAD + ROWS)
    columns = zip(*(row.split(",") for row in (HEAD + ROWS).split()), strict=True)
    lists = "\n".join(f"{key} = [{', '.join(cells)}]" for key, *cells in columns if key != "name")
    (tmp_path / "flight.toml").write_text(f'[schedule]\nname = "Booster"\n{lists}\n')
    (tmp_path / "at-52.toml").write_text(AT_52)
    return tmp_path


def run(*given):
    return CliRunner().invoke(app, [str(one) for one in given])


def numbers(document):
    """All numbers of a document in their order."""
    if isinstance(document, dict):
        document = [document[key] for key in sorted(document)]
    if isinstance(document, list):
        return [number for one in document for number in numbers(one)]
    return [document] if isinstance(document, int | float) else []


SLOW = ("design", "respond", "nozzle", "nozzle --over load")
"""Commands of several seconds, of which the thorough tests have the claim."""


@pytest.mark.parametrize(
    "command",
    [pytest.param(one, marks=[pytest.mark.thorough] * (one in SLOW)) for one in COMMANDS],
)
def test_a_schedule_at_a_time_is_answered_as_the_vehicle_between_its_rows(folder, command):
    options = (*COMMANDS[command], "--json")
    flight = run(*command.split(), "flight.csv", "--at", 52, *options)
    vehicle = run(*command.split(), "at-52.toml", *options)
    assert flight.exit_code == vehicle.exit_code != 2, flight.output
    computed, expected = (numbers(json.loads(one.stdout)) for one in (flight, vehicle))
    # roundings of the interpolation, times what a search between two of them may make of it
    np.testing.assert_allclose(computed, expected, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("schedule", ["flight.csv", "flight.toml"])
def test_init_writes_the_vehicle_of_a_schedule_at_a_time(folder, schedule):
    assert run("init", "--from", schedule, "--at", 52, "my.toml").exit_code == 0
    made, by_hand = tv.load_vehicle("my.toml"), tv.load_vehicle("at-52.toml")
    for name in ("weight", "moment_of_inertia", "thrust", "aerodynamic_arm", "control_arm", "time"):
        assert getattr(made, name) == pytest.approx(getattr(by_hand, name), rel=1e-12)
    assert made.attitude == pytest.approx(by_hand.attitude, rel=1e-11)
    assert made.numbers_from == f"{schedule} at 52 s"


def test_study_and_campaign_files_name_a_schedule_with_its_time(folder):
    wind = '[wind]\nshape = "triangular"\npeak_deg = 5\nduration_s = 7.5\n'
    (folder / "s.toml").write_text(f'[study]\nvehicle = "flight.csv"\ntime_s = 52\n{wind}')
    assert tv.load_study("s.toml").vehicle == tv.load_study("flight.csv", 52.0).vehicle
    text = f'[campaign]\nvehicle = "flight.csv"\ntime_s = 52\ncases = 10\n{wind}'
    (folder / "c.toml").write_text(text)
    assert tv.studyfile.load_campaign("c.toml").vehicle == tv.load_schedule("flight.csv").at(52.0)


@pytest.mark.parametrize(
    "command",
    [*sorted({*COMMANDS} - {"nozzle", "margins", "fly"}), "report", "explore", "init --from"],
)
def test_a_schedule_without_a_time_is_refused_with_the_option_that_gives_it(folder, command):
    words = command.split()
    for schedule in ("flight.csv", "flight.toml"):
        result = run(*words, schedule, *(["my.toml"] if words[0] == "init" else []))
        assert result.exit_code == 2
        assert f"{schedule} is a flight schedule" in result.output
        assert "--at TIME" in result.output


def test_what_a_time_of_flight_cannot_be_of_is_refused(folder):
    (folder / "s.toml").write_text('[study]\nvehicle = "flight.csv"\ntime_s = 52\n')
    refused = {
        ("study", "flight.csv", "--at", 70): "must be between 40 and 60 s",
        ("study", "at-52.toml", "--at", 50): "(--set flight.altitude_m M --set flight.specific_imp",
        ("study", "made-up-booster", "--at", 50): "has a structure",
        ("study", "s.toml", "--at", 50): "time_s in its [study]",
        ("fly", "flight.csv", "--at", 52, "--engine", "planar-varying"): "has no table [flight]",
        ("init", "my.toml", "--at", 50): "--at needs --from",
        ("init", "my.toml", "--study", "--from", "flight.csv"): "give --study or --from",
        ("boundary", "--at", 50): "--at needs a vehicle",
        ("report", "--at", 50): "--at needs a flight schedule",
    }
    for given, said in refused.items():
        result = run(*given)
        assert (result.exit_code, said in result.output) == (2, True), result.output
    with pytest.raises(InputError, match="flight schedule"):
        tv.load_vehicle("flight.csv")
    with pytest.raises(InputError, match="flight schedule"):
        tv.vehicle.load_any_vehicle("flight.toml")


def test_the_nominal_flight_of_a_vehicle_has_a_vehicle_at_each_time():
    plan = tv.load_study("configuration-i", 60.0)
    assert plan.vehicle == tv.load_schedule("configuration-i").at(60.0)


FLEXIBLE = """
[study]
vehicle = "flight.csv"
{time}
[schedule]
source = "flight.csv"
structure = "modes.csv"
[size]
from_s = 52
to_s = 53
every_s = 1
[autopilot]
attitude_gain = 1.0
rate_gain_s = 0.8
[wind]
peak_deg = 5
duration_s = 7.5
"""
MODES = """\
time_s,name,frequency_rad_per_s,damping,modal_mass_kg,gimbal_displacement,gimbal_slope_per_m,\
attitude_slope_per_m,rate_slope_per_m
40,first,12,0.005,5e6,1,-0.06,0.026,0.025
60,first,16,0.005,4e6,1,-0.07,0.030,0.027
"""
WITH_ACTUATOR = "".join(
    f"{line},{more}\n"
    for line, more in zip(
        (HEAD + ROWS).splitlines(),
        ("actuator_frequency_rad_per_s,actuator_damping", "12,0.7", "18,0.7"),
        strict=True,
    )
)
"""The flight with an actuator of 15.6 rad/s at 52 s."""


@pytest.mark.thorough
def test_a_single_time_has_structure_and_actuator_of_the_schedule_to_the_last_digit(folder):
    (folder / "modes.csv").write_text(MODES)
    (folder / "flight.csv").write_text(WITH_ACTUATOR)
    flight, time = folder / "flight-study.toml", folder / "study.toml"
    flight.write_text(FLEXIBLE.format(time=""))
    time.write_text(FLEXIBLE.format(time="time_s = 52"))
    sweep = json.loads(run("margins", flight, "--json").stdout)
    result = run("margins", time, "--json")
    single = json.loads(result.stdout)
    note = "the single flight time 52 s, time_s in [study]; --set study.time_s none takes"
    assert note in " ".join(result.stderr.split())
    assert single["flexible"]
    for name, values in sweep["margins"].items():
        if name in single["margins"]:
            assert single["margins"][name] == values[0], name
    assert len(single["bands"]["modes"]) == 1
    (mode,) = tv.load_study(time).vehicle.structure.bending
    assert mode.frequency == pytest.approx(14.4, rel=1e-14)
    for plan in (tv.load_study(time), tv.load_study("flight.csv", 52.0)):
        assert plan.nozzle.actuator.natural_frequency == pytest.approx(15.6, rel=1e-14)
    other = ("--set", "nozzle.actuator_frequency_rad_per_s=30", "--json")
    along, at_time = (json.loads(run("margins", x, *other).stdout) for x in (flight, time))
    common = along["margins"].keys() & at_time["margins"].keys()
    assert common
    for name in common:
        assert at_time["margins"][name] == along["margins"][name][0], name
    assert at_time["margins"] != single["margins"]
    assert "bending 1" in run("poles", time).output
    missed = run("margins", flight, "--set", "criteria.phase_margin_deg=49")
    assert "(NOT MET at 1 of 2 flight times)" in " ".join(missed.output.split())
    time.write_text(FLEXIBLE.format(time="time_s = 52\nrigid = true"))
    assert tv.load_study(time).vehicle.structure is None


def test_a_vehicle_at_a_time_that_is_not_known_cannot_have_the_structure_of_the_schedule(folder):
    (folder / "modes.csv").write_text(MODES)
    for line, message in (("", "needs a time, time_s"), ("time_s = 62", "between 40 and 60 s")):
        (folder / "vehicle.toml").write_text(AT_52.replace("time_s = 52", line))
        study = FLEXIBLE.format(time="").replace("flight.csv", "vehicle.toml", 1)
        (folder / "study.toml").write_text(study)
        with pytest.raises(InputError, match=message):
            tv.load_study(folder / "study.toml")
