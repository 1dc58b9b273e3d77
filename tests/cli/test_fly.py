"""`tvclin fly`: it says what the library says, survival is the exit code, and no tracebacks."""

import json
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.turns import usual
from tvclin.ascent.nominal_flight import load_flight_condition
from tvclin.cli.app import app

mpl.use("Agg")

PEAK = np.radians(5)
WIND = tv.TriangularWind(peak=PEAK, duration=7.5)


def run(*arguments):
    return CliRunner().invoke(app, ["fly", *map(str, arguments)])


def document(*arguments, code=0):
    result = run(*arguments, "--json")
    assert result.exit_code == code, result.output
    return json.loads(result.stdout)


def linear():
    return tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")


def test_the_report_control_is_flown_beside_the_linear_theory():
    answer = document()
    plant, vehicle = linear(), tv.load_vehicle("configuration-i")
    minimum = tv.boundary_limit(plant, WIND, switch="literal").deflection
    times, limit = np.linspace(0.0, 7.5, 201), answer["limit_deg"]
    flown = tv.fly_planar(
        vehicle, tv.flights.ReportControl(), WIND, times, deflection_limit=np.radians(limit)
    )
    constant = tv.trim_then_hold(plant, WIND, -np.radians(limit), 1.0, "literal")
    exact = tv.attitude_response(plant, constant, WIND, times)

    assert limit == pytest.approx(1.1 * abs(np.degrees(minimum)), rel=1e-12)
    assert answer["boundary_deg"]["linear"] == pytest.approx(abs(np.degrees(minimum)), rel=1e-12)
    assert answer["boundary_deg"]["flown"] is None
    assert (answer["survived"], answer["predicted"]) == (True, True)
    for name in ("attitude", "angle_of_attack"):
        both = answer["peaks_over_the_wind_deg"][name]
        for one, source in (("flown", flown), ("linear", exact)):
            peak = np.degrees(np.abs(source.outputs[name]).max())
            assert both[one] == pytest.approx(peak, rel=1e-9)


def test_the_required_deflection_beside_a_nonlinear_flight_is_of_the_model_of_the_study(tmp_path):
    """Linear theory beside the flight is of drift-exact, which requires another deflection."""
    study = tmp_path / "s.toml"
    vehicle = '[study]\nvehicle = "configuration-i"\nmodel = "fixed-path"\n'
    study.write_text(f"{vehicle}[wind]\npeak_deg = 4\nduration_s = 6\n")
    expected = json.loads(CliRunner().invoke(app, ["study", str(study), "--json"]).stdout)
    required = expected["verdict"]["required_deflection_deg"]
    assert document(study)["required_deflection_deg"] == pytest.approx(required, rel=1e-12)
    printed = " ".join(run(study).output.split())
    assert "linear theory is of drift-exact here, the study of fixed-path" in printed
    assert f"required deflection {required:.3f} deg in a head wind, see study" in printed


@pytest.mark.thorough
def test_an_autopilot_requires_the_same_in_a_study_of_any_dead_band(tmp_path):
    """It has none: its gust is at the worst time for K = 1; the required deflection has its K."""
    required, file = {}, tmp_path / "s.toml"
    for K in (0.3, 1.0):
        file.write_text(
            f'[study]\nvehicle = "configuration-i"\ndead_band = {K}\n'
            "[wind]\npeak_deg = 4\nduration_s = 9\n[gust]\npeak_deg = 1.5\nduration_s = 2\n"
            "[nozzle]\nlimit_deg = 0.8\n[autopilot]\nnatural_frequency_rad_per_s = 1.2\n"
        )
        study = json.loads(CliRunner().invoke(app, ["study", str(file), "--json"]).stdout)
        autopilot = next(x for x in study["questions"] if x["name"] == "autopilot")
        required[K], flown = autopilot["measure"]["required"], document(file)
        assert flown["autopilot_requirement_deg"] == pytest.approx(required[K], rel=1e-12)
        ideal = study["verdict"]["required_deflection_deg"]
        assert flown["required_deflection_deg"] == pytest.approx(ideal, rel=1e-12)
    assert required[0.3] == pytest.approx(required[1.0], rel=1e-12)


