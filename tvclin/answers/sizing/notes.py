"""Notes on a sizing: where it is not known, doubtful, or largest at an end of the flight."""

from collections.abc import Collection, Mapping

import numpy as np

from tvclin.answers.sizing.record import STEADY, Sizing
from tvclin.winds.wind_angles import linear_notes

_MAX_LISTED_TIMES = 2
"""Largest number of flight times that are listed one by one."""
_RELATIVE_TOLERANCE = 1e-9
"""Relative difference up to which two deflections count as equal."""


def notes_of(found: Sizing) -> tuple[str, ...]:
    """Return notes on a sizing, each one sentence; often none."""
    return (
        *_unknown(found),
        *_beyond_one_pole(found),
        *found.said,
        *_changes(found),
        *_outside(found),
        *_at_the_ends(found),
    )


def unknown_rows(found: Sizing, whys: list[list[str]]) -> list[str]:
    """Return a note for each wind on the flight times at which it is not known, and why."""
    notes = []
    for j, wind in enumerate(found.winds):
        times = {float(t): row[j] for t, row in zip(found.times, whys, strict=True) if row[j]}
        if times:
            notes.append(f"{wind} is not known at {flight_times(times)}: {times[min(times)]}")
    return notes


def doubtful_winds(angles: Mapping[str, float]) -> list[str]:
    """Return notes on winds, by name, whose largest angle [rad] is doubtfully linear."""
    return [f"{wind}: {note}" for wind, angle in angles.items() for note in linear_notes(angle)]


def flight_times(times: Collection[float]) -> str:
    """Return in words at which flight times [s]."""
    ends = [f"{t:.6g} s" for t in sorted({min(times), max(times)})]
    return (
        f"{len(times)} flight times, {' to '.join(ends)}"
        if len(times) > _MAX_LISTED_TIMES
        else " and ".join(ends)
    )


def hundredths(time: float, *, up: bool) -> str:
    """Return a flight time [s] rounded up or down to hundredths, as options name it."""
    return f"{(np.ceil if up else np.floor)(100.0 * time) / 100.0:.10g}"


def _unknown(found: Sizing) -> list[str]:
    begin, end = found.schedule.span
    place = found.schedule.altitude_text
    return [
        f"{wind} is known from {place(first)} to {place(last)} only; beyond, it is unknown, not"
        " calm: it is not counted, and no flight time there is sized"
        for wind, (first, last) in zip(found.winds, found.known_times.tolist(), strict=True)
        if begin < first or last < end
    ]


def _beyond_one_pole(found: Sizing) -> list[str]:
    beyond = found.beyond_one_pole
    notes = []
    for j, wind in enumerate(found.winds):
        if np.any(beyond[:, j]):
            i = int(np.argmax(beyond[:, j]))
            lasts, edge = found.ends[i, j] - found.begins[i, j], found.edge[i]
            holds = "no triangle" if np.isnan(edge) else f"triangles up to {edge:.1f} s"
            notes.append(
                f"{wind} ({lasts:.4g} s at {found.times[i]:.6g} s) is beyond the single-pole"
                f" theory, which holds for {holds} there: the minimum counts two poles, and"
                " every dead band needs at least as much"
            )
    return notes


def _changes(found: Sizing) -> list[str]:
    if found.freezing_error or not np.any(found.change > STEADY):
        return []
    i, j = np.unravel_index(int(np.nanargmax(found.change)), found.change.shape)
    return [
        f"beta or B changes by up to {100 * found.change[i, j]:.0f} % while {found.winds[j]} blows"
        f" (at {found.times[i]:.6g} s); frozen parameters are doubtful above {100 * STEADY:.0f} %"
    ]


def _outside(found: Sizing) -> list[str]:
    if np.all(found.covered):
        return []
    first, last = found.schedule.span
    return [
        f"winds blow outside the schedule, {first:.6g} to {last:.6g} s; parameters are there those"
        " of its nearer end"
    ]


def _at_the_ends(found: Sizing) -> list[str]:
    """Return notes on requirements that are largest at the first or the last flight time."""
    order = np.argsort(found.times)
    ends: dict[str, list[str]] = {}
    for requirement in found.required:
        if requirement.varying or requirement.direction:  # follows the nominal one
            continue
        name, values = requirement.label, found.at_times(requirement)[order]
        times, values = found.times[order][~np.isnan(values)], values[~np.isnan(values)]
        if times.size < 2:
            continue
        if values[0] > (1.0 + _RELATIVE_TOLERANCE) * values[1:].max():
            ends.setdefault(f"first flight time, {times[0]:.6g} s; before", []).append(name)
        if values[-1] > (1.0 + _RELATIVE_TOLERANCE) * values[:-1].max():
            ends.setdefault(f"last flight time, {times[-1]:.6g} s; after", []).append(name)
    return [
        f"largest at the {end} it, these may be larger: {'; '.join(names)}"
        for end, names in ends.items()
    ]
