"""`tvclin ascent` and its figure, and the gust of `tvclin study`."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import tvclin as tv
from tests.turns import usual
from tvclin.cli.app import app
from tvclin.plots import curves_of, sizing_chart
from tvclin.requirement.flight.request import SizingRequest


def gust_of(peak_deg, **more):
    """Return the options of a gust of 2 s; `more`: further keys."""
    keys = {"peak_deg": peak_deg, "duration_s": 2} | more
    return tuple(word for key, value in keys.items() for word in ("--set", f"gust.{key}={value}"))


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, list(arguments))


SOUNDINGS = Path(__file__).parents[1] / "soundings"
WIND, LOW = str(SOUNDINGS / "wyoming.txt"), str(SOUNDINGS / "low.csv")
OTHER = str(SOUNDINGS / "igra.txt")
BAD = str(SOUNDINGS / "bad.csv")
FLOWN = ("--winds", WIND, "--azimuth-deg", "90")
FAST = ("--every", "10", "--from", "60", "--to", "80", "--dead-band", "1")


@pytest.mark.thorough
def test_a_dead_band_below_one_is_said_to_trust_a_forecast() -> None:
    said = "K below 1 trusts a forecast"
    given = ("ascent", "configuration-ii", *FAST, "--more")
    assert said not in run(*given).output
    assert said in run(*given, "--dead-band", "0.5").output


def test_json_equals_the_library() -> None:
    offsets = (
        "--set",
        "size.dispersion_percent=30",
        "--set",
        "size.thrust_offset_deg=0.1",
        "--set",
        "size.gravity_offset_m=0.05",
    )
    given = (*FAST, *offsets, "--limit-deg", "0.4", "--json", "--peak-speed", "60")
    result = run("ascent", "configuration-ii", *given)
    document = json.loads(result.stdout)
    schedule = tv.load_schedule("configuration-ii")

    def wind_at(vehicle: tv.Vehicle) -> tv.TriangularWind:
        peak = tv.angle_from_speed(60.0, vehicle.velocity, vehicle.attitude)
        return tv.TriangularWind(peak=peak, duration=7.5)

    times = [60.0, 70.0, 80.0]
    sizing = tv.size(schedule, {"w": wind_at}, times=times, dead_bands=1.0)
    counted = tv.requirement.Requirement(varying=True, direction="head")
    needs = np.radians(document["required_deg"][counted.label])
    pulse = tv.ShapedWind("triangular", 0.05, 7.5)
    studies = [
        tv.Study.of(tv.Case(vehicle=v, wind=pulse.with_speed(60.0, v, "pitch"), sign="head"))
        for v in map(schedule.at, times)
    ]
    ratios = np.array([[study.ratio_to_nominal] for study in studies])
    # at 60 s the path is quick, and what a head wind adds is not a factor on what the flight does
    expected = sizing.required["K = 1, varying"] * ratios
    assert needs[1:] == pytest.approx(expected[1:], rel=0.005)
    assert needs[0] == pytest.approx(expected[0], rel=0.03)
    for name, values in sizing.required.items():
        assert document["required_deg"][name.label] == np.degrees(values).tolist()
    # the largest total is between the listed times: that of this time by itself
    time = document["total"]["time_s"]
    assert document["total"]["listed_s"] == [60.0, 70.0]
    at_time = run("ascent", "configuration-ii", *given, "--from", str(time), "--to", str(time))
    needs = np.radians(json.loads(at_time.stdout)["required_deg"][counted.label])
    at_time = tv.size(schedule, {"w": wind_at}, times=time, dead_bands=1.0)
    total = tv.worst_total(
        replace(at_time, required=at_time.required | {counted: needs}),
        counted,
        dispersion=0.3,
        thrust_offset=np.radians(0.1),
        gravity_offset=0.05,
        limit=np.radians(0.4),
    )
    assert document["total"]["total_deg"] == pytest.approx(np.degrees(total.total), rel=1e-9)
    assert document["verdict"]["sufficient"] is total.sufficient
    assert result.exit_code == (0 if total.sufficient else 1)


def test_the_table_the_csv_and_the_exit_code(tmp_path) -> None:
    table, picture = tmp_path / "a.csv", tmp_path / "a.png"
    given = ("ascent", "configuration-i", *FAST, "--csv", str(table), "--plot", str(picture))
    sufficient = run(*given, "--limit-deg", "0.6", "--set", "size.reserve_percent=10", "--more")
    short = run(
        "ascent", "configuration-i", *FAST, "--limit-deg", "0.5", "--set", "size.count=trim"
    )

    assert sufficient.exit_code == 0
    assert re.search(
        r"deg: SUFFICIENT, 0\.0\d+ deg remaining after the reserve; budget", sufficient.output
    )
    assert "budget, with 10 % in reserve" in sufficient.output
    assert short.exit_code == 1
    assert re.search(r"deg: NOT SUFFICIENT, short by 0\.1\d+ deg; budget", short.output)
    rows = table.read_text().splitlines()
    assert rows[0].startswith("time_s,wind,trim_deg,K1_deg,no_forecast_deg,minimum_deg")
    assert [row.split(",")[0] for row in rows[1:]] == ["60.0", "70.0", "80.0"]
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_a_wind_beyond_one_pole_is_marked(tmp_path) -> None:
    result = run(
        "ascent", "configuration-i", "--duration", "35", "--from", "66", "--to", "66", "--frozen"
    )
    assert result.exit_code == 0
    assert "is beyond the single-pole theory" in " ".join(result.output.split())
    assert any(line.split()[-1:] == ["1~"] for line in result.output.splitlines())


@pytest.mark.thorough
def test_the_frozen_vehicle_stands_beside_the_one_that_changes_with_how_far_it_is_off() -> None:
    along = ("ascent", "configuration-i", "--duration", "35", "--from", "66", "--to", "66")
    result = run(*along, "--more")
    assert any(line.split()[-1:] == ["1"] for line in result.output.splitlines())
    computed = json.loads(run(*along, "--json").stdout)["required_deg"]
    off = 100.0 * (computed["K = 1"][0][0] / computed["K = 1, varying"][0][0] - 1.0)
    table = result.output.split("frozen at each flight time")[1]
    assert f"{off:.1f}" in table.split()


@pytest.mark.thorough
def test_soundings_stand_beside_a_pulse_that_is_asked_for_and_gusts_on_both() -> None:
    """Flown through along the schedule; the wind of this file blows to one side."""
    schedule = tv.load_schedule("configuration-i")
    whole = tv.read_sounding(WIND).to_wind(schedule, azimuth=np.radians(90))
    gust = tv.OneMinusCosineGust(peak=np.radians(1), duration=2.0)
    winds = {
        "pulse": tv.TriangularWind(peak=np.radians(5), duration=7.5) + gust.shift(2.75),
        "sounding": lambda vehicle: whole + gust.shift(float(vehicle.time) - 1.0),
    }
    placing = {"sounding": "flight"}  # of the history; a measured wind places itself
    options = {"times": [55.0, 65.0], "dead_bands": 1.0, "window": 16.0, "placing": placing}
    expected = tv.size(schedule, winds, **options)
    given = (
        "--from",
        "55",
        "--to",
        "65",
        "--set",
        "sounding.window_s=16",
        *gust_of(1, peak_time_s=3.75),
        "--json",
    )
    given += ("--set", "study.sign=frozen")  # in the dynamic pressure of calm air, as the histories
    pulse = ("--duration", "7.5")
    document = json.loads(run("ascent", "configuration-i", *FLOWN, *pulse, *FAST, *given).stdout)

    assert document["winds"][1] == "wyoming.txt, gust of 1 deg, 2 s"
    for one, values in expected.required.items():
        np.testing.assert_allclose(
            document["required_deg"][one.label], np.degrees(values), rtol=1e-9, err_msg=one.label
        )
    assert any("geopotential heights made geometric" in note for note in document["notes"])
    side = ("--to", "60", "--plane", "yaw", "--json")
    yaw = json.loads(run("ascent", "configuration-i", *FLOWN, *FAST, *side).stdout)
    across = tv.read_sounding(WIND).to_wind(schedule, azimuth=np.radians(90), plane="yaw")
    B = tv.Coefficients.from_vehicle(schedule.at(60.0), "yaw").B
    at = across(np.linspace(*schedule.span, 40001))
    assert yaw["winds"] == ["wyoming.txt"]
    assert yaw["required_deg"]["trim"][0][0] == pytest.approx(
        np.degrees(abs(B) * np.abs(at).max()), rel=1e-4
    )


@pytest.mark.thorough
@pytest.mark.parametrize(
    "given",
    [
        ("ascent", "configuration-i", "--from", "60", "--to", "60", "--dead-band", "1"),
        ("fly", "configuration-i", "--limit-deg", "2"),
        ("boundary", "configuration-i"),
    ],
)
def test_the_title_names_the_gust_on_a_sounding(given) -> None:
    """Of the whole flight, of one flight time, and of the theory."""
    gust = "--set", "gust.peak_deg=1", "--set", "gust.duration_s=0.5"
    title = " ".join(run(*given, *FLOWN, *gust).output.split()).partition(" Note")[0]
    assert "wyoming.txt" in title
    assert "gust of 1 deg, 0.5 s" in title


@pytest.mark.thorough
def test_a_sounding_is_flown_through_alone_and_its_end_leaves_the_flight_open(tmp_path) -> None:
    """Enough where the wind is known is not enough; a pulse joins only where one is named.

    The sounding has four levels, so that the wind between them is not known either.
    """
    gap, end = "from 5.71 to 12 km and in 1 other gap", "above 12.0 km (66.19 s)"
    given = ("ascent", "configuration-i", *FLOWN, "--dead-band", "1", "--every", "20")
    sufficient = run(*given, "--limit-deg", "0.7", "--more")
    lower = run(*given, "--limit-deg", "0.7", "--to", "65", "--json")
    short, unasked = run(*given, "--limit-deg", "0.3", "--json"), run(*given, "--json")
    other = run(*given, "--peak-deg", "2", "--to", "65", "--more")

    assert (sufficient.exit_code, short.exit_code) == (1, 1)
    assert (lower.exit_code, unasked.exit_code) == (1, 0)
    assert "Limit 0.700 deg: NOT KNOWN; required" in sufficient.output
    where = f"; required deflection NOT KNOWN {end}, {gap}"
    assert where in " ".join(sufficient.output.split())
    document, below = json.loads(short.stdout), json.loads(lower.stdout)
    assert document["winds"] == ["wyoming.txt"]
    assert document["times_s"] == [41.0, 60.0, 80.0, 100.0, 116.0]
    assert [row[0] for row in document["known"]] == [True, True, False, False, False]
    assert [row[0] is None for row in document["required_deg"]["K = 1"]] == [False] * 2 + [True] * 3
    assert document["verdict"]["sufficient"] is False
    of_gap = f"{gap}, in a gap of wyoming.txt (known with more levels)"
    assert json.loads(unasked.stdout)["verdict"]["not_sized"] == [end, of_gap]
    assert (below["verdict"]["sufficient"], below["verdict"]["not_sized"]) == (None, [of_gap])
    assert below["known_times_s"][0][1] == pytest.approx(66.19, abs=0.01)
    assert "by wind" in other.output
    assert "by wind" not in sufficient.output
    rows = [line.split() for line in other.output.splitlines() if line.startswith("  wyoming.txt")]
    worst = below["worst_by_wind"]["wyoming.txt"]["K = 1, varying"]
    assert float(rows[0][2]) == pytest.approx(worst["deflection_deg"], abs=0.01)


@pytest.mark.thorough
@pytest.mark.parametrize("more", [(), ("--more",)])
def test_marks_at_the_end_of_rows_are_explained_above_them(more) -> None:
    given = ("ascent", "configuration-i", "--every", "20")
    marked, plain = run(*given, "--from", "41", *more).output, run(*given, *more).output
    meaning = "Required deflection [deg]; +: the wind extends beyond the schedule"

    assert any(line.rstrip().endswith(" +") for line in marked.splitlines())
    assert marked.count(meaning) == 1
    assert meaning not in plain


@pytest.mark.thorough
def test_a_gap_of_a_sounding_says_which_flight_times_are_before_it(tmp_path) -> None:
    """The sounding has no level from 20 to 25 km, and the flight passes 20 km at about 86 s."""
    levels = [0, *range(1000, 20001, 1000), *range(25000, 46000, 1000)]
    lines = ["altitude_m,speed_m_per_s,direction_deg", *(f"{level},9,270" for level in levels)]
    (tmp_path / "gap.csv").write_text("\n".join(lines))
    given = ("ascent", "configuration-i", "--winds", str(tmp_path / "gap.csv"))
    given += ("--azimuth-deg", "90", "--limit-deg", "3", "--every", "20")
    shown = run(*given)
    words = " ".join(shown.output.split())
    cure = re.search(r"in a gap of gap.csv \(known with more levels or (--to) ([\d.]+)\)", words)

    assert shown.exit_code == 1
    assert cure, words
    assert run(*given, *cure.groups()).exit_code == 0
    assert run(*given, "--to", str(float(cure[2]) + 0.02)).exit_code == 1


@pytest.mark.thorough
def test_flight_times_include_both_ends_of_the_flight() -> None:
    """A pulse of 7.5 s fits whole into 41 to 116 s from 44.75 to 112.25 s."""
    document = json.loads(run("ascent", "configuration-i", "--every", "20", "--json").stdout)
    assert document["times_s"] == [44.75, 60.0, 80.0, 100.0, 112.25]
    assert any("first flight time, 44.75 s; before it" in note for note in document["notes"])
    until = run("ascent", "configuration-i", "--to", "62", "--every", "20").output
    assert "flight times before 44.75 s are left out" in " ".join(until.split())
    assert "--from 41 takes them in" in " ".join(until.split())
    given = ("--from", "50", "--to", "51", "--every", "0.1", "--json")
    times = json.loads(run("ascent", "configuration-i", *given).stdout)["times_s"]
    assert times == pytest.approx(np.arange(500, 511) / 10)


def test_a_measured_wind_counts_to_the_side_of_its_peak() -> None:
    """What blows to the other side is left out, exactly between the samples."""
    times, angles = [50.0, 60.0, 66.0, 70.0, 80.0], np.array([0.02, 0.02, -0.04, -0.05, 0.05])
    encountered = tv.ascent.MeasuredWind(tv.SampledWind(time=times, angle=angles), window=20.0)
    vehicle = tv.load_vehicle("configuration-i")
    around = encountered(vehicle.replace(time=66.0))

    assert around([56.0, 61.9, 62.0, 66.0, 70.0, 74.9, 75.1, 75.99]) == pytest.approx(
        [0.0, 0.0, 0.0, -0.04, -0.05, -0.001, 0.0, 0.0], abs=1e-15
    )
    assert (around.onset, around.end) == pytest.approx((62.0, 75.0))
    gusty = tv.ascent.MeasuredWind(
        encountered.wind, 20.0, tv.OneMinusCosineGust(peak=0.01, duration=2.0)
    )
    assert gusty(vehicle.replace(time=66.0))(66.0) == pytest.approx(-0.05)
    assert not np.any(encountered(vehicle.replace(time=30.0))([30.0, 52.0, 66.0]))


@pytest.mark.parametrize(("name", "lasts", "edge"), [("i", 26.5, 31.8), ("ii", 27.3, 40.7)])
def test_a_jet_stream_of_10_km_lies_within_the_single_pole_theory(name, lasts, edge) -> None:
    """At the time of Table I, and for any other: the whole triangle, where it was encountered."""
    schedule = tv.load_schedule(f"configuration-{name}")
    time = float(tv.load_vehicle(f"configuration-{name}").time)
    middle = np.interp(time, schedule.time, schedule.height)
    height = np.concatenate([middle + np.array([-5e3, 0.0, 5e3]), [60e3]])
    jet = tv.WindProfile(height=height, east=[0.0, 69.4, 0.0, 0.0], north=np.zeros(4))
    encountered = tv.fly_through(jet, schedule, azimuth=np.radians(90))
    sizing = tv.size(schedule, encountered, times=[time, 110.0, schedule.span[1]], dead_bands=1.0)

    assert (sizing.ends - sizing.begins)[0, 0] == pytest.approx(lasts, abs=0.05)
    assert sizing.edge[0] == pytest.approx(edge, abs=0.05)
    assert not sizing.beyond_single_pole.any()
    late = tv.fly_through(jet, schedule, azimuth=np.radians(90), window=10.0)
    assert tv.size(schedule, late, times=schedule.span[1]).required["K = 1"][0, 0] == 0.0
    plant = tv.Plant.from_vehicle(schedule.at(time), "drift-exact")
    whole = tv.required_deflection(plant, encountered.wind)
    assert sizing.required["K = 1"][0, 0] == pytest.approx(abs(whole.deflection), rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "words"),
    usual(
        [
            (("nowhere.csv",), "nowhere.csv"),
            (
                ("configuration-i", "--from", "90", "--to", "60"),
                "between --from and --to, which must be in this order; got 90 to 60 s",
            ),
            (("configuration-i", "--to", "900"), "time must be between 41 and 116 s"),
            (
                ("configuration-i", "--peak-deg", "5", "--peak-speed", "40"),
                "give --peak-deg or --peak-speed, not both",
            ),
            (("configuration-i", "--every", "0"), "every must be positive"),
            (("configuration-i", "--every", "1e-9"), "at most 10000 flight times"),
            (("configuration-i", "--set", "size.count=K=1", *FAST), "count must be one of trim"),
            (("configuration-i", "--limit-deg", "-1"), "--limit-deg must be positive"),
            (
                ("configuration-i", "--set", "size.reserve_percent=100", *FAST),
                "reserve must be a part of the limit",
            ),
            (("configuration-i", "--wind", "square"), "wind must be one of"),
            (("configuration-i", "--winds", "no.csv", "--azimuth-deg", "90"), "no.csv"),
            (("configuration-i", "--winds", WIND), "--winds needs --azimuth-deg"),
            (("configuration-i", "--azimuth-deg", "90"), "--azimuth-deg needs a sounding"),
            (
                ("configuration-i", "--winds", BAD, "--azimuth-deg", "90"),
                "bad.csv, line 3: direction must be between 0 and 360 degrees; got 400",
            ),
            (
                ("configuration-i", *FLOWN, "--set", "sounding.window_s=0", *FAST),
                "window_s in [sounding] must be positive",
            ),
            (
                ("configuration-i", "--winds", LOW, "--azimuth-deg", "90", *FAST),
                "low.csv: the flight does not reach the wind: it goes from 3045.19",
            ),
        ],
        *(0, 1, 2, 3, 4, 5, 7, 9, 10, 11, 12, 13, 14, 15),
    ),
)
def test_bad_input_is_one_sentence_and_exit_code_2(arguments, words) -> None:
    result = run("ascent", *arguments)

    assert result.exit_code == 2
    assert words in result.output
    assert "Traceback" not in result.output


def test_a_figure_of_one_flight_time_is_refused_before_anything_is_computed(monkeypatch) -> None:
    monkeypatch.setattr(SizingRequest, "sizing", None)
    result = run("ascent", "configuration-i", "--from", "66", "--to", "66", "--plot", "a.png")

    assert result.exit_code == 2
    (said,) = result.stderr.splitlines()
    assert "two or more flight times; got 66 s alone (--from, --to, --every)" in said


def test_the_figure_holds_the_worst_of_all_winds() -> None:
    schedule = tv.load_schedule("configuration-i")
    winds = {k: tv.TriangularWind(peak=p, duration=7.5) for k, p in (("a", 0.02), ("b", -0.06))}
    sizing = tv.size(schedule, winds, times=[80.0, 60.0], dead_bands=1.0)
    curves = curves_of(sizing_chart(sizing, np.radians(0.5)))

    assert curves.abscissa.tolist() == [60.0, 80.0]
    assert curves.column("K = 1").tolist() == np.degrees(sizing.required["K = 1"][::-1, 1]).tolist()
    minimum = np.degrees(sizing.required["minimum"][::-1, 1]).tolist()
    assert curves.column("lower bound, wind known").tolist() == minimum
    assert curves.column("available limit") == pytest.approx([0.5, 0.5])


@pytest.mark.thorough
def test_a_gust_on_top_of_the_wind_is_added_when_it_is_asked_for() -> None:
    document = json.loads(
        run(
            *("study", *gust_of(1.5, peak_time_s=3.75), "--model", "fixed-path"),
            *("--sign", "frozen", "--json"),
        ).stdout
    )
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "fixed-path")
    gust = tv.OneMinusCosineGust(peak=np.radians(1.5), duration=2.0).shift(2.75)
    both = tv.TriangularWind(peak=np.radians(5), duration=7.5) + gust
    expected = abs(np.degrees(tv.boundary_limit(plant, both).deflection))

    assert document["verdict"]["required_deflection_deg"] == pytest.approx(expected, rel=1e-12)
    assert document["gust"]["peak_deg"] == pytest.approx(1.5)
    assert document["trim_deflection_deg"] == pytest.approx(6.5 * float(plant.coefficients.B))
    late = run("study", *gust_of(1.5, peak_time_s=6))
    assert "with a gust of 1.5 deg and 2 s at 6 s" in " ".join(late.output.split())


def test_a_gust_that_cannot_be_is_refused() -> None:
    for arguments, words in (
        (("--gust", "0", "2"), "--gust (peak) must be other than zero"),
        (("--gust", "1", "-2"), "--gust (duration) must be positive"),
        (gust_of(-3, peak_time_s=8), "must not change its sign"),
        (gust_of(1, peak_time_s=8.5), "lies outside the wind, which lasts from 0 to 7.5 s"),
        (gust_of(1, peak_time_s=-1), "the gust of 2 s with its middle at -1 s lies outside"),
    ):
        result = run("study", *arguments)
        assert (result.exit_code, words in result.output) == (2, True), result.output


@pytest.mark.parametrize(
    ("command", "place"),
    [("fly", "the vehicle's"), ("disperse", "the vehicle's"), ("ascent", "each flight")],
)
def test_a_gust_on_a_sounding_has_no_time_of_its_own(command: str, place: str) -> None:
    result = run(command, "configuration-i", *FLOWN, *gust_of(1, peak_time_s=3))
    words = "take peak_time_s out of [gust] (gust.peak_time_s), a time in a pulse; with a sounding"
    assert result.exit_code == 2
    assert f"{words} the gust stands at {place} time" in " ".join(result.output.split())


@pytest.mark.thorough
def test_a_title_says_at_which_time_of_flight_the_gust_on_a_sounding_stands() -> None:
    result = run("fly", "configuration-i", *FLOWN, *gust_of(0.5))
    words = "with its gust of 0.5 deg, 2 s, at 66 s of flight"
    assert words in " ".join(result.output.split())


@pytest.mark.thorough
def test_in_soundings_alone_the_vehicle_counts_that_met_them() -> None:
    """Frozen at 43 s the vehicle needs more, which never encountered the jet there."""
    given = ("ascent", "configuration-i", *FLOWN, "--dead-band", "1", "--from", "43", "--to", "63")
    along = json.loads(run(*given, "--every", "20", "--varying", "--json").stdout)
    beside = json.loads(
        run(*given, "--every", "20", "--varying", "--set", "size.count=K = 1", "--json").stdout
    )
    wind = {name: one["total"]["lines"][1] for name, one in (("a", along), ("f", beside))}

    assert wind["a"]["deflection_deg"] == along["worst"]["K = 1, varying"]["deflection_deg"]
    assert wind["f"]["deflection_deg"] == along["worst"]["K = 1"]["deflection_deg"]


@pytest.mark.thorough
def test_a_sounding_is_chosen_by_its_time() -> None:
    """Of a file of several, each by itself."""
    noon, midnight = "2024-02-15 12", "2024-02-16 00"
    given = ("--azimuth-deg", "90", "--from", "41", "--to", "42", "--dead-band", "1", "--json")
    request = [("--winds", OTHER, "--set", f"sounding.time={time}") for time in (noon, midnight)]
    single = [json.loads(run("ascent", *one, *given).stdout) for one in request]
    schedule = tv.load_schedule("configuration-i")
    for k, time in enumerate((noon, midnight)):
        wind = tv.read_sounding(OTHER, time=time)
        encountered = tv.fly_through(wind, schedule, azimuth=np.pi / 2)
        computed = np.degrees(tv.size(schedule, encountered, times=[41.0, 42.0]).required["K = 1"])
        assert single[k]["required_deg"]["K = 1"] == computed.tolist()
        assert not any("choose another by its time" in note for note in single[k]["notes"])
    assert single[0]["required_deg"] != single[1]["required_deg"]
    for wrong, said in {
        ("--winds", OTHER, "--winds", OTHER): "twice",
        ("--winds", OTHER, "--set", "sounding.time=noon"): "has no sounding of time 'noon'",
    }.items():
        result = run("ascent", *wrong, *given)
        assert (result.exit_code, said in result.output) == (2, True), result.output


@pytest.mark.thorough
def test_it_says_which_options_would_tell_more() -> None:
    two = run(
        "ascent", *FLOWN, "--winds", OTHER, "--from", "41", "--to", "42", "--frozen", "--more"
    )
    pulse = run("ascent", "--every", "60")

    assert "--set sounding.window_s 20 counts of a sounding" in two.output
    assert "K = 1 in each wind [deg]" in two.output
    assert "--from 41 --to 116 take them in" in pulse.output
    assert "in each wind" not in pulse.output


@pytest.mark.thorough
def test_a_gust_is_given_by_its_speed_and_stays_at_its_peak() -> None:
    schedule, given = tv.load_schedule("configuration-i"), FAST
    gust = ("--set", "gust.peak_speed_m_per_s=9", "--set", "gust.duration_s=2")
    # as encountered the two are different winds, whose gusts have different worst times
    gust += ("--set", "gust.plateau_s=0.5", "--set", "study.sign=frozen")
    by_speed = json.loads(run("ascent", *given, *gust, "--json").stdout)
    for i, time in enumerate(by_speed["times_s"]):
        vehicle = schedule.at(time)
        peak = np.degrees(tv.angle_from_speed(9.0, vehicle.velocity, vehicle.attitude))
        single = ("--from", str(time), "--to", str(time), "--dead-band", "1")
        single += ("--set", "study.sign=frozen")
        given = gust_of(repr(float(peak)), plateau_s=0.5)
        by_angle = json.loads(run("ascent", *single, *given, "--json").stdout)
        for name, values in by_angle["required_deg"].items():
            if name.endswith("wind"):  # a speed is another angle in a head or a tail wind
                continue
            assert by_speed["required_deg"][name][i] == pytest.approx(values[0], rel=1e-6), name


def test_a_sign_in_the_yaw_plane_is_noted_as_in_a_study() -> None:
    yaw = ("--plane", "yaw", "--from", "66", "--to", "66")
    signed, across = run("ascent", *yaw, "--set", "study.sign=head"), run("ascent", *yaw)
    assert signed.stdout == across.stdout
    assert "sign head is not counted: a wind in the yaw plane" in " ".join(signed.stderr.split())


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (("--set", "gust.plateau_s=1"), "duration"),
        (gust_of(1, plateau_s=2), "must be shorter than the gust"),
        (("--set", "study.sign=up"), "sign"),
        (("--set", "study.sign=head", *FLOWN), "--set study.sign needs a pulse"),
        (
            ("--set", "study.sign=head", "--set", "wind.direction_deg=270", "--azimuth-deg", "90"),
            "leave sign",
        ),
    ],
)
def test_gusts_and_signs_without_meaning_are_refused(given, words) -> None:
    result = run("ascent", *given)
    assert result.exit_code == 2
    assert words in " ".join(result.stderr.split())


@pytest.mark.thorough
def test_both_planes_stand_beside_each_plane_alone() -> None:
    given = ("--set", "wind.direction_deg=270", "--azimuth-deg", "45", "--peak-speed", "50", *FAST)
    both = run(
        "ascent",
        "configuration-i",
        "--plane",
        "both",
        "--set",
        "nozzle.limit_shape=square",
        *given,
        "--more",
    )
    assert "pitch alone misses" in " ".join(both.output.split())
    document = json.loads(
        run(
            "ascent",
            "configuration-i",
            "--plane",
            "both",
            "--set",
            "nozzle.limit_shape=square",
            *given,
            "--json",
        ).stdout
    )
    needed = np.array(document["required_deg"]["K = 1"])
    single = {k: np.array(one["K = 1"]) for k, one in document["separate_deg"].items()}
    pitch = json.loads(run("ascent", "configuration-i", *given, "--json").stdout)
    assert single["pitch"].tolist() == pitch["required_deg"]["K = 1"]
    assert np.all(needed >= np.maximum(single["pitch"], single["yaw"]) * (1.0 - 1e-12))
    misses = np.array(document["pitch_omitted_fraction"]["K = 1"])
    assert misses == pytest.approx(1.0 - single["pitch"] / needed)


def test_both_planes_need_a_direction() -> None:
    for given, said in {
        ("--plane", "both"): "both planes need a wind with a direction",
        ("--azimuth-deg", "9"): "--azimuth-deg needs a sounding, --winds FILE",
        ("--set", "wind.direction_deg=9"): "direction in [wind] needs azimuth (--azimuth-deg)",
        ("--set", "nozzle.limit_shape=oval"): "limit_shape must be one of round",
    }.items():
        result = run("ascent", "configuration-i", *FAST, *given)
        assert result.exit_code == 2
        assert said in " ".join(result.output.split())


@pytest.mark.thorough
def test_a_flight_in_a_pulse_whose_pressure_is_not_known_is_not_known() -> None:
    """It lasts too long to be followed; nominal dynamic pressure alone refuses a limit."""
    arguments = ["ascent", "configuration-i", *FAST, "--duration", "6000", "--limit-deg"]
    for limit, word in (("2", "NOT KNOWN"), ("0.1", "NOT SUFFICIENT")):
        result = CliRunner().invoke(app, [*arguments, limit])
        assert result.exit_code == 1
        assert f"{float(limit):.3f} deg: {word}" in result.stdout
        assert "required deflection NOT KNOWN at the dynamic pressure encountered" in result.stdout
