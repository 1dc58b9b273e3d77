"""Covariance of a loop in turbulence over time, about its mean response to a known wind.

The vehicle starts at rest in turbulence that is stationary. Mean and covariance follow

    m' = A m + B_w alpha_w,    P' = A P + P A' + N,

of one vehicle (`turbulence_history`) or of a vehicle along its flight (`turbulence_along`), whose
filter stands in the distance flown. Each step is the exponential of a constant system that equals
the varying one to fourth order; for a constant vehicle and piecewise linear winds it is exact but
for the wind's own curvature.

Along a flight vehicle, structure, gains and the intensity of each time vary; a sampled autopilot
jumps at its samples, with the gains of each.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from tvclin.ascent.atmosphere import LAYER_ALTITUDES
from tvclin.ascent.schedule import FlightSchedule, flight_variable
from tvclin.ascent.structure_schedule import StructureSchedule
from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.fields import spec
from tvclin.control.autopilot.autopilot import Autopilot, require_pade
from tvclin.control.autopilot.gain_schedule import GainSchedule, autopilot_along
from tvclin.control.autopilot.sweep import plants_along
from tvclin.control.turbulence.covariance_march import Moments, VaryingLoop, march, march_times
from tvclin.control.turbulence.driven_loop import (
    DEFLECTION,
    DrivenLoop,
    LoadSlopes,
    SensorNoise,
    Signal,
    check_single,
    checked_parts,
    driven_loop,
    loads_at,
)
from tvclin.control.turbulence.loop_covariance import GaussianOutputs, stationary
from tvclin.linear.flexible import AnyPlant, FlexiblePlant, check_plant
from tvclin.numerics.covariance import absolute_covariance
from tvclin.vehicle.structure import Structure
from tvclin.winds.histories import History
from tvclin.winds.turbulence import Turbulence

_DURATIONS = errors.between(1e-3, errors.MAX_TIME)
"""Check of durations [s]."""


@dataclass(frozen=True, eq=False)
class CovarianceHistory(GaussianOutputs):
    """Mean and standard deviation of the outputs of a loop over time, linear and without limits.

    Make it with `turbulence_history` or `turbulence_along`.

    Attributes
    ----------
    times : ndarray
        Times [s], rising, ``(n,)``.
    outputs : tuple of str
        Names of the outputs.
    """

    times: FloatArray = field(metadata=spec("time"))
    outputs: tuple[str, ...] = field(metadata=spec(card=False))
    _signals: Mapping[str, Signal]
    _moments: Moments

    def mean(self, output: str = DEFLECTION) -> FloatArray:
        """Return the response to the known wind at the times ``(n,)``, in SI units.

        `InputError` for an unknown output.
        """
        row, direct = self._row(output)  # output = row x + direct alpha_w, x being the states
        return self._mean_of(row, direct)

    def deviation(self, output: str = DEFLECTION) -> FloatArray:
        """Return the standard deviation of an output at the times ``(n,)``, in SI units.

        `InputError` for an unknown output.
        """
        row, _ = self._row(output)
        return self._deviation_of(row)

    def largest(self, sigmas: float = 3.0, output: str = DEFLECTION) -> tuple[float, float]:
        """Return the largest ``|mean|`` + `sigmas` deviations of an output, and its time [s].

        `InputError` for an unknown output and a number of standard deviations beyond 0 to 10.
        """
        k = errors.number("sigmas", sigmas, errors.between(0.0, 10.0))
        sizes = np.abs(self.mean(output)) + k * self.deviation(output)
        largest = int(np.argmax(sizes))
        return float(sizes[largest]), float(self.times[largest])

    def travel(self, output: str = DEFLECTION) -> float:
        """Return the expected integral of ``|y'|``, of the deflection the nozzle's travel [rad].

        `InputError` for an unknown output and one that jumps with the turbulence or a noise.
        """
        return float(np.trapezoid(self._absolute_rates(output), self.times))

    def travel_deviation(self, output: str = DEFLECTION) -> float:
        """Return the standard deviation of the travel of an output, of the deflection in rad.

        It is the root of the double integral over two times of the covariance of ``|y'|`` at them,
        by the trapezoidal rule at up to 400 times. `InputError` for an unknown output and one that
        jumps.
        """
        row, direct = self._rate(output)  # of y'
        # indices of these times, covariances of the states, and transitions from a time to the next
        chosen, transitions = self._moments.chosen, self._moments.transitions
        P = self._moments.covariances[chosen]
        rows = np.broadcast_to(row, (len(self.times), row.shape[-1]))[chosen]
        mean, deviation = self._mean_of(row, direct)[chosen], self._deviation_of(row)[chosen]
        covariances = np.zeros((len(chosen), len(chosen)))
        # Column j: covariance of the states at time k with y' at the earlier time j.
        with_rate = np.zeros((row.shape[-1], len(chosen)))
        for k, row_k in enumerate(rows):
            if k:
                with_rate[:, :k] = transitions[k - 1] @ with_rate[:, :k]
            with_rate[:, k] = P[k] @ row_k
            covariances[k, : k + 1] = row_k @ with_rate[:, : k + 1]
        i, j = np.tril_indices(len(chosen))  # pairs of times
        sizes = np.maximum(deviation[i] * deviation[j], np.finfo(float).tiny)
        correlations = covariances[i, j] / sizes
        pairs = absolute_covariance((mean[i], mean[j]), (deviation[i], deviation[j]), correlations)
        half_steps = 0.5 * np.diff(self.times[chosen], prepend=self.times[chosen[0]])
        weights = half_steps + np.append(half_steps[1:], 0.0)  # of the trapezoidal rule
        pairs *= np.where(i == j, 1.0, 2.0) * weights[i] * weights[j]
        return float(np.sqrt(max(np.sum(pairs), 0.0)))

    def crossings(self, limit: float, output: str = DEFLECTION) -> float:
        """Return the expected number of crossings, over `times`, of +limit upwards and -limit down.

        `InputError` for an unknown output, one that jumps, and a limit, in the SI unit of the
        output, that is not positive.
        """
        return float(np.trapezoid(self.crossing_rate(limit, output), self.times))

    def time_fraction(self, limit: float, output: str = DEFLECTION) -> float:
        """Return the expected fraction of the time in which ``|output|`` is above a limit.

        `InputError` for an unknown output, and a limit that is not positive.
        """
        beyond = np.trapezoid(self.exceedance(limit, output), self.times)
        return float(beyond / (self.times[-1] - self.times[0]))

    def probability_of_none(self, limit: float, output: str = DEFLECTION) -> float:
        """Return the probability that the output stays within +-limit: e^-(expected crossings).

        It is right where crossings are rare and independent, and low where they come in clusters.
        `InputError` for an unknown output, one that jumps, and a limit that is not positive.
        """
        return float(np.exp(-self.crossings(limit, output)))

    def quantile(self, probability: float, output: str = DEFLECTION) -> FloatArray:
        """Return the value that an output is below with a probability, at each time, ``(n,)``.

        Of the output itself, with its sign, in SI units, at the n `times`. `InputError` for an
        unknown output and a probability that is not above 0 and below 1.
        """
        from scipy.special import ndtri  # late: scipy takes long to import

        z = float(ndtri(errors.fraction("probability", probability)))
        return self.mean(output) + z * self.deviation(output)


def turbulence_history(
    autopilot: Autopilot,
    plant: AnyPlant,
    turbulence: Turbulence,
    speed: float,
    duration: float,
    *,
    wind: History | None = None,
    altitude: float | None = None,
    noise: SensorNoise | None = None,
    loads: LoadSlopes | None = None,
    settled: bool = False,
) -> CovarianceHistory:
    """Return mean and covariance of a loop over time, in a known wind and turbulence.

    Parameters
    ----------
    autopilot, plant, turbulence
        One each; an unstable loop has a covariance that grows.
    speed, altitude : float
        Airspeed [m/s], and altitude [m] for turbulence that is a table.
    noise, loads : SensorNoise, LoadSlopes, optional
        White noise of the sensors, and slopes of loads for further outputs.
    duration : float
        Time [s] from 0 on.
    wind : History, optional
        The known wind [rad]; by default none.
    settled : bool
        Whether turbulence has acted for long before, so that the covariance is the stationary one
        throughout; by default the vehicle is at rest at first, and its drift an output.

    Raises
    ------
    InputError
        For a batch, numbers out of range, a duration of more than 30,000 steps, and an unstable
        loop that shall be settled.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> vehicle = tv.load_vehicle("configuration-i")
    >>> plant = tv.Plant.from_vehicle(vehicle, "drift-exact")
    >>> autopilot = tv.Autopilot(
    ...     attitude_gain=0.2144578, rate_gain=0.486223,
    ...     actuator=tv.Actuator(natural_frequency=25.0, damping=0.7))
    >>> air = tv.winds.Turbulence(intensity=6.0)
    >>> wind = tv.TriangularWind(peak=np.radians(5), duration=7.5)
    >>> result = tv.control.turbulence_history(
    ...     autopilot, plant, air, vehicle.velocity, duration=20.0, wind=wind)
    >>> print(f"{np.degrees(result.travel()):.3f} deg of travel")
    2.048 deg of travel
    >>> print(f"{result.crossings(np.radians(0.82)):.5f} crossings of 0.82 deg")
    0.02914 crossings of 0.82 deg
    """
    checked_parts(autopilot, turbulence, noise, loads)
    check_plant(plant)
    check_single("turbulence_history", autopilot, plant, loads)
    V = errors.number("speed", speed)
    altitude = None if altitude is None else errors.number("altitude", altitude, unit="m")
    a, b, c = turbulence.shaping_filter(V, altitude)  # of the velocity w; the angle is w/V
    at_rest = not errors.flag("settled", settled)
    loop = driven_loop(autopilot, plant, (a, b, c / V), np.asarray(V), noise, loads, drift=at_rest)
    times = march_times(0.0, errors.number("duration", duration, _DURATIONS, "s"), wind, loop)
    start = None
    if not at_rest:
        covariances, _ = stationary(loop)
        start = covariances[0]  # just behind a sample
    moments = march(loop, times, wind, start)
    return CovarianceHistory(times, loop.labels, loop.output_signals, moments)


def turbulence_along(
    schedule: FlightSchedule,
    autopilot: Autopilot | GainSchedule,
    turbulence: Turbulence,
    *,
    model: str = "drift-exact",
    plane: str = "pitch",
    start: float | None = None,
    stop: float | None = None,
    wind: History | None = None,
    structure: Structure | StructureSchedule | None = None,
    noise: SensorNoise | None = None,
    loads: LoadSlopes | None = None,
) -> CovarianceHistory:
    """Return mean and covariance of a vehicle along its flight, in a known wind and turbulence.

    Parameters
    ----------
    schedule : FlightSchedule
        The vehicle at its flight times; it needs altitudes for turbulence that is a table.
    autopilot : Autopilot or GainSchedule
        One autopilot, or its gains over the flight; continuous, or with one sample rate. The
        actuator of a flight that has one over time takes the place of the autopilot's.
    turbulence : Turbulence
        The wind.
    model : {"fixed-path", "drift", "drift-exact", "drift-and-speed"}
        Model of the motion.
    plane : {"pitch", "yaw"}
        Plane of the motion.
    start, stop : float, optional
        First and last time [s], by default those of the schedule: a start where the wind angle is
        small, so not on the pad.
    wind : History, optional
        The known wind [rad] over flight time; by default none.
    structure : Structure or StructureSchedule, optional
        Bending, slosh and sensors, constant or over the flight; by default those of the schedule.
    noise : SensorNoise, optional
        White noise of the sensors.
    loads : LoadSlopes, optional
        Loads per angle of attack and per deflection, one number or one for each time of the
        schedule, and the low-pass of their sensor. A schedule with altitudes has the output
        "q_alpha" by itself.

    Raises
    ------
    InputError
        For a delay or a sample rate that varies, a schedule without the altitudes that a table
        needs, more than 30,000 steps, numbers out of range, and a Pade approximation with another
        number of unstable poles than the exact delay at a breakpoint of the flight.

    Notes
    -----
    Between the times of the schedule the vehicle and the gains are straight lines. The outputs are
    those of `turbulence_history`, and the drift [m] where the model has a flight path. The delay of
    a continuous autopilot is its Pade approximation; with samples it is exact, the law has the
    gains of each sample, and the history shows the motion between samples too.
    """
    errors.instance("schedule", schedule, FlightSchedule, "see load_schedule")
    gains = autopilot.autopilot if isinstance(autopilot, GainSchedule) else autopilot
    checked_parts(gains, turbulence, noise, loads)
    if not isinstance(autopilot, GainSchedule) and gains.batch:
        raise errors.InputError(
            f"autopilot must be one autopilot, or a GainSchedule; got a batch of {gains.batch}"
        )
    delay = _constant("delay", gains.delay)
    rate = None if gains.sample_rate is None else _constant("sample_rate", gains.sample_rate)
    flight = schedule if start is None and stop is None else schedule.between(start, stop)
    frozen: Structure | None = None
    if isinstance(structure, StructureSchedule):
        flight = replace(flight, structure=structure)
    elif structure is not None:
        errors.instance("structure", structure, Structure, "or a StructureSchedule")
        frozen = structure
    if turbulence.altitude is not None:
        _ = flight.height  # raises for a schedule without altitude
    load_slopes = LoadSlopes() if loads is None else loads
    pressure_of_flight = load_slopes.dynamic_pressure is None and flight.altitude is not None

    def autopilots_and_plants(time: FloatArray) -> tuple[Autopilot, AnyPlant]:
        """Return the autopilots and the plants at times [s] of the flight, not beyond it.

        Delay and sample rate are constant. With a constant structure, `frozen`, the plants have it;
        else the structure of the flight.
        """
        autopilots = autopilot_along(autopilot, flight, time)
        autopilots = replace(autopilots, delay=delay, sample_rate=rate)
        if frozen is None:
            return autopilots, plants_along(flight, time, model, plane)
        vehicles = flight.at(time).rigid
        return autopilots, FlexiblePlant.from_vehicle(vehicles, frozen, model, plane)

    def loop_at(times: FloatArray) -> DrivenLoop:
        """Return the loops in turbulence at flight times [s], constant beyond the flight.

        `load_slopes`, at the times of the `schedule`, have the dynamic pressure of the flight if
        they have none of their own (`pressure_of_flight`). `noise`: of the sensors.
        """
        time = np.clip(times, *flight.span)
        autopilots, plants = autopilots_and_plants(time)
        height = None if flight.altitude is None else np.interp(time, flight.times, flight.height)
        V = np.broadcast_to(np.asarray(flight.at(time).velocity), times.shape)
        a, b, c = turbulence.shaping_filter(V, height)  # of the velocity; the angle is over V
        shaping = a, b, c / V[:, np.newaxis, np.newaxis]
        slopes = loads_at(load_slopes, schedule.times, time)
        if pressure_of_flight:
            pressure = flight_variable(flight, "dynamic_pressure", time)
            slopes = replace(slopes, dynamic_pressure=pressure)
        return driven_loop(autopilots, plants, shaping, V, noise, slopes, drift=True)

    breakpoints = _breakpoints(flight, autopilot, turbulence)
    if rate is None:
        require_pade(*autopilots_and_plants(breakpoints))
    loop = VaryingLoop(loop_at, breakpoints)
    times = march_times(*flight.span, wind, loop)
    moments = march(loop, times, wind)
    return CovarianceHistory(times, loop.labels, loop.signals(times), moments)


def _constant(name: str, value: float | FloatArray) -> float:
    """Return a number of an autopilot that must be constant; `InputError` if it varies.

    `name`: of the number, for the message. `value`: the number, or its values at breakpoints.
    """
    constant, *others = np.unique(value)
    if others:
        raise errors.InputError(f"the {name} of the autopilot must be the same along the flight")
    return float(constant)


def _breakpoints(
    flight: FlightSchedule, autopilot: Autopilot | GainSchedule, turbulence: Turbulence
) -> FloatArray:
    """Return the times of a flight at which its data, gains or turbulence have a corner [s].

    From the first to the last time of the flight. `autopilot`: constant, or a schedule with corners
    at its breakpoints. `turbulence`: constant, or a table over altitude. Over altitude the layers
    of the atmosphere have corners too, where the flight climbs throughout.
    """
    first, last = flight.span
    breaks = [flight.times]
    if flight.structure is not None:
        breaks.append(flight.structure.times)
    if isinstance(autopilot, GainSchedule) and autopilot.variable == "time":
        breaks.append(autopilot.breakpoints)
    if flight.altitude is not None and np.all(np.diff(flight.height) > 0.0):
        corners = [LAYER_ALTITUDES, *([] if turbulence.altitude is None else [turbulence.altitude])]
        breaks += [np.interp(corner, flight.height, flight.times) for corner in corners]
    inner = np.unique(np.concatenate(breaks))
    inner = inner[(inner > first + _CLOSE_S) & (inner < last - _CLOSE_S)]
    times = np.concatenate([[first], inner, [last]])
    return np.asarray(times[np.append(True, np.diff(times) > _CLOSE_S)])


_CLOSE_S = 1e-6
"""Breakpoints this close are one [s]."""
