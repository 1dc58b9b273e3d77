"""Boundaries of laws: the report's limits where trim is the law, and the table of the lean law."""

import numpy as np
import pytest

import tvclin as tv

PEAK = np.radians(5.0)
HARDWARE = {
    "actuator": tv.Actuator(natural_frequency=20.0, damping=0.7),
    "rate_limit": np.radians(5.0),
}


def plant_of(model="fixed-path"):
    return tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), model)


def triangle(plant, tau_beta, peak=PEAK):
    return tv.TriangularWind(peak=peak, duration=tau_beta / plant.coefficients.beta)


def limit(plant, law, tau_beta, **options):
    options = {"sample_rate": 100.0} | options
    return tv.closed_loop_boundary(plant, law, triangle(plant, tau_beta), **options).limit


@pytest.mark.parametrize("tau_beta", [2.0, 8.0])
def test_trim_as_a_feedback_has_the_boundary_of_eq_12(tau_beta):
    plant = plant_of()
    expected = tv.boundary_limit(plant, triangle(plant, tau_beta)).limit
    assert limit(plant, tv.TrimLaw(plant), tau_beta) == pytest.approx(expected, abs=0.002)


def test_trim_that_holds_the_attitude_meets_the_literal_dead_band_with_drift():
    plant = plant_of("drift-exact")
    expected = tv.boundary_limit(plant, triangle(plant, 8.0), 1.0, "literal").limit
    assert limit(plant, tv.TrimLaw(plant_of()), 8.0) == pytest.approx(expected, abs=0.002)


def test_the_dead_band_law_comes_near_the_open_loop_limit_of_a_wind_that_goes_on():
    plant = plant_of()
    expected = tv.boundary_limit(plant, triangle(plant, 4.0), 0.5).limit
    found = limit(plant, tv.DeadBandLaw(plant), 4.0)
    assert expected <= found + 1e-3 < expected + 0.005


@pytest.mark.parametrize(
    ("model", "tau_beta", "expected"),
    [("fixed-path", 4.0, 0.394), ("fixed-path", 8.0, 0.425), ("drift-exact", 4.0, 0.389)],
)
def test_the_recoverable_attitude_law_needs_what_is_known(model, tau_beta, expected):
    plant = plant_of(model)
    law = tv.RecoverableAttitudeLaw(plant, reach=0.95, design_peak=PEAK)
    found = limit(plant, law, tau_beta)
    assert found == pytest.approx(expected, abs=0.005)
    assert found >= tv.forecast_free_limit(plant, triangle(plant, tau_beta)).limit


def test_hardware_costs_little():
    plant = plant_of("drift-exact")
    law = tv.RecoverableAttitudeLaw(plant, reach=0.9, design_peak=PEAK)
    assert limit(plant, law, 4.0, **HARDWARE) == pytest.approx(0.399, abs=0.02)


def test_sudden_stops_cost_nothing_in_a_triangle():
    plant = plant_of()
    law = tv.RecoverableAttitudeLaw(plant, reach=0.9, design_peak=PEAK)
    with_stops = limit(plant, law, 4.0, cuts=12)
    assert with_stops == pytest.approx(limit(plant, law, 4.0), abs=0.002)


def test_the_edge_is_confirmed_by_flights_that_hit_every_event():
    plant = plant_of()
    wind = triangle(plant, 4.0)
    law = tv.RecoverableAttitudeLaw(plant, design_peak=PEAK)
    found = tv.closed_loop_boundary(plant, law, wind, sample_rate=200.0)
    times = np.array([wind.duration + 20.0])
    kept, lost = (
        tv.fly(plant, law, wind, times, deflection_limit=part * found.deflection)
        for part in (1.02, 0.98)
    )
    assert abs(kept.outputs["attitude"][0]) < 0.05 * PEAK
    assert abs(lost.outputs["attitude"][0]) > PEAK


def test_signs_and_peaks_do_not_matter():
    plant = plant_of()
    beta, expected = plant.coefficients.beta, []
    for B, peak in ((0.1, 0.05), (-0.1, 0.05), (0.1, -0.1)):
        other = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=beta, B=B))
        law = tv.RecoverableAttitudeLaw(other, design_peak=peak)
        wind = triangle(other, 4.0, peak)
        expected.append(tv.closed_loop_boundary(other, law, wind, sample_rate=50.0).limit)
    assert np.ptp(expected) < 1e-12


def test_a_reversal_makes_survival_fall_again_with_the_limit():
    plant = plant_of()
    wind = tv.standard_winds(PEAK, 4.0 / plant.coefficients.beta)["full reversal"]
    law = tv.RecoverableAttitudeLaw(plant, design_peak=PEAK)
    found = tv.closed_loop_boundary(plant, law, wind, sample_rate=50.0)
    assert not found.monotone
    assert found.limit > found.scan[~found.survives].max() - 1e-12


def test_no_limit_in_the_range():
    plant = plant_of()
    found = tv.closed_loop_boundary(
        plant, tv.TrimLaw(plant), triangle(plant, 4.0), sample_rate=50.0, highest=0.5
    )
    assert np.isinf(found.limit)
    assert found.status == "no limit in the range survives"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"sample_rate": 0.0}, "sample_rate must be positive"),
        ({"sample_rate": 20.0, **HARDWARE}, "sample_rate must be at least 40 Hz"),
        ({"lowest": 2.0, "highest": 1.0}, "highest must be above lowest"),
    ],
)
def test_bad_input_is_one_sentence(options, message):
    plant = plant_of()
    with pytest.raises(tv.InputError, match=message):
        limit(plant, tv.TrimLaw(plant), 4.0, **options)
