"""Specification of the sizing of a flight: schedule, winds, offsets, dispersions and reserve.

Model, planes, limit, limit shape and the first pulse belong to the case.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.ascent.measured_wind import (
    GustOf,
    GustOfSpeed,
    SoundingGaps,
    fly_through,
    gust_at,
    gust_words,
)
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.fields import checked, file_table, flag, quantity, text, word
from tvclin.base.fields import count as integer
from tvclin.base.lines import Line
from tvclin.base.lines import number as number_line
from tvclin.base.package_warnings import ImplausibleInput
from tvclin.case.case import Case
from tvclin.case.turbulence import TurbulenceRequest
from tvclin.control.autopilot.design_rules import AutopilotDesign
from tvclin.control.laws.registry import LAWS
from tvclin.kernels.choice import repeated
from tvclin.requirement.flight.controllability import ControllabilityRatio, controllability_ratio
from tvclin.requirement.flight.flight_requirement import (
    FlightMode,
    base_requirement,
    with_directions,
)
from tvclin.requirement.flight.flight_turbulence import FlightTurbulence, flight_turbulence
from tvclin.requirement.flight.flight_winds import WindOf
from tvclin.requirement.flight.refinement import neighbouring_times, refined_sizing
from tvclin.requirement.flight.size import WORDS, size
from tvclin.requirement.flight.sizing import Sizing
from tvclin.requirement.flight.total import DeflectionTotal, totals_over_flight, worst_total
from tvclin.requirement.required_quantity import NO_FORECAST, TRIM, Requirement, requirement_among
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.vehicle.vehicle import Vehicle, vehicle_warnings
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.shaped import ShapedWind, component_in, refuse_gust_time
from tvclin.winds.soundings.profile import WindProfile
from tvclin.winds.wind_angles import (
    CROSS,
    DIRECTIONS,
    FROZEN,
    MAX_LINEAR_ANGLE,
    SIGNS,
    checked_linear,
)


@dataclass(frozen=True, eq=False)
class SoundingRequest:
    """A wind over height, through which the flight goes.

    Attributes
    ----------
    profile : WindProfile
        The wind; see `read_sounding`.
    azimuth : float
        Direction of flight [rad], from north, clockwise.
    bias : WindProfile, optional
        The mean wind for which the flight path is biased; see `fly_through`.
    """

    profile: WindProfile
    azimuth: float
    bias: WindProfile | None = None

    def __post_init__(self) -> None:
        """Check the fields; `InputError` for another type, and a direction out of range."""
        errors.instance("profile", self.profile, WindProfile, "see read_sounding")
        object.__setattr__(self, "azimuth", errors.bearing("azimuth", self.azimuth))
        if self.bias is not None:
            errors.instance("bias", self.bias, WindProfile, "see read_sounding")


_MIN_STEP_FRACTION = 1e-9
"""Minimum distance of even flight times from the first and the last, as a fraction of a step."""
EVERY_S = 5.0
"""Default interval between flight times [s]."""
_MAX_FLIGHT_TIMES = 10_000
"""Largest number of flight times; more indicate a step in a wrong unit."""
MAX_RATE_NOISE = 0.1
"""Largest noise of a rate gyro [rad/s], rms."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SizingRequest:
    """Options of the sizing of a flight, other than its case.

    Attributes
    ----------
    schedule : FlightSchedule
        The flight.
    source : str
        Name of the vehicle or file of the flight, for messages; empty without a name.
    another : str
        Name of the study's vehicle, where the flight is of another or has another number, named.
    pulse : bool
        Whether the wind of the case counts, with its peak at each flight time.
    others : tuple of ShapedWind
        Further pulses with their peak at each flight time.
    peak_speed : float, optional
        Peak wind speed of the pulses [m/s]; each flight time has its angle from eq (B1e).
    soundings : dict of str to SoundingRequest
        Winds over height, by name. The gust of the case is on top of each wind: of a pulse at its
        time, or the worst time for the dead band that counts, of a sounding about each flight time.
    gust_speed : float, optional
        Wind speed [m/s] at the peak of the gust of pulses, in place of its angle.
    window : float, optional
        Length [s] of the interval of a sounding that counts, about each flight time.
    start : float, optional
        First flight time [s].
    stop : float, optional
        Last flight time [s].
    every : float
        Time between flight times [s]; the last step may be shorter.
    dead_bands : tuple of float
        Dead band K, from 0 to 1; may be given several times.
    law : str
        Column 'no forecast': bound, the lower bound of laws that must survive a stop of the wind at
        any instant, or flown, what the recoverable-attitude law requires in flight (slow).
    varying : bool, optional
        Whether parameters vary during the wind, or are frozen at each flight time.
    count : str, optional
        Column that enters the total for the wind: 'K = 1', trim, 'K = 1, varying', ...
    dispersion : float
        Increase by dispersions, as a fraction of the requirement of the wind.
    thrust_offset : float
        Angle between the thrust and the nozzle's axis [rad].
    gravity_offset : float
        Distance of the centre of gravity from the axis [m].
    reserve : float
        Fraction of the limit to keep unused, from 0 to 1.
    duty_law : str, optional
        Law that is flown for the duty of the nozzle, see `flight_duty`; on the page too.
    rate_noise : float
        Noise of the rate gyro [rad/s] for the duty, rms by sample: the cause of most travel.
    noise_seed : int
        Seed of that noise.
    steady_window : float
        Length [s] over which the steady rate of the duty is a mean.
    scheduled_design : AutopilotDesign, optional
        Specification of the autopilot over the flight, where it varies; that of the case is then
        that of the time of its vehicle.

    Raises
    ------
    InputError
        For numbers out of range, unknown names, and without any wind.
    """

    schedule: FlightSchedule
    source: str = text("", key=None, option=None)
    another: str = text("", key=None, option=None)
    pulse: bool = flag(True, key=None, option=None)
    others: tuple[ShapedWind, ...] = ()
    peak_speed: float | None = quantity("speed", None, errors.nonzero, option=None)
    gust_speed: float | None = quantity("speed", None, errors.nonzero, key=None, option=None)
    soundings: Mapping[str, SoundingRequest] = field(default_factory=dict)
    window: float | None = quantity("time", None, errors.positive, key=None, option=None)
    start: float | None = quantity(
        "time", None, key="from", option="--from", shown="the first with all pulses in the schedule"
    )
    stop: float | None = quantity(
        "time", None, key="to", option="--to", shown="the last with all pulses in the schedule"
    )
    every: float = quantity("time", EVERY_S, errors.positive)
    dead_bands: tuple[float, ...] = quantity(
        "number", (1.0, 0.5), errors.between(0.0, 1.0), many=True, option="--dead-band"
    )
    law: str = word(WORDS["law"], "bound")
    varying: bool | None = flag(
        None, option="--varying/--frozen", shown="varying where they can be followed"
    )
    count: str | None = text(
        None, shown="the largest dead band, varying, in the wind that needs more"
    )
    dispersion: float = quantity("percent", 0.0, errors.nonnegative)
    thrust_offset: float = quantity("angle", 0.0, errors.small_angle("an angle"))
    gravity_offset: float = quantity("length", 0.0)
    reserve: float = quantity("percent", 0.0, errors.nonnegative)
    duty_law: str | None = word(LAWS, None, option=None)
    rate_noise: float = quantity(
        "angular rate", 0.0, errors.between(0.0, MAX_RATE_NOISE), option=None
    )
    noise_seed: int = integer(0, option=None)
    steady_window: float = quantity("time", 0.5, errors.positive, option=None)
    scheduled_design: AutopilotDesign | None = None

    def __post_init__(self) -> None:
        """Check the fields; `InputError` as the class says."""
        errors.instance("schedule", self.schedule, FlightSchedule, "see load_schedule")
        object.__setattr__(
            self, "others", errors.each("others", self.others, ShapedWind, "of one shape")
        )
        errors.instance("soundings", self.soundings, Mapping, "of names to SoundingRequest")
        errors.each(
            "soundings", tuple(self.soundings.values()), SoundingRequest, "with their azimuth"
        )
        checked(self)
        if self.scheduled_design is not None:
            errors.instance("scheduled_design", self.scheduled_design, AutopilotDesign, "of a file")
        if not self.pulse and not self.others and not self.soundings:
            raise errors.InputError("a sizing needs a wind: a pulse or a sounding")

    def counted(self, sizing: Sizing, sign: str | None = None) -> Requirement:
        """Return the requirement that enters the total for the wind, unless `count` names it.

        It is of the largest dead band, with varying parameters if known wherever frozen ones are,
        in a wind of direction `sign`: by default the worst; `FROZEN` is the nominal pressure.
        """
        if self.count is not None:
            return requirement_among("count", self.count, sizing.required)
        errors.instance("sizing", sizing, Sizing, "see sizing()")
        if sign is not None:
            errors.one_of("sign", sign, (*SIGNS, FROZEN))
        base, worst = base_requirement(sizing), sizing.worst
        if sign == FROZEN:
            return base
        directions = DIRECTIONS if sign is None else (sign, CROSS)
        by_direction = (replace(base, direction=direction) for direction in directions)
        available = [requirement for requirement in by_direction if requirement in worst]
        return max(available, key=lambda requirement: worst[requirement].deflection, default=base)

    def pulses(self, case: Case) -> tuple[ShapedWind, ...]:
        """Return the wind of the case, if `pulse`, then `others`; each has the gust of the case."""
        errors.instance("case", case, Case, "of a wind and a nozzle")
        if not self.pulse and not self.others:
            return ()
        case_wind: Any = case.wind
        errors.instance("wind of the case", case_wind, ShapedWind, "of one shape")
        return tuple(
            replace(pulse, gust=case_wind.gust, gust_at=case_wind.gust_at)
            for pulse in (*((case_wind,) if self.pulse else ()), *self.others)
        )

    def times(self, case: Case) -> NDArray[Any]:
        """Return flight times [s], ``(n,)``: `start`, `stop`, and one `every` so many seconds.

        By default the longest pulse, with its peak at the first or last, lies in the schedule.
        `InputError` for ends not in order, and more than 10000 flight times.
        """
        half = 0.5 * max((pulse.duration for pulse in self.pulses(case)), default=0.0)
        first, last = self.schedule.span
        if last - first < 2.0 * half:
            half = 0.0
        low, high = first + half, last - half
        if self.start is not None:
            low = errors.number("the first flight time", self.start)
        if self.stop is not None:
            high = errors.number("the last one", self.stop)
        if high < low:
            raise errors.InputError(
                "flight times are those between start and stop, which must be in this order; got"
                f" {low:g} to {high:g} s"
            )
        if (high - low) / self.every > _MAX_FLIGHT_TIMES:
            raise errors.InputError(
                f"there may be at most {_MAX_FLIGHT_TIMES} flight times; got one every"
                f" {self.every:g} s"
            )
        # multiples of the step, or steps from the first time that is given
        even = np.ceil(low / self.every) * self.every if self.start is None else low
        between = np.arange(even, high, self.every)
        # those that are not the first or the last but for rounding
        distinct = np.abs(between - [[low], [high]]).min(axis=0) > _MIN_STEP_FRACTION * self.every
        last_time = [high] if high > low else []
        return np.concatenate([[low], between[distinct], last_time])

    def winds(self, case: Case) -> dict[str, WindOf]:
        """Return the winds by name: histories, or functions from a vehicle to its wind (`WindOf`).

        Of a sounding it is the wind angle of attack [rad] over flight time, in the plane of the
        case, or in both. Same exceptions as `fly_through`, with the name of the sounding;
        `InputError` also for the sign of a pulse with a direction, and a gust with a time without
        a pulse.
        """
        pulses, gust, speed = self.pulses(case), self._gust(case), self.peak_speed
        if case.sign in SIGNS and any(pulse.heading is not None for pulse in pulses):
            raise errors.InputError(
                "a wind with a direction is a head or a tail wind by that: leave sign"
            )
        on_top = "" if gust is None else f", {gust_words(gust)}"
        if self.soundings and not pulses:
            refuse_gust_time(getattr(case.wind, "gust_at", None), "at each flight time")
        winds: dict[str, WindOf] = {}
        for pulse in pulses:
            strength = f"{np.degrees(pulse.peak):.6g} deg" if speed is None else f"{speed:g} m/s"
            name = f"{pulse.shape} wind of {strength}, {pulse.duration:g} s{on_top}"
            winds[name] = partial(self._encountered, case, pulse)
        for name, sounding in self.soundings.items():
            with errors.naming(name):
                winds[f"{name}{on_top}"] = fly_through(
                    sounding.profile,
                    self.schedule,
                    azimuth=sounding.azimuth,
                    plane=case.planes,
                    window=self.window,
                    gust=gust,
                    pressure=case.sign != FROZEN,
                    bias=sounding.bias,
                )
        return winds

    def _gust(self, case: Case) -> GustOf | None:
        """Return the gust of a case [rad] over time, None without one.

        By a gust speed it is a function from a vehicle to its gust.
        """
        gust: GustOf | None = getattr(case.wind, "gust", None)
        if self.gust_speed is None or not isinstance(gust, History):
            return gust
        return GustOfSpeed(gust, self.gust_speed, case.planes)

    def _case_of(self, case: Case, pulse: ShapedWind, vehicle: Vehicle) -> Case:
        """Return the case of a vehicle in a pulse, whose speeds become angles for this vehicle.

        `case`: model, plane, nozzle, autopilot and sign of the result.
        """
        if self.peak_speed is not None:
            pulse = pulse.with_speed(self.peak_speed, vehicle, case.plane)
        if self.gust_speed is not None:
            pulse = pulse.with_gust_speed(self.gust_speed, vehicle, case.plane)
        return Case(
            vehicle=vehicle,
            model=case.model,
            plane=case.plane,
            wind=pulse,
            nozzle=case.nozzle,
            design=case.design,
            sign=case.sign,
        )

    def _encountered(self, case: Case, pulse: ShapedWind, vehicle: Vehicle) -> History | PlaneWind:
        """Return the wind angle [rad] of a vehicle in a pulse, in the plane of a case or in both.

        A gust is at the worst time for the largest K. `NotKnownError` beyond linear aerodynamics.
        """
        placed = self._case_of(case, pulse, vehicle).wind_at(float(max(self.dead_bands)))
        checked_linear(placed.max_angle)
        attitude = float(np.asarray(vehicle.attitude))
        if case.planes != BOTH:
            return placed.in_plane(case.plane, attitude).history({})  # nothing is dispersed
        peaks = placed.peaks(attitude)  # the angle in each plane [rad]
        return PlaneWind(**{plane: component_in(placed, peaks, plane) for plane in PLANES})

    def at(self, case: Case, time: float, pulse: ShapedWind) -> Case:
        """Return the case of a flight time [s], at the peak of a pulse.

        `InputError` for a time outside the schedule, and a wind without a component in the plane.
        """
        errors.instance("case", case, Case, "of a wind and a nozzle")
        errors.instance("pulse", pulse, ShapedWind, "one of pulses")
        vehicle = self.schedule.at(errors.number("time", time, unit="s"))
        return self._case_of(case, pulse, vehicle)

    def sizing(self, case: Case, progress: Callable[[int, int], None] | None = None) -> Sizing:
        """Return required deflections by flight time and wind; same exceptions as `size`.

        For pulses (triangles and other shaped winds, unlike soundings) they include the largest
        dead band in head and tail winds: it requires most. `progress`: called with the numbers of
        finished and of all requirements.
        """
        return self._sizing_at(case, self.times(case), progress)

    def _sizing_at(
        self, case: Case, times: FloatArray, progress: Callable[[int, int], None] | None = None
    ) -> Sizing:
        """Return the sizing at flight times [s], pulses in their possible directions.

        Gaps of the soundings are in words in its `gaps`. `progress`: called with the numbers of
        finished and of all requirements. `_mode`: flight along which parameters vary, if they do.
        """
        result = size(
            self.schedule,
            self.winds(case),
            times=times,
            dead_bands=self.dead_bands,
            model=case.model,
            plane=case.planes,
            law=self.law,
            varying=self.varying,
            limit_shape=case.nozzle.limit_shape or "round",
            progress=progress,
        )
        if self.soundings and any(requirement.varying for requirement in result.required):
            air = "nominal" if case.sign == FROZEN else "encountered"
            names = ", ".join(self.soundings)
            note = f"each K, varying counts the {air} dynamic pressure in {names}"
            # gaps of soundings that the flight times encounter, with a window within half of it
            half, span = 0.5 * (self.window or 0.0), (float(times.min()), float(times.max()))
            words = {
                name: SoundingGaps.of(x.profile, self.schedule).encountered(*span, half)
                for name, x in self.soundings.items()
            }
            gaps = [f"{x}, in a gap of {k} ({cure})" for k, (x, cure) in words.items() if x]
            result = replace(result, notes=(*result.notes, note), gaps=tuple(gaps))
        pulses = self.pulses(case)

        def at(time: float, k: int) -> Case:
            """Return the case of a flight time [s] in pulse number k."""
            return self.at(case, time, pulses[k])

        with repeated(result.known.size):  # similar runs: decide between compiled and plain code
            return with_directions(result, len(pulses), at, self._mode(case, result))

    def _mode(self, case: Case, sizing: Sizing) -> FlightMode | None:
        """Return the unstable mode of a case over its schedule and the winds of a sizing.

        None with both planes or frozen parameters.
        """
        if case.nozzle.limit_shape is not None or not base_requirement(sizing).varying:
            return None
        first, last = self.schedule.span
        span = np.nanmin([first, *sizing.begins.flat]), np.nanmax([last, *sizing.ends.flat])
        return FlightMode(self.schedule, case.model, case.plane, (float(span[0]), float(span[1])))

    def turbulence(
        self, case: Case, turbulence: TurbulenceRequest | None
    ) -> FlightTurbulence | str | None:
        """Return the result of `flight_turbulence` for a case in the winds of the request.

        If it is not known, the reason in words instead; None if `turbulence` is None.
        """
        errors.instance("case", case, Case, "of a wind and a nozzle")
        if turbulence is None:
            return None
        errors.instance(
            "turbulence", turbulence, TurbulenceRequest, "of an intensity or a severity"
        )
        signed = tuple(pulse.heading is None for pulse in self.pulses(case))  # head or tail wind
        winds, times = self.winds(case), self.times(case)
        try:
            # the autopilot over the flight, where the request specifies one
            flown = replace(case, design=self.scheduled_design or case.design)
            along_flight = flight_turbulence(flown, turbulence, self.schedule, times, winds, signed)
            return replace(along_flight, sounding_wavelength=self._sounding_wavelength)
        except errors.InputError as error:
            return str(error)

    @property
    def _sounding_wavelength(self) -> float | None:
        """Wavelength along the path [m] above which all soundings resolve the wind, or None."""
        schedule, widest = self.schedule, []
        for sounding in self.soundings.values():
            levels = sounding.profile.height
            inside = (levels >= schedule.height.min()) & (levels <= schedule.height.max())
            times = np.interp(levels[inside], schedule.height, schedule.times)
            speeds = np.interp(0.5 * (times[1:] + times[:-1]), schedule.times, schedule.speed)
            # levels that are flown past within d of each other resolve waves of 2 d
            widest.append(2.0 * float((speeds * np.diff(times)).max(initial=0.0)))
        return max(widest, default=None)

    def total(
        self, case: Case, sizing: Sizing, turbulence: FlightTurbulence | str | None = None
    ) -> DeflectionTotal:
        """Return the largest total over the flight; same exceptions as `worst_total`.

        A total is the required deflection with all that adds to it: turbulence, dispersion, offsets
        and reserve. Flight times between the sizing's count too, about the largest totals.
        `sizing`: result of `sizing`. `turbulence`: result of `turbulence`; a text, the reason for
        which that is not known, makes the total unknown.
        """
        errors.instance("sizing", sizing, Sizing, "see sizing()")
        if sizing.winds != tuple(self.winds(case)):
            raise errors.InputError(
                "the sizing must be of the winds of this request, as sizing() returns it; got"
                f" {', '.join(sizing.winds)}"
            )
        options: dict[str, Any] = {
            "dispersion": self.dispersion,
            "thrust_offset": self.thrust_offset,
            "gravity_offset": self.gravity_offset,
            "reserve": self.reserve,
            "limit": case.nozzle.limit,
            "rate_limit": case.nozzle.rate_limit,
            "turbulence": turbulence,
        }

        def totals_of(refined: Sizing) -> dict[float, float]:
            """Return the totals [rad] of a sizing by its flight times [s], with all `options`."""
            counted = self.counted(refined, case.sign)  # requirement of the wind, worse direction
            totals = totals_over_flight(refined, counted, **options)
            return {
                x.time: x.total for x in totals if x.time is not None and x.time in refined.times
            }

        counted = self.counted(sizing, case.sign)
        # further flight times have only what enters the total, to save time: the largest K, and
        # the bound, which takes no flights, unless the limit without a forecast counts
        request = replace(
            self,
            dead_bands=tuple({float(max(self.dead_bands)), counted.dead_band}),
            law=self.law if counted == NO_FORECAST else "bound",
        )
        refined = refined_sizing(sizing, partial(request._sizing_at, case), totals_of)
        worst = worst_total(refined, self.counted(refined, case.sign), **options)
        return replace(worst, listed=neighbouring_times(worst.time, sizing.times, refined.times))

    def ratio(self, case: Case, sizing: Sizing) -> ControllabilityRatio | None:
        """Return the limit of a case over trim and all that adds up, at the worst time of a sizing.

        Trim is B times the wind angle, B being the ratio of trim deflection to angle of attack;
        gust, thrust offset and gravity offset add to it. None without a limit or any known trim.
        """
        errors.instance("case", case, Case, "of a wind and a nozzle")
        errors.instance("sizing", sizing, Sizing, "see sizing()")
        if case.nozzle.limit is None or np.all(np.isnan(sizing.required[TRIM])):
            return None
        gust = self._gust(case)

        def peak(vehicle: Vehicle) -> float:
            """Return the peak [rad] of the gust that a vehicle of the flight encounters.

            The largest angle of linear aerodynamics where it is beyond that, and not known.
            """
            try:
                return 0.0 if gust is None else float(gust_at(gust, vehicle).peak)
            except errors.NotKnownError:
                return MAX_LINEAR_ANGLE

        return controllability_ratio(
            sizing,
            case.nozzle.limit,
            gust=[peak(self.schedule.at(t)) for t in sizing.times.tolist()],
            thrust_offset=self.thrust_offset,
            gravity_offset=self.gravity_offset,
        )

    @property
    def warnings(self) -> list[ImplausibleInput]:
        """Warnings on implausible numbers of the flight, and if it is of `another` vehicle."""
        noted = (note for note in self.schedule.notes if isinstance(note, ImplausibleInput))
        warnings = [*noted, *vehicle_warnings(self.schedule.vehicle)]
        if self.another:
            words = (
                f"the flight is of {self.source}, not of the study's vehicle, {self.another}; give"
                " its flight in [schedule], or omit [schedule] and [size]"
            )
            warnings.append(ImplausibleInput(words))
        return warnings

    def sounding_lines(self) -> Iterator[Line]:
        """Yield station, date and direction of flight of each sounding, as a sentence."""
        for name, sounding in self.soundings.items():
            source = sounding.profile.source or "given without a source"
            azimuth = number_line(f"flight.azimuth.{name}", np.degrees(sounding.azimuth), 1, "deg")
            name_and_source = source if source.startswith(name) else f"{name}: {source}"
            yield (f"Measured wind {name_and_source}; the flight goes towards ", *azimuth, ".")

    @property
    def notes(self) -> list[str]:
        """Notes on the flight, except of `warnings`, and on soundings."""
        of_flight = [x for x in self.schedule.notes if not isinstance(x, ImplausibleInput)]
        if not self.soundings:
            return of_flight
        scope = (
            "" if self.window is None else f" within {0.5 * self.window:g} s of each flight time"
        )
        return [
            *of_flight,
            f"in {', '.join(self.soundings)} only what blows{scope} to the side on which it is"
            " largest counts",
            *(
                f"{k}: {note}"
                for k, sounding in self.soundings.items()
                for note in sounding.profile.notes_along(self.schedule)
            ),
        ]


SIZE_TABLE = file_table("[size]", SizingRequest)
