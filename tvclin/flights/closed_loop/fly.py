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
from tvclin.base.errors import InputError, limit_angle, nonnegative, number, positive, times_row
from tvclin.control.autopilot.actuator import Actuator, check_engine
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.batch import Hardware, one_flight
from tvclin.flights.closed_loop.checks import (
    check_actuator,
    check_delays,
    check_fastest_pole,
    check_flight,
    check_rate_limit,
    check_sample_rate,
    check_samples,
    check_span,
    fastest_poles,
)
from tvclin.flights.closed_loop.continuous import ContinuousFlight, Loop
from tvclin.flights.closed_loop.fly_many import LOST, NO_FLIGHT, fly_many
from tvclin.flights.closed_loop.sampled import outputs_of, tracked
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.lateral import NO_LATERAL_SENSORS, LateralSensors
from tvclin.linear.plant import Plant
from tvclin.linear.response import Responses, time_response
from tvclin.linear.system import LinearSystem
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

    It is in equilibrium until the onset of the wind.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        One plant of any model. A flexible one needs a sample rate, and the law measures the outputs
        of its sensors.
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
        Without it the deflection equals its command.
    sample_rate : float, optional
        Samples of the law per second [Hz], the first at the onset of the wind, with a zero-order
        hold of the command. Without it the law is continuous.
    delay : float
        Computing delay [s] from a sample to the effect of its command, a whole number of samples or
        not; it needs a sample rate.
    gain : float
        Factor on the law's demand, positive, before its switch and the limit, see `fly_many`.

    Returns
    -------
    control.TimeResponseData
        Outputs of the plant [rad, rad/s], of the lateral sensors of the law [m/s, m, m/s^2], and
        the deflection [rad]; input wind [rad].

    Raises
    ------
    InputError
        For batches, limits or a gain that are not positive, a wind that never ends, times long
        after the flight is lost, samples that are far too long for the actuator, noise, a delay
        or a rate limit without a sample rate, and a law that depends on the deflection without
        actuator and sample rate.

    Notes
    -----
    Without a sample rate, the solver restarts at the breakpoints of the wind, the switches of the
    law, and where deflection or rate reach or leave their limit, however briefly. The attitude is
    exact to about 1e-9 of its largest value, to 1e-8 with a `RecoverableAttitudeLaw`; a flight that
    is nearly lost multiplies both. With a sample rate, samples in which the nozzle reaches no limit
    are exact; `fly_many` describes the others and their accuracy. A late gust is never missed.

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
    flown = flight_responses(
        plant,
        law,
        wind,
        timepts,
        deflection_limit=deflection_limit,
        rate_limit=rate_limit,
        actuator=actuator,
        sample_rate=sample_rate,
        delay=delay,
        gain=gain,
    )
    return time_response(
        flown.time,
        flown.outputs,
        flown.labels,
        name=f"{plant.model} with limits",
        title=f"Flight with limits, {plant.model} model",
        wind=wind,
    )


def flight_responses(
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
) -> Responses:
    """Return outputs and deflection of a flight at n times as arrays, without python-control.

    Outputs are those of the plant, then the lateral motion (drift rate, drift, acceleration) that
    the law senses: the flight computes it for the law in any case.
    `timepts`: times [s], ``(n,)``. `deflection_limit`, `rate_limit`: limits of deflection [rad] and
    rate [rad/s]. `sample_rate`: samples of the law per second [Hz]; without it the law is
    continuous. `delay`: computing delay [s]. `gain`: factor on the demand of the law. Same
    exceptions and outputs as `fly`.
    """
    check_flight(plant, law, wind)
    times = times_row("timepts", timepts)
    limit = limit_angle(deflection_limit)
    max_rate, factor = check_rate_limit(rate_limit), number("gain", gain, positive)
    check_engine(plant, actuator)
    check_span(float(wind.onset), float(times.max()))
    if sample_rate is None:
        if delay:
            raise InputError("a delay belongs to samples; give a sample_rate")
        if not isinstance(plant, Plant) or not plant.is_rigid:
            raise InputError(
                "a flexible plant, or one from a state space, is flown by samples; give a"
                " sample_rate"
            )
        rows = _continuous(plant, law, wind, times, (limit, max_rate), actuator, factor)
    else:
        period = 1.0 / check_sample_rate(sample_rate, actuator)
        late = float(check_delays(number("delay", delay, nonnegative, "s"), np.asarray(period)))
        hardware = Hardware(period, late, actuator=actuator, rate_limit=max_rate)
        onset, last = float(wind.onset), float(times.max())
        check_samples(max(last - onset, 0.0), period)
        check_fastest_pole(plant, period)
        until = max(last, onset) + period
        flight = one_flight(plant, law, wind, limit, hardware, factor, until)
        rows = tracked(flight, times).rows
    system = law.lateral_sensors.system(plant)
    outputs = np.vstack([outputs_of(system, rows, wind(times)), rows[-1:]])
    return Responses(times, outputs, (*system.outputs, "deflection"))


