"""Gains, filters and notches over the flight, scheduled on one of its variables.

`flight_autopilot` schedules a specified autopilot along a flight.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.schedule import VARIABLES, FlightSchedule, flight_variable
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Column, Columns, Tabled, columns_of
from tvclin.base.errors import InputError, callable_for, each, finite, instance, one_of, times_row
from tvclin.base.fields import array_table, spec
from tvclin.base.lines import Table
from tvclin.base.units import si_unit
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.autopilot import Autopilot, warn_of_feedback
from tvclin.control.autopilot.design_rules import LEAST_NOZZLE, AutopilotDesign
from tvclin.control.autopilot.feedback import CHAINS, GAINS
from tvclin.control.autopilot.gain_table import (
    GAIN_COLUMNS,
    NOTCH_NUMBERS,
    GainTable,
    ModeNotch,
    gain_columns,
)
from tvclin.control.margins.margins import Margins, loop_margins
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.filters import Filter

_MAX_INTERPOLATED_ORDER = 2
"""Highest order of a filter over the flight: between two stable denominators of second order every
one on the straight line is stable, of a higher order not."""
_SHOWN_PAIRS = 5
"""Number of pairs of times in a table, those that differ most."""


@dataclass(frozen=True, eq=False)
class GainSchedule:
    """Autopilot over the flight, straight lines between breakpoints of one variable of the flight.

    Attributes
    ----------
    breakpoints : ndarray
        Values of the variable, rising, ``(n,)``, in SI units.
    autopilot : Autopilot
        Autopilot with gains, delay, filters and actuator at the breakpoints, ``(n,)`` or ``()``.
        Filters are interpolated by their coefficients, denominators beginning with one.
    variable : str
        Variable of the flight, one of time [s], speed [m/s], altitude [m], mach, and
        dynamic_pressure [Pa]; see `flight_variable`.
    notches : tuple of ModeNotch
        Notches that follow a mode, behind the filters of the autopilot; their numbers are constant
        or at the breakpoints, ``(n,)``.

    Raises
    ------
    InputError
        For breakpoints that do not rise, fewer than two, an autopilot or a notch of another shape,
        and filters that change over the flight with an order above two.
    """

    breakpoints: FloatArray
    autopilot: Autopilot
    variable: str = "time"
    notches: tuple[ModeNotch, ...] = ()

    def __post_init__(self) -> None:
        """Check that breakpoints rise, and that numbers are constant or one for each of them."""
        one_of("variable", self.variable, VARIABLES)
        points = finite("breakpoints", self.breakpoints)
        if points.ndim != 1 or points.size < 2 or np.any(np.diff(points) <= 0.0):
            raise InputError(
                f"breakpoints must be two or more rising values of {self.variable}: take a part of"
                " the flight in which it rises"
            )
        instance("autopilot", self.autopilot, Autopilot, "whose gains are one for each breakpoint")
        if self.autopilot.batch not in {(), points.shape}:
            raise InputError(
                f"autopilot must have one gain for each of the {points.size} breakpoints; got a"
                f" batch of shape {self.autopilot.batch}"
            )
        for name in CHAINS:
            for filter_ in getattr(self.autopilot, name):
                if filter_.batch and filter_.order > _MAX_INTERPOLATED_ORDER:
                    raise InputError(
                        f"{name} that change over the flight must be of order"
                        f" {_MAX_INTERPOLATED_ORDER} at most, as what lies between two stable ones"
                        f" may be unstable; got order {filter_.order} (take several in series)"
                    )
        notches = each("notches", self.notches, ModeNotch, "ModeNotch(mode=...)")
        for notch in notches:
            if notch.batch not in {(), points.shape}:
                raise InputError(
                    f"the notch at {notch.mode} must have one number for each of the {points.size}"
                    f" breakpoints; got a batch of shape {notch.batch}"
                )
        object.__setattr__(self, "notches", notches)
        object.__setattr__(self, "breakpoints", points)

    @classmethod
    def design(
        cls,
        breakpoints: ArrayLike,
        coefficients: Coefficients,
        rule: Callable[..., Autopilot],
        variable: str = "time",
        **arguments: Any,
    ) -> Self:
        """Return the schedule of gains that a design rule gives at each breakpoint.

        Parameters
        ----------
        breakpoints : array_like
            Values of the variable of the flight, rising, ``(n,)``; see `flight_variable`.
        coefficients : Coefficients
            Coefficients of the vehicle at each of them, ``(n,)``.
        rule : callable
            Function from coefficients to an autopilot, such as `design_gains`.
        variable : str
            Name of the variable.
        **arguments
            Arguments of the rule.

        Examples
        --------
        >>> import tvclin as tv
        >>> c = tv.Coefficients(mu_alpha=[0.1, 0.28, 0.2], mu_delta=[2.0, 2.6, 3.0])
        >>> rule = {"natural_frequency": 1.0, "damping": 0.7}
        >>> times = [40.0, 66.0, 90.0]
        >>> schedule = tv.control.GainSchedule.design(times, c, tv.design_gains, **rule)
        >>> round(schedule.at(53.0).attitude_gain, 4)
        0.5212
        >>> schedule.margins(tv.Plant.from_coefficients(c)).stable.all().item()
        True
        """
        callable_for("rule", rule, "from coefficients to an Autopilot, such as design_gains")
        points = finite("breakpoints", breakpoints)
        return cls(points, rule(coefficients, **arguments), variable)

    def at(self, value: ArrayLike) -> Autopilot:
        """Return the autopilot at one or several values of the variable of the flight, in SI units.

        `InputError` for a value outside the breakpoints, as gains are not extrapolated, and for a
        schedule with notches that follow a mode, see `along`.
        """
        if self.notches:
            raise InputError(
                "a notch that follows a mode is known along a flight alone; see along(flight, time)"
            )
        values = finite("value", value)
        low, high = self.breakpoints[[0, -1]]
        outside = (values < low) | (values > high)
        if np.any(outside):
            raise InputError(
                f"{self.variable} must lie in the schedule, {low:.6g} to {high:.6g}; got"
                f" {values[outside].ravel()[0]:.6g}"
            )
        return self._interpolated(values)

    def along(self, flight: FlightSchedule, time: ArrayLike) -> Autopilot:
        """Return the autopilot at times of a flight [s], of their shape.

        Before the first and after the last breakpoint it is constant. The actuator of a flight that
        has one over time takes the place of the autopilot's. `InputError` for times outside the
        flight, and a flight without the variable or the mode of a notch.
        """
        instance("flight", flight, FlightSchedule, "see load_schedule")
        values = flight_variable(flight, self.variable, time)
        autopilot = self._interpolated(values)
        filters = autopilot.filters
        for notch in self.notches:
            numbers = {
                name: self._at_values(getattr(notch, name), values) for name in NOTCH_NUMBERS
            }
            filters = (*filters, replace(notch, **numbers).at(flight, time))
        return with_actuator_of(replace(autopilot, filters=filters), flight, time)

    def to_csv(self, path: Path | None = None) -> str:
        """Return the gains as the CSV table of a study file, and write it where a path is given.

        It is what `schedule` in [autopilot] reads; delay, filters, notches and sample rate stand in
        the study file itself. `InputError` when the file cannot be written.
        """
        gains = {name: getattr(self.autopilot, name) for name in GAINS}
        return gain_columns(self.variable, self.breakpoints, gains).csv(path)

    def margins(self, plants: Plant) -> Margins:
        """Return the margins at every breakpoint, of plants at these, ``(n,)``.

        It warns of zero gains, positive feedback and a slow actuator, as `Autopilot.loop` does.
        """
        loop = self.autopilot.exact_loop(plants)
        warn_of_feedback(self.autopilot, plants)
        return loop_margins(loop)

    def _interpolated(self, values: FloatArray) -> Autopilot:
        """Return the autopilot at `values` of the variable, of their shape, without mode notches.

        Between breakpoints by straight lines; constant outside them.
        """
        autopilot = self.autopilot
        changes: dict[str, Any] = {
            name: self._at_values(getattr(autopilot, name), values)
            for name in (*GAINS, "delay", "sample_rate")
        }
        for name in CHAINS:
            chain = getattr(autopilot, name)
            changes[name] = tuple(self._filter(filter_, values) for filter_ in chain)
        actuator = autopilot.actuator
        if actuator is not None and actuator.batch:
            changes["actuator"] = Actuator(
                natural_frequency=self._at_values(actuator.natural_frequency, values),
                damping=self._at_values(actuator.damping, values),
            )
        return replace(autopilot, **changes)

    def _at_values(self, numbers: Any, values: FloatArray) -> Any:
        """Return numbers ``(n,)`` at the breakpoints interpolated to `values` of the variable.

        A constant, or None, is returned unchanged.
        """
        return numbers if np.ndim(numbers) == 0 else np.interp(values, self.breakpoints, numbers)

    def _filter(self, filter_: Filter, values: FloatArray) -> Filter:
        """Return a filter at `values` of the variable, interpolated by its coefficients.

        `filter_`: a batch ``(n,)`` of filters at the breakpoints, or a constant one, which is
        returned unchanged.
        """
        if not filter_.batch:
            return filter_
        numerator, denominator = (
            np.stack([self._at_values(column, values) for column in coefficients.T], axis=-1)
            for coefficients in (filter_.numerator, filter_.denominator)  # (n, order + 1)
        )
        return Filter(numerator, denominator)


def autopilot_along(
    autopilot: Autopilot | GainSchedule, flight: FlightSchedule, time: FloatArray
) -> Autopilot:
    """Return the autopilot, constant or of a schedule, at times of a flight [s] ``(n,)``.

    The actuator of a flight that has one over time takes the place of the autopilot's.
    """
    if isinstance(autopilot, GainSchedule):
        return autopilot.along(flight, time)
    instance("autopilot", autopilot, Autopilot, "or a GainSchedule")
    return with_actuator_of(autopilot, flight, time)


def gains_along(
    autopilot: Autopilot | GainSchedule, flight: FlightSchedule, time: FloatArray
) -> dict[str, FloatArray]:
    """Return all gains of an autopilot at times [s] of a flight, by name, ``(n,)`` each."""
    if not isinstance(autopilot, GainSchedule):
        return {name: np.full(time.shape, getattr(autopilot, name)) for name in GAINS}
    values = flight_variable(flight, autopilot.variable, time)
    at_breakpoints = autopilot.autopilot  # each gain an array over these, or constant
    return {
        name: np.broadcast_to(
            autopilot._at_values(getattr(at_breakpoints, name), values), time.shape
        )
        for name in GAINS
    }


def constant_gains_notes(
    schedule: GainSchedule, flight: FlightSchedule, times: FloatArray
) -> Iterator[str]:
    """Yield a note if gains are constant at some times of a flight, outside the breakpoints.

    `times`: times of the flight [s], ``(n,)``.
    """
    values = flight_variable(flight, schedule.variable, times)
    low, high = schedule.breakpoints[[0, -1]]
    outside = times[(values < low) | (values > high)]
    if outside.size:
        unit = si_unit(GAIN_COLUMNS.quantities[schedule.variable])
        span = f"{low:.6g} to {high:.6g} {unit}".rstrip()
        yield (
            f"gains are given for {schedule.variable.replace('_', ' ')} {span} and constant beyond,"
            f" at {outside.size} of {times.size} flight times: the first {outside[0]:.6g} s, the"
            f" last {outside[-1]:.6g} s"
        )


def with_actuator_of(autopilot: Autopilot, flight: FlightSchedule, time: ArrayLike) -> Autopilot:
    """Return the autopilot with the actuator of a flight at times [s], if the flight has one."""
    actuator = flight_actuator(flight, time)
    return autopilot if actuator is None else replace(autopilot, actuator=actuator)


def flight_actuator(flight: FlightSchedule, time: ArrayLike) -> Actuator | None:
    """Return the actuator that a flight has at times [s]; None if its file has no actuator.

    Before and after the flight it is constant.
    """
    frequency_and_damping = flight.actuator_at(time)
    if frequency_and_damping is None:
        return None
    natural_frequency, damping = frequency_and_damping
    return Actuator(natural_frequency=natural_frequency, damping=damping)


@dataclass(frozen=True, eq=False)
class EqualValues(Tabled):
    """Pairs of times at which a variable of the flight has one value, and their gains.

    A schedule on this variable has one autopilot for both.

    Attributes
    ----------
    variable : str
        Name of the variable.
    value : ndarray
        Value of the variable, ``(k,)``.
    first_time, second_time : ndarray
        Times of flight [s], ``(k,)``.
    attitude_gain_ratio, rate_gain_ratio : ndarray
        Gain at the second time over that at the first, ``(k,)``.
    """

    variable: str = field(metadata=spec())
    value: FloatArray = field(metadata=spec())
    first_time: FloatArray = field(metadata=spec("time"))
    second_time: FloatArray = field(metadata=spec("time"))
    attitude_gain_ratio: FloatArray = field(metadata=spec())
    rate_gain_ratio: FloatArray = field(metadata=spec())

    @property
    def difference(self) -> FloatArray:
        """Relative difference of the gains at the two times of each of k pairs, ``(k,)``.

        It is ``|ln(ratio)|`` of attitude or rate gain, the larger; a gain that is zero at both
        times does not count.
        """
        ratios = np.stack([self.attitude_gain_ratio, self.rate_gain_ratio])
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.nanmax(np.abs(np.log(np.abs(ratios))), axis=0, initial=0.0))

    def table(self) -> Table:
        """Return the table of the five pairs of times whose gains differ most.

        At both times of a pair the variable of the flight has the same value.
        """
        caption = "Times of one value, and the ratio of the gains there"
        largest = np.argsort(-self.difference, kind="stable")[:_SHOWN_PAIRS]
        table = array_table(caption, "equal", self, *_PAIR_FIELDS, rows=largest.tolist())
        _, *headings = table.head  # the first column is headed by the variable
        return replace(table, head=(self.variable, *headings))

    def _columns(self) -> Columns:
        """Return pairs of flight times with equal values of the variable as columns of a CSV."""
        pairs = Column("pair", np.arange(1, self.value.size + 1), "")
        return Columns((pairs,), columns_of(self, *_PAIR_FIELDS), {"variable": self.variable})


_PAIR_FIELDS = ("value", "first_time", "second_time", "attitude_gain_ratio", "rate_gain_ratio")
"""Fields of a pair in `EqualValues`."""


def equal_values(
    flight: FlightSchedule, variable: str, times: ArrayLike, autopilot: Autopilot
) -> EqualValues:
    """Return the pairs of times at which a variable has one value, with the ratio of the gains.

    Parameters
    ----------
    flight : FlightSchedule
        The flight.
    variable : str
        Scheduling variable, as in `flight_variable`.
    times : array_like
        Times of flight [s], rising, ``(n,)``.
    autopilot : Autopilot
        Autopilot that each time needs, ``(n,)``, as a design rule gives it.

    Returns
    -------
    EqualValues
        A pair for each time and each later crossing of its value, between times by straight lines;
        none for a variable that is monotonic.

    Raises
    ------
    InputError
        For times that do not rise or lie outside the flight, and gains of another shape.
    """
    time = times_row("times", times)
    if time.size < 2 or np.any(np.diff(time) <= 0.0):
        raise InputError("times must be two or more rising times of flight in s")
    instance("autopilot", autopilot, Autopilot, "whose gains are one for each time")
    if autopilot.batch not in {(), time.shape}:
        raise InputError(
            f"autopilot must have one gain for each of the {time.size} times; got a batch of shape"
            f" {autopilot.batch}"
        )
    values = flight_variable(flight, variable, time)
    # A row is the first time of a pair; a later sign change or zero in it is the second.
    distance = values - values[:, np.newaxis]  # of the value at column j from that at row i
    crosses = (distance[:, :-1] * distance[:, 1:] < 0.0) | (distance[:, 1:] == 0.0)
    first, later = np.nonzero(np.triu(crosses, 1))
    fraction = distance[first, later] / (distance[first, later] - distance[first, later + 1])
    second_time = time[later] + fraction * (time[later + 1] - time[later])
    ratios = {}
    for name in ("attitude_gain", "rate_gain"):
        gains = np.broadcast_to(getattr(autopilot, name), time.shape)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios[f"{name}_ratio"] = np.interp(second_time, time, gains) / gains[first]
    return EqualValues(variable, values[first], time[first], second_time, **ratios)


def even_times(first: float, last: float, every: float) -> FloatArray:
    """Return the times `first`, `first` + `every`, ..., and `last` of a flight [s], ``(n,)``.

    A time within 1e-9 of a step before `last` is omitted: `last` stands for it.
    """
    count = int(np.ceil((last - first) / every - 1e-9))
    return np.append(first + every * np.arange(count), last)


def flight_autopilot(
    design: AutopilotDesign,
    flight: FlightSchedule,
    times: FloatArray,
    *,
    actuator: Actuator | None,
    model: str,
    plane: str,
) -> GainSchedule:
    """Return the schedule of a specified autopilot along a flight.

    Parameters
    ----------
    design : AutopilotDesign
        Gains over the flight, constant gains, or a rule, which is applied to the rigid vehicle at
        each of the times.
    flight : FlightSchedule
        The flight.
    times : ndarray
        Times of flight [s], rising, ``(n,)``, two or more: breakpoints of a rule.
    actuator : Actuator, optional
        Actuator of the nozzle; the actuator of a flight that has one over time takes its place.
    model, plane
        Model and plane of the plants.

    Raises
    ------
    InputError
        For a rule that needs a wind, gains both over the flight and constant, and as
        `GainSchedule`.
    """
    table = design.schedule or GainTable()
    constant = replace(design, schedule=None)
    if table.gains:
        if not constant.unspecified:
            raise InputError("give a schedule of gains, or gains or a rule for them, not both")
        return _tabulated(table, constant, actuator)
    if design.design == LEAST_NOZZLE:
        raise InputError(
            f"design {LEAST_NOZZLE} is of one flight time: give --at, or a table of its gains, see"
            " minimum_gain_schedule in Python"
        )
    plants = flight.plants(times, model, plane)
    designed = [
        constant.autopilot(plants.case(k, plants.batch), actuator) for k in range(len(times))
    ]
    gains: dict[str, Any] = {name: np.array([getattr(a, name) for a in designed]) for name in GAINS}
    # all but the gains is the same at all times
    return GainSchedule(np.asarray(times), replace(designed[0], **gains), notches=table.notches)


def design_at(design: AutopilotDesign, flight: FlightSchedule, time: float) -> AutopilotDesign:
    """Return the specification at one time of a flight [s], with constant gains and filters.

    `design`: specification, perhaps with gains, filters or notches over the flight.
    """
    table = design.schedule
    if table is None:
        return design
    constant = replace(design, schedule=None)
    if not table.gains:  # then the table has only notches at modes
        notches = tuple(notch.at(flight, time) for notch in table.notches)
        return replace(constant, filters=(*design.filters, *notches))
    autopilot = _tabulated(table, constant, actuator=None).along(flight, time)
    return replace(constant, **{k: getattr(autopilot, k) for k in (*table.gains, *CHAINS)})


def _tabulated(
    table: GainTable, constant: AutopilotDesign, actuator: Actuator | None
) -> GainSchedule:
    """Return the schedule of a table of gains over the flight, with the constants of an autopilot.

    `table`: gains, filters and notches at breakpoints of a variable of the flight; its gains
    replace constant ones, its filters stand behind constant ones. `constant`: specification of
    delay, filters and sample rate. `actuator`: actuator, or None.
    """
    arguments = constant.options(actuator) | table.gains
    for name in CHAINS:  # filters of the sum, the attitude and the rate
        arguments[name] = (*arguments[name], *table.chains.get(name, ()))
    autopilot = Autopilot(**arguments)
    return GainSchedule(table.breakpoints, autopilot, table.variable, table.notches)
