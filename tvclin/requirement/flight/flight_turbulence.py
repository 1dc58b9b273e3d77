"""Turbulence along a flight: spread and travel of a nozzle, and its largest deflection by wind.

The loop is linear and without limits, with the autopilot that its specification gives at each
flight time. Its spread is that along the flight; in a head wind and in a sounding with the dynamic
pressure encountered, of a pulse that at its peak throughout. The response to a pulse is that of the
loop frozen at its flight time, that to a sounding of the vehicle along the flight.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import nullcontext, suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from tvclin.ascent.measured_wind import MeasuredWind
from tvclin.ascent.schedule import FlightSchedule
from tvclin.ascent.wind_along import wind_along
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, NotKnownError
from tvclin.base.fields import derived, spec
from tvclin.base.lines import Line, Row, Table, degrees, quantities, significant
from tvclin.case.case import Case
from tvclin.case.turbulence import AFTER_WIND_S, TurbulenceRequest
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.flight_autopilot import flight_autopilot
from tvclin.control.autopilot.gain_schedule import GainSchedule, autopilot_along
from tvclin.control.autopilot.sweep import plants_along
from tvclin.control.turbulence.covariance_along import turbulence_along
from tvclin.control.turbulence.covariance_history import CovarianceHistory, turbulence_history
from tvclin.control.turbulence.driven_loop import ANGLE_OF_ATTACK, DEFLECTION, DEFLECTION_RATE
from tvclin.requirement.flight.flight_winds import WindOf, encountered_winds, placed_in_planes
from tvclin.requirement.required_quantity import in_wind
from tvclin.vehicle.coefficients import BOTH
from tvclin.vehicle.vehicle import at_pressure
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import ATTACK, FROZEN, beyond_linear

_DESIGN_STEP_S = 5.0
"""Longest time between two designs of the gains [s]."""


@dataclass(frozen=True)
class LargestInTurbulence(Shown):
    """Largest over a flight of the size of the response to a wind plus k standard deviations.

    Attributes
    ----------
    wind : str
        Name of the wind, with its direction where the dynamic pressure depends on it.
    deflection, time : float
        Deflection [rad] and its flight time [s].
    deflection_rate : float or None
        Deflection rate [rad/s]; None where it has no variance.
    angle_of_attack : float
        Angle of attack [rad].
    """

    wind: str = field(metadata=spec())
    deflection: float = field(metadata=spec("angle"))
    time: float = field(metadata=spec("time"))
    deflection_rate: float | None = field(metadata=spec("angular rate"))
    angle_of_attack: float = field(metadata=spec("angle"))


@dataclass(frozen=True, eq=False)
class FlightTurbulence(Shown):
    """Autopilot in turbulence along a flight; make it with `flight_turbulence`.

    Attributes
    ----------
    request : TurbulenceRequest
        The turbulence, and the standard deviations that count.
    times : ndarray
        Flight times [s], ``(n,)``.
    deflection_rms : ndarray
        Standard deviation of the deflection at the flight times [rad], ``(n,)``.
    winds : tuple of LargestInTurbulence
        The largest in each wind.
    history : CovarianceHistory
        Spread along the flight, without a known wind.
    """

    request: TurbulenceRequest
    times: FloatArray = field(metadata=spec("time", card=False))
    deflection_rms: FloatArray = field(metadata=spec("angle", card=False))
    winds: tuple[LargestInTurbulence, ...] = field(metadata=spec(card=False))
    history: CovarianceHistory

    @property
    @derived()
    def sigmas(self) -> float:
        """Standard deviations that count on top of the response to a wind."""
        return self.request.factor

    @property
    @derived("angle")
    def largest_rms(self) -> float:
        """Largest standard deviation of the deflection over the flight [rad]."""
        return float(self.deflection_rms.max())

    @cached_property
    @derived("angle")
    def travel(self) -> float | None:
        """Expected travel of the nozzle in turbulence alone [rad]; None where it has none."""
        return self.history.travel() if DEFLECTION_RATE in self.history.outputs else None

    @cached_property
    @derived("angle")
    def travel_deviation(self) -> float | None:
        """Standard deviation of that travel over flights [rad], from its variance."""
        return self.history.travel_deviation() if self.travel is not None else None

    def quantile_at(self, time: float) -> float:
        """Return k standard deviations of the deflection at a flight time [s], in rad."""
        order = np.argsort(self.times)
        rms = np.interp(time, self.times[order], self.deflection_rms[order])
        return self.sigmas * float(rms)

    @property
    def notes(self) -> Iterator[str]:
        """Notes on the autopilot, and on an angle of attack beyond linear aerodynamics."""
        yield "turbulence is that of the linear autopilot, without limits"
        angle = max((x.angle_of_attack for x in self.winds), default=0.0)
        if beyond := beyond_linear(angle, ATTACK):
            yield f"in turbulence {beyond}"

    def tables(self) -> list[Table]:
        """Return the tables of the largest in each wind, and of the spread and travel."""
        key, label = "flight.turbulence", self.request.label
        rows: list[tuple[Line, ...]] = [
            (
                (largest.wind,),
                degrees(f"{key}.{k}.deflection", largest.deflection),
                significant(f"{key}.{k}.time", largest.time, 5),
                degrees(f"{key}.{k}.rate", _number(largest.deflection_rate)),
                degrees(f"{key}.{k}.angle_of_attack", largest.angle_of_attack),
            )
            for k, largest in enumerate(self.winds)
        ]
        heads = ("wind", "deflection [deg]", "at [s]", "rate [deg/s]", "angle of attack [deg]")
        caption = f"The linear autopilot in each wind and turbulence, wind + {label}"
        tables = [Table(caption, heads, tuple(rows))] if rows else []
        at = float(self.times[int(np.argmax(self.deflection_rms))])
        rms = degrees(f"{key}.rms", self.largest_rms, unit="deg")
        alone: list[Row] = [
            ("largest rms of the deflection", (*rms, " at ", f"{at:.5g}", " s")),
        ]
        if self.travel is not None and self.travel_deviation is not None:
            travel = degrees(f"{key}.travel", self.travel, unit="deg")
            spread = degrees(f"{key}.travel_deviation", self.travel_deviation, unit="deg")
            span = f"{self.history.times[0]:.5g} to {self.history.times[-1]:.5g} s"
            alone.append((f"expected travel, {span}", (*travel, " +- ", *spread)))
        return [*tables, quantities("Turbulence alone, along the flight", alone)]


def _number(value: float | None) -> float:
    return float("nan") if value is None else value


@dataclass(frozen=True, eq=False)
class LoopOverFlight:
    """Autopilot of a case over a flight, and its turbulence.

    `case`: model, plane, nozzle, controller and the autopilot over the flight. `times`: flight
    times [s], ``(n,)``.
    """

    case: Case
    request: TurbulenceRequest
    schedule: FlightSchedule
    times: FloatArray

    def __post_init__(self) -> None:
        if self.case.planes == BOTH:
            raise InputError("turbulence is answered in one plane; leave out the limit shape")

    @property
    def model(self) -> str:
        """Model of the motion; with a structure "drift-exact" in place of "drift"."""
        bends = self.schedule.structure is not None
        return "drift-exact" if self.case.model == "drift" and bends else self.case.model

    @cached_property
    def gains(self) -> Autopilot | GainSchedule:
        """The autopilot along the flight.

        A rule designs gains at the flight times and beyond them, where it can.
        """
        case = self.case
        if case.controller is not None:
            return case.autopilot
        begin, end = self.schedule.span
        even = np.linspace(begin, end, 2 + int((end - begin) / _DESIGN_STEP_S))
        inside = np.unique(self.times)
        design = partial(
            flight_autopilot,
            case.autopilot_design,
            self.schedule,
            actuator=case.nozzle.actuator,
            model=self.model,
            plane=case.plane,
        )
        with suppress(InputError):
            return design(np.union1d(even, inside))
        return design(inside)

    @property
    def _air_is_table(self) -> bool:
        """Whether the intensity is that of the altitudes of the flight."""
        return self.request.intensity is None and self.schedule.altitude is not None

    def along(
        self, wind: History | None = None, pressure: FloatArray | float = 1.0
    ) -> CovarianceHistory:
        """Return mean and spread along the flight.

        `pressure`: ratio of the dynamic pressure to the nominal one, at the times of the schedule.
        """
        air = self.request.over_altitude if self._air_is_table else self.request.at()
        vehicle, plane = at_pressure(self.schedule.vehicle, pressure), self.case.plane
        flown = replace(self.schedule, vehicle=vehicle)
        return turbulence_along(flown, self.gains, air, wind=wind, model=self.model, plane=plane)

    def response(self, time: float, pressure: float, pulse: History) -> CovarianceHistory:
        """Return the response to a pulse from its onset on, frozen at a flight time [s]."""
        schedule, at = self.schedule, np.asarray(time)
        height = None
        if self._air_is_table:
            height = float(np.interp(time, schedule.times, schedule.height))
        plant = plants_along(schedule, at, self.model, self.case.plane, pressure)
        autopilot = autopilot_along(self.gains, schedule, at)
        speed = float(np.interp(time, schedule.times, schedule.speed))
        wind = pulse.shift(-float(pulse.onset))
        duration = float(wind.end) + AFTER_WIND_S
        air = self.request.at(height)
        return turbulence_history(autopilot, plant, air, speed, duration, wind=wind)


def flight_turbulence(
    case: Case,
    request: TurbulenceRequest,
    schedule: FlightSchedule,
    times: FloatArray,
    winds: Mapping[str, WindOf],
    signed: tuple[bool, ...] = (),
    progress: Callable[[int, int], None] | None = None,
) -> FlightTurbulence:
    """Return the autopilot of a case in turbulence along a flight, and in each wind.

    Parameters
    ----------
    case : Case
        Model, plane, nozzle and autopilot.
    request : TurbulenceRequest
        The turbulence, and the standard deviations that count.
    schedule : FlightSchedule
        The flight.
    times : ndarray
        Flight times [s], ``(n,)``, at which a rule designs the gains, and pulses have their peak.
    winds : dict of str to wind
        Winds by name, see `SizingRequest.winds`.
    signed : tuple of bool
        Whether each of the first winds may be a head or a tail wind.
    progress : callable, optional
        Called with the number of finished and of all pairs of flight time and wind.

    Raises
    ------
    InputError
        For both planes, a loop without a covariance, and as `turbulence_along`.
    """
    loop = LoopOverFlight(case, request, schedule, np.asarray(times, dtype=float))
    history = loop.along()
    rms = np.interp(loop.times, history.times, history.deviation())
    largest: list[LargestInTurbulence] = []
    for j, (name, wind) in enumerate(winds.items()):
        if isinstance(wind, MeasuredWind):
            responses = {"": _measured(loop, wind)}
        else:
            responses = _pulses(loop, wind, signed=j < len(signed) and signed[j])
        for direction, (spread, means) in responses.items():
            label = f"{name}{in_wind(direction)}"
            rows = [_largest(label, mean, spread, request.factor, start) for start, mean in means]
            largest.append(_worst(rows))
            rms = np.maximum(rms, np.interp(loop.times, spread.times, spread.deviation()))
        if progress is not None:
            progress(j + 1, len(winds))
    return FlightTurbulence(request, loop.times, rms, tuple(largest), history)


_Responses = tuple[CovarianceHistory, list[tuple[float, CovarianceHistory]]]
"""Spread along the flight, and responses to a wind, each from a flight time [s] on."""


def _measured(loop: LoopOverFlight, wind: MeasuredWind) -> _Responses:
    """Return spread and response along a sounding, with its gust about each flight time.

    The dynamic pressure is that of the sounding.
    """
    sign = FROZEN if loop.case.sign == FROZEN else None

    def flown(gust_time: float | None) -> CovarianceHistory:
        along = wind_along(loop.schedule, wind, loop.case.plane, sign, gust_time)
        return loop.along(along.history, along.pressure(loop.schedule.times))

    times: list[float | None] = [None] if wind.gust is None else loop.times.tolist()
    responses = []
    for time in times:
        with nullcontext() if time is None else suppress(NotKnownError):  # no such gust there
            responses.append((0.0, flown(time)))
    if not responses:
        raise InputError("the gust is not known at any flight time")
    return responses[0][1], responses


def _pulses(loop: LoopOverFlight, wind: WindOf, *, signed: bool) -> dict[str, _Responses]:
    """Return the spread along the flight and the responses to a pulse, by its direction."""
    case, schedule = loop.case, loop.schedule
    rows: dict[str, list[tuple[tuple[float, float, float], CovarianceHistory]]] = {}
    for time in loop.times.tolist():
        vehicle = schedule.at(time)
        placed = placed_in_planes((case.plane,), wind, vehicle, time, "peak", 1.0)
        in_plane = placed[case.plane]
        if not in_plane.known or in_plane.calm:
            continue
        at_peaks = encountered_winds(vehicle, in_plane, placed, case.sign, signed=signed)
        for direction, at_peak, pulse in at_peaks:
            slopes = (float(np.asarray(x.normal_force_slope)) for x in (at_peak, vehicle))
            ratio = next(slopes) / next(slopes)
            row = time, ratio, float(pulse.onset)
            rows.setdefault(direction, []).append((row, loop.response(time, ratio, pulse)))
    result = {}
    for direction, found in rows.items():
        times, ratios = np.array(sorted(row[:2] for row, _ in found)).T
        flown = loop.along(None, np.interp(schedule.times, times, ratios))
        result[direction] = flown, [(row[2], response) for row, response in found]
    return result


def _largest(
    name: str, mean: CovarianceHistory, spread: CovarianceHistory, k: float, start: float = 0.0
) -> LargestInTurbulence:
    """Return the largest of each quantity, of a mean from a flight time [s] on and a spread."""
    times = mean.times + start

    def sizes(output: str) -> FloatArray:
        deviation = np.interp(times, spread.times, spread.deviation(output))
        return np.abs(mean.mean(output)) + k * deviation

    deflection, smooth = sizes(DEFLECTION), DEFLECTION_RATE in spread.outputs
    return LargestInTurbulence(
        name,
        float(deflection.max()),
        float(times[np.argmax(deflection)]),
        float(sizes(DEFLECTION_RATE).max()) if smooth else None,
        float(sizes(ANGLE_OF_ATTACK).max()),
    )


def _worst(rows: list[LargestInTurbulence]) -> LargestInTurbulence:
    """Return the largest of each quantity over the flight times of a wind."""
    rates = [row.deflection_rate for row in rows if row.deflection_rate is not None]
    return replace(
        max(rows, key=lambda row: row.deflection),
        deflection_rate=max(rates, default=None),
        angle_of_attack=max(row.angle_of_attack for row in rows),
    )
