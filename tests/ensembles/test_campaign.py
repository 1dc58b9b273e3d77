"""Dispersed cases: their numbers, their distributions, and what a sample proves."""

import json
from itertools import pairwise

import numpy as np
import pytest
from scipy import stats
from typer.testing import CliRunner

import tvclin as tv
from tvclin.base.lines import text
from tvclin.cli.app import app
from tvclin.ensembles.campaign.outputs import column_label
from tvclin.ensembles.dispersions import DEFAULT_DISPERSIONS, METHODS, draw
from tvclin.ensembles.statistics import quantile_bound, sensitivities, success_probability


@pytest.fixture(scope="module")
def nominal():
    vehicle = tv.load_vehicle("configuration-i")
    return tv.Study.from_vehicle(
        vehicle,
        duration=7.5,
        peak=np.radians(5),
        limit=np.radians(0.42),
        model="fixed-path",
        sign="frozen",
    )


@pytest.mark.parametrize("method", METHODS)
def test_a_case_has_the_same_numbers_however_the_campaign_is_cut(method):
    whole = draw(5, 0, 2500, 3, method=method, size=2500)
    cuts = [0, 1, 7, 1023, 1024, 1025, 2047, 2500]
    parts = [draw(5, a, b - a, 3, method=method, size=2500) for a, b in pairwise(cuts)]
    np.testing.assert_array_equal(np.concatenate(parts), whole)
    assert not np.array_equal(whole, draw(6, 0, 2500, 3, method=method, size=2500))
    assert 0.0 < whole.min() < whole.max() < 1.0


@pytest.mark.parametrize("method", METHODS)
def test_numbers_are_uniform_and_independent(method):
    numbers = draw(11, 0, 4096, 4, method=method, size=4096)
    for column in numbers.T:
        assert stats.kstest(column, "uniform").pvalue > 1e-3
    correlation = np.corrcoef(numbers.T)
    assert np.abs(correlation - np.eye(4)).max() < 4.0 / np.sqrt(4096)


def test_a_latin_hypercube_has_one_case_in_each_layer():
    numbers = draw(3, 0, 500, 2, method="latin", size=500)
    for column in numbers.T:
        np.testing.assert_array_equal(np.sort((column * 500).astype(int)), np.arange(500))


def test_dispersions_have_the_moments_and_ends_that_they_say():
    each = (
        tv.Dispersion("thrust", "normal", 0.02),
        tv.Dispersion("velocity", "uniform", 10.0, relative=False),
        tv.Dispersion("weight", "truncated", 0.1),
    )
    nominal = {"thrust": 2e6, "velocity": 500.0, "weight": 1e6}
    values = tv.Dispersions(each).apply(nominal, draw(1, 0, 40_000, 3)).values
    assert np.std(values["thrust"]) / 2e6 == pytest.approx(0.02, rel=0.02)
    assert stats.kstest(values["velocity"], stats.uniform(490.0, 20.0).cdf).pvalue > 1e-3
    cut = stats.truncnorm(-3, 3, loc=1e6, scale=1e5)
    assert stats.kstest(values["weight"], cut.cdf).pvalue > 1e-3
    assert 0.7e6 <= values["weight"].min() < values["weight"].max() <= 1.3e6


def test_correlated_dispersions_are_correlated():
    each = (tv.Dispersion("thrust", "normal", 0.02), tv.Dispersion("weight", "normal", 0.05))
    dispersions = tv.Dispersions(each, correlation=((1.0, -0.6), (-0.6, 1.0)))
    values = dispersions.apply({"thrust": 1.0, "weight": 1.0}, draw(2, 0, 40_000, 2)).values
    assert np.corrcoef(values["thrust"], values["weight"])[0, 1] == pytest.approx(-0.6, abs=0.02)


def test_the_quantile_bound_is_missed_as_seldom_as_it_promises():
    rng = np.random.default_rng(8)
    samples = rng.exponential(size=(4000, 300))
    true = -np.log(1 - 0.98)
    computed = [quantile_bound(sample, 0.98, 0.9) for sample in samples]
    above = np.mean([one.upper >= true for one in computed])
    below = np.mean([one.lower <= true for one in computed])
    # Binomial steps make the bounds a little safer than specified.
    assert 0.9 - 0.02 < above < 0.97
    assert 0.9 - 0.02 < below < 0.97


