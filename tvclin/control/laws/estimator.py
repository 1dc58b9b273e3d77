"""The wind from attitude, rate and measured deflection: a disturbance observer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Carded
from tvclin.base.errors import (
    instance,
    nonnegative,
    nonzero,
    number,
    positive,
    single,
    whole_number,
)
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
