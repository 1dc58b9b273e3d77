"""Campaigns that judge both planes with one stop: each case is that of a study of both."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.turns import usual
from tvclin.cli.app import app
from tvclin.ensembles.campaign.cases import evaluate
from tvclin.requirement.encountered_requirement import encountered_requirements
from tvclin.studyfile.campaign_file import parse_campaign

SPREAD = [
    {"parameter": "thrust", "shape": "truncated", "percent": 2},
    {"parameter": "attitude", "shape": "normal", "percent": 3},
    {"parameter": "wind_peak", "shape": "uniform", "percent": 20},
    {"parameter": "wind_duration", "shape": "uniform", "percent": 30},
]
TABLES = {
    "campaign": {"vehicle": "configuration-i", "cases": 12, "seed": 3, "model": "drift"},
    "wind": {"peak_deg": 5.0, "duration_s": 7.5, "direction_deg": 250, "azimuth_deg": 25},
    "outputs": {"names": ["required"], "dead_bands": [1.0, 0.5]},
    "nozzle": {"limit_shape": "round", "limit_deg": 0.36},
    "dispersion": SPREAD,
}


def of_case(plan, columns, case, **more):
    """Return the case of the numbers that were drawn."""
    drawn = {name: float(columns[name][case]) for name in plan.dispersions.parameters}
    peak, duration = drawn.pop("wind_peak"), drawn.pop("wind_duration")
    later = 0.5 * (duration - plan.wind.duration)
    at = None if plan.wind.gust is None else plan.wind.gust_at + later
    return tv.Case(
        vehicle=plan.vehicle.replace(**drawn),
        model=plan.model,
        wind=replace(plan.wind, peak=peak, duration=duration, gust_at=at),
        nozzle=plan.nozzle,
    )


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("model", "stop", "direction", "gust"),
    usual(
        [
            ("fixed-path", "round", 250, False),
            ("drift", "square", 250, True),
            ("drift", "round", 60, False),
            ("drift-exact", "round", 250, False),
            ("drift-exact", "square", 60, True),
        ],
        0,
    ),
)
def test_cases_are_those_of_single_studies(model, stop, direction, gust) -> None:
    document = TABLES | {
        "campaign": TABLES["campaign"] | {"model": model},
        "wind": TABLES["wind"] | {"direction_deg": direction},
        "nozzle": {"limit_shape": stop},
    }
    if gust:
        document["gust"] = {"peak_deg": 1.0, "duration_s": 2.0}
    plan = parse_campaign(document)
    result = evaluate(plan, 0, 12)
    assert set(result["status"]) == {"ok"}
    for case in (0, 11):
        for K in plan.dead_bands:
            study = tv.Study.of(of_case(plan, result, case), K)
            name = f"required_K{K:g}"
            assert result[name][case] == pytest.approx(study.required_deflection, rel=1e-9)
            (single,) = encountered_requirements(study.case, study.placed, K).values()
            for plane, required in single.items():
                each = result[f"{name}_{plane}"][case]
                assert each == pytest.approx(required, rel=1e-9)
                assert each <= result[name][case]


@pytest.mark.thorough
def test_in_calm_air_they_are_the_same_to_rounding() -> None:
    plan = replace(parse_campaign(TABLES), sign="frozen", cases=3)
    result = evaluate(plan, 0, 3)
    for case in range(3):
        for K in plan.dead_bands:
            study = tv.Study.of(replace(of_case(plan, result, case), sign="frozen"), K)
            needs = result[f"required_K{K:g}"][case]
            assert needs == pytest.approx(study.required_deflection, rel=1e-12)


def test_what_nothing_undercuts_is_that_of_the_vectors() -> None:
    """Of equal planes in a wind of one direction it is that of one plane along it."""
    head = TABLES["campaign"] | {"model": "fixed-path", "cases": 3}
    names = ["minimum", "forecast-free"]
    plan = parse_campaign(TABLES | {"campaign": head, "outputs": {"names": names}})
    result = evaluate(plan, 0, 3)
    for case in range(3):
        drawn = of_case(plan, result, case)
        plant = tv.Plant.from_vehicle(drawn.vehicle, "fixed-path")
        along = replace(drawn.wind, heading=None).history({})
        minimum = tv.optimum_deflection(plant, along).peak
        free = abs(tv.forecast_free_limit(plant, along).deflection)
        assert result["minimum"][case] == pytest.approx(minimum, rel=1e-9)
        assert result["forecast_free"][case] == pytest.approx(free, rel=1e-9)
        parts = [result[f"minimum_{plane}"][case] for plane in ("pitch", "yaw")]
        assert np.hypot(*parts) == pytest.approx(minimum, rel=1e-9)


FLOWN = TABLES | {
    "campaign": TABLES["campaign"] | {"model": "fixed-path"},
    "outputs": {"names": ["required", "flight"], "law": "trim"},
    "nozzle": {"limit_shape": "round", "limit_deg": 0.33, "actuator_frequency_rad_per_s": 0},
    "autopilot": {"sample_rate_Hz": 50},
}


@pytest.mark.thorough
def test_a_flight_of_both_planes_survives_where_one_along_the_wind_does() -> None:
    plan = replace(parse_campaign(FLOWN), sign="frozen")
    result = evaluate(plan, 0, 12)
    fates = result["flight_survived"]
    assert 0 < fates.sum() < 12
    for case in range(12):
        drawn = of_case(plan, result, case)
        plant = tv.Plant.from_vehicle(drawn.vehicle, "fixed-path")
        along = replace(drawn.wind, heading=None).history({})
        flown = tv.fly_many(
            *(plant, tv.TrimLaw(plan.rigid_plant), along),
            deflection_limit=plan.nozzle.limit,
            sample_rate=50.0,
        )
        assert fates[case] == float(flown.status == "survived")
        if fates[case]:
            peak = result["flight_peak_deflection"][case]
            assert peak == pytest.approx(flown.peak_deflection, rel=1e-9)
    pitch, yaw = (result[f"flight_survived_{plane}"] for plane in ("pitch", "yaw"))
    np.testing.assert_array_equal(fates, np.minimum(pitch, yaw))
    assert np.all(np.isinf(result["flight_peak_attitude"]) == (fates == 0.0))


@pytest.mark.thorough
def test_a_case_that_cannot_be_has_its_own_status_and_the_others_go_on() -> None:
    wide = [{"parameter": "attitude", "shape": "uniform", "spread_deg": 60}, *SPREAD[:1]]
    plan = parse_campaign(TABLES | {"dispersion": wide})
    result = evaluate(plan, 0, 12)
    bad = result["status"] != "ok"
    assert 0 < bad.sum() < 12
    np.testing.assert_array_equal(~np.isfinite(result["required_K1"]), bad)
    some = int(np.flatnonzero(~bad)[0])
    single = evaluate(plan, some, 1)
    assert single["required_K1"][0] == result["required_K1"][some]


@pytest.mark.thorough
def test_results_and_a_replay_show_both_planes(tmp_path) -> None:
    pytest.importorskip("pyarrow")
    plan = parse_campaign(FLOWN)
    results = tv.run_campaign(plan, tmp_path)
    assert results.outputs[:3] == ("required_K1", "required_K1_pitch", "required_K1_yaw")
    assert tv.ensembles.open_campaign(tmp_path).campaign == plan
    assert "required_K1_yaw" in results.to_csv().partition("\n")[0]
    said = " ".join(CliRunner().invoke(app, ["disperse", str(tmp_path)]).output.split())
    assert "both planes, round stop: required deflection, K = 1" in said
    case = int(results.worst(1)[0])
    one = results.replay(case)
    replayed = CliRunner().invoke(app, ["disperse", str(tmp_path), "--case", str(case), "--json"])
    document = json.loads(replayed.stdout)
    assert document["fate"].startswith("lost with a limit")
    for plane, at in one.planes.items():
        response = one.response(one.capability, plane=plane)
        most = np.degrees(np.abs(response.outputs["attitude"]).max())
        assert document["response"][f"{plane}_largest_attitude_deg"] <= most * (1 + 1e-12)
        assert f"{plane}_largest_deflection_deg" in document["flight"]
        shares = one.campaign.nozzle.limit * at.share
        assert np.abs(one.flown(plane).outputs["deflection"]).max() <= shares * (1 + 1e-12)
    assert sum(at.share**2 for at in one.planes.values()) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"nozzle": {}, "wind": TABLES["wind"]}, None),
        ({"wind": {"peak_deg": 5.0, "duration_s": 7.5}}, "needs a wind with a direction"),
        ({"campaign": TABLES["campaign"] | {"sign": "head"}}, "leave sign"),
        ({"outputs": {"names": ["flown"]}}, '"flown" is of one plane'),
        ({"nozzle": {"limit_shape": "oval"}}, "limit_shape must be one of round"),
        ({"wind": TABLES["wind"] | {"direction_deg": 115}}, "no part in pitch"),
    ],
)
def test_what_both_planes_need_is_said(change, said) -> None:
    if said is None:  # in one plane a wind with a direction has its part there
        assert parse_campaign(TABLES | change).planes == "pitch"
        return
    with pytest.raises(tv.InputError, match=said):
        parse_campaign(TABLES | change)
