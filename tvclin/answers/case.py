"""One case: a vehicle in a wind, its limit and autopilot, on a model and in a plane."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from tvclin.base.errors import InputError, instance, number, one_of, positive, shown, small_angle
from tvclin.boundary.stops import Stop, stop_of
from tvclin.linear.models import MODELS, usual_model
from tvclin.vehicle.coefficients import PLANES
from tvclin.vehicle.linear_vehicle import AnyVehicle, LinearVehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.shaped import ShapedWind, WindEnsemble

if TYPE_CHECKING:
    from tvclin.control.autopilot.autopilot import Autopilot
    from tvclin.control.autopilot.rules import GainsAsked
    from tvclin.linear.flexible import AnyPlant

DEFAULT_WIND = ShapedWind("triangular", float(np.radians(5.0)), 7.5)


@dataclass(frozen=True, kw_only=True)
class Case:
    """A vehicle in a wind, with the limit of its nozzle and its autopilot.

    Attributes
    ----------
    vehicle : Vehicle or LinearVehicle
        The vehicle, one, with its structure; `vehicle.rigid` leaves that out.
    model, plane : str
        The model, `usual_model` of the vehicle where it is not given, and the plane of motion.
    wind : ShapedWind, WindEnsemble or History
        The wind with its gust and its direction; 5 degrees for 7.5 seconds, a triangle, unless
        given. An ensemble is for campaigns, and any other history for flights.
    limit : float, optional
        The deflection capability [rad] in question.
    nozzle_stop : Stop or str, optional
        What the nozzle can do in both planes, as of `size`: then the verdict is on both. It needs a
        wind with a direction.
    gains : GainsAsked, optional
        The autopilot.

    Raises
    ------
    InputError
        For numbers out of range and unknown names.
    """

    vehicle: AnyVehicle
    model: str = ""
    plane: str = "pitch"
    wind: ShapedWind | WindEnsemble | History = DEFAULT_WIND
    limit: float | None = None
    nozzle_stop: Stop | str | None = None
    gains: GainsAsked | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.vehicle, LinearVehicle):
            instance("vehicle", self.vehicle, Vehicle, "see load_vehicle")
        if isinstance(self.model, str) and not self.model:
            object.__setattr__(self, "model", usual_model(self.vehicle))
        one_of("model", self.model, MODELS)
        one_of("plane", self.plane, PLANES)
        if not isinstance(self.wind, ShapedWind | WindEnsemble | History):
            raise InputError(
                f"wind must be a ShapedWind, a WindEnsemble or a History; got {shown(self.wind)}"
            )
        if self.limit is not None:
            object.__setattr__(
                self, "limit", number("limit", self.limit, small_angle("a deflection", positive))
            )
        if self.nozzle_stop is not None:
            stop_of(self.nozzle_stop)
            if getattr(self.wind, "heading", None) is None:
                raise InputError(
                    "a stop of both planes needs a wind with a direction: give where it blows from,"
                    " and the azimuth of the flight"
                )
        if self.gains is not None:
            from tvclin.control.autopilot.rules import GainsAsked

            instance("gains", self.gains, GainsAsked, "or a rule for them")

    @property
    def shape(self) -> str:
        """Shape of the wind."""
        return str(getattr(self.wind, "shape", "sampled"))

    @property
    def loop_model(self) -> str:
        """The model that the autopilot controls."""
        return (self.gains and self.gains.model) or self.model

    @cached_property
    def plant(self) -> AnyPlant:
        """What flies, and what the autopilot controls: flexible where the vehicle bends."""
        from tvclin.linear.flexible import plant_of

        return plant_of(self.vehicle, self.loop_model, self.plane)

    @property
    def history(self) -> History:
        """The wind in the plane with its gust; of an ensemble the first."""
        if isinstance(self.wind, History):
            return self.wind
        if isinstance(self.wind, WindEnsemble) or self.wind.heading is None:
            return self.wind.history({})
        from tvclin.vehicle.linear_vehicle import whole_vehicle

        whole = whole_vehicle(self.vehicle, "a wind with a direction")
        return self.wind.in_plane(self.plane, float(np.asarray(whole.attitude))).history({})

    @property
    def asked(self) -> GainsAsked:
        """The autopilot that is asked for; the canonical one where nothing is said."""
        from tvclin.control.autopilot.rules import GainsAsked

        return self.gains or GainsAsked()

    @cached_property
    def autopilot(self) -> Autopilot:
        """The autopilot, designed on the rigid plant; `InputError` as `GainsAsked.autopilot`."""
        return self.asked.autopilot(self.plant.rigid)
