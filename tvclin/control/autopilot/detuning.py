"""Margins of a loop whose modes differ in frequency, damping or slope from the model.

A mode's frequency changes while its displacements, slopes and modal mass stay, so that its
low-frequency gain falls as 1/omega^2. Texts that hold the modal gain constant get other numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.cards import table
from tvclin.base.errors import InputError, instance, one_of, one_row, positive, single
from tvclin.base.fields import document
from tvclin.base.lines import Line, Table, listed, number, text
from tvclin.base.quantities import satisfaction
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.margins.bands import BandMargins
from tvclin.control.margins.criteria import CRITERIA, Criteria
from tvclin.control.margins.margins import MARGINS, Margins, loop_margins
from tvclin.linear.flexible import FlexiblePlant, named_modes
from tvclin.numerics.loop_margins import stability
from tvclin.vehicle.structure import SloshTank, Structure

_COLUMNS = {"aero_margin_dB": "down", "gain_increase_dB": "up", "phase_margin_deg": "phase"}
"""Margins of the table, and their headings."""
_INTERVALS = 20
"""Number of intervals of frequency factors on each side of one, with a trial at each end."""
_REFINEMENTS, _PARTS = 4, 16
"""Refinements of the interval in which the loop becomes unstable, and parts of it in each."""
NEAR = 0.1
"""Usual uncertainty of a mode's frequency, relative."""
_OF_FREQUENCY = " of its frequency"
_MAX_NAMED = 3
"""Largest number of changes that a verdict names."""


@dataclass(frozen=True, eq=False)
class StableRange:
    """Factors on a mode's frequency between which the loop is stable.

    `name`: the mode. `lower`, `upper`: the factors nearest to one, below and above, at which the
    loop becomes unstable; NaN where it is stable over the whole range of factors.
    """

    name: str
    lower: float
    upper: float

    def line(self, key: str = "edge", within: float = np.inf) -> Line:
        """Return the sentence on the factors at which the loop becomes unstable; () without any.

        Only factors that differ from one by at most `within` count, and so none that is NaN: there
        the loop is stable. Equal factors are both one, of a loop that is unstable without a change:
        () too. `key`: first part of the keys of the numbers.
        """
        bounds = {"lower": self.lower, "upper": self.upper}
        shown = [
            number(f"{key}.{bound}", factor)
            for bound, factor in bounds.items()
            if abs(factor - 1.0) <= within
        ]
        if not shown or self.lower == self.upper:
            return ()
        if len(shown) > 1:
            return (f"{self.name} is stable from ", *shown[0], " to ", *shown[1], _OF_FREQUENCY)
        return (f"{self.name} is unstable at ", *shown[0], _OF_FREQUENCY)


