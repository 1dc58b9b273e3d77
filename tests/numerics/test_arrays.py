"""The array kernels against 60-digit arithmetic."""

from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest
from scipy.optimize.elementwise import find_root

import tvclin as tv
from tests.turns import usual
from tvclin.numerics import polynomials
from tvclin.numerics.pieces import Pieces, moments
from tvclin.numerics.searches import first_crossing, roots_between
from tvclin.winds.histories import Piecewise

EPS = np.finfo(float).eps
RATES = np.array([0.0, -0.8, 0.3 + 2j, 0.3 - 2j])
SIZES = (1e-9, 1e-4, 0.1, 0.9, 1.0, 1.1, 2.5, 5.0, 9.5, 15.4, 16.4, 16.6, 30.0, 100.0, 300.0)
PHASES = (0.0, 0.5, 1.0, np.pi / 2, 2.2, 2.8)


def exact_moment(k, z):
    with mp.workdps(60):
        return mp.hyp1f1(k + 1, k + 2, -mp.mpmathify(z)) / (k + 1)


def moment_error(z, degree):
    """Largest error over the integral of the size of the integrand, M_k(Re z)."""
    computed = moments(z, degree)
    errors = []
    for k in range(degree + 1):
        with mp.workdps(60):
            miss = abs(exact_moment(k, z) - mp.mpmathify(computed[k]))
            errors.append(float(miss / exact_moment(k, np.real(z))))
    return max(errors)


@pytest.mark.thorough
@pytest.mark.parametrize("degree", [0, 1, 2, 7, 14, 15])
@pytest.mark.parametrize("size", SIZES)
def test_moments_are_exact_to_rounding_in_the_whole_complex_plane(size, degree):
    for phase in PHASES:
        assert moment_error(complex(size * np.exp(1j * phase)), degree) < 1e-14


@pytest.mark.parametrize("degree", [0, 1, 2, 7, 14, 15])
@pytest.mark.parametrize("size", SIZES)
def test_moments_of_real_arguments_are_real_and_exact_on_both_sides_of_zero(size, degree):
    for z in (size, -size):
        assert moments(z, degree).dtype == float
        assert moment_error(z, degree) < 1e-14


def test_real_moments_are_positive_and_relatively_exact():
    z = np.concatenate([-np.geomspace(1e-9, 300, 40), np.geomspace(1e-9, 300, 40)])
    computed = moments(z, 3)
    for k in range(4):
        expected = np.array([float(exact_moment(k, float(x))) for x in z])
        np.testing.assert_allclose(computed[:, k], expected, rtol=1e-14)


@pytest.mark.parametrize("z", [29.9, -29.9, 29.9j, 21.0 + 21.0j])
def test_moments_up_to_degree_30_keep_the_thirteen_digits_that_are_promised(z):
    assert moment_error(z, 30) < 1e-13


def test_moments_at_zero_are_one_over_the_orders():
    np.testing.assert_allclose(moments(0.0, 20), 1.0 / np.arange(1, 22), rtol=3e-16)


def test_a_batch_of_moments_is_the_loop_over_its_elements():
    z = np.array([[0.0, 1e-9, -3.0], [2.0, 40.0, -40.0]])
    loop = [[moments(x, 6) for x in row] for row in z]
    np.testing.assert_array_equal(moments(z, 6), loop)
    np.testing.assert_array_equal(
        moments(1j * z, 6), [[moments(1j * x, 6) for x in row] for row in z]
    )


def by_size(roots):
    return roots[np.argsort(np.abs(roots))]


@pytest.mark.parametrize("tiny", [1e-3, 1e-7, 1e-12, -1e-12])
def test_a_tiny_root_beside_big_ones_has_full_relative_accuracy(tiny):
    with mp.workdps(50):
        t, a, b = mp.mpf(tiny), mp.mpf(30), mp.mpf(-400)
        exact = [1, -(t + a + b), t * a + t * b + a * b, -t * a * b]
        polynomial = np.array([float(c) for c in exact])
        # The root of the rounded polynomial, which is what there is to find.
        expected = [float(mp.re(r)) for r in mp.polyroots([mp.mpf(c) for c in polynomial], 200)]
    expected = by_size(np.array(expected))
    np.testing.assert_allclose(by_size(polynomials.roots(polynomial)), expected, rtol=1e-15)


