"""Limits in two planes: the verdict in each plane, closed forms, and convex programs."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq, linprog
from scipy.special import hyp2f1

import tvclin as tv
from tests.turns import usual
from tvclin import InputError
from tvclin.boundary import (
    CircularShape,
    EllipticShape,
    PolygonShape,
    SquareShape,
    forecast_free,
    plane_bounds,
)
from tvclin.boundary.plane_bounds import PlanePair, no_forecast_bound
from tvclin.winds import PlaneWind
from tvclin.winds.wind_angles import angle_from_speed

BETA = 0.53
PLANT = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=BETA, B=0.107))
BOOSTER = tv.load_vehicle("configuration-i")
EXACT = tv.Plant.from_vehicle(BOOSTER, "drift-exact")
EPS = np.finfo(float).eps
KITE = PolygonShape([1.0, 0.6j, -0.5, -0.8j])


def triangle(tau_beta, beta=BETA, peak=0.08):
    return tv.TriangularWind(peak=peak, duration=tau_beta / beta)


def veering(tau_beta, degrees, beta=BETA, angle=0.0):
    gust = triangle(tau_beta, beta)
    return PlaneWind.veering(gust, angle, np.radians(degrees) / gust.duration)


def sudden(tau_beta, degrees):
    """A triangle that turns at its peak, at once."""
    gust = triangle(tau_beta)
    rise = gust.before(gust.duration / 2.0)
    turned = PlaneWind.towards(gust - rise, np.radians(degrees))
    return PlaneWind(pitch=rise + turned.pitch, yaw=turned.yaw)


@cache
def limits(tau_beta, degrees):
    wind = veering(tau_beta, degrees)
    return [tv.plane_limit(PLANT, wind, dead_band=K) for K in (0.0, 0.5, 1.0)]


# One direction: the scalar answer.


@pytest.mark.parametrize("plant", [PLANT, EXACT])
@pytest.mark.parametrize("K", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("quarter", [0, 1, 2, 3])
def test_along_an_axis_it_is_the_scalar_limit_to_the_last_digit(plant, K, quarter):
    gust = triangle(4.0)
    scalar = tv.boundary_limit(plant, gust, K)
    limit = tv.plane_limit(plant, PlaneWind.towards(gust, quarter * np.pi / 2), dead_band=K)
    assert limit.limit == scalar.limit
    assert limit.deflection == abs(scalar.deflection)
    assert limit.switch_time == scalar.switch_time
    assert limit.notes == ()
    held = limit.pitch, limit.yaw
    assert held[quarter % 2] == scalar.deflection * (1.0, 1.0, -1.0, -1.0)[quarter]
    assert held[(quarter + 1) % 2] == 0.0
    assert limit.pitch_only_ratio == (1.0, 0.0)[quarter % 2]


@pytest.mark.parametrize("angle", [0.3, 1.0, 2.5])
def test_of_one_direction_the_size_counts_and_pitch_alone_is_too_good(angle):
    gust = triangle(6.0)
    scalar = abs(tv.boundary_limit(PLANT, gust).deflection)
    limit = tv.plane_limit(PLANT, PlaneWind.towards(gust, angle))
    assert limit.deflection == pytest.approx(scalar, rel=1e-12)
    assert limit.pitch_only == pytest.approx(scalar * abs(np.cos(angle)), rel=1e-12)
    assert limit.pitch_only_ratio == pytest.approx(abs(np.cos(angle)), rel=1e-12)
    square = tv.plane_limit(PLANT, PlaneWind.towards(gust, angle), SquareShape())
    most = max(abs(np.cos(angle)), abs(np.sin(angle)))
    assert square.deflection == pytest.approx(scalar * most, rel=1e-12)


def test_a_west_jet_across_a_slanting_flight():
    """50 m/s at 45 degrees of azimuth, and every way to share the stop."""
    psi = np.radians(45.0)
    parts = [
        float(angle_from_speed(50.0 * part, BOOSTER.velocity, path))
        for part, path in ((np.cos(psi), BOOSTER.attitude), (np.sin(psi), np.pi / 2))
    ]
    assert np.degrees(parts) == pytest.approx([2.6515, 3.7623], abs=5e-5)
    pitch, yaw = (triangle(7.5, 1.0, part) for part in parts)
    wind = PlaneWind(pitch=pitch, yaw=yaw)
    assert np.degrees(wind.peak) == pytest.approx(4.60275, abs=5.1e-6)
    stops = CircularShape(), CircularShape().each_plane(), SquareShape()
    published = {
        "fixed-path": (0.19522, 0.33889, 0.39175, 0.27701),
        "drift-exact": (0.18602, 0.32291, 0.37328, 0.26395),
    }
    for model, (single, *shared) in published.items():
        plant = tv.Plant.from_vehicle(BOOSTER, model)
        computed = [tv.plane_limit(plant, wind, stop) for stop in stops]
        assert np.degrees([f.deflection for f in computed]) == pytest.approx(shared, abs=5.1e-6)
        assert np.degrees(computed[0].pitch_only) == pytest.approx(single, abs=5.1e-6)
        # sines of small angles stand for angles: some 1e-3 of the square
        ratio = 1.0 / np.sqrt(1.0 + (np.tan(psi) / np.sin(BOOSTER.attitude)) ** 2)
        assert computed[0].pitch_only_ratio == pytest.approx(ratio, abs=1e-3)


# Winds that turn: the verdict, the closed form, another solver.


@pytest.mark.thorough
@pytest.mark.parametrize("model", ["fixed-path", "drift", "drift-exact"])
@pytest.mark.parametrize("switch", ["report", "literal"])
@pytest.mark.parametrize("K", [0.0, 0.4, 1.0])
def test_trim_then_the_vector_held_leaves_no_fast_mode_in_either_plane(model, switch, K):
    """Eq (4b), for the whole history in each plane."""
    plant = tv.Plant.from_vehicle(BOOSTER, model)
    wind = veering(5.0, 120.0, angle=0.4)
    limit = tv.plane_limit(plant, wind, dead_band=K, switch=switch)
    held = {"pitch": limit.pitch, "yaw": limit.yaw}
    for plane, constant in held.items():
        blown = getattr(wind, plane)
        trim = tv.trim_deflection(plant, blown).before(limit.switch_time)
        control = trim + tv.linear.ConstantDeflection(limit=constant, start=limit.switch_time)
        left, size = (tv.residues(plant, control, one)[0] for one in (blown, 0.0 * blown))
        assert abs(left) <= 1e-12 * abs(size)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "stop", usual([CircularShape(), EllipticShape(1.0, 0.5), SquareShape(0.3), KITE], 1)
)
@pytest.mark.parametrize("K", usual([0.3, 1.0], 0))
def test_the_dead_band_is_left_where_quadrature_says(stop, K):
    wind = veering(4.0, 100.0, angle=0.2)
    limit = tv.plane_limit(PLANT, wind, stop, dead_band=K)
    size = -PLANT.coefficients.B

    def mean(a):
        parts = (
            [
                quad(lambda t, f=f: np.exp(-BETA * (t - a)) * f(wind(t)), a, end, epsrel=1e-12)[0]
                for f in (np.real, np.imag)
            ]
            if (end := float(wind.end))
            else []
        )
        return size * BETA * complex(*parts)

    spare = lambda a: stop.gauge(size * wind(a)) - K * stop.gauge(mean(a))  # noqa: E731
    middle = float(wind.end) / 2.0
    a = brentq(spare, 1e-3, middle, xtol=1e-12)
    # quad: 1e-8 of the size for the kink at the peak; the root moves by as much over its slope
    assert limit.switch_time == pytest.approx(a, abs=1e-6)
    assert limit.deflection == pytest.approx(float(stop.gauge(mean(a))), rel=1e-6)


TABLE = {
    (4, 0): (0.37382, 0.55876, 0.68846, 0.37382),
    (4, 90): (0.35822, 0.53294, 0.67514, 0.35822),
    (4, 180): (0.31491, 0.45922, 0.63150, 0.31992),
    (4, 360): (0.18587, 0.23963, 0.38800, 0.26950),
    (8, 0): (0.24093, 0.45492, 0.82901, 0.41451),
    (8, 90): (0.23457, 0.43723, 0.82103, 0.41063),
    (8, 180): (0.21667, 0.38836, 0.79522, 0.39942),
    (8, 360): (0.16034, 0.24853, 0.64491, 0.36311),
}


@pytest.mark.thorough
@pytest.mark.parametrize("case", usual([(case,) for case in TABLE], 0, 5))
def test_the_table_of_veering_triangles(case):
    computed = limits(*case)
    numbers = [*(one.limit for one in computed), computed[-1].no_forecast_bound]
    assert numbers == pytest.approx(TABLE[case], abs=5.1e-6)


@pytest.mark.thorough
@pytest.mark.parametrize("degrees", usual([90, 180, 360], 1))
def test_a_wind_that_turns_needs_less_and_says_what_it_leaves_open(degrees):
    straight, turning = limits(4, 0), limits(4, degrees)
    for one, other in zip(straight, turning, strict=True):
        assert other.limit < one.limit
    assert turning[0].notes == ()
    assert "constant deflection presumes how" in turning[2].notes[0]
    assert turning[2].limit >= turning[2].no_forecast_bound


def test_with_one_dead_band_it_is_never_below_the_bound_without_a_forecast():
    """So far a turn that the formula for K = 1 alone would promise less."""
    computed = [tv.plane_limit(PLANT, veering(4, turn)) for turn in (450.0, 720.0, 1500.0)]
    for one in computed:
        assert one.limit >= one.no_forecast_bound
    assert computed[-1].limit == computed[-1].no_forecast_bound
    assert "without a forecast is larger" in computed[-1].notes[-1]


def test_where_the_driver_falls_and_returns_every_larger_limit_is_sufficient():
    gusts = triangle(3.0) + 1.3 * triangle(3.0).shift(12.0)
    line = tv.boundary_limit(PLANT, gusts, 0.6)
    bent = PlaneWind(pitch=gusts, yaw=1e-9 * triangle(3.0))
    assert not bent.unidirectional
    limit = tv.plane_limit(PLANT, bent, dead_band=0.6)
    assert limit.limit == pytest.approx(line.limit, rel=1e-8)
    assert limit.switch_time == pytest.approx(line.switch_time, abs=1e-6)
    assert (line.status == "ok") == (not limit.notes[:-1])


@pytest.mark.thorough
def test_a_cluster_in_a_turning_wind_is_counted_from_inside():
    places = (1.0, 1.0j, -1.0, -1.0j)
    three = tv.boundary.Cluster(
        [
            tv.boundary.ClusterEngine(at=at, state="moving" if at != 1 else "centred")
            for at in places
        ]
    )
    wind = veering(4, 90)
    known = tv.plane_limit(PLANT, wind, three, dead_band=0.0)
    held = complex(known.pitch, known.yaw)
    assert known.deflection == pytest.approx(float(three.gauge(held)), rel=1e-12)
    limit = tv.plane_limit(PLANT, wind, three, dead_band=0.5)
    assert limit.deflection >= float(three.gauge(complex(limit.pitch, limit.yaw)))
    assert "polygon inside" in limit.notes[-1]


def measured(azimuth):
    """A plant, a wind, and three engines that move beside one that does not."""
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")
    profile = tv.read_soundings(Path(__file__).parents[1] / "soundings" / "wyoming.txt")[0]
    engines = [tv.boundary.ClusterEngine(at=1.0, state="centred")]
    engines += [tv.boundary.ClusterEngine(at=at) for at in (1.0j, -1.0, -1.0j)]
    wind = profile.to_winds(tv.load_schedule("configuration-i"), azimuth=azimuth)
    return plant, wind, tv.boundary.Cluster(engines)


def corners_needed(plant, wind, stop, even=60):
    """The least peak of a deflection that is constant in cells: one program of all corners."""
    poles = tv.unstable_modes(plant)
    p = poles.poles.real
    x = np.linspace(0.0, 1.0, even + 1)  # e^(-p t) of the fast pole; the other is a power of it
    x = np.unique(np.concatenate([x ** (p[0] / one) for one in p]))[::-1]
    cells = x.size - 1
    parts = np.stack([(x[:-1] ** r - x[1:] ** r) for r in p / p[0]]) / p[:, np.newaxis]
    rows, calls = [], []
    onset = float(wind.onset)
    for axis, blown in ((1.0, wind.pitch), (1.0j, wind.yaw)):
        for k in range(p.size):
            moments = np.real(np.conj(axis) * stop.corners)
            rows.append((parts[k][:, np.newaxis] * moments).ravel())
            size = -poles.wind_residues[k] / poles.deflection_residues[k]
            calls.append(size * np.exp(p[k] * onset) * float(blown.laplace(p[k])))
    each = np.kron(np.eye(cells), np.ones(stop.corners.size))
    scale = np.abs(calls).max()
    result = linprog(
        np.append(np.zeros(each.shape[1]), 1.0),
        A_ub=np.column_stack([each, -np.ones(cells)]),
        b_ub=np.zeros(cells),
        A_eq=np.column_stack([rows, np.zeros(len(rows))]),
        b_eq=np.asarray(calls) / scale,
    )
    return result.fun * scale


@pytest.mark.thorough
@pytest.mark.parametrize("azimuth", usual([0.5, 1.0, 4.5], 1))
def test_the_minimum_of_a_cluster_in_a_measured_wind_is_proved(azimuth):
    """In a part of the cells two corners share the deflection."""
    plant, wind, cluster = measured(azimuth)
    best = tv.boundary.plane_optimum(plant, wind, cluster)
    assert best.status == "ok"
    assert abs(best.certificate.gap) < 1e-6
    limit = tv.plane_limit(plant, wind, cluster, dead_band=0.0)
    assert limit.limit == pytest.approx(best.limit, rel=1e-12)
    assert not any("the minimum is not solved" in note for note in limit.notes)


@pytest.mark.thorough
def test_it_is_that_of_a_program_of_all_corners():
    plant, wind, cluster = measured(1.0)
    stop = cluster.inscribed(24)
    best = tv.boundary.plane_optimum(plant, wind, stop)
    needed = corners_needed(plant, wind, stop)
    assert best.certificate.dual <= needed * (1.0 + 1e-9)
    assert needed == pytest.approx(best.peak, rel=1e-4)  # of wider cells


@pytest.mark.thorough
def test_what_is_left_of_a_minimum_is_told(monkeypatch):
    plant, wind, cluster = measured(1.0)
    solved = tv.boundary.plane_optimum(plant, wind, cluster)
    monkeypatch.setattr(plane_bounds, "_MAX_CUTTING_PLANES", 4)
    rough = tv.boundary.plane_optimum(plant, wind, cluster)
    assert "not converged" in rough.status
    assert rough.certificate.dual <= solved.peak <= rough.peak
    limit = tv.plane_limit(plant, wind, cluster, dead_band=0.0)
    assert any("the minimum is not solved" in note for note in limit.notes)


@pytest.mark.thorough
@pytest.mark.parametrize("width", [1.0, 1e-3, 1e-6])
def test_a_stop_may_be_thin(width):
    wind = veering(20, 120, beta=EXACT.coefficients.beta)
    best = tv.boundary.plane_optimum(EXACT, wind, EllipticShape(1.0, width))
    assert best.status == "ok"
    assert abs(best.certificate.gap) < 1e-5
    assert best.certificate.residual < 1e-12


@pytest.mark.thorough
def test_a_batch_is_what_each_is_alone():
    gusts = tv.TriangularWind(peak=0.08, duration=[5.0, 9.0])
    winds = PlaneWind.veering(gusts, 0.3, [[0.0], [0.15]])
    limit = tv.plane_limit(PLANT, winds, dead_band=0.5)
    assert limit.limit.shape == limit.switch_time.shape == (2, 2)
    for case in range(4):
        single = tv.plane_limit(PLANT, winds.case(case, (2, 2)), dead_band=0.5)
        assert limit.deflection.ravel()[case] == single.deflection
    assert any("turns" in note for note in limit.notes)


# The minimum over all modes.


def from_ratio(ratio):
    """L/|D| at D1 = D2, by the closed form for two real poles, one in each plane."""
    s = 1.0 / (2.0 * (ratio - 1.0))

    def means(mu):
        x = mu**2 / (1.0 + mu**2)
        second = hyp2f1(0.5, 1.0, s + 1.0, x)
        first = mu * (s + 0.5) / (s + 1.0) * hyp2f1(0.5, 1.0, s + 2.0, x)
        return np.array([first, second]) / np.sqrt(1.0 + mu**2)

    mu = brentq(lambda mu: np.subtract(*means(mu)), 1e-3, 1e3, xtol=1e-14)
    return 1.0 / np.linalg.norm(means(mu))


@pytest.mark.thorough
@pytest.mark.parametrize("ratio", [1.1, 1.5, 3.0])
def test_planes_that_differ_are_served_one_after_the_other(ratio):
    """A nozzle that turns from the faster plane to the slower; the vector held is safe."""
    plants = [
        tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=b, B=0.107))
        for b in (0.5 * ratio, 0.5)
    ]
    gust = tv.TriangularWind(peak=0.01, duration=8.0)
    even = [gust * (1.0 / tv.boundary_limit(plant, gust, 0.0).limit) for plant in plants]
    wind = PlaneWind(pitch=even[0], yaw=even[1])
    safe = tv.plane_limit(plants[0], wind, dead_band=0.0, yaw_plant=plants[1])
    best = tv.boundary.plane_optimum(plants[0], wind, yaw_plant=plants[1])
    proof = best.certificate
    assert 0.0 <= proof.gap < 1e-5
    assert proof.residual < 1e-12
    expected = from_ratio(ratio)
    assert proof.dual / safe.deflection <= expected * (1.0 + 1e-9)
    assert expected <= best.peak / safe.deflection * (1.0 + 1e-9)
    angles = np.abs(np.angle(-best.deflections))
    assert np.all(np.diff(angles[best.times < 20.0]) > 0.0)


PUBLISHED = {(4, 90): 0.35503, (4, 180): 0.31155, (20, 180): 0.11543, (40, 360): 0.09647}


@pytest.mark.parametrize("case", PUBLISHED)
def test_two_modes_in_each_plane_with_proof(case):
    best = tv.boundary.plane_optimum(EXACT, veering(*case, beta=EXACT.coefficients.beta))
    assert best.limit == pytest.approx(PUBLISHED[case], abs=5.1e-6)
    assert abs(best.certificate.gap) < 1e-6
    assert best.status == "ok"


@pytest.mark.thorough
def test_the_deflection_of_the_optimum_meets_the_condition_of_every_mode():
    wind = veering(20, 120, beta=EXACT.coefficients.beta)
    best = tv.boundary.plane_optimum(EXACT, wind, EllipticShape(1.0, 0.6))
    steps = np.diff(best.deflections, prepend=0.0)
    for plane, part in (("pitch", np.real), ("yaw", np.imag)):
        poles = tv.unstable_modes(EXACT)
        for k, p in enumerate(poles.poles):
            # each step of the deflection is one from its time on: e^(-p t)/p
            turned = (part(steps) * np.exp(-p * best.times)).sum() / p
            blown = getattr(wind, plane).laplace(p)
            left = poles.deflection_residues[k] * turned + poles.wind_residues[k] * blown
            size = abs(poles.wind_residues[k]) * getattr(wind, plane).laplace_magnitude(p)
            assert abs(left) < 1e-11 * size
    assert EllipticShape(1.0, 0.6).gauge(best.deflections).max() <= best.peak * (1.0 + 1e-12)


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_along_a_line_the_optimum_is_that_of_one_plane(angle):
    gust = triangle(20.0, EXACT.coefficients.beta)
    best = tv.boundary.plane_optimum(EXACT, PlaneWind.towards(gust, angle))
    assert best.peak == pytest.approx(tv.optimum_deflection(EXACT, gust).peak, rel=1e-9)
    long = triangle(40.0, EXACT.coefficients.beta)
    limit = tv.plane_limit(EXACT, PlaneWind.towards(long, angle), dead_band=0.5)
    assert "minimum over all unstable poles after trim" in limit.notes[-1]
    single = tv.required_deflection(EXACT, long, 0.5)
    assert limit.limit == pytest.approx(single.limit, rel=1e-9)
    onset = tv.plane_limit(EXACT, PlaneWind.towards(long, angle), dead_band=0.0)
    assert onset.limit == pytest.approx(0.22529, abs=5.1e-6)
    assert onset.limit < 0.98 * limit.limit


def test_a_square_stop_is_two_problems_of_one_plane():
    wind = veering(20, 90, beta=EXACT.coefficients.beta)
    best = tv.boundary.plane_optimum(EXACT, wind, SquareShape())
    each = [tv.optimum_deflection(EXACT, one).peak for one in (wind.pitch, wind.yaw)]
    assert best.certificate.dual <= max(each) * (1.0 + 1e-9)
    assert max(each) <= best.peak * (1.0 + 1e-9)
    assert best.certificate.gap < 1e-3


# Without a forecast, against convex programs.


def program(wind, turned=(), sides=32, steps=64):
    """The least y with which one path stays within y of zero, and of it less each wind to come.

    In units of the peak, by a linear program over a round stop whose sides lie outside it: never
    more than the truth, and never less than cos(pi/sides) of it, at the steps.
    """
    edges = np.linspace(0.0, float(wind.end), steps + 1)
    ahead = BETA * wind.remaining_integral(BETA, edges) / float(wind.peak)
    e = np.exp(BETA * np.diff(edges)[0])
    request = ahead[:-1] - ahead[1:] / e  # discounted to the begin of each step
    normals = np.exp(2j * np.pi * np.arange(sides) / sides)
    parts = np.stack([normals.real, normals.imag], axis=1)
    cells = []
    # z after a step is e (z - demand - u (1 - 1/e)); z starts at zero, |u| <= y
    for k in range(steps):
        block = np.zeros((sides, 2 * steps + 1))
        block[:, 2 * k : 2 * k + 2] = -parts / e
        if k:
            block[:, 2 * k - 2 : 2 * k] = parts
        block[:, -1] = -(1.0 - 1.0 / e)
        cells.append((block, np.real(np.conj(normals) * request[k])))
        for there in (0.0, *turned):
            block = np.zeros((sides, 2 * steps + 1))
            block[:, 2 * k : 2 * k + 2] = parts
            block[:, -1] = -1.0
            cells.append((block, np.real(np.conj(normals) * there)))
    rows = np.concatenate([block for block, _ in cells])
    right = np.concatenate([one for _, one in cells])
    cost = np.append(np.zeros(2 * steps), 1.0)
    bounds = [(None, None)] * (2 * steps) + [(0.0, None)]
    return linprog(cost, rows, right, bounds=bounds, method="highs-ipm").fun


@pytest.mark.thorough
@pytest.mark.parametrize("tau_beta", [4, 8])
@pytest.mark.parametrize("degrees", [0, 90, 180])
def test_a_convex_program_meets_the_bound_without_a_forecast(tau_beta, degrees):
    """By a path for the wind, whatever the limit shape; to .004 for turns of 180 degrees."""
    wind = veering(tau_beta, degrees)
    bound = limits(tau_beta, degrees)[2].no_forecast_bound
    result = program(wind)
    room = 0.004 if degrees > 90 else 1e-5
    assert result <= bound + room
    # between the steps a largest value is missed by half the square of a step at most
    step = BETA * float(wind.end) / 64
    assert bound <= (result + 0.5 * step**2) / np.cos(np.pi / 32)


def test_the_bound_of_a_sudden_turn():
    limit = tv.plane_limit(PLANT, sudden(4, 90), dead_band=0.0)
    assert limit.limit == pytest.approx(0.30677, abs=5.1e-6)
    assert limit.no_forecast_bound == pytest.approx(0.30677, abs=5.1e-6)


@pytest.mark.thorough
@pytest.mark.parametrize("stop", [SquareShape(0.4), EllipticShape(1.0, 0.4), KITE])
def test_the_bound_for_other_stops_among_all_pairs_of_times(stop):
    wind = veering(8, 150)
    result = no_forecast_bound(PlanePair((PLANT, PLANT), wind), stop)
    t = np.linspace(0.0, float(wind.end), 151)
    ahead = -PLANT.coefficients.B * BETA * wind.remaining_integral(BETA, t)
    request = ahead[:, np.newaxis] - ahead * np.exp(-BETA * np.maximum(t - t[:, np.newaxis], 0.0))
    request = request[np.triu_indices(151)]
    around = np.exp(2j * np.pi * np.arange(360) / 360)
    both = stop.support(around) + stop.support(-around)
    apart = (np.real(np.conj(around) * request[:, np.newaxis]) / both).max()
    sought = max(apart, stop.gauge(ahead[0] - ahead * np.exp(-BETA * t)).max())
    assert sought <= result * (1.0 + 1e-9)
    assert result <= sought * 1.01


def test_a_wind_of_one_direction_has_the_scalar_bound_both_ways_of_computing():
    wind = triangle(8.0)
    scalar = abs(tv.forecast_free_limit(PLANT, wind).deflection)
    straight = PlanePair((PLANT, PLANT), PlaneWind.towards(wind, 0.6))
    # five grids narrow a step of .1 s to 2e-6 s; the largest value is flat
    assert no_forecast_bound(straight, CircularShape()) == pytest.approx(scalar, rel=1e-9)


# A turn instead of a stop.

TURNS = [(8.0, 0.3, 60.0, 0.4145), (8.0, 0.3, 90.0, 0.4688), (8.0, 0.3, 120.0, 0.5240)]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("tau_beta", "R", "degrees", "published"),
    usual(
        [*TURNS, (8.0, 0.3, 180.0, 0.5645), (4.0, 0.6, 75.0, None), (20.0, 0.8, 40.0, None)], 1, 4
    ),
)
def test_a_turn_instead_of_a_stop_against_a_convex_program(tau_beta, R, degrees, published):
    phi = np.radians(degrees)
    wind = triangle(tau_beta)
    free = tv.forecast_free_limit(PLANT, wind, R, phi)
    computed = free.limit
    if published:
        assert computed == pytest.approx(published, abs=5.1e-5)
    assert (free.kind == forecast_free.EXACT) == (np.cos(phi) <= -R / (2.0 * computed))
    turned = R * np.exp(1j * phi), R * np.exp(-1j * phi)
    steps = 128 if tau_beta > 8 else 64
    sought = max(program(PlaneWind.towards(wind, 0.0), turned, steps=steps), R)
    step = BETA * wind.duration / steps
    if free.kind == forecast_free.EXACT:
        assert sought <= computed * (1.0 + 1e-7)  # of the program
    elif degrees == 60.0:  # a turn of 60 degrees when the wind ends, and all is used up
        assert sought == pytest.approx(0.4163, abs=2e-4)
    assert computed <= (sought + 0.5 * step**2) / np.cos(np.pi / 32)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(20))
def test_the_least_circle_around_what_may_come(seed):
    """Of 0, sup W and R e^(+-j phi): on the line of the wind, by search."""
    draw = np.random.default_rng(seed)
    phi, R, wind = draw.uniform(0.0, np.pi), draw.uniform(0.0, 1.2), triangle(draw.uniform(1, 20))
    plain = tv.forecast_free_limit(PLANT, wind)
    S = float(BETA * wind.remaining_integral(BETA, plain.worst_stop_time) / wind.peak)
    z = np.linspace(0.0, 1.0, 200_001)
    radius = np.max([z, np.abs(S - z), np.abs(z - R * np.exp(1j * phi))], axis=0).min()
    expected = max(plain.wind_known, radius, R)
    computed = tv.forecast_free_limit(PLANT, wind, R, phi).limit
    assert computed == pytest.approx(expected, abs=5e-6)  # of the search


def test_small_turns_cost_nothing_and_a_turn_by_pi_is_a_reversal():
    wind = triangle(8.0)
    plain = tv.forecast_free_limit(PLANT, wind).limit
    S = 2.0 * plain
    edge = np.arccos(0.3 / S)
    turns = np.linspace(0.0, np.pi, 50)
    computed = [tv.forecast_free_limit(PLANT, wind, 0.3, phi).limit for phi in turns]
    assert np.all(np.diff(computed) >= 0.0)
    assert np.all(np.asarray(computed)[turns < edge] == plain)
    assert np.all(np.asarray(computed)[turns > edge] > plain)
    assert computed[-1] == tv.forecast_free_limit(PLANT, wind, 0.3).limit
    right = tv.forecast_free_limit(PLANT, wind, 0.3, np.pi / 2).limit
    assert right == pytest.approx((S**2 + 0.09) / (2.0 * S), rel=1e-12)
    with pytest.raises(InputError, match="turn must be between 0 and"):
        tv.forecast_free_limit(PLANT, wind, 0.3, 4.0)


# What is refused.

MERGED = EXACT.coefficients.replace(C2=0.39 * EXACT.coefficients.beta**3)
PAIR = tv.Plant.from_coefficients(MERGED, "drift-exact")
STABLE = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=-0.3, mu_delta=2.6))


@pytest.mark.parametrize("door", [tv.plane_limit, tv.boundary.plane_optimum])
@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"wind": triangle(4.0)}, "wind must have a direction: give PlaneWind.towards"),
        ({"wind": 0.1}, "wind must be a PlaneWind"),
        ({"wind": PlaneWind.towards(0.0 * triangle(4.0), 0.0)}, "be other than zero"),
        (
            {"wind": PlaneWind.towards(tv.linear.ConstantDeflection(limit=0.1), 0.0)},
            "wind must end",
        ),
        ({"plant": PAIR}, "all real; it has the complex pair"),
        ({"yaw_plant": PAIR}, "yaw_plant must have unstable poles, all real; it has the complex"),
        ({"plant": STABLE}, "it has none"),
        ({"limit_shape": "round"}, "limit_shape must be a LimitShape"),
    ],
)
def test_what_has_no_limit_in_two_planes_is_refused(door, changed, message):
    with pytest.raises(InputError, match=message):
        door(**{"plant": PLANT, "wind": veering(4, 90), **changed})


def test_a_pair_in_the_fourth_order_model_is_refused():
    plant = tv.Plant.from_vehicle(BOOSTER, "drift-and-speed")
    with pytest.raises(InputError, match="all real; it has 1 real and the complex pair"):
        tv.plane_limit(plant, veering(4, 90))


@pytest.mark.parametrize(
    ("changed", "message"),
    [({"dead_band": 1.1}, "dead_band must be between"), ({"switch": "x"}, "switch must be one of")],
)
def test_arguments_beyond_their_range_are_refused(changed, message):
    with pytest.raises(InputError, match=message):
        tv.plane_limit(PLANT, veering(4, 90), **changed)


def test_planes_of_other_models_are_served_together():
    """Two conditions in pitch and one in yaw: never less than pitch alone, nor more than both."""
    wind = veering(12, 60, beta=EXACT.coefficients.beta)
    flat = tv.Plant.from_vehicle(BOOSTER, "fixed-path")
    best = tv.boundary.plane_optimum(EXACT, wind, yaw_plant=flat)
    single = (
        tv.optimum_deflection(EXACT, wind.pitch).peak,
        tv.optimum_deflection(flat, wind.yaw).peak,
    )
    assert abs(best.certificate.gap) < 1e-5
    assert max(single) <= best.peak * (1.0 + 1e-9)
    assert best.certificate.dual <= np.hypot(*single) * (1.0 + 1e-9)


def test_the_optimum_is_of_one_wind():
    with pytest.raises(InputError, match="got a batch of shape"):
        tv.boundary.plane_optimum(PLANT, PlaneWind.veering(triangle(4.0), [0.0, 1.0], 0.1))


@pytest.mark.thorough
@pytest.mark.parametrize("time", [66.0, 97.0, 112.0])
def test_slow_poles_far_below_the_fast_ones_have_no_say_in_the_minimum(time) -> None:
    """Late in the flight the slow modes are served when the fast ones are long settled.

    Then the least is that of the fast modes, as for each plane alone; the planes are almost equal,
    so it is the norm of both.
    """
    vehicle = tv.load_schedule("configuration-i").at(time)
    gust = tv.TriangularWind(peak=0.08, duration=7.5)
    wind = PlaneWind.towards(gust, np.radians(55))
    pitch, yaw = (tv.Plant.from_vehicle(vehicle, "drift-exact", p) for p in ("pitch", "yaw"))
    best = tv.boundary.plane_optimum(pitch, wind, yaw_plant=yaw)
    assert best.certificate.gap < 1e-4
    assert best.certificate.residual < 1e-12
    single = [tv.optimum_deflection(p, w).peak for p, w in ((pitch, wind.pitch), (yaw, wind.yaw))]
    assert best.peak <= np.hypot(*single) * (1.0 + 1e-4)
    assert best.certificate.dual >= np.hypot(*single) * (1.0 - 1e-4)


def test_where_trim_grows_a_turning_wind_has_no_dead_band() -> None:
    """With b1 < 0 what trims the wind drives the path on; a straight wind has its scalar answer."""
    c = tv.Coefficients.from_beta(beta=0.5, B=0.1).replace(b1=-0.02, b2=0.01)
    plant, gust = tv.Plant.from_coefficients(c, "drift-exact"), triangle(4.0)
    turning = PlaneWind.veering(gust, angle=0.0, rate=0.2)
    with pytest.raises(tv.InputError, match="requires plants with b1 of zero or more"):
        tv.plane_limit(plant, turning)
    assert tv.plane_limit(plant, turning, dead_band=0.0).limit > 0.0
    straight = tv.plane_limit(plant, PlaneWind.towards(gust, 0.4))
    assert straight.limit == pytest.approx(tv.boundary_limit(plant, gust).limit, rel=1e-12)


def test_a_cluster_that_cannot_trim_its_own_jammed_engine_is_refused() -> None:
    with pytest.raises(tv.InputError, match="engines must"):
        tv.boundary.Cluster(
            [
                tv.boundary.ClusterEngine(at=1, state="stuck", deflection=1),
                tv.boundary.ClusterEngine(at=-1),
            ]
        )
