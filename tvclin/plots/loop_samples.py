"""What the figures of a loop are drawn from: its samples, its phase, and its verdict in words."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tvclin.base.errors import InputError, instance
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import CHAINS
from tvclin.control.margins.loop import Loop
from tvclin.control.margins.record import Margins, loop_margins
from tvclin.kernels import polynomials
from tvclin.kernels.loop_grid import frequencies
from tvclin.kernels.stability import stability
from tvclin.linear.plant import Plant
from tvclin.plots.curves import Column, Curves
from tvclin.plots.marks import Mark
from tvclin.plots.style import COLOURS, WARM

if TYPE_CHECKING:
    import control

FloatArray = NDArray[np.float64]

ON_AXIS = 1e-9
"""Poles nearer to the imaginary axis than this part of the largest one are on it."""
_PER_DECADE = 400
VERDICTS = {
    "ok": "stable closed loop",
    "unstable": "unstable closed loop",
    "marginal": "closed loop with a pole on the imaginary axis",
}
AERO, GAIN, PHASE = ("s", COLOURS[0]), ("^", WARM), ("o", COLOURS[4])
"""Marker and colour of the three margins."""


@dataclass(frozen=True, eq=False)
class LoopSamples:
    """One loop with its exact delay, sampled finely enough to be drawn.

    Attributes
    ----------
    loop : Loop
        The loop.
    margins : Margins
        Its margins.
    omega : ndarray
        Frequencies [rad/s], rising, above zero, ``(n,)``; those of the margins are among them.
    response : ndarray
        L(j omega), ``(n,)``.
    phase : ndarray
        Its phase [deg] without jumps, ``(n,)``; where L is nearest to -1 it is within half a
        turn of -180 deg.
    words : str
        What the loop is made of, in one line.
    pade_order : int
        Order of the approximation that stands for the delay in `system`.
    """

    loop: Loop
    margins: Margins
    omega: FloatArray
    response: NDArray[np.complex128]
    phase: FloatArray
    words: str
    pade_order: int

    @property
    def decibels(self) -> FloatArray:
        """Magnitude [dB], ``(n,)``."""
        return 20.0 * np.log10(np.abs(self.response))

    @property
    def verdict(self) -> str:
        """What the closed loop is."""
        return VERDICTS[self.margins.status]

    def at(self, omega: float) -> tuple[float, float]:
        """Return phase [deg], on the branch of the curve, and magnitude [dB] at one frequency."""
        value = complex(self.loop.response(omega))
        near = float(np.interp(omega, self.omega, self.phase))
        phase = float(np.degrees(np.angle(value)))
        return phase + 360.0 * round((near - phase) / 360.0), 20.0 * float(np.log10(abs(value)))

    def data(self) -> "control.FrequencyResponseData":
        """Return the samples as python-control's frequency response."""
        import control

        return control.FrequencyResponseData(
            self.response,
            self.omega,
            name="loop",
            inputs=["deflection_command"],
            outputs=["returned_command"],
        )

    def system(self) -> "control.TransferFunction":
        """Return the loop with the Pade approximation of its delay, as `Autopilot.loop` has it."""
        import control

        above, below = self.loop.numerator, self.loop.denominator
        if self.loop.delay > 0.0:
            powers = self.loop.delay ** np.arange(self.pade_order, -1, -1)
            top, bottom = (powers * p / p[-1] for p in control.pade(1.0, self.pade_order))
            above, below = polynomials.multiply(above, top), polynomials.multiply(below, bottom)
        return control.TransferFunction(np.trim_zeros(above, "f"), below, 0, name="loop")

    def curves(self, name: str) -> Curves:
        """Return magnitude and phase against frequency."""
        columns = (
            Column("magnitude", self.decibels, "dB", "magnitude"),
            Column("phase", self.phase, "deg", "phase"),
        )
        words = f"{self.words}; {self.verdict}"
        return Curves(name, words, "frequency [rad/s]", self.omega, columns)


