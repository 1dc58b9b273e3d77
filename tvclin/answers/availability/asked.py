"""What is asked of an archive of soundings, beside a case: its model, limit, stop and gust."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tvclin.answers.availability.growth import PairGrowth, WindGrowth, growth_of
from tvclin.answers.availability.judge import STOPS
from tvclin.answers.case import Case
from tvclin.answers.sizing.schedule import FlightSchedule
from tvclin.answers.sizing.wind_sign import FROZEN
from tvclin.base.errors import InputError, bearing, between, fraction, instance, number, one_of
from tvclin.base.tables import FileTable
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.winds.soundings.archive import Soundings

if TYPE_CHECKING:
    from tvclin.answers.availability.record import Availability

AVAILABILITY_TABLE = FileTable(
    "[availability]",
    {
        "azimuth": "angle",
        "known_to": "length",
        "persistence": "angle",
        **dict.fromkeys(
            ("persistence_hours", "utc_offset_hours", "confidence", "least_part"), "number"
        ),
    },
    words=("archive", "station", "plane", "in_order"),
    lists=("months", "years"),
)


@dataclass(frozen=True, kw_only=True, eq=False)
class AvailabilityAsked:
    """What the availability of a case depends on beside the case.

    Attributes
    ----------
    flight : FlightSchedule
        The flight.
    soundings : Soundings
        The archive.
    azimuth, plane, persistence, known_to, confidence
        As of `availability`.
    least_part : float, optional
        So many of the days it must fly; without it nothing is asked.

    Raises
    ------
    InputError
        For what is no flight or archive, an empty one, unknown names, and numbers out of range.
    """

    flight: FlightSchedule
    soundings: Soundings
    azimuth: float
    plane: str = BOTH
    persistence: float | WindGrowth | PairGrowth | str | None = None
    known_to: float | None = None
    confidence: float = 0.95
    least_part: float | None = None

    def __post_init__(self) -> None:
        instance("flight", self.flight, FlightSchedule, "see load_schedule")
        instance("soundings", self.soundings, Soundings, "see read_soundings")
        if not len(self.soundings):
            raise InputError(
                "soundings must hold one or more; got none (check month, years and station)"
            )
        one_of("plane of availability", self.plane, (BOTH, *PLANES))
        bearing("azimuth", self.azimuth)
        growth_of(self.persistence)
        if self.known_to is not None:
            number("known_to", self.known_to, between(0.0, 1e5), "m")
        fraction("confidence", self.confidence)
        if self.least_part is not None:
            number("least_part", self.least_part, between(0.0, 1.0))

    def availability(
        self, case: Case, progress: Callable[[int, int], None] | None = None
    ) -> Availability:
        """Return on how many days a case flies; `InputError` without a limit, and as its question.

        In both planes the stop is that of the nozzle, or round.
        """
        from tvclin.answers.availability.availability import availability

        instance("case", case, Case, "of a wind and a nozzle")
        if case.nozzle.limit is None:
            raise InputError("availability is judged for a limit: give limit_deg in [nozzle]")
        return availability(
            self.flight,
            self.soundings,
            limit=case.nozzle.limit,
            azimuth=self.azimuth,
            plane=self.plane,
            stop=one_of("stop of availability", case.nozzle.stop or "round", STOPS),
            model=case.model,
            persistence=self.persistence,
            gust=getattr(case.wind, "gust", None),
            known_to=self.known_to,
            confidence=self.confidence,
            sign=FROZEN if getattr(case, "sign", None) == FROZEN else None,
            progress=progress,
        )
