"""Margins of a loop over the flight, with the lines of the criteria."""

from typing import TYPE_CHECKING

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, instance
from tvclin.control.autopilot.sweep import Sweep
from tvclin.control.margins.criteria import Judgement
from tvclin.control.margins.margins import MARGINS, unit_factor
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import COLOURS, INK, WARM, Look, Style, called, cycle, draw

if TYPE_CHECKING:
    from control import ControlPlot

_NOMINAL, _DETUNED, _LIMIT = "whole loop", "worst detuned mode", "criterion"
_COLOURS = tuple(colour for colour in COLOURS if colour != WARM)  # that of the criteria


def sweep_chart(sweep: Sweep, name: str = "") -> "ControlPlot":
    """Draw each margin that a criterion limits over the flight time, with its limit.

    A panel for each criterion: the whole loop or the modes, the smallest margin with a detuned
    mode, and the limit. Curves are interrupted where the loop is unstable or has no such margin.

    Parameters
    ----------
    sweep : Sweep
        Sweep of two or more times.
    name : str
        Name of the vehicle.

    Raises
    ------
    InputError
        For a sweep of one time.
    """
    instance("sweep", sweep, Sweep, "see sweep")
    if sweep.times.size < 2:
        raise InputError("a figure over the flight needs two or more flight times; got 1")
    order = np.argsort(sweep.times)
    columns: list[Column] = []
    ordinates: dict[str, str] = {}
    styles: dict[str, Style] = {
        _NOMINAL: {"color": INK, "lw": 1.8},
        _DETUNED: {"color": INK, "lw": 1.2, "ls": ":"},
        _LIMIT: {"color": WARM, "lw": 1.2, "ls": "--"},
    }
    styles |= {
        mode: {"color": colour, "lw": 1.5}
        for mode, colour in zip(sweep.mode_names, cycle(_COLOURS), strict=False)
    }
    for limit in sweep.criteria.limits:
        panel = MARGINS.get(limit.margin, (limit.name,))[0]
        worst, unit = limit.shown
        factor = unit_factor(unit)
        ordinates[panel] = f"margin [{unit}]" if unit else "margin"
        unit = unit or "-"
        for judged in sweep.judgements:
            if judged.criterion == limit:
                values = factor * _finite(np.asarray(judged.value)[order])
                if np.any(np.isfinite(values)):
                    columns.append(Column(judged.band or _NOMINAL, values, unit, panel))
        detuned = [judged for judged in sweep.detuned_judgements if judged.criterion == limit]
        if detuned:
            columns.append(Column(_DETUNED, factor * _lowest(detuned)[order], unit, panel))
        columns.append(Column(_LIMIT, np.full(order.size, worst), unit, panel))
    words = f"margins over the flight, criteria {sweep.criteria.name}"
    curves = Curves("sweep", words, "flight time [s]", sweep.times[order], tuple(columns))
    ordinate = ordinates if len(ordinates) > 1 else next(iter(ordinates.values()))
    return draw(curves, Look(called(name, words), ordinate, styles))


def _finite(values: FloatArray) -> FloatArray:
    """Return values with NaN in place of what is not finite."""
    return np.where(np.isfinite(values), values, np.nan)


def _lowest(judgements: list[Judgement]) -> FloatArray:
    """Return the value ``(n,)`` of the smallest surplus over modes and changes; NaN if unstable."""
    values = np.concatenate([np.atleast_2d(judged.value) for judged in judgements])
    surplus = np.concatenate([np.atleast_2d(judged.surplus) for judged in judgements])
    worst = np.argmin(np.where(np.isnan(surplus), -np.inf, surplus), axis=0)
    return _finite(np.take_along_axis(values, worst[np.newaxis], axis=0)[0])
