"""Motion of a nozzle step by step, from samples or a flight, and its torque, power and energy."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Self

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.fields import Field, spec, specs
from tvclin.case.nozzle import NozzleData
from tvclin.flights.closed_loop.fly import NozzleFlight
from tvclin.linear.extremes import Point
from tvclin.vehicle.vehicle import Vehicle


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion of a nozzle and of its vehicle.

    `times` [s], `deflection` [rad]: ``(n + 1,)``, with straight lines between. `at` [s]: a time in
    each step, ``(n,)``, and at these times: `angle`, `rate`, `acceleration`: the deflection and its
    derivatives [rad, rad/s, rad/s2]; `angle_of_attack` [rad]; `angular_acceleration`: of the
    vehicle [rad/s2]. `weights` [s]: of an integral over time, ``(n,)``.
    `peak_acceleration`: the largest acceleration [rad/s2].
    """

    times: FloatArray
    deflection: FloatArray
    at: FloatArray
    angle: FloatArray
    rate: FloatArray
    acceleration: FloatArray
    peak_acceleration: Point
    angle_of_attack: FloatArray
    angular_acceleration: FloatArray
    weights: FloatArray

    @classmethod
    def of_samples(
        cls, t: FloatArray, delta: FloatArray, alpha: FloatArray, attitude: FloatArray
    ) -> Self:
        """Return a motion from n samples, with differences as derivatives, between samples.

        `t`: times [s], ``(n,)``. `delta`, `alpha`, `attitude`: deflection, angle of attack and
        attitude [rad], ``(n,)``.
        """
        acceleration = _second_derivative(t, delta)
        return cls(
            times=t,
            deflection=delta,
            at=_middle(t),
            angle=_middle(delta),
            rate=np.diff(delta) / np.diff(t),
            acceleration=_middle(np.pad(acceleration, 1, mode="edge")),
            peak_acceleration=largest(acceleration, t[1:-1]),
            angle_of_attack=_middle(alpha),
            angular_acceleration=_middle(np.pad(_second_derivative(t, attitude), 1, mode="edge")),
            weights=np.diff(t),
        )

    @classmethod
    def of_flight(cls, flight: NozzleFlight) -> Self:
        """Return the motion of a flight with its actuator, right after the start of each step.

        Integrals take every second time, in the middle between two changes of the command. Without
        an actuator the motion is taken from sample to sample.
        """
        t, delta, alpha = flight.times, flight.deflection, flight.angle_of_attack
        if flight.rate is None or flight.acceleration is None:
            rows = (t, delta, alpha, flight.attitude)
            return cls.of_samples(*(row[:: flight.times_per_sample] for row in rows))
        weights = np.zeros(t.size - 1)
        weights[1::2] = t[2::2] - t[:-2:2]
        return cls(
            times=t,
            deflection=delta,
            at=t[:-1],
            angle=delta[:-1],
            rate=flight.rate[:-1],
            acceleration=flight.acceleration[:-1],
            peak_acceleration=largest(flight.acceleration, t),
            angle_of_attack=alpha[:-1],
            angular_acceleration=np.pad(
                _second_derivative(t, flight.attitude), (1, 0), mode="edge"
            ),
            weights=weights,
        )

    @property
    def steps(self) -> FloatArray:
        """Lengths of the steps [s], ``(n,)``."""
        return np.diff(self.times)

    def between(self, start: float, stop: float) -> Self | None:
        """Return the motion from `start` to `stop` [s]; None where it has fewer than two steps."""
        inside = np.flatnonzero((self.times[:-1] >= start) & (self.times[1:] <= stop))
        if inside.size < 2:
            return None
        steps = slice(inside[0], inside[-1] + 1)
        rows = {k: getattr(self, k)[steps] for k in ("at", "angle", "rate", "acceleration")}
        ends = slice(steps.start, steps.stop + 1)
        return type(self)(
            times=self.times[ends],
            deflection=self.deflection[ends],
            **rows,
            peak_acceleration=largest(rows["acceleration"], rows["at"]),
            angle_of_attack=self.angle_of_attack[steps],
            angular_acceleration=self.angular_acceleration[steps],
            weights=self.weights[steps],
        )


def largest(values: FloatArray, times: FloatArray) -> Point:
    """Return the largest of `values` in size, with its sign, and its time [s]."""
    k = int(np.argmax(np.abs(values)))
    return Point(float(values[k]), float(times[k]))


