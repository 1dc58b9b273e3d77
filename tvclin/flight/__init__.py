"""Flights that the linear theory is checked against: nonlinear, and found by flying.

The rooms inside: `atmosphere`, `condition` (what a flight needs beyond a vehicle) and
`trajectory` (the nominal flight) say where a vehicle flies; `planar/` flies the report's own
equations in one plane and `sixdof/` flies in JSBSim; `door` says what both refuse, `answer` is
what both give back, `control` is what can turn the nozzle, and `flown_boundary` finds the least
deflection limit of any engine that says which flights are lost, as `falls` does. `beside` puts
the linear theory beside a flight.
"""

from tvclin.flight.atmosphere import Air, standard_atmosphere
from tvclin.flight.beside import MODEL as LINEAR_MODEL
from tvclin.flight.beside import FlightBeside, fly_beside, linear_boundary
from tvclin.flight.condition import FlightCondition, load_flight_condition
from tvclin.flight.control import ReportControl
from tvclin.flight.flown_boundary import ENGINES, FlownBoundary, flown_boundary
from tvclin.flight.planar import fly_planar
from tvclin.flight.sixdof import Earth, fly_sixdof
from tvclin.flight.trajectory import NominalFlight, nominal_flight

__all__ = [
    "ENGINES",
    "LINEAR_MODEL",
    "Air",
    "Earth",
    "FlightBeside",
    "FlightCondition",
    "FlownBoundary",
    "NominalFlight",
    "ReportControl",
    "flown_boundary",
    "fly_beside",
    "fly_planar",
    "fly_sixdof",
    "linear_boundary",
    "load_flight_condition",
    "nominal_flight",
    "standard_atmosphere",
]
