"""The winds that a flight is asked to meet: pulses about each flight time, and soundings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tvclin.answers.case import FROZEN, SIGNS, Case
from tvclin.answers.sizing.placing import WindOf
from tvclin.ascent.measured_wind import GustOf, fly_through, gust_of_speed
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.errors import InputError, bearing, instance, naming
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.shaped import ShapedWind, component_in
from tvclin.winds.soundings.profile import WindProfile


@dataclass(frozen=True, eq=False)
class SoundingAsked:
    """A wind over height that the flight goes through.

    Attributes
    ----------
    profile : WindProfile
        The wind; see `read_sounding`.
    azimuth : float
        Direction of flight [rad], from north, clockwise.
    bias : WindProfile, optional
        The mean wind for which the flight path is biased, as of `fly_through`.
    """

    profile: WindProfile
    azimuth: float
    bias: WindProfile | None = None

    def __post_init__(self) -> None:
        instance("profile", self.profile, WindProfile, "see read_sounding")
        object.__setattr__(self, "azimuth", bearing("azimuth", self.azimuth))
        if self.bias is not None:
            instance("bias", self.bias, WindProfile, "see read_sounding")


@dataclass(frozen=True, eq=False)
class FlightWinds:
    """What blows on the flight of a case.

    `case`: its planes, model, nozzle and sign count. `schedule`: the flight. `pulses`: whose peak
    meets each flight time, with the gust of the case. `soundings`: by name. `peak_speed`,
    `gust_speed`: wind speeds [m/s] in place of the angles of pulses and their gust. `window`: of a
    sounding, about each flight time [s]. `dead_band`: for which a gust comes at its worst time.
    """

    case: Case
    schedule: FlightSchedule
    pulses: tuple[ShapedWind, ...]
    soundings: Mapping[str, SoundingAsked]
    peak_speed: float | None
    gust_speed: float | None
    window: float | None
    dead_band: float

    @property
    def by_name(self) -> dict[str, WindOf]:
        """The winds as `size` takes them; soundings are in flight time. It raises as `winds`."""
        sign = self.case.sign
        if sign in SIGNS and any(one.heading is not None for one in self.pulses):
            raise InputError("a wind with a direction is a head or a tail wind by that: leave sign")
        return {self._name(one): self._met(one) for one in self.pulses} | {
            name: self._flown(name, one) for name, one in self.soundings.items()
        }

    @property
    def gust(self) -> GustOf | None:
        """The gust as each vehicle of the flight meets it."""
        gust: History | None = getattr(self.case.wind, "gust", None)
        if self.gust_speed is None or gust is None:
            return gust
        return gust_of_speed(gust, self.gust_speed, self.case.planes)

    def case_of(self, vehicle: Vehicle, pulse: ShapedWind) -> Case:
        """Return the case of a vehicle of the flight, in a pulse as it meets it."""
        case = self.case
        return Case(
            vehicle=vehicle,
            model=case.model,
            plane=case.plane,
            wind=self._blows(vehicle, pulse),
            nozzle=case.nozzle,
            design=case.design,
            sign=case.sign,
        )

    def _blows(self, vehicle: Vehicle, pulse: ShapedWind) -> ShapedWind:
        """A pulse with the angles at which a vehicle meets it and its gust."""
        if self.peak_speed is not None:
            pulse = pulse.with_speed(self.peak_speed, vehicle, self.case.plane)
        if self.gust_speed is not None:
            pulse = pulse.with_gust_speed(self.gust_speed, vehicle, self.case.plane)
        return pulse

    def _met(self, pulse: ShapedWind) -> WindOf:
        """A pulse as vehicles meet it: its part in the plane, or for both planes the vector."""
        case = self.case

        def met(vehicle: Vehicle) -> History | PlaneWind:
            blows = self.case_of(vehicle, pulse).wind_at(self.dead_band)
            attitude = float(np.asarray(vehicle.attitude))
            if case.planes != BOTH:
                return blows.in_plane(case.plane, attitude).history({})
            peaks = blows.peaks(attitude)
            return PlaneWind(**{plane: component_in(blows, peaks, plane) for plane in PLANES})

        return met

    def _flown(self, name: str, sounding: SoundingAsked) -> WindOf:
        with naming(name):
            return fly_through(
                sounding.profile,
                self.schedule,
                azimuth=sounding.azimuth,
                plane=self.case.planes,
                window=self.window,
                gust=self.gust,
                pressure=self.case.sign != FROZEN,
                bias=sounding.bias,
            )

    def _name(self, pulse: ShapedWind) -> str:
        name = f"{pulse.shape} wind of {_strength(pulse.peak, self.peak_speed)}"
        if pulse.gust is None:
            return f"{name}, {pulse.duration:g} s"
        gust, peak = pulse.gust, _strength(float(pulse.gust.peak), self.gust_speed)
        return f"{name}, {pulse.duration:g} s, gust of {peak}, {gust.end - gust.onset:g} s"


def _strength(peak: float, speed: float | None) -> str:
    return f"{np.degrees(peak):.6g} deg" if speed is None else f"{speed:g} m/s"
