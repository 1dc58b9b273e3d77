"""`tvclin availability`: on how many days of an archive the nozzle is sufficient."""

from dataclasses import dataclass, replace
from math import radians
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from tvclin.ascent.schedule_file import load_schedule
from tvclin.base.errors import InputError, nonnegative, nonzero, number, within
from tvclin.cli.inputs import note_source, only_with
from tvclin.cli.options import (
    GROUP,
    MODEL,
    SIGN,
    TIME_HELP,
    AsJson,
    Given,
    Plot,
    asked,
    switch,
    to_write,
)
from tvclin.cli.output import answer, draw, print_tables, say, say_notes
from tvclin.cli.progress import bar
from tvclin.cli.wind import gust_of_option
from tvclin.ensembles.availability import availability_record as answer_tables
from tvclin.ensembles.availability.availability_record import Availability, Today
from tvclin.ensembles.availability.sounding_winds import PairGrowth
from tvclin.vehicle.coefficients import PLANE_TEXTS
from tvclin.winds.histories import History
from tvclin.winds.soundings.archive import Soundings
from tvclin.winds.soundings.profile import WindProfile
from tvclin.winds.soundings.sounding_files import read_sounding, read_soundings

_ARCHIVE_FIELDS = ("years", "station", "in_order", "dates", "utc_offset")
"""Options that are arguments of `read_soundings` by the same names."""


@dataclass(frozen=True)
class FormatOptions:
    """Options of the format, units and site of soundings; `grouped` gives them to a command."""

    winds_format: str | None = asked(
        "Format of the sounding: csv, openrocket, wyoming, igra, rocketpy or synthetic.",
        shown="by its content",
    )
    units: str | None = asked(
        "Units of a table of winds that names none: those of heights, speeds and directions.",
        metavar="FT,MPH",
        shown="m,m/s,deg with --winds-format openrocket",
    )
    above_ground: float | None = asked(
        "Elevation of the site above the sea, in m, for a table of heights above the ground.",
        metavar="M",
    )

    @property
    def reading(self) -> dict[str, Any]:
        """Arguments of `read_sounding` from these options."""
        return {
            "format": self.winds_format,
            "units": self.units,
            "above_ground": self.above_ground,
        }


@dataclass(frozen=True)
class ArchiveOptions(FormatOptions):
    """Options that select soundings of an archive; `grouped` gives them to a command."""

    months: list[int] | None = asked(
        "Only this month, from 1 to 12; may be given several times.", flag="--month"
    )
    years: tuple[int, int] | None = asked("Only these years.", metavar="FIRST LAST")
    station: str | None = asked("Only this station, where there are several.")
    in_order: bool = switch(
        "--in-order",
        "Take files without a date in the order of their names, one a day from 2000-01-01"
        " on; of what month they are is then not known.",
    )
    dates: Path | None = asked(
        "Dates of files of one sounding that do not say theirs: a CSV file with the headings file"
        " and time (UTC).",
        metavar="FILE",
    )
    utc_offset: float = asked("Local time minus UTC, in h: months are those of local time.", 0.0)

    panel = "Archive"

    def read(self, archive: list[Path]) -> Soundings:
        """Return these soundings."""
        with bar("read") as progress:
            return read_soundings(
                archive,
                months=self.months or None,
                **{name: getattr(self, name) for name in _ARCHIVE_FIELDS},
                **self.reading,
                progress=progress,
            )


