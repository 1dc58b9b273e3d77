"""The deflection per wind angle in the worst sinusoidal wind, with the exact delay."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.control.autopilot.wiring import wind_numerator
from tvclin.control.margins.loop import Loop
from tvclin.control.margins.record import loop_margins
from tvclin.linear.flexible import AnyPlant
from tvclin.numerics import polynomials
from tvclin.numerics.loop_grid import AROUND, BELOW, BEYOND
from tvclin.numerics.searches import lowest

if TYPE_CHECKING:
    from tvclin.control.autopilot.autopilot import Autopilot


_EVEN = 801
"""Logarithmic frequencies from far below the smallest root to far beyond the largest."""
_ZERO = 1e-12
"""A root that is smaller, over the largest, is one at zero, of which there are no surroundings."""
_BESIDE = np.geomspace(1e-8, 0.3, 24)
"""Around a frequency at which |L| = 1, where a delay may leave little damping; relative."""
_PHASE_STEP, _MOST_STEPS = np.pi / 8.0, 20_000
"""Steps of the delay's phase [rad], and the most there may be."""


def wind_gain(plant: AnyPlant, autopilot: Autopilot) -> float:
    """Return the H-infinity norm from wind to deflection; infinite if the loop is not stable.

    `plant`, `autopilot`: one each.

    It is the highest peak of |G(j omega)|, the delay being exact. The peak is bracketed among
    frequencies around all roots and gain crossovers and refined there, so that what is left is
    rounding, about 1e-12 of the value for well separated roots. Of a flexible plant, which has no
    polynomials, it is the norm of python-control, with the Pade approximation of `Autopilot.close`.
    """
    found = loop_margins(autopilot.exact_loop(plant))
    if not found.stable:
        return float(np.inf)
    if plant.structure is not None:
        import control

        return float(control.system_norm(autopilot.close(plant)["deflection", "wind"], p="inf"))
    loop = autopilot.rational_loop(plant)
    above = wind_numerator(autopilot, plant)

    def lowness(omega: FloatArray) -> FloatArray:
        parts = loop.form.parts(omega.reshape(1, -1))
        returned, below = (part.reshape(omega.shape) for part in parts)
        return -np.abs(polynomials.value(above, 1j * omega) / (below + returned))

    omega = _samples(loop, above, found.crossings.gain_frequencies)
    values = lowness(omega)
    # At infinity nothing returns, and what is left is what passes through at once.
    through = abs(above[0] / loop.denominator[0]) if above.size == loop.denominator.size else 0.0
    k = 1 + np.flatnonzero((values[1:-1] <= values[:-2]) & (values[1:-1] < values[2:]))
    tops = lowest(lowness, omega[k - 1], omega[k + 1])[1] if k.size else values
    return float(max(-values.min(), -np.min(tops), through))


def _samples(loop: Loop, above: FloatArray, crossovers: FloatArray) -> FloatArray:
    """Frequencies from zero on, rising, that leave no resonance between two of them unseen."""
    parts = [loop.denominator + loop.numerator, loop.denominator, np.trim_zeros(above, "f")]
    roots = np.concatenate([polynomials.roots(part) for part in parts if part.size])
    sizes = np.abs(roots)
    counted = sizes[sizes > _ZERO * sizes.max()]
    low, high = BELOW * counted.min(), BEYOND * counted.max()
    widths = np.maximum(np.abs(roots.real), _BESIDE[0] * sizes)
    offsets = np.concatenate([-AROUND[1:], AROUND])
    every = [
        np.geomspace(low, high, _EVEN),
        (np.abs(roots.imag) + np.multiply.outer(offsets, widths)).ravel(),
        np.multiply.outer(crossovers, np.concatenate([1.0 - _BESIDE, 1.0 + _BESIDE])).ravel(),
    ]
    if loop.delay:
        turns = min(int(high * loop.delay / _PHASE_STEP), _MOST_STEPS)
        every.append(np.arange(1.0, turns + 1.0) * _PHASE_STEP / loop.delay)
    omega = np.concatenate(every)
    return np.unique(np.append(0.0, omega[(omega > 0.0) & (omega <= high)]))