@pytest.mark.parametrize("engine", usual(["planar", "sixdof"], 0))
def test_a_survivor_is_shown_until_the_limit_is_let_go_and_its_flight_does_not_end(
    engine, tmp_path
):
    if engine == "sixdof":
        pytest.importorskip("jsbsim")
    file = tmp_path / "flight.csv"
    arguments = ("--engine", engine)
    result = run(*arguments, "--csv", file)
    assert result.exit_code == 0
    assert "SURVIVED" in result.stdout
    assert "the flight ends" not in result.output
    assert "let go" in result.stdout
    when = document(*arguments)["let_go_s"]["flown"]
    rows = np.genfromtxt(file, delimiter=",", skip_header=2)
    time, attitude = rows[:, 0], rows[:, 1]
    assert np.all(np.isnan(attitude) == (time > when))
    step = time[1]
    assert np.nanargmin(attitude) < np.flatnonzero(time <= when)[-1]
    assert abs(attitude[time <= when][-1]) < 3.0 * step  # of some deg/s
    assert np.nanmax(attitude) < 0.1
    lost = run(*arguments, "--limit-deg", 0.3)
    assert lost.exit_code == 1
    assert "NOT SURVIVED" in lost.stdout
    assert "let go" not in lost.stdout
    assert "the flight ends" in lost.output


def test_a_limit_that_survives_below_one_that_is_lost_is_not_sufficient_and_says_why():
    """A wind that turns round: drift-minimum survives with 0.2 deg, and not with 0.3."""
    turning = ("gust.peak_deg=-10", "gust.duration_s=3.75", "gust.peak_time_s=5.6")
    design = ("--law", "autopilot", "--design", "drift-minimum", "--natural-frequency", 1)
    arguments = (*design, *(word for key in turning for word in ("--set", key)), "--limit-deg")
    result = run(*arguments, 0.2)
    assert result.exit_code == 1
    assert result.stdout.startswith(
        "Limit 0.2 deg: NOT SUFFICIENT, a larger limit is lost; this flight SURVIVED with 0.200"
    )
    assert "NOT SUFFICIENT; NOT SURVIVED with 0.300" in run(*arguments, 0.3).stdout


def test_peaks_of_a_lost_flight_are_until_its_end_and_the_linear_ones_over_the_whole_wind():
    options = ("--limit-deg", 0.1)
    computed, plant, times = document(*options, code=1), linear(), np.linspace(0.0, 7.5, 2001)
    constant = tv.trim_then_hold(plant, WIND, -np.radians(0.1), 1.0, "literal")
    exact = np.degrees(
        np.abs(tv.attitude_response(plant, constant, WIND, times).outputs["attitude"])
    )

    attitude = computed["peaks_over_the_wind_deg"]["attitude"]
    assert attitude["flown"] == pytest.approx(25.0, rel=1e-12)
    assert attitude["linear"] == pytest.approx(exact.max(), rel=1e-12)
    angle = computed["peaks_over_the_wind_deg"]["angle_of_attack"]["flown"]
    assert angle == pytest.approx(23.694, abs=1e-3)  # flown in steps of a tenth of that
    assert computed["ended_in_the_wind"] == {"flown": True, "linear": False}
    text = run(*options).stdout
    assert "the largest values, flown, are until the attitude reaches 25 deg" in " ".join(
        text.split()
    )


def test_a_flight_that_is_lost_has_exit_code_one_and_says_so():
    result = run("--limit-deg", 0.3, "--dead-band", 0.5)

    assert result.exit_code == 0
    result = run("--limit-deg", 0.3)
    assert result.exit_code == 1
    assert (
        "NOT SURVIVED with 0.300 deg at nominal dynamic pressure, vehicle frozen; linear theory:"
        " NOT SURVIVED." in " ".join(result.stdout.split())
    )
    assert "law report, K = 1" in " ".join(result.stdout.split())


