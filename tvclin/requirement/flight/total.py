"""Total deflection of a nozzle: requirement of the wind, nominal flight, offsets, dispersions.

    total = |nominal| + |wind| + sum of systematic offsets + sqrt(sum of random parts^2)

A reserve is a fraction of the available limit that stays unused: total <= (1 - reserve) limit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tvclin.base import errors
from tvclin.base.cards import Record, Shown, table
from tvclin.base.fields import checked, derived, quantity, spec, text, word
from tvclin.base.lines import Line as Cell
from tvclin.base.lines import Table, degrees, significant
from tvclin.base.lines import text as cell_text
from tvclin.base.quantities import OF_RAMP, sufficiency
from tvclin.boundary.limit_over_rate import ramp_rate, ramped_deflection
from tvclin.linear.modes import unstable_modes
from tvclin.requirement.flight.flight_turbulence import FlightTurbulence
from tvclin.requirement.flight.sizing import Sizing
from tvclin.requirement.required_quantity import Requirement, requirement_among
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.vehicle.vehicle import Vehicle

KINDS = ("systematic", "random")
"""Kinds of contributions to a total."""
HEAD, SUMS = ("what", "how it adds up", "[deg]"), "sum and root of sum of squares"
_MAX_DEFLECTION_RAD = 1e9
"""Largest deflection [rad] of a contribution."""
_MIN_SHORTFALL_RAD = float(np.radians(0.001))
"""Shortfall [rad] below which more than three digits behind the point are shown."""
RATES = (1e-15, 1e9)
"""Smallest and largest rate limit [rad/s]."""


@dataclass(frozen=True)
class Line(Record):
    """A contribution to the total deflection [rad], zero or positive.

    Systematic contributions add up, random ones by the root of the sum of squares.
    """

    name: str = text()
    deflection: float = quantity("angle", check=errors.nonnegative)
    kind: str = word(KINDS, "systematic")

    def __post_init__(self) -> None:
        """Check the fields; `InputError` for a negative deflection and an unknown kind."""
        checked(self, "kind", "name")
        name = self.name or "deflection"
        size = errors.number(name, self.deflection, errors.nonnegative, "rad")
        errors.within(name, size, 0.0, _MAX_DEFLECTION_RAD, "rad")
        object.__setattr__(self, "deflection", size)


@dataclass(frozen=True)
class DeflectionTotal(Shown):
    """The total deflection that a nozzle needs, and its limit; make it with `total_deflection`.

    Attributes
    ----------
    lines : tuple of Line
        Contributions; empty where the wind's is known at no flight time.
    reserve : float
        Fraction of the limit that is to stay unused, in [0, 1).
    limit : float or None
        Available deflection [rad].
    time : float or None
        Flight time [s] to which the lines belong.
    not_sized : tuple of str
        Intervals of the flight in which the total is not known, in words, such as
        "above 24.9 km"; empty where it is known throughout.
    rate_limit : float or None
        Rate limit of the nozzle [rad/s].
    end : str
        End of the flight at that time, in words, beyond which the total may be larger; empty
        between the ends.
    listed : tuple of float
        Listed flight times [s] between which that time lies; empty where it is listed.
    needed_rate : float
        Required rate [rad/s] of a ramp for the required deflection of the wind, at the limit or
        else at any; NaN where it is not known.
    counted : str
        Label of the requirement that is the wind's contribution; empty without one.
    """

    lines: tuple[Line, ...] = field(metadata=spec(card=False))
    reserve: float = quantity("number", 0.0, errors.nonnegative)
    limit: float | None = quantity(
        "angle", None, errors.small_angle("a deflection", errors.positive), document=False
    )
    time: float | None = quantity("time", None)
    not_sized: tuple[str, ...] = field(default=(), metadata=spec(card=False, document=False))
    rate_limit: float | None = quantity("angular rate", None, errors.between(*RATES), card=False)
    needed_rate: float = field(default=0.0, metadata=spec("angular rate", card=False))
    end: str = text("", card=False, document=False)
    listed: tuple[float, ...] = field(default=(), metadata=spec("time", card=False))
    counted: str = text("", card=False, document=False)

    def __post_init__(self) -> None:
        """Check the fields; `InputError` for numbers out of range, and other types."""
        for name, kind, hint in (
            ("lines", Line, "of a total"),
            ("not_sized", str, "a place"),
            ("listed", float, "flight times [s]"),
        ):
            object.__setattr__(self, name, errors.each(name, getattr(self, name), kind, hint))
        checked(self, "reserve", "limit", "time", "rate_limit", "end", "counted")
        if self.reserve >= 1.0:
            raise errors.InputError(
                f"reserve must be a part of the limit, below 1; got {self.reserve:.6g}"
            )
        errors.instance("needed_rate", self.needed_rate, float, "in rad/s")

    def _repr_html_(self) -> str:
        return table(total_table(self), self.verdict)

    @property
    def verdict(self) -> tuple[Cell, ...]:
        """The verdict on the limit, and where the total is not known, each as a line."""
        verdicts: list[Cell] = []
        if self.limit is not None:
            line: Cell = (sufficiency(self.sufficient),)
            if self.sufficient and self.remaining is not None:
                remaining = degrees("total.remaining", abs(self.remaining), unit="deg")
                words = " remaining after the reserve" if self.reserve else " remaining"
                line = (f"{sufficiency(True)}, ", *remaining, words)
            elif self.sufficient is False:
                shortfall = self.required - self.limit  # [rad]
                short = degrees("total.short", shortfall, unit="deg")
                if shortfall < _MIN_SHORTFALL_RAD:
                    short = significant("total.short_deg", np.degrees(shortfall), unit="deg")
                line = (f"{sufficiency(False)}, short by ", *short)
                if shortfall <= 0.0:  # the rate limit is too low, not the deflection limit
                    line = (f"{sufficiency(False)} at this rate limit",)
            limit = degrees("total.limit", self.limit, unit="deg")
            verdicts.append(("Limit ", *limit, ": ", *line))
        if self.not_sized:
            where = ", ".join(self.not_sized)
            verdicts.append((f"Required deflection {sufficiency(None)} {where}",))
        if self.rate_limit is not None:
            available = degrees("total.rate_limit", self.rate_limit, unit="deg/s")
            needed = degrees("total.needed_rate", self.needed_rate, unit="deg/s")
            word = f"{sufficiency(False)}, " if self.too_slow else ""
            line = ("required rate ", *needed, f" {OF_RAMP}")
            if not np.isfinite(self.needed_rate):
                unknown = np.isnan(self.needed_rate)
                line = (
                    f"required rate {sufficiency(None)}" if unknown else "no rate is sufficient",
                )
            verdicts.append(("Rate limit ", *available, f": {word}", *line))
        return tuple(verdicts)

    @property
    def words(self) -> str:
        """The verdict in words, with the required deflection and its flight time."""
        return self.words_with()

    def words_with(self, autopilot: str = "") -> str:
        """Return the lines of the verdict as clauses of a sentence, and the required deflection.

        `autopilot`: outcome of the autopilot's flights, for a clause after the verdict on the
        limit; empty for none. `InputError` for an outcome that is no text.
        """
        errors.text("autopilot", autopilot)
        clauses = [cell_text(line) for line in self.verdict]
        clauses[1:] = [f"{clause[0].lower()}{clause[1:]}" for clause in clauses[1:]]
        if autopilot:  # "Limit 5 deg: budget SUFFICIENT, ..; autopilot .."
            clauses[:1] = [clause.replace(": ", ": budget ", 1) for clause in clauses[:1]]
            clauses.insert(1, f"autopilot {autopilot}")
        if self.lines:
            known = " of those that are known" if self.not_sized else ""
            where = at_time(self, "the", known)
            # `no_ramp`: no limit is sufficient with the rate limit, which the total then omits
            omitted = f", {WITHOUT_RATE}" if self.no_ramp else ""
            clauses.append(f"budget {np.degrees(self.required):.3f} deg{where}{omitted}")
        return "; ".join(clauses)

    @property
    def systematic(self) -> float:
        """Sum of the systematic lines [rad]."""
        return float(sum(line.deflection for line in self.lines if line.kind == "systematic"))

    @property
    def random(self) -> float:
        """Root of the sum of the squares of the random lines [rad]."""
        deflections = [line.deflection for line in self.lines if line.kind == "random"]
        return float(np.linalg.norm(deflections))

    @property
    @derived("angle")
    def total(self) -> float:
        """Sum of systematic and random contributions [rad]; NaN without any."""
        return self.systematic + self.random if self.lines else float("nan")

    @property
    @derived("angle")
    def required(self) -> float:
        """Minimum limit [rad] with the reserve: total/(1 - reserve)."""
        return self.total / (1.0 - self.reserve)

    @property
    def too_slow(self) -> bool:
        """Whether the rate limit is below the required rate."""
        return self.rate_limit is not None and self.needed_rate > self.rate_limit * (1.0 + 1e-9)

    @property
    def no_ramp(self) -> bool:
        """Whether no ramp at the rate limit is sufficient, whatever its deflection.

        The rate limit, below the required rate, then has no line of its own among the `lines` of
        the total: its contribution would be infinite.
        """
        return self.too_slow and all(line.name != RATE_LINE for line in self.lines)

    @property
    @derived(card=False, document=False)
    def sufficient(self) -> bool | None:
        """Whether the limit covers the total and the reserve, at the available rate.

        Without a limit False where the rate limit is too low, else None. None also where no
        contribution of the wind is known, and where the limit is sufficient at the flight times
        that are known, and others are not known.
        """
        if self.limit is None:
            return False if self.too_slow else None
        if not self.lines:  # the wind's contribution is known at no flight time
            return None
        sufficient = bool(self.required <= self.limit * (1.0 + 1e-12)) and not self.too_slow
        return None if sufficient and self.not_sized else sufficient

    @property
    @derived("angle", card=False, document=False)
    def remaining(self) -> float | None:
        """Remaining deflection [rad]: the limit minus `required`; negative if insufficient.

        None without a limit, and where it is not known whether the limit is sufficient.
        """
        if self.limit is None or self.sufficient is None:
            return None
        return self.limit - self.required


def total_table(total: DeflectionTotal) -> Table:
    """Return the table of the contributions [deg], the total, and the budget if there is a reserve.

    The row of the wind is labelled with the requirement that counts for it, `total.counted`, and
    the total without the rate limit where no deflection is sufficient with it (`no_ramp`). The
    caption says at which flight time, "of those that are known" where others are `not_sized`.
    """
    wind = f"wind, {total.counted}" if total.counted else "wind"
    rows = rows_of(total, "total", wind)
    label = f"total, {WITHOUT_RATE}" if total.no_ramp else "total"
    rows.append(((label,), (SUMS,), degrees("total.total", total.total)))
    if total.reserve:
        reserve = significant("total.reserve_percent", 100 * total.reserve, unit="%")
        needed = degrees("total.required", total.required)
        rows.append((("budget, with ", *reserve, " in reserve"), ("",), needed))
    defined = " of those that are known" if total.not_sized else ""
    return Table(f"Budget of the deflection{at_time(total, 'the', defined)}", HEAD, tuple(rows))


def at_time(total: DeflectionTotal, article: str, defined: str = "") -> str:
    """Return the worst flight time of a total as the end of a caption.

    With the listed times between which it lies, or the end of the flight that it is. `article`:
    word before "worst flight time", such as "its". `defined`: words after it, such as "of those
    that are known".
    """
    if total.time is None:
        return ""
    listed = " and ".join(f"{time:.5g}" for time in total.listed)
    between = f", between the listed {listed} s" if listed else ""
    end = f", {total.end}" if total.end else ""
    return f" at {article} worst flight time{defined}, {total.time:.5g} s{between}{end}"


def rows_of(total: DeflectionTotal, key: str, wind: str) -> list[tuple[Cell, ...]]:
    """Return the contributions to a total as rows of a table.

    `key`: prefix of the names of numbers. `wind`: label of the row of the wind.
    """
    return [
        (
            (wind if line.name == "wind" else line.name,),
            (line.kind,),
            degrees(f"{key}.{line.name.partition(',')[0].replace(' ', '_')}", line.deflection),
        )
        for line in total.lines
        if line.deflection
    ]


RATE_LINE = "rate limit"
"""Name of the contribution of a rate limit."""
WITHOUT_RATE = "without the rate limit, at which no deflection is sufficient"
"""Condition of a total to which no ramp at the rate limit contributes."""
SAME = 1e-9
"""Relative difference below which two totals count as equal."""
_TIME_TOLERANCE = 1e-6
"""Difference [s] below which two flight times count as equal."""


def total_deflection(
    vehicle: Vehicle,
    wind: float,
    *,
    nominal: float = 0.0,
    dispersion: float = 0.0,
    thrust_offset: float = 0.0,
    gravity_offset: float = 0.0,
    others: Sequence[Line] = (),
    reserve: float = 0.0,
    limit: float | None = None,
) -> DeflectionTotal:
    """Return the total deflection that a nozzle needs at one time of the flight.

    Parameters
    ----------
    vehicle : Vehicle
        One vehicle, at that time.
    wind : float
        Required deflection of the wind [rad]; see `boundary_limit` and `size`. Systematic.
    nominal : float
        Deflection of the nominal flight delta_n [rad]. Systematic.
    dispersion : float
        Contribution of the dispersed vehicle and wind [rad], such as the `required.upper` of
        `disperse_study` less the required deflection of its study. Random.
    thrust_offset : float
        Angle [rad] between the thrust and the axis of the nozzle. Random.
    gravity_offset : float
        Distance [m] of the centre of gravity from the axis of the vehicle. Random.
    others : sequence of Line
        Further lines.
    reserve : float
        Part of the limit that is to stay unused.
    limit : float, optional
        Available deflection [rad].

    Raises
    ------
    InputError
        For a batch of vehicles and numbers out of range.

    Notes
    -----
    An offset moment takes the deflection that balances it, moment/(T l_c) with the control force
    per deflection for T: the thrust offset makes T l_c sin(angle), and the offset of the centre of
    gravity (T - F_A) times its distance, for thrust and axial force pass it by. The attitude
    is held; the drift that a side force starts is left out.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> booster = tv.load_vehicle("configuration-i")
    >>> found = tv.requirement.total_deflection(
    ...     booster, np.radians(0.35), thrust_offset=np.radians(0.25), gravity_offset=0.05,
    ...     reserve=0.2, limit=np.radians(1.0))
    >>> round(float(np.degrees(found.total)), 3), found.sufficient
    (0.626, True)
    """
    errors.instance("vehicle", vehicle, Vehicle, "see load_vehicle")
    errors.single("vehicle", vehicle.batch)
    others = errors.each("others", others, Line, "such as Line('wind tunnel', 0.01)")
    thrust, axial, slope, arm = (  # [N], [N], [N/rad], [m]
        float(np.asarray(x))
        for x in (vehicle.thrust, vehicle.axial_force, vehicle.control_force, vehicle.control_arm)
    )
    deflection = errors.number("nominal", nominal, errors.small_angle("a deflection"), "rad")
    wind = errors.number("wind", wind, errors.finite, "rad")
    dispersion = errors.number("dispersion", dispersion, errors.nonnegative, "rad")
    angle = errors.number("thrust_offset", thrust_offset, errors.small_angle("an angle"), "rad")
    distance = errors.number("gravity_offset", gravity_offset, errors.finite, "m")
    balance = abs((thrust - axial) * distance / (slope * arm))
    lines = (
        Line("nominal flight", abs(deflection)),
        Line("wind", abs(wind)),
        Line("dispersions", dispersion, kind="random"),
        Line("thrust offset", thrust * float(np.sin(abs(angle))) / slope, kind="random"),
        Line("centre of gravity offset", balance, kind="random"),
    )
    time = None if vehicle.time is None else float(np.asarray(vehicle.time))
    return DeflectionTotal((*lines, *others), reserve=reserve, limit=limit, time=time)


def worst_total(
    sizing: Sizing,
    name: Requirement | str,
    *,
    dispersion: float = 0.0,
    rate_limit: float | None = None,
    turbulence: FlightTurbulence | str | None = None,
    **offsets: float | None,
) -> DeflectionTotal:
    """Return the largest total over the flight times of a sizing.

    Parameters
    ----------
    sizing : Sizing
        The winds' requirements; its schedule gives the vehicle and the nominal deflection. Where
        one is not known, the total says so in `not_sized`.
    name : Requirement or str
        Which of its requirements counts as the wind, or its label, such as "K = 1".
    dispersion : float
        What dispersions add, as a part of the wind's requirement: 0.3 is 30 percent.
    rate_limit : float, optional
        Rate limit of the nozzle [rad/s]; the requirement of the wind is then for a ramp at this
        rate.
    turbulence : FlightTurbulence or str, optional
        Turbulence along the flight, whose standard deviations at each flight time are a random
        contribution; or the reason for which it is not known, in words, and the total neither.
    **offsets
        thrust_offset, gravity_offset, reserve and limit; see `total_deflection`.

    Raises
    ------
    InputError
        For an unknown name, numbers out of range, and an infinite requirement.
    """
    totals = totals_over_flight(
        sizing,
        name,
        dispersion=dispersion,
        rate_limit=rate_limit,
        turbulence=turbulence,
        **offsets,
    )
    not_sized = sizing.not_sized(name)
    if isinstance(turbulence, str):
        errors.text("reason", turbulence)
        not_sized = (*not_sized, f"in turbulence: {turbulence}")
    if not totals:
        return DeflectionTotal(
            lines=(),
            reserve=offsets.get("reserve") or 0.0,
            limit=offsets.get("limit"),
            not_sized=not_sized,
            rate_limit=rate_limit,
            needed_rate=np.nan,
        )
    # a time at which no ramp is sufficient is worse than one at which the nozzle is too slow, and
    # that than any other
    worst = max(totals, key=lambda total: (total.no_ramp, total.too_slow, total.total))
    needed = max(total.needed_rate for total in totals)
    # an end of the flight is named only where the totals of all other times are smaller
    others = max((total.total for total in totals if total.time != worst.time), default=np.inf)
    end = flight_end(sizing, worst.time) if worst.total > (1.0 + SAME) * others else ""
    counted = requirement_among("name", name, sizing.required).label
    return replace(worst, not_sized=not_sized, needed_rate=needed, end=end, counted=counted)


def totals_over_flight(
    sizing: Sizing,
    name: Requirement | str,
    *,
    dispersion: float = 0.0,
    rate_limit: float | None = None,
    turbulence: FlightTurbulence | str | None = None,
    **offsets: float | None,
) -> list[DeflectionTotal]:
    """Return the totals of the required deflection of the worst wind and all that adds to it.

    A total for each flight time of the `sizing` at which the requirement `name` is known, and for
    a wind that is fixed in flight time at the time at which its requirement arises. `dispersion`:
    addition of dispersions, 0.3 is 30 percent. `rate_limit`: of the nozzle [rad/s]. `turbulence`:
    a random contribution; a text, the reason for which it is not known, adds nothing here, and
    makes the total of `worst_total` unknown. Same parameters and exceptions as `worst_total`.
    """
    errors.instance("sizing", sizing, Sizing, "see size")
    ratio = errors.number("dispersion", dispersion, errors.nonnegative)
    if rate_limit is not None:
        rate_limit = errors.number("rate_limit", rate_limit, errors.between(*RATES), "rad/s")
    if turbulence is not None and not isinstance(turbulence, str):
        errors.instance("turbulence", turbulence, FlightTurbulence, "see SizingRequest.turbulence")
    needs = _needs(sizing, requirement_among("name", name, sizing.required))
    if never := [time for time, need in needs if np.isinf(need)]:
        raise errors.InputError(
            f"at {never[0]:g} s no limit is sufficient at this dead band, so that there is no"
            " total; take a larger one"
        )
    totals = []
    for t, need in needs:  # required deflection [rad] of the worst wind
        others: tuple[Line, ...] = ()
        if isinstance(turbulence, FlightTurbulence):
            name_of_line = f"turbulence, {turbulence.request.label}"
            others = (Line(name_of_line, turbulence.quantile_at(t), kind="random"),)
        total = total_deflection(
            sizing.schedule.at(t),
            need,
            nominal=float(sizing.schedule.nominal_at(t)),
            dispersion=ratio * need,
            others=others,
            **offsets,  # type: ignore[arg-type]
        )
        # with the rate limit, a ramp that must go to a larger deflection
        totals.append(_at_rate(total, need, _fastest_pole(sizing, t), rate_limit))
    return totals


def _needs(sizing: Sizing, requirement: Requirement) -> list[tuple[float, float]]:
    """Return flight times [s] of a sizing with the requirement [rad] of the worst wind of each.

    A wind that is fixed in flight time has one requirement, at the time at which it arises.
    """
    # time at which the requirement of a wind fixed in flight time arises; NaN for other winds
    arises, required = sizing.arising(requirement), sizing.required[requirement]
    fixed = np.isfinite(arises)
    by_time = np.fmax.reduce(np.where(fixed, np.nan, required), axis=1)
    needs = list(zip(sizing.times.tolist(), by_time.tolist(), strict=True))
    if fixed.any():
        by_wind = np.fmax.reduce(required[:, fixed], axis=0)
        times = np.clip(arises[fixed], *sizing.schedule.span)
        needs += zip(times.tolist(), by_wind.tolist(), strict=True)
    return [(time, need) for time, need in needs if not np.isnan(need)]


def flight_end(sizing: Sizing, time: float | None) -> str:
    """Return which end of the flight of a sizing a worst time [s] is, in words.

    Ends are of the schedule, of a known wind, and of the flight times that are sized. Empty
    between the ends, and without a time.
    """
    if time is None:
        return ""
    for end, beyond, k in (("first", "before", 0), ("last", "after", -1)):  # k: index of the end
        if np.isclose(time, sizing.schedule.span[k], rtol=0.0, atol=_TIME_TOLERANCE):
            return f"the {end} of the schedule: more may be needed {beyond}"
        if np.any(np.isclose(time, sizing.known_times[:, k], rtol=0.0, atol=_TIME_TOLERANCE)):
            return f"the {end} at which a wind is known: more may be needed {beyond}"
        if sizing.times.size > 1 and time == np.sort(sizing.times)[k]:
            return f"the {end} that is sized: more may be needed {beyond}"
    return ""


def _at_rate(
    total: DeflectionTotal, wind: float, pole: float, rate_limit: float | None
) -> DeflectionTotal:
    """Return a total with the contribution of a rate limit [rad/s], and the required rate.

    `wind`: deflection [rad] that the wind requires. `pole`: fastest unstable pole [1/s]; zero
    without one. A ramp reaches its deflection late, and must go to a larger one.
    """
    if rate_limit is None or not wind or not pole:
        return replace(total, rate_limit=rate_limit)
    excess = float(ramped_deflection(wind, pole, rate_limit)) - wind
    needed_rate = pole * wind  # below it no ramp is sufficient, whatever its deflection
    if total.limit is not None:
        others = total.total - wind
        available = (1.0 - total.reserve) * total.limit - others
        needed_rate = float(ramp_rate(wind, pole, available))
    lines = (*total.lines, Line(RATE_LINE, excess)) if np.isfinite(excess) else total.lines
    return replace(total, lines=lines, rate_limit=rate_limit, needed_rate=needed_rate)


def _fastest_pole(sizing: Sizing, time: float) -> float:
    """Return the size of a sizing's fastest unstable pole [1/s] at a flight time [s], or zero."""
    planes = PLANES if sizing.plane == BOTH else (sizing.plane,)
    plants = [sizing.schedule.plants(time, sizing.model, plane) for plane in planes]
    return max(float(np.abs(unstable_modes(plant).poles).max(initial=0.0)) for plant in plants)
