"""The page of a vehicle that bends and sloshes: its numbers are the library's, and judged."""

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import tvclin as tv
from tests.flexible import MODE_AND_TANK
from tests.show.pages import section
from tvclin.design import gain_designs
from tvclin.show.report.page import page_of
from tvclin.studyfile.findings import Findings, find
from tvclin.studyfile.parse import parse_study
from tvclin.studyfile.questions import questions, sufficient
from tvclin.studyfile.verdict import unjudged_values
from tvclin.vehicle.vehicle_file import read_vehicle_text

pytest.importorskip("jinja2")
pytest.importorskip("latex2mathml")

STUDY = """
[study]
vehicle = "my.toml"
[wind]
shape = "triangular"
peak_deg = 5
duration_s = 7.5
[nozzle]
limit_deg = 0.45
[autopilot]
natural_frequency_rad_per_s = 1.5
damping = 0.7
delay_ms = 10
[[autopilot.filter]]
kind = "notch"
frequency_Hz = 12
zero_damping = 0.05
pole_damping = 0.5
[criteria]
name = "classic"
mode_gain_margin_dB = 10
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a vehicle that bends and a study of it."""
    place = tmp_path_factory.mktemp("flexible")
    (place / "my.toml").write_text(read_vehicle_text("configuration-i")[0] + MODE_AND_TANK)
    (place / "all.toml").write_text(STUDY)
    return place


@pytest.fixture(scope="module")
def plan(folder: Path) -> tv.studyfile.StudyPlan:
    return tv.load_study(folder / "all.toml")


@pytest.fixture(scope="module")
def page(plan: tv.studyfile.StudyPlan) -> tuple[str, Findings]:
    return page_of(plan)


@pytest.fixture(scope="module")
def findings(page: tuple[str, Findings]) -> Findings:
    return page[1]


@pytest.fixture(scope="module")
def shown(findings: Findings) -> dict[str, float]:
    return section(findings, "flexible").values


def test_a_study_file_knows_the_structure_of_its_vehicle(plan, folder):
    assert plan.vehicle == tv.load_vehicle(folder / "my.toml")
    assert tv.load_study(folder / "my.toml").vehicle == plan.vehicle
    assert tv.load_study("configuration-i").vehicle.structure is None
    assert [limit.margin for limit in plan.criteria.limits][-1] == "mode_gain_margin_dB"


@pytest.mark.thorough
def test_the_section_shows_margins_by_band_and_modes_off_their_places(findings, shown, plan):
    plant = tv.FlexiblePlant.from_vehicle(plan.vehicle, plan.vehicle.structure, "drift-exact")
    autopilot = plan.autopilot
    bands = autopilot.band_margins(plant)
    assert shown["rigid.gain_increase_dB"] == pytest.approx(bands.rigid.gain_increase_dB, rel=1e-12)
    mode = bands.mode("bending 1")
    assert shown["band.0.gain"] == pytest.approx(mode.gain_margin_dB, rel=1e-12)
    off = tv.control.detuned(autopilot, plant, criteria=plan.criteria)
    for k in range(len(off.changes)):
        phase = off.margins.phase_margin_deg[k]
        assert shown.get(f"detuned.{k}.phase_margin_deg", np.nan) == pytest.approx(
            phase, rel=1e-12, nan_ok=True
        )
    assert shown["edge.0.lower"] == pytest.approx(off.stable_ranges[0].lower, rel=1e-12)
    moved = plant.shift()
    assert shown["flexible.shift.trim_price"] == pytest.approx(moved.trim_price, rel=1e-12)
    margin = section(findings, "margins").values
    assert margin["margin.gain_increase_dB"] == pytest.approx(bands.margins.gain_increase_dB)


