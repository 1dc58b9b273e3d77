"""`tvclin availability`: what it prints, draws and writes, and its exit codes."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import tvclin as tv
from tests.archives import Balloon, days, jet, write
from tvclin.cli.app import app
from tvclin.cli.availability import _verdict
from tvclin.ensembles.availability.availability_record import Today
from tvclin.plots import availability_chart, curves_of


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["availability", "configuration-i", *arguments])


@pytest.fixture(scope="module")
def station(tmp_path_factory) -> str:
    balloons = [
        Balloon(time, jet(5.0 * (i + 1))) for i, time in enumerate(days("2023-02-24T00", 20))
    ]
    return str(write(tmp_path_factory.mktemp("archive") / "s-data.txt", balloons))


EAST = ("--azimuth-deg", "90", "--plane", "pitch")


def test_json_and_csv_are_what_the_library_says(station, tmp_path) -> None:
    table = tmp_path / "all.csv"
    result = run(station, *EAST, "--limit-deg", "0.35", "--json", "--csv", str(table))
    document = json.loads(result.stdout)
    computed = tv.availability(
        tv.load_schedule("configuration-i"), tv.read_soundings(station),
        limit=np.radians(0.35), azimuth=np.radians([90.0]), plane="pitch",
    )  # fmt: skip
    towards, part = document["towards"][0], computed.fraction()[0]

    assert result.exit_code == 0
    assert (towards["flown"], towards["judged"]) == (part.flown, part.judged)
    assert [towards["lower"], towards["upper"]] == [part.lower, part.upper]
    assert sum(month["judged"] for month in towards["months"].values()) == 20
    assert list(towards["placard_deg"].values()) == np.degrees(computed.placard()[0]).tolist()
    assert table.read_text() == computed.to_csv()
    said = " ".join(run(station, *EAST, "--limit-deg", "0.35", "--more").output.split())
    assert document["judged_s"] == [41.0, 116.0]
    assert "Judged from 41 to 116 s of the flight" in said
    assert "pitch: 20 soundings of ZZM00088801 from 2023-02-24 to 2023-03-05 Judged" in said
    assert "With 95 % confidence the fraction of all such days lies in the interval" in said
    assert "is judged for the given limit alone: lower_deg and upper_deg" in said


def test_options_of_the_command_complete_the_keys_that_are_set(tmp_path) -> None:
    """A file without a wind, and soundings without dates, which a key takes in their order."""
    for i in range(2):
        profile = tv.WindProfile(
            height=np.arange(0.0, 61e3, 1e3), east=np.full(61, 10.0 * i), north=np.zeros(61)
        )
        rows = [f"{h},{u},0" for h, u in zip(profile.height, profile.east, strict=True)]
        text = "\n".join(["height_m,east_m_per_s,north_m_per_s", *rows, ""])
        (tmp_path / f"s{i}.csv").write_text(text, encoding="utf-8")
    study = tmp_path / "study.toml"
    table = f'archive = "{tmp_path}"\nazimuth_deg = 90\nplane = "pitch"\nin_order = true\n'
    text = f'[study]\nvehicle = "configuration-i"\n[availability]\n{table}'
    study.write_text(text, encoding="utf-8")
    limit = ("--limit-deg", "0.35", "--json")
    given = run(str(tmp_path), *EAST, *limit, "--set", "availability.in_order", "true")
    in_file = CliRunner().invoke(app, ["availability", str(study), *limit])
    assert (given.exit_code, in_file.exit_code) == (0, 0), given.output + in_file.output
    assert json.loads(given.stdout)["towards"] == json.loads(in_file.stdout)["towards"]


def test_a_gust_by_its_speed_is_that_of_the_library(station) -> None:
    keys = ("gust.peak_speed_m_per_s=9", "gust.duration_s=2", "gust.plateau_s=0.5")
    given = ("--limit-deg", "0.35", *(w for key in keys for w in ("--set", key)), "--json")
    document = json.loads(run(station, *EAST, *given).stdout)
    result = tv.availability(
        *(tv.load_schedule("configuration-i"), tv.read_soundings(station)),
        **{"limit": np.radians(0.35), "azimuth": np.radians([90.0]), "plane": "pitch"},
        gust=tv.winds.LayeredGust(peak=0.02, blend=0.75, plateau=0.5), gust_speed=9.0,
    )  # fmt: skip
    said = list(document["towards"][0]["placard_deg"].values())
    assert said == pytest.approx(np.degrees(result.placard()[0]).tolist(), rel=1e-12)
    printed = " ".join(run(station, *EAST, *given[:-1], "--more").stdout.split())
    assert ", with a gust of 9 m/s and 2 s" in printed


def test_a_gust_on_an_archive_has_no_time_of_its_own(station) -> None:
    keys = ("gust.peak_deg=1", "gust.duration_s=2", "gust.peak_time_s=3")
    result = run(station, *EAST, "--limit-deg", "1", *(w for key in keys for w in ("--set", key)))
    assert result.exit_code == 2
    assert "take peak_time_s out of [gust]" in " ".join(result.output.split())


def test_the_name_of_a_station_is_no_archive(station) -> None:
    named = run("--set", "availability.station", str(station))
    assert named.exit_code == 2
    assert "needs a STATION, or a file with archive in [availability] (station" in named.output


def test_one_month_is_that_month(station) -> None:
    result = run(station, *EAST, "--limit-deg", "0.35", "--month", "2")

    assert result.exit_code == 0
    assert result.output.startswith("Limit 0.350 deg, pitch, towards 90 deg: ")
    assert "February" in result.output
    assert "March" not in result.output
    assert "the soundings are of one season" in result.output


@pytest.mark.parametrize(
    ("lower", "upper", "words"),
    [
        (0.384, 0.407, "GO, required at most 0.407 deg"),
        (0.407, 0.407, "GO, required 0.407 deg"),
        (0.584, 0.607, "NO GO, required at least 0.584 deg"),
        (0.484, 0.507, "NOT KNOWN, between 0.484 and 0.507 deg"),
    ],
)
def test_the_number_of_today_is_called_a_bound_where_it_is_one(lower, upper, words) -> None:
    """The CSV has both bounds of a sounding, so that the same word would name two numbers."""
    bounds = {"lower": np.radians(lower), "upper": np.radians(upper)}
    balloon = Today(**bounds, limit=np.radians(0.5), archive_fraction=np.nan, judged=(40, 90))
    assert _verdict(balloon, (40, 90)) == words


def test_the_exit_code_of_today_is_go_or_no_go(station, tmp_path) -> None:
    soundings = tv.read_soundings(station)
    said = {}
    for name, wind in {
        "weak": soundings[2], "strong": soundings[18], "burst": soundings[9].between(0.0, 6e3),
    }.items():  # fmt: skip
        file = tmp_path / f"{name}.csv"
        rows = zip(wind.height, wind.east, wind.north, strict=True)
        text = "".join(f"{h!r},{e!r},{n!r}\n" for h, e, n in np.array(list(rows)).tolist())
        file.write_text(f"height_m,east_m_per_s,north_m_per_s\n{text}")
        said[name] = run(station, *EAST, "--limit-deg", "0.35", "--today", str(file))

    assert {name: one.exit_code for name, one in said.items()} == {
        "weak": 0, "strong": 1, "burst": 1,
    }  # fmt: skip
    assert ": GO, required" in said["weak"].output
    assert ": NO GO, required" in said["strong"].output
    assert ": NOT KNOWN, between" in said["burst"].output


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--limit-deg", "-1", "--azimuth-deg", "90"), "--limit-deg must be positive"),
        (("--limit-deg", "1", "--azimuth-deg", "90", "--month", "7"), "got none"),
        (
            ("--limit-deg", "1", "--azimuth-deg", "90", "--month", "13"),
            "Error: --month must be between",
        ),
        (
            (
                *(*EAST, "--limit-deg", "1", "--set", "availability.persistence_deg=1"),
                *("--set", "availability.persistence_hours=2"),
            ),
            "exclude each other",
        ),
        (EAST, "give --limit-deg"),
        (("--limit-deg", "1"), "availability needs --azimuth-deg"),
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_two(station, options, said) -> None:
    result = run(station, *options)

    assert result.exit_code == 2
    assert said in result.output


def test_an_archive_without_a_usable_sounding_is_one_sentence_with_its_line(tmp_path) -> None:
    (tmp_path / "2024-01-05.csv").write_text(
        "altitude_m,speed_m_per_s,direction_deg\n0,10,260\n11000,200,260\n26000,20,260\n"
    )
    result = run(str(tmp_path), *EAST, "--limit-deg", "0.6")

    assert result.exit_code == 2
    assert "none of 1 soundings can be used: " in result.output
    assert "line 3: no wind blows with 200 m/s, above 130" in result.output


def test_ascent_and_availability_know_nothing_above_the_end_of_a_sounding(tmp_path) -> None:
    file = tmp_path / "2024-01-05.csv"
    rows = "".join(f"{height},20,260\n" for height in range(0, 9001, 500))
    file.write_text(f"altitude_m,speed_m_per_s,direction_deg\n{rows}")
    days = run(str(tmp_path), *EAST, "--limit-deg", "0.6")
    options = ("--winds", str(file), "--azimuth-deg", "90", "--limit-deg", "0.6")
    flight = CliRunner().invoke(app, ["ascent", "configuration-i", *options])

    assert "none judged, 1 unknown" in days.output
    assert "required deflection NOT KNOWN above 9.0 km" in flight.output
    assert (days.exit_code, flight.exit_code) == (1, 1)


@pytest.mark.thorough
def test_the_figure_is_what_the_library_says(station, tmp_path) -> None:
    import matplotlib.pyplot as plt

    picture = tmp_path / "a.png"
    assert run(station, *EAST, "--limit-deg", "0.35", "--plot", str(picture)).exit_code == 0
    assert Path(picture).stat().st_size > 10_000
    flight, soundings = tv.load_schedule("configuration-i"), tv.read_soundings(station)
    for azimuth, names in ((1.5, ["flown"]), ([1.0, 1.5], ["57.3 deg", "85.94 deg"])):
        result = tv.availability(flight, soundings, limit=0.006, azimuth=azimuth)
        curves = curves_of(availability_chart(result))
        parts = result.curve(np.radians(curves.abscissa))
        for name in names:
            column = next(one for one in curves.columns if one.label == name)
            own = [part[names.index(name)] if isinstance(part, tuple) else part for part in parts]
            # a limit in degrees and back may fall to the other side of a need, for one sounding
            off = np.abs(column.values - [100 * part.fraction for part in own])
            assert np.sum(off > 1e-9) <= 2
    plt.close("all")


def test_a_study_file_has_what_the_options_give(station, tmp_path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(
        '[study]\nvehicle = "configuration-i"\n[wind]\npeak_deg = 5\nduration_s = 7.5\n[nozzle]\n'
        f'limit_deg = 0.35\n[availability]\narchive = "{station}"\nazimuth_deg = 90\n'
        'plane = "pitch"\n'
    )
    by_file = CliRunner().invoke(app, ["availability", str(file), "--json"])
    by_options = run(station, *EAST, "--limit-deg", "0.35", "--json")
    assert json.loads(by_file.stdout) == json.loads(by_options.stdout)
