"""Campaigns that fly dispersed vehicles along a whole flight."""

import json
from dataclasses import replace

import numpy as np
import pytest

import tvclin as tv
from tests.whole_flight import autopilot, flight, write_flight
from tvclin import InputError
from tvclin.control import ModeNotch
from tvclin.ensembles import Dispersion, Dispersions, FlightPlan, SoundingEnsemble
from tvclin.ensembles.campaign.case_replay import replay_case
from tvclin.ensembles.campaign.cases import evaluate
from tvclin.ensembles.campaign.folder import read, written
from tvclin.ensembles.campaign.results import ResultsInMemory
from tvclin.ensembles.campaign.summary import CampaignSummary
from tvclin.flights import fly_along, fly_many_along
from tvclin.vehicle import Filter
from tvclin.winds.shaped import ShapedWind

LIMIT, RATE = np.radians(0.45), 0.3
SPREAD = Dispersions(
    (
        Dispersion("normal_force_slope", "normal", 0.1),
        Dispersion("attitude", "normal", 0.01, relative=False),
        Dispersion("attitude_gain", "uniform", 0.2),
        Dispersion("wind_peak", "normal", 0.2),
    )
)


def campaign(*, flexible: bool = False, **changes) -> tv.Campaign:
    """Return a campaign along the made-up flight, in a triangle about 55 s."""
    made = flight(flexible=flexible)
    options = {
        "vehicle": made.at(55.0),
        "wind": ShapedWind("triangular", np.radians(5.0), 7.0),
        "dispersions": SPREAD,
        "cases": 4,
        "chunk": 2,
        "outputs": ("flight",),
        "nozzle": tv.Nozzle(limit=LIMIT, rate_limit=RATE),
        "along": FlightPlan(made, autopilot(sample_rate=20.0), stop=80.0),
    }
    return tv.Campaign(**options | changes)


@pytest.fixture(scope="module")
def columns():
    return evaluate(campaign(), 0, 4)


@pytest.mark.thorough
def test_a_case_is_a_flight_of_its_vehicle_in_the_worse_of_head_and_tail_wind(columns) -> None:
    made, laws = flight(flexible=False), autopilot(sample_rate=20.0)
    vehicle, nominal = made.vehicle, made.at(55.0)
    fates = columns["flight_survived"]
    assert set(fates.tolist()) == {0.0, 1.0}
    for k in range(4):
        values = {name: columns[name][k] for name in SPREAD.parameters}
        factor = values["normal_force_slope"] / nominal.normal_force_slope
        heavier = vehicle.replace(
            normal_force_slope=vehicle.normal_force_slope * factor,
            attitude=vehicle.attitude + (values["attitude"] - nominal.attitude),
        )
        gain = values["attitude_gain"] / laws.along(made, 55.0).attitude_gain
        gains = replace(laws.autopilot, attitude_gain=laws.autopilot.attitude_gain * gain)
        gust = tv.TriangularWind(peak=values["wind_peak"], duration=7.0).shift(51.5)
        head, tail = (
            fly_many_along(
                replace(made, vehicle=heavier),
                replace(laws, autopilot=gains),
                gust,
                deflection_limit=LIMIT,
                rate_limit=RATE,
                sign=sign,
                start=51.5,
                stop=80.0,
            )
            for sign in ("head", "tail")
        )
        survived = [str(flown.status) == "survived" for flown in (head, tail)]
        assert fates[k] == float(all(survived))
        if all(survived):
            peak = max(float(flown.peak_attitude) for flown in (head, tail))
            # the head wind of the campaign is that of its own copy of the wind
            assert columns["flight_peak_attitude"][k] == pytest.approx(peak, rel=1e-12)


def test_cases_have_the_same_bits_in_any_chunk_and_from_a_manifest(columns) -> None:
    plan = read(json.loads(json.dumps(written(campaign()))))
    assert written(plan) == written(campaign())
    for k in (1, 3):
        single = evaluate(plan, k, 1)
        for name, values in columns.items():
            assert single[name][0] == values[k]


@pytest.mark.thorough
def test_a_campaign_along_a_flight_is_resumed_and_replayed(tmp_path, columns) -> None:
    pytest.importorskip("pyarrow")
    results = tv.run_campaign(campaign(), tmp_path / "results")
    file = tmp_path / "results" / "chunks" / "00000001.parquet"
    before = file.read_bytes()
    file.unlink()
    results = tv.run_campaign(campaign(), tmp_path / "results")
    assert file.read_bytes() == before
    for name, values in columns.items():
        assert results.column(name).tolist() == values.tolist()
    survived = int(np.sum(columns["flight_survived"]))
    assert results.flights == (survived, 4 - survived)
    assert results.survival().estimate == survived / 4
    case = int(np.flatnonzero(columns["flight_survived"] == 1.0)[0])
    replay = results.replay(case)
    flown = replay.flown_along()
    assert [one.status for one in flown] == ["survived", "survived"]
    peak = max(abs(one.largest("attitude").value) for one in flown)
    assert peak == columns["flight_peak_attitude"][case]
    assert replay.extremes_flown["largest_attitude_deg"] == np.degrees(peak)


