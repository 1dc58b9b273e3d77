"""`tvclin nozzle`: the numbers of the library, a verdict with its exit code, and refusals."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import tvclin as tv
from tests.turns import usual
from tvclin.base.lines import text
from tvclin.cli.app import app
from tvclin.nozzle.duty_over_flight import FlownDuty
from tvclin.studyfile.findings import find
from tvclin.studyfile.questions import questions
from tvclin.studyfile.verdict import sentence
from tvclin.vehicle.vehicle import at_pressure

SOUNDING = str(Path(__file__).parents[1] / "soundings" / "wyoming.txt")


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["nozzle", *arguments])


def front(vehicle: tv.Vehicle | None = None, **nozzle: float) -> tv.boundary.RateTradeOff:
    plant = tv.Plant.from_vehicle(vehicle or tv.load_vehicle("configuration-i"), "drift-exact")
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
    return tv.boundary.rate_trade_off(
        plant, wind, **{key: np.radians(x) for key, x in nozzle.items()}
    )


def test_json_equals_the_library() -> None:
    answer = json.loads(run("--limit-deg", "0.35", "--rate-limit-deg", "2", "--json").stdout)
    expected = front(limit=0.35, rate_limit=2.0)
    assert answer["trade_off"]["limits_deg"] == pytest.approx(
        np.degrees(expected.limits), rel=1e-12
    )
    assert answer["trade_off"]["lower_bound_deg"] == pytest.approx(
        np.degrees(expected.lower_bound), rel=1e-12
    )
    assert answer["trade_off"]["above_lower_bound"] is True
    assert answer["flown"] == []


@pytest.mark.parametrize(("dead_band", "words"), [(0.0, ""), (0.5, "below the required"), (1, "")])
def test_a_dead_band_with_a_forecast_is_judged_by_its_required_deflection(dead_band, words) -> None:
    """0.23 deg is between what K = 0 requires, 0.227 deg, and the bound without a forecast."""
    options = ("--duration", "10", "--peak-deg", "6", "--limit-deg", "0.23")
    options += ("--dead-band", str(dead_band))
    words = words or ("below the lower bound, no forecast" if dead_band else "")
    done = run("configuration-i", *options)
    printed = " ".join(done.stdout.split())
    assert done.exit_code == bool(words)
    assert printed.startswith(f"NOT SUFFICIENT, {words}" if words else "Required deflection 0.227")
    study = CliRunner().invoke(app, ["study", "configuration-i", *options])
    assert study.exit_code == done.exit_code


def test_a_study_file_with_the_numbers_of_its_vehicle_is_answered_over_the_rate(tmp_path) -> None:
    vehicle = tv.load_vehicle("configuration-i")
    numbers = {"weight_N": vehicle.weight, "moment_of_inertia_kg_m2": vehicle.moment_of_inertia}
    numbers |= {"normal_force_slope_N_per_rad": vehicle.normal_force_slope}
    numbers |= {"thrust_N": vehicle.thrust, "aerodynamic_arm_m": vehicle.aerodynamic_arm}
    numbers |= {"control_arm_m": vehicle.control_arm, "axial_force_N": vehicle.axial_force}
    numbers |= {"velocity_m_per_s": vehicle.velocity}
    numbers |= {"attitude_deg": float(np.degrees(vehicle.attitude))}
    file = tmp_path / "s.toml"
    lines = "[wind]\npeak_deg = 5\nduration_s = 7.5\n[study.vehicle]\n"
    file.write_text(lines + "".join(f"{k} = {v!r}\n" for k, v in numbers.items()))
    answer, named = (json.loads(run(x, "--json").stdout) for x in (str(file), "configuration-i"))
    for key in ("minimum_deflection_deg", "minimum_rate_deg_per_s"):
        assert answer["trade_off"][key] == pytest.approx(named["trade_off"][key], rel=1e-9)


@pytest.mark.thorough
def test_the_required_rate_is_stated_at_the_limit_or_the_required_deflection() -> None:
    """At that rate the least limit is the one it is stated at."""
    required = json.loads(CliRunner().invoke(app, ["study", "--json"]).stdout)["verdict"]
    for options, limit in (
        ((), required["required_deflection_deg"]),
        (("--limit-deg", "0.35"), 0.35),
    ):
        stated = json.loads(run(*options, "--json").stdout)["required_rate"]
        assert stated["limit_deg"] == pytest.approx(limit, rel=1e-12)
        plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
        wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
        rate = np.radians(stated["required_rate_deg_per_s"])
        minimum = tv.boundary.optimum_with_rate_limit(plant, wind, rate, 0.0).peak
        assert np.degrees(minimum) == pytest.approx(limit, rel=1e-4)
        first = run(*options).output.partition("Lower bounds of the limit over")[0]
        assert f"{stated['required_rate_deg_per_s']:.3f}" in first


def test_the_required_rate_of_an_autopilot_is_that_of_the_library_at_both_pressures() -> None:
    """The larger pressure is that of the wind triangle at the peak of the head wind, by hand."""
    nominal = tv.load_vehicle("configuration-i")
    peak, path = np.radians(5.0), float(nominal.attitude)
    along = np.sin(peak) / np.sin(path - peak)  # speed of the wind over that of the vehicle
    denser = at_pressure(nominal, (np.cos(path) + along) ** 2 + np.sin(path) ** 2)
    limit = tv.Nozzle(limit=np.radians(1.2))
    law = tv.SaturatedLaw.of(tv.Case(vehicle=nominal, nozzle=limit).autopilot)
    at_nominal, at_peak = (
        np.degrees(tv.nozzle.flown_required_rate(tv.Case(vehicle=x, nozzle=limit), law))
        for x in (nominal, denser)
    )
    given = ("--law", "autopilot", "--limit-deg", "1.2")
    answer = json.loads(run(*given, "--json").stdout)
    # steps of 0.02 percent of the rate
    assert answer["autopilot_required_rate_deg_per_s"] == pytest.approx(at_peak, rel=2e-4)
    assert answer["autopilot_required_rate_nominal_deg_per_s"] == pytest.approx(at_nominal)
    printed = " ".join(run(*given).output.split())
    assert f"the limit at the largest pressure in this wind {at_peak:.3f} deg/s" in printed
    assert f"the limit at nominal dynamic pressure {at_nominal:.3f} deg/s" in printed


@pytest.mark.parametrize(
    ("limit", "verdict"), usual([("0.65", False), ("0.8", None), ("1.1", True)], 1)
)
def test_the_verdict_on_an_autopilot_is_that_of_fly(limit: str, verdict: bool | None) -> None:
    """At nominal dynamic pressure 0.69 deg survives, at that of the head wind's peak 1 deg."""
    given = ("--law", "autopilot", "--limit-deg", limit, "--json")
    given += ("--set", "nozzle.rate_limit_deg_per_s=0.5")
    flown = CliRunner().invoke(app, ["fly", "--wind", "triangular", *given])
    duty = run(*given)
    assert json.loads(flown.stdout)["sufficient"] is verdict
    assert json.loads(duty.stdout)["flown"][0]["verdict"]["satisfied"] is verdict
    assert duty.exit_code == flown.exit_code == (0 if verdict else 1)
    frozen = json.loads(run(*given, "--set", "study.sign=frozen").stdout)["flown"][0]["verdict"]
    assert frozen["satisfied"] is (verdict is not False)


