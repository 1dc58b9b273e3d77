"""A law that is told the estimated angle of attack in place of a measured one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, instance
from tvclin.control.laws.estimator import WindEstimator
from tvclin.control.laws.law import Chains, Law, Measurement
from tvclin.kernels.control_laws import LawNumbers
from tvclin.linear.plant import Plant


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
