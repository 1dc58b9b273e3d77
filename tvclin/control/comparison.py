"""An autopilot in wind, compared with ideal trim: required deflection, worst duration, worst sine.

The report compares every control with ideal trim, which takes |B alpha_w,max|. `compare_with_trim`
does the same for an autopilot in one wind: its largest deflection and angles, beside trim, the
boundary limits and the minimum of appendix C. `worst_duration` searches a family of winds, and
`wind_gain` is the H-infinity norm from wind to deflection. All peaks are those of exact histories,
without limits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from tvclin.base import lines
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown, table
from tvclin.base.errors import InputError, callable_for, ending, instance, number, positive
from tvclin.base.fields import derived, rows, spec
from tvclin.base.quantities import REQUIREMENT, STATIC_TRIM, WIND_KNOWN
from tvclin.boundary.limit import boundary_limit
from tvclin.boundary.open_loop import with_larger_requirements
from tvclin.boundary.optimum.minimum_peak import optimum_deflection
from tvclin.control.autopilot.autopilot import Autopilot, warn_of_feedback
from tvclin.control.autopilot.gains import steady_drift
from tvclin.control.autopilot.wiring import closed_loop, wind_numerator
from tvclin.control.margins.margins import Margins, loop_margins
from tvclin.linear.flexible import AnyPlant, check_plant
from tvclin.linear.plant import Plant
from tvclin.numerics import polynomials
from tvclin.numerics.loop_margins import PEAK_REFINEMENTS, grid_frequencies, stability
from tvclin.numerics.searches import grid_minimum
from tvclin.winds.histories import History

_CROSSOVER_OFFSETS = np.geomspace(1e-8, 0.3, 24)
"""Relative distances of frequencies from each gain crossover, where a delay may leave little
damping."""


def wind_gain(plant: AnyPlant, autopilot: Autopilot) -> float:
    """Return the H-infinity norm from wind to deflection; infinite if the loop is not stable.

    `plant`, `autopilot`: one each. The norm is the highest peak of the frequency response |G(j
    omega)|, with the exact delay. The peak is bracketed among frequencies around all roots and gain
    crossovers and refined to about 1e-12 of its value for well separated roots. For a flexible
    plant and a controller of one's own, which have no polynomials, it is the norm of python-control
    with the Pade approximation of `Autopilot.close`. With the open loop's L = N/D, and n/D from
    wind to deflection, the closed loop has G = n/(D + N).
    """
    margins = loop_margins(autopilot.exact_loop(plant))
    if not margins.stable:
        return float(np.inf)
    if not isinstance(plant, Plant) or not plant.is_rigid or autopilot.controller is not None:
        import control

        return float(
            control.system_norm(autopilot.close(plant)["deflection", "wind"], p="inf", tol=1e-11)
        )
    loop = autopilot.rational_loop(plant)
    numerator = wind_numerator(autopilot, plant)

    def negative_gain(omega: FloatArray) -> FloatArray:
        """Return -|G(j omega)| at frequencies [rad/s], in their shape.

        G, from wind to deflection, is `numerator` over D + N of the open loop's L = N/D.
        """
        N, D = (term.reshape(omega.shape) for term in loop.form.parts(omega.reshape(1, -1)))
        return -np.abs(polynomials.value(numerator, 1j * omega) / (D + N))  # N with its delay

    (grid,) = grid_frequencies(loop.form, stability(loop.form))  # of one loop
    ratios = np.concatenate([1.0 - _CROSSOVER_OFFSETS, 1.0 + _CROSSOVER_OFFSETS])
    frequencies = np.multiply.outer(margins.crossings.gain_frequencies, ratios).ravel()
    omega = np.unique(np.concatenate([[0.0], grid[np.isfinite(grid)], frequencies]))
    values = negative_gain(omega)
    # At infinity L vanishes, and G is the direct term.
    same_degree = numerator.size == loop.denominator.size
    direct = abs(numerator[0] / loop.denominator[0]) if same_degree else 0.0
    k = 1 + np.flatnonzero((values[1:-1] <= values[:-2]) & (values[1:-1] < values[2:]))
    if k.size:  # peaks between the frequencies next to the highest ones
        before, after = omega[k - 1], omega[k + 1]
        _, peaks = grid_minimum(negative_gain, before, after, PEAK_REFINEMENTS, smooth=True)
        values = np.append(values, peaks)
    return float(max(-values.min(), direct))


_GRID_DURATIONS = 21
"""Number of durations over the whole range."""
_PER_PERIOD = 6
"""Number of durations in each period of an oscillating mode."""
_MAX_PER_MODE = 750
"""Largest number of durations for one mode."""
_DECAY_EXPONENT = 5.0
"""Exponent of the decay, e^-5, of a mode up to which its periods are sampled."""
_DURATION_TOLERANCE = 1e-6
"""Tolerance of the worst duration, over the shortest duration."""


@dataclass(frozen=True)
class WorstDuration(Shown):
    """Duration at which a family of winds requires an autopilot's largest deflection.

    Attributes
    ----------
    duration : float
        Duration [s].
    peak_deflection : float
        Magnitude of the peak deflection in that wind [rad].
    at_range_end : bool
        Whether it is the shortest or longest duration of the search: beyond it may be worse.
    """

    duration: float = field(metadata=spec("time"))
    peak_deflection: float = field(metadata=spec("angle"))
    at_range_end: bool = field(metadata=spec(name="at_the_end"))


def worst_duration(
    plant: AnyPlant,
    autopilot: Autopilot,
    *,
    peak: float,
    shortest: float,
    longest: float,
    shape: Callable[..., History],
) -> WorstDuration:
    """Return the duration at which a family of winds requires the largest deflection.

    Parameters
    ----------
    plant, autopilot : Plant or FlexiblePlant, Autopilot
        One each, with a stable closed loop.
    peak : float
        Peak [rad] of every wind of the family.
    shortest, longest : float
        Range of durations [s].
    shape : callable
        Wind of a peak and a duration, such as `TriangularWind`.

    Raises
    ------
    InputError
        For an unstable closed loop, and durations that are not positive and rising.

    Notes
    -----
    Durations are evaluated over the whole range and in every period of the loop's modes until they
    have decayed (at most 750 for one mode), and those near a maximum are refined. A family whose
    winds oscillate faster than the loop may hide a worse duration.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> gains = tv.control.canonical_gains(plant.coefficients)
    >>> worst = tv.control.worst_duration(
    ...     plant, gains, peak=0.1, shortest=1, longest=60, shape=tv.TriangularWind
    ... )
    >>> round(worst.duration, 1), worst.at_range_end
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
    peaks = autopilot.deflection_peaks_function(plant)

    def deflections(durations: FloatArray) -> FloatArray:
        """Return the peak deflections [rad] in winds of a `shape` and n durations [s], ``(n,)``."""
        winds = [shape(peak=peak, duration=duration) for duration in durations.tolist()]
        instance("shape(peak, duration)", winds[0], History, "such as TriangularWind")
        return peaks(winds)

    return _worst(deflections, _durations(closed_loop(autopilot, plant).A, low, high))


