"""What is marked in the figures of a loop: its three margins, and the modes by name."""

from collections.abc import Callable

import numpy as np

from tvclin.base.lines import significant, text
from tvclin.control.margins.bands import GAIN as BY_GAIN
from tvclin.control.margins.bands import PHASE as BY_PHASE
from tvclin.control.margins.bands import UNSTABLE, ModeBand
from tvclin.control.margins.margins import margin
from tvclin.plots.loop_samples import LoopSamples, mode_frequency
from tvclin.plots.style import COLOURS, WARM, Mark

AERO, GAIN, PHASE = ("s", COLOURS[0]), ("^", WARM), ("o", COLOURS[4])
"""Marker and colour of the three margins."""
MODE = ("d", COLOURS[2])
"""Marker and colour of the modes."""

Places = Callable[[float], tuple[float, float]]
"""From a frequency [rad/s] to the coordinates of its point in the figure."""


def margin_marks(samples: LoopSamples, places: Places) -> list[Mark]:
    """Return the marks of the three margins; none for a loop that is not stable."""
    if not samples.margins.stable:
        return []
    marks = []
    styles = (AERO, GAIN, PHASE)
    for (shape, colour), row in zip(styles, samples.margins.rows(), strict=False):
        value = text(margin("", row.value, row.unit))
        if np.isfinite(row.frequency):
            entry = f"{row.label} {value} at {_at(row.frequency)}"
            marks.append(Mark(*places(row.frequency), value, shape, entry, colour))
        else:
            marks.append(Mark(np.nan, np.nan, "", shape, f"{row.label} {value}", colour))
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
        words = ", ".join(part for part in (mode.name, value) if part)
        entry = f"{mode.name} at {_at(frequency)}: {_words(mode, value)}"
        marks.append(Mark(*places(frequency), words, shape, entry, colour))
    return marks


def _at(frequency: float) -> str:
    return text(significant("", frequency, unit="rad/s"))


def _value(mode: ModeBand) -> str:
    margins = {BY_GAIN: (mode.gain_margin_dB, "dB"), BY_PHASE: (mode.phase_margin_deg, "deg")}
    held = margins.get(mode.stabilised)
    return "" if held is None else text(margin("", *held))


def _words(mode: ModeBand, value: str) -> str:
    if mode.stabilised == UNSTABLE:
        return "unstable"
    by = "-stabilised" if mode.stabilised in (BY_GAIN, BY_PHASE) else ""
    return ", ".join(part for part in (f"{mode.stabilised}{by}", value) if part)
