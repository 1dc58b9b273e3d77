"""Damaged files of other tools: a schedule, or one sentence; never a traceback."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import tvclin as tv
from tests.schedules.samples import FOLDER, GIVEN, MAP, OPENROCKET, read
from tests.turns import usual

READERS: dict[str, Callable[[Path], tv.FlightSchedule]] = {
    "openrocket.csv": read,
    "rasaero-flight.csv": lambda file: tv.ascent.read_rasaero(
        file, moment_of_inertia=([0.0, 5.0], [24.0, 20.0]), **GIVEN
    ),
    "rasaero-aerodynamics.csv": lambda file: read(OPENROCKET, normal_force_coefficient_slope=file),
    "component-analysis.csv": lambda file: read(OPENROCKET, normal_force_coefficient_slope=file),
    "table.csv": lambda file: tv.ascent.read_table(file, MAP),
}
PIECES = (b"nan", b"1e308", b"-1e308", b"inf", b",", b"\n", b"(", b"9", b"e", b"-", b"#", b'"')
CELLS = (b"0", b"-1", b"nan", b"1e300", b"1e-320", b"")


def hurt(content: bytes, drawn: random.Random) -> bytes:
    """Return a file with one thing wrong."""
    at, lines = drawn.randrange(len(content)), content.split(b"\n")
    one, other = drawn.randrange(len(lines)), drawn.randrange(len(lines))
    match drawn.randrange(5):
        case 0:
            return content[:at] + bytes([drawn.randrange(256)]) + content[at + 1 :]
        case 1:
            return content[:at] + content[at + drawn.randint(1, 60) :]
        case 2:
            return content[:at] + drawn.choice(PIECES) + content[at:]
        case 3:
            lines[one], lines[other] = lines[other], lines[one]
        case _:
            cells = lines[one].split(b",")
            cells[drawn.randrange(len(cells))] = drawn.choice(CELLS)
            lines[one] = b",".join(cells)
    return b"\n".join(lines)


@pytest.mark.parametrize("name", usual(READERS, 0))
def test_a_damaged_file_is_a_schedule_or_one_sentence(tmp_path: Path, name: str) -> None:
    drawn, file, said = random.Random(7), tmp_path / "flight.csv", []
    for _ in range(80):
        content = (FOLDER / name).read_bytes()
        for _ in range(drawn.randint(1, 3)):
            content = hurt(content, drawn)
        file.write_bytes(content)
        try:
            with np.errstate(over="raise", divide="raise", invalid="raise"):
                result = READERS[name](file)
            assert np.all(np.isfinite(result.vehicle.normal_force_slope))
        except tv.InputError as error:
            said.append(str(error))
    assert len(said) > 20
    assert all(len(line) < 500 for one in said for line in one.split("\n"))
