"""Frequency response of a loop: Nichols, Bode and Nyquist, with its margins, and its spectra.

The spectra are those in turbulence, of the wind, the nozzle and the vehicle.

python-control draws the curves of Bode and Nyquist from exact samples (`FrequencyResponseData`,
`NyquistResponseData`); it has no margins by band, no names of modes, no box of criteria and no disk
to draw. Its `nichols_grid` sets the frame to whole turns and -40 to 50 dB, and importing it takes
longer than the chart, whose contours are drawn here.
"""

from __future__ import annotations

from copy import deepcopy
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.errors import InputError, instance
from tvclin.base.lines import plural
from tvclin.base.quantities import satisfaction
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.margins.criteria import CRITERIA, Criteria
from tvclin.control.margins.loop import Loop
from tvclin.control.turbulence.driven_loop import ANGLE_OF_ATTACK, DEFLECTION, DEFLECTION_RATE
from tvclin.control.turbulence.loop_covariance import LoopCovariance
from tvclin.linear.flexible import AnyPlant
from tvclin.plots.curves import Column, Curves
from tvclin.plots.loop_samples import (
    ON_AXIS,
    LoopSamples,
    corner_frequencies,
    decisive_frequencies,
    margin_marks,
    mode_frequency,
    mode_marks,
    sampled,
    title,
    unstable_poles,
)
from tvclin.plots.style import (
    COLOURS,
    INK,
    WARM,
    Look,
    Mark,
    Style,
    broken,
    control_plot,
    draw,
    draw_marks,
    fine_grid,
    literal,
    new_axes,
    numbered,
    write_numbers,
)

if TYPE_CHECKING:
    import control
    from control import ControlPlot
    from matplotlib.axes import Axes

_CURVE: dict[str, Any] = {"color": INK, "lw": 1.8}
_LINE: dict[str, Any] = {"color": "0.35", "lw": 1.0, "ls": (0, (4, 2)), "zorder": 1.5}
_GRID_DECIBELS = np.array([-12.0, -6.0, -3.0, 0.0, 3.0, 6.0, 12.0])
_CONTOURS = "|T| = " + ", ".join(f"{size:g}" for size in _GRID_DECIBELS[::-1]) + " dB"
_MAX_DECIBELS = 60.0
"""Largest magnitude of the Bode diagram [dB]: poles on the imaginary axis have infinite peaks."""
_BELOW_MODES, _ABOVE_MODES = 40.0, 15.0
"""Range below the smallest peak of a mode and above the largest magnitude [dB]."""
_ENTRY_WIDTH = 42
"""Width of an entry of the legend of a Nichols chart, which has two columns [characters]."""
_SIDES = ("aero_margin_dB", "gain_increase_dB", "phase_margin_deg")


def nichols_chart(
    autopilot: Autopilot | Loop,
    plant: AnyPlant | None = None,
    criteria: Criteria = CRITERIA["classic"],
) -> ControlPlot:
    """Draw the Nichols chart of the loop, with its exact delay, and the box of the criteria.

    Each mode of a flexible vehicle is marked at its peak by its name, with its gain or phase
    margin. A sampled loop is drawn up to half its rate.

    Parameters
    ----------
    autopilot : Autopilot or Loop
        One autopilot, or one loop, whose modes have no names.
    plant : Plant or FlexiblePlant, optional
        One plant of any model; omitted with a loop.
    criteria : Criteria
        Their aero and gain-increase margins are the half heights of the box around -1, up and
        down, and their phase margin is its half width. Other requirements are not drawn.

    Raises
    ------
    InputError
        For a batch, a loop with a plant, and what `Autopilot.exact_loop` refuses.

    Notes
    -----
    Criteria limit the axes of the box alone: a curve through a corner may satisfy them.
    """
    instance("criteria", criteria, Criteria, 'such as CRITERIA["classic"]')
    samples = sampled("nichols_chart", autopilot, plant)
    axes = new_axes()
    lines = axes.plot(samples.phase, samples.decibels, label="loop", **_CURVE)
    # `at`: phase [deg] and magnitude [dB] at a frequency, the position of its mark
    marks = [*margin_marks(samples, samples.at), *mode_marks(samples, samples.at)]
    box = box_sides(criteria)
    _frame_nichols(axes, samples, marks, box)
    _draw_box(axes, box, criteria.name)
    verdict = ""
    if samples.margins.stable and any(box):
        word = satisfaction(criteria.are_satisfied(samples.judged))
        verdict = f", criteria {criteria.name} {word}"
    axes.set(
        title=title("Nichols chart of the loop", samples, verdict),
        xlabel="phase of L [deg]",
        ylabel="magnitude of L [dB]",
    )
    points = [
        Mark(point, 0.0, shape="X", name="L = -1" if point == -180.0 else "")
        for point in _critical(*axes.get_xlim())
    ]
    lines += draw_marks(axes, [*marks, *points])
    axes.figure.legend(loc="outside lower center", ncols=2)
    write_numbers((axes, marks))
    return control_plot(lines, axes, samples.curves("nichols"))


