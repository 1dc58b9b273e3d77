"""Closed loop over time: step of the command, response to a wind, comparison with trim, a flight.

python-control computes and draws the step (`control.step_response`), but over times from here: its
own would be 202 s for a loop of configuration I that settles in 25 s, in steps nine times as long
as the time constant of the fastest pole. It has no response to a wind of exact pieces.
"""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, instance, limit_angle
from tvclin.base.quantities import WIND_KNOWN
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.wind_response import WindResponse
from tvclin.control.comparison import TrimComparison
from tvclin.control.margins.margins import Margins, loop_margins
from tvclin.flights.closed_loop.fly_along import FlightAlong
from tvclin.linear.flexible import AnyPlant
from tvclin.plots.curves import Column, Curves
from tvclin.plots.loop_samples import ON_AXIS, VERDICTS, loop_words, require_single
from tvclin.plots.style import (
    ANGLES,
    COLOURS,
    INK,
    LINES,
    QUANTITIES,
    WARM,
    Look,
    Mark,
    Style,
    broken,
    called,
    control_plot,
    cycle,
    draw,
    draw_marks,
    fine_grid,
    literal,
    write_numbers,
)
from tvclin.winds.histories import History

if TYPE_CHECKING:
    import control
    from control import ControlPlot


_MIN_POINTS, _MAX_POINTS, _POINTS_PER_PERIOD = 2001, 20_001, 12
"""Smallest and largest number of points, and number in a period of the fastest mode."""
_SETTLING_CONSTANTS, _GROWTH_CONSTANTS = 5.0, 3.0
"""Horizon in time constants of decaying modes, and of an unstable mode."""
_LONG, _SHORT = 60.0, 12.0
"""Longest horizon for slow modes of a stable loop, times the crossover frequency."""
_MIN_MODE_SIZE = 0.02
"""Smallest mode that counts for the horizon, over the largest."""
_TRIM = "trim -B alpha_w,max"
_ORDINATES = {
    "angles": "angles [deg]",
    "deflection": "deflection [deg]",
    "wind": "wind angle of attack [deg]",
}
_STYLES = QUANTITIES | {_TRIM: {"color": INK, "ls": "--", "lw": 1.4}}
_STEP = {name: _STYLES[name] for name in ("attitude", "deflection")}
_COMPARISON_POINTS, _SPAN_OVER_DURATION = 601, 1.6
"""Points of a comparison with trim, and its time span over the duration of the wind."""
_AUTOPILOT, _IDEAL = "autopilot", "ideal trim"
_COMPARED: dict[str, Style] = {
    _AUTOPILOT: {"color": WARM, "ls": "-", "lw": 2.2},
    _IDEAL: {"color": INK, "ls": "--", "lw": 1.6},
    "boundary K = 1": {"color": COLOURS[0], "ls": LINES[3], "lw": 1.4},
    "boundary K = 0.5": {"color": COLOURS[1], "ls": "-.", "lw": 1.4},
    "boundary K = 0": {"color": COLOURS[2], "ls": (0, (3, 2)), "lw": 1.4},
    WIND_KNOWN: {"color": COLOURS[4], "ls": ":", "lw": 2.0},
    **QUANTITIES,
}
_LEVEL: dict[str, Any] = {"color": "0.35", "lw": 1.0, "ls": (0, (4, 2)), "zorder": 1.5}


