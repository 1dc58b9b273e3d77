"""Flight condition of a vehicle: altitude and specific impulse, which the report does not give."""

from dataclasses import dataclass
from os import PathLike

import numpy as np

from tvclin.ascent.atmosphere import HIGHEST, LOWEST, standard_atmosphere
from tvclin.base.errors import InputError, between, naming, positive
from tvclin.base.fields import checked, file_table, quantity
from tvclin.base.files import called
from tvclin.vehicle.vehicle import Vehicle
from tvclin.vehicle.vehicle_file import is_schedule, read_vehicle_text, table_of


@dataclass(frozen=True, kw_only=True)
class FlightCondition:
    """Altitude of a vehicle at its time, and the specific impulse by which its mass falls.

    Parameters
    ----------
    altitude : float
        Altitude [m] at the vehicle's time, from -5 to 86 km.
    specific_impulse : float
        Of the thrust [s], positive: it says how fast the mass falls.
    reference_area : float, optional
        S [m^2] of the aerodynamic coefficients, which no flight needs.
    table_scale : float
        A common factor on W, I, N, T and F_A. No flight depends on it; coefficients and forces do.

    Raises
    ------
    InputError
        For numbers out of range.
    """

    altitude: float = quantity("length", check=between(LOWEST, HIGHEST))
    specific_impulse: float = quantity("time", check=positive)
    reference_area: float | None = quantity("area", None, positive)
    table_scale: float = quantity("number", 1.0, positive)

    def __post_init__(self) -> None:
        checked(self)

    @property
    def density(self) -> float:
        """Density of the air [kg/m^3]."""
        return float(standard_atmosphere(self.altitude).density)

    def dynamic_pressure(self, vehicle: Vehicle) -> float:
        """Return rho V_n^2/2 [Pa]."""
        return 0.5 * self.density * float(np.asarray(vehicle.velocity)) ** 2

    def scaled(self, vehicle: Vehicle) -> Vehicle:
        """Return the vehicle with W, I, N, T and F_A times the common factor."""
        names = ("weight", "moment_of_inertia", "normal_force_slope", "thrust", "axial_force")
        changes = {name: self.table_scale * getattr(vehicle, name) for name in names}
        if vehicle.control_force_slope is not None:
            changes["control_force_slope"] = self.table_scale * vehicle.control_force_slope
        return vehicle.replace(**changes)


FLIGHT_TABLE = file_table("[flight]", FlightCondition, required=("altitude", "specific_impulse"))


def load_flight_condition(source: str | PathLike[str]) -> FlightCondition:
    """Return the flight condition of a vehicle by name, or of a vehicle file.

    It stands in the file under its own heading, [flight]: altitude_m, specific_impulse_s, and
    perhaps reference_area_m2 and table_scale.

    Raises
    ------
    InputError
        As `load_vehicle`, and where the heading or a key is missing.

    Examples
    --------
    >>> from tvclin.ascent.flight_condition import load_flight_condition
    >>> load_flight_condition("configuration-i").altitude
    11950.0
    """
    text, path = read_vehicle_text(source)
    table = {} if is_schedule(source) else table_of(text, path, FLIGHT_TABLE)
    name = called(path)
    if not table:
        raise InputError(
            f"{name} has no table [flight]; a flight needs altitude_m and specific_impulse_s in it"
        )
    with naming(name):
        return FlightCondition(**FLIGHT_TABLE.read(table))
