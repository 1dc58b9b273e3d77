"""`tvclin respond`: it says what the library says, and never with a traceback."""

import json

import matplotlib as mpl
import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.report_responses import triangular_attitude
from tests.turns import by_turns, usual
from tvclin.cli.app import app
from tvclin.linear.extremes import wind_loads

mpl.use("Agg")

TAU = 4 / 0.5292825


def run(*arguments):
    """Respond on a fixed path, where eq (13) is the answer, unless another model is named."""
    model = () if "--model" in arguments else ("--model", "fixed-path")
    return CliRunner().invoke(app, ["respond", *map(str, arguments), *model])


def document(*arguments):
    result = run(*arguments, "--json")
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def case(model="fixed-path", factor=1.1, dead_band=1.0, duration=7.5, shape=tv.TriangularWind):
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), model)
    wind = shape(peak=np.radians(5), duration=duration)
    limit = factor * tv.required_deflection(plant, wind, dead_band).deflection
    return plant, tv.trim_then_hold(plant, wind, limit, dead_band, "literal"), wind, limit


def attitude(parts, *times):
    plant, deflection, wind, _ = parts
    result = tv.attitude_responses(plant, deflection, wind, np.array(times))
    return np.degrees(result["attitude"])


@pytest.mark.parametrize(
    ("model", "factor"),
    usual(
        [
            *((model, 1.0) for model in ("fixed-path", "drift", "drift-exact", "drift-and-speed")),
            ("fixed-path", 0.9),
            ("drift", 1.1),
            ("drift-exact", 0.9),
        ],
        *(0, 6),
    ),
)
def test_json_equals_the_library(model, factor):
    answer = document("--model", model, "--capability", factor)
    parts = case(model, factor)
    plant, deflection, wind, limit = parts
    verdict = tv.linear.judge(plant, deflection, wind)
    loads = wind_loads(plant, deflection, wind)

    assert answer["limit_deg"] == pytest.approx(abs(np.degrees(limit)), rel=1e-14)
    assert answer["survived"] is (factor >= 1.0)
    assert answer["verdict"]["stable"] is verdict.stable
    assert answer["verdict"]["final_motion"] == str(verdict.final_motion)
    assert answer["peak_angle_of_attack"]["deg"] == pytest.approx(
        np.degrees(loads.peak_angle_of_attack), rel=1e-14
    )
    end = answer["shown_until"]["time_s"]
    assert end <= 22.5
    assert (end == 22.5) == (answer["shown_until"]["why"] == "whole")
    for name, time in (("at_wind_end", 7.5), ("at_end", end)):
        expected = pytest.approx(float(attitude(parts, time)[0]), abs=1e-9)
        assert answer["attitude"][name] == {"deg": expected, "time_s": time}


@by_turns("model,factor", ["fixed-path", "drift", "drift-exact"], [0.5, 1.0, 1.1, 1.5, 3.0], each=3)
def test_a_response_ends_where_the_limit_is_let_go_or_the_vehicle_has_fallen(
    model, factor, tmp_path
):
    file = tmp_path / "response.csv"
    arguments = ("--model", model, "--capability", factor, "--until", 12)
    answer = document(*arguments, "--csv", file)
    end, why = answer["shown_until"]["time_s"], answer["shown_until"]["why"]
    left = float(attitude(case(model, factor), end)[0])
    if why == "let go":
        assert answer["survived"]
        if answer["attitude"]["back_at_zero"] is None:  # never on the side of the wind
            assert end == 7.5
        else:
            assert left == pytest.approx(0.0, abs=1e-8)
            assert end == answer["attitude"]["back_at_zero"]["time_s"]
    if why == "fallen":
        assert abs(left) == pytest.approx(90.0)
        assert not answer["survived"]
    rows = np.genfromtxt(file, delimiter=",", skip_header=2)
    assert np.abs(rows[:, 1]).max() <= 90.0 + 1e-6
    assert rows[-1, 0] == pytest.approx(end)
    assert ("an autopilot lets go" in run(*arguments).output) == (why == "let go")


def test_the_peak_is_the_one_that_the_report_quotes():
    computed = document("--duration", TAU, "--capability", 1.1)["attitude"]

    assert computed["with_wind"]["deg"] == pytest.approx(-5.0 * 0.16420, abs=5e-4)
    assert computed["with_wind"]["time_s"] / TAU == pytest.approx(0.8770, abs=1e-3)
    assert computed["back_at_zero"]["time_s"] / TAU == pytest.approx(1.0802, abs=1e-3)


@pytest.mark.parametrize("peak", usual([5.0, -5.0], 0))
@pytest.mark.parametrize("shape", ["triangular", "rectangular"])
def test_extremes_do_not_depend_on_the_points(peak, shape):
    coarse, fine = (
        document("--peak-deg", peak, "--wind", shape, "--points", n, "--capability", 0.9)
        for n in (2, 1000)
    )

    assert coarse == fine
    assert np.sign(coarse["attitude"]["with_wind"]["deg"]) == -np.sign(peak)


