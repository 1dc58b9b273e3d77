"""Schedules from OpenRocket: check numbers, every way of writing the same, and the notes."""

from __future__ import annotations

import numpy as np
import pytest

import tvclin as tv
from tests.schedules.samples import (
    FIELDS,
    FOLDER,
    HEADER,
    LINES,
    NAMES,
    OPENROCKET,
    changed,
    column,
    kept,
    number_of,
    read,
    same,
    with_column,
    written,
)

G, MILLIBAR, S = 9.80665, 100.0, 0.0165
ROUNDING = 1e-15
"""Of a handful of products in double precision."""


@pytest.fixture(scope="module")
def sample() -> tv.FlightSchedule:
    return read(OPENROCKET)


@pytest.mark.parametrize(
    ("time", "mach", "pressure", "gravity", "mass", "inertia", "speed", "printed", "deflection"),
    [
        (1.0, 0.182353, 1009.77, 1.792, 29.8, 23.2, 62.0, (2.7816, 119.793, 0.02322), 0.0397),
        (3.0, 0.57795, 980.561, 1.736, 27.4, 21.6, 196.503, (27.1816, 134.889, 0.20151), 0.4989),
        (5.0, 0.988169, 922.349, 1.68, 25.0, 20.0, 335.977, (74.8983, 152.4, 0.49146), 1.3171),
    ],
)
def test_coefficients_are_those_worked_out_by_hand(
    sample, time, mach, pressure, gravity, mass, inertia, speed, printed, deflection
) -> None:
    """From the numbers of the row: q = 0.7 p M^2, N = q S C_N,alpha, arms from the nose tip."""
    vehicle = sample.at(time)
    N = 0.7 * pressure * MILLIBAR * mach**2 * S * 2.0
    l_a, l_c, T = gravity - 0.96, 2.95 - gravity, 2400.0
    expected = {
        "weight": mass * G,
        "moment_of_inertia": inertia,
        "normal_force_slope": N,
        "thrust": T,
        "aerodynamic_arm": l_a,
        "control_arm": l_c,
        "velocity": speed,
        "attitude": 84.0 * np.pi / 180.0,
    }
    for name, value in expected.items():
        # stations of up to 3 m are subtracted to arms of 0.7 m: five roundings there, few elsewhere
        assert getattr(vehicle, name) == pytest.approx(value, rel=10 * ROUNDING), name
    assert vehicle.axial_force == pytest.approx(N / 4.0, rel=1e-4)  # C_A = 0.5, four digits printed
    c = tv.Coefficients.from_vehicle(vehicle)
    mu_alpha, mu_delta = N * l_a / inertia, T * l_c / inertia
    assert (mu_alpha, mu_delta, N * l_a / (T * l_c)) == pytest.approx(printed, rel=5e-5, abs=5e-6)
    assert (c.mu_alpha, c.mu_delta) == pytest.approx((mu_alpha, mu_delta), rel=20 * ROUNDING)
    # eq (12), K = 1: y of a triangle on a fixed path, from the residue condition by itself
    wind = tv.TriangularWind(peak=np.radians(3.0), duration=1.5)
    need = tv.boundary_limit(tv.Plant.from_coefficients(c, "fixed-path"), wind, dead_band=1.0)
    assert abs(np.degrees(need.deflection)) == pytest.approx(deflection, abs=5e-5)
    assert abs(np.degrees(need.deflection)) == pytest.approx(
        np.degrees(_held(np.sqrt(mu_alpha), N * l_a / (T * l_c))), rel=1e-9
    )


def _held(beta: float, B: float) -> float:
    """Return the limit of a triangle of 3 deg and 1.5 s, trimmed until trim reaches it: by brentq.

    Where trim is left at the time a with B alpha(a) = limit, what grows is put out if
    integral from a of e^(-beta t) (B alpha(t) - limit) dt = 0.
    """
    from scipy.integrate import quad
    from scipy.optimize import brentq

    peak, tau = np.radians(3.0), 1.5

    def wind(t: float) -> float:
        return peak * max(0.0, 1.0 - abs(2.0 * t / tau - 1.0))

    def left(y: float) -> float:
        a = 0.5 * y * tau
        inside, _ = quad(
            lambda t: np.exp(-beta * (t - a)) * wind(t), a, tau, points=[tau / 2], epsabs=1e-15
        )
        return inside - y * peak / beta

    y = brentq(left, 1e-9, 1.0, xtol=1e-14)
    return float(B * y * peak)


