"""The kernels of margins beside other arithmetic: forty digits, python-control, brute force."""

import control
import mpmath
import numpy as np
import pytest

from tests.control.test_margins import NUMBERS, actuated, brute_force, random_loops
from tests.turns import usual
from tvclin.control.margins.loop import Loop
from tvclin.control.margins.margins import Crossings, loop_margins
from tvclin.numerics import polynomials
from tvclin.numerics.loop_margins import PEAK_REFINEMENTS
from tvclin.numerics.searches import grid_minimum

FREQUENCIES = [
    "aero_frequency",
    "gain_increase_frequency",
    "crossover_frequency",
    "delay_margin_frequency",
    "disk_frequency",
    "peak_sensitivity_frequency",
    "peak_complementary_sensitivity_frequency",
]


def test_the_vertex_of_a_smooth_dip_has_the_digits_of_twice_as_many_grids() -> None:
    """Against the place and the depth of a dip that are known, a resonance of height 1/width."""
    place, width = np.array([0.3001, 2.0007]), np.array([0.02, 0.5])

    def height(x):
        return -1.0 / np.hypot((x - place[:, np.newaxis]) * (1.0 + 0.1 * x), width[:, np.newaxis])

    low, high = place - 2.1 * width, place + 1.7 * width
    at, minimum = grid_minimum(height, low, high, PEAK_REFINEMENTS, smooth=True)
    assert np.all(np.abs(at - place) < 1e-7 * width)
    np.testing.assert_allclose(minimum, -1.0 / width, rtol=1e-13)


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


FAMILIES = [
    pytest.param(random_loops, 1e-12, id="random"),
    pytest.param(integrating, 1e-12, id="integrating"),
    pytest.param(bending, 1e-9, id="bending"),  # an undamped mode magnifies what a frequency lacks
]


class Exact:
    """One loop in forty digits."""

    def __init__(self, loop, case):
        self.above, self.below = (
            [mpmath.mpf(float(c)) for c in p[case]] for p in (loop.numerator, loop.denominator)
        )
        self.delay = mpmath.mpf(float(loop.delay[case]))

    def parts(self, omega):
        """Return N with its delay, D, and the derivative of ln L by omega."""
        s = mpmath.mpc(0, omega)
        (n, dn), (d, dd) = (mpmath.polyval(p, s, derivative=1) for p in (self.above, self.below))
        return n * mpmath.exp(-s * self.delay), d, 1j * (dn / n - dd / d - self.delay)

    def gain_crossing(self, omega):
        """Return what a frequency lacks until |L| = 1, and how far L may lag more there."""
        n, d, rise = self.parts(omega)
        lacking = -mpmath.log(abs(n / d)) / mpmath.re(rise)
        n, d, _ = self.parts(omega + lacking)
        return lacking, mpmath.arg(-n / d)

    def phase_crossing(self, omega):
        """Return what a frequency lacks until L is real and negative, and 1/|L| there."""
        if not omega:
            return mpmath.mpf(0), -self.below[-1] / self.above[-1]
        n, d, rise = self.parts(omega)
        lacking = -mpmath.arg(-n / d) / mpmath.im(rise)
        n, d, _ = self.parts(omega + lacking)
        return lacking, abs(d / n)

    def peaks(self, omega):
        """Return |S|, |T| and |S - T|/2 at three frequencies."""
        for kind, at in enumerate(omega):
            n, d, _ = self.parts(at)
            yield abs(((d, n, (d - n) / 2)[kind]) / (n + d))


@pytest.mark.thorough
@pytest.mark.parametrize("count", usual([50, 150], 0))
@pytest.mark.parametrize(("family", "rounding"), FAMILIES)
def test_every_crossing_is_that_of_forty_digits(family, rounding, count):
    loop = family(count, seed=5)
    m = loop_margins(loop)
    assert np.sum(m.status == "ok") > 10
    c = m.crossings
    kinds = [
        ("gain_crossing", c.gain_frequencies, c.phase_margins),
        ("phase_crossing", c.phase_frequencies, c.gain_factors),
    ]
    with mpmath.workdps(40):
        for name, frequencies, values in kinds:
            for case, place in np.argwhere(np.isfinite(frequencies)):
                omega, computed = frequencies[case, place], values[case, place]
                lacking, expected = getattr(Exact(loop, case), name)(mpmath.mpf(float(omega)))
                assert abs(lacking) <= 1e-12 * omega, (name, case, omega)
                assert computed == pytest.approx(float(expected), rel=rounding, abs=rounding)


