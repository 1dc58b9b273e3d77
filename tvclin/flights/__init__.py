"""Flights that the linear theory is checked against: nonlinear, and found by flying.

The files inside: `atmosphere`, `condition` (what a flight needs beyond a vehicle) and
`trajectory` (the nominal flight) say where a vehicle flies; `planar/` flies the report's own
equations in one plane and `sixdof/` flies in JSBSim; `door` says what both refuse, `answer` is
what both give back, `control` is what can turn the nozzle, and `flown_boundary` finds the least
deflection limit of any engine that says which flights are lost, as `falls` does. `beside` puts
the linear theory beside a flight.
"""
