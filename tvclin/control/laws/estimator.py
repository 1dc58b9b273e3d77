"""Wind estimation from attitude, rate and measured deflection: a disturbance observer.

`WindEstimator` is the observer, `EstimatedLaw` any law that takes the angle of attack from it
instead of from a vane.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Carded
from tvclin.base.errors import (
    InputError,
    instance,
    nonnegative,
    nonzero,
    number,
    positive,
    single,
    whole_number,
)
from tvclin.control.laws.law import Chains, Law, Measurement
from tvclin.kernels.control_laws import LawNumbers
from tvclin.linear.plant import Plant

_DAMPING = 0.7


@dataclass(frozen=True, kw_only=True)
class WindEstimator(Carded):
    """An observer of the attitude rate and of d = gamma + alpha_w, without a vane.

        q^' = mu_alpha (theta - d^) - mu_delta delta - damping q + 2 zeta w (q - q^)
        d^' = -(w^2/mu_alpha) (q - q^),        zeta = 0.7

    The error of d^ follows d' like a second-order system of natural frequency w. The angle of
    attack is theta - d^, and the wind d^ - gamma, gamma being known from inertial data.

    Parameters
    ----------
    bandwidth : float
        w [rad/s], positive.
    rate_noise : float
        Noise of the measured attitude rate [rad/s], rms for each sample of the law.
    seed : int
        Seed of the noise.

    Raises
    ------
    InputError
        For numbers out of range.
    """

    bandwidth: float
    rate_noise: float = 0.0
    seed: int = 0

    _keys = "bandwidth_rad_per_s rate_noise_deg_per_s seed"

    def __post_init__(self) -> None:
        object.__setattr__(
            self, "bandwidth", number("bandwidth", self.bandwidth, positive, "rad/s")
        )
        noise = number("rate_noise", self.rate_noise, nonnegative, "rad/s")
        object.__setattr__(self, "rate_noise", noise)
        object.__setattr__(self, "seed", whole_number("seed", self.seed))

    def states(self, plant: Plant) -> tuple[FloatArray, FloatArray]:
        """Return F and G of the observer's states q^ and d^, for the plant it believes in."""
        instance("plant", plant, Plant, "see Plant.from_vehicle")
        single("plant", plant.batch)
        c, w = plant.coefficients, self.bandwidth
        mu_alpha = float(nonzero("mu_alpha", c.mu_alpha, "1/s^2"))
        gains = np.array([2.0 * _DAMPING * w, -(w**2) / mu_alpha])
        F = np.array([[-gains[0], -mu_alpha], [-gains[1], 0.0]])
        G = np.zeros((2, 5))
        G[0, 0], G[0, 4] = mu_alpha, -float(c.mu_delta)
        G[:, 1] = gains
        G[0, 1] -= float(c.damping)
        return F, G


@dataclass(frozen=True)
class EstimatedLaw(Law):
    """Any law, with a wind estimator in place of a vane.

    The law sees the rate q^ and the angle of attack theta - d^ of the estimator; attitude, flight
    path angle and deflection are measured.

    Parameters
    ----------
    law : Law
        The law, without an estimator of its own.
    estimator : WindEstimator
        The estimator, and the noise of its gyro.
    plant : Plant
        The plant that the estimator believes in.

    Raises
    ------
    InputError
        For a batch, a plant without aerodynamic moment, and a law that estimates already.

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
        instance("law", self.law, Law, "such as SaturatedLaw")
        instance("estimator", self.estimator, WindEstimator, "see WindEstimator")
        own = self.law.numbers
        if isinstance(self.law, EstimatedLaw) or (own is not None and own.estimates):
            raise InputError("law has an estimator already; give it the angle of attack of one")
        self.estimator.states(self.plant)
        for name in ("engage", "release"):
            object.__setattr__(self, name, getattr(self.law, name))

    @property
    def states(self) -> tuple[FloatArray, FloatArray]:
        """Those of the estimator, then those of the law, which see what it estimates."""
        (F, G), (own, seen) = self.estimator.states(self.plant), self.law.states
        told = seen.copy()
        told[:, 0] += seen[:, 3]  # theta - d^ in place of alpha, and q^ in place of theta'
        told[:, [1, 3]] = 0.0
        coupled = np.column_stack([seen[:, 1], -seen[:, 3]])
        return np.block([[F, np.zeros((2, len(own)))], [coupled, own]]), np.vstack([G, told])

    @property
    def chains(self) -> Chains:
        """Those of the law; sensors are filtered ahead of the estimator."""
        return self.law.chains

    @property
    def rate_noise(self) -> tuple[float, int]:
        """That of the estimator's gyro."""
        return self.estimator.rate_noise, self.estimator.seed

    @property
    def numbers(self) -> LawNumbers | None:
        """Those of the law, which estimates."""
        own = self.law.numbers
        return None if own is None else own._replace(estimates=True)

    def demand(self, measured: Measurement, states: FloatArray, limit: Any) -> Any:
        """Return what the law asks for [rad]."""
        alpha = measured.attitude - states[1]
        told = measured._replace(attitude_rate=states[0], angle_of_attack=alpha)
        return self.law.demand(told, states[2:], limit)
