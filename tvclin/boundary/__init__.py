"""The minimum deflection limits: closed forms, any wind, the optimum, recoverable states.

- In any wind with any dead band: `boundary_limit`; without a forecast: `forecast_free_limit`.
- In closed form: `rectangular_limit` (7) and (16), `triangular_limit` (12),
  `triangular_limit_with_drift` (18), with a status from `solve_triangular_with_drift`.
- The minimum-peak control of appendix C: `optimum_deflection`, `optimum_with_rate_limit`; angle and
  rate together: `rate_trade_off`; angle and load: `load_trade_off`.
- Both planes: `plane_limit`, `plane_optimum`; limit shapes: `CircularShape`, `SquareShape`,
  `EllipticShape`, `PolygonShape`, and of several engines a `Cluster` of `ClusterEngine`.
- How far the report's formulas hold: `single_pole_validity`, `triangle_error`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
