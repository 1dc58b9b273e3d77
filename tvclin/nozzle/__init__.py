"""Duty of a nozzle: in a motion, in flights, over a whole flight, and its trade-offs as flown.

`nozzle_card` is the duty of a motion, `flight_card` that of a whole flight; `flown_trade_offs` are
the limits that laws require over the rate limit.
"""

from tvclin.base.doors import door

__getattr__, __dir__, __all__ = door(__name__, __file__)
