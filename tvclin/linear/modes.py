"""The modes of a plant: its poles, and the residues of its attitude there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import AnyArray
from tvclin.base.cards import Shown
from tvclin.base.errors import instance
from tvclin.base.lines import Line, Table, complex_number, upper_pole
from tvclin.linear.plant import INPUTS, RIGID, Plant
from tvclin.numerics import polynomials
from tvclin.numerics.modal import is_unstable

_TOGETHER = 2e-6
"""Poles nearer to each other than this part of their size count as repeated ones."""


@dataclass(frozen=True, eq=False)
class Modes(Shown):
    """Poles, and the residues of the attitude transfer functions there.

    All have shape ``(..., N)``, sorted from the fastest growing pole down; real when every pole
    is. Where the plants of a batch have different numbers of poles of the kind asked for, N is
    the largest and the rest is filled with NaN.

    Attributes
    ----------
    poles : ndarray
        Poles [1/s]; the unstable ones are the report's beta_i.
    deflection_residues, wind_residues : ndarray
        Residues [1/s] of the attitude per unit impulse of deflection and of wind, N(p)/D'(p);
        NaN at a repeated pole.
    """

    poles: AnyArray
    deflection_residues: AnyArray
    wind_residues: AnyArray

    _keys = "poles_per_s deflection_residues_per_s wind_residues_per_s"


def mode_table(caption: str, found: Mapping[str, Modes]) -> Table:
    """Return poles and residues by model, of each pair that with a positive imaginary part."""
    rows: list[tuple[Line, ...]] = []
    for model, modes in found.items():
        columns = (modes.poles, modes.deflection_residues, modes.wind_residues)
        upper = [one for one in zip(*columns, strict=True) if one[0].imag >= 0.0]
        for k, (pole, *residues) in enumerate(upper):
            key = f"poles.{model}.{k}"
            beside = (complex_number(f"{key}.{i}", one) for i, one in enumerate(residues))
            rows.append((("" if k else model,), upper_pole(key, pole), *beside))
    head = ("model", "pole [1/s]", "residue, deflection [1/s]", "wind [1/s]")
    return Table(caption, head, tuple(rows))


def all_modes(plant: Plant) -> Modes:
    """Return every pole of a plant and the residues of its attitude there.

    Parameters
    ----------
    plant : Plant
        One plant or a batch.
    """
    instance("plant", plant, Plant, RIGID)
    return _with_residues(plant, plant.poles)


def unstable_modes(plant: Plant) -> Modes:
    """Return the unstable poles of a plant and the residues of its attitude there.

    Parameters
    ----------
    plant : Plant
        One plant or a batch.

    Notes
    -----
    Eq (4b) asks about these. There is one for eqs (5) and (B8); there are two for the exact
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
    instance("plant", plant, Plant, RIGID)
    return _with_residues(plant, unstable_poles(plant))


def unstable_poles(plant: Plant) -> AnyArray:
    """Return the poles of `unstable_modes` alone, which take a third of the time.

    The fastest first, ``(..., N)`` [1/s]; NaN where a plant of a batch has fewer, and real where
    all are.
    """
    return that_grow(plant.poles)


def that_grow(every: AnyArray) -> AnyArray:
    """Return those of all poles ``(..., N)``, the fastest first, that `unstable_poles` has."""
    unstable = is_unstable(every)
    most = sum(bool(np.any(column)) for column in np.moveaxis(unstable, -1, 0))
    poles = np.where(unstable[..., :most], every[..., :most], np.nan)
    if np.iscomplexobj(poles) and np.all(np.imag(poles) == 0.0):
        poles = np.real(poles)
    return poles


def parted(poles: AnyArray) -> AnyArray:
    """Return unstable poles ``(..., N)``, of which two that are together are set apart a little.

    What two poles ask for together depends on their mean and on the square of their distance, so a
    distance of 2e-6 of their size changes it by some 1e-12, and keeps it from 0/0.

    `poles`: the fastest first, as `unstable_poles` gives them; NaN where there is none.
    """
    apart = np.array(poles)
    for i in range(poles.shape[-1] - 1):
        first, second = apart[..., i], apart[..., i + 1]
        middle = np.real(0.5 * (first + second))
        together = np.abs(first - second) < _TOGETHER * middle
        for k, side in ((i, 1.0), (i + 1, -1.0)):
            apart[..., k] = np.where(
                together, middle * (1.0 + side * _TOGETHER / 2.0), apart[..., k]
            )
    return np.real(apart) if np.all((np.imag(apart) == 0.0) | np.isnan(apart)) else apart


def left_eigenvectors(A: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Return eigenvalues of A ``(..., n, n)``, and left eigenvectors l A = p l as rows.

    The eigenvalues are sorted by their real parts, the largest first, ``(..., n)``; the rows have
    length one, ``(..., n, n)``.
    """
    values, columns = np.linalg.eig(np.swapaxes(A, -1, -2))
    order = np.argsort(-np.real(values), axis=-1)
    columns = np.take_along_axis(columns, order[..., np.newaxis, :], axis=-1)
    return np.take_along_axis(values, order, axis=-1), np.swapaxes(columns, -1, -2)


def left_eigenvector(A: AnyArray, pole: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Return the eigenvalue of A ``(..., n, n)`` next to a pole ``(...)``, and its row l."""
    values, rows = left_eigenvectors(A)
    nearest = np.abs(values - pole[..., np.newaxis]).argmin(axis=-1)[..., np.newaxis]
    row = np.take_along_axis(rows, nearest[..., np.newaxis], axis=-2)[..., 0, :]
    return np.take_along_axis(values, nearest, axis=-1)[..., 0], row


def wind_strength(plant: Plant, poles: AnyArray) -> AnyArray:
    """Return N_wind(p)/N_deflection(p) of the attitude at poles ``(..., N)``.

    It is B times the K1 of each pole; infinite where the deflection does not reach the pole.
    """
    turned, blown = (polynomials.value(plant.numerator("attitude", i), poles) for i in INPUTS)
    with np.errstate(divide="ignore", invalid="ignore"):  # NaN stands for a pole that is not there
        return np.asarray(np.where(turned == 0.0, np.inf, blown / turned))


def poles_in_words(poles: AnyArray) -> str:
    """Return which unstable poles one plant has: how many real ones, and each pair by name."""
    upper = poles[np.imag(poles) > 0.0]
    real = int(np.sum(np.imag(poles) == 0.0))
    pairs = [f"the complex pair {p.real:.4g} +- {p.imag:.4g}j 1/s" for p in upper]
    return " and ".join([f"{real} real" if real else "", *pairs]).removeprefix(" and ") or "none"


def _with_residues(plant: Plant, poles: AnyArray) -> Modes:
    slope = polynomials.value(polynomials.derivative(plant.denominator), poles)
    simple = slope != 0.0
    divisor = np.where(simple, slope, 1.0)
    values = [polynomials.value(plant.numerator("attitude", i), poles) for i in INPUTS]
    with np.errstate(invalid="ignore"):  # complex NaN stands for a pole that is not there
        at_poles = [np.where(simple, value / divisor, np.nan) for value in values]
    return Modes(poles, *at_poles)
