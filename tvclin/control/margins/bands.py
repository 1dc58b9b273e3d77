"""Margins by band: of the rigid body, and of each bending mode and tank.

The loop is a sum of partial fractions,

    L(s) = sum over modes [r_k/(s - p_k) + conj(r_k)/(s - conj(p_k))] + rigid body.

Each lightly damped pair of plant poles p_k owns its two terms, the rigid body the rest; at any
frequency the largest term owns the loop, its crossings and its peak.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IndexArray
from tvclin.base.cards import Shown
from tvclin.base.errors import one_of, plain
from tvclin.base.fields import decibels, derived, spec
from tvclin.control.margins.loop import Loop
from tvclin.control.margins.margins import InDecibels, Margins, in_batch_shape, margins_of
from tvclin.numerics.loop_margins import (
    PEAK_REFINEMENTS,
    LoopAnalysis,
    classical_margins,
    row_minimum,
)
from tvclin.numerics.loops import StateLoop
from tvclin.numerics.searches import grid_minimum

_OFFSETS = np.concatenate([-np.geomspace(40.0, 0.02, 60), [0.0], np.geomspace(0.02, 40.0, 60)])
"""Distances of search frequencies from a mode's frequency, in half-widths of its resonance."""
_GRID_FREQUENCIES = 400
"""Number of logarithmic search frequencies around a mode, from 1/20 to 20 of its frequency."""
_DISTANCE_HALF_WIDTHS = 8.0
"""Range of the distance from -1 around a mode's frequency, in half-widths."""
_DISTANCE_FREQUENCIES = 401
"""Number of search frequencies in that range."""
_GAIN_STEPS = 12
"""Number of steps of the loop gain from zero to one in the continuation of a mode's pole."""
_NEWTON_STEPS = 3
"""Number of Newton steps at each gain."""
_START_OFFSET = 1e-9
"""Distance of the start of the continuation from the pole, relative."""


@dataclass(frozen=True, eq=False)
class Terms:
    """Partial fractions of k loops: poles and residues ``(k, n)`` of n modes.

    `plant`: poles of the modes in the plant [1/s], ``(k, n)``; NaN where a loop lacks a mode.
    """

    loop: Loop
    form: StateLoop
    plant: AnyArray
    poles: AnyArray
    residues: AnyArray

    @classmethod
    def of(cls, loop: Loop, plant: AnyArray) -> Terms:
        """Return the terms of n modes in the partial fractions of k loops in matrix form.

        Pole and residue are in the variable w of the loops: s, or for sampled loops the bilinear
        variable. `plant`: poles of the modes in the plant [1/s], ``(k, n)``; NaN for no mode, of
        which the residue is zero.
        """
        form = loop.form
        assert isinstance(form, StateLoop)
        # Of each mode the pole of the loop that is nearest to the pole of the plant.
        distances = form.open_poles()[:, np.newaxis] - loop.s_to_w(plant)[..., np.newaxis]
        nearest = np.argmin(np.nan_to_num(np.abs(distances), nan=np.inf), axis=-1)
        poles = np.take_along_axis(form.open_poles(), nearest, axis=-1)
        # a case is the index of a loop's matrices, which several loops may share
        residues = np.take_along_axis(form.residues[form.case], nearest, axis=-1)
        missing = np.isnan(plant)
        poles, residues = np.where(missing, np.nan, poles), np.where(missing, 0.0, residues)
        return cls(loop, form, plant, poles, residues)

    def owner(self, omega: FloatArray, values: AnyArray | None = None) -> IndexArray:
        """Return the index of the mode with the largest term of L, ``(k, m)``; -1: rigid body.

        Of k loops at m frequencies. A mode's term is r/(s - p) + conj(r)/(s - conj(p)) of its pole
        p and residue r at s = j nu; the rigid body's is the rest of L without its delay.

        `omega`: frequencies [rad/s], ``(k, m)``. `values`: L at these frequencies, if known.
        """
        values = self.values(omega) if values is None else values
        # of the variable of the partial fractions: s, or if sampled w of the bilinear rule
        nu = np.imag(self.loop.s_to_w(1j * omega))
        s = 1j * nu[:, np.newaxis]
        p, r = self.poles[..., np.newaxis], self.residues[..., np.newaxis]
        with np.errstate(all="ignore"):
            modes = np.where(r == 0.0, 0.0, r / (s - p) + r.conj() / (s - p.conj()))
            delay = np.exp(-1j * nu * self.form.delay[:, np.newaxis])
            rigid = values / delay - modes.sum(axis=1)
            sizes = np.abs(np.concatenate([rigid[:, np.newaxis], modes], axis=1))
        # less one, as the rigid body is the first of the terms
        return np.argmax(np.nan_to_num(sizes, nan=-1.0, posinf=np.inf), axis=1) - 1

    def values(self, omega: FloatArray) -> AnyArray:
        """Return L of k loops at frequencies `omega` [rad/s], both ``(k, m)``; inf at a pole."""
        # the form has numerator and denominator as functions of s, or of w if sampled
        numerator, denominator = self.form.parts(np.imag(self.loop.s_to_w(1j * omega)))
        with np.errstate(all="ignore"):
            return numerator / denominator


