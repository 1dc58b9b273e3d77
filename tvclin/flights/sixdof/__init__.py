"""Flights with six degrees of freedom, in JSBSim.

Files, lowest first: `engine` alone knows JSBSim; `model` writes the vehicle and its Earth as JSBSim
files; `steering` commands the nozzle; `airframe` is a running instance with sensors and wind;
`fly_sixdof` has the public function and the verdicts.
"""
