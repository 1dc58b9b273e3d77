"""What a whole flight asks of its nozzle: each flight time in each wind, and all of it together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from tvclin.answers.nozzle_cards.card import NozzleCard
from tvclin.answers.nozzle_cards.verdict import NozzleVerdict
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown, named, table
from tvclin.base.documents import keyed, picked
from tvclin.base.files import write_rows
from tvclin.base.lines import Line, Table, significant
from tvclin.base.lines import number as figure
from tvclin.flights.closed_loop.fly_many import SURVIVED

_LEAST = "least_angle_deg=least least_rate_deg_per_s least_acceleration_deg_per_s2"
_CARD = (
    "angle_deg=|angle.value| rate_deg_per_s=|rate.value| steady_rate_deg_per_s"
    " acceleration_deg_per_s2=|acceleration.value| travel_deg reversals time_at_stop_s"
)
_WORK = (
    "torque_N_m=|torque.value| holding_torque_N_m=holding rms_torque_N_m=rms_torque"
    " power_W=power.value energy_J=energy"
)
_SHOWN = (
    *("least_angle_deg", "least_rate_deg_per_s", "angle_deg", "rate_deg_per_s"),
    "acceleration_deg_per_s2",
)


@dataclass(frozen=True, eq=False)
class CardPoint(Shown):
    """The nozzle at one flight time [s] in one wind, in one plane.

    The wind has its sign along the path where that matters. `least` is the least angle [rad] at any
    rate, the wind being known; `pole` the fast unstable one [1/s], zero where nothing grows, not a
    number where two are a pair; `limit` the part of the stop [rad] that this plane has. `status` is
    what became of the flight, as of `fly_many`, empty where nothing is flown, and `why` the reason
    where it cannot be judged; `card` is None then, and where it is lost. `said` is of the design of
    the law. `alone` is travel [rad] and energy [J] of the flight beside what
    noise takes by itself, `quiet` that [rad/s, W]. `direction`, head or tail, is that of a pulse
    whose dynamic pressure depends on it.
    """

    time: float
    wind: str
    plane: str
    limit: float
    least: float = 0.0
    pole: float = 0.0
    status: str = ""
    why: str = ""
    card: NozzleCard | None = None
    said: tuple[str, ...] = ()
    alone: FloatArray = field(default_factory=lambda: np.zeros(2))
    quiet: FloatArray = field(default_factory=lambda: np.zeros(2))
    direction: str = ""

    @property
    def least_rate(self) -> float:
        """The deflection rate p d0 [rad/s] that must be exceeded at any angle."""
        return self.pole * self.least

    @property
    def least_acceleration(self) -> float:
        """The acceleration p^2 d0 [rad/s2] that must be exceeded at any angle."""
        return self.pole**2 * self.least

    @property
    def lost(self) -> bool:
        """Whether a flight is known not to survive."""
        return self.status not in ("", SURVIVED) and not self.why

    @property
    def numbers(self) -> dict[str, float]:
        """All numbers by keys with their units."""
        found = picked(self, _LEAST)
        if self.card is not None:
            found |= picked(self.card, _CARD)
            found |= {} if self.card.work is None else picked(self.card.work, _WORK)
        return {key: float(value) for key, value in found.items()}

    def as_dict(self) -> dict[str, Any]:
        """Return the point as the command line prints it as JSON, angles in degrees."""
        return picked(self, "time_s wind plane status why") | self.numbers


@dataclass(frozen=True)
class Duty(Shown):
    """What a whole flight in one wind asks of a nozzle, one moment after the other.

    Travel is the integral of ``|delta'|`` [rad], not a number where a flight is lost or cannot be
    judged; energy [J]
    what the actuators give, not a number without nozzle data.
    """

    wind: str
    plane: str
    travel: float
    energy: float

    as_dict = keyed("wind plane travel_deg energy_J")


@dataclass(frozen=True, eq=False)
class FlightCard(Shown):
    """What a whole flight asks of its nozzle; make it with `flight_card`.

    Attributes
    ----------
    vehicle, law : str
        Their names.
    points : tuple of CardPoint
        By flight time and wind.
    duties : tuple of Duty
        Of the whole flight in each wind; the flight has one of them.
    verdict : NozzleVerdict
        What is needed, what is there and what is left.
    notes : tuple of str
        What is left out, and how the whole is counted.
    """

    vehicle: str
    law: str
    points: tuple[CardPoint, ...]
    duties: tuple[Duty, ...]
    verdict: NozzleVerdict
    notes: tuple[str, ...]

    as_dict = keyed("vehicle law verdict largest duties points notes")
    _keys = "vehicle law verdict=verdict.words largest"

    def _repr_html_(self) -> str:
        first, *rest = self.tables()
        return table(first, ((self.verdict.words,),)) + "".join(map(table, rest))

    @property
    def largest(self) -> dict[str, float]:
        """The largest of each quantity over the flight, by keys with their units."""
        return {key: one.numbers[key] for key, one in self._worst().items()}

    def tables(self) -> tuple[Table, ...]:
        """Return the verdict, the largest of each quantity, and the largest at each time."""
        return (*self.verdict.tables(), self._whole(), *self._over_time())

    def to_csv(self, path: Path | None = None) -> str:
        """Return a line for each flight as CSV, and write it where a path is given.

        Raises
        ------
        InputError
            When the file cannot be written.
        """
        keys = list(dict.fromkeys(chain.from_iterable(one.numbers for one in self.points)))
        rows = [
            [one.time, one.wind, one.plane, one.status]
            + [float(one.numbers.get(key, np.nan)) for key in keys]
            + [one.why]
            for one in self.points
        ]
        return write_rows([["time_s", "wind", "plane", "status", *keys, "why"], *rows], path)

    def _worst(self) -> dict[str, CardPoint]:
        numbers = [one.numbers for one in self.points]
        found = {}
        for key in dict.fromkeys(chain.from_iterable(numbers)):
            values = np.nan_to_num([one.get(key, -1.0) for one in numbers], nan=-1.0)
            found[key] = self.points[int(np.argmax(values))]
        return found

    def _whole(self) -> Table:
        planes = len({one.plane for one in self.points}) > 1

        def where(one: CardPoint | Duty) -> Line:
            return (f"{one.wind}, {one.plane}" if planes else one.wind,)

        rows: list[tuple[Line, ...]] = []
        for key, one in self._worst().items():
            name, unit = named(key)
            value = _cell(f"card.{key}", key, one.numbers[key])
            label = f"{name} [{unit}]" if unit else name
            rows.append(((label,), value, (f"{one.time:.6g}",), where(one)))
        for key in ("travel_deg", "energy_J"):
            sums = [one.as_dict()[key] for one in self.duties]
            if np.isfinite(sums).any():
                worst = self.duties[k := int(np.nanargmax(sums))]
                name, unit = named(key)
                value = _cell(f"card.whole.{key}", key, sums[k])
                label = f"{name} of the whole flight [{unit}]"
                rows.append(((label,), value, ("",), where(worst)))
        head = ("", "largest", "at [s]", "in the wind")
        return Table(f"The nozzle over the flight, {self.law} flown", head, tuple(rows))

    def _over_time(self) -> Iterator[Table]:
        times = sorted({one.time for one in self.points})
        for caption, keys in (
            ("By flight time, the largest of all winds", (*_SHOWN, "travel_deg")),
            ("Torque, power and energy by flight time", ("torque_N_m", "power_W", "energy_J")),
        ):
            there = [key for key in keys if key in self.largest]
            if not there:
                continue
            rows = []
            for time in times:
                now = [one.numbers for one in self.points if one.time == time]
                most = {
                    key: float(np.fmax.reduce([one.get(key, np.nan) for one in now]))
                    for key in there
                }
                cells = (_cell(f"card.{time:g}.{key}", key, most[key]) for key in there)
                rows.append(((f"{time:.6g}",), *cells))
            heads = [" [".join(filter(None, named(key))) + "]" for key in there]
            yield Table(caption, ("time [s]", *heads), tuple(rows))


def _cell(name: str, key: str, value: float) -> Line:
    return figure(name, value) if "_deg" in key else significant(name, value)
