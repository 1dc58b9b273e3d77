"""The answer of `flown_margins`: how far each quantity may change, and what fails then."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.cards import Shown, table
from tvclin.base.documents import decibels, keyed
from tvclin.base.lines import Line, Table, number, significant
from tvclin.control.margins.margins import margin
from tvclin.flights.closed_loop.edges import OK
from tvclin.flights.closed_loop.many import UNDECIDED

NOTHING = "nothing"
_CHANGES = {
    "gain_fall": "gain falls",
    "gain_rise": "gain rises",
    "effectiveness_fall": "effectiveness falls",
    "effectiveness_rise": "effectiveness rises",
    "delay": "further delay",
}
CHANGES = tuple(_CHANGES)
_CAUSES = {"lost": "is lost", "rings": "rings near rest", UNDECIDED: "neither lost nor settled"}


class NearRest(NamedTuple):
    """Changes with which the loop grows near rest: factors of the gain, and a delay [s]."""

    fall: float
    rise: float
    delay: float


@dataclass(frozen=True, eq=False)
class FlownMargin(Shown):
    """How far one quantity may change.

    Attributes
    ----------
    value : float
        A factor above one, or a further delay [s]; infinite if nothing fails.
    cause : str
        What comes first: "lost" (or "undecided", where a flight is neither lost nor settled),
        "rings" (the loop grows near rest; on the side of the aerodynamic moment it need not
        oscillate), or "nothing".
    again : bool
        Whether some larger change, of those that were tried, survives and does not ring.
    lost : float
        The change from which a flight is lost; infinite if none is that was tried.
    near_rest : float
        The change from which the loop grows near rest, from its eigenvalues.
    scan : ndarray
        The changes that were flown, rising.
    survives : ndarray of bool
        Which of them survive, whatever the loop does near rest.
    """

    value: float
    cause: str
    again: bool
    lost: float
    near_rest: float
    scan: FloatArray
    survives: BoolArray

    as_dict = keyed("value cause again lost near_rest")

    @property
    def dB(self) -> float:
        """The factor in dB; without meaning for a delay."""
        return float(decibels(self.value))


@dataclass(frozen=True, eq=False)
class FlownMargins(Shown):
    """What may change before the flight of a law with a limit is lost.

    Attributes
    ----------
    gain_fall, gain_rise : FlownMargin
        What the law asks for divided, or multiplied, ahead of switch and limit.
    effectiveness_fall, effectiveness_rise : FlownMargin
        What the nozzle does divided, or multiplied, behind its stop, of which the law knows
        nothing.
    delay : FlownMargin
        Further delay between command and nozzle.
    limit : float
        The limit, over ``|B alpha_w,max|``.
    boundary : float
        The least limit, of `closed_loop_boundary`, over the same.
    status : str
        "ok", or in words what is wrong with the limit or its boundary.
    """

    gain_fall: FlownMargin
    gain_rise: FlownMargin
    effectiveness_fall: FlownMargin
    effectiveness_rise: FlownMargin
    delay: FlownMargin
    limit: float
    boundary: float
    status: str

    as_dict = keyed(
        "limit_of_full_trim=limit boundary_of_full_trim=boundary spare status"
        f" {' '.join(CHANGES)} notes"
    )

    @property
    def spare(self) -> float:
        """The limit over the boundary."""
        return self.limit / self.boundary

    @property
    def near_rest(self) -> NearRest:
        """What gain and delay may be before the loop grows near rest."""
        return NearRest(*(getattr(self, n).near_rest for n in ("gain_fall", "gain_rise", "delay")))

    @property
    def notes(self) -> tuple[str, ...]:
        """What is to be known about these margins."""
        found = [] if self.status == OK else [self.status]
        for name in CHANGES:
            one = getattr(self, name)
            words = name.replace("_", " ")
            if one.cause == NOTHING:
                found.append(f"{words} inf: none up to {one.scan[-1]:.4g} is lost or rings")
            elif one.cause == UNDECIDED:
                found.append(f"{words} {one.value:.4g}: beyond it flights stay undecided")
            if one.again:
                found.append(f"{words} {one.value:.4g}: some larger changes survive again")
        return tuple(found)

    def _repr_html_(self) -> str:
        spare = number("spare", self.spare, 2)
        return table(flown_table(self), [("limit over boundary: ", *spare), (self.status,)])


def flown_table(found: FlownMargins, caption: str = "Flown margins") -> Table:
    """Return how far each quantity may change, what fails then, and what near rest allows."""
    rows: list[tuple[Line, ...]] = []
    for name in CHANGES:
        one: FlownMargin = getattr(found, name)
        flown, near_rest = (
            _change(f"flown.{name}.{key}", value, name == "delay")
            for key, value in (("value", one.value), ("near_rest", one.near_rest))
        )
        rows.append(((_CHANGES[name],), flown, (_CAUSES.get(one.cause, one.cause),), near_rest))
    return Table(caption, ("change", "margin", "failure", "near rest"), tuple(rows))


def _change(name: str, value: float, is_delay: bool) -> Line:
    """A further delay in ms, or a factor in dB and as it is."""
    if is_delay:
        return margin(name, 1000.0 * value, "ms")
    shown = margin(name, decibels(value), "dB")
    return (
        *shown,
        *(() if np.isinf(value) else (" (", *significant(f"{name}.factor", value), "x)")),
    )
