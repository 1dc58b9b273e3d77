"""Bounds on the margins of any autopilot, by the growth of the vehicle during the delay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tvclin.base.cards import Shown
from tvclin.base.documents import decibels, keyed
from tvclin.base.errors import InputError, nonnegative, number, single
from tvclin.control.autopilot.actuator import Actuator
from tvclin.linear.flexible import AnyPlant, check_plant

_ROUNDING = 1e-9
"""Of the largest pole: what grows more slowly may be rounding."""


@dataclass(frozen=True, kw_only=True)
class MarginBounds(Shown):
    """Upper bounds of the margins of any linear autopilot, by an unstable pole and a delay.

    With M = e^(p delay), the growth of the unstable mode during the delay.

    Attributes
    ----------
    pole : float
        p, the fastest unstable pole of the plant [1/s].
    delay : float
        Of the loop [s]; lags of the nozzle are not in it.
    peak_sensitivity : float
        M, the least that the peaks of ``|S|`` and ``|T|`` can be.
    disk_margin : float
        The largest, 2/(M + sqrt(M^2 - 1)).
    phase_margin : float
        The largest [rad], 2 arcsin(1/M).
    gain_range : float
        The largest factor between the highest and the lowest gain of a stable loop,
        ((M + 1)/(M - 1))^2; infinite without a delay.
    lag : float
        x = p (delay + 2 zeta/omega_n): the delay, and that for which the nozzle counts, over 1/p.
    rule_disk_margin : float
        2 (1 - sqrt x)/(1 + sqrt x), about the largest that attitude and rate gains reach: a fit,
        to 3 percent for x up to 0.22, not a bound. Two without delay and nozzle, zero for x >= 1.
    rule_attitude_gain, rule_rate_gain : float
        B/sqrt x and that over p: gains that about reach it; infinite where x is zero.
    """

    pole: float
    delay: float
    peak_sensitivity: float
    disk_margin: float
    phase_margin: float
    gain_range: float
    lag: float
    rule_disk_margin: float
    rule_attitude_gain: float
    rule_rate_gain: float

    @property
    def phase_margin_deg(self) -> float:
        """The largest phase margin in degrees."""
        return float(np.degrees(self.phase_margin))

    @property
    def sentence(self) -> str:
        """The bounds in one sentence; empty without delay and nozzle."""
        said = []
        if self.delay:
            said.append(
                f"with this delay no autopilot has a disk margin above {self.disk_margin:.3g}"
                f" or a phase margin above {self.phase_margin_deg:.3g} deg"
            )
        if 0.0 < self.rule_disk_margin < 2.0:
            a = self.rule_disk_margin
            said.append(
                f"with this actuator, attitude and rate gains reach a disk margin of about {a:.3g}"
                f" (a fitted rule; {decibels((2.0 + a) / (2.0 - a)):.3g} dB,"
                f" {np.degrees(2.0 * np.arctan(a / 2.0)):.3g} deg)"
            )
        return "; ".join(said)

    as_dict = keyed(
        "pole_per_s delay_s peak_sensitivity disk_margin phase_margin_deg gain_range lag"
        " rule_disk_margin rule_attitude_gain rule_rate_gain_s"
    )
    _keys = "peak_sensitivity disk_margin phase_margin_deg gain_range rule_disk_margin"


def margin_bounds(
    plant: AnyPlant, *, actuator: Actuator | None = None, delay: float = 0.0
) -> MarginBounds:
    """Return the margins that no autopilot around a plant can exceed.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        One plant with an unstable pole.
    actuator : Actuator, optional
        One; it counts in the rule for attitude and rate gains alone.
    delay : float
        Of the loop [s].

    Raises
    ------
    InputError
        For a batch, and a plant that does not grow.

    Notes
    -----
    T = L/(1 + L) is one at p, and is e^(-s delay) times what is analytic in the right half plane,
    which there is M; its largest size on the axis is not less than that at p. The least peak of S
    is the same, and that of S - T is M + sqrt(M^2 - 1): S and T are projections that complete each
    other. For phase and gain range see Doyle, Francis and Tannenbaum, Feedback Control Theory,
    chapter 11.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> nozzle = tv.Actuator(natural_frequency=25.13, damping=0.7)
    >>> found = tv.control.margin_bounds(plant, actuator=nozzle, delay=0.02)
    >>> round(found.disk_margin, 2), round(found.rule_disk_margin, 2)
    (1.73, 1.34)
    """
    check_plant(plant)
    single("plant", plant.batch)
    late = number("delay", delay, nonnegative, "s")
    if not isinstance(actuator, Actuator | None):
        raise InputError(f"actuator must be an Actuator or None; got {type(actuator).__name__}")
    slow = 0.0
    if actuator is not None:
        single("actuator", actuator.batch)
        damping = 0.5 if actuator.damping is None else float(actuator.damping)
        slow = 2.0 * damping / float(actuator.natural_frequency)
    poles = plant.poles
    grows = np.real(np.asarray(poles))
    grows = np.where(grows > _ROUNDING * np.abs(np.nan_to_num(poles)).max(initial=0.0), grows, 0.0)
    pole = float(np.nan_to_num(grows, nan=0.0).max(initial=0.0))
    if pole <= 0.0:
        raise InputError("margins are bounded by unstable poles only, and this plant has none")
    most = float(np.exp(min(pole * late, 700.0)))
    lag = pole * (late + slow)
    root = float(np.sqrt(min(lag, 1.0)))
    stiffness = float(plant.coefficients.B) / root if root else np.inf
    return MarginBounds(
        pole=pole,
        delay=late,
        peak_sensitivity=most,
        disk_margin=2.0 / (most + most * float(np.sqrt(1.0 - most**-2.0))),
        phase_margin=2.0 * float(np.arcsin(1.0 / most)),
        gain_range=((most + 1.0) / (most - 1.0)) ** 2 if most > 1.0 else np.inf,
        lag=lag,
        rule_disk_margin=2.0 * (1.0 - root) / (1.0 + root),
        rule_attitude_gain=stiffness,
        rule_rate_gain=stiffness / pole,
    )