def test_the_table_of_laws_says_whose_it_is_and_in_which_winds():
    shown = " ".join(run("--law", "all", "--wind", "triangular", "--peak-deg", 4).stdout.split())
    title = "Configuration I (260-inch solid booster), drift-exact, winds of 4 deg and 7.5 s, at"

    assert f"{title} nominal dynamic pressure, 100 Hz, delay 0 ms, no actuator Required" in shown


@pytest.mark.parametrize(
    ("law", "needs"),  # as `tvclin fly --law all` prints, over B times the peak
    usual(
        [
            ("trim", 0.654),
            ("dead-band", 0.542),
            ("autopilot", 1.257),
            ("recoverable-attitude", 0.390),
        ],
        0,
        3,
    ),
)
def test_every_law_survives_in_one_plane_with_a_tenth_more_than_it_needs(law, needs):
    answer = document("--law", law, "--engine", "planar")

    minimum = np.degrees(needs * linear().coefficients.B * PEAK)
    assert answer["boundary_deg"]["linear"] == pytest.approx(minimum, rel=2e-3)
    assert answer["limit_deg"] == pytest.approx(1.1 * answer["boundary_deg"]["linear"], rel=1e-12)
    assert (answer["survived"], answer["predicted"]) == (True, True)
    assert answer["dead_band"] == (0.5 if law == "dead-band" else None)
    for both in answer["peaks_over_the_wind_deg"].values():
        assert both["flown"] == pytest.approx(both["linear"], rel=0.05)


@pytest.mark.thorough
def test_the_boundary_is_flown_where_it_is_asked_for():
    pytest.importorskip("jsbsim")
    options = ("--engine", "sixdof", "--plane", "yaw", "--peak-deg", 1, "--dead-band", 0.5)
    computed = document(*options, "--more")["boundary_deg"]

    trim = np.degrees(linear().coefficients.B * np.radians(1))
    assert computed["flown"] == pytest.approx(computed["linear"], abs=7e-4 * trim)


@pytest.mark.thorough
def test_six_degrees_along_the_trajectory_are_those_of_one_plane(tmp_path):
    pytest.importorskip("jsbsim")
    options = ("--peak-deg", -3, "--limit-deg", 0.32)
    file = tmp_path / "flight.csv"
    six = document("--engine", "sixdof-varying", *options, "--csv", file)
    planar = document("--engine", "planar-varying", *options)

    assert six["wind"]["onset_s"] == planar["wind"]["onset_s"] == 66.0 - 3.75
    assert six["predicted"] is True
    for name, both in planar["peaks_over_the_wind_deg"].items():
        here = six["peaks_over_the_wind_deg"][name]
        assert here["linear"] == both["linear"]
        assert here["flown"] == pytest.approx(both["flown"], abs=0.01)
    vehicle = tv.load_vehicle("configuration-i")
    comment, headings, *rows = file.read_text(encoding="utf-8").splitlines()
    values = np.array([row.split(",") for row in rows], dtype=float)
    wind = tv.TriangularWind(peak=np.radians(-3), duration=7.5).shift(62.25)
    shown = np.isfinite(values[:, 1])  # until the limit is let go
    flown = tv.fly_sixdof(
        vehicle,
        tv.flights.ReportControl(),
        wind,
        values[shown, 0],
        deflection_limit=np.radians(0.32),
        condition=load_flight_condition("configuration-i"),
    )
    assert "sixdof" in comment
    assert headings.startswith("time [s],attitude: flown [deg],attitude: linear [deg],angle of")
    assert np.all(np.diff(shown.astype(int)) <= 0)
    for column, name in ((1, "attitude"), (3, "angle_of_attack"), (5, "deflection")):
        expected = np.degrees(np.asarray(flown.outputs[name]))
        np.testing.assert_allclose(values[shown, column], expected, atol=1e-12)


