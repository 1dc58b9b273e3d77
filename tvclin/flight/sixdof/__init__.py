"""Flights with six degrees of freedom, by JSBSim; the one room that imports it.

The rooms inside: `model` writes a vehicle as JSBSim's XML, `engine` is JSBSim with the
integrators and the reset that make it exact and repeatable, `airframe` flies one vehicle,
`senses` reads it in its plane, `steering` turns its nozzle, `earth` puts it over the rotating
Earth, `fly` is the door, and `verdict` says of flights whether they survive.
"""

from tvclin.flight.sixdof.earth import Earth
from tvclin.flight.sixdof.fly import SixDof, fly_sixdof

__all__ = ["Earth", "SixDof", "fly_sixdof"]
