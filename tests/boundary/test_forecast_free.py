"""The least limit without a forecast, against quadrature, viability by backward steps and a law."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

import tvclin as tv
from tests.turns import by_turns, usual
from tvclin import Coefficients, InputError, Plant, SampledWind, TriangularWind
from tvclin.boundary.closed_forms import rectangular_limit
from tvclin.boundary.forecast_free import BOUND, EXACT
from tvclin.linear.plant import MODELS

BETA = 0.53
COEFFICIENTS = Coefficients(
    mu_alpha=BETA**2, mu_delta=2.6, C1=0.025, C2=0.0036, b1=0.0284, b2=0.0169
)
PUBLISHED = {2: 0.3996, 4: 0.3738, 6: 0.3887, 8: 0.4145, 12: 0.4423, 20: 0.4653, 40: 0.4827}


def plant_of(model="fixed-path", coefficients=COEFFICIENTS):
    return Plant.from_coefficients(coefficients, model)


def triangle(tau_beta, peak=0.08):
    return TriangularWind(peak=peak, duration=tau_beta / BETA)


def limit_of(wind, **options):
    return tv.forecast_free_limit(plant_of(), wind, **options).limit


def random_wind(seed):
    """Return a wind >= 0 of largest value 0.1, with jumps, lulls and a late onset."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 9))
    time = rng.uniform(-3.0, 3.0) + np.cumsum(rng.exponential(rng.uniform(0.5, 6.0), count))
    angle = rng.uniform(0.0, 1.0, count) ** rng.uniform(0.3, 3.0)
    angle[rng.random(count) < 0.2] = 0.0
    angle[1] = 1.0
    if rng.random() < 0.5:  # a jump
        time = np.insert(time, 1, time[1])
        angle = np.insert(angle, 1, rng.uniform(0.0, 0.5))
    return SampledWind(time=time, angle=0.1 * angle)


def ahead(wind, at, rate=BETA):
    """The discounted wind to come at an instant, over the peak, by quadrature."""
    edges = np.unique([at, *wind.knots[wind.knots > at]])
    parts = [
        quad(lambda r: np.exp(-rate * (r - at)) * wind(r), a, b, epsabs=1e-13, epsrel=1e-12)[0]
        for a, b in pairwise(edges)
    ]
    return rate * sum(parts) / float(wind.peak)


def steps_of(wind, count=6000):
    """Return e^h, and the mean wind of even steps over the peak."""
    edges = np.linspace(float(wind.onset), float(wind.end), count + 1)
    h = BETA * (edges[1] - edges[0])
    fine = np.linspace(0.5 / 8, 7.5 / 8, 8) * (edges[1] - edges[0])
    means = wind(edges[:-1, np.newaxis] + fine).mean(axis=1) / float(wind.peak)
    return np.exp(h), means


def viable(wind, y, above=0.0):
    """Whether from z = 0 some deflection keeps -y <= z <= y - above throughout, by back steps.

    The states that can be kept form an interval; each step back widens it by what u = -y and
    u = y can do, and cuts it to where a stop is survived.
    """
    e, means = steps_of(wind)
    low, high = -y, y - above
    for w in means[::-1]:
        low = max(-y, (low + (e - 1.0) * (w - y)) / e)
        high = min(y - above, (high + (e - 1.0) * (w + y)) / e)
        if low > high:
            return False
    return low <= 0.0 <= high


def bisected(survives, low=0.0, high=2.0):
    for _ in range(22):
        middle = (low + high) / 2.0
        low, high = (low, middle) if survives(middle) else (middle, high)
    return high


