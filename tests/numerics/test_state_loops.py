"""Loops in state space beside polynomials, thirty digits, python-control, and brute force."""

from dataclasses import fields

import control
import mpmath
import numpy as np
import pytest

import tvclin as tv
from tvclin.control.margins.margins import Margins
from tvclin.numerics import state_space
from tvclin.numerics.loop_margins import analyse_loops

EPS = np.finfo(float).eps
NUMBERS = [field.name for field in fields(Margins)][2:-2]


def section(above, below):
    """Return a section of first or second order in controllable form."""
    n = len(below) - 1
    above = np.concatenate([np.zeros(n + 1 - len(above)), above]) / below[0]
    below = np.asarray(below) / below[0]
    A = np.eye(n, k=1)
    A[-1] = -below[:0:-1]
    C = (above[1:] - above[0] * below[1:])[::-1]
    return A, np.eye(n)[:, -1:], C[np.newaxis], above[:1, np.newaxis]


def flexible(rng, modes, damping=(1e-3, 1e-1)):
    """Return sections of a loop of order 4 + 2 modes: rigid body, actuator, poles beside zeros."""
    rigid = [rng.uniform(0.5, 3.0), rng.uniform(0.5, 3.0)], [1.0, 0.0, -rng.uniform(0.05, 0.5)]
    computed = [rigid, ([400.0], [1.0, 28.0, 400.0])]
    for _ in range(modes):
        pole = rng.uniform(3.0, 70.0)
        zero = pole * rng.uniform(0.8, 1.2)
        rub = 2.0 * np.exp(rng.uniform(*np.log(damping), 2))
        computed.append(([1.0, rub[0] * zero, zero**2], [1.0, rub[1] * pole, pole**2]))
    return computed


def cascade(sections):
    """Return A, B, C and D of the sections behind each other."""
    whole = section(*sections[0])
    for one in sections[1:]:
        whole = state_space.series(whole, section(*one))
    return whole


def exact(sections, delay, omega):
    """Return L and d ln L/d omega at j omega in many digits."""
    s, value, slope = mpmath.mpc(0, omega), mpmath.mpf(1), -mpmath.mpf(delay)
    for above, below in sections:
        (n, dn), (d, dd) = (
            mpmath.polyval([mpmath.mpf(float(c)) for c in p], s, derivative=1)
            for p in (above, below)
        )
        value, slope = value * n / d, slope + dn / n - dd / d
    return value * mpmath.exp(-s * mpmath.mpf(delay)), 1j * slope


def error_of(loop, omega, rise):
    """Return what L may lack over its size, of x = (j omega - A)^-1 B that is solved for.

    Elimination meets the equations of a matrix whose entries lack n roundings each (Wilkinson), and
    L = C x feels them by |C (j omega - A)^-1| |j omega - A| |x|. With the frequency, and with its
    product with the delay, L moves by the slope of its logarithm.
    """
    form = loop.form
    A, B, C = form.A[0], form.B[0], form.C[0]
    M = 1j * omega * np.eye(len(A)) - A
    x, y = np.linalg.solve(M, B), np.linalg.solve(M.T, C)
    solved = len(A) * np.abs(y) @ np.abs(M) @ np.abs(x) / abs(C @ x + form.D[0])
    return EPS * (solved + omega * (float(abs(rise)) + form.all_delays[0]))


@pytest.mark.thorough
@pytest.mark.parametrize("modes", [0, 1, 4, 8, 13])
@pytest.mark.parametrize("delay", [0.0, 0.04])
def test_every_crossing_is_that_of_thirty_digits(modes, delay):
    rng = np.random.default_rng(modes + 1)
    for _ in range(3):
        sections = flexible(rng, modes)
        loop = tv.Loop.from_matrices(*cascade(sections), delay)
        assert loop.poles.size == 4 + 2 * modes
        c = tv.control.loop_margins(loop).crossings
        assert c.gain_frequencies.size > 0
        with mpmath.workdps(30):
            for omega, phase in zip(c.gain_frequencies, c.phase_margins, strict=True):
                value, rise = exact(sections, delay, omega)
                error = error_of(loop, omega, rise)
                # Newton's steps end at 1e-13 of the frequency
                assert abs(mpmath.log(abs(value))) <= error + 1e-13 * omega * abs(mpmath.re(rise))
                assert abs(float(mpmath.arg(-value)) - phase) <= error
            for omega, factor in zip(c.phase_frequencies, c.gain_factors, strict=True):
                if omega == 0.0:
                    continue
                value, rise = exact(sections, delay, omega)
                error = error_of(loop, omega, rise)
                assert abs(float(mpmath.arg(-value))) <= error
                assert float(abs(value)) * factor == pytest.approx(1.0, rel=error)


