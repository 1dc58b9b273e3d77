"""The least peak of appendix C for a batch: a formula for one pole, for two, and for one pair.

Control begins with the wind. Only the peak is computed, not its deflection; other plants are solved
in a loop by `optimum_deflection`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tvclin.base.errors import broadcast, instance
from tvclin.boundary.optimum.constraints import conditions
from tvclin.boundary.optimum.minimum_peak import optimum_of
from tvclin.boundary.recoverable import least_reach
from tvclin.kernels.choice import run
from tvclin.kernels.remaining_integrals import ONSET_COMPILED, ONSET_PLAIN, onset_integrals
from tvclin.linear.modes import separated_poles, unstable_poles, wind_over_deflection
from tvclin.linear.plant import PLANT_HINT, Plant
from tvclin.numerics.pieces import kernel_arrays
from tvclin.numerics.searches import grid_minimum
from tvclin.winds.histories import History
from tvclin.winds.pulses import check_end

_SPANS = (3.0, 5.0, 8.0, 12.0, 18.0, 25.0)
"""Normalised times p T that are tried for a proof that a peak is sufficient."""
_FINER_SPANS = tuple(float(span) for span in range(1, 31))
"""Normalised times p T that are tried where `_SPANS` prove nothing."""
_RELATIVE_ROUNDING = 1e-10
"""Rounding of a proved peak, relative to it."""
_DIRECTIONS = 128
"""Directions of lambda on a grid for the dual of a pair, before the best is refined."""


def least_peaks(plant: Plant, wind: History, sufficient: FloatArray | None = None) -> FloatArray:
    """Return the peak [rad] of `optimum_deflection` from the onset of the wind on, for each case.

    `wind`: one wind or a batch, of winds that end; batches broadcast. `sufficient`: peaks [rad],
    which broadcast with the batch. With three poles, where this peak is proved to be no less than
    the minimum, it is returned in its place: the search takes a tenth of a second. Returned: of the
    shape of the batch; zero without an unstable pole, and infinite where the deflection does not
    reach one. `InputError` for a wind that is zero or never ends.

    With z_i = p_i d_i, d_i of eq (C1): one pole needs ``|z|``, two real ones the reach on whose
    edge (z_1, z_2) lies, eqs (C5), (C6); a pair the largest lambda . d over the L1 norm of
    lambda . e, over the directions of lambda.
    """
    instance("plant", plant, Plant, PLANT_HINT)
    instance("wind", wind, History, "such as TriangularWind")
    shape = broadcast(plant=plant.batch, wind=wind.batch)
    check_end(wind)
    poles = separated_poles(unstable_poles(plant))
    count = poles.shape[-1]
    if not count:
        return np.zeros(shape)
    peaks = None
    if sufficient is not None and count > 2:
        shape = np.broadcast_shapes(shape, np.shape(sufficient))
        peaks = np.broadcast_to(sufficient, shape).ravel()
    strength = np.broadcast_to(wind_over_deflection(plant, poles), (*shape, count)).reshape(
        -1, count
    )
    poles = np.broadcast_to(poles, (*shape, count)).reshape(-1, count)
    with np.errstate(invalid="ignore"):
        demands = -strength * _moments(wind, poles, shape)
    return peaks_of(poles, demands, peaks).reshape(shape)


def peaks_of(
    poles: AnyArray, demands: AnyArray, sufficient: FloatArray | None = None
) -> FloatArray:
    """Return the least peaks [rad] that satisfy the demands of modes, ``(n,)``.

    `poles`: `separated_poles` [1/s], the fastest first, ``(n, m)``; NaN for no pole;
    a pair has both. `demands`: d_i of eq (C1) from the start of the control on [rad s],
    ``(n, m)``; infinite where the deflection does not reach a pole. `sufficient`: peaks
    [rad] as for `least_peaks`, ``(n,)``.
    """
    present = ~np.isnan(poles)
    unreachable = np.any(present & ~np.isfinite(demands), axis=-1)
    number = present.sum(axis=-1)
    pair = (number == 2) & (np.imag(poles[:, 0]) != 0.0)
    peaks = np.where(unreachable, np.inf, 0.0)
    single = (number == 1) & ~unreachable
    peaks[single] = np.abs(np.real(poles[single, 0] * demands[single, 0]))
    two = (number == 2) & ~pair & ~unreachable
    if np.any(two):
        p, d = np.real(poles[two, :2]), np.real(demands[two, :2])
        z = p * d
        peaks[two] = least_reach(z[:, 0], z[:, 1], p[:, 1] / p[:, 0])
    pair &= ~unreachable
    if np.any(pair):
        peaks[pair] = _of_pairs(poles[pair, 0], demands[pair, 0])
    search = (number > 2) & ~unreachable
    if sufficient is not None and np.any(search):
        candidates = np.flatnonzero(search & (number == 3) & (np.imag(poles[:, 0]) == 0.0))
        proved = _is_sufficient(poles[candidates], demands[candidates], sufficient[candidates])
        peaks[candidates[proved]] = sufficient[candidates[proved]]
        search[candidates[proved]] = False
    for k in np.flatnonzero(search):
        upper = present[k] & (np.imag(poles[k]) >= 0.0)
        case_poles, case_demands = poles[k, upper], demands[k, upper]
        if not np.any(np.imag(case_poles)):  # of a batch with pairs
            case_poles, case_demands = np.real(case_poles), np.real(case_demands)
        peaks[k] = optimum_of(conditions(case_poles, case_demands)).peak
    return peaks


def _moments(wind: History, poles: AnyArray, shape: tuple[int, ...]) -> AnyArray:
    """Return the Laplace transforms of the winds from their onset at the poles, ``(n, m)``."""
    winds, which = kernel_arrays(wind.pieces, shape)
    filled = np.where(np.isnan(poles), 1.0, poles)  # NaN stands for a pole that is not there
    transforms = np.empty(filled.shape, dtype=np.result_type(filled, winds[1]))
    knots = transforms.size * winds[0].shape[-1]
    work = (winds, which, np.ascontiguousarray(filled), transforms)
    run(onset_integrals, work, which.size, ONSET_PLAIN * knots, ONSET_COMPILED * knots)
    return transforms if np.iscomplexobj(filled) else np.real(transforms)


def _is_sufficient(poles: AnyArray, demands: AnyArray, peak: FloatArray) -> BoolArray:
    """Return whether a peak is proved to suffice for a real pole p and two others, ``(n,)``.

    `poles` and `demands`: ``(n, 3)``. Let a constant deflection c act up to T, and the optimal one
    of the two other poles from then on, whose moment at p is at most peak e^(-p T)/p. That bounds c
    to an interval. If at both its ends the two other poles require no more than the peak, a c of
    the interval satisfies all conditions.
    """
    proved = _proved(poles, demands, peak, _SPANS, _bound_of_pairs)
    unproved = np.flatnonzero(~proved)
    proved[unproved] = _proved(
        poles[unproved], demands[unproved], peak[unproved], _FINER_SPANS, _of_pairs
    )
    return proved


def _proved(
    poles: AnyArray,
    demands: AnyArray,
    peak: FloatArray,
    spans: tuple[float, ...],
    of_pairs: Callable[[AnyArray, AnyArray], FloatArray],
) -> BoolArray:
    """Return whether a time T = span/p proves the peak, ``(n,)``; `of_pairs` bounds a pair's."""
    p, others = np.real(poles[:, 0]), poles[:, 1:]
    rate, paired = np.real(others), np.imag(others[:, 0]) != 0.0
    proved = np.zeros(p.shape, dtype=bool)
    for span in spans:
        died, propagated = np.exp(-span), np.exp(-others * (span / p)[:, np.newaxis])
        fits = np.ones(p.shape, dtype=bool)
        for sign in (-1.0, 1.0):
            # c (1 - e^(-p T))/p = d +/- peak e^(-p T)/p; for the others c (1 - e^(-s T))/s is done,
            # and the rest is counted from T.
            c = (p * np.real(demands[:, 0]) + sign * peak * died) / (1.0 - died)
            with np.errstate(all="ignore"):  # what is no number is not proved
                done = c[:, np.newaxis] * (1.0 - propagated) / others
                rest = (demands[:, 1:] - done) / propagated
            z = rate * np.real(rest)
            later = least_reach(z[:, 0], z[:, 1], rate[:, 1] / rate[:, 0])
            later[paired] = of_pairs(others[paired, 0], rest[paired, 0])
            fits &= np.maximum(np.abs(c), later) <= peak * (1.0 + _RELATIVE_ROUNDING)
        proved |= fits
    return proved


