"""The kernels of many flights: twins beside each other, and cases that mind nobody's business."""

import numpy as np
import pytest

import tvclin as tv
from tvclin import Actuator, Autopilot, Coefficients, Plant
from tvclin.closed_loop.fates import judging_rows
from tvclin.closed_loop.gusts import polynomial_pieces
from tvclin.closed_loop.step_matrices import exponentials
from tvclin.kernels import flight_table as table
from tvclin.kernels.choice import available, pinned
from tvclin.kernels.series import Series, exits, lengths
from tvclin.recoverable import unstable_coordinates

VEHICLE = tv.load_vehicle("configuration-i")
PEAK = 0.08
SERVO = Actuator(natural_frequency=20.0)
EACH_TWIN = pytest.mark.parametrize(
    "compiled",
    [False, pytest.param(True, marks=pytest.mark.skipif(not available(), reason="needs numba"))],
)
KINDS = [
    ("gains", {"actuator": SERVO, "rate_limit": 0.01}),
    ("gains", {"sample_rate": 50.0, "actuator": SERVO, "rate_limit": 0.01}),
    ("dead band", {}),
    ("lean", {"actuator": SERVO}),
    ("lean", {"sample_rate": 50.0}),
]
EACH_KIND = pytest.mark.parametrize(("name", "options"), KINDS)


def case(name, size, model="drift-exact"):
    """Return plants, a law of the nominal plant, winds and limits of a dispersed batch."""
    rng = np.random.default_rng(11)
    factors = rng.uniform(0.95, 1.05, (3, size))
    vehicle = VEHICLE.replace(
        thrust=VEHICLE.thrust * factors[0], aerodynamic_arm=VEHICLE.aerodynamic_arm * factors[1]
    )
    nominal = Plant.from_vehicle(VEHICLE, model)
    B, beta = float(nominal.coefficients.B), float(nominal.coefficients.beta)
    law = {
        "gains": tv.SaturatedLaw(Autopilot(attitude_gain=3 * B, rate_gain=3 * B / beta)),
        "dead band": tv.DeadBandLaw(nominal),
        "lean": tv.RecoverableAttitudeLaw(nominal, design_peak=PEAK),
    }[name]
    angle = PEAK * rng.uniform(-0.2, 1.0, (size, 9))
    wind = tv.SampledWind(time=np.linspace(0.3, 9.1, 9), angle=angle)
    limit = B * PEAK * rng.uniform(0.3, 1.2, size)
    return Plant.from_vehicle(vehicle, model), law, wind, limit


def fields(flown):
    return np.stack([np.asarray(v) for k, v in vars(flown).items() if k != "status"])


def part(case, index):
    """Return some of a batch."""
    plant, law, wind, limit = case
    numbers = {
        name: np.broadcast_to(getattr(plant.coefficients, name), limit.shape)[index]
        for name in ("mu_alpha", "mu_delta", "C1", "C2", "b1", "b2", "q")
    }
    angle = wind.angle[index]
    plant = Plant.from_coefficients(Coefficients(**numbers), plant.model)
    return plant, law, tv.SampledWind(time=wind.time, angle=angle), limit[index]


def flown(case, **options):
    plant, law, wind, limit = case
    return tv.fly_many(plant, law, wind, deflection_limit=limit, **options)


@EACH_KIND
def test_twins_agree(name, options):
    pytest.importorskip("numba")
    every = case(name, 70)
    with pinned(False):
        slow = flown(every, **options)
    with pinned(True):
        fast = flown(every, **options)
    assert set(slow.status) >= {"survived", "lost"}
    np.testing.assert_array_equal(slow.status, fast.status)
    np.testing.assert_allclose(fields(fast), fields(slow), rtol=1e-8, atol=1e-9)


@EACH_TWIN
@EACH_KIND
def test_a_case_does_not_depend_on_its_batch(name, options, compiled):
    every = case(name, 70)
    order = np.random.default_rng(3).permutation(70)
    until = 12.0 if compiled or name != "lean" else 2.0
    with pinned(compiled):
        whole = flown(every, until=until, **options)
        mixed = flown(part(every, order), until=until, **options)
        few = flown(part(every, np.array([66, 2, 30])), until=until, **options)
    np.testing.assert_array_equal(fields(mixed), fields(whole)[:, order])
    np.testing.assert_array_equal(fields(few), fields(whole)[:, [66, 2, 30]])


