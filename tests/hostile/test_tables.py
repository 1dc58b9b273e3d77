"""Damaged tables of winds: a wind, or one sentence, by every reader; never a traceback."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import tvclin as tv
from tvclin.winds.wind_file import wind_of

TABLES = (
    "Altitude,1450\nTime (s),Height (m),Speed (m/s),Direction (°)\n0,5,3,270\n9,99,4,280\n",
    "Altitude MSL (feet);Speed (kn);Dir (deg);U (kn);V (kn)\n0;3,2;270;3,2;0\n99;4;270;4;0\n",
    '"height_m","speed_m_per_s","direction_deg","Remarks"\n"0","4","270","a"\n"9","9","280","b, c"',
    "altitude,speed,direction,stddev\n1234,12,45,1\n3234,22,65,1\n",
    "Time (s)\tw (rad)\n0\t0\n1.5\t0.1\n2\t0\n",
    "time_s,weight_N\n1,2\n2,3\n",
)
PIECES = (
    *(b"999", b"-9999", b'"', b",", b";", b"\t", b"\n", b"(", b")", b"nan", b"1e308", b"inf"),
    *(b"\xb0", b"\xff\xfe", b"\x81", b"AGL", b"MSL", b" ", b"u (m/s)", b"1,000", b"<", b"#", b"_"),
)
FORMATS = (None, "csv", "openrocket")


def damaged(drawn: random.Random) -> bytes:
    """Return a table with one to four pieces inserted or replaced."""
    content = drawn.choice(TABLES).encode(drawn.choice(["utf-8", "cp1252", "utf-16"]))
    for _ in range(drawn.randint(1, 4)):
        first = drawn.randrange(len(content) + 1)
        last = first + drawn.choice([0, 0, 1, 3, 20])
        piece = drawn.choice([*PIECES, bytes([drawn.randrange(256)]), content[first:last] * 2])
        content = content[:first] + piece + content[last:]
    return content


def test_a_damaged_table_is_a_wind_or_one_sentence(tmp_path: Path) -> None:
    drawn, file, said = random.Random(3), tmp_path / "table.csv", []
    for _ in range(150):
        file.write_bytes(damaged(drawn))
        form, units = drawn.choice(FORMATS), drawn.choice([None, "ft,mph"])
        readers: tuple[Callable[[], Any], ...] = (
            lambda form=form, units=units: tv.read_sounding(file, form, units=units),
            lambda: tv.read_soundings(file, in_order=True),
            lambda: wind_of({"file": file.name}, tmp_path),
            lambda: tv.load_schedule(file),
        )
        for read in readers:
            try:
                assert read() is not None
            except tv.InputError as error:
                said.append(str(error))
    assert 100 < len(said) < 600
    assert all(len(line) < 500 for one in said for line in one.split("\n"))


def test_a_head_without_a_letter_is_no_head(tmp_path: Path) -> None:
    (tmp_path / "winds.csv").write_text("(),a\n0,1\n1,0\n")
    with pytest.raises(tv.InputError, match="first column time_s"):
        wind_of({"file": "winds.csv"}, tmp_path)
