"""Control of the deflection: autopilots, gains, margins, laws, turbulence.

- What is the loop? An `Autopilot` with its `Actuator`; of a state space `SystemAutopilot`; over a
  flight a `GainSchedule` with a `ModeNotch`, and its times of `equal_values`, `EqualValues`.
- Which gains? `design_gains`, `canonical_gains`, `half_relief_gains`, `relief_gains`,
  `drift_minimum_gains`, `load_minimum_gains`, `lqr_gains`, `drift_gains`; by a rule of a file
  `AutopilotDesign`; the `steady_drift` of any.
- Which margins? `Autopilot.margins`, `Margins`; `loop_margins` of any `Loop`; `margin_bounds`,
  `MarginBounds`; with modes `BandMargins` of a `RigidBand` and each `ModeBand`, `detuned` in
  frequency a `Detuned`; over a flight a `sweep`, `Sweep`.
- Are they sufficient? `Criteria`, `CRITERIA`.
- Which law flies? `TrimLaw`, `DeadBandLaw`, `RecoverableAttitudeLaw`, `SaturatedLaw`; of a state
  space `SystemLaw`; without a vane `AccelerometerLaw`, or an `EstimatedLaw` with a `WindEstimator`;
  with filters `FilteredLaw`; by name `design_law`; your own: a `Law` of a `Measurement`.
- How does the autopilot answer a wind? `compare_with_trim`, a `TrimComparison`; `worst_duration`, a
  `WorstDuration`.
- And turbulence? `turbulence_covariance`, a `LoopCovariance`; about a known wind
  `turbulence_history` and along a flight `turbulence_along`, each a `CovarianceHistory`; with its
  `Crossings`, `SensorNoise` and `LoadSlopes`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
