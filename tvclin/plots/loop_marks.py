"""What is marked in the figures of a loop: its three margins, and the modes by name."""

from collections.abc import Callable

import numpy as np

from tvclin.control.margins.bands import GAIN as BY_GAIN
from tvclin.control.margins.bands import PHASE as BY_PHASE
from tvclin.control.margins.bands import UNSTABLE, ModeBand
from tvclin.plots.loop_samples import LoopSamples, mode_frequency
from tvclin.plots.marks import Mark
from tvclin.plots.style import COLOURS, WARM

AERO, GAIN, PHASE = ("s", COLOURS[0]), ("^", WARM), ("o", COLOURS[4])
"""Marker and colour of the three margins."""
MODE = ("d", COLOURS[2])
"""Marker and colour of the modes."""

Places = Callable[[float], tuple[float, float]]
"""From a frequency [rad/s] to the coordinates of its point in the figure."""


def margin_marks(samples: LoopSamples, places: Places) -> list[Mark]:
    """Return the marks of the three margins; none for a loop that is not stable."""
    m = samples.margins
    rows = [
        (AERO, m.aero_frequency, "aero margin", f"{m.aero_margin_dB:.1f} dB"),
        (GAIN, m.gain_increase_frequency, "gain-increase margin", f"{m.gain_increase_dB:.1f} dB"),
        (PHASE, m.crossover_frequency, "phase margin", f"{m.phase_margin_deg:.1f} deg"),
    ]
    marks = []
    for (shape, colour), frequency, name, value in rows:
        if not m.stable:
            break
        if np.isfinite(frequency):
            x, y = places(frequency)
            entry = f"{name} {value} at {frequency:.3g} rad/s"
            marks.append(Mark(x, y, value, shape, entry, colour))
        else:
            marks.append(Mark(np.nan, np.nan, "", shape, f"{name} inf", colour))
    return marks


def mode_marks(samples: LoopSamples, places: Places) -> list[Mark]:
    """Return a mark for each mode: its name, and its gain or phase margin if the loop has one."""
    shape, colour = MODE
    marks = []
    for mode in samples.modes:
        frequency = mode_frequency(mode)
        if not np.isfinite(frequency):
            continue
        value = _value(mode) if samples.margins.stable else ""
        text = ", ".join(part for part in (mode.name, value) if part)
        entry = f"{mode.name} at {frequency:.3g} rad/s: {_words(mode, value)}"
        marks.append(Mark(*places(frequency), text, shape, entry, colour))
    return marks


def _value(mode: ModeBand) -> str:
    margins = {
        BY_GAIN: f"{mode.gain_margin_dB:.1f} dB",
        BY_PHASE: f"{mode.phase_margin_deg:.1f} deg",
    }
    return margins.get(mode.stabilised, "")


def _words(mode: ModeBand, value: str) -> str:
    if mode.stabilised == UNSTABLE:
        return "unstable"
    by = "-stabilised" if mode.stabilised in (BY_GAIN, BY_PHASE) else ""
    return ", ".join(part for part in (f"{mode.stabilised}{by}", value) if part)
