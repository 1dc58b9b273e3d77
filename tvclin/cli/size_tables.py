"""What `tvclin size` prints: tables of a sizing and its total."""

from typing import TYPE_CHECKING

from tvclin.cli.output import say

if TYPE_CHECKING:
    from tvclin.answers.sizing.record import Sizing
    from tvclin.answers.sizing.total import DeflectionTotal


_COLUMNS = 6
"""Winds that have a column each, as many as a terminal has room for."""


def print_sizing(
    found: "Sizing", total: "DeflectionTotal", source: str, counted: str, said: list[str]
) -> None:
    """Print the required deflections, the total and all notes; some come from elsewhere."""
    from tvclin.answers.sizing.record import VARYING

    name = found.schedule.vehicle.name or source
    planes = "both planes, one stop" if found.alone else found.plane
    say(f"{name}, {found.model}, {planes}: {', '.join(found.winds)}\n")
    frozen = [name for name in found.required if not name.endswith(VARYING)]
    _print_required(found, "Required deflection [deg]", frozen)
    if len(frozen) < len(found.required):
        rest = [name for name in found.required if name not in frozen]
        _print_required(found, "The same, parameters varying while the wind blows [deg]", rest)
    if found.alone:
        _print_planes(found, counted)
    if not (found.steady.all() and found.known.all()) or found.beyond_one_pole.any():
        say(
            "1: beyond the single-pole theory; ~: parameters change while the wind blows; +: beyond"
            " the schedule; ?: a wind is not known"
        )
    if len(found.winds) > 1:
        _print_by_wind(found, frozen, counted)
    trusts = "; K below 1 trusts a forecast" if (found.dead_bands < 1.0).any() else ""
    say(f"no forecast: {found.law_words}; minimum: the wind known, appendix C{trusts}")
    _print_total(total)
    for note in (*found.notes, *said):
        say(f"Note: {note}.")


def _print_required(found: "Sizing", title: str, names: list[str]) -> None:
    import numpy as np

    from tvclin.answers.sizing.record import VARYING
    from tvclin.cli.output import print_table

    columns = [np.degrees(found.at_times(name)) for name in names]
    rows = [
        [f"{time:g}", *(_cell(column[i]) for column in columns), _doubts(found, i)]
        for i, time in enumerate(found.times.tolist())
    ]
    print_table(title, ["time [s]", *(name.removesuffix(VARYING) for name in names), ""], rows)


def _print_planes(found: "Sizing", counted: str) -> None:
    """What each plane by itself asks for in the wind that is worst for both."""
    import numpy as np

    from tvclin.cli.output import print_table

    both, rows = found.required[counted], []
    for i, time in enumerate(found.times.tolist()):
        if np.all(np.isnan(both[i])):
            rows.append([f"{time:g}", "-", "-", "-", "-"])
            continue
        j = int(np.nanargmax(both[i]))
        alone = [_cell(np.degrees(one.required[counted][i, j])) for one in found.alone.values()]
        missing = 100.0 * found.pitch_misses[counted][i, j]
        rows.append([f"{time:g}", _cell(np.degrees(both[i, j])), *alone, f"{missing:.0f}"])
    headings = ["time [s]", "both", *(f"{plane} alone" for plane in found.alone)]
    print_table(f"{counted} by planes [deg]", [*headings, "pitch alone is too little by [%]"], rows)


def _print_by_wind(found: "Sizing", names: list[str], counted: str) -> None:
    """The largest of each requirement in each wind, and when the one that counts is largest."""
    import numpy as np

    from tvclin.cli.output import print_table

    rows = []
    for wind in found.winds:
        worst = found.worst_in(wind)
        cells = [_cell(np.degrees(worst[k].deflection)) if k in worst else "-" for k in names]
        rows.append([wind, *cells, f"{worst[counted].time:g}" if counted in worst else "-"])
    headings = ["wind", *names, f"{counted}: time [s]"]
    print_table("The largest over the flight, by wind [deg]", headings, rows)
    if len(found.winds) <= _COLUMNS:
        each = np.degrees(found.required[counted])
        over_time = [
            [f"{time:g}", *map(_cell, row)]
            for time, row in zip(found.times.tolist(), each.tolist(), strict=True)
        ]
        print_table(f"{counted} in each wind [deg]", ["time [s]", *found.winds], over_time)


def _cell(degrees: float) -> str:
    from math import isnan

    return "-" if isnan(degrees) else f"{degrees:.4f}"


def _print_total(total: "DeflectionTotal") -> None:
    import numpy as np

    from tvclin.cli.output import print_pairs

    pairs = [
        (f"{line.name} ({line.kind})", f"{np.degrees(line.deflection):.4f} deg")
        for line in total.lines
    ]
    pairs.append(
        (
            "total: systematic parts added, random by root of sum of squares",
            f"{np.degrees(total.total):.4f} deg",
        )
    )
    if total.reserve:
        said = f"{np.degrees(total.required):.4f} deg"
        pairs.append((f"limit that keeps {100 * total.reserve:g} % in reserve", said))
    at, kept = total.words
    print_pairs(f"\nThe {at}", pairs, columns=1)
    if total.limit is not None and total.left is not None:
        left, short = np.degrees(abs(total.left)), np.degrees(total.required - total.limit)
        said = f"SUFFICIENT, {left:.4f} deg left{kept}"
        if total.sufficient is None:
            said = (
                f"NOT KNOWN to be sufficient; where the winds are known {left:.4f} deg left{kept}"
            )
        if total.sufficient is False:
            said = f"NOT SUFFICIENT, short by {short:.4f} deg"
        say(f"Limit {np.degrees(total.limit):.4f} deg: {said}")
    if total.not_sized:
        say(f"NOT SIZED {', '.join(total.not_sized)}")


def _doubts(found: "Sizing", i: int) -> str:
    """Marks of a flight time: what is doubtful there in any wind."""
    from tvclin.answers.sizing.record import STEADY

    marks = {
        "1": found.beyond_one_pole[i].any(),
        "~": (found.change[i] > STEADY).any(),
        "+": not found.covered[i].all(),
        "?": not found.known[i].all(),
    }
    return "".join(mark for mark, there in marks.items() if there)
