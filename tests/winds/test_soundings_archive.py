"""Archives of soundings: what a whole station file or a folder becomes, and what stops nothing."""

import zipfile

import numpy as np
import pytest

import tvclin as tv
from tests.archives import Balloon, days, jet, write
from tvclin.winds.soundings.levels import geometric

FIVE = [(21, 101000, 5, 90, 3.0), (30, -9999, 6000, 270, 30.0), (30, -9999, 12000, 280, 60.0)]


def read(path, *balloons, **options):
    return tv.read_soundings(write(path / "station-data.txt", balloons), **options)


def test_an_archive_is_the_single_soundings_of_the_file(tmp_path) -> None:
    rng = np.random.default_rng(4)
    balloons = [Balloon(time, jet(rng.uniform(20, 70))) for time in days("2023-12-28T00", 20)]
    result = read(tmp_path, *balloons)

    assert len(result) == 20
    for i, balloon in enumerate(balloons):
        single = tv.read_sounding(
            tmp_path / "station-data.txt", time=balloon.time.replace("T", " ")
        )
        assert np.array_equal(result[i].height, single.height)
        assert np.array_equal(result[i].east, single.east)
        assert np.array_equal(result[i].north, single.north)
        assert result.times[i] == np.datetime64(balloon.time)


def test_a_zip_is_read_as_the_file_in_it(tmp_path) -> None:
    plain = read(tmp_path, *(Balloon(time, FIVE) for time in days("2024-02-27T00", 8)))
    with zipfile.ZipFile(tmp_path / "station-data.txt.zip", "w") as packed:
        packed.write(tmp_path / "station-data.txt", "station-data.txt")
    unpacked = tv.read_soundings(tmp_path / "station-data.txt.zip")

    assert np.array_equal(plain.times, unpacked.times)
    assert np.array_equal(plain.height, unpacked.height)


def test_months_and_years_are_left_out_before_their_levels_are_looked_at(tmp_path) -> None:
    broken = Balloon("2020-03-05T00", [(30, -9999, 5, 999, 3.0)])
    wanted = [Balloon(time, FIVE) for time in ("2020-02-29T12", "2021-02-01T00", "1995-02-01T00")]
    result = read(tmp_path, *wanted, broken, months=[2], years=(1996, 2025))

    assert result.times.astype(str).tolist() == ["2020-02-29T12:00", "2021-02-01T00:00"]
    assert all(result.usable)


def test_a_month_is_that_of_local_time(tmp_path) -> None:
    """At the Cape, five hours behind, the first of March at 00 UTC is still February."""
    balloons = [Balloon(time, FIVE) for time in days("2024-02-28T12", 5)]
    utc, cape = (read(tmp_path, *balloons, months=[2], utc_offset=hours) for hours in (0.0, -5.0))

    assert [len(utc), len(cape)] == [3, 4]
    assert str(cape.times[-1]) == "2024-03-01T00:00"
    whole = read(tmp_path, *balloons)
    assert [len(whole.select(month=2)), len(whole.with_utc_offset(-5).select(month=2))] == [3, 4]
    assert len(whole.with_utc_offset(-5).select(hour=19)) == 2


def test_a_level_without_a_height_lies_between_its_neighbours_in_log_pressure(tmp_path) -> None:
    levels = [
        (21, 100000, 100, 270, 10.0),
        (20, 50000, -9999, 270, 33.0),
        (10, 25000, 10100, 270, 50.0),
        (20, 20000, -9999, 270, 55.0),
    ]
    result = read(tmp_path, Balloon("2024-02-01T00", levels))

    assert result[0].height == pytest.approx(geometric(np.array([100.0, 5100.0, 10100.0])))
    assert result[0].speed == pytest.approx([10.0, 33.0, 50.0])
    assert result.notes == (
        "1 levels with a wind and a pressure, placed in its logarithm",
        "1 levels with a wind but without a height, left out",
    )


def test_no_level_is_placed_between_two_soundings(tmp_path) -> None:
    first = [(21, 100000, 100, 270, 10.0), (10, 25000, 10100, 270, 50.0), (20, 9000, -9999, 1, 1.0)]
    result = read(tmp_path, *(Balloon(time, first) for time in days("2024-02-01T00", 3)))

    assert result.counts.tolist() == [2, 2, 2]