def test_what_is_printed_fits_a_terminal_and_names_what_is_assumed(tmp_path, monkeypatch):
    """Its boundary, which costs two seconds, is not flown here."""
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr("tvclin.cli.flight_cases._flown_boundary", lambda case: 1.2e-3)
    file = tmp_path / "flight.png"
    said = run("--engine", "planar-varying", "--peak-deg", 1, "--more", "--plot", file)

    assert said.exit_code == 0, said.output
    assert max(map(len, said.stdout.splitlines())) <= 80
    for words in (
        "planar equations",
        "mass falling",
        "1.1 times the linear boundary",
        "with this limit the vehicle",
    ):
        assert words in " ".join(said.stdout.split())
    assert file.stat().st_size > 10_000


def test_without_jsbsim_the_extra_is_named(monkeypatch):
    from tvclin.flights.sixdof import airframe

    monkeypatch.setattr(airframe, "_IDLE", {})
    monkeypatch.setitem(sys.modules, "jsbsim", None)
    result = run("--engine", "sixdof")

    assert result.exit_code == 2
    assert 'pip install "tvclin[sixdof]"' in " ".join(result.output.split())


@pytest.mark.parametrize("damping", [None, 3e6])
def test_a_stable_vehicle_has_no_boundary_to_fly(stable_vehicle, damping):
    """With damping a moment that turns the vehicle away slowly leaves it stable too."""
    if damping is not None:
        numbers = f"aerodynamic_arm_m = 0.05\npitch_damping_N_m_s_per_rad = {damping}"
        text = stable_vehicle.read_text()
        stable_vehicle.write_text(text.replace("aerodynamic_arm_m = -2", numbers))
    result = run(stable_vehicle)

    assert result.exit_code == 2
    assert "which an unstable vehicle alone has" in " ".join(result.output.split())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["configuration-3"], "configuration-3"),
        (["--wind", "square"], "--wind must be one of"),
        (["--duration", "0"], "--duration must be positive"),
        (["--engine", "seven"], "--engine must be one of linear, planar, sixdof"),
        (["--law", "bang"], "--law must be one of report, autopilot, trim"),
        (["--law", "trim", "--dead-band", "0.5"], "--dead-band belongs to"),
        (["--dead-band", "1.5"], "--dead-band must be between 0 and 1"),
        (["--limit-deg", "0"], "--limit-deg must be positive"),
        (["--plane", "roll"], "plane must be one of"),
        (["--peak-deg", "0"], "--peak-deg must be"),
        (["--peak-deg", "-80", "--engine", "sixdof"], "horizontal wind can make"),
        (["--duration", "140", "--engine", "planar-varying"], "nominal flight does not reach"),
        (["--plot", "flight.xyz"], "xyz"),
    ],
)
def test_bad_input_is_exit_code_two_in_one_sentence(arguments, words):
    result = run(*arguments)

    assert result.exit_code == 2, result.output
    assert isinstance(result.exception, SystemExit)
    assert words in " ".join(result.output.split())


@pytest.mark.thorough
def test_a_survival_below_the_least_of_all_is_told_as_one_that_does_not_last():
    arguments = ("--duration", 60, "--dead-band", 0.5)
    wind = tv.TriangularWind(peak=PEAK, duration=60.0)
    minimum = np.degrees(tv.optimum_deflection(linear(), wind).peak)
    note = f"Note: {minimum:.3f} deg is the minimum of any control by linear theory"

    assert run(*arguments).output.startswith("SURVIVED with")
    assert note in " ".join(run(*arguments).output.split())
    assert "minimum" not in run(*arguments, "--limit-deg", 1.05 * minimum).output
    assert document(*arguments)["minimum_deg"] == pytest.approx(minimum, rel=1e-12)


