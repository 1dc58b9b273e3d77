"""Gains of least quadratic cost."""

from __future__ import annotations

from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, between, instance, nonnegative, number, positive
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.linear.plant import Plant

_HEAVIEST = 1e12
"""Of a weight, and of one over another."""
_NEGLIGIBLE = 1e-8
"""A pole nearer to the axis than this part of the largest is left without a cost."""


def lqr_gains(
    plant: Plant,
    *,
    attitude_weight: float = 1.0,
    rate_weight: float = 0.0,
    alpha_weight: float = 0.0,
    deflection_weight: float = 1.0,
    **options: Any,
) -> Autopilot:
    """Return the autopilot that minimises a quadratic cost, by `control.lqr`.

    The cost is the integral of attitude_weight theta^2 + rate_weight theta'^2 + alpha_weight
    alpha^2 + deflection_weight delta^2, without wind. On a model with drift the third state,
    the flight path angle, is fed back as the angle of attack.

    Parameters
    ----------
    plant : Plant
        One plant, "fixed-path", "drift" or "drift-exact".
    attitude_weight, rate_weight, alpha_weight : float
        Zero or positive.
    deflection_weight : float
        Positive; only the ratios of the weights count.
    **options
        The other arguments of `Autopilot`: actuator, delay, and so on. They are not designed
        for: look at the margins.

    Raises
    ------
    InputError
        For a batch, for "drift-and-speed", whose fourth state an autopilot does not measure, and
        for weights that leave an unstable mode without a cost.
    """
    instance("plant", plant, Plant, "see Plant.from_vehicle")
    if plant.batch or plant.model == "drift-and-speed":
        raise InputError(
            "lqr_gains needs one plant whose states an autopilot measures (fixed-path, drift or"
            f" drift-exact); got {plant.model} of shape {plant.batch}"
        )
    weights = {
        "attitude_weight": attitude_weight,
        "rate_weight": rate_weight,
        "alpha_weight": alpha_weight,
    }
    costs = [number(name, value, nonnegative) for name, value in weights.items()]
    cost = number("deflection_weight", deflection_weight, positive)
    for name, weight in zip((*weights, "deflection_weight"), (*costs, cost), strict=True):
        number(name, weight, between(0.0, _HEAVIEST))
    if cost * _HEAVIEST < max(costs):
        raise InputError(f"deflection_weight must be at least 1/{_HEAVIEST:g} of the others")
    on_attitude, on_rate, *on_path = (-_optimal_feedback(plant, costs, cost)).tolist()
    path = sum(on_path)
    return Autopilot(
        attitude_gain=on_attitude + path,
        rate_gain=on_rate,
        alpha_gain=0.0 - path,
        **options,
    )


def _optimal_feedback(plant: Plant, costs: list[float], cost: float) -> FloatArray:
    """The gains on the states with which delta = -gains . x costs least."""
    import control

    A, B, C, _ = plant.matrices()
    seen = C[[0, 1, -1]]
    Q, R = seen.T @ np.diag(costs) @ seen, np.array([[cost]])
    try:
        gains, _, poles = control.lqr(A, B[:, :1], Q, R, method="scipy")
    except (np.linalg.LinAlgError, control.ControlArgument, ValueError):
        poles, gains = np.ones(1), np.zeros((1, len(A)))
    if np.real(poles).max() >= -_NEGLIGIBLE * np.abs(poles).max():
        raise InputError(
            "the weights leave a mode of the plant without a cost; raise attitude_weight or"
            " alpha_weight"
        )
    return np.asarray(gains[0])
