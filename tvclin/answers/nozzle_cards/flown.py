"""What a law's flight asks of the nozzle."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

import numpy as np

from tvclin.answers.case import Case
from tvclin.answers.nozzle_cards.card import WINDOW, NozzleCard, card_of
from tvclin.answers.nozzle_cards.motion import Motion
from tvclin.answers.nozzle_cards.unjudged import flight_reason
from tvclin.answers.nozzle_cards.verdict import NozzleVerdict, needed_of
from tvclin.base.cards import Shown
from tvclin.base.documents import keyed
from tvclin.base.lines import Table
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law
from tvclin.control.laws.registry import design_notes
from tvclin.flights.closed_loop.fly import fly_nozzle
from tvclin.flights.closed_loop.fly_many import SURVIVED
from tvclin.flights.theory_comparison import NOT_KNOWN, OUTCOME_WORDS
from tvclin.vehicle.linear_vehicle import complete_vehicle
from tvclin.winds.wind_angles import beyond_linear


@dataclass(frozen=True)
class FlownCard(Shown):
    """What a law's flight asks of the nozzle.

    `status` is what became of the flight, as of `fly_many`. The card is until 15 times the fast
    mode's time after the wind; None of a flight that is lost. Notes are of the design of the law,
    and of what is left out of the card. In a wind beyond linear aerodynamics nothing is known.
    """

    law: str
    status: str
    card: NozzleCard | None
    notes: tuple[str, ...]
    verdict: NozzleVerdict

    as_dict = keyed("law status card verdict")

    @classmethod
    def of(cls, case: Case, name: str, law: Law) -> Self:
        """Return the card of a law in the wind of a case, with its nozzle, which has a limit."""
        limit, data, vehicle = case.nozzle.limit, case.nozzle.data, None
        assert limit is not None
        if data is not None:
            vehicle = complete_vehicle(case.vehicle, "the torque of a nozzle").rigid
        if beyond := beyond_linear(float(case.history.peak)):
            return cls(name, NOT_KNOWN, None, (), NozzleVerdict.unknown_of(case.nozzle, (beyond,)))
        flight = fly_nozzle(case.plant, law, case.history, deflection_limit=limit, **case.hardware)
        said, cards, lost = tuple(design_notes(law)), [], []
        why = flight_reason(case.plant, flight.status)
        if flight.times.size and not why:
            cards = [card_of(Motion.of_flight(flight), limit, WINDOW, data, vehicle)]
            said = (*said, *cards[0].notes, *actuator_notes(case.nozzle.actuator))
        if flight.status != SURVIVED and not why:
            lost = [f"{name} {OUTCOME_WORDS[flight.status]}"]
        travel = cards[0].travel if cards else np.nan
        unknown = [f"the flight of {name}: {why}"] if why else []
        needed = needed_of(case.nozzle, cards, travel) if cards or lost else {}
        verdict = NozzleVerdict.of(case.nozzle, needed, lost, unknown)
        return cls(name, flight.status, cards[0] if cards else None, said, verdict)

    @property
    def survived(self) -> bool:
        """Whether the flight is survived."""
        return self.status == SURVIVED

    @property
    def words(self) -> str:
        """What becomes of the flight, in words."""
        return f"{self.law} {OUTCOME_WORDS[self.status]} with this limit and rate"

    def tables(self) -> tuple[Table, ...]:
        """Return the card and what is left of the nozzle; nothing of a flight that is lost."""
        return () if self.card is None else (*self.card.tables(), *self.verdict.tables())


def actuator_notes(actuator: Actuator | None) -> Iterator[str]:
    """Yield what an actuator leaves out of rates and accelerations."""
    if actuator is None:
        yield "there is no actuator: rates and accelerations are from sample to sample"
    elif actuator.damping is None:
        yield "the rate of an actuator of first order jumps, which counts as no acceleration"
    else:
        yield "where the nozzle runs into its stop it is stopped short: no acceleration counts that"
