"""`tvclin margins` of a vehicle that bends and sloshes: the numbers of the library, by band."""

import json
import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.flexible import PHASED
from tests.turns import usual
from tvclin.cli.app import app
from tvclin.vehicle.vehicle_file import read_vehicle_text

RIGID = ("--set", "study.rigid=true")
GAINS = ("--attitude-gain", "0.2", "--rate-gain", "0.2", "--delay-ms", "20")
FREQUENCY = ("--set", "nozzle.actuator_frequency_rad_per_s=10")
"""Of an actuator slow enough to keep the second and third mode small."""


def run(*arguments):
    return CliRunner().invoke(app, list(arguments))


def booster(model="drift-exact"):
    return tv.linear.plant_of(tv.load_vehicle("made-up-booster"), model)


def autopilot(**changes):
    gains = {"attitude_gain": 0.2, "rate_gain": 0.2, "delay": 0.02}
    servo = tv.Actuator(natural_frequency=10.0, damping=0.7)
    return tv.Autopilot(**{**gains, "actuator": servo, **changes})


def margins(*more, file="made-up-booster"):
    return run("margins", file, *GAINS, *FREQUENCY, *more)


def test_a_vehicle_with_structure_gets_the_margins_of_the_flexible_vehicle_by_band():
    result = margins("--json")
    document, expected = json.loads(result.stdout), autopilot().band_margins(booster())
    assert document["flexible"]
    assert document["model"] == "drift-exact"
    for name in ("aero_margin_dB", "gain_increase_dB", "phase_margin_deg", "disk_margin"):
        computed = document["margins"][name]
        assert computed == pytest.approx(getattr(expected.margins, name), rel=1e-12, nan_ok=True)
    rigid = document["bands"]["rigid_body"]
    assert rigid["phase_margin_deg"] == pytest.approx(expected.rigid.phase_margin_deg, rel=1e-12)
    for mode in expected.modes:
        computed = document["bands"]["modes"][mode.name]
        assert computed["stabilised"] == mode.stabilised
        assert computed["distance"] == pytest.approx(mode.distance, rel=1e-12)
        assert computed["closed_pole"]["real"] == pytest.approx(mode.closed_pole.real, rel=1e-12)
    shown = margins("--more").output
    assert "Flexible vehicle (--set study.rigid true: without): 3 bending modes, 2 tanks" in shown
    poles = " ".join(shown.split("closed-loop poles [1/s]")[1].split("\n\n")[0].split())
    for mode in expected.modes:
        assert f"{mode.closed_pole.real:.4g}±{mode.closed_pole.imag:.4g}j" in poles
    for mode in expected.modes:
        word = {"with the rigid body": "rigid"}.get(mode.stabilised, mode.stabilised)
        at = mode.crossover_frequency if word == "phase" else mode.frequency
        assert re.search(rf"{mode.name} +{word} +{at:.4g}", shown)


TURNING = ("--natural-frequency", "1.3", "--damping", "0.7")
TURNING += ("--delay-ms", "30", "--sample-rate", "25")


@pytest.fixture
def phased(tmp_path: Path) -> str:
    """Return the path of a vehicle file with a phase-stabilised mode."""
    (tmp_path / "phased.toml").write_text(PHASED)
    return str(tmp_path / "phased.toml")


@pytest.mark.thorough
def test_the_smallest_margins_of_the_bands_are_those_of_the_whole_loop(phased):
    """The gain may rise by 2.69 dB at a phase crossover of the mode, of the rigid body by 40 dB."""
    result = run("margins", phased, *TURNING)
    for whole, band in (
        (r"gain may rise +2\.69 dB \(1\.36x\) +13\.3 ", r"bending 1 up +13\.3 +2\.69 dB"),
        (r" phase +5\.42 deg +14\.02 ", r"bending 1 +phase +14\.02 +5\.42 deg"),
        (r"gain may fall +16\.32 dB \(6\.55x\) +0\.2116", r"rigid down +0\.2116 +16\.32 dB"),
    ):
        assert re.search(whole, result.output)
        assert re.search(band, result.output)
    document = json.loads(run("margins", phased, *TURNING, "--json").stdout)
    mode, total = document["bands"]["modes"]["bending 1"], document["margins"]
    for name in ("gain_increase_dB", "gain_increase_frequency_rad_per_s"):
        assert mode[name] == total[name]
    assert mode["crossover_frequency_rad_per_s"] == total["crossover_frequency_rad_per_s"]


NOTCH = '[{kind = "notch", frequency_Hz = 2.5, zero_damping = 0.05, pole_damping = 0.5}]'


