"""What is asked of the whole: requirement, study, sizing, campaign, and the files that ask.

- One wind: `is_sufficient`, `required_deflection`, `survivable_peak`; of a `Case` with its `Nozzle`
  a `Study`, or with dispersions `disperse_study`.
- Files: `load_study`, `load_sizing`, `load_campaign`; as records `StudyPlan`,
  `SizingRequest`, `SoundingRequest`, `AvailabilityRequest`, `LawsRequest`, `Document`.
- A flight: its `size`, with numbers by `Requirement`, the `DeflectionTotal` of `total_deflection`,
  `worst_total`, and the `ControllabilityRatio` of `controllability_ratio`.
- Days of an archive: `tvclin.availability`; what the wind may become: `PairGrowth`, `WindGrowth`.
- Many cases: `Campaign` of `Dispersion` and `Dispersions`; `run_campaign`, `open_campaign`,
  `resume_campaign`.
- Gains for the least nozzle: `least_deflection_gains`, `least_gain_schedule`, `least_gains_front`;
  the worst case in a box: `tvclin.worst_case`.
- Laws in the standard winds: `law_trials`, `standard_laws`, `standard_winds`.
- What a motion asks of the nozzle: `nozzle_card`, with torque by `NozzleData`; a whole flight:
  `flight_card`; what laws need over its rate limit: `flown_fronts`; what a structure bears:
  `LoadBound`.
"""

from tvclin.base.doors import door

__getattr__, __dir__, __all__ = door(__name__, __file__)
