"""What a nozzle and a cluster can do: closed forms, linear programs, and what is refused."""

import numpy as np
import pytest
from scipy.optimize import linprog

import tvclin as tv
from tests.turns import usual
from tvclin import InputError
from tvclin.boundary import (
    CircularShape,
    Cluster,
    ClusterEngine,
    EllipticShape,
    PolygonShape,
    SquareShape,
)

CROSS = (1.0, 1.0j, -1.0, -1.0j)
AROUND = np.exp(1j * np.radians(np.arange(0.0, 360.0, 7.5)))
KITE = PolygonShape([1.0, 0.6j, -0.5, -0.8j])
STOPS = (CircularShape(), SquareShape(0.3), EllipticShape(2.0, 0.7), KITE)
ROUNDING = 1e-13
"""Of the gauge by grids: 4e-15 of the bracket, which is some times the shape."""


def unit(degrees):
    return np.exp(1j * np.radians(degrees))


def cluster(dead, places=CROSS, stop=None, hold_roll=True, state="centred", deflection=0.0):
    stop = stop or CircularShape()
    held = {"state": state, "deflection": deflection}
    return Cluster(
        [
            ClusterEngine(at=at, limit_shape=stop, **(held if k in dead else {}))
            for k, at in enumerate(places)
        ],
        hold_roll,
    )


@pytest.mark.parametrize("stop", STOPS)
def test_the_gauge_follows_from_the_support(stop):
    """g(v) = max d.v/h(d): looked for among many directions, it is approached from below."""
    fine = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 40001))
    sought = (np.real(np.conj(fine) * AROUND[:, np.newaxis]) / stop.support(fine)).max(axis=1)
    result = stop.gauge(AROUND)
    assert np.all(sought <= result * (1.0 + ROUNDING))
    # a corner of the polar shape is missed by a slope of at most 8 times half a step
    assert np.all(sought >= result * (1.0 - 8.0 * np.pi / 40000))
    assert tv.boundary.LimitShape.gauge(stop, AROUND) == pytest.approx(result, rel=ROUNDING)
    assert stop.gauge(stop.farthest(AROUND)) == pytest.approx(1.0, rel=ROUNDING)
    reached = np.real(np.conj(AROUND) * stop.farthest(AROUND))
    assert reached == pytest.approx(stop.support(AROUND), rel=ROUNDING)


def test_gauges_in_closed_form():
    v = np.array([3.0 + 4.0j, -1.0j, 0.0])
    assert CircularShape().gauge(v).tolist() == [5.0, 1.0, 0.0]
    assert SquareShape().gauge(v).tolist() == [4.0, 1.0, 0.0]
    assert SquareShape(np.pi / 4).gauge(v[:2]) == pytest.approx([7 / 2**0.5, 0.5**0.5], rel=1e-15)
    assert EllipticShape(3.0, 2.0).gauge(v).tolist() == [np.hypot(1.0, 2.0), 0.5, 0.0]
    assert SquareShape().reach(np.radians(45)) == pytest.approx(2**0.5, rel=1e-15)
    assert [stop.symmetric for stop in STOPS] == [True, True, True, False]


MIDDLES = np.array([1.0, 1.0 + 1.0j, 1.0j, -1.0 + 1.0j, -1.0, -1.0 - 1.0j, -1.0j, 1.0 - 1.0j])
"""A square with corners in the middle of its edges, where nothing turns."""


@pytest.mark.thorough
@pytest.mark.parametrize(
    "corners",
    [KITE.corners, *(np.roll(MIDDLES, k) * unit(20.0) for k in range(3)), CircularShape()],
)
def test_a_polygon_reaches_as_far_as_its_furthest_corner_and_up_to_its_nearest_edge(corners):
    stop = corners.inscribed() if isinstance(corners, CircularShape) else PolygonShape(corners)
    corner, after = stop.corners, np.roll(stop.corners, -1)
    normal = -1j * (after - corner)
    v = np.concatenate([AROUND, corner, normal, corner + after])[:, np.newaxis] * [1.0, 0.3]
    far = np.real(np.conj(corner) * v[..., np.newaxis]).max(axis=-1)
    over = np.real(np.conj(normal) * v[..., np.newaxis]) / np.real(np.conj(normal) * corner)
    assert stop.support(v) == pytest.approx(far, rel=ROUNDING)
    assert stop.gauge(v) == pytest.approx(over.max(axis=-1), rel=ROUNDING)


