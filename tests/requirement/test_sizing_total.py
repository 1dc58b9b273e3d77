"""All that the nozzle must turn: sums, squares, offsets by their moments, and the verdict."""

from dataclasses import replace

import numpy as np
import pytest

import tvclin as tv
from tests.small_launcher import rows, sounding, write
from tests.turns import usual
from tvclin import InputError
from tvclin.base.lines import text
from tvclin.requirement.flight.total import DeflectionTotal, Line, total_table

SCHEDULE = tv.load_schedule("configuration-i")


def test_systematic_lines_add_and_random_ones_add_in_squares() -> None:
    lines = (
        Line("a", 0.01),
        Line("b", 0.02),
        Line("c", 0.003, "random"),
        Line("d", 0.004, "random"),
    )
    result = DeflectionTotal(lines, reserve=0.3, limit=0.05)

    assert result.systematic == pytest.approx(0.03)
    assert result.random == pytest.approx(0.005)
    assert result.total == pytest.approx(0.035)
    assert result.required == pytest.approx(0.05)
    assert result.sufficient is True
    assert result.remaining == pytest.approx(0.0, abs=1e-15)
    assert DeflectionTotal(lines, reserve=0.3, limit=0.0499).sufficient is False
    assert DeflectionTotal(lines).sufficient is None


def test_what_is_not_known_leaves_no_remainder() -> None:
    """The part that is known may be at nominal dynamic pressure, which is no bound of the rest."""
    where = "at the dynamic pressure encountered at 60 s"
    unknown = DeflectionTotal((Line("wind", 0.01),), limit=0.05, not_sized=(where,))
    assert unknown.sufficient is None
    assert unknown.remaining is None
    lines = ("Limit 2.865 deg: NOT KNOWN", f"Required deflection NOT KNOWN {where}")
    assert tuple(map(text, unknown.verdict)) == lines
    assert "remaining" not in unknown.words


def test_an_offset_takes_the_deflection_that_balances_its_moment(configuration_i) -> None:
    v = configuration_i.replace(control_force_slope=0.5 * configuration_i.thrust)
    total = tv.requirement.total_deflection(
        v, 0.004, thrust_offset=-0.002, gravity_offset=0.1, nominal=-1e-4
    )
    size = {line.name: line.deflection for line in total.lines}
    control = v.control_force_slope * v.control_arm
    # moments about the centre of gravity: thrust aside at the nozzle, thrust and drag past it
    assert size["thrust offset"] == pytest.approx(
        v.thrust * v.control_arm * np.sin(0.002) / control
    )
    assert size["centre of gravity offset"] == pytest.approx(
        (v.thrust * 0.1 - v.axial_force * 0.1) / control
    )
    assert total.systematic == pytest.approx(0.0041)
    assert total.time == 66.0


def test_the_worst_total_is_that_of_the_flight_time_with_most(configuration_i) -> None:
    schedule = tv.FlightSchedule(
        configuration_i.replace(time=[40.0, 60.0, 80.0], velocity=[500.0, 540.0, 600.0]),
        nominal_deflection=[0.0, 0.0, -0.01],
    )
    wind = tv.TriangularWind(peak=0.05, duration=7.5)
    sizing = tv.size(schedule, wind, dead_bands=1.0)
    worst = tv.worst_total(sizing, "K = 1", dispersion=0.3, thrust_offset=0.001, limit=0.05)
    need = sizing.required["K = 1"][2, 0]

    assert worst.time == 80.0  # the nominal deflection outweighs what the wind takes less
    assert worst.systematic == pytest.approx(0.01 + need, rel=1e-14)
    assert worst.random == pytest.approx(np.hypot(0.3 * need, np.sin(0.001)), rel=1e-12)
    assert worst.sufficient is (worst.total <= 0.05)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"reserve": 1.0}, "reserve must be a part of the limit"),
        ({"reserve": -0.1}, "reserve must be zero or positive"),
        ({"limit": 0.0}, "limit must be positive"),
        ({"dispersion": -0.1}, "dispersion must be zero or positive"),
        ({"thrust_offset": 5.0}, "thrust_offset must be an angle within 90 degrees"),
        ({"gravity_offset": np.nan}, "gravity_offset must be finite"),
        ({"wind": np.nan}, "wind must be finite"),
        ({"others": (3,)}, "others must be a tuple of Line"),
    ],
)
def test_bad_numbers_are_refused(configuration_i, changes, words) -> None:
    with pytest.raises(InputError, match=words):
        tv.requirement.total_deflection(configuration_i, **({"wind": 0.01} | changes))


