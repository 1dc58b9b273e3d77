"""Gains of an autopilot by pole placement, wind relief, quadratic cost or return to the path.

On a fixed path, eq (5), without actuator and delay, and with the vehicle's damping d, the loop is

    s^2 + (mu_delta a1 + d) s + mu_delta (a0 + b0) - mu_alpha = s^2 + 2 zeta omega_n s + omega_n^2,

which gives a1 and the sum a0 + b0. How the sum is divided between attitude and angle of attack sets
how far the vehicle turns into a steady wind: alpha/alpha_w = -a0/(a0 + b0 - B). All gains have the
shape of the coefficients: every flight condition in one call.

In a constant wind the path settles where the moment and the force across the path vanish. With
w = C2/mu_alpha, phi = theta - gamma and alpha = phi - alpha_w,

    (b1 + w) phi + w gamma = (b1 - b2) alpha_w,
    (a0 + d1 V) gamma = (B - b0 - g V (b1 - b2)) alpha - a0 phi.

Without gravity phi and alpha do not depend on the gains. With a gain on the drift gamma is zero.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.control.autopilot.actuator import positive_in_range
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import Feedback
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.lateral import DRIFT, DRIFT_RATE, LateralSensors
from tvclin.linear.plant import Plant
from tvclin.linear.system import LinearSystem
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.linear_vehicle import AnyVehicle, coefficients_of

PlantOrVehicle = AnyPlant | AnyVehicle | Coefficients
"""Types that gains are computed from; a vehicle stands for its pitch plane."""

_FREQUENCY_OVER_POLE = 2.4
"""Natural frequency of the half-relief loop, over the unstable pole."""
_HALF_RELIEF_DAMPING = 1.2
"""Damping ratio of the half-relief loop."""


def canonical_gains(plant: PlantOrVehicle, **options: Any) -> Autopilot:
    """Return the autopilot with a0 = 2B and a1 = B/beta.

    On a fixed path, eq (5) of Borsody and Teren, without actuator and delay, the closed loop is s^2
    + beta s + beta^2 with beta = sqrt(mu_alpha): natural frequency beta, damping ratio 0.5. A
    damping d of the vehicle comes on top: (beta + d) s. B is the trim deflection per angle of
    attack, mu_alpha the aerodynamic moment per angle of attack over the inertia.

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
        raise errors.InputError(
            "canonical gains need an aerodynamically unstable vehicle, mu_alpha > 0; got"
            f" {mu_alpha:.6g} 1/s^2; give natural_frequency for gains by pole placement"
        )
    with np.errstate(over="ignore"):  # an Autopilot refuses what is not finite
        B, rate = coefficients.B, coefficients.B / coefficients.beta
    return Autopilot(attitude_gain=2.0 * B, rate_gain=rate, **options)


def design_gains(
    plant: PlantOrVehicle, *, natural_frequency: ArrayLike, damping: ArrayLike, **options: Any
) -> Autopilot:
    """Return the autopilot that gives a fixed path a specified natural frequency and damping ratio.

    Without actuator and delay the closed loop is
    s^2 + (mu_delta a1 + d) s + (mu_delta a0 - mu_alpha) = s^2 + 2 damping omega_n s + omega_n^2,
    with gains a0 on attitude and a1 on its rate, mu_alpha and mu_delta the moments over the inertia
    per angle of attack and per deflection, and d the vehicle's own damping.

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
        For numbers that are not positive, and for less damping than the vehicle's M_q alone gives.
    """
    stiffness, rate = _stiffness(_coefficients(plant), natural_frequency, damping)
    return Autopilot(attitude_gain=stiffness, rate_gain=rate, **options)


