"""Flights of an autopilot along a flight whose vehicle, structure and gains vary with time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.measured_wind import MeasuredWind
from tvclin.ascent.schedule import FlightSchedule, flight_variable
from tvclin.ascent.wind_along import WindAlong, wind_along
from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Column, Columns, Tabled, table
from tvclin.base.fields import Field, spec
from tvclin.base.lines import Line, Table, significant
from tvclin.base.units import si_unit
from tvclin.control.autopilot.autopilot import Autopilot, require_pade
from tvclin.control.autopilot.gain_schedule import GainSchedule
from tvclin.control.autopilot.wiring import closed_loop
from tvclin.control.turbulence.driven_loop import OUTPUT_KINDS
from tvclin.flights.closed_loop.checks import check_rate_limit, check_samples
from tvclin.flights.closed_loop.flown_flights import (
    FlownFlight,
    FlownFlights,
    checked_flight,
    flown_in_winds,
    fly_together,
    stages_in_parts,
)
from tvclin.flights.closed_loop.fly_many import UNDECIDED, FlownCases
from tvclin.kernels.flight_arrays import Flights
from tvclin.linear.plant import DEFAULT_MODEL
from tvclin.linear.system import LinearSystem, connect, constant_over_steps, polynomial_input
from tvclin.numerics.pieces import polynomial_pieces, recentred
from tvclin.numerics.propagation import GAUSS_NODES
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import FROZEN, SIGNS

_CONTINUOUS_STEP = 0.02
"""Longest step of a continuous loop [s]."""
UNLIMITED = "not judged"
"""Status of a flight of a continuous loop, which has no limits."""
OUTSIDE = "outside"
"""Status of a flight in both planes that returns, with a deflection outside the limit shape."""
_REASONS = {
    "survived": "after the wind, or over the last seconds in it, the unstable modes stay settled",
    "lost": "the unstable modes leave the set from which the deflection limit can return them",
    "rings": "the vehicle returns, and the loop keeps oscillating at the end of the flight",
    OUTSIDE: "NOT KNOWN: the nozzle overshoots the limit shape, which limits its commands alone",
    "undecided": "NOT KNOWN: the unstable modes are not settled at the end, or no mode is unstable",
    UNLIMITED: "NOT KNOWN: a continuous loop is flown without limits",
}


class Largest(NamedTuple):
    """Value of largest size of an output, with its sign, in SI units, and its time [s]."""

    value: float
    time: float


@dataclass(frozen=True, eq=False)
class FlightAlong(Tabled):
    """Outputs of a loop along a flight through a wind.

    Attributes
    ----------
    times : ndarray
        Times of flight [s], ``(n,)``: the samples of the autopilot, or the steps of a continuous
        one.
    outputs : dict of str to ndarray
        Outputs by name, ``(n,)``: wind, attitude, flight_path_angle, angle_of_attack [rad],
        attitude_rate [rad/s], deflection [rad], deflection_rate [rad/s]; pressure_ratio q/q_n;
        lateral drift [m] where the model has a flight path; q_alpha [Pa rad] where the altitude is
        known; bending_moment [N m] on request; the displacement of each mode and tank by its name.
    status : str
        Status as in `FlownCases`; "not judged" for a continuous loop, and "outside" in both planes
        where the flight would survive with a nozzle that overshoots the limit shape.
    planes : dict of str to FlightAlong
        Flights in pitch and yaw of a flight in both planes, each with the common status; empty for
        one plane. In both planes outputs are magnitudes of vectors, the deflection is in the
        measure of the limit shape, and the deflection rate is the larger of both planes.
    """

    times: FloatArray = field(metadata=spec("time"))
    outputs: dict[str, FloatArray]
    status: str = field(metadata=spec())
    planes: dict[str, FlightAlong] = field(default_factory=dict)

    @property
    def reason(self) -> str:
        """Meaning of the status, in words."""
        return _REASONS[self.status]

    @property
    def units(self) -> dict[str, str]:
        """SI unit of each output; empty for modes and tanks."""
        return {name: si_unit(_KINDS.get(name, "number")) for name in self.outputs}

    @property
    def mode_names(self) -> tuple[str, ...]:
        """Names of the modes and tanks among the outputs."""
        return tuple(name for name in self.outputs if name not in _KINDS)

    def largest(self, output: str) -> Largest:
        """Return the value of largest size of an output, at `times`, and its time.

        Parameters
        ----------
        output : str
            Name in `outputs`, such as "deflection".

        Raises
        ------
        InputError
            For an unknown output.
        """
        values = self.outputs[errors.one_of("output", output, tuple(self.outputs))]
        at = int(np.argmax(np.abs(values)))
        return Largest(float(values[at]), float(self.times[at]))

    def table(self) -> Table:
        """Return the table of the largest value of each output and its time, angles in degrees."""
        rows: list[tuple[Line, ...]] = []
        for name in self.outputs:
            item = Field(name, _KINDS.get(name, "number"), significant=5)
            value, time = self.largest(name)
            shown = item.cell_of(f"along.{name}", value)
            rows.append(((item.title,), shown, significant(f"along.{name}.s", time)))
        return Table(f"Largest values, {self.status}", ("output", "largest", "at [s]"), tuple(rows))

    def _repr_html_(self) -> str:
        """Return the table of the largest values in HTML, for a notebook."""
        return table(self.table(), ((self.reason,),))

    def _columns(self) -> Columns:
        """Return times and outputs as columns with units, for a file."""
        axis = Column("time", self.times, "s")
        columns = tuple(
            Column(name.replace(" ", "_"), values, self.units[name])
            for name, values in self.outputs.items()
        )
        return Columns((axis,), columns, {"status": self.status})


def fly_along(
    flight: FlightSchedule,
    autopilot: Autopilot | GainSchedule,
    wind: History | MeasuredWind,
    *,
    deflection_limit: float | None = None,
    rate_limit: float = np.inf,
    sign: str | None = None,
    gust_time: float | None = None,
    start: float | None = None,
    stop: float | None = None,
    model: str = DEFAULT_MODEL,
    plane: str = "pitch",
    alpha_moment: ArrayLike | None = None,
    deflection_moment: ArrayLike = 0.0,
) -> FlightAlong:
    """Return the outputs of an autopilot along a flight through a wind, from equilibrium.

    Parameters
    ----------
    flight : FlightSchedule
        Flight, with its structure and actuator where it has them.
    autopilot : Autopilot or GainSchedule
        Autopilot with its actuator, delay, filters and sample rate. Without a sample rate the loop
        is continuous and has no limits; its delay is a Pade approximation.
    wind : History or MeasuredWind
        One wind angle of attack [rad] over the time of flight, such as a pulse or a gust, or the
        wind of `fly_through`, without its window.
    deflection_limit, rate_limit : float
        Deflection limit [rad], within 90 degrees, and rate limit [rad/s], positive; of a sampled
        autopilot, which needs a deflection limit.
    sign : {"head", "tail", "frozen"}, optional
        Direction of the largest angle of a history in the pitch plane, for the dynamic pressure
        encountered: by default a head wind, whatever the sign of the angle. In the yaw plane a
        history is a cross wind, and a sounding has its own direction. "frozen" is the nominal
        dynamic pressure.
    gust_time : float, optional
        Time of flight [s] of the gust of a sounding.
    start, stop : float, optional
        Ends of the flight [s], by default those of the schedule, or of the sounding within it. By
        default a flight that is not decided at the end of the schedule goes on until it can settle
        after its wind, with vehicle and autopilot frozen as they are then.
    model : {"fixed-path", "drift", "drift-exact", "drift-and-speed"}
        Model of the motion; "drift" without a structure alone.
    plane : {"pitch", "yaw"}
        Plane of the motion.
    alpha_moment, deflection_moment : array_like, optional
        Slopes of a bending moment over angle of attack and deflection [N m/rad], one or one for
        each time of the schedule.

    Raises
    ------
    InputError
        For times outside the flight or the sounding, a delay that varies, limits of a continuous
        loop or none of a sampled one, a path on which no horizontal wind has the angle, the sign of
        a sounding, a Pade approximation with another number of unstable poles than the exact delay,
        and in the same cases as `fly_many`.

    Notes
    -----
    All quantities are deviations from the nominal flight. Normal and axial force, `alpha_moment`
    and q_alpha are those of the dynamic pressure encountered in the wind, by the wind triangle; a
    schedule of gains follows the nominal flight. Motions in a head wind with all angles reversed
    are the same, so that the wind keeps the sign of its angles.

    Between samples the motion is that of `fly_many`, with the matrices that equal the varying ones
    over each sample to fourth order: exact for bending and actuator, and for a constant vehicle.
    Between breakpoints of flight and wind they are interpolated from Chebyshev points, to 1e-12; in
    a sounding between those of the flight, in time and in dynamic pressure.
    Knots of the wind within a sample act on the vehicle of its middle. The states of a filter that
    varies are those of `Filter.matrices`, and stay where its coefficients change. The drift is the
    integral of speed times path angle by the trapezoidal rule.

    A flight is judged after its wind as in `fly_many`, by the recoverable set of the vehicle frozen
    at each sample; in a wind that lasts to the end, over the settling time before it.
    """
    if getattr(wind, "batch", ()):
        raise errors.InputError("wind must be one wind; see fly_many_along for many")
    wind_of_flight = wind_along(flight, wind, plane, sign, gust_time)
    along = checked_flight(flight, autopilot, wind_of_flight, start, stop, model, plane)
    slopes: dict[str, FloatArray] = {}
    if alpha_moment is not None:
        slopes["alpha_moment"] = _moment_slope(flight, "alpha_moment", alpha_moment)
        slopes["deflection_moment"] = _moment_slope(flight, "deflection_moment", deflection_moment)
    max_rate = check_rate_limit(rate_limit)
    if along.law.sample_rate is None:
        if deflection_limit is not None or np.isfinite(max_rate):
            raise errors.InputError("limits need samples: give the autopilot a sample_rate")
        return with_outputs(along, *_continuous(along), UNLIMITED, slopes)
    if deflection_limit is None:
        raise errors.InputError(
            "deflection_limit must be given for an autopilot with a sample_rate"
        )
    limit = errors.limit_angle(deflection_limit)
    return next(sampled_outputs([along], limit, max_rate, slopes))


def sampled_outputs(
    flights: Sequence[FlownFlight],
    limit: float,
    rate_limit: float,
    slopes: Mapping[str, FloatArray] | None = None,
) -> Iterator[FlightAlong]:
    """Yield the outputs of sampled flights with one model and autopilot, in their order.

    Their stages, the matrices of the loop at each sample with the winds, are computed together. A
    flight that is undecided at its end is flown again as `FlownFlight.further`, with a later end,
    if it can go on. `limit`, `rate_limit`: limits of deflection [rad] and rate [rad/s]. `slopes`:
    alpha_moment and deflection_moment [N m/rad] at the times of the schedule; with them the bending
    moment is an output.
    """
    for part, stages in stages_in_parts(flights):
        flown: list[FlightAlong | None] = []
        further: list[FlownFlight] = []
        for k, along in enumerate(flights[part]):
            # wind k of the stages is that of flight k
            outcome, records = flown_in_winds(
                stages, np.array([k]), np.array([limit]), np.array([rate_limit]), track=True
            )
            status = str(outcome.status[0])
            if status == UNDECIDED and along.further is not None:
                further.append(along.further)
                flown.append(None)
                continue
            states = tracked_states(records, limit)
            flown.append(with_outputs(along, *states, status, slopes or {}))
        # undecided flights again, with later ends, each in its place
        continued = sampled_outputs(further, limit, rate_limit, slopes)
        yield from (next(continued) if made is None else made for made in flown)


_KINDS = {"wind": "angle", "pressure_ratio": "number", **OUTPUT_KINDS}
"""Kinds of the outputs; displacements of modes and tanks are in their normalisation."""


def fly_many_along(
    flight: FlightSchedule,
    autopilot: Autopilot | GainSchedule,
    wind: History | Sequence[MeasuredWind],
    *,
    deflection_limit: ArrayLike,
    rate_limit: ArrayLike = np.inf,
    sign: str | None = None,
    start: float | None = None,
    stop: float | None = None,
    model: str = DEFAULT_MODEL,
    plane: str = "pitch",
) -> FlownCases:
    """Return the outcomes of many flights of a sampled autopilot along one flight.

    Parameters
    ----------
    flight, autopilot, sign, start, stop, model, plane
        Same as in `fly_along`; the autopilot has a sample rate.
    wind : History or sequence of MeasuredWind
        One wind or a batch, over the time of flight, or soundings without a gust.
    deflection_limit, rate_limit : array_like
        Deflection limits [rad] and rate limits [rad/s], positive; they broadcast with the winds.

    Returns
    -------
    FlownCases
        Peaks at samples and outcomes, of the shape of winds and limits.

    Raises
    ------
    InputError
        Same as `fly_along`.
    """
    limit = errors.small_angle("a deflection", errors.positive)(
        "deflection_limit", deflection_limit
    )
    rate = errors.numbers("rate_limit", rate_limit)
    if not np.all(rate > 0.0):
        raise errors.InputError("rate_limit must be positive")
    winds, batch = _winds_along(flight, wind, plane, sign)
    shape = errors.broadcast(wind=batch, deflection_limit=limit.shape, rate_limit=rate.shape)
    if not int(np.prod(shape)):
        raise errors.InputError("there must be a wind and a limit or more; got none")
    which = np.broadcast_to(np.arange(int(np.prod(batch))).reshape(batch), shape).ravel()
    limits, rates = (np.array(np.broadcast_to(a, shape)).ravel() for a in (limit, rate))
    flights = [checked_flight(flight, autopilot, w, start, stop, model, plane) for w in winds]
    flown = fly_together(flights, which, limits, rates)
    return FlownCases(**{name: values.reshape(shape) for name, values in vars(flown).items()})


def _winds_along(
    flight: FlightSchedule, wind: Any, plane: str, sign: str | None
) -> tuple[list[WindAlong], tuple[int, ...]]:
    """Return the winds along a flight with their dynamic pressure, and the shape of their batch.

    `wind`: a history or a batch of histories, or soundings. `plane`: plane of the motion. `sign`:
    "head", "tail" or "frozen", see `fly_along`: at nominal pressure all winds are one batch.
    """
    if sign is not None:
        errors.one_of("sign", sign, (*SIGNS, FROZEN))
    if not isinstance(wind, History):
        winds = errors.each("wind", wind, MeasuredWind, "a History, or soundings")
        return [wind_along(flight, sounding, plane, sign) for sounding in winds], (len(winds),)
    if sign == FROZEN or not wind.batch:
        return [wind_along(flight, wind, plane, sign)], wind.batch
    count = int(np.prod(wind.batch))
    cases = [wind.cases(np.asarray(k), wind.batch) for k in range(count)]
    return [wind_along(flight, case, plane, sign) for case in cases], wind.batch


def _moment_slope(flight: FlightSchedule, name: str, value: ArrayLike) -> FloatArray:
    """Return the slope of a moment [N m/rad] at the times of a flight, ``(n,)``.

    `value`: the slope, one or one for each time. `name`: name of the argument, for messages.
    """
    array = errors.finite(name, value, "N m/rad")
    if array.shape not in {(), flight.times.shape}:
        raise errors.InputError(
            f"{name} must be one number or one for each of the {flight.times.size} times; got shape"
            f" {array.shape}"
        )
    return np.broadcast_to(array, flight.times.shape)


def tracked_states(f: Flights, limit: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return times [s], states with deflection [rad], and deflection rates [rad/s] of a flight.

    Shapes ``(n,)``, ``(n, states + 1)`` and ``(n,)``. The nozzle is the state after the n of the
    plant; its rate is a state too if the actuator is of second order, else the differences of the
    deflection. `f`: a sampled flight at its end, with its recorded samples. `limit`: deflection
    limit [rad].
    """
    # recorded rows of a sample, of which the first has its start; number of states
    per_sample, order = int(f.steps.substeps[0].sum()), f.now.y.shape[1]
    y = np.concatenate([f.track[::per_sample, :order], f.now.y])
    count, n = len(y), f.vehicles.A.shape[1]
    samples = np.arange(count, dtype=float)
    period = float(f.steps.lengths[0, 0])  # of a sample, before the lengths of its parts [s]
    times: FloatArray = float(f.cases.start[0]) + period * samples
    deflection = np.clip(y[:, n], -limit, limit)
    rates = y[:, n + 1] if order > n + 1 else np.gradient(deflection, times)
    return times, np.column_stack([y[:, :n], deflection]), rates


