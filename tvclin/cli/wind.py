"""The options of the wind of one flight time, and the wind that they ask for."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tvclin.cli.inputs import gust_of, heading_given, only_with, peak_angle
from tvclin.cli.options import (
    TIME_HELP,
    AzimuthDeg,
    Gust,
    GustAt,
    PeakDeg,
    PeakSpeed,
    WindDirectionDeg,
)
from tvclin.cli.output import say

if TYPE_CHECKING:
    from tvclin.answers.case import Case
    from tvclin.answers.nozzle import Nozzle
    from tvclin.control.autopilot.rules import AutopilotDesign
    from tvclin.vehicle.linear_vehicle import AnyVehicle
    from tvclin.winds.histories import History
    from tvclin.winds.shaped import ShapedWind

_SHAPE, _DURATION, _WINDOW = "triangular", 7.5, 20.0


@dataclass(frozen=True)
class BlowingOptions:
    """All but the shape of a pulse; `grouped` gives them to a command."""

    duration: Annotated[
        float | None, typer.Option(help="Duration of the wind, in s.", show_default="7.5")
    ] = None
    peak_deg: PeakDeg = None
    peak_speed: PeakSpeed = None
    gust: Gust = None
    gust_at: GustAt = None
    winds: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="A sounding, in place of a pulse: what the vehicle's flight meets of it around its"
            " own time. Needs --azimuth-deg.",
        ),
    ] = None
    winds_time: Annotated[
        str | None,
        typer.Option(
            metavar="TIME", help=f"Which sounding of a file that holds several, {TIME_HELP}"
        ),
    ] = None
    window: Annotated[
        float | None,
        typer.Option(
            help="Length of the part of the sounding that counts, about the vehicle's own time of"
            " flight, in s.",
            show_default="20",
        ),
    ] = None
    wind_direction_deg: WindDirectionDeg = None
    azimuth_deg: AzimuthDeg = None

    def pulse(self, vehicle: "AnyVehicle", plane: str, shape: str = _SHAPE) -> "ShapedWind":
        """Return the pulse in a plane, with its gust; what is out of range is refused."""
        import numpy as np

        from tvclin.base.errors import positive
        from tvclin.vehicle.linear_vehicle import whole_vehicle
        from tvclin.winds.shaped import ShapedWind

        only_with("a sounding, --winds", window=self.window, winds_time=self.winds_time)
        length = _DURATION if self.duration is None else self.duration
        length = float(positive("--duration", length, "s"))
        if self.gust is None:
            only_with("--gust", gust_at=self.gust_at)
        gust = gust_of(self.gust, 0.5 * length if self.gust_at is None else self.gust_at)
        heading = heading_given(self.wind_direction_deg, self.azimuth_deg)
        peak = peak_angle(vehicle, plane, self.peak_deg, self.peak_speed, heading)
        found = ShapedWind(shape, peak, length, heading, gust)
        if heading is None:
            return found
        whole = whole_vehicle(vehicle, "a wind with a direction")
        return found.in_plane(plane, float(np.asarray(whole.attitude)))

    def sounding(
        self, source: str, vehicle: "AnyVehicle", plane: str, in_flight: bool = False
    ) -> "History":
        """Return what the flight of a source meets of the sounding, from t = 0 on, or in its time.

        As in `tvclin size`, what blows to the side on which the wind is largest counts.
        """
        import numpy as np

        from tvclin.answers.sizing.measured import fly_through
        from tvclin.answers.sizing.placing import place
        from tvclin.answers.sizing.schedule_file import load_schedule
        from tvclin.base.errors import InputError, between, number, positive
        from tvclin.vehicle.linear_vehicle import whole_vehicle
        from tvclin.winds.soundings.read import read_sounding

        file, degrees = self.winds, self.azimuth_deg
        assert file is not None
        only_with(
            "a pulse in place of --winds: a sounding has its own wind",
            wind=getattr(self, "wind", None),
            duration=self.duration,
            peak_deg=self.peak_deg,
            peak_speed=self.peak_speed,
            gust_at=self.gust_at,
            wind_direction_deg=self.wind_direction_deg,
        )
        whole = whole_vehicle(vehicle, "--winds")
        if degrees is None:
            raise InputError("--winds needs --azimuth-deg, the direction of flight")
        if whole.time is None:
            raise InputError("--winds needs a vehicle with its time of flight, time_s")
        window = _WINDOW if self.window is None else self.window
        length = number("--window", window, positive, "s")
        azimuth = float(np.radians(number("--azimuth-deg", degrees, between(-360.0, 360.0), "deg")))
        flight, time = load_schedule(source), float(whole.time)
        profile = read_sounding(file, time=self.winds_time)
        for note in profile.notes:
            say(f"Note: {file.name}: {note}.", err=True)
        gust = gust_of(self.gust, 0.0)
        met = fly_through(profile, flight, azimuth=azimuth, plane=plane, window=length, gust=gust)
        placed = place(met, whole, time, "peak", length)
        if not placed.known or placed.calm:
            word = "calm" if placed.known else "not known"
            raise InputError(f"the wind of {file.name} is {word} at {time:g} s, the vehicle's time")
        first, last = met.known
        if time - length / 2 < first or last < time + length / 2:
            say(
                f"Note: {file.name} is known from {first:.6g} to {last:.6g} s of flight only; what"
                " blows beyond is not counted.",
                err=True,
            )
        return placed.in_flight if in_flight else placed.in_flight.shift(-placed.span[0])


@dataclass(frozen=True)
class WindOptions(BlowingOptions):
    """The options in one place; `grouped` gives them to a command."""

    wind: Annotated[
        str | None,
        typer.Option(
            help="Shape of the wind: triangular or rectangular.", show_default="triangular"
        ),
    ] = None

    @property
    def name(self) -> str:
        """The shape of the pulse, or the file of the sounding."""
        return self.wind or _SHAPE if self.winds is None else self.winds.name

    def blowing(
        self, source: str, vehicle: "AnyVehicle", plane: str, in_flight: bool = False
    ) -> "ShapedWind | History":
        """Return the wind in a plane; in flight time its middle is at the vehicle's own."""
        from tvclin.base.errors import one_of
        from tvclin.vehicle.linear_vehicle import whole_vehicle
        from tvclin.winds.shaped import PULSES

        if self.winds is not None:
            return self.sounding(source, vehicle, plane, in_flight)
        found = self.pulse(vehicle, plane, one_of("--wind", self.name, PULSES))
        if not in_flight:
            return found
        time = whole_vehicle(vehicle, "a flight in its own time").time
        return found.history({}).shift((0.0 if time is None else float(time)) - found.duration / 2)

    def case(
        self,
        source: str,
        vehicle: "AnyVehicle",
        model: str | None,
        plane: str,
        nozzle: "Nozzle | None" = None,
        design: "AutopilotDesign | None" = None,
        *,
        in_flight: bool = False,
    ) -> "Case":
        """Return the case of a vehicle in the wind, with a nozzle and an autopilot if given."""
        from tvclin.answers.case import Case
        from tvclin.answers.nozzle import Nozzle

        return Case(
            vehicle=vehicle,
            model=model or "",
            plane=plane,
            wind=self.blowing(source, vehicle, plane, in_flight),
            nozzle=nozzle or Nozzle(),
            design=design,
        )


def wind_words(name: str, wind: "History") -> str:
    """Return a wind in words: its name, its peak and how long it blows."""
    import numpy as np

    peak, length = float(np.degrees(wind.peak)), float(wind.end - wind.onset)
    return f"{name} wind of {peak:.4g} deg and {length:.4g} s"