def test_a_law_that_trims_the_nominal_wind_alone_is_not_met() -> None:
    """0.38 deg is between 0.351 deg at nominal pressure and the required deflection, 0.412 deg."""
    answer = run("--law", "trim", "--limit-deg", "0.38", "--rate-limit-deg", "2")
    assert answer.exit_code == 1
    assert answer.stdout.startswith("Trim flown: NOT KNOWN: with the largest dynamic pressure")


def test_the_required_rate_of_laws_without_a_forecast_says_whose_it_is() -> None:
    """With a dead band below 1 a law has a forecast, and the bound without one does not count."""
    for band, laws in (("1", "any law without a forecast"), ("0.5", "any law")):
        answer = run("--limit-deg", "0.2", "--dead-band", band, "--duration", "40")
        assert f" {laws} with the limit" in " ".join(answer.output.split())


@pytest.mark.parametrize(
    ("options", "code", "words"),
    usual(
        [
            (
                ("--limit-deg", "0.35", "--rate-limit-deg", "2"),
                0,
                "lower bound, wind known at this rate limit",
            ),
            (
                ("--limit-deg", "0.21", "--rate-limit-deg", "0.5"),
                1,
                "NOT SUFFICIENT, below the lower bound",
            ),
            (
                ("--limit-deg", "0.35"),
                0,
                "required rate of any law without a forecast with the limit at least 0.142 deg/s",
            ),
            (("--limit-deg", "0.1"), 1, "NOT SUFFICIENT, below the lower bound"),
            (
                ("--rate-limit-deg", "2"),
                0,
                "Required deflection 0.412 deg in a head wind, see study; required rate",
            ),
            ((), 0, "a limit below it is never sufficient"),
            (
                ("--limit-deg", "0.35", "--rate-limit-deg", "0.5", "--law", "trim"),
                1,
                "trim is lost",
            ),
            (("--limit-deg", "2", "--rate-limit-deg", "5", "--law", "autopilot"), 0, "flown: MET"),
            (("--rate-limit-deg", "0.05"), 1, "at this rate limit: no limit is sufficient"),
            (("--law", "trim"), 2, "--limit-deg"),
            (("--law", "trm", "--limit-deg", "1"), 2, "trim"),
            (("--set", "autopilot.attitude_gain=1"), 2, "--law"),
            (("--load-deg", "1"), 2, "--load-deg needs --over load"),
            (
                ("--winds", SOUNDING, "--azimuth-deg", "9", "--set", "wind.peak_deg=3"),
                2,
                "give --winds or --set wind.peak_deg, not both",
            ),
            (("--every", "1"), 2, "--every needs --over flight"),
            (("--plane", "both"), 2, "--plane both needs tvclin nozzle --over"),
            (("--over", "loads"), 2, "--over must be one of rate, load"),
            (("--over", "flight", "--at", "60"), 2, "--at needs --over rate or load"),
            (("--over", "flight", "--dead-band", "0.5"), 2, "--dead-band needs --over rate"),
            (("--over", "flight", "--plot", "x.png"), 2, "load; --csv FILE writes the duty"),
            (("--help",), 0, "draw the curves of --over rate or"),
            (("--set", "nozzle.travel_limit_deg=1"), 0, "not counted here"),
            (
                ("--limit-deg", "1", "--law", "trim", "--set", "nozzle.torque_limit_N_m=1e4"),
                2,
                "mass_kg and arm_m",
            ),
            (
                ("--limit-deg", "1", "--law", "trim", "--set", "nozzle.travel_limit_deg=1"),
                1,
                "travel of a flight used",
            ),
            (
                ("--limit-deg", "1", "--law", "trim", "--set", "nozzle.travel_limit_deg=2"),
                0,
                "MET: travel of a flight used",
            ),
            (
                ("--duration", "20"),
                0,
                "a limit below it is not sufficient for a law without a forecast that must survive"
                " the wind even if it stops for good at any instant",
            ),
        ],
        *(0, 1, 2, 3, 4, 5, 6, 8, 9, 10, 11, 12, 13, 14, 15, 16, 20, 25),
    ),
)
def test_the_verdict_and_its_exit_code(options: tuple[str, ...], code: int, words: str) -> None:
    result = run(*options)
    assert result.exit_code == code, result.output
    assert words in " ".join(result.output.split())


