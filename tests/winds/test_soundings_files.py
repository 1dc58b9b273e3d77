"""Files of winds: every format read level by level; what is wrong refused in one sentence."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

import tvclin as tv
from tvclin.winds.soundings.levels import geometric

GOLDEN = Path(__file__).parents[1] / "soundings"
SOUNDINGS = ["table.csv", "components.csv", "wyoming.txt", "wyoming.csv", "igra.txt"]
SOUNDINGS += ["rocketpy.txt", "rocketpy.json"]
KNOT = 1852 / 3600
EARTH = 6_356_766.0


def holds(profile, height, east, north):
    np.testing.assert_allclose(profile.height, height, rtol=1e-15)
    np.testing.assert_allclose(profile.east, east, rtol=1e-14, atol=1e-13)
    np.testing.assert_allclose(profile.north, north, rtol=1e-14, atol=1e-13)


def from_geopotential(height):
    """Return geometric heights: in closed form, g goes with the inverse square of the radius."""
    height = np.array(height, dtype=float)
    return EARTH * height / (EARTH - height)


def write(tmp_path, content, name="wind.txt"):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def test_geometric_heights_have_the_potential_of_their_geopotential_heights():
    for height in (0.0, 5e3, 3e4):
        potential = quad(lambda z: (EARTH / (EARTH + z)) ** 2, 0.0, float(geometric(height)))[0]
        assert potential == pytest.approx(height, rel=1e-12)


def test_a_table_with_speed_and_direction():
    profile = tv.read_sounding(GOLDEN / "table.csv")
    slanted = 100 * KNOT * np.sqrt(0.5)
    east, north = [0.0, -10 * KNOT, 40 * KNOT, slanted], [0.0, 0.0, 0.0, slanted]
    holds(profile, [0.0, 1000.0, 5000.0, 12000.0], east, north)
    assert profile.notes == (
        "1 level given twice, from 5000 m on: the first is kept",
        "1 level without a wind bridged by straight lines, the longest from 1000 to 5000 m",
    )
    assert profile.source.endswith("table.csv")


def test_a_table_with_components():
    profile = tv.read_sounding(GOLDEN / "components.csv")
    holds(profile, [0.0, 10e3, 12e3], [-1.0, 30.0, 40.0], [2.0, -4.5, 0.0])
    assert profile.notes == ()


def test_openrocket_has_no_units_and_must_be_named():
    profile = tv.read_sounding(GOLDEN / "openrocket.csv", "openrocket")
    slanted = -10 * np.sqrt(0.5)
    holds(profile, [0.0, 100.0, 1000.0], [0.0, slanted, -15.0], [-5.0, slanted, 0.0])
    with pytest.raises(tv.InputError, match="line 1: 'altitude' has no known unit"):
        tv.read_sounding(GOLDEN / "openrocket.csv")


def test_a_table_copied_from_a_page_ends_where_the_markup_goes_on(tmp_path):
    rows = (GOLDEN / "components.csv").read_text()
    copied = tv.read_sounding(write(tmp_path, f"{rows}</PRE><H3>Indices</H3>\n1,2,3,4,5,6,7\n"))
    plain = tv.read_sounding(GOLDEN / "components.csv")
    holds(copied, plain.height, plain.east, plain.north)


def test_a_wyoming_list_in_knots_and_the_second_sounding_in_it():
    first = tv.read_sounding(GOLDEN / "wyoming.txt")
    at = np.radians(260)
    holds(
        first,
        from_geopotential([5, 1500, 5700, 12000]),
        KNOT * np.array([0.0, 20.0, -60 * np.sin(at), 120.0]),
        KNOT * np.array([10.0, 0.0, -60 * np.cos(at), 0.0]),
    )
    assert first.source.endswith("74794 XMR Cape Kennedy Observations at 12Z 15 Feb 2024")
    assert first.notes[0] == "the first of 2 soundings in the file; choose another by its time"
    second = tv.read_sounding(GOLDEN / "wyoming.txt", time="2024-02-16 00")
    np.testing.assert_array_equal(second.height, from_geopotential([5, 11980]))
    np.testing.assert_allclose(second.speed, [8 * KNOT, 110 * KNOT], rtol=1e-15)
    with pytest.raises(tv.InputError, match="no sounding of time '2024-02-17 00'; it has '2024-02"):
        tv.read_sounding(GOLDEN / "wyoming.txt", time="2024-02-17 00")


def test_a_wyoming_list_in_metres_per_second(tmp_path):
    text = (GOLDEN / "wyoming.txt").read_text()
    newer = text.replace("SKNT", "SPED").replace("knot", " m/s")
    newer = newer.replace("74794 XMR Cape Kennedy Observations at 12Z", "Observations at 12 UTC")
    profile = tv.read_sounding(write(tmp_path, newer), "wyoming", time="2024-02-15 12")
    np.testing.assert_allclose(profile.speed, [10.0, 20.0, 60.0, 120.0], rtol=1e-15)
    for wrong, said in (
        (text.replace("SKNT", "SPED"), "line 7: the unit of SPED must be m/s"),
        (text.replace("SKNT", "WIND"), "line 6: .* either SKNT"),
        (text.replace("HGHT", "HGHT."), "line 6: the header must name HGHT, DRCT"),
    ):
        with pytest.raises(tv.InputError, match=said):
            tv.read_sounding(write(tmp_path, wrong))


def test_a_wyoming_table_in_which_the_balloon_sinks_for_a_second():
    profile = tv.read_sounding(GOLDEN / "wyoming.csv")
    holds(profile, from_geopotential([5, 10, 12000]), [0.0, 0.0, 60.0], [5.0, 6.0, 0.0])
    assert "1 level where the balloon sank left out" in profile.notes
    assert "geopotential heights made geometric" in profile.notes


def test_igra_keeps_the_levels_that_have_only_a_wind():
    first = tv.read_sounding(GOLDEN / "igra.txt")
    at = np.radians(260)
    holds(
        first,
        from_geopotential([5, 1500, 5700, 12000]),
        [0.0, 10.3, -30.9 * np.sin(at), 61.7],
        [5.0, 0.0, -30.9 * np.cos(at), 0.0],
    )
    assert "1 level with a wind but without a height left out" in first.notes
    assert any("from 5705.12 to 12022.7 m" in note for note in first.notes)
    second = tv.read_sounding(GOLDEN / "igra.txt", time="2024-02-16 00")
    np.testing.assert_allclose(second.speed, [4.1, 56.6], rtol=1e-15)


def test_rocketpy_lists_come_from_python_and_json_and_go_back(tmp_path):
    profile = tv.read_sounding(GOLDEN / "rocketpy.json")
    holds(profile, [0.0, 1000.0, 12000.0], [5.0, 10.0, 41.5], [-2.0, 3.0, 0.0])
    called = tv.read_sounding(GOLDEN / "rocketpy.txt")
    holds(called, [0.0, 500.0, 1000.0, 5000.0], *called.at([0.0, 500.0, 1000.0, 5000.0]))
    assert called.at(500.0) == (7.5, 3.0)
    assert called.notes == ("1 level that only one list reaches left out",)
    apart = "wind_u=[(0, 5), (1000, 10)]; wind_v=((500, 3), (2000, 0))"
    holds(tv.read_sounding(write(tmp_path, apart)), [500.0, 1000.0], [7.5, 10.0], [3.0, 2.0])
    again = tv.read_sounding(write(tmp_path, json.dumps(profile.to_rocketpy())))
    holds(again, profile.height, profile.east, profile.north)


@pytest.mark.parametrize("name", SOUNDINGS)
def test_line_ends_may_be_mixed_and_a_byte_order_mark_stand_first(tmp_path, name):
    good = tv.read_sounding(GOLDEN / name)
    lines = (GOLDEN / name).read_bytes().split(b"\n")
    ends = [b"\r\n", b"\n", b"\r"] * len(lines)
    mixed = b"".join(line + end for line, end in zip(lines, ends, strict=False))
    holds(
        tv.read_sounding(write(tmp_path, b"\xef\xbb\xbf" + mixed, name)),
        *(good.height, good.east, good.north),
    )


def table(*rows, header="height_m,speed_m_per_s,direction_deg"):
    return "\n".join([header, *rows])


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (table("0,5,10", "1000,8,361"), "line 3: direction must be between 0 and 360 degrees"),
        (table("0,5,10", "1000,-8,36"), "line 3: speed must not be negative; got -8 m/s"),
        (table("0,5,10", "1000,131,36"), "line 3: no wind blows with 131 m/s, above 130; check"),
        (
            table("0,5,10", "9,0,131", header="height_m,u_m_per_s,v_m_per_s"),
            "line 3: no wind blows",
        ),
        (table("0,5,10", "1e6,8,36"), "line 3: height must be between .* check its unit"),
        (table("0,5,10", "1000,8,36", "", "900,8,36"), "line 5: .* 900 m comes after 1000 m"),
        (table("0,5,10", "1000,8"), "line 3: there are 3 names and 2 cells"),
        (table("0,5,10", "1000,fast,36"), "line 3: speed_m_per_s must be a number.* 'fast'"),
        (table("0,5,10", "1000,inf,36"), "line 3: speed_m_per_s must be a number"),
        (table("0,5,10"), "two or more levels with a height and a wind; got 1"),
        (table(), "no row below its line of names"),
        (table("0,5,10", header="height_m,speed,direction_deg"), "line 1: 'speed' has no known"),
        (table("0,5,1", header="height_m,speed_furlong,direction_deg"), "write speed_m_per_s"),
        (
            table("0,5", header="height_m,speed_kt"),
            "a height and .*, as height_m,speed_m_per_s,direction",
        ),
        (table("0,5,1", header="height_m,height_ft,speed_kt"), "line 1: height is given twice"),
        (table("0,5,1", header="height_m,speed_kt,v_kt"), "either speed and"),
        (
            table("9,9,1,1", "8,8,1,1", "7,7,1,1", header="time,height_m,u_kt,v_kt"),
            "line 3: heights must ascend; 8 m comes after 9 m",
        ),
        ("wind is strong today", "is in no format that is recognised"),
        ("", "is empty"),
        (b"\x00\x01\x02height_m,speed_kt\x00", "is not a text file"),
        (b"\xff\xfe\xfa", "is not a text file in UTF-8"),
        ("wind_u=[(0, 1), (1, 2)]", "wind_v is missing"),
        ("wind_u=[(0, 1), (1, 2)]\nwind_v=[(0, 1), (0, 2)]", "line 2: the heights of wind_v must"),
        ("wind_u=[(0, 1), (1, 2)]\nwind_v=[(0, 1), x]", "line 2: wind_v must be a list of numbers"),
        ("wind_u=[(0, 1), (1, 2)]\nwind_v=[3, 4]", "line 2: wind_v must be a list of two or more"),
        ("wind_u=[(0, 1), (1, 2)]\nwind_v=[(0, 1), (1,)]", "line 2: wind_v must be a list of two"),
        ("wind_u=[(0, 1), (2\n", "neither JSON nor Python"),
        ("wind_u=" + "-" * 20_000 + "1", "neither JSON nor Python"),
    ],
)
def test_what_is_no_wind_is_refused_in_one_sentence(tmp_path, content, said):
    with pytest.raises(tv.InputError, match=said) as error:
        tv.read_sounding(write(tmp_path, content))
    assert "\n" not in str(error.value)


def test_levels_without_a_wind_beyond_all_others_are_left_out(tmp_path):
    content = table("0,,", "1000,5,90", "2000,6,90", "3000,,")
    profile = tv.read_sounding(write(tmp_path, content))
    np.testing.assert_array_equal(profile.height, [1000.0, 2000.0])
    assert profile.notes == ("2 levels without a wind below or above all winds left out",)


def test_files_cut_short_are_refused(tmp_path):
    igra = (GOLDEN / "igra.txt").read_text().splitlines()
    for lines, said in (
        (igra[:5], "line 1: 6 levels are announced and 4 follow"),
        ([*igra[:6], igra[6][:40]], "line 7: a level is cut short"),
        ([*igra[:6], igra[6][1:]], "line 7: a level is cut short or not in its columns"),
    ):
        with pytest.raises(tv.InputError, match=said):
            tv.read_sounding(write(tmp_path, "\n".join(lines)))


def test_paths_that_are_no_files_are_refused(tmp_path):
    for path, said in (
        (tmp_path, "is a directory"),
        (tmp_path / "none.csv", "does not exist"),
        ("a\0b", "path must be a path that a file can have"),
        (3, "path must be a path that a file can have; got 3"),
    ):
        with pytest.raises(tv.InputError, match=said):
            tv.read_sounding(path)
    with pytest.raises(tv.InputError, match=r"format must be one of .* \(did you mean 'igra'"):
        tv.read_sounding(GOLDEN / "igra.txt", "igra2")
    with pytest.raises(tv.InputError, match="line 1: an IGRA file begins each sounding with"):
        tv.read_sounding(GOLDEN / "components.csv", "igra")
    with pytest.raises(tv.InputError, match="read it with read_range_reference"):
        tv.read_sounding(GOLDEN / "T1cap19.txt")


@st.composite
def mutated(draw):
    """Return a golden file of which some bytes are replaced, cut out or repeated."""
    content = (GOLDEN / draw(st.sampled_from([*SOUNDINGS, "T1cap19.txt"]))).read_bytes()
    for _ in range(draw(st.integers(1, 4))):
        first = draw(st.integers(0, len(content)))
        last = min(first + draw(st.integers(0, 30)), len(content))
        kept = [b"", content[first:last] * 2]
        new = draw(st.one_of(st.binary(max_size=6), st.sampled_from(kept)))
        content = content[:first] + new + content[last:]
    return content


@pytest.mark.thorough
@settings(max_examples=200, deadline=None)
@given(
    content=st.one_of(mutated(), st.binary(max_size=200)),
    name=st.sampled_from([None, "csv", "openrocket", "wyoming", "igra", "rocketpy"]),
)
def test_no_file_leads_to_anything_but_a_profile_or_a_sentence(tmp_path_factory, content, name):
    path = write(tmp_path_factory.getbasetemp(), content, "fuzzed.txt")
    for read in (lambda: tv.read_sounding(path, name), lambda: tv.winds.read_range_reference(path)):
        try:
            result = read()
        except tv.InputError as error:
            assert "\n" not in str(error)  # noqa: PT017
        else:
            assert result
