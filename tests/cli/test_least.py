"""`tvclin design --least`, `tvclin design --box`, and study files that ask for least gains."""

import json

import pytest
from typer.testing import CliRunner

import tvclin as tv
from tvclin.cli.app import app
from tvclin.cli.design import BoxResult
from tvclin.design.gain_designs import specified_autopilot
from tvclin.design.worst_case import Worst, WorstCase
from tvclin.studyfile.findings import find

STUDY = """
[study]
vehicle = "configuration-i"
[wind]
peak_deg = 5
duration_s = 7.5
[autopilot]
design = "least-nozzle"
crossover_rad_per_s = 2
delay_ms = 20
"""


def run(*arguments):
    return CliRunner().invoke(app, list(arguments))


@pytest.mark.thorough
def test_gains_are_sought_and_their_winds_listed():
    result = run("design", "--least", "--crossover", "2", "--delay-ms", "20", "--json")
    assert result.exit_code == 0
    document = json.loads(result.stdout)
    minimum = document["least"]
    assert minimum["meaning"] == "peak"
    assert len(minimum["deflections_deg"]) == 3
    assert minimum["deflection_deg"] >= document["rules"][0]["peak_deflection_deg"] * (1.0 - 1e-9)
    assert "crossover" in minimum["active"]


@pytest.mark.thorough
def test_gains_are_sought_for_the_samples_and_filters_that_are_given():
    """What `margins` says of the gains, given with the same samples, is what was designed for."""
    loop = (
        "--sample-rate",
        "25",
        "--delay-ms",
        "20",
        "--set",
        'autopilot.filter=[{kind="notch", frequency_Hz=9, zero_damping=0.05, pole_damping=0.5}]',
    )
    result = run("design", "--least", "--crossover", "2", *loop, "--json")
    assert result.exit_code == 0
    document = json.loads(result.stdout)
    assert document["criteria"]["satisfied"]
    own = document["autopilot"]
    gains = ("--attitude-gain", repr(own["attitude_gain"]), "--rate-gain", repr(own["rate_gain_s"]))
    judged = json.loads(run("margins", *gains, *loop, "--json").stdout)
    assert judged["criteria"]["satisfied"]
    assert own["sample_rate_Hz"] == judged["autopilot"]["sample_rate_Hz"] == 25.0


@pytest.mark.thorough
def test_a_study_file_designs_with_its_samples_and_filters(tmp_path):
    file = tmp_path / "least.toml"
    lag = '[[autopilot.filter]]\nkind = "low-pass"\non = "rate"\nfrequency_rad_per_s = 60\n'
    file.write_text(STUDY + "sample_rate_Hz = 25\n" + lag)
    case = tv.load_study(file)
    result = specified_autopilot(case, case.history, tv.CRITERIA["classic"])
    assert result.sample_rate == 25.0
    assert len(result.rate_filters) == 1
    assert tv.CRITERIA["classic"].are_satisfied(result.margins(case.plant))


@pytest.mark.thorough
def test_a_study_file_asks_for_them(tmp_path):
    file = tmp_path / "least.toml"
    file.write_text(STUDY)
    computed = find(tv.load_study(file)).comparison
    assert computed.ratio_to_trim == pytest.approx(1.109, abs=2e-3)
    assert tv.CRITERIA["classic"].are_satisfied(computed.margins)


@pytest.mark.thorough
def test_the_worst_margins_of_a_box_are_judged():
    fine = ("design", "--natural-frequency", "1", "--delay-ms", "20")
    good = run(*fine, "--box", "thrust=-3%..3%", "--box", "delay_ms=0..40")
    assert good.exit_code == 0
    assert "Criteria classic in the box: MET" in good.output
    assert "delay = 0.04 s" in good.output
    bad = run(*fine, "--box", "gain=0.2..1", "--json")
    assert bad.exit_code == 1
    document = json.loads(bad.stdout)
    assert document["criteria"]["satisfied"]
    assert not document["box"]["satisfied"]
    assert document["box"]["margins"]["aero_margin_dB"]["at"] == {"gain": 0.2}
    assert document["bounds"]["disk_margin"] == pytest.approx(1.73, abs=0.01)


