"""Which flights of the trim law survive with less than the bound of their needs.

The largest min(trim, demand) is enough, and in a wind of one sign no more than that. A wind that
turns about may need less: it finds the attitude off to the side from which it blows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tvclin.answers.availability.met import on_lines
from tvclin.answers.sizing.flight_mode import FlightMode
from tvclin.answers.sizing.flown import flight_steps, trim_law_lost
from tvclin.base.arrays import BoolArray, FloatArray, IndexArray

_LEAST, _MOST, _LOOKS = 0.5, 1.2, 24
"""Of the bound: with less nothing is flown, for the attitude is then off by more than is linear;
and up to so much, from the limit that is asked about, flights with so many limits must survive."""


@dataclass(frozen=True, eq=False)
class PlaneFlights:
    """Flights in one plane.

    A flight must survive each of its `winds`, knots [s] and wind angles [rad] there, ``(r, k)``;
    `bound` is the largest min(trim, demand) [rad], ``(r,)``.
    """

    mode: FlightMode
    winds: Sequence[tuple[FloatArray, FloatArray]]
    bound: FloatArray

    def lost(self, which: IndexArray, parts: FloatArray) -> BoolArray:
        """Return which of some are lost with parts of their bounds, each ``(w, p)``."""
        steps = flight_steps(self.mode)
        there = np.broadcast_to(steps, (which.size, steps.size))
        limits = parts * self.bound[which, np.newaxis]
        lost = np.zeros(parts.shape, dtype=bool)
        for times, angle in self.winds:
            wind = on_lines(times[which], angle[which], there)
            lost |= trim_law_lost(self.mode, steps, wind, limits)
        return lost


def survives_all(planes: Sequence[PlaneFlights], part: FloatArray) -> BoolArray:
    """Return which flights survive in all planes with a part of their bounds and more, ``(r,)``.

    Below a half, and from 1 on, nothing is flown, and it is False.
    """
    left = np.flatnonzero((part >= _LEAST) & (part < 1.0))
    for looks in (np.zeros(1), np.linspace(0.0, 1.0, _LOOKS)[1:]):  # most are lost with the first
        for plane in planes:
            if left.size:
                asked = part[left, np.newaxis]
                lost = plane.lost(left, asked + looks * (_MOST - asked))
                left = left[~lost.any(axis=1)]
    survives = np.zeros(part.size, dtype=bool)
    survives[left] = True
    return survives
