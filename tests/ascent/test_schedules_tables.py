"""Schedules from RASAero II and mapped tables, against the same flight written by OpenRocket."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tvclin as tv
from tests.schedules.samples import FOLDER, MAP, OPENROCKET, read
from tvclin.ascent.importers.column_map import QUANTITIES
from tvclin.base.units import UNITS, WRITTEN, unit_of

FLIGHT, AERODYNAMICS = FOLDER / "rasaero-flight.csv", FOLDER / "rasaero-aerodynamics.csv"
ASKED: dict[str, Any] = {
    "gimbal_station": 2.95,
    "moment_of_inertia": ([0.0, 5.0], [24.0, 20.0]),
    "normal_force_coefficient_slope": AERODYNAMICS,
    "ground": 0.0,
}
FIELDS = (
    *("weight", "moment_of_inertia", "normal_force_slope", "thrust", "aerodynamic_arm"),
    *("control_arm", "axial_force", "velocity", "attitude"),
)


def test_rasaero_gives_what_openrocket_gives_for_the_same_flight() -> None:
    """In pounds of force, inches and feet; q S as drag over its coefficient."""
    computed, other = tv.ascent.read_rasaero(FLIGHT, **ASKED), read(OPENROCKET)
    assert computed.span == (0.2, 5.0)  # it knows a centre of pressure on the rail
    for name in FIELDS:
        one = np.asarray(getattr(computed.vehicle, name))[1:]
        # seven digits in either file; six in the Mach number, squared, of the other's q
        np.testing.assert_allclose(one, getattr(other.vehicle, name), rtol=2e-5, err_msg=name)
    np.testing.assert_allclose(computed.height[1:], other.height, rtol=5e-7)  # seven digits of feet


def test_a_secant_over_four_degrees_is_not_the_slope_at_zero() -> None:
    """The column of that name holds 2.419 per rad; 2 per rad is the slope."""
    exact = tv.ascent.read_rasaero(FLIGHT, **(ASKED | {"normal_force_coefficient_slope": 2.0}))
    result = tv.ascent.read_rasaero(FLIGHT, **ASKED)
    np.testing.assert_allclose(
        result.vehicle.normal_force_slope, exact.vehicle.normal_force_slope, rtol=1e-6
    )


def test_the_inertia_is_straight_between_its_times_and_held_beyond() -> None:
    given = {"moment_of_inertia": ([1.0, 3.0], [24.0, 20.0])}
    result = tv.ascent.read_rasaero(FLIGHT, **(ASKED | given))
    assert [result.at(t).moment_of_inertia for t in (0.5, 2.0, 5.0)] == [24.0, 22.0, 20.0]
    assert any("given at 2 times from 1 to 3 s" in note for note in result.notes)


def test_a_unit_behind_the_name_of_a_column_is_its_unit(tmp_path) -> None:
    """The longest one: the column of the velocity, V_m_per_s, is not in seconds."""
    table = (FOLDER / "table.csv").read_text()
    for given, other in {"t (s)": "t_s", "T (kN)": "T_kN", "V (m/s)": "V_m_per_s"}.items():
        assert given in table
        table = table.replace(given, other)
    (tmp_path / "table.csv").write_text(table)
    others = {"time": "t_s", "thrust": "T_kN", "velocity": "V_m_per_s"}
    result = tv.ascent.read_table(tmp_path / "table.csv", MAP | others)
    expected = tv.ascent.read_table(FOLDER / "table.csv", MAP)
    assert result.span == expected.span
    for name in FIELDS:
        one, other = (getattr(schedule.vehicle, name) for schedule in (result, expected))
        np.testing.assert_array_equal(one, other, err_msg=name)


def test_a_map_may_name_the_damping() -> None:
    schedule = tv.ascent.read_table(
        FOLDER / "table.csv", MAP | {"pitch_damping_lbf_ft_s_per_rad": 30.0}
    )
    assert schedule.at(3.0).pitch_damping == pytest.approx(30.0 * 4.4482216152605 * 0.3048)
    assert any("pitch_damping: given" in note for note in schedule.notes)


def test_a_map_gives_what_openrocket_gives_for_the_same_flight() -> None:
    computed, other = tv.ascent.read_table(FOLDER / "table.csv", MAP), read(OPENROCKET)
    for t in (1.0, 3.0, 5.0):
        one, same = computed.at(t), other.at(t)
        for name in FIELDS:
            if name != "axial_force":
                expected = getattr(same, name)
                # the slope is written with six digits
                assert getattr(one, name) == pytest.approx(expected, rel=2e-6), name
        assert one.axial_force == 190.0


def test_coefficients_and_arms_may_be_mapped(tmp_path: Path) -> None:
    """N = q S C_N,alpha with 47.88 Pa to the psf and 57.3 deg to the rad."""
    file = tmp_path / "post.txt"
    file.write_text(
        "made up\nTIME GAMMA WEIGHT QBAR\n1 1.2 300 100\n2 1.1 290 200\n3 1.0 280 300\n"
    )
    schedule = tv.ascent.read_table(
        file,
        {
            "time_s": "TIME",
            "attitude_rad": "GAMMA",
            "weight_lbf": "WEIGHT",
            "dynamic_pressure_psf": "QBAR",
            "reference_area_m2": 0.5,
            "normal_force_coefficient_slope_per_deg": 0.05,
            "axial_force_coefficient": 0.4,
            "thrust_kN": 4.0,
            "moment_of_inertia_kg_m2": 100.0,
            "control_arm_m": 2.0,
            "aerodynamic_arm_m": 1.0,
            "velocity_m_per_s": 100.0,
            "altitude_ft": 5000.0,
            "nominal_deflection_deg": 0.1,
        },
    )
    q = 200.0 * 4.4482216152605 / 0.3048**2
    vehicle = schedule.at(2.0)
    assert vehicle.normal_force_slope == pytest.approx(q * 0.5 * 0.05 * 180 / np.pi, rel=1e-14)
    assert vehicle.axial_force == pytest.approx(q * 0.5 * 0.4, rel=1e-14)
    assert vehicle.weight == pytest.approx(290.0 * 4.4482216152605, rel=1e-14)
    assert schedule.height[0] == pytest.approx(1524.0, rel=1e-14)
    assert schedule.nominal_at(2.0) == pytest.approx(np.radians(0.1), rel=1e-14)
    written = tmp_path / "my.csv"
    schedule.to_csv(written)
    again = tv.load_schedule(written)
    assert again.nominal_at(2.0) == pytest.approx(np.radians(0.1), rel=1e-11)


def test_a_mapped_coefficient_is_not_taken_for_its_slope(tmp_path: Path) -> None:
    file = tmp_path / "flight.csv"
    file.write_text("t (s),q (Pa),CN,CN_alpha\n1,1000,0.1,2\n2,2000,0.1,2\n")
    rest = {k: v for k, v in MAP.items() if not isinstance(v, str)}
    rest |= {"time": "t (s)", "dynamic_pressure": "q (Pa)", "reference_area_m2": 0.0165}
    rest |= {"mass_kg": 25.0, "moment_of_inertia_kg_m2": 20.0, "thrust_N": 2400.0}
    rest |= {"gravity_station_m": 1.7, "velocity_m_per_s": 60.0}
    slope = "normal_force_coefficient_slope_per_rad"
    with pytest.raises(tv.InputError, match="CN is a coefficient and not its slope"):
        tv.ascent.read_table(file, rest | {slope: "CN"})
    schedule = tv.ascent.read_table(file, rest | {slope: "CN_alpha"})
    assert schedule.at(1.0).normal_force_slope == pytest.approx(1000 * 0.0165 * 2, rel=1e-15)


def test_an_angle_of_attack_that_is_mapped_is_looked_at(tmp_path: Path) -> None:
    with pytest.raises(tv.InputError, match="the angle of attack is 3 deg at 1 s"):
        tv.ascent.read_table(FOLDER / "table.csv", MAP | {"angle_of_attack_deg": 3.0})


def test_pounds_of_force_are_not_read_as_newtons(tmp_path: Path) -> None:
    """Of weight and thrust alike, so that their ratio looks right."""
    text = (FOLDER / "table.csv").read_text().replace("T (kN)", "T (lb)").replace(";2.4;", ";540;")
    path = tmp_path / "pounds.csv"
    path.write_text(text)
    names = {key: name for key, name in MAP.items() if not key.startswith("thrust")}
    with pytest.raises(tv.InputError, match=r"T \(lb\) is not in the unit of thrust_N"):
        tv.ascent.read_table(path, names | {"thrust_N": "T (lb)"})
    schedule = tv.ascent.read_table(path, names | {"thrust_lbf": "T (lb)"})
    assert schedule.at(3.0).thrust == pytest.approx(540 * 4.4482216152605, rel=1e-12)


@pytest.mark.parametrize("mark", ["(kft)", "[kft]", "(zenith)", "(m/s)", "(°)"])
@pytest.mark.parametrize("key", ["altitude_ft", "altitude"])
def test_a_unit_that_is_not_known_is_refused_with_those_that_are(tmp_path, mark, key) -> None:
    path = tmp_path / "flight.csv"
    path.write_text(_with_column(f"h {mark}", 40.0), encoding="utf-8")
    with pytest.raises(tv.InputError, match="is not known; .*m, km, ft, in, mm, cm") as error:
        tv.ascent.read_table(path, MAP | {key: f"h {mark}"})
    assert "\n" not in str(error.value)
    assert f"h {mark}" in str(error.value)


def test_units_in_brackets_are_units(tmp_path: Path) -> None:
    path = tmp_path / "flight.csv"
    path.write_text(_with_column("h [ft]", 40.0))
    for key in ("altitude", "altitude_ft"):
        schedule = tv.ascent.read_table(path, MAP | {key: "h [ft]"})
        np.testing.assert_allclose(schedule.height, 40.0 * 0.3048, rtol=1e-15)
    with pytest.raises(tv.InputError, match=r"h \[ft\] is not in the unit of altitude_m"):
        tv.ascent.read_table(path, MAP | {"altitude_m": "h [ft]"})


def test_every_unit_of_our_names_is_known_behind_theirs(tmp_path: Path) -> None:
    """A column in the very unit of the key is never refused."""
    for unit, factor in UNITS["force"].items():
        path = tmp_path / "flight.csv"
        text = (FOLDER / "table.csv").read_text().replace("T (kN)", f"T ({unit})")
        path.write_text(text.replace(";2.4;", f";{2400.0 / factor!r};"))
        names = {key: name for key, name in MAP.items() if key != "thrust"}
        schedule = tv.ascent.read_table(path, names | {f"thrust_{unit}": f"T ({unit})"})
        assert schedule.at(3.0).thrust == pytest.approx(2400.0, rel=1e-14)
    for kind in set(QUANTITIES.values()) - {"number"}:
        for unit, factor in UNITS[kind].items():
            written = unit.replace("_per_", "/").replace("per_", "1/").replace("_", " ")
            assert unit_of(written, WRITTEN[kind]).factor == pytest.approx(factor), (kind, unit)


@pytest.mark.parametrize("kind", WRITTEN)
def test_a_damaged_unit_is_itself_or_none(kind: str) -> None:
    """Never another one of its quantity, whatever the encoding has made of its signs."""
    known = WRITTEN[kind]
    for unit, factor in known.items():
        for mark in ("?", "\ufffd", "≤", "", " "):
            damaged = "".join(c if c.isascii() else mark for c in unit)
            result = unit_of(damaged, known)
            assert result is None or result.factor == pytest.approx(factor), (unit, damaged)


def _with_column(name: str, value: float) -> str:
    title, header, *rows = (FOLDER / "table.csv").read_text().splitlines()
    return "\n".join([title, f"{header};{name}", *(f"{row};{value:g}" for row in rows)]) + "\n"


TRAPS: dict[str, tuple[str, str, dict[str, Any], str]] = {
    "a column twice": (";N;", ";T (kN);", {}, r"'T \(kN\)' is there 2 times; keep one"),
    "decimal commas": ("77.564", "77,564", {}, "line 3: numbers have decimal commas"),
    "a number lost": ("27.4;", "NaN;", {}, "line 5: there is no number in column m"),
    "time falls": ("\n4;", "\n2.5;", {}, "line 6: the time must rise; got 2.5 s after 3 s"),
    "g for kg": (r"m (kg)", "m (t)", {}, "thrust over weight must be between"),
    "two stages": ("27.4;", "7.4;", {}, "line 5: the mass falls from 28.6 to 7.4 kg, .* a stage"),
    "kg cm^2 for kg m^2": ("Iyy (kg m2)", "Iyy (kg cm2)", {}, "radius of gyration"),
    "gimbal in cm": ("", "", {"gimbal_station_m": 295.0}, r"got 295 m \(is it in cm"),
    "gimbal ahead": ("", "", {"gimbal_station_m": 1.0}, "must lie behind the centre of gravity"),
}


@pytest.mark.parametrize("what", TRAPS)
def test_what_is_silently_wrong_is_refused_in_mapped_tables_too(tmp_path, what) -> None:
    old, new, names, said = TRAPS[what]
    path, columns = tmp_path / "flight.csv", MAP | names
    path.write_text((FOLDER / "table.csv").read_text().replace(old, new) if old else _plain())
    for key, name in columns.items():
        if old and name == old:
            columns[key] = new
    with pytest.raises(tv.InputError, match=said):
        tv.ascent.read_table(path, columns)


def _plain() -> str:
    return (FOLDER / "table.csv").read_text()


def test_marks_and_repeated_times_of_mapped_tables_are_read(tmp_path: Path) -> None:
    """A byte order mark, a comment's sign before the names, and the later of two rows at a time."""
    path = tmp_path / "flight.csv"
    lines = _plain().splitlines()
    lines[1] = f"# {lines[1]}"
    lines.insert(4, lines[4].replace("756.601", "1"))
    path.write_text("\n".join(lines), encoding="utf-8-sig")
    computed, plain = (
        tv.ascent.read_table(path, MAP),
        tv.ascent.read_table(FOLDER / "table.csv", MAP),
    )
    np.testing.assert_array_equal(
        computed.vehicle.normal_force_slope, plain.vehicle.normal_force_slope
    )