def test_rows_are_those_of_the_powered_free_flight(sample) -> None:
    assert sample.span == (0.5, 5.0)
    assert sample.times.size == 19
    assert any("2 rows before it left out" in note for note in sample.notes)
    assert any("from 5.2 s on" in note for note in sample.notes)


def test_every_column_says_where_it_came_from(sample) -> None:
    for name in (*FIELDS, "time", "altitude"):
        assert any(note.startswith(f"{name}: ") for note in sample.notes), name


def test_a_schedule_written_and_read_again_is_the_same(sample, tmp_path) -> None:
    file = tmp_path / "my.csv"
    sample.to_csv(file)
    text = file.read_text(encoding="utf-8")
    assert "# weight: column Mass (g) times 9.80665 m/s^2\n" in text
    same(tv.load_schedule(file), sample, 1e-11)  # twelve digits are written


def test_an_altitude_above_the_sea_counts_first_and_else_the_ground_is_added(sample, tmp_path):
    site = read(OPENROCKET, ground=160.0)
    np.testing.assert_allclose(site.height, sample.height + 160.0, rtol=ROUNDING)
    lines = changed("Altitude", kept, "Altitude above sea level (m)")
    same(read(written(tmp_path, lines), ground=None), sample, 0.0)
    with pytest.raises(tv.InputError, match=r"above the sea already, in Altitude .*leave ground"):
        read(written(tmp_path, lines), ground=160.0)


IMPERIAL = {
    "Altitude (m)": ("Altitude (ft)", 0.3048),
    "Total velocity (m/s)": ("Total velocity (mph)", 0.44704),
    "Mass (g)": ("Mass (oz)", 28.349523125),
    "Longitudinal moment of inertia (kg·m²)": (
        "Longitudinal moment of inertia (lb·ft²)",
        0.45359237 * 0.3048**2,
    ),
    "CP location (cm)": ("CP location (in)", 2.54),
    "CG location (cm)": ("CG location (ft)", 30.48),
    "Thrust (N)": ("Thrust (lbf)", 4.4482216152605),
    "Reference area (cm²)": ("Reference area (in²)", 6.4516),
    "Air pressure (mbar)": ("Air pressure (psi)", 68.94757293168361),
    "Speed of sound (m/s)": ("Speed of sound (kt)", 1852.0 / 3600.0),
}
"""Their names, and how many of the sample's units they are."""


def test_imperial_units_with_semicolons_and_a_byte_order_mark_are_the_same(sample, tmp_path):
    lines = list(LINES)
    lines[HEADER] = "# " + ";".join(IMPERIAL.get(name, (name,))[0] for name in NAMES)
    factors = [IMPERIAL[name][1] if name in IMPERIAL else 1.0 for name in NAMES]
    for i, line in enumerate(lines):
        if not line.startswith("#"):
            pairs = zip(line.split(","), factors, strict=True)
            lines[i] = ";".join(repr(float(cell) / factor) for cell, factor in pairs)
    same(read(written(tmp_path, lines, "utf-8-sig")), sample, 100 * ROUNDING)


def test_another_inertia_unit_is_a_force_times_length_times_time_squared(sample, tmp_path) -> None:
    """1 lbf ft s^2 = 1 slug ft^2 = 32.174 lb ft^2."""
    factor = 4.4482216152605 * 0.3048
    name = "Longitudinal moment of inertia (lbf·ft·s²)"
    lines = changed("Longitudinal", lambda value, _: repr(value / factor), name)
    same(read(written(tmp_path, lines)), sample, 100 * ROUNDING)
    assert factor == pytest.approx(32.17404855643044 * 0.45359237 * 0.3048**2, rel=1e-14)


