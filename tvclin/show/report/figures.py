"""Figures as inline SVG of a page: reproducible bytes, and colours that a style can change."""

import io
import re
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.plots.style import place_numbers

if TYPE_CHECKING:
    from control import ControlPlot
    from markupsafe import Markup

_WIDTH, _PANEL, _FOOT = 6.4, 1.9, 1.1
"""Sizes [inch]: of a figure, of one panel where there are several, and of the legend."""
_SINGLE_PANEL = 4.2
"""Height of the only panel of a figure [inch]."""
_LINE = 0.21
"""Height of a line of the legend [inch]."""
_COLOUR = re.compile(r"#([0-9a-f]{6})\b")
"""Colour of an SVG."""
_IDENTIFIER = re.compile(r'\b(id="|href="#|url\(#)')
"""Beginning of an identifier in an SVG, or of a reference to it."""


def inline_svg(plot: "ControlPlot", name: str, label: str) -> "Markup":
    """Return the `svg` element of a figure, and close the plot.

    `name`: letters, unique within the page. `label`: description of the figure for screen readers.
    Titles are removed, for the page has a caption, and the legend stands below, so that the letters
    stay large on a narrow screen. Every colour becomes a variable of the page's style sheet with
    the colour itself in reserve, and the figure's name prefixes every name within it.
    """
    import matplotlib.pyplot as plt
    from markupsafe import Markup, escape

    narrow(plot)
    with plt.rc_context({"svg.hashsalt": name, "svg.fonttype": "path"}):
        target = io.StringIO()
        nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
        plot.figure.savefig(target, format="svg", transparent=True, metadata=nothing)
    plt.close(plot.figure)
    text = target.getvalue()
    body = text[text.index("<svg") :]
    body = _IDENTIFIER.sub(rf"\1{name}-", body)
    body = _COLOUR.sub(r"var(--c\1, #\1)", body)
    opening = re.search(r'viewBox="[^"]+"', body)
    assert opening is not None
    inside = body[body.index(">") + 1 :]
    head = f'<svg role="img" aria-label="{escape(label)}" {opening.group()}'
    return Markup(f'{head} xmlns:xlink="http://www.w3.org/1999/xlink">{inside.strip()}')


def narrow(plot: "ControlPlot") -> None:
    """Give a figure the width of a page's column, and put one legend below it."""
    figure = plot.figure
    panels = [axes for axes in np.ravel(plot.axes) if axes.axison]
    entries: dict[str, Any] = {}
    for axes in panels:
        axes.minorticks_off()
        entries |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
        if axes.get_legend() is not None:
            axes.get_legend().remove()
        if len(panels) == 1:
            axes.set_title("")
    for legend in figure.legends:
        legend.remove()
    figure.suptitle("")
    if not panels:  # a drawing without axes
        plot.axes.flat[0].set_title("")
        ends = plot.axes.flat[0].get_ylim(), plot.axes.flat[0].get_xlim()
        high, wide = (float(np.ptp(interval)) for interval in ends)
        figure.set_size_inches(_WIDTH, _WIDTH * high / wide)
        return
    height = _SINGLE_PANEL if len(panels) == 1 else _PANEL * len(panels)
    options = {"handles": list(entries.values()), "labels": list(entries), "frameon": False}
    for columns in (2, 1):
        foot = max(_FOOT, _LINE * (-(-len(entries) // columns) + 1))
        figure.set_size_inches(_WIDTH, height + foot)
        legend = figure.legend(loc="outside lower center", ncols=columns, **options)
        if columns == 1 or legend.get_window_extent().width < figure.bbox.width:
            break
        legend.remove()
    place_numbers(*panels)
