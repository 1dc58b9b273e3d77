"""Samples of a loop for its figures: frequencies, phase, verdict in words, and marked margins.

The delay is exact, which no system of python-control can hold; `LoopSamples.data` are these samples
as its frequency response. Its own frequencies are 0.008 of a decade apart for a loop with bending,
whose modes with a damping of 0.005 are 0.004 of a decade wide: their peaks are up to 6 percent low.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.arrays import AnyArray, ComplexArray, FloatArray
from tvclin.base.errors import InputError, instance
from tvclin.base.lines import plural, significant, text
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import CHAINS
from tvclin.control.autopilot.system_autopilot import SystemAutopilot
from tvclin.control.margins.bands import GAIN as BY_GAIN
from tvclin.control.margins.bands import PHASE as BY_PHASE
from tvclin.control.margins.bands import UNSTABLE, BandMargins, ModeBand, band_margins
from tvclin.control.margins.loop import Loop
from tvclin.control.margins.margins import Margins, loop_margins, margin
from tvclin.linear.flexible import AnyPlant, check_plant, named_modes
from tvclin.numerics.loop_margins import grid_frequencies, stability
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import COLOURS, WARM, Mark, broken, literal

if TYPE_CHECKING:
    import control


ON_AXIS = 1e-9
"""Distance from the imaginary axis at which a pole counts as on it, over the largest pole."""
_PER_DECADE = 400
"""Number of frequencies in a decade."""
VERDICTS = {
    "ok": "stable closed loop",
    "unstable": "unstable closed loop",
    "marginal": "closed loop with a pole on the imaginary axis",
}
_LIGHT_DAMPING = 0.2
"""Largest damping ratio of roots with further frequencies around them."""
_OFFSETS = np.tan(np.radians(np.arange(-88.0, 89.0, 2.0)))
"""Distances of these frequencies, in half-widths of the root: its term turns by 4 degrees each."""
_PADE_ORDER = 4
"""Order of the Pade approximation for a loop without autopilot."""


@dataclass(frozen=True, eq=False)
class LoopSamples:
    """Frequency response of one loop with its exact delay, dense enough for figures.

    `bands`: margins by band, if the vehicle has modes. `airframe`: poles of the rigid vehicle
    [1/s], if known. `omega`: rising positive frequencies [rad/s], ``(n,)``, including the margins'
    frequencies. `response`: L, ``(n,)``. `phase`: continuous phase [deg], ``(n,)``, within half a
    turn of -180 deg where L is nearest to -1. `words`: description of the loop, in one line.
    `pade_order`: order of the delay's approximation in a root locus.
    """

    loop: Loop
    margins: Margins
    bands: BandMargins | None
    airframe: AnyArray
    omega: FloatArray
    response: ComplexArray
    phase: FloatArray
    words: str
    pade_order: int

    @property
    def decibels(self) -> FloatArray:
        """Magnitude of L [dB] at the n frequencies, ``(n,)``."""
        return 20.0 * np.log10(np.abs(self.response))

    @property
    def judged(self) -> Margins | BandMargins:
        """Margins that criteria judge: by band if the vehicle has modes."""
        return self.margins if self.bands is None else self.bands

    @property
    def modes(self) -> tuple[ModeBand, ...]:
        """Bands of the bending and slosh modes; empty without."""
        return () if self.bands is None else self.bands.modes

    @property
    def verdict(self) -> str:
        """Verdict on the closed loop in words."""
        return VERDICTS[self.margins.status]

    def at(self, omega: float) -> tuple[float, float]:
        """Return phase [deg], on the branch of the curve, and magnitude [dB] at omega [rad/s]."""
        value = complex(self.loop.response(omega))
        interpolated = float(np.interp(omega, self.omega, self.phase))
        phase = float(np.degrees(np.angle(value)))
        phase += 360.0 * round((interpolated - phase) / 360.0)
        return phase, 20.0 * float(np.log10(abs(value)))

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

    def curves(self, name: str) -> Curves:
        """Return the curves of magnitude [dB] and phase [deg] over frequency.

        `name`: name of the figure.
        """
        columns = (
            Column("magnitude", self.decibels, "dB", "magnitude"),
            Column("phase", self.phase, "deg", "phase"),
        )
        words = f"{self.words}; {self.verdict}"
        return Curves(name, words, "frequency [rad/s]", self.omega, columns)


def sampled(figure: str, autopilot: Autopilot | Loop, plant: AnyPlant | None) -> LoopSamples:
    """Return the samples of one loop.

    `figure`: name of the figure, for messages. `autopilot`, `plant`: an autopilot and its plant, or
    a loop alone, whose vehicle's poles and modes are not known. A plant with modes has margins by
    band: of its rigid part and of each mode. Frequencies at which L is infinite or zero are left
    out. The phase is unwrapped, and whole turns are taken off so that it is within half a turn of
    -180 deg where L is nearest to -1. `InputError` for a batch, and for a loop with a plant.
    """
    bands = None
    if isinstance(autopilot, Loop):
        if plant is not None:
            raise InputError(
                f"plant must be left out: {figure} was given a Loop, which has its own"
            )
        if autopilot.batch:
            raise InputError(
                f"{figure} draws one loop; got a batch of shape {autopilot.batch} (see Loop.take)"
            )
        delay = f", delay {float(autopilot.delay):.4g} s" if autopilot.delay > 0.0 else ""
        loop, words = autopilot, f"loop of order {autopilot.poles.shape[-1]}{delay}"
        airframe, order = np.zeros(0), _PADE_ORDER  # no poles of a vehicle are known
    else:
        instance("autopilot", autopilot, Autopilot, "see design_gains, or a Loop")
        require_single(figure, autopilot, plant)
        assert plant is not None
        loop, words = autopilot.exact_loop(plant), loop_words(autopilot, plant)
        if not plant.is_rigid:
            bands = band_margins(loop, *named_modes(plant))
        airframe, order = np.asarray(plant.rigid.poles), autopilot.pade_order
    margins = loop_margins(loop) if bands is None else bands.margins
    omega = _frequencies(loop, margins, () if bands is None else bands.modes)
    response = loop.response(omega)
    drawable = np.isfinite(response) & (response != 0.0)
    omega, response = omega[drawable], response[drawable]
    phase = np.degrees(np.unwrap(np.angle(response)))
    nearest = phase[np.argmin(np.abs(1.0 + response))]
    phase = phase - 360.0 * np.round((nearest + 180.0) / 360.0)
    return LoopSamples(loop, margins, bands, airframe, omega, response, phase, words, order)


def require_single(figure: str, autopilot: Any, plant: Any, **others: Any) -> None:
    """Raise `InputError` unless autopilot and plant are of their types, and all are single.

    `figure`: name of the figure, for the message. `others`: by name, such as a wind. What is single
    has the empty batch shape.
    """
    instance("autopilot", autopilot, Autopilot, "see design_gains")
    check_plant(plant)
    shapes = {"autopilot": autopilot.batch, "plant": plant.batch}
    shapes |= {name: value.batch for name, value in others.items()}
    if any(shapes.values()):
        shown = ", ".join(f"{name} {shape}" for name, shape in shapes.items() if shape)
        raise InputError(
            f"{figure} draws one autopilot around one plant; got batches of shape {shown}"
            " (take one element at a time)"
        )


def loop_words(autopilot: Autopilot, plant: AnyPlant) -> str:
    """Return the description of the loop of an autopilot around a plant, in one line.

    It has gains, number of filters, actuator, delay and sample rate, as far as there are any.
    """
    if isinstance(autopilot, SystemAutopilot):
        return f"{plant.name or plant.model}, {autopilot.description}"
    terms = [autopilot.gains_text]
    filters = sum(len(getattr(autopilot, name)) for name in CHAINS)  # of attitude, rate and sum
    if filters:
        terms.append(plural(filters, "filter"))
    if autopilot.actuator is not None:
        terms.append(f"actuator {autopilot.actuator.natural_frequency:.4g} rad/s")
    if autopilot.delay:
        terms.append(f"delay {autopilot.delay:.4g} s")
    if autopilot.sample_rate is not None:
        terms.append(f"sampled at {autopilot.sample_rate:.4g} Hz")
    name = plant.name
    return f"{name and name + ', '}model {plant.model}, {', '.join(terms)}"


def title(name: str, samples: LoopSamples, more: str = "") -> str:
    """Return the title of a figure: its name, the verdict, and the description of the loop.

    `samples`: the loop. `more`: words after the verdict.
    """
    return literal(broken(f"{name}: {samples.verdict}{more}\n{samples.words}"))


def decisive_frequencies(margins: Margins) -> FloatArray:
    """Return the frequencies [rad/s] of the gain margins down and up and the phase margin, if any.

    The gain margin down, by which the gain may fall, is named aero margin.
    """
    gains = margins.aero_frequency, margins.gain_increase_frequency
    frequencies = np.array([*gains, margins.crossover_frequency])
    return frequencies[np.isfinite(frequencies)]


def mode_frequency(mode: ModeBand) -> float:
    """Return the frequency of a mode's peak [rad/s]; else of its alias or pole.

    The alias is the frequency at which a mode above half the sample rate appears. NaN if all are.
    """
    candidates = (mode.peak_frequency, mode.alias, abs(np.imag(mode.pole)))
    return float(next((frequency for frequency in candidates if np.isfinite(frequency)), np.nan))


def corner_frequencies(loop: Loop) -> FloatArray:
    """Return the rising magnitudes [rad/s] of the nonzero poles of the loop, in the s plane.

    Of a sampled loop, whose form has poles in the w plane, they end at half its rate. The loop is a
    single one, the first row of the arrays.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        size = np.abs(loop.w_to_s(loop.form.open_poles().astype(complex))[0])
    size = size[np.isfinite(size)]
    # nonzero: above rounding
    relevant = (size > 1e-9 * size.max(initial=0.0)) & (size <= loop.max_frequency()[0, 0])
    return np.sort(size[relevant])