def test_a_root_at_zero_is_exactly_zero():
    result = by_size(polynomials.roots(np.array([1.0, 0.0, -0.28, 0.0])))
    assert result[0] == 0.0
    np.testing.assert_allclose(np.sort(result[1:]), [-np.sqrt(0.28), np.sqrt(0.28)], rtol=4e-16)


@pytest.mark.parametrize("root", [1.0, -0.5, 0.1, 3.7])
def test_a_double_root_is_found_to_half_the_digits(root):
    result = polynomials.roots(np.array([1.0, -2.0 * root, root**2]))
    # A relative change of epsilon moves a double root by its square root, 1.5e-8.
    np.testing.assert_allclose(result, [root, root], rtol=4e-8)


def test_a_double_root_leaves_no_residual():
    polynomial = np.poly([0.3, 0.3, -2.0])
    result = polynomials.roots(polynomial)
    size = np.polyval(np.abs(polynomial), np.abs(result))
    assert np.all(np.abs(np.polyval(polynomial, result)) <= 4e-16 * size)


def test_complex_roots_come_in_conjugate_pairs():
    frequency, damping = 25.1, 0.7
    result = polynomials.roots(np.array([1.0, 2 * damping * frequency, frequency**2]))
    imaginary = frequency * np.sqrt(1 - damping**2)
    expected = -damping * frequency + imaginary * np.array([-1j, 1j])
    np.testing.assert_allclose(result[np.argsort(result.imag)], expected, rtol=4e-16)
    assert result[0] == np.conj(result[1])


def test_roots_of_quadratics_of_any_shape_keep_their_digits():
    rng = np.random.default_rng(3)
    sizes = 10.0 ** rng.uniform(-6.0, 6.0, (2, 100))
    quadratics = np.stack([np.ones(100), *(sizes * rng.choice([-1.0, 1.0], (2, 100)))], axis=-1)
    for quadratic, computed in zip(quadratics, polynomials.roots(quadratics), strict=True):
        with mp.workdps(50):
            middle, product = -mp.mpf(quadratic[1]) / 2, mp.mpf(quadratic[2])
            height = mp.sqrt(middle**2 - product)
            for root in (middle - height, middle + height):
                error = min(abs(mp.mpmathify(complex(r)) / root - 1) for r in computed)
                assert error <= 4 * EPS, quadratic


def test_real_roots_are_real_and_one_complex_pair_makes_the_batch_complex():
    real, pair = [1.0, 0.0, -4.0], [1.0, 0.0, 4.0]
    assert polynomials.roots(np.array([real])).dtype == float
    assert polynomials.roots(np.array([real, pair])).dtype == complex


def test_a_batch_of_roots_is_the_loop_over_its_elements():
    batch = np.array([[[2.0, 1.0, -9.0, 1e-7]], [[1.0, -3.0, 2.0, -1.0]]])
    result = polynomials.roots(batch)
    assert result.shape == (2, 1, 3)
    for i in range(2):
        np.testing.assert_array_equal(result[i, 0], polynomials.roots(batch[i, 0]))


def test_one_polynomial_many_times_has_its_roots_each_time():
    one = np.poly([-2.0 + 3.0j, -2.0 - 3.0j, 0.5]).real
    many = np.tile(one, (2, 3, 1))
    result = polynomials.roots(many)
    np.testing.assert_array_equal(result, np.tile(polynomials.roots(one), (2, 3, 1)))
    many[1, 2, -1] += 1.0  # and one that is another has its own
    np.testing.assert_array_equal(polynomials.roots(many)[0, 0], result[0, 0])
    np.testing.assert_array_equal(polynomials.roots(many)[1, 2], polynomials.roots(many[1, 2]))


