"""All that takes deflection, added up: a record, its verdict and its table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tvclin.base.cards import Shown, table
from tvclin.base.documents import keyed
from tvclin.base.errors import (
    InputError,
    between,
    each,
    instance,
    nonnegative,
    number,
    one_of,
    positive,
    small_angle,
    text,
    within,
)
from tvclin.base.lines import Line as Cell
from tvclin.base.lines import Table, degrees, significant

KINDS = ("systematic", "random")
HEAD, SUMS = ("what", "how it adds up", "[deg]"), "sum and root of sum of squares"
_WIDEST = 1e9
"""Deflections beyond this [rad] mean nothing."""
_SMALL = float(np.radians(0.001))
"""A shortfall below it [rad] would be nothing in three digits behind the point."""
RATES = (1e-15, 1e9)
"""Rates [rad/s] that can be told from none, and from any."""


@dataclass(frozen=True)
class Line:
    """What takes deflection, and how much [rad], zero or positive.

    What is systematic adds up with the others, what is random by the root of the sum of squares.
    """

    name: str
    deflection: float
    kind: str = "systematic"

    as_dict = keyed("name deflection_deg kind")

    def __post_init__(self) -> None:
        one_of("kind", self.kind, KINDS)
        text("name of a line", self.name)
        name = self.name or "deflection"
        size = number(name, self.deflection, nonnegative, "rad")
        within(name, size, 0.0, _WIDEST, "rad")
        object.__setattr__(self, "deflection", size)


@dataclass(frozen=True)
class DeflectionTotal(Shown):
    """The total deflection that a nozzle needs, and its limit; make it with `total_deflection`.

    Attributes
    ----------
    lines : tuple of Line
        What takes deflection; nothing where that is known at no flight time.
    reserve : float
        Part of the limit that is to stay unused, in [0, 1).
    limit : float or None
        Available deflection [rad].
    time : float or None
        Flight time [s] to which the lines belong.
    not_sized : tuple of str
        Where along the flight the total is not known, in words, such as "above 24.9 km"; nothing
        where it is known throughout.
    rate_limit : float or None
        Of the nozzle [rad/s].
    end : str
        Which end of the flight that time is, in words, beyond which the total may be larger; empty
        between the ends.
    needed_rate : float
        The least deflection rate [rad/s], at the limit or else at any; NaN where it is not known.
    """

    lines: tuple[Line, ...]
    reserve: float = 0.0
    limit: float | None = None
    time: float | None = None
    not_sized: tuple[str, ...] = ()
    rate_limit: float | None = None
    needed_rate: float = 0.0
    end: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "lines", each("lines", self.lines, Line, "of a total"))
        object.__setattr__(self, "not_sized", each("not_sized", self.not_sized, str, "a place"))
        reserve = number("reserve", self.reserve, nonnegative)
        if reserve >= 1.0:
            raise InputError(f"reserve must be a part of the limit, below 1; got {reserve:.6g}")
        if self.limit is not None:
            number("limit", self.limit, small_angle("a deflection", positive), "rad")
        if self.time is not None:
            number("time", self.time, unit="s")
        if self.rate_limit is not None:
            number("rate_limit", self.rate_limit, between(*RATES), "rad/s")
        instance("needed_rate", self.needed_rate, float, "in rad/s")
        text("end", self.end)

    _keys = "time_s total_deg reserve limit_deg required_deg"

    as_dict = keyed(
        "time_s lines total_deg reserve required_deg rate_limit_deg_per_s needed_rate_deg_per_s"
    )

    def _repr_html_(self) -> str:
        return table(total_table(self), self.verdict)

    @property
    def verdict(self) -> tuple[Cell, ...]:
        """Whether the limit is enough, and where the total is not known, each as a line."""
        said: list[Cell] = []
        if self.limit is not None and self.left is not None:
            left = degrees("total.left", abs(self.left), unit="deg")
            beside = " left after the reserve" if self.reserve else " left"
            line: Cell = ("SUFFICIENT, ", *left, beside)
            if self.sufficient is None:
                known = "NOT KNOWN to be sufficient; where the winds are known "
                line = (known, *line[1:])
            if not self.lines:
                line = ("NOT KNOWN",)
            elif self.sufficient is False:
                lacks = self.required - self.limit
                short = degrees("total.short", lacks, unit="deg")
                if lacks < _SMALL:
                    short = significant("total.short_deg", np.degrees(lacks), unit="deg")
                of = " of a limit that keeps the reserve" if self.reserve else ""
                line = ("NOT SUFFICIENT, short by ", *short, of)
                if lacks <= 0.0:
                    line = ("NOT SUFFICIENT at this rate limit",)
            limit = degrees("total.limit", self.limit, unit="deg")
            said.append(("Limit ", *limit, ": ", *line))
        if self.not_sized:
            said.append((f"NOT SIZED {', '.join(self.not_sized)}",))
        if self.rate_limit is not None:
            there = degrees("total.rate_limit", self.rate_limit, unit="deg/s")
            needed = degrees("total.needed_rate", self.needed_rate, unit="deg/s")
            word = "NOT SUFFICIENT, " if self.too_slow else ""
            line = (*needed, " needed") if np.isfinite(self.needed_rate) else ("no rate is enough",)
            line = ("NOT KNOWN",) if np.isnan(self.needed_rate) else line
            said.append(("Rate limit ", *there, f": {word}", *line))
        return tuple(said)

    @property
    def systematic(self) -> float:
        """Sum of the systematic lines [rad]."""
        return float(sum(line.deflection for line in self.lines if line.kind == "systematic"))

    @property
    def random(self) -> float:
        """Root of the sum of the squares of the random lines [rad]."""
        parts = [line.deflection for line in self.lines if line.kind == "random"]
        return float(np.linalg.norm(parts))

    @property
    def total(self) -> float:
        """Systematic and random together [rad]; NaN where nothing is known."""
        return self.systematic + self.random if self.lines else float("nan")

    @property
    def required(self) -> float:
        """The least limit [rad] that leaves the reserve: total/(1 - reserve)."""
        return self.total / (1.0 - self.reserve)

    @property
    def too_slow(self) -> bool:
        """Whether the rate limit is below what is needed."""
        return self.rate_limit is not None and self.needed_rate > self.rate_limit * (1.0 + 1e-9)

    @property
    def sufficient(self) -> bool | None:
        """Whether the limit covers the total and leaves the reserve, at the rate that there is.

        None without a limit, and where it is enough for what is known and not all is known.
        """
        if self.limit is None:
            return False if self.too_slow else None
        if not self.lines:
            return None
        enough = bool(self.required <= self.limit * (1.0 + 1e-12)) and not self.too_slow
        return None if enough and self.not_sized else enough

    @property
    def left(self) -> float | None:
        """What of the limit total and reserve leave [rad]; negative if it is too little."""
        return None if self.limit is None else (1.0 - self.reserve) * self.limit - self.total


def total_table(total: DeflectionTotal, counted: str = "") -> Table:
    """Return what takes deflection and the total, as a table; `counted` says what of a wind."""
    wind = f"wind, {counted}" if counted else "wind"
    rows = rows_of(total, "total", wind)
    rows.append((("total",), (SUMS,), degrees("total.total", total.total)))
    if total.reserve:
        kept = significant("total.reserve_percent", 100 * total.reserve, unit="%")
        needed = degrees("total.required", total.required)
        rows.append((("limit that keeps ", *kept, " in reserve"), ("",), needed))
    known = " of those that are known" if total.not_sized else ""
    return Table(f"All that takes deflection{at_time(total, 'the', known)}", HEAD, tuple(rows))


def at_time(total: DeflectionTotal, whose: str, known: str = "") -> str:
    """Return the worst flight time of a total as the end of a caption, with the end that it is."""
    if total.time is None:
        return ""
    end = f", {total.end}" if total.end else ""
    return f" at {whose} worst flight time{known}, {total.time:.5g} s{end}"


def rows_of(total: DeflectionTotal, key: str, wind: str) -> list[tuple[Cell, ...]]:
    """Return what takes deflection as rows of a table, that of the wind in other words."""
    return [
        (
            (wind if one.name == "wind" else one.name,),
            (one.kind,),
            degrees(f"{key}.{one.name.replace(' ', '_')}", one.deflection),
        )
        for one in total.lines
        if one.deflection
    ]
