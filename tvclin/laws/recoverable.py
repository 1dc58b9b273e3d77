"""Lean into the felt wind as far as one can still return from, and no further."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.errors import between, finite, instance, nonnegative, number, positive
from tvclin.kernels.flight_table import EDGE, FAST_FIRST, HEADROOM, SLOW_LOOP
from tvclin.laws.estimator import WindEstimator
from tvclin.laws.law import Law, Seen, coordinate, seen_coordinates
from tvclin.plant import Plant
from tvclin.recoverable import UnstableCoordinates, larger, smaller

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class RecoverableAttitudeLaw(Law):
    """The law that needs no forecast where the report's needs one.

    With the coordinate z of the unstable mode (see `recoverable`), the felt wind w and D =
    limit/B it follows a lean Z: as far as the wind, never further than the recoverable set with
    its `reach`, nor than the design wind asks of the part `trust` of the limit::

        u = z - k w + gain (z - Z),     |Z| <= min(reach D, k max(A, 1.1 |w|) - trust D)

    A being the design peak. Full deflection into the wind, holding, following it down, and
    attitude feedback at rest are one formula. With drift an outer loop on the slow coordinate
    moves Z.

    Parameters
    ----------
    plant : Plant
        The plant it is designed on, with one or two real unstable poles.
    reach : float
        Part of the recoverable set that is used, in (0, 1]; what is left is the reserve for
        reversals, slow actuators and noise.
    gain : float
        Gain of the feedback on z.
    design_peak : float, optional
        A, the largest wind angle [rad] to be met; without one it leans as far as `reach` allows.
        Better too high than too low.
    trust : float
        Part of the limit that the design wind is set against, in (0, 1]. One leans no further
        than is needed if limit, B and design peak are exactly as believed; less is a reserve for
        what is believed wrongly, and costs where the wind turns round.
    dead_band : float
        A felt wind below this angle [rad] counts as none; it spares the nozzle from noise.
    estimator : WindEstimator, optional
        Without one the angle of attack is measured exactly.

    Raises
    ------
    InputError
        For a plant without a real unstable pole, one whose unstable modes move its speed, a
        batch, and numbers out of range.

    Warns
    -----
    UserWarning
        For an estimator slower than the unstable mode.
    """

    plant: Plant
    reach: float = 0.9
    gain: float = 10.0
    design_peak: float | None = None
    trust: float = 0.8
    dead_band: float = 0.0
    estimator: WindEstimator | None = None

    def __post_init__(self) -> None:
        modes = seen_coordinates(self.plant)
        for name in ("reach", "trust"):
            part = number(name, getattr(self, name), between(1e-3, 1.0))
            object.__setattr__(self, name, part)
        object.__setattr__(self, "gain", number("gain", self.gain, positive))
        object.__setattr__(self, "dead_band", number("dead_band", self.dead_band, nonnegative))
        if self.design_peak is not None:
            peak = abs(number("design_peak", self.design_peak, finite, "rad"))
            object.__setattr__(self, "design_peak", peak)
        if self.estimator is None:
            return
        instance("estimator", self.estimator, WindEstimator, "see WindEstimator")
        if self.estimator.bandwidth < modes.poles[0]:
            warnings.warn(
                f"the estimator, bandwidth = {self.estimator.bandwidth:.6g} rad/s, is slower than"
                f" the unstable mode, {modes.poles[0]:.6g} 1/s",
                stacklevel=3,
            )

    @property
    def states(self) -> tuple[FloatArray, FloatArray]:
        """Those of the estimator."""
        return super().states if self.estimator is None else self.estimator.states(self.plant)

    @property
    def rate_noise(self) -> tuple[float, int]:
        """That of the estimator's gyro."""
        gyro = self.estimator
        return super().rate_noise if gyro is None else (gyro.rate_noise, gyro.seed)

    def demand(self, seen: Seen, states: FloatArray, limit: Any) -> Any:
        """Return the deflection asked for [rad]."""
        B, rows, (strength, *_) = self._numbers
        rate, wind = seen.attitude_rate, seen.attitude - seen.angle_of_attack
        if self.estimator is not None:
            rate, wind = states.tolist() if states.ndim == 1 else states
        wind = wind - seen.flight_path_angle
        size = larger(abs(wind) - self.dead_band, 0.0)
        felt = strength * _where(wind < 0.0, -size, size)
        z = [coordinate(row, seen.attitude, rate, seen.flight_path_angle) for row in rows]
        lean = self._lean(z, felt, size, limit / abs(B))
        return B * (z[0] - felt + self.gain * (z[0] - lean))

    def _lean(self, z: list[Any], felt: Any, wind: Any, D: Any) -> Any:
        """Z: the lean [rad] that the wind, the recoverable set and the design wind allow."""
        most = reach = self.reach * D
        if self.design_peak is not None:
            largest = larger(self.design_peak, HEADROOM * wind)
            asked = self._numbers[2][0] * largest - self.trust * D
            most = smaller(reach, larger(asked, 0.0))
        slow = SLOW_LOOP * z[1] if len(z) > 1 else 0.0
        lean = smaller(most + larger(slow, 0.0), felt + slow)
        lean = larger(lean, smaller(slow, 0.0) - most)
        spare = FAST_FIRST * D
        lean = _where(felt > 0.0, larger(lean, felt - spare), lean)
        lean = _where(felt < 0.0, smaller(lean, felt + spare), lean)
        bounded = smaller(larger(z[1], -EDGE * reach), EDGE * reach) if len(z) > 1 else 0.0
        low, high = self._modes.fast_range(bounded, reach)
        return smaller(larger(lean, low), high)

    @cached_property
    def _modes(self) -> UnstableCoordinates:
        return seen_coordinates(self.plant)

    @cached_property
    def _numbers(self) -> tuple[float, list[list[float]], list[float]]:
        """B, the rows of z, and the strengths of the wind: plain, for the innermost loop."""
        modes = self._modes
        return float(self.plant.coefficients.B), modes.rows.tolist(), modes.wind.tolist()


def _where(condition: Any, this: Any, that: Any) -> Any:
    """One of two, elementwise; of floats without numpy, which takes longer."""
    if isinstance(condition, bool):
        return this if condition else that
    return np.where(condition, this, that)
