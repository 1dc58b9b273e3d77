"""The required deflection of a random case is the same at every entry point, or refused by name.

Python, study file, shell, page, panel, campaign of one case, and the flight at one time, whose
vehicle is constant; for a sounding, the ascent through it and an archive of it alone. Vehicles are
those of the report with other numbers, some nearly neutral, stable, or so slow that their path is
quick.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.show.pages import Page
from tests.turns import seeds, usual
from tvclin.base.lines import text
from tvclin.boundary.open_loop import Reason
from tvclin.cli.app import app
from tvclin.ensembles.campaign.cases import NOT_KNOWN, evaluate
from tvclin.ensembles.campaign.outputs import required_name
from tvclin.requirement.case_requirement import CaseRequirement, case_requirement
from tvclin.show.explorer import answer as panel
from tvclin.show.explorer.choices import Choices
from tvclin.show.report.page import page_of
from tvclin.studyfile.findings import find
from tvclin.studyfile.verdict import sentence

KEYS = (
    *("weight_N", "moment_of_inertia_kg_m2", "normal_force_slope_N_per_rad", "thrust_N"),
    *("aerodynamic_arm_m", "control_arm_m", "axial_force_N", "velocity_m_per_s", "attitude_deg"),
)
VEHICLES = (
    (1.48e6, 2.25e7, 6.67e5, 2.495e6, 9.45, 23.56, 8.07e4, 538.81, 44.83),
    (1.4314629e7, 6.724251586e8, 5514677.6, 4.21881006e7, 39.71, 40.57, 1206493.8, 439.75, 36.8),
)
UNKNOWN = "not known"
_NO_LIMIT = "no limit is sufficient at this dead band"
_REFUSED_ALONG = ("varying parameters need a real unstable pole", _NO_LIMIT)
_SCAN = 2e-3
"""Relative distance of the limits that are flown where flights of the limited law decide."""
_AFTER_TRIM, _AFTER_TRIM_OF_VECTOR = 3e-4, 1e-3
"""Relative errors of the minimum after trim: of straight lines between steps, and of a vector."""


def drawn(seed: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return a random vehicle and the other tables of its study file."""
    rng = np.random.default_rng(seeds(seed))
    numbers = np.array(VEHICLES[rng.integers(2)]) * np.exp(rng.normal(0.0, 0.25, len(KEYS)))
    kind = rng.random()
    if kind < 0.25:  # nearly neutral, or stable
        numbers[4] *= 10.0 ** rng.uniform(-4.0, -1.0) if kind < 0.15 else -1.0
    elif kind < 0.35:
        numbers[7] *= 10.0 ** rng.uniform(-1.2, -0.3)
    numbers[8] = rng.uniform(3.0, 90.0) if rng.random() < 0.4 else min(numbers[8], 89.0)
    vehicle = dict(zip(KEYS, numbers.tolist(), strict=True))
    if rng.random() < 0.2:
        vehicle["pitch_damping_N_m_s_per_rad"] = float(numbers[1] * rng.uniform(0.01, 0.3))
    models = ("fixed-path", "drift", "drift-exact", "drift-exact", "drift-and-speed")
    study: dict[str, Any] = {
        "model": str(rng.choice(models)),
        "plane": str(rng.choice(["pitch", "pitch", "yaw"])),
        "dead_band": float(rng.choice([1.0, 1.0, 1.0, 0.0, 0.5, 0.75, round(rng.random(), 3)])),
    }
    shape = str(rng.choice(["triangular", "rectangular", "one-minus-cosine"]))
    wind: dict[str, Any] = {"shape": shape, "duration_s": float(10.0 ** rng.uniform(-0.3, 1.9))}
    name = "peak_speed_m_per_s" if rng.random() < 0.35 else "peak_deg"
    if name == "peak_deg":
        wind[name] = float(rng.choice([1, -1]) * 10.0 ** rng.uniform(-1.0, 1.3))
    else:
        wind[name] = float(numbers[7] * 10.0 ** rng.uniform(-2.0, 0.2))
    nozzle: dict[str, Any] = {"limit_deg": float(10.0 ** rng.uniform(-1.0, 0.9))}
    if rng.random() < 0.2:
        wind["direction_deg"] = float(
            rng.choice([0.0, 90.0, 180.0, 270.0, rng.uniform(0.0, 360.0)])
        )
        wind["azimuth_deg"] = float(rng.uniform(0.0, 360.0))
        if rng.random() < 0.6:
            shapes = ("round", "square", "square-45", "round-each-plane")
            nozzle["limit_shape"] = str(rng.choice(shapes))
    elif rng.random() < 0.4:
        signs = ("head", "tail", "frozen") if study["plane"] == "pitch" else ("frozen",)
        study["sign"] = str(rng.choice(signs))
    tables = {"study": study, "wind": wind, "nozzle": nozzle}
    if rng.random() < 0.15:
        lasts = float(rng.uniform(0.3, 1.0) * min(wind["duration_s"], 3.0))
        tables["gust"] = {"duration_s": lasts, name: wind[name] * float(rng.uniform(0.05, 0.5))}
        if rng.random() < 0.5:
            tables["gust"]["peak_time_s"] = float(rng.uniform(0.0, wind["duration_s"]))
    return vehicle, tables


