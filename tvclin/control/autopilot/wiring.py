"""The loop of an autopilot around a plant: state space, polynomials, and difference equations.

All three forms wire the blocks that the docstring of `Autopilot` shows; tests compare them. The
sampled loop is exact: at t_k = k h the law reads the outputs y_k, and its command reaches the
actuator one delay later and is held (zero-order hold); vehicle, actuator and sensor lags become
`LinearSystem.to_steps`. Filters become difference equations by the bilinear rule, each exact at its
own frequency; the integral is that of the held samples. With z = (1 + w h/2)/(1 - w h/2) the
sampled L(z) is a rational function of w, with the same values at w = j nu, nu = (2/h) tan(omega
h/2), so that its margins are computed like those of a continuous loop (Franklin, Powell and
Workman, Digital Control of Dynamic Systems).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tvclin.base.arrays import ComplexArray, FloatArray, IndexArray
from tvclin.base.errors import InputError
from tvclin.control.autopilot.actuator import plant_blocks, plant_with_actuator
from tvclin.control.autopilot.feedback import CHAINS, Feedback
from tvclin.control.margins.loop import Loop, SampledLoop, w_plane_loop
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.lateral import ACCELERATION, DRIFT, DRIFT_RATE, SENSOR_OF
from tvclin.linear.named_systems import require_signals
from tvclin.linear.plant import Plant
from tvclin.linear.system import LinearSystem, connect, gain
from tvclin.numerics import polynomials, state_space
from tvclin.numerics.loops import StateLoop
from tvclin.numerics.state_space import Matrices, pade_delay
from tvclin.vehicle.filters import Filter

COMMAND, RETURNED = "deflection_command", "returned_command"
DISTURBANCES = ("wind", "attitude_command", "deflection_disturbance")
SENSOR_NOISE = "attitude_noise", "rate_noise"
"""Names of the inputs that add to the outputs of the sensors, ahead of their filters."""
_DELAYED = "delayed_command"
ATTITUDE_ERROR, FILTERED_RATE = "attitude_error", "filtered_rate"
LAW_INPUTS = (
    ATTITUDE_ERROR,
    FILTERED_RATE,
    "flight_path_angle",
    "angle_of_attack",
    "deflection",
    DRIFT_RATE,
    DRIFT,
    ACCELERATION,
)
"""Inputs of a law, behind the filters of its sensors."""
CONTROLLER = "controller_output"
"""Output of a controller in state space."""
_ATTITUDE_COMMAND = "attitude_command"
LAW_OUTPUT, INTEGRAL = "law_output", "attitude_error_integral"
"""Names of the command before its filters, and of the integrator's state."""


def open_loop(
    autopilot: Feedback, plant: AnyPlant, *, pade: bool = False, sensor_noise: bool = False
) -> LinearSystem:
    """Return the state space of the loop, broken at the command, for one autopilot or a batch.

    Inputs: wind, attitude command and deflection disturbance (`DISTURBANCES`), the command, and
    with `sensor_noise` the noises of attitude and rate sensor (`SENSOR_NOISE`). Outputs: the
    plant's, the deflection and the returned command. States, in this order: plant, actuator, with
    `pade` the Pade approximation of the delay (else it is left out), integrator, filters. `plant`:
    one plant or a batch, which broadcasts with the autopilot.
    """
    # plant with sensors, actuator, and the sum of deflection and disturbance
    vehicle = plant_blocks(plant, autopilot.actuator, autopilot.lateral_sensors)
    A, B, C, D = pade_delay(float(autopilot.delay) if pade else 0.0, autopilot.pade_order)
    states = tuple(f"delay_{k}" for k in range(1, len(A) + 1))
    delay = LinearSystem(A, B, C, D, inputs=(COMMAND,), outputs=(_DELAYED,), states=states)
    blocks = [
        *(block.renamed({COMMAND: _DELAYED}) for block in vehicle),
        delay,
        *autopilot_blocks(autopilot, plant),
    ]
    sensors = plant.sensed if sensor_noise else ()
    inputs = (*DISTURBANCES, COMMAND, *sensors)
    loop = connect(blocks, inputs, (*vehicle[0].outputs, "deflection", RETURNED))
    # an external input named as a sensor's output adds to it: its noise
    return loop.renamed(dict(zip(sensors, SENSOR_NOISE, strict=False)))


