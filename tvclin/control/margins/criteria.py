"""Criteria for stability margins: their limits with their sources, judgements, and their tables."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from tvclin.base import lines
from tvclin.base.cards import Record
from tvclin.base.errors import InputError, each, instance, nonnegative, number, one_of, plain, text
from tvclin.base.fields import Field, decibels, spec, specs
from tvclin.base.lines import Line, Table, labelled, significant
from tvclin.base.quantities import satisfaction
from tvclin.base.tables import FileTable
from tvclin.control.margins.bands import GAIN, PHASE, RIGID, BandMargins, ModeBand
from tvclin.control.margins.margins import MARGINS, Margins, margin, unit_factor

_MODE_MARGINS = {
    "mode_gain_margin_dB": "gain_margin_dB",
    "mode_phase_margin_deg": "phase_margin_deg",
}
"""Margins that criteria limit for each mode, and their attributes of `ModeBand`."""
_UNITS = {name: "s" if unit == "ms" else unit for name, (_, unit, _) in MARGINS.items()}
_UNITS |= {"mode_gain_margin_dB": "dB", "mode_phase_margin_deg": "deg"}
CRITERIA_TABLE = FileTable(
    "[criteria]",
    {name: "delay" if unit == "s" else "number" for name, unit in _UNITS.items()},
    words=("name",),
)
_UPPER_LIMITS = ("peak_sensitivity", "peak_complementary_sensitivity")
"""Numbers with an upper limit; all others have a lower limit."""
_LAUNCH_VEHICLE = (
    "customary for the rigid-body attitude loop of launch vehicles, on both sides of the gain"
    " when the vehicle is unstable; from course texts, no primary source checked"
)
_AIRCRAFT = (
    "customary for aircraft flight control after the MIL-F-9490 family; from course texts, no"
    " primary source checked"
)


@dataclass(frozen=True)
class Criterion(Record):
    """Limit of one margin.

    Attributes
    ----------
    margin : str
        Name of the attribute of `Margins`, with its unit; "mode_gain_margin_dB" applies to each
        gain-stabilised mode, "mode_phase_margin_deg" to each phase-stabilised mode.
    limit : float
        Lower limit of the margin; upper limit of a peak.
    source : str
        Source of the number.
    """

    margin: str = field(metadata=spec())
    limit: float = field(metadata=spec())
    source: str = field(metadata=spec())

    def __post_init__(self) -> None:
        """Check the name of the margin and its limit."""
        one_of("margin", self.margin, _UNITS)
        text("source", self.source)
        object.__setattr__(self, "limit", number(self.margin, self.limit, nonnegative))

    @property
    def unit(self) -> str:
        """Unit of the limit: dB, deg, s, or empty."""
        return _UNITS[self.margin]

    @property
    def shown(self) -> tuple[float, str]:
        """Limit in the unit of tables, which is ms for a delay, and that unit."""
        unit = "ms" if self.unit == "s" else self.unit
        return unit_factor(unit) * self.limit, unit

    @property
    def name(self) -> str:
        """Name of the margin without its unit, such as "phase margin"."""
        return self.margin.removesuffix("_dB").removesuffix("_deg").replace("_", " ")

    @property
    def description(self) -> str:
        """Name and limit with its unit, such as "phase margin 30 deg"."""
        limit, unit = self.shown
        return f"{self.name} {limit:g} {unit}".rstrip()

    @property
    def is_upper_limit(self) -> bool:
        """Whether the limit is an upper one."""
        return self.margin in _UPPER_LIMITS


@dataclass(frozen=True, eq=False)
class Judgement(Record):
    """Margin compared with its criterion; numbers have the shape ``(...)`` of the batch.

    Attributes
    ----------
    criterion : Criterion
        Limit of the margin.
    value : float or ndarray
        Margin of the loop; NaN for an unstable loop.
    surplus : float or ndarray
        Distance of the value from the limit, in its unit; negative for an unsatisfied criterion.
    satisfied : bool or ndarray
        Whether the criterion is satisfied; False for an unstable loop.
    band : str
        Name of the mode; empty for the whole loop.
    """

    criterion: Criterion = field(
        metadata=specs(
            Field("margin", of="criterion.margin"),
            Field("limit", of="criterion.limit"),
            Field("source", of="criterion.source"),
        )
    )
    value: Any = field(metadata=spec())
    surplus: Any = field(metadata=spec())
    satisfied: Any = field(metadata=spec())
    band: str = field(default="", metadata=spec(of=lambda judged: judged.band or None))

    @property
    def relative_surplus(self) -> Any:
        """Surplus as a ratio to the limit; to one for a limit of zero."""
        return np.asarray(self.surplus) / (self.criterion.limit or 1.0)

    @property
    def shortfall(self) -> Line:
        """Text on a margin of one loop that misses its limit, as "phase 3 deg short".

        `band`, the name of a mode, takes the place of the margin's name for the margin of a mode.
        """
        _, unit = self.criterion.shown
        label = self.band
        if not label:
            label, *_ = MARGINS[self.criterion.margin]
        shortfall = -unit_factor(unit) * self.surplus
        return (f"{label} ", *significant(f"{label}.shortfall", shortfall, 3, unit), " short")


@dataclass(frozen=True)
class Criteria:
    """Named set of limits, such as ``CRITERIA["classic"]``, or a custom set.

    Attributes
    ----------
    name : str
        Name of the set.
    limits : tuple of Criterion
        Limits of the set.
    base : Criteria, optional
        Set of which limits were replaced, or to which they were added.
    """

    name: str
    limits: tuple[Criterion, ...]
    base: "Criteria | None" = None

    def __post_init__(self) -> None:
        """Check that the set has a name and one or more limits."""
        text("name", self.name)
        if self.base is not None:
            instance("base", self.base, Criteria, 'such as CRITERIA["classic"]')
        limits = each("limits", self.limits, Criterion, "see Criteria.custom")
        object.__setattr__(self, "limits", limits)
        if not limits:
            raise InputError(f"criteria need a limit: one or more of {', '.join(_UNITS)}")

    @classmethod
    def custom(cls, name: str = "own", source: str = "the user", **limits: float) -> Self:
        """Return criteria with limits of the user.

        Parameters
        ----------
        name : str
            Name of the set.
        source : str
            Source of the numbers.
        **limits
            aero_margin_dB, gain_increase_dB, phase_margin_deg, delay_margin [s] and disk_margin
            are lower limits, peak_sensitivity and peak_complementary_sensitivity upper limits;
            mode_gain_margin_dB and mode_phase_margin_deg apply to modes, see `judge`.

        Raises
        ------
        InputError
            For a name that is no margin, no limits, and numbers below zero.

        Examples
        --------
        >>> import tvclin as tv
        >>> limits = {"aero_margin_dB": 3, "phase_margin_deg": 20}
        >>> dispersed = tv.control.Criteria.custom("dispersed", **limits)
        >>> [r.limit for r in dispersed.limits]
        [3.0, 20.0]
        """
        return cls(name, tuple(Criterion(key, value, source) for key, value in limits.items()))

    def with_limits(self, source: str, **limits: float) -> "Criteria":
        """Return the criteria with some limits replaced or added, which their name says.

        `source`: source of their numbers. `limits`: limits by margin, such as phase_margin_deg;
        without any the criteria are unchanged. `InputError` for a name that is no margin, and a
        limit below zero.
        """
        if not limits:
            return self
        limits_of_source = Criteria.custom(self.name, source, **limits).limits
        by_margin = {r.margin: r for r in (*self.limits, *limits_of_source)}
        return _changed(self.base or self, tuple(by_margin.values()))

    @property
    def description(self) -> str:
        """Names and limits of all criteria, in one line."""
        return ", ".join(r.description for r in self.limits)

    @property
    def has_mode_limits(self) -> bool:
        """Whether a criterion applies to modes."""
        return any(r.margin in _MODE_MARGINS for r in self.limits)

    @property
    def has_delay_limit(self) -> bool:
        """Whether a criterion limits the delay margin."""
        return any(r.margin == "delay_margin" for r in self.limits)

    @property
    def without_mode_limits(self) -> "Criteria | None":
        """Criteria with the limits of the whole loop alone; None if there are none."""
        loop = tuple(r for r in self.limits if r.margin not in _MODE_MARGINS)
        if not loop or not self.has_mode_limits:
            return self if loop else None
        base = self.base and self.base.without_mode_limits
        return _changed(base, loop) if base else Criteria(self.name, loop)

    def judge(self, margins: Margins | BandMargins) -> tuple[Judgement, ...]:
        """Return the judgement of each margin, in the order of the criteria.

        `margins`: of one loop or a batch. With bands, a limit of modes applies to each mode: the
        gain margin to gain-stabilised modes, the phase margin to phase-stabilised modes. For other
        modes the value is NaN and the surplus infinite, unless the loop is unstable. `InputError`
        for limits of modes on margins without bands.
        """
        if isinstance(margins, BandMargins):
            loop, modes = margins.margins, margins.modes
        else:
            instance("margins", margins, Margins, "see Autopilot.margins")
            loop, modes = margins, ()
        judgements = []
        for criterion in self.limits:
            if criterion.margin not in _MODE_MARGINS:
                judgements.append(_judge(criterion, loop))
            elif isinstance(margins, Margins):
                raise InputError(
                    f"{criterion.margin} is a criterion of modes; give Autopilot.band_margins in"
                    " place of margins"
                )
            else:
                judgements += [_judge(criterion, loop, mode) for mode in modes]
        return tuple(judgements)

    def are_satisfied(self, margins: Margins | BandMargins) -> Any:
        """Return whether `margins` satisfy every criterion: bool, ``(...)`` of a batch."""
        verdicts = [np.asarray(judgement.satisfied) for judgement in self.judge(margins)]
        return plain_bool(np.logical_and.reduce(verdicts))


def _changed(base: Criteria, limits: tuple[Criterion, ...]) -> Criteria:
    """Return the criteria `limits`, named as `base` and the limits that it has not."""
    changes = ", ".join(r.description for r in limits if r not in base.limits)
    return Criteria(f"{base.name}, with {changes}", limits, base) if changes else base


def _judge(criterion: Criterion, loop: Margins, mode: ModeBand | None = None) -> Judgement:
    """Return the judgement by `criterion` of a margin of a whole `loop`, or of one of its modes.

    `loop`: margins of one loop or a batch. NaN, of an unstable loop, never satisfies a criterion.
    Where a `mode` has no such margin, as it is stabilised otherwise, its value is NaN and the
    surplus infinite.
    """
    if mode is None:
        value = np.asarray(getattr(loop, criterion.margin), dtype=float)
    else:
        value = np.where(loop.stable, getattr(mode, _MODE_MARGINS[criterion.margin]), np.nan)
    surplus = value - criterion.limit
    surplus = -surplus if criterion.is_upper_limit else surplus
    if mode is not None:
        surplus = np.where(loop.stable & np.isnan(value), np.inf, surplus)[()]
    band = "" if mode is None else mode.name
    return Judgement(criterion, plain(value), plain(surplus), plain_bool(surplus >= 0.0), band)


def plain_bool(array: Any) -> Any:
    """Return a Python bool for an array of shape ``()``, and other arrays unchanged."""
    return bool(array) if np.ndim(array) == 0 else array


CRITERIA = {
    name: Criteria.custom(
        name, source, aero_margin_dB=6.0, gain_increase_dB=6.0, phase_margin_deg=phase_deg
    )
    for name, phase_deg, source in (
        ("classic", 30.0, _LAUNCH_VEHICLE),
        ("aircraft", 45.0, _AIRCRAFT),
    )
}
"""Criteria by name: 6 dB and 30 deg, 6 dB and 45 deg."""


def margin_table(margins: Margins, judged: Sequence[Judgement] = ()) -> Table:
    """Return the table of margins of one stable loop, their frequencies, limits and surplus.

    `judged`: judgements of these margins; without one for a margin its last two cells are empty.
    """
    by_margin = {j.criterion.margin: j for j in judged if not j.band}
    rows: list[tuple[Line, ...]] = []
    for name, label, value, unit, frequency in margins.rows():
        key = f"margin.{name}"
        frequency_cell = significant(f"{key}.rad_per_s", frequency)
        value_cell = margin(key, value, unit)
        if unit == "dB" and np.isfinite(value):  # also as a factor
            factor = significant(f"{key}.factor", getattr(margins, name.removesuffix("_dB")), 3)
            value_cell = (*value_cell, " (", *factor, "x)")
        limit_cells = _limit_cells(by_margin.get(name))
        rows.append((labelled(label), value_cell, frequency_cell, *limit_cells))
        if name == "disk_margin":
            gain = margin(f"{key}.gain", margins.disk_margin_dB, "dB")
            phase = margin(f"{key}.phase", margins.disk_phase_deg, "deg")
            rows.append((("  gain and phase",), (*gain, ", ", *phase), ("",), ("",), ("",)))
    return Table("Margins", ("margin", "value", "at [rad/s]", "required", "by"), tuple(rows))


def band_table(bands: BandMargins, judged: Sequence[Judgement] = ()) -> Table:
    """Return the table of margins by band: the rigid body, if the loop is stable, and each mode.

    A mode that sets a gain margin of the whole loop has a further row for it. `judged`: judgements
    of criteria; if they are about a mode, its last two columns are the required margin and the
    surplus. Without any the table lacks these columns.
    """
    rows: list[tuple[Line, ...]] = []
    # the first three margins: gain may fall, gain may rise, phase
    for name, label in zip(MARGINS, ("down", "up", "phase"), strict=False):
        _, unit, frequency = MARGINS[name]
        at = significant(f"rigid.{name}.rad_per_s", getattr(bands.rigid, frequency))
        value = margin(f"rigid.{name}", getattr(bands.rigid, name), unit)
        rows.append(((f"rigid {label}",), ("",), at, value, ("",), ("",)))
    rows = rows if bands.margins.stable else []
    # the band of a judgement is the name of a mode, or empty for the whole loop
    by_mode = {j.band: j for j in judged if j.band and not np.isnan(j.value)}
    for k, mode in enumerate(bands.modes):
        rows.append((*_mode_cells(k, mode), *_limit_cells(by_mode.get(mode.name))))
        rows += [(*cells, ("",), ("",)) for cells in _gain_cells(k, mode, bands.margins)]
    head = ("band", "held by", "at [rad/s]", "margin", "required", "by")
    width = len(head) if by_mode else len(head) - 2
    return Table("Margins by band", head[:width], tuple(row[:width] for row in rows))


def _mode_cells(k: int, mode: ModeBand) -> tuple[Line, ...]:
    """Return the cells of a mode in the table of bands: name, stabilisation, frequency and margin.

    `k`: index of the mode, for the keys of the numbers. The margin is the gain or phase margin, or
    the distance of L from -1 for a mode that is stable with the rigid body.
    """
    key = f"band.{k}"
    margins = {
        GAIN: margin(f"{key}.gain", mode.gain_margin_dB, "dB"),
        PHASE: margin(f"{key}.phase", mode.phase_margin_deg, "deg"),
        RIGID: (*lines.number(f"{key}.distance", mode.distance, 2), " from -1"),
    }
    crossover = np.isfinite(mode.crossover_frequency)
    return (
        (mode.name,),
        ("rigid" if mode.stabilised == RIGID else str(mode.stabilised),),
        significant(f"{key}.rad_per_s", mode.crossover_frequency if crossover else mode.frequency),
        margins.get(mode.stabilised, ("none",)),
    )


def _gain_cells(k: int, mode: ModeBand, loop: Margins) -> Iterator[tuple[Line, ...]]:
    """Yield the rows of a mode's gain margins that decide the whole loop's, at most two.

    "down" is the factor by which the gain may fall, "up" by which it may rise. The cells are name,
    no phase, frequency and margin [dB]. `k`: index of the mode, for the keys of the numbers.
    `loop`: margins of the whole loop.
    """
    margins = {"reduction": ("down", loop.aero_margin), "increase": ("up", loop.gain_increase)}
    for change, (label, of_loop) in margins.items():
        factor = getattr(mode, f"gain_{change}")
        if np.isfinite(factor) and factor == of_loop:
            key = f"band.{k}.gain_{change}"
            at = significant(f"{key}.rad_per_s", getattr(mode, f"gain_{change}_frequency"))
            yield (f"{mode.name} {label}",), ("",), at, margin(key, decibels(factor), "dB")


def _limit_cells(judgement: Judgement | None) -> tuple[Line, Line]:
    """Return the limit of a margin, and its surplus with the verdict; empty without judgement.

    The key of both numbers has the mode of the margin, `band`, which is empty for the whole loop.
    """
    if judgement is None:
        return ("",), ("",)
    criterion = judgement.criterion
    limit, unit = criterion.shown
    key = f"criteria.{judgement.band}{'.' * bool(judgement.band)}{criterion.margin}"
    prefix = ("at most ",) if criterion.is_upper_limit else ()
    surplus = unit_factor(unit) * judgement.surplus
    sign = "+" if 0.0 <= surplus < np.inf else ""
    verdict = f" {satisfaction(judgement.satisfied)}"
    return (
        (*prefix, *significant(key, limit, unit=unit)),
        (sign, *significant(f"{key}.surplus", surplus, 3), verdict),
    )
