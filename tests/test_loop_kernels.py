"""The twins of the kernels of margins: one beside the other, and both beside other arithmetic."""

from dataclasses import fields
from importlib import import_module

import control
import mpmath
import numpy as np
import pytest

from tests.test_margins import NUMBERS, actuated, brute_force, random_loops
from tvclin.kernels.choice import pinned
from tvclin.margins import Crossings, Loop, loop_margins

FREQUENCIES = [
    "aero_frequency",
    "gain_increase_frequency",
    "crossover_frequency",
    "delay_margin_frequency",
]


def both(loop):
    """Return what numpy and the compiled twin find."""
    pytest.importorskip("numba")
    with pinned(False):
        plain = loop_margins(loop)
    with pinned(True):
        return plain, loop_margins(loop)


def assert_same(plain, compiled, rounding=1e-12):
    """Hold the twins together; an undamped mode magnifies the rounding of a frequency."""
    np.testing.assert_array_equal(compiled.status, plain.status)
    np.testing.assert_array_equal(compiled.unstable_poles, plain.unstable_poles)
    for field in fields(Crossings):
        expected, found = (getattr(m.crossings, field.name) for m in (plain, compiled))
        exact = 1e-12 if "frequencies" in field.name else rounding
        slack = 0.0 if "frequencies" in field.name else rounding
        np.testing.assert_allclose(found, expected, rtol=exact, atol=slack, err_msg=field.name)
    for name in [*NUMBERS, *FREQUENCIES]:
        exact = 1e-9 if "disk" in name or "peak" in name else rounding
        expected, found = getattr(plain, name), getattr(compiled, name)
        np.testing.assert_allclose(found, expected, rtol=exact, atol=rounding, err_msg=name)


@pytest.mark.parametrize("seed", range(3))
def test_twins_agree_on_random_loops(seed):
    plain, compiled = both(random_loops(400, seed=10 + seed))
    assert {"ok", "unstable"} <= set(plain.status)
    assert_same(plain, compiled)


def integrating(count, seed):
    """Return loops of order 6 with a pole at the origin, numerator times (s + 1/10)/s."""
    loop = random_loops(count, seed)
    above = np.pad(loop.numerator[:, 1:], [(0, 0), (0, 1)])
    above += 0.1 * loop.numerator
    above = np.pad(above, [(0, 0), (1, 0)])
    return Loop(above, np.pad(loop.denominator, [(0, 0), (0, 1)]), loop.delay)


def bending(count, seed):
    """Return loops of order 6 with a bending mode beside a zero, some without any damping."""
    rng = np.random.default_rng(seed)
    above, below = np.zeros((count, 7)), np.zeros((count, 7))
    for k in range(count):
        square, rub = rng.uniform(3.0, 15.0) ** 2, rng.choice([0.0, 1e-4, 1e-2, 0.3])
        feedback = [rng.uniform(0.2, 2.0), rng.uniform(0.5, 3.0)]
        plant = np.polymul([1, 0, rng.uniform(-0.6, 0.6)], [1, rub, square])
        top, below[k] = actuated(np.polymul(feedback, [1.1, 0.01, square]), plant)
        above[k, 7 - len(top) :] = top
    return Loop(above, below, rng.choice([0.0, 0.02, 0.2], count))


@pytest.mark.parametrize(("family", "rounding"), [(integrating, 1e-12), (bending, 1e-9)])
def test_twins_agree_on_loops_with_integrators_and_bending_modes(family, rounding):
    plain, compiled = both(family(300, seed=5))
    assert np.sum(plain.status == "ok") > 20
    assert_same(plain, compiled, rounding)


def test_twins_agree_on_loops_of_the_first_order_and_without_crossings():
    assert_same(*both(Loop([[1.0], [-0.5], [-2.0], [3.0]], [1.0, 1.0], [0.0, 0.3, 0.3, 1.0])))
    assert_same(*both(Loop([0.1], [1.0, 3.0, 2.0], [0.0, 0.01, 100.0])))


def test_a_pole_or_zero_on_the_axis_is_no_crossing_of_a_delayed_loop():
    """Beside it the phase turns back twice, within rounding."""
    above = [[2.5, 0, 168.0], [1.2, 0, 88.56], [3.0, 0, 146.4], [2.4, 0, 65.52]]
    below = [
        [1, 5.3, 88.7, 470.11, 113.62, 602.186],
        [1, 7.8, 103.7, 754.82, 748.02, 652.12],
        [1, 6.1, 63.9, 389.79, 31.7, 193.37],
        [1, 9.6, 45.1, 349.4, 340.8, 305.3],
    ]
    loop = Loop(np.pad(above, [(0, 0), (3, 0)]), below, [0.2, 0.5, 0.2, 0.2])
    for found in both(loop):
        factors = found.crossings.gain_factors
        assert np.all((factors > 1e-6) & (factors < 1e7) | np.isnan(factors))


def test_what_is_marginal_is_so_for_both():
    edge = Loop([[0, 1.0], [0.5, 0.0]], [[1.0, 0.0, 1.0], [1.0, -0.5, 4.0]], 0.0)
    for found in both(edge):
        assert found.status.tolist() == ["marginal", "marginal"]


def test_a_loop_has_the_same_margins_alone_and_anywhere_in_a_batch():
    loop = random_loops(150, seed=8)
    _, whole = both(loop)
    with pinned(True):
        for case in (0, 63, 64, 149):
            alone = loop_margins(loop.take(case))
            for name in NUMBERS:
                np.testing.assert_array_equal(getattr(alone, name), getattr(whole, name)[case])


