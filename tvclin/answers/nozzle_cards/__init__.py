"""Duty of a nozzle: the card of a motion, of a flight in a wind, and of a whole flight.

The files inside: `motion` is the motion of a nozzle, from samples or a flight; `work` its torque
and power; `card` its angle, rate and travel; `flown` the card of a law's flight; `whole` the cards
of each flight time and wind of a sizing, with their `record`; `verdict` compares requirements with
the data sheet, and `unjudged` names flights and winds that are not known.
"""
