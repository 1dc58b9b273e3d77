"""The page: every number is the library's, every text escaped, the same inputs the same bytes."""

import json
import re
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.show.pages import Page, section
from tests.turns import usual
from tvclin.base.lines import Number, as_sentence, text
from tvclin.cli.app import app
from tvclin.design.standard_trials import law_trials
from tvclin.linear.plant import MODELS
from tvclin.show.report.page import _environment, page_of
from tvclin.studyfile import verdict
from tvclin.studyfile.assumptions import assumptions
from tvclin.studyfile.findings import find
from tvclin.studyfile.glossary import TERMS
from tvclin.studyfile.parse import parse_study
from tvclin.studyfile.questions import questions
from tvclin.studyfile.read import example
from tvclin.vehicle.vehicle_file import template
from tvclin.winds.shaped import SHAPES

pytest.importorskip("jinja2")
pytest.importorskip("latex2mathml")


def test_a_page_says_what_it_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "jinja2", None)
    with pytest.raises(
        tv.InputError, match=r"the page needs jinja2, which is not installed: .*tvclin\[report\]"
    ):
        _environment()


def sawtooth(peak: float, duration: float) -> tv.winds.AsymmetricTriangularWind:
    return tv.winds.AsymmetricTriangularWind(peak=peak, duration=duration, peak_time=duration)


@pytest.fixture(scope="module")
def plan() -> tv.studyfile.StudyPlan:
    """Return the example in calm air's dynamic pressure, with fewer laws, samples and cases."""
    whole = parse_study(tomllib.loads(example()))
    laws = tv.design.LawsRequest(names=("trim", "autopilot"), sample_rate=20.0)
    flight = replace(whole.sizing, start=60.0, stop=90.0)
    return replace(whole, model="fixed-path", laws=laws, cases=300, sizing=flight, sign="frozen")


@pytest.fixture(scope="module")
def html(plan: tv.studyfile.StudyPlan) -> str:
    return tv.report_html(plan)


@pytest.fixture(scope="module")
def page(html: str) -> Page:
    return Page(html)


def expected_boundaries(study: tv.Study) -> dict[str, float]:
    computed: dict[str, float] = {}
    for name in ("fixed-path", "drift-exact"):
        plant = tv.Plant.from_vehicle(study.vehicle, name)
        for i, K in enumerate((1.0, 0.75, 0.5, 0.25, 0.0)):
            one = tv.required_deflection(plant, study.wind, K)
            computed[f"boundary.{i}.K"] = K
            computed[f"boundary.{i}.{name}.part"] = one.limit
            computed[f"boundary.{i}.{name}_deg"] = abs(np.degrees(one.deflection))
        trim = abs(study.coefficients.B * study.wind.peak)
        free = abs(tv.forecast_free_limit(plant, study.wind).deflection)
        minimum = tv.optimum_deflection(plant, study.wind).peak
        for key, value in (("trim", trim), ("forecast_free", free), ("minimum", minimum)):
            computed[f"{key}.{name}.part"] = value / trim
            computed[f"{key}.{name}_deg"] = np.degrees(value)
    name = study.model
    needs = [computed[f"trim.{name}_deg"]]
    needs += [computed[f"boundary.{i}.{name}_deg"] for i in range(5)]
    needs += [computed[f"{key}.{name}_deg"] for key in ("forecast_free", "minimum")]
    needs[1] = np.degrees(study.required_deflection)
    peak = np.degrees(study.wind.peak)
    return computed | {f"survived.{k}_deg": 0.4 * peak / need for k, need in enumerate(needs)}


def expected_inputs(vehicle: tv.Vehicle) -> dict[str, float]:
    c = tv.Coefficients.from_vehicle(vehicle)
    coefficients = {
        "coefficients.beta_per_s": c.beta,
        **{f"coefficients.{k}": getattr(c, k) for k in ("K1", "B", "C1", "C2", "b1", "b2")},
    }
    poles = {
        f"poles.{model}.{k}.{part}": getattr(pole, {"real": "real", "imaginary": "imag"}[part])
        for model in MODELS
        for k, pole in enumerate(
            one
            for one in tv.unstable_modes(tv.Plant.from_vehicle(vehicle, model)).poles
            if one.imag >= 0.0
        )
        for part in (("real", "imaginary") if pole.imag else ("real",))
    }
    return (coefficients | poles) | {
        "vehicle.weight": 1.48e6,
        "vehicle.thrust": 2.495e6,
        "vehicle.moment_of_inertia": 0.225e8,
        "vehicle.normal_force_slope": 0.667e6,
        "vehicle.axial_force": 0.807e5,
        "vehicle.aerodynamic_arm": 9.45,
        "vehicle.control_arm": 23.56,
        "vehicle.velocity": 538.81,
        "vehicle.attitude": 44.83,
        "vehicle.time": 66.0,
        "wind.peak_deg": 5.0,
        "wind.duration": 7.5,
        "question.dead_band": 1.0,
        "question.limit_deg": 0.4,
    }


def expected_verdict(study: tv.Study) -> dict[str, float]:
    need = np.degrees(study.required_deflection)
    return {
        "verdict.limit_deg": 0.4,
        "verdict.wind_deg": need,
        "basis.dead_band": 1.0,
        "basis.peak_deg": 5.0,
        "basis.duration_s": 7.5,
        "facts.required_deg": need,
        "facts.limit_deg": 0.4,
        "facts.trim_deg": 5.0 * study.coefficients.B,
        "facts.minimum_deg": np.degrees(
            tv.optimum_deflection(
                tv.Plant.from_vehicle(study.vehicle, study.model), study.wind
            ).peak
        ),
        "validity.duration": 7.5,
        "validity.edge": tv.boundary.single_pole_validity(study.coefficients),
    }


def expected_laws(plan: tv.studyfile.StudyPlan, study: tv.Study) -> dict[str, float]:
    plant = tv.Plant.from_vehicle(plan.vehicle, plan.model)
    laws = tv.design.standard_laws(plant, study.wind.peak)
    trim = 5.0 * study.coefficients.B
    parts = {"any": tv.forecast_free_limit(plant, study.wind).limit}
    parts["minimum"] = np.degrees(tv.optimum_deflection(plant, study.wind).peak) / trim
    for name in plan.laws.names:
        (one,) = law_trials(plant, {name: laws[name]}, {"w": study.wind}, sample_rate=20.0)
        parts[name] = one.limit
    computed = {"laws.0.ideal_deg": trim, "laws.sample_rate": 20.0}
    for key, part in parts.items():
        computed |= {f"laws.0.{key}": part, f"laws.0.{key}_deg": part * trim}
    return computed


