"""Data sheet of a nozzle and its verdict, and the duty over a flight: by time and wind, and tables.

The data sheet says what a nozzle offers; a verdict compares it with the duty of motions.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any, Self

import numpy as np

from tvclin.ascent.measured_wind import MeasuredPlanes, MeasuredWind, hundredths
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown, table
from tvclin.base.fields import (
    Field,
    chosen,
    derived,
    document,
    fields_of,
    record_table,
    spec,
    specs,
)
from tvclin.base.files import write_rows
from tvclin.base.lines import Line, Table
from tvclin.base.quantities import satisfaction, survival
from tvclin.base.units import written
from tvclin.case.nozzle import Nozzle
from tvclin.flights.closed_loop.fly_many import NO_FLIGHT, SURVIVED, UNDECIDED
from tvclin.flights.closed_loop.outcomes import decidable
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.modes import select_unstable
from tvclin.nozzle.duty import NozzleDuty, Work
from tvclin.requirement.flight.flight_turbulence import FlightTurbulence
from tvclin.requirement.flight.sizing import flight_times
from tvclin.vehicle.linear_vehicle import FIXED_PATH

_RELATIVE_TOLERANCE = 1e-12
"""Excess of a requirement, relative to what is available, that counts as rounding."""
_USED = {"limit": "deflection", "rate_limit": "deflection rate"}
"""What a nozzle uses of these limits, by their names; of others the label of the limit says it."""


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
        """Ratio of the required to the available value, for sorting.

        -1 without an available value, and zero for a requirement that is not known.
        """
        if self.available is None:
            return -1.0
        return float(np.nan_to_num(self.required / self.available))


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
        flight diverges with the available values, the required values are not known, unless one is
        above what is available without that flight. Values are in the units of documents.
        """
        lines, diverged = [], tuple(diverged)
        for item in chosen(nozzle, *required):
            minimum, available = item.in_document_unit(required[item.name]), item.value(nozzle)
            if diverged and minimum <= (available or 0.0):
                minimum = np.nan
            name, unit = _USED.get(item.name, item.title), written(item.suffix)
            lines.append(DataSheetLine(name, unit, required=minimum, available=available))
        return cls(tuple(sorted(lines, key=lambda line: -line.ratio)), diverged, tuple(unknown))

    @classmethod
    def unknown_of(cls, nozzle: Nozzle, unknown: Iterable[str]) -> Self:
        """Return the verdict on a nozzle with unknown requirements, for reasons in words."""
        names = requirements_on_nozzle(nozzle, duties=(), travel=np.nan)
        return cls.of(nozzle, required=dict.fromkeys(names, np.nan), unknown=unknown)

    @property
    @derived(card=False)
    def satisfied(self) -> bool | None:
        """Whether all flights are survived and all lines satisfied; None where not known.

        Lines count where the data sheet has a value; without any it is not known.
        """
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
        # lines are sorted, the largest required fraction of what is available first
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
        """The verdict with its reason: NOT SURVIVED for a lost flight, else whether it is MET."""
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


