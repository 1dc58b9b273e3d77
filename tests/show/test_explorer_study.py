"""The study file that the panel writes: its numbers are those of the panel."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tvclin.cli.app import app
from tvclin.control.laws.registry import AUTOPILOT
from tvclin.show.explorer.answer import answer
from tvclin.show.explorer.choices import CONTROLS, HALF_RELIEF, Choices
from tvclin.show.explorer.study import study_text, write_study

CHOSEN = Choices(
    vehicle=tv.load_vehicle("configuration-ii").replace(name='own "one"', pitch_damping=1e6),
    plane="yaw",
    model="drift",
    shape="rectangular",
    duration=6.3,
    peak=4.7 * (np.pi / 180.0),
    dead_band=0.85,
    limit=0.61 * (np.pi / 180.0),
    law=AUTOPILOT,
    attitude_gain=0.84,
    rate_gain=0.66,
    delay=0.027,
)


def test_the_study_of_a_panel_has_its_numbers(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    here, path = answer(CHOSEN, 0), write_study(CHOSEN, "own/one.toml")
    told = CliRunner().invoke(app, ["study", str(path), "--json"])
    there = json.loads(told.stdout)["verdict"]
    plan = tv.load_study(path)
    plant = tv.Plant.from_vehicle(plan.vehicle, plan.loop_model, plan.plane)
    margins = plan.autopilot.margins(plant)

    assert path == tmp_path / "study-one.toml"
    assert plan.vehicle == CHOSEN.vehicle
    assert here.required is not None
    assert here.margins is not None
    assert there["required_deflection_deg"] == pytest.approx(np.degrees(here.required), rel=1e-12)
    assert there["sufficient"] is here.verdict.startswith("Enough")
    assert margins.phase_margin == pytest.approx(here.margins.phase_margin, rel=1e-12)
    assert margins.delay_margin == pytest.approx(here.margins.delay_margin, rel=1e-12)


@pytest.mark.parametrize("law", CONTROLS)
def test_a_study_has_the_gains_of_the_law_if_it_has_some(law: str, tmp_path: Path) -> None:
    path = tmp_path / "one.toml"
    path.write_text(study_text(replace(CHOSEN, law=law)), encoding="utf-8")
    plan = tv.load_study(path)

    assert (plan.design is not None) is (law in (AUTOPILOT, HALF_RELIEF))
    assert (plan.wind.shape, plan.wind.peak) == (CHOSEN.shape, CHOSEN.peak)
    assert (plan.nozzle.limit, plan.dead_band, plan.plane) == (CHOSEN.limit, 0.85, "yaw")
