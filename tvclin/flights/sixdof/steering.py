"""Steering of a JSBSim flight: the deflection of a history, the report's control, or a law.

JSBSim integrates forces at its samples to second order, so that each sample represents the step
around it: a deflection that jumps or bends within that step is given as its mean over the step.

A law measures the drift, integrated by the trapezoidal rule, and the lateral acceleration, whose
lag is exact for a force that is a straight line over each step, extrapolated over the next one.
"""

from __future__ import annotations

from collections.abc import Callable
from math import copysign, exp, sin

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.control.autopilot.actuator import actuator_system
from tvclin.control.laws.law import Law, Measurement
from tvclin.control.laws.trim import TrimLaw
from tvclin.flights.engine_interface import ONSET_OVER_LIMIT, Command
from tvclin.kernels.control_laws import next_mode
from tvclin.linear.lateral import LateralSensors
from tvclin.winds.histories import History

Steering = Callable[[int, Measurement], float]
"""Function from the number of a step and the predicted measurements to the deflection [rad]."""

_NOTHING = np.zeros(0)
_SWITCH_PARTS = 128
"""Number of parts of the step in which the control switches."""


def step_means(history: History, times: FloatArray, step: float) -> FloatArray:
    """Return the means of a history over a step [s] around each equidistant time [s], ``(n,)``.

    They are the differences of its integral, the filter 1/s, over the step.
    """
    edges = np.append(times, times[-1] + step) - 0.5 * step
    return np.diff(history.filter([1.0], [1.0, 0.0])(edges)) / step


def by_history(history: History, times: FloatArray, step: float, limit: float) -> Steering:
    """Return the steering of a deflection history within the limit [rad].

    Measurements are not used. `times`: equidistant times of the steps [s], ``(n,)``. `step`: step
    [s].
    """
    means = np.clip(step_means(history, times, step), -limit, limit).tolist()
    return lambda k, measured: means[k]


class TrimThenHold:
    """Steering of the report's control: trim until K times the limit, then the limit for ever.

    With K = 0 the wind alone sets the switch.
    """

    def __init__(
        self,
        trim: TrimLaw,
        limit: float,
        dead_band: float,
        wind: History,
        times: FloatArray,
        step: float,
    ) -> None:
        """Evaluate the wind angle at all steps, before the flight: means, and values at the ends.

        `trim`: law of trim and attitude feedback. `limit`: deflection limit [rad], positive.
        `dead_band`: K. `times`: equidistant times [s], ``(n,)``, in the middle of the steps.
        `step`: step [s]. `_level`: trim [rad] at which the control switches, K times the limit.
        `_constant`: deflection [rad] after the switch, None before it.
        """
        self._trim, self._B = trim, float(trim.plant.coefficients.B)
        self._limit, self._level = limit, max(dead_band, ONSET_OVER_LIMIT) * limit
        self._by_wind_alone = dead_band == 0.0
        self._wind, self._times, self._step = wind, times, step
        self._means = step_means(wind, times, step).tolist()
        self._ends = wind(times + 0.5 * step).tolist()
        self._constant: float | None = None

    def __call__(self, k: int, measured: Measurement) -> float:
        """Return the deflection [rad] at the step with number `k`, for predicted measurements.

        The trim deflection is B times the angle of attack, which is an angle without the wind minus
        the wind, at the end of the step (`_ends`). From where it reaches K times the limit on
        (`_level`), the limit is constant (`_constant`), with the sign of trim. The measured angle
        of attack has the mean wind of the step in it (`_means`). With K = 0 the wind alone counts.
        In the step of the switch it is the mean of trim and limit (`_switching_mean`).
        """
        if self._constant is not None:
            return self._constant
        demand = float(self._trim.demand(measured, _NOTHING, self._limit))
        without_wind = 0.0 if self._by_wind_alone else demand / self._B + self._means[k]
        if abs(self._B * (without_wind - self._ends[k])) < self._level:
            return demand
        return self._switching_mean(k, without_wind)

    def _switching_mean(self, k: int, without_wind: float) -> float:
        """Return the mean deflection [rad] of the step in which the control switches to the limit.

        Trim is followed in 128 parts of the step up to the switch, where it reaches K times the
        limit (`_level`), and the limit after it, which is kept for all later steps. `k`: number of
        the step. `without_wind`: angle of attack [rad] without the wind; B, the ratio of trim
        deflection to angle of attack, makes the demand of it.
        """
        fraction = np.linspace(-0.5, 0.5, _SWITCH_PARTS + 1)  # of the step, from its middle
        trim = self._B * (without_wind - self._wind(self._times[k] + fraction * self._step))
        i = int(np.argmax(np.abs(trim) >= self._level))
        sign = copysign(1.0, trim[i])
        self._constant = sign * self._limit
        switch = fraction[0]
        if i > 0:
            switch = np.interp(self._level, sign * trim[i - 1 : i + 1], fraction[i - 1 : i + 1])
        before = np.append(trim[:i], sign * self._level), np.append(fraction[:i], switch)
        return float(np.trapezoid(*before) + self._constant * (0.5 - switch))