@dataclass(frozen=True, eq=False)
class DutyPoint(Shown):
    """Duty of a nozzle at a flight time [s] in a wind, in a plane.

    `wind`: its name, with its direction along the path where that matters. `limit`: the deflection
    limit of this plane [rad]. `minimum`: minimum angle [rad] in a known wind, without a rate limit.
    `pole`: the fast unstable pole [1/s]; zero without an unstable pole, NaN for a
    complex pair. `status`: outcome of the flight, see `fly_many`; empty where nothing is flown.
    `reason`: the reason where the flight cannot be judged. `duty`: the flight's; None where it is
    lost or cannot be judged. `law_notes`: notes on the design of the law. `without_noise`:
    travel [rad] and energy [J] of the flight without the share of noise. `noise_rate`: travel and
    energy of noise per time [rad/s, W]. `direction`: head or tail, for a pulse whose dynamic
    pressure depends on it.
    """

    time: float = field(metadata=spec("time"))
    wind: str = field(metadata=spec())
    plane: str = field(metadata=spec())
    limit: float
    minimum: float = field(default=0.0, metadata=spec("angle", name="minimum_angle"))
    pole: float = 0.0
    status: str = field(default="", metadata=spec())
    reason: str = field(default="", metadata=spec())
    duty: NozzleDuty | None = None
    law_notes: tuple[str, ...] = ()
    without_noise: FloatArray = field(default_factory=lambda: np.zeros(2))
    noise_rate: FloatArray = field(default_factory=lambda: np.zeros(2))
    direction: str = ""

    @property
    @derived("angular rate")
    def minimum_rate(self) -> float:
        """The deflection rate p d0 [rad/s] that must be exceeded at any angle.

        p: fast unstable pole [1/s]. d0: minimum angle [rad] in the known wind.
        """
        return self.pole * self.minimum

    @property
    @derived("angular acceleration")
    def minimum_acceleration(self) -> float:
        """The acceleration p^2 d0 [rad/s2] that must be exceeded, as `minimum_rate` p d0."""
        return self.pole**2 * self.minimum

    @property
    def diverged(self) -> bool:
        """Whether the flight is known not to survive: it was flown, and can be judged."""
        return self.status not in ("", SURVIVED) and not self.reason

    @property
    def numbers(self) -> dict[str, float]:
        """Magnitudes of the nozzle's minima and of its duty, by keys such as "angle_deg".

        Minima are the deflection, rate and acceleration that any law requires at least in the wind.
        """
        numbers = document(self, "minimum_angle", "minimum_rate", "minimum_acceleration")
        if (duty := self.duty) is not None:
            names = ("angle", "rate", "steady_rate", "acceleration")
            numbers |= document(duty, *names, "travel", "reversals", "time_at_stop")
            if duty.work is not None:
                names = ("torque", "holding_torque", "rms_torque", "power")
                numbers |= document(duty.work, *names, "energy")
        return {key: abs(float(value)) for key, value in numbers.items()}

    def as_dict(self) -> dict[str, Any]:
        """Return the point for JSON, angles in degrees."""
        return document(self) | self.numbers


_FIELDS = {
    item.document_key: item for kind in (Work, NozzleDuty, DutyPoint) for item in fields_of(kind)
}
"""Fields of all numbers, by key."""


@dataclass(frozen=True)
class WindDuty(Shown):
    """Travel and energy of a nozzle in a whole flight in a wind.

    `travel`: integral of ``|delta'|`` [rad]; NaN where a flight is lost or cannot be judged.
    `energy`: work of the actuators [J]; NaN without nozzle data.
    """

    wind: str = field(metadata=spec())
    plane: str = field(metadata=spec())
    travel: float = field(metadata=spec("angle"))
    energy: float = field(metadata=spec("energy"))


