"""The study file that the panel writes: what commands make of it are the numbers of the panel."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.show.explored import moved
from tests.turns import usual
from tvclin.cli.app import app
from tvclin.control.laws.registry import AUTOPILOT, LAWS
from tvclin.show.explorer.answer import Answer, answer
from tvclin.show.explorer.choices import CONTROLS, IN_PLANE, OWN, study_text, write_study

NOTCHED = """
[study]
vehicle = "made-up-launcher"
dead_band = 0.5
[wind]
shape = "triangular"
peak_deg = 4.0
duration_s = 5.0
[nozzle]
limit_deg = 3.0
[autopilot]
natural_frequency_rad_per_s = 1.2
delay_ms = 10
[[autopilot.filter]]
kind = "notch"
frequency_Hz = 5.6
zero_damping = 0.05
pole_damping = 0.6
[[autopilot.filter]]
kind = "low-pass"
frequency_Hz = 9.0
damping = 0.7
on = "rate"
"""
CASES: dict[str, dict[str, Any]] = {
    "rigid": {"shape": "rectangular", "duration": 6.3, "limit": 0.61, "law": "trim"},
    "yaw, own gains": {
        **{"plane": "yaw", "model": "drift", "law": AUTOPILOT, "design": OWN, "delay": 27.0},
        **{"attitude_gain": 0.84, "rate_gain": 0.66, "alpha_gain": 0.1, "limit": 1.5},
    },
    "flexible, filtered": {"source": NOTCHED, "law": AUTOPILOT},
    "flexible, filtered, sampled": {"source": NOTCHED, "law": AUTOPILOT, "sample_rate": 60.0},
    "without its structure": {"source": NOTCHED, "structure": False, "law": AUTOPILOT},
    "without its filters": {"source": NOTCHED, "filters": False, "law": "trim"},
    "gust": {"gust_peak": 1.5, "gust_duration": 1.2, "dead_band": 0.6, "limit": 0.5},
    "gust against, a head wind": {"gust_peak": 1.0, "peak": -4.0, "sign": "head", "dead_band": 0.5},
    "both planes": {"plane": "both", "stop": "square", "heading": 130.0, "model": "fixed-path"},
    "across the flight, in both": {"plane": "both", "heading": 90.0, "model": "fixed-path"},
    "from a side": {"direction": "from a direction", "heading": 30.0, "model": "fixed-path"},
    "rate limited": {"rate_limit": 0.4, "limit": 0.5, "law": "recoverable-attitude"},
    "sampled, slow actuator": {
        "sample_rate": 20.0,
        "actuator": 8.0,
        "limit": 0.6,
        "law": AUTOPILOT,
    },
    "without an actuator": {"actuator": 0.0, "design": "lqr", "law": AUTOPILOT, "limit": 0.9},
    "dead band": {"law": "dead-band", "dead_band": 0.7, "limit": 0.7, "sign": "frozen"},
}


def document(*words: Any) -> dict[str, Any]:
    done = CliRunner().invoke(app, [str(word) for word in (*words, "--json")])
    assert done.exit_code in (0, 1), done.output
    return dict(json.loads(done.stdout))


@pytest.fixture(scope="module")
def written(request: pytest.FixtureRequest, tmp_path_factory: Any) -> tuple[Answer, Path]:
    """Return what the panel says, without its curve, and the file that it writes."""
    case, folder = dict(CASES[request.param]), tmp_path_factory.mktemp("written")
    source = case.pop("source", "configuration-i")
    if source is NOTCHED:
        (folder / "own.toml").write_text(NOTCHED)
        source = folder / "own.toml"
    choices = moved(source, **case)
    path = folder / "written.toml"
    named = None if choices.plan.vehicle.structure is None else "made-up-launcher"
    path.write_text(study_text(choices, named), encoding="utf-8")
    return answer(choices, 4), path


_SHORT = ("flexible, filtered, sampled", "both planes")
_PLACES = [list(CASES).index(name) for name in _SHORT]
every = pytest.mark.parametrize("written", usual(CASES, *_PLACES), indirect=True)


@every
def test_study_says_of_the_file_what_the_panel_says(written: tuple[Answer, Path]) -> None:
    here, path = written
    there = tv.load_study(path).study()

    assert here.required == pytest.approx(there.required_deflection, rel=1e-9)
    assert there.governs in here.verdict
    assert there.sufficient is here.verdict.startswith("SUFFICIENT")


@every
def test_margins_says_of_the_file_what_the_panel_says(written: tuple[Answer, Path]) -> None:
    here, path = written
    found = document("margins", path)
    there, judged = found["margins"], found["criteria"]
    assert here.margins is not None
    assert (judged["name"], judged["satisfied"]) == (
        here.margins.criteria.name,
        here.margins.satisfied,
    )
    assert there["phase_margin_deg"] == pytest.approx(here.margins.whole.phase_margin_deg, rel=1e-9)
    assert there["aero_margin_dB"] == pytest.approx(here.margins.whole.aero_margin_dB, rel=1e-9)
    assert there["delay_margin_s"] == pytest.approx(here.margins.whole.delay_margin, rel=1e-9)


def test_the_criteria_of_the_file_judge_and_are_written(tmp_path: Path) -> None:
    """What satisfies the classic set misses a delay margin of half a second."""
    own = "[study]\nvehicle = 'configuration-i'\n[wind]\npeak_deg = 5\nduration_s = 7.5\n"
    classic, stricter = "name = 'classic'", "name = 'aircraft'\ndelay_margin_ms = 500"
    for table, name, satisfied in (
        (classic, "classic", True),
        (stricter, "aircraft, with delay margin 500 ms", False),
    ):
        path, again = tmp_path / "own.toml", tmp_path / "written.toml"
        path.write_text(f"{own}[criteria]\n{table}\n[autopilot]\ndesign = 'lqr'\n")
        choices = moved(path)
        again.write_text(study_text(choices))
        here = answer(choices, 1).margins
        assert here is not None
        assert here.satisfied is satisfied
        for file in (path, again):
            there = document("margins", file)["criteria"]
            assert (there["name"], there["satisfied"]) == (name, here.satisfied)
        assert here.verdict.startswith(f"criteria {name}: ")


@pytest.mark.thorough
@every
def test_fly_says_of_the_file_what_the_panel_says(
    written: tuple[Answer, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    here, path = written
    law = here.choices.law
    band = ("--dead-band", here.choices.plan.dead_band) if law == "dead-band" else ()
    motion = here.motion
    assert motion is not None
    wind = tv.load_study(path).history
    shown = float(motion.time[-1] - motion.time[0]) / float(wind.end - wind.onset)
    monkeypatch.setattr("tvclin.cli.fly._DURATIONS_SHOWN", shown)
    monkeypatch.setattr("tvclin.cli.fly._POINTS", motion.time.size)
    there = document("fly", path, "--engine", "linear", "--law", law, *band)

    assert there["status"]["flown"] == here.outcome
    blowing = np.abs(motion.deflection[motion.time <= float(wind.end)])
    peaks = there["peaks_over_the_wind_deg"]["deflection"]
    assert float(np.degrees(blowing.max())) == pytest.approx(peaks["flown"], rel=1e-9)


def test_the_file_of_a_panel_opens_the_panel_again(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("own.toml").write_text(NOTCHED)
    for case in CASES.values():
        source = Path("own.toml") if case.get("source") else "configuration-i"
        choices = moved(source, **{name: one for name, one in case.items() if name != "source"})
        written = write_study(choices, "again", "made-up-launcher")
        again = moved(written, law=choices.law)
        assert study_text(again, "made-up-launcher") == written.read_text(encoding="utf-8")


@pytest.mark.parametrize("law", CONTROLS)
def test_a_study_names_the_law_that_was_flown(law: str) -> None:
    assert f"where the law {law} was flown" in study_text(moved(law=law))
    assert law in (*LAWS, CONTROLS[0])


def test_a_structure_without_a_file_is_refused_in_one_sentence() -> None:
    choices = moved("made-up-launcher", direction=IN_PLANE)
    with pytest.raises(tv.InputError, match="switch bending and slosh off"):
        study_text(choices)
    assert "[study.vehicle]" in study_text(moved("made-up-launcher", structure=False))
