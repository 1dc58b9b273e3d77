"""Tables of winds as other programs write them: heads, units, separators, encodings and gaps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import tvclin as tv
from tests.archives import Balloon, jet
from tvclin.winds.wind_file import wind_of

KNOT, FOOT, MILE = 1852 / 3600, 0.3048, 1609.344
HEAD = "Altitude (m),Wind Speed (m/s),Wind Direction (deg)"
ROWS = ((0.0, 3.0, 270.0), (3000.0, 12.0, 280.0))


def read(folder: Path, text: str, *given, encoding: str = "utf-8", **named) -> tv.WindProfile:
    path = folder / "wind.csv"
    path.write_bytes(text.encode(encoding))
    return tv.read_sounding(path, *given, **named)


def written(rows=ROWS, separator: str = ",", comma: str = ".") -> str:
    lines = [separator.join(f"{x:g}".replace(".", comma) for x in row) for row in rows]
    return "\n".join(["", *lines, ""])


def holds(profile: tv.WindProfile, rows=ROWS, length: float = 1.0, speed: float = 1.0) -> None:
    """Assert the heights, and the wind that comes from the direction of each row."""
    height, size, direction = np.array(rows).T
    np.testing.assert_allclose(profile.height, length * height, rtol=1e-14)
    angle = np.radians(direction + 180.0)
    np.testing.assert_allclose(profile.east, speed * size * np.sin(angle), rtol=1e-13)
    np.testing.assert_allclose(profile.north, speed * size * np.cos(angle), atol=1e-13)


@pytest.mark.parametrize(
    ("head", "length", "speed"),
    [
        ("Altitude (m),Wind Speed (m/s),Wind Direction (°)", 1, 1),
        ("Altitude MSL (m),Wind Speed (m/s),Wind Direction (deg)", 1, 1),
        ("Altitude (m),Wind speed (kn),Wind Direction (deg)", 1, KNOT),
        ("Altitude (feet),Wind speed (kts),Wind Direction (deg)", FOOT, KNOT),
        ("Height [m a.s.l.],Speed [m s-1],Direction [° true]", 1, 1),
        ("Height above mean sea level (km),Wind Speed (m s⁻¹),Dir (degrees)", 1000, 1),
        ("alt_ft,wind_speed_mph,wind_dir_deg", FOOT, MILE / 3600),
        ("Altitude (metres),WSPD (m/sec),WDIR (º)", 1, 1),
        ("altitude ft msl,wind speed kph,wind direction deg", FOOT, 1 / 3.6),
        ("height_m,speed_km_per_h,direction_deg", 1, 1 / 3.6),
        ("Height (m),Speed (ft/sec),Direction (deg)", 1, FOOT),
        ("Height (m),Speed (knots),Direction from (deg)", 1, KNOT),
    ],
)
def test_usual_units_and_qualifiers_of_heads_are_known(tmp_path, head, length, speed) -> None:
    rows = tuple((h / length if length == 1000 else h, s, d) for h, s, d in ROWS)
    holds(read(tmp_path, head + written(rows)), rows, length, speed)


@pytest.mark.parametrize("head", ["Altitude AGL (m)", "Height (m AGL)", "Height above ground (m)"])
def test_heights_above_the_ground_are_refused_by_that_name_and_read_with_the_site(tmp_path, head):
    text = f"{head},Wind Speed (m/s),Wind Direction (deg)" + written()
    with pytest.raises(tv.InputError, match=r"line 1: .* is above the ground \(AGL\).*above_gr"):
        read(tmp_path, text)
    profile = read(tmp_path, text, above_ground=160.0)
    holds(profile, [(h + 160.0, s, d) for h, s, d in ROWS])
    assert any("at 160 m" in note for note in profile.notes)
    both = f"Altitude MSL (m),{text}".replace("\n0,", "\n160,0,").replace("\n3000", "\n3160,3000")
    holds(read(tmp_path, both), [(h + 160.0, s, d) for h, s, d in ROWS])
    for wrong in (both, text.replace(head, "Altitude MSL (m)")):
        with pytest.raises(tv.InputError, match="leave above_ground out"):
            read(tmp_path, wrong, above_ground=160.0)


def test_the_head_is_the_line_that_fits_best_and_metadata_above_it_are_told(tmp_path) -> None:
    """Not the first line that names an altitude."""
    rows = ((1450.0, 3.0, 270.0), (4500.0, 14.0, 280.0))
    text = (
        "Altitude,1450\nLatitude,32.99\nTime (s),Height (m),Wind Speed (m/s),Wind Direction (deg)\n"
        "0,1450,3,270\n600,4500,14,280\n"
    )
    profile = read(tmp_path, text)
    holds(profile, rows)
    assert profile.notes == (
        "2 lines above the names of columns skipped, the first 'Altitude,1450'",
    )
    prose = "Altitude, speed and direction of the wind above the pad\nheight speed direction\n"
    holds(read(tmp_path, prose + text), rows)


@pytest.mark.parametrize("separator", [";", "\t"])
def test_decimal_commas_between_semicolons_and_tabs_are_read(tmp_path, separator) -> None:
    rows = ((0.0, 3.2, 270.0), (500.5, 6.1, 275.0), (3000.0, 12.4, 280.0))
    head = separator.join(["height_m", "speed_m_per_s", "direction_deg"])
    holds(read(tmp_path, head + written(rows, separator, ",")), rows)


def test_commas_that_may_be_of_thousands_are_refused(tmp_path) -> None:
    """2,500 m is 2.5 m or 2500 m."""
    text = "height_m;speed_m_per_s;direction_deg\n0;5;270\n2,500;6;270\n"
    with pytest.raises(tv.InputError, match="line 3: the comma of 2,500 may be that of decimals"):
        read(tmp_path, text)
    assert read(tmp_path, text.replace("0;5;", "0,5;5;")).height.tolist() == [0.5, 2.5]


def test_columns_between_blanks_are_read(tmp_path) -> None:
    holds(read(tmp_path, "height_m speed_m_per_s direction_deg" + written(separator="  ")))
    holds(read(tmp_path, HEAD.replace(",", "  ") + written(separator="   ")))


@pytest.mark.parametrize("encoding", ["cp1252", "utf-16", "utf-16-be", "utf-8-sig"])
def test_usual_encodings_are_read(tmp_path, encoding) -> None:
    mark = "\ufeff" if encoding == "utf-16-be" else ""
    holds(read(tmp_path, mark + HEAD.replace("deg", "°") + written(), encoding=encoding))


def test_quoted_cells_may_hold_separators(tmp_path) -> None:
    text = (
        '"Altitude (m)","Wind Speed (m/s)","Wind Direction (deg)","Remarks, if any"\n'
        '"0","3","270","ok"\n"3000","12","280","gust, 14"\n'
    )
    holds(read(tmp_path, text))


def test_components_beside_speed_and_direction_are_held_to_them(tmp_path) -> None:
    text = f"{HEAD},U (m/s),V (m/s)\n0,4,270,4,0\n3000,12,280,11.8,-2.1\n"
    profile = read(tmp_path, text)
    holds(profile, ((0.0, 4.0, 270.0), (3000.0, 12.0, 280.0)))
    off = np.hypot(11.8 + 12 * np.sin(np.radians(280)), -2.1 + 12 * np.cos(np.radians(280)))
    assert profile.notes == (
        f"speed and direction read; the components beside them differ by up to {off:.2g} m/s",
    )
    with pytest.raises(tv.InputError, match=r"line 3: .* give 11\.82 m/s .* are -11\.8 and 2\.1"):
        read(tmp_path, text.replace("11.8,-2.1", "-11.8,2.1"))
    assert read(tmp_path, text.replace("11.8,-2.1", ",")).east.size == 2


def test_the_spread_of_a_speed_is_no_speed(tmp_path) -> None:
    rows = "\n0,3,9,270,9\n3000,12,9,280,9\n"
    holds(
        read(tmp_path, "height_m,speed_m_per_s,speed_std_m_per_s,direction_deg,gust_speed" + rows)
    )
    for name in ("speed_std_m_per_s", "speed_max", "wind speed error (m/s)"):
        with pytest.raises(
            tv.InputError, match=f"line 1: '{name[:9]}.* no known unit; write speed"
        ):
            read(tmp_path, f"height_m,{name},direction_deg" + written())


@pytest.mark.parametrize("gap", ["", "-9999", "-32768", "999", "9999", "NaN", "--", "-999.0"])
def test_missing_values_are_missing_and_not_winds(tmp_path, gap) -> None:
    text = f"{HEAD}\n0,3,270\n1000,{gap},{gap}\n2000,5,{gap}\n3000,12,280\n"
    profile = read(tmp_path, text)
    holds(profile)
    assert any(note.startswith("2 levels without a wind bridged") for note in profile.notes)
    noted = any("taken for a missing value" in note for note in profile.notes)
    assert noted == (gap in {"999", "9999", "-999.0"})
    high = read(tmp_path, f"{HEAD}\n999,3,270\n9999,12,280\n")
    np.testing.assert_array_equal(high.height, [999.0, 9999.0])


@pytest.mark.parametrize("row", ["0,3,777", "0,-77,270", "0,777,270", "-7777,3,270"])
def test_a_number_that_is_no_wind_may_be_left_empty(tmp_path, row) -> None:
    with pytest.raises(tv.InputError, match="line 2: .* leave the cell empty where a value is"):
        read(tmp_path, f"{HEAD}\n{row}\n3000,12,280\n")


BARE = "altitude,speed,direction,stddev\n1234,12,45,1\n3234,22,65,1\n9234,42,85,1\n"
LEVELS = ((1234.0, 12.0, 45.0), (3234.0, 22.0, 65.0), (9234.0, 42.0, 85.0))


def test_what_is_assumed_of_a_table_without_units_is_told_and_can_be_said(tmp_path) -> None:
    profile = read(tmp_path, BARE, "openrocket")
    holds(profile, LEVELS)
    assert profile.notes == (
        "assumed, as the file does not say: altitudes in m, speeds in m/s, directions in deg and"
        " altitudes above the sea (else give units and above_ground, as keys of [sounding])",
    )
    for form in (None, "openrocket"):
        said = read(tmp_path, BARE, form, units="ft,mph,deg", above_ground=100.0)
        above = [(h + 100.0 / FOOT, s, d) for h, s, d in LEVELS]
        holds(said, above, FOOT, MILE / 3600)
        assert not any("assumed" in note for note in said.notes)
    (note,) = read(tmp_path, BARE, units="ft,mph").notes
    assert note.startswith("assumed, as the file does not say: directions in deg and altitudes ab")
    with pytest.raises(
        tv.InputError, match=r"'altitude' has no known unit; .*--set sounding.format open"
    ):
        read(tmp_path, BARE)


def test_a_folder_of_tables_without_units_is_read_alike(tmp_path) -> None:
    for day in (15, 16):
        (tmp_path / f"2024-02-{day}_12.csv").write_text(BARE)
    with pytest.raises(tv.InputError, match="^[^ ]+ holds no sounding: 2 files"):
        tv.read_soundings(tmp_path, format="igra")
    for form in (None, "openrocket"):
        soundings = tv.read_soundings(tmp_path, format=form, units="ft,mph,deg", above_ground=100.0)
        above = [(h + 100.0 / FOOT, s, d) for h, s, d in LEVELS]
        for profile in soundings:
            holds(profile, above, FOOT, MILE / 3600)
    station = tmp_path / "station.txt"
    station.write_text(Balloon("2024-02-01T00", jet(30.0)).text)
    with pytest.raises(tv.InputError, match="are for tables .*station.txt is of the format igra"):
        tv.read_soundings(station, units="ft,mph")
    with pytest.raises(tv.InputError, match="units must name"):
        tv.read_soundings(tmp_path, units="parsec")


@pytest.mark.parametrize("units", ["ft,mph,knots", "parsec", "", "m,m", 3])
def test_units_that_are_none_are_refused(tmp_path, units) -> None:
    with pytest.raises(tv.InputError, match="units must"):
        read(tmp_path, BARE, units=units)


def test_units_and_the_site_are_for_tables_alone(tmp_path) -> None:
    text = "wind_u = [(0, 5), (1000, 6)]\nwind_v = [(0, 1), (1000, 2)]\n"
    for given in ({"units": "ft,mph"}, {"above_ground": 3.0}):
        with pytest.raises(tv.InputError, match="are for tables .* of the format rocketpy"):
            read(tmp_path, text, **given)
    with pytest.raises(tv.InputError, match="above_ground must be between -450 and 9000"):
        read(tmp_path, BARE, "openrocket", above_ground=10e3)


@pytest.mark.parametrize("value", ["np.array([[0,1],[1000,2]])", "'winds/v.csv'", "other"])
def test_a_wind_that_is_no_list_is_not_said_to_be_missing(tmp_path, value) -> None:
    text = (
        "import numpy as np\n"
        'env.set_atmospheric_model(type="custom_atmosphere", wind_u=[[0,5],[1000,6]],'
        f" wind_v={value})\n"
    )
    with pytest.raises(tv.InputError, match="line 2: wind_v is given as .* and no list: write its"):
        read(tmp_path, text)


DERIVED = """\
#USM00072518 2018 02 27 12 1104    3   1523   9258    100    850 -99999 -99999 -99999 -99999     30
  92600     741     745    2810     -99    2876      30    2820    2880     600    1100      57
  85000    1439    1440    2800     -65    2933      30    2805    2938     400    1000      40
  50000    5630    5631    2541     -70    3097      35    2542    3098      40     140      31