@pytest.mark.parametrize(
    ("levels", "why"),
    [
        (
            [*FIVE, (30, -9999, 13000, 270, 171.0)],
            "line 9: no wind blows with 171 m/s, above 130; check its unit",
        ),
        (
            [*FIVE, (30, -9999, 13000, 400, 17.0)],
            "line 9: direction must be between 0 and 360 degrees; got 400",
        ),
        ([*FIVE, (30, -9999, 13000, 270, -3.0)], "line 9: speed must not be negative; got -3 m/s"),
        ([*FIVE, (30, 123456789, 13000, 270, 3.0)], "line 9: a level is cut short or not in its"),
        (FIVE[:1], "it has fewer than two levels with a height and a wind"),
        ([FIVE[2], FIVE[1], FIVE[0], FIVE[1]], "more than half of its levels lie below"),
        ([(30, -9999, h, -9999, -9999) for h in (0, 99)], "it has fewer than two levels"),
    ],
)
def test_a_bad_sounding_says_why_and_stops_nothing(tmp_path, levels, why) -> None:
    times = days("2024-02-01T00", 3)
    bad = Balloon(times[1], levels)
    result = read(tmp_path, Balloon(times[0], FIVE), bad, Balloon(times[2], FIVE))

    assert result.usable.tolist() == [True, False, True]
    assert result.why[1].startswith(why)
    assert len(list(result)) == 2
    assert (
        f"1 soundings that cannot be used (the first: {times[1]}:00 UTC, {why}" in result.notes[-1]
    )
    with pytest.raises(tv.InputError, match="cannot be used"):
        result[1]


def test_a_download_that_was_cut_off_keeps_what_is_whole(tmp_path) -> None:
    path = write(tmp_path / "a-data.txt", [Balloon(t, FIVE) for t in days("2024-02-01T00", 3)])
    for cut in (60, 20, 175):
        text = path.read_text()
        (tmp_path / "cut.txt").write_text(text[: len(text) - cut])
        soundings = tv.read_soundings(tmp_path / "cut.txt")

        assert soundings.usable.tolist()[:2] == [True, True]
        if len(soundings) > 2:
            assert "cut short" in soundings.why[2]


def test_a_header_that_announces_more_does_not_swallow_the_next(tmp_path) -> None:
    times = days("2024-02-01T00", 3)
    result = read(
        tmp_path, Balloon(times[0], FIVE, announced=9), *(Balloon(t, FIVE) for t in times[1:])
    )

    assert result.usable.tolist() == [False, True, True]
    assert result.why[0].startswith("line 1: 9 levels are announced and 3 follow")


def test_of_a_time_that_stands_twice_the_one_that_can_be_used_is_kept(tmp_path) -> None:
    result = read(
        tmp_path, Balloon("2024-02-01T00", FIVE[:1]), Balloon("2024-02-01T00", FIVE),
        Balloon("2024-02-01T00", jet(30.0)),
    )  # fmt: skip

    assert len(result) == 1
    assert result.counts.tolist() == [3]
    assert "2 soundings of a time that was there already, left out" in result.notes


def test_a_missing_hour_is_that_of_release_or_noon(tmp_path) -> None:
    result = read(
        tmp_path, Balloon("2024-02-01T00", FIVE, release=2310, hour=99),
        Balloon("2024-02-03T00", FIVE, hour=99), Balloon("2024-02-05T00", FIVE, release=2308),
        Balloon("1950-02-05T03", FIVE),
    )  # fmt: skip

    assert result.times.astype(str).tolist() == [
        "1950-02-05T03:00", "2024-02-01T23:10", "2024-02-03T12:00", "2024-02-05T00:00",
    ]  # fmt: skip
    assert sum("without an hour" in note for note in result.notes) == 2


def test_soundings_of_two_stations_are_not_mixed(tmp_path) -> None:
    other = Balloon("2024-02-02T00", FIVE, station="ZZM00099999")
    with pytest.raises(tv.InputError, match="of one station; got ZZM00088801 .* and ZZM00099999"):
        read(tmp_path, Balloon("2024-02-01T00", FIVE), other)

    assert len(tv.read_soundings(tmp_path / "station-data.txt", station="ZZM00099999")) == 1


