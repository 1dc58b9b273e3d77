"""Tables of availability: by month, limits by fraction of the days, and unknown soundings."""

from collections import Counter

import numpy as np

from tvclin.answers.availability.record import PLACARD, Availability
from tvclin.base.lines import Line, Table, degrees, minimum_limit, number

_MONTHS = (
    *("January", "February", "March", "April", "May", "June"),
    *("July", "August", "September", "October", "November", "December"),
)


def by_month(a: Availability) -> Table:
    """Return the table of soundings that fly, by month and azimuth."""
    rows = []
    for month, parts in a.by_month().items():
        by_azimuth = parts if isinstance(parts, tuple) else (parts,)
        for towards, part in zip(_towards(a), by_azimuth, strict=True):
            key = f"availability.month.{month}{towards}"
            counts = {"flown": part.flown, "judged": part.judged, "unknown": part.unknown}
            shares = {"part": part.part, "lower": part.lower, "upper": part.upper}
            cells = [number(f"{key}.{name}", value, 0) for name, value in counts.items()]
            cells += [number(f"{key}.{k}_percent", 100.0 * x, 1) for k, x in shares.items()]
            rows.append(((f"{_MONTHS[month - 1]}{towards}",), *cells))
    head = ("month", "SURVIVED", "of", "unknown", "fraction [%]", "from [%]", "to [%]")
    return Table("By month", head, tuple(rows))


def interval(a: Availability) -> str:
    """Return the meaning of the confidence interval, in words."""
    return (
        f"With {100 * a.confidence:g} % confidence the part of all such days lies in the interval;"
        " days that are alike count as fewer independent ones."
    )


def placard(a: Availability) -> Table:
    """Return the table of sufficient limits by fraction of the judged soundings and azimuth."""
    rows: list[tuple[Line, ...]] = []
    for part, limits in zip(PLACARD, np.atleast_2d(a.placard()).T, strict=True):
        key = f"availability.placard.{100.0 * part:g}"
        cells = (
            minimum_limit(degrees(f"{key}{k}", x)) for k, x in zip(_towards(a), limits, strict=True)
        )
        rows.append(((f"{100.0 * part:g} %",), *cells))
    head = ("part", *(f"limit [deg]{towards}" for towards in _towards(a)))
    return Table("Limit that is sufficient in a fraction of the soundings", head, tuple(rows))


def unknown(a: Availability) -> Table:
    """Return the table of reasons for unknown soundings, with their numbers."""
    reasons = Counter(reason.split(":")[0] for reason in a.why if reason)
    rows = tuple(
        ((reason,), number(f"availability.unknown.{i}", count, 0))
        for i, (reason, count) in enumerate(reasons.most_common())
    )
    return Table("Unknown soundings", ("why", "number"), rows)


def _towards(a: Availability) -> list[str]:
    """Return the labels of azimuths; an empty label for a single azimuth."""
    azimuths = np.degrees(np.atleast_1d(a.azimuth)).tolist()
    return [f", towards {azimuth:.4g} deg" for azimuth in azimuths] if len(azimuths) > 1 else [""]
