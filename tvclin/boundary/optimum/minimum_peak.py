"""The deflection with the smallest peak that survives a known wind, and the proof."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.documents import keyed
from tvclin.boundary.optimum import two_poles
from tvclin.boundary.optimum.constraints import Constraints, constraints_of
from tvclin.boundary.optimum.dual import best_multipliers
from tvclin.boundary.optimum.exponential_sums import Window
from tvclin.linear.deflections import BangBang, ConstantDeflection
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History, Piecewise, linear_pieces

OK = "ok"
STABLE = "no unstable pole: no deflection is needed"
UNTOUCHED = "the wind excites no unstable pole: no deflection is needed"
NOT_CONVERGED = "not converged: the certificate says how far off it is"
_MAX_GAP = 1e-9
"""Largest relative gap and residual of a certificate that proves a peak; else the status says
so."""
_RELATIVE_ROUNDING = 1e-14
"""Relative distance to the horizon below which a switch is omitted."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """A lower bound of every peak, and the peak of the deflection that it proves optimal.

    `primal`: peak [rad] of the deflection. `dual`: lambda . d over the L1 norm of lambda . e: no
    deflection that satisfies the conditions has a peak [rad] below it, whatever its shape. `gap`:
    (primal - dual)/primal. `residual`: largest violation of a condition (4b), relative to the sizes
    of its terms. `tail`: bound of the L1 norm that a truncated window omits, relative to it; it is
    included in `dual`. Zero where nothing is truncated.
    """

    primal: float
    dual: float
    gap: float
    residual: float
    tail: float

    as_dict = keyed("dual_deg gap residual tail")


@dataclass(frozen=True, eq=False)
class Optimum(Shown):
    """The deflection of least peak for one plant in one wind.

    Attributes
    ----------
    peak : float
        Largest size [rad]; zero where no deflection is required. Where the optimum was not
        reached, at least the proved lower bound: look at `status`.
    deflection : History
        The deflection [rad]: constant, or always at one of two limits, zero from a finite
        horizon on.
    switch_times : ndarray
        Times [s] at which the deflection changes its sign, ``(k,)``.
    multipliers : ndarray
        lambda [1/s], ``(n,)``, with an L1 norm of one: the derivatives of the peak by d_i. The
        functions of time e_i start at the start of the control; one for each real pole in the
        order of `unstable_modes`, two (cosine, sine) for each pair.
    certificate : Certificate
        A lower bound of every peak, and the residuals.
    status : str
        "ok", or the reason why it is not.
    """

    peak: float
    deflection: History
    switch_times: FloatArray
    multipliers: FloatArray
    certificate: Certificate
    status: str

    _keys = "peak_deg lower_bound_deg=certificate.dual switch_times_s status"


def optimum_deflection(
    plant: Plant, wind: History, start: float = 0.0, horizon: float | None = None
) -> Optimum:
    """Return the deflection of least peak that cancels every unstable mode (appendix C).

    Its peak is the lower bound with the wind known, by linear theory at nominal dynamic pressure.

    Parameters
    ----------
    plant : Plant
        One plant of any model, with any number of unstable poles.
    wind : History
        One wind that ends; it is known beforehand.
    start : float
        Start of the control t1 [s]. A late start costs a factor e^(beta t1) with one pole, an
        early one (negative) gains as much.
    horizon : float, optional
        Time [s] from which the deflection is zero again; by default it is never.

    Returns
    -------
    Optimum
        With a certificate. Compare it with `boundary_limit`, which satisfies the condition of
        the fastest real pole only.

    Raises
    ------
    InputError
        For a batch, a wind that is zero or never ends, a horizon that is not after the start or
        before the end of the wind, a start too late to be made up for, and unstable poles that
        the deflection does not reach.

    Notes
    -----
    With one pole the deflection is constant, delta = beta e^(beta t1) D; with two real ones it
    changes its sign once, eqs (C5) and (C6); with N real ones at most N - 1 times, and without
    end for a complex pair, which is followed until the rest is below 1e-12 of the norm (the
    deflection is zero from there on). In general it is the peak times the sign of lambda . e.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")
    >>> best = tv.optimum_deflection(plant, tv.TriangularWind(peak=-0.1, duration=37.787))
    >>> round(best.peak / (0.1 * plant.coefficients.B), 4), best.switch_times.round(3)
    (0.1391, array([0.284]))
    """
    return optimum_of(constraints_of(plant, wind, start, horizon), float(start))


def optimum_of(constraints: Constraints, start: float = 0.0) -> Optimum:
    """Return the deflection of least peak that satisfies the conditions, from `start` [s] on."""
    if not np.any(constraints.demands):
        zero, conditions = Piecewise(linear_pieces([start], [0.0], 0.0)), constraints.demands.size
        proof = Certificate(0.0, 0.0, 0.0, 0.0, 0.0)
        status = UNTOUCHED if conditions else STABLE
        return Optimum(0.0, zero, np.zeros(0), np.zeros(conditions), proof, status)
    window = Window(constraints)
    switches, multipliers = _solve(window)
    switches, limit = _polished(window, switches)
    deflection: History = (
        BangBang(limit=limit, switch_times=switches + start, start=start)
        if switches.size
        else ConstantDeflection(limit=limit, start=start)
    )
    if np.isfinite(window.end):
        deflection = deflection.before(window.end + start)
    certificate = certify(window, multipliers, switches, limit)
    norm = window.signed(multipliers).norm
    proved = abs(certificate.gap) < _MAX_GAP and certificate.residual < _MAX_GAP
    return Optimum(
        abs(limit) if proved else max(abs(limit), certificate.dual),
        deflection,
        switches + start,
        multipliers / norm,
        certificate,
        OK if proved else NOT_CONVERGED,
    )


def certify(
    window: Window, multipliers: FloatArray, switches: FloatArray, limit: float
) -> Certificate:
    """Return the certificate of a deflection that switches between two limits.

    `multipliers`: lambda, ``(n,)``; any of them bounds every peak from below. `switches`: switch
    times [s] after the start, ``(k,)``. `limit`: first deflection [rad].
    """
    constraints = window.constraints
    summed = window.signed(multipliers)
    beyond = window.tail(multipliers)
    dual = float(multipliers @ constraints.demands / (summed.norm + beyond))
    return Certificate(
        primal=abs(limit),
        dual=dual,
        gap=(abs(limit) - dual) / abs(limit),
        residual=_violation(window, switches, limit),
        tail=beyond / summed.norm,
    )


def _solve(window: Window) -> tuple[FloatArray, FloatArray]:
    """Return switch times [s] after the start, and multipliers of any scale, lambda . d > 0."""
    c = window.constraints
    if c.demands.size == 1:
        return np.zeros(0), np.sign(c.demands)
    if c.real and c.demands.size == 2:
        return _two_poles(c)
    best = best_multipliers(window)
    return best.zeros, best.multipliers


def _two_poles(c: Constraints) -> tuple[FloatArray, FloatArray]:
    """Return the switch time [s] of eqs (C5), and multipliers whose sum changes its sign then."""
    poles, demands = np.real(c.poles), c.demands
    time = two_poles.switch_time(tuple(poles), tuple(demands), c.horizon)
    # Without a switch before the end one constant meets both, and so their sum.
    if np.isinf(time) or time >= c.horizon * (1.0 - _RELATIVE_ROUNDING):
        return np.zeros(0), np.sign(demands)
    growth = np.exp((poles - poles.max()) * time)
    multipliers = np.array([growth[0], -growth[1]])
    return np.array([time]), multipliers * np.sign(multipliers @ demands)


def _limit(window: Window, switches: FloatArray) -> float:
    """Return the first deflection [rad] that satisfies the conditions with the switches, (C5a).

    It is a least-squares fit of all conditions, each divided by its size, to reduce rounding.
    """
    moments = _moments(window, switches).sum(axis=1) / window.sizes
    demands = window.constraints.demands / window.sizes
    return float(moments @ demands / (moments @ moments))


def _polished(window: Window, switches: FloatArray) -> tuple[FloatArray, float]:
    """Return switch times [s] and limit [rad] after Newton's iteration on the conditions.

    Times that come from nearly dependent conditions (a short horizon) are made exact to rounding.
    """
    # The moments of the deflection, limit sum of (-1)^k integral e, change with switch j by
    # 2 limit (-1)^j e(t_j), and with the limit by themselves for each relative change of it.
    limit = _limit(window, switches)
    violation = _violation(window, switches, limit)
    for _ in range(3 if switches.size else 0):
        signs = (-1.0) ** np.arange(switches.size)
        columns = [2.0 * limit * signs * window.constraints.basis(switches)]
        columns.append(limit * _moments(window, switches).sum(axis=1, keepdims=True))
        rows = np.hstack(columns) / window.sizes[:, np.newaxis]
        missing = window.constraints.demands - columns[1][:, 0]
        step = np.linalg.lstsq(rows, missing / window.sizes, rcond=None)[0]
        trial, moved = switches + step[:-1], limit * (1.0 + step[-1])
        if np.any(np.diff(trial, prepend=0.0, append=window.end) < 0.0):
            break
        if _violation(window, trial, moved) >= violation:
            break
        switches, limit, violation = trial, moved, _violation(window, trial, moved)
    return switches, float(limit)


def _violation(window: Window, switches: FloatArray, limit: float) -> float:
    """Return the largest violation of a condition, relative to the sizes of its terms."""
    demands = window.constraints.demands
    pieces = limit * _moments(window, switches)
    sizes = np.abs(pieces).sum(axis=1) + np.abs(demands)
    return float((np.abs(pieces.sum(axis=1) - demands) / sizes).max())


def _moments(window: Window, switches: FloatArray) -> FloatArray:
    """Return the moments of the pieces of a unit deflection, +1 first, ``(n, k + 1)``."""
    signs = (-1.0) ** np.arange(switches.size + 1)
    knots = np.concatenate([[0.0], switches, [window.end]])
    return window.constraints.moments(knots) * signs
