"""Parameters of an autopilot, checked: gains, filters, actuator, delay and sample rate."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Record
from tvclin.base.errors import InputError, broadcast, each, nonnegative, plain, shown
from tvclin.base.fields import spec
from tvclin.base.lines import Line, Row, Table, quantities, significant
from tvclin.control.autopilot.actuator import (
    MAX_MAGNITUDE,
    MIN_GAIN,
    Actuator,
    positive_in_range,
    zero_or_in_range,
)
from tvclin.linear.system import LinearSystem
from tvclin.vehicle.filters import Filter, filter_cells

GAINS = {
    "attitude_gain": "number",
    "rate_gain": "time",
    "alpha_gain": "number",
    "integral_gain": "per time",
}
"""Names of the gains, each with its kind of unit in `base.units`."""
CHAINS = ("attitude_filters", "rate_filters", "filters")
_CHAIN_LABELS = dict(zip(CHAINS, ("on the attitude", "on the rate", "behind the sum"), strict=True))
_MAX_PADE_ORDER = 10
"""Highest order of the Pade approximation: beyond, its coefficients span more decades than a
double has digits."""


@dataclass(frozen=True, kw_only=True)
class Feedback(Record):
    """Parameters of an `Autopilot`, whose docstring describes them."""

    attitude_gain: float | FloatArray = field(metadata=spec())
    rate_gain: float | FloatArray = field(metadata=spec("time"))
    alpha_gain: float | FloatArray = field(default=0.0, metadata=spec())
    integral_gain: float | FloatArray = field(default=0.0, metadata=spec("per time"))
    actuator: Actuator | None = field(default=None, metadata=spec())
    delay: float | FloatArray = field(default=0.0, metadata=spec("time"))
    pade_order: int = 4
    filters: tuple[Filter, ...] = field(default=(), metadata=spec())
    attitude_filters: tuple[Filter, ...] = field(default=(), metadata=spec())
    rate_filters: tuple[Filter, ...] = field(default=(), metadata=spec())
    sample_rate: float | FloatArray | None = field(default=None, metadata=spec("sample rate"))

    def __post_init__(self) -> None:
        gains = {name: zero_or_in_range(name, getattr(self, name), MIN_GAIN) for name in GAINS}
        delay = nonnegative("delay", self.delay, "s")
        delay = zero_or_in_range("delay", delay, 1.0 / MAX_MAGNITUDE, "s")
        for name, array in {**gains, "delay": delay}.items():
            object.__setattr__(self, name, plain(array))
        if not isinstance(self.actuator, Actuator | None):
            raise InputError(f"actuator must be an Actuator or None; got {shown(self.actuator)}")
        for name in CHAINS:
            chain = each(name, getattr(self, name), Filter, "Filter.notch(...)")
            object.__setattr__(self, name, chain)
        if self.sample_rate is not None:
            rate = positive_in_range("sample_rate", self.sample_rate, "Hz")
            object.__setattr__(self, "sample_rate", plain(rate))
        _ = self.batch  # raises for shapes that do not broadcast
        without_gain = np.all(np.stack(np.broadcast_arrays(*gains.values())) == 0.0, axis=0)
        if self.controller is None and np.any(without_gain):
            raise InputError(f"an autopilot needs a gain; {', '.join(GAINS)} are all zero")
        integral = gains["integral_gain"]
        if np.any(integral) and not np.all(integral):
            raise InputError("integral_gain must be zero for all of a batch or for none")
        order = self.pade_order
        is_integer = isinstance(order, int | np.integer) and not isinstance(order, bool)
        if not is_integer or not 1 <= order <= _MAX_PADE_ORDER:
            raise InputError(
                f"pade_order must be an integer from 1 to {_MAX_PADE_ORDER}; got {shown(order)}"
            )

    @property
    def controller(self) -> LinearSystem | None:
        """State space in place of the gains; None, but of a `SystemAutopilot`."""
        return None

    @property
    def continuous(self) -> Self:
        """Autopilot without samples."""
        return replace(self, sample_rate=None)

    def rows(self) -> list[Row]:
        """Return the parameters of one autopilot as rows of a table; gains of zero are omitted."""
        rows = [
            ("attitude gain a0", significant("gains.attitude", self.attitude_gain, 5)),
            ("rate gain a1", significant("gains.rate", self.rate_gain, 5, "s")),
        ]
        if self.alpha_gain:
            rows.append(("alpha gain b0", significant("gains.alpha", self.alpha_gain, 5)))
        if self.integral_gain:
            integral = significant("gains.integral", self.integral_gain, 5, "1/s")
            rows.append(("integral gain aI", integral))
        actuator: Line = ("none",)
        if self.actuator is not None:
            frequency, damping = self.actuator.natural_frequency, self.actuator.damping
            actuator = significant("gains.actuator_frequency", frequency, 4, "rad/s, damping ")
            actuator = (*actuator, *significant("gains.actuator_damping", damping, 3))
        delay = significant("gains.delay_ms", 1000.0 * np.asarray(self.delay), 4, "ms")
        rows += [("actuator", actuator), ("delay", delay)]
        if self.sample_rate is not None:
            rows.append(("samples", significant("gains.sample_rate", self.sample_rate, 5, "Hz")))
        return rows

    def tables(self) -> list[Table]:
        """Return a table of the parameters of one autopilot, and one of its filters, if any."""
        return [quantities("Autopilot", self.rows()), *self.filter_tables()]

    def filter_tables(self) -> list[Table]:
        """Return a table of the filters of one autopilot; an empty list without filters."""
        rows: list[tuple[Line, ...]] = [
            ((f"{label}, {position}",), *filter_cells(filter_, f"gains.{name}.{position}"))
            for name, label in _CHAIN_LABELS.items()
            for position, filter_ in enumerate(getattr(self, name), start=1)
        ]
        return [Table("Filters", ("where", "zeros", "poles", "gain"), tuple(rows))] if rows else []

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch; ``()`` for one autopilot."""
        shapes = {name: np.shape(getattr(self, name)) for name in (*GAINS, "delay")}
        if self.actuator is not None:
            shapes["actuator"] = self.actuator.batch
        for name in CHAINS:
            shapes |= {
                f"{name} {position}": filter_.batch
                for position, filter_ in enumerate(getattr(self, name), start=1)
            }
        if self.sample_rate is not None:
            shapes["sample_rate"] = np.shape(self.sample_rate)
        return broadcast(**shapes)
