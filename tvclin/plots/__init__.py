"""Figures. Each function returns python-control's `ControlPlot`: lines, axes, figure.

The figures of the report are drawn from `Curves`, which they carry as `.curves`, so that a CSV
written from it holds exactly what is drawn. matplotlib and python-control are imported when the
first figure is drawn.
"""

from tvclin.plots.boundaries import DEAD_BANDS, boundary_chart, figure_2, figure_5, study_chart
from tvclin.plots.closed_loops import step_chart, wind_chart
from tvclin.plots.comparison import comparison_chart
from tvclin.plots.curves import Column, Curves, curves_of
from tvclin.plots.flights import flight_chart, flight_curves
from tvclin.plots.flown_boundaries import figure_10, figure_11
from tvclin.plots.laws import laws_chart
from tvclin.plots.loops import bode_chart, nichols_chart
from tvclin.plots.nyquist import nyquist_chart
from tvclin.plots.poles import pole_map
from tvclin.plots.responses import (
    attitude_chart,
    figure_3,
    figure_4,
    figure_6,
    figure_7,
    figure_8,
    figure_9,
)
from tvclin.plots.root_locus import root_locus_chart
from tvclin.plots.single_response import response_chart, response_curves
from tvclin.plots.sizing import sizing_chart
from tvclin.plots.sketches import sketch_a, sketch_b, sketch_c
from tvclin.plots.style import save_figure
from tvclin.plots.vehicle_sketch import figure_1

__all__ = [
    "DEAD_BANDS",
    "Column",
    "Curves",
    "attitude_chart",
    "bode_chart",
    "boundary_chart",
    "comparison_chart",
    "curves_of",
    "figure_1",
    "figure_2",
    "figure_3",
    "figure_4",
    "figure_5",
    "figure_6",
    "figure_7",
    "figure_8",
    "figure_9",
    "figure_10",
    "figure_11",
    "flight_chart",
    "flight_curves",
    "laws_chart",
    "nichols_chart",
    "nyquist_chart",
    "pole_map",
    "response_chart",
    "response_curves",
    "root_locus_chart",
    "save_figure",
    "sizing_chart",
    "sketch_a",
    "sketch_b",
    "sketch_c",
    "step_chart",
    "study_chart",
    "wind_chart",
]
