"""Fraction of the days of an archive on which a deflection limit is sufficient.

`AvailabilityRequest` specifies it in a file; a case adds model, limit, limit shape and gust.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.schedule import FlightSchedule
from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.fields import checked, file_table, quantity, word
from tvclin.case.case import Case
from tvclin.ensembles.availability import sounding_winds
from tvclin.ensembles.availability.availability_record import Availability, scalar_or_row
from tvclin.ensembles.availability.judge import STOPS, Judge
from tvclin.linear.plant import DEFAULT_MODEL, MODELS
from tvclin.requirement.encountered_requirement import uses_encountered_pressure
from tvclin.requirement.flight.flight_requirement import WHOLE_TRIM
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.winds.histories import History
from tvclin.winds.pulses import checked_gust
from tvclin.winds.soundings.archive import Soundings
from tvclin.winds.soundings.levels import MAX_WIND_SPEED
from tvclin.winds.soundings.profile import MAX_LEVEL_DISTANCE
from tvclin.winds.wind_angles import FROZEN, MAX_LINEAR_ANGLE

_MAX_BOUND_SPREAD = 0.02
"""Largest relative difference of the bounds of a requirement that is used for its growth."""
_MIN_YEARS = 3
"""Number of years below which a note says that other years may be windier."""


def availability(
    flight: FlightSchedule,
    soundings: Soundings,
    *,
    limit: float,
    azimuth: ArrayLike,
    plane: str = BOTH,
    limit_shape: str = "round",
    model: str = DEFAULT_MODEL,
    persistence: float | sounding_winds.WindGrowth | sounding_winds.PairGrowth | str | None = None,
    gust: History | None = None,
    gust_speed: float | None = None,
    known_to: float | None = None,
    utc_offset: float | None = None,
    confidence: float = 0.95,
    sign: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Availability:
    """Return the fraction of soundings of an archive with which a deflection limit is sufficient.

    A flight with varying parameters goes through each sounding; the requirement is for the dead
    band K = 1, which needs no forecast; it is that of `size` with ``varying=True``, within a
    thousandth where the whole wind is known.

    Parameters
    ----------
    flight : FlightSchedule
        The flight, with its altitude; see `load_schedule`.
    soundings : Soundings
        The archive; see `read_soundings`.
    limit : float
        Deflection capability [rad].
    azimuth : array_like
        Direction of flight [rad], from north, clockwise; or several of them.
    plane : {"both", "pitch", "yaw"}
        Plane of the motion that counts.
    limit_shape : {"round", "square"}
        Limit shape of both planes: with a round stop the requirement is the root of the sum of
        squares of both planes, though their peaks need not coincide; with a square stop the larger.
    model : str
        Model of `Plant`.
    persistence : float, WindGrowth, PairGrowth or "pairs", optional
        Increase between balloon and launch: an angle [rad] that is added to each requirement; a
        wind that is added against the vehicle; or the growth of requirements between soundings of
        the archive.
    gust : History, optional
        Gust on top of each wind, once with its middle where the wind is largest, and once where
        trim reaches what the wind alone requires; the larger counts. By its angle it is the wind
        that turns the flight path by that angle.
    gust_speed : float, optional
        Wind speed [m/s] at the gust's peak, up to 1,000, in place of its angle; it adds to the wind
        at each time, in each plane as if the wind were in that plane alone.
    known_to : float, optional
        Height [m] to which a sounding must go to be judged.
    utc_offset : float, optional
        Local time less UTC [h], by which months are counted; by default the offset of the archive.
    confidence : float
        Confidence of the intervals, in (0, 1).
    sign : {"frozen"}, optional
        With "frozen" the nominal dynamic pressure counts, not that which each wind causes.
    progress : callable, optional
        Called with the number of finished soundings and of all soundings.

    Returns
    -------
    Availability
        Required deflection of each sounding, and the fraction that flies.

    Raises
    ------
    InputError
        For a flight without altitude, no usable sounding, and numbers out of range.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> flight = tv.load_schedule("configuration-i")
    >>> height = np.linspace(0.0, 32e3, 65)
    >>> jet = np.exp(-(((height - 11e3) / 4e3) ** 2))
    >>> winds = [tv.WindProfile(height=height, east=v * jet, north=0 * jet) for v in (30, 60)]
    >>> soundings = tv.winds.Soundings.from_profiles(winds, ["2024-02-01T00", "2024-02-01T12"])
    >>> limit, azimuth = np.radians(0.4), np.radians(90)
    >>> available = tv.availability(flight, soundings, limit=limit, azimuth=azimuth)
    >>> print(available.fraction())
    1 of 2 soundings survived: 50.0 %; 95 % interval 1.3 to 98.7 %, as of 2 independent ones
    """
    errors.instance("flight", flight, FlightSchedule, "see load_schedule")
    _check_usable(soundings)
    errors.one_of("plane", plane, (BOTH, *PLANES))
    errors.one_of("model", model, MODELS)
    if progress is not None:
        errors.callable_for("progress", progress, "of how many are done and how many there are")
    checked_gust(gust)
    if gust_speed is not None:
        if gust is None:
            raise errors.InputError("gust_speed is the speed of a gust: give the gust as well")
        errors.nonzero("gust_speed", gust_speed, "m/s")
        gust_speed = errors.number("gust_speed", gust_speed, errors.between(-1e3, 1e3), "m/s")
    azimuths = scalar_or_row("azimuth", azimuth)
    errors.directions("azimuth", azimuths)
    growth = sounding_winds.growth_of(persistence)
    capability = errors.number(
        "limit", limit, errors.small_angle("a deflection", errors.nonnegative), "rad"
    )
    confidence = errors.fraction("confidence", confidence)
    if utc_offset is not None:
        soundings = soundings.with_utc_offset(utc_offset)
    judge = Judge.of(
        flight,
        plane=plane,
        model=model,
        azimuths=azimuths,
        limit_shape=errors.one_of("limit_shape", limit_shape, STOPS),
        growth=growth if isinstance(growth, sounding_winds.WindGrowth) else None,
        gust=gust,
        gust_speed=gust_speed,
        known_to=None
        if known_to is None
        else errors.number("known_to", known_to, errors.between(0, 1e5), "m"),
        pressure=uses_encountered_pressure(sign),
    )
    bounds = judge.requirements(soundings, progress)
    # the increase until launch [rad] by azimuth; flights decide on what it leaves of the limit
    added, growth_notes = _added(growth, bounds.lower, bounds.upper, soundings)
    required, flight_notes = judge.decided(soundings, bounds, capability - added)
    lower, upper = (x + added[:, np.newaxis] for x in (required.lower, required.upper))
    single = np.ndim(azimuth) == 0
    return Availability(
        soundings=soundings,
        limit=capability,
        azimuth=float(azimuths[0]) if single else azimuths,
        plane=plane,
        model=model,
        lower=lower[0] if single else lower,
        upper=upper[0] if single else upper,
        wind_known=required.wind_known[0] if single else required.wind_known,
        persistence=added,
        confidence=confidence,
        notes=(
            *(*soundings.notes, *growth_notes, *flight_notes),
            *_interval_notes(judge, required.judged),
            *unmeasured_notes(judge, soundings),
            *_season_notes(soundings, required.reasons),
        ),
        reasons=tuple(required.reasons),
        judged=required.judged,
        judge=judge,
    )


def _check_usable(soundings: Soundings) -> None:
    """Raise `InputError` for another type than an archive, or one without a usable sounding."""
    errors.instance("soundings", soundings, Soundings, "see read_soundings")
    if not len(soundings):
        raise errors.InputError(
            "soundings must hold one or more; got none (check month, years and station)"
        )
    if not np.any(soundings.usable):
        raise errors.InputError(
            f"none of {len(soundings)} soundings can be used: {soundings.why[0]}"
        )


def _added(
    growth: float | sounding_winds.WindGrowth | sounding_winds.PairGrowth,
    lower: FloatArray,
    upper: FloatArray,
    soundings: Soundings,
) -> tuple[FloatArray, list[str]]:
    """Return the increase [rad] of requirements from balloon to launch, ``(a,)``, and its notes.

    `growth`: model of persistence, or the increase itself [rad]. `lower`, `upper`: bounds of the
    required deflection [rad] by azimuth and sounding, ``(a, n)``. `soundings`: give their times.
    """
    if isinstance(growth, sounding_winds.WindGrowth):
        note = "each required deflection includes the growth of the wind until launch"
        return np.zeros(lower.shape[0]), [note]
    if isinstance(growth, sounding_winds.PairGrowth):
        usable = upper - lower <= _MAX_BOUND_SPREAD * upper  # both bounds nearly equal
        added, pairs = sounding_winds.grown_by(
            growth, np.where(usable, lower, np.nan), soundings.times
        )
        added = np.maximum(added, 0.0)
        angles = ", ".join(f"{angle:.4f}" for angle in np.degrees(added).tolist())
        return added, [
            f"persistence adds {angles} deg; the required deflections of {100 * growth.quantile:g}"
            f" % of {pairs} pairs {sounding_winds.HALF_DAY:g} h apart grew by less, scaled to"
            f" {growth.hours:g} h"
        ]
    notes = [f"persistence adds {np.degrees(growth):.4g} deg"] if growth else []
    return np.full(lower.shape[0], growth), notes


def unmeasured_notes(judge: Judge, soundings: Soundings) -> list[str]:
    """Return a note on heights at which winds are not measured, and the wind assumed there.

    `judge` has the path of the flight, along which the heights of `soundings` count.
    """
    path = judge.path
    winds = sounding_winds.SoundingWinds.of(soundings[soundings.usable], path)
    low, high = path.height[[0, -1]].tolist()
    below, above, gaps = winds.bottom > low, winds.top < high, winds.has_gaps
    count, total = int(np.sum(below | above | gaps)), below.size
    if not count:
        return []
    places = {
        f"below {1e-3 * winds.bottom.max():.3g} km": np.any(below),
        f"above {1e-3 * winds.top.min():.3g} km": np.any(above),
        f"in gaps of more than {1e-3 * MAX_LEVEL_DISTANCE:g} km": np.any(gaps),
    }
    where = [place for place, is_unmeasured in places.items() if is_unmeasured]
    whose = "the wind" if total == 1 else f"the wind of {count} of {total} soundings"
    return [
        f"{whose} is not measured {' and '.join(where)}: to be sufficient, a limit must survive"
        f" {MAX_WIND_SPEED:g} m/s against the vehicle there (less where its angle would not be"
        " linear)"
    ]


def _interval_notes(judge: Judge, times: FloatArray) -> Iterator[str]:
    """Yield notes on intervals of the flight that are not judged, or judged separately.

    `times`: first and last time [s] of the judged interval of the flight `judge.flight` in each
    sounding, ``(n, 2)``; NaN where a sounding is not judged. `judge.marches` is empty if no
    mode is unstable at any time.
    """
    flight, (first, last) = judge.flight, judge.flight.span
    begin, end = judge.judged_path.time[[0, -1]].tolist()  # with an unstable mode
    changes = [interval.span[0] for interval in flight.one_sign_intervals[1:]]
    changes_text = ", ".join(f"{change:.4g}" for change in changes if change < end)
    if changes_text and judge.marches:
        yield (
            f"the aerodynamic moment changes its sign at {changes_text} s: flights of the trim law"
            " through all of the wind decide"
        )
    if any(march.motion.has_pair(begin, end) for march in judge.marches.values()):
        yield f"two unstable poles are a pair or equal for a while; K = 1 {WHOLE_TRIM}"
    stable = end if judge.marches else first  # time from which on no mode is unstable
    if stable < last:
        yield (f"from {stable:.4g} to {last:.4g} s no mode is unstable: no deflection is required")
    late, early = times[:, 0] > first, times[:, 1] < last
    where = []
    if np.any(late):
        where.append(f"until {flight.altitude_text(times[late, 0].max())}")
    if np.any(early):
        where.append(f"from {flight.altitude_text(times[early, 1].min())} on")
    if where:
        count, limit = int(np.sum(late | early)), np.degrees(MAX_LINEAR_ANGLE)
        yield (
            f"{' and '.join(where)} the wind angle of {count} of {len(times)} soundings exceeds"
            f" {limit:.3g} deg, beyond linear aerodynamics: the remaining interval of the flight"
            " is judged"
        )


def _season_notes(soundings: Soundings, reasons: list[str]) -> Iterator[str]:
    """Yield a note where the judged soundings are of fewer than `_MIN_YEARS` years.

    `reasons`: reason why a sounding is not judged, ``(n,)``; empty for a judged one.
    """
    judged = np.array([not reason for reason in reasons], dtype=bool)
    years = np.unique(soundings.years[judged & (soundings.years > 0)]).size
    if 0 < years < _MIN_YEARS:
        seasons = "one season" if years == 1 else "two seasons"
        yield f"the soundings are of {seasons}: other years may be windier than the intervals say"


@dataclass(frozen=True, kw_only=True, eq=False)
class AvailabilityRequest:
    """Specification of the availability of a case, in addition to the case.

    Attributes
    ----------
    flight : FlightSchedule
        The flight.
    soundings : Soundings
        The archive.
    azimuth : float
        Direction of flight [rad], from north, clockwise.
    plane : str
        Plane that counts.
    persistence : float, WindGrowth, PairGrowth or "pairs", optional
        Increase between balloon and launch; see `availability`.
    known_to : float, optional
        Height that a sounding must reach to be judged [m].
    confidence : float
        Confidence of the intervals, from 0 to 1.
    least_part : float, optional
        Required fraction of the days, which is judged.
    gust_speed : float, optional
        Wind speed [m/s] at the peak of the case's gust, in place of its angle.

    Raises
    ------
    InputError
        For other types than flight and archive, an archive without a usable sounding, unknown
        names, and numbers out of range.
    """

    flight: FlightSchedule
    soundings: Soundings
    azimuth: float = quantity("angle", check=errors.directions)
    plane: str = word((BOTH, *PLANES), BOTH)
    persistence: float | sounding_winds.WindGrowth | sounding_winds.PairGrowth | str | None = None
    known_to: float | None = quantity("length", None, errors.between(0.0, 1e5))
    confidence: float = quantity("number", 0.95, errors.fraction)
    least_part: float | None = quantity("number", None, errors.between(0.0, 1.0))
    gust_speed: float | None = quantity("speed", None, errors.nonzero, key=None, option=None)

    def __post_init__(self) -> None:
        """Check the fields; `InputError` as the class says."""
        errors.instance("flight", self.flight, FlightSchedule, "see load_schedule")
        _check_usable(self.soundings)
        checked(self)
        sounding_winds.growth_of(self.persistence)  # raises for a wrong one

    def availability(
        self,
        case: Case,
        progress: Callable[[int, int], None] | None = None,
        azimuth: ArrayLike | None = None,
    ) -> Availability:
        """Return the availability of a case; `InputError` for a nozzle without a limit.

        Same exceptions as the function `availability`. The nozzle gives limit and limit shape
        (round by default), the case model, gust and sign. `progress`: called with the number of
        finished soundings and of all soundings. `azimuth`: directions of flight [rad] in place of
        the one specified.
        """
        errors.instance("case", case, Case, "of a wind and a nozzle")
        if case.nozzle.limit is None:
            raise errors.InputError(
                "availability is judged for a limit: give limit_deg in [nozzle]"
            )
        return availability(
            self.flight,
            self.soundings,
            limit=case.nozzle.limit,
            azimuth=self.azimuth if azimuth is None else azimuth,
            plane=self.plane,
            limit_shape=errors.one_of(
                "limit_shape of availability", case.nozzle.limit_shape or "round", STOPS
            ),
            model=case.model,
            persistence=self.persistence,
            gust=getattr(case.wind, "gust", None),
            gust_speed=self.gust_speed,
            known_to=self.known_to,
            confidence=self.confidence,
            sign=FROZEN if case.sign == FROZEN else None,
            progress=progress,
        )


AVAILABILITY_TABLE = file_table(
    "[availability]",
    AvailabilityRequest,
    quantities={
        "persistence": "angle",
        "persistence_hours": "number",
        "utc_offset_hours": "number",
    },
    words=("archive", "station", "in_order", "dates"),
    lists=("months", "years"),
)