def closed_loop(
    autopilot: Feedback, plant: AnyPlant, *, sensor_noise: bool = False, command: bool = False
) -> LinearSystem:
    """Return the closed loop of an autopilot and a plant, from disturbances to all outputs.

    `autopilot`, `plant`: one each or batches, which broadcast. Inputs: wind, attitude command and
    deflection disturbance (`DISTURBANCES`); outputs: the plant's, the lateral sensors', and the
    deflection. The delay is its Pade approximation. With `sensor_noise` the noises of attitude and
    rate sensor [rad, rad/s] are further inputs, which outputs of these sensors contain. With
    `command` the last input is a deflection command that adds to the returned one, and the last
    output the returned command.
    """
    loop = open_loop(autopilot, plant, pade=True, sensor_noise=sensor_noise)
    # a tuple times a flag is the tuple or empty
    inputs = (*DISTURBANCES, *SENSOR_NOISE * sensor_noise, *(COMMAND,) * command)
    outputs = (*plant.outputs, *autopilot.lateral_sensors.signals, "deflection")
    return loop.feedback(RETURNED, COMMAND).select(inputs, outputs + (RETURNED,) * command)


def exact_loop(autopilot: Feedback, plant: AnyPlant) -> Loop:
    """Return the loop with its exact delay, for one autopilot and plant or a batch.

    Polynomials around a rigid plant, else matrices.
    """
    if isinstance(plant, Plant) and plant.is_rigid and autopilot.controller is None:
        return rational_loop(autopilot, plant)
    # The loop's output is the returned command, and L is minus that.
    loop = open_loop(autopilot, plant).select((COMMAND,), (RETURNED,))
    return Loop.from_matrices(loop.A, loop.B, 0.0 - loop.C, 0.0 - loop.D, autopilot.delay)


def autopilot_blocks(
    autopilot: Feedback, plant: AnyPlant, period: FloatArray | None = None
) -> list[LinearSystem]:
    """Return the blocks of an autopilot, from the sensors and the attitude command to the command.

    They are to be connected by signal name: filters of the sensors, the law (gains a0, a1, b0, an
    integral of the attitude error, gains on drift and acceleration, or a controller in state
    space), and filters of the command. `plant`: its names of sensed attitude and rate are inputs.
    `period` [s]: with it the blocks are difference equations.
    """
    chains = {name: getattr(autopilot, name) for name in CHAINS}
    command_sum = [gain(ATTITUDE_ERROR, {_ATTITUDE_COMMAND: -1.0})]  # attitude minus its command
    if autopilot.controller is not None:
        check_controller(autopilot.controller, plant)
        if _ATTITUDE_COMMAND in autopilot.controller.inputs:
            command_sum = []  # the controller itself takes the command off
        states = controller_system(autopilot.controller)
        gains: dict[str, Any] = {CONTROLLER: 1.0}
    else:
        integral = bool(np.any(np.asarray(autopilot.integral_gain)))
        states = attitude_integral(integral)
        gains = {
            ATTITUDE_ERROR: autopilot.attitude_gain,
            FILTERED_RATE: autopilot.rate_gain,
            "angle_of_attack": autopilot.alpha_gain,
        }
        if integral:
            gains[INTEGRAL] = autopilot.integral_gain
        gains |= autopilot.lateral_gains
    blocks = law_blocks(chains, states, plant.sensed, period)
    return [*blocks, *command_sum, gain(LAW_OUTPUT, gains)]


def check_controller(controller: LinearSystem, plant: AnyPlant) -> None:
    """Raise `InputError` for an input of a controller that neither plant nor sensors give."""
    available = dict.fromkeys((*plant.outputs, *SENSOR_OF, "deflection", _ATTITUDE_COMMAND))
    require_signals("the plant", "output", controller.inputs, tuple(available))


def controller_system(controller: LinearSystem) -> LinearSystem:
    """Return a controller in state space with the names of signals that the loop connects.

    Its inputs attitude and attitude_rate become the attitude error and the rate behind their
    filters, inputs of lateral motion the outputs of the sensors; its output is `CONTROLLER`.
    """
    names = {"attitude": ATTITUDE_ERROR, "attitude_rate": FILTERED_RATE} | SENSOR_OF
    states = tuple(f"controller_{k}" for k in range(1, len(controller.states) + 1))
    return replace(controller.renamed(names), outputs=(CONTROLLER,), states=states)