def test_a_batch_and_an_unknown_requirement_are_refused(configuration_i) -> None:
    batch = configuration_i.replace(thrust=[2e6, 3e6])
    with pytest.raises(InputError, match="one vehicle; got a batch"):
        tv.requirement.total_deflection(batch, 0.01)
    schedule = tv.FlightSchedule(configuration_i.replace(time=[40.0, 80.0]))
    turns = tv.SampledWind(time=[0.0, 2.0, 4.0, 6.0], angle=[0.0, 0.1, -0.1, 0.0])
    sizing = tv.size(schedule, turns, times=[60.0])
    with pytest.raises(InputError, match="did you mean 'K = 1'"):
        tv.worst_total(sizing, "K=1")
    nowhere = tv.worst_total(sizing, "K = 1", limit=1.0, rate_limit=0.1)
    assert (nowhere.lines, nowhere.not_sized, nowhere.sufficient) == ((), ("at 60 s",), None)
    assert np.isnan(nowhere.total)
    assert (nowhere.verdict[0][-1], nowhere.verdict[-1][-1]) == (
        "NOT KNOWN",
        "required rate NOT KNOWN",
    )
    with pytest.raises(InputError, match="kind must be one of"):
        Line("a", 0.1, "sometimes")


@pytest.mark.thorough
def test_a_rate_limit_adds_what_a_ramp_needs_more():
    """With K = 0, which needs the minimum, that is the linear program with a rate limit."""
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
    sizing = tv.size(
        SCHEDULE, wind, times=[66.0], dead_bands=[0.0], model="fixed-path", varying=False
    )
    plant = tv.Plant.from_vehicle(SCHEDULE.at(66.0), "fixed-path")
    for rate in np.radians([0.15, 0.4, 2.0]):
        total = tv.requirement.worst_total(sizing, "K = 0", rate_limit=float(rate), limit=0.1)
        slow = tv.boundary.optimum_with_rate_limit(plant, wind, float(rate), 0.0).peak
        parts = {line.name: line.deflection for line in total.lines}
        assert parts["wind"] + parts["rate limit"] == pytest.approx(slow, rel=1e-4)
        exact = tv.requirement.worst_total(
            sizing, "K = 0", rate_limit=float(rate), limit=total.total
        )
        assert exact.needed_rate == pytest.approx(rate, rel=1e-9)


def test_a_rate_limit_that_no_angle_mends_is_told_with_the_least_rate():
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
    sizing = tv.size(SCHEDULE, wind, times=[66.0], varying=False)
    total = tv.requirement.worst_total(sizing, "K = 1", rate_limit=1e-3, limit=0.1)
    assert total.sufficient is False
    words = " ".join(text(line) for line in total.verdict)
    assert "NOT SUFFICIENT at this rate limit" in words
    assert total.no_ramp
    assert total.words.endswith("without the rate limit, at which no deflection is sufficient")
    assert f"required rate {np.degrees(total.needed_rate):.3f} deg/s" in words
    assert tv.requirement.worst_total(sizing, "K = 1", rate_limit=1e-3).sufficient is False


