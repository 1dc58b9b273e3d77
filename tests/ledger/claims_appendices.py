"""The report's numbers of appendices B and C: roots, and the optimum with two of them."""

import numpy as np
from numpy.typing import NDArray

from tests.ledger.cases import both, vehicles
from tests.ledger.computed import Computed, Value, about, rounds_to
from tvclin.boundary.optimum.two_poles import (
    duration_without_fast_pole,
    early_switch,
    longest_single_pole_duration,
    single_pole_validity,
    switch_variable,
)
from tvclin.linear.modes import all_modes, unstable_modes
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import Coefficients

RATIO = 0.1
"""beta_1/beta_2 of the text of appendix C, which says "at least ten times"."""
SLOW, FAST = 0.01, 0.5
"""Its rounded poles [1/s]."""


def path_angle_roots() -> Computed:
    """The roots of the denominator of (B5): real for both vehicles, and one near zero."""
    roots = [_quadratic(c) for c in vehicles()]
    values = (
        Value("roots", *("complex" if np.any(r.imag) else "real" for r in roots)),
        Value("real part of one", *(float(r[0].real) for r in roots)),
        Value("of the other", *(float(r[1].real) for r in roots)),
        Value("imaginary part", *(float(abs(r[0].imag)) for r in roots)),
    )
    return Computed(values, not any(np.any(r.imag) for r in roots), "")


def c1_c2_against_beta() -> Computed:
    """C1/beta and C2/beta^3; "much smaller" is below a tenth."""
    first = both("C1/beta", lambda c: c.C1 / c.beta)
    second = both("C2/beta^3", lambda c: c.C2 / c.beta**3)
    return Computed((first, second), all(abs(n) < 0.1 for n in (*first.numbers, *second.numbers)))


def fast_root_over_beta() -> Computed:
    """The fast roots of (B7) over beta; "at" is within a tenth."""
    up = both("unstable", lambda c: _cubic(c)[0] / c.beta)
    down = both("stable", lambda c: _cubic(c)[-1] / c.beta)
    close = about(1, *up.numbers, last=0.1) and about(-1, *down.numbers, last=0.1)
    return Computed((up, down), close, "beta")


def slow_root_of_both() -> Computed:
    """C2/beta^2 of (B7)."""
    root = both("", lambda c: c.C2 / c.beta**2)
    return Computed((root,), rounds_to(0.01, *root.numbers, last=0.01), "1/s")


def slow_e_folding_time() -> Computed:
    """One over the slow root of (B7), over which a wind of 10 s is short: below a fifth of it."""
    time = both("e-folding time", lambda c: 1.0 / _cubic(c)[1])
    return Computed((time,), all(t > 5.0 * 10.0 for t in time.numbers), "s")


def ratio_of_the_unstable_poles() -> Computed:
    """The unstable poles of (B7), fast over slow."""
    ratio = both("", lambda c: 1.0 / _ratio(c))
    return Computed((ratio,), all(r >= 10.0 for r in ratio.numbers))


def largest_x_below_one() -> Computed:
    """The solution of (C6) over y from 0 to 1, for poles ten times apart."""
    largest = max(switch_variable(y, RATIO) for y in np.linspace(0.0, 1.0, 101))
    return Computed((Value("", largest),), largest <= 0.001)


def x_for_large_y() -> Computed:
    """The solution of (C6) at y = 10, the printed form, and the corrected one; within 1 percent."""
    y = 10.0
    root, printed = switch_variable(y, RATIO), (y - 1.0) / (2.0 * y)
    values = (
        Value("root at y = 10, poles 10 apart", root),
        Value("printed form", printed),
        Value("corrected form, (y - 1 + 2^(1 - r))/(2 y)", float(early_switch(y, RATIO))),
    )
    return Computed(values, abs(printed / root - 1.0) < 0.01)


def y_for_short_winds() -> Computed:
    """The limit of (C8) for tau to zero: below 0.1 as printed, and with the K1_i."""
    printed = both("as printed", _ratio)
    right = both("with the K1_i", lambda c: _K1_ratio(c) * _ratio(c))
    return Computed((right, printed), all(n < 0.1 for n in (*right.numbers, *printed.numbers)))


def y_for_long_winds() -> Computed:
    """The limit of (C8) for a long wind: 10 or more as printed, and with the K1_i."""
    printed = both("as printed", lambda c: 1.0 / _ratio(c))
    right = both("with the K1_i", lambda c: _K1_ratio(c) / _ratio(c))
    return Computed((right, printed), all(n >= 10.0 for n in (*right.numbers, *printed.numbers)))


def single_pole_duration() -> Computed:
    """Where y = 1: eq (C9), its logarithm to first order, and the exact poles with the K1_i."""
    duration = float(duration_without_fast_pole(SLOW, FAST))
    values = (
        Value("(C9)", duration),
        Value("without its neglect", float(longest_single_pole_duration(SLOW, FAST))),
        Value("to first order", 2.0 / SLOW * float(np.sqrt(SLOW / FAST))),
        both("exact roots, with the K1_i", single_pole_validity),
    )
    return Computed(values, rounds_to(28, duration), "s")


def single_pole_tau_beta() -> Computed:
    """The former times the fast pole, or beta."""
    tau_beta = FAST * float(duration_without_fast_pole(SLOW, FAST))
    exact = both("exact roots, with the K1_i", lambda c: c.beta * single_pole_validity(c))
    return Computed((Value("(C9)", tau_beta), exact), rounds_to(14, tau_beta))


def _quadratic(c: Coefficients) -> NDArray[np.complex128]:
    """The roots of the denominator of (B5), the larger first."""
    half = -float(c.C1) / 2.0
    return half + np.array([-1.0, 1.0]) * np.sqrt(complex(half**2 - float(c.q)))


def _cubic(c: Coefficients) -> list[float]:
    """The three real roots of (B7), falling."""
    return [float(root) for root in np.real(all_modes(Plant(c, "drift-exact")).poles)]


def _ratio(c: Coefficients) -> float:
    fast, slow, _ = _cubic(c)
    return slow / fast


def _K1_ratio(c: Coefficients) -> float:
    """K1_1/K1_2, slow over fast."""
    modes = unstable_modes(Plant(c, "drift-exact"))
    fast, slow = modes.wind_residues / modes.deflection_residues
    return float(slow / fast)


FUNCTIONS = (
    path_angle_roots,
    c1_c2_against_beta,
    fast_root_over_beta,
    slow_root_of_both,
    slow_e_folding_time,
    ratio_of_the_unstable_poles,
    largest_x_below_one,
    x_for_large_y,
    y_for_short_winds,
    y_for_long_winds,
    single_pole_duration,
    single_pole_tau_beta,
)
