"""Planar flights of the report's nonlinear equations.

The files inside: `equations` are (B1a) to (B1f) as deviations, `case` flies them, and `fly_planar`
is the public function.
"""
