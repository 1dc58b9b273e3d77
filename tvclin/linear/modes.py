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
        upper = np.imag(modes.poles) >= 0.0
        columns = (modes.poles, modes.deflection_residues, modes.wind_residues)
        upper_modes = zip(*(column[upper] for column in columns), strict=True)
        for k, (pole, *residues) in enumerate(upper_modes):
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
    """Return the unstable poles, and the residues there from deflection and wind to attitude.

    Parameters
    ----------
    plant : Plant
        One plant or a batch.

    Notes
    -----
    At each of them the residue of the attitude must vanish, eq (4b), if the vehicle is to survive.
    An unstable vehicle has one in the models fixed-path and drift, eqs (5) and (B8), two in
    drift-exact, three in drift-and-speed, of which two are a complex pair; a stable vehicle has
    none on a fixed path. Poles on the imaginary axis do not count.

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
    """Return the N unstable poles among n poles [1/s], ``(..., N)``.

    `all_modes`: poles by falling real part, ``(..., n)``. NaN where a case has fewer; real where
    all are.
    """
    unstable = is_unstable(all_modes)  # in each case the first of its poles
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
        mean = np.real(0.5 * (first + second))  # NaN where a pole is missing: not repeated
        repeated = np.abs(first - second) < _REPEATED_POLE_DISTANCE * mean
        for k, sign in ((i, 1.0), (i + 1, -1.0)):
            separated[..., k] = np.where(
                repeated, mean * (1.0 + sign * _REPEATED_POLE_DISTANCE / 2.0), separated[..., k]
            )
    all_real = np.all((np.imag(separated) == 0.0) | np.isnan(separated))
    return np.real(separated) if all_real else separated


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
    b2)/(p + b1) of eq (15b), with b1 and b2 [1/s] of the flight path. Infinite where the
    deflection does not control the pole.
    """
    from_deflection, from_wind, _ = plant.attitude_fractions(poles)
    with np.errstate(divide="ignore", invalid="ignore"):  # NaN: missing pole
        return np.asarray(np.where(from_deflection == 0.0, np.inf, from_wind / from_deflection))


def poles_text(poles: AnyArray) -> str:
    """Return a text on the unstable poles of one plant: number of real ones, and each pair.

    `poles`: the unstable poles [1/s], ``(N,)``. "none" without any.
    """
    upper = poles[np.imag(poles) > 0.0]
    real = int(np.sum(np.imag(poles) == 0.0))
    pairs = [f"the complex pair {p.real:.4g} +- {p.imag:.4g}j 1/s" for p in upper]
    return " and ".join([f"{real} real" if real else "", *pairs]).removeprefix(" and ") or "none"


def _with_residues(plant: Plant, poles: AnyArray) -> Modes:
    """Return the modes of a plant at `poles` ``(..., N)`` [1/s], with the residues N(p)/D'(p).

    N are the numerators of the attitude from deflection and wind, D its denominator, whose slope
    D'(p) is zero at a repeated pole: the residues are NaN there.
    """
    *numerators, slope = plant.attitude_fractions(poles)
    simple = slope != 0.0
    divisor = np.where(simple, slope, 1.0)
    with np.errstate(invalid="ignore"):  # complex NaN: missing pole
        residues = [np.where(simple, value / divisor, np.nan) for value in numerators]
    return Modes(poles, *residues)


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
        """Return the motion as text, such as "a ramp of 0.1 deg/s"; of a batch the first case."""
        times = (f"{time:.4g} s" for time in np.ravel(self.e_folding_times) if np.isfinite(time))
        distinct = [*dict.fromkeys(times)]
        texts = [f"a growing mode with an e-folding time of {time}" for time in distinct[:1]]
        if distinct[1:]:
            texts = [f"growing modes with e-folding times of {' and '.join(distinct)}"]
        rates, offsets = (
            np.degrees(array[np.isfinite(array) & (array != 0.0)])
            for array in (self.rate, self.offset)
        )
        if rates.size:
            texts.append(f"a ramp of {rates[0]:.4g} deg/s")
        elif offsets.size:
            texts.append(f"a constant attitude error of {offsets[0]:.4g} deg")
        if np.any(np.isnan(self.rate)):  # several poles at zero
            texts.append("what several poles at zero make of the deflection")
        if np.any(self.oscillates):
            texts.append("an undamped oscillation")
        return " and ".join(texts) or "nothing"


