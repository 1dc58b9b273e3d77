"""A vehicle known by its coefficients alone, and its files: TOML with one table [coefficients]."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from typing import Any, ClassVar, Self, TypeAlias

from tvclin.base.cards import Quantity, card, lines
from tvclin.base.errors import InputError, flag, instance, naming, shown, single, text
from tvclin.base.files import called
from tvclin.base.tables import FileTable
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.file import (
    COEFFICIENTS,
    needs_whole,
    parse_vehicle,
    source_tables,
    vehicle_text,
)
from tvclin.vehicle.vehicle import Vehicle

FIXED_PATH = "fixed-path"
"""The one model that mu_alpha and mu_delta are enough for."""
_SLOPES = {"mu_alpha": "per time squared", "mu_delta": "per time squared"}
_BY_BETA = {"beta": "per time", "B": "number"}
_DAMPING = {"damping": "per time"}
_OF_THE_PATH = {
    "C1": "per time",
    "C2": "per time cubed",
    "b1": "per time",
    "b2": "per time",
    "q": "per time squared",
}
COEFFICIENTS_TABLE = FileTable(
    f"[{COEFFICIENTS}]", _SLOPES | _BY_BETA | _DAMPING | _OF_THE_PATH, words=("name",)
)


@dataclass(frozen=True, kw_only=True)
class LinearVehicle:
    """A vehicle of which no more is known than the coefficients of its linear equations.

    Attributes
    ----------
    coefficients : Coefficients
        Of one vehicle in one plane.
    name : str
        What the vehicle is called.
    path_known : bool
        Whether C1, C2, b1, b2 and q are known; without them the only model is "fixed-path".

    Raises
    ------
    InputError
        For a batch.
    """

    coefficients: Coefficients
    name: str = ""
    path_known: bool = False

    structure: ClassVar[None] = None

    def __post_init__(self) -> None:
        instance("coefficients", self.coefficients, Coefficients, "see Coefficients.from_beta")
        single("coefficients", self.coefficients.batch)
        text("name", self.name)
        flag("path_known", self.path_known)

    @property
    def rigid(self) -> Self:
        """Itself: of a structure nothing is known."""
        return self

    def quantities(self) -> list[Quantity]:
        """Return its numbers as tables show them."""
        c = self.coefficients
        known = [
            Quantity("mu_alpha", "aerodynamic moment slope", c.mu_alpha, "1/s²"),
            Quantity("mu_delta", "control moment slope", c.mu_delta, "1/s²"),
        ]
        units = {"C1": "1/s", "C2": "1/s³", "b1": "1/s", "b2": "1/s", "q": "1/s²"}
        path = [Quantity(name, name, getattr(c, name), unit) for name, unit in units.items()]
        if c.damping:
            known.append(Quantity("damping", "damping", c.damping, "1/s"))
        return [*known, *(path if self.path_known else ())]

    def _repr_html_(self) -> str:
        return card(self.name or "Coefficients", [one[1:] for one in self.quantities()])

    def __repr__(self) -> str:
        title = f"Linear vehicle {self.name}".strip()
        return lines(title, [one[1:] for one in self.quantities()])

    def known_for(self, model: str) -> Coefficients:
        """Return the coefficients for a model; raise `InputError` where it needs unknown ones."""
        if text("model", model) != FIXED_PATH and not self.path_known:
            raise InputError(
                f'model "{shown(model)[1:-1]}" needs C1, C2, b1, b2 and q beside mu_alpha and'
                f' mu_delta; give them in {COEFFICIENTS_TABLE.heading}, or take "{FIXED_PATH}"'
            )
        return self.coefficients


AnyVehicle: TypeAlias = Vehicle | LinearVehicle


def load_any_vehicle(source: str | PathLike[str]) -> AnyVehicle:
    """Return a vehicle as `load_vehicle`, or one known by its coefficients from their file.

    The table [coefficients] holds mu_alpha_per_s2 and mu_delta_per_s2, or beta_per_s and B; for the
    motion of the path also C1_per_s, C2_per_s3, b1_per_s, b2_per_s and q_per_s2, zero in yaw; and
    damping_per_s, where there is any.

    Parameters
    ----------
    source : str or path
        As of `load_vehicle`.

    Raises
    ------
    InputError
        As `load_vehicle`, and where only some of the coefficients of the path are given.

    Examples
    --------
    >>> import tvclin as tv
    >>> tv.vehicle.load_any_vehicle("configuration-i").weight
    1480000.0
    """
    words, name = vehicle_text(source)
    document = source_tables(source)
    if COEFFICIENTS not in document or "vehicle" in document:
        return parse_vehicle(words, name)
    with naming(called(name)):
        for other in document.keys() - {COEFFICIENTS}:
            raise InputError(
                f"{shown(other)} cannot stand beside {COEFFICIENTS_TABLE.heading}, which is all"
                " that is known of a vehicle"
            )
        return _of_table(COEFFICIENTS_TABLE.one(document))


def coefficients_of(vehicle: AnyVehicle, plane: str = "pitch") -> Coefficients:
    """Return the coefficients of a vehicle in a plane, or those it is known by."""
    if isinstance(vehicle, LinearVehicle):
        return vehicle.coefficients
    return Coefficients.from_vehicle(vehicle, plane)


def whole_vehicle(vehicle: AnyVehicle, what: str) -> Vehicle:
    """Return a vehicle as it is; `InputError` where what is named cannot do with coefficients."""
    if isinstance(vehicle, LinearVehicle):
        raise InputError(needs_whole(what))
    return vehicle


def _of_table(given: Mapping[str, Any]) -> LinearVehicle:
    table = COEFFICIENTS_TABLE
    values = table.read(given)
    name = values.get("name", "")
    by_beta = values.keys() & _BY_BETA
    if by_beta and values.keys() & _SLOPES:
        raise InputError(
            f"{table.heading} must have mu_alpha and mu_delta, or beta and B, not some of each"
        )
    table.need(values, _BY_BETA if by_beta else _SLOPES)
    path = values.keys() & _OF_THE_PATH
    if path:
        table.need(values, _OF_THE_PATH)
    made = Coefficients.from_beta(**values) if by_beta else Coefficients(**values)
    return LinearVehicle(coefficients=made, name=name, path_known=bool(path))
