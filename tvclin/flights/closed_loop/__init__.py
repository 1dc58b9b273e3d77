"""Closed loops with limits: flights of a law, and the smallest limit with which it survives.

Files, lowest first: `outcomes` decides when a flight is lost or settled; `batch` writes plants,
laws and winds as arrays of the kernel; `checks` of arguments; `sampled` runs the kernel and returns
one flight at any time; `sampled_stability` of loops below their limits; `fly_many`, `fly_planes`
and `fly`, with `continuous` for laws without sampling; `survival_limit`, and `flown_margins`.
"""
