"""Control of the deflection: autopilots, margins, laws, and their comparison with trim.

- A loop: `Autopilot`, its `Actuator`; over a flight `GainSchedule`, with a `ModeNotch`, and
  the times of `equal_values`; of a state space `SystemAutopilot`.
- Gains: `design_gains`, `canonical_gains`, `half_relief_gains`, `relief_gains`,
  `drift_minimum_gains`, `load_minimum_gains`, `lqr_gains`, `drift_gains`; by a rule of a file
  `AutopilotDesign`; the `steady_drift` of any.
- Margins: `Autopilot.margins`, `loop_margins` of any `Loop`, their `margin_bounds`, with modes
  `detuned`, over a flight their `sweep`; requirements on them: `Criteria`, `CRITERIA`.
- Laws for flights: `TrimLaw`, `DeadBandLaw`, `RecoverableAttitudeLaw`, `SaturatedLaw`, of a state
  space `SystemLaw`, without a vane `AccelerometerLaw`, and around them `FilteredLaw`,
  `EstimatedLaw` with a `WindEstimator`; by name `design_law`; your own: `Law`.
- In turbulence, by covariance: `turbulence_covariance` of a loop, `turbulence_history` about a
  known wind, `turbulence_along` a flight; with `SensorNoise` and the `LoadSlopes` of a structure.
- Compared with trim: `compare_with_trim`, `worst_duration`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
