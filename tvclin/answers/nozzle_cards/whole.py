"""The card of a whole flight: the nozzle at each flight time in each wind, and all of it together.

The vehicle is frozen at each flight time, as in a sizing. A pulse blows once, at the worst of them;
a measured wind blows all along, and of each flight time counts what is nearer to it than to any
other. So nothing is counted twice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np

from tvclin.answers.case import FROZEN, SIGNS, Case
from tvclin.answers.flexible import law_asked
from tvclin.answers.nozzle_cards.card import WINDOW, NozzleCard, card_of
from tvclin.answers.nozzle_cards.flown import actuator_notes
from tvclin.answers.nozzle_cards.motion import Motion
from tvclin.answers.nozzle_cards.record import CardPoint, Duty, FlightCard
from tvclin.answers.nozzle_cards.unjudged import flight_reason, unjudged_flights, unknown_winds
from tvclin.answers.nozzle_cards.verdict import NozzleVerdict, needed_of
from tvclin.answers.planes import rectangle
from tvclin.answers.quantity import in_wind
from tvclin.answers.sizing.notes import doubtful_winds
from tvclin.answers.sizing.placing import PlacedWind, WindOf, angle_at, place_in
from tvclin.answers.sizing.request import SizingRequest
from tvclin.answers.varying_equations import at_pressure
from tvclin.ascent.measured_wind import MeasuredPlanes, MeasuredWind
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import (
    InputError,
    between,
    callable_for,
    instance,
    number,
    one_of,
    positive,
    whole_number,
)
from tvclin.boundary.fronts.ramps import ramp_rate, ramped_deflection
from tvclin.boundary.optimum.least_peaks import least_peaks
from tvclin.boundary.stops import stop_of
from tvclin.control.laws.law import FilteredLaw, NoisyLaw
from tvclin.control.laws.registry import LAWS, design_notes
from tvclin.flights.closed_loop.fly import fly_nozzle
from tvclin.flights.theory_comparison import OUTCOME_WORDS
from tvclin.kernels.choice import repeated
from tvclin.linear.modes import unstable_modes
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import pressure_ratio

_LOUDEST = 0.1
"""The largest noise of a gyro [rad/s] that is taken."""
_SETTLED, _AFTER = 7.5, 15.0
"""Times of the fast mode after a wind between which only noise is left."""


def flight_card(
    case: Case,
    asked: SizingRequest,
    law: str = "trim",
    *,
    noise: float = 0.0,
    seed: int = 0,
    window: float = WINDOW,
    progress: Callable[[int, int], None] | None = None,
) -> FlightCard:
    """Return what a whole flight asks of the nozzle of a case, with a law flown in each wind.

    Parameters
    ----------
    case : Case
        Its nozzle, which has a limit, its model and planes, its first pulse, and the gains of the
        law "autopilot".
    asked : SizingRequest
        The flight, its times and its winds.
    law : str
        One of `tvclin.control.LAWS`, designed anew at each flight time.
    noise : float
        Of the measured attitude rate [rad/s], rms for each sample: most of a nozzle's travel.
    seed : int
        Of the noise.
    window : float
        Length [s] over which the steady rate is a mean.
    progress : callable, optional
        Is told how many flight times and winds are done, and how many there are.

    Returns
    -------
    FlightCard
        Least angle d0, rate p d0 and acceleration p^2 d0 are those of a wind that is known. All
        else is of the flights, until 15 times the fast mode's time after a pulse, and of a measured
        wind from the middle between two flight times to the next.

    Raises
    ------
    InputError
        For a case without a limit, an unknown law, numbers out of range, and as
        `SizingRequest.winds`.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plan = tv.answers.load_sizing("configuration-i")
    >>> case = tv.Case(vehicle=plan.vehicle, nozzle=tv.Nozzle(limit=np.radians(1.0)))
    >>> asked = tv.answers.SizingRequest(schedule=plan.sizing.schedule, start=60.0, stop=70.0)
    >>> card = tv.answers.flight_card(case, asked)
    >>> card.verdict.met, round(card.largest["rate_deg_per_s"], 1)
    (True, 0.3)
    """
    instance("asked", asked, SizingRequest, "see load_sizing")
    one_of("law", law, LAWS)
    if progress is not None:
        callable_for("progress", progress, "of how many are done and how many there are")
    winds, times = asked.winds(case), asked.times(case)
    if case.nozzle.limit is None:
        raise InputError(
            "the card of a flight needs the stop of the nozzle: --limit-deg, limit_deg in [nozzle],"
            " or Nozzle(limit=...)"
        )
    flying = _Flying(
        case,
        asked,
        case.nozzle.limit,
        law,
        number("noise", noise, between(0.0, _LOUDEST), "rad/s"),
        whole_number("seed", seed),
        number("window", window, positive, "s"),
        np.concatenate([times[:1], (times[1:] + times[:-1]) / 2.0, times[-1:]]),
    )
    points: list[CardPoint] = []
    signed = [pulse.heading is None for pulse in asked.pulses(case)]
    unknown: dict[str, dict[float, str]] = {}
    angles = dict.fromkeys(winds, 0.0)
    every = [(i, j, name) for i in range(times.size) for j, name in enumerate(winds)]
    with repeated(len(every)):
        for done, (i, j, name) in enumerate(every, 1):
            time, wind = float(times[i]), winds[name]
            placed = place_in(flying.planes, wind, asked.schedule.at(time), time, "peak", 1.0)
            for one in placed.values():
                if not one.known:
                    unknown.setdefault(name, {})[time] = one.why
            angles[name] = max(angles[name], angle_at(placed, time))
            sign = j < len(signed) and signed[j]
            points += flying.points(i, time, name, placed, sign, _measured(wind))
            if progress is not None:
                progress(done, len(every))
    unjudged = (
        *unknown_winds(asked.schedule, winds, unknown),
        *unjudged_flights(law, points, case.law_model),
    )
    duties = tuple(_duties(points, winds, np.diff(flying.edges)))
    return FlightCard(
        vehicle=asked.schedule.vehicle.name,
        law=law,
        points=tuple(points),
        duties=duties,
        verdict=_verdict(flying, points, duties, unjudged),
        notes=(*doubtful_winds(angles), *_notes(flying, points, winds)),
    )


@dataclass(frozen=True, eq=False)
class _Flying:
    """What all flights of a card share."""

    case: Case
    asked: SizingRequest
    limit: float
    law: str
    noise: float
    seed: int
    window: float
    edges: FloatArray

    @property
    def planes(self) -> tuple[str, ...]:
        return PLANES if self.case.planes == BOTH else (self.case.plane,)

    def points(
        self,
        i: int,
        time: float,
        name: str,
        placed: dict[str, PlacedWind],
        signed: bool,
        measured: bool,
    ) -> Iterator[CardPoint]:
        """Yield the nozzle at a flight time in a wind, by plane and sign."""
        case, schedule = self.case, self.asked.schedule
        vehicle = schedule.at(time)
        limits = self._limits(vehicle, placed)
        for plane, one in placed.items():
            if one.calm:
                continue
            poles = unstable_modes(schedule.plants(time, case.law_model, plane)).poles
            if not poles.size:
                yield CardPoint(time, name, plane, limits[plane])
                continue
            share = self.edges[i : i + 2] if measured else None
            for direction, met, history in self._met(vehicle, one, placed, share, signed):
                wind = f"{name}{in_wind(direction)}"
                point = CardPoint(time, wind, plane, limits[plane], direction=direction)
                yield self._flown(point, met, history, share)

    def _limits(self, vehicle: Vehicle, placed: dict[str, PlacedWind]) -> dict[str, float]:
        """The part of the stop of each plane, in proportion to what trim takes."""
        case = self.case
        if len(placed) == 1:
            return dict.fromkeys(placed, self.limit)
        sizes = dict.fromkeys(placed, 0.0)
        for plane, one in placed.items():
            if not one.calm:
                plant = Plant.from_vehicle(vehicle, case.law_model, plane)
                sizes[plane] = abs(float(plant.coefficients.B) * float(one.history.peak))
        whole = float(rectangle(stop_of(case.nozzle.stop or "round"), *sizes.values()))
        return {k: self.limit * size / whole for k, size in sizes.items()} if whole else sizes

    def _met(
        self,
        vehicle: Vehicle,
        placed: PlacedWind,
        planes: dict[str, PlacedWind],
        share: FloatArray | None,
        signed: bool,
    ) -> Iterator[tuple[str, Vehicle, History]]:
        """Yield the direction of a wind, the vehicle in its largest dynamic pressure, and the wind.

        The direction is empty for winds that are known to have one alone.
        """
        wind, asked = (placed.whole or placed.history).shift(placed.zero), self.case.sign
        along, angle = planes.get("pitch"), np.zeros(())
        if share is not None:  # a measured wind, which knows its own unless it is frozen
            speeds = placed.speeds
            ratio = 1.0 if speeds is None else _largest(speeds.time, speeds.pressure, share)
            yield "", at_pressure(vehicle, ratio), wind
            return
        if along is not None and not along.calm and asked != FROZEN:
            angle = np.asarray(along.history.peak)
        ratio = float(pressure_ratio(vehicle.attitude, -np.abs(angle)))
        if not angle or np.isnan(ratio):
            yield "", vehicle, wind
        elif not signed:  # it has a direction
            yield "", at_pressure(vehicle, ratio) if angle < 0.0 else vehicle, wind
        else:
            for sign in SIGNS if asked is None else (asked,):
                met = at_pressure(vehicle, ratio) if sign == "head" else vehicle
                yield sign, met, wind * float(SIGNS[sign] * np.sign(angle))

    def _flown(self, point: CardPoint, vehicle: Vehicle, wind: History, share: Any) -> CardPoint:
        """A point with its flight."""
        own = Case(
            vehicle=vehicle.replace(structure=None) if vehicle.structure else vehicle,
            model=self.case.law_model,
            plane=point.plane,
            wind=wind,
            nozzle=self.case.nozzle,
            design=self.case.design,
        )
        plant, nozzle = own.plant.rigid, own.nozzle
        poles = unstable_modes(plant).poles
        pole = np.nan if np.iscomplexobj(poles) else float(np.abs(poles).max())
        point = replace(point, least=float(least_peaks(plant, wind)), pole=pole)
        law = law_asked(own, self.law, own.hardware["rate_limit"])
        said = tuple(design_notes(law))
        if self.noise:
            bare = law.law if isinstance(law, FilteredLaw) else law
            law = NoisyLaw(bare, noise=self.noise, seed=self.seed, **own.asked.chains)
        flight = fly_nozzle(plant, law, wind, deflection_limit=point.limit, **own.hardware)
        why = flight_reason(plant, flight.status)
        if why or not flight.times.size:
            return replace(point, status=flight.status, why=why)
        whole = Motion.of_flight(flight)
        motion = whole if share is None else whole.between(*share)
        if motion is None:
            return replace(point, status=flight.status)
        told = (point.limit, self.window, nozzle.data, vehicle if nozzle.data else None)
        card, quiet, end = card_of(motion, *told), np.zeros(2), float(wind.end)
        still = whole.between(end + _SETTLED / pole, end + _AFTER / pole) if self.noise else None
        if still is not None:
            quiet = _spent(card_of(still, *told)) / float(still.times[-1] - still.times[0])
        span = float(motion.times[-1] - motion.times[0]) if share is None else 0.0
        alone = _spent(card) - quiet * span
        return replace(point, status=flight.status, card=card, said=said, alone=alone, quiet=quiet)


def _largest(times: FloatArray, ratios: FloatArray, share: FloatArray) -> float:
    """The largest of ratios at times within a share of the flight."""
    within = times[(times > share[0]) & (times < share[1])]
    return float(np.interp(np.concatenate([share, within]), times, ratios).max())


def _spent(card: NozzleCard) -> FloatArray:
    """Travel [rad] and energy [J], which is not a number without nozzle data."""
    return np.array([card.travel, np.nan if card.work is None else card.work.energy])


def _duties(
    points: list[CardPoint], winds: dict[str, WindOf], shares: FloatArray
) -> Iterator[Duty]:
    """The whole flight in each wind: a pulse once, measured winds and noise all along."""
    for wind, plane in dict.fromkeys((one.wind, one.plane) for one in points):
        mine = [one for one in points if (one.wind, one.plane) == (wind, plane)]
        spent = np.array([one.alone for one in mine if one.card is not None]).reshape(-1, 2)
        if any(one.lost or one.why for one in mine):
            spent = np.full((1, 2), np.nan)
        elif not _measured(winds.get(wind)):
            noise = np.mean([one.quiet for one in mine], axis=0) * shares.sum()
            spent = (spent.max(axis=0, initial=0.0) + noise)[np.newaxis]
        yield Duty(wind, plane, *spent.sum(axis=0).tolist())


def _measured(wind: Any) -> bool:
    return isinstance(wind, MeasuredWind | MeasuredPlanes)


def _verdict(
    flying: _Flying, points: list[CardPoint], duties: tuple[Duty, ...], unknown: tuple[str, ...]
) -> NozzleVerdict:
    """What all flights and the theory of a known wind need, each in the measure of the stop."""
    nozzle = flying.case.nozzle
    if unknown and not points:
        return NozzleVerdict.unknown_of(nozzle, unknown)
    most = flying.case.hardware["rate_limit"]
    least, pole, limit = (
        np.array([getattr(one, name) for one in points]) for name in ("least", "pole", "limit")
    )
    flown = [one.card for one in points if one.card is not None]
    with np.errstate(invalid="ignore"):
        ramped = ramped_deflection(least, np.maximum(pole, 1e-9), most)
        known = np.where(least > 0.0, np.where(np.isnan(pole), least, ramped), 0.0)
        rates = np.nan_to_num(ramp_rate(least, pole, limit), nan=0.0, posinf=np.inf)
    turned = np.array([abs(one.card.angle.value) if one.card else 0.0 for one in points])
    needed = needed_of(nozzle, flown, float(np.max([one.travel for one in duties], initial=0.0)))
    needed["limit"] = flying.limit * float(np.max(np.maximum(known, turned) / limit, initial=0.0))
    needed["rate_limit"] = max(float(rates.max(initial=0.0)), needed["rate_limit"])
    lost = [
        f"{flying.law} {OUTCOME_WORDS[one.status]} at {one.time:.6g} s in {one.wind}"
        for one in points
        if one.lost
    ]
    return NozzleVerdict.of(nozzle, needed, lost, unknown)


def _notes(flying: _Flying, points: list[CardPoint], winds: dict[str, WindOf]) -> Iterator[str]:
    """Yield what is left out, and how the whole flight is counted."""
    still = [one for one in points if not one.pole]
    if still:
        yield f"without an unstable pole nothing is needed, as at {still[0].time:.6g} s"
    if any(map(_measured, winds.values())):
        yield (
            "a measured wind is counted from the middle between two flight times to the next, so"
            " that nothing counts twice"
            + (
                ""
                if flying.case.sign == FROZEN
                else "; the vehicle meets the largest dynamic pressure there"
            )
        )
    if any(one.direction == "head" for one in points):
        yield (
            "the dynamic pressure is that at the peak of a head wind throughout, and in a tail wind"
            " the nominal one"
        )
    if not all(map(_measured, winds.values())):
        noise = ", noise all along" if flying.noise else ""
        yield f"in the whole flight a pulse blows once, at the worst flight time{noise}"
    if flying.case.planes == BOTH:
        yield "each plane is flown by itself, with the part of the stop that trim would give it"
    yield from dict.fromkeys(chain.from_iterable(x.card.notes for x in points if x.card))
    told = [one for one in points if one.said]
    if told:
        others = f", and alike at {len(told) - 1} others" if len(told) > 1 else ""
        yield f"at {told[0].time:.6g} s{others}: {'; '.join(told[0].said)}"
    if flying.asked.schedule.vehicle.structure is not None:
        yield "the vehicle is rigid, without the structure in its file"
    yield from actuator_notes(flying.case.nozzle.actuator)
