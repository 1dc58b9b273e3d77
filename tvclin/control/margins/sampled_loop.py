"""A sampled loop, whose margins are found in the w plane and given in the s plane."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tvclin.base.errors import within
from tvclin.control.margins.loop import Loop
from tvclin.linear.system import delay_parts
from tvclin.numerics.loop_margins import LoopFindings
from tvclin.numerics.state_loop import StateLoop

_STEPS, _LONGEST, _NEAR = 30, 0.05, 1e-11
"""Newton's steps to a delay, how long over the frequency, and how near is there."""
_PER_SAMPLE, _LOOKS, _ROUNDS = 48.0, (8, 192), 14
"""Delays in a sample with which a loop is looked at, how few and how many they may be in all, and
how often it is looked again where it begins to grow: to 8^-13 of their distance."""
_BEYOND = 1.0 + 1e-6
"""So far beyond a delay that is an edge a loop grows."""


@dataclass(frozen=True, eq=False, init=False)
class SampledLoop(Loop):
    """The loop of a sampled autopilot, from the command to minus what the law returns.

    Made by `Autopilot.exact_loop`. Frequencies are those of the s plane, from zero to half the
    sample rate; `form` is in the variable w, z = (1 + w h/2)/(1 - w h/2).

    `period`, `late`: h, and the delay [s], ``(...)``. `later`: takes delays below h [s] ``(k,)``
    and the positions ``(k,)`` of loops in the flattened batch, and gives these loops with those
    delays. `closed_later`: takes any delays and positions, and gives the closed-loop poles z.
    """

    period: FloatArray
    late: FloatArray
    later: Callable[[FloatArray, IndexArray], StateLoop]
    closed_later: Callable[[FloatArray, IndexArray], AnyArray]

    def __init__(
        self,
        form: StateLoop,
        batch: tuple[int, ...],
        period: FloatArray,
        late: FloatArray,
        later: Callable[[FloatArray, IndexArray], StateLoop],
        closed_later: Callable[[FloatArray, IndexArray], AnyArray],
    ) -> None:
        self._hold(form, batch)
        own = {"period": period, "late": late, "later": later, "closed_later": closed_later}
        for name, value in own.items():
            object.__setattr__(self, name, value)

    def response(self, omega: ArrayLike) -> AnyArray:
        """Return L(e^(j omega h)) below half the sample rate [rad/s], as of `Loop`."""
        highest = float(np.pi / np.max(self.period))
        frequencies = within("omega", omega, -highest, highest, "rad/s")
        half = 0.5 * self.period.reshape(-1, 1)
        with np.errstate(over="ignore"):
            found = self._values(np.tan(frequencies.reshape(1, -1) * half) / half)
        return found.reshape((*self.batch, *frequencies.shape))

    @property
    def poles(self) -> AnyArray:
        """Poles z of the open loop, ``(..., n)``."""
        return self._z(self.form.open_poles()).reshape((*self.batch, -1))

    @property
    def closed_loop_poles(self) -> AnyArray:
        """Poles z of the closed loop, ``(..., n)``; inside the unit circle it is stable."""
        return self._z(self.form.closed_poles()).reshape((*self.batch, -1))

    def findings(self, *, delays: bool = True) -> LoopFindings:
        """Return verdict, crossings and peaks at frequencies of the s plane, as of `Loop`."""
        found = super().findings(delays=delays)
        half = 0.5 * self.period.reshape(-1)

        def turned(nu: FloatArray) -> FloatArray:
            rows = half.reshape(-1, *(1,) * (nu.ndim - 1))
            return np.arctan(nu * rows) / rows

        peaks = found.peaks.copy()
        peaks[..., 1] = turned(peaks[..., 1])
        omega = turned(found.gain_frequencies)
        return replace(
            found,
            gain_frequencies=omega,
            delays=self._delays(omega, found.phases, found.stable)
            if delays
            else np.full_like(omega, np.nan),
            phase_frequencies=turned(found.phase_frequencies),
            peaks=peaks,
        )

    def _delays(self, omega: FloatArray, phases: FloatArray, stable: BoolArray) -> FloatArray:
        """How much later L may be until it is -1 [s], ``(k, n)``, the least exactly.

        A delay that is no whole number of samples changes |L| as well. By Newton's steps on
        ln L(omega, T) = ln(-1), a whole sample being a factor of 1/z.
        """
        found = phases % (2.0 * np.pi) / omega
        if not found.shape[1]:
            return found
        case, place = np.nonzero(stable[:, np.newaxis] & np.isfinite(found))
        h, late = self.period.ravel()[case], self.late.ravel()[case]
        w, more = omega[case, place], found[case, place]
        arrived = np.zeros(case.size, dtype=bool)
        for _ in range(_STEPS if case.size else 0):
            whole, rest = delay_parts(late + more, h)
            nu = np.tan(0.5 * w * h) / (0.5 * h)
            form = self.later(rest, case)
            L, slope = (of(1j * nu[:, np.newaxis])[:, 0] for of in (form.value, form.slope))
            rate = 1j * slope / L * (1.0 + (0.5 * nu * h) ** 2)  # d ln L/d omega
            step = np.clip(-np.log(np.abs(L)) / rate.real, -_LONGEST * w, _LONGEST * w)
            w = np.minimum(w + step, np.pi / h)
            ahead = np.angle(-L) + rate.imag * step - whole * h * w
            ahead -= 2.0 * np.pi * np.round(ahead / (2.0 * np.pi))
            more = np.maximum(more + ahead / w, 0.0)
            arrived = (np.abs(step) < _NEAR * w) & (np.abs(ahead) < _NEAR)
            if np.all(arrived):
                break
        found[case[arrived], place[arrived]] = more[arrived]
        for k in np.flatnonzero(stable & np.any(np.isfinite(found), axis=1)):
            edges = np.sort(found[k, np.isfinite(found[k])])
            grows = self._grows(int(k), _BEYOND * edges)
            edge = edges[np.argmax(grows)]  # what is none is left out, if another is one
            least = self._grows_within(int(k), float(edge))
            first = int(np.nanargmin(found[k]))
            found[k] = np.maximum(found[k], least)
            found[k, first] = least
        return found

    def _grows(self, case: int, more: FloatArray) -> BoolArray:
        """Whether a loop grows with so much more delay [s], ``(m,)``."""
        late = self.late.ravel()[case]
        z = self.closed_later(late + more, np.full(more.size, case))
        return np.asarray(np.any(np.abs(z) > 1.0 + _NEAR, axis=-1))

    def _grows_within(self, case: int, most: float) -> float:
        """The delay [s] below `most` with which a loop begins to grow; `most` where it does not.

        Beside half the sample rate |L| changes with the part of a sample that a delay ends with,
        and may be one where now it is not.
        """
        count = int(np.clip(np.ceil(_PER_SAMPLE * most / self.period.ravel()[case]), *_LOOKS))
        low, high = 0.0, most
        for _ in range(_ROUNDS):
            looks = low + (high - low) * np.append(np.arange(1, count) / count, 2.0 - _BEYOND)
            grows = self._grows(case, looks)
            if high == most and not np.any(grows):
                return most
            first = int(np.argmax(grows)) if np.any(grows) else looks.size
            ends = np.concatenate([[low], looks, [high]])
            low, high, count = float(ends[first]), float(ends[first + 1]), _LOOKS[0]
        return high

    def in_plane(self, s: AnyArray) -> AnyArray:
        """Return w = (2/h) tanh(s h/2) of s ``(k, m)`` [1/s]."""
        half = 0.5 * self.period.reshape(-1, 1)
        return np.tanh(s * half) / half

    def from_plane(self, w: AnyArray) -> AnyArray:
        """Return the s ``(k, m)`` [1/s] of w, of all that have it the nearest to zero."""
        half = 0.5 * self.period.reshape(-1, 1)
        return np.arctanh(np.asarray(w, complex) * half) / half

    def highest(self) -> FloatArray:
        """Return half the sample rate [rad/s], ``(k, 1)``."""
        return np.pi / self.period.reshape(-1, 1)

    def aliases(self, omega: FloatArray) -> FloatArray:
        """Return where frequencies ``(k, m)`` [rad/s] above half the rate appear, else NaN."""
        whole = 2.0 * np.pi / self.period.reshape(-1, 1)
        folded = np.abs(omega - whole * np.round(omega / whole))
        return np.where(omega > 0.5 * whole, folded, np.nan)

    def _z(self, w: AnyArray) -> AnyArray:
        half = 0.5 * self.period.reshape(-1, 1)
        return (1.0 + w * half) / (1.0 - w * half)
