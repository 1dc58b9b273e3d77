"""A sizing as tables over flight time, and what stands in their columns, in words."""

from collections.abc import Sequence

import numpy as np

from tvclin.answers.sizing.record import STEADY, VARYING, Sizing
from tvclin.base.lines import Line, Table, degrees, number, significant, text

MARKS = (
    "1: beyond the single-pole theory; ~: parameters change while the wind blows; +: beyond the"
    " schedule; ?: a wind is not known"
)
"""What the marks of flight times mean in a table of the worst winds."""


def legend(s: Sizing) -> str:
    """Return what the requirements of a sizing are, in sentences."""
    trusts = " K below 1 trusts a forecast." if (s.dead_bands < 1.0).any() else ""
    return f"No forecast: {s.law_words}. Minimum: the wind is known (appendix C).{trusts}"


def over_time(s: Sizing, counted: str, wind: int | None = None) -> list[Table]:
    """Return by flight time what one wind asks for, or the worst wind of each time.

    Frozen parameters come first, with what is doubtful of them; then, where the sizing has them,
    varying ones, and for both planes what each plane by itself asks for.

    Parameters
    ----------
    s : Sizing
        The sizing.
    counted : str
        The requirement that is shown by planes.
    wind : int, optional
        The place of a wind; the worst of all at each time without it.
    """
    frozen = [name for name in s.required if not name.endswith(VARYING)]
    varying = [name for name in s.required if name.endswith(VARYING)]
    of = "" if wind is None else f": {s.winds[wind]}"
    doubts = ("",) if wind is None else ("change [%]", "one pole", "data")
    rows = [
        (significant(f"{_key(i, wind)}.time", time, 6), *row[1:], *_doubts(s, i, wind))
        for i, (time, row) in enumerate(zip(s.times, _required(s, frozen, wind), strict=True))
    ]
    tables = [
        Table(f"Required deflection [deg]{of}", ("time [s]", *frozen, *doubts), tuple(rows)),
    ]
    if varying:
        head = ["time [s]", *(name.removesuffix(VARYING) for name in varying)]
        caption = f"The same, parameters varying while the wind blows [deg]{of}"
        tables.append(Table(caption, tuple(head), tuple(_required(s, varying, wind))))
    if s.alone:
        alone = (f"{plane} alone" for plane in s.alone)
        head = ["time [s]", "both planes", *alone, "pitch is too little by [%]"]
        rows = [_by_planes(s, counted, i, wind) for i in range(s.times.size)]
        tables.append(Table(f"{counted} by planes [deg]{of}", tuple(head), tuple(rows)))
    return tables


def by_wind(s: Sizing, counted: str) -> Table:
    """Return the largest of each frozen requirement in each wind, and when what counts is."""
    names = [name for name in s.required if not name.endswith(VARYING)]
    rows = []
    for j, wind in enumerate(s.winds):
        worst = s.worst_in(wind)
        largest = {k: degrees(f"largest.{j}.{k}", one.deflection) for k, one in worst.items()}
        when = _time(worst[counted].time) if counted in worst else ("-",)
        rows.append(((wind,), *(largest.get(k, ("-",)) for k in names), when))
    head = ("wind", *names, f"{counted}: time [s]")
    return Table("The largest over the flight, by wind [deg]", head, tuple(rows))


def each_wind(s: Sizing, counted: str) -> Table:
    """Return one requirement by flight time, with a column for each wind."""
    rows = [
        (_time(time), *(degrees(f"each.{i}.{j}", need) for j, need in enumerate(needs)))
        for i, (time, needs) in enumerate(zip(s.times, s.required[counted], strict=True))
    ]
    return Table(f"{counted} in each wind [deg]", ("time [s]", *s.winds), tuple(rows))


def _required(s: Sizing, names: Sequence[str], wind: int | None) -> list[tuple[Line, ...]]:
    found = {k: s.at_times(k) if wind is None else s.required[k][:, wind] for k in names}
    return [
        (_time(time), *(degrees(f"{_key(i, wind)}.{k}", found[k][i]) for k in names))
        for i, time in enumerate(s.times)
    ]


def _doubts(s: Sizing, i: int, wind: int | None) -> list[Line]:
    """What is doubtful at a flight time: the cells of one wind, or the marks of any of them."""
    if wind is not None:
        change = number(f"{_key(i, wind)}.change_percent", 100.0 * s.change[i, wind], 1)
        one_pole, data = not s.beyond_one_pole[i, wind], s.covered[i, wind]
        return [change, ("yes" if one_pole else "no",), ("yes" if data else "no",)]
    marks = {
        "1": s.beyond_one_pole[i].any(),
        "~": (s.change[i] > STEADY).any(),
        "+": not s.covered[i].all(),
        "?": not s.known[i].all(),
    }
    return [("".join(mark for mark, there in marks.items() if there),)]


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
