"""Requirements at the dynamic pressure encountered, beside integration and nonlinear flights."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import linprog

import tvclin as tv
from tests.turns import usual
from tvclin.ascent.nominal_flight import load_flight_condition
from tvclin.base.lines import text
from tvclin.ensembles.campaign.cases import ENCOUNTERED_UNKNOWN, evaluate
from tvclin.requirement import study_tables
from tvclin.requirement.case_requirement import case_requirement
from tvclin.requirement.encountered_requirement import encountered_batch, encountered_requirements
from tvclin.time_varying.equations import at_pressure
from tvclin.time_varying.gust_time import encountered_requirements_by_time
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.wind_angles import pressure_ratio

SHAPES = {"triangular": tv.TriangularWind, "rectangular": tv.RectangularWind}


def required(vehicle, wind, model, dead_band, plane="pitch") -> float:
    """The required deflection [rad] of a pulse by the sign of its peak, of a tail wind positive."""
    name = "cross" if plane == "yaw" else "head" if wind.peak < 0.0 else "tail"
    shape = "triangular" if isinstance(wind, tv.TriangularWind) else "rectangular"
    pulse = tv.ShapedWind(shape, abs(float(wind.peak)), float(wind.duration))
    sign = None if plane == "yaw" else name
    case = tv.Case(vehicle=vehicle, model=model, plane=plane, wind=pulse, sign=sign)
    return encountered_requirements(case, pulse, dead_band)[name][plane]


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("shape", SHAPES)
def test_a_limit_held_from_the_onset_leaves_nothing_that_grows(configuration_i, shape, sign):
    """Theta'' = beta^2 r (theta - alpha_w) - (beta^2/B) delta, with r = q/q_n, to the end.

    The unstable component then, theta' + beta (theta - delta/B), is linear in delta.
    """
    wind = SHAPES[shape](peak=sign * np.radians(5), duration=7.5)
    c = tv.Coefficients.from_vehicle(configuration_i)
    V, path = float(configuration_i.velocity), float(configuration_i.attitude)

    def ratio(angle):
        blows = V * np.sin(angle) / np.sin(path + angle)  # horizontal, from behind
        return ((V * np.cos(path) - blows) ** 2 + (V * np.sin(path)) ** 2) / V**2

    def rates(t, x, delta):
        angle = float(wind(t))
        return [x[1], c.beta**2 * (ratio(angle) * (x[0] - angle) - delta / c.B)]

    def grows(delta: float) -> float:
        state = np.zeros(2)
        for half in ((0.0, 3.75), (3.75, np.nextafter(7.5, 0.0))):
            state = solve_ivp(rates, half, state, args=(delta,), rtol=1e-11, atol=1e-14).y[:, -1]
        return float(state[1] + c.beta * (state[0] - delta / c.B))

    zero, one = grows(0.0), grows(1.0)
    held = abs(zero / (zero - one))
    assert required(configuration_i, wind, "fixed-path", 0.0) == pytest.approx(held, rel=1e-6)


@pytest.mark.parametrize("name", usual(["configuration-i", "configuration-ii"]))
def test_head_and_tail_winds_need_what_flights_need(name) -> None:
    """Of flights along the nominal trajectory, over that of a small wind of either sign.

    They also vary mass, speed and path, and trim by the B of calm air: within two percent.
    """
    vehicle, condition = tv.load_vehicle(name).rigid, load_flight_condition(name)
    plant = tv.Plant.from_vehicle(vehicle, "drift-exact")

    def flown(deg: float) -> float:
        wind = tv.TriangularWind(peak=np.radians(deg), duration=7.5)
        middle = wind.shift(float(vehicle.time) - 3.75)
        given = {"frozen": False, "condition": condition, "tolerance": 1e-3, "highest": 4.0}
        return abs(tv.flown_boundary(vehicle, middle, **given).deflection) / abs(deg)

    def said(deg: float) -> float:
        wind = tv.TriangularWind(peak=np.radians(deg), duration=7.5)
        frozen = abs(tv.boundary_limit(plant, wind, switch="literal").deflection)
        return required(vehicle, wind, "drift-exact", 1.0) / frozen

    small = flown(0.05)
    for deg in (-5.0, 5.0):
        assert said(deg) == pytest.approx(flown(deg) / small, rel=0.02)


@pytest.mark.parametrize("dead_band", [1.0, 0.5, 0.0])
@pytest.mark.parametrize("shape", SHAPES)
def test_a_batch_requires_what_each_of_its_cases_does(configuration_i, shape, dead_band) -> None:
    """Their steps are others; both have errors of fourth order."""
    weights = configuration_i.weight * np.array([0.9, 1.0, 1.1])
    values = {
        "wind_peak": np.radians([4.0, 5.0, 6.0]),
        "wind_duration": np.array([7.5, 5.0, 6.0]),
    }
    vehicles = configuration_i.rigid.replace(weight=weights)
    pulse = tv.ShapedWind(shape, np.radians(5.0), 7.5)
    for sign, turn in (("head", -1.0), ("tail", 1.0)):
        case = tv.Case(vehicle=configuration_i, wind=pulse, sign=sign)
        result = encountered_batch(case, values, vehicles, dead_band, "pitch")
        for i, weight in enumerate(weights):
            wind = SHAPES[shape](
                peak=turn * values["wind_peak"][i], duration=values["wind_duration"][i]
            )
            vehicle = configuration_i.replace(weight=weight)
            single = required(vehicle, wind, "drift-exact", dead_band)
            assert result[i] == pytest.approx(single, rel=2e-6)


def test_the_dynamic_pressure_is_that_of_the_air_met(configuration_i) -> None:
    """Straight up a wind of either sign adds to the speed: 1/cos(alpha_w)^2."""
    up = configuration_i.replace(attitude=np.pi / 2)
    angles = np.radians([-5.0, 5.0])
    ratio = pressure_ratio(up.attitude, angles)
    np.testing.assert_allclose(ratio, 1.0 / np.cos(angles) ** 2, rtol=1e-12)
    head, tail = pressure_ratio(configuration_i.attitude, angles)
    assert head > 1.0 > tail
    assert np.isnan(pressure_ratio(np.radians(3.0), angles[0]))
    flat = configuration_i.replace(attitude=np.radians(3.0))
    with pytest.raises(tv.InputError, match="no horizontal wind turns it so far"):
        required(flat, tv.TriangularWind(peak=np.radians(-5.0), duration=7.5), "drift-exact", 1.0)


@pytest.mark.parametrize(("degrees", "speed"), usual([(8.0, None), (45.0, 0.7)], 1))
def test_the_requirement_of_a_dispersed_case_is_not_known_where_its_study_is_not(
    configuration_i, degrees, speed
) -> None:
    """No head wind turns a path of less than 5 deg by 5 deg.

    A wind of 0.7 times the speed of the vehicle from behind meets it at more than 30 deg, though at
    less by eq (B1e).
    """
    vehicle = configuration_i.replace(attitude=np.radians(degrees))
    wind = tv.ShapedWind("triangular", np.radians(5.0), 7.5)
    if speed is not None:
        wind = wind.with_speed(speed * float(vehicle.velocity), vehicle, "pitch")
    case = tv.Case(vehicle=vehicle, wind=wind, nozzle=tv.Nozzle(limit=0.3))
    spread = tv.Dispersions((tv.Dispersion("attitude", "uniform", 0.9),))
    result = tv.ensembles.disperse_study(tv.Study.of(case), spread, cases=8)
    known = []
    cases = result.values["attitude"].tolist(), result.deflection.tolist(), result.status
    for attitude, required, status in zip(*cases, strict=True):
        single = case_requirement(replace(case, vehicle=vehicle.replace(attitude=attitude)))
        known.append(not single.unknown)
        assert (status == ENCOUNTERED_UNKNOWN) is bool(single.unknown)
        expected = np.inf if single.unknown else single.required_deflection
        assert required == pytest.approx(expected, rel=1e-5)
    assert 0 < sum(known) < len(known)
    assert not result.sufficient


def test_a_wind_that_meets_the_flight_beyond_30_deg_has_no_verdict(configuration_i) -> None:
    """From behind at 117 deg, as fast as 1.2 times the vehicle, and at 18 deg by eq (B1e)."""
    vehicle = configuration_i.replace(attitude=np.radians(15.0))
    wind = tv.ShapedWind("triangular", 0.1, 7.5)
    wind = wind.with_speed(1.2 * float(vehicle.velocity), vehicle, "pitch")
    for sign, sufficient in (("head", True), ("tail", None), (None, None)):
        case = tv.Case(vehicle=vehicle, wind=wind, nozzle=tv.Nozzle(limit=0.3), sign=sign)
        assert tv.Study.of(case).sufficient is sufficient


def test_a_wind_of_a_negative_peak_with_a_heading_blows_the_other_way(configuration_i) -> None:
    studies = [
        of_peak(deg, heading=np.radians(heading)) for deg, heading in ((-5.0, 180.0), (5.0, 0.0))
    ]
    assert [list(study.encountered) for study in studies] == [["head"], ["head"]]
    required = [study.required_deflection for study in studies]
    assert required[0] == pytest.approx(required[1], rel=1e-12)


@pytest.mark.thorough
def test_a_gust_with_a_heading_has_the_direction_of_its_wind(configuration_i) -> None:
    """Wind and gust of negative peaks from behind are those of positive peaks from ahead."""
    needs, campaigns = [], []
    for sign, heading in ((-1.0, 150.0), (1.0, 330.0)):
        gust = tv.OneMinusCosineGust(peak=sign * np.radians(2.0), duration=2.0)
        wind = tv.ShapedWind(
            "triangular", sign * np.radians(5.0), 7.5, np.radians(heading), gust, 3.0
        )
        nozzle = tv.Nozzle(limit=0.01, limit_shape="round")
        case = tv.Case(vehicle=configuration_i, wind=wind, nozzle=nozzle)
        need = case_requirement(case)
        needs.append([need.nominal_deflection, need.required_deflection])
        options = {"vehicle": configuration_i, "wind": wind, "nozzle": nozzle, "cases": 1}
        campaign = tv.Campaign(**options, dispersions=tv.Dispersions(()))
        campaigns.append(evaluate(campaign, 0, 1)["required_K1"][0])
    assert needs[0] == pytest.approx(needs[1], rel=1e-12)
    assert campaigns == pytest.approx([need[1] for need in needs], rel=1e-9)


def of_peak(deg: float, **options) -> tv.Study:
    """The usual triangle of configuration I, of another peak."""
    vehicle = tv.load_vehicle("configuration-i")
    return tv.Study.from_vehicle(vehicle, duration=7.5, peak=np.radians(deg), **options)


def test_the_verdict_counts_the_worst_of_head_and_tail_wind() -> None:
    """0.3508 deg at nominal dynamic pressure, 0.4115 against the flight, 0.3063 from behind."""
    short, enough = (of_peak(5.0, limit=np.radians(x)) for x in (0.411, 0.413))
    assert (short.sufficient, enough.sufficient) == (False, True)
    assert short.governs == "the dynamic pressure in a head wind"
    request = {name: of_peak(5.0, sign=name) for name in ("head", "tail", "frozen")}
    needs = {name: np.degrees(one.required_deflection) for name, one in request.items()}
    assert needs == pytest.approx({"head": 0.41152, "tail": 0.30625, "frozen": 0.35082}, abs=2e-5)
    assert short.required_deflection == request["head"].required_deflection
    assert request["frozen"].governs == "the boundary of the control with the exit on trim"


@pytest.mark.thorough
@pytest.mark.parametrize("sign", usual(["head", "tail", "frozen", None], 0))
def test_a_limit_is_what_the_peak_that_it_survives_requires(sign: str | None) -> None:
    for limit in np.radians([0.02, 0.1, 0.4, 0.7]):
        peak = np.degrees(of_peak(5.0, limit=limit, sign=sign).survivable_peak)
        request = of_peak(peak, limit=limit, sign=sign)
        assert request.required_deflection == pytest.approx(limit, rel=1e-7)
        assert request.sufficient


def test_the_survivable_peak_of_a_wind_by_its_speed_says_at_which_speed(configuration_i) -> None:
    """The angle encountered is not in proportion to the speed, so that an angle survives less."""
    wind = ShapedWind("triangular", np.radians(5), 7.5).with_speed(40.0, configuration_i, "pitch")
    case = tv.Case(vehicle=configuration_i, wind=wind, nozzle=tv.Nozzle(limit=np.radians(0.5)))
    study = tv.Study.of(case)
    speed = float(study.peak_of.removeprefix("of the wind at ").removesuffix(" m/s"))
    faster = replace(case, wind=wind.with_speed(speed, configuration_i, "pitch"))
    required = case_requirement(faster).required_deflection
    assert required == pytest.approx(np.radians(0.5), rel=1e-3)
    by_angle = ShapedWind("triangular", float(study.survivable_peak), 7.5)
    assert case_requirement(replace(case, wind=by_angle)).required_deflection > np.radians(0.53)


@pytest.mark.parametrize("sign", usual([None, "tail", "frozen"], 0, 2))
@pytest.mark.parametrize("plane", usual(["pitch", "yaw"], 0))
def test_the_survivable_peak_by_speed_is_the_nominal_angle_of_that_speed(
    configuration_i, sign: str | None, plane: str
) -> None:
    """By eq (B1e), from whichever speed it is searched; at nominal pressure that of the angle."""
    limit, by_angle = tv.Nozzle(limit=np.radians(0.6)), ShapedWind("triangular", 0.08, 7.5)
    sign = None if plane == "yaw" and sign == "tail" else sign
    case = tv.Case(vehicle=configuration_i, plane=plane, sign=sign, nozzle=limit)

    def of_speed(speed: float) -> tv.Study:
        wind = by_angle.with_speed(speed, configuration_i, plane)
        return tv.Study.of(replace(case, wind=wind))

    slow, fast = of_speed(20.0), of_speed(90.0)
    survived = 20.0 * slow.survivable_factor
    assert 90.0 * fast.survivable_factor == pytest.approx(survived, rel=1e-8)
    sine = np.sin(configuration_i.attitude) if plane == "pitch" else 1.0
    angle = np.arcsin(survived / configuration_i.velocity * sine)
    assert slow.survivable_peak == pytest.approx(angle, rel=1e-12)
    assert of_speed(survived).required_deflection == pytest.approx(limit.limit, rel=1e-8)
    if sign == "frozen":
        by_angle_survived = tv.Study.of(replace(case, wind=by_angle)).survivable_peak
        assert slow.survivable_peak == pytest.approx(by_angle_survived, rel=1e-8)


def test_a_wind_with_a_direction_has_its_own_sign(configuration_i) -> None:
    """Against the flight like a head wind, from behind like a tail wind, from the side across."""

    def blown(heading: float, **options) -> tv.Study:
        return of_peak(5.0, heading=np.radians(heading), **options)

    assert blown(0.0).required_deflection == pytest.approx(of_peak(5.0).required_deflection)
    assert list(blown(0.0).encountered) == ["head"]
    assert list(blown(180.0).encountered) == ["tail"]
    tail = of_peak(5.0, sign="tail").required_deflection
    assert blown(180.0).required_deflection == pytest.approx(tail)
    across = of_peak(5.0, plane="yaw").required_deflection
    assert blown(90.0, plane="yaw").encountered == {"cross": pytest.approx(across)}
    with pytest.raises(tv.InputError, match="leave sign"):
        blown(0.0, sign="head")
    both = blown(30.0, limit_shape="round")
    assert 1.0 < both.ratio_to_nominal < of_peak(5.0).ratio_to_nominal
    assert both.required_deflection == both.encountered["head"]


@pytest.mark.thorough
def test_a_pair_is_never_limited_in_the_air_that_it_meets(configuration_i) -> None:
    """What trim is at its largest, by a flight under ideal trim in that air."""
    slow = configuration_i.replace(velocity=30.0)
    wind = tv.ShapedWind("triangular", np.radians(5.0), 20.0)
    result = tv.Study.of(tv.Case(vehicle=slow, wind=wind))
    assert any("are a pair" in note for note in result.notes)
    path = float(slow.attitude)

    def trimmed(turn: float) -> float:
        def terms(t):
            angle = float(wind.history({})(t))
            blows = np.sin(turn * angle) / np.sin(path + turn * angle)
            encountered_vehicle = at_pressure(slow, (np.cos(path) - blows) ** 2 + np.sin(path) ** 2)
            A, B = tv.Plant.from_vehicle(encountered_vehicle, "drift-exact").matrices()[:2]
            return A, B, angle

        def trim(t, x):
            A, B, angle = terms(t)
            return -(A[1, 2:] @ x + B[1, 1] * angle) / B[1, 0]

        def rates(t, x):
            A, B, angle = terms(t)
            return A[2:, 2:] @ x + B[2:, 0] * trim(t, x) + B[2:, 1] * angle

        times = np.linspace(0.0, 20.0, 401)
        flown = solve_ivp(rates, (0.0, 20.0), [0.0], t_eval=times, rtol=1e-9, atol=1e-13).y.T
        return max(abs(trim(t, x)) for t, x in zip(times, flown, strict=True))

    assert result.nominal_deflection == pytest.approx(trimmed(0.0), rel=1e-4)
    for name, turn in (("head", -1.0), ("tail", 1.0)):
        assert result.encountered[name] == pytest.approx(trimmed(turn), rel=1e-4)
    assert result.required_deflection == result.encountered["head"]


@pytest.mark.parametrize(("plane", "attitude"), [("pitch", None), ("yaw", None), ("pitch", 4.0)])
def test_a_limit_is_not_sufficient_where_the_pressure_encountered_is_not_known(
    configuration_i, plane, attitude
) -> None:
    """A wind too long to be followed, and one of 5 deg that no head wind has at this path."""
    duration, vehicle = (6000.0 if attitude is None else 7.5), configuration_i
    if attitude is not None:
        vehicle = vehicle.replace(attitude=np.radians(attitude))
    options = {"duration": duration, "peak": np.radians(5), "plane": plane}
    nominal = tv.Study.from_vehicle(vehicle, **options, sign="frozen").required_deflection
    for factor, sufficient in ((1.02, None), (0.98, False)):
        study = tv.Study.from_vehicle(vehicle, limit=factor * nominal, **options)
        assert study.sufficient is sufficient
        assert study.survivable_peak is None
        assert np.isnan(study.known_deflection)
        assert "survivable peak [deg]" not in study_tables.boundaries(study).head
        sentence = text(study_tables.requirement(study))
        assert sentence.startswith("Required deflection: NOT KNOWN; at nominal dynamic pressure ")
        calm = tv.Study.from_vehicle(vehicle, limit=factor * nominal, **options, sign="frozen")
        assert calm.sufficient is (factor > 1.0)
        assert "survivable peak [deg]" in study_tables.boundaries(calm).head


def test_what_lasts_too_long_to_be_followed_is_told(configuration_i) -> None:
    for duration in (1e4, 1e8):
        study = tv.Study.from_vehicle(
            configuration_i, duration=duration, peak=np.radians(5), model="fixed-path"
        )
        assert study.encountered == {}
        (steps,) = re.findall(r"at most 20000 steps; this wind.* takes ([\d.e+]+)", study.unknown)
        assert float(steps) > 20_000


def test_a_gust_that_is_short_beside_its_wind_is_followed(configuration_i) -> None:
    """In short steps of its own: with them through all of the wind these would be too many."""
    gust = tv.OneMinusCosineGust(peak=np.radians(1), duration=0.25)
    study = tv.Study.from_vehicle(
        configuration_i, duration=60.0, peak=np.radians(3), gust=gust, gust_at=30.0
    )
    assert not study.unknown
    assert study.encountered["head"] > study.nominal_deflection > study.encountered["tail"]


def test_a_gust_too_long_to_be_followed_is_not_searched_for_its_worst_time(configuration_i) -> None:
    """The search has longer steps, which would follow it for half a minute before the refusal."""
    gust = tv.winds.OneMinusCosineGust(peak=0.02, duration=1e4)
    wind = ShapedWind("triangular", np.radians(5), 7.5, gust=gust)
    search = encountered_requirements_by_time(
        configuration_i, "drift-exact", "pitch", wind, ("head", "tail"), 1.0
    )
    with pytest.raises(tv.InputError, match="can be followed for at most"):
        search(np.array([2.0]))


@pytest.mark.thorough
def test_a_gust_whose_worst_time_is_not_known_leaves_the_requirement_unknown(configuration_i):
    """A gust at an end of the wind lasts longer than can be followed, and may require more."""
    gust = tv.OneMinusCosineGust(peak=np.radians(0.5), duration=300.0)
    given = {"duration": 3300.0, "peak": np.radians(2.0), "gust": gust, "limit": np.radians(1.0)}
    middle, free = (
        tv.Study.from_vehicle(configuration_i, **given, gust_at=at) for at in (1650.0, None)
    )
    assert middle.sufficient is True
    assert free.sufficient is None
    assert "the worst time of the gust is not known: varying parameters can" in free.unknown


def test_the_survivable_peak_of_a_wind_with_a_gust_is_of_both_together(configuration_i) -> None:
    gust = tv.winds.OneMinusCosineGust(peak=np.radians(1), duration=2.0)
    wind = ShapedWind("triangular", np.radians(5), 7.5, gust=gust, gust_at=3.75)
    case = tv.Case(vehicle=configuration_i, wind=wind, nozzle=tv.Nozzle(limit=0.01), sign="frozen")
    study = tv.Study.of(case)

    assert study.peak_of == "of the wind, its gust included"
    assert study.judged_peak == pytest.approx(np.radians(6), rel=1e-9)


def test_without_speed_and_attitude_the_nominal_pressure_counts(configuration_i) -> None:
    c = tv.Coefficients.from_vehicle(configuration_i)
    bare = tv.vehicle.LinearVehicle(coefficients=c, name="bare")
    study = tv.Study.from_vehicle(bare, duration=7.5, peak=np.radians(5))
    assert study.encountered == {}
    assert any("the requirement in a head wind is not known" in note for note in study.notes)
    with pytest.raises(tv.InputError):
        tv.Study.from_vehicle(bare, duration=7.5, peak=np.radians(5), sign="head")


@pytest.mark.thorough
def test_a_flight_has_both_directions_at_each_time_and_its_total_the_larger() -> None:
    """With parameters that vary the ratio to the nominal pressure is nearly that of frozen ones."""
    plan = tv.studyfile.load_sizing("configuration-i")
    request = plan.sizing
    result = request.sizing(plan)
    (pulse,) = request.pulses(plan)
    nominal = result.required["K = 1, varying"][:, 0]
    for sign in ("head", "tail"):
        studies = [tv.Study.of(request.at(plan, t, pulse)) for t in result.times.tolist()]
        ratios = [study.encountered[sign] / study.nominal_deflection for study in studies]
        along = result.required[f"K = 1, varying, {sign} wind"][:, 0]
        np.testing.assert_allclose(along, nominal * ratios, rtol=0.02)
    name = "K = 1, varying, head wind"
    total = request.total(plan, result)
    assert request.counted(result) == name
    assert {line.name: line.deflection for line in total.lines}["wind"] == result.worst[
        name
    ].deflection


@pytest.mark.parametrize(
    ("sign", "column"),
    usual([("head", ", head wind"), ("tail", ", tail wind"), ("frozen", "")], 0),
)
def test_one_sign_of_a_flight_is_counted_where_it_is_asked_for(sign, column) -> None:
    plan = replace(tv.studyfile.load_sizing("configuration-i"), sign=sign)
    request = replace(plan.sizing, every=40.0)
    result = request.sizing(plan)
    assert request.counted(result, sign) == f"K = 1, varying{column}"
    assert sum(bool(one.direction) for one in result.required) == bool(column)


@pytest.mark.parametrize(("blows_from", "own"), usual([(270.0, "tail"), (90.0, "head")], 0))
def test_a_direction_says_which_sign_a_flight_meets(blows_from, own) -> None:
    plan = tv.studyfile.load_sizing("configuration-i")
    east = replace(plan.wind, heading=np.radians(blows_from - 90.0))
    plan = replace(plan, wind=east)
    request = replace(plan.sizing, every=40.0)
    result = request.sizing(plan)
    counted = request.counted(result)
    assert counted == f"K = 1, varying, {own} wind"
    assert [one for one in result.required if one.direction] == [f"K = 1, varying, {own} wind"]
    with pytest.raises(tv.InputError, match="leave sign"):
        request.sizing(replace(plan, sign=own))


@pytest.mark.thorough
@pytest.mark.parametrize("gust_speed", usual([None, 10.0], 1))
def test_dispersed_studies_with_a_gust_are_studies_of_their_cases(gust_speed) -> None:
    """Each is a march of its own; a gust by its speed [m/s] is too."""
    vehicle = tv.load_vehicle("configuration-i")
    gust = tv.OneMinusCosineGust(peak=np.radians(1.0), duration=2.0)
    wind = tv.ShapedWind("triangular", np.radians(5.0), 7.5, gust=gust, gust_at=3.0)
    if gust_speed is not None:
        wind = wind.with_gust_speed(gust_speed, vehicle, "pitch")
    spread = tv.Dispersions((
        tv.Dispersion("thrust", "uniform", 0.05),
        tv.Dispersion("wind_peak", "uniform", 0.2),
        tv.Dispersion("wind_duration", "uniform", 0.3),
    ))  # fmt: skip
    case = tv.Case(vehicle=vehicle, wind=wind)
    result = tv.ensembles.disperse_study(tv.Study.of(case), spread, cases=6)
    for i, needed in enumerate(result.deflection.tolist()):
        peak, duration, thrust = (
            float(result.values[name][i]) for name in ("wind_peak", "wind_duration", "thrust")
        )
        at = 3.0 + 0.5 * (duration - 7.5)
        blows = replace(wind, peak=peak, duration=duration, gust_at=at)
        single = tv.Study.of(replace(case, vehicle=vehicle.replace(thrust=thrust), wind=blows))
        assert needed == pytest.approx(single.required_deflection, rel=1e-5)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("duration", "calm", "head"),
    usual(
        [
            (60.0, 0.1048, 0.1083),
            (40.0, 0.0780, 0.0800),
            (90.0, 0.1325, 0.1381),
            (120.0, 0.1492, 0.1565),
        ],
        0,
    ),
)
def test_a_slow_mode_in_the_air_met_needs_the_least_of_all_control(
    configuration_i, duration, calm, head
) -> None:
    """By a linear program over both modes.

    The program's control is constant in a quarter of a second, its peak about 1e-4 too high, and
    the steps of the ratio are good to 1e-4.
    """
    wind = tv.ShapedWind("triangular", np.radians(5.0), duration)
    result = tv.Study.of(tv.Case(vehicle=configuration_i, wind=wind), 0.0)
    needs = {"calm": result.nominal_deflection} | result.encountered
    assert np.degrees([needs["calm"], needs["head"]]) == pytest.approx([calm, head], abs=5e-5)
    minimum = {"calm": 0.0, "head": -1.0, "tail": 1.0}
    minimum = {name: least_peak(configuration_i, wind, turn) for name, turn in minimum.items()}
    assert needs == pytest.approx(minimum, rel=2e-4)


@pytest.mark.thorough
@pytest.mark.parametrize("duration", [40.0, 60.0])
def test_three_modes_in_the_air_met_need_the_least_of_all_control(configuration_i, duration):
    """As before, of drift and speed; after the wind the cells of a slow pair are coarse, 5e-4."""
    wind = tv.ShapedWind("triangular", np.radians(5.0), duration)
    case = tv.Case(vehicle=configuration_i, wind=wind, model="drift-and-speed")
    needs = case_requirement(case, 0.0).encountered
    minimum = {"head": -1.0, "tail": 1.0}
    minimum = {
        name: least_peak(configuration_i, wind, turn, case.model) for name, turn in minimum.items()
    }
    assert needs == pytest.approx(minimum, rel=5e-4)


@pytest.mark.thorough
@pytest.mark.parametrize("dead_band", usual([0.5, 0.25, 0.4], 0))
def test_after_trim_the_slow_mode_needs_the_least_of_all_control(configuration_i, dead_band):
    """As before; the linear program's trim is level in a quarter of a second."""
    wind = tv.ShapedWind("triangular", np.radians(5.0), 60.0)
    result = case_requirement(tv.Case(vehicle=configuration_i, wind=wind), dead_band)
    calm, head = (
        least_peak(configuration_i, wind, turn, dead_band=dead_band) for turn in (0.0, -1.0)
    )
    assert result.nominal_deflection == pytest.approx(calm, rel=1e-3)
    assert result.encountered["head"] == pytest.approx(head, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "duration"), [("configuration-i", 330.0), ("made-up-launcher", 180.0)]
)
def test_batches_follow_winds_that_last(name: str, duration: float) -> None:
    """In steps that do not let what fades grow."""
    vehicle, wind = tv.load_vehicle(name), tv.ShapedWind("triangular", np.radians(5.0), duration)
    case = tv.Case(vehicle=vehicle, wind=wind, model="drift-exact", sign="head")
    single = case_requirement(case, 0.0).required_deflection
    result = encountered_batch(case, {}, vehicle.rigid, 0.0, "pitch")
    assert result == pytest.approx([single], rel=1e-6)