def test_scaling_a_polynomial_leaves_its_roots():
    polynomial = np.array([1.0, 0.25, -0.5, 0.01])
    np.testing.assert_allclose(
        polynomials.roots(1024.0 * polynomial), polynomials.roots(polynomial), rtol=1e-15
    )


def test_a_constant_has_no_roots():
    assert polynomials.roots(np.array([[3.0], [4.0]])).shape == (2, 0)


def test_quotient_and_remainder_rebuild_the_polynomial():
    polynomial, root = np.array([3.0, -1.0, 4.0, 1.0, -5.0]), np.array(2.0)
    quotient, remainder = polynomials.divide(polynomial, root)
    rebuilt = np.polyadd(np.polymul([1.0, -2.0], quotient), [remainder])
    np.testing.assert_array_equal(rebuilt, polynomial)
    assert remainder == np.polyval(polynomial, 2.0) == 53.0


def test_division_by_a_complex_root_leaves_the_value_there():
    polynomial, root = np.array([1.0, 2.0, 3.0]), np.array([0.5 + 1j, -2j])
    quotient, remainder = polynomials.divide(polynomial, root)
    np.testing.assert_allclose(remainder, np.polyval(polynomial, root), rtol=1e-15)
    np.testing.assert_array_equal(quotient, np.stack([np.ones(2), root + 2.0], axis=-1))


def test_values_and_derivatives_of_polynomials_broadcast():
    polynomial, s = np.array([[1.0, 2.0, 3.0], [0.0, -1.0, 1j]]), np.array([0.0, 2.0, 1 + 1j])
    np.testing.assert_array_equal(
        [np.polyval(row, s) for row in polynomial], polynomials.value(polynomial, s)
    )
    np.testing.assert_array_equal([[2.0, 2.0], [0.0, -1.0]], polynomials.derivative(polynomial))


def test_first_crossing_is_the_first_of_several_and_never_is_infinite():
    times = np.array([[0.0, 1.0, 3.0, 5.0], [0.0, 1.0, 3.0, 5.0]])
    levels = np.array([0.5, 2.0])

    def evaluate(t, index):
        return np.sin(t) - levels[index]

    result = first_crossing(times, np.sin(times) - levels[:, np.newaxis], evaluate)
    np.testing.assert_allclose(result, [np.pi / 6, np.inf], rtol=4e-16)


def test_roots_in_brackets_are_those_of_scipy_and_the_upper_end_where_nothing_rises():
    level, power = np.array([1e-8, 0.3, 0.9, 2.0, 40.0]), np.array([1.0, 3.0, 9.0, 0.2, 2.0])
    low, high = np.zeros(5), np.array([1.0, 1.0, 1.0, 100.0, 6.0])

    def function(x, k):
        return x ** power[k] - level[k]

    result = roots_between(low, high, function)
    expected = find_root(function, (low[:4], high[:4]), args=(np.arange(4),)).x
    np.testing.assert_allclose(result[:4], expected, rtol=8 * EPS)
    np.testing.assert_allclose(result[:4], level[:4] ** (1 / power[:4]), rtol=8 * EPS)
    assert result[4] == high[4]


def mixed():
    """Return a history with every kind of term, a jump, a piece of no width and a decaying end."""
    c = np.zeros((5, 4, 3), complex)
    c[0, 0], c[0, 1] = (1.0, -2.0, 0.5), (0.3, 0.7, -0.1)
    c[1, 2], c[1, 3] = (0.4 - 0.3j, 0.2j, 0.1), (0.4 + 0.3j, -0.2j, 0.1)
    c[2, 0] = 9.0
    c[3, 0], c[3, 1] = (-0.7, 0.1, 0.0), (1.5, 0.0, 0.2)
    c[4, 1] = (0.5, -0.2, 0.15)
    return Piecewise(Pieces(np.array([-1.0, 0.5, 2.0, 2.0, 7.0]), c, RATES))


