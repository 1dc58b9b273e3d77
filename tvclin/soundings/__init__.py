"""Soundings: measured winds, from a file to a history of the wind angle along a flight.

`read_sounding` gives a `WindProfile`, the wind over height; `WindProfile.to_wind` flies through it.
"""

from tvclin.soundings.profile import WindProfile
from tvclin.soundings.range_reference import RangeReference, read_range_reference, worst_month
from tvclin.soundings.read import read_sounding
from tvclin.soundings.steady import Climb, steady_climb
from tvclin.soundings.synthetic import add_gust, power_law_shear, synthetic_profile

__all__ = [
    "Climb",
    "RangeReference",
    "WindProfile",
    "add_gust",
    "power_law_shear",
    "read_range_reference",
    "read_sounding",
    "steady_climb",
    "synthetic_profile",
    "worst_month",
]
