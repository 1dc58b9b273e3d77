"""The recoverable-attitude law: lean into the wind, but only as far as can be recovered."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import (
    between,
    instance,
    nonnegative,
    number,
    positive,
    small_angle,
    unlimited,
)
from tvclin.control.laws.estimator import WindEstimator
from tvclin.control.laws.law import RATES, Law, Measurement, rate_over_pole, seen_coordinates
from tvclin.kernels.control_laws import LawNumbers, asked
from tvclin.linear.plant import Plant


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
    rate_limit : float
        What the nozzle turns at most [rad/s], as the law knows it. The nozzle then turns into the
        wind no further than it can turn back from at that rate, were the wind to stop.
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
    rate_limit: float = np.inf
    estimator: WindEstimator | None = None

    _keys = (
        "model=plant.model reach gain design_peak_deg trust dead_band_deg"
        " rate_limit_deg_per_s estimator"
    )

    def __post_init__(self) -> None:
        modes = seen_coordinates(self.plant)
        for name in ("reach", "trust"):
            part = number(name, getattr(self, name), between(1e-3, 1.0))
            object.__setattr__(self, name, part)
        object.__setattr__(self, "gain", number("gain", self.gain, positive))
        object.__setattr__(
            self,
            "dead_band",
            number("dead_band", self.dead_band, small_angle("a wind angle", nonnegative), "rad"),
        )
        most = unlimited("rate_limit", self.rate_limit, RATES, "rad/s")
        object.__setattr__(self, "rate_limit", most)
        if self.design_peak is not None:
            peak = abs(number("design_peak", self.design_peak, small_angle("a wind angle"), "rad"))
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

    @cached_property
    def numbers(self) -> LawNumbers:
        """The lean, as numbers."""
        modes = seen_coordinates(self.plant)
        fast, slow = ([*row.tolist(), 0.0][:3] for row in (modes.rows[0], modes.rows[-1]))
        slow = slow if modes.ratio else [0.0, 0.0, 0.0]
        return LawNumbers(
            leans=True,
            fast_attitude=fast[0],
            fast_rate=fast[1],
            fast_path=fast[2],
            slow_attitude=slow[0],
            slow_rate=slow[1],
            slow_path=slow[2],
            ratio=modes.ratio,
            wind=float(modes.wind[0]),
            B=float(self.plant.coefficients.B),
            reach=self.reach,
            gain=self.gain,
            peak=np.inf if self.design_peak is None else self.design_peak,
            trust=self.trust,
            dead_band=self.dead_band,
            swing=self.reach * rate_over_pole(self.plant, self.rate_limit),
            estimates=self.estimator is not None,
        )

    def demand(self, measured: Measurement, states: FloatArray, limit: Any) -> Any:
        """Return the deflection asked for [rad]."""
        shape = np.broadcast_shapes(*(np.shape(one) for one in (*measured[:4], limit)))
        if not shape and states.ndim == 1:
            return asked(self.numbers, measured, states.tolist(), limit)
        rows = (
            np.broadcast_to(one, shape).ravel().tolist() for one in (*measured[:4], *states, limit)
        )
        each = [asked(self.numbers, one[:4], one[4:-1], one[-1]) for one in zip(*rows, strict=True)]
        return np.array(each).reshape(shape)