def test_derived_parameters_are_refused_by_name(tmp_path) -> None:
    path = write(tmp_path / "station-drvd.txt", [Balloon("2024-02-01T00", FIVE)])
    with pytest.raises(tv.InputError, match="derived parameters of IGRA in other columns"):
        tv.read_soundings(path)


def test_a_folder_holds_single_soundings_and_pages_that_are_none(tmp_path) -> None:
    head = "time,pressure_hPa,geopotential height_m,wind direction_degree,wind speed_m/s\n"
    rows = [f"{{}},{p},{h},270,{v}\n" for p, h, v in ((1000, 100, 5), (500, 5500, 40))]
    for name, when in (
        ("a.csv", "2024-02-15 11:02:03"), ("XMR_2024021600.csv", "-"), ("nodate.csv", "-"),
    ):  # fmt: skip
        (tmp_path / name).write_text(head + "".join(rows).format(when, when))
    (tmp_path / "fast.2024-02-17_00.csv").write_text(
        "height_m,speed_kt,direction_deg\n0,10,270\n9000,300,270\n"
    )
    (tmp_path / "slow.2024-02-17_12.csv").write_text(
        "height_m,speed_kt,direction_deg\n0,10,270\n9000,100,270\n"
    )
    (tmp_path / "missing.txt").write_text("Sorry, unable to generate a list for this time\n")
    soundings = tv.read_soundings(tmp_path)

    assert soundings.times.astype(str).tolist() == [
        "2024-02-15T11:02", "2024-02-16T00:00", "2024-02-17T00:00", "2024-02-17T12:00",
    ]  # fmt: skip
    assert soundings.usable.tolist() == [True, True, False, True]
    assert "154.333 m/s, above 130" in soundings.why[2]
    assert soundings[3].speed[1] == pytest.approx(100 * 1852 / 3600)
    assert any("files without a sounding, left out" in note for note in soundings.notes)
    assert any("no date in it" in note and "nodate.csv" in note for note in soundings.notes)


def test_the_user_may_say_the_times(tmp_path) -> None:
    for name in "ab":
        (tmp_path / f"{name}.csv").write_text(
            "height_m,speed_kt,direction_deg\n0,10,270\n9000,99,270\n"
        )
    files = [tmp_path / "a.csv", tmp_path / "b.csv"]
    soundings = tv.read_soundings(files, times=["2024-02-02T00", "2024-02-01T12"])

    assert soundings.times.astype(str).tolist() == ["2024-02-01T12:00", "2024-02-02T00:00"]
    with pytest.raises(tv.InputError, match="no date in it"):
        tv.read_soundings(files)


def test_slices_masks_and_profiles_hold_the_same_levels(tmp_path) -> None:
    rng = np.random.default_rng(1)
    tops = [float(top) for top in rng.uniform(15e3, 30e3, 9)]
    times = days("2024-02-01T00", 9)
    result = read(
        tmp_path, *(Balloon(t, jet(40.0, top)) for t, top in zip(times, tops, strict=True))
    )
    made = tv.winds.Soundings.from_profiles(list(result)[::-1], result.times[::-1], result.station)

    assert np.array_equal(made.height, result.height)
    assert np.array_equal(made.east, result.east)
    some = result[np.arange(9) % 2 == 1]
    assert all(np.array_equal(some[k].height, result[2 * k + 1].height) for k in range(4))
    assert len(result[2:4]) == 2
    assert np.array_equal(result[-1].height, result[8].height)


def test_a_reader_tells_how_far_it_is(tmp_path) -> None:
    calls: list[tuple[int, int]] = []
    read(tmp_path, Balloon("2024-02-01T00", FIVE), progress=lambda *now: calls.append(now))

    size = (tmp_path / "station-data.txt").stat().st_size
    assert calls[-1] == (size, size)


def test_a_zip_of_something_else_is_refused(tmp_path) -> None:
    for name, text in (("a.zip", "height_m,speed_kt\n1,2\n"), ("b.zip", "")):
        with zipfile.ZipFile(tmp_path / name, "w") as packed:
            packed.writestr("a.txt", text)
        with pytest.raises(tv.InputError, match="1 station file without a header"):
            tv.read_soundings(tmp_path / name)
    (tmp_path / "c.zip").write_bytes(b"PK no zip")
    with pytest.raises(tv.InputError, match="is no zip that can be read"):
        tv.read_soundings(tmp_path / "c.zip")