@pytest.mark.parametrize("units", ["kg∑m≤ cm≤ ∞ m/s≤ ?", "kg�m� cm� � m/s� ?", "kgm2 cm2 deg m/s "])
def test_mangled_units_are_told_by_their_quantity(sample, tmp_path, units) -> None:
    inertia, area, angle, _, none = units.split(" ")
    swaps = {"kg·m²": inertia, "cm²": area, "(°)": f"({angle})", "(\u200b)": f"({none})"}
    lines = list(LINES)
    for proper, damaged in swaps.items():
        lines[HEADER] = lines[HEADER].replace(proper, damaged)
    result = read(written(tmp_path, lines))
    same(result, sample, 0.0)
    assert any("damaged" in note for note in result.notes) == (inertia != "kgm2")


def test_a_file_of_another_encoding_is_read(sample, tmp_path) -> None:
    lines = [line.replace("\u200b", "?") for line in LINES]
    same(read(written(tmp_path, lines, "cp1252")), sample, 0.0)


@pytest.mark.parametrize("separator", [" ", "\t"])
def test_percent_signs_and_spaces_between_columns_are_read(sample, tmp_path, separator) -> None:
    lines = [
        line.replace("#", "%").replace(",", separator) if i != HEADER else
        "% " + separator.join(NAMES)
        for i, line in enumerate(LINES)
    ]  # fmt: skip
    same(read(written(tmp_path, lines)), sample, 0.0)


def test_a_leading_space_in_the_place_of_the_comment_character_is_read(sample, tmp_path) -> None:
    same(read(written(tmp_path, [line.replace("#", " ") for line in LINES])), sample, 0.0)


def test_symbols_behind_names_are_read(sample, tmp_path) -> None:
    lines = list(LINES)
    for name, symbol in (("Mach number", "M"), ("Thrust", "Fₜ"), ("Mass", "m"), ("Time", "t")):
        lines[HEADER] = lines[HEADER].replace(f"{name} (", f"{name} ({symbol}) (")
    same(read(written(tmp_path, lines)), sample, 0.0)


def test_of_two_rows_at_one_time_the_later_counts(sample, tmp_path) -> None:
    at = number_of("3,")
    first = LINES[at - 1].replace("196.503", "150")
    result = read(written(tmp_path, [*LINES[: at - 1], first, *LINES[at - 1 :]]))
    same(result, sample, 0.0)
    assert any("1 row at the time of the next row" in note for note in result.notes)


def test_rows_before_the_rod_is_cleared_are_left_out(tmp_path) -> None:
    """Where there is a centre of pressure on the rod, the event says when it was left."""
    lines = [line.replace("t=0.42 s", "t=0.8 s") for line in LINES]
    assert read(written(tmp_path, lines)).span == (1.0, 5.0)


def test_the_path_stands_for_an_attitude_that_is_not_there(sample, tmp_path) -> None:
    """Vertical over total velocity is sin 84 deg in the sample, both to 5e-4 m/s."""
    result = read(written(tmp_path, changed("Vertical orient", kept, "Lateral direction (°)")))
    # d(theta) = tan(theta) d(sin)/sin, largest at the lowest speed
    off = np.tan(np.radians(84.0)) * 2 * 5e-4 / 29.944
    np.testing.assert_allclose(result.vehicle.attitude, np.radians(84.0), rtol=0.0, atol=off)
    assert any("that of the path" in note for note in result.notes)


def test_density_gives_the_same_dynamic_pressure_as_pressure(sample, tmp_path) -> None:
    """Rho V^2/2 = 0.7 p M^2 with rho = 1.4 p/a^2, in the digits of the sample's Mach numbers."""
    rows = {line.split(",")[0]: line.split(",") for line in LINES if not line.startswith("#")}
    air = {float(k): 1.4 * float(v[column("Air")]) * 100 / 340.0**2 for k, v in rows.items()}
    lines = changed("Air pressure", lambda _, t: repr(air[t] / 1e3), "Air density (g/cm³)")
    result = read(written(tmp_path, lines))
    # M has six digits, the first of them in the fifth place behind the point: 5e-7/0.088
    np.testing.assert_allclose(
        result.vehicle.normal_force_slope, sample.vehicle.normal_force_slope, rtol=2.2e-5
    )