def _continuous(along: FlownFlight) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return times [s] ``(k,)``, states and deflection rates of a flight of a continuous loop.

    The states of the plant and then the deflection [rad] are ``(k, n + 1)``, the deflection rates
    [rad/s] ``(k,)``. Steps end at the breakpoints of the wind and at the times of the data. Each is
    the matrix exponential of the constant loop that equals the varying one to fourth order. The
    delay is a Pade approximation. `InputError` if that changes the number of unstable poles, and
    for a motion without bounds. `along`: the flight, with its autopilot and wind.
    """
    wind, inner, delay = along.wind.history, along.breaks, float(np.unique(along.law.delay)[0])
    # breakpoints and coefficients, lowest power first, of one history: a batch of one
    knots, pieces = (array[0] for array in polynomial_pieces(wind.pieces))

    def loop_at(times: FloatArray) -> LinearSystem:
        """Return the closed loop of the flight `along` at times [s], with a constant `delay`."""
        plants, laws = along.loops(times)
        return closed_loop(replace(laws, delay=delay), plants)

    plants, laws = along.loops(np.concatenate([[along.start], inner, [along.stop]]))
    require_pade(replace(laws, delay=delay), plants)
    count = int(np.ceil((along.stop - along.start) / _CONTINUOUS_STEP - 1e-9))
    check_samples(along.stop - along.start, _CONTINUOUS_STEP)
    times = np.unique(np.concatenate([np.linspace(along.start, along.stop, count + 1), inner]))
    # steps shorter than rounding are joined
    times = times[np.append(True, np.diff(times) > 1e-9 * max(abs(along.stop), 1.0))]
    lengths, terms = np.diff(times), pieces.shape[1]
    systems = [  # the loop with the wind's polynomial, at both Gauss points of all steps
        connect([loop_at(times[:-1] + node * lengths), polynomial_input("wind", terms)], (), ())
        for node in GAUSS_NODES
    ]
    steps = constant_over_steps(systems[0], systems[1], lengths).to_steps(lengths).A
    order = steps.shape[-1] - terms  # states of the loop, ahead of those of the wind's polynomial
    # coefficients of the wind's polynomial about the start of each step; zero before its onset
    index = np.searchsorted(knots, times[:-1] + 1e-12, side="right") - 1
    begun, piece = index >= 0, np.maximum(index, 0)
    local = recentred(pieces[piece][:, np.newaxis], np.zeros(1), times[:-1] - knots[piece])[:, 0]
    local = np.where(begun[:, np.newaxis], local, 0.0)
    forced = (steps[:, :order, order:] @ local[..., np.newaxis])[..., 0]
    states = np.zeros((times.size, order))
    for k in range(lengths.size):
        states[k + 1] = steps[k, :order, :order] @ states[k] + forced[k]
    if not np.all(np.isfinite(states)):
        raise errors.InputError("the motion grows beyond all numbers; the loop is not stable")
    loop = loop_at(times)
    row = loop.select(("wind",), ("deflection",))
    C, D = (np.broadcast_to(m, (times.size, 1, m.shape[-1]))[:, 0] for m in (row.C, row.D))
    deflection = np.sum(C * states, axis=1) + D[:, 0] * np.asarray(wind(times))
    n = len(plants.states)
    if laws.actuator is not None and laws.actuator.damping is not None:
        rates = states[:, loop.states.index("actuator_rate")]
    else:
        rates = np.gradient(deflection, times)
    return times.astype(float), np.column_stack([states[:, :n], deflection]), rates


def with_outputs(
    along: FlownFlight,
    times: FloatArray,
    rows: FloatArray,
    rates: FloatArray,
    status: str,
    slopes: Mapping[str, FloatArray],
) -> FlightAlong:
    """Return a flight with its outputs at n times by name, ``(n,)`` each, in SI units and radians.

    `along`: the flight, with its autopilot and wind. `times`: flight times [s]. `rows`: states of
    the plant and deflection [rad], ``(n, m + 1)``. `rates`: deflection rates [rad/s]. `status`:
    status of the flight. `slopes`: bending moments [N m/rad] per angle, alpha_moment and
    deflection_moment, at the times of the schedule; empty for none. Outputs are C x + D u, u being
    deflection and wind; after the end of the schedule numbers of the vehicle are those of the end.
    """
    # times [s] within this flight, and of those `within` the schedule of the vehicle, which may end
    flight, inside = along.flight, np.clip(times, along.start, along.stop)
    within = np.minimum(inside, flight.span[1])
    ratio = along.wind.pressure(inside)  # q/q_n encountered in the wind
    plants = FlownFlights([along]).plants_at(inside, np.zeros(inside.size, np.int64), ratio)
    wind_angle = np.asarray(along.wind.history(times), float)
    states, deflection = rows[:, : len(plants.states)], rows[:, -1]
    _, _, C, D = plants.matrices()
    drives = np.column_stack([deflection, wind_angle])  # the first two inputs of the plants
    values = (C @ states[..., np.newaxis])[..., 0] + (D[..., :2] @ drives[..., np.newaxis])[..., 0]
    by_name = dict(zip(plants.outputs, values.T, strict=True))
    outputs: dict[str, FloatArray] = {"wind": wind_angle}
    for name in ("attitude", "attitude_rate", "flight_path_angle", "angle_of_attack"):
        if name in by_name:
            outputs[name] = by_name[name]
    outputs |= {"deflection": deflection, "deflection_rate": rates, "pressure_ratio": ratio}
    if "flight_path_angle" in outputs:
        drift_rate = flight_variable(flight, "speed", within) * outputs["flight_path_angle"]
        # integrated by the trapezoidal rule
        steps = 0.5 * (drift_rate[1:] + drift_rate[:-1]) * np.diff(times)
        outputs["drift"] = np.concatenate([[0.0], np.cumsum(steps)])
    if flight.altitude is not None:
        pressure = flight_variable(flight, "dynamic_pressure", within)
        outputs["q_alpha"] = ratio * pressure * outputs["angle_of_attack"]
    if "alpha_moment" in slopes:
        on_alpha, on_deflection = (
            np.interp(inside, flight.times, slopes[name])
            for name in ("alpha_moment", "deflection_moment")
        )
        moment = ratio * on_alpha * outputs["angle_of_attack"] + on_deflection * deflection
        outputs["bending_moment"] = moment
    if flight.structure is not None:
        counts = {"bending": flight.structure.modes, "slosh": flight.structure.tanks}
        for kind, names in counts.items():
            for k, name in enumerate(names, start=1):
                outputs[name] = states[:, plants.states.index(f"{kind}_{k}")]
    return FlightAlong(times, outputs, status)
