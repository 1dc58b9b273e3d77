"""The least peak of appendix C for a batch, and where two poles merge."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import tvclin
from tvclin import Coefficients, Plant, optimum_deflection
from tvclin.boundary.optimum.minimum_peak import minimum_peaks
from tvclin.vehicle.coefficients import NUMBERS

WIND = tvclin.TriangularWind(peak=-0.1, duration=12.0)


def plant_of_poles(first, second, third=0.9):
    """Return a drift-exact plant with two given unstable poles, and a stable one."""
    C1, minus = third - (first + second).real, (first * second).real - third * (first + second).real
    c = Coefficients(
        mu_alpha=-minus, mu_delta=2.0, C1=C1, C2=(first * second).real * third, b1=0.03, b2=0.02
    )
    return Plant(c, "drift-exact")


def test_where_two_poles_merge_nothing_jumps():
    peaks = []
    for apart in (1e-3, 1e-5, 1e-7, 0.0, 1e-7j, 1e-5j, 1e-3j):
        plant = plant_of_poles(0.2 + apart, 0.2 - apart)
        peaks.append(optimum_deflection(plant, WIND, float(WIND.onset)).peak)
        assert minimum_peaks(plant, WIND) == pytest.approx(peaks[-1], rel=1e-9)
    np.testing.assert_allclose(peaks[1:-1], peaks[3], rtol=1e-8)
    np.testing.assert_allclose(peaks, peaks[3], rtol=1e-4)
    assert peaks[0] < peaks[3] < peaks[-1] or peaks[0] > peaks[3] > peaks[-1]


def test_a_double_pole_asks_what_both_its_moments_do():
    plant, p = plant_of_poles(0.2, 0.2), 0.2
    best = optimum_deflection(plant, WIND, float(WIND.onset))
    # delta and the wind leave neither e^(pt) nor t e^(pt): F(p) = 0 and F'(p) = 0.
    turned, blown = (np.poly1d(plant.numerator("attitude", i)) for i in ("deflection", "wind"))

    def left(s):
        return turned(s) * best.deflection.laplace(s) + blown(s) * WIND.laplace(s)

    size = abs(turned(p) * best.peak / p)
    assert abs(left(p)) < 1e-9 * size
    assert abs(left(p + 1e-4) - left(p - 1e-4)) / 2e-4 < 1e-6 * size / p


@pytest.mark.thorough
@settings(max_examples=60, deadline=None)
@given(
    st.floats(0.02, 0.6),
    st.floats(1e-4, 0.95) | st.floats(1e-3, 3.0).map(lambda x: x * 1j),
    st.floats(1.0, 60.0),
)
def test_peaks_of_a_batch_are_those_of_the_certified_optimum(middle, apart, duration):
    plant = plant_of_poles(middle * (1.0 + apart), middle * (1.0 - apart))
    wind = tvclin.TriangularWind(peak=-0.07, duration=duration).shift(2.0)
    best = optimum_deflection(plant, wind, 2.0)
    assert best.status == "ok"
    assert minimum_peaks(plant, wind) == pytest.approx(best.peak, rel=1e-8)


def test_a_batch_of_peaks_takes_plants_of_every_kind_together():
    kinds = [(0.5, 0.013), (0.2, 0.2), (0.1 + 0.1j, 0.1 - 0.1j), (0.3, -0.1)]
    plants = [plant_of_poles(*two) for two in kinds]
    every = Coefficients(**{n: [getattr(p.coefficients, n) for p in plants] for n in NUMBERS})
    result = minimum_peaks(Plant(every, "drift-exact"), WIND)
    alone = [float(minimum_peaks(p, WIND)) for p in plants]
    # Conditions of poles set apart by 2e-6 are known to rounding over that.
    np.testing.assert_allclose(result, alone, rtol=np.finfo(float).eps / 2e-6 * 4.0)


def test_without_an_unstable_pole_nothing_is_needed():
    stable = Plant(Coefficients(mu_alpha=[-0.3, -0.2], mu_delta=2.0), "fixed-path")
    assert minimum_peaks(stable, WIND).tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    ("wind", "message"),
    [
        (0.0 * WIND, "wind must differ from zero"),
        (tvclin.linear.ConstantDeflection(limit=0.1), "wind must end"),
        (0.1, "wind must be a History"),
    ],
)
def test_winds_without_a_least_peak(wind, message):
    with pytest.raises(tvclin.InputError, match=message):
        minimum_peaks(plant_of_poles(0.5, 0.1), wind)
