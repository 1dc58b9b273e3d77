"""The numbers the report prints in its text, at the places where it prints them."""

import pytest

import tvclin


def limit_of(vehicle, wind, tau_beta, dead_band=1.0, model="fixed-path"):
    plant = tvclin.Plant.from_vehicle(vehicle, model)
    gust = wind(peak=-0.1, duration=tau_beta / plant.coefficients.beta)
    return tvclin.boundary_limit(plant, gust, dead_band).limit


def test_table_i_beta_of_configuration_i_is_0_53(configuration_i):
    assert round(tvclin.Coefficients.from_vehicle(configuration_i).beta, 2) == 0.53


def test_table_i_beta_of_both_configurations(configuration_i, configuration_ii):
    first = tvclin.Coefficients.from_vehicle(configuration_i)
    second = tvclin.Coefficients.from_vehicle(configuration_ii)
    assert first.beta == pytest.approx(0.52928, abs=5e-6)
    assert second.beta == pytest.approx(0.39570, abs=5e-6)


def test_equation_2_trim_deflection_per_angle_of_attack(configuration_i, configuration_ii):
    first = tvclin.Coefficients.from_vehicle(configuration_i)
    second = tvclin.Coefficients.from_vehicle(configuration_ii)
    assert first.B == pytest.approx(0.107229, abs=5e-7)
    assert second.B == pytest.approx(0.0965056, abs=5e-8)


def test_results_a_wind_of_7_5_seconds_has_tau_beta_4(configuration_i):
    assert round(7.5 * tvclin.Coefficients.from_vehicle(configuration_i).beta) == 4


def test_results_98_percent_of_trim_for_a_rectangular_wind(configuration):
    y = limit_of(configuration, tvclin.RectangularWind, 4.0)
    assert y == pytest.approx(0.982, abs=5e-4)


@pytest.mark.parametrize(("dead_band", "percent", "limit"), [(1.0, 69, 0.6885), (0.5, 56, 0.5588)])
def test_results_69_and_56_percent_for_a_triangular_wind(configuration, dead_band, percent, limit):
    y = limit_of(configuration, tvclin.TriangularWind, 4.0, dead_band)
    assert y == pytest.approx(limit, abs=5e-5)
    assert round(100 * y) == percent


def test_results_without_dead_band_it_is_37_percent_where_the_text_reads_38(configuration):
    y = limit_of(configuration, tvclin.TriangularWind, 4.0, 0.0)
    assert y == pytest.approx(0.3738, abs=5e-5)


def test_figure_5a_drift_at_tau_beta_4(configuration_i, configuration_ii):
    first = limit_of(configuration_i, tvclin.TriangularWind, 4.0, model="drift")
    second = limit_of(configuration_ii, tvclin.TriangularWind, 4.0, model="drift")
    assert first == pytest.approx(0.6648, abs=5e-5)
    assert second == pytest.approx(0.6619, abs=5e-5)


def test_figure_5a_drift_takes_about_4_percent_off_at_tau_beta_4(configuration):
    drifting = limit_of(configuration, tvclin.TriangularWind, 4.0, model="drift")
    fixed = limit_of(configuration, tvclin.TriangularWind, 4.0)
    assert 1.0 - drifting / fixed == pytest.approx(0.04, abs=0.006)
