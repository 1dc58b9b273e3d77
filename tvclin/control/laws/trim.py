"""Ideal trim as a feedback."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import nonnegative, number
from tvclin.control.laws.law import Law, Measurement, seen_coordinates
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
