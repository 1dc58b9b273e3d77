"""Gains for the least nozzle against exact peaks, brute scans, another search and flights."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag, expm

import tvclin as tv
from tests.turns import usual
from tvclin.control.autopilot.wind_response import deflection_peaks
from tvclin.design import minimum_gains as search_of
from tvclin.design.gain_problem import (
    UNSATISFIED_COST,
    GainProblem,
    required_limits,
    with_sudden_ends,
)
from tvclin.numerics.searches import box_minimum

VEHICLE = tv.load_vehicle("configuration-i")
NOZZLE = {"actuator": tv.Actuator(natural_frequency=8.0 * np.pi, damping=0.7), "delay": 0.02}
TWO, THREE = ("attitude", "rate"), ("attitude", "rate", "alpha")
BETA = float(tv.Coefficients.from_vehicle(VEHICLE).beta)


def plant(model="drift-exact"):
    return tv.Plant.from_vehicle(VEHICLE, model)


def triangles(*tau_beta):
    return [tv.TriangularWind(peak=0.05, duration=x / BETA) for x in tau_beta]


def problem(**changes):
    options = {
        "plant": plant(),
        "winds": tuple(triangles(4)),
        "criteria": tv.CRITERIA["classic"],
        "gains": TWO,
        **NOZZLE,
        "crossover": None,
        "filters": (),
        "limits": False,
        "stops": 0,
        "sample_rate": None,
    }
    return GainProblem(**(options | changes))


@pytest.fixture(scope="module")
def two():
    """Two gains in one wind, sought without a warning."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return tv.minimum_deflection_gains(plant(), triangles(4), crossover=2.0, **NOZZLE)


@pytest.fixture
def hasty(monkeypatch):
    """Let a search end early, where its result is not what is tested."""
    monkeypatch.setitem(search_of._LINEAR_SEARCH, "rounds", 4)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("model", "gains", "crossover", "tau_beta", "peak", "held"),
    usual(
        [
            ("fixed-path", TWO, None, (4,), 1.0353, (10.41, 3.544, 0.0)),
            ("drift-exact", THREE, 2.0, (2, 4, 8, 16), 0.8952, (0.983, 0.507, 0.292)),
        ],
        0,
    ),
)
def test_least_gains_are_those_of_another_search(model, gains, crossover, tau_beta, peak, held):
    """Found before the package, by differential evolution; gains of flat minima to 3 percent."""
    design = tv.minimum_deflection_gains(
        plant(model), triangles(*tau_beta), gains=gains, crossover=crossover, **NOZZLE
    )
    assert design.relative == pytest.approx(peak, abs=2e-3)
    assert design.meaning == "peak"
    a = design.autopilot
    assert (a.attitude_gain, a.rate_gain, a.alpha_gain) == pytest.approx(held, rel=0.03, abs=2e-3)
    assert tv.CRITERIA["classic"].are_satisfied(a.margins(plant(model)))


@pytest.mark.thorough
def test_a_differential_evolution_with_single_loops_finds_the_same(two):
    """It asks `answer` and `margins` one by one, in a box around, and finds nothing less."""
    from scipy.optimize import differential_evolution

    wind, computed = triangles(4)[0], two
    assert computed.active == ("phase_margin_deg", "crossover")

    def cost(gains):
        one = tv.Autopilot(attitude_gain=gains[0], rate_gain=gains[1], **NOZZLE)
        margins = one.margins(plant())
        if not margins.stable:
            return UNSATISFIED_COST + 10.0
        short = max(0.0, 30.0 - margins.phase_margin_deg, 6.0 - margins.aero_margin_dB)
        short += max(0.0, float(np.max(margins.crossings.gain_frequencies)) - 2.0)
        trim = float(plant().coefficients.B) * wind.peak
        return (
            (UNSATISFIED_COST + short)
            if short
            else abs(one.wind_response(plant(), wind).peak("deflection")[0]) / trim
        )

    other = differential_evolution(
        cost, [(0.8, 1.6), (0.4, 0.8)], popsize=5, maxiter=9, seed=1, polish=False, tol=0.0
    )
    assert computed.relative - 1e-4 <= other.fun <= computed.relative + 0.02


