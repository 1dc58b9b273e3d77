"""Gains and filters of an autopilot as files specify them: constant, over the flight, or at a mode.

Gains over the flight are columns of a CSV table. Each filter has a table of its own,
[[autopilot.filter]]; the CSV table may have columns for its numbers,
``filter.2.frequency_rad_per_s`` or ``filter.MODE.pole_damping``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Column, Columns, Record
from tvclin.base.fields import spec
from tvclin.base.lines import listed
from tvclin.base.sheet import cell_number, read_sheet
from tvclin.base.tables import FileTable
from tvclin.base.units import si_unit
from tvclin.control.autopilot.feedback import GAINS
from tvclin.vehicle.filters import Filter

CHAIN_OF_POSITION = {"sum": "filters", "attitude": "attitude_filters", "rate": "rate_filters"}
"""Position of a filter in a file, and the name of its chain in an `Autopilot`."""
COLUMN_PREFIX = "filter."
"""Beginning of the columns of filters in a table of gains."""
_KINDS: dict[str, tuple[Callable[..., Filter], tuple[str, ...]]] = {
    "notch": (Filter.notch, ("frequency", "zero_damping", "pole_damping")),
    "low-pass": (Filter.low_pass, ("frequency",)),
    "lead-lag": (Filter.lead_lag, ("zero", "pole")),
    "rational": (Filter.from_coefficients, ("numerator", "denominator")),
}
"""Kinds of filters: function from numbers to the filter, and the numbers that it needs."""
NOTCH_NUMBERS = ("zero_damping", "pole_damping", "ratio")
"""Numbers of a notch that follows a mode."""
FILTER_TABLE = FileTable(
    "[[autopilot.filter]]",
    {
        "frequency": "natural frequency",
        "damping": "number",
        "zero_damping": "number",
        "pole_damping": "number",
        "zero": "natural frequency",
        "pole": "natural frequency",
        "ratio": "number",
    },
    words=("kind", "on", "mode"),
    lists=("numerator", "denominator"),
    required=("kind",),
)


@dataclass(frozen=True, kw_only=True)
class ModeNotch(Record):
    """Notch behind the sum of all feedbacks, at the frequency of a bending mode at each time.

    Parameters
    ----------
    mode : str
        Name of the mode in the structure of the flight.
    zero_damping, pole_damping : float or ndarray
        As in `Filter.notch`; in a `GainSchedule` also at its breakpoints, ``(n,)``.
    ratio : float or ndarray
        Frequency of the notch over the mode's, positive, likewise.

    Raises
    ------
    InputError
        For numbers out of range, and arrays that do not broadcast.
    """

    mode: str = field(metadata=spec())
    zero_damping: float | FloatArray = field(metadata=spec())
    pole_damping: float | FloatArray = field(metadata=spec())
    ratio: float | FloatArray = field(default=1.0, metadata=spec())

    def __post_init__(self) -> None:
        """Check the name of the mode, and the numbers, which become floats or arrays."""
        errors.text("mode", self.mode)
        for name in NOTCH_NUMBERS:
            check = errors.finite if name == "zero_damping" else errors.positive
            object.__setattr__(self, name, errors.plain(check(name, getattr(self, name))))
        _ = self.batch  # raises for shapes that do not broadcast

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch of numbers; ``()`` for constant ones."""
        return errors.broadcast(**{name: np.shape(getattr(self, name)) for name in NOTCH_NUMBERS})

    def at(self, flight: Any, time: ArrayLike) -> Filter:
        """Return the notch at times [s] of a `FlightSchedule`.

        `InputError` for a flight whose structure has no mode of this name, and numbers of another
        shape than the times.
        """
        structure: Any = getattr(flight, "structure", None)
        if not hasattr(structure, "mode_number"):  # no structure over time
            raise errors.InputError(
                f"a notch at {self.mode} has no mode: it needs a flight with a structure over time,"
                " which rigid in [study] leaves out"
            )
        mode = structure.at(time).bending[structure.mode_number(self.mode)]
        errors.broadcast(time=np.shape(time), notch=self.batch)
        frequency = self.ratio * np.asarray(mode.frequency)
        return Filter.notch(frequency, self.zero_damping, self.pole_damping)


