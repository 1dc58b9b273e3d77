"""Flights in both planes, with one limit for the vector of the demands of both.

Each plane is a flight of `kernels.flights`. At each sample the demands (x, y) behind the filters
are scaled by min(1, limit/g(x, y)), g the gauge of the limit shape.
"""

import math

from tvclin.base.arrays import FloatArray
from tvclin.kernels.control_laws import law_demand
from tvclin.kernels.flights import NEVER, Flights, filtered_demand, measure_sample, move_sample
from tvclin.kernels.source import bare, inlined


@bare
def fly_in_planes(
    pitch: Flights, yaw: Flights, normals: FloatArray, limit: FloatArray, first: int, last: int
) -> None:
    """Fly cases from `first` up to `last` in both planes, the vector of their demands limited.

    The demands behind the filters are brought into the limit shape along their direction; each
    plane has its own limit besides. `normals`: of the edges of the limit shape over their distance
    from zero, ``(k, 2)``; none for a circle. `limit`: scale [rad] of the limit shape, ``(m,)``. The
    flights of both planes end at the same sample.
    """
    for i in range(first, last):
        for k in range(NEVER):
            flies = measure_sample(pitch, i, k)
            if not (measure_sample(yaw, i, k) and flies):
                break
            x, y = autopilot_demand(pitch, i), autopilot_demand(yaw, i)
            gauge = math.hypot(x, y) if normals.shape[0] == 0 else 0.0
            for r in range(normals.shape[0]):
                gauge = max(gauge, normals[r, 0] * x + normals[r, 1] * y)
            scale = limit[i] / gauge if gauge > limit[i] else 1.0
            move_sample(pitch, i, k, scale * x)
            move_sample(yaw, i, k, scale * y)


@inlined
def autopilot_demand(f: Flights, i: int) -> float:
    """Return the demand [rad] of the law of a flight without switches, behind its filters."""
    law = f.laws.numbers[f.cases.law[i]]
    demand = law_demand(law, f.now.measured[i], f.now.states[i], f.cases.limit[i])
    return filtered_demand(f, i, demand)