def expected_autopilot(study: tv.Study) -> dict[str, float]:
    plant = tv.Plant.from_vehicle(study.vehicle, "fixed-path")
    actuator = tv.Actuator(natural_frequency=25.1, damping=0.7)
    autopilot = tv.control.canonical_gains(plant.coefficients, actuator=actuator)
    law = tv.SaturatedLaw(replace(autopilot, actuator=None))
    flown = tv.closed_loop_boundary(plant, law, study.wind, actuator=actuator, sample_rate=100.0)
    stop = abs(np.degrees(flown.deflection))
    survived = np.degrees(
        tv.survivable_peak(tv.Plant.from_vehicle(study.vehicle), study.wind, np.radians(0.4))
    )
    m, c = autopilot.margins(plant), tv.compare_with_trim(plant, autopilot, study.wind)
    margins = {
        "aero_margin_dB": (m.aero_margin_dB, m.aero_frequency),
        "gain_increase_dB": (m.gain_increase_dB, m.gain_increase_frequency),
        "phase_margin_deg": (m.phase_margin_deg, m.crossover_frequency),
        "delay_margin": (1000.0 * m.delay_margin, m.delay_margin_frequency),
        "disk_margin": (m.disk_margin, m.disk_frequency),
        "peak_sensitivity": (m.peak_sensitivity, m.peak_sensitivity_frequency),
        "peak_complementary_sensitivity": (
            m.peak_complementary_sensitivity,
            m.peak_complementary_sensitivity_frequency,
        ),
    }
    computed = {f"margin.{name}": value for name, (value, _) in margins.items()}
    computed |= {f"margin.{name}.rad_per_s": at for name, (_, at) in margins.items()}
    computed["margin.aero_margin_dB.factor"] = m.aero_margin
    computed["margin.gain_increase_dB.factor"] = m.gain_increase
    computed["margin.disk_margin.gain"] = m.disk_margin_dB
    computed["margin.disk_margin.phase"] = m.disk_phase_deg
    angles = {
        "peak_deflection_rate_deg_s": c.peak_deflection_rate,
        "peak_angle_of_attack_deg": c.peak_angle_of_attack,
        "peak_attitude_deg": c.peak_attitude,
    }
    beside = {
        "deflection": c.peak_deflection,
        "stop": np.radians(stop),
        "trim": c.trim_deflection,
        "minimum": c.minimum,
        **{f"K{K:g}": boundary for K, boundary in c.boundaries.items()},
    }
    return (
        computed
        | {f"wind.{name}_deg": np.degrees(angle) for name, angle in beside.items()}
        | {f"wind.{name}.part": angle / c.trim_deflection for name, angle in beside.items()}
        | {f"wind.{name}": np.degrees(angle) for name, angle in angles.items()}
        | {
            "answer.autopilot_deg": np.degrees(c.peak_deflection),
            "facts.stop_deg": stop,
            "failure.required_deg": stop,
            "failure.limit_deg": 0.4,
            "laws.autopilot_requirement_deg": stop,
            "verdict.required_deg": stop,  # the autopilot needs most of all
            "verdict.surplus_deg": stop - 0.4,
            "verdict.surplus_percent": 100.0 * (1.0 - 0.4 / stop),
            "facts.survivable_peak_deg": min(survived, 5.0 * 0.4 / stop),
            "wind.wind_gain": c.wind_gain,
            "gains.attitude": 2.0 * study.coefficients.B,
            "gains.rate": study.coefficients.B / study.coefficients.beta,
            "gains.actuator_frequency": 25.1,
            "gains.actuator_damping": 0.7,
            "gains.delay_ms": 0.0,
            "criteria.aero_margin_dB": 6.0,
            "criteria.gain_increase_dB": 6.0,
            "criteria.phase_margin_deg": 30.0,
            "criteria.aero_margin_dB.surplus": m.aero_margin_dB - 6.0,
            "criteria.gain_increase_dB.surplus": m.gain_increase_dB - 6.0,
            "criteria.phase_margin_deg.surplus": m.phase_margin_deg - 30.0,
        }
    )


def expected_dispersed(plan: tv.studyfile.StudyPlan, study: tv.Study) -> dict[str, float]:
    d = tv.ensembles.disperse_study(study, plan.dispersions, cases=300, seed=1)
    return {
        "answer.probability": 99.865,
        "basis.success": 100.0 * d.success.estimate,
        "answer.success": 100.0 * d.success.upper,
        "facts.covers_deg": np.degrees(d.required.upper),
        "dispersed.cases": 300.0,
        "dispersed.seed": 1.0,
        "dispersed.median_deg": np.degrees(np.median(d.deflection)),
        "dispersed.estimate_deg": np.degrees(d.required.estimate),
        "dispersed.upper_deg": np.degrees(d.required.upper),
        "dispersed.success": 100.0 * d.success.estimate,
        "dispersed.success_lower": 100.0 * d.success.lower,
        "dispersed.success_upper": 100.0 * d.success.upper,
    } | {f"dispersed.driver.{name}": rank for name, rank in d.drivers.items()}


