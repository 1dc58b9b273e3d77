"""Sizing of a flight: the required deflection of each wind at each flight time.

For both planes with a limit shape it combines the sizing of each plane and the vectors of winds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.measured_wind import FlightWind
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.errors import InputError, callable_for, finite, flag, instance, one_of, within
from tvclin.boundary.limit_shapes import LimitShape, limit_shape_of
from tvclin.boundary.optimum.two_poles import single_pole_validity
from tvclin.kernels.choice import repeated
from tvclin.linear.plant import DEFAULT_MODEL, MODELS, Plant
from tvclin.requirement.flight.flight_requirement import (
    WHOLE_TRIM,
    FlightMode,
    FlightRequirement,
    flight_requirements,
)
from tvclin.requirement.flight.flight_winds import (
    PlacedWind,
    WindOf,
    angle_at,
    concurrent_trim,
    named_winds,
    placed_in_planes,
    placings,
)
from tvclin.requirement.flight.frozen_requirement import LAWS, frozen_requirements
from tvclin.requirement.flight.sizing import (
    Sizing,
    doubtful_winds,
    flight_times,
    notes_of,
    slower_modes_message,
    unknown_wind_notes,
)
from tvclin.requirement.nominal_requirement import FrozenRequirement
from tvclin.requirement.plane_requirement import rectangle, vector_requirements
from tvclin.requirement.required_quantity import MINIMUM, NO_FORECAST, TRIM, Requirement
from tvclin.vehicle.coefficients import BOTH, PLANES, Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.wind_angles import NominalWind


def two_plane_sizing(
    parts: dict[str, Sizing],
    vehicles: list[Vehicle],
    placed: list[list[dict[str, PlacedWind]]],
    limit_shape: LimitShape,
    counted: Callable[[Any], Any],
) -> Sizing:
    """Return the sizing of both planes from the sizing of each plane, without notes.

    `parts`: sizing of each plane. `vehicles`: by flight time, ``(n,)``. `placed`: winds by plane,
    by flight time and wind. `limit_shape`: shape of the limit in both planes. `counted`: function
    that returns its argument and counts it for the progress. The worse plane counts in what limits
    validity: change of the vehicle, coverage of the wind by the schedule, and the two-pole result.
    """
    pitch, yaw = (parts[plane] for plane in PLANES)

    def requirement(vehicle: Vehicle, wind: dict[str, PlacedWind]) -> FrozenRequirement:
        """Return the requirements [rad] of the wind vector on a vehicle; zeros if a plane is calm.

        The wind is then in the other plane alone, whose own requirement counts anyway.
        """
        if any(in_plane.calm for in_plane in wind.values()):
            return FrozenRequirement.of_calm(pitch.dead_bands)
        in_pitch, in_yaw = (Plant.from_vehicle(vehicle, pitch.model, plane) for plane in PLANES)
        vector = PlaneWind(**{plane: in_plane.history for plane, in_plane in wind.items()})
        return vector_requirements(in_pitch, in_yaw, vector, limit_shape, pitch.dead_bands)

    needs = [
        [counted(requirement(vehicle, wind)) for wind in row]
        for vehicle, row in zip(vehicles, placed, strict=True)
    ]
    # flight times [s] at which requirements arise; `more`: where the vector requires more
    arises = {name: _two_plane_arising(pitch, yaw, name) for name in {**pitch.arises, **yaw.arises}}
    required, more = _required(pitch, yaw, needs, limit_shape, arises)
    # a vector without trim is one for which no requirement of both planes is defined
    refused = [[bool(vector.messages) and not vector.trim for vector in row] for row in needs]
    vector_notes = [
        note for i, j in np.argwhere(more | np.array(refused)) for note in needs[i][j].messages
    ]
    messages = (*pitch.said, *yaw.said, *vector_notes)
    # ratio of the deflections that the slow and the fast mode demand: of yaw where the slow one
    # decides there, else of pitch
    slow = np.where(yaw.beyond_single_pole, yaw.slow_mode, pitch.slow_mode)
    return replace(
        pitch,
        required=required,
        plane=BOTH,
        begins=np.fmin(pitch.begins, yaw.begins),
        ends=np.fmax(pitch.ends, yaw.ends),
        change=np.maximum(pitch.change, yaw.change),
        covered=pitch.covered & yaw.covered,
        slow_mode=slow,
        edge=np.fmin(pitch.edge, yaw.edge),
        said=tuple(dict.fromkeys(messages)),
        separate=parts,
        arises=arises,
        limit_shape=limit_shape,
    )


def _two_plane_arising(pitch: Sizing, yaw: Sizing, name: Requirement) -> FloatArray:
    """Return the flight time [s] at which a requirement of each of m winds arises, ``(m,)``.

    It is NaN for a wind that is moved to each flight time, not fixed in flight time. `pitch`,
    `yaw`: sizing of each plane, requirements [rad] by flight time and wind, NaN if not known.
    `name`: the requirement; the plane in which its largest value is larger counts.
    """
    pitch_time, yaw_time = (sizing.arising(name) for sizing in (pitch, yaw))
    pitch_size, yaw_size = (
        np.nanmax(sizing.required[name], axis=0, initial=0.0) for sizing in (pitch, yaw)
    )
    in_pitch = np.isnan(yaw_time) | ((pitch_size >= yaw_size) & ~np.isnan(pitch_time))
    return np.where(in_pitch, pitch_time, yaw_time)


def _required(
    pitch: Sizing,
    yaw: Sizing,
    needs: list[list[FrozenRequirement]],
    limit_shape: LimitShape,
    arises: dict[Requirement, FloatArray],
) -> tuple[dict[Requirement, FloatArray], BoolArray]:
    """Return the requirements [rad] of both planes, and whether the wind vector requires more.

    `pitch`, `yaw`: sizing of each plane. `needs`: requirements of the wind vector, by flight time
    and wind. `limit_shape`: limit in both planes. `arises`: times [s] at which requirements of
    winds fixed in flight time arise, NaN for other winds.

    For trim, minimum and the bound without a forecast the larger of both planes counts, for dead
    bands the limit that contains the rectangle of both; the wind vector counts if it is larger.
    """
    defined = [name for name in pitch.required if name in yaw.required]
    corners = {
        name: rectangle(limit_shape, pitch.required[name], yaw.required[name]) for name in defined
    }
    vectors, required = _columns(needs, pitch.dead_bands), dict(corners)
    # the requirement of a plane over its limit in the shape with the limit one is the limit that
    # contains the requirement of this plane
    pitch_limit, yaw_limit = limit_shape.plane_limits
    for name in (TRIM, MINIMUM, *((NO_FORECAST,) if pitch.law == "bound" else ())):
        larger = np.maximum(pitch.required[name] / pitch_limit, yaw.required[name] / yaw_limit)
        required[name] = np.maximum(larger, vectors[name])
    names = [Requirement(dead_band=K) for K in pitch.dead_bands]
    for name in names:
        required[name] = np.maximum(corners[name], vectors[name])
        if (along := replace(name, varying=True)) in corners:
            # with varying parameters the planes' limit is raised as much as with frozen ones
            positive = corners[name] > 0.0
            ratio = np.ones(positive.shape)
            np.divide(required[name], corners[name], out=ratio, where=positive)
            fixed = ~np.isnan(arises.get(along, np.full(len(pitch.winds), np.nan)))
            # a wind fixed in flight time has one requirement, whatever the flight time of the row
            largest_ratio = np.nanmax(ratio, axis=0, initial=1.0)
            required[along] = corners[along] * np.where(fixed, largest_ratio, ratio)
    return required, np.any([required[name] > corners[name] for name in names], axis=0)


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
    limit_shape: LimitShape | str = "round",
    progress: Callable[[int, int], None] | None = None,
) -> Sizing:
    """Return the required deflection [rad] of each wind at each flight time.

    A wind that is an angle is at nominal dynamic pressure; `tvclin ascent` adds the requirements in
    a head wind and a tail wind, on which its verdict is based.

    Parameters
    ----------
    schedule : FlightSchedule
        The vehicle over its flight; see `load_schedule`.
    winds : History, callable, or mapping of str to these
        A wind, or winds by name. A function takes the vehicle at a flight time and returns the wind
        that it encounters: a wind speed has different angles at different speeds of flight. A
        measured wind of `fly_through` keeps its flight time. For both planes each is a `PlaneWind`,
        a function that returns one, or a measured wind of both planes.
    times : array_like, optional
        Flight times [s] within the schedule, ``(n,)``; by default the times of the schedule.
    dead_bands : array_like
        Dead bands K of the report's control, in [0, 1].
    model : str
        Model of `Plant`.
    plane : {"pitch", "yaw", "both"}
        Plane of `Plant`; or both planes, which share a limit shape.
    placing : {"peak", "flight"} or mapping of str to these
        "peak": a wind is moved so that its peak is at the flight time. "flight": a wind is in
        flight time, and counts within half a `window` [s] of each flight time. For all winds, or by
        name, then "peak" for other winds.
    window : float
        Length [s] of the interval about each flight time in which a wind in flight time counts.
    law : {"bound", "flown"}
        Requirement of laws without a forecast: their lower bound, or the requirement of the
        recoverable-attitude law in flight (a second or more for each wind and time).
    varying : bool, optional
        Whether to compute requirements with parameters that vary during the wind as well; by
        default where that is possible.
    limit_shape : LimitShape or str
        Limit shape of both planes, or its name: "round", "round-each-plane" (within it each plane
        is limited separately), "square", "square-45" (turned by 45 degrees).
    progress : callable, optional
        Called with the number of finished pairs of flight time and wind, and of all pairs.

    Returns
    -------
    Sizing
        Requirements with parameters frozen at each flight time, by `required_deflection`,
        `forecast_free_limit` and `optimum_deflection`; NaN where a measured wind is not known. For
        both planes they are in the measure of the limit shape: the larger of the limit for separate
        planes, and of `plane_limit` of the vector.

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
    shape = limit_shape_of(limit_shape)
    chosen = schedule.times if times is None else np.atleast_1d(finite("times", times, "s"))
    bands = np.array(sorted(set(np.ravel(within("dead_bands", dead_bands, 0.0, 1.0))))[::-1])
    if chosen.ndim != 1 or not chosen.size or not bands.size:
        raise InputError("times and dead_bands must hold one number or more each")
    named = named_winds(winds)
    placed_as = placings(named, placing)
    vehicles = [schedule.at(t) for t in chosen.tolist()]
    planes = PLANES if plane == BOTH else (plane,)
    placed = [
        [placed_in_planes(planes, x, v, t, placed_as[name], window) for name, x in named.items()]
        for t, v in zip(chosen.tolist(), vehicles, strict=True)
    ]
    # number of requirements of each wind and time: frozen, varying, and of the vector
    per_wind = len(planes) * (1 if varying is False else 2) + (plane == BOTH)
    count_need = _progress_counter(progress, len(placed) * len(named) * per_wind)
    known_times = np.array([getattr(wind, "known", (-np.inf, np.inf)) for wind in named.values()])
    sizings = {}
    for name in planes:
        in_plane = [[wind[name] for wind in row] for row in placed]
        inputs = _Inputs(
            schedule=schedule,
            times=chosen,
            winds=tuple(named),
            known_times=known_times,
            dead_bands=bands,
            model=model,
            plane=name,
            law=law,
        )
        # similar runs, which decide between compiled and plain code
        with repeated(len(named) * chosen.size):
            sizings[name] = _plane_sizing(inputs, vehicles, in_plane, varying, count_need)
    sizing = (
        sizings[plane]
        if plane in sizings
        else two_plane_sizing(sizings, vehicles, placed, shape, count_need)
    )
    wind_notes = [
        f"{k}: {note}" for k, wind in named.items() for note in getattr(wind, "notes", ())
    ]
    # a wind is unknown in both planes for one reason
    reasons = [[wind[planes[0]].why for wind in row] for row in placed]
    rows = zip(chosen.tolist(), placed, strict=True)
    angles = np.array([[angle_at(wind, t) for wind in row] for t, row in rows])
    doubtful = doubtful_winds(dict(zip(named, angles.max(axis=0).tolist(), strict=True)))
    notes = (*wind_notes, *unknown_wind_notes(sizing, reasons), *doubtful, *notes_of(sizing))
    concurrent = concurrent_trim(schedule, chosen, named, placed_as, planes, shape, sizing.known)
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


