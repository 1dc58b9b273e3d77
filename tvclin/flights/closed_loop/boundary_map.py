"""The boundary of a law over the gain and the delay of its loop: one map for its flown margins.

With a limit L the gain may fall to where the boundary at that gain is L, and the delay may grow to
where the boundary at that delay is. The effectiveness e of the nozzle may fall to where the
boundary at the gain e is e L, if the law does not know the limit (see `flown_margins`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, nonnegative, one_row, positive, shown
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.boundary import closed_loop_boundary
from tvclin.linear.flexible import AnyPlant
from tvclin.winds.histories import History

_MOST = 2_000
"""Boundaries in a map."""


@dataclass(frozen=True, eq=False)
class BoundaryMap(Shown):
    """The boundary of a law in a wind, over gain and delay.

    Attributes
    ----------
    gains : ndarray
        Factors on what the law asks for, ``(n,)``.
    delays : ndarray
        Computing delays [s], ``(m,)``.
    limit : ndarray
        Least limit with which the law survives, over ``|B alpha_w,max|``, ``(n, m)``; infinite
        where none that was tried does.
    growth : ndarray
        How fast the loop grows near rest [1/s], ``(n, m)``; where it is positive the loop rings,
        whatever the boundary.
    full_trim : float
        ``|B alpha_w,max|`` [rad].
    """

    gains: FloatArray
    delays: FloatArray
    limit: FloatArray
    growth: FloatArray
    full_trim: float

    _keys = "gains delays_s limit_over_trim=limit"


def boundary_map(
    plant: AnyPlant,
    law: Law,
    wind: History,
    gains: ArrayLike,
    delays: ArrayLike,
    *,
    rate_limit: float = np.inf,
    actuator: Actuator | None = None,
    sample_rate: float = 100.0,
    cuts: int = 0,
    lowest: float = 0.02,
    highest: float = 2.0,
) -> BoundaryMap:
    """Return the boundary of a law over the gain and the delay of its loop.

    Parameters
    ----------
    plant, law, wind
        As of `closed_loop_boundary`.
    gains : array_like
        Factors on what the law asks for, positive and rising, ``(n,)``.
    delays : array_like
        Computing delays [s], rising, ``(m,)``.
    rate_limit, actuator, sample_rate, cuts, lowest, highest
        As of `closed_loop_boundary`.

    Raises
    ------
    InputError
        As `closed_loop_boundary`, for gains or delays that do not rise, and for more than 2000
        boundaries.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> law = tv.SaturatedLaw(tv.control.canonical_gains(plant.coefficients))
    >>> wind = tv.TriangularWind(peak=0.1, duration=8.0)
    >>> gains, delays = [1.0, 2.0, 4.0], [0.0, 0.3]
    >>> found = tv.flights.boundary_map(plant, law, wind, gains, delays, sample_rate=25)
    >>> found.limit.round(2).tolist()
    [[1.39, 1.58], [0.99, 1.05], [0.82, 0.83]]
    """
    factors = positive("gains", one_row("gains", gains))
    late = nonnegative("delays", one_row("delays", delays, "s"), "s")
    for name, row in (("gains", factors), ("delays", late)):
        if not np.all(np.diff(row) > 0.0):
            raise InputError(f"{name} must rise; got {shown(row)}")
    if factors.size * late.size > _MOST:
        raise InputError(
            f"gains and delays may make at most {_MOST} boundaries; got {factors.size} times"
            f" {late.size}"
        )
    found = [
        [
            closed_loop_boundary(
                plant,
                law,
                wind,
                rate_limit=rate_limit,
                actuator=actuator,
                sample_rate=sample_rate,
                delay=delay,
                gain=gain,
                cuts=cuts,
                lowest=lowest,
                highest=highest,
            )
            for delay in late.tolist()
        ]
        for gain in factors.tolist()
    ]
    return BoundaryMap(
        gains=factors,
        delays=late,
        limit=np.array([[one.limit for one in row] for row in found]),
        growth=np.array([[one.growth for one in row] for row in found]),
        full_trim=abs(float(plant.coefficients.B) * float(wind.peak)),
    )
