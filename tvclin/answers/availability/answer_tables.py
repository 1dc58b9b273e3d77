"""On how many days a limit is enough, as tables: by month, by part of the days, and unknown."""

from collections import Counter

import numpy as np

from tvclin.answers.availability.record import PLACARD, Availability
from tvclin.base.lines import Line, Table, degrees, minimum_limit, number

_MONTHS = (
    *("January", "February", "March", "April", "May", "June"),
    *("July", "August", "September", "October", "November", "December"),
)


def by_month(a: Availability) -> Table:
    """Return how many soundings of each month fly, towards each azimuth."""
    rows = []
    for month, parts in a.by_month().items():
        each = parts if isinstance(parts, tuple) else (parts,)
        for towards, part in zip(_towards(a), each, strict=True):
            key = f"availability.month.{month}{towards}"
            counts = {"flown": part.flown, "judged": part.judged, "unknown": part.unknown}
            shares = {"part": part.part, "lower": part.lower, "upper": part.upper}
            cells = [number(f"{key}.{name}", value, 0) for name, value in counts.items()]
            cells += [number(f"{key}.{k}_percent", 100.0 * x, 1) for k, x in shares.items()]
            rows.append(((f"{_MONTHS[month - 1]}{towards}",), *cells))
    head = ("month", "enough in", "of", "unknown", "part [%]", "from [%]", "to [%]")
    return Table("By month", head, tuple(rows))


def interval(a: Availability) -> str:
    """Return what the interval means, in words."""
    return (
        f"With {100 * a.confidence:g} % confidence the part of all such days lies in the interval;"
        " days that are alike count as fewer independent ones."
    )


def placard(a: Availability) -> Table:
    """Return the limits that are enough in parts of the judged soundings, towards each azimuth."""
    rows: list[tuple[Line, ...]] = []
    for part, limits in zip(PLACARD, np.atleast_2d(a.placard()).T, strict=True):
        key = f"availability.placard.{100.0 * part:g}"
        cells = (
            minimum_limit(degrees(f"{key}{k}", x)) for k, x in zip(_towards(a), limits, strict=True)
        )
        rows.append(((f"{100.0 * part:g} %",), *cells))
    head = ("part", *(f"limit [deg]{towards}" for towards in _towards(a)))
    return Table("Limit that is enough in a part of soundings", head, tuple(rows))


def unknown(a: Availability) -> Table:
    """Return why soundings are not judged; what is wrong with a file is not told line by line."""
    reasons = Counter(why.split(":")[0] for why in a.why if why)
    rows = tuple(
        ((why,), number(f"availability.unknown.{i}", count, 0))
        for i, (why, count) in enumerate(reasons.most_common())
    )
    return Table("Unknown soundings", ("why", "number"), rows)


def _towards(a: Availability) -> list[str]:
    """What names an azimuth among several; nothing for one."""
    azimuths = np.degrees(np.atleast_1d(a.azimuth)).tolist()
    return [f", towards {one:.4g} deg" for one in azimuths] if len(azimuths) > 1 else [""]
