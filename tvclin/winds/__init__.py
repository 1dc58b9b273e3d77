"""Winds: histories of the wind angle of attack alpha_w.

A positive wind angle lowers the angle of attack (alpha = theta - gamma - alpha_w): it is a tail
wind, or the downwind part of a cross wind.

- What has every wind? As a `History` a value at a time, a transform, a sum with others, a shift.
- Which pulse? `TriangularWind`, `RectangularWind`, `AsymmetricTriangularWind`, `TrapezoidalWind`;
  by a name, with gust and direction, `ShapedWind`; the `equivalent_triangle` of any.
- Which gust? `OneMinusCosineGust`, `LayeredGust`.
- From samples or a speed? `SampledWind`, `angle_from_speed`; many at once `WindEnsemble`; in both
  planes `PlaneWind`.
- As measured over height? `read_sounding`, a `WindProfile`; archives `read_soundings`, `Soundings`;
  percentiles of a launch site `read_range_reference`, a `RangeReference`, `worst_month`.
- Made up over height? `synthetic_profile`, `power_law_shear`, `add_gust`.
- Along which climb? `steady_climb`, a `Climb`.
- Random? `Turbulence`, by spectrum, intensity and length; over altitude `read_turbulence`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