@dataclass(frozen=True, eq=False)
class Detuned:
    """Margins of a loop with detuned modes, one row for each change; row zero is nominal.

    Attributes
    ----------
    changes : tuple of str
        The change of each row, such as "bending 1 x 0.8".
    margins : Margins
        Margins of the rows, ``(n,)``.
    critical_margin : tuple of str
        Name of the margin of each row with the smallest surplus relative to its requirement, with
        the name of its mode, "mode_gain_margin_dB of bending 1"; "unstable" for an unstable loop.
    satisfied : ndarray of bool
        Whether each row satisfies the criteria, ``(n,)``.
    stable_ranges : tuple of StableRange
        Factors on the frequency of each mode between which the loop is stable.
    searched : tuple of float
        Smallest and largest factor on a frequency up to which they were searched.
    plants : FlexiblePlant
        The changed plants, ``(n,)``, as `Autopilot.band_margins` takes them.
    """

    changes: tuple[str, ...]
    margins: Margins
    critical_margin: tuple[str, ...]
    satisfied: BoolArray
    stable_ranges: tuple[StableRange, ...]
    searched: tuple[float, float]
    plants: FlexiblePlant

    @property
    def all_satisfied(self) -> bool:
        """Whether every row satisfies the criteria."""
        return bool(np.all(self.satisfied))

    @property
    def verdict(self) -> str:
        """MET, or NOT MET with the number of changes that fail the criteria and the first three."""
        failed = [name for name, good in zip(self.changes, self.satisfied, strict=True) if not good]
        if not failed:
            return "MET"
        more = ", ..." if len(failed) > _MAX_NAMED else ""
        shown = ", ".join(failed[:_MAX_NAMED])
        return f"NOT MET in {len(failed)} of {len(self.changes)} rows ({shown}{more})"

    def row(self, change: str) -> int:
        """Return the index of the row with a change, such as "bending 1 x 0.8"."""
        return self.changes.index(one_of("change", change, self.changes))

    def as_dict(self) -> dict[str, Any]:
        """Return the record as the command line prints it as JSON, angles in degrees.

        A dictionary of margins, critical margin and verdict for each change; the stable range of
        each mode; and whether all changes satisfy the criteria.
        """
        names = ("status", "aero_margin", "gain_increase", "phase_margin", "delay_margin")
        columns = {
            "change": self.changes,
            **document(self.margins, *names),
            "first": self.critical_margin,
            "satisfied": self.satisfied,
        }
        rows = zip(*columns.values(), strict=True)
        return {
            "rows": [dict(zip(columns, row, strict=True)) for row in rows],
            "edges": self.stable_ranges,
            "satisfied": self.all_satisfied,
        }

    def table(self) -> Table:
        """Return the table of margins, of the critical one of each row, and of its verdict.

        Margins are the gain margins down and up [dB] and the phase margin [deg].
        """
        m, rows = self.margins, []
        for k, change in enumerate(self.changes):
            numbers = (number(f"detuned.{k}.{name}", getattr(m, name)[k], 2) for name in _COLUMNS)
            critical = (_margin_label(self.critical_margin[k]),)
            short = change.replace(" at the sensors", "").replace("half its", "half")
            verdict = (satisfaction(bool(self.satisfied[k])),)
            rows.append(((short,), *numbers, critical, verdict))
        head = ("change", *_COLUMNS.values(), "fails first", "required")
        return Table("Margins with one mode detuned, in dB and deg", head, tuple(rows))

    @property
    def stability_lines(self) -> tuple[Line, ...]:
        """Factors on its frequency at which each mode makes the loop unstable, a line each.

        One line that says so of a loop that is unstable without a change, or with none of them.
        """
        if not self.margins.stable[0]:
            return (("The loop is unstable with all modes at their frequencies.",),)
        modes = (mode.line(f"edge.{j}") for j, mode in enumerate(self.stable_ranges))
        lines = tuple(line for line in modes if line)
        low, high = (f"{factor:.6g}" for factor in self.searched)
        stays = f"The loop is stable with any one mode from {low} to {high} of its frequency."
        return lines or ((stays,),)

    def _repr_html_(self) -> str:
        """Return table and stability lines for a notebook."""
        return table(self.table(), self.stability_lines)


def _margin_label(name: str) -> str:
    """Return the text in a table of the margin that fails first; "UNSTABLE" without margins.

    `name`: "unstable", or the name of a margin: of the loop, as "aero_margin_dB", with its heading
    as text; or of a mode, "mode_gain_margin_dB of bending 1", with the text "bending 1, gain".
    """
    margin, _, mode = name.partition(" of ")
    if mode:
        return f"{mode}, {'gain' if 'gain' in margin else 'phase'}"
    if name in MARGINS:
        label, *_ = MARGINS[name]
        return _COLUMNS.get(name, label)
    return name.upper()


