"""One case: a vehicle in a wind, its nozzle and autopilot, on a model and in a plane."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.errors import InputError, between, instance, number, one_of, shown
from tvclin.base.fields import checked, word
from tvclin.case.nozzle import Nozzle
from tvclin.linear.plant import DEFAULT_MODEL, MODELS, Plant, default_model, flexible_model
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.vehicle.linear_vehicle import FIXED_PATH, AnyVehicle, LinearVehicle, complete_vehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History, VehicleWind
from tvclin.winds.shaped import FixedWind, ShapedWind, WindEnsemble, heading_cosines
from tvclin.winds.wind_angles import CROSS, FROZEN, SIGNS

if TYPE_CHECKING:
    from tvclin.control.autopilot.autopilot import Autopilot
    from tvclin.control.autopilot.design_rules import AutopilotDesign
    from tvclin.linear.flexible import AnyPlant
    from tvclin.linear.system import LinearSystem

DEFAULT_WIND = ShapedWind("triangular", float(np.radians(5.0)), 7.5)
ANY_NOZZLE = Nozzle()
"""Nozzle without limits, with the usual actuator."""
FLIGHT_SAMPLE_RATE_HZ = 100.0
"""Sample rate [Hz] in flights of an autopilot without a sample rate."""


def _single_plane(name: str, value: object) -> str:
    """Return `value` if it is a plane; for both planes the `InputError` says how to judge them."""
    if isinstance(value, str) and value == BOTH:
        raise InputError(
            f"{name} must be one of {', '.join(PLANES)}; tvclin study judges both planes of a wind"
            " with a direction: --set wind.direction_deg DEG --azimuth-deg DEG --set"
            " nozzle.limit_shape round"
        )
    return one_of(name, value, PLANES)


@dataclass(frozen=True, kw_only=True)
class Case:
    """A vehicle in a wind, with its nozzle and its autopilot.

    Attributes
    ----------
    vehicle : Vehicle or LinearVehicle
        The vehicle, no batch, with its structure; `vehicle.rigid` is without it.
    model : str
        Model of the motion.
    plane : str
        Plane of the motion.
    wind : ShapedWind, WindEnsemble, VehicleWind or History
        The wind with its gust and its direction; 5 degrees for 7.5 seconds, a triangle, unless
        given. An ensemble is for campaigns, and a sounding, or any other history, for flights.
    nozzle : Nozzle
        Limits and actuator of the nozzle; with a limit shape of both planes both are judged.
    design : AutopilotDesign, optional
        Specification of the autopilot; by default canonical gains.
    plant_system : LinearSystem, optional
        State space in place of the plant of the autopilot's margins and flights, see `SystemPlant`;
        trim and boundaries are of the vehicle.
    controller : LinearSystem, optional
        State space in place of the gains of the design, whose delay, filters and sample rate stay,
        see `SystemAutopilot`.
    sign : str, optional
        Direction of a wind along the path for the required deflection: head or tail, with the
        dynamic pressure encountered, or frozen, at nominal dynamic pressure. Measured
        winds and winds with a heading have their own direction.

    Raises
    ------
    InputError
        For numbers out of range and unknown names.
    """

    vehicle: AnyVehicle
    model: str = word(
        MODELS,
        "",
        shown=f"{DEFAULT_MODEL}; {FIXED_PATH} where no more than mu_alpha and mu_delta is known",
    )
    plane: str = word(PLANES, "pitch", check=_single_plane)
    wind: ShapedWind | FixedWind | WindEnsemble | VehicleWind | History = DEFAULT_WIND
    nozzle: Nozzle = ANY_NOZZLE
    design: AutopilotDesign | None = None
    plant_system: LinearSystem | None = None
    controller: LinearSystem | None = None
    sign: str | None = word((*SIGNS, FROZEN), None, shown="the worse of head and tail")

    def __post_init__(self) -> None:
        """Set the default model; raise `InputError` for numbers out of range and unknown names."""
        if not isinstance(self.vehicle, LinearVehicle):
            instance("vehicle", self.vehicle, Vehicle, "see load_vehicle")
        if isinstance(self.model, str) and not self.model:
            object.__setattr__(self, "model", default_model(self.vehicle))
        checked(self)
        kinds = ShapedWind | FixedWind | WindEnsemble | VehicleWind | History
        if not isinstance(self.wind, kinds):
            raise InputError(
                f"wind must be a ShapedWind, a WindEnsemble or a History; got {shown(self.wind)}"
            )
        instance("nozzle", self.nozzle, Nozzle, "of a limit, a stop, a rate limit, an actuator")
        if self.design is not None:
            from tvclin.control.autopilot.design_rules import AutopilotDesign

            instance("design", self.design, AutopilotDesign, "of gains, or a rule for them")
        for name in ("plant_system", "controller"):
            if getattr(self, name) is not None:
                from tvclin.linear.system import LinearSystem

                instance(name, getattr(self, name), LinearSystem, "see linear.read_system")
        if self.controller is not None and self.design is not None and self.design.has_gains:
            raise InputError("a controller has its own gains; leave those of the design out")

    @property
    def shape(self) -> str:
        """Shape of the wind, such as "triangular"; "sampled" for a history."""
        return str(getattr(self.wind, "shape", "sampled"))

    @property
    def planes(self) -> str:
        """The judged plane; "both" where the nozzle has a limit shape of both planes."""
        return self.plane if self.nozzle.limit_shape is None else BOTH

    @property
    def loop_model(self) -> str:
        """Model of the plant of the autopilot: "drift-exact" for "drift" with a structure."""
        return flexible_model(self.vehicle.structure, self.model)

    @property
    def law_model(self) -> str:
        """Model of the plant in flights of laws: `loop_model`, but with constant speed.

        Laws do not measure the speed.
        """
        return DEFAULT_MODEL if self.model == "drift-and-speed" else self.loop_model

    @cached_property
    def plant(self) -> AnyPlant:
        """Plant of flights and autopilot: `plant_system`, a state space, if there is one.

        Else it is the vehicle's, flexible where the vehicle has a structure.
        """
        from tvclin.linear.flexible import plant_of

        plant = plant_of(self.vehicle, self.loop_model, self.plane)
        if self.plant_system is None:
            return plant
        from tvclin.linear.system_plant import SystemPlant

        return SystemPlant(self.plant_system, plant.coefficients)

    @property
    def heading(self) -> float | None:
        """Heading of the wind [rad]; None for a wind in the plane."""
        return getattr(self.wind, "heading", None)

    def directions(self, plane: str | None = None) -> tuple[str, ...]:
        """Return the possible directions of the wind: head and tail, one of them, or cross.

        `plane`: the judged plane, by default the plane of the case. Empty for the nominal dynamic
        pressure, by request. `InputError` for an unknown plane, and a sign of a wind that has a
        direction.
        """
        judged = self.plane if plane is None else one_of("plane", plane, PLANES)
        if self.sign is not None and self.sign not in SIGNS:
            return ()
        if self.heading is not None:
            if self.sign is not None:
                raise InputError(
                    "a wind with a direction is a head or a tail wind by that: leave sign"
                )
            along, _ = heading_cosines(self.heading)  # positive from behind
            along *= float(np.sign(getattr(self.wind, "peak", 1.0)))  # a negative peak reverses it
            return (CROSS if along == 0.0 else "tail" if along > 0.0 else "head",)
        if judged == "yaw":
            return (CROSS,)
        return tuple(SIGNS) if self.sign is None else (self.sign,)

    def wind_at(self, dead_band: float) -> ShapedWind:
        """Return the wind of a shape, with its gust at its time, or the worst for a dead band K.

        It keeps its heading; the worst time is taken for the wind in the plane. `dead_band`: K, the
        vehicle is trimmed up to K times the limit.
        """
        in_plane = self.wind_in_plane_at(dead_band)
        assert isinstance(self.wind, ShapedWind)
        assert isinstance(in_plane, ShapedWind)
        return replace(self.wind, gust_at=in_plane.gust_at)

    @cached_property
    def wind_in_plane(self) -> ShapedWind | FixedWind | WindEnsemble | History:
        """The wind in the plane, with its gust at its time, or at the worst time with K = 1.

        With the dead band K = 1 the vehicle is trimmed up to the limit.
        """
        return self.wind_in_plane_at(1.0)

    def wind_in_plane_at(self, dead_band: float) -> ShapedWind | FixedWind | WindEnsemble | History:
        """Return the wind in the plane, with the gust at the worst time for a dead band K.

        A wind with a heading is projected on the plane; an ensemble, a history and a wind without a
        gust are returned as they are. A gust keeps a time of its own, and one against the wind is
        in the wind's middle. `dead_band`: K, the vehicle is trimmed up to K times the limit.
        """
        wind, _ = self.placed_wind(dead_band)
        return wind

    def placed_wind(
        self, dead_band: float
    ) -> tuple[ShapedWind | FixedWind | WindEnsemble | History, str]:
        """Return the result of `wind_in_plane_at`, and why its gust may not be at the worst time.

        The reason is empty where that time is known; else the gust is at the worst time for the
        nominal dynamic pressure, or in the wind's middle. `dead_band`: K. `InputError` for a gust
        whose time is outside the wind.
        """
        wind = self.wind
        if isinstance(wind, VehicleWind):
            return wind.history(self.vehicle, self.plane), ""
        if not isinstance(wind, ShapedWind):
            return wind, ""
        if wind.heading is not None:
            vehicle = complete_vehicle(self.vehicle, "a wind with a direction")
            wind = wind.in_plane(self.plane, float(np.asarray(vehicle.attitude)))
        gust = wind.gust
        if gust is None:
            return wind, ""
        if wind.gust_at is not None:
            half = 0.5 * float(gust.end - gust.onset)
            if not -half < wind.gust_at < wind.duration + half:
                raise InputError(
                    f"the gust of {2.0 * half:.4g} s with its middle at {wind.gust_at:.4g} s lies"
                    f" outside the wind, which lasts from 0 to {wind.duration:.4g} s: give another"
                    " peak_time_s in [gust], or leave it out"
                )
            return wind, ""
        if float(gust.peak) * wind.peak < 0.0:
            return wind, ""
        time, reason = self._worst_gust_time(wind, dead_band)
        return replace(wind, gust_at=time), reason

    def _worst_gust_time(self, wind: ShapedWind, dead_band: float) -> tuple[float | None, str]:
        """Return the time [s] of the middle of the gust at which most is required, and a reason.

        The time is None where nothing is required, it is not known, or the vehicle is a batch. The
        reason says why it is not known at the dynamic pressure that counts; empty where it is.

        `wind`: the wind in the plane, with a gust. `dead_band`: K, the vehicle is trimmed up to K
        times the limit.
        """
        from tvclin.time_varying import gust_time  # late, with its engine

        plant = Plant.from_vehicle(self.vehicle, self.model, self.plane)
        if plant.batch:
            return None, ""
        searches = [gust_time.nominal_requirements_by_time(plant, wind, dead_band)]
        directions = self.directions()
        if directions and not isinstance(self.vehicle, LinearVehicle):
            assert isinstance(self.wind, ShapedWind)
            encountered = gust_time.encountered_requirements_by_time(
                self.vehicle, self.model, self.plane, self.wind, directions, dead_band
            )
            searches.insert(0, encountered)
        reason = ""
        for search in searches:
            try:
                time = gust_time.worst_gust_time(wind, search)
            except InputError as error:
                reason = reason or str(error)
            else:
                if time is not None:
                    return time, reason
        return None, reason

    @property
    def history(self) -> History:
        """The wind [rad] as a history, a gust at the worst time for the dead band K = 1.

        An ensemble gives its first wind.
        """
        return self.history_at(1.0)

    def history_at(self, dead_band: float) -> History:
        """Return the wind [rad] as a history, with the gust at the worst time for a dead band K.

        `dead_band`: K in [0, 1], the vehicle is trimmed up to K times the limit. With K = 1 it is
        of `wind_in_plane`, which is cached. Dispersed winds have their nominal values.
        """
        K = number("dead_band", dead_band, between(0.0, 1.0))
        wind = self.wind_in_plane if K == 1.0 else self.wind_in_plane_at(K)
        return wind if isinstance(wind, History) else wind.history({})

    @cached_property
    def one_sign_history(self) -> History:
        """The part [rad] of `history` with the sign of its peak, for the theorems that need it.

        It is `history` itself of any wind but a sounding with angles of both signs.
        """
        if isinstance(self.wind, VehicleWind) and not self.history.constant_sign:
            return self.wind.of_one_sign(self.vehicle, self.plane)
        return self.history

    @cached_property
    def unknown_wind(self) -> str:
        """Reason why survival is not known in the wind, a sounding with gaps; often empty."""
        if isinstance(self.wind, VehicleWind):
            return self.wind.unknown(self.vehicle, self.plane)
        return self.wind.why_unknown if isinstance(self.wind, FixedWind) else ""

    @property
    def hardware(self) -> dict[str, Any]:
        """Actuator, rate limit [rad/s], delay [s] and sample rate [Hz] of flights, by name."""
        design, rate_limit = self.autopilot_design, self.nozzle.rate_limit
        period = None if self.controller is None else self.controller.period  # [s]
        controller_rate = None if period is None else 1.0 / float(period)
        return {
            "actuator": self.nozzle.actuator,
            "rate_limit": np.inf if rate_limit is None else rate_limit,
            "delay": design.delay,
            "sample_rate": design.sample_rate or controller_rate or FLIGHT_SAMPLE_RATE_HZ,
        }

    @property
    def autopilot_design(self) -> AutopilotDesign:
        """Specification of the autopilot; canonical gains if `design` is None."""
        from tvclin.control.autopilot.design_rules import AutopilotDesign

        return self.design or AutopilotDesign()

    @cached_property
    def autopilot(self) -> Autopilot:
        """The autopilot, designed on the rigid plant; `InputError` where its gains cannot be.

        With a `controller`, a state space in place of gains, it is a `SystemAutopilot` of that,
        with the filters, `chains`, and the delays and sensors of the specification.
        """
        design = self.autopilot_design
        if self.controller is not None:
            from tvclin.control.autopilot.system_autopilot import SystemAutopilot

            chains: dict[str, Any] = design.chains
            return SystemAutopilot(
                self.controller,
                actuator=self.nozzle.actuator,
                delay=design.delay,
                sample_rate=design.sample_rate,
                acceleration_station=design.acceleration_station,
                accelerometer_bandwidth=design.accelerometer_bandwidth,
                **chains,
            )
        return design.autopilot(self.plant.rigid, self.nozzle.actuator)