@dataclass(frozen=True)
class JudgedOptions:
    """Options of the judgement of soundings, and of today's balloon; `grouped` gives them."""

    stop: str = asked("Stop of the nozzle: round (root of the sum of squares) or square.", "round")
    persistence_deg: float | None = asked(
        "Angle added for the change of wind until launch, in deg."
    )
    persistence_hours: float | None = asked(
        "In place of --persistence-deg, the hours from balloon to launch. Added is the"
        " growth of need that 95 % of the archive's pairs 12 h apart do not exceed, scaled to"
        " these hours."
    )
    today: Path | None = asked("Also judge this balloon of today: go or no go?", metavar="FILE")
    today_time: str | None = asked(
        f"Which balloon of a --today that holds several, {TIME_HELP}", metavar="TIME"
    )

    @property
    def growth(self) -> float | PairGrowth | None:
        """Persistence angle [rad], or growth of need in the archive; None without an option."""
        if self.persistence_deg is not None and self.persistence_hours is not None:
            raise InputError("give --persistence-deg or --persistence-hours, not both")
        if self.persistence_hours is not None:
            return PairGrowth(self.persistence_hours)
        if self.persistence_deg is None:
            return None
        return radians(within("--persistence-deg", self.persistence_deg, 0.0, 90.0))

    def balloon(self, **reading: Any) -> WindProfile | None:
        """Return the wind of the balloon of today; None without an option.

        `reading`: other arguments of `read_sounding`.
        """
        if self.today is None:
            only_with("--today", today_time=self.today_time)
            return None
        profile = read_sounding(self.today, time=self.today_time, **reading)
        for note in profile.notes:
            say(f"Note: {self.today.name}: {note}.", err=True)
        return profile


@dataclass(frozen=True)
class GustOptions:
    """Options of the gust on each sounding; `grouped` gives them to a command."""

    gust: tuple[float, float] | None = asked(
        "Gust (1 - cosine) on top of the wind: its peak and duration.", metavar="DEG S"
    )
    gust_speed: tuple[float, float] | None = asked(
        "Gust by its peak wind speed, in m/s, and its duration, by eq (B1e).", metavar="M/S S"
    )
    gust_plateau: float | None = asked(
        "How long the gust stays at its peak, a part of its duration, in s.", shown="0"
    )

    @property
    def on_top(self) -> tuple[History | None, float | None]:
        """The gust, and its speed [m/s] where that replaces its angle."""
        if self.gust is not None and self.gust_speed is not None:
            raise InputError("give --gust or --gust-speed, not both")
        speed = self.gust_speed and number("--gust-speed", self.gust_speed[0], nonzero)
        gust = (1.0, self.gust_speed[1]) if self.gust_speed else self.gust
        if gust is None:
            only_with("--gust", gust_plateau=self.gust_plateau)
            return None, None
        option = "--gust-speed" if self.gust_speed else "--gust"
        level = number("--gust-plateau", self.gust_plateau or 0.0, nonnegative, "s")
        return gust_of_option(gust, level, option), speed


def availability(
    source: Annotated[
        str,
        typer.Argument(
            metavar="SCHEDULE|VEHICLE",
            help="A flight schedule (CSV or TOML) with its altitude, or a vehicle with a flight.",
        ),
    ],
    archive: Annotated[
        list[Path],
        typer.Argument(
            metavar="STATION...",
            help="A station file of IGRA (.txt or .zip), or files and folders of soundings.",
        ),
    ],
    azimuth_deg: Annotated[
        list[float],
        typer.Option(
            help="Direction of flight, in deg from north, clockwise; may be given several times."
        ),
    ],
    limit_deg: Annotated[float, typer.Option(help="Deflection limit, in deg.")],
    model: Given = MODEL,
    sign: Given = replace(SIGN, shown={"sign": "that of each sounding"}),
    question: Given = Given(
        "ensembles.availability.availability_request.AvailabilityRequest",
        ("plane", "known_to", "confidence"),
    ),
    only: ArchiveOptions = GROUP,
    begin: float | None = asked(
        "First flight time that counts, in s.", flag="--from", shown="the first"
    ),
    end: float | None = asked("Last flight time that counts, in s.", flag="--to", shown="the last"),
    judged: JudgedOptions = GROUP,
    winds: GustOptions = GROUP,
    as_json: AsJson = False,
    csv: Path | None = asked(
        "Also write what every sounding needs into this file: required_deg (empty where"
        " --limit-deg is not judged), and its bounds, lower_deg and upper_deg.",
        callback=to_write,
    ),
    plot: Plot = None,
) -> None:
    """Say on how many days of an archive of soundings the nozzle is sufficient.

    Each sounding is flown through along the whole flight, with trim up to the limit (K = 1), which
    needs no forecast. What a balloon did not see is unknown, not calm.

    Exit code 0: some soundings were judged; with --today: the limit is sufficient for that balloon,
    in every direction; 1: it is not, or that is not known; 2: bad input.
    """
    from tvclin import plots
    from tvclin.ensembles.availability.availability import availability as availability_of

    limit = float(np.radians(within("--limit-deg", limit_deg, 0.0, 90.0)))
    azimuths = np.radians(within("--azimuth-deg", azimuth_deg, -360.0, 360.0))
    note_source(source, "availability")
    flight, balloon = load_schedule(source).between(begin, end), judged.balloon(**only.reading)
    soundings, (gust, speed) = only.read(archive), winds.on_top
    with bar("soundings") as progress:
        result = availability_of(
            flight,
            soundings,
            limit=limit,
            azimuth=azimuths,
            stop=judged.stop,
            persistence=judged.growth,
            gust=gust,
            gust_speed=speed,
            progress=progress,
            **model.values,
            **sign.values,
            **question.values,
        )
    today = () if balloon is None else result.today(balloon)
    if csv is not None:
        result.to_csv(csv)
    draw(plot, lambda: plots.availability_chart(result, source))
    judged_any = any(share.judged for share in result.fraction())
    yes = all(day.go for day in today) if today else judged_any
    answer(as_json, lambda: _document(result, today), lambda: _print(result, today, source), yes)


