"""Filters: their values, their state space, batches of them, and what is refused."""

import numpy as np
import pytest
from scipy import signal

from tvclin import InputError
from tvclin.vehicle import Filter

POINTS = np.array([0.0, 1.0, -0.3 + 2.0j, 14.0j, 400.0j])
FILTERS = {
    "low pass of first order": (Filter.low_pass(13.0), lambda s: 13.0 / (s + 13.0)),
    "low pass": (Filter.low_pass(13.0, 0.95), lambda s: 169.0 / (s**2 + 24.7 * s + 169.0)),
    "lead": (Filter.lead_lag(2.0, 9.0), lambda s: (1 + s / 2.0) / (1 + s / 9.0)),
    "all pass": (Filter.lead_lag(-5.0, 5.0), lambda s: (5.0 - s) / (5.0 + s)),
    "notch": (
        Filter.notch(32.0, 0.06, 0.6),
        lambda s: (s**2 + 3.84 * s + 1024.0) / (s**2 + 38.4 * s + 1024.0),
    ),
    "gain": (Filter.from_coefficients([3.0], [2.0]), lambda s: 1.5 + 0 * s),
    "leading zeros": (
        Filter.from_coefficients([0.0, 0.0, 4.0], [2.0, 6.0]),
        lambda s: 2.0 / (s + 3.0),
    ),
    "integrator": (Filter.from_coefficients([1.0, 2.0], [1.0, 0.0]), lambda s: (s + 2.0) / s),
}


@pytest.mark.parametrize("name", FILTERS)
def test_a_filter_has_the_values_of_its_formula(name):
    computed, formula = FILTERS[name]
    points = POINTS[1:]
    np.testing.assert_allclose(computed(points), formula(points), rtol=1e-14)


@pytest.mark.parametrize("name", FILTERS)
def test_its_state_space_is_the_same_transfer_function(name):
    computed, formula = FILTERS[name]
    A, B, C, D = computed.matrices()
    for s in POINTS[1:]:
        value = (C @ np.linalg.solve(s * np.eye(computed.order) - A, B) + D)[0, 0]
        # The two terms cancel where the filter is small: the error is of the size of both.
        assert abs(value - formula(s)) < 1e-14 * (abs(value) + 2.0 * abs(D[0, 0]))


def test_scipy_finds_the_same_response_of_a_filter_of_high_order():
    above, below = signal.cheby1(8, 0.5, 40.0, analog=True)
    result = Filter.from_coefficients(above, below)
    _, expected = signal.freqs(above, below, [1.0, 20.0, 40.0, 90.0])
    # Horner's scheme errs by eps times the sum of the sizes of the terms, here of the denominator.
    omega = np.array([1.0, 20.0, 40.0, 90.0])
    terms = np.polyval(np.abs(below), omega) / np.abs(np.polyval(below, 1j * omega))
    assert np.all(np.abs(result(1j * omega) / expected - 1.0) < 40 * 2.2e-16 * terms)
    A, B, C, D = result.matrices()
    poles = np.sort_complex(np.linalg.eigvals(A))
    np.testing.assert_allclose(poles, np.sort_complex(np.roots(below)), rtol=1e-9)
    assert D[0, 0] == 0.0
    assert (C @ np.linalg.solve(-A, B))[0, 0] == pytest.approx(above[-1] / below[-1], rel=1e-12)


def test_a_batch_of_filters_is_each_of_them():
    frequencies = np.array([[3.0], [30.0]])
    dampings = np.array([0.2, 0.7, 1.5])
    every = Filter.low_pass(frequencies, dampings)
    assert every.batch == (2, 3)
    A, B, C, D = every.matrices()
    assert (A.shape, B.shape, C.shape, D.shape) == (
        (2, 3, 2, 2),
        (2, 3, 2, 1),
        (2, 3, 1, 2),
        (2, 3, 1, 1),
    )
    for i, w in enumerate(frequencies[:, 0]):
        for k, zeta in enumerate(dampings):
            one = Filter.low_pass(w, zeta)
            np.testing.assert_array_equal(every(POINTS)[i, k], one(POINTS))
            np.testing.assert_array_equal(A[i, k], one.matrices()[0])


def test_a_zero_in_the_right_half_plane_turns_the_phase_alone():
    phase = Filter.lead_lag(-5.0, 5.0)(1j * np.geomspace(0.1, 100.0, 20))
    np.testing.assert_allclose(np.abs(phase), 1.0, rtol=1e-14)
    assert np.all(np.angle(phase) < 0.0)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Filter([1.0, 0.0], [1.0]), "numerator must not be of higher degree"),
        (lambda: Filter([1.0], [0.0, 1.0]), "first coefficient of the denominator must be other"),
        (lambda: Filter([], [1.0]), "numerator must be 1 to 13 coefficients"),
        (lambda: Filter([1.0], 2.0), "denominator must be 1 to 13 coefficients"),
        (lambda: Filter([1.0], [1.0] * 14), "denominator must be 1 to 13 coefficients"),
        (lambda: Filter.low_pass(0.0), "frequency must be positive; got 0 rad/s|between"),
        (lambda: Filter.low_pass(3.0, -0.1), "damping must be between 1e-09"),
        (lambda: Filter.lead_lag(0.0, 1.0), "zero must be other than zero"),
        (lambda: Filter.notch([1.0, 2.0], [0.1, 0.2, 0.3], 0.5), "must have shapes that broadcast"),
    ],
)
def test_what_is_no_filter_is_refused_in_one_sentence(make, said):
    with pytest.raises(InputError, match=said):
        make()