def box_sides(criteria: Criteria) -> tuple[float, float, float]:
    """Return the heights of the criteria box above and below -1 [dB], and its half width [deg]."""
    limits = {criterion.margin: criterion.limit for criterion in criteria.limits}
    up, down, half_width = (limits.get(name, 0.0) for name in _SIDES)
    return up, down, half_width


def _draw_box(axes: Axes, box: tuple[float, float, float], name: str) -> None:
    """Draw the region that the criteria forbid, around the critical points, into axes.

    `box`: its extent upwards and downwards [dB], and half of its width [deg]; zero without a
    criterion. `name`: name of the criteria.
    """
    from matplotlib.patches import Rectangle

    up, down, half_width = box
    if not any(box):
        return
    words = f"criteria {name}: +{up:g}/-{down:g} dB, {half_width:g} deg"
    label = literal(broken(words, _ENTRY_WIDTH))
    style: dict[str, Any] = {"ec": WARM, "fc": WARM, "lw": 1.6, "ls": "--", "zorder": 1.2}
    for point in _critical(*axes.get_xlim()):
        entry = label if point == -180.0 else ""
        patch = Rectangle(
            (point - half_width, -down), 2.0 * half_width, up + down, label=entry, **style
        )
        patch.set_facecolor((*patch.get_facecolor()[:3], 0.1))
        axes.add_patch(patch)


def _critical(lowest: float, highest: float) -> list[float]:
    """Return the phases [deg] of L = -1 between two phases: -180 and whole turns from it.

    `lowest`, `highest`: ends of the frame [deg].
    """
    turns = np.arange(np.ceil((lowest + 180.0) / 360.0), np.floor((highest + 180.0) / 360.0) + 1.0)
    return (360.0 * turns - 180.0).tolist()


def _frame_nichols(
    axes: Axes, samples: LoopSamples, marks: list[Mark], box: tuple[float, float, float]
) -> None:
    """Set the limits of the axes of a Nichols chart: around margins, criteria and the loop.

    `samples`: the loop over frequency. `marks`: its margins. `box`: extent of the criteria upwards
    and downwards [dB], and half width [deg]. Levels, grid and contours of |T| are drawn too. The
    frame holds whole boxes, ends at multiples of 30 deg and 3 dB, and shows -540 to 180 deg.
    """
    up, down, half_width = box
    heights = [mark.y for mark in marks if np.isfinite(mark.y)]
    size = samples.decibels
    top = max([up, *heights, min(12.0, float(size.max()))]) + 6.0
    bottom = min([-down, *heights, -12.0]) - 6.0
    visible = samples.phase[(size < top) & (size > bottom)]
    phases = [-180.0 - max(half_width, 30.0), -180.0 + max(half_width, 30.0), *(m.x for m in marks)]
    phases += [float(v) for v in np.clip(visible, -540.0, 180.0)]
    first, last = np.nanmin(phases), np.nanmax(phases)
    for point in _critical(first - half_width, last + half_width):
        first, last = min(first, point - half_width), max(last, point + half_width)
    axes.set_xlim(30.0 * np.floor(first / 30.0 - 0.2), 30.0 * np.ceil(last / 30.0 + 0.2))
    axes.set_ylim(3.0 * np.floor(bottom / 3.0), 3.0 * np.ceil(top / 3.0))
    axes.xaxis.set_major_locator(_degree_locator(axes.get_xlim()))
    _draw_contours(axes)
    axes.axhline(0.0, **_LINE)
    axes.axvline(-180.0, **_LINE)
    fine_grid(axes)