@pytest.mark.thorough
@pytest.mark.parametrize(("family", "rounding"), FAMILIES)
def test_every_peak_is_that_of_forty_digits(family, rounding):
    loop = family(60, seed=7)
    m = loop_margins(loop)
    names = ["peak_sensitivity", "peak_complementary_sensitivity", "disk"]
    with mpmath.workdps(40):
        for case in np.flatnonzero(m.status == "ok"):
            at = [float(getattr(m, f"{name}_frequency")[case]) for name in names]
            computed = [getattr(m, name)[case] for name in names[:2]] + [1.0 / m.disk_margin[case]]
            exact, apart = Exact(loop, case), mpmath.mpf(1e-7)
            inner = [0.0 < omega < np.inf for omega in at]
            places = [omega if there else 1.0 for omega, there in zip(at, inner, strict=True)]
            before, there, after = (
                list(exact.peaks([mpmath.mpf(w) * (1 + k * apart) for w in places]))
                for k in (-1, 0, 1)
            )
            for kind in np.flatnonzero(inner):
                a, b, c = before[kind], there[kind], after[kind]
                top = b + (c - a) ** 2 / (8 * (2 * b - a - c))  # of the parabola through them
                assert 2 * b > a + c
                assert computed[kind] == pytest.approx(float(top), rel=1e-9)


@pytest.mark.parametrize("count", usual([70, 200], 0))
@pytest.mark.parametrize(("family", "rounding"), FAMILIES)
def test_margins_are_those_of_brute_force(family, rounding, count):
    loop = family(count, seed=6)
    computed, expected = loop_margins(loop), brute_force(loop)
    decided = computed.status != "marginal"
    np.testing.assert_array_equal(
        computed.unstable_poles[decided], expected["unstable_poles"][decided]
    )
    good = computed.status == "ok"
    assert good.sum() > 10
    for name in NUMBERS:
        values = getattr(computed, name)[good]
        np.testing.assert_allclose(values, expected[name][good], rtol=1e-7, err_msg=name)


def test_loops_of_the_first_order_have_the_margins_of_their_formulas():
    """L = g e^(-s T)/(s + 1): |L| = 1 at sqrt(g^2 - 1), where the phase is -arctan(w) - w T."""
    g, T = np.array([1.0, -0.5, -2.0, 3.0]), np.array([0.0, 0.3, 0.3, 1.0])
    m = loop_margins(Loop(g[:, np.newaxis], [1.0, 1.0], T))
    assert m.status.tolist() == ["ok", "ok", "unstable", "unstable"]
    omega = np.sqrt(np.maximum(g**2 - 1.0, 0.0))
    np.testing.assert_allclose(m.crossings.gain_frequencies[2:, 0], omega[2:], rtol=1e-14)
    assert np.isnan(m.crossings.gain_frequencies[1]).all()
    left = np.angle(-g * np.exp(-1j * omega * T) / (1j * omega + 1.0))
    np.testing.assert_allclose(m.crossings.phase_margins[2:, 0], left[2:], rtol=1e-13)
    assert m.gain_increase[1] == pytest.approx(2.0, rel=1e-15)  # -0.5 may double, at zero
    assert m.gain_increase_frequency[1] == 0.0


def test_a_loop_without_gain_crossover_has_no_phase_margin_and_bears_any_delay():
    m = loop_margins(Loop([0.1], [1.0, 3.0, 2.0], [0.0, 0.01, 100.0]))
    assert m.status.tolist() == ["ok"] * 3
    assert np.all(np.isinf(m.phase_margin) & np.isinf(m.delay_margin))
    assert m.crossings.gain_frequencies.shape == (3, 0)


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
    factors = loop_margins(loop).crossings.gain_factors
    assert np.all((factors > 1e-6) & (factors < 1e7) | np.isnan(factors))


def test_what_is_marginal_is_so():
    edge = Loop([[0, 1.0], [0.5, 0.0]], [[1.0, 0.0, 1.0], [1.0, -0.5, 4.0]], 0.0)
    assert loop_margins(edge).status.tolist() == ["marginal", "marginal"]


@pytest.mark.thorough
@pytest.mark.parametrize(("family", "rounding"), FAMILIES)
def test_a_loop_has_the_same_margins_alone_and_anywhere_in_a_batch(family, rounding):
    loop = family(600, seed=8)
    whole = loop_margins(loop)
    for case in (0, 1, 63, 64, 149, 511, 512, 598, 599):
        single = loop_margins(loop.take(case))
        for name in [*NUMBERS, *FREQUENCIES]:
            np.testing.assert_array_equal(getattr(single, name), getattr(whole, name)[case])
        for name in Crossings.__dataclass_fields__:
            listed = getattr(whole.crossings, name)[case]
            result = getattr(single.crossings, name)
            np.testing.assert_array_equal(result, listed[np.isfinite(listed)])