def test_each_plane_for_itself_leaves_the_square_inside():
    inside = CircularShape().each_plane()
    assert inside.gauge(AROUND) == pytest.approx(2**0.5 * SquareShape().gauge(AROUND), rel=1e-14)
    assert SquareShape().each_plane().gauge(AROUND) == pytest.approx(SquareShape().gauge(AROUND))


@pytest.mark.thorough
@pytest.mark.parametrize("stop", [*STOPS, cluster([0], stop=EllipticShape(1.0, 0.5))])
def test_an_inscribed_polygon_is_never_more_than_the_shape(stop):
    around = unit(np.arange(0.0, 360.0, 13.3))
    inside, true = stop.inscribed(90).gauge(around), stop.gauge(around)
    assert np.all(inside >= true * (1.0 - ROUNDING))
    assert np.all(inside <= true * (1.0 + 4.0 * np.pi / 90))  # a corner of a stop of 4 to 1


def least_limit(places, wanted, stop_corners, dead=(), hold_roll=True):
    """The primal program: the least L for which deflections in L S have the mean that is wanted."""
    live = [k for k in range(len(places)) if k not in dead]
    count = 2 * len(live)
    cost = np.append(np.zeros(count), 1.0)
    mean = np.zeros((2, count + 1))
    roll = np.zeros((1, count + 1))
    rows = []
    edges = np.roll(stop_corners, -1) - stop_corners
    normals = -1j * edges
    heights = np.real(np.conj(normals) * stop_corners)
    for i, k in enumerate(live):
        mean[0, 2 * i] = mean[1, 2 * i + 1] = 1.0 / len(places)
        roll[0, 2 * i : 2 * i + 2] = -places[k].imag, places[k].real
        for n, h in zip(normals, heights, strict=True):
            row = np.zeros(count + 1)
            row[2 * i : 2 * i + 2], row[-1] = (n.real, n.imag), -h
            rows.append(row)
    equal = np.vstack([mean, roll]) if hold_roll else mean
    right = [wanted.real, wanted.imag, 0.0][: len(equal)]
    bounds = [(None, None)] * count + [(0, None)]
    return linprog(cost, np.array(rows), np.zeros(len(rows)), equal, right, bounds).fun


PLACES = (1.0 + 0.2j, -0.3 + 1.1j, -1.0 + 0.0j, 0.4 - 0.8j)


@pytest.mark.thorough
@pytest.mark.parametrize("dead", [(), (0,), (2, 3)])
@pytest.mark.parametrize("hold_roll", usual([True, False], 1))
def test_a_linear_program_finds_the_same_limit_with_square_stops(dead, hold_roll):
    stop = SquareShape(0.2)
    result = cluster(dead, PLACES, stop, hold_roll)
    for v in unit(np.array([10.0, 100.0, 200.0, 305.0])):
        expected = least_limit(PLACES, complex(v), stop.corners, dead, hold_roll)
        assert result.gauge(v) == pytest.approx(expected, rel=1e-8)  # HiGHS: 1e-7 feasible, vertex


@pytest.mark.thorough
@pytest.mark.parametrize("dead", [(0,), (1, 2)])
def test_linear_programs_enclose_the_limit_with_round_stops(dead):
    sides = 64
    inside = np.exp(2j * np.pi * np.arange(sides) / sides)
    for v in unit(np.array([10.0, 77.0, 205.0])):
        above = least_limit(PLACES, complex(v), inside, dead)
        result = cluster(dead, PLACES).gauge(v)
        assert above * np.cos(np.pi / sides) <= result * (1.0 + 1e-9)
        assert result <= above * (1.0 + 1e-9)


@pytest.mark.thorough
def test_clusters_with_engines_that_are_centred():
    three = cluster([0])
    result = three.gauge(unit(np.array([0.0, 45.0, 90.0])))
    assert result[[0, 2]] == pytest.approx([4 / 3, 4 / (1 + 3**0.5)], rel=1e-12)
    assert result[1] == pytest.approx(1.4047, abs=5e-5)
    assert cluster([0], hold_roll=False).gauge(AROUND) == pytest.approx(4 / 3, rel=1e-12)
    two = cluster([0, 1]).gauge(unit(np.array([0.0, 90.0, 45.0])))
    assert two == pytest.approx([8**0.5, 8**0.5, 2.0], rel=1e-12)
    square = cluster([0], stop=SquareShape()).gauge(unit(np.array([0.0, 45.0])))
    assert square == pytest.approx([4 / 3, 4 / 3 * 1.2 / 2**0.5], rel=1e-9)
    five = (*unit(np.array([45.0, 135.0, 225.0, 315.0])), 0.0)
    assert cluster([4], five).gauge(AROUND) == pytest.approx(1.25, rel=1e-12)
    result = cluster([0, 4], five).gauge(unit(np.array([0.0, 135.0])))
    assert result == pytest.approx([1.7558, 1.8301], abs=5e-5)


