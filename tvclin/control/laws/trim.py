"""Ideal trim as a feedback, and the report's control with a dead band.

Trim cancels the wind's moment, delta = B alpha, and a feedback of the unstable coordinate z keeps
the attitude. `DeadBandLaw` adds the switch of the report: from K times the limit on, the full
limit.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Self

from tvclin.base.errors import between, nonnegative, number, small_angle
from tvclin.base.fields import checked, quantity, spec
from tvclin.control.laws.law import (
    LinearLaw,
    law_rate_limit,
    measured_coordinates,
    rate_limit_angle,
)
from tvclin.kernels.control_laws import LawNumbers
from tvclin.linear.plant import Plant


@dataclass(frozen=True)
class TrimLaw(LinearLaw):
    """Ideal trim and attitude feedback, limited: delta = B (alpha + gain z).

    z is the coordinate of the fastest unstable mode of the design plant; on a fixed path it is
    theta + theta'/(p + d), with the pole p and the damping d. Until the limit is reached the mode
    stays in equilibrium, so without drift the boundary of this law is the report's with K = 1,
    eq (12).

    Parameters
    ----------
    plant : Plant
        Plant of the design, which need not be the one in flight. Designed on a fixed path the law
        holds the attitude, also in a drifting flight: ideal trim as the report defines it.
        Designed with drift it holds the nose to the path, which loses the load relief of the drift
        and lets the path diverge with the slow mode.
    gain : float
        Ratio of the feedback gain on z to the gain of trim.

    Raises
    ------
    InputError
        For a plant without a real unstable pole, a batch, and a gain below zero.
    """

    plant: Plant = field(metadata=spec(name="model", of="plant.model"))
    gain: float = quantity("number", 10.0, nonnegative)

    def __post_init__(self) -> None:
        """Check that the plant has a real unstable pole, and the gain."""
        measured_coordinates(self.plant)  # raises without an unstable pole
        checked(self, "gain")

    @classmethod
    def suited(cls, plant: Plant, peak: float, rate_limit: float) -> Self:
        """Return trim with a gain that a nozzle with rate limit r can follow, at most the default.

        An error z decays as e^(-gain p t), p being the unstable pole and B the trim per angle of
        attack: with gain = r/(p B A) the feedback of an error as large as the wind turns the nozzle
        at the rate r. The default gain requires a nozzle about five times as fast as the wind; with
        this gain trim requires no more than the wind's rate.

        Parameters
        ----------
        plant : Plant
            Plant of the design.
        peak : float
            Peak A of the wind [rad].
        rate_limit : float
            Rate limit r of the nozzle [rad/s].
        """
        size = abs(number("peak", peak, small_angle("a wind angle"), "rad"))
        # r/(p B) [rad]
        available = rate_limit_angle(plant, law_rate_limit("rate_limit", rate_limit, "rad/s"))
        return cls(plant, gain=min(cls.gain, available / size) if size else cls.gain)

    @cached_property
    def numbers(self) -> LawNumbers:
        """Coefficients of B (alpha + gain z), and the switching levels `engage` and `release`.

        alpha is the angle of attack, B the trim deflection per angle of attack. z is the coordinate
        of the unstable mode [rad], a sum of attitude, its rate and flight path angle, with the
        factors of its left eigenvector; on a fixed path the last is zero.
        """
        B = float(self.plant.coefficients.B)
        attitude, rate, path = measured_coordinates(self.plant).left_eigenvectors[0].tolist()
        return LawNumbers(
            attitude=B * self.gain * attitude,
            attitude_rate=B * self.gain * rate,
            flight_path_angle=B * self.gain * path,
            angle_of_attack=B,
            engage=self.engage,
            release=self.release,
        )


_RELEASE_OVER_DEAD_BAND = 0.9
"""Demand at which the full limit is released, over that at which it is engaged."""


@dataclass(frozen=True)
class DeadBandLaw(TrimLaw):
    """The report's control as a feedback: trim inside the dead band, then the full limit.

    When the demanded deflection reaches K times the limit, the full limit is commanded until the
    demand has fallen to 0.9 K of the limit; then trim and attitude feedback command the nozzle
    again. The switch acts on the demanded deflection, so with drift it is the literal dead band,
    not the limit of (18).

    Parameters
    ----------
    plant : Plant
        Plant of the design.
    gain : float
        Ratio of the feedback gain on z to the gain of trim. One places the poles about where the
        canonical gains do; a larger gain undoes the lean into the wind that the dead band causes.
    dead_band : float
        K, from 0.01 to one.

    Raises
    ------
    InputError
        In the same cases as `TrimLaw`, and for a dead band outside [0.01, 1]: zero would switch on
        rounding.
    """

    gain: float = quantity("number", 1.0, nonnegative)
    dead_band: float = quantity("number", 0.5, between(0.01, 1.0))

    def __post_init__(self) -> None:
        """Check plant, gain and dead band."""
        super().__post_init__()
        checked(self, "dead_band")

    @property
    def engage(self) -> float:  # type: ignore[override]
        """Dead band K, the demand over the limit at which the full limit is commanded."""
        return self.dead_band

    @property
    def release(self) -> float:  # type: ignore[override]
        """Demand over the limit at which the full limit is released: 0.9 of the dead band K.

        Below `engage`, against chatter.
        """
        return _RELEASE_OVER_DEAD_BAND * self.dead_band
