"""Duty of a nozzle in a motion and over a flight, and flown trade-off curves.

- What does a motion take? `nozzle_duty`, a `NozzleDuty`: angle, rate, travel, torque, power.
- What does a flight take? `flight_duty`, a `FlightDuty`.
- Which limit does each law require over the rate limit? `flown_trade_offs`.
- Which rate limit does one law require with a deflection limit? `flown_required_rate`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
