"""One flight with limits: the public function `fly`, and the motion of its nozzle.

Without a sample rate the flight is integrated event-exact (`continuous`); with one it is stepped by
the kernel (`sampled`). `fly_nozzle` returns deflection, rate and acceleration at many times in each
sample.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, nonnegative, number, positive, small_angle, times_row
from tvclin.control.autopilot.actuator import Actuator, check_engine
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.batch import Hardware, one_flight
from tvclin.flights.closed_loop.checks import (
    check_actuator,
    check_delays,
    check_flight,
    check_pace,
    check_rate_limit,
    check_sample_rate,
    check_samples,
    check_span,
    paces,
)
from tvclin.flights.closed_loop.continuous import ContinuousFlight, Loop
from tvclin.flights.closed_loop.fly_many import LOST, NO_FLIGHT, fly_many
from tvclin.flights.closed_loop.sampled import outputs_of, tracked
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.plant import Plant
from tvclin.linear.response import time_response
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from control import TimeResponseData


def fly(
    plant: AnyPlant,
    law: Law,
    wind: History,
    timepts: ArrayLike,
    *,
    deflection_limit: float,
    rate_limit: float = np.inf,
    actuator: Actuator | None = None,
    sample_rate: float | None = None,
    delay: float = 0.0,
    gain: float = 1.0,
) -> TimeResponseData:
    """Return the flight of a law with limits, as `control.TimeResponseData`.

    It is at rest until the onset of the wind.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        One plant of any model. A flexible one needs a sample rate, and a law sees what its
        sensors say.
    law : Law
        The law, designed on this plant or on another.
    wind : History
        One wind that ends.
    timepts : array_like
        Times [s], ``(n,)``; breakpoints and switches need not be among them.
    deflection_limit : float
        Largest deflection [rad], positive.
    rate_limit : float
        Largest deflection rate [rad/s]; it needs an actuator or a sample rate. With a sample rate
        alone a step of the command is spread over the whole sample, see `fly_many`.
    actuator : Actuator, optional
        Without one the deflection follows its command at once.
    sample_rate : float, optional
        Samples of the law in a second [Hz], the first at the onset of the wind; the command is
        held between them. Without one the law is computed without pause.
    delay : float
        Computing delay [s], from a sample to when its command takes effect; it needs a sample
        rate, of which it need not be a whole number of samples.
    gain : float
        Factor on what the law asks for, positive, ahead of its switch and of the limit, as of
        `fly_many`.

    Returns
    -------
    control.TimeResponseData
        Outputs those of the plant, and the deflection [rad, rad/s]; input wind [rad].

    Raises
    ------
    InputError
        For batches, limits or a gain that are not positive, a wind that never ends, times long
        after the flight is lost, samples that are far too long for the actuator, noise, a delay
        or a rate limit that need a sample rate, and a law that looks at the deflection where it has
        neither an actuator nor a sample before it.

    Notes
    -----
    Without pause, the breakpoints of the wind, the limit, the switches of the law, and the rate
    limit and the stop of an actuator are hit by the solver, which runs anew from each to the next,
    however short the limit is touched. The attitude is exact to about 1e-9 of its largest value, to
    1e-8 with a law that leans; a flight that is nearly lost multiplies both. With a sample rate a
    sample is exact in which the nozzle meets no limit; `fly_many` says how others are walked, and
    how exactly. Either way a late gust is never missed.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> wind = tv.TriangularWind(peak=0.1, duration=8.0)
    >>> law = tv.RecoverableAttitudeLaw(plant, design_peak=0.1)
    >>> flown = tv.fly(plant, law, wind, np.linspace(0, 40, 9), deflection_limit=0.0045)
    >>> bool(abs(flown.outputs["attitude"][-1]) < 1e-6)
    True
    """
    check_flight(plant, law, wind)
    times = times_row("timepts", timepts)
    limit = number(
        "deflection_limit", deflection_limit, small_angle("a deflection", positive), "rad"
    )
    most, factor = check_rate_limit(rate_limit), number("gain", gain, positive)
    check_engine(plant, actuator)
    check_span(float(wind.onset), float(times.max()))
    if sample_rate is None:
        if delay:
            raise InputError("a delay belongs to samples; give a sample_rate")
        if plant.structure is not None:
            raise InputError("a flexible plant is flown by samples; give a sample_rate")
        rows = _continuous(plant, law, wind, times, (limit, most), actuator, factor)
    else:
        length = 1.0 / check_sample_rate(sample_rate, actuator)
        late = float(check_delays(number("delay", delay, nonnegative, "s"), np.asarray(length)))
        hardware = Hardware(length, late, actuator, most)
        rows = _sampled(plant, law, wind, times, limit, hardware, factor)
    outputs = np.vstack([outputs_of(plant, rows, wind(times)), rows[-1:]])
    labels, name = (*plant.outputs, "deflection"), f"{plant.model} with limits"
    title = f"Flight with limits, {plant.model} model"
    return time_response(times, outputs, labels, name=name, title=title, wind=wind)


def _continuous(
    plant: Plant,
    law: Law,
    wind: History,
    times: FloatArray,
    limits: tuple[float, float],
    actuator: Actuator | None,
    gain: float,
) -> FloatArray:
    if law.rate_noise[0]:
        raise InputError("noise belongs to samples; give a sample_rate")
    if any(law.chains):
        raise InputError("filters are flown by samples; give a sample_rate")
    if limits[1] < np.inf and actuator is None:
        raise InputError("a rate_limit needs an actuator or a sample_rate")
    check_actuator(actuator)
    # any time is like another, and near zero it is known more sharply
    start, loop = float(wind.onset), Loop(LinearEquations(plant), law, *limits, actuator, gain)
    flight, times = ContinuousFlight(loop, wind.shift(-start)), times - start
    return flight.shown(flight.arcs(0.0, float(times.max())), times)


@dataclass(frozen=True, eq=False)
class LinearEquations:
    """The `Equations` of a plant, all of whose states are angles, or angles in a second."""

    plant: Plant

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return self.plant.states

    @property
    def scales(self) -> FloatArray:
        """All are alike."""
        return np.ones(len(self.states))

    def rates(self, t: float, x: FloatArray, deflection: float, gust: float) -> FloatArray:
        """Return A x + B u."""
        del t
        A, B = self._matrices
        return A @ x + B[:, 0] * deflection + B[:, 1] * gust

    def angle_of_attack(self, t: Any, x: FloatArray, gust: Any) -> Any:
        """Return theta - gamma - alpha_w."""
        del t
        return x[0] - gust if len(x) < 3 else x[0] - x[2] - gust

    @cached_property
    def _matrices(self) -> tuple[FloatArray, FloatArray]:
        return self.plant.matrices()[:2]


def _sampled(
    plant: AnyPlant,
    law: Law,
    wind: History,
    times: FloatArray,
    limit: float,
    hardware: Hardware,
    gain: float,
) -> FloatArray:
    length = float(hardware.length)
    start, last = float(wind.onset), float(times.max())
    check_samples(max(last - start, 0.0), length)
    check_pace(plant, length)
    until = max(last, start) + length
    return tracked(one_flight(plant, law, wind, limit, hardware, gain, until), times).rows


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
