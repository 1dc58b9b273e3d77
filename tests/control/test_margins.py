"""Margins and the verdict they rest on, against brute force, argument principle and mpmath."""

from dataclasses import replace

import control
import mpmath
import numpy as np
import pytest
from scipy.special import lambertw

import tvclin as tv
from tests.margin_numbers import NUMBERS
from tests.turns import usual
from tvclin.control.margins.loop import Loop
from tvclin.control.margins.margins import loop_margins

OMEGA = np.geomspace(1e-4, 2e3, 9_000)
COURSE = [1.317 * 1.59, 1.317 * 1.88], [1, 0, -0.228]


def actuated(numerator, denominator, frequency=25.1, damping=0.7):
    lag = [1, 2 * damping * frequency, frequency**2]
    return np.multiply(numerator, frequency**2), np.polymul(denominator, lag)


def handful():
    """Return five stable loops, the last with a bending mode that crosses |L| = 1 again."""
    drift = np.polymul([0.4, 0.3], [1, 0.0284]) * 2.6, [1, 0.025, -0.28, 0.0036]
    bending = np.polymul(COURSE[0], [1.6, 0.05, 25.0]), np.polymul(COURSE[1], [1, 0.05, 25.0])
    return {
        "course": Loop(*COURSE),
        "course, delayed": Loop(*actuated(*COURSE), 0.1),
        "drift": Loop(*actuated(*drift)),
        "drift, delayed": Loop(*actuated(*drift), 0.2),
        "bending": Loop(*actuated(*bending, frequency=60.0), 0.15),
    }


LOOPS = [pytest.param(loop, id=name) for name, loop in handful().items()]


def random_loops(count, seed=0):
    """Return a batch of fixed-path and drifting vehicles, stable and unstable, with actuators."""
    rng = np.random.default_rng(seed)
    above, below = np.zeros((count, 6)), np.zeros((count, 6))
    for k in range(count):
        mu_alpha, mu_delta = rng.uniform(-0.3, 0.6), rng.uniform(0.3, 4)
        feedback = [rng.uniform(0.2, 3), rng.uniform(0.5, 6) * abs(mu_alpha)]
        if k % 2:
            numerator, denominator = feedback, np.polymul([1, 0, -mu_alpha], [0.02, 1])
        else:
            numerator = np.polymul(feedback, [1, rng.uniform(0.01, 0.08)])
            denominator = [1, rng.uniform(0.005, 0.05), -mu_alpha, rng.uniform(0, 0.01)]
        numerator, below[k] = actuated(
            np.multiply(numerator, min(1, mu_delta)),
            denominator,
            rng.uniform(3, 40),
            rng.uniform(0.3, 1.2),
        )
        above[k, 6 - len(numerator) :] = numerator
    return Loop(above, below, rng.choice([0.0, 0.02, 0.1, 0.3], count))


def parts(loop, case, omega):
    """Return numerator with delay, and denominator, of the loops `case (m,)` at `omega (m, n)`."""
    s = 1j * omega
    above, below = np.zeros_like(s), np.zeros_like(s)
    for k in range(loop.denominator.shape[-1]):
        above = above * s + loop.numerator[case, k, np.newaxis]
        below = below * s + loop.denominator[case, k, np.newaxis]
    return above * np.exp(-s * loop.delay[case, np.newaxis]), below


def zeros_between(loop, function, values):
    """Return case, frequency and L where the function changes sign, refined by subdivision."""
    case, place = np.nonzero(values[:, :-1] * values[:, 1:] < 0)
    low, high = OMEGA[place], OMEGA[place + 1]
    for _ in range(5):
        omega = np.linspace(low, high, 30, axis=-1)
        values = function(*parts(loop, case, omega))
        hit = np.argmax(values[:, :-1] * values[:, 1:] <= 0, axis=1)
        low, high = omega[np.arange(len(hit)), hit], omega[np.arange(len(hit)), hit + 1]
    omega = (low + high) / 2
    above, below = parts(loop, case, omega[:, np.newaxis])
    with np.errstate(divide="ignore", invalid="ignore"):
        return case, omega, (above / below)[:, 0]


