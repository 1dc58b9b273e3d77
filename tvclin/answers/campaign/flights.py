"""Flights of a law with limits in every case: the law is designed on the nominal plant."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tvclin.base.errors import InputError, instance, number, one_of, positive, single, small_angle
from tvclin.base.tables import Table
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import GAINS
from tvclin.control.autopilot.gains import canonical_gains
from tvclin.control.laws.law import Law
from tvclin.control.laws.registry import AUTOPILOT, LAWS, design_law
from tvclin.flights.closed_loop.checks import check_rate_limit
from tvclin.flights.closed_loop.fly import fly
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.modes import unstable_modes
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from control import TimeResponseData

FloatArray = NDArray[np.float64]

FLIGHT_TABLE = Table(
    "[flight]",
    {
        "deflection_limit": "angle",
        "rate_limit": "angular rate",
        "sample_rate": "sample rate",
        **GAINS,
        "natural_frequency": "natural frequency",
        "damping": "number",
    },
    words=("law",),
    required=("deflection_limit",),
)
COLUMNS = {
    "flight_survived": "",
    "flight_peak_attitude": "rad",
    "flight_peak_angle_of_attack": "rad",
    "flight_peak_deflection": "rad",
}
MOTIONS = ("flight_peak_attitude", "flight_peak_angle_of_attack")
"""Angles that are no deflections, with which a deflection limit is not compared."""
_WATCHED = 20.0
"""A replayed flight ends so long after its wind, over the fastest unstable pole."""


@dataclass(frozen=True, kw_only=True)
class Flight:
    """How every case is flown.

    Attributes
    ----------
    law : str
        One of `LAWS`, as `design_law` designs it on the nominal plant.
    deflection_limit : float
        Largest deflection [rad].
    rate_limit : float
        Largest deflection rate [rad/s].
    sample_rate : float
        Samples of the law in a second [Hz].
    attitude_gain, rate_gain, alpha_gain, integral_gain : float, optional
        Of the autopilot, as of `Autopilot`; without the first two the canonical gains.
    natural_frequency, damping : float, optional
        Of the actuator, as of `Actuator`; without a frequency the nozzle follows at once.

    Raises
    ------
    InputError
        For an unknown law, gains of a law that has none, and numbers out of range.
    """

    law: str = AUTOPILOT
    deflection_limit: float
    rate_limit: float = np.inf
    sample_rate: float = 50.0
    attitude_gain: float | None = None
    rate_gain: float | None = None
    alpha_gain: float = 0.0
    integral_gain: float = 0.0
    natural_frequency: float | None = None
    damping: float = 0.7

    def __post_init__(self) -> None:
        one_of("law", self.law, LAWS)
        deflection = small_angle("a deflection", positive)
        for name, check in (("deflection_limit", deflection), ("sample_rate", positive)):
            object.__setattr__(self, name, number(name, getattr(self, name), check))
        object.__setattr__(self, "rate_limit", check_rate_limit(self.rate_limit))
        for name in GAINS:
            if getattr(self, name) is not None or name.startswith(("alpha", "integral")):
                object.__setattr__(self, name, number(name, getattr(self, name)))
        if (self.attitude_gain is None) != (self.rate_gain is None):
            raise InputError("give attitude_gain and rate_gain, or neither of them")
        if self.law != AUTOPILOT and (
            self.attitude_gain is not None or self.alpha_gain or self.integral_gain
        ):
            raise InputError(f'gains belong to the law "autopilot"; this is "{self.law}"')
        _ = self.actuator

    @property
    def actuator(self) -> Actuator | None:
        """The actuator, if there is one."""
        if self.natural_frequency is None:
            return None
        return Actuator(natural_frequency=self.natural_frequency, damping=self.damping)

    def gains(self, plant: Plant) -> dict[str, float]:
        """Return the nominal gains; nothing for a law that has none."""
        instance("plant", plant, Plant, "see Plant.from_vehicle")
        single("plant", plant.batch)
        if self.law != AUTOPILOT:
            return {}
        attitude, rate = self.attitude_gain, self.rate_gain
        if attitude is None or rate is None:
            canonical = canonical_gains(plant.coefficients)
            attitude, rate = float(canonical.attitude_gain), float(canonical.rate_gain)
        return {
            "attitude_gain": attitude,
            "rate_gain": rate,
            "alpha_gain": self.alpha_gain,
            "integral_gain": self.integral_gain,
        }

    def designed(self, plant: Plant, peak: float, gains: dict[str, Any]) -> Law:
        """Return the law, designed on a plant and for a peak [rad], or with these gains."""
        own = {AUTOPILOT: Autopilot(**gains)} if self.law == AUTOPILOT else {}
        return design_law(self.law, plant, peak, **own)


def flight_response(flight: Flight, law: Law, plant: AnyPlant, wind: History) -> "TimeResponseData":
    """Return the flight of one case at the samples of its law, until some time after its wind.

    Raises
    ------
    InputError
        As `fly`.
    """
    poles = np.real(unstable_modes(plant.rigid).poles)
    end = float(wind.end) + (_WATCHED / float(poles.max()) if poles.size else 0.0)
    count = int(np.ceil((end - float(wind.onset)) * flight.sample_rate)) + 1
    return fly(
        plant,
        law,
        wind,
        float(wind.onset) + np.arange(count) / flight.sample_rate,
        deflection_limit=flight.deflection_limit,
        rate_limit=flight.rate_limit,
        actuator=flight.actuator,
        sample_rate=flight.sample_rate,
    )