def test_no_attitude_is_written_once_the_linear_one_is_over_90_degrees(tmp_path):
    file = tmp_path / "lost.csv"
    result = run("--limit-deg", 0.3, "--duration", 20, "--csv", file)

    headings, *rows = (line for line in file.read_text().splitlines() if line[0] != "#")
    column = headings.split(",").index("attitude: linear [deg]")
    cells = [row.split(",")[column] for row in rows]
    known = np.array([float(cell) for cell in cells if cell not in ("", "nan")])
    assert result.exit_code == 1
    assert 60.0 < np.abs(known).max() <= 90.0
    assert known.size < len(cells)


SOUNDING = str(Path(__file__).parents[1] / "soundings" / "wyoming.txt")


def test_a_sounding_asks_of_a_flight_what_it_asks_of_the_sizing():
    sounding = ["--winds", SOUNDING, "--azimuth-deg", "90", "--set", "sounding.window_s=20"]
    flown = json.loads(CliRunner().invoke(app, ["fly", *sounding, "--json"]).stdout)
    times = ["--from", "66", "--to", "66.1", "--every", "0.1", "--dead-band", "1"]
    sized = json.loads(CliRunner().invoke(app, ["ascent", *sounding, *times, "--json"]).stdout)

    assert flown["boundary_deg"]["linear"] == pytest.approx(
        sized["required_deg"]["K = 1"][0][0], rel=1e-6
    )
    assert flown["wind"]["shape"] == "wyoming.txt"
    assert flown["survived"] is None  # the excerpt has gaps of more than 2 km


@pytest.mark.thorough
@pytest.mark.parametrize(
    "engine",
    usual([[], ["--law", "autopilot"], ["--engine", "planar-varying"]], 0, 1),
)
def test_a_flight_through_gaps_of_a_sounding_is_not_known_to_survive(tmp_path, engine):
    """A limit too small stays so, and levels every kilometre on the same lines are known."""
    heights, winds = np.arange(0.0, 21.0), tmp_path / "jet.csv"
    options = [*engine, "--winds", winds, "--azimuth-deg", 90]
    answers = {}
    for step in (1, 10):
        speeds = np.interp(heights[::step], [0.0, 10.0, 20.0], [3.0, 30.0, 10.0])
        rows = [f"{h:g},{v},270" for h, v in zip(heights[::step], speeds, strict=True)]
        text = "\n".join(["altitude_km,speed_m_per_s,direction_deg", *rows, ""])
        winds.write_text(text, encoding="utf-8")
        for limit in (0.6, 0.15):
            done = run(*options, "--limit-deg", limit, "--json")
            answers[step, limit] = done.exit_code, json.loads(done.stdout)["survived"]
    assert answers == {
        (1, 0.6): (0, True),
        (1, 0.15): (1, False),
        (10, 0.6): (1, None),
        (10, 0.15): (1, False),
    }
    printed = run(*options, "--limit-deg", 0.6).stdout
    assert "the wind is not known from 0 to 10 km and in 1 other gap" in " ".join(printed.split())


VARYING = ("--duration", 10, "--peak-deg", 6, "--engine", "planar-varying", "--limit-deg", 0.4)


@pytest.mark.thorough
@pytest.mark.parametrize("engine", usual(["planar-varying", "sixdof-varying"], 0))
def test_a_flight_that_encounters_its_own_pressure_is_the_worse_of_head_and_tail_wind(engine):
    if engine.startswith("sixdof"):
        pytest.importorskip("jsbsim")
    for peak in (6, -6):
        worse = run(*VARYING, "--engine", engine, "--peak-deg", peak)
        said = " ".join(worse.stdout.split())
        assert worse.exit_code == 1
        assert said.startswith("NOT SURVIVED with 0.400 deg in a head wind at encountered")
        assert "Note: in a tail wind: SURVIVED" in said


