"""Hostile files and names: one sentence and exit code 2, never a traceback."""

from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

import tvclin as tv
from tvclin.cli.app import app
from tvclin.vehicle.vehicle_file import template

LONG = "x" * 300
"""No file system takes a name of so many letters."""
VEHICLE = template()
WIND = "[wind]\npeak_deg = 5\nduration_s = 7.5\n"
STUDY = f'[study]\nvehicle = "configuration-i"\n{WIND}'
SCHEDULE = """
[schedule]
time_s = [1, 2]
weight_N = 1.5e6
moment_of_inertia_kg_m2 = 2e7
thrust_N = 2.5e6
aerodynamic_arm_m = 9
control_arm_m = 23
velocity_m_per_s = 400
attitude_deg = 60
normal_force_slope_N_per_rad = 9e5
axial_force_N = 1e5
"""
CAMPAIGN = f'[campaign]\nvehicle = "configuration-i"\ncases = 10\n{WIND}'


@pytest.fixture(autouse=True)
def _says_not_how_far_it_is(monkeypatch) -> None:
    """A slow machine would tell."""
    monkeypatch.setattr("tvclin.cli.output._LINE_INTERVAL_S", float("inf"))


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def check_refused(result: Result) -> str:
    """Assert exit code 2 and one sentence of bounded length; return it."""
    assert result.exit_code == 2
    assert isinstance(result.exception, SystemExit), repr(result.exception)
    (said,) = result.stderr.splitlines()
    assert said.startswith("Error: ")
    assert len(said) < 900
    return said


@pytest.mark.parametrize(
    "arguments",
    [
        ("study", LONG),
        ("study", f"{LONG}.toml"),
        ("study", "a/" * 3000),
        ("ascent", f"{LONG}.csv"),
        ("report", "-o", LONG),
        ("init", LONG),
        ("init", "--study", f"{LONG}/my.toml"),
        ("respond", "--csv", LONG),
        ("respond", "--plot", f"{LONG}.png"),
        ("init", "--campaign", LONG),
        ("disperse", LONG, "-o", "results"),
        ("disperse", LONG),
    ],
)
def test_a_name_longer_than_the_file_system_takes_is_one_sentence(arguments) -> None:
    assert LONG not in check_refused(run(*arguments))


@pytest.mark.parametrize(
    "arguments",
    [
        ("ascent", "--csv", "no/x.csv"),
        ("ascent", "--plot", "no/x.png"),
        ("ascent", "--plot", "x.xyz"),
    ],
)
def test_where_an_answer_cannot_be_written_is_told_before_the_work(monkeypatch, arguments) -> None:
    monkeypatch.setattr("tvclin.cli.ascent.case_over_flight", pytest.fail)
    assert "x." in check_refused(run(*arguments))


