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
from typing import Any

import numpy as np
import pytest
from matplotlib.image import imread
from typer.testing import CliRunner

import tvclin as tv
from tvclin.cli.app import app
from tvclin.control.laws.registry import AUTOPILOT
from tvclin.kernels.choice import pinned
from tvclin.show.explorer import parts
from tvclin.show.explorer.answer import Answer, answer
from tvclin.show.explorer.choices import (
    CONTROLS,
    HALF_RELIEF,
    REPORT,
    TRIM,
    Choices,
    idle,
)
from tvclin.show.explorer.notebook import notebook_text
from tvclin.show.explorer.parts import law_of
from tvclin.show.explorer.picture import new_picture, round_up
from tvclin.winds.shaped import PULSES


@pytest.fixture(autouse=True)
def numpy_alone() -> Iterator[None]:
    """Compare with the kernels that the panel takes."""
    with pinned(False):
        yield


def asked(**changes: Any) -> Choices:
    return Choices(vehicle=tv.load_vehicle("configuration-i"), **changes)


def plant_of(choices: Choices) -> tv.Plant:
    return tv.Plant.from_vehicle(choices.vehicle, choices.model, choices.plane)


def wind_of(choices: Choices) -> Any:
    return PULSES[choices.shape](peak=choices.peak, duration=choices.duration)


@pytest.mark.parametrize("shape", list(PULSES))
@pytest.mark.parametrize(
    ("model", "plane"), [("fixed-path", "yaw"), ("drift", "pitch"), ("drift-exact", "yaw")]
)
def test_the_boundary_is_that_of_the_library(shape: str, model: str, plane: str) -> None:
    c = asked(shape=shape, model=model, plane=plane, duration=11.0, peak=0.04, dead_band=0.6)
    found = answer(c)
    needed = tv.required_deflection(plant_of(c), wind_of(c), 0.6).deflection
    longer = replace(c, duration=float(found.durations[20]))

    assert found.required == pytest.approx(abs(needed), rel=1e-12)
    assert found.boundary is not None
    assert found.boundary[20] == pytest.approx(answer(longer).required, rel=1e-12)


def test_a_pulse_without_a_closed_form_is_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    def sawtooth(peak: float, duration: float) -> tv.winds.AsymmetricTriangularWind:
        return tv.winds.AsymmetricTriangularWind(peak=peak, duration=duration, peak_time=duration)

    monkeypatch.setitem(PULSES, "sawtooth", sawtooth)
    booster = tv.load_vehicle("configuration-i")
    found = parts.boundary(booster, "pitch", "fixed-path", "sawtooth", 1.0, (7.5,)).value
    c = tv.Coefficients.from_vehicle(booster)
    x = float(c.beta) * 7.5
    # Trim up to t0, then its limit y = t0/tau for ever: (4b) gives e^(-beta t0) = (1 + x) e^-x.
    assert found == pytest.approx(float(c.B) * (1.0 - np.log1p(x) / x), rel=1e-12)


@pytest.mark.parametrize("factor", [0.999, 1.001])
def test_the_verdict_changes_on_the_boundary(factor: float) -> None:
    c = asked(dead_band=0.5)
    needed = answer(c).required
    assert needed is not None
    judged = replace(c, limit=factor * needed)

    assert answer(judged).verdict.startswith("Enough:") is (factor > 1.0)
    assert tv.is_sufficient(plant_of(c), wind_of(c), judged.limit, 0.5) is (factor > 1.0)


@pytest.mark.parametrize("law", [AUTOPILOT, HALF_RELIEF])
def test_the_margins_are_those_of_the_library(law: str) -> None:
    c = asked(law=law, attitude_gain=0.8, rate_gain=0.7, delay=0.05)
    gains = tv.Autopilot(attitude_gain=0.8, rate_gain=0.7)
    if law == HALF_RELIEF:
        gains = tv.control.half_relief_gains(plant_of(c).coefficients)
    actuator = tv.Actuator(natural_frequency=25.1, damping=0.7)
    expected = replace(gains, actuator=actuator, delay=0.05).margins(plant_of(c))
    found = answer(c, 0).margins

    assert found is not None
    for name in ("aero_margin", "gain_increase", "phase_margin", "delay_margin", "disk_margin"):
        assert getattr(found, name) == getattr(expected, name)


def test_the_report_s_control_has_its_exact_response() -> None:
    c = asked(law=REPORT, limit=0.006, dead_band=0.7)
    found, wind = answer(c).motion, wind_of(c)
    assert found is not None
    held = tv.trim_then_hold(plant_of(c), wind, -0.006, 0.7)
    exact = tv.attitude_response(plant_of(c), held, wind, found.time)

    np.testing.assert_array_equal(found.attitude, exact.outputs["attitude"])
    np.testing.assert_array_equal(found.deflection, held(found.time))


