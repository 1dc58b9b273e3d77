"""Figures. Each function returns python-control's `ControlPlot`: lines, axes, figure."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.boundary import boundary_limit
from tvclin.closed_forms import rectangular_limit, triangular_limit, triangular_limit_with_drift
from tvclin.coefficients import Coefficients
from tvclin.modes import all_modes
from tvclin.plant import MODELS, Plant
from tvclin.study import Study

if TYPE_CHECKING:
    from control import ControlPlot
    from matplotlib.axes import Axes

DEAD_BANDS = (1.0, 0.75, 0.5, 0.25, 0.0)
_LINES = ("-", "--", "-.", (0, (5, 1, 1, 1, 1, 1)), ":")
_MARKS = ("o", "s", "^", "D")
_INK = "#1a1a2e"
_COLOURS = ("#1b4f9c", "#2a8a8a", "#7a6a12", "#b4541a", "#8a2255")


def boundary_chart(
    tau_beta: ArrayLike | None = None,
    dead_bands: Sequence[float] = DEAD_BANDS,
    coefficients: Coefficients | None = None,
) -> "ControlPlot":
    """Draw the boundary limit against tau beta, the report's figure 2.

    Parameters
    ----------
    tau_beta : array_like, optional
        Abscissas, ``(n,)``, positive; 0.05 to 20 where not given.
    dead_bands : sequence of float
        K of the curves for triangular winds.
    coefficients : Coefficients, optional
        Of one vehicle; the boundaries with drift, eqs (16) and (18), are then drawn instead of
        eqs (7) and (12).
    """
    x = np.linspace(0.05, 20.0, 400) if tau_beta is None else np.asarray(tau_beta, dtype=float)
    axes = _new_axes()
    c = coefficients
    rectangular = rectangular_limit(x, 1.0 if c is None else c.K1)
    lines = axes.plot(x, rectangular, color=_INK, lw=2, label="rectangular")
    for K, colour, style in zip(dead_bands, _cycle(_COLOURS), _cycle(_LINES), strict=False):
        if c is None:
            y = triangular_limit(x, K)
        else:
            y = triangular_limit_with_drift(x, K, c.beta, c.b1, c.b2)
        lines += axes.plot(x, y, color=colour, ls=style, lw=1.6, label=f"triangular, K = {K:g}")
    what = "without drift: eqs (7), (12)" if c is None else "with drift: eqs (16), (18)"
    axes.set(
        title=f"Stability boundary {what}",
        xlabel=r"wind duration  $\tau\beta$",
        ylabel=r"boundary limit  $y_{BR} = -\delta_{max}/(B\,\alpha_{w,max})$",
        xlim=(0, float(x.max())),
        ylim=(0, 1.02),
    )
    axes.set_yticks(np.arange(0, 1.01, 0.1))
    axes.locator_params(axis="x", nbins=12)
    _fine_grid(axes)
    axes.legend(title="wind and dead band", loc="upper left", bbox_to_anchor=(1.01, 1.0))
    return _control_plot(lines, axes)


def study_chart(study: Study, durations: ArrayLike | None = None) -> "ControlPlot":
    """Draw the required deflection against the duration of the wind, for one study.

    Solid lines are the first model of the study's boundaries, broken ones the second; the wind
    and the limit of the study are marked.

    Parameters
    ----------
    study : Study
        The study; its peak, shape and vehicle are kept.
    durations : array_like, optional
        Abscissas [s], positive; up to three times the study's duration where not given.
    """
    chosen = float(study.wind.duration)
    x = np.linspace(0.02, 3.0, 200) * chosen if durations is None else np.asarray(durations)
    wind = type(study.wind)(peak=study.wind.peak, duration=x[:, np.newaxis])
    shown = np.array(sorted({1.0, 0.5, 0.0, study.dead_band}, reverse=True))
    axes = _new_axes()
    lines: list[Any] = []
    for model, style in zip(study.boundaries, ("-", "--"), strict=False):
        found = boundary_limit(Plant(study.coefficients, model), wind, shown)
        for K, y, colour in zip(shown, found.deflection.T, _cycle(_COLOURS), strict=False):
            label = f"K = {K:g}, {model}"
            lines += axes.plot(x, np.abs(np.degrees(y)), style, color=colour, lw=1.6, label=label)
    axes.axvline(chosen, color=_INK, lw=1.0)
    axes.plot(chosen, np.degrees(study.required_deflection), "o", color=_INK, label="required")
    trim = float(np.degrees(study.trim_deflection))
    axes.axhline(trim, color="0.4", lw=1.0, ls=":", label="trim, no drift")
    if study.limit is not None:
        limit = float(np.degrees(study.limit))
        axes.axhline(limit, color="#b4541a", lw=1.6, label="available limit")
    axes.set(
        title=f"{study.vehicle.name}: winds of {np.degrees(study.wind.peak):.3g} deg",
        xlabel="wind duration [s]",
        ylabel="deflection [deg]",
        xlim=(0.0, float(x.max())),
        ylim=(0.0, None),
    )
    _fine_grid(axes)
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0))
    return _control_plot(lines, axes)


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

    _, panels = plt.subplots(1, 2, figsize=(12, 5.6), layout="constrained")
    found = {model: all_modes(Plant(coefficients, model)) for model in models}
    everywhere = np.concatenate([modes.poles for modes in found.values()])
    reach = float(np.abs(everywhere).max()) or 1.0
    small = np.abs(everywhere)[np.abs(everywhere) < reach / 5]
    near = 1.6 * float(small.max(initial=0.0)) or reach / 5
    lines: list[Any] = []
    for axes, radius in zip(panels, (1.5 * reach, near), strict=True):
        axes.axhline(0.0, color="0.6", lw=0.8)
        axes.axvline(0.0, color="0.6", lw=0.8)
        axes.axvspan(0.0, radius, color="#b4541a", alpha=0.07)
        for row, (model, colour, mark) in enumerate(
            zip(models, _cycle(_COLOURS), _cycle(_MARKS), strict=False)
        ):
            poles = found[model].poles.astype(complex)
            strength = found[model].deflection_residues + 0j
            inside = np.abs(poles) <= radius
            if axes is panels[0]:
                inside &= np.abs(poles) > near
            lines += axes.plot(
                poles.real,
                poles.imag,
                mark,
                color=colour,
                ms=8 - row,
                mfc="none",
                mew=1.6,
                ls="",
                label=model,
            )
            for pole, residue in zip(poles[inside], strength[inside], strict=True):
                if pole.imag >= 0.0:
                    lift = 14 + 13 * row if axes is panels[0] else 10
                    _write_residue(axes, pole, residue, lift, colour)
        axes.set(
            xlim=(-radius, radius),
            ylim=(-radius, radius),
            xlabel="real part  [1/s]",
            ylabel="imaginary part  [rad/s]",
        )
        _fine_grid(axes)
    panels[0].set_title("Poles, and residues of attitude per deflection [1/s]")
    panels[1].set_title("Near the origin")
    panels[0].legend(loc="lower center", ncols=2)
    return _control_plot(lines, panels)


def _write_residue(axes: "Axes", pole: complex, residue: complex, lift: int, colour: str) -> None:
    if pole.imag == 0.0:
        text = f"{pole.real:+.5f}: {residue.real:+.4f}"
    else:
        text = f"{pole:.5f}: {residue:.4f}"
    axes.annotate(
        text,
        (pole.real, pole.imag),
        xytext=(0, lift),
        textcoords="offset points",
        ha="center",
        fontsize=8,
        color=colour,
    )


def _new_axes() -> "Axes":
    import matplotlib.pyplot as plt

    _, axes = plt.subplots(figsize=(8.6, 5.6), layout="constrained")
    return axes


def _fine_grid(axes: "Axes") -> None:
    axes.minorticks_on()
    axes.grid(which="major", color="0.75", lw=0.8)
    axes.grid(which="minor", color="0.9", lw=0.5)
    axes.set_axisbelow(True)


def _cycle(items: Sequence[Any]) -> list[Any]:
    return list(items) * 8


def _control_plot(lines: list[Any], axes: Any) -> "ControlPlot":
    from control import ControlPlot

    panels = np.atleast_2d(axes)
    table = np.empty(panels.shape, dtype=object)
    for index, panel in np.ndenumerate(panels):
        table[index] = [line for line in lines if line.axes is panel]
    return ControlPlot(table, panels, panels[0, 0].figure)
