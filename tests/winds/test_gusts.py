"""Trapezoids, lopsided triangles and gusts, against formulas and integrals of our own."""

from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest
from scipy.optimize import brentq

import tvclin as tv

EPS = np.finfo(float).eps
BETA, B, PEAK = 0.53, 0.107, 0.08
VARIABLES = [0.0, 1e-12, 1e-3, 0.53, 4.0, -0.5, 1e-9j, 0.3 + 2j, -0.2 + 1j, 2j * np.pi / 6]
TIMES = np.linspace(-1.0, 12.0, 105)
DEAD_BANDS = [1.0, 0.5, 0.0]


def polyline(*points):
    """Return straight lines between (time, angle) points as a function, and its corners."""

    def angle(t):
        for (t0, a0), (t1, a1) in pairwise(points):
            if t0 <= t < t1:
                return a0 + (a1 - a0) * (t - t0) / mp.mpf(t1 - t0)
        return mp.mpf(0)

    return angle, [t for t, _ in points]


def swell(blend, plateau):
    """Return a rise and fall in half cosine waves as a function, and its corners."""
    corners = [0.0, blend, blend + plateau, 2 * blend + plateau]

    def angle(t):
        if t < 0 or t >= corners[3]:
            return mp.mpf(0)
        phase = t if t < blend else corners[3] - t
        return PEAK if corners[1] <= t < corners[2] else PEAK * (1 - mp.cospi(phase / blend)) / 2

    return angle, corners


WINDS = {
    "one minus cosine": (tv.OneMinusCosineGust(peak=PEAK, duration=6.0), *swell(3.0, 0.0)),
    "layered": (tv.winds.LayeredGust(peak=PEAK, blend=1.5, plateau=4.0), *swell(1.5, 4.0)),
    "layered without plateau": (
        tv.winds.LayeredGust(peak=PEAK, blend=2.0, plateau=0.0),
        *swell(2.0, 0),
    ),
    "layered without blend": (
        tv.winds.LayeredGust(peak=PEAK, blend=0.0, plateau=4.0),
        *polyline((0.0, PEAK), (4.0, PEAK)),
    ),
    "trapezoid": (
        tv.winds.TrapezoidalWind(peak=PEAK, rise=1.0, hold=2.5, fall=3.0),
        *polyline((0.0, 0.0), (1.0, PEAK), (3.5, PEAK), (6.5, 0.0)),
    ),
    "trapezoid with jumps": (
        tv.winds.TrapezoidalWind(peak=PEAK, rise=0.0, hold=5.0, fall=0.0),
        *polyline((0.0, PEAK), (5.0, PEAK)),
    ),
    "trapezoid without top": (
        tv.winds.TrapezoidalWind(peak=PEAK, rise=2.0, hold=0.0, fall=5.0),
        *polyline((0.0, 0.0), (2.0, PEAK), (7.0, 0.0)),
    ),
    "lopsided triangle": (
        tv.winds.AsymmetricTriangularWind(peak=PEAK, duration=7.5, peak_time=6.0),
        *polyline((0.0, 0.0), (6.0, PEAK), (7.5, 0.0)),
    ),
    "jump and fall": (
        tv.winds.AsymmetricTriangularWind(peak=PEAK, duration=5.0, peak_time=0.0),
        *polyline((0.0, PEAK), (5.0, 0.0)),
    ),
    "rise and jump": (
        tv.winds.AsymmetricTriangularWind(peak=PEAK, duration=5.0, peak_time=5.0),
        *polyline((0.0, 0.0), (5.0, PEAK)),
    ),
}


def fixed_path():
    return tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=BETA, B=B))


def integral(function, corners, start=0.0):
    """Integrate from `start` to the last corner, piece by piece, in 30 digits."""
    with mp.workdps(30):
        return mp.quad(function, sorted({start, *(c for c in corners if c > start)}))


def limit_of_4b(angle, corners, K):
    """Solve (4b) on the fixed path: trim up to K times the limit, then hold the limit.

    The limit is the demand at the one time in the rise at which the wind is K times it.
    """

    def demand(a):
        return BETA * integral(lambda t: mp.exp(-BETA * (t - a)) * angle(t), corners, a)

    def excess(a):
        return float(angle(a) - K * demand(a))

    rises = K > 0.0 and excess(0.0) < 0.0
    a = brentq(excess, 0.0, np.nextafter(corners[1], 0.0), xtol=1e-15) if rises else 0.0
    return float(demand(a) / PEAK), a


@pytest.mark.parametrize("name", WINDS)
def test_winds_have_the_values_of_their_formula(name):
    wind, angle, _ = WINDS[name]
    expected = [float(angle(t)) for t in TIMES]
    np.testing.assert_allclose(wind(TIMES), expected, rtol=0.0, atol=4 * EPS * PEAK)