def greatest(loop, function, values, ends):
    """Return the supremum of a function on the axis; `ends` are its values at 0 and infinity."""
    inner = values[:, 1:-1]
    summit = np.where((inner >= values[:, :-2]) & (inner > values[:, 2:]), inner, 0.0)
    case, place = np.nonzero(summit > 0.5 * summit.max(axis=1, keepdims=True))
    low, high = OMEGA[place], OMEGA[place + 2]
    result = np.maximum(ends, values.max(axis=1))
    for _ in range(5):
        omega = np.linspace(low, high, 30, axis=-1)
        heights = function(*parts(loop, case, omega))
        top = np.clip(np.argmax(heights, axis=1), 1, 28)
        low, high = omega[np.arange(len(top)), top - 1], omega[np.arange(len(top)), top + 1]
        np.maximum.at(result, case, heights.max(axis=1))
    return result


def minimum(count, case, values):
    result = np.full(count, np.inf)
    np.minimum.at(result, case, values)
    return result


def unstable_by_argument(loop, omega=OMEGA):
    """Return the number of zeros of D + N e^(-s T) in the right half plane, by its argument."""
    every = np.arange(len(loop.delay))
    omega = np.concatenate([[0.0], omega])
    values = sum(parts(loop, every, np.broadcast_to(omega, (every.size, omega.size))))
    step = np.angle(values[:, 1:] / values[:, :-1])
    case, place = np.nonzero(np.abs(step) > 0.3)
    fine = sum(parts(loop, case, np.linspace(omega[place], omega[place + 1], 300, axis=-1)))
    steps = np.angle(fine[:, 1:] / fine[:, :-1])
    assert np.abs(steps).max(initial=0.0) < 1.5  # no turn is lost between two frequencies
    step[case, place] = steps.sum(axis=1)
    count = (loop.denominator.shape[-1] - 1) / 2 - step.sum(axis=1) / np.pi
    assert np.abs(count - np.round(count)).max() < 0.1
    return np.round(count)


def brute_force(loop):
    """Return the margins of a batch on a dense grid with local subdivision."""
    count = len(loop.delay)
    if count > 100:
        chunks = [brute_force(loop.take(np.arange(k, k + 100))) for k in range(0, count, 100)]
        return {name: np.concatenate([chunk[name] for chunk in chunks]) for name in chunks[0]}
    above, below = parts(loop, np.arange(count), np.broadcast_to(OMEGA, (count, OMEGA.size)))
    n0, d0 = loop.numerator[:, -1], loop.denominator[:, -1]

    def ratio(n, d):
        return np.abs(n) - np.abs(d)

    def imaginary(n, d):
        return np.imag(n * np.conj(d))

    computed = {"unstable_poles": unstable_by_argument(loop)}
    case, omega, L = zeros_between(loop, ratio, ratio(above, below))
    phase = np.angle(-L)
    computed["phase_margin"] = minimum(count, case, np.abs(phase))
    computed["delay_margin"] = minimum(count, case, phase % (2 * np.pi) / omega)
    case, omega, L = zeros_between(loop, imaginary, imaginary(above, below))
    real = (L.real < 0) & (np.abs(L.imag) < 1e-4 * np.abs(L))  # not where L passes a pole or zero
    at_zero = np.flatnonzero(n0 * d0 < 0)
    case = np.append(case[real], at_zero)
    size = np.append(np.abs(L[real]), np.abs(n0[at_zero] / d0[at_zero]))
    computed["aero_margin"] = minimum(count, case[size > 1], size[size > 1])
    computed["gain_increase"] = minimum(count, case[size < 1], 1 / size[size < 1])
    for name, function, limit in (
        ("peak_sensitivity", lambda n, d: np.abs(d / (n + d)), 1.0),
        ("peak_complementary_sensitivity", lambda n, d: np.abs(n / (n + d)), 0.0),
        ("disk_margin", lambda n, d: np.abs((d - n) / (n + d) / 2), 0.5),
    ):
        ends = np.maximum(function(n0, d0), limit)
        computed[name] = greatest(loop, function, function(above, below), ends)
    computed["disk_margin"] = 1 / computed["disk_margin"]
    return computed