def _draw_contours(axes: Axes) -> None:
    """Draw the contours of |T|, T = L/(1 + L), into each turn of the axes of a Nichols chart.

    On a contour L = T/(1 - T), whose phase [deg] is from -360 to 0, plus whole turns.
    """
    angle = np.radians(np.linspace(-359.75, -0.25, 2000))[:, np.newaxis]
    closed = 10.0 ** (_GRID_DECIBELS / 20.0) * np.exp(1j * angle)
    loop = closed / (1.0 - closed)
    phase, size = np.mod(np.degrees(np.angle(loop)), -360.0), 20.0 * np.log10(np.abs(loop))
    turns = np.array(axes.get_xlim()) / 360.0
    for k in np.arange(np.floor(turns[0]) + 1.0, np.ceil(turns[1]) + 1.0):
        lines = axes.plot(phase + 360.0 * k, size, color="0.55", lw=0.9, ls=":", zorder=0.0)
        if k == 0.0:
            lines[0].set_label(_CONTOURS)


def bode_chart(autopilot: Autopilot | Loop, plant: AnyPlant | None = None) -> ControlPlot:
    """Draw magnitude and phase of the loop, with its exact delay, against frequency.

    A margin at zero frequency is marked on the left edge, and half the rate of a sampled loop by a
    dotted line.

    Parameters
    ----------
    autopilot, plant
        One autopilot and one plant of any model, or one loop alone.
    """
    import matplotlib.pyplot as plt

    samples = sampled("bode_chart", autopilot, plant)
    _, axes = plt.subplots(2, 1, figsize=(8.6, 7.4), layout="constrained", sharex=True)
    drawn = samples.data().plot(
        plot_type="bode",
        ax=axes[:, np.newaxis],
        dB=True,
        deg=True,
        Hz=False,
        wrap_phase=False,
        initial_phase=float(samples.phase[0]),
        grid=False,
        show_legend=False,
        **_CURVE,
    )
    lines = [line for panel in drawn.lines.flat for line in panel]
    edge = _frame_bode(axes, samples)

    def magnitude(omega: float) -> tuple[float, float]:
        """Return the position [rad/s, dB] of a mark at `omega` [rad/s], at the `edge` if below."""
        _, decibels = samples.at(omega)
        return max(omega, edge), decibels

    def phase(omega: float) -> tuple[float, float]:
        """Return the position [rad/s, deg] of a mark at `omega` [rad/s], at the `edge` if below."""
        degrees, _ = samples.at(omega)
        return max(omega, edge), degrees

    upper, lower = margin_marks(samples, magnitude), margin_marks(samples, phase)
    _draw_levels(axes, upper, lower)
    # the third mark is that of the phase margin: its number stands in the lower panel
    in_phase = [*upper[2:3], *lower[2:3]]
    upper += mode_marks(samples, magnitude)
    lower += mode_marks(samples, phase)
    axes[0].figure.suptitle(title("Bode diagram of the loop", samples))
    lines += draw_marks(axes[0], upper)
    handles, labels = axes[0].get_legend_handles_labels()
    axes[0].figure.legend(handles, labels, loc="outside lower center", ncols=2)
    lines += draw_marks(axes[1], lower)
    gains = [numbered(mark, mark not in in_phase) for mark in upper]
    phases = [numbered(mark, mark in in_phase) for mark in lower]
    write_numbers((axes[0], gains), (axes[1], phases))
    return control_plot(lines, axes[:, np.newaxis], samples.curves("bode"))


