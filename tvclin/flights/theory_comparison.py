"""A flight compared with the linear theory, or a flexible vehicle with the rigid one."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.nominal_flight import FlightCondition
from tvclin.base import errors
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.lines import Line, Table, degrees, minimum_limit
from tvclin.boundary.limit import boundary_limit
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.fly import flight_responses
from tvclin.flights.closed_loop.fly_many import (
    NOT_KNOWN,
    OUTCOME_WORDS,
    SURVIVED,
    FlownCases,
    fly_many,
)
from tvclin.flights.closed_loop.survival_limit import closed_loop_boundary
from tvclin.flights.engine_interface import MAX_ATTITUDE, OUTPUTS, ReportControl
from tvclin.flights.flown_boundary import ENGINES
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.extremes import MAX_SHOWN_ATTITUDE, release_time
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.plant import DEFAULT_MODEL, Plant
from tvclin.linear.response import attitude_responses
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import beyond_linear

SAMPLE_RATE = 100.0
"""Sample rate of a law in the linear flight [Hz]: the steps of JSBSim."""
_MAX_LIMIT_OVER_TRIM = 4.0
"""Largest limit of the search for the linear boundary, over the largest trim deflection."""
_LIMIT_TOLERANCE = 1e-9
"""Relative distance from the limit at which a deflection counts as at the limit."""
PEAKS = ("attitude", "deflection", "angle_of_attack")
"""Outputs whose peaks tables show."""


@dataclass(frozen=True, eq=False)
class FlightComparison:
    """Flight of an engine, compared with the linear flight with the same limit.

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
        Whether the flight survives the wind, and whether it does in linear theory; None in a wind
        beyond the linear aerodynamics that both assume, and for `in_unknown_wind`.
    let_go : tuple of float
        Times [s], flown and linear, at which the limit of the report's control, held for ever
        otherwise, is released: at zero attitude, if the flight survives. Infinite if that is later
        than the last time. The rows are NaN afterwards.
    """

    times: FloatArray
    flown: FloatArray
    linear: FloatArray
    wind: History
    survived: bool | None
    predicted: bool | None
    let_go: tuple[float, float]

    ranges: ClassVar[tuple[float, float]] = (MAX_ATTITUDE, MAX_SHOWN_ATTITUDE)
    """Largest attitudes [rad] of the models of both flights."""

    def peaks(self, name: str) -> tuple[float, float]:
        """Return the peak magnitude of an output during the wind, flown and linear [rad, rad/s].

        A flight that leaves the range of its model in the wind counts until it does: its outputs
        are extrapolated from the last two times to the largest attitude of the model (`ranges`).

        Parameters
        ----------
        name : str
            Name of the output, such as "attitude".

        Raises
        ------
        InputError
            For an unknown output, and where no time lies in the wind.
        """
        row = OUTPUTS.index(errors.one_of("name", name, OUTPUTS))
        flown, linear = (
            self._peak(rows, row, limit if ended else None)
            for rows, limit, ended in zip(
                (self.flown, self.linear), self.ranges, self.ended, strict=True
            )
        )
        return flown, linear

    def _peak(self, rows: FloatArray, row: int, last_attitude: float | None) -> float:
        """Return the peak magnitude of an output during the wind [rad, rad/s].

        `rows`: five outputs of a flight at n times, ``(5, n)``, the attitude first. `row`: index of
        the output. `last_attitude`: size of the attitude [rad] at which the flight ends after the
        last sample, to which the output is extrapolated; None without such an end.
        `InputError` if no time lies in the wind.
        """
        samples = rows[:, self._during_wind & np.isfinite(rows[0])]
        if not samples.size:
            raise errors.InputError("timepts must have some time before the wind ends")
        peak = float(np.abs(samples[row]).max())
        if last_attitude is None or samples.shape[1] < 2:
            return peak
        before, last = samples[:, -2], samples[:, -1]
        # steps from the last sample to that attitude, on a line through the last two
        beyond = (last_attitude - abs(last[0])) / (abs(last[0]) - abs(before[0]))
        return max(peak, float(abs(last[row] + beyond * (last[row] - before[row]))))

    @property
    def _during_wind(self) -> BoolArray:
        """Whether each of the n times is not after the end of the wind, ``(n,)``."""
        return self.times <= float(self.wind.end)

    @property
    def ended(self) -> tuple[bool, bool]:
        """Whether the flight and the linear flight leave the range of their models in the wind.

        The attitude is then NaN before the wind ends. It is NaN also after the release of the limit
        at a finite time, `let_go`, which does not count.
        """
        flown, linear = (
            bool(np.isnan(rows[0, self._during_wind]).any() and np.isinf(let_go))
            for rows, let_go in zip((self.flown, self.linear), self.let_go, strict=True)
        )
        return flown, linear

    @property
    def beyond_linear(self) -> str:
        """Reason of `beyond_linear` why survival is not known in this wind; else empty."""
        return beyond_linear(float(self.wind.peak))

    def in_unknown_wind(self) -> Self:
        """Return the comparison where parts of the wind are not known: no flight survives for sure.

        A flight that survives, or is predicted to, becomes not known, None; a loss remains, False.
        """
        survived, predicted = (
            False if x is False else None for x in (self.survived, self.predicted)
        )
        return replace(self, survived=survived, predicted=predicted)

    @property
    def outcomes(self) -> tuple[str, str]:
        """Outcomes of the flight and of the linear flight, in words."""
        words = {True: "survives", False: "is lost", None: "is not known to survive"}
        return words[self.survived], words[self.predicted]

    @property
    def largest(self) -> dict[str, tuple[float, float]]:
        """Peaks of the flight and of the linear flight [rad, rad/s], by the label of their row.

        The labels name degrees, into which `table` converts the peaks.
        """
        return {
            f"largest {name.replace('_', ' ')} over the wind [deg]": self.peaks(name)
            for name in PEAKS
        }

    def table(
        self, caption: str, names: Sequence[str], boundaries: tuple[float | None, float] | None
    ) -> Table:
        """Return the table of outcomes, boundaries and peaks of both flights.

        Parameters
        ----------
        caption : str
            Caption of the table.
        names : sequence of str
            Names of both flights, or of the first alone.
        boundaries : tuple of float or None
            Smallest limits [rad] with which the flight and the linear flight survive. The row is
            left out if the first is not known.
        """
        angles = dict(self.largest)
        if boundaries is not None and boundaries[0] is not None:
            angles = {"smallest limit that survives [deg]": (boundaries[0], boundaries[1])} | angles
        outcomes = ((outcome,) for outcome in self.outcomes)
        rows: list[tuple[Line, ...]] = [(("with this limit the vehicle",), *outcomes)]
        for k, (label, pair) in enumerate(angles.items()):
            # of an infinite smallest limit the cell is "none is sufficient"
            cells = [
                minimum_limit(degrees(f"flown.{k}.{i}", angle)) for i, angle in enumerate(pair)
            ]
            rows.append(((label,), *cells))
        width = len(names) + 1  # of the label, and of a flight for each name
        return Table(caption, ("quantity", *names), tuple(row[:width] for row in rows))


def linear_boundary(plant: Plant, control: ReportControl | Law, wind: History) -> float:
    """Return the smallest deflection limit [rad] with which a control survives in linear theory.

    `plant`: linear model of one vehicle. `control`: the report's control, or a law. `wind`: one
    wind that ends. `InputError` in the same cases as `boundary_limit` and `closed_loop_boundary`,
    and for a law that survives with no limit up to four times the largest trim deflection.
    """
    if isinstance(control, ReportControl):
        boundary = boundary_limit(plant, wind, control.dead_band, switch="literal")
        return abs(float(boundary.deflection))
    limits = closed_loop_boundary(
        plant, control, wind, sample_rate=SAMPLE_RATE, highest=_MAX_LIMIT_OVER_TRIM
    )
    if not np.isfinite(limits.limit):
        raise errors.InputError(
            f"control must survive with {_MAX_LIMIT_OVER_TRIM:g} times the largest trim deflection"
            " as its limit"
        )
    return abs(limits.deflection)


def compare_flight(
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
) -> FlightComparison:
    """Return a flight of an engine and its verdict, compared with linear theory.

    Parameters
    ----------
    vehicle : Vehicle
        One vehicle, aerodynamically unstable.
    control : ReportControl or Law
        Command of the nozzle.
    wind : History
        One wind that ends.
    timepts : array_like
        Times [s], ``(n,)``, the last not before the end of the wind.
    deflection_limit : float
        Largest deflection [rad].
    engine : {"planar", "sixdof"}
        Engine of the flight.
    plane : {"pitch", "yaw"}
        The plane of wind, nozzle and outputs.
    condition : FlightCondition, optional
        With it, parameters vary along the trajectory; in linear theory they are always frozen.
    boundary : float, optional
        The `linear_boundary` [rad], if it is known.

    Raises
    ------
    InputError
        In the same cases as `fly_planar`, `fly_sixdof` and `linear_boundary`.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> vehicle = tv.load_vehicle("configuration-i")
    >>> wind = tv.TriangularWind(peak=np.radians(1), duration=7.5)
    >>> times = np.linspace(0, 10, 101)
    >>> report = tv.flights.ReportControl()
    >>> c = tv.flights.compare_flight(vehicle, report, wind, times, deflection_limit=0.00126)
    >>> c.survived, c.predicted, np.degrees(c.peaks("attitude")).round(2).tolist()
    (True, True, [0.43, 0.43])
    """
    plant = Plant.from_vehicle(vehicle, DEFAULT_MODEL, plane)
    errors.instance("wind", wind, History, "such as TriangularWind")
    errors.single("wind", wind.batch)
    errors.ending("wind", wind.end)
    if not isinstance(control, ReportControl | Law):
        raise errors.InputError(
            f"control must be a ReportControl or a Law; got {errors.shown(control)}"
        )
    limit = errors.limit_angle(deflection_limit)
    last, end = float(np.max(errors.times_row("timepts", timepts))), float(wind.end)
    if last < end - _LIMIT_TOLERANCE * abs(end):
        raise errors.InputError(
            f"timepts must reach the end of the wind, {end:.6g} s; got {last:.6g} s"
        )
    if boundary is None:
        minimum = linear_boundary(plant, control, wind)
    else:
        minimum = errors.number("boundary", boundary, errors.positive, "rad")
    options: dict[str, Any] = {"plane": plane, "condition": condition}
    simulator = ENGINES[errors.one_of("engine", engine, ENGINES)]
    survives = simulator.verdict(vehicle, wind, control, frozen=condition is None, **options)
    survived, predicted = survives(limit), limit >= minimum
    # the report's control holds the limit until it is released
    holds = isinstance(control, ReportControl)
    with warnings.catch_warnings():
        if survived and holds:  # the fall in the other direction is after the release of the limit
            warnings.filterwarnings("ignore", message="the flight ends")
        times, rows = simulator.outputs(
            vehicle, control, wind, timepts, deflection_limit=limit, **options
        )
    linear = _linear(plant, control, wind, times, limit)
    # NaN from the first attitude (row 0) beyond 90 degrees on
    linear[:, np.logical_or.accumulate(np.abs(linear[0]) > MAX_SHOWN_ATTITUDE)] = np.nan
    ends = tuple(
        _release_time(plant, wind, times, outputs, limit) if holds and survivor else np.inf
        for outputs, survivor in ((rows, survived), (linear, predicted))
    )
    is_linear = not beyond_linear(float(wind.peak))
    return FlightComparison(
        times=times,
        flown=rows,
        linear=linear,
        wind=wind,
        survived=survived if is_linear else None,
        predicted=predicted if is_linear else None,
        let_go=(ends[0], ends[1]),
    )


def _release_time(
    plant: Plant, wind: History, times: FloatArray, rows: FloatArray, limit: float
) -> float:
    """Return the time [s] at which the report's control releases its limit, infinite for none.

    It does so where the attitude is zero again, if the flight has ended at the limit: the held
    limit would turn the vehicle over to the other side. `times`: times of the flight [s], ``(n,)``.
    `rows`: its outputs [rad, rad/s], ``(5, n)``, attitude first and deflection last, which are set
    to NaN after the release. `limit`: deflection limit [rad]. `plant`, `wind`: of the flight.
    """
    finite = np.flatnonzero(np.isfinite(rows[0]))
    if not finite.size or abs(rows[-1, finite[-1]]) < limit * (1.0 - _LIMIT_TOLERANCE):
        return np.inf
    when = release_time(plant, wind, times, rows[0])
    rows[:, times > when] = np.nan
    return when


def _linear(
    plant: Plant, control: ReportControl | Law, wind: History, times: FloatArray, limit: float
) -> FloatArray:
    """Return the `OUTPUTS` of the linear flight at n times [s], in rad and rad/s, ``(5, n)``.

    The report's control is exact, a law sampled. `plant`: linear model of one vehicle. `control`:
    the report's control, or a law. `limit`: deflection limit [rad].
    """
    if isinstance(control, ReportControl):
        # trim opposes the wind; B, the ratio of trim deflection to angle of attack, may be negative
        sign = -float(np.sign(plant.coefficients.B * wind.peak))
        deflection = trim_then_hold(plant, wind, sign * limit, control.dead_band, "literal")
        outputs = attitude_responses(plant, deflection, wind, times)
        return np.stack([*(outputs[name] for name in OUTPUTS[:-1]), deflection(times)])
    nozzle: dict[str, Any] = {"deflection_limit": limit, "sample_rate": SAMPLE_RATE}
    flown = flight_responses(plant, control, wind, times, **nozzle)
    return np.stack([flown[name] for name in OUTPUTS])


@dataclass(frozen=True, eq=False)
class SampledFlight(FlightComparison):
    """Sampled flight of a law with the limits of the nozzle; `linear` is the rigid vehicle.

    For a rigid plant both are equal. `status`: status of both in `FlownCases`, flown and rigid.
    `peak_rates`: largest nozzle rate [rad/s] of both, a mean over a sample.
    """

    status: tuple[str, str]
    peak_rates: tuple[float, float]

    ranges = (MAX_ATTITUDE, MAX_ATTITUDE)

    def in_unknown_wind(self) -> Self:
        """Return the comparison where parts of the wind are not known, with status and outcome."""
        flown, rigid = (NOT_KNOWN if x == SURVIVED else x for x in self.status)
        return replace(super().in_unknown_wind(), status=(flown, rigid))

    @property
    def outcomes(self) -> tuple[str, str]:
        """Outcomes of the flight and of the rigid vehicle's flight, in words."""
        return OUTCOME_WORDS[self.status[0]], OUTCOME_WORDS[self.status[1]]

    @property
    def largest(self) -> dict[str, tuple[float, float]]:
        """Peaks of both flights [rad, rad/s], by the label of their row, and of the nozzle rate."""
        return super().largest | {"largest rate of the nozzle [deg/s]": self.peak_rates}