R = 287.053
"""Of dry air, J/(kg K), with which OpenRocket makes its density."""


@pytest.mark.parametrize(
    ("unit", "factor", "zero"),
    [("K", 1.0, 0.0), ("°C", 1.0, 273.15), ("°F", 5.0 / 9.0, 459.67 * 5.0 / 9.0)],
)
def test_pressure_and_temperature_give_the_dynamic_pressure_of_the_density(
    tmp_path, unit, factor, zero
) -> None:
    """Of air of 216.65 K, where the tool's speed of sound makes 0.7 p M^2 1.4 percent less."""
    T, a = 216.65, 165.77 + 0.606 * 216.65
    lines = with_column(f"Air temperature ({unit})", lambda _: repr((T - zero) / factor))
    result = read(written(tmp_path, lines))
    row = LINES[number_of("3,") - 1].split(",")
    p, V = 100.0 * float(row[column("Air pressure")]), float(row[column("Total velocity")])
    q = p / (R * T) * V**2 / 2
    # the offset of a temperature costs a digit more than the products do
    assert result.at(3.0).normal_force_slope == pytest.approx(q * S * 2.0, rel=20 * ROUNDING)
    assert any(
        "q = p V^2/(2 R T) of column Air pressure (mbar) and" in note for note in result.notes
    )
    assert 0.7 * p * (V / a) ** 2 / q == pytest.approx(1.0 - 0.0134, abs=5e-5)


def test_a_density_of_few_decimals_is_told_and_pressure_with_temperature_counts_first(tmp_path):
    lines = changed("Normal force", lambda *_: "0.001", "Air density (g/cm³)")
    plain = read(written(tmp_path, [line.replace("Air pressure", "Pressure") for line in lines]))
    assert any("3 decimals, 50 percent of it" in note for note in plain.notes)
    lines = with_column("Air temperature (K)", lambda _: "288.15", lines)
    result = read(written(tmp_path, lines))
    assert not any("decimals" in note for note in result.notes)
    assert any("p V^2/(2 R T)" in note for note in result.notes)


@pytest.mark.parametrize("decimals", [repr, lambda x: f"{x:.6e}"])
def test_decimal_commas_between_semicolons_are_decimal_points(tmp_path, decimals) -> None:
    lines, commas = list(LINES), list(LINES)
    for i, line in enumerate(LINES):
        if line.startswith("#"):
            commas[i] = line.replace(",", ";")
        else:
            lines[i] = ",".join(decimals(float(cell)) for cell in line.split(","))
            commas[i] = lines[i].replace(",", ";").replace(".", ",")
    expected = read(written(tmp_path, lines))
    same(read(written(tmp_path, commas, "utf-8-sig")), expected, 0.0)


def test_its_own_slope_is_read_where_it_is_there(sample, tmp_path) -> None:
    name = "Normal force coefficient derivative (CN\u03b1) (\u200b)"
    lines = changed("Normal force", lambda *_: 2.0, name)
    file = written(tmp_path, lines)
    same(read(file, normal_force_coefficient_slope=None), sample, ROUNDING)
    twice = read(file, normal_force_coefficient_slope=4.0)
    np.testing.assert_allclose(
        twice.vehicle.normal_force_slope, 2.0 * sample.vehicle.normal_force_slope, rtol=ROUNDING
    )


@pytest.mark.parametrize("table", ["rasaero-aerodynamics.csv", "component-analysis.csv"])
def test_slopes_over_mach_come_from_other_tables(sample, table) -> None:
    """Both hold 2 per rad at zero angle; the secant to 4 deg of the first is 2.42."""
    result = read(OPENROCKET, normal_force_coefficient_slope=FOLDER / table)
    same(result, sample, 1e-7)  # seven digits are written
    assert any(table in note for note in result.notes)


