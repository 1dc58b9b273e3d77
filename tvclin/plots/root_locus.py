"""The root locus of a loop: where the closed-loop poles go with the loop gain."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, FloatArray
from tvclin.base.errors import InputError, nonnegative
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.margins.loop import Loop, SampledLoop
from tvclin.linear.flexible import AnyPlant
from tvclin.plots.curves import Column, Curves
from tvclin.plots.loop_samples import (
    MODE,
    LoopSamples,
    corner_frequencies,
    margin_marks,
    sampled,
    title,
)
from tvclin.plots.root_locus import LocusPoles
from tvclin.plots.style import (
    COLOURS,
    INK,
    WARM,
    Mark,
    control_plot,
    draw_marks,
    fine_grid,
    named_once,
    numbered,
    write_numbers,
)

if TYPE_CHECKING:
    from control import ControlPlot
    from matplotlib.axes import Axes


_END: dict[str, Any] = {"ls": "", "color": INK, "zorder": 4}
_LEFT = 1.2
"""Poles of a sampled loop farther than so many times half its rate are left out of the frame."""
_TALL = 1.15
"""The frame of the modes is so many times as high as the fastest of them is fast."""


def root_locus_chart(
    autopilot: Autopilot | Loop, plant: AnyPlant | None = None, gains: ArrayLike | None = None
) -> ControlPlot:
    """Draw where the closed-loop poles go when a factor multiplies the loop gain.

    Each pole is one line from a pole of the loop towards a zero, or far out. Around a flexible
    vehicle a panel of its own shows the modes, by their names, with a stretched real axis.

    Parameters
    ----------
    autopilot, plant
        As of `nichols_chart`. Of a sampled loop the discrete poles z are drawn as s = ln(z)/h, up
        to half the sample rate: the unit circle is the imaginary axis.
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
    import matplotlib.pyplot as plt

    samples = sampled("root_locus_chart", autopilot, plant)
    locus = LocusPoles.of("root_locus_chart", samples.loop, samples.pade_order)
    poles = locus.closed(np.ones(1))[0]
    radii = _radii(samples, poles)
    factors = _default_factors(locus, samples, radii) if gains is None else _given(gains)
    branches = locus.branches(factors)
    count = len(radii) + bool(samples.modes)
    rows: Any = [[0, 0]] if count == 1 else [[0, 1], [2, 2]][: count - 1]
    size = (8.6, 7.4) if count == 1 else (10.4, 6.4 * len(rows))
    figure, placed = plt.subplot_mosaic(rows, figsize=size, layout="constrained")
    panels = np.array([[placed[k] for k in range(count)]])
    # the branches end that do not end at a zero or out of the frame
    ends = branches[-1][np.abs(branches[-1]) < radii[0]]
    ended = f"end of the locus (factor {factors[-1]:.3g})"
    marks = [
        *named_once(map(_pole_mark, poles[np.argsort(-poles.imag)])),
        *_axis_marks(samples),
        *named_once(Mark(end.real, end.imag, "", "|", ended, INK) for end in ends),
    ]
    lines: list[Any] = []
    for axes in panels[0]:
        lines += _draw_locus(axes, locus, _within(branches, samples.loop))
    for axes, radius in zip(panels[0], radii, strict=False):
        _frame_round(axes, radius, locus.poles)
    if len(radii) > 1:
        panels[0, 0].set_title("the whole locus", fontsize="medium")
        panels[0, 1].set_title("near the origin", fontsize="medium")
    nearest = panels[0, len(radii) - 1]
    shown = [[numbered(mark, not mark.inside(nearest)) for mark in marks], marks][-len(radii) :]
    if samples.modes:
        _frame_modes(panels[0, -1], samples)
        plain = [numbered(mark, False) for mark in marks]
        shown[0] = plain if len(radii) > 1 else marks
        poles_of_modes = ((complex(mode.pole), mode.name) for mode in samples.modes)
        begun = "modes in the vehicle (factor 0)"
        named = (Mark(p.real, p.imag, one, MODE[0], begun, MODE[1]) for p, one in poles_of_modes)
        shown.append([*plain, *named_once(named)])
    for axes, drawn in zip(panels[0], shown, strict=True):
        lines += draw_marks(axes, drawn)
    name = "Root locus of the loop gain"
    name += ", s = ln(z)/h" if isinstance(samples.loop, SampledLoop) else ""
    figure.suptitle(title(name, samples))
    handles, labels = panels[0, -1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2)
    write_numbers(*zip(panels[0], shown, strict=True))
    return control_plot(lines, panels, _locus_curves(factors, branches, samples))


def _within(branches: AnyArray, loop: Loop) -> AnyArray:
    """The branches, broken where a sampled pole steps over half the rate and comes back below."""
    if not isinstance(loop, SampledLoop):
        return branches
    steps = np.abs(np.diff(branches.imag, axis=0, prepend=branches.imag[:1]))
    return np.where(steps > float(loop.max_frequency()[0, 0]), np.nan, branches)


def _given(gains: ArrayLike) -> FloatArray:
    factors = nonnegative("gains", gains)
    if factors.ndim != 1 or factors.size < 2:
        raise InputError(
            "gains must be a row of two or more factors on the loop gain; got the shape"
            f" {factors.shape}"
        )
    return np.unique(factors)


