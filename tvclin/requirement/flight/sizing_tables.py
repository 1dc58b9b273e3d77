"""Tables of a sizing over flight time, and the legend of their columns."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import compress, repeat

import numpy as np

from tvclin.base.arrays import BoolArray
from tvclin.base.fields import record_table
from tvclin.base.lines import Line, Table, degrees, number, significant, text
from tvclin.base.quantities import NO_FORECAST, QUANTITIES, WIND_KNOWN
from tvclin.requirement.flight.sizing import STEADY, Sizing
from tvclin.requirement.required_quantity import MINIMUM, Requirement, heading_of

_MARKS = {
    "1": "beyond the single-pole theory",
    "~": "parameters change during the wind",
    "+": "the wind extends beyond the schedule",
    "=": "the effect of the sign of a pulse is not known; both signs have the nominal requirement",
    "?": "a wind is not known",
}
"""Meanings of the marks of flight times in a table of the worst winds."""
_FREEZING_ERROR_HEAD = "{} off by [%]"
"""Head of the column with the error of a frozen requirement."""
_MAX_FREEZING_ERROR = 1.0
"""Relative error above which a frozen requirement is no approximation, as at a low speed."""

COLUMNS = (
    "Change: relative change of beta or B during the wind; above"
    f" {100 * STEADY:g} % a frozen vehicle is doubtful. One pole: whether the slow motion of the"
    " flight path may be neglected. Data: whether the wind is known, and the flight data cover it."
)
"""Definitions of the columns of validity, in sentences."""


def _marks_line(sizing: Sizing) -> str:
    """Return the meanings of the marks in a table of the worst winds; empty without marks."""
    present = {mark for i in range(sizing.times.size) for mark in _marks(sizing, i)}
    return "; ".join(f"{mark}: {words}" for mark, words in _MARKS.items() if mark in present)


def legend(sizing: Sizing) -> str:
    """Return the definitions of the requirements of a sizing, in sentences."""
    first = Requirement(dead_band=sizing.dead_bands[0])
    sentences = [
        f"{NO_FORECAST.capitalize()}: {sizing.law_words}.",
        f"{WIND_KNOWN.capitalize()}: {QUANTITIES[WIND_KNOWN]}.",
    ]
    if (sizing.dead_bands < 1.0).any():
        sentences.append("K below 1 trusts a forecast.")
    if any(requirement.direction for requirement in sizing.required):
        sentences.append(
            f"Head and tail wind: K = {first.dead_band:g} with the dynamic pressure in them."
        )
    if sizing.freezing_error:
        sentences.append(
            f"{_FREEZING_ERROR_HEAD.format(first)}: by how much it is larger with the vehicle"
            " frozen at the flight time than with one that changes during the wind."
        )
    if line := _frozen_bounds_line(sizing):
        sentences.append(line)
    return " ".join(sentences)


def _frozen_bounds_line(sizing: Sizing) -> str:
    """Return a sentence on the lower bound of the frozen vehicle, where it is off by over a tenth.

    Empty without varying parameters, and where both bounds with the wind known nearly agree.
    """
    errors = sizing.freezing_error.get(MINIMUM, np.zeros(0))
    errors = np.where(np.isfinite(errors), errors, 0.0)
    if np.abs(errors).max(initial=0.0) <= STEADY:
        return ""
    i, j = np.unravel_index(int(np.abs(errors).argmax()), errors.shape)
    return (
        "A lower bound of the frozen vehicle holds for that vehicle alone: with the wind known it"
        f" is {1.0 + errors[i, j]:.3g} times the bound with parameters that change, which counts"
        f" (in {sizing.winds[j]} at {sizing.times[i]:.6g} s)."
    )


def time_tables(sizing: Sizing, counted: Requirement, wind: int | None = None) -> list[Table]:
    """Return tables of the requirements of a sizing by flight time, in one wind or in the worst.

    `counted`: requirement that the budget counts. `wind`: index of the wind; None for the worst
    wind of each time.

    The first table has parameters that vary during the wind, where the sizing has them, and head
    and tail winds; a wind that is fixed in the flight has a single number, with the time at which
    it arises. The second has frozen parameters; for both planes a third has the counted requirement
    of each plane.
    """
    frozen = [
        requirement
        for requirement in sizing.required
        if not (requirement.varying or requirement.direction)
    ]
    first = _first_requirements(sizing)
    if wind is not None:
        first = [requirement for requirement in first if _counts(sizing, requirement, wind)]
    suffix = "" if wind is None else f": {sizing.winds[wind]}"
    # heads and cells of the last columns, on how far a number of the first table is valid
    validity = ("",) if wind is None else ("change [%]", "one pole", "data")
    marks = [_validity_cells(sizing, i, wind) for i in range(sizing.times.size)]

    def of_names(
        caption: str,
        times: list[Line],
        names: list[Requirement],
        last: Sequence[str],
        more: list[list[Line]],
        shown: Iterable[bool] = repeat(True),
    ) -> Table:
        """Return the table of the requirements `names` [deg] of `sizing` in one or the worst wind.

        `times`: first cells of rows, the flight times. `last`, `more`: heads of the last columns,
        and their cells by row. `shown`: whether a row is in the table. The `suffix` of the
        `caption` names the `wind`; after it stand the meanings of marks.
        """
        head = ("time [s]", *map(_short, names), *last)
        rows_of_cells = zip(times, _required(sizing, names, wind), more, strict=True)
        rows = tuple(
            (time, *needs, *cells) for time, needs, cells in compress(rows_of_cells, shown)
        )
        marked = _marks_line(sizing) if wind is None and validity[0] in last else ""
        return Table("; ".join(filter(None, (f"{caption} [deg]{suffix}", marked))), head, rows)

    keys = [significant(f"{_key(i, wind)}.time", time, 6) for i, time in enumerate(sizing.times)]
    # whether each wind is fixed in the flight, with a single number that needs no row
    fixed = _is_fixed(sizing, first) if wind is None else _is_fixed(sizing, first)[[wind]]
    all_fixed = fixed.all()
    tables = [] if all_fixed else [of_names("Required deflection", keys, first, validity, marks)]
    if all_fixed and fixed.size == 1:
        tables = [fixed_wind_table(sizing, wind or 0)]
    if sizing.freezing_error:  # known: of the frozen requirement, over the varying one
        band = Requirement(dead_band=sizing.dead_bands[0])
        errors = [_freezing_error(sizing, band, i, wind) for i in range(sizing.times.size)]
        last, cells = (
            [_FREEZING_ERROR_HEAD.format(band)],
            [
                [number(f"{_key(i, wind)}.frozen_off_percent", 100.0 * error, 1)]
                for i, error in enumerate(errors)
            ],
        )
        if all_fixed:  # there is no first table with the columns of validity
            cells = [[*cell, *more] for cell, more in zip(cells, marks, strict=True)]
            last += validity
        shown = [not abs(error) > _MAX_FREEZING_ERROR for error in errors]
        caption = "Required deflection with the vehicle frozen at each flight time"
        times = keys if all_fixed else [_time(time) for time in sizing.times]
        if not all(shown):
            caption += ", where that is off by at most 100 %"
        if any(shown):
            tables.append(of_names(caption, times, frozen, last, cells, shown))
    if sizing.separate:
        plane_heads = (f"{plane} alone" for plane in sizing.separate)
        head = ["time [s]", "both planes", *plane_heads, "pitch alone misses [%]"]
        nominal = replace(counted, direction="")
        rows_by_plane = tuple(
            _row_of_planes(sizing, nominal, i, wind) for i in _rows_of(sizing, nominal, wind)
        )
        tables.append(Table(f"{nominal} by planes [deg]{suffix}", tuple(head), rows_by_plane))
    return tables


def fixed_wind_table(sizing: Sizing, wind: int) -> Table:
    """Return the requirements of a wind that is fixed in the flight, and when they arise [s].

    `wind`: its index among the winds of the sizing. `arising` has the largest value [rad] of each
    requirement that has a time at which it arises.
    """
    name = sizing.winds[wind]
    arising = {
        k: x
        for k, x in sizing.worst_in(name).items()
        if not np.isnan(sizing.arising(k)[wind]) and _counts(sizing, k, wind)
    }
    return record_table(
        f"Required deflection over the whole flight: {name}",
        f"flight.whole.{wind}",
        list(arising.values()),
        *("deflection", "time"),
        labels=("requirement", map(_short, arising)),
    )


def _is_fixed(sizing: Sizing, names: Sequence[Requirement]) -> BoolArray:
    """Return whether each of the m winds of a sizing is fixed in flight time, ``(m,)``.

    Such a wind has one requirement for the whole flight, which arises at a known time, instead of
    one for each flight time. `names`: requirements of which all must be so.
    """
    return np.all([~np.isnan(sizing.arising(name)) for name in names], axis=0)


def _rows_of(sizing: Sizing, name: Requirement, wind: int | None) -> Sequence[int]:
    """Return the indices of the flight times at which a requirement has a row in a table.

    They are all. A wind that is fixed in flight time has one requirement for all flight times: then
    the first at which it is known. `name`: the requirement. `wind`: index of a wind; None for the
    worst, which is fixed where all winds are.
    """
    fixed = ~np.isnan(sizing.arising(name))
    finite = np.isfinite(sizing.required[name])
    if not (fixed.all() if wind is None else fixed[wind]):
        return range(sizing.times.size)
    return [int(np.argmax(finite.any(axis=1) if wind is None else finite[:, wind]))]


def by_wind(sizing: Sizing, counted: Requirement) -> Table:
    """Return the table of the largest of each requirement in each wind of a sizing.

    `counted`: requirement whose time of the largest is in the last column.
    """
    names = _first_requirements(sizing)
    rows = []
    for j, wind in enumerate(sizing.winds):
        worst = sizing.worst_in(wind)
        largest = {k: degrees(f"largest.{j}.{k}", x.deflection) for k, x in worst.items()}
        time = significant("", worst[counted].time, 5) if counted in worst else ("-",)
        rows.append(((wind,), *(largest.get(k, ("-",)) for k in names), time))
    head = ("wind", *map(_short, names), f"{counted}: time [s]")
    return Table("The largest over the flight, by wind [deg]", head, tuple(rows))


def wind_columns_table(sizing: Sizing, counted: Requirement) -> list[Table]:
    """Return the table of one requirement by flight time, with a column for each wind.

    `counted`: the requirement. Winds that are the same at all flight times are omitted; no table
    for fewer than two other winds.
    """
    # winds that are placed at each flight time have no single time at which they arise
    several = np.flatnonzero(np.isnan(sizing.arising(counted))).tolist()
    if len(several) < 2:
        return []
    rows = [
        (_time(time), *(degrees(f"each.{i}.{j}", needs[j]) for j in several))
        for i, (time, needs) in enumerate(zip(sizing.times, sizing.required[counted], strict=True))
    ]
    head = ("time [s]", *(sizing.winds[j] for j in several))
    return [Table(f"{counted} in each wind [deg]", head, tuple(rows))]


def _first_requirements(sizing: Sizing) -> list[Requirement]:
    """Return the requirements in the first table of a sizing.

    They are the requirements with varying parameters or the pressure of a head or tail wind, if
    there is a `freezing_error`, the comparison of frozen and varying parameters; else all.
    """
    varying = [
        requirement
        for requirement in sizing.required
        if requirement.varying or requirement.direction
    ]
    return varying if sizing.freezing_error else list(sizing.required)


def _counts(sizing: Sizing, requirement: Requirement, wind: int) -> bool:
    """Return whether a requirement in a wind of a sizing is not its nominal one once more.

    A sounding has its own direction: its requirement in a head or a tail wind is the nominal one.
    `wind`: index of the wind.
    """
    nominal = replace(requirement, direction="")
    if requirement == nominal or nominal not in sizing.required:
        return True
    values, nominal_values = (sizing.required[k][:, wind] for k in (requirement, nominal))
    return not np.array_equal(values, nominal_values, equal_nan=True)


def _required(
    sizing: Sizing, names: Sequence[Requirement], wind: int | None
) -> list[tuple[Line, ...]]:
    """Return the cells of requirements [deg], a row for each flight time of a sizing.

    `names`: requirements of the columns. `wind`: index of a wind; None for the worst.
    """
    # winds fixed in flight time have a single number, at a time of their own, in no row
    by_time = {k: np.where(np.isnan(sizing.arising(k)), sizing.required[k], np.nan) for k in names}
    required = {
        k: np.fmax.reduce(by_time[k], axis=1) if wind is None else sizing.required[k][:, wind]
        for k in names
    }
    return [
        tuple(degrees(f"{_key(i, wind)}.{k}", required[k][i]) for k in names)
        for i in range(sizing.times.size)
    ]


def _validity_cells(sizing: Sizing, i: int, wind: int | None) -> list[Line]:
    """Return the cells of validity of the requirements at a flight time.

    In one wind they are the relative change of beta (rate of the attitude) or B (trim deflection
    per angle of attack) during the wind [%], whether a single pole is sufficient, and whether the
    wind is known and the schedule covers it; in the worst wind a cell of marks. `i`: index of the
    flight time. `wind`: index of a wind, None for the worst.
    """
    if wind is not None:
        change = number(f"{_key(i, wind)}.change_percent", 100.0 * sizing.change[i, wind], 1)
        single_pole = not sizing.beyond_single_pole[i, wind]
        data = sizing.covered[i, wind] and sizing.known[i, wind]
        return [change, ("yes" if single_pole else "no",), ("yes" if data else "no",)]
    return [(_marks(sizing, i),)]


def _marks(sizing: Sizing, i: int) -> str:
    """Return the marks of the flight time with index `i`, keys of `_MARKS`.

    A mark is set where its condition holds for at least one of the winds at that time.
    """
    marks = {
        "1": sizing.beyond_single_pole[i].any(),
        "~": not sizing.freezing_error and (sizing.change[i] > STEADY).any(),  # of beta or B
        "+": not sizing.covered[i].all(),  # the flight ends before the wind, or begins after it
        "=": sizing.unsigned is not None and sizing.unsigned[i].any(),  # effect of sign not known
        "?": not sizing.known[i].all(),
    }
    return "".join(mark for mark, present in marks.items() if present)


def _freezing_error(sizing: Sizing, name: Requirement, i: int, wind: int | None) -> float:
    """Return the relative error of the frozen requirement `name`; NaN if unknown.

    It is against the requirement with parameters that vary during the wind. `i`: index of the
    flight time; `wind`: index of a wind, None for the worst.
    """
    along = sizing.required[replace(name, varying=True)][i]  # [rad], by wind
    # the worst wind: an unknown requirement is below all others, which are not negative
    j = int(np.argmax(np.nan_to_num(along, nan=-1.0))) if wind is None else wind
    unknown = np.isnan(along[j]) or np.isnan(sizing.required[name][i, j])
    return np.nan if unknown else float(np.nan_to_num(sizing.freezing_error[name][i, j]))


def _short(requirement: Requirement) -> str:
    """Return the head of the column of a requirement: direction of the wind, or its name."""
    if requirement.direction:
        return f"{requirement.direction} wind"
    return heading_of(requirement.name)


def _row_of_planes(
    sizing: Sizing, nominal: Requirement, i: int, wind: int | None
) -> tuple[Line, ...]:
    """Return the row of a flight time in the table by planes, five cells in the order of its head.

    They are the time [s], the requirement [deg] of both planes, of pitch and of yaw, and the
    fraction [%] that a limit for pitch alone misses. The time is the flight time, or, for a wind
    fixed in the flight, that at which its requirement arises. `nominal`: key of the requirement at
    nominal dynamic pressure. `i`, `wind`: indices of flight time and wind, None for the worst.
    """
    required, key = sizing.required[nominal][i], f"{_key(i, wind)}.planes"  # [rad], by wind
    # the worst wind: an unknown requirement is below all others, which are not negative
    j = int(np.argmax(np.nan_to_num(required, nan=-1.0))) if wind is None else wind
    arises = float(sizing.arising(nominal)[j])  # NaN: the wind is placed at each flight time
    return (
        _time(sizing.times[i]) if np.isnan(arises) else significant("", arises, 4),
        degrees(f"{key}.both", required[j]),
        *(
            degrees(f"{key}.{plane}", of_plane.required[nominal][i, j])
            for plane, of_plane in sizing.separate.items()
        ),
        number(f"{key}.missing_percent", 100.0 * sizing.pitch_omitted_fraction[nominal][i, j], 1),
    )


def _key(i: int, wind: int | None) -> str:
    """Return the prefix of the names of numbers at a flight time.

    `i`: index of the flight time; `wind`: index of a wind, None for the worst.
    """
    return f"flight.{'worst' if wind is None else wind}.{i}"


def _time(time: float) -> Line:
    """Return the cell of a flight time [s]."""
    return (text(significant("", time, 6)),)
