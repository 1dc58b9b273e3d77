"""Flights of laws with limits, and flights that the linear theory is checked against.

`closed_loop/` flies the linear models; `planar/` the report's own equations in one plane, and
`sixdof/` in JSBSim. For these two `atmosphere`, `condition` (what a flight needs beyond a vehicle)
and `trajectory` (the nominal flight) say where a vehicle flies, `checks` what both refuse, `answer`
what both give back, `control` what can turn the nozzle, and `flown_boundary` finds the least
deflection limit of any engine that says which flights are lost, as `falls` does. `beside` puts the
linear theory beside a flight.
"""

from tvclin.base.doors import door

__getattr__, __dir__, __all__ = door(__name__, __file__)
