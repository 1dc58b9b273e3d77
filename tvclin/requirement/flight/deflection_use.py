"""Required, used and remaining deflection by flight time, and the autopilot requirement.

The latter is the smallest limit above which this autopilot survives with every limit, flown along
the flight with its samples, delay, filters, bending and rate limit, at the dynamic pressure
encountered. At one frozen time it is `autopilot_requirement`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.wind_along import WindAlong, sounding_along, wind_along
from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Column, Columns, Shown, Tabled, table
from tvclin.base.fields import spec
from tvclin.base.lines import Line, Table, degrees, significant
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.gain_schedule import GainSchedule
from tvclin.flights.closed_loop.flown_flights import checked_flight, limit_of_flight
from tvclin.flights.closed_loop.fly_along import FlightAlong
from tvclin.flights.closed_loop.survival_limit import OPEN
from tvclin.requirement.flight.flight_winds import PlacedWind, WindOf, named_winds, place, placings
from tvclin.requirement.flight.sizing import Sizing, flight_times
from tvclin.requirement.required_quantity import heading_of
from tvclin.vehicle.coefficients import PLANES
from tvclin.winds.wind_angles import FROZEN, SIGNS


@dataclass(frozen=True, eq=False)
class AutopilotRequirements(Shown):
    """Autopilot requirements over a flight.

    Attributes
    ----------
    times : ndarray
        Flight times [s], ``(n,)``.
    winds : tuple of str
        Names of the winds.
    limit : ndarray
        Autopilot requirements [rad], ``(n, m)``: the larger of head and tail wind for a pulse.
        Infinite where no limit up to twice the largest trim deflection survives, NaN where the
        requirement is not known.
    reasons : tuple of str
        Reasons why requirements are not known or not certain; often none.
    """

    times: FloatArray = field(metadata=spec("time"))
    winds: tuple[str, ...] = field(metadata=spec())
    limit: FloatArray = field(metadata=spec("angle"))
    reasons: tuple[str, ...] = field(metadata=spec())

    @property
    def at_times(self) -> FloatArray:
        """Requirement [rad] in the worst wind of each time, ``(n,)``; NaN if one is not known."""
        return np.max(self.limit, axis=1)


def autopilot_requirements(
    sizing: Sizing,
    autopilot: Autopilot | GainSchedule,
    winds: WindOf | Mapping[str, WindOf],
    *,
    rate_limit: float = np.inf,
    sign: str | None = None,
    placing: str | Mapping[str, str] = "peak",
    window: float = 20.0,
    progress: Callable[[int, int], None] | None = None,
) -> AutopilotRequirements:
    """Return the autopilot requirement of each wind at each flight time of a sizing.

    It is the smallest deflection limit [rad] above which the autopilot survives with every limit.

    Parameters
    ----------
    sizing : Sizing
        Flight, flight times, model and plane; of one plane.
    autopilot : Autopilot or GainSchedule
        Autopilot with a sample rate.
    winds, placing, window, progress
        As they were given to `size`. Each wind is flown from its onset to the end of the flight.
    rate_limit : float
        Rate limit [rad/s], positive.
    sign : {"head", "tail", "frozen"}, optional
        Direction of pulses in the pitch plane, by default the worse of head and tail wind;
        "frozen" for the nominal dynamic pressure.

    Raises
    ------
    InputError
        For a sizing of both planes, other winds than its own, and as `size` and `fly_along`.
    """
    if progress is not None:
        errors.callable_for("progress", progress, "of how many are done and how many there are")
    errors.instance("sizing", sizing, Sizing, "see size")
    plane = errors.one_of("the plane of the sizing", sizing.plane, PLANES)
    by_name = named_winds(winds)
    if tuple(by_name) != sizing.winds:
        raise errors.InputError(
            f"winds must be those of the sizing, {', '.join(sizing.winds)}; got"
            f" {', '.join(by_name)}"
        )
    if sign is not None:
        errors.one_of("sign", sign, (*SIGNS, FROZEN))
    signs = tuple(SIGNS) if sign is None and plane == "pitch" else (sign,)  # head and tail, or one
    width = errors.number("window", window, errors.positive, "s")
    max_rate = errors.unlimited("rate_limit", rate_limit, unit="rad/s")
    flight, placed_as = sizing.schedule, placings(by_name, placing)
    limit = np.full((sizing.times.size, len(by_name)), np.nan)
    unknown_at: dict[tuple[str, str], list[float]] = {}  # flight times [s] by wind and reason
    pairs = [(i, j) for i in range(sizing.times.size) for j in range(len(by_name))]
    for done, (i, j) in enumerate(pairs, start=1):
        name, time = sizing.winds[j], float(sizing.times[i])
        try:
            placed = place(by_name[name], flight.at(time).rigid, time, placed_as[name], width)
            for wind in _encountered(sizing, placed, plane, signs):
                begin = max(float(wind.history.onset), flight.span[0])
                along = checked_flight(
                    flight, autopilot, wind, begin, stop=None, model=sizing.model, plane=plane
                )
                scan = limit_of_flight(along, max_rate)
                if np.isinf(scan.limit) and OPEN in scan.status:  # no limit tried survives
                    raise errors.NotKnownError(scan.status)
                limit[i, j] = np.fmax(limit[i, j], scan.limit)  # the larger of head and tail wind
        except errors.NotKnownError as error:
            limit[i, j] = np.nan
            unknown_at.setdefault((name, str(error)), []).append(time)
        if progress is not None:
            progress(done, len(pairs))
    reasons = (f"{wind} at {flight_times(at)}: {why}" for (wind, why), at in unknown_at.items())
    return AutopilotRequirements(
        times=sizing.times, winds=sizing.winds, limit=limit, reasons=tuple(reasons)
    )


def _encountered(
    sizing: Sizing, placed: PlacedWind, plane: str, signs: tuple[str | None, ...]
) -> list[WindAlong]:
    """Return a placed wind as the flight of a sizing encounters it, by possible directions.

    `plane`: plane of its angle. `signs`: directions of a pulse, "head", "tail" or None for a cross
    wind, or "frozen" for the nominal dynamic pressure; a sounding, of one sign or both, has its own
    direction. `NotKnownError` for a wind that is calm or not known.
    """
    if not placed.known:
        raise errors.NotKnownError(placed.why or "the wind is not known")
    if placed.calm:
        raise errors.NotKnownError("the wind is calm")
    if placed.speeds is not None:  # a sounding, with the wind speeds of both planes
        history = placed.two_sided or placed.history  # `two_sided`: with both signs, else None
        speeds = None if signs == (FROZEN,) else placed.speeds
        return [sounding_along(history, speeds, plane, sizing.schedule.span)]
    try:
        return [wind_along(sizing.schedule, placed.in_flight, plane, sign) for sign in signs]
    except errors.InputError as error:  # no horizontal wind has the angle on this path
        raise errors.NotKnownError(str(error)) from None


@dataclass(frozen=True, eq=False)
class DeflectionUse(Tabled):
    """Deflections by flight time: required, lower bounds, used by an autopilot, and remaining.

    Attributes
    ----------
    times : ndarray
        Flight times of the sizing [s], rising, ``(n,)``.
    required : dict of str to ndarray
        Requirements and lower bounds [rad] by their labels, the worst wind at each time, ``(n,)``;
        "autopilot" is the autopilot's, for every limit above which it survives.
    used : ndarray
        Largest deflection [rad] of the flight from the middle between two times to the next,
        ``(n,)``; NaN where it does not fly.
    remaining : ndarray
        Available deflection [rad] minus the largest of these, ``(n,)``; NaN where one is not known.
    limit : float
        Available deflection [rad].
    reasons : tuple of str
        Reasons why autopilot requirements are not known; often none.
    """

    times: FloatArray = field(metadata=spec("time"))
    required: dict[str, FloatArray]
    used: FloatArray = field(metadata=spec("angle"))
    remaining: FloatArray = field(metadata=spec("angle"))
    limit: float = field(metadata=spec("angle"))
    reasons: tuple[str, ...] = field(default=(), metadata=spec())

    @property
    def by_heading(self) -> dict[str, FloatArray]:
        """Requirements, used and remaining deflection [rad] at n flight times, by heading."""
        required = {heading_of(label): values for label, values in self.required.items()}
        return {**required, "used": self.used, "remaining": self.remaining}

    def table(self) -> Table:
        """Return the table of deflections [deg] by heading, a row for each flight time."""
        values = self.by_heading
        rows: list[tuple[Line, ...]] = [
            (
                significant(f"use.{k}.time", time),
                *(degrees(f"use.{k}.{name}", column[k]) for name, column in values.items()),
            )
            for k, time in enumerate(self.times)
        ]
        return Table(
            "Required, used and remaining deflection [deg]", ("time [s]", *values), tuple(rows)
        )

    def _repr_html_(self) -> str:
        """Return the table of all times in HTML, for notebooks."""
        return table(self.table())

    def _columns(self) -> Columns:
        """Return the requirements, the used and the remaining deflection [rad] over the time."""
        columns = [
            Column(f"required_{label.replace(' ', '_')}", values, "rad")
            for label, values in self.required.items()
        ]
        columns += [Column(name, getattr(self, name), "rad") for name in ("used", "remaining")]
        return Columns((Column("time", self.times, "s"),), tuple(columns), {"limit": self.limit})


def deflection_use(
    sizing: Sizing,
    flown: FlightAlong | ArrayLike,
    limit: float,
    requirements: AutopilotRequirements | None = None,
    labels: Sequence[str] | None = None,
) -> DeflectionUse:
    """Return required, used and remaining deflection by flight time.

    Parameters
    ----------
    sizing : Sizing
        Requirements by flight time.
    flown : FlightAlong or array_like
        Flight of an autopilot through the wind; or its largest deflection [rad] in the wind of each
        flight time, ``(n,)``, NaN where not known.
    limit : float
        Available deflection [rad], within 90 degrees.
    requirements : AutopilotRequirements, optional
        Autopilot requirements at the times of the sizing, with the label "autopilot".
    labels : sequence of str, optional
        Labels of the requirements and lower bounds of the sizing that count, by default all.

    Raises
    ------
    InputError
        For a limit out of range, unknown labels, and requirements or deflections at other times.
    """
    errors.instance("sizing", sizing, Sizing, "see size")
    available = errors.limit_angle(limit, "limit")
    order = np.argsort(sizing.times)
    times = sizing.times[order]
    every = tuple(r.label for r in sizing.required)
    names = every if labels is None else errors.each("labels", labels, str, "of sizing.required")
    required = {str(name): sizing.at_times(name)[order] for name in names}
    reasons: tuple[str, ...] = ()
    if requirements is not None:
        errors.instance(
            "requirements", requirements, AutopilotRequirements, "see autopilot_requirements"
        )
        if not np.array_equal(requirements.times, sizing.times):
            raise errors.InputError("requirements must be at the flight times of the sizing")
        required["autopilot"], reasons = requirements.at_times[order], requirements.reasons
    if isinstance(flown, FlightAlong):
        used = used_around(flown, times)
    else:
        used = errors.numbers("flown", flown)
        if used.shape != times.shape:
            raise errors.InputError(
                f"flown must be a flight, see fly_along, or a deflection for each of the"
                f" {times.size} flight times; got shape {used.shape}"
            )
        used = used[order]
    largest = np.max([*required.values(), used], axis=0)  # NaN where one is not known
    return DeflectionUse(
        times=times,
        required=required,
        used=used,
        remaining=available - largest,
        limit=available,
        reasons=reasons,
    )


def used_around(flown: FlightAlong, times: FloatArray) -> FloatArray:
    """Return the largest deflection [rad] of a flight around each of rising flight times ``(n,)``.

    `flown`: the flight of an autopilot. A time counts from the middle to the time before to the
    middle to the next; NaN where the flight does not fly.
    """
    edges = np.concatenate([[-np.inf], 0.5 * (times[1:] + times[:-1]), [np.inf]])
    sizes = np.abs(flown.outputs["deflection"])
    nearest = np.searchsorted(edges, flown.times, side="right") - 1  # index of the flight time
    used = np.array([sizes[nearest == k].max(initial=-np.inf) for k in range(times.size)])
    within = (times >= flown.times[0]) & (times <= flown.times[-1])
    return np.where(within & np.isfinite(used), used, np.nan)