def measured_outputs(autopilot: Feedback, plant: AnyPlant) -> tuple[str, ...]:
    """Return the names of the outputs of plant, sensors and actuator that an autopilot reads.

    The attitude command, which is none of these, is left out. `InputError` for an input of its
    controller that neither `plant` nor sensors give.
    """
    if autopilot.controller is None:
        return (*plant.sensed, "angle_of_attack", *autopilot.lateral_sensors.signals)
    check_controller(autopilot.controller, plant)
    names = dict(zip(("attitude", "attitude_rate"), plant.sensed, strict=True)) | SENSOR_OF
    read = (names.get(name, name) for name in autopilot.controller.inputs)
    return tuple(dict.fromkeys(name for name in read if name != _ATTITUDE_COMMAND))


def in_steps(system: LinearSystem, period: FloatArray) -> LinearSystem:
    """Return difference equations of a period [s], with a zero-order hold of continuous inputs.

    `system`: continuous, or difference equations of that period; `InputError` for another one.
    """
    if system.period is None:
        return system.to_steps(period)
    if np.any(np.abs(period - system.period) > _RELATIVE_PERIOD * period):
        raise InputError(
            f"the controller has a sample time of {float(system.period):.6g} s; give sample_rate ="
            f" {1.0 / float(system.period):.6g} Hz to what it is flown with, not"
            f" {1.0 / float(np.max(period)):.6g} Hz"
        )
    return replace(system, period=period)


def attitude_integral(present: bool) -> LinearSystem:
    """Return the integrator of a law's attitude error; without states if not `present`.

    Its inputs are all of `LAW_INPUTS`, of which it integrates the first, the attitude error.
    """
    n, names = int(present), (INTEGRAL,) if present else ()
    A, B, C, D = (
        np.zeros((n, n)),
        np.eye(n, len(LAW_INPUTS)),
        np.eye(n),
        np.zeros((n, len(LAW_INPUTS))),
    )
    return LinearSystem(A, B, C, D, inputs=LAW_INPUTS, outputs=names, states=names)


def law_blocks(
    chains: Mapping[str, Sequence[Filter]],
    states: LinearSystem,
    sensed: tuple[str, str],
    period: FloatArray | None = None,
) -> list[LinearSystem]:
    """Return the blocks of a law: filters of its sensors, its states, filters of its command.

    `chains`: filters of attitude, rate and command, by the names `CHAINS`. `states`: state space of
    the law, driven by `LAW_INPUTS`, the filtered signals and the other measurements. `sensed`:
    names of attitude and attitude rate before the filters. `period` [s]: with it all blocks are
    difference equations: filters by the bilinear rule, each exact at its own frequency, the law's
    states with a zero-order hold on their inputs.
    """
    # Signals ahead of and behind the filters of attitude, rate and command.
    attitude, rate = sensed
    ends = ((attitude, ATTITUDE_ERROR), (rate, FILTERED_RATE), (LAW_OUTPUT, RETURNED))
    blocks = [states if period is None else in_steps(states, period)] if states.outputs else []
    for name, (source, target) in zip(CHAINS, ends, strict=True):
        chain = chains[name]
        if not chain and source != target:
            blocks.append(gain(target, {source: 1.0}))
        # of n filters in series: source, n - 1 signals between them, target
        signals = [source, *(f"{name} {k}" for k in range(1, len(chain))), target]
        for k, filter_ in enumerate(chain, start=1):
            names = (f"{name.removesuffix('s')}_{k}_{j}" for j in range(1, filter_.order + 1))
            if period is None:
                matrices = filter_.matrices()
            else:
                matrices = filter_in_steps(filter_, period, f"{name} {k}")
            ahead, behind = (signals[k - 1],), (signals[k],)
            blocks.append(LinearSystem(*matrices, ahead, behind, tuple(names), period))
    return blocks


