"""Whatever the schedule and the cut, a flight ends with an answer or a reason in every row."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.schedules.samples import GIVEN, OPENROCKET
from tests.small_launcher import sounding, write
from tests.turns import by_turns
from tvclin.ascent.measured_wind import GustOfSpeed, MeasuredWind
from tvclin.cli.app import app
from tvclin.requirement.flight.flight_winds import PlacedWind, WindOf, placed_in_planes

ARMS = {
    "stable at first": ([0, 25, 35, 122], [-0.5, 0.0, 4.0, 3.0]),
    "with complex pairs": ([0, 40, 50, 60, 70, 122], [3.0, 3.0, 0.005, 0.005, 3.0, 3.0]),
}
SCHEDULES = ["configuration-i", "made-up-launcher", "from the pad", "openrocket", *ARMS]
Cut = tuple[float | None, float | None, float]
"""First and last flight time, and the step between, as parts of the span."""
CUTS: dict[str, Cut] = {
    "as it is": (None, None, 0.35),
    "its first time": (0.0, 0.0, 1.0),
    "its first tenth": (0.0, 0.1, 0.037),
    "its last time": (1.0, 1.0, 1.0),
}
GUST = ("--set", "gust.peak_speed_m_per_s=9", "--set", "gust.duration_s=2")
WINDS: dict[str, tuple[str, ...]] = {
    "a pulse": (),
    "a pulse by its speed": ("--peak-speed", "20", "--duration", "3"),
    "both planes": ("--varying", "--plane", "both", "--set", "wind.direction_deg=200"),
    "a sounding": ("--winds", "wind.csv"),
    "a gust on it": ("--winds", "wind.csv", "--plane", "both", *GUST),
}

PAGE = """
[study]
vehicle = "made-up-launcher"
[[wind]]
shape = "triangular"
peak_deg = 5.0
duration_s = 3.0
[[wind]]
sounding = "{folder}/wind.csv"
azimuth_deg = 90
[gust]
peak_speed_m_per_s = 9
duration_s = 2.0
[nozzle]
limit_deg = 3.0
[schedule]
source = "{schedule}"
[size]
every_s = 30.0
{until}[availability]
archive = "{folder}"
azimuth_deg = 90
least_part = 0.9
"""


@pytest.fixture(scope="module")
def sources(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return the sources of the commands, by the names above."""
    folder = tmp_path_factory.mktemp("schedules")
    computed = {name: name for name in SCHEDULES[:2]}
    computed["from the pad"] = str(write(folder / "pad.csv"))
    computed["openrocket"] = str(folder / "rocket.csv")
    tv.ascent.read_openrocket(OPENROCKET, **dict[str, Any](GIVEN)).to_csv(computed["openrocket"])
    flight = tv.load_schedule(computed["from the pad"])
    for name, bent in ARMS.items():
        arm = np.interp(flight.times, *bent)
        computed[name] = str(folder / f"{len(computed)}.csv")
        turned = flight.vehicle.replace(aerodynamic_arm=arm)
        tv.FlightSchedule(turned, altitude=flight.height).to_csv(computed[name])
    wind = sounding()
    rows = np.column_stack([wind.height, wind.east, wind.north])
    lines = [",".join(f"{x:.9g}" for x in row) for row in rows]
    for k in range(3):
        text = "\n".join(["height_m,east_m_per_s,north_m_per_s", *lines]) + "\n"
        (folder / f"2024-02-0{k + 1}.csv").write_text(text)
    (folder / "wind.csv").write_text(text)
    return computed | {"folder": str(folder)}


def document(*arguments: str) -> dict[str, Any]:
    """Return what a command says as JSON; it may say that a limit is not enough."""
    result = CliRunner().invoke(app, [*arguments, "--json"])
    assert result.exit_code in (0, 1), result.output
    answer: dict[str, Any] = json.loads(result.stdout)
    return answer


def cut_of(source: str, cut: str, *, every: bool) -> list[str]:
    first, last = tv.load_schedule(source).span
    start, stop, step = CUTS[cut]
    ends = {"--from": start, "--to": stop}
    cuts = [f"{k}={first + x * (last - first)}" for k, x in ends.items() if x is not None]
    return [*cuts, f"--every={step * (last - first)}"] if every else cuts


def place(wind: WindOf, vehicle: tv.Vehicle, time: float) -> PlacedWind:
    """Return a wind in the pitch plane, its place its own."""
    return placed_in_planes(("pitch",), wind, vehicle, time, "peak", 1.0)["pitch"]


