"""`tvclin availability`: on how many days of an archive the nozzle is sufficient."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from tvclin.base.errors import InputError, within
from tvclin.base.files import called
from tvclin.case.case import DEFAULT_WIND
from tvclin.cli.inputs import note_omissions, note_vehicle_warnings
from tvclin.cli.options import LIMIT, MODEL, SIZING, AsJson, More, Options, Plot, option, to_write
from tvclin.cli.output import (
    answer,
    bar,
    draw,
    note_below,
    print_answer,
    print_tables,
    say,
    waiting,
)
from tvclin.ensembles.availability import availability_record as answer_tables
from tvclin.ensembles.availability.availability import unmeasured_notes
from tvclin.ensembles.availability.availability_record import Availability, Today
from tvclin.studyfile.read import is_flight, is_flight_with_keys, load_sizing, load_study
from tvclin.studyfile.settings import with_settings
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.coefficients import PLANE_TEXTS
from tvclin.vehicle.vehicle_file import source_tables
from tvclin.winds.shaped import refuse_gust_time
from tvclin.winds.soundings.archive import Soundings
from tvclin.winds.soundings.profile import WindProfile

_REQUEST = "ensembles.availability.availability.AvailabilityRequest"
_SHOWN_TIMES = {"start": "the first", "stop": "the last"}
"""Defaults of the flight times that count."""


def availability(
    source: Annotated[
        str,
        typer.Argument(
            metavar="SCHEDULE|VEHICLE|STUDY",
            help="A flight schedule (CSV or TOML) with its altitude, a vehicle with a flight, or a"
            " study file with a table availability.",
        ),
    ],
    archive: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="STATION...",
            help="A station file of IGRA (.txt or .zip), or files and folders of soundings.",
        ),
    ] = None,
    azimuth: list[float] | None = option(
        "Direction of flight, in deg from north, clockwise; may be given several times.",
        flag="--azimuth-deg",
    ),
    limit: Options = LIMIT,
    limit_shape: str | None = option(
        "Limit shape of the nozzle: round (root of the sum of squares) or square.", shown="round"
    ),
    model: Options = MODEL,
    question: Options = Options(_REQUEST, ("plane",)),
    months: list[int] | None = option(
        "Only this month, from 1 to 12; may be given several times.", flag="--month"
    ),
    times: Options = Options(SIZING, ("start", "stop"), shown=_SHOWN_TIMES),
    today: Path | None = option("Also judge this balloon of today: go or no go?", metavar="FILE"),
    as_json: AsJson = False,
    csv: Path | None = option(
        "Also write the bounds of the required deflection of every sounding into this file,"
        " lower_deg and upper_deg.",
        callback=to_write,
    ),
    plot: Plot = None,
    more: More = False,
) -> None:
    """Print on how many days of an archive of soundings the nozzle is sufficient.

    Each sounding is flown through along the whole flight, with trim up to the limit (K = 1), which
    needs no forecast. What a balloon did not see is unknown, not calm: above its last level a limit
    must be sufficient for 130 m/s against the vehicle, a bound with which a verdict can be GO where
    tvclin ascent, which assumes nothing there, is NOT KNOWN. Years, gust, persistence
    until launch and the format of files are keys: --set availability.years 1990,2020, --set
    availability.persistence_hours 3, --set gust.peak_speed_m_per_s 9, --set sounding.units ft,mph.

    Exit code 0: some soundings were judged; with --today: the limit is sufficient for that balloon,
    in every direction; 1: it is not, or that is not known; 2: bad input.
    """
    azimuths = azimuth and np.radians(within("--azimuth-deg", azimuth, -360.0, 360.0))
    keys: dict[str, Any] = {
        "availability.archive": [str(file.absolute()) for file in archive or ()],
        "availability.azimuth_deg": azimuth and azimuth[0],
        "availability.months": months,
        "availability.plane": question.values.get("plane"),
        "nozzle.limit_rad": limit.values.get("limit"),
        "nozzle.limit_shape": limit_shape,
        "study.model": model.values.get("model"),
    }
    with waiting("reading"):
        plan = _plan(source, keys)
        balloon = None if today is None else plan.reading.profile(today)
    assert plan.availability is not None
    flight = plan.availability.flight.between(times.values.get("start"), times.values.get("stop"))
    request = replace(plan.availability, flight=flight)
    with bar("soundings") as progress:
        towards = np.atleast_1d(request.azimuth if azimuths is None else azimuths)
        result = request.availability(plan, progress, towards)
    judged = () if balloon is None else result.today(balloon)
    for note in () if balloon is None else _balloon_notes(result, balloon):
        note_below(f"{called(today)}: {note}")
    _write(result, source, csv, plot)
    answer(
        as_json,
        lambda: _document(result, judged),
        lambda: _print(result, judged, source, more),
        all(day.go for day in judged) if judged else any(s.judged for s in result.fraction()),
    )


def _balloon_notes(result: Availability, balloon: WindProfile) -> list[str]:
    """Return the notes on the balloon of today, and on heights at which it measured no wind."""
    sounding = Soundings.from_profiles([balloon], ["2000-01-01"])  # its time does not count
    return [*balloon.notes, *unmeasured_notes(result.judge, sounding)]


def _write(result: Availability, source: str, csv: Path | None, plot: Path | None) -> None:
    """Write every sounding into the file `csv`, and the figure into `plot`, where they are given.

    `source`: name of the file, for the title of the figure.
    """
    from tvclin import plots

    if csv is not None:
        result.to_csv(csv)
    draw(plot, lambda: plots.availability_chart(result, source))


def _plan(source: str, keys: Mapping[str, Any]) -> StudyPlan:
    """Return the plan of a source with the keys that have a value, and note what is omitted of it.

    A study needs a wind, which an availability does not use: without one it gets `DEFAULT_WIND`.
    `keys`: values by key of a study file; None, or an empty list, is not given. `InputError`
    without an archive, a direction of flight or a limit, and for a gust with a time.
    """
    values = {key: value for key, value in keys.items() if value is not None and value != []}
    if "availability.months" in values:
        within("--month", values["availability.months"], 1, 12)
    tables = source_tables(source)
    named = [
        key.removeprefix("availability.") for key in (*values, *tables.get("availability", {}))
    ]
    for name, needed in {"archive": "a STATION", "azimuth": "--azimuth-deg"}.items():
        # a key may end in a unit, as azimuth_deg
        if not any(key.startswith(name) for key in named):
            station = name == "archive" and "station" in named
            hint = " (station there is the name of one of several)" if station else ""
            raise InputError(
                f"availability needs {needed}, or a file with {name} in [availability]{hint}"
            )
    if "study" in tables and "wind" not in tables:
        values |= {"wind.shape": DEFAULT_WIND.shape, "wind.peak_rad": DEFAULT_WIND.peak}
        values |= {"wind.duration_s": DEFAULT_WIND.duration}
    edited = with_settings(source, [(key, f"{value}") for key, value in values.items()])
    plan = load_sizing(edited) if is_flight_with_keys(edited) else load_study(edited)
    refuse_gust_time(getattr(plan.wind, "gust_at", None), "where it requires most")
    if plan.nozzle.limit is None:
        raise InputError("availability is judged for a limit: give --limit-deg")
    if not (is_flight_with_keys(source) or is_flight(source)):
        note_vehicle_warnings(plan.vehicle)
    elif plan.sizing is not None:
        for warning in plan.sizing.warnings:
            note_below(warning)
    note_omissions(plan, "availability")
    return plan


def _document(result: Availability, today: tuple[Today, ...]) -> dict[str, Any]:
    """Return an availability for JSON, with the verdict on the sounding `today` by azimuth."""
    document = result.as_dict()
    for towards, answer_today in zip(document["towards"], today, strict=False):
        towards["today"] = answer_today
    return document


def _print(result: Availability, launch: tuple[Today, ...], source: str, more: bool) -> None:
    """Print the fractions of soundings that fly, the verdict on a launch, and a table by month.

    `launch`: verdicts on the sounding of today by azimuth, empty without one. `source`: name of
    the file. `more`: whether the details are printed, and all notes.
    """
    azimuths = [f"{angle:.4g} deg" for angle in np.degrees(np.atleast_1d(result.azimuth)).tolist()]
    limit = f"limit {np.degrees(result.limit):.3f} deg, {PLANE_TEXTS[result.plane]}"
    days = zip(azimuths, result.fraction(), strict=True)
    shares = [f"towards {azimuth}: {fraction}" for azimuth, fraction in days]
    verdicts = [
        f"today towards {azimuth}: {_verdict(day, result.judge.flight.span)}"
        for azimuth, day in zip(azimuths, launch, strict=False)
    ]

    print_answer(
        "\n".join([*verdicts, f"{limit}, {shares[0]}", *shares[1:]]),
        answer_tables.by_month(result),
        notes=result.notes,
        more=more,
        details=lambda: _print_details(result, source),
    )


def _print_details(result: Availability, source: str) -> None:
    """Print the limits by fraction of soundings, the flight, the archive, and what is judged.

    `source`: name of the file, for a vehicle without a name.
    """
    name = result.judge.flight.vehicle.name or source
    begin, end = result.judged_in_all
    print_tables(answer_tables.placard(result))
    gust = result.judge.additions.gust_text
    say(f"{name}, {result.model}, {PLANE_TEXTS[result.plane]}: {result.soundings}{gust}")
    say(f"Judged from {begin:.4g} to {end:.4g} s of the flight. {answer_tables.interval(result)}")
    say(
        "A sounding whose trim reaches the required deflection more than once is judged for the"
        " given limit alone: lower_deg and upper_deg of the CSV bracket its requirement."
    )


def _verdict(balloon: Today, span: tuple[float, float]) -> str:
    """Return the verdict GO, NO GO or NOT KNOWN on a launch, with its requirement in degrees.

    `balloon`: verdict on the launch from one balloon. GO shows the upper bound of the required
    deflection, "at most", NO GO the lower one, "at least", where these differ, and the fraction of
    archived soundings that require less. NOT KNOWN (`go` is None) shows its reason, `why`, or else
    both bounds. Without such a reason the first and last flight time that are judged, `judged`,
    follow if they are not `span`, those of the flight [s].
    """
    times = ""
    if not balloon.why and balloon.judged != span:
        first, last = balloon.judged  # [s]
        times = f"; from {first:.4g} to {last:.4g} s, the rest is not judged"
    if balloon.go is None:
        between = (
            f", between {np.degrees(balloon.lower):.3f} and {np.degrees(balloon.upper):.3f} deg"
        )
        return f"NOT KNOWN{f', {balloon.why}' if balloon.why else between}{times}"
    need = np.degrees(balloon.upper if balloon.go else balloon.lower)
    archive_text = (
        ""
        if np.isnan(balloon.archive_fraction)
        else f", more than {100 * balloon.archive_fraction:.0f} % of the archive"
    )
    bound = "at most " if balloon.go else "at least "
    required = f"required {bound if balloon.lower < balloon.upper else ''}{need:.3f} deg"
    return f"{'GO' if balloon.go else 'NO GO'}, {required}{archive_text}{times}"
