"""Every question of a study file has its answer, and the worst one is the verdict."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

import tvclin as tv
from tests.show.pages import Page
from tests.turns import usual
from tvclin.base.lines import text
from tvclin.base.quantities import NO_LIMIT
from tvclin.cli.app import app
from tvclin.studyfile import verdict
from tvclin.studyfile.findings import Findings, find
from tvclin.studyfile.questions import all_yes, questions, sufficient
from tvclin.studyfile.verdict import questions_table

SPREAD = tv.Dispersions((tv.Dispersion("normal_force_slope", "truncated", 0.1),))
LOOSE = tv.control.Criteria.custom("loose", aero_margin_dB=3.0)
GAINS = tv.AutopilotDesign(attitude_gain=0.6, rate_gain=0.8)
DESIGN = tv.AutopilotDesign(design="poles", natural_frequency=2.0, damping=0.8)


def found_for(limit_deg: float | None, **changes: object) -> Findings:
    limit = None if limit_deg is None else float(np.radians(limit_deg))
    plan = tv.studyfile.StudyPlan(
        vehicle=tv.load_vehicle("configuration-i"),
        nozzle=tv.Nozzle(limit=limit),
        cases=400,
        sign="frozen",
    )
    return find(replace(plan, **changes))


def headline(findings: Findings) -> str:
    line = verdict.sentence(findings)
    return "".join(one if isinstance(one, str) else one.text for one in line)


NO = ("NOT SUFFICIENT", "NOT MET", "NOT SURVIVED")


def answers(findings: Findings) -> dict[str, bool | None]:
    return {question.name: question.yes for question in questions(findings)}


def test_a_limit_that_covers_the_wind_alone_is_not_sufficient_for_a_probability() -> None:
    result = found_for(0.4, dispersions=SPREAD, probability=0.99, model="fixed-path")
    assert answers(result) == {"wind": True, "probability": False}
    assert headline(result).endswith(
        " deg that 99 % of flights require; SUFFICIENT for the 0.368 deg that the ideal trim law"
        " requires in this wind."
    )
    wide = found_for(0.6, dispersions=SPREAD, probability=0.99, model="fixed-path")
    assert answers(wide) == {"wind": True, "probability": True}
    assert headline(wide).startswith("SUFFICIENT")


@pytest.mark.thorough
@pytest.mark.usefixtures("few_durations")
def test_study_report_and_page_have_one_headline(tmp_path) -> None:
    """An autopilot that requires more than the ideal law, whose requirement the limit covers."""
    file, page = tmp_path / "s.toml", tmp_path / "p.html"
    file.write_text(
        '[study]\nvehicle = "configuration-i"\nsign = "frozen"\nmodel = "fixed-path"\n'
        "[wind]\npeak_deg = 5\nduration_s = 7.5\n"
        '[nozzle]\nlimit_deg = 0.4\n[autopilot]\ndesign = "canonical"\n'
    )
    study, report = (
        " ".join(CliRunner().invoke(app, [*words, str(file)]).output.split())
        for words in (("study",), ("report", "-o", str(page)))
    )
    first = study.partition(" Every question")[0]
    assert report.removeprefix(f"Wrote {page}. ").startswith(first)
    assert first in Page(page.read_text()).text.replace("\xa0", " ")
    assert first.startswith("NOT SUFFICIENT: the limit of 0.400 deg is ")
    assert "; SUFFICIENT for the 0.368 deg that the ideal trim law requires in this wind" in first
    assert first.endswith("; also NOT MET: margins.")


def test_the_table_of_all_questions_shows_the_worst_first_and_what_is_left() -> None:
    result = found_for(0.4, dispersions=SPREAD, probability=0.99, model="fixed-path", design=DESIGN)
    rows = {text(row[0]): [text(cell) for cell in row[1:]] for row in questions_table(result).rows}
    parts = {
        question.name: question.measure.required / question.measure.available
        for question in questions(result)
    }
    ranks = [(rows[name][0] not in NO, -parts[name]) for name in rows]
    assert ranks == sorted(ranks)
    for question in questions(result):
        needed, there, left = (float(cell.split()[0]) for cell in rows[question.name][1:4])
        assert left == pytest.approx(there - needed, abs=1.01e-3)
        if question.required_deflection == question.required_deflection:  # a deflection
            assert needed == pytest.approx(
                float(np.degrees(question.required_deflection)), abs=5.01e-4
            )
            assert there == 0.4


@pytest.mark.parametrize(
    ("peak_deg", "limit_deg", "rate_deg", "gains", "not_known"),
    usual(
        [
            (9.0, 0.9, 0.3, None, {"nozzle rate"}),
            (14.0, 1.3, 1.0, GAINS, {"nozzle rate", "autopilot"}),
        ],
        0,
    ),
)
def test_nothing_remains_of_a_limit_where_the_answer_is_not_known(
    peak_deg, limit_deg, rate_deg, gains, not_known
) -> None:
    """An upper bound is above the limit: the dynamic pressure at a head wind's peak throughout.

    In a wind of 14 deg no limit survives with that pressure, which is no answer either.
    """
    wind = tv.ShapedWind("triangular", peak=np.radians(peak_deg), duration=7.5)
    nozzle = tv.Nozzle(limit=np.radians(limit_deg), rate_limit=np.radians(rate_deg))
    result = found_for(None, wind=wind, nozzle=nozzle, design=gains, sign="head")
    rows = {text(row[0]): [text(cell) for cell in row[1:]] for row in questions_table(result).rows}
    assert {name for name, row in rows.items() if row[0] == "NOT KNOWN"} == not_known
    assert {name for name, row in rows.items() if not row[3]} == not_known
    if "autopilot" in not_known:
        _, required, _, _, why = rows["autopilot"]
        assert required == ""
        assert why.startswith(f"autopilot requirement: {NO_LIMIT}, with the")


def test_too_few_cases_are_no_yes() -> None:
    result = found_for(
        3.0, dispersions=SPREAD, model="fixed-path"
    )  # 400 cases cannot speak of 99.865 percent
    assert answers(result) == {"wind": True, "probability": None}
    assert sufficient(result) is None
    assert not all_yes(result)
    assert headline(result).startswith("NOT KNOWN: too few cases")
    assert "99.865 % of flights: cases must be at least 1705" in headline(result)


@pytest.mark.thorough
def test_every_answer_in_a_wind_whose_pressure_is_not_known_is_not_known() -> None:
    """On a path of 4 deg, which no head wind turns by 5 deg."""
    vehicle = tv.load_vehicle("configuration-i").replace(attitude=np.radians(4.0))
    changes = {"vehicle": vehicle, "design": DESIGN, "criteria": LOOSE}
    result = found_for(0.9, **changes, sign=None)
    assert result.study.required_deflection < result.study.limit
    shown = answers(result)
    assert shown["margins"] is True
    assert {shown.pop("wind"), shown.pop("autopilot")} == {None}
    assert headline(result).startswith("NOT KNOWN: the requirement at the pressure encountered")
    assert answers(found_for(0.9, vehicle=vehicle))["wind"] is True  # at nominal dynamic pressure


def test_few_cases_suffice_to_refuse_a_limit_that_covers_a_part_of_them() -> None:
    result = found_for(0.36, dispersions=SPREAD, model="fixed-path")
    success = result.dispersed.success
    assert 0.0 < success.estimate < success.upper < 0.99865
    assert np.isinf(result.dispersed.required.upper)
    assert answers(result)["probability"] is False
    shown = f"sufficient in at most {100 * success.upper:.2f} %, not in 99.865 % of flights"
    assert {question.name: question.text for question in questions(result)}["probability"] == shown


@pytest.mark.thorough
def test_an_autopilot_is_judged_by_its_flight_with_the_limit_as_its_stop() -> None:
    """A linear peak above the limit is no loss where the flight survives, and a note says so."""
    result = found_for(0.5, design=DESIGN, criteria=LOOSE)
    loop, wind = result.comparison, result.study.wind
    law = tv.SaturatedLaw(replace(loop.autopilot, actuator=None, delay=0.0))
    nozzle = {"actuator": loop.autopilot.actuator, "sample_rate": 100.0}
    asks = np.degrees(loop.peak_deflection)
    needs = np.degrees(abs(result.stop.deflection))
    assert needs < asks
    for part, survives in ((0.98, False), (1.02, True)):
        limit = float(np.radians(part * needs))
        flown = tv.fly_many(loop.plant, law, wind, deflection_limit=limit, **nozzle)
        assert (str(flown.status) == "survived") is survives
        result = found_for(part * needs, design=DESIGN, criteria=LOOSE)
        assert answers(result)["autopilot"] is survives
    basis = "".join(str(getattr(one, "text", one)) for one in verdict.basis(result))
    assert f"would turn the nozzle by {asks:.3f} deg, more than the limit" in basis
    assert f"more than the {needs:.3f} deg that this autopilot requires" in headline(result)
    wide = found_for(1.01 * asks, design=DESIGN, criteria=LOOSE)
    assert "more than the limit" not in str(verdict.basis(wide))
    (said,) = (question for question in questions(wide) if question.name == "autopilot")
    assert said.measure.required == pytest.approx(needs, rel=1e-12)
    assert f"without a limit the autopilot would turn the nozzle by {asks:.3f} deg" in said.text


@pytest.mark.thorough
def test_an_autopilot_that_its_rate_limit_loses_is_not_enough() -> None:
    """With every limit that is tried, and its peak without stop and rate limit below the limit."""
    design = tv.AutopilotDesign(design="half-relief")
    slow = tv.Nozzle(limit=np.radians(0.42), rate_limit=np.radians(0.2))
    result = found_for(None, nozzle=slow, design=design)
    loop, limit = result.comparison, slow.limit
    assert loop.peak_deflection < limit
    assert loop.peak_deflection_rate > slow.rate_limit
    (said,) = (question for question in questions(result) if question.name == "autopilot")
    assert said.yes is False
    assert np.isinf(said.measure.required)
    rate = np.degrees(loop.peak_deflection_rate)
    assert said.text.endswith(f"at {rate:.3f} deg/s")
    assert result.autopilot_survives == 0.0
    law = tv.SaturatedLaw(replace(loop.autopilot, actuator=None, delay=0.0))
    nozzle = {"actuator": tv.Actuator(), "sample_rate": 100.0, "rate_limit": slow.rate_limit}
    flown = tv.fly_many(loop.plant, law, result.study.wind, deflection_limit=limit, **nozzle)
    assert str(flown.status) == "lost"
    wide = found_for(None, nozzle=replace(slow, limit=np.radians(20.0)), design=design)
    assert answers(wide)["autopilot"] is False  # nor is a limit beyond those tried at first


def flown_in_a_head_wind(findings: Findings, limit: float, size: float = 1.0) -> float:
    """Return the attitude [rad] long after a wind, flown at the dynamic pressure encountered."""
    vehicle, wind, loop = findings.plan.vehicle, findings.study.wind * size, findings.comparison
    path, sign = float(vehicle.attitude), np.sign(float(wind.peak))

    def plant(ratio: float) -> tv.Plant:
        more = {
            "normal_force_slope": vehicle.normal_force_slope * ratio,
            "axial_force": vehicle.axial_force * ratio,
        }
        return tv.Plant.from_vehicle(vehicle.replace(**more), findings.plan.model)

    ends = [[np.asarray(matrix) for matrix in plant(ratio).matrices()[:2]] for ratio in (1.0, 2.0)]

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        angle = float(wind(t)) if t < float(wind.end) else 0.0
        against = np.sin(-sign * angle) / np.sin(path - sign * angle)
        ratio = (np.cos(path) - against) ** 2 + np.sin(path) ** 2
        A, inputs = (end + (ratio - 1.0) * (two - end) for end, two in zip(*ends, strict=True))
        request = loop.autopilot.attitude_gain * x[0] + loop.autopilot.rate_gain * x[1]
        return A @ x + inputs @ np.array([np.clip(request, -limit, limit), angle])

    span = (0.0, float(wind.end) + 20.0)
    gone = solve_ivp(rates, span, np.zeros(3), rtol=1e-6, atol=1e-8, max_step=0.1)
    return abs(float(gone.y[0, -1]))


@pytest.mark.thorough
def test_an_autopilot_is_judged_in_the_air_that_a_head_wind_meets() -> None:
    """What survives at nominal pressure alone is lost there; what is sufficient survives."""
    design = tv.AutopilotDesign(design="poles", natural_frequency=1.1, damping=0.7)
    result = found_for(0.5, sign=None, design=design, criteria=LOOSE)
    calm, head = (abs(float(one.deflection)) for one in (result.stop, result.head.stop))
    assert np.degrees([calm, head]).round(3).tolist() == [0.451, 0.585]  # as in docs/limits.md
    assert flown_in_a_head_wind(result, 1.05 * calm) > 1.0
    assert flown_in_a_head_wind(result, head) < 1e-2
    request = found_for(np.degrees(0.98 * head), sign=None, design=design, criteria=LOOSE)
    assert answers(request)["autopilot"] is None
    assert sufficient(request) is None
    assert 0.9 < request.autopilot_survives < 1.0
    enough = found_for(np.degrees(1.1 * head), sign=None, design=design, criteria=LOOSE)
    assert answers(enough)["autopilot"] is True
    size = enough.autopilot_survives
    assert 1.02 < size < 1.1
    assert flown_in_a_head_wind(enough, 1.1 * head, size) < 1e-2
    tail = found_for(np.degrees(1.02 * calm), sign="tail", design=design, criteria=LOOSE)
    assert tail.head is None
    assert answers(tail)["autopilot"] is True


@pytest.mark.thorough
def test_samples_and_the_rate_limit_of_the_nozzle_count_in_margins_and_flights() -> None:
    plain = found_for(0.5, design=DESIGN, criteria=LOOSE)
    design = replace(DESIGN, sample_rate=20.0)
    nozzle = tv.Nozzle(limit=np.radians(0.5), rate_limit=np.radians(0.4))
    result = found_for(0.5, design=design, nozzle=nozzle, criteria=LOOSE)
    loop, before = result.comparison, plain.comparison
    expected = loop.autopilot.margins(loop.plant)
    assert loop.margins.phase_margin_deg == expected.phase_margin_deg
    assert loop.margins.phase_margin_deg < before.margins.phase_margin_deg - 1.0
    assert (
        loop.peak_deflection == before.peak_deflection
    )  # of the continuous autopilot, as a note says
    assert "peaks are of the continuous autopilot" in " ".join(loop.notes)
    law = tv.SaturatedLaw(replace(loop.autopilot, actuator=None, delay=0.0, sample_rate=None))
    flown = {"actuator": tv.Actuator(), "sample_rate": 20.0, "rate_limit": nozzle.rate_limit}
    boundary = tv.closed_loop_boundary(loop.plant, law, result.study.wind, **flown)
    assert result.stop.deflection == boundary.deflection
    assert abs(boundary.deflection) > 1.05 * abs(plain.stop.deflection)


@pytest.mark.thorough
def test_margins_that_are_not_met_are_no_with_or_without_a_limit() -> None:
    strict = tv.control.Criteria.custom("strict", aero_margin_dB=60.0)
    for limit in (3.0, None):
        result = found_for(limit, design=DESIGN, criteria=strict)
        assert answers(result)["margins"] is False
        assert sufficient(result) is False
        assert "does not meet the criteria strict" in headline(result)
    assert sufficient(found_for(None, design=DESIGN, criteria=LOOSE)) is None


@pytest.mark.thorough
def test_what_has_no_answer_is_no_yes() -> None:
    stable = tv.load_vehicle("configuration-i").replace(aerodynamic_arm=-2.0)
    result = found_for(0.4, vehicle=stable, sign=None, design=tv.AutopilotDesign(), criteria=LOOSE)
    assert answers(result) == {"wind": True, "autopilot": None, "margins": None}
    assert headline(result).startswith("NOT KNOWN: ")


@pytest.mark.thorough
@pytest.mark.usefixtures("few_durations")
@pytest.mark.parametrize(("limit", "code"), usual([(0.3, 1), (0.4, 1), (0.6, 0)], 1))
def test_study_and_report_exit_alike(tmp_path, limit: float, code: int) -> None:
    file = tmp_path / "s.toml"
    file.write_text(
        "[study]\nvehicle = 'configuration-i'\nmodel = 'fixed-path'\n"
        "[wind]\npeak_deg = 5\nduration_s = 7.5\n"
        f"[nozzle]\nlimit_deg = {limit}\n"
        "[question]\nprobability = 0.99\n[campaign]\ncases = 400\n[[dispersion]]\n"
        "parameter = 'normal_force_slope'\nshape = 'truncated'\npercent = 10\n"
    )
    page = ["report", str(file), "-o", str(tmp_path / "r.html")]
    for command in (["study", str(file)], ["study", str(file), "--json"], page):
        result = CliRunner().invoke(app, command)
        assert result.exit_code == code, result.output
        if "--json" in command:
            document = json.loads(result.stdout)
            assert document["all_answers_yes"] is (code == 0)
            assert [question["name"] for question in document["questions"]] == [
                "wind",
                "probability",
            ]


@pytest.mark.thorough
def test_flown_margins_are_refused_in_a_wind_of_too_many_samples() -> None:
    """1500 s at 100 Hz; the answers of a shell have no flown margins at all."""
    design = tv.AutopilotDesign(natural_frequency=1.1, damping=0.7)
    long = tv.ShapedWind("triangular", np.radians(1.0), 1500.0)
    plan = replace(tv.load_study("configuration-i"), design=design, wind=long, sign="frozen")
    plan = replace(plan, nozzle=tv.Nozzle(limit=np.radians(2.0)))
    result = find(plan)
    assert result.flown is None
    assert "at most 100000 samples, this one has 150000" in result.reasons["flown"]
    assert "flown" not in find(plan, omitted=("flown",)).reasons