def _worst(deflections: Callable[[FloatArray], FloatArray], durations: FloatArray) -> WorstDuration:
    """Return the worst of the durations [s], refined between its neighbours.

    `deflections`: function from durations to peak deflections [rad], both ``(n,)``. `durations`:
    rising, ``(n,)``; the worst may be at an end of them.
    """
    from scipy.optimize import minimize_scalar  # late: it takes 0.3 s to import

    values = deflections(durations)
    top = int(np.argmax(values))
    at_end = top in (0, durations.size - 1)
    worst = WorstDuration(float(durations[top]), float(values[top]), at_range_end=at_end)
    # Maxima that may be the highest of all: a maximum is taken to exceed its highest sample by no
    # more than this sample exceeds its lower neighbour.
    before, middle, after = values[:-2], values[1:-1], values[2:]
    bound = 2.0 * middle - np.minimum(before, after)
    possible = (middle >= before) & (middle >= after) & (bound >= values.max())
    tolerance = {"xatol": _DURATION_TOLERANCE * durations[0]}
    for k in (1 + np.flatnonzero(possible)).tolist():
        bounds = durations[k - 1], durations[k + 1]
        maximum = minimize_scalar(
            lambda duration: -deflections(np.array([duration]))[0], bounds=bounds, options=tolerance
        )
        if -maximum.fun > worst.peak_deflection:
            worst = WorstDuration(float(maximum.x), float(-maximum.fun), at_range_end=False)
    return worst


def _durations(A: FloatArray, low: float, high: float) -> FloatArray:
    """Return durations [s] ``(n,)`` that resolve every oscillation of a loop until it decays.

    `A`: state matrix of the closed loop, stable; a mode counts as decayed at e^-5, and has six
    durations in each of its periods, 750 at most. `low`, `high`: shortest and longest duration [s].
    """
    grids = [np.geomspace(low, high, _GRID_DURATIONS)]
    for pole in np.linalg.eigvals(A):
        last = min(_DECAY_EXPONENT / -pole.real, high)  # [s]
        if pole.imag > 0.0 and last > low:
            count = int((last - low) * pole.imag / (2.0 * np.pi) * _PER_PERIOD) + 2
            grids.append(np.linspace(low, last, min(count, _MAX_PER_MODE)))
    return np.unique(np.concatenate(grids))


