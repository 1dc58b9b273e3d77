"""The terms of a loop, one for each mode: which is the largest, its peak, where its pole goes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IndexArray
from tvclin.control.margins.loop import Loop
from tvclin.numerics.searches import lowest
from tvclin.numerics.state_loop import StateLoop

_AROUND = np.concatenate([-np.geomspace(40.0, 0.02, 60), [0.0], np.geomspace(0.02, 40.0, 60)])
"""Frequencies around a mode, in half-widths, among which its peak is looked for."""
_EVEN = 400
"""Frequencies over the whole range beside them."""
_NEAR, _LAID = 8.0, 401
"""The distance from -1 is the least within so many half-widths of a mode, and is looked for among
so many frequencies there."""
_STEPS, _NEWTON, _ASIDE = 12, 3, 1e-9
"""Steps of the gain from zero to one in which a mode is followed, Newton's in each, and how far
from its pole it begins, over its size."""


@dataclass(frozen=True, eq=False)
class Terms:
    """The terms of ``(k,)`` loops: poles and residues of n modes in the variable of the loop."""

    loop: Loop
    form: StateLoop
    plant: AnyArray
    poles: AnyArray
    residues: AnyArray

    @classmethod
    def of(cls, loop: Loop, plant: AnyArray) -> Terms:
        """Return the terms of loops held as matrices; `plant` has poles of the plant ``(k, n)``."""
        form = loop.form
        assert isinstance(form, StateLoop)
        wanted = loop.in_plane(plant)
        apart = np.abs(form.open_poles()[:, np.newaxis] - wanted[..., np.newaxis])
        place = np.argmin(np.nan_to_num(apart, nan=np.inf), axis=-1)
        every = (form.open_poles(), form.residues[form.case])
        poles, residues = (np.take_along_axis(one, place, axis=-1) for one in every)
        missing = np.isnan(plant)
        return cls(
            loop, form, plant, np.where(missing, np.nan, poles), np.where(missing, 0.0, residues)
        )

    def owner(self, omega: FloatArray) -> IndexArray:
        """The place of the largest term at frequencies ``(k, m)`` of s; -1 of the rigid body."""
        nu = np.imag(self.loop.in_plane(1j * omega))
        s = 1j * nu[:, np.newaxis]
        p, r = self.poles[..., np.newaxis], self.residues[..., np.newaxis]
        with np.errstate(all="ignore"):
            parts = np.where(r == 0.0, 0.0, r / (s - p) + r.conj() / (s - p.conj()))
            late = np.exp(-1j * nu * self.form.delay[:, np.newaxis])
            above, below = self.form.parts(nu)
            rest = above / below / late - parts.sum(axis=1)
            sizes = np.abs(np.concatenate([rest[:, np.newaxis], parts], axis=1))
        return np.argmax(np.nan_to_num(sizes, nan=-1.0, posinf=np.inf), axis=1) - 1

    def values(self, omega: FloatArray) -> AnyArray:
        """L at frequencies ``(k, m)`` of s."""
        above, below = self.form.parts(np.imag(self.loop.in_plane(1j * omega)))
        with np.errstate(all="ignore"):
            return above / below


def _around(terms: Terms, k: int) -> FloatArray:
    """Frequencies around a mode as it is seen, from zero to the highest, rising, ``(k, m)``."""
    pole = terms.loop.from_plane(terms.poles[:, k, np.newaxis])
    width = np.maximum(np.abs(pole.real), 1e-6 * np.abs(pole))
    near = pole.imag + width * _AROUND
    low, high = 0.05 * pole.imag, 20.0 * pole.imag
    even = low * (high / low) ** np.linspace(0.0, 1.0, _EVEN)
    omega = np.concatenate([near, even], axis=-1)
    omega = np.where(omega > 0.0, omega, low)
    omega = np.minimum(omega, terms.loop.highest())
    return np.sort(omega, axis=-1)


def peak(terms: Terms, k: int) -> tuple[FloatArray, FloatArray]:
    """Return the largest |L| where the k-th mode owns it, and where; NaN if it owns nothing."""
    omega = _around(terms, k)
    sizes = np.abs(terms.values(omega))
    sizes = np.where(terms.owner(omega) == k, sizes, -np.inf)
    top = np.argmax(sizes, axis=-1)
    rows = np.arange(len(omega))
    height, where = sizes[rows, top], omega[rows, top]
    nu = np.imag(terms.loop.in_plane(1j * omega))
    inner = np.clip(top, 1, omega.shape[-1] - 2)
    low, at, high = (nu[rows, inner + j] for j in (-1, 0, 1))
    owned = np.flatnonzero(np.isfinite(height))
    if owned.size:
        form = terms.form.take(owned)

        def lowness(frequency: FloatArray) -> FloatArray:
            above, below = form.parts(frequency)
            return -np.abs(above / below)

        found, least = lowest(lowness, low[owned], high[owned])
        better = -least > height[owned]
        height[owned[better]], at[owned[better]] = -least[better], found[better]
        where = np.where(
            np.isfinite(height), np.imag(terms.loop.from_plane(1j * at[:, np.newaxis]))[:, 0], where
        )
    nothing = ~np.isfinite(height)
    return np.where(nothing, np.nan, height), np.where(nothing, np.nan, where)


def distance(terms: Terms, k: int, closed: AnyArray) -> FloatArray:
    """Return the least |1 + L| within eight half-widths of the k-th pole.

    It lies beside the closed pole ``(m,)`` of the mode, where that is near, and is as wide.
    """
    pole, near = (terms.loop.from_plane(of[:, np.newaxis]) for of in (terms.poles[:, k], closed))
    low, high = (pole.imag + side * _NEAR * np.abs(pole.real) for side in (-1.0, 1.0))
    even = low + (high - low) * np.linspace(0.0, 1.0, _LAID)
    beside = np.clip(near.imag + np.abs(near.real) * _AROUND, low, high)
    offsets = np.sort(np.nan_to_num(np.concatenate([even, beside], axis=-1)), axis=-1)

    def height(omega: FloatArray) -> FloatArray:
        return np.abs(1.0 + terms.values(np.abs(omega)))

    values = height(offsets)
    rows, last = np.arange(len(values)), values.shape[-1] - 1
    place = np.argmin(np.nan_to_num(values, nan=np.inf), axis=-1)
    before, after = (offsets[rows, np.clip(place + step, 0, last)] for step in (-1, 1))
    return np.minimum(values.min(axis=-1), lowest(height, before, after)[1])


def followed(terms: Terms) -> AnyArray:
    """Return the closed-loop poles that begin at those of the modes as the gain grows, ``(k, n)``.

    Newton's steps on (s - p)(1 + g L) = 0, which has no pole at p, for g rising to one.
    """
    p = terms.poles
    s = p * (1.0 - _ASIDE)
    with np.errstate(all="ignore"):
        for gain in [*np.linspace(0.0, 1.0, _STEPS + 1)[1:], 1.0, 1.0]:
            for _ in range(_NEWTON):
                value, slope = gain * terms.form.value(s), gain * terms.form.slope(s)
                step = (s - p) * (1.0 + value) / (1.0 + value + (s - p) * slope)
                s = np.where(np.isfinite(step), s - step, s)
    return np.where(terms.residues == 0.0, p, s)
