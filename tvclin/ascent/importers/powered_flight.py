"""The powered flight that another tool has simulated: its rows, their checks, and its schedule.

Numbers are in SI units. What would be silently wrong, as a mass in another unit, is refused with
its row. Rows are thinned until straight lines between them are close enough.

The slope of the normal force coefficient is a number, over Mach, or from another tool's table.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.atmosphere import pressure_notes
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base import errors
from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.base.lines import plural
from tvclin.base.sheet import Column, Heading, Headings, Sheet, letters, read_sheet
from tvclin.base.units import DEGREE
from tvclin.vehicle.vehicle import STANDARD_GRAVITY, Vehicle
from tvclin.winds.soundings.wind_table import SITE_ELEVATIONS

MIN_SLOPE = 0.5
"""A slope below this [1/rad] is taken for one per degree: slender bodies have 2 per radian."""
MAX_SLOPE = 100.0
"""A slope above this [1/rad] has no meaning: large fins on a thin body make 40."""
_MAX_CONSTANT_MACH = 0.3
"""Mach number up to which a slope hardly changes: below a table its first slope counts."""
_SLOPE = re.compile(r"c_?n_?([^\x00-\x7f]+|a|alpha)( .*)?", flags=re.IGNORECASE)

Slope = ArrayLike | str | PathLike[str] | tuple[ArrayLike, ArrayLike]


def slope_at_mach(slope_source: Slope, mach: FloatArray) -> Column:
    """Return the slope dC_N/dalpha [1/rad] at Mach numbers, ``(n,)``.

    `slope_source`: a number, a pair of Mach numbers and slopes, or a table that RASAero II or
    OpenRocket's component analysis exports. Of RASAero it is CN Potential at the smallest angle of
    attack over that angle: the slope at zero. Its CNalpha (0 to 4 deg) is a secant that holds
    viscous lift. Of OpenRocket's tables it is the column of the whole rocket. Straight lines
    between the Mach numbers of a pair or a file; `InputError` for some beyond them, except that
    below Mach 0.3 the first slope counts.
    """
    if isinstance(slope_source, str | PathLike):
        missing = (
            "names with Mach; give the table that RASAero II (aero plots) or OpenRocket (component"
            " analysis) exports over Mach"
        )
        sheet = read_sheet(slope_source, "a table of slopes over Mach", _at_mach_numbers, missing)
        potential = sheet.find("CN Potential")
        at, slope = _analysed(sheet) if potential is None else _potential(sheet, potential)
    elif isinstance(slope_source, tuple | list):
        if len(slope_source) != 2:
            raise errors.InputError(
                "normal_force_coefficient_slope must be a number [1/rad], a pair of Mach numbers"
                f" and slopes, or a file; got {errors.shown(slope_source)}"
            )
        row = errors.one_row("the Mach numbers of normal_force_coefficient_slope", slope_source[0])
        slopes = errors.one_row(
            "the slopes of normal_force_coefficient_slope", slope_source[1], "1/rad"
        )
        at, slope = _checked_slopes(row, slopes, "given over Mach")
    else:
        value = errors.number(
            "normal_force_coefficient_slope", slope_source, errors.nonnegative, "1/rad"
        )
        return Column(np.full(mach.shape, value), f"given, {value:g} per rad")
    if mach.max() > at[-1] or mach.min() < at[0] > _MAX_CONSTANT_MACH:
        raise errors.InputError(
            f"normal_force_coefficient_slope must cover the flight, Mach {mach.min():.3g} to"
            f" {mach.max():.3g}; got Mach {at[0]:.3g} to {at[-1]:.3g}"
        )
    return Column(np.interp(mach, at, slope.values), slope.origin)


def _at_mach_numbers(headings: Headings) -> float:
    """Return 1 if one of the first two headings of a line is the Mach number, else 0."""
    return float(any(set(heading.names) & {"mach", "machnumber"} for heading in headings[:2]))


def _potential(sheet: Sheet, heading: Heading) -> tuple[FloatArray, Column]:
    """Return Mach numbers, ``(n,)``, and slopes [1/rad] at them, of a table of RASAero II.

    They are CN Potential/Alpha at the smallest Alpha above zero. `sheet`: the table. `heading`:
    heading of the column CN Potential.
    """
    angle = sheet.find("Alpha")
    if angle is None:
        raise errors.InputError(f"{sheet.text.source} has no column Alpha beside {heading.text}")
    mach = sheet.numbers(_mach_of(sheet), "number").values
    alpha = sheet.numbers(angle, "angle", {"": DEGREE}).values
    force = sheet.numbers(heading, "number").values
    # smallest angle of attack above zero at each Mach number, and whether a row has it
    smallest = {m: min(alpha[(mach == m) & (alpha > 0.0)], default=np.nan) for m in np.unique(mach)}
    at_smallest = np.array([alpha[i] == smallest.get(mach[i]) for i in range(mach.size)])
    if not np.any(at_smallest):
        raise errors.InputError(
            f"{sheet.text.source} holds no angle of attack above zero; export it with Alpha 0, 2, 4"
        )
    origin = f"{sheet.text.source}, column {heading.text} over the smallest Alpha"
    mach, slope = mach[at_smallest], force[at_smallest] / alpha[at_smallest]
    order = np.argsort(mach, kind="stable")
    return _checked_slopes(mach[order], slope[order], origin)


def _analysed(sheet: Sheet) -> tuple[FloatArray, Column]:
    """Return Mach numbers, ``(n,)``, and slopes [1/rad] at them, of OpenRocket's analysis.

    The slopes are of all components: the only column of the `sheet`, or the sum of the others.
    """
    columns = [heading for heading in sheet.headings if _SLOPE.fullmatch(heading.name)]
    if not columns:
        nearest = [
            heading.text
            for heading in sheet.headings
            if letters(heading.name).startswith(("cn", "normal"))
        ]
        is_none = f"; {nearest[0]} is a coefficient, not its slope" if nearest else ""
        raise errors.InputError(
            f"{sheet.text.source} has no slope of the normal force coefficient{is_none}: it must"
            " have a column CN Potential (RASAero II) or CN alpha (OpenRocket's component analysis)"
        )
    slopes = [sheet.numbers(column, "per angle").values for column in columns]
    if len(columns) > 1 and not np.allclose(slopes[0], np.sum(slopes[1:], axis=0), rtol=1e-2):
        raise errors.InputError(
            f"{sheet.text.source} holds {len(columns)} columns CN alpha, the first of them not the"
            " sum of the others; export that of the whole rocket alone"
        )
    mach = sheet.numbers(_mach_of(sheet), "number").values
    return _checked_slopes(mach, slopes[0], f"{sheet.text.source}, column {columns[0].text}")


def _mach_of(sheet: Sheet) -> Heading:
    """Return the heading of the Mach number in a sheet that has it."""
    heading = sheet.find("Mach", "Mach number")
    assert heading is not None  # by `_at_mach_numbers`
    return heading


def _checked_slopes(mach: FloatArray, slope: FloatArray, origin: str) -> tuple[FloatArray, Column]:
    """Return Mach numbers and slopes [1/rad] at them, ``(n,)`` each; `InputError` if invalid.

    `origin`: where the slopes come from, in words.
    """
    if mach.shape != slope.shape or mach.size < 2:
        raise errors.InputError(
            "normal_force_coefficient_slope must hold as many slopes as Mach numbers, two or more;"
            f" got {slope.size} and {mach.size}"
        )
    finite_rows = np.isfinite(mach) & np.isfinite(slope)
    if not np.all(finite_rows) or np.any(np.diff(mach) <= 0.0) or np.any(slope < 0.0):
        raise errors.InputError(
            "the Mach numbers of normal_force_coefficient_slope must rise, and no slope may be"
            f" missing or negative; got another row in what is {origin}"
        )
    return mach, Column(slope, origin)


_BURNING = 0.05
"""Fraction of the largest thrust below which the motor counts as burnt out."""
_RESTARTED = 0.5
"""Fraction of the largest thrust above which a motor that was burnt out burns again."""
_MIN_POSITIVE, _MAX_SIZE = 1e-12, 1e12
"""Bounds of the numbers of a flight in SI units: of positive ones below, of all sizes above."""
_POSITIVE = {
    *("mass", "weight", "moment_of_inertia", "thrust", "velocity", "mach", "density", "pressure"),
    *("sound", "drag_coefficient", "dynamic_pressure", "reference_area", "temperature"),
}


@dataclass(frozen=True, eq=False, kw_only=True)
class Flight:
    """Rows of a flight, in the order of their times.

    `source`: name of the flight in messages. `places`: name of each row in messages. `columns`:
    numbers in SI units by name, NaN where one is missing, with `time`, `thrust` and `velocity`
    among them. `notes`: remarks for the reader.
    """

    source: str
    places: tuple[str, ...]
    columns: dict[str, Column]
    notes: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> FloatArray:
        """Return the numbers of the n rows in a column, by its name [SI], ``(n,)``."""
        return self.columns[name].values

    def origin(self, name: str) -> str:
        """Return the origin of a column, by its name, in words."""
        return self.columns[name].origin

    def noted(self, *notes: str) -> Flight:
        """Return the flight with further notes."""
        return replace(self, notes=(*self.notes, *notes))

    def with_columns(self, **columns: Column) -> Flight:
        """Return the flight with further columns."""
        return replace(self, columns=self.columns | columns)

    def require(self, good: BoolArray, say: Callable[[int], str]) -> None:
        """Raise `InputError` about the first row that is not good.

        `good`: whether each row is, ``(n,)``. `say`: function from the index of a row to a message.
        """
        if not np.all(good):
            i = int(np.argmin(good))
            raise errors.InputError(f"{self.places[i]}: {say(i)}")

    def rows(self, index: IndexArray) -> Flight:
        """Return some rows of the flight; `index`: their indices, in the order of the result."""
        columns = {k: Column(c.values[index], c.origin) for k, c in self.columns.items()}
        return replace(self, places=tuple(self.places[i] for i in index), columns=columns)


def powered(
    flight: Flight, start: float | None, stop: float | None, free: BoolArray | None = None
) -> Flight:
    """Return the rows of one burn; `InputError` where a number of them is missing.

    It begins with the first row that moves in free flight with thrust, and ends before the first
    with less than 5 percent of the largest thrust. `start`, `stop`: earliest and latest time [s].
    `free`: whether each row is in free flight, off the rod; by default every row is.
    """
    time, thrust = flight["time"], flight["thrust"]
    flight.require(np.isfinite(time), lambda _: "the time is missing")
    flight.require(
        np.append(True, np.diff(time) >= 0.0),
        lambda i: f"the time must rise; got {time[i]:g} s after {time[i - 1]:g} s",
    )
    low = -np.inf if start is None else errors.number("start", start, unit="s")
    high = np.inf if stop is None else errors.number("stop", stop, unit="s")
    inside = (time >= low) & (time <= high)
    last_of_time = np.append(np.diff(time) > 0.0, True)  # of rows at one time the last counts
    index = np.flatnonzero(inside & last_of_time)
    thrust_or_zero = np.nan_to_num(thrust[index], nan=0.0)
    largest = max(thrust_or_zero, default=0.0)
    if not largest > 0.0:
        raise errors.InputError(
            f"{flight.source} has no thrust between start and stop; give the times of a burn"
        )
    burnt_out = np.isfinite(thrust[index]) & (thrust_or_zero < _BURNING * largest)
    moving = ~(flight["velocity"][index] <= 0.0)  # so is a row whose speed is missing
    launched = True if free is None else free[index]
    flying = np.flatnonzero(~burnt_out & moving & launched)
    if not flying.size:
        raise errors.InputError(
            f"{flight.source} has no row of a free flight with thrust: where the motor burns, the"
            " centre of pressure or the speed is missing or zero in every row"
        )
    first = flying[0]
    after = np.flatnonzero(burnt_out[first:])
    end = first + after[0] if after.size else index.size
    burn = flight.rows(index[first:end])
    for name, column in burn.columns.items():
        _check_numbers(burn, name, column)
    if len(burn.places) < 2:
        raise errors.InputError(
            f"{flight.source} must hold two or more rows of powered flight; got {len(burn.places)}"
        )
    return burn.noted(*_omitted(flight, inside & ~last_of_time, index, first, end))


def _check_numbers(flight: Flight, name: str, column: Column) -> None:
    """Raise `InputError` for a number of a column that is missing or impossible.

    `flight`: the flight of the column. `name`: its quantity, on which the rule depends.
    """
    values = column.values
    flight.require(
        np.isfinite(values),
        lambda _: f"there is no number in {column.origin}, while the motor burns",
    )
    smallest, rule = -_MAX_SIZE, "must be a plausible number"
    if name in _POSITIVE:
        smallest, rule = _MIN_POSITIVE, "must be positive"
    flight.require(
        (values >= smallest) & (values <= _MAX_SIZE),
        lambda i: f"{column.origin} {rule}; got {values[i]:.6g} in SI units",
    )


def _omitted(
    flight: Flight, repeated: BoolArray, index: IndexArray, first: int, end: int
) -> list[str]:
    """Return notes on the powered flight, and on the rows of a file that are omitted.

    `flight`: all rows of the file. `repeated`: whether the row after each row of the file has the
    same time. `index`: rows of distinct times, ``(n,)``. `first`, `end`: the powered flight is
    ``index[first:end]``.
    """
    time = flight["time"][index]
    notes = [
        f"powered flight from {time[first]:g} to {time[end - 1]:g} s: {plural(end - first, 'row')}"
    ]
    if first:
        notes.append(
            f"{plural(first, 'row')} before it left out: on the launch rod, or without thrust"
        )
    if end < time.size:
        notes.append(
            f"{plural(time.size - end, 'row')} after it left out: thrust below"
            f" {100 * _BURNING:g} percent of its largest from {time[end]:g} s on"
        )
        thrust = flight["thrust"][index]
        restarted = np.nan_to_num(thrust[end:]) > _RESTARTED * max(thrust)
        if np.any(restarted):
            notes.append(
                f"the thrust comes back at {time[end + int(np.argmax(restarted))]:g} s: that"
                " burn is read with start (--from) at that time"
            )
    if np.any(repeated):
        count = int(np.sum(repeated))
        notes.append(f"{plural(count, 'row')} at the time of the next row left out")
    return notes


_MAX_ANGLE_OF_ATTACK = np.radians(2.0)
"""Angle of attack [rad] above which body lift moves the centre of pressure."""
_MAX_PATH_DIFFERENCE = np.radians(10.0)
"""Largest angle [rad] between attitude and flight path of a simulation without wind."""
_THRUST_OVER_WEIGHT = (0.2, 500.0)
"""Smallest and largest ratio, at its best, from upper stages to small rockets."""
_RADIUS_OVER_ARM = (0.1, 3.0)
"""Smallest and largest radius of gyration over the control arm; slender bodies have 0.5 to 1."""
_MIN_EXHAUST_SPEED = 500.0
"""Exhaust speed [m/s] below the slowest of motors: faster loss of mass is a separation."""
_MASS_ROUNDING = 2e-3
"""Rounding of a mass with four digits or three decimals, over the mass."""
_MAX_GIMBAL_OVER_GRAVITY = 5.0
"""Largest station of a gimbal in metres, relative to the centre of gravity."""


def _check_angle_of_attack(flight: Flight) -> None:
    """Raise `InputError` for an angle of attack of a flight above 2 deg.

    Beyond it slope and centre of pressure are not those at zero.
    """
    angle, time = np.abs(flight["angle_of_attack"]), flight["time"]
    flight.require(
        angle <= _MAX_ANGLE_OF_ATTACK,
        lambda i: (
            f"the angle of attack is {np.degrees(angle[i]):.3g} deg at {time[i]:g} s, beyond the 2"
            " deg up to which slope and centre of pressure are those of the linear vehicle;"
            " simulate without wind, or leave these rows out with start and stop"
        ),
    )


def _check_attitude(flight: Flight, attitude: FloatArray) -> None:
    """Raise `InputError` for an attitude [rad] of n rows far from the path of a flight."""
    path = np.arcsin(np.clip(flight["climb"] / flight["velocity"], -1.0, 1.0))
    flight.require(
        np.abs(path - attitude) <= _MAX_PATH_DIFFERENCE,
        lambda i: (
            f"the attitude is {np.degrees(attitude[i]):.3g} deg and the path"
            f" {np.degrees(path[i]):.3g} deg above the horizon; without wind they are near each"
            " other, so check that the attitude is not from the vertical"
        ),
    )


def _check_gimbal(flight: Flight, gimbal: FloatArray, gravity: FloatArray) -> None:
    """Raise `InputError` for a gimbal ahead of the centre of gravity, and one not in metres.

    `gimbal`, `gravity`: stations [m] from the nose tip at each row of the flight, ``(n,)``.
    """
    forward = np.flatnonzero(gravity >= gimbal)
    if forward.size:
        i = forward[0]
        raise errors.InputError(
            f"gimbal_station must lie behind the centre of gravity, {gravity[i]:.4g} m from the"
            f" nose tip at {flight['time'][i]:g} s; got {gimbal[i]:.6g} m"
        )
    if gimbal.max() > _MAX_GIMBAL_OVER_GRAVITY * gravity.max() > 0.0:
        raise errors.InputError(
            f"gimbal_station must be in m from the nose tip, and the centre of gravity is"
            f" {gravity.max():.4g} m from it; got {gimbal.max():.6g} m (is it in cm, or in inches?)"
        )


def _check_slope(slope: FloatArray) -> None:
    """Raise `InputError` for slopes [1/rad] too large, or all too small, for bodies with fins."""
    if slope.max() > MAX_SLOPE:
        raise errors.InputError(
            f"normal_force_coefficient_slope must be per radian, at most {MAX_SLOPE:g} with large"
            f" fins; got {slope.max():.4g} (was it turned from degrees twice?)"
        )
    if slope.max() < MIN_SLOPE:
        raise errors.InputError(
            f"normal_force_coefficient_slope must be per radian, and slender bodies have about 2;"
            f" got at most {slope.max():.4g} (a coefficient, or per degree: then times 57.3?)"
        )


def _check_masses(flight: Flight, weight: FloatArray) -> None:
    """Raise `InputError` for a mass in another unit, and for a stage that falls off.

    `weight`: weight [N] at each row of the flight, ``(n,)``.
    """
    ratio = flight["thrust"] / weight  # at its best it must be that of a booster
    best = int(np.argmax(ratio))
    smallest, largest = _THRUST_OVER_WEIGHT
    if not smallest <= ratio[best] <= largest:
        raise errors.InputError(
            f"{flight.places[best]}: thrust over weight must be between {smallest:g} and"
            f" {largest:g} for a booster; got {ratio[best]:.3g}, so check the units of mass and"
            " thrust"
        )
    # m' = -T/c: the most that a step burns, at the smallest exhaust speed c, and the rounding
    mass = weight / STANDARD_GRAVITY
    thrust = np.maximum(flight["thrust"][:-1], flight["thrust"][1:])
    most_burnt = thrust * np.diff(flight["time"]) / _MIN_EXHAUST_SPEED + _MASS_ROUNDING * mass[:-1]
    flight.require(
        np.append(True, -np.diff(mass) <= most_burnt),
        lambda i: (
            f"the mass falls from {mass[i - 1]:.5g} to {mass[i]:.5g} kg, more than the motor burns,"
            " so a stage leaves; read one stage with start and stop"
        ),
    )


def _check_inertia(
    flight: Flight, inertia: FloatArray, weight: FloatArray, arm: FloatArray
) -> None:
    """Raise `InputError` for an inertia in another unit, or about another axis.

    `inertia`, `weight`, `arm`: moment of inertia [kg m^2], weight [N] and control arm [m] at each
    row of the flight, ``(n,)``.
    """
    errors.positive("moment_of_inertia", inertia, "kg m^2")
    size = np.abs(arm)
    ratio = np.sqrt(inertia * STANDARD_GRAVITY / weight) / size  # radius of gyration over the arm
    smallest, largest = _RADIUS_OVER_ARM
    flight.require(
        (ratio >= smallest) & (ratio <= largest),
        lambda i: (
            f"the radius of gyration, {ratio[i] * size[i]:.3g} m, must be between {smallest:g} and"
            f" {largest:g} times the control arm, {size[i]:.3g} m; check the unit of the moment of"
            " inertia, and that it is about the transverse axis"
        ),
    )


MOST_ROWS = 200
"""Largest number of rows of a schedule, unless specified."""
_LINE_TOLERANCE = 1e-3
"""Rows are added until straight lines between them are so close, in parts of the largest."""
_NOT_OF_VEHICLE = ("altitude", "nominal_deflection")
"""Columns of a schedule that are not fields of its vehicle."""
_FIELDS = (
    *("weight", "moment_of_inertia", "normal_force_slope", "thrust", "aerodynamic_arm"),
    *("control_arm", "axial_force", "velocity", "attitude", "pitch_damping", *_NOT_OF_VEHICLE),
)
"""Columns of a schedule beyond its time, in the order of its notes."""
_COMPUTED = ("weight", "normal_force_slope", "aerodynamic_arm", "control_arm", "axial_force")
"""Columns that are computed from others where a flight does not have them."""


def schedule_of_flight(flight: Flight, name: str, max_rows: int = MOST_ROWS) -> FlightSchedule:
    """Return the schedule of a powered flight, whose columns are the quantities of `read_table`.

    `name`: name of the vehicle. `max_rows`: largest number of rows. The speed upwards, `climb`, is
    compared with the attitude where it is given. `InputError` for implausible numbers.
    """
    largest = errors.whole_number("max_rows", max_rows)
    if largest < 2:
        raise errors.InputError(f"max_rows must be 2 or more; got {largest}")
    # fields of the vehicle, altitude and deflection: given, or computed from other columns
    columns = {
        key: flight.columns[key] if key in flight.columns else _computed(flight, key)
        for key in _FIELDS
        if key in flight.columns or key in _COMPUTED
    }
    values = {key: column.values for key, column in columns.items()}
    if "angle_of_attack" in flight.columns:
        _check_angle_of_attack(flight)
    if "climb" in flight.columns:
        _check_attitude(flight, values["attitude"])
    _check_masses(flight, values["weight"])
    _check_inertia(flight, values["moment_of_inertia"], values["weight"], values["control_arm"])
    time = flight["time"]
    rows, error = thinned_rows(time, values, largest)
    others: dict[str, Any] = {
        key: values.pop(key)[rows] for key in _NOT_OF_VEHICLE if key in values
    }
    numbers: dict[str, Any] = {key: column[rows] for key, column in values.items()}
    vehicle = Vehicle(name=name, time=time[rows], **numbers)
    notes = [f"time: {flight.origin('time')}"]
    notes += [f"{key}: {column.origin}" for key, column in columns.items()]
    notes += flight.notes
    if rows.size < time.size:
        within = f"straight lines are within {100 * error:.2g} percent"
        notes.append(f"thinned to {rows.size} rows: {within}")
    notes += _stable(vehicle)
    names = ("time", "dynamic_pressure", "velocity", "altitude")
    if set(names) <= flight.columns.keys():  # forces are computed from the pressure
        notes += pressure_notes(*(flight[name] for name in names))
    return FlightSchedule(vehicle, **others, notes=tuple(notes))


def _computed(flight: Flight, name: str) -> Column:
    """Return one of the columns `_COMPUTED` [SI] of a flight, by its name, from other columns.

    The weight is that of the mass. Arms are of stations from the nose tip aft, l_a = x_CG - x_CP,
    negative where the flight is stable, and l_c = x_gimbal - x_CG. Forces are q S, dynamic pressure
    times reference area, times a coefficient: N [N/rad] by the slope dC_N/dalpha, F_A by C_A.
    """
    columns = flight.columns
    if name == "weight":
        mass = columns["mass"]
        return Column(mass.values * STANDARD_GRAVITY, f"{mass.origin} times 9.80665 m/s^2")
    if name == "aerodynamic_arm":
        return _difference(columns["gravity_station"], columns["pressure_station"])
    if name == "control_arm":
        gimbal, gravity = columns["gimbal_station"], columns["gravity_station"]
        _check_gimbal(flight, gimbal.values, gravity.values)
        return _difference(gimbal, gravity)
    if name == "axial_force":
        symbol, coefficient = "C_A", columns["axial_force_coefficient"]
    else:
        symbol, coefficient = "dC_N/dalpha", columns["normal_force_coefficient_slope"]
        _check_slope(coefficient.values)
    q, area = columns["dynamic_pressure"], columns["reference_area"]
    return Column(
        q.values * area.values * coefficient.values,
        f"q S {symbol}; q = {q.origin}; S = {area.origin}; {symbol} = {coefficient.origin}",
    )


def _difference(minuend: Column, subtrahend: Column) -> Column:
    """Return the difference of two columns."""
    origin = f"{minuend.origin} less {subtrahend.origin}"
    return Column(minuend.values - subtrahend.values, origin)


def specified_slope(flight: Flight, slope: Slope) -> Column:
    """Return a specified slope [1/rad] at the Mach number of each row of a flight."""
    column = slope_at_mach(slope, flight["mach"])
    _check_slope(column.values)
    return column


def specified_gimbal(flight: Flight, station: float) -> Column:
    """Return the station of a gimbal [m] at each row of a flight."""
    return Column(np.full(len(flight.places), station), f"gimbal at {station:g} m, given,")


def above_sea(above_ground: Column, source: str, ground: float | None) -> Column:
    """Return altitudes above the sea [m] of those above the ground.

    `source`: name of their file. `ground`: elevation of the site [m]; `InputError` for None.
    """
    if ground is None:
        raise errors.InputError(
            f"{source} has altitudes above the ground, and winds are above the sea: give ground,"
            " the elevation of the launch site in m (0 at the sea)"
        )
    site = errors.number("ground", ground, errors.between(*SITE_ELEVATIONS), "m")
    return Column(above_ground.values + site, f"{above_ground.origin}, plus {site:g} m of ground")


def _stable(vehicle: Vehicle) -> tuple[str, ...]:
    """Return a note on times at which the vehicle is aerodynamically stable."""
    arm = np.asarray(vehicle.aerodynamic_arm)
    if np.all(arm > 0.0):
        return ()
    if np.all(arm <= 0.0):
        return (
            "stable throughout: the centre of pressure lies behind the centre of gravity, and a"
            " fixed path needs no deflection; does the vehicle that is steered have these fins?",
        )
    count = int(np.sum(arm <= 0.0))
    return (f"stable at {count} of {arm.size} times, where a fixed path needs no deflection",)


def thinned_rows(
    time: FloatArray, values: dict[str, FloatArray], largest: int
) -> tuple[IndexArray, float]:
    """Return the indices of thinned rows, and the largest error of lines between them.

    The error is relative to the largest value of a column. `time`, `values`: times [s] and columns,
    ``(n,)`` each. Up to a number of `largest` all rows are returned; else the first and the last,
    and repeatedly the row of largest error, until it is below a thousandth.
    """
    if time.size <= largest:
        return np.arange(time.size), 0.0
    sizes = {key: float(np.abs(value).max()) for key, value in values.items()}
    columns = np.array([values[key] / size for key, size in sizes.items() if size > 0.0])
    selected = np.array([0, time.size - 1])
    while True:
        lines = np.array([np.interp(time, time[selected], column[selected]) for column in columns])
        error = np.abs(lines - columns).max(axis=0)
        worst = int(np.argmax(error))
        if error[worst] <= _LINE_TOLERANCE or selected.size >= largest:
            return selected, float(error[worst])
        selected = np.sort(np.append(selected, worst))
