"""What a nozzle can do: how far and how fast it turns, and what lies behind its command."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

from tvclin.base.errors import instance, number, positive, small_angle
from tvclin.base.tables import FileTable
from tvclin.boundary.stops import Stop, stop_of
from tvclin.control.autopilot.actuator import Actuator

_ACTUATOR = {"actuator_frequency": "natural frequency", "actuator_damping": "number"}
USUAL_ACTUATOR = Actuator()
NOZZLE_TABLE = FileTable(
    "[nozzle]", {"limit": "angle", "rate_limit": "angular rate", **_ACTUATOR}, words=("stop",)
)


@dataclass(frozen=True, kw_only=True)
class Nozzle:
    """What a nozzle can do.

    Attributes
    ----------
    limit : float, optional
        The deflection limit [rad] in question.
    stop : Stop or str, optional
        What it can do in both planes over its limit, or a word: "round", "round-each-plane" (each
        plane limited by itself within it), "square", "square-45" (turned by 45 degrees). With it
        both planes are judged, which share it.
    rate_limit : float, optional
        Largest deflection rate [rad/s], which counts in flights; none unless given.
    actuator : Actuator or None
        Between command and deflection.

    Raises
    ------
    InputError
        For numbers out of range, an unknown shape of a stop, and what is no actuator.
    """

    limit: float | None = None
    stop: Stop | str | None = None
    rate_limit: float | None = None
    actuator: Actuator | None = USUAL_ACTUATOR

    def __post_init__(self) -> None:
        angle = small_angle("a deflection", positive)
        for name, check, unit in (("limit", angle, "rad"), ("rate_limit", positive, "rad/s")):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, number(name, getattr(self, name), check, unit))
        if self.stop is not None:
            stop_of(self.stop)
        if self.actuator is not None:
            instance("actuator", self.actuator, Actuator, "or None")

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> Self:
        """Return what the table [nozzle] of a file says; an actuator of 0 rad/s is none.

        Raises
        ------
        InputError
            For what the table may not hold, and as `Nozzle` and `Actuator` themselves.
        """
        found = NOZZLE_TABLE.read(table)
        given = {name: found.pop(name) for name in _ACTUATOR if name in found}
        return cls(**found, actuator=actuator_of(**given))


def actuator_of(actuator_frequency: float = 25.1, actuator_damping: float = 0.7) -> Actuator | None:
    """Return an actuator of a natural frequency [rad/s] and a damping ratio; none of zero."""
    if number("actuator_frequency", actuator_frequency) == 0.0:
        return None
    return Actuator(natural_frequency=actuator_frequency, damping=actuator_damping)
