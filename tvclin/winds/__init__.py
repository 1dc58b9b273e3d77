"""Winds: histories of the wind angle of attack alpha_w.

A positive wind angle lowers the angle of attack (alpha = theta - gamma - alpha_w): it is a tail
wind, or the downwind part of a cross wind.
"""

from tvclin.winds.equivalent import equivalent_triangle
from tvclin.winds.gusts import LayeredGust, OneMinusCosineGust
from tvclin.winds.pulses import (
    AsymmetricTriangularWind,
    RectangularWind,
    TrapezoidalWind,
    TriangularWind,
)
from tvclin.winds.sampled import SampledWind
from tvclin.winds.speed import angle_from_speed

__all__ = [
    "AsymmetricTriangularWind",
    "LayeredGust",
    "OneMinusCosineGust",
    "RectangularWind",
    "SampledWind",
    "TrapezoidalWind",
    "TriangularWind",
    "angle_from_speed",
    "equivalent_triangle",
]
