"""The recoverable-attitude law: lean into the wind, within the null-controllable region."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.fields import checked, quantity, spec
from tvclin.control.laws.estimator import WindEstimator
from tvclin.control.laws.law import (
    Law,
    Measurement,
    law_rate_limit,
    measured_coordinates,
    rate_limit_angle,
)
from tvclin.kernels.control_laws import LawNumbers, law_demand
from tvclin.linear.plant import Plant


@dataclass(frozen=True)
class RecoverableAttitudeLaw(Law):
    """Law without a forecast: the attitude leans into the wind within the recoverable set.

    With the coordinate z of the unstable mode (see `recoverable`), the measured wind w and D =
    limit/B the law follows a lean Z: as far as the wind, not beyond the fraction `reach` of the
    recoverable set, and not beyond what the design wind requires with the fraction `trust` of the
    limit::

        u = z - k w + gain (z - Z),     |Z| <= min(reach D, k max(A, 1.1 |w|) - trust D)

    A being the design peak. One formula covers full deflection into the wind, holding, the return,
    and attitude feedback near equilibrium. With drift an outer loop on the slow coordinate moves Z.

    Parameters
    ----------
    plant : Plant
        Plant of the design, with one or two real unstable poles.
    reach : float
        Fraction of the recoverable set that is used, in (0, 1]; the rest is the reserve for
        reversals, slow actuators and noise.
    gain : float
        Gain of the feedback on z.
    design_peak : float, optional
        A, the largest expected wind angle [rad]; without it the lean is limited by `reach` alone.
        Too high is safer than too low.
    trust : float
        Fraction of the limit in the design, in (0, 1]. With one the lean is just sufficient if
        limit, B and design peak are exact; less is a reserve for errors of these, and raises the
        deflection in winds that reverse.
    dead_band : float
        Measured winds below this angle [rad] count as zero, which keeps noise from the nozzle.
    rate_limit : float
        Rate limit of the nozzle [rad/s], as the law knows it. The nozzle then turns into the wind
        no further than it can return from at that rate if the wind stops.
    estimator : WindEstimator, optional
        Estimator of the wind; without it the angle of attack is measured exactly.

    Raises
    ------
    InputError
        For a plant without a real unstable pole, a plant whose unstable modes include its speed, a
        batch, and numbers out of range.

    Warns
    -----
    UserWarning
        For an estimator slower than the unstable mode.
    """

    plant: Plant = field(metadata=spec(name="model", of="plant.model"))
    reach: float = quantity("number", 0.9, errors.between(1e-3, 1.0))
    gain: float = quantity("number", 10.0, errors.positive)
    design_peak: float | None = quantity("angle", None, errors.small_angle("a wind angle"))
    trust: float = quantity("number", 0.8, errors.between(1e-3, 1.0))
    dead_band: float = quantity(
        "angle", 0.0, errors.small_angle("a wind angle", errors.nonnegative)
    )
    rate_limit: float = quantity("angular rate", np.inf, law_rate_limit)
    estimator: WindEstimator | None = field(default=None, metadata=spec())

    def __post_init__(self) -> None:
        """Check the numbers and the plant; warn of an estimator slower than the unstable mode.

        A plant without measurable unstable modes raises `InputError`.
        """
        modes = measured_coordinates(self.plant)
        checked(self, "reach", "trust", "gain", "dead_band", "rate_limit", "design_peak")
        if self.design_peak is not None:
            object.__setattr__(self, "design_peak", abs(self.design_peak))
        if self.estimator is None:
            return
        errors.instance("estimator", self.estimator, WindEstimator, "see WindEstimator")
        if self.estimator.bandwidth < modes.poles[0]:
            warnings.warn(
                f"the estimator, bandwidth = {self.estimator.bandwidth:.6g} rad/s, is slower than"
                f" the unstable mode, {modes.poles[0]:.6g} 1/s",
                stacklevel=3,
            )

    @property
    def states(self) -> tuple[FloatArray, FloatArray]:
        """F and G of s' = F s + G m, s the estimator's states; no states without an estimator.

        m: measurements, the first five of `LAW_INPUTS`.
        """
        return super().states if self.estimator is None else self.estimator.states(self.plant)

    @property
    def rate_noise(self) -> tuple[float, int]:
        """Noise of the estimator's gyro [rad/s rms of each sample], and its seed."""
        gyro = self.estimator
        return super().rate_noise if gyro is None else (gyro.rate_noise, gyro.seed)

    @cached_property
    def numbers(self) -> LawNumbers:
        """Parameters of the law for compiled flights, see the class.

        The coordinates [rad] of the fast and, with drift, of the slow unstable mode are sums of
        attitude, its rate and flight path angle, with the factors of a left eigenvector. The law
        leans: it turns the attitude into the wind, up to the fraction `reach` of the largest
        coordinate from which the vehicle can return.
        """
        modes = measured_coordinates(self.plant)
        fast_attitude, fast_rate, fast_path = modes.left_eigenvectors[0].tolist()
        # ratio of the poles: zero with a single mode
        slow = modes.left_eigenvectors[-1] if modes.ratio else np.zeros(3)
        slow_attitude, slow_rate, slow_path = slow.tolist()
        return LawNumbers(
            leans=True,
            fast_attitude=fast_attitude,
            fast_rate=fast_rate,
            fast_path=fast_path,
            slow_attitude=slow_attitude,
            slow_rate=slow_rate,
            slow_path=slow_path,
            ratio=modes.ratio,
            # k of the fast mode, z' = s (z - u - k w): u is deflection/B, w the wind angle, and B
            # trim deflection per angle of attack
            wind=float(modes.wind[0]),
            B=float(self.plant.coefficients.B),
            reach=self.reach,  # of the lean, over the largest recoverable coordinate
            gain=self.gain,
            # beyond the lean that a wind of this peak requires with the fraction `trust` of the
            # limit the law does not lean
            peak=np.inf if self.design_peak is None else self.design_peak,
            trust=self.trust,
            dead_band=self.dead_band,
            # reach times the change of u [rad] at full rate in a time constant of the fast mode
            rate_travel=self.reach * rate_limit_angle(self.plant, self.rate_limit),
            estimates=self.estimator is not None,
        )

    def demand(self, measured: Measurement, states: FloatArray, limit: Any) -> Any:
        """Return the demanded deflection [rad], before the limit, for each of a batch of flights.

        `measured`: numbers or ``(...)``, of which four count: attitude, its rate, flight path
        angle, angle of attack. `states`: of the estimator, ``(2, ...)``, or none. `limit`: [rad].
        """
        angles = measured[:4]
        shape = np.broadcast_shapes(*(np.shape(value) for value in (*angles, limit)))
        if not shape and states.ndim == 1:
            return law_demand(self.numbers, measured, states.tolist(), limit)
        columns = (
            np.broadcast_to(value, shape).ravel().tolist() for value in (*angles, *states, limit)
        )
        flights = zip(*columns, strict=True)  # of each four angles, states and the limit
        demands = [law_demand(self.numbers, row[:4], row[4:-1], row[-1]) for row in flights]
        return np.array(demands).reshape(shape)
