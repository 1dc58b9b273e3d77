"""Planar flights of the report's nonlinear equations.

The files inside: `equations` are (B1a) to (B1f) as deviations, `case` flies them, `fly` is the
door, and `verdict` says which deflection limits survive.
"""
