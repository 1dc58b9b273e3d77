"""Gusts with the shape of one minus a cosine, which start and end without a kink."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import ending, instance, nonnegative, single
from tvclin.numerics.pieces import Pieces
from tvclin.winds.checks import checked_part, checked_peak, checked_span, keep
from tvclin.winds.histories import History
from tvclin.winds.pulses import Pulse

# Parts of the peak at the rates 0, +j omega and -j omega. Every piece counts its time from its own
# start, where its half wave is at an extreme, so that all coefficients are real.
_UP = [0.5, -0.25, -0.25]
_PLATEAU = [1.0, 0.0, 0.0]
_DOWN = [0.5, 0.25, 0.25]
_CALM = [0.0, 0.0, 0.0]


@dataclass(frozen=True, kw_only=True, eq=False)
class OneMinusCosineGust(Pulse):
    """A gust that rises from t = 0 to its peak at T/2 and falls until T, both smoothly.

        alpha_w = (peak/2) (1 - cos(2 pi t/T)),    0 <= t <= T

    Parameters
    ----------
    peak : array_like
        Wind angle of attack at its largest [rad], not zero, within 90 degrees.
    duration : array_like
        Duration T [s], positive; broadcasts with `peak`. In the words of airworthiness rules it
        is twice the gust gradient distance over the speed.

    Raises
    ------
    InputError
        For a peak of zero or beyond 90 degrees, a duration not above zero, or shapes that do
        not broadcast.

    Notes
    -----
    The shape is that of 14 CFR 25.341(a)(2).
    """

    @cached_property
    def pieces(self) -> Pieces:
        """The pieces as arrays."""
        duration = np.asarray(self.duration)
        knots = np.stack([np.zeros_like(duration), duration / 2, duration], axis=-1)
        return _waves(np.asarray(self.peak), duration / 2, knots, [_UP, _DOWN, _CALM])


@dataclass(frozen=True, kw_only=True, eq=False)
class LayeredGust(History):
    """A gust that rises smoothly to its peak, stays there, and falls as it rose.

    The rise is (peak/2) (1 - cos(pi t/blend)), and the fall is its mirror image.

    Parameters
    ----------
    peak : array_like
        Wind angle of attack on the plateau [rad], not zero, within 90 degrees.
    blend : array_like
        How long the rise lasts [s], and the fall; zero or positive, zero being a jump.
    plateau : array_like
        How long the peak lasts [s]; zero or positive, and not zero where `blend` is. All three
        broadcast.

    Raises
    ------
    InputError
        For a peak of zero or beyond 90 degrees, a negative blend or plateau, a gust that does
        not last, or shapes that do not broadcast.

    Notes
    -----
    It is the discrete gust of NASA-HDBK-1001, eq (2.69), flown through: the heights there, over
    the rate of climb, are the times here. Not read in the handbook itself, but in the program
    MAPLEAF (TurbulenceModelling.py), which cites it.
    """

    peak: float | FloatArray = field()  # type: ignore[assignment]
    blend: float | FloatArray
    plateau: float | FloatArray

    def __post_init__(self) -> None:
        peak, blend = checked_peak(self.peak), checked_part("blend", self.blend)
        plateau = nonnegative("plateau", self.plateau, "s")
        keep(self, peak=peak, blend=blend, plateau=plateau)
        checked_span("blend + plateau", blend + plateau)

    @cached_property
    def pieces(self) -> Pieces:
        """The pieces as arrays."""
        blend = np.asarray(self.blend)
        top = blend + self.plateau
        knots = np.stack(np.broadcast_arrays(0.0, blend, top, top + blend), axis=-1)
        return _waves(np.asarray(self.peak), blend, knots, [_UP, _PLATEAU, _DOWN, _CALM])


def _waves(
    peak: FloatArray, half_wave: FloatArray, knots: FloatArray, shape: list[list[float]]
) -> Pieces:
    coefficients = peak[..., np.newaxis, np.newaxis] * np.array(shape)
    omega = np.pi / np.where(half_wave > 0.0, half_wave, 1.0)
    rates = 1j * omega[..., np.newaxis] * np.array([0.0, 1.0, -1.0])
    return Pieces(knots, coefficients[..., np.newaxis], rates)


def checked_gust(gust: History | None) -> History | None:
    """Return a gust, or none; `InputError` for a batch, and for one that does not end."""
    if gust is not None:
        instance("gust", gust, History, "such as OneMinusCosineGust")
        single("gust", gust.batch)
        ending("gust", gust.end)
    return gust
