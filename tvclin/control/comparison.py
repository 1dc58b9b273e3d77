"""An autopilot in wind, compared with ideal trim: required deflection, worst duration, worst sine.

The report compares every control with ideal trim, which takes |B alpha_w,max|. `compare_with_trim`
does the same for an autopilot in one wind: its largest deflection and angles, beside trim, the
boundary limits and the minimum of appendix C. `worst_duration` searches a family of winds, and
`wind_gain` is the H-infinity norm from wind to deflection. All peaks are those of exact histories,
without limits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tvclin.base import lines
from tvclin.base.arrays import FloatArray, IndexArray
from tvclin.base.cards import Shown, table
from tvclin.base.documents import keyed
from tvclin.base.errors import InputError, callable_for, ending, instance, number, positive
from tvclin.boundary.limit import boundary_limit
from tvclin.boundary.open_loop import with_larger_requirements
from tvclin.boundary.optimum.minimum_peak import optimum_deflection
from tvclin.control.autopilot.autopilot import Autopilot, warn_of_feedback
from tvclin.control.autopilot.wiring import closed_loop, wind_numerator
from tvclin.control.margins.loop import Loop
from tvclin.control.margins.margins import Margins, loop_margins
from tvclin.linear.flexible import AnyPlant, check_plant
from tvclin.linear.plant import Plant
from tvclin.numerics import polynomials
from tvclin.numerics.loop_margins import (
    HIGH_OVER_LARGEST_ROOT,
    LOW_OVER_SMALLEST_ROOT,
    ROOT_OFFSETS,
)
from tvclin.numerics.searches import grid_minimum
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from tvclin.control.autopilot.autopilot import Autopilot


_EVEN = 801
"""Logarithmic frequencies from far below the smallest root to far beyond the largest."""
_ZERO = 1e-12
"""A root that is smaller, over the largest, is one at zero, of which there are no surroundings."""
_BESIDE = np.geomspace(1e-8, 0.3, 24)
"""Around a frequency at which |L| = 1, where a delay may leave little damping; relative."""
_PHASE_STEP, _MOST_STEPS = np.pi / 8.0, 20_000
"""Steps of the delay's phase [rad], and the most there may be."""


def wind_gain(plant: AnyPlant, autopilot: Autopilot) -> float:
    """Return the H-infinity norm from wind to deflection; infinite if the loop is not stable.

    `plant`, `autopilot`: one each.

    It is the highest peak of |G(j omega)|, the delay being exact. The peak is bracketed among
    frequencies around all roots and gain crossovers and refined there, so that what is left is
    rounding, about 1e-12 of the value for well separated roots. Of a flexible plant, which has no
    polynomials, it is the norm of python-control, with the Pade approximation of `Autopilot.close`.
    """
    found = loop_margins(autopilot.exact_loop(plant))
    if not found.stable:
        return float(np.inf)
    if plant.structure is not None:
        import control

        return float(control.system_norm(autopilot.close(plant)["deflection", "wind"], p="inf"))
    loop = autopilot.rational_loop(plant)
    above = wind_numerator(autopilot, plant)

    def lowness(omega: FloatArray) -> FloatArray:
        parts = loop.form.parts(omega.reshape(1, -1))
        returned, below = (part.reshape(omega.shape) for part in parts)
        return -np.abs(polynomials.value(above, 1j * omega) / (below + returned))

    omega = _samples(loop, above, found.crossings.gain_frequencies)
    values = lowness(omega)
    # At infinity nothing returns, and what is left is what passes through at once.
    through = abs(above[0] / loop.denominator[0]) if above.size == loop.denominator.size else 0.0
    k = 1 + np.flatnonzero((values[1:-1] <= values[:-2]) & (values[1:-1] < values[2:]))
    tops = grid_minimum(lowness, omega[k - 1], omega[k + 1])[1] if k.size else values
    return float(max(-values.min(), -np.min(tops), through))


