"""Modes of a plant: its poles, the residues of its attitude there, and left eigenvectors.

The residue at a simple pole p is N(p)/D'(p); with l A = p l the left eigenvector l gives the
component of the states in the mode.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from tvclin.base.arrays import AnyArray
from tvclin.base.cards import Shown
from tvclin.base.errors import instance
from tvclin.base.fields import spec
from tvclin.base.lines import Line, Table, complex_number, upper_pole
from tvclin.linear.plant import PLANT_HINT, Plant
from tvclin.numerics.modal import is_unstable

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
    """Return poles and residues by model, one row per conjugate pair, with Im >= 0."""
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
    """Return the poles of `unstable_modes` [1/s], ``(..., N)``, without residues.

    They are sorted by falling real part; NaN where a plant of a batch has fewer, and real where all
    are.
    """
    return select_unstable(plant.poles)


def select_unstable(all_modes: AnyArray) -> AnyArray:
    """Return the unstable poles of all poles ``(..., N)``, as `unstable_poles` sorts them."""
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

    `poles`: sorted as by `unstable_poles`; NaN for missing poles.
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
    """Return eigenvalues of A ``(..., n, n)``, and left eigenvectors l A = p l as rows.

    The eigenvalues are sorted by falling real part, ``(..., n)``; the rows have length one, ``(...,
    n, n)``.
    """
    values, columns = np.linalg.eig(np.swapaxes(A, -1, -2))
    order = np.argsort(-np.real(values), axis=-1)
    columns = np.take_along_axis(columns, order[..., np.newaxis, :], axis=-1)
    return np.take_along_axis(values, order, axis=-1), np.swapaxes(columns, -1, -2)


def left_eigenvector(A: AnyArray, pole: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Return the eigenvalue of A ``(..., n, n)`` nearest to a pole ``(...)``, and its row l."""
    values, rows = left_eigenvectors(A)
    nearest = np.abs(values - pole[..., np.newaxis]).argmin(axis=-1)[..., np.newaxis]
    row = np.take_along_axis(rows, nearest[..., np.newaxis], axis=-2)[..., 0, :]
    return np.take_along_axis(values, nearest, axis=-1)[..., 0], row


def wind_over_deflection(plant: Plant, poles: AnyArray) -> AnyArray:
    """Return N_wind(p)/N_deflection(p) of the attitude at poles ``(..., N)``.

    It is B times the K1 of each pole; infinite where the deflection does not control the pole.
    """
    from_deflection, from_wind, _ = plant.attitude_fractions(poles)
    with np.errstate(divide="ignore", invalid="ignore"):  # NaN: missing pole
        return np.asarray(np.where(from_deflection == 0.0, np.inf, from_wind / from_deflection))


def poles_text(poles: AnyArray) -> str:
    """Return a text on the unstable poles of one plant: number of real ones, and each pair."""
    upper = poles[np.imag(poles) > 0.0]
    real = int(np.sum(np.imag(poles) == 0.0))
    pairs = [f"the complex pair {p.real:.4g} +- {p.imag:.4g}j 1/s" for p in upper]
    return " and ".join([f"{real} real" if real else "", *pairs]).removeprefix(" and ") or "none"


def _with_residues(plant: Plant, poles: AnyArray) -> Modes:
    """Return the modes of poles: N(p)/D'(p) for each input, NaN at a repeated pole."""
    *values, slope = plant.attitude_fractions(poles)
    simple = slope != 0.0
    divisor = np.where(simple, slope, 1.0)
    with np.errstate(invalid="ignore"):  # complex NaN: missing pole
        at_poles = [np.where(simple, value / divisor, np.nan) for value in values]
    return Modes(poles, *at_poles)