def _continuous(
    plant: Plant,
    law: Law,
    wind: History,
    times: FloatArray,
    limits: tuple[float, float],
    actuator: Actuator | None,
    gain: float,
) -> FloatArray:
    """Return n states and deflection [rad] at m times of a flight without sampling, ``(n + 1, m)``.

    `plant`: rigid plant. `times`: [s], ``(m,)``. `limits`: limits of deflection [rad] and rate
    [rad/s]. `actuator`: nozzle dynamics, if any. `gain`: factor on the demand of the law.
    `InputError` for noise and filters of a law, and a rate limit without an actuator.
    """
    noise, _seed = law.rate_noise
    if noise:
        raise InputError("noise belongs to samples; give a sample_rate")
    if any(law.chains):
        raise InputError("filters are flown by samples; give a sample_rate")
    limit, rate_limit = limits
    if rate_limit < np.inf and actuator is None:
        raise InputError("a rate_limit needs an actuator or a sample_rate")
    check_actuator(actuator)
    # the equations do not depend on time, and near zero its rounding is smallest
    equations = LinearEquations(plant, law.lateral_sensors)
    loop = Loop(equations, law, limit=limit, rate_limit=rate_limit, actuator=actuator, gain=gain)
    start = float(wind.onset)
    flight, times = ContinuousFlight(loop, wind.shift(-start)), times - start
    return flight.rows(flight.arcs(0.0, float(times.max())), times)


@dataclass(frozen=True, eq=False)
class LinearEquations:
    """`Equations` of a linear plant with lateral sensors."""

    plant: Plant
    sensors: LateralSensors = NO_LATERAL_SENSORS

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return self._system.states

    @property
    def scales(self) -> FloatArray:
        """Magnitude of each state that corresponds to an angle of one, ``(n,)``.

        One for states of the vehicle; for that of a sensor the largest entry [1/s] of its row of A.
        """
        scales = np.ones(len(self.states))
        sensors = slice(len(self.plant.states), None)
        scales[sensors] = np.abs(self._system.A[sensors]).max(axis=-1, initial=1.0)
        return scales

    def rates(self, t: float, x: FloatArray, deflection: float, gust: float) -> FloatArray:
        """Return the derivatives A x + B u of the states x, ``(n,)``, see `Equations.rates`.

        The time is not used, here and below: the matrices are constant.
        """
        A, B, _, _ = self._system.matrices()
        by_deflection, by_wind = B.T[:2]  # the first two inputs
        return A @ x + by_deflection * deflection + by_wind * gust

    def angle_of_attack(self, t: Any, x: FloatArray, gust: Any) -> Any:
        """Return theta - gamma - alpha_w [rad], see `Equations.angle_of_attack`.

        States are attitude theta, its rate, and path angle gamma, which is zero in a model with a
        fixed path, of two states.
        """
        return x[0] - gust if len(self.plant.states) < 3 else x[0] - x[2] - gust

    def lateral(self, t: Any, x: FloatArray) -> dict[str, Any]:
        """Return the measurements of the lateral sensors by name, see `Equations.lateral`."""
        # outputs of the lateral sensors follow the plant's
        rows = self._system.C[len(self.plant.outputs) :] @ x
        return self.sensors.measurements(rows)

    @cached_property
    def _system(self) -> LinearSystem:
        """State space of the plant with its lateral sensors."""
        return self.sensors.system(self.plant)


_TIME_AFTER_WIND_TIMES_POLE = 15.0
"""Length of a flight after its wind, times the fast pole: later motion is rounding."""
_TIMES_PER_RADIAN = 15.0
"""Smallest number of times in 1/omega of the fastest pole of actuator and vehicle. The peak of an
oscillation is then missed by at most 1 - cos(1/30), 0.06 percent; a product of two such
oscillations, such as power, is integrated by midpoints to (2 * 2/15)^2/24, 0.3 percent."""
_MIN_TIMES = 4
"""Smallest number of times in a sample."""
_MAX_TIMES = 1_000_000
"""Largest number of times during a wind, and after it."""


