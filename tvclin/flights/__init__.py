"""Flights of laws with limits, and flights that the linear theory is checked against.

- Linear, by samples: `fly`, `fly_many`; in both planes `fly_planes`. What a law needs:
  `closed_loop_boundary`, `flown_plane_limit`, over gains and delays `boundary_map`; the margins
  that its limit leaves: `flown_margins`.
- With the report's own equations: `fly_planar`; in JSBSim: `fly_sixdof` on its `Earth`. What turns
  the nozzle there: `ReportControl`. The theory beside a flight: `fly_beside`; the least limit of
  any engine: `tvclin.flown_boundary`.
"""

from tvclin.base.doors import door

__getattr__, __dir__, __all__ = door(__name__, __file__)
