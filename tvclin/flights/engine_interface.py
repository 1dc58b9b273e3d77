"""Interface of the engines of nonlinear flights: the nozzle command, and the verdict on a flight.

A command is a history, a law, an autopilot, or the report's control. The verdict is the sign of the
attitude rate long after the wind: with a limit that is too small the vehicle tumbles in the
direction in which the wind turns it. With a sufficient limit a law returns it to equilibrium; the
report's control, which holds the limit for ever, turns it the other way.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import radians

import numpy as np

from tvclin.base.errors import InputError, between, instance, limit_angle, single
from tvclin.base.fields import checked, quantity
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.laws.autopilot_law import SaturatedLaw
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.checks import check_actuator, check_rate_limit
from tvclin.linear.lateral import NO_LATERAL_SENSORS, LateralSensors
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind


@dataclass(frozen=True)
class ReportControl:
    """The report's control: trim until K times the deflection limit, then the full limit for ever.

    The switch acts on the trim deflection, as the literal switch of `trim_then_hold`. Trim follows
    the measured angle of attack, and the feedback of `TrimLaw` corrects its residual error.

    Parameters
    ----------
    dead_band : float
        K, from 0 to 1; zero applies the limit when the wind sets in.

    Raises
    ------
    InputError
        For a dead band outside [0, 1].
    """

    dead_band: float = quantity("number", 1.0, between(0.0, 1.0))

    def __post_init__(self) -> None:
        """Raise `InputError` for a dead band outside [0, 1]."""
        checked(self)


ONSET_OVER_LIMIT = 1e-9
"""Demand, over the limit, at which a control without dead band takes a wind to have begun."""
Control = History | Law | Autopilot | ReportControl
"""Types that command the nozzle of a flight."""


@dataclass(frozen=True, eq=False)
class Command:
    """Command of the nozzle and its hardware, checked; made by `command_of`.

    `control`: source of the command. `actuator`: actuator between a law and the nozzle.
    `rate_limit`: largest deflection rate [rad/s] of a law.
    """

    control: History | ReportControl | Law
    actuator: Actuator | None = None
    rate_limit: float = np.inf

    @property
    def lateral_sensors(self) -> LateralSensors:
        """Sensors of lateral motion of a law; none of another control."""
        return self.control.lateral_sensors if isinstance(self.control, Law) else NO_LATERAL_SENSORS


def command_of(
    control: object, start: float, actuator: Actuator | None = None, rate_limit: float = np.inf
) -> Command:
    """Return the command of the nozzle in a flight that begins at `start` [s].

    `control`: deflection history, law, autopilot, or the report's control. `actuator`: nozzle
    dynamics of a law. `rate_limit`: limit of its deflection rate [rad/s]. `InputError` for another
    type, histories in a batch or from before the flight, an autopilot with a delay, filters, two
    actuators, and hardware without a law.
    """
    max_rate = check_rate_limit(rate_limit)
    if isinstance(control, History | ReportControl):
        if actuator is not None or max_rate < np.inf:
            raise InputError("actuator and rate_limit belong to a law or an autopilot")
        if isinstance(control, History):
            check_history("control", control, start)
        return Command(control)
    if isinstance(control, Autopilot):
        if control.delay != 0.0:
            raise InputError("an autopilot with a delay is not flown; leave the delay out")
        if actuator is not None and control.actuator is not None:
            raise InputError("actuator must be left out: the autopilot has one")
        actuator = control.actuator or actuator
        control = SaturatedLaw(replace(control, actuator=None))
    check_actuator(actuator)
    instance("control", control, Law, "or a History, an Autopilot or a ReportControl")
    assert isinstance(control, Law)
    if any(control.chains):
        raise InputError("filters are flown by fly() with a sample_rate; leave them out here")
    return Command(control, actuator, max_rate)


def check_path(drift: bool, sensors: LateralSensors) -> None:
    """Raise `InputError` for drift that is measured on a path that does not turn.

    `drift`: whether the path may turn. `sensors`: lateral sensors of the law.
    """
    if not drift and (sensors.drift_rate or sensors.drift):
        raise InputError("drift is fed back, but the path of this flight is fixed; set drift")


def limit_of(control: object, deflection_limit: float) -> float:
    """Return the deflection limit [rad] of a control; `InputError` unless it is positive.

    It may be infinite for a history of the deflection.
    """
    if isinstance(control, History) and deflection_limit == np.inf:
        return np.inf
    return limit_angle(deflection_limit)


def check_history(name: str, history: object, start: float) -> None:
    """Raise `InputError` unless `history` is a single one with an onset at `start` [s] or later.

    `name`: name of the argument, for the message.
    """
    instance(name, history, History, "such as TriangularWind")
    assert isinstance(history, History)
    single(name, history.batch)
    if history.onset < start:
        raise InputError(
            f"{name} must not begin before the flight, at {start:.6g} s; got {name} from"
            f" {float(history.onset):.6g} s on"
        )


MAX_ATTITUDE = radians(25.0)
"""Largest attitude from the nominal [rad] at which forces linear in alpha are a valid model."""
OUTPUTS = ("attitude", "attitude_rate", "flight_path_angle", "angle_of_attack", "deflection")


def warn_of_the_end(time: float) -> None:
    """Warn that a flight left the range of its model, attitudes up to 25 degrees, at a time [s].

    The warning names the line that called the caller, which is the user's.
    """
    warnings.warn(
        f"the flight ends at t = {time:.6g} s, where its attitude is more than 25 deg from the"
        " nominal: beyond, the model holds no longer",
        stacklevel=3,
    )


_VERDICT_TIME_TIMES_POLE = 12.0
"""Time after the wind at which a flight is judged, times the pole: errors have grown by e^12."""
_MIN_FALL_RATE = 0.1
"""Smallest late attitude rate of a fall, over the pole times the wind's peak."""


def verdict_time(wind: History | PlaneWind, pole: float) -> float:
    """Return the time [s] of the verdict on a flight that stays within the range of its model.

    It is 12 times 1/pole after the wind: by then deviations at its end have grown by e^12. `wind`:
    one wind that ends. `pole`: unstable pole of the vehicle [1/s].
    """
    return float(wind.end) + _VERDICT_TIME_TIMES_POLE / pole


def has_fallen(rate: float, peak: float, pole: float) -> bool:
    """Return whether a late attitude rate [rad/s], positive in the direction of a fall, means one.

    It does above a tenth of pole times peak of the wind. `peak`: peak of the wind [rad]. `pole`:
    unstable pole of the vehicle [1/s].
    """
    return rate > _MIN_FALL_RATE * pole * abs(peak)


def verdict_of(
    late_rate: Callable[[float], float], control: object, wind: History, pole: float
) -> Callable[[float], bool]:
    """Return the function from a deflection limit [rad] to whether its flight survives.

    `late_rate`: function from a limit to the attitude rate [rad/s] at the time of the verdict.
    `control`: a law, which returns to equilibrium and must not fall in either direction; or the
    report's control, which holds the limit for ever and is lost only in the direction in which the
    wind turns the vehicle: a positive wind to negative attitudes. `wind`: one wind. `pole`:
    unstable pole of the vehicle [1/s].
    """
    peak, is_law = float(wind.peak), isinstance(control, Law)

    def survives(limit: float) -> bool:
        """Return whether the flight with a deflection limit [rad] survives: no late fall."""
        rate = late_rate(limit)  # of the attitude [rad/s], at the time of the verdict
        rate_with_wind = -rate if peak > 0.0 else rate
        return not has_fallen(abs(rate) if is_law else rate_with_wind, peak, pole)

    return survives