def expected_flight(plan: tv.studyfile.StudyPlan) -> dict[str, float]:
    """Each flight time by itself, and the sum of the worst one as the text of the page has it."""
    wind = tv.TriangularWind(peak=np.radians(5), duration=7.5)
    schedule = tv.load_schedule("configuration-i")
    computed: dict[str, float] = {}
    totals: dict[float, dict[str, float]] = {}
    ratios: dict[float, dict[str, float]] = {}
    for i, time in enumerate((60.0, 70.0, 80.0, 90.0)):
        vehicle = schedule.at(time)
        plant = tv.Plant.from_vehicle(vehicle, "fixed-path")
        around = schedule.at(np.linspace(time - 3.75, time + 3.75, 33))
        now, then = (tv.Coefficients.from_vehicle(one) for one in (vehicle, around))
        changes = [np.abs(x / x0 - 1).max() for x, x0 in ((then.beta, now.beta), (then.B, now.B))]
        need = np.degrees(np.abs(tv.boundary_limit(plant, wind, [1.0, 0.5]).deflection))
        computed |= {
            f"flight.0.{i}.time": time,
            f"flight.0.{i}.trim_deg": 5.0 * plant.coefficients.B,
            f"flight.0.{i}.K = 1_deg": need[0],
            f"flight.0.{i}.K = 0.5_deg": need[1],
            f"flight.0.{i}.no forecast_deg": np.degrees(
                abs(tv.forecast_free_limit(plant, wind).deflection)
            ),
            f"flight.0.{i}.minimum_deg": np.degrees(tv.optimum_deflection(plant, wind).peak),
            f"flight.0.{i}.change_percent": 100.0 * max(changes),
        }
        offset = (2.495e6 - vehicle.axial_force) * 0.02 / (2.495e6 * 23.56)
        lines = {
            "nominal_flight": abs(np.degrees(schedule.nominal_at(time))),
            "wind": need[0],
            "dispersions": 0.2 * need[0],
            "thrust_offset": np.degrees(np.sin(np.radians(0.1))),
            "centre_of_gravity_offset": np.degrees(offset),
        }
        systematic, random = [*lines.values()][:2], [*lines.values()][2:]
        lines["total"] = sum(systematic) + np.sqrt(np.sum(np.square(random)))
        totals[lines["total"]] = lines
        taken = lines | {"wind": 5.0 * plant.coefficients.B}
        offsets = (taken["thrust_offset"], taken["centre_of_gravity_offset"])
        taken["takes"] = taken["nominal_flight"] + taken["wind"] + np.hypot(*offsets)
        ratios[taken["takes"]] = taken
    worst, taken = totals[max(totals)], ratios[max(ratios)]
    computed |= {f"total.{name}_deg": value for name, value in worst.items()}
    parts = ("nominal_flight", "wind", "thrust_offset", "centre_of_gravity_offset", "takes")
    computed |= {f"ratio.{name}_deg": taken[name] for name in parts}
    computed |= {"ratio.limit_deg": 0.4, "ratio.ratio": 0.4 / taken["takes"]}
    return computed | {
        "total.reserve_percent": 10.0,
        "total.required_deg": worst["total"] / 0.9,
        "total.limit_deg": 0.4,
        "total.short_deg": worst["total"] / 0.9 - 0.4,
        "facts.flight_deg": worst["total"] / 0.9,
        "assumptions.change_percent": computed[
            f"flight.0.{[*totals].index(max(totals))}.change_percent"
        ],
    }


def test_every_number_is_that_of_the_library(plan: tv.studyfile.StudyPlan, page: Page) -> None:
    study = plan.study()
    expected = (
        expected_verdict(study)
        | expected_inputs(plan.vehicle)
        | expected_boundaries(study)
        | expected_laws(plan, study)
        | expected_autopilot(study)
        | expected_dispersed(plan, study)
        | expected_flight(plan)
    )
    needs = {"wind": "facts.required_deg", "whole_flight": "facts.flight_deg"}
    needs |= {"probability": "facts.covers_deg", "autopilot": "facts.stop_deg"}
    for name, key in needs.items():
        if not np.isfinite(expected[key]):
            continue
        row = {"required": expected[key], "available": 0.4, "remaining": 0.4 - expected[key]}
        expected |= {f"answer.{name}.{column}_deg": value for column, value in row.items()}
    phase = expected["criteria.phase_margin_deg.surplus"]
    row = {"required": 30.0, "available": 30.0 + phase, "remaining": phase}
    expected |= {f"answer.margins.{column}_deg": value for column, value in row.items()}
    for key in needs.values():  # they stand in the table of all questions
        del expected[key]
    seen = {
        "angle_of_attack_deg": "wind.peak_angle_of_attack_deg",
        "rate_deg": "wind.peak_deflection_rate_deg_s",
    }
    expected |= {f"assumptions.{name}": expected[key] for name, key in seen.items()}
    expected = {name: value for name, value in expected.items() if np.isfinite(value)}
    computed = {name: value for name, (value, _) in page.numbers.items()}

    beside = ("response.", "sweep.", "use.", "flown.")  # with tests of their own
    assert {name for name in computed if not name.startswith(beside)} == expected.keys()
    for name, value in expected.items():
        assert computed[name] == pytest.approx(value, rel=1e-12, abs=1e-14), name


def test_the_rule_of_the_study_is_applied_at_each_flight_time_and_flown(
    plan: tv.studyfile.StudyPlan, page: Page
) -> None:
    flight, times = plan.sizing.schedule, [60.0, 70.0, 80.0, 90.0]
    every = np.union1d(times, [*np.arange(41.0, 112.0, 10.0), 116.0])
    plants = flight.plants(every, "fixed-path", "pitch")
    actuator = tv.Actuator(natural_frequency=25.1, damping=0.7)
    gains = tv.control.canonical_gains(plants.coefficients, actuator=actuator)
    schedule = tv.control.GainSchedule(every, replace(gains, sample_rate=100.0))
    phases = gains.margins(plants).phase_margin_deg[np.isin(every, times)]
    for k, time in enumerate(times):
        assert page.numbers[f"sweep.{k}.time"][0] == time
        assert page.numbers[f"sweep.{k}.phase [deg]"][0] == pytest.approx(phases[k], rel=1e-9)
        pulse = tv.TriangularWind(peak=np.radians(5.0), duration=7.5).shift(time - 3.75)
        flown = tv.flights.fly_along(
            flight,
            schedule,
            pulse,
            deflection_limit=np.radians(0.4),
            sign="frozen",
            start=time - 3.75,
            model="fixed-path",
        )
        if flown.status == "survived":
            used = abs(np.degrees(flown.largest("deflection").value))
            assert page.numbers[f"use.{k}.used_deg"][0] == pytest.approx(used, rel=1e-9)