class SpecifiedFilters(NamedTuple):
    """Filters of [[autopilot.filter]].

    `constant`, `scheduled`: constant filters, and those at breakpoints of the flight ``(n,)``, by
    the chain names of an `Autopilot`. `notches`: notches that follow a mode.
    """

    constant: dict[str, Any]
    scheduled: dict[str, tuple[Filter, ...]]
    notches: tuple[ModeNotch, ...]


def specified_filters(
    rows: Sequence[Mapping[str, Any]], columns: Mapping[str, FloatArray]
) -> SpecifiedFilters:
    """Return the filters of [[autopilot.filter]] tables, completed by columns over the flight.

    `rows`: the tables in their order. `columns`: numbers at the breakpoints ``(n,)`` by ``filter.``
    with the number of the table, or the mode of a notch, and the key.

    Raises
    ------
    InputError
        With the number of the filter, for rows that are no tables, an unknown kind or position, and
        a key that is missing, given twice or not of that kind. For a column of no filter.
    """
    constant: dict[str, Any] = dict.fromkeys(CHAIN_OF_POSITION.values(), ())
    scheduled: dict[str, tuple[Filter, ...]] = {}
    notches: list[ModeNotch] = []
    for row in rows:
        if not isinstance(row, Mapping):
            raise errors.InputError(
                f"filter must be given as {FILTER_TABLE.heading}; got {errors.shown(row)}"
            )
    for k, (row, numbers) in enumerate(zip(rows, _numbers_of_rows(rows, columns), strict=True)):
        with errors.naming(f"filter {k + 1} of the autopilot"):
            # The table completed at each breakpoint of the flight, or as it is without columns.
            values_by_point = zip(*numbers.values(), strict=True)
            points = [dict(zip(numbers, values, strict=True)) for values in values_by_point]
            tables = [dict(row) | point for point in points] or [dict(row)]
            if "mode" in row:
                notches.append(_joined([_mode_notch(table) for table in tables]))
                continue
            positions, filters = zip(*map(_filter, tables), strict=True)
            chain = CHAIN_OF_POSITION[positions[0]]  # all are equal
            if points:
                numerator, denominator = (
                    np.stack([getattr(filter_, name) for filter_ in filters])
                    for name in ("numerator", "denominator")
                )
                scheduled[chain] = (*scheduled.get(chain, ()), Filter(numerator, denominator))
            else:
                constant[chain] += filters
    return SpecifiedFilters(constant, scheduled, tuple(notches))


def _numbers_of_rows(
    rows: Sequence[Mapping[str, Any]], columns: Mapping[str, FloatArray]
) -> list[dict[str, list[float]]]:
    """Return the numbers over the flight of each filter, ``(n,)`` by key, from a table's columns.

    `rows`: tables [[autopilot.filter]]. `columns`: ``(n,)`` by "filter.N.key" with the number N of
    the filter in the file, from 1, or "filter.MODE.key" for the only notch of a mode. `InputError`
    for a column of no filter, and for a number given both in a row and in a column.
    """
    by_number = {f"{k + 1}": k for k in range(len(rows))}
    modes = [f"{row['mode']}" if "mode" in row else "" for row in rows]
    by_mode = {mode: k for k, mode in enumerate(modes) if mode and modes.count(mode) == 1}
    labels = by_number | by_mode | by_number  # in this order; a number counts before a mode "1"
    numbers: list[dict[str, list[float]]] = [{} for _ in rows]
    for column, values in columns.items():
        label, _, key = column.removeprefix(COLUMN_PREFIX).rpartition(".")
        if label not in labels:
            legal = f"{listed(tuple(labels))} are known" if labels else "the file has none"
            raise errors.InputError(
                f"{column} must name a filter of {FILTER_TABLE.heading} by its number or its mode,"
                f" as filter.1.frequency_rad_per_s; {legal}"
            )
        row, completed = rows[labels[label]], numbers[labels[label]]
        if key in row or key in completed:
            raise errors.InputError(
                f"{column} is given twice; keep one, of the file or of the table"
            )
        completed[key] = values.tolist()
    return numbers


