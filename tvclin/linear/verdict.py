"""Residue condition, eq (4b): stability of the attitude under a deflection in a wind.

The attitude contains no unstable exponential exactly when its residue vanishes at every unstable
pole. Residues come from the exact transforms; no verdict comes from a simulation.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import instance
from tvclin.base.fields import spec
from tvclin.kernels.response_cases import MARGINAL
from tvclin.linear.modes import Modes, unstable_modes
from tvclin.linear.plant import Plant
from tvclin.numerics.modal import residues as residues_of_pieces
from tvclin.winds.histories import History, Piecewise


@dataclass(frozen=True, eq=False)
class Verdict(Shown):
    """Verdict of the residue condition, eq (4b), on a deflection in a wind.

    Attributes
    ----------
    stable : bool or ndarray
        True when every residue is zero within `tolerance`, ``(...)``.
    residues : ndarray
        Residue of the attitude [rad] at each unstable pole, ``(..., N)``, with the time counted
        from the first breakpoint of the two histories, so that it does not depend on their delay.
    tolerance : ndarray
        Rounding error [rad] of each residue, ``(..., N)``.
    final_motion : FinalMotion
        Attitude long after the wind, which (4a) restricts but (4b) does not.
    """

    stable: Any = field(metadata=spec())
    residues: AnyArray = field(metadata=spec("angle"))
    tolerance: FloatArray = field(metadata=spec("angle"))
    final_motion: FinalMotion


@dataclass(frozen=True, eq=False)
class FinalMotion:
    """Attitude long after the wind, besides the decaying terms.

    Attributes
    ----------
    offset : ndarray
        Constant attitude error [rad], ``(...)``; NaN where it ramps.
    rate : ndarray
        Slope of a ramp [rad/s], ``(...)``. Both are NaN for a plant with several poles at zero
        (a vehicle without aerodynamic moment).
    e_folding_times : ndarray
        E-folding time [s] of each unstable pole that is excited; NaN for the others,
        ``(..., N)``.
    oscillates : bool or ndarray
        True when the plant has an undamped oscillation, ``(...)``.
    """

    offset: FloatArray
    rate: FloatArray
    e_folding_times: FloatArray
    oscillates: Any

    def __str__(self) -> str:
        times = (f"{time:.4g} s" for time in np.ravel(self.e_folding_times) if np.isfinite(time))
        distinct = [*dict.fromkeys(times)]
        texts = [f"a growing mode with an e-folding time of {time}" for time in distinct[:1]]
        if distinct[1:]:
            texts = [f"growing modes with e-folding times of {' and '.join(distinct)}"]
        ramps, errors = (np.degrees(_nonzero_elements(array)) for array in (self.rate, self.offset))
        if ramps.size:
            texts.append(f"a ramp of {ramps[0]:.4g} deg/s")
        elif errors.size:
            texts.append(f"a constant attitude error of {errors[0]:.4g} deg")
        if np.any(np.isnan(self.rate)):
            texts.append("what several poles at zero make of the deflection")
        if np.any(self.oscillates):
            texts.append("an undamped oscillation")
        return " and ".join(texts) or "nothing"


def residues(plant: Plant, deflection: History, wind: History) -> AnyArray:
    """Return the residue of the attitude response [rad] at each unstable pole, ``(..., N)``.

    Parameters
    ----------
    plant, deflection, wind
        As in `attitude_responses`.

    Notes
    -----
    Eq (4b): [N_delta(p) L(delta)(p) + N_wind(p) L(alpha_w)(p)] / D'(p).
    """
    modes = unstable_modes(plant)
    values, _, start = _at_poles(modes, deflection, wind)
    with np.errstate(over="ignore"):
        return values * np.exp(-modes.poles * start[..., np.newaxis])


def judge(plant: Plant, deflection: History, wind: History) -> Verdict:
    """Return the verdict of eq (4b) on a deflection in a wind.

    It judges the history itself: a deflection above the boundary that is constant without end is
    unstable by (4b), although its capability is sufficient (see `requirement.is_sufficient`).

    Parameters
    ----------
    plant, deflection, wind
        As in `attitude_responses`.
    """
    modes = unstable_modes(plant)
    values, tolerance, _ = _at_poles(modes, deflection, wind)
    zero = (np.abs(values) <= tolerance) | np.isnan(modes.poles)
    stable = np.all(zero, axis=-1)
    with np.errstate(invalid="ignore"):
        e_folding = np.where(zero, np.nan, 1.0 / np.real(modes.poles))
    offset, rate = _final_attitude(plant, deflection, wind)
    return Verdict(
        bool(stable) if stable.ndim == 0 else stable,
        values,
        np.broadcast_to(tolerance, values.shape),
        FinalMotion(offset, rate, e_folding, _oscillates(plant)),
    )


def is_stable(plant: Plant, deflection: History, wind: History) -> Any:
    """Return ``judge(plant, deflection, wind).stable``: True where (4b) is satisfied."""
    return judge(plant, deflection, wind).stable


def _at_poles(
    modes: Modes, deflection: History, wind: History
) -> tuple[AnyArray, FloatArray, FloatArray]:
    """Return the residues [rad], their rounding errors [rad], and the start of the inputs [s].

    The residues are those with the time counted from the start, and so neither vanish for a late
    wind nor overflow for an early one; times e^(-p start) they are those of the flight. Both are
    ``(..., N)``; NaN at a pole that is NaN.
    """
    instance("deflection", deflection, History, "such as ConstantDeflection")
    instance("wind", wind, History, "such as TriangularWind")
    start = np.minimum(deflection.knots[..., 0], wind.knots[..., 0])
    gains = (modes.deflection_residues, modes.wind_residues)
    pieces = (deflection.pieces, wind.pieces)
    return (*residues_of_pieces(modes.poles, gains, pieces, start), start)


def _final_attitude(
    plant: Plant, deflection: History, wind: History
) -> tuple[FloatArray, FloatArray]:
    """Return the constant [rad] and the rate [rad/s] of the attitude long after the wind.

    Both follow from the final value theorem; the constant is NaN where the attitude ramps.
    """
    denominator, *numerators = plant.low_order_terms()
    last = denominator[..., -1]
    marginal = last == 0.0
    repeated = marginal & (denominator[..., -2] == 0.0)
    slope = np.where(repeated, np.nan, np.where(marginal, denominator[..., -2], 1.0))
    orders = [_low_order_terms(*pair) for pair in zip(numerators, (deflection, wind), strict=True)]
    constant, total = (first + second for first, second in zip(*orders, strict=True))
    rate = np.where(marginal, constant / slope, 0.0)
    drifted = np.where(rate == 0.0, total / slope, np.nan)
    return np.where(marginal, drifted, constant / np.where(marginal, 1.0, last)), rate


def _low_order_terms(numerator: FloatArray, history: History) -> tuple[FloatArray, FloatArray]:
    """Return the terms with 1/s and with s^0 of a numerator times the transform of a history.

    A history that does not decay is its final value from t = 0 on, plus a remainder.
    """
    pieces, end = history.pieces, history.final_value
    constant = np.zeros(pieces.coefficients.shape[-3:], dtype=bool)
    constant[-1, :, 0] = True
    constant = constant & (pieces.rates == 0.0)[..., np.newaxis, :, np.newaxis]
    remainder = replace(pieces, coefficients=np.where(constant, 0.0, pieces.coefficients))
    slope = numerator[..., -2] if numerator.shape[-1] > 1 else 0.0
    with np.errstate(invalid="ignore"):  # a history without a final value
        area = Piecewise(remainder).laplace(0.0) - end * pieces.knots[..., -1]
        return numerator[..., -1] * end, numerator[..., -1] * area + slope * end


def _oscillates(plant: Plant) -> Any:
    """Return whether a plant has an undamped oscillation, ``(...)``."""
    poles = plant.poles
    size = np.abs(poles).max(axis=-1, keepdims=True)
    undamped = (np.abs(np.real(poles)) <= MARGINAL * size) & (np.imag(poles) != 0.0)
    return np.any(undamped, axis=-1)


def _nonzero_elements(array: FloatArray) -> FloatArray:
    """Return the finite elements that are not zero."""
    return array[np.isfinite(array) & (array != 0.0)]
