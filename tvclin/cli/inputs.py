"""What several commands make of their options."""

from typing import TYPE_CHECKING, Any, TypeVar

from tvclin.cli.output import say

if TYPE_CHECKING:
    from tvclin.vehicle.linear_vehicle import AnyVehicle
    from tvclin.winds.histories import History
    from tvclin.winds.shaped import ShapedWind

T = TypeVar("T")


def only_with(needed: str, **options: Any) -> None:
    """Raise `InputError` for options that are given, and mean nothing without something else.

    Options are named as in a signature; one that is None or False is not given.
    """
    from tvclin.base.errors import InputError

    given = [
        f"--{name.replace('_', '-')}"
        for name, value in options.items()
        if value is not None and value is not False
    ]
    if given:
        *others, last = given
        named = f"{', '.join(others)} and {last} need" if others else f"{last} needs"
        raise InputError(f"{named} {needed}")


def vehicle_of(source: str, rigid: bool = False) -> "AnyVehicle":
    """Return a vehicle, rigid if that is asked for, and say on stderr what in it is odd."""
    from tvclin.base.errors import InputError
    from tvclin.base.files import called, tables_of
    from tvclin.vehicle.file import vehicle_text
    from tvclin.vehicle.linear_vehicle import load_any_vehicle

    text, name = vehicle_text(source)
    if {"study", "campaign"} & tables_of(text, name).keys():
        raise InputError(
            f"{called(name)} is a study file, for tvclin study, size, report and campaign; name"
            " its vehicle here"
        )
    found = load_any_vehicle(source)
    note_doubts(found)
    return found.rigid if rigid else found


def rigid_vehicle_of(source: str, plane: str, question: str) -> "AnyVehicle":
    """Return a vehicle for a question that knows it as rigid, and say so if its file knows more."""
    found = vehicle_of(source)
    note_left_out(question, found, plane)
    return found.rigid


def note_doubts(vehicle: "AnyVehicle") -> None:
    """Say what in the numbers of a vehicle is rather a slip than meant, on stderr."""
    from tvclin.vehicle.doubts import doubts
    from tvclin.vehicle.vehicle import Vehicle

    for doubt in doubts(vehicle) if isinstance(vehicle, Vehicle) else ():
        say(f"Note: {doubt}.", err=True)


def note_left_out(question: str, vehicle: "AnyVehicle", plane: str) -> None:
    """Say on stderr what a question leaves out of a vehicle, see `parts.told`."""
    if vehicle.structure is None:
        return
    from tvclin.answers.parts import told

    for sentence in told(question, vehicle, plane):
        say(f"Note: {sentence}.", err=True)


def note_source(source: str, question: str) -> None:
    """Say the same of a study file or a vehicle file; nothing of a flight without a vehicle."""
    from tvclin.answers.study_file.read import load_study
    from tvclin.base.files import tables_of
    from tvclin.vehicle.file import vehicle_text

    if source.lower().endswith(".csv"):
        return
    if {"vehicle", "study", "campaign"} & tables_of(*vehicle_text(source)).keys():
        plan = load_study(source)
        note_doubts(plan.vehicle)
        note_left_out(question, plan.vehicle, plan.plane)


def peak_angle(
    vehicle: "AnyVehicle",
    plane: str,
    peak_deg: float | None,
    peak_speed: float | None,
    heading: float | None = None,
) -> float:
    """Return the peak wind angle of attack [rad] that was asked for; 5 degrees if none was.

    With a heading [rad] it is the size of the vector of both planes.
    """
    import numpy as np

    from tvclin.base.errors import InputError
    from tvclin.vehicle.linear_vehicle import whole_vehicle
    from tvclin.winds.speed import angle_in_plane, angles_from_speed

    if peak_speed is None:
        return float(np.radians(5.0 if peak_deg is None else peak_deg))
    if peak_deg is not None:
        raise InputError("give --peak-deg or --peak-speed, not both")
    vehicle = whole_vehicle(vehicle, "--peak-speed")
    if heading is not None:
        at = float(np.asarray(vehicle.velocity)), float(np.asarray(vehicle.attitude))
        return float(np.hypot(*angles_from_speed(peak_speed, *at, heading)))
    return float(angle_in_plane(peak_speed, vehicle.velocity, vehicle.attitude, plane))


def heading_given(wind_direction_deg: float | None, azimuth_deg: float | None) -> float | None:
    """Return the heading of the wind [rad] that options give; None without --wind-direction-deg."""
    if wind_direction_deg is azimuth_deg is None:
        return None
    import numpy as np

    from tvclin.base.errors import number
    from tvclin.winds.file import heading_of

    names = ("--wind-direction-deg", "--azimuth-deg")
    direction, azimuth = (
        None if value is None else float(np.radians(number(name, value)))
        for name, value in zip(names, (wind_direction_deg, azimuth_deg), strict=True)
    )
    return heading_of(direction, azimuth, names)


def gust_of(given: tuple[float, float] | None, peak_time: float) -> "History | None":
    """Return the 1 - cosine gust of a peak [deg] and a duration [s] that peaks at a time [s]."""
    import numpy as np

    from tvclin.base.errors import nonzero, number, positive
    from tvclin.winds.gusts import OneMinusCosineGust

    if given is None:
        return None
    peak, duration = number("--gust", given[0], nonzero), number("--gust", given[1], positive)
    found = OneMinusCosineGust(peak=np.radians(peak), duration=duration)
    return found.shift(number("--gust-at", peak_time, unit="s") - 0.5 * duration)


def wind_with(
    wind: "ShapedWind",
    shape: str | None,
    duration: float | None,
    peak: float | None,
    heading: float | None,
    gust: tuple[float, float] | None,
    gust_at: float | None = None,
) -> "ShapedWind":
    """Return a wind with what options say in its place; a gust peaks in its middle without a time.

    Peak and heading are in rad.
    """
    from dataclasses import replace

    if gust is None:
        only_with("--gust", gust_at=gust_at)
    lasts = chosen(duration, wind.duration)
    return replace(
        wind,
        shape=chosen(shape, wind.shape),
        duration=lasts,
        peak=chosen(peak, wind.peak),
        heading=chosen(heading, wind.heading),
        gust=chosen(gust_of(gust, chosen(gust_at, 0.5 * lasts)), wind.gust),
    )


def limit_of(limit_deg: float | None) -> float | None:
    """Return the deflection limit [rad] of --limit-deg; None without it."""
    import numpy as np

    from tvclin.base.errors import within

    if limit_deg is None:
        return None
    return float(np.radians(within("--limit-deg", limit_deg, 1e-6, 90.0)))


def chosen(option: "T | None", otherwise: "T") -> "T":
    """Return an option, or what holds where it is not given."""
    return otherwise if option is None else option
