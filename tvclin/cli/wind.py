"""Options of the wind at one flight time, and the wind that they specify."""

from dataclasses import dataclass, replace
from math import degrees, radians
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.errors import (
    Faults,
    InputError,
    between,
    nonzero,
    number,
    one_of,
    positive,
)
from tvclin.base.quantities import NOMINAL
from tvclin.case.case import Case
from tvclin.cli.inputs import chosen, only_with
from tvclin.cli.options import SHAPE, TIME_HELP, asked
from tvclin.cli.output import say
from tvclin.requirement.case_requirement import CaseRequirement, pulse_of
from tvclin.studyfile.read import vehicle_source
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.linear_vehicle import complete_vehicle
from tvclin.winds import wind_file
from tvclin.winds.histories import History
from tvclin.winds.shaped import SHAPES, ShapedWind
from tvclin.winds.wind_file import heading_of

if TYPE_CHECKING:
    from tvclin.ascent.measured_wind import MeasuredPlanes, MeasuredWind
    from tvclin.winds.soundings.profile import WindProfile

    Met = MeasuredWind | MeasuredPlanes

_WINDOW_S = 20.0
"""Default of --window: length of the part of a sounding that counts [s]."""


GUST = asked(
    "Gust (1 - cosine) on top of the wind: its peak and duration; more: --set gust.KEY VALUE.",
    metavar="DEG S",
)


def gust_of_option(
    gust: tuple[float, float], plateau: float = 0.0, option: str = "--gust"
) -> History:
    """Return the gust of a peak [deg] and a duration [s] of an option, with a plateau [s]."""
    peak, duration = number(option, gust[0], nonzero), number(option, gust[1], positive)
    return wind_file.gust_of(float(np.radians(peak)), duration, plateau)


@dataclass(frozen=True)
class _Pulse:
    duration: float | None = asked("Duration of the wind, in s.", shown="7.5")
    peak_deg: float | None = asked("Peak wind angle of attack, in deg.", shown="5")
    peak_speed: float | None = asked(
        "Peak wind speed, in m/s, in place of --peak-deg, by eq (B1e)."
    )


@dataclass(frozen=True)
class PulseOptions(_Pulse):
    """Options of a pulse but its shape; `grouped` gives them to a command."""

    gust: tuple[float, float] | None = GUST
    wind_direction_deg: float | None = asked(
        "Where the wind blows from, in deg from north, clockwise; --peak-deg is then the size of"
        " the wind's vector in both planes. Needs --azimuth-deg."
    )
    azimuth_deg: float | None = asked("Direction of flight, in deg from north, clockwise.")

    panel = "Wind"

    def __post_init__(self) -> None:
        if self.peak_deg is not None and self.peak_speed is not None:
            raise InputError("give --peak-deg or --peak-speed, not both")

    def over(self, plan: StudyPlan, source: str = "") -> StudyPlan:
        """Return a plan with the pulse of these options in place of its own values."""
        wind, shape = pulse_of(plan), getattr(self, "wind", None)
        lasts = number("--duration", chosen(self.duration, wind.duration), positive, "s")
        peak = wind.peak
        if self.peak_deg is not None:
            peak = float(np.radians(number("--peak-deg", self.peak_deg, nonzero, "deg")))
        wind = replace(
            wind,
            shape=wind.shape if shape is None else one_of("--wind", shape, SHAPES),
            duration=lasts,
            peak=peak,
            heading=chosen(self._heading, wind.heading),
        )
        wind = self._gusty(wind)
        if self.peak_speed is not None:
            vehicle = complete_vehicle(plan.vehicle, "--peak-speed")
            speed = number("--peak-speed", self.peak_speed, nonzero, "m/s")
            wind = wind.with_speed(speed, vehicle, plan.plane)
        return replace(plan, wind=wind)

    def _gusty(self, wind: ShapedWind) -> ShapedWind:
        """Return a wind with the gust of these options, at the time of the largest requirement."""
        if self.gust is None:
            return wind
        return replace(wind, gust=gust_of_option(self.gust), gust_at=None, gust_speed=None)

    @property
    def _heading(self) -> float | None:
        """The heading of the wind [rad]; None without --wind-direction-deg."""
        angles_deg = {
            "--wind-direction-deg": self.wind_direction_deg,
            "--azimuth-deg": self.azimuth_deg,
        }
        angles = [
            None if angle is None else float(np.radians(number(name, angle)))
            for name, angle in angles_deg.items()
        ]
        return heading_of(angles[0], angles[1], ("--wind-direction-deg", "--azimuth-deg"))


