"""Flight schedules from what other tools write: OpenRocket, RASAero II, RocketPy, any table.

A file for each source reads its columns: `openrocket`, `rasaero`, `rocketpy`, `column_map` (any
table), and `simulation_log` with `matlab_file`. `powered_flight` selects the rows of a burn, checks
that they are plausible, and makes the schedule; `normal_force_slope` is the slope of the normal
force coefficient, a number or over Mach.
"""
