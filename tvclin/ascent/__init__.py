"""A vehicle over its flight: its schedule, the winds measured along it, and flights of other tools.

- A flight: `FlightSchedule`; from files, or along the nominal flight of a vehicle,
  `load_schedule`; a variable of it, `flight_variable`; its bending and slosh over time, a
  `StructureSchedule` of `load_structure`.
- From other tools: `read_openrocket`, `read_rasaero`, `schedule_from_rocketpy`, `read_table`; of a
  flight log with its winds `read_log`, a `SimulatedFlight`.
- Winds over height along a flight: `fly_through`, a `MeasuredWind`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
