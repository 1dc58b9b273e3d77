"""The cost of margins: minimum deflection of gains over the required disk margin."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.answers.least_gains.least import answered
from tvclin.answers.least_gains.record import LeastGains
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, instance, one_row, positive
from tvclin.base.quantities import WIND_KNOWN
from tvclin.boundary.limit import boundary_limit
from tvclin.boundary.optimum.minimum_peak import optimum_deflection

DEAD_BANDS = (1.0, 0.5)
"""Dead bands K of the boundaries that are shown."""


@dataclass(frozen=True, eq=False)
class GainsFront(Shown):
    """Minimum deflection over the required disk margin, with the limits of the theory.

    Attributes
    ----------
    disk_margin : ndarray
        Required disk margins, rising, ``(n,)``.
    relative : ndarray
        Minimum deflection with each disk margin, normalised by the largest trim, ``(n,)``; infinite
        where no gains have the margin.
    each : tuple of LeastGains or None
        Gains for each disk margin; None where no gains have it.
    limits : dict of str to float
        Boundaries of the report and minimum of appendix C in the worst wind, normalised by the
        largest trim.
    """

    disk_margin: FloatArray
    relative: FloatArray
    each: tuple[LeastGains | None, ...]
    limits: dict[str, float]

    @property
    def gains(self) -> tuple[str, ...]:
        """Names of the free gains."""
        return next(tuple(least.question.gains) for least in self.each if least is not None)

    @property
    def meaning(self) -> str:
        """Meaning of the deflection, "peak" or "boundary"; see `LeastGains`."""
        return next(least.meaning for least in self.each if least is not None)

    _keys = "disk_margin over_trim=relative limits"


def least_gains_front(
    found: LeastGains, disk_margin: ArrayLike = (0.4, 0.6, 0.8, 1.0, 1.2)
) -> GainsFront:
    """Return the minimum deflection of gains over the required disk margin.

    Parameters
    ----------
    found : LeastGains
        Gains for the least nozzle; all their other specifications are kept.
    disk_margin : array_like
        Disk margins, rising, ``(n,)``.

    Returns
    -------
    GainsFront
        The search at each disk margin begins near the gains of the previous disk margin.

    Raises
    ------
    InputError
        For disk margins that are not positive and rising, and when no gains have the smallest.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> wind = tv.TriangularWind(peak=0.05, duration=7.5)
    >>> gains = tv.least_deflection_gains(plant, wind, actuator=tv.Actuator(), delay=0.02)
    >>> tv.answers.least_gains_front(gains, [0.8, 1.2]).relative.round(2)
    array([1.03, 1.1 ])
    """
    instance("found", found, LeastGains, "see least_deflection_gains")
    margins = positive("disk_margin", one_row("disk_margin", disk_margin))
    if not margins.size or np.any(np.diff(margins) <= 0.0):
        raise InputError("disk_margin must be one or more rising numbers")
    question, start = found.question, found.question.point(found.autopilot)
    each: list[LeastGains | None] = []
    for margin in margins.tolist():
        criteria = question.criteria.with_limits("the front", disk_margin=margin)
        if each and each[-1] is None:
            each.append(None)
            continue
        try:
            each.append(answered(replace(question, criteria=criteria), start[np.newaxis]))
        except InputError:
            if not each:
                raise
            each.append(None)
            continue
        start = question.point(each[-1].autopilot)  # type: ignore[union-attr]
    trim = question.trims.max()
    relative = [np.inf if gains is None else gains.deflection / trim for gains in each]
    return GainsFront(margins, np.array(relative), tuple(each), _limits(found))


def _limits(found: LeastGains) -> dict[str, float]:
    """Return the boundaries and the minimum in the worst wind, normalised by the largest trim."""
    question, plant = found.question, found.question.plant.rigid
    trim, limits = question.trims.max(), {}
    for K in DEAD_BANDS:
        values: Any = [boundary_limit(plant, wind, K).deflection for wind in question.winds]
        limits[f"boundary, K = {K:g}"] = float(np.max(np.abs(values)) / trim)
    minimum = max(float(optimum_deflection(plant, wind).peak) for wind in question.winds)
    return limits | {WIND_KNOWN: minimum / trim}
