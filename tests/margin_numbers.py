"""The margins of a loop that are numbers, by their names in `Margins`."""

NUMBERS = [
    "aero_margin",
    "gain_increase",
    "phase_margin",
    "delay_margin",
    "disk_margin",
    "peak_sensitivity",
    "peak_complementary_sensitivity",
]