def test_the_response_is_the_exact_one(plan: tv.studyfile.StudyPlan, page: Page, html: str) -> None:
    """Against a dense sample of the report's eq (13) flown to the end that the page names."""
    study = plan.study()
    plant = tv.Plant.from_vehicle(plan.vehicle, "fixed-path")
    limit = -np.radians(0.4)
    deflection = tv.trim_then_hold(plant, study.wind, limit, 1.0)
    shown = {name: value for name, (value, _) in page.numbers.items()}
    times = np.linspace(0.0, shown["response.at_end_s"], 20001)
    times = np.unique([*times, 7.5 / 2])
    answer = tv.attitude_responses(plant, deflection, study.wind, times)
    attitude = np.degrees(answer["attitude"])
    attack = np.degrees(answer["angle_of_attack"])[times < study.wind.end]

    said = " ".join(html[html.index("Exact response of the linear model") :].split())
    assert said.startswith(
        "Exact response of the linear model at nominal dynamic pressure, with the"
    )
    assert shown["response.at_end_deg"] == pytest.approx(0.0, abs=1e-9)
    assert shown["response.with_wind_deg"] == pytest.approx(attitude.min(), rel=1e-6)
    assert shown["response.with_wind_s"] == pytest.approx(times[attitude.argmin()], abs=1e-3)
    at = np.interp(7.5, times, attitude)
    assert shown["response.at_wind_end_deg"] == pytest.approx(at, rel=1e-6)
    assert shown["response.at_wind_end_s"] == 7.5
    assert shown["response.angle_of_attack_deg"] == pytest.approx(attack.min(), rel=1e-6)
    assert shown["response.angle_of_attack_s"] == pytest.approx(times[attack.argmin()], abs=1e-3)


@pytest.mark.thorough
def test_a_response_that_is_lost_ends_at_90_degrees(plan: tv.studyfile.StudyPlan) -> None:
    lost = replace(plan, nozzle=tv.Nozzle(limit=0.001), wind=replace(plan.wind, duration=20.0))
    result = find(lost)
    shown = section(result, "response").values
    plant = tv.Plant.from_vehicle(plan.vehicle, "fixed-path")
    deflection = tv.trim_then_hold(plant, result.study.wind, -0.001, 1.0)
    late = shown["response.at_end_s"]
    answer = tv.attitude_responses(plant, deflection, result.study.wind, [late - 0.021, late])
    before, after = np.degrees(np.abs(answer["attitude"]))

    assert before < 90.0
    assert after == pytest.approx(90.0, rel=1e-9)
    assert abs(shown["response.at_end_deg"]) == pytest.approx(after, rel=1e-9)
    assert late < 20.0
    assert "response.angle_of_attack_deg" not in shown


def test_every_text_is_its_number_rounded(page: Page) -> None:
    raised = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    for name, (value, shown) in page.numbers.items():
        text = shown.translate(raised).replace("·10", "e")
        match = re.fullmatch(r"-?\d+(?:\.(\d+))?(?:e(-?\d+))?", text)
        assert match, (name, text)
        step = 10.0 ** (int(match.group(2) or 0) - len(match.group(1) or ""))
        assert abs(float(text) - value) <= 0.5 * step * (1 + 1e-9), (name, value, text)


@pytest.mark.thorough
@pytest.mark.usefixtures("few_durations")
def test_the_head_of_the_page_is_that_of_the_study_file(tmp_path: Path) -> None:
    text = '[study]\nvehicle = "configuration-i"\n[wind]\npeak_deg = 5\nduration_s = 7.5\n'
    given = 'project = "A & B"\ndate = 2026-01-31\nrevision = "C"\n'
    (tmp_path / "bare.toml").write_text(text)
    (tmp_path / "signed.toml").write_text(f"{text}[document]\n{given}")
    bare, signed = (tv.load_study(tmp_path / f"{name}.toml") for name in ("bare", "signed"))
    html = tv.report_html(signed)
    head = html[html.index("<body>") : html.index("<h1>")]

    assert re.findall(r"<dt>(.*?)</dt><dd>(.*?)</dd>", head) == [
        ("project", "A &amp; B"),
        ("date", "2026-01-31"),
        ("revision", "C"),
    ]
    assert 'class="document"' not in tv.report_html(bare)
    assert find(bare).seal == find(signed).seal
    assert "# [document]" in example()


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("revision = 3", ".document.: revision must be a text of printable characters; got 3"),
        ("date = true", ".document.: date must be a text of printable characters; got True"),
        ('auther = "A"', "unknown key in .document.: 'auther'; did you mean author"),
    ],
)
def test_a_head_of_a_wrong_kind_is_one_sentence(line: str, said: str) -> None:
    document = tomllib.loads(f'[study]\nvehicle = "configuration-i"\n[document]\n{line}\n')
    with pytest.raises(tv.InputError, match=said):
        parse_study(document | {"wind": {"peak_deg": 5.0, "duration_s": 7.5}})


def test_formulas_are_mathml_and_the_glossary_has_what_stands_on_the_page(html: str) -> None:
    equations = html[html.index('id="equations"') : html.index('id="origin"')]
    glossary = html[html.index('id="glossary"') :]
    terms = re.findall(r'<th scope="row">(\w[\w -]*)</th>', glossary)
    before = re.sub(r"<[^>]*>", "", html[: html.index('id="glossary"')]).lower()

    assert equations.count("<math") == equations.count('<th scope="row">') == 11
    assert {"trim", "limit", "boundary", "drift"} <= set(terms) < set(TERMS)
    assert all(term.lower() in before for term in terms)
    assert "<math" in glossary


@pytest.mark.thorough
def test_the_same_inputs_give_the_same_bytes(plan: tv.studyfile.StudyPlan, html: str) -> None:
    again = tv.report_html(plan)
    for _ in range(2):
        if again == html:  # else some work became worth machine code, which changes last digits
            break
        html, again = again, tv.report_html(plan)
    assert again == html
    assert len(html.encode()) < 2_000_000


def test_the_seal_is_that_of_the_inputs(plan: tv.studyfile.StudyPlan, html: str) -> None:
    short = replace(plan, laws=None, design=None, criteria=None, dispersions=None)
    nearly = replace(short, nozzle=tv.Nozzle(limit=plan.nozzle.limit * (1 + 1e-15)))

    assert len(set(re.findall(r"[0-9a-f]{64}", html))) == 1
    assert find(short).seal == find(short).seal != find(nearly).seal


