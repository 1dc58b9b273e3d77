"""Where the poles are, and how strongly the deflection excites them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.errors import different, instance, one_of, single
from tvclin.linear.modes import Modes, all_modes
from tvclin.linear.plant import MODELS, Plant
from tvclin.plots.style import COLOURS, MARKS, WARM, control_plot, cycle, fine_grid, literal
from tvclin.vehicle.coefficients import Coefficients

if TYPE_CHECKING:
    from control import ControlPlot
    from matplotlib.axes import Axes


def pole_map(coefficients: Coefficients, models: Sequence[str] = MODELS) -> "ControlPlot":
    """Draw the poles of the models, with the residue from deflection to attitude beside each.

    The right panel shows the poles near the origin, which the whole map cannot separate.

    Parameters
    ----------
    coefficients : Coefficients
        Of one vehicle.
    models : sequence of str
        Models to draw.
    """
    import matplotlib.pyplot as plt

    instance("coefficients", coefficients, Coefficients, "see Coefficients.from_vehicle")
    single("coefficients", coefficients.batch)
    models = different("models", tuple(models) if isinstance(models, list) else models)
    models = [one_of("model", one, MODELS) for one in models]
    _, panels = plt.subplots(1, 2, figsize=(10.4, 5.6), layout="constrained")
    found = {model: all_modes(Plant(coefficients, model)) for model in models}
    everywhere = np.concatenate([modes.poles for modes in found.values()])
    reach = float(np.abs(everywhere).max()) or 1.0
    small = np.abs(everywhere)[np.abs(everywhere) < reach / 5]
    near = 1.6 * float(small.max(initial=0.0)) or reach / 5
    lines: list[Any] = []
    for axes, radius, least in ((panels[0], 1.5 * reach, near), (panels[1], near, -1.0)):
        _prepare(axes, radius)
        for row, model in enumerate(models):
            lines += _mark_poles(axes, found[model], model, row, (least, radius))
    panels[0].set_title("Poles, and residues of attitude per deflection [1/s]")
    panels[1].set_title("Near the origin")
    panels[1].locator_params(axis="x", nbins=6)  # small numbers are long
    if coefficients.name:
        panels[0].figure.suptitle(literal(coefficients.name))
    panels[0].legend(loc="lower center", ncols=2)
    return control_plot(lines, panels)


def _prepare(axes: "Axes", radius: float) -> None:
    axes.axhline(0.0, color="0.6", lw=0.8)
    axes.axvline(0.0, color="0.6", lw=0.8)
    axes.axvspan(0.0, radius, color=WARM, alpha=0.07)
    axes.set(
        xlim=(-radius, radius),
        ylim=(-radius, radius),
        xlabel="real part [1/s]",
        ylabel="imaginary part [rad/s]",
    )
    fine_grid(axes)


def _mark_poles(
    axes: "Axes", modes: Modes, model: str, row: int, named: tuple[float, float]
) -> list[Any]:
    """Mark the poles of one model, and write the residue beside those of the sizes `named`."""
    poles, strength = modes.poles.astype(complex), modes.deflection_residues + 0j
    colour, size = cycle(COLOURS)[row], np.abs(poles)
    mark = {"marker": cycle(MARKS)[row], "ms": 8 - row, "mfc": "none", "mew": 1.6}
    lines = axes.plot(poles.real, poles.imag, ls="", color=colour, label=model, **mark)
    inside = (size > named[0]) & (size <= named[1]) & (poles.imag >= 0.0)
    lift = 12 + 14 * (row if named[0] >= 0.0 else row % 2)
    for pole, residue in zip(poles[inside], strength[inside], strict=True):
        _write_residue(axes, pole, residue, lift, colour)
    return lines


def _write_residue(axes: "Axes", pole: complex, residue: complex, lift: int, colour: str) -> None:
    if pole.imag == 0.0:
        text = f"{pole.real:.4g}: {residue.real:.4g}"
    else:
        text = f"{pole:.4g}: {residue:.4g}"
    axes.annotate(
        text,
        (pole.real, pole.imag),
        xytext=(0, lift),
        textcoords="offset points",
        ha="center",
        fontsize=9.5,
        color=colour,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
    )
