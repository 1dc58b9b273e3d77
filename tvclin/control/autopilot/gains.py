"""Gains of an autopilot by pole placement, wind relief or quadratic cost, and over the flight.

On a fixed path, eq (5), without actuator and delay, and with the vehicle's damping d, the loop is

    s^2 + (mu_delta a1 + d) s + mu_delta (a0 + b0) - mu_alpha = s^2 + 2 zeta omega_n s + omega_n^2,

which gives a1 and the sum a0 + b0. How the sum is divided between attitude and angle of attack sets
how far the vehicle turns into a steady wind: alpha/alpha_w = -a0/(a0 + b0 - B). All gains have the
shape of the coefficients: every flight condition in one call.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import (
    InputError,
    between,
    broadcast,
    callable_for,
    finite,
    instance,
    nonnegative,
    number,
    plain,
    positive,
)
from tvclin.control.autopilot.actuator import sized
from tvclin.control.autopilot.autopilot import Autopilot, warn_of_feedback
from tvclin.control.autopilot.feedback import GAINS
from tvclin.control.margins.margins import Margins, loop_margins
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.linear_vehicle import AnyVehicle, coefficients_of

Steered = AnyPlant | AnyVehicle | Coefficients
"""What gains are made for; of a vehicle they are those of the pitch plane."""

_FREQUENCY, _DAMPING = 2.4, 1.2
"""Of the loop of half relief: natural frequency, over the unstable pole, and damping ratio."""


def canonical_gains(plant: Steered, **options: Any) -> Autopilot:
    """Return the autopilot with a0 = 2B and a1 = B/beta.

    On eq (5), without actuator and delay, the closed loop is s^2 + beta s + beta^2: natural
    frequency beta, damping ratio 0.5. A damping d of the vehicle comes on top: (beta + d) s.

    Parameters
    ----------
    plant : Plant, FlexiblePlant, vehicle or Coefficients
        Of one aerodynamically unstable vehicle or of a batch; for others see
        `design_gains`.
    **options
        The other arguments of `Autopilot`: actuator, delay, and so on.

    Raises
    ------
    InputError
        For a stable vehicle, which has no beta.
    """
    coefficients = _coefficients(plant)
    mu_alpha = np.min(coefficients.mu_alpha, initial=np.inf)
    if mu_alpha <= 0.0:
        raise InputError(
            "canonical gains need an aerodynamically unstable vehicle, mu_alpha > 0; got"
            f" {mu_alpha:.6g} 1/s^2 (choose a natural_frequency and use design_gains instead)"
        )
    with np.errstate(over="ignore"):  # an Autopilot refuses what is not finite
        B, rate = coefficients.B, coefficients.B / coefficients.beta
    return Autopilot(attitude_gain=2.0 * B, rate_gain=rate, **options)


def design_gains(
    plant: Steered, *, natural_frequency: ArrayLike, damping: ArrayLike, **options: Any
) -> Autopilot:
    """Return the autopilot that gives eq (5) the poles asked for.

    Without actuator and delay, d being the vehicle's own damping, the closed loop is
    s^2 + (mu_delta a1 + d) s + (mu_delta a0 - mu_alpha) = s^2 + 2 damping omega_n s + omega_n^2.

    Parameters
    ----------
    plant : Plant, FlexiblePlant, vehicle or Coefficients
        Of one vehicle or of a batch, stable or not.
    natural_frequency : array_like
        omega_n [rad/s] of the closed loop, positive.
    damping : array_like
        Damping ratio of the closed loop, positive.
    **options
        The other arguments of `Autopilot`: actuator, delay, and so on.

    Raises
    ------
    InputError
        For numbers that are not positive, and for less damping than the vehicle has by itself.
    """
    stiffness, rate = _stiffness(_coefficients(plant), natural_frequency, damping)
    return Autopilot(attitude_gain=stiffness, rate_gain=rate, **options)


def relief_gains(
    plant: Steered,
    *,
    natural_frequency: ArrayLike,
    damping: ArrayLike,
    alpha_ratio: ArrayLike,
    **options: Any,
) -> Autopilot:
    """Return the autopilot that leaves a given part of a steady wind as angle of attack.

    The attitude answers as with `design_gains`, but part of the stiffness comes from the angle
    of attack, so that the vehicle turns into the wind:

        a0 = ratio omega_n^2/mu_delta,    a0 + b0 = (omega_n^2 + mu_alpha)/mu_delta

    Parameters
    ----------
    plant : Plant, FlexiblePlant, vehicle or Coefficients
        Of one vehicle or of a batch, stable or not.
    natural_frequency, damping : array_like
        Of the closed loop on a fixed path [rad/s] and [-], positive.
    alpha_ratio : array_like
        Size of alpha/alpha_w when the attitude has settled in a steady wind and the flight path
        has not yet changed, zero or positive. Pure attitude hold has 1 + mu_alpha/omega_n^2 =
        a0/(a0 - B), above one.
    **options
        The other arguments of `Autopilot`: actuator, delay, and so on.

    Raises
    ------
    InputError
        For numbers out of range.

    Notes
    -----
    With theta'' = theta' = 0 the autopilot asks for a0 theta + b0 alpha = B alpha, and before
    the path has changed theta = alpha + alpha_w; so alpha = -a0/(a0 + b0 - B) alpha_w.
    With drift the slow pole of the closed loop lies near w - ratio (b1 + w), where
    w = C2/mu_alpha = g sin(Theta_n)/V_n: below the ratio w/(b1 + w) gravity turns the path away.
    """
    coefficients, ratio = _coefficients(plant), nonnegative("alpha_ratio", alpha_ratio)
    stiffness, rate = _stiffness(coefficients, natural_frequency, damping)
    broadcast(gains=np.shape(stiffness), alpha_ratio=ratio.shape)
    with np.errstate(over="ignore"):
        attitude = ratio * np.asarray(natural_frequency, float) ** 2 / coefficients.mu_delta
    return Autopilot(
        attitude_gain=attitude, rate_gain=rate, alpha_gain=stiffness - attitude, **options
    )


def half_relief_gains(plant: Steered, **options: Any) -> Autopilot:
    """Return the autopilot that turns the vehicle by half of the wind: gains for a small limit.

    They are `relief_gains` with a natural frequency of 2.4 p, a damping ratio of 1.2 and an alpha
    ratio of one half, p being the unstable pole on a fixed path. Behind a stop (`SaturatedLaw`)
    they need hardly more than one half of trim in winds that rise and fall, also where these stop
    at any instant; in gusts that reverse they need more.

    Parameters
    ----------
    plant : Plant, FlexiblePlant, vehicle or Coefficients
        Of one aerodynamically unstable vehicle or of a batch.
    **options
        The other arguments of `Autopilot`: actuator, delay, and so on.

    Raises
    ------
    InputError
        For a stable vehicle, which has no unstable pole, and for one whose own damping is above
        5.76 p.

    Notes
    -----
    In a steady wind the nozzle stands at r of trim and the attitude at 1 - r of the wind, r being
    the alpha ratio. To hold that takes a limit above r, and to come back from there when the wind
    stops one above 1 - r. In slow winds the larger of the two is enough, and least for one half. A
    smaller ratio, less damping or a higher frequency overshoot the lean, and a stop just behind the
    peak may then cost a tenth of trim at once.

    Examples
    --------
    >>> import tvclin as tv
    >>> c = tv.Coefficients.from_beta(beta=0.5, B=0.1)
    >>> gains = tv.control.half_relief_gains(c)
    >>> [round(float(gain), 3) for gain in (gains.attitude_gain, gains.rate_gain, gains.alpha_gain)]
    [0.288, 1.152, 0.388]
    >>> wind = tv.TriangularWind(peak=0.1, duration=8.0)
    >>> law, plant = tv.SaturatedLaw(gains), tv.Plant.from_coefficients(c)
    >>> round(tv.closed_loop_boundary(plant, law, wind, sample_rate=50, cuts=12).limit, 2)
    0.45
    """
    coefficients = _coefficients(plant)
    if np.any(np.asarray(coefficients.mu_alpha) <= 0.0):
        raise InputError(
            "half-relief gains need an aerodynamically unstable vehicle, mu_alpha > 0; got"
            f" {np.min(coefficients.mu_alpha):.6g} 1/s^2 (use relief_gains instead)"
        )
    return relief_gains(
        coefficients,
        natural_frequency=plain(np.asarray(_FREQUENCY * coefficients.pole)),
        damping=_DAMPING,
        alpha_ratio=0.5,
        **options,
    )


def drift_minimum_gains(
    plant: Steered, *, natural_frequency: ArrayLike, damping: ArrayLike, **options: Any
) -> Autopilot:
    """Return the autopilot whose flight path does not turn in a steady wind.

    The vehicle leans into the wind until thrust and lift across the path cancel. The size of
    alpha/alpha_w is then (b2 + w)/(b1 + w), with w = C2/mu_alpha = g sin(Theta_n)/V_n; without
    drag and weight it is 1/(1 + (N/T)(1 + l_a/l_c)).

    Parameters
    ----------
    plant : Plant, FlexiblePlant, vehicle or Coefficients
        Of one vehicle or of a batch, with b1 and b2, and mu_alpha other than zero.
    natural_frequency, damping : array_like
        Of the closed loop on a fixed path [rad/s] and [-], positive; the first not below that
        of an aerodynamically stable vehicle itself.
    **options
        The other arguments of `Autopilot`: actuator, delay, and so on.

    Raises
    ------
    InputError
        For coefficients without drift or with b1 + w or b2 + w below zero, and numbers out of
        range.

    Notes
    -----
    gamma' = 0 at gamma = 0 in eq (B6) with the attitude settled: (b1 + w) alpha +
    (b2 + w) alpha_w = 0. The principle is Hoelkner's.
    """
    c = _coefficients(plant)
    if np.any(np.asarray(c.mu_alpha) == 0.0) or np.any(np.asarray(c.b1) == 0.0):
        raise InputError(
            "drift-minimum gains need coefficients with drift (b1, b2, C2) and mu_alpha other"
            " than zero; make them with Coefficients.from_vehicle"
        )
    along = c.C2 / np.asarray(c.mu_alpha)
    thrust, lift = np.broadcast_arrays(c.b1 + along, c.b2 + along)
    worst = np.unravel_index(np.argmin(np.minimum(thrust, lift)), thrust.shape)
    if thrust[worst] <= 0.0 or lift[worst] < 0.0:
        raise InputError(
            "there are no drift-minimum gains: no attitude in a steady wind keeps the path of this"
            f" vehicle, whose b1 + w = {thrust[worst]:.6g} and b2 + w = {lift[worst]:.6g} 1/s (w ="
            " C2/mu_alpha) would have to be positive; use design_gains instead"
        )
    _stiffen(c, natural_frequency)
    return relief_gains(
        c,
        natural_frequency=natural_frequency,
        damping=damping,
        alpha_ratio=lift / thrust,
        **options,
    )


def load_minimum_gains(
    plant: Steered, *, natural_frequency: ArrayLike, damping: ArrayLike, **options: Any
) -> Autopilot:
    """Return the autopilot that turns the nose wholly into a steady wind: a0 = 0.

    The angle of attack, and with it the bending moment, goes to zero. Nothing holds the attitude
    any more: with drift and gravity the flight path runs away slowly, near e^(C2/mu_alpha t), and
    margins on the exact models say so.

    Parameters
    ----------
    plant : Plant, FlexiblePlant, vehicle or Coefficients
        Of one vehicle or of a batch.
    natural_frequency, damping, **options
        As of `drift_minimum_gains`.

    Raises
    ------
    InputError
        For numbers out of range.
    """
    coefficients = _coefficients(plant)
    _stiffen(coefficients, natural_frequency)
    return relief_gains(
        coefficients,
        natural_frequency=natural_frequency,
        damping=damping,
        alpha_ratio=0.0,
        **options,
    )


def _coefficients(plant: Steered) -> Coefficients:
    """Return the coefficients of a plant or a vehicle; `InputError` for what has none."""
    if isinstance(plant, AnyPlant):
        return plant.coefficients
    if isinstance(plant, AnyVehicle):
        return coefficients_of(plant)
    instance("plant", plant, Coefficients, "or a plant, or a vehicle")
    return plant


def _stiffen(coefficients: Coefficients, natural_frequency: ArrayLike) -> None:
    """Raise `InputError` for a closed loop that is softer than the vehicle alone."""
    frequency = sized("natural_frequency", natural_frequency, "rad/s")
    broadcast(coefficients=coefficients.batch, natural_frequency=frequency.shape)
    asked, own = np.broadcast_arrays(
        frequency, np.sqrt(np.maximum(-np.asarray(coefficients.mu_alpha), 0.0))
    )
    if np.any(asked < own):
        softest = np.unravel_index(np.argmin(asked - own), asked.shape)
        raise InputError(
            "natural_frequency must not be below that of the vehicle alone, sqrt(-mu_alpha) ="
            f" {own[softest]:.6g} rad/s: the feedback would be positive; got {asked[softest]:.6g}"
        )


def _stiffness(
    coefficients: Coefficients, natural_frequency: ArrayLike, damping: ArrayLike
) -> tuple[Any, Any]:
    """The gain on attitude and angle of attack together, and that on the rate."""
    frequency = sized("natural_frequency", natural_frequency, "rad/s")
    ratio, c = sized("damping", damping), coefficients
    broadcast(
        coefficients=coefficients.batch, natural_frequency=frequency.shape, damping=ratio.shape
    )
    with np.errstate(over="ignore"):
        stiffness = np.asarray((frequency**2 + c.mu_alpha) / c.mu_delta)
        wanted, own = np.broadcast_arrays(2.0 * ratio * frequency, c.damping)
        if np.any(wanted < own):
            short = np.unravel_index(np.argmin(wanted - own), wanted.shape)
            raise InputError(
                "2 damping natural_frequency must not be below the vehicle's own damping M_q/I ="
                f" {own[short]:.6g} 1/s: the rate feedback would be positive; got"
                f" {wanted[short]:.6g} 1/s"
            )
        return plain(stiffness), plain(np.asarray((wanted - own) / c.mu_delta))


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


@dataclass(frozen=True, eq=False)
class GainSchedule:
    """Gains at several flight times, straight lines between them.

    Attributes
    ----------
    time : ndarray
        Flight times [s], rising, ``(n,)``.
    autopilot : Autopilot
        Its gains at those times, ``(n,)`` or the same for all; actuator and delay as they are.

    Raises
    ------
    InputError
        For times that do not rise, fewer than two, and gains of another shape.
    """

    time: FloatArray
    autopilot: Autopilot

    def __post_init__(self) -> None:
        time = finite("time", self.time, "s")
        if time.ndim != 1 or time.size < 2 or np.any(np.diff(time) <= 0.0):
            raise InputError("time must be two or more rising flight times in s")
        instance("autopilot", self.autopilot, Autopilot, "whose gains are one for each time")
        if self.autopilot.batch not in {(), time.shape}:
            raise InputError(
                f"autopilot must have one gain for each of the {time.size} times; got a batch of"
                f" shape {self.autopilot.batch}"
            )
        object.__setattr__(self, "time", time)

    @classmethod
    def design(
        cls,
        time: ArrayLike,
        coefficients: Coefficients,
        rule: Callable[..., Autopilot],
        **arguments: Any,
    ) -> Self:
        """Return the schedule that a rule gives, such as `design_gains` or `canonical_gains`.

        Parameters
        ----------
        time : array_like
            Flight times [s], rising, ``(n,)``.
        coefficients : Coefficients
            Those of the vehicle at each time, ``(n,)``.
        rule : callable
            Any of the functions that return an autopilot from coefficients.
        **arguments
            What the rule asks for.

        Examples
        --------
        >>> import tvclin as tv
        >>> c = tv.Coefficients(mu_alpha=[0.1, 0.28, 0.2], mu_delta=[2.0, 2.6, 3.0])
        >>> rule = {"natural_frequency": 1.0, "damping": 0.7}
        >>> times = [40.0, 66.0, 90.0]
        >>> schedule = tv.control.GainSchedule.design(times, c, tv.design_gains, **rule)
        >>> round(schedule.at(53.0).attitude_gain, 4)
        0.5212
        >>> schedule.margins(tv.Plant.from_coefficients(c)).stable.all().item()
        True
        """
        callable_for("rule", rule, "from coefficients to an Autopilot, such as design_gains")
        return cls(finite("time", time, "s"), rule(coefficients, **arguments))

    def at(self, time: ArrayLike) -> Autopilot:
        """Return the autopilot at a flight time, or at several.

        Raises
        ------
        InputError
            For a time outside the schedule: gains are not extrapolated.
        """
        when = finite("time", time, "s")
        outside = (when < self.time[0]) | (when > self.time[-1])
        if np.any(outside):
            raise InputError(
                f"time must lie in the schedule, {self.time[0]:.6g} to {self.time[-1]:.6g} s;"
                f" got {when[outside].ravel()[0]:.6g}"
            )
        held = {name: getattr(self.autopilot, name) for name in (*GAINS, "delay")}
        changes: dict[str, Any] = {
            name: np.interp(when, self.time, np.broadcast_to(values, self.time.shape))
            for name, values in held.items()
        }
        if self.autopilot.actuator is not None and self.autopilot.actuator.batch:
            raise InputError("an actuator that changes over the flight is not interpolated")
        return replace(self.autopilot, **changes)

    def margins(self, plants: Plant) -> Margins:
        """Return the margins at every flight time.

        Parameters
        ----------
        plants : Plant
            The plant at each of the times, ``(n,)``.

        Warns
        -----
        UserWarning
            As `Autopilot.loop`.
        """
        loop = self.autopilot.exact_loop(plants)
        warn_of_feedback(self.autopilot, plants)
        return loop_margins(loop)
