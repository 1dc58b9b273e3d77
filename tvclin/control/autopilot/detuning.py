"""The margins of a loop whose modes have other frequencies, damping or slopes than assumed.

A mode's frequency is moved and its displacements, slopes and modal mass kept, so that what it gives
at low frequencies falls as 1/omega^2. Texts that keep a modal gain find other numbers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.base.cards import table
from tvclin.base.documents import picked
from tvclin.base.errors import InputError, instance, one_of, one_row, positive, single
from tvclin.base.lines import Line, Table, number
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.margins.bands import BandMargins
from tvclin.control.margins.criteria import CRITERIA, Criteria
from tvclin.control.margins.margins import MARGINS, Margins, loop_margins
from tvclin.linear.flexible import FlexiblePlant
from tvclin.linear.flexible_modes import named_modes
from tvclin.numerics.loop_margins import stability
from tvclin.vehicle.structure import SloshTank

_SHOWN = {"aero_margin_dB": "down", "gain_increase_dB": "up", "phase_margin_deg": "phase"}
"""The margins of a table, and their headings."""
_SEARCHED, _HALVED = 41, 20
"""So many factors on a frequency are tried between the least and the largest, and how often the
interval is halved in which the loop becomes unstable."""

_NAMED = 3
"""Changes named in a verdict, at the most."""


@dataclass(frozen=True, eq=False)
class Edge:
    """The factors on the frequency of a mode, nearest to one, at which the loop becomes unstable.

    NaN where it stays stable as far as it was asked.
    """

    name: str
    lower: float
    upper: float


@dataclass(frozen=True, eq=False)
class Detuned:
    """Margins of a loop with detuned modes; one row for each change, the first without any.

    Attributes
    ----------
    changes : tuple of str
        What is changed in each row.
    margins : Margins
        Those of the rows, ``(n,)``.
    first : tuple of str
        The margin of each row that lacks most, or has least to spare, over what is asked for, of a
        mode with its name, "mode_gain_margin_dB of bending 1"; "unstable" where there are none.
    met : ndarray of bool
        Whether each row has all that is asked for, ``(n,)``.
    edges : tuple of Edge
        Where the loop becomes unstable, mode by mode.
    plants : FlexiblePlant
        The changed plants, ``(n,)``, as for `Autopilot.band_margins`.
    """

    changes: tuple[str, ...]
    margins: Margins
    first: tuple[str, ...]
    met: BoolArray
    edges: tuple[Edge, ...]
    plants: FlexiblePlant

    @property
    def all_met(self) -> bool:
        """Whether each row has all that is asked for."""
        return bool(np.all(self.met))

    @property
    def verdict(self) -> str:
        """MET, or NOT MET with the number of changes that miss the criteria and the first few."""
        missed = [name for name, met in zip(self.changes, self.met, strict=True) if not met]
        if not missed:
            return "MET"
        more = ", ..." if len(missed) > _NAMED else ""
        shown = ", ".join(missed[:_NAMED])
        return f"NOT MET in {len(missed)} of {len(self.changes)} rows ({shown}{more})"

    def row(self, change: str) -> int:
        """Return the place of a row by what is changed in it."""
        return self.changes.index(one_of("change", change, self.changes))

    def as_dict(self) -> dict[str, Any]:
        """Return the record as the command line prints it as JSON, angles in degrees."""
        names = "status aero_margin_dB gain_increase_dB phase_margin_deg delay_margin_s"
        columns = {
            "change": self.changes,
            **picked(self.margins, names),
            **picked(self, "first met"),
        }
        rows = zip(*columns.values(), strict=True)
        return {
            "rows": [dict(zip(columns, row, strict=True)) for row in rows],
            "edges": self.edges,
            "met": self.all_met,
        }

    def table(self) -> Table:
        """Return the margins of each row, what fails first in it, and whether criteria are met."""
        m, rows = self.margins, []
        for k, change in enumerate(self.changes):
            numbers = (number(f"detuned.{k}.{name}", getattr(m, name)[k], 2) for name in _SHOWN)
            first = (_failing(self.first[k]),)
            short = change.replace(" at the sensors", "").replace("half its", "half")
            rows.append(((short,), *numbers, first, ("met" if self.met[k] else "NOT MET",)))
        head = ("change", *_SHOWN.values(), "fails first", "asked")
        return Table("Margins with one mode detuned, in dB and deg", head, tuple(rows))

    @property
    def said(self) -> tuple[Line, ...]:
        """At which frequencies of a mode the loop becomes unstable, a line for each mode."""
        said = []
        for j, edge in enumerate(self.edges):
            sides = {"lower": edge.lower, "upper": edge.upper}
            shown = [number(f"edge.{j}.{k}", at) for k, at in sides.items() if np.isfinite(at)]
            if shown:
                line = shown[0] if len(shown) == 1 else (*shown[0], " and ", *shown[1])
                said.append((f"{edge.name}: unstable at ", *line, " of its frequency"))
        return tuple(said) or (("The loop becomes unstable at no frequency between these.",),)

    def _repr_html_(self) -> str:
        return table(self.table(), self.said)


def _failing(name: str) -> str:
    """The name of a margin in the words of the headings; "bending 1, gain" of a mode."""
    what, _, mode = name.partition(" of ")
    if mode:
        return f"{mode}, {'gain' if 'gain' in what else 'phase'}"
    return _SHOWN.get(name) or (MARGINS[name][0] if name in MARGINS else name.upper())


def detuned(
    autopilot: Autopilot,
    plant: FlexiblePlant,
    factors: ArrayLike = (0.8, 0.9, 1.1, 1.2),
    criteria: Criteria = CRITERIA["classic"],
) -> Detuned:
    """Return the margins with each mode's frequency off, damping halved, or slopes reversed.

    Parameters
    ----------
    autopilot : Autopilot
        One.
    plant : FlexiblePlant
        One, with a bending mode or a tank.
    factors : array_like
        On the frequency of one bending mode or tank after the other, positive, ``(n,)``. Between
        the least and the largest the loop is searched for where it becomes unstable.
    criteria : Criteria
        What is asked for, of modes too.

    Raises
    ------
    InputError
        For a batch, a plant without modes, factors that are not positive, and what
        `Autopilot.exact_loop` refuses.

    Notes
    -----
    Further rows: the damping of each halved, and the slopes of each bending mode at the sensors
    with the other sign, as of a source that counts them the other way.

    Examples
    --------
    >>> import tvclin as tv
    >>> tank = tv.vehicle.SloshTank(mass=2400.0, station=19.94, damping=0.01, pendulum_length=2.1)
    >>> vehicle = tv.load_vehicle("configuration-i")
    >>> plant = tv.FlexiblePlant.from_vehicle(vehicle, tv.Structure(slosh=(tank,)))
    >>> autopilot = tv.Autopilot(attitude_gain=0.36, rate_gain=0.56, actuator=tv.Actuator())
    >>> found = tv.control.detuned(autopilot, plant, factors=[0.8, 1.2])
    >>> found.changes
    ('nominal', 'slosh 1 x 0.8', 'slosh 1 x 1.2', 'slosh 1, half its damping')
    >>> found.margins.status.tolist(), found.first[0]
    (['ok', 'ok', 'ok', 'ok'], 'aero_margin_dB')
    """
    instance("autopilot", autopilot, Autopilot, "see design_gains")
    instance("plant", plant, FlexiblePlant, "see FlexiblePlant.from_vehicle")
    instance("criteria", criteria, Criteria, "see Criteria.own")
    single("autopilot", autopilot.batch)
    single("plant", plant.batch)
    row = positive("factors", one_row("factors", factors))
    names, _ = named_modes(plant)
    if not names:
        raise InputError("detuned() needs a plant with a bending mode or a tank; this has none")
    count = len(names)
    bending = len(plant.structure.bending)
    changes = ["nominal", *(f"{name} x {factor:.6g}" for name in names for factor in row)]
    changes += [f"{name}, half its damping" for name in names]
    changes += [f"{name}, slopes at the sensors turned" for name in names[:bending]]
    # One row for each change, one column for each mode.
    place = np.arange(count)
    moved, damped, turned = np.ones((3, len(changes), count))
    start = 1 + count * row.size
    moved[np.arange(1, start), np.repeat(place, row.size)] = np.tile(row, count)
    damped[start + place, place] = 0.5
    turned[start + count + place[:bending], place[:bending]] = -1.0
    plants = with_modes(plant, moved, damped, turned)
    bands = autopilot.band_margins(plants) if criteria.of_modes else None
    margins = loop_margins(autopilot.exact_loop(plants)) if bands is None else bands.whole
    return Detuned(
        tuple(changes),
        margins,
        _first(criteria, bands or margins, margins, len(changes)),
        np.broadcast_to(criteria.are_met(bands or margins), len(changes)),
        tuple(_edges(autopilot, plant, names, float(row.min()), float(row.max()))),
        plants,
    )


def with_modes(
    plant: FlexiblePlant,
    frequency: FloatArray,
    damping: FloatArray,
    turned: FloatArray | None = None,
) -> FlexiblePlant:
    """Return plants with factors on frequencies, dampings and slopes at the sensors of the modes.

    `plant`: one or a batch, which broadcasts with the factors. `frequency`, `damping`, `turned`: of
    bending modes and then of tanks, ``(..., modes)``; the slopes are those of bending.
    """
    structure = plant.structure
    signs = np.ones_like(frequency) if turned is None else turned
    columns = list(zip(*(np.moveaxis(a, -1, 0) for a in (frequency, damping, signs)), strict=True))
    bending = tuple(
        replace(
            mode,
            frequency=mode.frequency * moved,
            damping=mode.damping * damped,
            attitude_slope=mode.attitude_slope * sign,
            rate_slope=mode.rate_slope * sign,
        )
        for mode, (moved, damped, sign) in zip(structure.bending, columns, strict=False)
    )
    slosh = tuple(
        _tank(tank, moved, damped)
        for tank, (moved, damped, _) in zip(structure.slosh, columns[len(bending) :], strict=True)
    )
    return replace(plant, structure=replace(structure, bending=bending, slosh=slosh))


def _tank(tank: SloshTank, frequency: FloatArray, damping: FloatArray) -> SloshTank:
    """A tank with its frequency moved, that of a pendulum by its length."""
    changes: dict[str, Any] = {"damping": tank.damping * damping}
    if tank.frequency is None:
        changes["pendulum_length"] = np.asarray(tank.pendulum_length) / frequency**2
    else:
        changes["frequency"] = tank.frequency * frequency
    return replace(tank, **changes)


def _first(
    criteria: Criteria, found: Margins | BandMargins, whole: Margins, count: int
) -> tuple[str, ...]:
    """The margin of each row with the least surplus over what is asked for."""
    judged = criteria.judge(found)
    asked = [max(one.requirement.limit, np.finfo(float).tiny) for one in judged]
    parts = np.stack(
        [np.broadcast_to(j.surplus, count) / limit for j, limit in zip(judged, asked, strict=True)]
    )
    least = np.argmin(np.where(np.isnan(parts), np.inf, parts), axis=0)
    names = [one.requirement.margin + (f" of {one.band}" if one.band else "") for one in judged]
    good = np.broadcast_to(whole.stable, count)
    return tuple(names[k] if fine else "unstable" for k, fine in zip(least, good, strict=True))


def _edges(
    autopilot: Autopilot, plant: FlexiblePlant, names: tuple[str, ...], low: float, high: float
) -> list[Edge]:
    """Where the loop becomes unstable between two factors, by its poles alone."""

    def unstable(factors: FloatArray, modes: IndexArray) -> BoolArray:
        moved = np.ones((factors.size, len(names)))
        moved[np.arange(factors.size), modes] = factors
        even = np.ones_like(moved)
        found = stability(autopilot.exact_loop(with_modes(plant, moved, even, even)).form)
        return np.asarray((found.unstable_poles > 0) | found.marginal)

    count = len(names)
    outward = [np.linspace(1.0, end, _SEARCHED // 2 + 1)[1:] for end in (min(low, 1), max(high, 1))]
    inner, outer = np.full((2, 2, count), np.nan)
    every = np.concatenate(outward)
    states = unstable(np.tile(every, count), np.repeat(np.arange(count), every.size))
    if unstable(np.ones(1), np.zeros(1, dtype=int))[0]:
        return [Edge(name, 1.0, 1.0) for name in names]
    for end, (factors, fails) in enumerate(
        zip(outward, np.split(states.reshape(count, -1), 2, axis=1), strict=True)
    ):
        place = np.argmax(fails, axis=1)
        found = np.any(fails, axis=1)
        outer[end] = np.where(found, factors[place], np.nan)
        inner[end] = np.where(found, np.append(1.0, factors)[place], np.nan)
    side, mode = np.nonzero(np.isfinite(outer))
    for _ in range(_HALVED if side.size else 0):
        middle = 0.5 * (inner[side, mode] + outer[side, mode])
        fails = unstable(middle, mode)
        outer[side, mode] = np.where(fails, middle, outer[side, mode])
        inner[side, mode] = np.where(fails, inner[side, mode], middle)
    return [Edge(name, *outer[:, k].tolist()) for k, name in enumerate(names)]