@pytest.mark.parametrize(("tau_beta", "published"), PUBLISHED.items())
def test_the_triangle_has_the_closed_form_and_the_published_row(tau_beta, published):
    bound = tv.forecast_free_limit(plant_of(), triangle(tau_beta))
    half = np.exp(-tau_beta / 2.0)
    wind_known = 2.0 / tau_beta * (1.0 - half) ** 2
    expected = max(wind_known, 0.5 - np.log(2.0 - half) / tau_beta)
    assert bound.limit == pytest.approx(expected, rel=1e-12)
    assert bound.limit == pytest.approx(published, abs=5e-5)
    assert bound.wind_known == pytest.approx(wind_known, rel=1e-12)
    # Sup W is where W is the wind itself, on the way up.
    instant = (tau_beta / 2.0 - np.log(2.0 - half)) / BETA
    assert bound.worst_stop_time == pytest.approx(instant, rel=1e-9)
    assert bound.kind == EXACT == "exact"


def test_the_two_branches_of_the_triangle_meet():
    short, long = (tv.forecast_free_limit(plant_of(), triangle(tb)) for tb in (4.46, 4.47))
    assert short.limit == short.wind_known
    assert long.limit > long.wind_known


@pytest.mark.parametrize("tau_beta", [0.3, 1.0, 5.0, 30.0])
def test_nothing_is_gained_in_a_rectangle(tau_beta):
    """It is strongest at its onset, where all of it is still to come."""
    wind = tv.RectangularWind(peak=0.05, duration=tau_beta / BETA)
    bound = tv.forecast_free_limit(plant_of(), wind)
    assert bound.limit == pytest.approx(-np.expm1(-tau_beta), rel=1e-12)
    assert bound.limit == pytest.approx(rectangular_limit(tau_beta), rel=1e-12)
    assert bound.worst_stop_time == 0.0


SMOOTH = (
    tv.OneMinusCosineGust(peak=-0.07, duration=9.0),
    tv.winds.LayeredGust(peak=0.07, blend=2.0, plateau=5.0),
    triangle(6.0).filter([1.0], [1.0, 1.0]).before(40.0),
)


@pytest.mark.parametrize(
    "wind", usual([*(random_wind(seed) for seed in range(12)), *SMOOTH], 0, 5, 12, 14)
)
def test_any_wind_against_quadrature(wind):
    bound = tv.forecast_free_limit(plant_of(), wind)
    assert bound.wind_known == pytest.approx(ahead(wind, float(wind.onset)), rel=1e-9)
    worst = ahead(wind, bound.worst_stop_time)
    assert bound.limit == pytest.approx(max(bound.wind_known, worst / 2.0), rel=1e-9)
    every = np.linspace(float(wind.onset), float(wind.end), 50)
    assert max(ahead(wind, t) for t in every) <= worst * (1.0 + 1e-9)


@pytest.mark.parametrize("seed", usual(range(12), 0))
def test_backward_viability_finds_the_same_limit(seed):
    wind = random_wind(seed)
    assert bisected(lambda y: viable(wind, y)) == pytest.approx(limit_of(wind), abs=1e-3)


@pytest.mark.parametrize("seed", usual(range(12), 0, 5))
def test_the_greedy_law_survives_just_above_and_not_just_below(seed):
    """Deflect fully until z = y, then hold: it knows only the wind that it feels."""
    wind = random_wind(seed)
    e, means = steps_of(wind, 20000)

    def stays(y):
        z = 0.0
        for w in means:
            z = e * z - (e - 1.0) * (w + max(-y, min(y, (e * z - y) / (e - 1.0) - w)))
            if z < -y:
                return False
        return True

    limit = limit_of(wind)
    assert stays(1.002 * limit)
    assert not stays(0.998 * limit)


