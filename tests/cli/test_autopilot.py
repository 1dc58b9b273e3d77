"""`tvclin margins`, `design`, and `fly` of laws: the numbers of the library, and clear refusals."""

import json
import re

import numpy as np
import pytest
from scipy.signal import cont2discrete
from typer.testing import CliRunner

import tvclin as tv
from tests.turns import usual
from tvclin.base.lines import text
from tvclin.cli.app import app
from tvclin.design.standard_trials import _limit, law_trials, standard_laws


def run(*arguments):
    return CliRunner().invoke(app, list(arguments))


def booster(model=None):
    return tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), model)


def test_margins_equal_the_library():
    result = run("margins", "--natural-frequency", "1", "--delay-ms", "40", "--json")
    plant = booster()
    rule = {"natural_frequency": 1.0, "damping": 0.7}
    autopilot = tv.design_gains(plant.coefficients, **rule, actuator=tv.Actuator(), delay=0.04)
    expected, document = autopilot.margins(plant), json.loads(result.stdout)
    assert result.exit_code == 0
    for name in ("aero_margin_dB", "gain_increase_dB", "phase_margin_deg", "disk_margin"):
        assert document["margins"][name] == pytest.approx(getattr(expected, name), rel=1e-12)
    assert document["criteria"]["satisfied"]
    assert all(limit["source"] for limit in document["criteria"]["limits"])


UNSTABLE = ("--attitude-gain", "0.05", "--rate-gain", "0.3")
LAW = ("--law", "autopilot")
GAIN_MARGINS = ("aero_margin_dB", "gain_increase_dB")


def test_criteria_decide_the_exit_code():
    gains = ("margins", "--natural-frequency", "1")
    assert run(*gains).exit_code == 0
    assert run(*gains, "--set", "criteria.phase_margin_deg=80").exit_code == 1
    assert run(*gains, "--set", "criteria.delay_margin_ms=2000").exit_code == 1
    assert "NOT MET" in run("margins").output


def test_a_gain_margin_may_be_asked_for_in_decibels():
    plant = booster()
    rule = {"natural_frequency": 1.0, "damping": 0.7, "actuator": tv.Actuator()}
    margins = tv.design_gains(plant.coefficients, **rule).margins(plant)
    minimum = min(margins.aero_margin_dB, 20.0 * np.log10(margins.gain_increase))
    for request, code in ((minimum - 1e-6, 0), (minimum + 1e-6, 1)):
        both = [("--set", f"criteria.{name}={float(request)!r}") for name in GAIN_MARGINS]
        result = run("margins", "--natural-frequency", "1", *both[0], *both[1])
        assert result.exit_code == code


def test_only_gains_that_are_used_are_shown():
    gains = (
        "margins",
        "--attitude-gain",
        "0.7",
        "--rate-gain",
        "0.9",
        "--set",
        "autopilot.alpha_gain=0.25",
    )
    shown = run(*gains, "--more", "--set", "autopilot.integral_gain_per_s=0.05").output
    assert re.search(r"alpha gain b0\W+0\.25\b", shown)
    assert re.search(r"integral gain aI\W+0\.05 1/s", shown)
    assert "integral gain" not in run(*gains, "--more").output


def test_an_unstable_loop_has_a_reason_and_no_margins():
    result = run("margins", "--attitude-gain", "0.05", "--rate-gain", "0.3")
    assert result.exit_code == 1
    assert "NOT MET, the closed loop is unstable: 2 closed-loop poles" in result.output
    assert "phase" not in result.output
    other = run("fly", "--attitude-gain", "0.05", "--rate-gain", "0.3")
    assert other.exit_code == 1
    assert "Autopilot requirement: NOT KNOWN, the closed loop is unstable" in other.output
    assert json.loads(run("fly", *UNSTABLE, "--json").stdout)["survived"] is None
    limited = run("fly", *UNSTABLE, "--limit-deg", "1")
    assert "criteria" not in limited.stdout.replace("that satisfy the criteria", "")
    for answer in (result, other, limited):
        assert answer.stdout.count("loop is unstable") == 1


