"""Many cases: dispersed studies, campaigns, archives of winds, with their confidence.

- What scatters? A `Dispersion` each, `Dispersions` with correlations.
- Which deflection covers a study? `disperse_study`, a `DispersedStudy`.
- And a million cases? A `Campaign`; `run_campaign`, `open_campaign`, `resume_campaign`, their
  `CampaignResults`; along a whole flight a `FlightPlan`, in a `SoundingEnsemble`.
- On how many days is the nozzle sufficient? `tvclin.availability`, an `Availability`, by an
  `AvailabilityRequest`, and `Today`; until launch `PairGrowth`, `WindGrowth`.
- Do flights with limits survive turbulence? `fly_turbulence`, `fly_turbulence_along`,
  `TurbulenceFlights` with a `SurvivalFraction`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
