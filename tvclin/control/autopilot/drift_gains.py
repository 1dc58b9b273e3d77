"""Gains that bring a vehicle back to its nominal path, and the steady drift of any gains.

In a constant wind the path settles where the moment and the force across the path vanish. With
w = C2/mu_alpha, phi = theta - gamma and alpha = phi - alpha_w,

    (b1 + w) phi + w gamma = (b1 - b2) alpha_w,
    (a0 + d1 V) gamma = (B - b0 - g V (b1 - b2)) alpha - a0 phi.

Without gravity phi and alpha do not depend on the gains. With a gain on the drift gamma is zero.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tvclin.base.arrays import ComplexArray, FloatArray
from tvclin.base.errors import InputError, broadcast, instance, number, plain
from tvclin.control.autopilot.actuator import positive_in_range
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import Feedback
from tvclin.linear.lateral import LateralSensors
from tvclin.linear.plant import Plant

_RELATIVE_POLE_ERROR = 1e-6
"""Largest relative error of a placed pole."""


def drift_gains(
    plant: Plant,
    *,
    natural_frequency: float,
    damping: float,
    drift_frequency: float,
    drift_damping: float,
    **options: Any,
) -> Autopilot:
    """Return the autopilot that places the poles of attitude and drift, by `control.place`.

    Attitude, its rate, drift rate and drift are fed back, without actuator and delay; the drift
    returns to zero in a constant wind.

    Parameters
    ----------
    plant : Plant
        One plant with a flight path and a known speed, "drift" or "drift-exact".
    natural_frequency, damping : float
        Of the faster pair of poles [rad/s] and [-], positive.
    drift_frequency, drift_damping : float
        Of the slower pair [rad/s] and [-], positive.
    **options
        The other arguments of `Autopilot`: actuator, delay, and so on. They are not designed for:
        look at the margins.

    Raises
    ------
    InputError
        For a batch, another model, numbers that are not positive, and equal poles.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> made = tv.control.drift_gains(plant, natural_frequency=1.2, damping=0.7,
    ...                               drift_frequency=0.1, drift_damping=0.8)
    >>> made.closed_loop_poles(plant).round(3)[::2]
    array([-0.84+0.857j, -0.08+0.06j ])
    >>> tv.control.steady_drift(made, plant)
    0.0
    """
    import control

    speed = _speed(plant)
    if plant.batch:
        raise InputError(f"drift_gains is for one plant; got a batch of shape {plant.batch}")
    pairs = (
        ("natural_frequency", natural_frequency, "damping", damping),
        ("drift_frequency", drift_frequency, "drift_damping", drift_damping),
    )
    poles = np.concatenate([_pair(*pair) for pair in pairs])
    system = LateralSensors(drift=True).system(plant)
    A, B = _per_speed(system.A, float(speed)), system.B[:, :1]
    try:
        gains = control.place(A, B, poles)[0]
    except ValueError:
        gains = np.full(4, np.nan)
    placed = np.linalg.eigvals(A - B * np.nan_to_num(gains))
    errors = np.abs(placed[:, np.newaxis] - poles).min(axis=0)
    if not np.all(errors < _RELATIVE_POLE_ERROR * np.abs(poles)):
        raise InputError(
            "the poles of attitude and drift cannot be placed: give them different frequencies or"
            " damping ratios, and no damping ratio of 1"
        )
    on_attitude, on_rate, on_path, on_drift = (-gains).tolist()
    return Autopilot(
        attitude_gain=on_attitude,
        rate_gain=on_rate,
        drift_rate_gain=on_path / float(speed),
        drift_gain=on_drift / float(speed),
        **options,
    )


def steady_drift(autopilot: Feedback, plant: Plant) -> float | FloatArray:
    """Return the steady drift rate in a constant wind, per wind angle [m/s per rad], ``(...)``.

    The velocity normal to the nominal path to which the vehicle settles where the loop is stable;
    zero with a gain on the drift.

    Parameters
    ----------
    autopilot : Autopilot
        One autopilot or a batch.
    plant : Plant
        One plant or a batch with a known speed, "drift" or "drift-exact"; it broadcasts with the
        gains.

    Raises
    ------
    InputError
        For another model, coefficients without velocity, and a controller in state space.

    Notes
    -----
    With w = C2/mu_alpha, zero in the model "drift", and k = B - b0 - g V (b1 - b2),
    gamma/alpha_w = ((k - a0) (b1 - b2)/(b1 + w) - k)/(a0 + d1 V + (k - a0) w/(b1 + w)); with an
    integral of the attitude -(b1 - b2)/b1.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> gains = tv.design_gains(plant, natural_frequency=1.2, damping=0.7)
    >>> round(tv.control.steady_drift(gains, plant) * 3.14159 / 180, 2)  # m/s per deg
    -5.04
    """
    speed = _speed(plant)
    instance("autopilot", autopilot, Feedback, "see design_gains")
    if autopilot.controller is not None:
        raise InputError("steady_drift is of gains; of a controller see its wind_response")
    broadcast(autopilot=autopilot.batch, plant=plant.batch)
    c = plant.coefficients
    b1, difference = np.asarray(c.b1), np.asarray(c.b1 - c.b2)
    gravity = 0.0 if plant.model == "drift" else c.C2 / np.asarray(c.mu_alpha)
    if np.any(autopilot.drift_gain):
        path = np.zeros(np.broadcast_shapes(autopilot.batch, plant.batch))
    elif np.any(autopilot.integral_gain):
        path = -difference / b1
    else:
        a0 = np.asarray(autopilot.attitude_gain)
        k = c.B - autopilot.alpha_gain - autopilot.acceleration_gain * speed * difference
        rest = a0 + autopilot.drift_rate_gain * speed + (k - a0) * gravity / (b1 + gravity)
        path = ((k - a0) * difference / (b1 + gravity) - k) / rest
    return plain(np.asarray(speed * path))


def _speed(plant: Plant) -> FloatArray:
    """Return the speed of a plant [m/s]; `InputError` for another model, or without a speed."""
    instance("plant", plant, Plant, "see Plant.from_vehicle")
    if not plant.is_rigid or plant.model not in ("drift", "drift-exact"):
        raise InputError(f"drift needs a plant drift or drift-exact; got {plant.model}")
    plant.lateral_rows("drift_rate", 0.0)  # raises without a speed
    return np.asarray(plant.coefficients.velocity)


def _pair(name: str, frequency: float, damping_name: str, damping: float) -> ComplexArray:
    """Return the two poles [1/s] of a natural frequency [rad/s] and a damping ratio."""
    w = number(name, frequency, positive_in_range, "rad/s")
    ratio = number(damping_name, damping, positive_in_range)
    return np.roots([1.0, 2.0 * ratio * w, w**2]).astype(complex)


def _per_speed(A: FloatArray, speed: float) -> FloatArray:
    """Return A for the drift over the speed [s] as last state."""
    scale = np.array([1.0, 1.0, 1.0, speed])
    return A * scale / scale[:, np.newaxis]