@pytest.mark.parametrize("n", [1, 2, 44, 45, 46, 229, 230, 3001])
@pytest.mark.parametrize(("p", "c"), [(0.99, 0.9), (0.95, 0.9), (0.5, 0.99), (0.02, 0.6)])
def test_the_ranks_of_the_bounds_are_the_first_and_last_that_hold(n, p, c):
    ranks = np.arange(1, n + 1)
    at_least = np.array([stats.binom.cdf(r - 1, n, p) for r in ranks])  # rank r is no smaller
    above, below = ranks[at_least >= c], ranks[1.0 - at_least >= c]
    result = quantile_bound(ranks[::-1], p, c)
    assert result.upper == (above[0] if above.size else np.inf)
    assert result.lower == (below[-1] if below.size else -np.inf)


@pytest.mark.parametrize(("p", "needed"), [(0.95, 45), (0.99, 230), (0.9973, 852), (0.99865, 1705)])
def test_a_sample_below_the_published_size_has_no_upper_bound(p, needed):
    # Hanson and Beard, NASA/TP-2010-216447: so many cases without a failure, at a risk of 0.1
    sample = np.arange(needed, dtype=float)
    assert np.isinf(quantile_bound(sample[:-1], p, 0.9).upper)
    assert quantile_bound(sample, p, 0.9).upper == sample[-1]
    few = quantile_bound([1.0], p, 0.9).few_cases
    assert few == f": cases must be at least {len(sample)}"


def test_success_is_clopper_and_pearson():
    result = success_probability(47, 50, 0.9)
    assert result.estimate == 0.94
    assert result.lower == pytest.approx(stats.beta.ppf(0.05, 47, 4), rel=1e-10)
    assert result.upper == pytest.approx(stats.beta.ppf(0.95, 48, 3), rel=1e-10)
    said = text(result.line("success"))  # one-sided bounds of quantiles stand beside it
    assert said == "94.00 % (85.22 to 98.34 %, two-sided 90 %)"
    assert success_probability(230, 230, 0.8).lower == pytest.approx(0.1 ** (1 / 230), rel=1e-10)


def test_sensitivities_are_spearmans_with_equal_and_infinite_values():
    random = np.random.default_rng(8)
    output = np.append(random.integers(0, 9, 300).astype(float), [np.inf] * 5)
    inputs = {
        "continuous": output_noise(random, output),
        "steps": np.append(random.integers(0, 4, 300), np.arange(5)) + 0.0,
    }
    result = sensitivities(inputs, output)
    for name, values in inputs.items():
        assert result[name] == pytest.approx(stats.spearmanr(values, output).statistic, abs=1e-14)


def output_noise(random, output):
    """Return values that rise with the output, beside noise of a third of its range."""
    return np.minimum(output, 9.0) + random.normal(size=output.size) * 3.0


def test_sensitivities_find_what_drives():
    rng = np.random.default_rng(4)
    inputs = {name: rng.normal(size=5000) for name in ("weak", "none", "strong")}
    result = sensitivities(inputs, np.exp(inputs["strong"]) - 0.3 * inputs["weak"])
    assert list(result) == ["strong", "weak", "none"]
    assert result["strong"] > 0.8
    assert result["weak"] < -0.1
    assert abs(result["none"]) < 0.05


def test_dispersed_cases_are_those_of_single_studies(nominal):
    result = tv.ensembles.disperse_study(nominal, cases=50, seed=9)
    for case in (0, 17, 49):
        values = {name: float(column[case]) for name, column in result.values.items()}
        duration = values.pop("wind_duration")
        vehicle = nominal.vehicle.replace(**values)
        single = tv.Study.from_vehicle(
            vehicle, duration=duration, peak=np.radians(5), model="fixed-path", sign="frozen"
        )
        assert result.deflection[case] == pytest.approx(single.required_deflection, rel=1e-12)
    assert set(result.status.tolist()) == {"ok"}


def test_the_first_cases_do_not_depend_on_how_many_follow(nominal):
    few, many = (tv.ensembles.disperse_study(nominal, cases=n, seed=3) for n in (40, 1500))
    # The many may take machine code, whose exponentials differ in their last digit.
    np.testing.assert_allclose(few.deflection, many.deflection[:40], rtol=1e-15)
    bound = stats.beta.ppf(0.05, *_counts(many, nominal.limit))
    assert many.success.lower == pytest.approx(bound, rel=1e-9)
    assert not np.array_equal(
        few.deflection, tv.ensembles.disperse_study(nominal, cases=40, seed=4).deflection
    )


