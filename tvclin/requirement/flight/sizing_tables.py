"""Tables of a sizing over flight time, and the legend of their columns."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import compress, repeat

import numpy as np

from tvclin.base.arrays import BoolArray
from tvclin.base.lines import Line, Table, degrees, number, significant, text
from tvclin.base.quantities import NO_FORECAST, QUANTITIES, WIND_KNOWN
from tvclin.requirement.flight.sizing import STEADY, Sizing
from tvclin.requirement.required_quantity import Requirement

_MARKS = {
    "1": "beyond the single-pole theory",
    "~": "parameters change while the wind blows",
    "+": "beyond the schedule",
    "=": "what the sign of a pulse changes is not known, that at nominal pressure is of both",
    "?": "a wind is not known",
}
"""Meanings of the marks of flight times in a table of the worst winds."""
_OFF = "{} off by [%]"
"""Head of the column with the error of a frozen requirement."""
_MAX_FREEZING_ERROR = 1.0
"""Relative error above which a frozen requirement is no approximation, as at a low speed."""

COLUMNS = (
    "Change: by how much beta or B changes while the wind blows; above"
    f" {100 * STEADY:g} % a frozen vehicle is doubtful. One pole: whether the slow motion of the"
    " flight path may be neglected. Data: whether the flight data cover the whole wind."
)
"""Definitions of the columns of doubts, in sentences."""


def marks_line(s: Sizing) -> str:
    """Return the meanings of the marks in a table of the worst winds; empty without marks."""
    there = {mark for i in range(s.times.size) for mark in _marks(s, i)}
    return "; ".join(f"{mark}: {words}" for mark, words in _MARKS.items() if mark in there)


def legend(s: Sizing) -> str:
    """Return the definitions of the requirements of a sizing, in sentences."""
    trusts = " K below 1 trusts a forecast." if (s.dead_bands < 1.0).any() else ""
    signed = f" Head and tail wind: K = {s.dead_bands[0]:g} with the dynamic pressure in them."
    signed *= any(one.direction for one in s.required)
    known = f"{WIND_KNOWN.capitalize()}: {QUANTITIES[WIND_KNOWN]}."
    return f"{NO_FORECAST.capitalize()}: {s.law_words}. {known}{trusts}{signed}"


def over_time(s: Sizing, counted: Requirement, wind: int | None = None) -> list[Table]:
    """Return the requirements by flight time of one wind, by its index, or of the worst wind.

    First with parameters that vary while the wind blows, where the sizing has them, and in head and
    tail winds: a wind that is fixed in the flight has one number each, with the time at which it
    arises. Then with frozen parameters; and for both planes the counted requirement of each plane.
    """
    frozen = [one for one in s.required if not (one.varying or one.direction)]
    first = _first(s)
    of = "" if wind is None else f": {s.winds[wind]}"
    doubts = ("",) if wind is None else ("change [%]", "one pole", "data")
    marks = [_doubts(s, i, wind) for i in range(s.times.size)]

    def of_names(
        caption: str,
        times: list[Line],
        names: list[Requirement],
        last: Sequence[str],
        more: list[list[Line]],
        shown: Iterable[bool] = repeat(True),
    ) -> Table:
        head = ("time [s]", *map(_short, names), *last)
        each = zip(times, _required(s, names, wind), more, strict=True)
        rows = tuple((time, *needs, *cells) for time, needs, cells in compress(each, shown))
        return Table(f"{caption} [deg]{of}", head, rows)

    keys = [significant(f"{_key(i, wind)}.time", time, 6) for i, time in enumerate(s.times)]
    fixed = _fixed(s, first) if wind is None else _fixed(s, first)[[wind]]
    whole = fixed.all()
    tables = [] if whole else [of_names("Required deflection", keys, first, doubts, marks)]
    if whole and fixed.size == 1:
        tables = [whole_flight(s, wind or 0)]
    if s.freezing_error:
        band = Requirement(dead_band=s.dead_bands[0])
        off = [[_off(s, band, i, wind)] for i in range(s.times.size)]
        errors = (_freezing_error(s, band, i, wind) for i in range(s.times.size))
        shown = [abs(error) <= _MAX_FREEZING_ERROR for error in errors]
        caption, last = "The same with the vehicle frozen at each flight time", [_OFF.format(band)]
        if whole:
            caption = "Required deflection with the vehicle frozen at each flight time"
            off = [[*one, *more] for one, more in zip(off, marks, strict=True)]
            last += doubts
        times = keys if whole else [_time(time) for time in s.times]
        if not all(shown):
            caption += ", where that is off by at most 100 %"
        if any(shown):
            tables.append(of_names(caption, times, frozen, last, off, shown))
    if s.separate:
        alone = (f"{plane} alone" for plane in s.separate)
        head = ["time [s]", "both planes", *alone, "pitch alone misses [%]"]
        nominal = replace(counted, direction="")
        by = tuple(_by_planes(s, nominal, i, wind) for i in _differing(s, nominal, wind))
        tables.append(Table(f"{nominal} by planes [deg]{of}", tuple(head), by))
    return tables


def whole_flight(s: Sizing, wind: int) -> Table:
    """Return the requirements of a wind that is fixed in the flight, and when they arise [s]."""
    name, rows = s.winds[wind], []
    for requirement, worst in s.worst_in(name).items():
        if not np.isnan(s.arising(requirement)[wind]):
            key = f"flight.whole.{wind}.{requirement}"
            size, when = degrees(key, worst.deflection), significant(f"{key}.time", worst.time, 4)
            rows.append(((_short(requirement),), size, when))
    head = ("requirement", "[deg]", "arises at [s]")
    return Table(f"Required deflection over the whole flight: {name}", head, tuple(rows))


def _fixed(s: Sizing, names: Sequence[Requirement]) -> BoolArray:
    """Return which winds have one number for the flight of all these requirements, ``(m,)``."""
    return np.all([~np.isnan(s.arising(name)) for name in names], axis=0)


def _differing(s: Sizing, name: Requirement, wind: int | None) -> Sequence[int]:
    """Return indices of flight times at which a requirement differs: of a fixed wind the first."""
    fixed = ~np.isnan(s.arising(name))
    known = np.isfinite(s.required[name])
    if not (fixed.all() if wind is None else fixed[wind]):
        return range(s.times.size)
    return [int(np.argmax(known.any(axis=1) if wind is None else known[:, wind]))]


def by_wind(s: Sizing, counted: Requirement) -> Table:
    """Return the largest of each requirement in each wind, and the time of the counted one."""
    names = _first(s)
    rows = []
    for j, wind in enumerate(s.winds):
        worst = s.worst_in(wind)
        largest = {k: degrees(f"largest.{j}.{k}", one.deflection) for k, one in worst.items()}
        when = significant("", worst[counted].time, 5) if counted in worst else ("-",)
        rows.append(((wind,), *(largest.get(k, ("-",)) for k in names), when))
    head = ("wind", *map(_short, names), f"{counted}: time [s]")
    return Table("The largest over the flight, by wind [deg]", head, tuple(rows))


def each_wind(s: Sizing, counted: Requirement) -> list[Table]:
    """Return one requirement by flight time, with a column for each wind that has a row for each.

    Nothing where there are fewer than two such winds.
    """
    several = np.flatnonzero(np.isnan(s.arising(counted))).tolist()
    if len(several) < 2:
        return []
    rows = [
        (_time(time), *(degrees(f"each.{i}.{j}", needs[j]) for j in several))
        for i, (time, needs) in enumerate(zip(s.times, s.required[counted], strict=True))
    ]
    head = ("time [s]", *(s.winds[j] for j in several))
    return [Table(f"{counted} in each wind [deg]", head, tuple(rows))]


def _first(s: Sizing) -> list[Requirement]:
    """Return the requirements of the first table: the varying ones, if there are any."""
    varying = [one for one in s.required if one.varying or one.direction]
    return varying if s.freezing_error else list(s.required)


def _required(s: Sizing, names: Sequence[Requirement], wind: int | None) -> list[tuple[Line, ...]]:
    by_time = {k: np.where(np.isnan(s.arising(k)), s.required[k], np.nan) for k in names}
    found = {
        k: np.fmax.reduce(by_time[k], axis=1) if wind is None else s.required[k][:, wind]
        for k in names
    }
    return [
        tuple(degrees(f"{_key(i, wind)}.{k}", found[k][i]) for k in names)
        for i in range(s.times.size)
    ]


def _doubts(s: Sizing, i: int, wind: int | None) -> list[Line]:
    """Return the cells of doubts at a flight time: of one wind, or the marks of all winds."""
    if wind is not None:
        change = number(f"{_key(i, wind)}.change_percent", 100.0 * s.change[i, wind], 1)
        one_pole, data = not s.beyond_one_pole[i, wind], s.covered[i, wind]
        return [change, ("yes" if one_pole else "no",), ("yes" if data else "no",)]
    return [(_marks(s, i),)]


def _marks(s: Sizing, i: int) -> str:
    marks = {
        "1": s.beyond_one_pole[i].any(),
        "~": not s.freezing_error and (s.change[i] > STEADY).any(),
        "+": not s.covered[i].all(),
        "=": s.unsigned is not None and s.unsigned[i].any(),
        "?": not s.known[i].all(),
    }
    return "".join(mark for mark, there in marks.items() if there)


def _off(s: Sizing, name: Requirement, i: int, wind: int | None) -> Line:
    """Return the error [%] of a frozen requirement at a flight time, in the worst or one wind."""
    percent = 100.0 * _freezing_error(s, name, i, wind)
    return number(f"{_key(i, wind)}.frozen_off_percent", percent, 1)


def _freezing_error(s: Sizing, name: Requirement, i: int, wind: int | None) -> float:
    """Relative error of a frozen requirement at a flight time, in the worst wind or in one."""
    along = s.required[replace(name, varying=True)][i]
    j = int(np.argmax(np.nan_to_num(along, nan=-1.0))) if wind is None else wind
    return float(np.nan_to_num(s.freezing_error[name][i, j]))


def _short(requirement: Requirement) -> str:
    """Return a requirement as the head of its column: the direction of the wind, or its name."""
    bounds = {"no forecast": NO_FORECAST, "minimum": WIND_KNOWN}
    name = bounds.get(requirement.name, requirement.name)
    return f"{requirement.direction} wind" if requirement.direction else name


def _by_planes(s: Sizing, counted: Requirement, i: int, wind: int | None) -> tuple[Line, ...]:
    """Return the requirement of each plane at a flight time, in one wind or the worst for both."""
    both, key = s.required[counted][i], f"{_key(i, wind)}.planes"
    j = int(np.argmax(np.nan_to_num(both, nan=-1.0))) if wind is None else wind
    arises = float(s.arising(counted)[j])
    return (
        _time(s.times[i]) if np.isnan(arises) else significant("", arises, 4),
        degrees(f"{key}.both", both[j]),
        *(degrees(f"{key}.{k}", one.required[counted][i, j]) for k, one in s.separate.items()),
        number(f"{key}.missing_percent", 100.0 * s.pitch_omitted_fraction[counted][i, j], 1),
    )


def _key(i: int, wind: int | None) -> str:
    return f"flight.{'worst' if wind is None else wind}.{i}"


def _time(time: float) -> Line:
    return (text(significant("", time, 6)),)