def test_the_published_course_booster():
    m = loop_margins(Loop(*COURSE))
    poles = np.roots([1, 1.317 * 1.59, 1.317 * 1.88 - 0.228])
    np.testing.assert_allclose(poles, [-1.047 + 1.073j, -1.047 - 1.073j], atol=5e-4)
    assert (m.status, m.stable, m.unstable_poles) == ("ok", True, 0)
    assert m.crossover_frequency == pytest.approx(2.262, abs=5e-4)
    assert m.phase_margin_deg == pytest.approx(62.4, abs=0.05)
    assert m.aero_margin_dB == pytest.approx(20.7, abs=0.05)
    assert m.aero_margin == pytest.approx(1.317 * 1.88 / 0.228, rel=1e-14)
    assert (m.aero_frequency, m.gain_increase) == (0.0, np.inf)


@pytest.mark.thorough
def test_a_thousand_random_loops_have_the_margins_of_brute_force():
    loop = random_loops(1000)
    computed, expected = loop_margins(loop), brute_force(loop)
    np.testing.assert_array_equal(computed.unstable_poles, expected["unstable_poles"])
    for k in np.flatnonzero(loop.delay == 0.0):
        poles = np.roots(loop.numerator[k] + loop.denominator[k])
        assert computed.unstable_poles[k] == np.sum(poles.real > 0)
    good = expected["unstable_poles"] == 0
    assert 100 < good.sum() < 950
    np.testing.assert_array_equal(computed.status, np.where(good, "ok", "unstable"))
    for name in NUMBERS:
        values = getattr(computed, name)
        assert np.all(np.isnan(values[~good]))
        np.testing.assert_allclose(values[good], expected[name][good], rtol=1e-7, err_msg=name)


@pytest.mark.parametrize("loop", LOOPS)
def test_a_loop_becomes_unstable_at_its_delay_margin(loop):
    m = loop_margins(loop)
    edge = m.delay_margin + loop.delay
    before, after = (Loop(loop.numerator, loop.denominator, edge * k) for k in (1 - 1e-9, 1 + 1e-9))
    assert loop_margins(before).status == "ok"
    assert (loop_margins(after).status, loop_margins(after).unstable_poles) == ("unstable", 2)


def test_poles_on_the_axis_without_delay_are_unstable_with_one():
    numerator, denominator = [1.317 * 1.88], [1, 0, -0.228]
    assert loop_margins(Loop(numerator, denominator)).status == "marginal"
    for delay in (1e-9, 0.01, 0.3):
        late = loop_margins(Loop(numerator, denominator, delay))
        assert (late.status, late.unstable_poles) == ("unstable", 2)


def test_poles_that_begin_on_the_axis_are_counted_whichever_way_a_delay_moves_them():
    rng = np.random.default_rng(1)
    above, below = [], []
    for _ in range(50):
        closed = np.polymul([1, 0, rng.uniform(0.3, 3) ** 2], np.poly(-rng.uniform(0.2, 6, 3)))
        above.append(np.poly(-rng.uniform(-3, 5, 2)) * rng.choice([-1, 1]) * rng.uniform(0.3, 30))
        below.append(np.polyadd(closed, -above[-1]))
    loop = Loop(above, below, rng.choice([0.1, 1.0], 50))
    expected = unstable_by_argument(loop, np.geomspace(1e-4, 2e3, 30_000))
    np.testing.assert_array_equal(loop_margins(loop).unstable_poles, expected)


def test_a_high_order_pade_has_as_many_unstable_poles():
    loop = random_loops(100, seed=4)
    computed = loop_margins(loop).unstable_poles
    late = np.flatnonzero((loop.delay > 0) & (loop.delay <= 0.1))
    assert len(late) > 40
    for k in late:
        top, bottom = control.pade(1.0, 10)
        powers = loop.delay[k] ** -np.arange(5, -1, -1.0)  # in units of the delay
        closed = np.polyadd(
            np.polymul(loop.denominator[k] * powers, bottom),
            np.polymul(loop.numerator[k] * powers, top),
        )
        assert np.sum(np.roots(closed).real > 0) == computed[k]


