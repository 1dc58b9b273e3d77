"""Duty of a nozzle in a motion: angle, rate, travel, and torque, power and energy.

A motion consists of steps, from samples or from a flight with its actuator.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.fields import Field, rows, spec, specs
from tvclin.base.lines import Table, quantities
from tvclin.base.lines import number as figure
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

        Integrals take every second time, in the middle between two changes of the command, with the
        time [s] between the changes as its weight. Without an actuator the motion is taken from
        sample to sample.
        """
        t, delta, alpha = flight.times, flight.deflection, flight.angle_of_attack
        if flight.rate is None or flight.acceleration is None:
            rows = (t, delta, alpha, flight.attitude)
            return cls.of_samples(*(row[:: flight.times_per_sample] for row in rows))
        # Times alternate: a change of the command, and the middle between two of them.
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

    def between(self, start: float, stop: float) -> Self | None:
        """Return the motion from `start` to `stop` [s]; None where it has fewer than two steps.

        Its largest acceleration is that at the times `at` of its steps, one in each.
        """
        inside = np.flatnonzero((self.times[:-1] >= start) & (self.times[1:] <= stop))
        if inside.size < 2:
            return None
        steps = slice(inside[0], inside[-1] + 1)
        ends = slice(steps.start, steps.stop + 1)
        of_steps = {
            name: values[steps]
            for name, values in vars(self).items()
            if name not in ("times", "deflection", "peak_acceleration")
        }
        return replace(
            self,
            times=self.times[ends],
            deflection=self.deflection[ends],
            peak_acceleration=largest(self.acceleration[steps], self.at[steps]),
            **of_steps,
        )


def largest(values: FloatArray, times: FloatArray) -> Point:
    """Return the value of largest size of `values` ``(n,)``, with its sign, and its time [s]."""
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


def _peak(name: str, kind: str, *, card: bool = True, time_card: bool = False) -> Mapping[str, Any]:
    """Return the metadata of the attribute `name`, a `Point`: its value, and its time.

    `kind`: kind of quantity of the value. `card`, `time_card`: whether notebooks show each.
    """
    time = Field(kind="time", name=f"{name}_time", of=f"{name}.time", card=time_card)
    return specs(Field(kind=kind, of=f"{name}.value", card=card), time)


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

    torque: Point = field(metadata=_peak("torque", "moment", time_card=True))
    holding: float = field(metadata=spec("moment", name="holding_torque"))
    rms_torque: float = field(metadata=spec("moment"))
    power: Point = field(metadata=_peak("power", "power", time_card=True))
    energy: float = field(metadata=spec("energy"))
    returned: float = field(metadata=spec("energy", name="returned_energy"))
    corner_power: float = field(metadata=spec("power"))
    stiffness: float


