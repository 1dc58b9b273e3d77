"""Motion of the nozzle in a flight: deflection, rate and acceleration, many times in a sample."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.batch import Hardware, one_flight
from tvclin.flights.closed_loop.checks import check_samples, check_span, paces
from tvclin.flights.closed_loop.many import LOST, NO_FLIGHT, fly_many
from tvclin.flights.closed_loop.track import outputs_of, tracked
from tvclin.linear.flexible import AnyPlant
from tvclin.winds.histories import History

_AFTER = 15.0
"""Length of a flight after its wind, in times of the fast mode: what moves then is rounding."""
_LOOKS_PER_RADIAN = 15.0
"""Times of a flight in 1/omega of the fastest pole of actuator and vehicle, at the least. A peak of
an oscillation is then missed by at most 1 - cos(1/30) of it, 0.06 percent; a product of two such
oscillations, as power is, is integrated by midpoints to (2 * 2/15)^2/24 of it, 0.3 percent."""
_MIN_LOOKS = 4
"""Times in a sample, at the least."""
_MAX_LOOKS = 1_000_000
"""Times in a wind, at the most, beyond which a flight is refused; and after it, where it ends."""


@dataclass(frozen=True, eq=False)
class NozzleFlight:
    """Outcome of a flight, and the motion of its nozzle; angles in rad.

    `times`: even times [s] from the first command on, `looks` in a sample, at the first of which
    the command changes, ``(n,)``; none of a flight that is lost or cannot be flown. `looks` is
    even. `rate`, `acceleration`: of the actuator right after the times; None without an actuator.
    """

    status: str
    times: FloatArray
    deflection: FloatArray
    angle_of_attack: FloatArray
    attitude: FloatArray
    rate: FloatArray | None
    acceleration: FloatArray | None
    looks: int = _MIN_LOOKS


def fly_nozzle(
    plant: AnyPlant,
    law: Law,
    wind: History,
    *,
    deflection_limit: float,
    rate_limit: float,
    actuator: Actuator | None,
    sample_rate: float,
    delay: float,
) -> NozzleFlight:
    """Return the motion of a nozzle in the flight of a law; arguments as of `fly_many`.

    `InputError` for a wind of more samples or times than can be held.
    """
    onset, end, h = float(wind.onset), float(wind.end), 1.0 / sample_rate
    looks = looks_per_sample(plant, actuator, h)
    longest = _longest(onset, end, h, looks)
    options: dict[str, Any] = {"deflection_limit": deflection_limit, "rate_limit": rate_limit}
    options |= {"actuator": actuator, "sample_rate": sample_rate, "delay": delay}
    status = str(fly_many(plant, law, wind, **options).status)
    none = np.empty(0)
    if status in (LOST, NO_FLIGHT):
        return NozzleFlight(status, none, none, none, none, None, None)
    late = onset + delay % h
    after = min(_AFTER / float(plant.coefficients.pole), longest)
    count = int(np.ceil((end - late + after) / h))
    times = np.asarray(late + h / looks * np.arange(count * looks + 1), dtype=np.float64)
    hardware = Hardware(h, delay, actuator, rate_limit)
    flight = one_flight(plant, law, wind, deflection_limit, hardware, until=times[-1] + h)
    rows, rate, acceleration = tracked(flight, times)
    seen = outputs_of(plant, rows, wind(times))
    alpha, attitude = (seen[plant.outputs.index(name)] for name in ("angle_of_attack", "attitude"))
    return NozzleFlight(status, times, rows[-1], alpha, attitude, rate, acceleration, looks)


def looks_per_sample(plant: AnyPlant, actuator: Actuator | None, length: float) -> int:
    """Return the even number of times in a sample [s] at which a flight is evaluated."""
    poles = np.zeros(1) if actuator is None else np.roots(actuator.denominator)
    fastest = max(float(np.abs(poles).max()), float(paces(plant)))
    return max(2 * int(np.ceil(_LOOKS_PER_RADIAN * fastest * length / 2.0)), _MIN_LOOKS)


def _longest(start: float, stop: float, length: float, looks: int) -> float:
    """Return the longest motion [s] that is evaluated; `InputError` for a wind that is longer."""
    check_span(start, stop)
    check_samples(stop - start, length)
    longest = _MAX_LOOKS / looks * length
    if stop - start > longest:
        lower = ", or a lower sample rate" if looks == _MIN_LOOKS else ""
        raise InputError(
            f"the wind of a nozzle's motion may last at most {longest:.4g} s, with {looks} times in"
            f" a sample at {1.0 / length:.4g} Hz; got {stop - start:.6g} s: take a wind that ends"
            f" earlier{lower}"
        )
    return longest