def test_no_margins_and_notes_fit_a_terminal(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    gains = ("--attitude-gain", "2", "--rate-gain", "1.5")
    lost = run("margins", *gains, "--delay-ms", "900")
    endless = run("margins", *gains, "--set", "nozzle.actuator_frequency_rad_per_s=0")
    assert "NOT MET, the closed loop" in lost.output
    assert "Note: gain-increase margin inf" in endless.output
    for result in (lost, endless):
        assert max(map(len, result.output.splitlines())) <= 80


@pytest.mark.parametrize(("rate_gain", "outside"), usual([(2.5, False), (4.5, True)], 1))
def test_each_pole_of_a_sampled_loop_is_shown_once_also_that_of_a_negative_z(rate_gain, outside):
    """A real z < 0 has s = ln|z|/h + j pi/h and no conjugate."""
    h, system = 0.2, booster().ss()
    A, B, *_ = cont2discrete((system.A, system.B[:, :1], system.C, system.D[:, :1]), h)
    z = np.linalg.eigvals(A + B @ [[0.6, rate_gain, 0.0]])
    single = z[z.real < 0.0].item().real
    expected = [f"{np.log(p) / h:.4g}" for p in z.real if p > 0.0]
    expected.append(f"{np.log(-single) / h:.4g}+{np.pi / h:.4g}j (z = {single:.4g})")

    gains = ("--attitude-gain", "0.6", "--rate-gain", f"{rate_gain}", "--sample-rate", "5")
    ideal = ("--set", "nozzle.actuator_frequency_rad_per_s=0")
    shown = " ".join(run("margins", *gains, *ideal, "--more").output.split())
    poles = shown.split("log(z)/h [1/s] ")[1].split(", ")
    assert sorted(poles) == sorted(expected)
    reason = "unstable: 1 closed-loop pole lies outside the unit circle"
    assert (reason in shown) is outside


def poles_shown(*arguments):
    line = next(
        line
        for line in run(*arguments, "--more").output.splitlines()
        if "closed-loop poles" in line and "[1/s]" in line
    )
    words = line.split("[1/s]")[1].split(",")
    return [complex(word.strip().replace("±", "+").replace("+-", "-")) for word in words]


@pytest.mark.thorough
def test_poles_of_a_sampled_loop_are_shown_as_the_continuous_ones_to_which_they_tend():
    """A zero-order hold is half a sample of delay: a pole p moves by about p h, relative."""
    gains = ("margins", "--attitude-gain", "0.8", "--rate-gain", "0.8", "--model", "fixed-path")
    continuous = poles_shown(*gains)
    for rate in (100.0, 1000.0):
        sampled = poles_shown(*gains, "--sample-rate", f"{rate:g}")
        for pole in continuous:
            nearest = min(sampled, key=lambda other: abs(other - pole))
            assert abs(nearest - pole) < abs(pole) ** 2 / rate
        assert all(pole.real > -rate * np.log(1e3) for pole in sampled)


@pytest.mark.parametrize("delay", [0.02, 0.15, 0.25])
def test_poles_of_a_loop_with_delay_are_exact_ones_and_the_actuator_is_among_them(delay):
    gains = ("--attitude-gain", "0.8", "--rate-gain", "0.8", "--model", "fixed-path")
    shown = poles_shown("margins", *gains, "--delay-ms", str(1000 * delay))
    autopilot = tv.Autopilot(
        attitude_gain=0.8, rate_gain=0.8, actuator=tv.Actuator(), delay=delay, pade_order=10
    )
    loop = autopilot.rational_loop(booster("fixed-path"))
    above, below = (np.poly1d(p) for p in (loop.numerator, loop.denominator))
    for pole in shown:  # by the argument principle there is an exact pole near by
        circle = pole + 0.06 * abs(pole) * np.exp(2j * np.pi * np.linspace(0, 1, 2001))
        around = below(circle) + above(circle) * np.exp(-circle * delay)
        assert np.round(np.angle(around[1:] / around[:-1]).sum() / (2 * np.pi)) >= 1
    near = autopilot.close(booster("fixed-path")).poles()
    slow = near[(near.imag >= 0) & (np.abs(near) < 30.0) & (near.real > -25.0)]
    for pole in slow:
        assert np.min(np.abs(np.array(shown) - pole)) < 0.05 * abs(pole)


def test_unstable_poles_of_a_loop_with_a_long_delay_are_shown():
    gains = ("--attitude-gain", "2", "--rate-gain", "5", "--model", "fixed-path")
    shown = poles_shown("margins", *gains, "--delay-ms", "900")
    assert max(pole.real for pole in shown) > 0.0
    assert max(abs(pole) for pole in shown if pole.real > 0.0) > 3.0 / 0.9


def test_a_stable_vehicle_is_told_what_to_give(stable_vehicle):
    for command in ("margins", "design"):
        result = run(command, str(stable_vehicle))
        assert result.exit_code == 2
        assert "give --natural-frequency" in result.stderr
    assert run("margins", str(stable_vehicle), "--natural-frequency", "1").exit_code in {0, 1}


@pytest.mark.parametrize("form", [[], ["--json"]])
def test_of_an_unstable_loop_there_are_words_and_no_figure(form, tmp_path):
    file = tmp_path / "chart.png"
    gains = (*UNSTABLE, *form)
    result = run("fly", *gains, "--plot", str(file))
    assert result.exit_code == 1
    assert result.stdout == run("fly", *gains).stdout
    assert "an unstable loop has no flight to draw" in result.stderr
    assert not file.exists()


def test_a_warning_is_said_once():
    result = run("margins", "--attitude-gain", "-0.05", "--rate-gain", "0.3")
    assert result.stderr.count("Warning: attitude_gain = -0.05 is positive feedback") == 1


def test_the_autopilot_is_compared_as_in_the_library_and_its_flight_is_drawn(tmp_path):
    file = tmp_path / "flight.svg"
    result = run("fly", "--natural-frequency", "1", "--json", "--plot", str(file))
    assert "</svg>" in file.read_text()
    document = json.loads(result.stdout)["comparison"]
    plant = booster()
    rule = {"natural_frequency": 1.0, "damping": 0.7, "actuator": tv.Actuator()}
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
    expected = tv.compare_with_trim(plant, tv.design_gains(plant.coefficients, **rule), wind)
    peak = np.degrees(expected.peak_deflection)
    assert document["peak_deflection_deg"] == pytest.approx(peak, rel=1e-12)
    assert document["minimum_deg"] == pytest.approx(np.degrees(expected.minimum), rel=1e-12)
    assert document["part_of_trim"] == pytest.approx(expected.ratio_to_trim, rel=1e-12)


@pytest.mark.thorough
def test_a_limit_is_judged():
    gains = ("fly", "--natural-frequency", "1", "--limit-deg")
    assert run(*gains, "0.6").exit_code == 1
    assert run(*gains, "0.7").exit_code == 0


@pytest.mark.thorough
def test_a_sufficient_limit_that_a_longer_wind_exceeds_is_said_to_be_exceeded():
    longer = json.loads(run("fly", *LAW, "--json").stdout)["comparison"]["worst_duration"]
    assert longer["peak_deflection_deg"] > 0.95
    said = " ".join(run("fly", *LAW, "--limit-deg", "0.95").output.split())
    assert (
        "Limit 0.95 deg: NOT KNOWN, sufficient at nominal dynamic pressure, and below the bound"
        " for a head wind" in said
    )
    yaw = ("fly", *LAW, "--plane", "yaw", "--limit-deg")
    worst = f"{longer['peak_deflection_deg']:.3f} deg in a wind of {longer['duration_s']:.3g} s"
    said = " ".join(run(*yaw, "0.95").output.split())
    assert f"SUFFICIENT in this wind; without a limit the autopilot uses {worst}" in said


@pytest.mark.parametrize("chart", usual(["nichols", "bode", "nyquist", "root-locus"], 0))
def test_charts_are_written(chart, tmp_path):
    file = tmp_path / "chart.png"
    run("margins", "--natural-frequency", "1", "--chart", chart, "--plot", str(file))
    assert file.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("ending", ["mat", "npz"])
def test_plant_and_loop_are_written_as_systems_with_their_bits(ending, tmp_path):
    plant, rule = booster("drift"), {"natural_frequency": 1.0, "damping": 0.7}
    autopilot = tv.design_gains(plant.coefficients, **rule, actuator=tv.Actuator(), delay=0.02)
    given = ("--model", "drift", "--natural-frequency", "1", "--delay-ms", "20")
    expected = {"poles": plant.ss(), "margins": autopilot.loop(plant)}
    for command, system in expected.items():
        file = tmp_path / f"{command}.{ending}"
        options = given[:2] if command == "poles" else given
        assert run(command, *options, "--system", str(file)).exit_code == 0
        read = tv.linear.read_system(file)
        assert (list(read.inputs), list(read.outputs)) == (
            system.input_labels,
            system.output_labels,
        )
        for name in "ABCD":
            np.testing.assert_array_equal(getattr(read, name), getattr(system, name))
    refused = run("poles", "--system", str(tmp_path / "plant.txt"))
    assert (refused.exit_code, "must end in .mat or .npz" in refused.stderr) == (2, True)


@pytest.mark.thorough
def test_gains_with_samples_have_the_peaks_of_the_continuous_loop():
    """The margins are of the sampled loop; of the peaks "-" stood in the table."""
    continuous, sampled = (
        json.loads(run("design", *rate, "--json").stdout) for rate in ((), ("--sample-rate", "50"))
    )
    peaks = [[rule["peak_deflection_deg"] for rule in d["rules"]] for d in (continuous, sampled)]
    assert peaks[0] == peaks[1]
    assert len([peak for peak in peaks[0] if peak is not None]) > 3
    assert any("peaks of the continuous one" in note for note in sampled["notes"])
    assert sampled["rules"][0]["phase_margin_deg"] < continuous["rules"][0]["phase_margin_deg"]


def test_the_plant_of_a_flexible_vehicle_is_written_with_its_structure(tmp_path):
    vehicle = tv.load_vehicle("made-up-launcher")
    for given, subject in (((), vehicle), (("--set", "study.rigid=true"), vehicle.rigid)):
        assert (
            run("poles", "made-up-launcher", *given, "--system", f"{tmp_path}/p.npz").exit_code == 0
        )
        plant = tv.linear.plant_of(subject)
        np.testing.assert_array_equal(tv.linear.read_system(f"{tmp_path}/p.npz").A, plant.ss().A)
    assert "tvclin margins --more prints those of the closed loop" in " ".join(
        run("poles").output.split()
    )


def test_laws_are_flown_in_the_winds_asked_for():
    arguments = ("--set", "laws.winds", "triangle", "--model", "fixed-path", "--sample-rate", "40")
    result = run("fly", "--law", "all", "--duration", "4", *arguments, "--json")
    document = json.loads(result.stdout)
    limits = {trial["law"]: trial["limit"] for trial in document["trials"]}
    flown = ("autopilot", "trim", "dead-band", "half-relief", "recoverable-attitude")
    assert tuple(limits) == flown
    assert min(limits.values()) >= document["no_forecast"]["triangle"]
    head = {key: document[key] for key in ("model", "plane", "peak_deg", "cuts", "sample_rate_Hz")}
    expected = {"model": "fixed-path", "plane": "pitch", "cuts": 0, "sample_rate_Hz": 40.0}
    assert head == expected | {"peak_deg": pytest.approx(5.0)}
    trim = abs(np.degrees(booster("fixed-path").coefficients.B * np.radians(5.0)))
    assert document["trim_deflection_deg"] == pytest.approx(trim, rel=1e-12)
    for trial in document["trials"]:
        assert trial["limit_deg"] == pytest.approx(trial["limit"] * trim, rel=1e-12)
        assert (trial["status"], trial["creeps"]) == ("ok", False)
        assert trial["growth"] < 0.0


@pytest.mark.thorough
def test_of_a_wind_that_turns_no_law_without_forecast_is_bounded(tmp_path, monkeypatch):
    """Nothing is flown: the bound, and the chart of the laws, belong to the winds alone."""
    monkeypatch.setattr("tvclin.cli.fly.law_trials", lambda *_, **__: [])
    monkeypatch.setattr(
        "tvclin.plots.trade_offs.law_curve", lambda _, __, tau, ___, **____: np.ones_like(tau)
    )
    winds, file = ("--set", "laws.winds", "triangle,opposite gusts"), tmp_path / "laws.svg"
    every = ("fly", "--law", "all", "--model", "fixed-path")
    result = run(*every, *winds, "--json", "--plot", str(file))
    bounds = json.loads(result.stdout)["no_forecast"]
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
    assert bounds["triangle"] == tv.forecast_free_limit(booster("fixed-path"), wind).limit
    assert bounds["opposite gusts"] is None
    assert "</svg>" in file.read_text()


@pytest.mark.thorough
def test_a_boundary_beyond_the_range_is_no_number():
    """Of a puff of 10 ms next to nothing is needed; two samples a second are too few."""
    plain = ("--wind", "triangular", "--model", "fixed-path", "--more", "--sample-rate")
    every = ("fly", "--law", "all", "--duration")
    short = run(*every, "0.01", *plain, "20").stdout
    assert short.count("<0.02 ") == 5
    assert short.count("<0.01072") == 5  # in deg, of the 0.5360 that trim takes
    assert "0.020" not in short
    slow = run(*every, "7", *plain, "0.5").stdout
    assert ">4" in slow
    assert "inf" not in slow
    assert "nan" not in slow


def test_a_law_that_lets_a_mode_creep_away_is_marked():
    law = tv.TrimLaw(booster("drift-exact"))
    winds = {"triangle": tv.design.standard_winds(0.08, 7.0)["triangle"]}
    (computed,) = law_trials(booster("drift-exact"), {"trim": law}, winds, sample_rate=20.0)
    assert computed.creeps
    assert computed.growth == pytest.approx(0.0129, abs=1e-4)
    assert computed.status == "near rest a real mode grows with +0.0129 1/s"
    assert (computed.lowest, computed.highest) == (0.02, 4.0)
    assert text(_limit("", computed, 1.0)) == f"{computed.limit:.3f}!"
    for trial in law_trials(
        booster("drift-exact"),
        standard_laws(booster("drift-exact"), 0.08),
        winds,
        sample_rate=20.0,
    ):
        assert not trial.creeps


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["margins", "--design", "guess"], "--design must be one of canonical, poles"),
        (["margins", "--design", "poles"], "design poles needs --natural-frequency, in rad/s"),
        (["margins", "--rate-gain", "1"], "need --attitude-gain and --rate-gain, both"),
        (["margins", "--attitude-gain", "1", "--design", "lqr"], "not both; got --attitude-gain,"),
        (
            ["study", "--attitude-gain", "1", "--rate-gain", "1", "--damping", "0.5"],
            "not both; got --attitude-gain, --rate-gain, damping",
        ),
        (["study", "--attitude-gain", "1"], "need --attitude-gain and --rate-gain, both"),
        (
            ["study", "--attitude-gain", "1", "--rate-gain", "1", "--natural-frequency", "1"],
            "not both",
        ),
        (["margins", "--delay-ms", "-1"], "--delay-ms must be zero or positive"),
        (["margins", "--set", "criteria.name", "some"], "must be one of classic, aircraft"),
        (["margins", "--chart", "smith"], "--chart must be one of nichols"),
        (["margins", "--natural-frequency", "0"], "--natural-frequency must be positive"),
        (
            ["fly", "--attitude-gain", "1e200", "--rate-gain", "1"],
            "--attitude-gain must be zero or 1e-30 to 1e+09 in size; got 1e+200",
        ),
        (
            ["margins", "--natural-frequency", "1e200"],
            "--natural-frequency must be between 1e-09 and",
        ),
        (
            [
                "margins",
                "--natural-frequency",
                "1",
                "--set",
                "nozzle.actuator_frequency_rad_per_s=1e200",
            ],
            "actuator_frequency must be between 1e-09 and 1e+09",
        ),
        (
            ["margins", "--natural-frequency", "1", "--delay-ms", "1e-200"],
            "--delay-ms must be zero or",
        ),
        (["fly", *LAW, "--limit-deg", "0"], "--limit-deg must be"),
        (["fly", "--law", "all", "--set", "laws.winds", "storm"], "must be one of triangle"),
        (["fly", "--law", "all", "--limit-deg", "1"], "--limit-deg needs a single law"),
        (["fly", "--law", "all", "--engine", "linear"], "--engine needs a single law"),
    ],
)
def test_bad_input_is_one_sentence(arguments, message):
    result = run(*arguments)
    assert result.exit_code == 2
    assert message in result.stderr
    assert "Traceback" not in result.stderr