def test_the_card_is_of_the_flight() -> None:
    """Its peaks are those of `fly_many`, its travel the integral of the rate."""
    options = ("--limit-deg", "2", "--rate-limit-deg", "5", "--law", "autopilot", "--json")
    card = json.loads(run(*options).stdout)["flown"][0]["duty"]
    case = tv.Case(vehicle=tv.load_vehicle("configuration-i"))
    law = tv.control.design_law("autopilot", case.plant, float(case.history.peak))
    limits = {"deflection_limit": np.radians(2.0), "rate_limit": np.radians(5.0)}
    flown = tv.fly_many(
        case.plant,
        law,
        case.history,
        **limits,
        actuator=case.nozzle.actuator,
        sample_rate=100.0,
    )
    assert abs(card["angle_deg"]) == pytest.approx(np.degrees(flown.peak_deflection), rel=1e-4)
    # there a mean over a sample, here over an eighth of one
    rate = float(np.degrees(flown.peak_deflection_rate))
    assert abs(card["rate_deg_per_s"]) == pytest.approx(rate, rel=0.02)
    assert card["travel_deg"] > 2.0 * abs(card["angle_deg"])


def test_files_hold_the_front_and_the_nozzle(tmp_path: Path) -> None:
    table, figure = tmp_path / "front.csv", tmp_path / "front.png"
    options = ("--limit-deg", "0.35", "--rate-limit-deg", "2")
    assert run(*options, "--csv", str(table), "--plot", str(figure)).exit_code == 0
    assert figure.stat().st_size > 5000
    lines = [line for line in table.read_text().splitlines() if not line.startswith("#")]
    rows = [list(row.values()) for row in csv.DictReader(lines)]
    expected = front(limit=0.35, rate_limit=2.0)
    known = [float(row[1]) for row in rows]
    assert known == pytest.approx(np.degrees(expected.limits), rel=1e-6)
    assert [float(row[3]) for row in rows if row[3] not in ("", "nan")] == pytest.approx([0.35])


HINGE = """
mass_kg = 1200
arm_m = 1.35
inertia_kg_m2 = 400
stiffness_N_m_per_deg = 15200
damping_N_m_s_per_deg = 174
friction_kN_m = 2
offset_m = 0.01
thrust_offset_m = 0.002
"""


