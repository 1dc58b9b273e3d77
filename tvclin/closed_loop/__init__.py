"""Closed loops with limits: flights of a law, and the least limit with which it survives.

The rooms inside: `airframe` steps plant and nozzle exactly, `sampled` flies a law at its sample
rate, `continuous` one that is computed without pause on the `equations` of what flies, `fly` is
the door to both, `survival` decides whether flights survive, `boundary` finds the limit, and
`checks` says what is refused. `many` is the door to batches of flights: `law_rows`, `gusts`,
`step_matrices` and `fates` make the numbers for the kernels that fly them.
"""

from tvclin.closed_loop.boundary import ClosedLoopBoundary, closed_loop_boundary
from tvclin.closed_loop.fly import fly
from tvclin.closed_loop.many import FlownCases, fly_many

__all__ = ["ClosedLoopBoundary", "FlownCases", "closed_loop_boundary", "fly", "fly_many"]
