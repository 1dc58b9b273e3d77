"""Modes of a plant: its poles, the residues of its attitude there, and left eigenvectors.

The residue at a simple pole p is N(p)/D'(p); with l A = p l the left eigenvector l gives the
component of the states in the mode.

The attitude contains no unstable exponential exactly when its residue vanishes at every unstable
pole: the residue condition, eq (4b). Residues come from the exact transforms; no verdict comes from
a simulation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import instance
from tvclin.base.fields import spec
from tvclin.base.lines import Line, Table, complex_number, upper_pole
from tvclin.kernels.response_cases import MARGINAL
from tvclin.linear.plant import PLANT_HINT, Plant
from tvclin.numerics.modal import is_unstable
from tvclin.numerics.modal import residues as residues_of_pieces
from tvclin.winds.histories import History, Piecewise

_REPEATED_POLE_DISTANCE = 2e-6
"""Distance of two poles, over their size, below which they count as repeated."""


@dataclass(frozen=True, eq=False)
class Modes(Shown):
    """Poles, and the residues of the attitude transfer functions there.

    All have the shape ``(..., N)``, sorted by falling real part; real when every pole is real.
    Where the plants of a batch have different numbers of such poles, N is the largest and the rest
    is filled with NaN.

    Attributes
    ----------
    poles : ndarray
        Poles [1/s]; the unstable ones are the report's beta_i.
    deflection_residues, wind_residues : ndarray
        Residues [1/s] of the attitude per unit impulse of deflection and of wind, N(p)/D'(p);
        NaN at a repeated pole.
    """

    poles: AnyArray = field(metadata=spec("per time"))
    deflection_residues: AnyArray = field(metadata=spec("per time"))
    wind_residues: AnyArray = field(metadata=spec("per time"))


def mode_table(caption: str, modes_by_model: Mapping[str, Modes]) -> Table:
    """Return the table of poles and residues by model, one row per conjugate pair, with Im >= 0.

    `caption`: title of the table. `modes_by_model`: modes of one plant, by the name of the model.
    """
    rows: list[tuple[Line, ...]] = []
    for model, modes in modes_by_model.items():
        columns = (modes.poles, modes.deflection_residues, modes.wind_residues)
        upper = [mode for mode in zip(*columns, strict=True) if mode[0].imag >= 0.0]
        for k, (pole, *residues) in enumerate(upper):
            key = f"poles.{model}.{k}"
            cells = (complex_number(f"{key}.{i}", residue) for i, residue in enumerate(residues))
            rows.append((("" if k else model,), upper_pole(key, pole), *cells))
    head = ("model", "pole [1/s]", "residue, deflection [1/s]", "wind [1/s]")
    return Table(caption, head, tuple(rows))


def all_modes(plant: Plant) -> Modes:
    """Return all poles of a plant and the residues of its attitude there.

    Parameters
    ----------
    plant : Plant
        One plant or a batch.
    """
    instance("plant", plant, Plant, PLANT_HINT)
    return _with_residues(plant, plant.poles)


def unstable_modes(plant: Plant) -> Modes:
    """Return the unstable poles of a plant and the residues of its attitude there.

    Parameters
    ----------
    plant : Plant
        One plant or a batch.

    Notes
    -----
    Eq (4b) concerns these. There is one for eqs (5) and (B8); there are two for the exact
    third-order model of an unstable vehicle, three for the fourth-order model, two of them a
    complex pair, and none for a stable vehicle on a fixed path. Poles on the imaginary axis do
    not count.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")
    >>> tv.unstable_modes(plant).poles.round(5)
    array([0.5102 , 0.01285])
    """
    instance("plant", plant, Plant, PLANT_HINT)
    return _with_residues(plant, unstable_poles(plant))


def unstable_poles(plant: Plant) -> AnyArray:
    """Return the unstable poles of a plant [1/s], ``(..., N)``, by falling real part.

    NaN where a plant of a batch has fewer, and real where all are.
    """
    return select_unstable(plant.poles)


def select_unstable(all_modes: AnyArray) -> AnyArray:
    """Return the unstable poles among all poles ``(..., n)`` [1/s], ``(..., N)``.

    `all_modes`: all poles by falling real part. NaN where a case has fewer, and real where all are.
    """
    unstable = is_unstable(all_modes)
    count = sum(bool(np.any(column)) for column in np.moveaxis(unstable, -1, 0))
    poles = np.where(unstable[..., :count], all_modes[..., :count], np.nan)
    if np.iscomplexobj(poles) and np.all(np.imag(poles) == 0.0):
        poles = np.real(poles)
    return poles


def separated_poles(poles: AnyArray) -> AnyArray:
    """Return unstable poles ``(..., N)`` with nearly equal ones separated slightly.

    Results that depend on two poles jointly depend on their mean and on the square of their
    distance, so that a distance of 2e-6 of their size changes them by some 1e-12, and avoids 0/0.

    `poles`: [1/s], by falling real part; NaN for missing poles. Only neighbours in this order are
    compared; two equal ones move apart along the real axis, about their mean.
    """
    separated = np.array(poles)
    for i in range(poles.shape[-1] - 1):
        first, second = separated[..., i], separated[..., i + 1]
        middle = np.real(0.5 * (first + second))
        repeated = np.abs(first - second) < _REPEATED_POLE_DISTANCE * middle
        for k, sign in ((i, 1.0), (i + 1, -1.0)):
            separated[..., k] = np.where(
                repeated, middle * (1.0 + sign * _REPEATED_POLE_DISTANCE / 2.0), separated[..., k]
            )
    return (
        np.real(separated)
        if np.all((np.imag(separated) == 0.0) | np.isnan(separated))
        else separated
    )


def left_eigenvectors(A: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Return eigenvalues p of A ``(..., n, n)``, and left eigenvectors l A = p l as rows.

    The eigenvalues are sorted by falling real part, ``(..., n)``; the rows have length one, ``(...,
    n, n)``.
    """
    values, columns = np.linalg.eig(np.swapaxes(A, -1, -2))
    order = np.argsort(-np.real(values), axis=-1)
    columns = np.take_along_axis(columns, order[..., np.newaxis, :], axis=-1)
    return np.take_along_axis(values, order, axis=-1), np.swapaxes(columns, -1, -2)


