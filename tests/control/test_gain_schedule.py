"""Schedules of the autopilot on variables of the flight, and values that two times share."""

from dataclasses import replace

import numpy as np
import pytest

import tvclin as tv
from tests.whole_flight import TIMES, autopilot, flight
from tvclin import InputError
from tvclin.control.autopilot.gain_table import load_gains
from tvclin.vehicle import Filter


def test_mach_and_dynamic_pressure_are_those_of_the_standard_atmosphere() -> None:
    made = flight()
    # the table of the U.S. Standard Atmosphere 1976 at 7500 m
    sound, density = 310.2, 0.5572
    mach = tv.ascent.flight_variable(made, "mach", 50.0)
    pressure = tv.ascent.flight_variable(made, "dynamic_pressure", 50.0)
    assert mach == pytest.approx(400.0 / sound, rel=2e-4)
    assert pressure == pytest.approx(0.5 * density * 400.0**2, rel=2e-4)
    assert tv.ascent.flight_variable(made, "altitude", 40.0) == (2700.0 + 7500.0) / 2.0
    for name in ("time", "speed", "altitude", "mach", "dynamic_pressure"):
        assert tv.ascent.flight_variable(made, name, [[40.0], [50.0]]).shape == (2, 1)


def test_gains_on_mach_are_straight_lines_in_mach_and_end_with_their_last_value() -> None:
    made, times = flight(), np.array([40.0, 60.0, 80.0])
    mach = tv.ascent.flight_variable(made, "mach", times)
    gains = tv.Autopilot(attitude_gain=[0.6, 0.4, 0.2], rate_gain=[0.7, 0.5, 0.4])
    on_mach = tv.control.GainSchedule(mach, gains, "mach")
    now = on_mach.along(made, [35.0, 40.0, 55.0, 100.0])
    middle = np.interp(tv.ascent.flight_variable(made, "mach", 55.0), mach, [0.6, 0.4, 0.2])
    np.testing.assert_allclose(now.attitude_gain, [0.6, 0.6, middle, 0.2], rtol=1e-15)
    with pytest.raises(InputError, match=r"mach must lie in the schedule, 0\.9.* to 2\.\d+; got 5"):
        on_mach.at(5.0)
    with pytest.raises(InputError, match="time must be between 30 and 110; got 20 s"):
        on_mach.along(made, 20.0)


def test_filters_and_actuators_are_interpolated_and_stay_stable_between() -> None:
    lags = Filter.low_pass([20.0, 40.0], [0.5, 0.7])
    gains = {"attitude_gain": 0.5, "rate_gain": 0.5}
    servo = tv.Actuator(natural_frequency=[20.0, 30.0], damping=[0.6, 0.8])
    made = tv.control.GainSchedule(
        [0.0, 10.0], tv.Autopilot(**gains, filters=(lags,), actuator=servo)
    ).at(5.0)
    assert made.filters[0].denominator.tolist() == [1.0, (20.0 + 56.0) / 2.0, (400 + 1600) / 2.0]
    assert (made.actuator.natural_frequency, made.actuator.damping) == (25.0, pytest.approx(0.7))
    fourth = Filter(np.ones((2, 1)), np.array([[1.0, 3, 3, 2, 1]] * 2))
    with pytest.raises(InputError, match="filters that change over the flight must be of order 2"):
        tv.control.GainSchedule([0.0, 1.0], tv.Autopilot(**gains, filters=(fourth,)))


def test_a_notch_follows_its_mode_and_the_actuator_the_flight() -> None:
    made = replace(flight(), actuator_frequency=np.linspace(20, 30, 5), actuator_damping=0.7)
    notch = tv.control.ModeNotch(mode="second", zero_damping=0.05, pole_damping=0.5, ratio=1.1)
    now = replace(autopilot(), notches=(notch,)).along(made, [30.0, 80.0])
    for k, time in enumerate((30.0, 80.0)):
        frequency = 1.1 * made.at(time).structure.bending[1].frequency
        want = Filter.notch(frequency, 0.05, 0.5)
        np.testing.assert_array_equal(now.filters[-1].numerator[k], want.numerator)
    assert now.actuator.natural_frequency.tolist() == [20.0, 26.25]
    with pytest.raises(InputError, match="mode must be one of first, second; got 'third'"):
        replace(notch, mode="third").at(made, 50.0)
    with pytest.raises(InputError, match="has no mode: it needs a flight with a structure"):
        notch.at(flight(flexible=False), 50.0)
    with pytest.raises(InputError, match=r"see along\(flight, time\)"):
        replace(autopilot(), notches=(notch,)).at(50.0)


