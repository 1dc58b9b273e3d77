"""A study file that asks for a whole flight, in a pulse and in a sounding."""

FLIGHT = """
[study]
vehicle = "configuration-i"
model = "drift"

[[wind]]
peak_deg = 4.0
duration_s = 7.5

[[wind]]
sounding = "wyoming.txt"
azimuth_deg = 90
time = "2024-02-15 12"

[gust]
peak_deg = 1.0
duration_s = 2.0

[nozzle]
limit_deg = 0.6

[schedule]
source = "configuration-ii"

[sounding]
window_s = 16

[size]
from_s = 70
to_s = 90
every_s = 20
dead_bands = [1.0]
varying = true
dispersion_percent = 20
thrust_offset_deg = 0.1
gravity_offset_m = 0.02
reserve_percent = 10
"""
