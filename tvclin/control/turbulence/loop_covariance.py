"""Stationary covariance of a loop in turbulence: rms, quantiles, spectra, travel and crossings.

In continuous time A P + P A' + N = 0. With samples the covariance has the period of a sample; it
is found at the sample and propagated exactly between, so that an rms is the largest over all
phases of a sample, and a travel or a rate of crossings the mean over them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, fraction, nonnegative, number, one_of, positive, within
from tvclin.base.fields import Field, derived, spec, specs
from tvclin.base.lines import Table, significant
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.turbulence.covariance_march import Moments
from tvclin.control.turbulence.driven_loop import (
    DEFLECTION,
    DEFLECTION_RATE,
    OUTPUT_KINDS,
    DrivenLoop,
    LoadSlopes,
    SensorNoise,
    Signal,
    check_single,
    checked_parts,
    driven_loop,
)
from tvclin.linear.flexible import AnyPlant, check_plant
from tvclin.numerics.covariance import (
    crossing_rate,
    exceedance,
    mean_absolute,
    periodic_covariance,
    stationary_covariance,
    steps,
)
from tvclin.winds.turbulence import Turbulence

_PHASES = 16
"""Steps of each interval of a sample, an even number."""
_MAX_FREQUENCY = 1e9
"""Largest frequency of a spectrum [rad/s]."""


class GaussianOutputs(Shown):
    """Outputs of a linear loop at n times, Gaussian, with mean and covariance of its states.

    `_signals`: each output y = row x + direct alpha_w by name, of the states x and the known wind
    alpha_w [rad]: row ``(states,)`` and direct term ``()``, or with n leading times. `_moments`:
    mean and covariance of the states, the mean being the response to the known wind.
    """

    outputs: tuple[str, ...]
    _signals: Mapping[str, Signal]
    _moments: Moments

    def crossing_rate(self, limit: float, output: str = DEFLECTION) -> Any:
        """Return the expected crossings [1/s] of +limit up and -limit down at the times, ``(n,)``.

        `InputError` for an unknown output, one that jumps, and a limit, in the SI unit of the
        output, that is not positive.
        """
        bound = number("limit", limit, positive)
        (row, direct), (rate_row, rate_direct) = self._row(output), self._rate(output)
        deviation, rate_deviation = self._deviation_of(row), self._deviation_of(rate_row)
        product = np.maximum(deviation * rate_deviation, np.finfo(float).tiny)  # no 0/0
        correlation = self._covariance_of(row, rate_row) / product
        mean, rate_mean = self._mean_of(row, direct), self._mean_of(rate_row, rate_direct)
        return crossing_rate(bound, mean, deviation, rate_mean, rate_deviation, correlation)

    def exceedance(self, limit: float, output: str = DEFLECTION) -> Any:
        """Return the probability of ``|output| > limit`` at the times, ``(n,)``.

        `limit`: in the SI unit of the output. A nozzle with this deflection limit has that fraction
        less gain in Gaussian motion. `InputError` for an unknown output and a limit that is not
        positive.
        """
        bound = number("limit", limit, positive)
        row, direct = self._row(output)
        return exceedance(bound, self._mean_of(row, direct), self._deviation_of(row))

    def _row(self, output: str) -> tuple[FloatArray, FloatArray]:
        """Return row and direct term of an `output`; `InputError` for an unknown one."""
        row, direct, _ = self._signals[one_of("output", output, self.outputs)]
        return row, direct

    def _rate(self, output: str) -> tuple[FloatArray, FloatArray]:
        """Return row and direct term of the rate of an `output`.

        `InputError` for an unknown output, and for one that jumps.
        """
        _, _, rate = self._signals[one_of("output", output, self.outputs)]
        if rate is None:
            raise InputError(
                f"{output} has no rate of finite variance, as it follows the turbulence, the noise"
                " or a sample at once: it crosses every limit infinitely often, and has no travel;"
                " see its rms and quantile"
            )
        return rate

    def _mean_of(self, row: FloatArray, direct: FloatArray) -> FloatArray:
        """Return the mean of an output with this `row` and `direct` term at the times, ``(n,)``."""
        means, wind = self._moments.means, self._moments.wind
        return np.asarray(np.sum(row * means, axis=-1) + direct * wind)

    def _deviation_of(self, row: FloatArray) -> FloatArray:
        """Return the standard deviation of an output with this `row` at the times, ``(n,)``."""
        return np.asarray(np.sqrt(np.maximum(self._covariance_of(row, row), 0.0)))

    def _covariance_of(self, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return the covariance of outputs with the rows `first` and `second`, ``(n,)``."""
        covariances = self._moments.covariances
        first, second = (np.broadcast_to(row, covariances.shape[:-1]) for row in (first, second))
        return np.asarray(np.einsum("ki,kij,kj->k", first, covariances, second))

    def _absolute_rates(self, output: str) -> FloatArray:
        """Return the expected size of the rate, E|y'|, of an `output` y at the times, ``(n,)``.

        In the SI unit of the output per second. `InputError` for an output that jumps.
        """
        row, direct = self._rate(output)
        return mean_absolute(self._mean_of(row, direct), self._deviation_of(row))