def relief_gains(
    plant: PlantOrVehicle,
    *,
    natural_frequency: ArrayLike,
    damping: ArrayLike,
    alpha_ratio: ArrayLike,
    **options: Any,
) -> Autopilot:
    """Return the autopilot with a specified ratio alpha/alpha_w in a steady wind.

    The attitude responds as with `design_gains`, but a fraction of the stiffness comes from the
    angle of attack, so that the vehicle turns into the wind:

        a0 = ratio omega_n^2/mu_delta,    a0 + b0 = (omega_n^2 + mu_alpha)/mu_delta

    mu_alpha and mu_delta are the moments per angle of attack and per deflection over the inertia.

    Parameters
    ----------
    plant, natural_frequency, damping, **options
        Same parameters as `design_gains`.
    alpha_ratio : array_like
        Magnitude of alpha/alpha_w when the attitude has settled in a steady wind and the flight
        path has not yet changed, zero or positive. Pure attitude hold has 1 + mu_alpha/omega_n^2 =
        a0/(a0 - B), above one, B being trim deflection per angle of attack.

    Raises
    ------
    InputError
        For numbers out of range.

    Notes
    -----
    With theta'' = theta' = 0 the deflection a0 theta + b0 alpha is trim, B alpha, and before the
    path has changed theta = alpha + alpha_w; so alpha = -a0/(a0 + b0 - B) alpha_w. With drift the
    slow pole of the closed loop lies near w - ratio (b1 + w), where w = C2/mu_alpha =
    g sin(Theta_n)/V_n: below the ratio w/(b1 + w) gravity turns the path away.
    """
    coefficients, ratio = _coefficients(plant), errors.nonnegative("alpha_ratio", alpha_ratio)
    stiffness, rate = _stiffness(coefficients, natural_frequency, damping)
    errors.broadcast(gains=np.shape(stiffness), alpha_ratio=ratio.shape)
    with np.errstate(over="ignore"):
        attitude = ratio * np.asarray(natural_frequency, float) ** 2 / coefficients.mu_delta
    return Autopilot(
        attitude_gain=attitude, rate_gain=rate, alpha_gain=stiffness - attitude, **options
    )


