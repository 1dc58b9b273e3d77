"""Ascent: a vehicle over its flight, the winds measured along it, flights of other tools.

- What is the flight? A `FlightSchedule`, by `load_schedule` from files or along the nominal flight
  of a vehicle; Mach number and others over it `flight_variable`.
- How do bending and slosh change? A `StructureSchedule`, by `load_structure`.
- From another tool? `read_openrocket`, `read_rasaero`, `schedule_from_rocketpy`, `read_table`; a
  log with its wind `read_log`, a `SimulatedFlight`.
- Which wind does it encounter? `fly_through`, a `MeasuredWind`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