def test_the_peak_is_a_peak_and_the_zero_a_zero():
    parts = case()
    computed = document("--capability", 1.1)["attitude"]
    peak = computed["with_wind"]
    near = attitude(parts, *(peak["time_s"] + np.linspace(-0.5, 0.5, 101)))

    assert abs(peak["deg"]) >= np.abs(near).max()
    assert attitude(parts, computed["back_at_zero"]["time_s"]) == pytest.approx(0.0, abs=1e-9)


def test_on_the_boundary_the_attitude_is_that_of_equation_13():
    answer = document("--duration", TAU, "--capability", 1, "--until", 1.5)
    limit = answer["limit_deg"] / (5.0 * case()[0].coefficients.B)

    expected = -5.0 * triangular_attitude(1.5, TAU * case()[0].coefficients.beta, limit)
    assert answer["attitude"]["at_end"]["deg"] == pytest.approx(expected, rel=1e-9)
    assert answer["attitude"]["against_wind"] is None
    assert answer["attitude"]["back_at_zero"] is None
    assert answer["verdict"]["stable"] is True
    assert "constant attitude error" in answer["verdict"]["final_motion"]


def test_trim_throughout_leaves_nothing():
    answer = document("--limit-deg", 1)

    assert answer["attitude"]["with_wind"] is None
    assert answer["attitude"]["against_wind"] is None
    assert answer["survived"] is True
    assert answer["verdict"]["stable"] is True
    assert answer["verdict"]["final_motion"] == "nothing"


def test_a_short_response_has_no_end_of_the_wind():
    assert document("--until", 0.5)["attitude"]["at_wind_end"] is None


def test_the_csv_is_the_exact_response(tmp_path):
    file = tmp_path / "response.csv"
    calls = ["--model", "drift", "--capability", 1.1, "--until", 2]
    result = run(*calls, "--points", 31, "--csv", file)
    plant, deflection, wind, _ = case("drift")

    assert result.exit_code == 0
    comment, headings, *rows = file.read_text(encoding="utf-8").splitlines()
    values = np.array([row.split(",") for row in rows], dtype=float)
    end = document(*calls)["shown_until"]["time_s"]
    expected = tv.attitude_responses(plant, deflection, wind, np.linspace(0.0, end, 31))
    assert "Configuration I" in comment
    assert "model drift, K = 1, limit 0.391 deg" in comment
    assert headings == (
        "time [s],attitude [deg],attitude_rate [deg/s],flight_path_angle [deg],"
        "angle_of_attack [deg],deflection [deg],lower limit [deg],wind [deg]"
    )
    np.testing.assert_array_equal(expected.time, values[:, 0])
    outputs = np.degrees(expected.outputs)
    rounding = 16.0 * np.finfo(float).eps * max(5.0, np.abs(outputs).max())
    assert np.all(np.abs(values[:, 1:5].T - outputs) <= 1e-13 * np.abs(outputs) + rounding)
    assert not values[0, 1:4].any()  # what begins at rest begins at zero
    np.testing.assert_allclose(values[:, 7], np.degrees(wind(expected.time)), rtol=1e-13)
    assert np.all(values[:, 6] == pytest.approx(-0.391, abs=5e-4))


@pytest.mark.parametrize("limit", usual([0.3, 0.36, 0.45, 0.8], 1, 3), ids="limit {}".format)
def test_the_frame_of_the_figure_holds_every_curve_whole_with_the_limit(
    limit, monkeypatch, tmp_path
):
    drawn = []
    monkeypatch.setattr("tvclin.plots.save_figure", lambda plot, path: drawn.append(plot))
    assert run("--limit-deg", limit, "--plot", tmp_path / "response.png").exit_code == 0
    (plot,) = drawn
    for axes, columns in zip(plot.axes.flat, plot.curves.panels.values(), strict=True):
        low, high = axes.get_ylim()
        for column in columns:
            assert low < column.values.min() <= column.values.max() < high
    level = plot.curves.column("lower limit", "deflection")
    np.testing.assert_allclose(level, -limit, rtol=1e-14)


def test_a_vehicle_that_trim_holds_at_rest_is_at_zero_in_the_csv(tmp_path):
    file = tmp_path / "response.csv"
    run("--limit-deg", 0.8, "--csv", file)
    rows = np.genfromtxt(file, delimiter=",", skip_header=2)
    assert not rows[:, 1:3].any()  # attitude and rate
    assert "-0.0," not in file.read_text(encoding="utf-8")


@pytest.mark.thorough
@pytest.mark.parametrize("kind", usual(["png", "svg"], 0))
def test_the_figure_is_written_and_closed(tmp_path, kind):
    import matplotlib.pyplot as plt

    plt.close("all")
    file = tmp_path / f"response.{kind}"

    assert run("configuration-ii", "--plot", file, "--model", "drift-and-speed").exit_code == 0
    assert file.stat().st_size > 5000
    assert not plt.get_fignums()


