"""Two real unstable poles: eqs (C5) to (C9), and the range of the single-pole theory.

    y = beta1 D1/(beta2 D2),   r = beta1/beta2,   x = e^(-beta2 t_s)

with beta1 the slow pole, beta2 the fast one, and t_s the time of the single switch.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray, IndexArray
from tvclin.base.errors import plain
from tvclin.linear.modes import unstable_modes
from tvclin.linear.plant import Plant
from tvclin.numerics.searches import roots_between
from tvclin.vehicle.coefficients import Coefficients

_MAX_DECAY_TIMES = 60.0
"""Largest switch time, in e-folding times: e^(-60) is far below the rounding of any condition."""


def switch_time(
    poles: tuple[float, float], demands: tuple[float, float], horizon: float = np.inf
) -> float:
    """Return the time t_s [s] after the start at which the optimum changes its sign; inf if never.

    `poles`: two different positive poles p_i [1/s], in any order. `demands`: d_i [rad s], moments
    of the deflection with e^(-p_i t) that cancel the poles' modes, not both zero. `horizon`: H [s],
    time at which the deflection becomes zero; infinite for a deflection without end. With
    c_i = p_i d_i, E_i = e^(-p_i t_s) and F_i = e^(-p_i H), eqs (C5) of the report say

        c1 (1 - 2 E2 + F2) = c2 (1 - 2 E1 + F1).

    The difference of the two sides has opposite values at t_s = 0 and t_s = H, and one zero between
    them whatever the signs and sizes of c_i: any direction meets the border of the convex set of
    attainable moments once. Nothing is divided by c_i, and y = c1/c2 = 1 is no special point: the
    switch moves to infinity on one side of it and comes back from zero on the other.
    """
    c = [pole * demand for pole, demand in zip(poles, demands, strict=True)]

    def excess(t: float) -> float:
        """Return the left minus the right side of eq (C5) for a switch at `t` [s].

        Each 1 - 2 E + F is a fixed term and one that moves with `t`, subtracted separately, so that
        equal fixed terms cancel exactly.
        """
        # poles[0] has E1 and F1, and by eq (C5) stands with c2 = c[1]
        (fixed1, moving1), (fixed2, moving2) = (_moment_terms(pole, t, horizon) for pole in poles)
        return (c[0] * fixed2 - c[1] * fixed1) + (c[0] * moving2 - c[1] * moving1)

    # beyond this time the switch no longer moves either side
    last = min(horizon, _MAX_DECAY_TIMES / min(poles))
    at_start, at_end = excess(0.0), excess(last)
    if at_start == 0.0 or at_start * at_end >= 0.0:
        return np.inf  # no sign change: no switch
    # `roots_between` finds zeros of functions that rise
    rising = lambda t, _: np.array([np.sign(at_end) * excess(float(t[0]))])  # noqa: E731
    return float(roots_between(np.zeros(1), np.array([last]), rising)[0])


def _moment_terms(pole: float, t: float, horizon: float) -> tuple[float, float]:
    """Return 1 - 2 E + F as a constant and a term that moves with the switch, of one pole.

    It is the moment of a switched deflection times p, E = e^(-p t) and F = e^(-p H). `pole`: p
    [1/s]. `t`: switch time [s]. `horizon`: H [s]. For an early switch both terms are differences
    from t = 0 and H = 0, e^(-p H) - 1 and 2 (1 - e^(-p t)), without cancellation.
    """
    if pole * t < 0.5:
        return math.expm1(-pole * horizon), -2.0 * math.expm1(-pole * t)
    return 1.0 + math.exp(-pole * horizon), -2.0 * math.exp(-pole * t)


def switch_variable(y: float, ratio: float) -> float:
    """Return x = e^(-beta2 t_s) in [0, 1], t_s being the switch time, by eq (C6) of the report.

    `y`: beta1 D1/(beta2 D2), of any sign and size, of slow pole beta1, fast pole beta2 [1/s] and
    demands D1, D2 [rad s], the integrals of e^(-beta_i t) times the deflection by eq (C1). `ratio`:
    r = beta1/beta2, between 0 and 1.

    2 x^r - 2 x y = 1 - y. At y = 1 it is x = 0: there is no switch.

    Examples
    --------
    >>> round(switch_variable(10.0, 0.1), 5)
    0.5441
    """
    return float(np.exp(-switch_time((ratio, 1.0), (y / ratio, 1.0))))


def early_switch(y: FloatArray, ratio: float) -> FloatArray:
    """Return the approximation of x = e^(-beta2 t_s), t_s being the switch time, for a large y.

        x = (y - 1 + 2^(1 - r))/(2 y)

    `y`, `ratio`: as in `switch_variable`, y positive. It follows from one step of eq (C6) of the
    report at x = 1/2; printed is (y - 1)/(2y), which is too small. For y -> infinity the peak goes
    to beta1 D1/(2^(1 - r) - 1).
    """
    return (y - 1.0 + 2.0 ** (1.0 - ratio)) / (2.0 * y)


def longest_single_pole_duration(
    beta1: ArrayLike, beta2: ArrayLike, K1_ratio: ArrayLike = 1.0
) -> Any:
    """Return the duration tau [s] of a triangular wind at which y = 1, by eq (C8) of the report.

        y = (K1_1/K1_2) (beta2/beta1) ((1 - e^(-tau beta1/2))/(1 - e^(-tau beta2/2)))^2

    y is the ratio of the peaks that the slow pole beta1 and the fast pole beta2 require alone. Up
    to there the fast pole alone decides the minimum peak, nearly. The print omits the ratio of the
    drift factors K1_1/K1_2. y rises with the duration from K1_ratio beta1/beta2 to
    K1_ratio beta2/beta1; NaN is returned where it is never 1.

    `beta1`, `beta2`: slow and fast unstable pole [1/s], positive. `K1_ratio`: K1_1/K1_2, the
    factors by which the drift multiplies both peaks; 1 without drift.

    Examples
    --------
    >>> round(longest_single_pole_duration(0.01, 0.5), 3)
    30.479
    """
    b1, b2, K = np.broadcast_arrays(beta1, beta2, K1_ratio)
    reached = (b1 < K * b2) & (K * b1 < b2)  # y is 1 at some duration
    # y is larger than without the fast pole's exponential, eq (C9): its root comes no later
    latest = np.where(reached, duration_without_fast_pole(b1, b2, np.where(reached, K, 1.0)), 1.0)
    shape, latest = b1.shape, np.ravel(latest)
    b1, b2, K = b1.ravel(), b2.ravel(), K.ravel()

    def excess(tau: FloatArray, k: IndexArray) -> FloatArray:
        """Return sqrt(y) - 1 by eq (C8) for durations `tau` [s] of the vehicles with indices `k`.

        y is the ratio of the peaks that the slow pole b1 [1/s] and the fast pole b2 require, and K
        the ratio of the factors by which the drift multiplies these peaks.
        """
        quotient = np.expm1(-tau * b1[k] / 2.0) / np.expm1(-tau * b2[k] / 2.0)
        return np.asarray(np.sqrt(K[k] * b2[k] / b1[k]) * quotient - 1.0)

    duration = roots_between(latest * 1e-12, latest * (1.0 + 1e-9), excess).reshape(shape)
    return plain(np.where(reached, duration, np.nan))


def duration_without_fast_pole(
    beta1: ArrayLike, beta2: ArrayLike, K1_ratio: ArrayLike = 1.0
) -> Any:
    """Return the duration tau [s] at which y = 1 if e^(-tau beta2/2) is neglected, eq (C9).

        1 - e^(-tau beta1/2) = sqrt(beta1/(K1_ratio beta2))

    y is the peak that the slow pole `beta1` [1/s] requires in a triangular wind over the fast
    pole's, `beta2` (report, appendix C); NaN where y is never 1. `K1_ratio`: factor of the drift
    on the slow pole's peak over its factor on the other, see `longest_single_pole_duration`.

    Examples
    --------
    >>> round(duration_without_fast_pole(0.01, 0.5), 3)
    30.495
    """
    b1, b2, K = np.broadcast_arrays(beta1, beta2, K1_ratio)
    root = np.sqrt(b1 / (K * b2))
    reached = root < 1.0
    return plain(np.where(reached, -2.0 / b1 * np.log1p(-np.where(reached, root, 0.0)), np.nan))


def single_pole_validity(coefficients: Coefficients) -> Any:
    """Return the duration [s] up to which a single-pole boundary holds in triangular winds.

    Parameters
    ----------
    coefficients : Coefficients
        Of one vehicle or a batch.

    Returns
    -------
    float or ndarray
        tau [s] at which y = 1, y being the peak that the slow pole requires by itself over that of
        the fast one, with the actual poles of the third-order model and their drift factors K1;
        longer winds require markedly more deflection than the fast pole alone requires. NaN for a
        vehicle without two real unstable poles.

    Examples
    --------
    >>> import tvclin as tv
    >>> vehicle = tv.load_vehicle("configuration-i")
    >>> round(single_pole_validity(tv.Coefficients.from_vehicle(vehicle)), 1)
    31.8
    """
    modes = unstable_modes(Plant.from_coefficients(coefficients, "drift-exact"))
    poles = modes.poles
    if poles.shape[-1] < 2:
        return plain(np.full(coefficients.batch, np.nan))
    usable = np.all((np.imag(poles) == 0.0) & ~np.isnan(poles), axis=-1)
    slow, fast = (np.where(usable, np.real(poles[..., i]), 1.0 + i) for i in (1, 0))
    with np.errstate(invalid="ignore"):  # complex NaN stands for a pole that is not there
        # B K1_i of each pole: N_wind/N_deflection of the attitude there
        K = np.real(modes.wind_residues / modes.deflection_residues)
    ratio = np.where(usable, K[..., 1] / K[..., 0], 1.0)
    usable &= ratio > 0.0
    duration = longest_single_pole_duration(slow, fast, np.where(usable, ratio, 1.0))
    return plain(np.where(usable, duration, np.nan))
