"""Laws that know what the nozzle turns at most, beside a convex program and in JSBSim."""

import numpy as np
import pytest
from scipy import sparse
from scipy.optimize import linprog
from scipy.special import lambertw

import tvclin as tv
from tests.turns import usual
from tvclin.control import design_law
from tvclin.kernels.control_laws import lean_command, recovery_travel

PEAK, B, BETA = 0.1, 0.1, 0.5
FIXED = tv.Plant(tv.Coefficients.from_beta(beta=BETA, B=B), "fixed-path")
VEHICLE = tv.load_vehicle("configuration-i")
EXACT = tv.Plant.from_vehicle(VEHICLE, "drift-exact")


def triangle(plant, tau_beta):
    return tv.TriangularWind(peak=PEAK, duration=tau_beta / float(plant.coefficients.pole))


def turning(plant, rho):
    """A rate limit [rad/s] that is so many times p B A."""
    c = plant.coefficients
    return rho * float(c.pole) * PEAK * float(c.B)


def recoverable(plant, rate_limit=np.inf, **options):
    return tv.RecoverableAttitudeLaw(plant, design_peak=PEAK, rate_limit=rate_limit, **options)


def program(tau_beta, rho, count=300, tangents=40):
    """The least y of a law that a stop at any instant may meet, in a triangle, as a linear program.

    Of v = -delta/(B A) and z at nodes, v straight between them: z' = z - w + v in the time of the
    pole, |v'| <= rho, |v| <= y, and z + v within rho (1 - e^(-(y +- v)/rho)), which is concave: so
    many tangents of it.
    """
    h = tau_beta / count
    times = h * np.arange(count + 1)
    w = 1.0 - np.abs(2.0 * times / tau_beta - 1.0)
    first = np.exp(h) - (np.exp(h) - 1.0) / h  # of an input at the start of a step
    last = (np.exp(h) - 1.0) / h - 1.0
    n = count + 1
    one = sparse.eye_array(n, format="csr")
    before, after, none = one[:-1], one[1:], sparse.csr_array((count, n))
    moves = sparse.hstack(
        [after - np.exp(h) * before, -(first * before + last * after), np.zeros((count, 1))]
    )
    starts = sparse.csr_array(([1.0, 1.0], ([0, 1], [0, n])), shape=(2, 2 * n + 1))
    equal = sparse.vstack([moves, starts])
    known = np.append(-(first * w[:-1] + last * w[1:]), [0.0, 0.0])
    rows, most = [], []
    for sign in (1.0, -1.0):
        rows.append(sparse.hstack([none, sign * (after - before), np.zeros((count, 1))]))
        most.append(np.full(count, rho * h))
        rows.append(sparse.hstack([0.0 * one, sign * one, -np.ones((n, 1))]))
        most.append(np.zeros(n))
        for s in np.linspace(0.0, 3.0, tangents):
            slope = np.exp(-s / rho)
            at = rho * (1.0 - slope) - slope * s
            rows.append(
                sparse.hstack([sign * one, sign * (1.0 - slope) * one, -slope * np.ones((n, 1))])
            )
            most.append(np.full(n, at))
    result = linprog(
        np.append(np.zeros(2 * n), 1.0),
        A_ub=sparse.vstack(rows, format="csr"),
        b_ub=np.concatenate(most),
        A_eq=equal,
        b_eq=known,
        bounds=[(None, None)] * (2 * n) + [(0.0, None)],
    )
    assert result.status == 0
    return float(result.x[-1])


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("tau_beta", "rho", "expected"),
    usual(
        [
            (4.0, 1.0, 0.514),
            (8.0, 1.0, 0.636),
            (2.0, 1.2, 0.486),
            (4.0, 0.6, 0.734),
            (4.0, 2.0, 0.416),
        ],
        0,
    ),
)
def test_the_law_is_near_a_convex_program_of_all_laws_that_a_stop_may_meet(tau_beta, rho, expected):
    """The program is good for 2e-3. A part of the set is the set of a part of limit and rate."""
    reach, rate, wind = 0.98, turning(FIXED, rho), triangle(FIXED, tau_beta)
    minimum = program(tau_beta, rho)
    assert minimum == pytest.approx(expected, abs=2e-3)
    law = recoverable(FIXED, rate, reach=reach)
    flown = tv.closed_loop_boundary(FIXED, law, wind, rate_limit=rate, sample_rate=100, cuts=5)
    assert minimum - 2e-3 < flown.limit < 1.02 * program(tau_beta, reach * rho) / reach
    assert flown.monotone


def test_how_far_the_nozzle_turns_is_the_inverse_of_the_recoverable_set():
    swing, room = 0.3, np.array([0.0, 1e-9, 1e-3, 0.1, 0.5, 2.0, 40.0])
    q = room / swing
    exact = 1.0 + q + lambertw(-np.exp(-1.0 - q)).real
    exact[:2] = np.sqrt(2.0 * q[:2])  # the same, to a part of sqrt(q)/4, without the branch point
    computed = np.array([recovery_travel(one, swing) for one in room]) / swing
    assert computed == pytest.approx(exact, rel=3e-5, abs=0.0)
    assert computed[2:] == pytest.approx(exact[2:], rel=1e-9)
    assert recovery_travel(-1.0, swing) == 0.0