@pytest.mark.parametrize("delay", [0.0, 0.05])
@pytest.mark.parametrize("modes", [0, 1, 3])
def test_polynomials_and_state_space_have_the_same_margins(modes, delay):
    rng = np.random.default_rng(11 + modes)
    for _ in range(8):
        sections = flexible(rng, modes, damping=(5e-3, 0.2))
        above, below = np.ones(1), np.ones(1)
        for n, d in sections:
            above, below = np.polymul(above, n), np.polymul(below, d)
        one, other = (
            tv.control.loop_margins(loop)
            for loop in (
                tv.Loop(above, below, delay),
                tv.Loop.from_matrices(*cascade(sections), delay),
            )
        )
        assert one.status == other.status
        assert one.unstable_poles == other.unstable_poles
        for name in NUMBERS:
            flat = 1e-5 if "disk_f" in name or "sensitivity_f" in name else 1e-8  # tops are flat
            expected = pytest.approx(getattr(one, name), rel=flat, nan_ok=True)
            assert getattr(other, name) == expected, name


def test_poles_and_responses_are_those_of_python_control():
    rng = np.random.default_rng(5)
    for modes in (1, 5, 11):
        system = control.ss(*cascade(flexible(rng, modes)))
        loop = tv.Loop.from_system(system)
        closed = np.sort_complex(control.feedback(system, 1).poles())
        size = np.abs(closed).max()
        np.testing.assert_allclose(
            np.sort_complex(loop.form.closed_poles()[0]), closed, rtol=0, atol=1e-10 * size
        )
        omega = np.geomspace(0.01, 300.0, 60)
        expected = system(1j * omega)
        np.testing.assert_allclose(loop.response(omega), expected, rtol=1e-9, atol=1e-13)
        unstable = int(np.sum(closed.real > 0.0))
        assert tv.control.loop_margins(loop).unstable_poles == unstable


@pytest.mark.thorough
@pytest.mark.parametrize("delay", [0.0, 0.03])
def test_no_crossing_of_a_fine_grid_is_missed(delay):
    rng = np.random.default_rng(17)
    for modes in (2, 6, 12):
        sections = flexible(rng, modes)
        loop = tv.Loop.from_matrices(*cascade(sections), delay)
        omega = np.unique(
            np.concatenate(
                [np.geomspace(1e-3, 200.0, 40_000)]
                + [p.imag + abs(p.real) * np.linspace(-20, 20, 801) for p in loop.poles]
            )
        )
        omega = omega[(omega > 1e-3) & (omega < 200.0)]
        values = loop.response(omega)
        c = tv.control.loop_margins(loop).crossings
        size = np.sign(np.abs(values) - 1.0)
        gains = np.sum(size[1:] != size[:-1])
        assert np.sum((c.gain_frequencies > 1e-3) & (c.gain_frequencies < 200.0)) == gains
        side = np.sign(values.imag)
        real = 0.5 * (values.real[1:] + values.real[:-1])
        phases = np.sum((side[1:] != side[:-1]) & (real < 0.0))
        assert np.sum((c.phase_frequencies > 1e-3) & (c.phase_frequencies < 200.0)) == phases


@pytest.mark.thorough
@pytest.mark.parametrize("delay", [0.0, 0.02])
def test_the_peak_behind_the_disk_margin_is_that_of_a_fine_grid(delay):
    rng = np.random.default_rng(23)
    stable = 0
    for _ in range(12):
        loop = tv.Loop.from_matrices(*cascade(flexible(rng, 3, damping=(5e-3, 0.1))), delay)
        m = tv.control.loop_margins(loop)
        if not m.stable:
            continue
        stable += 1
        for omega in (
            np.geomspace(1e-3, 1e3, 20_000),
            m.disk_frequency * (1 + 1e-6 * np.arange(-9, 10)),
        ):
            L = loop.response(omega)
            highest = np.abs(0.5 * (1.0 - L) / (1.0 + L)).max()
            assert highest <= (1.0 + 1e-10) / m.disk_margin
        assert highest == pytest.approx(1.0 / m.disk_margin, rel=1e-9)
    assert stable > 2


@pytest.mark.thorough
def test_the_disk_margin_is_that_of_slycot():
    slycot = pytest.importorskip("slycot")
    rng = np.random.default_rng(29)
    stable = 0
    for _ in range(10):
        A, B, C, D = cascade(flexible(rng, 3, damping=(5e-3, 0.1)))
        m = tv.control.loop_margins(tv.Loop.from_matrices(A, B, C, D))
        if not m.stable:
            continue
        stable += 1
        # (S - T)/2 = 1/2 - L/(1 + L) of the closed loop A - B C
        n, one = len(A), np.full((1, 1), 0.5)
        norm = slycot.ab13dd("C", "I", "N", "D", n, 1, 1, A - B @ C, np.eye(n), B, -C, one, 1e-12)[
            0
        ]
        assert m.disk_margin == pytest.approx(1.0 / norm, rel=1e-8)
    assert stable > 1


