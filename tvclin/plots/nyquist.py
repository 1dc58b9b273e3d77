"""The Nyquist diagram of a loop: encirclements, and the surroundings of -1."""

from copy import deepcopy
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.margins.loop import Loop
from tvclin.linear.flexible import AnyPlant
from tvclin.plots.curves import Column, Curves
from tvclin.plots.loop_samples import (
    ON_AXIS,
    LoopSamples,
    margin_marks,
    mode_marks,
    sampled,
    unstable_poles,
)
from tvclin.plots.style import (
    INK,
    WARM,
    Mark,
    control_plot,
    draw_marks,
    fine_grid,
    literal,
    numbered,
    write_numbers,
)

if TYPE_CHECKING:
    import control
    from control import ControlPlot
    from matplotlib.axes import Axes

_CURVE: dict[str, Any] = {"color": INK, "lw": 1.8}
_ARC = 181
"""Points of the contour on the way round a pole."""


def nyquist_chart(autopilot: Autopilot | Loop, plant: AnyPlant | None = None) -> "ControlPlot":
    """Draw the Nyquist curve of the loop, the whole of it and the surroundings of -1.

    The delay is exact. Around poles of the loop on the imaginary axis the contour is indented to
    the right, and what lies far out is drawn nearer, dash-dotted. The disk is the one of the disk
    margin: the curve touches it and does not enter.

    Parameters
    ----------
    autopilot, plant
        As of `nichols_chart`.
    """
    import matplotlib.pyplot as plt

    samples = sampled("nyquist_chart", autopilot, plant)
    found = _nyquist(samples)
    figure, panels = plt.subplots(1, 2, figsize=(12.0, 6.6), layout="constrained")

    def place(omega: float) -> tuple[float, float]:
        value = complex(samples.loop.response(omega))
        return value.real, value.imag

    marks = [*margin_marks(samples, place), *mode_marks(samples, place)]
    reach = _reach(samples)
    lines: list[Any] = []
    for axes in panels:
        # python-control shrinks the far parts of a response where they are kept: plot a copy
        drawn = deepcopy(found).plot(
            ax=axes,
            max_curve_magnitude=reach,
            primary_style=["-", "-."],
            mirror_style=["--", ":"],
            start_marker="",
            arrows=2,
            arrow_size=9,
            show_legend=False,
            **_CURVE,
        )
        lines += [line for part in drawn.lines.flat for line in part if line is not None]
        axes.set(xlabel="real part of L [-]", ylabel="imaginary part of L [-]")
        axes.margins(0.08)
        axes.set_aspect("equal", adjustable="datalim" if axes is panels[0] else "box")
    panels[0].set_title("the whole curve; dashed: negative frequencies", fontsize="medium")
    panels[1].set_title("near -1", fontsize="medium")
    _frame_near(panels[1], samples, marks)
    for axes in panels:
        fine_grid(axes)
        lines += draw_marks(axes, [*marks, Mark(-1.0, 0.0, shape="X", name="L = -1")])
    figure.suptitle(literal(f"Nyquist diagram: {_counted(found, samples)}\n{samples.words}"))
    handles, labels = panels[1].get_legend_handles_labels()
    figure.legend(handles[1:], labels[1:], loc="outside lower center", ncols=2)
    far = [numbered(mark, not mark.inside(panels[1])) for mark in marks]
    write_numbers((panels[0], far), (panels[1], marks))
    return control_plot(lines, panels, _nyquist_curves(found, samples))


