"""Closed loops with limits: flights of a law, and the least limit with which it survives.

The rooms inside: `airframe` steps plant and nozzle exactly, `sampled` flies a law at its sample
rate, `continuous` one that is computed without pause on the `equations` of what flies, `fly` is
the door to both, `survival` decides whether flights survive, `boundary` finds the limit, and
`checks` says what is refused.
"""

from tvclin.closed_loop.boundary import ClosedLoopBoundary, closed_loop_boundary
from tvclin.closed_loop.fly import fly

__all__ = ["ClosedLoopBoundary", "closed_loop_boundary", "fly"]
