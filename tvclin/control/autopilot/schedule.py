"""Gains over the flight."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, callable_for, finite, instance
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import GAINS
from tvclin.control.autopilot.warnings import warn_of_feedback
from tvclin.control.margins.record import Margins, loop_margins
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import Coefficients


@dataclass(frozen=True, eq=False)
class GainSchedule:
    """Gains at several flight times, straight lines between them.

    Attributes
    ----------
    time : ndarray
        Flight times [s], rising, ``(n,)``.
    autopilot : Autopilot
        Its gains at those times, ``(n,)`` or the same for all; actuator and delay as they are.

    Raises
    ------
    InputError
        For times that do not rise, fewer than two, and gains of another shape.
    """

    time: FloatArray
    autopilot: Autopilot

    def __post_init__(self) -> None:
        time = finite("time", self.time, "s")
        if time.ndim != 1 or time.size < 2 or np.any(np.diff(time) <= 0.0):
            raise InputError("time must be two or more rising flight times in s")
        instance("autopilot", self.autopilot, Autopilot, "whose gains are one for each time")
        if self.autopilot.batch not in {(), time.shape}:
            raise InputError(
                f"autopilot must have one gain for each of the {time.size} times; got a batch of"
                f" shape {self.autopilot.batch}"
            )
        object.__setattr__(self, "time", time)

    @classmethod
    def design(
        cls,
        time: ArrayLike,
        coefficients: Coefficients,
        rule: Callable[..., Autopilot],
        **arguments: Any,
    ) -> Self:
        """Return the schedule that a rule gives, such as `design_gains` or `canonical_gains`.

        Parameters
        ----------
        time : array_like
            Flight times [s], rising, ``(n,)``.
        coefficients : Coefficients
            Those of the vehicle at each time, ``(n,)``.
        rule : callable
            Any of the functions that return an autopilot from coefficients.
        **arguments
            What the rule asks for.

        Examples
        --------
        >>> import tvclin as tv
        >>> c = tv.Coefficients(mu_alpha=[0.1, 0.28, 0.2], mu_delta=[2.0, 2.6, 3.0])
        >>> rule = {"natural_frequency": 1.0, "damping": 0.7}
        >>> times = [40.0, 66.0, 90.0]
        >>> schedule = tv.control.GainSchedule.design(times, c, tv.design_gains, **rule)
        >>> round(schedule.at(53.0).attitude_gain, 4)
        0.5212
        >>> schedule.margins(tv.Plant.from_coefficients(c)).stable.all().item()
        True
        """
        callable_for("rule", rule, "from coefficients to an Autopilot, such as design_gains")
        return cls(finite("time", time, "s"), rule(coefficients, **arguments))

    def at(self, time: ArrayLike) -> Autopilot:
        """Return the autopilot at a flight time, or at several.

        Raises
        ------
        InputError
            For a time outside the schedule: gains are not extrapolated.
        """
        when = finite("time", time, "s")
        outside = (when < self.time[0]) | (when > self.time[-1])
        if np.any(outside):
            raise InputError(
                f"time must lie in the schedule, {self.time[0]:.6g} to {self.time[-1]:.6g} s;"
                f" got {when[outside].ravel()[0]:.6g}"
            )
        held = {name: getattr(self.autopilot, name) for name in (*GAINS, "delay")}
        changes: dict[str, Any] = {
            name: np.interp(when, self.time, np.broadcast_to(values, self.time.shape))
            for name, values in held.items()
        }
        if self.autopilot.actuator is not None and self.autopilot.actuator.batch:
            raise InputError("an actuator that changes over the flight is not interpolated")
        return replace(self.autopilot, **changes)

    def margins(self, plants: Plant) -> Margins:
        """Return the margins at every flight time.

        Parameters
        ----------
        plants : Plant
            The plant at each of the times, ``(n,)``.

        Warns
        -----
        UserWarning
            As `Autopilot.loop`.
        """
        loop = self.autopilot.exact_loop(plants)
        warn_of_feedback(self.autopilot, plants)
        return loop_margins(loop)