@pytest.mark.thorough
def test_flown_margins_stand_beside_the_linear_ones():
    arguments = ("margins", "--natural-frequency", "1", "--model", "fixed-path", "--delay-ms", "5")
    flown = (*arguments, "--limit-deg", "0.6", "--duration", "6", "--sample-rate", "60")
    document, plant = json.loads(run(*flown, "--json").stdout), booster("fixed-path")
    law = tv.SaturatedLaw(tv.design_gains(plant.coefficients, natural_frequency=1.0, damping=0.7))
    expected = tv.flights.flown_margins(
        plant,
        law,
        tv.TriangularWind(peak=np.radians(5.0), duration=6.0),
        limit=np.radians(0.6),
        actuator=tv.Actuator(),
        sample_rate=60.0,
        delay=0.005,
    )
    for name in ("gain_fall", "effectiveness_fall", "delay"):
        one = getattr(expected, name)
        computed = document["flown"][name]
        assert computed["value"] == pytest.approx(one.value, rel=1e-9)
        assert (computed["cause"], computed["survives_beyond"]) == (one.cause, one.survives_beyond)
    assert document["flown"]["spare"] == pytest.approx(expected.spare, rel=1e-12)
    stepped = json.loads(run(*arguments, "--sample-rate", "60", "--json").stdout)
    assert document["margins"] == stepped["margins"]
    shown = run(*flown).output
    wind = "In this triangular wind of 5 deg and 6 s, at nominal dynamic pressure"
    assert f"{wind}, with a limit of 0.6 deg, 60 Hz" in " ".join(shown.split())
    assert re.search(rf"gain falls\W+{expected.gain_fall.dB:.2f} dB", shown)


