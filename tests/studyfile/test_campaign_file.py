"""Campaign files: what they say, and one sentence for what they should not."""

import csv
import json
import re
import sys
import tomllib
import tracemalloc
from dataclasses import fields, is_dataclass, replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.turns import usual
from tvclin.cli.app import app
from tvclin.ensembles.campaign.cases import evaluate
from tvclin.ensembles.campaign.folder import _KINDS, begin, read, read_manifest, written
from tvclin.ensembles.campaign.outputs import columns
from tvclin.ensembles.dispersions import DEFAULT_DISPERSIONS
from tvclin.kernels.choice import available, pinned
from tvclin.linear.plant import DEFAULT_MODEL
from tvclin.studyfile.campaign_file import parse_campaign, template
from tvclin.studyfile.parse import parse_study

HEAD = {"vehicle": "configuration-i", "cases": 10}
WIND = {"peak_deg": 5.0, "duration_s": 7.5}


def campaign(**tables):
    return parse_campaign({"campaign": HEAD, "wind": WIND} | tables)


def test_the_template_is_a_campaign(tmp_path):
    file = tmp_path / "my.toml"
    file.write_text(template())
    plan = tv.studyfile.load_campaign(file)
    assert plan.vehicle == tv.load_vehicle("configuration-i")
    assert plan.wind == tv.ShapedWind("triangular", peak=np.radians(5), duration=7.5)
    assert plan.nozzle.limit == pytest.approx(np.radians(0.42), rel=1e-15)
    assert plan.dispersions.distributions[0] == tv.Dispersion("thrust", "truncated", 0.01)
    arm = tv.Dispersion("aerodynamic_arm", "truncated", 0.47, relative=False)
    assert plan.dispersions.distributions[3] == arm
    correlation = np.array(plan.dispersions.correlation)
    assert correlation[2, 3] == correlation[3, 2] == -0.3
    assert np.count_nonzero(correlation) == 5 + 2


def test_the_page_shows_a_campaign():
    page = (Path(__file__).parents[2] / "docs" / "campaigns.md").read_text()
    (text,) = re.findall(r"```toml\n(.*?)```", page, flags=re.DOTALL)
    plan = parse_campaign(tomllib.loads(text))
    assert plan.outputs == ("required", "forecast-free", "minimum")
    assert plan.until == 0.01
    assert plan.dispersions.distributions[1] == tv.Dispersion(
        "wind_duration", "uniform", 2.0, False
    )


def test_a_record_makes_the_same_campaign():
    plan = replace(parse_campaign(tomllib.loads(template())), until=0.07, nozzle=tv.Nozzle())
    kept = json.loads(json.dumps(written(plan)))
    assert read(kept) == plan
    assert written(read(kept)) == kept


def test_spreads_carry_their_units():
    rows = [
        {"parameter": "thrust", "spread_kN": 20.0},
        {"parameter": "wind_peak", "spread_deg": 0.5, "shape": "uniform"},
        {"parameter": "velocity", "percent": 3.0},
        {"parameter": "pitch_damping", "spread_lbf_ft_s_per_rad": 1e5},
    ]
    each = campaign(dispersion=rows).dispersions.distributions
    assert [one.spread for one in each] == pytest.approx(
        [2e4, np.radians(0.5), 0.03, 1e5 * 4.4482216152605 * 0.3048], rel=1e-14
    )
    assert [one.relative for one in each] == [False, False, True, False]


@pytest.mark.parametrize(
    ("spread", "of_weight"),
    [
        ({"percent": 2.0}, tv.Dispersion("weight", "normal", 0.02)),
        ({"spread_kg": 100.0}, tv.Dispersion("weight", "normal", 980.665, relative=False)),
    ],
)
def test_a_mass_is_dispersed_as_its_weight(spread, of_weight):
    rows = [{"parameter": "mass", **spread}, {"parameter": "thrust", "percent": 1.0}]
    coefficient = {"between": ["thrust", "mass"], "coefficient": 0.5}
    each = campaign(dispersion=rows, correlation=[coefficient]).dispersions
    assert each.distributions[0] == of_weight
    assert each.correlation == ((1.0, 0.5), (0.5, 1.0))
    with pytest.raises(tv.InputError, match="must be one of .*, mass; got 'masss'"):
        campaign(dispersion=[{"parameter": "masss", "percent": 1.0}])
    twice = [*rows, {"parameter": "weight", "percent": 1.0}]
    with pytest.raises(tv.InputError, match="dispersed twice"):
        campaign(dispersion=twice)


