"""A sampled loop, whose margins are found in the w plane and given in the s plane."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.base.errors import within
from tvclin.control.margins.loop import Loop
from tvclin.kernels.loop_margins import LoopFindings
from tvclin.kernels.state_loop import StateLoop

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[Any]


@dataclass(frozen=True, eq=False, init=False)
class SampledLoop(Loop):
    """The loop of a sampled autopilot, from the command to minus what the law returns.

    Made by `Autopilot.exact_loop`. Frequencies are those of the s plane, from zero to half the
    sample rate.

    Attributes
    ----------
    form : StateLoop
        The same loops in the variable w, z = (1 + w h/2)/(1 - w h/2).
    batch : tuple of int
        Shape of the batch.
    period : ndarray
        h [s], ``(...)``.
    """

    period: FloatArray

    def __init__(self, form: StateLoop, batch: tuple[int, ...], period: FloatArray) -> None:
        self._hold(form, batch)
        object.__setattr__(self, "period", period)

    def response(self, omega: ArrayLike) -> ComplexArray:
        """Return L(e^(j omega h)), shape ``batch + omega.shape``; infinite at a pole.

        Parameters
        ----------
        omega : array_like
            Frequencies [rad/s] below half the sample rate, of any shape.
        """
        highest = float(np.pi / np.max(self.period))
        frequencies = within("omega", omega, -highest, highest, "rad/s")
        half = 0.5 * self.period.reshape(-1, 1)
        with np.errstate(over="ignore"):
            found = self._values(np.tan(frequencies.reshape(1, -1) * half) / half)
        return found.reshape((*self.batch, *frequencies.shape))

    @property
    def poles(self) -> ComplexArray:
        """Poles z of the open loop, ``(..., n)``."""
        return self._z(self.form.open_poles()).reshape((*self.batch, -1))

    @property
    def closed_loop_poles(self) -> ComplexArray:
        """Poles z of the closed loop, ``(..., n)``; inside the unit circle it is stable."""
        return self._z(self.form.closed_poles()).reshape((*self.batch, -1))

    def findings(self) -> LoopFindings:
        """Return verdict, crossings and peaks at frequencies of the s plane, of ``(k,)`` loops."""
        found = super().findings()
        half = 0.5 * self.period.reshape(-1)

        def turned(nu: FloatArray) -> FloatArray:
            rows = half.reshape(-1, *(1,) * (nu.ndim - 1))
            return np.arctan(nu * rows) / rows

        peaks = found.peaks.copy()
        peaks[..., 1] = turned(peaks[..., 1])
        return replace(
            found,
            gain_frequencies=turned(found.gain_frequencies),
            phase_frequencies=turned(found.phase_frequencies),
            peaks=peaks,
        )

    def in_plane(self, s: ComplexArray) -> ComplexArray:
        """Return w = (2/h) tanh(s h/2) of s ``(k, m)`` [1/s]."""
        half = 0.5 * self.period.reshape(-1, 1)
        return np.tanh(s * half) / half

    def from_plane(self, w: ComplexArray) -> ComplexArray:
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

    def _z(self, w: ComplexArray) -> ComplexArray:
        half = 0.5 * self.period.reshape(-1, 1)
        return (1.0 + w * half) / (1.0 - w * half)
