"""Duty of a nozzle in the flight of a law in one wind, and over an entire flight.

The vehicle is frozen at each flight time, as in a sizing. A pulse occurs once, at the worst flight
time; a measured wind lasts the entire flight, and each flight time counts the interval around it,
so that no interval is counted twice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain
from typing import Any, Self

import numpy as np

from tvclin.ascent.measured_wind import MeasuredPlanes, MeasuredWind
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, callable_for, instance, one_of
from tvclin.base.fields import spec
from tvclin.base.lines import Table
from tvclin.boundary.limit_over_rate import ramp_rate, ramped_deflection
from tvclin.boundary.limit_shapes import limit_shape_of
from tvclin.boundary.optimum.minimum_peak import minimum_peaks
from tvclin.case.case import Case
from tvclin.case.flexible_autopilot import specified_law
from tvclin.case.nozzle import Nozzle
from tvclin.case.turbulence import TurbulenceRequest
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.design_rules import GIVEN_GAINS, AutopilotDesign
from tvclin.control.autopilot.gain_schedule import design_at
from tvclin.control.autopilot.gain_table import GainTable
from tvclin.control.laws.law import FilteredLaw, Law, NoisyLaw
from tvclin.control.laws.registry import AUTOPILOT, LAWS, design_law, design_notes, linear_gains
from tvclin.control.turbulence.driven_loop import ACCELERATION, DEFLECTION, DEFLECTION_RATE
from tvclin.flights.closed_loop.fly import fly_nozzle
from tvclin.flights.closed_loop.fly_many import NOT_KNOWN, OUTCOME_WORDS, SURVIVED
from tvclin.kernels.choice import repeated
from tvclin.linear.modes import unstable_modes
from tvclin.linear.plant import Plant
from tvclin.nozzle.data_sheet import (
    DutyPoint,
    FlightDuty,
    NozzleVerdict,
    WindDuty,
    flight_reason,
    requirements_on_nozzle,
    unjudged_flights,
    unknown_winds,
)
from tvclin.nozzle.duty import WINDOW, Motion, NozzleDuty, duty_of_motion
from tvclin.requirement.flight.flight_turbulence import FlightTurbulence
from tvclin.requirement.flight.flight_winds import (
    PlacedWind,
    WindOf,
    angle_at,
    encountered_winds,
    placed_in_planes,
)
from tvclin.requirement.flight.request import SizingRequest
from tvclin.requirement.flight.sizing import doubtful_winds
from tvclin.requirement.plane_requirement import rectangle
from tvclin.requirement.required_quantity import in_wind
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.vehicle.linear_vehicle import complete_vehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import FROZEN, beyond_linear


@dataclass(frozen=True)
class FlownDuty(Shown):
    """Duty of a nozzle in the flight of a law, and the verdict on its data sheet.

    `status`: outcome of the flight; see `fly_many`. `duty`: the duty until 15 time constants of the
    fast mode after the wind; None for a flight that is lost, and in a wind beyond linear
    aerodynamics or with gaps. `notes`: on the design of the law, and on omitted terms.
    """

    law: str = field(metadata=spec())
    status: str = field(metadata=spec())
    duty: NozzleDuty | None = field(metadata=spec())
    notes: tuple[str, ...]
    verdict: NozzleVerdict = field(metadata=spec())

    @classmethod
    def of(cls, case: Case, name: str, law: Law) -> Self:
        """Return the duty of a law in the wind of a case, whose nozzle has a deflection limit.

        `name`: name of the law. A wind beyond the linear aerodynamics, or a flight without an
        outcome, is not judged. A flight that is lost has no duty; the verdict says so.
        """
        limit, data, vehicle = case.nozzle.limit, case.nozzle.data, None
        assert limit is not None
        if data is not None:  # data of the nozzle's joint, for its torque, which a vehicle loads
            vehicle = complete_vehicle(case.vehicle, "the torque of a nozzle").rigid
        if beyond := beyond_linear(float(case.history.peak)):
            return cls(name, NOT_KNOWN, None, (), NozzleVerdict.unknown_of(case.nozzle, (beyond,)))
        flight = fly_nozzle(case.plant, law, case.history, deflection_limit=limit, **case.hardware)
        notes, status = tuple(design_notes(law)), flight.status
        reason = flight_reason(case.plant, status)
        if status == SURVIVED and case.unknown_wind:
            reason, status = case.unknown_wind, NOT_KNOWN
        if reason:
            unknown = NozzleVerdict.unknown_of(case.nozzle, [f"the flight of {name}: {reason}"])
            return cls(name, status, None, notes, unknown)
        duties, diverged = [], [] if status == SURVIVED else [f"{name} {OUTCOME_WORDS[status]}"]
        if flight.times.size:
            duties = [duty_of_motion(Motion.of_flight(flight), limit, WINDOW, data, vehicle)]
            notes = (*notes, *duties[0].notes, *actuator_notes(case.nozzle.actuator))
        duty = next(iter(duties), None)
        required = requirements_on_nozzle(case.nozzle, duties, duty.travel if duty else np.nan)
        return cls(name, status, duty, notes, NozzleVerdict.of(case.nozzle, required, diverged))

    def bounded_by(self, at_largest: Self | None) -> Self:
        """Return the duty with a verdict that also counts the largest dynamic pressure in the wind.

        `at_largest`: duty of the same law at that pressure throughout, an upper bound of what the
        flight encounters; None where it is not known. Limits that are not sufficient stay so, and
        those that are sufficient for this flight alone are not known to be.
        """
        if at_largest is not None and at_largest.verdict.satisfied:
            return self
        reason = "the dynamic pressure in this wind is not known"
        if at_largest is not None:
            words = at_largest.verdict.words
            reason = f"with the largest dynamic pressure in this wind throughout, a bound, {words}"
        return replace(self, verdict=replace(self.verdict, unknown=(reason,)))

    @property
    def survived(self) -> bool:
        """Whether the flight is survived."""
        return self.status == SURVIVED

    @property
    def words(self) -> str:
        """The outcome of the flight, in words."""
        return f"{self.law} {OUTCOME_WORDS[self.status]} with this limit and rate"

    def tables(self) -> tuple[Table, ...]:
        """Return the tables of duty and data sheet; empty for a flight that does not survive."""
        return () if self.duty is None else (*self.duty.tables(), *self.verdict.tables())


def actuator_notes(actuator: Actuator | None) -> Iterator[str]:
    """Yield notes on rates and accelerations that the model of the actuator omits.

    An actuator without a damping is of first order.
    """
    if actuator is None:
        yield "without an actuator, rates and accelerations are differences from sample to sample"
    elif actuator.damping is None:
        yield "the rate of an actuator of first order jumps, which counts as no acceleration"
    else:
        yield "the acceleration of the nozzle as it runs into its stop is not counted"


_DESIGN_STEP_S = 5.0
"""Longest time between two designs of a law in turbulence [s]."""
_NOISE_START, _NOISE_END = 7.5, 15.0
"""Ends of the interval with noise alone after a wind, in time constants of the fast mode."""


def flight_duty(
    case: Case,
    request: SizingRequest,
    law: str = "trim",
    *,
    turbulence: TurbulenceRequest | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> FlightDuty:
    """Return the duty of the nozzle of a case over a flight, with a law flown in each wind.

    Parameters
    ----------
    case : Case
        Nozzle with a limit, model and planes, first pulse, and the gains of the law "autopilot".
    request : SizingRequest
        The flight, its times and its winds, the noise of the measured attitude rate, and the length
        over which the steady rate is a mean.
    law : str
        Name of `tvclin.control.LAWS`; the law is designed at each flight time.
    turbulence : TurbulenceRequest, optional
        Turbulence on top of each wind, of the law as long as it is linear: its standard deviations
        count beside what the flights use. Of laws that switch the verdict is then not known.
    progress : callable, optional
        Called with the number of finished and of all pairs of flight time and wind.

    Returns
    -------
    FlightDuty
        Minimum angle d0, rate p d0 and acceleration p^2 d0 are for a known wind. All other numbers
        are of flights, until 15 time constants of the fast mode after a pulse, and in a measured
        wind from the middle between two flight times to the next.

    Raises
    ------
    InputError
        For a case without a limit, an unknown law, and numbers out of range; also the exceptions of
        `SizingRequest.winds`.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plan = tv.studyfile.load_sizing("configuration-i")
    >>> case = tv.Case(vehicle=plan.vehicle, nozzle=tv.Nozzle(limit=np.radians(1.0)))
    >>> request = tv.requirement.SizingRequest(schedule=plan.sizing.schedule, start=60.0, stop=70.0)
    >>> duty = tv.nozzle.flight_duty(case, request)
    >>> duty.verdict.satisfied, round(duty.largest["rate_deg_per_s"], 1)
    (True, 0.3)
    """
    instance("request", request, SizingRequest, "see load_sizing")
    one_of("law", law, LAWS)
    if turbulence is not None:
        instance("turbulence", turbulence, TurbulenceRequest, "of an intensity or a severity")
    if progress is not None:
        callable_for("progress", progress, "of how many are done and how many there are")
    winds, times = request.winds(case), request.times(case)
    if case.nozzle.limit is None:
        raise InputError(
            "the duty over a flight needs the deflection limit of the nozzle: --limit-deg,"
            " limit_deg in [nozzle], or Nozzle(limit=...)"
        )
    edges = np.concatenate([times[:1], (times[1:] + times[:-1]) / 2.0, times[-1:]])
    conditions = _Conditions(
        case=case, request=request, limit=case.nozzle.limit, law=law, edges=edges
    )
    points: list[DutyPoint] = []
    # pulses are the first of the winds; without a heading each is flown as head and tail wind
    signed_pulses = [pulse.heading is None for pulse in request.pulses(case)]
    unknown: dict[str, dict[float, str]] = {}
    angles = dict.fromkeys(winds, 0.0)
    pairs = [(i, j, name) for i in range(times.size) for j, name in enumerate(winds)]
    with repeated(len(pairs)):  # similar runs, which decide between compiled and plain code
        for done, (i, j, name) in enumerate(pairs, 1):
            time, wind = float(times[i]), winds[name]
            vehicle = request.schedule.at(time)
            placed = placed_in_planes(conditions.planes, wind, vehicle, time)
            # empty where a sounding ends
            reasons = [in_plane.why for in_plane in placed.values() if not in_plane.known]
            if isinstance(wind, MeasuredWind | MeasuredPlanes):
                in_interval = wind.gaps.reason(*edges[i : i + 2].tolist())
                reasons += [in_interval] if in_interval else []
            if reasons:
                unknown.setdefault(name, {})[time] = next(filter(None, reasons), "")
            angles[name] = max(angles[name], angle_at(placed, time))
            signed = j < len(signed_pulses) and signed_pulses[j]
            points += conditions.points(i, time, name, placed, signed, _measured(wind))
            if progress is not None:
                progress(done, len(pairs))
    unjudged = [
        *unknown_winds(request.schedule, winds, unknown),
        *unjudged_flights(law, points, case.law_model),
    ]
    random = _in_turbulence(case, request, law, max(angles.values()), turbulence)
    if isinstance(random, str):  # the reason why it is not known
        unjudged.append(f"turbulence: {random}")
        random = None
    duties = tuple(_duties(points, winds, np.diff(conditions.edges)))
    return FlightDuty(
        vehicle=request.schedule.vehicle.name,
        law=law,
        points=tuple(points),
        duties=duties,
        verdict=_verdict(conditions, points, duties, tuple(unjudged), random),
        notes=(
            *doubtful_winds(angles),
            *_turbulence_notes(random, law, case.nozzle),
            *_notes(conditions, points, winds),
        ),
        turbulence=random,
    )


@dataclass(frozen=True, eq=False)
class _Conditions:
    """Conditions that are common to all flights of a law.

    `limit`: deflection limit [rad]. `law`: its name. `edges`: ends of the intervals [s] around the
    n flight times, ``(n + 1,)``.
    """

    case: Case
    request: SizingRequest
    limit: float
    law: str
    edges: FloatArray

    @property
    def planes(self) -> tuple[str, ...]:
        """Names of the planes that are flown."""
        return PLANES if self.case.planes == BOTH else (self.case.plane,)

    def points(
        self,
        i: int,
        time: float,
        name: str,
        placed: dict[str, PlacedWind],
        signed: bool,
        measured: bool,
    ) -> Iterator[DutyPoint]:
        """Yield the duty of the nozzle at a flight time in a wind, by plane and sign.

        `i`, `time`: index of the flight time, and itself [s]. `name`: name of the wind. `placed`:
        the wind in each plane. `signed`: whether head and tail wind count separately. `measured`:
        whether the wind lasts the flight, so that only the interval around this time counts, from
        ``edges[i]`` [s] on. Each flight is of the vehicle in the dynamic pressure that its wind
        encounters, `at_peak`; nothing is flown without an unstable pole.
        """
        case, schedule = self.case, self.request.schedule
        vehicle = schedule.at(time)
        limits = self._limits(vehicle, placed)
        for plane, in_plane in placed.items():
            if in_plane.calm:
                continue
            poles = unstable_modes(schedule.plants(time, case.law_model, plane)).poles
            if not poles.size:
                yield DutyPoint(time=time, wind=name, plane=plane, limit=limits[plane])
                continue
            interval = self.edges[i : i + 2] if measured else None
            for direction, at_peak, history in encountered_winds(
                vehicle, in_plane, placed, case.sign, signed=signed, interval=interval
            ):
                wind = f"{name}{in_wind(direction)}"
                point = DutyPoint(
                    time=time, wind=wind, plane=plane, limit=limits[plane], direction=direction
                )
                yield self._flown(point, at_peak, history, interval)

    def _limits(self, vehicle: Vehicle, placed: dict[str, PlacedWind]) -> dict[str, float]:
        """Return the share of the deflection limit [rad] by plane, in proportion to trim.

        `vehicle`: frozen at its flight time. `placed`: the wind in each plane. Trim is the peak of
        the wind in that plane times B, the trim deflection per angle of attack; a single plane has
        the whole limit, and a calm plane none.
        """
        case = self.case
        if len(placed) == 1:
            return dict.fromkeys(placed, self.limit)
        trims = dict.fromkeys(placed, 0.0)
        for plane, in_plane in placed.items():
            if not in_plane.calm:
                plant = Plant.from_vehicle(vehicle, case.law_model, plane)
                trims[plane] = abs(float(plant.coefficients.B) * float(in_plane.history.peak))
        # The scale of the limit shape that contains both trims at once.
        shape = limit_shape_of(case.nozzle.limit_shape or "round")
        total = float(rectangle(shape, *trims.values()))
        return {k: self.limit * trim / total for k, trim in trims.items()} if total else trims

    def _flown(self, point: DutyPoint, vehicle: Vehicle, wind: History, interval: Any) -> DutyPoint:
        """Return a point with status and duty of its flight, in an interval of it.

        Travel and energy that sensor noise takes, `noise_rate` per second, are taken from 7.5 to 15
        time constants of the fast mode after the wind, where noise alone moves the nozzle, and are
        not in `without_noise`. `point`: time, wind, plane and limit. `vehicle`: frozen, in the air
        of that wind. `wind`: wind angle [rad]. `interval`: begin and end [s]; None: all.
        """
        case = Case(
            vehicle=vehicle.replace(structure=None) if vehicle.structure else vehicle,
            model=self.case.law_model,
            plane=point.plane,
            wind=wind,
            nozzle=self.case.nozzle,
            design=frozen_design(self.case, self.request, point.time),
            controller=self.case.controller,
        )
        plant, nozzle = case.plant.rigid, case.nozzle
        poles = unstable_modes(plant).poles
        # The fast pole [1/s]; none of a complex pair.
        pole = np.nan if np.iscomplexobj(poles) else float(np.abs(poles).max())
        point = replace(point, minimum=float(minimum_peaks(plant, wind)), pole=pole)
        law = specified_law(case, self.law, case.hardware["rate_limit"])
        notes = tuple(design_notes(law))
        request = self.request
        if request.rate_noise:
            bare = law.law if isinstance(law, FilteredLaw) else law
            chains = case.autopilot_design.chains
            law = NoisyLaw(bare, noise=request.rate_noise, seed=request.noise_seed, **chains)
        flight = fly_nozzle(plant, law, wind, deflection_limit=point.limit, **case.hardware)
        reason = flight_reason(plant, flight.status)
        if reason or not flight.times.size:
            return replace(point, status=flight.status, reason=reason)
        complete = Motion.of_flight(flight)
        motion = complete if interval is None else complete.between(*interval)
        if motion is None:
            return replace(point, status=flight.status)
        duty_in = partial(
            duty_of_motion,
            limit=point.limit,
            window=request.steady_window,
            nozzle=nozzle.data,
            vehicle=vehicle if nozzle.data else None,
        )
        duty, noise_rate = duty_in(motion), np.zeros(2)  # travel and energy per second
        if request.rate_noise:  # noise alone moves the nozzle some time after the wind
            begin, end = (float(wind.end) + t / pole for t in (_NOISE_START, _NOISE_END))
            noisy = complete.between(begin, end)
            if noisy is not None:
                duration = float(noisy.times[-1] - noisy.times[0])
                noise_rate = _spent(duty_in(noisy)) / duration
        # of a pulse the noise is subtracted, as it counts over the whole flight; an interval of a
        # measured wind keeps its own
        span = float(motion.times[-1] - motion.times[0]) if interval is None else 0.0
        without_noise = _spent(duty) - noise_rate * span
        return replace(
            point,
            status=flight.status,
            duty=duty,
            law_notes=notes,
            without_noise=without_noise,
            noise_rate=noise_rate,
        )


def frozen_design(case: Case, request: SizingRequest, time: float) -> AutopilotDesign | None:
    """Return the autopilot at a flight time [s]: that over the flight, or else that of the case."""
    scheduled = request.scheduled_design
    return case.design if scheduled is None else design_at(scheduled, request.schedule, time)


def _spent(duty: NozzleDuty) -> FloatArray:
    """Return travel [rad] and energy [J] of a duty, ``(2,)``; NaN energy without nozzle data."""
    return np.array([duty.travel, np.nan if duty.work is None else duty.work.energy])


def _duties(
    points: list[DutyPoint], winds: dict[str, WindOf], intervals: FloatArray
) -> Iterator[WindDuty]:
    """Yield the duty over the flight by wind: pulses count once, other winds and noise add up.

    `points`: all flights, each with travel and energy `without_noise`, and those of noise in a
    second, `noise_rate`. `winds`: by name. `intervals`: duration [s] of the interval around each
    flight time. NaN where a flight is lost or cannot be judged.
    """
    for wind, plane in dict.fromkeys((point.wind, point.plane) for point in points):
        flown = [point for point in points if (point.wind, point.plane) == (wind, plane)]
        rows = [point.without_noise for point in flown if point.duty is not None]
        spent = np.array(rows).reshape(-1, 2)
        if any(point.diverged or point.reason for point in flown):
            spent = np.full((1, 2), np.nan)  # a single row of travel and energy
        elif not _measured(winds.get(wind)):
            noise = np.mean([point.noise_rate for point in flown], axis=0) * intervals.sum()
            spent = (spent.max(axis=0, initial=0.0) + noise)[np.newaxis]
        yield WindDuty(wind, plane, *spent.sum(axis=0).tolist())


def _measured(wind: Any) -> bool:
    """Return whether a wind was measured over the heights of the flight."""
    return isinstance(wind, MeasuredWind | MeasuredPlanes)


def _verdict(
    conditions: _Conditions,
    points: list[DutyPoint],
    duties: tuple[WindDuty, ...],
    unknown: tuple[str, ...],
    turbulence: FlightTurbulence | None,
) -> NozzleVerdict:
    """Return the verdict from the requirements of all flights and of the theory of a known wind.

    `conditions`: common to all flights. `points`: all flights. `duties`: of the whole flight, by
    wind. `unknown`: what cannot be judged, in words. `turbulence`: counted on top of each wind, or
    None.
    """
    nozzle = conditions.case.nozzle
    if unknown and not points:  # no flight and no theory to require anything
        return NozzleVerdict.unknown_of(nozzle, unknown)
    max_rate = conditions.case.hardware["rate_limit"]
    minimum, pole, limit = (
        np.array([getattr(point, name) for point in points])
        for name in ("minimum", "pole", "limit")
    )
    flown = [point.duty for point in points if point.duty is not None]
    # Of any control that knows the wind: the angle with a ramp at the rate limit, and the rate of
    # a ramp to the deflection limit. For a complex pair the angle is d0, and the rate 0.
    with np.errstate(invalid="ignore"):  # without a pole, in whose place is 1e-9, none is required
        ramped = ramped_deflection(minimum, np.maximum(pole, 1e-9), max_rate)
        theory = np.where(minimum > 0.0, np.where(np.isnan(pole), minimum, ramped), 0.0)
        rates = np.nan_to_num(ramp_rate(minimum, pole, limit), nan=0.0, posinf=np.inf)
    angles = np.array([abs(x.duty.angle.value) if x.duty else 0.0 for x in points])
    travel = float(np.max([duty.travel for duty in duties], initial=0.0))
    required = requirements_on_nozzle(nozzle, flown, travel)
    # the angle that theory or flight requires, the larger, over the limit of the plane
    ratio = float(np.max(np.maximum(theory, angles) / limit, initial=0.0))
    # the limit of the nozzle in proportion to the point that takes most of the limit in its plane
    required["limit"] = conditions.limit * ratio
    required["rate_limit"] = max(float(rates.max(initial=0.0)), required["rate_limit"])
    if turbulence is not None:
        _add_turbulence(required, points, turbulence, nozzle)
    diverged = [
        f"{conditions.law} {OUTCOME_WORDS[point.status]} at {point.time:.6g} s in {point.wind}"
        for point in points
        if point.diverged
    ]
    return NozzleVerdict.of(nozzle, required, diverged, unknown)


def _add_turbulence(
    required: dict[str, float],
    points: list[DutyPoint],
    turbulence: FlightTurbulence,
    nozzle: Nozzle,
) -> None:
    """Add k standard deviations of turbulence to the requirements of flights, in place.

    `required`: requirements by the key of their limit [SI]. `points`: all flights. Torque and power
    in turbulence are not known where those of the wind are within the limits of `nozzle`.
    """
    flown = [(point.time, point.duty) for point in points if point.duty is not None]
    for name, peak, output in (
        ("limit", "angle", DEFLECTION),
        ("rate_limit", "rate", DEFLECTION_RATE),
        ("acceleration_limit", "acceleration", ACCELERATION),
    ):
        sizes = [
            abs(getattr(duty, peak).value) + turbulence.quantile_at(time, output)
            for time, duty in flown
        ]
        required[name] = float(np.max([required[name], *sizes]))
    travels = [wind.travel for wind in turbulence.winds]
    # travel [rad] that turbulence adds in each wind
    added = [
        np.nan if x is None else x.expected - x.of_wind + turbulence.sigmas * x.deviation
        for x in travels
    ]
    required["travel_limit"] += float(np.max(added, initial=0.0))
    for name in ("torque_limit", "power_limit"):
        if required.get(name, np.inf) <= (getattr(nozzle, name) or 0.0):
            required[name] = np.nan


def _in_turbulence(
    case: Case, request: SizingRequest, law: str, peak: float, turbulence: TurbulenceRequest | None
) -> FlightTurbulence | str | None:
    """Return a law in turbulence along the flight, or the reason for which it is not known.

    `case`: nozzle, model and autopilot. `request`: the flight. `law`: name of the law. `peak`:
    largest wind angle [rad], for which a law is designed. `turbulence`: None: there is none.
    """
    if turbulence is None or law == AUTOPILOT:  # None without turbulence
        return request.turbulence(case, turbulence)
    schedule, (begin, end) = request.schedule, request.schedule.span
    even = np.linspace(begin, end, 2 + int((end - begin) / _DESIGN_STEP_S))
    # gains of an autopilot that is the same as the law within its limit, by flight time
    designs: dict[float, dict[str, float]] = {}
    for time in np.union1d(even, request.times(case)).tolist():
        plant = schedule.plants(time, case.law_model, case.plane)
        if not unstable_modes(plant).poles.size:
            continue
        try:
            designed = design_law(law, plant, peak, rate_limit=case.hardware["rate_limit"])
        except InputError as error:
            return str(error)
        if (gains_at := linear_gains(designed)) is None:
            return f"{law} is not linear within the limit, as {AUTOPILOT}, trim and half-relief are"
        designs[time] = gains_at
    gains = {k: np.array([row[k] for row in designs.values()]) for k in GIVEN_GAINS}
    table = GainTable("time", np.array(list(designs)), gains)
    specified = case.autopilot_design
    chains: Any = specified.chains
    design = AutopilotDesign(
        delay=specified.delay, sample_rate=specified.sample_rate, schedule=table, **chains
    )
    # The gains of the law, between these flight times linear, replace the autopilot of the case.
    flown = replace(request, scheduled_design=design)
    return flown.turbulence(replace(case, controller=None), turbulence)


def _turbulence_notes(
    turbulence: FlightTurbulence | None, law: str, nozzle: Nozzle
) -> Iterator[str]:
    """Yield notes on how the duty includes turbulence, and on what is not known in it.

    `law`: its name. `nozzle`: its rate limit and data.
    """
    if turbulence is not None:
        yield (
            f"{turbulence.request.label} of turbulence count on top of each wind: of travel from"
            f" its variance over flights, of the linear law {law} without limits"
        )
        if law == "trim" and nozzle.rate_limit is not None and len(turbulence.winds) > 1:
            yield "in turbulence the gain of trim is that for the largest wind angle"
        yield from turbulence.sounding_notes
        if DEFLECTION_RATE not in turbulence.rms:
            yield "rate and travel in turbulence are not known without an actuator"
        if nozzle.data is not None:
            yield "torque, power and energy are those of the winds, without turbulence"


def _notes(
    conditions: _Conditions, points: list[DutyPoint], winds: dict[str, WindOf]
) -> Iterator[str]:
    """Yield notes on omitted terms, and on how the whole flight is counted.

    `conditions`: common to all flights. `points`: all flights. `winds`: by name.
    """
    stable = [point for point in points if not point.pole]  # zero without an unstable pole
    if stable:
        yield f"without an unstable pole no deflection is required, as at {stable[0].time:.6g} s"
    if any(map(_measured, winds.values())):
        pressure = "; the dynamic pressure is the largest of the interval"
        yield (
            "a measured wind is counted from the middle between two flight times to the next, so"
            f" that no interval counts twice{'' if conditions.case.sign == FROZEN else pressure};"
            " the minima are of all of it past the vehicle as it is then, and may be larger"
        )
    if any(point.direction == "head" for point in points):
        yield (
            "the dynamic pressure is that at the peak of a head wind throughout, and in a tail wind"
            " the nominal one"
        )
    if not all(map(_measured, winds.values())):
        noise = ", noise at all times" if conditions.request.rate_noise else ""
        yield f"over the flight a pulse occurs once, at the worst flight time{noise}"
    if conditions.case.planes == BOTH:
        yield "each plane is flown separately, with the limit divided in proportion to trim"
    yield from dict.fromkeys(chain.from_iterable(x.duty.notes for x in points if x.duty))
    noted = [point for point in points if point.law_notes]
    if noted:
        others = f", and alike at {len(noted) - 1} others" if len(noted) > 1 else ""
        yield f"at {noted[0].time:.6g} s{others}: {'; '.join(noted[0].law_notes)}"
    if conditions.request.schedule.vehicle.structure is not None:
        yield "the vehicle is rigid, without the structure in its file"
    yield from actuator_notes(conditions.case.nozzle.actuator)
