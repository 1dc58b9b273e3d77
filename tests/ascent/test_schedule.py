"""Flight schedules: tables, nominal flights, and what lies between their rows."""

import numpy as np
import pytest

import tvclin as tv
from tvclin import InputError
from tvclin.ascent.nominal_flight import load_flight_condition, nominal_flight
from tvclin.vehicle.vehicle_file import template

CSV = """\
# a flight
time_s, weight_kN, moment_of_inertia_kg_m2, normal_force_slope_N_per_rad, thrust_N, \
aerodynamic_arm_m, control_arm_m, axial_force_N, velocity_m_per_s, attitude_deg, \
nominal_deflection_deg, altitude_m
60, 1500, 2.25e7, 6.0e5, 2.495e6, 9.45, 23.56, 8e4, 500, 48, 0.02, 9e3

70, 1450, 2.25e7, 6.8e5, ,        9.45, 23.56, 8e4, 560, 43, 0.01, 12e3
80, 1400, 2.25e7, 6.1e5, ,        9.45, 23.56, 7e4, 650, 38, 0, 16e3
"""
SPEEDS = {500: 48, 560: 43, 650: 38}
"""Velocities [m/s] and attitudes [deg] of the rows."""
TOML = """
[schedule]
name = "a flight"
time_s = [60, 70, 80]
weight_kN = [1500, 1450, 1400]
moment_of_inertia_kg_m2 = 2.25e7
normal_force_slope_N_per_rad = [6.0e5, 6.8e5, 6.1e5]
thrust_N = 2.495e6
aerodynamic_arm_m = 9.45
control_arm_m = 23.56
axial_force_N = [8e4, 8e4, 7e4]
velocity_m_per_s = [500, 560, 650]
attitude_deg = [48, 43, 38]
nominal_deflection_deg = [0.02, 0.01, 0]
altitude_m = [9e3, 12e3, 16e3]
"""


def read(tmp_path, text: str, name: str) -> tv.FlightSchedule:
    path = tmp_path / name
    path.write_text(text)
    return tv.load_schedule(path)


def test_both_kinds_of_table_say_the_same(tmp_path) -> None:
    rows, lists = read(tmp_path, CSV, "flight.csv"), read(tmp_path, TOML, "flight.toml")

    for schedule in (rows, lists):
        vehicle = schedule.at(65.0)
        assert vehicle.velocity == pytest.approx(530.0, rel=1e-14)
        assert vehicle.weight == pytest.approx(1.475e6, rel=1e-14)
        assert vehicle.attitude == pytest.approx(np.radians(45.5), rel=1e-14)
        assert vehicle.thrust == 2.495e6
        assert schedule.nominal_at(75.0) == pytest.approx(np.radians(0.005))
        assert schedule.span == (60.0, 80.0)
        assert schedule.clamped_at(100.0).velocity == 650.0
        assert schedule.height.tolist() == [9e3, 12e3, 16e3]
    assert lists.vehicle.name == "a flight"
    assert rows.at([60.0, 80.0]).velocity.tolist() == [500.0, 650.0]


def test_headings_with_their_unit_in_brackets_are_the_keys(tmp_path) -> None:
    head = (
        "Time (s), Weight [kN], moment of inertia (kg m^2), Normal force slope (N/rad),"
        " Thrust (MN), Aerodynamic arm (m), control_arm (ft), axial_force_N, Velocity (km/s),"
        " Attitude (°), Nominal deflection (deg), Altitude (km)"
    )
    in_their_units = {"2.495e6": "2.495", "23.56": "77.29658792650919"}
    in_their_units |= {f" {v}, {angle},": f" {v / 1e3}, {angle}," for v, angle in SPEEDS.items()}
    in_their_units |= {f"{height}e3": height for height in ("9", "12", "16")}
    text = CSV.replace(CSV[CSV.index("time_s") : CSV.index("\n60")], head)
    for number, other in in_their_units.items():
        text = text.replace(number, other)
    keys, names = read(tmp_path, CSV, "keys.csv"), read(tmp_path, text, "names.csv")
    for name in ("weight", "moment_of_inertia", "thrust", "control_arm", "velocity", "attitude"):
        expected = getattr(keys.vehicle, name)
        np.testing.assert_allclose(getattr(names.vehicle, name), expected, rtol=1e-14)
    np.testing.assert_allclose(names.height, keys.height, rtol=1e-14)
    np.testing.assert_allclose(names.nominal_deflection, keys.nominal_deflection, rtol=1e-14)


