"""Made-up archives of soundings in the columns of IGRA: no real wind, no real station."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np

STATION = "ZZM00088801"


class Balloon(NamedTuple):
    """One sounding: its time, and levels of type, pressure [Pa], height [m], direction, speed."""

    time: str
    levels: list[tuple[int, int, int, int, float]]
    release: int = 9999
    hour: int | None = None
    station: str = STATION
    announced: int | None = None

    @property
    def text(self) -> str:
        """As it stands in a station file; -9999 for what is missing."""
        when = np.datetime64(self.time)
        date = str(when)[:10].replace("-", " ")
        hour = int(str(when)[11:13]) if self.hour is None else self.hour
        count = len(self.levels) if self.announced is None else self.announced
        rows = [
            f"#{self.station} {date} {hour:02d} {self.release:04d} {count:4d} ncdc-nws ncdc-gts"
            "  285000  -806000"
        ]
        rows += [
            f"{kind:2d} -9999 {pressure:6d} {height:5d} -9999 -9999 -9999 {direction:5d} "
            f"{-9999 if speed == -9999 else round(10 * speed):5d} "
            for kind, pressure, height, direction, speed in self.levels
        ]
        return "\n".join(rows) + "\n"


def jet(
    peak: float, top: float = 32e3, direction: int = 270
) -> list[tuple[int, int, int, int, float]]:
    """Return levels of a jet stream at 11 km with a speed [m/s], each half kilometre."""
    heights = np.arange(0.0, top + 1.0, 500.0)
    speeds = peak * np.exp(-(((heights - 11e3) / 4e3) ** 2))
    return [
        (30, -9999, int(h), direction, round(float(v), 1))
        for h, v in zip(heights, speeds, strict=True)
    ]


def days(start: str, count: int, step: int = 12) -> list[str]:
    """Return times, so many hours apart."""
    first = np.datetime64(start, "h")
    return [str(first + np.timedelta64(step * i, "h")) for i in range(count)]


def write(path: Path, balloons: Iterable[Balloon]) -> Path:
    """Write a station file."""
    path.write_text("".join(balloon.text for balloon in balloons), encoding="utf-8")
    return path
