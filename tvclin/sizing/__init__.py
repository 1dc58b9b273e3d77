"""The deflection a vehicle must have over its flight: flight times by winds.

The rooms inside: `schedule` is the vehicle over time and `schedule_file` reads it; `placing` says
where in the flight a wind blows, and `measured` what counts of one that was flown through; `frozen`
sizes one vehicle in one wind, `growing` and `varying` one whose parameters vary meanwhile; `size`
puts flight times and winds together into a `record`; and `total` adds what else the nozzle has to
do.
"""

from tvclin.sizing.measured import MeasuredWind, fly_through
from tvclin.sizing.record import Sizing, Worst
from tvclin.sizing.schedule import FlightSchedule
from tvclin.sizing.schedule_file import load_schedule
from tvclin.sizing.size import size
from tvclin.sizing.total import DeflectionTotal, Line, total_deflection, worst_total

__all__ = [
    "DeflectionTotal",
    "FlightSchedule",
    "Line",
    "MeasuredWind",
    "Sizing",
    "Worst",
    "fly_through",
    "load_schedule",
    "size",
    "total_deflection",
    "worst_total",
]