def test_slopes_over_mach_are_straight_between_and_held_only_at_low_speed(sample) -> None:
    mach, slope = [0.2, 1.2], [2.0, 4.0]
    result = read(OPENROCKET, normal_force_coefficient_slope=(mach, slope))
    ratio = result.at(3.0).normal_force_slope / sample.at(3.0).normal_force_slope
    assert ratio == pytest.approx((2.0 + 2.0 * (0.57795 - 0.2)) / 2.0, rel=10 * ROUNDING)
    assert result.at(0.5).normal_force_slope == pytest.approx(
        sample.at(0.5).normal_force_slope, rel=10 * ROUNDING
    )
    for short in ([0.2, 0.9], [0.4, 1.2]):
        with pytest.raises(tv.InputError, match=r"must cover the flight, Mach 0\.0881 to 0\.988"):
            read(OPENROCKET, normal_force_coefficient_slope=(short, slope))


def test_a_slope_on_another_area_counts_on_that(sample) -> None:
    result = read(OPENROCKET, reference_area=0.02)
    np.testing.assert_allclose(
        result.vehicle.normal_force_slope,
        sample.vehicle.normal_force_slope * 0.02 / 0.0165,
        rtol=10 * ROUNDING,
    )
    np.testing.assert_array_equal(result.vehicle.axial_force, sample.vehicle.axial_force)
    assert any("S = 0.02 m^2 as given (the file has 0.0165)" in note for note in result.notes)


def test_a_centre_of_pressure_ahead_of_the_nose_is_legal(tmp_path) -> None:
    result = read(written(tmp_path, changed("CP location", lambda x, _: x - 100.0)))
    assert result.at(3.0).aerodynamic_arm == pytest.approx(1.736 + 0.04, rel=10 * ROUNDING)


def test_a_stable_rocket_is_told(tmp_path) -> None:
    result = read(written(tmp_path, changed("CP location", lambda x, _: x + 150.0)))
    assert result.at(3.0).aerodynamic_arm == pytest.approx(1.736 - 2.46, rel=10 * ROUNDING)
    assert any("stable throughout" in note and "fins?" in note for note in result.notes)
    some = read(written(tmp_path, changed("CP location", lambda x, _: x + 78.0)))
    assert any(note.startswith("stable at 9 of 19 times") for note in some.notes)


def test_wind_in_the_simulation_is_told(tmp_path) -> None:
    result = read(written(tmp_path, changed("Speed of sound", lambda x, _: 1.03 * x)))
    assert any("has wind" in note and "3 percent" in note for note in result.notes)
    assert not any("has wind" in note for note in read(OPENROCKET).notes)


def test_an_inertia_of_few_decimals_and_a_damping_column_are_told(tmp_path) -> None:
    lines = changed("Longitudinal", lambda x, _: f"{0.0001 * x:.3f}")
    lines[HEADER] = lines[HEADER].replace("Normal force coeff", "Pitch damping coeff")
    for i, line in enumerate(lines):  # a small rocket: mass and thrust by the same part
        if not line.startswith("#"):
            cells = line.split(",")
            for name in ("Mass", "Thrust"):
                cells[column(name)] = str(1e-4 * float(cells[column(name)]))
            lines[i] = ",".join(cells)
    notes = read(written(tmp_path, lines)).notes
    assert any("written with 3 decimals, 25 percent of it" in note for note in notes)
    assert any("not read: column Pitch damping coefficient" in note for note in notes)


DAMPING = "Damping moment coefficient (kg·m²/s)"


def test_the_damping_of_the_file_is_that_of_the_vehicle(tmp_path) -> None:
    result = read(written(tmp_path, changed("Normal force", lambda _, t: 20.0 + t, DAMPING)))
    assert result.at(3.0).pitch_damping == pytest.approx(23.0, rel=ROUNDING)
    assert any("the damping is that of column Damping" in note for note in result.notes)
    assert not any("mostly less" in note for note in result.notes)
    damping = tv.Coefficients.from_vehicle(result.at(3.0)).damping
    assert damping == pytest.approx(23.0 / 21.6, rel=10 * ROUNDING)
    assert not np.any(read(OPENROCKET).vehicle.pitch_damping)