@pytest.mark.thorough
def test_a_mode_that_is_unstable_within_a_tenth_of_its_frequency_is_noted(phased):
    """At 1.06 of its frequency the loop is stable, at 1.07 it is not."""
    notched = (*TURNING, "--set", f"autopilot.filter={NOTCH}")
    note = "bending 1 is unstable at 1.065 of its frequency; --detuned shows the margins"
    result = run("margins", phased, *notched, "--json")
    assert note in json.loads(result.stdout)["notes"]
    assert result.exit_code == 0
    off = run("margins", phased, *notched, "--detuned", "--json")
    document = json.loads(off.stdout)
    assert f"{document['detuned']['edges'][0]['upper']:.3f}" == "1.065"
    assert note not in document["notes"]
    for factor, stable in ((0.95, True), (1.06, True), (1.07, False)):
        moved = PHASED.replace("frequency_Hz = 2.5", f"frequency_Hz = {2.5 * factor}")
        Path(phased).write_text(moved)
        document = json.loads(run("margins", phased, *notched, "--json").stdout)
        assert document["stable"] is stable
        assert any("is unstable at" in note for note in document["notes"]) is (factor == 1.06)


@pytest.mark.thorough
def test_modes_are_judged_where_the_command_line_asks_it_of_them():
    own = (
        "criteria.aero_margin_dB=3",
        "criteria.gain_increase_dB=3",
        "criteria.phase_margin_deg=20",
    )
    own = tuple(word for key in own for word in ("--set", key))
    assert margins(*own).exit_code == 0
    document = json.loads(margins(*own, "--set", "criteria.mode_gain_margin_dB=6", "--json").stdout)
    judged = {(limit["band"], limit["margin"]): limit for limit in document["criteria"]["limits"]}
    second = autopilot().band_margins(booster()).mode("bending 2").gain_margin_dB
    computed = judged["bending 2", "mode_gain_margin_dB"]
    assert computed["surplus"] == pytest.approx(second - 6.0, rel=1e-9)
    assert [key[0] for key, one in judged.items() if not one["satisfied"]] == ["bending 2"]
    free = margins(*own, "--set", "criteria.mode_gain_margin_dB=6").output
    assert "bending 1: phase-stabilised, without a required margin (mode_phase_margin_deg" in free
    failed = margins(
        *own,
        "--set",
        "criteria.mode_gain_margin_dB=6",
        "--set",
        "criteria.mode_phase_margin_deg=30",
    )
    assert "no criterion of modes" not in failed.output
    assert failed.exit_code == 1
    assert re.search(rf"bending 2 .* 6 dB +{second - 6.0:.3g} NOT MET", failed.output)
    assert re.search(r"bending 1 .* 30 deg .*(?<!NOT) MET", failed.output)


def test_an_unstable_flexible_vehicle_says_which_mode_is_lost():
    slower = ("--set", "nozzle.actuator_frequency_rad_per_s=15")
    result = run("margins", "made-up-booster", *GAINS, *slower)
    assert result.exit_code == 1
    assert "NOT MET, the closed loop is unstable: 2 closed-loop poles" in result.output
    assert re.search(r"bending 2 +unstable", result.output)
    assert not re.search(r"bending 1 +unstable", result.output)


def test_rigid_leaves_the_structure_out():
    document = json.loads(margins(*RIGID, "--model", "drift-exact", "--json").stdout)
    expected = autopilot().margins(booster().rigid)
    assert not document["flexible"]
    assert "bands" not in document
    computed = document["margins"]["gain_increase_dB"]
    assert computed == pytest.approx(expected.gain_increase_dB, rel=1e-12)
    assert json.loads(margins(*RIGID, "--json").stdout)["model"] == "drift-exact"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("configuration-i", "--set", "criteria.mode_phase_margin_deg=6"), "needs [[bending]]"),
        (("made-up-booster", *RIGID, "--detuned"), "--detuned needs modes"),
        (
            ("made-up-booster", "--set", "nozzle.actuator_frequency_rad_per_s=0"),
            "actuator of second order",
        ),
        (
            ("made-up-booster", "--set", "criteria.mode_gain_margin_dB=-6"),
            "mode_gain_margin_dB must be",
        ),
    ],
)
def test_what_does_not_go_together_is_one_sentence(arguments, message):
    result = run("margins", *arguments)
    assert result.exit_code == 2
    assert message in result.stderr


@pytest.mark.thorough
def test_a_model_without_modes_gives_way_to_the_exact_one_and_is_told() -> None:
    simplified, exact = margins("--model", "drift"), margins()
    assert "the model is drift-exact: drift leaves out the structure" in simplified.stderr
    assert simplified.stdout == exact.stdout


ONE_MODE = """
[[bending]]
frequency_Hz = 9
damping = 0.01
modal_mass_kg = 20000
gimbal_displacement = 1.0
gimbal_slope_per_m = -0.05
attitude_slope_per_m = 0.05
rate_slope_per_m = 0.05
"""


