"""Hostile files of winds and flights: refused soon, in one sentence that names the bound."""

import struct
import zipfile
from pathlib import Path
from time import process_time

import pytest

import tvclin as tv
from tests.archives import Balloon, jet
from tests.turns import usual

SOON = 60.0
"""Seconds of the processor; without bounds these took minutes, or all memory."""
MAP = {
    **{"time": "t (s)", "weight_N": 1e4, "moment_of_inertia_kg_m2": 1e3, "thrust_N": 2e4},
    **{"axial_force_N": 0.0, "normal_force_slope_N_per_rad": 1e4, "velocity_m_per_s": 100.0},
    **{"attitude_deg": 84.0, "aerodynamic_arm_m": 1.0, "control_arm_m": 1.0},
}


@pytest.fixture(autouse=True)
def _soon():
    begun = process_time()
    yield
    assert process_time() - begun < SOON


def refused(read, *given) -> str:
    with pytest.raises(tv.InputError) as caught:
        read(*given)
    assert len(str(caught.value)) < 900
    return str(caught.value)


@pytest.fixture
def packed(tmp_path):
    """Return a function that packs a text as a station file."""

    def pack(text: bytes, how: int = zipfile.ZIP_DEFLATED) -> Path:
        file = tmp_path / "station-data.txt.zip"
        with zipfile.ZipFile(file, "w", how) as made:
            made.writestr("station-data.txt", text)
        return file

    return pack


@pytest.mark.parametrize("how", usual(["ZIP_DEFLATED", "ZIP_BZIP2", "ZIP_LZMA"], 0))
def test_every_way_of_packing_that_is_damaged_is_one_sentence(packed, how) -> None:
    text = "".join(Balloon(f"2024-02-{day:02d}T00", jet(30.0)).text for day in range(1, 29))
    file = packed(text.encode(), getattr(zipfile, how))
    assert len(tv.read_soundings(file)) == 28
    whole = file.read_bytes()
    begin = 30 + struct.unpack("<H", whole[26:28])[0]
    sentences = set()
    for at in range(begin, begin + 200):
        file.write_bytes(whole[:at] + bytes([whole[at] ^ 0xFF]) + whole[at + 1 :])
        try:
            tv.read_soundings(file)
        except tv.InputError as error:  # not every bit of a header is of use to what unpacks
            sentences.add(str(error).removeprefix(str(file)).split(":")[0])
    assert sentences
    assert sentences <= {
        " is no zip that can be read; load it down again",
        " cannot be read",
        " must hold one .txt, as a station file does; got 0",
    }


@pytest.mark.thorough
def test_a_line_that_unpacks_to_gigabytes_is_not_gathered(packed) -> None:
    file = packed(b"#" + bytes(200_000_000))
    said = refused(tv.read_soundings, file)
    assert said.endswith("line 1: it has 1000 bytes or more")


@pytest.mark.thorough
def test_a_sounding_of_millions_of_levels_is_not_gathered(packed) -> None:
    head, *levels = Balloon("2024-02-01T00", jet(30.0)).text.splitlines(keepends=True)
    file = packed((head + "".join(levels) * 20_000).encode())
    assert "more than 1000000 levels" in refused(tv.read_soundings, file)


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_table_of_more_than_a_thousand_columns_is_refused(tmp_path, separator) -> None:
    file = tmp_path / "wide.csv"
    names = [f"c{i}" for i in range(80_000)]
    file.write_text(separator.join(["t (s)", "height_m", "speed_kt", *names]) + "\n1,2,3\n")
    assert "line 1: it has more than 1000 columns" in refused(tv.ascent.read_table, file, MAP)
    assert "with at most 1000 columns" in refused(tv.read_sounding, file)


@pytest.mark.parametrize("columns", [1000, 1001])
def test_a_sounding_and_a_flight_may_have_a_thousand_columns(tmp_path, columns) -> None:
    file = tmp_path / "wide.csv"
    more = columns - 4
    file.write_text(
        ",".join(["t (s)", "height_m", "speed_m_per_s", "direction_deg", *["x"] * more])
        + "".join(f"\n{k},{1000 * k},{3 * k},90" + ",0" * more for k in (1, 2, 3))
    )
    if columns > 1000:
        refused(tv.read_sounding, file)
        refused(tv.ascent.read_table, file, MAP)
    else:
        assert tv.read_sounding(file).height.size == 3
        assert tv.ascent.read_table(file, MAP).span == (1.0, 3.0)


def test_a_line_of_hundreds_of_megabytes_is_refused(tmp_path) -> None:
    file = tmp_path / "long.csv"
    file.write_bytes(b"t (s),height_m\n" + b"1," * 45_000_000)
    for read, *more in ((tv.ascent.read_table, MAP), (tv.read_sounding,)):
        assert "line 2: it has more than 1000000 letters" in refused(read, file, *more)


@pytest.mark.thorough
def test_a_text_without_a_header_is_not_searched_to_its_end(tmp_path) -> None:
    file = tmp_path / "none.csv"
    file.write_text("1.5,2.5,3.5,4.5 word (m)\n" * 1_000_000)
    assert "no line of column names" in refused(tv.ascent.read_table, file, MAP)
    assert "in its first 1000 lines" in refused(tv.read_sounding, file)


@pytest.mark.parametrize(
    "head",
    [
        f"t (s),{'n' * 80_000}",
        f"t (s),thrust ({'u' * 80_000})",
        f"t (s),{'n' * 80_000} (s)",
        f"t (s),{'(' * 40_000}",
    ],
)
def test_what_a_table_is_told_does_not_repeat_thousands_of_letters(tmp_path, head) -> None:
    file = tmp_path / "table.csv"
    file.write_text(f"{head}\n1,x\n2,3\n")
    name = head.split(",", 1)[1]
    for source in (name, name.split(" (")[0]):
        said = refused(tv.ascent.read_table, file, MAP | {"thrust_N": source})
        assert "line 1: a name of a column has at most 200 letters; got '" in said


@pytest.mark.parametrize(
    "head", [f"height_m,speed_{'u' * 80_000},direction_deg", f"height_m,height_{'u' * 80_000},u_kt"]
)
def test_what_a_sounding_is_told_does_not_repeat_thousands_of_letters(tmp_path, head) -> None:
    file = tmp_path / "sounding.csv"
    file.write_text(f"{head}\n1,2,3\n4,5,6\n")
    refused(tv.read_sounding, file)