DEAD_BANDS = (1.0, 0.5, 0.0)
"""Dead bands K at which the boundary limit is computed for comparison."""


@dataclass(frozen=True, eq=False)
class TrimComparison(Shown):
    """Peaks of an autopilot in a wind, compared with trim, boundary limits and the minimum.

    Angles are magnitudes [rad]. If the closed loop is unstable the autopilot's are infinite.

    Attributes
    ----------
    plant, autopilot, wind : Plant or FlexiblePlant, Autopilot, History
        The loop and its wind.
    margins : Margins
        Margins of the loop.
    trim_deflection : float
        ``|B alpha_w,max|``, the deflection of ideal trim without drift.
    peak_deflection : float
        Largest deflection of the autopilot.
    peak_deflection_rate : float
        Largest deflection rate [rad/s]; infinite where the deflection jumps, which it does in a
        wind that jumps if the angle of attack is fed back without an actuator.
    peak_angle_of_attack, peak_attitude : float
        Largest angle of attack and attitude error. Ideal trim keeps the attitude, and its angle of
        attack is the wind. The bending moment is proportional to N times the angle of attack.
    peak_flight_path_angle : float
        Largest drift of the path; times the speed it is the lateral velocity. NaN on a fixed path.
    boundaries : dict of float to float
        Deflection on the report's boundary for each dead band K; NaN for a wind of two signs.
    minimum : float
        Minimum peak over all controls, the wind being known, appendix C.
    wind_gain : float
        H-infinity norm from wind to deflection: the deflection per wind angle in the worst
        sinusoidal wind.
    notes : tuple of str
        Warnings on the validity of the numbers; often empty.
    """

    plant: AnyPlant = field(metadata=spec(name="model", of="plant.model"))
    autopilot: Autopilot
    wind: History
    margins: Margins = field(metadata=spec(name="status", of="margins.status"))
    trim_deflection: float = field(metadata=spec("angle"))
    peak_deflection: float = field(metadata=spec("angle"))
    peak_deflection_rate: float = field(
        metadata=spec(
            "angular rate",
            "largest rate of deflection",
            key="peak_deflection_rate_deg_s",
            card=False,
        )
    )
    peak_angle_of_attack: float = field(
        metadata=spec("angle", "largest angle of attack", card=False)
    )
    peak_attitude: float = field(metadata=spec("angle", "largest attitude error", card=False))
    peak_flight_path_angle: float = field(
        metadata=spec("angle", "largest drift of the path", card=False)
    )
    boundaries: dict[float, float]
    minimum: float = field(metadata=spec("angle"))
    wind_gain: float = field(
        metadata=spec(label="H-infinity, wind to deflection", digits=3, card=False)
    )
    notes: tuple[str, ...] = field(default=(), metadata=spec())

    def deflections(self, caption: str = "", stop: float | None = None) -> lines.Table:
        """Return the table of the peak deflection, of trim, boundary limits and minimum.

        Parameters
        ----------
        caption : str
            Title of the table.
        stop : float, optional
            Smallest deflection limit [rad] with which the autopilot survives in flight.
        """
        flown = {} if stop is None else {"stop": (f"{REQUIREMENT}, flown", stop)}
        boundaries = {f"K{K:g}": (f"boundary, K = {K:g}", y) for K, y in self.boundaries.items()}
        deflections = {  # label and deflection [rad] by key
            "deflection": ("this autopilot, without a limit", self.peak_deflection),
            **flown,
            "trim": (STATIC_TRIM, self.trim_deflection),
            **boundaries,
            "minimum": (WIND_KNOWN, self.minimum),
        }
        trim = self.trim_deflection or np.nan
        table_rows = tuple(
            (
                (label,),
                lines.minimum_limit(lines.degrees(f"wind.{key}", value)),
                lines.minimum_limit(lines.number(f"wind.{key}.part", value / trim)),
            )
            for key, (label, value) in deflections.items()
        )
        return lines.Table(caption, ("deflection", "[deg]", "over trim"), table_rows)

    def motions(self) -> list[lines.Row]:
        """Return rows of the peak rate, angles and drift, and of the H-infinity norm."""
        angles = ("peak_angle_of_attack", "peak_attitude", "peak_flight_path_angle")
        finite = [name for name in angles if np.isfinite(getattr(self, name))]
        return rows(self, "wind", "peak_deflection_rate", *finite, "wind_gain", "steady_drift_rate")

    def _repr_html_(self) -> str:
        """Return deflections, motions and notes as tables for a notebook."""
        title = f"Autopilot beside trim, {self.plant.model}"
        motions = lines.quantities("In this wind", self.motions())
        notes = [(note,) for note in self.notes]
        return table(self.deflections(title)) + table(motions, notes)

    @property
    @derived(
        "speed", label="steady drift in a constant wind of that peak", card=False, document=False
    )
    def steady_drift_rate(self) -> float | None:
        """Steady drift rate [m/s], normal to the path, in a constant wind of this peak.

        None for an autopilot without gains on drift and acceleration, an unstable loop, and another
        model than "drift" and "drift-exact".
        """
        plant, autopilot = self.plant.rigid, self.autopilot
        if not autopilot.lateral_gains or not self.margins.stable:
            return None
        if not plant.is_rigid or plant.model not in ("drift", "drift-exact"):
            return None
        return float(steady_drift(autopilot, plant)) * float(self.wind.peak)

    @property
    @derived(name="part_of_trim", card=False, document=False)
    def ratio_to_trim(self) -> float:
        """Peak deflection of the autopilot over the trim deflection."""
        return self.peak_deflection / self.trim_deflection if self.trim_deflection else np.nan