def filter_in_steps(filter_: Filter, period: FloatArray, name: str) -> Matrices:
    """Return A, B, C, D of a filter's difference equation, by the prewarped bilinear rule.

    s = c (z - 1)/(z + 1) with c = w/tan(w h/2) is exact at the filter's own frequency w, the
    geometric mean of its poles; c = 2/h where w = 0. `period`: h [s]. `name`: name of the filter in
    messages. `InputError` for a w that is not below half the sample rate.
    """
    if not filter_.order:
        return filter_.matrices()
    half = 0.5 * period
    frequency = np.abs(filter_.denominator[..., -1]) ** (1.0 / filter_.order)
    half_phase = frequency * half
    if np.any(half_phase >= 0.5 * np.pi):
        raise InputError(
            f"{name} has its own frequency at {np.max(frequency):.6g} rad/s, which must lie below"
            f" half the sample rate, {np.pi / np.max(period):.6g} rad/s; raise sample_rate"
        )
    frequency, half_phase = np.broadcast_arrays(frequency, half_phase)
    rises = frequency > 0.0
    c = np.where(rises, frequency / np.tan(np.where(rises, half_phase, 1.0)), 1.0 / half)
    return state_space.to_steps(filter_.matrices(), c)


def rational_loop(autopilot: Feedback, plant: Plant) -> Loop:
    """Return the loop L(s) as polynomials with an exact delay.

    `autopilot`: gains and filters, one or a batch. `plant`: rigid, one or a batch.
    """
    numerator, integrators = _feedback(autopilot, plant, "deflection")  # number of poles at zero
    actuator_numerator, actuator_denominator = _actuator(autopilot)
    denominator = polynomials.times_variable(plant.denominator, integrators)
    for name in CHAINS:
        if getattr(autopilot, name):
            _, filter_denominator = _chain(autopilot, name)
            denominator = polynomials.multiply(denominator, filter_denominator)
    if autopilot.lateral_sensors.acceleration:  # times s + bandwidth
        lag = np.array([1.0, autopilot.accelerometer_bandwidth])
        denominator = polynomials.multiply(denominator, lag)
    # L is minus what returns, so that 1 + L = 0 is the closed loop.
    return Loop(
        numerator=polynomials.multiply(-numerator, actuator_numerator),
        denominator=polynomials.multiply(denominator, actuator_denominator),
        delay=autopilot.delay,
    )


def wind_numerator(autopilot: Feedback, plant: Plant) -> FloatArray:
    """Return the numerator ``(..., n)`` from wind to deflection of the open loop.

    `autopilot`, `plant`: gains and a rigid plant. Denominator and delay are the same as in
    `rational_loop`, the loop from the command.
    """
    numerator, _ = _feedback(autopilot, plant, "wind")
    actuator_numerator, _ = _actuator(autopilot)
    return polynomials.multiply(numerator, actuator_numerator)


def _feedback(autopilot: Feedback, plant: Plant, source: str) -> tuple[FloatArray, int]:
    """Return the numerator ``(..., n)`` from a plant input to the command, and the integrators.

    Coefficients have the highest power of s first. `source`: the input, "deflection" or "wind". The
    number of integrators is zero or one. The denominator is the plant's, times s with an integrator
    of attitude or drift, times those of all filters of the autopilot and of its accelerometer. Of
    the gains a0 is on attitude, a1 on its rate, b0 on the angle of attack and aI on the integral.
    """
    sensors = autopilot.lateral_sensors
    integrators = int(sensors.drift or np.any(np.asarray(autopilot.integral_gain)))
    # (a1 s + a0 + aI/s) theta + b0 alpha, over s with an integrator
    gains = [autopilot.rate_gain, autopilot.attitude_gain, autopilot.integral_gain]
    alpha_gain = np.asarray(autopilot.alpha_gain)[..., np.newaxis]
    on_angle = polynomials.times_variable(alpha_gain, integrators)  # b0, or b0 s
    angle = polynomials.multiply(on_angle, plant.numerator("angle_of_attack", source))
    on_attitude = np.stack(np.broadcast_arrays(*gains[: 2 + integrators]), axis=-1)
    # filters F = N/D of the sensed attitude and of the sensed rate
    N_attitude, D_attitude = _chain(autopilot, "attitude_filters")
    N_rate, D_rate = _chain(autopilot, "rate_filters")
    sensor_denominator = polynomials.multiply(D_attitude, D_rate)
    if autopilot.attitude_filters or autopilot.rate_filters:
        # (a1 s F_rate + (a0 + aI/s) F_attitude) theta + b0 alpha, over both denominators; the
        # first coefficient is a1, with s, or s^2 with an integrator
        rate = polynomials.times_variable(on_attitude[..., :1], 1 + integrators)
        rate = polynomials.multiply(polynomials.multiply(rate, N_rate), D_attitude)
        attitude = polynomials.multiply(on_attitude[..., 1:], N_attitude)
        on_attitude = polynomials.add(rate, polynomials.multiply(attitude, D_rate))
        angle = polynomials.multiply(angle, sensor_denominator)
    attitude = polynomials.multiply(on_attitude, plant.numerator("attitude", source))
    numerator = polynomials.add(attitude, angle)
    if sensors.signals:
        numerator = _with_lateral(
            autopilot, plant, source, integrators, numerator, sensor_denominator
        )
    if autopilot.filters:
        command_numerator, _ = _chain(autopilot, "filters")
        numerator = polynomials.multiply(numerator, command_numerator)
    return numerator, integrators


