"""The least deflection over the disk margin that is asked for, beside the theory's limits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from tvclin.answers.least_gains.front import GainsFront
from tvclin.base.errors import InputError, each
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import COLOURS, INK, Look, Style, draw

if TYPE_CHECKING:
    from control import ControlPlot

_LINES: dict[str, Style] = {
    "boundary, K = 1": {"color": "0.45", "ls": "--", "lw": 1.4},
    "boundary, K = 0.5": {"color": "0.45", "ls": "-.", "lw": 1.4},
    "minimum, wind known": {"color": INK, "ls": ":", "lw": 2.0},
}
_MEANS = {"peak": "linear peak", "boundary": "flown limit"}


def least_gains_chart(fronts: Sequence[GainsFront]) -> ControlPlot:
    """Draw what margins cost: the least deflection over the disk margin that is asked for.

    Parameters
    ----------
    fronts : sequence of GainsFront
        Of one vehicle in one set of winds, over the same disk margins: of two gains and of three,
        of linear peaks and of limits that were flown.

    Raises
    ------
    InputError
        For none, and for fronts over different disk margins.
    """
    every = each("fronts", fronts, GainsFront, "see least_gains_front")
    if not every:
        raise InputError("fronts must be one or more; got none")
    disk = every[0].disk_margin
    if any(not np.array_equal(one.disk_margin, disk) for one in every):
        raise InputError("fronts must be over the same disk margins")
    columns, styles = [], dict(_LINES)
    for k, one in enumerate(every):
        label = f"{len(one.gains)} gains, {_MEANS[one.meaning]}"
        columns.append(Column(label, np.where(np.isinf(one.relative), np.nan, one.relative)))
        styles[label] = {"color": COLOURS[k % len(COLOURS)], "lw": 2.0, "marker": "o", "ms": 4.0}
    columns += [Column(name, np.full(disk.shape, value)) for name, value in every[0].limits.items()]
    curves = Curves(
        "least-gains",
        "least deflection over the disk margin that is asked for",
        "disk margin asked for [-]",
        disk,
        tuple(columns),
    )
    plot = draw(
        curves, Look("Least deflection over disk margin", "deflection over |B alpha_w,max|", styles)
    )
    plot.axes.flat[0].set_ylim(bottom=0.0)
    return plot