@pytest.mark.thorough
@pytest.mark.parametrize("engine", ["planar-varying", "sixdof-varying"])
def test_a_flight_in_a_head_or_a_tail_wind_survives_as_the_boundary_of_each_says(engine):
    """A tail wind lowers the dynamic pressure and is survived."""
    if engine.startswith("sixdof"):
        pytest.importorskip("jsbsim")
    options = (*VARYING, "--engine", engine)
    vehicle, limit = tv.load_vehicle("configuration-i"), np.radians(0.4)
    condition, middle = load_flight_condition("configuration-i"), float(vehicle.time)
    for name, sign in {"tail": 1, "head": -1}.items():
        wind = tv.TriangularWind(peak=sign * np.radians(6), duration=10).shift(middle - 5.0)
        needs = tv.flown_boundary(
            vehicle, wind, frozen=False, condition=condition, tolerance=0.01, highest=4.0
        )
        survived = limit > abs(needs.deflection)
        assert survived == (name == "tail")
        answer = run(*options, "--set", f"study.sign={name}")
        assert answer.exit_code == int(not survived)
        said = " ".join(answer.stdout.split())
        assert f"in a {name} wind at encountered dynamic pressure, vehicle varying" in said
        assert "sign that counts" not in answer.stderr
    across = run(*options, "--set", "study.plane=yaw", "--json")
    assert json.loads(across.stdout)["direction"] == "cross"


@pytest.mark.thorough
def test_a_cross_wind_that_leaves_an_autopilot_open_is_called_one():
    """Between what it requires at nominal pressure and at that of the peak of a cross wind."""
    autopilot = ("--natural-frequency", "1.5", "--plane", "yaw", "--limit-deg", "0.413")
    said = " ".join(run("configuration-i", *autopilot).stdout.split())
    assert (
        "NOT KNOWN, sufficient at nominal dynamic pressure, and below the bound for a cross" in said
    )


def test_an_autopilot_flies_a_sounding_whole_and_boundaries_name_the_part_that_counts(tmp_path):
    """A jet from behind about the time of the vehicle, and a weaker wind from ahead above it."""
    flight = tv.load_schedule("configuration-i")
    height = np.interp([45.0, 66.0, 76.0, 90.0, 100.0], flight.times, flight.height)
    winds, curves = tmp_path / "jet.csv", tmp_path / "fly.csv"
    levels = np.linspace(height[0], height[-1], 21)
    rows = [f"{h},{np.interp(h, height, [0, 30, 0, -12, 0])},0" for h in levels]
    winds.write_text("height_m,wind_u_m_per_s,wind_v_m_per_s\n" + "\n".join(rows))
    sounding = ["--winds", winds, "--azimuth-deg", 90, "--set", "sounding.window_s=50"]

    autopilot = ("--natural-frequency", 1.5, "--sample-rate", 100, "--limit-deg", 5)
    flown = run(*autopilot, *sounding, "--csv", curves)
    lines = curves.read_text().splitlines()
    wind = np.array([float(line.split(",")[-1]) for line in lines[2:]])
    assert wind.min() < -0.1 * wind.max()
    assert ", t = 0 at 45 s of flight" in lines[0]
    assert "side on which it is largest" not in flown.stderr
    assert "peaks are of the continuous autopilot" not in flown.stdout  # not printed: with --more

    takers = {
        "boundary": "K < 1",
        "fly": "the report's control",
        "respond": "the boundary and its control",
        "disperse": "a campaign",
    }
    for command, what in takers.items():
        cases = ["--cases", "20"] if command == "disperse" else []
        bound = CliRunner().invoke(app, [command, "configuration-i", *map(str, sounding), *cases])
        assert bound.exit_code in (0, 1), bound.output
        note = f"in jet.csv only what blows to the side on which it is largest counts for {what}"
        assert note in " ".join(bound.stderr.split())


