"""The verdict of eq (4b): whether a deflection in a wind leaves a growing exponential behind.

It leaves none exactly when the residue of the attitude vanishes at every unstable pole. Residues
come from the exact transforms; no verdict ever comes from watching a simulation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import instance
from tvclin.kernels.response_cases import MARGINAL
from tvclin.linear.modes import Modes, unstable_modes
from tvclin.linear.plant import INPUTS, Plant
from tvclin.numerics.modal import residues as residues_of_pieces
from tvclin.winds.histories import History, Piecewise


@dataclass(frozen=True, eq=False)
class Verdict(Shown):
    """Whether a history leaves a growing exponential in the attitude, eq (4b).

    Attributes
    ----------
    stable : bool or ndarray
        True when every residue is zero within `tolerance`, ``(...)``.
    residues : ndarray
        Residue of the attitude [rad] at each unstable pole, ``(..., N)``, with the time counted
        from the first breakpoint of the two histories, so that it means the same however late they
        are.
    tolerance : ndarray
        The rounding [rad] to which each residue is known, ``(..., N)``.
    left_over : LeftOver
        What stays in the attitude for ever, which (4b) does not ask about but (4a) does.
    """

    stable: Any
    residues: AnyArray
    tolerance: FloatArray
    left_over: LeftOver

    _keys = "stable residues_deg tolerance_deg"


@dataclass(frozen=True, eq=False)
class LeftOver:
    """What the attitude does long after the wind, besides the decaying terms.

    Attributes
    ----------
    offset : ndarray
        Constant attitude error [rad], ``(...)``; NaN where it ramps.
    rate : ndarray
        Slope of a ramp [rad/s], ``(...)``. Both are NaN for a plant with several poles at zero
        (a vehicle without aerodynamic moment), of which nothing is said.
    e_folding_times : ndarray
        For each unstable pole that is excited, the time [s] in which it grows by e; NaN for the
        others, ``(..., N)``.
    oscillates : bool or ndarray
        True when the plant has an undamped oscillation, ``(...)``.
    """

    offset: FloatArray
    rate: FloatArray
    e_folding_times: FloatArray
    oscillates: Any

    def __str__(self) -> str:
        times = (f"{time:.4g} s" for time in np.ravel(self.e_folding_times) if np.isfinite(time))
        each = [*dict.fromkeys(times)]
        parts = [f"a growing mode with an e-folding time of {time}" for time in each[:1]]
        if each[1:]:
            parts = [f"growing modes with e-folding times of {' and '.join(each)}"]
        ramps, errors = (np.degrees(_known(array)) for array in (self.rate, self.offset))
        if ramps.size:
            parts.append(f"a ramp of {ramps[0]:.4g} deg/s")
        elif errors.size:
            parts.append(f"a constant attitude error of {errors[0]:.4g} deg")
        if np.any(np.isnan(self.rate)):
            parts.append("what several poles at zero make of the deflection")
        if np.any(self.oscillates):
            parts.append("an undamped oscillation")
        return " and ".join(parts) or "nothing"


def residues(plant: Plant, deflection: History, wind: History) -> AnyArray:
    """Return the residue of the attitude response [rad] at each unstable pole, ``(..., N)``.

    Parameters
    ----------
    plant, deflection, wind
        As of `attitude_responses`.

    Notes
    -----
    Eq (4b): [N_delta(p) L(delta)(p) + N_wind(p) L(alpha_w)(p)] / D'(p).
    """
    modes = unstable_modes(plant)
    found, _, start = _at_poles(modes, deflection, wind)
    with np.errstate(over="ignore"):
        return found * np.exp(-modes.poles * start[..., np.newaxis])


def judge(plant: Plant, deflection: History, wind: History) -> Verdict:
    """Return whether this deflection in this wind leaves a growing exponential, eq (4b).

    It judges the history as it is: a deflection above the boundary that is held for ever is
    unstable by (4b), although its capability is sufficient (see `requirement.is_sufficient`).

    Parameters
    ----------
    plant, deflection, wind
        As of `attitude_responses`.
    """
    modes = unstable_modes(plant)
    found, tolerance, _ = _at_poles(modes, deflection, wind)
    zero = (np.abs(found) <= tolerance) | np.isnan(modes.poles)
    stable = np.all(zero, axis=-1)
    with np.errstate(invalid="ignore"):
        e_folding = np.where(zero, np.nan, 1.0 / np.real(modes.poles))
    offset, rate = _final_attitude(plant, deflection, wind)
    return Verdict(
        bool(stable) if stable.ndim == 0 else stable,
        found,
        np.broadcast_to(tolerance, found.shape),
        LeftOver(offset, rate, e_folding, _oscillates(plant)),
    )


def is_stable(plant: Plant, deflection: History, wind: History) -> Any:
    """Return ``judge(plant, deflection, wind).stable``: True where (4b) is met."""
    return judge(plant, deflection, wind).stable


def _at_poles(
    modes: Modes, deflection: History, wind: History
) -> tuple[AnyArray, FloatArray, FloatArray]:
    """The residues [rad], the rounding to which they are known, and when the first input begins.

    They are those of the same flight with its time counted from there [s], and so neither vanish
    for a late wind nor overflow for an early one; e^(-p start) times them are those of the flight
    as it is. Both are ``(..., N)``; NaN at a pole that is NaN.
    """
    instance("deflection", deflection, History, "such as HeldDeflection")
    instance("wind", wind, History, "such as TriangularWind")
    start = np.minimum(deflection.knots[..., 0], wind.knots[..., 0])
    gains = (modes.deflection_residues, modes.wind_residues)
    pieces = (deflection.pieces, wind.pieces)
    return (*residues_of_pieces(modes.poles, gains, pieces, start), start)


def _final_attitude(
    plant: Plant, deflection: History, wind: History
) -> tuple[FloatArray, FloatArray]:
    """The constant or the ramp that the last values of the inputs leave (final value theorem)."""
    denominator, *numerators = _without_common_zero(plant)
    last = denominator[..., -1]
    marginal = last == 0.0
    several = marginal & (denominator[..., -2] == 0.0)
    slope = np.where(several, np.nan, np.where(marginal, denominator[..., -2], 1.0))
    orders = [_lowest(*pair) for pair in zip(numerators, (deflection, wind), strict=True)]
    held, total = (first + second for first, second in zip(*orders, strict=True))
    rate = np.where(marginal, held / slope, 0.0)
    drifted = np.where(rate == 0.0, total / slope, np.nan)
    return np.where(marginal, drifted, held / np.where(marginal, 1.0, last)), rate


def _lowest(numerator: FloatArray, history: History) -> tuple[FloatArray, FloatArray]:
    """The terms with 1/s and with s^0 of a numerator times the transform of a history.

    A history that does not die out is its final value from t = 0 on, and the rest of it.
    """
    pieces, end = history.pieces, history.final_value
    constant = np.zeros(pieces.coefficients.shape[-3:], dtype=bool)
    constant[-1, :, 0] = True
    constant = constant & (pieces.rates == 0.0)[..., np.newaxis, :, np.newaxis]
    rest = replace(pieces, coefficients=np.where(constant, 0.0, pieces.coefficients))
    slope = numerator[..., -2] if numerator.shape[-1] > 1 else 0.0
    with np.errstate(invalid="ignore"):  # a history without a final value
        area = Piecewise(rest).laplace(0.0) - end * pieces.knots[..., -1]
        return numerator[..., -1] * end, numerator[..., -1] * area + slope * end


def _without_common_zero(plant: Plant) -> list[FloatArray]:
    """The denominator and the numerators, divided by s where it divides all of them (in yaw)."""
    terms = [plant.denominator, *(plant.numerator("attitude", i) for i in INPUTS)]
    common = np.all([term[..., -1] == 0.0 for term in terms], axis=0)
    return [np.where(common[..., None], np.roll(term, 1, axis=-1), term) for term in terms]


def _oscillates(plant: Plant) -> Any:
    poles = plant.poles
    size = np.abs(poles).max(axis=-1, keepdims=True)
    undamped = (np.abs(np.real(poles)) <= MARGINAL * size) & (np.imag(poles) != 0.0)
    return np.any(undamped, axis=-1)


def _known(array: FloatArray) -> FloatArray:
    """The elements that are neither zero nor NaN."""
    return array[np.isfinite(array) & (array != 0.0)]
