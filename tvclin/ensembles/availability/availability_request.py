"""Specification of availability, to which a case adds its model, limit, stop and gust."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.errors import InputError, between, directions, fraction, instance, nonzero, one_of
from tvclin.base.fields import checked, file_table, quantity, word
from tvclin.case.case import Case
from tvclin.ensembles.availability.judge import STOPS
from tvclin.ensembles.availability.sounding_winds import PairGrowth, WindGrowth, growth_of
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.winds.soundings.archive import Soundings
from tvclin.winds.wind_angles import FROZEN

if TYPE_CHECKING:
    from tvclin.ensembles.availability.availability_record import Availability


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
        Required fraction of the days; None without a requirement.
    gust_speed : float, optional
        Wind speed [m/s] at the peak of the case's gust, in place of its angle.

    Raises
    ------
    InputError
        For other types than flight and archive, an empty archive, unknown names, and numbers out
        of range.
    """

    flight: FlightSchedule
    soundings: Soundings
    azimuth: float = quantity("angle", check=directions)
    plane: str = word((BOTH, *PLANES), BOTH)
    persistence: float | WindGrowth | PairGrowth | str | None = None
    known_to: float | None = quantity("length", None, between(0.0, 1e5))
    confidence: float = quantity("number", 0.95, fraction)
    least_part: float | None = quantity("number", None, between(0.0, 1.0))
    gust_speed: float | None = quantity("speed", None, nonzero, key=None, option=None)

    def __post_init__(self) -> None:
        instance("flight", self.flight, FlightSchedule, "see load_schedule")
        instance("soundings", self.soundings, Soundings, "see read_soundings")
        if not len(self.soundings):
            raise InputError(
                "soundings must hold one or more; got none (check month, years and station)"
            )
        checked(self)
        growth_of(self.persistence)

    def availability(
        self,
        case: Case,
        progress: Callable[[int, int], None] | None = None,
        azimuth: ArrayLike | None = None,
    ) -> Availability:
        """Return the availability of a case; `InputError` without a limit.

        Same exceptions as `availability`. In both planes the limit shape is from the nozzle, or
        round. `azimuth`: directions of flight [rad] in place of the one specified.
        """
        from tvclin.ensembles.availability.availability import availability

        instance("case", case, Case, "of a wind and a nozzle")
        if case.nozzle.limit is None:
            raise InputError("availability is judged for a limit: give limit_deg in [nozzle]")
        return availability(
            self.flight,
            self.soundings,
            limit=case.nozzle.limit,
            azimuth=self.azimuth if azimuth is None else azimuth,
            plane=self.plane,
            limit_shape=one_of(
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
