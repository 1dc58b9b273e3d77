"""Random cases: shell, study file, page, panel, Python, one flight time and one dispersed case."""

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
from tvclin.ensembles.campaign.cases import nominal
from tvclin.show.explorer.answer import answer
from tvclin.studyfile.findings import find
from tvclin.vehicle.vehicle_file import vehicle_file, vehicle_table

VEHICLES = ("configuration-i", "configuration-ii", "made-up-booster")
MODELS = ("fixed-path", "drift", "drift-exact", "drift-and-speed")
SHAPES = ("triangular", "rectangular", "one-minus-cosine")
SPREADS = {"weight": 0.05, "thrust": 0.05, "moment_of_inertia": 0.1, "normal_force_slope": 0.1}


def random_case(rng: np.random.Generator) -> dict[str, Any]:
    """Return the vehicle of a random case and its tables of a study file."""
    vehicle = tv.load_vehicle(str(rng.choice(VEHICLES))).rigid
    vehicle = vehicle.replace(
        **{k: getattr(vehicle, k) * np.exp(rng.normal(0.0, s)) for k, s in SPREADS.items()}
    )
    plane = str(rng.choice(["pitch", "pitch", "yaw"]))
    signs = [None, "head", "tail", "frozen"] if plane == "pitch" else [None, "frozen"]
    wind = {"shape": str(rng.choice(SHAPES)), "duration_s": float(np.exp(rng.uniform(0.4, 3.4)))}
    by_speed, gust, slanting = rng.random(3) < [0.3, 0.3, 0.2]
    if by_speed:
        wind["peak_speed_m_per_s"] = float(rng.uniform(5.0, 60.0))
    else:
        wind["peak_deg"] = float(rng.uniform(0.5, 9.0))
    tables: dict[str, Any] = {"wind": wind}
    if gust:
        tables["gust"] = {"peak_deg": rng.uniform(0.3, 2.0), "duration_s": rng.uniform(1.0, 4.0)}
    if slanting:
        wind |= {"direction_deg": float(rng.uniform(0.0, 360.0)), "azimuth_deg": 90.0}
        signs = [None, "frozen"]
        stop = [None, "round", "square"][rng.integers(3)]
        tables |= {"nozzle": {"limit_shape": stop}} if stop else {}
    tables["study"] = {
        "model": str(rng.choice(MODELS)),
        "plane": plane,
        "dead_band": float(rng.choice([1.0, 1.0, 0.75, 0.5, 0.25, 0.0])),
    }
    sign = signs[rng.integers(len(signs))]
    tables["study"] |= {"sign": sign} if sign else {}
    return {"vehicle": vehicle, "tables": tables}


def options(tables: dict[str, Any], by_keys: tuple[str, ...] = ()) -> list[str]:
    """Return the options of a command that say what the tables of a study file do.

    `by_keys`: what the command has no option of, so that it is set by its key.
    """
    names = {
        ("wind", "shape"): "--wind",
        ("wind", "duration_s"): "--duration",
        ("wind", "peak_deg"): "--peak-deg",
        ("wind", "peak_speed_m_per_s"): "--peak-speed",
        ("wind", "azimuth_deg"): "--azimuth-deg",
        ("nozzle", "limit_shape"): "--limit-shape",
        **{("study", key): "--" + key.replace("_", "-") for key in tables["study"]},
    }
    rows = [
        ["--set", f"{table}.{key}={tables[table][key]}"]
        if key in by_keys
        else [name, str(tables[table][key])]
        for (table, key), name in names.items()
        if key in tables.get(table, {})
    ]
    if "direction_deg" in tables.get("wind", {}):
        rows.append(["--set", f"wind.direction_deg={tables['wind']['direction_deg']}"])
    if "gust" in tables and "gust" in by_keys:
        rows += [["--set", f"gust.{key}={value}"] for key, value in tables["gust"].items()]
    elif "gust" in tables:
        rows.append(["--gust", *(str(float(value)) for value in tables["gust"].values())])
    return [word for row in rows for word in row]


def write_files(folder: Path, vehicle: tv.Vehicle, tables: dict[str, Any]) -> None:
    """Write the vehicle, its study, and a flight with equal parameters at all times."""
    (folder / "vehicle.toml").write_text(vehicle_file(vehicle))
    named = tables | {"study": {"vehicle": "vehicle.toml"} | tables["study"]}
    lines = [
        f"[{name}]\n" + "".join(f"{k} = {json.dumps(v)}\n" for k, v in table.items())
        for name, table in named.items()
    ]
    (folder / "study.toml").write_text("\n".join(lines))
    row = {k: v for k, v in vehicle_table(vehicle).items() if not isinstance(v, str)}
    heads = ",".join(row)
    flight = [",".join(str(v) for v in (row | {"time_s": t}).values()) for t in (0, 50, 100, 200)]
    (folder / "flight.csv").write_text("\n".join([heads, *flight]) + "\n")


def required_along_flight(document: dict[str, Any], dead_band: float) -> float:
    """Return the required deflection [deg] of one flight time: the worst direction of the wind."""
    rows, label = document["required_deg"], f"K = {dead_band:g}"
    directions = [key for key in rows if key.startswith(label) and key.endswith(" wind")]
    return max(rows[key][0][0] for key in directions or [f"{label}, varying"])


@pytest.mark.parametrize("seed", usual(range(40), 0))
def test_every_entry_point_says_the_same(seed: int, tmp_path: Path) -> None:
    case = random_case(np.random.default_rng(seed))
    vehicle, tables = case["vehicle"], case["tables"]
    write_files(tmp_path, vehicle, tables)
    given, study = options(tables), tables["study"]
    vehicle = tv.load_vehicle(tmp_path / "vehicle.toml")

    def run(*arguments: Any) -> dict[str, Any]:
        result = CliRunner().invoke(app, [*map(str, arguments), "--json"])
        assert result.exit_code == 0, result.output
        return json.loads(result.stdout)

    plan = tv.load_study(tmp_path / "study.toml")
    one_case = tv.Case(
        vehicle=vehicle,
        wind=plan.wind,
        nozzle=plan.nozzle,
        **{key: study.get(key) for key in ("model", "plane", "sign")},
    )
    K = study["dead_band"]
    expected = np.degrees(tv.Study.of(one_case, K).required_deflection)
    shell = run("study", tmp_path / "vehicle.toml", *given)
    file = run("study", tmp_path / "study.toml")
    page = find(plan).study.required_deflection
    panel = answer(moved(str(tmp_path / "study.toml")), 4).required
    shared = {key: getattr(one_case, key) for key in ("model", "plane", "sign", "wind", "nozzle")}
    campaign = tv.ensembles.Campaign(vehicle=vehicle, cases=1, dead_bands=(K,), **shared)
    dispersed = nominal(campaign)[f"required_K{K:g}"]
    given = options(tables, ("sign", "limit_shape", "gust"))
    if "nozzle" in tables:
        given[given.index("--plane") + 1] = "both"
    flight = run("ascent", tmp_path / "flight.csv", "--from", 100, "--to", 100, *given)
    answers = {
        "shell": shell["verdict"]["required_deflection_deg"],
        "study file": file["verdict"]["required_deflection_deg"],
        "page": np.degrees(page),
        "panel": np.degrees(panel),
        "campaign": np.degrees(dispersed),
        "flight": required_along_flight(flight, K),
    }
    for entry, value in answers.items():
        assert value == pytest.approx(expected, rel=1e-6), entry
