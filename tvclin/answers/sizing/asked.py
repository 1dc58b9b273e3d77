"""What is asked of a whole flight: its schedule, its winds, and what else the nozzle has to do."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.answers.planes import BOTH
from tvclin.answers.sizing.measured import fly_through
from tvclin.answers.sizing.placing import WindOf
from tvclin.answers.sizing.record import VARYING, Sizing
from tvclin.answers.sizing.schedule import FlightSchedule
from tvclin.answers.sizing.size import WORDS, size
from tvclin.answers.sizing.total import DeflectionTotal, worst_total
from tvclin.base.errors import (
    InputError,
    bearing,
    each,
    finite,
    flag,
    instance,
    naming,
    nonnegative,
    number,
    one_of,
    positive,
    small_angle,
    text,
    within,
)
from tvclin.base.tables import Table
from tvclin.boundary.stops import Stop, stop_of
from tvclin.linear.models import USUAL_MODEL
from tvclin.vehicle.coefficients import PLANES
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.gusts import checked_gust
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.shaped import PULSES, ShapedWind, part_in
from tvclin.winds.soundings.profile import WindProfile
from tvclin.winds.speed import angle_in_plane, angles_from_speed

SIZE_TABLE = Table(
    "[size]",
    {
        **dict.fromkeys(("start", "stop", "every", "window"), "time"),
        "peak_speed": "speed",
        "dispersion": "percent",
        "thrust_offset": "angle",
        "gravity_offset": "length",
        "reserve": "percent",
    },
    words=("model", "plane", "law", "varying", "count", "nozzle_stop"),
    lists=("dead_bands",),
)
_APART = 1e-9
"""Steps by which even flight times must differ from the first and the last."""
_MOST_TIMES = 10_000
"""Flight times; more are a step that was given in the wrong unit."""


@dataclass(frozen=True, eq=False)
class SoundingAsked:
    """A wind over height that the flight goes through.

    Attributes
    ----------
    profile : WindProfile
        The wind; see `read_sounding`.
    azimuth : float
        Direction of flight [rad], from north, clockwise.
    """

    profile: WindProfile
    azimuth: float

    def __post_init__(self) -> None:
        instance("profile", self.profile, WindProfile, "see read_sounding")
        object.__setattr__(self, "azimuth", bearing("azimuth", self.azimuth))


@dataclass(frozen=True, kw_only=True, eq=False)
class SizingAsked:
    """Everything that the sizing of a flight depends on.

    Attributes
    ----------
    schedule : FlightSchedule
        The flight.
    source : str
        The vehicle or file whose flight it is, as messages call it; empty where it has no name.
    another : str
        The study's vehicle, as messages call it, where the flight is that of another vehicle.
    pulses : tuple of ShapedWind
        Winds whose peak meets each flight time.
    peak_speed : float, optional
        Wind speed [m/s] at the peak of the pulses, in place of their angle: the vehicle meets it at
        the angle of its flight time, by eq (B1e).
    soundings : dict of str to SoundingAsked
        Winds over height, by name.
    gust : History, optional
        On top of each wind: of a pulse in its time, of a sounding about each flight time.
    window : float, optional
        As of `MeasuredWind` [s].
    start, stop : float, optional
        First and last flight time [s]; as far as the schedule covers the whole of the pulses.
    every : float
        Time between flight times [s]; the last step may be shorter.
    dead_bands : tuple of float
        K of the report's control.
    model, plane, law, varying
        As of `size`; for both planes each pulse needs a heading.
    nozzle_stop : Stop or str
        What the nozzle can do in both planes, as the `stop` of `size`.
    count : str, optional
        The requirement that counts as the wind's; where it is not given the largest dead band, with
        varying parameters if these are asked for and all winds are soundings.
    dispersion, thrust_offset, gravity_offset, reserve, limit
        As of `worst_total`.

    Raises
    ------
    InputError
        For numbers out of range, unknown names, and without any wind.
    """

    schedule: FlightSchedule
    source: str = ""
    another: str = ""
    pulses: tuple[ShapedWind, ...] = ()
    peak_speed: float | None = None
    soundings: Mapping[str, SoundingAsked] = field(default_factory=dict)
    gust: History | None = None
    window: float | None = None
    start: float | None = None
    stop: float | None = None
    every: float = 5.0
    dead_bands: tuple[float, ...] = (1.0, 0.5)
    model: str = USUAL_MODEL
    plane: str = "pitch"
    law: str = "bound"
    varying: bool = False
    count: str | None = None
    dispersion: float = 0.0
    thrust_offset: float = 0.0
    gravity_offset: float = 0.0
    reserve: float = 0.0
    limit: float | None = None
    nozzle_stop: Stop | str = "round"

    def __post_init__(self) -> None:
        instance("schedule", self.schedule, FlightSchedule, "see load_schedule")
        object.__setattr__(self, "pulses", each("pulses", self.pulses, ShapedWind, "of one shape"))
        instance("soundings", self.soundings, Mapping, "of names to SoundingAsked")
        each("soundings", tuple(self.soundings.values()), SoundingAsked, "with their azimuth")
        checked_gust(self.gust)
        self._check_words()
        if not self.pulses and not self.soundings:
            raise InputError("a sizing needs a wind: a pulse or a sounding")
        for pulse in self.pulses:
            one_of("shape of a pulse", pulse.shape, PULSES)
        if not finite("dead_bands", self.dead_bands).size:
            raise InputError("dead_bands must hold one number or more")
        within("dead_bands", self.dead_bands, 0.0, 1.0)
        object.__setattr__(self, "every", number("every", self.every, positive, "s"))
        if self.window is not None:
            number("window", self.window, positive, "s")
        for name in ("dispersion", "reserve"):
            number(name, getattr(self, name), nonnegative)
        for name in ("peak_speed", "start", "stop", "thrust_offset", "gravity_offset", "limit"):
            check = small_angle("an angle") if name in ("thrust_offset", "limit") else finite
            if getattr(self, name) is not None:
                number(name, getattr(self, name), check)

    def _check_words(self) -> None:
        for name in ("source", "another"):
            text(name, getattr(self, name))
        if self.count is not None:
            text("count", self.count)
        for name, words in WORDS.items():
            one_of(name, getattr(self, name), words)
        flag("varying", self.varying)
        stop_of(self.nozzle_stop)

    @property
    def counted(self) -> str:
        """The requirement that counts as the wind's.

        In soundings alone, with varying parameters, that of the vehicle that met them.
        """
        met = self.varying and self.soundings and not self.pulses
        return self.count or f"K = {max(self.dead_bands):g}{VARYING if met else ''}"

    @property
    def times(self) -> NDArray[Any]:
        """Flight times [s], the first and the last and even ones between; see `start`.

        Raises
        ------
        InputError
            For ends not in order, and more than 10000 flight times.
        """
        half = 0.5 * max((pulse.duration for pulse in self.pulses), default=0.0)
        first, last = self.schedule.span
        if last - first < 2.0 * half:
            half = 0.0
        low = first + half if self.start is None else number("the first flight time", self.start)
        high = last - half if self.stop is None else number("the last one", self.stop)
        if high < low:
            raise InputError(
                f"the last flight time must not be before the first; got {low:g} to {high:g} s"
            )
        if (high - low) / self.every > _MOST_TIMES:
            raise InputError(
                f"there may be at most {_MOST_TIMES} flight times; got one every {self.every:g} s"
            )
        even = np.ceil(low / self.every) * self.every if self.start is None else low
        between = np.arange(even, high, self.every)
        apart = np.abs(between - [[low], [high]]).min(axis=0) > _APART * self.every
        return np.concatenate([[low], between[apart], [high][: int(high > low)]])

    @property
    def winds(self) -> dict[str, WindOf]:
        """The winds by name, as `size` takes them; soundings are in flight time.

        Raises
        ------
        InputError
            As `fly_through`, with the name of the sounding.
        """
        return {self._pulse_name(pulse): self._met(pulse) for pulse in self.pulses} | {
            name: self._flown(name, sounding) for name, sounding in self.soundings.items()
        }

    def sizing(self, progress: Callable[[int, int], None] | None = None) -> Sizing:
        """Return the sizing, and tell how it goes on; raise `InputError` as `size`."""
        return size(
            self.schedule,
            self.winds,
            times=self.times,
            dead_bands=self.dead_bands,
            model=self.model,
            plane=self.plane,
            law=self.law,
            varying=self.varying,
            stop=self.nozzle_stop,
            progress=progress,
        )

    def total(self, found: Sizing) -> DeflectionTotal:
        """Return the worst total of a sizing; raise `InputError` as `worst_total`."""
        instance("found", found, Sizing, "see sizing()")
        return worst_total(
            found,
            one_of("count", self.counted, found.required),
            dispersion=self.dispersion,
            thrust_offset=self.thrust_offset,
            gravity_offset=self.gravity_offset,
            reserve=self.reserve,
            limit=self.limit,
        )

    @property
    def warnings(self) -> list[str]:
        """Why the flight may not be what was meant; nothing where it is the study's own."""
        if not self.another:
            return []
        return [
            f"the flight is that of {self.source}, not of the study's vehicle, {self.another}; give"
            " its own in [schedule], or leave out [schedule] and [size]"
        ]

    @property
    def notes(self) -> list[str]:
        """What is to be known of the winds; nothing without soundings."""
        if not self.soundings:
            return []
        near = "" if self.window is None else f" within {0.5 * self.window:g} s of each flight time"
        return [
            f"in {', '.join(self.soundings)} only what blows{near} to the side on which it is"
            " largest counts",
            *(f"{k}: {note}" for k, one in self.soundings.items() for note in one.profile.notes),
        ]

    def peak_at(self, vehicle: Vehicle, pulse: ShapedWind) -> float:
        """Return the peak angle [rad] of a pulse that a vehicle meets."""
        instance("vehicle", vehicle, Vehicle, "see load_vehicle")
        instance("pulse", pulse, ShapedWind, "one of pulses")
        if pulse.heading is not None or self.plane == BOTH:
            peaks = self._peaks(vehicle, pulse)
            return peaks[self.plane] if self.plane in peaks else math.hypot(*peaks.values())
        if self.peak_speed is None:
            return pulse.peak
        at = vehicle.velocity, vehicle.attitude
        return float(angle_in_plane(self.peak_speed, *at, self.plane))

    def _peaks(self, vehicle: Vehicle, pulse: ShapedWind) -> dict[str, float]:
        """The peak angles [rad] in both planes of a pulse with a heading."""
        attitude = float(np.asarray(vehicle.attitude))
        if self.peak_speed is None or pulse.heading is None:
            return pulse.peaks(attitude)
        velocity = float(np.asarray(vehicle.velocity))
        angles = angles_from_speed(self.peak_speed, velocity, attitude, pulse.heading)
        return dict(zip(PLANES, angles, strict=True))

    def _met(self, pulse: ShapedWind) -> WindOf:
        def met(vehicle: Vehicle) -> History | PlaneWind:
            blows = replace(pulse, gust=self.gust)
            if pulse.heading is None and self.plane != BOTH:
                return blows.history({"wind_peak": self.peak_at(vehicle, pulse)})
            peaks = self._peaks(vehicle, pulse)
            if self.plane == BOTH:
                return PlaneWind(**{plane: part_in(blows, peaks, plane) for plane in PLANES})
            if peaks[self.plane] == 0.0:
                pulse.in_plane(self.plane, float(np.asarray(vehicle.attitude)))
            return part_in(blows, peaks, self.plane)

        return met

    def _flown(self, name: str, sounding: SoundingAsked) -> WindOf:
        with naming(name):
            return fly_through(
                sounding.profile,
                self.schedule,
                azimuth=sounding.azimuth,
                plane=self.plane,
                window=self.window,
                gust=self.gust,
            )

    def _pulse_name(self, pulse: ShapedWind) -> str:
        strength = f"{np.degrees(pulse.peak):.6g} deg"
        if self.peak_speed is not None:
            strength = f"{self.peak_speed:g} m/s"
        return f"{pulse.shape} wind of {strength}, {pulse.duration:g} s"
