"""Motion of a nozzle, step by step in time: from samples, or from a flight."""

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

    `times` [s], `deflection` [rad]: ``(n + 1,)``, with straight lines between. `at` [s]: a time in
    each step, ``(n,)``, and at these times: `angle`, `rate`, `acceleration`: the deflection and its
    derivatives [rad, rad/s, rad/s2]; `angle_of_attack` [rad]; `swing`: the angular acceleration of
    the vehicle [rad/s2]. `weights` [s]: of an integral over time, ``(n,)``. `sharpest`: the largest
    acceleration [rad/s2].
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
        acceleration = _second_derivative(t, delta)
        return cls(
            times=t,
            deflection=delta,
            at=_middle(t),
            angle=_middle(delta),
            rate=np.diff(delta) / np.diff(t),
            acceleration=_middle(np.pad(acceleration, 1, mode="edge")),
            sharpest=largest(acceleration, t[1:-1]),
            angle_of_attack=_middle(alpha),
            swing=_middle(np.pad(_second_derivative(t, attitude), 1, mode="edge")),
            weights=np.diff(t),
        )

    @classmethod
    def of_flight(cls, f: NozzleFlight) -> Self:
        """Return the motion of a flight with its actuator, right after the start of each step.

        Integrals take every second time, in the middle between two changes of the command.
        Without an actuator the motion is taken from sample to sample.
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
            swing=np.pad(_second_derivative(f.times, f.attitude), (1, 0), mode="edge"),
            weights=weights,
        )

    @property
    def steps(self) -> FloatArray:
        """Lengths of the steps [s], ``(n,)``."""
        return np.diff(self.times)

    def between(self, start: float, stop: float) -> Self | None:
        """Return the motion from `start` to `stop` [s]; None where it has fewer than two steps."""
        inside = np.flatnonzero((self.times[:-1] >= start) & (self.times[1:] <= stop))
        if inside.size < 2:
            return None
        steps = slice(inside[0], inside[-1] + 1)
        rows = {k: getattr(self, k)[steps] for k in ("at", "angle", "rate", "acceleration")}
        ends = slice(steps.start, steps.stop + 1)
        return type(self)(
            times=self.times[ends],
            deflection=self.deflection[ends],
            **rows,
            sharpest=largest(rows["acceleration"], rows["at"]),
            angle_of_attack=self.angle_of_attack[steps],
            swing=self.swing[steps],
            weights=self.weights[steps],
        )


def largest(values: FloatArray, times: FloatArray) -> Point:
    """Return the value of largest size, with its sign, and its time."""
    k = int(np.argmax(np.abs(values)))
    return Point(float(values[k]), float(times[k]))


def rms(values: FloatArray, weights: FloatArray) -> float:
    """Return the root of the mean square, with the weights [s] of an integral over time."""
    return float(np.sqrt(np.average(values**2, weights=weights)))


def _second_derivative(t: FloatArray, values: FloatArray) -> FloatArray:
    """Return second derivatives at the inner times, ``(n - 1,)``, from differences of slopes."""
    return np.diff(np.diff(values) / np.diff(t)) / ((t[2:] - t[:-2]) / 2.0)


def _middle(values: FloatArray) -> FloatArray:
    """Return the means of neighbouring values, ``(n,)``."""
    return (values[1:] + values[:-1]) / 2.0