def test_a_damping_over_the_flight_is_read_written_and_read_again(tmp_path) -> None:
    text = TOML + "pitch_damping_N_m_s_per_rad = [6e5, 5e5, 3e5]\n"
    schedule = read(tmp_path, text, "damped.toml")
    assert schedule.at(75.0).pitch_damping == 4e5
    schedule.to_csv(tmp_path / "again.csv")
    again = tv.load_schedule(tmp_path / "again.csv")
    assert again.vehicle.pitch_damping.tolist() == [6e5, 5e5, 3e5]
    read(tmp_path, TOML, "calm.toml").to_csv(tmp_path / "calm.csv")
    assert "damping" not in (tmp_path / "calm.csv").read_text()


def test_a_jet_over_the_flight_knows_the_rate_of_the_inertia_from_the_table(tmp_path) -> None:
    """M_q = m' l_e^2 + I', in which I' = -2e4 kg m^2/s of the straight line, once."""
    falling = TOML.replace("kg_m2 = 2.25e7", "kg_m2 = [2.25e7, 2.23e7, 2.21e7]")
    jet = "jet_mass_flow_kg_per_s = [800, 900, 900]\nexit_arm_m = 24\n"
    computed = read(tmp_path, falling + jet, "jet.toml").vehicle.pitch_damping
    expected = np.array([800.0, 900.0, 900.0]) * 24.0**2 - 2e4
    np.testing.assert_allclose(computed, expected, rtol=1e-12)
    given = read(tmp_path, falling + jet + "inertia_rate_kg_m2_per_s = 0\n", "bound.toml")
    np.testing.assert_allclose(given.vehicle.pitch_damping, expected + 2e4, rtol=1e-14)
    slugs = "jet_mass_flow_lb_per_s = [1760, 1980, 1980]\n"
    in_pounds = read(tmp_path, falling + slugs, "lb.toml").vehicle.pitch_damping[1]
    assert in_pounds == pytest.approx(1980 * 0.45359237 * 23.56**2 - 2e4, rel=1e-12)
    constant = read(tmp_path, TOML + jet, "same.toml").vehicle.pitch_damping
    np.testing.assert_allclose(constant, expected + 2e4, rtol=1e-14)


def test_a_jet_in_a_row_that_is_wrong_names_the_row(tmp_path) -> None:
    jet = "jet_mass_flow_kg_per_s = [800, -1, 900]\n"
    with pytest.raises(InputError, match="row 2: mass_flow must be zero or positive"):
        read(tmp_path, TOML + jet, "jet.toml")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("1450", "heavy", r"line 5: weight_kN must be a number; got 'heavy'"),
        ("1450", "", r"line 5: weight_kN is missing; give it in every line"),
        ("1450", "-3", r"line 5: weight must be positive"),
        ("70,", "60,", r"line 5: time_s must rise; got 60 after 60"),
        ("70,", ",", r"line 5: time_s is missing"),
        (", 43, 0.01", ", 43", r"line 5: there are 12 names and 11 cells"),
        ("weight_kN", "weight_stone", r"line 2: weight_stone has no known unit in the schedule"),
        ("altitude_m", "altitude", r"line 2: altitude has no known unit in the schedule; .*_m or"),
        ("altitude_m", "Altitude (mi)", r"line 2: Altitude \(mi\) has no known .*altitude_m or"),
        ("weight_kN", "time_s", r"every column needs a key of its own; got 'time_s'"),
        ("1450", "1" * 200_000, "line 5: weight_kN must be finite"),
        ("time_s,", "name,", r"line 2: a key is missing in the schedule: time_s"),
        (CSV[CSV.index("70,") :], "", "two or more times; got 1"),
        ("altitude_m", "hight_m", r"line 2: unknown key in the schedule: 'hight_m'"),
        ("altitude_m", "Height (m)", r"line 2: unknown key .*'Height \(m\)'"),
        ("velocity_m_per_s", "speed [m/s]", r"'speed \[m/s\]'; did you mean velocity_m_per_s or"),
        ("weight_kN", "Weight (stone)", r"Weight \(stone\) has no known unit"),
        ("weight_kN", "Weight (stone)", r"line 2: tvclin import table FILE --columns"),
        ("weight_kN", "Time [s]", r"every column needs a key of its own; got 'time_s'"),
        ("velocity_m_per_s", "altitude_ft", r"line 2: a key is missing in the schedule: velocity_"),
        (CSV[CSV.index("time_s") :], "", "no line of keys: time_s.* tvclin import table"),
    ],
)
def test_a_wrong_line_is_named(tmp_path, old, new, words) -> None:
    with pytest.raises(InputError, match=words):
        read(tmp_path, CSV.replace(old, new, 1), "flight.csv")