def residues(plant: Plant, deflection: History, wind: History) -> AnyArray:
    """Return the residue of the attitude response [rad] at each unstable pole, ``(..., N)``.

    Parameters
    ----------
    plant, deflection, wind
        Same parameters as `judge`.

    Notes
    -----
    Eq (4b): [N_delta(p) L(delta)(p) + N_wind(p) L(alpha_w)(p)] / D'(p), with the numerators N and
    the denominator D of the attitude's transfer functions and the Laplace transforms L. It is the
    coefficient of e^(p t) in the attitude long after the wind.
    """
    modes = unstable_modes(plant)
    values, _, start = _at_poles(modes, deflection, wind)  # of time since the start of the inputs
    with np.errstate(over="ignore"):  # from that start [s] to t = 0
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
    # undamped: a real part that is zero to rounding, relative to the largest pole
    size = np.abs(plant.poles).max(axis=-1, keepdims=True)
    undamped = (np.abs(plant.poles.real) <= MARGINAL * size) & (plant.poles.imag != 0.0)
    return Verdict(
        stable=bool(stable) if stable.ndim == 0 else stable,
        residues=values,
        tolerance=np.broadcast_to(tolerance, values.shape),
        final_motion=FinalMotion(offset, rate, e_folding, oscillates=np.any(undamped, axis=-1)),
    )


def is_stable(plant: Plant, deflection: History, wind: History) -> Any:
    """Return whether the attitude has zero residues at all unstable poles, eq (4b), ``(...)``.

    Parameters
    ----------
    plant, deflection, wind
        Same parameters as `judge`.
    """
    return judge(plant, deflection, wind).stable


def _at_poles(
    modes: Modes, deflection: History, wind: History
) -> tuple[AnyArray, FloatArray, FloatArray]:
    """Return the residues [rad], their rounding errors [rad], and the start of the inputs [s].

    Residues and errors are ``(..., N)``, at the N poles of `modes`, NaN at a pole that is NaN; the
    start is ``(...)``. `deflection`, `wind`: the inputs [rad]. The time of the residues is counted
    from the start of the inputs, so that they neither vanish for a late wind nor overflow for an
    early one; multiplied by e^(-p start) they are those with time counted from t = 0.
    """
    instance("deflection", deflection, History, "such as ConstantDeflection")
    instance("wind", wind, History, "such as TriangularWind")
    start = np.minimum(deflection.knots[..., 0], wind.knots[..., 0])  # first breakpoint
    gains = (modes.deflection_residues, modes.wind_residues)
    pieces = (deflection.pieces, wind.pieces)
    return (*residues_of_pieces(modes.poles, gains, pieces, start), start)


def _final_attitude(
    plant: Plant, deflection: History, wind: History
) -> tuple[FloatArray, FloatArray]:
    """Return the constant [rad] and the rate [rad/s] of the attitude long after a wind, ``(...)``.

    By the final value theorem, without the unstable modes, D being the common denominator: if D(0)
    is not zero the constant is the final inputs times the transfer functions at s = 0; with one
    pole at zero these inputs give the rate, and their integrals the constant, NaN in a ramp.
    `plant`: one plant or a batch. `deflection`, `wind`: its inputs [rad].
    """
    denominator, *numerators = plant.low_order_terms()
    static, slope = denominator[..., -1], denominator[..., -2]  # D = .. + slope s + static
    marginal = static == 0.0  # a pole at zero
    repeated = marginal & (slope == 0.0)
    slope = np.where(repeated, np.nan, np.where(marginal, slope, 1.0))
    # coefficients of 1/s and s^0 in the transform of D times the attitude, for each input
    orders = [_low_order_terms(*pair) for pair in zip(numerators, (deflection, wind), strict=True)]
    first_order, zeroth_order = (
        by_delta + by_wind for by_delta, by_wind in zip(*orders, strict=True)
    )
    rate = np.where(marginal, first_order / slope, 0.0)
    integrated = np.where(rate == 0.0, zeroth_order / slope, np.nan)
    return np.where(marginal, integrated, first_order / np.where(marginal, 1.0, static)), rate


def _low_order_terms(numerator: FloatArray, history: History) -> tuple[FloatArray, FloatArray]:
    """Return the coefficients of 1/s and s^0 of a numerator times the transform of a history.

    `numerator`: highest power first, ``(..., k)``. A history that does not decay is its final value
    from t = 0 on, plus a remainder: its transform is final value/s + area + ..., the area [rad s]
    being the integral of the remainder.
    """
    pieces, final = history.pieces, history.final_value
    # the constant, power 0 of rate 0 in the last piece (pieces, rates, powers), ends in the final
    # value; without it, the transform at s = 0 is the integral
    constant = np.zeros(pieces.coefficients.shape[-3:], dtype=bool)
    constant[-1, :, 0] = True
    constant = constant & (pieces.rates == 0.0)[..., np.newaxis, :, np.newaxis]
    remainder = replace(pieces, coefficients=np.where(constant, 0.0, pieces.coefficients))
    slope = numerator[..., -2] if numerator.shape[-1] > 1 else 0.0
    with np.errstate(invalid="ignore"):  # a history without a final value
        # the constant acts from the last knot on, the final value from t = 0 on
        area = Piecewise(remainder).laplace(0.0) - final * pieces.knots[..., -1]
        return numerator[..., -1] * final, numerator[..., -1] * area + slope * final
