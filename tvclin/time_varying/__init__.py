"""Required deflection where coefficients vary: over a wind, with dynamic pressure, over a flight.

The modules of this chapter have no public names; `requirement` and `case` use them.
"""
