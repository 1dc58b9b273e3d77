"""Winds: histories of the wind angle of attack alpha_w.

A positive wind angle lowers the angle of attack (alpha = theta - gamma - alpha_w): it is a tail
wind, or the downwind part of a cross wind. Every wind is a `History`: it has a value at a time, a
transform, a sum with others and a shift.

- Pulses: `TriangularWind`, `RectangularWind`, `AsymmetricTriangularWind`, `TrapezoidalWind`; by a
  name with gust and direction `ShapedWind`. `equivalent_triangle` of any pulse.
- Gusts: `OneMinusCosineGust`, `LayeredGust`.
- From samples: `SampledWind`; many at once: `WindEnsemble`; in both planes: `PlaneWind`.
- Random in time: `Turbulence`, by its spectrum, intensity and length; over altitude from a file:
  `read_turbulence`.
- From a speed: `angle_from_speed`.
- Measured over height: `read_sounding`, `WindProfile`; archives: `read_soundings`, `Soundings`; of
  a range: `read_range_reference`, `worst_month`.
- Synthetic over height: `synthetic_profile`, `power_law_shear`, `add_gust`.
- Along a steady climb: `steady_climb`, `Climb`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