@dataclass(frozen=True, eq=False)
class NozzleFlight:
    """Outcome of a flight, and the motion of its nozzle; angles in rad.

    `times`: equidistant times [s] from the first command on, ``(n,)``, an even number
    `times_per_sample` of them in a sample, at the first of which the command changes; empty for a
    flight that is lost or not possible. `rate`, `acceleration`: nozzle rate [rad/s] and
    acceleration [rad/s^2] right after the times; None without an actuator.
    """

    status: str
    times: FloatArray
    deflection: FloatArray
    angle_of_attack: FloatArray
    attitude: FloatArray
    rate: FloatArray | None
    acceleration: FloatArray | None
    times_per_sample: int = _MIN_TIMES


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
    """Return the motion of a nozzle in the sampled flight of a law in one wind.

    `deflection_limit`, `rate_limit`: limits of deflection [rad] and rate [rad/s]. `sample_rate`:
    samples of the law per second [Hz]. `delay`: computing delay [s]. The flight goes on for 15 over
    the fast pole after its wind, or as long as the number of times allows. `InputError` as
    `fly_many`, and for a wind of too many samples or times.
    """
    onset, end, h = float(wind.onset), float(wind.end), 1.0 / sample_rate
    per_sample = times_per_sample(plant, actuator, h)
    longest = _max_duration(onset, end, h, per_sample)
    options: dict[str, Any] = {"deflection_limit": deflection_limit, "rate_limit": rate_limit}
    options |= {"actuator": actuator, "sample_rate": sample_rate, "delay": delay}
    status = str(fly_many(plant, law, wind, **options).status)
    none = np.empty(0)
    if status in (LOST, NO_FLIGHT):
        return NozzleFlight(status, none, none, none, none, rate=None, acceleration=None)
    first = onset + delay % h  # commands arrive in this phase of a sample
    # time after the wind [s]; `longest` keeps the number of times within bounds
    after = min(_TIME_AFTER_WIND_TIMES_POLE / float(plant.coefficients.pole), longest)
    count = int(np.ceil((end - first + after) / h))
    times = np.asarray(first + h / per_sample * np.arange(count * per_sample + 1), dtype=np.float64)
    hardware = Hardware(h, delay, actuator=actuator, rate_limit=rate_limit)
    flight = one_flight(plant, law, wind, deflection_limit, hardware, until=times[-1] + h)
    rows, rate, acceleration = tracked(flight, times)  # rows: states, and last the deflection
    outputs = outputs_of(flight.system, rows, wind(times))
    alpha, attitude = (
        outputs[plant.outputs.index(name)] for name in ("angle_of_attack", "attitude")
    )
    return NozzleFlight(
        status=status,
        times=times,
        deflection=rows[-1],
        angle_of_attack=alpha,
        attitude=attitude,
        rate=rate,
        acceleration=acceleration,
        times_per_sample=per_sample,
    )


def times_per_sample(plant: AnyPlant, actuator: Actuator | None, period: float) -> int:
    """Return the even number of times in a sample `period` [s] that resolve the fastest pole."""
    poles = np.zeros(1) if actuator is None else np.roots(actuator.denominator)
    fastest = max(float(np.abs(poles).max()), float(fastest_poles(plant)))
    return max(2 * int(np.ceil(_TIMES_PER_RADIAN * fastest * period / 2.0)), _MIN_TIMES)


def _max_duration(start: float, stop: float, period: float, per_sample: int) -> float:
    """Return the longest motion [s] of a nozzle; `InputError` for a longer wind.

    `start`, `stop`: onset and end of the wind [s]. `period`: sample period [s]. `per_sample`:
    number of times in a sample at which the motion is computed, at most `_MAX_TIMES` in all.
    """
    check_span(start, stop)
    check_samples(stop - start, period)
    longest = _MAX_TIMES / per_sample * period
    if stop - start > longest:
        lower = ", or a lower sample rate" if per_sample == _MIN_TIMES else ""
        raise InputError(
            f"the wind of a nozzle's motion may last at most {longest:.4g} s, with {per_sample}"
            f" times in a sample at {1.0 / period:.4g} Hz; got {stop - start:.6g} s: take a wind"
            f" that ends earlier{lower}"
        )
    return longest