def _with_lateral(
    autopilot: Feedback,
    plant: Plant,
    source: str,
    integrators: int,
    numerator: FloatArray,
    sensor_denominator: FloatArray,
) -> FloatArray:
    """Return the numerator from a plant input to the command, with drift and acceleration.

    Gains: d1 on the drift rate z', d0 on the drift z, g on the acceleration n. `plant`: rigid.
    `source`: its input, "deflection" or "wind". `numerator`: of the feedback of attitude and angle
    of attack, ``(..., n)``, over the denominator of the plant, times s to the power `integrators`,
    times `sensor_denominator`, of the filters of attitude and rate.
    """
    sensors, station = autopilot.lateral_sensors, autopilot.acceleration_station
    if sensors.drift_rate or sensors.drift:
        # (d1 + d0/s) z', over s with an integrator
        gains = [autopilot.drift_rate_gain, autopilot.drift_gain][: 1 + sensors.drift]
        on_path = np.stack(np.broadcast_arrays(*gains), axis=-1)
        on_path = polynomials.times_variable(on_path, integrators - sensors.drift)
        path = polynomials.multiply(on_path, plant.lateral_numerator("drift_rate", source, station))
        numerator = polynomials.add(numerator, polynomials.multiply(path, sensor_denominator))
    if sensors.acceleration:
        # g n bandwidth/(s + bandwidth), over a common denominator with the other feedback
        acceleration = plant.lateral_numerator("acceleration", source, station)
        gain = np.asarray(autopilot.acceleration_gain)[..., np.newaxis] * sensors.bandwidth
        sensed = polynomials.multiply(gain * acceleration, sensor_denominator)
        sensed = polynomials.times_variable(sensed, integrators)
        numerator = polynomials.multiply(numerator, np.array([1.0, sensors.bandwidth]))
        numerator = polynomials.add(numerator, sensed)
    return numerator


def _chain(autopilot: Feedback, name: str) -> tuple[FloatArray, FloatArray]:
    """Return numerator and denominator of a series of filters; ones without filters.

    `name`: "attitude_filters", "rate_filters", or "filters" of the command. Coefficients have the
    highest power of s first.
    """
    numerator, denominator = np.ones(1), np.ones(1)
    for filter_ in getattr(autopilot, name):
        numerator = polynomials.multiply(numerator, filter_.numerator)
        denominator = polynomials.multiply(denominator, filter_.denominator)
    return numerator, denominator


def _actuator(autopilot: Feedback) -> tuple[FloatArray, FloatArray]:
    """Return numerator and denominator of an autopilot's actuator; ones without an actuator.

    Coefficients have the highest power of s first. The actuator has unit steady gain.
    """
    if autopilot.actuator is None:
        return np.ones(1), np.ones(1)
    denominator = autopilot.actuator.denominator
    return denominator[..., -1:], denominator


_RELATIVE_PERIOD = 1e-9
"""Relative distance of two sample times that count as equal."""
_MAX_DELAY_PERIODS = 25
"""Longest delay, in sample periods."""
_MAX_POLE_TIMES_PERIOD = 50.0
"""Largest unstable pole times the sample period: the motion grows by at most e^50 in a sample."""


