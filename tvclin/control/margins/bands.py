"""Margins by band: of the rigid body, and of each bending mode and tank.

The loop is a sum of partial fractions,

    L(s) = sum over modes [r_k/(s - p_k) + conj(r_k)/(s - conj(p_k))] + rigid body.

Each lightly damped pair of plant poles p_k owns its two terms, the rigid body the rest; at any
frequency the largest term owns the loop, its crossings and its peak.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IndexArray
from tvclin.base.cards import Shown
from tvclin.base.documents import decibels, keyed
from tvclin.base.errors import InputError, instance, one_of, plain
from tvclin.control.margins.loop import Loop
from tvclin.control.margins.margins import InDecibels, Margins, in_shape, margins_of
from tvclin.numerics.loop_margins import LoopAnalysis, classical_margins, row_minimum
from tvclin.numerics.loops import StateLoop
from tvclin.numerics.searches import grid_minimum

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

        found, least = grid_minimum(lowness, low[owned], high[owned])
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
    return np.minimum(values.min(axis=-1), grid_minimum(height, before, after)[1])


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


GAIN, PHASE, RIGID, UNSTABLE = "gain", "phase", "with the rigid body", "unstable"


@dataclass(frozen=True, eq=False)
class RigidBand(Shown, InDecibels):
    """Margins of a stable loop at the crossings of the rigid body; ``(...)``.

    NaN for a loop that is not stable; infinite, and the frequency NaN, where there is none.

    Attributes
    ----------
    aero_margin, gain_increase, phase_margin : float or ndarray
        As of `Margins`: factors on the gain, and a phase [rad].
    aero_frequency, gain_increase_frequency, crossover_frequency : float or ndarray
        Where they are [rad/s].
    """

    aero_margin: Any
    aero_frequency: Any
    gain_increase: Any
    gain_increase_frequency: Any
    phase_margin: Any
    crossover_frequency: Any

    as_dict = keyed(
        "aero_margin_dB aero_frequency_rad_per_s gain_increase_dB gain_increase_frequency_rad_per_s"
        " phase_margin_deg crossover_frequency_rad_per_s"
    )
    _keys = "aero_margin_dB gain_increase_dB phase_margin_deg"


@dataclass(frozen=True, eq=False)
class ModeBand(Shown):
    """One mode in the loop; numbers have the shape ``(...)`` of the batch.

    Attributes
    ----------
    name : str
        Name of the mode in the plant.
    pole : complex or ndarray
        Its pole in the plant [1/s].
    closed_pole : complex or ndarray
        Where it goes as the gain of the loop grows from zero to one [1/s]. Of a sampled loop that
        of least frequency which has the same samples.
    stabilised : str or ndarray of str
        "gain": it is felt, and ``|L|`` stays below one where it owns the loop. "phase": ``|L|`` is
        one or above one there, all over where the rest of the loop is large at its frequency.
        "with the rigid body": the rest of the loop is larger even at its pole. "unstable": its
        closed pole lies in the right half plane.
    peak, peak_frequency : float or ndarray
        The largest ``|L|`` at frequencies that it owns, and where [rad/s]; NaN if it owns none.
    lag_margin, lead_margin : float or ndarray
        The least phase [rad] by which L may lag, and lead, at crossovers that it owns; infinite
        without one, and NaN in a loop that is not stable.
    gain_reduction, gain_increase : float or ndarray
        Factors above one by which the gain may fall and rise at phase crossovers that it owns.
    distance : float or ndarray
        The least ``|1 + L|`` within eight half-widths of its pole.
    alias : float or ndarray
        The frequency [rad/s] at which a sampled law sees it, where that is another; else NaN.
    """

    name: str
    pole: Any
    closed_pole: Any
    stabilised: Any
    peak: Any
    peak_frequency: Any
    lag_margin: Any
    lead_margin: Any
    gain_reduction: Any
    gain_increase: Any
    distance: Any
    alias: Any

    as_dict = keyed(
        "frequency_rad_per_s closed_pole stabilised peak_dB peak_frequency_rad_per_s gain_margin_dB"
        " phase_margin_deg lag_margin_deg lead_margin_deg gain_reduction_dB gain_increase_dB"
        " distance alias_rad_per_s"
    )

    _keys = "frequency_rad_per_s stabilised peak_dB gain_margin_dB phase_margin_deg distance"

    @property
    def frequency(self) -> Any:
        """Frequency of the mode in the plant [rad/s]."""
        return plain(np.abs(self.pole))

    @property
    def peak_dB(self) -> Any:
        """The peak in dB."""
        return decibels(self.peak)

    @property
    def gain_margin_dB(self) -> Any:
        """By how many dB a gain-stabilised mode stays below one; NaN for others."""
        stays = np.asarray(self.stabilised) == GAIN
        return plain(np.where(stays, -np.asarray(self.peak_dB), np.nan)[()])

    @property
    def phase_margin_deg(self) -> Any:
        """The smaller of lag and lead margin in degrees; NaN where there is none.

        Only a mode that is held by phase has one, and only if it has a crossover of its own.
        """
        least = np.degrees(np.minimum(self.lag_margin, self.lead_margin))
        held = (np.asarray(self.stabilised) == PHASE) & np.isfinite(least)
        return plain(np.where(held, least, np.nan)[()])


@dataclass(frozen=True, eq=False)
class BandMargins(Shown):
    """The margins of one loop by band, or of a batch.

    Attributes
    ----------
    whole : Margins
        Of the whole loop: the verdict.
    rigid : RigidBand
        Of the rigid body.
    modes : tuple of ModeBand
        Of each bending mode and tank.
    """

    whole: Margins
    rigid: RigidBand
    modes: tuple[ModeBand, ...]

    def mode(self, name: str) -> ModeBand:
        """Return the band of one mode by its name."""
        names = [one.name for one in self.modes]
        return self.modes[names.index(one_of("name", name, names))]

    def as_dict(self) -> dict[str, Any]:
        """Return the record as the command line prints it as JSON, angles in degrees."""
        return {"rigid_body": self.rigid, "modes": {one.name: one for one in self.modes}}

    _keys = "whole_loop=whole.status rigid_body=rigid mode=modes"


def band_margins(
    loop: Loop, names: tuple[str, ...], poles: AnyArray, *, delays: bool = True
) -> BandMargins:
    """Return the margins of a loop by band.

    `loop`: held as matrices, one or a batch ``(...)``. `names`: names of the modes. `poles`: upper
    pole of each in the plant [1/s], ``(..., n)``; each is a pole of the loop. `delays`: as of
    `Loop.findings`. `InputError` for a loop that is held as polynomials.
    """
    instance("loop", loop, Loop, "see Autopilot.exact_loop")
    if not isinstance(loop.form, StateLoop):
        raise InputError(
            "band_margins() takes loops that are held as matrices; see Loop.from_system"
        )
    count = len(loop.form.case)
    own = np.broadcast_to(poles, (*loop.batch, len(names))).reshape(count, len(names))
    terms = Terms.of(loop, own)
    found = loop.findings(delays=delays)
    ends = followed(terms)
    numbers = [_rigid(terms, found)]
    numbers += [_mode(terms, found, k, ends[:, k]) for k in range(len(names))]
    shaped = [{key: in_shape(v, loop.batch) for key, v in one.items()} for one in numbers]
    modes = (ModeBand(name=name, **one) for name, one in zip(names, shaped[1:], strict=True))
    return BandMargins(margins_of(found, loop.batch), RigidBand(**shaped[0]), tuple(modes))


def _rigid(terms: Terms, found: LoopAnalysis) -> dict[str, Any]:
    pairs = classical_margins(_owned(terms, found, -1))[:3]
    pairs[..., ~found.stable] = np.nan
    names = (field.name for field in fields(RigidBand))
    return dict(zip(names, pairs.reshape(-1, len(found.stable)), strict=True))


def _mode(terms: Terms, found: LoopAnalysis, k: int, closed: AnyArray) -> dict[str, Any]:
    pole = terms.plant[:, k]
    owned = _owned(terms, found, k)
    highest, where = peak(terms, k)
    felt = terms.owner(np.nan_to_num(np.imag(pole), nan=1.0)[:, np.newaxis])[:, 0] == k
    crosses = np.any(~np.isnan(owned.phases), axis=-1)
    by_phase = crosses | (felt & (highest >= 1.0))
    words = np.select([closed.real > 0.0, by_phase, ~felt], [UNSTABLE, PHASE, RIGID], GAIN)
    sides = (np.where(one > 0.0, one, np.nan) for one in (owned.phases, -owned.phases))
    lags = [row_minimum(one, found.gain_frequencies)[0] for one in sides]
    margins = np.stack([*lags, *classical_margins(owned)[:2, 0]])
    margins[:, ~found.stable] = np.nan
    names = ("lag_margin", "lead_margin", "gain_reduction", "gain_increase")
    return {
        **dict(zip(names, margins, strict=True)),
        "pole": pole,
        "closed_pole": terms.loop.from_plane(closed[:, np.newaxis])[:, 0],
        "stabilised": words,
        "peak": highest,
        "peak_frequency": where,
        "distance": distance(terms, k, closed),
        "alias": terms.loop.aliases(np.imag(pole)[:, np.newaxis])[:, 0],
    }


def _owned(terms: Terms, found: LoopAnalysis, k: int) -> LoopAnalysis:
    """The findings with the crossings that the k-th mode owns alone."""

    def own(omega: FloatArray, values: FloatArray) -> FloatArray:
        return np.where(terms.owner(np.nan_to_num(omega)) == k, values, np.nan)

    phases = own(found.gain_frequencies, found.phases)
    return replace(found, phases=phases, factors=own(found.phase_frequencies, found.factors))
