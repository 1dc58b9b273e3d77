"""Option --box of `tvclin design`: the worst margins and deflection between bounds of numbers."""

from dataclasses import dataclass, replace
from typing import Annotated, Any

import typer

from tvclin.base.errors import InputError
from tvclin.base.quantities import satisfaction
from tvclin.base.tables import known
from tvclin.cli.output import say
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.margins.criteria import Criteria
from tvclin.design.worst_case import BOX_TABLE, WorstCase, unit_of, worst_case
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.linear_vehicle import complete_vehicle
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


@dataclass(frozen=True, eq=False)
class BoxResult:
    """The worst case in a box, and the criteria of its margins."""

    worst: WorstCase
    criteria: Criteria

    @property
    def satisfied(self) -> bool:
        """Whether the worst margins satisfy the criteria, as far as they are known."""
        return self.worst.stable and all(
            self.worst.margins[criterion.margin].value >= criterion.limit
            for criterion in self.criteria.limits
            if criterion.margin in self.worst.margins
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the worst case and the verdict, for JSON."""
        return self.worst.as_dict() | {"met": self.satisfied}

    @property
    def verdict(self) -> str:
        """Verdict on the criteria in the box, with the worst disk margin and its position."""
        disk = self.worst.margins["disk_margin"]
        at = ", ".join(f"{k} = {v:.5g} {unit_of(k)}".rstrip() for k, v in disk.at.items())
        word = satisfaction(self.satisfied)
        unstable = "" if self.worst.stable else "; the loop becomes UNSTABLE there"
        return (
            f"criteria {self.criteria.name} in the box: {word}; worst disk margin {disk.value:.3f}"
            f" at {at}{unstable}"
        )


def worst_in_box(given: list[str], case: StudyPlan, autopilot: Autopilot) -> BoxResult | None:
    """Return the worst case in the box of the options, of the rigid vehicle; None without one."""
    if not given:
        return None
    vehicle, wind = complete_vehicle(case.vehicle, "--box"), case.wind_in_plane
    loop = replace(autopilot, sample_rate=None)
    if not isinstance(wind, ShapedWind):
        raise InputError(
            "--box moves peak and duration of a pulse: give no --winds with it; tvclin margins"
            " --limit-deg goes through a sounding"
        )
    box: dict[str, tuple[float, float]] = {}
    for text in given:
        name, ends = _interval(text, vehicle, loop, wind)
        if name in box:
            raise InputError(f"--box gives {name} twice")
        box[name] = ends
    if autopilot.sample_rate is not None:
        say("Note: the margins in the box are of the continuous autopilot.", err=True)
    worst = worst_case(vehicle, loop, box, model=case.plant.model, plane=case.plane, wind=wind)
    return BoxResult(worst, case.held_to.without_mode_limits or case.held_to)


def _interval(
    text: str, vehicle: Vehicle, autopilot: Autopilot, wind: ShapedWind
) -> tuple[str, tuple[float, float]]:
    """Return the name of a number, and its two ends [SI]."""
    key, (low, high), percent = _split(text)
    if not low < high:
        raise InputError(f"--box must have a smaller and a larger value, LO..HI; got {text!r}")
    if not percent:
        ((name, factor),) = BOX_TABLE.read({key: 1.0}).items()
        return name, (factor * low, factor * high)
    known("number of --box", [key], BOX_TABLE.quantities)
    centre = _nominal(key, vehicle, autopilot, wind)
    if not centre:
        raise InputError(
            f"--box {text}: {key} has no nominal value for a percentage; give both ends in its unit"
        )
    factor = 0.01 * abs(centre)
    return key, (centre + factor * low, centre + factor * high)


def _split(text: str) -> tuple[str, tuple[float, float], bool]:
    """Return the key, the two numbers, and whether they are in percent."""
    key, equals, ends = text.partition("=")
    low, dots, high = (end.strip() for end in ends.partition(".."))
    if not equals or not dots:
        raise InputError(
            f"--box must be KEY=LO..HI, as in delay_ms=0..40 or thrust=-3%..3%; got {text!r}"
        )
    percent = low.endswith("%") and high.endswith("%")
    if percent:
        low, high = low.removesuffix("%"), high.removesuffix("%")
    try:
        return key.strip(), (float(low), float(high)), percent
    except ValueError:
        raise InputError(
            f"--box must have two numbers beside the dots, both in percent or neither; got {text!r}"
        ) from None


def _nominal(name: str, vehicle: Vehicle, autopilot: Autopilot, wind: ShapedWind) -> float:
    """Return the nominal value of a number; zero where none is defined."""
    actuator = autopilot.actuator
    values: dict[str, Any] = {**vars(vehicle), **vars(autopilot), **wind.nominal, "gain": 1.0}
    if actuator is not None:
        values["actuator_frequency"] = actuator.natural_frequency
        values["actuator_damping"] = actuator.damping
    value = values.get(name)
    return float(value) if isinstance(value, int | float) else 0.0