SPECIAL = {
    "integrator": ([0.5, 0.1], [1.0, 1.0, 0.0]),
    "double integrator": ([1.0, 0.3], [0.1, 1.0, 0.0, 0.0]),
    "undamped mode": ([0.5, 0.2, 4.5], np.polymul([1.0, 1.0, 0.5], [1.0, 0.0, 9.0])),
    "undamped mode and integrator": (
        [0.2, 0.2, 1.0, 0.5],
        np.polymul([1.0, 1.5, 0.0], [1.0, 0.0, 9.0]),
    ),
    "double pole": ([1.0, 0.5], np.polymul([1.0, -0.4], np.polymul([1.0, 2.0], [1.0, 2.0]))),
}


@pytest.mark.parametrize("name", SPECIAL)
@pytest.mark.parametrize("delay", [0.0, 0.1])
def test_poles_on_the_axis_and_repeated_ones_are_no_obstacle(name, delay):
    above, below = (np.asarray(p, float) for p in SPECIAL[name])
    expected = tv.control.loop_margins(tv.Loop(above, below, delay))
    # A change of the states, in whole numbers, hides the structure.
    A, B, C, D = section(above, below)
    n = len(A)
    turn = np.tril(np.ones((n, n)))
    back = np.linalg.inv(turn)
    margins = tv.control.loop_margins(
        tv.Loop.from_matrices(turn @ A @ back, turn @ B, C @ back, D, delay)
    )
    assert margins.status == expected.status
    assert margins.unstable_poles == expected.unstable_poles
    for key in NUMBERS:
        # A repeated pole is known to the root of rounding, and so is what lies beside it.
        rough = 1e-5 if "frequency" in key and "crossover" not in key else 1e-6
        assert getattr(margins, key) == pytest.approx(
            getattr(expected, key), rel=rough, nan_ok=True
        )


def test_a_loop_has_the_same_margins_alone_and_in_a_batch():
    rng = np.random.default_rng(31)
    systems = [cascade(flexible(rng, 2)) for _ in range(5)]
    stacked = [np.stack(m) for m in zip(*systems, strict=True)]
    delays = np.array([0.0, 0.02, 0.1, 0.0, 0.05])
    loops = tv.Loop.from_matrices(*stacked, delays)
    many = tv.control.loop_margins(loops)
    for k, system in enumerate(systems):
        one = tv.control.loop_margins(tv.Loop.from_matrices(*system, delays[k]))
        assert one.status == many.status[k]
        for name in NUMBERS:
            both = (getattr(one, name), getattr(many, name)[k])
            np.testing.assert_allclose(*both, rtol=1e-9 if "freq" not in name else 1e-5)


@pytest.mark.parametrize("system", [([[1.0, 2.0]], 0, 0), ([[-1.0]], [[1.0, 1.0]], [[1.0]])])
def test_matrices_that_are_no_loop_are_refused(system):
    with pytest.raises(tv.InputError, match=r"a loop needs A \(\.\.\., n, n\)"):
        tv.Loop.from_matrices(*system)
    with pytest.raises(tv.InputError, match="algebraic loop"):
        tv.Loop.from_matrices([[-1.0]], [[1.0]], [[1.0]], [[0.5]])


def test_a_loop_of_matrices_has_no_polynomials():
    loop = tv.Loop.from_matrices([[-1.0]], [[1.0]], [[2.0]])
    assert loop.response(0.0) == 2.0
    with pytest.raises(tv.InputError, match="held as matrices and has no polynomials"):
        _ = loop.numerator


def test_what_passes_at_once_is_a_crossing_at_infinity():
    # In the w plane of a sampled loop: (0.4 - 0.5 w)/(w + 1) is -0.5 at infinity.
    from tvclin.numerics.loops import StateLoop

    one, no = np.ones((1, 1)), np.zeros(1)
    form = StateLoop.balanced(-one[np.newaxis], one, 0.9 * one, np.array([-0.5]), no)
    result = analyse_loops(form)
    assert result.unstable_poles[0] == 0
    assert result.phase_frequencies[0, -1] == np.inf
    assert result.factors[0, -1] == pytest.approx(2.0, rel=1e-12)
    assert result.peaks[0, 0, 0] == pytest.approx(2.0, rel=1e-12)  # S = 1/(1 - 0.5)
