"""`tvclin availability`: on how many days of an archive the nozzle is enough."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tvclin.cli.inputs import note_source, only_with
from tvclin.cli.options import TIME_HELP, AsJson, Gust, Model, Plot
from tvclin.cli.output import print_tables, say, say_notes
from tvclin.cli.progress import bar
from tvclin.cli.wind import gust_of

if TYPE_CHECKING:
    from tvclin.answers.availability.growth import PairGrowth
    from tvclin.answers.availability.record import Availability, Today


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
    month: Annotated[
        list[int] | None,
        typer.Option(help="Only this month, from 1 to 12; may be given several times."),
    ] = None,
    years: Annotated[
        tuple[int, int] | None, typer.Option(metavar="FIRST LAST", help="Only these years.")
    ] = None,
    station: Annotated[
        str | None, typer.Option(help="Only this station, where there are several.")
    ] = None,
    in_order: Annotated[
        bool,
        typer.Option(
            "--in-order",
            help="Take files without a date in the order of their names, one a day from 2000-01-01"
            " on; of what month they are is then not known.",
        ),
    ] = False,
    utc_offset: Annotated[
        float, typer.Option(help="Local time minus UTC, in h: months are those of local time.")
    ] = 0.0,
    begin: Annotated[
        float | None,
        typer.Option(
            "--from", help="First flight time that counts, in s.", show_default="the first"
        ),
    ] = None,
    end: Annotated[
        float | None,
        typer.Option("--to", help="Last flight time that counts, in s.", show_default="the last"),
    ] = None,
    plane: Annotated[str, typer.Option(help="Plane that counts: both, pitch or yaw.")] = "both",
    stop: Annotated[
        str,
        typer.Option(help="Stop of the nozzle: round (root of the sum of squares) or square."),
    ] = "round",
    model: Model = None,
    persistence_deg: Annotated[
        float | None,
        typer.Option(help="Angle added for the change of wind until launch, in deg."),
    ] = None,
    persistence_hours: Annotated[
        float | None,
        typer.Option(
            help="In place of --persistence-deg, the hours from balloon to launch. Added is the"
            " growth of need that 95 % of the archive's pairs 12 h apart do not exceed, scaled to"
            " these hours."
        ),
    ] = None,
    gust: Gust = None,
    known_to_m: Annotated[
        float | None, typer.Option(help="Height that a sounding must reach to be judged, in m.")
    ] = None,
    confidence: Annotated[
        float, typer.Option(help="Confidence of the intervals, from 0 to 1.")
    ] = 0.95,
    today: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Also judge this balloon of today: go or no go?"),
    ] = None,
    today_time: Annotated[
        str | None,
        typer.Option(
            metavar="TIME", help=f"Which balloon of a --today that holds several, {TIME_HELP}"
        ),
    ] = None,
    as_json: AsJson = False,
    csv: Annotated[
        Path | None,
        typer.Option(
            help="Also write what every sounding needs into this file: need_deg (empty where"
            " --limit-deg is not judged), and its bounds, least_deg and most_deg."
        ),
    ] = None,
    plot: Plot = None,
) -> None:
    """Say on how many days of an archive of soundings the nozzle is enough.

    Each sounding is flown through along the whole flight, with trim up to the limit (K = 1), which
    needs no forecast. What a balloon did not see is unknown, not calm.

    Exit code 0: some soundings were judged; with --today: the limit is enough for that balloon, in
    every direction; 1: it is not, or that is not known; 2: bad input.
    """
    import numpy as np

    from tvclin.answers.availability.availability import availability as judged
    from tvclin.answers.sizing.schedule_file import load_schedule
    from tvclin.base.errors import within
    from tvclin.cli.output import print_json
    from tvclin.linear.models import USUAL_MODEL
    from tvclin.winds.soundings.read import read_sounding
    from tvclin.winds.soundings.read_soundings import read_soundings

    limit = np.radians(within("--limit-deg", limit_deg, 0.0, 90.0))
    azimuths = np.radians(within("--azimuth-deg", azimuth_deg, -360.0, 360.0))
    note_source(source, "availability")
    flight = load_schedule(source).between(begin, end)
    balloon = None
    if today is None:
        only_with("--today", today_time=today_time)
    else:
        balloon = read_sounding(today, time=today_time)
        for note in balloon.notes:
            say(f"Note: {today.name}: {note}.", err=True)
    with bar("read") as progress:
        soundings = read_soundings(
            archive,
            months=month or None,
            years=years,
            station=station,
            utc_offset=utc_offset,
            in_order=in_order,
            progress=progress,
        )
    with bar("soundings") as progress:
        found = judged(
            flight,
            soundings,
            limit=float(limit),
            azimuth=azimuths,
            plane=plane,
            stop=stop,
            model=model or USUAL_MODEL,
            persistence=_persistence(persistence_deg, persistence_hours),
            gust=gust_of(gust),
            known_to=known_to_m,
            confidence=confidence,
            progress=progress,
        )
    launch = () if balloon is None else found.today(balloon)
    if csv is not None:
        found.to_csv(csv)
    if plot is not None:
        from tvclin.plots import availability_chart, save_figure

        save_figure(availability_chart(found), plot)
    if as_json:
        document = found.as_dict()
        for towards, one in zip(document["towards"], launch, strict=False):
            towards["today"] = one
        print_json(document)
    else:
        _print(found, launch, source)
    judged_any = any(part.judged for part in found.part())
    if any(one.go is not True for one in launch) or (balloon is None and not judged_any):
        raise typer.Exit(1)


def _persistence(degrees: float | None, hours: float | None) -> "float | PairGrowth | None":
    import numpy as np

    from tvclin.answers.availability.growth import PairGrowth
    from tvclin.base.errors import InputError, within

    if degrees is not None and hours is not None:
        raise InputError("give --persistence-deg or --persistence-hours, not both")
    if hours is not None:
        return PairGrowth(hours)
    return (
        None
        if degrees is None
        else float(np.radians(within("--persistence-deg", degrees, 0.0, 90.0)))
    )


def _print(found: "Availability", launch: "tuple[Today, ...]", source: str) -> None:
    import numpy as np

    from tvclin.answers.availability import answer_tables

    name = found.judge.flight.vehicle.name or source
    say(f"{name}, {found.model}, {found.plane}: {found.soundings!r}\n")
    azimuths = [f"{one:.4g}" for one in np.degrees(np.atleast_1d(found.azimuth)).tolist()]
    begin, end = found.judged_in_all
    say(f"Limit {np.degrees(found.limit):.3f} deg, from {begin:.4g} to {end:.4g} s of the flight")
    for azimuth, part in zip(azimuths, found.part(), strict=True):
        say(f"towards {azimuth} deg: {part}")
    say(answer_tables.interval(found))
    typer.echo()
    print_tables(answer_tables.by_month(found), answer_tables.placard(found))
    say(
        "A sounding that meets its limit more than once is flown only if that decides about"
        f" {np.degrees(found.limit):.4g} deg. Else least_deg and most_deg of the CSV bracket what"
        " it asks for; need_deg is the lower of them, and empty where this limit is not judged. Ask"
        " again for another limit."
    )
    for azimuth, one in zip(azimuths, launch, strict=False):
        cut = one.judged != found.judge.flight.span and not one.why
        part = "; from {:.4g} to {:.4g} s, the rest is not judged".format(*one.judged) * cut
        say(f"Today towards {azimuth} deg: {_said(one)}{part}")
    say_notes(found.notes)


def _said(one: "Today") -> str:
    """What a balloon says, in words."""
    import numpy as np

    if one.go is None:
        between = f", between {np.degrees(one.least):.3f} and {np.degrees(one.most):.3f} deg"
        return f"NOT KNOWN{f', {one.why}' if one.why else between}"
    need = np.degrees(one.most if one.go else one.least)
    beside = "" if np.isnan(one.part) else f", more than {100 * one.part:.0f} % of the archive"
    return f"{'GO' if one.go else 'NO GO'}, it asks for {need:.3f} deg{beside}"
