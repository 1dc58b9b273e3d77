"""Statistics of samples: quantiles and probabilities with confidence, and their drivers.

Days of an archive are correlated: the fraction that flies has an interval with the number of
independent days that have as much information.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.base.arrays import FloatArray, IntArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, fraction, whole_number
from tvclin.base.fields import derived, spec
from tvclin.base.lines import Line, number, text
from tvclin.requirement.nominal_requirement import covers

_PROBABILITY_TOLERANCE = 1e-12
"""Largest difference of a probability and a confidence that count as equal."""


def shares(probability: float, confidence: float) -> tuple[str, str]:
    """Return the labels in tables of the quantile of a sample and of its upper bound.

    `probability`, `confidence`: of the quantile, and of the bound, both in (0, 1).
    """
    percent = f"{100 * probability:g} %"
    return f"{percent} of the cases", f"{percent} of flights, {100 * confidence:g} % sure"


@dataclass(frozen=True)
class Quantile(Shown):
    """A quantile of a sample with its confidence bounds, by order statistics.

    The p-quantile is the value that is not exceeded with the probability p.

    `probability`, `confidence`: of the quantile, and of each bound. `estimate`: the sample
    quantile. `upper`, `lower`: bounds of the quantile, each with that confidence; plus and minus
    infinity if the sample is too small to bound it. `cases`: size of the sample.
    """

    probability: float = field(metadata=spec())
    confidence: float = field(metadata=spec())
    estimate: float = field(metadata=spec())
    upper: float = field(metadata=spec())
    lower: float = field(metadata=spec())
    cases: int = field(metadata=spec())

    @property
    def angles(self) -> dict[str, float]:
        """Estimate and bounds of an angle [deg] by their keys."""
        names = ("estimate", "lower", "upper")
        return {f"{name}_deg": float(np.degrees(getattr(self, name))) for name in names}

    @property
    def few_cases(self) -> str:
        """End of a sentence with the number of cases for an upper bound; empty if reached.

        It is the smallest n with 1 - p^n >= c, p being the probability of the quantile, and c the
        confidence of the bound.
        """
        sure = 1.0 - self.confidence + _PROBABILITY_TOLERANCE
        min_cases = int(np.ceil(np.log(sure) / np.log(self.probability)))
        return f": cases must be at least {min_cases}" if self.cases < min_cases else ""

    def within(self, tolerance: float) -> bool:
        """Return whether the bounds differ by at most `tolerance` times the estimate, if finite."""
        if not np.isfinite(self.estimate):  # a lost flight requires an infinite limit
            return False
        return bool(self.upper - self.lower <= tolerance * abs(self.estimate))


@dataclass(frozen=True)
class Success(Shown):
    """A probability of success, or of loss, with the ends of its Clopper-Pearson interval."""

    estimate: float = field(metadata=spec())
    lower: float = field(metadata=spec())
    upper: float = field(metadata=spec())
    confidence: float = field(metadata=spec())

    def line(self, name: str) -> Line:
        """Return the probability and its two-sided interval [%], as a line with that name."""
        ends = {"": self.estimate, "_lower": self.lower, "_upper": self.upper}
        estimate, lower, upper = (number(name + k, 100.0 * p, 2) for k, p in ends.items())
        sides = f" %, two-sided {100 * self.confidence:g} %)"
        return (*estimate, " % (", *lower, " to ", *upper, sides)


@dataclass(frozen=True)
class Driver:
    """The correlation of an input with the loss of flights.

    `rank`: rank correlation with the loss: positive where larger values are lost more often.
    `confidence`: one minus the probability that any of as many inputs without effect correlates as
    much.
    """

    rank: float
    confidence: float


def quantile_bound(
    values: ArrayLike, probability: float = 0.99865, confidence: float = 0.9
) -> Quantile:
    """Return a quantile of a sample and its one-sided bounds, whatever the distribution.

    `values`: the sample, ``(n,)``; infinite values are legal, NaN is not. `probability`,
    `confidence`: of the quantile, and of each bound.

    The r-th smallest of n values is at least the p-quantile with the probability that a binomial
    number of n and p is below r.
    """
    from scipy.special import bdtr  # scipy.stats takes half a second more to import

    sample = np.sort(np.asarray(values, dtype=float).ravel())
    if not sample.size or np.any(np.isnan(sample)):
        raise InputError("values must be a sample of one number or more, without NaN")
    p, c = fraction("probability", probability), fraction("confidence", confidence)
    n = sample.size

    def below(rank: int) -> float:
        """Return the probability that at most `rank` values lie below the quantile."""
        return float(bdtr(rank, n, p))

    # the smallest rank with the confidence c, and the largest; from zero, as in `sample`
    upper = bisect_left(range(n), c - _PROBABILITY_TOLERANCE, key=below)
    lower = bisect_right(range(n), 1.0 - c + _PROBABILITY_TOLERANCE, key=below) - 1
    return Quantile(
        probability=p,
        confidence=c,
        estimate=float(np.quantile(sample, p, method="inverted_cdf")),
        upper=float(sample[upper]) if upper < n else np.inf,
        lower=float(sample[lower]) if lower >= 0 else -np.inf,
        cases=n,
    )


def success_probability(successes: int, cases: int, confidence: float = 0.9) -> Success:
    """Return a probability of success and its two-sided Clopper-Pearson interval.

    `successes`, `cases`: number of successful cases, and of all. `confidence`: of the interval, in
    (0, 1). `InputError` for no case, more successes than cases, and another confidence.
    """
    k, n = whole_number("successes", successes), whole_number("cases", cases)
    if not 0 < n or k > n:
        raise InputError(f"successes must be at most cases, which are not zero; got {k} of {n}")
    c = fraction("confidence", confidence)
    low, high = _clopper_pearson(k, n, c)
    return Success(estimate=k / n, lower=low, upper=high, confidence=c)


def _clopper_pearson(successes: float, cases: float, confidence: float) -> tuple[float, float]:
    """Return the ends of the two-sided interval of a probability with a confidence in (0, 1).

    `successes`, `cases`: numbers of successes and of independent cases, which need not be whole.
    """
    from scipy.special import betaincinv  # scipy.stats takes half a second more to import

    k, n, tail = successes, cases, (1.0 - confidence) / 2.0
    # quantiles of beta distributions, which are those of a binomial number of k of n successes
    low = float(betaincinv(k, n - k + 1.0, tail)) if k > 0.0 else 0.0
    high = float(betaincinv(k + 1.0, n - k, 1.0 - tail)) if k < n else 1.0
    return low, high


def covers_quantile(
    limit: float, required: ArrayLike, unknown: ArrayLike, probability: float, confidence: float
) -> bool | None:
    """Return whether a limit covers the quantile of a requirement, with a confidence.

    `limit`: [rad]. `required`: requirements of cases [rad], ``(n,)``. `unknown`: whether the
    requirement of a case is not known, ``(n,)``. `probability`, `confidence`: of the quantile, and
    of its upper bound, which the limit must reach. None where the sample is too small, and where
    infinite and zero requirements of the unknown cases lead to different verdicts.
    """
    verdicts: set[bool | None] = set()
    for value in (np.inf, 0.0):
        sample = np.where(unknown, value, required)
        quantile = quantile_bound(sample, probability, confidence)
        if np.isfinite(quantile.estimate) and np.isinf(quantile.upper):
            # too small a sample for an upper bound: a limit is still refused if its probability of
            # success, by the upper end of its interval, is below `probability`
            sufficient = int(np.sum(covers(limit, sample)))
            success = success_probability(sufficient, sample.size, confidence)
            verdicts.add(False if success.upper < probability else None)
        else:
            verdicts.add(bool(covers(limit, quantile.upper)))
    return verdicts.pop() if len(verdicts) == 1 else None


def sensitivities(inputs: dict[str, FloatArray], output: ArrayLike) -> dict[str, float]:
    """Return the rank correlation of each input with the output, the strongest first.

    `inputs`: dispersed values, ``(n,)`` each. `output`: values without NaN, ``(n,)``;
    infinite values have the highest rank.

    Spearman's coefficient: its square is about the fraction of the variance of the ranks that the
    input explains by itself, when inputs are independent. Zero where input or output is constant.
    """
    result = np.asarray(output, dtype=float)
    if np.any(np.isnan(result)):
        raise InputError("output must be a sample without NaN")
    output_ranks = _ranks(result)
    correlations = {
        name: float(np.corrcoef(_ranks(values), output_ranks)[0, 1])
        if np.ptp(values) and result.min() < result.max()
        else 0.0
        for name, values in inputs.items()
    }
    return dict(sorted(correlations.items(), key=lambda item: -abs(item[1])))


def _ranks(values: ArrayLike) -> FloatArray:
    """Return the ranks of n values, from one, ``(n,)``; equal values have their mean rank.

    As `scipy.stats.rankdata`, whose import takes longer than a study.
    """
    _values, index, counts = np.unique(values, return_inverse=True, return_counts=True)
    mean_ranks = np.cumsum(counts) - 0.5 * (counts - 1.0)  # of each different value
    return mean_ranks[index]


def loss_drivers(inputs: dict[str, FloatArray], losses: ArrayLike) -> dict[str, Driver]:
    """Return the correlation of each input with the loss of flights, the strongest first.

    `inputs`: dispersed values of n flights, ``(n,)`` each. `losses`: whether a flight is lost,
    ``(n,)``. The result is empty where no flight or every flight is lost.

    `Driver.confidence` comes from the test of Mann and Whitney, exact for few flights without ties,
    times the number of inputs (Bonferroni).

    Examples
    --------
    >>> import numpy as np
    >>> from tvclin.ensembles.statistics import loss_drivers
    >>> thrust = np.linspace(0.95, 1.05, 8)
    >>> driver = loss_drivers({"thrust": thrust}, thrust < 0.98)["thrust"]
    >>> round(driver.rank, 3), round(driver.confidence, 3)
    (-0.845, 0.964)
    """
    from scipy.stats import mannwhitneyu

    which = np.asarray(losses, dtype=bool)
    if not np.any(which) or np.all(which):
        return {}

    def chance(values: FloatArray) -> float:
        """Return the probability of so strong a correlation by chance, times the number of inputs.

        `values`: values of one input, ``(n,)``, of which lost and survived flights are compared.
        """
        if not np.ptp(values):
            return 1.0
        return len(inputs) * float(mannwhitneyu(values[which], values[~which]).pvalue)

    ranks = sensitivities(inputs, which)
    return {k: Driver(rank, max(1.0 - chance(inputs[k]), 0.0)) for k, rank in ranks.items()}


_MAX_LAG_STEPS = 124
"""Largest lag of the autocorrelation, in steps of the archive: two months with two a day."""
_LAG_TOLERANCE = 0.25
"""Largest difference of the distance of two soundings from a lag, in steps of the archive."""


@dataclass(frozen=True)
class SurvivalFraction(Shown):
    """Fraction of soundings with which a limit is sufficient, with its confidence interval.

    Attributes
    ----------
    flown, judged, unknown : int
        Numbers of soundings that the limit survives, that are judged, and that are not known.
    effective : float
        Number of independent soundings with the same information.
    lower, upper : float
        Ends of the interval; NaN where nothing is judged.
    confidence : float
        Confidence of the interval.
    """

    flown: int = field(metadata=spec())
    judged: int = field(metadata=spec())
    unknown: int = field(metadata=spec())
    effective: float = field(metadata=spec(name="effective_number"))
    lower: float = field(metadata=spec())
    upper: float = field(metadata=spec())
    confidence: float

    @property
    @derived()
    def fraction(self) -> float:
        """Ratio of the soundings that fly to those that are judged; NaN where none is judged."""
        return self.flown / self.judged if self.judged else float("nan")

    @property
    @derived(name="whatever_unknown")
    def bounds(self) -> tuple[float, float]:
        """Fractions of all soundings if every unknown one were lost, and if every one flew."""
        total = self.judged + self.unknown
        if not total:
            return float("nan"), float("nan")
        return self.flown / total, (self.flown + self.unknown) / total

    @property
    def line(self) -> Line:
        """The fraction that flies with its interval, in a sentence.

        It also has the fractions with every unknown one lost and flown (`bounds`), and the number
        of independent ones with the same information (`effective`).
        """
        unknown = (*number("availability.unknown", self.unknown, 0), " unknown")
        if not self.judged:
            return ("none judged, ", *unknown)
        shares = {"part": self.fraction, "lower": self.lower, "upper": self.upper}
        shares |= dict(zip(("least", "most"), self.bounds, strict=True))
        percent = {k: number(f"availability.{k}_percent", 100.0 * x, 1) for k, x in shares.items()}
        bounds: Line = (" (", *percent["least"], " to ", *percent["most"], " % whatever they were)")
        return (
            *number("availability.flown", self.flown, 0),
            " of ",
            *number("availability.judged", self.judged, 0),
            f" {'sounding' if self.judged == 1 else 'soundings'} survived",
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


def survival_fraction(
    flies: FloatArray,
    required: FloatArray,
    times: NDArray[np.datetime64],
    season: IntArray,
    confidence: float,
) -> SurvivalFraction:
    """Return the fraction of soundings that fly, with its confidence interval.

    `flies`: 1 for a sounding that flies, 0 for one that does not, NaN for unknown. `required`:
    required deflections [rad], whose autocorrelation counts if all soundings fly, or none.
    `times`: times of the soundings. `season`: number of the month of a year; only soundings of one
    season are compared. ``(n,)`` each. `confidence`: of the interval, in (0, 1), by Clopper and
    Pearson for n/(1 + 2 sum of the autocorrelations up to the first that is not positive) cases.
    """
    judged_rows = ~np.isnan(flies)
    judged, flown = int(judged_rows.sum()), int(np.nansum(flies))
    unknown = flies.size - judged
    n, lower, upper = 0.0, np.nan, np.nan
    if judged:
        varying = 0 < flown < judged  # else all values of `flies` are alike, without a correlation
        n = effective_number(
            (flies if varying else required)[judged_rows], times[judged_rows], season[judged_rows]
        )
        lower, upper = _clopper_pearson(flown / judged * n, n, confidence)
    return SurvivalFraction(
        flown=flown,
        judged=judged,
        unknown=unknown,
        effective=n,
        lower=lower,
        upper=upper,
        confidence=confidence,
    )


def effective_number(values: FloatArray, times: NDArray[np.datetime64], season: IntArray) -> float:
    """Return the number of independent values with the information of correlated `values`.

    `values`, `times`, `season`: values, their times, and numbers of their seasons, ``(n,)`` each.
    It is n/(1 + 2 sum of the autocorrelations) for n values, over lags of whole steps of time up to
    the first correlation that is not positive; pairs are within a season. All n values count where
    they do not vary, or have one time.
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
    step = float(np.median(intervals))  # usual interval of the archive [min]
    correlations = 0.0
    for lag in range(1, _MAX_LAG_STEPS + 1):
        # the first value later than each by about this lag, and whether it is near and in season
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
