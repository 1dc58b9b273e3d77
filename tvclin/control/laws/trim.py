"""Ideal trim as a feedback, and the report's control with a dead band.

Trim cancels the wind's moment, delta = B alpha, and a feedback of the unstable coordinate z keeps
the attitude. `DeadBandLaw` adds the switch of the report: from K times the limit on, the full
limit.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import between, nonnegative, number, small_angle, unlimited
from tvclin.control.laws.law import RATES, Law, Measurement, rate_over_pole, seen_coordinates
from tvclin.kernels.control_laws import LawNumbers
from tvclin.linear.plant import Plant


@dataclass(frozen=True)
class TrimLaw(Law):
    """Ideal trim and attitude feedback, limited: delta = B (alpha + gain z).

    z is the coordinate of the fastest unstable mode of the plant it is designed on; on a fixed
    path it is theta + theta'/(p + d), with the pole p and the damping d. Until the limit is reached
    the mode stays at rest, so without drift the boundary of this law is the report's with K = 1,
    eq (12).

    Parameters
    ----------
    plant : Plant
        The plant it is designed on, which need not be the one it flies. Designed on a fixed path
        it holds the attitude, also in a drifting flight: ideal trim as the report means it.
        Designed with drift it holds the nose to the path, which gives away what drift relieves
        and lets the path creep away with the slow mode.
    gain : float
        Gain of the feedback on z, over that of trim.

    Raises
    ------
    InputError
        For a plant without a real unstable pole, a batch, and a gain below zero.
    """

    plant: Plant
    gain: float = 10.0

    _keys = "model=plant.model gain"

    def __post_init__(self) -> None:
        seen_coordinates(self.plant)
        object.__setattr__(self, "gain", number("gain", self.gain, nonnegative))

    @classmethod
    def suited(cls, plant: Plant, peak: float, rate_limit: float) -> Self:
        """Return trim with the gain that a rate limit r can follow, at most the usual one.

        Parameters
        ----------
        plant : Plant
            The plant it is designed on.
        peak : float
            Peak A of the wind [rad].
        rate_limit : float
            What the nozzle turns at most, r [rad/s].

        Notes
        -----
        An error z fades as e^(-gain p t): with gain = r/(p B A) the feedback of one as large as the
        wind turns the nozzle with r. With the usual gain a nozzle that is five times as quick as
        the wind is just quick enough; with this one trim needs no more than the wind's own rate.
        """
        size = abs(number("peak", peak, small_angle("a wind angle"), "rad"))
        most = rate_over_pole(plant, unlimited("rate_limit", rate_limit, RATES, "rad/s"))
        return cls(plant, gain=min(cls.gain, most / size) if size else cls.gain)

    @property
    def numbers(self) -> LawNumbers:
        """B (alpha + gain z), and when the whole limit is commanded."""
        B, (attitude, rate, path) = self._numbers
        return LawNumbers(
            attitude=B * self.gain * attitude,
            attitude_rate=B * self.gain * rate,
            flight_path_angle=B * self.gain * path,
            angle_of_attack=B,
            engage=self.engage,
            release=self.release,
        )

    def demand(self, measured: Measurement, states: FloatArray, limit: Any) -> Any:
        """Return the trim deflection and the attitude feedback [rad]."""
        del states, limit
        B, (attitude, rate, path) = self._numbers
        error = attitude * measured.attitude + rate * measured.attitude_rate
        error = error + path * measured.flight_path_angle
        return B * (measured.angle_of_attack + self.gain * error)

    @cached_property
    def _numbers(self) -> tuple[float, list[float]]:
        """B, and z as parts of attitude, rate and flight path: plain, for the innermost loop."""
        row = seen_coordinates(self.plant).rows[0]
        return float(self.plant.coefficients.B), [*row.tolist(), 0.0][:3]


_LETTING_GO = 0.9
"""Of the dead band, at which the whole limit is let go."""


@dataclass(frozen=True)
class DeadBandLaw(TrimLaw):
    """The report's control as a feedback: trim inside the dead band, then the whole limit.

    When the deflection asked for reaches K times the limit, the whole limit is used until it has
    fallen to 0.9 K of the limit: the work is done, and trim and attitude feedback have the nozzle
    again. It switches on the deflection asked for, so with drift it meets the
    literal dead band, not that of (18).

    Parameters
    ----------
    plant : Plant
        The plant it is designed on.
    gain : float
        Gain of the feedback on z, over that of trim. One places the poles about where
        the canonical gains do; with more, the attitude feedback undoes the lean that the dead band
        is for.
    dead_band : float
        K, from 0.01 to one.

    Raises
    ------
    InputError
        As `TrimLaw`, and for a dead band outside [0.01, 1]: zero would switch on any rounding.
    """

    gain: float = 1.0
    dead_band: float = 0.5

    _keys = "model=plant.model gain dead_band"

    def __post_init__(self) -> None:
        super().__post_init__()
        K = number("dead_band", self.dead_band, between(0.01, 1.0))
        object.__setattr__(self, "dead_band", K)

    @property
    def engage(self) -> float:  # type: ignore[override]
        """K."""
        return self.dead_band

    @property
    def release(self) -> float:  # type: ignore[override]
        """A little less than K, so that the nozzle does not chatter on the edge."""
        return _LETTING_GO * self.dead_band
