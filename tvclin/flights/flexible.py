"""A flight by samples, also of a flexible vehicle, beside the rigid one with the same law."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.control.laws.law import Law
from tvclin.flights.answer import FARTHEST, OUTPUTS
from tvclin.flights.beside import FlightBeside
from tvclin.flights.closed_loop.fly import fly
from tvclin.flights.closed_loop.many import SURVIVED, FlownCases, fly_many
from tvclin.linear.flexible import AnyPlant
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import beyond_linear

NOT_KNOWN = "not known"
"""Status of a flight in a wind beyond linear aerodynamics."""
FATES = {
    "survived": "survives",
    "lost": "is lost",
    "rings": "is brought back, and its nozzle keeps oscillating",
    "undecided": "is neither lost nor settled",
    "no flight": "cannot be flown",
    NOT_KNOWN: "is not known to survive",
}
"""What became of a flight, as of `FlownCases`, in words."""


@dataclass(frozen=True, eq=False)
class SampledFlight(FlightBeside):
    """A flight of a law in steps with the limits of the nozzle; `linear` is the rigid vehicle.

    Of a rigid plant the two are the same. `status`: what became of both, flown and rigid, as of
    `FlownCases`. `peak_rates`: the largest rate of the nozzle [rad/s] of both, a mean over a
    sample.
    """

    status: tuple[str, str]
    peak_rates: tuple[float, float]

    @property
    def fates(self) -> tuple[str, str]:
        """What becomes of both, in words."""
        return FATES[self.status[0]], FATES[self.status[1]]

    @property
    def largest(self) -> dict[str, tuple[float, float]]:
        """What is largest in both [rad, rad/s], by its name."""
        return super().largest | {"largest rate of the nozzle [deg/s]": self.peak_rates}


def fly_sampled(
    plant: AnyPlant, law: Law, wind: History, timepts: ArrayLike, **nozzle: Any
) -> SampledFlight:
    """Return a flight by samples, what became of it, and the same of the rigid vehicle.

    Arguments and errors as of `fly`; `nozzle`: deflection_limit, rate_limit, actuator, sample_rate
    and delay.
    """
    many: list[FlownCases] = [fly_many(one, law, wind, **nozzle) for one in (plant, plant.rigid)]
    beyond = beyond_linear(float(wind.peak))
    status = [NOT_KNOWN if beyond else str(one.status) for one in many]
    times = np.asarray(timepts, dtype=float)
    rows = [_rows(one, law, wind, times, nozzle) for one in (plant, plant.rigid)]
    return SampledFlight(
        times=times,
        flown=rows[0],
        linear=rows[1],
        wind=wind,
        survived=None if beyond else status[0] == SURVIVED,
        predicted=None if beyond else status[1] == SURVIVED,
        let_go=(np.inf, np.inf),
        status=(status[0], status[1]),
        peak_rates=(float(many[0].peak_deflection_rate), float(many[1].peak_deflection_rate)),
    )


def _rows(
    plant: AnyPlant, law: Law, wind: History, times: FloatArray, nozzle: dict[str, Any]
) -> FloatArray:
    """The `OUTPUTS`, ``(5, n)``; NaN from where the model holds no longer."""
    flown, nothing = fly(plant, law, wind, times, **nozzle), np.zeros(times.size)
    there = (*plant.outputs, "deflection")  # a fixed path has no angle
    rows = np.stack([flown.outputs[name] if name in there else nothing for name in OUTPUTS])
    beyond = np.flatnonzero(np.abs(rows[0]) > FARTHEST)
    rows[:, beyond[0] if beyond.size else times.size :] = np.nan
    return rows
