"""Boundary: minimum deflection limits, in closed form and in any wind, in one plane and two.

- Which limit survives a wind, with a dead band? `boundary_limit`, a `BoundaryLimit`.
- Which without a forecast? `forecast_free_limit`, a `ForecastFreeLimit`.
- In closed form? `rectangular_limit` (7) and (16), `triangular_limit` (12),
  `triangular_limit_with_drift` (18), with a status `solve_triangular_with_drift`.
- Which minimum peak has any control that knows the wind (appendix C)? `optimum_deflection`, an
  `Optimum`; with a rate limit `optimum_with_rate_limit`, a `RateLimitedOptimum`.
- What does rate or load cost in angle? `rate_trade_off`, a `RateTradeOff`; `load_trade_off`, a
  `LoadTradeOff`.
- With one limit for both planes? `plane_limit`, a `PlaneLimit`; `plane_optimum`, a `PlaneOptimum`.
- Of which `LimitShape`? `CircularShape`, `SquareShape`, `EllipticShape`, `PolygonShape`; of several
  engines a `Cluster` of `ClusterEngine`.
- How far do the formulas hold? `single_pole_validity`, `triangle_error`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
