"""Upper bounds of the margins of any linear autopilot, from an unstable pole and a delay."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, nonnegative, number, single
from tvclin.base.fields import decibels, spec
from tvclin.control.autopilot.actuator import Actuator
from tvclin.linear.flexible import AnyPlant, check_plant

_MIN_GROWTH_OVER_POLE = 1e-9
"""Smallest growth rate of an unstable pole, over the largest pole; below it may be rounding."""


@dataclass(frozen=True, kw_only=True)
class MarginBounds(Shown):
    """Upper bounds of the margins of any linear autopilot, by an unstable pole and a delay.

    With M = e^(p delay), the growth of the unstable mode during the delay.

    Attributes
    ----------
    pole : float
        p, the fastest unstable pole of the plant [1/s].
    delay : float
        Delay of the loop [s], without the lag of the nozzle.
    peak_sensitivity : float
        M, lower bound of the peaks of ``|S|`` and ``|T|``.
    disk_margin : float
        Upper bound 2/(M + sqrt(M^2 - 1)) of the disk margin.
    phase_margin : float
        Upper bound 2 arcsin(1/M) of the phase margin [rad].
    gain_range : float
        Upper bound ((M + 1)/(M - 1))^2 of the ratio of the highest to the lowest gain of a stable
        loop; infinite without a delay.
    lag : float
        x = p (delay + 2 zeta/omega_n), the delay and the equivalent delay of the nozzle, times p.
    rule_disk_margin : float
        2 (1 - sqrt x)/(1 + sqrt x), about the largest disk margin of attitude and rate gains: a
        fit, to 3 percent for x up to 0.22, not a bound. Two without delay and nozzle, zero for
        x >= 1.
    rule_attitude_gain, rule_rate_gain : float
        Gains a0 = B/sqrt x and a1 = a0/p [s] that about reach it; infinite where x is zero.
    """

    pole: float = field(metadata=spec("per time", card=False))
    delay: float = field(metadata=spec("time", card=False))
    peak_sensitivity: float = field(metadata=spec())
    disk_margin: float = field(metadata=spec())
    phase_margin: float = field(metadata=spec("angle"))
    gain_range: float = field(metadata=spec())
    lag: float = field(metadata=spec(card=False))
    rule_disk_margin: float = field(metadata=spec())
    rule_attitude_gain: float = field(metadata=spec(card=False))
    rule_rate_gain: float = field(metadata=spec("time", card=False))

    @property
    def phase_margin_deg(self) -> float:
        """Upper bound of the phase margin in degrees."""
        return float(np.degrees(self.phase_margin))

    @property
    def sentence(self) -> str:
        """Bounds in one sentence; empty without delay and nozzle."""
        clauses = []
        if self.delay:
            clauses.append(
                f"with this delay no autopilot has a disk margin above {self.disk_margin:.3g}"
                f" or a phase margin above {self.phase_margin_deg:.3g} deg"
            )
        if 0.0 < self.rule_disk_margin < 2.0:
            alpha = self.rule_disk_margin
            clauses.append(
                "with this actuator, attitude and rate gains reach a disk margin of about"
                f" {alpha:.3g} (a fitted rule; {decibels((2.0 + alpha) / (2.0 - alpha)):.3g} dB,"
                f" {np.degrees(2.0 * np.arctan(alpha / 2.0)):.3g} deg)"
            )
        return "; ".join(clauses)


def margin_bounds(
    plant: AnyPlant, *, actuator: Actuator | None = None, delay: float = 0.0
) -> MarginBounds:
    """Return upper bounds of the margins of any autopilot around a plant with an unstable pole.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        One plant with an unstable pole.
    actuator : Actuator, optional
        One actuator; only the rule for attitude and rate gains uses it.
    delay : float
        Delay of the loop [s].

    Raises
    ------
    InputError
        For a batch, and a plant without an unstable pole.

    Notes
    -----
    T = L/(1 + L) equals one at the unstable pole p. It is e^(-s delay) times a function that is
    analytic in the right half plane and equals M = e^(p delay) at p; by the maximum principle its
    peak on the imaginary axis is at least M. The least peak of S is the same, and the least peak of
    S - T is M + sqrt(M^2 - 1), since S and T are complementary projections. For phase and gain
    range see Doyle, Francis and Tannenbaum, Feedback Control Theory, chapter 11. The rule for
    attitude and rate gains is a fit, no bound: gains B/sqrt(x) and B/(p sqrt(x)), x = p (delay +
    nozzle delay).

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> nozzle = tv.Actuator(natural_frequency=25.13, damping=0.7)
    >>> bounds = tv.control.margin_bounds(plant, actuator=nozzle, delay=0.02)
    >>> round(bounds.disk_margin, 2), round(bounds.rule_disk_margin, 2)
    (1.73, 1.34)
    """
    check_plant(plant)
    single("plant", plant.batch)
    time = number("delay", delay, nonnegative, "s")
    if not isinstance(actuator, Actuator | None):
        raise InputError(f"actuator must be an Actuator or None; got {type(actuator).__name__}")
    nozzle_delay = 0.0
    if actuator is not None:
        single("actuator", actuator.batch)
        # A first-order lag has the equivalent delay 1/omega_n, as if its damping were 0.5.
        damping = 0.5 if actuator.damping is None else float(actuator.damping)
        nozzle_delay = 2.0 * damping / float(actuator.natural_frequency)
    poles = np.nan_to_num(plant.poles)
    pole = float(np.real(poles).max(initial=0.0))
    if pole <= _MIN_GROWTH_OVER_POLE * np.abs(poles).max(initial=0.0):
        raise InputError("margins are bounded by unstable poles only, and this plant has none")
    M = float(np.exp(min(pole * time, 700.0)))  # e^700: without overflow
    lag = pole * (time + nozzle_delay)
    root = float(np.sqrt(min(lag, 1.0)))
    # attitude gain of the rule, B/root: B is the ratio of trim deflection to angle of attack
    stiffness = float(plant.coefficients.B) / root if root else np.inf
    return MarginBounds(
        pole=pole,
        delay=time,
        peak_sensitivity=M,
        disk_margin=2.0 / (M + M * float(np.sqrt(1.0 - M**-2.0))),
        phase_margin=2.0 * float(np.arcsin(1.0 / M)),
        gain_range=((M + 1.0) / (M - 1.0)) ** 2 if M > 1.0 else np.inf,
        lag=lag,
        rule_disk_margin=2.0 * (1.0 - root) / (1.0 + root),
        rule_attitude_gain=stiffness,
        rule_rate_gain=stiffness / pole,
    )
