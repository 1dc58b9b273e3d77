"""`tvclin vehicles` and `tvclin init`."""

from pathlib import Path
from typing import Annotated

import typer

from tvclin.cli.options import AsJson, At, option, switch
from tvclin.cli.output import say


def vehicles(as_json: AsJson = False) -> None:
    """List the vehicles that come with the package."""
    import numpy as np

    from tvclin.base.lines import words
    from tvclin.cli.output import print_json, print_tables
    from tvclin.vehicle.coefficients import Coefficients
    from tvclin.vehicle.vehicle_file import list_vehicles, load_vehicle

    rows, document = [], {}
    for key in list_vehicles():
        vehicle = load_vehicle(key)
        c = Coefficients.from_vehicle(vehicle)
        kinds = ("bending", "slosh")
        counts = {kind: len(getattr(vehicle.structure, kind, ())) for kind in kinds}
        beta = np.sqrt(c.mu_alpha)
        document[key] = {"name": vehicle.name, "beta_per_s": beta, "B": c.B, **counts}
        numbers = [f"{beta:.4f}", f"{c.B:.4f}", *map(str, counts.values())]
        rows.append([key, vehicle.name, *numbers])
    if as_json:
        print_json(document)
    else:
        head = ["key", "name", "beta [1/s]", "B [-]", "bending", "slosh"]
        print_tables(words("Vehicles", head, rows))


def init(
    file: Annotated[Path | None, typer.Argument(help="The file to write, such as my.toml.")] = None,
    study: bool = switch("--study", "A study file: vehicle, wind, laws, margins and more."),
    campaign: bool = switch("--campaign", "A campaign file, for tvclin disperse: many cases."),
    vehicle: str | None = option(
        "Copy this vehicle of the package instead (see: tvclin vehicles)."
    ),
    schedule: str | None = option(
        "Write the vehicle of this flight schedule at a time instead, with --at.",
        flag="--from",
        metavar="SCHEDULE",
    ),
    time: At = None,
    keys: bool = switch(
        "--keys",
        "List all keys of these files instead, for --set too, and the columns of tables of a"
        " flight, its structure and gains.",
    ),
) -> None:
    """Write a commented file to fill in: of a vehicle, or with --study of a whole study."""
    if keys:
        _print_keys(file)
        return
    from tvclin.base.errors import InputError, one_of
    from tvclin.base.files import called, write_new
    from tvclin.cli.inputs import only_with
    from tvclin.studyfile import campaign_file
    from tvclin.studyfile.read import study_template
    from tvclin.vehicle.vehicle_file import list_vehicles, read_vehicle_text, template

    if file is None:
        raise InputError("name the file to write, such as my.toml (or give --keys)")
    sources = {"--study": study, "--campaign": campaign, "--vehicle": vehicle is not None}
    sources |= {"--from": schedule is not None}
    if sum(sources.values()) > 1:
        raise InputError(f"give {' or '.join(name for name in sources if sources[name])}, not both")
    text = study_template() if study else template()
    if campaign:
        text = campaign_file.template()
    if schedule is None:
        only_with("--from", at=time)
    else:
        text = _vehicle_of_flight(schedule, time)
    if vehicle is not None:
        text, _ = read_vehicle_text(one_of("--vehicle", vehicle, list_vehicles()))
    write_new(file, text)
    name = called(file)
    then = f"tvclin {'report' if study else 'disperse' if campaign else 'study'} {name}"
    say(f"Wrote {name}. Fill in what differs, then: {then}")


def _print_keys(file: Path | None) -> None:
    """Print all keys of study and vehicle files; `InputError` with a file."""
    from tvclin.base.errors import InputError
    from tvclin.cli.output import print_tables
    from tvclin.studyfile.keys import column_tables, key_tables

    if file is not None:
        raise InputError("--keys writes no file; leave out its name")
    print_tables(*key_tables(), *column_tables())


def _vehicle_of_flight(schedule: str, time: float | None) -> str:
    """Return the text of a vehicle file for a flight schedule at a time [s].

    A vehicle without a name is named after the file and the time. The altitude, if known, stands in
    a comment, beside a specific impulse that the reader is to replace. `InputError` without a time.
    """
    import numpy as np

    from tvclin.ascent.schedule_file import load_schedule, load_vehicle_at
    from tvclin.base.errors import InputError
    from tvclin.vehicle.linear_vehicle import complete_vehicle
    from tvclin.vehicle.vehicle_file import missing_time_message, vehicle_file

    if time is None:
        raise InputError(missing_time_message(schedule))
    vehicle = complete_vehicle(load_vehicle_at(schedule, time), "--from")
    flight, key = load_schedule(schedule), f"{Path(schedule).stem} at {time:g} s"
    text = vehicle_file(vehicle.replace(name=vehicle.name or key))
    if flight.altitude is None:
        return text
    height = float(np.interp(time, flight.times, flight.height))
    return (
        f"{text}\n# [flight]  # for fly --engine planar-varying\n# altitude_m = {height:.10g}\n"
        "# specific_impulse_s = 260  # of this vehicle\n"
    )