@pytest.fixture
def ensemble(tmp_path):
    rng = np.random.default_rng(2)
    time = np.linspace(0.0, 30.0, 16)
    angle = np.abs(np.cumsum(rng.normal(size=(5, 16)), axis=1)) * 0.3
    with (tmp_path / "winds.csv").open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["time_s", *(f"wind {k}" for k in range(5))])
        writer.writerows(np.column_stack([time, angle.T]).tolist())
    return tmp_path, time, angle


def test_each_case_draws_one_wind_of_an_ensemble(ensemble):
    folder, time, angle = ensemble
    every = {"names": ["required", "forecast-free", "minimum"], "dead_bands": [0.5]}
    tables = {
        "campaign": HEAD | {"cases": 400, "sign": "frozen"},
        "wind": {"file": "winds.csv"},
        "outputs": every,
    }
    plan = parse_campaign(tables, folder)
    kept = read(json.loads(json.dumps(written(plan))))
    np.testing.assert_array_equal(kept.wind.angle, plan.wind.angle)
    result = evaluate(plan, 0, 400)
    counts = np.bincount(result["wind"], minlength=5)
    assert counts.size == 5
    assert counts.min() > 400 / 5 - 4 * np.sqrt(400 / 5)
    plant = tv.Plant.from_vehicle(plan.vehicle)
    for k in range(5):
        wind = tv.SampledWind(time=time, angle=np.radians(angle[k]))
        rows = result["wind"] == k
        limit = abs(tv.required_deflection(plant, wind, 0.5).deflection)
        np.testing.assert_allclose(result["required_K0.5"][rows], limit, rtol=1e-11)
        free = abs(tv.forecast_free_limit(plant, wind).deflection)
        np.testing.assert_allclose(result["forecast_free"][rows], free, rtol=1e-11)
        minimum = tv.optimum_deflection(plant, wind).peak
        np.testing.assert_allclose(result["minimum"][rows], minimum, rtol=1e-11)


def test_an_output_that_the_nominal_vehicle_does_not_have_is_named(tmp_path):
    """With a short arm of the air two modes grow as a pair, for which there is no such bound."""
    vehicle = tv.load_vehicle("configuration-i").replace(aerodynamic_arm=0.02)
    campaign = tv.Campaign(
        vehicle=vehicle,
        wind=tv.ShapedWind("triangular", peak=0.05, duration=7.5),
        outputs=("required", "forecast-free"),
        model="drift-exact",
        cases=4,
    )
    with pytest.raises(tv.InputError, match="output forecast-free: plant must have real unstable"):
        tv.run_campaign(campaign, tmp_path / "results")
    results = tv.run_campaign(replace(campaign, outputs=("required",)), tmp_path / "results")
    assert results.complete


@pytest.mark.thorough
def test_a_wind_that_changes_its_sign_is_the_status_of_its_cases_alone(ensemble):
    folder, _, angle = ensemble
    tables = {"campaign": HEAD | {"cases": 60}, "wind": {"file": "winds.csv"}}
    good = parse_campaign(tables | {"outputs": {"dead_bands": [0.5]}}, folder)
    turned = np.array(good.wind.angle)
    turned[2, 8] = -0.1
    bad = replace(good, wind=tv.winds.WindEnsemble(good.wind.time, turned))
    before, after = evaluate(good, 0, 60), evaluate(bad, 0, 60)
    hit = before["wind"] == 2
    assert 0 < hit.sum() < 60
    assert all("required: wind must not change its sign" in said for said in after["status"][hit])
    assert set(after["status"][~hit]) == {"ok"}
    assert np.all(np.isnan(after["required_K0.5"][hit]))
    column = "required_K0.5"
    np.testing.assert_allclose(after[column][~hit], before[column][~hit], rtol=1e-12)
    assert angle.shape == (5, 16)