def written(file: Path, tables: dict[str, dict[str, Any]]) -> Path:
    """Write a study file of tables and return its path."""
    lines = [
        f"[{name}]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in table.items())
        for name, table in tables.items()
    ]
    file.write_text("".join(lines))
    return file


def answered(answer: Callable[[], Any]) -> Any:
    """Return an answer, or the sentence that refuses it."""
    try:
        return answer()
    except tv.InputError as error:
        return str(error)


def requirement_of(plan: Any) -> CaseRequirement:
    """Return the requirement of a plan, as a study has it."""
    return case_requirement(plan, plan.dead_band)


def known(need: CaseRequirement) -> float | str:
    """Return the required deflection [rad] of a requirement, or that it is not known."""
    return UNKNOWN if need.beyond_linear or need.unknown else need.required_deflection


def of_campaign(plan: Any) -> float | str:
    """Return the required deflection [rad] of a campaign of one case without dispersions."""
    options = {name: getattr(plan, name) for name in ("vehicle", "wind", "model", "plane", "sign")}
    K = plan.dead_band
    campaign = tv.Campaign(
        **options, nozzle=plan.nozzle, dispersions=tv.Dispersions(()), cases=1, dead_bands=(K,)
    )
    columns = evaluate(campaign, 0, 1)
    status, required = str(columns["status"][0]), float(columns[required_name(K)][0])
    if status in NOT_KNOWN:
        assert required == np.inf
        return UNKNOWN
    if np.isnan(required):
        raise tv.InputError(status)
    return required


def of_flight(file: Path) -> float | str:
    """Return the required deflection [rad] at the time of a flight of a constant vehicle."""
    plan = tv.studyfile.load_sizing(file)
    request = plan.sizing
    sizing = request.sizing(plan)
    if request.total(plan, sizing).not_sized:
        return UNKNOWN
    return float(sizing.required[request.counted(sizing, plan.sign)][0, 0])


def of_panel(plan: Any) -> float | str:
    """Return the required deflection [rad] of the panel."""
    part = panel.requirement(Choices(plan=plan).requirement_inputs)
    if part.value is None:
        raise tv.InputError("; ".join(part.notes))
    return known(part.value)


def same(value: float | str, expected: float | str, tolerance: float = 1e-6) -> bool:
    """Return whether two required deflections are the same."""
    if isinstance(value, str) or isinstance(expected, str):
        return value == expected
    return value == pytest.approx(expected, rel=tolerance)