@dataclass(frozen=True, eq=False)
class FlightDuty(Shown):
    """Duty of a nozzle over a whole flight; make it with `flight_duty`.

    Attributes
    ----------
    vehicle, law : str
        Names of vehicle and law.
    points : tuple of DutyPoint
        Duty by flight time and wind.
    duties : tuple of WindDuty
        Travel and energy of the whole flight by wind; a flight has one of these winds.
    verdict : NozzleVerdict
        Requirements, what the data sheet offers, and what remains.
    notes : tuple of str
        Omitted terms, and how the whole flight is counted.
    turbulence : FlightTurbulence or None
        The autopilot in turbulence along the flight; None where it is not counted.
    """

    vehicle: str = field(metadata=spec())
    law: str = field(metadata=spec())
    points: tuple[DutyPoint, ...] = field(metadata=spec(card=False))
    duties: tuple[WindDuty, ...] = field(metadata=spec(card=False))
    verdict: NozzleVerdict = field(
        metadata=specs(Field(card=False), Field(of="verdict.words", document=False))
    )
    notes: tuple[str, ...] = field(metadata=spec(card=False))
    turbulence: FlightTurbulence | None = field(default=None, metadata=spec(card=False))

    def _repr_html_(self) -> str:
        """Return verdict and tables for a notebook."""
        first, *rest = self.tables()
        return table(first, ((self.verdict.words,),)) + "".join(map(table, rest))

    @property
    @derived()
    def largest(self) -> dict[str, float]:
        """The largest of each quantity over the flight, by keys with their units."""
        return {key: point.numbers[key] for key, point in self._worst().items()}

    def tables(self) -> tuple[Table, ...]:
        """Return the verdict, the largest of each quantity, and the largest at each time."""
        random = [] if self.turbulence is None else self.turbulence.duty_tables()
        return (*self.verdict.tables(), self._flight_table(), *random, *self._time_tables())

    def to_csv(self, path: Path | None = None) -> str:
        """Return a line for each flight as CSV, and write it where a path is given.

        Raises
        ------
        InputError
            When the file cannot be written.
        """
        keys = list(dict.fromkeys(chain.from_iterable(point.numbers for point in self.points)))
        rows = [
            [point.time, point.wind, point.plane, point.status]
            + [float(point.numbers.get(key, np.nan)) for key in keys]
            + [point.reason]
            for point in self.points
        ]
        return write_rows([["time_s", "wind", "plane", "status", *keys, "reason"], *rows], path)

    def _worst(self) -> dict[str, DutyPoint]:
        """Return the point with the largest value of each number, by key.

        Points are flights at a time and in a wind. Numbers are angles, rates, travel, ... of the
        nozzle, zero or more; a missing number counts as -1, which is never the largest.
        """
        numbers = [point.numbers for point in self.points]
        worst = {}
        for key in dict.fromkeys(chain.from_iterable(numbers)):
            values = np.nan_to_num([row.get(key, -1.0) for row in numbers], nan=-1.0)
            worst[key] = self.points[int(np.argmax(values))]
        return worst

    def _flight_table(self) -> Table:
        """Return the table of the largest numbers, with their times and winds."""
        planes = len({point.plane for point in self.points}) > 1

        def where(item: DutyPoint | WindDuty) -> Line:
            """Return the wind of a point or a sum, with its plane if there are several `planes`."""
            return (f"{item.wind}, {item.plane}" if planes else item.wind,)

        rows: list[tuple[Line, ...]] = []
        for key, point in self._worst().items():
            value = _FIELDS[key].cell(f"duty.{key}", point.numbers[key])
            label = _FIELDS[key].heading
            rows.append(((label,), value, (f"{point.time:.6g}",), where(point)))
        for key in ("travel_deg", "energy_J"):
            sums = [duty.as_dict()[key] for duty in self.duties]
            if np.isfinite(sums).any():
                item, k = _FIELDS[key], int(np.nanargmax(sums))
                value = item.cell(f"duty.whole.{key}", sums[k])
                label = f"{item.title} of the whole flight [{item.unit}]"
                rows.append(((label,), value, ("",), where(self.duties[k])))
        head = ("", "largest", "at [s]", "in the wind")
        return Table(f"The nozzle over the flight, {self.law} flown", head, tuple(rows))

    def _time_tables(self) -> Iterator[Table]:
        """Yield tables of the largest numbers of all winds, a row for each flight time."""
        times = sorted({point.time for point in self.points})
        minima = ("minimum_angle_deg", "minimum_rate_deg_per_s")
        peaks = ("angle_deg", "rate_deg_per_s", "acceleration_deg_per_s2")
        for caption, keys in (
            ("By flight time, the largest of all winds", (*minima, *peaks, "travel_deg")),
            ("Torque, power and energy by flight time", ("torque_N_m", "power_W", "energy_J")),
        ):
            available = [key for key in keys if key in self.largest]
            if not available:
                continue
            rows = []
            for time in times:
                numbers = [point.numbers for point in self.points if point.time == time]
                largest = {
                    key: float(np.fmax.reduce([row.get(key, np.nan) for row in numbers]))
                    for key in available
                }
                cells = (_FIELDS[k].cell(f"duty.{time:g}.{k}", largest[k]) for k in available)
                rows.append(((f"{time:.6g}",), *cells))
            heads = [_FIELDS[key].heading for key in available]
            yield Table(caption, ("time [s]", *heads), tuple(rows))


