"""What a motion asks of the nozzle that makes it: angle, rate, travel, torque, power and energy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.answers.case import Case
from tvclin.answers.nozzle import NozzleData
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
from tvclin.control.laws.law import Law
from tvclin.control.laws.registry import design_notes
from tvclin.flights.closed_loop.fly import fly
from tvclin.flights.closed_loop.many import LOST, SURVIVED, fly_many
from tvclin.flights.flexible import FATES
from tvclin.linear.extremes import Point
from tvclin.vehicle.linear_vehicle import whole_vehicle
from tvclin.vehicle.vehicle import Vehicle

FloatArray = NDArray[np.float64]

_AT_STOP = 1e-3
"""A deflection so near to the limit, relative, is at the stop."""
_AT_REST = 1e-6
"""A rate below this part of the largest is none."""
_WINDOW = 0.5
_AFTER = 15.0
"""A flight is shown so many times of its fast mode after the wind: what moves then is rounding."""
_IN_A_SAMPLE, _MOST = 8, 400_001
"""Times of a card in a sample of the law, and in all."""


@dataclass(frozen=True)
class Work(Shown):
    """What the actuators give.

    Attributes
    ----------
    torque : Point
        Largest torque [N m] while the nozzle turns, with friction.
    holding : float
        Largest torque [N m] at rest, to which friction adds or takes up to M_f.
    rms_torque : float
        Root of the mean square [N m], holding included.
    power : Point
        Largest power [W] that is given.
    energy : float
        Energy [J] that is given; what the nozzle gives back is not taken off.
    returned : float
        Energy [J] that the nozzle gives back.
    corner_power : float
        Largest torque times largest rate [W], never below the largest power.
    stiffness : float
        k + s_E a_x [N m/rad] at the least; below zero the nozzle turns away by itself.
    """

    torque: Point
    holding: float
    rms_torque: float
    power: Point
    energy: float
    returned: float
    corner_power: float
    stiffness: float

    as_dict = keyed(
        "torque_N_m=torque.value torque_time_s=torque.time holding_torque_N_m=holding"
        " rms_torque_N_m=rms_torque power_W=power.value power_time_s=power.time"
        " corner_power_W=corner_power energy_J=energy returned_energy_J=returned"
    )


@dataclass(frozen=True)
class NozzleCard(Shown):
    """What a motion of the nozzle asks of it; peaks with their signs and times.

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
        Its length [s].
    travel : float
        Integral of ``|delta'|`` [rad].
    reversals : int
        How often the rate changes its sign.
    time_at_stop : float or None
        Time [s] within a thousandth of the limit; None without one.
    work : Work or None
        Torque, power and energy, where nozzle data are given.
    notes : tuple of str
        What is left out, and why.
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

        def at(point: Point, key: str, unit: str) -> Row:
            when = figure(f"card.{key}_s", point.time, 2)
            return key, (*degrees(f"card.{key}", point.value, unit=unit), " at ", *when, " s")

        rows = [
            at(self.angle, "angle", "deg"),
            at(self.rate, "rate", "deg/s"),
            at(self.acceleration, "acceleration", "deg/s2"),
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
    window: float = _WINDOW,
    nozzle: NozzleData | None = None,
    vehicle: Vehicle | None = None,
    angle_of_attack: ArrayLike | None = None,
    attitude: ArrayLike | None = None,
) -> NozzleCard:
    """Return what a motion of the nozzle, flown or given, asks of it.

    Parameters
    ----------
    times : array_like
        Times [s], ``(n,)``, three or more, which increase.
    deflection : array_like
        Deflection [rad] at these, ``(n,)``.
    limit : float, optional
        The stop [rad].
    window : float
        Length [s] over which the steady rate is a mean.
    nozzle : NozzleData, optional
        For torque, power and energy.
    vehicle : Vehicle, optional
        One vehicle, for what its thrust and its motion add to the torque; on a bench without.
    angle_of_attack, attitude : array_like, optional
        Of the flight [rad], ``(n,)``; they need a vehicle.

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
    deflection that jumps, or kinks, has larger ones the closer the times are.

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
    stop = (
        None if limit is None else number("limit", limit, small_angle("a limit", positive), "rad")
    )
    width = min(number("window", window, positive, "s"), float(t[-1] - t[0]))
    steps, middle = np.diff(t), (t[1:] + t[:-1]) / 2.0
    rate = np.diff(delta) / steps
    turning = rate[np.abs(rate) > _AT_REST * np.abs(rate).max()]
    begin = np.concatenate([t, t - width])
    begin = begin[(begin >= t[0]) & (begin <= t[-1] - width)]
    steady = (np.interp(begin + width, t, delta) - np.interp(begin, t, delta)) / width
    notes = []
    work = None
    if nozzle is None:
        notes.append(
            "torque, power and energy need the engine and its hinge: mass_kg, arm_m and more in"
            " [nozzle]"
        )
    else:
        instance("nozzle", nozzle, NozzleData, "of an engine and its hinge")
        work, notes = _work(t, delta, nozzle, vehicle, angle_of_attack, attitude)
    at_stop = None
    if stop is not None:
        near = np.abs(delta) >= stop * (1.0 - _AT_STOP)
        at_stop = float(steps[near[1:] & near[:-1]].sum())
    return NozzleCard(
        angle=_largest(delta, t),
        rate=_largest(rate, middle),
        acceleration=_largest(_bends(t, delta), t[1:-1]),
        rms_rate=_rms(rate, steps),
        steady_rate=float(np.abs(steady).max()),
        window=width,
        travel=float(np.abs(np.diff(delta)).sum()),
        reversals=int(np.count_nonzero(turning[1:] * turning[:-1] < 0.0)),
        time_at_stop=at_stop,
        work=work,
        notes=tuple(notes),
    )


@dataclass(frozen=True)
class FlownCard(Shown):
    """What a law's flight asks of the nozzle.

    Attributes
    ----------
    law, status : str
        The name of the law, and what became of its flight, as of `fly_many`.
    card : NozzleCard or None
        Until 15 times the fast mode's time after the wind; None of a flight that is lost.
    notes : tuple of str
        Of the design of the law, and of what is left out of the card.
    """

    law: str
    status: str
    card: NozzleCard | None
    notes: tuple[str, ...]

    as_dict = keyed("law status card")

    @classmethod
    def of(cls, case: Case, name: str, law: Law) -> Self:
        """Return the card of a law in the wind of a case, with its nozzle, which has a limit."""
        plant, wind, limit = case.plant, case.history, case.nozzle.limit
        flown = {"deflection_limit": limit, **case.hardware}
        status, said = str(fly_many(plant, law, wind, **flown).status), tuple(design_notes(law))
        if status == LOST:
            return cls(name, status, None, said)
        onset, end = float(wind.onset), float(wind.end) + _AFTER / float(plant.coefficients.pole)
        count = int(np.ceil((end - onset) * flown["sample_rate"])) * _IN_A_SAMPLE + 1
        times = np.linspace(onset, end, min(count, _MOST))
        outputs = fly(plant, law, wind, times, **flown).outputs
        beside: dict[str, Any] = {}
        if (data := case.nozzle.data) is not None:
            vehicle = whole_vehicle(case.vehicle, "the torque of a nozzle").rigid
            moves = {key: outputs[key] for key in ("angle_of_attack", "attitude")}
            beside = {"nozzle": data, "vehicle": vehicle, **moves}
        card = nozzle_card(times, outputs["deflection"], limit=limit, **beside)
        return cls(name, status, card, said + card.notes)

    @property
    def survived(self) -> bool:
        """Whether the flight is survived."""
        return self.status == SURVIVED

    @property
    def words(self) -> str:
        """What becomes of the flight, in words."""
        return f"{self.law} {FATES[self.status]} with this limit and rate"

    def tables(self) -> tuple[Table, ...]:
        """Return the card; nothing of a flight that is lost."""
        return () if self.card is None else self.card.tables()


def _work(
    t: FloatArray,
    delta: FloatArray,
    nozzle: NozzleData,
    vehicle: Vehicle | None,
    angle_of_attack: ArrayLike | None,
    attitude: ArrayLike | None,
) -> tuple[Work, list[str]]:
    """Torque, power and energy, in the middle between two times; and what is left out of them."""
    engine, steps, middle = nozzle.engine, np.diff(t), (t[1:] + t[:-1]) / 2.0
    inertia, moment = float(engine.inertia_about_gimbal), float(engine.static_moment)
    angle, rate, bend = _middle(delta), np.diff(delta) / steps, _middle(_at_all(t, delta))
    stiffness, steady, felt = nozzle.stiffness, 0.0, np.zeros(rate.size)
    notes = []
    if vehicle is None:
        if angle_of_attack is not None or attitude is not None:
            raise InputError("angle_of_attack and attitude need a vehicle")
        notes.append("without a vehicle the torque is that on a bench: no thrust, no acceleration")
    else:
        instance("vehicle", vehicle, Vehicle, "see load_vehicle")
        single("vehicle", vehicle.batch)
        if attitude is None or angle_of_attack is None:
            notes.append("without angle of attack and attitude the vehicle does not turn")
        alpha = np.zeros(t.size) if angle_of_attack is None else angle_of_attack
        turned = np.zeros(t.size) if attitude is None else attitude
        swing = _middle(_at_all(t, _row("attitude", turned, t)))
        mass, thrust = float(vehicle.mass), float(vehicle.thrust)
        ahead = (thrust - float(vehicle.axial_force)) / mass
        force = float(vehicle.normal_force_slope) * _middle(_row("angle_of_attack", alpha, t))
        aside = (force + thrust * angle) / mass - float(vehicle.control_arm) * swing
        felt = inertia * swing - moment * aside
        stiffness += moment * ahead
        steady = float(engine.mass) * ahead * nozzle.offset + thrust * nozzle.thrust_offset
        if stiffness < 0.0:
            notes.append("k + s_E a_x is negative: the nozzle turns away by itself")
    held = inertia * bend + stiffness * angle + steady + felt
    moves = np.abs(rate) > _AT_REST * np.abs(rate).max()
    torque = held + nozzle.damping * rate + np.where(moves, nozzle.friction * np.sign(rate), 0.0)
    power = torque * rate
    turning, resting = np.where(moves, torque, 0.0), np.where(moves, 0.0, np.abs(torque))
    largest = _largest(turning, middle)
    given = int(np.argmax(power))
    return (
        Work(
            torque=largest,
            holding=float(resting.max()),
            rms_torque=_rms(torque, steps),
            power=Point(max(float(power[given]), 0.0), float(middle[given])),
            energy=float((np.maximum(power, 0.0) * steps).sum()),
            returned=float((np.maximum(-power, 0.0) * steps).sum()),
            corner_power=abs(largest.value) * float(np.abs(rate).max()),
            stiffness=stiffness,
        ),
        notes,
    )


def _row(name: str, values: ArrayLike, t: FloatArray) -> FloatArray:
    row = (directions if name == "attitude" else small_angle("an angle"))(name, values, "rad")
    if row.shape != t.shape:
        raise InputError(f"{name} must be a row of {t.size} numbers, as times; got {row.shape}")
    return row


def _bends(t: FloatArray, values: FloatArray) -> FloatArray:
    """Second derivative at the inner times: the change of slope over half of both steps."""
    return np.diff(np.diff(values) / np.diff(t)) / ((t[2:] - t[:-2]) / 2.0)


def _at_all(t: FloatArray, values: FloatArray) -> FloatArray:
    """The same at all times."""
    return np.pad(_bends(t, values), 1, mode="edge")


def _middle(values: FloatArray) -> FloatArray:
    return (values[1:] + values[:-1]) / 2.0


def _rms(values: FloatArray, steps: FloatArray) -> float:
    return float(np.sqrt(np.average(values**2, weights=steps)))


def _largest(values: FloatArray, times: FloatArray) -> Point:
    """The value of largest size, with its sign, and its time."""
    k = int(np.argmax(np.abs(values)))
    return Point(float(values[k]), float(times[k]))
