"""The linear models: plants, modes, the verdict of (4b), exact responses and their loads.

- What is the plant? `Plant`, of one of the `available_models`; with a structure `FlexiblePlant`;
  `plant_of` takes what a vehicle has; with drift among its outputs `lateral_plant`.
- From matrices and files of MATLAB? `SystemPlant`, `read_system`, `write_system`.
- Which poles are unstable, with which residues? `unstable_modes`, `all_modes`, a record `Modes`;
  `residues`.
- Does a deflection hold it in a wind? `is_stable`; `judge`, a `Verdict` with its `FinalMotion`.
- Which deflection? `trim_deflection`, `trim_then_hold`, `ConstantDeflection`, `BangBang`.
- How does it move, exactly, on the boundary too? `attitude_response`; in batches
  `attitude_responses`, `Responses`; angle of attack and loads `wind_loads`, `Loads`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