def unstable_poles(loop: Loop) -> int:
    """Return the number of poles of one loop in the open right half plane."""
    (poles,) = loop.form.open_poles()
    return int(np.sum(np.real(poles) > ON_AXIS * np.abs(poles).max()))


def _frequencies(loop: Loop, margins: Margins, modes: tuple[ModeBand, ...]) -> FloatArray:
    """Return frequencies [rad/s] that resolve all crossings and modes of a loop, ``(n,)``, rising.

    `margins`, `modes`: margins and modes of the loop, whose frequencies are among them. Others are
    the frequencies of the margins' search, others around lightly damped poles and zeros, `_OFFSETS`
    times the real part from the imaginary part, and `_PER_DECADE` in between; of a sampled loop up
    to half its rate. Its form has roots in the w plane, bilinear image of z.
    """
    roots = (loop.form.open_poles(), loop.form.closed_poles(), loop.form.zeros())
    root = np.concatenate([row[0].astype(complex) for row in roots])
    with np.errstate(invalid="ignore"):
        light = root[(root.imag > 0.0) & (np.abs(root.real) < _LIGHT_DAMPING * root.imag)]
    around = light.imag[:, np.newaxis] + np.abs(light.real)[:, np.newaxis] * _OFFSETS
    highest = loop.max_frequency()[0, 0]  # half the rate of a sampled loop, else infinite
    (omega,) = grid_frequencies(loop.form, stability(loop.form))  # of one loop
    omega = np.concatenate([omega, around.ravel()])
    omega = np.imag(loop.w_to_s(1j * omega[np.newaxis]))[0]
    omega = np.sort(omega[np.isfinite(omega) & (omega > 0.0) & (omega < highest)])
    decades = np.log10(omega[-1] / omega[0])
    even = np.geomspace(omega[0], omega[-1], int(np.ceil(_PER_DECADE * decades)))
    marked = np.array([*decisive_frequencies(margins), *map(mode_frequency, modes)])
    frequencies = np.concatenate([omega, even, marked[marked > 0.0]])
    return np.unique(np.minimum(frequencies, highest))


