"""Columns over axes: a CSV and a Dataset hold the same numbers."""

import csv
import io

import numpy as np
import pytest

import tvclin as tv
from tvclin.base.cards import Column, Columns, columns_of

NEEDS = np.radians([[1.0, 2.0, np.nan], [4.0, 5.0, 6.0]])
TABLE = Columns(
    (
        Column("time", np.array([0.5, 1.0]), "s"),
        Column("wind", np.array(["a", "b", "c"]), ""),
    ),
    (
        Column("need", NEEDS, "rad"),
        Column("thrust", np.array([7.0, 8.0]), "N/rad", ("time",)),
        Column("known", np.array([True, False, True]), "1", ("wind",)),
    ),
    {"plane": "pitch"},
)


def test_a_csv_has_a_line_for_each_place_with_units_in_its_headings() -> None:
    head, *rows = csv.reader(io.StringIO(TABLE.csv()))
    assert head == ["time_s", "wind", "need_deg", "thrust_N_per_rad", "known"]
    assert [row[:2] for row in rows[:4]] == [["0.5", "a"], ["0.5", "b"], ["0.5", "c"], ["1.0", "a"]]
    assert [row[3:] for row in rows[2:4]] == [["7.0", "True"], ["8.0", "True"]]
    assert rows[2][2] == ""
    assert float(rows[5][2]) == np.degrees(NEEDS[1, 2])


@pytest.mark.thorough
def test_a_dataset_has_the_same_numbers_in_si_units() -> None:
    pytest.importorskip("xarray")
    data = TABLE.dataset()
    np.testing.assert_array_equal(data["need"], NEEDS)
    assert data["need"].dims == ("time", "wind")
    assert data["thrust"].attrs == {"units": "N/rad"}
    assert float(data["thrust"].sel(time=1.0)) == 8.0
    assert data.attrs == {"plane": "pitch"}


def test_fields_of_a_record_are_columns_in_si_units() -> None:
    sizing = tv.size(
        tv.load_schedule("configuration-i"),
        {"gust": tv.TriangularWind(peak=0.05, duration=7.5)},
        times=[60.0],
        dead_bands=1.0,
    )
    begins, known = columns_of(sizing, "begins", "known")
    assert (begins.heading, begins.attributes) == ("begins_s", {"units": "s"})
    assert (known.heading, known.attributes) == ("known", {"units": "1"})
    np.testing.assert_array_equal(begins.values, sizing.begins)


def test_dates_and_directions_are_written_as_they_are_read() -> None:
    dates = np.array(["2024-02-01T00", "2024-02-01T12"], dtype="datetime64[ns]")
    table = Columns(
        (Column("azimuth", np.radians([60.0]), "rad"), Column("time", dates, "UTC")),
        (Column("flies", np.array([[1.0, np.nan]])),),
    )
    assert table.csv() == (
        "azimuth_deg,time_utc,flies\n60.0,2024-02-01T00:00,1.0\n60.0,2024-02-01T12:00,\n"
    )


@pytest.mark.parametrize("name", ["=cmd()", "+1", "-1", "@x", "\t=1", "=HYPERLINK(1,2)"])
def test_no_name_is_a_formula_in_a_spreadsheet_and_every_number_stays_one(name: str) -> None:
    """A cell is a formula if it begins so; after an apostrophe a spreadsheet reads a text."""
    winds = Column("wind", np.array([name, "plain"]), "")
    head, first, second = csv.reader(
        io.StringIO(Columns((winds,), (Column("need", np.array([-0.5, 1e-9])),)).csv())
    )
    assert head == ["wind", "need"]
    assert first == [f"'{name}", "-0.5"]
    assert second == ["plain", "1e-09"]


def test_no_escape_sequence_of_a_name_reaches_a_csv() -> None:
    names = np.array(["a\x1b[31mb", "c\rd", "e\udcfff", "ä·日"])
    rows = csv.reader(io.StringIO(Columns((Column("wind", names, ""),), ()).csv()))
    assert [row[0] for row in rows] == ["wind", "a?[31mb", "c?d", "e?f", "ä·日"]