@pytest.mark.parametrize("model", ["fixed-path", "drift", "drift-exact"])
@pytest.mark.parametrize("shape", ["triangular", "rectangular", "one-minus-cosine"])
def test_every_output_is_that_of_the_single_case(model, shape):
    plan = replace(
        campaign(wind=WIND | {"shape": shape}),
        dispersions=tv.Dispersions(
            (tv.Dispersion("thrust", "normal", 0.05), tv.Dispersion("wind_duration", "normal", 0.2))
        ),
        model=model,
        cases=3,
        outputs=("required", "forecast-free", "minimum"),
        sign="frozen",
        dead_bands=(0.5,),
    )
    result = evaluate(plan, 0, 3)
    for case in range(3):
        vehicle = plan.vehicle.replace(thrust=float(result["thrust"][case]))
        plant = tv.Plant.from_vehicle(vehicle, model)
        wind = tv.ShapedWind(shape, plan.wind.peak, float(result["wind_duration"][case]))
        history = wind.history({})
        expected = [
            abs(tv.required_deflection(plant, history, 0.5).deflection),
            abs(tv.forecast_free_limit(plant, history).deflection),
            tv.optimum_deflection(plant, history).peak,
        ]
        row = [result[name][case] for name in ("required_K0.5", "forecast_free", "minimum")]
        assert row == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"campain": {}}, "unknown table: 'campain'; did you mean campaign?"),
        ({"campaign": HEAD | {"modle": "drift"}}, "unknown key .*'modle'; did you mean model?"),
        ({"campaign": {"cases": 3}}, r"a key is missing in \[campaign\]: vehicle"),
        ({"campaign": HEAD | {"vehicle": "configuration-3"}}, "did you mean 'configuration-i"),
        ({"campaign": HEAD | {"vehicle": {"weight": 3.0}}}, "weight has no known unit"),
        ({"campaign": HEAD | {"vehicle": 3}}, "vehicle must be a name or a path"),
        ({"campaign": HEAD | {"seed": 1.5}}, "seed must be an integer"),
        ({"campaign": HEAD | {"seed": "one"}}, "seed must be an integer"),
        ({"campaign": HEAD | {"cases": 0}}, "cases must be from 1"),
        ({"campaign": HEAD | {"cases": "many"}}, "cases must be an integer"),
        ({"campaign": HEAD | {"chunk": -1}}, "chunk must be an integer, zero or positive"),
        ({"campaign": HEAD | {"model": "drifty"}}, "model must be one of .*'drift'"),
        ({"campaign": HEAD | {"plane": "roll"}}, "plane must be one of"),
        ({"campaign": HEAD | {"method": "halton"}}, "method must be one of plain"),
        ({"campaign": HEAD | {"method": "latin", "cases": 10**8}}, "at most 1e7 cases"),
        (
            {"campaign": HEAD | {"until_percent": -3}},
            r"until_percent in \[campaign\] must be positive",
        ),
        ({"campaign": 3}, r"\[campaign\] must be a table"),
        (
            {"wind": {"peak": 5.0, "duration_s": 7.5}},
            "peak has no known unit .* write peak_rad or",
        ),
        ({"wind": WIND | {"peak_rad": 0.1}}, "peak is given twice .* keep one"),
        ({"wind": WIND | {"shpe": "triangular"}}, "'shpe'; did you mean shape?"),
        ({"wind": WIND | {"shape": "square"}}, "shape of the wind must be one of triangular"),
        ({"wind": WIND | {"peak_deg": 120.0}}, "within 90 degrees"),
        ({"wind": WIND | {"duration_s": -1.0}}, "duration of the wind must be positive"),
        ({"wind": {"file": "none.csv"}}, "none.csv does not exist"),
        ({"wind": {"file": "none.csv", "unit": "knots"}}, "unit in .wind. must be one of rad"),
        ({"outputs": {"names": ["requird"]}}, "did you mean 'required'"),
        ({"outputs": {"names": []}}, "one or more different values"),
        ({"outputs": {"dead_bands": [1.5]}}, "dead_bands must be between 0 and 1"),
        ({"outputs": {"dead_bands": 1.0}}, "dead_bands in .outputs. must be a list"),
        ({"question": {"probability": 1.0}}, "probability must be above 0 and below 1"),
        ({"nozzle": {"limit_deg": -1.0}}, r"limit_deg in \[nozzle\] must be positive"),
        ({"dispersion": {"parameter": "thrust"}}, r"must be given as \[\[dispersion\]\]"),
        ({"dispersion": [{"parameter": "thurst"}]}, "did you mean 'thrust'"),
        ({"dispersion": [{"parameter": "thrust"}]}, "spread of thrust must be given once"),
        (
            {"dispersion": [{"parameter": "thrust", "percent": 1, "spread_N": 2}]},
            "spread of thrust must be given once",
        ),
        (
            {"dispersion": [{"parameter": "thrust", "spread_deg": 2}]},
            "spread_deg has no known unit .* of thrust; write spread_N",
        ),
        (
            {"dispersion": [{"parameter": "thrust", "percent": -2}]},
            "spread must be positive",
        ),
        (
            {"dispersion": [{"parameter": "thrust", "percent": 1}] * 2},
            "a parameter is dispersed twice",
        ),
        (
            {
                "dispersion": [{"parameter": "thrust", "percent": 1}],
                "correlation": [{"between": ["thrust", "weight"], "coefficient": 0.5}],
            },
            "between in .*correlation.* must be one of thrust; got 'weight'",
        ),
        (
            {
                "dispersion": [{"parameter": p, "percent": 1} for p in ("thrust", "weight")],
                "correlation": [{"between": ["thrust", "thrust"], "coefficient": 0.5}],
            },
            "between in .*correlation.* must name two parameters; got .'thrust', 'thrust'",
        ),
        (
            {
                "dispersion": [{"parameter": p, "percent": 1} for p in ("thrust", "weight")],
                "correlation": [{"between": ["thrust", "weight"], "coefficient": 1.5}],
            },
            "correlation must be positive definite",
        ),
    ],
)
def test_bad_files_are_one_clear_sentence(tables, message):
    with pytest.raises(tv.InputError, match=message):
        campaign(**tables)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "winds.csv is empty"),
        ("t,a\n0,1\n", "first column time_s"),
        ("time_s\n0\n1\n", "first column time_s"),
        ("time_s,a\n0,x\n", "line 2: a must be a number"),
        ("time_s,a\n0,1\n1\n", "line 3: there are 2 names and 1 cell in this line"),
        ("time_s,a\n0,1\n", "two or more samples"),
        ("time_s,a\n1,1\n0,1\n", "must not decrease"),
        ("time_s,a\n0,0\n1,0\n", "not zero throughout"),
        ("time_s,a\n0,100\n1,0\n", "within 90 degrees"),
        ("time_s,a\n0,nan\n1,0\n", "line 2: there is no number in a"),
    ],
)
def test_bad_wind_files_are_one_clear_sentence(tmp_path, text, message):
    (tmp_path / "winds.csv").write_text(text)
    with pytest.raises(tv.InputError, match=message):
        parse_campaign({"campaign": HEAD, "wind": {"file": "winds.csv"}}, tmp_path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a = " + "[" * 10_000, "is not valid TOML"),
        ('[campaign]\nvehicle = "none.toml"\n', "none.toml does not exist"),
    ],
)
def test_a_campaign_file_is_named_in_what_is_wrong_with_it(tmp_path, text, message):
    file = tmp_path / "many.toml"
    file.write_text(text)
    with pytest.raises(tv.InputError, match=rf"many\.toml:? .*{message}") as caught:
        tv.studyfile.load_campaign(file)
    assert "\n" not in str(caught.value)


