"""Closed loops with limits: flights of a law, and the least limit with which it survives.

The files inside: `fly` flies one, `many` batches of them, `boundary` finds the limit on the `edges`
of what survives, `boundary_map` does so over gain and delay, and `flown_margins` says how much may
change before a flight is lost, or grows `near_rest`.
`continuous` flies a law that is computed without pause, on the `equations` of what flies;
`sampled` one at its sample rate, with the laws of `law_batch`, the winds of `gusts` and the
`outcomes` as numbers for the kernel. `track` tells a sampled flight at any time, `growth` how it
grows near rest, and `checks` says what is refused.
"""