@dataclass(frozen=True, eq=False)
class LoopCovariance(GaussianOutputs):
    """Stationary covariance of one loop in turbulence, linear and without limits.

    Make it with `turbulence_covariance`.

    Attributes
    ----------
    intensity : float
        Standard deviation of the wind [m/s].
    speed : float
        Airspeed [m/s].
    outputs : tuple of str
        Names of the outputs.
    """

    intensity: float = field(metadata=spec("speed"))
    speed: float = field(metadata=spec("speed"))
    outputs: tuple[str, ...] = field(metadata=specs(Field("outputs", card=False)))
    _loop: DrivenLoop
    _signals: Mapping[str, Signal]
    _moments: Moments
    _weights: FloatArray

    @property
    @derived("angle")
    def deflection_rms(self) -> float:
        """Standard deviation of the deflection [rad]."""
        return self.rms()

    @property
    @derived("angular rate")
    def deflection_rate_rms(self) -> float | None:
        """Standard deviation of the deflection rate [rad/s]; None for a deflection that jumps."""
        return self.rms(DEFLECTION_RATE) if DEFLECTION_RATE in self.outputs else None

    @property
    @derived("angular rate")
    def travel_rate(self) -> float | None:
        """Expected travel of the nozzle in each second [rad/s]; None for one that jumps."""
        return self.mean_absolute_rate() if DEFLECTION_RATE in self.outputs else None

    @property
    def max_frequency(self) -> float:
        """Largest frequency of a spectrum [rad/s]: of a sampled autopilot half its rate."""
        # The intervals of a sample [s], each ahead of a jump; none in continuous time.
        period = sum(jump.length for jump in self._loop.jumps)
        return float(np.pi / period) if period else _MAX_FREQUENCY

    def rms(self, output: str = DEFLECTION) -> float:
        """Return the standard deviation of an output in its SI unit.

        With samples it is the largest over times within a sample. `InputError` for an unknown
        output.
        """
        row, _ = self._row(output)
        return float(self._deviation_of(row).max())

    def quantile(self, probability: float, output: str = DEFLECTION) -> float:
        """Return the quantile of the size of an output, ``|output|``, at a probability.

        `InputError` for an unknown output and a probability that is not above 0 and below 1.
        """
        from scipy.special import ndtri  # late: scipy takes long to import

        # The size of a Gaussian number is below its quantile on both sides, hence (1 + P)/2.
        return self.rms(output) * float(ndtri(0.5 + 0.5 * fraction("probability", probability)))

    def mean_absolute_rate(self, output: str = DEFLECTION) -> float:
        """Return E|y'| of an output, of the deflection its travel in each second [rad/s].

        With samples it is the mean over n times within a sample, with their `_weights`.
        `InputError` for an unknown output, and one that jumps with the wind or with the noise.
        """
        return float(self._weights @ self._absolute_rates(output))

    def crossing_rate(self, limit: float, output: str = DEFLECTION) -> float:
        """Return an output's expected crossings [1/s], of +limit upwards and -limit downwards.

        With samples it is the mean over times within a sample. `InputError` for an unknown output,
        one that jumps, and a limit that is not positive.
        """
        return float(self._weights @ super().crossing_rate(limit, output))

    def exceedance(self, limit: float, output: str = DEFLECTION) -> float:
        """Return the fraction of time in which ``|output|`` is above a limit.

        With samples it is the mean over n times within a sample, with their `_weights`. In
        Gaussian motion a nozzle with this deflection limit has that fraction less gain (the
        random-input describing function of a saturation): where it is more than a percent or so,
        the loop is linear no more, see `tvclin.ensembles.fly_turbulence`. `InputError` for an
        unknown output and a limit that is not positive.
        """
        return float(self._weights @ super().exceedance(limit, output))

    def probability_of_none(self, limit: float, duration: float, output: str = DEFLECTION) -> float:
        """Return the probability that an output stays within +-limit for a duration [s].

        It is exp(-crossings), which is right where crossings are rare and independent, and low
        where they come in clusters. `InputError` for an unknown output, one that jumps, a limit
        that is not positive, and a negative duration.
        """
        time = number("duration", duration, nonnegative, "s")
        return float(np.exp(-time * self.crossing_rate(limit, output)))

    def spectrum(self, omega: ArrayLike, output: str = DEFLECTION) -> FloatArray:
        """Return the one-sided power spectrum, whose integral over omega is the variance.

        Of a sampled autopilot it is the density of the output at the samples, up to half their
        rate. It is f N f*/pi with the factors f = row (p I - A)^-1, where p is j omega and the
        noise has the intensity N; of a sampled autopilot with the period h, p = exp(j omega h), A
        is the transition over a sample, and N is h times the covariance of its noise.

        `omega`: frequencies [rad/s] of any shape, as the result. `InputError` for an
        unknown output, and frequencies that are negative, above 1e9 rad/s, or above half the sample
        rate.
        """
        (row, _), loop = self._row(output), self._loop
        frequencies = within("omega", omega, 0.0, _MAX_FREQUENCY, "rad/s")
        if loop.jumps:
            period = np.pi / self.max_frequency  # the largest is half the sample rate
            if np.any(frequencies > self.max_frequency):
                raise InputError(
                    f"omega must be up to half the sample rate, {self.max_frequency:.6g} rad/s; got"
                    f" {frequencies.max():.6g}"
                )
            A, sample_noise = _over_a_sample(loop)
            p, noise = np.exp(1j * frequencies.ravel() * period), sample_noise * period
        else:
            p, A, noise = 1j * frequencies.ravel(), loop.A, loop.noise
        systems = p[:, np.newaxis, np.newaxis] * np.eye(len(A)) - A
        rows = np.broadcast_to(row, (len(p), len(row)))[..., np.newaxis]
        factors = np.linalg.solve(np.swapaxes(systems, -1, -2), rows)[..., 0]
        power = np.real(np.einsum("ki,ij,kj->k", factors, noise, factors.conj()))
        return np.asarray(power / np.pi).reshape(frequencies.shape)

    def tables(self) -> list[Table]:
        """Return the table of the rms of each output, and of the travel of the nozzle in a second.

        The travel, the mean absolute deflection rate [deg/s], is no rms, although its row has the
        same column. It is omitted for a nozzle that jumps, whose rate is infinite.
        """
        kinds = {name: OUTPUT_KINDS.get(name, "number") for name in self.outputs}
        fields = [Field(name, kind, significant=4) for name, kind in kinds.items()]
        rows = [
            ((item.title,), item.cell_of(f"turbulence.{item.name}", self.rms(item.name)))
            for item in fields
        ]
        if self.travel_rate is not None:
            label, travel = ("travel of the nozzle in a second",), np.degrees(self.travel_rate)
            rows.append((label, significant("turbulence.travel_deg_per_s", travel, 4, "deg/s")))
        return [Table("Turbulence, without limits", ("quantity", "rms"), tuple(rows))]