def test_a_flight_that_is_lost_before_anything_changes_is_no_bad_input():
    result = run("margins", "--natural-frequency", "1", "--limit-deg", "0.2")
    assert result.exit_code == 1
    needs = 0.8712 * 5.0 * tv.Plant.from_vehicle(tv.load_vehicle("configuration-i")).coefficients.B
    said = " ".join(result.output.split())
    assert said.startswith("Criteria classic: MET; NOT SURVIVED with 0.2 deg, at nominal dynamic")
    assert f"the unchanged flight needs {needs:.3f}" in said
    document = json.loads(
        run("margins", "--natural-frequency", "1", "--limit-deg", "0.2", "--json").stdout
    )
    assert document["notes"][0] == "NOT SURVIVED with 0.2 deg, at nominal dynamic pressure"
    assert any(note.startswith("the unchanged flight needs") for note in document["notes"])
    unstable = run("margins", "--limit-deg", "0.6", *UNSTABLE)
    assert unstable.exit_code == 1
    assert "NOT MET, the closed loop is unstable" in unstable.output


@pytest.mark.thorough
def test_an_autopilot_says_by_what_it_is_judged() -> None:
    given = ("margins", "configuration-i", "--set", "criteria.delay_margin_ms=20")
    given += tuple(w for name in GAIN_MARGINS for w in ("--set", f"criteria.{name}=4"))
    criteria = json.loads(run(*given, "--json").stdout)["criteria"]

    request = {limit["margin"]: (limit["limit"], limit["source"]) for limit in criteria["limits"]}
    assert request["delay_margin"] == (0.02, "the study file")
    assert request["gain_increase_dB"] == (4.0, "the study file")
    assert request["phase_margin_deg"][0] == 30.0
    assert request["phase_margin_deg"][1] != "the study file"  # it was not changed


