"""How many of the soundings fly, with a confidence interval for correlated days."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tvclin.base.arrays import FloatArray, IntArray
from tvclin.base.cards import Shown
from tvclin.base.documents import keyed
from tvclin.base.lines import Line, number, text

_LATEST = 124
"""Steps, up to which soundings are compared: two months of two a day."""
_NEAR = 0.25
"""Of a step, by which two soundings may be closer or farther apart."""


@dataclass(frozen=True)
class Part(Shown):
    """The part of soundings in which a limit is enough, with its confidence interval.

    Attributes
    ----------
    flown, judged, unknown : int
        Those that fly, of how many, and how many there are beside of which it is not known.
    effective : float
        As many independent soundings would say as much.
    lower, upper : float
        The interval; NaN where nothing is judged.
    confidence : float
        Of the interval.
    """

    flown: int
    judged: int
    unknown: int
    effective: float
    lower: float
    upper: float
    confidence: float

    as_dict = keyed(
        "flown judged unknown part lower upper effective_number=effective whatever_unknown=bounds"
    )

    @property
    def part(self) -> float:
        """Those that fly over those that are judged; NaN where there is none."""
        return self.flown / self.judged if self.judged else float("nan")

    @property
    def bounds(self) -> tuple[float, float]:
        """The same if all of the unknown were lost, and if all of them flew."""
        every = self.judged + self.unknown
        if not every:
            return float("nan"), float("nan")
        return self.flown / every, (self.flown + self.unknown) / every

    @property
    def line(self) -> Line:
        """The part in one sentence."""
        unknown = (*number("availability.unknown", self.unknown, 0), " unknown")
        if not self.judged:
            return ("none judged, ", *unknown)
        share = {"part": self.part, "lower": self.lower, "upper": self.upper}
        share |= dict(zip(("least", "most"), self.bounds, strict=True))
        of = {k: number(f"availability.{k}_percent", 100.0 * x, 1) for k, x in share.items()}
        apart: Line = (" (", *of["least"], " to ", *of["most"], " % whatever they were)")
        return (
            *number("availability.flown", self.flown, 0),
            " of ",
            *number("availability.judged", self.judged, 0),
            " flown",
            *((", ", *unknown) if self.unknown else ()),
            ": ",
            *(*of["part"], " %"),
            *(apart if self.unknown else ()),
            f"; {100 * self.confidence:g} % interval ",
            *(*of["lower"], " to ", *of["upper"], " %, as of "),
            *number("availability.effective", self.effective, 0),
            " independent ones",
        )

    def __str__(self) -> str:
        """In one sentence."""
        return text(self.line)


def part_of(
    flies: FloatArray,
    need: FloatArray,
    times: NDArray[np.datetime64],
    season: IntArray,
    confidence: float,
) -> Part:
    """Return how many fly, with the interval of a confidence.

    `flies` is 1 for those that fly, 0 for those that do not, NaN for unknown; `need` what they ask
    for [rad], by which days are compared if all of them fly, or none; only soundings of one
    `season`, the month of a year, are compared; each ``(n,)``. The interval is that of Clopper and
    Pearson for n/(1 + 2 sum of the autocorrelations) cases, up to the first that is not positive.
    """
    from scipy.special import betaincinv  # scipy.stats takes half a second more to import

    known = ~np.isnan(flies)
    judged, flown = int(known.sum()), int(np.nansum(flies))
    unknown = flies.size - judged
    if not judged:
        return Part(0, 0, unknown, 0.0, np.nan, np.nan, confidence)
    one_of_both = 0 < flown < judged
    n = effective_number((flies if one_of_both else need)[known], times[known], season[known])
    k, missed = flown / judged * n, (1.0 - confidence) / 2.0
    lower = float(betaincinv(k, n - k + 1.0, missed)) if flown else 0.0
    upper = float(betaincinv(k + 1.0, n - k, 1.0 - missed)) if flown < judged else 1.0
    return Part(flown, judged, unknown, n, lower, upper, confidence)


def effective_number(values: FloatArray, times: NDArray[np.datetime64], season: IntArray) -> float:
    """Return as how many independent values some count that follow each other in time."""
    order = np.argsort(times, kind="stable")
    values, season = values[order], season[order]
    minutes = times[order].astype("datetime64[m]").astype(np.int64)
    away = values - np.mean(values)
    power = np.mean(away**2)
    apart = np.diff(minutes)
    apart = apart[apart > 0]
    if not apart.size or not power > 0.0 or not np.isfinite(power):
        return float(values.size)
    step = float(np.median(apart))
    sums = 0.0
    for lag in range(1, _LATEST + 1):
        later = np.searchsorted(minutes, minutes + (lag - _NEAR) * step)
        there = np.minimum(later, minutes.size - 1)
        close = np.abs(minutes[there] - minutes - lag * step) <= _NEAR * step
        pairs = close & (season[there] == season)
        if not np.any(pairs):
            break
        correlation = float(np.mean(away[pairs] * away[there[pairs]]) / power)
        if correlation <= 0.0:
            break
        sums += correlation
    return float(values.size / (1.0 + 2.0 * sums))