@pytest.mark.parametrize("part", ["", " part"])
def test_the_damping_is_the_whole_and_not_one_of_its_parts(tmp_path, part) -> None:
    """A newer file has all three; one that has only parts has no damping that could be used."""
    lines = with_column(f"Damping moment coefficient (aerodynamic{part}) (kg·m²/s)", lambda _: "21")
    lines = with_column(
        f"Damping moment coefficient (propulsive{part}) (kg·m²/s)", lambda _: "2", lines
    )
    parts = read(written(tmp_path, lines))
    assert not np.any(parts.vehicle.pitch_damping)
    assert sum("a part of the damping" in note for note in parts.notes) == 2
    for name in (DAMPING, "Damping moment coefficient (Cdm) (kg·m²/s)"):
        result = read(written(tmp_path, with_column(name, lambda _: "23", lines)))
        assert np.all(result.vehicle.pitch_damping == 23.0)
        assert not any("a part of" in note for note in result.notes)
        again = [*lines[:HEADER], *with_column(name, lambda _: "23", lines)[HEADER:]]
        twice = read(written(tmp_path, with_column(name, lambda _: "23", again)))
        assert not np.any(twice.vehicle.pitch_damping)
        assert any("Damping moment coefficient is there 2 times" in note for note in twice.notes)


def test_a_damping_of_the_wrong_sign_is_left_out_and_one_below_the_jets_doubted(tmp_path) -> None:
    """The jet alone has 1.2 kg/s times (2.95 - 1.74)^2 m^2, some 1.8 kg m^2/s."""
    lines = changed("Normal force", lambda _, t: 2.0 - t, DAMPING)
    result = read(written(tmp_path, lines))
    assert not np.any(result.vehicle.pitch_damping)
    assert any("negative at 5 s" in note and "August 2026" in note for note in result.notes)
    lines = changed("Normal force", lambda *_: 1.0, DAMPING)
    result = read(written(tmp_path, lines))
    assert np.all(result.vehicle.pitch_damping == 1.0)
    assert any("mostly less than that of the jet alone" in note for note in result.notes)


def test_many_rows_are_thinned_to_straight_lines_within_a_thousandth(tmp_path) -> None:
    at = [i for i, line in enumerate(LINES) if not line.startswith("#")]
    rows = np.array([[float(x) for x in LINES[i].split(",")] for i in at])
    fine = np.arange(0.5, 5.0001, 0.01)
    kept_rows = np.column_stack([np.interp(fine, rows[:21, 0], c) for c in rows[:21].T])
    kept_rows[:, column("CP")] = 96.0
    body = [",".join(f"{x:.12g}" for x in row) for row in kept_rows]
    file = written(tmp_path, [*LINES[: HEADER + 1], *body])
    whole, thin, few = (read(file, max_rows=n) for n in (1000, 200, 5))
    assert whole.times.size == fine.size
    assert thin.times.size <= 200
    assert few.times.size == 5
    for name in FIELDS:
        exact = np.asarray(getattr(whole.vehicle, name))
        line = np.interp(whole.times, thin.times, getattr(thin.vehicle, name))
        assert np.abs(line - exact).max() <= 1e-3 * np.abs(exact).max(), name
    assert any(note.startswith("thinned to") for note in thin.notes)


def test_one_stage_of_two_is_read_by_its_times(tmp_path) -> None:
    lines = changed("Mass", lambda x, t: x + 20e3 * (t < 2.9))
    result = read(written(tmp_path, lines), start=3.0)
    assert result.span == (3.0, 5.0)
    assert read(written(tmp_path, lines), stop=2.8).span == (0.5, 2.75)


def test_the_schedule_can_be_sized() -> None:
    result = read(OPENROCKET)
    wind = tv.TriangularWind(peak=np.radians(3.0), duration=0.5)
    need = tv.size(result, wind, times=[3.0], model="fixed-path", dead_bands=1.0)
    assert 0.0 < np.degrees(need.required["K = 1"][0, 0]) < 0.6046  # 3 deg times B = 0.20151
