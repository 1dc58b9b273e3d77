"""Flight times by winds, frozen: the same numbers as the rooms it is made of, and what it says."""

import csv
import io
import sys

import numpy as np
import pytest

import tvclin as tv
from tvclin import InputError
from tvclin.requirement.flight.flight_winds import place
from tvclin.requirement.flight.frozen_requirement import slow_mode

PEAK = np.radians(5)


def held(vehicle: tv.Vehicle) -> tv.FlightSchedule:
    """Return a flight on which nothing changes."""
    return tv.FlightSchedule(vehicle.replace(time=[40.0, 66.0, 120.0]))


def turning(vehicle: tv.Vehicle) -> tv.FlightSchedule:
    """Return a flight on which speed and dynamic pressure rise."""
    growth = np.array([0.8, 1.0, 1.3])
    return tv.FlightSchedule(
        vehicle.replace(
            time=[40.0, 66.0, 120.0],
            velocity=vehicle.velocity * growth,
            normal_force_slope=vehicle.normal_force_slope * growth**2,
        )
    )


def test_a_vehicle_that_does_not_change_needs_exactly_what_it_needs_frozen(configuration) -> None:
    wind = tv.TriangularWind(peak=PEAK, duration=7.5)
    sizing = tv.size(
        held(configuration), wind, times=[50.3, 66.0, 101.7], dead_bands=(1.0, 0.5, 0.0)
    )
    plant = tv.Plant.from_vehicle(configuration, "drift-exact")
    needed = np.abs(tv.required_deflection(plant, wind, (1.0, 0.5, 0.0)).deflection)

    for k, K in enumerate((1, 0.5, 0)):
        assert sizing.required[f"K = {K:g}"] == pytest.approx(np.full((3, 1), needed[k]), rel=1e-12)
    least = tv.optimum_deflection(plant, wind).peak
    assert sizing.required["minimum"] == pytest.approx(np.full((3, 1), least), rel=1e-12)
    assert np.all(
        sizing.required["no forecast"]
        == max(abs(tv.forecast_free_limit(plant, wind).deflection), least)
    )
    assert np.all(sizing.required["trim"] == plant.coefficients.B * PEAK)
    assert np.all(sizing.change == 0.0)
    assert np.all(sizing.steady)


def test_without_a_forecast_no_less_is_required_than_with_the_wind_known() -> None:
    """Early in a flight the minimum over both modes exceeds the bound of the fast mode."""
    slow = tv.Vehicle(
        weight=372653.0,
        moment_of_inertia=1492308.0,
        normal_force_slope=59979.0,
        thrust=626956.0,
        aerodynamic_arm=3.208,
        control_arm=8.277,
        axial_force=6083.0,
        velocity=115.12,
        attitude=1.38755,
    )
    wind, plant = (
        tv.TriangularWind(peak=PEAK, duration=7.5),
        tv.Plant.from_vehicle(slow, "drift-exact"),
    )
    least = tv.optimum_deflection(plant, wind).peak
    assert abs(tv.forecast_free_limit(plant, wind).deflection) == pytest.approx(least, rel=1e-9)
    sizing = tv.size(held(slow), wind, times=[66.0], varying=False)
    np.testing.assert_allclose(sizing.required["no forecast"], least, rtol=1e-9)
    study = tv.Study.from_vehicle(slow, duration=7.5, peak=PEAK)
    assert study.needs["forecast_free"] == pytest.approx(study.minima, rel=1e-9)


def test_dead_bands_that_differ_in_the_seventh_digit_have_a_number_each(configuration) -> None:
    wind, bands = tv.TriangularWind(peak=PEAK, duration=7.5), (0.3333334, 0.3333333)
    sizing = tv.size(held(configuration), wind, times=[66.0], dead_bands=bands, varying=False)
    plant = tv.Plant.from_vehicle(configuration, "drift-exact")
    needed = np.abs(tv.required_deflection(plant, wind, bands).deflection)
    assert needed[0] > needed[1]
    for K, deflection in zip(bands, needed, strict=True):
        requirement = tv.requirement.Requirement(dead_band=K)
        assert sizing.required[requirement][0, 0] == pytest.approx(deflection, rel=1e-12)
        assert sizing.required[f"K = {K}"] is sizing.required[requirement]


