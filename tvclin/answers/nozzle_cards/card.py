"""Duty of a nozzle in a motion: angle, rate, travel, torque, power and energy."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from tvclin.answers.nozzle import NozzleData
from tvclin.answers.nozzle_cards.motion import Motion, largest, rms
from tvclin.answers.nozzle_cards.work import AT_REST, Work, work_of
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.documents import keyed
from tvclin.base.errors import (
    InputError,
    directions,
    instance,
    number,
    positive,
    single,
    small_angle,
    times_row,
)
from tvclin.base.lines import Row, Table, degrees, quantities, significant
from tvclin.base.lines import number as figure
from tvclin.linear.extremes import Point
from tvclin.vehicle.vehicle import Vehicle

_STOP_TOLERANCE = 1e-3
"""Distance from the limit, relative to it, within which a deflection is at the limit."""
WINDOW = 0.5
"""Length [s] of the usual window of a steady rate."""
WITHOUT_DATA = (
    "torque, power and energy need the engine and its hinge: mass_kg, arm_m and more in [nozzle]"
)
"""Note on a card without nozzle data."""


@dataclass(frozen=True)
class NozzleCard(Shown):
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

    angle: Point
    rate: Point
    acceleration: Point
    rms_rate: float
    steady_rate: float
    window: float
    travel: float
    reversals: int
    time_at_stop: float | None
    work: Work | None
    notes: tuple[str, ...]

    as_dict = keyed(
        "angle_deg=angle.value angle_time_s=angle.time rate_deg_per_s=rate.value"
        " rate_time_s=rate.time acceleration_deg_per_s2=acceleration.value"
        " acceleration_time_s=acceleration.time rms_rate_deg_per_s steady_rate_deg_per_s window_s"
        " travel_deg reversals time_at_stop_s work notes"
    )
    _keys = (
        "angle_deg=angle.value rate_deg_per_s=rate.value travel_deg reversals time_at_stop_s work"
        " notes"
    )

    def tables(self) -> tuple[Table, ...]:
        """Return the card as a table of names and values."""

        def peak(point: Point, key: str, unit: str) -> Row:
            time = figure(f"card.{key}_s", point.time, 2)
            return key, (*degrees(f"card.{key}", point.value, unit=unit), " at ", *time, " s")

        rows = [
            peak(self.angle, "angle", "deg"),
            peak(self.rate, "rate", "deg/s"),
            peak(self.acceleration, "acceleration", "deg/s2"),
            ("rms rate", degrees("card.rms_rate", self.rms_rate, unit="deg/s")),
            (
                f"steady rate over {self.window:g} s",
                degrees("card.steady_rate", self.steady_rate, unit="deg/s"),
            ),
            ("travel", degrees("card.travel", self.travel, unit="deg")),
            ("reversals", (str(self.reversals),)),
        ]
        if self.time_at_stop is not None:
            rows.append(
                ("time at the stop", figure("card.time_at_stop_s", self.time_at_stop, unit="s"))
            )
        if self.work is not None:
            for name, value, unit in (
                ("torque, turning", self.work.torque.value, "N m"),
                ("torque, holding", self.work.holding, "N m"),
                ("rms torque", self.work.rms_torque, "N m"),
                ("power", self.work.power.value, "W"),
                ("corner power", self.work.corner_power, "W"),
                ("energy", self.work.energy, "J"),
                ("energy given back", self.work.returned, "J"),
            ):
                rows.append((name, significant(f"card.{name}", value, unit=unit)))
        return (quantities("What the motion asks of the nozzle", rows),)


def nozzle_card(
    times: ArrayLike,
    deflection: ArrayLike,
    *,
    limit: float | None = None,
    window: float = WINDOW,
    nozzle: NozzleData | None = None,
    vehicle: Vehicle | None = None,
    angle_of_attack: ArrayLike | None = None,
    attitude: ArrayLike | None = None,
) -> NozzleCard:
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
    With the axial and the normal acceleration of the hinge

        a_x = (T - F_A)/m,    a_n = (N alpha + T delta)/m - l_c theta''

    the actuators give, positive as delta,

        M = J_E (delta'' + theta'') + s_E (a_x delta - a_n) + c delta' + k delta
            + M_f sgn(delta') + m_E a_x e + T e_T.

    Deflections are straight between the times, and accelerations differences of their slopes: a
    deflection that jumps, or kinks, has larger accelerations the closer the times are.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> times = np.linspace(0.0, 1.0, 2001)
    >>> card = tv.answers.nozzle_card(times, np.radians(1.0) * np.sin(2 * np.pi * 3 * times))
    >>> round(float(np.degrees(card.rate.value)), 2), round(float(np.degrees(card.travel)), 2)
    (18.85, 12.0)
    """
    t = times_row("times", times)
    delta = _row("deflection", deflection, t)
    if t.size < 3 or np.any(np.diff(t) <= 0.0):
        raise InputError("times must be three or more, each after the one before")
    if limit is not None:
        limit = number("limit", limit, small_angle("a limit", positive), "rad")
    window = number("window", window, positive, "s")
    notes = []
    if nozzle is not None:
        instance("nozzle", nozzle, NozzleData, "of an engine and its hinge")
    if vehicle is not None:
        instance("vehicle", vehicle, Vehicle, "see load_vehicle")
        single("vehicle", vehicle.batch)
        if attitude is None or angle_of_attack is None:
            notes.append("without angle of attack and attitude the vehicle does not turn")
    elif angle_of_attack is not None or attitude is not None:
        raise InputError("angle_of_attack and attitude need a vehicle")
    zero = np.zeros(t.size)
    alpha = zero if angle_of_attack is None else _row("angle_of_attack", angle_of_attack, t)
    theta = zero if attitude is None else _row("attitude", attitude, t)
    card = card_of(Motion.of_samples(t, delta, alpha, theta), limit, window, nozzle, vehicle)
    return card if nozzle is None else replace(card, notes=(*notes, *card.notes))


def card_of(
    motion: Motion,
    limit: float | None,
    window: float,
    nozzle: NozzleData | None,
    vehicle: Vehicle | None,
) -> NozzleCard:
    """Return the duty of a nozzle in a motion; same parameters as of `nozzle_card`."""
    t, delta, rate, steps = motion.times, motion.deflection, motion.rate, motion.steps
    width = min(window, float(t[-1] - t[0]))
    turning = rate[np.abs(rate) > AT_REST * np.abs(rate).max()]
    begin = np.concatenate([t, t - width])
    begin = begin[(begin >= t[0]) & (begin <= t[-1] - width)]
    steady = (np.interp(begin + width, t, delta) - np.interp(begin, t, delta)) / width
    work, notes = None, [WITHOUT_DATA]
    if nozzle is not None:
        work, notes = work_of(motion, nozzle, vehicle)
    at_stop = None
    if limit is not None:
        near = np.abs(delta) >= limit * (1.0 - _STOP_TOLERANCE)
        at_stop = float(steps[near[1:] & near[:-1]].sum())
    return NozzleCard(
        angle=largest(delta, t),
        rate=largest(rate, motion.at),
        acceleration=motion.sharpest,
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
    """Return angles [rad] at the times `t`, ``(n,)``; `InputError` for another shape or size."""
    row = (directions if name == "attitude" else small_angle("an angle"))(name, values, "rad")
    if row.shape != t.shape:
        raise InputError(f"{name} must be a row of {t.size} numbers, as times; got {row.shape}")
    return row