@pytest.mark.thorough
def test_the_loop_can_be_built_again_from_the_numbers_of_the_page(findings, plan):
    shown, autopilot = section(findings, "margins").values, plan.autopilot
    assert shown["gains.attitude"] == autopilot.attitude_gain
    assert shown["gains.rate"] == autopilot.rate_gain
    assert shown["gains.actuator_frequency"] == autopilot.actuator.natural_frequency
    assert shown["gains.delay_ms"] == pytest.approx(1000.0 * autopilot.delay)
    assert autopilot.filters
    for k, one in enumerate(autopilot.filters, start=1):
        for side, powers in (("zeros", one.numerator), ("poles", one.denominator)):
            for j, root in enumerate(r for r in np.roots(powers) if r.imag > 0.0):
                size = shown[f"gains.filters.{k}.{side}.{j}.frequency"]
                assert size == pytest.approx(abs(root), rel=1e-12)
                damping = shown[f"gains.filters.{k}.{side}.{j}.damping"]
                assert damping == pytest.approx(-root.real / size, rel=1e-12)
        assert shown[f"gains.filters.{k}.rest"] == pytest.approx(one(0.0).real, rel=1e-12)


@pytest.mark.thorough
def test_the_section_shows_the_flight_with_limits_beside_the_rigid_vehicle(findings, shown, plan):
    plant = tv.FlexiblePlant.from_vehicle(plan.vehicle, plan.vehicle.structure, "drift-exact")
    gains = replace(plan.autopilot, actuator=None, delay=0.0)
    wind = tv.TriangularWind(peak=np.radians(5), duration=7.5)
    nozzle = {"actuator": tv.Actuator(), "sample_rate": 100.0, "delay": 0.01}
    law = tv.SaturatedLaw(gains)
    for k, one in enumerate((plant, plant.rigid)):
        minimum = tv.closed_loop_boundary(one, law, wind, **nozzle).deflection
        assert shown[f"flown.0.{k}_deg"] == pytest.approx(abs(np.degrees(minimum)))
        many = tv.fly_many(one, law, wind, deflection_limit=plan.nozzle.limit, **nozzle)
        rate = np.degrees(many.peak_deflection_rate)
        assert shown[f"flown.4.{k}_deg"] == pytest.approx(float(rate))
    answers = {question.name: question for question in questions(findings)}
    assert answers["flexible flight"].yes
    said = "flown at nominal dynamic pressure and 100 Hz the flexible vehicle survives"
    assert answers["flexible flight"].text == said
    assert answers["margins"].yes
    assert (
        "flexible vehicle meets the criteria classic, with mode gain margin 10 dB"
        in answers["margins"].text
    )


@pytest.mark.thorough
def test_the_whole_page_holds_the_section_and_what_went_in(page):
    html, findings = page
    assert 'id="flexible"' in html
    assert html.count("<svg") == 6
    inputs = section(findings, "inputs").values
    assert inputs["structure.bending.0.modal_mass"] == 5e4
    assert inputs["structure.slosh.0.station"] == 12.0
    assert "structure.slosh.0.frequency" not in inputs
    assert "the autopilot alone" in section(findings, "assumptions").text


@pytest.mark.thorough
def test_gains_are_sought_once_for_all_parts_of_a_study(plan, monkeypatch):
    sought, seek = [], gain_designs.specified_autopilot
    monkeypatch.setattr(
        gain_designs, "specified_autopilot", lambda *a, **k: sought.append(a) or seek(*a, **k)
    )
    findings = find(replace(plan, nozzle=tv.Nozzle()))
    assert len(sought) == 1
    assert findings.flexible.autopilot is findings.comparison.autopilot


@pytest.mark.thorough
def test_a_mode_that_is_not_held_is_a_verdict_of_no(plan):
    findings = find(replace(plan, design=replace(plan.design, filters=())))
    answers = {question.name: question for question in questions(findings)}
    assert sufficient(findings) is False
    for name in ("autopilot", "margins", "flexible flight"):
        assert answers[name].yes is False
    assert "its nozzle keeps oscillating" in answers["flexible flight"].text
    assert "flexible vehicle is not stable" in answers["autopilot"].text
    shown = section(findings, "flexible")
    assert "rigid.gain_increase_dB" not in shown.values
    assert "no limit in the range survives" in shown.text


