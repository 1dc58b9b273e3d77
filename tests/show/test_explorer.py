"""The panel to explore: its numbers are the library's, and what is moved is what changes."""

import ast
import asyncio
import io
import json
import os
import signal
import sys
from collections.abc import Iterator
from dataclasses import replace
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.image import imread
from typer.testing import CliRunner

import tvclin as tv
from tests.show.explored import moved, values
from tests.turns import usual
from tvclin.case.features import COMPUTED, NOTED, OPTIONS, use_of
from tvclin.cli.app import app
from tvclin.control.laws.registry import AUTOPILOT
from tvclin.kernels.choice import pinned
from tvclin.show.explorer import answer as parts
from tvclin.show.explorer.answer import Answer, answer
from tvclin.show.explorer.choices import (
    CONTROLS,
    OWN,
    REPORT,
    Choices,
    choices_of,
    idle_controls,
    round_up,
)
from tvclin.show.explorer.lab import notebook_text
from tvclin.show.explorer.panel import new_picture
from tvclin.vehicle.coefficients import BOTH


@pytest.fixture(autouse=True)
def numpy_alone() -> Iterator[None]:
    """Compare with the kernels that the panel takes."""
    with pinned(False):
        yield


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take three durations for the curve: enough to see that it moves."""
    monkeypatch.setattr(parts, "DURATIONS", parts.DURATIONS[:15:7])


@pytest.mark.parametrize("factor", [0.999, 1.001])
def test_the_verdict_changes_at_what_a_study_requires(factor: float) -> None:
    c = moved(dead_band=0.5)
    needed = tv.Study.of(c.plan, 0.5).required_deflection
    judged = moved(dead_band=0.5, limit=np.degrees(factor * needed))

    assert answer(judged, 4).verdict.startswith("SUFFICIENT:") is (factor > 1.0)


def test_the_curve_is_what_longer_winds_require(few: None) -> None:
    c = moved(shape="rectangular", model="fixed-path", dead_band=0.6)
    result = answer(c)
    wind = replace(c.wind, duration=float(result.durations[1]))
    longer = tv.Study.of(replace(c.plan, wind=wind), 0.6)

    assert result.boundary is not None
    assert result.boundary[1] == pytest.approx(longer.required_deflection, rel=1e-12)


def test_the_report_s_control_has_its_exact_response() -> None:
    c = moved(law=REPORT, limit=0.35, dead_band=0.7)
    result, wind, plant = answer(c, 2).motion, c.plan.history, c.plan.plant
    assert result is not None
    constant = tv.trim_then_hold(plant, wind, -c.limit, 0.7)
    exact = tv.attitude_response(plant, constant, wind, result.time)

    np.testing.assert_array_equal(result.attitude, exact.outputs["attitude"])
    np.testing.assert_array_equal(result.deflection, constant(result.time))


@pytest.mark.thorough
def test_what_did_not_change_is_not_computed_again(few: None) -> None:
    start = {"peak": 1.776, "model": "fixed-path", "dead_band": 0.5, "design": OWN}
    answer(moved(**start))
    computed = [parts.requirement, parts.loop_margins, parts.motion, parts.outcome]

    def grown(**changes: Any) -> list[int]:
        before = [len(one.cache) for one in computed]
        answer(moved(**start | changes))
        return [len(one.cache) - b for one, b in zip(computed, before, strict=True)]

    assert grown(duration=8.2501) == [1, 0, 1, 1]
    assert grown(limit=0.3501) == [0, 0, 1, 1]
    assert grown(attitude_gain=0.7501) == [0, 1, 0, 0]
    assert grown(dead_band=0.3501) == [4, 0, 0, 0]  # the point, and the curve
    assert grown(sign="frozen") == [4, 0, 0, 0]
    assert grown(delay=31.0) == [0, 1, 1, 1]
    assert grown(law=AUTOPILOT, attitude_gain=0.7502) == [0, 1, 1, 1]


def test_an_answer_in_steps_is_the_whole_one(few: None) -> None:
    c = moved(model="fixed-path", dead_band=0.5)
    whole, some, none = answer(c), answer(c, 5), answer(c, 0)

    assert (len(whole.remaining), len(some.remaining), len(none.remaining)) == (0, 2, 7)
    assert some.required == whole.required
    np.testing.assert_array_equal(some.boundary, whole.boundary[:1])
    assert none.verdict == "What the ideal trim law requires is computed ..."
    assert pixels(new_picture().png(none)).std() > 0.0


def test_what_takes_long_is_not_waited_for() -> None:
    assert not any(answer(moved(), 0).remaining)
    assert answer(moved(gust_peak=1.0), 0).remaining[:4] == (False, True, True, True)
    assert answer(moved(plane=BOTH), 0).remaining[:4] == (False, False, False, True)


FIELDS = {
    **{"stop": "square", "direction": "from a direction", "heading": 140.0, "gust_duration": 2.0},
    **{"rate_limit": 0.3, "attitude_gain": 0.31, "rate_gain": 0.4, "alpha_gain": 0.05},
    **{"sign": "head", "structure": False, "filters": False, "actuator": 9.0, "delay": 55.0},
    **{"sample_rate": 33.0, "limit": 0.3, "dead_band": 0.7, "peak": 4.0, "duration": 6.0},
}


@pytest.mark.parametrize(
    "others",
    [{}, {"law": REPORT}, {"plane": "yaw"}, {"plane": BOTH}, {"design": OWN}, {"gust_peak": 1.0}],
)
def test_idle_is_what_changes_nothing(others: dict[str, Any]) -> None:
    plan = tv.load_study("configuration-i")
    start = values(plan) | others

    def asks(v: dict[str, Any]) -> Any:
        c = choices_of(plan, plan.vehicle, v)
        flown = c.motion_inputs if c.law != REPORT else replace(c.motion_inputs, nozzle=tv.Nozzle())
        return c.margin_inputs, c.requirement_inputs, flown, c.limit

    resting = idle_controls(plan, plan.vehicle, start)
    for field, value in FIELDS.items():
        assert (asks(start) == asks(start | {field: value})) is (field in resting), field


MOVED: dict[str, dict[str, Any]] = {
    "gust": {"gust_peak": 1.0},
    "head wind": {"peak": -5.0},
    "sign that counts": {"sign": "frozen"},
    "heading": {"direction": "from a direction"},
    "limit shape": {"plane": BOTH, "stop": "square"},
    "actuator": {"actuator": 9.0},
    "rate limit": {"rate_limit": 0.3},
    "delay": {"delay": 40.0},
    "sample rate": {"sample_rate": 30.0},
    "gains": {"design": "lqr"},
    "limit": {"limit": 0.3},
}


def test_each_part_that_the_table_calls_computed_is_asked() -> None:
    def asks(c: Choices) -> Any:
        return c.margin_inputs, c.requirement_inputs, c.motion_inputs

    assert all(asks(moved(**value)) != asks(moved()) for value in MOVED.values())
    bent = moved("made-up-launcher"), moved("made-up-launcher", structure=False)
    assert bent[0].requirement_inputs == bent[1].requirement_inputs
    assert bent[0].margin_inputs != bent[1].margin_inputs
    assert bent[0].motion_inputs != bent[1].motion_inputs
    by_file = {"structure", "damping", "filters"}
    computed = {part for part in OPTIONS if use_of("explore", part) == COMPUTED}
    assert computed | {"structure"} == MOVED.keys() | by_file
    assert use_of("explore", "structure") == NOTED


@pytest.mark.parametrize("arm", usual([-3.0, 0.0], 0))
@pytest.mark.parametrize("law", usual(CONTROLS, 0, 1))
def test_what_cannot_be_answered_says_why(few: None, arm: float, law: str) -> None:
    stable = tv.load_vehicle("configuration-i").replace(aerodynamic_arm=arm)
    plan = tv.studyfile.StudyPlan(vehicle=stable, model="drift")
    result = answer(choices_of(plan, stable, values(plan) | {"law": law}))

    assert all(len(note.split()) > 3 for note in result.notes)
    if arm < 0.0:
        assert result.verdict.startswith("No deflection is needed")
        assert any("canonical gains need" in note for note in result.notes)
    else:
        assert result.verdict.startswith("No answer")
        assert any("mu_alpha other than zero" in note for note in result.notes)
    assert pixels(new_picture().png(result)).std() > 0.0


def pixels(png: bytes) -> Any:
    return imread(io.BytesIO(png))


def answers() -> list[Answer]:
    every = ({}, {"duration": 9.0}, {"limit": 0.23, "law": AUTOPILOT}, {"law": REPORT})
    return [answer(moved(**one), 5) for one in (*every, {"duration": 17.0})]


@pytest.mark.thorough
def test_a_picture_that_is_moved_is_the_picture_drawn_anew() -> None:
    moved = new_picture()
    seen = []
    for one in answers():
        seen.append(pixels(moved.png(one)))
        np.testing.assert_array_equal(seen[-1], pixels(new_picture().png(one)))

    assert all(np.any(a != b) for a, b in pairwise(seen))


def test_round_numbers_hold_what_they_are_made_for() -> None:
    for size in np.geomspace(1e-4, 80.0, 97):
        assert size <= round_up(size) <= 1.67 * size
    assert [round_up(x) for x in (1.0, 1.2, 0.021, 7.5)] == [1.0, 1.5, 0.03, 10.0]


def opened(vehicle: str | tv.Vehicle) -> Any:
    """Open a panel as a notebook does, whose curve is not waited for."""
    pytest.importorskip("ipywidgets")
    from tvclin.show.explorer.panel import Panel

    async def at_once() -> Any:
        return Panel(vehicle)

    return asyncio.run(at_once())


@pytest.fixture(scope="module")
def the_panel() -> Any:
    return opened("configuration-i")


@pytest.fixture
def panel(few: None, the_panel: Any) -> Any:
    return the_panel


@pytest.mark.thorough
def test_a_moved_widget_changes_what_is_asked_and_shown(panel: Any) -> None:
    def shown() -> list[Any]:
        return [panel.image.value, panel.verdict.value, panel.margins.value]

    changes = {"dead_band": 0.5, "vehicle": "configuration-ii", "duration": 6.0, "peak": 6.0}
    changes |= {"limit": 0.3, "shape": "rectangular", "law": "autopilot", "design": OWN}
    changes |= {"attitude_gain": 0.9, "rate_gain": 0.9, "alpha_gain": 0.1, "delay": 100.0}
    changes |= {"sample_rate": 40.0, "actuator": 12.0, "rate_limit": 0.2, "model": "drift"}
    for field, value in (changes | {"plane": "yaw"}).items():
        before, asked_before = shown(), panel.choices
        panel.controls[field].value = value
        assert panel.choices != asked_before or field == "design", field
        assert shown() != before or field == "design", field


@pytest.mark.thorough
def test_bad_combinations_are_one_sentence_in_the_panel(panel: Any) -> None:
    for field, value in {"model": "drift", "law": "dead-band", "dead_band": 0.0}.items():
        panel.controls[field].value = value
    assert "dead_band must be between 0.01 and 1" in panel.notes.value

    panel.controls["law"].value = AUTOPILOT
    panel.controls["design"].value = OWN
    for field in ("attitude_gain", "rate_gain", "alpha_gain"):
        panel.controls[field].value = 0.0
    assert "an autopilot needs a gain" in panel.notes.value
    assert "Margins: none" in panel.margins.value

    panel.controls["design"].value = "canonical"
    gains = tv.control.canonical_gains(tv.Coefficients.from_vehicle(panel.vehicle, "yaw"))
    assert panel.controls["attitude_gain"].value == gains.attitude_gain
    assert panel.controls["rate_gain"].value == gains.rate_gain
    assert "phase" in panel.margins.value

    peak, panel.controls["peak"].value = panel.controls["peak"].value, 0.0
    assert "No answer" in panel.verdict.value
    panel.controls["peak"].value = peak


@pytest.mark.thorough
def test_what_is_idle_is_greyed_and_says_why(panel: Any) -> None:
    panel.controls["design"].value = "canonical"
    assert panel.controls["alpha_gain"].disabled
    assert "the rule canonical sets it" in panel.controls["alpha_gain"].tooltip
    panel.controls["design"].value = OWN
    assert not panel.controls["alpha_gain"].disabled
    assert panel.controls["alpha_gain"].tooltip is None


@pytest.mark.thorough
def test_a_vehicle_of_one_s_own_is_explored(panel: Any) -> None:
    own = tv.load_vehicle("configuration-ii").replace(name="mine", control_arm=1.0)
    explored = opened(own)

    assert explored.choices.plan.vehicle == own
    assert "the ideal trim law requires" in explored.verdict.value
    assert explored.controls["vehicle"].options == ("mine", *tv.list_vehicles())
    assert explored.controls["limit"].max > 5.0 * panel.controls["limit"].max
    with pytest.raises(tv.InputError, match="one vehicle; got a batch of shape"):
        tv.explore(own.replace(thrust=np.array([3e7, 4e7])))


@pytest.mark.thorough
def test_in_a_notebook_the_panel_is_there_before_its_curve(
    panel: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tvclin.show.explorer.panel._WAIT", 0.0)
    known = []

    async def filled() -> Any:
        one = type(panel)("configuration-i")
        draw, first = one._draw, one.image.value
        monkeypatch.setattr(
            one, "_draw", lambda result: (known.append(result.durations.size), draw(result))
        )
        while known[-1:] != [3]:
            await asyncio.sleep(0.01)
        assert one.image.value != first

    asyncio.run(asyncio.wait_for(filled(), 600.0))
    assert known == sorted(known)


@pytest.mark.thorough
def test_a_vehicle_with_structure_says_what_is_rigid_here(panel: Any) -> None:
    structured, plant = opened("made-up-booster"), tv.load_vehicle("made-up-booster").structure
    bends = tv.FlexiblePlant.from_vehicle(
        tv.load_vehicle("made-up-booster"), plant, "drift-exact"
    ).shift()
    assert "Boundaries and the open-loop response are of the rigid" in structured.notes.value
    assert f"required deflection by {bends.trim_price:+.2f} percent" in structured.notes.value
    structured.controls["structure"].value = False
    assert "structure" not in structured.notes.value


def test_a_study_file_begins_with_its_case_and_tells_what_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(
        '[study]\nvehicle = "configuration-ii"\nplane = "yaw"\n[wind]\npeak_deg = 3.0\n'
        "duration_s = 4.0\n[nozzle]\nlimit_deg = 0.7\nrate_limit_deg_per_s = 2.0\n[autopilot]\n"
        'delay_ms = 30\n[[dispersion]]\nparameter = "thrust"\nshape = "uniform"\npercent = 5\n'
    )
    result, plan = moved(path), tv.load_study(path)
    assert result.law == AUTOPILOT
    assert repr(result.plan.nozzle) == repr(plan.nozzle)
    assert (result.plan.wind, result.plan.plane) == (plan.wind, "yaw")
    assert result.plan.autopilot_design.delay == pytest.approx(0.03, rel=1e-15)
    (left,) = [note for note in answer(result, 0).notes if note.startswith("Not counted")]
    assert "dispersion" in left


def test_a_study_is_never_written_over(
    panel: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    panel.controls["vehicle"].value = "configuration-i"
    (tmp_path / "study-configuration-i.toml").write_text("mine")
    for name in ("study-configuration-i-2.toml", "study-configuration-i-3.toml"):
        panel.study.click()
        assert f"Wrote {tmp_path / name}, for: tvclin study {name}" in panel.said.value
        assert tv.load_study(name).vehicle == panel.vehicle
    assert (tmp_path / "study-configuration-i.toml").read_text() == "mine"


@pytest.mark.thorough
def test_a_vehicle_that_bends_or_is_known_by_coefficients_is_named_by_its_file(
    few: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("c.toml").write_text("[coefficients]\nmu_alpha_per_s2 = 0.2\nmu_delta_per_s2 = 1.3\n")
    Path("own.toml").write_text(
        '[study]\nvehicle = "made-up-launcher"\n[wind]\npeak_deg = 3.0\nduration_s = 4.0\n'
    )
    for source, named in (("c.toml", "c.toml"), ("own.toml", "made-up-launcher")):
        one = opened(source)
        one.study.click()
        written = Path(f"study-{source}")
        assert f'vehicle = "{named}"' in written.read_text()
        assert tv.load_study(written).vehicle == one.vehicle


def test_a_study_that_cannot_be_written_is_one_sentence(
    panel: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(path: Path, text: str) -> None:
        raise tv.InputError(f"{path} cannot be written: disk full")

    monkeypatch.setattr("tvclin.show.explorer.choices.write_new", refused)
    panel.study.click()
    assert "cannot be written: disk full" in panel.said.value


@pytest.mark.thorough
def test_a_panel_ends_only_the_jupyterlab_that_was_started_for_it(
    panel: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    ended: list[Any] = []
    monkeypatch.setattr(os, "kill", lambda *what: ended.append(what))

    def buttons(one: Any) -> list[str]:
        return [button.description for button in one.box.children[0].children[-1].children]

    assert "End" not in buttons(type(panel)("configuration-i"))
    monkeypatch.setenv("TVCLIN_EXPLORE", "12345")
    started = type(panel)("configuration-i")
    assert "End" in buttons(started)
    started.end.click()
    assert ended == [(12345, signal.SIGTERM)]


def test_a_missing_extra_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ipywidgets", None)

    with pytest.raises(tv.InputError, match=r"pip install \"tvclin\[notebook\]\""):
        tv.explore()


def test_a_vehicle_s_path_is_quoted_in_the_notebook() -> None:
    source = json.loads(notebook_text("it's \\ mine.toml"))["cells"][1]["source"]

    assert ast.literal_eval(source.partition("explore(")[2][:-1]) == "it's \\ mine.toml"


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[list[str]]:
    """Return the options with which JupyterLab would have been started."""
    for name in ("jupyterlab", "ipywidgets", "ipykernel"):
        if find_spec(name) is None:
            pytest.skip(f"{name}, of the extra notebook, is not installed")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TVCLIN_EXPLORE", "")  # to be put back
    given: list[list[str]] = []
    lab = SimpleNamespace(LabApp=SimpleNamespace(launch_instance=given.append))
    monkeypatch.setitem(sys.modules, "jupyterlab.labapp", lab)  # which takes seconds to import
    return given


@pytest.mark.thorough
def test_the_command_writes_the_notebook_once_and_opens_it(started: list[list[str]]) -> None:
    path = Path("explore-configuration-ii.ipynb")
    for said in ("Wrote", "Opening"):
        done = CliRunner().invoke(
            app, ["explore", "configuration-ii", "--no-browser", "--", "--allow-root"]
        )
        assert (done.exit_code, done.stdout.split()[0]) == (0, said)
        if said == "Wrote":
            assert path.read_text() == notebook_text("configuration-ii")
            path.write_text("changed by hand")

    assert path.read_text() == "changed by hand"
    for one in started:
        assert (one[0], one[-2:]) == (str(path), ["--no-browser", "--allow-root"])
        assert f"--LabApp.default_url=/lab/tree/{path}" in one
        (folder,) = (o.partition("=")[2] for o in one if "extra_labextensions_path" in o)
        assert list(Path(folder).glob("*/package.json"))


@pytest.mark.thorough
def test_a_server_that_opened_its_page_ends_some_time_after_it(started: list[list[str]]) -> None:
    def timeouts(*options: str) -> list[str]:
        assert CliRunner().invoke(app, ["explore", *options]).exit_code == 0
        return [option for option in started[-1] if "timeout" in option]

    idle_kernel, no_kernel = timeouts()
    assert timeouts("--no-browser") == []
    own = "--ServerApp.shutdown_no_activity_timeout=900"
    assert timeouts("--", own) == [idle_kernel, own]
    assert no_kernel.startswith("--ServerApp.shutdown_no_activity_timeout=")


@pytest.mark.thorough
def test_a_jupyterlab_that_cannot_start_is_one_sentence(
    started: list[list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    lab = sys.modules["jupyterlab.labapp"].LabApp
    monkeypatch.setattr(lab, "launch_instance", lambda _: sys.exit(1))
    done = CliRunner().invoke(app, ["explore"])
    assert done.exit_code == 2
    assert "JupyterLab ended with exit code 1, see above" in done.stderr


def test_the_command_refuses_in_one_sentence(
    started: list[list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    unknown = CliRunner().invoke(app, ["explore", "--vehicle", "configuration-iii"])
    twice = ["explore", "configuration-ii", "--vehicle", "configuration-i"]
    bare = CliRunner().invoke(app, twice)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    missing = CliRunner().invoke(app, ["explore"])

    assert (unknown.exit_code, bare.exit_code, missing.exit_code) == (2, 2, 2)
    assert "give SOURCE or --vehicle, not both" in bare.stderr
    assert "did you mean" in unknown.stderr
    assert "tvclin explore needs jupyterlab, which is not installed" in missing.stderr
    assert 'pip install "tvclin[notebook]"' in missing.stderr
    assert started == []
    assert list(Path.cwd().iterdir()) == []