def test_what_has_no_bound_without_forecast_is_refused_as_one_case_is(configuration_i):
    fixed = tv.Plant.from_vehicle(configuration_i, "fixed-path")
    gust, constant = (
        tv.TriangularWind(peak=0.08, duration=7.5),
        tv.linear.ConstantDeflection(limit=0.1),
    )
    for plant, wind, said in (
        (fixed, constant, "wind must end"),
        (fixed, gust - gust.shift(9.0), "not defined for a wind that changes its sign"),
    ):
        with pytest.raises(tv.InputError, match=said):
            tv.forecast_free_limit(plant, wind)
    stable = tv.Plant.from_vehicle(configuration_i.replace(aerodynamic_arm=-2.0), "fixed-path")
    many = tv.TriangularWind(peak=0.08, duration=[7.5, 9.0])
    assert tv.forecast_free_limit(stable, many).limit.tolist() == [0.0, 0.0]


def test_a_dispersed_wind_needs_a_shape(ensemble):
    rows = [{"parameter": "wind_peak", "percent": 10}]
    with pytest.raises(tv.InputError, match="take its dispersion out, or give a pulse"):
        parse_campaign(
            {"campaign": HEAD, "wind": {"file": "winds.csv"}, "dispersion": rows}, ensemble[0]
        )


