"""Turbulence along a flight: deviation and travel of a nozzle, largest deflection by wind.

The loop is linear and without limits, with the autopilot that its specification gives at each
flight time. Its covariance is computed along the flight: with the dynamic pressure encountered in a
head wind and in a sounding, with the pressure at the peak of a pulse throughout. To a pulse the
loop responds frozen at its flight time, to a sounding as the vehicle varies along the flight.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import nullcontext, suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import NamedTuple, TypeAlias

import numpy as np

from tvclin.ascent.measured_wind import MeasuredWind
from tvclin.ascent.schedule import FlightSchedule
from tvclin.ascent.structure_schedule import StructureSchedule
from tvclin.ascent.wind_along import wind_along
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, NotKnownError, number, one_of
from tvclin.base.fields import derived, record_table, spec
from tvclin.base.lines import Line, Row, Table, degrees, quantities
from tvclin.case.case import Case
from tvclin.case.turbulence import AFTER_WIND_S, TurbulenceRequest
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.gain_schedule import GainSchedule, autopilot_along, flight_autopilot
from tvclin.control.autopilot.sweep import plants_along
from tvclin.control.turbulence.covariance_history import (
    CovarianceHistory,
    turbulence_along,
    turbulence_history,
)
from tvclin.control.turbulence.driven_loop import (
    ACCELERATION,
    ANGLE_OF_ATTACK,
    DEFLECTION,
    DEFLECTION_RATE,
)
from tvclin.linear.plant import flexible_model
from tvclin.requirement.flight.flight_winds import WindOf, encountered_winds, placed_in_planes
from tvclin.requirement.required_quantity import in_wind
from tvclin.vehicle.coefficients import BOTH
from tvclin.vehicle.structure import Structure
from tvclin.vehicle.vehicle import at_pressure
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import ATTACK, FROZEN, beyond_linear

_OUTPUTS = (DEFLECTION, DEFLECTION_RATE, ACCELERATION)
"""Outputs whose standard deviation at the flight times is kept."""
_DESIGN_STEP_S = 5.0
"""Longest time between two designs of the gains [s]."""


class Travel(NamedTuple):
    """Travel of a nozzle in a whole flight [rad].

    `expected`: in a wind and turbulence. `deviation`: standard deviation over flights, from its
    variance. `of_wind`: in the wind without turbulence.
    """

    expected: float
    deviation: float
    of_wind: float


@dataclass(frozen=True, eq=False)
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
    time: float = field(metadata=spec("time", significant=5))
    deflection_rate: float | None = field(metadata=spec("angular rate"))
    angle_of_attack: float = field(metadata=spec("angle"))
    _whole: Callable[[], CovarianceHistory]

    @cached_property
    def travel(self) -> Travel | None:
        """Travel of the nozzle over the whole flight [rad]: expected, its deviation, in the wind.

        A pulse is placed where it moves the nozzle most. None where the deflection rate has no
        variance.
        """
        flown = self._whole()  # mean and standard deviation over the whole flight
        if DEFLECTION_RATE not in flown.outputs:
            return None
        of_wind = float(np.trapezoid(np.abs(flown.mean(DEFLECTION_RATE)), flown.times))
        return Travel(expected=flown.travel(), deviation=flown.travel_deviation(), of_wind=of_wind)

    @property
    @derived("angle")
    def expected_travel(self) -> float | None:
        """Expected travel of the whole flight [rad]; None where the rate has no variance."""
        return None if self.travel is None else self.travel.expected

    @property
    @derived("angle")
    def travel_deviation(self) -> float | None:
        """Standard deviation of the travel over flights [rad]; None for a rate without variance."""
        return None if self.travel is None else self.travel.deviation


@dataclass(frozen=True, eq=False)
class FlightTurbulence(Shown):
    """Autopilot in turbulence along a flight; make it with `flight_turbulence`.

    Attributes
    ----------
    request : TurbulenceRequest
        The turbulence, and the standard deviations that count.
    times : ndarray
        Flight times [s], ``(n,)``.
    rms : dict of str to ndarray
        Standard deviation at the flight times of the deflection [rad], and of its rate [rad/s] and
        acceleration [rad/s2] where they have a variance, ``(n,)``.
    winds : tuple of LargestInTurbulence
        The largest in each wind.
    history : CovarianceHistory
        Standard deviations over the flight, without a known wind.
    is_flexible : bool
        Whether the loop has the structure of the vehicle.
    sounding_wavelength : float or None
        Wavelength along the path [m] above which all levels of the soundings resolve the wind; None
        without soundings.
    """

    request: TurbulenceRequest
    times: FloatArray = field(metadata=spec("time", card=False))
    rms: Mapping[str, FloatArray]
    winds: tuple[LargestInTurbulence, ...] = field(metadata=spec(card=False))
    history: CovarianceHistory
    is_flexible: bool = False
    sounding_wavelength: float | None = field(default=None, metadata=spec("length"))

    @property
    @derived()
    def sigmas(self) -> float:
        """Number of standard deviations of the turbulence that are added to the wind's response."""
        return self.request.factor

    @property
    @derived("angle", card=False)
    def deflection_rms(self) -> FloatArray:
        """Standard deviation of the deflection at the flight times [rad], ``(n,)``."""
        return self.rms[DEFLECTION]

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
        """Standard deviation of the nozzle's travel over flights [rad], from its variance."""
        return self.history.travel_deviation() if self.travel is not None else None

    def quantile_at(self, time: float, output: str = DEFLECTION) -> float:
        """Return `sigmas` standard deviations of an output at a flight time [s]; NaN for none.

        `InputError` for an output other than deflection, deflection_rate and
        deflection_acceleration.
        """
        if one_of("output", output, _OUTPUTS) not in self.rms:
            return float("nan")
        # flight times may be in any order
        order, at = np.argsort(self.times), number("time", time, unit="s")
        return self.sigmas * float(np.interp(at, self.times[order], self.rms[output][order]))

    @property
    def notes(self) -> Iterator[str]:
        """Notes on the autopilot, and on an angle of attack beyond linear aerodynamics."""
        structure = ", with the structure of the vehicle" if self.is_flexible else ""
        yield f"turbulence is that of the linear loop{structure}, without limits"
        angle = max((x.angle_of_attack for x in self.winds), default=0.0)
        if beyond := beyond_linear(angle, ATTACK):
            yield f"in turbulence {beyond}"
        yield from self.sounding_notes

    @property
    def sounding_notes(self) -> Iterator[str]:
        """Note on wavelengths that a sounding and the turbulence both hold."""
        wavelength = self.sounding_wavelength
        if wavelength is not None and self.request.over_altitude.cutoff_wavelength is None:
            yield (
                f"the sounding holds the waves above {wavelength:.3g} m along the path, which"
                " turbulence counts once more; with this cutoff_wavelength it does not"
            )

    def tables(self) -> list[Table]:
        """Return the tables of the largest response in each wind, and of deviations and travel."""
        key, label = "flight.turbulence", self.request.label
        names = ("wind", "deflection", "time", "deflection_rate", "angle_of_attack")
        caption = f"The linear loop in each wind and turbulence, wind + {label}"
        tables = [record_table(caption, key, self.winds, *names)] if self.winds else []
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

    def duty_tables(self) -> list[Table]:
        """Return the tables of `tables`, and a table of the travel over a flight in each wind."""
        rows: list[tuple[Line, ...]] = []
        for k, wind in enumerate(self.winds):
            if wind.travel is not None:
                travel, key = wind.travel, f"flight.turbulence.{k}.travel"
                high = travel.expected + self.sigmas * travel.deviation
                sizes = {"wind": travel.of_wind, "expected": travel.expected}
                sizes |= {"deviation": travel.deviation, "high": high}
                cells = [degrees(f"{key}.{name}", size) for name, size in sizes.items()]
                rows.append(((wind.wind,), *cells))
        heads = ("wind", "wind alone", "expected", "deviation", f"with {self.sigmas:.4g} of these")
        caption = "Travel of the nozzle in a whole flight, in turbulence, from its variance [deg]"
        return [*self.tables(), *([Table(caption, heads, tuple(rows))] if rows else [])]


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
        """Raise `InputError` for a case of both planes."""
        if self.case.planes == BOTH:
            raise InputError("turbulence is answered in one plane; leave out the limit shape")

    @property
    def model(self) -> str:
        """Model of the motion; with a structure "drift-exact" in place of "drift"."""
        return flexible_model(self.structure, self.case.model)

    @property
    def structure(self) -> Structure | StructureSchedule | None:
        """Structure of the vehicle, over the flight or constant."""
        return self.schedule.structure or self.schedule.vehicle.structure

    @cached_property
    def gains(self) -> Autopilot | GainSchedule:
        """The autopilot along the flight, as specified, or else with gains that a rule designs.

        They are designed at even times of the flight and at the flight times, or at the flight
        times alone where that is not possible at the others.
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
    def _follows_altitude(self) -> bool:
        """Whether the intensity follows the altitudes of the flight."""
        return self.request.intensity is None and self.schedule.altitude is not None

    def along(
        self, wind: History | None = None, pressure: FloatArray | float = 1.0
    ) -> CovarianceHistory:
        """Return mean and standard deviation of the outputs of the loop over flight time.

        `wind`: known wind [rad], to which the mean is the response; without it the mean is zero.
        `pressure`: ratio of the dynamic pressure to the nominal one, at the times of the schedule.
        """
        turbulence = self.request.over_altitude if self._follows_altitude else self.request.at()
        vehicle, plane = at_pressure(self.schedule.vehicle, pressure), self.case.plane
        flown = replace(self.schedule, vehicle=vehicle)
        return turbulence_along(
            flown, self.gains, turbulence, wind=wind, model=self.model, plane=plane
        )

    def response(self, time: float, pressure: float, pulse: History) -> CovarianceHistory:
        """Return mean and deviation of the outputs in a pulse, frozen at a flight time [s].

        They are of the loop in turbulence; the mean is the response to the pulse [rad], from its
        onset on. `pressure`: ratio of the dynamic pressure in the pulse to the nominal one.
        """
        schedule, at = self.schedule, np.asarray(time)
        height = None
        if self._follows_altitude:
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
    signed: tuple[bool, ...],
) -> FlightTurbulence:
    """Return standard deviation, travel and peak deflection in turbulence along a flight.

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
        Winds by name, or functions from a vehicle to its wind, as `SizingRequest.winds` returns.
    signed : tuple of bool
        Whether each of the first winds may be a head or a tail wind; False for the others.

    Raises
    ------
    InputError
        For both planes, a loop without a covariance, and as `turbulence_along`.
    """
    loop = LoopOverFlight(case, request, schedule, np.asarray(times, dtype=float))
    history = loop.along()
    outputs = [output for output in _OUTPUTS if output in history.outputs]
    covariances, largest = [history], []  # over the flight; largest responses, by wind
    for j, (name, wind) in enumerate(winds.items()):
        if isinstance(wind, MeasuredWind):
            responses = {"": _measured(loop, wind)}
        else:
            responses = _pulses(loop, wind, signed=j < len(signed) and signed[j])
        for direction, response in responses.items():
            largest.append(_largest(f"{name}{in_wind(direction)}", response, request.factor))
            covariances.append(response.covariance)
    rms = {
        output: np.max(
            [np.interp(loop.times, x.times, x.deviation(output)) for x in covariances], axis=0
        )
        for output in outputs
    }
    return FlightTurbulence(
        request=request,
        times=loop.times,
        rms=rms,
        winds=tuple(largest),
        history=history,
        is_flexible=loop.structure is not None,
    )


class _Responses(NamedTuple):
    """Covariance along the flight, and responses to a wind.

    `covariance`: standard deviations along the flight, without the wind for a pulse. `means`: pairs
    of the flight time [s] at which a response begins, and the response from then on. `whole`:
    function that returns mean and standard deviation of the whole flight with the wind.
    """

    covariance: CovarianceHistory
    means: list[tuple[float, CovarianceHistory]]
    whole: Callable[[], CovarianceHistory]


def _measured(loop: LoopOverFlight, wind: MeasuredWind) -> _Responses:
    """Return standard deviations and responses of a loop in a sounding.

    `wind`: the sounding's wind. One response for each flight time at which its gust is placed, or
    a single one without a gust. The dynamic pressure follows the wind, unless it is frozen.
    """
    sign = FROZEN if loop.case.sign == FROZEN else None

    def flown(gust_time: float | None) -> CovarianceHistory:
        """Return mean and deviation of the outputs in the sounding, at the times of the flight.

        `gust_time`: flight time [s] at which its gust is placed; None for no gust.
        """
        along = wind_along(loop.schedule, wind, loop.case.plane, sign, gust_time)
        return loop.along(along.history, along.pressure(loop.schedule.times))

    times: list[float | None] = [None] if wind.gust is None else loop.times.tolist()
    responses = []
    for time in times:
        with nullcontext() if time is None else suppress(NotKnownError):  # no such gust there
            responses.append(flown(time))
    if not responses:
        raise InputError("the gust is not known at any flight time")
    first, *_ = responses
    means = [(0.0, response) for response in responses]  # offset zero: all are in flight time
    # every response is of the whole flight, with the same standard deviations
    return _Responses(covariance=first, means=means, whole=lambda: first)


_PulseRow: TypeAlias = tuple[float, float, History, CovarianceHistory]
"""Flight time [s], q/q_n (dynamic pressure over the nominal one), a pulse, and the response."""


def _pulses(loop: LoopOverFlight, wind: WindOf, *, signed: bool) -> dict[str, _Responses]:
    """Return by direction the responses of the loop to a pulse, and its covariance in turbulence.

    `loop`: autopilot and vehicle over the flight. `wind`: a pulse, or a function from a vehicle to
    it. `signed`: whether both a head and a tail wind are computed, where the case does not say
    which. Flight times at which the pulse is not known or zero are omitted.
    """
    case, schedule = loop.case, loop.schedule
    rows: dict[str, list[_PulseRow]] = {}  # by direction, at all flight times
    for time in loop.times.tolist():
        vehicle = schedule.at(time)
        placed = placed_in_planes((case.plane,), wind, vehicle, time)
        in_plane = placed[case.plane]
        if not in_plane.known or in_plane.calm:
            continue
        at_peaks = encountered_winds(vehicle, in_plane, placed, case.sign, signed=signed)
        for direction, at_peak, pulse in at_peaks:  # vehicle at the pressure of the wind's peak
            # the normal force per angle is proportional to the dynamic pressure
            at_peak_slope, slope = (
                float(np.asarray(x.normal_force_slope)) for x in (at_peak, vehicle)
            )
            ratio = at_peak_slope / slope
            row = time, ratio, pulse, loop.response(time, ratio, pulse)
            rows.setdefault(direction, []).append(row)
    return {direction: _of_pulse(loop, of_times) for direction, of_times in rows.items()}


def _of_pulse(loop: LoopOverFlight, rows: list[_PulseRow]) -> _Responses:
    """Return the responses of a loop over the flight to a pulse of one direction.

    `rows`: by flight time. The whole flight has their dynamic pressures, and the pulse with the
    most nozzle travel.
    """
    times, ratios, pulses, responses = zip(*rows, strict=True)
    order = np.argsort(times)
    # constant beyond the flight times
    pressure = np.interp(loop.schedule.times, np.take(times, order), np.take(ratios, order))
    # nozzle travel [rad]; `mean`: deflection over time in the pulse, without turbulence
    travels = [np.abs(np.diff(response.mean())).sum() for response in responses]
    worst = pulses[int(np.argmax(travels))]
    onsets = [float(pulse.onset) for pulse in pulses]
    return _Responses(
        covariance=loop.along(wind=None, pressure=pressure),
        means=list(zip(onsets, responses, strict=True)),
        whole=lambda: loop.along(worst, pressure),
    )


def _largest(name: str, responses: _Responses, k: float) -> LargestInTurbulence:
    """Return the largest value of each output over the responses to a wind in turbulence.

    The value is the size of a mean response plus `k` standard deviations at the same flight time,
    which are taken constant beyond the ends of the flight. `name`: name of the wind.
    """
    covariance = responses.covariance
    times = np.concatenate([mean.times + start for start, mean in responses.means])

    def sizes(output: str) -> FloatArray:
        """Return |mean response| + k standard deviations of an output at `times` [SI], ``(n,)``."""
        means = np.concatenate([mean.mean(output) for _, mean in responses.means])
        deviation = np.interp(times, covariance.times, covariance.deviation(output))
        return np.abs(means) + k * deviation

    deflection, has_rate = sizes(DEFLECTION), DEFLECTION_RATE in covariance.outputs
    return LargestInTurbulence(
        wind=name,
        deflection=float(deflection.max()),
        time=float(times[np.argmax(deflection)]),
        deflection_rate=float(sizes(DEFLECTION_RATE).max()) if has_rate else None,
        angle_of_attack=float(sizes(ANGLE_OF_ATTACK).max()),
        _whole=responses.whole,  # a function: the whole flight is computed only for the travel
    )
