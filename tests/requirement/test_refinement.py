"""The largest total between the listed flight times of a sizing."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import tvclin as tv
from tvclin import InputError
from tvclin.base.arrays import FloatArray
from tvclin.requirement.flight.refinement import refined_sizing
from tvclin.requirement.flight.sizing import Sizing, joined_sizing

SCHEDULE = tv.load_schedule("configuration-i")
WIND = tv.TriangularWind(peak=0.05, duration=7.5)


def sized(times: FloatArray) -> Sizing:
    return tv.size(SCHEDULE, WIND, times=times, dead_bands=1.0, varying=False)


def refined(listed: list[float], total: Callable[[float], float]) -> tuple[FloatArray, float]:
    """Times of a refined sizing, and the largest of a total that is a function of time."""
    sizing = refined_sizing(
        sized(np.array(listed)),
        sized,
        lambda part: {t: total(t) for t in part.times.tolist() if not np.isnan(total(t))},
    )
    assert set(listed) <= set(sizing.times.tolist())
    # rows of the joined sizing are those of its times
    assert sizing.required["K = 1"] == pytest.approx(sized(sizing.times).required["K = 1"])
    return sizing.times, float(np.nanmax([total(t) for t in sizing.times.tolist()]))


def test_gaps_of_soundings_are_those_of_the_listed_times() -> None:
    """The times between see a part of the gaps, in other words."""
    all_gaps, part = ("from 20 to 25 km and in 1 other gap",), ("from 20 to 25 km",)
    listed = replace(sized(np.array([55.0, 60.0])), gaps=all_gaps)
    joined = joined_sizing(listed, replace(sized(np.array([57.5])), gaps=part))
    assert joined.times.tolist() == [55.0, 57.5, 60.0]
    assert joined.gaps == all_gaps


@pytest.mark.thorough
@pytest.mark.parametrize("listed", [[55.0, 60.0, 65.0, 70.0], [70.0, 60.0, 65.0, 55.0]])
def test_the_largest_total_of_a_parabola_is_found_to_a_thousandth(listed) -> None:
    times, largest = refined(listed, lambda t: 1.0 - ((t - 63.1) / 12.0) ** 2)
    assert largest == pytest.approx(1.0, abs=1e-3)
    assert times.size <= 4 + 2 * 4


@pytest.mark.thorough
def test_times_far_apart_are_divided_first_so_that_a_peak_between_them_counts() -> None:
    def total(t: float) -> float:
        return float(np.exp(-(((t - 57.4) / 4.0) ** 2)) + 1.05 * np.exp(-(((t - 86.9) / 4.0) ** 2)))

    assert refined([45.0, 100.0], total)[1] == pytest.approx(1.05, rel=1e-3)


@pytest.mark.thorough
def test_of_two_maxima_the_lower_listed_one_may_be_the_higher_between() -> None:
    def total(t: float) -> float:
        return float(np.exp(-(((t - 55.0) / 4.0) ** 2)) + 1.1 * np.exp(-(((t - 82.5) / 6.0) ** 2)))

    listed = [50.0, 55.0, 60.0, 65.0, 70.0, 75.0, 80.0, 85.0, 90.0]
    assert max(listed, key=total) == 55.0
    assert refined(listed, total)[1] == pytest.approx(1.1, rel=1e-3)


def test_no_time_is_added_where_the_total_is_flat_unknown_or_of_a_single_time() -> None:
    assert refined([55.0, 60.0, 65.0, 70.0], lambda t: np.nan if t < 60.0 else 1.0)[0].size == 4
    assert refined([60.0], lambda t: t)[0].tolist() == [60.0]


def request(**changes: object) -> tv.requirement.SizingRequest:
    given = {"start": 60.0, "stop": 100.0, "varying": False, "dead_bands": (1.0,)}
    return tv.requirement.SizingRequest(**(given | changes))


@pytest.mark.thorough
def test_a_limit_that_is_sufficient_at_listed_times_alone_is_not_sufficient() -> None:
    schedule = tv.load_schedule("configuration-ii")
    case = tv.Case(
        vehicle=schedule.at(60.0),
        wind=tv.ShapedWind("triangular", 0.09, 7.5),
        nozzle=tv.Nozzle(limit=np.radians(0.33)),
    )
    coarse = request(schedule=schedule, peak_speed=60.0, every=40.0)
    dense = replace(coarse, every=1.0)
    listed, totals = coarse.sizing(case), dense.sizing(case)
    counted = dense.counted(totals)
    largest = tv.worst_total(totals, counted, limit=case.nozzle.limit)

    assert tv.worst_total(listed, counted, limit=case.nozzle.limit).sufficient is True
    total = coarse.total(case, listed)
    assert total.sufficient is False
    assert total.required == pytest.approx(largest.required, rel=1e-3)
    assert total.listed == (60.0, 100.0)
    assert "s, between the listed 60 and 100 s" in total.words
    elsewhere = replace(coarse, peak_speed=50.0)
    with pytest.raises(InputError, match="must be of the winds of this request"):
        elsewhere.total(case, listed)


@pytest.mark.thorough
def test_a_gust_on_a_jet_requires_most_where_it_meets_the_shear_between_listed_times() -> None:
    """Between 60 and 65 s, though the total in the middle of either interval is lower."""
    speed = np.array([0.0, 20.0, 25.0, 45.0, 52.0, 40.0, 28.0, 20.0, 10.0])
    height = np.array([0.0, 9e3, 10e3, 11e3, 12e3, 13e3, 14e3, 15e3, 40e3])
    jet = tv.WindProfile(height=height, east=speed, north=0.0 * speed)
    gust = tv.TriangularWind(peak=np.radians(1.0), duration=3.0)
    case = tv.Case(
        vehicle=SCHEDULE.at(66.0), wind=tv.ShapedWind("triangular", 0.09, 7.5, gust=gust)
    )
    coarse = request(
        schedule=SCHEDULE,
        start=55.0,
        stop=75.0,
        pulse=False,
        soundings={"jet": tv.requirement.SoundingRequest(jet, np.radians(90.0))},
        window=10.0,
    )
    dense = replace(coarse, every=0.25).sizing(case)
    largest = np.nanmax(dense.at_times("K = 1"))
    listed = coarse.sizing(case)

    assert np.nanmax(listed.at_times("K = 1")) < 0.98 * largest
    total = coarse.total(case, listed)
    assert total.listed == (60.0, 65.0)
    assert total.total == pytest.approx(largest, rel=2e-3)