@pytest.mark.parametrize("vehicle", ["configuration-i", "made-up-launcher"])
def test_gains_that_nobody_specified_are_called_textbook_gains_and_those_proposed_are_enough(
    vehicle,
):
    shown = CliRunner().invoke(app, ["margins", vehicle])
    proposal = re.search(r"gains that satisfy the criteria classic: (--.+?), or", shown.stdout)
    better = CliRunner().invoke(app, ["margins", vehicle, *proposal[1].split()])

    assert (shown.exit_code, better.exit_code) == (1, 0)
    assert "textbook gains" in shown.stdout
    assert "textbook gains" not in better.stdout
    assert "gains that satisfy" not in better.stdout


@pytest.mark.thorough
@pytest.mark.parametrize("command", ["--", "file"])
def test_proposed_gains_replace_the_design_of_a_study_file(tmp_path, command):
    head = '[study]\nvehicle = "made-up-launcher"\n[wind]\npeak_deg = 2\nduration_s = 7.5\n'
    (tmp_path / "s.toml").write_text(f'{head}[autopilot]\ndesign = "canonical"\n')
    shown = CliRunner().invoke(app, ["margins", f"{tmp_path}/s.toml"])
    said = " ".join(shown.stdout.split())
    options = re.search(r"classic: (--.+?), or", said)[1].split()
    if command == "file":
        design, frequency = re.search(
            r'in \[autopilot\] design = "(\w+)" and natural_frequency_rad_per_s = (\S+),', said
        ).groups()
        options = ["--set", f"autopilot.design={design}"]
        options += ["--set", f"autopilot.natural_frequency_rad_per_s={frequency}"]
    better = CliRunner().invoke(app, ["margins", f"{tmp_path}/s.toml", *options])
    assert (shown.exit_code, better.exit_code) == (1, 0)