def turbulence_covariance(
    autopilot: Autopilot,
    plant: AnyPlant,
    turbulence: Turbulence,
    speed: float,
    *,
    altitude: float | None = None,
    noise: SensorNoise | None = None,
    loads: LoadSlopes | None = None,
) -> LoopCovariance:
    """Return the stationary covariance of a loop in turbulence, linear and without limits.

    Parameters
    ----------
    autopilot : Autopilot
        One autopilot, continuous or with a sample rate. The delay of a continuous one is its Pade
        approximation; with samples it is exact.
    plant : Plant or FlexiblePlant
        One plant of any model.
    turbulence : Turbulence
        The wind; its angle is w/V.
    speed : float
        Airspeed V [m/s].
    altitude : float, optional
        Altitude [m], for turbulence that is a table.
    noise : SensorNoise, optional
        White noise of the sensors.
    loads : LoadSlopes, optional
        Slopes of loads, for further outputs.

    Returns
    -------
    LoopCovariance
        The covariance of the outputs of `Autopilot.close`, and of deflection rate and
        acceleration where they have a variance, the drift rate where the model has a flight
        path, and the loads.

    Raises
    ------
    InputError
        For an unstable loop, which has no stationary covariance, with its pole; for a batch, a
        Pade approximation that hides an instability, and an autopilot without an actuator whose
        deflection follows the noise of the sensors.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> vehicle = tv.load_vehicle("configuration-i")
    >>> plant = tv.Plant.from_vehicle(vehicle, "fixed-path")
    >>> autopilot = tv.Autopilot(
    ...     attitude_gain=0.2144578, rate_gain=0.486223,
    ...     actuator=tv.Actuator(natural_frequency=25.0, damping=0.7))
    >>> air = tv.winds.Turbulence(intensity=6.0)
    >>> result = tv.control.turbulence_covariance(autopilot, plant, air, vehicle.velocity)
    >>> print(f"{np.degrees(result.rms()):.6f} deg")
    0.065673 deg
    >>> print(f"{np.degrees(result.mean_absolute_rate()):.6f} deg/s of travel")
    0.057944 deg/s of travel
    """
    checked_parts(autopilot, turbulence, noise, loads)
    check_plant(plant)
    check_single("turbulence_covariance", autopilot, plant, loads)
    V = number("speed", speed)
    altitude = None if altitude is None else number("altitude", altitude, unit="m")
    a, b, c = turbulence.shaping_filter(V, altitude)  # of the velocity w; the angle is w/V
    loop = driven_loop(autopilot, plant, (a, b, c / V), np.asarray(V), noise, loads)
    covariances, weights = stationary(loop)
    # No known wind, so means of zero.
    means = np.zeros(covariances.shape[:-1])
    moments = Moments(wind=np.zeros(len(weights)), means=means, covariances=covariances)
    sigma, _ = turbulence.over(altitude)
    return LoopCovariance(
        intensity=float(sigma),
        speed=V,
        outputs=loop.labels,
        _loop=loop,
        _signals=loop.output_signals,
        _moments=moments,
        _weights=weights,
    )