def test_a_slope_per_degree_is_asked_about_in_mapped_tables(tmp_path: Path) -> None:
    names = {key: name for key, name in MAP.items() if key != "normal_force_slope_N_per_rad"}
    names |= {"dynamic_pressure_Pa": "N", "reference_area_m2": 0.0165}
    for slope, said in ((0.035, "or per degree"), (114.6, "turned from degrees twice")):
        with pytest.raises(tv.InputError, match=said):
            tv.ascent.read_table(
                FOLDER / "table.csv", names | {"normal_force_coefficient_slope_per_rad": slope}
            )


@pytest.mark.parametrize(
    ("called", "value", "said"),
    [
        ("Weight (lb)", lambda x, t: x + 900.0 * (t < 2.9), "a stage leaves"),
        ("Angle of Attack (deg)", lambda _, t: 3.0 * (t > 2.9), "the angle of attack is 3 deg"),
        ("Pitch Attitude (deg)", lambda x, _: 90.0 - x, "check that the attitude is not from the"),
        ("Thrust (lb)", lambda *_: 0.0, "has no thrust"),
    ],
)
def test_what_is_silently_wrong_is_refused_in_rasaero_too(tmp_path, called, value, said) -> None:
    header, *rows = FLIGHT.read_text().splitlines()
    names = header.split(",")
    index, lines = names.index(called), [header]
    for row in rows:
        cells = row.split(",")
        cells[index] = repr(float(value(float(cells[index]), float(cells[0]))))
        lines.append(",".join(cells))
    path = tmp_path / "flight.csv"
    path.write_text("\n".join(lines))
    with pytest.raises(tv.InputError, match=said):
        tv.ascent.read_rasaero(path, **ASKED)


