"""What `tvclin margins --box` adds: the worst margins when numbers lie anywhere in a box."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from tvclin.answers.worst_case import WorstCase
    from tvclin.cli.pulse import PulseOptions
    from tvclin.control.autopilot.autopilot import Autopilot
    from tvclin.control.margins.criteria import Criteria
    from tvclin.vehicle.linear_vehicle import AnyVehicle
    from tvclin.vehicle.vehicle import Vehicle
    from tvclin.winds.shaped import ShapedWind

Box = Annotated[
    list[str] | None,
    typer.Option(
        "--box",
        metavar="NAME=LO..HI",
        help="A number that lies anywhere between two values, in SI units, or in percent of the"
        " nominal one as in thrust=-3%..3%; may be given several times. Names: those of campaign"
        " dispersions, gain, delay, actuator_frequency, actuator_damping.",
    ),
]


def worst_in_box(
    given: list[str],
    loaded: "AnyVehicle",
    autopilot: "Autopilot",
    model: str,
    plane: str,
    blows: "PulseOptions",
) -> "WorstCase | None":
    """Return the worst case in the box of the options; None without one."""
    if not given:
        return None
    from tvclin.answers.worst_case import worst_case
    from tvclin.base.errors import InputError, one_of
    from tvclin.vehicle.linear_vehicle import whole_vehicle
    from tvclin.winds.shaped import PULSES, ShapedWind

    vehicle = whole_vehicle(loaded, "--box")
    shape = one_of("--wind", blows.wind, PULSES)
    wind = ShapedWind(shape, blows.peak(vehicle, plane), blows.duration)
    box = {}
    for one in given:
        name, found, ends = one.partition("=")
        low, dots, high = ends.partition("..")
        if not found or not dots:
            raise InputError(f"--box must be NAME=LO..HI, as in delay=0..0.04; got {one!r}")
        if name in box:
            raise InputError(f"--box gives {name} twice")
        nominal = _nominal(name, vehicle, autopilot, wind)
        box[name] = (_number(one, low, nominal), _number(one, high, nominal))
    return worst_case(vehicle, autopilot, box, model=model, plane=plane, wind=wind)


def _number(one: str, text: str, nominal: float | None) -> float:
    from tvclin.base.errors import InputError

    try:
        value = float(text.strip().removesuffix("%"))
    except ValueError:
        raise InputError(
            f"--box must have numbers on both sides of the dots; got {one!r}"
        ) from None
    if not text.strip().endswith("%"):
        return value
    if not nominal:
        raise InputError(f"--box {one}: there is no nominal value to take a percentage of")
    return nominal + 0.01 * value * abs(nominal)


def _nominal(
    name: str, vehicle: "Vehicle", autopilot: "Autopilot", wind: "ShapedWind"
) -> float | None:
    """The nominal value of a number; None where there is none."""
    actuator = autopilot.actuator
    known: dict[str, Any] = {**vars(vehicle), **vars(autopilot), **wind.nominal, "gain": 1.0}
    if actuator is not None:
        known |= {f"actuator_{k}": v for k, v in (("frequency", actuator.natural_frequency),)}
        known["actuator_damping"] = actuator.damping
    value = known.get(name)
    return float(value) if isinstance(value, int | float) else None


def met_in_box(found: "WorstCase", asked: "Criteria") -> bool:
    """Return whether the worst margins are those that are asked for, as far as they are known."""
    return found.stable and all(
        found.margins[one.margin].value >= one.limit
        for one in asked.requirements
        if one.margin in found.margins
    )


def print_worst(found: "WorstCase", asked: "Criteria") -> None:
    """Print the worst margins and the worst deflection, where they are, and the verdict."""
    import numpy as np

    from tvclin.answers.worst_case import unit_of
    from tvclin.cli.output import print_table
    from tvclin.control.margins.record import MARGINS, factor_to

    rows = []
    for name, one in found.margins.items():
        label, unit, _ = MARGINS[name]
        factor = factor_to(unit)
        cells = [f"{factor * value:.4g} {unit}".strip() for value in (one.nominal, one.value)]
        rows.append([label, *cells, _place(one.corner), one.how])
    if found.deflection is not None:
        one = found.deflection
        cells = [f"{np.degrees(value):.4g} deg" for value in (one.nominal, one.value)]
        rows.append(["required deflection", *cells, _place(one.corner), one.how])
    print_table("Worst case in the box", ["", "nominal", "worst", "at", "how"], rows)
    if not found.stable:
        typer.echo("In this box the loop becomes UNSTABLE; its margins count as zero there.")
    worst = found.margins["disk_margin"]
    at = ", ".join(f"{k} = {v:.5g} {unit_of(k)}".removesuffix(" -") for k, v in worst.at.items())
    typer.echo(f"Worst disk margin at: {at}")
    typer.echo(
        f"Criteria {asked.name} in the box: {'MET' if met_in_box(found, asked) else 'NOT MET'}"
    )


def _place(corner: bool) -> str:
    return "a corner" if corner else "inside"