def test_a_heading_of_a_number_without_a_unit_needs_none(tmp_path) -> None:
    head = (
        "time_s,mass_kg,thrust_kN,moment_of_inertia_kg_m2,control_arm_m,aerodynamic_arm_m,"
        "velocity_m_per_s,attitude_deg,dynamic_pressure_kPa,reference_area_m2,"
        "normal_force_coefficient_slope_per_rad,axial_force_coefficient\n"
    )
    rows = "".join(f"{t},9500,190,1.8e5,8,3,450,60,35,1.131,2.6,0.45\n" for t in (60, 70))
    key = read(tmp_path, head + rows, "key.csv")
    for heading in ("Axial force coefficient", "axial force coefficient [-]"):
        words = head.replace("axial_force_coefficient", heading) + rows
        assert read(tmp_path, words, "words.csv").at(65.0) == key.at(65.0)


def test_all_unknown_and_missing_columns_are_named_at_once(tmp_path) -> None:
    own = CSV.replace("time_s", "time").replace("weight_kN", "weight").replace("altitude_m", "h/m")
    own = own.replace("velocity_m_per_s", "speed_m_per_s").replace("axial_force_N", "drag_N")
    with pytest.raises(InputError) as refused:
        read(tmp_path, own, "flight.csv")
    lines = [line.partition("line 2: ")[2] for line in str(refused.value).split("\n")]
    for line, beginning in zip(
        lines,
        (
            "time has no known unit in the schedule; write time_s",
            "weight has no known unit in the schedule; write weight_N or weight_kN",
            "unknown key in the schedule: 'drag_N'; tvclin init --keys",
            "unknown key in the schedule: 'speed_m_per_s'; did you mean velocity_m_per_s",
            "unknown key in the schedule: 'h/m'; tvclin init --keys",
            "a key is missing in the schedule: axial_force_N or",
            "tvclin import table FILE",
        ),
        strict=True,
    ):
        assert line.startswith(beginning)


def test_the_columns_that_a_message_lists_make_a_flight(tmp_path) -> None:
    with pytest.raises(InputError, match="no line of keys") as refused:
        read(tmp_path, "a,b\n1,2\n2,3\n", "flight.csv")
    keys = str(refused.value).partition("keys: ")[2].partition(", or")[0]
    row = ",1.5e6,2e7,2.5e6,9,23,400,60,9e5,1e5\n"
    assert read(tmp_path, f"{keys}\n0{row}10{row}", "flight.csv").span == (0.0, 10.0)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[1500, 1450, 1400]", "[1500, 1450]", "a value for each of the 3 times"),
        ("[1500, 1450, 1400]", '[1500, "a", 1400]', "row 2: weight_kN must be a number"),
        ("time_s = [60, 70, 80]", "time_s = 60", "needs time_s, a list of times"),
        ("60, 70, 80", "60, 70, 65", "row 3: time_s must rise"),
        ("[0.02, 0.01, 0]", "true", "nominal_deflection_deg must be a number"),
        ("altitude_m", "altitude", "altitude has no known unit in the schedule; write altitude_m"),
        ("[schedule]", "schedule = 3", "must be a table"),
        ("[schedule]", "[schedule", "not valid TOML"),
        ("[schedule]", "[vehicle]\n[schedule]", "nothing beside"),
        ("name =", "nominal_deflection_rad = 0.1\nname =", "given twice"),
    ],
)
def test_a_wrong_list_is_named(tmp_path, old, new, words) -> None:
    text = TOML.replace(old, new, 1)
    if "schedule = 3" in text:
        text = "schedule = 3"
    with pytest.raises(InputError, match=words):
        read(tmp_path, text, "flight.toml")


