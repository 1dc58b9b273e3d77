"""What turns the nozzle of a flight: a history, a law, an autopilot, or the report's control."""

from dataclasses import dataclass, replace

from tvclin.autopilot import Actuator, Autopilot
from tvclin.errors import InputError, instance, within
from tvclin.histories import History
from tvclin.laws import Law, SaturatedLaw


@dataclass(frozen=True)
class ReportControl:
    """Trim until K times the deflection limit is asked for, then the whole limit for ever.

    The dead band is left by the trim deflection itself, which is the literal switch of
    `trim_then_hold`, but trim is what the measured angle of attack asks for.

    Parameters
    ----------
    dead_band : float
        K, from 0 to 1; zero applies the limit when the wind sets in.

    Raises
    ------
    InputError
        For a dead band outside [0, 1].
    """

    dead_band: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "dead_band", float(within("dead_band", self.dead_band, 0.0, 1.0)))


Control = History | Law | Autopilot | ReportControl
"""What can fly."""


def law_and_actuator(control: object, actuator: Actuator | None) -> tuple[Law, Actuator | None]:
    """Return the law of a law or an autopilot, and the actuator, which an autopilot may bring.

    Raises
    ------
    InputError
        For anything else, for an autopilot with a delay, and for two actuators.
    """
    if isinstance(control, Autopilot):
        if control.delay != 0.0:
            raise InputError("an autopilot with a delay is not flown; leave the delay out")
        if actuator is not None and control.actuator is not None:
            raise InputError("actuator must be left out: the autopilot has one")
        actuator = control.actuator or actuator
        control = SaturatedLaw(replace(control, actuator=None))
    instance("control", control, Law, "or a History, an Autopilot or a ReportControl")
    assert isinstance(control, Law)
    return control, actuator
