"""Duty of a nozzle in a motion and over a flight, and flown trade-off curves.

`nozzle_duty` is the duty of a motion, `flight_duty` the duty over an entire flight;
`flown_trade_offs` are the limits that laws require over the rate limit.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
