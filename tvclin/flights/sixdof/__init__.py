"""Flights with six degrees of freedom, in JSBSim.

Files, lowest first: `model` writes the vehicle and its Earth as JSBSim files; `steering` commands
the nozzle; `airframe`, which alone imports JSBSim, is a running instance with sensors and wind;
`fly_sixdof` has the public function and the verdicts.
"""