def test_the_page_stands_alone_and_is_in_order(html: str, page: Page) -> None:
    tags = [tag for tag, _ in page.tags]
    ids = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    targets = [attribute["href"] for attribute in page.attributes("a")]
    targets += [attribute["xlink:href"] for attribute in page.attributes("use")]
    targets += re.findall(r"url\((#[^)]+)\)", html)

    assert not {"script", "img", "iframe", "object"} & set(tags)
    assert [attribute["href"] for attribute in page.attributes("link")] == ["data:,"]
    assert not re.search(r"@import|src=|https?://(?!www\.w3\.org/)", html)
    assert len(ids) == len(set(ids))
    assert {target[1:] for target in targets} <= set(ids)
    assert [tag for tag in tags if re.fullmatch("h[1-6]", tag)] == ["h1", *["h2"] * 14]
    assert all(attribute["scope"] in ("row", "col") for attribute in page.attributes("th"))
    assert all(
        attribute["role"] == "img" and attribute["aria-label"]
        for attribute in page.attributes("svg")
    )
    assert tags.count("svg") == 8
    assert tags.count("table") == tags.count("caption")


def test_a_pulse_without_a_closed_form_is_named_no_equation(
    plan: tv.studyfile.StudyPlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(SHAPES, "sawtooth", sawtooth)
    bare = tv.studyfile.StudyPlan(vehicle=plan.vehicle, wind=replace(plan.wind, shape="sawtooth"))
    equations = set(section(find(bare), "equations").of("th"))

    assert {"(4b)", "(5)", "(B7)"} <= equations
    assert not {"(7)", "(12)", "(16)", "(18)"} & equations


def test_a_measured_wind_is_told_with_its_station_its_date_and_the_direction_of_flight() -> None:
    sounding = {"sounding": "tests/soundings/wyoming.txt", "azimuth_deg": 62.5}
    wind = {"peak_deg": 5.0, "duration_s": 7.5}
    study = {"vehicle": "configuration-i"}
    request = parse_study({"study": study, "wind": [wind, sounding], "schedule": {}}).sizing
    (sounding_line,) = map(text, request.sounding_lines())
    for said in ("wyoming.txt: 74794 XMR Cape Kennedy", "12Z 15 Feb 2024", "towards 62.5 deg"):
        assert said in sounding_line
    assert "soundings/" not in sounding_line


@pytest.mark.parametrize(
    ("model", "named", "others"),
    [
        ("drift", {"(B8)", "(18)"}, {"(B7)", "(B5)"}),
        ("drift-exact", {"(B7)"}, {"(B8)", "(18)", "(B5)"}),
        ("drift-and-speed", {"(B5)"}, {"(B7)", "(B8)", "(18)"}),
    ],
)
def test_each_model_has_the_equation_that_glossary_and_conventions_say(
    plan: tv.studyfile.StudyPlan, model: str, named: set[str], others: set[str]
) -> None:
    bare = tv.studyfile.StudyPlan(vehicle=plan.vehicle, model=model)
    equations = set(section(find(bare), "equations").of("th"))
    assert named | {"(12)"} <= equations
    assert not others & equations


@pytest.mark.thorough
@pytest.mark.usefixtures("few_durations")
def test_the_nichols_chart_says_whose_criteria_its_box_is_of(html: str) -> None:
    design = tv.AutopilotDesign(design="lqr")
    plan = tv.studyfile.StudyPlan(vehicle=tv.load_vehicle("configuration-i"), design=design)
    without, given = (" ".join(text.split()) for text in (tv.report_html(plan), html))

    assert "the box of the criteria classic, which stand where the file gives none." in without
    assert "the box of the criteria" in given
    assert "which stand where the file gives none" not in given


@pytest.mark.thorough
@pytest.mark.usefixtures("few_durations")
def test_names_are_escaped() -> None:
    name = '<script>alert("1")</script> & \'--><b>'
    vehicle = tv.load_vehicle("configuration-i").replace(name=name)
    criteria = tv.control.Criteria.custom("--><script>", aero_margin_dB=3)
    html = tv.report_html(tv.studyfile.StudyPlan(vehicle=vehicle, criteria=criteria))
    page = Page(html)

    assert not {"script", "b"} & {tag for tag, _ in page.tags}
    assert any(name in text for text in page.texts)
    assert html.count("<svg") == html.count("</svg>") == 5


@pytest.mark.thorough
def test_the_flight_in_a_measured_wind_says_where_its_numbers_are_doubtful(tmp_path) -> None:
    """On a page that sounding and gust make too much for the limit, and the seal tells apart."""
    (tmp_path / "w.csv").write_text(
        "height_m,speed_m_per_s,direction_deg\n5000,0,270\n8000,40,270\n12000,60,260\n16000,9,90\n"
    )
    text = (
        '[study]\nvehicle = "configuration-i"\n[[wind]]\npeak_deg = 5\nduration_s = 35\n'
        '[[wind]]\nsounding = "w.csv"\nazimuth_deg = 90\n[nozzle]\nlimit_deg = 0.4\n'
        "[gust]\npeak_deg = 1\nduration_s = 2\n"
        "[size]\nfrom_s = 66\nto_s = 66\nvarying = true\n[sounding]\nwindow_s = 20\n"
    )
    (tmp_path / "s.toml").write_text(text)
    plan = tv.load_study(tmp_path / "s.toml")
    result = find(plan)
    sizing, shown = result.flight[0], section(result, "flight")

    assert sizing.winds == (
        "triangular wind of 5 deg, 35 s, gust of 1 deg, 2 s",
        "w.csv, gust of 1 deg, 2 s",
    )
    for j in range(2):
        for name, values in sizing.required.items():
            key = f"flight.{j}.0.{name}_deg"
            if j == 1 and name.direction:
                # a sounding is one wind of its own sign: its requirement stands in one column
                assert values[0, 1] == sizing.required["K = 1, varying"][0, 1]
                assert key not in shown.values
            elif np.isfinite(values[0, j]):
                assert shown.values[key] == pytest.approx(np.degrees(values[0, j]), rel=1e-12)
    assert "Required deflection [deg]: w.csv, gust of 1 deg, 2 s" in shown.of("caption")
    frozen = [shown.cells[k:] for k, cell in enumerate(shown.cells) if cell == ("th", "one pole")]
    one_pole = [next(text for _, text in rest if text in ("no", "yes")) for rest in frozen]
    assert one_pole == ["no", "yes"]
    assert "is beyond the single-pole theory" in shown.text
    assert "In w.csv only what blows within 10 s" in shown.text
    assert "Measured wind w.csv; the flight goes towards" in shown.text
    basis = [one for one in verdict.basis(result) if isinstance(one, str)]
    assert any("counts all deflections of the nozzle" in one for one in basis)
    case = section(result, "inputs").values
    worst = float(result.study.gust.onset)
    assert (case["gust.peak_deg"], case["gust.begins"]) == (pytest.approx(1.0), worst)
    (tmp_path / "s.toml").write_text(text.replace("azimuth_deg = 90", "azimuth_deg = 91"))
    turned = replace(result, plan=tv.load_study(tmp_path / "s.toml"))
    again = replace(result, plan=tv.load_study(tmp_path / "s.toml"))
    assert turned.seal == again.seal != result.seal


@pytest.mark.thorough
@pytest.mark.usefixtures("few_durations")
def test_a_page_does_not_call_a_flight_above_its_sounding_enough(tmp_path) -> None:
    """The wind is known to 12 km, and the limit is enough up to there."""
    (tmp_path / "w.csv").write_text("height_m,east_m_per_s,north_m_per_s\n0,0,0\n12000,20,0\n")
    text = (
        '[study]\nvehicle = "configuration-i"\n[[wind]]\npeak_deg = 2\nduration_s = 7.5\n'
        '[[wind]]\nsounding = "w.csv"\nazimuth_deg = 90\n[nozzle]\nlimit_deg = 0.6\n'
        "[size]\nfrom_s = 60\nto_s = 80\nevery_s = 20\n"
    )
    (tmp_path / "s.toml").write_text(text)
    computed = find(tv.load_study(tmp_path / "s.toml"))
    result = CliRunner().invoke(app, ["report", f"{tmp_path}/s.toml", "-o", f"{tmp_path}/p.html"])
    said = "".join(part for part in verdict.sentence(computed) if isinstance(part, str))

    assert [question.yes for question in questions(computed)] == [True, None]
    assert said.startswith("NOT KNOWN: ")
    assert "required deflection of the whole flight of configuration-i not known above" in said
    assert "Required deflection NOT KNOWN above 12.0 km" in section(computed, "flight").text
    assert (result.exit_code, "NOT KNOWN: " in result.output) == (1, True)


@pytest.mark.thorough
def test_a_gust_is_in_the_response_and_the_wind_of_the_autopilot(
    plan: tv.studyfile.StudyPlan,
) -> None:
    gust = tv.OneMinusCosineGust(peak=np.radians(1.0), duration=2.0).shift(2.75)
    wind = replace(plan.wind, gust=gust, gust_at=3.75)
    gusty = replace(plan, wind=wind, laws=None, sizing=None, dispersions=None)
    result = find(gusty)
    shown = section(result, "response").values
    both = result.study.wind + gust
    plant = tv.Plant.from_vehicle(plan.vehicle, "fixed-path")
    deflection = tv.trim_then_hold(plant, both, -np.radians(0.4), 1.0)
    times = np.linspace(0.0, shown["response.at_end_s"], 8001)
    attitude = np.degrees(tv.attitude_responses(plant, deflection, both, times)["attitude"])
    flown = tv.compare_with_trim(plant, plan.autopilot, both)

    assert shown["response.with_wind_deg"] == pytest.approx(attitude.min(), rel=1e-4)
    assert result.comparison.peak_deflection == flown.peak_deflection
    assert any("with a gust of 1 deg and 2 s" in str(one) for one in verdict.basis(result))


def test_shortfall_and_remaining_over_the_flight_are_one_number_each(
    plan: tv.studyfile.StudyPlan,
) -> None:
    once = replace(plan.sizing, start=60.0, stop=60.0)
    fixed = tv.studyfile.StudyPlan(
        vehicle=plan.vehicle, model="fixed-path", nozzle=plan.nozzle, sizing=once, sign="frozen"
    )
    short = find(fixed)
    wide = np.radians(0.9)
    sufficient = find(replace(fixed, nozzle=tv.Nozzle(limit=wide), sizing=once))
    heading = [one for one in verdict.sentence(short) if isinstance(one, Number)]
    headline = {one.name: one.text for one in heading}
    shown = {name: said for name, (_, said) in section(short, "flight").numbers.items()}
    tiles = {name: said for name, (_, said) in section(short, "questions").numbers.items()}

    assert headline["verdict.surplus_deg"] == shown["total.short_deg"]
    assert tiles["answer.whole_flight.required_deg"] == headline["verdict.required_deg"]
    assert tiles["answer.wind.required_deg"] == "0.368"
    assert verdict.sentence(short)[0] == "NOT SUFFICIENT: the limit of "
    assert "the whole flight of configuration-i requires" in text(verdict.sentence(short))
    total = sufficient.flight[1]
    left = np.degrees(total.limit - total.total / 0.9)
    page = section(sufficient, "flight")
    tiles = {name: said for name, (_, said) in section(sufficient, "questions").numbers.items()}
    assert page.values["total.remaining_deg"] == pytest.approx(left, rel=1e-12)
    assert "remaining after the reserve" in page.text
    remaining = page.numbers["total.remaining_deg"][1]
    assert tiles["answer.whole_flight.remaining_deg"] == remaining


@pytest.mark.thorough
@pytest.mark.usefixtures("few_durations")
def test_a_flight_of_another_vehicle_is_told_wherever_it_counts(tmp_path: Path) -> None:
    text = '[study]\nvehicle = "my.toml"\n[wind]\npeak_deg = 5\nduration_s = 7.5\n'
    text += "[nozzle]\nlimit_deg = 0.4\n[size]\nfrom_s = 60\nto_s = 60\n"
    (tmp_path / "my.toml").write_text(template())
    study, output = tmp_path / "s.toml", tmp_path / "r.html"
    study.write_text(f'{text}[schedule]\nsource = "configuration-i"\n')
    said = "the flight is of configuration-i, not of the study's vehicle, my.toml; give its flight"
    request = tv.studyfile.load_sizing(study).sizing
    result = CliRunner().invoke(app, ["report", str(study), "-o", str(output)])
    sized = CliRunner().invoke(app, ["ascent", str(study)])
    answered = CliRunner().invoke(app, ["study", str(study)])
    document = json.loads(CliRunner().invoke(app, ["study", str(study), "--json"]).stdout)

    assert (request.source, request.another) == ("configuration-i", "my.toml")
    assert output.read_text().count(said[1:].replace("'", "&#39;")) == 2
    assert f"\nNote: {said}" in result.output
    assert f"\nNote: {said}" in sized.output
    assert f"\nNote: {said}" in answered.output
    assert any(note.startswith(said) for note in document["notes"])


def test_a_flight_without_an_answer_says_why(plan: tv.studyfile.StudyPlan) -> None:
    late = tv.studyfile.StudyPlan(vehicle=plan.vehicle, sizing=replace(plan.sizing, stop=900.0))
    (said,) = section(find(late), "flight").of("p")
    assert said.startswith("There is no answer: time must be between 41 and 116 s")


@pytest.mark.usefixtures("few_durations")
def test_what_no_page_can_hold_is_replaced() -> None:
    vehicle = tv.load_vehicle("configuration-i")
    object.__setattr__(vehicle, "name", "a\0b\x1b[31m\u202ec")
    html = tv.report_html(
        tv.Study.from_vehicle(vehicle, duration=7.5, peak=0.08, model="fixed-path")
    )

    assert "a\ufffdb\ufffd[31m\ufffdc: deflection study" in html
    assert all(one.isprintable() or one in "\n\t" for one in html)


@pytest.mark.parametrize(
    ("limit", "said"),
    [
        (
            0.3,
            "NOT SUFFICIENT: the limit of 0.300 deg is 0.112 deg (27.1 %) short of the 0.412 deg",
        ),
        (None, "In this wind the ideal trim law requires 0.412 deg of deflection."),
    ],
)
def test_the_verdict_says_by_how_much(limit: float | None, said: str) -> None:
    vehicle = tv.load_vehicle("configuration-i")
    limit = None if limit is None else np.radians(limit)
    heading = verdict.sentence(
        find(tv.studyfile.StudyPlan(vehicle=vehicle, nozzle=tv.Nozzle(limit=limit)))
    )
    words = "".join(one if isinstance(one, str) else one.text for one in heading)

    assert words.startswith(said)


def test_a_wind_too_long_for_one_pole_is_told_beside_the_verdict(
    plan: tv.studyfile.StudyPlan,
) -> None:
    edge = tv.boundary.single_pole_validity(tv.Coefficients.from_vehicle(plan.vehicle))
    for duration, noted in ((0.999 * edge, False), (1.001 * edge, True)):
        long = tv.studyfile.StudyPlan(
            vehicle=plan.vehicle, wind=replace(plan.wind, duration=duration)
        )
        doubts = [
            text(assumption.line)
            for assumption in assumptions(find(long))
            if assumption.state == "doubt"
        ]
        assert any("slow motion" in doubt for doubt in doubts) is noted


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("change", "duration", "dead_band", "said"),
    usual(
        [
            ({}, 60.0, 0.5, "survived with a control that lets go of it"),
            ({"velocity": 45.0, "attitude": 1.5}, 7.5, 1.0, "Trim stays within the limit"),
        ],
        0,
    ),
)
def test_the_figure_of_a_limit_that_is_enough_does_not_contradict_it(
    plan: tv.studyfile.StudyPlan,
    change: dict[str, float],
    duration: float,
    dead_band: float,
    said: str,
) -> None:
    request = tv.studyfile.StudyPlan(
        vehicle=plan.vehicle.replace(**change),
        wind=replace(plan.wind, duration=duration),
        model="drift-exact",
        dead_band=dead_band,
        nozzle=tv.Nozzle(limit=np.radians(0.5)),
    )
    result = find(request)

    assert result.study.sufficient
    assert said in section(result, "response").of("figcaption")[0]