@dataclass(frozen=True)
class ShapedOptions(PulseOptions):
    """Options of a pulse; `grouped` gives them to a command."""

    wind: str | None = SHAPE


@dataclass(frozen=True)
class FormatOptions:
    """Options of the format, units and site of soundings; `grouped` gives them to a command."""

    winds_format: str | None = asked(
        "Format of the sounding: csv, openrocket, wyoming, igra, rocketpy or synthetic.",
        shown="by its content",
    )
    units: str | None = asked(
        "Units of a table of winds that names none: those of heights, speeds and directions.",
        metavar="FT,MPH",
        shown="m,m/s,deg with --winds-format openrocket",
    )
    above_ground: float | None = asked(
        "Elevation of the site above the sea, in m, for a table of heights above the ground.",
        metavar="M",
    )

    @property
    def reading(self) -> dict[str, Any]:
        """Arguments of `read_sounding` from these options."""
        return {
            "format": self.winds_format,
            "units": self.units,
            "above_ground": self.above_ground,
        }


@dataclass(frozen=True)
class BiasOptions(FormatOptions, PulseOptions):
    """Options of the mean wind that a biased flight path removes from soundings."""

    bias: Path | None = asked(
        "Take a wind out of the soundings, for which the flight path is biased: a sounding, as"
        " yesterday's, or the mean of a station file.",
        metavar="FILE",
    )
    bias_month: int | None = asked(
        "Month of the mean of a station file, from 1 to 12.", shown="all"
    )

    @property
    def mean_wind(self) -> "WindProfile | None":
        """The wind for which the flight path is biased."""
        from tvclin.winds.soundings.igra import is_station
        from tvclin.winds.soundings.sounding_files import read_sounding, read_soundings

        if self.bias is None:
            only_with("--bias", bias_month=self.bias_month)
            return None
        if is_station(self.bias):
            months = None if self.bias_month is None else [self.bias_month]
            return read_soundings(self.bias, months=months).mean()
        only_with("--bias, the file of a station", bias_month=self.bias_month)
        return read_sounding(self.bias)

    def only_with_sounding(self, *names: str) -> None:
        """Raise `InputError` for options of soundings, and of these names, where there is none."""
        fields = ("winds_format", "units", "above_ground", "bias", "bias_month", *names)
        only_with("a sounding, --winds", **{name: getattr(self, name) for name in fields})