def test_a_file_that_cannot_be_read(tmp_path):
    with pytest.raises(tv.InputError, match=r"does not exist; .* tvclin init --campaign"):
        tv.studyfile.load_campaign(tmp_path / "none.toml")
    bad = tmp_path / "bad.toml"
    bad.write_text("[campaign")
    with pytest.raises(tv.InputError, match=r"bad\.toml is not valid TOML"):
        tv.studyfile.load_campaign(bad)


GUST = tv.OneMinusCosineGust(peak=np.radians(1.0), duration=2.0).shift(2.0)


def test_a_gust_stays_as_far_from_the_middle_of_each_dispersed_wind() -> None:
    wind = tv.ShapedWind("triangular", np.radians(5.0), 7.5, gust=GUST, gust_at=3.0)
    spread = tv.Dispersions((tv.Dispersion("wind_duration", "uniform", 0.2),))
    vehicle = tv.load_vehicle("configuration-i")
    calm = {"model": "drift", "sign": "frozen"}
    plan = tv.Campaign(vehicle=vehicle, wind=wind, dispersions=spread, cases=5, **calm)
    result = evaluate(plan, 0, 5)
    plant = tv.Plant.from_vehicle(vehicle, "drift")
    for duration, required in zip(result["wind_duration"], result["required_K1"], strict=True):
        moved = GUST.shift(0.5 * (duration - 7.5))
        both = tv.TriangularWind(peak=np.radians(5.0), duration=duration) + moved
        expected = abs(tv.required_deflection(plant, both).deflection)
        assert required == pytest.approx(expected, rel=1e-12)
    again = read(written(plan))
    assert written(again) == written(plan)
    np.testing.assert_array_equal(evaluate(again, 0, 5)["required_K1"], result["required_K1"])


SPREAD = {"dispersion": [{"parameter": "wind_peak", "percent": 10.0}]}
BOTH = {
    "gust on K = 1": {"gust": {"peak_deg": 1.0, "duration_s": 2.0}} | SPREAD,
    "gust on K = 0.5": {
        "study": {"dead_band": 0.5},
        "gust": {"peak_deg": 1.0, "duration_s": 2.0},
        **SPREAD,
    },
    "placed gust": {"gust": {"peak_deg": 1.0, "duration_s": 2.0, "peak_time_s": 2.0}} | SPREAD,
    "assumed dispersions": {},
    "sobol": {"campaign": {"method": "sobol"}} | SPREAD,
    "head wind": {"study": {"sign": "head", "plane": "pitch"}} | SPREAD,
    "hinge": {"nozzle": {"limit_deg": 0.5, "mass_kg": 1200.0, "arm_m": 1.35}} | SPREAD,
    "default model": {"study": {}} | SPREAD,
}


