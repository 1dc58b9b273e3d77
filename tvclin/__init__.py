"""tvclin: how much thrust-vector deflection a booster needs to survive a wind.

The names of an ordinary week are here; each chapter has these and all others, by question:

- `tvclin.vehicle`: vehicles, their files, structure and filters. `load_vehicle`, `list_vehicles`,
  `Vehicle`, `Coefficients`, `Structure`.
- `tvclin.winds`: winds, gusts, soundings. `TriangularWind`, `RectangularWind`, `ShapedWind`,
  `SampledWind`, `OneMinusCosineGust`, `WindProfile`, `read_sounding`, `read_soundings`,
  `angle_from_speed`.
- `tvclin.linear`: plants, poles and residues, exact responses. `Plant`, `FlexiblePlant`,
  `unstable_modes`, `residues`, `is_stable`, `trim_deflection`, `trim_then_hold`,
  `attitude_response`, `attitude_responses`.
- `tvclin.ascent`: a vehicle over its flight, from files and other tools; winds along it.
  `FlightSchedule`, `load_schedule`, `fly_through`.
- `tvclin.boundary`: boundary limits, limit shapes, the minimum-peak control. `boundary_limit`,
  `forecast_free_limit`, `optimum_deflection`, `plane_limit`.
- `tvclin.control`: autopilots, margins, laws. `Autopilot`, `Actuator`, `AutopilotDesign`,
  `design_gains`, `Loop`, `CRITERIA`, `compare_with_trim`, `SaturatedLaw`, `TrimLaw`,
  `RecoverableAttitudeLaw`.
- `tvclin.flights`: flights of laws, in one plane, in two, with six degrees of freedom. `fly`,
  `fly_many`, `closed_loop_boundary`, `fly_planar`, `fly_sixdof`, `flown_boundary`.
- `tvclin.case`: a vehicle in a wind, with its nozzle and autopilot. `Case`, `Nozzle`.
- `tvclin.requirement`: required deflection of a wind, a study, and over a flight. `Study`,
  `required_deflection`, `is_sufficient`, `survivable_peak`, `size`, `worst_total`.
- `tvclin.nozzle`: duty of a nozzle: angle, rate, travel, torque, power.
- `tvclin.ensembles`: dispersions, campaigns, archives of winds. `Dispersion`, `Dispersions`,
  `Campaign`, `run_campaign`, `availability`.
- `tvclin.design`: gains for the minimum deflection, trials of laws, the worst case in a box.
  `minimum_deflection_gains`, `worst_case`.
- `tvclin.studyfile`: study files, with all questions about a vehicle. `load_study`.
- `tvclin.plots`: figures.

A study as one page: `report_html`; a panel in a notebook: `explore`; bad input raises `InputError`.
A name is loaded when it is first used, so that ``import tvclin`` is quick.
"""

from tvclin.base.public_names import public_names

__version__ = "0.1.0"
__getattr__, __dir__, __all__ = public_names(__name__, __file__)
