"""Structure over the flight: rows by name, what lies between them, and tables that are refused."""

from dataclasses import replace

import numpy as np
import pytest

import tvclin as tv
from tvclin import InputError

HEAD = (
    "time_s,name,frequency_rad_per_s,damping,modal_mass_kg,gimbal_displacement,gimbal_slope_per_m,"
    "attitude_slope_per_m,rate_slope_per_m,tank_displacements,mass_kg,station_m,pendulum_length_m"
)
ROWS = (
    "60,first,10,0.005,5e5,1,-0.06,0.26,0.25,0.3,,,",
    "60,second,14,0.005,2e5,1,-0.09,-0.22,-0.20,0.7,,,",
    "60,lox,,0.01,,,,,,,24000,20,2",
    "80,second,12,0.007,2e5,1,-0.09,-0.20,-0.18,0.7,,,",
    "80,first,16,0.005,4e5,1,-0.07,0.30,0.27,0.1,,,",
    "80,lox,,0.01,,,,,,,20000,18,2.4",
)
FLIGHT = """\
time_s,weight_N,moment_of_inertia_kg_m2,normal_force_slope_N_per_rad,thrust_N,aerodynamic_arm_m,\
control_arm_m,axial_force_N,velocity_m_per_s,attitude_deg,altitude_m,actuator_frequency_rad_per_s,\
actuator_damping,structure
60,1.5e7,2.2e8,6e6,2.5e7,9.4,23.5,8e5,500,48,9e3,24,0.7,modes.csv
80,1.4e7,2.0e8,6e6,2.5e7,9.4,23.5,8e5,650,40,14e3,28,0.7,
"""


def table(folder, rows=ROWS, head=HEAD):
    path = folder / "modes.csv"
    path.write_text("\n".join((head, *rows)) + "\n")
    return path


def test_modes_keep_their_names_where_their_frequencies_cross(tmp_path) -> None:
    made = tv.ascent.load_structure(table(tmp_path))
    assert (made.modes, made.tanks, made.span) == (("first", "second"), ("lox",), (60.0, 80.0))
    now = made.at(75.0)
    assert [mode.frequency for mode in now.bending] == [14.5, 12.5]
    assert now.bending[1].damping == pytest.approx(0.0065, rel=1e-14)
    assert now.bending[0].tank_displacements == (pytest.approx(0.15, rel=1e-14),)
    assert (now.slosh[0].mass, now.slosh[0].pendulum_length) == (21000.0, pytest.approx(2.3))
    assert made.at([60.0, 80.0]).batch == (2,)
    assert made.mode_number("second") == 1


def test_other_units_and_blanks_in_names_say_the_same(tmp_path) -> None:
    want = tv.ascent.load_structure(table(tmp_path)).at(60.0)
    in_hertz = [f"{r.split(',')[0]},lower {','.join(r.split(',')[1:])}" for r in ROWS]
    rows = [
        ",".join(
            f"{float(cell) / (2.0 * np.pi):.17g}" if k == 2 and cell else cell
            for k, cell in enumerate(row.split(","))
        )
        for row in in_hertz
    ]
    head = HEAD.replace("frequency_rad_per_s", "frequency_Hz")
    made = tv.ascent.load_structure(table(tmp_path, rows, head))
    assert made.modes == ("lower first", "lower second")
    got = made.at(60.0)
    for mode, other in zip(got.bending, want.bending, strict=True):
        assert mode.frequency == pytest.approx(other.frequency, rel=1e-14)
        assert mode.rate_slope == other.rate_slope


def test_a_mode_of_the_opposite_sign_is_turned(tmp_path) -> None:
    opposite = "80,first,16,0.005,4e5,-1,0.07,-0.30,-0.27,-0.1,,,"
    made = tv.ascent.load_structure(table(tmp_path, (*ROWS[:4], opposite, ROWS[5])))
    right = tv.ascent.load_structure(table(tmp_path))
    assert made.at(75.0) == right.at(75.0)
    assert made.notes == ("first: the sign of its displacements and slopes is reversed at 80 s",)