def _frame_bode(axes: Any, samples: LoopSamples) -> float:
    """Return the left edge [rad/s] after setting the frame: a decade around all corners.

    `axes`: both panels, magnitude and phase. `samples`: the loop over frequency. The right edge is
    nearer where the loop stays below -40 dB; half the rate of a sampled loop is drawn dotted.
    `InputError` for a loop without a gain in the frame.
    """
    decisive = decisive_frequencies(samples.margins)
    modes = [mode_frequency(mode) for mode in samples.modes]
    corners = np.concatenate([decisive[decisive > 0.0], corner_frequencies(samples.loop), modes])
    corners = corners if corners.size else samples.omega
    low_edge, high_edge = 0.1 * corners.min(), 10.0 * corners.max()
    large = samples.omega[samples.decibels > -40.0]
    if large.size:
        marked = np.max([*decisive, *(w for w in modes if np.isfinite(w))], initial=0.0)
        high_edge = min(high_edge, max(float(large.max()), 2.0 * float(marked)))
    highest = float(samples.loop.max_frequency()[0, 0])  # half the sample rate, or infinite
    high_edge = min(high_edge, 1.1 * highest)
    axes[0].set_xlim(low_edge, high_edge)
    for panel in axes:
        if high_edge > highest:
            panel.axvline(highest, color="0.35", lw=1.2, ls=":", zorder=1.5)
    visible = (samples.omega >= low_edge) & (samples.omega <= high_edge)
    if not visible.any():
        raise InputError(
            "autopilot and plant must make a loop with a gain to be drawn; its is none"
        )
    for panel, values, step in ((axes[0], samples.decibels, 5.0), (axes[1], samples.phase, 15.0)):
        low, high = np.min(values[visible]), np.max(values[visible])
        panel.set_ylim(step * np.floor(low / step - 0.3), step * np.ceil(high / step + 0.3))
    low, high = axes[0].get_ylim()
    if modes:  # room for their names; notches and the fall beyond the last mode have no end
        peaks = [decibels for _, decibels in (samples.at(w) for w in modes if np.isfinite(w))]
        low = max(low, float(np.nanmin([0.0, *peaks])) - _BELOW_MODES)
        high += _ABOVE_MODES
    axes[0].set_ylim(min(low, -10.0), np.clip(high, 10.0, _MAX_DECIBELS))
    return float(low_edge)


def _draw_levels(axes: Any, upper: list[Mark], lower: list[Mark]) -> None:
    """Draw labels, grid, the levels 0 dB and -180 deg, and each margin as a line to its level.

    `axes`: both panels, magnitude and phase. `upper`, `lower`: marks of the margins in each of
    them, in the order aero, gain-increase and phase margin. The first two are drawn in magnitude,
    the last in phase, to the nearest phase of L = -1.
    """
    magnitude, phase = axes
    low, high = phase.get_ylim()
    phase.set_ylim(min(low, -195.0), max(high, -165.0))
    phase.yaxis.set_major_locator(_degree_locator(phase.get_ylim()))
    magnitude.set(ylabel="magnitude of L [dB]", xlabel="")
    phase.set(ylabel="phase of L [deg]", xlabel="frequency [rad/s]")
    for panel, level in ((magnitude, 0.0), (phase, -180.0)):
        fine_grid(panel)
        panel.axhline(level, **_LINE)
    for panel, marks in ((magnitude, upper[:2]), (phase, lower[2:3])):
        for mark in marks:
            turns = round((mark.y + 180.0) / 360.0) if np.isfinite(mark.y) else 0
            level = 0.0 if panel is magnitude else 360.0 * turns - 180.0
            panel.plot([mark.x] * 2, [level, mark.y], color=mark.colour, lw=2.2, zorder=3)