@pytest.mark.parametrize("plant", [FIXED, EXACT])
def test_without_a_rate_limit_the_law_is_what_it_was_to_the_last_digit(plant):
    law, seen = recoverable(plant), np.random.default_rng(3).normal(scale=0.05, size=(200, 4))
    n = law.numbers
    for theta, rate, path, alpha in seen:
        wind = theta - alpha - path
        felt, D = n.wind * wind, 0.006 / abs(n.B)
        fast = n.fast_attitude * theta + n.fast_rate * rate + n.fast_path * path
        slow = n.slow_attitude * theta + n.slow_rate * rate + n.slow_path * path
        before = n.B * (fast - felt + n.gain * (fast - lean_command(n, slow, felt, abs(wind), D)))
        measurement = tv.control.laws.law.Measurement(theta, rate, path, alpha, 0.0)
        assert law.demand(measurement, np.zeros(0), 0.006) == before
    assert design_law("trim", plant, PEAK) == tv.TrimLaw(tv.Plant(plant.coefficients, "fixed-path"))
    assert design_law("recoverable-attitude", plant, PEAK) == law


@pytest.mark.thorough
def test_with_drift_an_actuator_a_delay_and_sudden_stops():
    """At twice the rate of the wind: .51 is the least, and the law that knows no rate is lost."""
    rate, wind = turning(EXACT, 1.0), triangle(EXACT, 4.0)
    nozzle = {"actuator": tv.Actuator(natural_frequency=20.0), "delay": 0.02, "cuts": 3}
    flown = {"rate_limit": rate, "sample_rate": 50, "lowest": 0.3, "highest": 1.5}
    boundary = tv.closed_loop_boundary(EXACT, recoverable(EXACT, rate), wind, **flown, **nozzle)
    assert 0.5 < boundary.limit < 0.55
    assert boundary.monotone
    for more in ({}, {"cuts": 3}):
        before = tv.closed_loop_boundary(EXACT, recoverable(EXACT), wind, **flown, **more)
        assert before.limit > 1.0
    gyro = tv.control.WindEstimator(bandwidth=10.0, rate_noise=np.radians(0.02), seed=1)
    blind = recoverable(EXACT, rate, reach=0.8, gain=5.0, estimator=gyro)
    boundary = tv.closed_loop_boundary(EXACT, blind, wind, **flown, **nozzle)
    assert boundary.limit < 0.65


@pytest.mark.thorough
@pytest.mark.parametrize("name", usual(["trim", "recoverable-attitude"], 0))
def test_flights_in_jsbsim_need_the_same_within_half_a_percent(name):
    """In a wind of half a degree, where the linear plant is the vehicle."""
    wind, rate = 0.1 * triangle(EXACT, 4.0), 0.1 * turning(EXACT, 1.0)
    law = design_law(name, EXACT, 0.1 * PEAK, rate_limit=rate)
    nozzle = {"actuator": tv.Actuator(natural_frequency=40.0), "rate_limit": rate}
    linear = tv.closed_loop_boundary(EXACT, law, wind, sample_rate=100, **nozzle)
    flown = tv.flown_boundary(VEHICLE, wind, law=law, engine="sixdof", tolerance=1e-3, **nozzle)
    assert flown.limit == pytest.approx(linear.limit, rel=5e-3)


@pytest.mark.parametrize(
    ("tau_beta", "rho"), usual([(2.0, 1.2), (4.0, 0.6), (4.0, 1.0), (8.0, 0.5)], 1)
)
def test_trim_with_the_gain_that_suits_needs_the_known_minimum_of_a_nozzle_as_slow(tau_beta, rho):
    """Trim that is never late needs eq. (12) with K = 1, from the wind's own rate on."""
    rate, wind = turning(FIXED, rho), triangle(FIXED, tau_beta)
    flown = {"rate_limit": rate, "sample_rate": 100}
    law = design_law("trim", FIXED, PEAK, rate_limit=rate)
    assert law.gain == pytest.approx(rho)
    minimum = tv.boundary_limit(FIXED, wind).limit
    boundary = tv.closed_loop_boundary(FIXED, law, wind, **flown)
    assert minimum - 2e-3 < boundary.limit < 1.02 * minimum
    assert boundary.monotone
    usual = tv.closed_loop_boundary(FIXED, tv.TrimLaw(FIXED), wind, **flown)
    assert usual.limit > 1.05 * minimum


@pytest.mark.thorough
def test_in_both_planes_a_wind_in_any_direction_needs_no_more():
    """The rate is that of each plane, so one in between turns faster still."""
    rate, wind = turning(FIXED, 1.0), triangle(FIXED, 4.0)
    law = recoverable(FIXED, rate)
    flown = {"rate_limit": rate, "sample_rate": 25.0, "lowest": 0.4, "highest": 0.8}
    one = tv.closed_loop_boundary(FIXED, law, wind, **flown).limit
    oblique = tv.winds.PlaneWind.towards(wind, np.radians(30.0))
    assert tv.flights.flown_plane_limit(FIXED, law, oblique, **flown).limit < 1.01 * one
