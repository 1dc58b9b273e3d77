"""Spectra of a loop in turbulence: the wind, the nozzle and the vehicle over frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tvclin.base.errors import InputError, instance
from tvclin.control.turbulence.driven_loop import (
    ANGLE_OF_ATTACK,
    DEFLECTION,
    DEFLECTION_RATE,
)
from tvclin.control.turbulence.loop_covariance import LoopCovariance
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import COLOURS, INK, WARM, Look, Style, draw

if TYPE_CHECKING:
    from control import ControlPlot

_FREQUENCIES_HZ = np.logspace(-3.0, 2.0, 401)
"""Frequencies [Hz]; of a sampled autopilot those up to half its rate."""
_ANGLES, _RATES = "angles [deg/sqrt(Hz)]", "rates [deg/s/sqrt(Hz)]"
_DRAWN: dict[str, tuple[str, Style]] = {
    ANGLE_OF_ATTACK: (_ANGLES, {"color": INK, "lw": 1.4, "ls": "--"}),
    "attitude": (_ANGLES, {"color": COLOURS[0], "lw": 1.6}),
    DEFLECTION: (_ANGLES, {"color": WARM, "lw": 2.0}),
    "attitude_rate": (_RATES, {"color": COLOURS[0], "lw": 1.6, "ls": ":"}),
    DEFLECTION_RATE: (_RATES, {"color": WARM, "lw": 2.0, "ls": ":"}),
}
"""Panel and style of each output."""
_DECADES = 6.0
"""Decades of the ordinate below the largest value."""


def spectrum_curves(covariance: LoopCovariance) -> Curves:
    """Return the curves of `spectrum_chart`: square roots of one-sided spectra per Hz."""
    instance("covariance", covariance, LoopCovariance, "see turbulence_covariance")
    if not covariance.intensity:
        raise InputError("a spectrum needs turbulence of an intensity above zero")
    hertz = _FREQUENCIES_HZ[2.0 * np.pi * _FREQUENCIES_HZ <= covariance.max_frequency]
    columns = []
    for name, (panel, _) in _DRAWN.items():
        if name in covariance.outputs:
            power = 2.0 * np.pi * covariance.spectrum(2.0 * np.pi * hertz, name)
            unit = "deg/sqrt(Hz)" if panel == _ANGLES else "deg/s/sqrt(Hz)"
            density = np.degrees(np.sqrt(power))
            columns.append(Column(name.replace("_", " "), density, unit, panel.split(" [")[0]))
    words = f"spectra in turbulence of {covariance.intensity:.4g} m/s at {covariance.speed:.6g} m/s"
    return Curves("turbulence", words, "frequency [Hz]", hertz, tuple(columns))


def spectrum_chart(
    covariance: LoopCovariance, title: str = "Spectra of the loop in turbulence"
) -> ControlPlot:
    """Draw the spectra of angles and rates of a loop in turbulence, over frequency.

    Parameters
    ----------
    covariance : LoopCovariance
        Result of `turbulence_covariance`.
    title : str
        Title of the figure.

    Raises
    ------
    InputError
        For turbulence without an intensity.
    """
    curves = spectrum_curves(covariance)
    styles = {name.replace("_", " "): style for name, (_, style) in _DRAWN.items()}
    ordinates = {label.split(" [")[0]: label for label in (_ANGLES, _RATES)}
    plot = draw(curves, Look(title, ordinates, styles))
    for axes, columns in zip(plot.axes.flat, curves.panels.values(), strict=False):
        top = max(float(column.values.max()) for column in columns)
        axes.set(xscale="log", yscale="log", ylim=(2.0 * top * 10.0**-_DECADES, 2.0 * top))
    return plot