@pytest.mark.thorough
def test_an_actuator_is_called_assumed_until_it_is_specified_even_by_the_same_numbers(tmp_path):
    head = '[study]\nvehicle = "configuration-i"\n[wind]\npeak_deg = 2\nduration_s = 7.5\n'
    loop = head + '[criteria]\nname = "classic"\n[autopilot]\ndesign = "lqr"\n'
    nozzle = "[nozzle]\nactuator_frequency_rad_per_s = 25.1\n"
    said = "an actuator of 25.1 rad/s and damping 0.7 is assumed"
    for table, assumed in ((loop, True), (loop + nozzle, False), (head, False)):
        (tmp_path / "s.toml").write_text(table)
        shown = CliRunner().invoke(app, ["study", f"{tmp_path}/s.toml"])
        assert (said in shown.stdout) is assumed

    options = ["--set", "nozzle.actuator_frequency_rad_per_s=25.1"]
    assert said in CliRunner().invoke(app, ["margins"]).stdout
    assert said not in CliRunner().invoke(app, ["margins", *options]).stdout


@pytest.mark.parametrize(("model", "unstable"), [("drift-exact", True), ("fixed-path", False)])
def test_rules_without_margins_are_named_with_the_reason(model, unstable):
    """Without a reference of the attitude the flight path diverges, but not a fixed one."""
    options = ("design", "configuration-i", "--model", model)
    rules = {rule["rule"]: rule for rule in json.loads(run(*options, "--json").stdout)["rules"]}
    assert [name for name, rule in rules.items() if not rule["stable"]] == (
        ["load-minimum"] if unstable else []
    )
    said = "no margins, the loop is not stable: load-minimum"
    assert (said in " ".join(run(*options).stdout.split())) is unstable


