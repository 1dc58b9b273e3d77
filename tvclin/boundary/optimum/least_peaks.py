"""The least peak of appendix C for a batch: a formula for one pole, for two, and for one pair.

Control begins with the wind. Only the peak is found, not the deflection that has it; other plants
go one by one through `optimum_deflection`.
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

_SPANS, _MARGIN = (3.0, 5.0, 8.0, 12.0, 18.0, 25.0), 1e-10
"""Times p T that are tried for a proof that a peak is enough, and what is left to rounding."""
_CLOSER = tuple(float(span) for span in range(1, 31))
"""Times that are tried where those were not enough."""
_DIRECTIONS = 128
"""Directions of lambda in which the dual of a pair is looked at before the best is refined."""


def least_peaks(plant: Plant, wind: History, enough: FloatArray | None = None) -> FloatArray:
    """Return the peak [rad] of `optimum_deflection` from the onset of the wind on, for each case.

    `wind`: one wind or a batch, of winds that end; batches broadcast. `enough`: peaks [rad], which
    broadcast with the batch. With three poles, where this is proved to be no less than what is
    asked, it is returned in its place: the search takes a tenth of a second. Returned: of the shape
    of the batch; zero without an unstable pole, and infinite where the deflection does not reach
    one. `InputError` for a wind that is zero or never ends.

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
    if enough is not None and count > 2:
        shape = np.broadcast_shapes(shape, np.shape(enough))
        peaks = np.broadcast_to(enough, shape).ravel()
    strength = np.broadcast_to(wind_over_deflection(plant, poles), (*shape, count)).reshape(
        -1, count
    )
    poles = np.broadcast_to(poles, (*shape, count)).reshape(-1, count)
    with np.errstate(invalid="ignore"):
        demands = -strength * _moments(wind, poles, shape)
    return peaks_of(poles, demands, peaks).reshape(shape)


def peaks_of(poles: AnyArray, demands: AnyArray, enough: FloatArray | None = None) -> FloatArray:
    """Return the least peaks [rad] that meet the demands of modes, for each case.

    `poles`: `separated_poles` [1/s], the fastest first, ``(n, m)``; NaN where there
    is none, and both of a pair. `demands`: d_i of eq (C1) from the start of the control on [rad s],
    ``(n, m)``; infinite where the deflection does not reach a pole. `enough`: as of `least_peaks`,
    ``(n,)``.
    """
    there = ~np.isnan(poles)
    lost = np.any(there & ~np.isfinite(demands), axis=-1)
    number = there.sum(axis=-1)
    pair = (number == 2) & (np.imag(poles[:, 0]) != 0.0)
    found = np.where(lost, np.inf, 0.0)
    one = (number == 1) & ~lost
    found[one] = np.abs(np.real(poles[one, 0] * demands[one, 0]))
    two = (number == 2) & ~pair & ~lost
    if np.any(two):
        p, d = np.real(poles[two, :2]), np.real(demands[two, :2])
        z = p * d
        found[two] = least_reach(z[:, 0], z[:, 1], p[:, 1] / p[:, 0])
    pair &= ~lost
    if np.any(pair):
        found[pair] = _of_pairs(poles[pair, 0], demands[pair, 0])
    search = (number > 2) & ~lost
    if enough is not None and np.any(search):
        some = np.flatnonzero(search & (number == 3) & (np.imag(poles[:, 0]) == 0.0))
        proved = _is_enough(poles[some], demands[some], enough[some])
        found[some[proved]] = enough[some[proved]]
        search[some[proved]] = False
    for k in np.flatnonzero(search):
        upper = there[k] & (np.imag(poles[k]) >= 0.0)
        own, asked = poles[k, upper], demands[k, upper]
        if not np.any(np.imag(own)):  # of a batch with pairs
            own, asked = np.real(own), np.real(asked)
        found[k] = optimum_of(conditions(own, asked)).peak
    return found


def _moments(wind: History, poles: AnyArray, shape: tuple[int, ...]) -> AnyArray:
    """The Laplace transforms of the winds, counted from their onset, at ``poles (n, m)``."""
    winds, which = kernel_arrays(wind.pieces, shape)
    known = np.where(np.isnan(poles), 1.0, poles)  # NaN stands for a pole that is not there
    found = np.empty(known.shape, dtype=np.result_type(known, winds[1]))
    knots = found.size * winds[0].shape[-1]
    work = (winds, which, np.ascontiguousarray(known), found)
    run(onset_integrals, work, which.size, ONSET_PLAIN * knots, ONSET_COMPILED * knots)
    return found if np.iscomplexobj(known) else np.real(found)