def _default_factors(locus: LocusPoles, samples: LoopSamples, radii: list[float]) -> FloatArray:
    """Factors from zero to beyond where the loop becomes unstable; if it is so, stable and back."""
    known = samples.margins.crossings.gain_factors
    known = np.sort(known[np.isfinite(known) & (known > 0.0)])
    above = known[known > 1.0][: 1 if samples.margins.stable else 2]
    top = float(np.clip(2.0 * above.max(initial=5.0), 3.0, 1e4))
    steps = np.concatenate([np.geomspace(1e-6 * top, top, 400), np.linspace(0.0, top, 200)])
    steps = np.unique(np.concatenate([steps, [1.0], known[known < top]]))
    return locus.refined(steps, radii[-1], radii[0])


def _radii(samples: LoopSamples, poles: AnyArray) -> list[float]:
    """How far the panels go: all poles but those of the delay, and those close to the origin."""
    order = samples.loop.form.open_poles().shape[-1]
    sizes = np.sort(np.abs(poles))[:order]
    if isinstance(samples.loop, SampledLoop):  # farther left nothing is left after a few samples
        sizes = sizes[sizes <= _LEFT * float(samples.loop.max_frequency()[0, 0])]
    highest = np.array([samples.margins.gain_increase_frequency])
    known = [*corner_frequencies(samples.loop), *sizes]
    whole = 1.2 * float(np.nanmax([*known, *highest]))
    slow = [*np.abs(samples.airframe), *sizes[sizes < 0.25 * whole]]
    if samples.modes:  # these have their own panel
        slow = [*np.abs(samples.airframe), *highest[np.isfinite(highest)]]
    near = 1.5 * float(max(slow, default=whole))
    return [whole, near] if near < 0.35 * whole else [whole]


def _pole_mark(pole: complex) -> Mark:
    """A closed-loop pole, with a number beside one of each pair."""
    text = f"{pole.real:.3g}" if pole.imag == 0.0 else f"{pole.real:.3g} ± {pole.imag:.3g}j"
    text = text if pole.imag >= 0.0 else ""
    return Mark(pole.real, pole.imag, text, "D", "closed-loop poles (factor 1)", COLOURS[1])


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


def _draw_locus(axes: Axes, locus: LocusPoles, branches: AnyArray) -> list[Any]:
    axes.axhline(0.0, color="0.6", lw=0.8, zorder=0.5)
    axes.axvline(0.0, color="0.4", lw=1.0, zorder=0.5)
    lines = axes.plot(locus.poles.real, locus.poles.imag, "x", label="poles of the loop", **_END)
    lines += axes.plot(
        locus.zeros.real, locus.zeros.imag, "o", mfc="none", label="zeros of the loop", **_END
    )
    for branch in branches.T:
        lines += axes.plot(branch.real, branch.imag, color=INK, lw=1.6, zorder=3, label="_locus")
    return lines


def _frame_round(axes: Axes, radius: float, poles: AnyArray) -> None:
    rightmost = np.max(poles.real[np.abs(poles) < radius], initial=0.0)
    _frame(axes, (-1.2 * radius, max(0.6 * radius, 1.2 * float(rightmost))), (-radius, radius))
    axes.set_aspect("equal", adjustable="box")


def _frame_modes(axes: Axes, samples: LoopSamples) -> None:
    """Show the upper half plane to above the fastest mode, as wide as the modes go at factor 1."""
    poles = np.array([mode.pole for mode in samples.modes])
    ends = np.array([mode.closed_pole for mode in samples.modes])
    known = np.concatenate([poles, ends])
    wide = 2.0 * float(np.nanmax(np.abs(known.real)))
    _frame(axes, (-wide, 0.6 * wide), (0.0, _TALL * float(np.nanmax(known.imag))))
    axes.set_title("modes, real axis stretched", fontsize="medium")


def _frame(axes: Axes, xlim: tuple[float, float], ylim: tuple[float, float]) -> None:
    axes.axvspan(0.0, xlim[1], color=WARM, alpha=0.07, zorder=0.5)
    axes.set(xlim=xlim, ylim=ylim)
    axes.set(xlabel="real part of s [1/s]", ylabel="imaginary part of s [rad/s]")
    fine_grid(axes)


def _locus_curves(factors: FloatArray, branches: AnyArray, samples: LoopSamples) -> Curves:
    """The branches; those that set out from a mode, in a row of factors from zero, by its name."""
    names = [f"pole {number}" for number in range(1, branches.shape[-1] + 1)]
    for mode in samples.modes:
        if factors[0] == 0.0 and np.isfinite(mode.pole):
            names[int(np.argmin(np.abs(branches[0] - mode.pole)))] = mode.name
    columns = []
    for name, branch in zip(names, branches.T, strict=True):
        columns.append(Column(f"{name} real part", branch.real, "1/s"))
        columns.append(Column(f"{name} imaginary part", branch.imag, "rad/s"))
    words = f"{samples.words}; {samples.verdict}"
    return Curves("root-locus", words, "factor on the loop gain [-]", factors, tuple(columns))