@pytest.mark.parametrize("seed", range(12))
def test_foresight_is_appendix_c_and_costs_less(seed):
    wind = random_wind(seed)
    plant = plant_of()
    bound = tv.forecast_free_limit(plant, wind)
    minimum = tv.optimum_deflection(plant, wind, start=float(wind.onset)).peak
    assert bound.wind_known == pytest.approx(minimum / (plant.coefficients.B * wind.peak), rel=1e-9)
    assert bound.limit >= bound.wind_known
    assert bound.limit <= 1.0
    assert bound.deflection == pytest.approx(-bound.limit * plant.coefficients.B * wind.peak)
    assert limit_of(wind) <= tv.boundary_limit(plant, wind).limit * (1.0 + 1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_only_the_shape_counts_and_neither_its_sign_nor_its_date(seed):
    wind, plant = random_wind(seed), plant_of()
    bound = tv.forecast_free_limit(plant, wind)
    for other, factor, later in ((3.0 * wind, 3.0, 0.0), (-wind, -1.0, 0.0), (wind, 1.0, 500.0)):
        again = tv.forecast_free_limit(plant, other.shift(later))
        assert again.limit == pytest.approx(bound.limit, rel=1e-9)
        assert again.deflection == pytest.approx(factor * bound.deflection, rel=1e-9)
        assert again.worst_stop_time == pytest.approx(bound.worst_stop_time + later, abs=1e-6)
    slow = Plant.from_coefficients(Coefficients(mu_alpha=BETA**2 / 9.0, mu_delta=-2.6))
    stretched = SampledWind(time=3.0 * wind.time, angle=wind.angle)
    assert tv.forecast_free_limit(slow, stretched).limit == pytest.approx(bound.limit, rel=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_a_wind_that_is_larger_throughout_never_needs_less(seed):
    """Of the same onset: the law may lean as soon as it feels a wind."""
    rng, wind, plant = np.random.default_rng(100 + seed), random_wind(seed), plant_of()
    more = SampledWind(time=wind.time, angle=wind.angle + rng.uniform(0.0, 0.05, wind.time.size))
    other = random_wind(seed + 50)
    later = other.shift(float(wind.onset - other.onset) + rng.exponential(2.0))
    for larger in (more, wind + later):
        whole = [one.shift(-float(wind.onset)) for one in (wind, larger)]
        minimum, most = (abs(tv.forecast_free_limit(plant, one).deflection) for one in whole)
        assert minimum <= most * (1.0 + 1e-12)


@pytest.mark.thorough
@by_turns("reversal,seed", [0.05, 0.15, 0.3, 1.0], [0, 3, 5, 7, 8], each=4)
def test_a_reversal_is_reserved_for(seed, reversal):
    """With z above y - R a reversal instead of a stop would be lost, and z begins at zero."""
    wind = random_wind(seed)
    result = limit_of(wind, reversal=reversal)
    plain = tv.forecast_free_limit(plant_of(), wind)
    largest = ahead(wind, plain.worst_stop_time)
    expected = max(plain.wind_known, (largest + reversal) / 2.0, reversal)
    assert result == pytest.approx(expected, rel=1e-9)
    assert bisected(lambda y: viable(wind, y, reversal)) == pytest.approx(result, abs=1e-3)


def test_long_winds_need_half_and_never_more():
    limits = [limit_of(triangle(tau_beta)) for tau_beta in (10, 30, 100, 1000, 1e4)]
    assert np.all(np.diff(limits) > 0.0)
    assert 0.4999 < limits[-1] < 0.5
    assert limit_of(triangle(1e4), reversal=1.0) == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("model", ["drift", "drift-exact"])
@pytest.mark.parametrize("name", ["configuration-i", "configuration-ii"])
def test_with_drift_it_is_the_bound_of_the_fast_mode(name, model):
    plant = Plant.from_vehicle(tv.load_vehicle(name), model)
    c = plant.coefficients
    cubic = [1.0, c.C1, -(c.beta**2), c.C2] if model == "drift-exact" else [1, 0, -(c.beta**2)]
    pole = np.roots(cubic).max()
    strength = (pole + c.b2) / (pole + c.b1)
    for seed in range(3):
        wind = random_wind(seed)
        bound = tv.forecast_free_limit(plant, wind)
        assert bound.kind == BOUND != EXACT
        wind_known = ahead(wind, float(wind.onset), pole)
        every = [ahead(wind, t, pole) for t in (bound.worst_stop_time, *wind.knots[:-1])]
        expected = strength * max(wind_known, every[0] / 2.0)
        assert bound.limit == pytest.approx(expected, rel=1e-8)
        assert every[0] == max(every)
        assert bound.wind_known == pytest.approx(strength * wind_known, rel=1e-8)
        assert bound.deflection == pytest.approx(-bound.limit * c.B * float(wind.peak))


@pytest.mark.parametrize(
    ("wind", "message"),
    [
        (SampledWind(time=[0, 1, 2, 3], angle=[0, 0.1, -0.01, 0]), "changes its sign"),
        (triangle(4.0) - triangle(4.0).shift(20.0), "changes its sign"),
        (tv.linear.ConstantDeflection(limit=0.1), "wind must end"),
        (0.0 * triangle(4.0), "wind must end, and be other than zero"),
        (0.1, "wind must be a History"),
    ],
)
def test_winds_for_which_it_is_not_defined(wind, message):
    with pytest.raises(InputError, match=message):
        tv.forecast_free_limit(plant_of(), wind)


@pytest.mark.parametrize(
    ("reversal", "message"),
    [(-0.1, "zero or positive"), (np.nan, "finite"), ([0.1, 0.2], "reversal must be one number")],
)
def test_reversals_that_cannot_be(reversal, message):
    with pytest.raises(InputError, match=message):
        limit_of(triangle(4.0), reversal=reversal)


def test_plants_for_which_it_is_not_defined():
    wind = triangle(4.0)
    stable = plant_of(coefficients=COEFFICIENTS.replace(mu_alpha=-0.3))
    merged = COEFFICIENTS.replace(C2=0.39 * COEFFICIENTS.beta**3)
    pair = plant_of("drift-exact", coefficients=merged)
    for plant, has in ((stable, "it has none"), (pair, r"it has the complex pair 0\.\d+ \+- 0")):
        with pytest.raises(InputError, match=has):
            tv.forecast_free_limit(plant, wind)
    with pytest.raises(InputError, match="plant must be a Plant"):
        tv.forecast_free_limit(COEFFICIENTS, wind)


@pytest.mark.thorough
def test_a_batch_gives_what_each_case_gives_alone():
    vehicle = tv.load_vehicle("configuration-i")
    slow, durations = np.array([380.0, 480.0, 538.81, 600.0]), [4.0, 9.0, 20.0, 50.0]
    winds = TriangularWind(peak=[[0.08], [-0.05]], duration=durations)
    for model in MODELS:
        plant = Plant.from_vehicle(vehicle.replace(velocity=slow), model)
        bound = tv.forecast_free_limit(plant, winds)
        for i, peak in enumerate((0.08, -0.05)):
            for k, V in enumerate(slow):
                one = Plant.from_vehicle(vehicle.replace(velocity=V), model)
                wind = TriangularWind(peak=peak, duration=durations[k])
                single = tv.forecast_free_limit(one, wind)
                for name in ("limit", "deflection", "wind_known", "worst_stop_time"):
                    expected = pytest.approx(getattr(single, name), rel=1e-12)
                    assert getattr(bound, name)[i, k] == expected, (model, name)


def test_in_a_batch_a_stable_case_needs_nothing_and_a_pair_has_no_bound():
    beta = COEFFICIENTS.beta
    three = COEFFICIENTS.replace(
        mu_alpha=[beta**2, -0.3, beta**2], C2=[0.1 * beta**3, 0.0, 0.39 * beta**3]
    )
    bound = tv.forecast_free_limit(plant_of("drift-exact", coefficients=three), triangle(4.0))
    assert bound.limit[0] > 0.0
    assert bound.limit[1] == 0.0
    assert np.isnan(bound.limit[2])