@EACH_TWIN
@pytest.mark.parametrize("off", [0.0, 1e-16, -1e-16])
def test_a_flight_that_turns_away_from_its_limit_leaves_when_it_comes_back(off, compiled):
    """Rounding puts the start on either side of the limit; left at once, it would stay for ever."""
    powers, step = np.array([1.0 + off, -1.0, 3.0]), 1.0
    if compiled:
        from tvclin.kernels.compiled import arc_events, lanes

        s, w = np.zeros(lanes.SERIES_SIZE), np.zeros(lanes.SIZE)
        for k, c in enumerate(powers):
            s[lanes.at(lanes.SERVO, k)] = c
        w[lanes.row(lanes.STEP)] = step
        w[lanes.row(lanes.VALUE + lanes.SERVO)] = powers.sum()
        w[lanes.row(lanes.SLOPE + lanes.SERVO)] = powers[1] + 2.0 * powers[2]
        when, side = arc_events._exit(s, w, lanes.SERVO, np.uint64(0), -1.0, 1.0, 2)
    else:
        c = np.zeros((table.ORDER + 1, 1))
        c[:3, 0] = powers
        one = np.ones(1)
        (when,), (side,) = exits(c, step * one, -one, one)
    assert side == 1.0
    assert when == pytest.approx(1.0 / 3.0, rel=1e-9)


@pytest.mark.parametrize("attitude", [0.0, 0.3])
def test_a_step_is_as_long_as_the_accuracy_allows_however_large_the_attitude(attitude):
    rows, y = np.zeros((table.ROWS, 2)), np.zeros((7, 12, 2))
    rows[table.SCALE], rows[table.SERVO_SCALE] = 1.0 / 0.1, 1.0 / 0.02
    rows[table.ACCURACY] = 1e-8, 1e-11
    y[0, 0], y[0, 1:] = attitude, 0.01
    none = np.zeros((12, 2))
    long, short = lengths(rows, Series(y, none, none, none), np.full(2, 0.2))
    assert long / short == pytest.approx(1e3 ** (1 / 11), rel=0.12)


def test_threads_change_nothing(monkeypatch):
    pytest.importorskip("numba")
    every = case("gains", 900)
    found = []
    for threads in ("1", "2"):
        monkeypatch.setenv("TVCLIN_NUM_THREADS", threads)
        with pinned(True):
            found.append(fields(flown(every, sample_rate=50.0)))
    np.testing.assert_array_equal(*found)


@pytest.mark.parametrize("model", ["fixed-path", "drift", "drift-exact"])
def test_the_rows_that_judge_are_the_unstable_coordinates(model):
    plant = Plant.from_vehicle(VEHICLE, model)
    modes, rows = unstable_coordinates(plant), judging_rows(plant)
    n, N = modes.rows.shape[1], modes.poles.size
    np.testing.assert_allclose(rows[:n], modes.rows[0], rtol=1e-9, atol=1e-12)
    if N > 1:
        np.testing.assert_allclose(rows[4 : 4 + n], modes.rows[1], rtol=1e-9, atol=1e-12)
    assert rows[9] == pytest.approx(modes.ratio, rel=1e-12)


def test_a_plant_with_a_pair_or_without_an_unstable_pole_is_not_judged():
    pair = Plant.from_vehicle(VEHICLE, "drift-and-speed")
    assert np.isnan(judging_rows(pair)[8])
    mixed = Plant.from_coefficients(Coefficients(mu_alpha=np.array([0.2, -0.2]), mu_delta=1.0))
    np.testing.assert_array_equal(np.isnan(judging_rows(mixed)[8]), [False, True])


def test_exponentials_of_a_batch_are_scipys():
    from scipy.linalg import expm

    matrices = np.random.default_rng(1).normal(size=(6, 5, 5)) * 3
    np.testing.assert_allclose(exponentials(matrices, 0.7), expm(0.7 * matrices), rtol=1e-11)


@pytest.mark.parametrize(
    "wind",
    [
        tv.OneMinusCosineGust(peak=np.array([0.05, -0.1]), duration=np.array([3.0, 8.0])),
        tv.LayeredGust(peak=0.05, blend=2.0, plateau=3.0),
        tv.TriangularWind(peak=0.1, duration=3.0),
    ],
)
def test_polynomial_pieces_are_the_wind(wind):
    knots, c = polynomial_pieces(wind)
    for k, (row, pieces) in enumerate(zip(knots, c, strict=True)):
        times = np.linspace(row[0], row[-1], 500)
        index = np.searchsorted(row, times, side="right") - 1
        u = times - row[index]
        found = sum(pieces[index, j] * u**j for j in range(c.shape[-1]))
        expected = np.atleast_2d(wind(times))[k]
        np.testing.assert_allclose(found, expected, atol=1e-11 * np.abs(expected).max())