def fly_sampled(
    plant: AnyPlant, law: Law, wind: History, timepts: ArrayLike, **nozzle: Any
) -> SampledFlight:
    """Return a sampled flight of a law and its outcome, for a vehicle and for the rigid vehicle.

    `linear`, `predicted` and the second entries of pairs are of the rigid vehicle's flight.

    `plant`: one plant; its rigid one is flown too. `wind`: one wind that ends. `timepts`: times
    [s], ``(n,)``. `nozzle`: deflection_limit, rate_limit, actuator, sample_rate and delay of `fly`,
    with its exceptions.
    """
    plants = (plant, plant.rigid)
    cases: list[FlownCases] = [fly_many(p, law, wind, **nozzle) for p in plants]
    beyond = beyond_linear(float(wind.peak))
    status = [NOT_KNOWN if beyond else str(case.status) for case in cases]
    times = np.asarray(timepts, dtype=float)
    rows = [_rows(p, law, wind, times, nozzle) for p in plants]
    return SampledFlight(
        times=times,
        flown=rows[0],
        linear=rows[1],
        wind=wind,
        survived=None if beyond else status[0] == SURVIVED,
        predicted=None if beyond else status[1] == SURVIVED,
        let_go=(np.inf, np.inf),  # a law, unlike the report's control, holds no limit for ever
        status=(status[0], status[1]),
        peak_rates=(float(cases[0].peak_deflection_rate), float(cases[1].peak_deflection_rate)),
    )


def _rows(
    plant: AnyPlant, law: Law, wind: History, times: FloatArray, nozzle: dict[str, Any]
) -> FloatArray:
    """Return the `OUTPUTS` of a sampled flight [rad, rad/s], ``(5, n)``.

    They are NaN from the first attitude beyond the model's range on. `times`: times [s], ``(n,)``.
    `nozzle`: arguments of `fly` after the times.
    """
    flown, zeros = flight_responses(plant, law, wind, times, **nozzle), np.zeros(times.size)
    available = (*plant.outputs, "deflection")  # a model with a fixed path has no path angle
    rows = np.stack([flown[name] if name in available else zeros for name in OUTPUTS])
    beyond = np.flatnonzero(np.abs(rows[0]) > MAX_ATTITUDE)
    rows[:, beyond[0] if beyond.size else times.size :] = np.nan
    return rows
