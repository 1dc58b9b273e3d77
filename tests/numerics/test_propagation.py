"""Matrix exponentials and what they carry, against mpmath, quadrature and closed forms."""

import mpmath as mp
import numpy as np
import pytest
from scipy.linalg import expm, matrix_balance
from scipy.optimize import minimize_scalar

from tvclin.numerics.pieces import Pieces
from tvclin.numerics.propagation import (
    augmented_matrix,
    balanced,
    input_states,
    matrix_exponentials,
    motions,
    peak_output,
)

EPS = np.finfo(float).eps
STEPS = np.array([0.0, 1e-12, 1e-3, 0.1, 1.0, 30.0])
RNG = np.random.default_rng(11)
MATRICES = {
    "small": 1e-9 * RNG.normal(size=(4, 4)),
    "any": RNG.normal(size=(5, 5)),
    "complex": RNG.normal(size=(3, 3)) + 1j * RNG.normal(size=(3, 3)),
    "fourfold pole": np.eye(4, k=1) - 0.7 * np.eye(4),
    "fourfold pole, badly scaled": 1e4 * np.eye(4, k=1) - 0.7 * np.eye(4),
    "nilpotent": np.eye(4, k=1),
    "zero": np.zeros((3, 3)),
    "stiff": np.array([[-1000.0, 1.0], [0.0, -1.0]]),
    "stiff oscillator": np.array([[0.0, 1.0, 0.0], [-6.3e4, -350.0, 1.0], [0.0, 0.0, -0.05]]),
    "undamped": np.array([[0.0, 50.0], [-50.0, 0.0]]),
    "badly scaled oscillator": np.array([[0.0, 1e6], [-1e-6, -1e-2]]),
    "growing": np.array([[0.0, 1.0], [0.28, 0.0]]),
}
EACH_MATRIX = pytest.mark.parametrize("matrix", MATRICES.values(), ids=MATRICES)


@EACH_MATRIX
def test_balancing_is_a_similarity_whose_norms_are_those_of_lapack(matrix):
    computed, scale = balanced(matrix)
    np.testing.assert_array_equal(computed * scale[:, np.newaxis] / scale, matrix)  # powers of two
    expected = matrix_balance(matrix, permute=False)[0]
    for axis in (0, 1):
        sizes, lapack = (np.linalg.norm(one, axis=axis) for one in (computed, expected))
        assert np.linalg.norm(sizes) <= 2.0 * np.linalg.norm(lapack)


def exact(matrix, step):
    with mp.workdps(60):
        result = mp.expm(mp.matrix(matrix.tolist()) * mp.mpf(float(step)))
        return np.array([[complex(cell) for cell in row] for row in result.tolist()])


@EACH_MATRIX
def test_exponentials_are_those_of_sixty_digits(matrix):
    """One rounding for each of the norm's units: no method that squares does better."""
    result = matrix_exponentials(matrix, STEPS)
    balanced = matrix_balance(matrix, permute=False)[0]
    rounding = 4 * EPS * max(np.linalg.norm(balanced, 1) * STEPS.max(), 1.0)
    for step, one in zip(STEPS, result, strict=True):
        expected = exact(matrix, step)
        assert np.abs(one - expected).max() <= rounding * np.abs(expected).max()
    assert result.dtype == matrix.dtype


@pytest.mark.thorough
@EACH_MATRIX
def test_a_short_step_keeps_its_digits_beside_a_very_long_one(matrix):
    steps = np.array([1e-3, 1e5])
    with np.errstate(over="ignore", invalid="ignore"):  # what grows may overflow in so long a time
        computed = matrix_exponentials(matrix, steps)[0]
    np.testing.assert_array_equal(computed, matrix_exponentials(matrix, steps[:1])[0])
    balanced, scaling = matrix_balance(matrix, permute=False)
    balanced_found = np.linalg.inv(scaling) @ computed @ scaling
    expected = exact(balanced, 1e-3)
    rounding = 4 * EPS * max(np.linalg.norm(balanced, 1) * 1e-3, 1.0)
    assert np.abs(balanced_found - expected).max() <= rounding * np.abs(expected).max()


