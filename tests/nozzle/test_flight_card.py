"""The card of a whole flight, against single flights, closed forms, and sums by hand."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.small_launcher import write
from tests.turns import usual
from tvclin.base.lines import text
from tvclin.cli.app import app
from tvclin.control.laws.law import NoisyLaw
from tvclin.flights.closed_loop.fly import fly_nozzle
from tvclin.nozzle.data_sheet import NozzleVerdict, flight_reason
from tvclin.nozzle.duty_over_flight import FlownDuty
from tvclin.studyfile.findings import find
from tvclin.studyfile.questions import questions
from tvclin.studyfile.verdict import sentence

DEG = float(np.radians(1.0))
HINGE = tv.case.NozzleData(
    engine=tv.vehicle.Engine(mass=1200.0, arm=1.35, moment_of_inertia=400.0),
    stiffness=8e5,
    damping=1e4,
    friction=2000.0,
    offset=0.01,
)
NOZZLE = tv.Nozzle(limit=DEG, rate_limit=10.0 * DEG, data=HINGE)
SCHEDULE = tv.load_schedule("configuration-i")
BOOSTER = SCHEDULE.vehicle


def request(**given):
    return tv.requirement.SizingRequest(schedule=SCHEDULE, **{"start": 60.0, "stop": 70.0} | given)


def plan(**given):
    from tvclin.studyfile.study_plan import StudyPlan

    return StudyPlan(vehicle=BOOSTER, **{"nozzle": NOZZLE, "sign": "frozen"} | given)


def test_each_point_is_the_flight_of_its_time_and_the_minimum_of_its_wind():
    card = tv.nozzle.flight_duty(plan(), request())
    assert [point.time for point in card.points] == [60.0, 65.0, 70.0]
    for point in card.points:
        case = tv.Case(vehicle=SCHEDULE.at(point.time), nozzle=NOZZLE)
        law = tv.control.design_law("trim", case.plant, float(case.history.peak))
        single = FlownDuty.of(case, "trim", law).duty
        minimum = tv.optimum_deflection(case.plant, case.history, 0.0).peak
        pole = float(np.real(tv.unstable_modes(case.plant).poles[0]))
        assert point.minimum == pytest.approx(minimum, rel=1e-9)
        assert point.minimum_rate == pytest.approx(pole * minimum, rel=1e-9)
        assert point.minimum_acceleration == pytest.approx(pole**2 * minimum, rel=1e-9)
        # the same flight but for its time, and the time of rest before it
        assert point.duty.travel == pytest.approx(single.travel, rel=1e-6)
        assert point.duty.work.energy == pytest.approx(single.work.energy, rel=1e-4)
        assert abs(point.duty.rate.value) == pytest.approx(abs(single.rate.value), rel=1e-6)
    assert card.duties[0].travel == max(point.duty.travel for point in card.points)


def test_a_head_wind_has_the_dynamic_pressure_of_its_peak_and_a_tail_wind_that_of_calm_air():
    card = tv.nozzle.flight_duty(plan(sign=None), request(stop=60.0))
    calm = tv.nozzle.flight_duty(plan(), request(stop=60.0)).points[0]
    head, tail = card.points
    assert tail.minimum == calm.minimum
    assert abs(tail.duty.angle.value) == pytest.approx(abs(calm.duty.angle.value), rel=1e-9)
    vehicle = SCHEDULE.at(60.0)
    angle = np.radians(-5.0)  # tan of the angle of the air: the law of sines, backwards
    w = vehicle.velocity * np.sin(angle) / np.sin(vehicle.attitude + angle)
    air = np.hypot(
        vehicle.velocity * np.cos(vehicle.attitude) - w, vehicle.velocity * np.sin(vehicle.attitude)
    )
    ratio = float((air / vehicle.velocity) ** 2)
    encountered = vehicle.replace(
        normal_force_slope=vehicle.normal_force_slope * ratio,
        axial_force=vehicle.axial_force * ratio,
    )
    plant = tv.Plant.from_vehicle(encountered)
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
    assert head.minimum == pytest.approx(tv.optimum_deflection(plant, wind, 0.0).peak, rel=1e-9)


HELD = tv.FlightSchedule(SCHEDULE.at(66.0).replace(time=[40.0, 100.0]), altitude=[6e3, 16e3])
JET = tv.WindProfile(height=[7e3, 10e3, 13e3, 15e3], east=[0.0, 25.0, 5.0, 0.0], north=[0.0] * 4)


def in_the_jet(azimuth, **options):
    sounding = tv.requirement.SoundingRequest(JET, azimuth=np.radians(azimuth))
    return tv.requirement.SizingRequest(
        schedule=HELD, pulse=False, soundings={"jet": sounding}, **options
    )


@pytest.mark.parametrize("azimuth", [90.0, 270.0])
def test_a_measured_wind_is_met_with_the_largest_dynamic_pressure_of_its_part(azimuth):
    card = tv.nozzle.flight_duty(
        plan(sign=None), in_the_jet(azimuth, start=60.0, stop=80.0, every=20.0)
    )
    wind = tv.fly_through(JET, HELD, azimuth=np.radians(azimuth)).wind
    vehicle, tail = SCHEDULE.at(66.0), 1.0 if azimuth == 90.0 else -1.0
    path = float(vehicle.attitude)
    # 60 to 70 s with the peak at 64 s, 70 to 80 s; the altitude rises by a sixth of a km in 1 s
    for point, times in zip(card.points, ([60.0, 64.0, 70.0], [70.0, 80.0]), strict=True):
        east = np.interp(6e3 + 1e4 / 60.0 * (np.array(times) - 40.0), JET.height, JET.east)
        along = np.cos(path) - tail * east / float(vehicle.velocity)
        ratio = float((along**2 + np.sin(path) ** 2).max())
        encountered = vehicle.replace(
            normal_force_slope=vehicle.normal_force_slope * ratio,
            axial_force=vehicle.axial_force * ratio,
        )
        expected = tv.optimum_deflection(
            tv.Plant.from_vehicle(encountered), wind, float(wind.onset)
        ).peak
        # the pressure is a chord of its parabola between the samples, 20 m/s apart
        within = 2.0 * (10.0 / float(vehicle.velocity)) ** 2
        assert point.minimum == pytest.approx(expected, rel=within)


@pytest.mark.thorough
def test_a_measured_wind_is_counted_once_over_the_flight():
    """On a flight that does not change, the parts are those of one flight from end to end."""
    case = plan()
    computed = [
        tv.nozzle.flight_duty(case, in_the_jet(90.0, start=50.0, stop=90.0, every=every)).duties[0]
        for every in (5.0, 10.0, 20.0)
    ]
    whole = tv.fly_through(JET, HELD, azimuth=np.radians(90.0)).wind
    one = tv.Case(vehicle=SCHEDULE.at(66.0), nozzle=NOZZLE, wind=whole)
    law = tv.control.design_law("trim", one.plant, float(whole.peak))
    flown = fly_nozzle(one.plant, law, whole, deflection_limit=DEG, **one.hardware)
    inside = (flown.times >= 50.0) & (flown.times <= 90.0)
    travel = np.abs(np.diff(flown.deflection[inside])).sum()
    for duty in computed:  # at each end of a part up to a step of 2.5 ms is left out
        assert duty.travel == pytest.approx(travel, rel=2e-3)


def test_noise_makes_travel_as_its_rms_rate_says():
    """Of a rate that is normal the mean size is sqrt(2/pi) of its rms; in 15 s within 4 percent."""
    noise = np.radians(0.05)
    quiet = tv.nozzle.flight_duty(plan(), request(stop=60.0)).points[0].duty
    card = tv.nozzle.flight_duty(plan(), request(stop=60.0, rate_noise=noise, noise_seed=3))
    loud = card.points[0].duty
    span = 7.5 + 15.0 / float(tv.Plant.from_vehicle(SCHEDULE.at(60.0)).coefficients.pole)
    assert loud.travel > 5.0 * quiet.travel
    assert loud.travel == pytest.approx(span * np.sqrt(2.0 / np.pi) * loud.rms_rate, rel=0.04)
    # the whole flight of one time is that wind alone; of ten seconds, noise goes on between
    longer = tv.nozzle.flight_duty(plan(), request(rate_noise=noise, noise_seed=3))
    case = tv.Case(vehicle=SCHEDULE.at(65.0), nozzle=NOZZLE)
    law = NoisyLaw(tv.control.design_law("trim", case.plant, 0.09), noise=noise, seed=3)
    flown = fly_nozzle(case.plant, law, case.history, deflection_limit=DEG, **case.hardware)
    still = flown.rate[flown.times > 7.5 * (1.0 + 1.0 / float(case.plant.coefficients.pole))]
    rate = np.sqrt(2.0 / np.pi * np.mean(still**2))
    wind = loud.travel - span * rate
    within = 2.0 * 0.04 * span * rate  # of the noise that is taken off one flight, twice
    assert longer.duties[0].travel == pytest.approx(wind + 10.0 * rate, abs=within)


def profile(levels: list[float], east: list[float]) -> tv.WindProfile:
    """Return a wind from the west [m/s] between levels [m], known at every kilometre."""
    height = np.union1d(levels, np.arange(np.ceil(levels[0]), levels[-1], 1e3))
    return tv.WindProfile(
        height=height, east=np.interp(height, levels, east), north=np.zeros(height.size)
    )


def test_where_a_wind_is_not_known_the_verdict_is_not_known():
    """The sounding begins at 7 km, where the flight is at 46 s."""
    held = tv.FlightSchedule(SCHEDULE.at(66.0).replace(time=[40.0, 100.0]), altitude=[6e3, 16e3])
    jet = profile([7e3, 10e3, 15e3], [0.0, 25.0, 0.0])
    sounding = tv.requirement.SoundingRequest(jet, azimuth=np.radians(90.0))
    options = {"pulse": False, "soundings": {"jet": sounding}, "start": 45.0, "stop": 60.0}
    case = tv.Case(vehicle=held.vehicle, nozzle=NOZZLE)
    computed = tv.nozzle.flight_duty(
        case, tv.requirement.SizingRequest(schedule=held, **options)
    ).verdict
    assert computed.satisfied is None
    assert computed.unknown == ("jet is not known below 7.0 km (46 s): --from 46 begins there",)
    assert "NOT KNOWN" in computed.words
    offered = tv.requirement.SizingRequest(schedule=held, **options | {"start": 46.0})
    assert tv.nozzle.flight_duty(case, offered).verdict.satisfied is True


def test_above_the_last_level_of_a_balloon_the_end_of_the_flight_is_offered():
    """At 64.0294 s: what is offered is not beyond it."""
    held = tv.FlightSchedule(SCHEDULE.at(66.0).replace(time=[40.0, 100.0]), altitude=[6e3, 16e3])
    jet = profile([0.0, 8e3, 10004.9], [5.0, 25.0, 5.0])
    sounding = tv.requirement.SoundingRequest(jet, azimuth=np.radians(90.0))
    options = {"pulse": False, "soundings": {"jet": sounding}, "start": 50.0, "every": 10.0}
    case = tv.Case(vehicle=held.vehicle, nozzle=NOZZLE)
    computed = tv.nozzle.flight_duty(
        case, tv.requirement.SizingRequest(schedule=held, **options)
    ).verdict
    assert computed.unknown == ("jet is not known above 10.0 km (64.03 s): --to 64.02 ends there",)
    offered = tv.requirement.SizingRequest(schedule=held, stop=64.02, **options)
    assert tv.nozzle.flight_duty(case, offered).verdict.satisfied is True


@pytest.mark.thorough
def test_a_flight_with_a_complex_pair_is_not_known_and_what_would_make_it_known_is_named(tmp_path):
    """Not called lost, and no number of a motion that is not judged is shown."""
    flight = tv.load_schedule(write(tmp_path / "pad.csv"))
    poles = {
        time: np.linalg.eigvals(flight.plants(time, "drift-exact", "pitch").matrices()[0])
        for time in (10.0, 20.0)
    }
    assert np.any((poles[10.0].real > 1e-3) & (poles[10.0].imag != 0.0))
    assert not np.any((poles[20.0].real > 1e-3) & (poles[20.0].imag != 0.0))
    case = plan(nozzle=tv.Nozzle(limit=5.0 * DEG))

    def card(start, model="drift-exact"):
        flown = tv.requirement.SizingRequest(schedule=flight, start=start, stop=20.0, every=10.0)
        return tv.nozzle.flight_duty(replace(case, model=model), flown)

    result = card(10.0)
    assert result.verdict.satisfied is None
    assert result.verdict.diverged == ()
    (reason,) = result.verdict.unknown
    assert reason.startswith("the flight of trim at 10 s in triangular wind of 5 deg, 7.5 s: two")
    assert "--from 20 omits these times, --model fixed-path judges" in reason
    first, second = (line.split(",") for line in result.to_csv().splitlines()[1:])
    angle = result.to_csv().splitlines()[0].split(",").index("angle_deg") + 1  # a name has a comma
    assert (first[angle], first[4]) == ("nan", "no flight")
    assert float(second[angle]) > 0.0
    assert card(20.0).verdict.satisfied is True
    assert card(10.0, "fixed-path").verdict.satisfied is True


def test_a_flight_that_ends_undecided_is_not_known():
    plant = tv.Plant.from_vehicle(SCHEDULE.at(66.0))
    assert "neither diverged nor settled" in flight_reason(plant, "undecided")
    assert flight_reason(plant, "lost") == flight_reason(plant, "survived") == ""
    verdict = NozzleVerdict.of(NOZZLE, {"limit": 0.5 * DEG}, unknown=["the flight: it is open"])
    assert verdict.satisfied is None
    assert verdict.words == "NOT KNOWN: the flight: it is open"
    short = NozzleVerdict.of(NOZZLE, {"limit": 1.5 * DEG}, unknown=["the flight: it is open"])
    assert short.words.startswith("NOT MET: deflection used 1.5 deg")


def test_noise_is_that_of_the_gyro_for_each_sample():
    case = tv.Case(vehicle=SCHEDULE.at(60.0))
    law = NoisyLaw(tv.control.design_law("trim", case.plant, 0.09), noise=1e-3, seed=2)
    assert law.rate_noise == (1e-3, 2)


def test_both_planes_have_their_part_of_the_stop():
    wind = tv.ShapedWind("triangular", 5.0 * DEG, 7.5, heading=np.radians(200.0))
    nozzle = replace(NOZZLE, limit_shape="round")
    card = tv.nozzle.flight_duty(plan(wind=wind, nozzle=nozzle, sign=None), request(stop=60.0))
    pitch, yaw = card.points
    assert np.hypot(pitch.limit, yaw.limit) == pytest.approx(DEG, rel=1e-9)
    assert {pitch.plane, yaw.plane} == {"pitch", "yaw"}
    turned = np.hypot(abs(pitch.duty.angle.value), abs(yaw.duty.angle.value))
    limit = next(line for line in card.verdict.lines if line.name == "deflection")
    assert np.degrees(turned) == pytest.approx(limit.required, rel=0.05)  # both peak together


@pytest.mark.parametrize(
    ("sheet", "worst", "satisfied"),
    usual(
        [
            ({}, "deflection", True),
            ({"rate_limit": 0.25 * DEG}, "deflection rate", True),
            ({"acceleration_limit": 1.0 * DEG}, "acceleration", False),
            ({"torque_limit": 1e3}, "torque", False),
            ({"power_limit": 1e5}, "deflection", True),
            ({"travel_limit": 1.2 * DEG}, "travel of a flight", False),
        ],
        1,
        5,
    ),
)
def test_the_worst_line_heads_the_verdict(sheet, worst, satisfied):
    computed = tv.nozzle.flight_duty(plan(nozzle=replace(NOZZLE, **sheet)), request()).verdict
    assert computed.lines[0].name == worst
    assert computed.satisfied is satisfied
    assert worst in computed.words
    for line in computed.lines:
        assert line.remaining is None or line.remaining == pytest.approx(
            line.available - line.required
        )


def test_of_a_limit_that_is_reached_nothing_is_left():
    reached, beyond = (
        NozzleVerdict.of(NOZZLE, {"limit": DEG * (1.0 + over)}).lines[0] for over in (1e-15, 1e-9)
    )
    assert (reached.satisfied, reached.remaining) == (True, 0.0)
    assert not beyond.satisfied
    assert beyond.remaining < 0.0


def test_what_a_lost_flight_needs_is_not_known_to_be_there():
    needed = {"limit": 0.9 * DEG, "rate_limit": 11.0 * DEG, "acceleration_limit": 0.0}
    lost = NozzleVerdict.of(NOZZLE, needed, ["trim is lost"])
    computed = {line.name: (line.required, line.satisfied, line.remaining) for line in lost.lines}
    assert np.isnan(computed["deflection"][0])
    assert computed["deflection"][1] is None
    assert np.isnan(computed["acceleration"][0])
    assert computed["deflection rate"][1] is False
    assert lost.satisfied is False


def test_a_rate_limit_that_no_angle_mends_is_told_with_the_least_rate():
    card = tv.nozzle.flight_duty(plan(nozzle=replace(NOZZLE, rate_limit=0.05 * DEG)), request())
    assert card.verdict.satisfied is False
    assert "trim is lost at 60 s" in card.verdict.words
    (rate,) = (line for line in card.verdict.lines if line.name == "deflection rate")
    assert rate.required > max(point.minimum_rate for point in card.points) / DEG


def test_what_is_missing_is_named():
    with pytest.raises(tv.InputError, match="--limit-deg, limit_deg in"):
        tv.nozzle.flight_duty(plan(nozzle=tv.Nozzle()), request())
    with pytest.raises(tv.InputError, match="mass_kg and arm_m"):
        tv.Nozzle(limit=DEG, torque_limit=1e4)
    card = tv.nozzle.flight_duty(plan(nozzle=tv.Nozzle(limit=DEG)), request(stop=60.0))
    assert any("torque, power and energy need" in note for note in card.notes)


STUDY = """
[study]
vehicle = "configuration-i"
[wind]
peak_deg = 5
duration_s = 7.5
[nozzle]
limit_deg = {limit}
rate_limit_deg_per_s = {rate}
torque_limit_N_m = {torque}
mass_kg = 1200
arm_m = 1.35
stiffness_N_m_per_deg = 15200
[schedule]
[size]
from_s = 66
to_s = 66
varying = false
duty_law = "trim"
"""


@pytest.mark.parametrize(
    ("limit", "rate", "torque", "answers"),
    usual(
        [
            (1.0, 5.0, 3e4, {"whole flight": True, "nozzle card": True}),
            (1.0, 5.0, 1e3, {"whole flight": True, "nozzle card": False}),
            (1.0, 0.12, 3e4, {"whole flight": False, "nozzle card": False}),
        ],
        1,
    ),
)
def test_a_study_file_asks_for_the_card_and_counts_the_rate(tmp_path, limit, rate, torque, answers):
    file = tmp_path / "study.toml"
    file.write_text(STUDY.format(limit=limit, rate=rate, torque=torque))
    computed = {question.name: question for question in questions(find(tv.load_study(file)))}
    assert {name: computed[name].yes for name in answers} == answers
    if rate < 1.0:
        measure = computed["whole flight"].measure
        assert measure.unit == "deg/s"
        assert measure.required > measure.available == pytest.approx(rate)
    else:  # as `tvclin ascent` says of the same flight
        document = json.loads(CliRunner().invoke(app, ["ascent", str(file), "--json"]).stdout)
        along = computed["rate along the flight"]
        assert (along.yes, along.quantity) == (True, "required rate")
        assert f"required rate {along.measure.required:.3f} deg/s" in document["verdict"]["words"]
    assert ("rate along the flight" in computed) is (rate > 1.0)


def test_a_limit_with_which_no_rate_is_sufficient_is_not_blamed_on_the_rate(tmp_path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(STUDY.format(limit=0.2, rate=5.0, torque=3e4))
    computed = {question.name: question for question in questions(find(tv.load_study(file)))}
    assert "rate along the flight" not in computed
    assert computed["whole flight"].yes is False
    assert computed["whole flight"].measure.unit == "deg"


@pytest.mark.thorough
def test_a_flight_that_cannot_be_judged_does_not_head_the_page_as_not_sufficient(tmp_path):
    write(tmp_path / "pad.csv")
    study = STUDY.format(limit=5.0, rate=20.0, torque=3e4)
    study = study.replace("[schedule]", '[schedule]\nsource = "pad.csv"')
    study = study.replace("from_s = 66\nto_s = 66", "from_s = 10\nto_s = 20\nevery_s = 10")
    file = tmp_path / "study.toml"
    file.write_text(study)
    result = find(tv.load_study(file))
    (card,) = (question for question in questions(result) if question.name == "nozzle card")
    assert card.yes is None
    assert card.text.startswith("the flight of trim at 10 s in 2 winds: two unstable poles")
    assert text(sentence(result)).startswith("NOT KNOWN: the flight of trim at 10 s")