def step_chart(autopilot: Autopilot, plant: AnyPlant) -> "ControlPlot":
    """Draw attitude and deflection after a step of the attitude command.

    The loop is linear: deg per deg are rad per rad. A delay is its Pade approximation, as in
    `Autopilot.close`. The horizon is the time in which the closed-loop modes die down, but very
    slow ones are not followed to their end; what is approached is marked on the right edge.

    Parameters
    ----------
    autopilot, plant
        One autopilot, not sampled, and one plant, rigid or flexible.
    """
    import control
    import matplotlib.pyplot as plt

    require_single("step_chart", autopilot, plant)
    margins = loop_margins(autopilot.exact_loop(plant))
    status, words = margins.status, loop_words(autopilot, plant)
    closed = autopilot.close(plant)[list(_STEP), "attitude_command"]  # attitude and deflection
    horizon = _rounded(_horizon(closed, _LONG / margins.crossover_frequency))
    with np.errstate(over="ignore", invalid="ignore"):
        response = control.step_response(closed, np.linspace(0.0, horizon, _points(plant, horizon)))
    if not np.all(np.isfinite(response.outputs)):
        raise InputError(
            "autopilot and plant must have a step response that can be drawn; this one grows beyond"
            " all numbers"
        )
    figure, panels = plt.subplots(2, 1, figsize=(8.6, 7.2), layout="constrained", sharex=True)
    drawn = response.plot(
        ax=panels[:, np.newaxis], plot_inputs=False, show_legend=False, title="", lw=2.0
    )
    lines = [line for panel in drawn.lines.flat for line in panel]
    figure.suptitle(literal(f"Step of the attitude command: {VERDICTS[status]}\n{broken(words)}"))
    rows = np.reshape(np.asarray(response.outputs, dtype=float), (len(_STEP), -1))
    columns = tuple(
        Column(name, row, "deg/deg", panel=name) for name, row in zip(_STEP, rows, strict=True)
    )
    words = f"{words}; {VERDICTS[status]}"
    curves = Curves("step", words, "time [s]", np.asarray(response.time), columns)
    # final values of attitude and deflection; an unstable loop has none
    final = np.real(closed.dcgain()).ravel() if status == "ok" else np.full(2, np.nan)
    written = []
    for axes, (name, style), end in zip(panels, _STEP.items(), final, strict=True):
        marks = _step_marks(curves, name, float(end))
        axes.get_lines()[0].set(color=style["color"], ls=style["ls"])
        if np.isfinite(end):
            axes.axhline(end, **_LEVEL)
        axes.set(ylabel=f"{name} [deg per deg]", xlabel="", xlim=(0.0, horizon))
        fine_grid(axes)
        lines += draw_marks(axes, marks)
        written.append((axes, marks))
    panels[1].set_xlabel("time [s]")
    write_numbers(*written)
    return control_plot(lines, panels[:, np.newaxis], curves)


def _step_marks(curves: Curves, name: str, end: float) -> list[Mark]:
    """Return the marks of the peak and, for a stable loop, of the final value of a curve.

    `curves`: step response. `name`: output of the curve, and heading of its panel. `end`: final
    value, NaN for an unstable loop; zero where it is rounding of the peak. A peak at the last time
    is not marked.
    """
    times, values = curves.abscissa, curves.column(label=name, panel=name)
    top = int(np.argmax(np.abs(values)))
    end = 0.0 if abs(end) < ON_AXIS * abs(values[top]) else end
    if np.isnan(end):
        return [Mark(times[top], values[top], f"{values[top]:.3g}", colour=WARM)]
    marks = [Mark(times[-1], end, f"in the end {end:.3g}", shape="s")]
    if top < times.size - 1:
        words = f"peak {values[top]:.3g} at {times[top]:.3g} s"
        marks.append(Mark(times[top], values[top], words))
    return marks


def wind_chart(autopilot: Autopilot, plant: AnyPlant, wind: History) -> "ControlPlot":
    """Draw the response of the closed loop to a wind, and the deflection of trim.

    Parameters
    ----------
    autopilot, plant
        One autopilot, not sampled, and one plant, rigid or flexible.
    wind : History
        One wind angle of attack [rad].

    Notes
    -----
    The response is exact, with the Pade approximation of a delay; see `Autopilot.wind_response`.
    The horizon is the end of the wind plus a settling time.
    """
    instance("wind", wind, History, "such as TriangularWind")
    require_single("wind_chart", autopilot, plant, wind=wind)
    margins = loop_margins(autopilot.exact_loop(plant))
    answer, status = autopilot.wind_response(plant, wind), margins.status
    start, stop = _wind_horizon(autopilot, plant, wind, margins)
    count = _points(plant, stop - start)
    times, peak = _times(start, stop, wind, count), None
    if status == "ok":
        value, when = answer.peak("deflection")
        peak = Mark(when, float(np.degrees(value)), colour=WARM)
        # up to beyond the peak, which is one of the times
        times = np.union1d(_times(start, max(stop, 1.1 * when), wind, count), when)
    words = loop_words(autopilot, plant)
    curves = _wind_curves(answer, plant, wind, times, f"{words}; {VERDICTS[status]}")
    title = f"Autopilot in a wind: {VERDICTS[status]}\n{words}"
    plot = draw(curves, Look(title, _ORDINATES, _STYLES, across=1))
    if peak is not None:
        has_coefficients = plant.coefficients_known
        trim = float(curves.column(_TRIM, "deflection")[0]) if has_coefficients else 0.0
        trim_ratio = f", {abs(peak.y / trim):.2f} x trim" if trim else ""
        marks = [replace(peak, text=f"peak {peak.y:.3g} deg at {peak.x:.3g} s{trim_ratio}")]
        panel = plot.axes[list(curves.panels).index("deflection"), 0]
        draw_marks(panel, marks)
        write_numbers((panel, marks))
    return plot


