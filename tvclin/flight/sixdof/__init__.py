"""Flights with six degrees of freedom, by JSBSim; the one room that imports it.

The rooms inside: `model` writes a vehicle as JSBSim's XML, `engine` is JSBSim with the
integrators and the reset that make it exact and repeatable, `airframe` flies one vehicle,
`steering` turns its nozzle, and `fly` is the door.
"""

from tvclin.flight.sixdof.fly import SixDof, fly_sixdof

__all__ = ["SixDof", "fly_sixdof"]