def _frequencies(terms: Terms, k: int) -> FloatArray:
    """Return rising search frequencies [rad/s] around a mode (or its alias), ``(loops, m)``.

    Close together within 40 half-widths of its resonance, and from 1/20 to 20 of its frequency; at
    most half the sample rate. `terms`: partial fractions of the loops, in s, or in w of the
    bilinear rule if sampled. `k`: index of the mode.
    """
    pole = terms.loop.w_to_s(terms.poles[:, k, np.newaxis])  # in s [1/s], (loops, 1)
    # Half-width of the resonance; a mode without damping would have none.
    width = np.maximum(np.abs(pole.real), 1e-6 * np.abs(pole))
    resonance = pole.imag + width * _OFFSETS  # -40 to 40 half-widths
    low, high = 0.05 * pole.imag, 20.0 * pole.imag
    grid = low * (high / low) ** np.linspace(0.0, 1.0, _GRID_FREQUENCIES)
    omega = np.concatenate([resonance, grid], axis=-1)
    omega = np.where(omega > 0.0, omega, low)
    return np.sort(np.minimum(omega, terms.loop.max_frequency()), axis=-1)


def mode_peak(terms: Terms, k: int) -> tuple[FloatArray, FloatArray]:
    """Return the peak of |L| where a mode's partial fraction is the largest, and its frequency.

    Both ``(loops,)``, the frequency in rad/s; NaN for a mode that owns no frequency, its partial
    fraction being nowhere the largest. `terms`: partial fractions of the loops. `k`: index of the
    mode.
    """
    omega = _frequencies(terms, k)
    values = terms.values(omega)
    sizes = np.where(terms.owner(omega, values) == k, np.abs(values), -np.inf)
    top = np.argmax(sizes, axis=-1)
    rows = np.arange(len(omega))
    height = sizes[rows, top]
    nu = np.imag(terms.loop.s_to_w(1j * omega))  # in the variable of the form, w if sampled
    inner = np.clip(top, 1, omega.shape[-1] - 2)
    low, peak, high = (nu[rows, inner + j] for j in (-1, 0, 1))  # frequencies around the sample
    owned = np.flatnonzero(np.isfinite(height))  # loops in which the mode owns a frequency
    if owned.size:
        form = terms.form.take(owned)

        def negative_gain(frequency: FloatArray) -> FloatArray:
            """Return -|L|, to be minimised, of the loops in which the mode owns a frequency.

            `frequency`: of the variable of `form`, the loops' partial fractions, ``(owned, ...)``.
            """
            numerator, denominator = form.parts(frequency)
            return -np.abs(numerator / denominator)

        bounds = low[owned], high[owned]
        location, minimum = grid_minimum(negative_gain, *bounds, PEAK_REFINEMENTS, smooth=True)
        better = -minimum > height[owned]
        height[owned[better]], peak[owned[better]] = -minimum[better], location[better]
    frequency = np.imag(terms.loop.w_to_s(1j * peak[:, np.newaxis]))[:, 0]
    none = ~np.isfinite(height)
    return np.where(none, np.nan, height), np.where(none, np.nan, frequency)