@dataclass(frozen=True)
class SoundingOptions(BiasOptions):
    """Options of a sounding, or of a pulse but its shape; `grouped` gives them to a command."""

    winds: Path | None = asked(
        "A sounding, in place of a pulse: what the vehicle's flight meets of it around its"
        " own time. Needs --azimuth-deg.",
        metavar="FILE",
    )
    winds_time: str | None = asked(
        f"Which sounding of a file that holds several, {TIME_HELP}", metavar="TIME"
    )
    window: float | None = asked(
        "Length of the part of the sounding that counts, about the vehicle's own time of"
        " flight, in s.",
        shown="20",
    )

    def over(self, plan: StudyPlan, source: str = "") -> StudyPlan:
        """Return a plan with the sounding or the pulse of these options; a sounding from t = 0."""
        if self.winds is None:
            self.only_with_sounding("window", "winds_time")
            return super().over(plan, source)
        wind = self.sounding(plan, source)
        return replace(plan, wind=wind.shift(-float(wind.onset)))

    def in_flight(self, plan: StudyPlan, source: str = "") -> StudyPlan:
        """Return a plan with the wind in flight time, a pulse centred on the vehicle's own time."""
        if self.winds is not None:
            return replace(plan, wind=self.sounding(plan, source))
        shifted = self.over(plan, source)
        time = complete_vehicle(plan.vehicle, "a flight in its own time").time
        middle = 0.0 if time is None else float(time)
        return replace(
            shifted, wind=shifted.history.shift(middle - 0.5 * pulse_of(shifted).duration)
        )

    def name(self, case: Case) -> str:
        """Return the name of the wind of a case: its shape, or the file of the sounding."""
        if self.winds is not None:
            return self.winds.name
        return chosen(getattr(self, "wind", None), case.shape)

    def title(self, case: Case, source: str) -> str:
        """Return the vehicle of a case, its model and its wind, at nominal dynamic pressure."""
        name = case.vehicle.name or source
        return f"{name}, {case.plant.model}: {wind_words(self.name(case), case)}, {NOMINAL}"

    def document(self, case: Case, required: CaseRequirement | None) -> dict[str, Any]:
        """Return the vehicle, model, wind and plane of a case, and its requirement, for JSON."""
        return {
            "vehicle": case.vehicle.name,
            "model": case.plant.model,
            "wind": {"name": self.name(case), **case.history.as_dict()},
            "plane": case.plane,
            "required_deflection_deg": required and degrees(required.required_deflection),
        }

    def sounding(self, plan: StudyPlan, source: str) -> History:
        """Return the wind angle [rad] of the sounding in the flight of a plan, in flight time.

        As in `tvclin ascent`, only the wind with the sign of its peak counts.
        """
        from tvclin.requirement.flight.flight_winds import place

        assert self.winds is not None
        fields = ("duration", "peak_deg", "peak_speed", "wind_direction_deg")
        pulse = {name: getattr(self, name, None) for name in ("wind", *fields)}
        only_with("a pulse in place of --winds: a sounding has its own wind", **pulse)
        vehicle, faults = complete_vehicle(plan.vehicle, "--winds"), Faults()
        with faults.kept():
            azimuth = azimuth_of(self.azimuth_deg)
        with faults.kept():
            if vehicle.time is None:
                raise InputError("--winds needs a vehicle with its time of flight, time_s")
        faults.tell()
        length = number("--window", chosen(self.window, _WINDOW_S), positive, "s")
        wind, time = self._encountered(plan, source, azimuth, length), float(vehicle.time)
        placed = place(wind, vehicle, time, "peak", length)
        if not placed.known or placed.calm:
            word = "calm" if placed.known else "not known"
            raise InputError(
                f"the wind of {self.winds.name} is {word} at {time:g} s, the vehicle's time"
            )
        first, last = wind.known
        if time - length / 2 < first or last < time + length / 2:
            say(
                f"Note: {self.winds.name} is known from {first:.6g} to {last:.6g} s of flight only;"
                " what blows beyond is not counted.",
                err=True,
            )
        return placed.in_flight

    def _encountered(self, plan: StudyPlan, source: str, azimuth: float, length: float) -> "Met":
        """Return the sounding along the flight of a plan, or else along that of its vehicle."""
        assert self.winds is not None
        from tvclin.ascent.measured_wind import fly_through
        from tvclin.ascent.schedule_file import load_schedule

        request, gust = plan.sizing, self._gusty(pulse_of(plan)).gust
        return fly_through(
            noted_sounding(self.winds, self.winds_time, **self.reading),
            load_schedule(vehicle_source(source)) if request is None else request.schedule,
            azimuth=azimuth,
            plane=plan.plane,
            window=length,
            gust=gust,
            bias=self.mean_wind,
        )


@dataclass(frozen=True)
class WindOptions(SoundingOptions, ShapedOptions):
    """Options of a pulse or a sounding; `grouped` gives them to a command."""


def azimuth_of(degrees: float | None) -> float:
    """Return the direction of flight [rad] of --azimuth-deg, which soundings need."""
    if degrees is None:
        raise InputError("--winds needs --azimuth-deg, the direction of flight")
    return radians(number("--azimuth-deg", degrees, between(-360.0, 360.0), "deg"))


def noted_sounding(file: Path, time: str | None, **reading: Any) -> "WindProfile":
    """Return the sounding of a file, and print its notes on stderr.

    `reading`: other arguments of `read_sounding`.
    """
    from tvclin.winds.soundings.sounding_files import read_sounding

    profile = read_sounding(file, time=time, **reading)
    for note in profile.notes:
        say(f"Note: {file.name}: {note}.", err=True)
    return profile


def wind_words(name: str, case: Case) -> str:
    """Return the wind of a case in words: its name, its peak, its duration, and its gust."""
    wind, gust = case.history, ""
    peak, length = float(wind.peak), float(wind.end - wind.onset)
    in_plane = case.wind_in_plane
    if isinstance(in_plane, ShapedWind):
        peak, length, gust = in_plane.peak, in_plane.duration, in_plane.gust_text
    return f"{name} wind of {degrees(peak):.4g} deg and {length:.4g} s{gust}"