def rms(values: FloatArray, weights: FloatArray) -> float:
    """Return the root mean square of `values`, with the weights [s] of an integral over time."""
    return float(np.sqrt(np.average(values**2, weights=weights)))


def _second_derivative(t: FloatArray, values: FloatArray) -> FloatArray:
    """Return second derivatives of n `values` at inner times `t` [s], ``(n - 2,)``."""
    return np.diff(np.diff(values) / np.diff(t)) / ((t[2:] - t[:-2]) / 2.0)


def _middle(values: FloatArray) -> FloatArray:
    """Return the means of neighbours among n values, ``(n - 1,)``."""
    return (values[1:] + values[:-1]) / 2.0


AT_REST = 1e-6
"""Fraction of the largest rate below which a rate counts as zero."""


@dataclass(frozen=True)
class Work(Shown):
    """Torque, power and energy of the actuators.

    `torque`: largest torque [N m] while the nozzle turns, with friction. `holding`: largest torque
    [N m] at rest, to which friction adds or takes up to M_f. `rms_torque`: root of the mean square
    [N m] at all times, with friction in motion. `power`: largest power [W] of the actuators.
    `energy`: work of the actuators [J], from which `returned` [J], the work of the nozzle on them,
    is not subtracted.
    `corner_power`: largest torque times largest rate [W], never below the largest power.
    `stiffness`: k + s_E a_x [N m/rad]; with a negative one the nozzle turns away by itself.
    """

    torque: Point = field(
        metadata=specs(
            Field(kind="moment", of="torque.value"),
            Field(kind="time", name="torque_time", of="torque.time"),
        )
    )
    holding: float = field(metadata=spec("moment", name="holding_torque"))
    rms_torque: float = field(metadata=spec("moment"))
    power: Point = field(
        metadata=specs(
            Field(kind="power", of="power.value"),
            Field(kind="time", name="power_time", of="power.time"),
        )
    )
    energy: float = field(metadata=spec("energy"))
    returned: float = field(metadata=spec("energy", name="returned_energy"))
    corner_power: float = field(metadata=spec("power"))
    stiffness: float


def work_of(motion: Motion, nozzle: NozzleData, vehicle: Vehicle | None) -> tuple[Work, list[str]]:
    """Return torque, power and energy of a motion, and notes on omitted terms.

    `nozzle`: engine and hinge, see `nozzle_duty` for the equation. `vehicle`: None on a bench.
    """
    engine, weights, rate = nozzle.engine, motion.weights, motion.rate
    inertia, moment = float(engine.inertia_about_gimbal), float(engine.static_moment)
    stiffness, constant, inertial = nozzle.stiffness, 0.0, np.zeros(rate.size)
    notes = []
    if vehicle is None:
        notes.append("without a vehicle the torque is that on a bench: no thrust, no acceleration")
    else:
        mass, thrust = float(vehicle.mass), float(vehicle.thrust)
        a_x = (thrust - float(vehicle.axial_force)) / mass
        force = float(vehicle.normal_force_slope) * motion.angle_of_attack
        force = force + float(vehicle.control_force) * motion.angle
        a_n = force / mass - float(vehicle.control_arm) * motion.angular_acceleration
        inertial = inertia * motion.angular_acceleration - moment * a_n
        stiffness += moment * a_x
        constant = float(engine.mass) * a_x * nozzle.offset + thrust * nozzle.thrust_offset
        if stiffness < 0.0:
            notes.append("k + s_E a_x is negative: the nozzle turns away by itself")
    frictionless = inertia * motion.acceleration + stiffness * motion.angle + constant + inertial
    moving = np.abs(rate) > AT_REST * np.abs(rate).max()
    friction = np.where(moving, nozzle.friction * np.sign(rate), 0.0)
    torque = frictionless + nozzle.damping * rate + friction
    power = torque * rate
    peak, peak_power = largest(np.where(moving, torque, 0.0), motion.at), int(np.argmax(power))
    work = Work(
        torque=peak,
        holding=float(np.where(moving, 0.0, np.abs(torque)).max()),
        rms_torque=rms(torque, weights),
        power=Point(max(float(power[peak_power]), 0.0), float(motion.at[peak_power])),
        energy=float((np.maximum(power, 0.0) * weights).sum()),
        returned=float((np.maximum(-power, 0.0) * weights).sum()),
        corner_power=abs(peak.value) * float(np.abs(rate).max()),
        stiffness=stiffness,
    )
    return work, notes