@pytest.mark.parametrize("s", VARIABLES)
@pytest.mark.parametrize("name", WINDS)
def test_winds_have_the_transform_of_their_quadrature(name, s):
    wind, angle, corners = WINDS[name]
    expected = complex(integral(lambda t: mp.exp(-mp.mpmathify(s) * t) * angle(t), corners))
    # Where the transform has a zero the rounding is that of its terms.
    rounding = 4 * EPS * wind.laplace_magnitude(s)
    np.testing.assert_allclose(wind.laplace(s), expected, rtol=1e-12, atol=rounding)


@pytest.mark.parametrize("name", WINDS)
def test_winds_know_their_peak_onset_and_end(name):
    wind, _, corners = WINDS[name]
    assert (wind.onset, wind.end, wind.final_value) == (0.0, corners[-1], 0.0)
    assert wind.peak == PEAK
    assert (-1.0 * wind).peak == pytest.approx(-PEAK, rel=4 * EPS)


def test_a_gust_has_knots_at_its_start_peak_and_end():
    wind = tv.OneMinusCosineGust(peak=PEAK, duration=6.0)
    np.testing.assert_array_equal(wind.knots, [0.0, 3.0, 6.0])


@pytest.mark.parametrize("second", WINDS)
@pytest.mark.parametrize("first", WINDS)
def test_any_two_winds_can_be_added_and_shifted(first, second):
    one, two = WINDS[first][0], WINDS[second][0]
    both = one - 0.5 * two.shift(2.25)
    expected = one(TIMES) - 0.5 * two(TIMES - 2.25)
    np.testing.assert_allclose(both(TIMES), expected, rtol=0.0, atol=16 * EPS * PEAK)
    for s in (0.0, 0.53, 0.3 + 2j):
        transform = one.laplace(s) - 0.5 * np.exp(-2.25 * s) * two.laplace(s)
        rounding = 16 * EPS * both.laplace_magnitude(s)
        np.testing.assert_allclose(both.laplace(s), transform, rtol=0.0, atol=rounding)


BATCHES = {
    tv.OneMinusCosineGust: {"duration": [[3.0], [6.0], [9.0]]},
    tv.winds.LayeredGust: {"blend": [[0.0], [1.0], [2.0]], "plateau": [3.0, 0.5]},
    tv.winds.TrapezoidalWind: {"rise": [[0.0], [1.0], [2.0]], "hold": [3.0, 0.0], "fall": 1.5},
    tv.winds.AsymmetricTriangularWind: {"duration": 4.0, "peak_time": [[0.0], [1.5], [4.0]]},
}


@pytest.mark.parametrize("kind", BATCHES)
def test_a_batch_of_winds_is_the_loop_over_its_elements(kind):
    arguments = {"peak": [0.1, -0.3]} | BATCHES[kind]
    batch = kind(**arguments)
    answers = tv.boundary_limit(fixed_path(), batch, 0.5)
    names, values = arguments.keys(), np.broadcast_arrays(*arguments.values())
    assert batch.batch == batch.peak.shape == (3, 2)
    for index in np.ndindex(3, 2):
        single = kind(**{name: value[index] for name, value in zip(names, values, strict=True)})
        np.testing.assert_allclose(batch(TIMES)[index], single(TIMES), rtol=0.0, atol=1e-16)
        np.testing.assert_allclose(batch.laplace(0.7)[index], single.laplace(0.7), rtol=1e-14)
        assert batch.onset[index] == single.onset
        assert batch.end[index] == single.end
        alone = tv.boundary_limit(fixed_path(), single, 0.5)
        assert answers.limit[index] == pytest.approx(alone.limit, rel=1e-13)


@pytest.mark.parametrize("K", DEAD_BANDS)
@pytest.mark.parametrize("name", WINDS)
def test_the_boundary_is_the_solution_of_equation_4b(name, K):
    wind, angle, corners = WINDS[name]
    expected, time = limit_of_4b(angle, corners, K)
    boundary = tv.boundary_limit(fixed_path(), wind, K)
    assert boundary.limit == pytest.approx(expected, rel=1e-12)
    assert boundary.switch_time == pytest.approx(time, rel=1e-11, abs=1e-15)
    assert boundary.status == "ok"


@pytest.mark.parametrize("model", ["fixed-path", "drift"])
@pytest.mark.parametrize("K", DEAD_BANDS)
@pytest.mark.parametrize("name", WINDS)
def test_the_control_on_the_boundary_leaves_no_growing_exponential(name, K, model):
    wind = WINDS[name][0].shift(1.0)
    coefficients = tv.Coefficients.from_beta(beta=BETA, B=B, b1=0.0284, b2=0.0169)
    plant = tv.Plant.from_coefficients(coefficients, model)
    limit = tv.boundary_limit(plant, wind, K).deflection
    on_it = tv.trim_then_hold(plant, wind, limit, K)
    below = tv.trim_then_hold(plant, wind, 0.99 * limit, K)
    assert tv.is_stable(plant, on_it, wind)
    assert not tv.is_stable(plant, below, wind)