def test_a_campaign_needs_a_folder_that_can_be(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    file = tmp_path / "many.toml"
    spread = '[[dispersion]]\nparameter = "thrust"\nshape = "uniform"\nspread_percent = 1\n'
    file.write_text(f"{CAMPAIGN}\n{spread}")

    check_refused(run("disperse", file, "-o", tmp_path / LONG))


@pytest.mark.parametrize("name", [LONG, "a\\u0000b"])
@pytest.mark.parametrize(
    "text",
    [
        f'[study]\nvehicle = "NAME"\n{WIND}',
        '[study]\nvehicle = "configuration-i"\n[wind]\nfile = "NAME"\n',
        f'{STUDY}[schedule]\nsource = "NAME"\n',
        f"{STUDY.replace('[wind]', '[[wind]]')}"
        '[[wind]]\nsounding = "NAME"\nazimuth_deg = 90\n[schedule]\nsource = "configuration-i"\n',
    ],
)
def test_no_name_within_a_file_is_a_traceback(tmp_path: Path, text: str, name: str) -> None:
    file = tmp_path / "my.toml"
    file.write_text(text.replace("NAME", name))

    check_refused(run("study", file))


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
def test_a_name_that_just_fits_can_be_written(tmp_path: Path) -> None:
    file = tmp_path / ("x" * 250 + ".toml")

    assert run("init", file).exit_code == 0
    assert file.read_text() == VEHICLE


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[vehicle]\nweight_N = " + "1" * 5000, "more than 4300 digits"),
        ("[vehicle]\nname = 0x" + "f" * 5000, "'name' holds a whole number beyond 1.8e+308"),
        ("[vehicle]\nname = " + "[" * 100 + "]" * 100, "'name' is nested more than 8 levels"),
        ("vehicle" + ".a" * 3000 + " = 1", "'a' is nested more than 8 levels"),
        ("schedule" + ".a" * 3000 + " = 1", "'a' is nested more than 8 levels"),
        ("[schedule]\ntime_s = " + "[" * 900 + "]" * 900, "nested too deep"),
        (f"[vehicle]\n[vehicle.{'n' * 5000}]\n[vehicle.{'n' * 5000}]", "not valid TOML"),
    ],
)
def test_no_number_and_no_nesting_is_a_traceback(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "my.toml"
    file.write_text(text)

    for load in (tv.load_vehicle, tv.load_study, tv.studyfile.load_sizing, tv.load_schedule):
        with pytest.raises(tv.InputError, match=said.replace("+", r"\+")) as caught:
            load(file)
        assert len(str(caught.value)) < 900
    with pytest.raises(tv.InputError, match=said.replace("+", r"\+")):
        tv.studyfile.load_campaign(file)


@pytest.mark.parametrize(
    ("command", "text"),
    [
        ("disperse", f'{CAMPAIGN}[outputs]\nnames = [["boundary"]]\n'),
        ("disperse", f"{CAMPAIGN}[outputs]\ndead_bands = [[1.0]]\n"),
        ("disperse", f'{CAMPAIGN}[[dispersion]]\nparameter = ["thrust"]\npercent = 1\n'),
        ("study", f'{STUDY}[laws]\nnames = [["trim"]]\n'),
        ("study", f"{STUDY}[laws]\nwinds = [{{a = 1}}]\n"),
    ],
)
def test_a_list_where_a_name_belongs_is_one_sentence(tmp_path, command, text) -> None:
    file = tmp_path / "my.toml"
    file.write_text(text)
    where = ["-o", tmp_path / "results"] if command == "disperse" else []

    check_refused(run(*command.split(), file, *where))


@pytest.mark.parametrize(
    ("command", "text"),
    [
        ("study", STUDY.replace("configuration-i", "v" * 5000)),
        ("study", STUDY + "y" * 5000 + " = 1\n"),
        ("study", f"{STUDY}[{'z' * 5000}]\n"),
        ("study", VEHICLE.replace('name = "', 'name = "\\n' + "n" * 5000)),
        ("study", f"{STUDY}[laws]\nnames = {['name' * 9] * 500}\n"),
        ("study", f"{STUDY}[nozzle]\nlimit_deg = {[1] * 5000}\n"),
        ("ascent", SCHEDULE + "k" * 5000 + " = 1\n"),
        ("ascent", f"schedule = {[1] * 3000}\n"),
    ],
)
def test_an_error_does_not_repeat_thousands_of_letters(tmp_path, command, text) -> None:
    file = tmp_path / "my.toml"
    file.write_text(text)

    check_refused(run(command, file))


def test_a_file_of_winds_is_read_as_every_other(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text('[study]\nvehicle = "configuration-i"\n[wind]\nfile = "winds.csv"\n')
    for content in (b"time_s,a\n0," + b"1" * 200_000, b"\xff\xfe", b"time_s,a\n\0,1\n", b""):
        (tmp_path / "winds.csv").write_bytes(content)
        check_refused(run("study", file))


ALL_LAWS = ("--law", "all", "--wind", "triangular")


@pytest.mark.parametrize(
    ("arguments", "bound"),
    [
        (["respond", "--duration", "925140181"], "must be at most 1372 s"),
        (["respond", "--until", "1e-3", "--duration", "1e5"], "must be at most 1372 s"),
        (["fly", "--duration", "1e9"], "must be at most 1824 s long"),
        (["fly", "--peak-speed", "1e-9"], "at least 1.43e-05 deg"),
        (["fly", "--engine", "planar-varying", "--peak-deg", "1e-9"], "at least 1.43e-05 deg"),
        (["fly", *ALL_LAWS, "--sample-rate", "1e-18"], "between 1e-09 and 1e+09"),
        (["fly", *ALL_LAWS, "--sample-rate", "1e9"], "between 0.01 and 1e+06"),
        (["fly", *ALL_LAWS, "--duration", "1e6"], "samples"),
        (
            [
                *(
                    "ascent",
                    "--set",
                    "gust.peak_deg=20",
                    "--set",
                    "gust.duration_s=2e4",
                    "--varying",
                ),
                *("--from", "70", "--to", "71"),
            ],
            "for at most 20000 steps",
        ),
    ],
)
def test_what_arithmetic_or_patience_cannot_carry_is_refused_with_the_bound(arguments, bound):
    assert bound in check_refused(run(*arguments))


@pytest.mark.thorough
def test_a_long_command_shows_a_bar_on_a_terminal_alone() -> None:
    command = ["fly", *ALL_LAWS, "--set", "laws.cuts", "2", "--json"]
    quiet = CliRunner().invoke(app, command)
    shown = CliRunner().invoke(app, command, env={"FORCE_COLOR": "1"})

    assert quiet.stderr == ""
    assert "60 flights" in shown.stderr  # five laws, four scans, the wind and two stops
    assert quiet.stdout == shown.stdout


def test_the_air_stays_what_it_is_far_beyond_the_atmosphere() -> None:
    from tvclin.ascent.atmosphere import HIGHEST, LOWEST, air_at, density_at

    for height in (-1e9, -6_356_766.0, -1e5, LOWEST, 0.0, HIGHEST, 2e5, 1e9, 1e300):
        assert density_at(height) == pytest.approx(float(air_at(height).density), rel=1e-12)
        assert 0.0 < density_at(height) < 10.0


def test_a_weak_wind_along_the_trajectory_takes_no_more_steps_than_a_strong_one() -> None:
    """The altitude [m] once had the smallest error of an angle [rad], which is its rounding."""
    from tvclin.ascent.nominal_flight import load_flight_condition
    from tvclin.flights.closed_loop.continuous import ContinuousFlight, Loop
    from tvclin.flights.planar import planar_case

    vehicle = tv.load_vehicle("configuration-i")
    condition = load_flight_condition("configuration-i")
    counts = []
    for peak in (1e-2, 1e-5):
        wind = tv.TriangularWind(peak=peak, duration=7.5).shift(62.0)
        case = planar_case(
            vehicle, wind, (62.0, 75.0), plane="pitch", drift=True, condition=condition
        )
        law = tv.TrimLaw(tv.Plant.from_vehicle(vehicle, "fixed-path"))
        loop = Loop(case.motion, law, 0.2 * peak, float("inf"), None)
        arcs = ContinuousFlight(loop, wind).arcs(62.0, 75.0)
        counts.append(sum(len(arc.solution.ts) for arc in arcs))
    assert counts[1] < 2 * counts[0]
