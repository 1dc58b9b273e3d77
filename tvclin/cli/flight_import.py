"""`tvclin import`: flight schedules from files of other tools."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from tvclin.ascent.importers.column_map import read_table
from tvclin.ascent.importers.openrocket import read_openrocket
from tvclin.ascent.importers.rasaero import read_rasaero
from tvclin.ascent.importers.simulation_log import read_log
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.errors import InputError, shown
from tvclin.base.files import called, read_text, tables_of
from tvclin.base.lines import Table, words
from tvclin.cli.options import GROUP, More, grouped, option, to_write
from tvclin.cli.output import print_answer, say
from tvclin.vehicle.coefficients import Coefficients

import_ = typer.Typer(
    no_args_is_help=True,
    help="Make a flight schedule, for tvclin ascent, of a flight that another tool has simulated.",
    epilog="Then: tvclin ascent my-flight.csv --peak-deg 5 --limit-deg 3",
)

File = Annotated[Path, typer.Argument(help="The file that the tool exported.")]
Output = Annotated[
    Path,
    typer.Option("-o", "--output", help="The schedule to write, a CSV file.", callback=to_write),
]
Gimbal = Annotated[float, typer.Option(help="Station of the gimbal, in m from the nose tip aft.")]


@dataclass(frozen=True)
class Site:
    """Options of the slope of the normal force and the launch site; `grouped` gives them."""

    cn_alpha_per_rad: float | None = option("Slope of the normal force coefficient, per rad.")
    cn_alpha: Path | None = option(
        "The slope over Mach in place of one number: a table of RASAero II or OpenRocket.",
        flag="--cn-alpha",
    )
    ground_m: float | None = option(
        "Elevation of the launch site above the sea, in m, from -450 to 9000."
    )

    @property
    def arguments(self) -> dict[str, Any]:
        """Arguments of a reader: the slope, and the elevation of the ground [m]."""
        number, table = self.cn_alpha_per_rad, self.cn_alpha
        if number is not None and table is not None:
            raise InputError("give --cn-alpha-per-rad or --cn-alpha, not both")
        slope = number if table is None else table
        return {"normal_force_coefficient_slope": slope, "ground": self.ground_m}


@dataclass(frozen=True)
class Rows:
    """Options that select the rows of a file; `grouped` gives them to a command.

    The fields have the names of the arguments of the readers, such as `read_table`.
    """

    start: float | None = option("Earliest time, in s.", flag="--from")
    stop: float | None = option("Latest time, in s.", flag="--to")
    max_rows: int = option(
        "Most rows to write; a longer flight is thinned to straight lines.",
        200,
        flag="--most-rows",
    )


@import_.command()
@grouped
def openrocket(
    file: File,
    gimbal_station_m: Gimbal,
    output: Output,
    site: Site = GROUP,
    reference_area_m2: float | None = option(
        "Reference area of a given slope, in m^2.", shown="that of the file"
    ),
    rows: Rows = GROUP,
    more: More = False,
) -> None:
    """Read the data that OpenRocket exports of a simulation without wind.

    Exit code 0: written; 2: bad input, and nothing is written.
    """
    imported = read_openrocket(
        file,
        gimbal_station=gimbal_station_m,
        reference_area=reference_area_m2,
        **site.arguments,  # slope of the normal force, and launch site
        **vars(rows),  # times, and number of rows
    )
    _write(imported, output, more)


@import_.command()
@grouped
def rasaero(
    file: File,
    gimbal_station_m: Gimbal,
    output: Output,
    inertia: Annotated[
        list[str],
        typer.Option(
            metavar="TIME:KG_M2",
            help="A time, in s, and the moment of inertia at it; give two or more.",
        ),
    ],
    site: Site = GROUP,
    rows: Rows = GROUP,
    more: More = False,
) -> None:
    """Read the flight that RASAero II exports, of a simulation without wind.

    Exit code 0: written; 2: bad input, and nothing is written.
    """
    arguments = site.arguments
    if arguments["normal_force_coefficient_slope"] is None:
        raise InputError("give --cn-alpha-per-rad, or --cn-alpha with RASAero's aerodynamics")
    imported = read_rasaero(
        file,
        gimbal_station=gimbal_station_m,
        moment_of_inertia=_inertias(inertia),
        **arguments,  # slope of the normal force, and launch site
        **vars(rows),  # times, and number of rows
    )
    _write(imported, output, more)


@import_.command()
@grouped
def table(
    file: File,
    output: Output,
    columns: Annotated[
        Path,
        typer.Option(help='TOML file with a table named columns: weight = "Gross weight (lbf)".'),
    ],
    rows: Rows = GROUP,
    more: More = False,
) -> None:
    """Read any table with a line of column names, with --columns to say which is which.

    Exit code 0: written; 2: bad input, and nothing is written.
    """
    schedule = read_table(file, _columns(columns), **vars(rows))
    _write(schedule, output, more)


@import_.command()
@grouped
def log(
    file: Annotated[
        Path, typer.Argument(help="A table with column names, or a .mat file of version 5.")
    ],
    output: Output,
    wind_output: Path | None = option(
        "Also write the wind that the flight encountered, over height, as CSV.", callback=to_write
    ),
    columns: Path | None = option(
        "TOML file with a table named columns, as of tvclin import table.",
        shown="our names, with their units",
    ),
    rows: Rows = GROUP,
    more: More = False,
) -> None:
    """Read the log of a simulation in wind: a schedule, and the wind that it encountered.

    The flight is to the north, azimuth 0, and the wind along it. The wind is the column
    wind_angle_deg, wind_speed_m_per_s, or angle_of_attack_deg.

    Exit code 0: written; 2: bad input, and nothing is written.
    """
    result = read_log(file, None if columns is None else _columns(columns), **vars(rows))
    if wind_output is None:
        _write(result.schedule, output, more)
        return
    result.profile  # noqa: B018  # nothing is written where it has none
    _write(result.schedule, output, more)
    result.write_wind(wind_output)
    say(f"Wrote {called(wind_output)}: add --winds {wind_output} --azimuth-deg 0")


def _columns(file: Path) -> dict[str, Any]:
    """Return the table [columns] of a TOML file: names of columns, or numbers, by quantity."""
    document = tables_of(read_text(file, "a TOML file of columns"), str(file))
    columns = document.get("columns")
    if not isinstance(columns, dict) or len(document) > 1:
        raise InputError(f"{called(file)} must hold one table [columns] and nothing beside it")
    return columns


def _inertias(texts: list[str]) -> tuple[list[float], list[float]]:
    """Return times [s] and moments of inertia [kg m^2] of options such as 0:24."""
    try:
        pairs = [tuple(map(float, text.split(":"))) for text in texts]
        times, inertias = zip(*pairs, strict=True)
    except ValueError:
        raise InputError(
            "--inertia must be a time and a moment of inertia, such as 0:24; got"
            f" {shown(' '.join(texts))}"
        ) from None
    return list(times), list(inertias)


def _write(schedule: FlightSchedule, output: Path, more: bool) -> None:
    """Write a schedule into the file `output`, and print its coefficients over time and its notes.

    `more`: whether all notes are printed. Notes on single columns come last.
    """
    schedule.to_csv(output)
    written = f"wrote {called(output)}: {schedule.times.size} times. Then: tvclin ascent {output}"
    # a note "weight: ..." says where a column comes from, and no more
    columns = [note for note in schedule.notes if note.partition(":")[0].isidentifier()]
    notes = [*(note for note in schedule.notes[::-1] if note not in columns), *columns]
    print_answer(written, _table(schedule), notes=notes, more=more)


def _table(schedule: FlightSchedule) -> Table:
    """Return the table of the coefficients at the first, the middle and the last time."""
    first, last = schedule.span
    times = np.array([first, 0.5 * (first + last), last])
    c = Coefficients.from_vehicle(schedule.at(times))
    rows = [
        [f"{t:.4g}", f"{mu_alpha:.4f}", f"{mu_delta:.4f}", f"{B:.5f}"]
        for t, mu_alpha, mu_delta, B in np.column_stack([times, c.mu_alpha, c.mu_delta, c.B])
    ]
    head = ["t [s]", "mu_alpha [1/s^2]", "mu_delta [1/s^2]", "B [-]"]
    return words(schedule.vehicle.name, head, rows)
