"""Flights that the linear theory is checked against.

The rooms inside: `atmosphere`, `condition` (what a flight needs beyond a vehicle) and
`trajectory` (the nominal flight) say where a vehicle flies.
"""

from tvclin.flight.atmosphere import Air, standard_atmosphere
from tvclin.flight.condition import FlightCondition, load_flight_condition
from tvclin.flight.trajectory import NominalFlight, nominal_flight

__all__ = [
    "Air",
    "FlightCondition",
    "NominalFlight",
    "load_flight_condition",
    "nominal_flight",
    "standard_atmosphere",
]
