"""What a study file asks of an archive of soundings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tvclin.answers.availability.growth import PairGrowth
from tvclin.answers.availability.judge import STOPS
from tvclin.answers.planes import BOTH
from tvclin.answers.sizing.schedule import FlightSchedule
from tvclin.base.errors import InputError, between, fraction, instance, number, one_of, shown
from tvclin.base.tables import Table
from tvclin.linear.plant import MODELS
from tvclin.vehicle.coefficients import PLANES
from tvclin.winds.histories import History
from tvclin.winds.soundings.archive import Soundings
from tvclin.winds.soundings.read_soundings import read_soundings

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
        For what is no flight or archive, unknown names, and numbers out of range.
    """

    flight: FlightSchedule
    soundings: Soundings
    azimuth: float
    plane: str = BOTH
    stop: str = "round"
    model: str = "drift-exact"
    persistence: float | PairGrowth | None = None
    gust: History | None = None
    known_to: float | None = None
    confidence: float = 0.95
    least_part: float | None = None

    def __post_init__(self) -> None:
        instance("flight", self.flight, FlightSchedule, "see load_schedule")
        instance("soundings", self.soundings, Soundings, "see read_soundings")
        for name, names in {"plane": (BOTH, *PLANES), "stop": STOPS, "model": MODELS}.items():
            one_of(f"{name} of availability", getattr(self, name), names)
        number("azimuth", self.azimuth, unit="rad")
        fraction("confidence", self.confidence)
        if self.least_part is not None:
            number("least_part", self.least_part, between(0.0, 1.0))

    @classmethod
    def of_table(cls, table: Mapping[str, Any], folder: Path, **study: Any) -> AvailabilityAsked:
        """Return what a table [availability] asks for.

        Parameters
        ----------
        table : mapping
            As it stands in the file.
        folder : Path
            Where its archive is.
        **study
            Flight, gust, and more of the study that counts where the table says nothing.

        Raises
        ------
        InputError
            For unknown keys, and as `read_soundings`.
        """
        given = AVAILABILITY_TABLE.read(table)
        AVAILABILITY_TABLE.need(given, ("archive", "azimuth"))
        archive = given.pop("archive")
        names = archive if isinstance(archive, list) else [archive]
        if not names or not all(isinstance(one, str) and one.isprintable() for one in names):
            raise InputError(
                "archive in [availability] must be a station file, a folder, or a list of them;"
                f" got {shown(archive)}"
            )
        soundings = read_soundings(
            [folder / name for name in names],
            months=given.pop("months", None),
            years=given.pop("years", None),
            station=given.pop("station", None),
            utc_offset=given.pop("utc_offset_hours", 0.0),
        )
        hours = given.pop("persistence_hours", None)
        if hours is not None:
            if "persistence" in given:
                raise InputError(
                    "[availability] has persistence_deg and persistence_hours; keep one"
                )
            given["persistence"] = PairGrowth(hours)
        return cls(soundings=soundings, **(study | given))

    def availability(self, limit: float) -> Availability:
        """Return on how many days a limit [rad] is enough; raise `InputError` as `availability`."""
        from tvclin.answers.availability.availability import availability

        asked = {one.name: getattr(self, one.name) for one in fields(self)}
        del asked["least_part"]
        return availability(asked.pop("flight"), asked.pop("soundings"), limit=limit, **asked)
