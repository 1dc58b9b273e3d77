"""Required deflection against flight time, in the worst wind of each."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tvclin.answers.quantity import MINIMUM, NO_FORECAST, TRIM, Requirement
from tvclin.answers.sizing.record import Sizing
from tvclin.base.errors import InputError, instance, number, positive, small_angle
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import COLOURS, INK, LINES, WARM, Look, Style, called, cycle, draw
from tvclin.vehicle.coefficients import IN_WORDS

if TYPE_CHECKING:
    from control import ControlPlot

_LIMIT = "available limit"
_MARKS = {"head": "^", "tail": "v", "cross": "x"}
_COLOURS = tuple(colour for colour in COLOURS if colour != WARM)  # that of the limit


def sizing_chart(sizing: Sizing, limit: float | None = None, name: str = "") -> "ControlPlot":
    """Draw the required deflections over the flight, and the available one.

    Lines are for parameters that are frozen at each flight time; rings, where the sizing has them,
    for parameters that vary while the wind blows; triangles for head and tail winds.

    Parameters
    ----------
    sizing : Sizing
        Of two or more flight times; of several winds the worst counts at each.
    limit : float, optional
        Available deflection [rad].
    name : str
        What a vehicle without a name of its own is called.

    Raises
    ------
    InputError
        For a sizing of one flight time.
    """
    instance("sizing", sizing, Sizing, "see size")
    if sizing.times.size < 2:
        raise InputError("a figure over the flight needs two or more flight times; got 1")
    order = np.argsort(sizing.times)
    rows = {one.label: np.degrees(sizing.at_times(one))[order] for one in sizing.required}
    columns = [Column(label, row, "deg") for label, row in rows.items() if np.isfinite(row).any()]
    styles = _styles(sizing)
    if limit is not None:
        most = np.degrees(number("limit", limit, small_angle("a deflection", positive), "rad"))
        columns.append(Column(_LIMIT, np.full(order.size, most), "deg"))
        styles[_LIMIT] = {"color": WARM, "ls": "-", "lw": 1.4}
    winds = sizing.winds[0] if len(sizing.winds) == 1 else f"the worst of {len(sizing.winds)} winds"
    words = f"{sizing.model}, {IN_WORDS[sizing.plane]}, {winds}"
    curves = Curves("sizing", words, "flight time [s]", sizing.times[order], tuple(columns))
    top = 1.05 * max(float(np.nanmax(column.values)) for column in columns)
    title = called(sizing.schedule.vehicle.name or name, f"required deflection: {words}")
    return draw(curves, Look(title, "deflection [deg]", styles, limits={"": (0.0, top or 1.0)}))


def _styles(sizing: Sizing) -> dict[str, Style]:
    """A colour for each requirement, the same for frozen and varying parameters."""
    bands = [Requirement(dead_band=K) for K in sizing.dead_bands]
    colours = dict(zip([TRIM, NO_FORECAST, MINIMUM, *bands], (INK, *cycle(_COLOURS)), strict=False))
    lines = dict(zip([TRIM, *bands, NO_FORECAST, MINIMUM], cycle(LINES), strict=False))
    styles: dict[str, Style] = {}
    for one in sizing.required:
        kind = replace(one, varying=False, direction="")
        style: Style = {"color": colours[kind], "lw": 1.8, "ls": lines[kind]}
        if one.direction:
            style = {"ls": "", "marker": _MARKS[one.direction], "ms": 4.5, "color": colours[kind]}
        elif one.varying:
            style |= {"ls": "", "marker": "o", "ms": 4.5, "mfc": "none"}
        styles[one.label] = style
    return styles