def _plane_sizing(
    inputs: _Inputs,
    vehicles: list[Vehicle],
    placed: list[list[PlacedWind]],
    varying: bool | None,
    count_need: Callable[[Any], Any],
) -> Sizing:
    """Return the sizing in one plane, without its notes.

    `inputs`: schedule, flight times, dead bands, model and plane. `vehicles`: vehicle at each of n
    flight times. `placed`: m winds at each of these times. `varying`: whether requirements with
    parameters that vary during a wind are added to those with frozen ones; None where possible.
    `count_need`: function that returns a requirement unchanged and reports progress.
    """
    schedule, bands, model, plane = inputs.schedule, inputs.dead_bands, inputs.model, inputs.plane
    frozen = _frozen(inputs, placed)
    needs = [[count_need(next(frozen)) for _ in row] for row in placed]
    required = _columns(needs, bands)
    slow = _numbers(needs, lambda need: need.slow_mode)
    messages, arises = _messages(inputs.times, needs), {}  # arises: when a requirement does [s]
    if varying is not False:
        try:
            firsts, lasts = zip(
                schedule.span, *(w.span for row in placed for w in row if not w.calm), strict=True
            )
            mode = FlightMode(schedule, model, plane, span=(min(firsts), max(lasts)))
            varying_needs = _varying_requirements(mode, placed, bands, count_need)
            along = _columns(varying_needs, bands)
            required |= {replace(key, varying=True): values for key, values in along.items()}
            arises = _arising_times(placed, varying_needs, bands)
            messages += _missing(required, bands)
            messages += _without_exit(mode, inputs.times, placed, bands)
            # whether slower modes raise the minimum, by flight time and wind
            raised = _numbers(varying_needs, lambda need: need.slower_modes)
            messages += slower_modes_message(inputs.times, raised)
        except InputError as error:
            if varying:
                raise
            messages.append(f"parameters are frozen at each flight time: {error}")
    rows = list(zip(vehicles, placed, strict=True))
    # longest wind [s] for which a single pole is sufficient
    edges = [single_pole_validity(Coefficients.from_vehicle(v, plane)) for v in vehicles]
    span = np.array([[(np.nan, np.nan) if w.calm else w.span for w in row] for row in placed])
    changes = [[_change(schedule, plane, v, w) for w in row] for v, row in rows]
    (begins, ends), (first, last) = np.moveaxis(span, -1, 0), schedule.span
    tolerance = 1e-9 * (last - first)  # rounding of times
    return Sizing(
        **vars(inputs),
        required=required,
        begins=begins,
        ends=ends,
        change=np.array(changes),
        known=np.array([[w.known for w in row] for row in placed]),
        covered=np.array([[w.calm for w in row] for row in placed])
        | ((begins >= first - tolerance) & (ends <= last + tolerance)),
        slow_mode=slow,
        edge=np.array(edges),
        said=tuple(dict.fromkeys(messages)),
        notes=(),
        arises=arises,
    )