def _degree_locator(frame: tuple[float, float]) -> Any:
    """Return the tick locator of an axis of phase, with about ten ticks.

    `frame`: limits of the axis [deg].
    """
    from matplotlib.ticker import MultipleLocator

    span = abs(frame[1] - frame[0])
    return MultipleLocator(
        next(step for step in (15, 30, 45, 90, 180, 360, 1e9) if span < 12 * step)
    )


_ARC = 181
"""Number of points of the contour around a pole on the axis."""


def nyquist_chart(autopilot: Autopilot | Loop, plant: AnyPlant | None = None) -> ControlPlot:
    """Draw the Nyquist curve of the loop, the whole of it and the surroundings of -1.

    The delay is exact. The contour is indented to the right around poles of the loop on the
    imaginary axis; distant parts of the curve are drawn compressed, dash-dotted. The disk is that
    of the disk margin: the curve touches it from outside.

    Parameters
    ----------
    autopilot, plant
        One autopilot and one plant of any model, or one loop alone.
    """
    import matplotlib.pyplot as plt

    samples = sampled("nyquist_chart", autopilot, plant)
    response = _nyquist(samples)
    figure, panels = plt.subplots(1, 2, figsize=(12.0, 6.6), layout="constrained")
    whole, near = panels

    def point(omega: float) -> tuple[float, float]:
        """Return real and imaginary part of L at a frequency `omega` [rad/s]."""
        value = complex(samples.loop.response(omega))
        return value.real, value.imag

    marks = [*margin_marks(samples, point), *mode_marks(samples, point)]
    max_magnitude = _max_magnitude(samples)
    lines: list[Any] = []
    for axes in panels:
        # python-control shrinks the far parts of a response where they are kept: plot a copy
        drawn = deepcopy(response).plot(
            ax=axes,
            max_curve_magnitude=max_magnitude,
            primary_style=["-", "-."],
            mirror_style=["--", ":"],
            start_marker="",
            arrows=2,
            arrow_size=9,
            show_legend=False,
            **_CURVE,
        )
        lines += [line for group in drawn.lines.flat for line in group if line is not None]
        axes.set(xlabel="real part of L [-]", ylabel="imaginary part of L [-]")
        axes.margins(0.08)
        axes.set_aspect("equal", adjustable="datalim" if axes is whole else "box")
    whole.set_title("the whole curve; dashed: negative frequencies", fontsize="medium")
    near.set_title("near -1", fontsize="medium")
    _frame_critical_point(near, samples, marks)
    for axes in panels:
        fine_grid(axes)
        lines += draw_marks(axes, [*marks, Mark(-1.0, 0.0, shape="X", name="L = -1")])
    figure.suptitle(
        literal(f"Nyquist diagram: {_encirclements_text(response, samples)}\n{samples.words}")
    )
    handles, labels = near.get_legend_handles_labels()
    # the first entry is the curve of python-control
    figure.legend(handles[1:], labels[1:], loc="outside lower center", ncols=2)
    distant = [numbered(mark, not mark.inside(near)) for mark in marks]
    write_numbers((whole, distant), (near, marks))
    return control_plot(lines, panels, _nyquist_curves(response, samples))


def _nyquist(samples: LoopSamples) -> control.NyquistResponseData:
    """Return the open loop L along the Nyquist contour, indented to the right of poles on the axis.

    The contour of a sampled loop is in its variable w, the bilinear image of z, at frequencies of
    the s plane. Around a pole it is a half circle of a hundredth of the lowest frequency.
    Encirclements of -1 are counted clockwise: the turns of 1 + L, twice those at positive
    frequencies.
    """
    import control

    loop = samples.loop  # one loop: the only row of the arrays
    axis = np.imag(loop.s_to_w(1j * samples.omega[np.newaxis]))[0]
    poles = loop.form.open_poles()[0].astype(complex)
    rounding = ON_AXIS * np.abs(poles).max()  # a smaller real part counts as none
    on_axis = poles[(np.abs(poles.real) <= rounding) & (poles.imag >= 0.0)]
    corners = np.unique(np.abs(on_axis.imag))
    radius = 1e-2 * float(axis[0])
    arc = radius * np.sin(np.linspace(-0.5 * np.pi, 0.5 * np.pi, _ARC))
    around_corners = (corners[:, np.newaxis] + arc).ravel()
    # along the contour, real and imaginary part in the variable of the loop
    nu = np.unique(np.concatenate([[0.0], around_corners[around_corners > 0.0], axis]))
    distances = np.abs(nu[:, np.newaxis] - corners).min(axis=-1, initial=np.inf)
    contour = np.sqrt(np.maximum(radius**2 - distances**2, 0.0)) + 1j * nu
    values = loop.form.value(contour[np.newaxis])[0]
    omega = np.imag(loop.w_to_s(1j * nu[np.newaxis]))[0]
    clockwise = -np.sum(np.diff(np.unwrap(np.angle(1.0 + values)))) / np.pi
    along = contour.real + 1j * omega
    return control.NyquistResponseData(round(clockwise), along, values, dt=0, sysname="loop")