def stationary(loop: DrivenLoop) -> tuple[FloatArray, FloatArray]:
    """Return the stationary covariance of n states at k times within a sample, and their weights.

    `loop`: one loop, with A [1/s], the intensity N of its noise, and the jumps of its states at
    samples. Shapes ``(k, n, n)`` and ``(k,)``: the mean over a sample is the sum of weights times
    values, by Simpson's rule on 17 times of each interval before a jump. In continuous time k is
    1. `InputError` for an unstable loop.
    """
    if not loop.jumps:
        poles = np.linalg.eigvals(loop.A)
        if (pole := poles[np.argmax(poles.real)]).real >= 0.0:
            raise InputError(f"{_unstable(pole)} 1/s, and so no stationary covariance")
        return stationary_covariance(loop.A, loop.noise)[np.newaxis], np.ones(1)
    F, noise = _over_a_sample(loop)
    if not np.all(np.isfinite(F)):
        raise InputError("the loop is not stable: it grows beyond all numbers within a sample")
    poles = np.linalg.eigvals(F)
    if abs(pole := poles[np.argmax(np.abs(poles))]) >= 1.0:
        raise InputError(f"{_unstable(pole)} in z, and so no stationary covariance")
    P = periodic_covariance(F, noise)  # just behind a sample, then through its intervals
    covariances, weights = [], []
    simpson = np.array([1.0, *([4.0, 2.0] * (_PHASES // 2))[:-1], 1.0]) / (3.0 * _PHASES)
    period = sum(jump.length for jump in loop.jumps)
    for jump in loop.jumps:
        (step,), (step_noise,) = steps(loop.A, loop.noise, np.array([jump.length / _PHASES]))
        covariances.append(P)
        for _ in range(_PHASES):
            P = step @ P @ step.T + step_noise
            covariances.append(P)
        weights.append(simpson * (jump.length / period))
        P = jump.matrix @ P @ jump.matrix.T + jump.noise
    return np.array(covariances), np.concatenate(weights)


def _unstable(pole: complex) -> str:
    """Return the begin of a message that the loop has an unstable pole, without its unit."""
    imaginary = f" +- {abs(pole.imag):.6g}j" if pole.imag else ""
    return f"the loop is not stable: it has a pole at {pole.real:.6g}{imaginary}"


def _over_a_sample(loop: DrivenLoop) -> tuple[FloatArray, FloatArray]:
    """Return transition F and noise covariance, ``(n, n)``, from one sample of a loop to the next.

    The n states are those behind a sample: x -> F x plus noise. `loop`: one sampled loop, with the
    intervals of a sample in `jumps`, each ending in a jump of the states.
    """
    n = len(loop.A)
    F, noise = np.eye(n), np.zeros((n, n))
    for jump in loop.jumps:
        J = jump.matrix
        (step,), (step_noise,) = steps(loop.A, loop.noise, np.array([jump.length]))
        transition = J @ step  # through the interval and its jump
        F = transition @ F
        noise = transition @ noise @ transition.T + J @ step_noise @ J.T + jump.noise
    return F, noise
