"""Laws that say which deflection to ask for; the limits are the flight's.

The files inside: `law` says what a law is; `attitude` (gains), `accelerometer` (gains without a
vane), `trim` (ideal trim), `dead_band` (the report's control) and `recoverable` (lean as far as one
can return from) are the laws, `filtered` is any of them with filters, and `estimator` finds the
wind where the angle of attack is not measured.
"""
