"""Flights that the linear theory is checked against: nonlinear, and found by flying.

The rooms inside: `atmosphere`, `condition` (what a flight needs beyond a vehicle) and
`trajectory` (the nominal flight) say where a vehicle flies; `planar/` flies the report's own
equations in one plane and `sixdof/` flies in JSBSim; `door` says what both refuse, `answer` is
what both give back, `control` is what can turn the nozzle, and `flown_boundary` finds the least
deflection limit of any engine that says which flights are lost, as `falls` does.
"""

from tvclin.flight.atmosphere import Air, standard_atmosphere
from tvclin.flight.condition import FlightCondition, load_flight_condition
from tvclin.flight.control import ReportControl
from tvclin.flight.flown_boundary import ENGINES, FlownBoundary, flown_boundary
from tvclin.flight.planar import fly_planar
from tvclin.flight.sixdof import Earth, fly_sixdof
from tvclin.flight.trajectory import NominalFlight, nominal_flight

__all__ = [
    "ENGINES",
    "Air",
    "Earth",
    "FlightCondition",
    "FlownBoundary",
    "NominalFlight",
    "ReportControl",
    "flown_boundary",
    "fly_planar",
    "fly_sixdof",
    "load_flight_condition",
    "nominal_flight",
    "standard_atmosphere",
]