def test_a_page_says_where_no_limit_is_enough(plan: tv.studyfile.StudyPlan) -> None:
    slow = plan.vehicle.replace(velocity=45.0, attitude=1.5)
    request = tv.studyfile.StudyPlan(
        vehicle=slow,
        wind=plan.wind,
        model="drift-exact",
        dead_band=0.0,
        nozzle=tv.Nozzle(limit=0.1),
    )
    result = find(request)

    assert dict(verdict.facts(result))["required deflection"] == ("none is sufficient",)
    assert section(result, "boundaries").of("td").count("none is sufficient") == 2
    assert [question.text for question in questions(result)] == [
        "with this dead band no limit is sufficient"
    ]
    endless = find(replace(request, nozzle=tv.Nozzle()))
    assert verdict.sentence(endless)[0].startswith(
        "NOT SUFFICIENT: with this dead band no limit is"
    )
    assert not section(endless, "response").text


def test_the_page_tells_every_doubt_of_the_study(plan: tv.studyfile.StudyPlan) -> None:
    long = tv.studyfile.StudyPlan(
        vehicle=plan.vehicle,
        wind=replace(plan.wind, duration=60.0),
        model="drift-exact",
        dead_band=0.5,
        nozzle=tv.Nozzle(limit=np.radians(0.2)),
    )
    result = find(long)
    assumptions = section(result, "assumptions").text

    assert len(result.study.notes) == 4
    assert all(as_sentence(note) in assumptions for note in result.study.notes)
    beside = "".join(one for one in verdict.basis(result) if isinstance(one, str))
    assert "trusts a forecast of the wind" in beside