def test_a_vehicle_has_its_nominal_flight() -> None:
    schedule = tv.load_schedule("configuration-ii", start=75.0, stop=95.0, step=0.25)
    booster = tv.load_vehicle("configuration-ii")
    flight = nominal_flight(
        booster, load_flight_condition("configuration-ii"), start=75.0, stop=95.0
    )

    assert 85.0 in schedule.times
    assert schedule.at(85.0).velocity == booster.velocity
    t = np.array([75.1, 80.77, 94.9])
    exact = flight.vehicle_at(t)
    for name in ("velocity", "normal_force_slope", "weight", "attitude"):
        assert getattr(schedule.at(t), name) == pytest.approx(getattr(exact, name), rel=1e-5)
    assert schedule.nominal_at(t) == pytest.approx(flight.deflection(t), rel=1e-3)
    # as a flight through a sounding sees it
    states = schedule.speed, schedule.flight_path_angle, schedule.height
    assert np.array(states) == pytest.approx(flight.states(schedule.time), rel=1e-12)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({}, "two or more times"),
        ({"time": [1.0]}, "two or more times"),
        ({"time": [1.0, 1.0]}, "must rise; got 1 s after 1 s at index 1"),
        ({"time": [1.0, 2.0], "weight": [[1.0, 2.0]]}, "weight must be one number or one for each"),
    ],
)
def test_what_is_no_schedule_is_refused(configuration_i, fields, words) -> None:
    with pytest.raises(InputError, match=words):
        tv.FlightSchedule(configuration_i.replace(**fields))


def test_a_step_that_makes_too_many_rows_is_refused() -> None:
    with pytest.raises(InputError, match="step must give at most .* rows; got 1e-09 s"):
        tv.load_schedule("configuration-ii", start=75.0, stop=95.0, step=1e-9)


def test_times_outside_are_refused(tmp_path) -> None:
    schedule = read(tmp_path, CSV, "flight.csv")
    with pytest.raises(InputError, match="between 60 and 80 s"):
        schedule.at(81.0)
    with pytest.raises(InputError, match="no table \\[flight\\]"):
        read(tmp_path, template(), "mine.toml")
    with pytest.raises(InputError, match="does not exist; name a flight schedule"):
        tv.load_schedule(tmp_path / "none.csv")


def test_a_schedule_without_altitude_says_so_when_it_is_asked(configuration_i) -> None:
    schedule = tv.FlightSchedule(configuration_i.replace(time=[1.0, 2.0]))
    assert schedule.speed.tolist() == [configuration_i.velocity] * 2
    with pytest.raises(InputError, match="no altitude; give altitude_m"):
        _ = schedule.height


def test_an_altitude_in_kilometres_is_that_in_metres(tmp_path) -> None:
    file = tmp_path / "km.csv"
    tv.load_schedule("configuration-i").to_csv(file)
    lines = file.read_text(encoding="utf-8").splitlines()
    head, *rows = [line.split(",") for line in lines if not line.startswith("#")]
    place = head.index("altitude_m")
    head[place] = "altitude_km"
    for row in rows:
        row[place] = f"{float(row[place]) / 1e3!r}"
    file.write_text("\n".join(",".join(row) for row in (head, *rows)) + "\n", encoding="utf-8")
    read = tv.load_schedule(file)
    np.testing.assert_allclose(read.height, tv.load_schedule("configuration-i").height, rtol=1e-9)
