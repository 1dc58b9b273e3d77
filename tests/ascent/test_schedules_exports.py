"""OpenRocket exports as users have them: optional columns, languages, encodings, separators."""

from __future__ import annotations

import numpy as np
import pytest

import tvclin as tv
from tests.schedules.samples import (
    HEADER,
    LINES,
    NAMES,
    OPENROCKET,
    changed,
    read,
    same,
    with_column,
    written,
)

DAMPING = "Damping moment coefficient (kg·m²/s)"


@pytest.fixture(scope="module")
def sample() -> tv.FlightSchedule:
    return read(OPENROCKET)


def test_an_optional_column_never_blocks_a_file(sample, tmp_path) -> None:
    """A damping without a unit, as an extension of OpenRocket writes it, and other odd units."""
    for name, cell in (
        ("Damping moment coefficient (\u200b)", lambda _: "1.5"),
        ("Damping moment coefficient (1)", lambda _: "1.5"),
        (DAMPING, lambda _: "strong"),
        ("Air density (furlong)", lambda _: "1.2"),
        ("Air temperature (furlong)", lambda _: "288"),
    ):
        result = read(written(tmp_path, with_column(name, cell)))
        same(result, sample, 0.0)
        assert not np.any(result.vehicle.pitch_damping)
        (note,) = [one for one in result.notes if one.startswith("not read")]
        assert f"not read: column {name.partition(' (')[0]}, which is not needed: " in note
    lines = [line.replace("Vertical velocity (m/s)", "Vertical velocity (1)") for line in LINES]
    same(read(written(tmp_path, lines)), sample, 0.0)


TRANSLATED = {
    **{"Time": "Zeit", "Total velocity": "Gesamtgeschwindigkeit", "Angle of attack": "Winkel"},
    **{"CG location": "Position vom CG", "Mach number": "Machzahl", "Thrust": "Schub"},
}


def test_translated_names_are_said_to_be_and_those_that_are_missing_named(tmp_path) -> None:
    lines = list(LINES)
    for name, other in TRANSLATED.items():
        lines[HEADER] = lines[HEADER].replace(f"{name} (", f"{other} (")
    with pytest.raises(tv.InputError, match="names of columns are translated") as error:
        read(written(tmp_path, lines))
    said = str(error.value)
    assert said.startswith(f"{tmp_path / 'flight.csv'}, line {HEADER + 1}: ")
    assert "'Zeit (s)', 'Gesamtgeschwindigkeit (m/s)', 'Winkel" in said
    missing = said.partition("missing are ")[2].partition(":")[0].split(", ")
    assert sorted(missing) == sorted(TRANSLATED)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig", "cp1252"])
def test_files_of_every_usual_encoding_are_read(sample, tmp_path, encoding) -> None:
    lines = [line.replace("\u200b", "") for line in LINES]
    same(read(written(tmp_path, lines, encoding)), sample, 0.0)


def test_decimal_commas_between_tabs_and_quoted_cells_are_read(sample, tmp_path) -> None:
    tabs, quoted = list(LINES), list(LINES)
    tabs[HEADER] = LINES[HEADER].replace(",", "\t")
    for i, line in enumerate(LINES):
        if not line.startswith("#"):
            tabs[i] = line.replace(",", "\t").replace(".", ",")
            quoted[i] = ",".join(f'"{cell.replace(".", ",")}"' for cell in line.split(","))
    quoted[HEADER] = ",".join(f'"{name}"' for name in NAMES)
    for lines in (tabs, quoted):
        same(read(written(tmp_path, lines)), sample, 0.0)


def test_an_export_in_wind_is_refused_at_the_first_free_row(tmp_path) -> None:
    """The sample with an angle of attack of 11.1 degrees from the rod on, which ends at 0.42 s."""
    lines = changed("Angle of attack", lambda *_: 11.1)
    with pytest.raises(tv.InputError, match=r"is 11\.1 deg at 0\.5 s, .*simulate without wind"):
        read(written(tmp_path, lines))
