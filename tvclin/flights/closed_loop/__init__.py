"""Closed loops with limits: flights of a law, and the least limit with which it survives.

The files inside: `fly` is the door to one flight, `many` to batches of them, and `boundary` finds
the limit. `continuous` flies a law that is computed without pause, on the `equations` of what
flies; `sampled` one at its sample rate, with the laws of `law_batch`, the winds of `gusts` and the
judges of `fates` as numbers for the kernel. `track` tells a sampled flight at any time, `growth`
how it grows near rest, and `checks` says what is refused.
"""