def _samples(loop: Loop, above: FloatArray, crossovers: FloatArray) -> FloatArray:
    """Frequencies from zero on, rising, that leave no resonance between two of them unseen."""
    parts = [loop.denominator + loop.numerator, loop.denominator, np.trim_zeros(above, "f")]
    roots = np.concatenate([polynomials.roots(part) for part in parts if part.size])
    sizes = np.abs(roots)
    counted = sizes[sizes > _ZERO * sizes.max()]
    low, high = LOW_OVER_SMALLEST_ROOT * counted.min(), HIGH_OVER_LARGEST_ROOT * counted.max()
    widths = np.maximum(np.abs(roots.real), _BESIDE[0] * sizes)
    offsets = np.concatenate([-ROOT_OFFSETS[1:], ROOT_OFFSETS])
    every = [
        np.geomspace(low, high, _EVEN),
        (np.abs(roots.imag) + np.multiply.outer(offsets, widths)).ravel(),
        np.multiply.outer(crossovers, np.concatenate([1.0 - _BESIDE, 1.0 + _BESIDE])).ravel(),
    ]
    if loop.delay:
        turns = min(int(high * loop.delay / _PHASE_STEP), _MOST_STEPS)
        every.append(np.arange(1.0, turns + 1.0) * _PHASE_STEP / loop.delay)
    omega = np.concatenate(every)
    return np.unique(np.append(0.0, omega[(omega > 0.0) & (omega <= high)]))


_DURATIONS, _EACH_SWING, _MOST_IN_A_SWING = 41, 16, 2000
"""Durations tried first: over the whole range, in each swing of a mode, and at most for one."""
_FIRST, _ABOUT = 4, 6
"""Each so many of them is tried at first, and so many of these show how tall a swing is."""
_DECAYED = 5.0
"""The swings of a mode are counted until it has fallen to e^-5."""
_NEAR = 1e-6
"""To which a worst duration is sought, over the shortest."""
_FLAT = 1e-9
"""A summit that rises less than this part above its samples is not refined."""


@dataclass(frozen=True)
class WorstDuration(Shown):
    """The wind of a family in which an autopilot needs the largest deflection.

    Attributes
    ----------
    duration : float
        Its duration [s].
    peak_deflection : float
        The deflection [rad].
    at_the_end : bool
        Whether it is the shortest or longest that was asked about: beyond it may be worse.
    """

    duration: float
    peak_deflection: float
    at_the_end: bool

    as_dict = keyed("duration_s peak_deflection_deg at_the_end")


def worst_duration(
    plant: AnyPlant,
    autopilot: Autopilot,
    *,
    peak: float,
    shortest: float,
    longest: float,
    shape: Callable[..., History],
) -> WorstDuration:
    """Return the duration in a family of winds that needs the largest deflection.

    Parameters
    ----------
    plant, autopilot : Plant or FlexiblePlant, Autopilot
        One each, with a stable closed loop.
    peak : float
        Peak [rad] of every wind of the family.
    shortest, longest : float
        The durations [s] in question.
    shape : callable
        Such as `TriangularWind`: called with peak and duration.

    Raises
    ------
    InputError
        For an unstable closed loop, and durations that are not positive and rising.

    Notes
    -----
    Durations are tried over the whole range and in every swing of the loop's modes until they
    have died out (at most 2000 for one mode), and those that may be the worst are refined. A
    family whose winds swing by themselves, faster than the loop, may hide a worse one.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> gains = tv.control.canonical_gains(plant.coefficients)
    >>> worst = tv.control.worst_duration(
    ...     plant, gains, peak=0.1, shortest=1, longest=60, shape=tv.TriangularWind
    ... )
    >>> round(worst.duration, 1), worst.at_the_end
    (12.8, False)
    """
    check_plant(plant)
    instance("autopilot", autopilot, Autopilot, "see design_gains")
    if plant.batch or autopilot.batch:
        raise InputError("worst_duration is for one case; take those of a batch one by one")
    callable_for("shape", shape, "of peak and duration, such as TriangularWind")
    peak = number("peak", peak, unit="rad")
    low = number("shortest", shortest, positive, "s")
    high = number("longest", longest, positive, "s")
    if low >= high:
        raise InputError(f"longest must be above shortest; got {high:.6g} and {low:.6g} s")
    margins = loop_margins(autopilot.exact_loop(plant))
    warn_of_feedback(autopilot, plant)
    if not margins.stable:
        raise InputError(f"no duration is the worst: {margins.reason}")
    answer = autopilot.in_winds(plant)

    def deflection(duration: float) -> float:
        return abs(answer(shape(peak=peak, duration=duration)).peak("deflection")[0])

    return _worst(deflection, _durations(closed_loop(autopilot, plant).A, low, high))