def detuned(
    autopilot: Autopilot,
    plant: FlexiblePlant,
    factors: ArrayLike = (0.8, 0.9, 1.1, 1.2),
    criteria: Criteria = CRITERIA["classic"],
) -> Detuned:
    """Return the margins with each mode's frequency scaled, damping halved, or slopes reversed.

    Parameters
    ----------
    autopilot : Autopilot
        One autopilot.
    plant : FlexiblePlant
        One plant with a bending mode or a tank.
    factors : array_like
        Factors on the frequency of a mode, positive, ``(n,)``, for one mode at a time. Between the
        smallest and the largest, the factor at which the loop becomes unstable is searched.
    criteria : Criteria
        Criteria of the margins, of the loop and of modes.

    Raises
    ------
    InputError
        For a batch, a plant without modes, factors that are not positive, and in the same cases as
        `Autopilot.exact_loop`.

    Notes
    -----
    Further rows have the damping of each mode halved, and the slopes of each bending mode at the
    sensors reversed, as data with the opposite sign convention would have them.

    Examples
    --------
    >>> import tvclin as tv
    >>> tank = tv.vehicle.SloshTank(mass=2400.0, station=19.94, damping=0.01, pendulum_length=2.1)
    >>> vehicle = tv.load_vehicle("configuration-i")
    >>> plant = tv.FlexiblePlant.from_vehicle(vehicle, tv.Structure(slosh=(tank,)))
    >>> autopilot = tv.Autopilot(attitude_gain=0.36, rate_gain=0.56, actuator=tv.Actuator())
    >>> rows = tv.control.detuned(autopilot, plant, factors=[0.8, 1.2])
    >>> rows.changes
    ('nominal', 'slosh 1 x 0.8', 'slosh 1 x 1.2', 'slosh 1, half its damping')
    >>> rows.margins.status.tolist(), rows.critical_margin[0]
    (['ok', 'ok', 'ok', 'ok'], 'aero_margin_dB')
    """
    instance("autopilot", autopilot, Autopilot, "see design_gains")
    instance("plant", plant, FlexiblePlant, "see FlexiblePlant.from_vehicle")
    instance("criteria", criteria, Criteria, "see Criteria.custom")
    single("autopilot", autopilot.batch)
    single("plant", plant.batch)
    row = positive("factors", one_row("factors", factors))
    names, _ = named_modes(plant)
    if not names:
        raise InputError("detuned() needs a plant with a bending mode or a tank; this has none")
    changes, frequency, damping, slope_sign = mode_changes(names, len(plant.structure.bending), row)
    varied = structure_with_mode_factors(plant.structure, frequency, damping, slope_sign)
    plants = replace(plant, structure=varied)
    # margins of modes are computed only for criteria that judge them
    bands = autopilot.band_margins(plants) if criteria.has_mode_limits else None
    margins = loop_margins(autopilot.exact_loop(plants)) if bands is None else bands.margins
    low, high = min(float(row.min()), 1.0), max(float(row.max()), 1.0)
    return Detuned(
        changes=changes,
        margins=margins,
        critical_margin=_critical_margins(criteria, bands or margins, margins, len(changes)),
        satisfied=np.broadcast_to(criteria.are_satisfied(bands or margins), len(changes)),
        stable_ranges=stable_ranges(autopilot, plant, low, high, _INTERVALS),
        searched=(low, high),
        plants=plants,
    )


def mode_changes(
    names: tuple[str, ...], bending: int, factors: FloatArray
) -> tuple[tuple[str, ...], FloatArray, FloatArray, FloatArray]:
    """Return changes of single modes, and their factors on frequency, damping and slopes.

    The changes are texts as "bending 1 x 0.8", the first "nominal"; factors are ``(changes,
    modes)``. Each mode has n frequencies, then half its damping; each bending mode then has slopes
    of opposite sign at the sensors. `names`: of bending modes, then tanks. `bending`: number of
    bending modes. `factors`: factors on a frequency, ``(n,)``.
    """
    count = len(names)
    changes = ["nominal", *(f"{name} x {factor:.6g}" for name in names for factor in factors)]
    changes += [f"{name}, half its damping" for name in names]
    changes += [f"{name}, sensor slopes of opposite sign" for name in names[:bending]]
    mode = np.arange(count)
    frequency, damping, slope_sign = np.ones((3, len(changes), count))
    first_damping = 1 + count * factors.size  # row of the first change of damping
    rows = np.arange(1, first_damping)
    frequency[rows, np.repeat(mode, factors.size)] = np.tile(factors, count)
    damping[first_damping + mode, mode] = 0.5
    slope_sign[first_damping + count + mode[:bending], mode[:bending]] = -1.0
    return tuple(changes), frequency, damping, slope_sign


_SENSED = (
    "attitude_slope",
    "rate_slope",
    "drift_displacement",
    "accelerometer_displacement",
    "accelerometer_slope",
)
"""Slopes and displacements of a bending mode at the sensors."""


def structure_with_mode_factors(
    structure: Structure,
    frequency: FloatArray,
    damping: FloatArray,
    slope_sign: FloatArray | None = None,
) -> Structure:
    """Return a structure with factors on frequencies, dampings and sensor shapes of its modes.

    `frequency`, `damping`: factors for bending modes and then tanks, ``(..., modes)``, which
    broadcast with the numbers of the structure. `slope_sign`: likewise, 1 or -1 for slopes and
    displacements of bending modes at the sensors; None: all are 1.
    """
    signs = np.ones_like(frequency) if slope_sign is None else slope_sign
    bending = tuple(
        replace(
            mode,
            frequency=mode.frequency * frequency[..., k],
            damping=mode.damping * damping[..., k],
            **{name: getattr(mode, name) * signs[..., k] for name in _SENSED},
        )
        for k, mode in enumerate(structure.bending)
    )
    slosh = tuple(
        _detuned_tank(tank, frequency[..., k], damping[..., k])
        for k, tank in enumerate(structure.slosh, start=len(bending))
    )
    return replace(structure, bending=bending, slosh=slosh)


