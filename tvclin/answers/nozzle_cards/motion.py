"""How a nozzle moves, between each two times one after the other: given, or flown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.flights.closed_loop.fly import NozzleFlight
from tvclin.linear.extremes import Point


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion of a nozzle and of its vehicle.

    Times [s] and deflections [rad] ``(n + 1,)`` have straight lines between. All else is of `at`,
    one time of each step, ``(n,)``: the deflection and its derivatives [rad/s, rad/s2], the
    vehicle's angle of attack [rad] and its angular acceleration, `swing` [rad/s2]. `weights` [s]
    are those of an integral over time, ``(n,)``. `sharpest` is the largest acceleration.
    """

    times: FloatArray
    deflection: FloatArray
    at: FloatArray
    angle: FloatArray
    rate: FloatArray
    acceleration: FloatArray
    sharpest: Point
    angle_of_attack: FloatArray
    swing: FloatArray
    weights: FloatArray

    @classmethod
    def of_samples(
        cls, t: FloatArray, delta: FloatArray, alpha: FloatArray, attitude: FloatArray
    ) -> Self:
        """Return a motion whose derivatives are differences, in the middle of each step."""
        bends = _bends(t, delta)
        return cls(
            times=t,
            deflection=delta,
            at=_middle(t),
            angle=_middle(delta),
            rate=np.diff(delta) / np.diff(t),
            acceleration=_middle(np.pad(bends, 1, mode="edge")),
            sharpest=largest(bends, t[1:-1]),
            angle_of_attack=_middle(alpha),
            swing=_middle(np.pad(_bends(t, attitude), 1, mode="edge")),
            weights=np.diff(t),
        )

    @classmethod
    def of_flight(cls, f: NozzleFlight) -> Self:
        """Return the motion of a flight with its actuator, right after the begin of each step.

        Integrals take every second time, the middle between two at which a command may change.
        Without an actuator the motion is that from sample to sample.
        """
        if f.rate is None or f.acceleration is None:
            rows = (f.times, f.deflection, f.angle_of_attack, f.attitude)
            return cls.of_samples(*(row[:: f.times_per_sample] for row in rows))
        weights = np.zeros(f.times.size - 1)
        weights[1::2] = f.times[2::2] - f.times[:-2:2]
        return cls(
            times=f.times,
            deflection=f.deflection,
            at=f.times[:-1],
            angle=f.deflection[:-1],
            rate=f.rate[:-1],
            acceleration=f.acceleration[:-1],
            sharpest=largest(f.acceleration, f.times),
            angle_of_attack=f.angle_of_attack[:-1],
            swing=np.pad(_bends(f.times, f.attitude), (1, 0), mode="edge"),
            weights=weights,
        )

    @property
    def steps(self) -> FloatArray:
        """Lengths of the steps [s], ``(n,)``."""
        return np.diff(self.times)

    def between(self, start: float, stop: float) -> Self | None:
        """Return the steps from one time [s] to another; None where there are fewer than two."""
        inside = np.flatnonzero((self.times[:-1] >= start) & (self.times[1:] <= stop))
        if inside.size < 2:
            return None
        some = slice(inside[0], inside[-1] + 1)
        own = {k: getattr(self, k)[some] for k in ("at", "angle", "rate", "acceleration")}
        ends = slice(some.start, some.stop + 1)
        return type(self)(
            times=self.times[ends],
            deflection=self.deflection[ends],
            **own,
            sharpest=largest(own["acceleration"], own["at"]),
            angle_of_attack=self.angle_of_attack[some],
            swing=self.swing[some],
            weights=self.weights[some],
        )


def largest(values: FloatArray, times: FloatArray) -> Point:
    """Return the value of largest size, with its sign, and its time."""
    k = int(np.argmax(np.abs(values)))
    return Point(float(values[k]), float(times[k]))


def rms(values: FloatArray, weights: FloatArray) -> float:
    """Return the root of the mean square, with the weights [s] of an integral over time."""
    return float(np.sqrt(np.average(values**2, weights=weights)))


def _bends(t: FloatArray, values: FloatArray) -> FloatArray:
    """Second derivative at the inner times: the change of slope over half of both steps."""
    return np.diff(np.diff(values) / np.diff(t)) / ((t[2:] - t[:-2]) / 2.0)


def _middle(values: FloatArray) -> FloatArray:
    return (values[1:] + values[:-1]) / 2.0