def half_relief_gains(plant: PlantOrVehicle, **options: Any) -> Autopilot:
    """Return the autopilot that turns the vehicle by half of the wind, for a small limit.

    Its gains are `relief_gains` with a natural frequency of 2.4 p, a damping ratio of 1.2 and an
    alpha ratio of one half, p being the unstable pole on a fixed path. Under a deflection limit
    (`SaturatedLaw`) they require hardly more than one half of trim in winds that rise and fall,
    also if these stop at any instant; in gusts that reverse they require more.

    Parameters
    ----------
    plant, **options
        Same parameters as `canonical_gains`.

    Raises
    ------
    InputError
        For a stable vehicle, which has no unstable pole, and a vehicle whose damping M_q/I is
        above 5.76 p.

    Notes
    -----
    In a steady wind the nozzle stands at r of trim and the attitude at 1 - r of the wind, r being
    the alpha ratio. Holding it takes a limit above r of trim, and the return from there when the
    wind stops a limit above 1 - r. In slow winds the larger of the two is sufficient; r = 1/2 makes
    it smallest. With a smaller ratio, less damping or a higher frequency the attitude overshoots,
    and a wind that stops just after its peak may then cost a tenth of trim more.

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
        raise errors.InputError(
            "half-relief gains need an aerodynamically unstable vehicle, mu_alpha > 0; got"
            f" {np.min(coefficients.mu_alpha):.6g} 1/s^2 (use relief_gains instead)"
        )
    return relief_gains(
        coefficients,
        natural_frequency=errors.plain(np.asarray(_FREQUENCY_OVER_POLE * coefficients.pole)),
        damping=_HALF_RELIEF_DAMPING,
        alpha_ratio=0.5,
        **options,
    )


def drift_minimum_gains(
    plant: PlantOrVehicle, *, natural_frequency: ArrayLike, damping: ArrayLike, **options: Any
) -> Autopilot:
    """Return the autopilot whose flight path does not turn in a steady wind.

    The vehicle leans into the wind until thrust and lift across the path cancel. The angle of
    attack alpha = theta - gamma - alpha_w (attitude, path, wind) is then opposite to the wind
    alpha_w, and ``|alpha/alpha_w|`` = (b2 + w)/(b1 + w), with w = C2/mu_alpha = g sin(Theta_n)/V_n
    (speed V_n, nominal attitude Theta_n), and b1, b2 [1/s] of the drift model, gamma' = b1 delta/B
    + b2 alpha_w; without drag and weight it is 1/(1 + (N/T)(1 + l_a/l_c)), N being the lift slope,
    T the thrust, l_a and l_c the arms of both. C2 [1/s^3] is the weight's term of the report.

    Parameters
    ----------
    plant : Plant, FlexiblePlant, vehicle or Coefficients
        Of one vehicle or of a batch, with b1 and b2, and mu_alpha other than zero.
    natural_frequency, damping, **options
        Same parameters as `load_minimum_gains`.

    Raises
    ------
    InputError
        For coefficients without drift or with b1 + w or b2 + w below zero, and numbers out of
        range.

    Notes
    -----
    gamma' = 0 at gamma = 0 in eq (B6) of the report with the attitude settled: (b1 + w) alpha +
    (b2 + w) alpha_w = 0. The principle is Hoelkner's.
    """
    c = _coefficients(plant)
    if np.any(np.asarray(c.mu_alpha) == 0.0) or np.any(np.asarray(c.b1) == 0.0):
        raise errors.InputError(
            "drift-minimum gains need coefficients with drift (b1, b2, C2) and mu_alpha other"
            " than zero; make them with Coefficients.from_vehicle"
        )
    w = c.C2 / np.asarray(c.mu_alpha)
    thrust, lift = np.broadcast_arrays(c.b1 + w, c.b2 + w)  # b1 + w and b2 + w [1/s]
    worst = np.unravel_index(np.argmin(np.minimum(thrust, lift)), thrust.shape)
    if thrust[worst] <= 0.0 or lift[worst] < 0.0:
        raise errors.InputError(
            "there are no drift-minimum gains: no attitude in a steady wind keeps the path of this"
            f" vehicle, whose b1 + w = {thrust[worst]:.6g} and b2 + w = {lift[worst]:.6g} 1/s (w ="
            " C2/mu_alpha) would have to be positive; use design_gains instead"
        )
    _check_stiffness(c, natural_frequency)
    return relief_gains(
        c,
        natural_frequency=natural_frequency,
        damping=damping,
        alpha_ratio=lift / thrust,
        **options,
    )


def load_minimum_gains(
    plant: PlantOrVehicle, *, natural_frequency: ArrayLike, damping: ArrayLike, **options: Any
) -> Autopilot:
    """Return the autopilot whose angle of attack vanishes in a steady wind: a0 = 0.

    The bending moment vanishes with it. The attitude has no reference any more: with drift and
    gravity the flight path diverges slowly, near e^(w t) with w = C2/mu_alpha = g sin(Theta_n)/V_n,
    and the margins on the exact models belong to an unstable loop.

    Parameters
    ----------
    plant : Plant, FlexiblePlant, vehicle or Coefficients
        Of one vehicle or of a batch.
    natural_frequency, damping : array_like
        Of the closed loop on a fixed path [rad/s] and [-], positive; the frequency not below that
        of an aerodynamically stable vehicle without autopilot.
    **options
        The other arguments of `Autopilot`: actuator, delay, and so on.

    Raises
    ------
    InputError
        For numbers out of range.
    """
    coefficients = _coefficients(plant)
    _check_stiffness(coefficients, natural_frequency)
    return relief_gains(
        coefficients,
        natural_frequency=natural_frequency,
        damping=damping,
        alpha_ratio=0.0,
        **options,
    )


def _coefficients(plant: PlantOrVehicle) -> Coefficients:
    """Return the coefficients of a plant or a vehicle, of the latter in its pitch plane.

    `plant`: one or a batch; coefficients are returned as they are. `InputError` for another type.
    """
    if isinstance(plant, AnyPlant):
        return plant.coefficients
    if isinstance(plant, AnyVehicle):
        return coefficients_of(plant)
    errors.instance("plant", plant, Coefficients, "or a plant, or a vehicle")
    return plant


def _check_stiffness(coefficients: Coefficients, natural_frequency: ArrayLike) -> None:
    """Raise `InputError` for a natural frequency of the loop [rad/s] below the vehicle's alone.

    `coefficients`: of one vehicle or a batch; with a stable aerodynamic moment over the inertia,
    mu_alpha < 0, the frequency is sqrt(-mu_alpha), else zero. `natural_frequency`: ``(...)``.
    """
    frequency = positive_in_range("natural_frequency", natural_frequency, "rad/s")
    errors.broadcast(coefficients=coefficients.batch, natural_frequency=frequency.shape)
    specified, bare = np.broadcast_arrays(
        frequency, np.sqrt(np.maximum(-np.asarray(coefficients.mu_alpha), 0.0))
    )
    if np.any(specified < bare):
        worst = np.unravel_index(np.argmin(specified - bare), bare.shape)
        raise errors.InputError(
            "natural_frequency must not be below the pole frequency of the vehicle alone,"
            " sqrt(-mu_alpha) ="
            f" {bare[worst]:.6g} rad/s: the feedback would be positive; got {specified[worst]:.6g}"
        )


def _stiffness(
    coefficients: Coefficients, natural_frequency: ArrayLike, damping: ArrayLike
) -> tuple[Any, Any]:
    """Return the stiffness gain a0 + b0 and the rate gain a1 [s] of a closed loop on a fixed path.

    With gains a0 on attitude and b0 on angle of attack: a0 + b0 = (omega_n^2 + mu_alpha)/mu_delta
    and a1 = (2 zeta omega_n - d)/mu_delta, of moments over the inertia per angle of attack and per
    deflection [1/s^2], and of the vehicle's own damping d [1/s]: `coefficients`. All broadcast with
    `natural_frequency`, `damping`: omega_n [rad/s] and damping ratio zeta of the loop. `InputError`
    for less damping than the vehicle alone has.
    """
    frequency = positive_in_range("natural_frequency", natural_frequency, "rad/s")
    ratio, c = positive_in_range("damping", damping), coefficients
    errors.broadcast(
        coefficients=coefficients.batch, natural_frequency=frequency.shape, damping=ratio.shape
    )
    with np.errstate(over="ignore"):
        stiffness = np.asarray((frequency**2 + c.mu_alpha) / c.mu_delta)
        damping_rate, bare = np.broadcast_arrays(2.0 * ratio * frequency, c.damping)  # [1/s]
        if np.any(damping_rate < bare):
            worst = np.unravel_index(np.argmin(damping_rate - bare), bare.shape)
            raise errors.InputError(
                "2 damping natural_frequency must not be below the vehicle's own damping M_q/I ="
                f" {bare[worst]:.6g} 1/s: the rate feedback would be positive; got"
                f" {damping_rate[worst]:.6g} 1/s"
            )
        return errors.plain(stiffness), errors.plain(np.asarray((damping_rate - bare) / c.mu_delta))


_MAX_WEIGHT = 1e12
"""Largest weight of a quadratic cost, and largest ratio of two weights."""
_MIN_DECAY_OVER_POLE = 1e-8
"""Smallest decay rate of a closed-loop pole, over the largest pole; below it a mode has no cost."""


def lqr_gains(
    plant: Plant,
    *,
    attitude_weight: float = 1.0,
    rate_weight: float = 0.0,
    alpha_weight: float = 0.0,
    drift_rate_weight: float = 0.0,
    drift_weight: float = 0.0,
    deflection_weight: float = 1.0,
    **options: Any,
) -> Autopilot:
    """Return the autopilot that minimises a quadratic cost, by `control.lqr`.

    The cost is the integral of attitude_weight theta^2 + rate_weight theta'^2 + alpha_weight
    alpha^2 + drift_rate_weight z'^2 + drift_weight z^2 + deflection_weight delta^2, without wind.
    On a model with drift the third state, the flight path angle, is fed back as the angle of
    attack; with a weight on the drift z [m] or its rate, as the drift rate.

    Parameters
    ----------
    plant : Plant
        One plant, "fixed-path", "drift" or "drift-exact".
    attitude_weight, rate_weight, alpha_weight : float
        Zero or positive.
    drift_rate_weight, drift_weight : float
        Weights [rad^2 s^2/m^2] and [rad^2/m^2], zero or positive; they need a speed and a path.
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
    errors.instance("plant", plant, Plant, "see Plant.from_vehicle")
    if plant.batch or plant.model == "drift-and-speed":
        raise errors.InputError(
            "lqr_gains needs one plant whose states an autopilot measures (fixed-path, drift or"
            f" drift-exact); got {plant.model} of shape {plant.batch}"
        )
    weights = {
        "attitude_weight": attitude_weight,
        "rate_weight": rate_weight,
        "alpha_weight": alpha_weight,
        "drift_rate_weight": drift_rate_weight,
        "drift_weight": drift_weight,
    }
    costs = [errors.number(name, value, errors.nonnegative) for name, value in weights.items()]
    cost = errors.number("deflection_weight", deflection_weight, errors.positive)
    for name, weight in zip((*weights, "deflection_weight"), (*costs, cost), strict=True):
        errors.number(name, weight, errors.between(0.0, _MAX_WEIGHT))
    if cost * _MAX_WEIGHT < max(costs):
        raise errors.InputError(
            f"deflection_weight must be at least 1/{_MAX_WEIGHT:g} of the others"
        )
    sensors = LateralSensors(
        drift_rate=drift_rate_weight > 0.0 or drift_weight > 0.0, drift=drift_weight > 0.0
    )
    feedback = -_optimal_feedback(sensors.system(plant), costs, cost)
    # Gains on attitude, its rate and, with a flight path, on gamma and perhaps the drift.
    on_attitude, on_rate, *on_path = feedback.tolist()
    if not sensors.signals:
        # gamma = theta - alpha without wind: its gain goes to the attitude, and off alpha.
        path = sum(on_path)  # of none or one
        return Autopilot(
            attitude_gain=on_attitude + path,
            rate_gain=on_rate,
            alpha_gain=0.0 - path,
            **options,
        )
    on_gamma, *on_drift = on_path  # the drift rate is the speed times gamma
    return Autopilot(
        attitude_gain=on_attitude,
        rate_gain=on_rate,
        drift_rate_gain=on_gamma / float(np.asarray(plant.coefficients.velocity)),
        drift_gain=on_drift[0] if sensors.drift else 0.0,
        **options,
    )


