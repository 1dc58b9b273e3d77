"""Requirements of motions on a nozzle, what it offers, and what remains of that."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from tvclin.answers.nozzle import Nozzle
from tvclin.answers.nozzle_cards.card import NozzleCard
from tvclin.base.cards import Shown, table
from tvclin.base.documents import keyed
from tvclin.base.lines import Line, Table, significant
from tvclin.base.quantities import satisfaction, survival

SHEET = {
    "limit": ("limit", "deg"),
    "rate_limit": ("rate limit", "deg/s"),
    "acceleration_limit": ("acceleration", "deg/s2"),
    "travel_limit": ("travel of a flight", "deg"),
    "torque_limit": ("torque", "N m"),
    "power_limit": ("power", "W"),
}
"""What a nozzle can do, by the field that says it: in words, and the unit in which it is told."""
_ROUNDING = 1e-12


def needed_of(nozzle: Nozzle, cards: Sequence[NozzleCard], travel: float) -> dict[str, float]:
    """Return what motions take of a nozzle [SI], by the fields of `SHEET`; all but its travel.

    Flights keep to the rate limit, which an actuator of second order may pass by a thousandth.
    """
    rate = max((abs(one.rate.value) for one in cards), default=0.0)
    needed = {
        "limit": max((abs(one.angle.value) for one in cards), default=0.0),
        "rate_limit": min(rate, nozzle.rate_limit or np.inf),
        "acceleration_limit": max((abs(one.acceleration.value) for one in cards), default=0.0),
        "travel_limit": travel,
    }
    work = [one.work for one in cards if one.work is not None]
    if nozzle.data is not None:
        held = (one.holding + nozzle.data.friction for one in work)
        needed["torque_limit"] = max([0.0, *held, *(abs(one.torque.value) for one in work)])
        needed["power_limit"] = max((one.power.value for one in work), default=0.0)
    return needed


@dataclass(frozen=True)
class Need(Shown):
    """A line of a data sheet; numbers in its unit.

    What is needed is infinite where nothing is sufficient, and not a number where it is not known.
    """

    name: str
    unit: str
    needed: float
    there: float | None

    as_dict = keyed("name unit needed there left met")

    @property
    def left(self) -> float | None:
        """What is left; negative where it is too little."""
        if self.there is None:
            return None
        left = self.there - self.needed
        return max(left, 0.0) if self.met else left  # a stop that is reached, but for rounding

    @property
    def met(self) -> bool | None:
        """Whether the nozzle offers what is needed; None where it says nothing, or not known."""
        if self.there is None or np.isnan(self.needed):
            return None
        return bool(self.needed <= self.there * (1.0 + _ROUNDING))

    @property
    def part(self) -> float:
        """Which part of what there is is needed; -1 where none is given."""
        return -1.0 if self.there is None else float(np.nan_to_num(self.needed / self.there))


@dataclass(frozen=True)
class NozzleVerdict(Shown):
    """Whether a nozzle meets its data sheet, line by line, that with the largest needed part first.

    `lost` are flights that are not survived, `unknown` what cannot be judged, a flight or a wind,
    with the reason and what would make it known; both in words.
    """

    needs: tuple[Need, ...]
    lost: tuple[str, ...] = ()
    unknown: tuple[str, ...] = ()

    as_dict = keyed("met words needs lost unknown")
    _keys = "verdict=words lost unknown"

    @classmethod
    def of(
        cls,
        nozzle: Nozzle,
        needed: dict[str, float],
        lost: Iterable[str] = (),
        unknown: Iterable[str] = (),
    ) -> Self:
        """Return the verdict on a nozzle of what is needed [SI], by the fields of `SHEET`.

        Where a flight is lost with what there is, what it needs is not known.
        """
        needs, lost = [], tuple(lost)
        for name, (words, unit) in SHEET.items():
            if name in needed:
                scale = float(np.degrees(1.0)) if unit.startswith("deg") else 1.0
                there: Any = getattr(nozzle, name)
                there = None if there is None else scale * there
                need = scale * needed[name]
                if lost and need <= (there or 0.0):
                    need = np.nan
                needs.append(Need(words, unit, need, there))
        return cls(tuple(sorted(needs, key=lambda one: -one.part)), lost, tuple(unknown))

    @classmethod
    def unknown_of(cls, nozzle: Nozzle, unknown: Iterable[str]) -> Self:
        """Return the verdict on a nozzle of which nothing is known, and why, in words."""
        return cls.of(nozzle, dict.fromkeys(needed_of(nozzle, (), np.nan), np.nan), (), unknown)

    @property
    def met(self) -> bool | None:
        """Whether all flights are survived and no line is short; None where nothing is given."""
        answers = [one.met for one in self.needs if one.there is not None]
        if self.lost or False in answers:
            return False
        return None if not answers or None in answers or self.unknown else True

    @property
    def reason(self) -> str:
        """What the verdict rests on, in words: a flight, a wind, or the line that is worst."""
        if self.lost:
            others = len(self.lost) - 1
            return f"{self.lost[0]}{f', and {others} more' if others else ''}"
        if self.unknown and self.met is None:
            return "; ".join(self.unknown)
        worst = next((one for one in self.needs if one.there is not None), None)
        if worst is None or self.met is None:
            return ""
        if np.isinf(worst.needed):
            return f"no {worst.name} is sufficient"
        needed, there = (f"{x:.4g} {worst.unit}" for x in (worst.needed, worst.there or 0.0))
        return f"the {worst.name} needed is {needed}, and {there} is available"

    @property
    def words(self) -> str:
        """The verdict in a sentence, with its reason."""
        given = any(one.there is not None for one in self.needs)
        if not (given or self.lost or self.unknown):
            return "nothing is judged; give a limit and a rate limit"
        word = survival(False) if self.lost else satisfaction(self.met)
        return f"{word}: {self.reason}" if self.reason else word

    def _repr_html_(self) -> str:
        return "".join(table(one, ((self.words,),)) for one in self.tables())

    def tables(self) -> tuple[Table, ...]:
        """Return what is needed, what is there and what is left."""

        def cell(key: str, value: float | None) -> Line:
            return significant(key, np.nan if value is None or value == -np.inf else value)

        rows = tuple(
            (
                (f"{one.name} [{one.unit}]",),
                cell(f"sheet.{one.name}.needed", one.needed),
                cell(f"sheet.{one.name}.there", one.there),
                cell(f"sheet.{one.name}.left", one.left),
            )
            for one in self.needs
        )
        known = ", where that is known" if self.unknown else ""
        return (
            Table(
                f"What is asked of the nozzle{known}",
                ("", "required", "available", "remaining"),
                rows,
            ),
        )
