"""The panel to explore: its numbers are the library's, and what is moved is what changes."""

import ast
import io
import json
import subprocess
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
from tvclin.cli.app import app
from tvclin.kernels.choice import pinned
from tvclin.show.explorer import parts
from tvclin.show.explorer.answer import Answer, answer
from tvclin.show.explorer.choices import (
    GAINS,
    HALF_RELIEF,
    LAWS,
    RECOVERABLE,
    REPORT,
    TRIM,
    Choices,
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
    def sawtooth(peak: float, duration: float) -> tv.AsymmetricTriangularWind:
        return tv.AsymmetricTriangularWind(peak=peak, duration=duration, peak_time=duration)

    monkeypatch.setitem(PULSES, "sawtooth", sawtooth)
    booster = tv.load_vehicle("configuration-i")
    found = parts.boundary_point(booster, "pitch", "fixed-path", "sawtooth", 1.0, 7.5).value
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


def test_the_margins_are_those_of_the_library() -> None:
    c = asked(attitude_gain=0.8, rate_gain=0.7, delay=0.05)
    actuator = tv.Actuator(natural_frequency=25.1, damping=0.7)
    autopilot = tv.Autopilot(attitude_gain=0.8, rate_gain=0.7, actuator=actuator, delay=0.05)
    expected, found = autopilot.margins(plant_of(c)), answer(c).margins

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


@pytest.mark.parametrize("law", [law for law in LAWS if law != REPORT])
@pytest.mark.parametrize("limit", [0.0052, 0.0078])
def test_a_flight_and_its_outcome_are_those_of_the_kernels(law: str, limit: float) -> None:
    c = asked(law=law, limit=limit, model="fixed-path", attitude_gain=0.21, rate_gain=0.2)
    found = answer(c).motion
    assert found is not None
    numbers = (0.21, 0.2) if law == GAINS else (1.0,)
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
    found = parts.boundary_point(damped, "pitch", "fixed-path", shape, 0.5, 9.0).value
    kind = tv.TriangularWind if shape == "triangular" else tv.RectangularWind
    plant = tv.Plant.from_vehicle(damped, "fixed-path")
    needed = tv.boundary_limit(plant, kind(peak=0.1, duration=9.0), 0.5)
    assert found == pytest.approx(abs(needed.deflection) / 0.1, rel=1e-12)


def test_what_did_not_change_is_not_computed_again() -> None:
    c = asked(peak=0.031)
    answer(c)
    computed = [
        parts.boundary_curve,
        parts.boundary_point,
        parts.loop_margins,
        parts.motion,
    ]

    def grown(**changes: Any) -> list[int]:
        before = [one.cache_info().misses for one in computed]
        answer(replace(c, **changes))
        return [one.cache_info().misses - b for one, b in zip(computed, before, strict=True)]

    assert grown(duration=8.2501) == [0, 1, 0, 1]
    assert grown(attitude_gain=0.7501) == [0, 0, 1, 0]
    assert grown(dead_band=0.3501) == [1, 1, 0, 0]
    assert grown(peak=0.0301) == [0, 0, 0, 1]
    assert grown(law=GAINS, attitude_gain=0.7502) == [0, 0, 1, 1]


@pytest.mark.parametrize("arm", [-3.0, 0.0])
@pytest.mark.parametrize("law", LAWS)
def test_what_cannot_be_answered_says_why(arm: float, law: str) -> None:
    stable = tv.load_vehicle("configuration-i").replace(aerodynamic_arm=arm)
    found = answer(Choices(vehicle=stable, law=law))

    assert all(len(note.split()) > 3 for note in found.notes)
    if arm < 0.0:
        assert found.verdict.startswith("No deflection is needed")
        assert bool(found.notes) is (law in (TRIM, "dead band", HALF_RELIEF, RECOVERABLE))
    else:
        assert found.verdict.startswith("No answer")
        assert "mu_alpha other than zero" in found.notes[0]
        assert len(found.notes) == 1
    assert pixels(new_picture().png(found)).std() > 0.0


def pixels(png: bytes) -> Any:
    return imread(io.BytesIO(png))


def answers() -> list[Answer]:
    few = asked(limit=0.004, law=GAINS)
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


@pytest.fixture(scope="module")
def panel() -> Any:
    pytest.importorskip("ipywidgets")
    from tvclin.show.explorer.panel import Panel

    return Panel("configuration-i")


@pytest.mark.parametrize(
    ("field", "value", "si"),
    [
        ("vehicle", "configuration-ii", tv.load_vehicle("configuration-ii")),
        ("duration", 6.0, 6.0),
        ("peak", 6.0, 6.0 * (np.pi / 180.0)),
        ("dead_band", 0.5, 0.5),
        ("limit", 0.3, 0.3 * (np.pi / 180.0)),
        ("shape", "rectangular", "rectangular"),
        ("law", "dead band", "dead band"),
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
        "law": "dead band",
        "dead_band": 0.0,
    }.items():
        panel.controls[field].value = value
    assert "dead_band must be between 0.01 and 1" in panel.notes.value

    panel.controls["attitude_gain"].value = panel.controls["rate_gain"].value = 0.0
    assert "an autopilot needs a gain" in panel.notes.value
    assert ">Margins: none.<" in panel.margins.value

    panel.canonical.click()
    gains = tv.canonical_gains(tv.Coefficients.from_vehicle(panel.choices.vehicle))
    assert panel.choices.attitude_gain == gains.attitude_gain
    assert panel.choices.rate_gain == gains.rate_gain
    assert "phase" in panel.margins.value


def test_a_vehicle_of_one_s_own_is_explored(panel: Any) -> None:
    own = tv.load_vehicle("configuration-ii").replace(name="mine", control_arm=1.0)
    explored = type(panel)(own)

    assert explored.choices.vehicle is own
    assert explored.controls["vehicle"].options == ("mine", *tv.list_vehicles())
    assert explored.controls["limit"].max > 5.0 * panel.controls["limit"].max
    with pytest.raises(tv.InputError, match="one vehicle; got a batch of shape"):
        tv.explore(own.replace(thrust=np.array([3e7, 4e7])))


def test_a_vehicle_with_structure_is_said_to_be_rigid_here() -> None:
    pytest.importorskip("ipywidgets")
    from tvclin.show.explorer.panel import Panel

    panel, plant = Panel("made-up-booster"), tv.load_structure("made-up-booster")
    moved = tv.FlexiblePlant.from_vehicle(
        tv.load_vehicle("made-up-booster"), plant, "drift-exact"
    ).shift()
    assert "of the rigid vehicle, without the structure in its file" in panel.notes.value
    assert f"asks for by {moved.trim_price:+.2f} percent" in panel.notes.value
    panel.controls["vehicle"].value = "configuration-i"
    assert "structure" not in panel.notes.value


def test_a_missing_extra_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ipywidgets", None)

    with pytest.raises(tv.InputError, match=r"pip install \"tvclin\[notebook\]\""):
        tv.explore()


def test_a_vehicle_s_path_is_quoted_in_the_notebook() -> None:
    source = json.loads(notebook_text("it's \\ mine.toml"))["cells"][1]["source"]

    assert ast.literal_eval(source.partition("explore(")[2][:-1]) == "it's \\ mine.toml"


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[list[str]]:
    """Return the commands that would have been run."""
    for name in ("jupyterlab", "ipywidgets", "ipykernel"):
        if find_spec(name) is None:
            pytest.skip(f"{name}, of the extra notebook, is not installed")
    monkeypatch.chdir(tmp_path)
    commands: list[list[str]] = []

    def begun(command: list[str]) -> Any:
        commands.append(command)
        interrupts = [KeyboardInterrupt]

        def wait() -> int:
            if interrupts:
                raise interrupts.pop()
            return 0

        return SimpleNamespace(wait=wait)

    monkeypatch.setattr(subprocess, "Popen", begun)
    return commands


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
    lab = [sys.executable, "-m", "jupyterlab", str(path), "--no-browser", "--allow-root"]
    assert started == [lab, lab]


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
