"""Covariance of a loop in turbulence over time, about its mean response to a known wind.

The vehicle starts at rest in turbulence that is stationary. Mean and covariance follow

    m' = A m + B_w alpha_w,    P' = A P + P A' + N,

of one vehicle (`turbulence_history`) or of a vehicle along its flight (`turbulence_along`), whose
filter stands in the distance flown. Each step is the exponential of a constant system that equals
the varying one to fourth order; for a constant vehicle and piecewise linear winds it is exact but
for the wind's own curvature.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import (
    MAX_TIME,
    InputError,
    between,
    flag,
    fraction,
    instance,
    number,
    one_of,
    positive,
    shown,
)
from tvclin.base.fields import spec
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.gain_schedule import GainSchedule
from tvclin.control.turbulence.covariance_march import gauss_times, march, march_times
from tvclin.control.turbulence.driven_loop import (
    DEFLECTION,
    DrivenLoop,
    LoadSlopes,
    SensorNoise,
    checked_parts,
    driven_loop,
)
from tvclin.control.turbulence.loop_covariance import smooth_rate, stationary
from tvclin.linear.flexible import AnyPlant, FlexiblePlant, check_plant
from tvclin.linear.plant import Plant
from tvclin.numerics.gaussian import absolute_covariance, crossing_rate, mean_absolute
from tvclin.vehicle.structure import Structure
from tvclin.winds.histories import History
from tvclin.winds.turbulence import Turbulence

_DURATIONS = between(1e-3, MAX_TIME)
"""Check of durations [s]."""
_MAX_TIMES_OF_PAIRS = 400
"""Times of the double integral of a travel's variance."""