"""


@pytest.mark.parametrize("name", ["x.txt", "USM00072518-drvd.txt"])
def test_derived_parameters_of_igra_are_named_by_every_reader_under_any_name(tmp_path, name):
    file = tmp_path / name
    file.write_text(DERIVED)
    for read_file in (tv.read_sounding, tv.read_soundings):
        with pytest.raises(
            tv.InputError, match="holds derived parameters of IGRA .* ends in -data"
        ):
            read_file(file)
    file.write_text(Balloon("2024-02-01T00", jet(30.0)).text)
    assert tv.read_sounding(file).height.size > 2


def test_a_wyoming_list_with_collapsed_blanks_is_refused_by_that_reason(tmp_path) -> None:
    source = Path(__file__).parents[1] / "soundings" / "wyoming.txt"
    lines = [" ".join(line.split()) for line in source.read_text().splitlines()]
    with pytest.raises(tv.InputError, match="line 6: the blanks between .* are collapsed to one"):
        read(tmp_path, "\n".join(lines))


def test_a_table_of_winds_over_time_is_read_in_the_same_ways(tmp_path) -> None:
    texts = (
        "time_s,a\n0,0\n1.5,3\n2.5,0\n",
        "Time (s);Wind (°)\n0;0\n1,5;3\n2,5;0\n",
        '"Time (ms)"\t"Wind (rad)"\n0\t0\n1500\t0.05235987755982989\n2500\t0\n',
    )
    for text, encoding in zip(texts, ("utf-8", "cp1252", "utf-16"), strict=True):
        (tmp_path / "winds.csv").write_bytes(text.encode(encoding))
        wind = wind_of({"file": "winds.csv"}, tmp_path)
        np.testing.assert_allclose(wind.time, [0.0, 1.5, 2.5], rtol=1e-15)
        np.testing.assert_allclose(wind.angle, [[0.0, np.radians(3.0), 0.0]], rtol=1e-15)
    with pytest.raises(tv.InputError, match=r"'Wind \(rad\)' is not in deg, the unit in \[wind\]"):
        wind_of({"file": "winds.csv", "unit": "deg"}, tmp_path)