def test_python_control_finds_the_same_crossings():
    drawn = random_loops(60, seed=2)
    loop = Loop(drawn.numerator, drawn.denominator)
    m = loop_margins(loop)
    for k in np.flatnonzero(m.status == "ok"):
        system = control.tf(loop.numerator[k], loop.denominator[k])
        factors, phases, _, at, where, _ = control.stability_margins(system, returnall=True)
        gains, lags = m.crossings.gain_frequencies[k], m.crossings.phase_margins[k]
        there = np.isfinite(gains)
        np.testing.assert_allclose(gains[there], where, rtol=1e-9)
        left = np.degrees(lags[there]) - phases
        np.testing.assert_allclose(left - 360.0 * np.round(left / 360.0), 0.0, atol=1e-6)
        places, computed = m.crossings.phase_frequencies[k], m.crossings.gain_factors[k]
        there, true = places > 0.0, (at > 0.0) & (factors > 1e-9)  # it counts undamped poles too
        np.testing.assert_allclose(places[there], at[true], rtol=1e-7)
        np.testing.assert_allclose(computed[there], factors[true], rtol=1e-6)


def test_crossovers_beside_an_undamped_mode_are_exact():
    """There |N|^2 - |D|^2 has two roots that agree in five digits."""
    above, below = [1e-4, 3e-4], np.polymul([1.0, 0.0, 90.25], [1.0, 1.0])
    loop = Loop([above], [below])
    computed = loop_margins(loop).crossings.gain_frequencies[0]
    assert computed.shape == (2,)
    with mpmath.workdps(40):

        def level(omega):
            top, bottom, _ = Exact(loop, 0).parts(omega)
            return mpmath.log(abs(top / bottom))

        for omega in computed:
            exact = mpmath.findroot(level, (omega * (1 - 1e-9), omega * (1 + 1e-9)))
            assert omega == pytest.approx(float(exact), rel=1e-14)


def test_polynomials_of_different_degree_have_the_roots_they_were_made_of():
    rng, p, expected = np.random.default_rng(0), np.zeros((500, 9)), []
    for row in p:
        real = rng.choice([-1, 1], rng.integers(1, 6)) * 10.0 ** rng.uniform(-4, 3)
        real = real * np.sort(rng.uniform(0.5, 2.0, real.size))
        pair = 10.0 ** rng.uniform(-2, 2) * np.exp(1j * rng.uniform(0.1, 3.0))
        terms = rng.choice([-1, 1]) * np.real(np.poly([*real, pair, np.conj(pair)]))
        row[-terms.size :] = terms
        expected.append(np.sort(real[real > 0.0]))
    p[7] = 0.0
    result = polynomials.roots_of_each(p)
    assert np.isnan(result[7]).all()
    for k in np.delete(np.arange(500), 7):
        roots = result[k][~np.isnan(result[k])]
        assert roots.size == 8 - np.argmax(p[k] != 0.0)
        for one in expected[k]:
            assert np.abs(roots - one).min() <= 1e-6 * one


@pytest.mark.thorough
def test_the_closed_loop_has_as_many_unstable_poles_as_it_was_made_of():
    rng = np.random.default_rng(1)
    for degree in np.repeat(np.arange(1, 9), 50):
        roots = rng.uniform(-3, 1, degree)
        closed, part = np.poly(roots), rng.uniform(-1, 1)
        m = loop_margins(Loop([part], closed - part * (np.arange(degree + 1) == degree)))
        assert m.unstable_poles == np.sum(roots > 0)


def test_a_loop_of_order_fourteen_has_the_margins_of_forty_digits():
    poles = np.linspace(0.5, 4.0, 14)
    loop = Loop([[1.0]], [np.poly(-poles) / np.prod(poles)])
    m = loop_margins(loop)
    assert m.status.tolist() == ["ok"]
    lags = [0.0]
    with mpmath.workdps(40):
        for omega, factor in zip(
            m.crossings.phase_frequencies[0], m.crossings.gain_factors[0], strict=True
        ):
            lacking, expected = Exact(loop, 0).phase_crossing(mpmath.mpf(float(omega)))
            assert abs(lacking) <= 1e-12 * omega
            assert factor == pytest.approx(float(expected), rel=1e-12)
            lags.append(np.sum(np.arctan(omega / poles)))
    # each crossing is half a turn, then whole turns behind the one before; 14 lags make 3.5 turns
    np.testing.assert_allclose(lags[1:], np.pi * np.array([1.0, 3.0, 5.0]), rtol=1e-12)