@pytest.mark.parametrize("law", [law for law in CONTROLS if law != REPORT])
@pytest.mark.parametrize("limit", [0.0052, 0.0078])
def test_a_flight_and_its_outcome_are_those_of_the_kernels(law: str, limit: float) -> None:
    c = asked(law=law, limit=limit, model="fixed-path", attitude_gain=0.21, rate_gain=0.2)
    found = answer(c).motion
    assert found is not None
    numbers = (0.21, 0.2) if law == AUTOPILOT else (1.0,)
    case = plant_of(c), law_of(plant_of(c), law, numbers, c.peak), wind_of(c)
    sampled = {"deflection_limit": limit, "sample_rate": parts.SAMPLE_RATE}
    flown = tv.fly_many(*case, **sampled, until=float(found.time[-1]))
    outcome = tv.fly_many(*case, **sampled)

    assert np.abs(found.attitude).max() == pytest.approx(float(flown.peak_attitude), rel=1e-6)
    assert np.abs(found.deflection).max() <= limit * (1.0 + 1e-12)
    assert found.survived is (str(outcome.status) == "survived")


@pytest.mark.parametrize("shape", ["triangular", "rectangular"])
def test_the_curve_of_a_damped_vehicle_is_that_of_its_pole(shape: str) -> None:
    booster = tv.load_vehicle("configuration-i")
    damped = booster.replace(pitch_damping=0.3 * booster.moment_of_inertia)
    found = parts.boundary(damped, "pitch", "fixed-path", shape, 0.5, (9.0,)).value
    kind = tv.TriangularWind if shape == "triangular" else tv.RectangularWind
    plant = tv.Plant.from_vehicle(damped, "fixed-path")
    needed = tv.boundary_limit(plant, kind(peak=0.1, duration=9.0), 0.5)
    assert found == pytest.approx(abs(needed.deflection) / 0.1, rel=1e-12)


def test_what_did_not_change_is_not_computed_again() -> None:
    c = asked(peak=0.031, model="fixed-path")
    answer(c)
    computed = [parts.boundary, parts.loop_margins, parts.motion]

    def grown(**changes: Any) -> list[int]:
        before = [one.cache_info().misses for one in computed]
        answer(replace(c, **changes))
        return [one.cache_info().misses - b for one, b in zip(computed, before, strict=True)]

    assert grown(duration=8.2501) == [1, 0, 1]
    assert grown(attitude_gain=0.7501) == [0, 0, 0]
    assert grown(dead_band=0.3501) == [2, 0, 0]  # the point, and the curve
    assert grown(peak=0.0301) == [0, 0, 1]
    assert grown(law=AUTOPILOT, attitude_gain=0.7502) == [0, 1, 1]


def test_a_curve_in_pieces_is_the_whole_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "DURATIONS", parts.DURATIONS[::3])
    c = asked(dead_band=1.0)
    whole, some = answer(c), answer(c, 4)
    wind = tv.TriangularWind(peak=c.peak, duration=parts.DURATIONS)
    needed = np.abs(tv.required_deflection(plant_of(c), wind).deflection)

    assert (whole.whole, some.whole) == (True, False)
    np.testing.assert_allclose(whole.boundary, needed, rtol=1e-12)
    np.testing.assert_array_equal(some.boundary, whole.boundary[:4])
    np.testing.assert_array_equal(some.durations, parts.DURATIONS[:4])
    assert some.required == whole.required


MOVED = {"attitude_gain": 0.9, "rate_gain": 0.8, "delay": 0.09, "dead_band": 0.6, "limit": 0.006}


@pytest.mark.parametrize("law", CONTROLS)
def test_idle_are_the_sliders_that_change_nothing_with_the_law(law: str) -> None:
    def shown(c: Choices) -> list[Any]:
        one = answer(c)
        motion, margins = one.motion, one.margins
        assert motion is not None
        return [
            *(one.boundary, motion.attitude, motion.deflection, one.verdict, one.notes),
            *(() if margins is None else (margins.phase_margin, margins.gain_increase)),
        ]

    before = asked(law=law, model="fixed-path")
    for field, value in MOVED.items():
        pairs = zip(shown(before), shown(replace(before, **{field: value})), strict=True)
        same = all(np.array_equal(a, b) for a, b in pairs)
        assert same is (field in idle(law)), field


@pytest.mark.parametrize("arm", [-3.0, 0.0])
@pytest.mark.parametrize("law", CONTROLS)
def test_what_cannot_be_answered_says_why(arm: float, law: str) -> None:
    stable = tv.load_vehicle("configuration-i").replace(aerodynamic_arm=arm)
    found = answer(Choices(vehicle=stable, law=law, model="drift"))

    assert all(len(note.split()) > 3 for note in found.notes)
    if arm < 0.0:
        assert found.verdict.startswith("No deflection is needed")
        assert bool(found.notes) is (
            law in (TRIM, "dead-band", HALF_RELIEF, "recoverable-attitude")
        )
    else:
        assert found.verdict.startswith("No answer")
        assert "mu_alpha other than zero" in found.notes[0]
        assert len(found.notes) == 1
    assert pixels(new_picture().png(found)).std() > 0.0