def _encirclements_text(response: Any, samples: LoopSamples) -> str:
    """Return a sentence on encirclements, unstable open-loop poles and the Nyquist verdict.

    `response`: python-control's Nyquist response of the loop. `samples`: the loop over frequency.
    """
    # python-control counts clockwise
    turns, open_loop = -response.count, unstable_poles(samples.loop)
    direction = "counterclockwise" if turns >= 0 else "clockwise"
    times = plural(abs(turns), f"{direction} encirclement")
    return f"{times} of -1, {plural(open_loop, 'unstable open-loop pole')}: {samples.verdict}"


def _max_magnitude(samples: LoopSamples) -> float:
    """Return the magnitude of the loop up to which a Nyquist curve is drawn to scale.

    `samples`: the loop over frequency, with its margins and modes. The scale is the largest L at
    the crossings of the real axis and at the peaks of modes, at least 2; a curve that stays within
    four times the scale is drawn whole.
    """
    sizes = np.abs(samples.response)
    factors = samples.margins.crossings.gain_factors  # 1/|L| where L is real and negative
    factors = factors[np.isfinite(factors)]
    peaks = [mode.peak for mode in samples.modes if np.isfinite(mode.peak)]
    scale = float(np.max([*(1.0 / factors[factors > 0.0]), *peaks], initial=2.0))
    largest = float(sizes.max())
    return 1.25 * largest if largest < 4.0 * scale else 2.0 * scale


def _frame_critical_point(axes: Axes, samples: LoopSamples, marks: list[Mark]) -> None:
    """Set the frame of axes around -1, with the unit circle and the disk of the disk margin.

    `samples`: the loop with its margins. `marks`: marks of the margins, which the frame holds. A
    disk margin alpha is a disk through the real points -(2 + alpha)/(2 - alpha) and its inverse;
    from alpha = 2 on it is none.
    """
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
    # marks farther left than -4 are in the panel of the whole curve
    distances = [-mark.x for mark in marks if np.isfinite(mark.x) and mark.x > -4.0]
    width = max([2.2, *(1.2 * x for x in distances)])
    axes.set_xlim(-width, 1.2)
    axes.set_ylim(-0.5 * (width + 1.2), 0.5 * (width + 1.2))


def _nyquist_curves(response: Any, samples: LoopSamples) -> Curves:
    """Return the curves of real and imaginary part of the open loop over the frequency.

    `response`: python-control's Nyquist response. `samples`: the loop with its description.
    """
    columns = (
        Column("real part", np.asarray(response.response.real), "-"),
        Column("imaginary part", np.asarray(response.response.imag), "-"),
    )
    omega = np.asarray(response.contour.imag)
    words = f"{samples.words}; {samples.verdict}"
    return Curves("nyquist", words, "frequency [rad/s]", omega, columns)


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
    """Return the curves of the square roots of one-sided spectra per Hz, of angles and rates.

    A spectrum per rad/s times 2 pi is that per Hz. `covariance`: loop in turbulence. `InputError`
    for turbulence of no intensity.
    """
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