@pytest.mark.parametrize(
    ("change", "verdict"),
    [
        ({}, "MET"),
        ({"omitted": "structure"}, "NOT KNOWN, the vehicle in the box is without its structure"),
        ({"peak_sensitivity": 9.0}, "NOT KNOWN, no peak sensitivity is computed in a box"),
        ({"omitted": "structure", "disk_margin": 1.0}, "NOT MET"),
    ],
)
def test_criteria_are_met_in_a_box_only_where_all_are_computed(change, verdict):
    worst = Worst(0.8, 0.9, {"delay": 0.04}, True, "searched")
    found = WorstCase({"delay": (0.0, 0.04)}, {"disk_margin": worst}, True, None, 2)
    limits = {"disk_margin": 0.7} | {k: v for k, v in change.items() if k != "omitted"}
    box = BoxResult(found, tv.control.Criteria.custom(**limits), change.get("omitted", ""))
    assert f"in the box: {verdict}; worst disk margin 0.800 at delay = 0.04 s" in box.verdict
    assert box.satisfied is {"MET": True, "NOT MET": False}.get(verdict)


@pytest.mark.thorough
def test_a_box_is_judged_in_samples():
    """The continuous autopilot satisfies the criteria with each of these delays."""
    design = ("design", "configuration-i", "--natural-frequency", "1")
    continuous = run(*design, "--box", "delay_ms=0..200")
    assert "in the box: MET" in continuous.output
    assert "at nominal" in continuous.output  # the required deflection
    sampled = run(*design, "--sample-rate", "5", "--box", "delay_ms=0..200")
    assert (sampled.exit_code, "in the box: NOT MET" in sampled.output) == (1, True)
    assert "of the continuous autopilot" not in sampled.output
    assert "gains that satisfy the criteria" not in sampled.output  # these gains, without the box


@pytest.mark.thorough
def test_the_keys_of_a_box_carry_their_units():
    """The same box in other units, or in percent of the nominal thrust, is the same."""
    thrust = tv.load_vehicle("configuration-i").thrust
    low, high = 0.97 * thrust, 1.03 * thrust
    computed = [
        json.loads(run("design", "--delay-ms", "20", "--json", *box).stdout)["box"]["box"]
        for box in (
            ("--box", f"thrust_N={low}..{high}", "--box", "delay_s=0..0.04"),
            ("--box", f"thrust_kN={low / 1e3}..{high / 1e3}", "--box", "delay_ms=0 .. 40"),
            ("--box", "thrust=-3%..3%", "--box", "delay=-100%..100%"),
        )
    ]
    for one in computed:
        assert one["thrust"] == pytest.approx([low, high], rel=1e-12)
        assert one["delay"] == pytest.approx([0.0, 0.04], rel=1e-12)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["design", "--three-gains"], "--three-gains needs --least"),
        (["design", "--three-gains", "--crossover", "3"], "--three-gains and --crossover need"),
        (["design", "--least", "--set", "autopilot.sudden_ends", "3"], "sudden_ends needs minimum"),
        (["design", "--least", "--design", "lqr"], "not both"),
        (["design", "--least", "--damping", "0.7"], "not both"),
        (["design", "--least", "--attitude-gain", "0.7"], "not both"),
        (
            ["design", "--least", "--set", "nozzle.actuator_frequency_rad_per_s=0"],
            "give one of these",
        ),
        (["margins", "--design", "least-nozzle", "--damping", "0.7"], "give no damping"),
        (["design", "--box", "delay"], "KEY=LO..HI"),
        (["design", "--box", "delay_ms=a..b"], "two numbers beside the dots"),
        (["design", "--box", "thrust=-3%..3"], "both in percent or neither"),
        (["design", "--box", "delay=1%..2%"], "no nominal value"),
        (["design", "--box", "delay=0..0.04"], "write delay_s or delay_ms"),
        (["design", "--box", "thrust=2.4e6..2.6e6"], "write thrust_N or thrust_kN"),
        (["design", "--box", "thrst_kN=1..2"], "did you mean thrust_kN"),
        (["design", "--box", "thrst=1%..2%"], "did you mean thrust"),
        (["design", "--box", "foo=1..2"], "tvclin init --keys lists the known ones"),
        (["design", "--box", "bending_frequency=1%..2%"], "unknown number of --box"),
        (["design", "--box", "gain=1..2", "--box", "gain=1..2"], "twice"),
    ],
)
def test_what_is_asked_wrongly_is_said_in_a_sentence(arguments, words):
    result = run(*arguments)
    assert result.exit_code == 2
    assert words in " ".join(result.output.split())