@pytest.mark.thorough
def test_a_brute_scan_finds_nothing_less(two):
    """Over the whole box, 50 by 50, in the batch engines and the best then exactly."""
    request, computed = problem(crossover=2.0), two
    axes = np.meshgrid(*2 * [np.linspace(0.0, 1.0, 50)], indexing="ij")
    points = np.stack([axis.ravel() for axis in axes], axis=-1)
    good = points[request.shortfalls(points) <= 0.0]
    peaks = deflection_peaks(request.autopilot(good), request.plant, request.winds[0], 8.0 / BETA)
    assert good.shape[0] > 60
    best = (
        request.autopilot(good[np.argmin(peaks)])
        .wind_response(request.plant, request.winds[0])
        .peak("deflection")
    )
    assert computed.deflection < abs(best[0]) < 1.1 * computed.deflection


@pytest.mark.parametrize("gust", ["triangle", "rectangle", "cosine"])
def test_peaks_of_many_loops_are_those_of_each(gust):
    """Steps resolve well-damped loops: a parabola then errs by the fourth power of one."""
    duration = 4.0 / BETA
    wind = {
        "triangle": tv.TriangularWind(peak=0.05, duration=duration),
        "rectangle": tv.RectangularWind(peak=0.05, duration=duration),
        "cosine": tv.OneMinusCosineGust(peak=0.05, duration=duration),
    }[gust]
    c = plant().coefficients
    frequency = np.array([0.8, 1.5, 3.0])
    rows = tv.control.relief_gains(
        c, natural_frequency=frequency, damping=0.9, alpha_ratio=[1.2, 0.5, 0.8], **NOZZLE
    )
    many = deflection_peaks(rows, plant(), wind, 8.0 / BETA)
    for k, computed in enumerate(many):
        one = replace(
            rows,
            **{n: getattr(rows, n)[k] for n in ("attitude_gain", "rate_gain", "alpha_gain")},
        )
        assert computed == pytest.approx(
            abs(one.wind_response(plant(), wind).peak("deflection")[0]), rel=5e-4
        )


def test_the_share_of_alpha_is_affine_on_a_fixed_path():
    """For one loop the deflection is affine in b0, so its peak is convex: the middle is least."""
    fixed, wind = plant("fixed-path"), triangles(4)[0]
    B = float(fixed.coefficients.B)
    times = np.linspace(0.0, 15.0, 61)
    shown = [
        tv.Autopilot(attitude_gain=3 * B - b, rate_gain=0.4, alpha_gain=b, **NOZZLE).wind_response(
            fixed, wind
        )(times)[-1]
        for b in (0.0, B, 2 * B)
    ]
    np.testing.assert_allclose(shown[1], 0.5 * (shown[0] + shown[2]), atol=1e-12)


@pytest.mark.thorough
def test_a_limit_that_flies_is_below_the_peak_and_is_that_of_the_boundary():
    wind = triangles(4)[0]
    design = tv.minimum_deflection_gains(
        plant(), wind, crossover=2.0, limits=True, sample_rate=60.0, **NOZZLE
    )
    law = tv.SaturatedLaw.of(design.autopilot)
    flown = tv.closed_loop_boundary(plant(), law, wind, sample_rate=60.0, **NOZZLE)
    steady = replace(design.autopilot, sample_rate=None)
    peak = abs(steady.wind_response(plant(), wind).peak("deflection")[0])
    trim = float(plant().coefficients.B) * wind.peak
    assert design.meaning == "boundary"
    assert design.relative == pytest.approx(flown.limit, abs=1e-9)
    assert design.relative == pytest.approx(0.766, abs=0.002)
    assert 0.15 < peak / trim - design.relative < 0.4
    assert design.many_stops >= design.deflection * (1.0 - 1e-9)


