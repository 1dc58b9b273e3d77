"""Duty of a nozzle in the flight of a law."""

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
    """Duty of a nozzle in the flight of a law, and the verdict on its data sheet.

    `status` is the outcome of the flight, as of `fly_many`. The card ends 15 time constants of the
    fast mode after the wind; it is None for a lost flight. `notes` are on the design of the law,
    and on terms that the card omits. In a wind beyond linear aerodynamics nothing is known.
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
        notes, cards, lost = tuple(design_notes(law)), [], []
        reason = flight_reason(case.plant, flight.status)
        if flight.times.size and not reason:
            cards = [card_of(Motion.of_flight(flight), limit, WINDOW, data, vehicle)]
            notes = (*notes, *cards[0].notes, *actuator_notes(case.nozzle.actuator))
        if flight.status != SURVIVED and not reason:
            lost = [f"{name} {OUTCOME_WORDS[flight.status]}"]
        travel = cards[0].travel if cards else np.nan
        unknown = [f"the flight of {name}: {reason}"] if reason else []
        needed = needed_of(case.nozzle, cards, travel) if cards or lost else {}
        verdict = NozzleVerdict.of(case.nozzle, needed, lost, unknown)
        return cls(name, flight.status, cards[0] if cards else None, notes, verdict)

    @property
    def survived(self) -> bool:
        """Whether the flight is survived."""
        return self.status == SURVIVED

    @property
    def words(self) -> str:
        """The outcome of the flight, in words."""
        return f"{self.law} {OUTCOME_WORDS[self.status]} with this limit and rate"

    def tables(self) -> tuple[Table, ...]:
        """Return the tables of the card and of the data sheet; empty for a lost flight."""
        return () if self.card is None else (*self.card.tables(), *self.verdict.tables())


def actuator_notes(actuator: Actuator | None) -> Iterator[str]:
    """Yield notes on rates and accelerations that the model of the actuator omits."""
    if actuator is None:
        yield "there is no actuator: rates and accelerations are from sample to sample"
    elif actuator.damping is None:
        yield "the rate of an actuator of first order jumps, which counts as no acceleration"
    else:
        yield "where the nozzle runs into its stop it is stopped short: no acceleration counts that"
