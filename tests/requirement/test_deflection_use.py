"""Required, used and remaining deflection by flight time."""

from dataclasses import replace

import numpy as np
import pytest

import tvclin as tv
from tests.whole_flight import autopilot, flight
from tvclin import InputError


@pytest.mark.thorough
def test_what_remains_is_the_limit_minus_the_largest_of_what_is_required_and_used() -> None:
    made = flight(flexible=False)
    gust = tv.TriangularWind(peak=np.radians(4.0), duration=6.0)
    sizing = tv.size(made, gust, times=[45.0, 55.0, 65.0])
    flown = tv.flights.fly_along(made, autopilot(), gust.shift(52.0), start=50.0, stop=80.0)
    use = tv.requirement.deflection_use(sizing, flown, 0.05)
    assert np.isnan(use.used[0])
    assert np.isnan(use.remaining[0])
    sizes, times = np.abs(flown.outputs["deflection"]), flown.times
    assert use.used[1] == sizes[times < 60.0].max()
    assert use.used[2] == sizes[times >= 60.0].max()
    for k in (1, 2):
        largest = max(use.used[k], *(sizing.at_times(r)[k] for r in sizing.required))
        assert use.remaining[k] == 0.05 - largest
    assert use.table().head[-2:] == ("used", "remaining")
    figure = tv.plots.deflection_use_chart(use)
    curves = tv.plots.curves_of(figure)
    assert use.table().head == ("time [s]", *(column.label for column in curves.columns[:-1]))
    drawn = {line.get_label(): line.get_color() for line in figure.axes[0, 0].get_lines()}
    assert list(drawn.values()).count(drawn["remaining"]) == 1
    np.testing.assert_array_equal(curves.column("used")[1:], np.degrees(use.used[1:]))
    assert len(use.to_csv().splitlines()) == 4
    laws = autopilot(sample_rate=25.0)
    needed = tv.requirement.autopilot_requirements(sizing, laws, gust, sign="head")
    with_autopilot = tv.requirement.deflection_use(sizing, flown, 0.05, needed)
    np.testing.assert_array_equal(with_autopilot.required["autopilot"], needed.at_times)
    np.testing.assert_array_equal(
        with_autopilot.remaining, np.minimum(use.remaining, 0.05 - needed.at_times)
    )
    assert np.all(needed.at_times > sizing.at_times("K = 1"))
    one = tv.size(made, gust, times=[55.0])
    largest = abs(flown.largest("deflection").value)
    assert tv.requirement.deflection_use(one, flown, 0.05).used.tolist() == [largest]


@pytest.mark.thorough
def test_the_autopilot_requirement_is_the_larger_of_head_and_tail_wind() -> None:
    made, laws = flight(flexible=False), autopilot(sample_rate=25.0)
    gust = tv.TriangularWind(peak=np.radians(4.0), duration=6.0)
    steep = tv.TriangularWind(peak=np.radians(31.0), duration=6.0)
    sizing = tv.size(made, {"gust": gust, "steep": steep}, times=[65.0])
    winds = {"gust": gust, "steep": steep}
    needed = tv.requirement.autopilot_requirements(sizing, laws, winds, rate_limit=0.3)
    options = {"rate_limit": 0.3, "start": 62.0}
    head, tail = (
        tv.flights.survival_limit_along(made, laws, gust.shift(62.0), sign=sign, **options).limit
        for sign in ("head", "tail")
    )
    assert needed.limit[0, 0] == max(head, tail)
    assert np.isnan(needed.limit[0, 1])
    assert "linear aerodynamics says nothing" in needed.reasons[0]
    with pytest.raises(InputError, match="winds must be those of the sizing"):
        tv.requirement.autopilot_requirements(sizing, laws, gust)


def test_a_head_wind_that_cannot_be_is_not_known_and_the_reason_is_said() -> None:
    made, laws = flight(flexible=False), autopilot(sample_rate=25.0)
    level = replace(made, vehicle=made.vehicle.replace(attitude=np.radians(3.0)))
    gust = tv.TriangularWind(peak=np.radians(4.0), duration=6.0)
    sizing = tv.size(level, gust, times=[65.0])
    needed = tv.requirement.autopilot_requirements(sizing, laws, gust)
    assert np.isnan(needed.limit[0, 0])
    assert "no horizontal wind turns it so far" in needed.reasons[0]


@pytest.mark.thorough
def test_the_requirement_at_the_end_of_the_flight_is_of_the_vehicle_frozen_as_it_is_then() -> None:
    made, laws = flight(flexible=False), autopilot(sample_rate=25.0)
    gust = tv.TriangularWind(peak=np.radians(4.0), duration=6.0)
    sizing = tv.size(made, gust, times=[105.0, 106.0])
    needed = tv.requirement.autopilot_requirements(sizing, laws, gust, sign="head")
    assert np.all(needed.at_times > sizing.at_times("K = 1"))
    assert not needed.reasons
    unknown = replace(needed, limit=np.full((2, 1), np.nan), reasons=("wind: undecided",))
    use = tv.requirement.deflection_use(sizing, [0.01, 0.01], 0.05, unknown)
    assert np.isnan(use.remaining).all()
    assert use.reasons == unknown.reasons
