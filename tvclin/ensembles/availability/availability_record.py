"""Availability: fractions of days, curves over the limit, placards and columns, as tables."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.cards import Column, Columns, Shown, Tabled, card
from tvclin.base.fields import derived, document, spec
from tvclin.base.lines import Line, Table, degrees, minimum_limit, plural, text
from tvclin.base.lines import number as number_cell
from tvclin.ensembles.availability.judge import Judge
from tvclin.ensembles.statistics import survival_fraction
from tvclin.requirement.nominal_requirement import covers
from tvclin.winds.soundings.archive import Soundings
from tvclin.winds.soundings.profile import WindProfile

_UNKNOWN_WIND = "its wind is not known far enough"
_UNDECIDED = "its trim reaches the limit more than once, and was not flown: ask for this limit"
"""Reason for a sounding whose bounds lie on both sides of the limit."""
_LOWER_RATIO = 1.0 - 1e-9
"""Ratio of two requirements above which the lower counts as equal to the other."""
PLACARD = (0.5, 0.8, 0.9, 0.95, 0.99)
"""Fractions of the soundings whose sufficient limits are shown."""


@dataclass(frozen=True)
class Today(Shown):
    """Verdict on a launch from a balloon, in a direction of flight.

    Attributes
    ----------
    lower, upper : float
        Bounds of its required deflection [rad], with persistence: with a calm and with a strong
        wind where the wind is not known. NaN where nothing can be said.
    limit : float
        Deflection capability [rad].
    archive_fraction : float
        Fraction of the archive's known soundings that require less.
    judged : tuple of float
        First and last time [s] of the judged interval of the flight.
    why : str
        Reason why nothing can be said; empty for a judged sounding.
    """

    lower: float = field(metadata=spec("angle"))
    upper: float = field(metadata=spec("angle"))
    limit: float
    archive_fraction: float = field(metadata=spec(name="archive_fraction_below"))
    judged: tuple[float, float] = field(metadata=spec("time"))
    why: str = field(default="", metadata=spec())

    @property
    @derived()
    def go(self) -> bool | None:
        """Whether the limit is sufficient; None where that is not known."""
        if not np.isnan(self.upper) and covers(self.limit, self.upper):
            return True
        return None if np.isnan(self.lower) or covers(self.limit, self.lower) else False


@dataclass(frozen=True, eq=False)
class Availability(Tabled):
    """Required deflections of the soundings of an archive; make it with `availability`.

    With several azimuths arrays have a leading axis for them, and methods give a tuple.

    Attributes
    ----------
    soundings : Soundings
        The archive.
    limit : float
        Deflection capability [rad].
    azimuth : float or ndarray
        Direction of flight [rad], or several of them.
    plane, model : str
        Plane of the motion that counts, and model of the plant.
    lower, upper : ndarray
        Bounds of the required deflections [rad], with persistence, ``(n,)``: with a calm and with a
        strong wind where the wind is not known. NaN where nothing can be said. Where trim reaches
        the limit more than once, or the path is quick, `upper` includes what a flight may require
        more, up to the largest trim. Both depend on the limit: `upper` is the limit where a flight
        survived with it, `lower` too where it was above.
    wind_known : ndarray of bool
        Whether the requirement is the same with calm and with a strong wind, ``(n,)``.
    persistence : ndarray
        The angle [rad] that `lower` and `upper` include for it, by azimuth, ``(a,)``.
    confidence : float
        Confidence of the intervals.
    notes : tuple of str
        Assumptions and limitations.
    reasons : tuple of str
        Reason why nothing can be said of a sounding, ``(n,)``; empty for a judged one.
    judged : ndarray
        First and last time [s] of the judged interval of the flight by sounding, ``(n, 2)``, in
        which the wind angle is at most 30 deg. NaN where nothing can be said.
    judge : Judge
        The flight, with which other winds are judged.
    """

    soundings: Soundings
    limit: float = field(metadata=spec("angle"))
    azimuth: float | FloatArray
    plane: str = field(metadata=spec())
    model: str = field(metadata=spec())
    lower: FloatArray
    upper: FloatArray
    wind_known: BoolArray
    persistence: FloatArray
    confidence: float
    notes: tuple[str, ...] = field(metadata=spec())
    reasons: tuple[str, ...]
    judged: FloatArray
    judge: Judge

    @property
    def flies(self) -> FloatArray:
        """Verdicts on n soundings, ``(n,)``: 1 for a sufficient limit, 0 if not, NaN if unknown."""
        return self._flies(self.limit)

    @property
    def why(self) -> tuple[str, ...]:
        """Reason why each of n soundings is not judged; empty for a judged one.

        It is the sounding's own (`reasons`), or where the limit lies between both bounds of the
        requirement, that its wind is not known, or that trim reaches the limit more than once and
        no flight with this limit was computed.
        """
        undecided: list[bool] = np.any(np.isnan(np.atleast_2d(self.flies)), axis=0).tolist()
        wind_known = np.all(np.atleast_2d(self.wind_known), axis=0).tolist()
        of_open = [_UNDECIDED if known else _UNKNOWN_WIND for known in wind_known]
        return tuple(
            reason or (open_reason if is_open else "")
            for reason, is_open, open_reason in zip(self.reasons, undecided, of_open, strict=True)
        )

    @property
    def judged_in_all(self) -> tuple[float, float]:
        """First and last time [s] of the flight interval that is judged in every sounding."""
        begins, ends = self.judged[~np.isnan(self.judged[:, 0])].T  # of the judged soundings
        first, last = self.judge.flight.span
        return float(begins.max(initial=first)), float(ends.min(initial=last))

    def fraction(self) -> Any:
        """Fraction of all soundings that survive at the limit, a `SurvivalFraction`.

        A tuple of fractions, one for each launch azimuth, where the archive is judged at several.
        """
        return self._fractions(self.limit)

    def reaches(self, fraction: float) -> Any:
        """Return whether at least a fraction of the days flies: True, False, or None if not proven.

        A tuple of these for several azimuths. `fraction`: the fraction, in [0, 1]. An answer is
        proven if it holds for the whole confidence interval, with unknown soundings counted as lost
        for True, and as flown for False.
        """
        fraction = errors.number("fraction", fraction, errors.between(0.0, 1.0))
        unknown_lost, unknown_flown = (
            self._as_tuple(self._fractions(self.limit, unknown=verdict)) for verdict in (0.0, 1.0)
        )
        return self._by_azimuth(
            [
                True if low.lower >= fraction else False if high.upper < fraction else None
                for low, high in zip(unknown_lost, unknown_flown, strict=True)
            ]
        )

    def by_month(self) -> dict[int, Any]:
        """Return the `SurvivalFraction`, or a tuple by azimuth, by local month from 1 to 12."""
        months = self.soundings.months
        return {
            month: self._fractions(self.limit, months == month)
            for month in np.unique(months[months > 0]).tolist()
        }

    def curve(self, limits: ArrayLike) -> tuple[Any, ...]:
        """Return the fractions of all soundings that fly with each of m limits.

        `limits`: deflection limits [rad] instead of the nozzle's, ``(m,)``. For each limit a
        `SurvivalFraction`, or, for several azimuths, a tuple of them.
        """
        row = errors.small_angle("a deflection", errors.nonnegative)(
            "limits", scalar_or_row("limits", limits)
        )
        return tuple(self._fractions(limit) for limit in row.tolist())

    def placard(self, fractions: ArrayLike = PLACARD) -> FloatArray:
        """Return the minimum limits [rad] sufficient for fractions of the judged soundings.

        Infinite where no limit is sufficient, NaN where no sounding is known. Shape
        ``(p,)``, or ``(a, p)`` for several azimuths.
        """
        fractions = errors.within("fractions", scalar_or_row("fractions", fractions), 0.0, 1.0)

        def limits(lower: FloatArray, upper: FloatArray) -> FloatArray:
            """Return the limits [rad] sufficient for the fractions, ``(p,)``, of one azimuth.

            `lower`, `upper`: limits [rad] that are insufficient and sufficient for each sounding,
            ``(n,)``; NaN where unknown.
            """
            judged = ~np.isnan(upper)
            if not np.any(judged):
                return np.full(fractions.shape, np.nan)
            # Each upper bound, rising, is a limit to try: numbers of soundings that fly with it
            # (their own bound is at most the limit), and that do not (their lower bound is above).
            high, low = np.sort(upper[judged]), np.sort(lower[judged])
            flown = np.searchsorted(high, high, side="right")
            not_flown = low.size - np.searchsorted(low, high, side="right")
            fraction = flown / np.maximum(flown + not_flown, 1)
            index = np.searchsorted(fraction, fractions * (1.0 - 1e-12))  # but for rounding
            return np.append(high, np.inf)[np.minimum(index, high.size)]

        rows = zip(np.atleast_2d(self.lower), np.atleast_2d(self.upper), strict=True)
        sufficient = np.stack([limits(lower, upper) for lower, upper in rows])
        return sufficient[0] if np.ndim(self.azimuth) == 0 else sufficient

    def today(self, profile: WindProfile) -> Any:
        """Return the verdict from a balloon, a `Today`; a tuple of them for several azimuths.

        Parameters
        ----------
        profile : WindProfile
            The wind over height that the balloon measured.

        Raises
        ------
        InputError
            For another type than a profile.
        """
        errors.instance("profile", profile, WindProfile, "see read_sounding")
        sounding = Soundings.from_profiles([profile], ["2000-01-01"])  # its time does not count
        # persistence: angle [rad] kept for the change of the wind after the balloon, by azimuth
        limits = self.limit - self.persistence
        required, _ = self.judge.decided(sounding, self.judge.requirements(sounding), limits)
        first, last = required.judged[0].tolist()  # [0]: of this one sounding
        verdicts = []
        for a, archive in enumerate(np.atleast_2d(self.upper)):  # by azimuth
            bounds = (required.lower[a, 0], required.upper[a, 0])
            lower, upper = (float(bound + self.persistence[a]) for bound in bounds)
            judged = archive[~np.isnan(archive)]
            # fraction of archived soundings that require less; equal ones do not count
            below = float(np.mean(judged < upper * _LOWER_RATIO)) if judged.size else float("nan")
            verdicts.append(
                Today(
                    lower=lower,
                    upper=upper,
                    limit=self.limit,
                    archive_fraction=below,
                    judged=(first, last),
                    why=required.reasons[0],
                )
            )
        return self._by_azimuth(verdicts)

    def _columns(self) -> Columns:
        """Return the table of requirements [rad] and verdicts, by azimuth and sounding time.

        Each requirement has a lower and an upper bound. "from" and "to" are the first and last
        judged flight time [s] of a sounding, "why" the reason where its verdict is not known.
        """
        angles = {name: np.atleast_2d(getattr(self, name)) for name in ("lower", "upper")}
        begins, ends = self.judged.T
        return Columns(
            (
                Column("azimuth", np.atleast_1d(self.azimuth), "rad"),
                Column("time", self.soundings.times.astype("datetime64[ns]"), "UTC"),
            ),
            (
                *(Column(name, values, "rad") for name, values in angles.items()),
                Column("flies", np.atleast_2d(self.flies)),
                Column("from", begins, "s", axes=("time",)),
                Column("to", ends, "s", axes=("time",)),
                Column("why", np.array(self.why, dtype=str), unit="", axes=("time",)),
            ),
            {
                "limit": self.limit,
                "plane": self.plane,
                "model": self.model,
                "station": self.soundings.station,
            },
        )

    def with_limit(self, limit: float) -> Self:
        """Return the availability with another limit [rad]; `InputError` for a negative limit."""
        return replace(
            self,
            limit=errors.number(
                "limit", limit, errors.small_angle("a deflection", errors.nonnegative), "rad"
            ),
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the record for JSON, angles in degrees, by azimuth under "towards".

        "placard_deg": limits sufficient for fractions of the soundings. "persistence_deg": angle
        kept for the change of the wind after the balloon.
        """
        names = [f"{100 * fraction:g} %" for fraction in PLACARD]
        months = {
            str(month): self._as_tuple(fractions) for month, fractions in self.by_month().items()
        }
        azimuths = np.degrees(np.atleast_1d(self.azimuth)).round(12)
        placards = np.degrees(np.atleast_2d(self.placard()))
        towards = [
            {
                "azimuth_deg": azimuths[a],
                **fraction.as_dict(),
                "months": {month: fractions[a] for month, fractions in months.items()},
                "placard_deg": dict(zip(names, placards[a], strict=True)),
                "persistence_deg": np.degrees(self.persistence[a]),
            }
            for a, fraction in enumerate(self._as_tuple(self.fraction()))
        ]
        return {
            "vehicle": self.judge.flight.vehicle.name,
            "station": self.soundings.station,
            **document(self, "model", "plane", "limit"),
            "confidence": self.confidence,
            "soundings": len(self.soundings),
            "judged_s": list(self.judged_in_all),
            "towards": towards,
            "notes": self.notes,
        }

    def _repr_html_(self) -> str:
        """Return a card for notebooks: limit, fraction that flies, sufficient limits, notes.

        Fractions are by azimuth. The limit sufficient for a fraction of the soundings is that of
        `placard`, of all azimuths in one row.
        """
        parts = self._as_tuple(self.fraction())
        rows: list[tuple[str, Any, str]] = [("limit", text(degrees("", self.limit)), "deg")]
        azimuths = np.degrees(np.atleast_1d(self.azimuth)).tolist()
        rows += [
            (f"towards {azimuth:.4g} deg", str(part), "")
            for azimuth, part in zip(azimuths, parts, strict=True)
        ]
        rows += [
            (
                f"sufficient for {100 * p:g} %",
                ", ".join(text(degrees("", limit)) for limit in self.placard([p]).ravel()),
                "deg",
            )
            for p in (0.5, 0.9, 0.95, 0.99)
        ]
        return card("Launch availability", rows + [("note", note, "") for note in self.notes])

    @property
    def requires_deflection(self) -> bool:
        """Whether any judged sounding requires deflection."""
        return bool(np.nanmax(self.upper, initial=0.0) > 0.0)

    def _as_tuple(self, value: Any) -> tuple[Any, ...]:
        """Return values by azimuth as a tuple, of length one for a single azimuth."""
        return (value,) if np.ndim(self.azimuth) == 0 else value

    def _flies(self, limit: float) -> FloatArray:
        """Return verdicts in n soundings on a limit [rad]: 1 sufficient, 0 not, NaN unknown.

        A limit from the upper bound of the required deflection on is sufficient, below the lower
        bound not.
        """
        with np.errstate(invalid="ignore"):
            sufficient = np.asarray(covers(limit, self.upper))
            insufficient = ~np.asarray(covers(limit, self.lower))
        known = ~np.isnan(self.lower)
        return np.where(known & sufficient, 1.0, np.where(known & insufficient, 0.0, np.nan))

    def _fractions(
        self, limit: float, which: BoolArray | slice = slice(None), unknown: float = np.nan
    ) -> Any:
        """Return the `SurvivalFraction` of selected soundings with a limit [rad], by azimuth.

        `which`: whether a sounding is selected, ``(n,)``; by default all. `unknown`: verdict that
        unknown soundings count as: 1 flown, 0 not flown; NaN keeps them out of the fraction. Its
        confidence interval allows for the autocorrelation of the verdicts, or, where all verdicts
        are alike, of the lower bounds of the required deflections.
        """
        times = self.soundings.times[which]
        # number of the month of each sounding: correlation is sought within a month alone
        season = (12 * self.soundings.years + self.soundings.months)[which]
        flown = np.nan_to_num(self._flies(limit), nan=unknown)
        rows = zip(np.atleast_2d(flown), np.atleast_2d(self.lower), strict=True)
        return self._by_azimuth(
            [
                survival_fraction(flies[which], required[which], times, season, self.confidence)
                for flies, required in rows
            ]
        )

    def _by_azimuth(self, values: list[Any]) -> Any:
        """Return values by azimuth as a tuple, or the value of a single azimuth."""
        return values[0] if np.ndim(self.azimuth) == 0 else tuple(values)