def _is_enough(poles: AnyArray, demands: AnyArray, peak: FloatArray) -> BoolArray:
    """Whether a peak is proved to suffice for a real pole p and two others, ``(n, 3)`` of each.

    Let a constant c act up to T, and what the two others still ask for from then on. That does no
    more to the pole p than peak e^(-p T)/p. So if both ends of what c may be for that leave no more
    to be asked for than the peak, one c between them meets all conditions.
    """
    proved = _proved(poles, demands, peak, _SPANS, _most_of_pairs)
    left = np.flatnonzero(~proved)
    proved[left] = _proved(poles[left], demands[left], peak[left], _CLOSER, _of_pairs)
    return proved


def _proved(
    poles: AnyArray,
    demands: AnyArray,
    peak: FloatArray,
    spans: tuple[float, ...],
    of_pairs: Callable[[AnyArray, AnyArray], FloatArray],
) -> BoolArray:
    """Whether one of several times T proves it; `of_pairs` is what pairs take no more than."""
    p, others = np.real(poles[:, 0]), poles[:, 1:]
    rate, paired = np.real(others), np.imag(others[:, 0]) != 0.0
    proved = np.zeros(p.shape, dtype=bool)
    for span in spans:
        died, turned = np.exp(-span), np.exp(-others * (span / p)[:, np.newaxis])
        fits = np.ones(p.shape, dtype=bool)
        for side in (-1.0, 1.0):
            # c (1 - e^(-p T))/p = d +/- peak e^(-p T)/p; for the others c (1 - e^(-s T))/s is done,
            # and the rest is counted from T.
            c = (p * np.real(demands[:, 0]) + side * peak * died) / (1.0 - died)
            with np.errstate(all="ignore"):  # what is no number is not proved
                done = c[:, np.newaxis] * (1.0 - turned) / others
                rest = (demands[:, 1:] - done) / turned
            z = rate * np.real(rest)
            later = least_reach(z[:, 0], z[:, 1], rate[:, 1] / rate[:, 0])
            later[paired] = of_pairs(others[paired, 0], rest[paired, 0])
            fits &= np.maximum(np.abs(c), later) <= peak * (1.0 + _MARGIN)
        proved |= fits
    return proved


def _most_of_pairs(poles: AnyArray, demands: AnyArray) -> FloatArray:
    """A bound of `_of_pairs` that is found at once: a demand over the least of all norms.

    min integral |Re(e^(-s u - j phi))| du  >=  (1/sigma - 1/|sigma + 2j omega|)/2
    """
    sigma, omega = np.real(poles), np.imag(poles)
    return np.abs(demands) / (0.5 * (1.0 / sigma - 1.0 / np.hypot(sigma, 2.0 * omega)))


def _of_pairs(poles: AnyArray, demands: AnyArray) -> FloatArray:
    """The least peaks of complex pairs ``(n,)``, by the dual.

    For lambda of the direction phi, lambda . e = e^(-sigma u) cos(omega u + phi), and

        peak = max over phi of |Re(d e^(-j phi))| / integral e^(-sigma u) |cos(omega u + phi)| du
    """
    k = np.real(poles) / np.imag(poles)

    def negative(left: FloatArray, i: IndexArray) -> FloatArray:
        """Minus the quotient at phi = pi/2 - left, times sigma^2 + omega^2 over omega."""
        toward = np.abs(np.real(demands[i, np.newaxis] * np.exp(1j * (left - 0.5 * np.pi))))
        return -toward / _norm(left, k[i, np.newaxis])

    # Pairs that are nearly real turn within about 1/k of phi = pi/2.
    near = np.geomspace(1e-8, np.pi, _DIRECTIONS)
    grid = np.sort(np.concatenate([np.linspace(0.0, np.pi, _DIRECTIONS), near]))
    everyone = np.arange(k.size)
    looked = negative(grid, everyone)
    best = np.argmin(looked, axis=-1)
    value = looked[everyone, best]
    inner = np.flatnonzero((best > 0) & (best < grid.size - 1))
    if inner.size:
        ends = (grid[best[inner] + step] for step in (-1, 1))
        _, refined = grid_minimum(lambda left: negative(left, inner), *ends)
        value[inner] = np.minimum(value[inner], refined)
    return -value * np.imag(poles) * (1.0 + k**2)


def _norm(left: FloatArray, k: FloatArray) -> FloatArray:
    """The integral of e^(-k x) ``|cos(x + phi)|`` over x > 0, times 1 + k^2; phi = pi/2 - left.

    Up to the first zero at x = left, and from there on a geometric series of half waves.
    """
    whole = (1.0 + np.exp(-k * np.pi)) / -np.expm1(-k * np.pi)
    return np.exp(-k * left) * (1.0 + whole) - np.cos(left) + k * np.sin(left)
