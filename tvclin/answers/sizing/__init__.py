"""The deflection a vehicle must have over its flight: flight times by winds.

The files inside: `placing` says where in the flight a wind blows; `frozen` sizes one vehicle in one
wind, `flight_mode` and `flight_requirement` one whose parameters vary meanwhile; `size` puts flight
times and winds together into a `record`; `total` adds what else the nozzle has to do; and `request`
is all that one sizing depends on.
"""