@pytest.mark.thorough
@by_turns("wind, schedule, cut", WINDS, SCHEDULES, CUTS, each=29)
def test_each_row_of_a_sizing_has_a_number_or_a_reason(
    sources: dict[str, str], schedule: str, cut: str, wind: str
) -> None:
    source, folder = sources[schedule], Path(sources["folder"])
    options = [str(folder / one) if one.endswith("csv") else one for one in WINDS[wind]]
    toward = ["--azimuth-deg", "70"] if options and "--peak-speed" not in options else []
    result = document("ascent", source, *options, *toward, *cut_of(source, cut, every=True))
    known = np.array(result["known"])
    for name, needs in result["required_deg"].items():
        there = np.array(needs, dtype=float)
        assert np.all(np.isnan(there[~known]))
        assert np.all(there[known & ~np.isnan(there)] >= 0.0)
        if np.any(np.isnan(there)):
            assert result["notes"], name
    if not known.all():
        assert result["verdict"]["not_sized"]
        assert result["verdict"]["sufficient"] is not True


@pytest.mark.thorough
@by_turns("schedule, cut", SCHEDULES, ["as it is", "its first tenth"], each=11)
def test_each_sounding_is_judged_or_said_to_be_unknown(
    sources: dict[str, str], schedule: str, cut: str
) -> None:
    where = [sources["folder"], "--azimuth-deg", "70", "--limit-deg", "1"]
    part = cut_of(sources[schedule], cut, every=False)
    (computed,) = document("availability", sources[schedule], *where, *part)["towards"]
    assert computed["flown"] <= computed["judged"]
    assert computed["judged"] + computed["unknown"] == 3


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("schedule", "until"),
    [
        ("from the pad", "to_s = 40\n"),
        ("openrocket", ""),
        ("stable at first", "to_s = 40\n"),  # unstable from 27 s on
        ("with complex pairs", "to_s = 75\n"),  # from 50 to 60 s
    ],
)
def test_the_page_of_a_flight_is_written(
    sources: dict[str, str], schedule: str, until: str, tmp_path: Path
) -> None:
    study = tmp_path / "study.toml"
    study.write_text(PAGE.format(folder=sources["folder"], schedule=sources[schedule], until=until))
    page = tmp_path / "page.html"
    result = CliRunner().invoke(app, ["report", str(study), "-o", str(page)])
    assert result.exit_code in (0, 1), result.output
    assert ("Required deflection NOT KNOWN" in page.read_text()) == (schedule != "openrocket")


@pytest.mark.thorough
def test_a_flight_that_is_known_nowhere_is_not_known_to_be_covered(
    sources: dict[str, str],
) -> None:
    wind = ("--winds", str(Path(sources["folder"]) / "wind.csv"), "--azimuth-deg", "70")
    pad = ("ascent", sources["from the pad"], "--to=0.5", "--from=0.5", "--limit-deg", "3")
    for winds in (wind, ("--peak-speed", "20")):
        result = CliRunner().invoke(app, [*pad, *winds])
        assert result.exit_code == 1
        assert "Limit 3.000 deg: NOT KNOWN; required deflection NOT KNOWN" in result.output
        assert "SUFFICIENT" not in result.output
        assert " meets the flight at more than 30 deg" in result.output or "20 m/s" in result.output


def test_a_pulse_by_its_speed_is_known_up_to_thirty_degrees() -> None:
    """Half the speed of flight across the path meets it at 30 deg."""
    flight = tv.load_schedule("configuration-i")
    vehicle = flight.at(60.0)
    half = 0.5 * float(vehicle.velocity) / float(np.sin(vehicle.attitude))
    at = ("ascent", "configuration-i", "--from", "60", "--to", "60", "--frozen", "--dead-band", "1")
    just, beyond = (document(*at, "--peak-speed", f"{half * x:.9g}") for x in (0.999, 1.001))
    assert (just["known"], beyond["known"]) == ([[True]], [[False]])
    assert "meets the flight at 30.03 deg, and above 30 deg" in beyond["notes"][0]


@pytest.mark.thorough
def test_a_gust_by_its_speed_counts_on_top_of_a_sounding_up_to_thirty_degrees(
    sources: dict[str, str],
) -> None:
    flight = tv.load_schedule(sources["from the pad"])
    gust = GustOfSpeed(tv.OneMinusCosineGust(peak=0.01, duration=2.0), 9.0, "pitch")
    encountered = tv.fly_through(sounding(), flight, azimuth=np.radians(90.0), gust=gust)
    times = np.arange(4.0, 20.0)
    placed = [place(encountered, flight.at(t), t) for t in times.tolist()]
    assert isinstance(encountered, MeasuredWind)
    vehicle = flight.at(times)
    angle = np.abs(encountered.wind(times)) + tv.angle_from_speed(
        np.minimum(9.0, vehicle.velocity), vehicle.velocity, vehicle.attitude
    )
    known = [one.known for one in placed]
    assert known == (angle <= np.radians(30.0)).tolist()
    assert {False, True} == set(known)
    assert all(one.why for one in placed if not one.known)
