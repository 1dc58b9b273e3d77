"""Design: gains for the minimum deflection, laws in standard winds, the worst case in a box.

- Gains: `minimum_deflection_gains`, `minimum_gain_schedule`, `gain_trade_off`.
- Laws in the standard winds: `law_trials`, `standard_laws`, `standard_winds`, by a `LawsRequest`.
- The worst case in a box: `tvclin.worst_case`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