def largest_z(autopilot, factor):
    """The largest closed-loop pole z with a factor on all gains: a held command, late by a part."""
    A, inputs = plant().matrices()[:2]
    w, zeta, h, n = 8.0 * np.pi, 0.7, 1.0 / autopilot.sample_rate, len(A)
    F = np.zeros((n + 3, n + 3))  # states, deflection, its rate, and the command that is held
    F[:n, :n], F[:n, n] = A, inputs[:, 0]
    F[n, n + 1], F[n + 1, n : n + 3] = 1.0, [-(w**2), -2.0 * zeta * w, w**2]
    early, later = expm(F * autopilot.delay), expm(F * (h - autopilot.delay))
    taken = np.eye(n + 4)  # the last is the command of the sample
    taken[n + 2] = np.eye(n + 4)[n + 3]
    asks = np.eye(n + 4)
    asks[n + 3] = 0.0
    asks[n + 3, :2] = factor * np.array([autopilot.attitude_gain, autopilot.rate_gain])
    step = block_diag(later, 1.0) @ taken @ block_diag(early, 1.0) @ asks
    return float(np.abs(np.linalg.eigvals(step)).max())


@pytest.mark.thorough
def test_gains_of_a_sampled_autopilot_keep_their_margins_in_steps():
    """A gain twice as high, or half as high, by the exponential matrices of one sample."""
    design = tv.minimum_deflection_gains(plant(), triangles(4)[0], sample_rate=15.0, **NOZZLE)
    assert design.autopilot.sample_rate == 15.0
    assert "gain_increase_dB" in design.active
    twice = 10.0 ** (6.0 / 20.0)
    assert all(largest_z(design.autopilot, k) < 1.0 for k in (1.0, twice, 1.0 / twice))
    assert largest_z(design.autopilot, 1.01 * twice) > 1.0


def test_filters_of_every_place_are_those_of_the_gains_that_are_tried():
    chains = {
        "filters": (tv.vehicle.Filter.low_pass(60.0),),
        "attitude_filters": (tv.vehicle.Filter.low_pass(50.0),),
        "rate_filters": (tv.vehicle.Filter.lead_lag(3.0, 30.0),),
    }
    tried = problem(**chains).autopilot(np.array([[0.5, 0.5]]))
    assert {name: getattr(tried, name) for name in chains} == chains


@pytest.mark.thorough
def test_the_race_finds_the_boundary_of_each_row():
    request = problem(limits=True, stops=2, sample_rate=60.0)
    points = np.array([[0.45, 0.5], [0.5, 0.6], [0.4, 0.55]])
    result = required_limits(request, points, np.inf, 60)
    for point, one in zip(points, result, strict=True):
        law = tv.SaturatedLaw.of(request.autopilot(point))
        flown = tv.closed_loop_boundary(
            request.plant, law, request.winds[0], sample_rate=60.0, cuts=2, **NOZZLE
        )
        assert one == pytest.approx(flown.limit, abs=2e-3)


def test_stops_are_the_winds_cut_at_even_instants():
    winds = tuple(triangles(4, 8))
    every = with_sudden_ends(winds, 3)
    assert every.batch == (8,)
    times = np.linspace(0.0, 16.0, 33)
    cut = winds[1].before(0.5 * winds[1].duration)
    np.testing.assert_allclose(every(times)[3], cut(times), atol=1e-15)
    np.testing.assert_allclose(every(times)[6:], [wind(times) for wind in winds], atol=1e-15)


@pytest.mark.thorough
@pytest.mark.usefixtures("hasty")
def test_what_is_overfitted_or_given_up_is_said():
    easy = tv.control.Criteria.custom(aero_margin_dB=6.0, phase_margin_deg=30.0)
    design = tv.minimum_deflection_gains(
        plant("fixed-path"), triangles(4), gains=THREE, criteria=easy, **NOZZLE
    )
    said = " ".join(design.notes)
    for words in ("below 0.45", "judge three gains on drift-exact", "one wind alone"):
        assert words in said