def mode_distance(terms: Terms, k: int, closed: AnyArray) -> FloatArray:
    """Return the minimum of |1 + L| within eight half-widths of a mode's pole, ``(loops,)``.

    `terms`: partial fractions of the loops. `k`: index of the mode. `closed`: its closed-loop pole,
    ``(loops,)``. If it lies in that range, the minimum is near it and as wide as its half-width.
    """
    # poles [1/s], (loops, 1): s itself, or of a sampled loop at w, by w = (2/h) tanh(s h/2)
    open_pole = terms.loop.w_to_s(terms.poles[:, k, np.newaxis])
    closed_pole = terms.loop.w_to_s(closed[:, np.newaxis])
    half_range = _DISTANCE_HALF_WIDTHS * np.abs(open_pole.real)
    low, high = open_pole.imag - half_range, open_pole.imag + half_range
    grid = low + (high - low) * np.linspace(0.0, 1.0, _DISTANCE_FREQUENCIES)
    # and close together around the closed-loop pole, -40 to 40 half-widths
    resonance = np.clip(closed_pole.imag + np.abs(closed_pole.real) * _OFFSETS, low, high)
    omega = np.sort(np.nan_to_num(np.concatenate([grid, resonance], axis=-1)), axis=-1)

    def distance(omega: FloatArray) -> FloatArray:
        """Return |1 + L|^2 at frequencies `omega` [rad/s]: smooth where it vanishes."""
        L = terms.values(np.abs(omega))
        return np.asarray((1.0 + L.real) ** 2 + L.imag**2)

    values = distance(omega)
    rows, last = np.arange(len(values)), values.shape[-1] - 1
    smallest = np.argmin(np.nan_to_num(values, nan=np.inf), axis=-1)
    before, after = (omega[rows, np.clip(smallest + step, 0, last)] for step in (-1, 1))
    _, refined = grid_minimum(distance, before, after, PEAK_REFINEMENTS, smooth=True)
    return np.sqrt(np.minimum(values.min(axis=-1), refined))


def closed_mode_poles(terms: Terms) -> AnyArray:
    """Return the closed-loop poles of n modes of k loops [1/s], ``(k, n)``: s, or w if sampled.

    `terms`: their partial fractions. A mode's pole p is continued as the gain g rises from zero to
    one, by Newton's iteration on (s - p)(1 + g L) = 0, L being the open loop: this has no pole at
    p. It starts just beside p, where L is defined. A mode without a residue stays at p.
    """
    p = terms.poles
    s = p * (1.0 - _START_OFFSET)
    with np.errstate(all="ignore"):
        # Two rounds more at the gain of one, for convergence.
        for gain in [*np.linspace(0.0, 1.0, _GAIN_STEPS + 1)[1:], 1.0, 1.0]:
            for _ in range(_NEWTON_STEPS):
                value, slope = gain * terms.form.value(s), gain * terms.form.slope(s)
                step = (s - p) * (1.0 + value) / (1.0 + value + (s - p) * slope)
                s = np.where(np.isfinite(step), s - step, s)
    return np.where(terms.residues == 0.0, p, s)


GAIN, PHASE, RIGID, UNSTABLE = "gain", "phase", "with the rigid body", "unstable"


@dataclass(frozen=True, eq=False)
class RigidBand(Shown, InDecibels):
    """Margins of a stable loop at the crossings that the rigid body owns, ``(...)``.

    NaN for a loop that is not stable; infinite, with the frequency NaN, without a crossing.

    Attributes
    ----------
    aero_margin, gain_increase, phase_margin : float or ndarray
        Factors on the gain, and a phase [rad], as in `Margins`.
    aero_frequency, gain_increase_frequency, crossover_frequency : float or ndarray
        Frequencies of the margins [rad/s].
    """

    aero_margin: Any = field(metadata=spec("gain"))
    aero_frequency: Any = field(metadata=spec("natural frequency", card=False))
    gain_increase: Any = field(metadata=spec("gain"))
    gain_increase_frequency: Any = field(metadata=spec("natural frequency", card=False))
    phase_margin: Any = field(metadata=spec("angle"))
    crossover_frequency: Any = field(metadata=spec("natural frequency", card=False))