def jet(speed: float, cross: float, top: float) -> tv.WindProfile:
    """Return a jet of a speed and a cross wind [m/s] at 9 km, with levels up to `top` [m]."""
    height = np.arange(0.0, top + 1.0, 1e3)
    ratio = np.interp(height, [0.0, 9e3, min(top, 2e4)], [0.0, 1.0, 0.0])
    return tv.WindProfile(height=height, east=speed * ratio, north=cross * ratio)


@pytest.mark.thorough
def test_soundings_are_drawn_with_their_own_direction() -> None:
    made = flight(flexible=False)
    soundings = [
        tv.fly_through(jet(speed, 5.0, 4e4), made, azimuth=np.pi / 2) for speed in (-30.0, 25.0)
    ]
    winds = SoundingEnsemble.of(soundings)
    nozzle = tv.Nozzle(limit=0.2, rate_limit=RATE)
    plan = FlightPlan(made, autopilot(sample_rate=20.0), start=45.0, stop=70.0)
    only = Dispersions((Dispersion("thrust", "normal", 0.01),))
    request = campaign(wind=winds, dispersions=only, nozzle=nozzle, along=plan)
    answers = evaluate(read(json.loads(json.dumps(written(request)))), 0, 4)
    for k in range(4):
        factor = answers["thrust"][k] / made.at(55.0).thrust
        varied = replace(made, vehicle=made.vehicle.replace(thrust=made.vehicle.thrust * factor))
        flown = fly_along(
            varied,
            autopilot(sample_rate=20.0),
            soundings[answers["wind"][k]],
            deflection_limit=0.2,
            rate_limit=RATE,
            start=45.0,
            stop=70.0,
        )
        largest = abs(flown.largest("attitude").value)
        assert answers["flight_peak_attitude"][k] == pytest.approx(largest, rel=1e-12)
    assert set(answers["wind"].tolist()) == {0, 1}


@pytest.mark.thorough
def test_a_flight_in_a_sounding_that_ends_before_it_is_never_survived() -> None:
    made = flight(flexible=False)
    sounding = tv.fly_through(jet(20.0, 0.0, 1.5e4), made, azimuth=np.pi / 2)
    assert sounding.known[1] == pytest.approx(70.625)  # the flight is at 15 km
    request = campaign(
        wind=SoundingEnsemble.of([sounding]),
        dispersions=Dispersions((Dispersion("thrust", "normal", 0.01),)),
        nozzle=tv.Nozzle(limit=0.2, rate_limit=RATE),
        along=FlightPlan(made, autopilot(sample_rate=20.0), start=45.0, stop=80.0),
    )
    summary = CampaignSummary.of(ResultsInMemory.of(request))
    assert (summary.results.flights, summary.survival.upper < 1.0) == ((0, 0), True)
    assert summary.survival.estimate == summary.success.estimate == 0.0
    assert summary.sufficient is None
    assert summary.verdict.startswith("limit 11.459 deg: NOT KNOWN; ")
    assert ": in 4 of 4 cases" in summary.verdict
    known = replace(request, along=replace(request.along, stop=70.0))
    assert ResultsInMemory.of(known).flights == (4, 0)
    with pytest.raises(InputError, match="sounding 1 of 1 must be known at times of the flight"):
        replace(request, along=replace(request.along, start=75.0))