def test_each_time_has_the_vehicle_of_that_time(configuration_i) -> None:
    schedule = turning(configuration_i)
    sizing = tv.size(
        schedule, tv.TriangularWind(peak=PEAK, duration=7.5), times=[53.0, 93.0], model="drift"
    )
    # half way along straight lines: 0.9 and 1.15 of the speed, 0.82 and 1.345 of the force slope
    for i, (speed, slope) in enumerate([(0.9, 0.82), (1.15, 1.345)]):
        vehicle = configuration_i.replace(
            velocity=configuration_i.velocity * speed,
            normal_force_slope=configuration_i.normal_force_slope * slope,
        )
        study = tv.Study.from_vehicle(vehicle, duration=7.5, peak=PEAK, model="drift")
        assert sizing.required["K = 1"][i, 0] == pytest.approx(study.nominal_deflection, rel=1e-12)


def test_a_pulse_is_moved_until_its_peak_meets_the_time(configuration_i) -> None:
    winds = {
        "triangle": tv.TriangularWind(peak=PEAK, duration=8.0),
        "sawtooth": tv.winds.AsymmetricTriangularWind(peak=PEAK, duration=8.0, peak_time=6.0),
        "trapezoid": tv.winds.TrapezoidalWind(peak=PEAK, rise=1.0, hold=4.0, fall=3.0),
    }
    sizing = tv.size(held(configuration_i), winds, times=[70.0])

    assert sizing.begins[0] == pytest.approx([66.0, 64.0, 67.0], abs=1e-12)
    assert sizing.ends[0] == pytest.approx([74.0, 72.0, 75.0], abs=1e-12)


def test_winds_in_flight_time_stand_beside_pulses(configuration_i) -> None:
    winds = {
        "pulse": tv.TriangularWind(peak=PEAK, duration=8.0),
        "measured": tv.SampledWind(time=[50.0, 60.0, 70.0], angle=[0.0, 0.08, 0.0]),
    }
    sizing = tv.size(
        held(configuration_i), winds, times=[66.0], placing={"measured": "flight"}, window=8.0
    )
    assert (sizing.begins[0].tolist(), sizing.ends[0].tolist()) == ([62.0, 62.0], [70.0, 70.0])
    for placing, words in (
        ({"mesured": "flight"}, "did you mean 'measured'"),
        ({"pulse": "up"}, "placing of pulse must be one of"),
    ):
        with pytest.raises(InputError, match=words):
            tv.size(held(configuration_i), winds, times=[66.0], placing=placing)


def test_a_wind_in_flight_time_is_cut_where_it_is(configuration_i) -> None:
    wind = tv.SampledWind(time=[50.0, 60.0, 70.0], angle=[0.0, 0.08, 0.0])
    placed = place(wind, configuration_i, 66.0, "flight", 8.0)
    sizing = tv.size(
        held(configuration_i), wind, times=[45.0, 66.0, 100.0], placing="flight", window=8.0
    )

    t = np.array([61.9, 62.1, 66.0, 69.9, 70.1])
    assert placed.in_flight(t) == pytest.approx(np.where((t > 62) & (t < 70), wind(t), 0.0))
    assert sizing.required["trim"][:, 0] == pytest.approx(
        [0.0, 0.064 * tv.Coefficients.from_vehicle(configuration_i).B, 0.0]
    )
    assert sizing.required["K = 1"][2, 0] == 0.0  # a calm needs nothing


@pytest.mark.parametrize(("name", "within", "beyond"), [("I", 26.5, 35.0), ("II", 27.0, 45.0)])
def test_a_wind_beyond_the_single_pole_says_so_and_has_the_minimum_of_its_model(
    configuration_i, configuration_ii, name, within, beyond
) -> None:
    vehicle = {"I": configuration_i, "II": configuration_ii}[name]
    winds = {f"{t:g} s": tv.TriangularWind(peak=PEAK, duration=t) for t in (within, beyond)}
    c = tv.Coefficients.from_vehicle(vehicle)
    for model, says in (("fixed-path", "leaves out the slow pole"), ("drift-exact", "two poles")):
        sizing = tv.size(held(vehicle), winds, times=[80.0], model=model)
        plant = tv.Plant(c, model)
        minimum = [tv.optimum_deflection(plant, wind).peak for wind in winds.values()]
        assert sizing.beyond_single_pole.tolist() == [[False, True]]
        assert sizing.required["minimum"][0] == pytest.approx(minimum, rel=1e-6)
        (note,) = [note for note in sizing.notes if "single-pole" in note]
        assert note.startswith(f"{beyond:g} s (")
        assert says in note
    # the edge of any wind is that of triangles for a triangle
    edge = tv.TriangularWind(peak=PEAK, duration=sizing.edge[0])
    assert slow_mode(tv.Plant(c, "fixed-path"), edge) == pytest.approx(1.0, rel=1e-9)


