"""Fraction of soundings that fly, with a confidence interval for correlated days."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tvclin.base.arrays import FloatArray, IntArray
from tvclin.base.cards import Shown
from tvclin.base.documents import keyed
from tvclin.base.lines import Line, number, text

_MAX_LAG_STEPS = 124
"""Largest lag of the autocorrelation, in steps of the archive: two months with two a day."""
_LAG_TOLERANCE = 0.25
"""Largest difference of the distance of two soundings from a lag, in steps of the archive."""


@dataclass(frozen=True)
class Part(Shown):
    """Fraction of soundings with which a limit is sufficient, with its confidence interval.

    Attributes
    ----------
    flown, judged, unknown : int
        Numbers of soundings that fly, that are judged, and that are not known.
    effective : float
        Number of independent soundings with the same information.
    lower, upper : float
        Ends of the interval; NaN where nothing is judged.
    confidence : float
        Confidence of the interval.
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
        """Ratio of the soundings that fly to those that are judged; NaN where none is judged."""
        return self.flown / self.judged if self.judged else float("nan")

    @property
    def bounds(self) -> tuple[float, float]:
        """Fractions of all soundings if every unknown one were lost, and if every one flew."""
        total = self.judged + self.unknown
        if not total:
            return float("nan"), float("nan")
        return self.flown / total, (self.flown + self.unknown) / total

    @property
    def line(self) -> Line:
        """The fraction with its interval, in a sentence."""
        unknown = (*number("availability.unknown", self.unknown, 0), " unknown")
        if not self.judged:
            return ("none judged, ", *unknown)
        shares = {"part": self.part, "lower": self.lower, "upper": self.upper}
        shares |= dict(zip(("least", "most"), self.bounds, strict=True))
        percent = {k: number(f"availability.{k}_percent", 100.0 * x, 1) for k, x in shares.items()}
        bounds: Line = (" (", *percent["least"], " to ", *percent["most"], " % whatever they were)")
        return (
            *number("availability.flown", self.flown, 0),
            " of ",
            *number("availability.judged", self.judged, 0),
            " flown",
            *((", ", *unknown) if self.unknown else ()),
            ": ",
            *(*percent["part"], " %"),
            *(bounds if self.unknown else ()),
            f"; {100 * self.confidence:g} % interval ",
            *(*percent["lower"], " to ", *percent["upper"], " %, as of "),
            *number("availability.effective", self.effective, 0),
            " independent ones",
        )

    def __str__(self) -> str:
        """Return the fraction with its interval, in a sentence."""
        return text(self.line)


def part_of(
    flies: FloatArray,
    need: FloatArray,
    times: NDArray[np.datetime64],
    season: IntArray,
    confidence: float,
) -> Part:
    """Return the fraction of soundings that fly, with its confidence interval.

    `flies`: 1 for a sounding that flies, 0 for one that does not, NaN for unknown. `need`: required
    deflections [rad], whose autocorrelation counts if all soundings fly, or none. `season`: the
    month of a year; only soundings of the same season are compared. ``(n,)`` each. The interval is
    that of Clopper and Pearson for n/(1 + 2 sum of the autocorrelations) cases, up to the first
    that is not positive.
    """
    from scipy.special import betaincinv  # scipy.stats takes half a second more to import

    judged_rows = ~np.isnan(flies)
    judged, flown = int(judged_rows.sum()), int(np.nansum(flies))
    unknown = flies.size - judged
    if not judged:
        return Part(0, 0, unknown, 0.0, np.nan, np.nan, confidence)
    varying = 0 < flown < judged
    n = effective_number(
        (flies if varying else need)[judged_rows], times[judged_rows], season[judged_rows]
    )
    k, tail = flown / judged * n, (1.0 - confidence) / 2.0
    lower = float(betaincinv(k, n - k + 1.0, tail)) if flown else 0.0
    upper = float(betaincinv(k + 1.0, n - k, 1.0 - tail)) if flown < judged else 1.0
    return Part(flown, judged, unknown, n, lower, upper, confidence)


def effective_number(values: FloatArray, times: NDArray[np.datetime64], season: IntArray) -> float:
    """Return the number of independent values with the information of correlated `values`.

    `values`, `times`, `season`: ``(n,)``; the autocorrelation is over time within a season.
    """
    order = np.argsort(times, kind="stable")
    values, season = values[order], season[order]
    minutes = times[order].astype("datetime64[m]").astype(np.int64)
    deviation = values - np.mean(values)
    variance = np.mean(deviation**2)
    intervals = np.diff(minutes)
    intervals = intervals[intervals > 0]
    if not intervals.size or not variance > 0.0 or not np.isfinite(variance):
        return float(values.size)
    step = float(np.median(intervals))
    correlations = 0.0
    for lag in range(1, _MAX_LAG_STEPS + 1):
        later = np.searchsorted(minutes, minutes + (lag - _LAG_TOLERANCE) * step)
        partner = np.minimum(later, minutes.size - 1)
        close = np.abs(minutes[partner] - minutes - lag * step) <= _LAG_TOLERANCE * step
        pairs = close & (season[partner] == season)
        if not np.any(pairs):
            break
        correlation = float(np.mean(deviation[pairs] * deviation[partner[pairs]]) / variance)
        if correlation <= 0.0:
            break
        correlations += correlation
    return float(values.size / (1.0 + 2.0 * correlations))
