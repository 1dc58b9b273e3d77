"""A sizing as tables over flight time, and what stands in their columns, in words."""

from collections.abc import Sequence

import numpy as np

from tvclin.answers.sizing.record import IN_A, STEADY, VARYING, Sizing
from tvclin.base.lines import Line, Table, degrees, number, significant, text

_MARKS = {
    "1": "beyond the single-pole theory",
    "~": "parameters change while the wind blows",
    "+": "beyond the schedule",
    "=": "what the sign of a pulse changes is not known, and calm air's number stands for both",
    "?": "a wind is not known",
}
"""What the marks of flight times mean in a table of the worst winds."""


def marks_line(s: Sizing) -> str:
    """Return what the marks mean that a table of the worst winds has; nothing if it has none."""
    there = {mark for i in range(s.times.size) for mark in _marks(s, i)}
    return "; ".join(f"{mark}: {words}" for mark, words in _MARKS.items() if mark in there)


def legend(s: Sizing) -> str:
    """Return what the requirements of a sizing are, in sentences."""
    trusts = " K below 1 trusts a forecast." if (s.dead_bands < 1.0).any() else ""
    signed = f" Head and tail wind: K = {s.dead_bands[0]:g} with the dynamic pressure in them."
    signed *= any(name.endswith(tuple(IN_A.values())) for name in s.required)
    return f"No forecast: {s.law_words}. Minimum: the wind is known (appendix C).{trusts}{signed}"


def over_time(s: Sizing, counted: str, wind: int | None = None) -> list[Table]:
    """Return by flight time what one wind asks for, of its place, or the worst wind of each time.

    First with parameters that vary while the wind blows, where the sizing has them, and in head and
    tail winds; then with those of each flight time; and for both planes what each by itself asks
    for of the requirement that is counted.
    """
    frozen = [name for name in s.required if ", " not in name]
    first = _first(s)
    of = "" if wind is None else f": {s.winds[wind]}"
    doubts = ("",) if wind is None else ("change [%]", "one pole", "data")
    marks = [_doubts(s, i, wind) for i in range(s.times.size)]

    def of_names(
        caption: str,
        times: list[Line],
        names: list[str],
        last: Sequence[str],
        more: list[list[Line]],
    ) -> Table:
        head = ("time [s]", *map(_short, names), *last)
        each = zip(times, _required(s, names, wind), more, strict=True)
        rows = tuple((time, *needs, *cells) for time, needs, cells in each)
        return Table(f"{caption} [deg]{of}", head, rows)

    keys = [significant(f"{_key(i, wind)}.time", time, 6) for i, time in enumerate(s.times)]
    tables = [of_names("Required deflection", keys, first, doubts, marks)]
    if s.freezing_error:
        name = f"K = {s.dead_bands[0]:g}"
        off = [[_off(s, name, i, wind)] for i in range(s.times.size)]
        caption = "The same with the vehicle frozen at each flight time"
        times = [_time(time) for time in s.times]
        tables.append(of_names(caption, times, frozen, (f"{name} off by [%]",), off))
    if s.alone:
        alone = (f"{plane} alone" for plane in s.alone)
        head = ["time [s]", "both planes", *alone, "pitch alone misses [%]"]
        calm = next(
            (counted.removesuffix(x) for x in IN_A.values() if counted.endswith(x)), counted
        )
        by = tuple(_by_planes(s, calm, i, wind) for i in range(s.times.size))
        tables.append(Table(f"{calm} by planes [deg]{of}", tuple(head), by))
    return tables


def by_wind(s: Sizing, counted: str) -> Table:
    """Return the largest of each requirement in each wind, and when what counts is."""
    names = _first(s)
    rows = []
    for j, wind in enumerate(s.winds):
        worst = s.worst_in(wind)
        largest = {k: degrees(f"largest.{j}.{k}", one.deflection) for k, one in worst.items()}
        when = _time(worst[counted].time) if counted in worst else ("-",)
        rows.append(((wind,), *(largest.get(k, ("-",)) for k in names), when))
    head = ("wind", *map(_short, names), f"{counted}: time [s]")
    return Table("The largest over the flight, by wind [deg]", head, tuple(rows))


def each_wind(s: Sizing, counted: str) -> Table:
    """Return one requirement by flight time, with a column for each wind."""
    rows = [
        (_time(time), *(degrees(f"each.{i}.{j}", need) for j, need in enumerate(needs)))
        for i, (time, needs) in enumerate(zip(s.times, s.required[counted], strict=True))
    ]
    return Table(f"{counted} in each wind [deg]", ("time [s]", *s.winds), tuple(rows))


def _first(s: Sizing) -> list[str]:
    """The requirements that come first: varying ones, if there are any, in calm air and winds."""
    ends = (VARYING, *IN_A.values())
    varying = [name for name in s.required if name.endswith(ends)]
    return varying if s.freezing_error else list(s.required)


def _required(s: Sizing, names: Sequence[str], wind: int | None) -> list[tuple[Line, ...]]:
    found = {k: s.at_times(k) if wind is None else s.required[k][:, wind] for k in names}
    return [
        tuple(degrees(f"{_key(i, wind)}.{k}", found[k][i]) for k in names)
        for i in range(s.times.size)
    ]


def _doubts(s: Sizing, i: int, wind: int | None) -> list[Line]:
    """What is doubtful at a flight time: the cells of one wind, or the marks of any of them."""
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


def _off(s: Sizing, name: str, i: int, wind: int | None) -> Line:
    """By how much a frozen requirement is off at a flight time, in the worst wind or in one."""
    along = s.required[f"{name}{VARYING}"][i]
    j = int(np.argmax(np.nan_to_num(along, nan=-1.0))) if wind is None else wind
    return number(f"{_key(i, wind)}.frozen_off_percent", 100.0 * s.freezing_error[name][i, j], 1)


def _short(name: str) -> str:
    """A requirement as the head of its column."""
    for ending in IN_A.values():
        if name.endswith(ending):
            return ending.removeprefix(", ")
    return name.removesuffix(VARYING)


def _by_planes(s: Sizing, counted: str, i: int, wind: int | None) -> tuple[Line, ...]:
    """What each plane asks for at a flight time, in one wind or in that which is worst for both."""
    both, key = s.required[counted][i], f"{_key(i, wind)}.planes"
    j = int(np.argmax(np.nan_to_num(both, nan=-1.0))) if wind is None else wind
    return (
        _time(s.times[i]),
        degrees(f"{key}.both", both[j]),
        *(degrees(f"{key}.{k}", one.required[counted][i, j]) for k, one in s.alone.items()),
        number(f"{key}.missing_percent", 100.0 * s.pitch_misses[counted][i, j], 1),
    )


def _key(i: int, wind: int | None) -> str:
    return f"flight.{'worst' if wind is None else wind}.{i}"


def _time(time: float) -> Line:
    return (text(significant("", time, 6)),)