@dataclass(frozen=True, eq=False)
class CovarianceHistory(Shown):
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
    _loop: DrivenLoop  # at the times
    _wind: FloatArray
    _means: FloatArray
    _covariances: FloatArray
    _transitions: FloatArray

    def mean(self, output: str = DEFLECTION) -> FloatArray:
        """Return the response to the known wind at the times ``(n,)``, in SI units.

        Raises
        ------
        InputError
            For an unknown output.
        """
        return self._value(*self._output(output))

    def deviation(self, output: str = DEFLECTION) -> FloatArray:
        """Return the standard deviation of an output at the times, ``(n,)``.

        Raises
        ------
        InputError
            As `mean`.
        """
        return self._spread(self._output(output)[0])

    def largest(self, sigmas: float = 3.0, output: str = DEFLECTION) -> tuple[float, float]:
        """Return the largest ``|mean|`` plus some standard deviations, and its time [s].

        Raises
        ------
        InputError
            As `mean`, and for a number of standard deviations beyond 0 to 10.
        """
        k = number("sigmas", sigmas, between(0.0, 10.0))
        sizes = np.abs(self.mean(output)) + k * self.deviation(output)
        at = int(np.argmax(sizes))
        return float(sizes[at]), float(self.times[at])

    def travel(self, output: str = DEFLECTION) -> float:
        """Return the expected integral of ``|y'|``, of the deflection the nozzle's travel [rad].

        Raises
        ------
        InputError
            As `mean`, and for an output that jumps with the turbulence or a noise.
        """
        rate = self._rate(output)
        expected = mean_absolute(self._value(*rate), self._spread(rate[0]))
        return float(np.trapezoid(expected, self.times))

    def travel_deviation(self, output: str = DEFLECTION) -> float:
        """Return the standard deviation of the travel.

        It is the double integral of the covariance of ``|y'|`` at two times.

        Raises
        ------
        InputError
            As `travel`.
        """
        rate, direct = self._rate(output)
        count = len(self.times)
        chosen = np.unique(np.linspace(0, count - 1, _MAX_TIMES_OF_PAIRS).round().astype(int))
        rows = np.broadcast_to(rate, (count, rate.shape[-1]))
        mean, spread = self._value(rate, direct)[chosen], self._spread(rate)[chosen]
        covariances = np.zeros((len(chosen), len(chosen)))
        carried = np.zeros((rate.shape[-1], len(chosen)))
        column = 0
        for k in range(count):
            if k:
                carried[:, :column] = self._transitions[k - 1] @ carried[:, :column]
            if k == chosen[column]:
                carried[:, column] = self._covariances[k] @ rows[k]
                covariances[column, : column + 1] = rows[k] @ carried[:, : column + 1]
                column += 1
        covariances = np.tril(covariances) + np.tril(covariances, -1).T
        sizes = np.maximum(np.outer(spread, spread), np.finfo(float).tiny)
        pairs = absolute_covariance(
            (mean[:, np.newaxis], mean), (spread[:, np.newaxis], spread), covariances / sizes
        )
        when = self.times[chosen]
        variance = np.trapezoid(np.trapezoid(pairs, when, axis=1), when)
        return float(np.sqrt(max(variance, 0.0)))

    def crossings(self, limit: float, output: str = DEFLECTION) -> float:
        """Return the expected number of crossings of +limit upwards and of -limit downwards.

        Raises
        ------
        InputError
            As `travel`, and for a limit that is not positive.
        """
        return float(np.trapezoid(self.crossing_rate(limit, output), self.times))

    def crossing_rate(self, limit: float, output: str = DEFLECTION) -> FloatArray:
        """Return the expected crossings [1/s] of both limits at the times, ``(n,)``.

        Raises
        ------
        InputError
            As `crossings`.
        """
        bound = number("limit", limit, positive)
        row, direct = self._output(output)
        rate = self._rate(output)
        spread, motion = self._spread(row), self._spread(rate[0])
        crossed = self._joint(row, rate[0])
        correlation = crossed / np.maximum(spread * motion, np.finfo(float).tiny)
        means = self._value(row, direct), self._value(*rate)
        return crossing_rate(bound, means[0], spread, means[1], motion, correlation)

    def probability_of_none(self, limit: float, output: str = DEFLECTION) -> float:
        """Return the probability that the output stays within +-limit: exp(-crossings).

        It is right where crossings are rare and independent, and low where they come in clusters.

        Raises
        ------
        InputError
            As `crossings`.
        """
        return float(np.exp(-self.crossings(limit, output)))

    def quantile(self, probability: float, output: str = DEFLECTION) -> FloatArray:
        """Return the value of an output that is not exceeded with a probability, ``(n,)``.

        Raises
        ------
        InputError
            As `mean`, and for a probability that is not above 0 and below 1.
        """
        from scipy.special import ndtri  # late: scipy takes long to import

        z = float(ndtri(fraction("probability", probability)))
        return self.mean(output) + z * self.deviation(output)

    def _output(self, output: str) -> tuple[FloatArray, FloatArray]:
        return self._loop.row(one_of("output", output, self.outputs))

    def _rate(self, output: str) -> tuple[FloatArray, FloatArray]:
        """Return row and direct part of an output's rate; `InputError` for an output that jumps."""
        rate, direct = smooth_rate(self._loop, output)
        row = self._output(output)[0]
        varies = row.ndim > 1
        return rate + np.gradient(row, self.times, axis=0) if varies else rate, direct

    def _value(self, row: FloatArray, direct: FloatArray) -> FloatArray:
        """Return the mean of an output of given row and direct part."""
        return np.asarray(np.sum(row * self._means, axis=-1) + direct * self._wind)

    def _spread(self, row: FloatArray) -> FloatArray:
        """Return the standard deviation of a row of the states."""
        return np.asarray(np.sqrt(np.maximum(self._joint(row, row), 0.0)))

    def _joint(self, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return the covariance of two rows of the states at the times, ``(n,)``."""
        shape = self._covariances.shape[:-1]
        rows = np.broadcast_to(first, shape), np.broadcast_to(second, shape)
        return np.asarray(np.einsum("ki,kij,kj->k", rows[0], self._covariances, rows[1]))


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
    autopilot, plant, turbulence, speed, altitude, noise, loads
        As in `turbulence_covariance`; an unstable loop has a covariance that grows.
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
    if autopilot.batch or plant.batch:
        raise InputError(
            "turbulence_history() is for one autopilot and one plant; got batches of shape"
            f" {autopilot.batch} and {plant.batch} (see turbulence_along)"
        )
    shape = turbulence.shaping_filter(speed, altitude)
    V = float(speed)
    shape = *shape[:2], shape[2] / V
    at_rest = not flag("settled", settled)
    loop = driven_loop(autopilot, plant, shape, np.asarray(V), noise, loads, drift=at_rest)
    times = march_times(0.0, number("duration", duration, _DURATIONS, "s"), wind, loop)
    start = None if at_rest else stationary(loop)[0][0]
    moments = march((loop, loop), times, wind, shape[:2], start)
    return CovarianceHistory(times, loop.labels, loop, *moments)


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
    structure: Structure | None = None,
    noise: SensorNoise | None = None,
) -> CovarianceHistory:
    """Return mean and covariance of a vehicle along its flight, in a known wind and turbulence.

    Parameters
    ----------
    schedule : FlightSchedule
        The vehicle at its flight times; it needs altitudes for turbulence that is a table.
    autopilot : Autopilot or GainSchedule
        One continuous autopilot, or its gains over the flight.
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
    structure : Structure, optional
        Bending, slosh and sensors, constant along the flight.
    noise : SensorNoise, optional
        White noise of the sensors.

    Raises
    ------
    InputError
        For an autopilot with a sample rate, a schedule without the altitudes that a table needs,
        and numbers out of range.

    Notes
    -----
    Between the times of the schedule the vehicle and the gains are straight lines. The outputs are
    those of `turbulence_history`, and the drift [m] where the model has a flight path.
    """
    instance("schedule", schedule, FlightSchedule, "see load_schedule")
    gains = autopilot if isinstance(autopilot, GainSchedule) else None
    parts = autopilot.autopilot if isinstance(autopilot, GainSchedule) else autopilot
    checked_parts(parts, turbulence, noise, None)
    if parts.sample_rate is not None:
        raise InputError(
            "turbulence_along() is for continuous autopilots; this one has a sample_rate (replace"
            " it by None, and add half a sample to the delay)"
        )
    if structure is not None and not isinstance(structure, Structure):
        raise InputError(f"structure must be a Structure or None; got {shown(structure)}")
    if gains is None and parts.batch:
        raise InputError(
            f"autopilot must be one autopilot, or a GainSchedule; got a batch of {parts.batch}"
        )
    delay = np.unique(parts.delay)
    if delay.size > 1:
        raise InputError("the delay of the autopilot must be the same along the flight")
    flight = schedule if start is None and stop is None else schedule.between(start, stop)
    if turbulence.altitude is not None:
        _ = flight.height  # refuses a schedule without altitude
    A, b, c = turbulence.normalised_filter

    def loop_at(times: FloatArray) -> DrivenLoop:
        vehicle = flight.at(np.clip(times, *flight.span))
        plant: AnyPlant
        if structure is None:
            plant = Plant.from_vehicle(vehicle, model, plane)
        else:
            plant = FlexiblePlant.from_vehicle(vehicle, structure, model, plane)
        law = gains.along(flight, np.clip(times, *flight.span)) if gains else parts
        law = replace(law, delay=float(delay[0]))
        height = None if flight.altitude is None else np.interp(times, flight.times, flight.height)
        sigma, length = (np.broadcast_to(x, times.shape) for x in turbulence.over(height))
        V = np.broadcast_to(np.asarray(vehicle.velocity), times.shape)
        advance, angle = (x[:, np.newaxis, np.newaxis] for x in (V / length, sigma / V))
        shape = A * advance, b * np.sqrt(advance), c * angle
        return driven_loop(law, plant, shape, V, noise, drift=True)

    times = march_times(*flight.span, wind, None)
    loops = loop_at(np.concatenate([times, *gauss_times(times)]))
    steps = len(times) - 1
    first, second = loops.part(slice(-2 * steps, -steps)), loops.part(slice(-steps, None))
    loop = loops.part(slice(len(times)))
    moments = march((first, second), times, wind, (A, b))
    return CovarianceHistory(times, loop.labels, loop, *moments)