def scalar_or_row(name: str, value: ArrayLike) -> FloatArray:
    """Return a number or a row of numbers as a row, ``(n,)``; `InputError` for other shapes.

    `name`: name of the argument in the error, `value`: its value.
    """
    array = errors.finite(name, value)
    return errors.one_row(name, array if array.ndim else array[np.newaxis])


_MONTHS = (
    *("January", "February", "March", "April", "May", "June"),
    *("July", "August", "September", "October", "November", "December"),
)


def limit_line(record: Availability) -> Line:
    """Return the line with the limit [deg] and the fraction of the soundings that fly with it.

    `record`: availability for a single azimuth.
    """
    return (
        "Limit ",
        *degrees("availability.limit", record.limit, unit="deg"),
        ": ",
        *record.fraction().line,
    )


def archive_words(record: Availability) -> str:
    """Return a sentence with azimuth [deg], number, station and dates of the soundings, and gust.

    `record`: availability for a single azimuth.
    """
    azimuth = f"{np.degrees(float(record.azimuth)):.4g}"
    first, last = record.soundings.times[[0, -1]].astype("datetime64[D]")
    station = record.soundings.station or "an archive"
    return (
        f"The vehicle flies towards {azimuth} deg through each of the"
        f" {plural(len(record.soundings), 'wind')} of {station} from {first} to {last}"
        f"{record.judge.additions.gust_text}."
    )