def test_a_wind_speed_makes_a_larger_angle_at_a_lower_speed(configuration_i) -> None:
    def jet(vehicle: tv.Vehicle) -> tv.TriangularWind:
        angle = tv.angle_from_speed(60.0, vehicle.velocity, vehicle.attitude)
        return tv.TriangularWind(peak=angle, duration=7.5)

    sizing = tv.size(turning(configuration_i), jet, times=[66.0, 120.0])
    B = [tv.Coefficients.from_vehicle(sizing.schedule.at(t)).B for t in (66.0, 120.0)]
    speeds = configuration_i.velocity * np.array([1.0, 1.3])
    angles = np.arcsin(60.0 * np.sin(configuration_i.attitude) / speeds)

    assert sizing.required["trim"][:, 0] == pytest.approx(np.array(B) * angles, rel=1e-14)


def test_a_dead_band_without_an_exit_is_noted_where_poles_are_a_pair_during_a_wind() -> None:
    """At 20 s they are real, but the pulse begins at 16.25 s, when they are a pair until 17.5 s."""
    schedule = tv.FlightSchedule(
        tv.Vehicle(
            time=[16.0, 20.0, 24.0, 28.0],
            weight=[380498.0, 372653.0, 364807.0, 356961.0],
            moment_of_inertia=[1.51385e6, 1.49231e6, 1.47077e6, 1.44923e6],
            normal_force_slope=[37951.0, 59978.6, 86629.7, 118000.0],
            thrust=[624500.0, 626956.0, 629837.0, 633000.0],
            aerodynamic_arm=[3.226, 3.208, 3.189, 3.17],
            control_arm=[8.262, 8.277, 8.292, 8.307],
            axial_force=[3816.13, 6082.86, 8953.36, 12400.0],
            velocity=[89.21, 115.12, 142.81, 172.0],
            attitude=np.radians([82.575, 79.501, 76.205, 72.8]),
        )
    )
    wind = tv.TriangularWind(peak=PEAK, duration=7.5)
    sizing = tv.size(schedule, wind, times=[20.0, 23.0], dead_bands=[1.0, 0.5])
    along, frozen = sizing.required["K = 0.5, varying"][:, 0], sizing.required["K = 0.5"][:, 0]
    assert along[0] > 4.0 * frozen[0]
    assert along[1] < 1.2 * frozen[1]
    notes = " ".join(sizing.notes)
    assert "at 20 s, parameters varying: two unstable poles are a pair" in notes
    assert "K = 1 then counts all of trim there" in notes
    assert "K < 1 requires the largest trim over K" in notes


def test_what_is_doubtful_is_said(configuration_i) -> None:
    winds = {
        "long": tv.TriangularWind(peak=PEAK, duration=20.0),
        "turns": tv.SampledWind(time=[0.0, 2.0, 4.0, 6.0], angle=[0.0, 0.1, -0.1, 0.0]),
    }
    sizing = tv.size(turning(configuration_i), winds, times=[45.0, 66.0], varying=False)

    assert np.all(np.isnan(sizing.required["K = 1"][:, 1]))
    assert np.all(sizing.required["minimum"] > 0.0)
    assert sizing.covered.tolist() == [[False, True], [True, True]]
    assert not sizing.steady[1, 0]
    said = " | ".join(sizing.notes)
    for words in (
        "must not change its sign",
        "frozen parameters are doubtful",
        "beyond the sched",
    ):
        assert words in said
    # beta changes as the root of N, B as N itself: from 56 to 76 s, over 66 s
    slope = np.interp([56.0, 76.0], [40.0, 66.0, 120.0], np.array([0.8, 1.0, 1.3]) ** 2)
    assert sizing.change[1, 0] == pytest.approx(np.abs(slope - 1.0).max(), rel=1e-12)