def test_a_delay_may_stabilise():
    """With s^2 + 1 - 0.3 (1 + 0.1 s) e^(-s T) a short delay damps what nothing else does."""
    delays = np.array([0.0, 0.05, 0.5, 2.0, 4.0, 5.0, 9.0])
    loop = Loop([-0.03, -0.3], [1, 0, 1], delays)
    margins = loop_margins(loop)
    assert margins.unstable_poles[0] == np.sum(np.roots([1, -0.03, 0.7]).real > 0) == 2
    np.testing.assert_array_equal(margins.unstable_poles, unstable_by_argument(loop))
    assert margins.status[2] == margins.status[3] == "ok"
    edge = delays[2] + margins.delay_margin[2]
    assert edge == pytest.approx(delays[3] + margins.delay_margin[3], rel=1e-12)
    after = loop_margins(Loop([-0.03, -0.3], [1, 0, 1], edge * np.array([1 - 1e-9, 1 + 1e-9])))
    assert after.status.tolist() == ["ok", "unstable"]


@pytest.mark.parametrize(
    "loop",
    [
        Loop([1], [1, 0, 1]),  # s^2 + 2
        Loop([-1], [1, 1]),  # s
        Loop([-1], [1, 1], 0.4),  # a pole at zero whatever the delay
        Loop([1], [1, 0], np.pi / 2),  # s + e^(-pi s/2) at j
        Loop([1.0, 0.228 / 1.5], [1, 0, -0.228 / 1.5]),  # the gain that just carries the moment
    ],
)
def test_loops_on_the_edge_are_marginal(loop):
    m = loop_margins(loop)
    assert (m.status, m.unstable_poles, m.stable) == ("marginal", 0, False)
    assert np.all(np.isnan([getattr(m, name) for name in NUMBERS]))
    assert "not asymptotically stable: a pole lies on the imaginary axis" in m.reason
    assert m.notes == (m.reason,)


@pytest.mark.parametrize("loop", LOOPS)
def test_mpmath_gives_the_same_to_ten_digits(loop):
    m = loop_margins(loop)
    above, below = ([mpmath.mpf(float(x)) for x in p] for p in (loop.numerator, loop.denominator))
    with mpmath.workdps(30):

        def L(w):
            s = mpmath.mpc(0, w)
            late = mpmath.exp(-s * mpmath.mpf(float(loop.delay)))
            return mpmath.polyval(above, s) / mpmath.polyval(below, s) * late

        size = np.abs(loop.response(OMEGA))
        place = np.flatnonzero((size[:-1] - 1) * (size[1:] - 1) < 0)
        gains = [
            mpmath.findroot(
                lambda w: mpmath.log(abs(L(w))), tuple(OMEGA[k : k + 2]), solver="illinois"
            )
            for k in place
        ]
        phases = [mpmath.arg(-L(w)) for w in gains]
        delays = [p % (2 * mpmath.pi) / w for p, w in zip(phases, gains, strict=True)]
        top = float(OMEGA[np.argmax(np.abs(1 / (1 + loop.response(OMEGA))))])
        peak = mpmath.findroot(
            lambda w: mpmath.diff(lambda x: mpmath.log(abs(1 + L(x))), w), (top, top * 1.001)
        )
        peak = 1 / abs(1 + L(peak))
    np.testing.assert_allclose(m.crossings.gain_frequencies, np.float64(gains), rtol=1e-10)
    np.testing.assert_allclose(m.crossings.phase_margins, np.float64(phases), rtol=1e-10)
    assert m.phase_margin == pytest.approx(float(min(abs(p) for p in phases)), rel=1e-10)
    assert m.delay_margin == pytest.approx(float(min(delays)), rel=1e-10)
    assert m.peak_sensitivity == pytest.approx(float(peak), rel=1e-10)


