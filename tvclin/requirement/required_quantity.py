"""Requirements on a deflection limit: quantity, dead band, parameters, direction of the wind."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from tvclin.base import quantities
from tvclin.base.errors import between, one_of
from tvclin.base.fields import checked, flag, word
from tvclin.base.fields import quantity as number_field
from tvclin.base.package_warnings import ImplausibleInput
from tvclin.winds.wind_angles import DIRECTIONS

DEAD_BAND = "dead band"
MAX_LINEAR_DEFLECTION = float(np.radians(30.0))
"""Deflection [rad] above which its lateral force is no longer proportional to it, within 5 %."""
QUANTITIES = ("trim", DEAD_BAND, "no forecast", "minimum")
_HEADINGS = {
    "no forecast": quantities.NO_FORECAST,
    "minimum": quantities.WIND_KNOWN,
    "autopilot": quantities.REQUIREMENT,
}
"""Headings of tables and figures that are not the label, by the name of a requirement."""


@dataclass(frozen=True, eq=False)
class Requirement:
    """Key of a requirement on a deflection limit in records, tables and figures.

    It is equal to its label, and to each requirement with that label: a mapping by requirements is
    also one by labels.

    Parameters
    ----------
    quantity : {"trim", "dead band", "no forecast", "minimum"}
        Ideal trim along the path; the required deflection with a dead band; the lower bound of laws
        without a forecast; the lower bound with the wind known.
    dead_band : float
        K in [0, 1], of the quantity "dead band"; the others have none.
    varying : bool
        Whether the parameters vary during the wind; else they are frozen at the flight time.
    direction : {"", "head", "tail", "cross"}
        Direction of the wind whose angle and dynamic pressure are encountered; empty at nominal
        dynamic pressure.

    Raises
    ------
    InputError
        For unknown names, and a dead band outside [0, 1].

    Examples
    --------
    >>> import tvclin as tv
    >>> print(tv.requirement.Requirement(dead_band=0.5, varying=True, direction="head"))
    K = 0.5, varying, head wind
    """

    quantity: str = word(QUANTITIES, DEAD_BAND)
    dead_band: float = number_field("number", 1.0, between(0.0, 1.0))
    varying: bool = flag(False)
    direction: str = word(("", *DIRECTIONS), "")

    def __post_init__(self) -> None:
        """Check the fields; `InputError` as the class says."""
        checked(self)

    @property
    def name(self) -> str:
        """The quantity, or the dead band with all its digits, as "K = 1"."""
        if self.quantity != DEAD_BAND:
            return self.quantity
        return f"K = {np.format_float_positional(self.dead_band, trim='-')}"

    @property
    def label(self) -> str:
        """Label, such as "K = 1, varying, head wind"."""
        varying = ", varying" if self.varying else ""
        return f"{self.name}{varying}{in_wind(self.direction)}"

    @property
    def column(self) -> str:
        """The label without blanks and signs, for columns of a CSV and variables of a Dataset."""
        return self.label.replace(" = ", "").replace(", ", "_").replace(" ", "_")

    def __str__(self) -> str:
        """Return the label."""
        return self.label

    def __eq__(self, other: object) -> bool:
        """Return whether another requirement, or a text, has this label."""
        return str(other) == self.label if isinstance(other, Requirement | str) else NotImplemented

    def __hash__(self) -> int:
        """Return the hash of the label, which a text with this label has too."""
        return hash(self.label)


TRIM, NO_FORECAST, MINIMUM = (
    Requirement(quantity) for quantity in ("trim", "no forecast", "minimum")
)


def heading_of(label: str) -> str:
    """Return the heading of a requirement in tables, figures and notes, by its label.

    Some quantities have a heading of their own; what follows the first comma of the label, as
    ", varying, head wind", stays.
    """
    name, comma, suffix = label.partition(", ")
    return f"{_HEADINGS.get(name, name)}{comma}{suffix}"


def in_wind(direction: str) -> str:
    """Return the end of a label, ", head wind", for a direction of the wind; empty for none."""
    return f", {direction} wind" if direction else ""


def deflection_warnings(required: float) -> Iterator[ImplausibleInput]:
    """Yield a warning on a required deflection [rad] above `MAX_LINEAR_DEFLECTION`.

    None on an infinite one, where no limit is sufficient.
    """
    if MAX_LINEAR_DEFLECTION < required < np.inf:
        yield ImplausibleInput(
            f"the required deflection is {np.degrees(required):.4g} deg, and above"
            f" {np.degrees(MAX_LINEAR_DEFLECTION):.3g} deg the linear force of a nozzle says"
            " nothing: a number of the vehicle or of the wind may be in another unit"
        )


def requirement_among(
    argument: str, requirement: Requirement | str, available: Iterable[Requirement]
) -> Requirement:
    """Return the requirement in `available` with this label; `InputError` for another label.

    `argument`: name of the argument in the error. `requirement`: the label, or a requirement with
    it.
    """
    by_label = {quantity.label: quantity for quantity in available}
    label = requirement.label if isinstance(requirement, Requirement) else requirement
    return by_label[one_of(argument, label, by_label)]