def by_month(record: Availability) -> Table:
    """Return the table of an availability `record`: soundings that fly, by month and azimuth."""
    rows = []
    for month, parts in record.by_month().items():
        by_azimuth = parts if isinstance(parts, tuple) else (parts,)
        for towards, part in zip(_towards(record), by_azimuth, strict=True):
            key = f"availability.month.{month}{towards}"
            counts = {"flown": part.flown, "judged": part.judged, "unknown": part.unknown}
            shares = {"part": part.fraction, "lower": part.lower, "upper": part.upper}
            cells = [number_cell(f"{key}.{name}", value, 0) for name, value in counts.items()]
            cells += [number_cell(f"{key}.{k}_percent", 100.0 * x, 1) for k, x in shares.items()]
            rows.append(((f"{_MONTHS[month - 1]}{towards}",), *cells))
    head = ("month", "SURVIVED", "of", "unknown", "fraction [%]", "from [%]", "to [%]")
    return Table("By month", head, tuple(rows))


def interval(record: Availability) -> str:
    """Return a sentence on the meaning of the confidence intervals of an availability `record`."""
    return (
        f"With {100 * record.confidence:g} % confidence the fraction of all such days lies in the"
        " interval; days that are alike count as fewer independent ones."
    )


def placard(record: Availability) -> Table:
    """Return the table of the limits [deg] that fractions of the judged soundings require.

    `record`: availability. The rows are the fractions, from 50 to 99 percent, the columns azimuths.
    """
    rows: list[tuple[Line, ...]] = []
    for fraction, limits in zip(PLACARD, np.atleast_2d(record.placard()).T, strict=True):
        key = f"availability.placard.{100.0 * fraction:g}"
        cells = (
            minimum_limit(degrees(f"{key}{k}", x))
            for k, x in zip(_towards(record), limits, strict=True)
        )
        rows.append(((f"{100.0 * fraction:g} %",), *cells))
    head = ("fraction", *(f"limit [deg]{towards}" for towards in _towards(record)))
    return Table("Limit that is sufficient in a fraction of the soundings", head, tuple(rows))


def unknown(record: Availability) -> Table:
    """Return the table of reasons why soundings of a `record` are not judged, with their counts."""
    # what follows a colon is of a single sounding, such as its line in the file
    reasons = Counter(reason.split(":")[0] for reason in record.why if reason)
    rows = tuple(
        ((reason,), number_cell(f"availability.unknown.{i}", count, 0))
        for i, (reason, count) in enumerate(reasons.most_common())
    )
    return Table("Unknown soundings", ("why", "number"), rows)


def _towards(record: Availability) -> list[str]:
    """Return the labels of the azimuths of an availability `record`; empty for a single one."""
    azimuths = np.degrees(np.atleast_1d(record.azimuth)).tolist()
    return [f", towards {azimuth:.4g} deg" for azimuth in azimuths] if len(azimuths) > 1 else [""]