def _wind_curves(
    answer: WindResponse, plant: AnyPlant, wind: History, times: FloatArray, words: str
) -> Curves:
    """Return the curves [deg] of a response to a wind, with the deflection of trim.

    Trim is -B times the peak of the wind, B being trim deflection per angle of attack; it is
    omitted where the plant has no coefficients.

    `answer`: response to the wind. `plant`: plant with its coefficients. `times`: [s], ``(n,)``.
    `words`: description of the loop.
    """
    rows = dict(zip(answer.labels, np.degrees(answer(times)), strict=True))
    peak = float(np.degrees(wind.peak))
    trim = []
    if plant.coefficients_known:
        angle = np.full(times.size, -float(plant.coefficients.B) * peak)
        trim = [Column(_TRIM, angle, "deg", "deflection")]
    angles = [name for name in ANGLES if name in rows]
    columns = [
        *(Column(name, rows[name], "deg", "angles") for name in angles),
        Column("deflection", rows["deflection"], "deg", "deflection"),
        *trim,
        Column("wind", np.degrees(wind(times)), "deg", "wind"),
    ]
    words = f"{words}; wind of {peak:.6g} deg"
    return Curves("autopilot-in-wind", words, "time [s]", times, tuple(columns))


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
    instance("comparison", comparison, TrimComparison, "see compare_with_trim")
    c = comparison
    if not c.margins.stable:
        raise InputError(f"there is nothing to compare: {c.margins.reason}")
    start, end = float(c.wind.onset), float(c.wind.end)
    stop = start + _SPAN_OVER_DURATION * (end - start)
    times = _times(start, stop, c.wind, _COMPARISON_POINTS)
    # without samples, as the peaks of the comparison
    answer = c.autopilot.continuous.wind_response(c.plant, c.wind)
    rows = dict(zip(answer.labels, np.degrees(answer(times)), strict=True))
    wind, B = np.degrees(c.wind(times)), float(c.plant.coefficients.B)  # trim is -B times the wind
    sign = -float(np.sign(B * c.wind.peak))  # that of trim; limits are sizes [rad]
    levels = {f"boundary K = {K:g}": limit for K, limit in c.boundaries.items()}
    levels[WIND_KNOWN] = c.minimum
    columns = [
        Column(_AUTOPILOT, rows.pop("deflection"), "deg", "deflection"),
        Column(_IDEAL, -B * wind, "deg", "deflection"),
        *(
            Column(name, np.full(times.size, sign * np.degrees(limit)), "deg", "deflection")
            for name, limit in levels.items()
            if np.isfinite(limit)
        ),
        *(Column(name, row, "deg", "angles") for name, row in rows.items() if name in ANGLES),
        Column("wind", wind, "deg", "angles"),
    ]
    peak = float(np.degrees(c.wind.peak))
    words = (
        f"{c.plant.model}, wind of {peak:.4g} deg and {end - start:.4g} s; peak deflection"
        f" {np.degrees(c.peak_deflection):.4g} deg, {c.ratio_to_trim:.3g} times trim"
    )
    name = c.plant.name
    curves = Curves("comparison-with-trim", words, "time [s]", times, tuple(columns))
    look = Look(called(name, f"Autopilot beside trim\n{words}"), _ORDINATES, _COMPARED, across=1)
    return draw(curves, look)


def _points(plant: AnyPlant, length: float) -> int:
    """Return the number of points that resolve the fastest mode of a plant over a time.

    `length`: that time [s].
    """
    turns = float(np.abs(plant.poles).max()) * length / (2.0 * np.pi)
    return int(np.clip(_POINTS_PER_PERIOD * turns, _MIN_POINTS, _MAX_POINTS))


def _times(start: float, stop: float, wind: History, count: int) -> FloatArray:
    """Return times [s] with both sides of every breakpoint of a wind, else equidistant, ``(n,)``.

    `start`, `stop`: first and last time [s]. `count`: number of equidistant times.
    """
    sides = np.concatenate([np.nextafter(wind.knots, -np.inf), wind.knots])
    sides = sides[(sides >= start) & (sides <= stop)]
    return np.unique(np.concatenate([np.linspace(start, stop, count), sides]))


def _wind_horizon(
    autopilot: Autopilot, plant: AnyPlant, wind: History, margins: Margins
) -> tuple[float, float]:
    """Return start and end [s] of a figure: of the wind and a settling time, or of the growth.

    `autopilot`, `plant`: the loop, with its `margins`, which say whether it is stable. A wind that
    never ends or begins counts to its last breakpoint, and from zero. The settling time is at most
    half the wind, or `_SHORT` over the crossover frequency.
    """
    last = float(wind.end) if np.isfinite(wind.end) else float(wind.knots[-1])
    first = min(0.0, float(wind.onset) if np.isfinite(wind.onset) else 0.0)
    system = autopilot.close(plant)[list(_STEP), "wind"]  # from wind to attitude and deflection
    if margins.status == "unstable":
        return first, first + _rounded(_horizon(system, np.inf))
    longest = max(0.5 * (last - first), _SHORT / margins.crossover_frequency)
    return first, first + _rounded(last - first + _horizon(system, longest))