def _joined(notches: Sequence[ModeNotch]) -> ModeNotch:
    """Return one notch with the numbers of n notches at a mode as arrays, ``(n,)``.

    A single notch is returned as it is, with its numbers as floats.
    """
    first = notches[0]
    if len(notches) == 1:
        return first
    numbers = {name: np.array([getattr(n, name) for n in notches]) for name in NOTCH_NUMBERS}
    return ModeNotch(mode=first.mode, **numbers)


def _filter(row: Mapping[str, Any]) -> tuple[str, Filter]:
    """Return the position, "sum", "attitude" or "rate", and the filter of one table of a file.

    `row`: keys and values of [[autopilot.filter]]. `InputError` for an unknown kind or position,
    and for numbers that are missing or not of that kind of filter.
    """
    keys = FILTER_TABLE.read(row)
    position = errors.one_of("on", keys.pop("on", "sum"), CHAIN_OF_POSITION)
    kind = errors.one_of("kind", keys.pop("kind"), _KINDS)
    make, needed = _KINDS[kind]
    FILTER_TABLE.need(keys, needed)
    allowed = (*needed, "damping") if kind == "low-pass" else needed
    for name in keys:
        if name not in allowed:
            raise errors.InputError(f"a {kind} filter takes {', '.join(allowed)}; got {name}")
    for name in ("numerator", "denominator"):
        if name in keys:
            keys[name] = [errors.number(f"{name}[{k}]", c) for k, c in enumerate(keys[name])]
    return position, make(**keys)


def _mode_notch(row: Mapping[str, Any]) -> ModeNotch:
    """Return the notch of a table `row` with a mode, whose frequency it follows over the flight.

    It needs mode, zero_damping and pole_damping, and may have a ratio. `InputError` for another
    kind than "notch", another position than the sum, and other keys.
    """
    keys = FILTER_TABLE.read(row)
    allowed = ("mode", *NOTCH_NUMBERS)
    kind, position = keys.pop("kind"), keys.pop("on", "sum")
    FILTER_TABLE.need(keys, ("mode", "zero_damping", "pole_damping"))
    if kind != "notch" or position != "sum" or set(keys) - set(allowed):
        raise errors.InputError(
            f"a filter that follows a mode is a notch on the sum, of {listed(allowed)}"
        )
    return ModeNotch(**keys)


_VARIABLES = {
    "time": "time",
    "speed": "speed",
    "altitude": "altitude",
    "mach": "number",
    "dynamic_pressure": "pressure",
}
"""Variables of the flight with their kinds of units."""
GAIN_COLUMNS = FileTable("a table of gains", _VARIABLES | GAINS)
"""Columns of a table of gains: one variable of the flight, and gains."""
_REQUIRED_GAINS = {"attitude_gain", "rate_gain"}
"""Gains that a table must have."""
_KEYS = "keys such as mach,attitude_gain,rate_gain_s (tvclin init --keys lists them)"
"""Expected line of names, for a message."""


@dataclass(frozen=True, eq=False)
class GainTable:
    """Part of an autopilot's specification that varies over the flight.

    `breakpoints`: rising values ``(n,)`` of `variable` in SI units. `gains`: gains by name,
    ``(n,)``; without gains the specification's, constant or by a rule, count. `chains`: filters at
    the breakpoints, ``(n,)``, by the chain names of an `Autopilot`. `notches`: notches that follow
    a mode.
    """

    variable: str = "time"
    breakpoints: FloatArray = field(default_factory=lambda: np.zeros(0))
    gains: dict[str, FloatArray] = field(default_factory=dict)
    chains: dict[str, tuple[Filter, ...]] = field(default_factory=dict)
    notches: tuple[ModeNotch, ...] = ()