def left_eigenvector(A: AnyArray, pole: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Return the eigenvalue p of A nearest to a pole, and its left eigenvector l, l A = p l.

    `A`: ``(..., n, n)``. `pole`: ``(...)`` [1/s]. Shapes ``(...)`` and ``(..., n)``.
    """
    values, rows = left_eigenvectors(A)
    nearest = np.abs(values - pole[..., np.newaxis]).argmin(axis=-1)[..., np.newaxis]
    row = np.take_along_axis(rows, nearest[..., np.newaxis], axis=-2)[..., 0, :]
    return np.take_along_axis(values, nearest, axis=-1)[..., 0], row


def wind_over_deflection(plant: Plant, poles: AnyArray) -> AnyArray:
    """Return N_wind(p)/N_deflection(p) of the attitude at poles p of a plant, ``(..., N)``.

    `poles`: [1/s], ``(..., N)``; NaN stays NaN. It is the deflection, up to its sign, that cancels
    the effect of a unit wind angle on the mode: B K1, with trim B per angle of attack and K1 = (p +
    b2)/(p + b1) of eq (15b). Infinite where the deflection does not control the pole.
    """
    from_deflection, from_wind, _ = plant.attitude_fractions(poles)
    with np.errstate(divide="ignore", invalid="ignore"):  # NaN: missing pole
        return np.asarray(np.where(from_deflection == 0.0, np.inf, from_wind / from_deflection))


def poles_text(poles: AnyArray) -> str:
    """Return a text on the unstable poles of one plant: number of real ones, and each pair.

    `poles`: [1/s], ``(N,)``.
    """
    upper = poles[np.imag(poles) > 0.0]
    real = int(np.sum(np.imag(poles) == 0.0))
    pairs = [f"the complex pair {p.real:.4g} +- {p.imag:.4g}j 1/s" for p in upper]
    return " and ".join([f"{real} real" if real else "", *pairs]).removeprefix(" and ") or "none"


def _with_residues(plant: Plant, poles: AnyArray) -> Modes:
    """Return the modes of a plant at `poles` ``(..., N)`` [1/s]: N(p)/D'(p) for each input.

    NaN at a repeated pole.
    """
    *values, slope = plant.attitude_fractions(poles)
    simple = slope != 0.0
    divisor = np.where(simple, slope, 1.0)
    with np.errstate(invalid="ignore"):  # complex NaN: missing pole
        at_poles = [np.where(simple, value / divisor, np.nan) for value in values]
    return Modes(poles, *at_poles)


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
        """Return the motion in words, such as "a ramp of 0.1 deg/s"."""
        times = (f"{time:.4g} s" for time in np.ravel(self.e_folding_times) if np.isfinite(time))
        distinct = [*dict.fromkeys(times)]
        texts = [f"a growing mode with an e-folding time of {time}" for time in distinct[:1]]
        if distinct[1:]:
            texts = [f"growing modes with e-folding times of {' and '.join(distinct)}"]
        ramps, errors = (
            np.degrees(array[np.isfinite(array) & (array != 0.0)])
            for array in (self.rate, self.offset)
        )
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
    plant : Plant
        One plant or a batch.
    deflection, wind : History
        Deflection and wind angle of attack [rad]; all batches broadcast.

    Notes
    -----
    Eq (4b): [N_delta(p) L(delta)(p) + N_wind(p) L(alpha_w)(p)] / D'(p), with the numerators N and
    the denominator D of the attitude's transfer functions and the Laplace transforms L. It is the
    coefficient of e^(p t) in the attitude long after the wind.
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
    plant : Plant
        One plant or a batch.
    deflection, wind : History
        Deflection and wind angle of attack [rad]; all batches broadcast.
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
    """Return whether a deflection satisfies (4b) in a wind: `judge`'s `stable`, ``(...)``.

    Parameters
    ----------
    plant : Plant
        One plant or a batch.
    deflection, wind : History
        Deflection and wind angle of attack [rad]; all batches broadcast.
    """
    return judge(plant, deflection, wind).stable


def _at_poles(
    modes: Modes, deflection: History, wind: History
) -> tuple[AnyArray, FloatArray, FloatArray]:
    """Return the residues [rad], their rounding errors [rad], and the start of the inputs [s].

    Residues and errors are ``(..., N)``, at the N poles of `modes`, NaN at a pole that is NaN.
    `deflection`, `wind`: the inputs [rad]. The time of the residues is counted from the start of
    the inputs, so that they neither vanish for a late wind nor overflow for an early one; times
    e^(-p start) they are the flight's.
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
    """Return the constant [rad] and the rate [rad/s] of the attitude long after a wind, ``(...)``.

    Both follow from the final value theorem, of the last coefficients of the transfer functions:
    with D(0) other than zero the constant is their ratio at s = 0; with one pole at zero the
    constant inputs give the rate and their integrals the constant, which is NaN where the attitude
    ramps. Unstable modes do not count. `plant`: one plant or a batch. `deflection`, `wind`: its
    inputs [rad].
    """
    denominator, *numerators = plant.low_order_terms()
    last = denominator[..., -1]
    marginal = last == 0.0  # a pole at zero
    repeated = marginal & (denominator[..., -2] == 0.0)
    slope = np.where(repeated, np.nan, np.where(marginal, denominator[..., -2], 1.0))
    orders = [_low_order_terms(*pair) for pair in zip(numerators, (deflection, wind), strict=True)]
    constant, total = (first + second for first, second in zip(*orders, strict=True))
    rate = np.where(marginal, constant / slope, 0.0)
    drifted = np.where(rate == 0.0, total / slope, np.nan)
    return np.where(marginal, drifted, constant / np.where(marginal, 1.0, last)), rate


def _low_order_terms(numerator: FloatArray, history: History) -> tuple[FloatArray, FloatArray]:
    """Return the terms with 1/s and with s^0 of a numerator times the transform of a history.

    `numerator`: highest power first, ``(..., k)``. A history that does not decay is its final value
    from t = 0 on, plus a remainder: its transform is final value/s + area + ..., the area [rad s]
    being the integral of the remainder.
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
    """Return whether a plant has an undamped oscillation, ``(...)``.

    A pole pair whose real part is zero to rounding, relative to the largest pole.
    """
    poles = plant.poles
    size = np.abs(poles).max(axis=-1, keepdims=True)
    undamped = (np.abs(np.real(poles)) <= MARGINAL * size) & (np.imag(poles) != 0.0)
    return np.any(undamped, axis=-1)