def _bound_of_pairs(poles: AnyArray, demands: AnyArray) -> FloatArray:
    """Return an upper bound of `_of_pairs`, ``(n,)``: the demand over a lower bound of the norms.

    min integral |Re(e^(-s u - j phi))| du  >=  (1/sigma - 1/|sigma + 2j omega|)/2
    """
    sigma, omega = np.real(poles), np.imag(poles)
    return np.abs(demands) / (0.5 * (1.0 / sigma - 1.0 / np.hypot(sigma, 2.0 * omega)))


def _of_pairs(poles: AnyArray, demands: AnyArray) -> FloatArray:
    """Return the least peaks of complex pairs ``(n,)``, by the dual.

    For lambda of the direction phi, lambda . e = e^(-sigma u) cos(omega u + phi), and

        peak = max over phi of |Re(d e^(-j phi))| / integral e^(-sigma u) |cos(omega u + phi)| du
    """
    k = np.real(poles) / np.imag(poles)

    def negative(zero: FloatArray, i: IndexArray) -> FloatArray:
        """Return minus the quotient at phi = pi/2 - zero, times (sigma^2 + omega^2)/omega."""
        toward = np.abs(np.real(demands[i, np.newaxis] * np.exp(1j * (zero - 0.5 * np.pi))))
        return -toward / _norm(zero, k[i, np.newaxis])

    # Pairs that are nearly real turn within about 1/k of phi = pi/2.
    fine = np.geomspace(1e-8, np.pi, _DIRECTIONS)
    grid = np.sort(np.concatenate([np.linspace(0.0, np.pi, _DIRECTIONS), fine]))
    pairs = np.arange(k.size)
    values = negative(grid, pairs)
    best = np.argmin(values, axis=-1)
    value = values[pairs, best]
    inner = np.flatnonzero((best > 0) & (best < grid.size - 1))
    if inner.size:
        ends = (grid[best[inner] + step] for step in (-1, 1))
        _, refined = grid_minimum(lambda zero: negative(zero, inner), *ends)
        value[inner] = np.minimum(value[inner], refined)
    return -value * np.imag(poles) * (1.0 + k**2)


def _norm(zero: FloatArray, k: FloatArray) -> FloatArray:
    """Return the integral of e^(-k x) ``|cos(x + phi)|`` over x > 0, times 1 + k^2.

    `zero`: the first zero x = pi/2 - phi. The integral is exact up to there, and from there on a
    geometric series of half waves.
    """
    series = (1.0 + np.exp(-k * np.pi)) / -np.expm1(-k * np.pi)
    return np.exp(-k * zero) * (1.0 + series) - np.cos(zero) + k * np.sin(zero)