def test_a_vehicle_without_moment_is_answered_with_its_path_too() -> None:
    still = tv.load_vehicle("configuration-i").replace(aerodynamic_arm=0.0)
    found = answer(Choices(vehicle=still, law=REPORT))

    assert found.verdict.startswith("No deflection is needed")
    assert "feels none: mu_alpha is 0" in found.notes[0]


def pixels(png: bytes) -> Any:
    return imread(io.BytesIO(png))


def answers() -> list[Answer]:
    few = asked(limit=0.004, law=AUTOPILOT)
    long = asked(duration=17.0)
    return [answer(c) for c in (asked(), asked(duration=9.0), few, replace(few, law=REPORT), long)]


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


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take three durations for the curve: enough to see that it moves."""
    monkeypatch.setattr(parts, "DURATIONS", parts.DURATIONS[:15:7])


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


@pytest.mark.parametrize(
    ("field", "value", "si"),
    [
        ("dead_band", 0.5, 0.5),  # first: with 1 the others would fly the trim law, in plain Python
        ("vehicle", "configuration-ii", tv.load_vehicle("configuration-ii")),
        ("duration", 6.0, 6.0),
        ("peak", 6.0, 6.0 * (np.pi / 180.0)),
        ("limit", 0.3, 0.3 * (np.pi / 180.0)),
        ("shape", "rectangular", "rectangular"),
        ("law", "autopilot", "autopilot"),
        ("attitude_gain", 0.9, 0.9),
        ("rate_gain", 0.9, 0.9),
        ("delay", 100.0, 0.1),
        ("model", "drift-and-speed", "drift-and-speed"),
        ("plane", "yaw", "yaw"),
    ],
)
def test_a_moved_widget_changes_what_is_asked_and_shown(
    panel: Any, field: str, value: Any, si: Any
) -> None:
    def shown() -> list[Any]:
        return [panel.image.value, panel.verdict.value, panel.margins.value]

    if field == "plane":  # gravity ties speed and path together in pitch alone
        panel.controls["model"].value = "drift-and-speed"
    before, asked_before = shown(), panel.choices
    panel.controls[field].value = value

    assert getattr(panel.choices, field) == si
    assert replace(panel.choices, **{field: getattr(asked_before, field)}) == asked_before
    assert shown() != before


def test_bad_combinations_are_one_sentence_in_the_panel(panel: Any) -> None:
    for field, value in {
        "plane": "pitch",
        "model": "drift",
        "law": "dead-band",
        "dead_band": 0.0,
    }.items():
        panel.controls[field].value = value
    assert "dead_band must be between 0.01 and 1" in panel.notes.value
    assert "Margins: none, with the law dead-band." in panel.margins.value

    panel.controls["law"].value = AUTOPILOT
    panel.controls["attitude_gain"].value = panel.controls["rate_gain"].value = 0.0
    assert "an autopilot needs a gain" in panel.notes.value
    assert "Margins: none" in panel.margins.value

    panel.canonical.click()
    gains = tv.control.canonical_gains(tv.Coefficients.from_vehicle(panel.choices.vehicle))
    assert panel.choices.attitude_gain == gains.attitude_gain
    assert panel.choices.rate_gain == gains.rate_gain
    assert "phase" in panel.margins.value


def test_what_is_idle_is_greyed_and_says_why(panel: Any) -> None:
    for law in CONTROLS:
        panel.controls["law"].value = law
        greyed = {field for field, one in panel.controls.items() if one.disabled}
        assert greyed == set(idle(law))
        assert panel.canonical.disabled is (law != AUTOPILOT)
    assert panel.controls["delay"].tooltip == ("counts only with the law autopilot or half-relief")
    panel.controls["law"].value = AUTOPILOT
    assert panel.controls["delay"].tooltip is None


def test_a_vehicle_of_one_s_own_is_explored(panel: Any) -> None:
    own = tv.load_vehicle("configuration-ii").replace(name="mine", control_arm=1.0)
    explored = opened(own)

    assert explored.choices.vehicle is own
    assert "this wind needs" in explored.verdict.value
    assert explored.controls["vehicle"].options == ("mine", *tv.list_vehicles())
    assert explored.controls["limit"].max > 5.0 * panel.controls["limit"].max
    with pytest.raises(tv.InputError, match="one vehicle; got a batch of shape"):
        tv.explore(own.replace(thrust=np.array([3e7, 4e7])))


def test_in_a_notebook_the_panel_is_there_before_its_curve(
    panel: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tvclin.show.explorer.panel._WAIT", 0.0)
    known = []

    async def filled() -> Any:
        one = type(panel)("configuration-i")
        draw, first = one._draw, one.image.value
        monkeypatch.setattr(
            one, "_draw", lambda found: (known.append(found.durations.size), draw(found))
        )
        assert "Enough" in one.verdict.value
        while known[-1:] != [3]:
            await asyncio.sleep(0.01)
        assert one.image.value != first

    asyncio.run(asyncio.wait_for(filled(), 600.0))
    assert known[:3] == [1, 2, 3]


def test_a_vehicle_with_structure_is_said_to_be_rigid_here(panel: Any) -> None:
    structured, plant = opened("made-up-booster"), tv.load_vehicle("made-up-booster").structure
    moved = tv.FlexiblePlant.from_vehicle(
        tv.load_vehicle("made-up-booster"), plant, "drift-exact"
    ).shift()
    assert "of the rigid vehicle, without the structure in its file" in structured.notes.value
    assert f"needs by {moved.trim_price:+.2f} percent" in structured.notes.value
    structured.controls["vehicle"].value = "configuration-i"
    assert "structure" not in structured.notes.value


def test_a_study_is_never_written_over(
    panel: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    panel.controls["vehicle"].value = "configuration-i"
    (tmp_path / "study-configuration-i.toml").write_text("mine")
    for name in ("study-configuration-i-2.toml", "study-configuration-i-3.toml"):
        panel.study.click()
        assert f"Wrote {tmp_path / name}, for: tvclin study {name}" in panel.said.value
        assert tv.load_study(name).vehicle == panel.choices.vehicle
    assert (tmp_path / "study-configuration-i.toml").read_text() == "mine"


def test_a_study_that_cannot_be_written_is_one_sentence(
    panel: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(path: Path, text: str) -> None:
        raise tv.InputError(f"{path} cannot be written: disk full")

    monkeypatch.setattr("tvclin.show.explorer.study.write_new", refused)
    panel.study.click()
    assert "cannot be written: disk full" in panel.said.value


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
    monkeypatch.setattr("jupyterlab.labapp.LabApp.launch_instance", given.append)
    return given


def test_the_command_writes_the_notebook_once_and_opens_it(started: list[list[str]]) -> None:
    path = Path("explore-configuration-ii.ipynb")
    for said in ("Wrote", "Opening"):
        told = CliRunner().invoke(
            app, ["explore", "--vehicle", "configuration-ii", "--no-browser", "--", "--allow-root"]
        )
        assert (told.exit_code, told.stdout.split()[0]) == (0, said)
        if said == "Wrote":
            assert path.read_text() == notebook_text("configuration-ii")
            path.write_text("changed by hand")

    assert path.read_text() == "changed by hand"
    for one in started:
        assert (one[0], one[-2:]) == (str(path), ["--no-browser", "--allow-root"])
        assert f"--LabApp.default_url=/lab/tree/{path}" in one
        (folder,) = (o.partition("=")[2] for o in one if "extra_labextensions_path" in o)
        assert list(Path(folder).glob("*/package.json"))


def test_a_server_that_opened_its_page_ends_some_time_after_it(started: list[list[str]]) -> None:
    def timeouts(*options: str) -> list[str]:
        assert CliRunner().invoke(app, ["explore", *options]).exit_code == 0
        return [option for option in started[-1] if "timeout" in option]

    idle_kernel, no_kernel = timeouts()
    assert timeouts("--no-browser") == []
    own = "--ServerApp.shutdown_no_activity_timeout=900"
    assert timeouts("--", own) == [idle_kernel, own]
    assert no_kernel.startswith("--ServerApp.shutdown_no_activity_timeout=")


def test_a_jupyterlab_that_cannot_start_is_one_sentence(
    started: list[list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("jupyterlab.labapp.LabApp.launch_instance", lambda _: sys.exit(1))
    told = CliRunner().invoke(app, ["explore"])
    assert told.exit_code == 2
    assert "JupyterLab ended with exit code 1, see above" in told.stderr


def test_the_command_refuses_in_one_sentence(
    started: list[list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    unknown = CliRunner().invoke(app, ["explore", "--vehicle", "configuration-iii"])
    bare = CliRunner().invoke(app, ["explore", "configuration-ii"])
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    missing = CliRunner().invoke(app, ["explore"])

    assert (unknown.exit_code, bare.exit_code, missing.exit_code) == (2, 2, 2)
    assert "name the vehicle with --vehicle configuration-ii" in bare.stderr
    assert "did you mean" in unknown.stderr
    assert "tvclin explore needs jupyterlab, which is not installed" in missing.stderr
    assert 'pip install "tvclin[notebook]"' in missing.stderr
    assert started == []
    assert list(Path.cwd().iterdir()) == []
