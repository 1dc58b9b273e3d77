"""Flights with six degrees of freedom, by JSBSim; the one folder that knows it.

The files inside: `model` writes a vehicle as JSBSim's XML, `engine` is JSBSim with the
integrators and the reset that make it exact and repeatable, `sensors` reads a flight in its plane,
`steering` turns the nozzle, `earth` puts a flight over the rotating Earth, `departure` on its
trajectory, `airframe` flies one vehicle, `case` is what is flown, checked, and `fly_sixdof`
is the public function.
"""
