"""Coefficients of the linear equations of motion: all numbers of a vehicle that a plant has.

    theta'' = mu_alpha alpha - mu_delta delta - damping theta',    alpha = theta - gamma - alpha_w

mu_alpha = beta^2 is the report's N l_a/I, and mu_delta = beta^2/B its T l_c/I; the report omits the
damping, M_q/I. Positive deflection pitches the nose down.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from tvclin.base import errors
from tvclin.base.arrays import Real
from tvclin.base.cards import Record, card, card_rows, lines
from tvclin.base.fields import derived, parameters, quantity
from tvclin.vehicle.vehicle import STANDARD_GRAVITY, Vehicle

PLANES, BOTH = ("pitch", "yaw"), "both"
PLANE_TEXTS = {**dict(zip(PLANES, PLANES, strict=True)), BOTH: "both planes"}
"""Text of a plane, or of both, in sentences and titles."""
_MAX_COEFFICIENT = 1e18
"""Largest coefficient, and largest 1/mu_delta: products of several must not overflow."""


def _if_unstable(name: str) -> Callable[[Any], Any]:
    """Return a function of `Coefficients` that returns their property `name` for tables.

    It returns None unless all vehicles of the batch are unstable: aerodynamic moment mu_alpha > 0.
    """
    return lambda c: getattr(c, name) if np.all(np.asarray(c.mu_alpha) > 0.0) else None


@dataclass(frozen=True, kw_only=True)
class Coefficients(Record):
    """Coefficients of the attitude equations of a vehicle or a batch of vehicles.

    Parameters
    ----------
    mu_alpha : array_like
        Aerodynamic moment per angle of attack over the inertia, N l_a/I = beta^2 [1/s^2].
        Zero or negative is an aerodynamically stable vehicle, which is legal.
    mu_delta : array_like
        Control moment per deflection over the inertia, T l_c/I = beta^2/B [1/s^2], not zero;
        negative for effectors ahead of the centre of gravity.
    C1, C2 : array_like
        Coefficients [1/s] and [1/s^3] of the exact denominator, eq (B7).
    b1, b2 : array_like
        Zeros [1/s] of the numerators of deflection and wind, eq (B7).
    q : array_like
        The gravity term (g cos(Theta_n)/V_n)^2 [1/s^2], zero or positive; zero in yaw. It is
        not the dynamic pressure.
    damping : array_like
        Moment against the attitude rate over the inertia, M_q/I [1/s], zero or positive; zero in
        the report.
    velocity : array_like
        Speed V_n [m/s], zero where it is not known; lateral drift and acceleration need it.
    name : str
        Name of the vehicle, for titles of figures; comparisons ignore it.

    Raises
    ------
    InputError
        For numbers that are not finite, a mu_delta of zero, a q or a damping below zero, or shapes
        that do not broadcast.

    Notes
    -----
    Report eqs (2), (B4), (B5), (B7) and (15b); the damping is derived in docs/theory.md.
    """

    mu_alpha: Real = quantity("per time squared", label="mu_alpha", key="mu_alpha")
    mu_delta: Real = quantity(
        "per time squared", check=errors.nonzero, label="mu_delta", key="mu_delta"
    )
    C1: Real = quantity("per time", 0.0, key="C1")
    C2: Real = quantity("per time cubed", 0.0, key="C2")
    b1: Real = quantity("per time", 0.0, key="b1")
    b2: Real = quantity("per time", 0.0, key="b2")
    q: Real = quantity("per time squared", 0.0, errors.nonnegative, key="q")
    damping: Real = quantity("per time", 0.0, errors.nonnegative, key="damping")
    velocity: Real = quantity("speed", 0.0, errors.nonnegative, card=False, document=False)
    name: str = field(default="", compare=False, repr=False)

    def __post_init__(self) -> None:
        """Check all numbers and the name; set each number to a float or, in a batch, an array."""
        checked = {
            name: item.check(name, getattr(self, name), item.si_unit)
            for name, item in parameters(Coefficients).items()
        }
        errors.together(**checked)  # their shapes must broadcast
        for name, array in checked.items():
            errors.within(name, array, -_MAX_COEFFICIENT, _MAX_COEFFICIENT)
        smallest = np.abs(checked["mu_delta"]).min(initial=np.inf)
        if smallest < 1.0 / _MAX_COEFFICIENT:
            raise errors.InputError(
                f"mu_delta must be at least {1.0 / _MAX_COEFFICIENT:g} 1/s^2 in size; got"
                f" {smallest:.6g}"
            )
        for name, array in checked.items():
            object.__setattr__(self, name, errors.plain(array))
        errors.instance("name", self.name, str, "the vehicle's")

    def _repr_html_(self) -> str:
        """Return the coefficients as a table in HTML."""
        title = f"Coefficients: {self.name}" if self.name else "Coefficients"
        return card(title, card_rows(self))

    def __repr__(self) -> str:
        """Return the coefficients as lines of text."""
        return lines(f"Coefficients {self.name}".strip(), card_rows(self))

    @classmethod
    def from_vehicle(cls, vehicle: Vehicle, plane: str = "pitch") -> Self:
        """Return the coefficients of a vehicle: moments (2), numerators and denominator (B7).

        Parameters
        ----------
        vehicle : Vehicle
            One vehicle or a batch.
        plane : {"pitch", "yaw"}
            In yaw the term q vanishes; the weight component W sin(Theta_n) has the real attitude
            in both planes.

        Notes
        -----
        Appendix B, eqs (B4), (B5). Its rule for yaw sets Theta_n to 90 degrees throughout, which is
        right for the cosine alone: it would make C2 too large by the factor 1/sin(Theta_n).
        """
        plane = errors.one_of("plane", plane, PLANES)
        errors.instance("vehicle", vehicle, Vehicle, "see load_vehicle")
        v = vehicle
        momentum = v.mass * v.velocity  # m V_n
        weight_along = v.weight * np.sin(v.attitude)  # W sin(Theta_n)
        mu_alpha = v.normal_force_slope * v.aerodynamic_arm / v.moment_of_inertia
        b2 = (v.thrust - v.axial_force - weight_along) / momentum
        C1 = b2 + v.normal_force_slope / momentum
        b1 = C1 + v.normal_force_slope * v.aerodynamic_arm / v.control_arm / momentum
        path_rate = STANDARD_GRAVITY * np.cos(v.attitude) / v.velocity  # g cos(Theta_n)/V_n [1/s]
        return cls(
            mu_alpha=mu_alpha,
            mu_delta=v.control_force * v.control_arm / v.moment_of_inertia,
            C1=C1,
            C2=mu_alpha * STANDARD_GRAVITY * np.sin(v.attitude) / v.velocity,
            b1=b1,
            b2=b2,
            q=path_rate**2 if plane == "pitch" else np.zeros_like(path_rate),
            damping=v.pitch_damping / v.moment_of_inertia,
            velocity=v.velocity,
            name=v.name,
        )

    @classmethod
    def from_beta(cls, *, beta: Real, B: Real, **others: Any) -> Self:
        """Return the coefficients with mu_alpha = beta^2 and mu_delta = beta^2/B [1/s^2].

        They are the moments per angle of attack and per deflection over the inertia.
        `beta`: vehicle response parameter [1/s], positive, eq (B4). `B`: trim deflection per angle
        of attack, not zero, eq (2). `others`: C1, C2, b1, b2, q, damping, velocity and name.
        """
        beta, B = errors.positive("beta", beta, "1/s"), errors.nonzero("B", B)
        errors.within("beta", beta, 0.0, _MAX_COEFFICIENT**0.5, "1/s")
        errors.together(beta=beta, B=B)
        return cls(mu_alpha=beta**2, mu_delta=beta**2 / B, **others)

    def replace(self, **changes: Any) -> Self:
        """Return a copy with the fields `changes` changed; `InputError` for an unknown one."""
        unknown = set(changes) - set(self.__dataclass_fields__)
        if unknown:
            raise errors.InputError(f"Coefficients has no field {', '.join(sorted(unknown))}")
        return replace(self, **changes)

    @cached_property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch; ``()`` for one vehicle."""
        return np.broadcast_shapes(*(np.shape(getattr(self, name)) for name in NUMBERS))

    @property
    def beta_squared(self) -> Real:
        """Coefficient mu_alpha [1/s^2]: beta^2 of an unstable vehicle, negative of a stable one."""
        return self.mu_alpha

    @property
    @derived("per time", of=_if_unstable("beta"))
    def beta(self) -> Real:
        """Vehicle response parameter beta [1/s], eq (B4).

        `InputError` for an aerodynamically stable vehicle (mu_alpha <= 0), which has no such pole.
        """
        if np.any(np.asarray(self.mu_alpha) <= 0.0):
            raise errors.InputError(
                "beta needs an aerodynamically unstable vehicle, mu_alpha > 0; got mu_alpha ="
                f" {np.min(self.mu_alpha):.6g} 1/s^2"
            )
        return errors.plain(np.sqrt(self.mu_alpha))

    @property
    @derived("per time", label="pole p", of=_if_unstable("pole"))
    def pole(self) -> Real:
        """Unstable pole p [1/s] on a fixed path, p (p + damping) = mu_alpha.

        It is beta = sqrt(mu_alpha) without damping, and smaller with it; the other pole is -(p +
        damping). mu_alpha [1/s^2]: aerodynamic moment per angle of attack over the inertia.
        `InputError` for an aerodynamically stable vehicle.
        """
        beta, half = np.asarray(self.beta), np.asarray(self.damping) / 2.0
        # the positive root of p^2 + damping p - mu_alpha, without a difference of close numbers
        damped = self.mu_alpha / (half + np.hypot(half, beta))
        return errors.plain(np.where(half == 0.0, beta, damped))

    @property
    def pole_symbol(self) -> str:
        """Symbol of the `pole` in tables and figures: beta, or p with damping."""
        return "p" if np.any(self.damping) else "beta"

    @property
    @derived()
    def B(self) -> Real:
        """Trim deflection per angle of attack B = N l_a/(T l_c), eq (2).

        N, T: lift per angle of attack and thrust. l_a, l_c: arms of both from the centre of
        gravity.
        """
        return self.mu_alpha / self.mu_delta

    @property
    @derived(of=_if_unstable("K1"), document=False)
    def K1(self) -> Real:
        """Ratio K1 = (p + b2)/(p + b1) at the unstable `pole` p, eq (15b).

        -b2 and -b1 [1/s] are the zeros of the attitude from wind and from deflection, eq (B7).

        `InputError` for an aerodynamically stable vehicle, which has no such pole.
        """
        return (self.pole + self.b2) / (self.pole + self.b1)


NUMBERS = tuple(parameters(Coefficients))
"""Names of the numerical fields."""