@pytest.mark.parametrize("name", usual(BOTH, 3, 6))
def test_a_study_and_a_campaign_of_one_file_disperse_the_same_cases(name):
    """One gust, one model, one draw: every case to the last digit."""
    tables = dict(BOTH[name])
    model = {} if name == "default model" else {"model": "fixed-path"}
    document = {
        "study": {"vehicle": "configuration-i"} | model | tables.pop("study", {}),
        "campaign": {"cases": 6, "seed": 3} | tables.pop("campaign", {}),
        "wind": WIND,
        **tables,
    }
    study, plan = parse_study(document), parse_campaign(document)
    drawn = tv.ensembles.disperse_study(
        tv.Study.of(study, study.dead_band),
        study.dispersions or DEFAULT_DISPERSIONS,
        cases=study.cases,
        seed=study.seed,
        method=study.method,
    )
    (name,) = columns(plan)
    np.testing.assert_array_equal(evaluate(plan, 0, plan.cases)[name], drawn.deflection)


def test_a_gust_without_a_time_is_where_the_nominal_vehicle_requires_most():
    head = HEAD | {"model": "fixed-path", "sign": "frozen"}
    gust, outputs = {"peak_deg": 1.0, "duration_s": 2.0}, {"dead_bands": [0.5, 1.0]}
    plan = campaign(campaign=head, gust=gust, outputs=outputs)
    plant = plan.rigid_plant

    def required(at):
        wind = replace(plan.wind, gust_at=at).history({})
        return abs(tv.required_deflection(plant, wind, 0.5).deflection)

    assert required(plan.wind.gust_at) >= max(map(required, np.linspace(0.5, 7.0, 14))) * (1 - 1e-9)
    assert required(plan.wind.gust_at) > 1.005 * required(3.75)


@pytest.mark.thorough
def test_a_gust_costs_a_campaign_a_megabyte_for_each_case():
    """The largest trim deflection, four megabytes each, is that of the cases alone that fly."""
    plan = campaign(gust={"peak_deg": 1.0, "duration_s": 2.0}, **SPREAD)
    with pinned(available()):
        evaluate(plan, 0, 2)
        tracemalloc.start()
        try:
            evaluate(plan, 0, 96)
            assert tracemalloc.get_traced_memory()[1] < 96 * 2**20
        finally:
            tracemalloc.stop()


def test_both_templates_name_the_model_that_counts_without_one(tmp_path):
    own = tmp_path / "my.toml"
    own.write_text(template())
    assert tv.studyfile.load_campaign(own).model == campaign().model == DEFAULT_MODEL
    assert CliRunner().invoke(app, ["init", "--study", str(tmp_path / "s.toml")]).exit_code == 0
    assert tv.studyfile.load_study(tmp_path / "s.toml").model == DEFAULT_MODEL


def test_a_manifest_holds_every_kind_of_value_that_a_campaign_can_hold():
    """Every dataclass that annotations name, from the fields of a campaign down to the last."""
    import_module("tvclin.control.autopilot.gain_table")  # whichever tests were run before
    modules = [module for name, module in sys.modules.items() if name.startswith("tvclin.")]
    kinds = [
        value for module in modules for value in vars(module).values() if isinstance(value, type)
    ]
    known = {kind.__name__: kind for kind in kinds if is_dataclass(kind)}
    reached, left = {}, [known["Campaign"]]
    while left:
        kind = left.pop()
        reached[kind.__name__] = kind
        here = vars(sys.modules[kind.__module__])  # of two kinds with one name, its own
        words = re.findall(r"\w+", " ".join(str(field.type) for field in fields(kind)))
        named = [here[word] if word in here else known.get(word) for word in words]
        left += [one for one in named if is_dataclass(one) and one.__name__ not in reached]
    assert {"NozzleData", "Engine", "Filter", "BendingMode", "WindEnsemble"} <= reached.keys()
    # a table of gains, which a campaign refuses
    assert reached.keys() - _KINDS.keys() == {"GainTable"}


def test_a_nozzle_with_its_hinge_is_no_obstacle_to_a_campaign(tmp_path):
    hinge = {"mass_kg": 1200.0, "arm_m": 1.35, "inertia_kg_m2": 400.0, "friction_kN_m": 2.0}
    limits = {"limit_deg": 0.5, "torque_limit_kN_m": 90.0}
    plan = replace(campaign(nozzle=hinge | limits), model="fixed-path", cases=8)
    begin(plan, tmp_path)
    assert read_manifest(tmp_path).campaign.nozzle == plan.nozzle