def _optimal_feedback(system: LinearSystem, costs: list[float], cost: float) -> FloatArray:
    """Return the gains k ``(n,)`` on n states for which delta = -k x minimises a quadratic cost.

    The cost is the integral of x' Q x + R delta^2, the weighted squares as a form in the states x.
    `system`: plant and lateral sensors, with the deflection as first input. `costs`: weights of the
    squares of attitude, its rate, angle of attack, drift rate and drift, as far as these are
    outputs. `cost`: R, weight of the squared deflection. `InputError` for a mode without a cost.
    """
    import control

    A, B, C, _ = system.matrices()
    weighted = ("attitude", "attitude_rate", "angle_of_attack", DRIFT_RATE, DRIFT)
    rows = {name: C[k] for k, name in enumerate(system.outputs)}
    outputs = np.array([rows.get(name, np.zeros(len(A))) for name in weighted])
    Q, R = outputs.T @ np.diag(costs) @ outputs, np.array([[cost]])
    try:
        gains, _, poles = control.lqr(A, B[:, :1], Q, R, method="scipy")
    except (np.linalg.LinAlgError, control.ControlArgument, ValueError):
        # No solution: a pole of one stands for an unstable loop, refused below.
        poles, gains = np.ones(1), np.zeros((1, len(A)))
    if np.real(poles).max() >= -_MIN_DECAY_OVER_POLE * np.abs(poles).max():
        raise errors.InputError(
            "the weights leave a mode of the plant without a cost; raise attitude_weight,"
            " alpha_weight or drift_rate_weight"
        )
    return np.asarray(gains[0])


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
        Same parameters as `lqr_gains`.

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
        raise errors.InputError(f"drift_gains is for one plant; got a batch of shape {plant.batch}")
    frequencies = (
        errors.number("natural_frequency", natural_frequency, positive_in_range, "rad/s"),
        errors.number("drift_frequency", drift_frequency, positive_in_range, "rad/s"),
    )
    ratios = (
        errors.number("damping", damping, positive_in_range),
        errors.number("drift_damping", drift_damping, positive_in_range),
    )
    pairs = zip(frequencies, ratios, strict=True)
    poles = np.array([np.roots([1.0, 2.0 * zeta * w, w**2]) for w, zeta in pairs], complex).ravel()
    system = LateralSensors(drift=True).system(plant)
    # States attitude, its rate, flight path angle, and drift over speed [s], of about one size.
    scale = np.array([1.0, 1.0, 1.0, float(speed)])
    A, B = system.A * scale / scale[:, np.newaxis], system.B[:, :1]
    try:
        gains = control.place(A, B, poles)[0]  # from all states to the deflection
    except ValueError:  # no solution: gains of zero leave other poles, refused below
        gains = np.zeros(4)
    placed = np.linalg.eigvals(A - B * np.nan_to_num(gains))
    distances = np.abs(placed[:, np.newaxis] - poles).min(axis=0)
    if not np.all(distances < _RELATIVE_POLE_ERROR * np.abs(poles)):
        raise errors.InputError(
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
    integral of the attitude -(b1 - b2)/b1. Gains: a0 on attitude, b0 on angle of attack, d1 on
    drift rate, g on acceleration. B is the ratio of trim deflection to angle of attack, C2 the
    constant term [1/s^3] of the denominator of (B7), and mu_alpha beta^2 [1/s^2]; b1 and b2 [1/s]
    give the path, gamma' = b1 delta/B + b2 alpha_w in the drift model, and V is the speed.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> gains = tv.design_gains(plant, natural_frequency=1.2, damping=0.7)
    >>> round(tv.control.steady_drift(gains, plant) * 3.14159 / 180, 2)  # m/s per deg
    -5.04
    """
    speed = _speed(plant)
    errors.instance("autopilot", autopilot, Feedback, "see design_gains")
    if autopilot.controller is not None:
        raise errors.InputError("steady_drift is of gains; of a controller see its wind_response")
    errors.broadcast(autopilot=autopilot.batch, plant=plant.batch)
    c = plant.coefficients
    b1, difference = np.asarray(c.b1), np.asarray(c.b1 - c.b2)
    w = 0.0 if plant.model == "drift" else c.C2 / np.asarray(c.mu_alpha)
    if np.any(autopilot.drift_gain):
        path_ratio = np.zeros(np.broadcast_shapes(autopilot.batch, plant.batch))
    elif np.any(autopilot.integral_gain):
        path_ratio = -difference / b1
    else:
        a0 = np.asarray(autopilot.attitude_gain)
        k = c.B - autopilot.alpha_gain - autopilot.acceleration_gain * speed * difference
        divisor = a0 + autopilot.drift_rate_gain * speed + (k - a0) * w / (b1 + w)
        path_ratio = ((k - a0) * difference / (b1 + w) - k) / divisor
    return errors.plain(np.asarray(speed * path_ratio))


def _speed(plant: Plant) -> FloatArray:
    """Return the speed of a plant [m/s], ``(...)``.

    `InputError` for another plant than a rigid one of the models "drift" and "drift-exact", and for
    coefficients without a speed.
    """
    errors.instance("plant", plant, Plant, "see Plant.from_vehicle")
    if not plant.is_rigid or plant.model not in ("drift", "drift-exact"):
        raise errors.InputError(f"drift needs a plant drift or drift-exact; got {plant.model}")
    plant.lateral_rows("drift_rate", 0.0)  # raises without a speed
    return np.asarray(plant.coefficients.velocity)
