"""Sizing: required deflections by flight time and wind, their largest values, and notes."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.cards import Column, Columns, Shown, Tabled, columns_of, table
from tvclin.base.errors import one_of
from tvclin.base.fields import derived, document, record_table, spec
from tvclin.base.quantities import NO_FORECAST, QUANTITIES
from tvclin.boundary.limit_shapes import LimitShape
from tvclin.linear.plant import DEFAULT_MODEL, ONE_POLE
from tvclin.requirement.plane_requirement import omitted_fraction
from tvclin.requirement.required_quantity import Requirement, heading_of, requirement_among
from tvclin.vehicle.coefficients import PLANE_TEXTS
from tvclin.winds.wind_angles import linear_notes

if TYPE_CHECKING:
    from tvclin.requirement.flight.flight_winds import ConcurrentTrim

STEADY = 0.1
"""Relative change of beta or B above which frozen parameters are doubtful."""


@dataclass(frozen=True)
class Worst(Shown):
    """Largest deflection [rad] of a requirement, with its flight time [s] and wind."""

    deflection: float = field(metadata=spec("angle"))
    time: float = field(metadata=spec("time", "flight time", significant=6))
    wind: str = field(metadata=spec())


@dataclass(frozen=True, eq=False)
class Sizing(Tabled):
    """Required deflections over a flight, in several winds; make it with `size`.

    Attributes
    ----------
    schedule : FlightSchedule
        The flight.
    times : ndarray
        Flight times [s], ``(n,)``.
    winds : tuple of str
        Names of the winds, m of them.
    dead_bands : ndarray
        K, falling, ``(k,)``.
    required : dict of Requirement to ndarray
        Required deflections [rad], ``(n, m)``, by requirement or by label, ``required["K = 1"]``.
        NaN where a requirement is not defined, with the reason in `said`, and where the wind is not
        known. With varying parameters the minimum is defined for a single unstable pole only.
    law : str
        Meaning of "no forecast": "bound", the lower bound of all laws without a forecast, or
        "flown", the requirement of the recoverable-attitude law in flight.
    model, plane : str
        Model and plane of `Plant`; "both" for both planes, which share a limit shape.
    begins, ends : ndarray
        Onset and end of each wind [s], ``(n, m)``; NaN in a calm.
    change : ndarray
        Relative change of beta or B during the wind, over its value at the flight time, ``(n, m)``;
        NaN where no wind is known.
    known_times : ndarray
        First and last flight time [s] at which each wind is known, ``(m, 2)``: a sounding ends at
        its last level. Infinite for others.
    known : ndarray of bool
        Whether the wind is known, ``(n, m)``.
    covered : ndarray of bool
        Whether the schedule covers the wind; outside, parameters are from its nearer end.
    slow_mode : ndarray
        y of eq (C8) for each wind, ``(n, m)``: from one on the slow mode of the flight path
        decides, a single pole is not sufficient, and "minimum" is the two-pole result.
    edge : ndarray
        Duration [s] of a triangle from which two poles count, ``(n,)``; see
        `single_pole_validity`.
    said : tuple of str
        Reasons why a requirement is not defined or not exact; often none.
    notes : tuple of str
        Notes on the validity of the numbers; often none.
    separate : dict of str to Sizing
        For both planes, the sizing of each plane by itself; else empty.
    unsigned : ndarray of bool, or None
        Whether the effect of the sign of a pulse is not known, so that both signs have the nominal
        requirement, ``(n, m)``; None where no signs were computed.
    limit_shape : LimitShape or None
        For both planes, the limit shape; deflections are in its measure.
    arises : dict of Requirement to ndarray
        Flight time [s] at which a requirement with varying parameters arises, ``(m,)``, for winds
        that are the same at all flight times, such as a sounding without a window, whose single
        requirement is repeated in each row: the exit of the dead band; for trim and minimum the
        time of the largest trim. NaN for other winds.
    gaps : tuple of str
        Gaps of soundings in which their wind is not known, in words; often none.
    concurrent : ConcurrentTrim or None
        Trim of winds that are fixed in flight time, with the vehicle of the time of each angle.
    """

    schedule: FlightSchedule = field(metadata=spec(name="vehicle", of="schedule.vehicle.name"))
    times: FloatArray = field(metadata=spec("time", card=False))
    winds: tuple[str, ...] = field(metadata=spec())
    dead_bands: FloatArray
    required: dict[Requirement, FloatArray] = field(metadata=spec("angle", card=False))
    law: str = field(metadata=spec(card=False))
    model: str = field(metadata=spec())
    plane: str = field(metadata=spec())
    begins: FloatArray = field(metadata=spec("time", card=False))
    ends: FloatArray = field(metadata=spec("time", card=False))
    change: FloatArray = field(metadata=spec(card=False))
    known_times: FloatArray = field(metadata=spec("time", card=False))
    known: BoolArray = field(metadata=spec(card=False))
    covered: BoolArray = field(metadata=spec(card=False))
    slow_mode: FloatArray = field(metadata=spec(card=False, document=False))
    edge: FloatArray = field(metadata=spec("time", name="single_pole_edge", card=False))
    said: tuple[str, ...]
    notes: tuple[str, ...]
    separate: Mapping[str, Sizing] = field(default_factory=dict)
    limit_shape: LimitShape | None = None
    unsigned: BoolArray | None = None
    arises: Mapping[Requirement, FloatArray] = field(
        default_factory=dict, metadata=spec("time", card=False, document=False)
    )
    gaps: tuple[str, ...] = ()
    concurrent: ConcurrentTrim | None = None

    @property
    @derived(card=False, document=False)
    def pitch_omitted_fraction(self) -> dict[Requirement, FloatArray]:
        """Fraction of the requirement that is omitted in pitch alone, by flight time and wind.

        With 0.4 a limit for the pitch plane alone would be 40 percent too small. Empty for a single
        plane.
        """
        if not self.separate:
            return {}
        pitch = self.separate["pitch"].required
        return {name: omitted_fraction(x, self.required[name]) for name, x in pitch.items()}

    def as_dict(self) -> dict[str, Any]:
        """Return the record for JSON, angles in degrees."""
        planes: dict[str, Any] = {}
        if self.separate:
            planes = {
                "limit_shape": repr(self.limit_shape),
                "separate_deg": {
                    plane: document(sizing, "required")["required_deg"]
                    for plane, sizing in self.separate.items()
                },
                **document(self, "pitch_omitted_fraction"),
            }
        return {
            **document(self),
            **(document(self, "arises") if self.arises else {}),
            **planes,
            "worst_by_wind": {
                wind: {key.label: worst for key, worst in self.worst_in(wind).items()}
                for wind in self.winds
            },
        }

    def _repr_html_(self) -> str:
        """Return a card for notebooks: the largest of each requirement, with its time and wind."""
        span = f"{self.times[0]:.6g} to {self.times[-1]:.6g} s"
        name = self.schedule.vehicle.name or "Sizing"
        title = f"{name}, {self.model}, {PLANE_TEXTS[self.plane]}: {span}, the largest"
        labels = ("requirement", (heading_of(key.label) for key in self.worst))
        worst = list(self.worst.values())
        return table(
            record_table(title, "worst", worst, "deflection", "time", "wind", labels=labels)
        )

    @property
    @derived(card=False)
    def beyond_single_pole(self) -> BoolArray:
        """Whether m winds are beyond the single-pole theory at n flight times, ``(n, m)``.

        There the slow mode of the flight path, not the fast one of the attitude, sets the required
        deflection: `slow_mode`, the ratio of the two, is negative or above one; NaN gives False.
        """
        return np.asarray((self.slow_mode > 1.0) | (self.slow_mode < 0.0))

    @property
    def steady(self) -> BoolArray:
        """Whether beta and B change by at most a tenth during each of m winds, ``(n, m)``.

        beta is sqrt(abs(mu_alpha)) [1/s], B the ratio of trim deflection to angle of attack.
        """
        return np.asarray((self.change <= STEADY) & self.covered)

    @property
    def law_words(self) -> str:
        """Meaning of the requirement without a forecast in words: of `law`, "bound" or "flown"."""
        words = {
            "bound": QUANTITIES[NO_FORECAST],
            "flown": "the recoverable-attitude law",
        }
        return words[self.law]

    @property
    @derived(card=False)
    def worst(self) -> dict[Requirement, Worst]:
        """Largest value of each requirement, omitting those that are defined nowhere."""
        return self._largest(range(len(self.winds)))

    @property
    @derived("angle", document=False)
    def largest(self) -> dict[Requirement, float]:
        """Largest deflection [rad] of each requirement, omitting those that are defined nowhere."""
        return {name: worst.deflection for name, worst in self.worst.items()}

    def worst_in(self, wind: str) -> dict[Requirement, Worst]:
        """Return the largest value [rad] of each requirement over the flight, with its time.

        `wind`: name of the wind, one of `winds`; `InputError` for an unknown one.
        """
        return self._largest([self.winds.index(one_of("wind", wind, self.winds))])

    @property
    def freezing_error(self) -> dict[Requirement, FloatArray]:
        """Frozen over varying requirement, minus one, in n flight times and m winds, ``(n, m)``.

        By the requirement with frozen parameters; empty if none has been sized with varying ones.
        """
        pairs = {frozen: replace(frozen, varying=True) for frozen in self.required}
        with np.errstate(invalid="ignore", divide="ignore"):
            return {
                frozen: self.required[frozen] / self.required[varying] - 1.0
                for frozen, varying in pairs.items()
                if varying in self.required and not frozen.varying
            }

    def at_times(self, name: Requirement | str) -> FloatArray:
        """Return a requirement [rad] in the worst wind of each flight time, ``(n,)``.

        `name`: the requirement or its label; `InputError` for an unknown one. Winds in which it is
        not known do not count; see `not_sized`.
        """
        values = self.required[requirement_among("name", name, self.required)]
        with np.errstate(invalid="ignore"):
            return np.fmax.reduce(values, axis=1)

    def arising(self, name: Requirement | str) -> FloatArray:
        """Return the flight time [s] at which a requirement of each of m winds arises, ``(m,)``.

        Of a dead band it arises at its exit, of trim and minimum at the largest trim. NaN for a
        wind that is not fixed in flight time, but moved to each flight time. Same parameters and
        exceptions as `at_times`.
        """
        requirement = requirement_among("name", name, self.required)
        return np.asarray(self.arises.get(requirement, np.full(len(self.winds), np.nan)))

    def not_sized(self, name: Requirement | str) -> tuple[str, ...]:
        """Return the intervals in which a requirement is not known in every wind, in words.

        Last are the `gaps` of soundings. Same parameters and exceptions as `at_times`.
        """
        requirement = requirement_among("name", name, self.required)
        values = self.required[requirement]
        # first and last time [s] at which all winds are known
        first, last = self.known_times[:, 0].max(), self.known_times[:, 1].min()
        early, late = self.times < first, self.times > last
        # flight times without a requirement that no end of a sounding explains
        rest = self.times[np.isnan(values).any(axis=1) & ~early & ~late]
        words = {
            f"above {self.schedule.altitude_text(last)}": np.any(late),
            f"below {self.schedule.altitude_text(first)}": np.any(early),
            _interval(rest): rest.size > 0,
        }
        # head and tail winds are computed for the largest dead band alone; `unsigned`: whether
        # their effect is not known
        if self.unsigned is not None and requirement.dead_band == self.dead_bands[0]:
            times = self.times[self.unsigned.any(axis=1)]
            words[f"at the dynamic pressure encountered {_interval(times)}"] = times.size > 0
        return (*(word for word, unknown in words.items() if unknown), *self.gaps)

    def _largest(self, winds: Sequence[int]) -> dict[Requirement, Worst]:
        """Return the largest value [rad] of each requirement over the flight, with time and wind.

        `winds`: indices of the winds. A requirement that is NaN throughout is omitted. The time of
        a wind that is fixed in flight time is that at which the requirement arises.
        """
        largest = {}
        for name, required in self.required.items():
            values = required[:, winds]
            if np.all(np.isnan(values)):
                continue
            i, j = np.unravel_index(int(np.nanargmax(values)), values.shape)
            wind = winds[int(j)]
            arises = float(self.arising(name)[wind])
            time = float(self.times[i]) if np.isnan(arises) else arises
            largest[name] = Worst(float(values[i, j]), time, self.winds[wind])
        return largest

    def _columns(self) -> Columns:
        """Return the columns of requirements and validity, by flight time and wind."""
        needs = {requirement.column: values for requirement, values in self.required.items()}
        for plane, sizing in self.separate.items():
            needs |= {f"{k.column}_{plane}_alone": v for k, v in sizing.required.items()}
        others = ("begins", "ends", "change", "known", "covered", "slow_mode", "beyond_single_pole")
        return Columns(
            (Column("time", self.times, "s"), Column("wind", np.array(self.winds), "")),
            (
                *(Column(name, values, "rad") for name, values in needs.items()),
                *columns_of(self, *others),
                *columns_of(self, "single_pole_edge", axes=("time",)),
            ),
            document(self, "vehicle", "model", "plane", "law"),
        )


def joined_sizing(sizing: Sizing, further: Sizing) -> Sizing:
    """Return a sizing with the flight times of another one in the same winds, in order of time.

    The times of `further` lie between those of `sizing`. Requirements [rad] that `further` does not
    have are NaN at its flight times. Reasons, notes, gaps of soundings and fields of winds fixed in
    flight time are taken from `sizing`.
    """
    order = np.argsort(np.concatenate([sizing.times, further.times]), kind="stable")

    def rows(values: Any, others: Any) -> Any:
        """Return the rows of both sizings, in order of time."""
        return np.concatenate([values, others])[order]

    unknown = np.full(further.known.shape, np.nan)
    unsigned = [
        np.zeros(x.known.shape, dtype=bool) if x.unsigned is None else x.unsigned
        for x in (sizing, further)
    ]
    names = ("times", "begins", "ends", "change", "known", "covered", "slow_mode", "edge")
    return replace(
        sizing,
        **{name: rows(getattr(sizing, name), getattr(further, name)) for name in names},
        required={
            name: rows(values, further.required.get(name, unknown))
            for name, values in sizing.required.items()
        },
        separate={
            plane: joined_sizing(of_plane, further.separate[plane])
            for plane, of_plane in sizing.separate.items()
        },
        unsigned=rows(*unsigned),
    )


_MAX_LISTED_TIMES = 2
"""Largest number of flight times that are listed one by one."""
_RELATIVE_TOLERANCE = 1e-9
"""Relative difference up to which two deflections count as equal."""


def _interval(times: FloatArray) -> str:
    """Return the interval of flight times [s], in words; "at" the time of a single one."""
    first, last = (f"{time:.6g}" for time in (times.min(initial=np.inf), times.max(initial=0.0)))
    return f"from {first} to {last} s" if times.size > 1 else f"at {last} s"


_MIN_REPEATED = 3
"""Smallest number of flight times in a row with the same requirement that has a note."""
_REPEATED_TOLERANCE = 1e-6
"""Relative difference of requirements below which they are the same."""


def notes_of(sizing: Sizing) -> tuple[str, ...]:
    """Return notes on a sizing, each one sentence; often none."""
    return (
        *_unknown_notes(sizing),
        *_beyond_single_pole_notes(sizing),
        *sizing.said,
        *_change_notes(sizing),
        *_uncovered_notes(sizing),
        *_end_notes(sizing),
        *_repeated_notes(sizing),
    )


def _repeated_notes(sizing: Sizing) -> Iterator[str]:
    """Yield a note on each wind that requires the same at three or more flight times in a row.

    That is a sounding with a gust or a window: what sets the requirement is then no part of the
    wind about these flight times. It is the varying requirement of the largest dead band.
    """
    band = Requirement(dead_band=sizing.dead_bands[0], varying=True)
    if band not in sizing.required or sizing.times.size < _MIN_REPEATED:
        return
    order = np.argsort(sizing.times)
    # soundings with a gust or a window: winds placed about the flight time
    placed = np.isnan(sizing.arising(band)) & np.isfinite(sizing.known_times).any(axis=1)
    for j in np.flatnonzero(placed):
        wind, values = sizing.winds[j], sizing.required[band][order, j]
        # zero, infinite and unknown requirements, as different numbers, are runs of their own
        counts = np.isfinite(values) & (values > 0.0)
        values = np.where(counts, values, -np.arange(1.0, values.size + 1.0))
        # index of the run of equal values to which each flight time belongs
        steps = np.abs(np.diff(values)) > _REPEATED_TOLERANCE * np.abs(values[:-1])
        runs = np.cumsum(np.append(0, steps))
        longest = np.flatnonzero(runs == np.argmax(np.bincount(runs)))
        if longest.size >= _MIN_REPEATED:
            first, last = sizing.times[order][longest[[0, -1]]].tolist()
            yield (
                f"{wind}: {band} is the same from {first:.6g} to {last:.6g} s, set by wind that"
                " blows away from these flight times"
            )


def unknown_wind_notes(sizing: Sizing, reasons: list[list[str]]) -> Iterator[str]:
    """Yield notes on flight times of a sizing at which winds are not known.

    `reasons`: the reason by flight time and wind, empty for a known wind.
    """
    for j, wind in enumerate(sizing.winds):
        times = {float(t): row[j] for t, row in zip(sizing.times, reasons, strict=True) if row[j]}
        if times:
            yield f"{wind} is not known at {flight_times(times)}: {times[min(times)]}"


def doubtful_winds(angles: Mapping[str, float]) -> list[str]:
    """Return notes on winds, by name, whose largest angle [rad] is doubtfully linear."""
    return [f"{wind}: {note}" for wind, angle in angles.items() for note in linear_notes(angle)]


def slower_modes_message(times: FloatArray, raised: FloatArray) -> Iterator[str]:
    """Yield a message on flight times [s] at which slower unstable modes raise the minimum.

    They count as modes of the vehicle when the wind ends, while the fastest mode follows the
    flight. `raised`: whether they do by more than 5 percent, by time and wind.
    """
    if at := times[np.any(raised, axis=1)].tolist():
        yield (
            f"at {flight_times(at)}, parameters varying: slower unstable modes count as those of"
            " the vehicle when the wind ends; the minimum, and each K with it, may be more than a"
            " control requires"
        )


def flight_times(times: Collection[float]) -> str:
    """Return flight times [s] in words: number, first and last, or all of them."""
    ends = [f"{t:.6g} s" for t in sorted({min(times), max(times)})]
    return (
        f"{len(times)} flight times, {' to '.join(ends)}"
        if len(times) > _MAX_LISTED_TIMES
        else " and ".join(ends)
    )


def _unknown_notes(sizing: Sizing) -> Iterator[str]:
    """Yield notes on winds of a sizing that are not known over the entire flight."""
    begin, end = sizing.schedule.span
    altitude = sizing.schedule.altitude_text  # altitude in words at a flight time
    for wind, (first, last) in zip(sizing.winds, sizing.known_times.tolist(), strict=True):
        limits = [f"from {altitude(first)}"] if begin < first else []
        limits += [f"to {altitude(last)}"] if last < end else []
        if limits:
            yield (
                f"{wind} is known {' '.join(limits)} only; beyond, the wind is unknown, not"
                " calm: no flight time there is sized"
            )


def _beyond_single_pole_notes(sizing: Sizing) -> Iterator[str]:
    """Yield notes on winds of a sizing beyond the single-pole theory."""
    beyond = sizing.beyond_single_pole
    consequence = "the minimum counts two poles, and every dead band requires at least as much"
    if sizing.model in ONE_POLE:
        consequence = (
            f"{sizing.model} leaves out the slow pole, which may require more ({DEFAULT_MODEL})"
        )
    for j, wind in enumerate(sizing.winds):
        if np.any(beyond[:, j]):
            i = int(np.argmax(beyond[:, j]))  # first flight time at which the wind is beyond it
            duration, longest = sizing.ends[i, j] - sizing.begins[i, j], sizing.edge[i]  # [s]
            holds = "no triangle" if np.isnan(longest) else f"triangles up to {longest:.1f} s"
            yield (
                f"{wind} ({duration:.4g} s at {sizing.times[i]:.6g} s) is beyond the single-pole"
                f" theory, which holds for {holds}: {consequence}"
            )


def _change_notes(sizing: Sizing) -> Iterator[str]:
    """Yield a note on the largest change of beta or B during a wind of a sizing.

    beta [1/s] is the unstable pole on a fixed path, B the ratio of trim deflection to angle of
    attack. None for changes that are small, or with varying parameters.
    """
    if sizing.freezing_error or not np.any(sizing.change > STEADY):
        return
    i, j = np.unravel_index(int(np.nanargmax(sizing.change)), sizing.change.shape)
    yield (
        f"beta or B changes by up to {100 * sizing.change[i, j]:.0f} % while {sizing.winds[j]}"
        f" blows (at {sizing.times[i]:.6g} s); frozen parameters are doubtful above"
        f" {100 * STEADY:.0f} %"
    )


def _uncovered_notes(sizing: Sizing) -> Iterator[str]:
    """Yield a note on winds of a sizing that its flight schedule does not cover."""
    if not np.all(sizing.covered):
        first, last = sizing.schedule.span
        yield (
            f"winds extend beyond the schedule, {first:.6g} to {last:.6g} s, where parameters are"
            " those of its nearer end"
        )


def _end_notes(sizing: Sizing) -> Iterator[str]:
    """Yield notes on requirements of a sizing that are largest at its first or last time."""
    order = np.argsort(sizing.times)
    # varying parameters give a wind that is fixed in flight time a single number, not one by time
    has_fixed = any(np.isfinite(times).any() for times in sizing.arises.values())
    varying = not has_fixed and any(requirement.varying for requirement in sizing.required)
    ends: dict[str, list[str]] = {}
    for requirement in sizing.required:
        if requirement.varying != varying or requirement.direction:  # follows the nominal one
            continue
        name, values = heading_of(requirement.name), sizing.at_times(requirement)[order]
        times, values = sizing.times[order][~np.isnan(values)], values[~np.isnan(values)]
        if times.size < 2:
            continue
        if values[0] > (1.0 + _RELATIVE_TOLERANCE) * values[1:].max():
            ends.setdefault(f"first flight time, {times[0]:.6g} s; before", []).append(name)
        if values[-1] > (1.0 + _RELATIVE_TOLERANCE) * values[:-1].max():
            ends.setdefault(f"last flight time, {times[-1]:.6g} s; after", []).append(name)
    frozen = "with the vehicle frozen at each flight time, " if has_fixed else ""
    for end, names in ends.items():
        yield f"{frozen}largest at the {end} it, these may be larger: {'; '.join(names)}"
