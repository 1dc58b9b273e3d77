"""What is asked: one value for everything that can be moved."""

from dataclasses import dataclass

import numpy as np

from tvclin.control.laws.registry import AUTOPILOT, LAWS
from tvclin.linear.models import USUAL_MODEL
from tvclin.vehicle.vehicle import Vehicle

REPORT, TRIM, HALF_RELIEF = "report (open loop)", "trim", "half-relief"
CONTROLS = (REPORT, *LAWS)
_GAINS = ("attitude_gain", "rate_gain")
_OF_LAWS = dict.fromkeys(_GAINS, (AUTOPILOT,)) | {"delay": (AUTOPILOT, HALF_RELIEF)}
"""Fields that count with some laws only."""


@dataclass(frozen=True, kw_only=True)
class Choices:
    """A vehicle, a wind, a limit, a law and gains.

    Attributes
    ----------
    vehicle : Vehicle
        One vehicle.
    plane, model, shape : str
        As of `Study.from_vehicle`.
    duration : float
        Duration of the wind [s].
    peak : float
        Its peak wind angle of attack [rad].
    dead_band : float
        K.
    limit : float
        Deflection limit [rad].
    law : str
        One of `CONTROLS`: what turns the nozzle.
    attitude_gain, rate_gain : float
        a0 [rad/rad] and a1 [s], of the law of attitude and rate.
    delay : float
        Delay of the loop [s], of the margins of a law that has them, and not of its flight.
    """

    vehicle: Vehicle
    plane: str = "pitch"
    model: str = USUAL_MODEL
    shape: str = "triangular"
    duration: float = 7.5
    peak: float = float(np.radians(5.0))
    dead_band: float = 1.0
    limit: float = float(np.radians(0.4))
    law: str = TRIM
    attitude_gain: float = 0.5
    rate_gain: float = 0.55
    delay: float = 0.02


def idle(law: str) -> dict[str, str]:
    """Return the fields that change nothing with a law, each with the reason."""
    return {
        field: f"counts only with the law {' or '.join(laws)}"
        for field, laws in _OF_LAWS.items()
        if law not in laws
    }
