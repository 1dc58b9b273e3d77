"""Options of the wind at one flight time, and the wind that they specify."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import degrees, radians
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.ascent.measured_wind import gust_words
from tvclin.ascent.wind_along import WINDOW_S, SoundingWind
from tvclin.base.errors import InputError, between, nonzero, number, one_of, positive
from tvclin.base.files import called
from tvclin.base.quantities import NOMINAL
from tvclin.case.case import DEFAULT_WIND, Case
from tvclin.cli.inputs import chosen, keys_set, only_with
from tvclin.cli.options import SHAPE, option
from tvclin.cli.output import note_below
from tvclin.requirement.case_requirement import CaseRequirement, pulse_of
from tvclin.studyfile.read import vehicle_source
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.linear_vehicle import complete_vehicle
from tvclin.vehicle.vehicle_file import source_tables
from tvclin.winds.shaped import SHAPES, ShapedWind, refuse_gust_time
from tvclin.winds.soundings.sounding_files import NO_READING, SoundingReading
from tvclin.winds.wind_angles import CROSS, SIGNS

if TYPE_CHECKING:
    from tvclin.requirement.flight.request import SoundingRequest
    from tvclin.winds.soundings.profile import WindProfile


_DIRECTION = "a wind with a direction, --set wind.direction_deg 270"
DIRECTED = f"a sounding, --winds FILE, or {_DIRECTION}"
"""Winds that need the direction of flight."""


@dataclass(frozen=True)
class PulseOptions:
    """Options of a pulse; `grouped` gives them to a command."""

    duration: float | None = option("Duration of the wind, in s.", shown="7.5")
    peak_deg: float | None = option("Peak wind angle of attack, in deg.", shown="5")
    peak_speed: float | None = option(
        "Peak wind speed, in m/s, in place of --peak-deg, by eq (B1e)."
    )
    wind: str | None = SHAPE
    azimuth_deg: float | None = option(
        "Direction of flight, in deg from north, clockwise: for a sounding, or for a wind with a"
        " direction, --set wind.direction_deg, whose peak is then that of its vector."
    )

    panel = "Wind"
    directed = f"{_DIRECTION}; tvclin ascent and tvclin fly also take a sounding, --winds FILE"

    def __post_init__(self) -> None:
        """Raise `InputError` for two peaks."""
        if self.peak_deg is not None and self.peak_speed is not None:
            raise InputError("give --peak-deg or --peak-speed, not both")

    def applied_to(self, plan: StudyPlan, source: str = "") -> StudyPlan:
        """Return a plan with the pulse of these options in place of its own values.

        A sounding of the file is the wind unless an option of a pulse is given. `source` is not
        used: other options of a wind read it. `InputError` for a direction of flight without a wind
        that needs it, and a speed of a vehicle known by its coefficients.
        """
        wind, shape = plan.wind, self.wind
        pulse = (shape, self.duration, self.peak_deg, self.peak_speed)
        if isinstance(wind, SoundingWind) and all(value is None for value in pulse):
            return plan
        wind = wind if isinstance(wind, ShapedWind) else DEFAULT_WIND
        duration = number("--duration", chosen(self.duration, wind.duration), positive, "s")
        peak, speed = wind.peak, wind.speed
        if self.peak_deg is not None:
            peak = float(np.radians(number("--peak-deg", self.peak_deg, nonzero, "deg")))
            speed = None  # the angle replaces the speed of the file
        wind = replace(
            wind,
            shape=wind.shape if shape is None else one_of("--wind", shape, SHAPES),
            duration=duration,
            peak=peak,
            speed=speed,
        )
        if wind.heading is None and not _has_soundings(plan):
            only_with(self.directed, azimuth_deg=self.azimuth_deg)
        if self.peak_speed is not None:
            vehicle = complete_vehicle(plan.vehicle, "--peak-speed")
            speed = number("--peak-speed", self.peak_speed, nonzero, "m/s")
            wind = wind.with_speed(speed, vehicle, plan.plane)
        return replace(plan, wind=wind)


@dataclass(frozen=True)
class WindOptions(PulseOptions):
    """Options of a pulse or a sounding; `grouped` gives them to a command."""

    directed = DIRECTED
    winds: Path | None = option(
        "A sounding, in place of a pulse, around the vehicle's time of flight; with --azimuth-deg."
        " Its format, window, ...: --set sounding.KEY VALUE.",
        metavar="FILE",
    )

    def applied_to(self, plan: StudyPlan, source: str = "") -> StudyPlan:
        """Return a plan with the sounding or the pulse of these options.

        A sounding is a wind from t = 0 on, the flight time of the vehicle. `source`: file of the
        plan. `InputError` for keys of [sounding] in a plan without one.
        """
        sounding = self.sounding_of(plan, source)
        if sounding is None:
            plan = super().applied_to(plan, source)
            check_reading(plan)
        else:
            plan = replace(plan, wind=sounding)
        if isinstance(plan.wind, SoundingWind):
            note_sounding(plan.wind, plan, plan.reading.window)
        return plan

    def name(self, case: Case) -> str:
        """Return the name of the wind of a case: its shape, or the name of the sounding."""
        if self.winds is not None:
            return self.winds.name
        return chosen(self.wind, case.shape)

    def title(self, case: Case, source: str) -> str:
        """Return a title: vehicle of a case, or else its file `source`, its model and its wind."""
        name = case.vehicle.name or source
        return f"{name}, {case.plant.model}: {wind_words(self.name(case), case)}, {NOMINAL}"

    def document(self, case: Case, required: CaseRequirement | None) -> dict[str, Any]:
        """Return vehicle, model, wind and plane of a case for JSON, and its required deflection."""
        return {
            "vehicle": case.vehicle.name,
            "model": case.plant.model,
            "wind": {"name": self.name(case), **case.history.as_dict()},
            "plane": case.plane,
            "required_deflection_deg": required and degrees(required.known_deflection),
        }

    def sounding_of(self, case: Case, source: str) -> SoundingWind | None:
        """Return the sounding of --winds in the flight of a case; None without the option.

        `source`: file of the case, with keys of soundings: the bias is a mean wind over height for
        which the flight path is biased, the window [s] the part of the flight around the vehicle's
        time in which the sounding counts. `InputError` for options of a pulse, and for a gust with
        a time.
        """
        from tvclin.ascent.schedule_file import load_schedule

        if self.winds is None:
            return None
        self._check_no_pulse()
        refuse_gust_time(getattr(case.wind, "gust_at", None))
        reading = SoundingReading.of(source_tables(source), Path(source).parent)
        request = getattr(case, "sizing", None)
        return SoundingWind(
            name=self.winds.name,
            azimuth=azimuth_of(self.azimuth_deg),
            profile=reading.profile(self.winds),
            schedule=load_schedule(vehicle_source(source)) if request is None else request.schedule,
            window=chosen(reading.window, WINDOW_S),
            gust=getattr(case.wind, "gust", None),
            bias=reading.mean_wind,
        )

    def soundings_along(self, source: str) -> "dict[str, SoundingRequest]":
        """Return the soundings of --winds, a file or a folder, for a whole flight, by name.

        `source`: file of the case, whose keys say how they are read. `InputError` with a pulse.
        """
        self._check_no_pulse()
        reading = SoundingReading.of(source_tables(source), Path(source).parent)
        flight_options = FlightOptions(**(vars(self) | {"winds": [self.winds]}))
        return flight_options.soundings(reading)

    def _check_no_pulse(self) -> None:
        """Raise `InputError` for options of a pulse beside a sounding."""
        names = ("wind", "duration", "peak_deg", "peak_speed")
        pulse = {name: getattr(self, name) for name in names}
        only_with("a pulse in place of --winds: a sounding has its own wind", **pulse)


@dataclass(frozen=True)
class FlightOptions(PulseOptions):
    """Options of a pulse whose peak comes at each flight time, and of soundings."""

    directed = DIRECTED
    winds: list[Path] | None = option(
        "A sounding to fly through, with --azimuth-deg, or a folder or a station file of several;"
        " may be given several times. Its format, window, ...: --set sounding.KEY VALUE.",
        metavar="FILE",
    )

    def soundings(self, reading: SoundingReading) -> "dict[str, SoundingRequest]":
        """Return the soundings of the files of --winds, by name.

        `reading`: format, time and bias of soundings; the bias is a mean wind over height for which
        the flight path is biased. Files of one name are told apart by their paths.
        """
        from tvclin.requirement.flight.request import SoundingRequest

        files = self.winds or []
        azimuth = azimuth_of(self.azimuth_deg) if files else 0.0
        names = [called(file.name) for file in files]
        requests: dict[str, SoundingRequest] = {}
        for file, label in zip(files, names, strict=True):
            name = label if names.count(label) == 1 else called(file)
            for full_name, profile in _profiles(name, file, reading):
                if full_name in requests:
                    raise InputError(f"--winds gives {full_name} twice")
                requests[full_name] = SoundingRequest(profile, azimuth, reading.mean_wind)
        return requests

    def at_one_time(self, source: str) -> WindOptions:
        """Return the options of a wind at a single flight time. `source`: file of the case.

        `InputError` for several soundings, and for a sounding beside a wind of --set.
        """
        files = self.winds or []
        for key in keys_set(source) if files else ():
            if key.partition(".")[0] == "wind":
                raise InputError(f"give --winds or --set {key}, not both")
        if len(files) > 1:
            raise InputError(
                f"--winds may be given several times for a whole flight alone; got {len(files)}"
            )
        return WindOptions(**(vars(self) | {"winds": files[0] if files else None}))

    def applied_to(self, plan: StudyPlan, source: str = "") -> StudyPlan:
        """Return a plan with the pulse of these options, at each flight time.

        A peak speed stays a speed, of which each flight time makes its own angle. With soundings
        the pulse counts as well if an option of it is given. `source`: file of the case, which only
        `WindOptions.applied_to` reads.
        """
        # with soundings the azimuth is a part of these, see `soundings`
        azimuth = None if self.winds else self.azimuth_deg
        angular = replace(self, peak_speed=None, azimuth_deg=azimuth)
        plan = PulseOptions.applied_to(angular, plan)
        request, speed = plan.sizing, self.peak_speed
        assert request is not None
        named = (self.wind, self.duration, self.peak_deg, speed)
        request = replace(
            request,
            pulse=request.pulse or any(value is not None for value in named),
            peak_speed=None if self.peak_deg is not None else chosen(speed, request.peak_speed),
        )
        return replace(plan, sizing=request)


def _profiles(
    name: str, file: Path, reading: SoundingReading
) -> "Iterator[tuple[str, WindProfile]]":
    """Yield the sounding of a file, or each of a folder or station file by its date, with its name.

    `name`: name of a single sounding. `reading`: format and time of soundings.
    """
    from tvclin.winds.soundings.igra import is_station
    from tvclin.winds.soundings.sounding_files import read_soundings

    if reading.time is not None or not (file.is_dir() or is_station(file)):
        yield name, reading.profile(file)
        return
    archive = read_soundings(file, **reading.table)
    for k in np.flatnonzero(archive.usable).tolist():
        yield np.datetime_as_string(archive.times[k], "h"), archive[k]


def azimuth_of(degrees: float | None) -> float:
    """Return the direction of flight [rad] of --azimuth-deg [deg]; `InputError` without it."""
    if degrees is None:
        raise InputError("--winds needs --azimuth-deg, the direction of flight")
    return radians(number("--azimuth-deg", degrees, between(-360.0, 360.0), "deg"))


def winds_in_flight(plan: StudyPlan) -> dict[str, StudyPlan]:
    """Return plans with a wind in flight time, by its direction: head, tail or cross.

    A pulse is centred on the vehicle's own time. One in the pitch plane is a head and a tail wind,
    unless the plan has its sign or heading; a sounding has the direction of its largest angle.
    """
    if isinstance(plan.wind, SoundingWind):
        plan = replace(plan, wind=replace(plan.wind, in_flight=True))
        return {wind_direction(plan): plan}
    pulse = pulse_of(plan)
    time = complete_vehicle(plan.vehicle, "a flight in its own time").time
    middle = 0.0 if time is None else float(time)
    wind = plan.history.shift(middle - 0.5 * pulse.duration)
    if plan.plane != "pitch" or pulse.heading is not None:
        return {wind_direction(plan): replace(plan, wind=wind)}
    # the sign of the peak by direction, head and tail
    signs = {plan.sign: SIGNS[plan.sign]} if plan.sign in SIGNS else SIGNS
    return {
        name: replace(plan, wind=wind * (sign * float(np.sign(wind.peak))))
        for name, sign in signs.items()
    }


def with_gust_for(plan: StudyPlan, dead_band: float | None) -> StudyPlan:
    """Return a plan whose gust is at its time, or where a control requires most, as in a study.

    `dead_band`: K of the control; None for one without a dead band, of which K = 1 is taken.
    """
    wind = plan.wind
    if dead_band in (None, 1.0) or not isinstance(wind, ShapedWind) or wind.gust is None:
        return plan
    return replace(plan, wind=plan.wind_at(dead_band))


def wind_direction(plan: StudyPlan) -> str:
    """Return the direction of the wind of a plan by the plane and the sign of its peak."""
    if plan.plane != "pitch":
        return CROSS
    return "head" if float(plan.history.peak) < 0.0 else "tail"


def cut_condition(case: Case) -> str:
    """Return the condition on a lower bound in a sounding that is cut, in words.

    Empty for other winds, and where the window of the sounding begins and ends in calm: with a step
    at an end a part of the sounding may require more than all of it.
    """
    wind = case.wind
    if not isinstance(wind, SoundingWind) or not np.any(wind.steps(case.vehicle, case.plane)):
        return ""
    return "; the whole sounding may require less"


def note_sounding(wind: SoundingWind, case: Case, window: float | None) -> None:
    """Print notes on a sounding, and one on its window if it cuts the wind or is the default.

    Where the window cuts the wind, it begins or ends with a step that the sounding does not have,
    and may require more than the whole sounding. `case`: has vehicle and plane. `window`: length
    [s] that the user gives; None for the default.
    """
    part = f"of {wind.name} the {wind.window:g} s about the vehicle's own time count"
    steps = np.degrees(np.abs(wind.steps(case.vehicle, case.plane)))
    for note in wind.notes(case.vehicle, case.plane):
        note_below(note)
    if np.any(steps):
        note_below(
            f"{part}, cut with steps of {steps[0]:.3g} and {steps[1]:.3g} deg at the ends, which"
            " may change every number and which a longer window may take out: --set"
            f" sounding.window_s {2.0 * wind.window:g} or more (tvclin ascent: the whole sounding)"
        )
    elif window is None:
        note_below(f"{part}; --set sounding.window_s takes another length")


def note_one_sign(wind: Any, case: Case, what: str) -> None:
    """Print a note that `what` counts a part of a wind, if that is a sounding of both signs.

    `case`: has vehicle and plane.
    """
    if isinstance(wind, SoundingWind) and not wind.history(case.vehicle, case.plane).constant_sign:
        note_below(
            f"in {wind.name} only what blows to the side on which it is largest counts for {what}"
        )


def zero_words(case: Case) -> str:
    """Return where the time of a flight in a sounding is zero, in words; else empty."""
    if not isinstance(case.wind, SoundingWind):
        return ""
    return f", t = 0 at {case.wind.zero(case.vehicle, case.plane):.4g} s of flight"


def check_reading(plan: StudyPlan) -> None:
    """Raise `InputError` for keys of [sounding] in a plan without any sounding."""
    if plan.reading != NO_READING and not _has_soundings(plan):
        raise InputError("[sounding] needs a sounding: --winds FILE, or one in [[wind]]")


def _has_soundings(plan: StudyPlan) -> bool:
    """Return whether a sounding, or an archive of them, is a wind of a plan."""
    measured = isinstance(plan.wind, SoundingWind) or plan.availability is not None
    return measured or (plan.sizing is not None and bool(plan.sizing.soundings))


def wind_words(name: str, case: Case) -> str:
    """Return the wind of a case in words: its name, its peak, its duration, and its gust."""
    wind, gust = case.history, ""
    peak, length = float(wind.peak), float(wind.end - wind.onset)
    in_plane = case.wind_in_plane
    if isinstance(in_plane, ShapedWind):
        peak, length, gust = in_plane.peak, in_plane.duration, in_plane.gust_text
    elif isinstance(case.wind, SoundingWind) and case.wind.gust is not None:
        time = float(complete_vehicle(case.vehicle, "a sounding").time or 0.0)
        gust = f", with its {gust_words(case.wind.gust)}, at {time:.4g} s of flight"
    return f"{name} wind of {degrees(peak):.4g} deg and {length:.4g} s{gust}"
