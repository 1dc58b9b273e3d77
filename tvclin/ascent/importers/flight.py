"""The numbers of a flight as another tool gives them, and which rows are the powered flight."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.base.errors import InputError, number
from tvclin.base.lines import plural
from tvclin.base.sheet import Column

_BURNING = 0.05
"""Part of the largest thrust, below which the motor is taken as burnt out."""
_LEAST, _LARGEST = 1e-12, 1e12
"""No number of a flight is larger in SI units, and none that must be positive smaller."""
_POSITIVE = {
    *("mass", "weight", "moment_of_inertia", "thrust", "velocity", "mach", "density", "pressure"),
    *("sound", "area", "drag_coefficient", "dynamic_pressure", "reference_area", "temperature"),
}


@dataclass(frozen=True, eq=False, kw_only=True)
class Flight:
    """Rows of a flight, one after the other.

    `source`: what to call the whole in messages. `places`: what to call each row. `columns`:
    numbers in SI units by name, NaN where there is none; `time`, `thrust` and `velocity` are there.
    `notes`: what a reader should know.
    """

    source: str
    places: tuple[str, ...]
    columns: dict[str, Column]
    notes: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> FloatArray:
        return self.columns[name].values

    def origin(self, name: str) -> str:
        """Return where a column came from."""
        return self.columns[name].origin

    def noted(self, *notes: str) -> Flight:
        """Return the same with notes more."""
        return replace(self, notes=(*self.notes, *notes))

    def rows(self, index: IndexArray) -> Flight:
        """Return some rows of it."""
        columns = {k: Column(c.values[index], c.origin) for k, c in self.columns.items()}
        return replace(self, places=tuple(self.places[i] for i in index), columns=columns)


def powered(flight: Flight, begun: BoolArray, start: float | None, stop: float | None) -> Flight:
    """Return the rows of one burn, of which no number is missing.

    `begun`: the rows at which the vehicle flies freely. `start`, `stop`: earliest and latest time
    [s].
    """
    time, thrust = flight["time"], flight["thrust"]
    _check_times(flight)
    low = -np.inf if start is None else number("start", start, unit="s")
    high = np.inf if stop is None else number("stop", stop, unit="s")
    inside = (time >= low) & (time <= high)
    later = np.append(np.diff(time) > 0.0, True)  # of rows at one time the last counts
    index = np.flatnonzero(inside & later)
    known = np.nan_to_num(thrust[index], nan=0.0)
    most = max(known, default=0.0)
    if not most > 0.0:
        raise InputError(
            f"{flight.source} has no thrust between start and stop; give the times of a burn"
        )
    out = np.isfinite(thrust[index]) & (known < _BURNING * most)
    moving = ~(flight["velocity"][index] <= 0.0)
    first = np.flatnonzero(~out & moving & begun[index])
    if not first.size:
        raise InputError(
            f"{flight.source} has no row of a free flight with thrust: where the motor burns, the"
            " centre of pressure or the speed is missing or zero in every row"
        )
    after = np.flatnonzero(out[first[0] :])
    last = first[0] + after[0] if after.size else index.size
    chosen = index[first[0] : last]
    _check_complete(flight, chosen)
    if chosen.size < 2:
        raise InputError(
            f"{flight.source} must hold two or more rows of powered flight; got {chosen.size}"
        )
    return flight.rows(chosen).noted(*_left_out(flight, inside & ~later, index, first[0], last))


def _check_times(flight: Flight) -> None:
    time = flight["time"]
    lost = np.flatnonzero(~np.isfinite(time))
    if lost.size:
        raise InputError(f"{flight.places[lost[0]]}: the time is missing")
    falls = np.flatnonzero(np.diff(time) < 0.0)
    if falls.size:
        i = falls[0]
        raise InputError(
            f"{flight.places[i + 1]}: the time must rise; got {time[i + 1]:g} s after {time[i]:g} s"
        )


def _check_complete(flight: Flight, chosen: IndexArray) -> None:
    """Refuse rows in which a number is missing, or is none that a flight can have."""
    for name, column in flight.columns.items():
        values = column.values[chosen]
        lost = chosen[~np.isfinite(values)]
        if lost.size:
            raise InputError(
                f"{flight.places[lost[0]]}: there is no number in {column.origin}, while the motor"
                " burns"
            )
        least = _LEAST if name in _POSITIVE else -_LARGEST
        wrong = np.flatnonzero((values < least) | (values > _LARGEST))
        if wrong.size:
            rule = "must be positive" if name in _POSITIVE else "must be a plausible number"
            raise InputError(
                f"{flight.places[chosen[wrong[0]]]}: {column.origin} {rule}; got"
                f" {values[wrong[0]]:.6g} in SI units"
            )


def _left_out(
    flight: Flight, twice: BoolArray, index: IndexArray, first: int, last: int
) -> list[str]:
    """What to say of the rows that were not taken."""
    time = flight["time"][index]
    taken = plural(last - first, "row")
    notes = [f"powered flight from {time[first]:g} to {time[last - 1]:g} s: {taken}"]
    if first:
        notes.append(
            f"{plural(first, 'row')} before it left out: on the launch rod, or without thrust"
        )
    if last < time.size:
        notes.append(
            f"{plural(time.size - last, 'row')} after it left out: thrust below"
            f" {100 * _BURNING:g} percent of its largest from {time[last]:g} s on"
        )
        again = np.nan_to_num(flight["thrust"][index[last:]]) > 0.5 * max(flight["thrust"][index])
        if np.any(again):
            notes.append(
                f"the thrust comes back at {time[last + int(np.argmax(again))]:g} s: that burn is"
                " read with start (--from) at that time"
            )
    if np.any(twice):
        notes.append(f"{plural(int(np.sum(twice)), 'row')} at the time of the next row left out")
    return notes
