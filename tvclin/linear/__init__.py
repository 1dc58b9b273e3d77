"""The linear models: plant, modes, verdict, deflections, exact responses and their loads.

- A plant: `Plant`; with a structure `FlexiblePlant`; `plant_of` takes what a vehicle has; of a
  state space with named signals `SystemPlant`; with drift among its outputs `lateral_plant`; files
  of such systems `read_system`, `write_system`. `available_models` says which of the four are
  known.
- Its poles and residues: `unstable_modes`, `all_modes`, `residues`.
- Stability in a wind, by eq (4b): `is_stable`, `judge`.
- Deflections: `trim_deflection`, `trim_then_hold`, `ConstantDeflection`, `BangBang`.
- Responses, exact also on the boundary: `attitude_response`, `attitude_responses`; their loads:
  `wind_loads`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
