"""What the motion of a nozzle asks of it: the card of a motion, of a flight, and of a whole flight.

The files inside: `motion` is how a nozzle moves, given or flown; `work` its torque and power;
`card` what that asks of a nozzle; `flown` the same of a law's flight; `whole` of each flight time
and wind of a sizing, with its `record`; `verdict` what is needed, there and left.
"""