_PAIR = "two unstable poles are a pair, for which no test of loss is known"
"""Reason for a complex pair of unstable poles."""


def flight_reason(plant: AnyPlant, status: str) -> str:
    """Return the reason why the flight of a plant cannot be judged; empty if it can.

    `status`: outcome of the flight, one of `fly_many`.
    """
    if status == UNDECIDED:
        return "the flight has neither diverged nor settled at its end"
    if status != NO_FLIGHT:
        return ""
    if decidable(plant):  # a test of loss is known for its poles
        return "the wind lasts for more than a million samples"
    poles = select_unstable(plant.poles)
    poles = poles[~np.isnan(poles)]
    if np.iscomplexobj(poles) and np.any(np.imag(poles) != 0.0):
        return _PAIR
    return f"a test of loss is known for one or two unstable poles, and the plant has {poles.size}"


def unjudged_flights(law: str, points: Iterable[DutyPoint], model: str) -> Iterator[str]:
    """Yield notes on flights of a law that cannot be judged: times, winds, reason and options.

    `law`: its name. `points`: all flights. `model`: name of the model of the plants.
    """
    rows = list(points)
    reasons: dict[str, list[DutyPoint]] = {}
    for point in rows:
        if point.reason:
            reasons.setdefault(point.reason, []).append(point)
    unjudged = {point.time for affected in reasons.values() for point in affected}
    judged = {point.time for point in rows} - unjudged
    for reason, affected in reasons.items():
        remedies = []
        if judged and max(unjudged) < min(judged):
            remedies.append(f"--from {min(judged):.6g} omits these times")
        elif judged and min(unjudged) > max(judged):
            remedies.append(f"--to {max(judged):.6g} omits these times")
        if reason == _PAIR and model != FIXED_PATH:  # without drift there is no pair
            remedies.append(f"--model {FIXED_PATH} judges them without drift")
        winds = list(dict.fromkeys(point.wind for point in affected))
        where = winds[0] if len(winds) == 1 else f"{len(winds)} winds"
        remedy = f" ({', '.join(remedies)})" if remedies else ""
        times = flight_times({point.time for point in affected})
        yield f"the flight of {law} at {times} in {where}: {reason}{remedy}"


def unknown_winds(
    schedule: FlightSchedule, winds: Mapping[str, Any], unknown: Mapping[str, dict[float, str]]
) -> Iterator[str]:
    """Yield notes on winds that are not known at some heights, and options that omit these.

    `schedule`: the flight. `winds`: by name. `unknown`: by wind, the flight times [s] at which it
    is not known, with the reason; an empty reason for the end of a sounding.
    """
    for name, times in unknown.items():
        wind = winds[name]
        if isinstance(wind, MeasuredWind | MeasuredPlanes):
            first, last = wind.known
            early, late = min(times) < first, max(times) > last
            if early:
                yield (
                    f"{name} is not known below {schedule.altitude_text(first)}:"
                    f" --from {hundredths(first, up=True)} begins there"
                )
            if late:
                yield (
                    f"{name} is not known above {schedule.altitude_text(last)}:"
                    f" --to {hundredths(last, up=False)} ends there"
                )
        reasons = {time: reason for time, reason in times.items() if reason}
        if reasons:
            yield f"{name} at {flight_times(reasons)}: {reasons[min(reasons)]}"
