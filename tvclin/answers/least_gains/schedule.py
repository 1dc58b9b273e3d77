"""Gains for the least nozzle over a flight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.answers.least_gains.least import least_deflection_gains
from tvclin.answers.least_gains.record import LeastGains
from tvclin.base.errors import InputError, instance, times_row
from tvclin.control.autopilot.gains import GainSchedule
from tvclin.linear.plant import PLANT_HINT, Plant
from tvclin.winds.histories import History


@dataclass(frozen=True, eq=False)
class LeastSchedule:
    """Gains for the least nozzle at several flight times.

    Attributes
    ----------
    schedule : GainSchedule
        The gains, straight lines between the times.
    each : tuple of LeastGains
        Gains for the least nozzle at each time.
    """

    schedule: GainSchedule
    each: tuple[LeastGains, ...]

    @property
    def deflection(self) -> float:
        """Largest deflection of all times [rad], which the flight requires of the nozzle."""
        return max(gains.deflection for gains in self.each)


def least_gain_schedule(
    time: ArrayLike, plants: Plant, winds: History | Sequence[History], **options: Any
) -> LeastSchedule:
    """Return the gains for the least nozzle at each time of a flight.

    Parameters
    ----------
    time : array_like
        Flight times [s], rising, ``(n,)``.
    plants : Plant
        Plant at each time, ``(n,)``.
    winds, **options
        Same parameters as of `least_deflection_gains`; the winds may occur at any of the times.

    Raises
    ------
    InputError
        As `GainSchedule` and `least_deflection_gains`.

    Examples
    --------
    >>> import tvclin as tv
    >>> c = tv.Coefficients(mu_alpha=[0.1, 0.28], mu_delta=[2.0, 2.6])
    >>> wind = tv.TriangularWind(peak=0.05, duration=7.5)
    >>> least = tv.answers.least_gain_schedule(
    ...     [40.0, 66.0], tv.Plant.from_coefficients(c), wind, actuator=tv.Actuator(), crossover=2.0
    ... )
    >>> [round(gains.relative, 2) for gains in least.each]
    [1.03, 1.14]
    """
    instance("plants", plants, Plant, PLANT_HINT)
    times = times_row("time", time)
    if plants.batch != times.shape:
        raise InputError(
            f"plants must be one for each of the {times.size} times; got a batch of shape"
            f" {plants.batch}"
        )
    each = tuple(
        least_deflection_gains(plants.case(k, plants.batch), winds, **options)
        for k in range(times.size)
    )
    a0, a1, b0 = (
        np.array([getattr(least.autopilot, name) for least in each])
        for name in ("attitude_gain", "rate_gain", "alpha_gain")
    )
    gains = replace(each[0].autopilot, attitude_gain=a0, rate_gain=a1, alpha_gain=b0)
    return LeastSchedule(GainSchedule(times, gains), each)