AERO, GAIN, PHASE = ("s", COLOURS[0]), ("^", WARM), ("o", COLOURS[4])
"""Marker and colour of the three margins."""
MODE = ("d", COLOURS[2])
"""Marker and colour of the modes."""

Position = Callable[[float], tuple[float, float]]
"""Function from a frequency [rad/s] to the coordinates of its point in the figure."""


def margin_marks(samples: LoopSamples, position: Position) -> list[Mark]:
    """Return the marks of the three margins of a loop; an empty list for an unstable one.

    They are aero, gain-increase and phase margin; without a frequency they are in the legend alone.
    `samples`: the loop. `position`: function from a frequency [rad/s] to a place in the figure.
    """
    if not samples.margins.stable:
        return []
    marks = []
    styles = (AERO, GAIN, PHASE)  # the first three rows of margins
    for (shape, colour), row in zip(styles, samples.margins.rows(), strict=False):
        value = text(margin("", row.value, row.unit))
        mark = Mark(np.nan, np.nan, shape=shape, name=f"{row.label} {value}", colour=colour)
        if np.isfinite(row.frequency):
            x, y = position(row.frequency)
            entry = f"{row.label} {value} at {_frequency_text(row.frequency)}"
            mark = replace(mark, x=x, y=y, text=value, name=entry)
        marks.append(mark)
    return marks


def mode_marks(samples: LoopSamples, position: Position) -> list[Mark]:
    """Return a mark for each mode: its name, and its gain or phase margin if the loop has one.

    `samples`: the loop. `position`: function from a frequency [rad/s] to a position in the figure.
    """
    shape, colour = MODE
    marks = []
    for mode in samples.modes:
        frequency, stabilised, value = mode_frequency(mode), mode.stabilised, ""
        if not np.isfinite(frequency):
            continue
        margins = {BY_GAIN: (mode.gain_margin_dB, "dB"), BY_PHASE: (mode.phase_margin_deg, "deg")}
        if samples.margins.stable and stabilised in margins:
            value = text(margin("", *margins[stabilised]))
        kind = f"{stabilised}-stabilised" if stabilised in margins else stabilised
        legend = ["unstable"] if stabilised == UNSTABLE else [kind, value]
        entry = f"{mode.name} at {_frequency_text(frequency)}: {', '.join(filter(None, legend))}"
        words = ", ".join(filter(None, (mode.name, value)))
        marks.append(Mark(*position(frequency), words, shape, name=entry, colour=colour))
    return marks


def _frequency_text(frequency: float) -> str:
    """Return a frequency [rad/s] as text."""
    return text(significant("", frequency, unit="rad/s"))
