"""Control laws of flights: functions from measurements to the commanded deflection.

Files: `law` defines a law and adds filters to one; `attitude` (gains), `accelerometer` (gains
without a vane), `trim` (ideal trim, and the report's dead band) and `recoverable` (attitude within
the recoverable set) are laws; `estimator` replaces the vane by an observer, `both_planes` flies a
law in pitch and yaw, and `registry` designs laws by name. Limits belong to the flight.
"""