def study_file(folder: Path, hinge: str = HINGE) -> str:
    file = folder / "my.toml"
    file.write_text(
        '[study]\nvehicle = "configuration-i"\n[wind]\npeak_deg = 5\nduration_s = 7.5\n'
        f"[nozzle]\nlimit_deg = 0.6\nrate_limit_deg_per_s = 10{hinge}"
    )
    return str(file)


@pytest.mark.thorough
def test_the_torque_of_a_flight_is_that_of_its_motion_and_the_hinge_of_the_file(tmp_path) -> None:
    result = run(study_file(tmp_path), "--law", "trim", "--json")
    work = json.loads(result.stdout)["flown"][0]["duty"]["work"]
    plan = tv.load_study(tmp_path / "my.toml")
    engine = tv.vehicle.Engine(mass=1200.0, arm=1.35, moment_of_inertia=400.0)
    hinge = {"stiffness": np.degrees(15200.0), "damping": np.degrees(174.0), "friction": 2000.0}
    nozzle = tv.case.NozzleData(engine=engine, offset=0.01, thrust_offset=0.002, **hinge)
    assert vars(plan.nozzle.data) == pytest.approx(vars(nozzle))

    law = tv.control.design_law("trim", plan.plant, float(plan.history.peak))
    expected = FlownDuty.of(plan, "trim", law).duty.work.as_dict()
    assert work == pytest.approx(expected)


def test_a_hinge_without_what_turns_about_it_is_refused(tmp_path) -> None:
    result = run(study_file(tmp_path, "\nstiffness_N_m_per_deg = 15200\n"), "--law", "trim")
    assert result.exit_code == 2
    words = " ".join(result.stderr.split())
    assert "missing in [nozzle]: mass_kg" in words
    assert "arm_m" in words


def in_head_wind() -> tv.Vehicle:
    """Return configuration I at the dynamic pressure at the peak of a head wind of 5 deg."""
    vehicle, angle = tv.load_vehicle("configuration-i"), np.radians(-5.0)
    path = float(vehicle.attitude)
    against = np.sin(angle) / np.sin(path + angle)
    more = (np.cos(path) - against) ** 2 + np.sin(path) ** 2
    return vehicle.replace(
        normal_force_slope=vehicle.normal_force_slope * more,
        axial_force=vehicle.axial_force * more,
    )


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("bound", "vehicle", "ratio", "yes"),
    usual(
        [
            ("required_rate", in_head_wind(), 1.001, True),
            ("required_rate", in_head_wind(), 0.999, None),
            ("minimum_rate", in_head_wind(), 1.001, None),
            ("minimum_rate", in_head_wind(), 0.999, None),
            ("required_rate", None, 1.001, None),
            ("required_rate", None, 0.999, False),
            ("minimum_rate", None, 0.999, False),
        ],
        *(0, 3, 6),
    ),
)
def test_less_rate_never_has_a_better_answer(tmp_path, bound, vehicle, ratio, yes) -> None:
    """Nor where no deflection survives at that rate, at one dynamic pressure or at both."""
    plan = tv.load_study(study_file(tmp_path, ""))
    rate = float(ratio * getattr(front(vehicle, limit=0.6), bound))
    findings = find(replace(plan, nozzle=replace(plan.nozzle, rate_limit=rate)))
    (answer,) = (question for question in questions(findings) if question.name == "nozzle rate")
    assert answer.yes is yes
    required = np.degrees(front(in_head_wind(), limit=0.6).required_rate)
    assert answer.measure.required == pytest.approx(required)
    none = replace(findings.head, rates=replace(findings.head.rates, required_rate=np.inf))
    (other,) = (
        question
        for question in questions(replace(findings, head=none))
        if question.name == "nozzle rate"
    )
    assert other.text.startswith("with this limit no rate is sufficient")
    unknown = replace(findings, head=replace(findings.head, rates=None))
    (answer,) = (question for question in questions(unknown) if question.name == "nozzle rate")
    assert answer.yes is (None if yes else yes)
    if bound == "minimum_rate" and vehicle is None:
        assert text(sentence(findings)) == (
            "NOT MET: with this limit the larger of both lower bounds, by the peak pressure of a"
            f" head wind throughout, requires {required:.3f} deg/s and has"
            f" {np.degrees(rate):.3f} deg/s; SUFFICIENT for the 0.412 deg that the ideal trim law"
            " requires in this wind."
        )


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("limit", "rate", "yes"), usual([(0.6, 10.0, True), (0.25, 0.2, False), (0.3, 0.2, None)], 1, 2)
)
def test_a_study_judges_limit_and_rate_together_by_their_lower_bounds(tmp_path, limit, rate, yes):
    """At nominal pressure and, if it survives there, at that of a head wind's peak throughout."""
    file = Path(study_file(tmp_path, ""))
    study = file.read_text().replace("= 0.6", f"= {limit}").replace("= 10", f"= {rate}")
    file.write_text(study)
    result = CliRunner().invoke(app, ["study", str(file), "--json"])
    (request,) = (
        question
        for question in json.loads(result.stdout)["questions"]
        if question["name"] == "nozzle rate"
    )
    calm, needed = (
        np.degrees(front(one, limit=limit, rate_limit=rate).required_rate)
        for one in (None, in_head_wind())
    )
    if limit == 0.3:
        assert (round(calm, 3), round(needed, 3)) == (0.173, 0.314)
    assert f"at the nominal one {calm:.3f} deg/s" in request["why"]
    assert request["yes"] is (bool(needed <= rate) or (None if calm <= rate else False))
    assert request["yes"] is yes
    assert request["measure"] == {
        "required": pytest.approx(needed),
        "available": pytest.approx(rate),
        "unit": "deg/s",
    }


