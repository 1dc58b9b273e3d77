"""Required deflection: of one wind, of a study, and over a whole flight.

- Is a limit sufficient in a wind? `is_sufficient`; `required_deflection`, a `RequiredDeflection`;
  `survivable_peak`.
- Head or tail wind, gust, both planes? A `Study`, also of a `Case`.
- Which time of a flight requires most? `size`, a `Sizing` with a `Requirement` for each row; by
  keys of a file `SizingRequest` and `SoundingRequest`.
- Is the nozzle sufficient for all of it? `worst_total`, `total_deflection`, a `DeflectionTotal`; in
  turbulence `FlightTurbulence`; by the older ratio `controllability_ratio`, a
  `ControllabilityRatio`.
- What does an autopilot require and use? `autopilot_requirements`, `AutopilotRequirements`;
  `deflection_use`, a `DeflectionUse`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