def _messages(times: FloatArray, requirements: list[list[FrozenRequirement]]) -> list[str]:
    """Return the messages of requirements, with flight times where a message is not of all.

    `times`: flight times [s], ``(n,)``. `requirements`: by flight time, then by wind.
    """
    at: dict[str, list[float]] = {}
    for time, row in zip(times.tolist(), requirements, strict=True):
        for message in dict.fromkeys(message for frozen in row for message in frozen.messages):
            at.setdefault(message, []).append(time)
    return [
        message if len(when) == times.size else f"at {flight_times(when)}: {message}"
        for message, when in at.items()
    ]


def _frozen(inputs: _Inputs, placed: list[list[PlacedWind]]) -> Iterator[FrozenRequirement]:
    """Yield the requirements at frozen parameters, of all winds at the first flight time first.

    `inputs`: schedule, flight times, dead bands, model and plane. `placed`: for each flight time a
    row of its winds, all of one length. The requirements are zero in a calm, and NaN if the wind is
    not known.
    """
    bands, winds = inputs.dead_bands, [wind for row in placed for wind in row]
    not_calm = np.flatnonzero([not wind.calm for wind in winds])
    times = inputs.times[not_calm // len(placed[0])]  # flight time of each of these winds
    requirements = frozen_requirements(
        inputs.schedule.plants(times, inputs.model, inputs.plane),
        [winds[i].history for i in not_calm],
        dead_bands=bands,
        law=inputs.law,
        two_sided=[winds[i].two_sided for i in not_calm],  # with the angles of both signs
    )
    for wind in winds:
        if wind.calm:
            yield FrozenRequirement.of_calm(bands, 0.0 if wind.known else np.nan)
        else:
            yield next(requirements)


def _missing(required: dict[Requirement, FloatArray], bands: FloatArray) -> Iterator[str]:
    """Yield a message where dead bands are defined only with frozen parameters.

    `required`: each requirement [rad] at n flight times in m winds. `bands`: dead bands K.
    """
    for K in bands:
        frozen, along = (required[Requirement(dead_band=K, varying=x)] for x in (False, True))
        if np.any(np.isnan(along) & ~np.isnan(frozen)):
            yield "a wind changes its sign: dead bands below 1, varying, are not defined then"
            return


def _without_exit(
    mode: FlightMode, times: FloatArray, placed: list[list[PlacedWind]], bands: FloatArray
) -> Iterator[str]:
    """Yield messages on winds in which the whole of trim counts, as the dead band has no exit.

    It has none where two poles are a pair, or the aerodynamic moment changes its sign. `mode`:
    unstable mode. `times`: flight times [s] of the rows of winds in `placed`. `bands`: all K.
    """
    spans = [[wind.span for wind in row if not wind.calm] for row in placed]
    rows = list(zip(times.tolist(), spans, strict=True))
    paired = [time for time, row in rows if any(mode.has_pair(*span) for span in row)]
    at = [time for time, row in rows if not all(mode.has_exit(*span) for span in row)]
    if paired:
        yield (
            f"at {flight_times(paired)}, parameters varying: two unstable poles are a pair or equal"
            f" during a wind; K = 1 then {WHOLE_TRIM}"
        )
    if at and np.any(bands < 1.0):
        yield (
            f"at {flight_times(at)}, parameters varying: with such poles, or where the aerodynamic"
            " moment changes its sign, K < 1 requires the largest trim over K, so that the dead"
            " band has no exit"
        )


def _varying_requirements(
    mode: FlightMode,
    placed: list[list[PlacedWind]],
    bands: FloatArray,
    count_need: Callable[[FlightRequirement], FlightRequirement],
) -> list[list[FlightRequirement]]:
    """Return the requirements with varying parameters, by flight times and winds.

    `mode`: unstable mode along the flight. `placed`: winds by flight time. `bands`: dead bands K.
    `count_need`: function that returns a requirement unchanged and reports progress.
    """
    # A wind that is the same at several flight times is computed once. Distinct winds by a key,
    # the bytes of their breakpoints and coefficients: the wind with its angles of the larger sign
    # alone and, where they change sign, behind it that with both signs.
    winds: dict[bytes, list[NominalWind]] = {}

    def key_of(wind: PlacedWind) -> bytes:
        """Return the key of a wind in `winds`, where it is stored.

        A sounding has the dynamic pressure of its wind speeds, another wind the nominal one.
        """
        histories = (wind.in_flight, *([wind.two_sided] if wind.two_sided else []))
        key = b"".join(h.knots.tobytes() + h.pieces.coefficients.tobytes() for h in histories)
        if key not in winds:
            winds[key] = [
                FlightWind(h, mode.plane, wind.speeds) if wind.speeds else NominalWind(h)
                for h in histories
            ]
        return key

    keys = [[None if wind.calm else key_of(wind) for wind in row] for row in placed]
    # K < 1 takes the angles of one sign; K = 1 those of both, where there are both
    one_sign = [histories[0] for histories in winds.values()]
    both_signs = [histories[-1] for histories in winds.values()]
    requirements = flight_requirements(mode, one_sign, bands, both_signs)
    by_key = dict(zip(winds, requirements, strict=True))

    def requirement_of(wind: PlacedWind, key: bytes | None) -> FlightRequirement:
        """Return the requirement of a wind; zero in a calm, which has no key, NaN if not known."""
        if key is not None:
            return by_key[key]
        calm, times = 0.0 if wind.known else np.nan, np.full(bands.shape, np.nan)
        required = np.full(bands.shape, calm)
        sizes: dict[str, Any] = {"trim": calm, "required": required, "minimum": calm}
        return FlightRequirement(**sizes, slower_modes=False, trim_time=np.nan, times=times)

    return [
        [count_need(requirement_of(*pair)) for pair in zip(row, row_keys, strict=True)]
        for row, row_keys in zip(placed, keys, strict=True)
    ]


def _arising_times(
    placed: list[list[PlacedWind]], along: list[list[FlightRequirement]], bands: FloatArray
) -> dict[Requirement, FloatArray]:
    """Return the flight times [s] at which requirements of m winds arise, ``(m,)`` each.

    Parameters vary; NaN for winds that are moved to each flight time, not fixed in flight time.
    `placed`, `along`: winds, and requirements along the flight, by flight time and wind. `bands`:
    dead bands K: their time is the exit; of trim and minimum it is the largest trim.
    """
    fixed = np.array([[wind.fixed for wind in row] for row in placed])
    if not fixed.any():
        return {}
    first = fixed.argmax(axis=0)  # index of the first flight time at which a wind is fixed
    needs = [along[i][j] for j, i in enumerate(first.tolist())]
    times = {TRIM: [x.trim_time for x in needs], MINIMUM: [x.trim_time for x in needs]}
    times |= {Requirement(dead_band=K): [x.times[k] for x in needs] for k, K in enumerate(bands)}
    is_fixed = fixed.any(axis=0)
    return {
        replace(key, varying=True): np.where(is_fixed, value, np.nan)
        for key, value in times.items()
    }


def _progress_counter(
    progress: Callable[[int, int], None] | None, total: int
) -> Callable[[Any], Any]:
    """Return a function that returns its argument, and reports how many it was called with.

    `progress`: called with that number and the number of all calls, `total`; None for no report.
    """
    done = count(1)

    def count_requirement(requirement: Any) -> Any:
        """Return a requirement unchanged, and report that it is finished."""
        if progress is not None:
            progress(next(done), total)
        return requirement

    return count_requirement


def _columns(needs: Any, bands: FloatArray) -> dict[Requirement, FloatArray]:
    """Return requirements [rad] by name, each ``(n, m)``.

    `needs`: requirement of each of m winds at each of n flight times. `bands`: dead bands K,
    ``(k,)``. Only for a frozen vehicle there is a bound without a forecast.
    """
    columns = {TRIM: _numbers(needs, lambda need: need.trim)}
    for k, K in enumerate(bands):
        columns[Requirement(dead_band=K)] = _numbers(needs, lambda need, k=k: need.required[k])
    if isinstance(needs[0][0], FrozenRequirement):
        columns[NO_FORECAST] = _numbers(needs, lambda need: need.no_forecast)
    return columns | {MINIMUM: _numbers(needs, lambda need: need.minimum)}


def _numbers(requirements: Any, number: Any) -> FloatArray:
    """Return a number of each requirement, ``(n, m)``.

    `requirements`: by n flight times and m winds. `number`: function that returns this number of a
    requirement, such as its trim [rad].
    """
    return np.array([[number(x) for x in row] for row in requirements], dtype=float)


def _change(schedule: FlightSchedule, plane: str, vehicle: Vehicle, wind: PlacedWind) -> float:
    """Return the largest relative change of beta or B during a wind; NaN if it is not known.

    beta = sqrt(abs(mu_alpha)) [1/s] is the rate of the attitude, B the ratio of trim deflection to
    angle of attack; changes are against the values at the flight time. `schedule`: vehicle over the
    flight, in the plane `plane`. `vehicle`: vehicle at the flight time.
    """
    if wind.calm:
        return 0.0 if wind.known else np.nan
    times = np.linspace(*wind.span, _TIMES_IN_WIND)
    now = Coefficients.from_vehicle(vehicle, plane)
    then = Coefficients.from_vehicle(schedule.clamped_at(times, rigid=True), plane)
    beta_now, beta = (np.sqrt(np.abs(c.mu_alpha)) for c in (now, then))
    pairs = (beta_now, beta), (np.asarray(now.B), np.asarray(then.B))
    with np.errstate(divide="ignore", invalid="ignore"):
        changes = [np.abs(x / x_now - 1.0).max() for x_now, x in pairs if x_now != 0.0]
    return float(max(changes, default=0.0))
