"""What an autopilot is made of: gains, filters, actuator, delay and sample rate, checked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Carded
from tvclin.base.documents import picked
from tvclin.base.errors import InputError, broadcast, each, nonnegative, plain, shown
from tvclin.base.lines import Line, Row, Table, significant
from tvclin.control.autopilot.actuator import LARGEST, LEAST_GAIN, Actuator, sized, zero_or_sized
from tvclin.vehicle.filters import Filter, cells_of

GAINS = {
    "attitude_gain": "number",
    "rate_gain": "time",
    "alpha_gain": "number",
    "integral_gain": "per time",
}
"""The gains, and of what kind of `UNITS` each is."""
CHAINS = ("attitude_filters", "rate_filters", "filters")
_PLACES = dict(zip(CHAINS, ("on the attitude", "on the rate", "behind the sum"), strict=True))
_HIGHEST_PADE = 10
"""Beyond, the coefficients of the approximation span more decades than a number has digits."""


@dataclass(frozen=True, kw_only=True)
class Feedback(Carded):
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

    _keys = (
        "attitude_gain rate_gain_s alpha_gain integral_gain_per_s actuator delay_s"
        " sample_rate_Hz attitude_filters rate_filters filters"
    )

    def as_dict(self) -> dict[str, Any]:
        """Return the record as the command line prints it as JSON, angles in degrees."""
        gains = "attitude_gain rate_gain_s alpha_gain integral_gain_per_s delay_s actuator"
        return picked(self, f"{gains} {' '.join(CHAINS)} sample_rate_Hz")

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

    def rows(self) -> list[Row]:
        """Return the numbers of one autopilot as tables show them; gains of zero are left out."""
        rows = [
            ("attitude gain a0", significant("gains.attitude", self.attitude_gain, 5)),
            ("rate gain a1", significant("gains.rate", self.rate_gain, 5, "s")),
        ]
        if self.alpha_gain:
            rows.append(("alpha gain b0", significant("gains.alpha", self.alpha_gain, 5)))
        if self.integral_gain:
            integral = significant("gains.integral", self.integral_gain, 5, "1/s")
            rows.append(("integral gain aI", integral))
        engine: Line = ("none",)
        if self.actuator is not None:
            frequency, damping = self.actuator.natural_frequency, self.actuator.damping
            engine = significant("gains.actuator_frequency", frequency, 4, "rad/s, damping ")
            engine = (*engine, *significant("gains.actuator_damping", damping, 3))
        delay = significant("gains.delay_ms", 1000.0 * np.asarray(self.delay), 4, "ms")
        rows += [("actuator", engine), ("delay", delay)]
        if self.sample_rate is not None:
            rows.append(("samples", significant("gains.sample_rate", self.sample_rate, 5, "Hz")))
        return rows

    def filter_tables(self) -> list[Table]:
        """Return a table with the numbers of every filter of one autopilot; none without any."""
        rows: list[tuple[Line, ...]] = [
            ((f"{place}, {k}",), *cells_of(one, f"gains.{name}.{k}"))
            for name, place in _PLACES.items()
            for k, one in enumerate(getattr(self, name), start=1)
        ]
        return [Table("Filters", ("where", "zeros", "poles", "gain"), tuple(rows))] if rows else []

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