@pytest.mark.thorough
@pytest.mark.usefixtures("few_durations")
def test_the_page_has_what_a_head_and_a_tail_wind_need() -> None:
    vehicle = tv.load_vehicle("configuration-i")
    limit = tv.Nozzle(limit=np.radians(0.4))
    page = Page(tv.report_html(tv.studyfile.StudyPlan(vehicle=vehicle, nozzle=limit)))
    study = tv.Study.of(tv.Case(vehicle=vehicle, nozzle=limit))
    needs = {name: np.degrees(one) for name, one in study.encountered.items()}

    shown = {name: page.numbers[f"{name}_wind.drift-exact_deg"][0] for name in needs}
    assert shown == pytest.approx(needs, rel=1e-12)
    assert page.numbers["facts.required_deg"][0] == pytest.approx(needs["head"], rel=1e-12)
    peak = np.radians(page.numbers["facts.survivable_peak_deg"][0])
    there = tv.Study.from_vehicle(vehicle, duration=7.5, peak=peak)
    assert there.required_deflection == pytest.approx(np.radians(0.4), rel=1e-7)
    assert any("the dynamic pressure in a head wind" in one for one in page.texts)


@pytest.mark.thorough
@pytest.mark.usefixtures("few_durations")
def test_where_the_autopilot_decides_the_page_survives_what_its_flight_survives() -> None:
    """In calm air it scales with its wind; in a head wind the dynamic pressure grows with it."""
    vehicle, limit = tv.load_vehicle("configuration-i"), np.radians(0.2)
    nozzle, design = tv.Nozzle(limit=limit), tv.AutopilotDesign(design="canonical")
    calm = tv.studyfile.StudyPlan(vehicle=vehicle, nozzle=nozzle, design=design, sign="frozen")
    peaks = {}
    for plan in (calm, replace(calm, sign=None)):
        (peak, *_) = Page(tv.report_html(plan)).numbers["facts.survivable_peak_deg"]
        peaks[plan.sign] = float(peak)
    result = find(calm)
    expected = 5.0 * limit / abs(result.stop.deflection)
    assert peaks["frozen"] == pytest.approx(expected, rel=1e-12)

    angle, path = -np.radians(peaks[None]), float(vehicle.attitude)
    against = np.sin(angle) / np.sin(path + angle)
    more = (np.cos(path) - against) ** 2 + np.sin(path) ** 2
    denser = vehicle.replace(
        normal_force_slope=vehicle.normal_force_slope * more,
        axial_force=vehicle.axial_force * more,
    )
    wind = tv.TriangularWind(peak=-angle, duration=calm.wind.duration)
    law = tv.SaturatedLaw(replace(result.comparison.autopilot, actuator=None, delay=0.0))
    plant = tv.Plant.from_vehicle(denser, calm.model)
    minimum = tv.closed_loop_boundary(plant, law, wind, **calm.hardware).deflection
    assert abs(minimum) == pytest.approx(limit, rel=1e-4)
    assert peaks[None] < 0.95 * peaks["frozen"]


