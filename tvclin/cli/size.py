"""`tvclin size`: how much deflection a whole flight needs, and whether the limit covers it all."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tvclin.cli.inputs import peak_angle
from tvclin.cli.options import (
    MODELS_HELP,
    AsJson,
    Duration,
    PeakDeg,
    PeakSpeed,
    Plane,
    Plot,
    Wind,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tvclin.sizing import DeflectionTotal, FlightSchedule, Sizing
    from tvclin.sizing.placing import WindOf

_SOURCE = (
    "A flight schedule (CSV, or TOML with a table named schedule), or a vehicle whose file has a"
    " table named flight: then its nominal flight."
)


def size(
    source: Annotated[
        str, typer.Argument(metavar="SCHEDULE_OR_VEHICLE", help=_SOURCE)
    ] = "configuration-i",
    wind: Wind = "triangular",
    duration: Duration = 7.5,
    peak_deg: PeakDeg = None,
    peak_speed: PeakSpeed = None,
    begin: Annotated[
        float | None, typer.Option("--from", help="First flight time, in s; as early as it goes.")
    ] = None,
    end: Annotated[
        float | None, typer.Option("--to", help="Last flight time, in s; as late as it goes.")
    ] = None,
    every: Annotated[float, typer.Option(help="Time between flight times, in s.")] = 5.0,
    dead_band: Annotated[
        list[float] | None,
        typer.Option(help="Dead band K, from 0 to 1; may be given several times. 1 and 0.5."),
    ] = None,
    model: Annotated[str, typer.Option(help=f"Model: {MODELS_HELP}")] = "drift-exact",
    plane: Plane = "pitch",
    law: Annotated[
        str,
        typer.Option(
            help="Laws without a forecast: their bound, or one flown (slow): bound, flown."
        ),
    ] = "bound",
    varying: Annotated[
        bool, typer.Option("--varying", help="Let parameters vary while the wind blows as well.")
    ] = False,
    limit_deg: Annotated[
        float | None, typer.Option(help="Deflection capability, in deg: is it sufficient?")
    ] = None,
    count: Annotated[
        str | None, typer.Option(help="Requirement that counts as the wind's: K = 1, trim, ...")
    ] = None,
    dispersion: Annotated[
        float, typer.Option(help="What dispersions add, as a part of the wind's requirement.")
    ] = 0.0,
    disperse: Annotated[
        bool,
        typer.Option(
            "--disperse", help="Find that part: 2000 cases at the worst time, as of tvclin study."
        ),
    ] = False,
    thrust_offset_deg: Annotated[
        float, typer.Option(help="Angle of the thrust off the nozzle's axis, in deg.")
    ] = 0.0,
    gravity_offset_m: Annotated[
        float, typer.Option(help="Distance of the centre of gravity from the axis, in m.")
    ] = 0.0,
    reserve: Annotated[
        float, typer.Option(help="Part of the limit that is to stay unused, from 0 to 1.")
    ] = 0.0,
    as_json: AsJson = False,
    csv: Annotated[
        Path | None, typer.Option(help="Also write every flight time and wind into this file.")
    ] = None,
    plot: Plot = None,
) -> None:
    """Say how much deflection a flight needs at each time, and whether its limit is enough.

    Each wind is moved so that its peak meets the flight time.

    Exit code 0: sufficient, or no limit was given; 1: not sufficient; 2: bad input.
    """
    import numpy as np

    from tvclin.cli.output import print_json
    from tvclin.errors import one_of, within
    from tvclin.sizing import load_schedule, worst_total
    from tvclin.sizing import size as sized

    limit = (
        None
        if limit_deg is None
        else np.radians(float(within("--limit-deg", limit_deg, 1e-6, 90.0)))
    )
    schedule = load_schedule(source)
    found = sized(
        schedule,
        _winds(wind, duration, peak_deg, peak_speed, plane),
        times=_times(schedule, duration, begin, end, every),
        dead_bands=dead_band or (1.0, 0.5),
        model=model,
        plane=plane,
        law=law,
        varying=varying,
    )
    counted = one_of("--count", count or f"K = {found.dead_bands[0]:g}", found.required)
    if disperse:
        dispersion = _dispersed(found, counted, wind, duration, (peak_deg, peak_speed))
    total = worst_total(
        found,
        counted,
        dispersion=dispersion,
        thrust_offset=np.radians(thrust_offset_deg),
        gravity_offset=gravity_offset_m,
        reserve=reserve,
        limit=limit,
    )
    if csv is not None:
        found.to_csv(csv)
    if plot is not None:
        from tvclin.plots import save_figure, sizing_chart

        save_figure(sizing_chart(found, limit), plot)
    if as_json:
        print_json(_document(found, total))
    else:
        _print(found, total, source)
    if total.sufficient is False:
        raise typer.Exit(1)


def _winds(
    shape: str, duration: float, peak_deg: float | None, peak_speed: float | None, plane: str
) -> dict[str, "WindOf"]:
    """The winds by name, each for the vehicle that meets it: a speed makes different angles."""
    from tvclin.errors import one_of
    from tvclin.study import SHAPES

    make = SHAPES[one_of("wind", shape, SHAPES)]

    def met(vehicle: Any) -> Any:
        return make(peak=peak_angle(vehicle, plane, peak_deg, peak_speed), duration=duration)

    strength = f"{5.0 if peak_deg is None else peak_deg:g} deg"
    if peak_speed is not None:
        strength = f"{peak_speed:g} m/s"
    return {f"{shape} wind of {strength}, {duration:g} s": met}


def _dispersed(
    found: "Sizing",
    counted: str,
    shape: str,
    duration: float,
    peak: tuple[float | None, float | None],
) -> float:
    """What dispersions add at the worst flight time, as a part of what is counted there."""
    from tvclin.campaign import disperse_study
    from tvclin.errors import InputError
    from tvclin.study import Study

    bands = {f"K = {K:g}": float(K) for K in found.dead_bands}
    if counted not in bands or counted not in found.worst:
        raise InputError(f"--disperse needs a dead band to count, such as K = 1; got {counted}")
    vehicle = found.schedule.at(found.worst[counted].time)
    nominal = Study.from_vehicle(
        vehicle,
        wind=shape,
        duration=duration,
        peak=peak_angle(vehicle, found.plane, *peak),
        dead_band=bands[counted],
        model=found.model,
        plane=found.plane,
    )
    return disperse_study(nominal).part


def _times(
    schedule: "FlightSchedule",
    duration: float,
    begin: float | None,
    end: float | None,
    every: float,
) -> "NDArray[Any]":
    """Even flight times; without ends as many as the schedule covers with the whole wind."""
    import numpy as np

    from tvclin.errors import InputError, finite, positive

    step, half = (
        float(positive("--every", every, "s")),
        0.5 * float(positive("--duration", duration)),
    )
    first, last = schedule.span
    if last - first < 2.0 * half:
        half = 0.0
    low = np.ceil((first + half) / step) * step if begin is None else float(finite("--from", begin))
    high = last - half if end is None else float(finite("--to", end))
    if high < low:
        raise InputError(f"--to must not be before --from; got {low:g} to {high:g} s")
    if (high - low) / step > 10_000:
        raise InputError(f"--every must give at most 10000 flight times; got {step:g} s")
    return low + step * np.arange(np.floor((high - low) / step * (1.0 + 1e-12)) + 1)


def _print(found: "Sizing", total: "DeflectionTotal", source: str) -> None:
    from tvclin.sizing.record import VARYING

    name = found.schedule.vehicle.name or source
    typer.echo(f"{name}, {found.model}, {found.plane}: {', '.join(found.winds)}\n")
    frozen = [name for name in found.required if not name.endswith(VARYING)]
    _print_required(found, "Required deflection [deg]", frozen)
    if len(frozen) < len(found.required):
        rest = [name for name in found.required if name not in frozen]
        _print_required(found, "The same, parameters varying while the wind blows [deg]", rest)
    if not found.steady.all() or found.beyond_one_pole.any():
        typer.echo("1: beyond one pole; ~: parameters change meanwhile; +: beyond the schedule")
    law = "the bound of all such laws" if found.law == "bound" else "the recoverable-attitude law"
    typer.echo(f"no forecast: {law}; minimum: the wind known, appendix C")
    _print_total(total)
    for note in found.notes:
        typer.echo(f"Note: {note}.")


def _print_required(found: "Sizing", title: str, names: list[str]) -> None:
    import numpy as np

    from tvclin.cli.output import print_table
    from tvclin.sizing.record import VARYING

    columns = [np.degrees(found.at_times(name)) for name in names]
    rows = [
        [f"{time:g}", *(f"{column[i]:.4f}" for column in columns), _doubts(found, i)]
        for i, time in enumerate(found.times.tolist())
    ]
    print_table(title, ["time [s]", *(name.removesuffix(VARYING) for name in names), ""], rows)


def _print_total(total: "DeflectionTotal") -> None:
    import numpy as np

    from tvclin.cli.output import print_pairs

    pairs = [
        (f"{line.name} ({line.kind})", f"{np.degrees(line.deflection):.4f} deg")
        for line in total.lines
    ]
    pairs.append(
        ("total: systematic added, random in squares", f"{np.degrees(total.total):.4f} deg")
    )
    if total.reserve:
        said = f"{np.degrees(total.required):.4f} deg"
        pairs.append((f"limit that keeps {100 * total.reserve:g} % in reserve", said))
    print_pairs(f"\nThe worst flight time, {total.time:g} s", pairs, columns=1)
    if total.limit is not None and total.left is not None:
        word = "SUFFICIENT" if total.sufficient else "NOT SUFFICIENT"
        left = np.degrees(total.left)
        typer.echo(f"Limit {np.degrees(total.limit):.4f} deg: {word}, by {left:+.4f} deg")


def _doubts(found: "Sizing", i: int) -> str:
    """Marks of a flight time: what is doubtful there in any wind."""
    from tvclin.sizing.record import STEADY

    marks = {
        "1": found.beyond_one_pole[i].any(),
        "~": (found.change[i] > STEADY).any(),
        "+": not found.covered[i].all(),
    }
    return "".join(mark for mark, there in marks.items() if there)


def _document(found: "Sizing", total: "DeflectionTotal") -> dict[str, Any]:
    import numpy as np

    deg = np.degrees
    return {
        "vehicle": found.schedule.vehicle.name,
        **{name: getattr(found, name) for name in ("model", "plane", "switch", "law")},
        "winds": found.winds,
        "times_s": found.times,
        "required_deg": {name: deg(values) for name, values in found.required.items()},
        "begins_s": found.begins,
        "ends_s": found.ends,
        "change": found.change,
        "covered": found.covered,
        "beyond_one_pole": found.beyond_one_pole,
        "single_pole_edge_s": found.edge,
        "worst": {
            name: {"deflection_deg": deg(one.deflection), "time_s": one.time, "wind": one.wind}
            for name, one in found.worst.items()
        },
        "total": {
            "time_s": total.time,
            "lines": [
                {"name": one.name, "deflection_deg": deg(one.deflection), "kind": one.kind}
                for one in total.lines
            ],
            "total_deg": deg(total.total),
            "reserve": total.reserve,
            "required_deg": deg(total.required),
        },
        "notes": found.notes,
        "verdict": {
            "limit_deg": None if total.limit is None else deg(total.limit),
            "sufficient": total.sufficient,
            "left_deg": None if total.left is None else deg(total.left),
        },
    }
