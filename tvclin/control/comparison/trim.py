"""A closed loop in a wind beside trim: what the autopilot asks of the nozzle, and what is needed.

The report compares every control with ideal trim, which takes |B alpha_w,max|. Here the same is
done for an autopilot: its largest deflection and the loads it leaves, beside trim, the boundary
limits and the minimum of appendix C. All peaks are those of exact histories, without limits.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.base import lines
from tvclin.base.cards import Shown, table
from tvclin.base.errors import InputError, ending, instance
from tvclin.boundary.limit import boundary_limit
from tvclin.boundary.optimum.minimum_peak import optimum_deflection
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.warnings import warn_of_feedback
from tvclin.control.autopilot.wind_gain import wind_gain
from tvclin.control.margins.record import Margins, loop_margins
from tvclin.linear.flexible import AnyPlant, check_plant
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History

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
        found = boundary_limit(plant, wind, np.array(DEAD_BANDS), "literal")
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
