"""Covariance of a loop in turbulence over time, about its mean response to a known wind.

The vehicle starts at rest in turbulence that is stationary. Mean and covariance follow

    m' = A m + B_w alpha_w,    P' = A P + P A' + N,

of one vehicle (`turbulence_history`) or of a vehicle along its flight (`turbulence_along`), whose
filter stands in the distance flown. Each step is the exponential of a constant system that equals
the varying one to fourth order; for a constant vehicle and piecewise linear winds it is exact but
for the wind's own curvature.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import MAX_TIME, between, flag, fraction, number, one_of, positive
from tvclin.base.fields import spec
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.turbulence.covariance_march import Moments, march, march_times
from tvclin.control.turbulence.driven_loop import (
    DEFLECTION,
    LoadSlopes,
    SensorNoise,
    Signal,
    check_single,
    checked_parts,
    driven_loop,
)
from tvclin.control.turbulence.loop_covariance import stationary
from tvclin.linear.flexible import AnyPlant, check_plant
from tvclin.numerics.covariance import absolute_covariance, crossing_rate, exceedance, mean_absolute
from tvclin.winds.histories import History
from tvclin.winds.turbulence import Turbulence

_DURATIONS = between(1e-3, MAX_TIME)
"""Check of durations [s]."""


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
    _signals: Mapping[str, Signal]
    _moments: Moments

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
        chosen = self._moments.chosen
        rows = np.broadcast_to(rate, (len(self.times), rate.shape[-1]))[chosen]
        mean, spread = self._value(rate, direct)[chosen], self._spread(rate)[chosen]
        covariances = np.zeros((len(chosen), len(chosen)))
        carried = np.zeros((rate.shape[-1], len(chosen)))
        for k, row in enumerate(rows):
            if k:
                carried[:, :k] = self._moments.transitions[k - 1] @ carried[:, :k]
            carried[:, k] = self._moments.covariances[chosen[k]] @ row
            covariances[k, : k + 1] = row @ carried[:, : k + 1]
        first, second = np.tril_indices(len(chosen))
        sizes = np.maximum(spread[first] * spread[second], np.finfo(float).tiny)
        correlations = covariances[first, second] / sizes
        pairs = absolute_covariance(
            (mean[first], mean[second]), (spread[first], spread[second]), correlations
        )
        steps = 0.5 * np.diff(self.times[chosen], prepend=self.times[chosen[0]])
        weights = steps + np.append(steps[1:], 0.0)
        pairs *= np.where(first == second, 1.0, 2.0) * weights[first] * weights[second]
        return float(np.sqrt(max(np.sum(pairs), 0.0)))

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

    def exceedance(self, limit: float, output: str = DEFLECTION) -> FloatArray:
        """Return the probability of ``|output| > limit`` at the times, ``(n,)``.

        See `LoopCovariance.exceedance` on what it says about a deflection limit.

        Raises
        ------
        InputError
            As `mean`, and for a limit that is not positive.
        """
        bound = number("limit", limit, positive)
        return exceedance(bound, self.mean(output), self.deviation(output))

    def time_fraction(self, limit: float, output: str = DEFLECTION) -> float:
        """Return the expected fraction of the time in which ``|output|`` is above a limit.

        Raises
        ------
        InputError
            As `exceedance`.
        """
        beyond = np.trapezoid(self.exceedance(limit, output), self.times)
        return float(beyond / (self.times[-1] - self.times[0]))

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
        return self._signals[one_of("output", output, self.outputs)][:2]

    def _rate(self, output: str) -> tuple[FloatArray, FloatArray]:
        """Return row and direct part of an output's rate; `InputError` for an output that jumps."""
        return self._signals[one_of("output", output, self.outputs)].smooth_rate(output)

    def _value(self, row: FloatArray, direct: FloatArray) -> FloatArray:
        """Return the mean of an output of given row and direct part."""
        return np.asarray(np.sum(row * self._moments.means, axis=-1) + direct * self._moments.wind)

    def _spread(self, row: FloatArray) -> FloatArray:
        """Return the standard deviation of a row of the states."""
        return np.asarray(np.sqrt(np.maximum(self._joint(row, row), 0.0)))

    def _joint(self, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return the covariance of two rows of the states at the times, ``(n,)``."""
        covariances = self._moments.covariances
        rows = (np.broadcast_to(row, covariances.shape[:-1]) for row in (first, second))
        left, right = rows
        return np.asarray(np.sum((left[:, np.newaxis] @ covariances)[:, 0] * right, axis=-1))


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
    check_single("turbulence_history", autopilot, plant, loads)
    V = number("speed", speed)
    altitude = None if altitude is None else number("altitude", altitude, unit="m")
    shape = turbulence.shaping_filter(V, altitude)
    shape = *shape[:2], shape[2] / V
    at_rest = not flag("settled", settled)
    loop = driven_loop(autopilot, plant, shape, np.asarray(V), noise, loads, drift=at_rest)
    times = march_times(0.0, number("duration", duration, _DURATIONS, "s"), wind, loop)
    start = None if at_rest else stationary(loop)[0][0]
    moments = march(loop, times, wind, start)
    signals = {output: loop.signal(output) for output in loop.labels}
    return CovarianceHistory(times, loop.labels, signals, moments)