def _worst(deflection: Callable[[float], float], durations: FloatArray) -> WorstDuration:
    """The worst of the durations, or what is worse between them."""
    from scipy.optimize import minimize_scalar  # late: it takes 0.3 s to import

    durations, values = _tried(deflection, durations)
    top = int(np.argmax(values))
    ends = (0, durations.size - 1)
    worst = WorstDuration(float(durations[top]), float(values[top]), top in ends)
    for k in _summits(durations, values):
        edges = durations[k - 1], durations[k + 1]
        near = minimize_scalar(
            lambda d: -deflection(d), bounds=edges, options={"xatol": _NEAR * durations[0]}
        )
        if -near.fun > worst.peak_deflection:
            worst = WorstDuration(float(near.x), float(-near.fun), False)
    return worst


def _tried(
    deflection: Callable[[float], float], durations: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Some of the durations and their values; all of them where a swing may be the tallest.

    That is where the highest of those about rises above the rest by as much as they differ.
    """
    values = np.full(durations.shape, np.nan)

    def fill(places: IndexArray) -> None:
        values[places] = [deflection(duration) for duration in durations[places]]

    first = np.unique(np.append(np.arange(0, durations.size, _FIRST), durations.size - 1))
    fill(first)
    about = np.pad(values[first], _ABOUT // 2 - 1, mode="edge")
    about = np.lib.stride_tricks.sliding_window_view(about, _ABOUT)
    tall = 2.0 * about.max(axis=-1) - about.min(axis=-1) >= values[first].max()
    between = np.searchsorted(first, np.arange(durations.size), side="right") - 1
    fill(np.flatnonzero(np.isnan(values) & np.append(tall, False)[between]))
    known = ~np.isnan(values)
    return durations[known], values[known]


def _summits(x: FloatArray, values: FloatArray) -> list[int]:
    """The middles of the triples whose parabola may have the highest summit of all."""
    steps, slopes = np.diff(x), np.diff(values) / np.diff(x)
    bend = np.diff(slopes) / (x[2:] - x[:-2])
    slope = slopes[:-1] + bend * steps[:-1]
    hollow = np.where(bend < 0.0, bend, np.nan)
    way, gain = -slope / (2.0 * hollow), -(slope**2) / (4.0 * hollow)
    before, after = 0.5 * steps[:-1], 0.5 * steps[1:]
    before[0], after[-1] = steps[0], steps[-1]
    likely = (-before <= way) & (way <= after) & (gain > _FLAT * values.max())
    likely &= values[1:-1] + 2.0 * gain > values.max()
    return (1 + np.flatnonzero(likely)).tolist()


def _durations(A: FloatArray, low: float, high: float) -> FloatArray:
    """Durations [s] between which no swing of the closed loop A is lost, until it has decayed."""
    parts = [np.geomspace(low, high, _DURATIONS)]
    for pole in np.linalg.eigvals(A):
        last = min(_DECAYED / -pole.real, high)
        if pole.imag > 0.0 and last > low:
            count = int((last - low) * pole.imag / (2.0 * np.pi) * _EACH_SWING) + 2
            parts.append(np.linspace(low, last, min(count, _MOST_IN_A_SWING)))
    return np.unique(np.concatenate(parts))


DEAD_BANDS = (1.0, 0.5, 0.0)


@dataclass(frozen=True, eq=False)
class TrimComparison(Shown):
    """What an autopilot does in a wind, beside trim and the least deflections of the theory.

    Angles are sizes [rad]. Where the closed loop is unstable the autopilot's are infinite.

    Attributes
    ----------
    plant, autopilot, wind : Plant or FlexiblePlant, Autopilot, History
        What was compared.
    margins : Margins
        Those of the loop.
    trim_deflection : float
        ``|B alpha_w,max|``, what ideal trim without drift takes.
    peak_deflection : float
        Largest deflection of the autopilot.
    peak_deflection_rate : float
        Its largest rate [rad/s]; infinite where the deflection jumps, which it does in a wind
        that jumps when the angle of attack is fed back without an actuator.
    peak_angle_of_attack, peak_attitude : float
        The largest ones. Ideal trim keeps the attitude, and the wind is its angle of attack.
        The bending moment goes with N times the angle of attack.
    peak_flight_path_angle : float
        The drift; times the speed it is the lateral velocity. NaN on a fixed path.
    boundaries : dict of float to float
        For each dead band K the deflection on the report's boundary; NaN for a wind of two signs.
    minimum : float
        The least peak of any control that knows the wind, appendix C.
    wind_gain : float
        The H-infinity norm from wind to deflection: the deflection per wind angle in the worst
        sinusoidal wind.
    notes : tuple of str
        What the reader should know before believing the numbers; often nothing.
    """

    plant: AnyPlant
    autopilot: Autopilot
    wind: History
    margins: Margins
    trim_deflection: float
    peak_deflection: float
    peak_deflection_rate: float
    peak_angle_of_attack: float
    peak_attitude: float
    peak_flight_path_angle: float
    boundaries: dict[float, float]
    minimum: float
    wind_gain: float
    notes: tuple[str, ...] = ()

    _keys = (
        "model=plant.model status=margins.status peak_deflection_deg trim_deflection_deg"
        " minimum_deg notes"
    )

    def deflections(self, caption: str = "", stop: float | None = None) -> lines.Table:
        """Return the largest deflection beside trim, the boundaries and the minimum.

        Parameters
        ----------
        caption : str
            Stands above the table.
        stop : float, optional
            The least stop [rad] with which the autopilot survives, flown.
        """
        flown = {} if stop is None else {"stop": ("least stop that it survives with, flown", stop)}
        each = {
            "deflection": ("this autopilot, without a stop", self.peak_deflection),
            **flown,
            "trim": ("ideal trim", self.trim_deflection),
            **{f"K{K:g}": (f"boundary, K = {K:g}", one) for K, one in self.boundaries.items()},
            "minimum": ("minimum, wind known", self.minimum),
        }
        trim = self.trim_deflection or np.nan
        rows = tuple(
            (
                (label,),
                lines.least(lines.degrees(f"wind.{key}", value)),
                lines.least(lines.number(f"wind.{key}.part", value / trim)),
            )
            for key, (label, value) in each.items()
        )
        return lines.Table(caption, ("deflection", "[deg]", "over trim"), rows)

    def motions(self) -> list[lines.Row]:
        """Return the largest rate, angles and drift, and the gain of the worst sinusoidal wind."""
        rate = lines.degrees("wind.deflection_rate", self.peak_deflection_rate, unit="deg/s")
        angles = {
            "angle_of_attack": ("largest angle of attack", self.peak_angle_of_attack),
            "attitude": ("largest attitude error", self.peak_attitude),
            "drift": ("largest drift of the path", self.peak_flight_path_angle),
        }
        rows: list[lines.Row] = [("largest rate of deflection", rate)]
        rows += [
            (label, lines.degrees(f"wind.{key}", value, unit="deg"))
            for key, (label, value) in angles.items()
            if np.isfinite(value)
        ]
        gain = lines.number("wind.gain", self.wind_gain)
        return [*rows, ("H-infinity, wind to deflection", gain)]

    def _repr_html_(self) -> str:
        title = f"Autopilot beside trim, {self.plant.model}"
        motions = lines.quantities("In this wind", self.motions())
        notes = [(note,) for note in self.notes]
        return table(self.deflections(title)) + table(motions, notes)

    @property
    def relative(self) -> float:
        """The autopilot's largest deflection over that of trim."""
        return self.peak_deflection / self.trim_deflection if self.trim_deflection else np.nan


def compare_with_trim(plant: AnyPlant, autopilot: Autopilot, wind: History) -> TrimComparison:
    """Return what an autopilot does in a wind, beside trim and the theory's least deflections.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        One plant of any model; trim, boundaries and minimum are those of the rigid one.
    autopilot : Autopilot
        One autopilot. It has no limits here: compare its peak with the one there is. Of one with a
        sample rate the margins are those in steps, and peaks those of the continuous one.
    wind : History
        One wind that ends.

    Raises
    ------
    InputError
        For batches, and for a wind that never ends or is zero.

    Notes
    -----
    Trim, the boundaries and the minimum need no gains; they say how far the autopilot is from
    what the wind itself demands. Pure attitude hold makes the angle of attack larger than the
    wind: in a steady wind by a0/(a0 - B).

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> wind = tv.TriangularWind(peak=np.radians(5), duration=7.5)
    >>> c = tv.compare_with_trim(plant, tv.control.canonical_gains(plant.coefficients), wind)
    >>> round(c.relative, 3), round(c.boundaries[1.0] / c.trim_deflection, 3)
    (1.622, 0.654)
    """
    check_plant(plant)
    instance("autopilot", autopilot, Autopilot, "see design_gains")
    instance("wind", wind, History, "such as TriangularWind")
    if plant.batch or autopilot.batch or wind.batch:
        raise InputError("compare_with_trim is for one case; take those of a batch one by one")
    ending("wind", wind.end)
    margins = loop_margins(autopilot.exact_loop(plant))
    warn_of_feedback(autopilot, plant)
    trim = abs(float(plant.coefficients.B * wind.peak))
    steady = replace(autopilot, sample_rate=None)
    peaks = _peaks(plant, steady, wind) if margins.stable else dict.fromkeys(_PEAKS, np.inf)
    notes = [] if margins.stable else [margins.reason]
    if autopilot.sample_rate is not None:
        notes.append("margins are of the sampled autopilot, all peaks of the continuous one")
    boundaries = _boundaries(plant.rigid, wind, notes)
    least = optimum_deflection(plant.rigid, wind)
    if least.status != "ok":
        notes.append(f"minimum: {least.status}")
    return TrimComparison(
        plant=plant,
        autopilot=autopilot,
        wind=wind,
        margins=margins,
        trim_deflection=trim,
        **peaks,
        boundaries=boundaries,
        minimum=float(least.peak),
        wind_gain=wind_gain(plant, steady),
        notes=tuple(notes),
    )


_PEAKS = (
    "peak_deflection",
    "peak_deflection_rate",
    "peak_angle_of_attack",
    "peak_attitude",
    "peak_flight_path_angle",
)


def _peaks(plant: AnyPlant, autopilot: Autopilot, wind: History) -> dict[str, Any]:
    answer = autopilot.answer(plant, wind)
    sizes = {name: abs(answer.peak(name)[0]) for name in answer.labels}
    return {
        "peak_deflection": sizes["deflection"],
        "peak_deflection_rate": answer.peak_rate("deflection"),
        "peak_angle_of_attack": sizes["angle_of_attack"],
        "peak_attitude": sizes["attitude"],
        "peak_flight_path_angle": sizes.get("flight_path_angle", np.nan),
    }


def _boundaries(plant: Plant, wind: History, notes: list[str]) -> dict[float, float]:
    try:
        bands = np.array(DEAD_BANDS)
        boundary = boundary_limit(plant, wind, bands, "literal")
        found = with_larger_requirements(plant, wind, bands, boundary)
        limits = found.deflection
        notes += _boundary_notes(found.status)
    except InputError as error:
        notes.append(f"no boundary: {error}")
        limits = np.full(len(DEAD_BANDS), np.nan)
    return dict(zip(DEAD_BANDS, np.abs(limits).tolist(), strict=True))


def _boundary_notes(status: NDArray[np.str_]) -> list[str]:
    """What is said of the dead bands whose boundary is no solution, once for each status."""
    said: dict[str, list[str]] = {}
    for K, words in zip(DEAD_BANDS, status.tolist(), strict=True):
        said.setdefault(words, []).append(f"{K:g}")
    return [f"boundary K = {', '.join(K)}: {words}" for words, K in said.items() if words != "ok"]
