"""An autopilot in a wind for comparison with trim."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tvclin.base.errors import InputError
from tvclin.control.comparison.trim import TrimComparison
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import (
    ANGLES,
    COLOURS,
    INK,
    LINES,
    QUANTITIES,
    WARM,
    Look,
    Style,
    called,
    draw,
)

if TYPE_CHECKING:
    from control import ControlPlot

_POINTS, _LONGER = 601, 1.6
_AUTOPILOT, _TRIM, _MINIMUM = "autopilot", "ideal trim", "minimum, wind known"
_STYLES: dict[str, Style] = {
    _AUTOPILOT: {"color": WARM, "ls": "-", "lw": 2.2},
    _TRIM: {"color": INK, "ls": "--", "lw": 1.6},
    "boundary K = 1": {"color": COLOURS[0], "ls": LINES[3], "lw": 1.4},
    "boundary K = 0.5": {"color": COLOURS[1], "ls": "-.", "lw": 1.4},
    "boundary K = 0": {"color": COLOURS[2], "ls": (0, (3, 2)), "lw": 1.4},
    _MINIMUM: {"color": COLOURS[4], "ls": ":", "lw": 2.0},
    **QUANTITIES,
}
_ORDINATES = {"deflection": "deflection [deg]", "angles": "angles [deg]"}


def comparison_chart(comparison: TrimComparison) -> "ControlPlot":
    """Draw the deflection of an autopilot in a wind beside trim, boundaries and minimum.

    Parameters
    ----------
    comparison : TrimComparison
        See `compare_with_trim`; its closed loop is stable.

    Raises
    ------
    InputError
        For an unstable closed loop, whose deflection has no bounds to draw it in.
    """
    c = comparison
    if not c.margins.stable:
        raise InputError(f"there is nothing to compare: {c.margins.reason}")
    start, end = float(c.wind.onset), float(c.wind.end)
    times = np.linspace(start, start + _LONGER * (end - start), _POINTS)
    sides = np.concatenate([np.nextafter(c.wind.knots, -np.inf), c.wind.knots])
    times = np.unique(np.concatenate([times, sides[(sides >= times[0]) & (sides <= times[-1])]]))
    steady = replace(c.autopilot, sample_rate=None)  # as its peaks
    answer = steady.answer(c.plant, c.wind)
    seen = dict(zip(answer.labels, np.degrees(answer(times)), strict=True))
    wind, B = np.degrees(c.wind(times)), float(c.plant.coefficients.B)
    against = -float(np.sign(B * c.wind.peak))
    levels = {f"boundary K = {K:g}": limit for K, limit in c.boundaries.items()}
    levels[_MINIMUM] = c.minimum
    columns = [
        Column(_AUTOPILOT, seen.pop("deflection"), "deg", "deflection"),
        Column(_TRIM, -B * wind, "deg", "deflection"),
        *(
            Column(name, np.full(times.size, against * np.degrees(limit)), "deg", "deflection")
            for name, limit in levels.items()
            if np.isfinite(limit)
        ),
        *(Column(name, row, "deg", "angles") for name, row in seen.items() if name in ANGLES),
        Column("wind", wind, "deg", "angles"),
    ]
    peak = float(np.degrees(c.wind.peak))
    words = (
        f"{c.plant.model}, wind of {peak:.4g} deg and {end - start:.4g} s; peak deflection"
        f" {np.degrees(c.peak_deflection):.4g} deg, {c.relative:.3g} times trim"
    )
    name = c.plant.coefficients.name
    curves = Curves("comparison-with-trim", words, "time [s]", times, tuple(columns))
    look = Look(called(name, f"Autopilot beside trim\n{words}"), _ORDINATES, _STYLES, across=1)
    return draw(curves, look)
