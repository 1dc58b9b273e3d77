"""The ringing of nozzles: modes beside scipy's, and flights from which it is taken out."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eig

import tvclin as tv
from tvclin.kernels import arcs
from tvclin.kernels import flight_table as table
from tvclin.kernels.choice import available, pinned
from tvclin.kernels.ringing import CALM, FELT, INVERSE, LEFT, RIGHT, ringings

EACH_TWIN = pytest.mark.parametrize(
    "compiled",
    [False, pytest.param(True, marks=pytest.mark.skipif(not available(), reason="needs numba"))],
)
PLANT = tv.Plant(tv.Coefficients.from_beta(beta=0.53, B=0.107))
BETA, B, PEAK = 0.53, 0.107, 0.08


def rows(count):
    """Return the rows of plants, nozzles and laws of every kind."""
    rng = np.random.default_rng(5)
    found = np.zeros((table.ROWS, count))
    found[: table.STIFFNESS] = rng.uniform(-0.3, 0.3, (table.STIFFNESS, count))
    found[table.MOMENT] = rng.uniform(-5.0, -1.0, count)
    omega, damping = rng.uniform(15.0, 40.0, count), rng.uniform(0.4, 0.9, count)
    found[table.STIFFNESS], found[table.DRAG] = omega**2, 2.0 * damping * omega
    found[table.K_ATTITUDE : table.K_MEMORY + 1] = rng.uniform(0.0, 0.8, (5, count))
    found[table.LIMIT], found[table.SCALE], found[table.ACCURACY] = 0.1, 10.0, 1e-8
    return found


def loop(r):
    """Return the loop of one column, and what a gust drives: attitude first, memory last."""
    A, gust = np.zeros((7, 7)), np.zeros(7)
    A[0, 1] = A[4, 5] = A[6, 0] = 1.0
    A[1, [0, 2, 4]] = r[[table.MU, table.MU_PATH, table.MOMENT]]
    path = [table.PATH_ATTITUDE, table.PATH_PATH, table.PATH_SPEED, table.PATH_DEFLECTION]
    A[2, [0, 2, 3, 4]], A[3, 2] = r[path], r[table.SPEED_PATH]
    k = r[table.K_ALPHA]
    asked = [r[table.K_ATTITUDE] + k, r[table.K_RATE], r[table.K_PATH] - k, r[table.K_MEMORY]]
    A[5, [0, 1, 2, 6]] = r[table.STIFFNESS] * np.array(asked)
    A[5, [4, 5]] = -r[table.STIFFNESS], -r[table.DRAG]
    gust[[1, 2, 5]] = r[table.GUST], r[table.PATH_GUST], -r[table.STIFFNESS] * k
    return A, gust


def test_ringing_is_a_pair_of_modes_of_plant_nozzle_and_law():
    every = rows(200)
    found = ringings(every)
    assert np.mean(found[CALM].real > 0.0) > 0.95
    for r, own in zip(every.T, found.T, strict=True):
        A, gust = loop(r)
        values, left, right = eig(A, left=True)
        pole = 1.0 / own[INVERSE]
        if own[CALM].real == 0.0:
            continue
        k = np.argmin(abs(values - pole))
        assert values[k] == pytest.approx(pole, rel=1e-8)
        mode = right[:, k] / right[4, k]
        np.testing.assert_allclose(own[RIGHT:CALM], mode, rtol=1e-7, atol=1e-9)
        row = left[:, k].conj() / (left[:, k].conj() @ mode)
        np.testing.assert_allclose(own[LEFT:RIGHT], row, rtol=1e-7, atol=1e-9)
        assert own[FELT] == pytest.approx(row @ gust / pole, rel=1e-6, abs=1e-12)


def test_a_pair_that_grows_is_never_left_out():
    every = rows(50)
    every[table.K_RATE] = -200.0 / every[table.MOMENT]
    found = ringings(every)
    grows = found[INVERSE].real > 0.0
    assert np.sum(grows) > 10
    np.testing.assert_array_equal(found[CALM, grows], 0.0)


def test_a_nozzle_without_a_swing_of_its_own_is_left_alone():
    every = rows(50)
    every[table.DRAG] = 3.0 * np.sqrt(every[table.STIFFNESS])
    np.testing.assert_array_equal(ringings(every)[CALM], 0.0)


def flown(compiled, frequency, *, gain=3.0, until=20.0):
    law = tv.SaturatedLaw(tv.Autopilot(attitude_gain=gain * B, rate_gain=gain * B / BETA))
    wind = tv.TriangularWind(peak=PEAK * np.array([0.6, 1.0]), duration=8.0)
    servo = tv.Actuator(natural_frequency=frequency, damping=0.7)
    with pinned(compiled):
        return tv.fly_many(
            PLANT, law, wind, deflection_limit=1.2 * B * PEAK, actuator=servo, until=until
        )


def integrated(frequency, peak, *, gain=3.0, until=20.0):
    """Return last and largest attitude, by a solver that knows of limits only their values."""
    c, limit = PLANT.coefficients, 1.2 * B * PEAK

    def rates(t, y):
        wind = max(0.0, peak * (1.0 - abs(t / 4.0 - 1.0)))
        asked = gain * B * (y[0] + y[1] / BETA)
        pull = frequency**2 * (min(max(asked, -limit), limit) - y[2]) - 1.4 * frequency * y[3]
        deflection = min(max(y[2], -limit), limit)
        return [y[1], c.mu_alpha * (y[0] - wind) - c.mu_delta * deflection, y[3], pull]

    options = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-14, "max_step": 0.01}
    found = solve_ivp(rates, (0.0, until), np.zeros(4), events=lambda t, y: y[1], **options)
    return found.y[0, -1], np.abs(found.y_events[0][:, 0]).max()


@EACH_TWIN
@pytest.mark.parametrize("frequency", [25.0, 100.0])
def test_flights_are_those_of_a_solver(compiled, frequency):
    found = flown(compiled, frequency)
    for k, part in enumerate((0.6, 1.0)):
        last, peak = integrated(frequency, part * PEAK)
        assert found.final_attitude[k] == pytest.approx(last, abs=2e-8 * peak)
        assert found.peak_attitude[k] == pytest.approx(peak, rel=2e-8)


@EACH_TWIN
def test_ringing_that_lasts_is_flown(compiled):
    """A slow nozzle under a large gain swings for long together with the loop."""
    found = flown(compiled, 6.0, gain=5.0, until=12.0)
    for k, part in enumerate((0.6, 1.0)):
        last, peak = integrated(6.0, part * PEAK, gain=5.0, until=12.0)
        assert found.final_attitude[k] == pytest.approx(last, abs=2e-8 * peak)


def test_steps_do_not_stay_as_short_as_the_nozzle_is_swift(monkeypatch):
    steps = 0
    stepped = arcs._stepped

    def counted(flights, state):
        nonlocal steps
        steps += 1
        return stepped(flights, state)

    monkeypatch.setattr(arcs, "_stepped", counted)
    flown(False, 100.0, until=60.0)
    longest = 5.6 / 100.0  # of a Taylor series of order 11 that is stable for this nozzle
    assert steps < 60.0 / longest / 4.0