def test_a_delay_margin_below_half_a_sample_is_told_where_the_criteria_are_met():
    """At 10 Hz; at 100 Hz half a sample is far less."""
    numbers = {"aero_margin_dB": "1", "gain_increase_dB": "1", "phase_margin_deg": "5"}
    keys = [word for key, x in numbers.items() for word in ("--set", f"criteria.{key}", x)]
    loose = (*keys, "--natural-frequency", "5")
    noted = {}
    for rate in ("10", "100"):
        result = run("margins", *loose, "--sample-rate", rate, "--json")
        document = json.loads(result.stdout)
        assert (result.exit_code, document["criteria"]["satisfied"]) == (0, True)
        delay = document["margins"]["delay_margin_s"]
        noted[rate] = any("below half a sample" in note for note in document["notes"])
        assert noted[rate] == (delay < 0.5 / float(rate))
    assert noted == {"10": True, "100": False}


@pytest.mark.parametrize("command", ["study", "margins", "report"])
@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--set", "autopilot.damping", "0.7"), "design poles needs"),
        (("--set", "autopilot.design", "lqr", "--set", "autopilot.damping", "0.7"), "takes no"),
        (("--set", "autopilot.drift_damping", "0.7"), "is of gains by design drift-poles"),
    ],
)
def test_a_rule_without_its_numbers_is_bad_input_in_every_command(command, options, said, tmp_path):
    page = ("-o", str(tmp_path / "page.html")) if command == "report" else ()
    result = run(command, "configuration-i", *options, *page)
    assert (result.exit_code, result.stdout) == (2, "")
    assert said in result.stderr
