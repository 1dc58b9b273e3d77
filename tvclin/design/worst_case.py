"""Worst margins and worst required deflection of all vehicles in a box, and their numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from tvclin.base import lines
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown, table
from tvclin.base.errors import InputError, finite, instance, number, one_of, single, within
from tvclin.base.fields import spec
from tvclin.base.quantities import NOMINAL
from tvclin.base.tables import FileTable
from tvclin.base.units import si_unit
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import GAINS
from tvclin.control.margins.margins import MARGINS, Margins, margin, margins_of, unit_factor
from tvclin.ensembles.dispersions import KINDS, MODES, WIND
from tvclin.linear.plant import Plant, default_model
from tvclin.numerics.searches import box_minimum
from tvclin.requirement.nominal_requirement import required_deflection
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.wind_angles import within_linear

PROVED, SEARCHED = "corners (proved)", "searched"
LOOP = {
    "gain": "number",
    "delay": "delay",
    "actuator_frequency": "natural frequency",
    "actuator_damping": "number",
}
"""Numbers of the loop that are no gains of the autopilot, each of a kind of `UNITS`; `gain` is a
factor on all of them."""
_VEHICLE = tuple(name for name in KINDS if name not in {*WIND, *GAINS, *MODES})
BOX_TABLE = FileTable("--box", {name: KINDS[name] for name in _VEHICLE} | WIND | GAINS | LOOP)
"""The numbers of a box around a `Vehicle`, as the command line names them."""
_COEFFICIENTS = tuple(field.name for field in fields(Coefficients))
_MAX_BOX_NUMBERS = 10
"""Largest number of numbers in a box, which then has 1024 corners."""
_INTERIOR_POINTS = 256
"""Number of even points in the box, before the search."""
_SEARCH_OPTIONS: dict[str, Any] = {"per_round": 32, "rounds": 10, "tolerance": 1e-9, "islands": 1}
"""Options of the search that starts from the worst corners and interior points."""
_RELATIVE_TOLERANCE = 1e-6
"""Relative difference above which a point inside is worse than all corners."""
_SHOWN_MARGINS = tuple(name for name in MARGINS if not name.startswith("peak"))
"""Margins that are computed; peaks of S and T are equivalent to the disk margin."""


@dataclass(frozen=True, eq=False)
class Worst:
    """Worst value of a margin or deflection in a box, and the point of the box that has it.

    Attributes
    ----------
    value : float
        The worst value, in the unit of its name; of a margin zero where a loop is unstable.
    nominal : float
        The value where nothing has changed.
    at : dict of str to float
        The numbers of the box at that point [SI].
    corner : bool
        Whether that point is a corner of the box.
    method : str
        "corners (proved)": it is proved that a corner is the worst. "searched": all corners, even
        points inside and points near the worst of them were tried; there may be worse ones.
    """

    value: float
    nominal: float
    at: dict[str, float]
    corner: bool
    method: str

    @property
    def location(self) -> tuple[lines.Line, lines.Line]:
        """Cells of a table: "a corner" or "inside", and the method of the search."""
        return ("a corner" if self.corner else "inside",), (self.method,)


@dataclass(frozen=True, eq=False)
class WorstCase(Shown):
    """The worst margins and the worst required deflection in a box.

    Attributes
    ----------
    box : dict of str to pair of float
        The numbers and their bounds [SI].
    margins : dict of str to Worst
        aero_margin_dB, gain_increase_dB, phase_margin_deg, delay_margin [s] and disk_margin.
    stable : bool
        Whether every loop that was tried is stable.
    deflection : Worst or None
        The required deflection [rad] at nominal dynamic pressure, in size; None without a wind,
        and infinite in a wind of more than 30 deg, in which no deflection is known to be
        sufficient.
    tried : int
        Number of loops that were computed.
    """

    box: dict[str, tuple[float, float]] = field(metadata=spec(card=False))
    margins: dict[str, Worst] = field(metadata=spec(card=False))
    stable: bool = field(metadata=spec())
    deflection: Worst | None = field(metadata=spec(name="required_deflection_rad", card=False))
    tried: int = field(metadata=spec())

    def table(self) -> lines.Table:
        """Return the nominal and the worst value of each margin and of the deflection, located."""
        rows: list[tuple[lines.Line, ...]] = []  # of cells without keys for JSON, ""
        for name, worst in self.margins.items():
            label, unit, _ = MARGINS[name]
            values = (margin("", unit_factor(unit) * x, unit) for x in (worst.nominal, worst.value))
            rows.append(((label,), *values, *worst.location))
        if self.deflection is not None:
            worst = self.deflection
            values = (
                lines.minimum_limit(lines.degrees("", x, unit="deg"))
                for x in (worst.nominal, worst.value)
            )
            rows.append(((f"required deflection {NOMINAL}",), *values, *worst.location))
        head = ("", "nominal", "worst", "at", "method")
        return lines.Table("Worst case in the box", head, tuple(rows))

    def _repr_html_(self) -> str:
        """Return the table of the worst case, for a notebook."""
        return table(self.table())


def worst_case(
    subject: Vehicle | Coefficients,
    autopilot: Autopilot,
    box: Mapping[str, tuple[float, float]],
    *,
    model: str | None = None,
    plane: str = "pitch",
    wind: ShapedWind | None = None,
    dead_band: float = 1.0,
) -> WorstCase:
    """Return the worst margins, and the worst required deflection, anywhere in a box.

    Parameters
    ----------
    subject : Vehicle or Coefficients
        The nominal vehicle, or its coefficients.
    autopilot : Autopilot
        The nominal autopilot, continuous or with a sample rate, no batch.
    box : mapping of str to pairs
        Smallest and largest value [SI] of each uncertain number, up to ten: fields of
        `Vehicle` or of `Coefficients`, "wind_peak", "wind_duration", gains of `Autopilot`,
        "gain" (a factor on all gains), "delay", "actuator_frequency", "actuator_damping".
    model, plane : str
        Model of the plant, by `default_model` if not given, and plane of a `Vehicle`.
    wind : ShapedWind, optional
        The nominal wind; without it `deflection` is None.
    dead_band : float
        K of the required deflection.

    Raises
    ------
    InputError
        For unknown names, bounds that do not rise, a box of more than ten numbers, an actuator that
        is in the box and not in the loop, batches; also the exceptions of `Coefficients`,
        `Autopilot.exact_loop` and `required_deflection`, for any point of the box.

    Notes
    -----
    On a fixed path, with K = 1 and a wind of a single peak, the required deflection is static trim
    times the boundary limit y(tau beta), which rises with the duration tau times the pole beta; so
    it rises or falls with each number by itself, and a corner is the worst. The page on least gains
    has the proof. All other values are searched.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> vehicle = tv.load_vehicle("configuration-i")
    >>> autopilot = tv.control.canonical_gains(tv.Coefficients.from_vehicle(vehicle), delay=0.02)
    >>> box = {"thrust": (0.97 * vehicle.thrust, 1.03 * vehicle.thrust), "delay": (0.0, 0.04)}
    >>> found = tv.worst_case(vehicle, autopilot, box)
    >>> worst = found.margins["phase_margin_deg"]
    >>> round(worst.nominal, 1), round(worst.value, 1), worst.at["delay"], worst.method
    (27.2, 25.6, 0.04, 'searched')
    """
    ends = _checked(subject, autopilot, box, wind)
    model = default_model(subject) if model is None else model
    bounds = np.array(list(ends.values()))
    case = _Case(subject, autopilot, tuple(ends), ends=bounds, model=model, plane=plane, wind=wind)
    K = float(within("dead_band", number("dead_band", dead_band), 0.0, 1.0))
    corners = np.array(list(product((0.0, 1.0), repeat=len(ends))))
    margins = {name: case.worst(corners, partial(case.margin, name)) for name in _SHOWN_MARGINS}
    deflection = None
    if wind is not None:
        # where a corner is proved to be the worst (see Notes) nothing is searched
        proved = model == "fixed-path" and K == 1.0 and wind.gust is None
        deflection = case.worst(corners, partial(case.deflection, K), proved)
        deflection = replace(
            deflection, value=abs(deflection.value), nominal=abs(deflection.nominal)
        )
    return WorstCase(
        box=ends,
        margins=margins,
        stable=all(worst.value > 0.0 for worst in margins.values()),
        deflection=deflection,
        tried=sum(np.size(loops.status) for loops in case.analyses.values()),
    )


def _checked(subject: Any, autopilot: Any, box: Any, wind: Any) -> dict[str, tuple[float, float]]:
    """Return the box as lower and upper number [SI] by name.

    `InputError` for arguments of `worst_case` of another type, and for a number of the box that the
    `subject`, the `autopilot` or the `wind` does not have.
    """
    if not isinstance(subject, Vehicle | Coefficients):
        raise InputError(f"subject must be a Vehicle or Coefficients; got {type(subject).__name__}")
    single("subject", subject.batch)
    instance("autopilot", autopilot, Autopilot, "see design_gains")
    single("autopilot", autopilot.batch)
    if wind is not None:
        instance("wind", wind, ShapedWind, "of a shape, a peak and a duration")
    instance("box", box, Mapping, "of names to a least and a largest value")
    if not 0 < len(box) <= _MAX_BOX_NUMBERS:
        raise InputError(f"box must have 1 to {_MAX_BOX_NUMBERS} numbers; got {len(box)}")
    of_subject = _VEHICLE if isinstance(subject, Vehicle) else _COEFFICIENTS
    names = (*of_subject, *GAINS, *LOOP, *(WIND if wind is not None else ()))
    bounds_of = {}
    for name, pair in box.items():
        one_of("a number in box", name, names)
        bounds = finite(name, pair)
        if bounds.shape != (2,) or not bounds[0] < bounds[1]:
            raise InputError(f"box of {name} must be a least and a larger value; got {pair!r}")
        bounds_of[name] = (float(bounds[0]), float(bounds[1]))
    if autopilot.actuator is None and {"actuator_frequency", "actuator_damping"} & bounds_of.keys():
        raise InputError("an actuator is in the box, but the autopilot has none")
    first_order = autopilot.actuator is not None and autopilot.actuator.damping is None
    if first_order and "actuator_damping" in bounds_of:
        raise InputError("the actuator is of first order and has no damping")
    return bounds_of


@dataclass(frozen=True, eq=False)
class _Case:
    """Plants, autopilots and winds whose numbers lie in a box, around a nominal case."""

    subject: Vehicle | Coefficients
    autopilot: Autopilot
    names: tuple[str, ...]
    ends: FloatArray
    model: str
    plane: str
    wind: ShapedWind | None

    analyses: dict[tuple[bool, tuple[bytes, ...]], Margins] = field(default_factory=dict)

    def values(self, points: FloatArray) -> dict[str, FloatArray]:
        """Return the numbers [SI] at n `points` of the unit box ``(n, axes)``, ``(n,)`` by name.

        `ends` has the smallest and the largest value of each number, at 0 and 1 of its axis.
        """
        spread = self.ends[:, 0] * (1.0 - points) + self.ends[:, 1] * points
        return dict(zip(self.names, spread.T, strict=True))

    def plant(self, values: Mapping[str, FloatArray]) -> Plant:
        """Return the plants with some numbers other than the nominal ones.

        `values`: these numbers [SI], ``(n,)`` by name; numbers of a loop are ignored. `subject` is
        the nominal vehicle, or its coefficients.
        """
        names = _VEHICLE if isinstance(self.subject, Vehicle) else _COEFFICIENTS
        changed = self.subject.replace(**{k: v for k, v in values.items() if k in names})
        if isinstance(changed, Vehicle):
            return Plant.from_vehicle(changed, self.model, self.plane)
        return Plant.from_coefficients(changed, self.model)

    def loop(self, values: Mapping[str, FloatArray]) -> Autopilot:
        """Return the autopilots with some numbers other than the nominal ones.

        `values`: these numbers [SI], ``(n,)`` by name; "gain" is a factor on all gains, and those
        of the vehicle are ignored.
        """
        a = self.autopilot
        factor = values.get("gain", 1.0)
        changes: dict[str, Any] = {
            name: factor * values.get(name, getattr(a, name)) for name in GAINS
        }
        if "delay" in values:
            changes["delay"] = values["delay"]
        if a.actuator is not None:
            changes["actuator"] = Actuator(
                natural_frequency=values.get("actuator_frequency", a.actuator.natural_frequency),
                damping=values.get("actuator_damping", a.actuator.damping),
            )
        return replace(a, **changes)

    def margin(self, name: str, values: Mapping[str, FloatArray]) -> FloatArray:
        """Return a margin of n loops, ``(n,)``, zero where a loop is unstable.

        `name`: its name in `Margins`. `values`: numbers other than nominal [SI], ``(n,)`` by name.
        `analyses` keeps the margins of these numbers, for other margins of the same loops; of
        sampled loops without delay margins, which are most of the work, and apart with them.
        """
        delays = name == "delay_margin" or self.autopilot.sample_rate is None
        key = (delays, tuple(np.asarray(v).tobytes() for v in values.values()))
        if key not in self.analyses:
            loop = self.loop(values).exact_loop(self.plant(values))
            self.analyses[key] = margins_of(loop.analysis(delays=delays), loop)
        margins = np.asarray(getattr(self.analyses[key], name), float)
        return np.nan_to_num(margins, nan=0.0, posinf=np.inf)

    def deflection(self, dead_band: float, values: Mapping[str, FloatArray]) -> FloatArray:
        """Return minus the required deflections [rad] of n cases; -inf in winds beyond linearity.

        With the sign of a margin: the smallest is the worst. `dead_band`: K. `values`: numbers
        other than nominal [SI], ``(n,)`` by name.
        """
        assert self.wind is not None
        wind = self.wind.history(dict(values))
        required = required_deflection(self.plant(values), wind, dead_band)
        return np.where(within_linear(wind.peak), -np.abs(required.deflection), -np.inf)

    def worst(
        self,
        corners: FloatArray,
        value: Callable[[Mapping[str, FloatArray]], FloatArray],
        proved: bool = False,
    ) -> Worst:
        """Return the minimum of a value in the box.

        `corners`: of the unit box of k numbers, ``(2^k, k)``. `value`: function from n values of
        each number ``(n,)`` by name to ``(n,)``. `proved`: whether a corner is proved to be the
        minimum, so that nothing is searched.
        """
        nominal = float(value({}))  # no number other than nominal
        edges = np.broadcast_to(value(self.values(corners)), len(corners))
        best = int(np.argmin(edges))
        point, worst, corner = corners[best], float(edges[best]), True
        if not proved and np.isfinite(worst):
            # The search also gives the lowest values so far, which are of no use here.
            points, minima = box_minimum(
                lambda x, _lowest: np.broadcast_to(value(self.values(x)), len(x)),
                len(self.names),
                initial=_INTERIOR_POINTS,
                start=corners,
                **_SEARCH_OPTIONS,
            )
            if minima[0] < worst - _RELATIVE_TOLERANCE * abs(worst):
                point, worst = points[0], float(minima[0])
                corner = bool(np.all((point == 0.0) | (point == 1.0)))
        at = {name: float(v[0]) for name, v in self.values(point[np.newaxis]).items()}
        method = PROVED if proved else SEARCHED
        return Worst(value=worst, nominal=nominal, at=at, corner=corner, method=method)


def unit_of(name: str) -> str:
    """Return the SI unit, as text, of the number `name` of a vehicle, a wind or a loop in a box."""
    return si_unit(BOX_TABLE.quantities[name])