@pytest.mark.thorough
def test_gains_for_the_least_nozzle_are_those_of_the_vehicle_that_bends():
    """Gains designed for the rigid vehicle miss the criteria on the same file, by every command."""
    given = ("design", "made-up-launcher", "--delay-ms", "10")
    refused = run(*given, "--crossover", "2", "--least")
    words = "up to 2 rad/s: NOT MET by any attitude and rate gains"
    assert (refused.exit_code, words in " ".join(refused.output.split())) == (1, True)
    rigid = json.loads(run(*given, "--least", "--set", "study.rigid=true", "--json").stdout)[
        "autopilot"
    ]
    own = ("--attitude-gain", rigid["attitude_gain"], "--rate-gain", rigid["rate_gain_s"])
    gains = ("made-up-launcher", *map(str, own), "--delay-ms", "10", "--json")
    for command in ("margins", "design"):
        answer = run(command, *gains)
        assert (answer.exit_code, json.loads(answer.stdout)["criteria"]["satisfied"]) == (1, False)


@pytest.mark.thorough
def test_gains_found_with_a_notch_meet_the_criteria_in_margins_too():
    notch = (
        "made-up-launcher",
        "--set",
        'autopilot.filter=[{kind="notch", frequency_Hz=5.6, zero_damping=0.05, pole_damping=0.7}]',
        "--json",
    )
    answer = json.loads(run("design", "--least", "--crossover", "2", *notch).stdout)
    own = answer["autopilot"]
    gains = ("--attitude-gain", own["attitude_gain"], "--rate-gain", own["rate_gain_s"])
    margins = run("margins", *map(str, gains), *notch)
    assert (
        answer["criteria"]["satisfied"]
        is json.loads(margins.stdout)["criteria"]["satisfied"]
        is True
    )


IMPOSSIBLE = ("--set", "criteria.phase_margin_deg", "80")


def test_a_search_without_a_result_is_an_answer_of_no():
    """Exit code 1, the nearest gains judged as margins judges them, and the range of the search."""
    answer = run("design", "--least", *IMPOSSIBLE, "--json")
    document = json.loads(answer.stdout)
    assert answer.exit_code == 1
    assert document["unsatisfied"].startswith("criteria classic, with phase margin 80 deg: NOT MET")
    assert "least" not in document
    assert any("in the range of a0 from" in note for note in document["notes"])
    assert not any("--least" in note for note in document["notes"])
    own = document["autopilot"]
    gains = ("--attitude-gain", repr(own["attitude_gain"]), "--rate-gain", repr(own["rate_gain_s"]))
    judged = run("margins", *gains, *IMPOSSIBLE, "--json")
    assert judged.exit_code == 1
    phase = json.loads(judged.stdout)["margins"]["phase_margin_deg"]
    assert 70.0 < phase == pytest.approx(document["margins"]["phase_margin_deg"], rel=1e-9)


@pytest.mark.thorough
def test_rules_with_a_lower_peak_than_the_least_gains_are_named():
    """The peaks of the table say which; with two gains the note names the option for three."""
    document = json.loads(run("design", "--least", "--json").stdout)
    least, *others = document["rules"]
    peaks = {rule["rule"]: rule["peak_deflection_deg"] for rule in others if rule["satisfied"]}
    lower = {name for name, peak in peaks.items() if peak < least["peak_deflection_deg"]}
    (note,) = (note for note in document["notes"] if note.startswith("least-nozzle has"))
    assert lower == {"drift-minimum", "half-relief", "lqr"}
    assert all(name in note for name in (*lower, "--three-gains"))
