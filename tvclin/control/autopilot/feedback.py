"""Parameters of an autopilot, checked: gains, filters, actuator, delay and sample rate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Record
from tvclin.base.errors import InputError, broadcast, each, nonnegative, number, plain, shown
from tvclin.base.fields import Field, spec, specs
from tvclin.base.lines import Line, Row, Table, quantities, significant
from tvclin.base.units import si_unit
from tvclin.control.autopilot.actuator import (
    MAX_MAGNITUDE,
    MIN_GAIN,
    Actuator,
    positive_in_range,
    zero_or_in_range,
)
from tvclin.linear.lateral import ACCELERATION, DRIFT, DRIFT_RATE, LateralSensors
from tvclin.linear.plant import STATION_RANGE
from tvclin.linear.system import LinearSystem
from tvclin.vehicle.filters import Filter, filter_cells

GAINS = {
    "attitude_gain": "number",
    "rate_gain": "time",
    "alpha_gain": "number",
    "integral_gain": "per time",
    "drift_rate_gain": "angle per speed",
    "drift_gain": "angle per length",
    "acceleration_gain": "angle per acceleration",
}
"""Names of the gains, each with its kind of unit in `base.units`."""
_SYMBOLS = dict(zip(GAINS, ("a0", "a1", "b0", "aI", "d1", "d0", "g"), strict=True))
"""Symbols of the gains."""
ACCELEROMETER = ("acceleration_station", "accelerometer_bandwidth")
"""Names of the numbers of the lateral accelerometer."""
ACCELEROMETER_BANDWIDTH = 100.0
"""Default bandwidth of the lateral accelerometer [rad/s]."""
CHAINS = ("attitude_filters", "rate_filters", "filters")
_CHAIN_LABELS = dict(zip(CHAINS, ("on the attitude", "on the rate", "behind the sum"), strict=True))
_MAX_PADE_ORDER = 10
"""Highest order of the Pade approximation: beyond, its coefficients span more decades than a
double has digits."""


def _lateral(name: str) -> Mapping[str, Any]:
    """Return the metadata of the gain `name`: a field of documents, and another of notebooks.

    Documents have the gain always, tables in notebooks only where it is not zero.
    """

    def if_present(autopilot: Feedback) -> Any:
        """Return the gain `name` of an autopilot; None where it is zero."""
        gain = getattr(autopilot, name)
        return gain if np.any(gain) else None

    kind = GAINS[name]
    return specs(Field(name, kind, card=False), Field(name, kind, of=if_present, document=False))


@dataclass(frozen=True, kw_only=True)
class Feedback(Record):
    """Parameters of an `Autopilot`, whose docstring describes them."""

    attitude_gain: float | FloatArray = field(metadata=spec())
    rate_gain: float | FloatArray = field(metadata=spec("time"))
    alpha_gain: float | FloatArray = field(default=0.0, metadata=spec())
    integral_gain: float | FloatArray = field(default=0.0, metadata=spec("per time"))
    drift_rate_gain: float | FloatArray = field(default=0.0, metadata=_lateral("drift_rate_gain"))
    drift_gain: float | FloatArray = field(default=0.0, metadata=_lateral("drift_gain"))
    acceleration_gain: float | FloatArray = field(
        default=0.0, metadata=_lateral("acceleration_gain")
    )
    acceleration_station: float = field(default=0.0, metadata=spec("length", card=False))
    accelerometer_bandwidth: float = field(
        default=ACCELEROMETER_BANDWIDTH, metadata=spec("natural frequency", card=False)
    )
    actuator: Actuator | None = field(default=None, metadata=spec())
    delay: float | FloatArray = field(default=0.0, metadata=spec("time"))
    pade_order: int = 4
    filters: tuple[Filter, ...] = field(default=(), metadata=spec())
    attitude_filters: tuple[Filter, ...] = field(default=(), metadata=spec())
    rate_filters: tuple[Filter, ...] = field(default=(), metadata=spec())
    sample_rate: float | FloatArray | None = field(default=None, metadata=spec("sample rate"))

    def __post_init__(self) -> None:
        """Check all parameters and convert them to plain numbers, arrays and tuples.

        `InputError` for values out of range, shapes that do not broadcast, and gains that do not
        fit each other.
        """
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
        for name in ("integral_gain", "drift_gain"):
            if np.any(gains[name]) and not np.all(gains[name]):
                raise InputError(f"{name} must be zero for all of a batch or for none")
        if np.any(gains["integral_gain"]) and np.any(gains["drift_gain"]):
            raise InputError(
                "integral_gain and drift_gain cannot both be used: the two integrals leave a mode"
                " without feedback; set one of them to zero"
            )
        station = number("acceleration_station", self.acceleration_station, STATION_RANGE, "m")
        bandwidth = number(
            "accelerometer_bandwidth", self.accelerometer_bandwidth, positive_in_range, "rad/s"
        )
        object.__setattr__(self, "acceleration_station", station)
        object.__setattr__(self, "accelerometer_bandwidth", bandwidth)
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

    @property
    def gains_text(self) -> str:
        """Text on the gains of one autopilot by their symbols, as "a0 = 0.2, a1 = 0.2 s".

        Gains of zero are omitted, but not on attitude and rate.
        """
        gains = [(name, getattr(self, name), si_unit(kind)) for name, kind in GAINS.items()]
        return ", ".join(
            f"{_SYMBOLS[name]} = {value:.4g} {unit}".rstrip()
            for name, value, unit in gains
            if value or name in ("attitude_gain", "rate_gain")
        )

    def rows(self) -> list[Row]:
        """Return the parameters of one autopilot as rows of a table: label, and value with unit.

        Gains of zero are omitted, but not on attitude and rate; filters have their own table.
        """
        rows: list[Row] = []
        for name, kind in GAINS.items():
            value = getattr(self, name)
            if value or name in ("attitude_gain", "rate_gain"):
                key = f"gains.{name.removesuffix('_gain')}"
                title = f"{name.replace('_', ' ')} {_SYMBOLS[name]}"
                rows.append((title, significant(key, value, 5, si_unit(kind))))
        if self.acceleration_gain:
            station = significant(
                "gains.acceleration_station", self.acceleration_station, 4, "m, bandwidth "
            )
            bandwidth = significant(
                "gains.accelerometer_bandwidth", self.accelerometer_bandwidth, 4, "rad/s"
            )
            rows.append(("accelerometer at", (*station, *bandwidth)))
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
    def lateral_sensors(self) -> LateralSensors:
        """Sensors of drift rate, drift and acceleration, those with a gain."""
        return LateralSensors(
            drift_rate=bool(np.any(self.drift_rate_gain)),
            drift=bool(np.any(self.drift_gain)),
            acceleration=bool(np.any(self.acceleration_gain)),
            station=self.acceleration_station,
            bandwidth=self.accelerometer_bandwidth,
        )

    @property
    def lateral_gains(self) -> dict[str, float | FloatArray]:
        """Gains on drift rate, drift and acceleration by the names of their sensors' outputs.

        Only those that are not zero; a controller in state space has none.
        """
        gains = {
            DRIFT_RATE: self.drift_rate_gain,
            DRIFT: self.drift_gain,
            ACCELERATION: self.acceleration_gain,
        }
        used = () if self.controller is not None else self.lateral_sensors.signals
        return {name: gains[name] for name in used}

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch of gains, delay, actuator and filters; ``()`` for one autopilot."""
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