@pytest.mark.thorough
def test_a_part_of_a_sounding_is_said_to_be_one():
    sounding = ("--winds", SOUNDING, "--azimuth-deg", 90)
    said = "of wyoming.txt the 20 s about the vehicle's own time count, cut with steps of 4.26 and"
    for window in ((), ("--set", "sounding.window_s=20")):
        assert said in " ".join(run(*sounding, *window).stderr.split())
    cut = "survives this part of the sounding, cut to 20 s with steps at its ends, with less"
    bound = CliRunner().invoke(app, ["boundary", "configuration-i", *map(str, sounding)]).stdout
    assert cut in " ".join(bound.split())
    respond = CliRunner().invoke(app, ["respond", "configuration-i", *map(str, sounding)]).stderr
    assert "may take out: --set sounding.window_s 40 or more" in " ".join(respond.split())
    wide = " ".join(run(*sounding, "--set", "sounding.window_s=60").stderr.split())
    assert "own time count" not in wide


@pytest.mark.thorough
def test_a_note_on_what_is_not_counted_names_a_command_that_answers_for_the_wind():
    options = ("--law", "all", "--set", "nozzle.limit_deg=1")
    assert "not counted here: limit (tvclin study counts it)" in run(*options).stderr
    sounding = ("--winds", SOUNDING, "--azimuth-deg", 90)
    assert "not counted here: limit (tvclin ascent counts it)" in run(*options, *sounding).stderr


@pytest.mark.thorough
def test_a_sounding_is_chosen_by_its_time():
    """And where none is chosen of several, that is said."""
    sounding = ["--winds", SOUNDING, "--azimuth-deg", "90", "--json"]
    first, later = (
        CliRunner().invoke(app, ["fly", *sounding, *time])
        for time in ([], ["--set", "sounding.time=2024-02-16 00"])
    )
    profile = tv.read_sounding(SOUNDING, time="2024-02-16 00")
    flight = tv.load_schedule("configuration-i")
    wind = tv.fly_through(profile, flight, azimuth=np.pi / 2, window=20.0)
    needed = [json.loads(one.stdout)["boundary_deg"]["linear"] for one in (first, later)]
    sized = tv.size(flight, wind, times=[66.0], dead_bands=1.0).required["K = 1"][0, 0]
    assert needed[1] == pytest.approx(np.degrees(sized), rel=1e-6)
    assert needed[0] != pytest.approx(needed[1], rel=1e-2)
    assert "the first of 2 soundings in the file" in first.stderr
    assert "the first of 2" not in later.stderr


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--winds", SOUNDING], "--winds needs --azimuth-deg"),
        (["--set", "sounding.window_s=5"], "Error: [sounding] needs a sounding"),
        (["--azimuth-deg", 5], "--azimuth-deg needs a sounding, --winds FILE"),
        (["--winds", SOUNDING, "--azimuth-deg", 90, "--peak-deg", 3], "has its own wind"),
        (["--winds", "no.csv", "--azimuth-deg", 90], "no.csv"),
    ],
)
def test_a_sounding_that_cannot_be_flown_is_one_sentence(arguments, said):
    result = run(*arguments)

    assert result.exit_code == 2
    assert said in result.output


@pytest.mark.thorough
@pytest.mark.parametrize("plane", usual(["pitch", "yaw"], 0))
def test_a_sounding_of_a_file_is_the_wind_of_one_time(tmp_path, plane):
    """As with --winds; a key of [sounding] counts for both."""
    file = tmp_path / "my.toml"
    file.write_text(
        f'[study]\nvehicle = "configuration-i"\nplane = "{plane}"\n[sounding]\nwindow_s = 15\n'
        f'[wind]\nsounding = "{SOUNDING}"\nazimuth_deg = 70\n'
    )
    given = ("--winds", SOUNDING, "--azimuth-deg", 70, "--set", "sounding.window_s=15")
    by_options = run("configuration-i", "--plane", plane, *given, "--json")
    assert json.loads(run(file, "--json").stdout) == json.loads(by_options.stdout)
    turned = json.loads(run(file, "--azimuth-deg", 120, "--json").stdout)
    assert turned["boundary_deg"] != json.loads(by_options.stdout)["boundary_deg"]