_OUTPUTS = {
    "wind": ("wind", "angles"),
    "angle_of_attack": ("angle of attack", "angles"),
    "attitude": ("attitude", "attitude"),
    "deflection": ("deflection", "deflection"),
    "deflection_rate": ("deflection rate", "deflection rate"),
    "drift": ("drift", "drift"),
}
"""Outputs of a flight with their curve and their panel."""
_MODES = "modes and tanks"
_MODE_COLOURS = tuple(colour for colour in COLOURS if colour not in (WARM, COLOURS[1]))
_LIMITS = ("deflection limit", "deflection limit, negative")


def flight_along_chart(flown: FlightAlong, limit: float, name: str = "") -> "ControlPlot":
    """Draw the outputs of a flight of a loop over the flight time.

    Panels of angles of attack, attitude, deflection with its limit, deflection rate, drift, and
    displacements of modes and tanks, each over its largest.

    Parameters
    ----------
    flown : FlightAlong
        Flight, see `fly_along`.
    limit : float
        Deflection limit [rad], positive.
    name : str
        Name of the vehicle and the wind.
    """
    instance("flown", flown, FlightAlong, "see fly_along")
    limit_deg = np.degrees(limit_angle(limit, "limit"))
    columns: list[Column] = []
    ordinates: dict[str, str] = {}
    styles: dict[str, Style] = {curve: {"color": INK, "lw": 1.5} for curve, _ in _OUTPUTS.values()}
    styles["wind"] = {"color": COLOURS[1], "lw": 1.2, "ls": "--"}
    for key, (curve, panel) in _OUTPUTS.items():
        if key not in flown.outputs:
            continue
        values, unit = flown.outputs[key], flown.units[key]
        if unit.startswith("rad"):
            values, unit = np.degrees(values), unit.replace("rad", "deg")
        columns.append(Column(curve, values, unit, panel))
        ordinates[panel] = f"{panel} [{unit}]"
    for curve, end in zip(_LIMITS, (limit_deg, -limit_deg), strict=True):
        columns.append(Column(curve, np.full(flown.times.size, end), "deg", "deflection"))
        styles[curve] = {"color": WARM, "lw": 1.2, "ls": "--"}
    for mode, colour in zip(flown.mode_names, cycle(_MODE_COLOURS), strict=False):
        values = flown.outputs[mode]
        size = float(np.abs(values).max()) or 1.0
        columns.append(Column(mode, values / size, "-", _MODES))
        ordinates[_MODES] = "displacement over its largest"
        styles[mode] = {"color": colour, "lw": 1.0}
    words = "linear loop along the flight"
    curves = Curves("fly", words, "flight time [s]", flown.times, tuple(columns))
    return draw(curves, Look(called(name, words), ordinates, styles))


def _horizon(system: "control.StateSpace", longest: float) -> float:
    """Return the time [s] in which all relevant modes decay, or one of them grows.

    `system`: closed loop with the outputs and the input of the figure. `longest`: longest time [s]
    for slow modes; infinite without limit. A mode is relevant by its largest residue over its pole,
    the size of its part in a step response. The time is 5 time constants of the slowest decaying
    mode; of an unstable mode 3, or else of an undamped oscillation `_SHORT` over its frequency.
    """
    poles, vectors = np.linalg.eig(system.A)
    scale = float(np.abs(poles).max()) or 1.0
    excited = np.linalg.pinv(vectors) @ system.B  # left eigenvectors times B
    sizes = np.abs(system.C @ vectors).max(axis=0) * np.abs(excited).max(axis=1)
    sizes = sizes / np.maximum(np.abs(poles), ON_AXIS * scale)  # a pole at zero is finite
    poles = poles[sizes >= _MIN_MODE_SIZE * sizes.max()]
    falling, growing = poles.real < -ON_AXIS * scale, poles.real > ON_AXIS * scale
    time = _SETTLING_CONSTANTS / -float(poles.real[falling].max()) if falling.any() else np.inf
    oscillating = np.abs(poles[~falling & (poles.imag != 0.0)].imag)
    if growing.any():  # slow growth is not followed beyond ten times what decays
        time = min(_GROWTH_CONSTANTS / float(poles.real.max()), 10.0 * time)
    elif oscillating.size:
        time = _SHORT / float(oscillating.min())
    return float(np.fmin(time if np.isfinite(time) else _SHORT / scale, longest))


def _rounded(time: float) -> float:
    """Return the time [s], rounded up to two digits."""
    unit = 10.0 ** (np.floor(np.log10(time)) - 1.0)
    return float(np.ceil(time / unit - 1e-9) * unit)  # 1e-9: a time of two digits stays
