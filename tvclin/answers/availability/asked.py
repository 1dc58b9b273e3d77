"""What a study file asks of an archive of soundings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

from tvclin.answers.availability.growth import PairGrowth, WindGrowth, growth_of
from tvclin.answers.availability.judge import STOPS
from tvclin.answers.planes import BOTH
from tvclin.answers.sizing.schedule import FlightSchedule
from tvclin.base.errors import InputError, bearing, between, fraction, instance, number, one_of
from tvclin.base.tables import Table
from tvclin.linear.models import MODELS, USUAL_MODEL
from tvclin.vehicle.coefficients import PLANES
from tvclin.winds.gusts import checked_gust
from tvclin.winds.histories import History
from tvclin.winds.soundings.archive import Soundings

if TYPE_CHECKING:
    from tvclin.answers.availability.record import Availability

AVAILABILITY_TABLE = Table(
    "[availability]",
    {
        "azimuth": "angle",
        "known_to": "length",
        "persistence": "angle",
        **dict.fromkeys(
            ("persistence_hours", "utc_offset_hours", "confidence", "least_part"), "number"
        ),
    },
    words=("archive", "station", "plane", "stop", "model"),
    lists=("months", "years"),
)


@dataclass(frozen=True, kw_only=True, eq=False)
class AvailabilityAsked:
    """Everything on which the availability of a study depends.

    Attributes
    ----------
    flight : FlightSchedule
        The flight.
    soundings : Soundings
        The archive.
    azimuth, plane, stop, model, persistence, gust, known_to, confidence
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
    stop: str = "round"
    model: str = USUAL_MODEL
    persistence: float | WindGrowth | PairGrowth | str | None = None
    gust: History | None = None
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
        for name, names in {"plane": (BOTH, *PLANES), "stop": STOPS, "model": MODELS}.items():
            one_of(f"{name} of availability", getattr(self, name), names)
        bearing("azimuth", self.azimuth)
        growth_of(self.persistence)
        checked_gust(self.gust)
        if self.known_to is not None:
            number("known_to", self.known_to, between(0.0, 1e5), "m")
        fraction("confidence", self.confidence)
        if self.least_part is not None:
            number("least_part", self.least_part, between(0.0, 1.0))

    def availability(
        self, limit: float, progress: Callable[[int, int], None] | None = None
    ) -> Availability:
        """Return on how many days a limit [rad] is enough; raise `InputError` as `availability`."""
        from tvclin.answers.availability.availability import availability

        asked = {one.name: getattr(self, one.name) for one in fields(self)}
        del asked["least_part"]
        flight, soundings = asked.pop("flight"), asked.pop("soundings")
        return availability(flight, soundings, limit=limit, progress=progress, **asked)
