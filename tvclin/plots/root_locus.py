"""The root locus of a loop: where the closed-loop poles go with the loop gain."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.base.errors import InputError, nonnegative
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.kernels import polynomials
from tvclin.linear.plant import Plant
from tvclin.plots.curves import Column, Curves
from tvclin.plots.loop_samples import (
    LoopSamples,
    corner_frequencies,
    margin_marks,
    sampled,
    title,
)
from tvclin.plots.marks import Mark, draw_marks, numbered, write_numbers
from tvclin.plots.style import COLOURS, INK, WARM, control_plot, fine_grid

if TYPE_CHECKING:
    import control
    from control import ControlPlot
    from matplotlib.axes import Axes

FloatArray = NDArray[np.float64]

_STEP, _ROUNDS, _PARTS = 0.015, 4, 4
"""The largest step of a pole as a part of its size; how often, and into what, it is divided."""


def root_locus_chart(
    autopilot: Autopilot, plant: Plant, gains: ArrayLike | None = None
) -> ControlPlot:
    """Draw where the closed-loop poles go when a factor multiplies the loop gain.

    Parameters
    ----------
    autopilot, plant
        As of `nichols_chart`.
    gains : array_like, optional
        Factors on the loop gain, zero or positive, ``(n,)``; from zero to beyond the
        gain-increase margin where not given. The factor 1 is the loop as it is.

    Raises
    ------
    InputError
        As `nichols_chart`, and for factors that are no row of numbers above or at zero.

    Notes
    -----
    A delay is its Pade approximation, whose own poles lie far out and are left out of the frame.
    """
    import control
    import matplotlib.pyplot as plt

    samples = sampled("root_locus_chart", autopilot, plant)
    loop = samples.system()
    poles = loop.feedback().poles()
    radii = _radii(samples, plant, poles)
    factors = _default_factors(loop, samples, radii) if gains is None else _given(gains)
    found = control.root_locus_map(loop, factors)
    size = (12.0, 6.8) if len(radii) > 1 else (8.6, 7.4)
    figure, panels = plt.subplots(1, len(radii), figsize=size, layout="constrained", squeeze=False)
    marks = [*_pole_marks(poles), *_axis_marks(samples)]
    lines: list[Any] = []
    for axes, radius in zip(panels[0], radii, strict=True):
        lines += _draw_locus(axes, found, radius)
        lines += draw_marks(axes, marks)
    if len(radii) > 1:
        panels[0, 0].set_title("the whole locus", fontsize="medium")
        panels[0, 1].set_title("near the origin", fontsize="medium")
    figure.suptitle(title("Root locus of the loop gain", samples))
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2)
    far = [numbered(mark, not mark.inside(panels[0, -1])) for mark in marks]
    shown = [far, marks][-len(radii) :]
    write_numbers(*zip(panels[0], shown, strict=True))
    return control_plot(lines, panels, _locus_curves(found, samples))


def _given(gains: ArrayLike) -> FloatArray:
    factors = nonnegative("gains", gains)
    if factors.ndim != 1 or factors.size < 2:
        raise InputError(
            "gains must be a row of two or more factors on the loop gain; got the shape"
            f" {factors.shape}"
        )
    return np.unique(factors)


def _default_factors(
    loop: control.TransferFunction, samples: LoopSamples, radii: list[float]
) -> FloatArray:
    """Factors from zero to beyond where the loop becomes unstable; if it is so, stable and back."""
    known = samples.margins.crossings.gain_factors
    known = np.sort(known[np.isfinite(known) & (known > 0.0)])
    above = known[known > 1.0][: 1 if samples.margins.stable else 2]
    top = float(np.clip(2.0 * above.max(initial=5.0), 3.0, 1e4))
    steps = np.concatenate([np.geomspace(1e-6 * top, top, 400), np.linspace(0.0, top, 200)])
    steps = np.unique(np.concatenate([steps, [1.0], known[known < top]]))
    return _refined(loop, steps, radii)


def _refined(loop: control.TransferFunction, factors: FloatArray, radii: list[float]) -> FloatArray:
    """Put factors between those from which a pole would go too far in one step."""
    above, below = loop.num[0][0], loop.den[0][0]
    above = np.pad(above, (below.size - above.size, 0))
    for _ in range(_ROUNDS):
        poles = polynomials.roots(below + factors[:, np.newaxis] * above)
        steps = np.abs(poles[1:, :, np.newaxis] - poles[:-1, np.newaxis, :]).min(axis=-1)
        sizes = np.abs(poles[1:])
        coarse = (steps > _STEP * np.maximum(sizes, radii[-1])) & (sizes < 2.0 * radii[0])
        places = np.flatnonzero(np.any(coarse, axis=-1))
        between = np.linspace(factors[places], factors[places + 1], _PARTS + 1)
        factors = np.unique(np.concatenate([factors, between.ravel()]))
    return factors


def _radii(samples: LoopSamples, plant: Plant, poles: NDArray[Any]) -> list[float]:
    """How far the panels go: all poles but those of the delay, and those close to the origin."""
    order = samples.loop.denominator.shape[-1] - 1
    sizes = np.sort(np.abs(poles))[:order]
    highest = samples.margins.gain_increase_frequency
    known = [*corner_frequencies(samples.loop), *sizes]
    whole = 1.2 * float(np.nanmax([*known, highest]))
    slow = [*np.abs(polynomials.roots(plant.denominator)), *sizes[sizes < 0.25 * whole]]
    near = 1.5 * float(max(slow))
    return [whole, near] if near < 0.35 * whole else [whole]


def _pole_marks(poles: NDArray[Any]) -> list[Mark]:
    """The closed-loop poles, with a number beside one of each pair."""
    name, marks = "closed-loop poles (factor 1)", []
    for pole in poles[np.argsort(-poles.imag)]:
        text = f"{pole.real:.3g}" if pole.imag == 0.0 else f"{pole.real:.3g} ± {pole.imag:.3g}j"
        text = text if pole.imag >= 0.0 else ""
        marks.append(Mark(pole.real, pole.imag, text, "D", name, COLOURS[1]))
        name = ""
    return marks


def _axis_marks(samples: LoopSamples) -> list[Mark]:
    """Where the locus crosses the axis at the margins that decide."""
    marks = margin_marks(samples, lambda omega: (0.0, omega))[:2]
    m = samples.margins
    factors = (1.0 / m.aero_margin if m.aero_margin else np.inf, m.gain_increase)
    found = []
    for mark, factor in zip(marks, factors, strict=False):
        found.append(replace(mark, text=f"factor {factor:.3g}" if mark.text else ""))
        if mark.y > 0.0:
            found.append(replace(mark, y=-mark.y, text="", name=""))
    return found


def _draw_locus(axes: Axes, found: Any, radius: float) -> list[Any]:
    rightmost = np.max(found.poles.real[np.abs(found.poles) < radius], initial=0.0)
    frame = (-1.2 * radius, max(0.6 * radius, 1.2 * float(rightmost)))
    drawn = found.plot(ax=axes, interactive=False, show_legend=False, color=INK)
    axes.axhline(0.0, color="0.6", lw=0.8, zorder=0.5)
    axes.axvline(0.0, color="0.4", lw=1.0, zorder=0.5)
    axes.axvspan(0.0, frame[1], color=WARM, alpha=0.07, zorder=0.5)
    axes.set(
        xlim=frame,
        ylim=(-radius, radius),
        xlabel="real part of s  [1/s]",
        ylabel="imaginary part of s  [rad/s]",
    )
    axes.set_aspect("equal", adjustable="box")
    fine_grid(axes)
    poles, zeros, loci = (drawn.lines[0, k] for k in range(3))
    for group, label in ((poles, "poles of the loop"), (zeros, "zeros of the loop")):
        for line in group:
            line.set(label=label, zorder=4)
    for line in loci:
        line.set(label="_locus", lw=1.6, zorder=3)
    return [*poles, *zeros, *loci]


def _locus_curves(found: Any, samples: LoopSamples) -> Curves:
    columns = []
    for number, branch in enumerate(np.transpose(found.loci), 1):
        columns.append(Column(f"pole {number} real part", np.asarray(branch.real), "1/s"))
        columns.append(Column(f"pole {number} imaginary part", np.asarray(branch.imag), "rad/s"))
    factors = np.asarray(found.gains, dtype=float)
    abscissa = "factor on the loop gain [-]"
    return Curves(
        "root-locus", f"{samples.words}; {samples.verdict}", abscissa, factors, tuple(columns)
    )