def test_a_gust_takes_the_shape_of_samples_of_it():
    gust = tv.winds.LayeredGust(peak=PEAK, blend=1.5, plateau=4.0)
    time = np.linspace(0.0, 7.0, 1401)
    samples = tv.SampledWind(time=time, angle=gust(time))
    exact, close = (tv.boundary_limit(fixed_path(), w, 0.5).limit for w in (gust, samples))
    # Chords stay within curvature times step^2/8 of the curve, here 1.4e-5 of the peak.
    assert close == pytest.approx(exact, rel=2e-5)


GOOD = {
    tv.OneMinusCosineGust: {"peak": 0.1, "duration": 6.0},
    tv.winds.LayeredGust: {"peak": 0.1, "blend": 1.0, "plateau": 2.0},
    tv.winds.TrapezoidalWind: {"peak": 0.1, "rise": 1.0, "hold": 2.0, "fall": 3.0},
    tv.winds.AsymmetricTriangularWind: {"peak": 0.1, "duration": 6.0, "peak_time": 2.0},
}
MESSAGES = [
    (tv.OneMinusCosineGust, {"duration": 0.0}, r"^duration must be positive; got 0 s$"),
    (tv.OneMinusCosineGust, {"duration": np.nan}, r"^duration must be finite; got nan s$"),
    (tv.winds.LayeredGust, {"blend": -1.0}, r"^blend must be zero or positive; got -1 s$"),
    (tv.winds.LayeredGust, {"plateau": "2 s"}, r"^plateau must be a number in s; got '2 s'$"),
    (
        tv.winds.LayeredGust,
        {"blend": [0.0, 1.0, 0.0], "plateau": [1.0, 0.0, 0.0]},
        r"^blend \+ plateau must be positive; got 0 s at index 2$",
    ),
    (
        tv.winds.LayeredGust,
        {"blend": [1.0, 2.0], "plateau": [1.0] * 3},
        r"shapes that broadcast.*blend",
    ),
    (tv.winds.TrapezoidalWind, {"rise": -1.0}, r"^rise must be zero or positive; got -1 s$"),
    (tv.winds.TrapezoidalWind, {"hold": [2.0, -1.0]}, r"^hold must be .* got -1 s at index 1$"),
    (tv.winds.TrapezoidalWind, {"fall": np.inf}, r"^fall must be finite; got inf s$"),
    (
        tv.winds.TrapezoidalWind,
        {"rise": 0.0, "hold": 0.0, "fall": 0.0},
        r"^rise \+ hold \+ fall must be positive; got 0 s$",
    ),
    (
        tv.winds.AsymmetricTriangularWind,
        {"peak_time": -1.0},
        r"^peak_time must be zero or positive",
    ),
    (
        tv.winds.AsymmetricTriangularWind,
        {"peak_time": [2.0, 7.5]},
        r"^duration - peak_time must be zero or positive; got -1\.5 s at index 1$",
    ),
    *((kind, {"peak": 0.0}, r"^peak must be other than zero; got 0 rad$") for kind in GOOD),
    *((kind, {"peak": 5.0}, r"^peak must be a wind angle within 90 degrees") for kind in GOOD),
]


@pytest.mark.parametrize(("kind", "bad", "message"), MESSAGES)
def test_bad_winds_are_refused_in_one_sentence(kind, bad, message):
    with pytest.raises(tv.InputError, match=message):
        kind(**GOOD[kind] | bad)


@pytest.mark.parametrize(
    ("time", "angle", "message"),
    [
        ([0.0, 1.0, 2.0], [0.0, np.nan, 0.0], r"^angle must be finite; got nan rad at index 1$"),
        ([0.0, 1.0], [0.1, 0.2, 0.3], r"^time must hold two or more samples.*\(2,\).*\(3,\)$"),
        ([0.0, 2.0, 1.0], [0.1] * 3, r"^time must not decrease.* got 1 s at index 2$"),
        ([0.0, 1.0, 1.0, 1.0, 2.0], [0.1] * 5, r"not three times; got 1 s at index 3$"),
        ([1.0, 1.0], [0.1, 0.1], r"^angle must be a wind that is not zero throughout"),
        ([0.0, 0.0, 1.0], [0.1, 0.0, 0.0], r"zero wherever time advances, from 0 s to 1 s$"),
        ([0.0, 1.0, 1.0], [[0.1, 0.0, 0.0], [0.0, 0.0, 0.1]], r"zero wherever time advances"),
    ],
)
def test_bad_samples_are_refused_in_one_sentence(time, angle, message):
    with pytest.raises(tv.InputError, match=message):
        tv.SampledWind(time=time, angle=angle)