@pytest.mark.parametrize("variable", ["time", "speed", "altitude", "mach", "dynamic_pressure"])
def test_the_table_of_a_schedule_reads_back_as_its_gains(variable, tmp_path) -> None:
    gains = {"attitude_gain": [0.6, 0.4], "rate_gain": [0.7, 0.5], "alpha_gain": 0.1}
    drift = {"drift_rate_gain": [1e-3, 2e-3], "drift_gain": [1e-4, 1e-5]}
    law = tv.Autopilot(**gains, **drift, acceleration_gain=[1e-3, 2e-3])
    points = np.array([1.1, 3.3])
    tv.control.GainSchedule(points, law, variable).to_csv(tmp_path / "gains.csv")
    table, of_filters = load_gains(tmp_path / "gains.csv")
    assert (table.variable, table.breakpoints.tolist(), of_filters) == (variable, [1.1, 3.3], {})
    assert "integral_gain" not in table.gains
    for name, values in table.gains.items():
        expected = np.broadcast_to(getattr(law, name), (2,))
        np.testing.assert_allclose(values, expected, rtol=1e-15)


def test_the_numbers_of_a_notch_at_a_mode_are_interpolated_in_the_variable() -> None:
    made, width = flight(), np.array([0.3, 0.4, 0.6, 0.5, 0.7])
    notch = tv.control.ModeNotch(mode="first", zero_damping=0.05, pole_damping=width)
    schedule = replace(autopilot(), notches=(notch,))
    want = replace(notch, pole_damping=0.5).at(made, 60.0)
    np.testing.assert_allclose(
        schedule.along(made, 60.0).filters[-1].denominator, want.denominator, rtol=1e-14
    )
    with pytest.raises(InputError, match=r"first must have one number for each of the 5 .* \(2,\)"):
        replace(schedule, notches=(replace(notch, pole_damping=[0.3, 0.4]),))
    with pytest.raises(InputError, match="broadcast|shapes"):
        notch.at(made, [50.0, 60.0])


def test_times_of_equal_pressure_need_other_gains() -> None:
    made = flight(flexible=False)
    times = np.linspace(30.0, 110.0, 81)
    needed = autopilot().along(made, times)
    pairs = tv.control.equal_values(made, "dynamic_pressure", times, needed)
    assert pairs.value.size > 10
    for variable in ("time", "speed", "altitude", "mach"):
        assert tv.control.equal_values(made, variable, times, needed).value.size == 0
    first, second = (
        tv.ascent.flight_variable(made, "dynamic_pressure", t)
        for t in (pairs.first_time, pairs.second_time)
    )
    # straight lines over a second: the second difference of q over eight
    bend = np.abs(np.diff(tv.ascent.flight_variable(made, "dynamic_pressure", times), 2)).max()
    np.testing.assert_allclose(first, second, rtol=0, atol=0.125 * bend)
    k = int(np.argmax(pairs.difference))
    gains = [autopilot().at(t[k]).attitude_gain for t in (pairs.first_time, pairs.second_time)]
    assert pairs.attitude_gain_ratio[k] == pytest.approx(gains[1] / gains[0], rel=1e-12)
    assert pairs.difference[k] > 0.2
    assert pairs.table().rows[0][1][0].value == pairs.first_time[k]
    assert pairs.to_csv().splitlines()[0].startswith("pair,value,first_time_s")


def test_breakpoints_that_do_not_rise_are_refused_with_what_to_do() -> None:
    pressure = tv.ascent.flight_variable(flight(), "dynamic_pressure", TIMES)
    with pytest.raises(InputError, match="a part of the flight in which it rises"):
        tv.control.GainSchedule(pressure, autopilot().autopilot, "dynamic_pressure")
