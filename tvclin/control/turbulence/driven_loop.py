"""Loop, shaping filter and sensors as one linear system in white noise.

    x' = A x + B_w alpha_w + n,    E[n(t) n(t')'] = N delta(t - t'),    y = C x + D_w alpha_w

x holds plant, actuator, delay, law and the filter of the turbulence, alpha_w is the known part of
the wind. A sampled autopilot adds jumps: at each sample x becomes J x + j alpha_w plus the noise of
the sensors, with the command that acts, those on their way to the actuator, and the states of the
law among x; a delay is exact.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Record
from tvclin.base.errors import InputError, instance, number, shown, within
from tvclin.base.fields import spec
from tvclin.control.autopilot.actuator import plant_with_actuator
from tvclin.control.autopilot.autopilot import PADE_WARNING, Autopilot, pade_misleads
from tvclin.control.autopilot.wiring import (
    COMMAND,
    RETURNED,
    SENSOR_NOISE,
    autopilot_blocks,
    closed_loop,
    measured_outputs,
)
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.system import LinearSystem, connect, split_delay
from tvclin.winds.turbulence import FilterMatrices, Turbulence

DEFLECTION, DEFLECTION_RATE = "deflection", "deflection_rate"
ACCELERATION = "deflection_acceleration"
ANGLE_OF_ATTACK, PATH = "angle_of_attack", "flight_path_angle"
DRIFT_RATE, DRIFT = "drift_rate", "drift"
Q_ALPHA, BENDING_MOMENT = "q_alpha", "bending_moment"
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

    attitude: float = field(default=0.0, metadata=spec())
    rate: float = field(default=0.0, metadata=spec())

    def __post_init__(self) -> None:
        for name in ("attitude", "rate"):
            density = number(name, within(name, getattr(self, name), 0.0, _MAX_DENSITY))
            object.__setattr__(self, name, density)

    @property
    def intensities(self) -> FloatArray:
        """Two-sided intensities of attitude and rate in continuous time, ``(2,)``."""
        return 0.5 * np.array([self.attitude, self.rate]) ** 2


@dataclass(frozen=True)
class LoadSlopes(Record):
    """Slopes of loads over angle of attack and deflection.

    Parameters
    ----------
    dynamic_pressure : float, optional
        Dynamic pressure [Pa], for the output "q_alpha" [Pa rad].
    alpha_moment, deflection_moment : float, optional
        Slopes of a bending moment over angle of attack and deflection [N m/rad], for the output
        "bending_moment" [N m].

    Raises
    ------
    InputError
        For numbers that are not finite.
    """

    dynamic_pressure: float | None = field(default=None, metadata=spec("pressure"))
    alpha_moment: float | None = field(default=None, metadata=spec("moment slope"))
    deflection_moment: float = field(default=0.0, metadata=spec("moment slope"))

    def __post_init__(self) -> None:
        for name in ("dynamic_pressure", "alpha_moment", "deflection_moment"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, number(name, getattr(self, name)))

    @property
    def slopes(self) -> dict[str, tuple[float, float]]:
        """Slopes over angle of attack and deflection of each output."""
        slopes = {}
        if self.dynamic_pressure is not None:
            slopes[Q_ALPHA] = self.dynamic_pressure, 0.0
        if self.alpha_moment is not None:
            slopes[BENDING_MOMENT] = self.alpha_moment, self.deflection_moment
        return slopes


class Jump(NamedTuple):
    """Jump of the states behind an interval: x becomes matrix x + wind alpha_w, plus noise.

    `length`: of the interval [s]. `matrix` ``(n, n)``, `wind` ``(n,)``, `noise`: its covariance.
    """

    length: float
    matrix: FloatArray
    wind: FloatArray
    noise: FloatArray


@dataclass(frozen=True, eq=False)
class DrivenLoop:
    """Linear system in white noise, or a batch of them in continuous time.

    `A`, `noise`: A [1/s] and N, ``(..., n, n)``. `wind`: B_w, ``(..., n)``. `rows`, `direct`: C
    ``(..., m, n)`` and D_w ``(..., m)`` of the outputs `labels`. `order`: number of states of the
    loop, ahead of those of the filter, which are the next `filter_order`. `jumps`: of a sampled
    autopilot, the intervals of a sample in their order.
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

    def part(self, index: slice) -> DrivenLoop:
        """Return the loops at some positions of a batch ``(n,)``."""
        names = ("A", "noise", "wind", "rows", "direct")
        return replace(self, **{name: getattr(self, name)[index] for name in names})

    def with_rows(self, rows: Mapping[str, tuple[FloatArray, FloatArray]]) -> DrivenLoop:
        """Return the loop with further outputs: the row and the direct part of each."""
        shape = self.rows.shape[:-2]
        more = [np.broadcast_to(row, (*shape, self.A.shape[-1])) for row, _ in rows.values()]
        direct = [np.broadcast_to(part, shape) for _, part in rows.values()]
        return replace(
            self,
            rows=np.concatenate([self.rows, *(row[..., np.newaxis, :] for row in more)], axis=-2),
            direct=np.concatenate([self.direct, *(d[..., np.newaxis] for d in direct)], axis=-1),
            labels=(*self.labels, *rows),
        )

    def row(self, output: str) -> tuple[FloatArray, FloatArray]:
        """Return the row and the direct part of an output."""
        k = self.labels.index(output)
        return self.rows[..., k, :], self.direct[..., k]

    def is_smooth(self, row: FloatArray, direct: FloatArray) -> bool:
        """Return whether an output has a rate of finite variance: it jumps with no noise."""
        return (
            not np.any(_times(row, self.noise))
            and not np.any(direct)
            and all(
                np.array_equal(row @ jump.matrix, row) and not np.any(row @ jump.noise)
                for jump in self.jumps
            )
        )

    def derivative(self, row: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the row and the direct part of the rate of an output that `is_smooth`."""
        return _times(row, self.A), np.sum(row * self.wind, axis=-1)


def _times(row: FloatArray, matrix: FloatArray) -> FloatArray:
    """Return row times matrix, ``(..., n)`` and ``(..., n, n)``."""
    return np.asarray((row[..., np.newaxis, :] @ matrix)[..., 0, :])


def _is_constant(row: FloatArray) -> bool:
    """Return whether a row is the same for all of a batch, as along a flight."""
    return bool(np.all(row == row.reshape(-1, row.shape[-1])[0]))


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
    """Return the loop of an autopilot and a plant behind a shaping filter.

    `shape`: A, b and c of the filter in time, to the wind angle [rad]; with leading axes for a
    batch of plants. `speed`: of the vehicle [m/s], ``(...)``. `drift`: whether the drift
    is a state of a continuous loop, which has no stationary covariance.

    `InputError` for a Pade approximation that hides an instability, and for an autopilot without
    actuator whose deflection follows the noise of a sensor.
    """
    if autopilot.sample_rate is not None:
        loop = _sampled(autopilot, plant, shape, noise)
    else:
        loop = _continuous(autopilot, plant, shape, noise)
    more = {}
    if PATH in loop.labels and DRIFT_RATE not in loop.labels:
        row, direct = loop.row(PATH)
        V = np.asarray(speed)
        more[DRIFT_RATE] = V[..., np.newaxis] * row, V * direct
    alpha, deflection = loop.row(ANGLE_OF_ATTACK), loop.row(DEFLECTION)
    for name, (by_alpha, by_deflection) in (loads.slopes if loads else {}).items():
        more[name] = tuple(  # type: ignore[assignment]
            by_alpha * a + by_deflection * d for a, d in zip(alpha, deflection, strict=True)
        )
    if loop.is_smooth(*deflection) and _is_constant(deflection[0]):
        rate = more[DEFLECTION_RATE] = loop.derivative(deflection[0])
        random = np.any(_times(rate[0], loop.noise)) or np.any(rate[1])
        if not random and _is_constant(rate[0]):
            more[ACCELERATION] = loop.derivative(rate[0])
    loop = loop.with_rows(more) if more else loop
    integrated = drift and not loop.jumps and DRIFT_RATE in loop.labels and DRIFT not in loop.labels
    return _with_drift(loop) if integrated else loop


def _continuous(
    autopilot: Autopilot, plant: AnyPlant, shape: FilterMatrices, noise: SensorNoise | None
) -> DrivenLoop:
    loop = closed_loop(autopilot, plant, sensor_noise=noise is not None)
    if not plant.batch and pade_misleads(autopilot, plant, loop.A):
        raise InputError(PADE_WARNING.format(autopilot.pade_order))
    A, wind, rows, direct, driven = _behind_filter(loop, shape)
    if noise is not None:
        sensed = loop.select(SENSOR_NOISE, (DEFLECTION,))
        if np.any(sensed.D * np.sqrt(noise.intensities)):
            raise InputError(
                "the deflection follows the noise of the sensors at once and has no variance; give"
                " the autopilot an actuator, or a sample rate"
            )
        n = loop.A.shape[-1]
        driven[..., :n, :n] += (sensed.B * noise.intensities) @ np.swapaxes(sensed.B, -1, -2)
    n, m = loop.A.shape[-1], shape[0].shape[-1]
    return DrivenLoop(A, driven, wind, rows, direct, loop.outputs, n, m)


def _behind_filter(
    loop: LinearSystem, shape: FilterMatrices
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return A, B_w, C, D_w and N of a system and its shaping filter; its input is "wind"."""
    system = loop.select(("wind",), loop.outputs)
    a, b, c = shape
    n, m = system.A.shape[-1], a.shape[-1]
    batch = np.broadcast_shapes(system.batch, a.shape[:-2], c.shape[:-2])
    A, driven = np.zeros((2, *batch, n + m, n + m))
    A[..., :n, :n], A[..., :n, n:], A[..., n:, n:] = system.A, system.B @ c, a
    driven[..., n:, n:] = b @ np.swapaxes(b, -1, -2)
    wind = np.zeros((*batch, n + m))
    wind[..., :n] = system.B[..., 0]
    rows = np.zeros((*batch, len(system.outputs), n + m))
    rows[..., :n], rows[..., n:] = system.C, system.D @ c
    return A, wind, rows, np.broadcast_to(system.D[..., 0], (*batch, len(system.outputs))), driven


def _sampled(
    autopilot: Autopilot, plant: AnyPlant, shape: FilterMatrices, noise: SensorNoise | None
) -> DrivenLoop:
    period = 1.0 / float(autopilot.sample_rate or 1.0)
    complete, rest = split_delay(float(autopilot.delay), period)
    whole, remainder = int(complete), float(rest)
    lateral = autopilot.lateral_sensors
    vehicle = plant_with_actuator(plant, autopilot.actuator, lateral)
    sensed = tuple(dict.fromkeys((*plant.sensed, *measured_outputs(autopilot, plant))))
    law = connect(autopilot_blocks(autopilot, plant, np.asarray(period)), sensed, (RETURNED,))
    A, wind, rows, direct, driven = _behind_filter(vehicle, shape)
    n, pipe, states = len(A), whole + 1, len(law.states)
    total = n + 1 + pipe + states
    held, commands, laws = n, slice(n + 1, n + 1 + pipe), slice(n + 1 + pipe, total)
    command = vehicle.select((COMMAND,), vehicle.outputs)
    full_A, full_noise = np.zeros((2, total, total))
    full_A[:n, :n], full_noise[:n, :n] = A, driven
    full_A[: len(vehicle.states), held] = command.B[:, 0]
    full_rows = np.zeros((len(rows), total))
    full_rows[:, :n], full_rows[:, held] = rows, command.D[:, 0]
    index = [vehicle.outputs.index(name) for name in sensed]
    # the sample: the law reads the sensors, its command enters the pipe, and one leaves it
    sensors = full_rows[index]
    sample = np.eye(total)
    sample[laws] = law.B @ sensors
    sample[laws, laws] += law.A
    sample[commands] = np.eye(pipe, k=-1) @ np.eye(total)[commands]
    sample[n + 1] = law.D[0] @ sensors
    sample[n + 1, laws] += law.C[0]
    entry, by_wind = np.zeros((total, 2)), np.zeros(total)
    entry[laws], entry[n + 1] = law.B[:, :2], law.D[0, :2]
    by_wind[laws], by_wind[n + 1] = law.B @ direct[index], law.D[0] @ direct[index]
    arrival = np.eye(total)
    arrival[held] = np.eye(total)[n + pipe]
    if not remainder:
        sample, entry, by_wind = arrival @ sample, arrival @ entry, arrival @ by_wind
    variances = (noise.intensities if noise else np.zeros(2)) / period
    jumps = [Jump(period - remainder, sample, by_wind, entry * variances @ entry.T)]
    if remainder:
        nothing = np.zeros(total)
        jumps.insert(0, Jump(remainder, arrival, nothing, np.zeros((total, total))))
    full_wind = np.zeros(total)
    full_wind[:n] = wind
    m = shape[0].shape[-1]
    return DrivenLoop(
        full_A,
        full_noise,
        full_wind,
        full_rows,
        direct,
        vehicle.outputs,
        n - m,
        m,
        tuple(jumps),
    )


def _with_drift(loop: DrivenLoop) -> DrivenLoop:
    """Return a continuous loop with the drift [m], the integral of the drift rate."""
    row, direct = loop.row(DRIFT_RATE)
    n = loop.A.shape[-1]

    def wider(matrix: FloatArray, rows: int) -> FloatArray:
        result = np.zeros((*matrix.shape[:-2], matrix.shape[-2] + rows, n + 1))
        result[..., : matrix.shape[-2], :n] = matrix
        return result

    A = wider(loop.A, 1)
    A[..., n, :n] = row
    wind = np.concatenate([loop.wind, np.asarray(direct)[..., np.newaxis]], axis=-1)
    wide = replace(loop, A=A, noise=wider(loop.noise, 1), wind=wind, rows=wider(loop.rows, 0))
    return wide.with_rows({DRIFT: (np.eye(n + 1)[n], np.asarray(0.0))})


def checked_parts(
    autopilot: Autopilot,
    turbulence: Turbulence,
    noise: SensorNoise | None,
    loads: LoadSlopes | None,
) -> None:
    """Raise `InputError` for arguments of another type."""
    instance("turbulence", turbulence, Turbulence, "see Turbulence.mil_f_8785c")
    instance("autopilot", autopilot, Autopilot, "see design_gains")
    if noise is not None and not isinstance(noise, SensorNoise):
        raise InputError(f"noise must be a SensorNoise or None; got {shown(noise)}")
    if loads is not None and not isinstance(loads, LoadSlopes):
        raise InputError(f"loads must be LoadSlopes or None; got {shown(loads)}")