@pytest.mark.thorough
def test_a_vehicle_alone_says_what_its_margins_need(folder):
    findings = find(tv.load_study(folder / "my.toml"))
    said = section(findings, "flexible").of("p")[-1]
    assert "require an autopilot: [autopilot] in a study file" in said
    assert [question.name for question in questions(findings)] == []
    assert not section(find(tv.load_study("configuration-i")), "flexible").text


def test_what_is_asked_of_modes_needs_modes():
    document = tomllib.loads(STUDY) | {"study": {"vehicle": "configuration-i"}}
    with pytest.raises(tv.InputError, match=r"the vehicle needs \[\[bending\]\] or \[\[slosh\]\]"):
        parse_study(document)


def test_a_loop_that_a_flexible_vehicle_cannot_have_is_a_reason_and_no_page_is_lost():
    heavy = tv.load_study("made-up-booster")
    plan = replace(heavy, design=tv.AutopilotDesign(), nozzle=tv.Nozzle(limit=0.1, actuator=None))
    findings = find(plan)
    assert "second order" in findings.reasons["flexible"]
    answers = {question.name: question for question in questions(findings)}
    assert answers["margins"].yes is None
    assert answers["flexible flight"].yes is None
    assert "second order" in section(findings, "flexible").of("p")[-1]


@pytest.mark.thorough
def test_laws_are_flown_at_the_rate_that_is_asked_for(plan):
    """With an actuator of 25.1 rad/s, of any number of samples in its time."""
    for rate in (20.0, 50.0, 60.0):
        laws = tv.design.LawsRequest(names=("trim",), sample_rate=rate)
        findings = find(replace(plan, laws=laws, design=None, criteria=None, nozzle=tv.Nozzle()))
        assert f"sampled at {rate:g} Hz" in section(findings, "laws").text


@pytest.mark.thorough
def test_the_nominal_loop_is_no_change_and_unstable_changes_are_named_first(findings):
    off = findings.flexible.detuned
    nominal, *changes = off.changes
    margins = ("phase_margin_deg", *["phase_margin_deg"] * (len(changes) - 1), "unstable")
    missed = replace(off, critical_margin=margins, satisfied=np.zeros(len(margins), dtype=bool))
    flexible = replace(findings.flexible, detuned=missed)
    values = {v.name: v for v in unjudged_values(replace(findings, flexible=flexible))}
    assert values["modes detuned"].text == (
        f"{len(changes)} of {len(changes)} changes of one mode miss the criteria; UNSTABLE:"
        f" {changes[-1]}; margins too small: {', '.join(changes[:3])}, ..."
    )
    assert nominal == "nominal"


@pytest.mark.thorough
def test_a_flight_without_the_structure_of_the_vehicle_is_not_known_to_have_its_margins(
    plan: tv.studyfile.StudyPlan,
) -> None:
    """The loop along it is rigid: it survives and has its margins, and the vehicle bends."""
    schedule = tv.load_schedule("configuration-i")
    sizing = tv.requirement.SizingRequest(schedule=schedule, start=66.0, stop=68.0, every=2.0)
    nozzle = replace(plan.nozzle, limit=np.radians(3.0))
    along = replace(plan, sizing=sizing, nozzle=nozzle, criteria=None)
    yes = {}
    for structure in (plan.vehicle.structure, None):
        rigid = replace(along, vehicle=along.vehicle.replace(structure=structure))
        asked = questions(find(rigid))
        yes[structure is None] = {
            one.name: one.yes for one in asked if one.name.endswith("the flight")
        }
    names = "margins over the flight", "autopilot along the flight"
    assert [yes[False][name] for name in names] == [None, None]
    assert [yes[True][name] for name in names] == [True, True]