@EACH_MATRIX
@pytest.mark.parametrize("step", [1e-3, 0.3, 4.0])
def test_exponentials_are_those_of_scipy(matrix, step):
    computed, expected = matrix_exponentials(matrix, np.array([step]))[0], expm(matrix * step)
    np.testing.assert_allclose(computed, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize("name", ["any", "complex", "nilpotent", "undamped", "growing"])
def test_backwards_and_forwards_is_nowhere(name):
    there, back = matrix_exponentials(MATRICES[name], np.array([0.7, -0.7]))
    np.testing.assert_allclose(there @ back, np.eye(len(there)), atol=1e-13)
    np.testing.assert_allclose(back, exact(MATRICES[name], -0.7), atol=1e-13)


def test_no_step_changes_nothing_and_nothing_has_no_exponential():
    matrix = MATRICES["any"]
    np.testing.assert_array_equal(matrix_exponentials(matrix, np.zeros(2)), [np.eye(5)] * 2)
    assert matrix_exponentials(matrix, np.zeros(0)).shape == (0, 5, 5)
    assert matrix_exponentials(np.zeros((0, 0)), np.ones(3)).shape == (3, 0, 0)


def test_a_lag_with_its_input_held_and_in_a_ramp():
    """X' = -a x + b z: after a while h, of a unit that is held or that rises to one."""
    a, b, h = 0.7, 2.0, 1.3
    A, B, fallen = np.array([[-a]]), np.array([[b]]), np.exp(-a * h)
    held = matrix_exponentials(augmented_matrix(A, B), np.array([h]))[0]
    np.testing.assert_allclose(held, [[fallen, b * (1 - fallen) / a], [0, 1]], rtol=1e-14)
    rising = np.array([[0.0, 1.0 / h], [0.0, 0.0]])
    ramp = matrix_exponentials(augmented_matrix(A, np.array([[b, 0.0]]), rising), np.array([h]))[0]
    expected = b / h * (h / a - (1 - fallen) / a**2)
    np.testing.assert_allclose(ramp[0], [*held[0], expected], rtol=1e-14)
    np.testing.assert_array_equal(ramp[1:], [[0, 1, 1], [0, 0, 1]])


POLE, FREQUENCY, DAMPING = 0.7, 3.0, 0.2
OMEGA = FREQUENCY * np.sqrt(1 - DAMPING**2)
SYSTEMS = {
    "double pole": (
        [[-POLE, 1.0], [0.0, -POLE]],
        [0.0, 1.0],
        [lambda u: u * np.exp(-POLE * u), lambda u: np.exp(-POLE * u)],
    ),
    "triple pole": (
        [[-POLE, 1.0, 0.0], [0.0, -POLE, 1.0], [0.0, 0.0, -POLE]],
        [0.0, 0.0, 1.0],
        [lambda u, k=k: u**k / max(k, 1) * np.exp(-POLE * u) for k in (2, 1, 0)],
    ),
    "double integrator": (
        [[0.0, 1.0], [0.0, 0.0]],
        [0.0, 1.0],
        [lambda u: u, lambda u: 1.0],
    ),
    "oscillator": (
        [[0.0, 1.0], [-(FREQUENCY**2), -2 * DAMPING * FREQUENCY]],
        [0.0, 1.0],
        [
            lambda u: np.exp(-DAMPING * FREQUENCY * u) * np.sin(OMEGA * u) / OMEGA,
            lambda u: (
                np.exp(-DAMPING * FREQUENCY * u)
                * (np.cos(OMEGA * u) - DAMPING * FREQUENCY / OMEGA * np.sin(OMEGA * u))
            ),
        ],
    ),
    "growing and decaying": (
        [[0.5, 0.0], [0.0, -0.5]],
        [1.0, 2.0],
        [lambda u: np.exp(0.5 * u), lambda u: 2 * np.exp(-0.5 * u)],
    ),
}
INPUTS = {
    "cubic, a jump, a line, nothing": (
        [-1.0, 0.5, 2.0],
        [[[0.3, -0.2, 0.4, 0.1]], [[-0.5, 0.3, 0.0, 0.0]], [[0.0, 0.0, 0.0, 0.0]]],
        [0.0],
    ),
    "exponentials, one of them at a pole of a system": (
        [0.0, 1.5, 4.0],
        [[[0.2, 0.1], [0.0, 0.5]], [[-0.3, 0.0], [0.1, 0.2]], [[0.0, 0.0], [0.4, 0.0]]],
        [-POLE, -1.9],
    ),
    "one minus cosine": (
        [0.0, 1.0, 2.0],
        [[[0.5], [-0.25], [-0.25]], [[0.5], [0.25], [0.25]], [[0.0], [0.0], [0.0]]],
        [0.0, 1j * np.pi, -1j * np.pi],
    ),
    "at the frequency of the oscillator": (
        [0.0, 3.0],
        [[[-0.5j], [0.5j]], [[0.0], [0.0]]],
        [1j * FREQUENCY, -1j * FREQUENCY],
    ),
    "a piece of no width": ([0.0, 1.0, 1.0, 2.0], [[[1.0]], [[7.0]], [[-1.0]], [[0.0]]], [0.0]),
}
EACH_SYSTEM = pytest.mark.parametrize("system", SYSTEMS.values(), ids=SYSTEMS)
EACH_INPUT = pytest.mark.parametrize("history", INPUTS.values(), ids=INPUTS)


def carried(system, history):
    knots, coefficients, rates = history
    pieces = Pieces(np.array(knots), np.array(coefficients), np.array(rates))
    return motions(np.array(system[0]), np.array(system[1]), [pieces])[0]


def value(history, piece, time):
    knots, coefficients, rates = history
    u = time - knots[piece]
    rows = zip(coefficients[piece], rates, strict=True)
    terms = [c * u**k * np.exp(rate * u) for row, rate in rows for k, c in enumerate(row)]
    return np.real(sum(terms))


def convolved(kernel, history, time):
    """Integrate kernel(time - r) f(r) over each piece, by Gauss in panels of half a second."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    ends, total = [*history[0][1:], np.inf], 0.0
    for k, (start, end) in enumerate(zip(history[0], ends, strict=True)):
        width = min(end, time) - start
        if width > 0.0:
            edges = np.linspace(start, start + width, int(np.ceil(2 * width)) + 1)
            middle, half = (edges[1:] + edges[:-1]) / 2, np.diff(edges)[:, np.newaxis] / 2
            r = middle[:, np.newaxis] + half * nodes
            total += np.sum(half * weights * kernel(time - r) * value(history, k, r))
    return total


@pytest.mark.thorough
@EACH_SYSTEM
@EACH_INPUT
def test_the_motion_is_the_convolution_with_the_impulse_response(system, history):
    knots = history[0]
    times = np.array([knots[0] - 1.0, *knots, knots[0] + 0.3, knots[-1] + 0.05, knots[-1] + 6.0])
    computed = carried(system, history).at(times)[:, : len(system[0])]
    expected = [[convolved(kernel, history, t) for kernel in system[2]] for t in times]
    np.testing.assert_allclose(computed, expected, rtol=1e-12, atol=1e-13)
    assert not computed[0].any()


@EACH_INPUT
def test_the_input_is_carried_beside_the_states_and_is_continuous_from_the_right(history):
    knots = np.array(history[0])
    flown = carried(SYSTEMS["oscillator"], history)
    inputs = np.zeros(len(flown.matrix))
    inputs[2 :: len(history[1][0][0])] = 1.0
    last = [np.flatnonzero(knots == knot)[-1] for knot in knots]
    here = [value(history, piece, knot) for piece, knot in zip(last, knots, strict=True)]
    np.testing.assert_allclose(flown.at(knots) @ inputs, here, atol=1e-15)
    between = knots[-1] + np.array([0.2, 3.0])
    there = [value(history, len(knots) - 1, t) for t in between]
    np.testing.assert_allclose(flown.at(between) @ inputs, there, atol=1e-14)
    early = np.nextafter(knots[0], -np.inf)
    assert not flown.at(np.array([early, early - 5.0])).any()
    pieces = Pieces(knots, np.array(history[1]), np.array(history[2]))
    times = np.array([early, *between])
    np.testing.assert_allclose(input_states(pieces, times), flown.at(times)[:, 2:], atol=1e-14)


def step_input(*extra):
    """Return a unit step at zero, with knots where nothing happens."""
    knots = [0.0, *extra]
    return knots, [[[1.0]]] * len(knots), [0.0]


def oscillator(frequency, damping):
    """Return the oscillator whose step settles at one."""
    return [[0.0, 1.0], [-(frequency**2), -2 * damping * frequency]], [0.0, frequency**2]


def step_answer(frequency, damping, time):
    """Return the answer to the step and its rate, from any textbook."""
    sigma, omega = damping * frequency, frequency * np.sqrt(1 - damping**2)
    decayed = np.exp(-sigma * time)
    place = 1 - decayed * (np.cos(omega * time) + sigma / omega * np.sin(omega * time))
    return place, decayed * frequency**2 / omega * np.sin(omega * time)


@pytest.mark.parametrize("frequency", [0.7, 30.0])
@pytest.mark.parametrize("damping", [1e-9, 0.02, 0.3, 0.7])
def test_the_overshoot_of_a_step_is_found(frequency, damping):
    flown = carried(oscillator(frequency, damping), step_input())
    for row, sign in ((np.array([1.0, 0, 0]), 1), (np.array([-1.0, 0, 0]), -1)):
        computed, time = peak_output(flown, row, 40 / damping / frequency)
        over = np.exp(-np.pi * damping / np.sqrt(1 - damping**2))
        assert computed == pytest.approx(sign * (1 + over), rel=1e-11)
        assert time == pytest.approx(np.pi / frequency / np.sqrt(1 - damping**2), rel=1e-6)


@pytest.mark.parametrize("off", [-0.3, -0.01, -1e-6, 0.0, 1e-6, 0.01, 0.3])
def test_a_knot_beside_the_peak_does_not_hide_it(off):
    top = np.pi / np.sqrt(1 - 0.2**2)
    flown = carried(oscillator(1.0, 0.2), step_input(top + off))
    computed, time = peak_output(flown, np.array([1.0, 0, 0]), 200.0)
    assert computed == pytest.approx(1 + np.exp(-top * 0.2), rel=1e-11)
    assert time == pytest.approx(top, rel=1e-6)


@pytest.mark.parametrize("width", [0.01, 0.4, 1.5])
@pytest.mark.parametrize("damping", [1e-9, 0.003, 0.3])
def test_a_peak_after_the_last_knot_is_found(width, damping):
    """From the end of the pulse on the motion is free, from where and how fast it then is."""
    history = [0.0, width], [[[1.0]], [[0.0]]], [0.0]
    computed, time = peak_output(
        carried(oscillator(1.0, damping), history), np.array([1.0, 0, 0]), 40 / damping
    )
    omega = np.sqrt(1 - damping**2)
    place, rate = step_answer(1.0, damping, width)
    later = np.arctan2(rate * omega, damping * rate + place) / omega
    swing = np.cos(omega * later) * place + np.sin(omega * later) * (rate + damping * place) / omega
    assert computed == pytest.approx(np.exp(-damping * later) * swing, rel=1e-11)
    assert time == pytest.approx(width + later, rel=1e-6)


@pytest.mark.parametrize("width", [0.3, 2.0, 9.0])
def test_a_peak_at_a_knot_is_found_there(width):
    """A lag rises as long as the pulse lasts."""
    history = [0.0, width, width + 3.0], [[[-1.0]], [[0.0]], [[0.0]]], [0.0]
    result = peak_output(carried(([[-0.5]], [1.0]), history), np.array([1.0, 0.0]), 80.0)
    assert result == (pytest.approx(-2 * -np.expm1(-width / 2), rel=1e-12), width)


def test_a_peak_on_either_side_of_a_jump_is_found():
    """The input itself, which rises to 2 and drops to 1, or drops from 1 to -3 and rises."""
    itself = np.array([0.0, 1.0, 0.0])
    left = [0.0, 1.0, 2.0], [[[0.0, 2.0]], [[1.0, -1.0]], [[0.0, 0.0]]], [0.0]
    right = [0.0, 1.0, 2.0], [[[0.0, 1.0]], [[-3.0, 3.0]], [[0.0, 0.0]]], [0.0]
    for history, expected in ((left, 2.0), (right, -3.0)):
        assert peak_output(carried(([[-0.5]], [1.0]), history), itself, 80.0) == (
            pytest.approx(expected, rel=1e-14),
            1.0,
        )


def test_the_peak_of_a_smooth_gust_lies_at_its_middle_knot():
    flown = carried(([[-0.5]], [1.0]), INPUTS["one minus cosine"])
    computed, time = peak_output(flown, np.array([0.0, 1.0, 1.0, 1.0]), 80.0)
    assert computed == pytest.approx(1.0, rel=1e-14)
    assert time == pytest.approx(1.0, abs=1e-7)


@pytest.mark.thorough
def test_the_rate_of_a_lag_peaks_on_one_side_of_a_knot():
    """In a ramp x' = w - x tends to the slope, x' = slope + (x'(0) - slope) e^-t: it has no summit.

    The output does not see the two poles at zero of the ramp, which have one vector between them.
    """
    draw = np.random.default_rng(3)
    for _ in range(60):
        knots, ramps = np.cumsum([0.0, *draw.uniform(0.2, 2.0, 4)]), draw.uniform(-1, 1, (4, 2))
        history = knots, [*ramps[:, np.newaxis], [[0.0, 0.0]]], [0.0]
        x, sizes = 0.0, [0.0]
        for (first, slope), width in zip(ramps, np.diff(knots), strict=True):
            begun = first - x
            ended = slope + (begun - slope) * np.exp(-width)
            x = first + slope * width - ended
            sizes += [abs(begun), abs(ended)]
        sizes.append(abs(x))
        rate = np.array([-1.0, 1.0, 0.0])
        computed, _ = peak_output(carried(([[-1.0]], [1.0]), history), rate, 40.0)
        assert abs(computed) == pytest.approx(max(sizes), rel=1e-13)


def test_what_rises_for_ever_is_followed_as_far_as_asked():
    computed, time = peak_output(
        carried(([[-0.5]], [1.0]), step_input()), np.array([1.0, 0.0]), 80.0
    )
    assert (computed, time) == (pytest.approx(2.0, rel=1e-13), 80.0)


@pytest.mark.thorough
@pytest.mark.parametrize("damping", [0.005, 0.05])
def test_the_highest_of_many_swings_is_found(damping):
    """An oscillator in a wind of its own frequency, x'' + 2 d x' + x = sin t, which then stops.

    Meanwhile 2 d x = (answer to a step) - 1 + cos t, with its sign changed; then it is free.
    """
    omega = np.sqrt(1 - damping**2)
    for lasts in np.linspace(4.0, 150.0, 40):
        history = [0.0, lasts], [[[-0.5j], [0.5j]], [[0.0], [0.0]]], [1j, -1j]
        flown = carried(oscillator(1.0, damping), history)
        computed, time = peak_output(flown, np.array([1.0, 0, 0, 0]), 40 / damping)
        during, after = np.linspace(0.0, lasts, 20_001), np.linspace(0.0, 12.0, 20_001)
        stepped, rate = step_answer(1.0, damping, during)
        swings = (1 - stepped - np.cos(during)) / (2 * damping)
        place, rate = swings[-1], (np.sin(lasts) - rate[-1]) / (2 * damping)
        free = place * np.cos(omega * after) + (rate + damping * place) / omega * np.sin(
            omega * after
        )
        sizes = np.abs(np.concatenate([swings, np.exp(-damping * after) * free]))
        assert abs(computed) == pytest.approx(sizes.max(), rel=1e-4), lasts
        assert abs(computed) >= sizes.max() * (1 - 1e-12), lasts
        top = np.concatenate([during, lasts + after])[np.argmax(sizes)]
        assert time == pytest.approx(top, abs=0.02), lasts


@pytest.mark.parametrize("damping", [1e-9, 0.1])
def test_an_output_that_is_always_zero_has_no_peak(damping):
    """One that nothing drives, and one that nobody looks at."""
    A, B = oscillator(1.0, damping)
    for given, row in (([0.0, 0.0], [1.0, 0, 0]), (B, [0.0, 0, 0])):
        flown = carried((A, given), ([0.0, 5.0], [[[1.0]], [[0.0]]], [0.0]))
        assert peak_output(flown, np.array(row), 40 / damping) == (0.0, 0.0)


def two_swings(decay, frequencies):
    """Return two oscillators after an impulse, seen as the sum of their free swings."""
    A = np.kron(np.eye(2), -decay * np.eye(2))
    A[[0, 2], [1, 3]], A[[1, 3], [0, 2]] = frequencies, np.negative(frequencies)
    width = 1e-9
    history = [0.0, width], [[[1.0 / width]], [[0.0]]], [0.0]
    flown = carried((A, [0.0, 1.0, 0.0, 1.0]), history)
    return peak_output(flown, np.array([1.0, 0, 1.0, 0, 0]), 40 / decay)


@pytest.mark.parametrize("decay", [1e-3, 0.1])
def test_the_highest_beat_of_two_frequencies_is_found(decay):
    frequencies = np.array([1.0, np.sqrt(2.0)])

    def size(t):
        return np.exp(-decay * t) * np.abs(np.sin(np.multiply.outer(t, frequencies)).sum(axis=-1))

    times = np.arange(0.0, 400.0, 0.01)
    near = times[size(times) > 0.999 * size(times).max()]
    tops = [minimize_scalar(lambda t: -size(t), bounds=(t - 0.02, t + 0.02)) for t in near]
    best = min(tops, key=lambda top: top.fun)
    assert 2.0 * np.exp(-decay * times[-1]) < -best.fun  # nothing higher comes later
    computed, time = two_swings(decay, frequencies)
    assert abs(computed) == pytest.approx(-best.fun, rel=1e-8)
    assert time == pytest.approx(best.x, abs=1e-4)


def test_the_highest_beat_is_found_long_before_the_motion_has_died_out():
    computed, time = two_swings(1e-9, np.array([1.0, np.sqrt(2.0)]))
    assert 2.0 - 1e-4 < abs(computed) < 2.0
    swing = np.exp(-1e-9 * time) * np.sin(time * np.array([1.0, np.sqrt(2.0)])).sum()
    assert abs(computed) == pytest.approx(abs(swing), rel=1e-7)
