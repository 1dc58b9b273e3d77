"""Loop, shaping filter and sensors as one linear system in white noise.

    x' = A x + B_w alpha_w + n,    E[n(t) n(t')'] = N delta(t - t'),    y = C x + D_w alpha_w

x holds plant, actuator, delay, law and the filter of the turbulence, alpha_w is the known part of
the wind. A sampled autopilot adds jumps: at each sample x becomes J x + j alpha_w plus the noise of
the sensors, with the command that acts, those on their way to the actuator, and the states of the
law among x; a delay is exact.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Record
from tvclin.base.fields import checked, quantity, spec
from tvclin.control.autopilot import wiring
from tvclin.control.autopilot.actuator import plant_with_actuator
from tvclin.control.autopilot.autopilot import PADE_WARNING, Autopilot, pade_misleads
from tvclin.linear import lateral
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.system import LinearSystem, connect, split_delay
from tvclin.winds.turbulence import FilterMatrices, Turbulence

DEFLECTION, DEFLECTION_RATE = "deflection", "deflection_rate"
ACCELERATION = "deflection_acceleration"
ANGLE_OF_ATTACK, PATH = "angle_of_attack", "flight_path_angle"
DRIFT_RATE, DRIFT = "drift_rate", "drift"
Q_ALPHA, BENDING_MOMENT = "q_alpha", "bending_moment"
FILTERED = "filtered_"
"""Begin of the names of angle of attack and loads behind a low-pass."""
OUTPUT_KINDS = {
    "attitude": "angle",
    "sensed_attitude": "angle",
    "flight_path_angle": "angle",
    ANGLE_OF_ATTACK: "angle",
    DEFLECTION: "angle",
    "attitude_rate": "angular rate",
    "sensed_attitude_rate": "angular rate",
    DEFLECTION_RATE: "angular rate",
    ACCELERATION: "angular acceleration",
    DRIFT_RATE: "speed",
    DRIFT: "length",
    lateral.DRIFT_RATE: "speed",
    lateral.DRIFT: "length",
    lateral.ACCELERATION: "acceleration",
    "lateral_acceleration": "acceleration",
    Q_ALPHA: "pressure angle",
    BENDING_MOMENT: "moment",
}
OUTPUT_KINDS |= {
    FILTERED + name: OUTPUT_KINDS[name] for name in (ANGLE_OF_ATTACK, Q_ALPHA, BENDING_MOMENT)
}
"""Kind of unit of each output of a loop that is no output of a state space alone."""
_SLOPES = ("dynamic_pressure", "alpha_moment", "deflection_moment")
"""Names of the numbers of loads that may vary along a flight."""
_BANDWIDTHS = errors.between(1e-3, 1e5)
"""Check of bandwidths of a low-pass [rad/s]."""
_MAX_DENSITY = 1e3
"""Largest noise density of a sensor, in its unit."""


@dataclass(frozen=True)
class SensorNoise(Record):
    """White noise of the sensors of attitude and attitude rate.

    Parameters
    ----------
    attitude : float
        One-sided density of the attitude's noise [rad/sqrt(Hz)].
    rate : float
        One-sided density of the rate's noise [rad/s/sqrt(Hz)], the angle random walk of a gyro
        times sqrt(2).

    Raises
    ------
    InputError
        For a density that is negative or above 1000.

    Notes
    -----
    In continuous time white noise of a one-sided density N has E[n(t) n(t')] = N^2/2 delta(t - t');
    a sample of an autopilot with the sample rate f has the variance N^2 f/2, as behind a filter
    that passes all up to half the sample rate.
    """

    attitude: float = quantity("number", 0.0, errors.between(0.0, _MAX_DENSITY))
    rate: float = quantity("number", 0.0, errors.between(0.0, _MAX_DENSITY))

    def __post_init__(self) -> None:
        """Check both densities."""
        checked(self)

    @property
    def intensities(self) -> FloatArray:
        """Two-sided intensities N^2/2 of attitude and rate in continuous time, ``(2,)``.

        N: one-sided densities of their noise, [rad/sqrt(Hz)] and [rad/s/sqrt(Hz)].
        """
        return 0.5 * np.array([self.attitude, self.rate]) ** 2


@dataclass(frozen=True, eq=False)
class LoadSlopes(Record):
    """Slopes of loads over angle of attack and deflection, and a low-pass of loads that jump.

    Parameters
    ----------
    dynamic_pressure : array_like, optional
        Dynamic pressure [Pa], for the output "q_alpha" [Pa rad]. Along a flight with altitudes it
        is by default that of the flight.
    alpha_moment, deflection_moment : array_like, optional
        Slopes of a bending moment over angle of attack and deflection [N m/rad], for the output
        "bending_moment" [N m].
    bandwidth : float, optional
        Bandwidth [rad/s] of a first-order low-pass, behind which angle of attack and loads are the
        further outputs "filtered_angle_of_attack", "filtered_q_alpha" and
        "filtered_bending_moment": those have crossings of a limit, which rise with the bandwidth.

    Raises
    ------
    InputError
        For numbers that are not finite, shapes that do not broadcast, and a bandwidth beyond 1e-3
        to 1e5 rad/s.

    Notes
    -----
    Numbers over a flight are those at the times of its schedule, ``(n,)``.
    """

    dynamic_pressure: float | FloatArray | None = field(default=None, metadata=spec("pressure"))
    alpha_moment: float | FloatArray | None = field(default=None, metadata=spec("moment slope"))
    deflection_moment: float | FloatArray = field(default=0.0, metadata=spec("moment slope"))
    bandwidth: float | None = field(default=None, metadata=spec("natural frequency"))

    def __post_init__(self) -> None:
        """Check the bandwidth, and the slopes of all loads: finite, of shapes that broadcast.

        The slopes are dynamic pressure and moments, numbers or arrays ``(n,)`` along a flight.
        """
        shapes = {}
        for name in _SLOPES:
            if getattr(self, name) is not None:
                value = errors.finite(name, getattr(self, name))
                shapes[name] = value.shape
                object.__setattr__(self, name, errors.plain(value))
        errors.broadcast(**shapes)
        if self.bandwidth is not None:
            object.__setattr__(
                self, "bandwidth", errors.number("bandwidth", self.bandwidth, _BANDWIDTHS)
            )

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the numbers; ``()`` for one flight time."""
        return np.broadcast_shapes(*(np.shape(getattr(self, name)) for name in _SLOPES))

    @property
    def slopes(self) -> dict[str, tuple[float | FloatArray, float | FloatArray]]:
        """Slopes of each load by name [unit/rad], over angle of attack and over deflection."""
        slopes: dict[str, tuple[float | FloatArray, float | FloatArray]] = {}
        if self.dynamic_pressure is not None:
            slopes[Q_ALPHA] = self.dynamic_pressure, 0.0
        if self.alpha_moment is not None:
            slopes[BENDING_MOMENT] = self.alpha_moment, self.deflection_moment
        return slopes


def loads_at(loads: LoadSlopes, times: FloatArray, at: FloatArray) -> LoadSlopes:
    """Return the slopes of loads interpolated at flight times `at` [s], ``(m,)``.

    `loads`: slopes at the flight times `times` [s] ``(n,)``, or constant; `InputError` for another
    shape.
    """
    if loads.batch not in {(), times.shape}:
        raise errors.InputError(
            f"loads along a flight must have one number, or one for each of the {times.size} times"
            f" of the schedule; got shape {loads.batch}"
        )
    numbers = {name: getattr(loads, name) for name in _SLOPES}
    changes = {
        name: np.interp(at, times, value) for name, value in numbers.items() if np.ndim(value)
    }
    return replace(loads, **changes)


class Signal(NamedTuple):
    """Output of a loop.

    `row`, `direct`: its row of the states ``(..., n)`` and its direct part of the known wind.
    `rate`: row and direct part of its rate; None for an output that jumps.
    """

    row: FloatArray
    direct: FloatArray
    rate: tuple[FloatArray, FloatArray] | None


class Jump(NamedTuple):
    """Jump of the states behind an interval: x becomes matrix x + wind alpha_w, plus noise.

    `length`: of the interval [s]. `matrix` ``(..., n, n)``, `wind` ``(..., n)``, `noise`: its
    covariance, ``(..., n, n)``.
    """

    length: float
    matrix: FloatArray
    wind: FloatArray
    noise: FloatArray


@dataclass(frozen=True, eq=False)
class DrivenLoop:
    """Linear system in white noise, or a batch of them.

    `A`: system matrix [1/s]; `noise`: N = B B', intensity of the noise behind its input column B;
    ``(..., n, n)`` each. `wind`: column B_w of a further wind [rad], ``(..., n)``. `rows`,
    `direct`: C ``(..., m, n)`` and direct terms D_w ``(..., m)`` from it, of the outputs `labels`.
    `order`: number of states of the loop, behind which are the `filter_order` states of the filter.
    `jumps`: of a sampled autopilot, the intervals of a sample in their order.
    """

    A: FloatArray
    noise: FloatArray
    wind: FloatArray
    rows: FloatArray
    direct: FloatArray
    labels: tuple[str, ...]
    order: int
    filter_order: int
    jumps: tuple[Jump, ...] = ()

    @property
    def arrays(self) -> tuple[FloatArray, ...]:
        """All arrays of the loop, in the order in which `mapped` takes them."""
        jumps = (array for jump in self.jumps for array in jump[1:])
        return self.A, self.noise, self.wind, self.rows, self.direct, *jumps

    def mapped(self, function: Callable[[FloatArray], FloatArray]) -> DrivenLoop:
        """Return the loop with `function` of each of its arrays, to change the batch of all.

        The arrays are taken in the order of the property `arrays`.
        """
        A, noise, wind, rows, direct = map(function, self.arrays[:5])  # the others: of jumps
        jumps = tuple(Jump(length, *map(function, arrays)) for length, *arrays in self.jumps)
        return replace(self, A=A, noise=noise, wind=wind, rows=rows, direct=direct, jumps=jumps)

    def jumps_at(self, index: int, times: FloatArray) -> list[Jump]:
        """Return the jump behind the interval `index` of a sample for each of n `times`."""
        return [self.jumps[index]] * len(times)

    def with_rows(self, rows: Mapping[str, tuple[FloatArray, FloatArray]]) -> DrivenLoop:
        """Return the loop with further outputs.

        `rows`: row ``(..., n)`` and direct term ``(...)`` of each by its name.
        """
        batch = self.rows.shape[:-2]
        C = [np.broadcast_to(row, (*batch, self.A.shape[-1])) for row, _ in rows.values()]
        D = [np.broadcast_to(direct, batch) for _, direct in rows.values()]
        return replace(
            self,
            rows=np.concatenate([self.rows, np.stack(C, axis=-2)], axis=-2),
            direct=np.concatenate([self.direct, np.stack(D, axis=-1)], axis=-1),
            labels=(*self.labels, *rows),
        )

    def row(self, output: str) -> tuple[FloatArray, FloatArray]:
        """Return the row ``(..., n)`` and the direct term ``(...)`` of an output."""
        k = self.labels.index(output)
        return self.rows[..., k, :], self.direct[..., k]

    def is_smooth(self, row: FloatArray, direct: FloatArray) -> bool:
        """Return whether an output has a rate of finite variance: no noise makes it jump.

        `row`, `direct`: row ``(..., n)`` of C and direct term ``(...)`` of the output. Nothing of
        the noise N reaches it at once (row N = 0), nor the known wind, and a sample leaves it as it
        is, x -> J x with row J = row.
        """
        return (
            not np.any(_times(row, self.noise))
            and not np.any(direct)
            and all(
                np.array_equal(_times(row, jump.matrix), row)
                and not np.any(_times(row, jump.noise))
                for jump in self.jumps
            )
        )

    def signal(self, output: str) -> Signal:
        """Return row and direct term of the output called `output`, and of its rate if it has one.

        An output that turbulence, noise, wind or a sample moves at once has no rate.
        """
        row, direct = self.row(output)
        return Signal(row, direct, self.derivative(row) if self.is_smooth(row, direct) else None)

    @property
    def output_signals(self) -> dict[str, Signal]:
        """Outputs with their rates by name."""
        return {output: self.signal(output) for output in self.labels}

    def derivative(self, row: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return row and direct term of the rate of a smooth output with this `row` of C.

        y' = row x' = (row A) x + (row B_w) alpha_w.
        """
        return _times(row, self.A), np.sum(row * self.wind, axis=-1)


def _times(row: FloatArray, matrix: FloatArray) -> FloatArray:
    """Return row times matrix, ``(..., n)``, of `row` ``(..., n)`` and `matrix` ``(..., n, n)``."""
    return np.asarray((row[..., np.newaxis, :] @ matrix)[..., 0, :])


def _is_constant(row: FloatArray) -> bool:
    """Return whether a row ``(..., n)`` is the same for all loops of a batch."""
    first = row.reshape(-1, row.shape[-1])[0]
    return bool(np.all(row == first))


def driven_loop(
    autopilot: Autopilot,
    plant: AnyPlant,
    shape: FilterMatrices,
    speed: FloatArray,
    noise: SensorNoise | None = None,
    loads: LoadSlopes | None = None,
    *,
    drift: bool = False,
) -> DrivenLoop:
    """Return the loop of an autopilot and a plant behind a shaping filter of turbulence.

    Its outputs are those of the closed loop, the drift rate, loads, rate and acceleration of the
    deflection where these have a variance, and what is behind a low-pass.

    `autopilot`, `plant`: one each, or a batch along a flight. `shape`: A, b and c of the filter in
    time, to the wind angle [rad]; with leading axes for a batch of plants. `speed`: of the vehicle
    [m/s], ``(...)``. `noise`: of the sensors. `loads`: slopes of further outputs. `drift`: whether
    the drift [m], the integral of the drift rate, is a state; it has no stationary covariance.

    `InputError` for a Pade approximation that hides an instability, and for an autopilot without
    actuator whose deflection follows the noise of a sensor.
    """
    if autopilot.sample_rate is not None:
        loop = _sampled(autopilot, plant, shape, noise)
    else:
        loop = _continuous(autopilot, plant, shape, noise)
    # Further outputs, each with its row and its direct term: the drift rate V gamma, loads, and
    # rate and acceleration of the deflection, where they have a variance and are the rates of
    # outputs whose rows do not vary along a flight.
    more: dict[str, tuple[FloatArray, FloatArray]] = {}
    if PATH in loop.labels and DRIFT_RATE not in loop.labels:
        row, direct = loop.row(PATH)
        V = np.asarray(speed)
        more[DRIFT_RATE] = V[..., np.newaxis] * row, V * direct
    alpha_row, alpha_direct = loop.row(ANGLE_OF_ATTACK)
    deflection_row, deflection_direct = loop.row(DEFLECTION)
    for name, slopes in (loads.slopes if loads else {}).items():
        by_alpha, by_deflection = map(np.asarray, slopes)
        row = (
            by_alpha[..., np.newaxis] * alpha_row + by_deflection[..., np.newaxis] * deflection_row
        )
        more[name] = row, by_alpha * alpha_direct + by_deflection * deflection_direct
    if loop.is_smooth(deflection_row, deflection_direct) and _is_constant(deflection_row):
        rate_row, rate_direct = more[DEFLECTION_RATE] = loop.derivative(deflection_row)
        jumps_with_noise = np.any(_times(rate_row, loop.noise)) or np.any(rate_direct)
        if not jumps_with_noise and _is_constant(rate_row):
            more[ACCELERATION] = loop.derivative(rate_row)
    loop = loop.with_rows(more) if more else loop
    # Further states z' = pole z + row x + direct alpha_w: angle of attack and loads behind a
    # low-pass, and the drift.
    states: dict[str, tuple[float, FloatArray, FloatArray]] = {}  # pole, row, direct
    if loads is not None and (w := loads.bandwidth) is not None:
        for name in (ANGLE_OF_ATTACK, *loads.slopes):
            row, direct = loop.row(name)
            states[FILTERED + name] = -w, w * row, w * direct
    if drift and DRIFT_RATE in loop.labels and DRIFT not in loop.labels:
        states[DRIFT] = 0.0, *loop.row(DRIFT_RATE)
    return _with_states(loop, states) if states else loop


def _continuous(
    autopilot: Autopilot, plant: AnyPlant, shape: FilterMatrices, noise: SensorNoise | None
) -> DrivenLoop:
    """Return a loop without samples behind a shaping filter, with the noise of its sensors.

    Same parameters and exceptions as `driven_loop`.
    """
    loop = wiring.closed_loop(autopilot, plant, sensor_noise=noise is not None, command=True)
    if not plant.batch and pade_misleads(autopilot, plant, loop):
        raise errors.InputError(PADE_WARNING.format(autopilot.pade_order))
    # The last output is the returned command, which only the check above reads.
    driven = _behind_filter(loop.select(loop.inputs, loop.outputs[:-1]), shape)
    if noise is not None:
        from_noise = loop.select(wiring.SENSOR_NOISE, (DEFLECTION,))
        if np.any(from_noise.D * np.sqrt(noise.intensities)):
            raise errors.InputError(
                "the deflection follows the noise of the sensors at once and has no variance; give"
                " the autopilot an actuator, or a sample rate"
            )
        B, states = from_noise.B, slice(driven.order)  # of the loop, ahead of the filter's
        driven.noise[..., states, states] += (B * noise.intensities) @ np.swapaxes(B, -1, -2)
    return driven


def _behind_filter(
    loop: LinearSystem, shape: FilterMatrices, batch: tuple[int, ...] = ()
) -> DrivenLoop:
    """Return a system driven by a shaping filter, whose output is the system's input "wind".

    The states are the n of `loop` and the m of the filter z' = a z + b times white noise, whose
    output c z is the turbulent wind angle [rad]; a further wind acts on `loop` alone. `shape`: a
    ``(..., m, m)``, b ``(..., m, 1)`` and c ``(..., 1, m)``. `batch`: batch of outputs that are
    added later, with which the arrays broadcast.
    """
    system = loop.select(("wind",), loop.outputs)
    a, b, c = shape
    n, m = system.A.shape[-1], a.shape[-1]
    batch = np.broadcast_shapes(system.batch, a.shape[:-2], c.shape[:-2], batch)
    A, noise = np.zeros((2, *batch, n + m, n + m))
    A[..., :n, :n], A[..., :n, n:], A[..., n:, n:] = system.A, system.B @ c, a
    noise[..., n:, n:] = b @ np.swapaxes(b, -1, -2)
    wind = np.zeros((*batch, n + m))
    wind[..., :n] = system.B[..., 0]
    rows = np.zeros((*batch, len(system.outputs), n + m))
    rows[..., :n], rows[..., n:] = system.C, system.D @ c
    direct = np.broadcast_to(system.D[..., 0], (*batch, len(system.outputs)))
    return DrivenLoop(A, noise, wind, rows, direct, loop.outputs, order=n, filter_order=m)


def _widened(loop: DrivenLoop, count: int) -> DrivenLoop:
    """Return a loop with `count` more states behind the others; the new ones are constant."""

    def wider(array: FloatArray, axes: int) -> FloatArray:
        """Return an array with `count` zeros more at the end of each of its last `axes` axes."""
        return np.pad(array, [(0, 0)] * (array.ndim - axes) + [(0, count)] * axes)

    n = loop.A.shape[-1]
    new_states = np.diag(np.append(np.zeros(n), np.ones(count)))  # a jump leaves them as they are
    jumps = tuple(
        Jump(length, wider(matrix, 2) + new_states, wider(wind, 1), wider(noise, 2))
        for length, matrix, wind, noise in loop.jumps
    )
    A, noise = wider(loop.A, 2), wider(loop.noise, 2)
    wind, rows = wider(loop.wind, 1), wider(loop.rows, 1)
    return replace(loop, A=A, noise=noise, wind=wind, rows=rows, jumps=jumps)


def _sampled(
    autopilot: Autopilot, plant: AnyPlant, shape: FilterMatrices, noise: SensorNoise | None
) -> DrivenLoop:
    """Return a sampled loop behind a shaping filter; its states jump at each sample.

    Behind the states of vehicle, actuator and filter follow the command that acts on the actuator
    (constant between jumps), the commands on their way through the delay, and the states of the
    law. The delay is a number of complete samples and a rest [s]; with a rest a sample has two
    intervals, and the command arrives behind the first.

    Same parameters as `driven_loop`; a batch has one sample rate and delay.
    """
    period = 1.0 / float(autopilot.sample_rate or 1.0)  # [s]; there is a sample rate
    complete, rest = split_delay(float(autopilot.delay), period)
    vehicle = plant_with_actuator(plant, autopilot.actuator, autopilot.lateral_sensors)
    sensed = tuple(dict.fromkeys((*plant.sensed, *wiring.measured_outputs(autopilot, plant))))
    law = connect(
        wiring.autopilot_blocks(autopilot, plant, np.asarray(period)), sensed, (wiring.RETURNED,)
    )
    driven = _behind_filter(vehicle, shape, law.batch)
    # Indices of the further states: the command that acts, those on their way, from the newest to
    # the next to act, and the states of the law.
    acting = driven.A.shape[-1]
    newest, next_to_act = acting + 1, acting + 1 + int(complete)
    laws = slice(next_to_act + 1, next_to_act + 1 + len(law.states))
    loop = _widened(driven, laws.stop - acting)
    command = vehicle.select((wiring.COMMAND,), vehicle.outputs)
    loop.A[..., : len(vehicle.states), acting] = command.B[..., 0]
    loop.rows[..., acting] = command.D[..., 0]
    # A sample: the law reads the sensors, and its command is the newest of those on their way.
    # Inputs 0 and 1 of the law are attitude and attitude rate, the sensors with noise.
    index = [vehicle.outputs.index(name) for name in sensed]
    # what the sensors read of the states, and of the wind
    sensors, sensors_of_wind = loop.rows[..., index, :], loop.direct[..., index]
    unit = np.eye(laws.stop)
    sample = np.broadcast_to(unit, loop.A.shape).copy()
    sample[..., laws, :] = law.B @ sensors
    sample[..., laws, laws] += law.A
    sample[..., newest + 1 : next_to_act + 1, :] = unit[newest:next_to_act]  # each moves on by one
    sample[..., newest, :] = _times(law.D[..., 0, :], sensors)
    sample[..., newest, laws] += law.C[..., 0, :]
    by_noise, by_wind = np.zeros((*loop.A.shape[:-1], 2)), np.zeros(loop.A.shape[:-1])
    by_noise[..., laws, :], by_noise[..., newest, :] = law.B[..., :2], law.D[..., 0, :2]
    by_wind[..., laws] = (law.B @ sensors_of_wind[..., np.newaxis])[..., 0]
    by_wind[..., newest] = np.sum(law.D[..., 0, :] * sensors_of_wind, axis=-1)
    # The next to act arrives and acts: at the sample, or with the rest of the delay.
    arrival = unit.copy()
    arrival[acting] = unit[next_to_act]
    if not rest:
        sample, by_noise, by_wind = arrival @ sample, arrival @ by_noise, by_wind @ arrival.T
    variances = (noise.intensities if noise else np.zeros(2)) / period  # of a sample
    covariance = (by_noise * variances) @ np.swapaxes(by_noise, -1, -2)
    jumps = [Jump(period - float(rest), sample, wind=by_wind, noise=covariance)]
    if rest:
        arrivals = np.broadcast_to(arrival, sample.shape)
        no_wind, no_noise = np.zeros_like(by_wind), np.zeros_like(sample)
        jumps.insert(0, Jump(float(rest), arrivals, wind=no_wind, noise=no_noise))
    return replace(loop, jumps=tuple(jumps))


def _with_states(
    loop: DrivenLoop, states: Mapping[str, tuple[float, FloatArray, FloatArray]]
) -> DrivenLoop:
    """Return a loop with further outputs, each a state z' = pole z + row x + direct alpha_w.

    `states`: pole [1/s], row ``(..., n)`` and direct term of each by name; they become the last
    states.
    """
    n, wide = loop.A.shape[-1], _widened(loop, len(states))
    for k, (pole, row, direct) in enumerate(states.values(), start=n):
        wide.A[..., k, :n], wide.A[..., k, k], wide.wind[..., k] = row, pole, direct
    rows = np.eye(n + len(states))[n:]  # each output is its state, without a direct term
    direct = np.asarray(0.0)
    return wide.with_rows({name: (row, direct) for name, row in zip(states, rows, strict=True)})


def checked_parts(
    autopilot: Autopilot,
    turbulence: Turbulence,
    noise: SensorNoise | None,
    loads: LoadSlopes | None,
) -> None:
    """Raise `InputError` for an autopilot, turbulence, noise or loads of another type."""
    errors.instance("turbulence", turbulence, Turbulence, "see Turbulence.mil_f_8785c")
    errors.instance("autopilot", autopilot, Autopilot, "see design_gains")
    if noise is not None and not isinstance(noise, SensorNoise):
        raise errors.InputError(f"noise must be a SensorNoise or None; got {errors.shown(noise)}")
    if loads is not None and not isinstance(loads, LoadSlopes):
        raise errors.InputError(f"loads must be LoadSlopes or None; got {errors.shown(loads)}")


def check_single(
    function: str, autopilot: Autopilot, plant: AnyPlant, loads: LoadSlopes | None
) -> None:
    """Raise `InputError` for a batch, as the calling `function` is for one loop.

    `autopilot`, `plant`, `loads`: the arguments that must be single.
    """
    of_loads = () if loads is None else loads.batch
    if autopilot.batch or plant.batch or of_loads:
        raise errors.InputError(
            f"{function}() is for one autopilot and one plant; got batches of shape"
            f" {autopilot.batch} and {plant.batch}, loads {of_loads} (see turbulence_along)"
        )