def test_an_engine_hard_over_the_wrong_way_takes_two():
    for n in (3, 4, 7):
        places = np.exp(2j * np.pi * np.arange(n) / n)
        stuck = cluster([0], places, hold_roll=False, state="stuck", deflection=1.0)
        assert stuck.gauge(-1.0) == pytest.approx(n / (n - 2), rel=1e-12)
        assert stuck.gauge(1.0) == pytest.approx(1.0, rel=1e-12)
        assert not stuck.symmetric


@pytest.mark.thorough
def test_a_stuck_engine_s_own_roll_moment_is_balanced_too():
    """By one engine across the axis from the stuck one: roll and side force in closed form.

    Stuck at 1 towards j with moment 1, the others (-1, j, -j) must give a moment of -1. Towards j
    the engine at -1 gives -1 for all its deflection, and then those at j and -j are equal.
    """
    stuck = cluster([0], state="stuck", deflection=1.0j)
    assert stuck.gauge(1.0j) == pytest.approx(1.0, rel=1e-12)
    assert stuck.gauge(-1.0j) > 4 / 2
    assert stuck.gauge(1.0) == pytest.approx(stuck.gauge(-1.0), rel=1e-12)


def test_thrusts_that_are_not_about_the_axis_must_be_trimmed():
    """Three engines left of four at 2 m: the mean of theirs is off by 2/3 m."""
    left = Cluster([ClusterEngine(at=at) for at in (2.0j, -2.0, -2.0j)])
    assert left.offset(23.6) == pytest.approx(-2.0 / 3.0 / 23.6, rel=1e-15)
    assert cluster([0]).offset(23.6) == pytest.approx(0.0, abs=1e-17)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: EllipticShape(1.0, 0.0), "yaw must be between 1e-06"),
        (lambda: PolygonShape([1.0, 0.1 + 0.1j, 1.0j, -1.0, -1.0j]), "convex polygon"),
        (lambda: PolygonShape([2.0, 3.0, 2.0 + 1.0j]), "has zero inside"),
        (lambda: PolygonShape(unit(np.arange(5) * 144.0)), "once around"),
        (lambda: PolygonShape([1.0, 1.0j]), "3 to 10000"),
        (lambda: SquareShape(np.inf), "rotation must be finite"),
        (lambda: CircularShape().gauge("x"), "vector must be numbers"),
        (lambda: ClusterEngine(at=1.0, deflection=0.5), 'or state "stuck"'),
        (lambda: ClusterEngine(at=1.0, state="stuck", deflection=1.1), "within the stop"),
        (lambda: Cluster([ClusterEngine(at=1.0, state="centred")]), "one of them moving"),
        (lambda: cluster([0], state="out"), "give the vehicle without its thrust"),
        (
            lambda: cluster([0], CROSS[::2], hold_roll=False, state="stuck", deflection=1.0),
            "cannot trim the stuck one",
        ),
        (
            lambda: cluster([0], (1.0, 0.0, 0.0), state="stuck", deflection=1.0j),
            "balance the roll moment",
        ),
    ],
)
def test_what_is_no_stop_is_refused_in_one_sentence(call, message):
    with pytest.raises(InputError, match=message):
        call()


@pytest.mark.thorough
@pytest.mark.parametrize("apart", usual([1e-16, 1e-13, 1e-9], 1))
def test_corners_that_nearly_coincide_or_lie_on_an_edge_hide_no_other(apart: float) -> None:
    rng, tried = np.random.default_rng(3), 0
    for _ in range(200):
        angles = np.sort(rng.uniform(0.0, 2.0 * np.pi, 7))
        corners = np.exp(1j * angles) * (1.0 + 0.5j)
        near = corners[2] + apart * np.exp(2j * np.pi * rng.uniform())
        more = np.insert(corners, 3, near)
        more = np.insert(more, 1, 0.5 * (corners[0] + corners[1]))
        try:
            stop = tv.boundary.PolygonShape(more)
        except tv.InputError:  # zero is outside, or the edge between them turns back
            continue
        tried += 1
        d = np.exp(1j * rng.uniform(0.0, 2.0 * np.pi, 50))
        reach = np.real(np.conj(d)[:, np.newaxis] * more).max(axis=-1)
        assert stop.support(d) == pytest.approx(reach, rel=1e-12)
        assert stop.gauge(stop.farthest(d)) == pytest.approx(1.0, rel=1e-9)
    assert tried > 10
