"""Duty of a nozzle in a motion, and its comparison with the data sheet.

Duty is angle, rate, travel, torque, power and energy; the data sheet says what a nozzle offers.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown, table
from tvclin.base.fields import Field, chosen, derived, record_table, rows, spec, specs
from tvclin.base.lines import Table, quantities
from tvclin.base.lines import number as figure
from tvclin.base.quantities import satisfaction, survival
from tvclin.base.units import written
from tvclin.case.nozzle import Nozzle, NozzleData
from tvclin.linear.extremes import Point
from tvclin.nozzle.motion import AT_REST, Motion, Work, largest, rms, work_of
from tvclin.vehicle.vehicle import Vehicle

_STOP_TOLERANCE = 1e-3
"""Distance from the limit, relative to it, within which a deflection is at the limit."""
WINDOW = 0.5
"""Length [s] of the usual window of a steady rate."""
WITHOUT_DATA = (
    "torque, power and energy need the engine and its hinge: mass_kg, arm_m and more in [nozzle]"
)
"""Note on a duty without nozzle data."""


_WORK = (
    *("torque", "holding_torque", "rms_torque", "power", "corner_power"),
    *("energy", "returned_energy"),
)
"""Fields of torque, power and energy in the table of a motion."""


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

    angle: Point = field(
        metadata=specs(
            Field(kind="angle", of="angle.value"),
            Field(kind="time", name="angle_time", of="angle.time", card=False),
        )
    )
    rate: Point = field(
        metadata=specs(
            Field(kind="angular rate", of="rate.value"),
            Field(kind="time", name="rate_time", of="rate.time", card=False),
        )
    )
    acceleration: Point = field(
        metadata=specs(
            Field(kind="angular acceleration", of="acceleration.value", card=False),
            Field(kind="time", name="acceleration_time", of="acceleration.time", card=False),
        )
    )
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
        names = ("rms_rate", "steady_rate", "window", "travel", "reversals", "time_at_stop")
        shown += rows(self, "duty", *names)
        if self.work is not None:
            shown += rows(self.work, "duty", *_WORK)
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
    """Return the duty of a nozzle in a motion; parameters as in `nozzle_duty`.

    `limit`: deflection limit [rad] or None. `window`: length [s] of the mean of the steady rate.
    `nozzle`: engine and hinge, None without torque. `vehicle`: None on a bench.
    """
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
        at_limit = np.abs(delta) >= limit * (1.0 - _STOP_TOLERANCE)
        at_stop = float(steps[at_limit[1:] & at_limit[:-1]].sum())
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
    """Return angles `values` [rad] at times `t`, ``(n,)``; `InputError` on `name` for others."""
    row = (errors.directions if name == "attitude" else errors.small_angle("an angle"))(
        name, values, "rad"
    )
    if row.shape != t.shape:
        raise errors.InputError(
            f"{name} must be a row of {t.size} numbers, as times; got {row.shape}"
        )
    return row


_RELATIVE_TOLERANCE = 1e-12
"""Excess of a requirement, relative to what is available, that counts as rounding."""


def requirements_on_nozzle(
    nozzle: Nozzle, duties: Sequence[NozzleDuty], travel: float
) -> dict[str, float]:
    """Return the requirements of motions on a nozzle [SI], by the names of its limits.

    `duties`: one for each motion. `travel`: travel of the whole flight [rad]. Flights keep to the
    rate limit of `nozzle`, which an actuator of second order may exceed by a thousandth.
    """
    rate = max((abs(duty.rate.value) for duty in duties), default=0.0)
    required = {
        "limit": max((abs(duty.angle.value) for duty in duties), default=0.0),
        "rate_limit": min(rate, nozzle.rate_limit or np.inf),
        "acceleration_limit": max((abs(duty.acceleration.value) for duty in duties), default=0.0),
        "travel_limit": travel,
    }
    work = [duty.work for duty in duties if duty.work is not None]
    if nozzle.data is not None:
        holding = (w.holding + nozzle.data.friction for w in work)
        required["torque_limit"] = max([0.0, *holding, *(abs(w.torque.value) for w in work)])
        required["power_limit"] = max((w.power.value for w in work), default=0.0)
    return required


@dataclass(frozen=True)
class DataSheetLine(Shown):
    """A line of a data sheet: the required value and the available value, in `unit`.

    `required`: value that the flights use within the limits, at least the lower bound; infinite
    where no value is sufficient, NaN where it is not known. `available`: the value that the nozzle
    offers; None where the data sheet has none.
    """

    name: str = field(metadata=spec())
    unit: str = field(metadata=spec())
    required: float = field(metadata=spec(label="used"))
    available: float | None = field(metadata=spec())

    @property
    @derived(infinite="-")
    def remaining(self) -> float | None:
        """Remaining margin, available minus required; negative where the nozzle is insufficient."""
        if self.available is None:
            return None
        margin = self.available - self.required
        return max(margin, 0.0) if self.satisfied else margin  # negative by rounding only

    @property
    @derived()
    def satisfied(self) -> bool | None:
        """Whether the available value is sufficient; None where either value is not known."""
        if self.available is None or np.isnan(self.required):
            return None
        return bool(self.required <= self.available * (1.0 + _RELATIVE_TOLERANCE))

    @property
    def ratio(self) -> float:
        """Ratio of the required to the available value; -1 without an available value."""
        return (
            -1.0 if self.available is None else float(np.nan_to_num(self.required / self.available))
        )


@dataclass(frozen=True)
class NozzleVerdict(Shown):
    """Verdict on a nozzle by the lines of its data sheet, the largest required fraction first.

    `diverged`: flights that are not survived, in words. `unknown`: flights and winds that cannot be
    judged, with the reason and a remedy, in words.
    """

    lines: tuple[DataSheetLine, ...] = field(metadata=spec(card=False))
    diverged: tuple[str, ...] = field(default=(), metadata=spec())
    unknown: tuple[str, ...] = field(default=(), metadata=spec())

    @classmethod
    def of(
        cls,
        nozzle: Nozzle,
        required: dict[str, float],
        diverged: Iterable[str] = (),
        unknown: Iterable[str] = (),
    ) -> Self:
        """Return the verdict on a nozzle with requirements [SI] by the names of its limits.

        `diverged`, `unknown`: flights that are lost, and what cannot be judged, in words. Where a
        flight diverges with the available values, the required values are not known.
        """
        lines, diverged = [], tuple(diverged)
        for item in chosen(nozzle, *required):
            minimum, available = item.in_document_unit(required[item.name]), item.value(nozzle)
            if diverged and minimum <= (available or 0.0):
                minimum = np.nan
            lines.append(DataSheetLine(item.title, written(item.suffix), minimum, available))
        return cls(tuple(sorted(lines, key=lambda line: -line.ratio)), diverged, tuple(unknown))

    @classmethod
    def unknown_of(cls, nozzle: Nozzle, unknown: Iterable[str]) -> Self:
        """Return the verdict on a nozzle with unknown requirements, for reasons in words."""
        return cls.of(
            nozzle, dict.fromkeys(requirements_on_nozzle(nozzle, (), np.nan), np.nan), (), unknown
        )

    @property
    @derived(card=False)
    def satisfied(self) -> bool | None:
        """Whether all flights are survived and all lines satisfied; None where not known."""
        answers = [line.satisfied for line in self.lines if line.available is not None]
        if self.diverged or False in answers:
            return False
        return None if not answers or None in answers or self.unknown else True

    @property
    def reason(self) -> str:
        """The reason of the verdict, in words: a flight, a wind, or the worst line."""
        if self.diverged:
            others = len(self.diverged) - 1
            return f"{self.diverged[0]}{f', and {others} more' if others else ''}"
        if self.unknown and self.satisfied is None:
            return "; ".join(self.unknown)
        worst = next((line for line in self.lines if line.available is not None), None)
        if worst is None or self.satisfied is None:
            return ""
        if np.isinf(worst.required):
            return f"no {worst.name} is sufficient"
        required, available = (
            f"{x:.4g} {worst.unit}" for x in (worst.required, worst.available or 0.0)
        )
        return f"{worst.name} used {required}, available {available}"

    @property
    @derived(label="verdict")
    def words(self) -> str:
        """The verdict in a sentence, with its reason."""
        specified = any(line.available is not None for line in self.lines)
        if not (specified or self.diverged or self.unknown):
            return "nothing is judged; give a limit and a rate limit"
        word = survival(False) if self.diverged else satisfaction(self.satisfied)
        return f"{word}: {self.reason}" if self.reason else word

    def _repr_html_(self) -> str:
        """Return the lines of the data sheet and the verdict for a notebook."""
        return "".join(table(lines, ((self.words,),)) for lines in self.tables())

    def tables(self) -> tuple[Table, ...]:
        """Return the table of used, available and remaining values."""
        caption = "Requirements on the nozzle" + ", where that is known" * bool(self.unknown)
        labels = ("", (f"{line.name} [{line.unit}]" for line in self.lines))
        names = ("required", "available", "remaining")
        return (record_table(caption, "sheet", self.lines, *names, labels=labels),)
