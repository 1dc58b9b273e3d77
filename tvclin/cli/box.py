"""What `tvclin margins --box` adds: the worst margins when numbers lie anywhere in a box."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from tvclin.cli.output import print_tables, say

if TYPE_CHECKING:
    from tvclin.answers.case import Case
    from tvclin.answers.worst_case import WorstCase
    from tvclin.control.autopilot.autopilot import Autopilot
    from tvclin.control.margins.criteria import Criteria
    from tvclin.vehicle.vehicle import Vehicle
    from tvclin.winds.shaped import ShapedWind

Box = Annotated[
    list[str] | None,
    typer.Option(
        "--box",
        metavar="KEY=LO..HI",
        help="A number that may lie anywhere between two values, as delay_ms=0..40 or"
        " thrust_kN=2400..2600: a key with its unit, as in a vehicle file. Or in percent of the"
        " nominal value, without a unit: thrust=-3%..3%. May be given several times. Keys: those"
        " of a vehicle, wind_peak, wind_duration, the gains, gain (a factor on all gains), delay,"
        " actuator_frequency and actuator_damping.",
    ),
]


def worst_in_box(given: list[str], case: "Case", autopilot: "Autopilot") -> "WorstCase | None":
    """Return the worst case in the box of the options; None without one."""
    if not given:
        return None
    from dataclasses import replace

    from tvclin.answers.worst_case import BOX_TABLE, worst_case
    from tvclin.base.errors import InputError
    from tvclin.base.tables import known
    from tvclin.vehicle.linear_vehicle import whole_vehicle
    from tvclin.winds.shaped import ShapedWind

    vehicle, wind = whole_vehicle(case.vehicle, "--box"), case.blows
    autopilot = replace(autopilot, sample_rate=None)
    if not isinstance(wind, ShapedWind):
        raise InputError(
            "--box moves peak and duration of a pulse: give no --winds with it; --flown goes"
            " through a sounding"
        )
    box: dict[str, tuple[float, float]] = {}
    for one in given:
        key, ends, percent = _parted(one)
        if percent:
            known("number of --box", [key], BOX_TABLE.quantities)
            name, centre = key, _nominal(key, vehicle, autopilot, wind)
            if not centre:
                raise InputError(
                    f"--box {one}: {key} has no nominal value for a percentage; give both ends in"
                    " its unit"
                )
            factor = 0.01 * abs(centre)
        else:
            ((name, factor),), centre = BOX_TABLE.read({key: 1.0}).items(), 0.0
        if name in box:
            raise InputError(f"--box gives {name} twice")
        box[name] = (centre + factor * ends[0], centre + factor * ends[1])
    model, plane = case.plant.model, case.plane
    return worst_case(vehicle, autopilot, box, model=model, plane=plane, wind=wind)


def _parted(one: str) -> tuple[str, tuple[float, float], bool]:
    """The key, the two numbers, and whether they are in percent."""
    from tvclin.base.errors import InputError

    key, found, ends = one.partition("=")
    low, dots, high = (part.strip() for part in ends.partition(".."))
    if not found or not dots:
        raise InputError(
            f"--box must be KEY=LO..HI, as in delay_ms=0..40 or thrust=-3%..3%; got {one!r}"
        )
    percent = low.endswith("%") and high.endswith("%")
    if percent:
        low, high = low.removesuffix("%"), high.removesuffix("%")
    try:
        return key.strip(), (float(low), float(high)), percent
    except ValueError:
        raise InputError(
            f"--box must have two numbers beside the dots, both in percent or neither; got {one!r}"
        ) from None


def _nominal(name: str, vehicle: "Vehicle", autopilot: "Autopilot", wind: "ShapedWind") -> float:
    """The nominal value of a number; zero where there is none."""
    actuator = autopilot.actuator
    known: dict[str, Any] = {**vars(vehicle), **vars(autopilot), **wind.nominal, "gain": 1.0}
    if actuator is not None:
        known["actuator_frequency"] = actuator.natural_frequency
        known["actuator_damping"] = actuator.damping
    value = known.get(name)
    return float(value) if isinstance(value, int | float) else 0.0


def met_in_box(found: "WorstCase", asked: "Criteria") -> bool:
    """Return whether the worst margins are those that are asked for, as far as they are known."""
    return found.stable and all(
        found.margins[one.margin].value >= one.limit
        for one in asked.requirements
        if one.margin in found.margins
    )


def print_worst(found: "WorstCase", asked: "Criteria") -> None:
    """Print the worst margins and the worst deflection, where they are, and the verdict."""
    from tvclin.answers.worst_case import unit_of

    print_tables(found.table())
    if not found.stable:
        say("In this box the loop becomes UNSTABLE; its margins count as zero there.")
    worst = found.margins["disk_margin"]
    at = ", ".join(f"{k} = {v:.5g} {unit_of(k)}".rstrip() for k, v in worst.at.items())
    say(f"Worst disk margin at: {at}")
    say(f"Criteria {asked.name} in the box: {'MET' if met_in_box(found, asked) else 'NOT MET'}")
