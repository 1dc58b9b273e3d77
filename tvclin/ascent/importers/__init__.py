"""Flight schedules from what other tools write: OpenRocket, RASAero II, RocketPy, any table.

The files inside: `slopes` is the slope of the normal force coefficient, over Mach where it is known
so; `flight` holds the numbers of a flight in SI units and chooses of them, `checks` refuses what
would be silently wrong, and `build` makes the schedule. `openrocket` (with
`openrocket_columns`), `rasaero`, `rocketpy`, `mapped` and `log` are the sources.
"""
