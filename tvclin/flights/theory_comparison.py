"""A flight compared with the linear theory, or a flexible vehicle with the rigid one."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.flight_condition import FlightCondition
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import (
    InputError,
    ending,
    instance,
    number,
    one_of,
    positive,
    shown,
    single,
    small_angle,
    times_row,
)
from tvclin.base.lines import Line, Table, degrees, least
from tvclin.boundary.limit import boundary_limit
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.fly import fly
from tvclin.flights.closed_loop.fly_many import SURVIVED, FlownCases, fly_many
from tvclin.flights.closed_loop.survival_limit import closed_loop_boundary
from tvclin.flights.flown_boundary import ENGINES
from tvclin.flights.nozzle_command import ReportControl
from tvclin.flights.verdict import FARTHEST, OUTPUTS
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.extremes import MAX_SHOWN_ATTITUDE, release_time
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.plant import DEFAULT_MODEL, Plant
from tvclin.linear.response import attitude_responses
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import beyond_linear

SAMPLE_RATE = 100.0
"""Samples of a law in the linear flight [Hz]: the steps of JSBSim."""
_HIGHEST = 4.0
"""Limits that are tried, over the largest trim deflection; what needs more is refused."""
_AT_LIMIT = 1e-9
"""A deflection so near the limit, over the limit, is at it."""
PEAKS = ("attitude", "deflection", "angle_of_attack")
"""Of these outputs tables show the largest."""


@dataclass(frozen=True, eq=False)
class FlightBeside:
    """A flight and the linear flight with the same limit.

    Attributes
    ----------
    times : ndarray
        Times [s], ``(n,)``.
    flown, linear : ndarray
        Attitude, attitude rate, flight path angle, angle of attack and deflection [rad, rad/s],
        ``(5, n)``; NaN after a flight has left the range of its model, the linear one 90 degrees.
    wind : History
        The wind angle [rad].
    survived, predicted : bool or None
        Whether the flight survives the wind, and whether the linear theory says so; None in a wind
        `beyond` linear aerodynamics, which both rest on.
    let_go : tuple of float
        When the limit of the report's control, which would be held for ever, is let go [s], flown
        and linear: as the attitude is back at zero, if there it survives. Infinite if it is not
        while it is watched. The rows are NaN from then on.
    """

    times: FloatArray
    flown: FloatArray
    linear: FloatArray
    wind: History
    survived: bool | None
    predicted: bool | None
    let_go: tuple[float, float]

    def peaks(self, name: str) -> tuple[float, float]:
        """Return the largest size of an output over the wind, flown and linear.

        It is taken over the times at which there are both.

        Raises
        ------
        InputError
            For an unknown output, and where no time lies in the wind.
        """
        row = OUTPUTS.index(one_of("name", name, OUTPUTS))
        here = self.times <= float(self.wind.end)
        here &= np.isfinite(self.flown[row] + self.linear[row])
        if not np.any(here):
            raise InputError("timepts must have some time before the wind ends")
        flown, linear = (np.abs(each[row, here]).max() for each in (self.flown, self.linear))
        return float(flown), float(linear)

    @property
    def beyond(self) -> str:
        """Sentence why nothing is known in this wind, as of `beyond_linear`; empty where it is."""
        return beyond_linear(float(self.wind.peak))

    @property
    def fates(self) -> tuple[str, str]:
        """What becomes of both, in words."""
        words = {True: "survives", False: "is lost", None: "is not known to survive"}
        return words[self.survived], words[self.predicted]

    @property
    def largest(self) -> dict[str, tuple[float, float]]:
        """What is largest in both [rad, rad/s], by its name."""
        return {
            f"largest {name.replace('_', ' ')} over the wind [deg]": self.peaks(name)
            for name in PEAKS
        }

    def table(
        self, caption: str, names: Sequence[str], boundaries: tuple[float | None, float] | None
    ) -> Table:
        """Return what becomes of both, what is largest, and what differs.

        Parameters
        ----------
        caption : str
            Stands above the table.
        names : sequence of str
            What both are called, or the first alone.
        boundaries : tuple of float or None
            The least limits [rad] that both survive with, where they are known.
        """
        angles = dict(self.largest)
        if boundaries is not None and boundaries[0] is not None:
            angles = {"least limit that survives [deg]": (boundaries[0], boundaries[1])} | angles
        rows: list[tuple[Line, ...]] = [(("with this limit it",), *((one,) for one in self.fates))]
        for k, (label, both) in enumerate(angles.items()):
            cells = [least(degrees(f"flown.{k}.{i}", one)) for i, one in enumerate(both)]
            rows.append(((label,), *cells))
        width = len(names) + 1
        return Table(caption, ("quantity", *names), tuple(row[:width] for row in rows))


def linear_boundary(plant: Plant, control: ReportControl | Law, wind: History) -> float:
    """Return the least deflection limit [rad] with which a control survives in linear theory.

    `InputError` as `boundary_limit` and `closed_loop_boundary`, and for a law that survives with no
    limit up to four times the largest trim deflection.
    """
    if isinstance(control, ReportControl):
        found = boundary_limit(plant, wind, control.dead_band, switch="literal")
        return abs(float(found.deflection))
    limits = closed_loop_boundary(plant, control, wind, sample_rate=SAMPLE_RATE, highest=_HIGHEST)
    if not np.isfinite(limits.limit):
        raise InputError(
            f"control must survive with {_HIGHEST:g} times the largest trim deflection as its limit"
        )
    return abs(limits.deflection)


def fly_beside(
    vehicle: Vehicle,
    control: ReportControl | Law,
    wind: History,
    timepts: ArrayLike,
    *,
    deflection_limit: float,
    engine: str = "planar",
    plane: str = "pitch",
    condition: FlightCondition | None = None,
    boundary: float | None = None,
) -> FlightBeside:
    """Return a flight, whether it survives, and what the linear theory says of both.

    Parameters
    ----------
    vehicle : Vehicle
        One vehicle, aerodynamically unstable.
    control : ReportControl or Law
        What turns the nozzle.
    wind : History
        One wind that ends.
    timepts : array_like
        Times [s], ``(n,)``, the last not before the end of the wind.
    deflection_limit : float
        Largest deflection [rad].
    engine : {"planar", "sixdof"}
        What flies.
    plane : {"pitch", "yaw"}
        The plane of wind, nozzle and outputs.
    condition : FlightCondition, optional
        With one, parameters vary along the trajectory; the linear theory's are always frozen.
    boundary : float, optional
        The `linear_boundary` [rad], where it is known.

    Raises
    ------
    InputError
        As `fly_planar`, `fly_sixdof` and `linear_boundary`.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> vehicle = tv.load_vehicle("configuration-i")
    >>> wind = tv.TriangularWind(peak=np.radians(1), duration=7.5)
    >>> times = np.linspace(0, 10, 101)
    >>> report = tv.flights.ReportControl()
    >>> one = tv.flights.fly_beside(vehicle, report, wind, times, deflection_limit=0.00126)
    >>> one.survived, one.predicted, np.degrees(one.peaks("attitude")).round(2).tolist()
    (True, True, [0.43, 0.43])
    """
    plant = Plant.from_vehicle(vehicle, DEFAULT_MODEL, plane)
    instance("wind", wind, History, "such as TriangularWind")
    single("wind", wind.batch)
    ending("wind", wind.end)
    if not isinstance(control, ReportControl | Law):
        raise InputError(f"control must be a ReportControl or a Law; got {shown(control)}")
    limit = number(
        "deflection_limit", deflection_limit, small_angle("a deflection", positive), "rad"
    )
    last, end = float(np.max(times_row("timepts", timepts))), float(wind.end)
    if last < end - _AT_LIMIT * abs(end):
        raise InputError(f"timepts must reach the end of the wind, {end:.6g} s; got {last:.6g} s")
    if boundary is None:
        least = linear_boundary(plant, control, wind)
    else:
        least = number("boundary", boundary, positive, "rad")
    options: dict[str, Any] = {"plane": plane, "condition": condition}
    flying = ENGINES[one_of("engine", engine, ENGINES)]
    survives = flying.verdict(vehicle, wind, control, frozen=condition is None, **options)
    survived, predicted = survives(limit), limit >= least
    holds = isinstance(control, ReportControl)
    with warnings.catch_warnings():
        if survived and holds:  # over to the other side, where the limit has long been let go
            warnings.filterwarnings("ignore", message="the flight ends")
        times, rows = flying.outputs(
            vehicle, control, wind, timepts, deflection_limit=limit, **options
        )
    linear = _linear(plant, control, wind, times, limit)
    linear[:, np.logical_or.accumulate(np.abs(linear[0]) > MAX_SHOWN_ATTITUDE)] = np.nan
    ends = tuple(
        _let_go(plant, wind, times, each, limit) if holds and survivor else np.inf
        for each, survivor in ((rows, survived), (linear, predicted))
    )
    known = not beyond_linear(float(wind.peak))
    return FlightBeside(
        times=times,
        flown=rows,
        linear=linear,
        wind=wind,
        survived=survived if known else None,
        predicted=predicted if known else None,
        let_go=(ends[0], ends[1]),
    )


def _let_go(
    plant: Plant, wind: History, times: FloatArray, rows: FloatArray, limit: float
) -> float:
    """When the limit is let go; the rows become NaN from there on."""
    flown = np.flatnonzero(np.isfinite(rows[0]))
    if not flown.size or abs(rows[-1, flown[-1]]) < limit * (1.0 - _AT_LIMIT):
        return np.inf
    when = release_time(plant, wind, times, rows[0])
    rows[:, times > when] = np.nan
    return when


def _linear(
    plant: Plant, control: ReportControl | Law, wind: History, times: FloatArray, limit: float
) -> FloatArray:
    """The `OUTPUTS` of the linear flight, ``(5, n)``."""
    if isinstance(control, ReportControl):
        against = -float(np.sign(plant.coefficients.B * wind.peak))
        held = trim_then_hold(plant, wind, against * limit, control.dead_band, "literal")
        found = attitude_responses(plant, held, wind, times)
        return np.stack([*(found[name] for name in OUTPUTS[:-1]), held(times)])
    flown = fly(plant, control, wind, times, deflection_limit=limit, sample_rate=SAMPLE_RATE)
    return np.stack([flown.outputs[name] for name in OUTPUTS])


NOT_KNOWN = "not known"
"""Status of a flight in a wind beyond linear aerodynamics."""
FATES = {
    "survived": "survives",
    "lost": "is lost",
    "rings": "is brought back, and its nozzle keeps oscillating",
    "undecided": "is neither lost nor settled",
    "no flight": "cannot be flown",
    NOT_KNOWN: "is not known to survive",
}
"""What became of a flight, as of `FlownCases`, in words."""


@dataclass(frozen=True, eq=False)
class SampledFlight(FlightBeside):
    """A flight of a law in steps with the limits of the nozzle; `linear` is the rigid vehicle.

    Of a rigid plant the two are the same. `status`: what became of both, flown and rigid, as of
    `FlownCases`. `peak_rates`: the largest rate of the nozzle [rad/s] of both, a mean over a
    sample.
    """

    status: tuple[str, str]
    peak_rates: tuple[float, float]

    @property
    def fates(self) -> tuple[str, str]:
        """What becomes of both, in words."""
        return FATES[self.status[0]], FATES[self.status[1]]

    @property
    def largest(self) -> dict[str, tuple[float, float]]:
        """What is largest in both [rad, rad/s], by its name."""
        return super().largest | {"largest rate of the nozzle [deg/s]": self.peak_rates}


def fly_sampled(
    plant: AnyPlant, law: Law, wind: History, timepts: ArrayLike, **nozzle: Any
) -> SampledFlight:
    """Return a flight by samples, what became of it, and the same of the rigid vehicle.

    Arguments and errors as of `fly`; `nozzle`: deflection_limit, rate_limit, actuator, sample_rate
    and delay.
    """
    many: list[FlownCases] = [fly_many(one, law, wind, **nozzle) for one in (plant, plant.rigid)]
    beyond = beyond_linear(float(wind.peak))
    status = [NOT_KNOWN if beyond else str(one.status) for one in many]
    times = np.asarray(timepts, dtype=float)
    rows = [_rows(one, law, wind, times, nozzle) for one in (plant, plant.rigid)]
    return SampledFlight(
        times=times,
        flown=rows[0],
        linear=rows[1],
        wind=wind,
        survived=None if beyond else status[0] == SURVIVED,
        predicted=None if beyond else status[1] == SURVIVED,
        let_go=(np.inf, np.inf),
        status=(status[0], status[1]),
        peak_rates=(float(many[0].peak_deflection_rate), float(many[1].peak_deflection_rate)),
    )


def _rows(
    plant: AnyPlant, law: Law, wind: History, times: FloatArray, nozzle: dict[str, Any]
) -> FloatArray:
    """The `OUTPUTS`, ``(5, n)``; NaN from where the model holds no longer."""
    flown, nothing = fly(plant, law, wind, times, **nozzle), np.zeros(times.size)
    there = (*plant.outputs, "deflection")  # a fixed path has no angle
    rows = np.stack([flown.outputs[name] if name in there else nothing for name in OUTPUTS])
    beyond = np.flatnonzero(np.abs(rows[0]) > FARTHEST)
    rows[:, beyond[0] if beyond.size else times.size :] = np.nan
    return rows
