"""Wind estimation from attitude, rate and measured deflection: a disturbance observer.

`WindEstimator` is the observer, `EstimatedLaw` any law that takes the angle of attack from it
instead of from a vane.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Record
from tvclin.base.fields import checked, count, quantity
from tvclin.control.laws.autopilot_law import SystemLaw
from tvclin.control.laws.law import Chains, Law, Measurement
from tvclin.kernels.control_laws import LawNumbers
from tvclin.linear.lateral import LateralSensors
from tvclin.linear.plant import Plant

_OBSERVER_DAMPING = 0.7
"""Damping ratio of the observer's error."""


@dataclass(frozen=True, kw_only=True)
class WindEstimator(Record):
    """Observer of the attitude rate q and of d = gamma + alpha_w, without a vane.

        q^' = mu_alpha (theta - d^) - mu_delta delta - damping q + 2 zeta w (q - q^)
        d^' = -(w^2/mu_alpha) (q - q^),        zeta = 0.7

    The error of d^ responds to d' as a second-order system of natural frequency w. The angle of
    attack is theta - d^, and the wind d^ - gamma, gamma being known from inertial data.

    Parameters
    ----------
    bandwidth : float
        w [rad/s], positive.
    rate_noise : float
        Noise of the measured attitude rate [rad/s], rms of each sample.
    seed : int
        Seed of the noise.

    Raises
    ------
    InputError
        For numbers out of range.
    """

    bandwidth: float = quantity("natural frequency", check=errors.positive)
    rate_noise: float = quantity("angular rate", 0.0, errors.nonnegative)
    seed: int = count(0)

    def __post_init__(self) -> None:
        """Check bandwidth, noise and seed."""
        checked(self)

    def states(self, plant: Plant) -> tuple[FloatArray, FloatArray]:
        """Return F ``(2, 2)`` and G ``(2, 5)`` of s' = F s + G m, the equations of the observer.

        s are the estimates q^ of the attitude rate [rad/s] and d^ of gamma + alpha_w [rad], m the
        measurements attitude, its rate q, flight path angle, angle of attack, and deflection. The
        gains on the error q - q^ give it the natural frequency `bandwidth` and a damping of 0.7.
        `plant`: the model, one plant; its aerodynamic moment mu_alpha [1/s^2] is not zero.
        """
        errors.instance("plant", plant, Plant, "see Plant.from_vehicle")
        errors.single("plant", plant.batch)
        c, w = plant.coefficients, self.bandwidth
        mu_alpha = float(errors.nonzero("mu_alpha", c.mu_alpha, "1/s^2"))
        on_rate, on_wind = 2.0 * _OBSERVER_DAMPING * w, -(w**2) / mu_alpha  # gains on q - q^
        F = np.array([[-on_rate, -mu_alpha], [-on_wind, 0.0]])
        mu_delta, damping = float(c.mu_delta), float(c.damping)
        G = np.array(
            [[mu_alpha, on_rate - damping, 0.0, 0.0, -mu_delta], [0.0, on_wind, 0.0, 0.0, 0.0]]
        )
        return F, G


@dataclass(frozen=True)
class EstimatedLaw(Law):
    """Law with a wind estimator instead of a vane.

    The law takes the rate q^ and the angle of attack theta - d^ from the estimator; attitude,
    flight path angle and deflection are measured.

    Parameters
    ----------
    law : Law
        The law, without an estimator.
    estimator : WindEstimator
        The estimator, and the noise of its gyro.
    plant : Plant
        Model of the estimator.

    Raises
    ------
    InputError
        For a batch, a plant without aerodynamic moment, and a law that has an estimator.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> law = tv.SaturatedLaw(tv.control.half_relief_gains(plant.coefficients))
    >>> blind = tv.control.EstimatedLaw(law, tv.control.WindEstimator(bandwidth=10.0), plant)
    """

    law: Law
    estimator: WindEstimator
    plant: Plant

    def __post_init__(self) -> None:
        """Check that the law has no estimator, and take over its levels `engage` and `release`."""
        errors.instance("law", self.law, Law, "such as SaturatedLaw")
        errors.instance("estimator", self.estimator, WindEstimator, "see WindEstimator")
        if isinstance(self.law, SystemLaw):
            raise errors.InputError(
                "a controller in state space takes no estimator; put one into it"
            )
        numbers = self.law.numbers
        if isinstance(self.law, EstimatedLaw) or (numbers is not None and numbers.estimates):
            raise errors.InputError(
                "law has an estimator already; give it the angle of attack of one"
            )
        self.estimator.states(self.plant)  # raises for a batch, and without aerodynamic moment
        for name in ("engage", "release"):
            object.__setattr__(self, name, getattr(self.law, name))

    @property
    def states(self) -> tuple[FloatArray, FloatArray]:
        """F and G of s' = F s + G m, the estimator's states before the law's; m: measurements.

        m are attitude theta, its rate, flight path angle, angle of attack alpha, deflection. The
        estimator's states are q^, the estimate of the rate, and d^, of gamma + alpha_w: the law's
        states follow q^ in place of the rate, and theta - d^ in place of alpha.
        """
        (F, G), (F_law, G_law) = self.estimator.states(self.plant), self.law.states
        on_theta, on_rate, on_path, on_alpha, on_deflection = G_law.T
        none = np.zeros(len(F_law))
        G_law = np.column_stack([on_theta + on_alpha, none, on_path, none, on_deflection])
        coupling = np.column_stack([on_rate, -on_alpha])  # of the law's states with q^ and d^
        zeros = np.zeros((2, len(F_law)))
        return np.block([[F, zeros], [coupling, F_law]]), np.vstack([G, G_law])

    @property
    def chains(self) -> Chains:
        """Filter chains of the law; sensors are filtered before the estimator."""
        return self.law.chains

    @property
    def lateral_sensors(self) -> LateralSensors:
        """Sensors of lateral motion of the law."""
        return self.law.lateral_sensors

    @property
    def rate_noise(self) -> tuple[float, int]:
        """Noise of the estimator's gyro [rad/s rms of each sample], and its seed."""
        return self.estimator.rate_noise, self.estimator.seed

    @property
    def numbers(self) -> LawNumbers | None:
        """Parameters of the law for compiled flights, with an estimator."""
        numbers = self.law.numbers
        return None if numbers is None else numbers._replace(estimates=True)

    def demand(self, measured: Measurement, states: FloatArray, limit: Any) -> Any:
        """Return the demanded deflection [rad], before the limit [rad].

        `measured`: its rate and angle of attack are replaced by estimates. `states`: of the
        estimator the rate q^ and the sum d^ of flight path angle and wind, and of the law, ``(k,
        ...)``.
        """
        rate, path_and_wind, *_ = states
        alpha = measured.attitude - path_and_wind
        estimated = measured._replace(attitude_rate=rate, angle_of_attack=alpha)
        return self.law.demand(estimated, states[2:], limit)