def test_a_flight_has_its_structure_and_its_actuator(tmp_path) -> None:
    table(tmp_path)
    (tmp_path / "flight.csv").write_text(FLIGHT)
    flight = tv.load_schedule(tmp_path / "flight.csv")
    vehicle = flight.at(70.0)
    structure = vehicle.structure
    assert [mode.frequency for mode in vehicle.structure.bending] == [13.0, 13.0]
    assert [float(x) for x in flight.actuator_at(70.0)] == [26.0, 0.7]
    assert flight.at([60.0, 70.0, 80.0]).batch == (3,)
    part = flight.between(65.0, 75.0)
    assert part.at(70.0).structure == vehicle.structure
    constant = replace(flight, structure=None, vehicle=replace(flight.vehicle, structure=structure))
    assert constant.between(65.0, 75.0).at(70.0).structure == structure
    assert [float(x) for x in part.actuator_at(75.0)] == [27.0, 0.7]
    assert flight.plants(70.0, "drift-exact", "pitch").structure is None
    plant = tv.FlexiblePlant.from_vehicle(vehicle.rigid, vehicle.structure)
    assert plant.states[3::2] == ("bending_1", "bending_2", "slosh_1")


def test_engine_and_sensors_stand_in_a_schedule_and_its_table_in_a_study(tmp_path) -> None:
    table(tmp_path)
    keys, *rows = (line.split(",")[:-1] for line in FLIGHT.splitlines())
    columns = zip(keys, zip(*rows, strict=True), strict=True)
    lists = "".join(f"{key} = [{', '.join(cells)}]\n" for key, cells in columns)
    sensors = "[sensors]\nrate_gyro_frequency_rad_per_s = 120\n"
    (tmp_path / "flight.toml").write_text(f'[schedule]\nstructure = "modes.csv"\n{lists}{sensors}')
    structure = tv.load_schedule(tmp_path / "flight.toml").at(60.0).structure
    assert structure.rate_gyro == tv.vehicle.Filter.low_pass(120.0)
    assert len(structure.bending) == 2

    (tmp_path / "flight.csv").write_text(
        "\n".join(line.rpartition(",")[0] for line in FLIGHT.splitlines()) + "\n"
    )
    study = tmp_path / "study.toml"
    study.write_text(
        '[study]\nvehicle = "configuration-i"\n[wind]\npeak_deg = 5\nduration_s = 7.5\n'
        '[schedule]\nsource = "flight.csv"\nstructure = "modes.csv"\n'
    )
    sizing = tv.load_study(study).sizing
    assert sizing.schedule.structure.modes == ("first", "second")


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (ROWS[:-1], "lox has no row at 80 s, where others have one"),
        ((*ROWS, ROWS[0]), "line 8: first has two rows at 60 s; keep one"),
        (ROWS[:3], "two or more times; got 1"),
        (("60,first,10,0.005,,,,,,,,,",), "line 2: first must have a modal mass"),
        (("60,lox,,0.01,5,,,,,,24000,20,2",), "and not both"),
        (("60,,10,0.005,5e5,1,0,0,0,,,,",), "line 2: name is missing"),
        (("60,first,x,0.005,5e5,1,0,0,0,,,,",), "frequency_rad_per_s must be a number; got 'x'"),
        (("60,first,10,,5e5,1,0,0,0,,,,",), "a key is missing in .*damping"),
        ((*ROWS[:5], "80,lox,10,0.01,,,,,,,20000,18,"), "must have pendulum_length|frequency"),
    ],
)
def test_tables_that_cannot_be(tmp_path, rows, message) -> None:
    with pytest.raises(InputError, match=message):
        tv.ascent.load_structure(table(tmp_path, rows))


def test_a_structure_that_ends_before_the_flight_is_refused(tmp_path) -> None:
    table(tmp_path, [row.replace("80,", "75,", 1) for row in ROWS])
    (tmp_path / "flight.csv").write_text(FLIGHT)
    with pytest.raises(InputError, match="over the whole flight, 60 to 80 s; got 60 to 75 s"):
        tv.load_schedule(tmp_path / "flight.csv")