def _counts(campaign, limit):
    sufficient = int(np.sum(campaign.deflection <= limit))
    return sufficient, campaign.deflection.size - sufficient + 1


def test_one_bad_case_has_its_own_status(nominal):
    wild = tv.Dispersions((tv.Dispersion("thrust", "normal", 0.6),))
    result = tv.ensembles.disperse_study(nominal, wild, cases=400, seed=1)
    bad = result.values["thrust"] <= 0.0
    assert 0 < bad.sum() < 50
    np.testing.assert_array_equal(result.status == "impossible vehicle or wind", bad)
    np.testing.assert_array_equal(np.isnan(result.deflection), bad)
    assert result.required.cases == 400 - bad.sum()


@pytest.mark.parametrize(
    ("parameter", "nominal", "possible"),
    [
        ("thrust", 1.0, lambda x: x > 0),
        ("control_force_slope", 1.0, lambda x: x > 0),
        ("axial_force", 1.0, lambda x: x >= 0),
        ("pitch_damping", 1.0, lambda x: x >= 0),
        ("control_arm", -1.0, lambda x: x < 0),
        ("attitude", 1.0, lambda x: np.abs(x) < np.pi / 2),
        ("aerodynamic_arm", 1.0, np.isfinite),
    ],
)
def test_what_cannot_be_is_told(parameter, nominal, possible):
    wide = tv.Dispersions((tv.Dispersion(parameter, "normal", 0.7, relative=False),))
    result = wide.apply({parameter: nominal}, draw(1, 0, 2000, 1))
    np.testing.assert_array_equal(result.possible, possible(result.values[parameter]))


@pytest.mark.parametrize(("limit", "word"), [("0.4", "NOT SUFFICIENT"), ("0.9", "NOT KNOWN")])
def test_few_cases_refuse_a_limit_whose_probability_has_too_low_an_interval(limit, word):
    arguments = ["disperse", "--cases", "200", "--limit-deg", limit, "--model", "fixed-path"]
    arguments += ["--set", "study.sign=frozen"]
    text = CliRunner().invoke(app, arguments)
    document = json.loads(CliRunner().invoke(app, [*arguments, "--json"]).stdout)
    assert document["upper_deg"] is None
    assert (document["success"]["upper"] < 0.99865) == (word == "NOT SUFFICIENT")
    assert f"{float(limit):.3f} deg: {word}; " in text.output
    assert text.exit_code == 1


def test_a_wind_whose_pressure_is_not_known_has_no_probability() -> None:
    arguments = ["disperse", "--cases", "30", "--probability", "0.9", "--duration", "6000"]
    arguments += ["--model", "fixed-path", "--limit-deg"]
    for limit, words in (("2", "the requirement at the pressure"), ("0.3", "")):
        text = CliRunner().invoke(app, [*arguments, limit])
        assert f"{float(limit):.3f} deg: NOT KNOWN; " in text.output
        assert words in text.output
        assert text.exit_code == 1


def test_the_convergence_is_that_of_the_specified_probability():
    arguments = ["disperse", "--cases", "300", "--probability", "0.9", "--model", "fixed-path"]
    arguments += ["--set", "study.sign=frozen", "--confidence", "0.8", "--json"]
    document = json.loads(CliRunner().invoke(app, arguments).stdout)
    last = document["convergence"][-1]
    for key in ("estimate_deg", "lower_deg", "upper_deg"):
        assert last[key] == document[key]


@pytest.mark.thorough
def test_the_command_line_says_the_same(nominal):
    arguments = ["disperse", "--cases", "1800", "--limit-deg", "0.42", "--model", "fixed-path"]
    arguments += ["--set", "campaign.seed=2", "--set", "study.sign=frozen"]
    text = CliRunner().invoke(app, arguments).output
    document = json.loads(CliRunner().invoke(app, [*arguments, "--json"]).stdout)
    result = tv.ensembles.disperse_study(nominal, cases=1800, seed=2)
    assert document["upper_deg"] == pytest.approx(np.degrees(result.required.upper), rel=1e-12)
    assert f"{document['upper_deg']:.3f} deg" in text
    assert document["drivers"] == pytest.approx(result.drivers)
    few = CliRunner().invoke(app, ["disperse", "--cases", "100"]).output
    assert "too few cases to say" in few