@pytest.mark.parametrize("dead_band", [0.5, 0.25, 0.0])
def test_slow_modes_of_many_at_once_are_those_of_each(configuration_i, dead_band) -> None:
    vehicles = configuration_i.rigid.replace(weight=configuration_i.weight * np.array([0.9, 1.1]))
    values = {"wind_peak": np.radians([4.0, 5.0]), "wind_duration": np.array([60.0, 80.0])}
    pulse = tv.ShapedWind("triangular", np.radians(5.0), 60.0)
    case = tv.Case(vehicle=configuration_i, wind=pulse, sign="head")
    result = encountered_batch(case, values, vehicles, dead_band, "pitch")
    for i, weight in enumerate([0.9, 1.1]):
        vehicle = configuration_i.replace(weight=configuration_i.weight * weight)
        peak, duration = (float(values[k][i]) for k in ("wind_peak", "wind_duration"))
        case = tv.Case(vehicle=vehicle, wind=tv.ShapedWind("triangular", peak, duration))
        single = case_requirement(replace(case, sign="head"), dead_band)
        assert "minimum over all" in single.requirement.governs
        assert result[i] == pytest.approx(single.required_deflection, rel=1e-4)


def least_peak(vehicle, wind, turn, model="drift-exact", dead_band=0.0) -> float:
    """The least peak [rad] of any control from where trim has left the dead band at it.

    Constant in a quarter of a second; so are the parameters.
    """
    path, count = float(vehicle.attitude), int(4 * wind.duration)
    h, ends = wind.duration / count, np.geomspace(1.0, 3000.0, 300) - 1.0

    def matrices(ratio):
        return tv.Plant.from_vehicle(at_pressure(vehicle, ratio), model).matrices()[:2]

    def stepped(A, B):
        whole = np.block([[A, B], [np.zeros((B.shape[1], len(A) + B.shape[1]))]])
        return expm(whole * h)[: len(A)]

    angles = wind.peak * (1.0 - np.abs((2 * np.arange(count) + 1) / count - 1.0))
    blows = np.sin(turn * angles) / np.sin(path + turn * angles)
    equations = [matrices((np.cos(path) - blow) ** 2 + np.sin(path) ** 2) for blow in blows]
    x, states, trims = np.zeros(len(equations[0][0])), [], []
    for (A, B), angle in zip(equations, angles, strict=True):
        trims.append(-(A[1] @ x + B[1, 1] * angle) / B[1, 0])
        states.append(x)
        held = B[:, :1] / -B[1, 0]  # by trim: the attitude stays
        step = stepped(A + held @ A[1:2], B[:, 1:] + held * B[1, 1])
        x = step[:, :-1] @ x + step[:, -1] * angle

    A, B = matrices(1.0)
    poles, rows = np.linalg.eig(A.T)
    grows = (poles.real > 1e-6) & (poles.imag >= 0.0)
    poles, rows = poles[grows][:, np.newaxis], rows[:, grows].T
    after = rows @ B[:, :1] * -np.diff(np.exp(-poles * ends)) / poles
    turns = poles.imag[:, 0] > 0.0
    rows, after = (np.vstack([one.real, one.imag[turns]]) for one in (rows, after))
    reach, demand, request = after, np.zeros(len(rows)), []
    for k in reversed(range(count)):
        step = stepped(*equations[k])
        m = step.shape[0]
        reach = np.column_stack([rows @ step[:, m], reach])
        demand = demand + rows @ step[:, m + 1] * angles[k]
        rows = rows @ step[:, :m]
        apart = np.linalg.inv(np.linalg.qr(rows.T)[1].T)  # all turn to the fast one
        rows, reach, demand = (apart @ one for one in (rows, reach, demand))
        request.insert(0, (reach, demand + rows @ states[k]))
    if dead_band == 0.0:
        return least_size(*request[0])
    low, high = 0, count // 2  # trim grows up to there
    while high - low > 1:
        middle = (low + high) // 2
        inside = abs(trims[middle]) < dead_band * least_size(*request[middle])
        low, high = (middle, high) if inside else (low, middle)
    limits = [least_size(*request[k]) for k in (low, high)]
    over = [abs(trims[k]) - dead_band * limit for k, limit in zip((low, high), limits, strict=True)]
    return float(np.interp(0.0, over, limits))


def least_size(reach, demand) -> float:
    """The least peak of what is constant in cells: 1/t for the largest t within a peak of one."""
    sizes, n = np.abs(reach).sum(axis=1), reach.shape[1]
    unit = np.abs(demand / sizes).max()
    most = linprog(
        np.append(np.zeros(n), -1.0),
        A_eq=np.column_stack([reach, demand / unit]) / sizes[:, np.newaxis],
        b_eq=np.zeros(len(sizes)),
        bounds=[(-1.0, 1.0)] * n + [(0.0, None)],
    )
    assert most.status == 0, most.message
    return float(unit / most.x[-1])


def test_a_vehicle_that_no_deflection_holds_survives_a_peak_of_next_to_nothing(
    configuration_i,
) -> None:
    """Its mass in tonnes: the wind turns it by 1e100 deg, and no factor on the wind is searched."""
    light = configuration_i.replace(weight=1e-3 * configuration_i.weight)
    wind = tv.ShapedWind("triangular", np.radians(5.0), 7.5)
    case = tv.Case(vehicle=light, wind=wind, nozzle=tv.Nozzle(limit=0.01))
    study = tv.Study.of(case)
    assert study.required_deflection > 1e20
    assert 0.0 <= abs(study.survivable_peak) < 1e-9
