"""What laws need in triangular winds, beside the open-loop limits, over their duration."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.answers.requirement import required_deflection
from tvclin.answers.trials import law_curve
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import (
    InputError,
    nonzero,
    number,
    one_row,
    positive,
    shown,
    single,
    small_angle,
)
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.optimum.minimum_peak import optimum_deflection
from tvclin.control.laws.law import Law
from tvclin.linear.flexible import AnyPlant, check_plant
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import INK, Look, Style, called, draw, law_styles
from tvclin.winds.pulses import TriangularWind

if TYPE_CHECKING:
    from control import ControlPlot
    from matplotlib.lines import Line2D


TAU_BETA = np.array([1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 14.0, 20.0, 28.0, 40.0])
_FINE = 400
_FREE, _KNOWN = "any law, no forecast", "wind known (C)"
_OPEN: dict[str, Style] = {
    "required, K = 1": {"color": "0.45", "ls": "--", "lw": 1.4},
    "required, K = 0.5": {"color": "0.45", "ls": "-.", "lw": 1.4},
    _FREE: {"color": INK, "ls": "-", "lw": 2.4},
    _KNOWN: {"color": INK, "ls": ":", "lw": 2.0},
}


def laws_chart(
    plant: AnyPlant,
    laws: Mapping[str, Law],
    peak: float,
    tau_beta: FloatArray = TAU_BETA,
    **hardware: Any,
) -> "ControlPlot":
    """Draw the boundary of each law over tau*beta, with the limits that they are measured by.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        The plant that flies; what laws are measured by is of the rigid one.
    laws : mapping of str to Law
        By name, as of `standard_laws`.
    peak : float
        Peak of the triangular winds [rad].
    tau_beta : ndarray
        Durations times beta, or with damping the pole, rising, ``(n,)``.
    **hardware
        sample_rate, rate_limit, actuator and delay, as of `law_trials`.

    Notes
    -----
    The numbers are those at `tau_beta`, where laws have a mark; between them the lines are monotone
    cubics (PCHIP).
    """
    check_plant(plant)
    single("plant", plant.batch)
    if not isinstance(laws, Mapping) or not all(isinstance(name, str) for name in laws):
        raise InputError(f"laws must be a dict of laws by their names; got {shown(laws)}")
    peak = number("peak", peak, small_angle("a wind", nonzero), "rad")
    tau_beta = one_row("tau_beta", positive("tau_beta", tau_beta))
    pole, symbol = float(plant.coefficients.pole), plant.coefficients.pole_symbol
    winds = [TriangularWind(peak=peak, duration=float(x) / pole) for x in tau_beta]
    trim = abs(float(plant.coefficients.B) * peak)
    rows = {
        "required, K = 1": [required_deflection(plant.rigid, w).limit for w in winds],
        "required, K = 0.5": [required_deflection(plant.rigid, w, 0.5).limit for w in winds],
        _FREE: [forecast_free_limit(plant.rigid, w).limit for w in winds],
        _KNOWN: [optimum_deflection(plant.rigid, w).peak / trim for w in winds],
    }
    columns = [Column(name, np.array(row)) for name, row in rows.items()]
    columns += [
        Column(name, law_curve(plant, law, tau_beta, peak, **hardware))
        for name, law in laws.items()
    ]
    words = f"{plant.model}, triangular winds of {np.degrees(peak):.4g} deg"
    curves = Curves("laws", words, f"tau*{symbol}", tau_beta, tuple(columns))
    look = Look(
        called(plant.coefficients.name, f"From trim to the minimum\n{words}"),
        "deflection limit over |B alpha_w,max|",
        _OPEN | law_styles(laws),
        limits={"": (0.0, 2.0)},
    )
    plot = draw(curves, look)
    for line in plot.lines[0, 0]:
        _smooth(line)
    return plot


def _smooth(line: "Line2D") -> None:
    """Draw a line through its points without corners and without swinging, marks at the points."""
    from scipy.interpolate import PchipInterpolator

    x, y = (np.asarray(values, dtype=float) for values in line.get_data())
    known = np.isfinite(y)
    if known.sum() < x.size or x.size < 3:  # where there is no boundary the line is broken
        return
    fine = np.unique([*x, *np.linspace(x[0], x[-1], _FINE)])
    line.set_data(fine, PchipInterpolator(x, y)(fine))
    line.set_markevery(np.searchsorted(fine, x).tolist())