@dataclass(frozen=True, eq=False)
class ModeBand(Shown):
    """Stabilisation and margins of one mode; numbers have the shape ``(...)`` of the batch.

    Attributes
    ----------
    name : str
        Name of the mode in the plant.
    pole : complex or ndarray
        Pole of the mode in the plant [1/s].
    closed_pole : complex or ndarray
        Closed-loop pole [1/s] that the mode's pole becomes as the loop gain rises from zero to one.
        In a sampled loop the pole of lowest frequency with the same samples.
    stabilised : str or ndarray of str
        "gain": the mode owns its frequency, and ``|L|`` stays below one at frequencies that it
        owns. "phase": ``|L|`` reaches one there. "with the rigid body": the rest of the loop is
        larger even at the mode's frequency. "unstable": the closed-loop pole lies in the right
        half plane.
    peak, peak_frequency : float or ndarray
        Peak of ``|L|`` at frequencies that the mode owns, and its frequency [rad/s]; NaN if it owns
        none.
    lag_margin, lead_margin : float or ndarray
        Smallest phase [rad] by which L may lag, and lead, at crossovers that the mode owns;
        infinite without one, and NaN in a loop that is not stable.
    crossover_frequency : float or ndarray
        Frequency of the smaller one of lag and lead margin [rad/s].
    gain_reduction, gain_increase : float or ndarray
        Factors above one by which the gain may fall and rise at phase crossovers of the mode.
    gain_reduction_frequency, gain_increase_frequency : float or ndarray
        Frequencies of these factors [rad/s].
    distance : float or ndarray
        Minimum of ``|1 + L|`` within eight half-widths of the pole.
    alias : float or ndarray
        Frequency [rad/s] at which a sampled law measures a mode above half the rate; else NaN.
    """

    name: str
    pole: Any
    closed_pole: Any = field(metadata=spec(card=False))
    stabilised: Any = field(metadata=spec())
    peak: Any
    peak_frequency: Any = field(metadata=spec("natural frequency", card=False))
    lag_margin: Any = field(metadata=spec("angle", card=False))
    lead_margin: Any = field(metadata=spec("angle", card=False))
    crossover_frequency: Any = field(metadata=spec("natural frequency", card=False))
    gain_reduction: Any = field(metadata=spec("gain", card=False))
    gain_reduction_frequency: Any = field(metadata=spec("natural frequency", card=False))
    gain_increase: Any = field(metadata=spec("gain", card=False))
    gain_increase_frequency: Any = field(metadata=spec("natural frequency", card=False))
    distance: Any = field(metadata=spec())
    alias: Any = field(metadata=spec("natural frequency", card=False))

    @property
    @derived("natural frequency")
    def frequency(self) -> Any:
        """Frequency of the mode in the plant [rad/s]."""
        return plain(np.abs(self.pole))

    @property
    @derived("decibels", name="peak")
    def peak_dB(self) -> Any:
        """Peak of ``|L|`` in dB."""
        return decibels(self.peak)

    @property
    @derived("decibels", name="gain_margin")
    def gain_margin_dB(self) -> Any:
        """Distance in dB of the peak below one, of a mode `stabilised` by "gain"; else NaN."""
        by_gain = np.asarray(self.stabilised) == GAIN
        return plain(np.where(by_gain, -np.asarray(self.peak_dB), np.nan)[()])

    @property
    @derived("degrees", name="phase_margin")
    def phase_margin_deg(self) -> Any:
        """Smaller one of lag and lead margin in degrees; NaN without a crossover of the mode.

        Only a phase-stabilised mode has one.
        """
        smaller = np.degrees(np.minimum(self.lag_margin, self.lead_margin))
        by_phase = (np.asarray(self.stabilised) == PHASE) & np.isfinite(smaller)
        return plain(np.where(by_phase, smaller, np.nan)[()])


@dataclass(frozen=True, eq=False)
class BandMargins(Shown):
    """Margins by band of one loop, or of a batch.

    Attributes
    ----------
    margins : Margins
        Margins of the whole loop, which decide.
    rigid : RigidBand
        Margins of the rigid body.
    modes : tuple of ModeBand
        Margins of each bending mode and tank.
    """

    margins: Margins = field(metadata=spec(of="margins.status", label="whole loop", document=False))
    rigid: RigidBand = field(metadata=spec(name="rigid_body"))
    modes: tuple[ModeBand, ...] = field(
        metadata=spec(of=lambda bands: {mode.name: mode for mode in bands.modes}, label="mode")
    )

    def mode(self, name: str) -> ModeBand:
        """Return the band of one mode by its name."""
        names = [mode.name for mode in self.modes]
        return self.modes[names.index(one_of("name", name, names))]


def band_margins(
    loop: Loop, names: tuple[str, ...], poles: AnyArray, *, delays: bool = True
) -> BandMargins:
    """Return the margins by band of a loop in matrix form, or a batch of loops ``(...)``.

    `names`: names of the modes. `poles`: pole of each mode in the plant with positive imaginary
    part [1/s], ``(..., n)``; they are poles of the loop. `delays`: whether the delay margins of a
    sampled loop are computed, most of its work.
    """
    count = loop.form.delay.size  # of loops in the flattened batch
    plant_poles = np.broadcast_to(poles, (*loop.batch, len(names))).reshape(count, len(names))
    terms = Terms.of(loop, plant_poles)  # partial fractions of each mode in the loop
    analysis = loop.analysis(delays=delays)
    closed = closed_mode_poles(terms)
    bands = [_rigid(terms, analysis)]
    bands += [_mode(terms, analysis, k, closed[:, k]) for k in range(len(names))]
    rigid, *modes = (
        {key: in_batch_shape(v, loop.batch) for key, v in band.items()} for band in bands
    )
    return BandMargins(
        margins=margins_of(analysis, loop),
        rigid=RigidBand(**rigid),
        modes=tuple(ModeBand(name=name, **m) for name, m in zip(names, modes, strict=True)),
    )


