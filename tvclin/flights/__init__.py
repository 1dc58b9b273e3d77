"""Flights of laws with limits, and flights that the linear theory is checked against.

- Linear, by samples: `fly`, `fly_many`; in both planes `fly_planes`; along a flight that varies
  `fly_along`, `fly_many_along`. The requirement of a law: `closed_loop_boundary`, along a flight
  `survival_limit_along`, `flown_plane_limit`, over gains and delays `boundary_map`; the margins
  that its limit leaves: `flown_margins`.
- With the report's equations: `fly_planar`; in JSBSim: `fly_sixdof` on its `Earth`; the report's
  control there: `ReportControl`. A flight compared with theory: `compare_flight`; the smallest
  limit of any engine: `tvclin.flown_boundary`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