def _vehicle_and_law(autopilot: Feedback, plant: AnyPlant) -> tuple[LinearSystem, LinearSystem]:
    """Return the plant with its actuator, and the law of a sampled autopilot, as state spaces.

    The first is continuous and leads from the command to what the law reads, the second is in steps
    of a sample and leads from there to the returned command. `InputError` for an unstable pole
    above 50 sample rates, a delay above 25 samples, and a filter too fast for the sample rate.
    """
    period, delay = 1.0 / np.asarray(autopilot.sample_rate), np.asarray(autopilot.delay)
    sensed = measured_outputs(autopilot, plant)
    behind_actuator = plant_with_actuator(plant, autopilot.actuator, autopilot.lateral_sensors)
    vehicle = behind_actuator.select((COMMAND,), sensed)
    growth = vehicle.poles.real.max(axis=-1) * period
    if np.any(growth > _MAX_POLE_TIMES_PERIOD):
        raise InputError(
            f"sample_rate = {np.min(1.0 / period):.6g} Hz is too low for a vehicle whose motion"
            f" grows by e^{np.max(growth):.3g} from one sample to the next"
        )
    if np.any(delay / period > _MAX_DELAY_PERIODS):
        raise InputError(
            f"delay must be at most {_MAX_DELAY_PERIODS} sample periods; got"
            f" {np.max(delay / period):.6g} (lower sample_rate, or leave it out: so fast a law is"
            " continuous)"
        )
    return vehicle, connect(autopilot_blocks(autopilot, plant, period), sensed, (RETURNED,))


def loop_in_steps(autopilot: Feedback, plant: AnyPlant) -> LinearSystem:
    """Return the open loop in steps of a sample, from the command to the returned command.

    `autopilot`: with a sample rate; its delay is exact. `plant`: one plant or a batch. Same
    exceptions as `sampled_loop`.
    """
    vehicle, law = _vehicle_and_law(autopilot, plant)
    return vehicle.to_steps(1.0 / np.asarray(autopilot.sample_rate), autopilot.delay).series(law)


def sampled_loop(autopilot: Feedback, plant: AnyPlant) -> SampledLoop:
    """Return the exact loop of an autopilot with a sample rate, for one plant or a batch.

    `autopilot`: with a sample_rate [Hz]; its delay [s] runs from the sample to the command at the
    actuator, up to 25 periods, a whole number of them or not. `InputError` for a filter whose own
    frequency is not below half the sample rate, a delay above 25 periods, and an unstable pole
    above 50 sample rates.
    """
    period, delay = 1.0 / np.asarray(autopilot.sample_rate), np.asarray(autopilot.delay)
    vehicle, law = _vehicle_and_law(autopilot, plant)
    batch = np.broadcast_shapes(vehicle.batch, law.batch, period.shape, delay.shape)
    h, T = (np.broadcast_to(array, batch) for array in (period, delay))

    def open_steps(delays: FloatArray, cases: IndexArray) -> LinearSystem:
        """Return open loops in steps of a sample, from the command to the returned command.

        `delays`: their delays [s], ``(k,)``. `cases`: their indices in the flattened batch,
        ``(k,)``, of vehicles, laws and sample periods h.
        """
        vehicles, laws = (system.cases(cases, batch) for system in (vehicle, law))
        return vehicles.to_steps(h.ravel()[cases], delays).series(laws)

    def delayed_form(delays: FloatArray, cases: IndexArray) -> StateLoop:
        """Return the same loops, in w = (2/h)(z - 1)/(z + 1) in place of z; h: sample period [s].

        Same parameters as `open_steps`: k delays [s], and k indices in the flattened batch.
        """
        return _w_plane_loops(open_steps(delays, cases), h.ravel()[cases])

    def delayed_closed_poles(delays: FloatArray, cases: IndexArray) -> ComplexArray:
        """Return closed-loop poles z ``(k, n)``, with delays [s] ``(k,)``, of cases ``(k,)``."""
        return open_steps(delays, cases).feedback(RETURNED, COMMAND).poles

    return SampledLoop(
        form=_w_plane_loops(vehicle.to_steps(h, T).series(law), h),
        batch=batch,
        period=h,
        loop_delay=T,
        delayed_form=delayed_form,
        delayed_closed_poles=delayed_closed_poles,
    )


def _w_plane_loops(steps: LinearSystem, period: FloatArray) -> StateLoop:
    """Return the loops L as functions of w = (2/h)(z - 1)/(z + 1), closed by 1 + L = 0.

    `steps`: open loops -L in steps of the period h, from the command to the returned command.
    `period`: h [s].
    """
    A, B, C, D = steps.matrices()
    return w_plane_loop((A, B, 0.0 - C, 0.0 - D), period)
