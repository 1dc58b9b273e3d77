"""Sizing of a flight: the required deflection of each wind at each flight time.

Both planes with one limit shape are made of each plane and of the winds' vectors.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.errors import InputError, callable_for, finite, flag, instance, one_of, within
from tvclin.boundary.limit_shapes import LimitShape, limit_shape_of
from tvclin.boundary.optimum.two_poles import single_pole_validity
from tvclin.kernels.choice import repeated
from tvclin.linear.plant import DEFAULT_MODEL, MODELS, ONE_POLE, Plant
from tvclin.requirement.flight.flight_requirement import (
    LAWS,
    FlightMode,
    FlightRequirement,
    FlightWind,
    FrozenRequirement,
    flight_requirement,
    frozen_requirement,
)
from tvclin.requirement.flight.flight_winds import (
    PlacedWind,
    WindOf,
    angle_at,
    concurrent_trim,
    named_winds,
    place_in,
    placings,
)
from tvclin.requirement.flight.sizing import (
    Sizing,
    beyond_one_pole,
    doubtful_winds,
    flight_times,
    notes_of,
    unknown_rows,
)
from tvclin.requirement.plane_requirement import VectorRequirement, rectangle, vector_requirements
from tvclin.requirement.required_quantity import MINIMUM, NO_FORECAST, TRIM, Requirement
from tvclin.vehicle.coefficients import BOTH, PLANES, Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.wind_angles import NominalWind


def in_both_planes(
    parts: dict[str, Sizing],
    vehicles: list[Vehicle],
    placed: list[list[dict[str, PlacedWind]]],
    stop: LimitShape,
    counted: Callable[[Any], Any],
) -> Sizing:
    """Return the sizing of both planes from the sizings of each, without notes.

    `vehicles` has one for each flight time, and `placed` for each the winds by planes. `counted`
    returns its argument and counts it for the progress.
    """
    pitch, yaw = (parts[plane] for plane in PLANES)
    beyond = pitch.beyond_one_pole | yaw.beyond_one_pole
    bands = pitch.dead_bands
    needs = [
        [
            counted(_vector(vehicle, pitch.model, wind, bool(beyond[i, j]), stop, bands))
            for j, wind in enumerate(row)
        ]
        for i, (vehicle, row) in enumerate(zip(vehicles, placed, strict=True))
    ]
    arises = {name: _arises_in_both(pitch, yaw, name) for name in {**pitch.arises, **yaw.arises}}
    required, more = _required(pitch, yaw, needs, stop, arises)
    refused = [[bool(one.notes) and not one.trim for one in row] for row in needs]
    spoken = [one for i, j in np.argwhere(more | np.array(refused)) for one in needs[i][j].notes]
    said = (*pitch.said, *yaw.said, *spoken)
    slow = np.where(beyond_one_pole(yaw.slow_mode), yaw.slow_mode, pitch.slow_mode)
    return Sizing(
        **{name: getattr(pitch, name) for name in ("schedule", "times", "winds", "dead_bands")},
        **{name: getattr(pitch, name) for name in ("law", "model", "known_times", "known")},
        required=required,
        plane=BOTH,
        begins=np.fmin(pitch.begins, yaw.begins),
        ends=np.fmax(pitch.ends, yaw.ends),
        change=np.maximum(pitch.change, yaw.change),
        covered=pitch.covered & yaw.covered,
        slow_mode=slow,
        edge=np.fmin(pitch.edge, yaw.edge),
        said=tuple(dict.fromkeys(said)),
        notes=(),
        separate=parts,
        arises=arises,
        stop=stop,
    )


def _arises_in_both(pitch: Sizing, yaw: Sizing, name: Requirement) -> FloatArray:
    """Return when a number of a fixed wind arises [s]: in the plane of the larger, ``(m,)``."""
    times = [one.arising(name) for one in (pitch, yaw)]
    sizes = [np.nanmax(one.required[name], axis=0, initial=0.0) for one in (pitch, yaw)]
    in_pitch = np.isnan(times[1]) | ((sizes[0] >= sizes[1]) & ~np.isnan(times[0]))
    return np.where(in_pitch, *times)


def _required(
    pitch: Sizing,
    yaw: Sizing,
    needs: list[list[VectorRequirement]],
    stop: LimitShape,
    arises: dict[Requirement, FloatArray],
) -> tuple[dict[Requirement, FloatArray], BoolArray]:
    """Return the requirements [rad] of both planes, and where the wind vector requires more.

    Of the trim, the minimum and the bound without a forecast the larger of both planes counts, of
    dead bands the corner of both; and the requirement of the wind's vector, if it is larger.
    """
    known = [name for name in pitch.required if name in yaw.required]
    held = {name: rectangle(stop, pitch.required[name], yaw.required[name]) for name in known}
    sides = stop.support(np.array([1.0, 1j, -1.0, -1j])).reshape(2, 2).max(axis=0)
    alone = {  # a stop reaches no further in a plane than its support
        name: np.maximum(pitch.required[name] / sides[0], yaw.required[name] / sides[1])
        for name in known
    }
    required = dict(held)
    required[TRIM] = _larger(alone[TRIM], needs, lambda one: one.trim)
    required[MINIMUM] = _larger(alone[MINIMUM], needs, lambda one: one.minimum)
    if pitch.law == "bound":
        required[NO_FORECAST] = _larger(alone[NO_FORECAST], needs, lambda one: one.no_forecast)
    names = [Requirement(dead_band=K) for K in pitch.dead_bands]
    for k, name in enumerate(names):
        required[name] = _larger(held[name], needs, lambda one, k=k: one.required[k])
        if (along := replace(name, varying=True)) in held:  # what the vector requires besides
            beyond_planes = np.divide(
                required[name], held[name], out=np.ones(held[name].shape), where=held[name] > 0.0
            )
            fixed = (
                ~np.isnan(arises[along]) if along in arises else np.zeros(len(pitch.winds), bool)
            )
            whole = np.nanmax(beyond_planes, axis=0, initial=1.0)  # one number for the flight
            required[along] = held[along] * np.where(fixed, whole, beyond_planes)
    return required, np.any([required[name] > held[name] for name in names], axis=0)


def _vector(
    vehicle: Vehicle,
    model: str,
    wind: dict[str, PlacedWind],
    beyond: bool,
    stop: LimitShape,
    bands: FloatArray,
) -> VectorRequirement:
    """Return the requirements of the wind vector; zeros where one plane alone has wind."""
    if any(one.calm for one in wind.values()):
        nothing = np.zeros(bands.shape)
        return VectorRequirement(0.0, nothing, 0.0, 0.0, ())
    pitch, yaw = (Plant.from_vehicle(vehicle, model, plane) for plane in PLANES)
    both = PlaneWind(**{plane: one.history for plane, one in wind.items()})
    found = vector_requirements(pitch, yaw, both, stop, bands)
    if not (beyond and model in ONE_POLE):
        return found
    pitch, yaw = (Plant.from_vehicle(vehicle, "drift-exact", plane) for plane in PLANES)
    exact = vector_requirements(pitch, yaw, both, stop, bands)
    required = np.maximum(found.required, exact.minimum)
    return VectorRequirement(found.trim, required, found.no_forecast, exact.minimum, found.notes)


def _larger(values: FloatArray, needs: list[list[VectorRequirement]], value: Any) -> FloatArray:
    """Return the larger of the planes' values [rad] and the vector's; NaN is propagated."""
    return np.asarray(np.maximum(values, [[value(one) for one in row] for row in needs]))


WORDS = {"model": MODELS, "plane": (*PLANES, BOTH), "law": LAWS}
_TIMES_IN_WIND = 33
"""Number of times during a wind at which beta and B are evaluated for their change."""


def size(
    schedule: FlightSchedule,
    winds: WindOf | Mapping[str, WindOf],
    *,
    times: ArrayLike | None = None,
    dead_bands: ArrayLike = (1.0, 0.5),
    model: str = DEFAULT_MODEL,
    plane: str = "pitch",
    placing: str | Mapping[str, str] = "peak",
    window: float = 20.0,
    law: str = "bound",
    varying: bool | None = None,
    stop: LimitShape | str = "round",
    progress: Callable[[int, int], None] | None = None,
) -> Sizing:
    """Return the required deflection [rad] of each wind at each flight time.

    A wind that is an angle is at nominal dynamic pressure; `tvclin size` adds that in a head and in
    a tail wind, on which its verdict rests.

    Parameters
    ----------
    schedule : FlightSchedule
        The vehicle over its flight; see `load_schedule`.
    winds : History, callable, or mapping of str to these
        One wind, or winds by name. A function takes the vehicle at a flight time and gives the wind
        it meets then: a wind speed makes different angles at different speeds of flight. What
        `fly_through` gives has its place in the flight already. For both planes each is a
        `PlaneWind`, gives one, or is what `fly_through` gives for both.
    times : array_like, optional
        Flight times [s] within the schedule, ``(n,)``; its own times where not given.
    dead_bands : array_like
        K of the report's control, in [0, 1].
    model : str
        As of `Plant`.
    plane : {"pitch", "yaw", "both"}
        As of `Plant`; or both planes, which share one stop.
    placing : {"peak", "flight"} or mapping of str to these
        Whether a wind is moved so that its peak meets the flight time, or blows in flight time
        already: then what blows within half a `window` [s] of the flight time counts. For all
        winds, or by their names ("peak" for the others).
    window : float
        See `placing`.
    law : {"bound", "flown"}
        What stands for laws without a forecast: the bound that none of them undercuts, or what the
        recoverable-attitude law needs when it is flown (a second or more for each wind and time).
    varying : bool, optional
        Whether to let parameters vary while the wind blows as well, beside the frozen ones; where
        it is not given, if they can be followed.
    stop : LimitShape or str
        For both planes what the nozzle can do, or a word: "round", "round-each-plane" (each plane
        limited by itself within it), "square", "square-45" (turned by 45 degrees).
    progress : callable, optional
        Is told how many flight times and winds are done, and how many there are.

    Returns
    -------
    Sizing
        Frozen at each flight time, as `required_deflection`, `forecast_free_limit` and
        `optimum_deflection` say it; NaN where a measured wind is not known. Of both planes it is
        the limit in the measure of the stop: the larger of what holds the needs of each plane by
        itself, and of `plane_limit` of the vector.

    Raises
    ------
    InputError
        For times outside the schedule, batches of winds, winds that never end, unknown names and
        numbers out of range; with `varying`, for a vehicle without a real unstable pole; for both
        planes for a wind without a direction.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> schedule = tv.load_schedule("configuration-i")
    >>> wind = tv.TriangularWind(peak=np.radians(5), duration=7.5)
    >>> found = tv.size(schedule, wind, times=[56.0, 66.0, 76.0])
    >>> np.degrees(found.required["K = 1"])[:, 0].round(3)
    array([0.42 , 0.351, 0.26 ])
    >>> np.degrees(found.required["K = 1, varying"])[:, 0].round(3)
    array([0.417, 0.345, 0.255])
    """
    instance("schedule", schedule, FlightSchedule, "see load_schedule")
    for name, value in (("model", model), ("plane", plane), ("law", law)):
        one_of(name, value, WORDS[name])
    if varying is not None:
        flag("varying", varying)
    if progress is not None:
        callable_for("progress", progress, "of how many are done and how many there are")
    shape = limit_shape_of(stop)
    chosen = schedule.times if times is None else np.atleast_1d(finite("times", times, "s"))
    bands = np.array(sorted(set(np.ravel(within("dead_bands", dead_bands, 0.0, 1.0))))[::-1])
    if chosen.ndim != 1 or not chosen.size or not bands.size:
        raise InputError("times and dead_bands must hold one number or more each")
    named = named_winds(winds)
    where = placings(named, placing)
    vehicles = [schedule.at(t) for t in chosen.tolist()]
    planes = PLANES if plane == BOTH else (plane,)
    placed = [
        [place_in(planes, wind, v, t, where[name], window) for name, wind in named.items()]
        for t, v in zip(chosen.tolist(), vehicles, strict=True)
    ]
    rounds = len(planes) * (1 if varying is False else 2) + (plane == BOTH)
    count_need = _counted(progress, len(placed) * len(named) * rounds)
    always = -np.inf, np.inf
    known = np.array([getattr(wind, "known", always) for wind in named.values()])
    sizings = {}
    for name in planes:
        in_plane = [[wind[name] for wind in row] for row in placed]
        inputs = _Inputs(schedule, chosen, tuple(named), known, bands, model, name, law)
        with repeated(len(named) * chosen.size):
            sizings[name] = _sized(inputs, vehicles, in_plane, varying, count_need)
    sizing = (
        sizings[plane]
        if plane in sizings
        else in_both_planes(sizings, vehicles, placed, shape, count_need)
    )
    steep = [f"{k}: {note}" for k, wind in named.items() for note in getattr(wind, "notes", ())]
    whys = [[wind[planes[0]].why for wind in row] for row in placed]
    rows = zip(chosen.tolist(), placed, strict=True)
    angles = np.array([[angle_at(wind, t) for wind in row] for t, row in rows])
    doubtful = doubtful_winds(dict(zip(named, angles.max(axis=0).tolist(), strict=True)))
    notes = (*steep, *unknown_rows(sizing, whys), *doubtful, *notes_of(sizing))
    concurrent = concurrent_trim(schedule, chosen, named, where, planes, shape, sizing.known)
    return replace(sizing, concurrent=concurrent, notes=notes)


@dataclass(frozen=True, eq=False)
class _Inputs:
    """Inputs of a sizing in one plane that do not depend on the winds."""

    schedule: FlightSchedule
    times: FloatArray
    winds: tuple[str, ...]
    known_times: FloatArray
    dead_bands: FloatArray
    model: str
    plane: str
    law: str


def _sized(
    inputs: _Inputs,
    vehicles: list[Vehicle],
    placed: list[list[PlacedWind]],
    varying: bool | None,
    count_need: Callable[[Any], Any],
) -> Sizing:
    """Return the sizing in one plane, without its notes."""
    schedule, bands, model, plane = inputs.schedule, inputs.dead_bands, inputs.model, inputs.plane
    needs = [
        [count_need(_frozen(schedule.plants(t, model, plane), w, bands, inputs.law)) for w in row]
        for t, row in zip(inputs.times, placed, strict=True)
    ]
    required = _columns(needs, bands)
    slow = _table(needs, lambda need: need.slow_mode)
    messages, arises = _messages(inputs.times, needs), {}
    if varying is not False:
        try:
            mode = _flight_mode(schedule, model, plane, placed)
            along = _along(mode, placed, bands, count_need)
            required |= _varying(_columns(along, bands))
            arises = _arises(placed, along, bands)
            messages += _missing(required, bands)
        except InputError as error:
            if varying:
                raise
            messages.append(f"parameters are frozen at each flight time: {error}")
    edges = [single_pole_validity(Coefficients.from_vehicle(v, plane)) for v in vehicles]
    return Sizing(
        **vars(inputs),
        required=required,
        slow_mode=slow,
        edge=np.array(edges),
        said=tuple(dict.fromkeys(messages)),
        notes=(),
        arises=arises,
        **_circumstances(schedule, plane, vehicles, placed),
    )


def _messages(times: FloatArray, needs: list[list[FrozenRequirement]]) -> list[str]:
    """Return the messages of requirements, with the flight times of those that are not of all."""
    at: dict[str, list[float]] = {}
    for time, row in zip(times.tolist(), needs, strict=True):
        for message in dict.fromkeys(message for need in row for message in need.said):
            at.setdefault(message, []).append(time)
    return [
        message if len(when) == times.size else f"at {flight_times(when)}: {message}"
        for message, when in at.items()
    ]


def _circumstances(
    schedule: FlightSchedule,
    plane: str,
    vehicles: list[Vehicle],
    placed: list[list[PlacedWind]],
) -> dict[str, Any]:
    """Return fields of `Sizing`: begin, end, change and coverage of winds, ``(n, m)``."""
    span = np.array([[(np.nan, np.nan) if w.calm else w.span for w in row] for row in placed])
    changes = [
        [_change(schedule, plane, v, w) for w in row]
        for v, row in zip(vehicles, placed, strict=True)
    ]
    return {
        "begins": span[..., 0],
        "ends": span[..., 1],
        "change": np.array(changes),
        "known": np.array([[w.known for w in row] for row in placed]),
        "covered": np.array([[_covers(schedule, w) for w in row] for row in placed]),
    }


def _frozen(plant: Plant, wind: PlacedWind, bands: FloatArray, law: str) -> FrozenRequirement:
    """Return the requirement of a wind at frozen parameters: zero in a calm, NaN if not known."""
    if wind.calm:
        none = 0.0 if wind.known else np.nan
        return FrozenRequirement(none, np.full(bands.shape, none), none, none, np.nan, ())
    return frozen_requirement(plant, wind.history, bands, law, wind.whole)


def _varying(values: dict[Requirement, FloatArray]) -> dict[Requirement, FloatArray]:
    """Return values by requirement as those with varying parameters."""
    return {replace(key, varying=True): value for key, value in values.items()}


def _missing(required: dict[Requirement, FloatArray], bands: FloatArray) -> list[str]:
    """Return a message where dead bands are defined for frozen parameters alone."""
    for K in bands:
        frozen, along = (required[Requirement(dead_band=K, varying=x)] for x in (False, True))
        if np.any(np.isnan(along) & ~np.isnan(frozen)):
            return ["B changes its sign while a wind blows: no dead bands, varying, there"]
    return []


def _flight_mode(
    schedule: FlightSchedule, model: str, plane: str, placed: list[list[PlacedWind]]
) -> FlightMode:
    """Return the unstable mode over the schedule and all winds."""
    spans = [schedule.span, *(w.span for row in placed for w in row if not w.calm)]
    first, last = (f(x) for f, x in zip((min, max), zip(*spans, strict=True), strict=True))
    return FlightMode(schedule, model, plane, (first, last))


def _along(
    mode: FlightMode,
    placed: list[list[PlacedWind]],
    bands: FloatArray,
    count_need: Callable[[FlightRequirement], FlightRequirement],
) -> list[list[FlightRequirement]]:
    """Return the requirements with varying parameters, by flight times and winds."""
    along: dict[bytes, FlightRequirement] = {}  # without a window one wind meets every flight time

    def of_wind(wind: PlacedWind) -> FlightRequirement:
        if wind.calm:
            none, unknown = 0.0 if wind.known else np.nan, np.full(bands.shape, np.nan)
            return FlightRequirement(none, np.full(bands.shape, none), none, np.nan, unknown)
        histories = (wind.in_flight, *([wind.whole] if wind.whole else []))
        key = b"".join(h.knots.tobytes() + h.pieces.coefficients.tobytes() for h in histories)
        if key not in along:
            windowed, *complete = (
                FlightWind(h, mode.plane, wind.speeds) if wind.speeds else NominalWind(h)
                for h in histories
            )
            along[key] = flight_requirement(mode, windowed, bands, *complete)
        return along[key]

    return [[count_need(of_wind(wind)) for wind in row] for row in placed]


def _arises(
    placed: list[list[PlacedWind]], along: list[list[FlightRequirement]], bands: FloatArray
) -> dict[Requirement, FloatArray]:
    """Return the flight times [s] at which requirements of fixed winds arise, ``(m,)`` each."""
    fixed = np.array([[wind.fixed for wind in row] for row in placed])
    if not fixed.any():
        return {}
    first = fixed.argmax(axis=0)
    needs = [along[i][j] for j, i in enumerate(first.tolist())]
    times = {TRIM: [x.trim_time for x in needs], MINIMUM: [x.trim_time for x in needs]}
    times |= {Requirement(dead_band=K): [x.times[k] for x in needs] for k, K in enumerate(bands)}
    is_fixed = fixed.any(axis=0)
    return _varying({key: np.where(is_fixed, value, np.nan) for key, value in times.items()})


def _counted(progress: Callable[[int, int], None] | None, total: int) -> Callable[[Any], Any]:
    """Return a function that passes a requirement on and reports the number so far."""
    done = count(1)

    def count_need(need: Any) -> Any:
        if progress is not None:
            progress(next(done), total)
        return need

    return count_need


def _columns(needs: Any, bands: FloatArray) -> dict[Requirement, FloatArray]:
    """Return requirements with frozen parameters of needs by flight times and winds."""
    columns = {TRIM: _table(needs, lambda need: need.trim)}
    for k, K in enumerate(bands):
        columns[Requirement(dead_band=K)] = _table(needs, lambda need, k=k: need.required[k])
    if isinstance(needs[0][0], FrozenRequirement):
        columns[NO_FORECAST] = _table(needs, lambda need: need.no_forecast)
    return columns | {MINIMUM: _table(needs, lambda need: need.minimum)}


def _table(needs: Any, value: Any) -> FloatArray:
    """Return a value of requirements by flight times and winds, ``(n, m)``."""
    return np.array([[value(need) for need in row] for row in needs], dtype=float)


def _covers(schedule: FlightSchedule, wind: PlacedWind) -> bool:
    """Return whether the schedule covers a wind, to a relative tolerance of 1e-9."""
    first, last = schedule.span
    tolerance = 1e-9 * (last - first)
    return wind.calm or (wind.span[0] >= first - tolerance and wind.span[1] <= last + tolerance)


def _change(schedule: FlightSchedule, plane: str, vehicle: Vehicle, wind: PlacedWind) -> float:
    """Return the largest relative change of beta or B during a wind, from its flight time."""
    if wind.calm:
        return 0.0
    now = Coefficients.from_vehicle(vehicle, plane)
    then = Coefficients.from_vehicle(
        schedule.clamped_at(np.linspace(*wind.span, _TIMES_IN_WIND)), plane
    )
    pairs = [(np.sqrt(np.abs(c.mu_alpha)), np.asarray(c.B)) for c in (now, then)]
    with np.errstate(divide="ignore", invalid="ignore"):
        changes = [np.abs(x / x0 - 1.0).max() for x0, x in zip(*pairs, strict=True) if x0 != 0.0]
    return float(max(changes, default=0.0))
