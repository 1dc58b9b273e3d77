"""Warnings of numbers of an autopilot that are legal but hardly ever meant."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.control.autopilot.feedback import Feedback
from tvclin.control.autopilot.wiring import exact_loop
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.flexible_modes import named_modes
from tvclin.linear.modes import unstable_poles
from tvclin.numerics.stability import stability


def warn_of_feedback(autopilot: Feedback, plant: AnyPlant, stacklevel: int = 3) -> None:
    """Warn of zero gains, positive feedback, and an actuator slower than the plant.

    The warning points at the caller of the method that asks, which is three levels up.
    """
    plant = plant.rigid
    mu_delta = np.asarray(plant.coefficients.mu_delta)
    stiffness = np.asarray(autopilot.attitude_gain) + autopilot.alpha_gain
    name = "attitude_gain + alpha_gain" if np.any(autopilot.alpha_gain) else "attitude_gain"
    # A stable vehicle has a stiffness of its own, on the angle of attack. Feedback of that angle
    # may give it back, but no feedback of the attitude alone is meant to.
    own = np.maximum(-np.asarray(plant.coefficients.mu_alpha), 0.0)
    own = np.where((stiffness != 0.0) & (np.asarray(autopilot.alpha_gain) == 0.0), 0.0, own)
    gains: list[tuple[str, Any, Any, str]] = [
        (name, stiffness, own, "holds"),
        ("rate_gain", np.asarray(autopilot.rate_gain), plant.coefficients.damping, "damps"),
    ]
    if np.any(autopilot.integral_gain):
        gains.append(("integral_gain", np.asarray(autopilot.integral_gain), 0.0, ""))
    for name, gains_of_all, own_of_all, does in gains:
        gain, per, has = np.broadcast_arrays(gains_of_all, mu_delta, own_of_all)
        worst = np.unravel_index(np.argmin(gain * per + has), gain.shape)
        if gain[worst] * per[worst] + has[worst] < 0.0:
            warnings.warn(
                f"{name} = {gain[worst]:.6g} is positive feedback on a plant with"
                f" mu_delta = {per[worst]:.6g} 1/s^2; give it the sign of mu_delta",
                stacklevel=stacklevel,
            )
        elif gain[worst] == has[worst] == 0.0:
            warnings.warn(f"{name} is zero: nothing {does} the attitude", stacklevel=stacklevel)
    if autopilot.actuator is None:
        return
    poles = np.real(unstable_poles(plant))
    fastest = np.nan_to_num(poles).max(axis=-1, initial=0.0)
    slow = np.asarray(autopilot.actuator.natural_frequency) < fastest
    if np.any(slow):
        frequency = np.min(autopilot.actuator.natural_frequency)
        warnings.warn(
            f"the actuator, natural_frequency = {frequency:.6g} rad/s, is slower than the"
            f" fastest unstable pole of the plant, {np.max(fastest):.6g} 1/s",
            stacklevel=stacklevel,
        )


def warn_of_sampling(autopilot: Feedback, plant: AnyPlant) -> None:
    """Warn of a mode that is sampled less than twice in its period; points as the other."""
    if autopilot.sample_rate is None or plant.structure is None:
        return
    names, poles = named_modes(plant)
    rate = np.asarray(autopilot.sample_rate)[..., np.newaxis]
    cycles = np.imag(poles) / (2.0 * np.pi)
    slow = np.any(np.atleast_2d(rate < 2.0 * cycles).reshape(-1, len(names)), axis=0)
    if np.any(slow):
        which = ", ".join(name for name, is_slow in zip(names, slow, strict=True) if is_slow)
        warnings.warn(
            f"sample_rate = {np.min(rate):.6g} Hz is below twice the frequency of {which}, which"
            " sampling aliases to another frequency (see band_margins)",
            stacklevel=3,
        )


def pade_misleads(autopilot: Feedback, plant: AnyPlant, A: FloatArray) -> bool:
    """Return whether the closed loop A, with a Pade approximation, differs in its stability."""
    if not autopilot.delay:
        return False
    exact = stability(exact_loop(autopilot, plant).form)
    unstable = int(np.sum(np.real(np.linalg.eigvals(A)) > 0.0))
    return not bool(exact.marginal[0]) and unstable != int(exact.unstable_poles[0])
