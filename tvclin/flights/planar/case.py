"""One flight of the report's nonlinear equations in one plane, event-exact.

The bridge between the linear theory and an engine: the same equations as the theory, without
its small angles, with parameters frozen as in the theory or varying along the nominal flight.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from tvclin.ascent.flight_condition import FlightCondition
from tvclin.ascent.nominal_flight import nominal_flight
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, ending, flag, instance
from tvclin.control.laws.law import Law
from tvclin.control.laws.trim import TrimLaw
from tvclin.flights.answer import FARTHEST
from tvclin.flights.closed_loop.checks import check_span
from tvclin.flights.closed_loop.continuous import Arc, ContinuousFlight, smooth_piece
from tvclin.flights.closed_loop.regimes import Loop
from tvclin.flights.control import ONSET, Command, ReportControl, check_one
from tvclin.flights.planar.equations import PlanarMotion
from tvclin.linear.plant import Plant
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History

_RTOL, _ATOL = 1e-9, 1e-12
"""Of the solver, for each step of a flight without a law; angles [rad] are some hundredths."""
_FURTHER = 1e-6
"""A flight is followed so little further than its end, over the attitude there."""


@dataclass(frozen=True, eq=False)
class Flown:
    """A flight.

    `rows`: takes times [s] ``(m,)`` and gives the states and the deflection, ``(states + 1, m)``;
    NaN after the end. `end`: when the attitude left the range of the model [s]; infinite if it did
    not.
    """

    rows: Callable[[FloatArray], FloatArray]
    end: float


@dataclass(frozen=True, eq=False)
class PlanarCase:
    """What is flown, checked; make it with `planar_case`.

    `motion`: the equations. `wind`: one wind that ends. `span`: beginning and end of the flight
    [s].
    """

    motion: PlanarMotion
    wind: History
    span: tuple[float, float]

    def flown(self, command: Command, limit: float) -> Flown:
        """Return the flight of a command from rest, within a limit [rad].

        `InputError` for noise, and a rate limit without an actuator.
        """
        control, actuator, rate_limit = command.control, command.actuator, command.rate_limit
        if isinstance(control, History):
            return self._by_history(control, limit)
        if isinstance(control, ReportControl):
            design = Plant.from_vehicle(self.motion.vehicle, "fixed-path", self.motion.plane)
            control = _TrimThenHold(design, dead_band=control.dead_band)
        law: Law = control
        if law.rate_noise[0]:
            raise InputError("noise belongs to samples, and this flight has none; leave it out")
        if rate_limit < np.inf and actuator is None:
            raise InputError("a rate_limit needs an actuator")
        loop = Loop(self.motion, law, limit, rate_limit, actuator)
        flight = ContinuousFlight(loop, self.wind, FARTHEST)
        arcs = flight.arcs(*self.span)
        return self._ended(arcs, lambda times: flight.shown(arcs, times))

    def _by_history(self, control: History, limit: float) -> Flown:
        from scipy.integrate import solve_ivp

        start, stop = self.span
        knots = np.concatenate([self.wind.knots, control.knots])
        inside = knots[(knots > start) & (knots < stop)]
        state, arcs = np.zeros(len(self.motion.states)), []
        for first, last in pairwise(np.unique([start, *inside, max(stop, start + 1e-9)])):
            inputs = smooth_piece(control, float(first)), smooth_piece(self.wind, float(first))
            found = solve_ivp(
                self._rates,
                (first, last),
                state,
                method="DOP853",
                rtol=_RTOL,
                atol=_ATOL,
                dense_output=True,
                events=_far,
                args=(limit, *inputs),
            )
            arcs.append(Arc(float(first), found.sol, 0.0))
            state = found.y[:, -1]
            if found.status:
                break
        starts = np.array([arc.start for arc in arcs])

        def rows(times: FloatArray) -> FloatArray:
            index = np.clip(np.searchsorted(starts, times, side="right") - 1, 0, None)
            states = np.stack([arcs[k].solution(t) for k, t in zip(index, times, strict=True)], -1)
            return np.vstack([states, np.clip(control(times), -limit, limit)])

        return self._ended(arcs, rows)

    def _rates(self, t: float, x: FloatArray, limit: float, turned: Any, gust: Any) -> FloatArray:
        return self.motion.rates(t, x, min(max(float(turned(t)), -limit), limit), gust(t))

    def _ended(self, arcs: list[Arc], rows: Callable[[FloatArray], FloatArray]) -> Flown:
        solution: Any = arcs[-1].solution
        last = float(solution.t_max)
        if last >= self.span[1]:
            return Flown(rows, np.inf)
        return Flown(lambda times: np.where(times > last, np.nan, rows(times)), last)


def planar_case(
    vehicle: Vehicle,
    wind: History,
    span: tuple[float, float],
    *,
    plane: str,
    drift: bool,
    condition: FlightCondition | None,
) -> PlanarCase:
    """Return the case of a vehicle in a wind over a span of time [s]; as of `fly_planar`."""
    instance("vehicle", vehicle, Vehicle, "see load_vehicle")
    check_span(*span)
    check_one("wind", wind, span[0])
    ending("wind", wind.end)
    nominal = None
    if condition is not None:
        own = 0.0 if vehicle.time is None else float(vehicle.time)
        first, last = min(span[0], own), max(span[1], own) + 1e-3
        nominal = nominal_flight(vehicle, condition, start=first, stop=last)
    return PlanarCase(PlanarMotion(vehicle, plane, flag("drift", drift), nominal), wind, span)


@dataclass(frozen=True)
class _TrimThenHold(TrimLaw):
    """The report's control: trim until K times the limit is asked for, then the limit for ever."""

    dead_band: float = 1.0
    release = -np.inf

    @property
    def engage(self) -> float:  # type: ignore[override]
        """K, or the first sign of a wind."""
        return max(self.dead_band, ONSET)


def _far(t: float, x: FloatArray, *inputs: Any) -> float:
    """What falls through zero where the attitude leaves the range of the model."""
    del t, inputs
    return FARTHEST * (1.0 + _FURTHER) - abs(float(x[0]))


_far.terminal = True  # type: ignore[attr-defined]
