"""The sounding of `tvclin fly`: what its flight meets around the vehicle's own time."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tvclin.cli.options import TIME_HELP
from tvclin.cli.output import say

if TYPE_CHECKING:
    from tvclin.vehicle.vehicle import Vehicle
    from tvclin.winds.histories import History

Winds = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="A sounding to fly through, in place of a pulse."),
]
Window = Annotated[
    float | None,
    typer.Option(
        help="Length of the part of the sounding that counts, about the vehicle's own time of"
        " flight, in s.",
        show_default="20",
    ),
]
WindsTime = Annotated[
    str | None,
    typer.Option(metavar="TIME", help=f"Which sounding of a file that holds several, {TIME_HELP}"),
]
_WINDOW = 20.0


def sounding_wind(
    source: str,
    vehicle: "Vehicle",
    file: Path,
    time_utc: str | None,
    azimuth_deg: float | None,
    window: float | None,
    plane: str,
    along: bool,
) -> "History":
    """Return what a flight meets of a sounding, from t = 0 on, or in flight time.

    As in `tvclin size`, what blows to the side on which the wind is largest counts.
    """
    import numpy as np

    from tvclin.answers.sizing.measured import fly_through
    from tvclin.answers.sizing.placing import place
    from tvclin.answers.sizing.schedule_file import load_schedule
    from tvclin.base.errors import InputError, between, number, positive
    from tvclin.winds.soundings.read import read_sounding

    if azimuth_deg is None:
        raise InputError("--winds needs --azimuth-deg, the direction of flight")
    if vehicle.time is None:
        raise InputError("--winds needs a vehicle with its time of flight, time_s")
    length = _WINDOW if window is None else number("--window", window, positive, "s")
    azimuth = float(np.radians(number("--azimuth-deg", azimuth_deg, between(-360.0, 360.0), "deg")))
    flight, time = load_schedule(source), float(vehicle.time)
    profile = read_sounding(file, time=time_utc)
    for note in profile.notes:
        say(f"Note: {file.name}: {note}.", err=True)
    met = fly_through(profile, flight, azimuth=azimuth, plane=plane, window=length)
    placed = place(met, vehicle, time, "peak", length)
    if not placed.known or placed.calm:
        word = "calm" if placed.known else "not known"
        raise InputError(f"the wind of {file.name} is {word} at {time:g} s, the vehicle's time")
    first, last = met.known
    if time - length / 2 < first or last < time + length / 2:
        say(
            f"Note: {file.name} is known from {first:.6g} to {last:.6g} s of flight only; what"
            " blows beyond is not counted.",
            err=True,
        )
    return placed.in_flight if along else placed.in_flight.shift(-placed.span[0])