def by_law(command: Command, limit: float, step: float, count: int) -> Steering:
    """Return the steering of a law, evaluated at every step, with actuator and limits.

    The actuator follows its command of the step before by its exact step matrices; deflection and
    rate are limited after it. `command`: law, actuator and rate limit [rad/s]. `limit`: deflection
    limit [rad]. `step`, `count`: length [s] and number of the steps.
    """
    assert isinstance(command.control, Law)
    law_command, max_rate = _command(command.control, limit, step, count), command.rate_limit
    free, driven = np.zeros((1, 1)), np.ones(1)
    if command.actuator is not None:
        steps = actuator_system(command.actuator).to_steps(step)
        free, driven = steps.A, steps.B[:, 0]
    elif max_rate == np.inf:
        return law_command
    # states of the actuator: deflection, perhaps rate [rad, rad/s]; command [rad]
    servo, last_command = np.zeros(driven.size), 0.0

    def followed(k: int, measured: Measurement) -> float:
        """Return the deflection [rad] of the actuator at step `k`, and update its state.

        The command of the next step is that of the law, from the `measured` values.
        """
        nonlocal servo, last_command
        servo_next = free @ servo + driven * last_command
        if max_rate < np.inf:
            travel = max_rate * step  # largest in a step [rad]
            servo_next[0] = servo[0] + np.clip(servo_next[0] - servo[0], -travel, travel)
            servo_next[1:] = np.clip(servo_next[1:], -max_rate, max_rate)
        servo, deflection = servo_next, min(max(float(servo_next[0]), -limit), limit)
        last_command = law_command(k, measured._replace(deflection=deflection))
        return deflection

    return followed


def _command(law: Law, limit: float, step: float, count: int) -> Steering:
    """Return the steering that gives the law's command within the limit, with the law's states.

    Noise of the measured rate is drawn before the flight. The full limit is commanded, with the
    sign `mode` of the demand, from a demand of `engage` times the limit on, until it falls to
    `release` times it. `memory`: states of the law. `limit`: deflection limit [rad]. `step`,
    `count`: length [s] and number of the steps.
    """
    demand_of, engage, release = law.demand, law.engage * limit, law.release * limit
    F, _ = law.states  # of s' = F s + G m, s being the states
    memory = np.zeros(len(F))
    steps = law.state_space.to_steps(step)
    level, seed = law.rate_noise  # standard deviation [rad/s]
    noise = np.random.default_rng([seed, 0]).normal(0.0, level, count).tolist() if level else None
    mode = 0.0  # 1 or -1 while the full limit is commanded

    def command(k: int, measured: Measurement) -> float:
        """Return the commanded deflection [rad] at step `k`, and update `memory` and `mode`."""
        nonlocal memory, mode
        if noise is not None:
            measured = measured._replace(attitude_rate=measured.attitude_rate + noise[k])
        demand = float(demand_of(measured, memory, limit))
        mode = next_mode(engage, release, demand, mode)
        if memory.size:
            memory = steps.A @ memory + steps.B @ measured
        return mode * limit if mode else min(max(demand, -limit), limit)

    return command


class LateralMotion:
    """Lateral motion in one plane, from the steps of a flight.

    `_force` is the force per mass [m/s^2] on the accelerometer at its station, without its lag.
    """

    def __init__(self, sensors: LateralSensors, step: float) -> None:
        """Set the motion to zero, at the start of a flight.

        The lag of the accelerometer decays by e^(-bandwidth step) in a step, and follows a force
        that rises by 1 over the step by `_ramp`. `sensors`: lateral sensors of the law. `step`:
        step [s].
        """
        lag = sensors.bandwidth * step
        self._sensors, self._step, self._decay = sensors, step, exp(-lag)
        self._ramp = 1.0 - (1.0 - self._decay) / lag
        self._drift = self._drift_rate = self._speed = 0.0  # [m], [m/s], [m/s]
        # [m/s^2]: behind the lag; force per mass now and a step before
        self._acceleration = self._force = self._last_force = 0.0

    def measured(self, plain: Measurement) -> Measurement:
        """Return the measurements at the end of the next step, of lateral motion too.

        Measurements without a sensor are zero; the force per mass on the accelerometer [m/s^2] is
        extrapolated from the last two steps. `plain`: the predicted measurements without them.
        """
        sensors, rate = self._sensors, self._speed * sin(plain.flight_path_angle)
        extrapolated = 2.0 * self._force - self._last_force
        return plain._replace(
            drift_rate=rate if sensors.drift_rate else 0.0,
            drift=self._drifted(rate) if sensors.drift else 0.0,
            acceleration=self._lagged(extrapolated) if sensors.acceleration else 0.0,
        )

    def move(self, path: float, speed: float, force: float, angular_acceleration: float) -> None:
        """Update drift and acceleration of the lateral sensors to the end of a step.

        `path`: flight path angle [rad]. `speed`: over the ground [m/s]. `force`: force per mass at
        the centre of gravity [m/s^2], normal to the body, without weight. `angular_acceleration`:
        of the attitude [rad/s^2]. All but the speed are relative to the nominal flight. The drift
        is the integral of its rate, the acceleration is at the accelerometer, with its lag.
        """
        rate = speed * sin(path)
        self._drift, self._drift_rate, self._speed = self._drifted(rate), rate, speed
        local = force + self._sensors.station * angular_acceleration
        self._acceleration = self._lagged(local)
        self._last_force, self._force = self._force, local

    def _drifted(self, rate: float) -> float:
        """Return the drift [m] at the end of a step with a drift rate [m/s] there, by trapezoid."""
        return self._drift + 0.5 * self._step * (self._drift_rate + rate)

    def _lagged(self, force: float) -> float:
        """Return the acceleration [m/s^2] of the accelerometer at the end of a step, with its lag.

        It is exact for a force that is a straight line over the step, from `_force` at its begin.
        `_acceleration` is the lagged value at the begin; a lag keeps the fraction `_decay` of a
        difference over a step, and follows a line that rises by 1 up to `_ramp`. `force`: force per
        mass at the end, at the accelerometer [m/s^2].
        """
        decayed = self._force + self._decay * (self._acceleration - self._force)
        return decayed + self._ramp * (force - self._force)