def test_the_law_can_be_flown_instead_of_bounded(configuration_i) -> None:
    wind = tv.TriangularWind(peak=PEAK, duration=7.5)
    sizing = tv.size(held(configuration_i), wind, times=[66.0], model="fixed-path", law="flown")
    plant = tv.Plant.from_vehicle(configuration_i, "fixed-path")

    bound = abs(tv.forecast_free_limit(plant, wind).deflection)
    assert bound < sizing.required["no forecast"][0, 0] < 1.1 * bound


def test_a_stable_vehicle_needs_nothing(configuration_i) -> None:
    stable = configuration_i.replace(aerodynamic_arm=-2.0)
    sizing = tv.size(
        held(stable), tv.TriangularWind(peak=PEAK, duration=7.5), times=[66.0], model="fixed-path"
    )
    for name in ("K = 1", "no forecast", "minimum"):
        assert sizing.required[name][0, 0] == 0.0


def test_table_dataset_and_worst_hold_the_same_numbers(configuration_i, tmp_path) -> None:
    pytest.importorskip("xarray")
    winds = {k: tv.TriangularWind(peak=PEAK, duration=t) for k, t in (("a", 5.0), ("b", 9.0))}
    sizing = tv.size(turning(configuration_i), winds, times=[50.0, 66.0, 100.0])
    rows = list(csv.DictReader(io.StringIO(sizing.to_csv(tmp_path / "table.csv"))))
    data = sizing.to_xarray()

    assert (tmp_path / "table.csv").read_text() == sizing.to_csv()
    assert len(rows) == 6
    for i, time in enumerate(sizing.times):
        for j, wind in enumerate(sizing.winds):
            row = rows[2 * i + j]
            here = data.sel(time=time, wind=wind)
            assert (float(row["time_s"]), row["wind"]) == (time, wind)
            need = sizing.required["K = 0.5"][i, j]
            assert np.radians(float(row["K0.5_deg"])) == pytest.approx(need, rel=1e-15)
            assert float(here["K0.5"]) == need
            assert float(here["no_forecast"]) == sizing.required["no forecast"][i, j]
    worst = sizing.worst["K = 1"]
    assert worst.deflection == sizing.required["K = 1"].max() == sizing.at_times("K = 1").max()
    assert float(data["K1"].sel(time=worst.time, wind=worst.wind)) == worst.deflection
    assert data["trim"].attrs["units"] == "rad"


def test_what_is_defined_nowhere_has_no_worst(configuration_i) -> None:
    turns = tv.SampledWind(time=[0.0, 2.0, 4.0, 6.0], angle=[0.0, 0.1, -0.1, 0.0])
    sizing = tv.size(held(configuration_i), turns, times=[66.0])

    assert "K = 1" not in sizing.worst
    assert sizing.worst["minimum"].deflection == sizing.required["minimum"][0, 0]


def test_a_dataset_says_what_it_needs(configuration_i, monkeypatch) -> None:
    sizing = tv.size(
        held(configuration_i), tv.TriangularWind(peak=PEAK, duration=7.5), times=[66.0]
    )
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(InputError, match=r"needs xarray, .*not installed: .*tvclin\[campaign\]"):
        sizing.to_xarray()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"times": [200.0]}, "time must be between 40 and 120 s"),
        ({"times": []}, "one number or more"),
        ({"dead_bands": 1.5}, "dead_bands must be between"),
        ({"model": "drft"}, "model must be one of"),
        ({"placing": "centre"}, "placing must be one of"),
        ({"law": "trim"}, "law must be one of"),
        ({"placing": "flight", "window": 0.0}, "window must be positive"),
        ({"winds": {}}, "one wind or more"),
        ({"winds": tv.TriangularWind(peak=[0.1, 0.2], duration=5.0)}, "one history"),
        ({"winds": tv.linear.ConstantDeflection(limit=0.1)}, "must end"),
        ({"winds": lambda vehicle: 3.0}, "one history"),
        ({"schedule": 3}, "schedule must be a FlightSchedule"),
    ],
)
def test_bad_input_is_one_sentence(configuration_i, changes, words) -> None:
    given = {
        "schedule": held(configuration_i),
        "winds": tv.TriangularWind(peak=PEAK, duration=7.5),
        **changes,
    }
    with pytest.raises(InputError, match=words):
        tv.size(**given)
