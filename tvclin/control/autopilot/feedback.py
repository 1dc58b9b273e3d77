"""What an autopilot is made of: gains, filters, actuator, delay and sample rate, checked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tvclin.base.errors import InputError, broadcast, each, nonnegative, plain, shown
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.sizes import LARGEST, LEAST_GAIN, sized, zero_or_sized
from tvclin.vehicle.filters import Filter

FloatArray = NDArray[np.float64]

GAINS = {
    "attitude_gain": "number",
    "rate_gain": "time",
    "alpha_gain": "number",
    "integral_gain": "per time",
}
"""The gains, and of what kind of `UNITS` each is."""
CHAINS = ("attitude_filters", "rate_filters", "filters")
_HIGHEST_PADE = 10


@dataclass(frozen=True, kw_only=True)
class Feedback:
    """The numbers of an `Autopilot`, which says what they are."""

    attitude_gain: float | FloatArray
    rate_gain: float | FloatArray
    alpha_gain: float | FloatArray = 0.0
    integral_gain: float | FloatArray = 0.0
    actuator: Actuator | None = None
    delay: float | FloatArray = 0.0
    pade_order: int = 4
    filters: tuple[Filter, ...] = ()
    attitude_filters: tuple[Filter, ...] = ()
    rate_filters: tuple[Filter, ...] = ()
    sample_rate: float | FloatArray | None = None

    def __post_init__(self) -> None:
        gains = {name: zero_or_sized(name, getattr(self, name), LEAST_GAIN) for name in GAINS}
        delay = nonnegative("delay", self.delay, "s")
        delay = zero_or_sized("delay", delay, 1.0 / LARGEST, "s")
        for name, array in {**gains, "delay": delay}.items():
            object.__setattr__(self, name, plain(array))
        if not isinstance(self.actuator, Actuator | None):
            raise InputError(f"actuator must be an Actuator or None; got {shown(self.actuator)}")
        for name in CHAINS:
            chain = each(name, getattr(self, name), Filter, "Filter.notch(...)")
            object.__setattr__(self, name, chain)
        if self.sample_rate is not None:
            rate = sized("sample_rate", self.sample_rate, "Hz")
            object.__setattr__(self, "sample_rate", plain(rate))
        _ = self.batch  # the shapes go together
        if np.any(np.all(np.stack(np.broadcast_arrays(*gains.values())) == 0.0, axis=0)):
            raise InputError(f"an autopilot needs a gain; {', '.join(GAINS)} are all zero")
        integral = gains["integral_gain"]
        if np.any(integral) and not np.all(integral):
            raise InputError("integral_gain must be zero for all of a batch or for none")
        order = self.pade_order
        whole = isinstance(order, int | np.integer) and not isinstance(order, bool)
        if not whole or not 1 <= order <= _HIGHEST_PADE:
            raise InputError(
                f"pade_order must be an integer from 1 to {_HIGHEST_PADE}; got {shown(order)}"
            )

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch; ``()`` for one autopilot."""
        shapes = {name: np.shape(getattr(self, name)) for name in (*GAINS, "delay")}
        if self.actuator is not None:
            shapes["actuator"] = self.actuator.batch
        for name in CHAINS:
            shapes |= {f"{name} {k}": f.batch for k, f in enumerate(getattr(self, name), start=1)}
        if self.sample_rate is not None:
            shapes["sample_rate"] = np.shape(self.sample_rate)
        return broadcast(**shapes)

    def require_plain(self, what: str) -> None:
        """Raise `InputError` for filters and a sample rate, which `what` does not know."""
        if self.sample_rate is not None or any(getattr(self, name) for name in CHAINS):
            raise InputError(
                f"{what} knows no filters and no sample_rate of an autopilot; replace them by ()"
                " and None, or ask for margins()"
            )
