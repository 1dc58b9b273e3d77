"""Gains from the poles that they should give."""

from typing import Any

from tvclin.autopilot.actuator import one_number
from tvclin.autopilot.feedback import Autopilot, require_single
from tvclin.coefficients import Coefficients
from tvclin.errors import positive


def canonical_gains(coefficients: Coefficients, **options: Any) -> Autopilot:
    """Return the autopilot with a0 = 2B and a1 = B/beta.

    On eq (5), without actuator and delay, the closed loop is s^2 + beta s + beta^2: natural
    frequency beta, damping ratio 0.5.

    Parameters
    ----------
    coefficients : Coefficients
        Those of one aerodynamically unstable vehicle; for others see `design_gains`.
    **options
        The other arguments of `Autopilot`: actuator, delay, and so on.

    Raises
    ------
    InputError
        For a stable vehicle, which has no beta, and for a batch.
    """
    require_single(coefficients, Coefficients)
    B, beta = float(coefficients.B), float(coefficients.beta)
    return Autopilot(attitude_gain=2.0 * B, rate_gain=B / beta, **options)


def design_gains(
    coefficients: Coefficients, *, natural_frequency: float, damping: float, **options: Any
) -> Autopilot:
    """Return the autopilot that gives eq (5) the poles asked for.

    Without actuator and delay the closed loop is
    s^2 + mu_delta a1 s + (mu_delta a0 - mu_alpha) = s^2 + 2 damping omega_n s + omega_n^2.

    Parameters
    ----------
    coefficients : Coefficients
        Those of one vehicle, stable or not.
    natural_frequency : float
        omega_n [rad/s] of the closed loop, positive.
    damping : float
        Damping ratio of the closed loop, positive.
    **options
        The other arguments of `Autopilot`: actuator, delay, and so on.

    Raises
    ------
    InputError
        For numbers that are not positive, and for a batch.
    """
    require_single(coefficients, Coefficients)
    frequency = one_number("natural_frequency", positive, natural_frequency, "rad/s")
    ratio, c = one_number("damping", positive, damping), coefficients
    return Autopilot(
        attitude_gain=float((frequency**2 + c.mu_alpha) / c.mu_delta),
        rate_gain=float(2.0 * ratio * frequency / c.mu_delta),
        **options,
    )