@pytest.mark.parametrize("excess", [1.0, 1e-2, 1e-4, 1e-6])
def test_a_crossover_far_beyond_the_poles_is_found(excess):
    """s^3 + 6 s^2 + (11 + k) s + 6 + k (6 + excess) is on the edge at k = 60/excess."""
    m = loop_margins(Loop([1, 6 + excess], np.poly([-1, -2, -3])))
    assert m.gain_increase == pytest.approx(60 / excess, rel=1e-6)
    assert m.gain_increase_frequency == pytest.approx(np.sqrt(11 + 60 / excess), rel=1e-6)


def test_an_undamped_pole_is_no_crossover():
    """There L jumps from one side of the real axis to the other, but through infinity."""
    m = loop_margins(Loop([2.0, 0.1], [1, 0, 1.0], 0.1))  # a stable vehicle without damping
    assert m.status == "ok"
    assert m.aero_margin == np.inf
    assert m.crossings.phase_frequencies[0] > 2
    exactly = loop_margins(Loop([3.0, -9.0], [1, 23, 132.25, 281.75, 1470]))  # s^2 + 12.25
    np.testing.assert_allclose(exactly.crossings.phase_frequencies, [0, np.sqrt(189)])


def test_an_undamped_zero_is_no_crossover():
    """There it jumps through zero, which no factor makes -1."""
    m = loop_margins(Loop([0.1, 0, 0.4], np.polymul([1, 2], [1, 1.1, 1.1, 0.1])))
    assert m.status == "ok"
    assert np.all(np.abs(m.crossings.phase_frequencies - 2) > 1e-3)


@pytest.mark.parametrize(
    "loop",
    usual(
        [
            # A long delay turns a slow loop many times, each time with a peak.
            Loop([0.908], [1, 1.2154, 1], 32.8),
            # The peak at 2.9 rad/s is hardly above the value at zero.
            Loop(
                [2.5657e-6, 35.52978, 5.257793],
                [0.02, 1.0930975, 4.9163915, 13.0465, -1.5513, -4.2199],
                0.02,
            ),
        ],
        1,
    ),
)
def test_of_many_peaks_the_highest_is_found(loop):
    omega = np.linspace(0, 6, 3_000_001)
    peak = np.abs(1 / (1 + loop.response(omega))).max()
    assert loop_margins(loop).peak_sensitivity == pytest.approx(peak, rel=1e-6)


def test_the_poles_of_a_loop_with_a_delay_are_exact():
    """K e^(-s T)/s has its closed poles at W(-k T)/T, all branches of Lambert's W."""
    k, late = 1.3, 0.8
    loop = Loop([k], [1.0, 0.0], late)
    computed = loop.closed_loop_poles
    branches = range(-8, 8)
    exact = np.array([lambertw(-k * late, branch) / late for branch in branches])
    exact = exact[np.argsort(-exact.real, kind="stable")][: computed.size]
    assert computed.size >= 8
    apart = np.abs(computed[:8, np.newaxis] - exact).min(axis=1)
    np.testing.assert_array_less(apart, 1e-11 * np.abs(computed[:8]))
    np.testing.assert_allclose(computed[:8].real, exact[:8].real, rtol=1e-10)


def test_poles_with_a_delay_are_those_of_a_high_pade_approximation():
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    autopilot = tv.Autopilot(
        attitude_gain=0.8, rate_gain=0.9, actuator=tv.Actuator(), delay=0.1, pade_order=10
    )
    delays = np.array([0.0, 0.1])
    both = replace(autopilot, delay=delays).exact_loop(plant).closed_loop_poles
    near = autopilot.closed_loop_poles(plant)
    for pole in both[1, :5]:
        assert np.abs(near - pole).min() < 1e-9 * np.abs(pole)
    undelayed = replace(autopilot, delay=0.0).closed_loop_poles(plant)
    mine = both[0][~np.isnan(both[0])]
    np.testing.assert_allclose(np.sort_complex(mine), np.sort_complex(undelayed), rtol=1e-9)