@pytest.mark.thorough
def test_the_controllability_ratio_is_that_of_its_parts():
    booster = SCHEDULE.at(66.0)
    gust = tv.OneMinusCosineGust(peak=np.radians(1.5), duration=2.0)
    wind = tv.ShapedWind("triangular", np.radians(5.0), 7.5, gust=gust, gust_at=3.75)
    request = tv.requirement.SizingRequest(
        schedule=SCHEDULE,
        start=66.0,
        stop=66.0,
        varying=False,
        thrust_offset=np.radians(0.2),
        gravity_offset=0.05,
    )
    case = tv.Case(vehicle=booster, wind=wind, nozzle=tv.Nozzle(limit=np.radians(1.2)))
    result = request.ratio(case, request.sizing(case))
    B = abs(tv.Coefficients.from_vehicle(booster).B)
    force, nominal = booster.control_force, abs(float(SCHEDULE.nominal_at(66.0)))
    random = np.hypot(
        B * np.radians(1.5),
        np.hypot(
            booster.thrust * np.sin(np.radians(0.2)) / force,
            (booster.thrust - booster.axial_force) * 0.05 / (force * booster.control_arm),
        ),
    )
    assert result.ratio == pytest.approx(
        np.radians(1.2) / (nominal + B * np.radians(5.0) + random), rel=1e-9
    )
    assert "above the limit of 1" in result.words
    assert request.ratio(tv.Case(vehicle=booster), request.sizing(case)) is None


@pytest.mark.thorough
@pytest.mark.parametrize("window", usual([None, 20.0], 0))
def test_in_a_sounding_the_controllability_ratio_pairs_each_angle_with_the_vehicle_of_its_time(
    tmp_path, window
):
    """B(t) and alpha_w(t) of (B1e) from the rows of the schedule alone, every hundredth second."""
    flight = tv.load_schedule(write(tmp_path / "pad.csv"))
    request = tv.requirement.SizingRequest(
        schedule=flight,
        pulse=False,
        soundings={"jet": tv.requirement.SoundingRequest(sounding(), np.radians(90.0))},
        window=window,
        varying=False,
        every=10.0,
    )
    limit = np.radians(5.0)
    case = tv.Case(vehicle=flight.at(60.0), nozzle=tv.Nozzle(limit=limit))
    result = request.ratio(case, request.sizing(case))

    given = rows()
    t = np.arange(10.0, 121.0, 0.01)
    _, slope, thrust, arm, lever, _, speed, path, height = (
        np.interp(t, given[:, 0], column) for column in given.T[[2, *range(3, 11)]]
    )
    wind = np.interp(height, sounding().height, sounding().in_plane(np.radians(90.0)))
    trim = slope * arm / (thrust * lever) * np.arcsin(wind * np.sin(np.radians(path)) / speed)
    most = int(np.argmax(np.abs(trim)))
    assert result.ratio == pytest.approx(limit / abs(trim[most]), rel=2e-3)
    assert result.takes.time == pytest.approx(t[most], abs=0.3)
    assert "where the winds are known" in result.words


def test_a_wind_beyond_linear_aerodynamics_has_no_trim_in_the_controllability_ratio():
    """What is 12 deg about 50 s is 40 deg about 70 s, where nothing is sized."""
    wind = tv.SampledWind(time=[45, 50, 55, 65, 70, 75], angle=np.radians([0, 12, 0, 0, 40, 0]))
    sizing = tv.size(SCHEDULE, wind, times=[50.0, 70.0], placing="flight", window=10.0)
    ratio = tv.requirement.controllability_ratio(sizing, np.radians(5.0))
    assert np.isnan(sizing.required["trim"][1, 0])
    assert ratio.takes.time < 60.0
    assert "where the winds are known" in ratio.words
    B = abs(tv.Coefficients.from_vehicle(SCHEDULE.at(50.0)).B)
    assert ratio.ratio == pytest.approx(np.radians(5.0) / (B * np.radians(12.0)), rel=5e-3)


@pytest.mark.thorough
def test_the_row_of_the_wind_names_the_requirement_that_the_total_counts() -> None:
    plan = tv.studyfile.load_sizing("configuration-i")
    request = replace(plan.sizing, start=60.0, stop=70.0)
    sizing = request.sizing(plan)
    total = request.total(plan, sizing)
    assert total.counted == request.counted(sizing, plan.sign).label == "K = 1, varying, head wind"
    (row,) = [row for row in total_table(total).rows if row[0][0].startswith("wind")]
    assert row[0] == (f"wind, {total.counted}",)
    frozen = total_table(tv.worst_total(sizing, "K = 0.5"))
    assert any(row[0] == ("wind, K = 0.5",) for row in frozen.rows)