def _detuned_tank(
    tank: SloshTank, frequency_factor: FloatArray, damping_factor: FloatArray
) -> SloshTank:
    """Return a tank with factors ``(...)`` on its frequency and damping ratio.

    A tank without a frequency is a pendulum, whose frequency is sqrt(acceleration/length).
    """
    damping = tank.damping * damping_factor
    if tank.frequency is not None:
        return replace(tank, damping=damping, frequency=tank.frequency * frequency_factor)
    length = np.asarray(tank.pendulum_length) / frequency_factor**2
    return replace(tank, damping=damping, pendulum_length=length)


def _critical_margins(
    criteria: Criteria, margins: Margins | BandMargins, loops: Margins, count: int
) -> tuple[str, ...]:
    """Return the name of the margin with the smallest relative surplus in each of `count` loops.

    The surplus is the margin less its limit, here over the limit. `margins`: those that `criteria`
    judge: of the loops, or also of their modes, as "mode_gain_margin_dB of bending 1". `loops`:
    margins of the whole loops, ``(count,)``; the name for a loop that is not stable is "unstable".
    """
    judged = criteria.judge(margins)
    surplus = np.stack([np.broadcast_to(j.relative_surplus, count) for j in judged])
    critical = np.argmin(np.where(np.isnan(surplus), np.inf, surplus), axis=0)
    names = [j.criterion.margin + (f" of {j.band}" if j.band else "") for j in judged]
    stable = np.broadcast_to(loops.stable, count)
    return tuple(names[k] if good else "unstable" for k, good in zip(critical, stable, strict=True))


def stable_ranges(
    autopilot: Autopilot,
    plant: FlexiblePlant,
    low: float = 1.0 - NEAR,
    high: float = 1.0 + NEAR,
    intervals: int = _INTERVALS // 2,
) -> tuple[StableRange, ...]:
    """Return the stable range of the factor on each mode's frequency, by counts of unstable poles.

    `autopilot`, `plant`: one each. `low`, `high`: smallest and largest factor. `intervals`: number
    of intervals from one to each of them; a range of factors with an unstable loop that is narrower
    than an interval may be missed. Each of four refinements divides the interval in which the loop
    becomes unstable by 16.
    """
    names, _ = named_modes(plant)
    mode_count = len(names)

    # One row for each mode with factors below one, then for each with factors above one; `rows` are
    # the numbers of those that become unstable. They do so between the factors `inner` (stable) and
    # `outer` (unstable), which each refinement brings closer.
    rows = np.arange(2 * mode_count)
    inner = np.ones(2 * mode_count)
    outer = np.repeat([min(low, 1.0), max(high, 1.0)], mode_count)
    for refinement in range(_REFINEMENTS + 1):
        fractions = np.linspace(0.0, 1.0, 1 + (_PARTS if refinement else intervals))
        factors = inner[:, np.newaxis] + (outer - inner)[:, np.newaxis] * fractions
        # a loop for each factor, on the frequency of the mode of its row
        frequency = np.ones((factors.size, mode_count))
        modes = np.repeat(rows % mode_count, factors.shape[1])
        frequency[np.arange(factors.size), modes] = factors.ravel()
        damping = np.ones_like(frequency)
        structure = structure_with_mode_factors(plant.structure, frequency, damping)
        verdict = stability(autopilot.exact_loop(replace(plant, structure=structure)).form)
        fails = ((verdict.unstable_poles > 0) | verdict.marginal).reshape(factors.shape)
        fails[:, -1] |= refinement > 0  # `outer` is known to be unstable
        exists, first = np.any(fails, axis=1), np.argmax(fails, axis=1)  # first unstable factor
        rows, first, factors = rows[exists], first[exists], factors[exists]
        if not rows.size:
            break
        index = np.arange(rows.size)
        inner, outer = factors[index, np.maximum(first - 1, 0)], factors[index, first]
    bounds = np.full(2 * mode_count, np.nan)
    bounds[rows] = outer[: rows.size]
    lower, upper = bounds.reshape(2, mode_count).tolist()
    return tuple(StableRange(*row) for row in zip(names, lower, upper, strict=True))


def detuning_note(ranges: Sequence[StableRange]) -> str:
    """Return a text on the factors within 10 percent of one at which the loop becomes unstable.

    `ranges`: stable range of the frequency factor of each mode. Empty where the loop is stable
    within 10 percent of the frequencies of all modes, and where it is unstable without a change.
    """
    lines = [text(line) for mode in ranges if (line := mode.line(within=NEAR))]
    return listed(lines) if lines else ""
