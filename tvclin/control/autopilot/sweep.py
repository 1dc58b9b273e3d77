"""Sweep of a loop over the flight: margins by band, poles, criteria and detuned modes by time."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.schedule import FlightSchedule
from tvclin.base import errors
from tvclin.base.arrays import BoolArray, ComplexArray, FloatArray
from tvclin.base.cards import Column, Columns, Tabled, table
from tvclin.base.fields import derived, spec
from tvclin.base.lines import Line, Table, number, significant, text
from tvclin.base.quantities import satisfaction
from tvclin.control.autopilot.autopilot import Autopilot, warn_of_feedback, warn_of_sampling
from tvclin.control.autopilot.detuning import mode_changes, structure_with_mode_factors
from tvclin.control.autopilot.gain_schedule import GainSchedule, autopilot_along
from tvclin.control.margins.bands import BandMargins, ModeBand, band_margins
from tvclin.control.margins.criteria import CRITERIA, Criteria, Judgement
from tvclin.control.margins.loop import Loop, poles_in_s
from tvclin.control.margins.margins import MARGINS, Margins, margins_of, unit_factor
from tvclin.linear.flexible import AnyPlant, FlexiblePlant, named_modes, plant_of
from tvclin.linear.plant import DEFAULT_MODEL, Plant
from tvclin.vehicle.vehicle import at_pressure

_COLUMNS = ("aero_margin_dB", "gain_increase_dB", "phase_margin_deg", "disk_margin")
"""Margins of the whole loop in a CSV."""
_MAX_MODE_COLUMNS = 2
"""Largest number of modes with columns of their own in the table by flight time."""


class WorstMargin(NamedTuple):
    """Margin with the smallest surplus over a sweep.

    `margin`: name of the margin, with its mode and `change`. `value`: in the unit of the criterion;
    NaN for an unstable loop. `time`: time of flight [s]. `relative_surplus`: distance from the
    limit over the limit; minus infinity for an unstable loop. `satisfied`: whether the criterion is
    satisfied at all times. `change`: of a mode, as "first x 0.9"; empty for the nominal loop.
    """

    margin: str
    value: float
    time: float
    relative_surplus: float
    satisfied: bool
    change: str


@dataclass(frozen=True, eq=False)
class Sweep(Tabled):
    """Margins of a loop over the flight, each time as if frozen.

    Attributes
    ----------
    times : ndarray
        Times of flight [s], ``(n,)``.
    margins : Margins
        Margins of the whole loop, ``(n,)``; delay margins only where a criterion limits them.
    modes : tuple of ModeBand
        Margins of each bending mode and tank by its name in the flight, ``(n,)``.
    poles : ndarray
        Closed-loop poles [1/s], ``(n, k)``; log(z)/h of a loop in samples of h. NaN fills the rows.
    criteria : Criteria
        Criteria of the margins.
    judgements : tuple of Judgement
        Judgements ``(n,)`` in the order of the criteria, of the loop and of its modes.
    changes : tuple of str
        Changes of single modes, such as "first x 0.9".
    detuned : Margins or None
        Margins of the whole loop with each change, ``(changes, n)``.
    detuned_judgements : tuple of Judgement
        Judgements of these, ``(changes, n)``.
    """

    times: FloatArray = field(metadata=spec("time"))
    margins: Margins = field(metadata=spec(document=False))
    modes: tuple[ModeBand, ...] = field(metadata=spec(of=lambda s: s.mode_names))
    poles: ComplexArray = field(metadata=spec(card=False))
    criteria: Criteria = field(metadata=spec(of="criteria.name"))
    judgements: tuple[Judgement, ...] = field(metadata=spec(document=False, card=False))
    changes: tuple[str, ...] = field(metadata=spec())
    detuned: Margins | None = None
    detuned_judgements: tuple[Judgement, ...] = ()

    @property
    def mode_names(self) -> tuple[str, ...]:
        """Names of the modes and tanks."""
        return tuple(mode.name for mode in self.modes)

    @property
    @derived()
    def satisfied(self) -> BoolArray:
        """Whether all criteria are satisfied at each time, with every changed mode, ``(n,)``."""
        # Judgements ``(n,)`` of the nominal loop and ``(changes, n)`` of changed ones.
        verdicts = [
            np.asarray(judged.satisfied).reshape(-1, self.times.size).all(axis=0)
            for judged in self._judged
        ]
        return np.asarray(np.logical_and.reduce(verdicts))

    @property
    @derived()
    def all_satisfied(self) -> bool:
        """Whether all criteria are satisfied at all times, with every change."""
        return bool(np.all(self.satisfied))

    @property
    def minimum_damping(self) -> FloatArray:
        """Smallest damping ratio of the oscillating closed-loop poles at each time, ``(n,)``.

        NaN without one.
        """
        oscillating = np.where(self.poles.imag > 0.0, self.poles, np.nan)
        with np.errstate(invalid="ignore"):
            ratios = -oscillating.real / np.abs(oscillating)
        ratios = np.where(np.isnan(ratios), np.inf, ratios).min(axis=-1, initial=np.inf)
        return np.where(np.isinf(ratios), np.nan, ratios)

    @property
    def worst(self) -> tuple[WorstMargin, ...]:
        """Margin with the smallest surplus over the flight for each judgement of a criterion.

        First of the nominal loop and its modes, then of loops with changed modes.
        """
        nominal = (_worst(judged, self.times) for judged in self.judgements)
        changed = (_worst(judged, self.times, self.changes) for judged in self.detuned_judgements)
        return (*nominal, *changed)

    def table(self) -> Table:
        """Return the table of the worst of each margin, its time and its limit."""
        rows: list[tuple[Line, ...]] = []
        # `_judged` has the criterion of each margin
        for k, (worst, judged) in enumerate(zip(self.worst, self._judged, strict=True)):
            unit, key = judged.criterion.unit, f"sweep.worst.{k}"
            value: Line = ("-",)
            time: Line = ("-",)
            if worst.relative_surplus < np.inf:  # infinite: no mode has this margin
                value = number(f"{key}.value", worst.value, 2, unit)
                time = significant(f"{key}.time", worst.time)
            if np.isneginf(worst.relative_surplus):
                value = ("unstable",)
            limit = significant(f"{key}.limit", judged.criterion.limit, 4, unit)
            rows.append(((worst.margin,), value, time, limit, (satisfaction(worst.satisfied),)))
        minimum = self.minimum_damping
        if np.any(np.isfinite(minimum)):
            lowest = int(np.nanargmin(minimum))
            damping = significant("sweep.damping", minimum[lowest], 3)
            time = significant("sweep.damping.time", self.times[lowest])
            rows.append((("damping of the poles",), damping, time, ("",), ("",)))
        head = ("margin", "worst", "at [s]", "required", "")
        return Table("Worst margins over the flight", head, tuple(rows))

    @property
    def verdict(self) -> str:
        """Verdict on the criteria, with the margin of the largest shortfall and its time."""
        head = f"criteria {self.criteria.name}: {satisfaction(self.all_satisfied)}"
        count = f"{self.times.size} flight times"
        if self.all_satisfied:
            return f"{head} at {count}"
        pairs = zip(self.worst, self._judged, strict=True)  # smallest surplus, and its criterion
        missed = [(worst, judged) for worst, judged in pairs if not worst.satisfied]
        worst, judged = min(missed, key=lambda pair: pair[0].relative_surplus)
        limit, unit = judged.criterion.shown
        shown = text(number("value", unit_factor(unit) * worst.value, 2, unit))
        of_all = f"(NOT MET at {np.sum(~self.satisfied)} of {count})"
        if np.isneginf(worst.relative_surplus):
            shown = "the loop is unstable" + f" with {worst.change}" * bool(worst.change)
            return f"{head}, {shown} at {worst.time:.4g} s {of_all}"
        against = f"limit {limit:g} {unit}".rstrip()
        return f"{head}, {worst.margin}: {shown} at {worst.time:.4g} s, {against} {of_all}"

    @property
    def _judged(self) -> tuple[Judgement, ...]:
        """Judgements of the nominal loop, then of loops with a changed mode."""
        return (*self.judgements, *self.detuned_judgements)

    def time_table(self, rows: int | None = None) -> Table:
        """Return the table of the margins by flight time, and of those with one mode changed.

        `rows`: largest number of even flight times, to which the worst times are added; by
        default all. "detuned" is the smallest margin with a changed mode over its limit. Raises
        `InputError` for rows that are no whole number.
        """
        shown = np.arange(self.times.size)
        if rows is not None and shown.size > errors.whole_number("rows", rows):
            worst = [int(np.argmin(np.abs(self.times - w.time))) for w in self.worst]
            shown = np.unique([*np.linspace(0, shown[-1], rows).round().astype(int), *worst])
        columns = self._by_time()
        cells: list[tuple[Line, ...]] = []
        for k in shown:
            values = (number(f"sweep.{k}.{name}", column[k], 2) for name, column in columns.items())
            verdict = satisfaction(bool(self.satisfied[k]))
            cells.append((significant(f"sweep.{k}.time", self.times[k]), *values, (verdict,)))
        count = ""
        if shown.size < self.times.size:
            which = f"{rows} about evenly, and the worst of each margin"
            count = f", {shown.size} of {self.times.size}: {which}"
        return Table(
            f"Margins by flight time{count}", ("at [s]", *columns, "criteria"), tuple(cells)
        )

    def _by_time(self) -> dict[str, FloatArray]:
        """Return the columns of the table by flight time, ``(n,)``, by their headings.

        Margins of the loop [dB, deg] and of its modes, of more than two modes the smallest; and
        "detuned": smallest ratio of a margin with a changed mode to its limit, NaN for an unstable
        loop.
        """
        margins = {
            "gain down [dB]": self.margins.aero_margin_dB,
            "gain up [dB]": self.margins.gain_increase_dB,
            "phase [deg]": self.margins.phase_margin_deg,
        }
        for unit, name in (("dB", "gain_margin_dB"), ("deg", "phase_margin_deg")):
            of_modes = {
                f"{mode.name} [{unit}]": np.asarray(getattr(mode, name), float)
                for mode in self.modes
            }
            if len(of_modes) > _MAX_MODE_COLUMNS:
                of_modes = {f"worst mode [{unit}]": np.fmin.reduce(list(of_modes.values()))}
            margins |= of_modes
        columns = {
            name: np.asarray(values)
            for name, values in margins.items()
            if np.any(np.isfinite(values))
        }
        if self.detuned_judgements:
            ratios = [
                np.reshape(judged.relative_surplus, (-1, self.times.size))
                for judged in self.detuned_judgements
            ]
            lowest = np.concatenate(ratios).min(axis=0)  # NaN for an unstable loop
            # Margin over limit is one plus the surplus over the limit.
            columns["detuned"] = np.where(np.isinf(lowest), np.nan, 1.0 + lowest)
        return columns

    def _repr_html_(self) -> str:
        """Return the table of the worst margins, for a notebook."""
        return table(self.table())

    def _columns(self) -> Columns:
        """Return the margins at each flight time as columns of a CSV.

        Of the loop, of each mode, and the smallest with a changed mode; NaN where it is unstable.
        """
        axis = Column("time", self.times, "s")
        columns = [Column("status", np.asarray(self.margins.status), "")]
        columns += [_margin_column(name, getattr(self.margins, name)) for name in _COLUMNS]
        for mode in self.modes:
            key = mode.name.replace(" ", "_")
            columns += [
                Column(f"{key}_held_by", np.asarray(mode.stabilised), ""),
                Column(f"{key}_frequency", np.asarray(mode.frequency), "rad/s"),
                Column(f"{key}_gain_margin", np.asarray(mode.gain_margin_dB), "dB"),
                Column(f"{key}_phase_margin", np.radians(mode.phase_margin_deg), "rad"),
            ]
        columns.append(Column("minimum_damping", self.minimum_damping))
        if self.detuned is not None:
            for name in _COLUMNS:
                values = np.asarray(getattr(self.detuned, name))
                lowest = np.where(np.any(np.isnan(values), axis=0), np.nan, values.min(axis=0))
                columns.append(_margin_column(f"detuned_{name}", lowest))
        columns.append(Column("satisfied", self.satisfied, ""))
        return Columns((axis,), tuple(columns), {"criteria": self.criteria.name})


def _margin_column(name: str, values: FloatArray) -> Column:
    """Return the CSV column of a margin: its name without unit, values ``(n,)``, and the unit.

    `name`: of the margin, as "phase_margin_deg", "aero_margin_dB" or "disk_margin". Degrees become
    radians, as columns are in SI units.
    """
    key, _, unit = name.rpartition("_")
    if unit == "deg":
        return Column(key, np.radians(values), "rad")
    if unit == "dB":
        return Column(key, np.asarray(values), unit)
    return Column(name, np.asarray(values))


def _worst(judged: Judgement, times: FloatArray, changes: tuple[str, ...] = ("",)) -> WorstMargin:
    """Return the margin with the smallest surplus over flight times and detuned modes.

    Unstable loops precede all others. `judged`: margins of one criterion, by change and n times,
    ``(..., n)``. `times`: flight times [s], ``(n,)``. `changes`: names of the changes of modes, one
    for each value of the leading axis; one empty name for the nominal loop.
    """
    surplus = np.nan_to_num(judged.relative_surplus, nan=-np.inf, posinf=np.inf)
    smallest = int(np.argmin(surplus))
    row, column = divmod(smallest, times.size)  # of a change and a time
    # the label of a margin of the loop, or the name of a margin of modes
    label, *_ = MARGINS.get(judged.criterion.margin, (judged.criterion.name,))
    return WorstMargin(
        margin=", ".join(filter(None, [label, judged.band, changes[row]])),
        value=float(np.ravel(judged.value)[smallest]),
        time=float(times[column]),
        relative_surplus=float(np.ravel(surplus)[smallest]),
        satisfied=bool(np.all(judged.satisfied)),
        change=changes[row],
    )


def plants_along(
    flight: FlightSchedule,
    times: FloatArray,
    model: str,
    plane: str,
    pressure: FloatArray | float = 1.0,
) -> AnyPlant:
    """Return the plants of a flight at times [s] ``(n,)``, flexible where it has a structure.

    `model`, `plane`: model and plane of the motion. `pressure`: dynamic pressure over the nominal
    one, q/q_n, ``(n,)``.
    """
    return plant_of(at_pressure(flight.at(times), pressure), model, plane)


def sweep(
    flight: FlightSchedule,
    autopilot: Autopilot | GainSchedule,
    times: ArrayLike,
    *,
    criteria: Criteria = CRITERIA["classic"],
    factors: ArrayLike = (0.9, 1.1),
    model: str = DEFAULT_MODEL,
    plane: str = "pitch",
) -> Sweep:
    """Return the margins of a loop at times of the flight, nominal and with detuned modes.

    Parameters
    ----------
    flight : FlightSchedule
        Flight, with its structure and actuator where it has them.
    autopilot : Autopilot or GainSchedule
        One autopilot for all times, or its schedule.
    times : array_like
        Times of flight [s], ``(n,)``.
    criteria : Criteria
        Criteria of the margins, of the loop and of modes.
    factors : array_like
        Factors on the frequency of one mode or tank at a time, positive; empty for none. A notch
        that follows a mode stays at the nominal frequency.
    model : {"fixed-path", "drift", "drift-exact", "drift-and-speed"}
        Model of the motion; "drift" without a structure alone.
    plane : {"pitch", "yaw"}
        Plane of the motion.

    Raises
    ------
    InputError
        For times outside the flight, factors that are not positive, criteria of modes without a
        structure, and in the same cases as `Autopilot.exact_loop`.

    Warns
    -----
    UserWarning
        In the same cases as `Autopilot.margins`.

    Notes
    -----
    Each time is judged as if frozen: margins at every time are no proof of the flight, see
    `fly_along`.
    """
    errors.instance("flight", flight, FlightSchedule, "see load_schedule")
    errors.instance("criteria", criteria, Criteria, "see Criteria.custom")
    time = errors.times_row("times", times)
    if not time.size:
        raise errors.InputError("times must be one or more times of flight in s")
    row = errors.finite("factors", factors)
    row = errors.positive("factors", errors.one_row("factors", row)) if row.size else np.zeros(0)
    if isinstance(autopilot, Autopilot) and autopilot.batch:
        raise errors.InputError("autopilot must be one autopilot for all times, or a GainSchedule")
    autopilots = autopilot_along(autopilot, flight, time)
    plants = plants_along(flight, time, model, plane)
    if flight.structure is None:
        names, _ = named_modes(plants)
    else:  # over time: with its own names of modes and tanks
        names = (*flight.structure.modes, *flight.structure.tanks)
    if criteria.has_mode_limits and not names:
        raise errors.InputError("criteria of modes need a flight with a structure over time")
    loop = autopilots.exact_loop(plants)
    warn_of_feedback(autopilots, plants)
    warn_of_sampling(autopilots, plants)
    bands = _bands(loop, plants, names, delays=criteria.has_delay_limit)
    changes: tuple[str, ...] = ()
    detuned: Margins | None = None
    detuned_judgements: tuple[Judgement, ...] = ()
    if row.size and isinstance(plants, FlexiblePlant):
        # Of all changes those of frequencies, which follow the nominal row.
        rows = slice(1, 1 + len(names) * row.size)
        all_changes, *mode_factors = mode_changes(names, len(plants.structure.bending), row)
        changes = all_changes[rows]
        factors_of_rows = (array[rows, np.newaxis] for array in mode_factors)
        structure = structure_with_mode_factors(plants.structure, *factors_of_rows)
        varied = replace(plants, structure=structure)
        judged_names = names if criteria.has_mode_limits else ()
        varied_loop = autopilots.exact_loop(varied)
        varied_bands = _bands(varied_loop, varied, judged_names, delays=criteria.has_delay_limit)
        detuned, detuned_judgements = varied_bands.margins, criteria.judge(varied_bands)
    return Sweep(
        times=time,
        margins=bands.margins,
        modes=bands.modes,
        poles=poles_in_s(loop),
        criteria=criteria,
        judgements=criteria.judge(bands),
        changes=changes,
        detuned=detuned,
        detuned_judgements=detuned_judgements,
    )


def _bands(loop: Loop, plants: AnyPlant, names: tuple[str, ...], delays: bool) -> BandMargins:
    """Return the margins of whole loops around `plants`, and in the frequency band of each mode.

    Rigid plants have the margins of the whole loop alone. `names`: names of the bending modes and
    tanks of the flight, empty without any. `delays`: whether delay margins are computed.
    """
    if isinstance(plants, Plant) or not names:
        margins = margins_of(loop.analysis(delays=delays), loop)
        return BandMargins(margins, rigid=None, modes=())  # type: ignore[arg-type]
    _, poles = named_modes(plants)
    return band_margins(loop, names, poles, delays=delays)