@pytest.mark.parametrize("seed", usual(range(40), 6))
def test_a_case_requires_the_same_at_every_entry_point(seed: int, tmp_path: Path) -> None:
    vehicle, tables = drawn(seed)
    given = tables["study"], {"study.vehicle": vehicle}
    file = written(tmp_path / "my.toml", {"study": given[0], **given[1]} | tables)
    plan = answered(lambda: tv.load_study(file))
    if isinstance(plan, str) or isinstance(need := answered(lambda: requirement_of(plan)), str):
        result = CliRunner().invoke(app, ["study", str(file)])
        assert result.exit_code == 2, result.output
        return
    expected = known(need)
    K, tolerance = plan.dead_band, 1e-6
    if 0.0 < K < 1.0 and plan.model not in ("fixed-path", "drift"):
        tolerance = _AFTER_TRIM if plan.nozzle.limit_shape is None else _AFTER_TRIM_OF_VECTOR
    elif need.requirement.governs == Reason.TRIM_LAW:
        tolerance = _SCAN
    answers = {"campaign": lambda: of_campaign(plan), "panel": lambda: of_panel(plan)}
    end = 4.0 * tables["wind"]["duration_s"] + 20.0
    flight = {
        "schedule": {"time_s": [0.0, end], **vehicle},
        "size": {"from_s": 0.5 * end, "to_s": 0.5 * end, "dead_bands": [K]},
    }
    for varying in (False, True):
        size = flight["size"] | {"varying": varying}
        flown = written(
            tmp_path / f"flight-{varying}.toml",
            {"study": given[0], **given[1]} | tables | flight | {"size": size},
        )
        answers[f"flight, varying {varying}"] = lambda flown=flown: of_flight(flown)
    for name, answer in answers.items():
        computed = answered(answer)
        if isinstance(computed, str) and any(words in computed for words in _REFUSED_ALONG):
            assert name.startswith("flight")
            continue
        assert same(computed, expected, tolerance), (name, computed, expected)
    in_shell = CliRunner().invoke(app, ["study", str(file), "--json"])
    document = json.loads(in_shell.stdout)
    question, verdict = document["questions"][0], document["verdict"]
    if expected == UNKNOWN:
        assert question["answer"] != "SUFFICIENT"
        assert in_shell.exit_code == 1
    else:
        required = verdict["required_deflection_deg"]
        of_shell = np.inf if required is None else float(np.radians(required))
        assert same(of_shell, expected, 1e-12)
        covered = bool(plan.nozzle.limit >= expected)
        assert question["answer"] == ("SUFFICIENT" if covered else "NOT SUFFICIENT")
        assert in_shell.exit_code == (not covered)
    if seed % 10 == 0:
        page, findings = Page(page_of(plan)[0]), find(plan)
        assert text(sentence(findings)).startswith(question["answer"])
        if expected != UNKNOWN and np.isfinite(expected):
            shown = np.radians(page.values["verdict.required_deg"])
            assert same(float(shown), expected, 1e-12)


def ascent_and_sounding(seed: int, folder: Path) -> tuple[tv.FlightSchedule, tv.WindProfile]:
    """Return the ascent of a random vehicle in one minute, and a rough sounding along it."""
    rng, vehicle = np.random.default_rng(seeds(seed, 1)), drawn(seed)[0]
    climb = vehicle["velocity_m_per_s"] * np.sin(np.radians(vehicle["attitude_deg"]))
    top = 2e3 + 60.0 * climb
    schedule = {"time_s": [0.0, 60.0], **vehicle, "altitude_m": [2e3, top]}
    file = written(folder / "ascent.toml", {"schedule": schedule})
    height = np.unique(np.append(np.arange(0.0, top, rng.choice([300.0, 700.0, 1500.0])), top))
    jet = np.exp(-(((height - 0.5 * top) / (rng.uniform(0.1, 0.4) * top)) ** 2))
    sizes = vehicle["velocity_m_per_s"] * rng.uniform([-0.12, -0.12, 0.0], [0.12, 0.12, 0.04])
    east, north = (
        size * jet + sizes[2] * np.clip(rng.normal(0.0, 1.0, height.size), -2.0, 2.0)
        for size in sizes[:2]
    )
    return tv.load_schedule(file), tv.WindProfile(height=height, east=east, north=north)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", usual([*range(40), 118, 190, 383], 12, 33, 40, 42))
def test_a_sounding_flies_with_what_the_ascent_through_it_requires(
    seed: int, tmp_path: Path
) -> None:
    flight, wind = ascent_and_sounding(seed, tmp_path)
    rng, study = np.random.default_rng(seeds(seed, 2)), drawn(seed)[1]["study"]
    plane, model, azimuth = study["plane"], study["model"], float(rng.uniform(0.0, 2.0 * np.pi))
    through = tv.fly_through(wind, flight, azimuth=azimuth, plane=plane)
    options = {"model": model, "plane": plane}
    sizing = answered(
        lambda: tv.size(flight, through, times=[30.0], dead_bands=1.0, varying=True, **options)
    )
    if isinstance(sizing, str):
        assert "real unstable pole" in sizing
        return
    required = float(sizing.required["K = 1, varying"][0, 0])
    soundings = tv.winds.Soundings.from_profiles([wind], ["2024-02-01"])
    for part, flies in ((0.99, 0.0), (1.02, 1.0)):
        limit = part * required if 0.0 < required < np.pi / 2 / part else 1.0
        result = tv.availability(flight, soundings, limit=limit, azimuth=azimuth, **options)
        assert result.flies[0] == (flies if required else 1.0), (required, result.required)
