"""Design: gains for the minimum deflection, laws in standard winds, the worst case in a box.

- Which gains need the least deflection? `minimum_deflection_gains`, `MinimumGains`; over a flight
  `minimum_gain_schedule`, a `MinimumGainSchedule`; for more margin `gain_trade_off`, a
  `GainTradeOff`.
- Which law needs least? `law_trials`, each a `LawTrial`, of `standard_laws` in `standard_winds`; by
  keys of a file a `LawsRequest`.
- What is the worst case when numbers lie in a box? `tvclin.worst_case`, a `WorstCase` of a `Worst`
  for each margin and the deflection.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