@pytest.mark.thorough
def test_a_verdict_counts_the_rows_of_detuned_modes(tmp_path: Path) -> None:
    """A vehicle file whose mode is that of a row misses the criteria as the row does."""
    file = tmp_path / "one.toml"
    file.write_text(read_vehicle_text("configuration-i")[0] + ONE_MODE)
    loop = ("--natural-frequency", "1.5", "--delay-ms", "10", "--sample-rate", "100")
    arguments = (
        str(file),
        *loop,
        "--set",
        'autopilot.filter=[{kind="notch", frequency_Hz=9, zero_damping=0.05, pole_damping=0.5}]',
        "--set",
        "criteria.mode_gain_margin_dB=10",
    )
    nominal, moved = run("margins", *arguments), run("margins", *arguments, "--detuned", "--json")
    assert (nominal.exit_code, moved.exit_code) == (0, 1)
    document = json.loads(moved.stdout)
    computed = document["detuned"]
    assert document["criteria"]["satisfied"]
    missed = [row["change"] for row in computed["rows"] if not row["satisfied"]]
    assert missed
    assert computed["satisfied"] is False
    lower = ONE_MODE.replace("frequency_Hz = 9", f"frequency_Hz = {0.8 * 9.0}")
    file.write_text(read_vehicle_text("configuration-i")[0] + lower)
    assert "bending 1 x 0.8" in missed
    assert run("margins", *arguments).exit_code == 1
    file.write_text(read_vehicle_text("configuration-i")[0] + ONE_MODE)
    shown = " ".join(run("margins", *arguments, "--detuned").output.split())
    assert f"with detuned modes: NOT MET in {len(missed)} of {len(computed['rows'])} rows" in shown
    assert "Criteria classic, with mode gain margin 10 dB: MET" in shown


@pytest.mark.thorough
def test_detuned_modes_are_those_of_the_library():
    arguments = (
        "--detuned",
        "--set",
        "criteria.mode_gain_margin_dB=1",
        "--set",
        "criteria.aero_margin_dB=3",
        "--set",
        "criteria.gain_increase_dB=3",
        "--set",
        "criteria.phase_margin_deg=20",
    )
    document = json.loads(margins(*arguments, "--json").stdout)["detuned"]
    limits = {"aero_margin_dB": 3, "gain_increase_dB": 3, "phase_margin_deg": 20}
    criteria = tv.control.Criteria.custom(**limits, mode_gain_margin_dB=1)
    expected = tv.control.detuned(autopilot(), booster(), criteria=criteria)
    assert [row["change"] for row in document["rows"]] == list(expected.changes)
    assert [row["first"] for row in document["rows"]] == list(expected.critical_margin)
    assert [row["satisfied"] for row in document["rows"]] == expected.satisfied.tolist()
    assert "unstable" in expected.critical_margin
    for row, phase in zip(document["rows"], expected.margins.phase_margin_deg, strict=True):
        computed = row["phase_margin_deg"]
        assert (computed is None) == (row["status"] != "ok")
        assert computed is None or computed == pytest.approx(phase, rel=1e-9)
    edge = expected.stable_ranges[1]
    assert document["edges"][1]["lower"] == pytest.approx(edge.lower, rel=1e-9)
    shown = margins(*arguments, "--more").output
    assert f"bending 2 is unstable at {edge.lower:.3f} of its frequency" in shown
    assert re.search(r"bending 2 x 0.8 +- +- +- +UNSTABLE", shown)


@pytest.mark.parametrize("command", usual(["study", "poles", "boundary"], 0, 1))
def test_other_commands_say_that_they_know_the_vehicle_as_rigid(command):
    moved = booster().shift()
    result = run(command, "made-up-booster")
    assert "are of the rigid vehicle, without the structure in its file" in result.stderr
    assert f"fast pole by {moved.fast_pole:+.2f} percent" in result.stderr
    assert f"required deflection by {moved.trim_price:+.2f} percent" in result.stderr
    assert "rigid" not in run(command, "configuration-i").stderr


@pytest.mark.thorough
@pytest.mark.usefixtures("few_durations")
def test_the_page_shows_what_the_commands_print(tmp_path, monkeypatch):
    """Each line below a command of the page is a line of its output, but for spaces."""
    pytest.importorskip("jinja2")
    pytest.importorskip("latex2mathml")
    page = (Path(__file__).parents[2] / "docs" / "flexible.md").read_text()
    (tables,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    Path("my.toml").write_text(read_vehicle_text("configuration-i")[0] + "\n" + tables)
    sessions = re.findall(r"```console\n\$ tvclin (.*?)\n(.*?)```", page, re.DOTALL)
    assert len(sessions) == 3
    for command, shown in sessions:
        result = run(*shlex.split(command))
        printed = [" ".join(line.split()) for line in result.output.splitlines()]
        assert result.exit_code == 1
        for line in shown.splitlines():
            assert line in printed
    run(
        "report", "my.toml", "--set", "autopilot.natural_frequency_rad_per_s=1.5", "-o", "page.html"
    )
    assert "The flexible vehicle" in Path("page.html").read_text()