@pytest.mark.thorough
def test_more_disk_margin_costs_what_another_search_says():
    """Found before the package."""
    design = tv.minimum_deflection_gains(
        plant("fixed-path"),
        triangles(4),
        criteria=tv.control.Criteria.custom(aero_margin_dB=0.0),
        **NOZZLE,
    )
    front = tv.design.gain_trade_off(design, [1.2, 1.4])
    assert front.relative[0] == pytest.approx(1.1233, abs=1e-3)
    assert front.relative[1] == np.inf
    assert front.designs[1] is None
    boundary = tv.boundary_limit(plant("fixed-path"), triangles(4)[0])
    assert front.limits["boundary, K = 1"] == pytest.approx(boundary.limit)


@pytest.mark.thorough
@pytest.mark.usefixtures("hasty")
def test_a_flight_has_gains_at_each_time():
    c = tv.Coefficients(mu_alpha=[0.1, 0.28], mu_delta=[2.0, 2.6])
    plants = tv.Plant.from_coefficients(c)
    design = tv.design.minimum_gain_schedule(
        [40.0, 66.0], plants, triangles(4), crossover=2.0, **NOZZLE
    )
    assert tv.CRITERIA["classic"].are_satisfied(design.schedule.margins(plants)).all()
    assert design.deflection == max(one.deflection for one in design.designs)


@pytest.mark.thorough
def test_the_modes_of_a_flexible_vehicle_are_asked_too():
    flexible = tv.linear.plant_of(tv.load_vehicle("made-up-launcher"))
    criteria = tv.control.Criteria.custom(
        aero_margin_dB=6.0, phase_margin_deg=20.0, mode_gain_margin_dB=1.0
    )
    request = problem(plant=flexible, criteria=criteria)
    whole = problem(plant=flexible, criteria=replace(criteria, limits=criteria.limits[:2]))
    points = np.array([[x, y] for x in (0.1, 0.3, 0.5) for y in (0.4, 0.5, 0.6)])
    lacks, rigid = request.shortfalls(points), whole.shortfalls(points)
    assert np.all(lacks >= rigid)
    for point, lack in zip(points, lacks, strict=True):
        satisfied = criteria.are_satisfied(request.autopilot(point).band_margins(flexible))
        assert bool(satisfied) == (lack <= 0.0)


def test_the_search_finds_the_corner_of_two_walls():
    """The least of x + y where x y >= 0.04 and y >= 2 x is at x = 0.1 sqrt 2."""

    def values(points, pool):
        x, y = points.T
        lack = np.maximum(0.04 - x * y, 2.0 * x - y)
        return np.where(lack > 0.0, 10.0 + lack, x + y)

    points, _ = box_minimum(values, 2, initial=64, per_round=32, rounds=60)
    assert points[0] == pytest.approx([0.1 * np.sqrt(2.0), 0.2 * np.sqrt(2.0)], abs=1e-4)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"actuator": None, "delay": 0.0}, "without actuator, delay and crossover"),
        ({"stops": 6}, "give limits=True"),
        ({"gains": ("rate", "attitude")}, "gains must be"),
        ({"gains": ("attitude", "rate", "integral")}, "gains must be"),
        ({"winds": ()}, "winds must be one or more"),
        ({"winds": (tv.linear.ConstantDeflection(limit=0.01),)}, "must end"),
        ({"winds": (tv.TriangularWind(peak=[0.05, 0.1], duration=5.0),)}, "wind"),
        (
            {"plant": tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=-0.1, mu_delta=2.0))},
            "mu_alpha > 0",
        ),
        ({"crossover": -1.0}, "crossover"),
    ],
)
def test_what_cannot_be_sought_is_refused(changes, words):
    with pytest.raises(tv.InputError, match=words):
        problem(**changes)


def test_criteria_that_no_gains_meet_name_the_nearest_and_the_bound():
    with pytest.raises(tv.InputError) as said:
        tv.minimum_deflection_gains(
            plant("fixed-path"),
            triangles(4),
            criteria=tv.control.Criteria.custom(disk_margin=1.5),
            **NOZZLE,
        )
    words = str(said.value)
    assert "have disk 1.33 where 1.5 is required" in words
    assert "a disk margin of about 1.33" in words
    assert len(words) < 400
