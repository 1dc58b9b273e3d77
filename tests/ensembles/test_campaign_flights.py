"""Campaigns that fly a law with limits, and disperse its gains."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import beta
from typer.testing import CliRunner

import tvclin as tv
from tvclin.cli.app import app
from tvclin.ensembles.campaign.cases import evaluate
from tvclin.ensembles.campaign.folder import read, written
from tvclin.studyfile.campaign_file import parse_campaign

LIMIT = np.radians(0.36)
HEAD = {
    "vehicle": "configuration-i",
    "cases": 12,
    "seed": 3,
    "model": "fixed-path",
    "sign": "frozen",
}
TABLES = {
    "campaign": HEAD,
    "wind": {"peak_deg": 5.0, "duration_s": 7.5},
    "outputs": {"names": ["required", "flight"], "law": "trim"},
    "nozzle": {"limit_deg": 0.36, "actuator_frequency_rad_per_s": 0},
    "autopilot": {"sample_rate_Hz": 25},
    "dispersion": [{"parameter": "wind_duration", "shape": "uniform", "percent": 60}],
}


@pytest.fixture(scope="module")
def trimmed():
    return evaluate(parse_campaign(TABLES), 0, 12)


def test_trim_survives_where_the_boundary_says(trimmed):
    needed = trimmed["required_K1"]
    clear = np.abs(needed / LIMIT - 1.0) > 0.05  # samples cost a little
    assert clear.sum() >= 8
    survived = trimmed["flight_survived"] == 1.0
    np.testing.assert_array_equal(survived[clear], (needed <= LIMIT)[clear])
    assert 0 < survived.sum() < 12


def test_a_lost_flight_is_worse_than_any_number(trimmed):
    lost = trimmed["flight_survived"] == 0.0
    for name in ("attitude", "angle_of_attack", "deflection"):
        np.testing.assert_array_equal(np.isinf(trimmed[f"flight_peak_{name}"]), lost)
    assert np.all(trimmed["flight_peak_deflection"][~lost] <= LIMIT * (1 + 1e-12))


def test_a_case_flies_with_its_own_gains_and_plant():
    servo = tv.Actuator(natural_frequency=20.0, damping=0.7)
    nozzle = tv.Nozzle(limit=np.radians(0.8), rate_limit=0.5, actuator=servo)
    spread = (
        tv.Dispersion("attitude_gain", "normal", 0.1),
        tv.Dispersion("rate_gain", "uniform", 0.2),
        tv.Dispersion("thrust", "normal", 0.03),
    )
    plan = replace(
        parse_campaign(TABLES),
        outputs=("flight",),
        law="autopilot",
        nozzle=nozzle,
        design=tv.AutopilotDesign(sample_rate=50.0),
        dispersions=tv.Dispersions(spread),
        model="drift",
        cases=3,
    )
    nominal = tv.control.canonical_gains(plan.plant.coefficients)
    result = evaluate(plan, 0, 3)
    assert np.all(np.abs(result["attitude_gain"] / nominal.attitude_gain - 1.0) < 0.4)
    assert len(set(result["rate_gain"])) == 3
    for i in range(3):
        gains = {k: float(result[k][i]) for k in ("attitude_gain", "rate_gain")}
        plant = tv.Plant.from_vehicle(
            plan.vehicle.replace(thrust=float(result["thrust"][i])), "drift"
        )
        flown = tv.fly(
            plant,
            tv.SaturatedLaw(tv.Autopilot(**gains)),
            plan.wind.history({}),
            np.arange(0.0, 45.0, 0.02),
            deflection_limit=nozzle.limit,
            rate_limit=0.5,
            actuator=servo,
            sample_rate=50.0,
        )
        assert result["flight_survived"][i] == 1.0
        for name in ("attitude", "angle_of_attack", "deflection"):
            peak = np.abs(np.asarray(flown.outputs[name])).max()
            assert result[f"flight_peak_{name}"][i] == pytest.approx(peak, rel=1e-9)


@pytest.mark.parametrize("law", ["dead-band", "recoverable-attitude", "half-relief"])
def test_laws_that_lean_survive_where_trim_does_not(trimmed, law):
    plan = parse_campaign(TABLES | {"outputs": TABLES["outputs"] | {"law": law}})
    result = evaluate(plan, 0, 12)
    survived = result["flight_survived"] == 1.0
    assert np.all(survived | (trimmed["flight_survived"] == 0.0))
    if law != "dead-band":
        assert survived.sum() > (trimmed["flight_survived"] == 1.0).sum()


@pytest.mark.thorough
def test_boundaries_flown_in_six_degrees_go_through_the_same_chunks():
    pytest.importorskip("jsbsim")
    tables = {
        "campaign": HEAD | {"model": "drift-exact", "cases": 3},
        "wind": {"peak_deg": 1.0, "duration_s": 7.5},
        "outputs": {"names": ["required", "flown"], "dead_bands": [0.0]},
        "dispersion": [
            {"parameter": "thrust", "shape": "uniform", "percent": 5},
            {"parameter": "wind_duration", "shape": "uniform", "percent": 30},
        ],
    }
    result = evaluate(parse_campaign(tables), 0, 3)
    assert list(result["status"]) == ["ok"] * 3
    np.testing.assert_allclose(result["flown_K0"], result["required_K0"], rtol=3e-3)
    assert np.ptp(result["flown_K0"]) > 0.01 * result["flown_K0"].max()


def test_a_document_keeps_the_flight():
    rows = [{"parameter": "rate_gain", "percent": 5}]
    flown = {
        "outputs": {"names": ["flight"]},
        "nozzle": {
            "limit_rad": 0.01,
            "rate_limit_deg_per_s": 5.0,
            "actuator_frequency_rad_per_s": 20.0,
        },
        "autopilot": {"attitude_gain": 0.2, "rate_gain_s": 0.3},
    }
    plan = parse_campaign(TABLES | flown | {"dispersion": rows})
    assert plan.nozzle.rate_limit == np.radians(5.0)
    assert plan.nominal["rate_gain"] == 0.3
    assert read(json.loads(json.dumps(written(plan)))) == plan


@pytest.mark.thorough
def test_the_command_line_says_how_many_survive_and_replays_a_flight(tmp_path, trimmed):
    pytest.importorskip("pyarrow")
    plan = replace(parse_campaign(TABLES), cases=4)
    results = tv.run_campaign(plan, tmp_path)
    few = {name: values[:4] for name, values in trimmed.items()}
    np.testing.assert_array_equal(results.column("flight_survived"), few["flight_survived"])
    share = few["flight_survived"].mean()
    shown = CliRunner().invoke(app, ["disperse", str(tmp_path), "--json"])
    assert json.loads(shown.stdout)["survival"]["estimate"] == share
    text = CliRunner().invoke(app, ["disperse", str(tmp_path)]).output
    assert f"{100 * share:.2f} %" in text
    case = int(np.argmax(few["flight_survived"]))
    one = results.replay(case)
    peak = float(np.abs(np.asarray(one.flown().outputs["attitude"])).max())
    assert peak == pytest.approx(few["flight_peak_attitude"][case], rel=1e-11)
    refused = CliRunner().invoke(app, ["disperse", str(tmp_path), "--output", "flight"])
    assert refused.exit_code == 2


@pytest.fixture(scope="module")
def flown_only(tmp_path_factory):
    """Trim in winds of very different length; on a fixed path the speed drives nothing."""
    pytest.importorskip("pyarrow")
    rows = [
        {"parameter": "velocity", "percent": 5},
        {"parameter": "wind_duration", "shape": "uniform", "percent": 60},
    ]
    tables = TABLES | {
        "campaign": HEAD | {"cases": 60},
        "outputs": {"names": ["flight"], "law": "trim"},
        "dispersion": rows,
    }
    return tv.run_campaign(parse_campaign(tables), tmp_path_factory.mktemp("flown") / "results")


def test_losses_are_counted_with_clopper_and_pearsons_interval(flown_only):
    survived = flown_only.column("flight_survived")
    lost = int(np.sum(survived == 0.0))
    assert 0 < lost < 60
    assert flown_only.flights == (60 - lost, lost)
    loss = flown_only.loss()
    assert loss.estimate == lost / 60
    ends = beta.ppf(0.05, lost, 61 - lost), beta.ppf(0.95, lost + 1, 60 - lost)
    assert (loss.lower, loss.upper) == pytest.approx(ends)
    survival = flown_only.survival()
    assert (survival.lower, survival.upper) == pytest.approx((1.0 - loss.upper, 1.0 - loss.lower))


@pytest.mark.thorough
def test_what_drives_loss_is_asked_of_all_flights(flown_only):
    """The excess of mean ranks of those that are lost, and chance by permutation."""
    lost = flown_only.column("flight_survived") == 0.0
    result = flown_only.loss_drivers()
    assert list(result) == ["wind_duration", "velocity"]
    for name, one in result.items():
        ranks = np.argsort(np.argsort(flown_only.column(name))).astype(float)
        assert one.rank == pytest.approx(np.corrcoef(ranks, lost)[0, 1])
        rng = np.random.default_rng(1)
        means = [ranks[rng.permutation(lost)].mean() for _ in range(4000)]
        chance = 2 * np.mean(np.abs(np.subtract(means, 29.5)) >= abs(ranks[lost].mean() - 29.5))
        assert one.confidence == pytest.approx(max(1.0 - chance, 0.0), abs=0.05)
    assert result["wind_duration"].rank > 0.5
    assert result["velocity"].confidence < 0.9
    peaks = flown_only.drivers()
    assert abs(peaks["wind_duration"]) > abs(peaks["velocity"])


@pytest.mark.thorough
def test_a_flight_that_is_lost_has_no_angle_and_a_limit_is_compared_with_deflections(flown_only):
    attitude = "flight_peak_attitude"
    assert flown_only.angles[:2] == ("flight_peak_deflection", attitude)
    assert flown_only.success(output=attitude) is None
    assert flown_only.deflections == ("flight_peak_deflection",)
    with pytest.raises(tv.InputError, match="limit is a deflection, and flight_peak_attitude is"):
        flown_only.success(0.007, output=attitude)
    held = flown_only.success()
    assert held.estimate == flown_only.survival().estimate  # none is larger than 0.36 deg
    folder = str(flown_only.folder)
    for arguments in ([], ["--output", attitude]):
        shown = CliRunner().invoke(app, ["disperse", folder, *arguments])
        assert shown.exit_code == (not arguments)  # the limit is not sufficient
        assert "inf" not in shown.output
        assert "nan" not in shown.output
        assert "NOT SURVIVED" in shown.output
        assert "loss is driven by" in shown.output
        assert "wind_duration (+" in shown.output
        assert ("deg is SUFFICIENT in" in shown.output) == (not arguments)
    document = json.loads(CliRunner().invoke(app, ["disperse", folder, "--json"]).stdout)
    lost = flown_only.flights[1]
    assert document["flights"] == {"survived": 60 - lost, "lost": lost}
    assert document["loss"] == pytest.approx(vars(flown_only.loss()))
    assert document["success"] == pytest.approx(vars(flown_only.success()))
    assert document["loss_drivers"]["wind_duration"]["confidence"] > 0.99
    case = int(np.argmin(flown_only.column("flight_survived")))
    replayed = CliRunner().invoke(app, ["disperse", folder, "--case", str(case)])
    assert "inf" not in replayed.output
    limit = flown_only.campaign.nozzle.limit
    assert f"Case {case}: lost with a limit of {np.degrees(limit):.4g} deg" in replayed.output
    flight, one = flown_only.replay(case).flown(), flown_only.replay(case).extremes_flown
    over = np.abs(flight.outputs["attitude"]) > np.pi / 2
    assert one["until_s"] == flight.time[np.argmax(over)]
    assert one["largest_attitude_deg"] > 90.0
    assert one["largest_deflection_deg"] == pytest.approx(np.degrees(limit))
    refused = CliRunner().invoke(
        app, ["disperse", folder, "--limit-deg", "0.4", "--output", attitude]
    )
    assert refused.exit_code == 2
    assert not flown_only.quantile(probability=0.99).within(1.0)


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"outputs": {"names": ["flight"], "law": "trimm"}}, "did you mean 'trim'"),
        ({"outputs": {"names": ["required"], "law": "trim"}}, 'flown by the output "flight"'),
        ({"nozzle": {}}, "needs the limit of the nozzle: limit_deg"),
        ({"nozzle": {"limit_deg": 1, "rate": 2}}, "unknown key in .nozzle.: 'rate'"),
        ({"nozzle": {"limit_deg": -1}}, "limit_deg in .nozzle. must be positive"),
        (
            {
                "outputs": {"names": ["flight"], "law": "autopilot"},
                "autopilot": {"attitude_gain": 1},
            },
            "need attitude_gain and rate_gain, both",
        ),
        (
            {"dispersion": [{"parameter": "rate_gain", "percent": 5}]},
            "rate_gain is dispersed, but has no nominal value",
        ),
    ],
)
def test_bad_flights_are_one_clear_sentence(tables, message):
    with pytest.raises(tv.InputError, match=message):
        parse_campaign(TABLES | tables)