def _nyquist(samples: LoopSamples) -> "control.NyquistResponseData":
    """The response along the contour, indented to the right of the poles on the axis.

    Of a sampled loop the contour is that of its variable w, told at frequencies of the s plane.
    """
    import control

    loop = samples.loop
    axis = np.imag(loop.s_to_w(1j * samples.omega[np.newaxis]))[0]
    poles = loop.form.open_poles()[0].astype(complex)
    slack = ON_AXIS * np.abs(poles).max()
    corners = np.unique(np.abs(poles[(np.abs(poles.real) <= slack) & (poles.imag >= 0.0)].imag))
    radius = 1e-2 * float(axis[0])
    arc = radius * np.sin(np.linspace(-0.5 * np.pi, 0.5 * np.pi, _ARC))
    near = (corners[:, np.newaxis] + arc).ravel()
    nu = np.unique(np.concatenate([[0.0], near[near > 0.0], axis]))
    apart = np.abs(nu[:, np.newaxis] - corners).min(axis=-1, initial=np.inf)
    contour = np.sqrt(np.maximum(radius**2 - apart**2, 0.0)) + 1j * nu
    values = loop.form.value(contour[np.newaxis])[0]
    omega = np.imag(loop.w_to_s(1j * nu[np.newaxis]))[0]
    clockwise = -np.sum(np.diff(np.unwrap(np.angle(1.0 + values)))) / np.pi
    return control.NyquistResponseData(
        round(clockwise), contour.real + 1j * omega, values, 0, sysname="loop"
    )


def _counted(found: Any, samples: LoopSamples) -> str:
    """What Nyquist's criterion says: encirclements, poles of the loop, and the verdict."""
    turns, open_loop = -found.count, unstable_poles(samples.loop)
    way = "counterclockwise" if turns >= 0 else "clockwise"
    times = f"{abs(turns)} {way} encirclement{'s' * (abs(turns) != 1)} of -1"
    poles = f"{open_loop} unstable open-loop pole{'s' * (open_loop != 1)}"
    return f"{times}, {poles}: {samples.verdict}"


def _reach(samples: LoopSamples) -> float:
    """How far out the curve is drawn to scale."""
    sizes = np.abs(samples.response)
    crossings = samples.margins.crossings
    factors = crossings.gain_factors[np.isfinite(crossings.gain_factors)]
    peaks = [mode.peak for mode in samples.modes if np.isfinite(mode.peak)]
    far = float(np.max([*(1.0 / factors[factors > 0.0]), *peaks], initial=2.0))
    largest = float(sizes.max())
    return 1.25 * largest if largest < 4.0 * far else 2.0 * far


def _frame_near(axes: "Axes", samples: LoopSamples, marks: list[Mark]) -> None:
    """Show the surroundings of -1: the unit circle, and the disk that the loop stays out of."""
    from matplotlib.colors import to_rgba
    from matplotlib.patches import Circle

    dots = {"fc": "none", "ec": "0.35", "ls": ":", "lw": 1.2, "zorder": 1.5}
    axes.add_patch(Circle((0.0, 0.0), 1.0, label="|L| = 1", **dots))
    alpha = samples.margins.disk_margin
    if np.isfinite(alpha) and alpha < 2.0:
        ends = (2.0 + alpha) / (2.0 - alpha), (2.0 - alpha) / (2.0 + alpha)
        middle, radius = -0.5 * sum(ends), 0.5 * (ends[0] - ends[1])
        label = f"disk margin {alpha:.2f}"
        style = {"ec": WARM, "ls": "--", "lw": 1.6, "zorder": 1.2}
        axes.add_patch(Circle((middle, 0.0), radius, label=label, fc=to_rgba(WARM, 0.1), **style))
    far = [-mark.x for mark in marks if np.isfinite(mark.x) and mark.x > -4.0]
    left = max([2.2, *(1.2 * x for x in far)])
    axes.set_xlim(-left, 1.2)
    axes.set_ylim(-0.5 * (left + 1.2), 0.5 * (left + 1.2))


def _nyquist_curves(found: Any, samples: LoopSamples) -> Curves:
    columns = (
        Column("real part", np.asarray(found.response.real), "-"),
        Column("imaginary part", np.asarray(found.response.imag), "-"),
    )
    omega = np.asarray(found.contour.imag)
    words = f"{samples.words}; {samples.verdict}"
    return Curves("nyquist", words, "frequency [rad/s]", omega, columns)
