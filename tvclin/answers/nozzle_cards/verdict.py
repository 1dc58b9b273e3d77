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
"""Label and unit in the data sheet by field of `Nozzle`."""
_RELATIVE_TOLERANCE = 1e-12
"""Excess of a requirement, relative to what is available, that counts as rounding."""


def needed_of(nozzle: Nozzle, cards: Sequence[NozzleCard], travel: float) -> dict[str, float]:
    """Return the requirements of motions on a nozzle [SI], by the fields of `SHEET`.

    `travel`: travel of the whole flight [rad]. Flights keep to the rate limit, which an actuator of
    second order may exceed by a thousandth.
    """
    rate = max((abs(card.rate.value) for card in cards), default=0.0)
    needed = {
        "limit": max((abs(card.angle.value) for card in cards), default=0.0),
        "rate_limit": min(rate, nozzle.rate_limit or np.inf),
        "acceleration_limit": max((abs(card.acceleration.value) for card in cards), default=0.0),
        "travel_limit": travel,
    }
    work = [card.work for card in cards if card.work is not None]
    if nozzle.data is not None:
        holding = (w.holding + nozzle.data.friction for w in work)
        needed["torque_limit"] = max([0.0, *holding, *(abs(w.torque.value) for w in work)])
        needed["power_limit"] = max((w.power.value for w in work), default=0.0)
    return needed


@dataclass(frozen=True)
class Need(Shown):
    """A line of a data sheet: the required value and the available value, in `unit`.

    `needed`: infinite where no value is sufficient, NaN where it is not known. `there`: the value
    that the nozzle offers; None where the data sheet has none.
    """

    name: str
    unit: str
    needed: float
    there: float | None

    as_dict = keyed("name unit needed there left met")

    @property
    def left(self) -> float | None:
        """Remaining margin, available minus required; negative where the nozzle is insufficient."""
        if self.there is None:
            return None
        margin = self.there - self.needed
        return max(margin, 0.0) if self.met else margin  # negative by rounding only

    @property
    def met(self) -> bool | None:
        """Whether the available value is sufficient; None where either value is not known."""
        if self.there is None or np.isnan(self.needed):
            return None
        return bool(self.needed <= self.there * (1.0 + _RELATIVE_TOLERANCE))

    @property
    def part(self) -> float:
        """Ratio of the required to the available value; -1 without an available value."""
        return -1.0 if self.there is None else float(np.nan_to_num(self.needed / self.there))


@dataclass(frozen=True)
class NozzleVerdict(Shown):
    """Verdict on a nozzle by the lines of its data sheet, the largest required fraction first.

    `lost`: flights that are not survived, in words. `unknown`: flights and winds that cannot be
    judged, with the reason and a remedy, in words.
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
        """Return the verdict on a nozzle with requirements [SI] by the fields of `SHEET`.

        Where a flight is lost with the available values, the required values are not known.
        """
        needs, lost = [], tuple(lost)
        for name, (words, unit) in SHEET.items():
            if name in needed:
                scale = float(np.degrees(1.0)) if unit.startswith("deg") else 1.0
                value: Any = getattr(nozzle, name)
                available = None if value is None else scale * value
                need = scale * needed[name]
                if lost and need <= (available or 0.0):
                    need = np.nan
                needs.append(Need(words, unit, need, available))
        return cls(tuple(sorted(needs, key=lambda need: -need.part)), lost, tuple(unknown))

    @classmethod
    def unknown_of(cls, nozzle: Nozzle, unknown: Iterable[str]) -> Self:
        """Return the verdict on a nozzle with unknown requirements, for reasons in words."""
        return cls.of(nozzle, dict.fromkeys(needed_of(nozzle, (), np.nan), np.nan), (), unknown)

    @property
    def met(self) -> bool | None:
        """Whether all flights are survived and all lines satisfied; None where not known."""
        answers = [need.met for need in self.needs if need.there is not None]
        if self.lost or False in answers:
            return False
        return None if not answers or None in answers or self.unknown else True

    @property
    def reason(self) -> str:
        """The reason of the verdict, in words: a flight, a wind, or the worst line."""
        if self.lost:
            others = len(self.lost) - 1
            return f"{self.lost[0]}{f', and {others} more' if others else ''}"
        if self.unknown and self.met is None:
            return "; ".join(self.unknown)
        worst = next((need for need in self.needs if need.there is not None), None)
        if worst is None or self.met is None:
            return ""
        if np.isinf(worst.needed):
            return f"no {worst.name} is sufficient"
        needed, available = (f"{x:.4g} {worst.unit}" for x in (worst.needed, worst.there or 0.0))
        return f"the {worst.name} needed is {needed}, and {available} is available"

    @property
    def words(self) -> str:
        """The verdict in a sentence, with its reason."""
        specified = any(need.there is not None for need in self.needs)
        if not (specified or self.lost or self.unknown):
            return "nothing is judged; give a limit and a rate limit"
        word = survival(False) if self.lost else satisfaction(self.met)
        return f"{word}: {self.reason}" if self.reason else word

    def _repr_html_(self) -> str:
        return "".join(table(lines, ((self.words,),)) for lines in self.tables())

    def tables(self) -> tuple[Table, ...]:
        """Return the table of required, available and remaining values."""

        def cell(key: str, value: float | None) -> Line:
            return significant(key, np.nan if value is None or value == -np.inf else value)

        rows = tuple(
            (
                (f"{need.name} [{need.unit}]",),
                cell(f"sheet.{need.name}.needed", need.needed),
                cell(f"sheet.{need.name}.there", need.there),
                cell(f"sheet.{need.name}.left", need.left),
            )
            for need in self.needs
        )
        scope = ", where that is known" if self.unknown else ""
        return (
            Table(
                f"What is asked of the nozzle{scope}",
                ("", "required", "available", "remaining"),
                rows,
            ),
        )