@pytest.mark.thorough
def test_modes_vary_and_notches_stay_at_the_nominal_frequency() -> None:
    made, laws = flight(), autopilot(sample_rate=50.0)
    laws = replace(
        laws, notches=(tv.control.ModeNotch(mode="first", zero_damping=0.1, pole_damping=0.6),)
    )
    only = Dispersions((Dispersion("bending_1_frequency", "normal", 0.05),))
    plan = FlightPlan(made, laws, stop=62.0)
    request = campaign(flexible=True, dispersions=only, along=plan, cases=1, chunk=1)
    factor = evaluate(request, 0, 1)["bending_1_frequency"][0]
    structure = made.structure.structure
    first = replace(structure.bending[0], frequency=structure.bending[0].frequency * factor)
    bent = replace(structure, bending=(first, structure.bending[1]))
    varied = replace(made, structure=replace(made.structure, structure=bent))
    ratio = tv.control.ModeNotch(
        mode="first", zero_damping=0.1, pole_damping=0.6, ratio=1.0 / factor
    )
    gust = tv.TriangularWind(peak=np.radians(5.0), duration=7.0).shift(51.5)
    options = {"deflection_limit": LIMIT, "rate_limit": RATE, "start": 51.5, "stop": 62.0}
    head = fly_along(varied, replace(laws, notches=(ratio,)), gust, **options)
    following = fly_along(varied, laws, gust, **options)
    replayed = replay_case(request, 0).flown_along()[0]
    size = abs(head.largest("attitude").value)
    for made_by, same in ((head, True), (following, False)):
        difference = np.abs(replayed.outputs["attitude"] - made_by.outputs["attitude"]).max()
        assert (difference < 1e-10 * size) == same


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"outputs": ("required",)}, 'has the output "flight"'),
        ({"outputs": ("flight", "margins")}, 'no "margins"'),
        ({"vehicle": flight(flexible=False).at(55.0).replace(time=None)}, "with its time"),
        ({"vehicle": flight(flexible=False).at(55.0).replace(time=5.0)}, "time must be between"),
    ],
)
def test_campaigns_along_a_flight_that_cannot_be(changes, message) -> None:
    with pytest.raises(InputError, match=message):
        campaign(**changes)
    with pytest.raises(InputError, match="give the autopilot a sample_rate"):
        FlightPlan(flight(flexible=False), autopilot())


FILE = """
[campaign]
along = true
cases = 2
seed = 3

[outputs]
names = ["flight"]

[wind]
shape = "triangular"
peak_deg = 5.0
duration_s = 7.0

[[dispersion]]
parameter = "normal_force_slope"
percent = 10

[[dispersion]]
parameter = "bending_1_frequency"
shape = "uniform"
percent = 5
"""


@pytest.mark.thorough
def test_a_file_flies_its_cases_along_the_flight_with_its_schedule_and_notches(tmp_path) -> None:
    write_flight(tmp_path)
    study = (tmp_path / "study.toml").read_text(encoding="utf-8")
    study = study.replace('"flight.csv"', '"flight.csv"\ntime_s = 55')
    file = tmp_path / "campaign.toml"
    file.write_text(study + FILE, encoding="utf-8")
    made = tv.load_schedule(tmp_path / "flight.csv")
    laws = autopilot(filters=(Filter.low_pass(40.0, 0.7),), sample_rate=50.0)
    notches = (
        ModeNotch(mode=name, zero_damping=0.1, pole_damping=0.6) for name in ("first", "second")
    )
    plan = FlightPlan(made, replace(laws, notches=tuple(notches)))
    spread = (
        Dispersion("normal_force_slope", "normal", 0.1),
        Dispersion("bending_1_frequency", "uniform", 0.05),
    )
    request = campaign(
        vehicle=made.at(55.0),
        dispersions=Dispersions(spread),
        cases=2,
        seed=3,
        nozzle=tv.Nozzle(limit=np.radians(5.0), rate_limit=np.radians(20.0)),
        along=plan,
    )
    own = evaluate(tv.studyfile.load_campaign(file), 0, 2)
    for name, values in evaluate(request, 0, 2).items():
        if name == "status":
            assert own[name].tolist() == values.tolist()
        else:
            np.testing.assert_allclose(own[name], values, rtol=1e-9, err_msg=name)
    rule = study.replace(
        'schedule = "gains.csv"', "natural_frequency_rad_per_s = 1.1\ndamping = 0.7"
    )
    file.write_text(rule.replace("every_s = 20", "every_s = 5") + FILE, encoding="utf-8")
    assert tv.studyfile.load_campaign(file).along.autopilot.breakpoints.size == 17


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("along = true", "along = 3", "along in .campaign. must be true or false; got 3"),
        ("along = true", "along = false", "add along = true to .campaign."),
        ("time_s = 55", "", "is a flight schedule: give the time"),
        ('["flight"]', '["required"]', 'has the output "flight"'),
    ],
)
def test_a_file_of_a_campaign_along_a_flight_that_cannot_be(tmp_path, old, new, message) -> None:
    write_flight(tmp_path)
    study = (tmp_path / "study.toml").read_text(encoding="utf-8")
    study = study.replace('"flight.csv"', '"flight.csv"\ntime_s = 55') + FILE
    (tmp_path / "campaign.toml").write_text(study.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError, match=message):
        tv.studyfile.load_campaign(tmp_path / "campaign.toml")