def test_a_dynamic_pressure_against_speed_and_altitude_is_noted(tmp_path: Path) -> None:
    """0.5 rho V^2 in the standard atmosphere, with the printed density of 10 km, 0.41351 kg/m^3."""
    q = 0.5 * 0.41351 * 300.0**2
    head = "time_s,weight_N,moment_of_inertia_kg_m2,thrust_N,aerodynamic_arm_m,control_arm_m"
    head += ",axial_force_coefficient,velocity_m_per_s,attitude_deg,dynamic_pressure_Pa"
    head += ",reference_area_m2,normal_force_coefficient_slope_per_rad,altitude_m"
    file = tmp_path / "flight.csv"
    doubts = {1.05: None, 1.15: "the altitude, from the sea, or the speed", 1e-3: "a unit may be"}
    for ratio, doubt in doubts.items():
        row = f"1.5e6,2e7,2.5e6,9,23,0.3,300,60,{ratio * q},20,3,10000"
        file.write_text(f"{head}\n10,{row}\n20,{row}\n")
        notes = tv.load_schedule(file).notes
        said = [note for note in notes if "in the standard atmosphere:" in note]
        assert len(said) == (doubt is not None)
        assert all(f"atmosphere: {doubt}" in note for note in said)
    names = {key: name for key, name in MAP.items() if key != "normal_force_slope_N_per_rad"}
    names |= {"dynamic_pressure_Pa": 1e5, "altitude_m": 10e3, "reference_area_m2": 0.0165}
    slope = {"normal_force_coefficient_slope_per_rad": 3.0}
    notes = tv.ascent.read_table(FOLDER / "table.csv", names | slope).notes
    assert any("in the standard atmosphere: a unit may be wrong" in note for note in notes)