def _document(result: Availability, today: tuple[Today, ...]) -> dict[str, Any]:
    """Return the availability, with the balloon of today in each direction, for JSON."""
    document = result.as_dict()
    for towards, answer_today in zip(document["towards"], today, strict=False):
        towards["today"] = answer_today
    return document


def _print(result: Availability, launch: tuple[Today, ...], source: str) -> None:
    """Print the fractions of soundings that fly, placards, and the verdict on a launch."""
    name = result.judge.flight.vehicle.name or source
    say(f"{name}, {result.model}, {PLANE_TEXTS[result.plane]}: {result.soundings!r}\n")
    azimuths = [f"{angle:.4g}" for angle in np.degrees(np.atleast_1d(result.azimuth)).tolist()]
    begin, end = result.judged_in_all
    say(f"Limit {np.degrees(result.limit):.3f} deg, from {begin:.4g} to {end:.4g} s of the flight")
    for azimuth, fraction in zip(azimuths, result.fraction(), strict=True):
        say(f"towards {azimuth} deg: {fraction}")
    say(answer_tables.interval(result))
    typer.echo()
    print_tables(answer_tables.by_month(result), answer_tables.placard(result))
    say(
        "A sounding that meets its limit more than once is flown only if that decides about"
        f" {np.degrees(result.limit):.4g} deg. Else lower_deg and upper_deg of the CSV bracket what"
        " it asks for; required_deg is the lower of them, and empty where this limit is not"
        " judged. Ask"
        " again for another limit."
    )
    for azimuth, answer_today in zip(azimuths, launch, strict=False):
        cut = answer_today.judged != result.judge.flight.span and not answer_today.why
        fraction = (
            "; from {:.4g} to {:.4g} s, the rest is not judged".format(*answer_today.judged) * cut
        )
        say(f"Today towards {azimuth} deg: {_said(answer_today)}{fraction}")
    say_notes(result.notes)


def _said(balloon: Today) -> str:
    """Return the verdict on a balloon, in words."""
    if balloon.go is None:
        between = (
            f", between {np.degrees(balloon.lower):.3f} and {np.degrees(balloon.upper):.3f} deg"
        )
        return f"NOT KNOWN{f', {balloon.why}' if balloon.why else between}"
    need = np.degrees(balloon.upper if balloon.go else balloon.lower)
    archive_text = (
        ""
        if np.isnan(balloon.archive_fraction)
        else f", more than {100 * balloon.archive_fraction:.0f} % of the archive"
    )
    return f"{'GO' if balloon.go else 'NO GO'}, it asks for {need:.3f} deg{archive_text}"
