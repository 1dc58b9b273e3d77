"""Criteria for stability margins: requirements with their sources, judgements, and their tables."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from tvclin.base import lines
from tvclin.base.documents import keyed, picked
from tvclin.base.errors import InputError, each, instance, nonnegative, number, one_of, plain, text
from tvclin.base.lines import Line, Table, labelled, significant
from tvclin.base.tables import FileTable
from tvclin.control.margins.bands import GAIN, PHASE, RIGID, BandMargins, ModeBand
from tvclin.control.margins.margins import MARGINS, Margins, factor_to, margin

_OF_MODES = {"mode_gain_margin_dB": "gain_margin_dB", "mode_phase_margin_deg": "phase_margin_deg"}
"""What is asked of each mode, and its name in a `ModeBand`."""
_UNITS = {name: "s" if unit == "ms" else unit for name, (_, unit, _) in MARGINS.items()}
_UNITS |= {"mode_gain_margin_dB": "dB", "mode_phase_margin_deg": "deg"}
CRITERIA_TABLE = FileTable(
    "[criteria]",
    {name: "delay" if unit == "s" else "number" for name, unit in _UNITS.items()},
    words=("name",),
)
_AT_MOST = ("peak_sensitivity", "peak_complementary_sensitivity")
_LAUNCH_VEHICLE = (
    "customary for the rigid-body attitude loop of launch vehicles, on both sides of the gain"
    " when the vehicle is unstable; from course texts, no primary source checked"
)
_AIRCRAFT = (
    "customary for aircraft flight control after the MIL-F-9490 family; from course texts, no"
    " primary source checked"
)


@dataclass(frozen=True)
class Requirement:
    """One number that is asked for.

    Attributes
    ----------
    margin : str
        Name of the attribute of `Margins`, with its unit; "mode_gain_margin_dB" is asked of each
        gain-stabilised mode, "mode_phase_margin_deg" of each phase-stabilised one.
    limit : float
        The least that is asked for; of a peak the most.
    source : str
        Where the number comes from.
    """

    margin: str
    limit: float
    source: str

    as_dict = keyed("margin limit source")

    def __post_init__(self) -> None:
        one_of("margin", self.margin, _UNITS)
        text("source", self.source)
        object.__setattr__(self, "limit", number(self.margin, self.limit, nonnegative))

    @property
    def unit(self) -> str:
        """Unit of the number."""
        return _UNITS[self.margin]

    @property
    def shown(self) -> tuple[float, str]:
        """The limit in the unit that tables show, and that unit."""
        unit = "ms" if self.unit == "s" else self.unit
        return factor_to(unit) * self.limit, unit

    @property
    def name(self) -> str:
        """What is asked for, in words."""
        return self.margin.removesuffix("_dB").removesuffix("_deg").replace("_", " ")

    @property
    def at_most(self) -> bool:
        """Whether the number is an upper limit."""
        return self.margin in _AT_MOST


@dataclass(frozen=True, eq=False)
class Judgement:
    """One margin beside what is asked for; numbers have the shape ``(...)`` of the batch.

    Attributes
    ----------
    requirement : Requirement
        What is asked for.
    value : float or ndarray
        What the loop has; NaN for an unstable one.
    surplus : float or ndarray
        By how much it is met, in its unit; negative where it is not met.
    met : bool or ndarray
        Whether it is met; never for an unstable loop.
    band : str
        Name of the mode of which it is asked; empty for the whole loop.
    """

    requirement: Requirement
    value: Any
    surplus: Any
    met: Any
    band: str = ""

    def as_dict(self) -> dict[str, Any]:
        """Return the record as the command line prints it as JSON; the whole loop is no band."""
        asked = "margin=requirement.margin band limit=requirement.limit value surplus met"
        return picked(self, f"{asked} source=requirement.source") | {"band": self.band or None}


@dataclass(frozen=True)
class Criteria:
    """A named set of requirements, such as ``CRITERIA["classic"]``, or one's own.

    Attributes
    ----------
    name : str
        Name of the set.
    requirements : tuple of Requirement
        What it asks for.
    """

    name: str
    requirements: tuple[Requirement, ...]

    def __post_init__(self) -> None:
        text("name", self.name)
        asked = each("requirements", self.requirements, Requirement, "see Criteria.own")
        object.__setattr__(self, "requirements", asked)
        if not asked:
            raise InputError(f"criteria need a limit: one or more of {', '.join(_UNITS)}")

    @classmethod
    def own(cls, name: str = "own", source: str = "the user", **limits: float) -> Self:
        """Return criteria of one's own.

        Parameters
        ----------
        name : str
            Name of the set.
        source : str
            Where the numbers come from.
        **limits
            aero_margin_dB, gain_increase_dB, phase_margin_deg, delay_margin [s] and disk_margin
            are lower limits, peak_sensitivity and peak_complementary_sensitivity upper ones;
            mode_gain_margin_dB and mode_phase_margin_deg are asked of modes, see `judge`.

        Raises
        ------
        InputError
            For a name that is no margin, no limits, and numbers below zero.

        Examples
        --------
        >>> import tvclin as tv
        >>> dispersed = tv.control.Criteria.own("dispersed", aero_margin_dB=3, phase_margin_deg=20)
        >>> [r.limit for r in dispersed.requirements]
        [3.0, 20.0]
        """
        return cls(name, tuple(Requirement(key, value, source) for key, value in limits.items()))

    def changed(self, source: str, **limits: float) -> "Criteria":
        """Return the criteria with other limits, or further ones, that come from a source.

        Parameters
        ----------
        source : str
            Where the numbers come from.
        **limits
            As of `own`; without any these criteria are as they were.

        Raises
        ------
        InputError
            As `own`.
        """
        if not limits:
            return self
        name = f"{self.name}, changed by {text('source', source)}"
        each = (*self.requirements, *Criteria.own(name, source, **limits).requirements)
        return Criteria(name, tuple({one.margin: one for one in each}.values()))

    @property
    def words(self) -> str:
        """Every requirement with its number, in one line."""
        each = [(one.name, *one.shown) for one in self.requirements]
        return ", ".join(f"{name} {limit:g} {unit}".rstrip() for name, limit, unit in each)

    @property
    def of_modes(self) -> bool:
        """Whether something is asked of modes."""
        return any(one.margin in _OF_MODES for one in self.requirements)

    @property
    def without_modes(self) -> "Criteria | None":
        """What is asked of the whole loop; None where all is asked of modes."""
        kept = tuple(one for one in self.requirements if one.margin not in _OF_MODES)
        return Criteria(self.name, kept) if kept else None

    def judge(self, margins: Margins | BandMargins) -> tuple[Judgement, ...]:
        """Return each margin beside what is asked for.

        Parameters
        ----------
        margins : Margins or BandMargins
            Of one loop or of a batch. By band, the whole loop is judged, and each mode where one
            is asked: that it stays so far below one if it is gain-stabilised, that it has so much
            phase if it is phase-stabilised. Of other modes the value is NaN and the surplus
            infinite, unless the loop is unstable.

        Raises
        ------
        InputError
            For limits of modes on margins without bands.
        """
        if isinstance(margins, BandMargins):
            whole, modes = margins.whole, margins.modes
        else:
            instance("margins", margins, Margins, "see Autopilot.margins")
            whole, modes = margins, ()
        found = []
        for requirement in self.requirements:
            if requirement.margin not in _OF_MODES:
                found.append(_judged(requirement, whole))
            elif isinstance(margins, Margins):
                raise InputError(
                    f"{requirement.margin} is asked of modes; give Autopilot.band_margins in place"
                    " of margins"
                )
            found += [
                _judged_mode(requirement, whole, mode)
                for mode in modes
                if requirement.margin in _OF_MODES
            ]
        return tuple(found)

    def are_met(self, margins: Margins | BandMargins) -> Any:
        """Return whether every requirement is met, ``(...)``."""
        every = [np.asarray(one.met) for one in self.judge(margins)]
        return plain_bool(np.logical_and.reduce(every))


def _judged(requirement: Requirement, margins: Margins) -> Judgement:
    value = np.asarray(getattr(margins, requirement.margin), dtype=float)
    surplus = value - requirement.limit
    surplus = -surplus if requirement.at_most else surplus
    return Judgement(requirement, plain(value), plain(surplus), plain_bool(surplus >= 0.0))


def _judged_mode(requirement: Requirement, whole: Margins, mode: ModeBand) -> Judgement:
    value = np.asarray(getattr(mode, _OF_MODES[requirement.margin]), dtype=float)
    value = np.where(whole.stable, value, np.nan)
    asked = np.asarray(whole.stable) & ~np.isnan(value)
    surplus = np.where(asked, value - requirement.limit, np.where(whole.stable, np.inf, np.nan))
    met = plain_bool((surplus >= 0.0)[()])
    return Judgement(requirement, plain(value), plain(surplus), met, mode.name)


def plain_bool(array: Any) -> Any:
    """Return a Python bool for one answer, and an array for several."""
    return bool(array) if np.ndim(array) == 0 else array


def _both_sides(gain_dB: float, phase_deg: float, name: str, source: str) -> Criteria:
    return Criteria.own(
        name,
        source,
        aero_margin_dB=gain_dB,
        gain_increase_dB=gain_dB,
        phase_margin_deg=phase_deg,
    )


CRITERIA = {
    "classic": _both_sides(6.0, 30.0, "classic", _LAUNCH_VEHICLE),
    "aircraft": _both_sides(6.0, 45.0, "aircraft", _AIRCRAFT),
}
"""The criteria that have a name: 6 dB and 30 deg, 6 dB and 45 deg."""


_WORDS = {RIGID: "rigid"}
_FACTORS = {"aero_margin_dB": "aero_margin", "gain_increase_dB": "gain_increase"}
"""The factors on the gain that stand beside their size in dB."""


def margin_table(found: Margins, judged: Sequence[Judgement] = ()) -> Table:
    """Return the margins of one stable loop, where they are, and by how much criteria are met."""
    asked = {one.requirement.margin: one for one in judged if not one.band}
    rows: list[tuple[Line, ...]] = []
    for name, label, value, unit, frequency in found.rows():
        key = f"margin.{name}"
        at, shown = significant(f"{key}.rad_per_s", frequency), margin(key, value, unit)
        if name in _FACTORS and np.isfinite(value):
            factor = significant(f"{key}.factor", getattr(found, _FACTORS[name]), 3)
            shown = (*shown, " (", *factor, "x)")
        rows.append((labelled(label), shown, at, *_asked(asked.get(name))))
        if name == "disk_margin":
            gain = margin(f"{key}.gain", found.disk_margin_dB, "dB")
            phase = margin(f"{key}.phase", found.disk_phase_deg, "deg")
            rows.append((("  gain and phase",), (*gain, ", ", *phase), ("",), ("",), ("",)))
    return Table("Margins", ("margin", "value", "at [rad/s]", "asked", "by"), tuple(rows))


def band_table(found: BandMargins, judged: Sequence[Judgement] = ()) -> Table:
    """Return what the rigid body has, if the loop is stable, and what each mode has."""
    rows: list[tuple[Line, ...]] = []
    for name, label in zip(MARGINS, ("down", "up", "phase"), strict=False):
        _, unit, where = MARGINS[name]
        at = significant(f"rigid.{name}.rad_per_s", getattr(found.rigid, where))
        spare = margin(f"rigid.{name}", getattr(found.rigid, name), unit)
        rows.append(((f"rigid, {label}",), ("",), at, spare, ("",), ("",)))
    rows = rows if found.whole.stable else []
    asked = {one.band: one for one in judged if one.band and not np.isnan(one.value)}
    rows += [(*_mode(k, one), *_asked(asked.get(one.name))) for k, one in enumerate(found.modes)]
    head = ("band", "held by", "at [rad/s]", "margin", "asked", "by")
    width = len(head) if asked else len(head) - 2
    return Table("Margins by band", head[:width], tuple(row[:width] for row in rows))


def _mode(k: int, mode: ModeBand) -> tuple[Line, ...]:
    key = f"band.{k}"
    spare = {
        GAIN: margin(f"{key}.gain", mode.gain_margin_dB, "dB"),
        PHASE: margin(f"{key}.phase", mode.phase_margin_deg, "deg"),
        RIGID: (*lines.number(f"{key}.distance", mode.distance, 2), " from -1"),
    }
    return (
        (mode.name,),
        (_WORDS.get(mode.stabilised, str(mode.stabilised)),),
        significant(f"{key}.rad_per_s", mode.frequency),
        spare.get(mode.stabilised, ("none",)),
    )


def _asked(one: Judgement | None) -> tuple[Line, Line]:
    """What is asked of a margin, and by how much it is met."""
    if one is None:
        return ("",), ("",)
    limit, unit = one.requirement.shown
    key = f"criteria.{one.band}{'.' * bool(one.band)}{one.requirement.margin}"
    most = ("at most ",) if one.requirement.at_most else ()
    surplus = factor_to(unit) * one.surplus
    by = ("+" if 0.0 <= surplus < np.inf else "", *significant(f"{key}.surplus", surplus, 3))
    return (
        (*most, *significant(key, limit, unit=unit)),
        (*by, " met" if one.met else " NOT MET"),
    )
