"""Many cases: dispersed studies, campaigns, archives of winds, with their confidence.

- Dispersions: `Dispersion`, `Dispersions`; of a study `disperse_study`.
- Campaigns: `Campaign`; `run_campaign`, `open_campaign`, `resume_campaign`; along a whole flight by
  a `FlightPlan`, in a `SoundingEnsemble`.
- Flights with limits in sampled turbulence, with what the linear loop says of them:
  `fly_turbulence`, `fly_turbulence_along`, `TurbulenceFlights`.
- Days of an archive: `tvclin.availability` by an `AvailabilityRequest`; what the wind may become:
  `PairGrowth`, `WindGrowth`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
