"""Margins over the flight: those of single times, their worst, and detuned modes."""

from dataclasses import replace

import numpy as np
import pytest

import tvclin as tv
from tests.turns import usual
from tests.whole_flight import Filter, autopilot, flight
from tvclin import InputError
from tvclin.base.lines import text

NOTCHES = tuple(
    tv.control.ModeNotch(mode=name, zero_damping=0.1, pole_damping=0.6)
    for name in ("first", "second")
)
TIMES = np.array([35.0, 50.0, 75.0])


def schedule(**options) -> tv.control.GainSchedule:
    made = autopilot(filters=(Filter.low_pass(40.0, 0.7),), **options)
    return replace(made, notches=NOTCHES)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "options", usual([{"sample_rate": 50.0}, {}], 0), ids=["sampled", "continuous"]
)
def test_a_sweep_is_the_single_times_to_the_last_digit(options) -> None:
    laws, made = schedule(**options), flight()
    swept = tv.control.sweep(made, laws, TIMES)
    assert swept.mode_names == ("first", "second", "lox")
    for k, time in list(enumerate(TIMES))[1:2]:
        vehicle = made.at(time)
        plant = tv.FlexiblePlant.from_vehicle(vehicle.rigid, vehicle.structure)
        law = laws.along(made, time)
        bands = law.band_margins(plant)
        for name in ("aero_margin", "gain_increase", "phase_margin", "disk_margin"):
            assert getattr(swept.margins, name)[k] == getattr(bands.margins, name)
        for mode, band in zip(swept.modes, bands.modes, strict=True):
            assert (mode.peak[k], mode.distance[k]) == (band.peak, band.distance) or (
                np.isnan(mode.peak[k]) and np.isnan(band.peak)
            )
        rows = tv.control.detuned(law, plant, factors=[0.9, 1.1]).margins
        for name in ("gain_increase", "phase_margin"):
            np.testing.assert_array_equal(
                getattr(swept.detuned, name)[:, k], getattr(rows, name)[1:7]
            )
        one = tv.control.sweep(made, laws, [time])
        np.testing.assert_array_equal(one.minimum_damping, swept.minimum_damping[k])


def test_the_poles_of_a_continuous_loop_are_those_of_its_closed_system() -> None:
    made = flight(flexible=False)
    laws = autopilot(delay=0.0)
    swept = tv.control.sweep(made, laws, TIMES)
    for k, time in list(enumerate(TIMES))[::2]:
        closed = laws.along(made, time).close(made.plants(time, "drift-exact", "pitch")).poles()
        got = np.sort_complex(swept.poles[k][~np.isnan(swept.poles[k])])
        np.testing.assert_allclose(got, np.sort_complex(closed), rtol=1e-9, atol=1e-12)
    assert swept.modes == ()
    assert swept.changes == ()


def test_the_worst_margin_has_its_time_and_its_change() -> None:
    swept = tv.control.sweep(flight(), schedule(sample_rate=50.0), TIMES)
    worst = {w.margin: w for w in swept.worst}
    phase = worst["phase"]
    k = int(np.argmin(swept.margins.phase_margin))
    assert (phase.time, phase.value) == (TIMES[k], swept.margins.phase_margin_deg[k])
    change = next(w for name, w in worst.items() if name.startswith("gain may rise, "))
    c, k = np.unravel_index(np.argmin(swept.detuned.gain_increase), (6, 3))
    assert change.margin == f"gain may rise, {swept.changes[c]}"
    assert (change.time, change.satisfied) == (TIMES[k], change.value >= 6.0)
    rows = [[text(cell) for cell in row] for row in swept.table().rows]
    assert rows[0][0] == "aero: gain may fall"
    assert len(rows) == len(swept.worst) + 1
    lines = swept.to_csv().splitlines()
    assert lines[0].startswith("time_s,status,aero_margin_dB")
    assert len(lines) == 4


def test_an_unstable_time_is_told_and_never_met() -> None:
    laws = replace(autopilot().autopilot, attitude_gain=0.05, rate_gain=0.05)
    weak = tv.control.GainSchedule(autopilot().breakpoints, laws)
    swept = tv.control.sweep(flight(), weak, TIMES)
    assert not swept.all_satisfied
    assert np.isnan(swept.worst[0].value)
    assert text(swept.table().rows[0][1]) == "unstable"


def test_criteria_of_modes_apply_to_each_by_name() -> None:
    criteria = tv.control.CRITERIA["classic"].with_limits("a test", mode_gain_margin_dB=3.0)
    swept = tv.control.sweep(flight(), schedule(sample_rate=50.0), TIMES, criteria=criteria)
    judged = [j for j in swept.judgements if j.band == "first"]
    np.testing.assert_array_equal(judged[0].value, swept.modes[0].gain_margin_dB)
    with pytest.raises(InputError, match="criteria of modes need a flight with a structure"):
        tv.control.sweep(flight(flexible=False), autopilot(), TIMES, criteria=criteria)


def test_the_figure_has_a_panel_for_each_criterion() -> None:
    swept = tv.control.sweep(flight(), schedule(sample_rate=50.0), TIMES)
    curves = tv.plots.curves_of(tv.plots.sweep_chart(swept))
    assert list(curves.panels) == ["aero: gain may fall", "gain may rise", "phase"]
    np.testing.assert_array_equal(
        curves.column("whole loop", "phase"), swept.margins.phase_margin_deg
    )
    lowest = np.degrees(swept.detuned.phase_margin.min(axis=0))
    np.testing.assert_allclose(curves.column("worst detuned mode", "phase"), lowest, rtol=1e-14)
    assert set(curves.column("criterion", "phase")) == {30.0}


def test_a_flight_with_the_structure_of_its_vehicle_has_the_modes_of_that() -> None:
    """At each time the margins of the whole loop are those of the one plant there."""
    flight = tv.load_schedule("made-up-launcher")
    coefficients = tv.Coefficients.from_vehicle(flight.at(65.0))
    law = tv.design_gains(coefficients, natural_frequency=1.5, damping=0.7)
    law, times = replace(law, actuator=tv.control.Actuator()), [60.0, 65.0]
    margin_sweep = tv.control.sweep(flight, law, times, factors=())
    for k, time in enumerate(times):
        vehicle = flight.at(time)
        plant = tv.FlexiblePlant.from_vehicle(vehicle.rigid, vehicle.structure)
        single = law.band_margins(plant)
        expected = single.margins.phase_margin_deg
        assert margin_sweep.margins.phase_margin_deg[k] == pytest.approx(expected, rel=1e-9)
        assert [mode.name for mode in margin_sweep.modes] == [mode.name for mode in single.modes]
