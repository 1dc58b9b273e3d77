"""The least deflection of any law without a forecast, for a batch; see `forecast_free`."""

import numpy as np
from numpy.typing import NDArray

from tvclin.errors import InputError
from tvclin.histories import History
from tvclin.kernels import integrals
from tvclin.kernels import pieces as kernel
from tvclin.kernels.crossings import roots_between
from tvclin.modes import unstable_modes
from tvclin.plant import Plant

FloatArray = NDArray[np.float64]

_MANY = 16
"""Above so many knots the wind is sampled, and what is sought turns once in a piece at most."""


def forecast_free_deflections(plant: Plant, wind: History) -> FloatArray:
    """Return the deflection [rad] of `forecast_free_limit` without sign, for each case.

    Parameters
    ----------
    plant : Plant
        A batch; zero is the answer for those without an unstable pole.
    wind : History
        A batch that broadcasts with it, of winds of one sign that end.

    Raises
    ------
    InputError
        For a wind that changes its sign or never ends, and when the unstable poles are a pair.
    """
    shape = np.broadcast_shapes(plant.batch, wind.batch) or (1,)
    modes = unstable_modes(plant)
    if not modes.poles.shape[-1]:
        return np.zeros(shape)
    if np.iscomplexobj(modes.poles):
        raise InputError("a limit without forecast needs real unstable poles")
    if not np.all(np.isfinite(wind.end)):
        raise InputError("wind must end, and be other than zero")
    pole, *residues = (
        np.broadcast_to(row[..., 0], shape)
        for row in (modes.poles, modes.deflection_residues, modes.wind_residues)
    )
    unstable = ~np.isnan(pole)
    pole = np.where(unstable, pole, 1.0)
    size = np.broadcast_to(np.abs(wind.peak), shape)
    pieces = kernel.spread((wind * (1.0 / wind.peak)).pieces, shape)
    onset = np.broadcast_to(wind.onset, shape)[..., np.newaxis]
    foresight = pole * integrals.future(pieces, pole, onset)[..., 0].real
    times = wind.probe_times(1 if wind.knots.shape[-1] > _MANY else 16)
    ahead = _largest_future(pieces, pole, np.broadcast_to(times, (*shape, times.shape[-1])))
    with np.errstate(invalid="ignore"):
        strength = np.abs(residues[1] / residues[0]) * size
    return np.where(unstable, strength * np.maximum(foresight, ahead / 2.0), 0.0)


def _largest_future(pieces: kernel.Pieces, pole: FloatArray, times: FloatArray) -> FloatArray:
    """Sup W for winds of unit peak: its slope p (W - w) falls through zero there."""
    values = np.real(kernel.value(pieces, times))
    if values.min() < -1e-12:
        raise InputError("a limit without forecast is not defined for a wind that changes its sign")
    future = pole[..., np.newaxis] * integrals.future(pieces, pole, times).real
    largest = future.max(axis=-1)
    excess = values - future
    case, index = np.nonzero((excess[..., :-1] < 0.0) & (excess[..., 1:] > 0.0))
    if not case.size:
        return np.asarray(largest)

    def at(t: FloatArray, which: NDArray[np.intp]) -> tuple[FloatArray, FloatArray]:
        some, p = kernel.take(pieces, case[which]), pole[case[which]]
        now = np.real(kernel.value(some, t[:, np.newaxis]))[:, 0]
        return now, p * np.real(integrals.future(some, p, t[:, np.newaxis]))[:, 0]

    def difference(t: FloatArray, which: NDArray[np.intp]) -> FloatArray:
        now, rest = at(t, which)
        return now - rest

    roots = roots_between(times[case, index], times[case, index + 1], difference)
    np.maximum.at(largest, case, at(roots, np.arange(case.size))[1])
    return np.asarray(largest)
