"""Outputs of cases: functions from a batch to columns, also of flights of the campaign's law.

A batch is plants, winds and gains of the cases that are computed together, in a plane or in both.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from tvclin.ascent.measured_wind import unknown_between
from tvclin.ascent.schedule import FlightSchedule
from tvclin.ascent.wind_along import WindAlong, wind_along
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import naming
from tvclin.base.quantities import NO_FORECAST, WIND_KNOWN
from tvclin.base.quantities import REQUIRED as REQUIRED_DEFLECTION
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.limit_shapes import limit_shape_of
from tvclin.boundary.optimum.minimum_peak import minimum_peaks
from tvclin.case.flexible_autopilot import with_filters
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import CHAINS
from tvclin.control.laws.autopilot_law import SaturatedLaw
from tvclin.control.laws.law import Law
from tvclin.control.laws.registry import AUTOPILOT, design_law
from tvclin.control.margins.margins import loop_margins
from tvclin.ensembles.campaign.campaign_plan import Campaign, SoundingEnsemble, dispersed_flight
from tvclin.ensembles.dispersions import mode_names
from tvclin.flights.closed_loop.flown_flights import FlownFlight, checked_flight, fly_together
from tvclin.flights.closed_loop.fly_many import FlownCases, fly_many
from tvclin.linear.flexible import AnyPlant, FlexiblePlant
from tvclin.linear.plant import Plant
from tvclin.requirement.encountered_requirement import encountered_batch, uses_encountered_pressure
from tvclin.requirement.flight.flight_winds import place
from tvclin.requirement.nominal_requirement import (
    FrozenRequirement,
    may_be_zero_or_infinite,
    required_deflection,
)
from tvclin.requirement.plane_requirement import (
    rectangle,
    two_plane_requirement,
    vector_requirements,
)
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.vehicle.structure import select_cases
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.wind_angles import FROZEN, within_linear


@dataclass(frozen=True, eq=False)
class Batch:
    """Plants, winds and gains of `count` cases that are computed together.

    `plant`, `wind`: batches of shape ``(n,)``, or a single plant or wind for all cases. `gains`:
    gains of the autopilot where an output depends on them, ``(n,)`` where they are dispersed.
    `vehicle`: the vehicles that the plant linearises. `flexible`: flexible plants of the vehicles
    with their structure. `values`: dispersed values by name, ``(n,)``. `wind_angle`: largest wind
    angle [rad], of a wind with a direction the angle in both planes together, ``(n,)`` or a scalar.
    `plane_batches`: batches by plane, for each plane with a component of the wind, where both
    planes are judged.
    """

    plant: Plant
    wind: History
    gains: dict[str, Any]
    count: int
    vehicle: Vehicle
    wind_angle: FloatArray
    flexible: FlexiblePlant | None = None
    values: Mapping[str, Any] = field(default_factory=dict)
    plane_batches: Mapping[str, Batch] = field(default_factory=dict)

    @property
    def plants(self) -> dict[str, Plant]:
        """The plants by plane, for both planes."""
        model = self.plant.model
        return {name: Plant.from_vehicle(self.vehicle, model, name) for name in PLANES}

    @property
    def vectors(self) -> PlaneWind:
        """The winds of both planes; zero in a plane without a component of the wind."""
        winds = {plane: batch.wind for plane, batch in self.plane_batches.items()}
        return PlaneWind(**(dict.fromkeys(PLANES, 0.0 * self.wind) | winds))

    @property
    def flying(self) -> AnyPlant:
        """The plant that flies and that the autopilot controls: flexible with a structure."""
        return self.plant if self.flexible is None else self.flexible

    @cached_property
    def first(self) -> Batch:
        """Batch of the first case alone, with scalars in place of a batch axis."""
        shape = (self.count,)
        return Batch(
            plant=self.plant.case(0, shape),
            wind=self.wind.case(0, shape),
            gains={name: float(np.ravel(value)[0]) for name, value in self.gains.items()},
            count=1,
            vehicle=select_cases(self.vehicle, 0, shape),
            wind_angle=np.ravel(self.wind_angle)[0],
            flexible=None if self.flexible is None else self.flexible.cases(0, shape),
            values={name: value[:1] for name, value in self.values.items()},
        )


def plane_columns(name: str) -> dict[str, str]:
    """Return the names of a column in each plane, by plane: minimum_pitch and minimum_yaw.

    `name`: name of the column of both planes together, as minimum.
    """
    return {plane: f"{name}_{plane}" for plane in PLANES}


REQUIRED = "required_"
"""Beginning of the names of the columns of required deflections."""


def required_name(dead_band: float, kind: str = "required") -> str:
    """Return the name of the column of a dead band K in [0, 1], as in "required_K1".

    `kind`: first part of the name, "required" or "flown".
    """
    short = f"{dead_band:g}"
    return f"{kind}_K{short if float(short) == dead_band else repr(dead_band)}"


_LABELS = {
    "required": REQUIRED_DEFLECTION,
    "flown": "limit that the flights require",
    "forecast_free": NO_FORECAST,
    "minimum": WIND_KNOWN,
}
"""Labels of columns of deflections, by their names without dead band and plane."""


def column_label(column: str) -> str:
    """Return the label of a column, as "required deflection, K = 1, pitch" of required_K1_pitch."""
    plane = next((plane for plane in PLANES if column.endswith(f"_{plane}")), "")
    name, _, dead_band = column.removesuffix(f"_{plane}").partition("_K")
    label = _LABELS.get(name, name.replace("_", " "))
    return ", ".join(filter(None, (label, dead_band and f"K = {dead_band}", plane)))


COLUMNS = {
    "flight_survived": "",
    "flight_peak_deflection": "rad",
    "flight_peak_attitude": "rad",
    "flight_peak_angle_of_attack": "rad",
}
"""Units of the columns of the output "flight", by name."""
_MOTIONS = ("flight_peak_attitude", "flight_peak_angle_of_attack")
"""Columns of the motion of the vehicle."""
MOTIONS = (*_MOTIONS, *(column for name in _MOTIONS for column in plane_columns(name).values()))
"""Columns of the motion, in a plane and in both: angles, but no deflections."""


def law_of(campaign: Campaign, batch: Batch) -> Law:
    """Return the control law of a campaign for the first case of a batch, with its gains.

    With a `controller` in state space `campaign.autopilot` is this controller, the same in all
    cases; else the autopilot has the gains of the case. Other laws are designed on the plant for
    the peak of the wind. The filters of `autopilot_design` act in all but a controller.
    """
    if campaign.law == AUTOPILOT and campaign.controller is not None:
        return SaturatedLaw.of(campaign.autopilot)
    options: dict[str, Any] = {}
    if campaign.law == AUTOPILOT:
        options[AUTOPILOT] = Autopilot(**batch.first.gains)
    options["rate_limit"] = campaign.hardware["rate_limit"]
    law = design_law(campaign.law, campaign.rigid_plant, campaign.wind.max_angle, **options)
    return with_filters(law, campaign.autopilot_design)


def flights(campaign: Campaign, batch: Batch) -> dict[str, Any]:
    """Return survival and peaks [rad] of the flights of a batch of n cases, ``(n,)`` by column.

    Where a campaign judges both planes, they are of both together, with columns of each plane; each
    is flown with its share of the limit, a fraction. A flight that diverges in one plane is lost.
    """
    limit = campaign.nozzle.limit
    assert limit is not None
    if campaign.along is not None:
        return _flown_along(campaign, batch)
    if not batch.plane_batches:
        return _flown(campaign, batch, limit)
    shares = shares_of(campaign, batch)
    flown = {
        plane: _flown(in_plane, batch.plane_batches[plane], limit * shares[plane])
        for plane, in_plane in campaign.plane_campaigns.items()
    }
    # in a plane without wind nothing moves, and the flight survives
    calm = {name: np.zeros(batch.count) for name in COLUMNS} | {"flight_survived": np.ones(1)}
    pitch, yaw = (flown.get(plane, calm) for plane in PLANES)
    diverged = (pitch["flight_survived"] == 0.0) | (yaw["flight_survived"] == 0.0)
    combined = {name: np.hypot(pitch[name], yaw[name]) for name in _MOTIONS}
    combined["flight_peak_deflection"] = rectangle(
        limit_shape_of(campaign.nozzle.limit_shape or ""),
        pitch["flight_peak_deflection"],
        yaw["flight_peak_deflection"],
    )
    columns = {name: np.where(diverged, np.inf, peak) for name, peak in combined.items()}
    survived = pitch["flight_survived"] + yaw["flight_survived"] - 1.0  # 1 if both are; NaN stays
    columns["flight_survived"] = np.where(diverged, 0.0, survived)
    for name in COLUMNS:
        by_plane = plane_columns(name)
        columns |= {by_plane["pitch"]: pitch[name], by_plane["yaw"]: yaw[name]}
    return columns


def shares_of(campaign: Campaign, batch: Batch) -> dict[str, FloatArray]:
    """Return the fractions of the limit that each plane has, ``(n,)``, in ratio of their winds.

    With them the rectangle of both deflections lies within the limit shape, so that each plane may
    be flown by itself. `campaign`: has the limit shape. `batch`: n cases, in both planes.
    """
    peaks = {plane: np.abs(in_plane.wind.peak) for plane, in_plane in batch.plane_batches.items()}
    limit_shape = limit_shape_of(campaign.nozzle.limit_shape or "")
    # limit whose shape contains the rectangle of the peaks, in the unit of the peaks
    total = rectangle(limit_shape, *(peaks.get(plane, 0.0) for plane in PLANES))
    return {plane: peak / total for plane, peak in peaks.items()}


def _flown(campaign: Campaign, batch: Batch, limit: FloatArray | float) -> dict[str, Any]:
    """Return survival and peaks [rad] of the n flights of a batch in a plane, by column.

    `limit`: deflection limit [rad], ``(n,)`` or a scalar.
    """
    dispersed = any(np.ndim(value) for value in batch.gains.values())
    # filters between the sensors and the gains, which are the same in all cases
    chains = {name: getattr(campaign.autopilot_design, name) for name in CHAINS}
    gains_vary = dispersed and campaign.law == AUTOPILOT
    flown = fly_many(
        batch.flying,
        Autopilot(**batch.gains, **chains) if gains_vary else law_of(campaign, batch),
        batch.wind,
        deflection_limit=limit,
        **campaign.hardware,
    )
    return _fates(flown)


def _fates(flown: FlownCases) -> dict[str, Any]:
    """Return survival and peaks [rad] of m flights, ``(m,)`` by column, as in `COLUMNS`.

    `flown`: outcomes of the flights. `flight_survived` is 1 or 0, and NaN where the flight is
    undecided; peaks of diverged flights are infinite.
    """
    diverged = (flown.status == "lost") | (flown.status == "rings")  # or in a limit cycle
    fate = np.select([flown.status == "survived", diverged], [1.0, 0.0], np.nan)
    return {"flight_survived": fate} | {
        f"flight_peak_{name}": np.where(fate == 0.0, np.inf, getattr(flown, f"peak_{name}"))
        for name in ("attitude", "angle_of_attack", "deflection")
    }


def _flown_along(campaign: Campaign, batch: Batch) -> dict[str, Any]:
    """Return survival and peaks [rad] of n cases along their whole flights, ``(n,)`` by column.

    They are for the worse direction of the wind. A flight through a sounding that is not known over
    its whole time is never survived: `flight_survived` is 0 if it diverges, else NaN.
    """
    assert campaign.along is not None
    by_case = [flights_along(campaign, batch, case) for case in range(batch.count)]
    flights = [flight for of_case in by_case for flight in of_case]
    # index of the first flight of each case
    starts = np.cumsum([0, *(len(of_case) for of_case in by_case[:-1])])
    limits = (np.full(len(flights), x) for x in limits_along(campaign))
    fates = _fates(fly_together(flights, np.arange(len(flights)), *limits))
    survived = fates.pop("flight_survived")
    diverged = np.maximum.reduceat(survived == 0.0, starts)
    known = np.minimum.reduceat(survived, starts)
    if isinstance(campaign.wind, SoundingEnsemble):
        span = campaign.along.span
        unknown = [bool(unknown_between(wind, *span)) for wind in campaign.wind.soundings]
        index = batch.values.get("wind", 0)  # of each case's sounding; one sounding if not drawn
        known = np.where(np.array(unknown)[np.asarray(index, dtype=int)], np.nan, known)
    return {"flight_survived": np.where(diverged, 0.0, known)} | {
        name: np.maximum.reduceat(values, starts) for name, values in fates.items()
    }


def limits_along(campaign: Campaign) -> tuple[float, float]:
    """Return the deflection limit [rad] and the rate limit [rad/s] of a campaign along a flight."""
    limit = campaign.nozzle.limit
    assert limit is not None
    return limit, float(campaign.hardware["rate_limit"])


def flights_along(campaign: Campaign, batch: Batch, case: int) -> list[FlownFlight]:
    """Return the flights of a case along its whole flight, one for each direction of the wind.

    They are ready to be flown. `case`: its index in the batch, whose dispersed values change flight
    and autopilot; gains stay scheduled by the nominal flight, which alone is known on board.
    """
    plan = campaign.along  # of the nominal flight
    assert plan is not None
    values = {name: float(np.ravel(value)[case]) for name, value in batch.values.items()}
    flight, autopilot = plan.flight, plan.autopilot
    if values:
        flight, autopilot = dispersed_flight(plan, campaign.dispersions, campaign.nominal, values)
    flights, (first, _last), wind_of_case = [], plan.span, batch.wind.case(case, (batch.count,))
    for wind in _winds_along(campaign, flight, wind_of_case, values):
        known_from, known_to = wind.known  # [s]
        # without a specified start a flight begins with its wind
        start = float(wind.history.onset) if plan.start is None else first
        start = max(start, first, known_from)
        stop = None if plan.stop is None else min(plan.stop, known_to)
        along = checked_flight(flight, autopilot, wind, start, stop, campaign.model, campaign.plane)
        flights.append(replace(along, scheduled=plan.flight))
    return flights


def _winds_along(
    campaign: Campaign, flight: FlightSchedule, wind: History, values: Mapping[str, float]
) -> list[WindAlong]:
    """Return the wind of a case along its flight, once for each of its possible directions.

    `flight`: dispersed flight of the case. `wind`: its wind in the plane of the campaign [rad].
    `values`: its dispersed values by name, with the index of a sounding under "wind". A sounding
    and a history over flight time have one direction, a pulse may be a head and a tail wind. The
    sign `FROZEN` stands for the nominal dynamic pressure, by request.
    """
    plane, sign = campaign.plane, campaign.sign
    if isinstance(campaign.wind, SoundingEnsemble):
        sounding = campaign.wind.soundings[int(values.get("wind", 0))]
        return [wind_along(flight, sounding, plane, sign)]
    if not isinstance(campaign.wind, ShapedWind):  # a history, whose sign is its direction
        wind_sign = FROZEN if not uses_encountered_pressure(sign) else None
        if wind_sign is None and plane == "pitch":
            wind_sign = "tail" if float(wind.peak) > 0.0 else "head"
        return [wind_along(flight, wind, plane, wind_sign)]
    time = float(np.asarray(campaign.vehicle.time))
    placed = place(wind, campaign.vehicle, time).in_flight  # with its peak at this time
    directions = campaign.directions() or (FROZEN,)
    # in yaw a wind is a cross wind, for which `wind_along` takes no direction
    signs = [name if name == FROZEN or plane == "pitch" else None for name in directions]
    return [wind_along(flight, placed, plane, name) for name in signs]


_BOUNDARY_TOLERANCE = 5e-4
"""Tolerance of a flown boundary, relative to the largest trim deflection."""
_VALUES_BEYOND = dict.fromkeys(("flight_survived", *plane_columns("flight_survived").values()), 0.0)
"""Values of outputs that are no angles, in a wind beyond linear aerodynamics."""


@dataclass(frozen=True)
class Output:
    """An output of campaigns: its columns and the function that computes them.

    `columns`: from a campaign to the units of the columns by name. `work`: from a campaign and a
    batch to the columns, ``(n,)`` each or a scalar for all cases; `InputError` when a case has no
    answer. `case_by_case`: from a campaign to whether `work` takes a single case at
    a time.
    """

    columns: Callable[[Campaign], dict[str, str]]
    work: Callable[[Campaign, Batch], dict[str, Any]]
    case_by_case: Callable[[Campaign], bool] = lambda _: False


def columns(campaign: Campaign) -> dict[str, str]:
    """Return the units of the columns of a campaign by name."""
    units: dict[str, str] = {}
    for output in campaign.outputs:
        units |= REGISTRY[output].columns(campaign)
    return units


def compute(campaign: Campaign, batch: Batch, *, case_by_case: bool) -> dict[str, FloatArray]:
    """Return the columns of outputs of a campaign for a batch of n cases, by name, ``(n,)`` each.

    `case_by_case`: compute the outputs that take a single case at a time, or else the others.

    In a wind beyond linear aerodynamics, and in one that is not known throughout, no deflection is
    known to be sufficient: it is infinite, and a flight counts as lost (`_VALUES_BEYOND`). Margins,
    which no wind changes, stay. `InputError` when a case has no answer.
    """
    outputs: dict[str, Any] = {}
    for name in campaign.outputs:
        if REGISTRY[name].case_by_case(campaign) == case_by_case:
            with naming(f"output {name}"):
                outputs |= REGISTRY[name].work(campaign, batch)
    shape, beyond = (batch.count,), ~within_linear(batch.wind_angle) | bool(campaign.unknown_wind)
    return {
        name: np.broadcast_to(values, shape)
        if name.startswith("margin_")
        else np.where(np.broadcast_to(beyond, shape), _VALUES_BEYOND.get(name, np.inf), values)
        for name, values in outputs.items()
    }


def _with_plane_columns(campaign: Campaign, columns: dict[str, str]) -> dict[str, str]:
    """Return units by column, with columns of each plane where a campaign judges both planes.

    `columns`: units by column of the limit shape, or of the only plane.
    """
    if campaign.planes != BOTH:
        return columns
    by_plane = {k: unit for name, unit in columns.items() for k in plane_columns(name).values()}
    return columns | by_plane


def _required(campaign: Campaign, batch: Batch) -> dict[str, FloatArray]:
    """Return the required deflections [rad] of a batch of n cases, ``(n,)`` by column.

    There are columns for each dead band of the campaign, the fraction K of the limit up to which
    the vehicle is trimmed. They are at the dynamic pressure encountered in the wind of each case.
    """
    required: dict[str, FloatArray] = {}
    for dead_band in campaign.dead_bands:
        required |= _required_at(campaign, batch, dead_band)
    return required


def _required_at(campaign: Campaign, batch: Batch, dead_band: float) -> dict[str, FloatArray]:
    """Return required deflections [rad] at the encountered dynamic pressure, ``(n,)`` by column.

    `batch`: n cases of the campaign. `dead_band`: K in [0, 1]. Where both planes are judged there
    are three columns: both planes (the limit of the limit shape), pitch and yaw. Requirements that
    are zero or infinite at nominal dynamic pressure are so at the encountered one too.
    """
    name, vehicles = required_name(dead_band), batch.vehicle.rigid
    # function from a plane to the requirements there, or to None in a campaign at nominal pressure
    at_encountered = partial(encountered_batch, campaign, batch.values, vehicles, dead_band)
    if not batch.plane_batches:
        plant, wind, shape = batch.plant, batch.wind, (batch.count,)
        required = at_encountered(campaign.plane)
        if required is None:
            return {name: np.abs(required_deflection(plant, wind, dead_band).deflection)}
        special = np.broadcast_to(may_be_zero_or_infinite(plant, wind, dead_band), shape)
        if np.any(special):
            cases = np.flatnonzero(special)
            plants, winds = plant.cases(cases, shape), wind.cases(cases, shape)
            nominal = required_deflection(plants, winds, dead_band).deflection
            required = np.array(np.broadcast_to(required, shape))
            required[cases] = _or_nominal(required[cases], np.abs(nominal))
        return {name: required}
    limit_shape = limit_shape_of(campaign.nozzle.limit_shape or "")
    nominal = two_plane_requirement(batch.plants, batch.vectors, limit_shape, dead_band)
    separate = {
        plane: _or_nominal(at_encountered(plane), nominal.separate[plane])
        for plane in batch.plane_batches
    }
    # a plane without wind has its requirement at nominal pressure
    by_plane = nominal.separate | separate
    return {name: nominal.encountered(separate)} | {
        column: by_plane[plane] for plane, column in plane_columns(name).items()
    }


def _or_nominal(required: FloatArray | None, nominal: FloatArray) -> FloatArray:
    """Return required deflections [rad] of n cases, zero and infinity from `nominal`, ``(n,)``.

    `required`: those at the dynamic pressure encountered, ``(n,)``; None for the nominal one.
    `nominal`: those at nominal dynamic pressure, ``(n,)``.
    """
    ordinary = np.isfinite(nominal) & (nominal != 0.0)
    return nominal if required is None else np.where(ordinary, required, nominal)


def _slow(campaign: Campaign) -> bool:
    """Return whether minimum peaks are searched case by case: with three poles, not as a batch."""
    return campaign.model == "drift-and-speed"


def _bound(
    name: str,
    plane_bound: Callable[[Plant, History], Any],
    vector_bound: Callable[[FrozenRequirement], float],
    campaign: Campaign,
    batch: Batch,
) -> dict[str, Any]:
    """Return a lower bound of the deflection limit [rad] of cases by column, ``(n,)``.

    `name`: name of its column. `plane_bound`: function from a plant and a wind in a plane to the
    bound there. `vector_bound`: function from the requirement of both planes to their bound.
    `batch`: n cases of the campaign; where both planes are judged, the first case alone counts.
    Then column `name` is the limit of the shape, and each plane has a column of its bound.
    """
    if not batch.plane_batches:
        return {name: plane_bound(batch.plant, batch.wind)}
    limit_shape, shape = limit_shape_of(campaign.nozzle.limit_shape or ""), (batch.count,)
    bounds = dict.fromkeys(PLANES, 0.0)
    for plane, in_plane in batch.plane_batches.items():
        first = in_plane.first
        bounds[plane] = float(np.abs(plane_bound(first.plant, first.wind)))
    # the bound of a plane over its limit in the shape with the limit one bounds the shape's limit
    limits = limit_shape.plane_limits.tolist()
    bound = max(x / limit for x, limit in zip(bounds.values(), limits, strict=True))
    if len(batch.plane_batches) > 1:
        pitch, yaw = (plant.case(0, shape) for plant in batch.plants.values())
        vectors = batch.vectors.case(0, shape)
        requirement = vector_requirements(pitch, yaw, vectors, limit_shape, np.ones(1))
        bound = max(bound, vector_bound(requirement))
    return {name: bound} | {k: bounds[plane] for plane, k in plane_columns(name).items()}


_MARGINS = {
    "margin_aero_dB": ("aero_margin_dB", "dB"),
    "margin_gain_dB": ("gain_increase_dB", "dB"),
    "margin_phase_deg": ("phase_margin_deg", "deg"),
    "margin_delay": ("delay_margin", "s"),
}
"""Margins of a loop by column: attribute of `Margins`, and unit."""


def _margin_columns(campaign: Campaign) -> dict[str, str]:
    """Return the units of the columns of margins of a campaign by name."""
    peaks = {f"margin_{mode}_peak_dB": "dB" for mode in _mode_names(campaign)}
    return {"margin_stable": ""} | {k: unit for k, (_, unit) in _MARGINS.items()} | peaks


def _mode_names(campaign: Campaign) -> list[str]:
    """Return the names of all modes of the nominal vehicle of a campaign, bending before slosh."""
    return [k for names in mode_names(campaign.vehicle.structure).values() for k in names]


def _margins(campaign: Campaign, batch: Batch) -> dict[str, Any]:
    """Return the margins of the autopilot of a campaign by column, in dB, deg and s, ``(n,)``.

    `batch`: n vehicles around which they are; a flexible one has the peaks of its modes too.
    """
    autopilot, peaks = replace(campaign.autopilot, **batch.gains), {}
    if batch.flexible is not None and _mode_names(campaign):
        bands = autopilot.band_margins(batch.flexible)
        margins = bands.margins
        pairs = zip(_mode_names(campaign), bands.modes, strict=True)
        peaks = {f"margin_{name}_peak_dB": mode.peak_dB for name, mode in pairs}
    else:
        margins = loop_margins(autopilot.exact_loop(batch.flying))
    return {
        "margin_stable": np.asarray(margins.stable, dtype=float),
        **{column: getattr(margins, name) for column, (name, _unit) in _MARGINS.items()},
        **peaks,
    }


def _flown_limits(campaign: Campaign, batch: Batch) -> dict[str, float]:
    """Return boundary limits [rad] by column, flown with six degrees of freedom.

    They are for the first case of a batch, at all dead bands of the campaign.
    """
    from tvclin.flights.flown_boundary import flown_boundary  # late, with the engines

    vehicle, wind = batch.first.vehicle, batch.first.wind

    def flown(K: float) -> float:
        """Return the magnitude [rad] of the flown boundary limit at a dead band K."""
        boundary = flown_boundary(
            vehicle, wind, K, engine="sixdof", plane=campaign.plane, tolerance=_BOUNDARY_TOLERANCE
        )
        return abs(boundary.deflection)

    return {required_name(K, "flown"): flown(K) for K in campaign.dead_bands}


REGISTRY = {
    "required": Output(
        lambda campaign: _with_plane_columns(
            campaign, {required_name(K): "rad" for K in campaign.dead_bands}
        ),
        _required,
        _slow,
    ),
    "forecast-free": Output(
        lambda campaign: _with_plane_columns(campaign, {"forecast_free": "rad"}),
        partial(
            _bound,
            "forecast_free",
            lambda plant, wind: np.abs(forecast_free_limit(plant, wind).deflection),
            lambda requirement: requirement.no_forecast,
        ),
        lambda campaign: campaign.planes == BOTH,
    ),
    "minimum": Output(
        lambda campaign: _with_plane_columns(campaign, {"minimum": "rad"}),
        partial(_bound, "minimum", minimum_peaks, lambda requirement: requirement.minimum),
        lambda campaign: _slow(campaign) or campaign.planes == BOTH,
    ),
    "margins": Output(_margin_columns, _margins),
    "flight": Output(lambda campaign: _with_plane_columns(campaign, COLUMNS), flights),
    "flown": Output(
        lambda campaign: {required_name(K, "flown"): "rad" for K in campaign.dead_bands},
        _flown_limits,
        lambda _: True,
    ),
}
"""Outputs of a campaign by name."""