@pytest.mark.parametrize(
    ("attempt", "message"),
    [
        (lambda: tv.Dispersion("thurst", "normal", 0.1), r"did you mean 'thrust'"),
        (lambda: tv.Dispersion("thrust", "gauss", 0.1), "shape must be one of normal"),
        (lambda: tv.Dispersion("thrust", "normal", -0.1), "spread must be positive"),
        (lambda: tv.Dispersions((DEFAULT_DISPERSIONS.distributions[0],) * 2), "dispersed twice"),
        (
            lambda: tv.Dispersions(DEFAULT_DISPERSIONS.distributions[:2], ((1.0, 1.2), (1.2, 1.0))),
            "must be positive definite",
        ),
        (
            lambda: tv.Dispersions(DEFAULT_DISPERSIONS.distributions[:2], ((2.0, 0.0), (0.0, 1.0))),
            "correlation must have ones on its diagonal",
        ),
        (
            lambda: tv.winds.WindEnsemble(time=[0.0, 1.0], angle=[0.1, 0.0]),
            r"angle must hold one wind in each row; got an array of shape \(2,\)",
        ),
        (
            lambda: tv.Dispersions(DEFAULT_DISPERSIONS.distributions[:2], ((1.0,),)),
            "symmetric matrix of 2 rows",
        ),
        (
            lambda: tv.Dispersions(DEFAULT_DISPERSIONS.distributions[:1]).apply(
                {"thrust": 0.0}, [[0.5]]
            ),
            "no part of zero can be its spread",
        ),
        (
            lambda: tv.Dispersions(DEFAULT_DISPERSIONS.distributions[:1]).apply({}, [[0.5]]),
            "thrust is dispersed, but has no nominal value",
        ),
        (lambda: draw(0.5, 0, 1, 1), "seed must be an integer"),
        (lambda: draw(0, 0, 1, 1, method="halton"), "method must be one of"),
        (lambda: draw(0, 5, 10, 1, method="latin", size=12), "of 12 cases has no case 14"),
        (lambda: quantile_bound([1.0], 1.0), "probability must be above 0 and below 1; got 1"),
        (lambda: quantile_bound([]), "one number or more"),
        (lambda: quantile_bound([1.0, np.nan]), "without NaN"),
        (lambda: success_probability(3, 2), "at most cases"),
        (lambda: success_probability(1.5, 2), "successes must be an integer"),
    ],
)
def test_bad_input_is_one_clear_sentence(attempt, message):
    with pytest.raises(tv.InputError, match=message):
        attempt()


def test_a_study_in_which_no_case_can_be_says_so(nominal):
    turned = tv.Dispersions((tv.Dispersion("wind_peak", "normal", 1e9),))
    with pytest.raises(tv.InputError, match="no case has an answer; the first is: impossible"):
        tv.ensembles.disperse_study(nominal, turned, cases=20)


def test_bad_input_to_a_dispersed_study(nominal):
    with pytest.raises(tv.InputError, match="cases must be from 1 to 10000000; got 0"):
        tv.ensembles.disperse_study(nominal, cases=0)
    with pytest.raises(tv.InputError, match="seed must be an integer"):
        tv.ensembles.disperse_study(nominal, seed=-1)
    gain = tv.Dispersions((tv.Dispersion("rate_gain", "normal", 0.1),))
    with pytest.raises(tv.InputError, match="rate_gain is dispersed, but has no nominal value"):
        tv.ensembles.disperse_study(nominal, gain)
    result = CliRunner().invoke(app, ["disperse", "--set", "campaign.seed=-3"])
    assert result.exit_code == 2
    assert "seed must be an integer" in result.stderr


def test_a_requirement_that_is_not_known_is_not_said_to_be_lost():
    arguments = ["disperse", "--cases", "20", "--peak-deg", "31"]
    said = " ".join(CliRunner().invoke(app, arguments).output.split())
    assert "nominal lost or not known median lost or not known" in said
    assert "median lost" not in said.replace("lost or not known", "")


@pytest.mark.parametrize(
    ("column", "label"),
    [
        ("required_K0.5_yaw", "required deflection, K = 0.5, yaw"),
        ("flown_K1", "limit that the flights require, K = 1"),
        ("forecast_free_pitch", "lower bound, no forecast, pitch"),
        ("flight_peak_angle_of_attack", "flight peak angle of attack"),
    ],
)
def test_columns_have_labels_in_words(column, label):
    assert column_label(column) == label
