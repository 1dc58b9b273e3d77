"""Flight schedules from what other tools write: OpenRocket, RASAero II, RocketPy, any table.

The files inside: `slopes` is the slope of the normal force coefficient, over Mach where it is known
so; `powered_flight` chooses rows of a flight, refuses what would be silently wrong, and makes the
schedule. `openrocket`, `rasaero`, `rocketpy`, `mapped` (any table), `log` and `matlab` are the
sources.
"""
