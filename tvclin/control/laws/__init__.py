"""Control laws of flights: functions from measurements to the commanded deflection.

Files: `law` defines a law, adds filters to one, and flies one in pitch and yaw; `autopilot_law` (of
gains or a state space), `accelerometer` (gains without a vane), `trim` (ideal trim, and the
report's dead band) and `recoverable` (attitude within the recoverable set) are laws; `estimator`
replaces the vane by an observer, and `registry` designs laws by name. Limits belong to the flight.
"""