def _rigid(terms: Terms, analysis: LoopAnalysis) -> dict[str, Any]:
    """Return the fields of `RigidBand` of k loops by name, each ``(k,)``; NaN for unstable loops.

    They are margins at crossings at which no mode has the largest term of L. `terms`: partial
    fractions of the loops. `analysis`: their crossings.
    """
    # aero margin, gain increase and phase margin, each with its frequency, in the order of
    # `RigidBand`, without the delay margin; -1: index of the rigid body
    pairs = classical_margins(_owned(terms, analysis, -1))[:3]
    pairs[..., ~analysis.stable] = np.nan
    names = (field.name for field in fields(RigidBand))
    return dict(zip(names, pairs.reshape(-1, len(analysis.stable)), strict=True))


def _mode(terms: Terms, analysis: LoopAnalysis, k: int, closed: AnyArray) -> dict[str, Any]:
    """Return the fields of `ModeBand` by name, but the name of the mode, of all loops ``(loops,)``.

    `terms`: partial fractions of the loops L. `analysis`: their crossings. `k`: index of the mode.
    `closed`: its closed-loop pole in the variable w of the loops, ``(loops,)``. A mode has the
    margins at the frequencies that it owns, at which its partial fraction is the largest of L.
    """
    pole = terms.plant[:, k]
    owned = _owned(terms, analysis, k)
    peak, frequency = mode_peak(terms, k)
    # whether the mode's term is the largest of L at its own frequency
    dominant = terms.owner(np.nan_to_num(np.imag(pole), nan=1.0)[:, np.newaxis])[:, 0] == k
    crosses = np.any(~np.isnan(owned.phases), axis=-1)  # |L| is one at an owned frequency
    by_phase = crosses | (dominant & (peak >= 1.0))
    # How the mode is stabilised, the first that holds: not at all; by phase, for |L| reaches one;
    # with the rigid body, for the mode is not the largest term; else by gain.
    kinds = np.select([closed.real > 0.0, by_phase, ~dominant], [UNSTABLE, PHASE, RIGID], GAIN)

    def smallest_positive(phases: FloatArray) -> FloatArray:
        """Return the smallest positive of the phases [rad], ``(loops, crossovers)``, by loop."""
        minimum, _ = row_minimum(np.where(phases > 0.0, phases, np.nan), analysis.gain_frequencies)
        return minimum

    reduction, increase, (_, crossover), *_ = classical_margins(owned)  # (value, frequency) each
    margins = {
        "lag_margin": smallest_positive(owned.phases),
        "lead_margin": smallest_positive(-owned.phases),
        "crossover_frequency": crossover,
        "gain_reduction": reduction[0],
        "gain_reduction_frequency": reduction[1],
        "gain_increase": increase[0],
        "gain_increase_frequency": increase[1],
    }
    return {
        **{name: np.where(analysis.stable, row, np.nan) for name, row in margins.items()},
        "pole": pole,
        "closed_pole": terms.loop.w_to_s(closed[:, np.newaxis])[:, 0],
        "stabilised": kinds,
        "peak": peak,
        "peak_frequency": frequency,
        "distance": mode_distance(terms, k, closed),
        "alias": terms.loop.aliases(np.imag(pole)[:, np.newaxis])[:, 0],
    }


def _owned(terms: Terms, analysis: LoopAnalysis, k: int) -> LoopAnalysis:
    """Return the analysis with NaN for all crossings that a mode does not own.

    A mode owns a frequency at which its partial fraction is the largest term of L. `terms`: partial
    fractions of the loops. `analysis`: all crossings of the loops. `k`: index of the mode; -1 is
    the rigid body.
    """

    def select(omega: FloatArray, values: FloatArray) -> FloatArray:
        """Return `values` at frequencies `omega` [rad/s] where mode k is the largest term of L.

        They are NaN at other frequencies. `terms`: partial fractions of L, one for each mode.
        """
        return np.where(terms.owner(np.nan_to_num(omega)) == k, values, np.nan)

    phases = select(analysis.gain_frequencies, analysis.phases)
    factors = select(analysis.phase_frequencies, analysis.factors)
    return replace(analysis, phases=phases, factors=factors)