def work_of(motion: Motion, nozzle: NozzleData, vehicle: Vehicle | None) -> tuple[Work, list[str]]:
    """Return torque, power and energy of a motion, and notes on omitted terms.

    The torque is M in the notes of `nozzle_duty`, which define its terms. `motion`: deflection,
    rates and accelerations in each step. `nozzle`: engine and hinge. `vehicle`: None on a bench.
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


_STOP_TOLERANCE = 1e-3
"""Distance from the limit, relative to it, within which a deflection is at the limit."""
WINDOW = 0.5
"""Length [s] of the usual window of a steady rate."""
WITHOUT_DATA = (
    "torque, power and energy need the engine and its hinge: mass_kg, arm_m and more in [nozzle]"
)
"""Note on a duty without nozzle data."""


@dataclass(frozen=True)
class NozzleDuty(Shown):
    """Duty of a nozzle in a motion; peaks with their signs and times.

    Attributes
    ----------
    angle, rate, acceleration : Point
        Largest deflection [rad], its rate [rad/s] and acceleration [rad/s2]: differences from
        sample to sample.
    rms_rate : float
        Root of the mean square rate [rad/s].
    steady_rate : float
        Largest mean rate [rad/s] over a window.
    window : float
        Length of that window [s].
    travel : float
        Integral of ``|delta'|`` [rad].
    reversals : int
        Number of sign changes of the rate.
    time_at_stop : float or None
        Time [s] within a thousandth of the limit; None without a limit.
    work : Work or None
        Torque, power and energy; None without nozzle data.
    notes : tuple of str
        Omitted terms, and why they are omitted.
    """

    angle: Point = field(metadata=_peak("angle", "angle"))
    rate: Point = field(metadata=_peak("rate", "angular rate"))
    acceleration: Point = field(metadata=_peak("acceleration", "angular acceleration", card=False))
    rms_rate: float = field(metadata=spec("angular rate", card=False))
    steady_rate: float = field(metadata=spec("angular rate", card=False))
    window: float = field(metadata=spec("time", "window of the steady rate", card=False))
    travel: float = field(metadata=spec("angle"))
    reversals: int = field(metadata=spec(digits=0))
    time_at_stop: float | None = field(metadata=spec("time", "time at the stop", digits=3))
    work: Work | None = field(metadata=spec())
    notes: tuple[str, ...] = field(metadata=spec())

    def tables(self) -> tuple[Table, ...]:
        """Return the table of the duty, names and values."""
        peaks = {"angle": self.angle, "rate": self.rate, "acceleration": self.acceleration}
        shown = [
            (name, (*line, " at ", *figure(f"duty.{name}_s", peaks[name].time, 2), " s"))
            for name, line in rows(self, "duty", *peaks)
        ]
        shown += rows(self, "duty", "rms_rate", "steady_rate", "window")
        shown += rows(self, "duty", "travel", "reversals", "time_at_stop")
        if self.work is not None:
            names = ("torque", "holding_torque", "rms_torque", "power", "corner_power")
            shown += rows(self.work, "duty", *names, "energy", "returned_energy")
        return (quantities("Duty of the nozzle in the motion", shown),)


def nozzle_duty(
    times: ArrayLike,
    deflection: ArrayLike,
    *,
    limit: float | None = None,
    window: float = WINDOW,
    nozzle: NozzleData | None = None,
    vehicle: Vehicle | None = None,
    angle_of_attack: ArrayLike | None = None,
    attitude: ArrayLike | None = None,
) -> NozzleDuty:
    """Return the duty of a nozzle in a motion, flown or given.

    Parameters
    ----------
    times : array_like
        Times [s], ``(n,)``, three or more, which increase.
    deflection : array_like
        Deflection [rad] at these times, ``(n,)``.
    limit : float, optional
        Deflection limit [rad].
    window : float
        Length [s] over which the steady rate is a mean.
    nozzle : NozzleData, optional
        Engine and hinge, for torque, power and energy.
    vehicle : Vehicle, optional
        A single vehicle, whose thrust and motion add to the torque; without it, on a bench.
    angle_of_attack, attitude : array_like, optional
        Angle of attack and attitude of the flight [rad], ``(n,)``; they need a vehicle.

    Raises
    ------
    InputError
        For times that do not increase, rows of different lengths, a batch, and a flight without a
        vehicle.

    Notes
    -----
    With the axial and the normal acceleration of the hinge [m/s^2]

        a_x = (T - F_A)/m,    a_n = (N alpha + T delta)/m - l_c theta''

    the actuators give the torque [N m], positive as delta,

        M = J_E (delta'' + theta'') + s_E (a_x delta - a_n) + c delta' + k delta
            + M_f sgn(delta') + m_E a_x e + T e_T.

    T, F_A, N alpha are thrust, axial and normal force on the vehicle of mass m, l_c its control
    arm. m_E, s_E, J_E are mass, static moment and inertia of the engine about the hinge; k, c, M_f,
    e, e_T are stiffness, damping, friction and offsets of `NozzleData`.

    Deflections are straight between the times, and accelerations differences of their slopes: a
    deflection that jumps, or kinks, has larger accelerations the closer the times are.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> times = np.linspace(0.0, 1.0, 2001)
    >>> duty = tv.nozzle.nozzle_duty(times, np.radians(1.0) * np.sin(2 * np.pi * 3 * times))
    >>> round(float(np.degrees(duty.rate.value)), 2), round(float(np.degrees(duty.travel)), 2)
    (18.85, 12.0)
    """
    t = errors.times_row("times", times)
    delta = _row("deflection", deflection, t)
    if t.size < 3 or np.any(np.diff(t) <= 0.0):
        raise errors.InputError("times must be three or more, each after the one before")
    if limit is not None:
        limit = errors.number("limit", limit, errors.small_angle("a limit", errors.positive), "rad")
    window = errors.number("window", window, errors.positive, "s")
    notes = []
    if nozzle is not None:
        errors.instance("nozzle", nozzle, NozzleData, "of an engine and its hinge")
    if vehicle is not None:
        errors.instance("vehicle", vehicle, Vehicle, "see load_vehicle")
        errors.single("vehicle", vehicle.batch)
        if attitude is None or angle_of_attack is None:
            notes.append("without angle of attack and attitude the vehicle does not turn")
    elif angle_of_attack is not None or attitude is not None:
        raise errors.InputError("angle_of_attack and attitude need a vehicle")
    zero = np.zeros(t.size)
    alpha = zero if angle_of_attack is None else _row("angle_of_attack", angle_of_attack, t)
    theta = zero if attitude is None else _row("attitude", attitude, t)
    duty = duty_of_motion(Motion.of_samples(t, delta, alpha, theta), limit, window, nozzle, vehicle)
    return duty if nozzle is None else replace(duty, notes=(*notes, *duty.notes))


def duty_of_motion(
    motion: Motion,
    limit: float | None,
    window: float,
    nozzle: NozzleData | None,
    vehicle: Vehicle | None,
) -> NozzleDuty:
    """Return the duty of a nozzle in a motion: angle, rates, travel, reversals, and its torque.

    `motion`: deflection at `times`, its rate at a time `at` in each step, with `weights` [s] of an
    integral. `limit`: deflection limit [rad], for the time at it, or None. `window`: length [s]
    over which the steady rate is a mean. `nozzle`: engine and hinge, None without torque.
    `vehicle`: None on a bench.
    """
    t, delta, rate = motion.times, motion.deflection, motion.rate
    width = min(window, float(t[-1] - t[0]))
    turning = rate[np.abs(rate) > AT_REST * np.abs(rate).max()]  # its changes of sign: reversals
    # The deflection is straight between the times, so that its mean rate over a window is largest
    # where the window begins or ends at one of these.
    begin = np.concatenate([t, t - width])
    begin = begin[(begin >= t[0]) & (begin <= t[-1] - width)]
    steady = (np.interp(begin + width, t, delta) - np.interp(begin, t, delta)) / width
    work, notes = None, [WITHOUT_DATA]
    if nozzle is not None:
        work, notes = work_of(motion, nozzle, vehicle)
    at_stop = None
    if limit is not None:
        at_limit = np.abs(delta) >= limit * (1.0 - _STOP_TOLERANCE)
        at_stop = float(np.diff(t)[at_limit[1:] & at_limit[:-1]].sum())
    return NozzleDuty(
        angle=largest(delta, t),
        rate=largest(rate, motion.at),
        acceleration=motion.peak_acceleration,
        rms_rate=rms(rate, motion.weights),
        steady_rate=float(np.abs(steady).max()),
        window=width,
        travel=float(np.abs(np.diff(delta)).sum()),
        reversals=int(np.count_nonzero(turning[1:] * turning[:-1] < 0.0)),
        time_at_stop=at_stop,
        work=work,
        notes=tuple(notes),
    )


def _row(name: str, values: ArrayLike, t: FloatArray) -> FloatArray:
    """Return angles `values` [rad] at times `t`, ``(n,)``, as an array.

    `InputError` on `name` for another shape, and beyond the range of small angles; an attitude may
    be any angle.
    """
    check = errors.directions if name == "attitude" else errors.small_angle("an angle")
    row = check(name, values, "rad")
    if row.shape != t.shape:
        raise errors.InputError(
            f"{name} must be a row of {t.size} numbers, as times; got {row.shape}"
        )
    return row
