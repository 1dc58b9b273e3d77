"""Turbulence: its filters have the spectra of the specification, and its samples those filters."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import welch

import tvclin as tv
from tvclin.base.errors import InputError
from tvclin.winds.turbulence import COMPONENTS, SPECTRA

FOOT = 0.3048
SPEED = 538.81


def fitted(turbulence, omega, speed):
    """Return the one-sided spectrum of the shaping filter at one frequency."""
    A, b, c = turbulence.shaping_filter(speed)
    response = c @ np.linalg.solve(1j * omega * np.eye(len(A)) - A, b)
    return abs(response.item()) ** 2 / np.pi


@pytest.mark.parametrize("component", COMPONENTS)
@pytest.mark.parametrize("spectrum", SPECTRA)
def test_the_integral_of_a_spectrum_is_the_variance(spectrum, component):
    air = tv.winds.Turbulence(6.0, spectrum=spectrum, component=component)
    corner = SPEED / air.length
    ends = [0.0, *corner * 10.0 ** np.arange(-2, 9)]
    parts = [
        quad(lambda w: float(air.power_spectrum(w, SPEED)), *pair, epsrel=1e-10)[0]
        for pair in pairwise(ends)
    ]
    # the factor 1.339 of von Karman is rounded from Gamma(1/3)/(sqrt(pi) Gamma(5/6)) = 1.338982
    assert np.isclose(sum(parts), 36.0, rtol={"dryden": 1e-7, "von-karman": 2e-5}[spectrum])


@pytest.mark.parametrize("component", COMPONENTS)
def test_a_dryden_filter_has_exactly_its_spectrum(component):
    air = tv.winds.Turbulence(6.0, 533.4, component=component)
    for omega in (0.01, 0.3, 2.0, 50.0):
        assert np.isclose(fitted(air, omega, SPEED), air.power_spectrum(omega, SPEED), rtol=1e-12)


@pytest.mark.parametrize(("component", "error_dB"), [("along", 0.26), ("transverse", 0.23)])
def test_the_fit_of_von_karman_has_the_error_that_it_states(component, error_dB):
    air = tv.winds.Turbulence(6.0, spectrum="von-karman", component=component)
    corner = SPEED / air.length
    decibels = [
        10.0 * np.log10(fitted(air, w, SPEED) / air.power_spectrum(w, SPEED))
        for w in corner * np.logspace(-3, 1, 81)
    ]
    assert -0.04 < min(decibels)
    assert max(decibels) == pytest.approx(error_dB, abs=0.005)
    far = 100.0 * corner
    missing = {"along": -2.4, "transverse": -1.8}[component]
    beyond = 10.0 * np.log10(fitted(air, far, SPEED) / air.power_spectrum(far, SPEED))
    assert beyond == pytest.approx(missing, abs=0.05)


@pytest.mark.parametrize(
    ("exceedance", "feet", "feet_per_s"),
    [("severe", 15000, 22.1), ("moderate", 7500, 10.1), ("light", 35000, 0.4), (1e-6, 25000, 31.0)],
)
def test_intensities_are_those_of_the_specification(exceedance, feet, feet_per_s):
    air = tv.winds.Turbulence.mil_f_8785c(exceedance).at(feet * FOOT)
    assert np.isclose(air.intensity, feet_per_s * FOOT)
    assert np.isclose(air.length, 533.4)


def test_below_1000_ft_the_wind_at_20_ft_sets_the_intensity():
    across = tv.winds.Turbulence.mil_f_8785c("moderate").at(500 * FOOT)
    up = tv.winds.Turbulence.mil_f_8785c("moderate", component="along").at(500 * FOOT)
    factor, wind = 0.177 + 0.000823 * 500, 30.0 * 1852 / 3600
    assert np.isclose(across.intensity, 0.1 * wind / factor**0.4)
    assert np.isclose(across.length, 500 * FOOT / factor**1.2)
    assert np.isclose(up.intensity, 0.1 * wind)
    assert np.isclose(up.length, 500 * FOOT)
    # straight lines between 1000 and 2000 ft, where the table is 23 to 17.6 ft/s
    severe = tv.winds.Turbulence.mil_f_8785c("severe")
    table = 17.6 + (23.0 - 17.6) * 250 / 2000
    middle = 0.5 * (0.1 * 45.0 * 1852 / 3600 + FOOT * table)
    assert np.isclose(severe.at(1500 * FOOT).intensity, middle)
    assert np.isclose(severe.at(1500 * FOOT).length, 1375 * FOOT)


def test_welch_finds_the_spectrum_of_the_filter_in_samples():
    air = tv.winds.Turbulence(6.0, 533.4)
    step, count = 0.05, 2**14
    samples = air.samples(step * np.arange(count), SPEED, seed=5, runs=8)
    hertz, density = welch(samples, 1.0 / step, nperseg=2048)
    density, omega = density.mean(axis=0), 2.0 * np.pi * hertz
    # 15 half-overlapping segments of each run, of which about 0.55 count as independent
    spread = np.sqrt(1.0 / (0.55 * 8 * 15))
    band = slice(5, 200)  # windows blur below, samples fold above
    expected = 2.0 * np.pi * air.power_spectrum(omega[band], SPEED)
    assert np.abs(density[band] / expected - 1.0).max() < 5.0 * spread
    assert abs(np.mean(density[band] / expected) - 1.0) < 0.03


def test_samples_keep_their_covariance_at_any_steps_speeds_and_altitudes():
    air = tv.winds.Turbulence([3.0, 9.0], [300.0, 900.0], altitude=[0.0, 10_000.0])
    times, speed = np.array([0.0, 0.1, 0.9, 3.0]), np.array([300.0, 310.0, 390.0, 600.0])
    height = np.array([0.0, 100.0, 2000.0, 9000.0])
    runs = 4000
    wind = air.samples(times, speed, altitude=height, seed=1, runs=runs)
    sigma, length = air.over(height)
    advance = speed / length
    xi = np.concatenate([[0.0], np.cumsum(0.5 * (advance[1:] + advance[:-1]) * np.diff(times))])
    apart = np.abs(xi[:, np.newaxis] - xi)
    # autocorrelation of the transverse Dryden spectrum
    expected = np.outer(sigma, sigma) * np.exp(-apart) * (1.0 - 0.5 * apart)
    error = np.sqrt((np.outer(sigma, sigma) ** 2 + expected**2) / runs)
    assert np.all(np.abs(wind.T @ wind / runs - expected) < 5.0 * error)


def test_a_run_has_the_same_wind_whichever_others_are_drawn():
    air, times = tv.winds.Turbulence(6.0), 0.1 * np.arange(20)
    together = air.samples(times, SPEED, seed=7, runs=5)
    assert np.array_equal(air.samples(times, SPEED, seed=7, first=3, runs=2), together[3:])
    assert not np.array_equal(air.samples(times, SPEED, seed=8, runs=1), together[:1])
    angles = air.winds(times, SPEED, seed=7, runs=5)
    assert np.allclose(angles.angle, together / SPEED, rtol=1e-15)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: tv.winds.Turbulence(-1.0), "intensity must be between 0 and 10000; got -1 m/s"),
        (lambda: tv.winds.Turbulence(1.0, 0.0), "length must be between 0.001 and 1e"),
        (lambda: tv.winds.Turbulence([1.0, 2.0]), "one for each altitude"),
        (lambda: tv.winds.Turbulence(1.0, spectrum="karman"), "did you mean 'von-karman'"),
        (lambda: tv.winds.Turbulence(1.0, altitude=[1.0, 0.0]), "rising altitudes in m"),
        (lambda: tv.winds.Turbulence.mil_f_8785c(0.5), "from 1e-6 to 0.2"),
        (lambda: tv.winds.Turbulence.mil_f_8785c("severe").samples([0.0, 1.0], 9.0), "altitude"),
        (lambda: tv.winds.Turbulence(1.0).samples([1.0, 0.0], 9.0), "times must rise"),
    ],
)
def test_bad_turbulence_is_refused_in_a_sentence(make, sentence):
    with pytest.raises(InputError, match=sentence):
        make()


@pytest.mark.parametrize(
    "text",
    [
        "altitude_m,intensity_m_per_s,length_m\n0,3,200\n3048,6,533.4\n",
        "# of a site\naltitude [ft]; sigma [kt]; scale length [ft]\n"
        "0; 5,8315335; 656,167979\n10000; 11,663067; 1750\n",
    ],
)
def test_a_table_over_altitude_is_read_in_its_units(tmp_path, text):
    file = tmp_path / "turbulence.csv"
    file.write_text(text)
    air = tv.winds.read_turbulence(file, spectrum="von-karman")
    assert air.spectrum == "von-karman"
    assert np.allclose(
        air.over([0.0, 1524.0, 3048.0, 9e3]), [[3, 4.5, 6, 6], [200, 366.7, 533.4, 533.4]]
    )


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("height_m,speed_kt\n0,3\n1,2\n", "no line of names such as altitude_m"),
        ("altitude,intensity_m_per_s\n0,3\n9,2\n", "column altitude has no known unit"),
        ("altitude_m,intensity_m_per_s\n0,3\n9,\n", "line 3: there is no number in intensity"),
        ("altitude_m,intensity_m_per_s\n5,3\n2,2\n", "turbulence.csv.*rising altitudes"),
        ("altitude_m,sigma_kt,rms_kt\n0,3,2\n9,2,2\n", "two columns of the intensity"),
    ],
)
def test_a_table_that_cannot_be_read_is_refused_in_a_sentence(tmp_path, text, sentence):
    file = tmp_path / "turbulence.csv"
    file.write_text(text)
    with pytest.raises(InputError, match=sentence):
        tv.winds.read_turbulence(file)


@pytest.mark.parametrize(
    ("spectrum", "component"), [("dryden", "transverse"), ("von-karman", "along")]
)
def test_below_a_cutoff_the_spectrum_is_that_behind_a_high_pass(spectrum, component):
    whole = tv.winds.Turbulence(6.0, spectrum=spectrum, component=component)
    air = replace(whole, cutoff_wavelength=800.0)
    for omega in (0.1, 2.0, 2.0 * np.pi * SPEED / 800.0, 30.0):
        power = (omega * 800.0 / (2.0 * np.pi * SPEED)) ** 4
        expected = power / (1.0 + power)
        assert np.isclose(fitted(air, omega, SPEED) / fitted(whole, omega, SPEED), expected)
        ratio = air.power_spectrum(omega, SPEED) / whole.power_spectrum(omega, SPEED)
        assert np.isclose(ratio, expected)
    left = quad(lambda w: fitted(air, w, SPEED), 0.0, np.inf, limit=400)[0] / 36.0
    assert np.isclose(air.remaining_variance(), left, rtol=1e-5)
    assert whole.remaining_variance() == pytest.approx(1.0)
    long = replace(whole, cutoff_wavelength=1e9)
    assert np.isclose(long.remaining_variance(), 1.0, rtol=1e-5)


def test_a_sounding_resolves_twice_its_widest_gap():
    profile = tv.winds.WindProfile(
        height=[0.0, 100.0, 400.0, 600.0], east=[1.0] * 4, north=[0.0] * 4
    )
    assert profile.resolved_wavelength == 600.0


@pytest.mark.thorough
def test_samples_below_a_cutoff_have_its_covariance_while_speed_and_length_change():
    air = tv.winds.Turbulence([4.0, 8.0], [300.0, 900.0], altitude=[0.0, 9e3])
    air = replace(air, cutoff_wavelength=600.0)
    times = np.linspace(0.0, 20.0, 401)
    speed, height = 200.0 + 30.0 * times, 450.0 * times
    wind = air.samples(times, speed, altitude=height, seed=3, runs=4000)
    for k in (0, 100, 400):
        sigma = air.over(height[k])[0]
        expected = sigma * np.sqrt(air.remaining_variance(height[k]))
        # a filter that changes within its memory is off by the change in it: 600 m of some km
        assert np.isclose(wind[:, k].std(), expected, rtol=5.0 / np.sqrt(8000.0) + 0.02)
