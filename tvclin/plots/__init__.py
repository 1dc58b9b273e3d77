"""Figures. Each function returns python-control's `ControlPlot`: lines, axes, figure.

- What does a wind require? `study_chart`, `study_planes_chart`, `boundary_chart` at `DEAD_BANDS`,
  `sizing_chart`, `deflection_use_chart`, `availability_chart`, `plane_chart`.
- What does rate, load or margin cost? `rate_chart`, `load_chart`, `laws_chart`,
  `gain_trade_off_chart`.
- How does the vehicle move? `response_chart`, `attitude_chart`, `study_response_chart`,
  `step_chart`, `wind_chart`, `comparison_chart`, `flight_chart`, `flight_along_chart`.
- Where are margins and poles? `bode_chart`, `nyquist_chart`, `nichols_chart`, `pole_map`,
  `root_locus_chart`, `sweep_chart`, `flown_margins_chart`, `boundary_map_chart`; in turbulence
  `spectrum_chart`.
- What does the vehicle look like? `vehicle_chart`, `sketch_a`, `sketch_b`, `sketch_c`.
- The figures of the report? `figure_1`, `figure_2`, `figure_3`, `figure_4`, `figure_5`, `figure_6`,
  `figure_7`, `figure_8`, `figure_9`, `figure_10`, `figure_11`.
- As numbers or a file? `Curves` of `Column`, which figures carry as ``.curves``; `curves_of`,
  `response_curves`, `flight_curves`, `rate_curves`, `load_curves`, `spectrum_curves`;
  `save_figure`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
