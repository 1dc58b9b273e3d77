"""`tvclin boundary` in a wind: the numbers of the library, and one sentence for bad input."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import tvclin as tv
from tvclin.cli.app import app


def run(*arguments: str, vehicle: str = "configuration-i") -> Result:
    return CliRunner().invoke(app, ["boundary", vehicle, *arguments])


def test_json_equals_the_library() -> None:
    document = json.loads(run("--duration", "40", "--json").stdout)
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=40.0)
    expected = tv.optimum_deflection(plant, wind)

    assert document["peak_deg"] == pytest.approx(np.degrees(expected.peak), rel=1e-14)
    assert expected.switch_times.tolist() == document["switch_times_s"]
    assert document["first_segment"] == "goes with the wind"
    assert document["certificate"]["gap"] < 1e-9
    for boundary in document["boundaries"]:
        required = tv.required_deflection(plant, wind, boundary["dead_band"])
        assert boundary["limit"] == pytest.approx(required.limit, rel=1e-12)
        assert boundary["governed_by"] == required.governs
    assert [boundary["dead_band"] for boundary in document["boundaries"]] == [
        1.0,
        0.75,
        0.5,
        0.25,
        0.0,
    ]


def test_the_dead_bands_of_the_options_have_a_row_each() -> None:
    result = run("--dead-band", "0.4", "--dead-band", "0", "--duration", "40")
    assert result.exit_code == 0
    for said in ("Lower bound, wind known: 0.078 deg", "K = 0.4", "all unstable poles"):
        assert said in " ".join(result.output.split())
    assert "K = 1" not in result.output


@pytest.mark.parametrize(
    "options",
    [("--duration", "3"), ("--peak-deg", "2"), ("--start", "1"), ("--horizon", "9")],
)
def test_what_is_of_one_wind_is_refused_over_its_duration(options: tuple[str, ...]) -> None:
    result = run("--tau-beta", "4", *options)
    assert result.exit_code == 2
    assert f"{options[0]} needs a vehicle and no --tau-beta" in result.output


def test_an_early_start_gains_and_a_late_one_pays() -> None:
    arguments = ("--model", "fixed-path", "--json", "--start")
    peaks = [json.loads(run(*arguments, t).stdout)["peak_deg"] for t in ("-1", "0", "1")]
    beta = tv.Coefficients.from_vehicle(tv.load_vehicle("configuration-i")).beta

    assert peaks[1] / peaks[0] == pytest.approx(np.exp(beta), rel=1e-12)
    assert peaks[2] / peaks[1] == pytest.approx(np.exp(beta), rel=1e-12)


def test_a_rate_limit_costs_peak() -> None:
    document = json.loads(run("--set", "nozzle.rate_limit_deg_per_s=0.3", "--json").stdout)

    assert document["with_rate_limit"]["peak_deg"] > document["peak_deg"]
    assert document["with_rate_limit"]["rate_deg_per_s"] <= 0.3 * (1 + 1e-9)


@pytest.mark.thorough
def test_files_hold_the_deflection_that_was_found(tmp_path: Path) -> None:
    table, figure = tmp_path / "best.csv", tmp_path / "best.png"
    result = run("--csv", str(table), "--plot", str(figure))

    assert result.exit_code == 0
    assert figure.stat().st_size > 5000
    lines = [line for line in table.read_text().splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    column = next(name for name in rows[0] if name.startswith("deflection"))
    largest = max(abs(float(row[column])) for row in rows)
    peak = json.loads(run("--json").stdout)["peak_deg"]
    assert largest == pytest.approx(peak, rel=1e-6)


@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        (("--horizon", "1"), "horizon"),
        (("--set", "nozzle.rate_limit_deg_per_s=1e-4"), "rate"),
        (("--set", "nozzle.rate_limit_deg_per_s=-1"), "rate"),
        (("--wind", "square"), "wind"),
        (("--model", "none"), "model"),
        (("--start", "nan"), "start"),
        (("--csv", "/nowhere/at/all/x.csv"), "cannot be written"),
    ],
)
def test_bad_input_is_exit_code_two_and_one_sentence(
    arguments: tuple[str, ...], names: str
) -> None:
    result = run(*arguments)

    assert result.exit_code == 2
    assert isinstance(result.exception, SystemExit)
    assert names in result.output


def test_a_stable_vehicle_needs_nothing(stable_vehicle: Path) -> None:
    document = json.loads(
        run("--model", "fixed-path", "--json", vehicle=str(stable_vehicle)).stdout
    )

    assert document["peak_deg"] == 0.0
    assert document["first_segment"] == "none"