def compare_with_trim(plant: AnyPlant, autopilot: Autopilot, wind: History) -> TrimComparison:
    """Return the peaks of an autopilot in a wind, compared with trim, boundaries and minimum.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        One plant of any model; trim, boundaries and minimum are computed for the rigid vehicle.
    autopilot : Autopilot
        One autopilot, here without deflection limit. With a sample rate the margins are those of
        the sampled loop, and the peaks for the continuous loop.
    wind : History
        One wind that ends.

    Raises
    ------
    InputError
        For batches, and for a wind that never ends or is zero.

    Notes
    -----
    Trim, boundaries and minimum do not depend on the gains. Pure attitude hold makes the angle of
    attack larger than the wind: in a steady wind by a0/(a0 - B), a0 being the gain on the attitude
    and B the ratio of trim deflection to angle of attack.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> wind = tv.TriangularWind(peak=np.radians(5), duration=7.5)
    >>> c = tv.compare_with_trim(plant, tv.control.canonical_gains(plant.coefficients), wind)
    >>> round(c.ratio_to_trim, 3), round(c.boundaries[1.0] / c.trim_deflection, 3)
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
    continuous = autopilot.continuous
    peaks = dict.fromkeys((*_PEAKS, "peak_deflection_rate"), np.inf)  # of an unstable loop
    if margins.stable:
        response = continuous.wind_response(plant, wind)
        for name, output in _PEAKS.items():
            has_output = output in response.labels  # a fixed path has no flight path angle
            peaks[name] = abs(response.peak(output)[0]) if has_output else np.nan
        peaks["peak_deflection_rate"] = response.peak_rate("deflection")
    notes = [] if margins.stable else [margins.reason]
    if autopilot.sample_rate is not None:
        notes.append(
            "peaks are of the continuous autopilot, criteria and margins of the sampled one"
        )
    boundaries, boundary_notes = _boundaries(plant.rigid, wind)
    notes += boundary_notes
    minimum = optimum_deflection(plant.rigid, wind)
    if minimum.status != "ok":
        notes.append(f"minimum: {minimum.status}")
    return TrimComparison(
        plant=plant,
        autopilot=autopilot,
        wind=wind,
        margins=margins,
        trim_deflection=trim,
        **peaks,
        boundaries=boundaries,
        minimum=float(minimum.peak),
        wind_gain=wind_gain(plant, continuous),
        notes=tuple(notes),
    )


_PEAKS = {
    "peak_deflection": "deflection",
    "peak_angle_of_attack": "angle_of_attack",
    "peak_attitude": "attitude",
    "peak_flight_path_angle": "flight_path_angle",
}
"""Outputs of a loop by the names of their peaks."""


def _boundaries(plant: Plant, wind: History) -> tuple[dict[float, float], list[str]]:
    """Return the boundary limit [rad] of a plant in a wind by dead band K, and notes on them.

    The vehicle is trimmed up to K times the limit, then the whole limit is held. Larger
    requirements of other theorems take the limit's place. NaN where none exists, with a note.
    """
    bands = np.array(DEAD_BANDS)
    try:
        # "literal": the dead band ends where trim itself, not the wind, exceeds K times the limit
        boundary = boundary_limit(plant, wind, bands, "literal")
        requirement = with_larger_requirements(plant, wind, bands, boundary)
    except InputError as error:
        return dict.fromkeys(DEAD_BANDS, np.nan), [f"no boundary: {error}"]
    bands_by_status: dict[str, list[str]] = {}
    for K, status in zip(DEAD_BANDS, requirement.status.tolist(), strict=True):
        bands_by_status.setdefault(status, []).append(f"{K:g}")
    notes = [
        f"boundary K = {', '.join(texts)}: {status}"
        for status, texts in bands_by_status.items()
        if status != "ok"
    ]
    limits = np.abs(requirement.deflection).tolist()
    return dict(zip(DEAD_BANDS, limits, strict=True)), notes