def sampled(what: str, autopilot: Autopilot, plant: Plant) -> LoopSamples:
    """Return the samples of one loop.

    Parameters
    ----------
    what : str
        Name of the figure, for the refusals.
    autopilot, plant
        As of `nichols_chart`.
    """
    require_one(what, autopilot, plant)
    loop = autopilot.rational_loop(plant)
    margins = loop_margins(loop)
    omega = _frequencies(loop, margins)
    response = loop.response(omega)
    seen = np.isfinite(response) & (response != 0.0)
    omega, response = omega[seen], response[seen]
    phase = np.degrees(np.unwrap(np.angle(response)))
    nearest = phase[np.argmin(np.abs(1.0 + response))]
    phase = phase - 360.0 * np.round((nearest + 180.0) / 360.0)
    return LoopSamples(
        loop, margins, omega, response, phase, loop_words(autopilot, plant), autopilot.pade_order
    )


def require_one(what: str, autopilot: Any, plant: Any, **others: Any) -> None:
    """Raise `InputError` unless there is one autopilot, one plant, and one of all others."""
    instance("autopilot", autopilot, Autopilot, "see design_gains")
    instance("plant", plant, Plant, "see Plant.from_vehicle")
    shapes = {"autopilot": autopilot.batch, "plant": plant.batch}
    shapes |= {name: other.batch for name, other in others.items()}
    if any(shapes.values()):
        shown = ", ".join(f"{name} {shape}" for name, shape in shapes.items() if shape)
        raise InputError(
            f"{what} draws one autopilot around one plant; got batches of shape {shown}"
            " (take one element at a time)"
        )


def loop_words(autopilot: Autopilot, plant: Plant) -> str:
    """Return what a loop is made of, in one line."""
    parts = [f"a0 = {autopilot.attitude_gain:.4g}", f"a1 = {autopilot.rate_gain:.4g} s"]
    if autopilot.alpha_gain:
        parts.append(f"b0 = {autopilot.alpha_gain:.4g}")
    if autopilot.integral_gain:
        parts.append(f"aI = {autopilot.integral_gain:.4g} 1/s")
    filters = sum(len(getattr(autopilot, name)) for name in CHAINS)
    if filters:
        parts.append(f"{filters} filter{'s' * (filters > 1)}")
    if autopilot.actuator is not None:
        parts.append(f"actuator {autopilot.actuator.natural_frequency:.4g} rad/s")
    if autopilot.delay:
        parts.append(f"delay {autopilot.delay:.4g} s")
    return f"model {plant.model}, {', '.join(parts)}"


def title(what: str, samples: LoopSamples, more: str = "") -> str:
    """Return the title of a figure: what it is, the verdict, and what the loop is made of."""
    return f"{what}: {samples.verdict}{more}\n{samples.words}"


def decisive_frequencies(margins: Margins) -> FloatArray:
    """Return the frequencies [rad/s] of aero, gain-increase and phase margin that exist."""
    found = (margins.aero_frequency, margins.gain_increase_frequency, margins.crossover_frequency)
    return np.array([frequency for frequency in found if np.isfinite(frequency)])


def margin_marks(
    samples: LoopSamples, places: Callable[[float], tuple[float, float]]
) -> list[Mark]:
    """Return the marks of the three margins; none for a loop that is not stable.

    Parameters
    ----------
    samples : LoopSamples
        The loop.
    places : callable
        From a frequency [rad/s] to the coordinates of its point in the figure.
    """
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


def corner_frequencies(loop: Loop) -> FloatArray:
    """Return the sizes [rad/s] of the poles of the loop, rising, those at the origin left out."""
    size = np.abs(polynomials.roots(loop.denominator))
    return np.sort(size[size > 1e-9 * size.max()])


def unstable_poles(loop: Loop) -> int:
    """Return how many poles of the loop lie in the right half plane, those on the axis not."""
    poles = polynomials.roots(loop.denominator)
    return int(np.sum(np.real(poles) > ON_AXIS * np.abs(poles).max()))


def _frequencies(loop: Loop, margins: Margins) -> FloatArray:
    one = loop.form
    found = frequencies(one, stability(one))[0]
    found = found[np.isfinite(found)]
    decades = np.log10(found[-1] / found[0])
    even = np.geomspace(found[0], found[-1], int(np.ceil(_PER_DECADE * decades)))
    marked = decisive_frequencies(margins)
    return np.unique(np.concatenate([found, even, marked[marked > 0.0]]))
