"""Figures. Each function returns python-control's `ControlPlot`: lines, axes, figure.

The figures of the report are drawn from `Curves`, which they carry as `.curves`, so that a CSV
written from it holds exactly what is drawn. matplotlib and python-control are imported when the
first figure is drawn.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
