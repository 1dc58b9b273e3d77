"""The deflection of least peak when it may change only at a limited rate.

A linear program over deflections that are straight between nodes, with the exact moments of
each straight piece. The nodes are refined where the rate or the peak begins or ceases to bind.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.documents import keyed
from tvclin.base.errors import InputError, between, number, positive, shown
from tvclin.boundary.optimum.constraints import Constraints, constraints_of
from tvclin.boundary.optimum.exponential_sums import even_for
from tvclin.boundary.optimum.grid import apart
from tvclin.boundary.optimum.minimum_peak import (
    OK,
    STABLE,
    UNTOUCHED,
    Optimum,
    optimum_deflection,
)
from tvclin.boundary.optimum.rate_program import RateProgram
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History, Piecewise, linear_pieces

_RATES = (1e-15, 1e9)
"""Rates that the program can tell from none, and from any [rad/s]."""
_FEWEST_STEPS, _STEPS, _MOST_STEPS = 10, 200, 10_000
"""Steps of the program."""
_REFINEMENTS = 8
"""Programs on nodes that are made finer; `change` says how far the last one moved the peak."""
_SETTLED = 1e-8
"""A peak that changes by less than this part is found."""
_ACTIVE = 1e-7
"""A value so near to the peak, or a change so near to the full rate, is at it: the tolerance of a
linear program."""
_DECAYED = 20.0
"""Nodes reach so many times as far as the slowest pole decays in: what comes later changes the peak
by e^-20."""
_MOST_SPLIT = 40
"""Intervals that are split at a time, those of the highest price, which bounds the program."""


@dataclass(frozen=True, eq=False)
class RateLimitedOptimum(Shown):
    """The deflection of least peak under a rate limit.

    Attributes
    ----------
    peak : float
        Its largest size [rad].
    deflection : History
        The deflection [rad], straight between nodes, zero at the start; the last value is held
        for ever or to the horizon.
    rate : float
        Its largest slope [rad/s]; below the limit where that does not bind.
    unlimited_peak : float
        Peak [rad] without a rate limit, a lower bound.
    residual : float
        Largest violation of a condition (4b), relative to the sizes of its terms.
    change : float
        By how much the last refinement of the nodes lowered the peak, relative to it. The peak
        is an upper bound that falls towards the least one.
    status : str
        "ok", or in words why no deflection is needed.
    """

    peak: float
    deflection: History
    rate: float
    unlimited_peak: float
    residual: float
    change: float
    status: str

    as_dict = keyed("rate_deg_per_s peak_deg residual last_refinement=change status")
    _keys = "peak_deg unlimited_peak_deg rate_deg_per_s residual change status"


def optimum_with_rate_limit(
    plant: Plant,
    wind: History,
    rate_limit: float,
    start: float = 0.0,
    horizon: float | None = None,
    steps: int = _STEPS,
) -> RateLimitedOptimum:
    """Return the deflection of least peak whose rate stays within a limit.

    Parameters
    ----------
    plant, wind, start, horizon
        As of `optimum_deflection`. The deflection is zero at the start; with a horizon the last
        value is dropped there, whatever the rate.
    rate_limit : float
        Largest ``|delta'|`` [rad/s], positive.
    steps : int
        Number of pieces to begin with, at least 10.

    Raises
    ------
    InputError
        As `optimum_deflection`, and for a rate with which no deflection survives the wind; the
        message says which rate would do.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> wind = tv.TriangularWind(peak=-0.1, duration=7.5)
    >>> slow = tv.boundary.optimum_with_rate_limit(plant, wind, rate_limit=0.005)
    >>> round(slow.peak / tv.optimum_deflection(plant, wind).peak, 4)
    1.2836
    """
    rate = number("rate_limit", rate_limit, positive, "rad/s")
    number("rate_limit", rate, between(*_RATES), "rad/s")
    if isinstance(steps, bool) or not isinstance(steps, int) or steps < _FEWEST_STEPS:
        raise InputError(
            f"steps must be a whole number of {_FEWEST_STEPS} or more; got {shown(steps)}"
        )
    if steps > _MOST_STEPS:
        raise InputError(f"steps must be at most {_MOST_STEPS}; got {shown(steps)}")
    constraints = constraints_of(plant, wind, start, horizon)
    unlimited = optimum_deflection(plant, wind, start, horizon)
    if unlimited.peak == 0.0:
        status = UNTOUCHED if constraints.demands.size else STABLE
        return RateLimitedOptimum(0.0, unlimited.deflection, 0.0, 0.0, 0.0, 0.0, status)
    switches = unlimited.switch_times - start
    program, peak, change = _refined(constraints, switches, rate, unlimited.peak, steps)
    values = program.least_motion(peak * (1.0 + _SETTLED)) if np.isfinite(peak) else None
    if values is None:
        least = 1.001 * program.least_rate()
        raise InputError(
            "rate_limit is too small for any deflection to survive this wind; got"
            f" {np.degrees(rate):.4g} deg/s, and about {np.degrees(least):.4g} deg/s"
            f" ({least:.4g} rad/s) would do"
        )
    values *= unlimited.peak
    slopes = np.diff(values) / np.diff(program.nodes)
    deflection: History = Piecewise(
        linear_pieces(program.nodes + start, values, np.append(slopes, 0.0))
    )
    if np.isfinite(constraints.horizon):
        deflection = deflection.before(constraints.horizon + start)
    return RateLimitedOptimum(
        peak=float(np.abs(values).max()),
        deflection=deflection,
        rate=float(np.abs(slopes).max()),
        unlimited_peak=unlimited.peak,
        residual=program.residual(values),
        change=change,
        status=OK,
    )


def least_peak_at_rate(
    constraints: Constraints, unlimited: Optimum, start: float, rate: float
) -> float:
    """Return the peak [rad] of `optimum_with_rate_limit` alone; infinite where none is enough.

    `constraints`, `unlimited`: of the case, and its `optimum_deflection`, from `start` [s] on.
    The tolerance of a linear program, 1e-7 of the peak, is added to it.
    """
    switches = unlimited.switch_times - start
    _, peak, _ = _refined(constraints, switches, rate, unlimited.peak, _STEPS)
    return peak * unlimited.peak * (1.0 + _ACTIVE)


def _refined(
    constraints: Constraints, switches: FloatArray, rate: float, unit: float, steps: int
) -> tuple[RateProgram, float, float]:
    """The program on nodes fine enough, the peak in units, and its last change.

    Where the rate is too small, the peak is infinite.
    """
    nodes = _first_nodes(constraints, switches, steps)
    change, reached = np.inf, np.inf
    best = program = RateProgram(constraints, nodes, rate, unit)
    for _ in range(_REFINEMENTS):
        found = program.least_peak()
        if found is None:
            break
        peak = float(np.abs(found[0]).max())
        change = reached / peak - 1.0
        if peak < reached:
            best, reached = program, peak
        if change < _SETTLED:
            break
        program = RateProgram(constraints, _with_corners(program, *found), rate, unit)
    return best, reached, max(change, 0.0)


def _first_nodes(constraints: Constraints, switches: FloatArray, steps: int) -> FloatArray:
    """Nodes as even as can be for every pole, and at the switches without a rate limit."""
    last = min(constraints.horizon, _DECAYED / constraints.decays.min())
    share = max(steps // constraints.poles.size, 8)
    parts = [np.array([0.0, last]), switches[switches < last]]
    for pole in constraints.poles:
        parts.append(even_for(np.real(pole), last, share))
        if np.imag(pole):
            parts.append(np.linspace(0.0, last, share))
    return apart(np.minimum(np.concatenate(parts), last), 1e-9 / np.abs(constraints.poles).max())


def _with_corners(program: RateProgram, values: FloatArray, prices: FloatArray) -> FloatArray:
    """The nodes, and more in those intervals that are neither held at the peak nor at full rate.

    But not where the prices say that nothing can be gained.
    """
    nodes, peak, slope = program.nodes, np.abs(values).max(), program.rate / program.unit
    held = np.abs(values) > peak * (1.0 - _ACTIVE)
    full = np.abs(np.diff(values)) > program.steps - _ACTIVE * np.minimum(peak, program.steps)
    flat = held[:-1] & held[1:] & (values[:-1] * values[1:] > 0.0)
    decays = program.constraints.decays[:, np.newaxis]
    worth = np.abs(prices) @ np.exp(-decays * nodes[:-1]) * np.diff(nodes)
    loose = np.flatnonzero(~(flat | full) & (worth > _SETTLED * worth.max()))
    loose = loose[np.argsort(-worth[loose])[:_MOST_SPLIT]]
    left, right = nodes[loose], nodes[loose + 1]
    new = [left + (right - left) * part for part in (0.25, 0.5, 0.75)]
    for side in (peak, -peak):  # where a line of full rate through an end meets the peak
        new.append(left + np.abs(side - values[loose]) / slope)
        new.append(right - np.abs(side - values[loose + 1]) / slope)
    inside = [np.where((time > left) & (time < right), time, left) for time in new]
    fastest = np.abs(program.constraints.poles).max()
    return apart(np.concatenate([nodes, *inside]), min(1e-6 / fastest, 1e-3 * peak / slope))