def test_the_table_says_it_in_words():
    sufficient, short = (run("--capability", part).output for part in (1.1, 0.9))

    for words in (
        "-0.829",
        "8.138",
        "1.1 times that",
        "not stable by condition (4b)",
    ):
        assert words in sufficient
    assert sufficient.startswith("SURVIVED: ")
    assert "lets go" in sufficient
    assert short.startswith("NOT SURVIVED: ")
    assert "0.9 times that" in short
    assert "lets go" not in short


def test_without_a_limit_it_shows_the_boundary():
    computed, on_it = document(), document("--capability", 1)

    assert computed == on_it
    assert computed["limit_deg"] == computed["nominal_deflection_deg"]
    assert computed["verdict"]["stable"] is True


def test_a_stable_vehicle_needs_a_limit(stable_vehicle):
    result = run(stable_vehicle)
    assert result.exit_code == 2
    assert "--limit-deg" in result.output
    answer = document(stable_vehicle, "--limit-deg", "0.1")
    assert answer["survived"] is True
    assert "oscillation" in answer["verdict"]["final_motion"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["configuration-3"],
        ["--wind", "square"],
        ["--duration", "0"],
        ["--duration", "nan"],
        ["--peak-deg", "0"],
        ["--peak-deg", "5", "--peak-speed", "40"],
        ["--peak-speed", "1e4"],
        ["--dead-band", "1.5"],
        ["--capability", "0"],
        ["--capability", "-1"],
        ["--limit-deg", "0"],
        ["--limit-deg", "0.4", "--capability", "1.1"],
        ["--model", "drifty"],
        ["--plane", "roll"],
        ["--until", "0"],
        ["--until", "inf"],
        ["--points", "1"],
        ["--points", "100000000000"],
        ["--csv", "/nowhere/at/all/response.csv"],
        ["--csv", "."],
        ["--plot", "response.xyz"],
    ],
)
def test_bad_input_is_exit_code_two_without_a_traceback(arguments):
    result = run(*arguments)

    assert result.exit_code == 2
    assert isinstance(result.exception, SystemExit)
    assert result.output.strip()


def test_a_limit_that_survives_and_turns_the_vehicle_over_is_explained():
    arguments = ("--duration", 60, "--dead-band", 0.5, "--model", "drift-exact")
    words = "survived with a control that lets go of it"
    sufficient, short = (run(*arguments, "--capability", part).output for part in (1.1, 0.9))

    assert sufficient.startswith("SURVIVED: ")
    assert "exceeds 90 deg" in sufficient
    assert words in sufficient
    assert "exceeds 90 deg" in short
    assert words not in short


@pytest.mark.thorough
def test_a_response_at_nominal_pressure_says_what_a_head_wind_adds(tmp_path) -> None:
    """For the usual wind at 44.83 deg of attitude; none of a weak wind, in yaw or of one sign."""
    wind = np.sin(np.radians(5.0)) / np.sin(np.radians(39.83))
    path = np.radians(44.83)
    ratio = (np.cos(path) + wind) ** 2 + np.sin(path) ** 2
    for words in (["respond"], ["fly", "--law", "autopilot"], ["nozzle"]):
        said = CliRunner().invoke(app, [*words, "configuration-i", "--limit-deg", "0.45"])
        raised = f"{100.0 * (ratio - 1.0):.2g} percent"
        assert f"a head wind of this size raises the pressure by up to {raised}" in said.stderr
    for more in (["--peak-deg", "1.4"], ["--plane", "yaw"]):
        assert CliRunner().invoke(app, ["respond", "configuration-i", *more]).stderr == ""


@pytest.mark.thorough
def test_what_a_table_of_winds_does_not_say_is_told_or_given(tmp_path):
    """Configuration I flies at 12 km; 39,400 ft at 67 mph are the same as the site's and m/s."""
    feet, metres = tmp_path / "feet.csv", tmp_path / "metres.csv"
    feet.write_text(
        "altitude,speed,direction\n0,0,270\n39370.0787401575,67.1080887616,270\n90000,0,0\n"
    )
    metres.write_text(
        "Altitude MSL (m),Speed (m/s),Direction (deg)\n160,0,270\n12160,30,270\n27592,0,0\n"
    )
    arguments = ("--azimuth-deg", 90)
    site = ("--set", "sounding.units=ft,mph", "--set", "sounding.above_ground_m=160")
    given = document("--winds", feet, *site, *arguments)
    written = document("--winds", metres, *arguments)
    assert given["wind"]["peak_deg"] == pytest.approx(written["wind"]["peak_deg"], rel=1e-9)
    named = run("--winds", feet, "--set", "sounding.format=openrocket", *arguments)
    assert "feet.csv: assumed, as the file does not say: altitudes in m, speeds" in named.stderr
    assert "--set sounding.format openrocket" in run("--winds", feet, *arguments).stderr
    for key in ("units=ft,mph", "above_ground_m=160", "format=csv"):
        assert "[sounding] needs a sounding: --winds" in run("--set", f"sounding.{key}").stderr
