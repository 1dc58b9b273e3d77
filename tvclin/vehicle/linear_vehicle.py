"""Vehicles defined by coefficients alone, and their files: TOML with one table [coefficients]."""

from __future__ import annotations

from dataclasses import dataclass, field
from os import PathLike
from typing import Any, ClassVar, Self, TypeAlias

from tvclin.base.cards import card, card_rows, lines
from tvclin.base.errors import InputError, flag, instance, naming, shown, single, text
from tvclin.base.fields import Field, parameters, specs
from tvclin.base.files import called
from tvclin.base.tables import FileTable
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.vehicle.vehicle_file import (
    COEFFICIENTS,
    incomplete_vehicle_message,
    parse_vehicle,
    read_vehicle_text,
    source_tables,
)

FIXED_PATH = "fixed-path"
"""Model that mu_alpha and mu_delta suffice for."""
_SLOPES = ("mu_alpha", "mu_delta")
_BY_BETA = {"beta": "per time", "B": "number"}
_PATH_COEFFICIENTS = ("C1", "C2", "b1", "b2", "q")
_NUMBERS = parameters(Coefficients)
COEFFICIENTS_TABLE = FileTable(
    f"[{COEFFICIENTS}]",
    {name: item.kind for name, item in _NUMBERS.items()} | _BY_BETA,
    words=("name",),
)


def _coefficient(name: str, label: str = "") -> Field:
    """Return the specification of a coefficient of `LinearVehicle`, for its tables and documents.

    `name`: attribute of `Coefficients`. `label`: text in tables, by default the name.
    """

    def value(vehicle: LinearVehicle) -> Any:
        """Return the coefficient `name` of a vehicle; None if it is unknown or a zero damping."""
        # coefficients of the flight path, C1, C2, b1, b2 and q, are unknown together
        has_value = vehicle.path_known or name not in _PATH_COEFFICIENTS
        number = getattr(vehicle.coefficients, name)
        return number if has_value and (number or name != "damping") else None

    return Field(name, _NUMBERS[name].kind, of=value, label=label or name)


@dataclass(frozen=True, kw_only=True)
class LinearVehicle:
    """Vehicle that is defined by the coefficients of its linear equations alone.

    Attributes
    ----------
    coefficients : Coefficients
        Coefficients of one vehicle in one plane.
    name : str
        Name of the vehicle.
    path_known : bool
        Whether C1, C2, b1, b2 and q are known; without them the only model is "fixed-path".

    Raises
    ------
    InputError
        For a batch.
    """

    coefficients: Coefficients = field(
        metadata=specs(
            _coefficient("mu_alpha", "aerodynamic moment slope"),
            _coefficient("mu_delta", "control moment slope"),
            _coefficient("damping"),
            *map(_coefficient, _PATH_COEFFICIENTS),
        )
    )
    name: str = ""
    path_known: bool = False

    structure: ClassVar[None] = None

    def __post_init__(self) -> None:
        """Check the attributes."""
        instance("coefficients", self.coefficients, Coefficients, "see Coefficients.from_beta")
        single("coefficients", self.coefficients.batch)
        text("name", self.name)
        flag("path_known", self.path_known)

    @property
    def rigid(self) -> Self:
        """The vehicle itself: it has no structure."""
        return self

    def _repr_html_(self) -> str:
        """Return the known coefficients as a table in HTML."""
        return card(self.name or "Coefficients", card_rows(self))

    def __repr__(self) -> str:
        """Return the known coefficients as lines of text."""
        title = f"Linear vehicle {self.name}".strip()
        return lines(title, card_rows(self))

    def coefficients_for(self, model: str) -> Coefficients:
        """Return the coefficients; `InputError` if they do not suffice for a `model` by name."""
        if text("model", model) != FIXED_PATH and not self.path_known:
            # [1:-1]: without the quotes of `shown`
            raise InputError(
                f'model "{shown(model)[1:-1]}" needs C1, C2, b1, b2 and q beside mu_alpha and'
                f' mu_delta; give them in {COEFFICIENTS_TABLE.heading}, or take "{FIXED_PATH}"'
            )
        return self.coefficients


AnyVehicle: TypeAlias = Vehicle | LinearVehicle


def load_any_vehicle(source: str | PathLike[str]) -> AnyVehicle:
    """Return a vehicle as `load_vehicle`, or a `LinearVehicle` from its file.

    The table [coefficients] holds the moments over the inertia, per angle of attack
    mu_alpha_per_s2 and per deflection mu_delta_per_s2; or beta_per_s, the unstable pole on a fixed
    path, and B, the trim deflection per angle of attack. For the drift of the path it also holds
    coefficients of the report's eq (B7): C1_per_s and C2_per_s3 of the denominator, the zeros
    b1_per_s of the deflection and b2_per_s of the wind, and q_per_s2, the gravity term, zero in
    yaw; and optionally damping_per_s, the moment against the attitude rate over the inertia.

    Parameters
    ----------
    source : str or path
        Name of a vehicle of the package, or path of a file.

    Raises
    ------
    InputError
        For an unknown name, a file that cannot be read or has unknown or missing keys, and where
        only some of the coefficients of the path are given.

    Examples
    --------
    >>> import tvclin as tv
    >>> tv.vehicle.load_any_vehicle("configuration-i").weight
    1480000.0
    """
    content, name = read_vehicle_text(source)
    document = source_tables(source)
    if COEFFICIENTS not in document or "vehicle" in document:
        return parse_vehicle(content, name)
    table = COEFFICIENTS_TABLE
    with naming(called(name)):
        for key in document.keys() - {COEFFICIENTS}:
            raise InputError(
                f"{shown(key)} cannot stand beside {table.heading}, which is all that is known of a"
                " vehicle"
            )
        values = table.read(table.one(document))  # in SI units, by name
        by_beta = values.keys() & _BY_BETA  # beta and B
        if by_beta and values.keys() & set(_SLOPES):  # mu_alpha and mu_delta
            raise InputError(
                f"{table.heading} must have mu_alpha and mu_delta, or beta and B, not some of each"
            )
        table.need(values, _BY_BETA if by_beta else _SLOPES)
        path_known = bool(values.keys() & set(_PATH_COEFFICIENTS))  # C1, C2, b1, b2, q
        if path_known:
            table.need(values, _PATH_COEFFICIENTS)
        coefficients = Coefficients.from_beta(**values) if by_beta else Coefficients(**values)
        name = values.get("name", "")
        return LinearVehicle(coefficients=coefficients, name=name, path_known=path_known)


def coefficients_of(vehicle: AnyVehicle, plane: str = "pitch") -> Coefficients:
    """Return the coefficients of a vehicle in a `plane`, "pitch" or "yaw".

    A `LinearVehicle` has coefficients of one plane, whichever it is, which are returned unchanged.
    """
    if isinstance(vehicle, LinearVehicle):
        return vehicle.coefficients
    return Coefficients.from_vehicle(vehicle, plane)


def complete_vehicle(vehicle: AnyVehicle, what: str) -> Vehicle:
    """Return the vehicle; `InputError` for a `LinearVehicle`, which has coefficients alone.

    `what`: the answer that needs mass, thrust and speed too, for the message.
    """
    if isinstance(vehicle, LinearVehicle):
        raise InputError(incomplete_vehicle_message(what))
    return vehicle