def gain_columns(
    variable: str, breakpoints: FloatArray, gains: Mapping[str, FloatArray | float]
) -> Columns:
    """Return the columns of a CSV table of gains over a variable of the flight.

    Gains of zero are omitted, but not on attitude and rate. `variable`: name of the variable.
    `breakpoints`: its values ``(n,)`` in SI units. `gains`: gains by name, ``(n,)`` or constant.
    """
    columns = [  # axes () of a constant: one number for all breakpoints
        Column(name, np.asarray(gain), si_unit(GAINS[name]), () if np.ndim(gain) == 0 else None)
        for name, gain in gains.items()
        if name in _REQUIRED_GAINS or np.any(gain)
    ]
    points = Column(variable, breakpoints, si_unit(_VARIABLES[variable]))
    return Columns((points,), tuple(columns))


def load_gains(source: str | PathLike[str]) -> tuple[GainTable, dict[str, FloatArray]]:
    """Return the gains over a variable of the flight in a CSV table, and its columns of filters.

    Parameters
    ----------
    source : str or path
        A table with one column of time_s, speed_m_per_s, altitude_m, mach or dynamic_pressure_Pa,
        rising, and columns with the keys of the gains in [autopilot]: attitude_gain, rate_gain_s...
        Columns of filters are filter.N.KEY or filter.MODE.KEY, see `specified_filters`.

    Raises
    ------
    InputError
        For a cell that is no number, an unknown column, no or several columns of variables, values
        that do not rise, and a table without both attitude_gain and rate_gain.
    """
    sheet = read_sheet(
        source,
        "a table of gains",
        # the line with most known names has the headings
        lambda headings: float(sum(_is_known(heading.text) for heading in headings)),
        _KEYS,
    )
    keys = [heading.text for heading in sheet.headings]
    for key in keys:
        if not _is_known(key):
            raise sheet.error(
                f"{GAIN_COLUMNS.unknown(key)}; numbers of filters are {COLUMN_PREFIX}N.KEY or"
                f" {COLUMN_PREFIX}MODE.KEY, as filter.1.frequency_rad_per_s"
            )
        if keys.count(key) > 1:
            raise sheet.error(f"every column needs a key of its own; got {errors.shown(key)}")
    rows: list[dict[str, float]] = []
    for position, cells in zip(sheet.places, sheet.cells, strict=True):
        with errors.naming(position):
            numbers = {k: cell_number(k, cell) for k, cell in zip(keys, cells, strict=True)}
            of_filters = {k: numbers.pop(k) for k in keys if k.startswith(COLUMN_PREFIX)}
            rows.append(GAIN_COLUMNS.read(numbers) | of_filters)
    with errors.naming(sheet.text.source):
        variables = [name for name in rows[0] if name in _VARIABLES] if rows else []
        if len(variables) != 1:
            raise errors.InputError(
                "a table of gains needs one column of time_s, speed_m_per_s, altitude_m, mach or"
                f" dynamic_pressure_Pa; got {', '.join(variables) or 'none'}"
            )
        (variable,) = variables
        columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        points = columns.pop(variable)
        if points.size < 2 or np.any(np.diff(points) <= 0.0):
            raise errors.InputError(f"{variable} must have two or more values, which rise")
        if not _REQUIRED_GAINS <= columns.keys():
            raise errors.InputError("a table of gains needs attitude_gain and rate_gain_s, both")
    gains = {name: columns.pop(name) for name in GAINS if name in columns}
    return GainTable(variable, points, gains), columns


def _is_known(column: str) -> bool:
    """Return whether a column of this name in a table of gains is read.

    It is a variable of the flight, a gain, or a number of a filter, "filter.N.KEY".
    """
    return column in GAIN_COLUMNS.keys or column.startswith(COLUMN_PREFIX)