@pytest.mark.thorough
def test_with_laws_each_has_its_limit_at_each_rate(tmp_path: Path) -> None:
    """Of a study file only those of its table."""
    file, figure = Path(study_file(tmp_path, "")), tmp_path / "laws.png"
    file.write_text(file.read_text() + '\n[laws]\nnames = ["trim"]\nwinds = ["triangle"]\n')
    result = run(str(file), "--laws", "--json", "--plot", str(figure))
    assert result.exit_code == 0, result.output
    needed = json.loads(result.stdout)["laws"]
    case = tv.load_study(file)
    expected = tv.nozzle.flown_trade_offs({"": case}, laws=("trim",))[""]
    assert needed["limits_deg"]["trim"][-1] == pytest.approx(np.degrees(expected.required["trim"]))
    assert needed["survives"] == {"trim": True}
    assert figure.stat().st_size > 5000


@pytest.mark.parametrize(
    "question",
    [
        ("nozzle", "configuration-i", "--law", "autopilot", "--limit-deg", "1"),
        (
            *("nozzle", "configuration-i", "--over", "flight", "--from", "60", "--to", "65"),
            *("--law", "autopilot", "--limit-deg", "1"),
        ),
        ("fly", "configuration-i", "--law", "autopilot", "--engine", "planar"),
        ("fly", "configuration-i", "--law", "all", "--wind", "triangular"),
    ],
)
def test_flights_of_an_autopilot_say_that_nobody_specified_its_gains(question) -> None:
    words = "these are textbook gains, a0 = 2 B and a1 = B/beta"
    shown = CliRunner().invoke(app, [*question])
    specified = CliRunner().invoke(app, [*question, "--set", "autopilot.design=lqr"])

    assert words in " ".join(shown.output.split())
    assert words not in " ".join(specified.output.split())
    assert specified.exit_code < 2, specified.output


@pytest.mark.parametrize(
    ("options", "shown"), [((), False), (("--more",), True), (("--rate-limit-deg", "1"), True)]
)
def test_the_table_of_a_required_rate_that_the_verdict_has_is_below_more(options, shown) -> None:
    output = run(*options).stdout

    assert ("Required rate, a lower bound" in output) is shown
    assert "required rate of any law" in " ".join(output.split())


@pytest.mark.parametrize(
    ("limit", "verdict"), [("0.3", "NOT SURVIVED: "), ("2", "MET: deflection")]
)
def test_the_verdict_over_a_flight_says_that_its_vehicle_is_frozen(limit, verdict) -> None:
    flight = ("--over", "flight", "--from", "60", "--to", "60", "--limit-deg", limit)
    first = run(*flight).stdout.partition("\n\n")[0]

    assert first.startswith(verdict)
    assert " ".join(first.split()).endswith(", with the vehicle frozen at each flight time.")


@pytest.mark.parametrize("over", [(), ("--over", "flight", "--from", "60", "--to", "65")])
def test_more_prints_the_autopilot_that_is_flown(over) -> None:
    given = ("--law", "autopilot", "--limit-deg", "1", "--more")
    given += ("--set", "autopilot.attitude_gain=1.25", "--set", "autopilot.rate_gain_s=0.9")
    given += ("--set", "autopilot.sample_rate_Hz=40")
    output = " ".join(run(*over, *given).output.split())

    assert "flown at 40 Hz" in output
    assert "attitude gain a0 1.25 rate gain a1 0.9 s" in output
