"""Figures. Each function returns python-control's `ControlPlot`: lines, axes, figure.

The figures of the report are drawn from `Curves`, which they carry as `.curves`, so that a CSV
written from it holds exactly what is drawn. matplotlib and python-control are imported when the
first figure is drawn.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
