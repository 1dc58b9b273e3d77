"""The autopilot of a plan along its whole flight: its schedule and the sweep of its margins."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.case.autopilot_assumptions import actuator_notes
from tvclin.control.autopilot.flight_autopilot import flight_autopilot
from tvclin.control.autopilot.gain_schedule import GainSchedule
from tvclin.control.autopilot.sweep import Sweep, sweep
from tvclin.linear.plant import DEFAULT_MODEL
from tvclin.requirement.flight.request import SizingRequest
from tvclin.studyfile.study_plan import StudyPlan


@dataclass(frozen=True, eq=False)
class FlightLoop:
    """A plan with a flight, whose autopilot, structure and vehicle vary over the flight."""

    plan: StudyPlan

    @classmethod
    def of(cls, plan: StudyPlan) -> FlightLoop:
        """Return the loop of a plan, with the autopilot of its flight in place of a single time's.

        `InputError` for a plan without a flight, and with a controller in state space.
        """
        if plan.sizing is None:
            raise InputError("the autopilot over a flight needs a flight schedule")
        if plan.controller is not None or plan.plant_system is not None:
            raise InputError("a plant or a controller in state space is of a single flight time")
        return cls(replace(plan, design=plan.sizing.scheduled_design or plan.design))

    @property
    def request(self) -> SizingRequest:
        """The sizing of the flight, with its schedule and its flight times."""
        assert self.plan.sizing is not None  # by `of`
        return self.plan.sizing

    @property
    def flight(self) -> FlightSchedule:
        """The flight."""
        return self.request.schedule

    @property
    def model(self) -> str:
        """Model of the motion; with a structure "drift-exact" in place of "drift"."""
        model = self.plan.model or DEFAULT_MODEL
        return "drift-exact" if model == "drift" and self.flight.structure is not None else model

    @cached_property
    def times(self) -> FloatArray:
        """Flight times of the sweep [s], even ones and the last, ``(n,)``."""
        request, (first, last) = self.request, self.flight.span
        part = self.flight.between(request.start or first, request.stop or last)
        low, high = part.span
        count = max(int(np.ceil((high - low) / request.every - 1e-9)), 1)
        steps = low + request.every * np.arange(count)
        return np.append(steps, high)

    @cached_property
    def autopilot(self) -> GainSchedule:
        """The autopilot over the flight."""
        return flight_autopilot(
            self.plan.autopilot_design,
            self.flight,
            self.times,
            actuator=self.plan.nozzle.actuator,
            model=self.model,
            plane=self.plan.plane,
        )

    def sweep(self) -> Sweep:
        """Return the margins at the flight times, judged by the criteria of the plan."""
        options: Any = {"model": self.model, "plane": self.plan.plane}
        criteria = self.plan.held_to
        return sweep(self.flight, self.autopilot, self.times, criteria=criteria, **options)

    @property
    def notes(self) -> Iterator[str]:
        """Notes on the flight, on gains that are not specified, and on an assumed actuator."""
        yield from self.flight.notes
        if self.plan.autopilot_design.unspecified:
            yield (
                "these are textbook gains at each flight time, since no option and no file"
                " specifies others (--set autopilot.schedule FILE: a table of them)"
            )
        if self.flight.actuator_frequency is None:
            yield from actuator_notes(self.plan)