def test_a_notebook_shows_a_short_table() -> None:
    vehicle = tv.load_vehicle("configuration-i").replace(name="<b>")
    study = tv.Study.from_vehicle(
        vehicle, duration=7.5, peak=np.radians(5), limit=np.radians(0.3), model="fixed-path"
    )
    page = Page(study._repr_html_())

    assert "<b>" in page.texts
    assert {f"{np.degrees(study.required_deflection):.3f}", "no"} <= set(page.texts)


@pytest.mark.thorough
@pytest.mark.usefixtures("few_durations")
def test_a_stable_vehicle_has_a_page_too(plan: tv.studyfile.StudyPlan) -> None:
    stable = plan.vehicle.replace(aerodynamic_arm=-2.0)
    html = tv.report_html(replace(plan, vehicle=stable))

    assert "that the whole flight of configuration-i requires" in html
    assert html.count("There is no answer:") == 2
    assert "No deflection is needed" in tv.report_html(
        tv.studyfile.StudyPlan(vehicle=stable, model="fixed-path", nozzle=tv.Nozzle(limit=0.01))
    )


@pytest.mark.usefixtures("few_durations")
def test_the_command_writes_the_page_and_exits_by_the_verdict(tmp_path: Path) -> None:
    text = '[study]\nvehicle = "configuration-i"\n[wind]\npeak_deg = 5\nduration_s = 7.5\n'
    study, output = tmp_path / "study.toml", tmp_path / "report.html"
    study.write_text(text + "[nozzle]\nlimit_deg = 0.3\n")
    result = CliRunner().invoke(app, ["report", str(study), "-o", str(output)])

    assert result.exit_code == 1
    assert "<h1>NOT SUFFICIENT: the limit of " in output.read_text()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[study]\nvehicle = "configuration-i"\nlimt = 1\n', "unknown key in .study.: 'limt'"),
        ("[studdy]\n", "did you mean study"),
        ('[study]\nvehicle = "gone.toml"\n', "gone.toml does not exist"),
        ("[study\n", "not valid TOML"),
    ],
)
def test_a_bad_study_writes_nothing(tmp_path: Path, text: str, message: str) -> None:
    study, output = tmp_path / "study.toml", tmp_path / "report.html"
    study.write_text(text)
    result = CliRunner().invoke(app, ["report", str(study), "-o", str(output)])

    assert result.exit_code == 2
    assert re.search(message, result.stderr)
    assert result.stderr.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["study.toml"]


def test_a_folder_that_is_not_there_is_told() -> None:
    result = CliRunner().invoke(app, ["report", "-o", "/nowhere/at/all/x.html"])

    assert result.exit_code == 2
    assert "/nowhere/at/all/x.html cannot be written" in result.stderr


@pytest.mark.thorough
@pytest.mark.usefixtures("few_durations")
def test_the_page_says_what_the_limit_leaves_of_the_margins(plan: tv.studyfile.StudyPlan) -> None:
    short = replace(plan, laws=None, sizing=None, dispersions=None)
    sufficient, computed = page_of(replace(short, nozzle=tv.Nozzle(limit=np.radians(0.9))))
    loop = computed.comparison
    assert loop is not None
    law = tv.SaturatedLaw(replace(loop.autopilot, actuator=None, delay=0.0))
    flown = tv.flights.flown_margins(
        loop.plant,
        law,
        computed.study.wind,
        limit=np.radians(0.9),
        actuator=loop.autopilot.actuator,
        delay=float(loop.autopilot.delay),
        sample_rate=100.0,
    )
    part = sufficient[sufficient.index("Margins with the limit in this wind") :]
    shown = " ".join(re.sub(r"<[^>]*>", " ", part[:6000]).split())
    assert f"{flown.gain_fall.dB:.2f} dB" in shown
    assert f"{1000 * flown.delay.value:.1f} ms" in shown
    assert "With this limit no margin remains in this wind" in tv.report_html(short)
