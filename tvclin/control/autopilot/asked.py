"""An autopilot that is asked for: by its gains, or by a rule for them."""

from __future__ import annotations

from dataclasses import dataclass

from tvclin.base.errors import nonnegative, number, one_of
from tvclin.base.tables import Table
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import GAINS
from tvclin.control.autopilot.rules import DESIGNS, designed_autopilot
from tvclin.linear.plant import MODELS, Plant

_RULE = {"natural_frequency": "natural frequency", "damping": "number"}
_ACTUATOR = {"actuator_frequency": "natural frequency", "actuator_damping": "number"}
AUTOPILOT_TABLE = Table(
    "[autopilot]", {**_RULE, **GAINS, **_ACTUATOR, "delay": "delay"}, words=("design", "model")
)


@dataclass(frozen=True, kw_only=True)
class GainsAsked:
    """The autopilot that is to be judged; the gains are given, or follow from a rule.

    Attributes
    ----------
    model : str
        The model that is controlled.
    design, natural_frequency, damping, attitude_gain, rate_gain, alpha_gain
        As of `designed_autopilot`.
    integral_gain : float
        On the integrated attitude [1/s].
    actuator_frequency, actuator_damping : float
        As of `designed_autopilot`.
    delay : float
        Between sensors and actuator [s].
    """

    model: str = "drift"
    design: str | None = None
    natural_frequency: float | None = None
    damping: float | None = None
    attitude_gain: float | None = None
    rate_gain: float | None = None
    alpha_gain: float | None = None
    integral_gain: float = 0.0
    actuator_frequency: float = 25.1
    actuator_damping: float = 0.7
    delay: float = 0.0

    def __post_init__(self) -> None:
        one_of("model of the autopilot", self.model, MODELS)
        if self.design is not None:
            one_of("design", self.design, DESIGNS)
        for name in ("actuator_frequency", "delay"):
            object.__setattr__(self, name, number(name, getattr(self, name), nonnegative))
        for name in (*_RULE, *GAINS, "actuator_damping"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, number(name, getattr(self, name)))

    def autopilot(self, plant: Plant) -> Autopilot:
        """Return the autopilot for a plant; raise `InputError` as `designed_autopilot`."""
        asked = {name: value for name, value in vars(self).items() if name != "model"}
        return designed_autopilot(plant, **asked)
