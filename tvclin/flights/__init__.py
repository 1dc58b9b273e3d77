"""Flights of laws with limits, and flights that the linear theory is checked against.

- Does a law survive, by samples? `fly`; many cases `fly_many`, `FlownCases`; in both planes
  `fly_planes`, `FlownPlanes`.
- Along a flight that varies? `fly_along`, a `FlightAlong` with the `Largest` of each output;
  `fly_many_along`; in both planes `fly_planes_along`.
- Which limit does a law require? `closed_loop_boundary`, a `ClosedLoopBoundary`; in both planes
  `flown_plane_limit`, a `FlownPlaneLimit`; along a flight `survival_limit_along`; over gain and
  delay `boundary_map`, a `BoundaryMap`.
- Which margins remain with a limit? `flown_margins`, `FlownMargins`, each a `FlownMargin`.
- And with nonlinear equations? `fly_planar`; in JSBSim `fly_sixdof`, over its `Earth`; the
  `ReportControl`; the smallest limit `tvclin.flown_boundary`, a `FlownBoundary`; with theory
  `compare_flight`, a `FlightComparison`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
