"""Required deflection: of one wind, of a study, and over a whole flight.

- One wind: `is_sufficient`, `required_deflection`, `survivable_peak`; of a `Case` a `Study`.
- A flight: its `size` by a `SizingRequest` and `SoundingRequest`, with numbers by `Requirement`;
  the `DeflectionTotal` of `total_deflection` and `worst_total`, and the `ControllabilityRatio` of
  `controllability_ratio`; with the requirement of an autopilot, `autopilot_requirements`, and what
  it uses: `deflection_use`; in turbulence `FlightTurbulence`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
