"""What margins cost: the least deflection over the disk margin that is asked for."""

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


@dataclass(frozen=True, eq=False)
class GainsFront(Shown):
    """The least deflection over the disk margin that is asked for, beside the theory's limits.

    Attributes
    ----------
    disk_margin : ndarray
        The disk margins that were asked for, rising, ``(n,)``.
    relative : ndarray
        The least deflection with each over the largest trim, ``(n,)``; infinite where no gains have
        it.
    each : tuple of LeastGains or None
        The gains; None where there are none.
    limits : dict of str to float
        Over the largest trim and the worst wind: the report's boundaries and the minimum of
        appendix C.
    """

    disk_margin: FloatArray
    relative: FloatArray
    each: tuple[LeastGains | None, ...]
    limits: dict[str, float]

    @property
    def gains(self) -> tuple[str, ...]:
        """The gains that are free."""
        return next(tuple(one.question.gains) for one in self.each if one is not None)

    @property
    def meaning(self) -> str:
        """As of `LeastGains`."""
        return next(one.meaning for one in self.each if one is not None)

    _keys = "disk_margin over_trim=relative limits"


def least_gains_front(
    found: LeastGains, disk_margin: ArrayLike = (0.4, 0.6, 0.8, 1.0, 1.2)
) -> GainsFront:
    """Return the least deflection of gains over the disk margin that is required.

    Parameters
    ----------
    found : LeastGains
        Gains that were found; what was asked of them stays asked.
    disk_margin : array_like
        Disk margins, rising, ``(n,)``.

    Returns
    -------
    GainsFront
        From each disk margin to the next the search begins near the gains of the one before.

    Raises
    ------
    InputError
        For disk margins that are not positive and rising, and when no gains have the least of them.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> wind = tv.TriangularWind(peak=0.05, duration=7.5)
    >>> found = tv.least_deflection_gains(plant, wind, actuator=tv.Actuator(), delay=0.02)
    >>> tv.answers.least_gains_front(found, [0.8, 1.2]).relative.round(2)
    array([1.03, 1.1 ])
    """
    instance("found", found, LeastGains, "see least_deflection_gains")
    asked = positive("disk_margin", one_row("disk_margin", disk_margin))
    if not asked.size or np.any(np.diff(asked) <= 0.0):
        raise InputError("disk_margin must be one or more rising numbers")
    question, near = found.question, found.question.point(found.autopilot)
    each: list[LeastGains | None] = []
    for least in asked.tolist():
        criteria = question.criteria.with_limits("the front", disk_margin=least)
        if each and each[-1] is None:
            each.append(None)
            continue
        try:
            each.append(answered(replace(question, criteria=criteria), near[np.newaxis]))
        except InputError:
            if not each:
                raise
            each.append(None)
            continue
        near = question.point(each[-1].autopilot)  # type: ignore[union-attr]
    trim = question.trims.max()
    relative = [np.inf if one is None else one.deflection / trim for one in each]
    return GainsFront(asked, np.array(relative), tuple(each), _limits(found))


def _limits(found: LeastGains) -> dict[str, float]:
    """The report's boundaries and the minimum, of the worst wind, over the largest trim."""
    question, plant = found.question, found.question.plant.rigid
    trim, limits = question.trims.max(), {}
    for K in DEAD_BANDS:
        values: Any = [boundary_limit(plant, wind, K).deflection for wind in question.winds]
        limits[f"boundary, K = {K:g}"] = float(np.max(np.abs(values)) / trim)
    least = max(float(optimum_deflection(plant, wind).peak) for wind in question.winds)
    return limits | {WIND_KNOWN: least / trim}