def exact_value(history, t, i=None):
    """Return the value at `t` by its definition; of the piece `i` if it is given."""
    p = history.pieces
    i = int(np.searchsorted(p.knots, float(t), side="right")) - 1 if i is None else i
    if i < 0:
        return mp.mpf(0)
    u = mp.mpf(t) - mp.mpf(float(p.knots[i]))
    terms = [
        mp.mpmathify(complex(p.coefficients[i, r, k])) * u**k * mp.exp(complex(rate) * u)
        for r, rate in enumerate(p.rates)
        for k in range(p.degree + 1)
        if p.coefficients[i, r, k] != 0.0
    ]
    return mp.re(mp.fsum(terms))


def quadrature(history, s, start=None):
    """Integrate e^(-s (t - start)) times the history from `start` on."""
    knots = [*history.knots.tolist(), mp.inf]
    first, origin = (knots[0], 0.0) if start is None else (start, start)
    total = mp.mpc(0)
    for i, (low, high) in enumerate(pairwise(max(k, first) for k in knots)):

        def weighted(t, i=i):
            return mp.exp(-s * (t - origin)) * exact_value(history, t, i)

        if low < high and np.any(history.pieces.coefficients[i] != 0.0):
            ends = [low, high] if high == mp.inf else mp.linspace(low, high, 4)
            with mp.workdps(30):
                total += mp.quad(weighted, ends)
    return complex(total)


def test_values_are_the_sums_of_their_terms_on_every_piece():
    h, times = mixed(), np.array([-1.0, -0.2, 0.499, 0.5, 1.3, 1.999, 4.0, 6.9, 7.0, 11.0, 40.0])
    expected = [float(exact_value(h, t)) for t in times]
    np.testing.assert_allclose(h(times), expected, rtol=1e-14, atol=1e-15)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "s", usual([0.0, 1e-9, 0.5, -0.3, 3.0, 20.0, 0.3 + 2j, -0.4 - 1j, 1e-7 + 1e-7j], 1, 4, 7, 8)
)
def test_transforms_agree_with_quadrature(s):
    h = mixed()
    assert abs(h.laplace(s) - quadrature(h, s)) < 20 * EPS * h.laplace_magnitude(s)
    assert np.iscomplexobj(h.laplace(s)) == isinstance(s, complex)


@pytest.mark.thorough
@pytest.mark.parametrize("s", usual([0.2, 1.5, 0.0, 0.7 - 1j], 0))
def test_the_discounted_future_agrees_with_quadrature(s):
    h, times = mixed(), np.array([-3.0, -1.0, 0.2, 0.5, 1.7, 2.0, 5.0, 7.0, 30.0])
    expected = np.array([quadrature(h, s, t) for t in times])
    np.testing.assert_allclose(h.remaining_integral(s, times), expected, rtol=4e-14, atol=1e-15)


def test_a_history_is_zero_before_its_first_knot_and_continuous_from_the_right():
    h = mixed()
    assert h([-1.0000001])[0] == 0.0
    np.testing.assert_allclose(h([-1.0, 0.5, 2.0, 7.0]), [1.3, 0.8, 0.8, 0.5], rtol=4e-16)


def test_the_magnitude_does_not_heed_the_sign_nor_the_phase():
    h = mixed()
    np.testing.assert_array_equal(h.laplace_magnitude(0.4), (-h).laplace_magnitude(0.4 + 3j))
    assert h.laplace_magnitude(0.4) > abs(h.laplace(0.4))


@pytest.mark.parametrize("s", [0.0, -1.0, 0j, 1j, -0.5 + 2j])
def test_a_transform_that_diverges_is_infinite(s):
    assert np.isinf(tv.linear.ConstantDeflection(limit=0.1, start=2.0).laplace(s))
    assert np.isinf(tv.linear.ConstantDeflection(limit=0.1).laplace(s))


def test_a_decaying_end_has_a_transform_right_of_its_rate_and_none_left_of_it():
    h = mixed()
    assert np.isfinite(h.laplace(-0.79))
    assert np.isinf(h.laplace(-0.8))
    assert np.isinf(h.laplace(-0.9))