def test_slices_over_threads_change_nothing(monkeypatch):
    loop = random_loops(300, seed=9)
    _, whole = both(loop)
    monkeypatch.setattr("tvclin.kernels.threads._WORTH", 1e-9)
    _, sliced = both(loop)
    for name in NUMBERS:
        np.testing.assert_array_equal(getattr(sliced, name), getattr(whole, name))


@pytest.mark.parametrize("compiled", [False, True])
def test_python_control_finds_the_same_crossings(compiled):
    if compiled:
        pytest.importorskip("numba")
    drawn = random_loops(60, seed=2)
    loop = Loop(drawn.numerator, drawn.denominator)
    with pinned(compiled):
        m = loop_margins(loop)
    for k in np.flatnonzero(m.status == "ok"):
        system = control.tf(loop.numerator[k], loop.denominator[k])
        factors, phases, _, at, where, _ = control.stability_margins(system, returnall=True)
        gains, lags = m.crossings.gain_frequencies[k], m.crossings.phase_margins[k]
        there = np.isfinite(gains)
        np.testing.assert_allclose(gains[there], where, rtol=1e-9)
        left = np.degrees(lags[there]) - phases
        np.testing.assert_allclose(left - 360.0 * np.round(left / 360.0), 0.0, atol=1e-6)
        places, found = m.crossings.phase_frequencies[k], m.crossings.gain_factors[k]
        there, true = places > 0.0, (at > 0.0) & (factors > 1e-9)  # it counts undamped poles too
        np.testing.assert_allclose(places[there], at[true], rtol=1e-7)
        np.testing.assert_allclose(found[there], factors[true], rtol=1e-6)


def test_the_compiled_twin_has_the_margins_of_brute_force():
    pytest.importorskip("numba")
    loop = random_loops(200, seed=6)
    with pinned(True):
        found = loop_margins(loop)
    expected = brute_force(loop)
    np.testing.assert_array_equal(found.unstable_poles, expected["unstable_poles"])
    good = expected["unstable_poles"] == 0
    for name in NUMBERS:
        values = getattr(found, name)[good]
        np.testing.assert_allclose(values, expected[name][good], rtol=1e-7, err_msg=name)


@pytest.mark.parametrize("compiled", [False, True])
def test_crossovers_beside_an_undamped_mode_are_exact(compiled):
    """There |N|^2 - |D|^2 has two roots that agree in five digits."""
    if compiled:
        pytest.importorskip("numba")
    above, below = [1e-4, 3e-4], np.polymul([1.0, 0.0, 90.25], [1.0, 1.0])
    with pinned(compiled):
        found = loop_margins(Loop([above], [below])).crossings.gain_frequencies[0]
    assert found.shape == (2,)
    with mpmath.workdps(40):

        def level(omega):
            top, bottom = (mpmath.polyval(p, mpmath.mpc(0, omega)) for p in exactly)
            return mpmath.log(abs(top / bottom))

        exactly = [[mpmath.mpf(float(c)) for c in p] for p in (above, below)]
        for omega in found:
            exact = mpmath.findroot(level, (omega * (1 - 1e-9), omega * (1 + 1e-9)))
            assert omega == pytest.approx(float(exact), rel=1e-14)


def test_positive_roots_are_those_the_polynomials_were_made_of():
    kernel = pytest.importorskip("numba") and import_module(
        "tvclin.kernels.compiled.positive_roots"
    )
    rng, p, expected = np.random.default_rng(0), np.zeros((500, kernel.SIZE)), []
    for row in p:
        real = rng.choice([-1, 1], rng.integers(1, 6)) * 10.0 ** rng.uniform(-4, 3)
        real = real * rng.uniform(0.5, 2.0, real.size)
        pair = 10.0 ** rng.uniform(-2, 2) * np.exp(1j * rng.uniform(0, np.pi))
        terms = rng.choice([-1, 1]) * np.real(np.poly([*real, pair, np.conj(pair)]))
        row[: terms.size] = terms[::-1]
        expected.append(np.sort(real[real > 0.0]))
    roots, counts = np.zeros_like(p), np.zeros(len(p), dtype=np.intp)
    kernel.positive_roots(p, len(p), kernel.searches(len(p)), roots, counts)
    for found, count, true in zip(roots, counts, expected, strict=True):
        np.testing.assert_allclose(found[:count], true, rtol=1e-6)


def test_routh_counts_what_the_roots_say_or_is_unsure():
    stability = pytest.importorskip("numba") and import_module("tvclin.kernels.compiled.stability")
    rng, sure = np.random.default_rng(1), 0
    for degree in np.repeat(np.arange(1, 9), 50):
        roots = rng.uniform(-3, 1, degree)
        found = stability.unstable_roots(np.poly(roots)[::-1].copy(), degree, np.zeros((4, 32)))
        assert found in (np.sum(roots > 0), stability.UNSURE)
        sure += found != stability.UNSURE
    assert sure > 380
    for axis in ([1.0, 2.0, 1.0, 2.0], [1.0, 1.0, 0.0], [1.0, 3.0, 3.0 + 1e-9, 9.0]):
        p = np.array(axis[::-1])
        assert stability.unstable_roots(p, len(p) - 1, np.zeros((4, 32))) == stability.UNSURE


def test_loops_of_higher_order_than_the_compiled_twin_trusts_have_margins():
    above, below = [1.0], np.poly(-np.linspace(0.5, 4.0, 14))
    plain, compiled = both(Loop([above], [below / below[-1]]))
    assert plain.status.tolist() == ["ok"]
    assert_same(plain, compiled)
