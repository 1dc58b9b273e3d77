"""Soundings: measured winds, from a file to a history of the wind angle along a flight.

`read_sounding` gives a `WindProfile`, the wind over height; `WindProfile.to_wind` flies through it.
"""
