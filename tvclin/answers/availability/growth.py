"""Growth of a wind, or of its required deflection, between the balloon and the launch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import (
    InputError,
    finite,
    fraction,
    nonnegative,
    number,
    one_of,
    one_row,
    positive,
    small_angle,
)

HALF_DAY = 12.0
"""Time between the soundings of most stations [h]."""


@dataclass(frozen=True, eq=False)
class WindGrowth:
    """A wind speed that is added against the vehicle, with the sign that requires more.

    Parameters
    ----------
    speed : array_like
        Wind speed [m/s], a number for all heights, or one for each of `height`.
    height : array_like, optional
        Heights [m], ascending, straight lines between them; beyond them the nearest.

    Raises
    ------
    InputError
        For negative speeds, and rows of different lengths.
    """

    speed: ArrayLike
    height: ArrayLike | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "speed", nonnegative("speed", self.speed, "m/s"))
        if self.height is None:
            number("speed", self.speed, unit="m/s")
            return
        height = one_row("height", self.height, "m")
        if np.shape(self.speed) != height.shape or np.any(np.diff(height) <= 0.0):
            raise InputError("height must ascend, with one speed for each; check both rows")
        object.__setattr__(self, "height", height)

    def at(self, height: ArrayLike) -> FloatArray:
        """Return the speed [m/s] at heights [m], in their shape."""
        heights, speed = finite("height", height, "m"), np.asarray(self.speed)
        if self.height is None:
            return np.full(heights.shape, speed)
        return np.asarray(np.interp(heights, np.asarray(self.height), speed))


@dataclass(frozen=True)
class PairGrowth:
    """Growth of the requirement until launch, from pairs of soundings of the archive 12 h apart.

    It is the quantile of need(later) - need(earlier) over all pairs 12 h apart, times
    (hours/12)^(1/3): differences of winds grow with the interval as a spectrum with the power -5/3
    has it.

    Parameters
    ----------
    hours : float
        Time from the balloon to the launch [h].
    quantile : float
        Quantile over the pairs, in (0, 1).

    Raises
    ------
    InputError
        For numbers out of range.
    """

    hours: float = HALF_DAY
    quantile: float = 0.95

    def __post_init__(self) -> None:
        object.__setattr__(self, "hours", number("hours", self.hours, positive, "h"))
        object.__setattr__(self, "quantile", fraction("quantile", self.quantile))


def growth_of(persistence: Any) -> float | WindGrowth | PairGrowth:
    """Return persistence as an angle [rad], zero for None, or as a growth of winds or pairs."""
    if persistence is None:
        return 0.0
    if isinstance(persistence, WindGrowth | PairGrowth):
        return persistence
    if isinstance(persistence, str):
        one_of("persistence", persistence, ("pairs",))
        return PairGrowth()
    return number("persistence", persistence, small_angle("an angle", nonnegative), "rad")


def grown_by(
    growth: PairGrowth, need: FloatArray, times: NDArray[np.datetime64]
) -> tuple[FloatArray, int]:
    """Return the growth [rad] of requirements, ``(a,)``, and the number of pairs.

    `need`: required deflections [rad], ``(a, n)`` for azimuths and soundings.

    `InputError` where no two soundings are twelve hours apart.
    """
    minutes = times.astype("datetime64[m]").astype(np.int64)
    order = np.argsort(minutes, kind="stable")
    later = np.searchsorted(minutes[order], minutes[order] + round(60 * HALF_DAY))
    has_later = later < times.size
    earlier, partner = order[has_later], order[later[has_later]]
    pairs = minutes[partner] - minutes[earlier] == round(60 * HALF_DAY)
    grown = need[:, partner[pairs]] - need[:, earlier[pairs]]
    grown = grown[:, ~np.isnan(grown).any(axis=0)]
    if not grown.shape[1]:
        raise InputError(
            "persistence from pairs needs soundings 12 h apart that can be judged; there are"
            " none, so give an angle [rad]"
        )
    scale = (growth.hours / HALF_DAY) ** (1 / 3)
    return scale * np.quantile(grown, growth.quantile, axis=1), grown.shape[1]
